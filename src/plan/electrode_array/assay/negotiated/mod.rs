//! Droplets one after the other, which negotiate about the cells that their traces would close to others.
//!
//! Where droplets keep out of each other's traces, lists fail: each agent takes its shortest way, and leaves there what closes it to those
//! that come later. Here nobody is closed out at first.
//!
//! Method: errands are done in turn, the first of an order that can be done. Each way is a cheapest one, on which cells with harmful traces
//! are dear, but open. Each cell at which harm was done gets dearer for everyone, and all ways are planned anew, until none does harm: negotiated congestion (PathFinder: McMurchie and Ebeling, FPGA 1995),
//! with traces in place of wires. In time, each move is made as soon as those that were near its cell before, in this order, have left, so
//! droplets that keep apart do their errands at the same time, and who comes to a cell after whom stays what it was. Orders to begin with: one
//! droplet (agents that merge, or come out of one another) after the other, and those of courses that were planned otherwise, such as without
//! regard to traces; where none does, one in which droplets have other places. Then orders in which some errands of a droplet have another
//! place, as long as they are no worse.
//!
//! Guaranteed: a plan is legal. Not guaranteed: that one is found, or that it is short: nobody steps aside for a droplet that comes later.
//! Cost: one step of the budget for each [`droplet_turns::CELLS_PER_STEP`] cells that the search of a way expands, and for each [`INSTANTS_PER_STEP`]
//! instants of the courses.

mod droplet_turns;

use super::aside::as_replayed;
use super::bound::{self, AssayBounds};
use super::lists::{below, last_done, moved_to};
use super::replay::done_by;
use super::route::Ahead;
use super::{AgentCourse, AssayPlan, AssayProblem, ErrandPlace};
use crate::plan::electrode_array::board::BoardObjective;
use crate::plan::search::Meter;
use crate::random::SplitMix64;
use droplet_turns::{CheapestWay, DropletTurns};

/// Most rounds of negotiation until an order is given up.
const ROUNDS: usize = 240;

/// Orders that are tried until there is a plan, and then without a better one.
const ORDERS: usize = 500;

/// Most rounds of negotiation of an order that is to be better than a known one.
const ROUNDS_OF_OTHERS: usize = 12;

/// Instants of courses for one step of the budget.
const INSTANTS_PER_STEP: u64 = 16;

/// What a step to a cell at which harm was done costs more from then on.
const TOLL: u32 = 3;

/// One change of an order in this many brings forward the droplet that is done last.
const LAST_IN: usize = 4;

/// Seed of the changes of orders.
const SEED: u64 = 1;

/// The best courses found, if any, from the order of the program on, and from that of some courses.
pub(super) fn best(
    problem: &AssayProblem,
    ahead: &Ahead,
    known: &[Vec<AgentCourse>],
    objective: BoardObjective,
    least: &AssayBounds,
    meter: &mut Meter,
) -> Option<Vec<AgentCourse>> {
    let mut negotiation = Negotiation::new(problem, ahead, least.costs.makespan);
    let key = |courses: &[AgentCourse]| AssayPlan::costs(courses).key(objective);
    let mut random = SplitMix64::new(SEED);
    let drops = negotiation.in_order_of_program();
    let in_turn = negotiation.in_turn(&drops);
    let seeds = std::iter::once(in_turn).chain(known.iter().map(|courses| in_order_of(problem, courses)));
    let first = |order| negotiation.first_courses(order, meter);
    let best = seeds.filter_map(first).min_by_key(|(courses, _)| key(courses));
    let (mut best, mut order) = best.or_else(|| negotiation.by_changes(drops, &mut random, meter))?;
    let mut idle = 0;
    while idle < ORDERS && meter.left().steps > 0 && !AssayPlan::is_least(&best, objective, least.costs) {
        let other = negotiation.changed(&order, Some(best.as_slice()).filter(|_| idle % LAST_IN == 0), &mut random);
        let tolls = negotiation.ways.tolls.clone();
        idle += 1;
        match negotiation.courses(&other, ROUNDS_OF_OTHERS, meter) {
            Some(new) if key(&new) <= key(&best) => {
                idle = if key(&new) == key(&best) { idle } else { 0 };
                (best, order) = (new, other);
            }
            Some(_) | None => negotiation.ways.tolls = tolls,
        }
    }
    Some(best)
}

