//! One job of an electrode array: its steps are planned one after the other, from the current cells of the parts.
//!
//! After each step every part is on a cell that the program names: its goal, or the cell where it was before. So the
//! optimal plans of the steps form the optimal plan of the job, and its bounds are the sums of theirs. Only limits
//! couple the steps; where the best plan breaks a limit, [`limited`] chooses among the plans of each step.

use super::assay::NoAssayPlan;
use super::board::{self, BoardAnswer, BoardCosts, BoardObjective, BoardPlan, NoBoardPlan, Paths};
use super::errands::{self, AssaySite};
use super::exact;
use super::limits;
use super::limits::labels::{BoardFigures, PlanLimits};
use super::limits::limited::{self, AskedStep, PlanFront, UNLIMITED};
use super::motion::{ElectrodeArrayMotion, ElectrodeArrayStepMotion};
use super::places::arranged::{self, NoArrangement, PlacedPlan};
use super::portfolio;
use super::published::Heuristic;
use super::reasons::remedy::{CutOffPart, RemedyOutcome};
use super::reasons::{torn, why};
use super::stage::{self, BoardGround, BoardStage, CellBlocker};
use super::standings::{self, BoardStandings};
use super::teams::assigned;
use super::teams::loose::LooseParts;
use super::teams::shared::{self, SharedGoals};
use crate::claims::electrode_array::{
    AssayOperation, ElectrodeArrayAction, ElectrodeArrayMethod, ElectrodeArrayObjective, ElectrodeArrayOrder,
    ElectrodeArrayStep,
};
use crate::claims::{Job, Requirement};
use crate::device::MAX_EXPANSIONS;
use crate::device::electrode_array::{ElectrodeArrayOutcome, ElectrodeCell};
use crate::diagnostic::{CellRun, Code, Diagnostic, Reach, ReachExtent, Sink};
use crate::plan::errors::{self, Removal};
use crate::plan::requirements::{Kept, KnownLimit, require};
use crate::plan::search::{Meter, SearchAnswer, SearchBudget};
use crate::plan::{KindPlanner, Optimality, Plan};
use crate::quantity::count;
use crate::source::Span;
use std::collections::BTreeMap;

impl KindPlanner for ElectrodeArrayOrder {
    /// Whether the plan chooses which part of a team goes to which goal, or where an operation takes place. Parts that
    /// yield return to their cells.
    fn chooses_its_end(&self) -> bool {
        self.steps.iter().any(|step| match &step.action {
            ElectrodeArrayAction::Move(moves) => moves.iter().any(|one| one.team.is_some()),
            ElectrodeArrayAction::Assay(operations) => operations.iter().any(|one| !one.among.is_empty()),
            ElectrodeArrayAction::Wait(_) => false,
        })
    }
}

/// A plan for a job; `None` after an error was pushed.
pub fn plan(
    job: &Job,
    order: &ElectrodeArrayOrder,
    standing: &mut BoardStandings,
    sink: &mut Sink,
) -> Option<Plan<ElectrodeArrayMotion>> {
    let start = standing.before(job, order);
    sink.push_if_some(standings::on_obstacle(job, order, &start))?;
    let (plan, end) = planned(job, order, start, true, sink);
    standing.leave(job, order, end);
    plan
}

