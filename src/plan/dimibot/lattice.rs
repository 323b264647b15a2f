//! The cells a DiMiBot reaches, the flips between them, and the cost of a flip.
//!
//! The left modules move along x, the right ones along y (frame R1 of the paper); module `i` moves 2^i pitches of its axis.

use crate::real::Real;

pub use crate::device::dimibot::{Flip, LatticeCell, MAX_MODULES, MAX_REACH_UM, Side};

/// The lattice of reachable positions.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Lattice {
    /// Number of modules: left (x) and right (y), 1 to [`MAX_MODULES`] each.
    pub modules: [u32; 2],
    /// Pitch in µm between neighbouring cells, along x and along y. Cell (0, 0) lies at the origin.
    pub pitch_um: [f64; 2],
}

/// Why a lattice is rejected.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LatticeError {
    /// The number of modules of that side is not in 1..=[`MAX_MODULES`].
    Modules(Side),
    /// The pitch of that side is not positive, not finite, or spans more than [`MAX_REACH_UM`].
    Pitch(Side),
}

impl Lattice {
    /// A lattice from its numbers of modules and pitches (µm), left before right.
    ///
    /// # Errors
    /// See [`LatticeError`].
    pub fn new(modules: [u32; 2], pitch_um: [f64; 2]) -> Result<Self, LatticeError> {
        for side in Side::BOTH {
            let (n, pitch) = (modules[side.index()], pitch_um[side.index()]);
            if !(1..=MAX_MODULES).contains(&n) {
                return Err(LatticeError::Modules(side));
            }
            let reach = pitch * f64::from(1_u32 << n);
            if !(pitch > 0.0 && reach <= MAX_REACH_UM) {
                return Err(LatticeError::Pitch(side));
            }
        }
        Ok(Lattice { modules, pitch_um })
    }

    /// The lattice of a DiMiBot whose modules stroke by `stroke_um` with transmission `gain`: pitch = gain·stroke·√2 / 2^(N−1)
    /// (Eq. 2 and 6 of Chalvet, Haddab and Lutz 2016).
    ///
    /// # Errors
    /// See [`LatticeError`].
    pub fn of_strokes(modules: [u32; 2], gain: f64, stroke_um: f64) -> Result<Self, LatticeError> {
        let full = 2.0 * gain * stroke_um * std::f64::consts::SQRT_2;
        Lattice::new(modules, modules.map(|n| full / 2_f64.whole_power(n.min(64) as i32)))
    }

    /// Largest coordinate of that side's axis, 2^N − 1.
    pub const fn last(&self, side: Side) -> u32 {
        (1 << self.modules[side.index()]) - 1
    }

    /// Whether the cell belongs to the lattice.
    pub const fn contains(&self, cell: LatticeCell) -> bool {
        cell.x <= self.last(Side::Left) && cell.y <= self.last(Side::Right)
    }

    /// Position of a cell in µm.
    pub fn position_um(&self, cell: LatticeCell) -> [f64; 2] {
        [f64::from(cell.x) * self.pitch_um[0], f64::from(cell.y) * self.pitch_um[1]]
    }
}

/// Modules that switch together, as bit masks.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ModulePulse {
    /// Left modules.
    pub left: u32,
    /// Right modules.
    pub right: u32,
}

/// Cost of switching each module, in integer units of the objective.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct SwitchWeights {
    pub(crate) of: [[u64; MAX_MODULES as usize]; 2],
    pub(crate) modules: [u32; 2],
}

impl SwitchWeights {
    /// Distance travelled by the end-effector, in units of the finer pitch: 2^i, times 2^(difference of modules) on the coarser axis.
    pub fn distance(lattice: &Lattice) -> Self {
        let [left, right] = lattice.modules;
        let finest = left.max(right);
        SwitchWeights::from_fn(lattice, |side, i| 1 << (i + finest - lattice.modules[side.index()]))
    }

    /// Number of switches; time and energy of one-at-a-time switching are multiples of it.
    pub fn switches(lattice: &Lattice) -> Self {
        SwitchWeights::from_fn(lattice, |_, _| 1)
    }

    /// Lexicographic order of two measures: `second`, which must stay below 2^`bits` on a path, decides between paths of equal cost
    /// in the first.
    pub(crate) fn then(&self, second: &SwitchWeights, bits: u32) -> Self {
        let mut of = self.of;
        for (first, second) in of.iter_mut().flatten().zip(second.of.iter().flatten()) {
            *first = *first << bits | second;
        }
        SwitchWeights { of, modules: self.modules }
    }

    fn from_fn(lattice: &Lattice, weight: impl Fn(Side, u32) -> u64) -> Self {
        let mut of = [[0; MAX_MODULES as usize]; 2];
        for side in Side::BOTH {
            for i in 0..lattice.modules[side.index()] {
                of[side.index()][i as usize] = weight(side, i);
            }
        }
        let modules = lattice.modules;
        SwitchWeights { of, modules }
    }

    /// Cost of one flip; 0 for a module that the robot does not have.
    pub fn of(&self, flip: Flip) -> u64 {
        let of = self.of[flip.side.index()];
        of.get(usize::from(flip.module)).copied().unwrap_or(0)
    }

    /// Least cost between two cells without obstacles: every module whose state differs switches once.
    pub fn between(&self, a: LatticeCell, b: LatticeCell) -> u64 {
        self.of_masks([a.x ^ b.x, a.y ^ b.y])
    }

    /// The weights of the modules above the `fine` lowest of each side.
    pub(crate) fn without(&self, fine: [u32; 2]) -> Self {
        let mut of = [[0; MAX_MODULES as usize]; 2];
        for k in 0..2 {
            let kept = &self.of[k][fine[k] as usize..];
            of[k][..kept.len()].copy_from_slice(kept);
        }
        let modules = [self.modules[0] - fine[0], self.modules[1] - fine[1]];
        SwitchWeights { of, modules }
    }

    pub(crate) fn of_masks(&self, masks: [u32; 2]) -> u64 {
        let sum = |k: usize| bits(masks[k]).map(move |b| self.of[k][b.trailing_zeros() as usize]);
        sum(0).chain(sum(1)).sum()
    }
}

/// The set bits of a mask, each as a mask of its own, lowest first.
pub(crate) fn bits(mut mask: u32) -> impl Iterator<Item = u32> {
    std::iter::from_fn(move || {
        let bit = mask & mask.wrapping_neg();
        mask ^= bit;
        (bit != 0).then_some(bit)
    })
}
