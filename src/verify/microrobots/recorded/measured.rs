//! Checks the measurements of a recorded run against its commands and the obstacles of the scene.
//!
//! After a robot was measured and then driven, its next measurement can deviate from where the strokes bring it by no
//! more than the accumulated bounds on the device's errors. With speed error v, turning error τ per path length, and
//! errors p and h of a measured position and heading, a straight or curved path of length w adds at most (h +
//! deviation of heading so far) w + τ w² / 2 + v w to the deviation of the position, and τ w (1 + v) + v w / R to that
//! of the heading. The reason: two paths whose headings differ by at most δ diverge by at most δ w, and the one that
//! is longer by v w ends at most that much farther on. Robots that touch may have been stopped on their way, and align
//! themselves.

use super::super::super::boxes::{Extent, GroupedBoxes};
use super::super::super::geometry::solid::Solid;
use super::super::bodies::JudgedBody;
use super::super::motion::{RobotPlace, turn_between};
use super::commanded::CommandedLeg;
use super::{Deviation, JudgedRecording};
use crate::device::microrobots::Arm;
use crate::quantity::{digits, to_decimals};
use crate::real::Real;
use crate::verify::rule::{Findings, Rule, Violation, ms};
use nalgebra::Vector2;
use std::f64::consts::PI;

/// Rounding that does not count as a deviation: lines have all digits of a number.
const ROUNDING_UM: f64 = 1e-3;
const ROUNDING_RAD: f64 = 1e-6;

/// Greatest spacing of the points of a path at which a robot may have been stopped, and their greatest number in a
/// leg.
const STOP_STEP_UM: f64 = 1.0;
const MAX_STOP_STEPS: f64 = 10_000.0;

/// A leg of one robot: a path length, on a curve or straight.
#[derive(Debug, Clone, Copy)]
struct TrackedLeg {
    curve_um: Option<f64>,
    path_um: f64,
}

/// The expected pose of a robot, and the allowed deviation of its measurement.
#[derive(Debug, Clone, Copy)]
struct Expected {
    place: RobotPlace,
    off_um: f64,
    off_rad: f64,
}

/// Judgement of a measurement.
pub(super) enum Seen {
    Usable(Vec<RobotPlace>),
    /// A robot was not seen, or was seen where it cannot be; a violation if the run continues with it.
    SetAside(Box<Violation>),
}

/// The robots, tracked from measurement to measurement.
pub(super) struct Tracked<'r, 'a> {
    run: &'r JudgedRecording<'a>,
    /// The last usable measurement.
    anchor: Option<Vec<RobotPlace>>,
    /// For each robot, the legs driven since then.
    legs: Vec<Vec<TrackedLeg>>,
    /// A measurement that was set aside, with its violation; the next one may confirm it.
    suspect: Option<(Vec<Option<RobotPlace>>, Box<Violation>)>,
    solids: Vec<Solid>,
    boxes: GroupedBoxes,
    farthest: Option<(usize, Deviation)>,
}

impl<'r, 'a> Tracked<'r, 'a> {
    pub fn new(run: &'r JudgedRecording<'a>) -> Self {
        let obstacles = run.order.obstacles.iter();
        let solids: Vec<Solid> = obstacles.filter_map(|one| Solid::of(&one.shape, &one.pose)).collect();
        let boxes = GroupedBoxes::new(solids.iter().map(Solid::extent));
        let legs = vec![Vec::new(); run.order.robots.len()];
        Tracked { run, anchor: None, legs, suspect: None, solids, boxes, farthest: None }
    }

    pub fn farthest(self) -> Option<Deviation> {
        self.farthest.map(|(_, deviation)| deviation)
    }

    /// Whether any measurement has been usable so far.
    pub fn has_begun(&self) -> bool {
        self.anchor.is_some()
    }

    /// Adds the legs that are driven from now on.
    pub fn drive(&mut self, legs: &[CommandedLeg], docked: &[bool]) {
        let order = self.run.order;
        for (robot, own) in self.legs.iter_mut().enumerate().filter(|(robot, _)| !docked[*robot]) {
            let facts = order.robot(robot);
            own.extend(legs.iter().map(|leg| TrackedLeg {
                curve_um: match order.states[leg.control].arms[order.robots[robot].row] {
                    Arm::Up => None,
                    Arm::Down => Some(super::super::curve_um(facts)),
                },
                path_um: leg.strokes as f64 * facts.step_um,
            }));
        }
    }

