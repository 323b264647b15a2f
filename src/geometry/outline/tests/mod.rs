//! Outlines against formulas, integrals and brute force.

mod lists;

use super::*;
use crate::random::SplitMix64;
use std::f64::consts::{FRAC_PI_2, PI};

const TIP_UM: f64 = 4.5;

/// The outline of the paper's ellipsoid: 74 contacts at 20 deg with tips of 4.5 um.
const PAPER_UM: [f64; 2] = [16.0, 11.845];

fn curve(outline: &Outline) -> Curve {
    Curve::of(outline).unwrap_or_else(|error| panic!("{outline:?}: {error:?}"))
}

/// Difference between the greatest and the least x.
fn width_um(curve: &Curve) -> f64 {
    -curve.least(|spot| -spot.point_um[0]) - curve.least(|spot| spot.point_um[0])
}

fn spline(points: &[[f64; 2]]) -> Outline {
    Outline::Spline { points_um: points.to_vec() }
}

fn round(count: usize, at: impl Fn(f64) -> [f64; 2]) -> Vec<[f64; 2]> {
    (0..count).map(|step| at(TAU * step as f64 / count as f64)).collect()
}

/// A ring with lobes; concave beyond a certain depth.
fn lobed(lobes: f64, depth: f64) -> Outline {
    spline(&round(120, |angle| {
        let r = 20.0 * (1.0 + depth * (lobes * angle).cos());
        [r * angle.cos(), 0.8 * r * angle.sin()]
    }))
}

fn all() -> Vec<Outline> {
    let mut all = vec![
        Outline::Ellipse { semi_um: [14.0, 14.0] },
        Outline::Ellipse { semi_um: PAPER_UM },
        Outline::Ellipse { semi_um: [3.0, 40.0] },
        Outline::RoundedRectangle { half_um: [20.0, 10.0], radius_um: 3.0, centre_um: [0.0; 2] },
        Outline::RoundedRectangle { half_um: [20.0, 10.0], radius_um: 10.0, centre_um: [0.0; 2] },
        Outline::RoundedRectangle { half_um: [10.0, 10.0], radius_um: 10.0, centre_um: [0.0; 2] },
        Outline::RoundedRectangle { half_um: [20.0, 10.0], radius_um: 3.0, centre_um: [-15.0, 6.5] },
        lobed(3.0, 0.05),
        lobed(5.0, 0.2),
        lobed(2.0, 0.4),
    ];
    let superellipse = |exponent| Outline::Superellipse { semi_um: [18.0, 11.0], exponent };
    all.extend([2.0, 2.01, 2.5, 3.0, 4.0, 7.5, 10.0].map(superellipse));
    all
}

#[test]
fn the_papers_ellipse_has_74_contacts() {
    let [a, b] = PAPER_UM;
    // For a periodic function the trapezoidal rule converges faster than any power.
    let count = 4096;
    let speed = |step: usize| (TAU * step as f64 / count as f64).sin_cos();
    let integral: f64 = (0..count).map(speed).map(|(s, c)| (a * s).hypot(b * c)).sum::<f64>() * TAU / count as f64;
    let curve = curve(&Outline::Ellipse { semi_um: PAPER_UM });
    assert!((curve.perimeter_um() - integral).abs() < 1e-9, "{} {integral}", curve.perimeter_um());
    let contacts = curve.rolled_rad(curve.perimeter_um(), TIP_UM) / (TAU / 18.0);
    assert!((contacts - 74.0).abs() < 0.01, "{contacts}");
    assert!((curve.area_um2() - PI * a * b).abs() < 1e-8);
    assert!((curve.least_curvature_per_um() - b / (a * a)).abs() < 1e-12);
    assert!((curve.reach_um() - a).abs() < 1e-12 && (width_um(&curve) - 2.0 * a).abs() < 1e-12);
    assert!((curve.opposite_um() - curve.perimeter_um() / 2.0).abs() < 1e-9);
}

