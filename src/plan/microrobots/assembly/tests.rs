//! Assemblies on made-up beds, with a direct simulation as their oracle.

use super::*;
use crate::check::claims::microrobots::{Assurance, Obstacle, Placed, Precision, Stop};
use crate::device::microrobots::{Arm, ControlState, Docking as Limits, Facts, Fine, Robot, Turning, wrapped_rad};
use crate::geometry::Shape;
use crate::plan::microrobots::world::World;
use std::f64::consts::{FRAC_PI_2, PI, TAU};
use std::sync::Arc;

const UP: Arm = Arm::Up;
const DOWN: Arm = Arm::Down;

/// A row of the table; robots differ a little in all their figures.
fn row(index: usize) -> Robot {
    Robot {
        name: format!("D{}", index + 1),
        snap_down_v: 90.0 + 16.0 * index as f64,
        release_v: 30.0 + 15.0 * index as f64,
        turning_radius_um: 160.0 + 5.0 * (index * 3 % 5) as f64,
        step_um: 0.0095 + 0.0002 * (index * 2 % 5) as f64,
        turning: Turning::Clockwise,
        length_um: 260.0,
        width_um: 60.0,
    }
}

fn facts(count: usize) -> Facts {
    Facts {
        robots: (0..count).map(row).collect(),
        margin_v: 5.0,
        max_v: 200.0,
        relax_v: 110.0,
        flex_v: 60.0,
        period_ns: 50_000,
        dwell_ns: 500_000,
        clearance_um: 10.0,
        orbit_clearance_um: 20.0,
        docking: Limits { self_aligning_rad: 1.0, self_aligning_um: 80.0, sticking_rad: PI / 4.0, tolerance_um: 2.0 },
        fine: Fine { length_um: 200.0, cycle_um: 10.0 },
        errors: None,
    }
}

fn state(arms: Vec<Arm>) -> ControlState {
    ControlState { arms, levels_v: vec![1.0, 2.0], slack_v: 1.0 }
}

/// The states of a STRING table: the arms that snap first are down.
fn string_states(count: usize) -> Vec<ControlState> {
    (0..=count).map(|downs| state((0..count).map(|row| if row < downs { DOWN } else { UP }).collect())).collect()
}

/// All patterns of arms.
fn all_states(count: usize) -> Vec<ControlState> {
    let arm = |pattern: usize, row: usize| if pattern >> row & 1 == 1 { DOWN } else { UP };
    (0..1 << count).map(|pattern| state((0..count).map(|row| arm(pattern, row)).collect())).collect()
}

fn pose(x_um: f64, y_um: f64, heading_deg: f64) -> Pose {
    Pose { x_um, y_um, heading_rad: heading_deg.to_radians() }
}

fn order(starts: &[Pose], states: Vec<ControlState>, obstacles: Vec<Obstacle>) -> MicrorobotsOrder {
    let placed = |(row, pose): (usize, &Pose)| Placed { row, pose: *pose, span: Default::default() };
    MicrorobotsOrder {
        facts: Arc::new(facts(starts.len())),
        states: Arc::new(states),
        obstacles: Arc::new(obstacles),
        robots: Arc::new(starts.iter().enumerate().map(placed).collect()),
        expansions: 100_000,
        precision: Precision { place_um: 0.5, heading_rad: 0.5_f64.to_radians() },
        assurance: Assurance::Told,
        steps: Vec::new(),
    }
}

fn dock(robot: usize, pose: Pose) -> Dock {
    Dock { robot, goal: Stop { pose, span: Default::default() } }
}

/// A structure of so many robots about a place: the last two head on, the others to their sides.
fn structure(count: usize, at: Pose) -> Vec<Dock> {
    let place = |x: f64, y: f64, turn_deg: f64| super::track::composed(at, pose(x, y, turn_deg));
    let seats = [
        (-130.0, 0.0, 0.0),
        (130.0, 0.0, 180.0),
        (-130.0, 160.0, -90.0),
        (130.0, -160.0, 90.0),
        (130.0, 160.0, -90.0),
        (-130.0, -160.0, 90.0),
    ];
    (0..count).map(|seat| dock(count - 1 - seat, place(seats[seat].0, seats[seat].1, seats[seat].2))).collect()
}

/// Carries legs out stroke for stroke but for its sums, and finds the docks by the rule of recognition.
fn simulated(order: &MicrorobotsOrder, starts: &[Pose], docked: &[bool], legs: &[Leg], docks: &[Dock]) -> (Vec<Pose>, Vec<Docking>) {
    let (mut poses, mut docked, mut found) = (starts.to_vec(), docked.to_vec(), Vec::new());
    let world = World::new(order);
    for (index, leg) in legs.iter().enumerate() {
        for robot in (0..poses.len()).filter(|robot| !docked[*robot]).collect::<Vec<_>>() {
            let facts = order.robot(robot);
            let arm = order.states[leg.state].arms[order.robots[robot].row];
            poses[robot] = facts.moved(poses[robot], arm, facts.step_um * leg.strokes as f64);
        }
        let near = |dock: &&Dock| {
            let (at, goal) = (poses[dock.robot], dock.goal.pose);
            !docked[dock.robot]
                && (at.x_um - goal.x_um).hypot(at.y_um - goal.y_um) <= order.precision.place_um
                && wrapped_rad(at.heading_rad - goal.heading_rad).abs() <= order.precision.heading_rad
        };
        let there: Vec<usize> = docks.iter().filter(near).map(|dock| dock.robot).collect();
        let touches = |robot: &usize| {
            let others = (0..poses.len()).filter(|other| other != robot && (docked[*other] || there.contains(other)));
            let gap_um = |other: usize| bodies_gap_um(&world, (*robot, poses[*robot]), (other, poses[other]));
            others.into_iter().any(|other| gap_um(other) <= order.facts.docking.tolerance_um)
        };
        for robot in there.iter().copied().filter(touches).collect::<Vec<_>>() {
            docked[robot] = true;
            found.push(Docking { robot, leg: index });
        }
    }
    (poses, found)
}

