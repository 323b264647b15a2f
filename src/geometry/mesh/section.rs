//! Section of a closed surface with a plane.
//!
//! Input: a mesh and the axes of a plane through the origin. Output: closed polylines, counter-clockwise, without the
//! degenerate ones of a plane that only touches. Promise: a point of a polyline is the same whichever of its
//! triangles it is computed from; linear cost except for sorting.

use super::surface::edges;
use super::{Mesh, cross, dot};
use crate::real::Real;

/// Least area enclosed by a polyline, as a share of the square of its length.
const LEAST_AREA: f64 = 1e-12;

/// Distance from a plane, as a share of the greatest coordinate, that is within the rounding of 32-bit floats: such
/// vertices are on the plane.
const SAME_HEIGHT: f64 = 1e-7;

/// A triangle that the plane cuts: the edges where the section enters and leaves it.
struct Cut {
    enter: [u32; 2],
    leave: [u32; 2],
}

pub(super) fn loops(mesh: &Mesh, axes: [[f64; 3]; 2]) -> Vec<Vec<[f64; 2]>> {
    let normal = cross(axes[0], axes[1]);
    let reach_um = mesh.vertices_um.iter().flatten().map(|um| um.abs()).fold(0.0, f64::max);
    let snapped = |height: f64| if height.abs() <= SAME_HEIGHT * reach_um { 0.0 } else { height };
    let heights: Vec<f64> = mesh.vertices_um.iter().map(|vertex| snapped(dot(*vertex, normal))).collect();
    let mut cuts: Vec<Cut> = mesh.triangles.iter().filter_map(|triangle| cut(*triangle, &heights)).collect();
    cuts.sort_unstable_by_key(|cut| cut.enter);
    let mut is_done = vec![false; cuts.len()];
    let mut loops = Vec::new();
    for start in 0..cuts.len() {
        let (mut at, mut line) = (start, Vec::new());
        while !is_done[at] {
            is_done[at] = true;
            line.push(crossing(mesh, axes, &heights, cuts[at].enter));
            // The surface is closed, so the triangle beyond is cut too.
            let Ok(next) = cuts.binary_search_by_key(&cuts[at].leave, |cut| cut.enter) else { break };
            at = next;
        }
        loops.extend(tidied(line));
    }
    loops
}

/// In a triangle seen from outside, one edge goes up through the plane and one goes down; in its neighbours the
/// directions are reversed.
fn cut(triangle: [u32; 3], heights: &[f64]) -> Option<Cut> {
    let is_above = |vertex: u32| heights[vertex as usize] >= 0.0;
    let through =
        |above: bool| edges(triangle).into_iter().find(|[from, to]| is_above(*from) != above && is_above(*to) == above);
    let sorted = |[from, to]: [u32; 2]| [from.min(to), from.max(to)];
    Some(Cut { enter: sorted(through(true)?), leave: sorted(through(false)?) })
}

/// The point where an edge, its lower vertex first, meets the plane.
fn crossing(mesh: &Mesh, axes: [[f64; 3]; 2], heights: &[f64], [from, to]: [u32; 2]) -> [f64; 2] {
    let [from, to] = [from as usize, to as usize];
    let share = heights[from] / (heights[from] - heights[to]);
    axes.map(|axis| {
        let [low, high] = [dot(mesh.vertices_um[from], axis), dot(mesh.vertices_um[to], axis)];
        if share == 1.0 { high } else { low + share * (high - low) }
    })
}

/// A polyline without repeated points, counter-clockwise; `None` if it encloses nothing.
fn tidied(mut line: Vec<[f64; 2]>) -> Option<Vec<[f64; 2]>> {
    line.dedup();
    while line.len() > 1 && line.first() == line.last() {
        line.pop();
    }
    let area = |a: [f64; 2], b: [f64; 2], c: [f64; 2]| (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
    let twice: f64 = line.windows(2).map(|pair| area(line[0], pair[0], pair[1])).sum();
    if twice < 0.0 {
        line.reverse();
    }
    let around: f64 = line.windows(2).map(|pair| (pair[1][0] - pair[0][0]).hypotenuse(pair[1][1] - pair[0][1])).sum();
    (line.len() > 2 && twice.abs() > LEAST_AREA * around * around).then_some(line)
}
