//! Ground truth on tiny instances: exhaustive search over the joint states of a few parts.
//!
//! A part's state is its cell, the number of stops passed, and, for the sum of costs, whether it has arrived for good,
//! after which it stays and costs nothing. All joint states are numbered, and Dijkstra's algorithm runs over the
//! numbers.

use std::cmp::Reverse;
use std::collections::BinaryHeap;
use tweeze::plan::electrode_array::board::{BoardObjective, CellIndex, Instance};

/// The least makespan or sum of costs for the agents of `group` without the others; `None` if no plan exists.
pub fn least(instance: &Instance, group: &[usize], objective: BoardObjective) -> Option<u64> {
    Joint::new(instance, group, objective).search()
}

/// Number of joint states of a search for the agents of `group`.
pub fn states(instance: &Instance, group: &[usize]) -> u64 {
    let free = (0..instance.board.cells() as CellIndex).filter(|cell| !instance.board.is_blocked(*cell)).count() as u64;
    free.saturating_pow(group.len() as u32)
}

struct Joint<'a> {
    instance: &'a Instance,
    group: &'a [usize],
    objective: BoardObjective,
    /// For each member and each of its states, the cell and the states one step later.
    members: Vec<Vec<(CellIndex, Vec<usize>)>>,
    starts: Vec<usize>,
    /// For each member, its state at its goal.
    homes: Vec<usize>,
    /// For each member, its final state; for the sum of costs, the state of having arrived for good.
    ends: Vec<usize>,
}

impl<'a> Joint<'a> {
    fn new(instance: &'a Instance, group: &'a [usize], objective: BoardObjective) -> Self {
        let mut joint =
            Joint { instance, group, objective, members: vec![], starts: vec![], homes: vec![], ends: vec![] };
        for agent in group {
            joint.add(*agent);
        }
        joint
    }

    /// Adds the states of one agent: those under way, by cell and stops passed, then the state of having arrived for
    /// good.
    fn add(&mut self, agent: usize) {
        let board = &self.instance.board;
        let stops = &self.instance.agents[agent].stops;
        let goal = *stops.last().expect("an agent has a goal");
        let free: Vec<CellIndex> = (0..board.cells() as CellIndex).filter(|cell| !board.is_blocked(*cell)).collect();
        let merges = self.instance.merges.iter().flatten().any(|merging| *merging == agent);
        let enter = |cell: CellIndex, done: usize| {
            let done = done + stops[done..].iter().take_while(|stop| **stop == cell).count();
            let place = free.binary_search(&cell).expect("a free cell");
            done * free.len() + place
        };
        let home = enter(goal, stops.len());
        let settled = free.len() * (stops.len() + 1);
        let counts_all = self.objective == BoardObjective::SumOfCosts;
        let states = (0..=stops.len()).flat_map(|done| free.iter().map(move |cell| (*cell, done)));
        let mut table: Vec<(CellIndex, Vec<usize>)> = Vec::with_capacity(settled + 1);
        for (cell, done) in states {
            let stays = merges && enter(cell, done) == home;
            let around = if stays { vec![cell] } else { self.steps(cell) };
            let mut next: Vec<usize> = around.into_iter().map(|to| enter(to, done)).collect();
            if counts_all && next.contains(&home) {
                next.push(settled);
            }
            table.push((cell, next));
        }
        table.push((goal, vec![settled]));
        self.members.push(table);
        self.starts.push(enter(self.instance.agents[agent].start, 0));
        self.homes.push(home);
        self.ends.push(if counts_all { settled } else { home });
    }

    /// A free cell and its free neighbours.
    fn steps(&self, cell: CellIndex) -> Vec<CellIndex> {
        let board = &self.instance.board;
        let (width, height) = (i64::from(board.width()), i64::from(board.height()));
        let (column, row) = (i64::from(cell) % width, i64::from(cell) / width);
        let around = [(0, 0), (1, 0), (-1, 0), (0, 1), (0, -1)].map(|(right, up)| (column + right, row + up));
        let on_board =
            around.into_iter().filter(|(column, row)| (0..width).contains(column) && (0..height).contains(row));
        let cells = on_board.map(|(column, row)| (row * width + column) as CellIndex);
        cells.filter(|cell| !board.is_blocked(*cell)).collect()
    }

