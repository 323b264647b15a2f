//! Agents that step aside while they wait.
//!
//! An agent that is waiting, yielding or finished stays where its last errand ended. If it blocks another agent's stop
//! there, no order of the list yields a plan.
//!
//! Method: each agent that would stay near a cell that others need gets an extra errand of zero steps at the nearest
//! cell that nobody else needs; at the end, it gets another one to come back. The same holds for an agent that would be
//! done too soon for a time lag where it stands: it stays when it comes back. Before a merge, an agent goes to the stop
//! only once the other one has finished its errands near there. With traces, an agent that contaminates a stop comes
//! there after those whom it would contaminate. Where lists with these errands yield no plan either, random agents get
//! a random first errand, and the list is random. Guaranteed: courses with such errands do all original errands too.

use super::bound::{self, AssayBounds};
use super::replay::cut_where_gone;
use super::route::StopDistances;
use super::{AgentCourse, AssayPlan, AssayProblem, Errand, ErrandPlace, Traces, lags, lists};
use crate::plan::electrode_array::board::BoardObjective;
use crate::plan::electrode_array::board::CellIndex;
use crate::plan::electrode_array::fast::Distances;
use crate::plan::search::Meter;
use crate::random::SplitMix64;
use std::collections::VecDeque;

/// Most errands of an assay in which agents step aside: all pairs of errands are considered.
const MAX_ERRANDS: usize = 2_000;

/// 1/N of the remaining budget for lists with extra errands, without and with a return at the end; the joint search
/// gets the rest.
const SHARE: u64 = 3;

/// Most agents for which random lists are tried.
const MAX_AGENTS_OF_RANDOM_LISTS: usize = 64;

/// Random lists tried while there is no plan.
const MAX_RANDOM_LISTS: usize = 10_000;

/// Random lists tried once there is a plan.
const MORE_RANDOM_LISTS: usize = 40;

/// Budget steps charged per errand for each random list, since its bounds are computed anew.
const STEPS_PER_ERRAND: u64 = 20;

/// One agent in N gets a random first errand.
const DETOURS_IN: usize = 3;

/// Random seed.
const SEED: u64 = 1;

/// Courses by lists in which agents step aside; `None` if no agent would be in the way or these lists yield no plan.
pub(super) fn by_lists(
    problem: &AssayProblem,
    objective: BoardObjective,
    least: &AssayBounds,
    distances: &mut Distances,
    meter: &mut Meter,
) -> Option<Vec<AgentCourse>> {
    if problem.errands.iter().map(Vec::len).sum::<usize>() > MAX_ERRANDS {
        return None;
    }
    // Leaving at the end and coming back takes more moves than most plans need.
    [false, true].into_iter().find_map(|come_back| {
        let detoured = Some(Detours::of(problem, come_back)?.inserted(problem)).filter(can_be_ordered)?;
        let ahead = StopDistances::new(&detoured, distances, meter);
        let bounds = AssayBounds { costs: least.costs, ..bound::least(&detoured, &ahead) };
        let share = meter.left().steps / SHARE;
        let courses = meter.share(share, |meter| lags::by_lists(&detoured, &ahead, objective, &bounds, meter))?;
        as_replayed(problem, courses)
    })
}

