//! The DiMiBot: a planar microrobot whose bistable modules add up binary displacements.
//!
//! Facts, kinematics and vocabulary of the kind. Source of the model: Chalvet, Haddab, Lutz, *Trajectory planning for
//! micromanipulation with a nonredundant digital microrobot*, J. Mechanisms and Robotics 8(2), 2016, with the slips of that
//! text put right where the doc comments say so.

use super::{
    Choice, Count, Field, Need, Noun, Outcome, Phrase, Planner, Range, Sort, Together, Verb, Vocabulary, shape::Form,
};
use crate::geometry::Axis;
use crate::geometry::fault::{Fault, through};
use crate::quantity::Dimension;
use crate::real::Real;
use nalgebra::{DMatrix, DVector, Rotation2, Vector2};
use serde::{Deserialize, Serialize};

/// The most modules that one side may have.
pub const MAX_MODULES: u32 = 20;

/// The widest workspace, in micrometres: within it the rounding of a double stays far below the margins of planning.
pub const MAX_REACH_UM: f64 = 1e5;

/// The most places that one `visit` may name.
pub const MAX_VISITS: usize = 64;

/// The state of all modules of one side each: bit i of `x` is module `bl<i>`, bit j of `y` is module `br<j>`.
///
/// Read as numbers they are the place on the lattice, counted from word 0 along the axes of the paper's frame R1.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Default, Serialize, Deserialize)]
pub struct Cell {
    pub x: u32,
    pub y: u32,
}

impl Cell {
    /// The cell (x, y).
    pub const fn new(x: u32, y: u32) -> Self {
        Cell { x, y }
    }

    /// Its two numbers.
    pub const fn pair(self) -> [u32; 2] {
        [self.x, self.y]
    }

    /// The cell after one module has switched.
    pub const fn after(self, flip: Flip) -> Self {
        // A module that no robot has moves nothing.
        let bit = if (flip.module as u32) < MAX_MODULES { 1 << flip.module } else { 0 };
        match flip.side {
            Side::Left => Cell::new(self.x ^ bit, self.y),
            Side::Right => Cell::new(self.x, self.y ^ bit),
        }
    }
}

/// One module switches.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Flip {
    pub side: Side,
    /// Counted from 0 on its side; module i moves the end-effector by 2^i cells.
    pub module: u8,
}

impl Flip {
    /// The module of a mask with one bit.
    pub const fn of_bit(side: Side, bit: u32) -> Self {
        Flip { side, module: bit.trailing_zeros() as u8 }
    }
}

impl std::fmt::Display for Cell {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "({}, {})", self.x, self.y)
    }
}

/// Which of the two sides a module stands on.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Side {
    /// `bl`, moves the end-effector along x.
    Left,
    /// `br`, moves the end-effector along y.
    Right,
}

impl Side {
    /// Both sides, in the order of coordinates.
    pub const BOTH: [Side; 2] = [Side::Left, Side::Right];

    /// 0 for left, 1 for right: the index of the side's coordinate.
    pub const fn index(self) -> usize {
        match self {
            Side::Left => 0,
            Side::Right => 1,
        }
    }

    /// The direction in which its modules move the end-effector.
    pub const fn axis(self) -> Axis {
        match self {
            Side::Left => Axis::X,
            Side::Right => Axis::Y,
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

/// Whether several modules may be switched in one pulse.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Simultaneous {
    /// One module at a time, as in the paper.
    #[default]
    Never,
    /// Several, where no order of their switching and no mixture of partial strokes touches an obstacle.
    Safe,
}

/// What a device of this kind is: the fields of its declaration.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Facts {
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
    /// Time after each pulse in which no module is switched.
    pub rest_ns: u64,
    /// How far the end-effector may stand from its nominal place.
    pub repeatability_um: f64,
    /// Radius of the tip that goes down to the working plane.
    pub tip_radius_um: f64,
    pub home: Cell,
    pub simultaneous: Simultaneous,
}

impl Facts {
    /// Modules of one side.
    pub fn modules(&self, side: Side) -> u32 {
        match side {
            Side::Left => self.left,
            Side::Right => self.right,
        }
    }

    /// Distance between neighbouring cells along the axis of a side: K·Δ·√2 / 2^(n-1) (equations 2 and 6 of the paper).
    pub fn pitch_um(&self, side: Side) -> f64 {
        let widest_um = self.gain * self.stroke_um * std::f64::consts::SQRT_2;
        through(Fault::Pitch, widest_um / 2f64.whole_power(self.modules(side) as i32 - 1))
    }

    /// Cells along the axis of a side: 2^n.
    pub fn cells(&self, side: Side) -> u32 {
        1 << self.modules(side)
    }

    /// Whether a cell exists.
    pub fn holds(&self, cell: Cell) -> bool {
        cell.x < self.cells(Side::Left) && cell.y < self.cells(Side::Right)
    }

