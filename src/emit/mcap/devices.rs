//! The devices of a log with their jobs in order of time; each stands where its scene places it, the others side by
//! side.

use super::frames::{self, FramePose, Mover};
use super::{LogTopic, pictures};
use crate::claims::{Claims, Job};
use crate::verify::Verified;
use std::collections::BTreeMap;

/// Gap between the pictures of two devices, in units of pictures.
const GAP: f64 = 5.0;

/// Position of a device in pictures.
pub struct LoggedDevice<'a> {
    pub name: &'a str,
    /// Its pose in the frame `world`.
    pub pose: FramePose,
    /// Its first job.
    pub job: &'a Job,
}

impl<'a> LoggedDevice<'a> {
    /// The devices in the order of their first jobs: those that a scene places are there, the others side by side.
    pub fn all(verified: &'a Verified) -> Vec<LoggedDevice<'a>> {
        let claims = verified.claims();
        let mut devices: Vec<LoggedDevice> = Vec::new();
        let mut left = right_of_placed(claims);
        for job in &claims.jobs {
            if devices.iter().any(|device| device.name == job.device) {
                continue;
            }
            let pose = match claims.frame(&job.device) {
                Some(frame) => FramePose::turned([frame.x_um, frame.y_um, 0.0], frame.heading_rad),
                None => {
                    let [low, high] = pictures(&job.order).reach();
                    let offset = left - low;
                    left += high - low + GAP;
                    FramePose::at([offset, 0.0, 0.0])
                }
            };
            devices.push(LoggedDevice { name: &job.device, pose, job });
        }
        devices
    }
}

/// `/tf` of all devices and of the movers in their frames.
pub fn frames(devices: &[LoggedDevice], movers: &[Mover]) -> LogTopic {
    let poses: Vec<(&str, FramePose)> = devices.iter().map(|device| (device.name, device.pose)).collect();
    frames::topic(&poses, movers)
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
