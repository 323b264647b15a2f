//! Equilibrium of a grasp, and its resistance to the removal of a finger, as linear programs.
//!
//! Each contact bears a normal force, tangential forces in the plane of the section and across it, whose magnitudes
//! add up to at most the friction, and a torque about its normal within `torsion`; where tips stick, both limits begin
//! at the pull-off force. Forces and torques in space balance the load. Instead of only deciding whether such forces
//! exist, the program finds those deepest inside all cones and returns their depth. A depth of at least -[`TOLERANCE`]
//! counts as held, so that an exact balance passes. Tips that only push are also in balance with zero forces, so
//! without a load the normal forces must sum to 1.

use super::super::geometry::contour::Foot;
use super::Point;
use super::body::ObjectPose;
use crate::claims::fingers::FingersOrder;
use crate::device::fingers::{Adhesion, FingersFacts, Plane};
use crate::real::Real;
use microlp::{ComparisonOp, OptimizationDirection, Problem, Variable};

/// Greatest excess of a force over its cone, relative to the largest of the load, the pull and the pull-off force.
pub(super) const TOLERANCE: f64 = 1e-6;

/// Weight of a deviation from the wanted sum of normal forces, relative to the depth inside the cones; large, so that
/// the sum takes precedence.
const SUM_WEIGHT: f64 = 1e3;

/// Fraction of a load, or of a lever, below which it counts as zero (rounding).
const ROUNDING: f64 = 1e-9;

/// The contact of a tip, in section coordinates.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct ContactPoint {
    pub point_um: [f64; 2],
    /// The direction of the outward normal.
    pub normal_rad: f64,
}

impl ContactPoint {
    pub fn at(foot: &Foot) -> ContactPoint {
        ContactPoint { point_um: foot.point_um, normal_rad: foot.normal_rad }
    }

    /// The inward normal and the tangent.
    fn directions(&self) -> [[f64; 2]; 2] {
        let (y, x) = self.normal_rad.sine_cosine();
        [[-x, -y], [-y, x]]
    }
}

/// The load on a held part, without the contact forces, in section coordinates and micronewtons.
#[derive(Debug, Clone, Copy)]
pub(super) struct Statics<'a> {
    order: &'a FingersOrder,
    load_un: [f64; 2],
    /// Along the plane's normal.
    across_un: f64,
    centre_um: [f64; 2],
    /// Height of the centre of mass above the plane.
    height_um: f64,
    reach_um: f64,
}

/// Force variables of one contact, along its inward normal and its tangent.
struct ContactForces {
    normal: Variable,
    tangential: Variable,
    /// Variables out of the plane; `None` if the load has no such component.
    out_of_plane: Option<OutOfPlane>,
}

/// The force across the plane, and the torque about the inward normal as a force at the part's reach.
#[derive(Clone, Copy)]
struct OutOfPlane {
    across: Variable,
    torque: Variable,
}

/// Pull-off force of a tip, in micronewtons; 0 for tips that do not stick.
pub(super) fn pull_off_un(facts: &FingersFacts) -> f64 {
    if facts.adhesion == Adhesion::Sticking { facts.pull_off_un } else { 0.0 }
}

impl<'a> Statics<'a> {
    /// Load on a part in a pose.
    pub fn of(order: &'a FingersOrder, plane: Plane, pose: &ObjectPose, reach_um: f64) -> Self {
        let load_un = Point::from(order.load_un);
        let [x, y, z] = pose.axes(plane).map(|axis| axis.dot(&load_un));
        let centre_um = Point::from(order.part.centre_um);
        let [first, second] = plane.axes().map(|axis| Point::from(axis).dot(&centre_um));
        let height_um = Point::from(plane.normal()).dot(&centre_um);
        Statics { order, load_un: [x, y], across_un: z, centre_um: [first, second], height_um, reach_um }
    }

    /// Magnitude of the load, in the plane and across it.
    fn size_un(&self) -> f64 {
        self.load_un[0].hypotenuse(self.load_un[1]).hypotenuse(self.across_un)
    }

    /// Whether the load has a component across the plane, or a torque that turns the part out of it.
    fn is_spatial(&self) -> bool {
        let [x_un, y_un] = self.load_un;
        let torque_un_um = self.height_um.abs() * x_un.hypotenuse(y_un);
        self.across_un.abs().max(torque_un_um / self.reach_um) > ROUNDING * self.size_un()
    }

