//! The scene in three dimensions: obstacles with their true and grown shapes, the lattice, the tip, the path and the
//! stops.
//!
//! Scenery and plan are two topics per device. Since a viewer that jumps in time reads only the last message of each
//! topic, every message contains the whole picture. Scenery is written again when a job has another one.

use super::tip;
use crate::claims::dimibot::{DimibotObstacle, DimibotObstacleBody, DimibotOrder};
use crate::device::dimibot::Side;
use crate::device::dimibot::{DimibotFacts, LatticeCell};
use crate::emit::dimibot::motion::{self, extent_um, jobs, sceneries, tiles_um};
use crate::emit::mcap::LogTopic;
use crate::emit::mcap::drawing::{self, Slab, color};
use crate::emit::mcap::foxglove::{self, SceneEntity, SceneUpdate, line_primitive};
use crate::schedule::PlanRecord;
use crate::verify::Verified;
use std::collections::BTreeSet;

/// Gap between the lattice and its title.
const TITLE_GAP_UM: f64 = 1.25;

/// Heights above the ground, in micrometres: obstacles are upright, illustrations flat.
const OBSTACLE_HEIGHT_UM: f64 = 0.4;
const GROWN_HEIGHT_UM: f64 = 0.02;
const PATH_HEIGHT_UM: f64 = 0.05;
const LABEL_HEIGHT_UM: f64 = 0.6;

/// Distance of a label from its object.
const LABEL_GAP_UM: f64 = 0.3;

/// Diameter of the mark of a stop.
pub const STOP_UM: f64 = 0.12;

/// Diameter of the mark of the tip, which may be narrower.
pub const TIP_MARK_UM: f64 = 0.3;

/// Greatest number of stops and obstacles with labels.
const MAX_LABELS: usize = 200;

/// Greatest number of drawn obstacles and stops.
const MAX_DRAWN: usize = 20_000;

/// `/<device>/scene` and `/<device>/plan`.
pub fn topics(verified: &Verified, device: &str) -> [LogTopic; 2] {
    let mut shown = BTreeSet::new();
    let mut scenes = Vec::new();
    for (t_ns, order) in sceneries(verified, device) {
        let entities = scenery(order, device, t_ns);
        let ids: BTreeSet<String> = entities.iter().map(|entity| entity.id.clone()).collect();
        let gone = shown.difference(&ids).map(|id: &String| drawing::deletion(id, t_ns));
        scenes.push((t_ns, foxglove::encode(&SceneUpdate { deletions: gone.collect(), entities })));
        shown = ids;
    }
    let plan = |(order, plan): (&DimibotOrder, &PlanRecord)| {
        let update = SceneUpdate { deletions: Vec::new(), entities: plan_entities(order, plan) };
        (plan.start_ns, foxglove::encode(&update))
    };
    let plans = jobs(verified, device).into_iter().map(plan).collect();
    [
        LogTopic::new::<SceneUpdate>(format!("/{device}/scene"), scenes),
        LogTopic::new::<SceneUpdate>(format!("/{device}/plan"), plans),
    ]
}

/// The drawn obstacles; a viewer does not show more in reasonable time.
pub fn drawn(order: &DimibotOrder) -> &[DimibotObstacle] {
    &order.obstacles[..order.obstacles.len().min(MAX_DRAWN)]
}

/// The drawn stops.
pub fn stops(order: &DimibotOrder) -> Vec<LatticeCell> {
    motion::stops(order).into_iter().take(MAX_DRAWN).collect()
}

fn scenery(order: &DimibotOrder, device: &str, t_ns: u64) -> Vec<SceneEntity> {
    let new = |what: &str| drawing::entity(format!("{device}/{what}"), device, t_ns);
    let mut entities = vec![lattice(new("lattice"), order, device), tip(device, t_ns, &order.facts)];
    if order.obstacles.len() > MAX_LABELS {
        let mut all = new("obstacles");
        for obstacle in drawn(order) {
            draw_obstacle(&mut all, order, obstacle);
        }
        entities.push(all);
        return entities;
    }
    for obstacle in order.obstacles.iter() {
        let mut entity = new(&format!("obstacle/{}", obstacle.name));
        let place = draw_obstacle(&mut entity, order, obstacle);
        drawing::text(&mut entity, place, obstacle.name.clone(), color::OBSTACLE);
        entities.push(entity);
    }
    entities
}

fn plan_entities(order: &DimibotOrder, plan: &PlanRecord) -> Vec<SceneEntity> {
    let new = |what: &str| drawing::entity(format!("{}/{what}", plan.device), &plan.device, plan.start_ns);
    vec![path(new("path"), plan), mark_stops(new("stops"), order)]
}

