//! Where operations take place for which the program names several places.
//!
//! An arrangement has one place for each of them, and is an assay without a choice. Method: as long as there are few arrangements, in
//! the order of their lower bounds, until no bound is below the plan at hand: all by lists, and then by all positions of the parts. Of
//! more, one in which the places share the work, and then others that differ from the best one in one place, as long as plans become
//! better; beside the bound of [`relaxed`].
//!
//! Guaranteed: a plan is legal; `bounds` hold for the plans of every arrangement, and none is called impossible but where there were few
//! and each is. Cost: that of planning the arrangements, on one budget.

use super::assay::{self, AssayEffort, AssayPlan, AssayProblem, NoAssayPlan};
use super::board::{BoardCosts, BoardObjective};
use super::errands::{self, AssaySite, PartCourse, PartErrands};
use super::one_by_one::one_by_one;
use super::relaxed;
use super::stage::BoardStage;
use crate::claims::electrode_array::AssayOperation;
use crate::device::electrode_array::ElectrodeCell;
use crate::plan::search::{Meter, SearchAnswer, SearchBudget};

/// Most arrangements of which each has its own bound, and most operations of all arrangements whose bounds are looked at: in a long
/// assay each bound takes its time.
const MAX_ARRANGEMENTS: usize = 1_000;
const MAX_LOOKED: usize = 100_000;

/// One part in this many of the budget that is left goes to one arrangement of several, by lists, and by all positions.
const LISTS_SHARE: u64 = 64;
const SHARE: u64 = 4;

/// Of more arrangements, how many are planned after the first.
const MAX_TRIED: usize = 200;

/// A plan with the places that it has chosen.
pub struct PlacedPlan {
    pub operations: Vec<AssayOperation>,
    /// One for each part of the order.
    pub courses: Vec<PartCourse>,
    costs: BoardCosts,
    /// Lower bounds on every plan, wherever operations take place.
    pub bounds: BoardCosts,
}

/// Why no arrangement has a plan: the reason for the first one.
pub struct NoArrangement {
    pub operations: Vec<AssayOperation>,
    pub why: NoAssayPlan,
    /// How many there are.
    pub count: usize,
}

type PlacedAnswer = SearchAnswer<PlacedPlan, Box<NoArrangement>, BoardCosts>;

/// A plan of the operations at the best of their places; where the search gave up, lower bounds on every plan.
pub fn solve(
    site: &AssaySite,
    operations: &[AssayOperation],
    objective: BoardObjective,
    budget: SearchBudget,
) -> PlacedAnswer {
    solve_each(site, operations, (objective, MAX_ARRANGEMENTS.min(looks(operations))), budget)
}

/// How many arrangements have their bounds looked at, one at least.
fn looks(operations: &[AssayOperation]) -> usize {
    (MAX_LOOKED / operations.len().max(1)).max(1)
}

/// As [`solve`], with a bound of its own for each of so many arrangements at most.
pub(super) fn solve_each(
    site: &AssaySite,
    operations: &[AssayOperation],
    (objective, most): (BoardObjective, usize),
    budget: SearchBudget,
) -> PlacedAnswer {
    let choices = Choices::of(operations);
    let mut meter = Meter::new(budget);
    match choices.count().filter(|count| *count <= most) {
        Some(1) => only(site, operations, objective, &mut meter),
        Some(count) => of_few(site, &choices, count, objective, &mut meter),
        None => of_many(site, &choices, objective, &mut meter),
    }
}

/// Operations with the choices that they leave.
struct Choices<'a> {
    operations: &'a [AssayOperation],
    /// The indices of those with several places.
    open: Vec<usize>,
}

