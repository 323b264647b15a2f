//! Collision check of a command, against obstacles and other robots, before it is given.
//!
//! Input: the measured poses, and strokes in control states. Output: the first robot that these bring into an obstacle
//! or into another robot, as far as their poses are known. Every stroke moves all robots that have not docked, so those
//! that stand by are checked like the driven ones. Robots that are to meet may touch. Nothing is allocated.

use super::StrokeSegment;
use super::belief::Belief;
use crate::claims::microrobots::MicrorobotsOrder;
use crate::geometry::Pose;
use crate::plan::microrobots::strategy::{StrategySolid, body};

/// Samples of a robot's path per width of its body.
const SAMPLES_PER_WIDTH: f64 = 8.0;

/// Most samples of a segment, so that an answer is not late: circles with a very large turning radius are sampled more
/// coarsely.
const MAX_SAMPLES: f64 = 4096.0;

/// Thing that a robot would run into, as an index into the order's obstacles or robots.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum InTheWay {
    Obstacle(usize),
    Robot(usize),
}

impl InTheWay {
    /// Its name in the order's scene; empty if it is not of this order.
    pub fn name(self, order: &MicrorobotsOrder) -> &str {
        match self {
            InTheWay::Obstacle(at) => order.obstacles.get(at).map_or("", |obstacle| &obstacle.name),
            InTheWay::Robot(robot) => &order.robot(robot).name,
        }
    }

    /// Thing of this name in the order's scene.
    pub fn named(order: &MicrorobotsOrder, name: &str) -> Option<InTheWay> {
        let obstacle = order.obstacles.iter().position(|obstacle| obstacle.name == name).map(InTheWay::Obstacle);
        let robot = || (0..order.robots.len()).find(|robot| order.robot(*robot).name == name).map(InTheWay::Robot);
        obstacle.or_else(robot)
    }
}

/// A collision that a command would lead to.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct CollisionAhead {
    /// Index into the order's robots.
    pub robot: usize,
    pub with: InTheWay,
}