fn lattice(mut entity: SceneEntity, order: &DimibotOrder, device: &str) -> SceneEntity {
    let facts = &order.facts;
    let [x, y] = extent_um(facts);
    let corners = [[0.0, 0.0, 0.0], [x, 0.0, 0.0], [x, y, 0.0], [0.0, y, 0.0]];
    drawing::line(&mut entity, corners, line_primitive::Type::LineLoop, color::LATTICE);
    let mut title = format!(
        "{device}: {} x {} cells of {:.3} x {:.3} um",
        facts.cells(Side::Left),
        facts.cells(Side::Right),
        facts.pitch_um(Side::Left),
        facts.pitch_um(Side::Right)
    );
    let (shown, all) = (drawn(order).len(), order.obstacles.len());
    if shown < all {
        title.push_str(&format!(", {shown} of {all} obstacles shown"));
    }
    drawing::text(&mut entity, [x / 2.0, y + TITLE_GAP_UM, 0.0], title, color::LATTICE);
    entity
}

fn path(mut entity: SceneEntity, plan: &PlanRecord) -> SceneEntity {
    let places = plan.states.iter().map(|state| {
        let [x, y, z] = motion::place(state);
        [x, y, z + PATH_HEIGHT_UM]
    });
    drawing::line(&mut entity, places, line_primitive::Type::LineStrip, color::PATH);
    if let Some(first) = plan.states.first() {
        let [x, y, _] = motion::place(first);
        drawing::sphere(&mut entity, [x, y, PATH_HEIGHT_UM], STOP_UM, color::START);
        drawing::text(&mut entity, [x, y - LABEL_GAP_UM, LABEL_HEIGHT_UM], "start".into(), color::START);
    }
    entity
}

/// The tip at its true width, in the frame that moves with it, with a mark that is visible when the tip is narrow.
fn tip(device: &str, t_ns: u64, facts: &DimibotFacts) -> SceneEntity {
    let mut entity = drawing::entity(format!("{device}/tip"), &tip::tip_frame(device), t_ns);
    let slab = Slab { bottom_um: 0.0, height_um: OBSTACLE_HEIGHT_UM, color: color::TIP };
    drawing::disc(&mut entity, nalgebra::Point2::origin(), facts.tip_radius_um, slab);
    drawing::sphere(&mut entity, [0.0, 0.0, OBSTACLE_HEIGHT_UM], TIP_MARK_UM, color::TIP);
    entity
}

fn mark_stops(mut entity: SceneEntity, order: &DimibotOrder) -> SceneEntity {
    for (index, cell) in stops(order).into_iter().enumerate() {
        let [x, y] = order.facts.place_um(cell);
        drawing::sphere(&mut entity, [x, y, PATH_HEIGHT_UM], STOP_UM, color::STOP);
        if index < MAX_LABELS {
            drawing::text(&mut entity, [x, y + LABEL_GAP_UM, LABEL_HEIGHT_UM], cell.to_string(), color::STOP);
        }
    }
    entity
}

/// Draws an obstacle and returns the place of its label.
fn draw_obstacle(entity: &mut SceneEntity, order: &DimibotOrder, obstacle: &DimibotObstacle) -> [f64; 3] {
    let facts = &order.facts;
    let true_slab = Slab { bottom_um: 0.0, height_um: OBSTACLE_HEIGHT_UM, color: color::OBSTACLE };
    let grown_slab = Slab { bottom_um: 0.0, height_um: GROWN_HEIGHT_UM, color: color::GROWN };
    match &*obstacle.body.seen_from(order.frame.as_ref()) {
        DimibotObstacleBody::Cells { from, to } => {
            let (low, high) = tiles_um(facts, *from, *to);
            drawing::cuboid(entity, low, high, true_slab);
            [(low[0] + high[0]) / 2.0, high[1] + LABEL_GAP_UM, LABEL_HEIGHT_UM]
        }
        DimibotObstacleBody::Solid { shape, pose } => {
            let mut top_um = pose.y_um;
            for (growth_um, slab) in [(0.0, true_slab), (facts.growth_um(), grown_slab)] {
                // The checker refuses shapes that cannot be placed; one that slips through is just not drawn.
                if let Ok(body) = shape.grown(pose, growth_um) {
                    let body = drawing::on_grid(body);
                    drawing::body(entity, &body, slab);
                    top_um = drawing::top_um(&body);
                }
            }
            [pose.x_um, top_um + LABEL_GAP_UM, LABEL_HEIGHT_UM]
        }
    }
}
