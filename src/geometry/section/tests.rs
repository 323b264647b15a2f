use super::*;
use crate::geometry::{Pose, Shape};
use crate::random::SplitMix64;

fn merged(body: &Rounded, axis: PlaneAxis, at_um: f64) -> Vec<[f64; 2]> {
    let mut found = Vec::new();
    body.section(axis, at_um, &mut found);
    found.sort_by(|a, b| a[0].total_cmp(&b[0]));
    let mut merged: Vec<[f64; 2]> = Vec::new();
    for [lo, hi] in found {
        match merged.last_mut() {
            Some(last) if lo <= last[1] => last[1] = last[1].max(hi),
            Some(_) | None => merged.push([lo, hi]),
        }
    }
    merged
}

fn assert_near(found: &[[f64; 2]], wanted: &[[f64; 2]]) {
    assert_eq!(found.len(), wanted.len(), "{found:?} against {wanted:?}");
    for (f, w) in found.iter().zip(wanted) {
        assert!((f[0] - w[0]).abs() < 1e-12 && (f[1] - w[1]).abs() < 1e-12, "{f:?} {w:?}");
    }
}

#[test]
fn a_disc_is_cut_in_a_chord_and_touched_at_a_point() {
    let disc = Shape::Disc { radius_um: 4.0 };
    let body = disc.grown(&Pose::at(10.0, 1.0), 1.0).unwrap();
    assert_near(&merged(&body, PlaneAxis::X, 4.0), &[[6.0, 14.0]]);
    assert_near(&merged(&body, PlaneAxis::X, 6.0), &[[10.0, 10.0]]);
    assert_near(&merged(&body, PlaneAxis::X, 6.0 + 1e-9), &[]);
    assert_near(&merged(&body, PlaneAxis::Y, 13.0), &[[-3.0, 5.0]]);
}

#[test]
fn a_grown_box_has_straight_sides_and_round_corners() {
    let shape = Shape::Box { size_um: [4.0, 2.0] };
    let body = shape.grown(&Pose::at(0.0, 0.0), 5.0).unwrap();
    assert_near(&merged(&body, PlaneAxis::X, 0.5), &[[-7.0, 7.0]]);
    assert_near(&merged(&body, PlaneAxis::X, 4.0), &[[-6.0, 6.0]]);
    assert_near(&merged(&body, PlaneAxis::X, 6.0), &[[-2.0, 2.0]]);
    assert_near(&merged(&body, PlaneAxis::X, 6.001), &[]);
}

#[test]
fn a_horseshoe_is_cut_twice() {
    let points_um =
        vec![[0.0, 0.0], [6.0, 0.0], [6.0, 4.0], [5.0, 4.0], [5.0, 1.0], [1.0, 1.0], [1.0, 4.0], [0.0, 4.0]];
    let body = Shape::Polygon { points_um }.grown(&Pose::at(0.0, 0.0), 0.0).unwrap();
    assert_near(&merged(&body, PlaneAxis::X, 3.0), &[[0.0, 1.0], [5.0, 6.0]]);
    assert_near(&merged(&body, PlaneAxis::X, 1.0), &[[0.0, 6.0]]);
    assert_near(&merged(&body, PlaneAxis::Y, 3.0), &[[0.0, 1.0]]);
    let pocket = Rectangle { min_um: [1.5, 1.5], max_um: [4.5, 3.0] };
    assert!(!body.touches(&pocket));
    let leaning = Rectangle { min_um: [1.5, 1.5], max_um: [5.0, 3.0] };
    assert!(body.touches(&leaning));
    let inside = Rectangle { min_um: [2.0, 0.25], max_um: [3.0, 0.5] };
    assert!(body.touches(&inside));
}

#[test]
fn a_slanted_capsule_is_cut_across() {
    let shape = Shape::Capsule { length_um: 10.0, radius_um: 1.0 };
    let pose = Pose { x_um: 0.0, y_um: 0.0, heading_rad: std::f64::consts::FRAC_PI_4 };
    let body = shape.grown(&pose, 0.0).unwrap();
    let half = std::f64::consts::SQRT_2;
    assert_near(&merged(&body, PlaneAxis::X, 0.0), &[[-half, half]]);
}

/// A point of a line belongs to the section exactly if a rectangle shrunk to that point touches the body: two
/// independent computations.
#[test]
fn sections_and_rectangles_agree_on_points() {
    let mut stream = SplitMix64::new(7);
    let mut random = move || stream.unit();
    let star: Vec<[f64; 2]> = (0..7)
        .map(|k| (f64::from(k) * 0.8976, if k % 2 == 0 { 3.0 } else { 1.2 }))
        .map(|(angle, r)| [r * angle.cos(), r * angle.sin()])
        .collect();
    let shapes = [
        Shape::Point,
        Shape::Disc { radius_um: 1.5 },
        Shape::Box { size_um: [3.0, 1.0] },
        Shape::Polygon { points_um: star },
        Shape::Capsule { length_um: 3.0, radius_um: 0.5 },
    ];
    let (mut inside, mut outside) = (0, 0);
    for round in 0..4000 {
        let pose = Pose { x_um: random(), y_um: random(), heading_rad: random() * 7.0 };
        let body = shapes[round % 5].grown(&pose, random()).unwrap();
        let [x, y] = [random() * 6.0 - 3.0, random() * 6.0 - 3.0];
        let within = |spans: &[[f64; 2]], at: f64| spans.iter().any(|s| s[0] <= at && at <= s[1]);
        let touched = body.touches(&Rectangle { min_um: [x, y], max_um: [x, y] });
        assert_eq!(within(&merged(&body, PlaneAxis::X, y), x), touched, "{body:?} {x} {y}");
        assert_eq!(within(&merged(&body, PlaneAxis::Y, x), y), touched, "{body:?} {x} {y}");
        if touched { inside += 1 } else { outside += 1 }
    }
    assert!(inside > 500 && outside > 500);
}