/// Returns a plan, if one is found, and the cells of the parts after the job.
fn planned(
    job: &Job,
    order: &ElectrodeArrayOrder,
    start: Vec<Option<ElectrodeCell>>,
    may_remedy: bool,
    sink: &mut Sink,
) -> (Option<Plan<ElectrodeArrayMotion>>, Vec<Option<ElectrodeCell>>) {
    let ground = BoardGround::new(order);
    let (cells, before) = (start.clone(), sink.errors());
    let mut tasks = Tasks {
        job,
        order,
        ground: &ground,
        start: &start,
        cells,
        loose: LooseParts::default(),
        known: Vec::new(),
        assays: Vec::new(),
        stranded: None,
        may_remedy,
        sink,
    };
    let steps: Vec<Option<ElectrodeArrayStepMotion>> = order.steps.iter().map(|step| tasks.step(step)).collect();
    let (known, assays, end, stranded) = (tasks.known, tasks.assays, tasks.cells, tasks.stranded);
    let bounds = limits::total(known.iter().map(|(_, bounds)| *bounds).chain(assays.iter().copied()));
    let Some(steps) = steps.into_iter().collect::<Option<Vec<ElectrodeArrayStepMotion>>>() else {
        let alone = stranded.filter(|_| sink.errors() == before);
        let others = if alone.is_some() && may_remedy { assigned::orders(order) } else { Vec::new() };
        if let Some((plan, end)) = best_assigned(job, order, &others, bounds, start) {
            return (Some(plan), end);
        }
        stranded.into_iter().for_each(|step| sink.push(errors::not_from_here(step, others.len())));
        return (None, end);
    };
    let motion = ElectrodeArrayMotion { start, steps };
    if order.planner.method == ElectrodeArrayMethod::Portfolio && assays.is_empty() {
        return (within_limits(job, order, &ground, motion, &known, sink), end);
    }
    let plan = finished(order, motion, bounds, None);
    // The bounds of an assay hold whatever the limits are; a published plan is not asked for bounds.
    let least = |requirement: &Requirement| match assays.is_empty() {
        true => KnownLimit::default(),
        false => KnownLimit { least: limits::least(order, &requirement.outcome, bounds), ..KnownLimit::default() },
    };
    let mut broken = Sink::default();
    let kept = require(job, &plan, &mut |requirement| least(requirement), &mut broken);
    if kept == Kept::Yes {
        return (Some(plan), end);
    }
    let fewest = (!assays.is_empty()).then(|| in_fewest_steps(job, order, plan.motion.start, bounds)).flatten();
    if let Some((plan, end)) = fewest {
        return (Some(plan), end);
    }
    sink.append(broken);
    (None, end)
}

/// The cheapest plan among orders in which interchangeable parts have goals of their own, and the cells of the parts
/// after it. `bounds` hold for all of these orders.
fn best_assigned(
    job: &Job,
    order: &ElectrodeArrayOrder,
    others: &[ElectrodeArrayOrder],
    bounds: BoardCosts,
    start: Vec<Option<ElectrodeCell>>,
) -> Option<(Plan<ElectrodeArrayMotion>, Vec<Option<ElectrodeCell>>)> {
    let plans = others.iter().filter_map(|other| {
        let (plan, end) = planned(job, other, start.clone(), false, &mut Sink::default());
        Some((finished(order, plan?.motion, bounds, None), end))
    });
    plans.min_by(|(one, _), (other, _)| one.cost.total_cmp(&other.cost))
}

/// The plan of the fewest steps, and the cells of the parts after it, if it keeps the limits. Tried where the plan of
/// the least sum of costs breaks them.
fn in_fewest_steps(
    job: &Job,
    order: &ElectrodeArrayOrder,
    start: Vec<Option<ElectrodeCell>>,
    bounds: BoardCosts,
) -> Option<(Plan<ElectrodeArrayMotion>, Vec<Option<ElectrodeCell>>)> {
    if order.objective != ElectrodeArrayObjective::SumOfCosts {
        return None;
    }
    let fewest_steps = ElectrodeArrayOrder { objective: ElectrodeArrayObjective::Makespan, ..order.clone() };
    let (plan, end) = planned(job, &fewest_steps, start, false, &mut Sink::default());
    Some((finished(order, plan?.motion, bounds, None), end))
}

