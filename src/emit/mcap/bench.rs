//! The devices of a log with their jobs in order of time; each stands where its scene places it, the others side by
//! side.

use super::frames::{self, Mover, StandingPose};
use super::{LogTopic, pictures};
use crate::claims::{Claims, Job};
use crate::verify::Verified;
use std::collections::BTreeMap;

/// Gap between the pictures of two devices, in units of pictures.
const GAP: f64 = 5.0;

/// Position of a device in pictures.
pub struct PictureBench<'a> {
    pub device: &'a str,
    /// Its pose in the frame `world`.
    pub stand: StandingPose,
    /// Its first job.
    pub job: &'a Job,
}

impl<'a> PictureBench<'a> {
    /// The devices in the order of their first jobs: those that a scene places are there, the others side by side.
    pub fn all(verified: &'a Verified) -> Vec<PictureBench<'a>> {
        let claims = verified.claims();
        let mut benches: Vec<PictureBench> = Vec::new();
        let mut left = right_of_placed(claims);
        for job in &claims.jobs {
            if benches.iter().any(|bench| bench.device == job.device) {
                continue;
            }
            let stand = match claims.frame(&job.device) {
                Some(frame) => StandingPose::turned([frame.x_um, frame.y_um, 0.0], frame.heading_rad),
                None => {
                    let [low, high] = pictures(&job.order).reach();
                    let offset = left - low;
                    left += high - low + GAP;
                    StandingPose::at([offset, 0.0, 0.0])
                }
            };
            benches.push(PictureBench { device: &job.device, stand, job });
        }
        benches
    }
}

/// `/tf` of all devices and of the movers in their frames.
pub fn frames(benches: &[PictureBench], movers: &[Mover]) -> LogTopic {
    let stands: Vec<(&str, StandingPose)> = benches.iter().map(|bench| (bench.device, bench.stand)).collect();
    frames::topic(&stands, movers)
}

/// Start along x of the devices that no scene places.
fn right_of_placed(claims: &Claims) -> f64 {
    let devices: BTreeMap<&str, &Job> = claims.jobs.iter().map(|job| (job.device.as_str(), job)).collect();
    let ends = devices.into_values().filter_map(|job| {
        let frame = claims.frame(&job.device)?;
        pictures(&job.order).right_in_scene(&frame)
    });
    ends.reduce(f64::max).map_or(0.0, |end| end.max(0.0) + GAP)
}
