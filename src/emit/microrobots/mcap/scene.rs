//! The bed in three dimensions: obstacles and robots, their paths and goals, and arms, orbits and docked robots.
//!
//! There are three topics, since a viewer that jumps in time reads only the last message of each: the scenery
//! (`scene`), the plan (`plan`), and the state of each leg (`state`). The first two are repeated as points.

use super::{frame, frame_pose};
use crate::claims::microrobots::MicrorobotsOrder;
use crate::device::microrobots::{Arm, Robot};
use crate::emit::mcap::LogTopic;
use crate::emit::mcap::cloud::{CIRCLE_CORNERS, SpaceStroke, Stroke, circle, outlines, spaced_cloud};
use crate::emit::mcap::drawing::{self, Slab, color};
use crate::emit::mcap::foxglove::{self, Color, PointCloud, SceneEntity, SceneUpdate, line_primitive};
use crate::emit::microrobots::motion::{BedMotion, BedPlanMotion, ControlLeg, SweptDisc, goals, nose_corners};
use crate::geometry::{Pose, Shape};
use nalgebra::Point2;
use std::collections::BTreeSet;

/// Heights of the drawn bodies, as shares of a robot's width.
const BODY_PART: f64 = 0.3;
const MARK_PART: f64 = 0.1;

/// Heights above the bed, in micrometres.
const OBSTACLE_HEIGHT_UM: f64 = 30.0;
const ORBIT_HEIGHT_UM: f64 = 1.0;
const PLAN_HEIGHT_UM: f64 = 2.0;
const LABEL_HEIGHT_UM: f64 = 40.0;

/// Greatest number of marks of arms and docked robots over all legs; beyond it only orbits are shown.
const MAX_MARKS: usize = 50_000;

/// Greatest number of obstacles and goals with labels.
const MAX_LABELS: usize = 200;

/// Distance of neighbouring points of the clouds, in micrometres.
const POINTS_UM: f64 = 2.0;

/// Colour of an arm that is down.
const DOWN: Color = Color { r: 0.84, g: 0.37, b: 0.0, a: 1.0 };

/// Colour of a docked robot.
const DOCKED: Color = Color { r: 0.6, g: 0.6, b: 0.6, a: 1.0 };

/// Opacity of an orbit.
const ORBIT_ALPHA: f64 = 0.25;

/// `/<device>/scene`, `/<device>/plan`, `/<device>/state` and the first two as points.
pub fn topics(motion: &BedMotion, device: &str) -> Vec<LogTopic> {
    let (mut scenes, mut scene_points) = (Vec::new(), Vec::new());
    let mut shown: BTreeSet<String> = BTreeSet::new();
    for (index, plan) in motion.plans.iter().enumerate() {
        // The scenery is written at the beginning, and again when a job has other obstacles.
        let is_new = index == 0 || motion.plans[index - 1].order.obstacles != plan.order.obstacles;
        if is_new {
            let t_ns = if index == 0 { 0 } else { plan.start_ns };
            let entities = scenery(plan.order, device, t_ns);
            let ids: BTreeSet<String> = entities.iter().map(|entity| entity.id.clone()).collect();
            let deletions = shown.difference(&ids).map(|id| drawing::deletion(id, t_ns)).collect();
            scenes.push((t_ns, foxglove::encode(&SceneUpdate { deletions, entities })));
            scene_points
                .push((t_ns, foxglove::encode(&spaced_cloud(&scene_strokes(plan.order), device, t_ns, POINTS_UM))));
            shown = ids;
        }
    }
    let plans = motion.plans.iter().map(|plan| {
        let entities = vec![trails(plan, device), goal_marks(plan, device)];
        (plan.start_ns, foxglove::encode(&SceneUpdate { deletions: Vec::new(), entities }))
    });
    let plan_points = motion.plans.iter().map(|plan| {
        (plan.start_ns, foxglove::encode(&spaced_cloud(&plan_strokes(plan), device, plan.start_ns, POINTS_UM)))
    });
    vec![
        LogTopic::new::<SceneUpdate>(format!("/{device}/scene"), scenes),
        LogTopic::new::<SceneUpdate>(format!("/{device}/plan"), plans.collect()),
        state(motion, device),
        LogTopic::new::<PointCloud>(format!("/{device}/scene/points"), scene_points),
        LogTopic::new::<PointCloud>(format!("/{device}/plan/points"), plan_points.collect()),
    ]
}

