//! Converts an assay of a task to errands of agents, and the planned courses of agents back to courses of parts.
//!
//! Input: the order, the current cells of its parts, and the operations. Output: an [`AssayProblem`]; and, from the
//! cells of its agents, those of the parts.

use super::assay::{AgentCourse, AssayProblem, Errand, ErrandLag, ErrandPlace, SplitErrand, Traces};
use super::board::CellIndex;
use super::stage::{self, Actor, BoardGround, BoardStage};
use crate::claims::electrode_array::{
    AssayOperation, ElectrodeArrayMove, ElectrodeArrayOrder, ElectrodeArrayStop, Fluids,
};
use crate::device::electrode_array::ElectrodeCell;
use rustc_hash::FxHashMap;

/// Context in which an assay is planned.
#[derive(Clone, Copy)]
pub struct AssaySite<'a> {
    pub order: &'a ElectrodeArrayOrder,
    pub ground: &'a BoardGround<'a>,
    /// The current cells of the parts.
    pub cells: &'a [Option<ElectrodeCell>],
}

/// The cells of a part in an assay.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct PartCourse {
    /// The first instant at which it is on the board.
    pub since: usize,
    /// The part from which it splits off in the step before `since`, if it enters by a split.
    pub parent: Option<usize>,
    /// One cell per instant, from `since` until its last operation is done; afterwards it stays. Empty if it was gone
    /// before or has not entered yet.
    pub cells: Vec<ElectrodeCell>,
    /// Whether it merges into another part or leaves the board, and so is gone after the last cell.
    pub is_gone: bool,
}

impl PartCourse {
    /// Its cell at an instant: the first one before it enters, the last one after its end; `None` if it has no cells.
    pub fn at(&self, instant: usize) -> Option<ElectrodeCell> {
        self.cells.get(instant.saturating_sub(self.since)).or(self.cells.last()).copied()
    }

    /// The instant after its last one.
    pub fn until(&self) -> usize {
        self.since + self.cells.len()
    }

    /// The instant of its last move.
    pub fn last_arrival(&self) -> usize {
        let last = self.cells.last();
        self.cells.iter().rposition(|cell| Some(cell) != last).map_or(0, |before| self.since + before + 1)
    }
}

/// Errands of the parts in an assay: one entry per part, in the order of their first operations.
pub struct PartErrands {
    /// All stops of a part.
    pub moves: Vec<ElectrodeArrayMove>,
    /// By part and stop: the work that the part does there.
    works: Vec<Vec<StopWork>>,
    enters: Vec<bool>,
    is_gone: Vec<bool>,
    /// By part: the part from which it splits off, if it does.
    parents: Vec<Option<usize>>,
    /// By operation: the errand that completes it.
    ends: Vec<Option<ErrandPlace>>,
    /// By part: its index in `moves`.
    indices: FxHashMap<usize, usize>,
}

/// Work of a part at a stop.
#[derive(Debug, Clone, Default)]
struct StopWork {
    /// Steps of the board for which it stays at the stop or is mixed.
    steps: u32,
    /// Whether it goes round its mixing loop during these steps.
    mixes: bool,
    /// The part that it merges with.
    with: Option<usize>,
    /// The part that splits off from it as it moves from the previous stop to this one.
    splits: Option<usize>,
    /// Operations that must be done before.
    after: Vec<usize>,
    /// The operation; `None` at a waypoint and at the cell where it has split off.
    operation: Option<usize>,
}

