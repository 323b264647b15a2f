//! Rule-based successor of a configuration: urgent agents approach their goals, and agents in their way are pushed
//! aside.
//!
//! Method: in the manner of PIBT (Okumura, Machida, Défago, Tamura, "Priority inheritance with backtracking for
//! iterative multi-agent path finding", Artificial Intelligence 310, 2022), under the separation rule. No agent comes
//! near a cell that another leaves in the same step. So an agent whose path is blocked waits, which the rule always
//! allows, and the agents that block it choose before all others: each makes the first move of a shortest path to a
//! cell outside the blocked agent's path, avoiding only blocked cells and the pushing agent.

use super::NONE;
use crate::plan::electrode_array::board::{CellIndex, Instance};
use crate::plan::electrode_array::exact::tables::{CellPlace, ExactTables, StagedCell};
use crate::random::SplitMix64;
use std::collections::VecDeque;
use std::rc::Rc;

/// Most agents in one block: two that merge.
const MOST_IN_BLOCK: usize = 2;

/// Spatial hash of the agents: blocks with as many columns and rows as the separation. No two agents that keep the
/// separation share a block, so all agents near a cell are found in nine blocks.
struct Places {
    separation: i32,
    /// Blocks in a row, with one more at either side.
    across: i32,
    blocks: Vec<[(u32, CellIndex); MOST_IN_BLOCK]>,
}

impl Places {
    fn new(instance: &Instance) -> Places {
        let across = |cells: u32| cells.div_ceil(instance.separation) + 2;
        let (width, height) = (across(instance.board.width()), across(instance.board.height()));
        let blocks = vec![[(NONE, 0); MOST_IN_BLOCK]; (width * height) as usize];
        Places { separation: instance.separation as i32, across: width as i32, blocks }
    }

    fn block(&self, place: CellPlace) -> usize {
        ((place.row / self.separation + 1) * self.across + place.column / self.separation + 1) as usize
    }

    fn put(&mut self, agent: usize, cell: CellIndex, place: CellPlace) {
        let block = self.block(place);
        let slots = &mut self.blocks[block];
        let free = slots.iter().position(|(slot, _)| *slot == NONE).unwrap_or(MOST_IN_BLOCK - 1);
        slots[free] = (agent as u32, cell);
    }

    fn clear(&mut self, place: CellPlace) {
        let block = self.block(place);
        self.blocks[block] = [(NONE, 0); MOST_IN_BLOCK];
    }

    /// The agents, with their cells, in the blocks around a place.
    fn around(&self, place: CellPlace) -> impl Iterator<Item = (usize, CellIndex)> + '_ {
        let reach = if self.separation == 1 { 0 } else { 1 };
        let middle = self.block(place) as i32;
        let rows = -reach..=reach;
        let blocks = rows.flat_map(move |row| (-reach..=reach).map(move |column| middle + row * self.across + column));
        let agents = blocks.flat_map(|block| self.blocks[block as usize]);
        agents.filter(|(agent, _)| *agent != NONE).map(|(agent, cell)| (agent as usize, cell))
    }
}

/// Length of the path that an agent wants free, in separations.
const WAY_SEPARATIONS: u32 = 3;

/// Budget of the search for a cell out of the way: cells examined times cells of the path to avoid.
const MAX_CELL_CHECKS: usize = 20_000;

/// One pushed agent in N takes a longer way out where the shortest is blocked.
const RETREAT: usize = 16;

/// A request of one agent that others move away.
struct Push {
    /// Its cell, where it waits.
    at: CellIndex,
    /// The cells of its intended path, and those wanted by the agent that pushes it.
    way: Vec<CellIndex>,
}

/// Generates configurations; its tables are empty between calls.
pub(super) struct ConfigurationGenerator<'a> {
    tables: &'a ExactTables<'a>,
    here: Places,
    next: Places,
    /// Decided move of each agent.
    to: Vec<Option<StagedCell>>,
    /// Agents that choose next, each with the push to which it reacts.
    queue: VecDeque<(usize, Option<Rc<Push>>)>,
    /// By cell: number of the last search for a way out that reached it.
    seen: Vec<u32>,
    searches: u32,
}

