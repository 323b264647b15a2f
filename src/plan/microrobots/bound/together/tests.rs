//! The bound compared with sequences of control states: random ones, ones that attain it, and all of them on coarse
//! beds.
//!
//! The oracle has its own motion and shares nothing with the planner. It lets robots arrive wherever they are within
//! the precision, whether or not they touch, so it has every plan that a verifier accepts, and more.
//! `TWEEZE_ORACLE_CASES=2000` runs more cases.

use super::*;
use crate::device::microrobots::Turning;
use crate::plan::microrobots::world::fixture::{bed, robot};
use crate::random::SplitMix64;
use std::f64::consts::TAU;

/// Number of random beds of each kind.
fn cases(usual: u64) -> u64 {
    std::env::var("TWEEZE_ORACLE_CASES").ok().and_then(|text| text.parse().ok()).unwrap_or(usual)
}

/// A robot of the oracle.
#[derive(Debug, Clone, Copy)]
struct Disc {
    radius_um: f64,
    stroke_um: f64,
    sign: f64,
}

impl Disc {
    /// Pose after strokes on its circle or straight on.
    fn gone(self, [x, y, heading]: [f64; 3], strokes: f64, is_down: bool) -> [f64; 3] {
        let way_um = strokes * self.stroke_um;
        if !is_down {
            return [x + way_um * heading.cos(), y + way_um * heading.sin(), heading];
        }
        let later = heading + self.sign * way_um / self.radius_um;
        let curve_um = self.sign * self.radius_um;
        [x + curve_um * (later.sin() - heading.sin()), y - curve_um * (later.cos() - heading.cos()), later]
    }
}

/// A bed whose states lower these sets of arms.
struct Coarse {
    discs: Vec<Disc>,
    starts: Vec<[f64; 3]>,
    states: Vec<Vec<bool>>,
    precision: Precision,
}

impl Coarse {
    /// Robots with strokes of about this length; every fourth bed has a table that is not STRING.
    fn random(random: &mut SplitMix64, count: usize, stroke_um: f64) -> Coarse {
        let disc = |random: &mut SplitMix64| Disc {
            radius_um: 80.0 + 100.0 * random.unit(),
            stroke_um: stroke_um * (0.8 + 0.4 * random.unit()),
            sign: if random.below(2) == 0 { 1.0 } else { -1.0 },
        };
        let mut states: Vec<Vec<bool>> =
            (0..=count).map(|down| (0..count).map(|robot| robot < down).collect()).collect();
        if random.below(4) == 0 {
            states.extend((0..2).map(|_| (0..count).map(|_| random.below(2) == 0).collect()));
        }
        Coarse {
            discs: (0..count).map(|_| disc(random)).collect(),
            starts: (0..count).map(|_| [500.0 * random.unit(), 500.0 * random.unit(), TAU * random.unit()]).collect(),
            states,
            precision: Precision { place_um: 0.05 * stroke_um * random.unit(), heading_rad: 0.1 * random.unit() },
        }
    }

    fn order(&self) -> MicrorobotsOrder {
        let robots = self.discs.iter().zip(&self.starts).map(|(disc, [x_um, y_um, heading_rad])| {
            let turning = if disc.sign > 0.0 { Turning::Counterclockwise } else { Turning::Clockwise };
            let facts = crate::device::microrobots::Robot { turning, ..robot("D", disc.radius_um, disc.stroke_um) };
            (facts, Pose { x_um: *x_um, y_um: *y_um, heading_rad: *heading_rad })
        });
        let mut order = bed(robots.collect(), Vec::new());
        let state = |downs: &Vec<bool>| crate::device::microrobots::ControlState {
            arms: downs.iter().map(|down| if *down { Arm::Down } else { Arm::Up }).collect(),
            levels_v: vec![9.0],
            slack_v: 1.0,
        };
        order.states = std::sync::Arc::new(self.states.iter().map(state).collect());
        order.precision = self.precision;
        order
    }

    fn stroke(&self, poses: &mut [[f64; 3]], arrived: &[bool], state: usize, strokes: f64) {
        for (robot, pose) in poses.iter_mut().enumerate().filter(|(robot, _)| !arrived[*robot]) {
            *pose = self.discs[robot].gone(*pose, strokes, self.states[state][robot]);
        }
    }

