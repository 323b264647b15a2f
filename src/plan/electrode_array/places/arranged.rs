//! Chooses the places of operations for which the program names several.
//!
//! An arrangement has one place for each operation, and so is an assay without a choice. Method for few arrangements:
//! plan them in the order of their lower bounds, until no bound is below the best plan; first all by lists, then by
//! joint search. For more arrangements: plan those of some relaxed schedules, which ignore conflicts (`placement`) or,
//! where these yield no plan, random ones; then look for a better order for the best of them, and for arrangements that
//! differ from it in one place, as long as plans improve; then plan those with the least lower bounds (`place_tree`) as
//! if they were few. For a single arrangement, relaxed schedules suggest the order in which its parts take turns.
//!
//! Guaranteed: a plan is legal; `bounds` hold for the plans of every arrangement; "impossible" is returned only if
//! every arrangement is impossible. Cost: that of planning the arrangements, on one budget.

use super::critical_path::{self, BoardWays};
use super::lower_bounds;
use super::place_tree::PlaceTree;
use super::placement::{self, DropletWait, RelaxedSchedule, RelaxedTerms};
use crate::claims::electrode_array::{AssayOperation, ElectrodeArrayOrder};
use crate::plan::electrode_array::assay::{self, AssayEffort, AssayPlan, AssayProblem, NoAssayPlan};
use crate::plan::electrode_array::board::{BoardCosts, BoardObjective};
use crate::plan::electrode_array::errands::{self, AssaySite, PartCourse, PartErrands};
use crate::plan::electrode_array::one_by_one::one_by_one;
use crate::plan::electrode_array::stage::{self, BoardStage};
use crate::plan::search::{Meter, SearchAnswer};
use crate::random::SplitMix64;

/// Most arrangements for each of which a lower bound is computed, and most operations of all these arrangements
/// together: in a long assay each bound takes time.
const MAX_ARRANGEMENTS: usize = 1_000;
const MAX_BOUNDED_OPERATIONS: usize = 100_000;

/// 1/N of the remaining budget for one arrangement of several: by lists, and by joint search.
const LISTS_SHARE: u64 = 64;
const SHARE: u64 = 4;

/// All but 1/N of the remaining budget is for a better order of the best arrangement, if there are many.
const KEPT_SHARE: u64 = 4;

/// If there are many arrangements: most that are planned because they differ from the best one in one place.
const MAX_TRIED: usize = 200;

/// If there are many arrangements: most relaxed schedules, and most operations of all these schedules together.
const MAX_SCHEDULES: usize = 8;
const MAX_SCHEDULED_OPERATIONS: usize = 10_000;

/// Most random arrangements planned by lists where no relaxed schedule yields a plan, and then as many by joint search.
const MAX_DRAWN: usize = 100;

/// A plan with the places that it has chosen.
pub struct PlacedPlan {
    pub operations: Vec<AssayOperation>,
    /// One for each part of the order.
    pub courses: Vec<PartCourse>,
    costs: BoardCosts,
    /// Lower bounds on every plan, for any choice of places.
    pub bounds: BoardCosts,
}

/// Why no arrangement has a plan: the reason for the first one.
pub struct NoArrangement {
    pub operations: Vec<AssayOperation>,
    pub why: NoAssayPlan,
    /// Number of arrangements.
    pub count: usize,
}

type PlacedAnswer = SearchAnswer<PlacedPlan, Box<NoArrangement>, BoardCosts>;

/// Plans the operations at the best places found; where the search gave up, returns lower bounds on every plan.
pub fn solve(
    site: &AssaySite,
    operations: &[AssayOperation],
    objective: BoardObjective,
    meter: &mut Meter,
) -> PlacedAnswer {
    solve_each(site, operations, objective, MAX_ARRANGEMENTS.min(max_bound_count(operations)), meter)
}

/// Number of arrangements whose bounds are computed; at least one.
fn max_bound_count(operations: &[AssayOperation]) -> usize {
    (MAX_BOUNDED_OPERATIONS / operations.len().max(1)).max(1)
}

/// As [`solve`], with a lower bound for each arrangement if there are at most `most`.
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

/// Operations, some of which have several places.
struct Choices<'a> {
    operations: &'a [AssayOperation],
    /// The indices of the operations with several places.
    open: Vec<usize>,
}

