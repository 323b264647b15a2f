//! Share of the area of a goal structure that the robots cover in the end.

use crate::claims::microrobots::{MicrorobotsAction, MicrorobotsOrder};
use crate::geometry::Pose;
use crate::plan::microrobots::strategy::{BodyCorners, body};
use nalgebra::{Isometry2, Point2, Vector2};

/// Shares of the area of the goal structure, from 0 to 1.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct AreaMatch {
    /// Covered by the robots where they stick.
    pub in_place: f64,
    /// Covered once the structure is moved as a whole so that its first two robots match; this shows whether its shape
    /// is right.
    pub of_shape: f64,
}

/// Match of the true final poses with the goals of an order; `None` without goals. `structure` is the motion from the
/// planned place of the structure to its actual one.
pub fn area_match(order: &MicrorobotsOrder, poses: &[Pose], structure: Isometry2<f64>) -> Option<AreaMatch> {
    let goals: Vec<(usize, Pose)> = order
        .steps
        .iter()
        .filter_map(|step| match &step.action {
            MicrorobotsAction::Assemble(docks) => Some(docks),
            MicrorobotsAction::Apply { .. } | MicrorobotsAction::Drive { .. } | MicrorobotsAction::Wait(_) => None,
        })
        .flatten()
        .map(|dock| (dock.robot, dock.goal.pose))
        .collect();
    let at = |robot: usize, pose: Pose| body(order.robot(robot), pose, 0.0);
    let wanted: Vec<BodyCorners> = goals.iter().map(|(robot, goal)| at(*robot, *goal)).collect();
    let found: Vec<BodyCorners> = goals.iter().map(|(robot, _)| at(*robot, poses[*robot])).collect();
    let back = structure.inverse();
    let moved: Vec<BodyCorners> = found.iter().map(|corners| corners.map(|corner| back * corner)).collect();
    (!goals.is_empty()).then(|| AreaMatch { in_place: covered(&wanted, &found), of_shape: covered(&wanted, &moved) })
}

/// Share of the area of some rectangles that others cover; neither set overlaps itself, except within tolerances.
fn covered(wanted: &[BodyCorners], found: &[BodyCorners]) -> f64 {
    let whole: f64 = wanted.iter().map(|corners| area(corners)).sum();
    let common = |one: &BodyCorners| found.iter().map(|other| area(&clipped(one, other))).sum::<f64>().min(area(one));
    wanted.iter().map(common).sum::<f64>() / whole
}

/// The common part of two convex polygons with corners counter-clockwise (Sutherland and Hodgman, 1974).
fn clipped(one: &BodyCorners, other: &BodyCorners) -> Vec<Point2<f64>> {
    let mut left = one.to_vec();
    for (index, from) in other.iter().enumerate() {
        let along: Vector2<f64> = other[(index + 1) % other.len()] - from;
        let inside = |point: &Point2<f64>| along.perp(&(point - from));
        let mut kept = Vec::with_capacity(left.len() + 1);
        for (at, point) in left.iter().enumerate() {
            let next = left[(at + 1) % left.len()];
            let (here, there) = (inside(point), inside(&next));
            if here >= 0.0 {
                kept.push(*point);
            }
            if (here < 0.0) != (there < 0.0) {
                kept.push(point + (next - point) * (here / (here - there)));
            }
        }
        left = kept;
    }
    left
}

fn area(corners: &[Point2<f64>]) -> f64 {
    let doubled =
        |(index, corner): (usize, &Point2<f64>)| corner.coords.perp(&corners[(index + 1) % corners.len()].coords);
    corners.iter().enumerate().map(doubled).sum::<f64>() / 2.0
}

#[cfg(test)]
mod tests {
    use super::*;

    fn rectangle(x: f64, y: f64, turned_rad: f64) -> BodyCorners {
        let place = Isometry2::new(Vector2::new(x, y), turned_rad);
        [(-2.0, -1.0), (2.0, -1.0), (2.0, 1.0), (-2.0, 1.0)].map(|(x, y)| place * Point2::new(x, y))
    }

    #[test]
    fn common_areas_are_those_of_plain_geometry() {
        let one = rectangle(0.0, 0.0, 0.0);
        let common = |other: BodyCorners| area(&clipped(&one, &other));
        assert!((common(one) - 8.0).abs() < 1e-12);
        assert!((common(rectangle(1.0, 0.5, 0.0)) - 4.5).abs() < 1e-12);
        assert!((common(rectangle(0.0, 0.0, std::f64::consts::FRAC_PI_2)) - 4.0).abs() < 1e-12);
        assert_eq!(common(rectangle(9.0, 0.0, 0.3)), 0.0);
        assert!((covered(&[one, rectangle(4.0, 0.0, 0.0)], &[rectangle(2.0, 0.0, 0.0)]) - 0.5).abs() < 1e-12);
    }
}
