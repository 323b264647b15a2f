//! Grasps that hold, and fingers that may come and leave.

use super::*;
use crate::claims::fingers::{HandPart, Section};
use crate::schedule::electrode_array::ElectrodeArrayState;
use crate::verify::fingers::forces;

/// A round bead of 72 contacts, so that every quarter turn is a contact, for a hand with edited facts.
fn round(edit: impl FnOnce(&mut FingersFacts)) -> FingersOrder {
    let mut order = with_facts(edit);
    let section = section([13.5, 13.5]);
    assert_eq!(section.contacts, 72);
    let part = Arc::make_mut(&mut order.part);
    *part = HandPart { xy: section.clone(), xz: Some(section), ..part.clone() };
    order
}

fn held(order: FingersOrder, contacts: &[u32]) -> Day {
    let mut day = Day::new(order).step(FingersAction::Grasp(None));
    for (finger, contact) in contacts.iter().enumerate().filter(|(_, contact)| **contact > 0) {
        day = day.come(finger, *contact);
    }
    day.record()
}

#[test]
fn fingers_come_where_contacts_are() {
    let beside = |off_um: f64| {
        let day = held(order(), &[1, 38, 0]).step(FingersAction::Grasp(None));
        broken(&day.come_off(2, 28, off_um).counted().record())
    };
    assert_eq!(beside(0.0), []);
    assert_eq!(beside(0.049), []);
    assert_eq!(beside(-0.049), []);
    assert_eq!(beside(0.051), [Rule::Contact]);
    assert_eq!(beside(-0.051), [Rule::Contact]);
    let halfway = |share: f64| {
        let mut order = order();
        order.precision_rad = 1.0;
        let mut day = held(order, &[1, 38, 0]).rotate(Plane::Xy, 1);
        let start = day.clone();
        day.turned(&start, share);
        broken(&day.come(2, 28).counted())
    };
    assert_eq!(halfway(1e-4), [Rule::State]);
    assert_eq!(halfway(0.04), [Rule::State, Rule::Contact]);
    assert_eq!(halfway(0.5), [Rule::State, Rule::Contact]);
}

#[test]
fn no_more_than_three_fingers_hold() {
    let four = |contacts: &[u32]| broken(&held(with_facts(|facts| facts.fingers = 4), contacts));
    assert_eq!(four(&[1, 20, 38, 0]), []);
    assert_eq!(four(&[1, 20, 38, 57]), [Rule::Contact]);
}

/// One of three tips moves along a round part that the other two hold.
#[test]
fn tips_roll() {
    let slid = |by_um: f64| {
        let mut order = round(|_| ());
        order.precision_rad = 1.0;
        let mut day = held(order, &[1, 25, 49]).rotate(Plane::Xy, 0);
        day.tips_um[2] = day.seat_um(day.rolled_rad(49) + by_um / 4.5, 0.0);
        day.line(100 * MS);
        broken(&day)
    };
    assert_eq!(slid(0.07), []);
    assert_eq!(slid(0.2), [Rule::Slip]);
    assert_eq!(slid(-0.2), [Rule::Slip]);
}

#[test]
fn two_fingers_stay_where_one_leaves() {
    let left =
        |contacts: &[u32]| broken(&held(order(), contacts).step(FingersAction::Grasp(None)).go(1).counted().record());
    assert_eq!(left(&[1, 38, 30]), []);
    assert_eq!(left(&[1, 38, 0]), [Rule::Contact]);
}

/// Two contacts of a circle hold if both normals are within the friction cone about their chord.
#[test]
fn tips_that_only_push_stand_opposite_each_other() {
    let pushed = |friction: f64, contacts: &[u32]| {
        broken(&held(round(|facts| (facts.adhesion, facts.friction) = (Adhesion::Absent, friction)), contacts))
    };
    // Half of three contact steps of 5 deg, the offset from the opposite contact.
    let limit = 7.5_f64.to_radians().tan();
    assert_eq!(pushed(0.01, &[1, 37, 0]), []);
    assert_eq!(pushed(limit, &[1, 34, 0]), []);
    assert_eq!(pushed(limit * (1.0 - 1e-4), &[1, 34, 0]), [Rule::Equilibrium]);
    assert_eq!(pushed(0.3, &[1, 19, 0]), [Rule::Equilibrium]);
    assert_eq!(pushed(0.3, &[1, 25, 49]), []);
    assert_eq!(pushed(0.3, &[1, 10, 19]), [Rule::Equilibrium]);
}

