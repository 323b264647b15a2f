//! The electrode array: a board of electrodes that moves many parts at once, each pulled by the electrodes ahead of
//! it.
//!
//! Facts, geometry and vocabulary of the kind. Source of the model: Kritikou, Lamprianidis, Aspragathos, *A modified
//! cooperative A\* algorithm for the simultaneous motion of multiple microparts on a "Smart Platform" with electrostatic fields*,
//! Micromachines 9, 2018. Its separation rule is corrected where its tables contradict one another (see the standard
//! library's file).

use crate::quantity::fraction;
use serde::{Deserialize, Serialize};
use std::sync::Arc;

#[cfg(test)]
pub(crate) mod fixture;
mod map;
mod reservoirs;
mod words;

pub use map::{ElectrodeMap, MAX_CHANNEL, MAX_SHARING};
pub use reservoirs::{DispenseFrame, DispenseSequence, MAX_DISPENSE_FRAMES, ReservoirPads};
pub use words::{
    BoardNoun, ElectrodeArrayMethod, ElectrodeArrayObjective, ElectrodeArrayOutcome, ElectrodeArrayVerb, VOCABULARY,
    ZoneSort,
};

/// Greatest number of columns, and of rows, of a board.
pub const MAX_SIDE: u32 = 1_000;

/// Greatest number of parts that are placed in one scene, and so are on the board together.
pub const MAX_PLACED_PARTS: usize = 1_000;

/// Greatest number of parts in one scene, with those that come later.
pub const MAX_PARTS: usize = 32_768;

/// Most parts that share a set of goals in one step.
pub const MAX_TEAM: usize = 400;

/// Most candidate places of one operation, of which the plan chooses one.
pub const MAX_PLACES: usize = 16;

/// Greatest number of obstacles in one scene.
pub const MAX_OBSTACLES: usize = 100_000;

/// Greatest number of zones of one sort in one scene.
pub const MAX_ZONES: usize = 1_000;

/// Greatest separation of parts, and clearance from obstacles, that a program may ask for, in electrodes.
pub const MAX_APART: u32 = 100;

/// Default columns and rows of the mixing loop.
pub const DEFAULT_MIXER: [u32; 2] = [2, 2];

/// Columns between the two droplets after a split: the electrodes on both sides of the droplet pull, its own is off.
pub const SPLIT_APART: u32 = 2;

/// Most steps of all stays of one assay together.
pub const MAX_STAY_STEPS: u64 = 32_000_000;

/// Most steps of the stays of one part in an assay.
pub const MAX_STAY_STEPS_OF_PART: u64 = 1_000_000;

/// Most steps of a planned assay, and most steps of all its droplets together: a schedule records each droplet in each
/// step, which takes up to 200 bytes per step and 12 per droplet.
pub const MAX_ASSAY_STEPS: u64 = 8_000_000;
pub const MAX_DROPLET_STEPS: u64 = 100_000_000;

/// An electrode, and so a position of a part's centre: column and row, both from 1, rows upward.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
pub struct ElectrodeCell {
    pub column: u32,
    pub row: u32,
}

impl ElectrodeCell {
    /// The cell (column, row).
    pub const fn new(column: u32, row: u32) -> Self {
        ElectrodeCell { column, row }
    }

    /// Column and row.
    pub const fn pair(self) -> [u32; 2] {
        [self.column, self.row]
    }

    /// Chebyshev distance: the larger of the differences of columns and of rows.
    pub const fn apart(self, other: ElectrodeCell) -> u32 {
        let (columns, rows) = (self.column.abs_diff(other.column), self.row.abs_diff(other.row));
        if columns > rows { columns } else { rows }
    }

    /// Manhattan distance: the number of steps between two cells without obstacles.
    pub const fn steps_to(self, other: ElectrodeCell) -> u32 {
        self.column.abs_diff(other.column) + self.row.abs_diff(other.row)
    }
}

impl std::fmt::Display for ElectrodeCell {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "({}, {})", self.column, self.row)
    }
}

/// Separation that the centres of two parts must keep.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Separation {
    /// This Chebyshev distance, in electrodes, between each part's start and end of a step and the other's: all four
    /// combinations.
    Apart(u32),
    /// Table 3 of the paper as printed, for reproduction; some of its entries let parts collide.
    AsPublished,
}

/// The separation that the verifier requires if a plan follows the paper's Table 3.
pub const PUBLISHED_SEPARATION: u32 = 4;

impl Separation {
    /// The Chebyshev distance in force, in electrodes.
    pub const fn apart(self) -> u32 {
        match self {
            Separation::Apart(cells) => cells,
            Separation::AsPublished => PUBLISHED_SEPARATION,
        }
    }
}

