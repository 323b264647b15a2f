//! The hand in three dimensions: the part and the tips, the paths of the tips, the final poses of the part, and each
//! grasp with its forces.
//!
//! There are three topics, since a viewer that jumps in time reads only the last message of each: the scenery
//! (`scene`), the plan (`plan`), and the grasp of each state (`state`). The first two are repeated as points.

use super::solid;
use super::{frame_pose, part_frame, tip_frame};
use crate::claims::fingers::{FingersOrder, HandPart};
use crate::device::fingers::Plane;
use crate::emit::fingers::motion::{HandMotion, HandPlanMotion, RecordedGrasp};
use crate::emit::mcap::cloud::{CIRCLE_CORNERS, SpaceStroke, circle, space_cloud};
use crate::emit::mcap::drawing::{self, color};
use crate::emit::mcap::foxglove::{self, Color, PointCloud, SceneEntity, SceneUpdate, Vector3, line_primitive};
use crate::emit::mcap::{LogTopic, Pictures};
use crate::geometry::outline::Curve;
use crate::verify::fingers;
use nalgebra::{Point2, Point3, Quaternion, UnitQuaternion};

/// Opacity of a tip.
const TIP_ALPHA: f64 = 0.5;

/// Diameters of place marks and of arrows, as shares of a tip's diameter.
const MARK_PART: f64 = 0.12;
const ARROW_PART: f64 = 0.06;

/// The force whose arrow is as long as a tip is wide, as a share of the greatest force of a tip.
const FORCE_PART: f64 = 0.1;

/// Distance of neighbouring points of the clouds, in micrometres.
const POINTS_UM: f64 = 0.1;

/// Greatest number of states whose contacts are shown, since the forces of each take a linear program; beyond it only
/// the text is written.
const MAX_GRASPS: usize = 5_000;

const FORCE: Color = Color { r: 0.84, g: 0.37, b: 0.0, a: 1.0 };
const GOAL: Color = Color { r: 0.6, g: 0.6, b: 0.6, a: 1.0 };

/// Not the colour of the part.
fn color_of(finger: usize) -> Color {
    color::in_turn(finger + 1)
}

/// `/<device>/scene`, `/<device>/plan`, `/<device>/state` and the first two as points.
pub fn topics(motion: &HandMotion, device: &str) -> Vec<LogTopic> {
    let scene = motion.plans.first().map(|plan| (0, update(scenery(plan.order, motion.fingers, device))));
    let scene_points = motion.plans.first().map(|plan| {
        let part = &plan.order.part;
        let cloud = space_cloud(&part_strokes(part), &part_frame(device, &part.name), 0, POINTS_UM);
        (0, foxglove::encode(&cloud))
    });
    let plans = motion.plans.iter().map(|plan| (plan.start_ns, update(vec![trails(plan, device), goal(plan, device)])));
    let plan_points = motion.plans.iter().map(|plan| {
        (plan.start_ns, foxglove::encode(&space_cloud(&trail_strokes(plan), device, plan.start_ns, POINTS_UM)))
    });
    vec![
        LogTopic::new::<SceneUpdate>(format!("/{device}/scene"), scene.into_iter().collect()),
        LogTopic::new::<SceneUpdate>(format!("/{device}/plan"), plans.collect()),
        state(motion, device),
        LogTopic::new::<PointCloud>(format!("/{device}/scene/points"), scene_points.into_iter().collect()),
        LogTopic::new::<PointCloud>(format!("/{device}/plan/points"), plan_points.collect()),
    ]
}

fn scenery(order: &FingersOrder, fingers: usize, device: &str) -> Vec<SceneEntity> {
    let part = &order.part;
    let mut body = drawing::entity(format!("{device}/part/{}", part.name), &part_frame(device, &part.name), 0);
    solid::draw(&mut body, part);
    ends(&mut body, order);
    let tips = (0..fingers).map(|finger| {
        let mut tip = drawing::entity(format!("{device}/finger/f{}", finger + 1), &tip_frame(device, finger), 0);
        let color = color_of(finger);
        drawing::sphere(&mut tip, [0.0; 3], 2.0 * order.facts.tip_radius_um, Color { a: TIP_ALPHA, ..color });
        drawing::text(&mut tip, [0.0; 3], format!("f{}", finger + 1), color);
        tip
    });
    std::iter::once(body).chain(tips).collect()
}