    /// Whether a state keeps the arms of robots that have arrived up.
    fn spares(&self, state: usize, arrived: &[bool]) -> bool {
        arrived.iter().zip(&self.states[state]).all(|(arrived, down)| !arrived || !down)
    }

    /// A goal that this pose meets within the precision.
    fn about(&self, random: &mut SplitMix64, [x, y, heading]: [f64; 3]) -> [f64; 3] {
        let (turn, off_um) = (TAU * random.unit(), self.precision.place_um * random.unit());
        [x + off_um * turn.cos(), y + off_um * turn.sin(), heading + self.precision.heading_rad * random.signed_unit()]
    }

    fn bound(&self, goals: &[[f64; 3]]) -> u64 {
        let order = self.order();
        let pose = |[x_um, y_um, heading_rad]: [f64; 3]| Pose { x_um, y_um, heading_rad };
        let arrival = |robot: usize| RobotArrival::of(&order, robot, pose(self.starts[robot]), pose(goals[robot]));
        least_strokes(&order, (0..goals.len()).map(arrival).collect())
    }

    /// Fewest strokes, at most `most`, of all sequences after which all robots have arrived.
    fn fewest(&self, goals: &[[f64; 3]], most: u64) -> u64 {
        let mut best = most;
        self.search(goals, &self.starts, &vec![false; goals.len()], 0, &mut best);
        best
    }

    /// Any of the robots that are at their goals may stay.
    fn search(&self, goals: &[[f64; 3]], poses: &[[f64; 3]], arrived: &[bool], strokes: u64, best: &mut u64) {
        let is_there = |robot: usize| !arrived[robot] && self.is_at(poses[robot], goals[robot]);
        let there: Vec<bool> = (0..goals.len()).map(is_there).collect();
        for set in 0..1_u32 << goals.len() {
            let stays = |robot: usize| set >> robot & 1 == 1;
            if (0..goals.len()).all(|robot| !stays(robot) || there[robot]) {
                let arrived: Vec<bool> = (0..goals.len()).map(|robot| arrived[robot] || stays(robot)).collect();
                self.strokes_on(goals, poses, &arrived, strokes, best);
            }
        }
    }

    fn strokes_on(&self, goals: &[[f64; 3]], poses: &[[f64; 3]], arrived: &[bool], strokes: u64, best: &mut u64) {
        if arrived.iter().all(|arrived| *arrived) {
            *best = strokes.min(*best);
            return;
        }
        // With one stroke more, the sequence would not beat the best.
        if strokes + 1 >= *best {
            return;
        }
        for state in (0..self.states.len()).filter(|state| self.spares(*state, arrived)) {
            let mut poses = poses.to_vec();
            self.stroke(&mut poses, arrived, state, 1.0);
            self.search(goals, &poses, arrived, strokes + 1, best);
        }
    }

    fn is_at(&self, [x, y, heading]: [f64; 3], goal: [f64; 3]) -> bool {
        let turned = (heading - goal[2]).rem_euclid(TAU);
        (x - goal[0]).hypot(y - goal[1]) <= self.precision.place_um
            && turned.min(TAU - turned) <= self.precision.heading_rad
    }
}

/// Outcome of random legs with arrivals: where every robot arrives, and the strokes until the last one does.
fn drawn(random: &mut SplitMix64, coarse: &Coarse, longest: usize) -> (Vec<[f64; 3]>, u64) {
    let count = coarse.discs.len();
    let (mut poses, mut arrived, mut strokes) = (coarse.starts.clone(), vec![false; count], 0);
    while arrived.contains(&false) {
        let states: Vec<usize> = (0..coarse.states.len()).filter(|state| coarse.spares(*state, &arrived)).collect();
        let leg = 1 + random.below(longest) as u64;
        coarse.stroke(&mut poses, &arrived, states[random.below(states.len())], leg as f64);
        strokes += leg;
        if random.below(2) == 0 {
            arrived[random.below(count)] = true;
        }
    }
    (poses, strokes)
}

#[test]
fn no_sequence_of_states_is_below_the_bound() {
    let mut random = SplitMix64::new(31);
    for _ in 0..cases(2_000) {
        let count = 2 + random.below(5);
        let coarse = Coarse::random(&mut random, count, 1.0);
        let (ends, strokes) = drawn(&mut random, &coarse, 400);
        let goals: Vec<[f64; 3]> = ends.into_iter().map(|end| coarse.about(&mut random, end)).collect();
        let bound = coarse.bound(&goals);
        assert!(bound <= strokes, "{bound} where {strokes} do: {:?} {:?}", coarse.discs, coarse.starts);
    }
}

