//! Droplets planned one after the other, with negotiation about the cells that their traces would close to others.
//!
//! Where droplets keep out of each other's traces, lists fail: each agent takes its shortest path, and the trace that
//! it leaves closes cells to agents that are planned later. Here no cell is closed at first.
//!
//! Method: errands are done in turn, in each turn the first one of the order that can be done. Each path is a cheapest
//! one, on which cells with harmful traces are expensive but open. Each cell where contamination occurred gets more
//! expensive for everyone, and all paths are planned anew until nobody is contaminated: negotiated congestion
//! (PathFinder: McMurchie and Ebeling, FPGA 1995), with traces in place of wires. In time, each move is made as soon as
//! the agents that were near its cell before, in this order, have left; so droplets that keep apart do their errands at
//! the same time, and the order of visits to a cell does not change. Initial orders: one droplet (agents that merge or
//! split) after the other, and the orders of known courses, such as courses that ignore traces; where none of these
//! works, random permutations of the droplets. From each of them, the best one first, local search moves some errands
//! of a droplet to another place in the order, as long as the plan is no worse.
//!
//! Guaranteed: a plan is legal. Not guaranteed: that one is found, or that it is short, since nobody steps aside for a
//! droplet that comes later. Cost: one step of the budget for each [`droplet_turns::CELLS_PER_STEP`] cells that the
//! path search expands, and for each [`INSTANTS_PER_STEP`] instants of the courses.

mod droplet_turns;

use super::bound::{self, AssayBounds};
use super::detours::as_replayed;
use super::lists::{below, last_done, moved_to};
use super::replay::done_by;
use super::route::StopDistances;
use super::{AgentCourse, AssayPlan, AssayProblem, ErrandPlace};
use crate::plan::electrode_array::board::BoardObjective;
use crate::plan::search::Meter;
use crate::random::SplitMix64;
use droplet_turns::{CheapestWay, DropletTurns};

/// Most rounds of negotiation before an order is abandoned.
const ROUNDS: usize = 240;

/// Most orders tried until there is a plan, and then without an improvement.
const ORDERS: usize = 500;

/// Most rounds of negotiation of a changed order.
const ROUNDS_OF_OTHERS: usize = 12;

/// Instants of courses for one step of the budget.
const INSTANTS_PER_STEP: u64 = 16;

/// Extra cost, from then on, of a step to a cell where contamination occurred.
const TOLL: u32 = 3;

/// One change in N of an order moves the droplet that is done last forward.
const LAST_IN: usize = 4;

/// Random seed of the changes.
const SEED: u64 = 1;

/// The best courses found, if any, from the order of the program and from the orders of known courses.
pub(super) fn best(
    problem: &AssayProblem,
    ahead: &StopDistances,
    known: &[Vec<AgentCourse>],
    objective: BoardObjective,
    least: &AssayBounds,
    meter: &mut Meter,
) -> Option<Vec<AgentCourse>> {
    let mut negotiation = Negotiation::new(problem, ahead, least.costs.makespan);
    let key = |courses: &[AgentCourse]| AssayPlan::costs(courses).key(objective);
    let mut random = SplitMix64::new(SEED);
    let droplets = negotiation.in_order_of_program();
    let in_turn = negotiation.in_turn(&droplets);
    let seeds = std::iter::once(in_turn).chain(known.iter().map(|courses| in_order_of(problem, courses)));
    let mut firsts: Vec<NegotiatedOrder> = seeds.filter_map(|order| negotiation.first_courses(order, meter)).collect();
    if firsts.is_empty() {
        firsts.extend(negotiation.by_changes(droplets, &mut random, meter));
    }
    firsts.sort_by_key(|first| key(&first.courses));
    let is_least = |courses: &[AgentCourse]| AssayPlan::is_least(courses, objective, least.costs);
    let mut best: Option<Vec<AgentCourse>> = None;
    for first in firsts {
        if best.as_ref().is_some_and(|best| is_least(best) || meter.left().steps == 0) {
            break;
        }
        let found = negotiation.improved(first, objective, is_least, &mut random, meter);
        best = best.into_iter().chain([found]).min_by_key(|courses| key(courses));
    }
    best
}