    /// Judges a measurement, and makes it the new anchor if it is usable. `step` is the step of a violation.
    pub fn see(&mut self, poses: &[Option<RobotPlace>], step: usize, at_ns: u64, findings: &mut Findings) -> Seen {
        let Some(places) = poses.iter().copied().collect::<Option<Vec<RobotPlace>>>() else {
            let robot = poses.iter().position(Option::is_none).unwrap_or(0);
            let title = format!("`{}` is not seen at {}, but the run continues", self.run.name(robot), ms(at_ns));
            return Seen::SetAside(Box::new(self.run.within(Rule::Path, step, at_ns, title)));
        };
        let strayed = self.anchor.clone().and_then(|anchor| self.strayed(&anchor, &places, step, at_ns));
        let Some(violation) = strayed.or_else(|| self.overlap(&places, step, at_ns)) else {
            self.accept(places.clone());
            return Seen::Usable(places);
        };
        // A deviation that two measurements agree on is real.
        let is_confirmed = self.suspect.as_ref().is_some_and(|(suspect, _)| {
            (0..places.len()).all(|robot| suspect[robot].is_none_or(|before| self.is_same(before, places[robot])))
        });
        match self.suspect.take().filter(|_| is_confirmed) {
            Some((_, violation)) => {
                findings.push(*violation);
                self.accept(places.clone());
                Seen::Usable(places)
            }
            None => {
                self.suspect = Some((poses.to_vec(), violation.clone()));
                Seen::SetAside(violation)
            }
        }
    }

    fn accept(&mut self, places: Vec<RobotPlace>) {
        (self.anchor, self.suspect) = (Some(places), None);
        self.legs.iter_mut().for_each(Vec::clear);
    }

    /// Whether two measured poses may be the same.
    fn is_same(&self, one: RobotPlace, other: RobotPlace) -> bool {
        let errors = self.run.errors;
        (one.at - other.at).norm() <= 2.0 * errors.place_um + ROUNDING_UM
            && turn_between(one.theta_rad, other.theta_rad).abs() <= 2.0 * errors.heading_rad + ROUNDING_RAD
    }

    /// The violation of the first robot that is not where the commands bring it.
    fn strayed(
        &mut self,
        anchor: &[RobotPlace],
        places: &[RobotPlace],
        step: usize,
        at_ns: u64,
    ) -> Option<Box<Violation>> {
        for robot in 0..places.len() {
            let expected = self.expected(robot, anchor[robot]);
            let off_um = (places[robot].at - expected.place.at).norm();
            let off_rad = turn_between(expected.place.theta_rad, places[robot].theta_rad).abs();
            let is_there = off_um <= expected.off_um && off_rad <= expected.off_rad;
            if is_there {
                self.remember(robot, at_ns, off_um, expected.off_um);
            } else if !self.was_stopped(robot, anchor[robot], places) {
                let (name, at) = (self.run.name(robot), ms(at_ns));
                // A difference of less than a picometre is rounding.
                let shown = |value: f64| digits(to_decimals(value, 6));
                let [off, may] = [off_um, expected.off_um].map(shown);
                let [turned, may_turn] = [off_rad, expected.off_rad.min(PI)].map(|rad| shown(rad.to_degrees()));
                let title = format!(
                    "at {at}, `{name}` is measured {off} um and {turned} deg from where the commands bring it; \
                     the device's errors allow {may} um and {may_turn} deg"
                );
                return Some(Box::new(self.run.within(Rule::Path, step, at_ns, title)));
            }
        }
        None
    }

    fn remember(&mut self, robot: usize, at_ns: u64, off_um: f64, allowed_um: f64) {
        let share = |deviation: &Deviation| deviation.off_um / deviation.allowed_um;
        let deviation = Deviation { robot: self.run.name(robot).to_owned(), at_ns, off_um, allowed_um };
        if self.farthest.as_ref().is_none_or(|(_, before)| share(&deviation) > share(before)) {
            self.farthest = Some((robot, deviation));
        }
    }

    fn expected(&self, robot: usize, anchor: RobotPlace) -> Expected {
        let errors = self.run.errors;
        let start = Expected { place: anchor, off_um: errors.place_um, off_rad: errors.heading_rad };
        let end = self.legs[robot].iter().fold(start, |so_far, leg| self.after(so_far, leg));
        Expected {
            place: end.place,
            off_um: end.off_um + errors.place_um + self.run.tolerances.path_um + ROUNDING_UM,
            off_rad: end.off_rad + errors.heading_rad + ROUNDING_RAD,
        }
    }

    fn after(&self, Expected { place, off_um, off_rad }: Expected, leg: &TrackedLeg) -> Expected {
        let (errors, path_um) = (self.run.errors, leg.path_um);
        let turned_rad = errors.turning_rad_per_um * path_um;
        let bent = leg.curve_um.map_or(0.0, |curve_um| 1.0 / curve_um.abs());
        Expected {
            place: place.driven(leg.curve_um, path_um),
            off_um: off_um + (off_rad + turned_rad / 2.0 + errors.speed_ratio) * path_um,
            off_rad: off_rad + turned_rad * (1.0 + errors.speed_ratio) + errors.speed_ratio * path_um * bent,
        }
    }

