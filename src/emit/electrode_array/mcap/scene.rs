//! The board in three dimensions: electrodes, obstacles, labelled parts, paths and goals, and the electrodes that are
//! on.
//!
//! There are three topics, since a viewer that jumps in time reads only the last message of each: the scenery
//! (`scene`), the plan (`plan`), and the electrodes that are on (`active`). The first two are repeated as points for
//! viewers that show no scenes.

use super::{frame, place_um};
use crate::claims::electrode_array::{ElectrodeArrayOrder, ZoneSort};
use crate::device::electrode_array::{ElectrodeArrayFacts, ElectrodeCell, Electrodes};
use crate::emit::electrode_array::motion::{body, goal_cells, outline, runs, zone_body};
use crate::emit::mcap::LogTopic;
use crate::emit::mcap::cloud::{CIRCLE_CORNERS, SpaceStroke, Stroke, circle, rectangle, space_cloud, spaced_cloud};
use crate::emit::mcap::drawing::{self, Slab, color};
use crate::emit::mcap::foxglove::{self, Color, PointCloud, SceneEntity, SceneUpdate, line_primitive};
use crate::quantity::Quantity;
use crate::schedule::electrode_array::ElectrodeArrayState;
use crate::schedule::{Channel, PlanRecord, State};
use crate::verify::Verified;
use nalgebra::Point2;
use std::collections::{BTreeMap, BTreeSet};

/// Heights above the board, in pitches.
const ELECTRODE_HEIGHT: f64 = 0.05;
const ZONE_HEIGHT: f64 = 0.03;
const ACTIVE_HEIGHT: f64 = 0.12;
const PART_HEIGHT: f64 = 0.6;
const OBSTACLE_HEIGHT: f64 = 0.8;
const PLAN_HEIGHT: f64 = 0.15;
const LABEL_HEIGHT: f64 = 1.0;

/// Diameter of the mark of a stop.
const STOP: f64 = 0.6;

/// Distance of neighbouring points of the clouds, in pitches.
const POINTS: f64 = 0.05;

/// Points in the ring of an electrode that is on. Every switching instant repeats all rings; with as many points as the
/// scenery has, they would take more of a log than everything else together.
const ACTIVE_POINTS: usize = 24;

/// Greatest number of electrodes drawn one by one; of a larger board only the outline is drawn.
const MAX_ELECTRODES: usize = 10_000;

/// Greatest number of parts, stops or obstacles with labels.
const MAX_LABELS: usize = 200;

const ACTIVE: Color = Color { r: 1.0, g: 0.95, b: 0.4, a: 1.0 };

/// `/<device>/scene`, `/<device>/plan`, `/<device>/active` and the first two as points.
pub fn topics(verified: &Verified, device: &str) -> Vec<LogTopic> {
    let jobs = runs(verified, device);
    let (mut scenes, mut plans) = (Vec::new(), Vec::new());
    let (mut scene_points, mut plan_points) = (Vec::new(), Vec::new());
    let mut shown: BTreeSet<String> = BTreeSet::new();
    for (index, (order, plan)) in jobs.iter().enumerate() {
        // The scenery is written at the beginning, and again when a job has other obstacles or zones.
        let is_new =
            index == 0 || jobs[index - 1].0.obstacles != order.obstacles || jobs[index - 1].0.zones != order.zones;
        if is_new {
            let t_ns = if index == 0 { 0 } else { plan.start_ns };
            let entities = scenery(order, device, t_ns);
            let ids: BTreeSet<String> = entities.iter().map(|entity| entity.id.clone()).collect();
            let deletions = shown.difference(&ids).map(|id| drawing::deletion(id, t_ns)).collect();
            scenes.push((t_ns, foxglove::encode(&SceneUpdate { deletions, entities })));
            scene_points.push((t_ns, foxglove::encode(&points(order, &scene_strokes(order), device, t_ns))));
            shown = ids;
        }
        let t_ns = plan.start_ns;
        let ways = ways(order, plan);
        let entities = vec![way_lines(order, &ways, device, t_ns), stops(order, device, t_ns)];
        plans.push((t_ns, foxglove::encode(&SceneUpdate { deletions: Vec::new(), entities })));
        plan_points.push((t_ns, foxglove::encode(&points(order, &way_strokes(order, &ways), device, t_ns))));
    }
    let active = active(verified, device, jobs.first().map(|(order, _)| &order.facts));
    vec![
        LogTopic::new::<SceneUpdate>(format!("/{device}/scene"), scenes),
        LogTopic::new::<SceneUpdate>(format!("/{device}/plan"), plans),
        active.scenes,
        active.points,
        LogTopic::new::<PointCloud>(format!("/{device}/scene/points"), scene_points),
        LogTopic::new::<PointCloud>(format!("/{device}/plan/points"), plan_points),
    ]
}

