//! Plans of assays: each part does its errands in order, and waits only for the parts that it meets or whose errands
//! must come before.
//!
//! Problem: agents on a grid that keep their separation ([`super::board`]). Each visits its stops in order, stays at
//! some of them, and meets other agents to merge with them; one of the two is gone from then on. Some errands wait for
//! errands of other agents.
//!
//! Method: list scheduling. Agents take their turns in the order of a list. In its turn an agent's course is planned up
//! to the next agent that it meets and that has no course yet (`route`), around the courses of the others (`bookings`);
//! an agent that finds no course moves to the front of the next list. Besides the order of the list there is the order
//! of time, in which no agent enters the board or goes to a meeting long before it is needed there (`turns`); in both,
//! agents may keep off the places of others (`lanes`). Then local search: lists with agents moved are kept if they are
//! no worse (`lists`). Where no list yields a plan, agents that would block others step aside (`detours`); where that
//! does not help, or where agents leave traces, droplets are replanned one by one and negotiate about cells
//! (`negotiated`). Then random lists are tried. Where no plan is found, or the plan may have too many steps, a few
//! agents are planned jointly (`joint`).
//!
//! Guaranteed: a plan is legal; `bounds` hold for every plan; the same input and budget give the same plan. For few
//! agents, while the budget lasts, a plan is found where there is one, with the fewest steps or the least sum of costs.
//! Otherwise neither is guaranteed. Cost: one step of the budget is one expanded node of the search for one course, or
//! one joint position of several agents; with many agents, their courses are charged too.

mod bookings;
mod bound;
mod channels;
mod detours;
mod joint;
mod lags;
mod lanes;
mod list_planner;
mod lists;
mod negotiated;
mod replay;
mod route;
mod traces;
mod turn_queue;
mod turns;

use super::board::{BoardCosts, BoardObjective, BoardPlanProgress, CellIndex, Instance, NoBoardPlan};
use super::fast;
use crate::plan::search::{Meter, SearchAnswer};
pub use bound::{LoopRoom, families, steps_between};
pub use channels::are_kept_by_courses;
use joint::JointTerms;
pub use lags::are_kept;
pub use replay::{cut_where_gone, done_by};
use rustc_hash::FxHashSet;
pub use traces::Traces;

/// One errand of an agent.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Errand {
    /// The cell where it is done.
    pub stop: CellIndex,
    /// Steps for which the agent stays there.
    pub stay: u32,
    /// The agent with which it merges there; then `stay` is 0 for both.
    pub meets: Option<usize>,
    /// The mixing loop, an index into [`AssayProblem::loops`], that the agent follows for `stay` steps: whole rounds
    /// that begin and end at the stop.
    pub mixes: Option<usize>,
    /// The agent that splits off in the step in which this one moves to the stop.
    pub splits: Option<SplitErrand>,
}

impl Errand {
    /// Steps from the beginning of the errand until it is done.
    fn work(&self) -> u32 {
        if self.splits.is_some() { 1 } else { self.stay }
    }
}

/// A split: in one step the parent moves from `from` to its stop, and the child appears at its start on the opposite
/// side.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct SplitErrand {
    /// The parent's cell before that step: the stop of its previous errand.
    pub from: CellIndex,
    /// The agent that splits off.
    pub child: usize,
}

/// An errand, by its agent and its index among that agent's errands.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct ErrandPlace {
    pub agent: usize,
    pub errand: usize,
}

/// Time limit of an errand, counted from the end of other errands.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ErrandLag {
    pub of: ErrandPlace,
    /// The errands that it is counted from; at least one.
    pub after: Vec<ErrandPlace>,
    /// Most steps from the instant at which the last of these is done to the instant at which the errand begins.
    pub most: u32,
}

