//! The first two robots of a structure, which reach their goals simultaneously.
//!
//! Problem: while the first robot is driven, the second orbits; while the second is driven, the first runs straight
//! (the paper's section 2.1). Method: the second robot leaves its orbit for its approach along a known path, so the
//! time from the start to its approach is known up to full circles, and up to an optional earlier arrival on its goal's
//! axis. For each such time, the shortest first, the first robot needs a path of exactly that length whose last segment
//! is straight at least from the time at which the second leaves its orbit; such paths have a closed form
//! ([`super::closing`]). This is the paper's phase condition with the phase free; the paper's choice, the second robot
//! back where it began, is among the times. The second robot may also move near its goal first and orbit there while
//! the first is driven: then the first one's last straight segment is short. If no closed form avoids the bodies at
//! rest, the first robot's path is searched and lengthened by the paper's racetrack detour ([`super::roundabout`]).
//! Without a fine motion, a path that cannot be lengthened counts too, if it takes both robots the same time: two
//! robots that face each other run straight. Promise: the returned stretch satisfies the collision rules, and brings
//! both robots to their goals within precision. Not promised: the shortest one. Cost grows with the number of times
//! examined.

use super::bed::{AssemblyState, StageAddition, joined, legs_of_two};
use super::closing::{CIRCLES, ClosingRequest, closings, detours, shortest_of_length, stretches, turned_rad};
use super::ground::AssemblyGround;
use super::track::{ArmTrack, TrackAim, turn_um, whole};
use super::{PlannedFineMotion, StuckAssembly};
use crate::claims::microrobots::Dock;
use crate::device::microrobots::{Arm, MicrorobotsObjective, Robot};
use crate::geometry::Pose;
use crate::plan::microrobots::fine::Cycles;
use crate::plan::microrobots::free::{ArmSegment, joined as joined_segments, length_um};
use crate::plan::microrobots::paths::PathRequest;
use crate::plan::microrobots::world::Fixtures;
use crate::plan::microrobots::{AssemblyStage, Leg};
use crate::plan::search::Meter;
use std::f64::consts::TAU;

/// Lengths tried for the second robot's run on its goal's axis.
const RUNS: usize = 40;

/// Full circles of the second robot's orbit tried beyond its shortest path.
const MAX_ORBITS: usize = 8;

/// Paths of the first robot examined per time.
const MAX_PATHS: usize = 12;

/// Arm changes of the two robots that are this near to each other are merged, in strokes.
const ALIGNED_STROKES: u64 = 4;

/// Number of paths of the second robot, from the first one that leads to the goals on, among which the one with the
/// fewest legs is taken if control cycles are minimised.
const MAX_COMPARED: usize = 12;

/// Tolerance in strokes for the change of a path when it is rounded to whole strokes.
const FEW_STROKES: f64 = 4.0;

/// Two robots, and the control states that steer them while all others orbit.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Roles {
    pub first: usize,
    pub second: usize,
    /// Control states in which both turn, only the second turns, neither turns.
    pub states: [usize; 3],
}

/// Arms of the first and of the second robot in these states.
const ARMS: [[Arm; 3]; 2] = [[Arm::Down, Arm::Up, Arm::Up], [Arm::Down, Arm::Down, Arm::Up]];

/// Control states that steer two robots, if there are any.
pub fn roles(bed: &AssemblyState, first: usize, second: usize) -> Option<Roles> {
    let state = |part: usize| bed.state(&[(first, ARMS[0][part]), (second, ARMS[1][part])]);
    Some(Roles { first, second, states: [state(0)?, state(1)?, state(2)?] })
}

/// Plans the stretch that docks both robots, with the first of these fine motions that has room.
pub fn plan(
    bed: &AssemblyState,
    roles: Roles,
    docks: [&Dock; 2],
    fine: &[PlannedFineMotion],
    ground: &AssemblyGround,
    meter: &mut Meter,
) -> Result<StageAddition, StuckAssembly> {
    let fixtures = ground.fixtures(bed, &[roles.first, roles.second])?;
    let mut worst = None;
    for fine in fine {
        let pairing = PairingContext::new(bed, roles, docks, *fine);
        match brought_together(&pairing, PairSite { ground, fixtures: &fixtures }, meter) {
            Ok(stretch) => return Ok(stretch),
            Err(StuckAssembly::GaveUp) => return Err(StuckAssembly::GaveUp),
            Err(stuck) => worst = worst.or(Some(stuck)),
        }
    }
    Err(worst.unwrap_or(StuckAssembly::GaveUp))
}