fn scenery(order: &MicrorobotsOrder, device: &str, t_ns: u64) -> Vec<SceneEntity> {
    let mut obstacles = drawing::entity(format!("{device}/obstacles"), device, t_ns);
    let slab = Slab { bottom_um: 0.0, height_um: OBSTACLE_HEIGHT_UM, color: color::OBSTACLE };
    for (index, obstacle) in order.obstacles.iter().enumerate() {
        // The checker refuses shapes that cannot be placed; one that slips through is just not drawn.
        let Ok(body) = obstacle.shape.grown(&obstacle.pose, 0.0) else { continue };
        drawing::body(&mut obstacles, &drawing::on_grid(body), slab);
        if index < MAX_LABELS {
            let place = drawing::snap(Point2::new(obstacle.pose.x_um, obstacle.pose.y_um));
            let place = [place.x, place.y, LABEL_HEIGHT_UM];
            drawing::text(&mut obstacles, place, obstacle.name.clone(), color::OBSTACLE);
        }
    }
    let robots = (0..order.robots.len()).map(|robot| body(order.robot(robot), color::in_turn(robot), device, t_ns));
    std::iter::once(obstacles).chain(robots).collect()
}

/// A robot in its own frame: its body, and a nose that shows its heading.
fn body(robot: &Robot, color: Color, device: &str, t_ns: u64) -> SceneEntity {
    let mut entity = drawing::entity(format!("{device}/robot/{}", robot.name), &frame(device, &robot.name), t_ns);
    let (length_um, width_um) = (robot.length_um, robot.width_um);
    let slab = Slab { bottom_um: 0.0, height_um: BODY_PART * width_um, color };
    drawing::cuboid(&mut entity, [-length_um / 2.0, -width_um / 2.0], [length_um / 2.0, width_um / 2.0], slab);
    let nose = Slab { bottom_um: slab.height_um, height_um: MARK_PART * width_um, color: color::TIP };
    drawing::prism(&mut entity, &nose_corners(robot), nose);
    let above = [0.0, 0.0, LABEL_HEIGHT_UM.max(width_um)];
    drawing::text(&mut entity, above, robot.name.clone(), color);
    entity
}

/// The path of each robot that moves.
fn ways<'a>(plan: &'a BedPlanMotion) -> impl Iterator<Item = (usize, Vec<Point2<f64>>)> + 'a {
    (0..plan.order.robots.len()).filter_map(|robot| {
        let places = plan.moments.iter().map(|moment| moment.poses[robot]);
        let mut places: Vec<Point2<f64>> =
            places.map(|pose| drawing::snap(Point2::new(pose.x_um, pose.y_um))).collect();
        places.dedup();
        (places.len() > 1).then_some((robot, places))
    })
}

fn trails(plan: &BedPlanMotion, device: &str) -> SceneEntity {
    let mut entity = drawing::entity(format!("{device}/trails"), device, plan.start_ns);
    for (robot, way) in ways(plan) {
        let places = way.iter().map(|place| [place.x, place.y, PLAN_HEIGHT_UM]);
        drawing::line(&mut entity, places, line_primitive::Type::LineStrip, color::in_turn(robot));
    }
    entity
}

/// The outline of a robot at a pose, and its nose.
fn silhouette(robot: &Robot, pose: &Pose) -> Vec<Vec<Point2<f64>>> {
    let shapes = [
        Shape::Box { size_um: [robot.length_um, robot.width_um] },
        Shape::Polygon { points_um: nose_corners(robot).map(Into::into).to_vec() },
    ];
    let bodies = shapes.iter().filter_map(|shape| shape.grown(pose, 0.0).ok());
    bodies.flat_map(|body| outlines(&drawing::on_grid(body), CIRCLE_CORNERS)).collect()
}

/// A robot's outline and nose in its own frame.
pub fn outline(robot: &Robot, index: usize) -> Vec<SpaceStroke> {
    let lines = silhouette(robot, &Pose { x_um: 0.0, y_um: 0.0, heading_rad: 0.0 }).into_iter();
    lines.map(|corners| SpaceStroke::from(&Stroke { corners, color: color::in_turn(index) })).collect()
}

fn goal_marks(plan: &BedPlanMotion, device: &str) -> SceneEntity {
    let mut entity = drawing::entity(format!("{device}/goals"), device, plan.start_ns);
    for (index, (robot, stop)) in goals(plan.order).enumerate() {
        let facts = plan.order.robot(robot);
        for line in silhouette(facts, &stop.pose) {
            let places = line.iter().map(|place| [place.x, place.y, PLAN_HEIGHT_UM]);
            drawing::line(&mut entity, places, line_primitive::Type::LineStrip, color::in_turn(robot));
        }
        if index < MAX_LABELS {
            let [x, y, _] = frame_pose(&stop.pose).place;
            drawing::text(
                &mut entity,
                [x, y, PLAN_HEIGHT_UM],
                format!("goal of {}", facts.name),
                color::in_turn(robot),
            );
        }
    }
    entity
}

