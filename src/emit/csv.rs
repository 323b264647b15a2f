//! CSV: one row for each change, one column for each channel.
//!
//! The first column is the time in nanoseconds. A row's voltages hold until the next row; positions, whose columns are in um, run in
//! a straight line to the next row, so that `numpy.interp(t, time, x)` is where a stage is. The last row is the end of the
//! schedule. A column's header is the channel's name with its unit, and behind ` @ ` its wire: `bot.bl4.set [V] @ Dev1/port0/line8`.
//! Numbers are the shortest that read back as the same `f64`, so that `pandas.read_csv(path)` and
//! `numpy.loadtxt(path, delimiter=",", skiprows=1)` take the file as it is.

use super::error::{EmitError, MAX_TEXT_BYTES};
use super::{Format, Signals};
use crate::diagnostic::plain::commands;
use crate::schedule::{Channel, ChannelUnit};

/// Estimated bytes of a voltage, with its comma.
const VOLTAGE_BYTES: u64 = 4;

/// Estimated bytes of a position.
const POSITION_BYTES: u64 = 20;

/// The bytes of the file.
///
/// # Errors
/// [`EmitError::Ramp`] for a voltage that is not constant, [`EmitError::Leap`] for a position that jumps,
/// [`EmitError::TooLarge`] past [`MAX_TEXT_BYTES`].
pub(super) fn write(signals: &Signals) -> Result<Vec<u8>, EmitError> {
    EmitError::refuse_ramps(Format::Csv, signals)?;
    EmitError::refuse_leaps(Format::Csv, signals)?;
    let schedule = signals.schedule;
    let channels = schedule.channels.len();
    let values: u64 = schedule.channels.iter().map(value_bytes).sum();
    let row_bytes = digits(schedule.duration_ns) + 1 + values;
    let bytes = signals.count_edges(0..channels).saturating_mul(row_bytes);
    EmitError::refuse_size(Format::Csv, bytes, MAX_TEXT_BYTES)?;

    let mut writer = ::csv::Writer::from_writer(Vec::new());
    let failed = |error: ::csv::Error| EmitError::Failed { format: Format::Csv, detail: error.to_string() };
    let header = std::iter::once("time [ns]".to_owned()).chain(schedule.channels.iter().map(header));
    writer.write_record(header).map_err(failed)?;
    for t_ns in times(signals) {
        let values = (0..channels).map(|channel| signals.value(channel, t_ns).to_string());
        writer.write_record(std::iter::once(t_ns.to_string()).chain(values)).map_err(failed)?;
    }
    writer.into_inner().map_err(|error| EmitError::Failed { format: Format::Csv, detail: error.to_string() })
}

/// The instants of the rows: every edge, and both ends.
fn times(signals: &Signals) -> impl Iterator<Item = u64> {
    let duration_ns = signals.schedule.duration_ns;
    let edges = signals.edges(0..signals.schedule.channels.len());
    let inner = edges.filter(move |t_ns| *t_ns > 0 && *t_ns < duration_ns);
    let end = Some(duration_ns).filter(|end_ns| *end_ns > 0);
    std::iter::once(0).chain(inner).chain(end)
}

fn value_bytes(channel: &Channel) -> u64 {
    match channel.unit {
        ChannelUnit::Volt => VOLTAGE_BYTES,
        ChannelUnit::Micrometre => POSITION_BYTES,
    }
}

/// Number of digits of a number.
pub(super) fn digits(number: u64) -> u64 {
    u64::from(number.checked_ilog10().unwrap_or(0)) + 1
}

fn header(channel: &Channel) -> String {
    let Channel { name, unit, wire, .. } = channel;
    match wire {
        Some(wire) => format!("{name} [{}] @ {}", unit.symbol(), one_line(wire)),
        None => format!("{name} [{}]", unit.symbol()),
    }
}

/// The text without line ends and control characters, which readers of lines would trip over.
pub(super) fn one_line(text: &str) -> String {
    text.chars().map(|c| if commands(c) { ' ' } else { c }).collect()
}