/// The errands of all agents.
#[derive(Debug, Clone)]
pub struct AssayProblem<'a> {
    /// The agents with the stops of their errands, and no merges. Several agents that enter the board may have the same
    /// start.
    pub instance: &'a Instance,
    /// For each agent, whether it enters the board at an instant that the plan chooses; it then appears at its start,
    /// where its first errand is a stay.
    pub enters: Vec<bool>,
    /// For each agent its parent, if it enters by a split. It then appears at its start, which is the stop of its first
    /// errand.
    pub parents: Vec<Option<usize>>,
    /// Cells of each mixing loop, from its corner on.
    pub loops: Vec<Vec<CellIndex>>,
    /// For each agent its errands, at least one. Where two agents meet, the one with further errands remains; if
    /// neither has any, the one with the smaller index.
    pub errands: Vec<Vec<Errand>>,
    /// By agent and errand: the index of its operation; `None` if it belongs to none.
    pub operations: Vec<Vec<Option<usize>>>,
    /// By agent and errand: errands of other agents that must be done before it begins, that is, before its agent
    /// stays, is mixed or split, enters, leaves, or meets another one that is there already.
    pub afters: Vec<Vec<Vec<ErrandPlace>>>,
    /// Time limits between errands.
    pub lags: Vec<ErrandLag>,
    /// By agent and errand: its release, the first instant at which it may begin; empty if there are no releases. A
    /// replay of the courses does not know the releases, so the agent must not reach the stop earlier, unless its work
    /// before lasts until then.
    pub releases: Vec<Vec<u32>>,
    /// Schedules that ignore conflicts between agents: by agent and errand, the instant at which it begins.
    pub relaxed_schedules: Vec<Vec<Vec<u32>>>,
    /// For each agent, whether it is gone after its last errand: it merges into the agent that it meets there, or
    /// leaves the board.
    pub is_gone: Vec<bool>,
    /// Traces of the agents' contents; `None` if no trace contaminates another agent.
    pub traces: Option<Traces>,
}

/// Cells of one agent over time.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct AgentCourse {
    /// The first instant at which it is on the board.
    pub since: u32,
    /// One cell per instant, from `since` until its last errand is done; afterwards it stays there or is gone. Empty
    /// until it is planned.
    pub cells: Vec<CellIndex>,
}

impl AgentCourse {
    /// Its cell at an instant: the first one before it enters, the last one after its end; `None` if it is not planned
    /// yet.
    pub fn at(&self, instant: u32) -> Option<CellIndex> {
        self.cells.get(instant.saturating_sub(self.since) as usize).or(self.cells.last()).copied()
    }

    /// The instant after its last one.
    pub fn until(&self) -> u32 {
        self.since + self.cells.len() as u32
    }

    /// Cuts it after an instant, but not before its last move.
    pub fn end_at(&mut self, instant: u32) {
        let last = instant.max(self.last_arrival()).max(self.since);
        self.cells.truncate((last + 1 - self.since) as usize);
    }

    /// The instant of its last move.
    pub fn last_arrival(&self) -> u32 {
        let last = self.cells.last();
        let before = self.cells.iter().rposition(|cell| Some(cell) != last);
        before.map_or(0, |before| self.since + before as u32 + 1)
    }
}

/// The courses of all agents.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct AssayPlan {
    pub courses: Vec<AgentCourse>,
    /// Lower bounds on every plan.
    pub bounds: BoardCosts,
}

