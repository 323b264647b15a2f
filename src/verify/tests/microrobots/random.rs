//! Random trains of strokes compared with tiny steps of every robot, and random edits compared with every extreme of
//! the arms' transition voltages.

use super::*;
use crate::claims::microrobots::{MicrorobotsObstacle, MicrorobotsOrder};
use crate::device::microrobots::{Arm, Robot};
use crate::geometry::distance::{point_segment, quadrilateral_core, segment_core};
use crate::geometry::shape::Core;
use crate::geometry::{Rounded, Shape};
use crate::schedule::Actuation;
use crate::schedule::microrobots::MicrorobotsState;
use nalgebra::Point2;
use proptest::prelude::*;
use proptest::sample::Index;

/// Path between two samples, in strokes.
const SAMPLE: f64 = 0.2;

/// Error bound of the least sampled distance: bodies move at most 0.23 um from one sample to the next.
const SAMPLED_UM: f64 = 0.25;

/// Deviation that the verifier certainly detects.
const FOUND_UM: f64 = 2e-3;

/// Start poses of the robots of a scene, its obstacles, and the states in which they are driven, with numbers of
/// strokes.
type Draw = (Vec<(f64, f64, f64)>, Vec<(f64, f64, f64, u8)>, Vec<(usize, u64)>);

fn draw() -> impl Strategy<Value = Draw> {
    let robots = prop::collection::vec((0.0..1500.0f64, 0.0..1500.0f64, -180.0..180.0f64), 1..4);
    let obstacles = prop::collection::vec((-300.0..1800.0f64, -300.0..1800.0f64, 5.0..80.0f64, 0..4u8), 0..4);
    (robots, obstacles, prop::collection::vec((0..5usize, 1..900u64), 1..4))
}

fn body(x: f64, y: f64, size_um: f64, sort: u8) -> MicrorobotsObstacle {
    let shape = match sort {
        0 => Shape::Disc { radius_um: size_um },
        1 => Shape::Box { size_um: [size_um, 3.0 * size_um] },
        2 => Shape::Capsule { length_um: 2.0 * size_um, radius_um: size_um / 2.0 },
        _ => Shape::Polygon {
            points_um: [[0.0, 0.0], [2.0, 0.0], [0.5, 0.5], [0.0, 2.0]].map(|p| p.map(|v| v * size_um)).to_vec(),
        },
    };
    obstacle("dust", shape, pose(x, y, 10.0 * size_um))
}

/// A day with one `apply` step per leg.
fn strolled(robots: &[(f64, f64, f64)], obstacles: &[(f64, f64, f64, u8)], legs: &[(usize, u64)]) -> Day {
    let rows = [0, 1, 3];
    let robots: Vec<_> = robots.iter().zip(rows).map(|((x, y, deg), row)| (row, *x, *y, *deg)).collect();
    let mut order = order(&robots);
    order.obstacles = Arc::new(obstacles.iter().map(|(x, y, size, sort)| body(*x, *y, *size, *sort)).collect());
    legs.iter().fold(Day::new(order), |day, (state, strokes)| day.apply(*state, *strokes))
}

fn corners(robot: &Robot, pose: Pose) -> [Point2<f64>; 4] {
    let (length, width) = (robot.length_um / 2.0, robot.width_um / 2.0);
    [(length, width), (-length, width), (-length, -width), (length, -width)]
        .map(|(x, y)| pose.isometry() * Point2::new(x, y))
}

/// Least distances of a stroll: from a body to an obstacle, between two bodies, and from an orbit to anything.
#[derive(Debug)]
struct Least {
    obstacle_um: f64,
    pair_um: f64,
    orbit_um: f64,
}

/// Centre and radius of a disc.
type Disc = (Point2<f64>, f64);

