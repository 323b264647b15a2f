//! The first two robots of a structure: stages 1 and 2, repeated until both arrive together; then the fine motion.

use super::single::{
    MAX_FINE_TIMES, MAX_PUSHES, MAX_ROUNDS, again_um, push_on_um, push_um, touching_um, whole_strokes,
};
use super::{ControlPhase, Progress, StopReason, add_pieces, strokes};
use crate::claims::microrobots::MicrorobotsOrder;
use crate::device::microrobots::{Arm, Robot, wrapped_rad};
use crate::geometry::Pose;
use crate::plan::microrobots::control::CommandSegments;
use crate::plan::microrobots::control::belief::Belief;
use crate::plan::microrobots::strategy::{Couple, Episode, Phase, Pursuit, SHARES, centres, poses_of, steered};
use crate::plan::microrobots::{AssemblyStage, Leg};
use crate::real::Real;
use std::f64::consts::PI;

/// Most intervals of one gross motion.
const MAX_INTERVALS: usize = 20_000;

/// Share of the distance of self-alignment that may be used up before the fine motion: two robots that turn away when
/// they are so near to each other collide more often than they would miss the rest.
const ALIGNED_SHARE: f64 = 0.75;

/// Current activity of the two robots.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum PairState {
    /// The second robot is driven to the orbit from which it is driven later.
    Near,
    /// A round begins from where they stand.
    Begin,
    Timing,
    Meeting,
    Fine,
    Contact,
}

/// The two robots of a stage.
#[derive(Debug, Clone)]
pub struct PairStage<'a> {
    pub robots: [usize; 2],
    couple: Couple<'a>,
    /// Both turn, only the second turns, none of the two turns.
    states: [usize; 3],
    goals: [Pose; 2],
    /// Path to where the second robot orbits, if it is not there yet.
    near: Option<Pursuit>,
    /// Turning centres along the paths of the first round.
    via_um: [Vec<[f64; 2]>; 2],
    pursuits: [Pursuit; 2],
    doing: PairState,
    round: usize,
    intervals: usize,
    /// Times that the first robot arrived, but out of place or out of time.
    rounds: usize,
    shares: [f64; 2],
    is_kept: bool,
    left_um: f64,
    pushes: usize,
    /// Whether the last push began with the robots as near as ones that touch.
    is_pushed_on: bool,
}

impl<'a> PairStage<'a> {
    pub fn new(order: &'a MicrorobotsOrder, episode: &Episode) -> Option<Self> {
        let &AssemblyStage::Pair { first, second, states, intermediate, approach, goals, .. } = episode.stage else {
            return None;
        };
        let mut couple = Couple::new(order, [first, second], intermediate, approach)?;
        couple.models = couple.models.map(whole_strokes);
        let (near, via_um) = near(order, &couple, [first, second], episode);
        let pursuit = |at: usize, to: Pose| Pursuit::new(&couple.models[at], via_um[at].clone(), to);
        let pursuits = [pursuit(0, couple.intermediate()), pursuit(1, approach[1])];
        Some(PairStage {
            robots: [first, second],
            couple,
            states,
            goals,
            doing: if near.is_some() { PairState::Near } else { PairState::Begin },
            near,
            via_um,
            pursuits,
            round: 0,
            intervals: 0,
            rounds: 0,
            shares: [0.0; 2],
            is_kept: false,
            left_um: MAX_FINE_TIMES * order.facts.fine.length_um,
            pushes: 0,
            is_pushed_on: false,
        })
    }

    pub fn phase(&self) -> ControlPhase {
        match self.doing {
            PairState::Near => ControlPhase::Approach,
            PairState::Begin | PairState::Timing => ControlPhase::Timing,
            PairState::Meeting => ControlPhase::Meeting,
            PairState::Fine => ControlPhase::Fine,
            PairState::Contact => ControlPhase::Contact,
        }
    }