#[test]
fn a_circle_is_exact() {
    let curve = curve(&Outline::Ellipse { semi_um: [14.0, 14.0] });
    assert!((curve.perimeter_um() - 28.0 * PI).abs() < 1e-10);
    for step in -100..200 {
        let way = f64::from(step) * 1.37;
        let (spot, angle) = (curve.point_at(way), way / 14.0);
        assert!((spot.point_um[0] - 14.0 * angle.cos()).abs() < 1e-8);
        assert!((spot.point_um[1] - 14.0 * angle.sin()).abs() < 1e-8);
        assert!((spot.normal_rad - angle).abs() < 1e-9, "{} {angle}", spot.normal_rad);
        assert!((spot.curvature_per_um - 1.0 / 14.0).abs() < 1e-12);
        assert!((curve.rolled_rad(way, TIP_UM) - way * (1.0 / 14.0 + 1.0 / TIP_UM)).abs() < 1e-9);
    }
    let around = curve.nearest([0.0, 0.0]);
    assert!((around.distance_um + 14.0).abs() < 1e-9);
}

#[test]
fn ways_points_normals_and_curvatures_agree() {
    for outline in all() {
        let curve = curve(&outline);
        let perimeter = curve.perimeter_um();
        let count = 3000;
        for step in 0..count {
            // Across the joints of rounded rectangles, differences of curvature are of first order.
            let (way, small) = ((f64::from(step) + 0.37) * perimeter / f64::from(count), 1e-4);
            let [before, spot, after] = [way - small, way, way + small].map(|way| curve.point_at(way));
            let moved = minus(after.point_um, before.point_um);
            assert!((norm(moved) / (2.0 * small) - 1.0).abs() < 2e-6, "{outline:?} {way} {}", norm(moved));
            let (s, c) = spot.normal_rad.sin_cos();
            assert!(dot(moved, [c, s]).abs() < 1e-7 * (1.0 + spot.curvature_per_um.abs()), "{outline:?} {way}");
            assert!(cross([c, s], moved) > 0.0);
            let bent = (after.normal_rad - before.normal_rad) / (2.0 * small);
            let (low, high) = (
                before.curvature_per_um.min(after.curvature_per_um),
                before.curvature_per_um.max(after.curvature_per_um),
            );
            assert!(bent > low - 1e-3 && bent < high + 1e-3, "{outline:?} {way}: {bent} of {low} to {high}");
            assert!(curve.least_curvature_per_um() <= spot.curvature_per_um + 1e-12);
            assert!(curve.reach_um() >= norm(spot.point_um) - 1e-12);
        }
    }
}

/// The reported arc length matches a fine polyline, whose error decreases with the square of its step.
#[test]
fn ways_are_lengths() {
    for outline in all() {
        let curve = curve(&outline);
        let length = |count: usize| -> f64 {
            let point = |step: usize| curve.point_at(curve.perimeter_um() * step as f64 / count as f64).point_um;
            (0..count).map(|step| norm(minus(point(step + 1), point(step)))).sum()
        };
        let (coarse, fine) = (length(4000), length(8000));
        let limit = fine + (fine - coarse) / 3.0;
        assert!((limit - curve.perimeter_um()).abs() < 1e-6, "{outline:?}: {limit} {}", curve.perimeter_um());
    }
}

#[test]
fn the_normal_turns_just_once() {
    for outline in all() {
        let curve = curve(&outline);
        let perimeter = curve.perimeter_um();
        for way in [0.0, 0.3, 11.1, 40.0] {
            let turned = curve.point_at(way + perimeter).normal_rad - curve.point_at(way).normal_rad;
            assert!((turned - TAU).abs() < 1e-9, "{outline:?} {turned}");
            let back = curve.point_at(way - 3.0 * perimeter).normal_rad - curve.point_at(way).normal_rad;
            assert!((back + 3.0 * TAU).abs() < 1e-8, "{outline:?} {back}");
        }
        let rolled = curve.rolled_rad(perimeter, TIP_UM);
        assert!((rolled - TAU - perimeter / TIP_UM).abs() < 1e-9);
        assert_eq!(curve.rolled_rad(0.0, TIP_UM), 0.0);
    }
}

