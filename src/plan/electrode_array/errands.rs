//! An assay of a task as errands of agents, and plans of it as courses of parts.
//!
//! Input: the order, the current cells of its parts, and the operations. Output: an [`ErrandStage`], and from the cells of its
//! agents those of the parts.

use super::assay::{AgentCourse, AssayProblem, Errand, ErrandPlace, SplitErrand, Traces};
use super::board::CellIndex;
use super::stage::{self, Actor, BoardStage};
use crate::claims::electrode_array::{
    AssayOperation, AvoidedTrace, ElectrodeArrayMove, ElectrodeArrayOrder, ElectrodeArrayStop,
};
use crate::device::electrode_array::ElectrodeCell;
use std::collections::BTreeSet;

/// The cells of a part in an assay.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct PartCourse {
    /// The instant from which on it is on the board.
    pub since: usize,
    /// The part that has given it off in the step of the board before, if it comes by a split.
    pub parent: Option<usize>,
    /// At the instants 0, 1, … of the step until its last operation is done; afterwards it stays. Before `since` where it comes. Empty
    /// if it was gone before, or has not come yet.
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
    /// For each stop what the part does there.
    works: Vec<Vec<StopWork>>,
    comes: Vec<bool>,
    is_gone: Vec<bool>,
    /// The parts that give them off.
    parents: Vec<Option<usize>>,
    /// For each operation, what is done when it is.
    ends: Vec<Option<ErrandPlace>>,
    /// For each stop the fluids that the part contains until it has done what it does there, and after the last one.
    fluids: Vec<Vec<Fluids>>,
}

/// The names of fluids that a droplet contains.
type Fluids = BTreeSet<String>;

/// What a part does at a stop.
#[derive(Debug, Clone, Default)]
struct StopWork {
    /// Steps of the board for which it stays,
    steps: u32,
    /// going round its mixing loop.
    mixes: bool,
    /// The part that it merges with.
    with: Option<usize>,
    /// The part that it gives off as it comes from the stop before.
    splits: Option<usize>,
    /// The operations that are done before.
    after: Vec<usize>,
}

impl PartErrands {
    /// The operations by parts, from their current cells; for those that come, the outlet.
    pub fn new(
        order: &ElectrodeArrayOrder,
        cells: &[Option<ElectrodeCell>],
        operations: &[AssayOperation],
    ) -> PartErrands {
        let (moves, works) = (Vec::new(), Vec::new());
        let (comes, is_gone, parents, ends) = (Vec::new(), Vec::new(), Vec::new(), vec![None; operations.len()]);
        let mut errands = PartErrands { moves, works, comes, is_gone, parents, ends, fluids: Vec::new() };
        let mut fluids = fluids_before(order);
        for (nth, operation) in operations.iter().enumerate() {
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
                let work = StopWork {
                    steps: u32::try_from(operation.stay_steps(&order.facts)).unwrap_or(u32::MAX),
                    mixes: operation.mixes,
                    with: operation.parts().find(|other| *other != part),
                    splits: operation.splits.map(|half| half.part),
                    after: operation.after.clone(),
                };
                errands.works[index].resize(own.len() - 1, StopWork::default());
                errands.works[index].push(work);
                if let Some(fluid) = &operation.fluid {
                    fluids[part] = Fluids::from([fluid.clone()]);
                }
                errands.fluids[index].resize(errands.works[index].len(), fluids[part].clone());
                errands.ends[nth] = Some(ErrandPlace { agent: index, errand: errands.works[index].len() - 1 });
                errands.comes[index] |= operation.comes;
                errands.is_gone[index] |= operation.gone() == Some(part);
            }
            if let Some(half) = operation.splits {
                let index = errands.index(half.part, operation);
                errands.moves[index].stops.push(half.stop(operation));
                errands.works[index].push(StopWork::default());
                errands.parents[index] = Some(operation.part);
                fluids[half.part] = fluids[operation.part].clone();
                errands.fluids[index].push(fluids[half.part].clone());
            }
            if let Some(with) = operation.with {
                let both: Fluids = fluids[operation.part].union(&fluids[with]).cloned().collect();
                (fluids[operation.part], fluids[with]) = (both.clone(), both);
            }
        }
        for (own, one) in errands.fluids.iter_mut().zip(&errands.moves) {
            own.push(fluids[one.part].clone());
        }
        errands
    }

    fn index(&mut self, part: usize, operation: &AssayOperation) -> usize {
        self.moves.iter().position(|one| one.part == part).unwrap_or_else(|| {
            self.moves.push(ElectrodeArrayMove { part, with: None, stops: Vec::new(), span: operation.span });
            self.works.push(Vec::new());
            self.comes.push(false);
            self.is_gone.push(false);
            self.parents.push(None);
            self.fluids.push(Vec::new());
            self.moves.len() - 1
        })
    }

    /// The problem of a stage that was made of the moves.
    pub fn problem<'s>(&self, order: &ElectrodeArrayOrder, stage: &'s BoardStage) -> AssayProblem<'s> {
        let instance = &stage.instance;
        let of_part = |part: usize| self.moves.iter().position(|one| one.part == part);
        let mut loops: Vec<Vec<CellIndex>> = Vec::new();
        let mut errands = Vec::with_capacity(instance.agents.len());
        let none = [StopWork::default()];
        for (agent, asked) in instance.agents.iter().enumerate() {
            let works = self.works.get(agent).map_or(none.as_slice(), Vec::as_slice);
            let both = asked.stops.iter().zip(works).enumerate();
            let own = both.map(|(nth, (stop, work))| Errand {
                stop: *stop,
                stay: work.steps,
                meets: work.with.and_then(of_part),
                mixes: work.mixes.then(|| {
                    loops.iter().position(|known| known[0] == *stop).unwrap_or_else(|| {
                        let around = order.facts.mixing_loop(stage::cell(order, *stop));
                        loops.push(around.into_iter().map(|cell| stage::flat(order, cell)).collect());
                        loops.len() - 1
                    })
                }),
                splits: work.splits.and_then(of_part).map(|child| SplitErrand { from: asked.stops[nth - 1], child }),
            });
            errands.push(own.collect());
        }
        // Agents without an operation only step aside.
        let of_agents = |flags: &[bool]| -> Vec<bool> {
            (0..instance.agents.len()).map(|agent| flags.get(agent).copied().unwrap_or(false)).collect()
        };
        let (comes, is_gone) = (of_agents(&self.comes), of_agents(&self.is_gone));
        let before = |work: &StopWork| work.after.iter().filter_map(|operation| self.ends[*operation]).collect();
        let afters = |agent: usize| {
            let works = self.works.get(agent).map_or(none.as_slice(), Vec::as_slice);
            works.iter().map(before).collect()
        };
        let afters = (0..instance.agents.len()).map(afters).collect();
        let parent = |agent: usize| self.parents.get(agent).copied().flatten().and_then(of_part);
        let parents = (0..instance.agents.len()).map(parent).collect();
        let traces = (!order.contamination.is_unheeded()).then(|| self.traces(order, stage));
        AssayProblem { instance, comes, parents, errands, afters, loops, is_gone, traces }
    }

    /// The contents of the agents by their numbers, and which of them do harm to others. Who only steps aside contains what it did.
    fn traces(&self, order: &ElectrodeArrayOrder, stage: &BoardStage) -> Traces {
        let before = fluids_before(order);
        let mut known: Vec<Fluids> = Vec::new();
        let mut number = |fluids: &Fluids| {
            known.iter().position(|known| known == fluids).unwrap_or_else(|| {
                known.push(fluids.clone());
                known.len() - 1
            })
        };
        let of_agent = |(agent, actor): (usize, &Actor)| match self.fluids.get(agent) {
            Some(own) => own.clone(),
            None => vec![before[actor.part].clone(); 2],
        };
        let of_agents: Vec<Vec<Fluids>> = stage.agents.iter().enumerate().map(of_agent).collect();
        let contents = of_agents.iter().map(|own| own.iter().map(&mut number).collect()).collect();
        let is_wash = |fluids: &Fluids| !fluids.is_empty() && fluids.iter().all(|fluid| is_washing(order, fluid));
        let does_harm = |left: &Fluids, comes: &Fluids| {
            let is_met = |trace: &AvoidedTrace| {
                left.contains(&trace.of) && comes.contains(&trace.within) && !comes.contains(&trace.of)
            };
            order.contamination.avoided.iter().any(is_met)
        };
        let harms = known.iter().map(|left| known.iter().map(|comes| does_harm(left, comes)).collect()).collect();
        Traces { contents, washes: known.iter().map(is_wash).collect(), harms }
    }
}