/// Courses by random lists in which some agents first move to a random cell, out of the way of agents that come before
/// them.
pub(super) fn by_random_lists(
    problem: &AssayProblem,
    objective: BoardObjective,
    least: &AssayBounds,
    distances: &mut Distances,
    meter: &mut Meter,
) -> Option<Vec<AgentCourse>> {
    let board = &problem.instance.board;
    let is_there = |agent: &usize| !problem.enters[*agent] && problem.parents[*agent].is_none();
    let movable: Vec<usize> = (0..problem.errands.len()).filter(is_there).collect();
    let free: Vec<CellIndex> = (0..board.cells() as CellIndex).filter(|cell| !board.is_blocked(*cell)).collect();
    if movable.is_empty() || problem.errands.len() > MAX_AGENTS_OF_RANDOM_LISTS {
        return None;
    }
    let mut random = SplitMix64::new(SEED);
    let mut below = |count: usize| lists::below(&mut random, count);
    let mut best: Option<Vec<AgentCourse>> = None;
    let mut tries = MAX_RANDOM_LISTS;
    while tries > 0 && meter.left().steps > 0 {
        tries -= 1;
        meter.charge(STEPS_PER_ERRAND * problem.errands.iter().map(Vec::len).sum::<usize>() as u64);
        let mut detoured = problem.clone();
        for agent in movable.iter().filter(|_| below(DETOURS_IN) == 0).collect::<Vec<_>>() {
            insert(&mut detoured, ErrandPlace { agent: *agent, errand: 0 }, free[below(free.len())]);
            move_places(&mut detoured, |place| place.errand += usize::from(place.agent == *agent));
        }
        let ahead = StopDistances::new(&detoured, distances, meter);
        let bounds = AssayBounds { costs: least.costs, ..bound::least(&detoured, &ahead) };
        let seed = below(usize::MAX) as u64;
        let found = lists::by_random_list(&detoured, &ahead, objective, &bounds, seed, meter);
        let Some(courses) = found.and_then(|courses| as_replayed(problem, courses)) else { continue };
        tries = tries.min(MORE_RANDOM_LISTS);
        let key = |courses: &[AgentCourse]| AssayPlan::costs(courses).key(objective);
        if best.as_ref().is_none_or(|best| key(&courses) < key(best)) {
            best = Some(courses);
        }
    }
    best
}

/// Courses with extra errands as a replay without these sees them: an agent that leaves the board may reach its exit
/// too soon, and an errand may be done on the way. `None` if lags or traces are violated then.
pub(super) fn as_replayed(problem: &AssayProblem, mut courses: Vec<AgentCourse>) -> Option<Vec<AgentCourse>> {
    cut_where_gone(problem, &mut courses);
    let is_clean = problem.traces.as_ref().is_none_or(|traces| traces.harmed(problem, &courses).is_none());
    (is_clean && lags::are_kept(problem, &courses)).then_some(courses)
}

/// Updates the errand indices of predecessors and lags after errands were inserted.
fn move_places(problem: &mut AssayProblem, moved: impl Fn(&mut ErrandPlace)) {
    problem.afters.iter_mut().flatten().flatten().for_each(&moved);
    for lag in &mut problem.lags {
        moved(&mut lag.of);
        lag.after.iter_mut().for_each(&moved);
    }
}

/// The cells where agents step aside.
struct Detours {
    /// By agent and errand: the cell where it waits for the errand, if it would otherwise wait in the way of others.
    before: Vec<Vec<Option<CellIndex>>>,
    /// By agent: the cell where it goes after its last errand, before it comes back.
    after: Vec<Option<CellIndex>>,
}

/// Agents that need a cell, since they have errands near it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum WantedBy {
    Nobody,
    One(usize),
    Several,
}

impl Detours {
    /// `None` if no agent would be in the way.
    fn of(problem: &AssayProblem, come_back: bool) -> Option<Detours> {
        let mut wanted = wanted(problem);
        let mut before: Vec<Vec<Option<CellIndex>>> =
            problem.errands.iter().map(|errands| vec![None; errands.len()]).collect();
        let mut after = vec![None; problem.errands.len()];
        let awaited = problem.awaited();
        for (agent, errands) in problem.errands.iter().enumerate() {
            for (index, errand) in errands.iter().enumerate() {
                let place = ErrandPlace { agent, errand: index };
                let waits = problem.afters[agent].get(index).into_iter().flatten().any(|after| after.agent != agent)
                    || met_later(problem, place).is_some();
                let pauses = index.checked_sub(1).is_some_and(|errand| awaited.contains(&(agent, errand)));
                let is_too_soon = begins_too_soon(problem, place);
                let is_there = index > 0 || (!problem.enters[agent] && problem.parents[agent].is_none());
                if !(waits || pauses || is_too_soon) || !is_there || errand.splits.is_some() {
                    continue;
                }
                let from = index.checked_sub(1).map_or(problem.instance.agents[agent].start, |last| errands[last].stop);
                before[agent][index] = detour(problem, &mut wanted, agent, from, is_too_soon);
            }
            let has_operation = problem.operations[agent].iter().any(Option::is_some);
            if let Some(last) = errands.last().filter(|_| come_back && has_operation && !problem.is_gone[agent]) {
                after[agent] = detour(problem, &mut wanted, agent, last.stop, false);
            }
        }
        let is_any = before.iter().flatten().chain(&after).any(Option::is_some);
        is_any.then_some(Detours { before, after })
    }

