//! Plans of assays: every part does its errands one after the other, and none waits for a part that it does not meet.
//!
//! Problem: agents on a grid with separation kept ([`super::board`]); each visits its stops in order, stays at some of them, and
//! meets others, with which it merges: one of the two is gone from then on. Some errands wait for those of other agents.
//!
//! Method: list scheduling. The course of one agent after the other, up to the next agent that it meets and that has no course yet (`route`),
//! is planned around the courses of the others (`bookings`); an agent that finds none comes earlier in the next list. Beside the order of the
//! list there is that of time, in which nobody comes before it is of use (`turns`). Then lists with two agents exchanged, as long as they are
//! no worse (`lists`). Where no list leads to a plan, agents that would stay in the way step aside (`aside`); where that does not help, or where
//! they leave traces, droplets take turns and negotiate about cells (`negotiated`); then lists in random order are gone through, and where no plan is found, or it may have too many steps, a few agents are planned all at once (`joint`).
//!
//! Guaranteed: a plan is legal; `bound` holds for every plan; the same input and budget give the same plan. For few agents, while the
//! budget lasts, a plan is found where there is one, with the fewest steps or the least sum of costs. Else neither is guaranteed.
//! Cost: one step of the budget is one expanded node of the search of one course, or one joint position of several agents; of many agents
//! their courses cost some, too.

mod aside;
mod bookings;
mod bound;
mod channels;
mod joint;
mod lags;
mod lists;
mod negotiated;
mod replay;
mod route;
mod traces;
mod turns;

use super::board::{BoardCosts, BoardObjective, CellIndex, HeldBoardPlan, Instance, NoBoardPlan};
use super::fast;
use crate::plan::search::{Meter, SearchAnswer};
pub use bound::{LoopRoom, families, steps_between};
pub use channels::are_kept_by_courses;
use joint::JointTerms;
pub use lags::are_kept;
pub use replay::{cut_where_gone, done_by};
use rustc_hash::FxHashSet;
pub use traces::Traces;

/// One thing that an agent does.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Errand {
    /// Where.
    pub stop: CellIndex,
    /// Steps for which it stays there.
    pub stay: u32,
    /// The agent with which it merges there; both stay for no step.
    pub meets: Option<usize>,
    /// The loop, one of [`AssayProblem::loops`], round which it goes for these steps: whole rounds from the stop to the stop.
    pub mixes: Option<usize>,
    /// What it gives off in the one step in which it comes to the stop.
    pub splits: Option<SplitErrand>,
}

impl Errand {
    /// Steps from its beginning until it is done.
    fn work(&self) -> u32 {
        if self.splits.is_some() { 1 } else { self.stay }
    }
}

/// An agent that comes out of another one: that one is pulled apart at a cell, and in one step goes from there to its stop and the new agent
/// to its start, on the opposite side.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct SplitErrand {
    /// Where the first is before that step: the stop of its errand before.
    pub from: CellIndex,
    /// The agent that comes.
    pub child: usize,
}

/// An errand by its agent and its place among that one's.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct ErrandPlace {
    pub agent: usize,
    pub errand: usize,
}

/// How soon an errand is done after others.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ErrandLag {
    pub of: ErrandPlace,
    /// At least one.
    pub after: Vec<ErrandPlace>,
    /// Most steps from the instant at which the last of those is done to the one at which it begins.
    pub most: u32,
}