/// Marks where both sections meet: I and J in the paper.
fn ends(entity: &mut SceneEntity, order: &FingersOrder) {
    let Ok(curve) = Curve::of(&order.part.xy.outline) else { return };
    let mark_um = drawing::snapped(2.0 * order.facts.tip_radius_um * MARK_PART);
    for (name, way_um) in [("I", 0.0), ("J", curve.opposite_um())] {
        let place = solid::in_space(Plane::Xy, curve.point_at(way_um).point_um);
        drawing::sphere(entity, place, mark_um, color::TIP);
        drawing::text(entity, place, name.to_owned(), color::TIP);
    }
}

/// The path of each tip that moves.
fn ways(plan: &HandPlanMotion) -> impl Iterator<Item = (usize, Vec<[f64; 3]>)> {
    (0..plan.order.facts.fingers as usize).filter_map(|finger| {
        let mut way: Vec<[f64; 3]> =
            plan.moments.iter().map(|moment| moment.tips_um[finger].map(drawing::snapped)).collect();
        way.dedup();
        (way.len() > 1).then_some((finger, way))
    })
}

fn trails(plan: &HandPlanMotion, device: &str) -> SceneEntity {
    let mut entity = drawing::entity(format!("{device}/trails"), device, plan.start_ns);
    for (finger, way) in ways(plan) {
        drawing::line(&mut entity, way, line_primitive::Type::LineStrip, color_of(finger));
    }
    entity
}

/// The outlines of the part at the end of the plan.
fn goal(plan: &HandPlanMotion, device: &str) -> SceneEntity {
    let mut entity = drawing::entity(format!("{device}/goal"), device, plan.start_ns);
    let Some(last) = plan.grasps.last() else { return entity };
    let pose = frame_pose(&last.part).pose();
    for (_, outline) in solid::outlines(&plan.order.part) {
        drawing::line(&mut entity, outline, line_primitive::Type::LineLoop, GOAL);
    }
    entity.lines.iter_mut().for_each(|line| line.pose = pose);
    entity
}

fn update(entities: Vec<SceneEntity>) -> Vec<u8> {
    foxglove::encode(&SceneUpdate { deletions: Vec::new(), entities })
}

/// Removes the contacts at the instant at which all holding fingers begin to leave; `None` if the next grasp still
/// holds.
fn letting_go(plan: &HandPlanMotion, index: usize, place: [f64; 3], device: &str) -> Option<(u64, Vec<u8>)> {
    let next = plan.grasps.get(index + 1).filter(|next| next.contacts.iter().all(|contact| *contact == 0))?;
    let [start_ns, _] = plan.motions.get(index).copied().flatten()?;
    let frame = part_frame(device, &plan.order.part.name);
    let contacts = drawing::entity(format!("{device}/contacts"), &frame, start_ns);
    let mut words = words(next, place, device);
    words.timestamp = foxglove::timestamp(start_ns);
    Some((start_ns, update(vec![contacts, words])))
}

/// `/<device>/state`: the contacts of each grasp, the forces there, and the grasp in words.
fn state(motion: &HandMotion, device: &str) -> LogTopic {
    let mut messages: Vec<(u64, Vec<u8>)> = Vec::new();
    for plan in &motion.plans {
        let [_, high_um] = plan.order.reach();
        let curve = |plane| Curve::of(&plan.order.part.section(plane)?.outline).ok();
        let curves = Plane::ALL.map(|plane| (plane, curve(plane)));
        for (index, grasp) in plan.grasps.iter().enumerate() {
            let curve = curves.iter().find(|(plane, _)| *plane == grasp.plane).and_then(|(_, curve)| curve.as_ref());
            let contacts = contacts(plan.order, grasp, curve.filter(|_| messages.len() < MAX_GRASPS), device);
            let place = [0.0, high_um, 0.0];
            messages.push((grasp.t_ns, update(vec![contacts, words(grasp, place, device)])));
            messages.extend(letting_go(plan, index, place, device));
        }
    }
    LogTopic::new::<SceneUpdate>(format!("/{device}/state"), messages)
}

