//! State that all stages of the fast planner share: the instance, distances, reservations and the search of one agent.

use super::distances::Distances;
use super::reservations::{IntervalQuery, Others, Reservations};
use super::sipp::{Query, Sipp, StopRoute};
use super::weights::ConflictWeights;
use crate::plan::electrode_array::board::{CellIndex, Instance, NoBoardPlan, Paths};
use crate::plan::search::Meter;
use crate::random::SplitMix64;

/// One instance being planned.
pub(super) struct PlannedInstance<'a> {
    pub(super) instance: &'a Instance,
    pub(super) table: Reservations,
    pub(super) random: SplitMix64,
    /// Latest arrival of an agent.
    pub(super) step_limit: u32,
    /// By agent: its steps when alone.
    pub(super) least: Vec<u32>,
    distances: Distances,
    sipp: Sipp,
    partners: Vec<Vec<u32>>,
    /// Costs of soft conflicts.
    pub(super) weights: ConflictWeights,
}

/// Settings for planning one agent.
#[derive(Debug, Clone, Copy)]
pub(super) struct PathTerms {
    pub(super) others: Others,
    /// Value of one unit of conflict cost, in instants.
    pub(super) weight: u32,
    /// Extra weight of the heuristic, see [`Query::haste`].
    pub(super) haste: u32,
    /// Latest arrival.
    pub(super) limit: u32,
    /// The agent stays on its start until this instant.
    pub(super) delay: u32,
    /// A cell to visit before its stops.
    pub(super) detour: Option<CellIndex>,
}

impl<'a> PlannedInstance<'a> {
    /// The error is an agent that cannot reach one of its stops even alone.
    pub(super) fn new(
        instance: &'a Instance,
        seed: u64,
        meter: &mut Meter,
    ) -> Result<PlannedInstance<'a>, NoBoardPlan> {
        let mut partners = vec![Vec::new(); instance.agents.len()];
        for [one, other] in &instance.merges {
            partners[*one].push(*other as u32);
            partners[*other].push(*one as u32);
        }
        let mut distances = Distances::of(&instance.board);
        let least = individual(instance, &mut distances, meter)?;
        Ok(PlannedInstance {
            instance,
            table: Reservations::new(instance),
            random: SplitMix64::new(seed),
            step_limit: u32::MAX - 1,
            least,
            distances,
            sipp: Sipp::new(&instance.board),
            partners,
            weights: ConflictWeights::new(instance.agents.len()),
        })
    }

    /// Number of agents.
    pub(super) fn count(&self) -> usize {
        self.instance.agents.len()
    }

    /// Plans a path of one agent, whose own path must not be in the table.
    pub(super) fn plan(&mut self, agent: usize, terms: PathTerms, meter: &mut Meter) -> Option<Vec<CellIndex>> {
        let it = &self.instance.agents[agent];
        let stops = terms.detour.iter().chain(&it.stops);
        let route = route(self.instance, it.start, stops, &mut self.distances, meter).ok()?;
        let weights = self.weights.row(agent);
        let interval_query =
            IntervalQuery { goal: it.goal(), partners: &self.partners[agent], others: terms.others, weights };
        let query = Query {
            board: &self.instance.board,
            start: it.start,
            route: &route,
            interval_query,
            weight: terms.weight,
            haste: terms.haste,
            limit: terms.limit.min(self.step_limit),
            delay: terms.delay,
        };
        self.sipp.plan(&query, &mut self.table, &mut self.random, meter)
    }

    /// The agents in the table with which a path conflicts, sorted.
    pub(super) fn conflicts(&self, agent: usize, path: &[CellIndex]) -> Vec<usize> {
        let goal = self.instance.agents[agent].goal();
        let interval_query =
            IntervalQuery { goal, partners: &self.partners[agent], others: Others::Hard, weights: &[] };
        let mut found = Vec::new();
        self.table.conflicts(path, &interval_query, |other| {
            if other != agent {
                found.push(other);
            }
        });
        found.sort_unstable();
        found.dedup();
        found
    }

    /// A random shortest path of one agent, ignoring the others.
    pub(super) fn alone(&mut self, agent: usize, meter: &mut Meter) -> Vec<CellIndex> {
        let it = &self.instance.agents[agent];
        let mut path = vec![it.start];
        let Ok(route) = route(self.instance, it.start, &it.stops, &mut self.distances, meter) else { return path };
        let (mut cell, mut layer) = (it.start, route.passed(it.start, 0));
        let mut left = route.steps(cell, layer);
        while left > 0 {
            left -= 1;
            let dice = self.random.next_u64() as u32;
            let nearer = self.instance.board.neighbours(cell).filter(|next| route.steps(*next, layer) == left);
            let Some((_, next)) = nearer.enumerate().map(|(turn, next)| (dice >> (8 * turn) & 0xff, next)).max() else {
                break;
            };
            (cell, layer) = (next, route.passed(next, layer));
            path.push(cell);
        }
        path
    }

    /// Resets the table and enters these paths.
    pub(super) fn enter_all(&mut self, paths: &Paths) {
        self.table = Reservations::new(self.instance);
        for (agent, path) in paths.iter().enumerate() {
            self.table.add(agent, path);
        }
    }
}

/// By agent: its steps when alone.
pub(super) fn individual(
    instance: &Instance,
    distances: &mut Distances,
    meter: &mut Meter,
) -> Result<Vec<u32>, NoBoardPlan> {
    let one = |agent: usize| {
        let it = &instance.agents[agent];
        let closed = |stop| NoBoardPlan::Closed { agent, stop };
        let way = route(instance, it.start, &it.stops, distances, meter).map_err(closed)?;
        Ok(way.steps(it.start, 0))
    };
    (0..instance.agents.len()).map(one).collect()
}

/// The route through these stops; an error with the index of the first unreachable one.
fn route<'s>(
    instance: &Instance,
    start: CellIndex,
    stops: impl IntoIterator<Item = &'s CellIndex>,
    distances: &mut Distances,
    meter: &mut Meter,
) -> Result<StopRoute, usize> {
    let stops = stops.into_iter().map(|stop| (*stop, distances.to(&instance.board, *stop, meter))).collect();
    StopRoute::new(start, stops)
}
