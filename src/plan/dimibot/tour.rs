//! Tour of many places: a good order, and a lower bound on all orders.
//!
//! Problem: the open travelling salesman path from node 0 over all places, on to a fixed end if there is one. Method: nearest
//! insertion, then 2-opt and or-opt to a local optimum; as lower bound the ascent on 1-trees of Held and Karp (1971). Guaranteed:
//! no order costs less than the result of [`ascent`]. Cost: n² per improvement.

/// Steps of the ascent on 1-trees.
const ASCENT: u32 = 300;
/// Fixed-point denominator of the penalties of the ascent.
const FINE: i64 = 64;

/// Costs between nodes, symmetric; the path begins at node 0.
pub(super) struct TourCosts {
    pub(super) costs: Vec<Vec<u64>>,
    /// The node on which the path ends after all places; the last one.
    pub(super) end: Option<usize>,
}

impl TourCosts {
    /// Number of nodes between the beginning and a fixed end.
    fn places(&self) -> usize {
        self.costs.len() - 1 - usize::from(self.end.is_some())
    }

    /// Cost of visiting the places in this order.
    pub(super) fn length(&self, order: &[usize]) -> u64 {
        let from = std::iter::once(&0).chain(order);
        let last = order.last().copied().unwrap_or(0);
        from.zip(order).map(|(&a, &b)| self.costs[a][b]).sum::<u64>() + self.end.map_or(0, |end| self.costs[last][end])
    }

    /// The node at position `k` of the order, or the end after it.
    fn at(&self, order: &[usize], k: usize) -> Option<usize> {
        order.get(k).copied().or(self.end)
    }
}

/// Nearest insertion, then 2-opt and or-opt until neither improves.
pub(super) fn improved(table: &TourCosts) -> Vec<usize> {
    let mut order = insertion(table);
    while two_opt(table, &mut order) || or_opt(table, &mut order) {}
    order
}

fn insertion(table: &TourCosts) -> Vec<usize> {
    let costs = &table.costs;
    let mut order: Vec<usize> = Vec::new();
    let mut rest: Vec<usize> = (1..=table.places()).collect();
    let mut nearest: Vec<u64> = costs[0].clone();
    while let Some(at) = (0..rest.len()).min_by_key(|&k| nearest[rest[k]]) {
        let node = rest.remove(at);
        let place = (0..=order.len()).min_by_key(|&k| detour(table, &order, k, node));
        order.insert(place.unwrap_or(0), node);
        for &other in &rest {
            nearest[other] = nearest[other].min(costs[node][other]);
        }
    }
    order
}

/// Extra cost of visiting `node` before position `k` of the order.
fn detour(table: &TourCosts, order: &[usize], k: usize, node: usize) -> i64 {
    let costs = &table.costs;
    let before = if k == 0 { 0 } else { order[k - 1] };
    let to = costs[before][node] as i64;
    match table.at(order, k) {
        Some(after) => to + costs[node][after] as i64 - costs[before][after] as i64,
        None => to,
    }
}

fn two_opt(table: &TourCosts, order: &mut [usize]) -> bool {
    let costs = &table.costs;
    let n = order.len();
    for first in 0..n {
        let before = if first == 0 { 0 } else { order[first - 1] };
        for last in first + 1..n {
            let (a, b) = (order[first], order[last]);
            let (mut old, mut new) = (costs[before][a], costs[before][b]);
            if let Some(after) = table.at(order, last + 1) {
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

fn or_opt(table: &TourCosts, order: &mut Vec<usize>) -> bool {
    let costs = &table.costs;
    let old = table.length(order);
    for run in 1..=3.min(order.len().saturating_sub(1)) {
        for first in 0..=order.len() - run {
            let mut rest = order.clone();
            let moved: Vec<usize> = rest.drain(first..first + run).collect();
            let (head, tail) = (moved[0], moved[run - 1]);
            let inside: u64 = moved.windows(2).map(|w| costs[w[0]][w[1]]).sum();
            let base = table.length(&rest) + inside;
            for k in 0..=rest.len() {
                let before = if k == 0 { 0 } else { rest[k - 1] };
                let (mut new, mut cut) = (base + costs[before][head], 0);
                if let Some(after) = table.at(&rest, k) {
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

/// A lower bound on every path: ascent on 1-trees, with an extra node of cost 0 that closes the path between its two ends. `upper`
/// is the cost of some path.
pub(super) fn ascent(table: &TourCosts, upper: u64) -> u64 {
    let costs = &table.costs;
    let n = costs.len();
    let mut penalty = vec![0_i64; n];
    let mut best = i64::MIN;
    for step in 0..ASCENT {
        let (tree, mut degree) = spanning_tree(costs, &penalty);
        let end = table.end.or_else(|| (1..n).min_by_key(|&k| penalty[k])).unwrap_or(0);
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

/// Prim's algorithm: the weight of the minimum spanning tree, times [`FINE`], and the degrees.
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
