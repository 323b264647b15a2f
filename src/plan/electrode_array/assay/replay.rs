//! Replay of courses: the instants at which they do their errands.

use super::{AgentCourse, AssayProblem, Errand, ErrandPlace};

/// The first instant, from `from` on, at which a course has done an errand; the course stays at its last cell. If the
/// errand is a meeting, the instant at which this agent is there. `None` if the course does not do it.
pub fn done_at(problem: &AssayProblem, of: ErrandPlace, course: &AgentCourse, from: u32) -> Option<u32> {
    let errand = problem.errands[of.agent].get(of.errand)?;
    let at = |instant: u32| course.at(instant);
    let length = course.until();
    if let Some(around) = errand.mixes {
        let around = &problem.loops[around];
        let due = |step: u32| Some(around[step as usize % around.len()]);
        let goes_round = |since: &u32| (0..=errand.stay).all(|step| at(since + step) == due(step));
        return (from..length).find(goes_round).map(|since| since + errand.stay);
    }
    let mut since = None;
    for instant in from..length.max(from + 1) {
        since = if at(instant) == Some(errand.stop) { since.or(Some(instant)) } else { None };
        if since.is_some_and(|since| instant - since == errand.stay) {
            return Some(instant);
        }
    }
    since.map(|since| since + errand.stay)
}

/// For each agent, the instants at which courses do its errands; fewer than it has if they do not do all.
pub fn done_by(problem: &AssayProblem, courses: &[AgentCourse]) -> Vec<Vec<u32>> {
    let mut replay = Replay { problem, courses, done_at: vec![Vec::new(); courses.len()] };
    let mut done = 0;
    loop {
        (0..courses.len()).for_each(|agent| replay.go_on(agent));
        let now: usize = replay.done_at.iter().map(Vec::len).sum();
        if std::mem::replace(&mut done, now) == now {
            return replay.done_at;
        }
    }
}

/// Cuts the courses of agents that are gone at the first instant at which a replay has all their errands done, whatever
/// was planned after it. Returns when the errands are done, as [`done_by`] does.
pub fn cut_where_gone(problem: &AssayProblem, courses: &mut [AgentCourse]) -> Vec<Vec<u32>> {
    let done_by = done_by(problem, courses);
    for (agent, (course, done_at)) in courses.iter_mut().zip(&done_by).enumerate() {
        let is_gone = problem.is_gone[agent] && done_at.len() == problem.errands[agent].len();
        if let Some(last) = done_at.last().filter(|last| is_gone && **last >= course.since) {
            course.cells.truncate((last + 1 - course.since) as usize);
        }
    }
    done_by
}

struct Replay<'a> {
    problem: &'a AssayProblem<'a>,
    courses: &'a [AgentCourse],
    /// By agent, the instants at which its errands so far are done.
    done_at: Vec<Vec<u32>>,
}

impl Replay<'_> {
    /// The next errand of an agent and the instant from which it can be done; `None` while that is not known, or there
    /// is none.
    fn begins(&self, agent: usize) -> Option<(Errand, u32)> {
        let errand = self.done_at[agent].len();
        let due = self.problem.errands[agent].get(errand)?;
        let mut from = self.done_at[agent].last().copied().unwrap_or(self.courses[agent].since);
        for before in &self.problem.afters[agent][errand] {
            from = from.max(*self.done_at[before.agent].get(before.errand)?);
        }
        Some((*due, from))
    }

    /// The instant at which two agents merge: the first one at which both are at the stop and may begin.
    fn merged(&self, agent: usize, due: Errand, begins: u32, other: usize) -> Option<u32> {
        let (theirs, from) = self.begins(other)?;
        if theirs.meets != Some(agent) {
            return None;
        }
        let courses = [agent, other].map(|one| &self.courses[one]);
        let from = begins.max(from);
        let until = courses.map(AgentCourse::until).into_iter().fold(from + 1, u32::max);
        (from..until).find(|instant| courses.iter().all(|course| course.at(*instant) == Some(due.stop)))
    }

    /// Advances an agent through the errands that it can do.
    fn go_on(&mut self, agent: usize) {
        while let Some((due, from)) = self.begins(agent) {
            let errand = self.done_at[agent].len();
            let done = match (due.splits, due.meets) {
                (Some(split), _) => Some(self.courses[split.child].since),
                (None, Some(other)) => self.merged(agent, due, from, other),
                (None, None) => done_at(self.problem, ErrandPlace { agent, errand }, &self.courses[agent], from),
            };
            let Some(done) = done else { break };
            self.done_at[agent].push(done);
            due.meets.into_iter().for_each(|other| self.done_at[other].push(done));
        }
    }
}
