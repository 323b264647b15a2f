//! Lower bound on the strokes after which several robots have reached their goals, from what one voltage lets them do.
//!
//! Problem: every robot moves with every stroke, so robots whose paths differ in length hold one another up. Input:
//! robots of an order with their starts and goals, both with slacks. Output: a number of strokes that no schedule
//! undercuts, whatever control states it drives and in whatever order the robots arrive.
//!
//! Method: let robot i arrive after t_i strokes, of which it turns in q_i and runs straight in p_i = t_i - q_i. Then
//! 1. q_i is, up to the slack, the turn from its first heading to its last one and a number k_i of full circles, since
//!    it turns in one sense only; and p_i is at least what its turning centre must be moved with that many circles
//!    ([`free::least_ways`]).
//! 2. If the arm of i is down in every control state in which that of j is, then q_i ≥ q_j: while neither has arrived,
//!    i turns with every stroke with which j does. If i has arrived first and stays (it docked, so its arm must be up),
//!    no such state is driven any more, and j turns no more either. If j arrives first, q_i still grows.
//! 3. The strokes are at least the greatest p_i + q_i.
//!
//! So robots are visited in order of the number of states that lower their arms. For each robot the numbers of circles
//! that matter are 0, 1 and, for each choice of its predecessor (the last one visited to which 2. applies), the least
//! that turns as far as that choice does. The minimum over all choices of the greatest sum is found robot by robot.
//! Robots that do not stay where they arrive break 2., and the caller leaves them out. Not used: the directions of the
//! straight parts, obstacles, and the order in which robots touch; so the bound need not be attained. Cost: the square
//! of the number of robots.

use crate::claims::microrobots::{MicrorobotsOrder, Precision};
use crate::device::microrobots::Arm;
use crate::geometry::Pose;
use crate::plan::microrobots::free::{self, LeastWays, PoseWithin};

/// Rounding allowance of a number of strokes.
const ROUNDING_STROKES: f64 = 1e-3;

/// Rounding allowances of a path: absolute, and as a share of the turning radius.
const ROUNDING_UM: f64 = 1e-6;
const ROUNDING_SHARE: f64 = 1e-8;

/// Slack of a pose that is known exactly.
pub const EXACT: Precision = Precision { place_um: 0.0, heading_rad: 0.0 };

/// A robot on its way to the place where it stays.
#[derive(Debug, Clone, Copy)]
pub struct RobotArrival {
    /// Index into the order's robots.
    pub robot: usize,
    pub from: PoseWithin,
    pub to: PoseWithin,
}

impl RobotArrival {
    /// From an exact pose to within the order's precision of another.
    pub fn of(order: &MicrorobotsOrder, robot: usize, from: Pose, to: Pose) -> RobotArrival {
        let (from, to) = (PoseWithin { pose: from, slack: EXACT }, PoseWithin { pose: to, slack: order.precision });
        RobotArrival { robot, from, to }
    }
}

/// A number of circles of a robot, with the least strokes that it and the robots visited before it then need.
#[derive(Debug, Clone, Copy)]
struct CircleChoice {
    /// Fewest strokes in which it turns.
    turning: f64,
    strokes: f64,
}

/// Strokes that a robot needs.
struct StrokesNeeded {
    ways: LeastWays,
    /// Rounding allowance of a path.
    allowed_um: f64,
    step_um: f64,
}

impl StrokesNeeded {
    fn new(order: &MicrorobotsOrder, arrival: &RobotArrival) -> StrokesNeeded {
        let facts = order.robot(arrival.robot);
        let allowed_um = ROUNDING_UM + ROUNDING_SHARE * facts.turning_radius_um;
        StrokesNeeded { ways: free::least_ways(facts, arrival.from, arrival.to), allowed_um, step_um: facts.step_um }
    }

    fn strokes(&self, way_um: f64) -> f64 {
        way_um / self.step_um
    }

    /// Fewest turning strokes, and fewest strokes of the whole path, with this many full circles.
    fn with(&self, circles: u64) -> CircleChoice {
        let turn_um = self.ways.turn_um[0] + self.ways.circle_um * circles as f64 - self.allowed_um;
        let way_um = self.ways.length_um(circles) - self.allowed_um;
        CircleChoice { turning: self.strokes(turn_um.max(0.0)), strokes: self.strokes(way_um.max(0.0)) }
    }

    /// Fewest full circles with which it can turn for `turning` strokes.
    fn circles(&self, turning: f64) -> u64 {
        let lacking_um = turning * self.step_um - self.allowed_um - self.ways.turn_um[1];
        (lacking_um / self.ways.circle_um).ceil().max(0.0) as u64
    }
}

/// Least strokes until all of these robots have arrived.
pub fn least_strokes(order: &MicrorobotsOrder, mut arrivals: Vec<RobotArrival>) -> u64 {
    arrivals.sort_by_key(|arrival| (lowering(order, arrival.robot).count(), arrival.robot));
    let mut visited: Vec<Vec<CircleChoice>> = Vec::with_capacity(arrivals.len());
    let mut least: f64 = 0.0;
    for (at, arrival) in arrivals.iter().enumerate() {
        let earlier = arrivals[..at].iter().rposition(|earlier| turns_with(order, arrival.robot, earlier.robot));
        let earlier = earlier.map_or(&[] as &[CircleChoice], |earlier| &visited[earlier]);
        let choices = choices(&StrokesNeeded::new(order, arrival), earlier);
        least = least.max(choices.iter().map(|choice| choice.strokes).fold(f64::INFINITY, f64::min));
        visited.push(choices);
    }
    (least - ROUNDING_STROKES).ceil().max(0.0) as u64
}

/// Choices of a robot after those of its predecessor; one that turns less far than each of these has infinite strokes.
fn choices(needed: &StrokesNeeded, earlier: &[CircleChoice]) -> Vec<CircleChoice> {
    let mut circles: Vec<u64> =
        [0, 1].into_iter().chain(earlier.iter().map(|choice| needed.circles(choice.turning))).collect();
    circles.sort_unstable();
    circles.dedup();
    let choice = |circles: u64| {
        let turns = |choice: &&CircleChoice| needed.circles(choice.turning) <= circles;
        let before = earlier.iter().filter(turns).map(|choice| choice.strokes);
        let before = if earlier.is_empty() { 0.0 } else { before.fold(f64::INFINITY, f64::min) };
        let own = needed.with(circles);
        CircleChoice { strokes: own.strokes.max(before), ..own }
    };
    circles.into_iter().map(choice).collect()
}

/// Control states that lower the arm of a robot: few for those that snap down last.
pub fn lowering(order: &MicrorobotsOrder, robot: usize) -> impl Iterator<Item = usize> {
    let row = order.robots[robot].row;
    (0..order.states.len()).filter(move |state| order.states[*state].arms[row] == Arm::Down)
}

/// Whether the arm of a robot is down whenever that of the other one is.
fn turns_with(order: &MicrorobotsOrder, robot: usize, other: usize) -> bool {
    let row = order.robots[robot].row;
    lowering(order, other).all(|state| order.states[state].arms[row] == Arm::Down)
}

#[cfg(test)]
mod tests;