fn bodies_gap_um(world: &World, one: (usize, Pose), other: (usize, Pose)) -> f64 {
    let corners = |(robot, pose): (usize, Pose)| {
        let [a, b] = world.body(robot).half_um;
        let shape = Shape::Box { size_um: [2.0 * a, 2.0 * b] };
        shape.grown(&pose, 0.0).unwrap().core
    };
    let crate::geometry::Core::Polygon(outline) = corners(one) else { panic!("a box is a polygon") };
    crate::geometry::distance::quadrilateral_core([outline[0], outline[1], outline[2], outline[3]], &corners(other))
}

/// Plans, and holds the result against the simulation and the rules.
fn assembled(order: &MicrorobotsOrder, docks: &[Dock]) -> Result<Assembled, Stuck> {
    let starts: Vec<Pose> = order.robots.iter().map(|placed| placed.pose).collect();
    let docked = vec![false; starts.len()];
    let found = assemble(order, &starts, &docked, docks, Budget::of(order.expansions))?;
    check(order, &starts, &docked, docks, &found);
    Ok(found)
}

fn check(order: &MicrorobotsOrder, starts: &[Pose], docked: &[bool], docks: &[Dock], found: &Assembled) {
    let (ends, docking) = simulated(order, starts, docked, &found.legs, docks);
    let sorted = |docks: &[Docking]| {
        let mut docks: Vec<(usize, usize)> = docks.iter().map(|dock| (dock.leg, dock.robot)).collect();
        docks.sort_unstable();
        docks
    };
    assert_eq!(sorted(&docking), sorted(&found.docks));
    assert_eq!(docking.len(), docks.len());
    for dock in docks {
        let (at, goal) = (ends[dock.robot], dock.goal.pose);
        assert!((at.x_um - goal.x_um).hypot(at.y_um - goal.y_um) <= order.precision.place_um);
        assert!(wrapped_rad(at.heading_rad - goal.heading_rad).abs() <= order.precision.heading_rad);
    }
    assert_eq!(World::new(order).first_hit(starts, docked, &found.legs, &found.docks), None);
    assert!(found.legs.windows(2).all(|pair| pair[0].state != pair[1].state));
    assert!(found.legs.iter().all(|leg| leg.strokes >= 1));
    assert!(found.least_ns <= found.duration_ns);
}

/// Robots in a row, far enough apart to orbit.
fn in_a_row(count: usize) -> Vec<Pose> {
    (0..count).map(|index| pose(650.0 * index as f64, 0.0, 90.0 + 37.0 * index as f64)).collect()
}

#[test]
fn structures_of_two_to_five_robots_are_assembled() {
    for count in 2..=5 {
        let order = order(&in_a_row(count), string_states(count), Vec::new());
        let docks = structure(count, pose(1000.0, 1800.0, 20.0));
        let found = assembled(&order, &docks).unwrap_or_else(|stuck| panic!("{count} robots: {stuck:?}"));
        assert_eq!(found.stages.len(), count - 1);
        println!("{count}: {} legs {:.2} s, least {:.2} s", found.legs.len(), found.duration_ns as f64 / 1e9, found.least_ns as f64 / 1e9);
    }
}

/// A small generator of numbers from 0 to 1.
struct Dice(u64);

impl Dice {
    fn roll(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1_u64 << 53) as f64
    }
}

/// A disc in the scene.
fn disc(x_um: f64, y_um: f64, radius_um: f64) -> Obstacle {
    Obstacle { name: "disc".into(), shape: Shape::Disc { radius_um }, pose: pose(x_um, y_um, 0.0), span: Default::default() }
}

/// Places that keep apart from one another, on a bed of `side_um`.
fn scattered(dice: &mut Dice, count: usize, side_um: f64, apart_um: f64) -> Vec<Pose> {
    let mut found: Vec<Pose> = Vec::new();
    while found.len() < count {
        let next = pose(side_um * dice.roll(), side_um * dice.roll(), 360.0 * dice.roll());
        if found.iter().all(|other| (other.x_um - next.x_um).hypot(other.y_um - next.y_um) >= apart_um) {
            found.push(next);
        }
    }
    found
}

#[test]
fn explore() {
    let mut dice = Dice(7);
    let mut failed = std::collections::BTreeMap::new();
    for trial in 0..400 {
        let count = 2 + trial % 4;
        let obstacles = (trial / 4) % 5;
        let places = scattered(&mut dice, count + 1 + obstacles, 4500.0, 900.0);
        let starts = &places[..count];
        let docks = structure(count, places[count]);
        let blocks = places[count + 1..].iter().map(|p| disc(p.x_um, p.y_um, 60.0 + 100.0 * dice.roll())).collect();
        let order = order(starts, string_states(count), blocks);
        let begun = std::time::SystemTime::now();
        let found = assembled(&order, &docks);
        let took = begun.elapsed().unwrap().as_secs_f64();
        let what = match &found {
            Ok(found) => format!("ok {:.1} / {:.1}", found.duration_ns as f64 / 1e9, found.least_ns as f64 / 1e9),
            Err(stuck) => format!("{stuck:?}"),
        };
        if took > 0.1 || found.is_err() {
            println!("trial {trial} robots {count} obstacles {obstacles}: {took:.3} s {what}");
        }
        *failed.entry((count, found.is_ok())).or_insert(0) += 1;
        if let Ok(found) = &found { println!("T {trial} {:.2}", found.duration_ns as f64 / 1e9); }
    }
    println!("{failed:?}");
}
