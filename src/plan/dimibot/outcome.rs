//! What a search of the DiMiBot planner answers.

use super::lattice::Flip;
use crate::plan::search::SearchAnswer;

/// The answer of a search on the lattice.
pub type DimibotAnswer<P> = SearchAnswer<P, Impossible>;

/// A path of single flips.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct FlipPath {
    /// Modules in the order of their switching.
    pub flips: Vec<Flip>,
    /// Sum of the weights.
    pub cost: u64,
    /// No path costs less; equal to `cost` when the path is proven optimal.
    pub bound: u64,
    /// Steps of the search.
    pub expanded: u64,
}

/// No plan exists.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Impossible {
    /// Why.
    pub proof: Proof,
    /// Steps of the search.
    pub expanded: u64,
}

/// The ways in which a search shows that there is no plan.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Proof {
    /// The start is not a cell of the lattice.
    StartOutside,
    /// The goal is not a cell of the lattice.
    GoalOutside,
    /// An obstacle covers the start.
    StartCovered,
    /// An obstacle covers the goal.
    GoalCovered,
    /// Already between blocks of cells, where a flip counts as free if any cell of the block has it, the start and the goal are not connected.
    BlocksApart,
    /// All cells that can be reached from the start were visited: that many, and the goal is not among them.
    StartShut {
        /// Size of the start's component.
        cells: u64,
    },
    /// All cells from which the goal can be reached were visited: that many, and the start is not among them.
    GoalShut {
        /// Size of the goal's component.
        cells: u64,
    },
}

impl<P> DimibotAnswer<P> {
    pub(crate) const fn impossible(proof: Proof, expanded: u64) -> Self {
        SearchAnswer::Impossible(Impossible { proof, expanded })
    }
}