/// The errands of all agents.
#[derive(Debug, Clone)]
pub struct AssayProblem<'a> {
    /// The agents with the stops of their errands, and no merges. Agents that come may have one start.
    pub instance: &'a Instance,
    /// For each agent, whether it is nowhere until an instant that the plan chooses. Then it is at its start, where its first errand is a
    /// stay.
    pub comes: Vec<bool>,
    /// For each agent the one that gives it off, if it comes by a split. It is nowhere before, then at its start, which is the stop of
    /// its first errand.
    pub parents: Vec<Option<usize>>,
    /// Cells of mixing loops, from the corner on.
    pub loops: Vec<Vec<CellIndex>>,
    /// For each agent, at least one. Where two meet, the one with further errands, else the one of the smaller index, remains.
    pub errands: Vec<Vec<Errand>>,
    /// By agent and errand: the index of the operation, if it is for one.
    pub operations: Vec<Vec<Option<usize>>>,
    /// By agent and errand: the errands of others that are done before it begins: before its agent stays, is mixed or pulled apart, comes,
    /// leaves, or meets another that is there already.
    pub afters: Vec<Vec<Vec<ErrandPlace>>>,
    /// What must not be done too long after others.
    pub lags: Vec<ErrandLag>,
    /// By agent and errand: the first instant at which it may begin; empty where nothing is held back. Whoever replays the courses does not
    /// know them: unless what comes before lasts until then, the agent comes to the stop no earlier.
    pub releases: Vec<Vec<u32>>,
    /// Schedules on paper, in which nobody is in another's way: by agent and errand the instant at which it begins.
    pub papers: Vec<Vec<Vec<u32>>>,
    /// For each agent, whether it is gone after its last errand: the other one of those that meet there remains, or it leaves the board.
    pub is_gone: Vec<bool>,
    /// What they leave behind, if that does harm to any.
    pub traces: Option<Traces>,
}

/// Where an agent is.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct AgentCourse {
    /// The instant from which on it is there.
    pub since: u32,
    /// Its cell at each instant from that on until its last errand is done; afterwards it stays there, or is gone. Empty before it is planned.
    pub cells: Vec<CellIndex>,
}

impl AgentCourse {
    /// Its cell at an instant; before it is there, the first one, after its end, the last one.
    pub fn at(&self, instant: u32) -> Option<CellIndex> {
        self.cells.get(instant.saturating_sub(self.since) as usize).or(self.cells.last()).copied()
    }

    /// The instant after its last one.
    pub fn until(&self) -> u32 {
        self.since + self.cells.len() as u32
    }

    /// Cuts it after an instant and its last move.
    pub fn end_at(&mut self, instant: u32) {
        let last = instant.max(self.last_arrival()).max(self.since);
        self.cells.truncate((last + 1 - self.since) as usize);
    }

    /// The instant at which it comes to its last cell.
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
    /// The errand that is held back, and until when, so that another one begins no earlier than an instant: that one or, where its agent
    /// is there already, what it does there before. `None` where it is there from the start.
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
                (None, Some(_)) => self.given_off_by(place.agent)?,
                (None, None) if !self.comes[place.agent] && self.instance.agents[place.agent].start == errand.stop => {
                    return None;
                }
                _ => return Some((place, until)),
            };
            until = until.saturating_sub(self.errands[place.agent][place.errand].work());
        }
    }

    /// All errands, agent after agent.
    fn places(&self) -> impl Iterator<Item = ErrandPlace> + use<'_> {
        let agents = self.errands.iter().enumerate();
        agents.flat_map(|(agent, own)| (0..own.len()).map(move |errand| ErrandPlace { agent, errand }))
    }

    /// For an errand in which two meet, that of the other one.
    fn partner(&self, ErrandPlace { agent, errand }: ErrandPlace) -> Option<ErrandPlace> {
        let other = self.errands[agent][errand].meets?;
        let nth = self.errands[agent][..errand].iter().filter(|before| before.meets == Some(other)).count();
        let theirs = self.errands[other].iter().enumerate().filter(|(_, errand)| errand.meets == Some(agent));
        Some(ErrandPlace { agent: other, errand: theirs.map(|(place, _)| place).nth(nth)? })
    }

    /// The errand by which an agent is given off; `None` if it comes otherwise.
    fn given_off_by(&self, agent: usize) -> Option<ErrandPlace> {
        let parent = self.parents[agent]?;
        let gives_off = |errand: &Errand| errand.splits.is_some_and(|split| split.child == agent);
        Some(ErrandPlace { agent: parent, errand: self.errands[parent].iter().position(gives_off)? })
    }

    /// The first instant at which an errand may begin by its release; 0 where it has none.
    fn release(&self, agent: usize, errand: usize) -> u32 {
        self.releases.get(agent).and_then(|own| own.get(errand)).copied().unwrap_or(0)
    }

    /// The errands, by agent and errand, for which errands of others wait.
    fn awaited(&self) -> FxHashSet<(usize, usize)> {
        let by_agent = self.afters.iter().enumerate();
        let afters = by_agent.flat_map(|(agent, own)| own.iter().flatten().map(move |after| (agent, after)));
        afters.filter(|(agent, after)| after.agent != *agent).map(|(_, after)| (after.agent, after.errand)).collect()
    }

    /// Releases that hold nothing back.
    fn unheld(&self) -> Vec<Vec<u32>> {
        self.errands.iter().map(|errands| vec![0; errands.len()]).collect()
    }

    /// Most steps from the end of what a lag counts from to the end of its errand.
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

    /// Whether courses meet the bound of what is minimized.
    fn is_least(courses: &[AgentCourse], objective: BoardObjective, least: BoardCosts) -> bool {
        AssayPlan::costs(courses).key(objective).0 <= least.key(objective).0
    }
}

