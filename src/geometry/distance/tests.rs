//! Distances against known values, and against dense samples with an independent inside test.

use super::*;
use proptest::prelude::*;

fn p(x: f64, y: f64) -> Point2<f64> {
    Point2::new(x, y)
}

fn seg(a: (f64, f64), b: (f64, f64)) -> Segment {
    [p(a.0, a.1), p(b.0, b.1)]
}

/// A plate of 4 by 4 with a slot of 1 by 3 from the top.
fn slotted() -> Vec<Point2<f64>> {
    [(-2.0, -2.0), (2.0, -2.0), (2.0, 2.0), (0.5, 2.0), (0.5, -1.0), (-0.5, -1.0), (-0.5, 2.0), (-2.0, 2.0)]
        .map(|(x, y)| p(x, y))
        .to_vec()
}

#[test]
fn points_and_segments() {
    let way = seg((0.0, 0.0), (4.0, 0.0));
    for (point, expected) in [
        ((2.0, 3.0), 3.0),
        ((4.0, 0.0), 0.0),
        ((1.5, 0.0), 0.0),
        ((7.0, 4.0), 5.0),
        ((-3.0, -4.0), 5.0),
        ((4.5, 0.0), 0.5),
    ] {
        assert_eq!(point_segment(p(point.0, point.1), way), expected, "{point:?}");
    }
    assert_eq!(point_segment(p(3.0, 4.0), seg((0.0, 0.0), (0.0, 0.0))), 5.0);
}

#[test]
fn segments_and_segments() {
    let way = seg((0.0, 0.0), (4.0, 0.0));
    for (other, expected) in [
        (seg((2.0, -1.0), (2.0, 1.0)), 0.0),
        (seg((2.0, 0.0), (2.0, 1.0)), 0.0),
        (seg((4.0, 0.0), (5.0, 5.0)), 0.0),
        (seg((3.0, 0.0), (9.0, 0.0)), 0.0),
        (seg((5.0, 0.0), (9.0, 0.0)), 1.0),
        (seg((1.0, 2.0), (3.0, 2.0)), 2.0),
        (seg((2.0, 0.5), (2.0, 4.0)), 0.5),
        (seg((7.0, 4.0), (7.0, 9.0)), 5.0),
        (seg((2.0, 3.0), (2.0, 3.0)), 3.0),
    ] {
        assert_eq!(segment_segment(way, other), expected, "{other:?}");
        assert_eq!(segment_segment(other, way), expected, "{other:?} turned");
        assert_eq!(segment_segment([way[1], way[0]], other), expected, "{other:?} reversed");
    }
}

#[test]
fn segments_and_polygons() {
    for (way, expected) in [
        (seg((0.0, 5.0), (0.0, 0.0)), 0.5),
        (seg((0.0, 5.0), (0.0, -0.75)), 0.25),
        (seg((0.25, 5.0), (0.25, 0.0)), 0.25),
        (seg((0.0, 5.0), (0.0, -1.0)), 0.0),
        (seg((0.0, 5.0), (0.0, -9.0)), 0.0),
        (seg((-1.0, 0.0), (-1.0, 1.0)), 0.0),
        (seg((1.0, 1.0), (1.0, 1.0)), 0.0),
        (seg((0.0, 1.0), (0.0, 1.0)), 0.5),
        (seg((-9.0, 3.0), (9.0, 3.0)), 1.0),
        (seg((5.0, 6.0), (9.0, 6.0)), 5.0),
        (seg((-9.0, 0.0), (9.0, 0.0)), 0.0),
    ] {
        assert_eq!(segment_polygon(way, &slotted()), expected, "{way:?}");
        let turned: Vec<_> = slotted().into_iter().rev().collect();
        assert_eq!(segment_polygon(way, &turned), expected, "{way:?} turned");
    }
}

#[test]
fn quadrilaterals_and_cores() {
    let square = [p(0.0, 0.0), p(2.0, 0.0), p(2.0, 2.0), p(0.0, 2.0)];
    let far = |by: f64| slotted().into_iter().map(|corner| corner + nalgebra::Vector2::new(by, 0.0)).collect();
    for (core, expected) in [
        (Core::Point(p(1.0, 1.0)), 0.0),
        (Core::Point(p(2.0, 1.0)), 0.0),
        (Core::Point(p(5.0, 6.0)), 5.0),
        (Core::Segment(seg((0.5, 0.5), (1.5, 1.5))), 0.0),
        (Core::Segment(seg((-1.0, 1.0), (3.0, 1.0))), 0.0),
        (Core::Segment(seg((1.0, 1.0), (9.0, 1.0))), 0.0),
        (Core::Segment(seg((4.0, -1.0), (4.0, 9.0))), 2.0),
        (Core::Polygon(vec![p(0.5, 0.5), p(1.5, 0.5), p(1.0, 1.0)]), 0.0),
        (Core::Polygon(vec![p(-9.0, -9.0), p(9.0, -9.0), p(9.0, 9.0), p(-9.0, 9.0)]), 0.0),
        (Core::Polygon(far(5.0)), 1.0),
        (Core::Polygon(far(4.0)), 0.0),
    ] {
        assert_eq!(quadrilateral_core(square, &core), expected, "{core:?}");
    }
    let thin = [p(-0.25, 0.0), p(0.25, 0.0), p(0.25, 5.0), p(-0.25, 5.0)];
    assert_eq!(quadrilateral_core(thin, &Core::Polygon(slotted())), 0.25);
    let nothing = [p(3.0, 4.0); 4];
    assert_eq!(quadrilateral_core(nothing, &Core::Point(p(0.0, 0.0))), 5.0);
}