    pub fn proceed(&mut self, belief: &mut Belief, command: &mut CommandSegments) -> Progress {
        let measured = self.robots.map(|robot| belief.poses[robot]);
        let apart_um = self.apart_head_on_um(belief, measured).filter(|_| self.doing == PairState::Contact);
        if let Some(apart_um) = apart_um {
            if self.is_pushed_on {
                self.robots.into_iter().for_each(|robot| belief.dock(robot));
                belief.begin_structure([(self.robots[0], self.goals[0]), (self.robots[1], self.goals[1])]);
                return Progress::Done;
            }
            self.is_pushed_on = true;
            let push_um = push_on_um(apart_um, touching_um(belief, self.couple.models[0].robot.width_um));
            command.add(self.states[2], strokes(belief, self.robots[0], push_um));
            return Progress::Driving;
        }
        loop {
            let progress = match self.doing {
                PairState::Near => self.bring_near(belief, command, measured),
                PairState::Begin => self.begin_round(measured),
                PairState::Timing => self.time(belief, command, measured),
                PairState::Meeting => self.meet(belief, command, measured),
                PairState::Fine | PairState::Contact => return self.fine(belief, command, measured),
            };
            match progress {
                Progress::Done => {}
                Progress::Driving | Progress::Resting(_) | Progress::Failed(..) => return progress,
            }
        }
    }

    fn state(&self, which: usize, arm: Arm) -> usize {
        match (which, arm) {
            (0, Arm::Down) => self.states[0],
            (0, Arm::Up) | (_, Arm::Down) => self.states[1],
            (_, Arm::Up) => self.states[2],
        }
    }

    fn is_over(&mut self) -> bool {
        self.intervals += 1;
        self.intervals > MAX_INTERVALS
    }

    /// Brings the second robot to the orbit from which it is driven.
    fn bring_near(&mut self, belief: &Belief, command: &mut CommandSegments, measured: [Pose; 2]) -> Progress {
        let over = self.is_over();
        let model = &self.couple.models[1];
        let Some(pursuit) = self.near.as_mut().filter(|pursuit| pursuit.phase != Phase::Turning) else {
            self.doing = PairState::Begin;
            return Progress::Done;
        };
        if over {
            return Progress::Failed(StopReason::TimeLimit, self.robots[1]);
        }
        let pieces = pursuit.pieces(model, measured[1], model.interval_um);
        add_pieces(belief, command, self.robots[1], pieces, |arm| self.state(1, arm));
        Progress::Driving
    }

    fn begin_round(&mut self, measured: [Pose; 2]) -> Progress {
        if self.round >= MAX_ROUNDS {
            return Progress::Failed(StopReason::LeftCylinder, self.robots[1]);
        }
        // Only the first round takes the paths of the plan.
        let [first_um, second_um]: [&[[f64; 2]]; 2] =
            if self.round == 0 { [&self.via_um[0], &self.via_um[1]] } else { [&[], &[]] };
        let models = self.couple.models;
        self.pursuits[1].restart(&models[1], second_um, self.couple.approach[1]);
        self.couple.give_time(&self.pursuits[1], measured[1], self.round);
        self.pursuits[0].restart(&models[0], first_um, self.couple.intermediate());
        (self.doing, self.round, self.intervals, self.rounds) = (PairState::Timing, self.round + 1, 0, 0);
        Progress::Done
    }

    /// Brings the first robot to its line while the second orbits, until it is there in time.
    fn time(&mut self, belief: &Belief, command: &mut CommandSegments, measured: [Pose; 2]) -> Progress {
        if self.is_over() {
            return Progress::Failed(StopReason::TimeLimit, self.robots[0]);
        }
        let PairStage { couple, pursuits: [pursuit, second], .. } = self;
        if pursuit.phase == Phase::Arrived {
            let late_um = couple.late_um([&*pursuit, &*second], measured);
            let is_there = couple.models[0].accepted().holds(pursuit.approach, measured[0]);
            if is_there && late_um.abs() <= couple.begun_um() {
                (self.doing, self.intervals) = (PairState::Meeting, 0);
                return Progress::Done;
            }
            self.rounds += 1;
            if self.rounds > MAX_ROUNDS {
                return Progress::Failed(StopReason::LeftCylinder, self.robots[0]);
            }
            match is_there {
                true => pursuit.restart(&couple.models[0], &[couple.racetrack(late_um)], couple.intermediate()),
                false => pursuit.retry(&couple.models[0], measured[0]),
            }
        } else if pursuit.is_far(&couple.models[0], measured[0]) {
            couple.slide(pursuit, second, measured);
        }
        self.interval(belief, command, 0, measured)
    }