/// The disc of each robot in each leg; `None` where it does not orbit.
fn discs(day: &Day) -> Vec<Vec<Option<Disc>>> {
    let (order, legs) = (&day.order, day.legs.concat());
    let mut discs = vec![vec![None; legs.len()]; order.robots.len()];
    for (index, placed) in order.robots.iter().enumerate() {
        let robot = order.robot(index);
        let is_down = |leg: &Leg| placed.row < leg.state;
        let (mut pose, mut first) = (placed.pose, 0);
        while first < legs.len() {
            let count = legs[first..].iter().take_while(|leg| is_down(leg)).count();
            let path_um: f64 = legs[first..first + count].iter().map(|leg| leg.strokes as f64 * robot.step_um).sum();
            if path_um / robot.turning_radius_um > TAU {
                // The centre is halfway to the pose after half a turn.
                let half = carried(robot, Arm::Down, pose, TAU / 2.0 * robot.turning_radius_um);
                let centre = Point2::new((pose.x_um + half.x_um) / 2.0, (pose.y_um + half.y_um) / 2.0);
                let reach = corners(robot, pose).iter().map(|corner| (corner - centre).norm()).fold(0.0, f64::max);
                discs[index][first..first + count].fill(Some((centre, reach)));
            }
            for leg in &legs[first..(first + count).max(first + 1)] {
                let arm = if is_down(leg) { Arm::Down } else { Arm::Up };
                pose = carried(robot, arm, pose, leg.strokes as f64 * robot.step_um);
            }
            first += count.max(1);
        }
    }
    discs
}

fn least(day: &Day) -> Least {
    let order = &day.order;
    let solids: Vec<Rounded> = order.obstacles.iter().map(|o| o.shape.grown(&o.pose, 0.0).expect("a shape")).collect();
    let discs = discs(day);
    let mut least = Least { obstacle_um: f64::INFINITY, pair_um: f64::INFINITY, orbit_um: f64::INFINITY };
    let mut poses: Vec<Pose> = order.robots.iter().map(|robot| robot.pose).collect();
    for (nth, leg) in day.legs.concat().iter().enumerate() {
        let samples = (leg.strokes as f64 / SAMPLE).round() as u64;
        for sample in 0..=samples {
            if sample > 0 {
                for (index, pose) in poses.iter_mut().enumerate() {
                    let arm = if order.robots[index].row < leg.state { Arm::Down } else { Arm::Up };
                    *pose = carried(order.robot(index), arm, *pose, SAMPLE * order.robot(index).step_um);
                }
            }
            let discs: Vec<_> = discs.iter().map(|legs| legs[nth]).collect();
            sampled(order, &solids, &poses, &discs, &mut least);
        }
    }
    least
}

fn sampled(
    order: &MicrorobotsOrder,
    solids: &[Rounded],
    poses: &[Pose],
    discs: &[Option<(Point2<f64>, f64)>],
    least: &mut Least,
) {
    let bodies: Vec<_> = poses.iter().enumerate().map(|(index, pose)| corners(order.robot(index), *pose)).collect();
    for (index, body) in bodies.iter().enumerate() {
        for solid in solids {
            let gap = quadrilateral_core(*body, &solid.core) - solid.radius_um;
            least.obstacle_um = least.obstacle_um.min(gap);
        }
        for other in &bodies[index + 1..] {
            least.pair_um = least.pair_um.min(quadrilateral_core(*body, &Core::Polygon(other.to_vec())));
        }
        let Some((centre, reach)) = discs[index] else { continue };
        let solid = solids.iter().map(|solid| segment_core([centre; 2], &solid.core) - solid.radius_um);
        let others = (0..bodies.len()).filter(|other| *other != index).map(|other| match discs[other] {
            Some((middle, reach)) => (middle - centre).norm() - reach,
            None => quadrilateral_core(bodies[other], &Core::Segment([centre; 2])),
        });
        least.orbit_um = solid.chain(others).map(|gap| gap - reach).fold(least.orbit_um, f64::min);
    }
}

