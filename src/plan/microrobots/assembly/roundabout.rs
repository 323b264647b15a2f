//! Paths of the first robot of a pair around bodies at rest, lengthened by the racetrack detour.
//!
//! The closed-form paths of [`super::closing`] avoid obstacles only by luck. Here the path goes around them by search,
//! and reaches the goal's axis as early as the second robot's last run requires; its missing length is added somewhere
//! on the path as half a circle, a straight segment, half a circle and the same segment back.

use super::StuckAssembly;
use super::pair::{PairSite, PairingContext, SecondRobotPath};
use crate::device::microrobots::Arm;
use crate::geometry::Pose;
use crate::plan::microrobots::free::{ArmSegment, joined, length_um};
use crate::plan::microrobots::paths::PathRequest;
use crate::plan::search::Meter;
use std::f64::consts::{PI, TAU};

/// Paths of the second robot that are tried.
const MAX_PATHS: usize = 3;

/// How early the first robot reaches its goal's axis, in turning radii.
const LEADS: [f64; 3] = [0.0, 1.0, 2.5];

/// Full circles of the second robot beyond those that are needed.
const MORE_CIRCLES: usize = 4;

/// Most full circles of the second robot.
const MAX_CIRCLES: usize = 40;

/// Place where the second robot orbits while the first is driven.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum OrbitChoice {
    Early,
    Late,
}

impl PairingContext<'_> {
    /// Paths of both robots, with few circles of the second one first.
    pub fn roundabout(
        &self,
        ways: &[Vec<ArmSegment>],
        site: PairSite,
        meter: &mut Meter,
    ) -> Result<Vec<(SecondRobotPath, Vec<ArmSegment>)>, StuckAssembly> {
        let mut found = Vec::new();
        for way in ways.iter().take(MAX_PATHS) {
            for orbit in [OrbitChoice::Early, OrbitChoice::Late] {
                for lead in LEADS {
                    found.extend(self.around(way, orbit, lead, site, meter)?);
                }
            }
        }
        found.sort_by(|a: &(SecondRobotPath, _), b| a.0.total_um.total_cmp(&b.0.total_um));
        Ok(found)
    }

    /// The same for one path of the second robot, one place of its orbit, and one lead.
    fn around(
        &self,
        way: &[ArmSegment],
        orbit: OrbitChoice,
        lead: f64,
        site: PairSite,
        meter: &mut Meter,
    ) -> Result<Vec<(SecondRobotPath, Vec<ArmSegment>)>, StuckAssembly> {
        let first = self.facts[0];
        let [before_um, after_um] = self.outside(way, orbit);
        let lead_um = lead * first.turning_radius_um;
        let run = |way_um: f64| ArmSegment { arm: Arm::Up, way_um };
        let from: Pose = first.moved(self.first_from(), Arm::Up, before_um);
        let to: Pose = first.moved(self.approach[0], Arm::Up, -after_um - lead_um);
        let (world, fixtures) = (&site.ground.world, site.fixtures);
        let request = PathRequest { world, robot: self.roles.first, from, to, fixtures };
        let middle = match site.ground.path(self.bed, &[self.roles.first, self.roles.second], &request, meter) {
            Ok(way) => way,
            Err(StuckAssembly::GaveUp) => return Err(StuckAssembly::GaveUp),
            Err(_) => return Ok(Vec::new()),
        };
        let needed_um = length_um(&middle) + before_um + after_um + lead_um + TAU * first.turning_radius_um;
        let second_paths = (0..=MAX_CIRCLES).map(|circles| match orbit {
            OrbitChoice::Early => self.second_path(way, [circles, 0]),
            OrbitChoice::Late => self.second_path(way, [0, circles]),
        });
        let spare_um = |second_path: &SecondRobotPath| {
            (self.total(second_path) - self.forced_strokes()) as f64 * first.step_um - needed_um
        };
        let long = second_paths.filter(|second_path| spare_um(second_path) >= 0.0).take(MORE_CIRCLES);
        let mut found = Vec::new();
        for second_path in long {
            let side_um = spare_um(&second_path) / 2.0;
            for at in 0..=middle.len() {
                let (head, tail) = middle.split_at(at);
                let racetrack = racetrack(first.turning_radius_um, side_um);
                let whole = [run(before_um)].into_iter().chain(head.iter().copied()).chain(racetrack);
                let whole = joined(whole.chain(tail.iter().copied()).chain([run(lead_um + after_um)]));
                found.push((second_path.clone(), whole));
            }
        }
        Ok(found)
    }

    /// Lengths that the first robot must run straight before the second's orbit and after it.
    fn outside(&self, way: &[ArmSegment], orbit: OrbitChoice) -> [f64; 2] {
        let way = joined(way.iter().copied());
        let per_um = self.facts[0].step_um / self.facts[1].step_um;
        let turns = |at: usize| way.get(at).is_some_and(|segment| segment.arm == Arm::Down);
        let later = way.iter().rposition(|segment| segment.arm == Arm::Down).filter(|at| *at > 0).unwrap_or(way.len());
        match orbit {
            OrbitChoice::Early => [0.0, length_um(&way[usize::from(turns(0))..]) * per_um],
            OrbitChoice::Late => {
                let end = if turns(later) { later + 1 } else { later };
                [length_um(&way[..later]) * per_um, length_um(&way[end..]) * per_um]
            }
        }
    }
}

/// Half a circle, a straight segment, half a circle, and the same segment back.
fn racetrack(radius_um: f64, side_um: f64) -> [ArmSegment; 4] {
    let half = ArmSegment { arm: Arm::Down, way_um: PI * radius_um };
    let side = ArmSegment { arm: Arm::Up, way_um: side_um };
    [half, side, half, side]
}