/// Two tips below a part support it as a table would; they hold it only if they also hold it without its weight.
#[test]
fn a_part_that_rests_on_tips_is_not_held() {
    let rests = |load_un: [f64; 3], contacts: &[u32]| {
        let mut order = round(|facts| (facts.adhesion, facts.friction) = (Adhesion::Absent, 0.3));
        order.load_un = load_un;
        broken(&held(order, contacts))
    };
    assert_eq!(rests([5.0, 5.0, 0.0], &[1, 19, 0]), [Rule::Equilibrium]);
    assert_eq!(rests([5.0, 5.0, 0.0], &[1, 37, 0]), []);
}

/// Two tips press with their greatest force, and friction bears a load along the tangents, in the plane or across it.
#[test]
fn loads_are_borne_by_friction() {
    let loaded = |load_un: [f64; 3], sticking: Adhesion| {
        let mut order = round(|facts| facts.adhesion = sticking);
        order.load_un = load_un;
        broken(&held(order, &[1, 37, 0]))
    };
    let (sticks, most) = (Adhesion::Sticking, 2.0 * 0.3 * 31.5);
    assert_eq!(loaded([0.0, most, 0.0], sticks), []);
    assert_eq!(loaded([0.0, most + 1e-3, 0.0], sticks), [Rule::Equilibrium]);
    assert_eq!(loaded([0.0, 0.0, -most], sticks), []);
    assert_eq!(loaded([0.0, 0.0, -most - 1e-3], sticks), [Rule::Equilibrium]);
    // Along the normals one tip pushes and the other one pulls.
    assert_eq!(loaded([31.5, 0.0, 0.0], sticks), []);
    assert_eq!(loaded([31.501, 0.0, 0.0], sticks), [Rule::Equilibrium]);
    let most = 2.0 * 0.3 * 30.0;
    assert_eq!(loaded([0.0, most, 0.0], Adhesion::Absent), []);
    assert_eq!(loaded([0.0, most + 1e-3, 0.0], Adhesion::Absent), [Rule::Equilibrium]);
}

/// A load beside the line between two tips turns the part about that line: two tips bear it by torsion, a third one by
/// its lever.
#[test]
fn torques_balance_in_space() {
    let beside = |torsion_um: f64, contacts: &[u32]| {
        let mut order = round(|facts| facts.torsion_um = torsion_um);
        order.load_un = [0.0, 0.0, -1.0];
        Arc::make_mut(&mut order.part).centre_um = [0.0, 3.0, 0.0];
        broken(&held(order, contacts))
    };
    // 3 uN um of torque, against 2 x 31.5 uN x torsion.
    assert_eq!(beside(0.0, &[1, 37, 0]), [Rule::Equilibrium]);
    assert_eq!(beside(0.045, &[1, 37, 0]), [Rule::Equilibrium]);
    assert_eq!(beside(0.048, &[1, 37, 0]), []);
    assert_eq!(beside(0.0, &[1, 37, 19]), []);
}

/// The load turns relative to the part as the part rolls, so a grasp that holds at first need not keep holding.
#[test]
fn equilibrium_is_asked_while_tips_roll() {
    let mut order = round(|facts| (facts.adhesion, facts.friction) = (Adhesion::Absent, 0.1));
    order.load_un = [0.0, -5.9, 0.0];
    order.part = {
        let mut part = order.part.as_ref().clone();
        part.centre_um = [0.0, 6.0, 0.0];
        Arc::new(part)
    };
    assert_eq!(broken(&held(order.clone(), &[1, 37, 0])), []);
    let rolled = held(order, &[1, 37, 0]).rotate(Plane::Xy, 2).roll(2);
    assert_eq!(broken(&rolled), [Rule::Equilibrium]);
}

/// The two fingers that stay, at both ends of the x axis, bear the pull along y by friction alone.
#[test]
fn those_that_stay_resist_the_one_that_leaves() {
    let left = |removal_safety: f64| {
        let order = round(|facts| facts.removal_safety = removal_safety);
        broken(&held(order, &[1, 19, 37]).step(FingersAction::Grasp(None)).go(1).counted().record())
    };
    let most = 2.0 * 0.3 * 31.5 / 1.5;
    assert_eq!(left(0.0), []);
    assert_eq!(left(most), []);
    assert_eq!(left(most + 1e-3), [Rule::Removal]);
    let order = round(|facts| (facts.adhesion, facts.removal_safety) = (Adhesion::Absent, 100.0));
    assert_eq!(broken(&held(order, &[1, 19, 37]).step(FingersAction::Grasp(None)).go(1).counted().record()), []);
}

