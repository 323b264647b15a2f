//! Checks a schedule against the sampling of its instruments: clock and resolution.
//!
//! The lines and outputs of one card share a clock in the sender, so the slowest of them limits all. Levels are
//! rounded to the resolution of an output; if a device states the margin of its voltages, or the tolerance of its
//! stages, the rounding is checked against that.

use super::wired_channel::WiredChannel;
use crate::claims::Claims;
use crate::device::instrument::{Drive, Instrument, InstrumentFacts, OutputSort, QUOTIENT_ROOM, VoltageOutput};
use crate::diagnostic::{Code, Diagnostic};
use crate::quantity::{Dimension, Quantity, significant};
use crate::schedule::{Actuation, ChannelUnit, common_divisor_ns};
use std::collections::BTreeMap;

/// Voltages are rounded by at most 1/N of the device's margin: little compared with what the margin is for.
const MARGIN_SHARE: f64 = 10.0;

/// The voltages of one instrument and their sampling.
struct SampledVoltages<'a> {
    actuations: Vec<(&'a WiredChannel<'a>, Actuation)>,
    /// The lowest sample rate of the outputs that are used, with its drive.
    rate_hz: f64,
    slowest: &'a Drive,
}

/// For each instrument, compares the longest sample period on which every edge of its voltages falls with the
/// instrument's clock.
pub fn finer_than_a_sample(wired: &[WiredChannel]) -> Vec<Diagnostic> {
    let mut common: BTreeMap<&str, SampledVoltages> = BTreeMap::new();
    for wired in wired.iter().filter(|wired| !wired.actuations.is_empty()) {
        let drive = wired.drive;
        let Some(rate_hz) = rate_hz(drive, wired.instrument) else { continue };
        let none = SampledVoltages { actuations: Vec::new(), rate_hz, slowest: drive };
        let entry = common.entry(&drive.instrument).or_insert(none);
        if rate_hz < entry.rate_hz {
            (entry.rate_hz, entry.slowest) = (rate_hz, drive);
        }
        if wired.channel.unit == ChannelUnit::Volt {
            entry.actuations.extend(wired.away_from_rest().into_iter().map(|actuation| (wired, actuation)));
        }
    }
    common.into_values().filter_map(finer).collect()
}

fn finer(voltages: SampledVoltages) -> Option<Diagnostic> {
    let SampledVoltages { mut actuations, rate_hz, slowest } = voltages;
    actuations.sort_by_key(|(wired, actuation)| (actuation.start_ns, wired.index));
    let mut period_ns = 0;
    let mut first = None;
    for (wired, actuation) in &actuations {
        let half_ns = actuation.swing.map_or(0, |swing| swing.period_ns / 2);
        let times = [actuation.start_ns, actuation.duration_ns, half_ns];
        period_ns = times.into_iter().fold(period_ns, common_divisor_ns);
        if (period_ns as f64) * rate_hz < 1e9 / QUOTIENT_ROOM {
            first = first.or(Some((wired.drive, &wired.schedule.steps[actuation.step as usize])));
        }
    }
    let (drive, step) = first?;
    let [least, period] = [1.0 / rate_hz, period_ns as f64 / 1e9].map(|s| Quantity::new(s, Dimension::TIME));
    let rate = Quantity::new(rate_hz, Dimension::FREQUENCY);
    let title = format!("the edges are on multiples of {period}, but `{}` samples every {least}", drive.instrument);
    let finding = Diagnostic::new(Code::E0623, title).label(slowest.span, format!("at most {rate}"));
    let finding = match drive.span == slowest.span {
        true => finding,
        false => finding.label(drive.span, "on the same clock"),
    };
    let finding = finding.label_elsewhere(step.span, drive.span, "the times of this step need this resolution");
    Some(finding.help(format!("choose pulse durations, rests and waits as multiples of {least} or of a longer time")))
}