/// Arrangement of the electrodes of a part.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Electrodes {
    /// One, under the centre: a droplet.
    Single,
    /// Four, each one column and one row from the centre: the paper's micropart.
    Quad,
}

impl Electrodes {
    /// Columns and rows from the centre to each electrode.
    pub const fn offsets(self) -> &'static [[i64; 2]] {
        match self {
            Electrodes::Single => &[[0, 0]],
            Electrodes::Quad => &[[-1, -1], [1, -1], [-1, 1], [1, 1]],
        }
    }

    /// Number of columns or rows at each edge of the board that no centre can occupy.
    pub const fn rim(self) -> u32 {
        match self {
            Electrodes::Single => 0,
            Electrodes::Quad => 1,
        }
    }

    /// The least separation at which the electrodes that move one part do not pull another: an electrode attracts
    /// anything within one pitch of it, diagonals included, so the outermost electrodes of two parts must stay two
    /// pitches apart.
    pub const fn least_apart(self) -> u32 {
        2 * self.rim() + 2
    }
}

/// Footprint of a part.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Layout {
    pub electrodes: Electrodes,
    /// From the centre to the edge of the body along a column or a row, in pitches of the board.
    pub half_width_pitches: f64,
}

/// Whether the electrodes under a resting part are kept on.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Hold {
    /// A part rests without voltage; its electrodes are on only while it moves.
    Off,
    /// The electrodes that brought a part to its cell stay on while it rests there.
    On,
}

/// Facts of a device of this kind: the fields of its declaration.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct ElectrodeArrayFacts {
    /// 1 to [`MAX_SIDE`].
    pub columns: u32,
    /// 1 to [`MAX_SIDE`].
    pub rows: u32,
    pub radius_um: f64,
    /// Gap between the rims of two neighbouring electrodes over their radius: the paper's d1.
    pub pitch_ratio: f64,
    /// Potential of an electrode that is on.
    pub potential_v: f64,
    /// Duration of one move to a neighbouring cell, settling included.
    pub step_ns: u64,
    pub layout: Layout,
    pub hold: Hold,
    /// Time in which a reservoir dispenses one droplet; `None` if the device does not state it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub dispense_ns: Option<u64>,
    /// Columns and rows of the mixing loop, each at least 2.
    #[serde(default = "default_mixer", skip_serializing_if = "is_default_mixer")]
    pub mixer: [u32; 2],
    /// Least and greatest volume of a droplet that can be moved, in units of a dispensed droplet; `None` if not
    /// known.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub least_volume: Option<f64>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub most_volume: Option<f64>,
    /// Lowest and highest temperature of its heaters; `None` if not known.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub least_temperature_k: Option<f64>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub most_temperature_k: Option<f64>,
    pub separation: Separation,
    /// The least Chebyshev distance from a part's centre to an electrode that an obstacle covers, in electrodes; at least 1.
    pub clearance: u32,
    /// `None` if every place has a working electrode that needs no channel number.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub map: Option<Arc<ElectrodeMap>>,
    /// `None` if it is not known how the reservoirs dispense.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub reservoirs: Option<Arc<ReservoirPads>>,
}

fn default_mixer() -> [u32; 2] {
    DEFAULT_MIXER
}

fn is_default_mixer(mixer: &[u32; 2]) -> bool {
    *mixer == DEFAULT_MIXER
}

impl ElectrodeArrayFacts {
    /// Distance between neighbouring electrodes: (2 + d1) r (section 3 of the paper).
    pub fn pitch_um(&self) -> f64 {
        (2.0 + self.pitch_ratio) * self.radius_um
    }

    /// Whether the place is on the board; it may lack an electrode.
    pub fn is_on_board(&self, cell: ElectrodeCell) -> bool {
        (1..=self.columns).contains(&cell.column) && (1..=self.rows).contains(&cell.row)
    }

    /// Whether there is an electrode at a place of the board.
    pub fn has_electrode(&self, cell: ElectrodeCell) -> bool {
        self.is_on_board(cell) && self.map.as_ref().is_none_or(|map| map.has_electrode(cell))
    }

    /// Whether an electrode does not work.
    pub fn is_disabled(&self, cell: ElectrodeCell) -> bool {
        self.map.as_ref().is_some_and(|map| map.has_electrode(cell) && !map.works(cell))
    }

    /// Whether a part's centre can be there: inside the rim that its electrodes need and, for a droplet, over a
    /// working electrode. Boards of microparts have all their electrodes.
    pub fn reaches(&self, cell: ElectrodeCell) -> bool {
        let rim = self.layout.electrodes.rim();
        self.is_on_board(cell)
            && self.map.as_ref().is_none_or(|map| map.works(cell))
            && (1 + rim..=self.columns.saturating_sub(rim)).contains(&cell.column)
            && (1 + rim..=self.rows.saturating_sub(rim)).contains(&cell.row)
    }

