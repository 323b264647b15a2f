//! Simulation: carries plans out with imperfect devices and measurements.
//!
//! Input: an order, its plan, the number of trials, a seed. Output: a report of its kind. Promise: the same seed gives the same report,
//! whatever the number of threads. Only microrobots have error bounds.

pub mod microrobots;

use crate::claims::Order;
use crate::plan::Motion;
use microrobots::SimulationReport;

/// Report on `trials` trials of a plan; `None` if the kind or the device has no error bounds, or nothing is assembled.
pub fn simulate(order: &Order, motion: &Motion, trials: u64, seed: u64, threads: usize) -> Option<SimulationReport> {
    match (order, motion) {
        (Order::Microrobots(order), Motion::Microrobots(motion)) => {
            microrobots::simulate(order, motion, trials, seed, threads)
        }
        (Order::Dimibot(_) | Order::ElectrodeArray(_) | Order::Microrobots(_) | Order::Fingers(_), _) => None,
    }
}
