//! Shapes as primitives that viewers draw.

use super::foxglove::{
    self, ArrowPrimitive, Color, CubePrimitive, CylinderPrimitive, LinePrimitive, Point3, SceneEntity,
    SceneEntityDeletion, SpherePrimitive, TextPrimitive, TriangleListPrimitive, Vector3, line_primitive,
    scene_entity_deletion,
};
use crate::geometry::shape::{Core, Rounded};
use nalgebra::{Point2, Vector2};

/// Colours of pictures, distinguishable for the colour-blind (after Okabe and Ito) and on dark and light ground.
pub mod color {
    use super::Color;

    pub const OBSTACLE: Color = Color { r: 0.84, g: 0.37, b: 0.0, a: 1.0 };
    pub const GROWN: Color = Color { r: 0.96, g: 0.78, b: 0.62, a: 1.0 };
    pub const LATTICE: Color = Color { r: 0.6, g: 0.6, b: 0.6, a: 1.0 };
    pub const PATH: Color = Color { r: 0.34, g: 0.71, b: 0.91, a: 1.0 };
    pub const START: Color = Color { r: 0.8, g: 0.47, b: 0.65, a: 1.0 };
    pub const STOP: Color = Color { r: 0.0, g: 0.62, b: 0.45, a: 1.0 };
    pub const TIP: Color = Color { r: 0.94, g: 0.89, b: 0.26, a: 1.0 };

    /// Colours that are cycled through by items of one sort.
    const TURNS: [Color; 6] = [
        Color { r: 0.34, g: 0.71, b: 0.91, a: 1.0 },
        Color { r: 0.9, g: 0.62, b: 0.0, a: 1.0 },
        Color { r: 0.0, g: 0.62, b: 0.45, a: 1.0 },
        Color { r: 0.8, g: 0.47, b: 0.65, a: 1.0 },
        Color { r: 0.0, g: 0.45, b: 0.7, a: 1.0 },
        Color { r: 0.94, g: 0.89, b: 0.26, a: 1.0 },
    ];

    /// The colour of an item of a sort, by its index.
    pub fn in_turn(index: usize) -> Color {
        TURNS[index % TURNS.len()]
    }
}

/// Greatest number of corners of a filled polygon; the cost of filling is quadratic in it.
const MAX_FILLED_CORNERS: usize = 2000;

/// Diameter of the mark for an object without extent, in micrometres.
const MARK_UM: f64 = 0.06;

/// A slab of a colour, from `bottom_um` up.
#[derive(Clone, Copy)]
pub struct Slab {
    pub bottom_um: f64,
    pub height_um: f64,
    pub color: Color,
}

/// An empty entity.
pub fn entity(id: String, frame: &str, t_ns: u64) -> SceneEntity {
    SceneEntity {
        timestamp: foxglove::timestamp(t_ns),
        frame_id: frame.to_owned(),
        id,
        frame_locked: true,
        ..SceneEntity::default()
    }
}

/// Removes an entity.
pub fn deletion(id: &str, t_ns: u64) -> SceneEntityDeletion {
    SceneEntityDeletion {
        timestamp: foxglove::timestamp(t_ns),
        r#type: scene_entity_deletion::Type::MatchingId as i32,
        id: id.to_owned(),
    }
}

/// Adds a rounded body: cylinders at the corners, boxes along the edges, and the inside.
pub fn body(entity: &mut SceneEntity, body: &Rounded, slab: Slab) {
    let radius_um = body.radius_um;
    match &body.core {
        Core::Point(point) if radius_um == 0.0 => {
            sphere(entity, [point.x, point.y, slab.bottom_um], MARK_UM, slab.color)
        }
        Core::Point(point) => disc(entity, *point, radius_um, slab),
        Core::Segment([a, b]) => {
            disc(entity, *a, radius_um, slab);
            disc(entity, *b, radius_um, slab);
            bar(entity, *a, *b, radius_um, slab);
        }
        Core::Polygon(corners) => {
            for (a, b) in edges(corners) {
                disc(entity, a, radius_um, slab);
                bar(entity, a, b, radius_um, slab);
            }
            prism(entity, corners, slab);
        }
    }
}

/// Grid steps per micrometre for turned shapes. The last bits of sines differ between machines, and those of a log must
/// not.
const GRID_PER_UM: f64 = 1e6;