impl Choices<'_> {
    fn of(operations: &[AssayOperation]) -> Choices<'_> {
        let open = (0..operations.len()).filter(|nth| !operations[*nth].among.is_empty()).collect();
        Choices { operations, open }
    }

    /// Number of places of each of them.
    fn counts(&self) -> impl Iterator<Item = usize> {
        self.open.iter().map(|nth| self.operations[*nth].among.len())
    }

    /// The number of arrangements; `None` for more than [`MAX_ARRANGEMENTS`].
    fn count(&self) -> Option<usize> {
        self.counts()
            .try_fold(1usize, |count, places| count.checked_mul(places).filter(|count| *count <= MAX_ARRANGEMENTS))
    }

    /// The places of the arrangement with a number; those of the last operation change first.
    fn places(&self, mut number: usize) -> Vec<usize> {
        let mut places = vec![0; self.open.len()];
        for (place, nth) in places.iter_mut().zip(&self.open).rev() {
            let of = self.operations[*nth].among.len();
            (*place, number) = (number % of, number / of);
        }
        places
    }

    /// The operations at given places.
    fn at(&self, places: &[usize]) -> Vec<AssayOperation> {
        let mut operations = self.operations.to_vec();
        for (nth, place) in self.open.iter().zip(places) {
            operations[*nth] = self.operations[*nth].at_place(*place);
        }
        operations
    }

    /// The places that a relaxed schedule chooses.
    fn chosen_by(&self, order: &ElectrodeArrayOrder, schedule: &RelaxedSchedule) -> Vec<usize> {
        let place = |nth: &usize| {
            let cell = schedule.cells[*nth]?;
            self.operations[*nth].among.iter().position(|place| stage::flat(order, place.stop.cell) == cell)
        };
        self.open.iter().map(|nth| place(nth).unwrap_or(0)).collect()
    }
}

/// Converts operations with one place each to a stage and an assay problem, and passes these to `look`.
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

/// Terms on which an arrangement is planned.
#[derive(Clone, Copy)]
struct ArrangementTerms<'a> {
    objective: BoardObjective,
    effort: AssayEffort,
    /// Relaxed schedules of the operations that suggest the order in which parts take turns.
    schedules: &'a [RelaxedSchedule],
}

/// Plans an arrangement.
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
        problem.relaxed_schedules = terms.schedules.iter().map(|schedule| schedule.of(&problem.operations)).collect();
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

/// A plan of the operations one after the other, with known bounds.
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

/// Plans the only arrangement.
fn only(site: &AssaySite, operations: &[AssayOperation], objective: BoardObjective, meter: &mut Meter) -> PlacedAnswer {
    let mut ways = BoardWays::new(site, meter);
    let timed = critical_path::timed(operations, &mut ways);
    let least = lower_bounds::bounds(operations, &timed, &mut ways).makespan;
    let schedule = |wait| placement::schedule(operations, &timed, &mut ways, RelaxedTerms { seed: 0, least, wait });
    let schedules = [DropletWait::AtOutlet, DropletWait::OnBoard].map(schedule);
    let terms = ArrangementTerms { objective, effort: AssayEffort::Whole, schedules: &schedules };
    match planned(site, operations.to_vec(), terms, meter) {
        SearchAnswer::GaveUp(bounds) => {
            let plan = in_turn(site, operations.to_vec(), objective, bounds);
            plan.map_or(SearchAnswer::GaveUp(bounds), SearchAnswer::Found)
        }
        answer => answer,
    }
}

/// Costs of a plan, that of the objective first.
fn cost(objective: BoardObjective, plan: &PlacedPlan) -> [u64; 2] {
    ordered(objective, plan.costs)
}

fn ordered(objective: BoardObjective, costs: BoardCosts) -> [u64; 2] {
    match objective {
        BoardObjective::Makespan => [costs.makespan, costs.sum_of_costs],
        BoardObjective::SumOfCosts => [costs.sum_of_costs, costs.makespan],
    }
}

/// Lower bounds that hold for both.
fn least(one: BoardCosts, other: BoardCosts) -> BoardCosts {
    BoardCosts { makespan: one.makespan.min(other.makespan), sum_of_costs: one.sum_of_costs.min(other.sum_of_costs) }
}

/// An arrangement that may have a plan.
struct Arrangement {
    places: Vec<usize>,
    /// Lower bounds on its plans.
    bounds: BoardCosts,
}

