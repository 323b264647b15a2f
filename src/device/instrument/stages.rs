//! Stage controllers, and the limits of stages.

use super::Start;
use crate::device::words::words;
use serde::{Deserialize, Serialize};

words! {
    /// Protocol of a stage controller.
    pub enum StageProtocol {
        Gcs = "gcs": "PI: its General Command Set over TCP/IP or a serial line, a wave table for each axis",
        Mcs2 = "mcs2": "SmarAct: an MCS2 with the maker's package, a stream of positions",
    }
}

words! {
    /// Counting direction of a stage.
    pub enum Direction {
        Forward = "forward": "as the channel",
        Backward = "backward": "against the channel: the stage is mounted the other way round",
    }
}

impl Direction {
    /// 1, or -1 for a stage that counts in the opposite direction to its channel.
    pub fn sign(self) -> f64 {
        match self {
            Direction::Forward => 1.0,
            Direction::Backward => -1.0,
        }
    }
}

/// Rates at which an MCS2 accepts the points of a stream, in hertz: the range of its property `STREAM_BASE_RATE`.
const STREAM_RATES_HZ: std::ops::RangeInclusive<f64> = 10.0..=1000.0;

impl StageProtocol {
    /// Description of the accepted rates if `rate_hz` is not one of them; `None` if it is accepted.
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

/// A stage controller.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct StageControllerFacts {
    pub protocol: StageProtocol,
    /// At most [`super::MAX_OUTPUTS`].
    pub axes: u32,
    /// Points per second.
    pub rate_hz: f64,
    /// Most points in the table of an axis; `None` if points are streamed during play.
    pub most_points: Option<u32>,
    pub start: Start,
}

/// Limits of a stage. A limit that is not known is not checked.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct StageLimits {
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub speed_um_per_s: Option<f64>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub acceleration_um_per_s2: Option<f64>,
}

impl StageLimits {
    /// Whether no limit is known.
    pub fn is_empty(&self) -> bool {
        *self == StageLimits::default()
    }

    /// Greatest deviation of a stage from its path where the commanded speed jumps, in micrometres. The stage changes
    /// its speed uniformly, in the time `t = change / acceleration` centred on the corner, and is `change * t / 8`
    /// off at the corner.
    pub fn corner_rounding_um(&self, change_um_per_s: f64) -> f64 {
        self.acceleration_um_per_s2.map_or(0.0, |most| change_um_per_s * change_um_per_s / (8.0 * most))
    }
}

/// Greatest deviation of a path sampled at points, straight between them, from one with a corner between two points,
/// in micrometres: with the corner in the middle, it is `change * period / 4` off the straight line.
pub fn corner_cut_um(change_um_per_s: f64, period_s: f64) -> f64 {
    change_um_per_s * period_s / 4.0
}