/// Courses with the order of errands from which they come, and the tolls of their negotiation.
struct NegotiatedOrder {
    courses: Vec<AgentCourse>,
    order: ErrandOrder,
    tolls: Vec<u32>,
}

/// Errands in the order in which they are done.
type ErrandOrder = Vec<ErrandPlace>;

/// The errands in the order in which they begin in some courses.
fn in_order_of(problem: &AssayProblem, courses: &[AgentCourse]) -> ErrandOrder {
    let done_by = done_by(problem, courses);
    let begin = |place: &ErrandPlace| {
        let done = done_by[place.agent].get(place.errand).copied().unwrap_or(u32::MAX);
        done.saturating_sub(problem.errands[place.agent][place.errand].work())
    };
    let mut order: ErrandOrder = problem.places().collect();
    order.sort_by_key(begin);
    order
}

/// The first operation of an agent at or after an errand.
fn next_operation(problem: &AssayProblem, from: ErrandPlace) -> usize {
    problem.operations[from.agent][from.errand..].iter().flatten().next().copied().unwrap_or(usize::MAX)
}

/// The order with each item moved behind its predecessors, as far as possible (depth-first topological sort). `befores`
/// pushes the predecessors of an item on the stack; `is_first` returns true the first time it is asked about an item.
fn behind_befores<T: Copy>(
    order: impl DoubleEndedIterator<Item = T>,
    mut is_first: impl FnMut(T) -> bool,
    befores: impl Fn(T, &mut Vec<(T, bool)>),
) -> Vec<T> {
    let mut sorted = Vec::new();
    // Each item is on the stack twice: first to push its predecessors, then to be output after them.
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
    /// By agent, the number of its droplet.
    droplet_of: Vec<usize>,
    /// By droplet, its errands in the order of their operations.
    droplets: Vec<ErrandOrder>,
    /// By droplet: other droplets with errands that must come before some of its own.
    befores: Vec<Vec<usize>>,
    ways: CheapestWay<'a>,
}

