//! Visiting a set of cells in the best order, from a start and without return.
//!
//! Problem: the open travelling salesman path over optimal legs. Method: up to [`EXACT_PLACES`] places the dynamic programme of Held and Karp (1962); above,
//! nearest insertion, then 2-opt and or-opt to a local optimum, and the ascent on 1-trees of Held and Karp (1971) as lower bound.
//! Guaranteed: optimal where `cost == bound`. Cost: a search per pair of places; 2^n n² steps for n ≤ 12, n² per improvement above.

use super::field::Field;
use super::lattice::{Cell, Flip, Weights};
use super::outcome::{Impossible, Outcome, Path};
use super::pulses::{Train, pulses};
use super::shortest::shortest;
use crate::plan::search::{Budget, GaveUp, Meter};

/// Up to this many places the order is proven optimal.
pub const EXACT_PLACES: usize = 12;
/// Largest number of places; legs are found for every pair.
pub const MAX_PLACES: usize = 512;
/// Steps of the ascent on 1-trees.
const ASCENT: u32 = 300;
/// Penalties of the ascent are multiples of one part in this many.
const FINE: i64 = 64;

/// What a tour minimises.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Measure {
    /// Sum of the weights, one module at a time.
    Flips(Weights),
    /// Number of pulses, several modules at once where that is safe.
    Pulses,
}

/// The way from one place to the next.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Leg {
    /// One module at a time.
    Flips(Vec<Flip>),
    /// Several modules at once.
    Pulses(Train),
}

/// A tour.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Tour {
    /// Indices of the places in the order of their visits.
    pub order: Vec<usize>,
    /// The legs in that order, the first from the start.
    pub legs: Vec<Leg>,
    /// Sum of the legs' costs.
    pub cost: u64,
    /// No tour costs less; equal to `cost` when the tour is proven optimal.
    pub bound: u64,
    /// Steps of all searches for legs.
    pub expanded: u64,
}

/// The answer to a request for a tour.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum TourOutcome {
    /// A tour.
    Found(Tour),
    /// A place cannot be reached from the start.
    Impossible {
        /// Index of the first such place.
        place: usize,
        /// The proof.
        proof: Impossible,
    },
    /// The budget ran out, or there are more than [`MAX_PLACES`] places (nothing is spent then).
    GaveUp(GaveUp),
}

/// The best order in which to visit `places` from `start`.
pub fn tour(field: &Field, start: Cell, places: &[Cell], measure: &Measure, budget: Budget) -> TourOutcome {
    let mut meter = Meter::new(budget);
    if places.len() > MAX_PLACES {
        return TourOutcome::GaveUp(meter.gave_up(0));
    }
    let mut legs = Legs { field, measure, meter: &mut meter };
    let cells: Vec<Cell> = std::iter::once(start).chain(places.iter().copied()).collect();
    let table = match legs.table(&cells) {
        Ok(table) => table,
        Err(failure) => return failure,
    };
    let (order, bound) = match places.len() <= EXACT_PLACES {
        true => (exact(&table.costs), exact_bound(&table)),
        false => {
            let order = improved(&table.costs);
            let bound = ascent(&table.bounds, length(&table.costs, &order));
            (order, bound)
        }
    };
    let cost = length(&table.costs, &order);
    let bound = bound.min(cost);
    match legs.along(&cells, &order) {
        Ok(legs) => TourOutcome::Found(Tour {
            order: order.into_iter().map(|node| node - 1).collect(),
            legs,
            cost,
            bound,
            expanded: meter.spent(),
        }),
        Err(failure) => failure,
    }
}

/// Costs and lower bounds of all legs; node 0 is the start, node k + 1 is place k.
struct Table {
    costs: Vec<Vec<u64>>,
    bounds: Vec<Vec<u64>>,
}

struct Legs<'a> {
    field: &'a Field,
    measure: &'a Measure,
    meter: &'a mut Meter,
}

struct Found {
    leg: Leg,
    cost: u64,
    bound: u64,
}

