//! Maximal time lags: errands that must not be done too long after others.
//!
//! Method: lists that ignore the lags (`lists`). Where their plan breaks a lag, the earlier errand is held back by the
//! excess, and the lists are tried again. This helps because the later errand is late since it waits for a cell, an
//! agent or other errands, which do not depend on the earlier one.
//!
//! Guaranteed: plans keep all lags. Lower bounds without lags hold with them too. Where no such lists are found, the
//! joint search (`joint`) respects the lags.

use super::bound::AssayBounds;
use super::replay::done_by;
use super::route::StopDistances;
use super::{AgentCourse, AssayProblem, ErrandLag, ErrandPlace, lists};
use crate::plan::electrode_array::board::BoardObjective;
use crate::plan::electrode_array::fast::UNREACHABLE;
use crate::plan::search::Meter;

/// Rounds of holding errands back, and 1/N of the remaining budget for all of them.
const ROUNDS: usize = 24;
const HELD_SHARE: u64 = 2;

/// Courses that keep all lags, if lists yield them.
pub(super) fn by_lists(
    problem: &AssayProblem,
    ahead: &StopDistances,
    objective: BoardObjective,
    bounds: &AssayBounds,
    meter: &mut Meter,
) -> Option<Vec<AgentCourse>> {
    let first = lists::best(problem, ahead, objective, bounds, meter)?;
    if are_kept(problem, &first) {
        return Some(first);
    }
    let mut held = problem.clone();
    held.releases = problem.unheld();
    let share = meter.left().steps / HELD_SHARE;
    meter.share(share, |meter| held_back(&mut held, ahead, objective, bounds, first, meter))
}

/// Holds back errands that are done too early, until the courses of the best lists keep all lags.
fn held_back(
    held: &mut AssayProblem,
    ahead: &StopDistances,
    objective: BoardObjective,
    bounds: &AssayBounds,
    mut courses: Vec<AgentCourse>,
    meter: &mut Meter,
) -> Option<Vec<AgentCourse>> {
    for _ in 0..ROUNDS {
        for (place, release) in late(held, &courses) {
            let (place, release) = held.held_back_by(place, release)?;
            let own = &mut held.releases[place.agent][place.errand];
            *own = release.max(*own + 1);
        }
        courses = lists::best(held, ahead, objective, bounds, meter)?;
        if are_kept(held, &courses) {
            return Some(courses);
        }
    }
    None
}

/// Whether courses keep all lags.
pub fn are_kept(problem: &AssayProblem, courses: &[AgentCourse]) -> bool {
    late(problem, courses).is_empty()
}

/// The errands that are done too early before another one, each with the instant at which it should begin instead.
fn late(problem: &AssayProblem, courses: &[AgentCourse]) -> Vec<(ErrandPlace, u32)> {
    if problem.lags.is_empty() {
        return Vec::new();
    }
    let done = done_by(problem, courses);
    let end = |place: &ErrandPlace| done[place.agent].get(place.errand).copied().unwrap_or(u32::MAX);
    let of_lag = |lag: &ErrandLag| {
        let last = lag.after.iter().max_by_key(|place| end(place))?;
        let excess = end(&lag.of).saturating_sub(end(last)).saturating_sub(problem.most_to_end(lag));
        let work = problem.errands[last.agent][last.errand].work();
        (excess > 0).then(|| (*last, end(last).saturating_sub(work).saturating_add(excess)))
    };
    problem.lags.iter().filter_map(of_lag).collect()
}

/// An errand that its agent cannot reach in time, even alone, from an earlier one. The earlier one is a predecessor in
/// the lag, or comes after all of these.
pub(super) fn hopeless(problem: &AssayProblem, ahead: &StopDistances) -> Option<ErrandPlace> {
    let is_far = |lag: &&ErrandLag| {
        let ErrandPlace { agent, errand: last } = lag.of;
        let errands = &problem.errands[agent];
        // Steps from the end of an errand until the agent begins the last one at its stop.
        let steps_from = |first: usize| {
            let way = |index: usize| match ahead.steps(agent, index, errands[index - 1].stop) {
                UNREACHABLE => 0,
                way => way,
            };
            let ways = (first + 1..=last).map(way);
            ways.chain(errands[first + 1..last].iter().map(|errand| errand.stay)).fold(0u32, u32::saturating_add)
        };
        // Predecessors done by other agents may end later, close to this errand.
        let is_alone = lag.after.iter().all(|place| place.agent == agent && place.errand < last);
        let own = is_alone.then(|| lag.after.iter().map(|place| steps_from(place.errand)).min()).flatten();
        // An own earlier errand that comes after all predecessors of the lag begins no sooner than they are done.
        let afters = &problem.afters[agent];
        let waits = |index: &usize| lag.after.iter().all(|place| afters[*index].contains(place));
        let behind = (0..last).filter(waits).map(|index| steps_from(index).saturating_add(errands[index].work())).max();
        let is_split = errands[last].splits.is_some();
        !is_split && own.into_iter().chain(behind).any(|steps| steps > lag.most)
    };
    problem.lags.iter().find(is_far).map(|lag| lag.of)
}