/// The rules that a stroll breaks with these clearances of bodies and of orbits.
fn with_clearances(day: &Day, [body_um, orbit_um]: [f64; 2]) -> Vec<Rule> {
    let mut day = day.clone();
    let facts = Arc::make_mut(&mut day.order.facts);
    (facts.clearance_um, facts.orbit_clearance_um) = (body_um.max(0.0), orbit_um.max(0.0));
    let (schedule, claims) = day.both();
    rules(&schedule, &claims)
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 60, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn distances_are_those_of_tiny_steps((robots, obstacles, legs) in draw()) {
        let day = strolled(&robots, &obstacles, &legs);
        let Least { obstacle_um, pair_um, orbit_um } = least(&day);
        let found = |rule, clearances| with_clearances(&day, clearances).contains(&rule);
        let limits = [(Rule::Graze, obstacle_um, 0), (Rule::Meet, pair_um, 0), (Rule::Orbit, orbit_um, 1)];
        for (rule, least_um, which) in limits.into_iter().filter(|(_, least_um, _)| *least_um < 1e5) {
            let clearances = |um: f64| if which == 0 { [um, 0.0] } else { [0.0, um] };
            prop_assert!(found(rule, clearances(least_um + FOUND_UM)), "{rule:?} at {least_um}");
            if least_um > SAMPLED_UM {
                prop_assert!(!found(rule, clearances(least_um - SAMPLED_UM)), "{rule:?} at {least_um}");
            }
        }
    }
}

/// One mutation, of one actuation or of two.
#[derive(Debug, Clone)]
enum Mutation {
    Drop(Index),
    Double(Index),
    Swap(Index, Index),
    Shift(Index, i64),
    Stretch(Index, i64),
    Reassign(Index, Index),
    Steady(Index),
    Swing(Index, u64, [f64; 2]),
}

fn mutation() -> impl Strategy<Value = Mutation> {
    let index = any::<Index>;
    let (period, dwell) = (PERIOD as i64, DWELL as i64);
    let by_ns = move || prop_oneof![Just(1), Just(-1), Just(period), Just(-period), Just(dwell), -3 * dwell..3 * dwell];
    prop_oneof![
        index().prop_map(Mutation::Drop),
        index().prop_map(Mutation::Double),
        (index(), index()).prop_map(|(one, other)| Mutation::Swap(one, other)),
        (index(), by_ns()).prop_map(|(at, by_ns)| Mutation::Shift(at, by_ns)),
        (index(), by_ns()).prop_map(|(at, by_ns)| Mutation::Stretch(at, by_ns)),
        (index(), index()).prop_map(|(at, to)| Mutation::Reassign(at, to)),
        index().prop_map(Mutation::Steady),
        (index(), 1..4u64, prop_oneof![Just([100.0, 60.0]), Just([60.0, 100.0]), Just([100.0, 100.0])])
            .prop_map(|(at, part, levels)| Mutation::Swing(at, PERIOD / part, levels)),
    ]
}

fn mutate(schedule: &mut Schedule, mutation: &Mutation) {
    let steps = schedule.steps.len();
    let list = &mut schedule.actuations;
    match mutation {
        Mutation::Drop(at) => drop(list.remove(at.index(list.len()))),
        Mutation::Double(at) => list.push(*at.get(list)),
        Mutation::Swap(one, other) => {
            let (one, other) = (one.index(list.len()), other.index(list.len()));
            let level = |actuation: Actuation| (actuation.from, actuation.to, actuation.swing);
            let (first, second) = (level(list[one]), level(list[other]));
            (list[one].from, list[one].to, list[one].swing) = second;
            (list[other].from, list[other].to, list[other].swing) = first;
        }
        Mutation::Shift(at, by_ns) => {
            let actuation = at.get_mut(list);
            actuation.start_ns = actuation.start_ns.saturating_add_signed(*by_ns);
        }
        Mutation::Stretch(at, by_ns) => {
            let actuation = at.get_mut(list);
            actuation.duration_ns = actuation.duration_ns.saturating_add_signed(*by_ns);
        }
        Mutation::Reassign(at, to) => at.get_mut(list).step = to.index(steps) as u32,
        Mutation::Steady(at) => at.get_mut(list).swing = None,
        Mutation::Swing(at, period_ns, levels) => {
            let actuation = at.get_mut(list);
            (actuation.from, actuation.to) = (levels[0], levels[1]);
            actuation.swing = Some(Swing { period_ns: *period_ns, levels: *levels });
        }
    }
    list.sort_by_key(|actuation| (actuation.start_ns, actuation.channel));
}