impl Legs<'_> {
    fn table(&mut self, cells: &[Cell]) -> Result<Table, TourOutcome> {
        let n = cells.len();
        let (mut costs, mut bounds) = (vec![vec![0; n]; n], vec![vec![0; n]; n]);
        for a in 0..n {
            for b in a + 1..n {
                let found = self.leg(cells, a, b)?;
                (costs[a][b], costs[b][a]) = (found.cost, found.cost);
                (bounds[a][b], bounds[b][a]) = (found.bound, found.bound);
            }
        }
        Ok(Table { costs, bounds })
    }

    // Legs are found again rather than kept, since most of the table's are not used.
    fn along(&mut self, cells: &[Cell], order: &[usize]) -> Result<Vec<Leg>, TourOutcome> {
        let from = std::iter::once(0).chain(order.iter().copied());
        from.zip(order).map(|(a, &b)| self.leg(cells, a, b).map(|found| found.leg)).collect()
    }

    fn leg(&mut self, cells: &[Cell], a: usize, b: usize) -> Result<Found, TourOutcome> {
        // The same direction in both passes, so that both find the same cost.
        let (low, high) = (a.min(b), a.max(b));
        let budget = self.meter.left();
        let (outcome, spent) = match self.measure {
            Measure::Flips(weights) => {
                let outcome = shortest(self.field, cells[low], cells[high], weights, budget);
                by_flips(outcome, a > b)
            }
            Measure::Pulses => by_pulses(pulses(self.field, cells[low], cells[high], budget), a > b),
        };
        self.meter.charge(spent);
        match outcome {
            Outcome::Found(found) => Ok(found),
            Outcome::Impossible(proof) => Err(TourOutcome::Impossible { place: high - 1, proof }),
            Outcome::GaveUp(_) => Err(TourOutcome::GaveUp(self.meter.gave_up(0))),
        }
    }
}

fn by_flips(outcome: Outcome<Path>, backward: bool) -> (Outcome<Found>, u64) {
    match outcome {
        Outcome::Found(Path { mut flips, cost, bound, expanded }) => {
            if backward {
                flips.reverse();
            }
            let leg = Leg::Flips(flips);
            (Outcome::Found(Found { leg, cost, bound }), expanded)
        }
        Outcome::Impossible(proof) => (Outcome::Impossible(proof), proof.expanded),
        Outcome::GaveUp(report) => (Outcome::GaveUp(report), report.spent),
    }
}

fn by_pulses(outcome: Outcome<Train>, backward: bool) -> (Outcome<Found>, u64) {
    match outcome {
        Outcome::Found(mut train) => {
            if backward {
                train.pulses.reverse();
            }
            let (cost, bound, expanded) = (train.cost(), train.bound, train.expanded);
            let leg = Leg::Pulses(train);
            (Outcome::Found(Found { leg, cost, bound }), expanded)
        }
        Outcome::Impossible(proof) => (Outcome::Impossible(proof), proof.expanded),
        Outcome::GaveUp(report) => (Outcome::GaveUp(report), report.spent),
    }
}

/// Cost of visiting the nodes in that order from node 0.
fn length(costs: &[Vec<u64>], order: &[usize]) -> u64 {
    let from = std::iter::once(&0).chain(order);
    from.zip(order).map(|(&a, &b)| costs[a][b]).sum()
}

fn exact_bound(table: &Table) -> u64 {
    length(&table.bounds, &exact(&table.bounds))
}

/// Held and Karp's dynamic programme: the best order of all nodes but node 0.
fn exact(costs: &[Vec<u64>]) -> Vec<usize> {
    let n = costs.len() - 1;
    if n == 0 {
        return Vec::new();
    }
    // best[set][last]: least cost to visit the set and end at its member, with the member before.
    let mut best = vec![vec![(u64::MAX, 0); n]; 1 << n];
    for last in 0..n {
        best[1 << last][last] = (costs[0][last + 1], last);
    }
    for set in 1..1_usize << n {
        for last in (0..n).filter(|k| set >> k & 1 == 1) {
            let (cost, _) = best[set][last];
            for next in (0..n).filter(|k| set >> k & 1 == 0) {
                let reached = (cost + costs[last + 1][next + 1], last);
                let slot = &mut best[set | 1 << next][next];
                *slot = reached.min(*slot);
            }
        }
    }
    let mut set = (1 << n) - 1;
    let mut last = (0..n).min_by_key(|&k| best[set][k].0).unwrap_or(0);
    let mut order = Vec::with_capacity(n);
    while set != 0 {
        order.push(last + 1);
        let before = best[set][last].1;
        set &= !(1 << last);
        last = before;
    }
    order.reverse();
    order
}

/// Nearest insertion, then 2-opt and or-opt until neither improves.
fn improved(costs: &[Vec<u64>]) -> Vec<usize> {
    let mut order = insertion(costs);
    while two_opt(costs, &mut order) || or_opt(costs, &mut order) {}
    order
}

