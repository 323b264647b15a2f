//! Conditions for a closed surface of triangles, and its volume.
//!
//! Input: the corners of triangles. Output: vertices, joined where they coincide, and triangles that face outwards.
//! Promise: each edge belongs to two triangles, which traverse it in opposite directions.

use super::{BLOCK, MAX_TRIANGLES, MAX_UM, Mesh, MeshError, cross, dot, minus};
use crate::real::Real;

/// Least volume, as a share of the volume of a cube around the mesh.
const LEAST_VOLUME: f64 = 1e-9;

pub(super) fn joined(corners_um: &[[[f64; 3]; 3]]) -> Result<Mesh, MeshError> {
    if corners_um.is_empty() {
        return Err(MeshError::Empty);
    }
    if corners_um.len() > MAX_TRIANGLES {
        return Err(MeshError::TooManyTriangles(corners_um.len()));
    }
    // NaN fails this test too.
    let is_sound = |corners: &[[f64; 3]; 3]| corners.iter().flatten().all(|number| number.abs() <= MAX_UM);
    if let Some(triangle) = corners_um.iter().position(|corners| !is_sound(corners)) {
        return Err(MeshError::Number { triangle });
    }
    let has_area = |[a, b, c]: &[[f64; 3]; 3]| cross(minus(*b, *a), minus(*c, *a)) != [0.0; 3];
    if let Some(triangle) = corners_um.iter().position(|corners| !has_area(corners)) {
        return Err(MeshError::ZeroArea { triangle });
    }
    let mut mesh = indexed(corners_um);
    closed(&mesh)?;
    let extent_um = mesh.bounds_um();
    let cube_um3 = (0..3).map(|axis| extent_um[1][axis] - extent_um[0][axis]).fold(0.0, f64::max).whole_power(3);
    let volume_um3 = mesh.volume_um3();
    if volume_um3.abs() <= LEAST_VOLUME * cube_um3 {
        return Err(MeshError::NoVolume);
    }
    if volume_um3 < 0.0 {
        mesh.triangles.iter_mut().for_each(|triangle| triangle.swap(1, 2));
    }
    Ok(mesh)
}

/// Joins coinciding corners; the vertices are sorted by their coordinates.
fn indexed(corners_um: &[[[f64; 3]; 3]]) -> Mesh {
    // Adding 0 makes -0 and 0 the same place.
    let place = |at: usize| corners_um[at / 3][at % 3].map(|number| number + 0.0);
    let order = |a: &[f64; 3], b: &[f64; 3]| a.partial_cmp(b).unwrap_or(std::cmp::Ordering::Equal);
    let mut sorted: Vec<usize> = (0..3 * corners_um.len()).collect();
    sorted.sort_by(|a, b| order(&place(*a), &place(*b)));
    let mut vertices_um: Vec<[f64; 3]> = Vec::new();
    let mut triangles = vec![[0; 3]; corners_um.len()];
    for at in sorted {
        if vertices_um.last() != Some(&place(at)) {
            vertices_um.push(place(at));
        }
        triangles[at / 3][at % 3] = (vertices_um.len() - 1) as u32;
    }
    let blocks_um = corners_um.chunks(BLOCK).map(|block| bounds(block.iter().flatten().copied())).collect();
    Mesh { vertices_um, triangles, blocks_um }
}

/// The three edges of a triangle, in its orientation.
pub(super) fn edges([a, b, c]: [u32; 3]) -> [[u32; 2]; 3] {
    [[a, b], [b, c], [c, a]]
}

/// Checks that each edge is traversed once in each direction.
fn closed(mesh: &Mesh) -> Result<(), MeshError> {
    let mut all: Vec<([u32; 2], bool)> = Vec::with_capacity(3 * mesh.triangles.len());
    for [from, to] in mesh.triangles.iter().flat_map(|triangle| edges(*triangle)) {
        all.push(([from.min(to), from.max(to)], from < to));
    }
    all.sort_unstable();
    let (mut open, mut tangled) = (Vec::new(), Vec::new());
    for group in all.chunk_by(|a, b| a.0 == b.0) {
        match group {
            [_] => open.push(group[0].0),
            [one, other] if one.1 != other.1 => {}
            _ => tangled.push(group[0].0),
        }
    }
    let middle = |[a, b]: [u32; 2]| {
        [0, 1, 2].map(|axis| f64::midpoint(mesh.vertices_um[a as usize][axis], mesh.vertices_um[b as usize][axis]))
    };
    match (open.first(), tangled.first()) {
        (Some(edge), _) => Err(MeshError::Open { edges: open.len(), at_um: middle(*edge) }),
        (None, Some(edge)) => Err(MeshError::Tangled { edges: tangled.len(), at_um: middle(*edge) }),
        (None, None) => Ok(()),
    }
}

/// Sums the signed tetrahedra from one vertex to all triangles.
pub(super) fn volume_and_centre(mesh: &Mesh) -> (f64, [f64; 3]) {
    let apex = mesh.vertices_um[0];
    let (mut volume, mut moment) = (0.0, [0.0; 3]);
    for corners in mesh.corners() {
        let [a, b, c] = corners.map(|corner| minus(corner, apex));
        let part = dot(a, cross(b, c)) / 6.0;
        volume += part;
        (0..3).for_each(|axis| moment[axis] += part * (a[axis] + b[axis] + c[axis]) / 4.0);
    }
    (volume, [0, 1, 2].map(|axis| apex[axis] + moment[axis] / volume))
}

/// Bounding box of some points: the least and the greatest coordinates.
pub(super) fn bounds(places_um: impl Iterator<Item = [f64; 3]>) -> [[f64; 3]; 2] {
    places_um.fold([[f64::INFINITY; 3], [f64::NEG_INFINITY; 3]], |[low, high], place| {
        [[0, 1, 2].map(|axis| low[axis].min(place[axis])), [0, 1, 2].map(|axis| high[axis].max(place[axis]))]
    })
}

/// The square of the distance of a point from a box.
pub(super) fn box_square([low, high]: [[f64; 3]; 2], point: [f64; 3]) -> f64 {
    let off = |axis: usize| (low[axis] - point[axis]).max(point[axis] - high[axis]).max(0.0).whole_power(2);
    off(0) + off(1) + off(2)
}

/// The square of the distance of a point from a triangle: from its plane if the foot is inside, otherwise from the
/// nearest side.
pub(super) fn square([a, b, c]: [[f64; 3]; 3], point: [f64; 3]) -> f64 {
    let normal = cross(minus(b, a), minus(c, a));
    let is_inside = |from: [f64; 3], to: [f64; 3]| dot(cross(minus(to, from), minus(point, from)), normal) >= 0.0;
    if is_inside(a, b) && is_inside(b, c) && is_inside(c, a) {
        return dot(minus(point, a), normal).whole_power(2) / dot(normal, normal);
    }
    side_square(a, b, point).min(side_square(b, c, point)).min(side_square(c, a, point))
}

fn side_square(from: [f64; 3], to: [f64; 3], point: [f64; 3]) -> f64 {
    let (along, off) = (minus(to, from), minus(point, from));
    let share = (dot(off, along) / dot(along, along)).clamp(0.0, 1.0);
    let gap = [0, 1, 2].map(|axis| off[axis] - share * along[axis]);
    dot(gap, gap)
}
