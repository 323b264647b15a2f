//! Whether there is room for all possible deviations of robots from their paths.
//!
//! Paths are checked every few micrometres of their length, with half of that distance added to the deviation, so that
//! nothing in between is missed.

use super::StageContext;
use super::fine::FineMotionBounds;
use crate::geometry::Pose;
use crate::plan::microrobots::strategy::{
    BodyCorners, GoalFrame, SteeringModel, StrategySolid, bent, body, steered, turn,
};
use crate::real::Real;
use std::f64::consts::{E, TAU};

/// Step between two checks of a body.
const SAMPLE_STEP_UM: f64 = 5.0;

/// Most checks of one piece of a path; errors that need more are not bounded.
const MAX_SAMPLES: f64 = 10_000.0;

/// Room beyond this is not measured exactly.
pub const ENOUGH_UM: f64 = 500.0;

/// Bodies at rest or in motion around a driven robot.
pub struct Surroundings {
    pub free: Vec<StrategySolid>,
    /// Each with its possible displacement.
    pub docked: Vec<(StrategySolid, f64)>,
}

impl Surroundings {
    /// The tightest spot so far or at this body, whichever has less room to spare.
    pub fn tightest(
        &self,
        body: &BodyCorners,
        needs_um: f64,
        so_far: Option<Room>,
        is_met: &impl Fn(&StrategySolid) -> bool,
    ) -> Option<Room> {
        let free = self.free.iter().map(|solid| (solid, 0.0));
        let docked = self.docked.iter().filter(|(solid, _)| !is_met(solid)).map(|(solid, stray_um)| (solid, *stray_um));
        let mut tightest = so_far;
        for (solid, stray_um) in free.chain(docked) {
            let room =
                (solid.name.as_str(), needs_um + stray_um, solid.distance_um(body, needs_um + stray_um + ENOUGH_UM));
            if tightest.as_ref().is_none_or(|(_, needs_um, has_um)| room.2 - room.1 < has_um - needs_um) {
                tightest = Some((room.0.to_owned(), room.1, room.2));
            }
        }
        tightest
    }
}

/// Name of the obstruction, required room, available room.
pub type Room = (String, f64, f64);

/// An unbounded path: no room is sufficient.
pub fn unbounded() -> Room {
    (String::new(), f64::INFINITY, 0.0)
}

/// Whether a path is short enough to be checked every few micrometres.
pub fn can_be_sampled(way_um: f64, step_um: f64) -> bool {
    way_um / step_um <= MAX_SAMPLES
}

/// A piece of the nominal path.
struct NominalPiece {
    from: Pose,
    /// Counter-clockwise is positive.
    turn_per_um: f64,
    way_um: f64,
    stray_um: f64,
}

/// A gross motion with the possible deviations of a robot.
pub struct GrossMotion<'a> {
    model: &'a SteeringModel<'a>,
    parts: Vec<NominalPiece>,
    /// The motion without errors.
    nominal: Vec<NominalPiece>,
    /// Possible displacement of the approach with the structure.
    pub shift_um: f64,
    /// For every turn before a run, and for the last one: the angle it needs so that no circle is driven, and its
    /// actual angle; in radians.
    pub turns_rad: Vec<[f64; 2]>,
    /// The nominal length, and its possible deviation if no circle is driven.
    pub length_um: [f64; 2],
}

impl<'a> GrossMotion<'a> {
    /// Gross motion from the start of the stage, or from any place on that orbit, via centres to the approach.
    pub fn new(
        bed: &StageContext,
        model: &'a SteeringModel<'a>,
        robot: usize,
        via_um: &[[f64; 2]],
        approach: Pose,
    ) -> Self {
        let shift_um = bed.structure.of_um(approach);
        let mut way = GrossMotion::between(model, shift_um);
        let start = bed.episode.poses[robot];
        way.walk(start, via_um, approach, bed.structure.heading_rad, !bed.is_first);
        way
    }

    /// A motion without parts; its approach may be displaced by `shift_um`.
    pub fn between(model: &'a SteeringModel<'a>, shift_um: f64) -> Self {
        GrossMotion {
            model,
            parts: Vec::new(),
            nominal: Vec::new(),
            shift_um,
            turns_rad: Vec::new(),
            length_um: [0.0; 2],
        }
    }

    /// The largest deviation.
    pub fn stray_um(&self) -> f64 {
        self.parts.iter().map(|part| part.stray_um).fold(0.0, f64::max)
    }

    /// Nominal pose at this distance before the end; on the first orbit if the motion is shorter than that.
    pub fn left(&self, mut left_um: f64) -> Pose {
        for part in self.nominal.iter().rev() {
            if left_um <= part.way_um {
                return bent(part.from, part.turn_per_um, part.way_um - left_um);
            }
            left_um -= part.way_um;
        }
        self.nominal.first().map_or(Pose::at(0.0, 0.0), |part| bent(part.from, part.turn_per_um, -left_um))
    }

