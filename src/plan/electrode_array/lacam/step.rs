//! Rule-based successor of a configuration: urgent agents approach their goals, agents in their way are pushed aside.
//!
//! Method: in the manner of PIBT (Okumura, Machida, Défago, Tamura, "Priority inheritance with backtracking for iterative
//! multi-agent path finding", Artificial Intelligence 310, 2022), under the separation rule. No agent comes near a cell that
//! another leaves in the same step, so an agent whose path is blocked waits, which the rule always allows, and the agents that
//! block it choose before all others: the first move of a shortest path, past nothing but blocked cells and the pushing agent, to a
//! cell outside its path.

use super::super::board::CellIndex;
use super::super::exact::field::{ExactTables, StagedCell};
use super::NONE;
use crate::random::SplitMix64;
use rustc_hash::FxHashSet;
use std::collections::VecDeque;
use std::rc::Rc;

/// Most agents on one cell: two that merge.
const MOST_ON_CELL: usize = 2;

/// Agents by cell.
type Places = Vec<[u32; MOST_ON_CELL]>;

/// Length of the path that an agent wants free, in separations.
const WAY_SEPARATIONS: u32 = 3;

/// Budget of the search for a cell out of the way: cells examined times cells of the path.
const LOOKS: usize = 20_000;

/// One in this many pushed agents takes a longer way out where the shortest is blocked.
const RETREAT: usize = 16;

/// A request of one agent that others move away.
struct Push {
    /// Its cell.
    at: CellIndex,
    /// The cells of its intended path, and those wanted by the agent that pushes it.
    way: Vec<CellIndex>,
}

/// Generates configurations; its tables are empty between calls.
pub(super) struct ConfigurationGenerator<'a> {
    field: &'a ExactTables<'a>,
    here: Places,
    next: Places,
    /// Decided move of each agent.
    to: Vec<Option<StagedCell>>,
    /// Agents that choose next, with the push to which they react.
    queue: VecDeque<(usize, Option<Rc<Push>>)>,
    seen: FxHashSet<CellIndex>,
}