/// Why an assay has no plan.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum NoAssayPlan {
    /// Agents cannot come to their stops, whatever the others do.
    Alone(NoBoardPlan),
    /// This agent cannot come from one of its errands to another in time, even alone: to that of an operation, if it is for one.
    TooLate { agent: usize, operation: Option<usize> },
    /// The loop round which this agent is to be mixed leaves the board.
    LoopOffBoard { agent: usize },
    /// The agents keep one another from their operations, in every order; by agent, the cells that it came to.
    Excluded { reached: Vec<Vec<CellIndex>> },
}

/// Lower bounds on every plan of an assay, or why it is known at once that there is none.
pub fn bounds(problem: &AssayProblem, meter: &mut Meter) -> Result<BoardCosts, NoAssayPlan> {
    let mut distances = fast::Distances::of(&problem.instance.board);
    Ok(looked_ahead(problem, &mut distances, meter)?.1.costs)
}

/// The distances to all stops, with the bounds that follow from them.
fn looked_ahead(
    problem: &AssayProblem,
    distances: &mut fast::Distances,
    meter: &mut Meter,
) -> Result<(route::Ahead, bound::AssayBounds), NoAssayPlan> {
    fast::bounds(problem.instance).map_err(NoAssayPlan::Alone)?;
    let ahead = route::Ahead::new(problem, distances, meter);
    let least = bound::least(problem, &ahead);
    match lags::hopeless(problem, &ahead) {
        Some(ErrandPlace { agent, errand }) => {
            let operation = problem.operations.get(agent).and_then(|own| *own.get(errand)?);
            Err(NoAssayPlan::TooLate { agent, operation })
        }
        None => Ok((ahead, least)),
    }
}

/// One part in this many of the remaining budget for lists in random order, where the search of all positions has the rest.
const CHANCE_SHARE: u64 = 3;

/// One part in this many of the remaining budget for droplets that negotiate, where the search of all positions has the rest, and elsewhere.
const NEGOTIATED_SHARE_OF_FEW: u64 = 16;
const NEGOTIATED_SHARE: u64 = 3;

/// One part in this many of the remaining budget for the search without regard to traces.
const CAREFREE_SHARE: u64 = 3;

/// One part in this many of the remaining budget for the least sum of costs by all positions.
const SUM_SHARE: u64 = 2;

/// One part in this many of the share of droplets that negotiate for lists without regard to traces, whose order they begin with.
const CAREFREE_LISTS_SHARE: u64 = 16;

/// How far a plan is looked for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum AssayEffort {
    /// By lists, and where they do not end in the fewest steps by all positions.
    Whole,
    Lists,
    /// By all positions, with fewer steps than these.
    Below(u64),
}

