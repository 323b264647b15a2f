//! Whose course is planned next, and from when on.
//!
//! Eager turns follow the list: whoever can go on does so as far as it can. Of many agents some then come, or go to where they meet, long
//! before they are of use, and stand in the way of all others. Patient turns follow the time: next is who can go on first, what is to come
//! does so when another waits for it, and who has to wait stays where it is until shortly before.

use super::bookings::{Bookings, NEVER};
use super::lists::{ListPlanner, Progress, TurnOrder};
use super::route::{Course, RouteQuery};

/// How long before its time, in steps beyond those that it needs, who waits sets off or comes: if it is late with the first, with the other.
const EARLY: [u32; 2] = [100, 800];

/// Within so many steps after its time it is not late: it gives way to the one that it meets.
const PUNCTUAL: u32 = 12;

/// A shorter wait is left to the search.
const SHORT_WAIT: u32 = 200;

impl ListPlanner<'_, '_> {
    /// The agent that goes on next: of those that can, one whose turn it is where it goes to meet another, if there is one.
    pub(super) fn next(&self, progress: &Progress, list: &[usize], turns: TurnOrder) -> Option<usize> {
        let can_go_on = || list.iter().copied().filter(|agent| self.can_go_on(progress, *agent));
        let mut in_turn = can_go_on().filter(|agent| self.is_in_turn(progress, *agent));
        let next = match turns {
            TurnOrder::Eager => in_turn.next(),
            TurnOrder::Patient => in_turn.min_by_key(|agent| self.goes_on_at(progress, *agent)),
        };
        next.or_else(|| can_go_on().next())
    }

    /// Whether an agent has errands left and waits for none.
    fn can_go_on(&self, progress: &Progress, agent: usize) -> bool {
        progress.done[agent] < self.problem.errands[agent].len()
            && progress.courses[agent].ready.is_none()
            && progress.begins(self.problem, agent, progress.done[agent]).is_some()
            && (self.problem.parents[agent].is_none() || !progress.courses[agent].own.cells.is_empty())
    }

    /// Whether the agent that another one meets next meets no third one before, and is not there already: then that one goes on first.
    fn is_in_turn(&self, progress: &Progress, agent: usize) -> bool {
        let next_meeting = |agent: usize| {
            let waiting = usize::from(progress.courses[agent].ready.is_some());
            let left = &self.problem.errands[agent][progress.done[agent] - waiting.min(progress.done[agent])..];
            left.iter().find_map(|errand| errand.meets)
        };
        next_meeting(agent)
            .is_none_or(|other| next_meeting(other) == Some(agent) && !self.is_there_already(progress, other, agent))
    }

    /// Whether an agent that does not wait yet is where it meets another one next.
    fn is_there_already(&self, progress: &Progress, agent: usize, other: usize) -> bool {
        let next = self.problem.errands[agent].get(progress.done[agent]);
        let start = Some(self.problem.instance.agents[agent].start).filter(|_| !self.problem.comes[agent]);
        let here = progress.courses[agent].own.cells.last().copied().or(start);
        next.is_some_and(|errand| errand.meets == Some(other) && Some(errand.stop) == here)
            && self.can_go_on(progress, agent)
    }

    /// When an agent goes on, or another one waits for it; those that come and that nobody waits for yet are later.
    fn goes_on_at(&self, progress: &Progress, agent: usize) -> (bool, u32) {
        let (problem, own) = (self.problem, &progress.courses[agent].own);
        let begins = progress.begins(problem, agent, progress.done[agent]).unwrap_or(0);
        if !problem.comes[agent] || !own.cells.is_empty() {
            return (false, begins.max(own.until().saturating_sub(1)));
        }
        let errands = problem.errands[agent].iter().enumerate();
        let Some((meeting, other)) = errands.filter_map(|(place, errand)| Some((place, errand.meets?))).next() else {
            return (false, begins);
        };
        match progress.waits(problem, other, agent) {
            Some(since) => (false, since),
            None => (true, self.bounds.heads[agent][meeting]),
        }
    }

    /// The course of a query that begins shortly before it is of use; where there is none, one that begins at once.
    pub(super) fn late_course(&mut self, query: RouteQuery, bookings: &Bookings) -> Option<Course> {
        let mut best: Option<Course> = None;
        if let Some((due, way)) = self.due(&query) {
            // Until it sets off it has to be able to stay where it is.
            let free = if query.comes { NEVER } else { self.start_is_free_until(&query, bookings) };
            for early in EARLY {
                let end = best.as_ref().map_or(u32::MAX, Course::end);
                if best.is_some() && (!query.comes || end <= due.saturating_add(PUNCTUAL)) {
                    break;
                }
                let since = query.since.max(due.saturating_sub(way.saturating_add(early)));
                if since >= free {
                    continue;
                }
                let late = RouteQuery { since, limit: query.limit.min(end - 1), ..query };
                best = self.course(&late, bookings).or(best);
            }
        }
        match best {
            // It stays where it is before.
            Some(course) if !query.comes => {
                let stays = (query.since..course.since).map(|_| query.start);
                let cells = stays.chain(course.cells.iter().copied()).collect();
                Some(Course { since: query.since, cells, ..course })
            }
            Some(course) => Some(course),
            None => self.course(&query, bookings),
        }
    }

    /// The instant at which an agent is to be where its first errand, or another agent, waits for it, and the steps until it is there;
    /// `None` if it need not wait.
    fn due(&self, query: &RouteQuery) -> Option<(u32, u32)> {
        let errands = &self.problem.errands[query.agent][query.first..];
        let waits = |place: usize| query.waits[place].unwrap_or(0).max(query.begins[place]);
        let (place, due) = match query.comes {
            true => (0..query.waits.len()).find_map(|place| Some((place, query.waits[place]?)))?,
            false => Some((0, waits(0))).filter(|(_, due)| *due > query.since.saturating_add(SHORT_WAIT))?,
        };
        let from = |place: usize| place.checked_sub(1).map_or(query.start, |before| errands[before].stop);
        let ways = (0..=place).map(|place| self.ahead.steps(query.agent, query.first + place, from(place)));
        let stays = errands[..place].iter().map(|errand| errand.stay);
        Some((due, ways.chain(stays).fold(0, u32::saturating_add)))
    }
}
