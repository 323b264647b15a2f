//! The verifier's outlines compared with the planners' and with closed formulas.

use super::*;
use crate::geometry::outline::Curve;
use proptest::prelude::*;

/// Relative tolerance between arc lengths and positions of the two implementations.
const NEAR: f64 = 2e-9;

fn size() -> impl Strategy<Value = f64> {
    prop_oneof![Just(10.0), 1.0..50.0f64, 0.05..1.0f64, 1e3..1e5f64]
}

fn outline() -> impl Strategy<Value = Outline> {
    let ellipse = (size(), 0.05..1.0f64, any::<bool>()).prop_map(|(semi, share, is_upright)| {
        let semi_um = if is_upright { [semi * share, semi] } else { [semi, semi * share] };
        Outline::Ellipse { semi_um }
    });
    let exponent = prop_oneof![Just(2.0), Just(4.0), Just(2.5), 2.0..10.0f64, Just(10.0)];
    let lame = (size(), 0.2..2.0f64, exponent)
        .prop_map(|(semi, share, exponent)| Outline::Superellipse { semi_um: [semi, semi * share], exponent });
    let share = prop_oneof![Just(1.0), 0.05..1.0f64];
    let off = [-0.9..0.9f64, -0.9..0.9f64];
    let rounded = (size(), 0.2..2.0f64, share, off).prop_map(|(half, other, share, off)| {
        let half_um = [half, half * other];
        let radius_um = share * half_um[0].min(half_um[1]);
        let centre_um = [0, 1].map(|axis: usize| off[axis] * (half_um[axis] - radius_um));
        Outline::RoundedRectangle { half_um, radius_um, centre_um }
    });
    let wave = (2..4u8, 0.0..0.12f64, 0.0..7.0f64);
    let spline =
        (size(), 12..90usize, wave, any::<bool>()).prop_map(|(size, count, (waves, depth, phase), is_reversed)| {
            let point = |at: usize| {
                let angle = TAU * at as f64 / count as f64 + 0.3;
                let radius = size * (1.0 + depth * (f64::from(waves) * angle + phase).sin());
                [radius * angle.cos(), 0.8 * radius * angle.sin()]
            };
            let mut points_um: Vec<[f64; 2]> = (0..count).map(point).collect();
            if is_reversed {
                points_um.reverse();
            }
            Outline::Spline { points_um }
        });
    prop_oneof![ellipse, lame, rounded, spline]
}

