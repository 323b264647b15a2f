//! Least distances of bodies and orbits, to a thousandth of a micrometre.

use super::*;
use crate::claims::microrobots::MicrorobotsObstacle;
use crate::geometry::Shape;

/// Offset of an obstacle that must be detected.
const FINE: f64 = 1e-3;

fn dust(x: f64, y: f64, radius_um: f64) -> MicrorobotsObstacle {
    obstacle("dust", Shape::Disc { radius_um }, pose(x, y, 0.0))
}

/// The rules that a day breaks with these obstacles.
fn among(day: &Day, obstacles: Vec<MicrorobotsObstacle>) -> Vec<Rule> {
    let mut day = day.clone();
    day.order.obstacles = Arc::new(obstacles);
    let (schedule, claims) = day.both();
    rules(&schedule, &claims)
}

/// Asserts that a day passes with something just farther away than needed, and breaks one rule with it just nearer.
#[track_caller]
fn tight(rule: Rule, rules_at: impl Fn(f64) -> Vec<Rule>) {
    assert_eq!(rules_at(FINE), []);
    assert_eq!(rules_at(1e-9), []);
    assert_eq!(rules_at(-FINE), [rule]);
}

#[test]
fn a_straight_way_keeps_clear_of_obstacles() {
    let day = Day::new(order(&[(0, 0.0, 0.0, 0.0)])).apply(0, 400);
    tight(Rule::Graze, |by| among(&day, vec![dust(335.0 + by, 0.0, 5.0)]));
    tight(Rule::Graze, |by| among(&day, vec![dust(100.0, 45.0 + by, 5.0)]));
    tight(Rule::Graze, |by| among(&day, vec![dust(-135.0 - by, 0.0, 5.0)]));
    tight(Rule::Graze, |by| among(&day, vec![dust(320.0 + 9.0 + by, 30.0 + 12.0 + by, 5.0)]));
    let wall = |y| obstacle("wall", Shape::Box { size_um: [2000.0, 10.0] }, pose(0.0, y, 0.0));
    tight(Rule::Graze, |by| among(&day, vec![wall(45.0 + by)]));
    assert_eq!(among(&day, vec![wall(0.0)]), [Rule::Graze]);
    let around = vec![[-900.0, -900.0], [900.0, -900.0], [900.0, 900.0], [-900.0, 900.0]];
    let lake = obstacle("lake", Shape::Polygon { points_um: around }, pose(0.0, 0.0, 0.0));
    assert_eq!(among(&day, vec![lake]), [Rule::Graze]);
}

#[test]
fn a_turn_keeps_clear_of_obstacles() {
    let reach = f64::hypot(130.0, 120.0);
    let day = Day::new(order(&[(0, 0.0, 0.0, 90.0)])).apply(1, 628);
    let ray = |deg: f64, from: f64, radius| {
        dust(100.0 + from * deg.to_radians().cos(), from * deg.to_radians().sin(), radius)
    };
    for deg in [130.0, 90.0, 47.0, 0.0] {
        tight(Rule::Graze, |by| among(&day, vec![ray(deg, reach + 15.0 + by, 5.0)]));
    }
    tight(Rule::Graze, |by| among(&day, vec![dust(100.0, 0.0, 60.0 - by)]));
    tight(Rule::Graze, |by| among(&day, vec![ray(77.0, 40.0, 20.0 - by)]));
    assert_eq!(among(&day, vec![ray(-90.0, reach + 14.0, 5.0)]), []);
}

/// D4 turns to the other side, on another circle.
#[test]
fn a_turn_to_the_left_is_one() {
    let day = Day::new(order(&[(3, 0.0, 0.0, 90.0)])).apply(4, 500);
    let reach = f64::hypot(180.0, 100.0);
    tight(Rule::Graze, |by| among(&day, vec![dust(-150.0, reach + 15.0 + by, 5.0)]));
    assert_eq!(among(&day, vec![dust(150.0, reach + 14.0, 5.0)]), []);
}

