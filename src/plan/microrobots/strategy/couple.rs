//! The first two robots: making their paths end at the same time, and steering both with one cycle.

use super::{GoalFrame, Phase, Pursuit, SteeringModel, steered};
use crate::claims::microrobots::MicrorobotsOrder;
use crate::geometry::Pose;
use crate::real::Real;
use std::f64::consts::{FRAC_PI_2, TAU};

/// Range of the share of turning of the first robot and of the second: disjoint ranges allow independent choices.
pub const SHARES: [[f64; 2]; 2] = [[0.0, 0.5], [0.5, 1.0]];

/// Share of the fine motion by which one robot may be ahead of the other.
const MISSED_SHARE: f64 = 0.6;

/// Share of that which is accepted when the first robot begins its run.
const BEGUN_SHARE: f64 = 0.4;

/// Most that the intermediate pose slides on its line, to either side, in turning radii.
const SLIDE_SHARE: f64 = 0.5;

/// Largest single slide of the intermediate pose.
const SLIDE_STEP_UM: f64 = 30.0;

/// Least effect per micrometre for a slide to be useful.
const LEAST_EFFECT: f64 = 0.2;

/// Two robots that must meet.
#[derive(Debug, Clone)]
pub struct Couple<'a> {
    pub models: [SteeringModel<'a>; 2],
    /// Path length of the second robot per micrometre of the first.
    pub ratio: f64,
    /// Poses at which the fine motion begins.
    pub approach: [Pose; 2],
    /// Largest distance by which one may be ahead of the other, as path length of the first.
    pub missed_um: f64,
    intermediate: Pose,
    /// Shift back by whole circles of the second robot, which would otherwise have too little time.
    back_um: f64,
    slid_um: f64,
}

impl<'a> Couple<'a> {
    /// `None` if the device does not state its errors.
    pub fn new(
        order: &'a MicrorobotsOrder,
        [first, second]: [usize; 2],
        intermediate: Pose,
        approach: [Pose; 2],
    ) -> Option<Self> {
        let models = [SteeringModel::new(order, first)?, SteeringModel::new(order, second)?];
        let ratio = models[1].robot.step_um / models[0].robot.step_um;
        let missed_um = MISSED_SHARE * order.facts.fine.length_um;
        Some(Couple { models, ratio, approach, missed_um, intermediate, back_um: 0.0, slid_um: 0.0 })
    }

    /// Most that the intermediate pose slides.
    pub fn slide_um(&self) -> f64 {
        SLIDE_SHARE * self.models[0].robot.turning_radius_um
    }

    /// Pose at which the first robot's own drive should end, moved back by its slide.
    pub fn intermediate(&self) -> Pose {
        let (sin, cos) = self.approach[0].heading_rad.sine_cosine();
        let at = self.intermediate;
        let off_um = self.slid_um + self.back_um;
        Pose { x_um: at.x_um - off_um * cos, y_um: at.y_um - off_um * sin, ..at }
    }

    fn circle_um(&self) -> f64 {
        TAU * self.models[1].robot.turning_radius_um / self.ratio
    }

    /// Largest distance by which one may be ahead when the first begins its run.
    pub fn begun_um(&self) -> f64 {
        BEGUN_SHARE * self.missed_um
    }

    /// Gives the second robot the time that it needs, by starting the first robot's run farther back or less far back
    /// than planned: the paper's bound t_4π on a run that must be repeated.
    pub fn give_time(&mut self, second: &Pursuit, measured: Pose, round: usize) {
        let least_um = second.least_um(&self.models[1], measured) / self.ratio;
        (self.back_um, self.slid_um) = (0.0, 0.0);
        let short_um = least_um - self.run_um(self.intermediate()) - self.begun_um();
        let circles = (short_um / self.circle_um()).ceil();
        // In the first round the run is not shortened: the plan's own paths are known to be free.
        self.back_um = if round == 0 { circles.max(0.0) } else { circles } * self.circle_um();
    }

