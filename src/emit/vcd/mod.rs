//! VCD (IEEE 1364-2005, clause 18): waveforms for GTKWave, sigrok, PulseView and similar viewers, and a GTKWave save
//! file.
//!
//! Each device is a scope. A variable in it has the channel's whole name with `_` for dots, `bot_bl0_set`, because
//! GTKWave and sigrok show only the last part of a name. A wired channel appears a second time in the scope `wires`,
//! under the wire's name. A comment for each channel states the meaning of its variables:
//!
//! - A voltage that is either 0 V or one other voltage is a 1-bit `wire`, which logic analysers accept; the comment has
//!   the voltage.
//! - Other voltages are `real`, in volts. sigrok up to 0.5.2 leaves these out.
//! - A channel with drive trains is a `wire` that is 1 while a train runs, `fleet_bed_train`, and three `real`s that
//!   change only where a train begins or ends: `fleet_bed_first` and `fleet_bed_second` in volts,
//!   `fleet_bed_period_ns`. Half of each period is at the first level, then half at the second, counted from the last
//!   change of one of the four. Without a train, both levels are the voltage and the period is 0.
//! - A position changes continuously, and VCD has steps only, so it is written as the counts of a 10 nm encoder: at
//!   every nanosecond the nearest multiple of [`COUNT_UM`].
//!
//! The timescale is the longest of 1 ns, 10 ns, ... 1 s that divides every instant, since sigrok makes a sample of each
//! unit.

mod counts;
mod variables;
mod view;

use super::csv::digits;
use super::error::{EmitError, MAX_TEXT_BYTES};
use super::{Format, Signals};
use crate::schedule::ChannelUnit;
pub use counts::COUNT_UM;
use counts::Counts;
use std::cmp::Reverse;
use std::collections::{BTreeMap, BinaryHeap};
use std::fmt::Write as _;
use variables::{ChannelForm, Variable};

/// Estimated bytes of a change without the digits of its instant.
const CHANGE_BYTES: u64 = 10;

/// The scope of the physical outputs.
const WIRES: &str = "wires";

/// Time units of VCD from a nanosecond up, each ten times the one before.
const TIMESCALES: [&str; 10] = ["1 ns", "10 ns", "100 ns", "1 us", "10 us", "100 us", "1 ms", "10 ms", "100 ms", "1 s"];

/// The waveforms, and the save file with which GTKWave shows them.
///
/// # Errors
/// [`EmitError::Ramp`] for a voltage that is not constant, [`EmitError::TooLarge`] past [`MAX_TEXT_BYTES`].
pub(super) fn write(signals: &Signals) -> Result<[Vec<u8>; 2], EmitError> {
    EmitError::refuse_ramps(Format::Vcd, signals)?;
    let schedule = signals.schedule;
    let change_bytes = digits(schedule.duration_ns) + CHANGE_BYTES;
    let voltages = 8 * schedule.actuations.len() as u64;
    let lines = voltages.saturating_add(counts::number(signals));
    EmitError::refuse_size(Format::Vcd, lines.saturating_mul(change_bytes), MAX_TEXT_BYTES)?;
    let forms: Vec<ChannelForm> =
        (0..schedule.channels.len()).map(|channel| ChannelForm::new(signals, channel)).collect();
    let variables = variables::all(signals, &forms);
    let (unit_ns, timescale) = timescale(signals);

    let mut text = String::new();
    let _ = writeln!(text, "$version tweeze {} $end", env!("CARGO_PKG_VERSION"));
    let _ = writeln!(text, "$comment {} of {} $end", word(&schedule.name), word(&schedule.source.file));
    for own in variables.chunk_by(|one, next| one.channel == next.channel) {
        let channel = own[0].channel;
        let _ = writeln!(text, "{}", variables::comment(&schedule.channels[channel], &forms[channel], own));
    }
    let _ = writeln!(text, "$timescale {timescale} $end");
    let scopes = signals.device_names(plain);
    declare(&mut text, signals, &scopes, &variables);
    text.push_str("$enddefinitions $end\n");
    changes(&mut text, signals, &variables, unit_ns);
    let view = view::write(signals, &scopes, &forms, &variables, unit_ns);
    Ok([text.into_bytes(), view.into_bytes()])
}

