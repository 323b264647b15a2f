//! Choice of the plan whose simulated trials fail least, and the share of a plan's trials that fail.
//!
//! Problem: plans that take about the same time differ widely in how often robots with errors carry them out, because a
//! robot that recovers from an error drives circles, which hit what stands near. Method: the job is planned again with
//! more room (`ROOMS`) and other initial legs. All plans are simulated with a few trials, the rooms of the best ones
//! get more initial legs, and the better plans get more and more trials; again, until a plan rarely fails. Guaranteed:
//! the plan keeps the clearances of the task, and the same request gives the same plan. Not guaranteed: that no plan
//! fails less. The reported share is counted in separate trials, so that the choice does not flatter it. Cost: 26 to 50
//! plans, and one to three thousand trials in all.

use super::simulation::{self, SimulationReport};
use super::steps::{BedRoute, InitialLegChoice, plan_steps};
use super::why::with_errors;
use super::{Crew, MicrorobotsMotion};
use crate::claims::Job;
use crate::claims::microrobots::{MicrorobotsAction, MicrorobotsOrder};
use crate::device::microrobots::MicrorobotsObjective;
use crate::diagnostic::{Code, Diagnostic, Remark, Sink};
use crate::plan::parallel::{self, processors};
use crate::plan::watch::{self, IncumbentPlan};
use crate::quantity::digits;
use std::collections::BTreeMap;
use std::ops::RangeInclusive;
use std::sync::Arc;

/// Room that the tried plans keep. The first two numbers are added to the clearance of bodies and to that of orbits, as
/// shares of the largest turning radius, since circles need the room. The third is the length of the fine motion, as a
/// multiple of the device's: a robot that turns to its approach farther from the structure has room for a circle there.
const ROOMS: [[f64; 3]; 8] = [
    [0.0, 0.0, 1.0],
    [0.3, 0.25, 1.0],
    [0.6, 0.5, 1.5],
    [1.0, 0.0, 2.0],
    [0.0, 0.8, 1.0],
    [0.6, 1.2, 1.5],
    [1.5, 0.5, 1.0],
    [0.3, 1.8, 2.0],
];

/// Seeds of initial legs: `FIRST_DRAWS` for each room, then `MORE_DRAWS` at a time for the `GOOD_ROOMS` rooms of the
/// best plans, up to `MAX_PASSES` times or until at most `RARE_FAILURES` of the trials of the best plan fail.
const FIRST_DRAWS: u64 = 2;
const MORE_DRAWS: u64 = 4;
const GOOD_ROOMS: usize = 2;
const MAX_PASSES: usize = 4;
const RARE_FAILURES: f64 = 0.05;

/// Most plans: the fastest one, one without initial legs, and those with all initial legs drawn.
const MAX_POOL: usize = 2 + ROOMS.len() * FIRST_DRAWS as usize + MAX_PASSES * GOOD_ROOMS * MORE_DRAWS as usize;

/// Rounds of the choice: trials per plan, and the most plans that enter the round.
const ROUNDS: [(u64, usize); 3] = [(20, MAX_POOL), (60, 6), (200, 2)];

/// Seed of the trials used for the choice.
const CHOICE_SEED: u64 = 2;

/// Trials that are reported, and their seed.
const EXPECTED_TRIALS: u64 = 400;
const EXPECTED_SEED: u64 = 1;

/// Most work of the trials of one round of the choice, of those that are reported, and of those that check a guarantee.
/// Work is a plan's number of intervals (weighted) and of stretches of [`STRETCH_UM`] of all its robots, times the
/// trials. Enough for all trials of ten robots that drive for some minutes.
pub(super) const MAX_WORK: u64 = 16_000_000;

/// Work of an interval, in which the controller measures and decides, relative to that of a stretch.
const INTERVAL_WORK: u64 = 2;

/// Intervals by which a trial may outlast its plan: about the number of times that a pair that misses tries again.
const MORE_INTERVALS: u64 = 20;

/// Path between two collision checks of a simulated robot, in micrometres.
const STRETCH_UM: f64 = 10.0;

/// With fewer trials no failure share is reported.
const LEAST_TRIALS: u64 = 10;

/// Share of successes below which a plan gets a warning.
const DOUBTFUL_SHARE: f64 = 0.5;

/// Subject of the remark on the share of trials that succeed.
pub const EXPECTED: &str = "expected";

