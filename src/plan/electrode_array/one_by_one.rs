//! The operations of an assay one after the other, which is what they would be as steps of their own: a plan where [`super::assay`] finds
//! none.

use super::assay::{AgentCourse, AssayPlan, AssayProblem, all_done_at, are_kept};
use super::board::{BoardAnswer, BoardCosts, BoardObjective, CellIndex};
use super::errands::depart;
use super::portfolio;
use super::stage::{self, BoardGround, BoardStage};
use crate::claims::electrode_array::{AssayOperation, ElectrodeArrayMove, ElectrodeArrayOrder, ElectrodeArrayStop};
use crate::device::electrode_array::ElectrodeCell;
use crate::plan::search::SearchBudget;

/// A plan of the operations in turn, each with the best plan of a step of its own; `None` if one of them has none.
pub fn one_by_one(
    (order, ground): (&ElectrodeArrayOrder, &BoardGround),
    cells: &[Option<ElectrodeCell>],
    (operations, problem, stage): (&[AssayOperation], &AssayProblem, &BoardStage),
    (objective, bounds): (BoardObjective, BoardCosts),
) -> Option<AssayPlan> {
    let agents = &problem.instance.agents;
    let mut turns = Turns {
        order,
        ground,
        problem,
        stage,
        objective,
        now: cells.to_vec(),
        since: vec![0; agents.len()],
        courses: agents.iter().map(|agent| vec![agent.start]).collect(),
    };
    for operation in operations {
        turns.operate(operation)?;
    }
    let Turns { since, mut courses, .. } = turns;
    trim(problem, &since, &mut courses);
    let courses: Vec<AgentCourse> =
        since.into_iter().zip(courses).map(|(since, cells)| AgentCourse { since, cells }).collect();
    let is_clean = problem.traces.as_ref().is_none_or(|traces| traces.harmed(problem, &courses).is_none());
    (is_clean && are_kept(problem, &courses)).then_some(AssayPlan { courses, bounds })
}

/// The courses of the agents while their operations take turns.
struct Turns<'a> {
    order: &'a ElectrodeArrayOrder,
    ground: &'a BoardGround<'a>,
    problem: &'a AssayProblem<'a>,
    stage: &'a BoardStage<'a>,
    objective: BoardObjective,
    /// The current cells of all parts.
    now: Vec<Option<ElectrodeCell>>,
    since: Vec<u32>,
    courses: Vec<Vec<CellIndex>>,
}