/// `/<device>/state`: for each leg the arms that are down, the docked robots, and the orbits.
fn state(motion: &BedMotion, device: &str) -> LogTopic {
    let legs: usize = motion.plans.iter().map(|plan| plan.legs.len()).sum();
    let are_marked = legs * motion.robots.len() <= MAX_MARKS;
    let mut messages: Vec<(u64, Vec<u8>)> = Vec::new();
    for plan in &motion.plans {
        let orbits = plan.orbits();
        for leg in &plan.legs {
            let t_ns = leg.start_ns;
            let mut entities = vec![discs(plan.order, &orbits, device, t_ns)];
            if are_marked {
                entities.extend((0..leg.movers.len()).map(|robot| marks(plan.order, leg, robot, device)));
            }
            messages.push((t_ns, foxglove::encode(&SceneUpdate { deletions: Vec::new(), entities })));
        }
    }
    LogTopic::new::<SceneUpdate>(format!("/{device}/state"), messages)
}

/// The orbits in progress at an instant.
fn discs(order: &MicrorobotsOrder, orbits: &[SweptDisc], device: &str, t_ns: u64) -> SceneEntity {
    let mut entity = drawing::entity(format!("{device}/orbits"), device, t_ns);
    for orbit in orbits.iter().filter(|orbit| orbit.start_ns <= t_ns && t_ns < orbit.end_ns) {
        let centre = drawing::snap(Point2::from(orbit.centre_um));
        let color = Color { a: ORBIT_ALPHA, ..color::in_turn(orbit.robot) };
        let slab = Slab { bottom_um: 0.0, height_um: ORBIT_HEIGHT_UM, color };
        drawing::disc(&mut entity, centre, drawing::snapped(orbit.reach_um), slab);
        let text = format!("orbit of {}", order.robot(orbit.robot).name);
        drawing::text(&mut entity, [centre.x, centre.y, ORBIT_HEIGHT_UM], text, color::in_turn(orbit.robot));
    }
    entity
}

/// Marks of a robot in a leg: its arm if that is down, and a frame if it is docked.
fn marks(order: &MicrorobotsOrder, leg: &ControlLeg, robot: usize, device: &str) -> SceneEntity {
    let (facts, body) = (order.robot(robot), &leg.movers[robot]);
    let mut entity =
        drawing::entity(format!("{device}/marks/{}", facts.name), &frame(device, &facts.name), leg.start_ns);
    let (half_length_um, half_width_um) = (facts.length_um / 2.0, facts.width_um / 2.0);
    let top_um = (BODY_PART + MARK_PART) * facts.width_um;
    match body.arm {
        Arm::Up => {}
        Arm::Down => {
            // The arm is on the side to which the robot turns.
            let side = facts.turning.sign();
            let (near_um, far_um) = (side * half_width_um, side * 2.0 * half_width_um);
            let slab = Slab { bottom_um: 0.0, height_um: BODY_PART * facts.width_um, color: DOWN };
            let (low_um, high_um) = (near_um.min(far_um), near_um.max(far_um));
            drawing::cuboid(&mut entity, [-half_length_um / 4.0, low_um], [half_length_um / 4.0, high_um], slab);
        }
    }
    if body.is_docked {
        let corners = [[1.0, 1.0], [-1.0, 1.0], [-1.0, -1.0], [1.0, -1.0]];
        let corners = corners.map(|[x, y]| [x * half_length_um, y * half_width_um, top_um]);
        drawing::line(&mut entity, corners, line_primitive::Type::LineLoop, DOCKED);
        drawing::text(&mut entity, [0.0, -half_width_um, top_um], "docked".to_owned(), DOCKED);
    }
    entity
}

fn scene_strokes(order: &MicrorobotsOrder) -> Vec<Stroke> {
    let bodies = order.obstacles.iter().filter_map(|obstacle| obstacle.shape.grown(&obstacle.pose, 0.0).ok());
    let lines = bodies.flat_map(|body| outlines(&drawing::on_grid(body), CIRCLE_CORNERS));
    lines.map(|corners| Stroke { corners, color: color::OBSTACLE }).collect()
}

fn plan_strokes(plan: &BedPlanMotion) -> Vec<Stroke> {
    let ways = ways(plan).map(|(robot, corners)| Stroke { corners, color: color::in_turn(robot) });
    let goals = goals(plan.order).flat_map(|(robot, stop)| {
        let lines = silhouette(plan.order.robot(robot), &stop.pose).into_iter();
        lines.map(move |corners| Stroke { corners, color: color::in_turn(robot) })
    });
    let orbits = plan.orbits().into_iter().map(|orbit| Stroke {
        corners: circle(Point2::from(orbit.centre_um), orbit.reach_um, CIRCLE_CORNERS),
        color: Color { a: ORBIT_ALPHA, ..color::in_turn(orbit.robot) },
    });
    ways.chain(goals).chain(orbits).collect()
}
