//! A first plan, one agent after the other among those before it.
//!
//! Method: prioritised planning (Erdmann and Lozano-Pérez, 1987) with the search of [`super::sipp`]. The starts of agents that have no
//! path yet cost a little to pass, so that ways out stay open. When an agent finds no path it comes first in the next order.
//! Guaranteed: a plan that is returned is legal. Not guaranteed: that there is one; some solvable instances have no order that works.
//! Cost: at most [`ORDERS`] orders of one search for each agent.

use super::super::board::{CellIndex, Paths};
use super::crew::{PlannedInstance, Wish};
use super::reservations::{Others, Reservations};
use crate::plan::search::Meter;

/// How many orders are tried.
const ORDERS: usize = 8;

/// A search may take so many steps
const SEARCH_STEPS: u64 = 4_000;

/// and so many more for each move that its agent has to make; then another order is the cheaper try.
const SEARCH_STEPS_PER_MOVE: u64 = 100;

/// How long a start without a path is a hazard, in separations.
const HAZARD_SEPARATIONS: u32 = 6;

/// How many instants of detour one hazard is worth.
const HAZARD_WEIGHT: u32 = 1;

/// How much the searches hurry, see [`super::sipp::Query::haste`]: ways a little longer, a sixth of the nodes on large boards.
const HASTE: u32 = 2;

/// What an order came to.
pub(super) enum PrioritisedOutcome {
    /// A legal plan.
    Plan(Paths),
    /// Of the order that left the fewest agents without a path: the paths found.
    Part(Vec<Option<Vec<CellIndex>>>),
}

/// Tries orders: the shortest way first, then those that found no path earlier each time.
pub(super) fn prioritise(crew: &mut PlannedInstance, meter: &mut Meter) -> PrioritisedOutcome {
    let mut order: Vec<usize> = (0..crew.count()).collect();
    order.sort_by_key(|agent| crew.least[*agent]);
    let (mut best, mut fewest) = (vec![None; crew.count()], crew.count() + 1);
    for _ in 0..ORDERS {
        let (paths, failed) = attempt(crew, &order, fewest, meter);
        if failed.is_empty() {
            return PrioritisedOutcome::Plan(paths.into_iter().flatten().collect());
        }
        if failed.len() < fewest {
            (best, fewest) = (paths, failed.len());
        }
        if meter.left().steps == 0 {
            break;
        }
        order.retain(|agent| !failed.contains(agent));
        order.splice(0..0, failed);
    }
    PrioritisedOutcome::Part(best)
}

/// Plans in an order until as many found no path as `most`; the paths, and who found none.
fn attempt(
    crew: &mut PlannedInstance,
    order: &[usize],
    most: usize,
    meter: &mut Meter,
) -> (Vec<Option<Vec<CellIndex>>>, Vec<usize>) {
    crew.table = Reservations::new(crew.instance);
    let until = HAZARD_SEPARATIONS * crew.instance.separation;
    for agent in order {
        crew.table.add_hazard(*agent, crew.instance.agents[*agent].start, until);
    }
    let (mut paths, mut failed) = (vec![None; crew.count()], Vec::new());
    let wish =
        Wish { others: Others::Hard, weight: HAZARD_WEIGHT, haste: HASTE, limit: u32::MAX, delay: 0, detour: None };
    for agent in order {
        crew.table.remove_hazard(*agent, crew.instance.agents[*agent].start);
        let allowed = SEARCH_STEPS + SEARCH_STEPS_PER_MOVE * u64::from(crew.least[*agent]);
        let path = meter.share(allowed, |meter| crew.plan(*agent, wish, meter));
        match &path {
            Some(path) => crew.table.add(*agent, path),
            None => failed.push(*agent),
        }
        paths[*agent] = path;
        if failed.len() >= most {
            break;
        }
    }
    (paths, failed)
}
