//! Reasons why a format cannot represent a schedule.

use super::{Format, Signals};
use crate::device::instrument::Family;
use crate::diagnostic::{Code, Diagnostic};
use crate::quantity::{Dimension, Quantity, significant};

/// The largest text file that is written, in bytes; it is built in memory, and its readers load it whole.
pub const MAX_TEXT_BYTES: u64 = 1 << 28;

/// Reason why a schedule cannot be written in a format.
#[derive(Debug, Clone, PartialEq)]
pub enum EmitError {
    /// A voltage, a position or another figure is infinite or NaN.
    NotFinite,
    /// A voltage ramps, and the format represents constant voltages only.
    Ramp { format: Format, channel: String, start_ns: u64, from: f64, to: f64 },
    /// The file would be larger than its readers accept.
    TooLarge { format: Format, bytes: u64, limit: u64 },
    /// The instrument's memory is too small for the schedule at its sample period. For a sequence, which repeats
    /// points, the limit is that memory or the greatest number of steps in a sequence.
    TooManyPoints {
        instrument: String,
        points: u64,
        limit: u64,
        period_ns: u64,
        duration_ns: u64,
        most_steps: Option<u64>,
    },
    /// More frames than the program that comes with the driver loads.
    TooManyFrames { instrument: String, frames: u64, limit: u64, period_ns: u64 },
    /// The wave table of a stage controller is too short for the schedule at the widest point spacing that the
    /// tolerance of the hand allows.
    TooLongForTable { instrument: String, points: u64, limit: u64, period_ns: f64 },
    /// Electrodes are wired to drivers, but none of them uses the format.
    OtherProtocol { format: Format, name: String },
    /// Edges, or cuts at waits, fall between the samples of an instrument.
    TooFine { instrument: String, period_ns: u64, rate_hz: f64 },
    /// A stage moves by more than the tolerance of its device from one sample to the next, because the memory of the
    /// instrument is too small or its clock too slow. `um` has the move and the tolerance.
    CoarseStages { instrument: String, channel: String, um: [f64; 2], period_ns: u64, is_by_memory: bool },
    /// Digital lines of a card that has no sample clock for them.
    NoSampleClock { instrument: String },
    /// No channel is wired to an instrument of the family that plays the format; the family is `None` if the schedule
    /// has no channel.
    NotWired { format: Format, name: String, family: Option<Family> },
    /// A position jumps, and the format has only straight lines between positions.
    Jump { format: Format, channel: String, t_ns: u64, from: f64, to: f64 },
    /// The format represents stage positions only; `channel` is the first other channel, or `None` if there is no
    /// channel.
    NotPositions { format: Format, channel: Option<String> },
    /// The format cannot express something in the schedule: `what` completes the sentence of the message, `help` names
    /// a format that can.
    Unsupported { format: Format, what: String, help: String },
    /// No device of the schedule has anything to load.
    NothingToLoad { name: String },
    /// The requested instant is after the end of the schedule.
    OutsideSchedule { name: String, t_ns: u64, duration_ns: u64 },
    /// The library that writes the format failed.
    Failed { format: Format, detail: String },
}

impl EmitError {
    /// An error if a voltage ramps.
    pub(super) fn refuse_ramps(format: Format, signals: &Signals) -> Result<(), EmitError> {
        let Some(ramp) = signals.first_ramp() else { return Ok(()) };
        let channel = signals.schedule.channels.get(ramp.channel as usize);
        let channel = channel.map_or_else(String::new, |channel| channel.name.clone());
        Err(EmitError::Ramp { format, channel, start_ns: ramp.start_ns, from: ramp.from, to: ramp.to })
    }

    /// An error if a position jumps.
    pub(super) fn refuse_jumps(format: Format, signals: &Signals) -> Result<(), EmitError> {
        let Some((index, t_ns)) = signals.first_jump() else { return Ok(()) };
        let channel = signals.schedule.channels[index].name.clone();
        let (from, to) = (signals.value_before(index, t_ns), signals.value(index, t_ns));
        Err(EmitError::Jump { format, channel, t_ns, from, to })
    }

    /// An error if `bytes` is more than `limit`.
    pub(super) fn refuse_size(format: Format, bytes: u64, limit: u64) -> Result<(), EmitError> {
        if bytes > limit { Err(EmitError::TooLarge { format, bytes, limit }) } else { Ok(()) }
    }

