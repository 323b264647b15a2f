//! Paths between two stops of a task: the best one by an objective, or the Pareto front within limits.
//!
//! Input: a field, cells and budgets. Output: a [`Best`] leg, or a [`LabelFront`] of legs. Guaranteed: each leg is searched once, in
//! one direction; the result holds for both, since a path may be reversed.

use super::field::LatticeField;
use super::labels::{self, LabelFront};
use super::lattice::{Flip, LatticeCell, ModulePulse, Side, SwitchWeights};
use super::outcome::{DimibotAnswer, FlipPath, Impossible};
use super::pulses::{self, PulseTrain};
use super::tally::MotionTally;
use super::{published, shortest};
use crate::claims::dimibot::{DimibotMethod, DimibotObjective};
use crate::plan::search::{GaveUp, Meter, SearchBudget};
use rustc_hash::FxHashMap;

/// Minimum tie-breaking budget of a leg, however cheap the leg was.
const TIE_STEPS: u64 = 1 << 18;
/// Tie-breaking budget of a leg as a multiple of the steps that found it.
const TIE_FACTOR: u64 = 4;
/// Low bits of a lexicographic weight that hold the switches of a path, if distance comes first.
const SWITCH_BITS: u32 = 28;
/// Low bits of a lexicographic weight that hold the distance of a path, if switches come first.
const DISTANCE_BITS: u32 = 40;
/// A path with at most this many switches has a distance below 2^[`DISTANCE_BITS`].
const MAX_SWITCHES: u64 = 1 << 20;

/// The best path between two cells.
#[derive(Clone, Debug)]
pub(super) struct Best {
    pub(super) tally: MotionTally,
    pub(super) pulses: Vec<ModulePulse>,
    /// Lower bound on the objective's figure.
    pub(super) bound: u64,
    /// Whether no path of equal cost is better in the other figures.
    pub(super) is_exact: bool,
}

/// Why there is no leg.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum NoLeg {
    Impossible(Impossible),
    GaveUp(GaveUp),
}

/// Budgets of the searches of one stage.
pub(super) struct Meters {
    /// Budget for finding paths.
    pub(super) find: Meter,
    /// Budget for breaking ties between them.
    pub(super) ties: Meter,
    /// Budget for paths within limits.
    pub(super) limits: Meter,
}

impl Meters {
    pub(super) fn new(expansions: u64) -> Self {
        let meter = || Meter::new(SearchBudget::of(expansions));
        Meters { find: meter(), ties: meter(), limits: meter() }
    }
}

/// Searches legs and remembers them.
pub(super) struct Legs<'a> {
    field: &'a LatticeField,
    method: DimibotMethod,
    /// Whether several modules may switch in one pulse.
    with_pulses: bool,
    best: FxHashMap<(LatticeCell, LatticeCell, ObjectiveRank), Best>,
}

/// Objectives that rank paths alike share a search.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
enum ObjectiveRank {
    Distance,
    Switches,
    Pulses,
}

impl<'a> Legs<'a> {
    pub(super) fn new(field: &'a LatticeField, method: DimibotMethod, with_pulses: bool) -> Self {
        Legs { field, method, with_pulses, best: FxHashMap::default() }
    }

