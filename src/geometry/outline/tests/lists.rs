//! Outlines from lists of points.

use super::*;

fn smoothed(points: &[[f64; 2]]) -> Curve {
    let outline = Outline::from_polygon(points).unwrap_or_else(|error| panic!("{error:?}"));
    let Outline::Spline { points_um } = &outline else { panic!("{outline:?}") };
    assert!(points_um.len() <= MAX_SMOOTHED);
    curve(&outline)
}

/// Greatest distance of a curve from another.
fn off(one: &Curve, other: &Curve) -> f64 {
    let count = 700;
    let place = |step: i32| one.point_at(one.perimeter_um() * f64::from(step) / f64::from(count)).point_um;
    (0..count).map(|step| other.nearest(place(step)).distance_um.abs()).fold(0.0, f64::max)
}

fn ellipse(count: usize) -> Vec<[f64; 2]> {
    round(count, |angle| [PAPER_UM[0] * angle.cos(), PAPER_UM[1] * angle.sin()])
}

#[test]
fn a_fine_polygon_is_kept() {
    let exact = curve(&Outline::Ellipse { semi_um: PAPER_UM });
    for count in [500, 5000, 100_000] {
        let close = smoothed(&ellipse(count));
        assert!(off(&close, &exact) < 3e-3, "{count}: {}", off(&close, &exact));
        assert!((close.perimeter_um() - exact.perimeter_um()).abs() < 5e-3);
        assert!(close.least_curvature_per_um() > 0.8 * exact.least_curvature_per_um());
    }
    let concave = curve(&lobed(3.0, 0.2));
    let count = 20_000;
    let points: Vec<[f64; 2]> = (0..count)
        .map(|step| concave.point_at(concave.perimeter_um() * f64::from(step) / f64::from(count)).point_um)
        .collect();
    assert!(off(&smoothed(&points), &concave) < 5e-3);
}

/// Straight sides are taken for samples of something round.
#[test]
fn a_coarse_polygon_becomes_round() {
    let close = smoothed(&round(24, |angle| [14.0 * angle.cos(), 14.0 * angle.sin()]));
    let exact = curve(&Outline::Ellipse { semi_um: [14.0, 14.0] });
    assert!(off(&close, &exact) < 0.15, "{}", off(&close, &exact));
    assert!((close.least_curvature_per_um() - 1.0 / 14.0).abs() < 0.01, "{}", close.least_curvature_per_um());
}

#[test]
fn a_million_points_with_noise_are_smoothed() {
    let mut dice = SplitMix64::new(3);
    let mut points = ellipse(MAX_POLYGON);
    points.iter_mut().flatten().for_each(|number| *number += 0.02 * dice.signed_unit());
    let close = smoothed(&points);
    let exact = curve(&Outline::Ellipse { semi_um: PAPER_UM });
    assert!(off(&close, &exact) < 0.02, "{}", off(&close, &exact));
    assert!(close.least_curvature_per_um() > 0.0);
    points.push([0.0, 0.0]);
    assert_eq!(Outline::from_polygon(&points), Err(OutlineError::TooManyPoints(MAX_POLYGON + 1)));
}

/// The stairs of an image's pixels.
#[test]
fn stairs_are_smoothed() {
    let points = ellipse(4000).into_iter().map(|point| point.map(|number| (number * 5.0).round() / 5.0));
    let mut stairs: Vec<[f64; 2]> = Vec::new();
    for point in points {
        match stairs.last().copied() {
            Some(last) if last[0] != point[0] && last[1] != point[1] => stairs.extend([[point[0], last[1]], point]),
            Some(last) if last == point => {}
            Some(_) | None => stairs.push(point),
        }
    }
    let close = smoothed(&stairs);
    assert!(off(&close, &curve(&Outline::Ellipse { semi_um: PAPER_UM })) < 0.2);
    assert!(close.least_curvature_per_um() > -1.0 / TIP_UM, "{}", close.least_curvature_per_um());
}

#[test]
fn corners_are_rounded_a_little() {
    let side = |step: usize| -10.0 + 20.0 * (step % 100) as f64 / 100.0;
    let square: Vec<[f64; 2]> = (0..400)
        .map(|step| match step / 100 {
            0 => [10.0, side(step)],
            1 => [-side(step), 10.0],
            2 => [-10.0, -side(step)],
            _ => [side(step), -10.0],
        })
        .collect();
    let close = smoothed(&square);
    assert!((close.area_um2() - 400.0).abs() < 2.0, "{}", close.area_um2());
    assert!(close.nearest([10.0, 10.0]).distance_um < 0.3);
}

#[test]
fn direction_and_repeats_do_not_matter() {
    let points = ellipse(1000);
    let ahead = smoothed(&points);
    let mut other: Vec<[f64; 2]> = points.iter().rev().flat_map(|point| [*point, *point]).collect();
    other.push(points[999]);
    assert!(off(&smoothed(&other), &ahead) < 1e-3);
    assert_eq!(Outline::from_polygon(&points), Outline::from_polygon(&points));
}

#[test]
fn samples_are_met() {
    let points = ellipse(200);
    let close = curve(&Outline::Spline { points_um: points.clone() });
    assert!(points.iter().all(|point| close.nearest(*point).distance_um.abs() < 1e-9));
}

#[test]
fn what_is_no_polygon_is_refused() {
    let mut points = ellipse(100);
    points[7][0] = f64::NAN;
    assert_eq!(Outline::from_polygon(&points), Err(OutlineError::Number));
    points[7][0] = 1e300;
    assert_eq!(Outline::from_polygon(&points), Err(OutlineError::Number));
    assert_eq!(Outline::from_polygon(&[[1.0, 1.0]; 1000]), Err(OutlineError::TooFewPoints(1)));
    assert_eq!(Outline::from_polygon(&[]), Err(OutlineError::TooFewPoints(0)));
    let flat: Vec<[f64; 2]> = (0..50).map(|step| [f64::from(step), 0.0]).collect();
    assert_eq!(Outline::from_polygon(&flat), Err(OutlineError::NoArea));
    // Chaotic input terminates too.
    let mut dice = SplitMix64::new(31);
    for count in [5, 50, 5000] {
        let chaos: Vec<[f64; 2]> = (0..count).map(|_| [dice.signed_unit(), dice.signed_unit()]).collect();
        if let Ok(outline) = Outline::from_polygon(&chaos) {
            drop(Curve::of(&outline));
        }
    }
}
