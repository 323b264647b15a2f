//! Which agent's course is planned next, and from which instant on.
//!
//! Eager turns follow the list: an agent that can continue does so as far as it can. With many agents, some then enter,
//! or go to a meeting, long before they are needed, and block all others. Patient turns follow time: the agent that can
//! continue first is next; an agent enters when another one waits for it; and an agent that has to wait stays where it
//! is until shortly before its time. One that finds no course then stands back while others go on, since one of them
//! may be in its way.

use super::bookings::{Bookings, NEVER};
use super::list_planner::{ListPlanner, Progress};
use super::route::{Course, RouteQuery};
use super::turn_queue::{AgentTurn, TurnOrder};

/// Steps, beyond the travel time, by which a waiting agent sets off or enters before its time. The second value is
/// tried if it is late with the first.
const EARLY: [u32; 2] = [100, 800];

/// Steps after its time within which an agent is not late, since it gives way to the agent that it meets.
const PUNCTUAL: u32 = 12;

/// A shorter wait, in steps, is left to the search.
const SHORT_WAIT: u32 = 200;

impl ListPlanner<'_, '_> {
    /// As [`super::turn_queue::TurnQueue::next`], from the whole list.
    #[cfg(test)]
    pub(super) fn next_of_all(&self, progress: &Progress, list: &[usize], order: TurnOrder) -> Option<usize> {
        let able = || list.iter().copied().filter(|agent| self.can_go_on(progress, *agent));
        let mut in_turn = able().filter(|agent| self.is_in_turn(progress, *agent));
        let next = match order {
            TurnOrder::Eager => in_turn.next(),
            TurnOrder::Patient => in_turn.min_by_key(|agent| self.goes_on_at(progress, *agent)),
        };
        next.or_else(|| able().next())
    }

    /// Whether an agent can continue, in an order of turns.
    pub(super) fn turn_of(&self, progress: &Progress, agent: usize, order: TurnOrder) -> AgentTurn {
        if !self.can_go_on(progress, agent) {
            return AgentTurn::No;
        }
        match (self.is_in_turn(progress, agent), order) {
            (false, _) => AgentTurn::Able,
            (true, TurnOrder::Eager) => AgentTurn::Its((false, 0)),
            (true, TurnOrder::Patient) => AgentTurn::Its(self.goes_on_at(progress, agent)),
        }
    }

    /// Whether an agent has errands left and waits for none.
    fn can_go_on(&self, progress: &Progress, agent: usize) -> bool {
        progress.done[agent] < self.problem.errands[agent].len()
            && progress.courses[agent].ready.is_none()
            && progress.begins(self.problem, agent, progress.done[agent]).is_some()
            && (self.problem.parents[agent].is_none() || !progress.courses[agent].own.cells.is_empty())
    }

    /// Whether the next meeting of an agent is also the next one of its partner, and the partner is not there already.
    /// Otherwise the partner continues first.
    fn is_in_turn(&self, progress: &Progress, agent: usize) -> bool {
        let next_meeting = |agent: usize| {
            let waiting = usize::from(progress.courses[agent].ready.is_some());
            let left = &self.problem.errands[agent][progress.done[agent] - waiting.min(progress.done[agent])..];
            left.iter().find_map(|errand| errand.meets)
        };
        next_meeting(agent)
            .is_none_or(|other| next_meeting(other) == Some(agent) && !self.is_there_already(progress, other, agent))
    }

    /// Whether an agent is at its next meeting with another one, but does not wait there yet.
    fn is_there_already(&self, progress: &Progress, agent: usize, other: usize) -> bool {
        let next = self.problem.errands[agent].get(progress.done[agent]);
        let start = Some(self.problem.instance.agents[agent].start).filter(|_| !self.problem.enters[agent]);
        let here = progress.courses[agent].own.cells.last().copied().or(start);
        next.is_some_and(|errand| errand.meets == Some(other) && Some(errand.stop) == here)
            && self.can_go_on(progress, agent)
    }

    /// Sort key: the instant at which an agent continues, or at which another one begins to wait for it. Agents that
    /// enter and that nobody waits for yet come later.
    fn goes_on_at(&self, progress: &Progress, agent: usize) -> (bool, u32) {
        let (problem, own) = (self.problem, &progress.courses[agent].own);
        let begins = progress.begins(problem, agent, progress.done[agent]).unwrap_or(0);
        if !problem.enters[agent] || !own.cells.is_empty() {
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

    /// The course of a query that begins shortly before the agent is needed; if there is none, one that begins at once.
    pub(super) fn late_course(&mut self, query: RouteQuery, bookings: &Bookings) -> Option<Course> {
        let mut best: Option<Course> = None;
        if let Some((due, way)) = self.due(&query) {
            // It must be able to stay where it is until it sets off.
            let free = if query.enters { NEVER } else { self.start_is_free_until(&query, bookings) };
            for early in EARLY {
                let end = best.as_ref().map_or(u32::MAX, Course::end);
                if best.is_some() && (!query.enters || end <= due.saturating_add(PUNCTUAL)) {
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
            // It stays where it is before that.
            Some(course) if !query.enters => {
                let stays = (query.since..course.since).map(|_| query.start);
                let cells = stays.chain(course.cells.iter().copied()).collect();
                Some(Course { since: query.since, cells, ..course })
            }
            Some(course) => Some(course),
            None => self.course(&query, bookings),
        }
    }

    /// The instant at which an agent is due, because its first errand may begin or another agent waits for it, and its
    /// steps until it is there. `None` if it need not wait.
    fn due(&self, query: &RouteQuery) -> Option<(u32, u32)> {
        let errands = &self.problem.errands[query.agent][query.first..];
        let waits = |place: usize| query.waits[place].unwrap_or(0).max(query.begins[place]);
        let (place, due) = match query.enters {
            true => (0..query.waits.len()).find_map(|place| Some((place, query.waits[place]?)))?,
            false => Some((0, waits(0))).filter(|(_, due)| *due > query.since.saturating_add(SHORT_WAIT))?,
        };
        let from = |place: usize| place.checked_sub(1).map_or(query.start, |before| errands[before].stop);
        let ways = (0..=place).map(|place| self.ahead.steps(query.agent, query.first + place, from(place)));
        let stays = errands[..place].iter().map(|errand| errand.stay);
        Some((due, ways.chain(stays).fold(0, u32::saturating_add)))
    }
}
