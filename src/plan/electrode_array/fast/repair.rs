//! Repairs conflicting paths into a legal plan.
//!
//! Method: MAPF-LNS2 (Li and others, AAAI 2022): remove the paths of a few conflicting agents, replan them one after the other with
//! as few conflicts as possible, and keep the result if its conflicts weigh no more than before. Pairs that stay in conflict gain
//! weight ([`super::weights`]). Now and then an agent waits at its start or detours via a nearby cell: for two agents to swap in
//! a corridor, one of them must enter a bay. Guaranteed: a returned plan is legal. Not guaranteed: that one is found; the search
//! ends with its meter. Cost: one search for each agent of a neighbourhood of at most [`LARGEST`].

use super::planned_instance::{PathTerms, PlannedInstance};
use super::reservations::Others;
use super::weights::ConflictWeights;
use crate::plan::electrode_array::board::{CellIndex, Paths};
use crate::plan::search::Meter;

/// Most agents that are replanned at once.
const LARGEST: usize = 5;

/// Value of a conflict of weight 1, in instants of detour.
const WEIGHT: u32 = 30;

/// After this many rounds without fewer conflicts, the pairs in conflict gain weight.
const RAISING_ROUNDS: usize = 40;

/// Extra weight of the heuristic, see [`super::sipp::Query::haste`].
const HASTE: u32 = 2;

/// One replanned agent in N is delayed.
const DELAYED: usize = 8;

/// A delay is shorter than the agent's path plus this many instants.
const LONGEST_DELAY: usize = 8;

/// One of the other replanned agents in N detours via a cell.
const DETOURED: usize = 12;

/// The cell of a detour is at most this many separations away from the path, in columns and rows.
const DETOUR_SEPARATIONS: u32 = 3;

/// Paths, and their conflicts.
struct RepairState {
    paths: Paths,
    near: Vec<Vec<usize>>,
}

impl RepairState {
    fn pairs(&self) -> usize {
        self.near.iter().map(Vec::len).sum::<usize>() / 2
    }

    /// Total weight of the conflicts; each pair counts once for each of its agents.
    fn weight(&self, weights: &ConflictWeights) -> u64 {
        let of =
            |(agent, others): (usize, &Vec<usize>)| others.iter().map(|other| weights.of(agent, *other)).sum::<u64>();
        self.near.iter().enumerate().map(of).sum()
    }

    fn link(&mut self, agent: usize, others: Vec<usize>) {
        for other in &others {
            self.near[*other].push(agent);
        }
        self.near[agent] = others;
    }

    fn unlink(&mut self, agent: usize) {
        for other in std::mem::take(&mut self.near[agent]) {
            self.near[other].retain(|one| *one != agent);
        }
    }
}

/// Completes and repairs the paths of an attempt; `None` if more than `most_pairs` pairs conflict at the start, or the
/// meter runs out.
pub(super) fn repair(
    planned: &mut PlannedInstance,
    part: Vec<Option<Vec<CellIndex>>>,
    most_pairs: usize,
    meter: &mut Meter,
) -> Option<Paths> {
    planned.weights = ConflictWeights::new(planned.count());
    let mut state = begin(planned, part, meter)?;
    let (mut pairs, mut vain_rounds) = (state.pairs(), 0);
    if pairs > most_pairs {
        return None;
    }
    while pairs > 0 {
        meter.step()?;
        let chosen = neighbourhood(planned, &state);
        replan(planned, &mut state, chosen, meter)?;
        let before = std::mem::replace(&mut pairs, state.pairs());
        vain_rounds += usize::from(pairs >= before);
        if vain_rounds == RAISING_ROUNDS {
            vain_rounds = 0;
            raise(&mut planned.weights, &state);
        }
    }
    Some(state.paths)
}

/// Raises the weight of each pair in conflict.
fn raise(weights: &mut ConflictWeights, state: &RepairState) {
    for (agent, others) in state.near.iter().enumerate() {
        others.iter().for_each(|other| weights.raise(agent, *other));
    }
}

/// Enters the paths of an attempt and plans the missing ones, conflicts allowed.
fn begin(planned: &mut PlannedInstance, part: Vec<Option<Vec<CellIndex>>>, meter: &mut Meter) -> Option<RepairState> {
    let known = part.iter().flatten().cloned().collect::<Vec<_>>();
    let agents: Vec<usize> = (0..part.len()).filter(|agent| part[*agent].is_some()).collect();
    planned.table = super::reservations::Reservations::new(planned.instance);
    for (agent, path) in agents.iter().zip(&known) {
        planned.table.add(*agent, path);
    }
    let mut state = RepairState { paths: vec![Vec::new(); part.len()], near: vec![Vec::new(); part.len()] };
    for (agent, path) in part.into_iter().enumerate() {
        state.paths[agent] = match path {
            Some(path) => path,
            None => {
                let path = planned.plan(agent, SOFT, meter)?;
                let others = planned.conflicts(agent, &path);
                state.link(agent, others);
                planned.table.add(agent, &path);
                path
            }
        };
    }
    Some(state)
}

