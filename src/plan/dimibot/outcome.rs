//! Results of the searches of the DiMiBot planner.

use super::lattice::Flip;
use crate::plan::search::SearchAnswer;

/// Result of a search on the lattice.
pub type DimibotAnswer<P> = SearchAnswer<P, Impossible>;

/// A path of single flips.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct FlipPath {
    /// Modules in the order of their switching.
    pub flips: Vec<Flip>,
    /// Sum of the weights.
    pub cost: u64,
    /// Lower bound on the cost of any path; equal to `cost` when the path is proven optimal.
    pub bound: u64,
    /// Steps of the search.
    pub expanded: u64,
}

/// No plan exists.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Impossible {
    /// Kind of proof.
    pub proof: Proof,
    /// Steps of the search.
    pub expanded: u64,
}

/// Proof that there is no plan.
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
    /// The blocks of start and goal are not connected, although a flip of a block counts as free if it is legal from
    /// any of its cells.
    BlocksApart,
    /// The search exhausted the component of the start, which does not contain the goal.
    StartShut {
        /// Size of the start's component.
        cells: u64,
    },
    /// The search exhausted the component of the goal, which does not contain the start.
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
