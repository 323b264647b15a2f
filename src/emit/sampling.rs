//! Sample period of the outputs.
//!
//! Edges of voltages fall on samples, so voltages are exact. Positions are sampled often enough for their speed; where
//! an instrument is too slow or its memory too small, no stage moves by more than the tolerance of its device between
//! samples.

use super::signal::half_ns;
use super::wired::WiredInstrument;
use super::{EmitError, Signals, hold_parts};
use crate::claims::Claims;
use crate::device::instrument::QUOTIENT_ROOM;
use crate::schedule::{Actuation, ChannelUnit, common_divisor_ns};

/// Greatest move of a stage from one sample to the next, in micrometres, if the instrument is fast enough, its memory
/// suffices and the tolerance of its device is not smaller.
pub const SAMPLE_UM: f64 = 0.05;

/// Largest divisor by which the common period of voltages is subdivided for positions.
const MAX_DIVISOR: u64 = 100_000;

/// Sampling limits of an instrument.
pub struct SampleLimits {
    /// Least and greatest number of points.
    pub points: [u64; 2],
    /// Greatest sample rate.
    pub rate_hz: f64,
    /// Longest acceptable period, if any.
    pub most_ns: Option<u64>,
}

/// Sampling of all channels, before values are scaled.
pub struct Sampling {
    pub period_ns: u64,
    /// Number of points with the ones before and after the schedule; a sequence repeats some of them.
    pub points: u64,
}

impl Sampling {
    /// The sampling of what an instrument plays.
    ///
    /// # Errors
    /// [`EmitError::TooFine`], [`EmitError::CoarseStages`].
    pub fn new(
        signals: &Signals,
        wired: &WiredInstrument,
        claims: &Claims,
        limits: &SampleLimits,
    ) -> Result<Sampling, EmitError> {
        let duration_ns = signals.schedule.duration_ns;
        let common_ns = common_ns(signals);
        let by_rate_ns = ((1e9 / limits.rate_hz).ceil() as u64).max(1);
        let [least_points, most_points] = limits.points;
        let by_memory_ns = duration_ns.div_ceil(most_points.saturating_sub(2).max(1));
        let period_ns = match steady_ns(signals, claims) {
            None => {
                let exact_ns = common_divisor_ns(duration_ns, common_ns);
                // After the last edge nothing changes, so the end may be a little later.
                let whole_ns = if exact_ns < by_rate_ns { common_ns.max(exact_ns) } else { exact_ns }.max(1);
                limits.most_ns.map_or(whole_ns, |most_ns| divisor_period_ns(whole_ns, most_ns, by_rate_ns))
            }
            Some(steady_ns) => {
                let wanted_ns = limits.most_ns.map_or(steady_ns, |most_ns| steady_ns.min(most_ns));
                let least_ns = by_memory_ns.max(by_rate_ns);
                match common_ns {
                    0 => wanted_ns.clamp(1, duration_ns.max(1)).max(least_ns),
                    common_ns => divisor_period_ns(common_ns, wanted_ns, least_ns),
                }
            }
        };
        if common_ns > 0 && period_ns as f64 * limits.rate_hz < 1e9 / QUOTIENT_ROOM {
            let (instrument, rate_hz) = (wired.name.to_owned(), limits.rate_hz);
            return Err(EmitError::TooFine { instrument, period_ns, rate_hz });
        }
        let sampling = Sampling { period_ns, points: (duration_ns.div_ceil(period_ns) + 2).max(least_points) };
        sampling.keeps_tolerance(signals, wired, claims, by_memory_ns > by_rate_ns)?;
        Ok(sampling)
    }

    /// An error if a stage moves by more than the tolerance of its device from one sample to the next.
    fn keeps_tolerance(
        &self,
        signals: &Signals,
        wired: &WiredInstrument,
        claims: &Claims,
        is_by_memory: bool,
    ) -> Result<(), EmitError> {
        for index in signals.in_unit(ChannelUnit::Micrometre) {
            let channel = &signals.schedule.channels[index];
            let Some(tolerance_um) = claims.tolerance_um(&channel.device) else { continue };
            let step_um = um_per_ns(signals, index) * self.period_ns as f64;
            if step_um > tolerance_um * QUOTIENT_ROOM {
                return Err(EmitError::CoarseStages {
                    instrument: wired.name.to_owned(),
                    channel: channel.name.clone(),
                    um: [step_um, tolerance_um],
                    period_ns: self.period_ns,
                    is_by_memory,
                });
            }
        }
        Ok(())
    }