impl AssayProblem<'_> {
    /// The errand to hold back, and until when, so that errand `place` begins no earlier than `until`. It is that
    /// errand itself or, if its agent is at the stop already, its previous work there. `None` if the agent is there
    /// from the start.
    fn held_back_by(&self, place: ErrandPlace, until: u32) -> Option<(ErrandPlace, u32)> {
        let (mut place, mut until) = (place, until);
        loop {
            let errand = self.errands[place.agent][place.errand];
            if errand.mixes.is_some() || errand.splits.is_some() {
                return Some((place, until));
            }
            place = match (place.errand.checked_sub(1), self.parents[place.agent]) {
                (Some(before), _) if self.errands[place.agent][before].stop == errand.stop => {
                    ErrandPlace { errand: before, ..place }
                }
                (None, Some(_)) => self.split_of(place.agent)?,
                (None, None) if !self.enters[place.agent] && self.instance.agents[place.agent].start == errand.stop => {
                    return None;
                }
                _ => return Some((place, until)),
            };
            until = until.saturating_sub(self.errands[place.agent][place.errand].work());
        }
    }

    /// All errands, by agent.
    fn places(&self) -> impl Iterator<Item = ErrandPlace> + use<'_> {
        let agents = self.errands.iter().enumerate();
        agents.flat_map(|(agent, own)| (0..own.len()).map(move |errand| ErrandPlace { agent, errand }))
    }

    /// The errand of the other agent in a meeting; `None` if the errand is no meeting.
    fn partner(&self, ErrandPlace { agent, errand }: ErrandPlace) -> Option<ErrandPlace> {
        let other = self.errands[agent][errand].meets?;
        let nth = self.errands[agent][..errand].iter().filter(|before| before.meets == Some(other)).count();
        let theirs = self.errands[other].iter().enumerate().filter(|(_, errand)| errand.meets == Some(agent));
        Some(ErrandPlace { agent: other, errand: theirs.map(|(place, _)| place).nth(nth)? })
    }

    /// The errand of the parent in which an agent splits off; `None` if it enters otherwise.
    fn split_of(&self, agent: usize) -> Option<ErrandPlace> {
        let parent = self.parents[agent]?;
        let is_split = |errand: &Errand| errand.splits.is_some_and(|split| split.child == agent);
        Some(ErrandPlace { agent: parent, errand: self.errands[parent].iter().position(is_split)? })
    }

    /// The release of an errand; 0 if it has none.
    fn release(&self, agent: usize, errand: usize) -> u32 {
        self.releases.get(agent).and_then(|own| own.get(errand)).copied().unwrap_or(0)
    }

    /// The errands, as (agent, errand), that errands of other agents wait for.
    fn awaited(&self) -> FxHashSet<(usize, usize)> {
        let by_agent = self.afters.iter().enumerate();
        let afters = by_agent.flat_map(|(agent, own)| own.iter().flatten().map(move |after| (agent, after)));
        afters.filter(|(agent, after)| after.agent != *agent).map(|(_, after)| (after.agent, after.errand)).collect()
    }

    /// Releases of 0 for all errands.
    fn unheld(&self) -> Vec<Vec<u32>> {
        self.errands.iter().map(|errands| vec![0; errands.len()]).collect()
    }

    /// Most steps from the end of the last errand that a lag counts from to the end of the limited errand.
    fn most_to_end(&self, lag: &ErrandLag) -> u32 {
        lag.most.saturating_add(self.errands[lag.of.agent][lag.of.errand].work())
    }
}

impl AssayPlan {
    /// The instant at which the last errand is done, and the sum of the instants of the last arrivals.
    pub fn costs(courses: &[AgentCourse]) -> BoardCosts {
        BoardCosts {
            makespan: courses.iter().map(|course| u64::from(course.until()) - 1).max().unwrap_or(0),
            sum_of_costs: courses.iter().map(|course| u64::from(course.last_arrival())).sum(),
        }
    }

    /// Whether courses meet the lower bound of the objective.
    fn is_least(courses: &[AgentCourse], objective: BoardObjective, least: BoardCosts) -> bool {
        AssayPlan::costs(courses).key(objective).0 <= least.key(objective).0
    }
}

/// Why an assay has no plan.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum NoAssayPlan {
    /// An agent cannot reach its stops, whatever the others do.
    Alone(NoBoardPlan),
    /// This agent cannot get from one of its errands to another in time, even alone; `operation` is that of the later
    /// errand, if it has one.
    TooLate { agent: usize, operation: Option<usize> },
    /// The loop in which this agent is to be mixed leaves the board.
    LoopOffBoard { agent: usize },
    /// The agents block one another's operations in every order; by agent, the cells that it reached.
    Excluded { reached: Vec<Vec<CellIndex>> },
}

