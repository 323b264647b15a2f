//! Courses of the agents in the order of a list.
//!
//! An agent's course goes on until its last errand, or until it waits for an agent that comes later in the list; around
//! it are the courses of those that had their turns before. Agents take their turns in the order of the list or of time
//! ([`TurnOrder`]), and may keep to the lanes between the places of all others ([`super::lanes`]).

use super::bookings::{BookedCourse, Bookings, NEVER};
use super::bound::AssayBounds;
use super::lanes::Lanes;
use super::replay::done_at;
use super::route::{Course, RouteQuery, Router, StopDistances};
use super::turn_queue::{TurnLinks, TurnOrder, TurnQueue};
use super::{AgentCourse, AssayProblem, Errand, ErrandPlace};
use crate::device::electrode_array::{MAX_ASSAY_STEPS, MAX_DROPLET_STEPS};
use crate::plan::electrode_array::board::CellIndex;
use crate::plan::search::Meter;
use rustc_hash::FxHashSet;
use std::collections::VecDeque;

/// Most agents for which eager lists come first and only the search for courses is charged.
pub(super) const MAX_EAGER: usize = 64;

/// Budget steps charged per instant of a course with more agents, where keeping the courses takes most of the time.
const STEPS_PER_INSTANT: u64 = 8;

/// Budget of the search for one course, in steps.
const COURSE_STEPS: u64 = 20_000;

/// Added to that budget for each cell of the board and errand of the agent.
const STEPS_PER_CELL: u64 = 4;

/// Terms on which a list is scheduled.
#[derive(Debug, Clone, Copy)]
pub(super) struct ListTerms {
    /// Reservation time of an unplanned agent's start, in instants per unit of separation.
    pub kept_separations: u32,
    pub turns: TurnOrder,
    /// Whether an agent yields its turn after each errand that others wait for, and after each split.
    pub pauses: bool,
    /// Whether agents keep to the lanes between the places of all others where they can.
    pub keeps_lanes: bool,
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
    pub limit: u32,
    /// Built for the first list that keeps to lanes.
    lanes: Option<Lanes<'a>>,
    pub meter: &'m mut Meter,
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
    pub fn new(
        problem: &'a AssayProblem<'a>,
        ahead: &'a StopDistances,
        bounds: &'a AssayBounds,
        meter: &'m mut Meter,
    ) -> ListPlanner<'a, 'm> {
        let (router, links, awaited) = (Router::new(problem, ahead), TurnLinks::new(problem), problem.awaited());
        ListPlanner { problem, ahead, router, bounds, links, awaited, limit: NEVER, lanes: None, meter }
    }

    /// Whether some agent has more than one split.
    pub fn has_several_splits(&self) -> bool {
        let splits = |errands: &Vec<Errand>| errands.iter().filter(|errand| errand.splits.is_some()).count();
        self.problem.errands.iter().any(|errands| splits(errands) > 1)
    }

    /// The courses of all agents; the error is an agent that found none.
    pub fn courses(&mut self, list: &[usize], terms: ListTerms) -> Result<Vec<AgentCourse>, usize> {
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
            keeps_lanes: terms.keeps_lanes,
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

    /// The course of a query, within a budget of its own: along lanes if that is asked for and possible.
    pub(super) fn course(&mut self, query: &RouteQuery, bookings: &Bookings) -> Option<Course> {
        let cells = self.problem.instance.board.cells() as u64;
        let allowed = COURSE_STEPS + STEPS_PER_CELL * cells * query.waits.len() as u64;
        let (router, meter) = (&mut self.router, &mut *self.meter);
        let mut course = |closed| meter.share(allowed, |meter| router.course(query, bookings, closed, meter));
        let closed = match query.keeps_lanes {
            true => self.lanes.get_or_insert_with(|| Lanes::new(self.problem)).closed_to(query),
            false => None,
        };
        closed.and_then(|closed| course(Some(closed))).or_else(|| course(None))
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