    /// Whether the format cannot represent the schedule, although other formats may.
    pub fn is_unsupported_by_format(&self) -> bool {
        match self {
            EmitError::Ramp { .. }
            | EmitError::TooLarge { .. }
            | EmitError::TooManyPoints { .. }
            | EmitError::TooManyFrames { .. }
            | EmitError::TooLongForTable { .. }
            | EmitError::OtherProtocol { .. }
            | EmitError::TooFine { .. }
            | EmitError::CoarseStages { .. }
            | EmitError::NoSampleClock { .. }
            | EmitError::NotWired { .. }
            | EmitError::Jump { .. }
            | EmitError::NotPositions { .. }
            | EmitError::Unsupported { .. }
            | EmitError::NothingToLoad { .. } => true,
            EmitError::NotFinite | EmitError::OutsideSchedule { .. } | EmitError::Failed { .. } => false,
        }
    }

    /// The diagnostic for the terminal.
    pub fn diagnostic(&self) -> Diagnostic {
        match self {
            EmitError::NotFinite => Diagnostic::new(Code::E0820, "a value of the schedule is not a finite number")
                .help("check the constants of the device: one is so large or so small that its products leave the range of numbers"),
            EmitError::Ramp { format, channel, start_ns, from, to } => Diagnostic::new(
                Code::E0821,
                format!("`{channel}` ramps from {from} to {to} at {start_ns} ns, but `{}` stores only constant voltages", format.name()),
            )
            .help("write `--emit mcap`, `json` or `pwl`: these formats keep ramps"),
            EmitError::TooLarge { format, bytes, limit } => Diagnostic::new(
                Code::E0822,
                format!("the {} file would take about {} MiB; the limit is {} MiB", format.name(), bytes >> 20, limit >> 20),
            )
            .help("write `--emit json`, which grows only with the number of changes, or build the tasks one at a time with `--task`"),
            EmitError::TooManyPoints { instrument, points, limit, period_ns, duration_ns, most_steps } => {
                too_many_points(instrument, [*points, *limit], [*period_ns, *duration_ns], *most_steps)
            }
            EmitError::TooManyFrames { instrument, frames, limit, period_ns } => {
                too_many_frames(instrument, [*frames, *limit], *period_ns)
            }
            EmitError::TooLongForTable { instrument, points, limit, period_ns } => {
                too_long_for_table(instrument, [*points, *limit], *period_ns)
            }
            EmitError::OtherProtocol { format, name } => {
                let title = format!("no electrode of `{name}` is wired to a driver that `{}` supports", format.name());
                Diagnostic::new(Code::E0824, title).help("write `--emit frames`, which supports every electrode driver")
            }
            EmitError::TooFine { instrument, period_ns, rate_hz } => too_fine(instrument, *period_ns, *rate_hz),
            EmitError::CoarseStages { instrument, channel, um, period_ns, is_by_memory } => {
                coarse_stages(instrument, channel, *um, *period_ns, *is_by_memory)
            }
            EmitError::NoSampleClock { instrument } => {
                Diagnostic::new(Code::E0829, format!("the lines of `{instrument}` have no sample clock, so nothing keeps their times"))
                    .help("wire to lines of a clocked port; if these lines are clocked, set the `digital_rate` of the instrument")
            }
            EmitError::NotWired { format, name, family } => not_wired(*format, name, *family),
            EmitError::Jump { format, channel, t_ns, from, to } => Diagnostic::new(
                Code::E0826,
                format!("`{channel}` jumps from {from} um to {to} um at {t_ns} ns, but `{}` supports only straight lines", format.name()),
            )
            .help("write `--emit mcap`, `json` or `pwl`, which store it exactly"),
            EmitError::NotPositions { format, channel } => not_positions(*format, channel.as_deref()),
            EmitError::Unsupported { format, what, help } => {
                Diagnostic::new(Code::E0831, format!("`{}` cannot express {what}", format.name())).help(help.clone())
            }
            EmitError::NothingToLoad { name } => {
                Diagnostic::new(Code::E0830, format!("`{name}` moves no droplets, so a sheet would be empty"))
                    .help("a sheet lists what to load into boards of droplets: write `--emit html` or `svg` for other devices")
            }
            EmitError::OutsideSchedule { name, t_ns, duration_ns } => {
                let [t, duration] = [*t_ns, *duration_ns].map(Quantity::time_ns);
                Diagnostic::new(Code::E0828, format!("{t} is after the end of `{name}`, which lasts {duration}")).help(
                    format!("choose an instant from 0 ms to {duration}, or build the tasks one at a time with `--task`"),
                )
            }
            EmitError::Failed { format, detail } => {
                Diagnostic::new(Code::E0825, format!("the {} file could not be generated: {detail}", format.name()))
                    .help("this is a fault of Tweeze; please report it with the program")
            }
        }
    }
}