    /// Whether the second robot has time for another circle of its orbit before it leaves it.
    pub fn has_time(&self, second: &Pursuit, measured: [Pose; 2]) -> bool {
        let spare_um = self.run_um(measured[0]) - second.left_um(&self.models[1], measured[1]) / self.ratio;
        spare_um > 0.75 * self.circle_um()
    }

    /// Distance that the first robot must run along its line from a pose.
    pub fn run_um(&self, from: Pose) -> f64 {
        let (sin, cos) = self.approach[0].heading_rad.sine_cosine();
        (self.approach[0].x_um - from.x_um) * cos + (self.approach[0].y_um - from.y_um) * sin
    }

    /// Delay of the first robot, as a distance, if both were driven to their approaches, the first via the intermediate
    /// pose; between minus and plus half of the second one's circle.
    pub fn late_um(&self, pursuits: [&Pursuit; 2], measured: [Pose; 2]) -> f64 {
        let first_um = match pursuits[0].phase {
            Phase::Arrived => self.run_um(measured[0]),
            Phase::Facing | Phase::Running | Phase::Finishing | Phase::Turning => {
                pursuits[0].left_um(&self.models[0], measured[0]) + self.run_um(self.intermediate())
            }
        };
        let second_um = pursuits[1].left_um(&self.models[1], measured[1]) / self.ratio;
        let circle_um = self.circle_um();
        let late_um = (first_um - second_um).rem_euclid(circle_um);
        if late_um > circle_um / 2.0 { late_um - circle_um } else { late_um }
    }

    /// Slides the intermediate pose so that both arrive at the same time, as far as that helps.
    pub fn slide(&mut self, pursuit: &mut Pursuit, second: &Pursuit, measured: [Pose; 2]) {
        let before_um = self.slid_um;
        let late_um = self.late_um([&*pursuit, second], measured);
        self.aim(pursuit, before_um + 1.0);
        let effect = self.late_um([&*pursuit, second], measured) - late_um;
        let is_useful = (LEAST_EFFECT..10.0).contains(&effect.abs());
        let step_um = if is_useful { (-late_um / effect).clamp(-SLIDE_STEP_UM, SLIDE_STEP_UM) } else { 0.0 };
        self.aim(pursuit, (before_um + step_um).clamp(-self.slide_um(), self.slide_um()));
    }

    fn aim(&mut self, pursuit: &mut Pursuit, slid_um: f64) {
        self.slid_um = slid_um;
        pursuit.aim(&self.models[0], self.intermediate());
    }

    /// The centre of a loop of the first robot that compensates for its being late: the paper's racetrack, beside the
    /// line.
    pub fn racetrack(&self, late_um: f64) -> [f64; 2] {
        let model = &self.models[0];
        let circles_um = [model, &self.models[1]].map(|model| TAU * model.robot.turning_radius_um);
        let run_um = (-late_um - circles_um[0]).rem_euclid(circles_um[1] / self.ratio) / 2.0;
        let [x_um, y_um] = model.robot.orbit_centre_um(self.intermediate());
        let (sin, cos) = (self.approach[0].heading_rad + model.side() * FRAC_PI_2).sine_cosine();
        [x_um + run_um * cos, y_um + run_um * sin]
    }

    /// Frames of both goals, with their edges where the robots will meet.
    pub fn frames(&self, goals: [Pose; 2], measured: [Pose; 2]) -> [GoalFrame; 2] {
        let mut frames = [0, 1].map(|at| GoalFrame::new(self.models[at].robot, goals[at], 0.0));
        let ways_um = [0, 1].map(|at| {
            let (share, _) = steered(&self.models[at], &frames[at], measured[at], SHARES[at]);
            let seen = frames[at].seen(measured[at]);
            let contact = frames[at].met(seen, share / self.models[at].robot.turning_radius_um);
            contact.map_or(frames[at].gap_um(seen), |contact| contact.way_um)
        });
        let met_um = (ways_um[0] + ways_um[1]) / (1.0 + self.ratio);
        let shift_um = met_um - ways_um[0];
        frames[0].edge_um += shift_um;
        frames[1].edge_um -= shift_um;
        frames
    }
}