/// The plan that is best without limits, if it keeps them; otherwise the best plan found that does.
fn within_limits(
    job: &Job,
    order: &ElectrodeArrayOrder,
    ground: &BoardGround,
    mut motion: ElectrodeArrayMotion,
    known: &[(Paths, BoardCosts)],
    sink: &mut Sink,
) -> Option<Plan<ElectrodeArrayMotion>> {
    let limits = limits::of(order, &job.requirements);
    let bounds = limits::total(known.iter().map(|(_, bounds)| *bounds));
    let figures = limits::figures(known.iter().map(|(paths, _)| paths));
    if !limits::breaks(figures, limits) {
        return Some(finished(order, motion, bounds, None));
    }
    let objective = BoardObjective::of(order.objective);
    let is_only = known.len() == 1;
    let fronts = fronts(order, ground, &motion.start, known, limits, is_only);
    match limited::choose(&fronts, limits, objective) {
        limited::Chosen::Kept { paths, bound } => {
            let mut moved = paths.iter();
            stage::each_stage(order, ground, &motion.start.clone(), |index, stage, cells| {
                if let Some(paths) = moved.next() {
                    motion.steps[index] = ElectrodeArrayStepMotion::Paths(stage::moves_of(order, stage, cells, paths));
                }
            });
            Some(finished(order, motion, bounds, Some(bound)))
        }
        limited::Chosen::Broken { is_proven } => {
            let wider = self::fronts(order, ground, &motion.start, known, limits::lifted(limits), false);
            sink.push(limits::broken(order, &job.requirements, [&fronts, &wider], is_proven));
            None
        }
    }
}

/// The plans of each step that matter under the limits. One plan is enough if only one step moves parts.
fn fronts(
    order: &ElectrodeArrayOrder,
    ground: &BoardGround,
    start: &[Option<ElectrodeCell>],
    known: &[(Paths, BoardCosts)],
    limits: PlanLimits,
    is_only: bool,
) -> Vec<PlanFront> {
    let mut moves = Vec::with_capacity(known.len());
    stage::each_stage(order, ground, start, |_, stage, _| {
        moves.push(super::fast::bounds(&stage.instance).map_or(0, |bounds| bounds.sum_of_costs));
    });
    let bounds: Vec<BoardFigures> =
        known.iter().zip(moves).map(|((_, bounds), moves)| [bounds.makespan, bounds.sum_of_costs, moves]).collect();
    let mut fronts: Vec<PlanFront> = Vec::with_capacity(known.len());
    stage::each_stage(order, ground, start, |_, stage, _| {
        let turn = fronts.len();
        let rest = bounds.iter().enumerate().filter(|(other, _)| *other != turn);
        let rest = rest.fold([0; 3], |sum, (_, own)| [0, 1, 2].map(|figure: usize| sum[figure] + own[figure]));
        let most = [0, 1, 2].map(|figure: usize| match limits.most[figure] {
            UNLIMITED => UNLIMITED,
            most => most.saturating_sub(rest[figure]),
        });
        let asked = AskedStep {
            objective: BoardObjective::of(order.objective),
            limits: PlanLimits { most, least: limits.least },
            is_only,
            expansions: order.planner.expansions,
        };
        let standing = stage.standing_cells(order).collect();
        fronts.push(limited::front(&stage.instance, standing, &known[turn].0, bounds[turn], asked));
    });
    fronts
}

/// State while the steps of a job are planned.
pub(super) struct Tasks<'a> {
    pub(super) job: &'a Job,
    pub(super) order: &'a ElectrodeArrayOrder,
    ground: &'a BoardGround<'a>,
    /// Cells of the parts before the job.
    start: &'a [Option<ElectrodeCell>],
    /// Current cells of the parts.
    cells: Vec<Option<ElectrodeCell>>,
    /// Parts whose cells the program leaves open.
    loose: LooseParts,
    /// Paths of the steps with moves, with their lower bounds.
    known: Vec<(Paths, BoardCosts)>,
    /// Lower bounds of the assays and of the steps with interchangeable goals.
    assays: Vec<BoardCosts>,
    /// The first step without a plan from the cells that the plan chose for the parts. From other cells it may have
    /// one.
    stranded: Option<Span>,
    /// Whether a remedy may still be tried. One is tried per job, since each try costs as much as planning.
    may_remedy: bool,
    pub(super) sink: &'a mut Sink,
}

