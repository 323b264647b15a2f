//! Lines as coloured points.
//!
//! Rerun 0.41 shows point clouds but no `SceneUpdate`, and without points it does not open a 3D view on its own.

use super::drawing;
use super::foxglove::{self, Color, PackedElementField, PointCloud, packed_element_field::NumericType};
use crate::geometry::shape::{Core, Rounded};
use crate::real::Real;
use nalgebra::{Point2, Point3};

/// Distance of neighbouring points, in micrometres, unless there would be too many.
const STEP_UM: f64 = 0.05;

/// Approximate limit of points in a cloud.
const MAX_POINTS: f64 = 50_000.0;

/// Corners of a polygon that stands for a circle.
pub const CIRCLE_CORNERS: usize = 48;

/// A line through corners, of one colour.
pub struct Stroke {
    pub corners: Vec<Point2<f64>>,
    pub color: Color,
}

/// A line through corners in space, of one colour.
#[derive(Clone)]
pub struct SpaceStroke {
    pub corners: Vec<Point3<f64>>,
    pub color: Color,
}

impl From<&Stroke> for SpaceStroke {
    /// In the plane z = 0.
    fn from(stroke: &Stroke) -> SpaceStroke {
        let corners = stroke.corners.iter().map(|corner| Point3::new(corner.x, corner.y, 0.0)).collect();
        SpaceStroke { corners, color: stroke.color }
    }
}

pub fn rectangle([x0, y0]: [f64; 2], [x1, y1]: [f64; 2]) -> Vec<Point2<f64>> {
    ring([[x0, y0], [x1, y0], [x1, y1], [x0, y1]].map(Point2::from).to_vec())
}

pub fn outlines(body: &Rounded, corners: usize) -> Vec<Vec<Point2<f64>>> {
    match &body.core {
        Core::Point(centre) => vec![circle(*centre, body.radius_um, corners)],
        Core::Segment([a, b]) => {
            let across = (b - a).try_normalize(0.0).map(|along| nalgebra::Vector2::new(-along.y, along.x));
            let across = across.unwrap_or_default() * body.radius_um;
            let sides = [vec![a + across, b + across], vec![a - across, b - across]];
            let ends = [circle(*a, body.radius_um, corners), circle(*b, body.radius_um, corners)];
            sides.into_iter().chain(ends).collect()
        }
        Core::Polygon(core) => vec![ring(core.clone())],
    }
}

pub fn circle(centre: Point2<f64>, radius_um: f64, corners: usize) -> Vec<Point2<f64>> {
    let corner = |index: usize| {
        let angle = index as f64 * std::f64::consts::TAU / corners as f64;
        drawing::snap(centre + nalgebra::Vector2::new(angle.cosine(), angle.sine()) * radius_um)
    };
    ring((0..corners).map(corner).collect())
}

/// Closes a line.
fn ring(mut corners: Vec<Point2<f64>>) -> Vec<Point2<f64>> {
    corners.extend(corners.first().copied());
    corners
}

pub fn cloud(strokes: &[Stroke], device: &str, t_ns: u64) -> PointCloud {
    spaced_cloud(strokes, device, t_ns, STEP_UM)
}

/// A cloud with at least this spacing of neighbouring points; wider if there would be too many.
pub fn spaced_cloud(strokes: &[Stroke], device: &str, t_ns: u64, least_step_um: f64) -> PointCloud {
    space_cloud(&strokes.iter().map(SpaceStroke::from).collect::<Vec<_>>(), device, t_ns, least_step_um)
}

/// As [`spaced_cloud`], in space and in any frame.
pub fn space_cloud(strokes: &[SpaceStroke], frame: &str, t_ns: u64, least_step_um: f64) -> PointCloud {
    let lengths =
        strokes.iter().flat_map(|stroke| stroke.corners.windows(2)).map(|pair| nalgebra::distance(&pair[0], &pair[1]));
    let step_um = (lengths.sum::<f64>() / MAX_POINTS).max(least_step_um);
    let mut data = Vec::new();
    for SpaceStroke { corners, color } in strokes {
        let rgba = [color.r, color.g, color.b, color.a].map(|part| (part * 255.0).round() as u8);
        let mut add = |point: Point3<f64>| {
            let [x, y, z] = [point.x, point.y, point.z].map(|value| (value as f32).to_le_bytes());
            data.extend_from_slice([x, y, z, rgba].as_flattened());
        };
        for pair in corners.windows(2) {
            let parts = (nalgebra::distance(&pair[0], &pair[1]) / step_um).ceil().max(1.0) as usize;
            (0..parts).for_each(|part| add(pair[0] + (pair[1] - pair[0]) * (part as f64 / parts as f64)));
        }
        corners.last().copied().into_iter().for_each(&mut add);
    }
    let field = |name: &str, offset, numeric: NumericType| PackedElementField {
        name: name.to_owned(),
        offset,
        r#type: numeric as i32,
    };
    let places = ["x", "y", "z"].into_iter().zip([0, 4, 8]).map(|(name, at)| field(name, at, NumericType::Float32));
    let colors = ["red", "green", "blue", "alpha"].into_iter().zip(12..);
    let colors = colors.map(|(name, at)| field(name, at, NumericType::Uint8));
    PointCloud {
        timestamp: foxglove::timestamp(t_ns),
        frame_id: frame.to_owned(),
        pose: foxglove::pose_at([0.0; 3]),
        point_stride: 16,
        fields: places.chain(colors).collect(),
        data: data.into(),
    }
}
