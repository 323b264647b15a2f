//! An assay of a task as errands of agents, and plans of it as courses of parts.
//!
//! Input: the order, the current cells of its parts, and the operations. Output: an [`ErrandStage`], and from the cells of its
//! agents those of the parts. Where [`super::assay`] finds no plan, the operations are planned one after the other, which is what
//! they would be as steps of their own.

use super::assay::{AgentCourse, AssayPlan, AssayProblem, Errand};
use super::board::{BoardAnswer, BoardCosts, BoardObjective, CellIndex, Instance};
use super::portfolio;
use super::stage::{self, BoardGround, BoardStage};
use crate::claims::electrode_array::{AssayOperation, ElectrodeArrayMove, ElectrodeArrayOrder, ElectrodeArrayStop};
use crate::device::electrode_array::ElectrodeCell;
use crate::plan::search::SearchBudget;

/// The cells of a part in an assay.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct PartCourse {
    /// The instant from which on it is on the board.
    pub since: usize,
    /// At the instants 0, 1, … of the step until its last operation is done; afterwards it stays. Before `since` its outlet. Empty if it
    /// was gone before, or has not come yet.
    pub cells: Vec<ElectrodeCell>,
    /// Whether it merges with another part or leaves the board, and is gone after the last cell.
    pub is_gone: bool,
}

impl PartCourse {
    /// The instant at which it comes to its last cell.
    pub fn last_arrival(&self) -> usize {
        let last = self.cells.last();
        self.cells.iter().rposition(|cell| Some(cell) != last).map_or(0, |before| before + 1)
    }
}

/// What each part does in an assay: one entry for each part, in the order of their first operations.
pub struct PartErrands {
    /// All stops of a part.
    pub moves: Vec<ElectrodeArrayMove>,
    /// For each stop the steps of the board for which the part stays, and the part that it merges with.
    stays: Vec<Vec<(u32, Option<usize>)>>,
    comes: Vec<bool>,
    is_gone: Vec<bool>,
}

impl PartErrands {
    /// The operations by parts, from their current cells; for those that come, the outlet.
    pub fn new(
        order: &ElectrodeArrayOrder,
        cells: &[Option<ElectrodeCell>],
        operations: &[AssayOperation],
    ) -> PartErrands {
        let mut errands = PartErrands { moves: Vec::new(), stays: Vec::new(), comes: Vec::new(), is_gone: Vec::new() };
        for operation in operations {
            for part in operation.parts() {
                let Some(start) = cells[part] else { continue };
                let index = errands.index(part, operation);
                let own = &mut errands.moves[index].stops;
                match operation.stops.is_empty() {
                    true => {
                        let here = own.last().map_or(start, |stop| stop.cell);
                        own.push(ElectrodeArrayStop { cell: here, span: operation.span, origin: None });
                    }
                    false => own.extend(operation.stops.iter().cloned()),
                }
                let steps = operation.stay_ns.div_ceil(order.facts.step_ns);
                let other = operation.parts().find(|other| *other != part);
                errands.stays[index].resize(own.len() - 1, (0, None));
                errands.stays[index].push((u32::try_from(steps).unwrap_or(u32::MAX), other));
                errands.comes[index] |= operation.comes;
                errands.is_gone[index] |= operation.gone() == Some(part);
            }
        }
        errands
    }

    fn index(&mut self, part: usize, operation: &AssayOperation) -> usize {
        self.moves.iter().position(|one| one.part == part).unwrap_or_else(|| {
            self.moves.push(ElectrodeArrayMove { part, with: None, stops: Vec::new(), span: operation.span });
            self.stays.push(Vec::new());
            self.comes.push(false);
            self.is_gone.push(false);
            self.moves.len() - 1
        })
    }

    /// The problem of a stage that was made of the moves.
    pub fn problem<'s>(&self, instance: &'s Instance) -> AssayProblem<'s> {
        let of_part = |part: usize| self.moves.iter().position(|one| one.part == part);
        let errands = instance.agents.iter().enumerate().map(|(agent, asked)| {
            let stays = self.stays.get(agent).map_or([(0, None)].as_slice(), Vec::as_slice);
            let both = asked.stops.iter().zip(stays);
            both.map(|(stop, (stay, with))| Errand { stop: *stop, stay: *stay, meets: with.and_then(of_part) })
                .collect()
        });
        // Agents without an operation only step aside.
        let of_agents = |flags: &[bool]| -> Vec<bool> {
            (0..instance.agents.len()).map(|agent| flags.get(agent).copied().unwrap_or(false)).collect()
        };
        let (comes, is_gone) = (of_agents(&self.comes), of_agents(&self.is_gone));
        AssayProblem { instance, comes, errands: errands.collect(), is_gone }
    }
}

/// The cells of every part of the order, from the courses of the agents.
pub fn courses_of(
    order: &ElectrodeArrayOrder,
    stage: &BoardStage,
    cells: &[Option<ElectrodeCell>],
    (problem, courses): (&AssayProblem, &[AgentCourse]),
) -> Vec<PartCourse> {
    let stays =
        |cell: &Option<ElectrodeCell>| PartCourse { since: 0, cells: cell.iter().copied().collect(), is_gone: false };
    let mut motion: Vec<PartCourse> = cells.iter().map(stays).collect();
    for ((actor, course), is_gone) in stage.agents.iter().zip(courses).zip(&problem.is_gone) {
        let cells = course.cells.iter().map(|cell| stage::cell(order, *cell)).collect();
        motion[actor.part] = PartCourse { since: course.since as usize, cells, is_gone: *is_gone };
    }
    motion
}