impl<'a> Negotiation<'a> {
    fn new(problem: &'a AssayProblem<'a>, ahead: &'a StopDistances, least: u64) -> Negotiation<'a> {
        let droplet_of = bound::droplet_of(problem);
        let mut droplets: Vec<ErrandOrder> = vec![Vec::new(); droplet_of.len()];
        let mut befores: Vec<Vec<usize>> = vec![Vec::new(); droplet_of.len()];
        problem.places().for_each(|place| droplets[droplet_of[place.agent]].push(place));
        droplets.iter_mut().for_each(|own| own.sort_by_key(|place| next_operation(problem, *place)));
        for (agent, droplet) in droplet_of.iter().enumerate() {
            let others = problem.afters[agent].iter().flatten().map(|before| droplet_of[before.agent]);
            befores[*droplet].extend(others.filter(|other| other != droplet));
        }
        let ways = CheapestWay::new(ahead, least, problem.instance.board.cells());
        Negotiation { problem, droplet_of, droplets, befores, ways }
    }

    /// The droplets in the order of their first operations.
    fn in_order_of_program(&self) -> Vec<usize> {
        let mut order: Vec<usize> =
            (0..self.droplets.len()).filter(|droplet| !self.droplets[*droplet].is_empty()).collect();
        order.sort_by_key(|droplet| self.droplets[*droplet].first().map(|first| next_operation(self.problem, *first)));
        order
    }

    /// The errands of one droplet after the other, with each droplet behind its predecessors, as far as possible.
    fn in_turn(&self, order: &[usize]) -> ErrandOrder {
        let mut is_seen = vec![false; self.droplets.len()];
        let droplets = behind_befores(
            order.iter().copied(),
            |droplet| !std::mem::replace(&mut is_seen[droplet], true),
            |droplet, open| open.extend(self.befores[droplet].iter().rev().map(|before| (*before, false))),
        );
        droplets.into_iter().flat_map(|droplet| self.droplets[droplet].iter().copied()).collect()
    }

    /// Courses in a new order, without tolls from earlier ones.
    fn first_courses(&mut self, order: ErrandOrder, meter: &mut Meter) -> Option<NegotiatedOrder> {
        self.ways.tolls.fill(0);
        let courses = self.courses(&order, ROUNDS, meter)?;
        Some(NegotiatedOrder { courses, order, tolls: self.ways.tolls.clone() })
    }

    /// Local search from an order: the best courses found.
    fn improved(
        &mut self,
        first: NegotiatedOrder,
        objective: BoardObjective,
        is_least: impl Fn(&[AgentCourse]) -> bool,
        random: &mut SplitMix64,
        meter: &mut Meter,
    ) -> Vec<AgentCourse> {
        let key = |courses: &[AgentCourse]| AssayPlan::costs(courses).key(objective);
        let NegotiatedOrder { courses: mut best, mut order, mut tolls } = first;
        let mut idle = 0;
        while idle < ORDERS && meter.left().steps > 0 && !is_least(&best) {
            let other = self.changed(&order, Some(best.as_slice()).filter(|_| idle % LAST_IN == 0), random);
            self.ways.tolls.clone_from(&tolls);
            idle += 1;
            match self.courses(&other, ROUNDS_OF_OTHERS, meter) {
                Some(new) if key(&new) <= key(&best) => {
                    idle = if key(&new) == key(&best) { idle } else { 0 };
                    (best, order) = (new, other);
                    tolls.clone_from(&self.ways.tolls);
                }
                Some(_) | None => {}
            }
        }
        best
    }

    /// Courses in a permuted order of the droplets.
    fn by_changes(
        &mut self,
        mut droplets: Vec<usize>,
        random: &mut SplitMix64,
        meter: &mut Meter,
    ) -> Option<NegotiatedOrder> {
        for _ in 0..ORDERS {
            droplets = moved_to(&droplets, below(random, droplets.len()), below(random, droplets.len()));
            let found = self.first_courses(self.in_turn(&droplets), meter);
            if found.is_some() || meter.left().steps == 0 {
                return found;
            }
        }
        None
    }

    /// The order with some errands of a droplet moved. If courses are given, the droplet is one that is done last in
    /// them, and its errands move forward.
    fn changed(
        &self,
        order: &[ErrandPlace],
        ends_with: Option<&[AgentCourse]>,
        random: &mut SplitMix64,
    ) -> ErrandOrder {
        let last = ends_with.and_then(|courses| last_done(courses).pop());
        let droplet = self.droplet_of[last.unwrap_or_else(|| order[below(random, order.len())].agent)];
        let own: Vec<usize> =
            (0..order.len()).filter(|place| self.droplet_of[order[*place].agent] == droplet).collect();
        let from = if below(random, 2) == 0 { 0 } else { below(random, own.len()) };
        let to = if below(random, 2) == 0 { own.len() } else { from + 1 + below(random, own.len() - from) };
        let block = &own[from..to];
        let mut rest: ErrandOrder = Vec::with_capacity(order.len());
        rest.extend(order.iter().enumerate().filter(|(place, _)| !block.contains(place)).map(|(_, errand)| *errand));
        let end = if last.is_some() { block[0] } else { rest.len() };
        // Half of the time, before everything that another droplet does.
        let mut at = below(random, end + 1);
        if below(random, 2) == 0 && at < rest.len() {
            let other = self.droplet_of[rest[at].agent];
            at = rest.iter().position(|errand| self.droplet_of[errand.agent] == other).unwrap_or(at);
        }
        rest.splice(at..at, block.iter().map(|place| order[*place]));
        rest
    }

    /// The order with each errand moved behind its predecessors, as far as possible.
    fn sorted(&self, order: &[ErrandPlace]) -> ErrandOrder {
        let problem = self.problem;
        let mut is_seen: Vec<Vec<bool>> = problem.errands.iter().map(|errands| vec![false; errands.len()]).collect();
        behind_befores(
            order.iter().copied(),
            |place| !std::mem::replace(&mut is_seen[place.agent][place.errand], true),
            |place, open| {
                // The agent's own previous errands are pushed last for its partner too, so that they are sorted first.
                for of in std::iter::once(place).chain(problem.partner(place)) {
                    let own = of.errand.checked_sub(1).map(|errand| ErrandPlace { errand, ..of });
                    let before = own.or_else(|| problem.split_of(of.agent));
                    let afters = problem.afters[of.agent].get(of.errand).into_iter().flatten().copied();
                    open.extend(before.into_iter().chain(afters).map(|before| (before, false)));
                }
            },
        )
    }

    /// Courses without contamination, with the errands in an order.
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
