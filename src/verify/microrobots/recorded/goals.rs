//! Checks the goals of a recorded run against its measurements.
//!
//! A driven robot is at its goal if it is measured within the precision of the task plus the error of a measurement.
//! Docked robots are compared with one another, since their structure stands where its first two robots met: the goals
//! are fitted to the measured positions by the rigid motion of least squares. If every robot is within d of its place
//! in the true structure and is measured within p of its position, the n squared residuals of the best fit sum to at
//! most n (d + p)², so no robot is farther off than √n (d + p).

use super::super::motion::{RobotPlace, turn_between};
use super::measured::body;
use super::{GoalReached, JudgedRecording};
use crate::claims::Relation;
use crate::claims::microrobots::{Dock, MicrorobotsAction, MicrorobotsStop};
use crate::device::microrobots::MicrorobotsOutcome;
use crate::quantity::digits;
use crate::real::Real;
use crate::verify::rule::{Findings, Rule, ms};
use nalgebra::{Point2, Rotation2, Vector2};

/// Rounding that does not count as a deviation.
const ROUNDING_UM: f64 = 1e-3;
const ROUNDING_RAD: f64 = 1e-6;

/// Progress towards the goals.
pub(super) struct Goals<'r, 'a> {
    run: &'r JudgedRecording<'a>,
    /// Number of stops that the driven robot has passed in the current step.
    passed: usize,
    pub reached: Vec<GoalReached>,
}

impl<'r, 'a> Goals<'r, 'a> {
    pub fn new(run: &'r JudgedRecording<'a>) -> Self {
        Goals { run, passed: 0, reached: Vec::new() }
    }

    /// Allowed distance from a goal, and allowed angle from its heading.
    fn allowed(&self) -> [f64; 2] {
        let (precision, errors, tolerances) = (self.run.order.precision, self.run.errors, self.run.tolerances);
        [
            precision.place_um + errors.place_um + tolerances.goal_um + ROUNDING_UM,
            precision.heading_rad + errors.heading_rad + tolerances.heading_rad + ROUNDING_RAD,
        ]
    }

    fn is_at(&self, place: RobotPlace, stop: &MicrorobotsStop) -> bool {
        let ([off_um, off_rad], [may_um, may_rad]) = (place.off(&stop.pose), self.allowed());
        off_um <= may_um && off_rad <= may_rad
    }

    /// Passes the stops at which the driven robot is measured within a step.
    pub fn pass(&mut self, step: usize, places: &[RobotPlace]) {
        let Some(MicrorobotsAction::Drive { robot, stops }) = self.run.order.steps.get(step).map(|step| &step.action)
        else {
            return;
        };
        while self.passed + 1 < stops.len() && self.is_at(places[*robot], &stops[self.passed]) {
            self.passed += 1;
        }
    }

    /// Checks the goals of a step that is over.
    pub fn end_step(
        &mut self,
        step: usize,
        at_ns: u64,
        places: &[RobotPlace],
        docked: &[bool],
        findings: &mut Findings,
    ) {
        let passed = std::mem::take(&mut self.passed);
        match &self.run.order.steps[step].action {
            MicrorobotsAction::Drive { robot, stops } => {
                let Some(goal) = stops.last() else { return };
                let name = self.run.name(*robot);
                let missed = stops.get(passed).filter(|_| passed + 1 < stops.len());
                let ([off_um, off_rad], [allowed_um, allowed_rad]) = (places[*robot].off(&goal.pose), self.allowed());
                let title = match missed {
                    Some(stop) => {
                        let off = self.off(places[*robot], stop);
                        format!("`{name}` is not measured at a stop in its turn: at {} it is {off}", ms(at_ns))
                    }
                    None if self.is_at(places[*robot], goal) => {
                        let (robot, is_docked) = (name.to_owned(), false);
                        self.reached.push(GoalReached { robot, is_docked, off_um, allowed_um, off_rad, allowed_rad });
                        return;
                    }
                    None => {
                        format!(
                            "`{name}` misses its goal: at {} it is measured {}",
                            ms(at_ns),
                            self.off(places[*robot], goal)
                        )
                    }
                };
                let violation = self.run.within(Rule::Goal, step, at_ns, title);
                findings.push(violation.label(missed.unwrap_or(goal).span, "this stop"));
            }
            MicrorobotsAction::Assemble(docks) => self.assembled(step, at_ns, docks, places, docked, findings),
            MicrorobotsAction::Apply { .. } | MicrorobotsAction::Wait(_) => {}
        }
    }

    /// Distance from a stop, in words.
    fn off(&self, place: RobotPlace, stop: &MicrorobotsStop) -> String {
        let ([off_um, off_rad], [may_um, may_rad]) = (place.off(&stop.pose), self.allowed());
        distances([off_um, off_rad], [may_um, may_rad])
    }

