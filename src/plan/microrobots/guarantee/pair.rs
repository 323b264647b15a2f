//! Bounds of the first two robots.
//!
//! The first is brought to its intermediate pose like any robot; then it runs straight and uncorrected for as long as
//! the second is driven, which is bounded only if the second certainly drives no circle ([`ContainmentCheck::Turn`]).
//! In the fine motion each of them has half of the range of curvatures. The error that remains is left to
//! self-alignment.

use super::fine::{FineMotionBounds, Region};
use super::room::{ENOUGH_UM, FineMotion, GrossMotion, Surroundings, can_be_sampled, unbounded};
use super::{Containment, ContainmentCheck, Displaced, StageContext};
use crate::device::microrobots::{Arm, wrapped_rad};
use crate::geometry::Pose;
use crate::plan::microrobots::AssemblyStage;
use crate::plan::microrobots::strategy::{Couple, Cylinder, GoalFrame, SHARES, StrategySolid, body, poses_of};
use crate::real::Real;
use std::f64::consts::{PI, TAU};

/// Largest deviation of two goal headings from opposite for a head-on meeting.
const HEAD_ON_RAD: f64 = 0.02;

/// Step between two checks of both bodies.
const SAMPLE_STEP_UM: f64 = 5.0;

struct PairGuarantee<'a, 'b> {
    bed: &'a StageContext<'b>,
    couple: Couple<'a>,
    robots: [usize; 2],
    intermediate: Pose,
    goals: [Pose; 2],
}

pub fn containments(bed: &StageContext, structure: &mut Displaced) -> Option<Vec<Containment>> {
    let &AssemblyStage::Pair { first, second, intermediate, approach, goals, .. } = bed.episode.stage else {
        return None;
    };
    let couple = Couple::new(bed.order, [first, second], intermediate, approach)?;
    let pairing = PairGuarantee { bed, couple, robots: [first, second], intermediate, goals };
    let mut found = vec![pairing.edge()];
    let ways = pairing.ways();
    found.extend(pairing.turns(&ways));
    let (missed_um, meeting) = pairing.meeting(&ways[1]);
    found.extend(meeting);
    let cylinders = pairing.cylinders(&ways[1], missed_um);
    let frames = [0, 1].map(|at| GoalFrame::new(pairing.couple.models[at].robot, goals[at], 0.0));
    let bounds = [0, 1].map(|at| {
        // Their meeting point shifts by half of their timing error, as if both had begun that much nearer or farther.
        let model = &pairing.couple.models[at];
        let region = Region { cylinder: cylinders[at], along_um: model.cylinder().radius_um + missed_um / 2.0 };
        FineMotionBounds::new(model, &frames[at], approach[at], region, SHARES[at])
    });
    found.extend(pairing.contact(&cylinders, &bounds));
    found.extend(pairing.rooms(&ways, &frames, &bounds, missed_um));
    let aside_um = pairing.aside_um(&cylinders, &bounds);
    *structure = Displaced {
        middle_um: [(goals[0].x_um + goals[1].x_um) / 2.0, (goals[0].y_um + goals[1].y_um) / 2.0],
        place_um: (aside_um[0].max(aside_um[1])).hypotenuse(missed_um / 2.0),
        heading_rad: (bounds[0].incidence_rad + bounds[1].incidence_rad) / 2.0,
    };
    Some(found)
}

