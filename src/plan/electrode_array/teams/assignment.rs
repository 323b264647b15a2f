//! Assignment of goals to agents by costs alone: one with the least greatest cost, and one with the least sum.
//!
//! Problem: as many agents as goals, and the cost of each pair, or `None` where an agent cannot reach a goal. Method:
//! for the greatest cost, augmenting paths (H. W. Kuhn, "The Hungarian method for the assignment problem", Naval
//! Research Logistics Quarterly 2, 1955) within limits found by bisection; for the sum, the Hungarian method with
//! potentials (J. Munkres, "Algorithms for the assignment and transportation problems", Journal of the SIAM 5, 1957).
//!
//! Guaranteed: both are exact. Cost: the cube of the number of agents.

/// By agent and goal: the cost of the pair; `None` if the agent cannot reach the goal.
pub type PairCosts = Vec<Vec<Option<u32>>>;

/// Bottleneck assignment: the least greatest cost over all assignments; `None` if there is no complete one.
pub fn bottleneck(costs: &PairCosts) -> Option<u32> {
    let mut known: Vec<u32> = costs.iter().flatten().flatten().copied().collect();
    known.sort_unstable();
    known.dedup();
    let fits = |most: u32| matching(costs, most) == costs.len();
    let at = known.partition_point(|most| !fits(*most));
    match costs.is_empty() {
        true => Some(0),
        false => known.get(at).copied(),
    }
}

/// The size of a maximum matching of agents and goals among pairs that cost no more than a limit.
fn matching(costs: &PairCosts, most: u32) -> usize {
    let mut of_goal: Vec<Option<usize>> = vec![None; costs.len()];
    (0..costs.len()).filter(|agent| augment(costs, most, *agent, &mut of_goal)).count()
}

/// Gives an agent a goal along an augmenting path, on which other agents change their goals; returns whether there is
/// one.
fn augment(costs: &PairCosts, most: u32, agent: usize, of_goal: &mut [Option<usize>]) -> bool {
    let mut from: Vec<Option<usize>> = vec![None; costs.len()];
    let mut ring = vec![agent];
    while let Some(own) = ring.pop() {
        for goal in 0..costs.len() {
            if from[goal].is_some() || costs[own][goal].is_none_or(|cost| cost > most) {
                continue;
            }
            from[goal] = Some(own);
            if let Some(holder) = of_goal[goal] {
                ring.push(holder);
                continue;
            }
            let mut at = Some(goal);
            while let Some(goal) = at {
                let taker = from[goal];
                at = taker.and_then(|taker| of_goal.iter().position(|holder| *holder == Some(taker)));
                of_goal[goal] = taker;
                if let Some(left) = at {
                    of_goal[left] = None;
                }
                if taker == Some(agent) {
                    return true;
                }
            }
        }
    }
    false
}

/// Weight of a forbidden pair: more than any sum of costs.
const NEVER: i128 = i128::MAX / 4;

/// By agent, its goal in an assignment of least sum, without costs above `most`; among these, one with the least sum of
/// squares, in which agents seldom cross. `None` if there is no complete one.
pub fn least_sum(costs: &PairCosts, most: u32) -> Option<Vec<usize>> {
    let count = costs.len();
    // One unit of cost outweighs all squares together.
    let unit = (i128::from(most) * i128::from(most)) * count as i128 + 1;
    let weight = |agent: usize, goal: usize| match costs[agent][goal].filter(|cost| *cost <= most) {
        Some(cost) => i128::from(cost) * unit + i128::from(cost) * i128::from(cost),
        None => NEVER / (count as i128 + 1),
    };
    // Agents and goals from 1; row and column 0 begin each path.
    let (mut by_agent, mut by_goal) = (vec![0i128; count + 1], vec![0i128; count + 1]);
    let mut of_goal = vec![0usize; count + 1];
    for agent in 1..=count {
        of_goal[0] = agent;
        let mut goal = 0;
        let (mut slack, mut before) = (vec![NEVER; count + 1], vec![0usize; count + 1]);
        let mut is_done = vec![false; count + 1];
        while of_goal[goal] != 0 {
            is_done[goal] = true;
            let (own, mut least, mut next) = (of_goal[goal], NEVER, 0);
            for other in (1..=count).filter(|other| !is_done[*other]) {
                let reduced = weight(own - 1, other - 1) - by_agent[own] - by_goal[other];
                if reduced < slack[other] {
                    (slack[other], before[other]) = (reduced, goal);
                }
                if slack[other] < least {
                    (least, next) = (slack[other], other);
                }
            }
            for other in 0..=count {
                if is_done[other] {
                    by_agent[of_goal[other]] += least;
                    by_goal[other] -= least;
                } else {
                    slack[other] -= least;
                }
            }
            goal = next;
        }
        while goal != 0 {
            of_goal[goal] = of_goal[before[goal]];
            goal = before[goal];
        }
    }
    let mut goals = vec![0; count];
    for (goal, agent) in of_goal.iter().enumerate().skip(1) {
        goals[agent - 1] = goal - 1;
    }
    let is_allowed = |(agent, goal): (usize, &usize)| costs[agent][*goal].is_some_and(|cost| cost <= most);
    goals.iter().enumerate().all(is_allowed).then_some(goals)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// All permutations of the numbers below `count`.
    fn orders(count: usize) -> Vec<Vec<usize>> {
        let mut all: Vec<Vec<usize>> = vec![vec![]];
        for next in 0..count {
            let longer = |order: &Vec<usize>| {
                let order = order.clone();
                (0..=order.len()).map(move |at| [&order[..at], &[next], &order[at..]].concat())
            };
            all = all.iter().flat_map(longer).collect();
        }
        all
    }

    #[test]
    fn both_agree_with_all_assignments() {
        let mut chance = crate::random::SplitMix64::new(5);
        for round in 0..600 {
            let count = round % 6;
            let mut cost = || Some(chance.below(12) as u32).filter(|cost| *cost < 10);
            let costs: PairCosts = (0..count).map(|_| (0..count).map(|_| cost()).collect()).collect();
            let all = orders(count);
            let taken = |order: &Vec<usize>| -> Option<Vec<u32>> {
                order.iter().enumerate().map(|(agent, goal)| costs[agent][*goal]).collect()
            };
            let known: Vec<Vec<u32>> = all.iter().filter_map(taken).collect();
            let greatest = known.iter().map(|own| own.iter().copied().max().unwrap_or(0)).min();
            assert_eq!(bottleneck(&costs), greatest, "{costs:?}");
            for most in [greatest.unwrap_or(0), 9] {
                let kept = known.iter().filter(|own| own.iter().all(|cost| *cost <= most));
                let key = |own: &Vec<u32>| (own.iter().sum::<u32>(), own.iter().map(|cost| cost * cost).sum::<u32>());
                let found = least_sum(&costs, most).map(|order| key(&taken(&order).expect("all pairs are possible")));
                assert_eq!(found, kept.map(key).min(), "{costs:?}");
            }
        }
    }
}
