//! Planar distances for the oracle; none of the compiler's geometry is used.

pub type Point = [f64; 2];

/// A placed obstacle: all points within `radius` of a filled outline with one, two or more corners, in micrometres.
#[derive(Debug, Clone)]
pub struct Body {
    pub outline: Vec<Point>,
    pub radius: f64,
}

/// Clearance between a closed axis-parallel rectangle, which may be a segment or a point, and a body; negative inside
/// the rim.
pub fn clearance(low: Point, high: Point, body: &Body) -> f64 {
    let rectangle = [low, [high[0], low[1]], high, [low[0], high[1]]];
    let holds_a_corner = body.outline.iter().any(|p| (0..2).all(|axis| low[axis] <= p[axis] && p[axis] <= high[axis]));
    if holds_a_corner || contains(&body.outline, low) {
        return -body.radius;
    }
    let pairs = edges(&rectangle).flat_map(|(a, b)| edges(&body.outline).map(move |(c, d)| segment_gap(a, b, c, d)));
    pairs.fold(f64::INFINITY, f64::min) - body.radius
}

fn edges(outline: &[Point]) -> impl Iterator<Item = (Point, Point)> + '_ {
    (0..outline.len()).map(|k| (outline[k], outline[(k + 1) % outline.len()]))
}

/// Whether a point is inside, by the number of edges that a ray to the right crosses.
fn contains(outline: &[Point], p: Point) -> bool {
    let crossed = edges(outline)
        .filter(|(a, b)| (a[1] > p[1]) != (b[1] > p[1]) && p[0] < a[0] + (p[1] - a[1]) / (b[1] - a[1]) * (b[0] - a[0]));
    crossed.count() % 2 == 1
}

fn segment_gap(a: Point, b: Point, c: Point, d: Point) -> f64 {
    let (u, v, w) = (minus(b, a), minus(d, c), minus(c, a));
    let area = cross(u, v);
    if area != 0.0 {
        let (s, t) = (cross(w, v) / area, cross(w, u) / area);
        if (0.0..=1.0).contains(&s) && (0.0..=1.0).contains(&t) {
            return 0.0;
        }
    }
    point_gap(a, c, d).min(point_gap(b, c, d)).min(point_gap(c, a, b)).min(point_gap(d, a, b))
}

fn point_gap(p: Point, a: Point, b: Point) -> f64 {
    let (along, to) = (minus(b, a), minus(p, a));
    let length_squared = dot(along, along);
    let share = if length_squared > 0.0 { (dot(along, to) / length_squared).clamp(0.0, 1.0) } else { 0.0 };
    let nearest = [a[0] + share * along[0], a[1] + share * along[1]];
    (p[0] - nearest[0]).hypot(p[1] - nearest[1])
}

fn minus(a: Point, b: Point) -> Point {
    [a[0] - b[0], a[1] - b[1]]
}

fn dot(a: Point, b: Point) -> f64 {
    a[0] * b[0] + a[1] * b[1]
}

fn cross(a: Point, b: Point) -> f64 {
    a[0] * b[1] - a[1] * b[0]
}

#[test]
fn clearances_of_plain_cases() {
    let dot = Body { outline: vec![[3.0, 4.0]], radius: 1.0 };
    assert!((clearance([0.0, 0.0], [0.0, 0.0], &dot) - 4.0).abs() < 1e-12);
    assert!((clearance([0.0, 4.0], [1.0, 4.0], &dot) - 1.0).abs() < 1e-12);
    assert!(clearance([0.0, 4.0], [5.0, 4.0], &dot) <= -1.0);
    let square = Body { outline: vec![[0.0, 0.0], [2.0, 0.0], [2.0, 2.0], [0.0, 2.0]], radius: 0.0 };
    assert_eq!(clearance([1.0, 1.0], [1.0, 1.0], &square), 0.0);
    assert!((clearance([3.0, 1.0], [4.0, 1.0], &square) - 1.0).abs() < 1e-12);
    assert_eq!(clearance([-1.0, 1.0], [3.0, 1.0], &square), 0.0);
}