impl Tasks<'_> {
    /// The motion of one step. If it has none, planning continues from the goals, so that later steps are reported too.
    fn step(&mut self, step: &ElectrodeArrayStep) -> Option<ElectrodeArrayStepMotion> {
        match &step.action {
            ElectrodeArrayAction::Wait(duration_ns) => {
                let stage = BoardStage::new(self.order, self.ground, &self.cells, &[]);
                let restless = torn::restless(self.order, &stage, step.span).filter(|_| *duration_ns > 0);
                let is_fixed = self.loose.is_fixed_in(&step.action);
                let is_possible = restless.is_none();
                match restless {
                    Some(wrong) if is_fixed => self.sink.push(wrong),
                    Some(_) => self.strand(step),
                    None => {}
                }
                is_possible.then_some(ElectrodeArrayStepMotion::Wait(*duration_ns))
            }
            ElectrodeArrayAction::Move(moves) => {
                let stage = BoardStage::new(self.order, self.ground, &self.cells, moves);
                let paths = self.paths(step, &stage);
                let motion = paths.map(|paths| stage::moves_of(self.order, &stage, &self.cells, &paths));
                stage::arrive(&mut self.cells, moves);
                if let Some(motion) = &motion {
                    shared::arrive(&mut self.cells, moves, motion);
                }
                self.loose.follow(&step.action);
                motion.map(ElectrodeArrayStepMotion::Paths)
            }
            ElectrodeArrayAction::Assay(operations) => {
                let motion = self.operated(step, operations);
                let placed = match &motion {
                    Some(ElectrodeArrayStepMotion::Assay { operations, .. }) => operations,
                    Some(_) | None => operations,
                };
                errands::depart(&mut self.cells, placed);
                self.loose.follow(&step.action);
                motion
            }
        }
    }

    /// Records that a step has no plan from the current cells. Steps after it would start from cells that no plan
    /// reaches.
    fn strand(&mut self, step: &ElectrodeArrayStep) {
        self.stranded.get_or_insert(step.span);
    }

    /// The motion of all parts in an assay.
    fn operated(
        &mut self,
        step: &ElectrodeArrayStep,
        operations: &[AssayOperation],
    ) -> Option<ElectrodeArrayStepMotion> {
        let (objective, budget) =
            (BoardObjective::of(self.order.objective), SearchBudget::of(self.order.planner.expansions));
        let cells = self.cells.clone();
        let site = AssaySite { order: self.order, ground: self.ground, cells: &cells };
        let mut meter = Meter::new(budget);
        match arranged::solve(&site, operations, objective, &mut meter) {
            SearchAnswer::Found(PlacedPlan { operations, courses, bounds, .. }) => {
                self.assays.push(self.least_of(step, bounds));
                return Some(ElectrodeArrayStepMotion::Assay { operations, courses });
            }
            SearchAnswer::Impossible(_) if !self.loose.is_fixed_in(&step.action) => {
                self.strand(step);
            }
            SearchAnswer::Impossible(why) => {
                let is_torn = torn::excludes_operations(&site, &why);
                arranged::with_problem(&site, &why.operations, |stage, _| self.no_courses(step, stage, &why, is_torn));
            }
            SearchAnswer::GaveUp(bounds) => {
                let goals = arranged::with_problem(&site, operations, |stage, _| stage.goals());
                match meter.left().steps {
                    0 => self.gave_up(step, &goals, bounds, budget),
                    _ => self.nothing_left_to_try(step, &goals, bounds),
                }
            }
        }
        None
    }

    /// Reports why an assay has no plan. `is_torn`: it would have one if each electrode had a channel of its own.
    fn no_courses(&mut self, step: &ElectrodeArrayStep, stage: &BoardStage, none: &NoArrangement, is_torn: bool) {
        let before = std::mem::take(&mut *self.sink);
        match &none.why {
            NoAssayPlan::Excluded { reached } => {
                let parts: Vec<&str> = (0..reached.len()).map(|agent| self.part_name(stage, agent)).collect();
                let is_timed = none.operations.iter().any(|operation| operation.within.is_some());
                let excluded = errors::operations_exclude_one_another(step.span, &parts, is_timed);
                let diagnostic = match is_torn {
                    true => errors::operations_excluded_by_channels(step.span, &parts),
                    false => errors::where_others_stay(self.with_avoided(excluded, step), stage.standing_names()),
                };
                let reaches = parts.iter().zip(reached).map(|(part, cells)| reach(self.order, part, cells.clone()));
                self.sink.push(diagnostic.reached(reaches));
            }
            NoAssayPlan::TooLate { agent, operation } => {
                let diagnostic = errors::too_far_in_time(step.span, self.part_name(stage, *agent));
                let within = operation.and_then(|nth| none.operations.get(nth)?.within.as_ref());
                self.sink.push(match within {
                    Some(within) => diagnostic.label_elsewhere(within.span, step.span, "within this time"),
                    None => diagnostic,
                });
            }
            NoAssayPlan::LoopOffBoard { agent } => {
                self.sink.push(errors::loop_off_board(step.span, self.part_name(stage, *agent)));
            }
            NoAssayPlan::Alone(why) => self.impossible(step.span, stage, why),
        }
        let found = std::mem::replace(&mut *self.sink, before);
        for diagnostic in found.sorted() {
            self.sink.push(errors::of_first_arrangement(diagnostic.clone(), none.count));
        }
    }

    fn paths(&mut self, step: &ElectrodeArrayStep, stage: &BoardStage) -> Option<Paths> {
        if stage.agents.iter().any(|actor| actor.asked.is_some_and(|one| one.team.is_some())) {
            return self.by_teams(step, stage);
        }
        match self.order.planner.method {
            ElectrodeArrayMethod::Portfolio => self.by_portfolio(step, stage),
            ElectrodeArrayMethod::CooperativeAstar => self.as_published(step, stage, Heuristic::Spread),
            ElectrodeArrayMethod::PlainCooperativeAstar => self.as_published(step, stage, Heuristic::Plain),
        }
    }

    fn by_portfolio(&mut self, step: &ElectrodeArrayStep, stage: &BoardStage) -> Option<Paths> {
        let budget = SearchBudget::of(self.order.planner.expansions);
        match portfolio::solve(&stage.instance, BoardObjective::of(self.order.objective), None, budget) {
            BoardAnswer::Found(BoardPlan { paths, bounds }) => {
                self.add(&paths, self.least_of(step, bounds));
                Some(paths)
            }
            BoardAnswer::Impossible(_) if !self.loose.is_fixed_in(&step.action) => {
                self.strand(step);
                None
            }
            BoardAnswer::Impossible(why) => {
                self.impossible(step.span, stage, &why);
                None
            }
            BoardAnswer::GaveUp(bounds) => {
                self.gave_up(step, &stage.goals(), bounds, budget);
                None
            }
        }
    }

    /// The paths of a step with interchangeable goals.
    fn by_teams(&mut self, step: &ElectrodeArrayStep, stage: &BoardStage) -> Option<Paths> {
        let budget = SearchBudget::of(self.order.planner.expansions);
        match shared::solve(self.order, step.span, stage, BoardObjective::of(self.order.objective), budget) {
            SharedGoals::Found(BoardPlan { paths, bounds }) => {
                self.assays.push(self.least_of(step, bounds));
                return Some(paths);
            }
            SharedGoals::GaveUp(bounds) => self.gave_up(step, &stage.goals(), bounds, budget),
            SharedGoals::Alone(_) | SharedGoals::Refused(_) if !self.loose.is_fixed_in(&step.action) => {
                self.strand(step);
            }
            SharedGoals::Alone(why) => self.impossible(step.span, stage, &why),
            SharedGoals::Refused(diagnostic) => self.sink.push(diagnostic),
        }
        None
    }

    /// Lower bounds of a step that hold wherever the plan has brought the parts: the proven `bounds` if the cells are
    /// fixed, else weaker ones.
    fn least_of(&self, step: &ElectrodeArrayStep, bounds: BoardCosts) -> BoardCosts {
        let least = self.loose.least(self.order, self.ground, &self.cells, &step.action);
        least.unwrap_or(bounds)
    }

    fn gave_up(&mut self, step: &ElectrodeArrayStep, to: &str, bounds: BoardCosts, budget: SearchBudget) {
        let (what, steps) = ("the search for a plan", count(bounds.makespan, "step"));
        let diagnostic =
            errors::gave_up(step.span, to, what, budget.steps, &steps, ElectrodeArrayMethod::Portfolio.name());
        self.sink.push(self.with_avoided(diagnostic.help(more_may_do(budget.steps)), step));
    }

    /// Reports a search that ended before its budget was used up.
    fn nothing_left_to_try(&mut self, step: &ElectrodeArrayStep, to: &str, bounds: BoardCosts) {
        let avoids = !self.order.contamination.is_unheeded();
        let diagnostic = errors::nothing_left_to_try(step.span, to, bounds.makespan, avoids);
        self.sink.push(self.with_avoided(diagnostic, step));
    }

    /// Labels a diagnostic about a step that has no plan with what restricts it: avoided traces, the washes that these
    /// add, and the time within which operations must begin.
    fn with_avoided(&self, diagnostic: Diagnostic, step: &ElectrodeArrayStep) -> Diagnostic {
        let operations: &[AssayOperation] =
            if let ElectrodeArrayAction::Assay(operations) = &step.action { operations } else { &[] };
        let contamination = &self.order.contamination;
        let avoided = contamination.avoided.first().map(|avoided| avoided.span);
        let course = contamination.course.as_ref().map(|course| course.span);
        let washes = course.filter(|course| operations.iter().any(|operation| operation.span == *course));
        let within = operations.iter().find_map(|operation| operation.within.as_ref()).map(|within| within.span);
        let marks = [
            (avoided, "with these traces avoided"),
            (washes, "with these washes, in the order of the program"),
            (within, "within this time"),
        ];
        let marks = marks.into_iter().filter_map(|(span, text)| Some((span?, text)));
        marks.fold(diagnostic, |diagnostic, (span, text)| diagnostic.label_elsewhere(span, step.span, text))
    }

    fn part_name(&self, stage: &BoardStage, agent: usize) -> &str {
        &self.order.parts[stage.agents[agent].part].name
    }

    pub(super) fn impossible(&mut self, step: Span, stage: &BoardStage, reason: &NoBoardPlan) {
        match reason {
            NoBoardPlan::Closed { agent, stop } => self.closed(stage, *agent, *stop),
            NoBoardPlan::TornByChannels { agent, stop } => {
                self.sink.push(torn::torn(self.order, stage, *agent, *stop));
            }
            NoBoardPlan::Blocked { agents } => {
                if let Some(diagnostic) = torn::excluded(self.order, step, stage, agents) {
                    self.sink.push(diagnostic);
                    return;
                }
                let parts: Vec<(&str, Span)> =
                    agents.iter().map(|agent| stage.agents[*agent].named(self.order)).collect();
                let merge =
                    agents.iter().find_map(|agent| stage.agents[*agent].asked.filter(|asked| asked.with.is_some()));
                let blocked = errors::blocked_by_one_another(step, &parts, merge.map(|merge| merge.span));
                let diagnostic = errors::where_others_stay(blocked, stage.standing_names());
                let reached = exact::reached(&stage.instance, agents).unwrap_or_default();
                let reaches = parts.iter().zip(reached).map(|((name, _), cells)| reach(self.order, name, cells));
                self.sink.push(diagnostic.reached(reaches));
            }
            // Cannot occur without a limit; limits are checked after the plans without them are known.
            NoBoardPlan::TooFewSteps { least } => self.sink.push(errors::too_few_steps(step, 0, *least)),
        }
    }

    /// Reports a part that blocked cells cut off from one of its stops.
    fn closed(&mut self, stage: &BoardStage, agent: usize, stop: usize) {
        let (actor, asked) = (&stage.agents[agent], &stage.instance.agents[agent]);
        let from = if stop == 0 { asked.start } else { asked.stops[stop - 1] };
        let to = asked.stops[stop];
        let (blamed, removal) = why::why(stage, from, to);
        let part = &self.order.parts[actor.part];
        let cut_off = CutOffPart { order: self.order, stage, blamed: &blamed, removal, part: &part.name };
        let help = cut_off.help(self.remedy_outcome(&cut_off));
        let blockers: Vec<&CellBlocker> = stage.blockers().collect();
        let blamed: Vec<(String, Span)> =
            blamed.iter().map(|index| (blockers[*index].name(), blockers[*index].span)).collect();
        let blamed: Vec<(&str, Span)> = blamed.iter().map(|(name, span)| (name.as_str(), *span)).collect();
        let span = actor.asked.map_or(part.span, |action| action.span);
        let text = |cell| stage::cell(self.order, cell).to_string();
        let name = &part.name;
        let proof = match (blamed.is_empty(), &self.order.facts.map) {
            (false, _) => format!("`{name}` is cut off from {}", text(to)),
            (true, Some(_)) => {
                format!("no chain of working electrodes leads `{name}` from {} to {}", text(from), text(to))
            }
            (true, None) => format!("no cell that `{name}` can reach lies beside {}", text(to)),
        };
        let diagnostic = errors::impossible(
            errors::StepEnds { step: span, from: &text(from), to: &text(to) },
            &proof,
            &blamed,
            Removal::Unknown,
        );
        let diagnostic = diagnostic.reached(why::reached(stage, from).map(|cells| reach(self.order, name, cells)));
        self.sink.push(match help {
            Some(help) => diagnostic.help(help),
            None => diagnostic,
        });
    }

    /// Plans the whole task with a remedy applied, without trying further remedies.
    fn remedy_outcome(&mut self, cut_off: &CutOffPart) -> RemedyOutcome {
        let may_remedy = std::mem::replace(&mut self.may_remedy, false);
        let Some(order) = cut_off.remedied().filter(|_| may_remedy) else { return RemedyOutcome::LeftOut };
        let mut sink = Sink::default();
        if planned(self.job, &order, self.start.to_vec(), false, &mut sink).0.is_some() {
            return RemedyOutcome::Planned;
        }
        let is_proven = sink.sorted().iter().any(|diagnostic| diagnostic.code == Code::E0601);
        if is_proven { RemedyOutcome::Impossible } else { RemedyOutcome::NotFound(order.planner.expansions) }
    }

    pub(super) fn add(&mut self, paths: &Paths, bounds: BoardCosts) {
        self.known.push((paths.clone(), bounds));
    }
}