/// Number of parts into which a segment is sampled.
const PARTS: usize = 20;

fn samples(segment: Segment) -> impl Iterator<Item = Point2<f64>> {
    (0..=PARTS).map(move |part| segment[0] + (segment[1] - segment[0]) * (part as f64 / PARTS as f64))
}

fn length([a, b]: Segment) -> f64 {
    (b - a).norm()
}

/// Whether a point is in a polygon, by winding number: the corners turn around it once.
fn wound(point: Point2<f64>, corners: &[Point2<f64>]) -> bool {
    let turn = |[a, b]: Segment| (a - point).perp(&(b - point)).atan2((a - point).dot(&(b - point)));
    edges(corners).map(turn).sum::<f64>().abs() > std::f64::consts::PI
}

/// Distance of a point from a core, with the border of a polygon sampled.
fn sampled(point: Point2<f64>, core: &Core) -> f64 {
    let to_border = |border: Segment| samples(border).map(|other| (other - point).norm()).fold(f64::INFINITY, f64::min);
    match core {
        Core::Point(other) => (other - point).norm(),
        Core::Segment(ends) => to_border(*ends),
        Core::Polygon(corners) if wound(point, corners) => 0.0,
        Core::Polygon(corners) => edges(corners).map(to_border).fold(f64::INFINITY, f64::min),
    }
}

/// Bound on the error of sampling a core.
fn coarseness(core: &Core) -> f64 {
    let longest = match core {
        Core::Point(_) => 0.0,
        Core::Segment(ends) => length(*ends),
        Core::Polygon(corners) => edges(corners).map(length).fold(0.0, f64::max),
    };
    longest / PARTS as f64 / 2.0
}

fn point() -> impl Strategy<Value = Point2<f64>> {
    (-10.0..10.0f64, -10.0..10.0f64).prop_map(|(x, y)| p(x, y))
}

/// A polygon without self-crossings: corners at increasing angles around a centre, at any distance from it.
fn polygon() -> impl Strategy<Value = Vec<Point2<f64>>> {
    (point(), prop::collection::vec(0.3..6.0f64, 3..9)).prop_map(|(middle, radii)| {
        let turn = std::f64::consts::TAU / radii.len() as f64;
        let corner = |(at, radius): (usize, f64)| {
            middle + nalgebra::Rotation2::new(turn * at as f64) * nalgebra::Vector2::new(radius, 0.0)
        };
        radii.into_iter().enumerate().map(corner).collect()
    })
}

fn core() -> impl Strategy<Value = Core> {
    prop_oneof![
        point().prop_map(Core::Point),
        [point(), point()].prop_map(Core::Segment),
        polygon().prop_map(Core::Polygon),
    ]
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 200, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn a_segment_is_as_far_as_its_nearest_sample(way in [point(), point()], core in core()) {
        let nearest = samples(way).map(|point| sampled(point, &core)).fold(f64::INFINITY, f64::min);
        let distance = segment_core(way, &core);
        let slack = length(way) / PARTS as f64 / 2.0 + coarseness(&core);
        prop_assert!(distance <= nearest + 1e-12 && nearest <= distance + slack + 1e-12, "{distance} {nearest} {slack}");
    }

    #[test]
    fn a_rectangle_is_as_far_as_its_nearest_sample(
        corner in point(),
        (wide, high, turn) in (0.0..6.0f64, 0.0..6.0f64, 0.0..6.0f64),
        core in core(),
    ) {
        let [along, up] = [(wide, 0.0), (0.0, high)].map(|(x, y)| nalgebra::Rotation2::new(turn) * nalgebra::Vector2::new(x, y));
        let rows = samples([corner, corner + up]);
        let all = rows.flat_map(|start| samples([start, start + along]));
        let nearest = all.map(|point| sampled(point, &core)).fold(f64::INFINITY, f64::min);
        let distance = quadrilateral_core([corner, corner + along, corner + along + up, corner + up], &core);
        let slack = wide.hypot(high) / PARTS as f64 / 2.0 + coarseness(&core);
        prop_assert!(distance <= nearest + 1e-12 && nearest <= distance + slack + 1e-12, "{distance} {nearest} {slack}");
    }
}
