//! The grasp graph (fingers on contacts at an angle), and the search for the cheapest path through it.
//!
//! **Problem.** A node is a grasp (two or three of up to six fingers, each on a contact) at an angle of a leg; an edge
//! rolls by one step, places a finger or removes one. A route is a sequence of legs; a request holds alternative routes
//! and asks for the cheapest path over all of them. **Method.** A* (Hart, Nilsson and Raphael 1968) with partial
//! expansion (Goldenberg et al. 2014) over implicit nodes. The heuristic is the paper's table of reconfigurations, as
//! corrected ([`Estimator::Published`]), or the exact number of remaining reconfigurations, by a flood from the goals
//! over chains of grasps that roll into one another ([`Estimator::Layers`]). **Guaranteed**, within the angles that the
//! legs may visit: a returned path is cheapest, and has the fewest reconfigurations among equally cheap ones; of
//! equally cheap routes the first is taken; the answer that there is no path is a proof; the same request has the same
//! answer everywhere. **Not guaranteed:** which of several such paths is found (the node with the smaller estimate is
//! expanded first, then the one found last).
//! **Cost:** a flood takes some nanoseconds for each third contact of each of the C(F,2)·c² chains of pairs, whatever
//! the number of angles up to 64; the search takes some tens of nanoseconds for each contact of a pair that it expands.
//! If the path with the fewest reconfigurations must roll much farther than the turn requires, the estimate is far
//! below the cost, and many nodes are expanded.

mod course;
mod flood;
mod greedy;
mod layout;
mod leg_bounds;
mod published;
mod route;
mod strands;
mod symmetry;
#[cfg(test)]
mod tests;
mod walk;
mod weave;

use crate::device::fingers::MAX_FINGERS;
use crate::plan::fingers::looks::LooksBudget;
use crate::plan::fingers::mechanics::LazyGraspEvaluator;
use crate::plan::fingers::tables::Tables;
use crate::plan::search::{GaveUp, Meter, SearchAnswer, SearchBudget};
use std::rc::Rc;
use std::sync::Arc;

/// Most nodes of one route: all conceivable grasps, times all angles, of all its legs.
pub const MAX_NODES: u64 = 1 << 36;

/// The contact of each finger, from 1; 0 for a free finger, or one that the device does not have.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Grasp(pub [u16; MAX_FINGERS as usize]);

impl Grasp {
    /// A grasp from a list, one number per finger; `None` if the list is too long or one of its numbers too large.
    pub fn of(contacts: &[u32]) -> Option<Grasp> {
        let mut grasp = Grasp([0; MAX_FINGERS as usize]);
        for (finger, contact) in contacts.iter().enumerate() {
            *grasp.0.get_mut(finger)? = u16::try_from(*contact).ok()?;
        }
        Some(grasp)
    }

    /// The grasp as a list for `fingers` fingers.
    pub fn list(&self, fingers: usize) -> Vec<u32> {
        self.0.iter().take(fingers).map(|contact| u32::from(*contact)).collect()
    }

    /// The contact of a finger, from 0.
    pub fn contact(&self, finger: usize) -> Option<usize> {
        usize::from(self.0[finger]).checked_sub(1)
    }

    /// Number of fingers that hold.
    pub fn holding(&self) -> usize {
        self.0.iter().filter(|contact| **contact != 0).count()
    }
}

/// Relation between the grasp at the end of a leg and the one at the beginning of the next.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Regrasp {
    /// Both legs are in the same plane: all fingers stay on their contacts.
    Same,
    /// Exactly two fingers hold, on the contacts `old` (from 0) of the previous leg; on this leg they are on `new`, in this order.
    Across { old: [usize; 2], new: [usize; 2] },
}

/// A turn in one plane, from angle 0 to angle `steps`.
#[derive(Debug, Clone)]
pub struct TurnLeg {
    /// Tables of its section, with one layer for each angle or one for all. Legs with the same `Arc` share derived data.
    pub tables: Arc<Tables>,
    /// End angle; any sign, 0 for a leg that only changes the grasp.
    pub steps: i32,
    /// The lowest angle that it may visit, at most 0 and `steps`.
    pub lowest: i32,
    /// The highest angle that it may visit, at least 0 and `steps`.
    pub highest: i32,
    /// Transition from the previous leg. Ignored for the first leg.
    pub entry: Regrasp,
    /// The grasp required at its end; `None`: any.
    pub end: Option<Grasp>,
    /// Evaluator under a load: it decides which of the grasps, steps and removals in the tables hold. The tables are
    /// then those without the load.
    pub lazy: Option<Rc<LazyGraspEvaluator>>,
}