    /// Adds the path from a known pose, or from any place on its orbit.
    pub fn walk(&mut self, start: Pose, via_um: &[[f64; 2]], approach: Pose, tilt_rad: f64, is_orbiting: bool) {
        let model = self.model;
        let mut centre_um = model.robot.orbit_centre_um(start);
        let mut heading_rad = start.heading_rad;
        let last_um = model.robot.orbit_centre_um(approach);
        let circle_um = model.creep_um(TAU * model.robot.turning_radius_um);
        let shift_um = self.shift_um + tilt_rad * model.robot.turning_radius_um;
        let (mut off_um, mut unsure_rad) = (circle_um + model.centre_error_um(), model.errors.heading_rad);
        let count = via_um.len();
        for (index, next_um) in via_um.iter().copied().chain([last_um]).enumerate() {
            let moved_um = if index == count { shift_um } else { 0.0 };
            let (dx_um, dy_um) = (next_um[0] - centre_um[0], next_um[1] - centre_um[1]);
            let run_um = dx_um.hypotenuse(dy_um);
            if run_um <= model.left_alone_um() + moved_um {
                off_um += run_um + moved_um;
                centre_um = next_um;
                continue;
            }
            let direction_rad = dy_um.arc_tangent_over(dx_um);
            let stray = Stray::new(model, run_um, off_um + moved_um);
            let slack_rad = [unsure_rad, stray.heading_rad + model.lag_rad(run_um)];
            self.turn(centre_um, [heading_rad, direction_rad], slack_rad, off_um, is_orbiting && index == 0);
            self.run(centre_um, direction_rad, run_um, &stray);
            (centre_um, heading_rad) = (next_um, direction_rad);
            (off_um, unsure_rad) = (model.centre_miss_um() + circle_um + moved_um, stray.heading_rad);
        }
        let unsure = [unsure_rad, tilt_rad + model.cylinder().heading_rad];
        self.turn(centre_um, [heading_rad, approach.heading_rad], unsure, off_um, false);
    }

    /// Adds a turn about a centre; a full circle if it may become one.
    fn turn(&mut self, centre_um: [f64; 2], [from, to]: [f64; 2], [before, after]: [f64; 2], off_um: f64, any: bool) {
        let (side, radius_um) = (self.model.side(), self.model.robot.turning_radius_um);
        let angle_rad = turn(side * (to - from));
        let needs_rad = before + after;
        let way_um = angle_rad * radius_um;
        let pose = self.on_circle(centre_um, from);
        self.nominal.push(NominalPiece { from: pose, turn_per_um: side / radius_um, way_um, stray_um: 0.0 });
        self.turns_rad.push([needs_rad, angle_rad]);
        let (begin_rad, swept_rad) = match any || angle_rad < needs_rad || angle_rad + needs_rad >= TAU {
            true => (from, TAU),
            false => (from - side * before, angle_rad + needs_rad),
        };
        let from = self.on_circle(centre_um, begin_rad);
        let way_um = swept_rad * radius_um;
        self.parts.push(NominalPiece { from, turn_per_um: side / radius_um, way_um, stray_um: off_um });
        self.length_um[0] += angle_rad * radius_um;
    }

    fn on_circle(&self, [x_um, y_um]: [f64; 2], heading_rad: f64) -> Pose {
        let (sin, cos) = heading_rad.sine_cosine();
        let arm_um = self.model.side() * self.model.robot.turning_radius_um;
        Pose { x_um: x_um + arm_um * sin, y_um: y_um - arm_um * cos, heading_rad }
    }

    fn run(&mut self, centre_um: [f64; 2], direction_rad: f64, run_um: f64, stray: &Stray) {
        let radius_um = self.model.robot.turning_radius_um;
        let from = self.on_circle(centre_um, direction_rad);
        self.nominal.push(NominalPiece { from, turn_per_um: 0.0, way_um: run_um, stray_um: 0.0 });
        // With the centre on its line, a heading error moves the body mostly along the line, and hardly sideways.
        let (tilt_rad, reach_um) =
            (stray.heading_rad, self.model.robot.length_um.hypotenuse(self.model.robot.width_um) / 2.0);
        let (longer_um, aside_um) = (radius_um * tilt_rad, radius_um * tilt_rad * tilt_rad / 2.0);
        let from = bent(from, 0.0, -longer_um);
        let stray_um = stray.place_um + aside_um + reach_um * tilt_rad;
        self.parts.push(NominalPiece { from, turn_per_um: 0.0, way_um: run_um + 2.0 * longer_um, stray_um });
        self.length_um[0] += run_um;
        // Turns add up to the required change of heading, minus the robot's own drift.
        let errors = self.model.errors;
        let turned_um = errors.turning_rad_per_um * run_um * radius_um;
        self.length_um[1] += run_um * tilt_rad * tilt_rad / 2.0 + turned_um + self.model.centre_miss_um();
    }

