//! One attempt to plan the robots of a program without collisions, under a policy: the order of planning, and whether
//! robots planned later make way.

use super::delayed;
use super::timing::{NoTiming, OtherRobot, TimedAct, TimedPath, TipStay};
use super::tips::PlacedRobot;
use crate::claims::dimibot::{DimibotObstacle, DimibotObstacleBody, DimibotOrder};
use crate::claims::{Claims, Job, Order, Timeline};
use crate::device::dimibot::{DimibotObjective, DimibotOutcome, LatticeCell};
use crate::diagnostic::Sink;
use crate::plan::dimibot::{DimibotMotion, DimibotStandings, DimibotStepMotion, SAFETY_MARGIN_UM, plan};
use crate::plan::requirements::{Kept, keeps};
use crate::plan::{Motion, Plan, Planned};
use crate::source::Span;
use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

/// Most branches of which every order is tried.
const MAX_PERMUTED: usize = 3;

/// Most places of other robots around which a detour is searched.
const MAX_PLACES: usize = 2_000;

/// Assumption about robots not yet planned, while the earlier ones are.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum UnplannedRobots {
    /// They will leave in time by their own plans.
    WillLeave,
    /// They stay where they are.
    StayPut,
}

/// Policy for planning a program.
#[derive(Debug, Clone)]
pub struct Policy {
    unplanned: UnplannedRobots,
    /// Order in which the branches of a `together` are planned, as indices of the written order.
    order: Vec<usize>,
}

/// Why an attempt failed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum TryReason {
    Met,
    /// The tips touch at the end of both plans.
    EndTogether,
    /// A requirement is missed.
    Missed,
    NoWay,
    Spent,
}

/// Point at which an attempt failed: the job, the robots that may be in its way, and the instant.
#[derive(Debug, Clone)]
pub struct TryFailure {
    pub reason: TryReason,
    pub job: usize,
    pub with: Vec<String>,
    /// Job of the robot in its way, if that is known.
    pub with_job: Option<usize>,
    pub at_ns: u64,
}

/// Plans that keep the robots apart.
pub struct FoundPlans<'a> {
    pub plans: Vec<Plan<Motion<'a>>>,
    /// Number of detours (plans on another path than alone), end of the program in ns, and sum of waits in ns; smaller
    /// is better.
    pub rank: (usize, u64, u64),
}

impl FoundPlans<'_> {
    /// Whether every plan is that of the robot alone.
    pub fn is_untouched(&self) -> bool {
        let (detours, _, idle_ns) = self.rank;
        detours == 0 && idle_ns == 0
    }
}

/// Partial plans of a program during one attempt.
struct Try<'a, 'r> {
    claims: &'a Claims,
    robots: &'r BTreeMap<&'a str, PlacedRobot>,
    policy: Policy,
    allowed: &'r mut u64,
    plans: Vec<Plan<Motion<'a>>>,
    traces: BTreeMap<&'a str, PlannedTrace>,
    /// Robots planned later, in the other branches of each enclosing `together`.
    later: Vec<BTreeSet<&'a str>>,
    /// Number of detours (plans on another path than alone); then the sum of waits.
    detours: usize,
    idle_ns: u64,
}

/// Positions of a robot from the first instant to the end of its plan so far, where it stays.
struct PlannedTrace {
    /// In order of time; the last one has no end.
    stretches: Vec<TipStay>,
    cell: LatticeCell,
    job: Option<usize>,
}

/// All policies worth an attempt, the most promising first.
pub fn tries(claims: &Claims, robots: &BTreeMap<&str, PlacedRobot>) -> Vec<Policy> {
    let branches = most_branches(&claims.timeline, claims, robots);
    let orders = orders(branches);
    let of = |unplanned| orders.iter().map(move |order| Policy { unplanned, order: order.clone() });
    of(UnplannedRobots::WillLeave).chain(of(UnplannedRobots::StayPut)).collect()
}

/// Orders of `branches` branches: all permutations of a few; of many, rotations of the written order (six at most) and
/// its reverse.
fn orders(branches: usize) -> Vec<Vec<usize>> {
    if branches > MAX_PERMUTED {
        let turned = |first| (0..branches).map(move |at| (at + first) % branches).collect::<Vec<_>>();
        let all = (0..branches.min(2 * MAX_PERMUTED)).map(turned);
        return all.chain([(0..branches).rev().collect()]).collect();
    }
    let mut orders = vec![Vec::new()];
    for _ in 0..branches {
        let longer = |order: Vec<usize>| {
            let rest: Vec<usize> = (0..branches).filter(|at| !order.contains(at)).collect();
            rest.into_iter().map(move |at| order.iter().copied().chain([at]).collect())
        };
        orders = orders.into_iter().flat_map(longer).collect();
    }
    orders
}

