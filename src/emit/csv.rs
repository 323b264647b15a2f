//! CSV: one row per change, one column per channel, and four columns for a channel with drive trains.
//!
//! The first column is the time in nanoseconds. The voltages of a row hold until the next row. Positions (columns in
//! um) run in a straight line to the next row, so `numpy.interp(t, time, x)` is the position of a stage. The last row
//! is the end of the schedule. A column header is the channel's name with its unit, followed by ` @ ` and its wire:
//! `bot.bl4.set [V] @ Dev1/port0/line8`.
//!
//! A drive train is one row. Its channel has the columns `fleet.bed.first [V]`, `fleet.bed.second [V]`,
//! `fleet.bed.period [ns]` and `fleet.bed.start [ns]`: from `start` on, half of each period is at the first level and
//! half at the second, until the next row. Where the period is 0 there is no train, and both levels are the voltage.
//!
//! Numbers are the shortest that read back as the same `f64`. `pandas.read_csv(path)` and `numpy.loadtxt(path,
//! delimiter=",", skiprows=1)` read the file as it is.

use super::error::{EmitError, MAX_TEXT_BYTES};
use super::signal::Drive;
use super::{Format, Signals};
use crate::diagnostic::plain::is_unprintable;
use crate::schedule::{Channel, ChannelUnit};

/// Estimated bytes of a voltage, with its comma.
const VOLTAGE_BYTES: u64 = 4;

/// Estimated bytes of the numbers of a train.
const TRAIN_BYTES: u64 = 28;

/// Estimated bytes of a position.
const POSITION_BYTES: u64 = 20;

/// The bytes of the file.
///
/// # Errors
/// [`EmitError::Ramp`] for a voltage that is not constant, [`EmitError::Jump`] for a position that jumps,
/// [`EmitError::TooLarge`] past [`MAX_TEXT_BYTES`].
pub(super) fn write(signals: &Signals) -> Result<Vec<u8>, EmitError> {
    EmitError::refuse_ramps(Format::Csv, signals)?;
    EmitError::refuse_jumps(Format::Csv, signals)?;
    let schedule = signals.schedule;
    let channels = schedule.channels.len();
    let bytes_of_values: u64 = (0..channels).map(|channel| value_bytes(signals, channel)).sum();
    let row_bytes = digits(schedule.duration_ns) + 1 + bytes_of_values;
    let bytes = (times(signals).count() as u64).saturating_mul(row_bytes);
    EmitError::refuse_size(Format::Csv, bytes, MAX_TEXT_BYTES)?;

    let mut writer = ::csv::Writer::from_writer(Vec::new());
    let failed = |error: ::csv::Error| EmitError::Failed { format: Format::Csv, detail: error.to_string() };
    let header =
        std::iter::once("time [ns]".to_owned()).chain((0..channels).flat_map(|channel| header(signals, channel)));
    writer.write_record(header).map_err(failed)?;
    for t_ns in times(signals) {
        let numbers = (0..channels).flat_map(|channel| values(signals, channel, t_ns));
        writer.write_record(std::iter::once(t_ns.to_string()).chain(numbers)).map_err(failed)?;
    }
    writer.into_inner().map_err(|error| EmitError::Failed { format: Format::Csv, detail: error.to_string() })
}

/// The instants of the rows: starts and ends of all actuations, and both ends of the schedule.
fn times(signals: &Signals) -> impl Iterator<Item = u64> {
    let duration_ns = signals.schedule.duration_ns;
    let breaks = signals.breaks(0..signals.schedule.channels.len()).into_iter();
    let inner = breaks.filter(move |t_ns| *t_ns > 0 && *t_ns < duration_ns);
    let end = Some(duration_ns).filter(|end_ns| *end_ns > 0);
    std::iter::once(0).chain(inner).chain(end)
}

fn value_bytes(signals: &Signals, channel: usize) -> u64 {
    match signals.unit(channel) {
        ChannelUnit::Volt if signals.has_trains(channel) => TRAIN_BYTES,
        ChannelUnit::Volt => VOLTAGE_BYTES,
        ChannelUnit::Micrometre => POSITION_BYTES,
    }
}

/// The numbers of a channel in a row, one per column.
fn values(signals: &Signals, channel: usize, t_ns: u64) -> Vec<String> {
    match signals.has_trains(channel) {
        true => {
            let Drive { levels: [first, second], period_ns, start_ns } = signals.drive(channel, t_ns);
            vec![first.to_string(), second.to_string(), period_ns.to_string(), start_ns.to_string()]
        }
        false => vec![signals.value(channel, t_ns).to_string()],
    }
}

/// Number of decimal digits.
pub(super) fn digits(number: u64) -> u64 {
    u64::from(number.checked_ilog10().unwrap_or(0)) + 1
}

/// The headers of a channel's columns.
fn header(signals: &Signals, channel: usize) -> Vec<String> {
    let Channel { name, unit, wire, .. } = &signals.schedule.channels[channel];
    let unit = unit.symbol();
    let wire = wire.as_ref().map_or_else(String::new, |wire| format!(" @ {}", one_line(wire)));
    match signals.has_trains(channel) {
        true => vec![
            format!("{name}.first [{unit}]{wire}"),
            format!("{name}.second [{unit}]{wire}"),
            format!("{name}.period [ns]"),
            format!("{name}.start [ns]"),
        ],
        false => vec![format!("{name} [{unit}]{wire}")],
    }
}

/// The text without line ends and control characters, which would break line-based readers.
pub(super) fn one_line(text: &str) -> String {
    text.chars().map(|c| if is_unprintable(c) { ' ' } else { c }).collect()
}
