//! Sequences of control states with lengths, and random changes of them.

use super::ShootingRequest;
use super::lengths::{LegLengths, ShotRobot};
use crate::device::microrobots::Arm;
use crate::plan::microrobots::world::CollisionWorld;
use crate::plan::microrobots::{Leg, RobotDocking};
use crate::random::SplitMix64;
use crate::real::Real;

/// Most legs.
const MAX_LEGS: usize = 60;

/// Least lengths of the straight leg with which a segment ends, in micrometres: up to the length of a body. A robot
/// that docks beside another one cannot turn into its place.
const LAST_LEGS_UM: [f64; 3] = [60.0, 120.0, 240.0];

/// Most times that a drawn sequence goes through all control states before the first robots dock.
const MAX_CYCLES: usize = 3;

/// Range of the mean length of drawn legs, and the greatest length of an inserted leg, in micrometres.
const DRAWN_UM: [f64; 2] = [100.0, 500.0];
const INSERTED_UM: f64 = 1_000.0;

/// Legs shorter than this are left out, in micrometres.
const SHORTEST_UM: f64 = 0.3;

/// Share of changes that leave out a full circle, and the share of a circle that must be there.
const CIRCLE_CHANGES: f64 = 0.15;
const CIRCLE_SHARE: f64 = 0.8;

/// The part of an assembly up to a docking.
#[derive(Debug, Clone)]
pub struct ShotSegment {
    /// Robots that dock at its end.
    pub docking: Vec<usize>,
    /// Control states that keep the arms of docked robots up.
    pub allowed: Vec<usize>,
    /// Those of them in which the robots of `docking` run straight.
    pub straight: Vec<usize>,
}

impl ShotSegment {
    /// The segments of an assembly in which these robots dock one after the other; `None` if a robot cannot run
    /// straight to its goal.
    pub fn all(world: &CollisionWorld, docked: &[bool], dockings: &[Vec<usize>]) -> Option<Vec<ShotSegment>> {
        let mut docked = docked.to_vec();
        let mut segments = Vec::with_capacity(dockings.len());
        for docking in dockings {
            let allowed: Vec<usize> = world.allowed_states(&docked).collect();
            let is_straight = |state: &usize| docking.iter().all(|robot| world.arm(*state, *robot) == Arm::Up);
            let straight: Vec<usize> = allowed.iter().copied().filter(is_straight).collect();
            if straight.is_empty() {
                return None;
            }
            segments.push(ShotSegment { docking: docking.clone(), allowed, straight });
            docking.iter().for_each(|robot| docked[*robot] = true);
        }
        Some(segments)
    }
}

/// A leg. Its length is `least_um` + `root`², as the solver needs it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ShotLeg {
    pub state: usize,
    pub least_um: f64,
    pub root: f64,
}

impl ShotLeg {
    fn new(state: usize, length_um: f64) -> ShotLeg {
        ShotLeg { state, least_um: 0.0, root: length_um.sqrt() }
    }

    pub fn length_um(&self) -> f64 {
        self.least_um + self.root * self.root
    }
}

/// Legs of an assembly. Each segment ends with a straight leg.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct LegSequence {
    pub legs: Vec<ShotLeg>,
    /// Number of legs up to the end of each segment.
    pub ends: Vec<usize>,
}

impl LegSequence {
    /// Draws control states and lengths.
    pub fn drawn(segments: &[ShotSegment], random: &mut SplitMix64) -> LegSequence {
        let mut drawn = LegSequence::default();
        let mean_um = DRAWN_UM[0] + (DRAWN_UM[1] - DRAWN_UM[0]) * random.unit();
        let mut cycles = 1 + random.below(MAX_CYCLES);
        for segment in segments {
            for _ in 0..cycles {
                let mut states = segment.allowed.clone();
                random.shuffle(&mut states);
                for state in states {
                    // Exponentially distributed: few are long.
                    let length_um = -mean_um * (1.0 - random.unit()).natural_logarithm();
                    drawn.legs.push(ShotLeg::new(state, length_um));
                }
            }
            cycles = 1;
            let state = segment.straight[random.below(segment.straight.len())];
            let least_um = LAST_LEGS_UM[random.below(LAST_LEGS_UM.len())];
            drawn.legs.push(ShotLeg { least_um, ..ShotLeg::new(state, mean_um * random.unit()) });
            drawn.ends.push(drawn.legs.len());
        }
        drawn
    }