/// Contacts of fingers with the part, and their forces, in the part's frame so that both move with it.
///
/// Many sets of forces balance a grasp; these are one solution, of moderate magnitude.
fn contacts(order: &FingersOrder, grasp: &RecordedGrasp, curve: Option<&Curve>, device: &str) -> SceneEntity {
    let frame = part_frame(device, &order.part.name);
    let mut entity = drawing::entity(format!("{device}/contacts"), &frame, grasp.t_ns);
    let (Some(section), Some(curve)) = (order.part.section(grasp.plane), curve) else { return entity };
    let tip_um = order.facts.tip_radius_um;
    let forces_un = fingers::forces(order, grasp.state).unwrap_or_default();
    for (finger, contact) in grasp.contacts.iter().enumerate().filter(|(_, contact)| **contact > 0) {
        let rolled_rad = f64::from(contact - 1) * section.step_rad;
        let spot = curve.point_at(curve.way_rolled_um(rolled_rad, tip_um));
        let place = solid::in_space(grasp.plane, spot.point_um);
        drawing::sphere(&mut entity, place, drawing::snapped(2.0 * tip_um * MARK_PART), color_of(finger));
        if let Some(force_un) = forces_un.get(finger).copied().flatten() {
            let scale = 2.0 * tip_um / (FORCE_PART * order.facts.max_force_un);
            let [x, y, z] = turned_back(grasp, force_un).map(|part| drawing::snapped(part * scale));
            drawing::arrow(&mut entity, place, Vector3 { x, y, z }, drawing::snapped(2.0 * tip_um * ARROW_PART), FORCE);
        }
    }
    entity
}

/// Rotates a direction from the hand's frame to the part's.
fn turned_back(grasp: &RecordedGrasp, direction: [f64; 3]) -> [f64; 3] {
    let [w, x, y, z] = grasp.part.orientation;
    let turn = UnitQuaternion::new_normalize(Quaternion::new(w, x, y, z));
    turn.inverse_transform_vector(&direction.into()).into()
}

fn words(grasp: &RecordedGrasp, place: [f64; 3], device: &str) -> SceneEntity {
    let mut entity = drawing::entity(format!("{device}/grasp"), device, grasp.t_ns);
    let contacts: Vec<String> = grasp.contacts.iter().map(u32::to_string).collect();
    let text = format!("grasp ({}) in {} at angle {}", contacts.join(", "), grasp.plane.name(), grasp.angle_index);
    drawing::text(&mut entity, place, text, color::TIP);
    entity
}

/// Outline of a tip in its own frame: its circles in the three planes.
pub fn tip_outline(order: &FingersOrder, finger: usize) -> Vec<SpaceStroke> {
    let flat = circle(Point2::origin(), order.facts.tip_radius_um, CIRCLE_CORNERS);
    let turn = |axes: [usize; 2]| {
        let corner = |place: &Point2<f64>| {
            let mut corner = Point3::origin();
            (corner[axes[0]], corner[axes[1]]) = (place.x, place.y);
            corner
        };
        SpaceStroke { corners: flat.iter().map(corner).collect(), color: color_of(finger) }
    };
    [[0, 1], [0, 2], [1, 2]].map(turn).into()
}

fn part_strokes(part: &HandPart) -> Vec<SpaceStroke> {
    let stroke = |(plane, outline): (Plane, Vec<[f64; 3]>)| {
        let mut corners: Vec<Point3<f64>> = outline.into_iter().map(Point3::from).collect();
        corners.extend(corners.first().copied());
        SpaceStroke { corners, color: solid::color_of(plane) }
    };
    solid::outlines(part).into_iter().map(stroke).collect()
}

fn trail_strokes(plan: &HandPlanMotion) -> Vec<SpaceStroke> {
    let stroke = |(finger, way): (usize, Vec<[f64; 3]>)| SpaceStroke {
        corners: way.into_iter().map(Point3::from).collect(),
        color: color_of(finger),
    };
    ways(plan).map(stroke).collect()
}
