//! The DiMiBot: a planar microrobot whose bistable modules add up binary displacements.
//!
//! Facts, kinematics and vocabulary of the kind. Source of the model: Chalvet, Haddab, Lutz, *Trajectory planning for
//! micromanipulation with a nonredundant digital microrobot*, J. Mechanisms and Robotics 8(2), 2016. Doc comments say
//! where an error of that text is corrected.

use crate::geometry::PlaneAxis;
use crate::geometry::fault::{Fault, inject};
use crate::real::Real;
use nalgebra::{DMatrix, DVector, Rotation2, Vector2};
use serde::{Deserialize, Serialize};

mod words;

pub use words::{DimibotMethod, DimibotObjective, DimibotOutcome, DimibotVerb, PLANNERS, Simultaneous, VOCABULARY};

pub use super::MAX_REACH_UM;

/// Most modules on one side: a word has a digit for each module of both sides.
pub const MAX_MODULES: u32 = super::MAX_WORD_DIGITS / 2;

/// Greatest number of places in one `visit`.
pub const MAX_VISITS: usize = 64;

/// The states of all modules: bit i of `x` is module `bl<i>`, bit j of `y` is module `br<j>`.
///
/// Read as numbers, `x` and `y` are the position on the lattice, counted from word 0 along the axes of the paper's
/// frame R1.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Default, Serialize, Deserialize)]
pub struct LatticeCell {
    pub x: u32,
    pub y: u32,
}

impl LatticeCell {
    /// The cell (x, y).
    pub const fn new(x: u32, y: u32) -> Self {
        LatticeCell { x, y }
    }

    /// Its two indices.
    pub const fn pair(self) -> [u32; 2] {
        [self.x, self.y]
    }

    /// The cell after one module has switched.
    pub const fn after(self, flip: Flip) -> Self {
        // A module that no robot has changes nothing.
        let bit = if (flip.module as u32) < MAX_MODULES { 1 << flip.module } else { 0 };
        match flip.side {
            Side::Left => LatticeCell::new(self.x ^ bit, self.y),
            Side::Right => LatticeCell::new(self.x, self.y ^ bit),
        }
    }
}

/// The switching of one module.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Flip {
    pub side: Side,
    /// Index on its side, from 0; module i moves the end-effector by 2^i cells.
    pub module: u8,
}

impl Flip {
    /// The switching of the module whose bit is set in a one-bit mask.
    pub const fn of_bit(side: Side, bit: u32) -> Self {
        Flip { side, module: bit.trailing_zeros() as u8 }
    }
}

impl std::fmt::Display for LatticeCell {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "({}, {})", self.x, self.y)
    }
}

/// The side of the robot that a module is on.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Side {
    /// `bl`, moves the end-effector along x.
    Left,
    /// `br`, moves the end-effector along y.
    Right,
}

impl Side {
    /// Both sides, in coordinate order.
    pub const BOTH: [Side; 2] = [Side::Left, Side::Right];

    /// 0 for left, 1 for right: the index of the side's coordinate.
    pub const fn index(self) -> usize {
        match self {
            Side::Left => 0,
            Side::Right => 1,
        }
    }

    /// The axis along which its modules move the end-effector.
    pub const fn axis(self) -> PlaneAxis {
        match self {
            Side::Left => PlaneAxis::X,
            Side::Right => PlaneAxis::Y,
        }
    }

    /// The other side.
    pub const fn other(self) -> Side {
        match self {
            Side::Left => Side::Right,
            Side::Right => Side::Left,
        }
    }
}

/// Facts of a device of this kind: the fields of its declaration.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct DimibotFacts {
    /// Modules on the left, 1 to [`MAX_MODULES`].
    pub left: u32,
    /// Modules on the right, 1 to [`MAX_MODULES`].
    pub right: u32,
    /// Displacement Δ of a module between its two states.
    pub stroke_um: f64,
    /// The constant K of the flexure structure, without a unit.
    pub gain: f64,
    pub pulse_voltage_v: f64,
    pub pulse_current_a: f64,
    pub pulse_duration_ns: u64,
    /// Time after each pulse during which no module may be switched.
    pub rest_ns: u64,
    /// Greatest distance of the end-effector from its nominal position, in micrometres.
    pub repeatability_um: f64,
    /// Radius of the tip that reaches down to the working plane.
    pub tip_radius_um: f64,
    pub home: LatticeCell,
    pub simultaneous: Simultaneous,
}

impl DimibotFacts {
    /// Number of modules on one side.
    pub fn modules(&self, side: Side) -> u32 {
        match side {
            Side::Left => self.left,
            Side::Right => self.right,
        }
    }

    /// Distance between neighbouring cells along the axis of a side: K·Δ·√2 / 2^(n-1) (equations 2 and 6 of the paper).
    pub fn pitch_um(&self, side: Side) -> f64 {
        let widest_um = self.gain * self.stroke_um * std::f64::consts::SQRT_2;
        inject(Fault::Pitch, widest_um / 2f64.whole_power(self.modules(side) as i32 - 1))
    }

    /// Number of cells along the axis of a side: 2^n.
    pub fn cells(&self, side: Side) -> u32 {
        1 << self.modules(side)
    }