fn insertion(costs: &[Vec<u64>]) -> Vec<usize> {
    let mut order: Vec<usize> = Vec::new();
    let mut rest: Vec<usize> = (1..costs.len()).collect();
    let mut nearest: Vec<u64> = costs[0].clone();
    while let Some(at) = (0..rest.len()).min_by_key(|&k| nearest[rest[k]]) {
        let node = rest.remove(at);
        let place = (0..=order.len()).min_by_key(|&k| detour(costs, &order, k, node));
        order.insert(place.unwrap_or(0), node);
        for &other in &rest {
            nearest[other] = nearest[other].min(costs[node][other]);
        }
    }
    order
}

/// What it costs more to visit `node` before the `k`-th of the order.
fn detour(costs: &[Vec<u64>], order: &[usize], k: usize, node: usize) -> i64 {
    let before = if k == 0 { 0 } else { order[k - 1] };
    let to = costs[before][node] as i64;
    match order.get(k) {
        Some(&after) => to + costs[node][after] as i64 - costs[before][after] as i64,
        None => to,
    }
}

fn two_opt(costs: &[Vec<u64>], order: &mut [usize]) -> bool {
    let n = order.len();
    for first in 0..n {
        let before = if first == 0 { 0 } else { order[first - 1] };
        for last in first + 1..n {
            let (a, b) = (order[first], order[last]);
            let (mut old, mut new) = (costs[before][a], costs[before][b]);
            if let Some(&after) = order.get(last + 1) {
                old += costs[b][after];
                new += costs[a][after];
            }
            if new < old {
                order[first..=last].reverse();
                return true;
            }
        }
    }
    false
}

fn or_opt(costs: &[Vec<u64>], order: &mut Vec<usize>) -> bool {
    let old = length(costs, order);
    for run in 1..=3.min(order.len().saturating_sub(1)) {
        for first in 0..=order.len() - run {
            let mut rest = order.clone();
            let moved: Vec<usize> = rest.drain(first..first + run).collect();
            let (head, tail) = (moved[0], moved[run - 1]);
            let inside: u64 = moved.windows(2).map(|w| costs[w[0]][w[1]]).sum();
            let base = length(costs, &rest) + inside;
            for k in 0..=rest.len() {
                let before = if k == 0 { 0 } else { rest[k - 1] };
                let (mut new, mut cut) = (base + costs[before][head], 0);
                if let Some(&after) = rest.get(k) {
                    new += costs[tail][after];
                    cut = costs[before][after];
                }
                if new - cut < old {
                    rest.splice(k..k, moved);
                    *order = rest;
                    return true;
                }
            }
        }
    }
    false
}

/// A lower bound on every open path from node 0: the ascent on 1-trees, with a node of no cost that closes the path between its two ends.
fn ascent(costs: &[Vec<u64>], upper: u64) -> u64 {
    let n = costs.len();
    let mut penalty = vec![0_i64; n];
    let mut best = i64::MIN;
    for step in 0..ASCENT {
        let (tree, mut degree) = spanning_tree(costs, &penalty);
        let end = (1..n).min_by_key(|&k| penalty[k]).unwrap_or(0);
        degree[0] += 1;
        degree[end] += 1;
        let value = tree + penalty[0] + penalty[end] - 2 * penalty.iter().sum::<i64>();
        best = best.max(value);
        let square: i64 = degree.iter().map(|d| (d - 2) * (d - 2)).sum();
        let gap = upper as i64 * FINE - value;
        if square == 0 || gap <= 0 {
            break;
        }
        // The usual step of subgradient ascent, shrinking with time.
        let stride = (gap * i64::from(2 * (ASCENT - step)) / i64::from(ASCENT) / square).max(1);
        for (p, d) in penalty.iter_mut().zip(&degree) {
            *p += stride * (d - 2);
        }
    }
    let whole = best.div_euclid(FINE) + i64::from(best.rem_euclid(FINE) != 0);
    u64::try_from(whole).unwrap_or(0)
}

/// Prim's algorithm: the weight of the tree, times [`FINE`], and the degrees.
fn spanning_tree(costs: &[Vec<u64>], penalty: &[i64]) -> (i64, Vec<i64>) {
    let n = costs.len();
    let edge = |a: usize, b: usize| costs[a][b] as i64 * FINE + penalty[a] + penalty[b];
    let mut degree = vec![0; n];
    let mut near: Vec<(i64, usize)> = (0..n).map(|k| (edge(0, k), 0)).collect();
    let mut outside: Vec<usize> = (1..n).collect();
    let mut weight = 0;
    while let Some(at) = (0..outside.len()).min_by_key(|&k| near[outside[k]].0) {
        let node = outside.swap_remove(at);
        weight += near[node].0;
        degree[node] += 1;
        degree[near[node].1] += 1;
        for &other in &outside {
            near[other] = near[other].min((edge(node, other), node));
        }
    }
    (weight, degree)
}