/// Largest number of branches, in one `together`, that move robots of a shared scene.
fn most_branches(timeline: &Timeline, claims: &Claims, robots: &BTreeMap<&str, PlacedRobot>) -> usize {
    let deeper = |parts: &[Timeline]| parts.iter().map(|part| most_branches(part, claims, robots)).max().unwrap_or(0);
    match timeline {
        Timeline::Run(_) | Timeline::Wait(_) => 1,
        Timeline::Sequence(parts) => deeper(parts).max(1),
        Timeline::Together(parts) => {
            let placed = parts.iter().filter(|part| !devices(part, claims, robots).is_empty()).count();
            deeper(parts).max(placed).max(1)
        }
    }
}

/// The robots of a part of the timeline that share a scene.
fn devices<'a>(part: &Timeline, claims: &'a Claims, robots: &BTreeMap<&str, PlacedRobot>) -> BTreeSet<&'a str> {
    match part {
        Timeline::Run(job) => {
            let device = claims.jobs[*job].device.as_str();
            robots.contains_key(device).then_some(device).into_iter().collect()
        }
        Timeline::Wait(_) => BTreeSet::new(),
        Timeline::Sequence(parts) | Timeline::Together(parts) => {
            parts.iter().flat_map(|part| devices(part, claims, robots)).collect()
        }
    }
}

/// Plans all runs of a program under a policy, starting from the plans of the robots alone.
///
/// # Errors
/// If neither a timing nor a detour was found. `allowed` is the remaining number of comparisons and is decremented.
pub fn attempt<'a>(
    claims: &'a Claims,
    robots: &BTreeMap<&'a str, PlacedRobot>,
    alone: &[Plan<Motion<'a>>],
    policy: Policy,
    allowed: &mut u64,
) -> Result<FoundPlans<'a>, TryFailure> {
    let traces = robots.iter().map(|(device, robot)| (*device, PlannedTrace::begin(device, robot, claims))).collect();
    let (plans, later) = (alone.to_vec(), Vec::new());
    let mut attempt = Try { claims, robots, policy, allowed, plans, traces, later, detours: 0, idle_ns: 0 };
    let end_ns = attempt.part(&claims.timeline, 0)?;
    Ok(FoundPlans { rank: (attempt.detours, end_ns, attempt.idle_ns), plans: attempt.plans })
}

