//! Content of a log for a DiMiBot: end-effector, path, obstacles and lattice. One unit of its pictures is one micrometre.

mod points;
pub mod scene;
pub mod tip;

use crate::claims::dimibot::{DimibotOrder, in_scene_um};
use crate::emit::Signals;
use crate::emit::dimibot::motion;
use crate::emit::mcap::cloud::SpaceStroke;
use crate::emit::mcap::frames::{FramePose, Mover};
use crate::emit::mcap::{LogTopic, Pictures};
use crate::geometry::Pose;
use crate::verify::Verified;

impl Pictures for DimibotOrder {
    fn topics(&self, verified: &Verified, signals: &Signals, device: &str) -> (Vec<LogTopic>, Vec<Mover>) {
        let poses = motion::poses(verified, signals, device);
        let mut topics = Vec::from(tip::topics(verified, device, &poses));
        topics.extend(points::topics(verified, device));
        topics.extend(scene::topics(verified, device));
        let places = poses.into_iter().map(|(t_ns, place)| (t_ns, Some(FramePose::at(place)))).collect();
        let outline = vec![SpaceStroke::from(&points::tip(&self.facts))];
        (topics, vec![Mover { frame: tip::tip_frame(device), device: device.to_owned(), places, outline }])
    }

    fn reach(&self) -> [f64; 2] {
        [0.0, motion::extent_um(&self.facts)[0]]
    }

    fn right_in_scene(&self, frame: &Pose) -> Option<f64> {
        let [x, y] = motion::extent_um(&self.facts);
        let corners = [[0.0, 0.0], [x, 0.0], [0.0, y], [x, y]];
        Some(corners.map(|corner| in_scene_um(corner, Some(frame))[0]).into_iter().fold(f64::NEG_INFINITY, f64::max))
    }
}