    /// The robots of an assembly are docked, touch one another, and form the structure of their goals.
    fn assembled(
        &mut self,
        step: usize,
        at_ns: u64,
        docks: &[Dock],
        places: &[RobotPlace],
        docked: &[bool],
        findings: &mut Findings,
    ) {
        let (run, at) = (self.run, ms(at_ns));
        if let Some(dock) = docks.iter().find(|dock| !docked[dock.robot]) {
            let title = format!("the assembly ends at {at}, but `{}` is not considered docked", run.name(dock.robot));
            findings.push(run.within(Rule::Dock, step, at_ns, title).label(dock.goal.span, "this goal"));
            return;
        }
        let seen_um = |robot: usize| {
            let facts = run.order.robot(robot);
            run.errors.place_um + run.errors.heading_rad * facts.length_um.hypotenuse(facts.width_um) / 2.0
        };
        let standing: Vec<usize> = (0..places.len()).filter(|robot| docked[*robot]).collect();
        let fit = StructureFit::of(docks, places);
        let [may_um, may_rad] = fit.allowed(run, docks);
        for dock in docks {
            let (robot, name) = (dock.robot, run.name(dock.robot));
            let own = body(run, robot, places[robot]);
            let gap_um =
                |other: &usize| own.gap_um(&body(run, *other, places[*other])) - seen_um(*other) - seen_um(robot);
            let others = standing.iter().filter(|other| **other != robot);
            let apart_um = others.map(gap_um).fold(f64::INFINITY, f64::min);
            let [off_um, off_rad] = fit.off(dock, places[robot]);
            let title = if apart_um > run.order.facts.docking.tolerance_um + run.tolerances.goal_um + ROUNDING_UM {
                format!("at {at}, `{name}` is measured at least {} um from every docked robot", digits(apart_um))
            } else if off_um > may_um || off_rad > may_rad {
                let off = distances([off_um, off_rad], [may_um, may_rad])
                    .replace("from there", "from its place in the structure");
                format!("at {at}, `{name}` is measured {off}")
            } else {
                let (robot, is_docked) = (name.to_owned(), true);
                let (allowed_um, allowed_rad) = (may_um, may_rad);
                self.reached.push(GoalReached { robot, is_docked, off_um, allowed_um, off_rad, allowed_rad });
                continue;
            };
            findings.push(run.within(Rule::Dock, step, at_ns, title).label(dock.goal.span, "this goal"));
        }
    }
}

fn distances([off_um, off_rad]: [f64; 2], [may_um, may_rad]: [f64; 2]) -> String {
    let [off, may] = [off_um, may_um].map(digits);
    let [turned, may_turn] = [off_rad, may_rad].map(|rad| digits(rad.to_degrees()));
    format!("{off} um and {turned} deg from there; at most {may} um and {may_turn} deg are allowed")
}

/// The rigid motion that fits the goals of an assembly to the measured positions.
struct StructureFit {
    /// Counter-clockwise.
    turn: Rotation2<f64>,
    planned: Point2<f64>,
    found: Point2<f64>,
    /// Square root of the sum of the squared distances of the goals from their mean.
    spread_um: f64,
}

impl StructureFit {
    fn of(docks: &[Dock], places: &[RobotPlace]) -> StructureFit {
        let count = docks.len().max(1) as f64;
        let goal = |dock: &Dock| Vector2::new(dock.goal.pose.x_um, dock.goal.pose.y_um);
        let at = |dock: &Dock| places[dock.robot].at.coords;
        let middle = |of: &dyn Fn(&Dock) -> Vector2<f64>| docks.iter().map(of).sum::<Vector2<f64>>() / count;
        let (planned, found) = (middle(&goal), middle(&at));
        let (mut cross, mut dot, mut square) = (0.0, 0.0, 0.0);
        for dock in docks {
            let (a, b) = (goal(dock) - planned, at(dock) - found);
            cross += a.x * b.y - a.y * b.x;
            dot += a.dot(&b);
            square += a.norm_squared();
        }
        let turn = Rotation2::new(cross.arc_tangent_over(dot));
        StructureFit { turn, planned: planned.into(), found: found.into(), spread_um: square.sqrt() }
    }

    /// Deviation of a measured robot from its place in the structure, in micrometres and radians.
    fn off(&self, dock: &Dock, place: RobotPlace) -> [f64; 2] {
        let goal = RobotPlace::of(&dock.goal.pose);
        let due = self.found + self.turn * (goal.at - self.planned);
        [(place.at - due).norm(), turn_between(goal.theta_rad - self.turn.angle(), place.theta_rad).abs()]
    }

    /// Allowed deviation of each robot, in micrometres and radians.
    fn allowed(&self, run: &JudgedRecording, docks: &[Dock]) -> [f64; 2] {
        let (order, errors, tolerances) = (run.order, run.errors, run.tolerances);
        let count = docks.len() as f64;
        // Each contact of a chain may be off by the docking tolerance.
        let true_um = order.precision.place_um + (count - 1.0) * order.facts.docking.tolerance_um;
        let most_um = count.sqrt() * (true_um + errors.place_um);
        // The rotation error of the fit is bounded by the position errors over the spread of the goals.
        let fit_rad = 2.0 * most_um / self.spread_um.max(most_um);
        [
            most_um + tolerances.goal_um + ROUNDING_UM,
            order.precision.heading_rad + errors.heading_rad + fit_rad + tolerances.heading_rad + ROUNDING_RAD,
        ]
    }
}

/// The time limits, for the measured duration of the run.
pub(super) fn time(run: &JudgedRecording, took_ns: u64, findings: &mut Findings) {
    let granted_s = run.tolerances.time_ns as f64 / 1e9;
    let took_s = took_ns as f64 / 1e9;
    for requirement in run.job.requirements.iter().filter(|one| one.outcome == MicrorobotsOutcome::Time.name()) {
        let is_kept = match requirement.relation {
            Relation::Less | Relation::AtMost | Relation::Equal => took_s <= requirement.limit + granted_s,
            Relation::AtLeast | Relation::More => took_s >= requirement.limit - granted_s,
        };
        if !is_kept {
            let (took, limit) = (digits(took_s), digits(requirement.limit));
            let title = format!("the run took {took} s; the program's limit is {limit} s");
            let last = run.order.steps.len().saturating_sub(1);
            findings.push(run.within(Rule::Requirement, last, took_ns, title).label(requirement.span, "this limit"));
        }
    }
}