#[test]
fn rolling_and_its_inverse_agree() {
    let mut dice = SplitMix64::new(5);
    for outline in all() {
        let curve = curve(&outline);
        // A tip that reaches every point, and one that barely does.
        let least = curve.least_curvature_per_um();
        let tips = if least < -1e-6 { vec![-0.5 / least, -0.99 / least] } else { vec![TIP_UM, 1000.0] };
        for tip in tips {
            for _ in 0..300 {
                let way = dice.signed_unit() * 3.0 * curve.perimeter_um();
                let back = curve.way_rolled_um(curve.rolled_rad(way, tip), tip);
                assert!((way - back).abs() < 1e-6, "{outline:?} {tip}: {way} {back}");
            }
        }
        // A tip that does not reach every point: any answer will do, except NaN.
        if least < 0.0 {
            assert!((0..200).all(|step| !curve.way_rolled_um(f64::from(step) * 0.1, -3.0 / least).is_nan()));
        }
        for odd in [f64::NAN, f64::INFINITY, 1e300] {
            curve.way_rolled_um(odd, TIP_UM);
            curve.way_rolled_um(1.0, odd);
            curve.point_at(odd);
            curve.nearest([odd, 1.0]);
        }
    }
}

#[test]
fn it_begins_where_the_x_axis_leaves_it() {
    for outline in all() {
        let curve = curve(&outline);
        let (begin, opposite) = (curve.point_at(0.0), curve.point_at(curve.opposite_um()));
        assert!(begin.point_um[0] > 0.0 && begin.point_um[1].abs() < 1e-9, "{outline:?} {begin:?}");
        assert!(opposite.point_um[0] < 0.0 && opposite.point_um[1].abs() < 1e-7, "{outline:?} {opposite:?}");
        assert!(begin.normal_rad.abs() < PI);
    }
}

/// A winding outline that the x axis leaves three times on the right: the outermost point counts.
#[test]
fn the_farthest_of_several_places_counts() {
    let points = [
        [-10.0, 5.0],
        [-10.0, -5.0],
        [0.0, -8.0],
        [8.0, -5.0],
        [10.0, 3.0],
        [13.0, 4.0],
        [16.0, -6.0],
        [20.0, -6.0],
        [20.0, 6.0],
        [14.0, 10.0],
        [5.0, 9.0],
        [0.0, 8.0],
    ];
    let ahead = curve(&spline(&points));
    let begin = ahead.point_at(0.0).point_um;
    assert!(begin[0] > 19.0 && begin[1].abs() < 1e-9, "{begin:?}");
    let mut clockwise = points;
    clockwise.reverse();
    let back = curve(&spline(&clockwise));
    for step in 0..100 {
        let way = f64::from(step);
        assert!(norm(minus(ahead.point_at(way).point_um, back.point_at(way).point_um)) < 1e-6);
    }
    assert!(ahead.area_um2() > 0.0 && (ahead.area_um2() - back.area_um2()).abs() < 1e-9);
}

/// The least distance from sampled points of the curve, first with coarse steps, then with fine ones.
fn brute(curve: &Curve, point: [f64; 2]) -> f64 {
    let at = |way: f64| norm(minus(curve.point_at(way).point_um, point));
    let step = curve.perimeter_um() / 4000.0;
    let best = (0..4000).map(|at| f64::from(at) * step).min_by(|a, b| at(*a).total_cmp(&at(*b))).unwrap();
    let fine = (-1000..=1000).map(|part| at(best + f64::from(part) * step / 500.0));
    fine.fold(f64::INFINITY, f64::min)
}

