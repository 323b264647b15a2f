//! Joint positions of the agents of a small assay, and which of them are worth keeping.

use super::super::AssayProblem;
use super::stands::JointStand;
use rustc_hash::FxHashMap;

/// Nothing waits.
pub const IDLE: u32 = u32::MAX;

/// Where all agents are and what they have done, but for the traces that they have left.
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub struct JointStandings {
    pub stands: Box<[JointStand]>,
    /// By lag, the steps since what its errand comes after was done; [`IDLE`] before that, and once the errand is done.
    pub waits: Box<[u32]>,
    /// One bit for each agent that moves no more, where sums are minimized.
    pub settled: u8,
}

/// By cell, where traces matter: one bit for each content that was left there since it was washed, and may still do harm.
pub type LeftTraces = Box<[u64]>;

/// Where all agents are, what they have done, and what they have left behind.
#[derive(Debug, Clone)]
pub struct JointPosition {
    pub standings: JointStandings,
    pub left: LeftTraces,
}

/// How a position was reached.
struct ReachedPosition {
    left: LeftTraces,
    instant: u32,
    cost: u32,
}

/// The same of a position that may be known already.
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
    /// Whether all that can be done from another position of the same standings can be done from this one, no later where `counts_instants`,
    /// and for no more: whoever has left fewer traces can do all that others can.
    fn is_no_worse(self, other: PositionMerits, counts_instants: bool) -> bool {
        let has_left_less = || self.left.iter().zip(other.left).all(|(own, theirs)| own & !theirs == 0);
        (!counts_instants || self.instant <= other.instant) && self.cost <= other.cost && has_left_less()
    }
}

/// The positions that were reached, but for those than which another one of the same standings is no worse.
pub struct KnownPositions {
    reached: FxHashMap<JointStandings, Vec<ReachedPosition>>,
    /// Whether an earlier instant is worth more cost.
    counts_instants: bool,
}

impl KnownPositions {
    pub fn new(counts_instants: bool) -> KnownPositions {
        KnownPositions { reached: FxHashMap::default(), counts_instants }
    }

    /// Keeps a position unless one that is known is no worse; whether it was kept.
    pub fn takes(&mut self, position: &JointPosition, instant: u32, cost: u32) -> bool {
        let counts_instants = self.counts_instants;
        let new = PositionMerits { left: &position.left, instant, cost };
        let reached = || ReachedPosition { left: position.left.clone(), instant, cost };
        // Most positions are known: only a new one is copied.
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

/// By agent and number of errands done: one bit for each content whose traces may harm it from then on.
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