impl<'a> ConfigurationGenerator<'a> {
    pub(super) fn new(field: &'a ExactTables<'a>) -> ConfigurationGenerator<'a> {
        let empty = vec![[NONE; MOST_ON_CELL]; field.instance.board.cells()];
        ConfigurationGenerator {
            field,
            here: empty.clone(),
            next: empty,
            to: vec![None; field.agents()],
            queue: VecDeque::new(),
            seen: FxHashSet::default(),
        }
    }

    /// A successor in which constrained agents make their moves; `None` if those are impossible.
    pub(super) fn make(
        &mut self,
        from: &[StagedCell],
        order: &[usize],
        fixed: &[(usize, StagedCell)],
        random: &mut SplitMix64,
    ) -> Option<Vec<StagedCell>> {
        for (agent, node) in from.iter().enumerate() {
            put(&mut self.here, self.field.cell(*node), agent);
        }
        let fits = fixed.iter().all(|(agent, node)| {
            let clear = self.is_clear(&self.here, *agent, *node) && self.is_clear(&self.next, *agent, *node);
            self.go(*agent, *node);
            clear
        });
        if fits {
            for agent in order {
                self.queue.push_back((*agent, None));
                while let Some((agent, push)) = self.queue.pop_front() {
                    if self.to[agent].is_none() {
                        self.decide(from, agent, push.as_deref(), random);
                    }
                }
            }
        }
        let made: Option<Vec<StagedCell>> = if fits { self.to.iter().copied().collect() } else { None };
        self.clear(from);
        made
    }

    fn clear(&mut self, from: &[StagedCell]) {
        for node in from {
            self.here[self.field.cell(*node) as usize] = [NONE; MOST_ON_CELL];
        }
        for to in &mut self.to {
            if let Some(node) = to.take() {
                self.next[self.field.cell(node) as usize] = [NONE; MOST_ON_CELL];
            }
        }
    }

    fn go(&mut self, agent: usize, node: StagedCell) {
        put(&mut self.next, self.field.cell(node), agent);
        self.to[agent] = Some(node);
    }

    /// The best free move; otherwise the agent waits and pushes the agents that block the best move.
    fn decide(&mut self, from: &[StagedCell], agent: usize, push: Option<&Push>, random: &mut SplitMix64) {
        let here = from[agent];
        let candidates = match push {
            None => self.nearer(agent, here, random),
            Some(push) => self.aside(agent, here, push, random),
        };
        let mut wanted = None;
        for node in candidates {
            if !self.is_clear(&self.next, agent, node) {
                continue;
            }
            if self.is_clear(&self.here, agent, node) {
                return self.go(agent, node);
            }
            wanted = wanted.or(Some(node));
            // A move back into the path is no way out; but now and then it frees a jam in which nobody can move.
            if push.is_some() && random.below(RETREAT) > 0 {
                break;
            }
        }
        self.go(agent, here);
        let Some(node) = wanted else { return };
        let to = self.field.cell(node);
        let mut way = match push {
            None => self.way(agent, node),
            Some(_) => vec![to],
        };
        way.extend(push.iter().flat_map(|push| push.way.iter().copied()));
        let push = Rc::new(Push { at: self.field.cell(here), way });
        let blocking: Vec<usize> = self.near(&self.here, agent, to).collect();
        self.queue.extend(blocking.into_iter().map(|other| (other, Some(push.clone()))));
    }

    /// The cells of an agent's next steps on a shortest path.
    fn way(&self, agent: usize, mut node: StagedCell) -> Vec<CellIndex> {
        let mut way = vec![self.field.cell(node)];
        while way.len() < (WAY_SEPARATIONS * self.field.instance.separation) as usize {
            let distance = self.field.distance(agent, node);
            let Some(next) = self.field.next(agent, node).find(|next| self.field.distance(agent, *next) < distance)
            else {
                break;
            };
            way.push(self.field.cell(next));
            node = next;
        }
        way
    }

    /// The moves that reduce the distance to the goal.
    fn nearer(&self, agent: usize, here: StagedCell, random: &mut SplitMix64) -> Vec<StagedCell> {
        let distance = self.field.distance(agent, here);
        let nearer = |node: &StagedCell| self.field.distance(agent, *node) < distance;
        let mut moves: Vec<StagedCell> = self.field.next(agent, here).filter(nearer).collect();
        random.shuffle(&mut moves);
        moves
    }

    /// The moves out of the pushing agent's path, the shortest way out first.
    fn aside(&mut self, agent: usize, here: StagedCell, push: &Push, random: &mut SplitMix64) -> Vec<StagedCell> {
        let (field, instance) = (self.field, self.field.instance);
        let is_out = |cell: CellIndex| push.way.iter().all(|at| instance.board.apart(cell, *at) >= instance.separation);
        let mut moves: Vec<StagedCell> = field.next(agent, here).skip(1).collect();
        random.shuffle(&mut moves);
        let mut lengths = vec![NONE; moves.len()];
        self.seen.clear();
        self.seen.insert(field.cell(here));
        let firsts = moves.iter().enumerate().map(|(first, node)| (field.cell(*node), first, 1));
        let mut open: VecDeque<(CellIndex, usize, u32)> = firsts.collect();
        let mut looks = 0;
        while let Some((cell, first, length)) = open.pop_front() {
            let taken = instance.board.apart(cell, push.at) < instance.separation;
            if taken || !self.seen.insert(cell) {
                continue;
            }
            looks += push.way.len();
            if is_out(cell) {
                lengths[first] = lengths[first].min(length);
                continue;
            }
            if looks > LOOKS || lengths.iter().all(|known| *known < length) {
                break;
            }
            open.extend(instance.board.neighbours(cell).map(|beside| (beside, first, length + 1)));
        }
        let mut order: Vec<usize> = (0..moves.len()).filter(|first| lengths[*first] != NONE).collect();
        order.sort_by_key(|first| (lengths[*first], field.distance(agent, moves[*first])));
        order.into_iter().map(|first| moves[first]).collect()
    }

    fn is_clear(&self, places: &Places, agent: usize, node: StagedCell) -> bool {
        self.near(places, agent, self.field.cell(node)).next().is_none()
    }

    /// The other agents that are too near to a cell.
    fn near<'s>(&'s self, places: &'s Places, agent: usize, cell: CellIndex) -> impl Iterator<Item = usize> + 's {
        let around = self.field.instance.board.around(cell, self.field.instance.separation);
        let others = around.flat_map(|at| places[at as usize].iter().map(move |other| (at, *other as usize)));
        others
            .filter(move |(at, other)| {
                *other != NONE as usize && *other != agent && self.field.too_near(agent, cell, *other, *at)
            })
            .map(|(_, other)| other)
    }
}

fn put(places: &mut Places, cell: CellIndex, agent: usize) {
    let slots = &mut places[cell as usize];
    let free = slots.iter().position(|slot| *slot == NONE).unwrap_or(MOST_ON_CELL - 1);
    slots[free] = agent as u32;
}