    /// The objectives that rank paths differently.
    pub(super) fn objectives(&self) -> &'static [DimibotObjective] {
        match self.with_pulses {
            true => &[DimibotObjective::Distance, DimibotObjective::Switches, DimibotObjective::Time],
            false => &[DimibotObjective::Distance, DimibotObjective::Switches],
        }
    }

    /// Class of the objectives that rank paths as this one does.
    fn rank(&self, objective: DimibotObjective) -> ObjectiveRank {
        match objective {
            DimibotObjective::Distance => ObjectiveRank::Distance,
            DimibotObjective::Time if self.with_pulses => ObjectiveRank::Pulses,
            DimibotObjective::Time | DimibotObjective::Switches | DimibotObjective::Energy => ObjectiveRank::Switches,
        }
    }

    /// The best leg from one cell to the other.
    pub(super) fn best(
        &mut self,
        [from, to]: [LatticeCell; 2],
        objective: DimibotObjective,
        meters: &mut Meters,
    ) -> Result<Best, NoLeg> {
        let rank = self.rank(objective);
        if let Some(best) = self.best.get(&(from, to, rank)) {
            return Ok(best.clone());
        }
        if let Some(best) = self.best.get(&(to, from, rank)) {
            return Ok(Best { pulses: best.pulses.iter().rev().copied().collect(), ..best.clone() });
        }
        let best = match rank {
            ObjectiveRank::Pulses => self.by_pulses([from, to], meters)?,
            ObjectiveRank::Distance | ObjectiveRank::Switches if self.method == DimibotMethod::StagedAstar => {
                self.by_stages([from, to], rank, meters)?
            }
            ObjectiveRank::Distance | ObjectiveRank::Switches => self.as_published([from, to], rank, meters)?,
        };
        self.best.insert((from, to, rank), best.clone());
        Ok(best)
    }

    /// Pareto front of the legs that may be part of a best route within these limits.
    pub(super) fn front(
        &mut self,
        ends: [LatticeCell; 2],
        limits: MotionTally,
        meters: &mut Meters,
    ) -> Result<LabelFront<Vec<ModulePulse>>, NoLeg> {
        let mut known = Vec::new();
        let mut least = MotionTally::MAX;
        for objective in self.objectives() {
            let best = self.best(ends, *objective, meters)?;
            match objective {
                DimibotObjective::Distance => least.distance = best.bound,
                DimibotObjective::Switches | DimibotObjective::Energy => least.switches = best.bound,
                DimibotObjective::Time => least.pulses = best.bound,
            }
            known.push((best.tally, best.pulses));
        }
        if !self.with_pulses {
            least.pulses = least.switches;
        }
        // One path may be best in every figure.
        if let Some(way) = known.iter().find(|(tally, _)| *tally == least) {
            let ways = Some(way.clone()).filter(|(tally, _)| tally.is_within(limits));
            return Ok(LabelFront { ways: ways.into_iter().collect(), is_complete: true });
        }
        if !least.is_within(limits) {
            return Ok(LabelFront { ways: Vec::new(), is_complete: true });
        }
        if self.with_pulses {
            return Ok(pulses::front(self.field, ends, limits, known, &mut meters.limits));
        }
        let known = known.into_iter().map(|(tally, pulses)| (tally, pulses.into_iter().filter_map(flip).collect()));
        let front = labels::front(self.field, ends, limits, known.collect(), &mut meters.limits);
        let ways = front.ways.into_iter().map(|(tally, flips)| (tally, flips.into_iter().map(single).collect()));
        Ok(LabelFront { ways: ways.collect(), is_complete: front.is_complete })
    }

    fn by_pulses(&self, [from, to]: [LatticeCell; 2], meters: &mut Meters) -> Result<Best, NoLeg> {
        let train = match pulses::pulses(self.field, from, to, meters.find.left()) {
            DimibotAnswer::Found(train) => train,
            DimibotAnswer::Impossible(proof) => return Err(self.impossible(proof, meters)),
            DimibotAnswer::GaveUp(report) => return Err(self.gave_up(report, meters)),
        };
        meters.find.charge_metered(train.expanded);
        let PulseTrain { pulses, bound, .. } = train;
        let tally = MotionTally::sum(self.field.lattice(), &pulses);
        let is_exact = pulses::is_small(self.field.lattice()) || pulses.len() <= 1;
        Ok(Best { tally, pulses, bound, is_exact })
    }

    /// Searches for the objective alone first, which is the problem that the staged search is built for; then, if ties
    /// may remain, for all figures in lexicographic order.
    fn by_stages(&self, [from, to]: [LatticeCell; 2], rank: ObjectiveRank, meters: &mut Meters) -> Result<Best, NoLeg> {
        let weights = self.weights(rank);
        let path = match shortest(self.field, from, to, &weights[0], meters.find.left()) {
            DimibotAnswer::Found(path) => path,
            DimibotAnswer::Impossible(proof) => return Err(self.impossible(proof, meters)),
            DimibotAnswer::GaveUp(report) => return Err(self.gave_up(report, meters)),
        };
        meters.find.charge_metered(path.expanded);
        let best = self.of_path(&path, path.bound);
        if best.is_exact || path.cost > path.bound {
            return Ok(best);
        }
        let allowed = TIE_STEPS.max(path.expanded.saturating_mul(TIE_FACTOR)).min(meters.ties.left().steps);
        let ordered = ordered(&weights, rank);
        match shortest(self.field, from, to, &ordered, SearchBudget::of(allowed)) {
            DimibotAnswer::Found(fine) if fine.cost == fine.bound && fine.cost >> bits(rank) == path.cost => {
                meters.ties.charge_metered(fine.expanded);
                let fine = self.of_path(&fine, path.bound);
                let is_exact = is_exact(rank, fine.tally);
                Ok(Best { is_exact, ..fine })
            }
            DimibotAnswer::Found(_) | DimibotAnswer::Impossible(_) | DimibotAnswer::GaveUp(_) => {
                meters.ties.charge_metered(allowed);
                Ok(best)
            }
        }
    }

    fn as_published(
        &self,
        [from, to]: [LatticeCell; 2],
        rank: ObjectiveRank,
        meters: &mut Meters,
    ) -> Result<Best, NoLeg> {
        let method = match self.method {
            DimibotMethod::StagedAstar => shortest,
            DimibotMethod::Dijkstra => published::dijkstra,
            DimibotMethod::BidirectionalDijkstra => published::bidirectional_dijkstra,
            DimibotMethod::Astar => published::astar,
            DimibotMethod::HypercubeAstar => published::hypercube_astar,
        };
        let weights = self.weights(rank);
        let path = match method(self.field, from, to, &ordered(&weights, rank), meters.find.left()) {
            DimibotAnswer::Found(path) => path,
            DimibotAnswer::Impossible(proof) => return Err(self.impossible(proof, meters)),
            DimibotAnswer::GaveUp(report) => {
                let report = GaveUp { bound: report.bound >> bits(rank), ..report };
                return Err(self.gave_up(report, meters));
            }
        };
        meters.find.charge_metered(path.expanded);
        let best = self.of_path(&path, path.bound >> bits(rank));
        if is_exact(rank, best.tally) {
            return Ok(Best { is_exact: true, ..best });
        }
        // Once a second figure overflows its bits, the order of the sums is no longer that of the figures.
        let bound = weights[0].between(from, to);
        Ok(Best { bound, is_exact: false, ..best })
    }

    fn impossible(&self, proof: Impossible, meters: &mut Meters) -> NoLeg {
        meters.find.charge_metered(proof.expanded);
        NoLeg::Impossible(proof)
    }

    fn gave_up(&self, report: GaveUp, meters: &mut Meters) -> NoLeg {
        meters.find.charge_metered(report.spent);
        NoLeg::GaveUp(report)
    }

    /// Converts a path to a leg, which is known to be exact only if no module switches twice.
    fn of_path(&self, path: &FlipPath, bound: u64) -> Best {
        let pulses: Vec<ModulePulse> = path.flips.iter().copied().map(single).collect();
        let tally = MotionTally::sum(self.field.lattice(), &pulses);
        let mut switched = [0, 0];
        let is_exact = pulses.iter().all(|pulse| {
            let is_first = switched[0] & pulse.left == 0 && switched[1] & pulse.right == 0;
            switched = [switched[0] | pulse.left, switched[1] | pulse.right];
            is_first
        });
        Best { tally, pulses, bound, is_exact }
    }

    /// Weights of the primary figure, and of the figure that breaks ties.
    fn weights(&self, rank: ObjectiveRank) -> [SwitchWeights; 2] {
        let lattice = self.field.lattice();
        let [distance, switches] = [SwitchWeights::distance(lattice), SwitchWeights::switches(lattice)];
        match rank {
            ObjectiveRank::Distance => [distance, switches],
            ObjectiveRank::Switches | ObjectiveRank::Pulses => [switches, distance],
        }
    }
}