/// A stroll of robots that are far from one another, with waits.
fn spread(legs: &[(usize, u64)]) -> (Schedule, Claims) {
    let start = order(&[(0, 0.0, 0.0, 90.0), (1, 9000.0, 0.0, 0.0), (3, 0.0, 9000.0, 45.0)]);
    let mut day = Day::new(start);
    for (at, (state, strokes)) in legs.iter().enumerate() {
        day = day.apply(*state, *strokes);
        day = if at % 2 == 1 { day.wait(3 * DWELL) } else { day };
    }
    day.both()
}

/// Whether the arms in each train are those of the record, at every extreme of every transition voltage.
fn is_certain(schedule: &Schedule, claims: &Claims) -> bool {
    let crate::claims::Order::Microrobots(order) = &claims.jobs[0].order else { panic!("an order of a bed") };
    let margin_v = order.facts.margin_v;
    let is_wait = |timed: &&crate::schedule::TimedState| {
        schedule.actuations.iter().any(|actuation| actuation.start_ns == timed.t_ns)
    };
    order.facts.robots.iter().enumerate().all(|(row, robot)| {
        let extremes = [-margin_v, margin_v].into_iter();
        extremes.clone().flat_map(|snap| extremes.clone().map(move |release| (snap, release))).all(|(snap, release)| {
            let after = |arm: u8, level_v: f64| match level_v {
                level_v if level_v >= robot.snap_down_v + snap => 1,
                level_v if level_v <= robot.release_v + release => 0,
                _ => arm,
            };
            [0, 1].into_iter().all(|first| {
                let (mut arm, mut end_ns) = (first, 0);
                let mut due = schedule.plans[0].states.iter().filter(is_wait);
                schedule.actuations.iter().all(|actuation| {
                    arm = if actuation.start_ns > end_ns { after(arm, 0.0) } else { arm };
                    end_ns = actuation.end_ns();
                    let Some(swing) = actuation.swing else {
                        arm = after(arm, actuation.from);
                        return true;
                    };
                    let Some(State::Microrobots(MicrorobotsState { arms, .. })) = due.next().map(|timed| &timed.state)
                    else {
                        return false;
                    };
                    swing.levels.iter().cycle().take(6).all(|level_v| after(arm, *level_v) == arm) && arm == arms[row]
                })
            })
        })
    })
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 3000, failure_persistence: None, ..ProptestConfig::default() })]

    /// A mutant passes only if its actuations are those of the original.
    #[test]
    fn a_mutant_is_refused_or_the_same(
        legs in prop::collection::vec((0..5usize, 1..40u64), 1..6),
        mutations in prop::collection::vec(mutation(), 5),
    ) {
        let (sound, claims) = spread(&legs);
        prop_assert_eq!(rules(&sound, &claims), vec![]);
        for mutation in &mutations {
            let mut mutant = sound.clone();
            mutate(&mut mutant, mutation);
            let refused = !rules(&mutant, &claims).is_empty();
            prop_assert_eq!(refused, mutant.actuations != sound.actuations, "{:?}", mutation);
        }
    }

    /// Another level passes exactly if it leaves all arms unchanged, at every extreme of the transition voltages.
    #[test]
    fn another_level_is_judged_as_every_extreme_is(
        legs in prop::collection::vec((0..5usize, 1..5u64), 1..5),
        at in any::<Index>(),
        level_v in prop_oneof![0.0..200.0f64, 100.0..150.0f64, 10.0..60.0f64],
    ) {
        let (mut schedule, claims) = spread(&legs);
        let levels: Vec<usize> = (0..schedule.actuations.len()).filter(|at| schedule.actuations[*at].swing.is_none()).collect();
        level(&mut schedule, *at.get(&levels), [level_v; 2]);
        prop_assert_eq!(rules(&schedule, &claims).is_empty(), is_certain(&schedule, &claims));
    }
}

#[test]
fn the_samples_know_a_circle() {
    let day = Day::new(order(&[(0, 0.0, 0.0, 90.0)])).apply(1, 1300);
    let (centre, reach) = discs(&day)[0][0].expect("an orbit");
    assert!((centre - Point2::new(100.0, 0.0)).norm() < 1e-6 && (reach - f64::hypot(130.0, 120.0)).abs() < 1e-6);
    assert_eq!(point_segment(centre, [centre; 2]), 0.0);
}