#[test]
fn what_rests_may_lie_near() {
    let day = Day::new(order(&[(0, 0.0, 0.0, 0.0), (1, 0.0, 61.0, 0.0)])).wait(1_000);
    assert_eq!(among(&day, vec![dust(0.0, -36.0, 5.0)]), []);
}

fn run(robots: &[(usize, f64, f64, f64)], state: usize, strokes: u64) -> Vec<Rule> {
    let (schedule, claims) = Day::new(order(robots)).apply(state, strokes).both();
    rules(&schedule, &claims)
}

#[test]
fn robots_keep_clear_of_each_other() {
    tight(Rule::Meet, |by| run(&[(0, 0.0, 0.0, 0.0), (1, 350.0 + by, 0.0, 180.0)], 0, 100));
    tight(Rule::Meet, |by| run(&[(0, 0.0, 0.0, 0.0), (1, 0.0, 70.0 + by, 0.0)], 0, 100));
    tight(Rule::Meet, |by| run(&[(0, 0.0, 0.0, 0.0), (1, 0.0, 70.0 + by, 180.0)], 0, 1000));
    // Both cross one point, one after the other: front corner against side.
    tight(Rule::Meet, |by| run(&[(0, -300.0, 0.0, 0.0), (1, 0.0, -300.0 - 160.0 - by, 90.0)], 0, 600));
    assert_eq!(run(&[(0, -300.0, 0.0, 0.0), (1, 0.0, -310.0, 90.0)], 0, 200), []);
    assert_eq!(run(&[(0, -300.0, 0.0, 0.0), (1, 0.0, -310.0, 90.0)], 0, 400), [Rule::Meet]);
}

/// The area swept by a robot alone differs from that swept relative to another one moving at the same time.
#[test]
fn ways_may_cross_one_after_the_other() {
    let crossing = |y| run(&[(0, -300.0, 0.0, 0.0), (1, 0.0, y, 90.0)], 0, 1600);
    assert_eq!(crossing(-300.0), [Rule::Meet]);
    assert_eq!(crossing(-700.0), []);
}

#[test]
fn a_turn_of_a_whole_circle_takes_the_disc() {
    let reach = f64::hypot(130.0, 120.0);
    let turn = |strokes| Day::new(order(&[(0, 0.0, 0.0, 90.0)])).apply(1, strokes);
    tight(Rule::Orbit, |by| among(&turn(1257), vec![dust(100.0, reach + 25.0 + by, 5.0)]));
    assert_eq!(among(&turn(1256), vec![dust(100.0, reach + 24.0, 5.0)]), []);
    tight(Rule::Graze, |by| among(&turn(1256), vec![dust(100.0, reach + 15.0 + by, 5.0)]));
    assert_eq!(among(&turn(1257), vec![dust(100.0, 0.0, 1.0)]), [Rule::Orbit]);
    assert_eq!(among(&turn(1256), vec![dust(100.0, 0.0, 1.0)]), []);
    assert_eq!(among(&turn(5000), vec![dust(100.0, reach + 14.0, 5.0)]), [Rule::Graze, Rule::Orbit]);
}

#[test]
fn an_orbit_goes_on_over_legs_and_steps_but_not_over_waits() {
    let near = || vec![dust(100.0, f64::hypot(130.0, 120.0) + 24.0, 5.0)];
    let start = || Day::new(order(&[(0, 0.0, 0.0, 90.0)]));
    assert_eq!(among(&start().drive(0, &[(1, 628), (2, 628)]), near()), []);
    assert_eq!(among(&start().drive(0, &[(1, 628), (2, 629)]), near()), [Rule::Orbit]);
    assert_eq!(among(&start().apply(1, 628).apply(4, 629), near()), [Rule::Orbit]);
    assert_eq!(among(&start().apply(1, 628).wait(1).apply(4, 629), near()), []);
    assert_eq!(among(&start().drive(0, &[(1, 628), (0, 1), (1, 629)]), near()), []);
}

