//! The part of a hand in its own frame, as drawn: its sections, and the surface between them if that is known.

use crate::claims::fingers::{HandPart, Section};
use crate::device::fingers::Plane;
use crate::emit::fingers::motion::corners;
use crate::emit::mcap::drawing;
use crate::emit::mcap::foxglove::{
    self, Color, Point3, SceneEntity, SpherePrimitive, TriangleListPrimitive, Vector3, line_primitive,
};
use crate::geometry::outline::Outline;
use nalgebra::Point2;

/// Colour of the translucent surface.
const SURFACE: Color = Color { r: 0.34, g: 0.71, b: 0.91, a: 0.35 };

/// The colour of a section.
pub fn color_of(plane: Plane) -> Color {
    match plane {
        Plane::Xy => drawing::color::START,
        Plane::Xz => drawing::color::STOP,
    }
}

/// A point of a section in the part's frame, snapped to the grid of pictures.
pub fn in_space(plane: Plane, [first, second]: [f64; 2]) -> [f64; 3] {
    let axes = plane.axes();
    [0, 1, 2].map(|axis| drawing::snapped(axes[0][axis] * first + axes[1][axis] * second) + 0.0)
}

/// The outlines of a part in its frame, each with its plane.
pub fn outlines(part: &HandPart) -> Vec<(Plane, Vec<[f64; 3]>)> {
    let sections = Plane::ALL.into_iter().filter_map(|plane| Some((plane, part.section(plane)?)));
    let outline = |(plane, section): (Plane, &Section)| {
        (plane, corners(section).into_iter().map(|corner| in_space(plane, corner)).collect())
    };
    sections.map(outline).collect()
}

/// Draws a part: a solid if its sections are those of an ellipsoid, else the faces that they cut; and their outlines.
pub fn draw(entity: &mut SceneEntity, part: &HandPart) {
    match semi_axes_um(part) {
        Some([x, y, z]) => entity.spheres.push(SpherePrimitive {
            pose: foxglove::pose_at([0.0; 3]),
            size: Some(Vector3 { x: 2.0 * x, y: 2.0 * y, z: 2.0 * z }),
            color: Some(SURFACE),
        }),
        None => Plane::ALL.into_iter().for_each(|plane| face(entity, part, plane)),
    }
    for (plane, outline) in outlines(part) {
        drawing::line(entity, outline, line_primitive::Type::LineLoop, color_of(plane));
    }
}

/// Semi-axes of the part if its sections are those of an ellipsoid.
fn semi_axes_um(part: &HandPart) -> Option<[f64; 3]> {
    let Outline::Ellipse { semi_um: [x, y] } = part.xy.outline else { return None };
    let Outline::Ellipse { semi_um: [other_x, z] } = part.xz.as_ref()?.outline else { return None };
    (x == other_x).then_some([x, y, z])
}

/// Fills a section.
fn face(entity: &mut SceneEntity, part: &HandPart, plane: Plane) {
    let Some(section) = part.section(plane) else { return };
    let corners: Vec<Point2<f64>> = corners(section).into_iter().map(|corner| drawing::snap(corner.into())).collect();
    let point = |corner: &Point2<f64>| {
        let [x, y, z] = in_space(plane, [corner.x, corner.y]);
        Point3 { x, y, z }
    };
    entity.triangles.push(TriangleListPrimitive {
        pose: foxglove::pose_at([0.0; 3]),
        points: drawing::triangles(&corners).iter().flatten().map(point).collect(),
        color: Some(Color { a: SURFACE.a, ..color_of(plane) }),
        ..TriangleListPrimitive::default()
    });
}