    /// Whether the contacts alone hold the part. Tips that only push must also hold it without the load: a part that
    /// merely rests on them is not held.
    pub fn holds(&self, touches: &[ContactPoint]) -> bool {
        let holds = |statics: &Statics| statics.margin(touches, None).is_some_and(|margin| margin >= -TOLERANCE);
        let sticks = pull_off_un(&self.order.facts) > 0.0;
        holds(self) && (sticks || holds(&Statics { load_un: [0.0; 2], across_un: 0.0, ..*self }))
    }

    /// Whether the contacts hold the part while a finger is pulled off elsewhere.
    pub fn resists(&self, touches: &[ContactPoint], leaving: &ContactPoint) -> bool {
        self.margin(touches, Some(leaving)).is_some_and(|margin| margin >= -TOLERANCE)
    }

    /// Depth inside their cones of the best forces that balance the load and the pull on a leaving contact; `None` if
    /// none balance.
    fn margin(&self, touches: &[ContactPoint], leaving: Option<&ContactPoint>) -> Option<f64> {
        let facts = &self.order.facts;
        let pull_un = pull_off_un(facts) * facts.removal_safety;
        let load_un = self.size_un();
        let is_idle = pull_off_un(facts) == 0.0 && load_un == 0.0;
        let unit_un = if is_idle { 1.0 } else { pull_off_un(facts).max(pull_un).max(load_un) };
        let mut problem = Problem::new(OptimizationDirection::Maximize);
        let depth = problem.add_var(1.0, (f64::NEG_INFINITY, 1.0));
        // Without a load the scale of the forces is free: only their sum is fixed.
        let most = if is_idle { 2.0 } else { facts.max_force_un / unit_un };
        let contact_variables = self.contact_variables(&mut problem, touches, depth, unit_un, most);
        if is_idle {
            let sum: Vec<_> = contact_variables.iter().map(|contact| (contact.normal, 1.0)).collect();
            problem.add_constraint(&sum, ComparisonOp::Eq, 1.0);
        }
        let pull = leaving.map(|touch| {
            let [[x, y], _] = touch.directions();
            (touch.point_um, [-x * pull_un, -y * pull_un])
        });
        self.balance(&mut problem, touches, &contact_variables, pull, unit_un);
        Some(problem.solve().ok()?.into_solution().ok()?.var_value(depth))
    }

    /// Adds variables and friction cones for the forces of the contacts.
    fn contact_variables(
        &self,
        problem: &mut Problem,
        touches: &[ContactPoint],
        depth: Variable,
        unit_un: f64,
        most: f64,
    ) -> Vec<ContactForces> {
        let facts = &self.order.facts;
        let sticking = pull_off_un(facts) / unit_un;
        let is_spatial = self.is_spatial();
        let contact = |_: &ContactPoint| {
            let normal = problem.add_var(0.0, (-sticking, f64::INFINITY));
            let tangential = problem.add_var(0.0, (f64::NEG_INFINITY, f64::INFINITY));
            let room = facts.friction * sticking;
            let out_of_plane = is_spatial.then(|| self.out_of_plane(problem, normal, unit_un, sticking));
            let cone = |sign: f64| [(tangential, sign), (normal, -facts.friction), (depth, 1.0)];
            for sign in [1.0, -1.0] {
                match out_of_plane {
                    None => problem.add_constraint(cone(sign), ComparisonOp::Le, room),
                    Some(OutOfPlane { across, .. }) => [1.0, -1.0].into_iter().for_each(|other| {
                        let [tangential, normal, depth] = cone(sign);
                        let pyramid = [tangential, normal, depth, (across, other)];
                        problem.add_constraint(pyramid, ComparisonOp::Le, room);
                    }),
                }
            }
            problem.add_constraint([(normal, 1.0), (depth, 1.0)], ComparisonOp::Le, most);
            ContactForces { normal, tangential, out_of_plane }
        };
        touches.iter().map(contact).collect()
    }

    /// Adds variables and limits for the out-of-plane forces of a contact. The lever of the load is known only to the
    /// tolerance of contacts, so a torque of that size is ignored.
    fn out_of_plane(&self, problem: &mut Problem, normal: Variable, unit_un: f64, sticking: f64) -> OutOfPlane {
        let facts = &self.order.facts;
        let across = problem.add_var(0.0, (f64::NEG_INFINITY, f64::INFINITY));
        let torque = problem.add_var(0.0, (f64::NEG_INFINITY, f64::INFINITY));
        let torsion = facts.torsion_um / self.reach_um;
        let slack = facts.tolerance_um / self.reach_um * self.size_un() / unit_un;
        for sign in [1.0, -1.0] {
            problem.add_constraint([(torque, sign), (normal, -torsion)], ComparisonOp::Le, torsion * sticking + slack);
        }
        OutOfPlane { across, torque }
    }

