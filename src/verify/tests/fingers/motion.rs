//! Goals of steps, paths of free tips, and all clearances.

use super::*;
use nalgebra::{UnitQuaternion, Vector3};

/// The rules that the day breaks if a step has another action.
fn asked(nth: usize, action: FingersAction) -> Vec<Rule> {
    let (schedule, mut claims) = day().both();
    order_of(&mut claims, 0).steps[nth].action = action;
    rules(&schedule, &claims)
}

#[test]
fn steps_come_to_their_goals() {
    let step_rad = order().part.xy.step_rad;
    let rotate = |plane, angle_rad| FingersAction::Rotate { plane, steps: 3, angle_rad };
    assert_eq!(asked(0, FingersAction::Grasp(None)), []);
    assert_eq!(asked(0, FingersAction::Grasp(Some(vec![38, 1, 0]))), [Rule::Goal]);
    assert_eq!(asked(0, FingersAction::Grasp(Some(vec![1, 38, 28]))), [Rule::Goal]);
    assert_eq!(asked(1, rotate(Plane::Xy, 3.0 * step_rad + 0.0099)), []);
    assert_eq!(asked(1, rotate(Plane::Xy, 3.0 * step_rad - 0.0099)), []);
    assert_eq!(asked(1, rotate(Plane::Xy, 3.0 * step_rad + 0.0101)), [Rule::Goal]);
    assert_eq!(asked(1, rotate(Plane::Xy, 3.0 * step_rad - std::f64::consts::TAU)), [Rule::Goal]);
    assert_eq!(asked(1, rotate(Plane::Xz, 3.0 * step_rad)), [Rule::Goal]);
    assert_eq!(asked(1, FingersAction::Grasp(None)), [Rule::Goal]);
    assert_eq!(asked(2, FingersAction::Translate([5.04, -3.0, 2.0])), []);
    assert_eq!(asked(2, FingersAction::Translate([5.06, -3.0, 2.0])), [Rule::Goal]);
    assert_eq!(asked(2, FingersAction::Translate([5.0, -3.0, 2.06])), [Rule::Goal]);
    assert_eq!(asked(3, FingersAction::Wait(7 * MS + 1)), [Rule::Wait]);
    let early = Day::new(order())
        .step(FingersAction::Grasp(None))
        .come(0, 1)
        .come(1, 38)
        .record()
        .step(FingersAction::Release)
        .go(0);
    assert_eq!(broken(&early), [Rule::Goal]);
    let lonely = Day::new(order()).step(FingersAction::Grasp(None)).come(0, 1).record();
    assert_eq!(broken(&lonely), [Rule::Goal]);
}

/// A turn by 40 deg about z, then by -60 deg about the part's own y, with this goal.
fn oriented(goal: UnitQuaternion<f64>) -> Vec<Rule> {
    let mut order = order();
    let steps = [(Plane::Xy, 2), (Plane::Xz, -3)];
    order.precision_rad = 0.02;
    let q = goal.into_inner();
    let turns = vec![steps.map(|(plane, steps)| FingersTurn { plane, steps }).to_vec()];
    let day = Day::new(order)
        .step(FingersAction::Grasp(Some(vec![3, 40, 0])))
        .come(0, 3)
        .come(1, 40)
        .record()
        .step(FingersAction::Orient { goal: [q.w, q.i, q.j, q.k], turns, left_out_steps: None })
        .roll(2)
        .turn(Plane::Xz)
        .roll(-3);
    broken(&day)
}

#[test]
fn an_orientation_is_reached_by_turns_in_both_planes() {
    let step_rad = order().part.xy.step_rad;
    let about = |axis: [f64; 3], angle_rad: f64| UnitQuaternion::from_scaled_axis(Vector3::from(axis) * angle_rad);
    let (z, y) = ([0.0, 0.0, 1.0], [0.0, 1.0, 0.0]);
    let goal = about(z, 2.0 * step_rad) * about(y, -3.0 * step_rad);
    assert_eq!(oriented(goal), []);
    assert_eq!(oriented(about(z, 0.0199) * goal), []);
    assert_eq!(oriented(about(z, 0.0201) * goal), [Rule::Goal]);
    assert_eq!(oriented(about(y, -3.0 * step_rad) * about(z, 2.0 * step_rad)), [Rule::Goal]);
}

/// The plane of a turn follows from the motion of the tips, and a turn in the wrong plane is detected.
#[test]
fn a_turn_is_about_the_axis_that_is_asked_for() {
    let start = || Day::new(order()).step(FingersAction::Grasp(None)).come(0, 1).come(1, 38).record();
    assert_eq!(broken(&start().rotate(Plane::Xz, 2).roll(2)), []);
    let mut wrong = start().rotate(Plane::Xz, 2).roll(2);
    let angle_rad = 2.0 * wrong.order.part.xy.step_rad;
    wrong.order.steps[1].action = FingersAction::Rotate { plane: Plane::Xy, steps: 2, angle_rad };
    assert_eq!(broken(&wrong), [Rule::Goal]);
}

/// Finger 3 flies along a list of points, given relative to the part's origin.
fn past(places: &[[f64; 3]]) -> Vec<Rule> {
    let mut day = Day::new(order()).step(FingersAction::Grasp(None)).come(0, 1).come(1, 38).record();
    let origin_um = day.position_um;
    for place in places {
        day = day.fly(2, origin_um + Point::from(*place));
    }
    broken(&day)
}