/// Lower bounds on every plan of an assay, or an immediate proof that there is none.
pub fn bounds(problem: &AssayProblem, meter: &mut Meter) -> Result<BoardCosts, NoAssayPlan> {
    let mut distances = fast::Distances::of(&problem.instance.board);
    Ok(distances_and_bounds(problem, &mut distances, meter)?.1.costs)
}

/// The distances to all stops, with the lower bounds that follow from them.
fn distances_and_bounds(
    problem: &AssayProblem,
    distances: &mut fast::Distances,
    meter: &mut Meter,
) -> Result<(route::StopDistances, bound::AssayBounds), NoAssayPlan> {
    fast::bounds(problem.instance).map_err(NoAssayPlan::Alone)?;
    let ahead = route::StopDistances::new(problem, distances, meter);
    let least = bound::least(problem, &ahead);
    match lags::hopeless(problem, &ahead) {
        Some(ErrandPlace { agent, errand }) => {
            let operation = problem.operations.get(agent).and_then(|own| *own.get(errand)?);
            Err(NoAssayPlan::TooLate { agent, operation })
        }
        None => Ok((ahead, least)),
    }
}

/// 1/N of the budget is for lists if agents leave traces: negotiation mostly yields better plans then.
const LISTS_WITH_TRACES_SHARE: u64 = 3;

/// 1/N of the remaining budget is for random lists, where the joint search gets the rest.
const RANDOM_LISTS_SHARE: u64 = 3;

/// 1/N of the remaining budget is for negotiation: where the joint search gets the rest, and elsewhere.
const NEGOTIATED_SHARE_OF_FEW: u64 = 16;
const NEGOTIATED_SHARE: u64 = 3;

/// 1/N of the remaining budget is for the joint search that ignores traces.
const WITHOUT_TRACES_SHARE: u64 = 3;

/// 1/N of the remaining budget is for the least sum of costs by joint search.
const SUM_SHARE: u64 = 2;

/// 1/N of the share for negotiation is for lists that ignore traces; negotiation begins with their order.
const LISTS_WITHOUT_TRACES_SHARE: u64 = 16;

/// Search effort.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum AssayEffort {
    /// By lists; where these do not end in the fewest steps, by joint search.
    Whole,
    Lists,
    /// By joint search, for fewer steps than this.
    Below(u64),
}

/// Plans an assay. Where the search gave up, or no plan has as few steps as asked for, it returns lower bounds on every
/// plan.
pub fn solve(
    problem: &AssayProblem,
    objective: BoardObjective,
    effort: AssayEffort,
    meter: &mut Meter,
) -> SearchAnswer<AssayPlan, NoAssayPlan, BoardCosts> {
    let mut distances = fast::Distances::of(&problem.instance.board);
    let (ahead, least) = match distances_and_bounds(problem, &mut distances, meter) {
        Ok(known) => known,
        Err(why) => return SearchAnswer::Impossible(why),
    };
    let by_lists = match effort {
        AssayEffort::Below(_) => None,
        AssayEffort::Whole | AssayEffort::Lists => {
            // The lists ignore shared channels; courses that break their rule are dropped here.
            let courses = in_order(problem, &ahead, objective, &least, &mut distances, meter);
            courses.filter(|courses| are_kept_by_courses(problem, courses))
        }
    };
    if effort == AssayEffort::Lists {
        return found(by_lists, least.costs);
    }
    let (known, bounds) = match (objective, effort) {
        (BoardObjective::SumOfCosts, AssayEffort::Whole) => {
            match least_sum(problem, &ahead, by_lists, least.costs, meter) {
                Ok(known) => known,
                Err(why) => return SearchAnswer::Impossible(why),
            }
        }
        (BoardObjective::Makespan, _) | (BoardObjective::SumOfCosts, AssayEffort::Lists | AssayEffort::Below(_)) => {
            (by_lists, least.costs)
        }
    };
    match &known {
        Some(courses) if AssayPlan::is_least(courses, objective, bounds) => found(known, bounds),
        Some(_) | None => fewer_steps(problem, &ahead, known, bounds, objective, effort, meter),
    }
}