    /// The problem with these errands inserted.
    fn inserted<'a>(&self, problem: &AssayProblem<'a>) -> AssayProblem<'a> {
        let mut detoured = problem.clone();
        for place in problem.places() {
            detoured.afters[place.agent][place.errand].extend(met_later(problem, place));
            if let Some(traces) = &problem.traces {
                // A child is on the board from the split on, so the parent must wait.
                let held = problem.split_of(place.agent).filter(|_| place.errand == 0).unwrap_or(place);
                detoured.afters[held.agent][held.errand].extend(harmed_later(problem, traces, place));
            }
        }
        for agent in 0..problem.errands.len() {
            // From the last one on, so that earlier indices stay valid.
            for (index, cell) in self.before[agent].iter().enumerate().rev() {
                cell.iter().for_each(|cell| insert(&mut detoured, ErrandPlace { agent, errand: index }, *cell));
            }
            if let (Some(cell), Some(last)) = (self.after[agent], problem.errands[agent].last()) {
                for cell in [cell, last.stop] {
                    let end = ErrandPlace { agent, errand: detoured.errands[agent].len() };
                    insert(&mut detoured, end, cell);
                }
                if let Some(afters) = detoured.afters[agent].last_mut() {
                    *afters = others_near(problem, agent, last.stop);
                }
            }
        }
        let moved = |place: &mut ErrandPlace| {
            place.errand += self.before[place.agent][..=place.errand].iter().flatten().count();
        };
        move_places(&mut detoured, moved);
        detoured
    }
}

impl WantedBy {
    /// Whether no agent other than `agent` needs the cell.
    fn no_other_than(self, agent: usize) -> bool {
        self == WantedBy::Nobody || self == WantedBy::One(agent)
    }
}

/// Gives an agent an extra errand of zero steps before another one.
fn insert(problem: &mut AssayProblem, ErrandPlace { agent, errand: index }: ErrandPlace, stop: CellIndex) {
    let errand = Errand { stop, stay: 0, meets: None, mixes: None, splits: None };
    problem.errands[agent].insert(index, errand);
    problem.operations[agent].insert(index, None);
    problem.afters[agent].insert(index, Vec::new());
    for instants in std::iter::once(&mut problem.releases).chain(&mut problem.relaxed_schedules) {
        if let Some(own) = instants.get_mut(agent) {
            own.insert(index, 0);
        }
    }
    if let Some(contents) = problem.traces.as_mut().map(|traces| &mut traces.contents[agent]) {
        contents.insert(index, contents[index]);
    }
}

/// Whether the order of the errands has no cycle.
fn can_be_ordered(problem: &AssayProblem) -> bool {
    let mut done = vec![0; problem.errands.len()];
    let is_due = |done: &[usize], agent: usize| {
        let afters = problem.afters[agent].get(done[agent]).into_iter().flatten().copied();
        problem.split_of(agent).into_iter().chain(afters).all(|before| before.errand < done[before.agent])
    };
    let mut is_stuck = false;
    while !std::mem::replace(&mut is_stuck, true) {
        for agent in 0..problem.errands.len() {
            while let Some(errand) = problem.errands[agent].get(done[agent]).filter(|_| is_due(&done, agent)) {
                if let Some(other) = errand.meets {
                    let theirs = problem.errands[other].get(done[other]);
                    if theirs.is_none_or(|theirs| theirs.meets != Some(agent)) || !is_due(&done, other) {
                        break;
                    }
                    done[other] += 1;
                }
                done[agent] += 1;
                is_stuck = false;
            }
        }
    }
    problem.errands.iter().zip(&done).all(|(errands, done)| errands.len() == *done)
}

/// The last errand of the other agent near the stop of a merge, before that merge. Until it is done, an agent that
/// waits at the stop blocks the other one from it.
fn met_later(problem: &AssayProblem, place: ErrandPlace) -> Option<ErrandPlace> {
    let (instance, stop) = (problem.instance, problem.errands[place.agent][place.errand].stop);
    let ErrandPlace { agent, errand: met } = problem.partner(place)?;
    let is_near =
        |errand: &usize| instance.board.apart(problem.errands[agent][*errand].stop, stop) < instance.separation;
    Some(ErrandPlace { agent, errand: (0..met).rev().find(is_near)? })
}