/// A body with its points snapped to a grid of one picometre.
pub fn on_grid(body: Rounded) -> Rounded {
    let core = match body.core {
        Core::Point(point) => Core::Point(snap(point)),
        Core::Segment(ends) => Core::Segment(ends.map(snap)),
        Core::Polygon(corners) => Core::Polygon(corners.into_iter().map(snap).collect()),
    };
    Rounded { core, ..body }
}

/// The nearest grid point.
pub fn snap(point: Point2<f64>) -> Point2<f64> {
    point.map(snapped)
}

/// The nearest grid coordinate.
pub fn snapped(value: f64) -> f64 {
    (value * GRID_PER_UM).round() / GRID_PER_UM
}

/// The largest y of a body.
pub fn top_um(body: &Rounded) -> f64 {
    body.core.corners().iter().map(|point| point.y).fold(f64::NEG_INFINITY, f64::max) + body.radius_um
}

/// Adds an upright cylinder.
pub fn disc(entity: &mut SceneEntity, centre: Point2<f64>, radius_um: f64, slab: Slab) {
    if radius_um <= 0.0 {
        return;
    }
    entity.cylinders.push(CylinderPrimitive {
        pose: foxglove::pose_at([centre.x, centre.y, slab.bottom_um + slab.height_um / 2.0]),
        size: Some(Vector3 { x: 2.0 * radius_um, y: 2.0 * radius_um, z: slab.height_um }),
        bottom_scale: 1.0,
        top_scale: 1.0,
        color: Some(slab.color),
    });
}

/// Adds a box around a segment.
fn bar(entity: &mut SceneEntity, a: Point2<f64>, b: Point2<f64>, radius_um: f64, slab: Slab) {
    let along: Vector2<f64> = b - a;
    if radius_um <= 0.0 || along.norm() == 0.0 {
        return;
    }
    let middle = nalgebra::center(&a, &b);
    entity.cubes.push(CubePrimitive {
        pose: foxglove::turned_pose(
            [middle.x, middle.y, slab.bottom_um + slab.height_um / 2.0],
            (along / along.norm()).into(),
        ),
        size: Some(Vector3 { x: along.norm(), y: 2.0 * radius_um, z: slab.height_um }),
        color: Some(slab.color),
    });
}

/// Adds an upright box between its lower and upper corner.
pub fn cuboid(entity: &mut SceneEntity, low: [f64; 2], high: [f64; 2], slab: Slab) {
    entity.cubes.push(CubePrimitive {
        pose: foxglove::pose_at([
            (low[0] + high[0]) / 2.0,
            (low[1] + high[1]) / 2.0,
            slab.bottom_um + slab.height_um / 2.0,
        ]),
        size: Some(Vector3 { x: high[0] - low[0], y: high[1] - low[1], z: slab.height_um }),
        color: Some(slab.color),
    });
}

/// Adds the walls and the top of a polygon.
pub fn prism(entity: &mut SceneEntity, corners: &[Point2<f64>], slab: Slab) {
    let top = slab.bottom_um + slab.height_um;
    let up = |p: &Point2<f64>| Point3 { x: p.x, y: p.y, z: top };
    let down = |p: &Point2<f64>| Point3 { x: p.x, y: p.y, z: slab.bottom_um };
    let mut points: Vec<Point3> = Vec::new();
    for (a, b) in edges(corners) {
        points.extend([down(&a), down(&b), up(&b), down(&a), up(&b), up(&a)]);
    }
    for triangle in triangles(corners) {
        points.extend(triangle.iter().map(up));
    }
    entity.triangles.push(TriangleListPrimitive {
        pose: foxglove::pose_at([0.0; 3]),
        points,
        color: Some(slab.color),
        ..TriangleListPrimitive::default()
    });
    line(entity, corners.iter().map(|p| [p.x, p.y, top]), line_primitive::Type::LineLoop, slab.color);
}

fn edges(corners: &[Point2<f64>]) -> impl Iterator<Item = (Point2<f64>, Point2<f64>)> {
    corners.iter().copied().zip(corners.iter().copied().cycle().skip(1))
}

/// Triangulates a simple polygon by ear clipping (Meisters, *Polygons have ears*, 1975). A polygon that crosses itself
/// is filled as far as ears are found, and one with too many corners is not filled; the outline is drawn anyway.
pub fn triangles(corners: &[Point2<f64>]) -> Vec<[Point2<f64>; 3]> {
    let mut rest = match corners.len() {
        0..=MAX_FILLED_CORNERS => corners.to_vec(),
        _ => return Vec::new(),
    };
    if edges(&rest).map(|(a, b)| a.coords.perp(&b.coords)).sum::<f64>() < 0.0 {
        rest.reverse();
    }
    let mut triangles = Vec::new();
    while rest.len() >= 3 {
        let Some(ear) = (0..rest.len()).find(|&at| is_ear(&rest, at)) else { break };
        triangles.push(around(&rest, ear));
        rest.remove(ear);
    }
    triangles
}

