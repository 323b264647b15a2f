//! STRING microrobots: stress-engineered scratch drives on one bed, all supplied with the same voltage.
//!
//! Facts, kinematics and vocabulary of the kind. Each robot lowers its steering arm at its own snap-down voltage and
//! raises it at its own release voltage; with the arm down it turns on a circle, with the arm up it runs straight.
//! Source of the model: Donald, Levey, Paprotny, Rus, *Simultaneous control of multiple MEMS microrobots*, WAFR 2008
//! (supporting material). Its headings and formulas are corrected (see the standard library's file).

use crate::geometry::Pose;
use crate::geometry::fault::{Fault, inject};
use crate::real::Real;
use serde::{Deserialize, Serialize};
use std::f64::consts::TAU;

pub mod control;
#[cfg(test)]
pub(crate) mod fixture;
mod words;

pub use words::{
    BedNoun, MicrorobotsObjective, MicrorobotsOutcome, MicrorobotsPlanner, MicrorobotsVerb, Turning, VOCABULARY,
};

/// Greatest number of robots in one table.
pub const MAX_ROBOTS: usize = 128;

/// Greatest number of obstacles in one scene.
pub const MAX_OBSTACLES: usize = 1_000;

/// Greatest number of levels in one control cycle.
pub const MAX_LEVELS: u32 = 64;

/// The channel name of a bed, without the device's name.
pub const CHANNEL: &str = "bed";

/// Position of a steering arm.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Arm {
    /// The robot runs straight.
    Up,
    /// The robot turns.
    Down,
}

impl Arm {
    /// The arm's digit in a control state: 1 for down.
    pub const fn digit(self) -> u8 {
        match self {
            Arm::Up => 0,
            Arm::Down => 1,
        }
    }
}

impl Turning {
    /// The sign of the turning rate: positive is counter-clockwise.
    pub const fn sign(self) -> f64 {
        match self {
            Turning::Clockwise => -1.0,
            Turning::Counterclockwise => 1.0,
        }
    }
}

/// One robot: a row of the device's table.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Robot {
    pub name: String,
    /// Snap-down voltage: at or above it the arm goes down.
    pub snap_down_v: f64,
    /// Release voltage: at or below it the arm goes up.
    pub release_v: f64,
    /// Radius of the circle of its centre, arm down.
    pub turning_radius_um: f64,
    /// Distance by which one pulse of the drive train moves its centre.
    pub step_um: f64,
    pub turning: Turning,
    /// Length of its body, along its heading; the pose is that of the body's centre.
    pub length_um: f64,
    /// Width of its body, across its heading.
    pub width_um: f64,
}

impl Robot {
    /// Pose of its centre after travelling `way_um`.
    ///
    /// The exact integral of the unicycle model with turning rate v/r (equation 4 of the paper, whose equation 5
    /// contradicts it).
    pub fn moved(&self, pose: Pose, arm: Arm, way_um: f64) -> Pose {
        let (sin, cos) = pose.heading_rad.sine_cosine();
        let way_um = inject(Fault::Stroke, way_um);
        match arm {
            Arm::Up => Pose { x_um: pose.x_um + way_um * cos, y_um: pose.y_um + way_um * sin, ..pose },
            Arm::Down => {
                let curve = self.turning.sign() * self.turning_radius_um;
                let heading_rad = pose.heading_rad + way_um / curve;
                let (later_sin, later_cos) = heading_rad.sine_cosine();
                Pose {
                    x_um: pose.x_um + curve * (later_sin - sin),
                    y_um: pose.y_um - curve * (later_cos - cos),
                    heading_rad: wrapped_rad(heading_rad),
                }
            }
        }
    }

    /// Centre of its turning circle.
    pub fn orbit_centre_um(&self, pose: Pose) -> [f64; 2] {
        let (sin, cos) = pose.heading_rad.sine_cosine();
        self.orbit_centre_facing_um(pose, [cos, sin])
    }

    /// The same, given the cosine and the sine of the heading.
    pub fn orbit_centre_facing_um(&self, pose: Pose, [cos, sin]: [f64; 2]) -> [f64; 2] {
        let curve = self.turning.sign() * self.turning_radius_um;
        [pose.x_um - curve * sin, pose.y_um + curve * cos]
    }

    /// Radius of the disc that its body sweeps on its orbit: the distance to the farthest corner.
    pub fn orbit_reach_um(&self) -> f64 {
        (self.turning_radius_um + self.width_um / 2.0).hypotenuse(self.length_um / 2.0)
    }
}

