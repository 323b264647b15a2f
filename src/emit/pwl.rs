//! PWL: piecewise linear voltage sources for SPICE, and a small deck that ngspice runs.
//!
//! `<name>.pwl.inc` holds a source for each channel, between ground and a node that is named like the channel, with `_` for what
//! SPICE does not take in a name. `<name>.cir` includes it, puts a load on every node, runs the schedule and writes the node
//! voltages to `<name>.ngspice.txt`. A source cannot jump: a step at `t` begins at `t` and is done [`RISE_NS`] later. Straight
//! lines from one value to another are exact.

use super::csv::one_line;
use super::error::{EmitError, MAX_TEXT_BYTES};
use super::{Format, Signals, identifier};
use std::fmt::Write as _;

/// How long a step takes, in nanoseconds: the smallest that the schedule's clock can tell apart.
pub const RISE_NS: u64 = 1;

/// What each source of the deck drives, in ohms: light enough not to matter, to be replaced by the actuator's model.
const LOAD_OHM: &str = "1meg";

/// Time steps that the deck asks for; the edges come on top.
const STEPS: u64 = 1000;

/// About how many bytes a point takes.
const POINT_BYTES: u64 = 32;

/// The sources and the deck.
///
/// # Errors
/// [`EmitError::TooLarge`] past [`MAX_TEXT_BYTES`].
pub(super) fn write(signals: &Signals) -> Result<[Vec<u8>; 2], EmitError> {
    let points = 2 + 4 * signals.schedule.actuations.len() as u64;
    EmitError::refuse_size(Format::Pwl, points * POINT_BYTES, MAX_TEXT_BYTES)?;
    let nodes = identifier::distinct(signals.schedule.channels.iter().map(|channel| channel.name.as_str()));
    Ok([sources(signals, &nodes).into_bytes(), deck(signals, &nodes).into_bytes()])
}

fn sources(signals: &Signals, nodes: &[String]) -> String {
    let schedule = signals.schedule;
    let mut text = format!("* {}: one voltage source for each channel, steps rise in {RISE_NS} ns\n", schedule.name);
    for (index, (channel, node)) in schedule.channels.iter().zip(nodes).enumerate() {
        let wire = channel.wire.as_deref().map_or_else(String::new, |wire| format!(", wire {}", one_line(wire)));
        let _ = writeln!(text, "* {} [{}]{wire}", channel.name, channel.unit.symbol());
        let _ = writeln!(text, "V{node} {node} 0 PWL(");
        for (t_ns, volts) in points(signals, index) {
            let _ = writeln!(text, "+ {} {volts}", seconds(t_ns));
        }
        text.push_str("+ )\n");
    }
    text
}

/// Corners of a channel's waveform, in strictly increasing time.
fn points(signals: &Signals, channel: usize) -> Vec<(u64, f64)> {
    let breaks = signals.breaks([channel]);
    let mut points = vec![(0, signals.value_before(channel, 0))];
    let mut add = |t_ns: u64, volts: f64| match points.last() {
        Some((last_ns, _)) if *last_ns >= t_ns => {}
        Some(_) | None => points.push((t_ns, volts)),
    };
    for &t_ns in &breaks {
        let done_ns = t_ns + RISE_NS;
        add(t_ns, signals.value_before(channel, t_ns));
        let next = breaks.range(t_ns + 1..=done_ns).next();
        match next {
            Some(_) => add(done_ns, signals.value_before(channel, done_ns)),
            None => add(done_ns, signals.value(channel, done_ns)),
        }
    }
    add(signals.schedule.duration_ns, signals.value_before(channel, signals.schedule.duration_ns));
    points
}

/// Nanoseconds as decimal seconds, without rounding.
fn seconds(t_ns: u64) -> String {
    let text = format!("{}.{:09}", t_ns / 1_000_000_000, t_ns % 1_000_000_000);
    text.trim_end_matches('0').trim_end_matches('.').to_owned()
}

fn deck(signals: &Signals, nodes: &[String]) -> String {
    let schedule = signals.schedule;
    let name = &schedule.name;
    let stop_ns = schedule.duration_ns.max(STEPS * RISE_NS);
    let mut text = format!(
        "* {name}: run with `ngspice -b {name}.cir`, which writes {name}.ngspice.txt\n\
         * replace the loads by the actuators' own models\n.include {name}.pwl.inc\n"
    );
    for node in nodes {
        let _ = writeln!(text, "R{node} {node} 0 {LOAD_OHM}");
    }
    let _ = writeln!(text, ".tran {} {}", seconds(stop_ns / STEPS), seconds(stop_ns));
    text.push_str(".control\nset wr_singlescale\nset wr_vecnames\noption numdgt=12\nrun\n");
    let vectors: Vec<String> = nodes.iter().map(|node| format!("v({node})")).collect();
    let _ = writeln!(text, "wrdata {name}.ngspice.txt {}", vectors.join(" "));
    text.push_str(".endc\n.end\n");
    text
}
