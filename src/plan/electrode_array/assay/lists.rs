//! List scheduling: courses of the agents are planned in the order of a list.
//!
//! An agent's course goes on until its last errand, or until it waits for an agent that comes later in the list. The
//! first list begins with the agent whose errands take longest; others follow schedules that ignore conflicts. An agent
//! that finds no course moves to the front of the next list, with the agents that it meets. Once there is a plan, local
//! search changes its list: one agent moves to another place, or all agents of one droplet (every other time, of one
//! that is done last) move forward. The new list is kept if it is no worse. The agents of a first list also take turns
//! by time ([`TurnOrder`]), and the better plan counts. With many agents that is mostly the only plan.

use super::bookings::{BookedCourse, Bookings, NEVER};
use super::bound::AssayBounds;
use super::replay::done_at;
use super::route::{Course, RouteQuery, Router, StopDistances};
use super::turn_queue::{TurnLinks, TurnOrder, TurnQueue};
use super::{AgentCourse, AssayPlan, AssayProblem, Errand, ErrandPlace, bound};
use crate::device::electrode_array::{MAX_ASSAY_STEPS, MAX_DROPLET_STEPS};
use crate::plan::electrode_array::board::{BoardCosts, BoardObjective, BoardPlanProgress, CellIndex};
use crate::plan::search::Meter;
use crate::random::SplitMix64;
use rustc_hash::FxHashSet;
use std::collections::VecDeque;
use std::ops::Range;

/// Most lists tried until there is a plan, and then without an improvement.
const LISTS: usize = 200;

/// First lists tried without pauses, that is, where no agent yields its turn before it has to wait.
const LISTS_WITHOUT_PAUSE: usize = 100;

/// Lists tried with pauses if an agent has several splits.
const PAUSED_LISTS: usize = 4;

/// Rounds of local search; the best result counts.
const ROUNDS: usize = 4;

/// Most agents for which eager lists come first and only the search for courses is charged.
const MAX_EAGER: usize = 64;

/// Budget steps charged per instant of a course with more agents, where keeping the courses takes most of the time.
const STEPS_PER_INSTANT: u64 = 8;

/// Random seed of the changes.
const SEED: u64 = 1;

/// Reservation time of an unplanned agent's start, in instants per unit of separation; lists alternate between these.
const KEPT_SEPARATIONS: [u32; 3] = [6, 1, NEVER];

/// Budget of the search for one course, in steps.
const COURSE_STEPS: u64 = 20_000;

/// Added to that budget for each cell of the board and errand of the agent.
const STEPS_PER_CELL: u64 = 4;

/// The best courses found.
pub(super) fn best(
    problem: &AssayProblem,
    ahead: &StopDistances,
    objective: BoardObjective,
    bounds: &AssayBounds,
    meter: &mut Meter,
) -> Option<Vec<AgentCourse>> {
    let mut planner = ListPlanner::new(problem, ahead, bounds, meter);
    let mut list: Vec<usize> = (0..problem.errands.len()).collect();
    let lengths = bound::lengths(problem, ahead);
    list.sort_by_key(|agent| std::cmp::Reverse(lengths[*agent]));
    let mut random = SplitMix64::new(SEED);
    let is_crowd = list.len() > MAX_EAGER;
    let early = if is_crowd { first_patient(&mut planner, &list) } else { None };
    // With many agents, an eager list fails late.
    let tries = if early.is_some() { 1 } else { LISTS };
    let eager = first_eager(&mut planner, list.clone(), 0..tries, &mut random);
    // A parent keeps far from its children's starts as long as these have no course; with pauses they get one sooner.
    let pausing = LISTS_WITHOUT_PAUSE..LISTS_WITHOUT_PAUSE + PAUSED_LISTS;
    let has_pauses = planner.has_several_splits();
    let paused = has_pauses.then(|| first_eager(&mut planner, list.clone(), pausing, &mut random)).flatten();
    let key = |courses: &[AgentCourse]| AssayPlan::costs(courses).key(objective);
    let mut firsts: Vec<FirstList> = [eager, paused].into_iter().flatten().collect();
    let mut patient: Vec<Vec<AgentCourse>> = Vec::new();
    for schedule in problem.relaxed_schedules.iter().filter(|_| problem.releases.is_empty()) {
        let found = by_schedule(&mut planner, schedule);
        firsts.extend(found.0);
        patient.extend(found.1);
    }
    firsts.sort_by_key(|first| key(&first.courses));
    patient.extend(if is_crowd { early } else { first_patient(&mut planner, &list) });
    let best = Improvement { firsts, objective, least: bounds.costs }.best(&mut planner, &mut random);
    best.into_iter().chain(patient).min_by_key(|courses| key(courses))
}

