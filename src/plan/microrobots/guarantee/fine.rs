//! What the fine motion can correct, and what it leaves.
//!
//! Seen from the goal, with Y the place across at which a robot would dock if it ran straight, the curvature κ that it needs is
//! -Y / S(D), where S(D) = D(D + l)/2 is by how much a curvature moves the front of a robot of length l on a way D. An interval that is
//! driven with an error of curvature ε changes what is needed by ε (S(D) - S(D')) / S(D'); the sum over all intervals is what has to
//! be kept in reserve on both sides. ε has two parts: that of the measurement, E(D) / S(D), and the robot's own.

use crate::geometry::Pose;
use crate::plan::microrobots::strategy::{Cylinder, Driver, GoalFrame, steered};
use crate::real::Real;

/// The steepest heading that is reckoned with, against the normal of the edge.
const STEEPEST_RAD: f64 = 1.3;

/// With more intervals than these nothing is bounded.
const MAX_INTERVALS: f64 = 10_000.0;

/// So often the incidence and the reserve, which depend on each other, are worked out anew.
const ROUNDS: usize = 30;

/// A cylinder that is longer along the way to the goal.
#[derive(Debug, Clone, Copy)]
pub struct Region {
    pub cylinder: Cylinder,
    pub along_um: f64,
}

/// The bounds of a fine motion that begins in a cylinder.
#[derive(Debug, Clone, Copy)]
pub struct Last {
    /// A cylinder of this radius could just be corrected.
    pub reach_um: f64,
    /// At contact.
    pub incidence_rad: f64,
    /// At contact, once the robot lies flat.
    pub across_um: f64,
    /// By how much the curvature may differ from what is needed from the middle of the cylinder.
    pub bend_per_um: f64,
}

struct FineBounds<'a> {
    driver: &'a Driver<'a>,
    incidence_rad: f64,
    /// Of the heading when the fine motion begins.
    steepest_rad: f64,
    /// The longest way to the contact.
    way_um: f64,
}

impl Last {
    /// Of a robot that steers by a share of turning between two bounds.
    pub fn new(driver: &Driver, frame: &GoalFrame, approach: Pose, region: Region, shares: [f64; 2]) -> Self {
        let seen = frame.seen(approach);
        let steepest_rad = (seen.heading_rad.abs() + region.cylinder.heading_rad).min(STEEPEST_RAD);
        let [begin_rad, begin_bend_per_um, way_um] = met(driver, frame, approach, region, shares);
        let mut bounds = FineBounds { driver, incidence_rad: begin_rad, steepest_rad, way_um };
        for _ in 0..ROUNDS {
            bounds.incidence_rad = (begin_rad + bounds.reserve()[1]).min(STEEPEST_RAD);
        }
        let [reserve_per_um, _] = bounds.reserve();
        let reach_um = region.cylinder.radius_um + slack(driver, frame, seen, region, (shares, reserve_per_um));
        Last {
            reach_um,
            incidence_rad: bounds.incidence_rad,
            across_um: bounds.across_um(),
            bend_per_um: begin_bend_per_um + reserve_per_um,
        }
    }
}

/// Eight corners of a box that holds a cylinder, as poses of the world, and whether they are seen to lie apart from its middle.
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

/// If nothing went wrong any more: the steepest incidence from a cylinder, how far curvatures differ from the middle's, the
/// longest way.
fn met(driver: &Driver, frame: &GoalFrame, approach: Pose, region: Region, shares: [f64; 2]) -> [f64; 3] {
    let per_um = 1.0 / driver.robot.turning_radius_um;
    let share = |seen: Pose| steered(driver, frame, frame.placed(seen), shares).0;
    let middle = share(frame.seen(approach));
    let (mut incidence_rad, mut bend_per_um, mut way_um) = (0.0_f64, 0.0_f64, 0.0_f64);
    for corner in corners(frame, approach, region) {
        let share = share(corner);
        let contact = frame.met(corner, share * per_um);
        incidence_rad = incidence_rad.max(contact.map_or(STEEPEST_RAD, |contact| contact.incidence_rad.abs()));
        way_um = way_um.max(contact.map_or(0.0, |contact| contact.way_um));
        bend_per_um = bend_per_um.max((share - middle).abs() * per_um);
    }
    // Between the corners all change monotonically but for the curvature along the way, which a tenth covers.
    [incidence_rad, bend_per_um, way_um].map(|most| 1.1 * most)
}