impl<'a> Try<'a, '_> {
    fn part(&mut self, part: &Timeline, start_ns: u64) -> Result<u64, TryFailure> {
        match part {
            Timeline::Wait(duration_ns) => Ok(start_ns.saturating_add(*duration_ns)),
            Timeline::Run(job) => self.job(*job, start_ns),
            Timeline::Sequence(parts) => parts.iter().try_fold(start_ns, |at_ns, part| self.part(part, at_ns)),
            Timeline::Together(parts) => self.together(parts, start_ns),
        }
    }

    fn together(&mut self, parts: &[Timeline], start_ns: u64) -> Result<u64, TryFailure> {
        let robots: Vec<BTreeSet<&str>> = parts.iter().map(|part| devices(part, self.claims, self.robots)).collect();
        let placed: Vec<usize> = (0..parts.len()).filter(|at| !robots[*at].is_empty()).collect();
        let turns = self.policy.order.clone();
        let mut order: Vec<usize> = turns.iter().filter_map(|turn| placed.get(*turn)).copied().collect();
        order.extend((0..parts.len()).filter(|at| robots[*at].is_empty()));
        let mut end_ns = start_ns;
        for (turn, at) in order.iter().enumerate() {
            self.later.push(order[turn + 1..].iter().flat_map(|at| robots[*at].iter().copied()).collect());
            end_ns = end_ns.max(self.part(&parts[*at], start_ns)?);
            self.later.pop();
        }
        Ok(end_ns)
    }

    fn job(&mut self, index: usize, start_ns: u64) -> Result<u64, TryFailure> {
        let claims = self.claims;
        let job = &claims.jobs[index];
        let device = job.device.as_str();
        let (Some(robot), Some(order)) = (self.robots.get(device), DimibotOrder::of(&job.order)) else {
            return Ok(start_ns.saturating_add(duration_ns(&self.plans[index])));
        };
        let cell = self.traces[device].cell;
        let alone =
            self.alone(index, order, cell).ok_or_else(|| self.failure(TryReason::NoWay, index, None, start_ns))?;
        let (plan, way, delays) = self.timed(index, robot, order, &alone, start_ns)?;
        let (stretches, end_ns) = way.stretches(&delays);
        self.idle_ns = self.idle_ns.saturating_add(delays.iter().sum());
        let is_detour = plan.motion != alone.motion;
        let end = end_of(&plan.motion);
        self.plans[index] = delayed(&alone, plan, delays).map(|motion| Motion::Dimibot(Planned { order, motion }));
        self.detours += usize::from(is_detour);
        if let Some(trace) = self.traces.get_mut(device) {
            trace.follow(stretches, end, index);
        }
        Ok(end_ns)
    }

    /// The best plan of a robot alone from its current cell.
    fn alone(&self, index: usize, order: &DimibotOrder, cell: LatticeCell) -> Option<Plan<DimibotMotion>> {
        let known = &self.plans[index];
        match &known.motion {
            Motion::Dimibot(Planned { motion, .. }) if motion.start == cell => {
                Some(known.clone().map(|_| motion.clone()))
            }
            Motion::Dimibot(_) | Motion::ElectrodeArray(_) | Motion::Microrobots(_) | Motion::Fingers(_) => {
                replanned(&self.claims.jobs[index], order, cell)
            }
        }
    }

    /// The cheapest plan with its path and delays. Detours are tried only if the robot's own best path cannot be timed,
    /// or needs waits while time is minimised.
    fn timed(
        &mut self,
        index: usize,
        robot: &PlacedRobot,
        order: &DimibotOrder,
        alone: &Plan<DimibotMotion>,
        start_ns: u64,
    ) -> Result<(Plan<DimibotMotion>, TimedPath, Vec<u64>), TryFailure> {
        let job = &self.claims.jobs[index];
        let mut failure = None;
        let mut best: Option<(Plan<DimibotMotion>, TimedPath, Vec<u64>)> = None;
        for avoided in Avoided::ALL {
            let plan = match avoided {
                Avoided::Nothing => Some(alone.clone()),
                Avoided::FinalPositions | Avoided::AllPositions => {
                    self.detour(index, robot, order, alone, avoided, start_ns)
                }
            };
            let Some(plan) = plan else { continue };
            let way = self.way(job, robot, &plan.motion, start_ns);
            match self.delays(index, &way) {
                Ok(delays) if keeps_all(job, &delayed(alone, plan.clone(), delays.clone())) => {
                    let is_final =
                        delays.iter().all(|delay| *delay == 0) || plan.objective != DimibotObjective::Time.name();
                    if best.as_ref().is_none_or(|known| total(&plan, &delays) < total(&known.0, &known.2)) {
                        best = Some((plan, way, delays));
                    }
                    if is_final {
                        break;
                    }
                }
                Ok(_) => {
                    failure.get_or_insert(self.failure(TryReason::Missed, index, None, start_ns));
                }
                Err(met) if met.reason == TryReason::Spent => return Err(met),
                Err(met) => {
                    failure.get_or_insert(met);
                }
            }
        }
        best.ok_or_else(|| failure.unwrap_or_else(|| self.failure(TryReason::NoWay, index, None, start_ns)))
    }

    fn way(&self, job: &Job, robot: &PlacedRobot, motion: &DimibotMotion, start_ns: u64) -> TimedPath {
        let mut cell = motion.start;
        let mut acts = Vec::new();
        for step in &motion.steps {
            match step {
                DimibotStepMotion::Wait(duration_ns) => acts.push(TimedAct::Wait(*duration_ns)),
                DimibotStepMotion::Pulses(pulses) => {
                    for pulse in pulses {
                        let after = LatticeCell::new(cell.x ^ pulse.left, cell.y ^ pulse.right);
                        acts.push(TimedAct::Pulse { within: robot.between(cell, after), to: robot.at(after) });
                        cell = after;
                    }
                }
            }
        }
        let since_ns = self.traces[job.device.as_str()].since_ns().min(start_ns);
        let pulse_ns = robot.facts.pulse_duration_ns;
        let slot_ns = pulse_ns + robot.facts.rest_ns;
        let grain_ns = grain_ns(self.robots);
        TimedPath { since_ns, start_ns, from: robot.at(motion.start), acts, pulse_ns, slot_ns, grain_ns }
    }

    fn delays(&mut self, index: usize, way: &TimedPath) -> Result<Vec<u64>, TryFailure> {
        let own = self.claims.jobs[index].device.as_str();
        let names: Vec<&str> = self.neighbours(own);
        let others: Vec<OtherRobot> = names.iter().map(|name| self.other(own, name)).collect();
        let mut allowed = *self.allowed;
        let delays = way.delays(&others, &mut allowed);
        drop(others);
        *self.allowed = allowed;
        delays.map_err(|stuck| match stuck {
            NoTiming::Met(meeting) => {
                let with = names[meeting.with];
                let reason = if self.end_together(own, way, with) { TryReason::EndTogether } else { TryReason::Met };
                self.failure(reason, index, Some(with), meeting.at_ns)
            }
            NoTiming::Spent => self.failure(TryReason::Spent, index, None, way.start_ns),
        })
    }

    /// Whether a path ends too near the last place of another robot that was planned before.
    fn end_together(&self, own: &str, way: &TimedPath, with: &str) -> bool {
        let last = |stretches: &[TipStay]| stretches.last().map(|stretch| stretch.area);
        let (end, beside) = (last(&way.stretches(&[]).0), last(self.other(own, with).stretches));
        let is_planned = self.traces[with].job.is_some();
        is_planned && end.zip(beside).is_some_and(|(end, beside)| end.is_near(&beside, self.gap_um(own, with)))
    }

    /// The other robots that share a scene with a robot.
    fn neighbours(&self, own: &str) -> Vec<&'a str> {
        let scenes = self.claims.shared.iter().filter(|scene| scene.frames.contains_key(own));
        let names: BTreeSet<&str> = scenes.flat_map(|scene| scene.frames.keys()).map(String::as_str).collect();
        names.into_iter().filter(|name| *name != own).collect()
    }

    /// Another robot as an obstacle: without its last place if it is expected to make way.
    fn other(&self, own: &str, name: &str) -> OtherRobot<'_> {
        let stretches = self.traces[name].stretches.as_slice();
        let makes_way =
            self.policy.unplanned == UnplannedRobots::WillLeave && self.later.iter().any(|later| later.contains(name));
        let stretches = match makes_way {
            true => &stretches[..stretches.len().saturating_sub(1)],
            false => stretches,
        };
        OtherRobot { stretches, gap_um: self.gap_um(own, name) }
    }

    fn gap_um(&self, own: &str, name: &str) -> f64 {
        let growth = |device: &str| self.robots.get(device).map_or(0.0, |robot| robot.facts.growth_um());
        growth(own) + growth(name) + SAFETY_MARGIN_UM
    }

    /// A plan that avoids places of the others; `None` if there is none, or nothing to avoid.
    fn detour(
        &self,
        index: usize,
        robot: &PlacedRobot,
        order: &DimibotOrder,
        alone: &Plan<DimibotMotion>,
        avoided: Avoided,
        start_ns: u64,
    ) -> Option<Plan<DimibotMotion>> {
        let job = &self.claims.jobs[index];
        let cell = alone.motion.start;
        let mut obstacles: Vec<DimibotObstacle> = Vec::new();
        for name in self.neighbours(&job.device) {
            let (other, beside) = (self.robots.get(name)?, self.other(&job.device, name));
            let from = beside.stretches.partition_point(|stretch| stretch.end_ns < start_ns);
            for stretch in &beside.stretches[from..] {
                if avoided == Avoided::FinalPositions && stretch.end_ns != u64::MAX {
                    continue;
                }
                let around_um = beside.gap_um - robot.facts.growth_um();
                let (shape, pose) = other.obstacle(&stretch.area, around_um);
                let body = DimibotObstacleBody::Solid { shape, pose };
                if !obstacles.iter().any(|known| known.body == body) {
                    obstacles.push(DimibotObstacle { name: name.to_owned(), body, span: Span::default() });
                }
                if obstacles.len() > MAX_PLACES {
                    return None;
                }
            }
        }
        if obstacles.is_empty() {
            return None;
        }
        let obstacles = Arc::new(order.obstacles.iter().cloned().chain(obstacles).collect());
        let frame = Some(robot.frame);
        replanned(job, &DimibotOrder { obstacles, frame, ..order.clone() }, cell)
    }

    /// A failure at another robot, or at any of those that share the scene.
    fn failure(&self, reason: TryReason, job: usize, with: Option<&str>, at_ns: u64) -> TryFailure {
        let own = self.claims.jobs[job].device.as_str();
        let with = with.map_or_else(|| self.neighbours(own), |with| vec![with]);
        let with_job = match with[..] {
            [only] => self.traces.get(only).and_then(|trace| trace.job),
            _ => None,
        };
        TryFailure { reason, job, with: with.into_iter().map(str::to_owned).collect(), with_job, at_ns }
    }
}