/// The errands of others at the stop of an errand that must be done before it, since its agent leaves a trace that
/// contaminates them.
fn harmed_later(problem: &AssayProblem, traces: &Traces, place: ErrandPlace) -> Vec<ErrandPlace> {
    if traces.washes.contains(&true) {
        return Vec::new();
    }
    let errand = problem.errands[place.agent][place.errand];
    let left = traces.contents[place.agent][place.errand];
    let is_harmed = |other: &ErrandPlace| {
        let own = problem.errands[other.agent][other.errand];
        own.stop == errand.stop
            && errand.meets != Some(other.agent)
            && traces.harms[left][traces.contents[other.agent][other.errand]]
    };
    others(problem, place.agent).filter(is_harmed).collect()
}

/// The errands of others near a stop of an agent.
fn others_near(problem: &AssayProblem, agent: usize, stop: CellIndex) -> Vec<ErrandPlace> {
    let is_near = |place: &ErrandPlace| {
        let own = problem.errands[place.agent][place.errand].stop;
        problem.instance.board.apart(own, stop) < problem.instance.separation
    };
    others(problem, agent).filter(is_near).collect()
}

/// All errands of other agents.
fn others(problem: &AssayProblem, agent: usize) -> impl Iterator<Item = ErrandPlace> {
    problem.places().filter(move |place| place.agent != agent)
}

/// Whether an errand that others must follow within a time limit begins at once where its agent stands, so that the
/// agent can delay it only by leaving.
fn begins_too_soon(problem: &AssayProblem, place: ErrandPlace) -> bool {
    let stays = problem.errands[place.agent][place.errand].stay > 0;
    stays && problem.lags.iter().any(|lag| lag.after.contains(&place)) && problem.held_back_by(place, 1).is_none()
}

/// The cell to which an agent steps aside from `from`, if it would be in the way there or `leaves` in any case, and
/// there is room. From then on it counts as needed by that agent.
fn detour(
    problem: &AssayProblem,
    wanted: &mut [WantedBy],
    agent: usize,
    from: CellIndex,
    leaves: bool,
) -> Option<CellIndex> {
    let cell = nearest_unwanted(problem, wanted, agent, from, leaves).filter(|cell| *cell != from)?;
    want(problem, wanted, agent, cell);
    Some(cell)
}

/// By cell: the agents that start, enter, stay or are mixed near it.
fn wanted(problem: &AssayProblem) -> Vec<WantedBy> {
    let mut wanted = vec![WantedBy::Nobody; problem.instance.board.cells()];
    for (agent, errands) in problem.errands.iter().enumerate() {
        let around = errands.iter().filter_map(|errand| errand.mixes).flat_map(|around| &problem.loops[around]);
        let stops = errands.iter().map(|errand| &errand.stop);
        for cell in stops.chain(around).chain(std::iter::once(&problem.instance.agents[agent].start)) {
            want(problem, &mut wanted, agent, *cell);
        }
    }
    wanted
}

/// Records that an agent needs the cells near a cell.
fn want(problem: &AssayProblem, wanted: &mut [WantedBy], agent: usize, cell: CellIndex) {
    for near in problem.instance.board.around(cell, problem.instance.separation) {
        let by = &mut wanted[near as usize];
        *by = if by.no_other_than(agent) { WantedBy::One(agent) } else { WantedBy::Several };
    }
}

/// The nearest cell, from one on, that no other agent needs; not that one itself if the agent leaves it.
fn nearest_unwanted(
    problem: &AssayProblem,
    wanted: &[WantedBy],
    agent: usize,
    from: CellIndex,
    leaves: bool,
) -> Option<CellIndex> {
    let board = &problem.instance.board;
    let mut is_seen = vec![false; board.cells()];
    let mut queue = VecDeque::from([from]);
    is_seen[from as usize] = true;
    while let Some(cell) = queue.pop_front() {
        if wanted[cell as usize].no_other_than(agent) && !(leaves && cell == from) {
            return Some(cell);
        }
        for next in board.neighbours(cell) {
            if !std::mem::replace(&mut is_seen[next as usize], true) {
                queue.push_back(next);
            }
        }
    }
    None
}