fn both(outline: &Outline) -> (Contour, Curve) {
    (Contour::of(outline).expect("an outline"), Curve::of(outline).expect("an outline"))
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 300, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn outlines_are_as_long_and_as_wide(outline in outline()) {
        let (contour, curve) = both(&outline);
        let near = NEAR * curve.perimeter_um().max(10.0);
        prop_assert!((contour.round_um() - curve.perimeter_um()).abs() <= near, "{} {}", contour.round_um(), curve.perimeter_um());
        prop_assert!((contour.radius_um() - curve.reach_um()).abs() <= near, "{} {}", contour.radius_um(), curve.reach_um());
        let opposite = contour.opposite().expect("a place");
        let opposite_um = curve.opposite_um();
        prop_assert!((opposite.arc_length_um - opposite_um).abs() <= near, "{opposite:?} {opposite_um}");
        prop_assert!(opposite.point_um[0] < 0.0 && opposite.point_um[1].abs() <= near);
    }

    #[test]
    fn tips_touch_at_the_same_places(outline in outline(), off in 0.0..TAU, far in 0.3..3.0f64) {
        let (contour, curve) = both(&outline);
        let near = NEAR * curve.perimeter_um().max(10.0);
        let place = curve.point_at(off / TAU * curve.perimeter_um()).point_um.map(|part| part * far);
        let (judged, planned) = (contour.foot(place).expect("a place"), curve.nearest(place));
        prop_assert!((judged.distance_um - planned.distance_um).abs() <= near, "{judged:?} {planned:?}");
        // If several points are equally near, either is correct; the verifier's must be one of them.
        prop_assert!((length(minus(place, judged.point_um)) - judged.distance_um.abs()).abs() <= near);
        let spot = curve.point_at(judged.arc_length_um);
        prop_assert!(length(minus(spot.point_um, judged.point_um)) <= near);
        let turn = (spot.normal_rad - judged.normal_rad).rem_euclid(TAU);
        // Arc lengths are accurate to a length, so directions are accurate to that length over the radius of
        // curvature.
        let blur = near * spot.curvature_per_um.abs();
        prop_assert!(turn.min(TAU - turn) <= NEAR + blur, "{turn}");
        let bend = spot.curvature_per_um * curve.perimeter_um();
        // The curvature contains a root of the arc length if the exponent is only just above 2.
        let most = if matches!(outline, Outline::Superellipse { .. }) { 0.05 } else { 1e-6 + 10.0 * blur };
        prop_assert!((judged.curvature_per_um * curve.perimeter_um() - bend).abs() <= most * (1.0 + bend.abs()));
    }

    #[test]
    fn places_are_followed_in_the_neighbourhood(outline in outline(), off in -3.0..3.0f64, step in -0.02..0.02f64, out in 0.001..0.3f64) {
        let (contour, curve) = both(&outline);
        let round_um = curve.perimeter_um();
        let near = NEAR * round_um.max(10.0);
        let arc_length_um = off * round_um;
        let spot = curve.point_at(arc_length_um + step * round_um);
        let radius_um = out * round_um / 10.0;
        let tip_um = [spot.point_um[0] + radius_um * spot.normal_rad.cos(), spot.point_um[1] + radius_um * spot.normal_rad.sin()];
        let foot = contour.foot_near(tip_um, arc_length_um).expect("a place");
        prop_assert!((foot.distance_um - radius_um).abs() <= near || foot.distance_um < radius_um, "{foot:?} {radius_um}");
        if (foot.distance_um - radius_um).abs() <= near && curve.least_curvature_per_um() * radius_um > -0.5 {
            let off_um = foot.arc_length_um - arc_length_um - step * round_um;
            prop_assert!(off_um.abs() <= 10.0 * near.sqrt() * round_um.max(1.0).sqrt(), "{off_um}");
            let rolled_rad = curve.rolled_rad(foot.arc_length_um, radius_um);
            prop_assert!((foot.turn_of_tip_rad(radius_um) - rolled_rad).abs() <= NEAR * (1.0 + round_um / radius_um) + near * foot.curvature_per_um.abs(), "{rolled_rad}");
        }
    }

    #[test]
    fn tips_roll_as_far(outline in outline(), turn in -9.0..19.0f64, radius in 0.01..0.5f64) {
        let (contour, curve) = both(&outline);
        let tip_radius_um = radius * curve.perimeter_um() / 10.0;
        prop_assume!(curve.least_curvature_per_um() * tip_radius_um > -0.9);
        let near = NEAR * curve.perimeter_um().max(10.0);
        let foot = contour.rolled_to(turn, tip_radius_um).expect("a place");
        let arc_length_um = curve.way_rolled_um(turn, tip_radius_um);
        prop_assert!((foot.turn_of_tip_rad(tip_radius_um) - turn).abs() <= NEAR * (1.0 + curve.perimeter_um() / tip_radius_um));
        prop_assert!((foot.arc_length_um - arc_length_um).abs() <= 40.0 * near, "{foot:?} {arc_length_um}");
    }
}