    fn search(&self) -> Option<u64> {
        let size = self.members.iter().map(Vec::len).product();
        let mut least = vec![u64::MAX; size];
        let mut open = BinaryHeap::new();
        for start in self.starting() {
            least[self.number(&start)] = 0;
            open.push(Reverse((0, self.number(&start))));
        }
        let (end, mut later) = (self.number(&self.ends), Vec::new());
        while let Some(Reverse((cost, number))) = open.pop() {
            if number == end {
                return Some(cost);
            }
            if least[number] < cost {
                continue;
            }
            let state = self.state(number);
            let cost = cost + self.price(&state);
            later.clear();
            self.successors(&state, &mut vec![], &mut later);
            for next in &later {
                if cost < least[*next] {
                    least[*next] = cost;
                    open.push(Reverse((cost, *next)));
                }
            }
        }
        None
    }

    /// All agents at their starts; for the sum of costs, also with any of those that start at their goals already
    /// arrived for good.
    fn starting(&self) -> Vec<Vec<usize>> {
        let mut all = vec![self.starts.clone()];
        for member in 0..self.group.len() {
            let settled = self.ends[member];
            let at_home = self.starts[member] == self.homes[member] && settled != self.homes[member];
            if at_home {
                let arrived = all.clone().into_iter().map(|mut state| {
                    state[member] = settled;
                    state
                });
                all.extend(arrived.collect::<Vec<_>>());
            }
        }
        all
    }

    fn price(&self, state: &[usize]) -> u64 {
        match self.objective {
            BoardObjective::Makespan => 1,
            BoardObjective::SumOfCosts => state.iter().zip(&self.ends).filter(|(at, end)| at != end).count() as u64,
        }
    }

    fn number(&self, state: &[usize]) -> usize {
        state.iter().zip(&self.members).fold(0, |number, (at, states)| number * states.len() + at)
    }

    fn state(&self, mut number: usize) -> Vec<usize> {
        let mut state = vec![0; self.members.len()];
        for (at, states) in state.iter_mut().zip(&self.members).rev() {
            *at = number % states.len();
            number /= states.len();
        }
        state
    }

    /// The numbers of all joint states one step later; recursive over the members.
    fn successors(&self, from: &[usize], to: &mut Vec<usize>, found: &mut Vec<usize>) {
        let member = to.len();
        if member == from.len() {
            return found.push(self.number(to));
        }
        for next in &self.members[member][from[member]].1 {
            to.push(*next);
            if self.last_fits(from, to) {
                self.successors(from, to, found);
            }
            to.pop();
        }
    }

    /// Whether the last member's move keeps the separation rule with the moves of the members before it.
    fn last_fits(&self, from: &[usize], to: &[usize]) -> bool {
        let last = to.len() - 1;
        let ends = |member: usize| [from[member], to[member]].map(|state| self.members[member][state].0);
        let own = ends(last);
        (0..last)
            .all(|other| ends(other).iter().all(|their| own.iter().all(|at| !self.clash(last, *at, other, *their))))
    }

    fn clash(&self, member: usize, cell: CellIndex, other: usize, at: CellIndex) -> bool {
        let width = i64::from(self.instance.board.width());
        let [one, two] = [cell, at].map(|cell| (i64::from(cell) % width, i64::from(cell) / width));
        let apart = (one.0 - two.0).abs().max((one.1 - two.1).abs());
        let goal = self.instance.agents[self.group[member]].stops.last();
        let pair = [self.group[other], self.group[member]];
        let excused = self.instance.merges.contains(&pair) && (goal == Some(&cell) || goal == Some(&at));
        apart < i64::from(self.instance.separation) && !excused
    }
}