/// Places that a plan avoids, besides the obstacles of the scene.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Avoided {
    Nothing,
    FinalPositions,
    AllPositions,
}

impl Avoided {
    const ALL: [Avoided; 3] = [Avoided::Nothing, Avoided::FinalPositions, Avoided::AllPositions];
}

impl PlannedTrace {
    /// A robot at the start of its first run.
    fn begin(device: &str, robot: &PlacedRobot, claims: &Claims) -> PlannedTrace {
        let first = claims.jobs.iter().find(|job| job.device == device).and_then(|job| DimibotOrder::of(&job.order));
        let cell = first.and_then(|order| order.start).map_or(robot.facts.home, |start| start.value);
        let stretches = vec![TipStay { start_ns: 0, end_ns: u64::MAX, area: robot.at(cell) }];
        PlannedTrace { stretches, cell, job: None }
    }

    /// Instant from which it stays at its last place.
    fn since_ns(&self) -> u64 {
        self.stretches.last().map_or(0, |stretch| stretch.start_ns)
    }

    fn follow(&mut self, stretches: Vec<TipStay>, cell: LatticeCell, job: usize) {
        self.stretches.pop();
        self.stretches.extend(stretches);
        (self.cell, self.job) = (cell, Some(job));
    }
}

/// Cell in which a motion ends.
fn end_of(motion: &DimibotMotion) -> LatticeCell {
    let pulses = motion.steps.iter().flat_map(|step| match step {
        DimibotStepMotion::Pulses(pulses) => pulses.as_slice(),
        DimibotStepMotion::Wait(_) => &[],
    });
    pulses.fold(motion.start, |cell, pulse| LatticeCell::new(cell.x ^ pulse.left, cell.y ^ pulse.right))
}