#[test]
fn what_a_part_rests_on_holds_it_in_the_end() {
    let released = |support_un: f64, adhesion: Adhesion| {
        let order = with_facts(|facts| (facts.support_un, facts.adhesion) = (support_un, adhesion));
        broken(&held(order, &[1, 38, 0]).step(FingersAction::Release).go(0).go(1).record())
    };
    assert_eq!(released(1.5, Adhesion::Sticking), []);
    assert_eq!(released(1.499, Adhesion::Sticking), [Rule::Support]);
    assert_eq!(released(0.0, Adhesion::Absent), []);
}

/// The reported forces of a grasp balance and lie within the friction cones.
#[test]
fn shown_forces_balance() {
    for (contacts, load_un) in [(vec![1, 38, 0], [0.0; 3]), (vec![5, 30, 60], [1.0, -2.0, 0.5])] {
        let mut order = order();
        order.load_un = load_un;
        let day = held(order.clone(), &contacts);
        let forces = forces(&order, &day.state()).expect("a grasp that holds");
        let sum = forces.iter().flatten().fold(Point::from(load_un), |sum, force| sum + Point::from(*force));
        assert!(sum.norm() < 1e-5, "{sum}");
        let mut pressed_un = 0.0;
        for (finger, force) in forces.iter().enumerate() {
            assert_eq!(force.is_some(), contacts[finger] > 0);
            let Some(force) = force else { continue };
            let inward =
                day.seat_um(day.rolled_rad(contacts[finger]), 0.0) - day.seat_um(day.rolled_rad(contacts[finger]), 1.0);
            let (force, normal) = (Point::from(*force), inward.normalize());
            let along = (force - normal * force.dot(&normal)).norm();
            assert!(along <= 0.3 * (force.dot(&normal) + 1.5) + 1e-6);
            pressed_un += force.dot(&normal);
        }
        let holding = contacts.iter().filter(|contact| **contact > 0).count() as f64;
        assert!((pressed_un - 3.0 * holding).abs() < 1e-5, "{pressed_un}");
    }
    let order = order();
    assert_eq!(forces(&order, &held(order.clone(), &[1, 38, 0]).state()).map(|forces| forces.len()), Some(3));
    // No forces balance a load that two tips cannot bear.
    let mut loaded = order.clone();
    loaded.load_un = [0.0, 40.0, 0.0];
    assert_eq!(forces(&loaded, &held(order, &[1, 38, 0]).state()), None);
    let other = State::ElectrodeArray(ElectrodeArrayState { parts: Default::default() });
    assert_eq!(forces(&loaded, &other), None);
}

/// A peanut: a tip in one of its dents must not touch the lobes.
fn peanut(waist_um: f64) -> Section {
    let point = |at: usize| {
        let (y, x) = (std::f64::consts::TAU * at as f64 / 32.0).sin_cos();
        let radius_um = waist_um + (20.0 - waist_um) * x * x;
        [radius_um * x, radius_um * y]
    };
    with_contacts(crate::geometry::outline::Outline::Spline { points_um: (0..32).map(point).collect() })
}

#[test]
fn concave_parts_are_rolled() {
    let mut order = order();
    let section = peanut(12.0);
    let half = section.opposite.expect("a contact");
    let part = Arc::make_mut(&mut order.part);
    *part = HandPart { xy: section, xz: None, ..part.clone() };
    let day = held(order, &[1, half, 0]).rotate(Plane::Xy, -3).roll(-3);
    let (schedule, claims) = day.both();
    passes(&schedule, &claims);
}

/// A tip in the waist of a slender peanut would also be in its lobes.
#[test]
fn tips_that_hold_touch_in_one_place_only() {
    let grasped = |waist_um: f64| {
        let mut order = order();
        order.part = {
            let mut part = order.part.as_ref().clone();
            (part.xy, part.xz) = (peanut(waist_um), None);
            Arc::new(part)
        };
        let contacts = order.part.xy.contacts;
        let day = held(order, &[1, 1 + contacts / 4, 0]);
        let (schedule, claims) = day.both();
        match verify(schedule, &claims) {
            Verdict::Rejected(found) => found.into_iter().map(|violation| violation.rule).collect(),
            Verdict::Accepted(_) => Vec::new(),
            Verdict::Inconclusive { why } => panic!("{why}"),
        }
    };
    assert_eq!(grasped(12.0), []);
    assert!(grasped(4.0).contains(&Rule::Pierce), "{:?}", grasped(4.0));
}