#[test]
fn the_nearest_place_is_that_of_brute_force() {
    let mut dice = SplitMix64::new(11);
    for outline in all() {
        let curve = curve(&outline);
        for _ in 0..60 {
            let point = [dice.signed_unit() * 45.0, dice.signed_unit() * 45.0];
            let (found, wanted) = (curve.nearest(point), brute(&curve, point));
            assert!((found.distance_um.abs() - wanted).abs() < 1e-5, "{outline:?} {point:?} {found:?} {wanted}");
            assert!(found.distance_um.abs() < wanted + 1e-9, "{outline:?} {point:?} {found:?} {wanted}");
            let spot = curve.point_at(found.way_um);
            assert!((norm(minus(point, spot.point_um)) - found.distance_um.abs()).abs() < 1e-7);
        }
    }
}

#[test]
fn the_nearest_place_of_a_tip_is_its_contact() {
    let mut dice = SplitMix64::new(17);
    for outline in all() {
        let curve = curve(&outline);
        let least = curve.least_curvature_per_um();
        let tip = if least < -1e-6 { (-0.6 / least).min(2.0) } else { TIP_UM };
        for _ in 0..200 {
            let way = (dice.signed_unit() + 1.0) / 2.0 * curve.perimeter_um();
            let spot = curve.point_at(way);
            for side in [1.0, -1e-3] {
                let (s, c) = spot.normal_rad.sin_cos();
                let centre = [spot.point_um[0] + side * tip * c, spot.point_um[1] + side * tip * s];
                let found = curve.nearest(centre);
                assert!((found.distance_um - side * tip).abs() < 1e-8, "{outline:?} {way} {found:?}");
                let off_um = (found.way_um - way).abs();
                assert!(off_um.min(curve.perimeter_um() - off_um) < 1e-6, "{outline:?} {way} {found:?}");
            }
        }
    }
}

#[test]
fn a_rounded_rectangle_has_exact_normals() {
    let curve = curve(&Outline::RoundedRectangle { half_um: [20.0, 10.0], radius_um: 3.0, centre_um: [0.0; 2] });
    assert!((curve.perimeter_um() - (2.0 * (34.0 + 14.0) + TAU * 3.0)).abs() < 1e-10);
    assert!((curve.area_um2() - (800.0 - (4.0 - PI) * 9.0)).abs() < 1e-9);
    assert!((curve.reach_um() - (17.0_f64.hypot(7.0) + 3.0)).abs() < 1e-10);
    assert_eq!(curve.least_curvature_per_um(), 0.0);
    assert_eq!(curve.point_at(6.9).normal_rad, 0.0);
    let corner = curve.point_at(7.0 + 3.0 * PI / 4.0);
    assert!((corner.normal_rad - PI / 4.0).abs() < 1e-12 && (corner.curvature_per_um - 1.0 / 3.0).abs() < 1e-12);
    assert!((curve.point_at(7.0 + 3.0 * FRAC_PI_2 + 17.0).normal_rad - FRAC_PI_2).abs() < 1e-12);
    let above = curve.nearest([4.0, 12.5]);
    assert!((above.distance_um - 2.5).abs() < 1e-12);
}

#[test]
fn a_superellipse_keeps_its_equation() {
    for exponent in [2.0, 2.3, 4.0, 10.0] {
        let curve = curve(&Outline::Superellipse { semi_um: [18.0, 11.0], exponent });
        for step in 0..500 {
            let [x, y] = curve.point_at(f64::from(step) * 0.173).point_um;
            let sum = (x / 18.0).abs().powf(exponent) + (y / 11.0).abs().powf(exponent);
            assert!((sum - 1.0).abs() < 1e-12);
        }
        let flat = if exponent > 2.0 { 0.0 } else { 11.0 / 324.0 };
        assert!((curve.least_curvature_per_um() - flat).abs() < 1e-9, "{}", curve.least_curvature_per_um());
    }
}

