//! The scene repeated as coloured points: path, stops and the true outlines of obstacles.

use super::scene;
use crate::claims::dimibot::{DimibotObstacleBody, DimibotOrder};
use crate::device::dimibot::DimibotFacts;
use crate::emit::dimibot::motion;
use crate::emit::mcap::LogTopic;
use crate::emit::mcap::cloud::{CIRCLE_CORNERS, Stroke, circle, cloud, outlines, rectangle};
use crate::emit::mcap::drawing::{self, color};
use crate::emit::mcap::foxglove::{self, PointCloud};
use crate::schedule::PlanRecord;
use crate::verify::Verified;
use nalgebra::Point2;

/// Number of obstacles above which circles are small and get fewer corners.
const MANY_OBSTACLES: usize = 500;

const COARSE_CORNERS: usize = 8;

/// `/<device>/scene/points` and `/<device>/plan/points`.
pub fn topics(verified: &Verified, device: &str) -> [LogTopic; 2] {
    let scene = |(t_ns, order)| (t_ns, foxglove::encode(&cloud(&scenery(order), device, t_ns)));
    let plan = |(order, plan): (&DimibotOrder, &PlanRecord)| {
        (plan.start_ns, foxglove::encode(&cloud(&plan_strokes(order, plan), device, plan.start_ns)))
    };
    let scenes = motion::sceneries(verified, device).into_iter().map(scene).collect();
    let plans = motion::jobs(verified, device).into_iter().map(plan).collect();
    [
        LogTopic::new::<PointCloud>(format!("/{device}/scene/points"), scenes),
        LogTopic::new::<PointCloud>(format!("/{device}/plan/points"), plans),
    ]
}

/// Outline of the tip in its own frame, or of its mark if the tip is narrower.
pub fn tip(facts: &DimibotFacts) -> Stroke {
    let radius_um = facts.tip_radius_um.max(scene::TIP_MARK_UM / 2.0);
    Stroke { corners: circle(Point2::origin(), radius_um, CIRCLE_CORNERS), color: color::TIP }
}

fn plan_strokes(order: &DimibotOrder, plan: &PlanRecord) -> Vec<Stroke> {
    let path = plan.states.iter().map(|state| {
        let [x, y, _] = motion::place(state);
        Point2::new(x, y)
    });
    let stops = scene::stops(order).into_iter().map(|cell| {
        let centre = Point2::from(order.facts.place_um(cell));
        Stroke { corners: circle(centre, scene::STOP_UM / 2.0, CIRCLE_CORNERS), color: color::STOP }
    });
    std::iter::once(Stroke { corners: path.collect(), color: color::PATH }).chain(stops).collect()
}

fn scenery(order: &DimibotOrder) -> Vec<Stroke> {
    let facts = &order.facts;
    let [x, y] = facts.place_um(motion::last_cell(facts));
    let mut strokes = vec![Stroke { corners: rectangle([0.0, 0.0], [x, y]), color: color::LATTICE }];
    let corners = if order.obstacles.len() > MANY_OBSTACLES { COARSE_CORNERS } else { CIRCLE_CORNERS };
    for obstacle in scene::drawn(order) {
        let lines = match &*obstacle.body.seen_from(order.frame.as_ref()) {
            DimibotObstacleBody::Cells { from, to } => {
                let (low, high) = motion::tiles_um(facts, *from, *to);
                vec![rectangle(low, high)]
            }
            // The checker refuses shapes that cannot be placed; one that slips through is just not drawn.
            DimibotObstacleBody::Solid { shape, pose } => {
                shape.grown(pose, 0.0).map_or_else(|_| Vec::new(), |body| outlines(&drawing::on_grid(body), corners))
            }
        };
        strokes.extend(lines.into_iter().map(|corners| Stroke { corners, color: color::OBSTACLE }));
    }
    strokes
}