    /// Positions of a stage at the samples, in micrometres; the first sample, before the start, repeats the initial
    /// position.
    pub fn positions(&self, signals: &Signals, channel: usize) -> impl Iterator<Item = f64> {
        let at = move |index: u64| (index.saturating_sub(1) * self.period_ns).min(signals.schedule.duration_ns);
        (0..self.points).map(move |index| signals.value(channel, at(index)))
    }

    /// Greatest move of a stage in a period, in micrometres; `None` without stages.
    pub fn step_um(&self, signals: &Signals) -> Option<f64> {
        let fastest = signals.in_unit(ChannelUnit::Micrometre).map(|index| um_per_ns(signals, index)).reduce(f64::max);
        let step_um = fastest? * self.period_ns as f64;
        // Rounded up, except for the rounding error of the product.
        Some(((step_um * 1e4 - 1e-6).ceil() / 1e4).abs())
    }
}

/// Greatest common divisor of all times of voltages, and of the cuts at waits; 0 without voltages.
fn common_ns(signals: &Signals) -> u64 {
    let of_volts = signals.in_unit(ChannelUnit::Volt).flat_map(|channel| signals.away_from_rest(channel));
    let of_volts: Vec<Actuation> = of_volts.collect();
    let times = of_volts.iter().flat_map(|actuation| [actuation.start_ns, actuation.end_ns()]);
    let halves = of_volts.iter().filter_map(|actuation| actuation.swing).map(half_ns);
    let cuts = hold_parts::cuts_ns(signals.schedule).filter(|_| !of_volts.is_empty());
    times.chain(halves).chain(cuts).fold(0, common_divisor_ns)
}

/// The greatest round period in which no stage moves by more than [`SAMPLE_UM`], or the tolerance of its device if that
/// is less; `None` without stages.
fn steady_ns(signals: &Signals, claims: &Claims) -> Option<u64> {
    let of_stage = |index: usize| {
        let tolerance_um = claims.tolerance_um(&signals.schedule.channels[index].device);
        tolerance_um.map_or(SAMPLE_UM, |tolerance_um| tolerance_um.min(SAMPLE_UM)) / um_per_ns(signals, index)
    };
    let exact_ns = signals.in_unit(ChannelUnit::Micrometre).map(of_stage).reduce(f64::min)?;
    let mut decade_ns = 1;
    while 10.0 * decade_ns as f64 <= exact_ns && decade_ns < signals.schedule.duration_ns {
        decade_ns *= 10;
    }
    let round_ns = [5, 2, 1].map(|digit| digit * decade_ns);
    round_ns.into_iter().find(|period_ns| *period_ns as f64 <= exact_ns).or(Some(1))
}

/// Greatest speed of a stage.
fn um_per_ns(signals: &Signals, channel: usize) -> f64 {
    let speed = |actuation: &&Actuation| (actuation.to - actuation.from).abs() / actuation.duration_ns as f64;
    signals.of(channel).iter().map(speed).fold(0.0, f64::max)
}

/// A period divided by a whole number: the longest result that is at most `wanted_ns`, or else the shortest found that
/// is at least `least_ns`.
fn divisor_period_ns(whole_ns: u64, wanted_ns: u64, least_ns: u64) -> u64 {
    let parts = (1..=whole_ns.min(MAX_DIVISOR)).filter(|parts| whole_ns.is_multiple_of(*parts));
    let mut found_ns = whole_ns;
    for part_ns in parts.map(|parts| whole_ns / parts).take_while(|part_ns| *part_ns >= least_ns) {
        found_ns = part_ns;
        if part_ns <= wanted_ns {
            break;
        }
    }
    found_ns
}
