//! Fixed goals for interchangeable parts, used where the plan's own assignment leaves a later step without a plan.

use crate::claims::electrode_array::{ElectrodeArrayAction, ElectrodeArrayMove, ElectrodeArrayOrder};
use std::collections::BTreeMap;

/// Most assignments tried, for all steps together.
const MOST_ASSIGNMENTS: usize = 64;

/// 1/N of the budget of a step for each of them.
const SHARE: u64 = 16;

/// Orders in which each part of a team has a goal of its own: one for each assignment, but no more than the first
/// `MOST_ASSIGNMENTS`; none if no team has several parts.
pub fn orders(order: &ElectrodeArrayOrder) -> Vec<ElectrodeArrayOrder> {
    let sizes = order.steps.iter().flat_map(|step| teams(&step.action).into_values().map(|team| team.len()));
    let all = sizes.flat_map(|size| 1..=size).fold(1usize, usize::saturating_mul);
    let tried = if all > 1 { all.min(MOST_ASSIGNMENTS) } else { 0 };
    (0..tried).map(|nth| assigned(order, nth)).collect()
}

/// By team: the indices of its moves in a step.
fn teams(action: &ElectrodeArrayAction) -> BTreeMap<usize, Vec<usize>> {
    let mut teams: BTreeMap<usize, Vec<usize>> = BTreeMap::new();
    if let ElectrodeArrayAction::Move(moves) = action {
        let of_teams = moves.iter().enumerate().filter_map(|(place, one)| Some((one.team?, place)));
        of_teams.for_each(|(team, place)| teams.entry(team).or_default().push(place));
    }
    teams
}

/// The assignment with number `nth`. The number has one digit per part of a team, in a mixed radix: the number of goals
/// left for it.
fn assigned(order: &ElectrodeArrayOrder, mut nth: usize) -> ElectrodeArrayOrder {
    let mut order = order.clone();
    order.planner.expansions = (order.planner.expansions / SHARE).max(1);
    for step in &mut order.steps {
        let teams = teams(&step.action);
        let ElectrodeArrayAction::Move(moves) = &mut step.action else { continue };
        for places in teams.values() {
            let mut goals: Vec<_> = places.iter().map(|place| moves[*place].stops.clone()).collect();
            for place in places {
                let left = goals.len();
                let goal = goals.remove(nth % left);
                nth /= left;
                moves[*place] = ElectrodeArrayMove { stops: goal, team: None, ..moves[*place].clone() };
            }
        }
    }
    order
}
