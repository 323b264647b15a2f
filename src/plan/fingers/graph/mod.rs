//! The grasp graph: which fingers hold which contacts at which angle, and the cheapest way through it.
//!
//! **Problem.** A node is a grasp (two or three of up to six fingers, each on a contact) at an angle of a leg; an edge rolls by one
//! step, places a finger or takes one away. A route is a sequence of legs; a request holds alternative routes, and the cheapest way
//! over all of them is asked for. **Method.** A* (Hart, Nilsson and Raphael 1968) with partial expansion (Goldenberg et al. 2014) over
//! implicit nodes; the lower bound is the paper's table of reconfigurations, as corrected ([`Estimator::Published`]), or the exact
//! number of reconfigurations to go, by a flood from the goals over chains of grasps that roll into each other
//! ([`Estimator::Layers`]). **Guaranteed:** a found way is cheapest, of equally cheap routes the first; an answer that there is none is
//! a proof; of equally cheap ways one with the fewest reconfigurations is found; the same request has the same answer everywhere.
//! **Not:** which of those is found (that with the smaller estimate is looked at first, then the one found last). **Cost:** a flood takes some nanoseconds for each of the
//! C(F,2)·c² chains of pairs and each third contact, whatever the number of angles up to 64; the search, some tens for each contact
//! of a pair that it expands. Where the way with the fewest reconfigurations has to roll much farther than the turn asks for, the
//! estimate is far below the cost, and many nodes are expanded.

mod apart;
mod course;
mod flood;
mod greedy;
mod layout;
mod named;
mod published;
mod route;
mod strands;
#[cfg(test)]
mod tests;
mod walk;
mod weave;

use crate::device::fingers::MAX_FINGERS;
use crate::plan::fingers::looks::LooksBudget;
use crate::plan::fingers::mechanics::Lazy;
use crate::plan::fingers::tables::Tables;
use crate::plan::search::{GaveUp, Meter, SearchAnswer, SearchBudget};
use std::rc::Rc;
use std::sync::Arc;

/// The most nodes of one route: all grasps that could be, times all angles, of all its legs.
pub const MAX_NODES: u64 = 1 << 34;

/// The contact of each finger, from 1; 0 for a finger that is free, or that the device does not have.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Grasp(pub [u16; MAX_FINGERS as usize]);

impl Grasp {
    /// The grasp of a list, one number for each finger; `None` where the list or one of its numbers is too long.
    pub fn of(contacts: &[u32]) -> Option<Grasp> {
        let mut grasp = Grasp([0; MAX_FINGERS as usize]);
        for (finger, contact) in contacts.iter().enumerate() {
            *grasp.0.get_mut(finger)? = u16::try_from(*contact).ok()?;
        }
        Some(grasp)
    }

    /// The list for so many fingers.
    pub fn list(&self, fingers: usize) -> Vec<u32> {
        self.0.iter().take(fingers).map(|contact| u32::from(*contact)).collect()
    }

    /// The contact of a finger, from 0.
    pub fn contact(&self, finger: usize) -> Option<usize> {
        usize::from(self.0[finger]).checked_sub(1)
    }

    /// How many fingers hold.
    pub fn holding(&self) -> usize {
        self.0.iter().filter(|contact| **contact != 0).count()
    }
}

/// How the grasp at the end of a leg becomes the one at the beginning of the next.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Regrasp {
    /// Both are in the same plane: all fingers stay on their contacts.
    Same,
    /// Exactly two fingers hold, on the contacts `old` (from 0) of the leg before; they are then on `new` of this leg, in this order.
    Across { old: [usize; 2], new: [usize; 2] },
}

/// A turn in one plane, from angle 0 to angle `steps`.
#[derive(Debug, Clone)]
pub struct TurnLeg {
    /// Of its section; with one layer for each angle, or with one for all. Legs with the same `Arc` share what is made of it.
    pub tables: Arc<Tables>,
    /// Where it ends; any sign, 0 for a leg that only takes another grasp.
    pub steps: i32,
    /// The lowest angle that it may visit, at most 0 and `steps`.
    pub lowest: i32,
    /// The highest angle that it may visit, at least 0 and `steps`.
    pub highest: i32,
    /// How it follows the leg before it. Without meaning for the first leg.
    pub entry: Regrasp,
    /// The grasp at its end; `None`: any.
    pub end: Option<Grasp>,
    /// Under a load: which of the grasps, steps and removals of the tables there really are. The tables are then those without it.
    pub lazy: Option<Rc<Lazy>>,
}

