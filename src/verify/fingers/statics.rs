//! Whether fingers hold the part still: equilibrium and removal as linear programs.
//!
//! In the plane of a section each contact bears a normal and a tangential force within a friction cone, whose apex lies at the
//! pull-off force where tips stick; the load across the plane is borne in equal shares. Instead of asking whether forces exist that balance
//! the load, the program finds those deepest inside all cones, and by how much they are inside: [`TOLERANCE`] below zero still holds,
//! so that what is exactly in balance does. Tips that only push also balance by not touching at all, so without a load it is asked
//! whether forces whose normal parts sum to 1 balance.

use super::Point;
use super::body::Pose;
use crate::check::claims::fingers::FingersOrder;
use crate::device::fingers::Plane;
use crate::real::Real;
use microlp::{ComparisonOp, OptimizationDirection, Problem, Variable};

/// How far outside of its cone a force may be, as a share of the forces that matter: those that load, pull or hold.
pub(super) const TOLERANCE: f64 = 1e-6;

/// What missing the wanted sum of normal forces counts against being deep inside the cones.
const SUM_WEIGHT: f64 = 1e3;

/// Where a tip touches, in section coordinates.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Touch {
    pub point_um: [f64; 2],
    /// The direction of the outward normal.
    pub normal_rad: f64,
}

impl Touch {
    /// The inward normal and the tangent.
    fn directions(&self) -> [[f64; 2]; 2] {
        let (y, x) = self.normal_rad.sine_cosine();
        [[-x, -y], [-y, x]]
    }
}

/// The forces on a held part besides those of its contacts, in section coordinates; micronewtons.
#[derive(Debug, Clone, Copy)]
pub(super) struct Statics<'a> {
    order: &'a FingersOrder,
    load_un: [f64; 2],
    across_un: f64,
    centre_um: [f64; 2],
    reach_um: f64,
}

/// Pushes and pulls of one contact: along its inward normal and its tangent.
struct Bearing {
    normal: Variable,
    tangential: Variable,
}

impl<'a> Statics<'a> {
    /// Of a part in a pose.
    pub fn of(order: &'a FingersOrder, plane: Plane, pose: &Pose, reach_um: f64) -> Self {
        let load_un = Point::from(order.load_un);
        let [x, y, z] = pose.axes(plane).map(|axis| axis.dot(&load_un));
        let centre_um = Point::from(order.part.centre_um);
        let [first, second] = plane.axes().map(|axis| Point::from(axis).dot(&centre_um));
        Statics { order, load_un: [x, y], across_un: z.abs(), centre_um: [first, second], reach_um }
    }

    /// Whether contacts hold the part by themselves. Tips that only push must do so without the load too: a part that merely rests
    /// on them is not held.
    pub fn holds(&self, touches: &[Touch]) -> bool {
        let holds = |statics: &Statics| statics.margin(touches, None).is_some_and(|margin| margin >= -TOLERANCE);
        let sticks = self.order.facts.sticking_un() > 0.0;
        holds(self) && (sticks || holds(&Statics { load_un: [0.0; 2], across_un: 0.0, ..*self }))
    }

    /// Whether contacts hold the part while a finger is pulled off elsewhere.
    pub fn resists(&self, touches: &[Touch], leaving: &Touch) -> bool {
        self.margin(touches, Some(leaving)).is_some_and(|margin| margin >= -TOLERANCE)
    }

    /// How deep inside their cones forces can be that balance the load and the pull on a contact that is left; `None` if none balance.
    fn margin(&self, touches: &[Touch], leaving: Option<&Touch>) -> Option<f64> {
        let facts = &self.order.facts;
        let pull_un = facts.sticking_un() * facts.removal_safety;
        let load_un = self.load_un[0].hypotenuse(self.load_un[1]).max(self.across_un);
        let is_idle = facts.sticking_un() == 0.0 && load_un == 0.0;
        let unit_un = if is_idle { 1.0 } else { facts.sticking_un().max(pull_un).max(load_un) };
        let mut problem = Problem::new(OptimizationDirection::Maximize);
        let depth = problem.add_var(1.0, (f64::NEG_INFINITY, 1.0));
        // Idle forces have no size: what counts is their sum.
        let most = if is_idle { 2.0 } else { facts.max_force_un / unit_un };
        let bearings = self.bearings(&mut problem, touches, depth, (unit_un, most));
        if is_idle {
            let sum: Vec<_> = bearings.iter().map(|bearing| (bearing.normal, 1.0)).collect();
            problem.add_constraint(&sum, ComparisonOp::Eq, 1.0);
        }
        let pull = leaving.map(|touch| {
            let [[x, y], _] = touch.directions();
            (touch.point_um, [-x * pull_un, -y * pull_un])
        });
        self.balance(&mut problem, touches, &bearings, pull, unit_un);
        Some(problem.solve().ok()?.into_solution().ok()?.var_value(depth))
    }

