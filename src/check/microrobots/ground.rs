//! A scene as judged for one bed: obstacles, and where each robot starts.

use super::CheckedBed;
use super::bodies::{ObstacleSolid, RobotBody, is_too_near};
use super::errors;
use crate::check::Checker;
use crate::check::devices::CheckedDevice;
use crate::check::lets::Argument;
use crate::check::objects::{ObjectNames, of_other_kind};
use crate::check::scenes::{CheckedScene, SceneObject};
use crate::check::scope::nearest;
use crate::check::shapes::{self, MAX_HEADING_RAD};
use crate::check::tasks::TaskSite;
use crate::check::value::Value;
use crate::claims::microrobots::{MicrorobotsObstacle, Placed};
use crate::device::microrobots::{BedNoun, MAX_OBSTACLES, MAX_ROBOTS, MicrorobotsFacts, VOCABULARY};
use crate::device::shape::ShapeForm;
use crate::diagnostic::{Code, Sink};
use crate::geometry::shape::MAX_EXTENT_UM;
use crate::geometry::{Pose, Shape};
use std::rc::Rc;
use std::sync::Arc;

/// A scene as judged for one bed.
#[derive(Debug, Clone)]
pub struct BedScene {
    pub obstacles: Arc<Vec<MicrorobotsObstacle>>,
    /// In the order of the table.
    pub robots: Arc<Vec<Placed>>,
    pub names: ObjectNames,
    /// Whether all of its objects are possible.
    pub is_whole: bool,
}

impl Checker<'_> {
    /// The scene of a task for its device, judged once.
    pub fn ground(&mut self, site: &TaskSite, bed: &CheckedBed) -> Rc<BedScene> {
        self.scene_met(site, |checker, scene| match scene {
            Some(scene) => judged_scene(scene, &site.device, &bed.facts, checker.sink),
            None => judged(&[], &site.device, &bed.facts, checker.sink),
        })
    }
}

fn judged_scene(scene: &CheckedScene, device: &CheckedDevice, facts: &MicrorobotsFacts, sink: &mut Sink) -> BedScene {
    if let Some(crowd) = scene.crowd(&[(BedNoun::Robot.name(), MAX_ROBOTS), (BedNoun::Obstacle.name(), MAX_OBSTACLES)])
    {
        sink.push(crowd);
        return BedScene { is_whole: false, ..judged(&[], device, facts, sink) };
    }
    judged(&scene.objects, device, facts, sink)
}

/// A robot that was read: its placement, and the argument that gives its pose.
struct StandingRobot {
    name: String,
    placed: Placed,
    at: Argument,
}

fn judged(objects: &[Rc<SceneObject>], device: &CheckedDevice, facts: &MicrorobotsFacts, sink: &mut Sink) -> BedScene {
    let before = sink.errors();
    let (mut obstacles, mut standing) = (Vec::new(), Vec::new());
    let mut names = ObjectNames::default();
    names.know(facts.robots.iter().map(|row| row.name.as_str()));
    for object in objects {
        let mut reader = GroundReader { object, objects, device, facts, sink };
        match BedNoun::find(&object.noun) {
            Some(BedNoun::Robot) => {
                names.insert(&object.name, None);
                standing.extend(reader.robot());
            }
            Some(BedNoun::Obstacle) => {
                let obstacle = reader.obstacle();
                names.insert_other(&object.name, BedNoun::Obstacle.name(), object.span);
                obstacles.extend(obstacle);
            }
            None => sink.push(of_other_kind(object, &VOCABULARY)),
        }
    }
    standing.sort_by_key(|standing| standing.placed.row);
    for (index, standing) in standing.iter().enumerate() {
        names.insert(&standing.name, Some(index));
    }
    starts(&standing, &obstacles, facts, sink);
    BedScene {
        obstacles: Arc::new(obstacles),
        robots: Arc::new(standing.into_iter().map(|standing| standing.placed).collect()),
        names,
        is_whole: sink.errors() == before,
    }
}

/// Reads one object of a scene.
struct GroundReader<'a> {
    object: &'a SceneObject,
    /// All objects of the scene.
    objects: &'a [Rc<SceneObject>],
    device: &'a CheckedDevice,
    facts: &'a MicrorobotsFacts,
    sink: &'a mut Sink,
}