/// The best known courses, if any, and lower bounds on every plan.
type KnownCourses = (Option<Vec<AgentCourse>>, BoardCosts);

/// Minimises the sum of costs of a small assay by joint search, and raises the bound accordingly; where the search
/// gives up, returns the known courses.
fn least_sum(
    problem: &AssayProblem,
    ahead: &route::StopDistances,
    known: Option<Vec<AgentCourse>>,
    mut bounds: BoardCosts,
    meter: &mut Meter,
) -> Result<KnownCourses, NoAssayPlan> {
    let objective = BoardObjective::SumOfCosts;
    if known.as_ref().is_some_and(|courses| AssayPlan::is_least(courses, objective, bounds)) {
        return Ok((known, bounds));
    }
    let (share, terms) = (meter.left().steps / SUM_SHARE, JointTerms { objective, limit: u32::MAX });
    match meter.share(share, |meter| joint::least(problem, ahead, terms, meter)) {
        SearchAnswer::Found(courses) => {
            bounds.sum_of_costs = AssayPlan::costs(&courses).sum_of_costs;
            Ok((better(objective, known, courses), bounds))
        }
        SearchAnswer::Impossible(reached) => Err(NoAssayPlan::Excluded { reached }),
        SearchAnswer::GaveUp(sum) => {
            bounds.sum_of_costs = bounds.sum_of_costs.max(u64::from(sum));
            Ok((known, bounds))
        }
    }
}

/// The better of the known courses and new ones.
fn better(
    objective: BoardObjective,
    known: Option<Vec<AgentCourse>>,
    courses: Vec<AgentCourse>,
) -> Option<Vec<AgentCourse>> {
    known.into_iter().chain([courses]).min_by_key(|courses| AssayPlan::costs(courses).key(objective))
}

/// Minimises the number of steps by joint search, below that of the known courses. If sums are minimised, the result
/// counts only if its sum is smaller.
fn fewer_steps(
    problem: &AssayProblem,
    ahead: &route::StopDistances,
    known: Option<Vec<AgentCourse>>,
    bounds: BoardCosts,
    objective: BoardObjective,
    effort: AssayEffort,
    meter: &mut Meter,
) -> SearchAnswer<AssayPlan, NoAssayPlan, BoardCosts> {
    let steps = known.as_ref().map(|courses| AssayPlan::costs(courses).makespan);
    if steps == Some(bounds.makespan) {
        return found(known, bounds);
    }
    let begin = |courses: &Vec<AgentCourse>| BoardPlanProgress::begin(objective, AssayPlan::costs(courses), bounds);
    let _progress = known.as_ref().map(begin);
    // Only plans of fewer steps than the known one matter.
    let below = if let AssayEffort::Below(steps) = effort { Some(steps) } else { steps };
    let limit = below.and_then(|steps| u32::try_from(steps.checked_sub(1)?).ok()).unwrap_or(u32::MAX);
    let raised = |makespan: u64| BoardCosts { makespan: makespan.max(bounds.makespan), ..bounds };
    match fewest_steps(problem, ahead, limit, meter) {
        SearchAnswer::Found(courses) => {
            let bounds = raised(AssayPlan::costs(&courses).makespan);
            found(better(objective, known, courses), bounds)
        }
        SearchAnswer::Impossible(reached) if below.is_none() => {
            SearchAnswer::Impossible(NoAssayPlan::Excluded { reached })
        }
        SearchAnswer::Impossible(_) => found(known, raised(u64::from(limit) + 1)),
        SearchAnswer::GaveUp(steps) => found(known, raised(u64::from(steps.min(limit.saturating_add(1))))),
    }
}