    /// Nominal place of the end-effector in a cell, in the frame R1 from word 0.
    pub fn place_um(&self, cell: Cell) -> [f64; 2] {
        [f64::from(cell.x) * self.pitch_um(Side::Left), f64::from(cell.y) * self.pitch_um(Side::Right)]
    }

    /// The cell nearest to a place, whether or not it exists: the inverse kinematics of equations 3 and 8, which leave the
    /// test of the range to the reader. The numbers are whole.
    pub fn nearest_indices(&self, place_um: [f64; 2]) -> [f64; 2] {
        [(place_um[0] / self.pitch_um(Side::Left)).round(), (place_um[1] / self.pitch_um(Side::Right)).round()]
    }

    /// The cell nearest to a place, if it lies in the workspace.
    pub fn nearest_cell(&self, place_um: [f64; 2]) -> Option<Cell> {
        let [x, y] = self.nearest_indices(place_um);
        let inside =
            x >= 0.0 && y >= 0.0 && x < f64::from(self.cells(Side::Left)) && y < f64::from(self.cells(Side::Right));
        inside.then_some(Cell { x: x as u32, y: y as u32 })
    }

    /// The nearest cell that exists, for any finite place.
    pub fn clamped_cell(&self, place_um: [f64; 2]) -> Cell {
        self.clamped_cell_of(self.nearest_indices(place_um))
    }

    /// The cell that exists nearest to two indices.
    pub fn clamped_cell_of(&self, [x, y]: [f64; 2]) -> Cell {
        let clamp = |value: f64, side| value.clamp(0.0, f64::from(self.cells(side) - 1)) as u32;
        Cell { x: clamp(x, Side::Left), y: clamp(y, Side::Right) }
    }

    /// The word of a cell as a number: bl in the high bits, br in the low ones.
    pub fn word(&self, cell: Cell) -> u64 {
        (u64::from(cell.x) << self.right) | u64::from(cell.y)
    }

    /// The cell of a word.
    pub fn cell(&self, word: u64) -> Cell {
        Cell { x: (word >> self.right) as u32, y: (word & ((1 << self.right) - 1)) as u32 }
    }

    /// The word of a cell as the language writes it: `0b10001_00010`.
    pub fn word_text(&self, cell: Cell) -> String {
        format!("0b{:0left$b}_{:0right$b}", cell.x, cell.y, left = self.left as usize, right = self.right as usize)
    }