fn points(order: &ElectrodeArrayOrder, strokes: &[Stroke], device: &str, t_ns: u64) -> PointCloud {
    spaced_cloud(strokes, device, t_ns, POINTS * order.facts.pitch_um())
}

/// The colour of the part that must go there; a colour of its own for a goal that any of several parts may take.
fn color_of_stop(part: Option<usize>) -> Color {
    part.map_or(color::STOP, color::in_turn)
}

fn scenery(order: &ElectrodeArrayOrder, device: &str, t_ns: u64) -> Vec<SceneEntity> {
    let facts = &order.facts;
    let mut entities = vec![board(facts, device, t_ns), obstacles(order, device, t_ns)];
    entities.extend((!order.zones.is_empty()).then(|| zones(order, device, t_ns)));
    for (index, part) in order.parts.iter().enumerate() {
        let mut entity = drawing::entity(format!("{device}/part/{}", part.name), &frame(device, &part.name), t_ns);
        let (half, pitch_um) = (facts.layout.half_width_pitches * facts.pitch_um(), facts.pitch_um());
        let (bottom_um, height_um) = (ELECTRODE_HEIGHT * pitch_um, PART_HEIGHT * pitch_um);
        let slab = Slab { bottom_um, height_um, color: color::in_turn(index) };
        match facts.layout.electrodes {
            Electrodes::Quad => drawing::cuboid(&mut entity, [-half, -half], [half, half], slab),
            Electrodes::Single => drawing::disc(&mut entity, Point2::origin(), half, slab),
        }
        if index < MAX_LABELS {
            drawing::text(&mut entity, [0.0, 0.0, LABEL_HEIGHT * pitch_um], part.name.clone(), color::in_turn(index));
        }
        entities.push(entity);
    }
    entities
}

/// Outline of a part in its own frame.
pub fn part_outline(facts: &ElectrodeArrayFacts, index: usize) -> Stroke {
    let half_um = facts.layout.half_width_pitches * facts.pitch_um();
    let corners = match facts.layout.electrodes {
        Electrodes::Quad => rectangle([-half_um; 2], [half_um; 2]),
        Electrodes::Single => circle(Point2::origin(), half_um, CIRCLE_CORNERS),
    };
    Stroke { corners, color: color::in_turn(index) }
}

/// Converts corners from pitches to micrometres.
fn scaled(facts: &ElectrodeArrayFacts, corners: [[f64; 2]; 2]) -> [[f64; 2]; 2] {
    corners.map(|corner| corner.map(|pitches| pitches * facts.pitch_um()))
}

fn board(facts: &ElectrodeArrayFacts, device: &str, t_ns: u64) -> SceneEntity {
    let mut entity = drawing::entity(format!("{device}/board"), device, t_ns);
    let [[x0, y0], [x1, y1]] = scaled(facts, outline(facts));
    let corners = [[x0, y0, 0.0], [x1, y0, 0.0], [x1, y1, 0.0], [x0, y1, 0.0]];
    drawing::line(&mut entity, corners, line_primitive::Type::LineLoop, color::LATTICE);
    if facts.columns as usize * facts.rows as usize <= MAX_ELECTRODES {
        let height_um = ELECTRODE_HEIGHT * facts.pitch_um();
        let slab = Slab { bottom_um: 0.0, height_um, color: color::LATTICE };
        for row in 1..=facts.rows {
            for column in 1..=facts.columns {
                let cell = ElectrodeCell::new(column, row);
                if facts.has_electrode(cell) && !facts.is_disabled(cell) {
                    drawing::disc(&mut entity, Point2::from(place_um(facts, cell)), facts.radius_um, slab);
                }
            }
        }
    }
    let pitch = Quantity::length_um(facts.pitch_um());
    let title = format!("{device}: {} x {} electrodes, {pitch} apart", facts.columns, facts.rows);
    drawing::text(&mut entity, [(x0 + x1) / 2.0, y1 + facts.pitch_um(), 0.0], title, color::LATTICE);
    entity
}

fn obstacles(order: &ElectrodeArrayOrder, device: &str, t_ns: u64) -> SceneEntity {
    let mut entity = drawing::entity(format!("{device}/obstacles"), device, t_ns);
    let pitch_um = order.facts.pitch_um();
    let slab = Slab { bottom_um: 0.0, height_um: OBSTACLE_HEIGHT * pitch_um, color: color::OBSTACLE };
    for (index, obstacle) in order.obstacles.iter().enumerate() {
        let [low, high] = scaled(&order.facts, body(&order.facts, obstacle));
        drawing::cuboid(&mut entity, low, high, slab);
        if index < MAX_LABELS {
            let middle = [(low[0] + high[0]) / 2.0, (low[1] + high[1]) / 2.0, LABEL_HEIGHT * pitch_um];
            drawing::text(&mut entity, middle, obstacle.name.clone(), color::OBSTACLE);
        }
    }
    entity
}