#[test]
fn known_figures() {
    let circle = Contour::of(&Outline::Ellipse { semi_um: [3.0, 3.0] }).expect("an outline");
    assert!((circle.round_um() - 6.0 * PI).abs() < 1e-10 && (circle.radius_um() - 3.0).abs() < 1e-12);
    let foot = circle.foot([0.0, 5.0]).expect("a place");
    assert!((foot.distance_um - 2.0).abs() < 1e-12 && (foot.arc_length_um - 1.5 * PI).abs() < 1e-10);
    assert!((foot.normal_rad - PI / 2.0).abs() < 1e-12 && (foot.curvature_per_um - 1.0 / 3.0).abs() < 1e-12);
    assert!((foot.turn_of_tip_rad(3.0) - PI).abs() < 1e-10);
    assert!((circle.foot([0.0, 1.0]).expect("a place").distance_um + 2.0).abs() < 1e-12);
    // Ramanujan's second approximation, which is better than 1e-9 for these semi-axes.
    let h = (1.0f64 / 9.0).powi(2);
    let round_um = PI * 9.0 * (1.0 + 3.0 * h / (10.0 + (4.0 - 3.0 * h).sqrt()));
    let ellipse = Contour::of(&Outline::Ellipse { semi_um: [5.0, 4.0] }).expect("an outline");
    assert!((ellipse.round_um() - round_um).abs() < 1e-8);
    let rounded = Contour::of(&Outline::RoundedRectangle { half_um: [5.0, 3.0], radius_um: 1.0, centre_um: [0.0; 2] })
        .expect("an outline");
    assert!((rounded.round_um() - (4.0 * 4.0 + 4.0 * 2.0 + TAU)).abs() < 1e-10);
    assert!((rounded.radius_um() - (20f64.sqrt() + 1.0)).abs() < 1e-10);
    // A superellipse of exponent 2 is an ellipse.
    let lame = Contour::of(&Outline::Superellipse { semi_um: [5.0, 4.0], exponent: 2.0 }).expect("an outline");
    assert!((lame.round_um() - ellipse.round_um()).abs() < 1e-9);
}

/// A path of several laps, in either direction, is continuous.
#[test]
fn ways_run_on() {
    let contour = Contour::of(&Outline::Ellipse { semi_um: [5.0, 4.0] }).expect("an outline");
    let tip_um = [7.0, 0.5];
    let first = contour.foot(tip_um).expect("a place");
    for lap in [-2, -1, 0, 1, 7] {
        let around_um = f64::from(lap) * contour.round_um();
        for beside_um in [-2.0, 0.0, 2.0] {
            let foot = contour.foot_near(tip_um, first.arc_length_um + around_um + beside_um).expect("a place");
            assert!((foot.arc_length_um - first.arc_length_um - around_um).abs() < 1e-9, "{lap} {beside_um}");
            assert!((foot.turned_rad - first.turned_rad - f64::from(lap) * TAU).abs() < 1e-9);
        }
    }
}

/// Outlines that no claims have: none of them causes a panic or an endless loop.
#[test]
fn nonsense_is_no_outline() {
    let spline = |points_um: &[[f64; 2]]| Outline::Spline { points_um: points_um.to_vec() };
    let outlines = [
        Outline::Ellipse { semi_um: [f64::NAN, 1.0] },
        Outline::Ellipse { semi_um: [0.0, 1.0] },
        Outline::Ellipse { semi_um: [f64::INFINITY, 1.0] },
        Outline::Superellipse { semi_um: [1.0, 1.0], exponent: 1.0 },
        Outline::Superellipse { semi_um: [1.0, 1.0], exponent: f64::NAN },
        Outline::RoundedRectangle { half_um: [1.0, 2.0], radius_um: 1.5, centre_um: [0.0; 2] },
        Outline::RoundedRectangle { half_um: [1.0, 2.0], radius_um: 0.0, centre_um: [0.0; 2] },
        spline(&[]),
        spline(&[[1.0, 0.0], [0.0, 1.0], [-1.0, 0.0]]),
        spline(&[[1.0, 0.0], [1.0, 0.0], [-1.0, 0.0], [0.0, -1.0]]),
        spline(&[[1.0, 0.0], [0.0, f64::NAN], [-1.0, 0.0], [0.0, -1.0]]),
        spline(&[[3.0, 0.0], [2.0, 1.0], [1.0, 0.0], [2.0, -1.0]]),
        // A figure of eight has a total turn of zero.
        spline(&[[2.0, 1.0], [-2.0, -1.0], [-2.0, 1.0], [2.0, -1.0]]),
    ];
    for outline in outlines {
        assert!(Contour::of(&outline).is_none(), "{outline:?}");
    }
    for semi_um in [[1e-300, 1e300], [1e300, 1e300], [1e-308, 1e-308], [1.0, 1e12]] {
        for outline in [Outline::Ellipse { semi_um }, Outline::Superellipse { semi_um, exponent: 9.5 }] {
            if let Some(contour) = Contour::of(&outline) {
                let _ =
                    (contour.foot([1.0, 1.0]), contour.foot_near([1.0, 1.0], 1e300), contour.rolled_to(1e300, 1e-9));
                assert_eq!(contour.foot([f64::NAN, 0.0]), None);
            }
        }
    }
}
