//! Robots that dock into a structure.

use super::*;
use crate::claims::microrobots::Dock;
use crate::schedule::microrobots::MicrorobotsState;

fn docking(state: usize, strokes: u64, docks: &[usize]) -> Leg {
    Leg { docks: docks.to_vec(), ..leg(state, strokes) }
}

/// Two robots that meet head on and end with a gap between them.
fn head_on(gap_um: f64, docks: &[usize]) -> Day {
    let start = [(0, 0.0, 0.0, 0.0), (1, 840.0 + gap_um, 0.0, 180.0)];
    Day::new(order(&start)).assemble(&[0, 1], &[docking(0, 600, docks)])
}

fn judged(day: &Day) -> Vec<Rule> {
    let (schedule, claims) = day.both();
    rules(&schedule, &claims)
}

#[test]
fn bodies_that_touch_dock() {
    assert_eq!(judged(&head_on(4.999, &[0, 1])), []);
    assert_eq!(judged(&head_on(5.001, &[0, 1])), [Rule::State, Rule::Dock]);
    assert_eq!(judged(&head_on(5.001, &[])), [Rule::Meet, Rule::Dock]);
    assert_eq!(judged(&head_on(4.999, &[])), [Rule::State]);
    assert_eq!(judged(&head_on(10.001, &[])), [Rule::Dock]);
    assert_eq!(judged(&head_on(0.0, &[0, 1])), []);
    assert_eq!(judged(&head_on(-4.999, &[0, 1])), []);
    assert_eq!(judged(&head_on(-5.001, &[0, 1])), [Rule::Meet]);
}

#[test]
fn a_robot_docks_at_its_goal_only() {
    let off = |x_um: f64, docks: &[usize]| {
        let mut day = head_on(2.0, docks);
        let MicrorobotsAction::Assemble(list) = &mut day.order.steps[0].action else { panic!("an assembly") };
        list[0].goal.pose.x_um += x_um;
        judged(&day)
    };
    assert_eq!(off(0.499, &[0, 1]), []);
    assert_eq!(off(0.501, &[]), [Rule::Meet, Rule::Dock]);
    assert_eq!(off(0.501, &[0, 1]), [Rule::State, Rule::Dock]);
}

/// The exception applies to the last stretch only: both approach at one micrometre per micrometre of path.
#[test]
fn bodies_touch_on_the_last_stretch_only() {
    let stretch = |length_um, cycle_um| {
        let mut day = head_on(4.0, &[0, 1]);
        let facts = Arc::make_mut(&mut day.order.facts);
        (facts.fine.length_um, facts.fine.cycle_um) = (length_um, cycle_um);
        judged(&day)
    };
    assert_eq!(stretch(200.0, 20.0), []);
    assert_eq!(stretch(2.0, 1.001), []);
    assert_eq!(stretch(2.0, 0.999), [Rule::Meet]);
    assert_eq!(stretch(0.0, 0.0), [Rule::Meet]);
}

/// The last stretch may extend over several legs and several steps.
#[test]
fn the_last_stretch_goes_on_over_legs() {
    let start = [(0, 0.0, 0.0, 0.0), (1, 842.0, 0.0, 180.0)];
    let tail = |strokes| {
        let all = [leg(0, 600 - strokes), docking(0, strokes, &[0, 1])];
        judged(&Day::new(order(&start)).assemble(&[0, 1], &all))
    };
    assert_eq!(tail(2), []);
    assert_eq!(tail(20), []);
    let steps = Day::new(order(&start)).apply(0, 597).wait(5).assemble(&[0, 1], &[docking(0, 3, &[0, 1])]);
    assert_eq!(judged(&steps), []);
}

/// Two robots are docked and a third one comes from the side; then only the fourth moves, with all arms up.
fn structure(gap_um: f64) -> Day {
    let start = [(0, 0.0, 0.0, 0.0), (1, 842.0, 0.0, 180.0), (2, 300.0, 700.0 + gap_um, 270.0), (3, 0.0, 2000.0, 0.0)];
    Day::new(order(&start))
        .assemble(&[0, 1], &[docking(0, 600, &[0, 1])])
        .assemble(&[2], &[leg(0, 100), docking(0, 400, &[2])])
        .apply(0, 200)
}

#[test]
fn a_robot_docks_with_what_is_docked() {
    assert_eq!(judged(&structure(3.0)), []);
    assert_eq!(judged(&structure(4.999)), []);
    assert_eq!(judged(&structure(5.001)), [Rule::State, Rule::Dock]);
    assert_eq!(judged(&structure(-4.999)), []);
    assert_eq!(judged(&structure(-5.001)), [Rule::Meet]);
}