fn around(corners: &[Point2<f64>], at: usize) -> [Point2<f64>; 3] {
    let count = corners.len();
    [corners[(at + count - 1) % count], corners[at], corners[(at + 1) % count]]
}

/// Whether a corner of a counter-clockwise polygon turns left and no other corner is in its triangle.
fn is_ear(corners: &[Point2<f64>], at: usize) -> bool {
    let [a, b, c] = around(corners, at);
    let left_of = |p: Point2<f64>, q: Point2<f64>, r: Point2<f64>| (q - p).perp(&(r - p));
    let inside = |p: &Point2<f64>| {
        *p != a && *p != b && *p != c && [(a, b), (b, c), (c, a)].iter().all(|&(q, r)| left_of(q, r, *p) >= 0.0)
    };
    left_of(a, b, c) >= 0.0 && !corners.iter().any(inside)
}

/// Adds a line through points, of constant width on the screen.
pub fn line(
    entity: &mut SceneEntity,
    points: impl IntoIterator<Item = [f64; 3]>,
    shape: line_primitive::Type,
    color: Color,
) {
    entity.lines.push(LinePrimitive {
        r#type: shape as i32,
        pose: foxglove::pose_at([0.0; 3]),
        thickness: 2.0,
        scale_invariant: true,
        points: points.into_iter().map(|[x, y, z]| Point3 { x, y, z }).collect(),
        color: Some(color),
        ..LinePrimitive::default()
    });
}

/// Adds an arrow from a point along a vector, as long as the vector.
pub fn arrow(entity: &mut SceneEntity, from: [f64; 3], along: Vector3, diameter_um: f64, color: Color) {
    let length_um = (along.x * along.x + along.y * along.y + along.z * along.z).sqrt();
    if length_um <= 0.0 {
        return;
    }
    let head_um = length_um.min(3.0 * diameter_um);
    entity.arrows.push(ArrowPrimitive {
        pose: foxglove::pointed_pose(from, [along.x, along.y, along.z].map(|part| part / length_um)),
        shaft_length: length_um - head_um,
        shaft_diameter: diameter_um,
        head_length: head_um,
        head_diameter: 2.0 * diameter_um,
        color: Some(color),
    });
}

/// Adds a ball.
pub fn sphere(entity: &mut SceneEntity, centre: [f64; 3], diameter_um: f64, color: Color) {
    entity.spheres.push(SpherePrimitive {
        pose: foxglove::pose_at(centre),
        size: Some(Vector3 { x: diameter_um, y: diameter_um, z: diameter_um }),
        color: Some(color),
    });
}

/// Adds text that faces the viewer, of constant size on the screen.
pub fn text(entity: &mut SceneEntity, place: [f64; 3], text: String, color: Color) {
    entity.texts.push(TextPrimitive {
        pose: foxglove::pose_at(place),
        billboard: true,
        font_size: 12.0,
        scale_invariant: true,
        color: Some(color),
        text,
    });
}

#[cfg(test)]
mod tests {
    use super::*;

    fn area(triangles: &[[Point2<f64>; 3]]) -> f64 {
        triangles.iter().map(|[a, b, c]| (b - a).perp(&(c - a)) / 2.0).sum()
    }

    fn points(list: &[(f64, f64)]) -> Vec<Point2<f64>> {
        list.iter().map(|&(x, y)| Point2::new(x, y)).collect()
    }

    #[test]
    fn triangles_fill_a_polygon_in_either_sense_of_rotation() {
        let mut angle = points(&[(0.0, 0.0), (4.0, 0.0), (4.0, 1.0), (1.0, 1.0), (1.0, 4.0), (0.0, 4.0)]);
        assert_eq!(area(&triangles(&angle)), 7.0);
        assert_eq!(triangles(&angle).len(), 4);
        angle.reverse();
        assert_eq!(area(&triangles(&angle)), 7.0);
    }

    #[test]
    fn a_polygon_that_crosses_itself_ends() {
        assert!(triangles(&points(&[(0.0, 0.0), (2.0, 2.0), (2.0, 0.0), (0.0, 2.0)])).len() <= 2);
        assert!(triangles(&points(&[(0.0, 0.0), (0.0, 0.0), (0.0, 0.0)])).len() <= 1);
    }
}
