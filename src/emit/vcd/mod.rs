//! VCD (IEEE 1364-2005, clause 18): step functions for GTKWave and similar viewers.
//!
//! Each channel is a `real` variable in volts, found under its own name: the scopes are the name's parts, `bot` / `bl4`, and the
//! variable is `set`. A wired channel is found a second time in the scope `wires`, under the wire's name. The timescale is 1 ns.
//!
//! A position changes continuously, and VCD has steps only. So it is written as the counts of an encoder of 10 nm: at every nanosecond
//! the nearest multiple of [`COUNT_UM`], as a comment states for the channel.

mod counts;

use super::csv::{digits, one_line};
use super::error::{EmitError, MAX_TEXT_BYTES};
use super::{Format, Signals};
use crate::schedule::{Channel, ChannelUnit};
pub use counts::COUNT_UM;
use counts::Counts;
use std::cmp::Reverse;
use std::collections::BinaryHeap;
use std::fmt::Write as _;

/// Estimated bytes of a change without the digits of its instant.
const CHANGE_BYTES: u64 = 10;

/// The scope of the physical outputs.
const WIRES: &str = "wires";

/// The text of the file.
///
/// # Errors
/// [`EmitError::Ramp`] for a voltage that is not constant, [`EmitError::TooLarge`] past [`MAX_TEXT_BYTES`].
pub(super) fn write(signals: &Signals) -> Result<Vec<u8>, EmitError> {
    EmitError::refuse_ramps(Format::Vcd, signals)?;
    let schedule = signals.schedule;
    let change_bytes = digits(schedule.duration_ns) + CHANGE_BYTES;
    let lines = signals.count_edges(0..schedule.channels.len()).saturating_add(counts::number(signals));
    let bytes = lines.saturating_mul(change_bytes);
    EmitError::refuse_size(Format::Vcd, bytes, MAX_TEXT_BYTES)?;
    let mut text = String::new();
    let _ = writeln!(text, "$version tweeze {} $end", env!("CARGO_PKG_VERSION"));
    let _ = writeln!(text, "$comment {} of {} $end", word(&schedule.name), word(&schedule.source.file));
    for channel in &schedule.channels {
        let wire = channel.wire.as_deref().unwrap_or("none");
        let (name, unit) = (word(&channel.name), channel.unit.symbol());
        let form = match channel.unit {
            ChannelUnit::Volt => String::new(),
            ChannelUnit::Micrometre => format!(" as the nearest multiple of {COUNT_UM} {unit}"),
        };
        let _ = writeln!(text, "$comment {name} [{unit}]{form} wire: {} $end", one_line(wire).replace('$', "_"));
    }
    text.push_str("$timescale 1 ns $end\n");
    declare(&mut text, &schedule.channels);
    text.push_str("$enddefinitions $end\n");
    changes(&mut text, signals);
    Ok(text.into_bytes())
}

/// The scopes and variables. Channels that share a scope stand together, as one scope may be opened only once for some readers.
fn declare(text: &mut String, channels: &[Channel]) {
    let mut root = NameScope::default();
    for (index, channel) in channels.iter().enumerate() {
        let mut parts: Vec<&str> = channel.name.split('.').collect();
        let name = parts.pop().unwrap_or_default();
        let scope = parts.into_iter().fold(&mut root, |scope, part| scope.inner.entry(word(part)).or_default());
        scope.variables.push((word(name), index));
    }
    for (index, channel) in channels.iter().enumerate() {
        if let Some(wire) = &channel.wire {
            root.inner.entry(WIRES.to_owned()).or_default().variables.push((word(wire), index));
        }
    }
    root.print(text);
}

/// The parts of names, as a tree.
#[derive(Default)]
struct NameScope {
    variables: Vec<(String, usize)>,
    inner: indexmap::IndexMap<String, NameScope>,
}

impl NameScope {
    /// Recursion depth is the number of dots in a channel's name, which the language limits to a few.
    fn print(&self, text: &mut String) {
        for (name, index) in &self.variables {
            let _ = writeln!(text, "$var real 64 {} {name} $end", code(*index));
        }
        for (name, scope) in &self.inner {
            let _ = writeln!(text, "$scope module {name} $end");
            scope.print(text);
            text.push_str("$upscope $end\n");
        }
    }
}

fn changes(text: &mut String, signals: &Signals) {
    let mut said: Vec<f64> = Vec::new();
    text.push_str("#0\n$dumpvars\n");
    for channel in 0..signals.schedule.channels.len() {
        let value = first(signals, channel);
        let _ = writeln!(text, "r{value} {}", code(channel));
        said.push(value);
    }
    text.push_str("$end\n");
    let mut last_ns = 0;
    for (t_ns, channel, value) in values(signals).filter(|(t_ns, ..)| *t_ns > 0) {
        if said[channel] == value {
            continue;
        }
        if t_ns != last_ns {
            let _ = writeln!(text, "#{t_ns}");
            last_ns = t_ns;
        }
        let _ = writeln!(text, "r{value} {}", code(channel));
        said[channel] = value;
    }
    if signals.schedule.duration_ns != last_ns {
        let _ = writeln!(text, "#{}", signals.schedule.duration_ns);
    }
}

fn first(signals: &Signals, channel: usize) -> f64 {
    match signals.unit(channel) {
        ChannelUnit::Volt => signals.value(channel, 0),
        ChannelUnit::Micrometre => counts::counted(signals.value(channel, 0)),
    }
}

/// Values of channels, in order of time, then of channel; some are no changes.
fn values<'a>(signals: &'a Signals) -> impl Iterator<Item = (u64, usize, f64)> + 'a {
    let of_channel = |channel: usize| -> Box<dyn Iterator<Item = (u64, f64)> + 'a> {
        match signals.unit(channel) {
            ChannelUnit::Volt => {
                Box::new(signals.edges([channel]).map(move |t_ns| (t_ns, signals.value(channel, t_ns))))
            }
            ChannelUnit::Micrometre => Box::new(Counts::new(signals, channel)),
        }
    };
    let mut of_channel: Vec<_> = (0..signals.schedule.channels.len()).map(of_channel).collect();
    let mut heads: Vec<Option<(u64, f64)>> = of_channel.iter_mut().map(Iterator::next).collect();
    let firsts = heads.iter().enumerate();
    let mut due: BinaryHeap<_> = firsts.filter_map(|(channel, head)| Some(Reverse(((*head)?.0, channel)))).collect();
    std::iter::from_fn(move || {
        let Reverse((t_ns, channel)) = due.pop()?;
        let (_, value) = heads[channel]?;
        heads[channel] = of_channel[channel].next();
        due.extend(heads[channel].map(|(next_ns, _)| Reverse((next_ns, channel))));
        Some((t_ns, channel, value))
    })
}

/// The short code of a variable: printable characters, here letters only, which every reader takes.
fn code(mut index: usize) -> String {
    let mut code = String::new();
    loop {
        code.push(char::from(b'a' + (index % 26) as u8));
        index /= 26;
        if index == 0 {
            return code;
        }
    }
}

/// A text as one word: a reader ends names at blanks, and GTKWave splits them at dots.
fn word(text: &str) -> String {
    let plain = |c: char| if c.is_ascii_graphic() && c != '$' { c } else { '_' };
    text.chars().map(plain).collect()
}
