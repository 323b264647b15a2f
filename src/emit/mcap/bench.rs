//! The devices of a log, side by side, with their jobs in order of time.

use super::{dimibot, electrode_array, fingers, microrobots};
use crate::check::claims::{Job, Order};
use crate::schedule::PlanRecord;
use crate::verify::Verified;

/// Gap between the pictures of two devices, in units of pictures.
const GAP: f64 = 5.0;

/// Where a device stands in pictures.
pub struct Bench<'a> {
    pub device: &'a str,
    /// Its place along x in the frame `world`.
    pub offset: f64,
    /// Its first job.
    pub job: &'a Job,
}

impl<'a> Bench<'a> {
    /// The devices in the order of their first jobs, side by side.
    pub fn all(verified: &'a Verified) -> Vec<Bench<'a>> {
        let mut benches: Vec<Bench> = Vec::new();
        let mut left = 0.0;
        for job in &verified.claims().jobs {
            if !benches.iter().any(|bench| bench.device == job.device) {
                let [low, high] = reach(job);
                benches.push(Bench { device: &job.device, offset: left - low, job });
                left += high - low + GAP;
            }
        }
        benches
    }
}

/// From where to where the picture of a job's device reaches along x, in its own frame.
fn reach(job: &Job) -> [f64; 2] {
    match &job.order {
        Order::Dimibot(order) => [0.0, dimibot::width_um(&order.facts)],
        Order::ElectrodeArray(order) => [0.0, electrode_array::width(&order.facts)],
        Order::Microrobots(order) => microrobots::reach_um(order),
        Order::Fingers(order) => fingers::reach_um(order),
    }
}

/// The jobs of a device with their plans, in order of time.
pub fn jobs<'a>(verified: &'a Verified, device: &str) -> Vec<(&'a Job, &'a PlanRecord)> {
    let all = verified.claims().jobs.iter().zip(&verified.schedule().plans);
    let mut jobs: Vec<_> = all.filter(|(job, _)| job.device == device).collect();
    jobs.sort_by_key(|(_, plan)| plan.start_ns);
    jobs
}

/// The plans of a device, in order of time.
pub fn plans<'a>(verified: &'a Verified, device: &str) -> Vec<&'a PlanRecord> {
    jobs(verified, device).into_iter().map(|(_, plan)| plan).collect()
}