#[test]
fn free_tips_keep_clear_of_the_part() {
    // In the plane: the semi-axis, the tip's radius and the clearance, less the tolerance.
    let (least, away) = (11.845 + 4.5 + 0.5 - 0.05, [0.0, -40.0, 0.0]);
    assert_eq!(past(&[away, [0.0, -least - 1e-4, 0.0], away]), []);
    assert_eq!(past(&[away, [0.0, -least + 1e-3, 0.0], away]), [Rule::Pierce]);
    assert_eq!(past(&[away, [0.0, -least + 1e-3, 0.0]]), [Rule::Pierce]);
    assert_eq!(past(&[away, [0.0, 40.0, 0.0]]), [Rule::Pierce]);
    // Elsewhere: a sphere round the part.
    let (least, above) = (16.0 + 4.5 + 0.5 - 0.05, [0.0, -20.0, 40.0]);
    let at = |height: f64| [0.6 * height, -0.3 * height, (1.0_f64 - 0.45).sqrt() * height];
    assert_eq!(past(&[above, at(least + 1e-4), above]), []);
    assert_eq!(past(&[above, at(least - 1e-3), above]), [Rule::Pierce]);
    // The other section is known, too.
    let least = 11.845 + 4.5 + 0.5 - 0.05;
    assert_eq!(past(&[[0.0, -40.0, 40.0], [0.0, 0.0, 40.0], [0.0, 0.0, least + 1e-4]]), []);
    assert_eq!(past(&[[0.0, -40.0, 40.0], [0.0, 0.0, 40.0], [0.0, 0.0, least - 1e-3]]), [Rule::Pierce]);
}

/// A tip may be near the part only where it approaches its contact or leaves it.
#[test]
fn tips_come_along_the_normal() {
    let grasped = |seats: &[(f64, f64)]| {
        let mut day = Day::new(order()).step(FingersAction::Grasp(None)).come(0, 1).come(1, 38).record();
        day = day.step(FingersAction::Grasp(None));
        let (rolled_rad, across) = (day.rolled_rad(57), Point::new(0.0, 0.0, 35.0));
        let over = [day.tips_um[2] + across, day.seat_um(rolled_rad, 30.0) + across];
        day = day.fly(2, over[0]).fly(2, over[1]);
        for (steps, out_um) in seats {
            let to_um = day.seat_um(rolled_rad + steps * day.order.part.xy.step_rad, *out_um);
            day = day.fly(2, to_um);
        }
        day.grasp[2] = 57;
        broken(&day.counted().record())
    };
    assert_eq!(grasped(&[(0.0, 30.0), (0.0, 0.0)]), []);
    assert_eq!(grasped(&[(0.0, 30.0), (3.0, 0.4), (0.0, 0.0)]), []);
    assert_eq!(grasped(&[(0.0, 30.0), (5.0, 0.4), (0.0, 0.0)]), [Rule::Pierce]);
    assert_eq!(grasped(&[(0.0, 30.0), (2.0, 0.4), (2.0, 3.0), (0.0, 0.0)]), [Rule::Pierce]);
    // Nor may it enter the part where it may be near.
    assert_eq!(grasped(&[(0.0, 30.0), (1.0, 0.4), (0.0, 0.0)]), []);
    assert_eq!(grasped(&[(0.0, 30.0), (1.0, -0.5), (0.0, 0.0)]), [Rule::Pierce]);
}

#[test]
fn tips_keep_clear_of_one_another() {
    let beside = |apart_um: f64| {
        let seat = [16.0 + 4.5 + apart_um, 0.0, 0.0];
        let above = [seat[0], 0.0, 40.0];
        past(&[[0.0, -40.0, 40.0], above, seat])
    };
    assert_eq!(beside(9.0 + 0.5 - 0.05 + 1e-4), []);
    assert_eq!(beside(9.0 + 0.5 - 0.05 - 1e-4), [Rule::Apart]);
    // Two tips that pass each other between two instants.
    let mut day = Day::new(order()).step(FingersAction::Grasp(None));
    for finger in [1, 2] {
        day = day.clone().fly(finger, day.tips_um[finger] + Point::new(0.0, 0.0, 40.0));
    }
    day.tips_um.swap(1, 2);
    day.line(100 * MS);
    assert_eq!(broken(&day), [Rule::Goal, Rule::Apart]);
}

/// Tips that rest too near one another from the first instant on, and never move.
#[test]
fn tips_stand_clear_of_one_another_at_first() {
    let standing = |apart_um: f64| {
        let mut day = Day::new(order());
        day.start_um[1] = day.start_um[0] + Point::new(apart_um, 0.0, 0.0);
        day.tips_um.clone_from(&day.start_um);
        broken(&day.step(FingersAction::Wait(7 * MS)).still(7 * MS))
    };
    assert_eq!(standing(9.0 + 0.5 - 0.05 + 1e-4), []);
    assert_eq!(standing(9.0 + 0.5 - 0.05 - 1e-4), [Rule::Apart]);
}

#[test]
fn stages_keep_their_ranges() {
    let (schedule, mut claims) = day().both();
    let most = |axis: u32| {
        let of_axis = schedule.actuations.iter().filter(|line| line.channel % 3 == axis);
        of_axis.flat_map(|line| [line.from.abs(), line.to.abs()]).fold(0.0, f64::max)
    };
    let range_um = [most(0), most(1), most(2)];
    Arc::make_mut(&mut order_of(&mut claims, 0).facts).range_um = range_um;
    passes(&schedule, &claims);
    for axis in 0..3 {
        let mut short = claims.clone();
        Arc::make_mut(&mut order_of(&mut short, 0).facts).range_um[axis] -= 1e-5;
        only(Rule::Range, &schedule, &short);
    }
}