fn zones(order: &ElectrodeArrayOrder, device: &str, t_ns: u64) -> SceneEntity {
    let mut entity = drawing::entity(format!("{device}/zones"), device, t_ns);
    let pitch_um = order.facts.pitch_um();
    for (index, zone) in order.zones.iter().enumerate() {
        let [low, high] = scaled(&order.facts, zone_body(zone));
        let color = color_of_zone(zone.sort);
        drawing::cuboid(&mut entity, low, high, Slab { bottom_um: 0.0, height_um: ZONE_HEIGHT * pitch_um, color });
        if index < MAX_LABELS {
            let middle = [(low[0] + high[0]) / 2.0, (low[1] + high[1]) / 2.0, LABEL_HEIGHT * pitch_um];
            drawing::text(&mut entity, middle, zone.name.clone(), color);
        }
    }
    entity
}

fn color_of_zone(sort: ZoneSort) -> Color {
    match sort {
        ZoneSort::Heater => color::OBSTACLE,
        ZoneSort::Detector => color::STOP,
        ZoneSort::Magnet => color::START,
    }
}

/// The index of each part that moves, and the sequence of its cells without repetitions.
fn ways(order: &ElectrodeArrayOrder, plan: &PlanRecord) -> Vec<(usize, Vec<ElectrodeCell>)> {
    let mut ways: BTreeMap<&str, Vec<ElectrodeCell>> = BTreeMap::new();
    for timed in &plan.states {
        let State::ElectrodeArray(ElectrodeArrayState { parts }) = &timed.state else { continue };
        for (name, [column, row]) in parts.iter() {
            let way = ways.entry(name).or_default();
            let cell = ElectrodeCell::new(column, row);
            if way.last() != Some(&cell) {
                way.push(cell);
            }
        }
    }
    let parts = order.parts.iter().enumerate();
    let moved = parts.filter_map(|(index, part)| Some((index, ways.remove(part.name.as_str())?)));
    moved.filter(|(_, way)| way.len() > 1).collect()
}

fn way_lines(
    order: &ElectrodeArrayOrder,
    ways: &[(usize, Vec<ElectrodeCell>)],
    device: &str,
    t_ns: u64,
) -> SceneEntity {
    let mut entity = drawing::entity(format!("{device}/ways"), device, t_ns);
    for (part, way) in ways {
        let places = way.iter().map(|cell| {
            let [x, y] = place_um(&order.facts, *cell);
            [x, y, PLAN_HEIGHT * order.facts.pitch_um()]
        });
        drawing::line(&mut entity, places, line_primitive::Type::LineStrip, color::in_turn(*part));
    }
    entity
}

fn stops(order: &ElectrodeArrayOrder, device: &str, t_ns: u64) -> SceneEntity {
    let mut entity = drawing::entity(format!("{device}/stops"), device, t_ns);
    let [stop_um, height_um] = [STOP, PLAN_HEIGHT].map(|pitches| pitches * order.facts.pitch_um());
    for (index, (part, cell)) in goal_cells(order).enumerate() {
        let [x, y] = place_um(&order.facts, cell);
        drawing::sphere(&mut entity, [x, y, height_um], stop_um, color_of_stop(part));
        if index < MAX_LABELS {
            let name = part.and_then(|part| order.parts.get(part)).map_or("any", |part| &part.name);
            drawing::text(&mut entity, [x, y + stop_um, height_um], format!("{name} {cell}"), color_of_stop(part));
        }
    }
    entity
}

fn scene_strokes(order: &ElectrodeArrayOrder) -> Vec<Stroke> {
    let [low, high] = scaled(&order.facts, outline(&order.facts));
    let board = Stroke { corners: rectangle(low, high), color: color::LATTICE };
    let obstacles = order.obstacles.iter().map(|obstacle| {
        let [low, high] = scaled(&order.facts, body(&order.facts, obstacle));
        Stroke { corners: rectangle(low, high), color: color::OBSTACLE }
    });
    let zones = order.zones.iter().map(|zone| {
        let [low, high] = scaled(&order.facts, zone_body(zone));
        Stroke { corners: rectangle(low, high), color: color_of_zone(zone.sort) }
    });
    std::iter::once(board).chain(obstacles).chain(zones).collect()
}

