//! The motion of the devices of a verified schedule over time: the common base of all formats that draw it.
//!
//! Input: a [`Verified`] schedule and the name of a device. Output: the places of what moves, at the instants of its
//! states and between them, and the surroundings. Nothing is drawn here.

use crate::claims::Job;
use crate::schedule::PlanRecord;
use crate::verify::Verified;

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