/// The same for one fine motion.
fn brought_together(
    pairing: &PairingContext,
    site: PairSite,
    meter: &mut Meter,
) -> Result<StageAddition, StuckAssembly> {
    let mut choice = StretchChoice::new(pairing.bed.order.objective);
    let searched = search(pairing, site, meter, &mut choice);
    choice.best.ok_or(searched.err().unwrap_or(StuckAssembly::GaveUp))
}

/// Offers stretches until the choice is made.
fn search(
    pairing: &PairingContext,
    site: PairSite,
    meter: &mut Meter,
    choice: &mut StretchChoice,
) -> Result<(), StuckAssembly> {
    let (ground, roles) = (site.ground, pairing.roles);
    let mut stuck = match pairing.circles.contains(&true) {
        true => StuckAssembly::Untimely { first: roles.first, second: roles.second },
        false => StuckAssembly::Coarse { robot: roles.first },
    };
    let ways = pairing.paths_of_second(site, meter)?;
    let arrives =
        |second_path: &SecondRobotPath| pairing.aims[1].allows_turn(pairing.facts[1], turn_um(&second_path.way));
    let mut second_paths: Vec<SecondRobotPath> =
        ways.iter().flat_map(|way| pairing.with_circles(way)).filter(arrives).collect();
    if second_paths.is_empty() {
        stuck = StuckAssembly::Coarse { robot: roles.second };
    }
    second_paths.sort_by(|a, b| a.total_um.total_cmp(&b.total_um));
    for stages in pairing.stages() {
        let kept = |second_path: &&SecondRobotPath| *stages == PairStages::Overlapping || second_path.halt.is_none();
        for second_path in second_paths.iter().filter(kept) {
            let legs = choice.worthy(pairing.timed(second_path, *stages, site, meter)?);
            let stretch = pairing.first_free(second_path, legs, ground, meter, &mut stuck)?;
            if choice.offer(stretch) {
                return Ok(());
            }
        }
    }
    if choice.best.is_some() {
        return Ok(());
    }
    for (second_path, way) in pairing.roundabout(&ways, site, meter)? {
        let legs = pairing.legs(&second_path, vec![way], site, meter)?;
        if choice.offer(pairing.first_free(&second_path, legs, ground, meter, &mut stuck)?) {
            return Ok(());
        }
    }
    Err(stuck)
}

/// Choice among stretches, the shorter ones of which are offered first: the first one or, if control cycles are
/// minimised, the one with the fewest legs among several.
struct StretchChoice {
    objective: MicrorobotsObjective,
    best: Option<StageAddition>,
    /// Number of paths of the second robot that are still considered, from the first one with a stretch on.
    left: usize,
}

impl StretchChoice {
    fn new(objective: MicrorobotsObjective) -> Self {
        let left = match objective {
            MicrorobotsObjective::Time | MicrorobotsObjective::Failures => 1,
            MicrorobotsObjective::Switches => MAX_COMPARED,
        };
        StretchChoice { objective, best: None, left }
    }

    /// The legs that may be chosen, in order of preference.
    fn worthy(&self, mut all: Vec<Vec<Leg>>) -> Vec<Vec<Leg>> {
        if self.objective == MicrorobotsObjective::Switches {
            let most = self.best.as_ref().map_or(usize::MAX, |best| best.legs.len());
            all.retain(|legs| legs.len() < most);
            all.sort_by_key(Vec::len);
        }
        all
    }

    /// Takes over a path's stretch if it is better. Returns whether the choice is made then.
    fn offer(&mut self, stretch: Option<StageAddition>) -> bool {
        let is_better =
            |stretch: &StageAddition| self.best.as_ref().is_none_or(|best| stretch.legs.len() < best.legs.len());
        if let Some(stretch) = stretch.filter(is_better) {
            self.best = Some(stretch);
        }
        self.left = self.left.saturating_sub(usize::from(self.best.is_some()));
        self.left == 0
    }
}

/// Overlap of the paper's two stages.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum PairStages {
    /// The first robot completes its last turn before the second leaves the orbit on which it begins.
    Sequential,
    /// The first robot may turn whenever the second does.
    Overlapping,
}

/// Constants of the search for paths.
pub(super) struct PairingContext<'a> {
    pub bed: &'a AssemblyState<'a>,
    pub roles: Roles,
    pub facts: [&'a Robot; 2],
    from: [Pose; 2],
    goals: [Pose; 2],
    /// Poses at which the fine motion begins: as planned, and as the controller makes it.
    pub approach: [Pose; 2],
    gross_ends: [Pose; 2],
    fine: PlannedFineMotion,
    aims: [TrackAim; 2],
    cycles: Cycles<3>,
    /// Position of the first robot's arm in its first stroke, if prescribed because consecutive legs must differ in
    /// their states.
    forced: Option<Arm>,
    /// By number of full circles of the first robot, whether it can then end with the heading of its goal.
    circles: [bool; CIRCLES],
}