    /// The spot with the least room, if there is anything around.
    pub fn tightest(&self, around: &Surroundings) -> Option<Room> {
        let mut tightest = None;
        for part in &self.parts {
            let samples = (part.way_um / SAMPLE_STEP_UM).ceil().max(1.0);
            if !can_be_sampled(part.way_um, SAMPLE_STEP_UM) {
                return Some(unbounded());
            }
            for sample in 0..=samples as u64 {
                let pose = bent(part.from, part.turn_per_um, part.way_um * sample as f64 / samples);
                let half_um = self.half_look_um(part.turn_per_um);
                let whole = body(self.model.robot, pose, 0.0);
                tightest = around.tightest(&whole, part.stray_um + half_um, tightest, &|_| false);
            }
        }
        tightest
    }

    fn half_look_um(&self, turn_per_um: f64) -> f64 {
        let reach_um = self.model.robot.length_um.hypotenuse(self.model.robot.width_um) / 2.0;
        SAMPLE_STEP_UM / 2.0 * (1.0 + reach_um * turn_per_um.abs())
    }
}

/// Possible deviation of a robot from a straight path between two turns.
struct Stray {
    place_um: f64,
    heading_rad: f64,
}

impl Stray {
    /// The direction lags by at most 2 ε + 2 u/D + ω D/2 plus the contribution of an interval, where ε is the error of
    /// a measured heading, u that of a centre and ω the bound on the curvature; integrated along the path this gives
    /// the offset from the line.
    fn new(model: &SteeringModel, run_um: f64, off_um: f64) -> Self {
        let errors = model.errors;
        let interval_um = model.interval_um.min(run_um);
        let drift = errors.turning_rad_per_um;
        let centre_um = model.centre_error_um() + model.creep_um(model.interval_um);
        let steady_rad = 2.0 * errors.heading_rad + drift * interval_um;
        let first_rad = 2.0 * model.miss_rad_per_um() * interval_um;
        // Sagitta of the most curved path. A steady error s of the measured direction adds the offset s·D·ln(L/D) at
        // distance D from the target of a run L: at most s·L/e.
        let bulge_um = drift * run_um * run_um / 8.0 + steady_rad * run_um / E;
        let place_um = off_um + 2.0 * centre_um + 1.1 * bulge_um + first_rad * interval_um;
        // The slope of that offset, s·(1 + ln(L/D)), at the last interval.
        let logs = 1.0 + (run_um / interval_um.max(1.0)).max(1.0).natural_logarithm();
        let heading_rad = drift * run_um / 2.0
            + steady_rad * logs
            + first_rad
            + 2.0 * model.aim_error_rad(run_um.min(interval_um + model.guard_um()));
        Stray { place_um, heading_rad }
    }
}

/// A fine motion with the possible deviations of a robot.
pub struct FineMotion<'a> {
    pub model: &'a SteeringModel<'a>,
    pub frame: &'a GoalFrame,
    pub bounds: &'a FineMotionBounds,
    pub approach: Pose,
    pub shift_um: f64,
}

impl FineMotion<'_> {
    /// The spot with the least room except at the edge that it meets, if there is anything around.
    pub fn tightest(&self, around: &Surroundings) -> Option<Room> {
        let robot = self.model.robot;
        let share = steered(self.model, self.frame, self.approach, [0.0, 1.0]).0;
        let turn_per_um = self.model.side() * share / robot.turning_radius_um;
        let seen = self.frame.seen(self.approach);
        let way_um = self.frame.met(seen, share / robot.turning_radius_um).map_or(0.0, |contact| contact.way_um);
        let reach_um = robot.length_um.hypotenuse(robot.width_um) / 2.0;
        let at_goal = self.frame.goal;
        let is_met = |solid: &StrategySolid| solid.is_ahead(robot, at_goal);
        let samples = (way_um / SAMPLE_STEP_UM).ceil().max(1.0);
        if !can_be_sampled(way_um, SAMPLE_STEP_UM) {
            return Some(unbounded());
        }
        let mut tightest = None;
        for sample in 0..=samples as u64 {
            let gone_um = way_um * sample as f64 / samples;
            let left_um = way_um - gone_um;
            let tilt_rad = self.bounds.incidence_rad + self.bounds.bend_per_um * left_um;
            let aside_um = self.bounds.across_um
                + self.bounds.incidence_rad * left_um
                + self.bounds.bend_per_um * left_um * left_um / 2.0;
            let half_um = SAMPLE_STEP_UM / 2.0 * (1.0 + reach_um / robot.turning_radius_um);
            let stray_um = aside_um + tilt_rad * reach_um + self.shift_um + half_um;
            let pose = bent(self.approach, turn_per_um, gone_um);
            tightest = around.tightest(&body(robot, pose, 0.0), stray_um, tightest, &is_met);
        }
        tightest
    }
}