/// Errands in the order in which they are done.
type ErrandOrder = Vec<ErrandPlace>;

/// The errands in the order in which some courses come to their stops.
fn in_order_of(problem: &AssayProblem, courses: &[AgentCourse]) -> ErrandOrder {
    let done_by = done_by(problem, courses);
    let comes = |place: &ErrandPlace| {
        let done = done_by[place.agent].get(place.errand).copied().unwrap_or(u32::MAX);
        done.saturating_sub(problem.errands[place.agent][place.errand].work())
    };
    let mut order: ErrandOrder = problem.places().collect();
    order.sort_by_key(comes);
    order
}

/// The first operation that is done with an errand of an agent, or after it.
fn next_operation(problem: &AssayProblem, from: ErrandPlace) -> usize {
    problem.operations[from.agent][from.errand..].iter().flatten().next().copied().unwrap_or(usize::MAX)
}

/// An order with each item behind those that come before it, as far as that is possible; `befores` puts these on the stack that it is
/// given, and `is_first` tells the first time that it is asked about an item from the others.
fn behind_befores<T: Copy>(
    order: impl DoubleEndedIterator<Item = T>,
    mut is_first: impl FnMut(T) -> bool,
    befores: impl Fn(T, &mut Vec<(T, bool)>),
) -> Vec<T> {
    let mut sorted = Vec::new();
    // An item is there twice: until those before it are sorted, and then.
    let mut open: Vec<(T, bool)> = order.rev().map(|item| (item, false)).collect();
    while let Some((item, is_last)) = open.pop() {
        if is_last {
            sorted.push(item);
        } else if is_first(item) {
            open.push((item, true));
            befores(item, &mut open);
        }
    }
    sorted
}

struct Negotiation<'a> {
    problem: &'a AssayProblem<'a>,
    /// By agent, the droplet that it becomes.
    heads: Vec<usize>,
    /// By droplet, its errands in the order of their operations.
    drops: Vec<ErrandOrder>,
    /// By droplet: those whose errands come before some of its own.
    befores: Vec<Vec<usize>>,
    ways: CheapestWay<'a>,
}

