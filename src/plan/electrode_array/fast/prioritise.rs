//! Prioritised planning: a first plan, one agent after the other.
//!
//! Method: prioritised planning (Erdmann and Lozano-Pérez, 1987) with the search of [`super::sipp`]. Passing the start
//! of an agent without a path yet costs a little, so that its exit stays open. Agents that find no path come first in
//! the next order. Guaranteed: a returned plan is legal. Not guaranteed: that one is found; some solvable instances
//! have no order that works. Cost: at most [`ORDERS`] orders of one search for each agent.

use super::planned_instance::{PathTerms, PlannedInstance};
use super::reservations::{Others, Reservations};
use crate::plan::electrode_array::board::{CellIndex, Paths};
use crate::plan::search::Meter;

/// Most orders tried; where these leave agents without a path, repair is faster than further orders.
const ORDERS: usize = 3;

/// If fewer than 1/N of the agents are without a path, no further order is tried.
const FEW: usize = 32;

/// Budget of one search, in steps.
const SEARCH_STEPS: u64 = 4_000;

/// Added to that budget for each move that the agent must make; beyond it, another order is the cheaper try.
const SEARCH_STEPS_PER_MOVE: u64 = 100;

/// Time for which a start without a path is a hazard, in instants per unit of separation.
const HAZARD_SEPARATIONS: u32 = 6;

/// Value of one hazard, in instants of detour.
const HAZARD_WEIGHT: u32 = 1;

/// Extra weight of the heuristic, see [`super::sipp::Query::haste`]: paths get slightly longer, for a sixth of the
/// nodes on large boards.
const HASTE: u32 = 2;

/// Result of prioritised planning.
pub(super) enum PrioritisedOutcome {
    /// A legal plan.
    Plan(Paths),
    /// The paths found in the order that left the fewest agents without one.
    Part(Vec<Option<Vec<CellIndex>>>),
}

/// Tries orders: at first the agents with the shortest paths come first; then each time the agents that found no path
/// move to the front.
pub(super) fn prioritise(planned: &mut PlannedInstance, meter: &mut Meter) -> PrioritisedOutcome {
    let mut order: Vec<usize> = (0..planned.count()).collect();
    order.sort_by_key(|agent| planned.least[*agent]);
    let (mut best, mut fewest) = (vec![None; planned.count()], planned.count() + 1);
    for _ in 0..ORDERS {
        let (paths, failed) = attempt(planned, &order, fewest, meter);
        if failed.is_empty() {
            return PrioritisedOutcome::Plan(paths.into_iter().flatten().collect());
        }
        if failed.len() < fewest {
            (best, fewest) = (paths, failed.len());
        }
        if meter.left().steps == 0 || fewest * FEW < planned.count() {
            break;
        }
        order.retain(|agent| !failed.contains(agent));
        order.splice(0..0, failed);
    }
    PrioritisedOutcome::Part(best)
}

/// Plans in an order until `most` agents have found no path; returns the paths, and the agents without one.
fn attempt(
    planned: &mut PlannedInstance,
    order: &[usize],
    most: usize,
    meter: &mut Meter,
) -> (Vec<Option<Vec<CellIndex>>>, Vec<usize>) {
    planned.table = Reservations::new(planned.instance);
    let until = HAZARD_SEPARATIONS * planned.instance.separation;
    for agent in order {
        planned.table.add_hazard(*agent, planned.instance.agents[*agent].start, until);
    }
    let (mut paths, mut failed) = (vec![None; planned.count()], Vec::new());
    let terms = PathTerms {
        others: Others::Hard,
        weight: HAZARD_WEIGHT,
        haste: HASTE,
        limit: u32::MAX,
        delay: 0,
        detour: None,
    };
    for agent in order {
        planned.table.remove_hazard(*agent, planned.instance.agents[*agent].start);
        let allowed = SEARCH_STEPS + SEARCH_STEPS_PER_MOVE * u64::from(planned.least[*agent]);
        let path = meter.share(allowed, |meter| planned.plan(*agent, terms, meter));
        match &path {
            Some(path) => planned.table.add(*agent, path),
            None => failed.push(*agent),
        }
        paths[*agent] = path;
        if failed.len() >= most {
            break;
        }
    }
    (paths, failed)
}