impl Choices<'_> {
    fn of(operations: &[AssayOperation]) -> Choices<'_> {
        let open = (0..operations.len()).filter(|nth| !operations[*nth].among.is_empty()).collect();
        Choices { operations, open }
    }

    /// The number of arrangements; `None` for more than [`MAX_ARRANGEMENTS`].
    fn count(&self) -> Option<usize> {
        let mut places = self.open.iter().map(|nth| self.operations[*nth].among.len());
        places.try_fold(1usize, |count, places| count.checked_mul(places).filter(|count| *count <= MAX_ARRANGEMENTS))
    }

    /// The places of an arrangement by its number, those of the last operation changing first.
    fn places(&self, mut number: usize) -> Vec<usize> {
        let mut places = vec![0; self.open.len()];
        for (place, nth) in places.iter_mut().zip(&self.open).rev() {
            let of = self.operations[*nth].among.len();
            (*place, number) = (number % of, number / of);
        }
        places
    }

    /// The operations at these places.
    fn at(&self, places: &[usize]) -> Vec<AssayOperation> {
        let mut operations = self.operations.to_vec();
        for (nth, place) in self.open.iter().zip(places) {
            operations[*nth] = self.operations[*nth].at_place(*place);
        }
        operations
    }

    /// Places that share the work: each operation, in the order of the program, where least was done before it.
    fn shared(&self) -> Vec<usize> {
        let mut busy: Vec<(ElectrodeCell, u64)> = Vec::new();
        let mut places = Vec::with_capacity(self.open.len());
        for nth in &self.open {
            let operation = &self.operations[*nth];
            let work = |cell: ElectrodeCell| busy.iter().find(|(at, _)| *at == cell).map_or(0, |(_, work)| *work);
            let cells = operation.among.iter().map(|place| place.stop.cell);
            let Some((place, cell)) = cells.enumerate().min_by_key(|(_, cell)| work(*cell)) else { continue };
            let more = operation.stay_ns.max(1);
            match busy.iter_mut().find(|(at, _)| *at == cell) {
                Some((_, work)) => *work = work.saturating_add(more),
                None => busy.push((cell, more)),
            }
            places.push(place);
        }
        places
    }
}

/// Looks at operations with one place each as at agents on a board.
pub fn with_problem<T>(
    site: &AssaySite,
    operations: &[AssayOperation],
    look: impl FnOnce(&BoardStage, Result<&AssayProblem, NoAssayPlan>) -> T,
) -> T {
    let cells = errands::with_new_parts(site.cells, operations);
    let asked = PartErrands::new(site.order, &cells, operations);
    let stage = BoardStage::new(site.order, site.ground, &cells, &asked.moves);
    match asked.off_board(site.order) {
        Some(part) => {
            let agent = stage.agents.iter().position(|actor| actor.part == part).unwrap_or(0);
            look(&stage, Err(NoAssayPlan::LoopOffBoard { agent }))
        }
        None => look(&stage, Ok(&asked.problem(site.order, &stage, operations))),
    }
}

/// The plan of an arrangement.
fn planned(
    site: &AssaySite,
    operations: Vec<AssayOperation>,
    (objective, effort): (BoardObjective, AssayEffort),
    meter: &mut Meter,
) -> PlacedAnswer {
    let found = with_problem(site, &operations, |stage, problem| {
        let problem = match problem {
            Ok(problem) => problem,
            Err(why) => return SearchAnswer::Impossible(why),
        };
        match assay::solve(problem, (objective, effort), meter) {
            SearchAnswer::Found(plan) => SearchAnswer::Found(placed(site, (stage, problem), plan)),
            SearchAnswer::Impossible(why) => SearchAnswer::Impossible(why),
            SearchAnswer::GaveUp(bounds) => SearchAnswer::GaveUp(bounds),
        }
    });
    match found {
        SearchAnswer::Found((courses, costs, bounds)) => {
            SearchAnswer::Found(PlacedPlan { operations, courses, costs, bounds })
        }
        SearchAnswer::Impossible(why) => {
            SearchAnswer::Impossible(Box::new(NoArrangement { operations, why, count: 1 }))
        }
        SearchAnswer::GaveUp(bounds) => SearchAnswer::GaveUp(bounds),
    }
}

/// A plan of operations one after the other, with bounds that are known.
fn in_turn(
    site: &AssaySite,
    operations: Vec<AssayOperation>,
    (objective, bounds): (BoardObjective, BoardCosts),
) -> Option<PlacedPlan> {
    let (courses, costs, bounds) = with_problem(site, &operations, |stage, problem| {
        let problem = problem.ok()?;
        let turns = (operations.as_slice(), problem, stage);
        let plan = one_by_one((site.order, site.ground), site.cells, turns, (objective, bounds))?;
        Some(placed(site, (stage, problem), plan))
    })?;
    Some(PlacedPlan { operations, courses, costs, bounds })
}

