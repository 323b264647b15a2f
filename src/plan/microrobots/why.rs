//! Explains a step of microrobots without a plan: which robot, which orbit, which obstacle.

use super::assembly::{RobotBlocker, StuckAssembly};
use super::collision_proof::{InevitableCollision, StaticCollision};
use super::confinement::{Confinement, PathEnd};
use super::drive::{self, DriveBlocker, StuckReason};
use super::guarantee::message;
use super::world::{Collision, FirstCollision};
use crate::claims::microrobots::{MicrorobotsOrder, MicrorobotsStep, MicrorobotsStop};
use crate::device::microrobots::MicrorobotsPlanner;
use crate::diagnostic::{Code, Diagnostic, Reach, ReachExtent};
use crate::geometry::Pose;
use crate::quantity::{Dimension, Quantity, count, digits, to_decimals};
use crate::source::Span;

/// Text of the messages about one step.
pub struct BedReasons<'a> {
    pub order: &'a MicrorobotsOrder,
    pub step: &'a MicrorobotsStep,
    /// Which robots of the order have docked before the step.
    pub docked: &'a [bool],
    /// Whether the robots' poses before the step are the same in every plan.
    pub is_given: bool,
}

/// Label text: the errors under which an assembly was checked.
pub fn with_errors(order: &MicrorobotsOrder) -> &'static str {
    match order.facts.is_exact() {
        true => "without any errors",
        false => "with the errors of the device",
    }
}