    /// Displacement of the end-effector in the robot's own frame R0, in micrometres: equation 7 of the paper, and equation 1 where
    /// both sides have as many modules.
    ///
    /// A module at depth d below the top one moves the end-effector by K·Δ/2^d along each axis of R0; a right module moves
    /// it the other way along x.
    pub fn displacement_um(&self, cell: Cell) -> Vector2<f64> {
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

    /// The names of all channels, without the device's: the left side from the top module down, then the right side.
    pub fn channels(&self) -> Vec<String> {
        let modules = |side| (0..self.modules(side)).rev().map(move |module| (side, module));
        let both = modules(Side::Left).chain(modules(Side::Right));
        both.flat_map(|(side, module)| [Switch::Set, Switch::Reset].map(|switch| Facts::channel(side, module, switch)))
            .collect()
    }

    /// Energy of switching one module: voltage times current times duration.
    pub fn switch_energy_j(&self) -> f64 {
        self.pulse_voltage_v * self.pulse_current_a * self.pulse_duration_ns as f64 / 1e9
    }

    /// By how much an obstacle is grown: tip radius and repeatability.
    pub fn growth_um(&self) -> f64 {
        through(Fault::Growth, self.tip_radius_um + self.repeatability_um)
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

/// What an actuator of a module does; each module has one thermal actuator for either direction.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Switch {
    /// To state 1.
    Set,
    /// To state 0.
    Reset,
}

const fn quantity(name: &'static str, dimension: Dimension, range: Range, doc: &'static str) -> Field {
    Field { name, sort: Sort::Quantity { dimension, range }, need: Need::Required, doc }
}

const fn count(name: &'static str, doc: &'static str) -> Field {
    Field { name, sort: Sort::Count { least: 1, most: MAX_MODULES }, need: Need::Required, doc }
}

const SIMULTANEOUS: [Choice; 2] = [
    Choice { name: "never", doc: "one module at a time" },
    Choice { name: "safe", doc: "several in one pulse where no order and no partial stroke touches an obstacle" },
];

const FIELDS: &[Field] = &[
    count("left", "modules on the left (bl), each moving the end-effector along x"),
    count("right", "modules on the right (br), each moving the end-effector along y"),
    quantity("stroke", Dimension::LENGTH, Range::Positive, "displacement of a module between its two states"),
    quantity(
        "gain",
        Dimension::NUMBER,
        Range::Positive,
        "end-effector displacement per stroke, a constant of the flexure structure",
    ),
    quantity("pulse_voltage", Dimension::VOLTAGE, Range::Positive, "voltage of a switching pulse"),
    quantity("pulse_current", Dimension::CURRENT, Range::Positive, "current of a switching pulse"),
    quantity(
        "pulse_duration",
        Dimension::TIME,
        Range::Positive,
        "length of a switching pulse; the module snaps at some instant in it",
    ),
    quantity("rest", Dimension::TIME, Range::NotNegative, "time after each pulse in which no module is switched"),
    quantity(
        "repeatability",
        Dimension::LENGTH,
        Range::NotNegative,
        "how far the end-effector may stand from its nominal place",
    ),
    quantity("tip_radius", Dimension::LENGTH, Range::NotNegative, "radius of the tip in the working plane"),
    Field {
        name: "home",
        sort: Sort::State,
        need: Need::Optional("all modules at 0"),
        doc: "where the robot stands before the first task",
    },
    Field {
        name: "simultaneous",
        sort: Sort::Word(&SIMULTANEOUS),
        need: Need::Optional("never"),
        doc: "whether several modules may be switched in one pulse",
    },
];

const SETTINGS: &[Field] = &[
    Field {
        name: "precision",
        sort: Sort::Quantity { dimension: Dimension::LENGTH, range: Range::Positive },
        need: Need::Optional("any place in the workspace takes its nearest cell"),
        doc: "how far the cell taken for a place may lie from it",
    },
    Field {
        name: "simultaneous",
        sort: Sort::Word(&SIMULTANEOUS),
        need: Need::Optional("as the device says"),
        doc: "whether several modules may be switched in one pulse",
    },
];

const VERBS: &[Verb] = &[
    Verb {
        name: "move",
        noun: None,
        object: None,
        phrases: &[
            Phrase { preposition: "to", sort: Sort::Target, count: Count::Once },
            Phrase { preposition: "via", sort: Sort::Target, count: Count::AnyNumber },
        ],
        block: None,
        doc: "carries the end-effector to a cell or a place, by way of others in the order of writing",
        example: "move to (3.2 um, 5.9 um) via (3, 9)",
    },
    Verb {
        name: "visit",
        noun: None,
        object: Some(Sort::Targets),
        phrases: &[],
        block: None,
        doc: "carries the end-effector to each of these cells and places, in the best order, and ends at the last one",
        example: "visit [(3, 9), (12, 4), (3.2 um, 5.9 um)]",
    },
];

const BUDGET: [Field; 1] =
    [super::expansions("20 million", "how many states the search may expand before it gives up")];

const fn planner(name: &'static str, doc: &'static str) -> Planner {
    Planner { name, options: &BUDGET, doc }
}

/// The names of the planners, as `using` takes them and reports show them.
pub const PLANNERS: &[Planner] = &[
    planner(
        "staged_astar",
        "Tweeze's own: a greedy walk; where it is blocked, A* with the exact distance of the free lattice, then A* led by distances between blocks of cells",
    ),
    planner("dijkstra", "the paper's section 4.2"),
    planner("bidirectional_dijkstra", "the paper's section 4.2, from both ends"),
    planner("astar", "the paper's section 4.3: A* with the distance in the frame R1"),
    planner("hypercube_astar", "the paper's section 5: A* with the estimate of its algorithm 3"),
];

/// The words of the kind.
pub const VOCABULARY: Vocabulary = Vocabulary {
    name: "dimibot",
    summary: "a planar microrobot of bistable modules that switch one by one",
    library: ("std.dimibot", "dimibot.femto_st"),
    fields: FIELDS,
    nouns: &[Noun {
        name: "obstacle",
        doc: "what the tip must not touch; without a shape a point",
        shapes: Form::SOLID,
    }],
    settings: SETTINGS,
    state: Some(Sort::State),
    together: Together::No,
    verbs: VERBS,
    objectives: &[
        Choice { name: "distance", doc: "the way of the end-effector" },
        Choice { name: "switches", doc: "how often a module is switched" },
        Choice { name: "time", doc: "how long it takes" },
        Choice { name: "energy", doc: "what the pulses cost" },
    ],
    planners: PLANNERS,
    outcomes: &[
        Outcome { name: "distance", dimension: Dimension::LENGTH, doc: "the way of the end-effector" },
        Outcome { name: "switches", dimension: Dimension::NUMBER, doc: "how often a module is switched" },
        Outcome {
            name: "time",
            dimension: Dimension::TIME,
            doc: "from the beginning of the task to the end of its last rest",
        },
        Outcome {
            name: "energy",
            dimension: Dimension::ENERGY,
            doc: "voltage times current times time, over all pulses",
        },
    ],
    channels: "<device>.bl<i>.set, <device>.bl<i>.reset, and br likewise: the voltage on the actuator that brings the module to 1 or to 0",
};

#[cfg(test)]
pub(crate) mod tests;