/// The courses of all parts, their costs, and the bounds.
fn placed(
    site: &AssaySite,
    (stage, problem): (&BoardStage, &AssayProblem),
    plan: AssayPlan,
) -> (Vec<PartCourse>, BoardCosts, BoardCosts) {
    let courses = errands::courses_of(site.order, stage, site.cells, (problem, &plan.courses));
    (courses, AssayPlan::costs(&plan.courses), plan.bounds)
}

/// The plan of the only arrangement.
fn only(site: &AssaySite, operations: &[AssayOperation], objective: BoardObjective, meter: &mut Meter) -> PlacedAnswer {
    match planned(site, operations.to_vec(), (objective, AssayEffort::Whole), meter) {
        SearchAnswer::GaveUp(bounds) => {
            let plan = in_turn(site, operations.to_vec(), (objective, bounds));
            plan.map_or(SearchAnswer::GaveUp(bounds), SearchAnswer::Found)
        }
        answer => answer,
    }
}

/// What a plan costs, the objective first.
fn cost(objective: BoardObjective, plan: &PlacedPlan) -> [u64; 2] {
    ordered(objective, plan.costs)
}

fn ordered(objective: BoardObjective, costs: BoardCosts) -> [u64; 2] {
    match objective {
        BoardObjective::Makespan => [costs.makespan, costs.sum_of_costs],
        BoardObjective::SumOfCosts => [costs.sum_of_costs, costs.makespan],
    }
}

/// What holds for the plans of both.
fn least(one: BoardCosts, other: BoardCosts) -> BoardCosts {
    BoardCosts { makespan: one.makespan.min(other.makespan), sum_of_costs: one.sum_of_costs.min(other.sum_of_costs) }
}

/// An arrangement that may have a plan.
struct Arrangement {
    number: usize,
    /// Of its plans.
    bounds: BoardCosts,
}

/// Arrangements that are planned, few enough to have a bound each.
struct FewArrangements<'a> {
    site: &'a AssaySite<'a>,
    choices: &'a Choices<'a>,
    objective: BoardObjective,
    /// Those that may have a plan, by their bounds.
    due: Vec<Arrangement>,
    best: Option<PlacedPlan>,
    /// Why the first of those that have none has none.
    why: Option<(usize, Box<NoArrangement>)>,
}

impl FewArrangements<'_> {
    fn cost(&self) -> Option<[u64; 2]> {
        self.best.as_ref().map(|plan| cost(self.objective, plan))
    }

    /// Whether its plans may be better than the best.
    fn is_hopeful(&self, bounds: BoardCosts) -> bool {
        self.cost().is_none_or(|[best, _]| ordered(self.objective, bounds)[0] < best)
    }

    fn refuse(&mut self, number: usize, why: Box<NoArrangement>) {
        if self.why.as_ref().is_none_or(|(first, _)| number < *first) {
            self.why = Some((number, why));
        }
    }

    /// Plans the arrangements that may be better than the best, by lists or by all positions, each on a share of the budget that is left.
    fn plan(&mut self, by_lists: bool, share: u64, meter: &mut Meter) {
        for Arrangement { number, bounds } in std::mem::take(&mut self.due) {
            let mut own = Arrangement { number, bounds };
            if self.is_hopeful(bounds) && meter.left().steps > 0 {
                let makespan = self.best.as_ref().map(|plan| plan.costs.makespan);
                let effort = match (by_lists, makespan) {
                    (true, _) => AssayEffort::Lists,
                    (false, None) => AssayEffort::Whole,
                    (false, Some(steps)) => AssayEffort::Below(steps),
                };
                let operations = self.choices.at(&self.choices.places(number));
                let (site, terms) = (self.site, (self.objective, effort));
                match meter.share(meter.left().steps / share, |part| planned(site, operations, terms, part)) {
                    SearchAnswer::Found(plan) => {
                        own.bounds = plan.bounds;
                        if self.cost().is_none_or(|best| cost(self.objective, &plan) < best) {
                            self.best = Some(plan);
                        }
                    }
                    SearchAnswer::GaveUp(bounds) => own.bounds = bounds,
                    SearchAnswer::Impossible(why) => {
                        self.refuse(number, why);
                        continue;
                    }
                }
            }
            self.due.push(own);
        }
    }
}

