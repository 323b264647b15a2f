//! Steps with interchangeable goals, in terms of the task.

use crate::claims::electrode_array::{ElectrodeArrayMove, ElectrodeArrayOrder};
use crate::device::electrode_array::ElectrodeCell;
use crate::diagnostic::Diagnostic;
use crate::plan::electrode_array::board::{BoardCosts, BoardObjective, BoardPlan, NoBoardPlan};
use crate::plan::electrode_array::stage::{self, BoardStage};
use crate::plan::electrode_array::teams::{self, NoTeamPlan};
use crate::plan::errors;
use crate::plan::search::{SearchAnswer, SearchBudget};
use crate::source::Span;
use std::collections::BTreeMap;

/// Result for a step with teams.
pub enum SharedGoals {
    Found(BoardPlan),
    /// With lower bounds.
    GaveUp(BoardCosts),
    /// There is no plan, since a part that belongs to no team cannot reach a stop.
    Alone(NoBoardPlan),
    /// There is no plan, with the diagnostic that says why.
    Refused(Diagnostic),
}

/// Plans a step in which some moves belong to teams.
pub fn solve(
    order: &ElectrodeArrayOrder,
    step: Span,
    stage: &BoardStage,
    objective: BoardObjective,
    budget: SearchBudget,
) -> SharedGoals {
    let mut agents: BTreeMap<usize, Vec<usize>> = BTreeMap::new();
    for (agent, actor) in stage.agents.iter().enumerate() {
        if let Some(team) = actor.asked.and_then(|one| one.team) {
            agents.entry(team).or_default().push(agent);
        }
    }
    let teams: Vec<Vec<usize>> = agents.into_values().collect();
    match teams::solve(&stage.instance, &teams, objective, budget) {
        SearchAnswer::Found(plan) => SharedGoals::Found(plan),
        SearchAnswer::GaveUp(bounds) => SharedGoals::GaveUp(bounds),
        SearchAnswer::Impossible(NoTeamPlan::Alone(why)) => SharedGoals::Alone(why),
        SearchAnswer::Impossible(NoTeamPlan::Blocked) => {
            let all = stage.agents.iter().map(|actor| order.parts[actor.part].name.as_str());
            let blocked = errors::blocked_with_any_goals(step, &all.collect::<Vec<_>>());
            SharedGoals::Refused(errors::where_others_stay(blocked, stage.standing_names()))
        }
        SearchAnswer::Impossible(NoTeamPlan::Cut { team, goal, goals, agents }) => {
            let first = &stage.agents[teams[team][0]];
            let span = first.asked.map_or(step, |one| one.span);
            let part = &order.parts[first.part];
            let (name, goal) = (part.family().unwrap_or(&part.name), stage::cell(order, goal).to_string());
            let cut = errors::goals_out_of_reach(span, name, [goals, agents], &goal);
            SharedGoals::Refused(errors::where_others_stay(cut, stage.standing_names()))
        }
    }
}

/// Updates the cells of the parts of teams after a step, to the ends of their paths.
pub fn arrive(cells: &mut [Option<ElectrodeCell>], moves: &[ElectrodeArrayMove], motion: &[Vec<ElectrodeCell>]) {
    for one in moves.iter().filter(|one| one.team.is_some()) {
        cells[one.part] = motion[one.part].last().copied();
    }
}