/// The best courses found from a random first list.
pub(super) fn by_random_list(
    problem: &AssayProblem,
    ahead: &StopDistances,
    objective: BoardObjective,
    bounds: &AssayBounds,
    seed: u64,
    meter: &mut Meter,
) -> Option<Vec<AgentCourse>> {
    let mut planner = ListPlanner::new(problem, ahead, bounds, meter);
    let mut random = SplitMix64::new(seed);
    let mut list: Vec<usize> = (0..problem.errands.len()).collect();
    (1..list.len()).rev().for_each(|last| list.swap(last, below(&mut random, last + 1)));
    let first = first_eager(&mut planner, list, 0..2 * KEPT_SEPARATIONS.len(), &mut random)?;
    Improvement { firsts: vec![first], objective, least: bounds.costs }.best(&mut planner, &mut random)
}

/// A list that yields a plan.
struct FirstList {
    courses: Vec<AgentCourse>,
    list: Vec<usize>,
    terms: ListTerms,
}

/// Tries lists until one yields a plan; after a failure, the agents that blocked a course move to the front.
fn first_eager(
    planner: &mut ListPlanner,
    mut list: Vec<usize>,
    tries: Range<usize>,
    random: &mut SplitMix64,
) -> Option<FirstList> {
    let problem = planner.problem;
    for nth in tries {
        if planner.meter.left().steps == 0 {
            break;
        }
        let terms = ListTerms {
            kept_separations: KEPT_SEPARATIONS[nth % KEPT_SEPARATIONS.len()],
            turns: TurnOrder::Eager,
            pauses: nth >= LISTS_WITHOUT_PAUSE,
        };
        match planner.courses(&list, terms) {
            Ok(courses) => return Some(FirstList { courses, list, terms }),
            Err(failed) => {
                let mut first = vec![failed];
                first.extend(problem.errands[failed].iter().filter_map(|errand| errand.meets));
                first.extend(problem.parents[failed]);
                first.dedup();
                // Repeating the same order would fail again.
                if nth % 2 == 1 {
                    list = moved(&list, random);
                }
                list.retain(|agent| !first.contains(agent));
                list.splice(0..0, first);
            }
        }
    }
    None
}

/// The list in the order of a schedule that ignores conflicts, and courses in which no errand begins earlier than in
/// that schedule.
fn by_schedule(planner: &mut ListPlanner, schedule: &[Vec<u32>]) -> (Option<FirstList>, Option<Vec<AgentCourse>>) {
    let (problem, ahead, bounds) = (planner.problem, planner.ahead, planner.bounds);
    let mut released = AssayProblem { releases: problem.unheld(), ..problem.clone() };
    for (agent, own) in schedule.iter().enumerate() {
        for (errand, begin) in own.iter().enumerate() {
            if let Some((place, until)) = problem.held_back_by(ErrandPlace { agent, errand }, *begin) {
                let release = &mut released.releases[place.agent][place.errand];
                *release = until.max(*release);
            }
        }
    }
    let begin = |agent: &usize| {
        let first = usize::from(problem.enters[*agent]);
        schedule[*agent].get(first).copied().unwrap_or(0)
    };
    let mut list: Vec<usize> = (0..problem.errands.len()).collect();
    list.sort_by_key(begin);
    let mut random = SplitMix64::new(SEED);
    let mut fresh = ListPlanner::new(problem, ahead, bounds, planner.meter);
    let eager = first_eager(&mut fresh, list.clone(), 0..KEPT_SEPARATIONS.len(), &mut random);
    let mut held = ListPlanner::new(&released, ahead, bounds, planner.meter);
    let patient = first_patient(&mut held, &list);
    (eager, patient)
}

/// The courses of a list whose agents take their turns by time. The order of the list hardly changes them.
fn first_patient(planner: &mut ListPlanner, list: &[usize]) -> Option<Vec<AgentCourse>> {
    KEPT_SEPARATIONS.iter().find_map(|kept_separations| {
        let terms = ListTerms { kept_separations: *kept_separations, turns: TurnOrder::Patient, pauses: false };
        planner.courses(list, terms).ok()
    })
}