impl TurnLeg {
    /// How many angles it may visit.
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

/// What a way costs, in any unit.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct GraspCosts {
    /// Rolling by one step, for each finger that holds. At least 1.
    pub roll: u32,
    /// Placing a finger, or taking one away.
    pub gait: u32,
}

/// What is asked.
#[derive(Debug, Clone)]
pub struct GraspRequest {
    /// Of the device, 3 to 6.
    pub fingers: usize,
    pub start: Start,
    /// Each a sequence of at least one leg, to be taken from its first to its last.
    pub routes: Vec<Vec<TurnLeg>>,
    pub costs: GraspCosts,
    pub within: Within,
}

/// What a search must keep to.
#[derive(Debug, Clone, Default)]
pub struct Within {
    /// The most reconfigurations of a way; `None`: any number.
    pub gaits: Option<u32>,
    /// Shared by all searches of a task.
    pub looks: Rc<LooksBudget>,
}

/// How the way to go is estimated. Neither estimate is ever too large, so that both find ways of the same cost.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Estimator {
    /// The paper's table of reconfigurations, with contacts compared modulo their number, and completed for three-finger goals, more
    /// than three fingers, and legs that follow.
    Published,
    /// The least number of reconfigurations that the tables allow, exactly.
    Layers,
}

/// A grasp at an angle of a leg, in steps from where the leg begins.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct GraspNode {
    pub grasp: Grasp,
    pub angle: i32,
}

/// A way.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct GraspPath {
    /// Index of the request's routes.
    pub route: usize,
    /// In the unit of the request's costs.
    pub cost: u64,
    /// No way of any route costs less; the cost itself where the way is proven cheapest.
    pub bound: u64,
    /// For each leg all nodes from its first at angle 0 to its last at its end; neighbours are joined by an edge.
    pub legs: Vec<Vec<GraspNode>>,
    /// How many nodes were expanded for it.
    pub expanded: u64,
}

/// The farthest that any route comes.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct FarthestRoute {
    /// Index of the request's routes: the first of those that come farthest.
    pub route: usize,
    /// Index of its first leg whose end is out of reach.
    pub leg: usize,
    /// The angle nearest to its end that is reached: the end itself if only grasps come there that it may not end with. `None`
    /// where it cannot begin, that is where the start does not hold.
    pub farthest: Option<i32>,
    /// How many of the grasps that it may end with hold at all.
    pub ends: u64,
    /// Whether all that can be reached was looked at: if not, it may come farther.
    pub is_known: bool,
}

impl FarthestRoute {
    /// No route, or none of which anything is known.
    const NOWHERE: FarthestRoute = FarthestRoute { route: 0, leg: 0, farthest: None, ends: 0, is_known: false };
}

/// What came of a request.
pub type GraspAnswer = SearchAnswer<GraspPath, FarthestRoute, GraspSearchEnd>;

/// What ended a search for grasps early.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum GraspSearchEnd {
    /// The budget of expanded nodes.
    Expansions(GaveUp),
    /// The looks that all searches of a task share; no way costs less than the bound.
    Looks { bound: u64 },
    /// A route has more nodes than [`MAX_NODES`].
    TooLarge { nodes: u64 },
}

/// The cheapest way of all routes within the limit of reconfigurations; of equally cheap ways one with the fewest reconfigurations.
///
/// A step of the budget is a node that is expanded; what floods and placements look at is counted apart, by [`LooksBudget`].
pub fn solve(request: &GraspRequest, estimator: Estimator, budget: SearchBudget) -> GraspAnswer {
    named::by_few(request, |request| route::cheapest(request, estimator, &mut Meter::new(budget)))
}

/// The first route that can be gone leg by leg: at each junction a cheapest of the F(F - 1) ways in which two fingers can hold is
/// taken.
///
/// The bound of the way is one for the joint problem. [`GraspAnswer::Impossible`] is no proof here: it tells where the route that came
/// farthest got stuck. Limits of reconfigurations are not searched for.
pub fn decompose(request: &GraspRequest, estimator: Estimator, budget: SearchBudget) -> GraspAnswer {
    named::by_few(request, |request| greedy::decompose(request, estimator, budget))
}
