//! Fallback plan of an assay where [`super::assay`] finds none: its operations one after the other, as if each were a
//! step of its own.

use super::assay::{AgentCourse, AssayPlan, AssayProblem, are_kept, are_kept_by_courses, cut_where_gone};
use super::board::{BoardAnswer, BoardCosts, BoardObjective, CellIndex};
use super::errands::{AssaySite, depart};
use super::portfolio;
use super::stage::{self, BoardGround, BoardStage};
use crate::claims::electrode_array::{AssayOperation, ElectrodeArrayMove, ElectrodeArrayOrder, ElectrodeArrayStop};
use crate::device::electrode_array::ElectrodeCell;
use crate::plan::search::SearchBudget;

/// A plan of the operations in turn, each planned as a step of its own; `None` if one of them finds no plan, or traces,
/// lags or channels are violated.
pub fn one_by_one(
    site: &AssaySite,
    operations: &[AssayOperation],
    problem: &AssayProblem,
    stage: &BoardStage,
    objective: BoardObjective,
    bounds: BoardCosts,
) -> Option<AssayPlan> {
    let agents = &problem.instance.agents;
    let mut turns = Turns {
        order: site.order,
        ground: site.ground,
        problem,
        stage,
        objective,
        now: site.cells.to_vec(),
        courses: agents.iter().map(|agent| AgentCourse { since: 0, cells: vec![agent.start] }).collect(),
    };
    for operation in operations {
        turns.operate(operation)?;
    }
    let Turns { mut courses, .. } = turns;
    trim(problem, &mut courses);
    let is_clean = problem.traces.as_ref().is_none_or(|traces| traces.harmed(problem, &courses).is_none());
    let is_sound = is_clean && are_kept(problem, &courses) && are_kept_by_courses(problem, &courses);
    is_sound.then_some(AssayPlan { courses, bounds })
}

/// State while the operations take turns.
struct Turns<'a> {
    order: &'a ElectrodeArrayOrder,
    ground: &'a BoardGround<'a>,
    problem: &'a AssayProblem<'a>,
    stage: &'a BoardStage<'a>,
    objective: BoardObjective,
    /// The current cells of all parts.
    now: Vec<Option<ElectrodeCell>>,
    courses: Vec<AgentCourse>,
}

impl Turns<'_> {
    fn agent_of(&self, part: usize) -> Option<usize> {
        self.stage.agents.iter().position(|actor| actor.part == part)
    }

    fn instants(&self) -> u32 {
        self.courses.iter().map(AgentCourse::until).max().unwrap_or(1)
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
        let stay = u32::try_from(operation.stay_steps(&self.order.facts)).ok()?;
        match self.agent_of(operation.part).filter(|_| operation.mixes) {
            Some(agent) => self.mix(agent, stay)?,
            None => self.rest(self.instants() + stay),
        }
        depart(&mut self.now, std::slice::from_ref(operation));
        self.rest(self.instants());
        Some(())
    }

    /// Keeps all parts on the board where they are until their courses have `instants` instants.
    fn rest(&mut self, instants: u32) {
        let there = self.courses.iter_mut().zip(&self.stage.agents).filter(|(_, actor)| self.now[actor.part].is_some());
        for (course, _) in there {
            let more = instants.saturating_sub(course.until()) as usize;
            course.cells.extend(course.cells.last().copied().into_iter().cycle().take(more));
        }
    }

    /// Whether a cell is clear of all parts except one.
    fn is_clear(&self, cell: ElectrodeCell, but: usize) -> bool {
        let apart = self.order.facts.separation.apart();
        let others = self.now.iter().enumerate().filter(|(part, _)| *part != but);
        others.filter_map(|(_, cell)| *cell).all(|other| other.apart(cell) >= apart)
    }

    fn come(&mut self, operation: &AssayOperation) -> Option<()> {
        let (part, outlet) = operation.new_part()?;
        self.is_clear(outlet, part).then_some(())?;
        let (instants, agent) = (self.instants(), self.agent_of(part)?);
        self.courses[agent].since = instants - 1;
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
            course.cells.extend(&path[1..]);
            let (length, last) = (course.cells.len() + longest - path.len(), path[path.len() - 1]);
            course.cells.resize(length, last);
        }
        self.now[part] = stops.last().map(|stop| stop.cell);
        self.rest(self.instants());
        Some(())
    }

    /// Splits the part, which moves to a cell.
    fn split(&mut self, operation: &AssayOperation, goes: ElectrodeCell) -> Option<()> {
        let (part, (new, comes)) = (operation.part, operation.new_part()?);
        [goes, comes].into_iter().all(|cell| self.is_clear(cell, part)).then_some(())?;
        let instants = self.instants();
        let (parent, child) = (self.agent_of(part)?, self.agent_of(new)?);
        self.courses[parent].cells.push(stage::flat(self.order, goes));
        self.courses[child].since = instants;
        (self.now[part], self.now[new]) = (Some(goes), Some(comes));
        self.rest(instants + 1);
        Some(())
    }

    /// Moves an agent round its loop for some steps, from the corner on.
    fn mix(&mut self, agent: usize, steps: u32) -> Option<()> {
        let corner = *self.courses[agent].cells.last()?;
        let around = self.problem.loops.iter().find(|around| around[0] == corner)?;
        let part = self.stage.agents[agent].part;
        let is_clear = |cell: &CellIndex| self.is_clear(stage::cell(self.order, *cell), part);
        let is_open = |cell: &CellIndex| !self.problem.instance.board.is_blocked(*cell);
        around.iter().all(|cell| is_clear(cell) && is_open(cell)).then_some(())?;
        self.courses[agent].cells.extend((1..=steps as usize).map(|step| around[step % around.len()]));
        self.rest(self.instants());
        Some(())
    }
}

/// Cuts courses after the instant at which all errands are done and nothing moves any more. A later operation may be
/// done earlier than in its turn, while other parts were at work.
fn trim(problem: &AssayProblem, courses: &mut [AgentCourse]) {
    let done_by = cut_where_gone(problem, courses);
    for (course, done_at) in courses.iter_mut().zip(done_by) {
        course.end_at(done_at.last().copied().unwrap_or(0));
    }
}
