//! Assemblies on synthetic beds, with a direct simulation as their oracle.

use super::track::{ArmTrack, TrackAim};
use super::*;
use crate::claims::fixture::bed_order;
use crate::claims::microrobots::{MicrorobotsObstacle, Precision};
use crate::device::microrobots::fixture::{self, pose};
use crate::device::microrobots::{Arm, ControlState, Docking as Limits, MicrorobotsFacts, Robot, Turning, wrapped_rad};
use crate::geometry::Shape;
use crate::plan::microrobots::world::CollisionWorld;
use crate::plan::microrobots::world::fixture::dock;
use crate::plan::search::SearchBudget;
use std::f64::consts::{FRAC_PI_2, PI, TAU};
use std::sync::Arc;

const UP: Arm = Arm::Up;
const DOWN: Arm = Arm::Down;

/// A row of the table; robots differ slightly in all their figures.
fn row(index: usize) -> Robot {
    Robot {
        snap_down_v: 90.0 + 16.0 * index as f64,
        release_v: 30.0 + 15.0 * index as f64,
        length_um: 260.0,
        ..fixture::robot(
            &format!("D{}", index + 1),
            160.0 + 5.0 * (index * 3 % 5) as f64,
            0.0095 + 0.0002 * (index * 2 % 5) as f64,
        )
    }
}

fn facts(count: usize) -> MicrorobotsFacts {
    MicrorobotsFacts {
        margin_v: 5.0,
        relax_v: 110.0,
        flex_v: 60.0,
        dwell_ns: 500_000,
        docking: Limits { self_aligning_rad: 1.0, self_aligning_um: 80.0, sticking_rad: PI / 4.0, tolerance_um: 2.0 },
        ..fixture::facts((0..count).map(row).collect())
    }
}

/// An assembly from rest.
fn assembled_from(
    order: &MicrorobotsOrder,
    poses: &[Pose],
    docked: &[bool],
    docks: &[Dock],
    steps: u64,
) -> Result<Assembled, StuckAssembly> {
    let terms = AssemblyTerms { fine: CYCLES, most_stages: MAX_PLANS };
    assemble(order, poses, docked, None, docks, &mut Meter::new(SearchBudget::of(steps)), terms)
}

fn state(arms: Vec<Arm>) -> ControlState {
    ControlState { arms, levels_v: vec![1.0, 2.0], slack_v: 1.0 }
}

/// The states of a STRING table: the arms that snap first are down.
fn string_states(count: usize) -> Vec<ControlState> {
    fixture::string_states(count, 1.0, |_| vec![1.0, 2.0])
}

/// All patterns of arms.
fn all_states(count: usize) -> Vec<ControlState> {
    let arm = |pattern: usize, row: usize| if pattern >> row & 1 == 1 { DOWN } else { UP };
    (0..1 << count).map(|pattern| state((0..count).map(|row| arm(pattern, row)).collect())).collect()
}

fn order(starts: &[Pose], states: Vec<ControlState>, obstacles: Vec<MicrorobotsObstacle>) -> MicrorobotsOrder {
    MicrorobotsOrder {
        obstacles: Arc::new(obstacles),
        expansions: 100_000,
        precision: Precision { place_um: 0.5, heading_rad: 0.5_f64.to_radians() },
        ..bed_order(facts(starts.len()), states, starts.iter().copied().enumerate())
    }
}

/// A structure of `count` robots about a place: the last two head on, the others to their sides.
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

/// Executes legs leg by leg in closed form, and finds the docks by the rule of recognition.
fn simulated(
    order: &MicrorobotsOrder,
    starts: &[Pose],
    docked: &[bool],
    legs: &[Leg],
    docks: &[Dock],
) -> (Vec<Pose>, Vec<RobotDocking>) {
    let (mut poses, mut docked, mut found) = (starts.to_vec(), docked.to_vec(), Vec::new());
    let world = CollisionWorld::new(order);
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
            found.push(RobotDocking { robot, leg: index });
        }
    }
    (poses, found)
}