    /// Forces of contacts in cones.
    fn bearings(
        &self,
        problem: &mut Problem,
        touches: &[Touch],
        depth: Variable,
        (unit_un, most): (f64, f64),
    ) -> Vec<Bearing> {
        let facts = &self.order.facts;
        let sticking = facts.sticking_un() / unit_un;
        let share = self.across_un / unit_un / touches.len() as f64;
        let bearing = |_: &Touch| {
            let normal = problem.add_var(0.0, (-sticking, f64::INFINITY));
            let tangential = problem.add_var(0.0, (f64::NEG_INFINITY, f64::INFINITY));
            let room = facts.friction * sticking - share;
            for sign in [1.0, -1.0] {
                let cone = [(tangential, sign), (normal, -facts.friction), (depth, 1.0)];
                problem.add_constraint(cone, ComparisonOp::Le, room);
            }
            problem.add_constraint([(normal, 1.0), (depth, 1.0)], ComparisonOp::Le, most);
            Bearing { normal, tangential }
        };
        touches.iter().map(bearing).collect()
    }

    /// Forces and torques about the centre of mass sum to zero.
    fn balance(
        &self,
        problem: &mut Problem,
        touches: &[Touch],
        bearings: &[Bearing],
        pull: Option<([f64; 2], [f64; 2])>,
        unit_un: f64,
    ) {
        let mut rows: [(Vec<(Variable, f64)>, f64); 3] = Default::default();
        let mut bear = |variable: Option<Variable>, point_um: [f64; 2], [x, y]: [f64; 2]| {
            let arm = [0, 1].map(|axis| (point_um[axis] - self.centre_um[axis]) / self.reach_um);
            for (row, part) in rows.iter_mut().zip([x, y, arm[0] * y - arm[1] * x]) {
                match variable {
                    Some(variable) => row.0.push((variable, part)),
                    None => row.1 -= part / unit_un,
                }
            }
        };
        for (touch, bearing) in touches.iter().zip(bearings) {
            let [inward, tangent] = touch.directions();
            bear(Some(bearing.normal), touch.point_um, inward);
            bear(Some(bearing.tangential), touch.point_um, tangent);
        }
        bear(None, self.centre_um, self.load_un);
        if let Some((point_um, force_un)) = pull {
            bear(None, point_um, force_un);
        }
        for (row, right) in rows {
            problem.add_constraint(&row, ComparisonOp::Eq, right);
        }
    }

    /// The forces of contacts on the part that are deepest inside the cones while their normal parts sum to `sum_un`, or as nearly as
    /// can be: along the section's axes, in micronewtons. `None` if none balance.
    pub fn forces_un(&self, touches: &[Touch], sum_un: f64) -> Option<Vec<[f64; 2]>> {
        let unit_un = self.order.facts.max_force_un;
        let mut problem = Problem::new(OptimizationDirection::Maximize);
        let depth = problem.add_var(1.0, (-TOLERANCE, 1.0));
        let bearings = self.bearings(&mut problem, touches, depth, (unit_un, 1.0));
        self.balance(&mut problem, touches, &bearings, None, unit_un);
        let missed = problem.add_var(-SUM_WEIGHT, (0.0, f64::INFINITY));
        for (sign, op) in [(1.0, ComparisonOp::Ge), (-1.0, ComparisonOp::Le)] {
            let mut sum: Vec<_> = bearings.iter().map(|bearing| (bearing.normal, 1.0)).collect();
            sum.push((missed, sign));
            problem.add_constraint(&sum, op, sum_un / unit_un);
        }
        let solution = problem.solve().ok()?.into_solution().ok()?;
        let force = |(touch, bearing): (&Touch, &Bearing)| {
            let [inward, tangent] = touch.directions();
            let [normal, tangential] =
                [bearing.normal, bearing.tangential].map(|variable| solution.var_value(variable));
            [0, 1].map(|axis| (normal * inward[axis] + tangential * tangent[axis]) * unit_un)
        };
        Some(touches.iter().zip(&bearings).map(force).collect())
    }
}
