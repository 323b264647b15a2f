//! Prioritised planning under shared channels: a first plan, one agent after the other.
//!
//! Method: breadth-first search over the cells of one agent, instant by instant, around the paths of the agents before
//! it (prioritised planning: M. Erdmann, T. Lozano-Pérez, "On multiple moving objects", Algorithmica 2, 1987), in
//! several orders. Guaranteed: paths are legal; the same input gives the same paths. Not guaranteed: that a plan is
//! found, or a short one. Cost: one step of the meter for each tried move, and one more for each agent before.

use super::are_kept_by_paths;
use super::broadcast::{AgentStep, SharedChannels};
use crate::plan::electrode_array::board::{BoardCosts, BoardObjective, CellIndex, Paths, position};
use crate::plan::electrode_array::exact::tables::{ExactTables, StagedCell};
use crate::plan::search::Meter;
use crate::random::SplitMix64;
use rustc_hash::FxHashSet;

/// Number of orders tried.
const ORDERS: usize = 24;

/// The best plan over several orders; `None` if no order yields one within the limit on the steps.
pub fn first(
    tables: &ExactTables,
    channels: &SharedChannels,
    objective: BoardObjective,
    limit: Option<u64>,
    meter: &mut Meter,
) -> Option<Paths> {
    let mut random = SplitMix64::new(1);
    let mut order: Vec<usize> = (0..tables.agents()).collect();
    let mut best: Option<Paths> = None;
    for turn in 0..ORDERS {
        match turn {
            0 => {}
            1 => order.sort_by_key(|agent| std::cmp::Reverse(tables.least(*agent))),
            _ => random.shuffle(&mut order),
        }
        let Some(paths) = in_order(tables, channels, &order, meter) else {
            if meter.left().steps == 0 {
                break;
            }
            continue;
        };
        let costs = BoardCosts::of(&paths);
        let is_better = best.as_ref().is_none_or(|best| costs.key(objective) < BoardCosts::of(best).key(objective));
        let keeps = limit.is_none_or(|limit| costs.makespan <= limit);
        if is_better && keeps && are_kept_by_paths(tables.instance, &paths) {
            best = Some(paths);
        }
    }
    best
}

/// The plan of one order.
fn in_order(tables: &ExactTables, channels: &SharedChannels, order: &[usize], meter: &mut Meter) -> Option<Paths> {
    let mut turns = OrderedTurns { tables, channels, known: Vec::with_capacity(order.len()) };
    for agent in order {
        let path = turns.path(*agent, meter)?;
        turns.known.push((*agent, path));
    }
    let mut paths = vec![Vec::new(); order.len()];
    turns.known.into_iter().for_each(|(agent, path)| paths[agent] = path);
    Some(paths)
}

struct OrderedTurns<'a> {
    tables: &'a ExactTables<'a>,
    channels: &'a SharedChannels,
    /// The agents planned so far, with their paths.
    known: Vec<(usize, Vec<CellIndex>)>,
}

impl OrderedTurns<'_> {
    /// The earliest path of an agent around those planned so far.
    fn path(&self, agent: usize, meter: &mut Meter) -> Option<Vec<CellIndex>> {
        let end = self.known.iter().map(|(_, path)| path.len() - 1).max().unwrap_or(0);
        let may_outlast = self.may_outlast();
        // By instant, the nodes where it can be, each with the index of its predecessor.
        let mut layers: Vec<Vec<(StagedCell, usize)>> = vec![vec![(self.tables.start(agent), 0)]];
        let mut settled: FxHashSet<StagedCell> = FxHashSet::default();
        loop {
            let instant = layers.len() - 1;
            let here = &layers[instant];
            if let Some(at) = here.iter().position(|(node, _)| self.rests(agent, *node, instant..end)) {
                return Some(self.traced(&layers, at));
            }
            if instant >= end && !may_outlast {
                return None;
            }
            let mut met: FxHashSet<StagedCell> = FxHashSet::default();
            let mut next = Vec::new();
            for (before, (node, _)) in here.iter().enumerate() {
                for to in self.tables.next(agent, *node) {
                    meter.charge(self.known.len() as u64);
                    meter.step()?;
                    let cells = [*node, to].map(|node| self.tables.cell(node));
                    if !met.contains(&to) && !settled.contains(&to) && self.fits(agent, cells, instant) {
                        met.insert(to);
                        next.push((to, before));
                    }
                }
            }
            // From this instant on the other agents rest, so reaching a node once is enough.
            if instant >= end {
                settled.extend(met);
            }
            if next.is_empty() {
                return None;
            }
            layers.push(next);
        }
    }

    /// Whether the agents planned so far can stay at their goals while another one moves.
    fn may_outlast(&self) -> bool {
        let rest = |(_, path): &(usize, Vec<CellIndex>)| AgentStep::rest(path[path.len() - 1]);
        let rests: Vec<AgentStep> = self.known.iter().map(rest).collect();
        let goes = |nth: usize| {
            !self.channels.tears_apart(rests[nth])
                && rests[..nth].iter().all(|other| !self.channels.clash(rests[nth], *other))
        };
        (0..rests.len()).all(goes)
    }

    /// Whether an agent is at its goal and can stay there during some instants.
    fn rests(&self, agent: usize, node: StagedCell, mut instants: std::ops::Range<usize>) -> bool {
        let cell = self.tables.cell(node);
        node == self.tables.goal(agent)
            && instants.all(|instant| {
                !self.channels.tears_apart(AgentStep::rest(cell)) && self.fits(agent, [cell, cell], instant)
            })
    }

    /// Whether a step at an instant is compatible with those of the agents planned so far.
    fn fits(&self, agent: usize, [from, to]: [CellIndex; 2], instant: usize) -> bool {
        self.known.iter().all(|(other, path)| {
            let [theirs, next] = [instant, instant + 1].map(|instant| position(path, instant));
            let near = |own: CellIndex, their: CellIndex| self.tables.too_near(agent, own, *other, their);
            let is_near = near(to, next) || near(to, theirs) || near(from, next);
            !is_near && !self.channels.clash(AgentStep { from, to }, AgentStep { from: theirs, to: next })
        })
    }

    fn traced(&self, layers: &[Vec<(StagedCell, usize)>], mut at: usize) -> Vec<CellIndex> {
        let mut path = Vec::with_capacity(layers.len());
        for layer in layers.iter().rev() {
            let (node, before) = layer[at];
            path.push(self.tables.cell(node));
            at = before;
        }
        path.reverse();
        crate::plan::electrode_array::joint::trim(&mut path);
        path
    }
}
