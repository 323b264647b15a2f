//! Range of corrections of the fine motion, and its remaining error.
//!
//! Seen from the goal, let Y be the lateral place at which a robot would dock if it ran straight. It needs the
//! curvature κ = -Y / S(D), where S(D) = D(D + l)/2 is the lateral shift of the front of a robot of length l per unit
//! of curvature over a distance D. An interval driven with a curvature error ε changes the needed curvature by
//! ε (S(D) - S(D')) / S(D'); the sum over all intervals must be kept in reserve on both sides. ε has two parts: that of
//! the measurement, E(D) / S(D), and the robot's own.

use crate::geometry::Pose;
use crate::plan::microrobots::strategy::{Cylinder, GoalFrame, SteeringModel, steered};
use crate::real::Real;

/// Steepest heading considered, relative to the normal of the edge.
const STEEPEST_RAD: f64 = 1.3;

/// Most intervals; with more of them nothing is bounded.
const MAX_INTERVALS: f64 = 10_000.0;

/// Iterations of the incidence and the reserve, which depend on each other.
const ROUNDS: usize = 30;

/// A cylinder that is elongated along the path to the goal.
#[derive(Debug, Clone, Copy)]
pub struct Region {
    pub cylinder: Cylinder,
    pub along_um: f64,
}

/// Bounds of a fine motion that begins in a cylinder.
#[derive(Debug, Clone, Copy)]
pub struct FineMotionBounds {
    /// Radius of the largest correctable cylinder.
    pub reach_um: f64,
    /// Incidence at contact.
    pub incidence_rad: f64,
    /// Lateral offset at contact, once the robot lies flat.
    pub across_um: f64,
    /// Largest deviation of the needed curvature from that at the middle of the cylinder.
    pub bend_per_um: f64,
}

/// Bounds from which the reserve of curvature follows.
struct ReserveBounds<'a> {
    model: &'a SteeringModel<'a>,
    incidence_rad: f64,
    /// Steepest heading at the start of the fine motion.
    steepest_rad: f64,
    /// Longest path to the contact.
    way_um: f64,
}

impl FineMotionBounds {
    /// Bounds for a robot that steers by a share of turning between two limits.
    pub fn new(model: &SteeringModel, frame: &GoalFrame, approach: Pose, region: Region, shares: [f64; 2]) -> Self {
        let seen = frame.seen(approach);
        let steepest_rad = (seen.heading_rad.abs() + region.cylinder.heading_rad).min(STEEPEST_RAD);
        let [begin_rad, begin_bend_per_um, way_um] = met(model, frame, approach, region, shares);
        let mut bounds = ReserveBounds { model, incidence_rad: begin_rad, steepest_rad, way_um };
        for _ in 0..ROUNDS {
            bounds.incidence_rad = (begin_rad + bounds.reserve()[1]).min(STEEPEST_RAD);
        }
        let [reserve_per_um, _] = bounds.reserve();
        let reach_um = region.cylinder.radius_um + slack(model, frame, seen, region, shares, reserve_per_um);
        FineMotionBounds {
            reach_um,
            incidence_rad: bounds.incidence_rad,
            across_um: bounds.across_um(),
            bend_per_um: begin_bend_per_um + reserve_per_um,
        }
    }
}

/// The eight corners of a box that contains a cylinder, as poses of the world.
fn corners(frame: &GoalFrame, approach: Pose, region: Region) -> Vec<Pose> {
    let seen = frame.seen(approach);
    let off = |index: usize, bit: usize| if index & bit == 0 { -1.0 } else { 1.0 };
    let corner = |index: usize| Pose {
        x_um: seen.x_um + off(index, 1) * region.along_um,
        y_um: seen.y_um + off(index, 2) * region.cylinder.radius_um,
        heading_rad: seen.heading_rad + off(index, 4) * region.cylinder.heading_rad,
    };
    (0..8).map(corner).collect()
}

/// Without further errors: the steepest incidence from a cylinder, the largest deviation of the curvature from that at
/// the middle, and the longest path.
fn met(model: &SteeringModel, frame: &GoalFrame, approach: Pose, region: Region, shares: [f64; 2]) -> [f64; 3] {
    let per_um = 1.0 / model.robot.turning_radius_um;
    let share = |seen: Pose| steered(model, frame, frame.placed(seen), shares).0;
    let middle = share(frame.seen(approach));
    let (mut incidence_rad, mut bend_per_um, mut way_um) = (0.0_f64, 0.0_f64, 0.0_f64);
    for corner in corners(frame, approach, region) {
        let share = share(corner);
        let contact = frame.met(corner, share * per_um);
        incidence_rad = incidence_rad.max(contact.map_or(STEEPEST_RAD, |contact| contact.incidence_rad.abs()));
        way_um = way_um.max(contact.map_or(0.0, |contact| contact.way_um));
        bend_per_um = bend_per_um.max((share - middle).abs() * per_um);
    }
    // Between the corners everything changes monotonically except the curvature along the path; a margin of a tenth
    // covers that.
    [incidence_rad, bend_per_um, way_um].map(|most| 1.1 * most)
}