/// Returns the plan of a job whose trials fail least; `fastest` is one of the candidates.
pub fn most_reliable(order: &MicrorobotsOrder, start: &Crew, is_first: bool, fastest: BedRoute) -> BedRoute {
    let can_fail = order.facts.errors.is_some_and(|errors| !errors.are_zero());
    if !can_fail || !assembles(order) {
        return fastest;
    }
    let held = IncumbentPlan::begin(|| format!("{:.1} s", fastest.motion.duration_ns(order) as f64 / 1e9));
    let mut pool = PlanPool::new(order, start, is_first, fastest);
    pool.plan(&[(0, InitialLegChoice::None)]);
    pool.draw(0..ROOMS.len(), FIRST_DRAWS);
    let mut best = 0;
    for _ in 0..MAX_PASSES {
        let good = pool.good_rooms();
        pool.draw(good, MORE_DRAWS);
        let (plan, failures) = pool.best();
        best = plan;
        // A plan that is too long to be simulated keeps its duration.
        if failures.is_finite() {
            held.improve(|| format!("{} % of trials fail", digits((failures * 1e3).round() / 10.0)));
        }
        if failures <= RARE_FAILURES || !watch::may_continue() {
            break;
        }
    }
    pool.plans.swap_remove(best).route
}

/// A plan, and the room that it keeps.
struct PooledPlan {
    room: usize,
    route: BedRoute,
}

/// Plans of one job, among which the one that fails least is chosen.
struct PlanPool<'a> {
    order: &'a MicrorobotsOrder,
    start: &'a Crew,
    is_first: bool,
    /// The order with each of the `ROOMS`, and the number of initial legs drawn for it.
    rooms: [MicrorobotsOrder; ROOMS.len()],
    drawn: [u64; ROOMS.len()],
    plans: Vec<PooledPlan>,
    /// Share of trials that fail, by plan and round.
    failures: BTreeMap<(usize, usize), f64>,
}

impl<'a> PlanPool<'a> {
    fn new(order: &'a MicrorobotsOrder, start: &'a Crew, is_first: bool, fastest: BedRoute) -> PlanPool<'a> {
        let rooms = ROOMS.map(|shares| widened(order, shares));
        let plans = vec![PooledPlan { room: 0, route: fastest }];
        PlanPool { order, start, is_first, rooms, drawn: [0; ROOMS.len()], plans, failures: BTreeMap::new() }
    }

    /// Adds the plans with these rooms and initial legs, as far as there are any and they are new.
    fn plan(&mut self, choices: &[(usize, InitialLegChoice)]) {
        let planned = |choice: usize| {
            if !watch::may_continue() {
                return None;
            }
            let (room, initial) = choices[choice];
            let sink = &mut Sink::default();
            let route = plan_steps(self.order, &self.rooms[room], self.start, self.is_first, initial, sink)?;
            Some(PooledPlan { room, route })
        };
        for plan in parallel::in_order(choices.len(), processors(), planned).into_iter().flatten() {
            if self.plans.iter().all(|other| other.route.motion != plan.route.motion) {
                self.plans.push(plan);
            }
        }
    }

    /// Adds plans with that many more initial legs in each of these rooms.
    fn draw(&mut self, rooms: impl IntoIterator<Item = usize>, draws: u64) {
        let mut choices = Vec::new();
        for room in rooms {
            let first = self.drawn[room] + 1;
            self.drawn[room] += draws;
            choices.extend((first..=self.drawn[room]).map(|seed| (room, InitialLegChoice::Drawn(seed))));
        }
        self.plan(&choices);
    }

    /// Rooms of the plans that fail least in the first round.
    fn good_rooms(&mut self) -> Vec<usize> {
        let mut good: Vec<usize> = Vec::new();
        for plan in self.ranked((0..self.plans.len()).collect(), 0) {
            let room = self.plans[plan].room;
            if !good.contains(&room) && good.len() < GOOD_ROOMS {
                good.push(room);
            }
        }
        good
    }

    /// The plan that fails least after all rounds, and the share of its trials that fail in the last one.
    fn best(&mut self) -> (usize, f64) {
        let mut kept = (0..self.plans.len()).collect();
        for round in 0..ROUNDS.len() {
            kept = self.ranked(kept, round);
        }
        let best = kept.first().copied().unwrap_or_default();
        (best, self.failures(best, ROUNDS.len() - 1))
    }

    /// The first plans of these that enter a round, by how many of its trials fail, then by duration.
    fn ranked(&mut self, mut plans: Vec<usize>, round: usize) -> Vec<usize> {
        plans.truncate(ROUNDS[round].1);
        let mut ranked: Vec<(f64, u64, usize)> = Vec::with_capacity(plans.len());
        for plan in plans {
            ranked.push((self.failures(plan, round), self.plans[plan].route.motion.duration_ns(self.order), plan));
        }
        ranked.sort_by(|one, other| one.0.total_cmp(&other.0).then((one.1, one.2).cmp(&(other.1, other.2))));
        ranked.into_iter().map(|(_, _, plan)| plan).collect()
    }

    /// Share of a plan's trials in a round that fail; infinite if it is too long to be simulated.
    fn failures(&mut self, plan: usize, round: usize) -> f64 {
        let (trials, most) = ROUNDS[round];
        let simulated = || {
            let motion = &self.plans[plan].route.motion;
            let report = simulated(self.order, motion, LEAST_TRIALS..=trials, CHOICE_SEED, MAX_WORK / most as u64);
            report.map_or(f64::INFINITY, |report| 1.0 - report.successes as f64 / report.trials.max(1) as f64)
        };
        *self.failures.entry((plan, round)).or_insert_with(simulated)
    }
}

