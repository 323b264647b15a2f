//! The closed form of rolling compared with an integration of the no-slip condition alone, and chords compared with the closed
//! form.

use super::*;
use crate::plan::fingers::tip_motion::rolling::{chords, tip};

/// A tip's centre after the part has turned by an angle, by integration: the tip moves like the material of the part at the
/// contact, and the contact is the nearest point of the outline.
fn integrated(curve: &Curve, mut centre: Vector2<f64>, turn_rad: f64) -> Vector2<f64> {
    const STEPS: u32 = 400;
    let velocity = |centre: Vector2<f64>, angle_rad: f64| {
        let turned = |v: Vector2<f64>, by: f64| nalgebra::Rotation2::new(by) * v;
        let own = turned(centre, -angle_rad);
        let way_um = curve.nearest([own.x, own.y]).way_um;
        let contact = turned(Vector2::from(curve.point_at(way_um).point_um), angle_rad);
        Vector2::new(-contact.y, contact.x)
    };
    let h = turn_rad / f64::from(STEPS);
    for step in 0..STEPS {
        let at = h * f64::from(step);
        let first = velocity(centre, at);
        let second = velocity(centre + first * (h / 2.0), at + h / 2.0);
        let third = velocity(centre + second * (h / 2.0), at + h / 2.0);
        let fourth = velocity(centre + third * h, at + h);
        centre += (first + (second + third) * 2.0 + fourth) * (h / 6.0);
    }
    centre
}

#[test]
fn tips_follow_the_rolling_constraint() {
    for bench in benches(3) {
        let (curve, facts) = (&bench.curve, &bench.facts);
        for (contact, steps) in [(0, 5), (7, 11), (11, -4), (19, 3), (30, -9), (44, 2), (60, 7)] {
            let rolled_rad = f64::from(contact) * bench.section.step_rad;
            let turn_rad = f64::from(steps) * bench.section.step_rad;
            let (centre, _) = tip(curve, facts, rolled_rad);
            let by_force = integrated(curve, centre, turn_rad);
            let (there, _) = tip(curve, facts, rolled_rad - turn_rad);
            let there = nalgebra::Rotation2::new(turn_rad) * there;
            assert!((by_force - there).norm() < 1e-4, "contact {contact} by {steps}: {}", (by_force - there).norm());
        }
    }
}

#[test]
fn contacts_come_round() {
    for bench in benches(3) {
        let round_rad = f64::from(bench.section.contacts) * bench.section.step_rad;
        let (first, _) = tip(&bench.curve, &bench.facts, 0.0);
        let (again, _) = tip(&bench.curve, &bench.facts, round_rad);
        let (back, _) = tip(&bench.curve, &bench.facts, -round_rad);
        assert!((first - again).norm() < 1e-5 && (first - back).norm() < 1e-5);
        assert!(first.x > 0.0 && first.y.abs() < 1e-6, "contact 1 lies on the x axis");
    }
}

/// On chords all tips keep touching, within half the tolerance of exact rolling and near enough not to turn the part.
#[test]
fn chords_stay_near_the_curve() {
    for bench in benches(3) {
        let curve = &bench.curve;
        let half_um = (bench.facts.tolerance_um / 2.0).min(1e-4 * curve.reach_um());
        let step_rad = bench.section.step_rad;
        let count = chords(curve, &bench.facts, step_rad).expect("few are enough");
        assert!(count < 60, "{count}");
        let mut worst_um: f64 = 0.0;
        for chord in 0..bench.section.contacts * count {
            let rolled = |part: f64| -step_rad * (f64::from(chord) + part) / f64::from(count);
            let exact = |part: f64| {
                let (centre, _) = tip(curve, &bench.facts, rolled(part));
                nalgebra::Rotation2::new(-rolled(part)) * centre
            };
            let (from, to) = (exact(0.0), exact(1.0));
            for part in [0.2, 0.4, 0.5, 0.6, 0.8] {
                let centre = from.lerp(&to, part);
                worst_um = worst_um.max((centre - exact(part)).norm());
                let own = nalgebra::Rotation2::new(rolled(part)) * centre;
                let touch_um = curve.nearest([own.x, own.y]).distance_um - bench.facts.tip_radius_um;
                assert!(touch_um.abs() <= half_um + 1e-5, "{touch_um} at {chord}");
            }
        }
        assert!(worst_um <= half_um + 1e-5, "{worst_um}");
        assert!(worst_um > half_um / 20.0, "the chords are far too many: {worst_um}");
    }
}

#[test]
fn too_fine_a_tolerance_is_refused() {
    let bench = Bench::new(ellipse(), FingersFacts { tolerance_um: 1e-9, ..facts(3) });
    assert_eq!(chords(&bench.curve, &bench.facts, bench.section.step_rad), None);
    let course = bench.course(vec![begin(Plane::Xy, &[1, 38, 0]), FingerAct::Roll(1)]);
    assert_eq!(bench.hand().motion(&course), Err(TipMotionError::TooFine { step: 0 }));
}
