//! The closed-loop strategy that brings robots to their goals, defined once: `simulate` executes it, `guarantee` bounds
//! it.
//!
//! Input: the data of a robot and the bounds on the errors; a measured pose. Output: the arm's actions until the next
//! measurement. The two steps are those of the paper's section 3.2 (error detection and recovery).
//!
//! **Gross motion** (`pursuit`). While its arm is down a robot turns about a fixed centre; while it is up the centre
//! moves along the heading. So a path is a list of centres, and after the last one a turn to the required heading. A
//! robot turns to one side only, so an error of its heading to the other side costs a circle. Hence it never turns all
//! the way to its target: it keeps a lag, the largest drift to the bad side that the bounds allow on the rest of the
//! path, plus the uncertainty of the measurement. With the lag λ(D) = u + asin(ωD/2), where D is the distance, ω the
//! bound on the curvature and u the uncertainty of the measured direction, the true direction of the target stays on
//! the good side all the way: asin(ωD/2) is the angle of the chord of the most curved path, and a path that starts
//! outside of it and bends less stays outside. Excess over the lag is corrected at every measurement, at once and
//! cheaply. The remainder at the target is the excess of the last interval; [`SteeringModel::cylinder`] bounds it. A
//! circle is driven where a new target lies less than the lag ahead, and where the heading has passed the last one;
//! that is the paper's δ(t_2π).
//!
//! **Fine motion** (`approach`). At every measurement the share of the cycle with the arm down is chosen so that the
//! robot is laterally in its place once one of its front corners has met the edge and it has turned about that corner
//! until its front lies flat. Since the bed may rest, an interval of the fine motion is at most a tenth of its length,
//! whatever the time between measurements. When less than an eighth would be left after another interval, the share is
//! kept until contact: so near, a measurement changes the place by less than its own error.
//!
//! **Two robots at once** (`couple`). The second orbits while the first is driven, and the first runs straight,
//! uncorrected, while the second is driven. They arrive simultaneously if the first has as far to run along its line as
//! the second has to its approach; a delay of the first is compensated by sliding the pose at which its own drive ends
//! along its line, and, where that does not help, by a racetrack. If they still miss each other by too much of the fine
//! motion, everything restarts from the measured poses. In the fine motion the first turns for at most, the second for
//! at least half of a cycle, so that each can be steered independently; they stick together where they meet.

mod approach;
mod bodies;
mod couple;
mod episode;
mod pursuit;

pub use approach::{EdgeContact, GoalFrame, bent, steered};
pub use bodies::{BodyCorners, StrategySolid, body, edge_gap_um, obstacles};
pub use couple::{Couple, SHARES};
pub use episode::{Episode, centres, driven, episodes, poses_of};
pub use pursuit::{Phase, Pursuit, PursuitCircle};

use crate::claims::microrobots::MicrorobotsOrder;
use crate::device::microrobots::{Arm, Errors, Robot, wrapped_rad};
use crate::geometry::Pose;
use crate::real::Real;
use std::f64::consts::TAU;

/// Least number of intervals of the fine motion.
const FINE_INTERVALS: f64 = 10.0;

/// The last 1/`KEPT_PARTS` of the fine motion is driven with the last chosen share.
const KEPT_PARTS: f64 = 8.0;

/// An interval near a target is at most 1/`NEAR_INTERVALS` of the fine motion.
const NEAR_INTERVALS: f64 = 6.0;

/// Least distance of a target, in errors of a centre, at which its direction is still measured.
const SURE_CENTRES: f64 = 20.0;

/// Centres nearer to each other than this coincide.
pub const SAME_UM: f64 = 1e-6;

/// A path segment with the arm up or down.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct StrategyPiece {
    pub arm: Arm,
    /// Nominal, in micrometres of the driven robot's path.
    pub way_um: f64,
}

/// Model by which a robot is steered: its data, the bounds on its errors, and its intervals.
#[derive(Debug, Clone, Copy)]
pub struct SteeringModel<'a> {
    pub robot: &'a Robot,
    pub errors: Errors,
    /// Nominal path between two measurements, in gross motion.
    pub interval_um: f64,
    /// The same near a target, and at the end of the last turn: the bed rests for the remainder.
    pub near_interval_um: f64,
    /// The same in fine motion: whole cycles.
    pub fine_interval_um: f64,
    /// If less than this would be left after another interval, the share of the last cycles is kept.
    pub kept_um: f64,
    /// Path length of one cycle of the fine motion.
    pub cycle_um: f64,
}

/// A disc of positions about a pose, with an interval of headings.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Cylinder {
    pub radius_um: f64,
    /// To either side.
    pub heading_rad: f64,
}

impl Cylinder {
    /// Whether it contains `pose` when centred on `about`.
    pub fn holds(&self, about: Pose, pose: Pose) -> bool {
        let off_um = (pose.x_um - about.x_um).hypotenuse(pose.y_um - about.y_um);
        off_um <= self.radius_um && wrapped_rad(pose.heading_rad - about.heading_rad).abs() <= self.heading_rad
    }
}

