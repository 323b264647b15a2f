//! Simulation: carries plans out with devices and measurements that are not what they should be.
//!
//! Input: an order, its plan, how many trials, a seed. Output: a report of its kind. Promise: the same seed gives the same report,
//! whatever the number of threads. Only microrobots state their errors so far.

pub mod microrobots;

use crate::claims::Order;
use crate::plan::Motion;
use microrobots::SimulationReport;

/// Report on so many trials of a plan; `None` where the kind or the device does not state its errors, or nothing is assembled.
pub fn simulate(order: &Order, motion: &Motion, trials: u64, seed: u64, threads: usize) -> Option<SimulationReport> {
    match (order, motion) {
        (Order::Microrobots(order), Motion::Microrobots(motion)) => {
            microrobots::simulate(order, motion, trials, seed, threads)
        }
        (Order::Dimibot(_) | Order::ElectrodeArray(_) | Order::Microrobots(_) | Order::Fingers(_), _) => None,
    }
}