/// Planning of arrangements few enough to have a lower bound each.
struct FewArrangements<'a> {
    site: &'a AssaySite<'a>,
    choices: &'a Choices<'a>,
    objective: BoardObjective,
    /// Arrangements that may have a plan, by their bounds.
    due: Vec<Arrangement>,
    best: Option<PlacedPlan>,
    /// Among the arrangements without a plan, the first one and why it has none.
    why: Option<(Vec<usize>, Box<NoArrangement>)>,
}

impl<'a> FewArrangements<'a> {
    fn new(site: &'a AssaySite, choices: &'a Choices, objective: BoardObjective, best: Option<PlacedPlan>) -> Self {
        FewArrangements { site, choices, objective, due: Vec::new(), best, why: None }
    }

    fn cost(&self) -> Option<[u64; 2]> {
        self.best.as_ref().map(|plan| cost(self.objective, plan))
    }

    /// Whether an arrangement with these bounds may have a better plan than the best one.
    fn is_hopeful(&self, bounds: BoardCosts) -> bool {
        self.cost().is_none_or(|[best, _]| ordered(self.objective, bounds)[0] < best)
    }

    fn refuse(&mut self, places: Vec<usize>, why: Box<NoArrangement>) {
        if self.why.as_ref().is_none_or(|(first, _)| places < *first) {
            self.why = Some((places, why));
        }
    }

    /// Adds an arrangement, unless its bounds prove that it has no plan.
    fn add(&mut self, places: Vec<usize>, meter: &mut Meter) {
        let operations = self.choices.at(&places);
        match with_problem(self.site, &operations, |_, problem| assay::bounds(&problem?, meter)) {
            Ok(bounds) => self.due.push(Arrangement { places, bounds }),
            Err(why) => self.refuse(places, Box::new(NoArrangement { operations, why, count: 1 })),
        }
    }

    /// Plans the arrangements that may improve on the best plan, by lists, and then by joint search where fewer steps
    /// are not ruled out.
    fn plan_all(&mut self, meter: &mut Meter) {
        self.due.sort_by_cached_key(|own| (ordered(self.objective, own.bounds), own.places.clone()));
        self.plan(true, LISTS_SHARE, meter);
        if self.best.is_none() || self.objective == BoardObjective::Makespan {
            self.plan(false, SHARE, meter);
        }
    }

