//! The truth about tiny instances: every joint state of a few parts, by breadth first and by Dijkstra. Plain and slow.
//!
//! A part's place is its cell and how many of its stops it has come by; for the sum of costs also whether it has arrived for good,
//! after which it stays and is free of charge.

use std::cmp::Reverse;
use std::collections::{BinaryHeap, HashMap, HashSet, VecDeque};
use tweeze::plan::electrode_array::board::{Cell, Instance, Objective};

/// Cell, stops done, arrived for good.
type Part = (Cell, usize, bool);

/// The least makespan or sum of costs, or none if no plan exists; of the agents of `group`, as if the others were not there.
pub fn least(instance: &Instance, group: &[usize], objective: Objective) -> Option<u64> {
    let joint = Joint { instance, group };
    match objective {
        Objective::Makespan => joint.breadth_first(),
        Objective::SumOfCosts => joint.dijkstra(),
    }
}

/// The plain bound of one part alone; none if it is walled in.
pub fn alone(instance: &Instance, agent: usize) -> Option<u64> {
    least(instance, &[agent], Objective::Makespan)
}

struct Joint<'a> {
    instance: &'a Instance,
    group: &'a [usize],
}

impl Joint<'_> {
    fn start(&self) -> Vec<Part> {
        let start = |agent: &usize| self.at(*agent, self.instance.agents[*agent].start, 0);
        self.group.iter().map(start).collect()
    }

    fn at(&self, agent: usize, cell: Cell, done: usize) -> Part {
        let stops = &self.instance.agents[agent].stops[done..];
        (cell, done + stops.iter().take_while(|stop| **stop == cell).count(), false)
    }

    fn is_home(&self, agent: usize, part: Part) -> bool {
        let stops = &self.instance.agents[agent].stops;
        part.1 == stops.len() && stops.last() == Some(&part.0)
    }

    fn breadth_first(&self) -> Option<u64> {
        let mut seen = HashSet::from([self.start()]);
        let mut open = VecDeque::from([(self.start(), 0)]);
        while let Some((state, instant)) = open.pop_front() {
            if self.group.iter().zip(&state).all(|(agent, part)| self.is_home(*agent, *part)) {
                return Some(instant);
            }
            for next in self.successors(&state) {
                if seen.insert(next.clone()) {
                    open.push_back((next, instant + 1));
                }
            }
        }
        None
    }

    fn dijkstra(&self) -> Option<u64> {
        let mut least: HashMap<Vec<Part>, u64> = HashMap::new();
        let mut open: BinaryHeap<Reverse<(u64, Vec<Part>)>> =
            self.with_arrivals(self.start()).into_iter().map(|state| Reverse((0, state))).collect();
        while let Some(Reverse((cost, state))) = open.pop() {
            if state.iter().all(|part| part.2) {
                return Some(cost);
            }
            if least.get(&state).is_some_and(|known| *known < cost) {
                continue;
            }
            let cost = cost + state.iter().filter(|part| !part.2).count() as u64;
            for next in self.successors(&state).into_iter().flat_map(|next| self.with_arrivals(next)) {
                if least.get(&next).is_none_or(|known| cost < *known) {
                    least.insert(next.clone(), cost);
                    open.push(Reverse((cost, next)));
                }
            }
        }
        None
    }

    /// The state itself, and each in which some of those at home have arrived for good.
    fn with_arrivals(&self, state: Vec<Part>) -> Vec<Vec<Part>> {
        let mut all = vec![state];
        for (member, agent) in self.group.iter().enumerate() {
            let home: Vec<Vec<Part>> =
                all.iter().filter(|state| self.is_home(*agent, state[member]) && !state[member].2).cloned().collect();
            all.extend(home.into_iter().map(|mut state| {
                state[member].2 = true;
                state
            }));
        }
        all
    }

    fn successors(&self, state: &[Part]) -> Vec<Vec<Part>> {
        let mut partial: Vec<Vec<Part>> = vec![vec![]];
        for member in 0..self.group.len() {
            let moves = self.moves(self.group[member], state[member]);
            let extended = partial.iter().flat_map(|before| {
                let fits = moves.iter().filter(|to| self.fits(state, before, **to));
                fits.map(|to| before.iter().copied().chain([*to]).collect())
            });
            partial = extended.collect();
        }
        partial
    }

    fn moves(&self, agent: usize, (cell, done, arrived): Part) -> Vec<Part> {
        let merges = self.instance.merges.iter().flatten().any(|merging| *merging == agent);
        if arrived || merges && self.is_home(agent, (cell, done, arrived)) {
            return vec![(cell, done, arrived)];
        }
        let board = &self.instance.board;
        let (width, height) = (i64::from(board.width()), i64::from(board.height()));
        let (column, row) = (i64::from(cell) % width, i64::from(cell) / width);
        [(0, 0), (1, 0), (-1, 0), (0, 1), (0, -1)]
            .into_iter()
            .map(|(right, up)| (column + right, row + up))
            .filter(|(column, row)| (0..width).contains(column) && (0..height).contains(row))
            .map(|(column, row)| (row * width + column) as Cell)
            .filter(|next| !board.is_blocked(*next))
            .map(|next| self.at(agent, next, done))
            .collect()
    }

    /// Whether a member's move keeps the rule with the moves of those before it.
    fn fits(&self, from: &[Part], before: &[Part], to: Part) -> bool {
        let member = before.len();
        let own = [from[member].0, to.0];
        before.iter().enumerate().all(|(other, other_to)| {
            let theirs = [from[other].0, other_to.0];
            own.iter().all(|at| theirs.iter().all(|their| !self.clash((member, *at), (other, *their))))
        })
    }

    fn clash(&self, (member, cell): (usize, Cell), (other, at): (usize, Cell)) -> bool {
        let width = i64::from(self.instance.board.width());
        let [one, two] = [cell, at].map(|cell| (i64::from(cell) % width, i64::from(cell) / width));
        let apart = (one.0 - two.0).abs().max((one.1 - two.1).abs());
        let pair = [self.group[other], self.group[member]];
        let goal = self.instance.agents[self.group[member]].goal();
        let excused = self.instance.merges.contains(&pair) && (cell == goal || at == goal);
        apart < i64::from(self.instance.separation) && !excused
    }
}