impl<'a> ConfigurationGenerator<'a> {
    pub(super) fn new(tables: &'a ExactTables<'a>) -> ConfigurationGenerator<'a> {
        ConfigurationGenerator {
            tables,
            here: Places::new(tables.instance),
            next: Places::new(tables.instance),
            to: vec![None; tables.agents()],
            queue: VecDeque::new(),
            seen: vec![0; tables.instance.board.cells()],
            searches: 0,
        }
    }

    /// A successor in which constrained agents make their moves; `None` if these moves are impossible.
    pub(super) fn make(
        &mut self,
        from: &[StagedCell],
        order: &[usize],
        fixed: &[(usize, StagedCell)],
        random: &mut SplitMix64,
    ) -> Option<Vec<StagedCell>> {
        for (agent, node) in from.iter().enumerate() {
            let cell = self.tables.cell(*node);
            self.here.put(agent, cell, self.tables.place(cell));
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
            self.here.clear(self.tables.place(self.tables.cell(*node)));
        }
        for to in &mut self.to {
            if let Some(node) = to.take() {
                self.next.clear(self.tables.place(self.tables.cell(node)));
            }
        }
    }

    fn go(&mut self, agent: usize, node: StagedCell) {
        let cell = self.tables.cell(node);
        self.next.put(agent, cell, self.tables.place(cell));
        self.to[agent] = Some(node);
    }

    /// Makes the best free move; if there is none, the agent waits and pushes the agents that block its best move.
    fn decide(&mut self, from: &[StagedCell], agent: usize, push: Option<&Push>, random: &mut SplitMix64) {
        let here = from[agent];
        let candidates = match push {
            None => self.nearer(agent, here, random),
            Some(push) => self.moves_aside(agent, here, push, random),
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
            // A move back into the path is no way out, but now and then it frees a jam in which nobody can move.
            if push.is_some() && random.below(RETREAT) > 0 {
                break;
            }
        }
        self.go(agent, here);
        let Some(node) = wanted else { return };
        let to = self.tables.cell(node);
        let mut way = match push {
            None => self.way(agent, node),
            Some(_) => vec![to],
        };
        way.extend(push.iter().flat_map(|push| push.way.iter().copied()));
        let push = Rc::new(Push { at: self.tables.cell(here), way });
        let mut blocking: Vec<(CellIndex, usize)> = self.near(&self.here, agent, to).collect();
        blocking.sort_unstable();
        self.queue.extend(blocking.into_iter().map(|(_, other)| (other, Some(push.clone()))));
    }

    /// The cells of an agent's next steps on a shortest path.
    fn way(&self, agent: usize, mut node: StagedCell) -> Vec<CellIndex> {
        let mut way = vec![self.tables.cell(node)];
        while way.len() < (WAY_SEPARATIONS * self.tables.instance.separation) as usize {
            let distance = self.tables.distance(agent, node);
            let Some(next) = self.tables.next(agent, node).find(|next| self.tables.distance(agent, *next) < distance)
            else {
                break;
            };
            way.push(self.tables.cell(next));
            node = next;
        }
        way
    }

    /// The moves that reduce the distance to the goal.
    fn nearer(&self, agent: usize, here: StagedCell, random: &mut SplitMix64) -> Vec<StagedCell> {
        let distance = self.tables.distance(agent, here);
        let nearer = |node: &StagedCell| self.tables.distance(agent, *node) < distance;
        let mut moves: Vec<StagedCell> = self.tables.next(agent, here).filter(nearer).collect();
        random.shuffle(&mut moves);
        moves
    }

    /// The moves out of the pushing agent's path, the shortest way out first.
    fn moves_aside(&mut self, agent: usize, here: StagedCell, push: &Push, random: &mut SplitMix64) -> Vec<StagedCell> {
        let (tables, instance) = (self.tables, self.tables.instance);
        let way: Vec<CellPlace> = push.way.iter().map(|cell| tables.place(*cell)).collect();
        let pusher = tables.place(push.at);
        let mut moves: Vec<StagedCell> = tables.next(agent, here).skip(1).collect();
        random.shuffle(&mut moves);
        let mut lengths = vec![NONE; moves.len()];
        self.searches += 1;
        self.seen[tables.cell(here) as usize] = self.searches;
        let firsts = moves.iter().enumerate().map(|(first, node)| (tables.cell(*node), first, 1));
        let mut open: VecDeque<(CellIndex, usize, u32)> = firsts.collect();
        let mut checks = 0;
        while let Some((cell, first, length)) = open.pop_front() {
            let place = tables.place(cell);
            if tables.are_near(place, pusher) || self.seen[cell as usize] == self.searches {
                continue;
            }
            self.seen[cell as usize] = self.searches;
            checks += way.len();
            if !way.iter().any(|at| tables.are_near(place, *at)) {
                lengths[first] = lengths[first].min(length);
                continue;
            }
            if checks > MAX_CELL_CHECKS || lengths.iter().all(|known| *known < length) {
                break;
            }
            open.extend(instance.board.neighbours(cell).map(|beside| (beside, first, length + 1)));
        }
        let mut order: Vec<usize> = (0..moves.len()).filter(|first| lengths[*first] != NONE).collect();
        order.sort_by_key(|first| (lengths[*first], tables.distance(agent, moves[*first])));
        order.into_iter().map(|first| moves[first]).collect()
    }

    fn is_clear(&self, places: &Places, agent: usize, node: StagedCell) -> bool {
        self.near(places, agent, self.tables.cell(node)).next().is_none()
    }

    /// The other agents that are too near to a cell, with their cells.
    fn near<'s>(
        &'s self,
        places: &'s Places,
        agent: usize,
        cell: CellIndex,
    ) -> impl Iterator<Item = (CellIndex, usize)> + 's {
        let others = places.around(self.tables.place(cell)).filter(move |(other, _)| *other != agent);
        others.filter(move |(other, at)| self.tables.too_near(agent, cell, *other, *at)).map(|(other, at)| (at, other))
    }
}