    /// Adds the balance of forces, and of torques about the centre of mass.
    fn balance(
        &self,
        problem: &mut Problem,
        touches: &[ContactPoint],
        contact_variables: &[ContactForces],
        pull: Option<([f64; 2], [f64; 2])>,
        unit_un: f64,
    ) {
        let mut rows: [(Vec<(Variable, f64)>, f64); 6] = Default::default();
        let mut add = |variable: Option<Variable>, parts: [f64; 6]| {
            for (row, part) in rows.iter_mut().zip(parts) {
                match variable {
                    // A rounded zero would only spoil the solver's scale.
                    Some(variable) => row.0.push((variable, if part.abs() < ROUNDING { 0.0 } else { part })),
                    None => row.1 -= part / unit_un,
                }
            }
        };
        // A force along the section's axes and normal, with its torques about them as forces at the part's reach.
        let force = |point_um: [f64; 2], [x, y, z]: [f64; 3]| {
            let [along, beside] = [0, 1].map(|axis| (point_um[axis] - self.centre_um[axis]) / self.reach_um);
            let behind = -self.height_um / self.reach_um;
            [x, y, along * y - beside * x, z, beside * z - behind * y, behind * x - along * z]
        };
        for (touch, contact) in touches.iter().zip(contact_variables) {
            let [[x, y], [along, beside]] = touch.directions();
            add(Some(contact.normal), force(touch.point_um, [x, y, 0.0]));
            add(Some(contact.tangential), force(touch.point_um, [along, beside, 0.0]));
            if let Some(OutOfPlane { across, torque }) = contact.out_of_plane {
                add(Some(across), force(touch.point_um, [0.0, 0.0, 1.0]));
                add(Some(torque), [0.0, 0.0, 0.0, 0.0, x, y]);
            }
        }
        let [x_un, y_un] = self.load_un;
        // The load acts at the centre of mass and has no torque about it.
        add(None, [x_un, y_un, 0.0, self.across_un, 0.0, 0.0]);
        if let Some((point_um, [x_un, y_un])) = pull {
            add(None, force(point_um, [x_un, y_un, 0.0]));
        }
        let count = if self.is_spatial() { 6 } else { 3 };
        for (row, right) in rows.into_iter().take(count) {
            problem.add_constraint(&row, ComparisonOp::Eq, right);
        }
    }

    /// The forces of the contacts on the part that are deepest inside the cones while their normal parts sum to
    /// `sum_un`, or as nearly as possible: along the section's axes and across it, in micronewtons. `None` if none
    /// balance.
    pub fn forces_un(&self, touches: &[ContactPoint], sum_un: f64) -> Option<Vec<[f64; 3]>> {
        let unit_un = self.order.facts.max_force_un;
        let mut problem = Problem::new(OptimizationDirection::Maximize);
        let depth = problem.add_var(1.0, (-TOLERANCE, 1.0));
        let contact_variables = self.contact_variables(&mut problem, touches, depth, unit_un, 1.0);
        self.balance(&mut problem, touches, &contact_variables, None, unit_un);
        let missed = problem.add_var(-SUM_WEIGHT, (0.0, f64::INFINITY));
        for (sign, op) in [(1.0, ComparisonOp::Ge), (-1.0, ComparisonOp::Le)] {
            let mut sum: Vec<_> = contact_variables.iter().map(|contact| (contact.normal, 1.0)).collect();
            sum.push((missed, sign));
            problem.add_constraint(&sum, op, sum_un / unit_un);
        }
        let solution = problem.solve().ok()?.into_solution().ok()?;
        let force = |(touch, contact): (&ContactPoint, &ContactForces)| {
            let [inward, tangent] = touch.directions();
            let [normal, tangential] =
                [contact.normal, contact.tangential].map(|variable| solution.var_value(variable));
            let across = contact.out_of_plane.map_or(0.0, |out_of_plane| solution.var_value(out_of_plane.across));
            let [x, y] = [0, 1].map(|axis| normal * inward[axis] + tangential * tangent[axis]);
            [x, y, across].map(|part| part * unit_un)
        };
        Some(touches.iter().zip(&contact_variables).map(force).collect())
    }
}