impl Belief<'_> {
    /// First collision that segments lead to from the measured poses. Robots in `may_touch` are driven against each
    /// other or against docked ones on purpose.
    pub fn collision_ahead(&self, segments: &[StrokeSegment], may_touch: [Option<usize>; 2]) -> Option<CollisionAhead> {
        self.approach_ahead(0.0, segments, may_touch)
    }

    /// Whether the segments of a robot's drive lead to no collision, and bring nothing nearer than `room_um` to another
    /// thing.
    pub fn has_room(&self, room_um: f64, segments: &[StrokeSegment]) -> bool {
        // Things that are nearer already do not enter `room_um`, so collisions are checked as well.
        [0.0, room_um].into_iter().all(|room_um| self.approach_ahead(room_um, segments, [None; 2]).is_none())
    }

    fn approach_ahead(
        &self,
        room_um: f64,
        segments: &[StrokeSegment],
        may_touch: [Option<usize>; 2],
    ) -> Option<CollisionAhead> {
        let moving = || (0..self.poses.len()).filter(|robot| !self.docked[*robot]);
        let into_obstacle = |robot: usize| self.obstacle_ahead(robot, room_um, segments).map(InTheWay::Obstacle);
        let into_robot = |robot: usize| {
            let meets = |other: &usize| {
                let is_met_before = *other < robot && !self.docked[*other];
                let is_on_purpose =
                    [robot, *other].iter().all(|one| self.docked[*one] || may_touch.contains(&Some(*one)));
                *other != robot
                    && !is_met_before
                    && !is_on_purpose
                    && self.is_led_into([robot, *other], room_um, segments)
            };
            (0..self.poses.len()).find(meets).map(InTheWay::Robot)
        };
        moving().find_map(|robot| {
            let with = into_obstacle(robot).or_else(|| into_robot(robot))?;
            Some(CollisionAhead { robot, with })
        })
    }

    /// First obstacle that segments bring a robot into.
    fn obstacle_ahead(&self, robot: usize, room_um: f64, segments: &[StrokeSegment]) -> Option<usize> {
        if self.obstacles.is_empty() {
            return None;
        }
        let (facts, start) = (self.order.robot(robot), self.poses[robot]);
        // The body, shrunk by the error of its measurement, is certainly there.
        let doubt_um = self.doubt_um(self.reach_um(robot));
        let touches = |obstacle: &StrategySolid, pose: Pose, less_um: f64| {
            obstacle.distance_um(&body(facts, pose, less_um), 0.0) <= room_um
        };
        let enters = |obstacle: &StrategySolid, pose: Pose, less_um: f64| {
            touches(obstacle, pose, less_um) && !touches(obstacle, start, less_um)
        };
        // A robot that seems to touch at the start may go on only until it certainly does.
        let is_entered = |obstacle: &StrategySolid, pose: Pose| {
            touches(obstacle, pose, 0.0) && (enters(obstacle, pose, 0.0) || enters(obstacle, pose, doubt_um))
        };
        let mut from = start;
        segments.iter().find_map(|segment| {
            let (begin, way_um) = (from, self.way_um(robot, segment));
            from = self.gone(robot, begin, segment, 1.0);
            // Where the body turns, its corners go farther than its middle.
            let most_um = way_um * (1.0 + self.reach_um(robot) / facts.turning_radius_um);
            PathSamples::new(way_um / facts.width_um, most_um).find_map(|part| {
                let pose = self.gone(robot, begin, segment, part);
                let whole = body(facts, pose, 0.0);
                let clear_um = self
                    .obstacles
                    .iter()
                    .map(|obstacle| obstacle.distance_um(&whole, 0.0))
                    .fold(f64::INFINITY, f64::min);
                let entered = || self.obstacles.iter().position(|obstacle| is_entered(obstacle, pose));
                if clear_um <= room_um { entered() } else { None }.ok_or(clear_um - room_um)
            })
        })
    }

    /// Whether segments bring two robots into each other.
    fn is_led_into(&self, pair: [usize; 2], room_um: f64, segments: &[StrokeSegment]) -> bool {
        let facts = pair.map(|robot| self.order.robot(robot));
        let start = pair.map(|robot| self.poses[robot]);
        let ways_um = segments.iter().map(|segment| self.way_um(pair[0], segment) + self.way_um(pair[1], segment));
        if self.least_apart_um(pair, start) > ways_um.sum::<f64>() + room_um {
            return false;
        }
        let is_entered = |poses: [Pose; 2]| {
            let (apart_um, start_um) = (self.apart_um(pair, poses) - room_um, self.apart_um(pair, start) - room_um);
            let doubt_um = self.doubt_of_both_um(pair);
            apart_um <= 0.0 && (start_um > 0.0 || (apart_um <= -doubt_um && start_um > -doubt_um))
        };
        let mut from = start;
        segments.iter().any(|segment| {
            let begin = from;
            from = [0, 1].map(|nth| self.gone(pair[nth], begin[nth], segment, 1.0));
            let way_um = self.way_um(pair[0], segment) + self.way_um(pair[1], segment);
            let widths = way_um / facts[0].width_um.min(facts[1].width_um);
            let met = PathSamples::new(widths, way_um).find_map(|part| {
                let at = [0, 1].map(|nth| self.gone(pair[nth], begin[nth], segment, part));
                let clear_um = self.least_apart_um(pair, at) - room_um;
                if clear_um <= 0.0 && is_entered(at) { Ok(()) } else { Err(clear_um) }
            });
            met.is_some()
        })
    }

    /// Path length of a robot over a segment.
    fn way_um(&self, robot: usize, segment: &StrokeSegment) -> f64 {
        if self.docked[robot] { 0.0 } else { self.order.robot(robot).step_um * segment.strokes as f64 }
    }

    /// Pose of a robot after a part of a segment.
    fn gone(&self, robot: usize, from: Pose, segment: &StrokeSegment, part: f64) -> Pose {
        let arm = self.order.states[segment.state].arms[self.order.robots[robot].row];
        self.order.robot(robot).moved(from, arm, self.way_um(robot, segment) * part)
    }
}

/// Evenly spaced samples of a path, without those at which the bodies certainly do not touch.
struct PathSamples {
    count: f64,
    /// Most by which bodies can come nearer from one sample to the next.
    most_um: f64,
}

impl PathSamples {
    /// Samples for a path of `widths` body widths, on which bodies come nearer to each other by at most `most_um`.
    fn new(widths: f64, most_um: f64) -> Self {
        let count = (widths * SAMPLES_PER_WIDTH).ceil().clamp(1.0, MAX_SAMPLES);
        PathSamples { count, most_um: most_um / count }
    }

    /// First result of `find`, which is called with shares of the path. Its error is a lower bound on the distance of
    /// the bodies there, by which samples are skipped.
    fn find_map<T>(&self, find: impl Fn(f64) -> Result<T, f64>) -> Option<T> {
        let mut sample = 1.0;
        while sample <= self.count {
            match find(sample / self.count) {
                Ok(found) => return Some(found),
                Err(clear_um) if clear_um > 0.0 => sample += (clear_um / self.most_um).floor().max(1.0),
                Err(_) => sample += 1.0,
            }
        }
        None
    }
}