    /// Plans the arrangements that may improve on the best plan, by lists or by joint search, each on a share of the
    /// remaining budget.
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
                let terms = ArrangementTerms { objective, effort, schedules: &[] };
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

/// Plans all arrangements in the order of their bounds: first by lists, and then by joint search where fewer steps are
/// not ruled out.
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

/// Plans the arrangements of some relaxed schedules, and improves the best one.
fn of_many(site: &AssaySite, choices: &Choices, objective: BoardObjective, meter: &mut Meter) -> PlacedAnswer {
    let mut ways = BoardWays::new(site, meter);
    let timed = critical_path::timed(choices.operations, &mut ways);
    let bounds = lower_bounds::bounds(choices.operations, &timed, &mut ways);
    let mut many =
        ManyArrangements { site, choices, objective, bounds, best: None, places: Vec::new(), schedule: None };
    let schedules = (MAX_SCHEDULED_OPERATIONS / choices.operations.len().max(1)).clamp(1, MAX_SCHEDULES) as u64;
    for seed in 0..schedules {
        if many.is_least() {
            break;
        }
        let mut ways = BoardWays::new(site, meter);
        let wait = if seed % 2 == 0 { DropletWait::AtOutlet } else { DropletWait::OnBoard };
        let terms = RelaxedTerms { seed, least: bounds.makespan, wait };
        let schedule = placement::schedule(choices.operations, &timed, &mut ways, terms);
        many.realise(schedule, meter);
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

/// Planning of arrangements too many to have a lower bound each.
struct ManyArrangements<'a> {
    site: &'a AssaySite<'a>,
    choices: &'a Choices<'a>,
    objective: BoardObjective,
    bounds: BoardCosts,
    best: Option<PlacedPlan>,
    /// Places of the best plan.
    places: Vec<usize>,
    /// The relaxed schedule from which the best plan comes, if it does.
    schedule: Option<RelaxedSchedule>,
}

impl ManyArrangements<'_> {
    fn cost(&self) -> Option<[u64; 2]> {
        self.best.as_ref().map(|plan| cost(self.objective, plan))
    }

    fn is_least(&self) -> bool {
        self.cost().is_some_and(|[best, _]| best <= ordered(self.objective, self.bounds)[0])
    }

    /// Keeps a plan if it is better than the best one; returns whether it is.
    fn offer(&mut self, plan: PlacedPlan, places: Vec<usize>) -> bool {
        let is_better = self.cost().is_none_or(|best| cost(self.objective, &plan) < best);
        if is_better {
            (self.best, self.places) = (Some(plan), places);
        }
        is_better
    }

    /// Plans the arrangement of a relaxed schedule; while there is no plan, with every method.
    fn realise(&mut self, schedule: RelaxedSchedule, meter: &mut Meter) {
        let places = self.choices.chosen_by(self.site.order, &schedule);
        let operations = self.choices.at(&places);
        let schedules = std::slice::from_ref(&schedule);
        let mut found =
            self.planned(operations.clone(), AssayEffort::Lists, schedules, meter.left().steps / LISTS_SHARE, meter);
        if found.is_none() && self.best.is_none() {
            let steps = meter.left().steps / SHARE;
            let by_all_means = self.planned(operations.clone(), AssayEffort::Whole, schedules, steps, meter);
            found = by_all_means.or_else(|| in_turn(self.site, operations, self.objective, self.bounds));
        }
        if let Some(plan) = found
            && self.offer(plan, places)
        {
            self.schedule = Some(schedule);
        }
    }

    /// Where no relaxed schedule yields a plan: tries random arrangements until one does, by lists, and then with joint
    /// search too, which is quick where parts cannot pass.
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

    /// Plans an arrangement within `steps` steps of the budget.
    fn planned(
        &self,
        operations: Vec<AssayOperation>,
        effort: AssayEffort,
        schedules: &[RelaxedSchedule],
        steps: u64,
        meter: &mut Meter,
    ) -> Option<PlacedPlan> {
        let terms = ArrangementTerms { objective: self.objective, effort, schedules };
        match meter.share(steps, |part| planned(self.site, operations, terms, part)) {
            SearchAnswer::Found(plan) => Some(plan),
            SearchAnswer::Impossible(_) | SearchAnswer::GaveUp(_) => None,
        }
    }

    /// Looks for a better order at the places of the best plan, with most of the budget.
    fn better_order(&mut self, meter: &mut Meter) {
        let Some(schedule) = self.schedule.take().filter(|_| !self.is_least()) else { return };
        let (places, left) = (self.places.clone(), meter.left().steps);
        let (operations, steps) = (self.choices.at(&places), left - left / KEPT_SHARE);
        if let Some(plan) = self.planned(operations, AssayEffort::Lists, &[schedule], steps, meter) {
            self.offer(plan, places);
        }
    }

    /// Plans arrangements that differ from the best one in one place, as long as plans improve.
    fn improve(&mut self, meter: &mut Meter) {
        let (mut bounded, mut tried, mut is_better) = (0, 0, self.best.is_some());
        let max_bound_count = max_bound_count(self.choices.operations);
        while std::mem::take(&mut is_better) {
            for open in 0..self.places.len() {
                for place in 0..self.choices.operations[self.choices.open[open]].among.len() {
                    let is_over = bounded >= max_bound_count || tried >= MAX_TRIED || meter.left().steps == 0;
                    if place == self.places[open] || self.is_least() || is_over {
                        continue;
                    }
                    bounded += 1;
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

    /// Plans the arrangements whose lower bounds are least and below the best plan, as if they were few; the least
    /// bound of all others bounds the rest. Returns the reason for the first arrangement if none has a plan.
    fn plan_least_bounds(&mut self, meter: &mut Meter) -> Option<Box<NoArrangement>> {
        if self.is_least() {
            return None;
        }
        let (site, choices, objective) = (self.site, self.choices, self.objective);
        let bound_of = |places: &[usize], meter: &mut Meter| {
            let operations = choices.at(places);
            let mut ways = BoardWays::new(site, meter);
            let timed = critical_path::timed(&operations, &mut ways);
            ordered(objective, lower_bounds::bounds(&operations, &timed, &mut ways))[0]
        };
        let counts: Vec<usize> = choices.counts().collect();
        let mut tree = PlaceTree::new(&counts, ordered(objective, self.bounds)[0], max_bound_count(choices.operations));
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

    /// Whether an arrangement may have a better plan than the best one.
    fn is_hopeful(&self, operations: &[AssayOperation], meter: &mut Meter) -> bool {
        let Some([best, _]) = self.cost() else { return true };
        let limits = with_problem(self.site, operations, |_, problem| assay::bounds(&problem?, meter));
        limits.is_ok_and(|limits| ordered(self.objective, limits)[0] < best)
    }
}