/// A plan from a cell, if the planner finds one.
fn replanned(job: &Job, order: &DimibotOrder, cell: LatticeCell) -> Option<Plan<DimibotMotion>> {
    let mut standing = DimibotStandings::at(&job.device, cell);
    let job = Job { order: Order::Dimibot(order.clone()), ..job.clone() };
    plan(&job, order, &mut standing, &mut Sink::default())
}

/// The largest power of ten, in nanoseconds, that divides the pulse and rest times of all robots.
fn grain_ns(robots: &BTreeMap<&str, PlacedRobot>) -> u64 {
    let divides = |grain_ns: u64| {
        let times = robots.values().flat_map(|robot| [robot.facts.pulse_duration_ns, robot.facts.rest_ns]);
        times.into_iter().all(|time_ns| time_ns % grain_ns == 0)
    };
    std::iter::successors(Some(1), |grain_ns| Some(grain_ns * 10))
        .take_while(|grain_ns| divides(*grain_ns))
        .take(18)
        .last()
        .unwrap_or(1)
}

fn keeps_all(job: &Job, plan: &Plan<DimibotMotion>) -> bool {
    let reached = |name: &str| plan.outcomes.get(name).copied();
    job.requirements
        .iter()
        .all(|asked| reached(&asked.outcome).is_none_or(|reached| keeps(asked, reached) == Kept::Yes))
}

/// Cost of a plan, including its delays if time is minimised.
fn total(plan: &Plan<DimibotMotion>, delays: &[u64]) -> f64 {
    let idle_ms = delays.iter().sum::<u64>() as f64 / 1e6;
    if plan.objective == DimibotObjective::Time.name() { plan.cost + idle_ms } else { plan.cost }
}

fn duration_ns<M>(plan: &Plan<M>) -> u64 {
    // Every kind counts time in whole nanoseconds; seconds as `f64` convert back exactly up to the longest schedule.
    (plan.outcomes.get(DimibotOutcome::Time.name()).copied().unwrap_or_default() * 1e9).round() as u64
}