#[test]
fn others_keep_clear_of_an_orbit() {
    let reach = f64::hypot(130.0, 120.0);
    let by_it = |y, strokes| run(&[(0, 0.0, 0.0, 90.0), (1, -250.0, y, 0.0)], 1, strokes);
    tight(Rule::Orbit, |by| by_it(reach + 50.0 + by, 1300));
    assert_eq!(by_it(reach + 49.0, 1250), []);
    let two = |apart, strokes| run(&[(0, 0.0, 0.0, 90.0), (1, apart, 0.0, 90.0)], 2, strokes);
    tight(Rule::Orbit, |by| two(2.0 * reach + 20.0 + by, 1300));
    assert_eq!(two(2.0 * reach + 19.0, 1250), []);
    // The other robot stops before it comes near, or is far past when the orbit begins.
    let later = |legs: &[(usize, u64)]| {
        let (schedule, claims) =
            Day::new(order(&[(0, 0.0, 0.0, 90.0), (1, -250.0, reach + 45.0, 0.0)])).drive(0, legs).both();
        rules(&schedule, &claims)
    };
    assert_eq!(later(&[(1, 900)]), []);
    assert_eq!(later(&[(1, 900), (0, 1), (1, 900)]), []);
    assert_eq!(later(&[(1, 900), (2, 500)]), [Rule::Orbit]);
}

/// Where there is room, a long path takes no more evaluations than a short one, nor does an endless orbit.
#[test]
fn long_ways_are_looked_at_quickly() {
    let far = |strokes| {
        let day = Day::new(order(&[(0, 0.0, 0.0, 90.0), (1, 1000.0, 0.0, 90.0), (3, 500.0, 400.0, 30.0)]));
        among(&day.apply(2, strokes), vec![dust(100.0, 250.0, 5.0), dust(1000.0, -300.0, 5.0)])
    };
    assert_eq!(far(1300), []);
    assert_eq!(far(1_000_000), []);
    assert_eq!(far(10_000_000_000), []);
}

/// Two robots that turn side by side reach the exact limit twice in each turn: after millions of turns no decision is
/// possible.
#[test]
fn what_takes_too_long_is_refused() {
    let turns = |strokes| {
        let mut day = Day::new(order(&[(0, 0.0, 0.0, 90.0), (1, f64::hypot(240.0, 60.0) + 10.000_1, 0.0, 90.0)]));
        Arc::make_mut(&mut day.order.facts).orbit_clearance_um = 0.0;
        let (schedule, claims) = day.apply(2, strokes).both();
        match verify(schedule, &claims) {
            Verdict::Rejected(found) => found[0].title.clone(),
            Verdict::Accepted(_) | Verdict::Inconclusive { .. } => String::new(),
        }
    };
    assert_eq!(turns(1250), "");
    assert_eq!(
        turns(4_000_000_000),
        "the clearance check ran out of its evaluation budget at 10 ms: bodies stay too close to their limits"
    );
}

#[test]
fn messages_name_bodies_distances_and_limits() {
    let reported = |day: &Day| {
        let (schedule, claims) = day.both();
        let Verdict::Rejected(found) = verify(schedule, &claims) else { panic!("a breach") };
        found[0].title.clone()
    };
    let mut day = Day::new(order(&[(0, 0.0, 0.0, 90.0), (1, 1000.0, 0.0, 90.0)])).apply(2, 1300);
    day.order.obstacles = Arc::new(vec![dust(100.0, 10.0, 1.0)]);
    let inside = reported(&day);
    assert_eq!(inside, "the orbit of `D1` overlaps `dust` by 167.918 um at 10 ms; at least 20 um is needed");
    let meeting = Day::new(order(&[(0, 0.0, 0.0, 0.0), (1, 0.0, 65.0, 0.0)])).apply(0, 10);
    let near = reported(&meeting);
    assert_eq!(near, "`D1` and `D2` come within 5 um of each other at 5.5 ms; at least 10 um is needed");
    let mut wall = Day::new(order(&[(0, 0.0, 0.0, 0.0)])).apply(0, 10);
    wall.order.obstacles = Arc::new(vec![dust(0.0, 39.0, 5.0)]);
    assert_eq!(reported(&wall), "`D1` comes within 4 um of `dust` at 5.5 ms; at least 10 um is needed");
}
