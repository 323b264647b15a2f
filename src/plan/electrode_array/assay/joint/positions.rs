//! Joint positions of the agents of a small assay, and dominance between them.

use super::super::AssayProblem;
use super::stands::JointStand;
use rustc_hash::FxHashMap;

/// Value of a wait that has not begun, or is over.
pub const IDLE: u32 = u32::MAX;

/// The cells of all agents and the errands that they have done, without their traces.
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub struct JointStandings {
    pub stands: Box<[JointStand]>,
    /// By lag, the steps since its predecessors were done; [`IDLE`] before that, and once its errand is done.
    pub waits: Box<[u32]>,
    /// One bit for each agent that moves no more, if the sum of costs is minimised.
    pub settled: u8,
}

/// By cell, where traces matter: one bit for each content left there since its last wash that may still contaminate an
/// agent.
pub type LeftTraces = Box<[u64]>;

/// The cells of all agents, the errands that they have done, and their traces.
#[derive(Debug, Clone)]
pub struct JointPosition {
    pub standings: JointStandings,
    pub left: LeftTraces,
}

/// Traces, instant and cost with which a position was reached.
struct ReachedPosition {
    left: LeftTraces,
    instant: u32,
    cost: u32,
}

/// The same of a position that may be known already, by reference.
#[derive(Clone, Copy)]
struct PositionMerits<'a> {
    left: &'a [u64],
    instant: u32,
    cost: u32,
}

impl ReachedPosition {
    fn merits(&self) -> PositionMerits<'_> {
        PositionMerits { left: &self.left, instant: self.instant, cost: self.cost }
    }
}

impl PositionMerits<'_> {
    /// Whether this position dominates another one with the same standings: its cost is no higher, its instant no later
    /// if `counts_instants`, and its traces are a subset, so everything possible from the other one is possible from
    /// here.
    fn is_no_worse(self, other: PositionMerits, counts_instants: bool) -> bool {
        let has_left_less = || self.left.iter().zip(other.left).all(|(own, theirs)| own & !theirs == 0);
        (!counts_instants || self.instant <= other.instant) && self.cost <= other.cost && has_left_less()
    }
}

/// The non-dominated positions reached so far.
pub struct KnownPositions {
    reached: FxHashMap<JointStandings, Vec<ReachedPosition>>,
    /// Whether an earlier instant matters, even at a higher cost.
    counts_instants: bool,
}

impl KnownPositions {
    pub fn new(counts_instants: bool) -> KnownPositions {
        KnownPositions { reached: FxHashMap::default(), counts_instants }
    }

    /// Keeps a position unless a known one dominates it; returns whether it was kept.
    pub fn takes(&mut self, position: &JointPosition, instant: u32, cost: u32) -> bool {
        let counts_instants = self.counts_instants;
        let new = PositionMerits { left: &position.left, instant, cost };
        let reached = || ReachedPosition { left: position.left.clone(), instant, cost };
        // Most positions are known; only a new one is copied.
        let Some(known) = self.reached.get_mut(&position.standings) else {
            self.reached.insert(position.standings.clone(), vec![reached()]);
            return true;
        };
        if known.iter().any(|known| known.merits().is_no_worse(new, counts_instants)) {
            return false;
        }
        known.retain(|known| !new.is_no_worse(known.merits(), counts_instants));
        known.push(reached());
        true
    }
}

/// By agent and number of errands done: one bit for each content whose traces may still contaminate it.
pub fn harmful(problem: &AssayProblem) -> Vec<Vec<u64>> {
    let Some(traces) = &problem.traces else { return Vec::new() };
    let harming = |content: usize| {
        let bits = traces.harms.iter().enumerate().map(|(before, harms)| u64::from(harms[content]) << before);
        bits.fold(0, |all, bit| all | bit)
    };
    let of_agent = |contents: &Vec<usize>| {
        let mut from: Vec<u64> = contents.iter().map(|content| harming(*content)).collect();
        (1..from.len()).rev().for_each(|done| from[done - 1] |= from[done]);
        from
    };
    traces.contents.iter().map(of_agent).collect()
}