/// Courses that were planned one after the other, in some order.
fn in_order(
    problem: &AssayProblem,
    ahead: &route::StopDistances,
    objective: BoardObjective,
    least: &bound::AssayBounds,
    distances: &mut fast::Distances,
    meter: &mut Meter,
) -> Option<Vec<AgentCourse>> {
    let steps =
        if problem.traces.is_some() { meter.left().steps / LISTS_WITH_TRACES_SHARE } else { meter.left().steps };
    let listed = meter
        .share(steps, |meter| lags::by_lists(problem, ahead, objective, least, meter))
        .and_then(|courses| detours::as_replayed(problem, courses))
        .or_else(|| detours::by_lists(problem, objective, least, distances, meter));
    // With traces, lists yield long detours, if they yield a plan at all.
    let negotiated = match &listed {
        Some(courses) if problem.traces.is_none() || AssayPlan::is_least(courses, objective, least.costs) => None,
        Some(_) | None => {
            let part = if joint::takes(problem) { NEGOTIATED_SHARE_OF_FEW } else { NEGOTIATED_SHARE };
            let share = meter.left().steps / part;
            // Without traces these lists were tried already.
            let without_traces = problem.traces.as_ref().and_then(|_| {
                let without_traces = AssayProblem { traces: None, ..problem.clone() };
                meter.share(share / LISTS_WITHOUT_TRACES_SHARE, |meter| {
                    lags::by_lists(&without_traces, ahead, objective, least, meter)
                })
            });
            let known: Vec<_> = listed.iter().cloned().chain(without_traces).collect();
            meter.share(share, |meter| negotiated::best(problem, ahead, &known, objective, least, meter))
        }
    };
    let key = |courses: &Vec<AgentCourse>| AssayPlan::costs(courses).key(objective);
    listed.into_iter().chain(negotiated).min_by_key(key).or_else(|| {
        let steps = meter.left().steps;
        let share = if joint::takes(problem) { steps / RANDOM_LISTS_SHARE } else { steps };
        meter.share(share, |meter| detours::by_random_lists(problem, objective, least, distances, meter))
    })
}

/// The courses of fewest steps, by joint search. The search that ignores traces has far fewer states and comes first:
/// if its courses contaminate nobody, they have the fewest steps with traces too; if it has none, there are none with
/// traces.
fn fewest_steps(
    problem: &AssayProblem,
    ahead: &route::StopDistances,
    limit: u32,
    meter: &mut Meter,
) -> SearchAnswer<Vec<AgentCourse>, Vec<Vec<CellIndex>>, u32> {
    let terms = JointTerms { objective: BoardObjective::Makespan, limit };
    if let Some(traces) = &problem.traces {
        let without_traces = AssayProblem { traces: None, ..problem.clone() };
        let share = meter.left().steps / WITHOUT_TRACES_SHARE;
        match meter.share(share, |meter| joint::least(&without_traces, ahead, terms, meter)) {
            SearchAnswer::Found(courses) if traces.harmed(problem, &courses).is_none() => {
                return SearchAnswer::Found(courses);
            }
            SearchAnswer::Impossible(reached) => return SearchAnswer::Impossible(reached),
            SearchAnswer::Found(_) | SearchAnswer::GaveUp(_) => {}
        }
    }
    joint::least(problem, ahead, terms, meter)
}

fn found(courses: Option<Vec<AgentCourse>>, bounds: BoardCosts) -> SearchAnswer<AssayPlan, NoAssayPlan, BoardCosts> {
    match courses {
        Some(courses) => SearchAnswer::Found(AssayPlan { courses, bounds }),
        None => SearchAnswer::GaveUp(bounds),
    }
}