    /// Brings the second robot to its approach while the first runs straight; ends when the first has come too far.
    fn meet(&mut self, belief: &Belief, command: &mut CommandSegments, measured: [Pose; 2]) -> Progress {
        if self.is_over() {
            return Progress::Failed(StopReason::TimeLimit, self.robots[1]);
        }
        let model = &self.couple.models[1];
        let pursuit = &mut self.pursuits[1];
        let is_passed = self.couple.run_um(measured[0]) < -self.couple.missed_um;
        let is_there = pursuit.phase == Phase::Arrived && model.accepted().holds(pursuit.approach, measured[1]);
        if is_there || is_passed {
            self.doing = if self.is_within_reach(belief, measured) { PairState::Fine } else { PairState::Begin };
            return Progress::Done;
        }
        if pursuit.phase == Phase::Arrived {
            pursuit.retry(model, measured[1]);
        }
        if pursuit.phase == Phase::Facing && self.couple.has_time(pursuit, measured) {
            command.add(self.states[1], strokes(belief, self.robots[1], model.interval_um));
            return Progress::Driving;
        }
        self.interval(belief, command, 1, measured)
    }

    fn interval(
        &mut self,
        belief: &Belief,
        command: &mut CommandSegments,
        which: usize,
        measured: [Pose; 2],
    ) -> Progress {
        let model = &self.couple.models[which];
        let pieces = self.pursuits[which].pieces(model, measured[which], model.interval_um);
        add_pieces(belief, command, self.robots[which], pieces, |arm| self.state(which, arm));
        Progress::Driving
    }

    /// Whether the two arrive together, and the error that fine motion cannot correct is within self-alignment.
    fn is_within_reach(&self, belief: &Belief, measured: [Pose; 2]) -> bool {
        let frames = self.couple.frames(self.goals, measured);
        let aside_um = [0, 1].map(|at| steered(&self.couple.models[at], &frames[at], measured[at], SHARES[at]).1.abs());
        let most_um = ALIGNED_SHARE * belief.order.facts.docking.self_aligning_um;
        self.couple.run_um(measured[0]).abs() <= self.couple.missed_um && aside_um[0] + aside_um[1] <= most_um
    }

    fn fine(&mut self, belief: &Belief, command: &mut CommandSegments, measured: [Pose; 2]) -> Progress {
        // Robots that were pushed together and do not touch were not there yet.
        (self.doing, self.is_pushed_on) = (PairState::Fine, false);
        let frames = self.couple.frames(self.goals, measured);
        let models = self.couple.models;
        let [interval_um, cycle_um] = [models[0].fine_interval_um, models[0].cycle_um];
        let seen = frames[0].seen(measured[0]);
        if !self.is_kept {
            self.shares = [0, 1].map(|at| steered(&models[at], &frames[at], measured[at], SHARES[at]).0);
            self.is_kept = frames[0].gap_um(seen) < interval_um + models[0].kept_um;
        }
        let turn_per_um = self.shares[0] / models[0].robot.turning_radius_um;
        let way_um = frames[0].met(seen, turn_per_um).map_or(f64::INFINITY, |contact| contact.way_um);
        if way_um > interval_um {
            self.left_um -= interval_um;
            if self.left_um < 0.0 {
                return Progress::Failed(StopReason::MissedCone, self.robots[0]);
            }
            let count = (interval_um / cycle_um).round().max(1.0);
            (0..count as u64).for_each(|_| self.cycle(belief, command, cycle_um));
            return Progress::Driving;
        }
        self.pushes += 1;
        if self.pushes > MAX_PUSHES {
            return Progress::Failed(StopReason::MissedCone, self.robots[0]);
        }
        self.doing = PairState::Contact;
        self.last_cycles(belief, command, way_um);
        Progress::Driving
    }