impl GroundReader<'_> {
    fn robot(&mut self) -> Option<StandingRobot> {
        let row = self.row();
        let has_own_body = self.has_own_body();
        let (at, pose) = self.pose()?;
        let placed = Placed { row: row?, pose, span: self.object.span };
        (!has_own_body).then(|| StandingRobot { name: self.object.name.clone(), placed, at })
    }

    /// The row of the table that bears the robot's name.
    fn row(&mut self) -> Option<usize> {
        let name = &self.object.name;
        let row = self.facts.row(name);
        if row.is_none() {
            let known: Vec<&str> = self.facts.robots.iter().map(|robot| robot.name.as_str()).collect();
            let table = self.device.fields.get("robots").map(|field| field.span);
            // A robot that is already placed was not meant.
            let is_placed = |robot: &&str| self.objects.iter().any(|object| object.name == **robot);
            let near = nearest(name, known.iter().copied().filter(|robot| !is_placed(robot)));
            let wrong = errors::robot_without_row(self.object.span, name, near, &known, &self.device.name, table);
            self.sink.push(wrong);
        }
        row
    }

    /// Whether a robot has a shape, which is reported: its body is that of the table.
    fn has_own_body(&mut self) -> bool {
        let Some(shape) = &self.object.shape else { return false };
        self.sink.push(errors::robot_with_shape(shape.span, &self.object.name));
        true
    }

    fn pose(&mut self) -> Option<(Argument, Pose)> {
        let object = self.object;
        let Some(at) = &object.at else {
            self.sink.push(errors::robot_stands_nowhere(object.span, &object.name));
            return None;
        };
        let at = Argument { value: at.value.clone(), span: at.span, origin: object.origin.clone() };
        let Value::Pose(_) = at.value else {
            self.sink.push(errors::given_at(errors::no_heading(at.span, &object.name, &at.value), &at));
            return None;
        };
        let pose = exact_pose(&at, self.sink)?;
        Some((at, pose))
    }

    fn obstacle(&mut self) -> Option<MicrorobotsObstacle> {
        let object = self.object;
        let forms = VOCABULARY.noun(BedNoun::Obstacle.name()).map_or(&[][..], |noun| noun.shapes);
        let shape = match &object.shape {
            None => Shape::Point,
            Some(shape) if forms.contains(&shape.value.form) => shapes::in_plane(&shape.value)?,
            Some(shape) => {
                let known: Vec<&str> = forms.iter().map(|form: &ShapeForm| form.name()).collect();
                let form = shape.value.form.name();
                let wrong = errors::shape_of_other_kind(shape.span, form, &object.noun, VOCABULARY.name, &known);
                self.sink.push(wrong);
                return None;
            }
        };
        let pose = match &object.at {
            None => Pose::at(0.0, 0.0),
            Some(at) => match shapes::pose_of(&at.value) {
                Some(pose) => pose,
                None => {
                    self.sink.push(errors::obstacle_without_place(at.span, &at.value));
                    return None;
                }
            },
        };
        if !shapes::within_extent(&shape, &pose) {
            self.sink.push(errors::shape_too_large(object.span, &errors::length(MAX_EXTENT_UM)));
            return None;
        }
        Some(MicrorobotsObstacle { name: object.name.clone(), shape, pose, span: object.span })
    }
}

/// Whether a pose is within the range of exact geometry.
fn is_near(pose: &Pose) -> bool {
    pose.x_um.abs().max(pose.y_um.abs()) <= MAX_EXTENT_UM
}

/// The pose that an argument gives, within the range of exact geometry and with a known heading; `None` after an error.
pub fn exact_pose(at: &Argument, sink: &mut Sink) -> Option<Pose> {
    let pose = shapes::pose_of(&at.value)?;
    let far = (!is_near(&pose)).then(|| errors::pose_too_far(at.span, MAX_EXTENT_UM));
    at.unless(far, sink)?;
    let unknown = errors::heading_too_large(at.span, MAX_HEADING_RAD.to_degrees());
    at.unless((!shapes::heading_is_known(&pose)).then_some(unknown), sink)?;
    Some(pose)
}

/// Checks that robots start clear of obstacles and of each other, because all of them move with the first stroke.
fn starts(standing: &[StandingRobot], obstacles: &[MicrorobotsObstacle], facts: &MicrorobotsFacts, sink: &mut Sink) {
    let solids: Vec<Option<ObstacleSolid>> = obstacles.iter().map(ObstacleSolid::of).collect();
    let body = |standing: &StandingRobot| RobotBody::of(&facts.robots[standing.placed.row], standing.placed.pose);
    let bodies: Vec<RobotBody> = standing.iter().map(body).collect();
    let kept_um = facts.clearance_um;
    for (index, StandingRobot { name, at, .. }) in standing.iter().enumerate() {
        let what = errors::BlockedRobot { code: Code::E0505, robot: name, span: at.span };
        if let Some((obstacle, gap_um)) = first_near(&bodies[index], obstacles, &solids, kept_um) {
            let wrong = errors::robot_near_obstacle(&what, &obstacle.name, obstacle.span, gap_um, kept_um, None);
            sink.push(errors::given_at(wrong, at));
        }
        let gaps = bodies[..index].iter().map(|other| bodies[index].gap_um(other));
        if let Some((other, gap_um)) = gaps.enumerate().find(|(_, gap_um)| is_too_near(*gap_um, kept_um)) {
            let other = &standing[other];
            let wrong = errors::robots_start_too_near(name, at.span, &other.name, other.at.span, gap_um, kept_um);
            sink.push(errors::given_at(wrong, at));
        }
    }
}

/// The first obstacle that a body is too near to, and its distance in micrometres.
pub fn first_near<'o>(
    body: &RobotBody,
    obstacles: &'o [MicrorobotsObstacle],
    solids: &[Option<ObstacleSolid>],
    kept_um: f64,
) -> Option<(&'o MicrorobotsObstacle, f64)> {
    let gaps = solids.iter().map(|solid| solid.as_ref().map_or(f64::INFINITY, |solid| solid.gap_um(body, kept_um)));
    obstacles.iter().zip(gaps).find(|(_, gap_um)| is_too_near(*gap_um, kept_um))
}