/// The collision rules, and the bodies at rest while the two are steered.
#[derive(Clone, Copy)]
pub(super) struct PairSite<'a> {
    pub ground: &'a AssemblyGround<'a>,
    pub fixtures: &'a Fixtures,
}

/// A path of the second robot from its current pose to its approach; it begins with a turn.
#[derive(Debug, Clone)]
pub(super) struct SecondRobotPath {
    pub way: Vec<ArmSegment>,
    pub total_um: f64,
    /// Pose at which it orbits a second time, if it does.
    pub halt: Option<Pose>,
}

impl<'a> PairingContext<'a> {
    fn new(bed: &'a AssemblyState<'a>, roles: Roles, docks: [&Dock; 2], fine: PlannedFineMotion) -> Self {
        let robots = [roles.first, roles.second];
        let facts = robots.map(|robot| bed.robot(robot));
        let goals = docks.map(|dock| dock.goal.pose);
        let whole = Cycles::symmetric(&bed.order.facts.fine, &facts.map(|facts| facts.step_um));
        let count = match fine {
            PlannedFineMotion::OneIn(share) => whole.count.div_ceil(share),
            PlannedFineMotion::LeftOut => 0,
        };
        let cycles = Cycles { count, ..whole };
        let begins = |cycles: &Cycles<3>| [0, 1].map(|at| cycles.backward(facts[at], ARMS[at], goals[at]));
        let approach = begins(&cycles);
        let gross_ends = match fine {
            PlannedFineMotion::OneIn(_) => approach,
            PlannedFineMotion::LeftOut => begins(&whole),
        };
        let motion = [0, 1].map(|at| cycles.forward(facts[at], ARMS[at], Pose::at(0.0, 0.0)));
        let aims = [0, 1].map(|at| TrackAim { goal: goals[at], precision: bed.order.precision, motion: motion[at] });
        let [both, one, _] = roles.states.map(|state| bed.last_state() == Some(state));
        let forced = if both { Some(Arm::Up) } else { one.then_some(Arm::Down) };
        let from = robots.map(|robot| bed.poses[robot]);
        let mut pairing = PairingContext {
            bed,
            roles,
            facts,
            from,
            goals,
            approach,
            gross_ends,
            fine,
            aims,
            cycles,
            forced,
            circles: [true; CIRCLES],
        };
        let ends = [pairing.first_from(), approach[0]];
        let turn_um = |circles| turned_rad(facts[0], ends, circles) * facts[0].turning_radius_um;
        pairing.circles = std::array::from_fn(|circles| aims[0].allows_turn(facts[0], turn_um(circles)));
        pairing
    }