/// A plan of an assay; where the search gave up, or no plan has so few steps, lower bounds on every plan.
pub fn solve(
    problem: &AssayProblem,
    objective: BoardObjective,
    effort: AssayEffort,
    meter: &mut Meter,
) -> SearchAnswer<AssayPlan, NoAssayPlan, BoardCosts> {
    let mut distances = fast::Distances::of(&problem.instance.board);
    let (ahead, least) = match looked_ahead(problem, &mut distances, meter) {
        Ok(looked) => looked,
        Err(why) => return SearchAnswer::Impossible(why),
    };
    let by_lists = match effort {
        AssayEffort::Below(_) => None,
        AssayEffort::Whole | AssayEffort::Lists => {
            // Shared channels are not looked at until then.
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

/// Courses, if any are known, and lower bounds on every plan.
type KnownCourses = (Option<Vec<AgentCourse>>, BoardCosts);

/// The least sum of costs of a small assay by all positions, with the bound that this proves; where the search gave up, the courses that are
/// known.
fn least_sum(
    problem: &AssayProblem,
    ahead: &route::Ahead,
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

/// The better one of some courses and those that are known.
fn better(
    objective: BoardObjective,
    known: Option<Vec<AgentCourse>>,
    courses: Vec<AgentCourse>,
) -> Option<Vec<AgentCourse>> {
    known.into_iter().chain([courses]).min_by_key(|courses| AssayPlan::costs(courses).key(objective))
}

/// The courses of fewest steps by all positions, where these are fewer than those of the courses that are known and, if sums are minimized,
/// their sum is smaller.
fn fewer_steps(
    problem: &AssayProblem,
    ahead: &route::Ahead,
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
    let begin = |courses: &Vec<AgentCourse>| HeldBoardPlan::begin(objective, AssayPlan::costs(courses), bounds);
    let _held = known.as_ref().map(begin);
    // Only fewer steps than those at hand are of use.
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
    ahead: &route::Ahead,
    objective: BoardObjective,
    least: &bound::AssayBounds,
    distances: &mut fast::Distances,
    meter: &mut Meter,
) -> Option<Vec<AgentCourse>> {
    let listed = lags::by_lists(problem, ahead, objective, least, meter)
        .and_then(|courses| aside::as_replayed(problem, courses))
        .or_else(|| aside::by_lists(problem, objective, least, distances, meter));
    // Lists lead to long ways round where there are traces, if to any plan.
    let negotiated = match &listed {
        Some(courses) if problem.traces.is_none() || AssayPlan::is_least(courses, objective, least.costs) => None,
        Some(_) | None => {
            let part = if joint::takes(problem) { NEGOTIATED_SHARE_OF_FEW } else { NEGOTIATED_SHARE };
            let share = meter.left().steps / part;
            // Without traces these lists were tried already.
            let carefree = problem.traces.as_ref().and_then(|_| {
                let carefree = AssayProblem { traces: None, ..problem.clone() };
                meter.share(share / CAREFREE_LISTS_SHARE, |meter| {
                    lags::by_lists(&carefree, ahead, objective, least, meter)
                })
            });
            let known: Vec<_> = listed.iter().cloned().chain(carefree).collect();
            meter.share(share, |meter| negotiated::best(problem, ahead, &known, objective, least, meter))
        }
    };
    let key = |courses: &Vec<AgentCourse>| AssayPlan::costs(courses).key(objective);
    listed.into_iter().chain(negotiated).min_by_key(key).or_else(|| {
        let steps = meter.left().steps;
        let share = if joint::takes(problem) { steps / CHANCE_SHARE } else { steps };
        meter.share(share, |meter| aside::by_chance(problem, objective, least, distances, meter))
    })
}

/// The courses of fewest steps, by all positions. Without regard to traces there are far fewer of them: courses that do no harm all the same
/// have the fewest steps with it, too, and where there are none there are none with it.
fn fewest_steps(
    problem: &AssayProblem,
    ahead: &route::Ahead,
    limit: u32,
    meter: &mut Meter,
) -> SearchAnswer<Vec<AgentCourse>, Vec<Vec<CellIndex>>, u32> {
    let terms = JointTerms { objective: BoardObjective::Makespan, limit };
    if let Some(traces) = &problem.traces {
        let carefree = AssayProblem { traces: None, ..problem.clone() };
        let share = meter.left().steps / CAREFREE_SHARE;
        match meter.share(share, |meter| joint::least(&carefree, ahead, terms, meter)) {
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