    /// Whether a robot touches another one and is where that one may have stopped it, after self-alignment.
    fn was_stopped(&self, robot: usize, anchor: RobotPlace, places: &[RobotPlace]) -> bool {
        let (docking, errors) = (self.run.order.facts.docking, self.run.errors);
        let half_um = self.reach_um(robot);
        let align_rad = docking.self_aligning_rad.max(docking.sticking_rad);
        let align_um = docking.self_aligning_um + half_um * align_rad;
        let measured = places[robot];
        let own = self.body(robot, measured);
        let touches = |other: usize| {
            let seen_um = 2.0 * errors.place_um + errors.heading_rad * (half_um + self.reach_um(other));
            let near_um = docking.tolerance_um + align_um + seen_um;
            let apart_um = (places[other].at - measured.at).norm() - half_um - self.reach_um(other);
            other != robot && apart_um <= near_um && own.gap_um(&self.body(other, places[other])) <= near_um
        };
        if !(0..places.len()).any(touches) {
            return false;
        }
        let mut so_far = Expected { place: anchor, off_um: errors.place_um, off_rad: errors.heading_rad };
        let fits = |at: &Expected, step_um: f64| {
            let off_um = (measured.at - at.place.at).norm();
            let off_rad = turn_between(at.place.theta_rad, measured.theta_rad).abs();
            off_um <= at.off_um + errors.place_um + align_um + self.run.tolerances.path_um + step_um
                && off_rad <= at.off_rad + errors.heading_rad + align_rad + step_um / self.turning_um(robot)
        };
        if fits(&so_far, ROUNDING_UM) {
            return true;
        }
        for leg in &self.legs[robot] {
            let steps = (leg.path_um / STOP_STEP_UM).ceil().clamp(1.0, MAX_STOP_STEPS);
            let step_um = leg.path_um / steps;
            for step in 1..=steps as u64 {
                let part = TrackedLeg { path_um: step_um * step as f64, ..*leg };
                if fits(&self.after(so_far, &part), step_um) {
                    return true;
                }
            }
            so_far = self.after(so_far, leg);
        }
        false
    }

    fn turning_um(&self, robot: usize) -> f64 {
        self.run.order.robot(robot).turning_radius_um
    }

    /// Half of a body's diagonal.
    fn reach_um(&self, robot: usize) -> f64 {
        let facts = self.run.order.robot(robot);
        facts.length_um.hypotenuse(facts.width_um) / 2.0
    }

    pub fn body(&self, robot: usize, place: RobotPlace) -> JudgedBody {
        body(self.run, robot, place)
    }

    /// The violation of a measured body that overlaps another one or an obstacle by more than the measurement errors.
    fn overlap(&self, places: &[RobotPlace], step: usize, at_ns: u64) -> Option<Box<Violation>> {
        let (order, errors) = (self.run.order, self.run.errors);
        let seen_um = |robot: usize| errors.place_um + errors.heading_rad * self.reach_um(robot);
        for robot in 0..places.len() {
            let own = self.body(robot, places[robot]);
            for other in 0..robot {
                let may_um = order.facts.docking.tolerance_um + seen_um(robot) + seen_um(other) + ROUNDING_UM;
                let apart_um = (places[other].at - places[robot].at).norm();
                if apart_um > self.reach_um(robot) + self.reach_um(other) {
                    continue;
                }
                let gap_um = own.gap_um(&self.body(other, places[other]));
                if gap_um < -may_um {
                    let (one, two) = (self.run.name(other), self.run.name(robot));
                    let (deep, at) = (digits(-gap_um), ms(at_ns));
                    let title = format!("`{one}` and `{two}` are measured with an overlap of {deep} um at {at}");
                    return Some(Box::new(self.run.within(Rule::Meet, step, at_ns, title)));
                }
            }
            // The body shrunk by the error of its measurement.
            let half_um = own.half_um.map(|half_um| (half_um - seen_um(robot) - ROUNDING_UM).max(0.0));
            let core = JudgedBody { half_um, ..own }.vertices();
            let mut near = self.boxes.meeting(&Extent::of(&core).widened(ROUNDING_UM)).into_iter();
            if let Some(obstacle) = near.find(|obstacle| self.solids[*obstacle].gap_um(&core) <= 0.0) {
                let (name, what) = (self.run.name(robot), &order.obstacles[obstacle]);
                let title = format!("`{name}` is measured inside `{}` at {}", what.name, ms(at_ns));
                let violation = self.run.within(Rule::Graze, step, at_ns, title);
                return Some(Box::new(violation.label(what.span, "this obstacle")));
            }
        }
        None
    }
}

/// The body of a robot at a pose.
pub(super) fn body(run: &JudgedRecording, robot: usize, place: RobotPlace) -> JudgedBody {
    let facts = run.order.robot(robot);
    let (sin, cos) = place.theta_rad.sine_cosine();
    let half_um = [facts.length_um / 2.0, facts.width_um / 2.0];
    JudgedBody { centre: place.at, along: Vector2::new(sin, cos), half_um }
}
