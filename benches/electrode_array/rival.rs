//! The crate `mapf-rs` on boards of point agents. As usual, it forbids vertex and swap conflicts; it allows following
//! into a cell that is left in the same step, which our rule at separation 1 forbids. So our plans are valid for it,
//! but its plans need not be valid for us.

use crate::clock::timed;
use mapf_rs::algorithms::lacam;
use mapf_rs::base::{AgentId, Deadline, Graph, Instance as Theirs, Solution, VertexId};
use std::time::Duration;
use tweeze::plan::electrode_array::board::{BoardCosts, CellIndex, Instance};

/// The same instance for the rival, with its graph.
pub struct Rival<'a> {
    instance: &'a Instance,
    theirs: Theirs,
}

impl<'a> Rival<'a> {
    /// Converts an instance.
    pub fn new(instance: &'a Instance) -> Self {
        let board = &instance.board;
        let free: Vec<bool> = (0..board.cells() as CellIndex).map(|cell| !board.is_blocked(cell)).collect();
        let graph = Graph::from_grid(board.width() as usize, board.height() as usize, &free);
        let vertex = |cell: CellIndex| {
            let (column, row) = board.place(cell);
            graph.vertex_at(column as usize, row as usize).expect("starts and goals are free")
        };
        let starts: Vec<VertexId> = instance.agents.iter().map(|agent| vertex(agent.start)).collect();
        let goals = instance.agents.iter().map(|agent| vertex(agent.goal())).collect();
        let theirs = Theirs::new(graph.clone(), starts, goals).expect("starts and goals differ");
        Rival { instance, theirs }
    }

    /// LaCAM until its first plan: time and costs.
    pub fn first(&self, limit: Duration) -> Option<(Duration, BoardCosts)> {
        let (time, solution) = timed(|| lacam::solve(&self.theirs, 0, &Deadline::new(limit)));
        solution.map(|solution| (time, self.costs(&solution)))
    }

    /// LaCAM*, which improves its plan until the time limit.
    pub fn bettered(&self, time: Duration) -> Option<BoardCosts> {
        lacam::solve_star(&self.theirs, 0, &Deadline::new(time)).map(|solution| self.costs(&solution))
    }

    /// Checks the plan under the rival's own rule, with its check and with one of ours, and computes its costs as we
    /// do.
    fn costs(&self, solution: &Solution) -> BoardCosts {
        assert!(solution.validate(&self.theirs).is_ok(), "the rival's plan does not pass its own check");
        let agents = 0..self.instance.agents.len();
        let paths: Vec<Vec<VertexId>> = agents.map(|agent| solution.path_of(AgentId(agent as u32)).collect()).collect();
        for step in 1..solution.len() {
            let mut taken = rustc_hash::FxHashMap::default();
            for path in &paths {
                assert_eq!(taken.insert(path[step].0, path[step - 1].0), None, "two of the rival's agents on one cell");
            }
            let swaps = |(to, from): (&u32, &u32)| to != from && taken.get(from) == Some(to);
            assert!(!taken.iter().any(swaps), "two of the rival's agents swap");
        }
        let arrival =
            |path: &Vec<VertexId>| path.iter().rposition(|at| Some(at) != path.last()).map_or(0, |at| at as u64 + 1);
        let arrivals = paths.iter().map(arrival);
        BoardCosts { makespan: arrivals.clone().max().unwrap_or(0), sum_of_costs: arrivals.sum() }
    }
}