#[test]
fn a_spline_of_an_ellipse_is_near_it() {
    let [a, b] = PAPER_UM;
    let exact = curve(&Outline::Ellipse { semi_um: PAPER_UM });
    let mut before = f64::INFINITY;
    for count in [32, 64, 128] {
        let close = curve(&spline(&round(count, |angle| [a * angle.cos(), b * angle.sin()])));
        let off = (0..880)
            .map(|step| exact.nearest(close.point_at(f64::from(step) * 0.1).point_um).distance_um.abs())
            .fold(0.0, f64::max);
        // Fourth-order convergence, apart from rounding.
        assert!(off < before / 12.0 + 1e-9, "{count}: {off} after {before}");
        before = off;
        assert!((close.area_um2() - exact.area_um2()).abs() < 200.0 * off + 1e-9);
        assert!(norm(close.centre_um()) < off + 1e-9);
    }
    assert!(before < 1e-5, "{before}");
}

#[test]
fn the_centre_is_that_of_the_area() {
    // An ellipse whose centre is not the origin.
    let points = round(400, |angle| [3.0 + 16.0 * angle.cos(), -2.0 + 11.0 * angle.sin()]);
    let curve = curve(&spline(&points));
    assert!(norm(minus(curve.centre_um(), [3.0, -2.0])) < 1e-6, "{:?}", curve.centre_um());
    assert!((width_um(&curve) - 32.0).abs() < 1e-6);
}

#[test]
fn what_is_no_outline_is_refused() {
    let of = |outline: &Outline| Curve::of(outline).map(|_| ());
    let square = [[10.0, 10.0], [-10.0, 10.0], [-10.0, -10.0], [10.0, -10.0]];
    assert_eq!(of(&spline(&square)), Ok(()));
    assert_eq!(of(&spline(&square[..3])), Err(OutlineError::TooFewPoints(3)));
    assert_eq!(of(&spline(&[])), Err(OutlineError::TooFewPoints(0)));
    let ring = |count| spline(&round(count, |angle| [9.0 * angle.cos(), 9.0 * angle.sin()]));
    assert_eq!(of(&ring(MAX_POINTS)), Ok(()));
    assert_eq!(of(&ring(MAX_POINTS + 1)), Err(OutlineError::TooManyPoints(MAX_POINTS + 1)));
    for odd in [f64::NAN, f64::INFINITY, 2.0 * MAX_UM, -f64::MAX] {
        let mut points = square;
        points[2][1] = odd;
        assert_eq!(of(&spline(&points)), Err(OutlineError::Number));
        assert_eq!(of(&Outline::Superellipse { semi_um: [5.0, 4.0], exponent: odd }), Err(OutlineError::Number));
        assert_eq!(
            of(&Outline::RoundedRectangle { half_um: [5.0, 4.0], radius_um: odd, centre_um: [0.0; 2] }),
            Err(OutlineError::Number)
        );
        assert_eq!(of(&Outline::Ellipse { semi_um: [odd, 4.0] }), Err(OutlineError::Number));
    }
    assert_eq!(of(&Outline::Ellipse { semi_um: [0.0, 4.0] }), Err(OutlineError::NoArea));
    assert_eq!(
        of(&Outline::RoundedRectangle { half_um: [5.0, 4.0], radius_um: 4.01, centre_um: [0.0; 2] }),
        Err(OutlineError::Number)
    );
    assert_eq!(of(&Outline::Superellipse { semi_um: [5.0, 4.0], exponent: 1.99 }), Err(OutlineError::Number));
    let twice = [[10.0, 10.0], [-10.0, 10.0], [-10.0, 10.0], [-10.0, -10.0], [10.0, -10.0]];
    assert_eq!(of(&spline(&twice)), Err(OutlineError::RepeatedPoint(1)));
    assert_eq!(of(&spline(&[[1.0, 1.0]; 9])), Err(OutlineError::RepeatedPoint(0)));
    assert_eq!(of(&spline(&[[0.0, 0.0]; 9])), Err(OutlineError::RepeatedPoint(0)));
    assert_eq!(of(&spline(&[[-3.0, 0.0], [-1.0, 0.0], [1.0, 0.0], [2.0, 0.0]])), Err(OutlineError::NoArea));
    assert_eq!(of(&spline(&square.map(|[x, y]| [x + 30.0, y]))), Err(OutlineError::OffOrigin));
    assert_eq!(of(&spline(&square.map(|[x, y]| [x, y + 30.0]))), Err(OutlineError::OffOrigin));
}