/// The cells that a part reached.
fn reach(order: &ElectrodeArrayOrder, part: &str, cells: Vec<board::CellIndex>) -> Reach {
    let places = cells.into_iter().map(|cell| stage::cell(order, cell)).map(|cell| (cell.column, cell.row));
    Reach { what: part.to_owned(), extent: ReachExtent::Cells(CellRun::all(places)) }
}

/// Advice after a search that gave up; the budget that would suffice is not known.
fn more_may_do(budget: u64) -> String {
    let most = u64::from(MAX_EXPANSIONS);
    if budget >= most {
        return "no sufficient budget is known, and no larger one is allowed: move the parts in several steps of the \
                task"
            .to_owned();
    }
    let more = budget.saturating_mul(8).min(most);
    format!("no sufficient budget is known; a larger one may help: `using portfolio {{ expansions: {more} }}`")
}

/// The plan with its figures. `bounds` hold for every plan, `bound` only for plans that keep the limits of the task.
fn finished(
    order: &ElectrodeArrayOrder,
    motion: ElectrodeArrayMotion,
    bounds: BoardCosts,
    bound: Option<u64>,
) -> Plan<ElectrodeArrayMotion> {
    let outcomes = limits::outcomes(order, &motion);
    let (least, other) = match order.objective {
        ElectrodeArrayObjective::Makespan => {
            (bounds.makespan, (ElectrodeArrayOutcome::SumOfCosts.name().to_owned(), bounds.sum_of_costs as f64))
        }
        ElectrodeArrayObjective::SumOfCosts => {
            (bounds.sum_of_costs, (ElectrodeArrayOutcome::Steps.name().to_owned(), bounds.makespan as f64))
        }
    };
    let cost = outcomes[order.objective.outcome().name()];
    let bound = bound.unwrap_or(least) as f64;
    Plan {
        planner: order.planner.method.name(),
        objective: order.objective.name(),
        unit: "",
        cost,
        bound,
        proof: if cost <= bound { Optimality::Proven } else { Optimality::Open },
        bounds: BTreeMap::from([other]),
        outcomes,
        remarks: Vec::new(),
        motion,
    }
}