/// The cells of the parts, with those of the outlets for parts that come in an assay.
pub fn with_outlets(cells: &[Option<ElectrodeCell>], operations: &[AssayOperation]) -> Vec<Option<ElectrodeCell>> {
    let mut cells = cells.to_vec();
    for operation in operations.iter().filter(|operation| operation.comes) {
        cells[operation.part] = operation.stops.first().map(|outlet| outlet.cell);
    }
    cells
}

/// Updates the cells of the parts after an assay.
pub fn depart(cells: &mut [Option<ElectrodeCell>], operations: &[AssayOperation]) {
    for operation in operations {
        if let Some(stop) = operation.stops.last() {
            cells[operation.part] = Some(stop.cell);
        }
        if let Some(gone) = operation.gone() {
            cells[gone] = None;
        }
    }
}

/// The operations one after the other, each with the best plan of a step of its own; `None` if one of them has none.
pub fn one_by_one(
    (order, ground): (&ElectrodeArrayOrder, &BoardGround),
    cells: &[Option<ElectrodeCell>],
    (operations, problem, stage): (&[AssayOperation], &AssayProblem, &BoardStage),
    (objective, bounds): (BoardObjective, BoardCosts),
) -> Option<AssayPlan> {
    let agent_of = |part: usize| stage.agents.iter().position(|actor| actor.part == part);
    let mut now = cells.to_vec();
    let mut since = vec![0; problem.instance.agents.len()];
    let mut courses: Vec<Vec<CellIndex>> = problem.instance.agents.iter().map(|agent| vec![agent.start]).collect();
    for operation in operations {
        if let Some(outlet) = operation.stops.first().filter(|_| operation.comes) {
            let apart = order.facts.separation.apart();
            if now.iter().flatten().any(|cell| cell.apart(outlet.cell) < apart) {
                return None;
            }
            let instants = courses.iter().map(Vec::len).max().unwrap_or(1);
            if let Some(agent) = agent_of(operation.part) {
                since[agent] = instants as u32 - 1;
                courses[agent].resize(instants, problem.instance.agents[agent].start);
            }
        } else if !operation.stops.is_empty() {
            let (part, with) = (operation.part, operation.with);
            let moves = [ElectrodeArrayMove { part, with, stops: operation.stops.clone(), span: operation.span }];
            let step = BoardStage::new(order, ground, &now, &moves);
            let budget = SearchBudget::of(order.planner.expansions);
            let BoardAnswer::Found(plan) = portfolio::solve(&step.instance, objective, None, budget) else {
                return None;
            };
            let longest = plan.paths.iter().map(Vec::len).max().unwrap_or(1);
            for (actor, path) in step.agents.iter().zip(&plan.paths) {
                let Some(course) = agent_of(actor.part).map(|agent| &mut courses[agent]) else { continue };
                course.extend(&path[1..]);
                let (length, last) = (course.len() + longest - path.len(), path[path.len() - 1]);
                course.resize(length, last);
            }
        }
        let stay = u32::try_from(operation.stay_ns.div_ceil(order.facts.step_ns)).unwrap_or(u32::MAX) as usize;
        let lasts = courses.iter().map(Vec::len).max().unwrap_or(1) + stay;
        depart(&mut now, std::slice::from_ref(operation));
        let left = courses.iter_mut().zip(&stage.agents).filter(|(_, actor)| now[actor.part].is_some());
        left.for_each(|(course, _)| course.resize(lasts, course[course.len() - 1]));
    }
    trim(problem, &since, &mut courses);
    let courses = since.into_iter().zip(courses).map(|(since, cells)| AgentCourse { since, cells }).collect();
    Some(AssayPlan { courses, bounds })
}

/// Cuts courses after the instant at which all errands are done and nothing moves any more: while others were at work, a part may
/// have done an operation that comes later.
fn trim(problem: &AssayProblem, since: &[u32], courses: &mut [Vec<CellIndex>]) {
    let mut ends: Vec<usize> = vec![0; courses.len()];
    for (agent, course) in courses.iter().enumerate() {
        let (mut done, mut stays_since) = (0, None);
        for (instant, cell) in course.iter().enumerate().skip(since[agent] as usize) {
            while let Some(errand) = problem.errands[agent].get(done) {
                if *cell != errand.stop {
                    stays_since = None;
                    break;
                }
                let there = *stays_since.get_or_insert(instant);
                let together = errand
                    .meets
                    .is_none_or(|other| courses[other].get(instant).or(courses[other].last()) == Some(cell));
                if instant - there < errand.stay as usize || !together {
                    break;
                }
                (done, stays_since, ends[agent]) = (done + 1, None, instant);
            }
            if instant > 0 && course[instant - 1] != *cell {
                ends[agent] = ends[agent].max(instant);
            }
        }
    }
    courses.iter_mut().zip(ends).for_each(|(course, end)| course.truncate(end + 1));
}