/// Wraps a heading to (-180, 180] degrees.
pub fn wrapped_rad(heading_rad: f64) -> f64 {
    let turned_rad = heading_rad.rem_euclid(TAU);
    if turned_rad > TAU / 2.0 { turned_rad - TAU } else { turned_rad }
}

/// Docking rules.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Docking {
    /// Greatest angle between the axes of two robots that meet head on at which they still align themselves.
    pub self_aligning_rad: f64,
    /// Greatest distance between their axes at which they still do.
    pub self_aligning_um: f64,
    /// Greatest angle from the normal of the edge at which a robot that meets a structure sticks.
    pub sticking_rad: f64,
    /// Greatest gap or overlap of docked bodies.
    pub tolerance_um: f64,
}

/// Fine motion: the last stretch before a goal, driven by alternating between turning and running straight.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Fine {
    /// Path length of the robot from the intermediate configuration to the goal.
    pub length_um: f64,
    /// Path length of one cycle, in which each of the two or three motion primitives occurs once.
    pub cycle_um: f64,
}

/// Bounds on the errors of robots and measurements.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Errors {
    /// Relative error of the speed.
    pub speed_ratio: f64,
    /// Heading error per micrometre of path.
    pub turning_rad_per_um: f64,
    /// Error of a measured position, in any direction.
    pub place_um: f64,
    /// Error of a measured heading.
    pub heading_rad: f64,
    /// Interval from one measurement to the next.
    pub replan_ns: u64,
}

impl Errors {
    /// Whether all are zero: robots and measurements are exact.
    pub fn are_zero(&self) -> bool {
        [self.speed_ratio, self.turning_rad_per_um, self.place_um, self.heading_rad] == [0.0; 4]
    }
}

/// Facts of a device of this kind: the fields of its declaration.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct MicrorobotsFacts {
    /// In the order of the table; 1 to [`MAX_ROBOTS`].
    pub robots: Vec<Robot>,
    /// Tolerance of each snap-down and release voltage, plus or minus.
    pub margin_v: f64,
    /// Greatest voltage of the source.
    pub max_v: f64,
    /// Voltage between the strokes of the drive train.
    pub relax_v: f64,
    /// Voltage at the strokes of the drive train.
    pub flex_v: f64,
    /// Duration of one stroke: half at the flex level, then half at the relax level. Even, at least 2.
    pub period_ns: u64,
    /// Duration of each level of a control cycle.
    pub dwell_ns: u64,
    /// Least distance of a moving body from obstacles and from other bodies.
    pub clearance_um: f64,
    /// Least distance of any body from the disc that an orbiting robot sweeps.
    pub orbit_clearance_um: f64,
    pub docking: Docking,
    pub fine: Fine,
    /// `None` unless the device states all of them; then nothing can be guaranteed or simulated.
    pub errors: Option<Errors>,
    /// Time without a measurement, counted from the end of the last command, after which a controller stops; `None`
    /// for the default.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub watchdog_ns: Option<u64>,
}

/// Default of the watchdog, in measurement intervals.
pub const WATCHDOG_INTERVALS: u64 = 5;

impl MicrorobotsFacts {
    /// Whether its errors are stated and all are zero.
    pub fn is_exact(&self) -> bool {
        self.errors.is_some_and(|errors| errors.are_zero())
    }

    /// Time for which a controller waits for a measurement after the end of its last command.
    pub fn watchdog_ns(&self) -> u64 {
        let interval_ns = self.errors.map_or(u64::MAX, |errors| errors.replan_ns);
        self.watchdog_ns.unwrap_or(interval_ns.saturating_mul(WATCHDOG_INTERVALS))
    }

    /// The index of a robot in the table, by name.
    pub fn row(&self, name: &str) -> Option<usize> {
        self.robots.iter().position(|robot| robot.name == name)
    }
}

/// An arm pattern that the bed's voltage can set, whatever the arms were before.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct ControlState {
    /// In the order of the table.
    pub arms: Vec<Arm>,
    /// The levels of its control cycle, each held for the dwell time; as few as possible.
    pub levels_v: Vec<f64>,
    /// Tolerance of each level within which the state of every arm is certain.
    pub slack_v: f64,
}

impl ControlState {
    /// One digit for each robot, in the order of the table.
    pub fn digits(&self) -> String {
        self.arms.iter().map(|arm| char::from(b'0' + arm.digit())).collect()
    }
}