/// The longest time unit that divides every instant: its nanoseconds and its name.
fn timescale(signals: &Signals) -> (u64, &'static str) {
    let duration_ns = signals.schedule.duration_ns;
    let instants = signals.breaks(0..signals.schedule.channels.len());
    let has_counts = signals.in_unit(ChannelUnit::Micrometre).next().is_some();
    let fits =
        |unit_ns: u64| duration_ns.is_multiple_of(unit_ns) && instants.iter().all(|t_ns| t_ns.is_multiple_of(unit_ns));
    let longest = match has_counts || duration_ns == 0 {
        true => 0,
        false => (1..TIMESCALES.len()).take_while(|power| fits(10u64.pow(*power as u32))).last().unwrap_or(0),
    };
    (10u64.pow(longest as u32), TIMESCALES[longest])
}

/// The scopes and variables: a scope for each device, and one for the wires.
fn declare(text: &mut String, signals: &Signals, scopes: &BTreeMap<&str, String>, variables: &[Variable]) {
    let channels = &signals.schedule.channels;
    let mut devices: indexmap::IndexMap<&str, Vec<String>> = indexmap::IndexMap::new();
    for variable in variables {
        devices.entry(&channels[variable.channel].device).or_default().push(variable.declaration());
    }
    let wires: Vec<String> = variables.iter().filter_map(Variable::wire_declaration).collect();
    let devices = devices.into_iter().map(|(device, lines)| (scopes[device].clone(), lines));
    let scopes = devices.chain(Some((WIRES.to_owned(), wires)).filter(|(_, wires)| !wires.is_empty()));
    for (name, lines) in scopes {
        let _ = writeln!(text, "$scope module {name} $end");
        lines.into_iter().for_each(|line| text.push_str(&line));
        text.push_str("$upscope $end\n");
    }
}

fn changes(text: &mut String, signals: &Signals, variables: &[Variable], unit_ns: u64) {
    let mut stated: Vec<f64> = Vec::with_capacity(variables.len());
    text.push_str("#0\n$dumpvars\n");
    for variable in variables {
        let value = variable.value(signals, 0);
        variable.write(text, value);
        stated.push(value);
    }
    text.push_str("$end\n");
    let mut last_ns = 0;
    for (t_ns, index, value) in values(signals, variables).filter(|(t_ns, ..)| *t_ns > 0) {
        if stated[index] == value {
            continue;
        }
        if t_ns != last_ns {
            let _ = writeln!(text, "#{}", t_ns / unit_ns);
            last_ns = t_ns;
        }
        variables[index].write(text, value);
        stated[index] = value;
    }
    if signals.schedule.duration_ns != last_ns {
        let _ = writeln!(text, "#{}", signals.schedule.duration_ns / unit_ns);
    }
}

/// Values of variables, in order of time, then of variable; consecutive ones may be equal.
fn values<'a>(signals: &'a Signals, variables: &'a [Variable]) -> impl Iterator<Item = (u64, usize, f64)> + 'a {
    let of_variable = |variable: &'a Variable| -> Box<dyn Iterator<Item = (u64, f64)> + 'a> {
        match signals.unit(variable.channel) {
            ChannelUnit::Volt => {
                let breaks = signals.breaks([variable.channel]).into_iter();
                Box::new(breaks.map(move |t_ns| (t_ns, variable.value(signals, t_ns))))
            }
            ChannelUnit::Micrometre => Box::new(Counts::new(signals, variable.channel)),
        }
    };
    let mut of_variable: Vec<_> = variables.iter().map(of_variable).collect();
    let mut heads: Vec<Option<(u64, f64)>> = of_variable.iter_mut().map(Iterator::next).collect();
    let firsts = heads.iter().enumerate();
    let mut due: BinaryHeap<_> = firsts.filter_map(|(index, head)| Some(Reverse(((*head)?.0, index)))).collect();
    std::iter::from_fn(move || {
        let Reverse((t_ns, index)) = due.pop()?;
        let (_, value) = heads[index]?;
        heads[index] = of_variable[index].next();
        due.extend(heads[index].map(|(next_ns, _)| Reverse((next_ns, index))));
        Some((t_ns, index, value))
    })
}

/// A text as one word, since readers end names at blanks.
fn word(text: &str) -> String {
    let plain = |c: char| if c.is_ascii_graphic() && c != '$' { c } else { '_' };
    text.chars().map(plain).collect()
}

/// A text as the name of a variable or scope: GTKWave splits names at dots, and reads brackets as an index.
fn plain(text: &str) -> String {
    word(text).replace(['.', '[', ']', '{', '}'], "_")
}