/// Local search for better lists.
struct Improvement {
    /// The best one first.
    firsts: Vec<FirstList>,
    objective: BoardObjective,
    /// Lower bounds on every plan.
    least: BoardCosts,
}

impl Improvement {
    /// The best courses of several rounds, which start from the first lists in turn; `None` if there is no first list.
    fn best(self, planner: &mut ListPlanner, random: &mut SplitMix64) -> Option<Vec<AgentCourse>> {
        let mut best = self.firsts.first()?.courses.clone();
        let costs = AssayPlan::costs(&best);
        let mut progress = BoardPlanProgress::begin(self.objective, costs, self.least);
        for first in self.firsts.iter().cycle().take(ROUNDS) {
            if self.is_least(&best) {
                break;
            }
            let found = self.round(planner, first, random, &mut progress);
            if self.key(&found) < self.key(&best) {
                best = found;
            }
        }
        Some(best)
    }

    fn is_least(&self, courses: &[AgentCourse]) -> bool {
        AssayPlan::is_least(courses, self.objective, self.least)
    }

    fn key(&self, courses: &[AgentCourse]) -> (u64, u64) {
        AssayPlan::costs(courses).key(self.objective)
    }

    /// One round: changes the list until no change has improved it for a while, and returns its courses.
    fn round(
        &self,
        planner: &mut ListPlanner,
        first: &FirstList,
        random: &mut SplitMix64,
        progress: &mut BoardPlanProgress,
    ) -> Vec<AgentCourse> {
        let (mut courses, mut list) = (first.courses.clone(), first.list.clone());
        let droplet_of = bound::droplet_of(planner.problem);
        let mut idle = 0;
        while !self.is_least(&courses) && idle < LISTS && list.len() > 1 && planner.meter.left().steps > 0 {
            planner.limit = match self.objective {
                BoardObjective::Makespan => u32::try_from(AssayPlan::costs(&courses).makespan).unwrap_or(NEVER),
                BoardObjective::SumOfCosts => NEVER,
            };
            let other = match idle % 3 {
                0 => moved(&list, random),
                1 => advanced(&list, &droplet_of, &[below(random, droplet_of.len())], random),
                _ => advanced(&list, &droplet_of, &last_done(&courses), random),
            };
            idle += 1;
            let Ok(found) = planner.courses(&other, first.terms) else { continue };
            if self.key(&found) < self.key(&courses) {
                idle = 0;
                progress.offer(AssayPlan::costs(&found), self.least);
            }
            if self.key(&found) <= self.key(&courses) {
                (courses, list) = (found, other);
            }
        }
        courses
    }
}

/// The list with one random agent moved to a random place.
fn moved(list: &[usize], random: &mut SplitMix64) -> Vec<usize> {
    moved_to(list, below(random, list.len()), below(random, list.len()))
}

/// The list with the agent at index `from` moved to index `to`.
pub(super) fn moved_to(list: &[usize], from: usize, to: usize) -> Vec<usize> {
    let mut list = list.to_vec();
    if from < list.len() {
        let agent = list.remove(from);
        list.insert(to, agent);
    }
    list
}

/// The list with all agents of one droplet moved forward together. The droplet is that of a random agent among `some`.
fn advanced(list: &[usize], droplet_of: &[usize], some: &[usize], random: &mut SplitMix64) -> Vec<usize> {
    let Some(agent) = some.get(below(random, some.len())) else { return list.to_vec() };
    let droplet = droplet_of[*agent];
    let (own, mut others): (Vec<usize>, Vec<usize>) = list.iter().partition(|agent| droplet_of[**agent] == droplet);
    let first = list.iter().position(|agent| droplet_of[*agent] == droplet).unwrap_or(0);
    let to = below(random, first + 1);
    others.splice(to..to, own);
    others
}

/// The agents whose courses end last.
pub(super) fn last_done(courses: &[AgentCourse]) -> Vec<usize> {
    let length = |agent: &usize| courses[*agent].until();
    let longest = (0..courses.len()).map(|agent| length(&agent)).max();
    (0..courses.len()).filter(|agent| Some(length(agent)) == longest).collect()
}

/// A random number below `count`; 0 if `count` is 0.
pub(super) fn below(random: &mut SplitMix64, count: usize) -> usize {
    (random.next_u64() % count.max(1) as u64) as usize
}