    /// Nominal position of the end-effector in a cell, in the frame R1 from word 0.
    pub fn place_um(&self, cell: LatticeCell) -> [f64; 2] {
        [f64::from(cell.x) * self.pitch_um(Side::Left), f64::from(cell.y) * self.pitch_um(Side::Right)]
    }

    /// Indices of the cell nearest to a position, as whole numbers, not limited to the workspace: the inverse
    /// kinematics of equations 3 and 8, which leave the range test to the reader.
    pub fn nearest_indices(&self, place_um: [f64; 2]) -> [f64; 2] {
        [(place_um[0] / self.pitch_um(Side::Left)).round(), (place_um[1] / self.pitch_um(Side::Right)).round()]
    }

    /// The cell nearest to a position; `None` outside of the workspace.
    pub fn nearest_cell(&self, place_um: [f64; 2]) -> Option<LatticeCell> {
        let [x, y] = self.nearest_indices(place_um);
        let inside =
            x >= 0.0 && y >= 0.0 && x < f64::from(self.cells(Side::Left)) && y < f64::from(self.cells(Side::Right));
        inside.then_some(LatticeCell { x: x as u32, y: y as u32 })
    }

    /// The cell of the workspace nearest to any finite position.
    pub fn clamped_cell(&self, place_um: [f64; 2]) -> LatticeCell {
        self.clamped_cell_of(self.nearest_indices(place_um))
    }

    /// The cell of the workspace nearest to two indices.
    pub fn clamped_cell_of(&self, [x, y]: [f64; 2]) -> LatticeCell {
        let clamp = |value: f64, side| value.clamp(0.0, f64::from(self.cells(side) - 1)) as u32;
        LatticeCell { x: clamp(x, Side::Left), y: clamp(y, Side::Right) }
    }

    /// The word of a cell as a number: bl in the high bits, br in the low ones.
    pub fn word(&self, cell: LatticeCell) -> u64 {
        (u64::from(cell.x) << self.right) | u64::from(cell.y)
    }

    /// The cell of a word.
    pub fn cell(&self, word: u64) -> LatticeCell {
        LatticeCell { x: (word >> self.right) as u32, y: (word & ((1 << self.right) - 1)) as u32 }
    }

    /// The word of a cell as the language writes it: `0b10001_00010`.
    pub fn word_text(&self, cell: LatticeCell) -> String {
        format!("0b{:0left$b}_{:0right$b}", cell.x, cell.y, left = self.left as usize, right = self.right as usize)
    }

    /// Displacement of the end-effector in the robot's own frame R0, in micrometres: equation 7 of the paper, or
    /// equation 1 if both sides have the same number of modules.
    ///
    /// A module at depth d below the top one moves the end-effector by K·Δ/2^d along each axis of R0; a right module
    /// moves it in the opposite direction along x.
    pub fn displacement_um(&self, cell: LatticeCell) -> Vector2<f64> {
        let (left, right) = (self.left as usize, self.right as usize);
        let depth = |column: usize| if column < left { column } else { column - left };
        let matrix = DMatrix::from_fn(2, left + right, |row, column| {
            let size = 0.5f64.whole_power(depth(column) as i32);
            if row == 0 && column >= left { -size } else { size }
        });
        let bits = DVector::from_fn(left + right, |row, _| {
            let bit = if row < left { cell.x >> (left - 1 - row) } else { cell.y >> (left + right - 1 - row) };
            f64::from(bit & 1)
        });
        let sum = matrix * bits * (self.gain * self.stroke_um);
        Vector2::new(sum[0], sum[1])
    }

    /// The rotation from the robot's frame R0 to the workspace frame R1: 45 degrees.
    pub fn workspace_frame() -> Rotation2<f64> {
        Rotation2::new(-std::f64::consts::FRAC_PI_4)
    }

    /// The names of all channels, without the device's name: the left side from the top module down, then the right
    /// side.
    pub fn channels(&self) -> Vec<String> {
        let modules = |side| (0..self.modules(side)).rev().map(move |module| (side, module));
        let both = modules(Side::Left).chain(modules(Side::Right));
        both.flat_map(|(side, module)| {
            [Switch::Set, Switch::Reset].map(|switch| DimibotFacts::channel(side, module, switch))
        })
        .collect()
    }

    /// Energy of switching one module: voltage times current times duration.
    pub fn switch_energy_j(&self) -> f64 {
        self.pulse_voltage_v * self.pulse_current_a * self.pulse_duration_ns as f64 / 1e9
    }

    /// Distance by which obstacles are grown: tip radius plus repeatability.
    pub fn growth_um(&self) -> f64 {
        inject(Fault::Growth, self.tip_radius_um + self.repeatability_um)
    }

    /// The name of the channel that sets or resets a module, without the device's name.
    pub fn channel(side: Side, module: u32, value: Switch) -> String {
        let side = match side {
            Side::Left => "bl",
            Side::Right => "br",
        };
        let value = match value {
            Switch::Set => "set",
            Switch::Reset => "reset",
        };
        format!("{side}{module}.{value}")
    }
}

/// Switching direction; each module has one thermal actuator for each direction.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Switch {
    /// To state 1.
    Set,
    /// To state 0.
    Reset,
}

#[cfg(test)]
pub(crate) mod tests;