    /// Takes over the legs of a plan whose robots dock as in the segments; `step_um` is the path of a stroke.
    pub fn of_plan(legs: &[Leg], docks: &[RobotDocking], step_um: f64) -> LegSequence {
        let mut legs: Vec<ShotLeg> =
            legs.iter().map(|leg| ShotLeg::new(leg.state, leg.strokes as f64 * step_um)).collect();
        let mut ends: Vec<usize> = docks.iter().map(|dock| dock.leg + 1).collect();
        ends.dedup();
        for end in &ends {
            let last = &mut legs[end - 1];
            let length_um = last.length_um();
            let least_um = LAST_LEGS_UM.into_iter().rev().find(|least_um| *least_um <= length_um).unwrap_or(0.0);
            *last = ShotLeg { state: last.state, least_um, root: (length_um - least_um).sqrt() };
        }
        LegSequence { legs, ends }
    }

    /// Length of all legs.
    pub fn length_um(&self) -> f64 {
        self.legs.iter().map(ShotLeg::length_um).sum()
    }

    /// The roots of the lengths, as the solver needs them.
    pub fn roots(&self) -> Vec<f64> {
        self.legs.iter().map(|leg| leg.root).collect()
    }

    pub fn set_roots(&mut self, roots: &[f64]) {
        self.legs.iter_mut().zip(roots).for_each(|(leg, root)| leg.root = *root);
    }

    /// A sequence with a few random changes; `circle_um` is the length of a full circle.
    pub fn varied(&self, segments: &[ShotSegment], circle_um: f64, random: &mut SplitMix64) -> LegSequence {
        let mut varied = self.clone();
        if random.unit() < CIRCLE_CHANGES && varied.leave_out_circle(circle_um, random) {
            return varied;
        }
        for _ in 0..=random.below(3) {
            varied.change(segments, random);
        }
        varied
    }

    /// Shortens all legs of one control state by a full circle together; returns whether they are long enough.
    fn leave_out_circle(&mut self, circle_um: f64, random: &mut SplitMix64) -> bool {
        let state = self.legs[random.below(self.legs.len())].state;
        let squares: f64 = self.legs.iter().filter(|leg| leg.state == state).map(|leg| leg.root * leg.root).sum();
        if squares < CIRCLE_SHARE * circle_um {
            return false;
        }
        let kept = (1.0 - circle_um / squares).max(0.0).sqrt();
        self.legs.iter_mut().filter(|leg| leg.state == state).for_each(|leg| leg.root *= kept);
        true
    }

    fn change(&mut self, segments: &[ShotSegment], random: &mut SplitMix64) {
        let at = random.below(self.legs.len());
        let segment = self.ends.iter().take_while(|end| **end <= at).count();
        let ShotSegment { allowed, straight, .. } = &segments[segment];
        let is_last = self.ends[segment] == at + 1;
        let length_um = INSERTED_UM * random.unit() * random.unit();
        match random.below(7) {
            0..=2 if self.legs.len() < MAX_LEGS => {
                self.legs.insert(at, ShotLeg::new(allowed[random.below(allowed.len())], length_um));
                self.ends[segment..].iter_mut().for_each(|end| *end += 1);
            }
            3 if !is_last => self.remove(at),
            4 => self.legs[at].root = length_um.sqrt(),
            5 if is_last => self.legs[at].least_um = LAST_LEGS_UM[random.below(LAST_LEGS_UM.len())],
            5 if at + 2 < self.ends[segment] => self.legs.swap(at, at + 1),
            6 if is_last => self.legs[at].state = straight[random.below(straight.len())],
            _ if !is_last => self.legs[at].state = allowed[random.below(allowed.len())],
            _ => {}
        }
    }