/// For each part the fluids that it contains before the task.
fn fluids_before(order: &ElectrodeArrayOrder) -> Vec<Fluids> {
    let before = |part: usize| order.contamination.before.get(part).into_iter().flatten().cloned().collect();
    (0..order.parts.len()).map(before).collect()
}

fn is_washing(order: &ElectrodeArrayOrder, fluid: &str) -> bool {
    order.contamination.washes.iter().any(|wash| wash == fluid)
}

/// The cells of every part of the order, from the courses of the agents.
pub fn courses_of(
    order: &ElectrodeArrayOrder,
    stage: &BoardStage,
    cells: &[Option<ElectrodeCell>],
    (problem, courses): (&AssayProblem, &[AgentCourse]),
) -> Vec<PartCourse> {
    let stays = |cell: &Option<ElectrodeCell>| PartCourse {
        since: 0,
        parent: None,
        cells: cell.iter().copied().collect(),
        is_gone: false,
    };
    let mut motion: Vec<PartCourse> = cells.iter().map(stays).collect();
    for (agent, (actor, course)) in stage.agents.iter().zip(courses).enumerate() {
        motion[actor.part] = PartCourse {
            since: course.since as usize,
            parent: problem.parents[agent].map(|parent| stage.agents[parent].part),
            cells: course.cells.iter().map(|cell| stage::cell(order, *cell)).collect(),
            is_gone: problem.is_gone[agent],
        };
    }
    motion
}

/// The cells of the parts; for those that come in an assay, where they do.
pub fn with_new_parts(cells: &[Option<ElectrodeCell>], operations: &[AssayOperation]) -> Vec<Option<ElectrodeCell>> {
    let mut cells = cells.to_vec();
    for (part, cell) in operations.iter().filter_map(AssayOperation::new_part) {
        cells[part] = Some(cell);
    }
    cells
}

/// Updates the cells of the parts after an assay.
pub fn depart(cells: &mut [Option<ElectrodeCell>], operations: &[AssayOperation]) {
    for operation in operations {
        if let Some(stop) = operation.stops.last() {
            cells[operation.part] = Some(stop.cell);
        }
        if let Some(half) = operation.splits {
            cells[half.part] = Some(half.cell);
        }
        if let Some(gone) = operation.gone() {
            cells[gone] = None;
        }
    }
}