impl Turns<'_> {
    fn agent_of(&self, part: usize) -> Option<usize> {
        self.stage.agents.iter().position(|actor| actor.part == part)
    }

    fn instants(&self) -> usize {
        self.courses.iter().map(Vec::len).max().unwrap_or(1)
    }

    fn operate(&mut self, operation: &AssayOperation) -> Option<()> {
        let (stops, last) = match (operation.splits, operation.stops.as_slice()) {
            (Some(_), [stops @ .., last]) => (stops, Some(last.cell)),
            (_, stops) => (stops, None),
        };
        if operation.comes {
            self.come(operation)?;
        } else if !stops.is_empty() {
            self.travel(operation, stops)?;
        }
        if let Some(goes) = last {
            self.split(operation, goes)?;
        }
        let stay = usize::try_from(operation.stay_steps(&self.order.facts)).ok()?;
        match self.agent_of(operation.part).filter(|_| operation.mixes) {
            Some(agent) => self.mix(agent, stay)?,
            None => self.rest(self.instants() + stay),
        }
        depart(&mut self.now, std::slice::from_ref(operation));
        self.rest(self.instants());
        Some(())
    }

    /// All parts that are on the board stay where they are until they have some number of instants.
    fn rest(&mut self, instants: usize) {
        let there = self.courses.iter_mut().zip(&self.stage.agents).filter(|(_, actor)| self.now[actor.part].is_some());
        there.for_each(|(course, _)| course.resize(instants.max(course.len()), course[course.len() - 1]));
    }

    /// Whether a cell is clear of all parts but one.
    fn is_clear(&self, cell: ElectrodeCell, but: usize) -> bool {
        let apart = self.order.facts.separation.apart();
        let others = self.now.iter().enumerate().filter(|(part, _)| *part != but);
        others.filter_map(|(_, cell)| *cell).all(|other| other.apart(cell) >= apart)
    }

    fn come(&mut self, operation: &AssayOperation) -> Option<()> {
        let (part, outlet) = operation.new_part()?;
        self.is_clear(outlet, part).then_some(())?;
        let (instants, agent) = (self.instants(), self.agent_of(part)?);
        self.since[agent] = instants as u32 - 1;
        self.courses[agent].resize(instants, self.problem.instance.agents[agent].start);
        self.now[part] = Some(outlet);
        Some(())
    }

    fn travel(&mut self, operation: &AssayOperation, stops: &[ElectrodeArrayStop]) -> Option<()> {
        let (part, with) = (operation.part, operation.with);
        let moves = [ElectrodeArrayMove { with, ..ElectrodeArrayMove::alone(part, stops.to_vec(), operation.span) }];
        let step = BoardStage::new(self.order, self.ground, &self.now, &moves);
        let budget = SearchBudget::of(self.order.planner.expansions);
        let BoardAnswer::Found(plan) = portfolio::solve(&step.instance, self.objective, None, budget) else {
            return None;
        };
        let longest = plan.paths.iter().map(Vec::len).max().unwrap_or(1);
        for (actor, path) in step.agents.iter().zip(&plan.paths) {
            let Some(course) = self.agent_of(actor.part).map(|agent| &mut self.courses[agent]) else { continue };
            course.extend(&path[1..]);
            let (length, last) = (course.len() + longest - path.len(), path[path.len() - 1]);
            course.resize(length, last);
        }
        self.now[part] = stops.last().map(|stop| stop.cell);
        self.rest(self.instants());
        Some(())
    }

    /// The part is pulled apart, and goes to a cell.
    fn split(&mut self, operation: &AssayOperation, goes: ElectrodeCell) -> Option<()> {
        let (part, (new, comes)) = (operation.part, operation.new_part()?);
        [goes, comes].into_iter().all(|cell| self.is_clear(cell, part)).then_some(())?;
        let instants = self.instants();
        let (parent, child) = (self.agent_of(part)?, self.agent_of(new)?);
        self.courses[parent].push(stage::flat(self.order, goes));
        self.since[child] = instants as u32;
        self.courses[child].resize(instants + 1, self.problem.instance.agents[child].start);
        (self.now[part], self.now[new]) = (Some(goes), Some(comes));
        self.rest(instants + 1);
        Some(())
    }

    /// An agent goes round its loop for some steps, from the corner on.
    fn mix(&mut self, agent: usize, steps: usize) -> Option<()> {
        let corner = *self.courses[agent].last()?;
        let around = self.problem.loops.iter().find(|around| around[0] == corner)?;
        let part = self.stage.agents[agent].part;
        let is_clear = |cell: &CellIndex| self.is_clear(stage::cell(self.order, *cell), part);
        let is_open = |cell: &CellIndex| !self.problem.instance.board.is_blocked(*cell);
        around.iter().all(|cell| is_clear(cell) && is_open(cell)).then_some(())?;
        self.courses[agent].extend((1..=steps).map(|step| around[step % around.len()]));
        self.rest(self.instants());
        Some(())
    }
}

/// Cuts courses after the instant at which all errands are done and nothing moves any more: while others were at work, a part may
/// have done an operation that comes later.
fn trim(problem: &AssayProblem, since: &[u32], courses: &mut [Vec<CellIndex>]) {
    let cells: Vec<&[CellIndex]> = courses.iter().map(Vec::as_slice).collect();
    let done_at = all_done_at(problem, since, &cells);
    for (course, done_at) in courses.iter_mut().zip(done_at) {
        let end = done_at.last().copied().unwrap_or(0) as usize;
        let moved = course.windows(2).rposition(|pair| pair[0] != pair[1]).map_or(0, |before| before + 1);
        course.truncate(end.max(moved) + 1);
    }
}
