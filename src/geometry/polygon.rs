//! Checks that a list of corners is the outline of a simple polygon.

use nalgebra::{Point2, Vector2};

/// Fault of an outline; corners are counted from 1.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum PolygonFault {
    TooFewCorners,
    /// This corner and the next one coincide.
    RepeatedCorner(usize),
    /// The sides that begin at these two corners touch or cross.
    Crossing(usize, usize),
    /// All corners lie on one line.
    NoArea,
}

/// The first fault of an outline, if it has one. Checks every pair of sides.
pub fn fault(corners: &[[f64; 2]]) -> Option<PolygonFault> {
    if corners.len() < 3 {
        return Some(PolygonFault::TooFewCorners);
    }
    let corners: Vec<Point2<f64>> = corners.iter().map(|&[x, y]| Point2::new(x, y)).collect();
    if corners.iter().all(|corner| cross(corners[1] - corners[0], corner - corners[0]) == 0.0)
        && corners[0] != corners[1]
    {
        return Some(PolygonFault::NoArea);
    }
    let count = corners.len();
    let side = |index: usize| (corners[index], corners[(index + 1) % count]);
    if let Some(twice) = (0..count).find(|&corner| side(corner).0 == side(corner).1) {
        return Some(PolygonFault::RepeatedCorner(twice + 1));
    }
    for a in 0..count {
        for b in a + 1..count {
            let neighbours = b == a + 1 || (a == 0 && b == count - 1);
            let meet = if neighbours { folds_back(&corners, a, b) } else { touch(side(a), side(b)) };
            if meet {
                return Some(PolygonFault::Crossing(a + 1, b + 1));
            }
        }
    }
    None
}

fn cross(a: Vector2<f64>, b: Vector2<f64>) -> f64 {
    a.x * b.y - a.y * b.x
}

/// Whether two sides with a common corner lie on one another.
fn folds_back(corners: &[Point2<f64>], a: usize, b: usize) -> bool {
    let count = corners.len();
    let (shared, one, other) = if b == a + 1 {
        (corners[b], corners[a], corners[(b + 1) % count])
    } else {
        (corners[a], corners[b], corners[a + 1])
    };
    let (u, v) = (one - shared, other - shared);
    cross(u, v) == 0.0 && u.dot(&v) > 0.0
}

/// Whether two closed segments have a point in common.
fn touch(a: (Point2<f64>, Point2<f64>), b: (Point2<f64>, Point2<f64>)) -> bool {
    let side = |p: Point2<f64>, s: (Point2<f64>, Point2<f64>)| cross(s.1 - s.0, p - s.0);
    let (b0, b1) = (side(b.0, a), side(b.1, a));
    let (a0, a1) = (side(a.0, b), side(a.1, b));
    if b0 * b1 < 0.0 && a0 * a1 < 0.0 {
        return true;
    }
    let on = |p: Point2<f64>, s: (Point2<f64>, Point2<f64>), turn: f64| turn == 0.0 && (p - s.0).dot(&(p - s.1)) <= 0.0;
    on(b.0, a, b0) || on(b.1, a, b1) || on(a.0, b, a0) || on(a.1, b, a1)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn outlines_are_told_apart() {
        let square = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]];
        let bow_tie = [[0.0, 0.0], [1.0, 1.0], [1.0, 0.0], [0.0, 1.0]];
        let spike = [[0.0, 0.0], [2.0, 0.0], [1.0, 0.0], [1.0, 1.0]];
        let line = [[0.0, 0.0], [1.0, 1.0], [2.0, 2.0]];
        let twice = [[0.0, 0.0], [1.0, 0.0], [1.0, 0.0], [0.0, 1.0]];
        let arrow = [[0.0, 0.0], [2.0, 1.0], [0.0, 2.0], [1.0, 1.0]];
        assert_eq!(fault(&square), None);
        assert_eq!(fault(&arrow), None);
        assert_eq!(fault(&square[..2]), Some(PolygonFault::TooFewCorners));
        assert_eq!(fault(&line), Some(PolygonFault::NoArea));
        assert_eq!(fault(&twice), Some(PolygonFault::RepeatedCorner(2)));
        assert_eq!(fault(&bow_tie), Some(PolygonFault::Crossing(1, 3)));
        assert_eq!(fault(&spike), Some(PolygonFault::Crossing(1, 2)));
    }
}
