//! Where a command brings the robots, held against the obstacles before it is given.
//!
//! Input: the measured poses, and strokes in control states. Output: the first robot that these bring into an obstacle, as far as its pose is known.
//! Every stroke moves all robots that have not docked, so those that stand by are looked at like the driven ones. Nothing is allocated.

use super::Segment;
use super::belief::Belief;
use crate::geometry::Pose;
use crate::plan::microrobots::strategy::{StrategySolid, body};

/// Looks at a robot on its way are so many to a width of its body.
const LOOKS_PER_WIDTH: f64 = 8.0;

/// Looks at a segment at most, so that an answer is not late: circles of robots with a very large turning radius are looked at more coarsely.
const MOST_LOOKS: f64 = 4096.0;

impl Belief<'_> {
    /// The first robot that some segments bring into an obstacle from where it was measured.
    pub fn led_into_obstacle(&self, segments: &[Segment]) -> Option<usize> {
        (0..self.poses.len())
            .filter(|robot| !self.docked[*robot] && !self.obstacles.is_empty())
            .find(|robot| self.is_led_into_obstacle(*robot, segments))
    }

    fn is_led_into_obstacle(&self, robot: usize, segments: &[Segment]) -> bool {
        let (facts, row) = (self.order.robot(robot), self.order.robots[robot].row);
        let start = self.poses[robot];
        // A body that is smaller by the error of its measurement is surely there.
        let doubt_um = self.doubt_um(self.reach_um(robot));
        let touches = |obstacle: &StrategySolid, pose: Pose, less_um: f64| {
            obstacle.distance_um(&body(facts, pose, less_um), 0.0) <= 0.0
        };
        let enters = |obstacle: &StrategySolid, pose: Pose, less_um: f64| {
            touches(obstacle, pose, less_um) && !touches(obstacle, start, less_um)
        };
        let goes_in = |pose: Pose| {
            let is_entered = |obstacle: &StrategySolid| {
                // From where it seems to touch already, it must not go on until it surely does.
                touches(obstacle, pose, 0.0) && (enters(obstacle, pose, 0.0) || enters(obstacle, pose, doubt_um))
            };
            self.obstacles.iter().any(is_entered)
        };
        let mut from = start;
        segments.iter().any(|segment| {
            let arm = self.order.states[segment.state].arms[row];
            let way_um = facts.step_um * segment.strokes as f64;
            let looks = (way_um * LOOKS_PER_WIDTH / facts.width_um).ceil().clamp(1.0, MOST_LOOKS);
            let begin = from;
            from = facts.moved(begin, arm, way_um);
            (1..=looks as u64).any(|look| goes_in(facts.moved(begin, arm, way_um * look as f64 / looks)))
        })
    }
}
