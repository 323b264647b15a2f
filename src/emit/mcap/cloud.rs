//! The scene once more as coloured points: path, stops and the true outlines of obstacles.
//!
//! Rerun 0.41 shows clouds of points but no `SceneUpdate`, and without one it opens no view in three dimensions by itself.

use super::foxglove::{self, Color, PackedElementField, PointCloud, packed_element_field::NumericType};
use super::scene::{self, Bench, color};
use super::{Topic, motion};
use crate::check::claims::{Body, DimibotOrder};
use crate::geometry::shape::{Core, Rounded};
use crate::schedule::PlanRecord;
use crate::verify::Verified;
use nalgebra::Point2;

/// Distance of neighbouring points, in micrometres, unless there would be too many.
const STEP_UM: f64 = 0.05;

/// About the most points of a cloud.
const MAX_POINTS: f64 = 50_000.0;

/// Corners of a polygon that stands for a circle.
const CIRCLE_CORNERS: usize = 48;

/// `/<device>/points` for each device.
pub fn topics(verified: &Verified) -> Vec<Topic> {
    let topic = |bench: Bench| {
        let cloud = |(job, plan): (&_, &PlanRecord)| {
            (plan.start_ns, foxglove::encode(&cloud(&strokes(scene::order(job), plan), plan)))
        };
        let messages = scene::jobs(verified, bench.device).into_iter().map(cloud).collect();
        Topic::new::<PointCloud>(format!("/{}/points", bench.device), messages)
    };
    Bench::all(verified).into_iter().map(topic).collect()
}

/// A line through corners, of one colour.
struct Stroke {
    corners: Vec<Point2<f64>>,
    color: Color,
}

fn strokes(order: &DimibotOrder, plan: &PlanRecord) -> Vec<Stroke> {
    let path = plan.states.iter().map(|state| {
        let [x, y, _] = motion::place(state);
        Point2::new(x, y)
    });
    let facts = &order.facts;
    let mut strokes = vec![Stroke { corners: path.collect(), color: color::PATH }];
    strokes.extend(scene::stops(order).map(|stop| {
        let [x, y] = facts.place_um(stop.cell);
        Stroke { corners: circle(Point2::new(x, y), scene::STOP_UM / 2.0), color: color::STOP }
    }));
    for obstacle in order.obstacles.iter() {
        let outlines = match &obstacle.body {
            Body::Cells { from, to } => {
                let ([x0, y0], [x1, y1]) = scene::tiles_um(facts, *from, *to);
                vec![ring([(x0, y0), (x1, y0), (x1, y1), (x0, y1)].map(|(x, y)| Point2::new(x, y)).to_vec())]
            }
            // The checker refuses shapes that cannot be placed; one that slips through is only not drawn.
            Body::Solid { shape, pose } => shape.grown(pose, 0.0).map_or_else(|_| Vec::new(), |body| outlines(&body)),
        };
        strokes.extend(outlines.into_iter().map(|corners| Stroke { corners, color: color::OBSTACLE }));
    }
    let corner = facts.place_um(scene::last_cell(facts));
    let lattice = [[0.0, 0.0], [corner[0], 0.0], corner, [0.0, corner[1]]].map(Point2::from);
    strokes.push(Stroke { corners: ring(lattice.to_vec()), color: color::LATTICE });
    strokes
}

fn outlines(body: &Rounded) -> Vec<Vec<Point2<f64>>> {
    match &body.core {
        Core::Point(centre) => vec![circle(*centre, body.radius_um)],
        Core::Segment([a, b]) => {
            let across = (b - a).try_normalize(0.0).map(|along| nalgebra::Vector2::new(-along.y, along.x));
            let across = across.unwrap_or_default() * body.radius_um;
            let sides = [vec![a + across, b + across], vec![a - across, b - across]];
            let ends = [circle(*a, body.radius_um), circle(*b, body.radius_um)];
            sides.into_iter().chain(ends).collect()
        }
        Core::Polygon(corners) => vec![ring(corners.clone())],
    }
}

fn circle(centre: Point2<f64>, radius_um: f64) -> Vec<Point2<f64>> {
    let corner = |index: usize| {
        let angle = index as f64 * std::f64::consts::TAU / CIRCLE_CORNERS as f64;
        centre + nalgebra::Vector2::new(angle.cos(), angle.sin()) * radius_um
    };
    ring((0..CIRCLE_CORNERS).map(corner).collect())
}

/// Closes a line.
fn ring(mut corners: Vec<Point2<f64>>) -> Vec<Point2<f64>> {
    corners.extend(corners.first().copied());
    corners
}

fn cloud(strokes: &[Stroke], plan: &PlanRecord) -> PointCloud {
    let lengths =
        strokes.iter().flat_map(|stroke| stroke.corners.windows(2)).map(|pair| nalgebra::distance(&pair[0], &pair[1]));
    let step_um = (lengths.sum::<f64>() / MAX_POINTS).max(STEP_UM);
    let mut data = Vec::new();
    for Stroke { corners, color } in strokes {
        let rgba = [color.r, color.g, color.b, color.a].map(|part| (part * 255.0).round() as u8);
        let mut add = |point: Point2<f64>| {
            for value in [point.x as f32, point.y as f32, 0.0] {
                data.extend(value.to_le_bytes());
            }
            data.extend(rgba);
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
        timestamp: foxglove::timestamp(plan.start_ns),
        frame_id: plan.device.clone(),
        pose: foxglove::pose_at([0.0; 3]),
        point_stride: 16,
        fields: places.chain(colors).collect(),
        data: data.into(),
    }
}
