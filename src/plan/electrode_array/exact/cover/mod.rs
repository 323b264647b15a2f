//! Lower bound on the increase of the sum of costs, given the least joint increase of each pair (a weighted vertex
//! cover; Li, Felner, Boyarski, Ma, Koenig, "Improved heuristics for multi-agent path finding with conflict-based
//! search", IJCAI 2019).

/// Two agents whose joint costs rise by at least `weight`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Edge {
    pub ends: [usize; 2],
    pub weight: u32,
}

/// Most edges for which the cover is exact; with more, the bound comes from a greedy matching.
const MOST_EDGES: usize = 12;

/// A lower bound on the sum of the rises: exact for few edges.
pub fn least_rise(edges: &[Edge]) -> u32 {
    let mut edges: Vec<Edge> = edges.iter().copied().filter(|edge| edge.weight > 0).collect();
    edges.sort_by_key(|edge| std::cmp::Reverse((edge.weight, edge.ends)));
    if edges.len() > MOST_EDGES {
        return matched(&edges);
    }
    let agents = edges.iter().flat_map(|edge| edge.ends).max().map_or(0, |most| most + 1);
    let mut best = edges.iter().map(|edge| edge.weight).sum();
    cover(&edges, &mut vec![0; agents], 0, &mut best);
    best
}

/// Sum of the weights of edges without a common end.
fn matched(edges: &[Edge]) -> u32 {
    let mut taken: Vec<usize> = vec![];
    let mut sum = 0;
    for edge in edges {
        if !edge.ends.iter().any(|end| taken.contains(end)) {
            taken.extend(edge.ends);
            sum += edge.weight;
        }
    }
    sum
}

/// Tries every split of the first uncovered edge's deficit; recursion is at most [`MOST_EDGES`] deep.
fn cover(edges: &[Edge], rises: &mut Vec<u32>, sum: u32, best: &mut u32) {
    if sum >= *best {
        return;
    }
    let lacking = edges.iter().enumerate().find_map(|(index, Edge { ends: [one, other], weight })| {
        weight.checked_sub(rises[*one] + rises[*other]).filter(|lack| *lack > 0).map(|lack| (index, *one, *other, lack))
    });
    let Some((index, one, other, lack)) = lacking else {
        *best = sum;
        return;
    };
    for share in 0..=lack {
        rises[one] += share;
        rises[other] += lack - share;
        cover(&edges[index + 1..], rises, sum + lack, best);
        rises[one] -= share;
        rises[other] -= lack - share;
    }
}

#[cfg(test)]
mod tests;
