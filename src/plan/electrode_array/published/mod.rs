//! The planner of Kritikou et al. 2018 as printed, for comparison: parts one after the other, each step by step to its
//! goal.
//!
//! Problem: parts that move at the same time on a board, in order of priority. Method: "μCA*", Algorithm 1 of G.
//! Kritikou, N. Lamprianidis, N. Aspragathos, "A Modified Cooperative A* Algorithm for the Simultaneous Motion of
//! Multiple Microparts on a Smart Platform with Electrostatic Fields", Micromachines 9(11), 548, 2018. For each part of
//! higher priority the whole path is known; the next position of a part is the one of its five candidates that is
//! allowed and has the least value of a function (equation 12 or 13); one candidate survives each step, without
//! backtracking.
//!
//! Guaranteed: a part that has a path keeps the chosen check against every part of higher priority that has one, up to
//! the horizon. Not guaranteed: that a path is found where there is one, or that it is short. Parts without a path are
//! ignored by the others although they still stand on the board, as in the paper. Cost: parts² · horizon.

mod table;

use super::board::{BoardGrid, CellIndex, Instance, position};
pub use table::{PartMotion, Zero};

/// Function whose least value chooses the next position.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Heuristic {
    /// Equation 12: the candidate's Manhattan distance from the goal, plus a summand below 1 that prefers candidates
    /// far from the parts of higher priority.
    Spread,
    /// Equation 13: the Manhattan distance alone; its other summand is the same for all candidates.
    Plain,
}

/// Check of two moves for compatibility.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum PairCheck {
    /// The rule of the board: all four combinations of starts and ends keep the separation.
    Clean,
    /// Table 3 as printed, with its unsafe and its over-strict entries; designed for a separation of 4.
    AsPublished(Zero),
}

/// Tie-breaking between candidates of equal least value, which the paper leaves open.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Ties {
    /// The order of the candidates, each motion once; the first of the best survives.
    pub order: [PartMotion; 5],
}

impl Default for Ties {
    /// The order of the paper's action space: right, left, down, up, stay.
    fn default() -> Self {
        Ties { order: [PartMotion::Right, PartMotion::Left, PartMotion::Down, PartMotion::Up, PartMotion::Stay] }
    }
}

/// An interpretation of the paper.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct PaperReading {
    pub heuristic: Heuristic,
    pub check: PairCheck,
    pub ties: Ties,
}

/// Result for one part.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum PublishedOutcome {
    /// Its path up to its last arrival at its goal; it stays there up to the horizon.
    Arrived(Vec<CellIndex>),
    /// "There is no path": after this partial path no candidate was allowed.
    Stuck(Vec<CellIndex>),
    /// The horizon came first; this is the path up to it.
    OutOfTime(Vec<CellIndex>),
}

impl PublishedOutcome {
    /// Steps to the last arrival, if it arrived.
    pub fn finish(&self) -> Option<usize> {
        match self {
            PublishedOutcome::Arrived(path) => Some(path.len() - 1),
            PublishedOutcome::Stuck(_) | PublishedOutcome::OutOfTime(_) => None,
        }
    }
}

/// A candidate's value, `goal_distance + others / spread`; with the plain function, or for the first part, `others` is
/// 0.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct CandidateValue {
    /// Manhattan distance to the next stop, and from there through the remaining ones.
    pub goal_distance: u64,
    /// Number of parts of higher priority that count.
    pub others: u64,
    /// The sum of the Manhattan distances to them, at least 1.
    pub spread: u64,
}

impl CandidateValue {
    /// Exact comparison of the values.
    fn less_than(&self, other: &CandidateValue) -> bool {
        let scaled = |one: &CandidateValue, by: &CandidateValue| {
            u128::from(one.goal_distance * one.spread + one.others) * u128::from(by.spread)
        };
        scaled(self, other) < scaled(other, self)
    }
}

/// Plans every part, in the order of the instance, over `horizon` steps; one outcome per part.
pub fn plan(instance: &Instance, reading: PaperReading, horizon: usize) -> Vec<PublishedOutcome> {
    let mut outcomes: Vec<PublishedOutcome> = Vec::with_capacity(instance.agents.len());
    let mut walks: Vec<(usize, Vec<CellIndex>)> = Vec::new();
    for agent in 0..instance.agents.len() {
        let walk = PublishedWalk { instance, reading, agent, higher: &walks };
        let outcome = walk.run(horizon);
        if let PublishedOutcome::Arrived(path) | PublishedOutcome::OutOfTime(path) = &outcome {
            walks.push((agent, path.clone()));
        }
        outcomes.push(outcome);
    }
    outcomes
}

/// Search for the path of one part, given the paths of those of higher priority.
struct PublishedWalk<'a> {
    instance: &'a Instance,
    reading: PaperReading,
    agent: usize,
    /// The agents of higher priority that have a path, with their paths.
    higher: &'a [(usize, Vec<CellIndex>)],
}