fn too_many_points(
    instrument: &str,
    [points, limit]: [u64; 2],
    [period_ns, duration_ns]: [u64; 2],
    most_steps: Option<u64>,
) -> Diagnostic {
    let Some(steps) = most_steps else {
        let title = format!(
            "the schedule of {duration_ns} ns needs {points} points of {period_ns} ns; `{instrument}` takes at most {limit}"
        );
        return Diagnostic::new(Code::E0823, title).help(format!(
            "choose pulse duration, rest and waits as multiples of a longer time: {} ns or more would fit",
            duration_ns.div_ceil(limit.saturating_sub(2).max(1))
        ));
    };
    let title = format!(
        "the {duration_ns} ns of the schedule need {points} points of {period_ns} ns; `{instrument}` repeats {limit} in at most {steps} steps"
    );
    Diagnostic::new(Code::E0823, title).help(
        "build the tasks one at a time with `--task`, or choose the times of the device and the waits as multiples of a longer time",
    )
}

fn too_many_frames(instrument: &str, [frames, limit]: [u64; 2], period_ns: u64) -> Diagnostic {
    let period = Quantity::time_ns(period_ns);
    let title = format!("`{instrument}` needs {frames} frames of {period}; its own program loads at most {limit}");
    Diagnostic::new(Code::E0823, title)
        .help("write `--emit frames`, whose sender has no limit, or build the tasks one at a time with `--task`")
}

fn too_fine(instrument: &str, period_ns: u64, rate_hz: f64) -> Diagnostic {
    let [period, least] = [period_ns as f64 / 1e9, 1.0 / rate_hz].map(|s| Quantity::new(s, Dimension::TIME));
    let title = format!("edges and waits fall on multiples of {period}, but `{instrument}` samples every {least}");
    Diagnostic::new(Code::E0623, title)
        .help(format!("choose pulse durations, rests and waits as multiples of {least} or of a longer time"))
}

fn coarse_stages(
    instrument: &str,
    channel: &str,
    [step_um, tolerance_um]: [f64; 2],
    period_ns: u64,
    is_by_memory: bool,
) -> Diagnostic {
    let [step, tolerance] = [step_um, tolerance_um].map(|um| Quantity::length_um(significant(um, 3)));
    let period = Quantity::new(significant(period_ns as f64, 3) / 1e9, Dimension::TIME);
    let title = format!(
        "`{channel}` moves by {step} between samples of `{instrument}`; the tolerance of its device is {tolerance}"
    );
    let help = match (is_by_memory, (tolerance_um / step_um * 100.0).floor()) {
        (true, _) => format!(
            "its memory requires samples {period} apart: build the tasks one at a time with `--task`, or use an instrument with more points"
        ),
        (false, percent) if percent >= 1.0 => format!(
            "its samples are {period} apart: lower the speeds of the device to {percent} % of their present values, or use a faster instrument"
        ),
        (false, _) => format!("its samples are {period} apart: use a faster instrument"),
    };
    Diagnostic::new(Code::E0624, title).help(help)
}

fn too_long_for_table(instrument: &str, [points, limit]: [u64; 2], period_ns: f64) -> Diagnostic {
    let period = Quantity::new(period_ns / 1e9, Dimension::TIME);
    let title = format!("each axis of `{instrument}` needs {points} points of {period}; its tables hold {limit}");
    Diagnostic::new(Code::E0823, title).help(
        "build the tasks one at a time with `--task`, or lower the speeds of the device: points may then be further apart",
    )
}

fn not_positions(format: Format, channel: Option<&str>) -> Diagnostic {
    let what = match channel {
        Some(channel) => format!("`{channel}` takes voltages"),
        None => "the schedule has no channel".to_owned(),
    };
    Diagnostic::new(Code::E0827, format!("{what}, but `{}` stores only stage positions", format.name()))
        .help("write voltages with `--emit csv`, `pwl` or `scpi`, and the tasks of stages on their own with `--task`")
}

fn nothing_switched(format: Format, name: &str) -> Diagnostic {
    let title = format!("`{name}` switches and moves nothing, so a file of `{}` would be empty", format.name());
    Diagnostic::new(Code::E0824, title).help(format!(
        "omit `{}` for this schedule; `--emit json` or `mcap` record what happens without channels",
        format.name()
    ))
}

fn not_wired(format: Format, name: &str, family: Option<Family>) -> Diagnostic {
    let Some(family) = family else { return nothing_switched(format, name) };
    let wires = match family {
        Family::ElectrodeDriver => "electrodes -> NAME",
        Family::WaveformGenerator | Family::DataAcquisition | Family::StageController | Family::MachineController => {
            "…"
        }
    };
    let (family, (file, instrument)) = (family.name(), family.library());
    let title =
        format!("`{}` is for instruments `{family}`, but no channel of `{name}` is wired to one", format.name());
    Diagnostic::new(Code::E0824, title).help(format!(
        "declare the instrument with `use {file}` and `instrument NAME : {instrument}`, and wire channels to it with `wiring DEVICE {{ {wires} }}`; `tweeze devices {family}` shows outputs and wires"
    ))
}
