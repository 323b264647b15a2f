//! Distance, switches and pulses of a motion, which determine all its outcomes; the order of two motions.
//!
//! Time and energy of a DiMiBot follow from the numbers of pulses and switches, so three whole numbers determine all outcomes. Ties
//! in the objective are broken by the other outcomes in the order of the vocabulary: distance, switches, time, energy.

use super::lattice::{Lattice, ModulePulse, Side};
use crate::claims::dimibot::DimibotObjective;

/// The figures of a motion.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct MotionTally {
    /// Distance of the end-effector in units of the finer pitch.
    pub distance: u64,
    /// Number of module switches.
    pub switches: u64,
    /// Number of pulses; equal to `switches` where one module is switched at a time.
    pub pulses: u64,
}

impl MotionTally {
    /// Upper bound on every motion.
    pub const MAX: MotionTally = MotionTally { distance: u64::MAX, switches: u64::MAX, pulses: u64::MAX };

    /// The figures of one pulse.
    pub fn of(lattice: &Lattice, pulse: ModulePulse) -> Self {
        let finest = lattice.modules[0].max(lattice.modules[1]);
        let way = |mask: u32, side: Side| u64::from(mask) << (finest - lattice.modules[side.index()]);
        MotionTally {
            distance: way(pulse.left, Side::Left) + way(pulse.right, Side::Right),
            switches: u64::from(pulse.left.count_ones() + pulse.right.count_ones()),
            pulses: 1,
        }
    }

    /// The figures of a sequence of pulses.
    pub fn sum(lattice: &Lattice, pulses: &[ModulePulse]) -> Self {
        pulses.iter().fold(MotionTally::default(), |sum, pulse| sum.plus(MotionTally::of(lattice, *pulse)))
    }

    /// The sum of two motions; saturates.
    #[must_use]
    pub const fn plus(self, other: MotionTally) -> Self {
        MotionTally {
            distance: self.distance.saturating_add(other.distance),
            switches: self.switches.saturating_add(other.switches),
            pulses: self.pulses.saturating_add(other.pulses),
        }
    }

    /// The remainder of a limit; `None` if it is exceeded.
    pub const fn minus(self, other: MotionTally) -> Option<Self> {
        if !other.is_within(self) {
            return None;
        }
        Some(MotionTally {
            distance: self.distance - other.distance,
            switches: self.switches - other.switches,
            pulses: self.pulses - other.pulses,
        })
    }

    /// Whether every figure is at most its limit.
    pub const fn is_within(self, limit: MotionTally) -> bool {
        self.distance <= limit.distance && self.switches <= limit.switches && self.pulses <= limit.pulses
    }

    /// The smaller of the two in each figure.
    #[must_use]
    pub fn least(self, other: MotionTally) -> Self {
        MotionTally {
            distance: self.distance.min(other.distance),
            switches: self.switches.min(other.switches),
            pulses: self.pulses.min(other.pulses),
        }
    }

    /// Sort key of motions, most important figure first.
    pub const fn key(self, objective: DimibotObjective) -> [u64; 3] {
        match objective {
            DimibotObjective::Distance => [self.distance, self.switches, self.pulses],
            // Energy is a multiple of the switches.
            DimibotObjective::Switches | DimibotObjective::Energy => [self.switches, self.distance, self.pulses],
            DimibotObjective::Time => [self.pulses, self.distance, self.switches],
        }
    }

    /// The figure that is minimised.
    pub const fn of_objective(self, objective: DimibotObjective) -> u64 {
        self.key(objective)[0]
    }

    /// A tally of which only the minimised figure is known.
    pub const fn only(objective: DimibotObjective, figure: u64) -> Self {
        let none = MotionTally { distance: 0, switches: 0, pulses: 0 };
        match objective {
            DimibotObjective::Distance => MotionTally { distance: figure, ..none },
            DimibotObjective::Switches | DimibotObjective::Energy => MotionTally { switches: figure, ..none },
            DimibotObjective::Time => MotionTally { pulses: figure, ..none },
        }
    }
}

/// Adds a tally with its item to a Pareto front; `false` if the front dominates it.
pub fn add_to_front<T>(front: &mut Vec<(MotionTally, T)>, tally: MotionTally, item: T) -> bool {
    if front.iter().any(|(known, _)| known.is_within(tally)) {
        return false;
    }
    front.retain(|(known, _)| !tally.is_within(*known));
    front.push((tally, item));
    true
}