    /// A cycle of three primitives, half before and half after the straight one.
    fn cycle(&self, belief: &Belief, command: &mut CommandSegments, cycle_um: f64) {
        let [first, second] = self.shares;
        let [both, one, none] = self.states;
        let (turning_um, second_um) = (first * cycle_um / 2.0, (second - first) * cycle_um / 2.0);
        let straight_um = (1.0 - second) * cycle_um;
        let pieces = [(both, turning_um), (one, second_um), (none, straight_um), (one, second_um), (both, turning_um)];
        pieces.into_iter().for_each(|(state, way_um)| command.add(state, strokes(belief, self.robots[0], way_um)));
    }

    /// The cycles before the contact; the last one turns first, so that both arms are up when the robots stick.
    fn last_cycles(&self, belief: &Belief, command: &mut CommandSegments, way_um: f64) {
        let cycle_um = self.couple.models[0].cycle_um;
        let whole = ((way_um / cycle_um).ceil() - 1.0).max(0.0);
        (0..whole as u64).for_each(|_| self.cycle(belief, command, cycle_um));
        let last_um = way_um - whole * cycle_um;
        let [first, second] = self.shares;
        let [both, one, none] = self.states;
        let width_um = self.couple.models[0].robot.width_um;
        let push_um = push_um(belief, width_um, way_um) + again_um(self.pushes, cycle_um);
        let straight_um = (1.0 - second) * last_um + push_um;
        for (state, way_um) in [(both, first * last_um), (one, (second - first) * last_um), (none, straight_um)] {
            command.add(state, strokes(belief, self.robots[0], way_um));
        }
    }

    /// Distance between the fronts of the two, if they are measured as against each other.
    fn apart_head_on_um(&self, belief: &Belief, measured: [Pose; 2]) -> Option<f64> {
        let robots = [0, 1].map(|at| self.couple.models[at].robot);
        let noses = [0, 1].map(|at| nose(robots[at], measured[at]));
        let doubt_um = belief.doubt_um((robots[0].length_um + robots[1].length_um) / 2.0);
        let apart_um = (noses[1][0] - noses[0][0]).hypotenuse(noses[1][1] - noses[0][1]);
        let askew_rad = wrapped_rad(measured[0].heading_rad - measured[1].heading_rad - PI).abs();
        let most_um = 2.0 * doubt_um + touching_um(belief, robots[0].width_um);
        let are_head_on = apart_um <= most_um && askew_rad <= 2.0 * belief.errors.heading_rad + 0.01;
        are_head_on.then_some(apart_um)
    }
}

/// Path of the second robot to the orbit from which it is driven, and the turning centres on the paths of both from
/// then on.
fn near(
    order: &MicrorobotsOrder,
    couple: &Couple,
    [first, second]: [usize; 2],
    episode: &Episode,
) -> (Option<Pursuit>, [Vec<[f64; 2]>; 2]) {
    let Some(&[_, ends]) = episode.gross.first() else { return (None, [Vec::new(), Vec::new()]) };
    let via_um = |at: usize| episode.via_um.get(at).cloned().unwrap_or_default();
    let row = order.robots[second].row;
    let runs = |leg: &Leg| order.states[leg.state].arms[row] == Arm::Up;
    let Some(begins) = episode.steered[..ends].iter().rposition(runs).map(|leg| leg + 1) else {
        return (None, [via_um(0), via_um(1)]);
    };
    let way = poses_of(order, second, episode.poses[second], &episode.steered[..begins]);
    let via = centres(order, second, &way, &episode.steered[..begins], 0);
    let pursuit = Pursuit::new(&couple.models[1], via, way[begins]);
    let way = poses_of(order, first, episode.poses[first], &episode.steered[..ends]);
    (Some(pursuit), [centres(order, first, &way, &episode.steered[..ends], begins), via_um(1)])
}

/// The middle of a robot's front.
fn nose(robot: &Robot, pose: Pose) -> [f64; 2] {
    let (sin, cos) = pose.heading_rad.sine_cosine();
    [pose.x_um + robot.length_um / 2.0 * cos, pose.y_um + robot.length_um / 2.0 * sin]
}