    fn remove(&mut self, leg: usize) {
        self.legs.remove(leg);
        self.ends.iter_mut().filter(|end| **end > leg).for_each(|end| *end -= 1);
    }

    /// Leaves out short legs and joins consecutive ones of the same control state; the states before and after a
    /// docking become different if possible.
    pub fn tidy(&mut self, segments: &[ShotSegment]) {
        let mut leg = 0;
        while leg < self.legs.len() {
            let (begins, ends) = (self.ends.contains(&leg) || leg == 0, self.ends.contains(&(leg + 1)));
            if !ends && self.legs[leg].length_um() < SHORTEST_UM {
                self.remove(leg);
            } else if !begins && self.legs[leg - 1].state == self.legs[leg].state {
                self.legs[leg].root = self.legs[leg].root.hypotenuse(self.legs[leg - 1].root);
                self.remove(leg - 1);
            } else {
                leg += 1;
            }
        }
        for (segment, end) in segments.iter().zip(&self.ends) {
            let state = |leg: usize| self.legs.get(leg).map(|leg| leg.state);
            let (last, next) = (state(end - 1), state(*end));
            if last != next {
                continue;
            }
            let before = end.checked_sub(2).and_then(state);
            let other = segment.straight.iter().find(|other| ![before, next].contains(&Some(**other)));
            if let Some(other) = other {
                self.legs[end - 1].state = *other;
            }
        }
    }

    /// The legs in whole strokes, and the dockings; `None` if the state does not change at a docking.
    pub fn in_strokes(&self, segments: &[ShotSegment], step_um: f64) -> Option<(Vec<Leg>, Vec<RobotDocking>)> {
        let (mut legs, mut docks): (Vec<Leg>, Vec<RobotDocking>) = (Vec::new(), Vec::new());
        let mut begin = 0;
        for (segment, end) in segments.iter().zip(&self.ends) {
            let first = legs.len();
            for leg in &self.legs[begin..*end] {
                let strokes = (leg.length_um() / step_um).round() as u64;
                let has_begun = legs.len() > first;
                match legs.last_mut() {
                    _ if strokes == 0 => {}
                    Some(last) if last.state != leg.state => legs.push(Leg { state: leg.state, strokes }),
                    Some(last) if has_begun => last.strokes += strokes,
                    Some(_) => return None,
                    None => legs.push(Leg { state: leg.state, strokes }),
                }
            }
            let leg = legs.len().checked_sub(1).filter(|leg| *leg >= first)?;
            docks.extend(segment.docking.iter().map(|&robot| RobotDocking { robot, leg }));
            begin = *end;
        }
        Some((legs, docks))
    }

    /// The request to bring all robots that have goals to them with these legs.
    pub fn lengths(&self, request: &ShootingRequest, segments: &[ShotSegment]) -> LegLengths {
        let mut lengths = LegLengths { robots: Vec::new(), arms: Vec::new(), least_um: Vec::new() };
        let goals = || request.goals.iter().enumerate().filter_map(|(robot, goal)| Some((robot, (*goal)?)));
        for (robot, goal) in goals() {
            let segment = segments.iter().position(|segment| segment.docking.contains(&robot));
            let ends = segment.map_or(self.legs.len(), |segment| self.ends[segment]);
            let facts = request.order.robot(robot);
            lengths.robots.push(ShotRobot {
                curve_um: facts.turning.sign() * facts.turning_radius_um,
                pace: facts.step_um / request.step_um,
                start: request.bed.poses[robot],
                ends,
                goal,
            });
        }
        for leg in &self.legs {
            lengths.arms.extend(goals().map(|(robot, _)| request.world.arm(leg.state, robot)));
            lengths.least_um.push(leg.least_um);
        }
        lengths
    }
}
