//! Where operations take place for which the program names several places.
//!
//! An arrangement has one place for each of them, and is an assay without a choice. Method: as long as there are few arrangements, in
//! the order of their lower bounds, until no bound is below the plan at hand: all by lists, and then by all positions of the parts. Of
//! more, those of some schedules on paper (`placement`), or, where these have no plan, some at random; the best of them in a better order, and
//! then others that differ from it in one place, as long as plans become better; then as of few those whose lower bounds are least
//! (`place_tree`). Where there is only one, schedules on paper say in which order its parts may have their turns.
//!
//! Guaranteed: a plan is legal; `bounds` hold for the plans of every arrangement, and they are called impossible only where each one is.
//! Cost: that of planning the arrangements, on one budget.

use super::critical_path::{self, BoardWays};
use super::place_tree::PlaceTree;
use super::placement::{self, PaperSchedule, PaperTerms, PaperWait};
use super::relaxed;
use crate::claims::electrode_array::{AssayOperation, ElectrodeArrayOrder};
use crate::plan::electrode_array::assay::{self, AssayEffort, AssayPlan, AssayProblem, NoAssayPlan};
use crate::plan::electrode_array::board::{BoardCosts, BoardObjective};
use crate::plan::electrode_array::errands::{self, AssaySite, PartCourse, PartErrands};
use crate::plan::electrode_array::one_by_one::one_by_one;
use crate::plan::electrode_array::stage::{self, BoardStage};
use crate::plan::search::{Meter, SearchAnswer};
use crate::random::SplitMix64;

/// Most arrangements of which each has its own bound, and most operations of all arrangements whose bounds are looked at: in a long
/// assay each bound takes its time.
const MAX_ARRANGEMENTS: usize = 1_000;
const MAX_LOOKED: usize = 100_000;

/// One part in this many of the budget that is left goes to one arrangement of several, by lists, and by all positions.
const LISTS_SHARE: u64 = 64;
const SHARE: u64 = 4;

/// All but one part in this many goes to the best of more arrangements.
const KEPT_SHARE: u64 = 4;

/// Of more arrangements, how many are planned that differ in one place from the best one,
const MAX_TRIED: usize = 200;

/// after those of so many schedules on paper, with so many operations all together.
const PAPERS: usize = 8;
const MAX_PAPER_OPERATIONS: usize = 10_000;

/// Where no schedule on paper has a plan, how many arrangements drawn at random are planned by lists, and then as many by all positions.
const MAX_DRAWN: usize = 100;

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
    meter: &mut Meter,
) -> PlacedAnswer {
    solve_each(site, operations, objective, MAX_ARRANGEMENTS.min(looks(operations)), meter)
}

/// How many arrangements have their bounds looked at, one at least.
fn looks(operations: &[AssayOperation]) -> usize {
    (MAX_LOOKED / operations.len().max(1)).max(1)
}

