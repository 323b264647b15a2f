//! The verifier's distances compared with the planners', on bodies of every size that are apart, touch, overlap or are
//! degenerate.

use super::convex::{apart_um, nearest_points};
use super::solid::Solid;
use crate::geometry::distance::{Segment, point_segment, quadrilateral_core, segment_core, segment_segment};
use crate::geometry::shape::{Core, MAX_EXTENT_UM};
use crate::geometry::{Pose, Rounded, Shape};
use nalgebra::{Point2, Vector2};
use proptest::prelude::*;

/// Tolerance between the two implementations, for coordinates of this size.
fn rounding_um(size_um: f64) -> f64 {
    1e-15 * size_um * 40.0
}

/// Coordinates with many equal values, so that bodies touch, are collinear, or are points.
fn coordinate() -> impl Strategy<Value = f64> {
    prop_oneof![
        4 => (-4..=4i32).prop_map(f64::from),
        4 => -10.0..10.0f64,
        1 => (-8..=8i32).prop_map(|x| f64::from(x) * 1e-9),
        1 => prop::sample::select(vec![1e6, -1e6, 1e-300, -1e-12, 0.5])
    ]
}

fn point() -> impl Strategy<Value = Point2<f64>> {
    (coordinate(), coordinate()).prop_map(|(x, y)| Point2::new(x, y))
}

/// A rectangle in any direction, its corners in order; its width, or both its sides, may be zero.
fn rectangle() -> impl Strategy<Value = [Point2<f64>; 4]> {
    let angle = prop_oneof![(0..8i32).prop_map(|eighth| f64::from(eighth).to_radians() * 45.0), 0.0..7.0f64];
    let size = prop_oneof![Just(0.0), Just(1.0), 0.0..8.0f64, Just(1e-9)];
    (point(), angle, size.clone(), size).prop_map(|(centre, angle_rad, length, width)| {
        let (along, across) =
            (Vector2::new(angle_rad.cos(), angle_rad.sin()), Vector2::new(-angle_rad.sin(), angle_rad.cos()));
        [(1.0, 1.0), (-1.0, 1.0), (-1.0, -1.0), (1.0, -1.0)]
            .map(|(a, b)| centre + along * (a * length / 2.0) + across * (b * width / 2.0))
    })
}

fn shape() -> impl Strategy<Value = Shape> {
    let size = || prop_oneof![Just(0.0), Just(2.0), 0.0..9.0f64, Just(1e-9), Just(1e5)];
    // Simple polygons, some of them concave, in either orientation.
    let star = (prop::collection::vec(0.5..6.0f64, 3..12), any::<bool>()).prop_map(|(radii_um, is_reversed)| {
        let count = radii_um.len() as f64;
        let corner = |(at, radius): (usize, &f64)| {
            let (sin, cos) = (std::f64::consts::TAU * at as f64 / count).sin_cos();
            [radius * cos, radius * sin]
        };
        let mut points_um: Vec<[f64; 2]> = radii_um.iter().enumerate().map(corner).collect();
        if is_reversed {
            points_um.reverse();
        }
        Shape::Polygon { points_um }
    });
    prop_oneof![
        Just(Shape::Point),
        size().prop_map(|radius_um| Shape::Disc { radius_um }),
        (size(), size()).prop_map(|(x, y)| Shape::Box { size_um: [x, y] }),
        (size(), size()).prop_map(|(length_um, radius_um)| Shape::Capsule { length_um, radius_um }),
        star
    ]
}

fn pose() -> impl Strategy<Value = Pose> {
    (coordinate(), coordinate(), -7.0..7.0f64).prop_map(|(x_um, y_um, heading_rad)| Pose { x_um, y_um, heading_rad })
}

fn size_um(points: &[Point2<f64>]) -> f64 {
    points.iter().map(|point| point.coords.abs().max()).fold(1.0, f64::max)
}