impl<'a> Negotiation<'a> {
    fn new(problem: &'a AssayProblem<'a>, ahead: &'a Ahead, least: u64) -> Negotiation<'a> {
        let heads = bound::drops(problem);
        let mut drops: Vec<ErrandOrder> = vec![Vec::new(); heads.len()];
        let mut befores: Vec<Vec<usize>> = vec![Vec::new(); heads.len()];
        problem.places().for_each(|place| drops[heads[place.agent]].push(place));
        drops.iter_mut().for_each(|own| own.sort_by_key(|place| next_operation(problem, *place)));
        for (agent, drop) in heads.iter().enumerate() {
            let others = problem.afters[agent].iter().flatten().map(|before| heads[before.agent]);
            befores[*drop].extend(others.filter(|other| other != drop));
        }
        let ways = CheapestWay::new(ahead, least, problem.instance.board.cells());
        Negotiation { problem, heads, drops, befores, ways }
    }

    /// The droplets in the order of their first operations.
    fn in_order_of_program(&self) -> Vec<usize> {
        let mut order: Vec<usize> = (0..self.drops.len()).filter(|drop| !self.drops[*drop].is_empty()).collect();
        order.sort_by_key(|drop| self.drops[*drop].first().map(|first| next_operation(self.problem, *first)));
        order
    }

    /// The errands of one droplet after the other, with each droplet behind those that come before it, as far as that is possible.
    fn in_turn(&self, order: &[usize]) -> ErrandOrder {
        let mut is_seen = vec![false; self.drops.len()];
        let drops = behind_befores(
            order.iter().copied(),
            |drop| !std::mem::replace(&mut is_seen[drop], true),
            |drop, open| open.extend(self.befores[drop].iter().rev().map(|before| (*before, false))),
        );
        drops.into_iter().flat_map(|drop| self.drops[drop].iter().copied()).collect()
    }

    /// Courses in an order about which nothing is known yet.
    fn first_courses(&mut self, order: ErrandOrder, meter: &mut Meter) -> Option<(Vec<AgentCourse>, ErrandOrder)> {
        self.ways.tolls.fill(0);
        Some((self.courses(&order, ROUNDS, meter)?, order))
    }

    /// Courses in an order in which droplets have other places.
    fn by_changes(
        &mut self,
        mut drops: Vec<usize>,
        random: &mut SplitMix64,
        meter: &mut Meter,
    ) -> Option<(Vec<AgentCourse>, ErrandOrder)> {
        for _ in 0..ORDERS {
            drops = moved_to(&drops, below(random, drops.len()), below(random, drops.len()));
            let found = self.first_courses(self.in_turn(&drops), meter);
            if found.is_some() || meter.left().steps == 0 {
                return found;
            }
        }
        None
    }

    /// An order in which some errands of a droplet have another place; of that which some courses end with they come earlier.
    fn changed(
        &self,
        order: &[ErrandPlace],
        ends_with: Option<&[AgentCourse]>,
        random: &mut SplitMix64,
    ) -> ErrandOrder {
        let last = ends_with.and_then(|courses| last_done(courses).pop());
        let drop = self.heads[last.unwrap_or_else(|| order[below(random, order.len())].agent)];
        let own: Vec<usize> = (0..order.len()).filter(|place| self.heads[order[*place].agent] == drop).collect();
        let from = if below(random, 2) == 0 { 0 } else { below(random, own.len()) };
        let to = if below(random, 2) == 0 { own.len() } else { from + 1 + below(random, own.len() - from) };
        let block = &own[from..to];
        let mut rest: ErrandOrder = Vec::with_capacity(order.len());
        rest.extend(order.iter().enumerate().filter(|(place, _)| !block.contains(place)).map(|(_, errand)| *errand));
        let end = if last.is_some() { block[0] } else { rest.len() };
        // Mostly before all that another droplet does.
        let mut at = below(random, end + 1);
        if below(random, 2) == 0 && at < rest.len() {
            let other = self.heads[rest[at].agent];
            at = rest.iter().position(|errand| self.heads[errand.agent] == other).unwrap_or(at);
        }
        rest.splice(at..at, block.iter().map(|place| order[*place]));
        rest
    }

    /// An order with each errand behind those that come before it, as far as that is possible.
    fn sorted(&self, order: &[ErrandPlace]) -> ErrandOrder {
        let problem = self.problem;
        let mut is_seen: Vec<Vec<bool>> = problem.errands.iter().map(|errands| vec![false; errands.len()]).collect();
        behind_befores(
            order.iter().copied(),
            |place| !std::mem::replace(&mut is_seen[place.agent][place.errand], true),
            |place, open| {
                // Those of who comes to it last, so that they are sorted first.
                for of in std::iter::once(place).chain(problem.partner(place)) {
                    let own = of.errand.checked_sub(1).map(|errand| ErrandPlace { errand, ..of });
                    let before = own.or_else(|| problem.given_off_by(of.agent));
                    let afters = problem.afters[of.agent].get(of.errand).into_iter().flatten().copied();
                    open.extend(before.into_iter().chain(afters).map(|before| (before, false)));
                }
            },
        )
    }

    /// Courses that do no harm, with errands in an order.
    fn courses(&mut self, order: &[ErrandPlace], rounds: usize, meter: &mut Meter) -> Option<Vec<AgentCourse>> {
        let order = &self.sorted(order);
        for _ in 0..rounds {
            meter.step()?;
            let mut turns = DropletTurns::new(self.problem);
            let is_done = turns.run(order, &mut self.ways);
            let instants: u64 = turns.courses.iter().map(|course| course.cells.len() as u64).sum();
            meter.charge(std::mem::take(&mut self.ways.steps) + instants / INSTANTS_PER_STEP);
            is_done?;
            if turns.harmed.is_empty() {
                return as_replayed(self.problem, turns.courses);
            }
            turns.harmed.iter().for_each(|cell| self.ways.tolls[*cell as usize] += TOLL);
        }
        None
    }
}
