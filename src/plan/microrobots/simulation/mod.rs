//! Closed-loop simulation: carries out a plan's assemblies with imperfect robots and measurements.
//!
//! Input: an order, its plan, the number of trials, a seed. Output: a [`SimulationReport`]. Every trial draws for each robot errors of its
//! figures, always within the bounds of the device (`facts.errors`): a part that stays for the trial and a part that
//! changes from interval to interval; a quarter of the trials keep extreme errors throughout, another quarter change between
//! extremes. Robots are then brought to their goals by the closed loop of [`strategy`](crate::plan::microrobots::strategy).
//!
//! Simulated: measurement, gross motion, fine motion by whole cycles of its primitives, contact of a corner, alignment,
//! collisions of the true bodies. Not simulated: single strokes (paths are continuous). Robots that orbit keep their nominal centres, and
//! a body that enters the disc that they sweep, grown by the creep of a centre in one turn, has collided. Other steps than
//! `assemble` are assumed to be carried out exactly. The structure is where its first two robots stick together: the goals and approaches of
//! later robots move along with it, and are measured relative to it.
//!
//! If all errors are 0, measuring changes nothing: the legs of the plan are carried out as written (`written`).
//!
//! The same seed gives the same report, whatever the number of threads: a trial depends on the seed and its own index alone.
//! Cost grows with trials times the path length over the interval.

mod pair;
mod report;
mod single;
mod trial;
mod written;

pub use report::{Dockings, Failures, SimulationReport, Spread, wilson};
pub use trial::FailureReason;

use crate::claims::microrobots::MicrorobotsOrder;
use crate::plan::microrobots::strategy::{Episode, episodes, obstacles};
use crate::plan::microrobots::{AssemblyStage, MicrorobotsMotion};
use single::SingleStage;
use trial::{EndedTrial, Trial, TrialFailure};

/// Greatest number of trials in one call.
pub const MAX_TRIALS: u64 = 10_000_000;

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
    let episodes = episodes(order, motion);
    let first = episodes.first()?;
    let solids = obstacles(order);
    let start = (&first.poses[..], &first.docked[..]);
    let one = |index: u64| run(Trial::new(order, errors, &solids, start, (seed, index)), &episodes);
    let names = (0..order.robots.len()).map(|robot| order.robot(robot).name.clone()).collect();
    Some(SimulationReport::new(names, &gathered(trials.min(MAX_TRIALS), threads.max(1) as u64, &one)))
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

fn run(mut trial: Trial, episodes: &[Episode]) -> EndedTrial {
    let failure = episodes.iter().try_for_each(|episode| stage(&mut trial, episode)).err();
    trial.tick();
    EndedTrial { failure, time_ns: trial.time_ns(), met: trial.met }
}

fn stage(trial: &mut Trial, episode: &Episode) -> Result<(), TrialFailure> {
    trial.take(episode);
    // Stages without legs are those of tests of the strategy alone.
    if trial.errors.are_zero() && !episode.legs.is_empty() {
        return written::run(trial, episode);
    }
    match *episode.stage {
        AssemblyStage::Departure { .. } => written::depart(trial, episode),
        AssemblyStage::Single { robot, states, approach, goal } => {
            SingleStage { robot, states, approach, goal }.run(trial, episode)
        }
        AssemblyStage::Escort { .. } => Ok(()),
        AssemblyStage::Pair { .. } => pair::run(trial, episode),
    }
}

#[cfg(test)]
mod tests;
