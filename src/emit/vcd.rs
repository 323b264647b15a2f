//! VCD (IEEE 1364-2005, clause 18): step functions for GTKWave and its kin.
//!
//! Each channel is a `real` variable in volts, found under its own name: the scopes are the name's parts, `bot` / `bl4`, and the
//! variable is `set`. A wired channel is found a second time in the scope `wires`, under the wire's name. The timescale is 1 ns.

use super::csv::{digits, one_line};
use super::error::{EmitError, MAX_TEXT_BYTES};
use super::{Format, Signals};
use crate::schedule::Channel;
use std::cmp::Reverse;
use std::collections::BinaryHeap;
use std::fmt::Write as _;

/// About how many bytes a change takes besides the digits of its instant.
const CHANGE_BYTES: u64 = 10;

/// The scope that holds the physical outputs.
const WIRES: &str = "wires";

/// The text of the file.
///
/// # Errors
/// [`EmitError::Ramp`] for a value that is not constant, [`EmitError::TooLarge`] past [`MAX_TEXT_BYTES`].
pub(super) fn write(signals: &Signals) -> Result<Vec<u8>, EmitError> {
    EmitError::refuse_ramps(Format::Vcd, signals)?;
    let schedule = signals.schedule;
    let change_bytes = digits(schedule.duration_ns) + CHANGE_BYTES;
    let bytes = signals.count_edges(0..schedule.channels.len()).saturating_mul(change_bytes);
    EmitError::refuse_size(Format::Vcd, bytes, MAX_TEXT_BYTES)?;
    let mut text = String::new();
    let _ = writeln!(text, "$version tweeze {} $end", env!("CARGO_PKG_VERSION"));
    let _ = writeln!(text, "$comment {} of {} $end", word(&schedule.name), word(&schedule.source.file));
    for channel in &schedule.channels {
        let wire = channel.wire.as_deref().unwrap_or("none");
        let (name, unit) = (word(&channel.name), channel.unit.symbol());
        let _ = writeln!(text, "$comment {name} [{unit}] wire: {} $end", one_line(wire).replace('$', "_"));
    }
    text.push_str("$timescale 1 ns $end\n");
    declare(&mut text, &schedule.channels);
    text.push_str("$enddefinitions $end\n");
    changes(&mut text, signals);
    Ok(text.into_bytes())
}

/// The scopes and variables. Channels that share a scope stand together, as one scope may be opened only once for some readers.
fn declare(text: &mut String, channels: &[Channel]) {
    let mut root = Scope::default();
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
struct Scope {
    variables: Vec<(String, usize)>,
    inner: indexmap::IndexMap<String, Scope>,
}

impl Scope {
    /// As deep as the names of channels have dots, which the language keeps to a few.
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
    let channels = signals.schedule.channels.len();
    text.push_str("#0\n$dumpvars\n");
    for channel in 0..channels {
        let _ = writeln!(text, "r{} {}", signals.value(channel, 0), code(channel));
    }
    text.push_str("$end\n");
    let mut last_ns = 0;
    for (t_ns, channel) in edges(signals).filter(|(t_ns, _)| *t_ns > 0) {
        if signals.value_before(channel, t_ns) == signals.value(channel, t_ns) {
            continue;
        }
        if t_ns != last_ns {
            let _ = writeln!(text, "#{t_ns}");
            last_ns = t_ns;
        }
        let _ = writeln!(text, "r{} {}", signals.value(channel, t_ns), code(channel));
    }
    if signals.schedule.duration_ns != last_ns {
        let _ = writeln!(text, "#{}", signals.schedule.duration_ns);
    }
}

/// The edges of every channel with the channel's index, in order of time, then of channel.
fn edges(signals: &Signals) -> impl Iterator<Item = (u64, usize)> {
    let channels = 0..signals.schedule.channels.len();
    let mut of_channel: Vec<_> = channels.map(|channel| signals.edges([channel])).collect();
    let firsts = of_channel.iter_mut().enumerate();
    let mut due: BinaryHeap<_> =
        firsts.filter_map(|(channel, edges)| Some(Reverse((edges.next()?, channel)))).collect();
    std::iter::from_fn(move || {
        let Reverse((t_ns, channel)) = due.pop()?;
        due.extend(of_channel[channel].next().map(|next_ns| Reverse((next_ns, channel))));
        Some((t_ns, channel))
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
