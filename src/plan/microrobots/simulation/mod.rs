//! Simulation of the closed loop: the controller brings imperfect robots together by imperfect measurements.
//!
//! Input: an order, its plan, the number of trials, a seed. Output: a [`SimulationReport`]. Every trial draws for each robot errors of its
//! figures, always within the bounds of the device (`facts.errors`): a part that stays for the trial and a part that
//! changes from interval to interval; a quarter of the trials keep extreme errors throughout, another quarter change between
//! extremes. The bed has true poses, which the [`Controller`] never sees: it is given measurements, and
//! answers with segments of the drive, as it does in `tweeze control`.
//!
//! Simulated: measurement, the motion of all robots, contact of bodies, alignment, sticking, collisions of the true bodies. A trial succeeds
//! if the controller finishes and every robot sticks in its place. Not simulated: single strokes (paths are continuous); a robot that
//! sticks stays where it is, even if its arm is down until the end of the command in which it docked.
//!
//! If all errors are 0, measuring changes nothing: the legs of the plan are carried out as written.
//!
//! The same seed gives the same report, whatever the number of threads: a trial depends on the seed and its own index alone.
//! Cost grows with trials times the path length over the interval.

mod area;
mod contact;
mod report;
mod trial;

pub use report::{Dockings, Failures, ShareSpread, SimulationReport, Spread, wilson};
pub use trial::FailureReason;

use crate::claims::microrobots::MicrorobotsOrder;
use crate::plan::microrobots::control::{Command, Controller};
use crate::plan::microrobots::strategy::obstacles;
use crate::plan::microrobots::{AssemblyStage, MicrorobotsMotion, MicrorobotsStepMotion};
use trial::{EndedTrial, Trial, TrialFailure, TrialStart};

/// Greatest number of trials in one call.
pub const MAX_TRIALS: u64 = 10_000_000;

/// Measurements of one trial: more than a day of them at five a second.
const MAX_MEASUREMENTS: u64 = 1_000_000;

/// Report on `trials` trials (at most [`MAX_TRIALS`]) of a plan; `None` if the device does not bound its errors, or nothing is
/// assembled.
pub fn simulate(
    order: &MicrorobotsOrder,
    motion: &MicrorobotsMotion,
    trials: u64,
    seed: u64,
    threads: usize,
) -> Option<SimulationReport> {
    let errors = order.facts.errors?;
    let stages = docking_stages(motion);
    if stages.is_empty() {
        return None;
    }
    let solids = obstacles(order);
    let start =
        TrialStart { obstacles: &solids, stages: &stages, poses: &motion.start.poses, docked: &motion.start.docked };
    let controller = Controller::new(order, motion)?;
    let one = |index: u64| run(Trial::new(order, errors, start, (seed, index)), controller.clone());
    let names = (0..order.robots.len()).map(|robot| order.robot(robot).name.clone()).collect();
    Some(SimulationReport::new(names, &gathered(trials.min(MAX_TRIALS), threads.max(1) as u64, &one)))
}

/// The stages of a plan in which robots dock, in order of time.
fn docking_stages(motion: &MicrorobotsMotion) -> Vec<&AssemblyStage> {
    let docks = |stage: &&AssemblyStage| matches!(stage, AssemblyStage::Pair { .. } | AssemblyStage::Single { .. });
    motion.steps.iter().flat_map(MicrorobotsStepMotion::stages).filter(docks).collect()
}

/// All trials in their order, by several threads.
fn gathered(trials: u64, threads: u64, one: &(impl Fn(u64) -> EndedTrial + Sync)) -> Vec<EndedTrial> {
    let share = trials.div_ceil(threads);
    std::thread::scope(|scope| {
        let part = |thread: u64| (thread * share).min(trials)..((thread + 1) * share).min(trials);
        let handles: Vec<_> = (0..threads)
            .map(|thread| scope.spawn(move || part(thread).map(one).collect::<Vec<EndedTrial>>()))
            .collect();
        // A trial does not panic; were it to, its thread's share would be missing from the count.
        handles.into_iter().flat_map(|handle| handle.join().unwrap_or_default()).collect()
    })
}

fn run(mut trial: Trial, mut controller: Controller) -> EndedTrial {
    let failure = attempt(&mut trial, &mut controller).err();
    trial.tick();
    let area = match failure {
        None => area::area_match(trial.order, &trial.poses, trial.structure),
        Some(_) => None,
    };
    EndedTrial { failure, time_ns: trial.time_ns(), met: trial.met, area }
}

/// Measures, asks and drives until the controller ends.
fn attempt(trial: &mut Trial, controller: &mut Controller) -> Result<(), TrialFailure> {
    let mut measured = vec![None; trial.poses.len()];
    for _ in 0..MAX_MEASUREMENTS {
        trial.tick();
        let now_ns = trial.time_ns();
        (0..measured.len()).for_each(|robot| measured[robot] = Some(trial.measured(robot)));
        let done = match controller.observe(&measured, now_ns) {
            Command::Drive { segments, until_ns } => {
                let done = trial.carry_out(segments);
                trial.rest_until(until_ns);
                done
            }
            Command::Rest { until_ns } | Command::Continue { until_ns } => {
                trial.rest_until(until_ns);
                Ok(())
            }
            Command::Finished => return trial.all_docked(controller.step()),
            Command::Stop(stop) => return Err(TrialFailure::stopped(stop)),
        };
        let during =
            |(robot, reason)| TrialFailure { robot, reason, step: controller.step(), phase: controller.phase() };
        done.map_err(during)?;
    }
    Err(TrialFailure { robot: 0, reason: FailureReason::TimeLimit, step: controller.step(), phase: controller.phase() })
}

#[cfg(test)]
pub(in crate::plan::microrobots) mod tests;
