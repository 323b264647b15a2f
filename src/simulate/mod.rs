//! Simulation: executes plans on imperfect devices with imperfect measurements.
//!
//! Input: a plan, the number of trials, a seed. Output: a report of its kind. Promise: the same seed gives the same
//! report, whatever the number of threads. Only microrobots state their errors so far.

use crate::plan::Motion;
use crate::plan::microrobots::{control, simulation};
pub use control::ControlPhase;
pub use simulation::{Disturbances, DockingStatistics, FailureReason, Failures, ShareSpread, SimulationReport, Spread};

/// Report on `trials` trials of a plan; `None` if the kind or the device has no error bounds, or nothing is assembled.
pub fn simulate(motion: &Motion, trials: u64, seed: u64, threads: usize) -> Option<SimulationReport> {
    simulate_disturbed(motion, Disturbances::default(), trials, seed, threads)
}

/// The same as `simulate`, under disturbances.
pub fn simulate_disturbed(
    motion: &Motion,
    disturbances: Disturbances,
    trials: u64,
    seed: u64,
    threads: usize,
) -> Option<SimulationReport> {
    match motion {
        Motion::Microrobots(planned) => {
            simulation::simulate_disturbed(planned.order, &planned.motion, disturbances, trials, seed, threads)
        }
        // These kinds have no simulation.
        Motion::Dimibot(_) | Motion::ElectrodeArray(_) | Motion::Fingers(_) => None,
    }
}