impl<'a> PairGuarantee<'a, '_> {
    fn held(&self, which: usize, check: ContainmentCheck, needs: f64, has: f64) -> Containment {
        Containment { robot: self.robots[which], check, needs, has }
    }

    /// The two must touch and face each other at their goals.
    fn edge(&self) -> Containment {
        let facts = [0, 1].map(|at| self.couple.models[at].robot);
        let other = StrategySolid::standing(facts[1], self.goals[1]);
        let tolerance_um = self.bed.order.facts.docking.tolerance_um;
        let touch = other.distance_um(&body(facts[0], self.goals[0], 0.0), tolerance_um) <= tolerance_um + 1e-6;
        let between_rad = wrapped_rad(self.goals[0].heading_rad - self.goals[1].heading_rad - PI);
        let face = other.is_ahead(facts[0], self.goals[0]) && between_rad.abs() <= HEAD_ON_RAD;
        self.held(0, ContainmentCheck::Edge, 1.0, f64::from(u8::from(touch && face)))
    }

    /// The path of the first to its intermediate pose, slid as far as possible, and of the second to its approach.
    fn ways(&'a self) -> [GrossMotion<'a>; 2] {
        let via_um = |at: usize| self.bed.episode.via_um.get(at).map_or(&[][..], |via_um| &via_um[..]);
        let mut first = GrossMotion::between(&self.couple.models[0], self.couple.slide_um());
        first.walk(self.bed.episode.poses[self.robots[0]], via_um(0), self.intermediate, 0.0, !self.bed.is_first);
        let mut second = GrossMotion::between(&self.couple.models[1], 0.0);
        second.walk(self.halt(), via_um(1), self.couple.approach[1], 0.0, true);
        [first, second]
    }

    /// Pose at which the second robot orbits until it is driven to its approach.
    fn halt(&self) -> Pose {
        let second = self.robots[1];
        let ends = self.bed.episode.gross.first().map_or(0, |gross| gross[1]);
        let poses = poses_of(self.bed.order, second, self.bed.episode.poses[second], &self.bed.episode.steered[..ends]);
        poses[poses.len() - 1]
    }

    /// The second robot may leave its orbit at any time, but any later turn must be long enough.
    fn turns(&self, ways: &[GrossMotion; 2]) -> Option<Containment> {
        let shortage = |[needs, has]: &[f64; 2]| has - needs;
        let tightest = ways[1].turns_rad.iter().skip(1).min_by(|a, b| shortage(a).total_cmp(&shortage(b)));
        tightest.map(|[needs, has]| self.held(1, ContainmentCheck::Turn, *needs, *has))
    }

    /// Longest drive of the second robot, from anywhere on its orbit, in micrometres of the first one's path.
    fn run_um(&self, second: &GrossMotion) -> f64 {
        let circle_um = TAU * self.couple.models[1].robot.turning_radius_um;
        let nominal_um = self.couple.run_um(self.intermediate) + self.couple.slide_um();
        nominal_um.max((second.length_um[0] + second.length_um[1]) / self.couple.ratio).min(nominal_um + circle_um)
    }

    /// Timing error of the two when the second arrives, and its limits.
    fn meeting(&self, second: &GrossMotion) -> (f64, [Containment; 2]) {
        let models = &self.couple.models;
        let speed = models[0].errors.speed_ratio + models[1].errors.speed_ratio;
        let unsure_um = models[0].errors.place_um + models[1].centre_error_um();
        let missed_um = self.couple.begun_um() + speed * self.run_um(second) + second.length_um[1] + unsure_um;
        // After the last slide a circle and two intervals remain.
        let circle_um = TAU * models[0].robot.turning_radius_um;
        let late_um = speed * (circle_um + 2.0 * (models[0].interval_um + models[0].guard_um())) + unsure_um;
        let late = self.held(1, ContainmentCheck::Meeting, late_um, self.couple.begun_um());
        (missed_um, [late, self.held(0, ContainmentCheck::Meeting, missed_um, self.couple.missed_um)])
    }

    /// Cylinders of both at the start of the fine motion, without their timing error.
    fn cylinders(&self, second: &GrossMotion, missed_um: f64) -> [Cylinder; 2] {
        let [first, other] = [0, 1].map(|at| self.couple.models[at].cylinder());
        let drift = self.couple.models[0].errors.turning_rad_per_um * (1.0 + self.couple.models[0].errors.speed_ratio);
        let run_um = self.run_um(second) + missed_um;
        let heading_rad = first.heading_rad + drift * run_um;
        let radius_um = first.radius_um + first.heading_rad * run_um + drift * run_um * run_um / 2.0;
        [Cylinder { radius_um, heading_rad }, other]
    }

    /// Lateral offset at which each may come to rest.
    fn aside_um(&self, cylinders: &[Cylinder; 2], bounds: &[FineMotionBounds; 2]) -> [f64; 2] {
        [0, 1].map(|at| {
            let length_um = self.bed.order.facts.fine.length_um;
            let drift = self.couple.models[at].errors.turning_rad_per_um;
            let beyond_um = (cylinders[at].radius_um - bounds[at].reach_um).max(0.0);
            let saturated_um = if beyond_um > 0.0 { drift * length_um * length_um } else { 0.0 };
            bounds[at].across_um + beyond_um + saturated_um
        })
    }

    fn contact(&self, cylinders: &[Cylinder; 2], bounds: &[FineMotionBounds; 2]) -> [Containment; 2] {
        let docking = self.bed.order.facts.docking;
        let aside_um = self.aside_um(cylinders, bounds);
        let between_rad = bounds[0].incidence_rad + bounds[1].incidence_rad;
        // The axes are compared at the fronts, whose offset grows with the lean of a corner.
        let lean_um = self.couple.models[0].robot.width_um * between_rad.min(1.0).sine();
        [
            self.held(0, ContainmentCheck::Axes, aside_um[0] + aside_um[1] + lean_um, docking.self_aligning_um),
            self.held(0, ContainmentCheck::Directions, between_rad, docking.self_aligning_rad),
        ]
    }

    fn rooms(
        &self,
        ways: &[GrossMotion; 2],
        frames: &[GoalFrame; 2],
        bounds: &[FineMotionBounds; 2],
        missed_um: f64,
    ) -> Vec<Containment> {
        let mut around = self.bed.surroundings(&self.robots);
        let mut found = Vec::new();
        for at in [1, 0] {
            if at == 0 {
                // While the first is driven, the second orbits.
                let model = &self.couple.models[1];
                let creep_um = model.creep_um(ways[0].length_um[0]) + model.centre_miss_um();
                around.free.push(StrategySolid::orbit(model.robot, self.halt(), creep_um));
            }
            let room = ways[at].tightest(&around);
            found.extend(room.map(|(name, needs, has)| self.held(at, ContainmentCheck::Gross(name), needs, has)));
        }
        around.free.pop();
        for at in [0, 1] {
            let (model, approach) = (&self.couple.models[at], self.couple.approach[at]);
            let shift_um = missed_um / 2.0;
            let stretch = FineMotion { model, frame: &frames[at], bounds: &bounds[at], approach, shift_um };
            let room = stretch.tightest(&around);
            found.extend(room.map(|(name, needs, has)| self.held(at, ContainmentCheck::Fine(name), needs, has)));
        }
        found.extend(self.apart(&around, ways, missed_um));
        found
    }

    /// Room of the first robot's run, to everything around and to the second robot, which is driven meanwhile.
    fn apart(&self, around: &Surroundings, ways: &[GrossMotion; 2], missed_um: f64) -> Vec<Containment> {
        let [first, second] = [0, 1].map(|at| &self.couple.models[at]);
        let run_um = self.run_um(&ways[1]);
        let cylinder = self.cylinders(&ways[1], missed_um)[0];
        let reach_um = first.robot.length_um.hypotenuse(first.robot.width_um) / 2.0;
        let stray_um = cylinder.radius_um + reach_um * cylinder.heading_rad + SAMPLE_STEP_UM;
        let second_um = ways[1].stray_um() + missed_um + SAMPLE_STEP_UM;
        if !can_be_sampled(run_um, SAMPLE_STEP_UM) {
            let (name, needs, has) = unbounded();
            return vec![self.held(0, ContainmentCheck::Gross(name), needs, has)];
        }
        let (mut tightest, mut nearest): (Option<(String, f64, f64)>, _) = (None, f64::INFINITY);
        for sample in 0..=(run_um / SAMPLE_STEP_UM) as u64 {
            let left_um = sample as f64 * SAMPLE_STEP_UM;
            let pose = first.robot.moved(self.couple.approach[0], Arm::Up, -left_um);
            let whole = body(first.robot, pose, 0.0);
            tightest = around.tightest(&whole, stray_um, tightest, &|_| false);
            let other = ways[1].left(left_um * self.couple.ratio);
            nearest = f64::min(nearest, StrategySolid::standing(second.robot, other).distance_um(&whole, ENOUGH_UM));
        }
        let room = tightest.map(|(name, needs, has)| self.held(0, ContainmentCheck::Gross(name), needs, has));
        let name = second.robot.name.clone();
        room.into_iter().chain([self.held(0, ContainmentCheck::Gross(name), stray_um + second_um, nearest)]).collect()
    }
}