impl PublishedWalk<'_> {
    fn run(&self, horizon: usize) -> PublishedOutcome {
        let agent = &self.instance.agents[self.agent];
        let mut path = vec![agent.start];
        let mut stops_done = self.stops_done(0, agent.start);
        let mut arrived = (stops_done == agent.stops.len()).then_some(0);
        for instant in 1..=horizon {
            let here = path[instant - 1];
            let Some((next, _)) = self.best(instant, here, stops_done) else { return PublishedOutcome::Stuck(path) };
            path.push(next);
            stops_done = self.stops_done(stops_done, next);
            let at_goal = stops_done == agent.stops.len() && next == agent.goal();
            arrived = if at_goal { arrived.or(Some(instant)) } else { None };
        }
        match arrived {
            Some(last) => {
                path.truncate(last + 1);
                PublishedOutcome::Arrived(path)
            }
            None => PublishedOutcome::OutOfTime(path),
        }
    }

    fn stops_done(&self, done: usize, at: CellIndex) -> usize {
        done + self.instance.agents[self.agent].stops[done..].iter().take_while(|stop| **stop == at).count()
    }

    /// The candidate that survives at an instant.
    fn best(&self, instant: usize, here: CellIndex, stops_done: usize) -> Option<(CellIndex, CandidateValue)> {
        let mut best: Option<(CellIndex, CandidateValue)> = None;
        for (cell, value) in self.candidates(instant, here, stops_done) {
            if best.as_ref().is_none_or(|(_, least)| value.less_than(least)) {
                best = Some((cell, value));
            }
        }
        best
    }

    /// The allowed candidates in the order of the motions, each with its value.
    fn candidates(&self, instant: usize, here: CellIndex, stops_done: usize) -> Vec<(CellIndex, CandidateValue)> {
        let moves = self.reading.ties.order.iter().filter_map(|motion| moved(&self.instance.board, here, *motion));
        moves
            .filter(|next| self.is_allowed(instant, here, *next))
            .map(|next| (next, self.value(instant, next, stops_done)))
            .collect()
    }

    fn is_allowed(&self, instant: usize, here: CellIndex, next: CellIndex) -> bool {
        self.higher.iter().all(|(other, way)| {
            let theirs = [position(way, instant - 1), position(way, instant)];
            match self.reading.check {
                PairCheck::Clean => self.keeps_rule([here, next], *other, theirs),
                PairCheck::AsPublished(_) if self.instance.merge_cell(self.agent, *other).is_some() => {
                    self.keeps_rule([here, next], *other, theirs)
                }
                PairCheck::AsPublished(zero) => table::allows(&self.instance.board, theirs, [here, next], zero),
            }
        })
    }

    fn keeps_rule(&self, own: [CellIndex; 2], other: usize, theirs: [CellIndex; 2]) -> bool {
        own.iter().all(|at| theirs.iter().all(|their| !self.instance.too_near(self.agent, *at, other, *their)))
    }

    fn value(&self, instant: usize, at: CellIndex, stops_done: usize) -> CandidateValue {
        let board = &self.instance.board;
        let agent = &self.instance.agents[self.agent];
        let ahead = &agent.stops[stops_done..];
        let goals = if ahead.is_empty() {
            std::slice::from_ref(agent.stops.last().expect("an agent has a goal"))
        } else {
            ahead
        };
        let onward = goals.windows(2).map(|pair| u64::from(board.manhattan(pair[0], pair[1]))).sum::<u64>();
        let goal_distance = u64::from(board.manhattan(at, goals[0])) + onward;
        match self.reading.heuristic {
            Heuristic::Plain => CandidateValue { goal_distance, others: 0, spread: 1 },
            Heuristic::Spread => {
                let from = |(_, way): &(usize, Vec<CellIndex>)| u64::from(board.manhattan(at, position(way, instant)));
                let spread = self.higher.iter().map(from).sum::<u64>().max(1);
                CandidateValue { goal_distance, others: self.higher.len() as u64, spread }
            }
        }
    }
}

/// The cell to which a motion leads; `None` if it is off the board or blocked.
fn moved(board: &BoardGrid, here: CellIndex, motion: PartMotion) -> Option<CellIndex> {
    let (column, row) = board.place(here);
    let cell = match motion {
        PartMotion::Right => (column + 1 < board.width()).then(|| here + 1),
        PartMotion::Left => (column > 0).then(|| here - 1),
        PartMotion::Down => (row > 0).then(|| here - board.width()),
        PartMotion::Up => (row + 1 < board.height()).then(|| here + board.width()),
        PartMotion::Stay => Some(here),
    };
    cell.filter(|cell| !board.is_blocked(*cell))
}

#[cfg(test)]
mod tests;