/// Amount by which a cylinder may be larger and still be steered to the goal by shares that keep a reserve of
/// curvature.
fn slack(
    model: &SteeringModel,
    frame: &GoalFrame,
    seen: Pose,
    region: Region,
    [least, most]: [f64; 2],
    reserve_per_um: f64,
) -> f64 {
    let per_um = 1.0 / model.robot.turning_radius_um;
    let (low, high) = (least * per_um + reserve_per_um, most * per_um - reserve_per_um);
    // The lateral place has at most one extremum along x within the cylinder; the sagitta bounds it.
    let sagitta_um = region.along_um * region.along_um * per_um / 2.0;
    let across = |ahead: f64, aside: f64, turn_per_um: f64| {
        let corner = Pose {
            x_um: seen.x_um + ahead * region.along_um,
            y_um: seen.y_um + aside * region.cylinder.radius_um,
            heading_rad: seen.heading_rad + aside * region.cylinder.heading_rad,
        };
        frame.met(corner, turn_per_um).map_or(f64::INFINITY, |contact| contact.across_um)
    };
    let most_um = across(-1.0, 1.0, low).max(across(1.0, 1.0, low)) + sagitta_um;
    let least_um = across(-1.0, -1.0, high).min(across(1.0, -1.0, high)) - sagitta_um;
    (-most_um).min(least_um)
}

impl ReserveBounds<'_> {
    fn length_um(&self) -> f64 {
        self.model.robot.length_um
    }

    /// Upper bound on the lateral shift of the front per unit of curvature over a distance, apart from the incidence.
    fn moved(&self, way_um: f64) -> f64 {
        way_um * (way_um + self.length_um()) / 2.0
    }

    /// Lower bound on the same: on a path of maximal curvature, relative to the normal of its end.
    fn moved_at_least(&self, way_um: f64) -> f64 {
        let bent_rad =
            (way_um / self.model.robot.turning_radius_um).min(self.steepest_rad + self.incidence_rad).min(1.5);
        let lean_um = self.model.robot.width_um / 2.0 * self.incidence_rad.sine();
        let least = way_um * (way_um * bent_rad.cosine() + self.length_um() - 2.0 * lean_um) / 2.0;
        least.max(1e-6)
    }

    /// Lateral error due to a measurement at this distance before the contact.
    fn measured_um(&self, way_um: f64) -> f64 {
        let errors = self.model.errors;
        let lever_um = way_um + self.length_um() / 2.0;
        let lean_um = self.model.robot.width_um / 2.0 * self.incidence_rad.sine() * errors.heading_rad;
        (errors.place_um + errors.heading_rad * lever_um) / self.incidence_rad.cosine() + lean_um
    }

    fn drift_per_um(&self) -> f64 {
        self.model.errors.turning_rad_per_um * (1.0 + self.model.errors.speed_ratio)
    }

    /// Shortest distance to the contact at a measurement after which the share is still adjusted.
    fn shortest_um(&self) -> f64 {
        let errors = self.model.errors;
        let unsure_um =
            errors.place_um + errors.heading_rad * self.length_um().hypotenuse(self.model.robot.width_um) / 2.0;
        let over_um = self.model.fine_interval_um * errors.speed_ratio;
        // A turn may advance the front faster than the middle.
        (0.8 * (self.model.kept_um - over_um - unsure_um)).max(0.05 * self.model.kept_um)
    }

    /// Change of the needed curvature, and of the incidence with it, over all intervals; the last steered interval lies
    /// as near to the contact as possible.
    fn reserve(&self) -> [f64; 2] {
        let step_um = self.model.fine_interval_um * (1.0 + self.model.errors.speed_ratio);
        let (mut per_um, mut turned_rad) = (0.0, self.drift_per_um() * self.way_um);
        let mut after_um = self.shortest_um();
        if (self.way_um - after_um) / step_um > MAX_INTERVALS {
            return [f64::INFINITY; 2];
        }
        while after_um < self.way_um {
            let before_um = after_um + step_um;
            let error_per_um = self.measured_um(before_um) / self.moved_at_least(before_um) + self.drift_per_um();
            let moved = (self.moved(before_um) - self.moved(after_um)) / self.incidence_rad.cosine();
            let changed_per_um = error_per_um * moved / self.moved_at_least(after_um);
            per_um += changed_per_um;
            turned_rad += changed_per_um * after_um;
            after_um = before_um;
        }
        // The measured share itself is off by the error of its measurement.
        let last_um = self.shortest_um() + step_um;
        per_um += self.measured_um(last_um) / self.moved_at_least(last_um);
        [per_um, turned_rad]
    }

    /// Lateral error at contact: of the last measurement, of the path after it, and of an interrupted cycle.
    fn across_um(&self) -> f64 {
        let errors = self.model.errors;
        let robot = self.model.robot;
        let unsure_um = errors.place_um + errors.heading_rad * self.length_um().hypotenuse(robot.width_um) / 2.0;
        let gap_um = self.model.fine_interval_um + self.model.kept_um + unsure_um;
        let steepest_rad = self.incidence_rad + 1.3 * gap_um / robot.turning_radius_um;
        // A turn moves the leading corner back.
        let turning = robot.width_um / 2.0 / robot.turning_radius_um;
        let way_um = gap_um / (steepest_rad.min(STEEPEST_RAD).cosine() - turning).max(0.2);
        let cycle_um = self.model.cycle_um;
        let ripple_um = (self.length_um() / 2.0 + cycle_um) * cycle_um / (8.0 * robot.turning_radius_um) + 0.01;
        let drift_um = self.drift_per_um() * self.moved(way_um);
        self.measured_um(way_um) + (drift_um + ripple_um) / self.incidence_rad.cosine()
    }
}