#[test]
fn what_is_docked_stays_so_in_the_next_run() {
    let first = structure(0.0);
    let robots: Vec<_> = first.order.robots.iter().map(|robot| (robot.row, robot.pose)).collect();
    let mut second = Day::new(first.order.clone());
    second.order.steps.clear();
    let second = second.apply(0, 300);
    let claims = in_turn(vec![first.order, second.order]);
    let sound = schedule(&claims, &[first.legs, second.legs]);
    passes(&sound, &claims);
    assert_eq!(robots.len(), 4);
    let State::Microrobots(MicrorobotsState { docked, .. }) = &sound.plans[1].states[1].state else {
        panic!("a bed's state")
    };
    assert_eq!(*docked, ["D1", "D2", "D3"]);
    let mut loose = sound;
    let State::Microrobots(MicrorobotsState { docked, .. }) = &mut loose.plans[1].states[0].state else {
        panic!("a bed's state")
    };
    docked.remove(1);
    only(Rule::Start, &loose, &claims);
}

/// Only steps that assemble dock robots: driving up to a body does not dock.
#[test]
fn only_an_assembly_docks() {
    let start = [(0, 0.0, 0.0, 0.0), (1, 842.0, 0.0, 180.0)];
    assert_eq!(judged(&Day::new(order(&start)).drive(0, &[(0, 600)])), [Rule::Meet]);
    let both_again = head_on(2.0, &[0, 1]).assemble(&[0, 1], &[]);
    assert_eq!(judged(&both_again), []);
    let mut elsewhere = both_again;
    let MicrorobotsAction::Assemble(docks) = &mut elsewhere.order.steps[1].action else { panic!("an assembly") };
    docks[1] = Dock { goal: stop(pose(0.0, 0.0, 0.0)), ..docks[1].clone() };
    assert_eq!(judged(&elsewhere), [Rule::Dock]);
}

/// A robot that reaches its goal one leg before the other one has nothing to dock with, and moves on.
#[test]
fn robots_dock_together_or_with_what_is_docked() {
    let start = [(0, 0.0, 0.0, 0.0), (1, 842.0, 0.0, 180.0)];
    let mut day = Day::new(order(&start)).assemble(&[0, 1], &[leg(0, 598), leg(0, 2)]);
    let MicrorobotsAction::Assemble(docks) = &mut day.order.steps[0].action else { panic!("an assembly") };
    docks[0].goal.pose.x_um -= 0.9;
    assert_eq!(judged(&day), [Rule::Meet, Rule::Dock]);
}

/// Docked robots are obstacles to orbits like any others.
#[test]
fn orbits_keep_clear_of_what_is_docked() {
    let reach = f64::hypot(130.0, 120.0);
    let by = |gap_um: f64| {
        // After 600 straight strokes, the first robot orbits below the two that have docked.
        let robots = [(0, 600.0, -100.0 - reach - 30.0 - gap_um, 180.0), (1, 0.0, 0.0, 0.0), (2, 842.0, 0.0, 180.0)];
        let day = Day::new(order(&robots)).assemble(&[1, 2], &[docking(0, 600, &[1, 2])]).apply(1, 1300);
        judged(&day)
    };
    assert_eq!(by(20.001), []);
    assert_eq!(by(19.999), [Rule::Orbit]);
}

/// A robot whose arm is down in the leg in which it docks is not docked yet; afterwards, states that lower the arms of
/// others are allowed.
#[test]
fn the_arms_of_docked_robots_are_up() {
    let after = |state: usize| {
        let robots = [(0, -3000.0, 3000.0, 0.0), (1, 0.0, 0.0, 0.0), (2, 842.0, 0.0, 180.0), (3, 6000.0, 0.0, 0.0)];
        let day = Day::new(order(&robots)).assemble(&[1, 2], &[docking(0, 600, &[1, 2])]);
        judged(&day.apply(state, 10))
    };
    assert_eq!(after(0), []);
    assert_eq!(after(1), []);
    assert_eq!(after(2), [Rule::Twist]);
    assert_eq!(after(3), [Rule::Twist]);
    assert_eq!(after(4), [Rule::Twist]);
}

/// The second robot turns into its seat with its arm down and docks; one more stroke in that state is one too many.
#[test]
fn an_arm_goes_up_when_its_robot_has_docked() {
    let reach = |more: &[(usize, u64)]| {
        let seat = pose(242.0, 0.0, 180.0);
        let facts = facts();
        let back = |arm, strokes: f64, from| carried(&facts.robots[1], arm, from, -0.5 * strokes);
        let before = back(crate::device::microrobots::Arm::Down, 40.0, seat);
        let start = [(1, before.x_um, before.y_um, before.heading_rad.to_degrees()), (2, -20.0, 0.0, 0.0)];
        let mut legs = vec![docking(2, 40, &[0, 1])];
        legs.extend(more.iter().map(|(state, strokes)| leg(*state, *strokes)));
        judged(&Day::new(order(&start)).assemble(&[0, 1], &legs))
    };
    assert_eq!(reach(&[]), []);
    assert_eq!(reach(&[(0, 1)]), []);
    assert_eq!(reach(&[(2, 1)]), [Rule::Twist]);
}
