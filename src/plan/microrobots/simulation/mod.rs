//! Simulation of the closed loop: the controller brings imperfect robots together from imperfect measurements.
//!
//! Input: an order, its plan, the number of trials, a seed. Output: a [`SimulationReport`]. Every trial draws errors of
//! each robot's figures, always within the bounds of the device (`facts.errors`): a part that stays for the trial and a
//! part that changes from interval to interval. A quarter of the trials keep extreme errors throughout; another quarter
//! change between extremes. The bed has true poses, which the [`Controller`] never sees: it gets measurements and
//! answers with segments of the drive, as in `tweeze control`.
//!
//! Simulated: measurement, the motion of all robots, contact of bodies, alignment, sticking, collisions of the true
//! bodies. A trial succeeds if the controller finishes and every robot sticks in its place. Not simulated: single
//! strokes (paths are continuous); a robot that sticks stays where it is, even if its arm is down until the end of the
//! command in which it docked.
//!
//! If all errors are 0, measuring changes nothing: the legs of the plan are carried out as written.
//!
//! The same seed gives the same report, whatever the number of threads: a trial depends on the seed and its own index
//! alone. Cost grows with trials times the path length over the interval.

mod area;
mod disturbances;
mod report;
mod trial;

pub use disturbances::Disturbances;
pub use report::{DockingStatistics, Failures, ShareSpread, SimulationReport, Spread, wilson};
pub use trial::{EndedTrial, FailureReason};

use crate::claims::microrobots::MicrorobotsOrder;
use crate::device::microrobots::Errors;
use crate::plan::microrobots::control::{Command, Controller, Pilot};
use crate::plan::microrobots::strategy::{StrategySolid, obstacles};
use crate::plan::microrobots::{AssemblyStage, MicrorobotsMotion, MicrorobotsStepMotion};
use crate::plan::parallel;
use disturbances::DisturbedView;
use trial::{Trial, TrialFailure, TrialStart};

/// Most trials in one call.
pub const MAX_TRIALS: u64 = 10_000_000;

/// Most measurements of one trial: more than a day of them at five a second.
const MAX_MEASUREMENTS: u64 = 1_000_000;

/// The bed of a task, on which trials are run.
pub struct SimulatedBed<'a> {
    order: &'a MicrorobotsOrder,
    motion: &'a MicrorobotsMotion,
    errors: Errors,
    obstacles: Vec<StrategySolid>,
    stages: Vec<&'a AssemblyStage>,
    disturbances: Disturbances,
}

impl<'a> SimulatedBed<'a> {
    /// `None` if the device does not bound its errors, or nothing is assembled.
    pub fn new(
        order: &'a MicrorobotsOrder,
        motion: &'a MicrorobotsMotion,
        disturbances: Disturbances,
    ) -> Option<SimulatedBed<'a>> {
        let (errors, stages) = (order.facts.errors?, docking_stages(motion));
        let obstacles = obstacles(order);
        (!stages.is_empty()).then_some(SimulatedBed { order, motion, errors, obstacles, stages, disturbances })
    }

    /// Runs one trial; it depends on the seed, its own index and the pilot alone.
    pub fn trial(&self, seed: u64, index: u64, pilot: &mut impl Pilot) -> EndedTrial {
        let crew = &self.motion.start;
        let (obstacles, stages) = (self.obstacles.as_slice(), self.stages.as_slice());
        let start = TrialStart { obstacles, stages, poses: &crew.poses, docked: &crew.docked };
        let trial = Trial::new(self.order, self.errors, start, seed, index);
        run(trial, DisturbedView::new(self.disturbances, seed, index), pilot)
    }

    /// Statistics of trials.
    pub fn report(&self, trials: &[EndedTrial]) -> SimulationReport {
        let names = (0..self.order.robots.len()).map(|robot| self.order.robot(robot).name.clone()).collect();
        SimulationReport::new(names, trials)
    }
}

/// Report on `trials` trials (at most [`MAX_TRIALS`]) of a plan by the controller; `None` if the device does not bound
/// its errors, or nothing is assembled.
pub fn simulate(
    order: &MicrorobotsOrder,
    motion: &MicrorobotsMotion,
    trials: u64,
    seed: u64,
    threads: usize,
) -> Option<SimulationReport> {
    simulate_disturbed(order, motion, Disturbances::default(), trials, seed, threads)
}

/// The same under disturbances.
pub fn simulate_disturbed(
    order: &MicrorobotsOrder,
    motion: &MicrorobotsMotion,
    disturbances: Disturbances,
    trials: u64,
    seed: u64,
    threads: usize,
) -> Option<SimulationReport> {
    let bed = SimulatedBed::new(order, motion, disturbances)?;
    let controller = Controller::new(order, motion)?;
    let one = |index: usize| bed.trial(seed, index as u64, &mut controller.clone());
    Some(bed.report(&parallel::in_order(trials.min(MAX_TRIALS) as usize, threads, one)))
}

/// The stages of a plan in which robots dock, in order of time.
fn docking_stages(motion: &MicrorobotsMotion) -> Vec<&AssemblyStage> {
    let docks = |stage: &&AssemblyStage| matches!(stage, AssemblyStage::Pair { .. } | AssemblyStage::Single { .. });
    motion.steps.iter().flat_map(MicrorobotsStepMotion::stages).filter(docks).collect()
}

fn run(mut trial: Trial, mut view: DisturbedView, pilot: &mut impl Pilot) -> EndedTrial {
    let failure = attempt(&mut trial, &mut view, pilot).err();
    trial.tick();
    let area = match failure {
        None => area::area_match(trial.order, &trial.poses, trial.structure),
        Some(_) => None,
    };
    EndedTrial { failure, time_ns: trial.time_ns(), contacts: trial.contacts, area }
}

/// Measures, asks the pilot and drives, until the pilot ends.
fn attempt(trial: &mut Trial, view: &mut DisturbedView, pilot: &mut impl Pilot) -> Result<(), TrialFailure> {
    let mut measured = vec![None; trial.poses.len()];
    for _ in 0..MAX_MEASUREMENTS {
        trial.tick();
        view.disturb(trial);
        (0..measured.len()).for_each(|robot| measured[robot] = view.seen(trial.measured(robot)));
        let now_ns = trial.time_ns();
        // The bed holds still until the answer comes.
        trial.rest_until(now_ns.saturating_add(view.delay_ns()));
        let done = match pilot.observe(&measured, now_ns) {
            Command::Drive { segments, until_ns } => {
                let done = trial.carry_out(segments);
                trial.rest_until(until_ns);
                done
            }
            Command::Rest { until_ns } | Command::Continue { until_ns } => {
                trial.rest_until(until_ns);
                Ok(())
            }
            Command::Finished => return trial.all_docked(pilot.step()),
            Command::Stop(stop) => return Err(TrialFailure::stopped(stop, trial.order)),
        };
        let during = |(robot, reason)| TrialFailure { robot, reason, step: pilot.step(), phase: pilot.phase() };
        done.map_err(during)?;
    }
    Err(TrialFailure { robot: 0, reason: FailureReason::TimeLimit, step: pilot.step(), phase: pilot.phase() })
}

#[cfg(test)]
pub(in crate::plan::microrobots) mod tests;