impl BedReasons<'_> {
    /// Report of a raw state whose strokes cause a collision.
    pub fn applied_into(&self, hit: &FirstCollision) -> Diagnostic {
        let after = Quantity::new(hit.strokes * self.order.facts.period_ns as f64 / 1e9, Dimension::TIME);
        let title = format!("{} after {}", self.collision_text(hit.collision), rounded(after));
        let diagnostic =
            Diagnostic::new(Code::E0606, title).label(self.step.span, "this carries all robots that have not docked");
        self.shown(diagnostic, hit).help(match self.is_given {
            true => "apply it for a shorter time, or apply another state",
            false => {
                "where the robots are by then depends on the plan of the steps before: route a robot differently there \
                 (`via`), apply the state for a shorter time, or apply another state"
            }
        })
    }

    /// Report of a raw state that lowers the arm of a docked robot.
    pub fn lowers_docked(&self, state: usize, robot: usize) -> Diagnostic {
        let name = self.name(robot);
        Diagnostic::new(Code::E0606, format!("control state {state} lowers the arm of {name}, but {name} has docked"))
            .label(self.step.span, "a lowered arm would turn the structure")
            .help("apply a state in which the arms of all docked robots are up; `tweeze devices FILE` shows the control states")
    }

    /// Report of an assembly after a step in which robots turned, so that they are on their orbits from its beginning.
    pub fn still_turning(&self, hit: &FirstCollision) -> Diagnostic {
        let diagnostic =
            Diagnostic::new(Code::E0602, format!("no path was found: {}", self.collision_text(hit.collision)))
                .label(self.step.span, "it has been turning since the step before");
        self.shown(diagnostic, hit).help("put `wait 1 ms` before this step: at 0 V all arms go up")
    }

    /// Report of a stage whose success is not certain though the task demands it; the plan tolerates `multiple` times
    /// the errors.
    pub fn not_guaranteed(&self, names: &str, why: &str, multiple: f64) -> Diagnostic {
        let help = match self.order.facts.errors.filter(|_| multiple > 0.0) {
            Some(errors) => format!(
                "leave `guaranteed` out and count successes with `tweeze simulate`; this plan is guaranteed up to {}",
                message::fields(&errors, multiple)
            ),
            None if self.order.facts.is_exact() => {
                "place each goal flat against the edge that it faces, without overlap; `tweeze simulate` lists what fails".to_owned()
            }
            None => "leave `guaranteed` out and count successes with `tweeze simulate`; an assembly is guaranteed only \
                     with small errors"
                .to_owned(),
        };
        Diagnostic::new(Code::E0605, format!("the docking of {names} is not guaranteed: {why}"))
            .label(self.step.span, with_errors(self.order))
            .help(help)
    }

    /// Report of a robot that does not reach one of its stops.
    pub fn not_driven(&self, robot: usize, stuck: &drive::StuckDrive, stops: &[MicrorobotsStop]) -> Diagnostic {
        let is_proof =
            stuck.reason.is_proof() && (self.is_given && stuck.stop == 0 || stuck.reason == StuckReason::Docked);
        let code = if is_proof { Code::E0601 } else { Code::E0602 };
        let name = self.name(robot);
        let goal = stops.get(stuck.stop).map_or(self.step.span, |stop| stop.span);
        let start = self.order.robots[robot].span;
        let clearance = length(self.order.facts.clearance_um);
        match stuck.reason {
            StuckReason::Docked => Diagnostic::new(code, format!("{name} has docked and no longer moves"))
                .label(self.step.span, "it is part of a structure")
                .help("drive it before it docks"),
            StuckReason::NeverTurns => Diagnostic::new(
                code,
                format!("no control state lowers the arm of {name}{}, so it only runs straight", self.beside_docked()),
            )
            .label(goal, "it must turn to get here")
            .help("`tweeze devices FILE` shows the control states"),
            StuckReason::NeverRuns => Diagnostic::new(
                code,
                format!("no control state raises the arm of {name}{}, so it only turns", self.beside_docked()),
            )
            .label(goal, "it must run straight to get here")
            .help("`tweeze devices FILE` shows the control states"),
            StuckReason::Start(thing) => {
                let title =
                    format!("{name} is too near to {} to move: at least {clearance} is needed", self.thing(thing));
                let diagnostic = Diagnostic::new(code, title).label(start, "it starts here");
                self.near(diagnostic, thing, start).help("start it elsewhere, or with another heading")
            }
            StuckReason::Goal(thing) => {
                let title =
                    format!("at its goal {name} is too near to {}: at least {clearance} is needed", self.thing(thing));
                let diagnostic = Diagnostic::new(code, title).label(goal, "no path can end here");
                self.near(diagnostic, thing, goal).help("choose another place or heading")
            }
            StuckReason::Blocked(thing) => {
                let title = format!("no path was found for {name} around {}", self.thing(thing));
                let diagnostic = Diagnostic::new(code, title).label(goal, "the path to this pose");
                self.near(diagnostic, thing, goal).help("name a pose along the path with `via`, or make room")
            }
            StuckReason::GaveUp(thing) => {
                let diagnostic = self.gave_up();
                self.near(diagnostic, thing, self.step.span)
            }
            StuckReason::OutOfBudget => self.gave_up(),
            StuckReason::TooFine => {
                Diagnostic::new(code, format!("whole strokes do not bring {name} within the precision"))
                    .label(goal, "this pose")
                    .help("use a larger `precision`, or give the bed a smaller `step_size`")
            }
            StuckReason::Meets(hit) => {
                let title =
                    format!("{name} has a path, but all robots move with it: {}", self.collision_text(hit.collision));
                let diagnostic =
                    Diagnostic::new(code, title).label(goal, "the last choice of control states tried ends like this");
                self.shown(diagnostic, &hit)
                    .help("make room for the robots that move with it, or drive them out of the way first")
            }
        }
    }

    /// Report of collisions one of which happens before the step can end: a proof.
    pub fn inevitable_collision(&self, collision: &InevitableCollision, strokes: u64) -> Diagnostic {
        let robots = collision.robots();
        let step_um = robots.iter().map(|robot| self.order.robot(*robot).step_um).fold(0.0, f64::max);
        let driven = if robots.len() == 1 { "it" } else { "them" };
        let ways_um = [collision.strokes, strokes as f64].map(|strokes| strokes * step_um);
        let mut diagnostic = self.unavoidable(&self.inevitable_text(collision), driven, ways_um);
        let reason = match robots.len() {
            1 => "this holds with its arm up, down or alternating",
            _ => "no control state saves all of these robots",
        };
        for robot in &robots {
            diagnostic = diagnostic.label_elsewhere(self.order.robots[*robot].span, self.step.span, reason);
        }
        self.around(diagnostic, &collision.obstacles()).help(match robots.len() {
            1 => "start it elsewhere or with another heading, or make room in front of it",
            _ => "start one of them elsewhere or with another heading, or make room in front of it",
        })
    }

    /// Report of a collision that no plan avoids after the first path, although the step drives the robots (`driven`: it
    /// or them) at least the second.
    fn unavoidable(&self, collision: &str, driven: &str, ways_um: [f64; 2]) -> Diagnostic {
        let [way, needed] = ways_um.map(length);
        let title = format!(
            "{collision} within {way} of path, whatever control states are applied; the strokes of this step drive \
             {driven} at least {needed}"
        );
        Diagnostic::new(Code::E0601, title).label(self.step.span, "every stroke moves all robots that have not docked")
    }

    /// Report of a robot that obstacles confine, or whose goal they shut off: a proof. The step drives it at least
    /// `needed_um`.
    pub fn confined(&self, confinement: &Confinement, goal: Span, needed_um: f64) -> Diagnostic {
        let Confinement { end, robot, obstacles, way_um } = confinement;
        let name = self.name(*robot);
        let names = obstacles.iter().map(|index| self.thing(DriveBlocker::Obstacle(*index)));
        let names = names.collect::<Vec<_>>().join(" or ");
        let [clearance, way] = [self.order.facts.clearance_um, *way_um].map(length);
        let diagnostic = match end {
            PathEnd::Start => {
                let collision = format!("{name} comes nearer than {clearance} to {names}");
                self.unavoidable(&collision, "it", [*way_um, needed_um])
                    .label_elsewhere(
                        self.order.robots[*robot].span,
                        self.step.span,
                        "every longer path from here meets an obstacle",
                    )
                    .help("start it elsewhere or with another heading, or make room around it")
            }
            PathEnd::Goal => {
                let title = format!(
                    "every path of {name} to this pose comes nearer than {clearance} to {names} in its last {way}"
                );
                Diagnostic::new(Code::E0601, title).label(goal, "every longer path to here meets an obstacle").help(
                    "choose another place or heading, or make room behind it: a robot turns to one side only and never \
                     backs up",
                )
            }
        };
        self.around(diagnostic, obstacles)
    }

    /// Labels obstacles of a proof.
    fn around(&self, diagnostic: Diagnostic, obstacles: &[usize]) -> Diagnostic {
        obstacles
            .iter()
            .fold(diagnostic, |diagnostic, index| self.near(diagnostic, DriveBlocker::Obstacle(*index), self.step.span))
    }

    /// The collisions one of which happens, as a sentence.
    fn inevitable_text(&self, collision: &InevitableCollision) -> String {
        let clearance = length(self.order.facts.clearance_um);
        let of = |robot: usize| {
            let partners = collision.collisions.iter().filter_map(|one| match *one {
                StaticCollision::Obstacle { robot: at, obstacle } if at == robot => {
                    Some(self.thing(DriveBlocker::Obstacle(obstacle)))
                }
                StaticCollision::Robots { robot: at, other } if at == robot => Some(self.name(other)),
                StaticCollision::Obstacle { .. } | StaticCollision::Robots { .. } => None,
            });
            let partners = partners.collect::<Vec<_>>().join(" or ");
            (!partners.is_empty()).then(|| format!("{} comes nearer than {clearance} to {partners}", self.name(robot)))
        };
        let sentences: Vec<String> = collision.robots().into_iter().filter_map(of).collect();
        sentences.join(", or ")
    }

    /// Further condition on a control state, if anything has docked.
    fn beside_docked(&self) -> &'static str {
        if self.docked.contains(&true) { " with the arms of docked robots up" } else { "" }
    }

    fn thing(&self, thing: DriveBlocker) -> String {
        match thing {
            DriveBlocker::Obstacle(index) => format!("`{}`", self.order.obstacles[index].name),
            DriveBlocker::Robot(robot) => self.name(robot),
            DriveBlocker::Orbit(robot) => format!("the orbit of {}", self.name(robot)),
        }
    }

    fn near(&self, diagnostic: Diagnostic, thing: DriveBlocker, named_at: Span) -> Diagnostic {
        let span = match thing {
            DriveBlocker::Obstacle(index) => self.order.obstacles[index].span,
            DriveBlocker::Robot(robot) | DriveBlocker::Orbit(robot) => self.order.robots[robot].span,
        };
        diagnostic.label_elsewhere(span, named_at, "in the way")
    }

    /// Report of an assembly without a plan.
    pub fn not_assembled(&self, stuck: &StuckAssembly, span: &dyn Fn(usize) -> Span) -> Diagnostic {
        let code = Code::E0602;
        match stuck {
            StuckAssembly::Unsteerable { robots, orbiting } => self.unsteerable(code, robots, *orbiting, span),
            StuckAssembly::GoalInOrbit { robot, orbiting, gap_um } => {
                self.goal_in_orbit(code, *robot, *orbiting, *gap_um, span)
            }
            StuckAssembly::Apart { robot } => {
                let title = format!("{} touches nothing at its goal when it docks", self.name(*robot));
                Diagnostic::new(code, title)
                    .label(span(*robot), "no body that has docked before is within the docking tolerance")
                    .help("a robot docks with those that snap down after it: make their goals touch")
            }
            StuckAssembly::Blocked { robot, partner, hit } => self.blocked(code, *robot, *partner, hit, span),
            StuckAssembly::Untimely { first, second } => {
                let title = format!(
                    "{} and {} cannot be brought to their goals at the same time",
                    self.name(*first),
                    self.name(*second)
                );
                Diagnostic::new(code, title)
                    .label(span(*first), "no phase of the other's orbit was found from which both arrive together")
                    .help("start them farther from their goals, or with other headings")
            }
            StuckAssembly::NoPath { robot, blocker } => {
                let title = format!("no path was found for {} around {}", self.name(*robot), self.blocker(*blocker));
                let diagnostic = Diagnostic::new(code, title).label(span(*robot), "the path to this goal");
                self.in_the_way(diagnostic, *blocker)
                    .help("move it aside, or allow more: `using one_way_dubins { expansions: 2000000 }`")
            }
            StuckAssembly::NoOrbit { robot, blocker } => {
                let title =
                    format!("{} has no room for its orbit: {} is in it", self.name(*robot), self.blocker(*blocker));
                let reach = Quantity::length_um(self.order.robot(*robot).orbit_reach_um());
                let diagnostic = Diagnostic::new(code, title).label(
                    self.order.robots[*robot].span,
                    format!("it sweeps a disc with a radius of {} while others are driven", rounded(reach)),
                );
                self.in_the_way(diagnostic, *blocker)
                    .help("start it elsewhere with room around it, or drive it there before this step")
            }
            StuckAssembly::Coarse { robot } => {
                let title =
                    format!("whole strokes do not bring {} to its goal within the precision", self.name(*robot));
                let facts = self.order.robot(*robot);
                let (step_um, turn_deg) = (facts.step_um, (facts.step_um / facts.turning_radius_um).to_degrees());
                let step = Quantity::length_um(step_um);
                Diagnostic::new(code, title).label(span(*robot), "this goal").help(format!(
                    "a stroke moves it by {step} or turns it by {} deg: give the task a larger `precision` and `heading_precision`, or \
                     the bed a smaller `step_size`",
                    digits(turn_deg)
                ))
            }
            StuckAssembly::Loose { robot, gap_um } => self.loose(code, *robot, *gap_um, span(*robot)),
            StuckAssembly::GaveUp => self.gave_up(),
        }
    }

    fn loose(&self, code: Code, robot: usize, gap_um: f64, goal: Span) -> Diagnostic {
        let um = |um: f64| Quantity::length_um(um).to_string();
        let tolerance = um(self.order.facts.docking.tolerance_um);
        let title = format!(
            "{} ends {} from its docking partner; the docking tolerance is {tolerance}",
            self.name(robot),
            um(to_decimals(gap_um, 5))
        );
        Diagnostic::new(code, title)
            .label(goal, "whole strokes brought it no nearer to this goal")
            .help("use a larger `docking_tolerance`, or give the bed a smaller `step_size`")
    }

    fn gave_up(&self) -> Diagnostic {
        let budget = self.order.expansions;
        Diagnostic::new(Code::E0602, format!("the search gave up after {}", count(budget, "expansion")))
            .label(self.step.span, "neither planned nor proven impossible")
            .help(crate::plan::errors::more_allowed(budget, MicrorobotsPlanner::OneWayDubins.name()))
    }

    fn unsteerable(
        &self,
        code: Code,
        robots: &[usize],
        orbiting: Option<usize>,
        span: &dyn Fn(usize) -> Span,
    ) -> Diagnostic {
        let names = self.names(robots);
        let orbits = orbiting.map_or("all others that have not docked".to_owned(), |robot| self.name(robot));
        let verb = if orbiting.is_some() { "orbits" } else { "orbit" };
        let title = format!("no control states steer {names} while {orbits} {verb}{}", self.beside_docked());
        let first = robots.first().copied().unwrap_or(0);
        Diagnostic::new(code, title).label(span(first), "it cannot be steered alone").help(
            "robots that snap down first dock last: an assembly begins with the two that snap down last, and no other \
             plans are searched; `tweeze devices FILE` shows the control states",
        )
    }

    fn goal_in_orbit(
        &self,
        code: Code,
        robot: usize,
        orbiting: usize,
        gap_um: f64,
        span: &dyn Fn(usize) -> Span,
    ) -> Diagnostic {
        let (name, other) = (self.name(robot), self.name(orbiting));
        let place = match gap_um < 0.0 {
            true => format!("lies {} inside the disc that {other} sweeps", length(-gap_um)),
            false => format!("is {} from the disc that {other} sweeps", length(gap_um)),
        };
        let least = length(self.order.facts.orbit_clearance_um);
        Diagnostic::new(code, format!("the goal of {name} {place}; at least {least} is needed"))
            .label(span(robot), format!("{name} docks here while {other} orbits"))
            .label_elsewhere(self.order.robots[orbiting].span, span(robot), "its orbit begins here")
            .help(format!("start {other} farther from the structure, or drive it away before this step"))
    }

    fn blocked(
        &self,
        code: Code,
        robot: usize,
        partner: Option<usize>,
        hit: &FirstCollision,
        span: &dyn Fn(usize) -> Span,
    ) -> Diagnostic {
        let driven = match partner {
            Some(partner) => format!("{} and {}", self.name(robot), self.name(partner)),
            None => self.name(robot),
        };
        let title = format!("no path was found for {driven}: {}", self.collision_text(hit.collision));
        let diagnostic =
            Diagnostic::new(code, title).label(span(robot), "the last path tried to this goal ends like this");
        self.shown(diagnostic, hit)
            .help("give the robots more room: other starts, other headings of the goals, or fewer obstacles")
    }

    /// A collision as text.
    pub fn collision_text(&self, collision: Collision) -> String {
        let facts = &self.order.facts;
        let (clearance, orbit) = (length(facts.clearance_um), length(facts.orbit_clearance_um));
        let obstacle = |index: usize| format!("`{}`", self.order.obstacles[index].name);
        match collision {
            Collision::Obstacle { robot, obstacle: index } => {
                format!("{} comes nearer than {clearance} to {}", self.name(robot), obstacle(index))
            }
            Collision::Robots { robot, other } => {
                format!("{} comes nearer than {clearance} to {}", self.name(robot), self.name(other))
            }
            Collision::OrbitObstacle { robot, obstacle: index } => {
                format!("the orbit of {} comes nearer than {orbit} to {}", self.name(robot), obstacle(index))
            }
            Collision::OrbitRobot { robot, other } => {
                format!("{} comes nearer than {orbit} to the orbit of {}", self.name(other), self.name(robot))
            }
            Collision::Orbits { robot, other } => {
                format!(
                    "the orbits of {} and {} come nearer than {orbit} to each other",
                    self.name(robot),
                    self.name(other)
                )
            }
        }
    }

    /// Labels the thing that is met, and shows where.
    fn shown(&self, diagnostic: Diagnostic, hit: &FirstCollision) -> Diagnostic {
        let (first, other) = match hit.collision {
            Collision::Obstacle { robot, .. } | Collision::OrbitObstacle { robot, .. } => (robot, None),
            Collision::Robots { robot, other }
            | Collision::OrbitRobot { robot, other }
            | Collision::Orbits { robot, other } => (robot, Some(other)),
        };
        let at = |robot: usize, pose: &Pose| Reach {
            what: self.order.robot(robot).name.clone(),
            extent: ReachExtent::Pose([pose.x_um, pose.y_um, pose.heading_rad]),
        };
        self.labelled(diagnostic, hit.collision)
            .reached([at(first, &hit.at)])
            .reached(other.map(|other| at(other, &hit.with)))
    }

    /// Labels the thing that is met, at its declaration in the program.
    fn labelled(&self, diagnostic: Diagnostic, collision: Collision) -> Diagnostic {
        let robot = |index: usize| (self.order.robots[index].span, "it starts here");
        let obstacle = |index: usize| (self.order.obstacles[index].span, "in the way");
        let (span, label) = match collision {
            Collision::Obstacle { obstacle: index, .. } | Collision::OrbitObstacle { obstacle: index, .. } => {
                obstacle(index)
            }
            Collision::Robots { other, .. } | Collision::Orbits { other, .. } => robot(other),
            Collision::OrbitRobot { robot: orbiting, .. } => robot(orbiting),
        };
        diagnostic.label_elsewhere(span, self.step.span, label)
    }

    fn in_the_way(&self, diagnostic: Diagnostic, blocker: RobotBlocker) -> Diagnostic {
        let span = match blocker {
            RobotBlocker::Obstacle(index) => self.order.obstacles[index].span,
            RobotBlocker::Orbit(robot) | RobotBlocker::Docked(robot) => self.order.robots[robot].span,
        };
        diagnostic.label_elsewhere(span, self.step.span, "in the way")
    }

    fn blocker(&self, blocker: RobotBlocker) -> String {
        match blocker {
            RobotBlocker::Obstacle(index) => format!("`{}`", self.order.obstacles[index].name),
            RobotBlocker::Orbit(robot) => format!("the orbit of {}", self.name(robot)),
            RobotBlocker::Docked(robot) => format!("{}, which has docked", self.name(robot)),
        }
    }

    fn name(&self, robot: usize) -> String {
        format!("`{}`", self.order.robot(robot).name)
    }

    fn names(&self, robots: &[usize]) -> String {
        robots.iter().map(|robot| self.name(*robot)).collect::<Vec<_>>().join(" and ")
    }
}

/// A length, rounded to a tenth of a micrometre.
fn length(um: f64) -> String {
    rounded(Quantity::new((um * 10.0).round() / 1e7, Dimension::LENGTH))
}

fn rounded(quantity: Quantity) -> String {
    let text = quantity.to_string();
    match text.split_once(' ') {
        Some((number, unit)) => {
            let value: f64 = number.parse().unwrap_or(quantity.si);
            format!("{} {unit}", digits(to_decimals(value, 2)))
        }
        None => text,
    }
}