fn ordered([first, second]: &[SwitchWeights; 2], rank: ObjectiveRank) -> SwitchWeights {
    first.then(second, bits(rank))
}

fn bits(rank: ObjectiveRank) -> u32 {
    match rank {
        ObjectiveRank::Distance => SWITCH_BITS,
        ObjectiveRank::Switches | ObjectiveRank::Pulses => DISTANCE_BITS,
    }
}

/// Whether no path that costs less in the first figure can overflow the bits of the second: a switch is at least one unit of
/// distance and at most 2^19.
fn is_exact(rank: ObjectiveRank, tally: MotionTally) -> bool {
    match rank {
        ObjectiveRank::Distance => tally.distance < 1 << SWITCH_BITS,
        ObjectiveRank::Switches | ObjectiveRank::Pulses => tally.switches <= MAX_SWITCHES,
    }
}

/// One module in a pulse of its own.
pub(super) fn single(flip: Flip) -> ModulePulse {
    let mask = 1 << flip.module;
    match flip.side {
        Side::Left => ModulePulse { left: mask, right: 0 },
        Side::Right => ModulePulse { left: 0, right: mask },
    }
}

fn flip(pulse: ModulePulse) -> Option<Flip> {
    match (pulse.left, pulse.right) {
        (left, 0) if left.is_power_of_two() => Some(Flip::of_bit(Side::Left, left)),
        (0, right) if right.is_power_of_two() => Some(Flip::of_bit(Side::Right, right)),
        _ => None,
    }
}
