//! Retiming: each move is made as early as the separation rule allows.
//!
//! Problem: paths of many agents in which few move at a time, as a search of configurations produces them. Under the
//! rule all four combinations of the starts and ends of two moves keep the distance, so the moves of one step may
//! equally be made one after the other, and moves may be simultaneous as soon as no agent comes near a cell before
//! another has left it. Method: each move in turn, at the first instant after its agent's last move and after every
//! agent that was too near to its target has left. Guaranteed: legal paths with the same moves and no more steps. Cost:
//! for each move, the cells nearer than the separation.

use crate::plan::electrode_array::board::{CellIndex, Instance, Paths};

/// The same moves, each as early as possible; the paths must be legal.
pub fn earliest(instance: &Instance, paths: &Paths) -> Paths {
    let early = paths.iter().map(|path| vec![path[0]]).collect();
    let mut timing = Timing { instance, left: vec![Vec::new(); instance.board.cells()], early };
    let last = paths.iter().map(Vec::len).max().unwrap_or(0);
    for instant in 1..last {
        for (agent, path) in paths.iter().enumerate().filter(|(_, path)| instant < path.len()) {
            if path[instant - 1] != path[instant] {
                timing.make(agent, path[instant]);
            }
        }
    }
    timing.early
}

struct Timing<'a> {
    instance: &'a Instance,
    /// By cell: the agents that left it, each with the instant of its last departure.
    left: Vec<Vec<(usize, usize)>>,
    early: Paths,
}

impl Timing<'_> {
    /// Appends one agent's next move.
    fn make(&mut self, agent: usize, to: CellIndex) {
        let own = self.early[agent].len() - 1;
        let gone = self.gone(agent, to);
        let here = self.early[agent][own];
        let instant = own.max(gone) + 1;
        self.early[agent].resize(instant, here);
        self.early[agent].push(to);
        let visits = &mut self.left[here as usize];
        match visits.iter_mut().find(|(known, _)| *known == agent) {
            Some(visit) => visit.1 = instant,
            None => visits.push((agent, instant)),
        }
    }

    /// The instant by which all agents that were too near to a cell have left.
    fn gone(&self, agent: usize, to: CellIndex) -> usize {
        let near = self.instance.board.around(to, self.instance.separation);
        let instants = near.flat_map(|cell| {
            let others = self.left[cell as usize].iter().filter(move |(other, _)| *other != agent);
            others.filter(move |(other, _)| self.instance.too_near(agent, to, *other, cell))
        });
        instants.map(|(_, instant)| *instant).max().unwrap_or(0)
    }
}