fn bodies_gap_um(world: &CollisionWorld, one: (usize, Pose), other: (usize, Pose)) -> f64 {
    let corners = |(robot, pose): (usize, Pose)| {
        let [a, b] = world.body(robot).half_um;
        let shape = Shape::Box { size_um: [2.0 * a, 2.0 * b] };
        shape.grown(&pose, 0.0).unwrap().core
    };
    let crate::geometry::Core::Polygon(outline) = corners(one) else { panic!("a box is a polygon") };
    crate::geometry::distance::quadrilateral_core([outline[0], outline[1], outline[2], outline[3]], &corners(other))
}

/// Plans, and checks the result against the simulation and the rules.
fn assembled(order: &MicrorobotsOrder, docks: &[Dock]) -> Result<Assembled, StuckAssembly> {
    let starts: Vec<Pose> = order.robots.iter().map(|placed| placed.pose).collect();
    let docked = vec![false; starts.len()];
    let found = assembled_from(order, &starts, &docked, docks, order.expansions)?;
    check(order, &starts, &docked, docks, &found);
    Ok(found)
}

fn check(order: &MicrorobotsOrder, starts: &[Pose], docked: &[bool], docks: &[Dock], found: &Assembled) {
    let (ends, docking) = simulated(order, starts, docked, &found.legs, docks);
    let sorted = |docks: &[RobotDocking]| {
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
    for (index, leg) in found.legs.iter().enumerate() {
        let up = |robot: usize| order.states[leg.state].arms[order.robots[robot].row] == UP;
        let before = found.docks.iter().filter(|dock| dock.leg < index).map(|dock| dock.robot);
        assert!(before.chain((0..docked.len()).filter(|robot| docked[*robot])).all(up), "leg {index}");
    }
    assert_eq!(CollisionWorld::new(order).first_collision(starts, docked, &found.legs, &found.docks), None);
    assert!(found.legs.windows(2).all(|pair| pair[0].state != pair[1].state));
    assert!(found.legs.iter().all(|leg| leg.strokes >= 1));
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
        let docking = found.stages.iter().filter(|stage| !matches!(stage, AssemblyStage::Escort { .. }));
        assert_eq!(docking.count(), count - 1);
    }
}

/// Without fine motions a structure needs fewer legs, and the rules are still kept.
#[test]
fn structures_without_fine_motions_have_few_legs() {
    for count in 2..=4 {
        let (starts, docked) = (in_a_row(count), vec![false; count]);
        let mut order = order(&starts, string_states(count), Vec::new());
        let docks = structure(count, pose(1000.0, 1800.0, 20.0));
        let with = assembled(&order, &docks).unwrap();
        for objective in [MicrorobotsObjective::Time, MicrorobotsObjective::Switches] {
            order.objective = objective;
            let meter = &mut Meter::new(SearchBudget::of(order.expansions));
            let terms = AssemblyTerms { fine: DIRECT, most_stages: MAX_PLANS };
            let found = assemble(&order, &starts, &docked, None, &docks, meter, terms).unwrap();
            check(&order, &starts, &docked, &docks, &found);
            assert!(found.legs.len() <= 9 + 5 * (count - 2), "{count} robots: {} legs", found.legs.len());
            assert!(with.legs.len() > 60 + 40 * (count - 2));
        }
    }
}