/// Share of simulated trials of a plan that fail; adds a remark on it, and a warning if most fail. `None` if nothing is
/// assembled, the device does not state its errors, or the plan is too long to be simulated.
pub fn failure_share(
    job: &Job,
    order: &MicrorobotsOrder,
    motion: &MicrorobotsMotion,
    remarks: &mut Vec<Remark>,
    sink: &mut Sink,
) -> Option<f64> {
    let report = simulated(order, motion, LEAST_TRIALS..=EXPECTED_TRIALS, EXPECTED_SEED, MAX_WORK)?;
    let SimulationReport { trials, successes, .. } = report;
    let percent = |share: f64| digits((share * 1e3).round() / 10.0);
    let share = successes as f64 / trials.max(1) as f64;
    let [low, high] = report.wilson.map(percent);
    let counted = format!("{successes} of {trials} simulated trials succeed, {low} to {high} % with 95 % confidence");
    if share < DOUBTFUL_SHARE {
        let help = match order.objective {
            MicrorobotsObjective::Failures => {
                "`tweeze simulate` lists why trials fail; more room between robots or smaller errors help"
            }
            MicrorobotsObjective::Time | MicrorobotsObjective::Switches => {
                "`minimize failures` chooses the plan that fails least; `tweeze simulate` lists why trials fail"
            }
        };
        let title = format!("the assembly of `{}` is likely to fail: {counted}", job.task);
        let assembly = order.steps.iter().find(|step| matches!(step.action, MicrorobotsAction::Assemble(_)));
        let span = assembly.map_or(job.run_span, |step| step.span);
        sink.push(Diagnostic::new(Code::W0511, title).label(span, with_errors(order)).help(help));
    }
    remarks.push(Remark { subject: EXPECTED.to_owned(), text: counted });
    Some(1.0 - share)
}

fn assembles(order: &MicrorobotsOrder) -> bool {
    order.steps.iter().any(|step| matches!(step.action, MicrorobotsAction::Assemble(_)))
}

/// The same order with larger clearances; a plan that keeps these keeps the order's own.
fn widened(order: &MicrorobotsOrder, shares: [f64; 3]) -> MicrorobotsOrder {
    let radii_um = (0..order.robots.len()).map(|robot| order.robot(robot).turning_radius_um);
    let radius_um = radii_um.fold(0.0, f64::max);
    let mut wider = order.clone();
    let facts = Arc::make_mut(&mut wider.facts);
    facts.clearance_um += shares[0] * radius_um;
    facts.orbit_clearance_um += shares[1] * radius_um;
    facts.fine.length_um *= shares[2];
    wider
}

/// Simulates as many trials as the work allows, up to the end of the range. `None` also if these are fewer than its
/// start.
pub(super) fn simulated(
    order: &MicrorobotsOrder,
    motion: &MicrorobotsMotion,
    trials: RangeInclusive<u64>,
    seed: u64,
    most_work: u64,
) -> Option<SimulationReport> {
    let errors = order.facts.errors?;
    let stroke_um: f64 = (0..order.robots.len()).map(|robot| order.robot(robot).step_um).sum();
    let (duration_ns, replan_ns) = (motion.duration_ns(order).max(1), errors.replan_ns.max(1));
    let intervals = duration_ns / replan_ns;
    // A robot that is off its path drives on for whole intervals, however short the plan is.
    let longest_ns = duration_ns.saturating_add(replan_ns.saturating_mul(MORE_INTERVALS));
    let strokes = motion.strokes() as f64 * (longest_ns as f64 / duration_ns as f64);
    let work = intervals.saturating_mul(INTERVAL_WORK).saturating_add((strokes * stroke_um / STRETCH_UM) as u64);
    let work = work.saturating_add(1);
    let allowed = (most_work / work).min(*trials.end());
    (allowed >= *trials.start()).then(|| simulation::simulate(order, motion, allowed, seed, processors())).flatten()
}
