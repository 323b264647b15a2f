//! Controllers of stages, and what stages can follow.

use super::Start;
use crate::device::words::words;
use serde::{Deserialize, Serialize};

words! {
    /// How a controller of stages is spoken to.
    pub enum StageProtocol {
        Gcs = "gcs": "PI: its General Command Set over TCP/IP or a serial line, a wave table for each axis",
        Mcs2 = "mcs2": "SmarAct: an MCS2 by the maker's package, a stream of places",
    }
}

words! {
    /// Which way a stage counts.
    pub enum Direction {
        Forward = "forward": "as the channel",
        Backward = "backward": "against the channel: the stage is mounted the other way round",
    }
}

impl Direction {
    /// 1, or -1 for a stage that counts against its channel.
    pub fn sign(self) -> f64 {
        match self {
            Direction::Forward => 1.0,
            Direction::Backward => -1.0,
        }
    }
}

/// The rates at which an MCS2 takes the places of a stream, in hertz: the range of its property `STREAM_BASE_RATE`.
const STREAM_RATES_HZ: std::ops::RangeInclusive<f64> = 10.0..=1000.0;

impl StageProtocol {
    /// What its rates are, in words, if one is none of these.
    pub fn refuses_rate(self, rate_hz: f64) -> Option<&'static str> {
        match self {
            StageProtocol::Gcs => None,
            StageProtocol::Mcs2 => {
                let is_taken = STREAM_RATES_HZ.contains(&rate_hz) && rate_hz.fract() == 0.0;
                (!is_taken).then_some("whole hertz from 10 Hz to 1 kHz")
            }
        }
    }
}

/// A controller of stages.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct StageControllerFacts {
    pub protocol: StageProtocol,
    /// At most [`super::MAX_OUTPUTS`].
    pub axes: u32,
    /// Points in a second, in hertz.
    pub rate_hz: f64,
    /// Points of the table of an axis; `None` for one that is sent while it is played.
    pub most_points: Option<u32>,
    pub start: Start,
}

/// What a stage can follow. What is not known is not held.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct StageLimits {
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub speed_um_per_s: Option<f64>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub acceleration_um_per_s2: Option<f64>,
}

impl StageLimits {
    /// Whether nothing is known.
    pub fn is_empty(&self) -> bool {
        *self == StageLimits::default()
    }

    /// How far a stage is off its way at most where the speed changes at once, in micrometres. It changes its speed evenly, in the time
    /// `t = change / acceleration` around the corner, and is `change * t / 8` off at the corner itself.
    pub fn rounding_um(&self, change_um_per_s: f64) -> f64 {
        self.acceleration_um_per_s2.map_or(0.0, |most| change_um_per_s * change_um_per_s / (8.0 * most))
    }
}

/// How far a way that runs straight from point to point is off one with a corner between two points, at most, in micrometres: the
/// corner lies in the middle, `change * period / 4` beside the straight line.
pub fn cut_um(change_um_per_s: f64, period_s: f64) -> f64 {
    change_um_per_s * period_s / 4.0
}
