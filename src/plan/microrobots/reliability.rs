//! Choice of the plan whose simulated trials fail least, and the share of a plan's trials that fail.
//!
//! Problem: plans that take about the same time differ widely in how often robots with errors carry them out, because a
//! robot that recovers from an error drives circles, which hit what stands near. Method: the job is planned again with
//! more room (`ROOMS`) and other initial legs. All plans are simulated with a few trials, the rooms of the best ones
//! get more initial legs, and the better plans get more and more trials. Guaranteed: the plan keeps the clearances of
//! the task, and the same request gives the same plan. Not guaranteed: that no plan fails less. The reported share is
//! counted in separate trials, so that the choice does not flatter it. Cost: about twenty-five plans, and two thousand
//! trials in all.

use super::simulation::{self, SimulationReport};
use super::steps::{BedRoute, InitialLegChoice, plan_steps};
use super::why::with_errors;
use super::{Crew, MicrorobotsMotion};
use crate::claims::Job;
use crate::claims::microrobots::{MicrorobotsAction, MicrorobotsOrder};
use crate::device::microrobots::MicrorobotsObjective;
use crate::diagnostic::{Code, Diagnostic, Remark, Sink};
use crate::plan::watch::IncumbentPlan;
use crate::quantity::digits;
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

/// Seeds of initial legs: `FIRST_DRAWS` for each room, then up to `DRAWS` for the `GOOD_ROOMS` rooms of the best plans.
const FIRST_DRAWS: u64 = 2;
const GOOD_ROOMS: usize = 2;
const DRAWS: u64 = 6;

/// Trials of each plan before the rooms are chosen.
const FIRST_TRIALS: u64 = 16;

/// Rounds of the choice: trials per plan, and the most plans that enter the round.
const ROUNDS: [(u64, usize); 3] = [(20, usize::MAX), (60, 6), (200, 2)];

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
    let rooms = ROOMS.map(|shares| widened(order, shares));
    let planned = |room: usize, initial_legs: InitialLegChoice, routes: &mut Vec<(usize, BedRoute)>| {
        let route = plan_steps(order, &rooms[room], start, is_first, initial_legs, &mut Sink::default());
        let is_new = |route: &BedRoute| routes.iter().all(|other| other.1.motion != route.motion);
        if let Some(route) = route.filter(is_new) {
            routes.push((room, route));
        }
    };
    let _held = IncumbentPlan::begin(|| format!("{:.1} s", fastest.motion.duration_ns(order) as f64 / 1e9));
    let mut routes = vec![(0, fastest)];
    planned(0, InitialLegChoice::None, &mut routes);
    for room in 0..ROOMS.len() {
        (1..=FIRST_DRAWS).for_each(|seed| planned(room, InitialLegChoice::Drawn(seed), &mut routes));
    }
    let all = |routes: &[(usize, BedRoute)]| (0..routes.len()).collect::<Vec<usize>>();
    let mut good: Vec<usize> = Vec::new();
    for route in ranked(order, &routes, all(&routes), FIRST_TRIALS) {
        if !good.contains(&routes[route].0) && good.len() < GOOD_ROOMS {
            good.push(routes[route].0);
        }
    }
    for room in good {
        (FIRST_DRAWS + 1..=DRAWS).for_each(|seed| planned(room, InitialLegChoice::Drawn(seed), &mut routes));
    }
    let mut kept = all(&routes);
    for (trials, most) in ROUNDS {
        kept.truncate(most);
        kept = ranked(order, &routes, kept, trials);
    }
    routes.swap_remove(kept.first().copied().unwrap_or_default()).1
}

/// Sorts plans by how many of `trials` trials fail, then by duration.
fn ranked(order: &MicrorobotsOrder, routes: &[(usize, BedRoute)], mut kept: Vec<usize>, trials: u64) -> Vec<usize> {
    let work = MAX_WORK / kept.len().max(1) as u64;
    let failures = |route: &usize| {
        let report = simulated(order, &routes[*route].1.motion, LEAST_TRIALS..=trials, CHOICE_SEED, work);
        report.map_or(u64::MAX, |report| (report.trials - report.successes) * trials / report.trials.max(1))
    };
    kept.sort_by_cached_key(|route| (failures(route), routes[*route].1.motion.duration_ns(order), *route));
    kept
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
    let threads = std::thread::available_parallelism().map_or(1, std::num::NonZero::get);
    (allowed >= *trials.start()).then(|| simulation::simulate(order, motion, allowed, seed, threads)).flatten()
}
