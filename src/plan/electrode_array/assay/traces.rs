//! Traces that agents leave on the cells that they visit, and the contamination of other agents by them.
//!
//! Contents are numbered: the contents of an agent after each of its errands are known beforehand, whatever the plan.

use super::{AgentCourse, AssayProblem, replay};
use crate::plan::electrode_array::board::CellIndex;

/// The contents of agents, by their numbers.
#[derive(Debug, Clone)]
pub struct Traces {
    /// By agent and number of errands done; one entry more than it has errands.
    pub contents: Vec<Vec<usize>>,
    /// By content: whether it is a wash, which removes traces and leaves none.
    pub washes: Vec<bool>,
    /// By content left and content that arrives: whether the first contaminates the second.
    pub harms: Vec<Vec<bool>>,
}

/// A visit of an agent to a cell, both instants included, with one content.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Touch {
    pub agent: usize,
    pub from: u32,
    pub to: u32,
    pub content: usize,
}

impl Traces {
    /// The visits of a course to cells, in order. `done_at` has the instants of the errands done so far.
    pub fn touches(&self, agent: usize, course: &AgentCourse, done_at: &[u32]) -> Vec<(CellIndex, Touch)> {
        let contents = &self.contents[agent];
        let mut touches: Vec<(CellIndex, Touch)> = Vec::new();
        let mut done = 0;
        for (instant, cell) in (course.since..).zip(&course.cells) {
            while done_at.get(done).is_some_and(|at| *at <= instant) {
                done += 1;
            }
            let content = contents[done.min(contents.len() - 1)];
            match touches.last_mut() {
                Some((last, touch)) if last == cell && touch.content == content => touch.to = instant,
                _ => touches.push((*cell, Touch { agent, from: instant, to: instant, content })),
            }
        }
        touches
    }

    /// The first agent that is contaminated among visits of one cell in order, by a trace or by an agent that is there
    /// at the same time.
    fn harmed_here<'t>(&self, touches: impl Iterator<Item = &'t Touch>) -> Option<usize> {
        let mut left: Vec<&Touch> = Vec::new();
        for touch in touches {
            if self.washes[touch.content] {
                left.clear();
                continue;
            }
            if left.iter().any(|left| self.harms[left.content][touch.content]) {
                return Some(touch.agent);
            }
            // An agent that leaves the cell as this one is dispensed is there with it.
            let is_with = |other: &&&Touch| other.to >= touch.from && self.harms[touch.content][other.content];
            if let Some(other) = left.iter().find(is_with) {
                return Some(other.agent);
            }
            left.push(touch);
        }
        None
    }

    /// An agent that is contaminated; `None` if none is.
    pub fn harmed(&self, problem: &AssayProblem, courses: &[AgentCourse]) -> Option<usize> {
        let done_at = replay::done_by(problem, courses);
        let mut touches: Vec<(CellIndex, Touch)> = Vec::new();
        for (agent, (course, done_at)) in courses.iter().zip(&done_at).enumerate() {
            touches.extend(self.touches(agent, course, done_at));
        }
        // A wash removes traces at the instant at which it arrives.
        touches.sort_by_key(|(cell, touch)| (*cell, touch.from, !self.washes[touch.content], touch.agent));
        let mut cells = touches.chunk_by(|(one, _), (other, _)| one == other);
        cells.find_map(|of_cell| self.harmed_here(of_cell.iter().map(|(_, touch)| touch)))
    }

    /// Appends the instants `from..to` at which a content may not visit a cell: others have left a trace that
    /// contaminates it, or will be contaminated by the trace that it would leave. `touches` are the visits of the cell,
    /// in order.
    pub fn append_closed(&self, touches: &[Touch], content: usize, closed: &mut Vec<(u32, u32)>) {
        if self.washes[content] {
            return;
        }
        let mut washed = None;
        for (nth, touch) in touches.iter().enumerate() {
            if self.washes[touch.content] {
                washed = Some(touch.from);
                continue;
            }
            if self.harms[touch.content][content] {
                let next = touches[nth..].iter().find(|later| self.washes[later.content]);
                closed.push((touch.from, next.map_or(u32::MAX, |wash| wash.from)));
            }
            if self.harms[content][touch.content] {
                closed.push((washed.map_or(0, |washed: u32| washed + 1), touch.to + 1));
            }
        }
    }
}