    /// The first and the last cell that a part's centre can occupy, if there is any.
    pub fn reach(&self) -> Option<[ElectrodeCell; 2]> {
        let rim = self.layout.electrodes.rim();
        let first = ElectrodeCell::new(1 + rim, 1 + rim);
        let last = ElectrodeCell::new(self.columns.saturating_sub(rim), self.rows.saturating_sub(rim));
        (first.column <= last.column && first.row <= last.row).then_some([first, last])
    }

    /// The mixing loop whose corner with the least column and row is `corner`: along the row first, then upward, and
    /// back. Cells may lie off the board.
    pub fn mixing_loop(&self, corner: ElectrodeCell) -> Vec<ElectrodeCell> {
        let [columns, rows] = self.mixer.map(|side| side - 1);
        let ElectrodeCell { column, row } = corner;
        let east = (0..columns).map(|along| ElectrodeCell::new(column + along, row));
        let north = (0..rows).map(|up| ElectrodeCell::new(column + columns, row + up));
        let west = (0..columns).map(|back| ElectrodeCell::new(column + columns - back, row + rows));
        let south = (0..rows).map(|down| ElectrodeCell::new(column, row + rows - down));
        east.chain(north).chain(west).chain(south).collect()
    }

    /// Steps of mixing for at least a time: whole rounds of the loop, since the droplet must end where it began.
    pub fn mixing_steps(&self, time_ns: u64) -> u64 {
        let round = u64::from(2 * (self.mixer[0] + self.mixer[1]) - 4);
        time_ns.div_ceil(self.step_ns).div_ceil(round).saturating_mul(round)
    }

    /// The name of an electrode's channel, without the device's name. A shared channel is named after its first
    /// electrode.
    pub fn channel(cell: ElectrodeCell) -> String {
        format!("e{}_{}", cell.column, cell.row)
    }

    /// The electrodes that share a channel with one, itself included, row by row from row 1.
    pub fn on_channel_of(&self, cell: ElectrodeCell) -> Vec<ElectrodeCell> {
        self.map.as_ref().map_or_else(|| vec![cell], |map| map.on_channel_of(cell))
    }

    /// The working electrodes that share a channel with one, itself included.
    pub fn working_on_channel_of(&self, cell: ElectrodeCell) -> Vec<ElectrodeCell> {
        self.on_channel_of(cell).into_iter().filter(|cell| !self.is_disabled(*cell)).collect()
    }

    /// The first of the electrodes that share a channel with one, row by row from row 1; it gives the channel its
    /// name.
    pub fn first_on_channel_of(&self, cell: ElectrodeCell) -> ElectrodeCell {
        self.map.as_ref().map_or(cell, |map| map.first_on_channel_of(cell))
    }

    /// The name of a pad's channel, without the device's name.
    pub fn pad_channel(pad: u32) -> String {
        format!("pad{pad}")
    }

    /// The pad whose channel has this name, without the device's name; `None` if no reservoir of the board has such a
    /// pad.
    pub fn pad(&self, channel: &str) -> Option<u32> {
        let pad: u32 = channel.strip_prefix("pad")?.parse().ok()?;
        let is_own =
            self.reservoirs.as_ref()?.pads().contains(&pad) && ElectrodeArrayFacts::pad_channel(pad) == channel;
        is_own.then_some(pad)
    }

    /// Time in which the reservoir at an outlet dispenses a droplet; `None` if not known.
    pub fn dispense_ns_at(&self, outlet: ElectrodeCell) -> Option<u64> {
        let own = self.reservoirs.as_ref().and_then(|pads| Some(pads.duration_ns(pads.at(outlet)?)));
        own.or(self.dispense_ns)
    }

    /// The electrode that gives a channel its name, by that name without the device's; `None` if the board has no
    /// such channel.
    pub fn electrode(&self, channel: &str) -> Option<ElectrodeCell> {
        let cell = self.named_electrode(channel)?;
        (self.first_on_channel_of(cell) == cell).then_some(cell)
    }

    /// The electrode with this name, whether or not a channel is named after it.
    pub fn named_electrode(&self, channel: &str) -> Option<ElectrodeCell> {
        let (column, row) = channel.strip_prefix('e')?.split_once('_')?;
        let cell = ElectrodeCell::new(column.parse().ok()?, row.parse().ok()?);
        (self.has_electrode(cell) && ElectrodeArrayFacts::channel(cell) == channel).then_some(cell)
    }
}

/// A volume in words: `2 droplets`, `1/4 droplet`.
pub fn droplets(volume: f64) -> String {
    let plural = if volume > 1.0 { "s" } else { "" };
    format!("{} droplet{plural}", fraction(volume))
}
