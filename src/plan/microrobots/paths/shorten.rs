//! Shortens a free path: corners are removed and moved as long as that makes it shorter and keeps it free.

use super::{PathRequest, SHORTEST_UM};
use crate::device::microrobots::Arm;
use crate::plan::microrobots::free::{self, ArmSegment, joined};
use crate::real::Real;

/// The first and the last step size of a corner.
const STEPS_UM: [f64; 2] = [200.0, 0.5];

/// Most tries.
const MAX_TRIES: usize = 500;

/// Least gain of a move.
const LEAST_GAIN_UM: f64 = 1e-3;

/// A path no longer than the given one. Invalid tries are dropped.
pub(super) fn shortened(request: &PathRequest, way: Vec<ArmSegment>) -> Vec<ArmSegment> {
    let mut corners = corners(request, &way);
    let mut best = (free::length_um(&way), way);
    let mut tries = 0;
    let mut step_um = STEPS_UM[0];
    while step_um >= STEPS_UM[1] && tries < MAX_TRIES {
        if leave_one_out(request, &mut corners, &mut best, &mut tries)
            || move_one(request, &mut corners, &mut best, &mut tries, step_um)
        {
            continue;
        }
        step_um /= 2.0;
    }
    best.1
}

/// The corners of a path, except the first and the last turning centre.
fn corners(request: &PathRequest, way: &[ArmSegment]) -> Vec<[f64; 2]> {
    let mut pose = request.from;
    let mut corners = Vec::new();
    for segment in way {
        pose = request.facts().moved(pose, segment.arm, segment.way_um);
        if segment.arm == Arm::Up {
            corners.push(request.facts().orbit_centre_um(pose));
        }
    }
    let goal_um = request.facts().orbit_centre_um(request.to);
    corners.retain(|corner| (corner[0] - goal_um[0]).hypotenuse(corner[1] - goal_um[1]) > SHORTEST_UM);
    corners
}

/// The path over corners to the goal, ending with the free optimum.
fn over(request: &PathRequest, corners: &[[f64; 2]]) -> Option<Vec<ArmSegment>> {
    let mut pose = request.from;
    let mut way = Vec::with_capacity(2 * corners.len() + 5);
    for corner in corners {
        let leg = request.leg_to(pose, *corner)?;
        pose = request.end(pose, &leg);
        way.extend(leg);
    }
    way.extend(free::shortest(request.facts(), pose, request.to));
    Some(joined(way))
}

/// Whether the corners give a shorter path that is free; it then becomes the best one.
fn improves(request: &PathRequest, corners: &[[f64; 2]], best: &mut (f64, Vec<ArmSegment>), tries: &mut usize) -> bool {
    *tries += 1;
    let Some(way) = over(request, corners) else { return false };
    let length_um = free::length_um(&way);
    let better = length_um < best.0 - LEAST_GAIN_UM && request.is_free(request.from, &way);
    if better {
        *best = (length_um, way);
    }
    better
}

fn leave_one_out(
    request: &PathRequest,
    corners: &mut Vec<[f64; 2]>,
    best: &mut (f64, Vec<ArmSegment>),
    tries: &mut usize,
) -> bool {
    for index in 0..corners.len() {
        let corner = corners.remove(index);
        if improves(request, corners, best, tries) {
            return true;
        }
        corners.insert(index, corner);
    }
    false
}

fn move_one(
    request: &PathRequest,
    corners: &mut [[f64; 2]],
    best: &mut (f64, Vec<ArmSegment>),
    tries: &mut usize,
    step_um: f64,
) -> bool {
    let half = step_um * std::f64::consts::FRAC_1_SQRT_2;
    let moves = [
        [step_um, 0.0],
        [half, half],
        [0.0, step_um],
        [-half, half],
        [-step_um, 0.0],
        [-half, -half],
        [0.0, -step_um],
        [half, -half],
    ];
    let mut moved = false;
    for index in 0..corners.len() {
        let before = corners[index];
        for [dx, dy] in moves {
            corners[index] = [before[0] + dx, before[1] + dy];
            if improves(request, corners, best, tries) {
                moved = true;
                break;
            }
            corners[index] = before;
        }
    }
    moved
}