    /// Overlaps to try, preferred first. Closed-loop execution, used if the device states its errors, keeps the stages
    /// apart as long as possible. Without a fine motion the legs are not those of the closed loop, and only their cost
    /// counts.
    fn stages(&self) -> &'static [PairStages] {
        match (self.fine, self.bed.order.facts.errors) {
            (PlannedFineMotion::OneIn(_), Some(_)) => &[PairStages::Sequential, PairStages::Overlapping],
            (PlannedFineMotion::OneIn(_), None) | (PlannedFineMotion::LeftOut, _) => &[PairStages::Overlapping],
        }
    }

    /// First candidate that the collision rules allow; if none, the last one's collision is recorded in `stuck`.
    fn first_free(
        &self,
        second_path: &SecondRobotPath,
        legs: Vec<Vec<Leg>>,
        ground: &AssemblyGround,
        meter: &mut Meter,
        stuck: &mut StuckAssembly,
    ) -> Result<Option<StageAddition>, StuckAssembly> {
        for legs in legs {
            meter.step().ok_or(StuckAssembly::GaveUp)?;
            match ground.cut_at_docking(self.bed, self.stretch(legs, second_path.halt)) {
                Err(apart) => *stuck = apart,
                Ok(stretch) => match ground.first_collision(self.bed, &stretch) {
                    None => return Ok(Some(stretch)),
                    Some(hit) => {
                        *stuck =
                            StuckAssembly::Blocked { robot: self.roles.first, partner: Some(self.roles.second), hit }
                    }
                },
            }
        }
        Ok(None)
    }

    /// Paths of the second robot that avoid the bodies at rest: first those along its goal's axis, by length, then a
    /// searched one.
    fn paths_of_second(&self, site: PairSite, meter: &mut Meter) -> Result<Vec<Vec<ArmSegment>>, StuckAssembly> {
        let PairSite { ground, fixtures } = site;
        let (second, from, to) = (self.facts[1], self.from[1], self.approach[1]);
        let index = self.roles.second;
        let clear = |way: &Vec<ArmSegment>| ground.world.obstruction_on(index, from, way, fixtures).is_none();
        let mut ways: Vec<Vec<ArmSegment>> =
            detours(second, from, to, &[0.0], &stretches(second, RUNS)).into_iter().filter(clear).collect();
        let request = PathRequest { world: &ground.world, robot: index, from, to, fixtures };
        match ground.path(self.bed, &[self.roles.first, index], &request, meter) {
            Ok(way) => ways.push(way),
            Err(stuck) if ways.is_empty() || stuck == StuckAssembly::GaveUp => return Err(stuck),
            Err(_) => {}
        }
        Ok(ways)
    }

    /// A path of the second robot with full circles at its start and at its last turn, during which the first one can
    /// be driven.
    fn with_circles(&self, way: &[ArmSegment]) -> Vec<SecondRobotPath> {
        let counts = (0..=MAX_ORBITS).flat_map(|all| (0..=all).map(move |late| [all - late, late]));
        counts.map(|circles| self.second_path(way, circles)).collect()
    }

    pub fn second_path(&self, way: &[ArmSegment], [early, late]: [usize; 2]) -> SecondRobotPath {
        let second = self.facts[1];
        let circles =
            |count: usize| [ArmSegment { arm: Arm::Down, way_um: TAU * second.turning_radius_um * count as f64 }];
        let way = joined_segments(way.iter().copied());
        let later = way.iter().rposition(|segment| segment.arm == Arm::Down).filter(|at| *at > 0).unwrap_or(way.len());
        let (before, after) = way.split_at(later);
        let go = |pose, segment: &ArmSegment| second.moved(pose, segment.arm, segment.way_um);
        let halt = (late > 0).then(|| before.iter().fold(self.from[1], go));
        let before = circles(early).into_iter().chain(before.iter().copied());
        let way = joined_segments(before.chain(circles(late)).chain(after.iter().copied()));
        SecondRobotPath { total_um: length_um(&way), way, halt }
    }

    /// Legs that bring both robots to their approaches at the same time, the second one by this path.
    fn timed(
        &self,
        second_path: &SecondRobotPath,
        stages: PairStages,
        site: PairSite,
        meter: &mut Meter,
    ) -> Result<Vec<Vec<Leg>>, StuckAssembly> {
        let first = self.facts[0];
        let later_um = match stages {
            PairStages::Sequential => second_path.way.iter().skip(1).map(|segment| segment.way_um).sum(),
            PairStages::Overlapping => {
                let last = second_path.way.last().filter(|segment| segment.arm == Arm::Up);
                last.map_or(0.0, |segment| segment.way_um)
            }
        };
        let asked = ClosingRequest {
            from: self.first_from(),
            to: self.approach[0],
            length_um: (self.total(second_path) - self.forced_strokes()) as f64 * first.step_um,
            least_last_um: later_um / self.facts[1].step_um * first.step_um,
            circles: self.circles,
        };
        let shortest = shortest_of_length(first, &asked, self.bed.order.precision.place_um);
        self.legs(second_path, shortest.into_iter().chain(closings(first, &asked)).collect(), site, meter)
    }

    /// Strokes of the second robot's path, and so of the first one's: at least one more than the forced ones.
    pub fn total(&self, second_path: &SecondRobotPath) -> u64 {
        ((second_path.total_um / self.facts[1].step_um).round() as u64).max(2)
    }

    pub fn forced_strokes(&self) -> u64 {
        u64::from(self.forced.is_some())
    }

    /// Pose of the first robot from which it can be driven freely.
    pub fn first_from(&self) -> Pose {
        let first = self.facts[0];
        self.forced.map_or(self.from[0], |arm| first.moved(self.from[0], arm, first.step_um))
    }

    /// Legs for the paths of the first robot that fit the second's and avoid the bodies at rest.
    fn legs(
        &self,
        second_path: &SecondRobotPath,
        ways: Vec<Vec<ArmSegment>>,
        site: PairSite,
        meter: &mut Meter,
    ) -> Result<Vec<Vec<Leg>>, StuckAssembly> {
        let ([first, second], index, start) = (self.facts, self.roles.first, self.first_from());
        let forced = self.forced_strokes();
        let theirs = StrokedPath { segments: &second_path.way, before: 0.0, step_um: second.step_um };
        let fits = |way: &Vec<ArmSegment>| {
            turns_within(&StrokedPath { segments: way, before: forced as f64, step_um: first.step_um }, &theirs)
        };
        let clear =
            |way: &Vec<ArmSegment>| site.ground.world.obstruction_on(index, start, way, site.fixtures).is_none();
        let mut kept: Vec<Vec<ArmSegment>> = Vec::new();
        for way in ways.into_iter().filter(fits) {
            if kept.len() == MAX_PATHS {
                break;
            }
            meter.step().ok_or(StuckAssembly::GaveUp)?;
            if clear(&way) {
                kept.push(way);
            }
        }
        let total = self.total(second_path);
        let whole_second = || whole(second, self.from[1], &second_path.way, &self.aims[1], total);
        let Some(seconds) = (!kept.is_empty()).then(whole_second).flatten() else { return Ok(Vec::new()) };
        let legs = |way: &Vec<ArmSegment>| {
            let mut track = ArmTrack::default();
            self.forced.into_iter().for_each(|arm| track.push(arm, 1));
            track.extend(&whole(first, start, way, &self.aims[0], total - forced)?);
            let aligned = track.aligned(&seconds, ALIGNED_STROKES);
            if self.aims[0].miss(aligned.end(first, self.from[0])) <= 1.0 {
                track = aligned;
            }
            legs_of_two(&track, &seconds, self.roles.states)
        };
        Ok(kept.iter().filter_map(legs).collect())
    }

    /// Pose of the first robot at the end of its own drive, after `driven` legs. Without a fine motion it lies on the
    /// line on which the controller lets it run, as far before the end as in the legs.
    fn intermediate(&self, legs: &[Leg], driven: usize) -> Pose {
        let first = self.facts[0];
        match self.fine {
            PlannedFineMotion::OneIn(_) => legs[..driven].iter().fold(self.from[0], |pose, leg| {
                let arm = if leg.state == self.roles.states[0] { Arm::Down } else { Arm::Up };
                first.moved(pose, arm, first.step_um * leg.strokes as f64)
            }),
            PlannedFineMotion::LeftOut => {
                let left: u64 = legs[driven..].iter().map(|leg| leg.strokes).sum();
                let run_um = first.step_um * left as f64 - self.bed.order.facts.fine.length_um;
                first.moved(self.gross_ends[0], Arm::Up, -run_um.max(0.0))
            }
        }
    }

    /// The whole stage, after legs that bring both to their approaches.
    fn stretch(&self, legs: Vec<Leg>, halt: Option<Pose>) -> StageAddition {
        let Roles { first, second, states } = self.roles;
        let driven = legs.iter().rposition(|leg| leg.state == states[0]).map_or(0, |last| last + 1);
        let intermediate = self.intermediate(&legs, driven);
        let pair = AssemblyStage::Pair {
            first,
            second,
            states,
            intermediate,
            approach: self.gross_ends,
            goals: self.goals,
            steered: Vec::new(),
        };
        let escort = halt.map(|to| AssemblyStage::Escort { robot: second, beside: first, states, to });
        let legs = joined(legs.into_iter().chain(self.cycles.legs(states)));
        StageAddition { legs, docking: vec![first, second], stages: escort.into_iter().chain([pair]).collect() }
    }
}

/// A path in the strokes of its robot.
struct StrokedPath<'a> {
    segments: &'a [ArmSegment],
    /// Strokes before the path begins.
    before: f64,
    step_um: f64,
}

impl StrokedPath<'_> {
    /// Spans of strokes in which it turns, without a few at either end.
    fn turns(&self) -> Vec<[f64; 2]> {
        let mut end = self.before;
        let mut spans: Vec<[f64; 2]> = Vec::new();
        for segment in self.segments {
            let start = end;
            end += segment.way_um / self.step_um;
            if segment.arm == Arm::Down && end - start > FEW_STROKES {
                spans.push([start + FEW_STROKES, end - FEW_STROKES]);
            }
        }
        spans
    }
}

/// Whether one robot turns only while the other does, up to a few strokes.
fn turns_within(one: &StrokedPath, other: &StrokedPath) -> bool {
    let theirs = other.turns();
    let covered = |span: &[f64; 2]| {
        theirs.iter().any(|other| other[0] - FEW_STROKES <= span[0] && span[1] <= other[1] + FEW_STROKES)
    };
    one.turns().iter().all(covered)
}