/// Terms on which a list is scheduled.
#[derive(Debug, Clone, Copy)]
struct ListTerms {
    /// Reservation time of an unplanned agent's start, in instants per unit of separation.
    kept_separations: u32,
    turns: TurnOrder,
    /// Whether an agent yields its turn after each errand that others wait for, and after each split.
    pauses: bool,
}

/// The errands that an agent can do next, in the form of [`RouteQuery`].
#[derive(Default)]
struct DueErrands {
    waits: Vec<Option<u32>>,
    begins: Vec<u32>,
    held: Vec<u32>,
}

pub(super) struct ListPlanner<'a, 'm> {
    pub problem: &'a AssayProblem<'a>,
    pub ahead: &'a StopDistances,
    router: Router<'a>,
    pub bounds: &'a AssayBounds,
    pub links: TurnLinks,
    /// The errands, as (agent, errand), that others wait for.
    awaited: FxHashSet<(usize, usize)>,
    /// Latest end of all courses.
    limit: u32,
    meter: &'m mut Meter,
}

/// State while the courses are planned.
pub(super) struct Progress<'a> {
    bookings: Bookings<'a>,
    pub courses: Vec<BookedCourse>,
    /// By agent: number of errands done.
    pub done: Vec<usize>,
    /// By agent: when each errand was done, except the last one of an agent that waits.
    done_at: Vec<Vec<u32>>,
    /// By agent: the agents that it has merged with.
    past: Vec<Vec<usize>>,
    /// Agents that have split off and have no course yet, each with the instant at which it appears.
    split_off: VecDeque<(usize, u32)>,
    /// Number of instants of all courses.
    instants: u64,
}

impl Progress<'_> {
    /// Records when the errands of a new part of a course, from an instant on, are done; `None` if it does not do them.
    fn note_done(
        &mut self,
        problem: &AssayProblem,
        agent: usize,
        since: u32,
        begins: &[u32],
        waits: &[Option<u32>],
    ) -> Option<()> {
        let course = &self.courses[agent];
        let first = since.max(course.own.since);
        let mut last = first;
        let mut splits = course.splits.iter().filter(|before| **before >= first);
        for (begins, waits) in begins.iter().zip(waits) {
            let errand = self.done_at[agent].len();
            let Errand { meets, splits: split, .. } = problem.errands[agent][errand];
            if meets.is_some() && waits.is_none() {
                break;
            }
            let from = last.max(*begins).max(waits.unwrap_or(0));
            last = match split {
                Some(_) => splits.next()? + 1,
                None => done_at(problem, ErrandPlace { agent, errand }, &course.own, from)?,
            };
            self.done_at[agent].push(last);
        }
        Some(())
    }

    /// Reserves the starts of agents that have split off.
    fn keep_split_off(&mut self, problem: &AssayProblem, instants: u32) {
        for (agent, since) in &self.split_off {
            let start = problem.instance.agents[*agent].start;
            self.bookings.keep(*agent, start, *since, since - 1, since.saturating_add(instants));
        }
    }

    /// The instant from which an errand may begin; `None` if it is not known yet.
    pub(super) fn begins(&self, problem: &AssayProblem, agent: usize, errand: usize) -> Option<u32> {
        Some(self.after(problem, agent, errand)?.max(problem.release(agent, errand)))
    }

    /// The instant at which an errand's predecessors are all done; `None` if it is not known yet.
    fn after(&self, problem: &AssayProblem, agent: usize, errand: usize) -> Option<u32> {
        let mut last = 0;
        for before in problem.afters[agent].get(errand).into_iter().flatten() {
            last = last.max(*self.done_at[before.agent].get(before.errand)?);
        }
        Some(last)
    }

    /// The instant since which `other` has waited for `agent` at the end of its course; `None` if it does not wait.
    pub(super) fn waits(&self, problem: &AssayProblem, other: usize, agent: usize) -> Option<u32> {
        let waiting = self.done[other].checked_sub(1).map(|last| problem.errands[other][last]);
        let course = &self.courses[other];
        let is_there = waiting.is_some_and(|errand| errand.meets == Some(agent)) && course.ready.is_some();
        is_there.then(|| course.own.until() - 1)
    }
}

impl<'a, 'm> ListPlanner<'a, 'm> {
    fn new(
        problem: &'a AssayProblem<'a>,
        ahead: &'a StopDistances,
        bounds: &'a AssayBounds,
        meter: &'m mut Meter,
    ) -> ListPlanner<'a, 'm> {
        let (router, links, awaited) = (Router::new(problem, ahead), TurnLinks::new(problem), problem.awaited());
        ListPlanner { problem, ahead, router, bounds, links, awaited, limit: NEVER, meter }
    }