impl PartErrands {
    /// Groups the operations by part, from the current cells; parts that enter the board start at their outlet.
    pub fn new(
        order: &ElectrodeArrayOrder,
        cells: &[Option<ElectrodeCell>],
        operations: &[AssayOperation],
    ) -> PartErrands {
        let (moves, works) = (Vec::new(), Vec::new());
        let (enters, is_gone, parents, ends) = (Vec::new(), Vec::new(), Vec::new(), vec![None; operations.len()]);
        let mut errands = PartErrands { moves, works, enters, is_gone, parents, ends, indices: FxHashMap::default() };
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
                    operation: Some(nth),
                };
                errands.works[index].resize(own.len() - 1, StopWork::default());
                errands.works[index].push(work);
                // Of two parts that merge, the one that remains.
                errands.ends[nth].get_or_insert(ErrandPlace { agent: index, errand: errands.works[index].len() - 1 });
                errands.enters[index] |= operation.comes;
                errands.is_gone[index] |= operation.gone() == Some(part);
            }
            if let Some(half) = operation.splits {
                let index = errands.index(half.part, operation);
                errands.moves[index].stops.push(half.stop(operation));
                errands.works[index].push(StopWork::default());
                errands.parents[index] = Some(operation.part);
            }
        }
        errands
    }

    fn index(&mut self, part: usize, operation: &AssayOperation) -> usize {
        *self.indices.entry(part).or_insert_with(|| {
            self.moves.push(ElectrodeArrayMove::alone(part, Vec::new(), operation.span));
            self.works.push(Vec::new());
            self.enters.push(false);
            self.is_gone.push(false);
            self.parents.push(None);
            self.moves.len() - 1
        })
    }

    /// A part whose mixing loop leaves the board.
    pub fn off_board(&self, order: &ElectrodeArrayOrder) -> Option<usize> {
        let [columns, rows] = order.facts.mixer.map(|side| side - 1);
        let leaves = |cell: ElectrodeCell| {
            cell.column.saturating_add(columns) > order.facts.columns
                || cell.row.saturating_add(rows) > order.facts.rows
        };
        let is_off = |(one, works): &(&ElectrodeArrayMove, &Vec<StopWork>)| {
            one.stops.iter().zip(*works).any(|(stop, work)| work.mixes && leaves(stop.cell))
        };
        self.moves.iter().zip(&self.works).find(is_off).map(|(one, _)| one.part)
    }

    /// The assay problem of a stage that was made from the moves of these operations.
    pub fn problem<'s>(
        &self,
        order: &ElectrodeArrayOrder,
        stage: &'s BoardStage,
        operations: &[AssayOperation],
    ) -> AssayProblem<'s> {
        let instance = &stage.instance;
        let of_part = |part: usize| self.indices.get(&part).copied();
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
        // Agents without an operation only yield.
        let of_agents = |flags: &[bool]| -> Vec<bool> {
            (0..instance.agents.len()).map(|agent| flags.get(agent).copied().unwrap_or(false)).collect()
        };
        let (enters, is_gone) = (of_agents(&self.enters), of_agents(&self.is_gone));
        let before = |work: &StopWork| work.after.iter().filter_map(|operation| self.ends[*operation]).collect();
        let afters = |agent: usize| {
            let works = self.works.get(agent).map_or(none.as_slice(), Vec::as_slice);
            works.iter().map(before).collect()
        };
        let afters = (0..instance.agents.len()).map(afters).collect();
        let parent = |agent: usize| self.parents.get(agent).copied().flatten().and_then(of_part);
        let parents = (0..instance.agents.len()).map(parent).collect();
        let traces = (!order.contamination.is_unheeded()).then(|| traces(order, stage, operations));
        let lag = |(nth, operation): (usize, &AssayOperation)| {
            let within = operation.within.as_ref()?;
            let after: Option<Vec<ErrandPlace>> = within.of.iter().map(|earlier| self.ends[*earlier]).collect();
            let most = u32::try_from(within.most_ns / order.facts.step_ns).unwrap_or(u32::MAX);
            Some(ErrandLag { of: self.ends[nth]?, after: after?, most })
        };
        let lags = operations.iter().enumerate().filter_map(lag).collect();
        let own = |agent: usize| {
            let works = self.works.get(agent).map_or(none.as_slice(), Vec::as_slice);
            works.iter().map(|work| work.operation).collect()
        };
        let operations = (0..instance.agents.len()).map(own).collect();
        let (releases, relaxed_schedules) = (Vec::new(), Vec::new());
        AssayProblem {
            instance,
            enters,
            parents,
            errands,
            operations,
            afters,
            lags,
            releases,
            loops,
            relaxed_schedules,
            is_gone,
            traces,
        }
    }
}

/// The contents of the agents, numbered, and which of them contaminate others.
fn traces(order: &ElectrodeArrayOrder, stage: &BoardStage, operations: &[AssayOperation]) -> Traces {
    let contamination = &order.contamination;
    let mut known: Vec<Fluids> = Vec::new();
    let mut number = |fluids: &Fluids| {
        known.iter().position(|known| known == fluids).unwrap_or_else(|| {
            known.push(fluids.clone());
            known.len() - 1
        })
    };
    // By part: its contents at its stops so far.
    let mut contents: Vec<Vec<usize>> = vec![Vec::new(); order.parts.len()];
    let mut now = contamination.before.clone();
    now.resize(order.parts.len(), Fluids::new());
    for operation in operations {
        operation.begin_fluids(&mut now);
        for part in operation.parts() {
            let stops = operation.stops.len().max(1);
            contents[part].extend(vec![number(&now[part]); stops]);
        }
        operation.end_fluids(&mut now);
        if let Some(half) = operation.splits {
            contents[half.part].push(number(&now[half.part]));
        }
    }
    let of_agent = |actor: &Actor| {
        let (own, last) = (&contents[actor.part], number(&now[actor.part]));
        // An agent that only yields has one stop.
        own.iter().copied().chain(own.is_empty().then_some(last)).chain([last]).collect()
    };
    let contents = stage.agents.iter().map(of_agent).collect();
    let does_harm = |left: &Fluids| known.iter().map(|comes| contamination.contaminates(left, comes)).collect();
    let (washes, harms) =
        (known.iter().map(|fluids| contamination.is_wash(fluids)).collect(), known.iter().map(does_harm).collect());
    Traces { contents, washes, harms }
}

/// The course of every part of the order, from the courses of the agents.
pub fn courses_of(
    order: &ElectrodeArrayOrder,
    stage: &BoardStage,
    cells: &[Option<ElectrodeCell>],
    problem: &AssayProblem,
    courses: &[AgentCourse],
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

/// The cells of the parts before an assay; a part that enters during the assay has the cell where it enters.
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