/// A horseshoe around the origin: the axis meets it on both sides, but the origin is outside.
#[test]
fn the_origin_lies_inside() {
    let outer = (0..=40).map(|step| (20.0, -1.2 * FRAC_PI_2 + f64::from(step) * 2.4 * FRAC_PI_2 / 40.0));
    let inner = (0..=40).map(|step| (12.0, 1.2 * FRAC_PI_2 - f64::from(step) * 2.4 * FRAC_PI_2 / 40.0));
    let points: Vec<[f64; 2]> = outer.chain(inner).map(|(r, angle)| [r * angle.sin(), r * angle.cos()]).collect();
    assert_eq!(Curve::of(&spline(&points)).map(|_| ()), Err(OutlineError::OffOrigin));
}

#[test]
fn a_crossing_is_found() {
    let eight = round(64, |angle| [20.0 * angle.cos(), 9.0 * (2.0 * angle).sin() + 3.0 * angle.sin()]);
    let Err(OutlineError::Crossing { ways_um }) = Curve::of(&spline(&eight)).map(|_| ()) else {
        panic!("{:?}", Curve::of(&spline(&eight)).map(|_| ()));
    };
    assert!(ways_um[0] < ways_um[1]);
    let twice: Vec<[f64; 2]> = round(40, |angle| [9.0 * (2.0 * angle).cos(), 9.0 * (2.0 * angle).sin()]);
    assert!(matches!(Curve::of(&spline(&twice)).map(|_| ()), Err(OutlineError::Crossing { .. })));
    // A small loop on a large ring.
    let mut looped = round(40, |angle| [20.0 * angle.cos(), 20.0 * angle.sin()]);
    looped.splice(11..11, [[-6.0, 18.0], [-6.0, 17.0], [-4.0, 17.0]]);
    assert!(matches!(Curve::of(&spline(&looped)).map(|_| ()), Err(OutlineError::Crossing { .. })));
}

#[test]
fn whatever_the_numbers_it_comes_to_an_end() {
    let mut dice = SplitMix64::new(23);
    for round in 0..140 {
        let scale = 10_f64.powi(round % 14 - 7);
        let count = 4 + (round % 60) as usize;
        let points: Vec<[f64; 2]> =
            (0..count).map(|_| [scale * dice.signed_unit(), scale * dice.signed_unit()]).collect();
        drop(Curve::of(&spline(&points)));
        let rings: Vec<[f64; 2]> = super::tests::round(count, |angle| {
            let r = scale * (1.0 + 0.2 * dice_of(angle, round));
            [r * angle.cos(), r * angle.sin()]
        });
        if let Ok(curve) = Curve::of(&spline(&rings)) {
            assert!(
                (curve.point_at(curve.perimeter_um()).normal_rad - curve.point_at(0.0).normal_rad - TAU).abs() < 1e-9
            );
        }
        drop(Curve::of(&Outline::Ellipse { semi_um: [scale, scale * scale] }));
        drop(Curve::of(&Outline::Superellipse {
            semi_um: [scale, scale * scale],
            exponent: 2.0 + f64::from(round % 9),
        }));
    }
    let many: Vec<[f64; 2]> =
        (0..MAX_POINTS).map(|_| [100.0 * dice.signed_unit(), 100.0 * dice.signed_unit()]).collect();
    assert!(matches!(
        Curve::of(&spline(&many)).map(|_| ()),
        Err(OutlineError::Crossing { .. } | OutlineError::Rough { .. })
    ));
}

fn dice_of(angle: f64, seed: i32) -> f64 {
    SplitMix64::new((angle * 1000.0) as u64 + seed as u64).signed_unit()
}