    /// Whether some agent has more than one split.
    fn has_several_splits(&self) -> bool {
        let splits = |errands: &Vec<Errand>| errands.iter().filter(|errand| errand.splits.is_some()).count();
        self.problem.errands.iter().any(|errands| splits(errands) > 1)
    }

    /// The courses of all agents; the error is an agent that found none.
    fn courses(&mut self, list: &[usize], terms: ListTerms) -> Result<Vec<AgentCourse>, usize> {
        let (problem, separation) = (self.problem, self.problem.instance.separation);
        let count = problem.errands.len();
        let mut progress = Progress {
            bookings: Bookings::new(&problem.instance.board, separation, count, problem.traces.as_ref()),
            courses: vec![BookedCourse::default(); count],
            done: vec![0; count],
            done_at: vec![Vec::new(); count],
            past: vec![Vec::new(); count],
            split_off: VecDeque::new(),
            instants: 0,
        };
        let until = separation.saturating_mul(terms.kept_separations);
        for (agent, asked) in problem.instance.agents.iter().enumerate() {
            if !problem.enters[agent] && problem.parents[agent].is_none() {
                progress.bookings.keep(agent, asked.start, 0, 0, until);
            }
        }
        let mut queue = TurnQueue::new(list);
        list.iter().for_each(|agent| queue.note(*agent, self.turn_of(&progress, *agent, terms.turns)));
        loop {
            #[cfg(test)]
            assert_eq!(queue.next(), self.next_of_all(&progress, list, terms.turns));
            // Agents that have split off come first, since they are on the board already.
            let split_off = progress.split_off.pop_front().map(|(agent, _)| agent);
            let Some(agent) = split_off.or_else(|| queue.next_due()) else { break };
            if self.extend_course(&mut progress, agent, terms)? {
                queue.went_on(agent);
                for other in self.links.affected(agent) {
                    queue.note(other, self.turn_of(&progress, other, terms.turns));
                }
            } else if terms.turns == TurnOrder::Patient && !problem.enters[agent] {
                // Another agent blocks it that goes away later.
                queue.postpone(agent)?;
            } else {
                return Err(agent);
            }
            progress.keep_split_off(problem, until);
        }
        if let Some(agent) = (0..count).find(|agent| progress.done[*agent] < problem.errands[*agent].len()) {
            return Err(agent);
        }
        let courses: Vec<AgentCourse> = progress.courses.into_iter().map(|course| course.own).collect();
        if count > MAX_EAGER {
            let instants: u64 = courses.iter().map(|course| course.cells.len() as u64).sum();
            self.meter.charge(STEPS_PER_INSTANT * instants);
        }
        // An agent may have reached a meeting before the other one, not planned then, left its traces there.
        match problem.traces.as_ref().and_then(|traces| traces.harmed(problem, &courses)) {
            Some(agent) => Err(agent),
            None => Ok(courses),
        }
    }

    /// The errands that an agent can do next, up to where it waits for another one or yields its turn.
    fn due_errands(&self, progress: &Progress, agent: usize, terms: ListTerms) -> DueErrands {
        let problem = self.problem;
        let mut due = DueErrands::default();
        for (place, errand) in problem.errands[agent].iter().enumerate().skip(progress.done[agent]) {
            let Some(after) = progress.after(problem, agent, place) else { break };
            let since = errand.meets.and_then(|other| progress.waits(problem, other, agent));
            let release = problem.release(agent, place);
            let is_held = release > after && errand.mixes.is_none() && errand.splits.is_none();
            due.waits.push(since);
            due.begins.push(after.max(release));
            due.held.push(if is_held { release } else { 0 });
            let pauses = terms.pauses && (errand.splits.is_some() || self.awaited.contains(&(agent, place)));
            if pauses || (errand.meets.is_some() && since.is_none()) {
                break;
            }
        }
        due
    }