/// The highest sample rate of an output, in hertz; `None` if it has no clock.
fn rate_hz(drive: &Drive, instrument: &Instrument) -> Option<f64> {
    let sort = instrument.facts.output(&drive.output)?;
    match (&instrument.facts, sort) {
        (InstrumentFacts::DataAcquisition(facts), OutputSort::Digital) => {
            Some(facts.digital_rate_hz).filter(|rate_hz| *rate_hz > 0.0)
        }
        (facts, _) => Some(facts.voltage()?.rate_hz),
    }
}

/// A channel whose output rounds its values by more than the device tolerates.
pub fn coarser_than_its_use(wired: &WiredChannel, claims: &Claims) -> Option<Diagnostic> {
    let &WiredChannel { channel, drive, instrument, .. } = wired;
    let voltage = instrument.facts.voltage()?;
    if instrument.facts.output(&drive.output) != Some(OutputSort::Voltage) {
        return None;
    }
    let of = wired.actuations.iter().flat_map(|actuation| actuation.levels());
    let at_output = |value| drive.link.at_output(value);
    let (rounded_v, borne, figure) = match channel.unit {
        ChannelUnit::Volt => {
            let borne_v = claims.margin_v(&channel.device)? / MARGIN_SHARE;
            let values: Vec<f64> = of.chain([channel.rest_v]).map(at_output).collect();
            let codes = OutputCodes::new(instrument, voltage, &values)?;
            let most_v = values.iter().map(|value| codes.rounds_by(*value)).fold(0.0, f64::max);
            (most_v, borne_v, "a tenth of its `margin`")
        }
        ChannelUnit::Micrometre => {
            let borne_um = claims.tolerance_um(&channel.device)? / 2.0;
            let values: Vec<f64> = of.map(at_output).collect();
            // A stage passes through all values between two, so the worst rounding is half a step.
            let most_v = OutputCodes::new(instrument, voltage, &values)?.step_v / 2.0;
            (most_v, borne_um, "half of its `tolerance`")
        }
    };
    let rounded = (drive.link.value(rounded_v) - drive.link.value(0.0)).abs();
    if rounded <= borne * QUOTIENT_ROOM {
        return None;
    }
    let title = format!(
        "`{}` is rounded by up to {}; its device tolerates {}, {figure}",
        channel.name,
        wired.shown(significant(rounded, 3)),
        wired.shown(significant(borne, 3)),
    );
    let help = match channel.unit {
        ChannelUnit::Volt => "use an output with more bits",
        ChannelUnit::Micrometre => "use an output with more bits, or a stage with more volts per micrometre",
    };
    Some(Diagnostic::new(Code::E0625, title).label(drive.span, format!("{} bits", voltage.bits)).help(help))
}

/// The voltages that an output can give: the codes of a generator span the voltages that it plays, those of a card
/// its whole range.
struct OutputCodes {
    middle_v: f64,
    step_v: f64,
}

impl OutputCodes {
    /// The codes of an output that plays these voltages; `None` for an output without codes, or with a constant
    /// voltage.
    fn new(instrument: &Instrument, voltage: VoltageOutput, played_v: &[f64]) -> Option<OutputCodes> {
        let least_v = played_v.iter().copied().reduce(f64::min)?;
        let most_v = played_v.iter().copied().reduce(f64::max)?;
        let codes = f64::from(2_u32.saturating_pow(voltage.bits));
        let (middle_v, step_v) = match &instrument.facts {
            InstrumentFacts::WaveformGenerator(_) => {
                (f64::midpoint(least_v, most_v), (most_v - least_v) / (codes - 2.0))
            }
            InstrumentFacts::DataAcquisition(_) => (0.0, 2.0 * voltage.peak_v / codes),
            InstrumentFacts::ElectrodeDriver(_)
            | InstrumentFacts::StageController(_)
            | InstrumentFacts::MachineController(_) => return None,
        };
        (step_v > 0.0).then_some(OutputCodes { middle_v, step_v })
    }

    /// Distance of a voltage from the nearest one that the output can give.
    fn rounds_by(&self, played_v: f64) -> f64 {
        let codes = (played_v - self.middle_v) / self.step_v;
        (codes - codes.round()).abs() * self.step_v
    }
}
