//! Enumerates choices of places in the order of their lower bounds, mostly without writing them down.
//!
//! Method: best-first branch and bound. A node fixes the places of the first operations with several places; its bound
//! holds for any places of the others. Guaranteed: no choice comes before one whose bound is lower, and
//! [`PlaceTree::least`] bounds all choices that have not come yet. Cost: for each expanded node, a bound for each place
//! of the next operation.

use std::cmp::Reverse;
use std::collections::BinaryHeap;

/// Ordered by the lowest bound, then the most places fixed, then the age.
type PlaceNode = Reverse<(u64, Reverse<usize>, usize, Vec<usize>)>;

/// The choices that have not come yet.
pub(super) struct PlaceTree<'a> {
    /// Number of places of each operation.
    counts: &'a [usize],
    open: BinaryHeap<PlaceNode>,
    /// Number of nodes created.
    nodes: usize,
    /// Number of bounds that may still be computed.
    bounds_left: usize,
}

impl PlaceTree<'_> {
    /// All choices, with a bound on all of them and the most bounds that may be computed.
    pub fn new(counts: &[usize], bound: u64, most_bounds: usize) -> PlaceTree<'_> {
        PlaceTree {
            counts,
            open: BinaryHeap::from([Reverse((bound, Reverse(0), 0, Vec::new()))]),
            nodes: 1,
            bounds_left: most_bounds,
        }
    }

    /// The next choice with its bound; `None` when all remaining bounds are at least `limit`, or no more bounds may be
    /// computed. `bound_of` computes the bound of places of the first operations.
    pub fn next(&mut self, limit: u64, mut bound_of: impl FnMut(&[usize]) -> u64) -> Option<(Vec<usize>, u64)> {
        while self.least()? < limit {
            let depth = self.open.peek().map_or(0, |Reverse((.., places))| places.len());
            let count = self.counts.get(depth).copied();
            if count.is_some_and(|count| count > self.bounds_left) {
                return None;
            }
            let Reverse((bound, _, _, places)) = self.open.pop()?;
            let Some(count) = count else { return Some((places, bound)) };
            self.bounds_left -= count;
            for place in 0..count {
                let mut places = places.clone();
                places.push(place);
                let own = bound_of(&places).max(bound);
                self.open.push(Reverse((own, Reverse(places.len()), self.nodes, places)));
                self.nodes += 1;
            }
        }
        None
    }

    /// The least bound of the remaining choices; `None` when there are none.
    pub fn least(&self) -> Option<u64> {
        self.open.peek().map(|Reverse((bound, ..))| *bound)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::SplitMix64;

    /// Sum of the costs of places. It grows with each operation, so that every prefix is a bound.
    fn cost(costs: &[Vec<u64>], places: &[usize]) -> u64 {
        places.iter().enumerate().map(|(nth, place)| costs[nth][*place]).sum()
    }

    #[test]
    fn all_choices_come_in_the_order_of_their_bounds() {
        let mut random = SplitMix64::new(7);
        for _ in 0..100 {
            let counts: Vec<usize> = (0..random.below(4) + 1).map(|_| random.below(4) + 1).collect();
            let costs: Vec<Vec<u64>> =
                counts.iter().map(|count| (0..*count).map(|_| random.below(5) as u64).collect()).collect();
            let mut all: Vec<u64> = vec![0];
            for own in &costs {
                all = all.iter().flat_map(|sum| own.iter().map(move |cost| sum + cost)).collect();
            }
            all.sort_unstable();
            let mut tree = PlaceTree::new(&counts, 0, usize::MAX);
            let mut came = Vec::new();
            while let Some((places, bound)) = tree.next(u64::MAX, |places| cost(&costs, places)) {
                assert_eq!(bound, cost(&costs, &places));
                came.push(bound);
            }
            assert_eq!(came, all);
            assert_eq!(tree.least(), None);
        }
    }

    #[test]
    fn what_is_left_out_is_bounded() {
        let (counts, costs) = ([3, 3], [vec![4, 1, 2], vec![0, 7, 3]]);
        let bound_of = |places: &[usize]| cost(&costs, places);
        let mut tree = PlaceTree::new(&counts, 0, usize::MAX);
        assert_eq!(tree.next(2, bound_of), Some((vec![1, 0], 1)));
        assert_eq!(tree.next(2, bound_of), None);
        assert_eq!(tree.least(), Some(2));
        let mut short = PlaceTree::new(&counts, 0, 5);
        assert_eq!(short.next(u64::MAX, bound_of), None);
        assert_eq!(short.least(), Some(1));
    }
}