const SOFT: PathTerms =
    PathTerms { others: Others::Soft, weight: WEIGHT, haste: HASTE, limit: u32::MAX, delay: 0, detour: None };

/// Agents around a conflict: a random walk along conflicts, filled up with agents that pass nearby.
fn neighbourhood(planned: &mut PlannedInstance, state: &RepairState) -> Vec<usize> {
    let troubled: Vec<usize> = (0..planned.count()).filter(|agent| !state.near[*agent].is_empty()).collect();
    let size = (2 + planned.random.below(LARGEST - 1)).min(planned.count());
    let mut chosen = vec![troubled[planned.random.below(troubled.len())]];
    let mut at = chosen[0];
    for _ in 0..4 * size {
        if chosen.len() >= size {
            break;
        }
        let near = &state.near[at];
        let next = if !near.is_empty() && planned.random.below(3) > 0 {
            near[planned.random.below(near.len())]
        } else {
            passer(planned, &state.paths[at])
        };
        if !chosen.contains(&next) {
            chosen.push(next);
        }
        at = chosen[planned.random.below(chosen.len())];
    }
    chosen
}

/// An agent that passes near a random position of a path.
fn passer(planned: &mut PlannedInstance, path: &[CellIndex]) -> usize {
    let cell = path[planned.random.below(path.len())];
    let count = planned.table.visitors(cell).count();
    let pick = planned.random.below(count);
    planned.table.visitors(cell).nth(pick).expect("the path itself is in the table")
}

/// Replans the chosen agents; undone if the conflicts weigh more than before. `None` when the meter runs out.
fn replan(
    planned: &mut PlannedInstance,
    state: &mut RepairState,
    mut chosen: Vec<usize>,
    meter: &mut Meter,
) -> Option<()> {
    let before = state.weight(&planned.weights);
    let old: Vec<_> = chosen.iter().map(|agent| (*agent, state.paths[*agent].clone())).collect();
    for (agent, path) in &old {
        planned.table.remove(*agent, path);
        state.unlink(*agent);
    }
    planned.random.shuffle(&mut chosen);
    let mut placed = 0;
    for agent in &chosen {
        let terms = varied_terms(planned, &state.paths[*agent]);
        let Some(path) = planned.plan(*agent, terms, meter) else { break };
        let others = planned.conflicts(*agent, &path);
        state.link(*agent, others);
        planned.table.add(*agent, &path);
        state.paths[*agent] = path;
        placed += 1;
        if state.weight(&planned.weights) > before {
            break;
        }
    }
    if placed == chosen.len() && state.weight(&planned.weights) <= before {
        return Some(());
    }
    for agent in &chosen[..placed] {
        planned.table.remove(*agent, &state.paths[*agent]);
        state.unlink(*agent);
    }
    for (agent, path) in old {
        let others = planned.conflicts(agent, &path);
        state.link(agent, others);
        planned.table.add(agent, &path);
        state.paths[agent] = path;
    }
    (meter.left().steps > 0).then_some(())
}

/// Settings for replanning: mostly the shortest path; some agents wait or detour first, for agents that cannot pass
/// otherwise.
fn varied_terms(planned: &mut PlannedInstance, path: &[CellIndex]) -> PathTerms {
    if planned.random.below(DELAYED) == 0 {
        return PathTerms { delay: planned.random.below(path.len() + LONGEST_DELAY) as u32, ..SOFT };
    }
    if planned.random.below(DETOURED) == 0 {
        return PathTerms { detour: beside(planned, path), ..SOFT };
    }
    SOFT
}

/// A random cell near a random position of a path; `None` if it is blocked.
fn beside(planned: &mut PlannedInstance, path: &[CellIndex]) -> Option<CellIndex> {
    let board = &planned.instance.board;
    let (column, row) = board.place(path[planned.random.below(path.len())]);
    let reach = DETOUR_SEPARATIONS * planned.instance.separation;
    let mut near = |at: u32, side: u32| {
        let (low, high) = (at.saturating_sub(reach), at.saturating_add(reach).min(side - 1));
        low + planned.random.below((high - low) as usize + 1) as u32
    };
    let cell = board.cell(near(column, board.width()), near(row, board.height()));
    (!board.is_blocked(cell)).then_some(cell)
}