/// The arrangements in the order of their bounds: first by lists, and then by all positions where fewer steps are not ruled out.
fn of_few(
    site: &AssaySite,
    choices: &Choices,
    count: usize,
    objective: BoardObjective,
    meter: &mut Meter,
) -> PlacedAnswer {
    let mut few = FewArrangements { site, choices, objective, due: Vec::new(), best: None, why: None };
    for number in 0..count {
        let operations = choices.at(&choices.places(number));
        match with_problem(site, &operations, |_, problem| assay::bounds(problem?, meter)) {
            Ok(bounds) => few.due.push(Arrangement { number, bounds }),
            Err(why) => few.refuse(number, Box::new(NoArrangement { operations, why, count })),
        }
    }
    few.due.sort_by_key(|own| (ordered(objective, own.bounds), own.number));
    few.plan(true, LISTS_SHARE, meter);
    if few.best.is_none() || objective == BoardObjective::Makespan {
        few.plan(false, SHARE, meter);
    }
    let bounds = few.due.iter().map(|own| own.bounds).reduce(least);
    if let (None, Some(first), Some(bounds)) = (&few.best, few.due.first(), bounds) {
        few.best = in_turn(site, choices.at(&choices.places(first.number)), (objective, bounds));
    }
    match (few.best, bounds, few.why) {
        (Some(plan), bounds, _) => {
            let bounds = bounds.unwrap_or(plan.bounds);
            SearchAnswer::Found(PlacedPlan { bounds, ..plan })
        }
        (None, None, Some((_, why))) => SearchAnswer::Impossible(Box::new(NoArrangement { count, ..*why })),
        (None, bounds, _) => SearchAnswer::GaveUp(bounds.unwrap_or_default()),
    }
}

/// An arrangement in which the places share the work, and better ones from there on.
fn of_many(site: &AssaySite, choices: &Choices, objective: BoardObjective, meter: &mut Meter) -> PlacedAnswer {
    let bounds = relaxed::bounds(site, choices.operations, meter);
    let mut places = choices.shared();
    let first = choices.at(&places);
    let share = meter.left().steps / SHARE;
    let answer = meter.share(share, |part| planned(site, first.clone(), (objective, AssayEffort::Whole), part));
    let found = if let SearchAnswer::Found(plan) = answer { Some(plan) } else { None };
    let Some(mut best) = found.or_else(|| in_turn(site, first, (objective, bounds))) else {
        return SearchAnswer::GaveUp(bounds);
    };
    let (mut looked, mut tried, mut is_better) = (0, 0, true);
    let looks = looks(choices.operations);
    while std::mem::take(&mut is_better) {
        for open in 0..places.len() {
            for place in 0..choices.operations[choices.open[open]].among.len() {
                let is_least = cost(objective, &best)[0] <= ordered(objective, bounds)[0];
                let is_over = looked >= looks || tried >= MAX_TRIED || meter.left().steps == 0;
                if place == places[open] || is_least || is_over {
                    continue;
                }
                looked += 1;
                let mut others = places.clone();
                others[open] = place;
                let operations = choices.at(&others);
                let limits = with_problem(site, &operations, |_, problem| assay::bounds(problem?, meter));
                if !limits.is_ok_and(|limits| ordered(objective, limits)[0] < cost(objective, &best)[0]) {
                    continue;
                }
                tried += 1;
                let share = meter.left().steps / LISTS_SHARE;
                let terms = (objective, AssayEffort::Lists);
                let answer = meter.share(share, |part| planned(site, operations, terms, part));
                if let SearchAnswer::Found(plan) = answer
                    && cost(objective, &plan) < cost(objective, &best)
                {
                    (best, places, is_better) = (plan, others, true);
                }
            }
        }
    }
    SearchAnswer::Found(PlacedPlan { bounds, ..best })
}