    /// Extends the course of an agent to its end, or to where it waits for another one; returns whether one is found.
    /// The error is the agent if it does not do its errands, or the courses take more steps than a plan may have.
    fn extend_course(&mut self, progress: &mut Progress, agent: usize, terms: ListTerms) -> Result<bool, usize> {
        let problem = self.problem;
        let first = progress.done[agent];
        let errands = &problem.errands[agent][first..];
        let DueErrands { waits, begins, held } = self.due_errands(progress, agent, terms);
        let last = waits.len().checked_sub(1).map(|last| errands[last]).ok_or(agent)?;
        let is_last = first + waits.len() == problem.errands[agent].len();
        let must_wait = last.meets.is_some() && waits.last().is_some_and(Option::is_none);
        let is_gone = is_last && problem.is_gone[agent] && !must_wait;
        let start = problem.instance.agents[agent].start;
        let own = &progress.courses[agent].own;
        let (start, since) = match own.cells.last() {
            None => (start, if problem.enters[agent] { begins[0] } else { 0 }),
            Some(last) => (*last, own.until() - 1),
        };
        let query = RouteQuery {
            agent,
            start,
            since,
            first,
            waits: &waits,
            begins: &begins,
            held: &held,
            past: &progress.past[agent],
            is_gone,
            enters: problem.enters[agent] && own.cells.is_empty(),
            // Errands after the last one of these must be done within the limit too.
            limit: match self.limit {
                NEVER => NEVER,
                limit => limit.saturating_sub(self.bounds.after[agent][first + waits.len() - 1]),
            },
        };
        progress.bookings.lift(agent);
        let course = match terms.turns {
            TurnOrder::Eager => self.course(&query, &progress.bookings),
            TurnOrder::Patient => self.late_course(query, &progress.bookings),
        };
        let Some(course) = course else {
            if !progress.courses[agent].own.cells.is_empty() {
                progress.bookings.enter(agent, &progress.courses[agent], &progress.done_at[agent]);
            }
            return Ok(false);
        };
        progress.instants += course.cells.len() as u64;
        if u64::from(course.end()) > MAX_ASSAY_STEPS || progress.instants > MAX_DROPLET_STEPS {
            return Err(agent);
        }
        let own = &mut progress.courses[agent];
        match own.own.cells.pop() {
            None => own.own = AgentCourse { since: course.since, cells: course.cells },
            // The course continues from its last cell.
            Some(_) => own.own.cells.extend(&course.cells),
        }
        own.ready = must_wait.then_some(course.ready);
        own.splits.extend(course.splits.iter().map(|(_, at)| at - 1));
        own.is_gone = is_gone;
        progress.done[agent] = first + waits.len();
        progress.note_done(problem, agent, since, &begins, &waits).ok_or(agent)?;
        progress.bookings.enter(agent, &progress.courses[agent], &progress.done_at[agent]);
        for (child, since) in course.splits {
            // The child's course begins where it appears.
            let start = problem.instance.agents[child].start;
            let own = AgentCourse { since, cells: vec![start] };
            progress.courses[child] = BookedCourse { own, is_split_off: true, ..BookedCourse::default() };
            progress.split_off.push_back((child, since));
        }
        for (errand, waited) in errands.iter().zip(&waits) {
            if let (Some(other), Some(_)) = (errand.meets, waited) {
                self.met(progress, other, agent, errand.stop);
            }
        }
        Ok(true)
    }

    /// The course of a query, within a budget of its own.
    pub(super) fn course(&mut self, query: &RouteQuery, bookings: &Bookings) -> Option<Course> {
        let cells = self.problem.instance.board.cells() as u64;
        let allowed = COURSE_STEPS + STEPS_PER_CELL * cells * query.waits.len() as u64;
        let router = &mut self.router;
        self.meter.share(allowed, |meter| router.course(query, bookings, meter))
    }

    /// The first instant at which the agent of a query can no longer stay at its start.
    pub(super) fn start_is_free_until(&mut self, query: &RouteQuery, bookings: &Bookings) -> u32 {
        self.router.start_is_free_until(query, bookings)
    }

    /// Ends the wait of an agent that has been met: it is gone, or can continue from that instant.
    fn met(&self, progress: &mut Progress, other: usize, agent: usize, stop: CellIndex) {
        let since = progress.courses[other].own.until() - 1;
        let course = &progress.courses[agent].own;
        let came = (since..course.until()).find(|instant| course.at(*instant) == Some(stop)).unwrap_or(since);
        progress.done_at[other].push(came);
        let course = &mut progress.courses[other];
        course.own.cells.resize((came + 1 - course.own.since) as usize, stop);
        course.ready = None;
        course.is_gone = self.problem.is_gone[other] && progress.done[other] == self.problem.errands[other].len();
        progress.bookings.enter(other, &progress.courses[other], &progress.done_at[other]);
        progress.past[agent].push(other);
        progress.past[other].push(agent);
    }
}