/// By how much a cylinder could be larger and still be steered to the goal by shares that keep a reserve of curvature.
fn slack(
    driver: &Driver,
    frame: &GoalFrame,
    seen: Pose,
    region: Region,
    ([least, most], reserve_per_um): ([f64; 2], f64),
) -> f64 {
    let per_um = 1.0 / driver.robot.turning_radius_um;
    let (low, high) = (least * per_um + reserve_per_um, most * per_um - reserve_per_um);
    // The place across has at most one extreme along x within the cylinder; the sagitta bounds it.
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

impl FineBounds<'_> {
    fn length_um(&self) -> f64 {
        self.driver.robot.length_um
    }

    /// By how much a curvature moves the front on a way, at most, but for the incidence.
    fn moved(&self, way_um: f64) -> f64 {
        way_um * (way_um + self.length_um()) / 2.0
    }

    /// The same at least: on a way that bends as much as it can, against the normal of its end.
    fn moved_at_least(&self, way_um: f64) -> f64 {
        let bent_rad =
            (way_um / self.driver.robot.turning_radius_um).min(self.steepest_rad + self.incidence_rad).min(1.5);
        let lean_um = self.driver.robot.width_um / 2.0 * self.incidence_rad.sine();
        let least = way_um * (way_um * bent_rad.cosine() + self.length_um() - 2.0 * lean_um) / 2.0;
        least.max(1e-6)
    }

    /// What a measurement so far before the contact may cost across.
    fn measured_um(&self, way_um: f64) -> f64 {
        let errors = self.driver.errors;
        let lever_um = way_um + self.length_um() / 2.0;
        let lean_um = self.driver.robot.width_um / 2.0 * self.incidence_rad.sine() * errors.heading_rad;
        (errors.place_um + errors.heading_rad * lever_um) / self.incidence_rad.cosine() + lean_um
    }

    fn drift_per_um(&self) -> f64 {
        self.driver.errors.turning_rad_per_um * (1.0 + self.driver.errors.speed_ratio)
    }

    /// The shortest way to the contact at a measurement after which the share is still changed.
    fn shortest_um(&self) -> f64 {
        let errors = self.driver.errors;
        let unsure_um =
            errors.place_um + errors.heading_rad * self.length_um().hypotenuse(self.driver.robot.width_um) / 2.0;
        let over_um = self.driver.fine_interval_um * errors.speed_ratio;
        // A turn may bring the front ahead faster than the middle.
        (0.8 * (self.driver.kept_um - over_um - unsure_um)).max(0.05 * self.driver.kept_um)
    }

    /// How much the curvature that is needed may change, and the incidence with it, over all intervals; the last one that is
    /// steered anew lies as near to the contact as it may.
    fn reserve(&self) -> [f64; 2] {
        let step_um = self.driver.fine_interval_um * (1.0 + self.driver.errors.speed_ratio);
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

    /// The error across at contact: of the last measurement, of the way after it, and of a cycle that is broken off.
    fn across_um(&self) -> f64 {
        let errors = self.driver.errors;
        let robot = self.driver.robot;
        let unsure_um = errors.place_um + errors.heading_rad * self.length_um().hypotenuse(robot.width_um) / 2.0;
        let gap_um = self.driver.fine_interval_um + self.driver.kept_um + unsure_um;
        let steepest_rad = self.incidence_rad + 1.3 * gap_um / robot.turning_radius_um;
        // A turn takes back the corner that is ahead.
        let turning = robot.width_um / 2.0 / robot.turning_radius_um;
        let way_um = gap_um / (steepest_rad.min(STEEPEST_RAD).cosine() - turning).max(0.2);
        let cycle_um = self.driver.cycle_um;
        let ripple_um = (self.length_um() / 2.0 + cycle_um) * cycle_um / (8.0 * robot.turning_radius_um) + 0.01;
        let drift_um = self.drift_per_um() * self.moved(way_um);
        self.measured_um(way_um) + (drift_um + ripple_um) / self.incidence_rad.cosine()
    }
}