fn corners(body: &Rounded) -> Vec<Point2<f64>> {
    match &body.core {
        Core::Point(point) => vec![*point],
        Core::Segment(ends) => ends.to_vec(),
        Core::Polygon(corners) => corners.clone(),
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 4000, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn points_and_segments_are_as_far_apart_as_planners_say(ends in [point(), point(), point(), point()]) {
        let [a, b, c, d] = ends;
        let near = rounding_um(size_um(&ends));
        let (one, other): (Segment, Segment) = ([a, b], [c, d]);
        prop_assert!((apart_um(&[a], &[c]) - (c - a).norm()).abs() <= near);
        prop_assert!((apart_um(&[a], &other) - point_segment(a, other)).abs() <= near);
        let (judged, planned) = (apart_um(&one, &other), segment_segment(one, other));
        prop_assert!((judged - planned).abs() <= near, "{judged} {planned}");
        prop_assert!((apart_um(&other, &one) - judged).abs() <= near);
    }

    #[test]
    fn rectangles_are_as_far_apart_as_planners_say(one in rectangle(), other in rectangle(), point in point()) {
        let near = rounding_um(size_um(&one).max(size_um(&other)).max(size_um(&[point])));
        let (judged, planned) = (apart_um(&one, &other), quadrilateral_core(one, &Core::Polygon(other.to_vec())));
        prop_assert!((judged - planned).abs() <= near, "{judged} {planned}");
        let (judged, planned) = (apart_um(&one, &[point]), quadrilateral_core(one, &Core::Point(point)));
        prop_assert!((judged - planned).abs() <= near, "{judged} {planned}");
    }

    #[test]
    fn obstacles_are_where_planners_put_them(
        (shape, pose) in (shape(), pose()),
        (rectangle, point) in (rectangle(), point()),
    ) {
        let (solid, body) = (Solid::of(&shape, &pose).expect("a shape"), shape.grown(&pose, 0.0).expect("a shape"));
        let near = rounding_um(size_um(&rectangle).max(size_um(&[point])).max(size_um(&corners(&body))).max(body.radius_um));
        let planned = quadrilateral_core(rectangle, &body.core) - body.radius_um;
        let judged = solid.gap_um(&rectangle);
        prop_assert!((judged - planned).abs() <= near, "{judged} {planned}");
        let planned = segment_core([point, rectangle[0]], &body.core) - body.radius_um;
        let judged = solid.gap_um(&[point, rectangle[0]]);
        prop_assert!((judged - planned).abs() <= near, "{judged} {planned}");
        let (extent, bounds) = (solid.extent(), body.bounds());
        for axis in 0..2 {
            prop_assert!((extent.low[axis] - bounds.min_um[axis]).abs() <= near);
            prop_assert!((extent.high[axis] - bounds.max_um[axis]).abs() <= near);
        }
    }

    /// The nearest points lie on the two bodies and are as far apart as these.
    #[test]
    fn nearest_points_are_as_far_apart_as_the_bodies(
        (shape, pose) in (shape(), pose()),
        (rectangle, other) in (rectangle(), rectangle()),
    ) {
        let solid = Solid::of(&shape, &pose).expect("a shape");
        let near = 1e3 * rounding_um(size_um(&rectangle).max(size_um(&other)).max(solid.extent().high.map(f64::abs).into_iter().fold(1.0, f64::max)));
        let gap_um = apart_um(&rectangle, &other);
        if gap_um > near {
            let [one, two] = nearest_points(&rectangle, &other).expect("corners");
            prop_assert!(((one - two).norm() - gap_um).abs() <= near, "{one} {two} {gap_um}");
            prop_assert!(apart_um(&[one], &rectangle) <= near && apart_um(&[two], &other) <= near);
        }
        let gap_um = solid.gap_um(&rectangle);
        if gap_um > near {
            let [on_solid, on_body] = solid.nearest_points(&rectangle).expect("corners");
            prop_assert!(((on_solid - on_body).norm() - gap_um).abs() <= near, "{on_solid} {on_body} {gap_um}");
            prop_assert!(solid.gap_um(&[on_solid]) <= near && apart_um(&[on_body], &rectangle) <= near);
        }
    }

    /// A body grown by planners touches exactly if the verifier finds a distance of at most the growth.
    #[test]
    fn growing_an_obstacle_is_keeping_away_from_it(
        (shape, pose, growth_um) in (shape(), pose(), 0.0..5.0f64),
        (x, y, width, height) in (-9.0..9.0f64, -9.0..9.0f64, 0.0..5.0f64, 0.0..5.0f64),
    ) {
        let (solid, body) = (Solid::of(&shape, &pose).expect("a shape"), shape.grown(&pose, growth_um).expect("a shape"));
        let rectangle = crate::geometry::section::Rectangle { min_um: [x, y], max_um: [x + width, y + height] };
        let swept = [(x, y), (x + width, y), (x + width, y + height), (x, y + height)].map(|(x, y)| Point2::new(x, y));
        let gap_um = solid.gap_um(&swept);
        // Within the margin that planners keep, either answer is possible.
        prop_assume!((gap_um - growth_um).abs() > 1e-9);
        prop_assert_eq!(body.touches(&rectangle), gap_um <= growth_um);
    }
}

#[test]
fn what_is_no_shape_for_planners_is_none_for_the_judge() {
    let wide_um = MAX_EXTENT_UM * 1.001;
    let at = Pose::at(1.0, 2.0);
    let polygon = |points_um: &[[f64; 2]]| Shape::Polygon { points_um: points_um.to_vec() };
    let shapes = [
        Shape::Disc { radius_um: -1.0 },
        Shape::Disc { radius_um: f64::NAN },
        Shape::Disc { radius_um: wide_um },
        Shape::Box { size_um: [-1.0, 1.0] },
        Shape::Box { size_um: [1.0, wide_um] },
        Shape::Capsule { length_um: -1.0, radius_um: 1.0 },
        Shape::Capsule { length_um: f64::INFINITY, radius_um: 1.0 },
        polygon(&[[0.0, 0.0], [1.0, 0.0]]),
        polygon(&[[0.0, 0.0], [1.0, 0.0], [0.0, wide_um]]),
        polygon(&[[0.0, 0.0], [1.0, 0.0], [0.0, f64::NAN]]),
    ];
    for shape in shapes {
        assert!(shape.grown(&at, 0.0).is_err() && Solid::of(&shape, &at).is_none(), "{shape:?}");
    }
    for pose in [Pose::at(wide_um, 0.0), Pose::at(0.0, f64::NAN), Pose { heading_rad: f64::INFINITY, ..at }] {
        assert!(Shape::Point.grown(&pose, 0.0).is_err() && Solid::of(&Shape::Point, &pose).is_none(), "{pose:?}");
    }
    assert!(Solid::of(&Shape::Disc { radius_um: MAX_EXTENT_UM }, &at).is_some());
}

#[test]
fn distances_by_hand() {
    let p = |x: f64, y: f64| Point2::new(x, y);
    let square = [p(0.0, 0.0), p(2.0, 0.0), p(2.0, 2.0), p(0.0, 2.0)];
    for (body, expected) in [
        (vec![p(1.0, 1.0)], 0.0),
        (vec![p(5.0, 6.0)], 5.0),
        (vec![p(2.0, 2.0), p(3.0, 3.0)], 0.0),
        (vec![p(3.0, -9.0), p(3.0, 9.0)], 1.0),
        (vec![p(3.0, 1.0), p(9.0, 1.0)], 1.0),
        (vec![p(-1.0, 1.0), p(9.0, 1.0)], 0.0),
        (vec![p(0.5, 4.0), p(1.5, 4.0), p(1.0, 2.5)], 0.5),
        (vec![], f64::INFINITY),
    ] {
        assert_eq!(apart_um(&square, &body), expected, "{body:?}");
        assert_eq!(apart_um(&body, &square), expected, "{body:?} turned");
    }
    // Collinear segments, which no side separates.
    assert_eq!(apart_um(&[p(0.0, 0.0), p(1.0, 0.0)], &[p(3.0, 0.0), p(4.0, 0.0)]), 2.0);
    // A cavity is outside, and so is a body in it.
    let cup = Shape::Polygon {
        points_um: vec![
            [-2.0, -2.0],
            [2.0, -2.0],
            [2.0, 2.0],
            [1.0, 2.0],
            [1.0, -1.0],
            [-1.0, -1.0],
            [-1.0, 2.0],
            [-2.0, 2.0],
        ],
    };
    let cup = Solid::of(&cup, &Pose::at(0.0, 0.0)).expect("a shape");
    assert_eq!(cup.gap_um(&[p(0.0, 0.0)]), 1.0);
    assert_eq!(cup.gap_um(&[p(0.0, -1.5)]), 0.0);
    assert_eq!(cup.gap_um(&[p(-9.0, -9.0), p(9.0, -9.0), p(9.0, 9.0), p(-9.0, 9.0)]), 0.0);
}