impl<'a> SteeringModel<'a> {
    /// `None` if the device does not state its errors.
    pub fn new(order: &'a MicrorobotsOrder, robot: usize) -> Option<Self> {
        let facts = &order.facts;
        let errors = facts.errors?;
        let robot = order.robot(robot);
        let strokes = (errors.replan_ns / facts.period_ns).max(1) as f64;
        let interval_um = strokes * robot.step_um;
        let cycle_um = facts.fine.cycle_um.min(interval_um).min(facts.fine.length_um);
        let most_um = interval_um.min(facts.fine.length_um / FINE_INTERVALS);
        let fine_interval_um = cycle_um * (most_um / cycle_um).floor().max(1.0);
        let kept_um = facts.fine.length_um / KEPT_PARTS;
        let near_interval_um = interval_um.min(facts.fine.length_um / NEAR_INTERVALS);
        Some(SteeringModel { robot, errors, interval_um, near_interval_um, fine_interval_um, kept_um, cycle_um })
    }

    /// +1 if it turns counter-clockwise.
    pub fn side(&self) -> f64 {
        self.robot.turning.sign()
    }

    /// Bound on the error of the measured centre of its turns.
    pub fn centre_error_um(&self) -> f64 {
        self.errors.place_um + self.robot.turning_radius_um * self.errors.heading_rad
    }

    /// Bound on the angular error of a turn, per micrometre of its nominal path.
    pub fn miss_rad_per_um(&self) -> f64 {
        let speed = self.errors.speed_ratio;
        speed / self.robot.turning_radius_um + (1.0 + speed) * self.errors.turning_rad_per_um
    }

    /// Bound on the creep of its centre while it turns on a nominal path of this length.
    pub fn creep_um(&self, way_um: f64) -> f64 {
        self.robot.turning_radius_um * self.errors.turning_rad_per_um * (1.0 + self.errors.speed_ratio) * way_um
    }

    /// Bound on the creep of its centre in a full circle; allowance for orbiting robots.
    pub fn orbit_error_um(&self) -> f64 {
        self.creep_um(TAU * self.robot.turning_radius_um)
    }

    /// Bound on the error of the direction of a target at this distance, including the contribution of an interval.
    pub fn aim_error_rad(&self, distance_um: f64) -> f64 {
        let off_um = self.centre_error_um() + self.creep_um(self.interval_um.min(distance_um));
        self.errors.heading_rad + (off_um / distance_um.max(off_um).max(SAME_UM)).arc_sine()
    }

    /// Lag kept from the direction of a target, on the side from which corrections are cheap.
    pub fn lag_rad(&self, distance_um: f64) -> f64 {
        let chord = self.errors.turning_rad_per_um * (distance_um + self.centre_error_um()) / 2.0;
        self.aim_error_rad(distance_um) + chord.min(1.0).arc_sine()
    }

    /// Measured distance within which a target counts as reached.
    pub fn capture_um(&self) -> f64 {
        1.5 * self.centre_error_um() + SAME_UM
    }

    /// Measured distance of the centre from a new target within which that is skipped: the centre could not reliably be
    /// brought nearer.
    pub fn left_alone_um(&self) -> f64 {
        self.centre_miss_um() - self.centre_error_um()
    }

    /// Least distance to a target at which a corrected interval ends, so that no target is passed unnoticed, and the
    /// noise of a measured centre turns the robot only slightly.
    pub fn guard_um(&self) -> f64 {
        let passed_um = self.centre_error_um() + self.errors.speed_ratio * self.interval_um;
        (2.0 * passed_um).max(SURE_CENTRES * self.centre_error_um()) + SAME_UM
    }

    /// Largest distance between a centre and its target, before the last turn.
    pub fn centre_miss_um(&self) -> f64 {
        let centre_um = self.centre_error_um();
        let left_um = self.near_interval_um + self.guard_um() + centre_um;
        let drift = self.errors.turning_rad_per_um;
        let off_um = 2.0 * (centre_um + self.creep_um(self.interval_um.min(left_um)));
        let excess_um = 2.0 * self.miss_rad_per_um() * left_um * left_um / 4.0;
        let across_um = off_um + 2.0 * self.errors.heading_rad * left_um + drift * left_um * left_um + excess_um;
        let along_um = centre_um + self.errors.speed_ratio * left_um + 0.05 * across_um;
        across_um.hypotenuse(along_um).max(self.capture_um() + centre_um)
    }

    /// Bound on the true end of the gross motion: the paper's δ(t_2π) for this strategy, measured once more and
    /// accepted.
    pub fn cylinder(&self) -> Cylinder {
        let heading_rad = self.errors.heading_rad + self.near_interval_um * self.miss_rad_per_um() + 1e-9;
        let circle_um = self.creep_um(TAU * self.robot.turning_radius_um);
        let radius_um = self.centre_miss_um() + circle_um + self.robot.turning_radius_um * heading_rad + SAME_UM;
        Cylinder {
            radius_um: radius_um + 2.0 * self.errors.place_um,
            heading_rad: heading_rad + 2.0 * self.errors.heading_rad,
        }
    }

    /// Measured poses within this count as arrived.
    pub fn accepted(&self) -> Cylinder {
        let true_one = self.cylinder();
        Cylinder {
            radius_um: true_one.radius_um - self.errors.place_um,
            heading_rad: true_one.heading_rad - self.errors.heading_rad,
        }
    }
}

/// Angle reduced to the range from 0 to a full turn, the latter excluded.
pub fn turn(angle_rad: f64) -> f64 {
    let turned_rad = angle_rad.rem_euclid(TAU);
    if turned_rad >= TAU { 0.0 } else { turned_rad }
}
