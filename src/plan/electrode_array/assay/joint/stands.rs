//! Cells and progress of the agents of a small assay, and their next errands.

use super::super::{AssayProblem, Errand, ErrandPlace};
use crate::plan::electrode_array::board::CellIndex;

/// State of one agent.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum JointStand {
    /// It has not entered the board yet.
    NotEntered,
    There(AgentStand),
    Gone,
}

impl JointStand {
    /// Its cell and progress, if it is on the board.
    pub fn there(self) -> Option<AgentStand> {
        if let JointStand::There(stand) = self { Some(stand) } else { None }
    }
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct AgentStand {
    pub cell: CellIndex,
    /// Errands done.
    pub done: u32,
    /// Steps for which it has been at the stop of its next errand or in its loop, at most as many as the errand takes.
    pub rested: u32,
}

/// An agent at its start.
pub fn at_start(problem: &AssayProblem, agent: usize) -> AgentStand {
    AgentStand { cell: problem.instance.agents[agent].start, done: 0, rested: 0 }
}

pub fn start(problem: &AssayProblem, agent: usize) -> JointStand {
    JointStand::There(at_start(problem, agent))
}

/// The errand that an agent is to do next.
pub fn due(problem: &AssayProblem, stands: &[JointStand], agent: usize) -> Option<Errand> {
    problem.errands[agent].get(stands[agent].there()?.done as usize).copied()
}

/// Whether all predecessors of an agent's next errand are done.
pub fn may_begin(problem: &AssayProblem, stands: &[JointStand], agent: usize) -> bool {
    let errand = match stands[agent] {
        JointStand::NotEntered => 0,
        JointStand::There(stand) => stand.done as usize,
        JointStand::Gone => return true,
    };
    problem.afters[agent].get(errand).is_none_or(|before| before.iter().all(|place| is_done(stands, place)))
}

/// Whether an errand is done.
pub fn is_done(stands: &[JointStand], place: &ErrandPlace) -> bool {
    match stands[place.agent] {
        JointStand::NotEntered => false,
        JointStand::There(stand) => stand.done as usize > place.errand,
        JointStand::Gone => true,
    }
}

/// The agent with which `agent` merges next, and the cell, if the errands of both are this merge and `agent` may begin
/// it.
pub fn meeting(problem: &AssayProblem, stands: &[JointStand], agent: usize) -> Option<(usize, CellIndex)> {
    let own = due(problem, stands, agent)?;
    let other = own.meets.filter(|_| may_begin(problem, stands, agent))?;
    let theirs = due(problem, stands, other)?;
    (theirs.meets == Some(agent) && theirs.stop == own.stop).then_some((other, own.stop))
}

/// Does all errands that can be done at the agents' cells.
pub fn settle(problem: &AssayProblem, stands: &mut [JointStand]) {
    let ready = |stands: &[JointStand], agent: usize| {
        let own = due(problem, stands, agent)?;
        let stand = stands[agent].there()?;
        if stand.cell != own.stop
            || stand.rested < own.stay
            || own.splits.is_some()
            || !may_begin(problem, stands, agent)
        {
            return None;
        }
        match own.meets {
            None => Some((agent, None)),
            Some(_) => {
                let (other, stop) = meeting(problem, stands, agent)?;
                stands[other].there().is_some_and(|theirs| theirs.cell == stop).then_some((agent, Some(other)))
            }
        }
    };
    while let Some((agent, other)) = (0..stands.len()).find_map(|agent| ready(stands, agent)) {
        for one in std::iter::once(agent).chain(other) {
            let JointStand::There(stand) = &mut stands[one] else { continue };
            (stand.done, stand.rested) = (stand.done + 1, 0);
            if problem.is_gone[one] && stand.done as usize == problem.errands[one].len() {
                stands[one] = JointStand::Gone;
            }
        }
    }
    for agent in 0..stands.len() {
        let stay = due(problem, stands, agent)
            .filter(|own| own.mixes.is_some() || stands[agent].there().is_some_and(|stand| stand.cell == own.stop))
            .map_or(0, |own| own.stay);
        if let JointStand::There(stand) = &mut stands[agent] {
            stand.rested = stand.rested.min(stay);
        }
    }
}