/// As [`solve`], with a bound of its own for each of so many arrangements at most.
pub(in super::super) fn solve_each(
    site: &AssaySite,
    operations: &[AssayOperation],
    objective: BoardObjective,
    most: usize,
    meter: &mut Meter,
) -> PlacedAnswer {
    let choices = Choices::of(operations);
    match choices.count().filter(|count| *count <= most) {
        Some(1) => only(site, operations, objective, meter),
        Some(count) => of_few(site, &choices, count, objective, meter),
        None => of_many(site, &choices, objective, meter),
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

    /// How many places each of them has.
    fn counts(&self) -> impl Iterator<Item = usize> {
        self.open.iter().map(|nth| self.operations[*nth].among.len())
    }

    /// The number of arrangements; `None` for more than [`MAX_ARRANGEMENTS`].
    fn count(&self) -> Option<usize> {
        self.counts()
            .try_fold(1usize, |count, places| count.checked_mul(places).filter(|count| *count <= MAX_ARRANGEMENTS))
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

    /// The places that operations have on paper.
    fn on_paper(&self, order: &ElectrodeArrayOrder, paper: &PaperSchedule) -> Vec<usize> {
        let place = |nth: &usize| {
            let cell = paper.cells[*nth]?;
            self.operations[*nth].among.iter().position(|place| stage::flat(order, place.stop.cell) == cell)
        };
        self.open.iter().map(|nth| place(nth).unwrap_or(0)).collect()
    }
}

/// Looks at operations with one place each as at agents on a board.
pub fn with_problem<T>(
    site: &AssaySite,
    operations: &[AssayOperation],
    look: impl FnOnce(&BoardStage, Result<AssayProblem, NoAssayPlan>) -> T,
) -> T {
    let cells = errands::with_new_parts(site.cells, operations);
    let asked = PartErrands::new(site.order, &cells, operations);
    let stage = BoardStage::new(site.order, site.ground, &cells, &asked.moves);
    match asked.off_board(site.order) {
        Some(part) => {
            let agent = stage.agents.iter().position(|actor| actor.part == part).unwrap_or(0);
            look(&stage, Err(NoAssayPlan::LoopOffBoard { agent }))
        }
        None => look(&stage, Ok(asked.problem(site.order, &stage, operations))),
    }
}

/// How an arrangement is planned.
#[derive(Clone, Copy)]
struct ArrangementTerms<'a> {
    objective: BoardObjective,
    effort: AssayEffort,
    /// Schedules of the operations, in whose order parts may have their turns.
    papers: &'a [PaperSchedule],
}

/// The plan of an arrangement.
fn planned(
    site: &AssaySite,
    operations: Vec<AssayOperation>,
    terms: ArrangementTerms,
    meter: &mut Meter,
) -> PlacedAnswer {
    let found = with_problem(site, &operations, |stage, problem| {
        let mut problem = match problem {
            Ok(problem) => problem,
            Err(why) => return SearchAnswer::Impossible(why),
        };
        problem.papers = terms.papers.iter().map(|paper| paper.of(&problem.operations)).collect();
        match assay::solve(&problem, terms.objective, terms.effort, meter) {
            SearchAnswer::Found(plan) => SearchAnswer::Found(placed(site, stage, &problem, plan)),
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
    objective: BoardObjective,
    bounds: BoardCosts,
) -> Option<PlacedPlan> {
    let (courses, costs, bounds) = with_problem(site, &operations, |stage, problem| {
        let problem = problem.ok()?;
        let plan = one_by_one(site, &operations, &problem, stage, objective, bounds)?;
        Some(placed(site, stage, &problem, plan))
    })?;
    Some(PlacedPlan { operations, courses, costs, bounds })
}

/// The courses of all parts, their costs, and the bounds.
fn placed(
    site: &AssaySite,
    stage: &BoardStage,
    problem: &AssayProblem,
    plan: AssayPlan,
) -> (Vec<PartCourse>, BoardCosts, BoardCosts) {
    let courses = errands::courses_of(site.order, stage, site.cells, problem, &plan.courses);
    (courses, AssayPlan::costs(&plan.courses), plan.bounds)
}

/// The plan of the only arrangement.
fn only(site: &AssaySite, operations: &[AssayOperation], objective: BoardObjective, meter: &mut Meter) -> PlacedAnswer {
    let mut ways = BoardWays::new(site, meter);
    let timed = critical_path::timed(operations, &mut ways);
    let least = relaxed::bounds(operations, &timed, &mut ways).makespan;
    let paper = |wait| placement::schedule(operations, &timed, &mut ways, PaperTerms { seed: 0, least, wait });
    let papers = [PaperWait::AtOutlet, PaperWait::OnBoard].map(paper);
    let terms = ArrangementTerms { objective, effort: AssayEffort::Whole, papers: &papers };
    match planned(site, operations.to_vec(), terms, meter) {
        SearchAnswer::GaveUp(bounds) => {
            let plan = in_turn(site, operations.to_vec(), objective, bounds);
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
    places: Vec<usize>,
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
    why: Option<(Vec<usize>, Box<NoArrangement>)>,
}

impl<'a> FewArrangements<'a> {
    fn new(site: &'a AssaySite, choices: &'a Choices, objective: BoardObjective, best: Option<PlacedPlan>) -> Self {
        FewArrangements { site, choices, objective, due: Vec::new(), best, why: None }
    }

    fn cost(&self) -> Option<[u64; 2]> {
        self.best.as_ref().map(|plan| cost(self.objective, plan))
    }

    /// Whether its plans may be better than the best.
    fn is_hopeful(&self, bounds: BoardCosts) -> bool {
        self.cost().is_none_or(|[best, _]| ordered(self.objective, bounds)[0] < best)
    }

    fn refuse(&mut self, places: Vec<usize>, why: Box<NoArrangement>) {
        if self.why.as_ref().is_none_or(|(first, _)| places < *first) {
            self.why = Some((places, why));
        }
    }

    /// Adds an arrangement, unless it is known at once that it has no plan.
    fn add(&mut self, places: Vec<usize>, meter: &mut Meter) {
        let operations = self.choices.at(&places);
        match with_problem(self.site, &operations, |_, problem| assay::bounds(&problem?, meter)) {
            Ok(bounds) => self.due.push(Arrangement { places, bounds }),
            Err(why) => self.refuse(places, Box::new(NoArrangement { operations, why, count: 1 })),
        }
    }

    /// Plans those that may be better than the best, by lists, and then by all positions where fewer steps are not ruled out.
    fn plan_all(&mut self, meter: &mut Meter) {
        self.due.sort_by_cached_key(|own| (ordered(self.objective, own.bounds), own.places.clone()));
        self.plan(true, LISTS_SHARE, meter);
        if self.best.is_none() || self.objective == BoardObjective::Makespan {
            self.plan(false, SHARE, meter);
        }
    }

    /// Plans the arrangements that may be better than the best, by lists or by all positions, each on a share of the budget that is left.
    fn plan(&mut self, by_lists: bool, share: u64, meter: &mut Meter) {
        for mut own in std::mem::take(&mut self.due) {
            let bounds = own.bounds;
            if self.is_hopeful(bounds) && meter.left().steps > 0 {
                let makespan = self.best.as_ref().map(|plan| plan.costs.makespan);
                let effort = match (by_lists, makespan) {
                    (true, _) => AssayEffort::Lists,
                    (false, None) => AssayEffort::Whole,
                    (false, Some(steps)) => AssayEffort::Below(steps),
                };
                let operations = self.choices.at(&own.places);
                let (site, objective) = (self.site, self.objective);
                let terms = ArrangementTerms { objective, effort, papers: &[] };
                match meter.share(meter.left().steps / share, |part| planned(site, operations, terms, part)) {
                    SearchAnswer::Found(plan) => {
                        own.bounds = plan.bounds;
                        if self.cost().is_none_or(|best| cost(self.objective, &plan) < best) {
                            self.best = Some(plan);
                        }
                    }
                    SearchAnswer::GaveUp(bounds) => own.bounds = bounds,
                    SearchAnswer::Impossible(why) => {
                        self.refuse(own.places, why);
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
    let mut few = FewArrangements::new(site, choices, objective, None);
    (0..count).for_each(|number| few.add(choices.places(number), meter));
    few.plan_all(meter);
    let bounds = few.due.iter().map(|own| own.bounds).reduce(least);
    if let (None, Some(first), Some(bounds)) = (&few.best, few.due.first(), bounds) {
        few.best = in_turn(site, choices.at(&first.places), objective, bounds);
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

/// The best of the arrangements of some schedules on paper, and better ones from there on.
fn of_many(site: &AssaySite, choices: &Choices, objective: BoardObjective, meter: &mut Meter) -> PlacedAnswer {
    let mut ways = BoardWays::new(site, meter);
    let timed = critical_path::timed(choices.operations, &mut ways);
    let bounds = relaxed::bounds(choices.operations, &timed, &mut ways);
    let mut many = ManyArrangements { site, choices, objective, bounds, best: None, places: Vec::new(), paper: None };
    let papers = (MAX_PAPER_OPERATIONS / choices.operations.len().max(1)).clamp(1, PAPERS) as u64;
    for seed in 0..papers {
        if many.is_least() {
            break;
        }
        let mut ways = BoardWays::new(site, meter);
        let wait = if seed % 2 == 0 { PaperWait::AtOutlet } else { PaperWait::OnBoard };
        let terms = PaperTerms { seed, least: bounds.makespan, wait };
        let paper = placement::schedule(choices.operations, &timed, &mut ways, terms);
        many.realise(paper, meter);
    }
    many.draw(meter);
    many.better_order(meter);
    many.improve(meter);
    let none = many.plan_least_bounds(meter);
    let bounds = many.bounds;
    match (many.best, none) {
        (Some(best), _) => SearchAnswer::Found(PlacedPlan { bounds, ..best }),
        (None, Some(why)) => SearchAnswer::Impossible(why),
        (None, None) => SearchAnswer::GaveUp(bounds),
    }
}

/// More arrangements than have a bound each.
struct ManyArrangements<'a> {
    site: &'a AssaySite<'a>,
    choices: &'a Choices<'a>,
    objective: BoardObjective,
    bounds: BoardCosts,
    best: Option<PlacedPlan>,
    /// Of the best plan.
    places: Vec<usize>,
    /// The schedule on paper from which that comes, if it does.
    paper: Option<PaperSchedule>,
}

impl ManyArrangements<'_> {
    fn cost(&self) -> Option<[u64; 2]> {
        self.best.as_ref().map(|plan| cost(self.objective, plan))
    }

    fn is_least(&self) -> bool {
        self.cost().is_some_and(|[best, _]| best <= ordered(self.objective, self.bounds)[0])
    }

    /// Keeps a plan if it is better than the best.
    fn offer(&mut self, plan: PlacedPlan, places: Vec<usize>) -> bool {
        let is_better = self.cost().is_none_or(|best| cost(self.objective, &plan) < best);
        if is_better {
            (self.best, self.places) = (Some(plan), places);
        }
        is_better
    }

    /// Plans those of schedules on paper; the first one by all means.
    fn realise(&mut self, paper: PaperSchedule, meter: &mut Meter) {
        let places = self.choices.on_paper(self.site.order, &paper);
        let operations = self.choices.at(&places);
        let papers = std::slice::from_ref(&paper);
        let mut found =
            self.planned(operations.clone(), AssayEffort::Lists, papers, meter.left().steps / LISTS_SHARE, meter);
        if found.is_none() && self.best.is_none() {
            let steps = meter.left().steps / SHARE;
            let by_all_means = self.planned(operations.clone(), AssayEffort::Whole, papers, steps, meter);
            found = by_all_means.or_else(|| in_turn(self.site, operations, self.objective, self.bounds));
        }
        if let Some(plan) = found
            && self.offer(plan, places)
        {
            self.paper = Some(paper);
        }
    }

    /// Where no schedule on paper leads to a plan, those that are drawn at random, until one has a plan: by lists, and then by all positions, which is
    /// quick where parts cannot pass.
    fn draw(&mut self, meter: &mut Meter) {
        let mut random = SplitMix64::new(0);
        for nth in 0..2 * MAX_DRAWN {
            if self.best.is_some() || meter.left().steps == 0 {
                return;
            }
            let places: Vec<usize> = self.choices.counts().map(|count| random.below(count)).collect();
            let effort = if nth < MAX_DRAWN { AssayEffort::Lists } else { AssayEffort::Whole };
            let steps = meter.left().steps / LISTS_SHARE;
            if let Some(plan) = self.planned(self.choices.at(&places), effort, &[], steps, meter) {
                self.offer(plan, places);
            }
        }
    }

    /// The plan of an arrangement on so many steps of the budget.
    fn planned(
        &self,
        operations: Vec<AssayOperation>,
        effort: AssayEffort,
        papers: &[PaperSchedule],
        steps: u64,
        meter: &mut Meter,
    ) -> Option<PlacedPlan> {
        let terms = ArrangementTerms { objective: self.objective, effort, papers };
        match meter.share(steps, |part| planned(self.site, operations, terms, part)) {
            SearchAnswer::Found(plan) => Some(plan),
            SearchAnswer::Impossible(_) | SearchAnswer::GaveUp(_) => None,
        }
    }

    /// Looks for a better order at the places of the best plan, on most of the budget.
    fn better_order(&mut self, meter: &mut Meter) {
        let Some(paper) = self.paper.take().filter(|_| !self.is_least()) else { return };
        let (places, left) = (self.places.clone(), meter.left().steps);
        let (operations, steps) = (self.choices.at(&places), left - left / KEPT_SHARE);
        if let Some(plan) = self.planned(operations, AssayEffort::Lists, &[paper], steps, meter) {
            self.offer(plan, places);
        }
    }

    /// Plans arrangements that differ from the best one in one place, as long as plans become better.
    fn improve(&mut self, meter: &mut Meter) {
        let (mut looked, mut tried, mut is_better) = (0, 0, self.best.is_some());
        let looks = looks(self.choices.operations);
        while std::mem::take(&mut is_better) {
            for open in 0..self.places.len() {
                for place in 0..self.choices.operations[self.choices.open[open]].among.len() {
                    let is_over = looked >= looks || tried >= MAX_TRIED || meter.left().steps == 0;
                    if place == self.places[open] || self.is_least() || is_over {
                        continue;
                    }
                    looked += 1;
                    let mut others = self.places.clone();
                    others[open] = place;
                    let operations = self.choices.at(&others);
                    if !self.is_hopeful(&operations, meter) {
                        continue;
                    }
                    tried += 1;
                    let steps = meter.left().steps / LISTS_SHARE;
                    if let Some(plan) = self.planned(operations, AssayEffort::Lists, &[], steps, meter) {
                        is_better |= self.offer(plan, others);
                    }
                }
            }
        }
    }

    /// Plans those whose lower bounds are least and below the best plan, as of few; the bound of all others holds for what is left. Answers
    /// with the reason for the first one if none has a plan.
    fn plan_least_bounds(&mut self, meter: &mut Meter) -> Option<Box<NoArrangement>> {
        if self.is_least() {
            return None;
        }
        let (site, choices, objective) = (self.site, self.choices, self.objective);
        let bound_of = |places: &[usize], meter: &mut Meter| {
            let operations = choices.at(places);
            let mut ways = BoardWays::new(site, meter);
            let timed = critical_path::timed(&operations, &mut ways);
            ordered(objective, relaxed::bounds(&operations, &timed, &mut ways))[0]
        };
        let counts: Vec<usize> = choices.counts().collect();
        let mut tree = PlaceTree::new(&counts, ordered(objective, self.bounds)[0], looks(choices.operations));
        let mut few = FewArrangements::new(site, choices, objective, self.best.take());
        let limit = few.cost().map_or(u64::MAX, |[best, _]| best);
        while few.due.len() < MAX_ARRANGEMENTS && meter.left().steps > 0 {
            let Some((places, _)) = tree.next(limit, |places| bound_of(places, meter)) else { break };
            few.add(places, meter);
        }
        few.plan_all(meter);
        let planned = few.due.iter().map(|own| ordered(objective, own.bounds)[0]);
        let all = planned.chain(tree.least()).chain(few.cost().map(|[best, _]| best)).min();
        let figure = match objective {
            BoardObjective::Makespan => &mut self.bounds.makespan,
            BoardObjective::SumOfCosts => &mut self.bounds.sum_of_costs,
        };
        *figure = all.unwrap_or(*figure).max(*figure);
        self.best = few.best;
        let (_, why) = few.why.filter(|_| all.is_none())?;
        let count = counts.iter().fold(1, |count: usize, places| count.saturating_mul(*places));
        Some(Box::new(NoArrangement { count, ..*why }))
    }

    /// Whether the plans of an arrangement may be better than the best.
    fn is_hopeful(&self, operations: &[AssayOperation], meter: &mut Meter) -> bool {
        let Some([best, _]) = self.cost() else { return true };
        let limits = with_problem(self.site, operations, |_, problem| assay::bounds(&problem?, meter));
        limits.is_ok_and(|limits| ordered(self.objective, limits)[0] < best)
    }
}