impl TurnLeg {
    /// Number of angles that it may visit.
    pub fn angles(&self) -> usize {
        (self.highest - self.lowest) as usize + 1
    }
}

/// The grasp at the beginning of every route.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Start {
    Any,
    At(Grasp),
}

/// Edge costs, in any unit.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct GraspCosts {
    /// Cost of rolling by one step, for each finger that holds. At least 1.
    pub roll: u32,
    /// Cost of placing or removing a finger.
    pub gait: u32,
}

/// Request to the search.
#[derive(Debug, Clone)]
pub struct GraspRequest {
    /// Number of fingers of the device, 3 to 6.
    pub fingers: usize,
    pub start: Start,
    /// Alternatives, each a sequence of at least one leg, to be followed from first to last.
    pub routes: Vec<Vec<TurnLeg>>,
    pub costs: GraspCosts,
    pub limits: GraspSearchLimits,
}

/// Limits of a search.
#[derive(Debug, Clone, Default)]
pub struct GraspSearchLimits {
    /// Most reconfigurations of a path; `None`: unlimited.
    pub gaits: Option<u32>,
    /// Shared by all searches of a task.
    pub looks: Rc<LooksBudget>,
}

/// Heuristic of the search. Both are admissible, so both find paths of the same cost.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Estimator {
    /// The paper's table of reconfigurations, with contacts compared modulo their number, and extended to three-finger goals, more
    /// than three fingers, and subsequent legs.
    Published,
    /// The exact least number of reconfigurations that the tables allow.
    Layers,
}

/// A grasp at an angle of a leg, in steps from the start of the leg.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct GraspNode {
    pub grasp: Grasp,
    pub angle: i32,
}

/// A path through the grasp graph.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct GraspPath {
    /// Index into the request's routes.
    pub route: usize,
    /// In the unit of the request's costs.
    pub cost: u64,
    /// Lower bound over all routes; equal to `cost` where the path is proven cheapest.
    pub bound: u64,
    /// For each leg, all nodes from its first at angle 0 to its last at its end; neighbours are joined by an edge.
    pub legs: Vec<Vec<GraspNode>>,
    /// Number of nodes expanded.
    pub expanded: u64,
}

/// The farthest point that any route reaches.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct FarthestRoute {
    /// Index into the request's routes: the first of those that reach farthest.
    pub route: usize,
    /// Index of its first leg whose end is unreachable.
    pub leg: usize,
    /// The reached angle nearest to its end; the end itself if it is reached only with grasps that may not end the leg.
    /// `None` if it cannot begin, because the start does not hold.
    pub farthest: Option<i32>,
    /// Number of allowed end grasps that hold at all.
    pub ends: u64,
    /// Whether everything reachable was explored; if not, the route may reach farther.
    pub is_known: bool,
}

impl FarthestRoute {
    /// No route, or nothing is known of any.
    const NOWHERE: FarthestRoute = FarthestRoute { route: 0, leg: 0, farthest: None, ends: 0, is_known: false };
}

/// Result of a request.
pub type GraspAnswer = SearchAnswer<GraspPath, FarthestRoute, GraspSearchEnd>;

/// The limit that ended a search for grasps early.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum GraspSearchEnd {
    /// The budget of expanded nodes.
    Expansions(GaveUp),
    /// The looks that all searches of a task share; lower bound on the cost of any path.
    Looks { bound: u64 },
    /// A route has more nodes than [`MAX_NODES`].
    TooLarge { nodes: u64 },
}

/// The cheapest path over all routes within the limit on reconfigurations; of equally cheap ones, a path with the fewest
/// reconfigurations.
///
/// A step of the budget is an expanded node; looks of floods and placements are counted separately, by [`LooksBudget`].
pub fn solve(request: &GraspRequest, estimator: Estimator, budget: SearchBudget) -> GraspAnswer {
    symmetry::with_fewest_fingers(request, |request| {
        route::cheapest(request, estimator, leg_bounds::bounds, &mut Meter::new(budget))
    })
}

/// The first route that is feasible leg by leg: at each junction, the cheapest of the F(F - 1) assignments of two
/// fingers is taken.
///
/// The bound of the path holds for the joint problem. [`GraspAnswer::Impossible`] is no proof here: it reports where the route that
/// came farthest got stuck. Limits on reconfigurations are ignored.
pub fn decompose(request: &GraspRequest, estimator: Estimator, budget: SearchBudget) -> GraspAnswer {
    symmetry::with_fewest_fingers(request, |request| greedy::decompose(request, estimator, budget))
}