/// All robots turn, then one after the other runs straight: no sequence takes fewer strokes, and the bound attains
/// that.
#[test]
fn the_bound_of_robots_that_turn_and_then_run_is_what_they_take() {
    let mut random = SplitMix64::new(32);
    for _ in 0..cases(500) {
        let count = 2 + random.below(5);
        let mut coarse = Coarse::random(&mut random, count, 1.0);
        coarse.precision = Precision { place_um: 1e-3, heading_rad: 1e-6 };
        let (mut poses, arrived, mut strokes) = (coarse.starts.clone(), vec![false; count], 0);
        for state in (0..=count).rev() {
            let leg = 1 + random.below(500 / count) as u64;
            coarse.stroke(&mut poses, &arrived, state, leg as f64);
            strokes += leg;
        }
        // Unless some robot has turned by a whole circle, none can do with less.
        let bound = coarse.bound(&poses);
        let least_um =
            coarse.discs.iter().map(|disc| TAU * disc.radius_um / disc.stroke_um).fold(f64::INFINITY, f64::min);
        assert!(bound <= strokes, "{bound} where {strokes} do");
        assert!(strokes as f64 > least_um || bound + 1 >= strokes, "{bound} of {strokes}");
    }
}

/// A robot that turns whenever another one does must make one more circle if it needs less of a turn.
#[test]
fn a_robot_that_needs_less_of_a_turn_goes_round_once_more() {
    let mut random = SplitMix64::new(33);
    let mut coarse = Coarse::random(&mut random, 2, 1.0);
    coarse.states.truncate(3);
    coarse.precision = Precision { place_um: 1e-3, heading_rad: 1e-6 };
    let turned = |robot: usize, turn_rad: f64| {
        let disc = coarse.discs[robot];
        disc.gone(coarse.starts[robot], turn_rad * disc.radius_um / disc.stroke_um, true)
    };
    let strokes =
        |robot: usize, turn_rad: f64| (turn_rad * coarse.discs[robot].radius_um / coarse.discs[robot].stroke_um) as u64;
    let bound = coarse.bound(&[turned(0, 1.0), turned(1, 3.0)]);
    assert!(bound.abs_diff(strokes(0, 1.0 + TAU)) <= 2, "{bound}");
    let bound = coarse.bound(&[turned(0, 3.0), turned(1, 0.5)]);
    assert!(bound.abs_diff(strokes(0, 3.0)) <= 2, "{bound}");
}

#[test]
fn no_sequence_of_single_strokes_on_a_coarse_bed_is_below_the_bound() {
    let mut random = SplitMix64::new(34);
    let (mut attained, mut joint, all) = (0, 0, cases(300));
    for _ in 0..all {
        let coarse = Coarse::random(&mut random, 2, 200.0);
        let (mut poses, arrived) = (coarse.starts.clone(), vec![false; 2]);
        let drawn = 3 + random.below(6) as u64;
        for _ in 0..drawn {
            coarse.stroke(&mut poses, &arrived, random.below(coarse.states.len()), 1.0);
        }
        let goals: Vec<[f64; 3]> = poses.iter().map(|pose| coarse.about(&mut random, *pose)).collect();
        let (bound, fewest) = (coarse.bound(&goals), coarse.fewest(&goals, drawn));
        assert!(bound <= fewest, "{bound} where {fewest} do: {:?} {:?} {goals:?}", coarse.discs, coarse.starts);
        attained += u64::from(bound == fewest);
        let alone = (0..2).map(|robot| alone(&coarse, robot, goals[robot])).max();
        joint += u64::from(alone.is_some_and(|alone| alone < bound));
    }
    println!("{attained} of {all} attained, {joint} above that of the slowest robot alone");
    assert!(10 * attained > all && 20 * joint > all, "{attained} and {joint} of {all}: too weak to say anything");
}

/// The bound of one robot alone.
fn alone(coarse: &Coarse, robot: usize, goal: [f64; 3]) -> u64 {
    let order = coarse.order();
    let pose = |[x_um, y_um, heading_rad]: [f64; 3]| Pose { x_um, y_um, heading_rad };
    least_strokes(&order, vec![RobotArrival::of(&order, robot, pose(coarse.starts[robot]), pose(goal))])
}