/// Changes of an arm move to those of the other one that are near, and to no others.
#[test]
fn changes_of_arms_are_aligned() {
    let track = |pieces: &[(Arm, u64)]| ArmTrack { pieces: pieces.to_vec() };
    let (one, other) = (track(&[(DOWN, 103), (UP, 97), (DOWN, 50)]), track(&[(DOWN, 100), (UP, 150)]));
    assert_eq!(one.aligned(&other, 3), track(&[(DOWN, 100), (UP, 100), (DOWN, 50)]));
    assert_eq!(one.aligned(&other, 2), one);
    assert_eq!(other.aligned(&one, 3), track(&[(DOWN, 103), (UP, 147)]));
    // A piece between two changes that become one is gone.
    assert_eq!(track(&[(UP, 99), (DOWN, 2), (UP, 149)]).aligned(&other, 1), track(&[(UP, 250)]));
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
fn disc(x_um: f64, y_um: f64, radius_um: f64) -> MicrorobotsObstacle {
    MicrorobotsObstacle {
        name: "disc".into(),
        shape: Shape::Disc { radius_um },
        pose: pose(x_um, y_um, 0.0),
        span: Default::default(),
    }
}

/// Random places at a minimum distance, on a bed of `side_um`.
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

/// Failures among scattered beds, with obstacles or without.
#[test]
fn scattered_robots_are_assembled_among_obstacles() {
    let mut dice = Dice(7);
    for trial in 0..32 {
        let (count, obstacles) = (2 + trial % 4, trial / 4 % 5);
        let places = scattered(&mut dice, count + 1 + obstacles, 4500.0, 900.0);
        let blocks = places[count + 1..].iter().map(|p| disc(p.x_um, p.y_um, 60.0 + 100.0 * dice.roll())).collect();
        let order = order(&places[..count], string_states(count), blocks);
        let found = assembled(&order, &structure(count, places[count]));
        assert!(found.is_ok(), "trial {trial}: {found:?}");
    }
}

#[test]
fn the_same_assembly_comes_out_twice() {
    let order = order(&in_a_row(4), string_states(4), vec![disc(1000.0, 1000.0, 80.0)]);
    let docks = structure(4, pose(1000.0, 1800.0, 200.0));
    assert_eq!(assembled(&order, &docks), assembled(&order, &docks));
}

#[test]
fn robots_that_turn_the_other_way_are_assembled() {
    let mut order = order(&in_a_row(3), string_states(3), Vec::new());
    let mut facts = (*order.facts).clone();
    facts.robots[0].turning = Turning::Counterclockwise;
    facts.robots[2].turning = Turning::Counterclockwise;
    order.facts = Arc::new(facts);
    assembled(&order, &structure(3, pose(900.0, 1700.0, -50.0))).unwrap();
}

/// A robot without a goal orbits all the while, and keeps its place.
#[test]
fn a_robot_without_a_goal_orbits() {
    let starts = in_a_row(3);
    let order = order(&starts, string_states(3), Vec::new());
    let docks: Vec<Dock> =
        structure(2, pose(900.0, 1700.0, 10.0)).into_iter().map(|d| dock(d.robot + 1, d.goal.pose)).collect();
    let found = assembled(&order, &docks).unwrap();
    let down = |leg: &Leg| order.states[leg.state].arms[0] == DOWN;
    assert!(found.legs.iter().all(down));
}

/// Further robots dock one by one to a structure from an earlier task.
#[test]
fn a_structure_grows() {
    let mut starts = in_a_row(4);
    let docks = structure(4, pose(1000.0, 1800.0, 70.0));
    let (built, new) = docks.split_at(2);
    built.iter().for_each(|dock| starts[dock.robot] = dock.goal.pose);
    let order = order(&starts, string_states(4), Vec::new());
    let docked = [false, false, true, true];
    let found = assembled_from(&order, &starts, &docked, new, 100_000).unwrap();
    check(&order, &starts, &docked, new, &found);
    let robots: Vec<usize> = found.docks.iter().map(|dock| dock.robot).collect();
    assert_eq!(robots, [1, 0]);
}

/// The robot that snaps first docks last: once it is docked, its arm cannot stay up while another one's is down.
#[test]
fn what_has_docked_keeps_its_arm_up() {
    let mut starts = in_a_row(3);
    let docks = structure(3, pose(1000.0, 1800.0, 70.0));
    [&docks[0], &docks[2]].into_iter().for_each(|dock| starts[dock.robot] = dock.goal.pose);
    let docked = [true, false, true];
    let alone = |states: Vec<ControlState>| {
        let order = order(&starts, states, Vec::new());
        let found = assembled_from(&order, &starts, &docked, &docks[1..2], 100_000)?;
        check(&order, &starts, &docked, &docks[1..2], &found);
        Ok(found)
    };
    assert_eq!(alone(string_states(3)), Err(StuckAssembly::Unsteerable { robots: vec![1], orbiting: None }));
    assert!(alone(all_states(3)).is_ok());
}

#[test]
fn a_string_table_leaves_one_order() {
    let order = order(&in_a_row(3), string_states(3), Vec::new());
    let seats = structure(3, pose(900.0, 1700.0, 10.0));
    // Robot 0 in the first pair: robot 1 would need to orbit while robots 0 and 2 are steered.
    let swapped = [dock(2, seats[0].goal.pose), dock(0, seats[1].goal.pose), dock(1, seats[2].goal.pose)];
    let starts = in_a_row(3);
    let found = assembled_from(&order, &starts, &[false; 3], &swapped[..2], 100_000);
    assert_eq!(found, Err(StuckAssembly::Unsteerable { robots: vec![2, 0], orbiting: Some(1) }));
}

#[test]
fn other_tables_allow_other_orders() {
    let seats = structure(3, pose(900.0, 1700.0, 10.0));
    let swapped = [dock(2, seats[0].goal.pose), dock(0, seats[1].goal.pose), dock(1, seats[2].goal.pose)];
    let chain = [[UP, UP, UP], [UP, DOWN, UP], [DOWN, DOWN, UP], [DOWN, DOWN, DOWN]];
    let relabelled = order(&in_a_row(3), chain.map(|arms| state(arms.to_vec())).to_vec(), Vec::new());
    let found = assembled(&relabelled, &swapped).unwrap();
    assert_eq!(found.docks.iter().map(|dock| dock.robot).collect::<Vec<_>>(), [2, 0, 1]);
    // With all states there are more orders; a slower one is never kept.
    let free = order(&in_a_row(3), all_states(3), Vec::new());
    assert!(assembled(&free, &swapped).unwrap().cost <= found.cost);
}

#[test]
fn the_first_pair_needs_a_state_in_which_only_one_of_it_turns() {
    let order = order(&in_a_row(2), vec![state(vec![UP, UP]), state(vec![DOWN, DOWN])], Vec::new());
    let found = assembled(&order, &structure(2, pose(900.0, 1700.0, 10.0)));
    assert_eq!(found, Err(StuckAssembly::Unsteerable { robots: vec![1, 0], orbiting: None }));
}

#[test]
fn a_goal_in_an_orbit_is_told() {
    let starts = in_a_row(3);
    let order = order(&starts, string_states(3), Vec::new());
    let [x, y] = order.robot(0).orbit_centre_um(starts[0]);
    let reach_um = order.robot(0).orbit_reach_um() + order.facts.orbit_clearance_um;
    let pair = |gap_um: f64| structure(2, pose(x, y + reach_um + 30.0 + gap_um, 0.0));
    let docks = |gap_um: f64| -> Vec<Dock> { pair(gap_um).iter().map(|d| dock(d.robot + 1, d.goal.pose)).collect() };
    let found = assembled(&order, &docks(-200.0));
    let Err(StuckAssembly::GoalInOrbit { orbiting: 0, gap_um, .. }) = found else { panic!("{found:?}") };
    assert!(gap_um < order.facts.orbit_clearance_um);
    let near = assembled(&order, &docks(60.0));
    assert!(!matches!(near, Err(StuckAssembly::GoalInOrbit { .. })), "{near:?}");
}

#[test]
fn goals_apart_are_told() {
    let order = order(&in_a_row(2), string_states(2), Vec::new());
    let docks = [dock(1, pose(900.0, 1700.0, 0.0)), dock(0, pose(1300.0, 1700.0, 180.0))];
    assert_eq!(assembled(&order, &docks), Err(StuckAssembly::Apart { robot: 1 }));
}

#[test]
fn an_orbit_without_room_is_told() {
    let starts = in_a_row(3);
    let near = {
        let [x, y] = row(0).orbit_centre_um(starts[0]);
        disc(x, y, 20.0)
    };
    let order = order(&starts, string_states(3), vec![near]);
    let found = assembled(&order, &structure(3, pose(900.0, 1900.0, 10.0)));
    assert_eq!(found, Err(StuckAssembly::NoOrbit { robot: 0, blocker: RobotBlocker::Obstacle(0) }));
}

#[test]
fn a_walled_goal_is_told() {
    let wall = |turn: usize| {
        let (sin, cos) = (turn as f64 * FRAC_PI_2).sin_cos();
        let size_um = [10.0 + 1400.0 * sin.abs(), 10.0 + 1400.0 * cos.abs()];
        let at = pose(1000.0 + 700.0 * cos, 2000.0 + 700.0 * sin, 0.0);
        MicrorobotsObstacle { name: "wall".into(), shape: Shape::Box { size_um }, pose: at, span: Default::default() }
    };
    let order = order(&in_a_row(2), string_states(2), (0..4).map(wall).collect());
    let found = assembled(&order, &structure(2, pose(1000.0, 2000.0, 0.0)));
    let Err(StuckAssembly::NoPath { robot: 0, blocker: RobotBlocker::Obstacle(_) }) = found else {
        panic!("{found:?}")
    };
}

#[test]
fn a_spent_budget_is_told() {
    let mut order = order(&in_a_row(2), string_states(2), Vec::new());
    order.expansions = 0;
    assert_eq!(assembled(&order, &structure(2, pose(900.0, 1700.0, 10.0))), Err(StuckAssembly::GaveUp));
}

/// A path of a given length has that length, and ends at its goal.
#[test]
fn closings_close() {
    let (robot, mut dice) = (row(1), Dice(3));
    let mut found = 0;
    for _ in 0..300 {
        let mut any = || pose(3000.0 * dice.roll(), 3000.0 * dice.roll(), 360.0 * dice.roll());
        let (from, to) = (any(), any());
        let asked = super::closing::ClosingRequest {
            from,
            to,
            length_um: 9000.0 * dice.roll(),
            least_last_um: 800.0 * dice.roll(),
            circles: [true; super::closing::CIRCLES],
        };
        for way in super::closing::closings(&robot, &asked) {
            let end = way.iter().fold(from, |pose, piece| robot.moved(pose, piece.arm, piece.way_um));
            let length_um: f64 = way.iter().map(|piece| piece.way_um).sum();
            assert!((end.x_um - to.x_um).hypot(end.y_um - to.y_um) < 1e-6, "{way:?}");
            assert!(wrapped_rad(end.heading_rad - to.heading_rad).abs() < 1e-9);
            assert!((length_um - asked.length_um).abs() < 1e-6);
            assert!(way[4].way_um >= asked.least_last_um && way.iter().all(|piece| piece.way_um >= 0.0));
            found += 1;
        }
    }
    assert!(found > 1000, "only {found} ways");
}

/// A turn is refused exactly if no number of whole strokes makes it within the precision of the heading: all numbers of
/// strokes up to an eighth of a turn more are tried.
#[test]
fn turns_are_those_that_whole_strokes_make() {
    let (robot, mut dice) = (row(1), Dice(7));
    let stroke_rad = robot.step_um / robot.turning_radius_um;
    let mut counted = [0; 2];
    for _ in 0..60 {
        let turn_rad = 6.0 * (dice.roll() + 1.0);
        let precision = Precision { place_um: 1.0, heading_rad: stroke_rad * (0.05 + 0.4 * dice.roll().abs()) };
        let aim = TrackAim { goal: Pose::at(0.0, 0.0), precision, motion: Pose::at(0.0, 0.0) };
        let most = ((turn_rad + TAU / 8.0) / stroke_rad) as u64;
        let is_made = (0..most).any(|strokes| (strokes as f64 * stroke_rad - turn_rad).abs() <= precision.heading_rad);
        assert_eq!(aim.allows_turn(&robot, turn_rad * robot.turning_radius_um), is_made, "{turn_rad} rad");
        counted[usize::from(is_made)] += 1;
    }
    assert!(counted.iter().all(|count| *count > 5), "{counted:?}");
}