fn way_strokes(order: &ElectrodeArrayOrder, ways: &[(usize, Vec<ElectrodeCell>)]) -> Vec<Stroke> {
    let ways = ways.iter().map(|(part, way)| Stroke {
        corners: way.iter().map(|cell| Point2::from(place_um(&order.facts, *cell))).collect(),
        color: color::in_turn(*part),
    });
    let stops = goal_cells(order).map(|(part, cell)| Stroke {
        corners: circle(
            Point2::from(place_um(&order.facts, cell)),
            STOP / 2.0 * order.facts.pitch_um(),
            CIRCLE_CORNERS,
        ),
        color: color_of_stop(part),
    });
    ways.chain(stops).collect()
}

/// Topics of the electrodes that are on.
struct ActiveTopics {
    scenes: LogTopic,
    points: LogTopic,
}

/// `/<device>/active`, the electrodes that are on, whenever one is switched, and `/<device>/active/points`.
fn active(verified: &Verified, device: &str, facts: Option<&ElectrodeArrayFacts>) -> ActiveTopics {
    let on = facts.map_or_else(Vec::new, |facts| switched_on(verified, device, facts));
    let scene = |(t_ns, cells, facts): &(u64, BTreeSet<ElectrodeCell>, &ElectrodeArrayFacts)| {
        let mut entity = drawing::entity(format!("{device}/on"), device, *t_ns);
        let slab = Slab { bottom_um: 0.0, height_um: ACTIVE_HEIGHT * facts.pitch_um(), color: ACTIVE };
        for cell in cells {
            drawing::disc(&mut entity, Point2::from(place_um(facts, *cell)), facts.radius_um, slab);
        }
        (*t_ns, foxglove::encode(&SceneUpdate { deletions: Vec::new(), entities: vec![entity] }))
    };
    let mut rings: BTreeMap<ElectrodeCell, SpaceStroke> = BTreeMap::new();
    let points = |(t_ns, cells, facts): &(u64, BTreeSet<ElectrodeCell>, &ElectrodeArrayFacts)| {
        let ring = |cell: &ElectrodeCell| {
            let corners = || circle(Point2::from(place_um(facts, *cell)), facts.radius_um, ACTIVE_POINTS);
            let stroke = || SpaceStroke::from(&Stroke { corners: corners(), color: ACTIVE });
            rings.entry(*cell).or_insert_with(stroke).clone()
        };
        let lit: Vec<SpaceStroke> = cells.iter().map(ring).collect();
        // Each side of a ring is shorter than its radius, so the spacing adds no points to its corners.
        (*t_ns, foxglove::encode(&space_cloud(&lit, device, *t_ns, facts.radius_um)))
    };
    ActiveTopics {
        scenes: LogTopic::new::<SceneUpdate>(format!("/{device}/active"), on.iter().map(scene).collect()),
        points: LogTopic::new::<PointCloud>(format!("/{device}/active/points"), on.iter().map(points).collect()),
    }
}

/// The electrodes that are on, from each instant at which one is switched.
fn switched_on<'a>(
    verified: &Verified,
    device: &str,
    facts: &'a ElectrodeArrayFacts,
) -> Vec<(u64, BTreeSet<ElectrodeCell>, &'a ElectrodeArrayFacts)> {
    let schedule = verified.schedule();
    let cells = |channel: &Channel| {
        let name = channel.name.strip_prefix(device).filter(|_| channel.device == device)?.strip_prefix('.')?;
        facts.electrode(name).map(|first| facts.working_on_channel_of(first))
    };
    let of_channel: Vec<Vec<ElectrodeCell>> =
        schedule.channels.iter().map(|channel| cells(channel).unwrap_or_default()).collect();
    // By instant, the electrodes that are switched then, and whether on or off.
    let mut switched: BTreeMap<u64, Vec<(ElectrodeCell, Switched)>> = BTreeMap::from([(0, Vec::new())]);
    for actuation in &schedule.actuations {
        let cells = of_channel.get(actuation.channel as usize).map_or(&[][..], Vec::as_slice);
        let mut note = |t_ns: u64, change: Switched| {
            let changes = cells.iter().map(|cell| (*cell, change));
            if !cells.is_empty() {
                switched.entry(t_ns).or_default().extend(changes);
            }
        };
        note(actuation.start_ns, Switched::On);
        note(actuation.end_ns(), Switched::Off);
    }
    let mut on: BTreeSet<ElectrodeCell> = BTreeSet::new();
    let from = |(t_ns, mut changes): (u64, Vec<(ElectrodeCell, Switched)>)| {
        changes.sort_by_key(|(_, switched)| *switched);
        for (cell, switched) in changes {
            match switched {
                Switched::Off => on.remove(&cell),
                Switched::On => on.insert(cell),
            };
        }
        (t_ns, on.clone(), facts)
    };
    switched.into_iter().map(from).collect()
}

/// An event of an electrode; ends at an instant are ordered before beginnings.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
enum Switched {
    Off,
    On,
}
