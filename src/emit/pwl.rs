//! PWL: piecewise linear voltage sources for SPICE, and a small deck that ngspice runs.
//!
//! `<name>.pwl.inc` has a source for each channel, between ground and a node named like the channel, with `_` for
//! characters that SPICE does not allow in a name. `<name>.cir` includes it, puts a load on every node, runs the
//! schedule and writes the node voltages to `<name>.ngspice.txt`. A source cannot jump: a step at `t` begins at `t` and
//! ends [`RISE_NS`] later. Straight lines from one value to another are exact.
//!
//! A channel of positions is a source too, in which 1 V means 1 um: the set point of a model of a stage, or of the
//! amplifier in front of it, after a gain of volts per micrometre. The comment before the source states this.
//!
//! A drive train is one line however long it is: the PWL source of its channel has the second level of the swing, and a
//! PULSE source in series adds the difference to the first one for half of each period; its eighth number is the number
//! of periods. The node carries the sum, the voltage of the channel. The sources have every train to its end. Since
//! ngspice takes about thirty points per edge, the deck stops after 20,000 edges and says how to run all.

use super::csv::one_line;
use super::error::{EmitError, MAX_TEXT_BYTES};
use super::signal::{JUMP_TOLERANCE_UM, half_ns};
use super::{Format, Signals, identifier};
use crate::schedule::{Actuation, ChannelUnit, Swing};
use std::collections::BTreeSet;
use std::fmt::Write as _;

/// Duration of a step, in nanoseconds: the resolution of the schedule's clock.
pub const RISE_NS: u64 = 1;

/// Load of each source of the deck, in ohms: negligible; to be replaced by the actuator's model.
const LOAD_OHM: &str = "1meg";

/// Time steps of the deck's run, in addition to the edges.
const STEPS: u64 = 1000;

/// Estimated bytes of a point.
const POINT_BYTES: u64 = 32;

/// Estimated bytes of the source of a train.
const TRAIN_BYTES: u64 = 128;

/// Greatest number of edges in the deck if there are trains, since ngspice takes about thirty points for each.
const MAX_EDGES: u64 = 20_000;

/// Greatest product of edges and sources, since ngspice evaluates every source at every point.
const MAX_WORK: u64 = 5_000_000;

/// The sources and the deck.
///
/// # Errors
/// [`EmitError::TooLarge`] past [`MAX_TEXT_BYTES`].
pub(super) fn write(signals: &Signals) -> Result<[Vec<u8>; 2], EmitError> {
    let channels = &signals.schedule.channels;
    let lines: Vec<Waveform> = (0..channels.len()).map(|channel| Waveform::new(signals, channel)).collect();
    let bytes = lines.iter().map(Waveform::estimated_bytes).fold(0, u64::saturating_add);
    EmitError::refuse_size(Format::Pwl, bytes, MAX_TEXT_BYTES)?;
    let trains = channels
        .iter()
        .zip(&lines)
        .flat_map(|(channel, line)| (1..=line.trains.len()).map(|number| format!("{}.train{number}", channel.name)));
    let trains: Vec<String> = trains.collect();
    let words = channels.iter().map(|channel| channel.name.as_str()).chain(trains.iter().map(String::as_str));
    let mut nodes = identifier::distinct(words);
    let inner = nodes.split_off(channels.len());
    Ok([sources(signals, &lines, &nodes, &inner).into_bytes(), deck(signals, &nodes).into_bytes()])
}

/// Waveform of a channel: a line through points, with the trains on top.
struct Waveform<'a> {
    signals: &'a Signals<'a>,
    channel: usize,
    /// Empty if a level is no longer than the rise of a step; the line then goes through every edge.
    trains: Vec<(&'a Actuation, Swing)>,
}

impl<'a> Waveform<'a> {
    fn new(signals: &'a Signals<'a>, channel: usize) -> Self {
        let all: Vec<_> = signals.swings(channel).collect();
        let slow = all.iter().all(|(_, swing)| half_ns(*swing) > RISE_NS);
        Waveform { signals, channel, trains: if slow { all } else { Vec::new() } }
    }

    fn estimated_bytes(&self) -> u64 {
        let trains = self.trains.len() as u64;
        let points = match trains {
            0 => self.signals.count_edges([self.channel]),
            _ => 2 * self.signals.of(self.channel).len() as u64,
        };
        (2 + points.saturating_mul(2)).saturating_mul(POINT_BYTES).saturating_add(trains * TRAIN_BYTES)
    }

    fn breaks(&self) -> BTreeSet<u64> {
        match self.trains.is_empty() {
            true => self.signals.edges([self.channel]).collect(),
            false => self.signals.breaks([self.channel]),
        }
    }

    /// The value without the trains on top.
    fn base(&self, t_ns: u64) -> f64 {
        let train = self.signals.during(self.channel, t_ns);
        self.second_level(train).unwrap_or_else(|| self.signals.value(self.channel, t_ns))
    }

    fn base_before(&self, t_ns: u64) -> f64 {
        let train = self.signals.until(self.channel, t_ns);
        self.second_level(train).unwrap_or_else(|| self.signals.value_before(self.channel, t_ns))
    }

    /// Whether a stage does not jump at an instant, up to rounding, so that no rise is needed.
    fn bends(&self, t_ns: u64) -> bool {
        match self.signals.unit(self.channel) {
            ChannelUnit::Volt => false,
            ChannelUnit::Micrometre => (self.base_before(t_ns) - self.base(t_ns)).abs() <= JUMP_TOLERANCE_UM,
        }
    }

    fn second_level(&self, train: Option<&Actuation>) -> Option<f64> {
        train.and_then(|train| train.swing).filter(|_| !self.trains.is_empty()).map(|swing| swing.levels[1])
    }

    /// Corners of the line, in strictly increasing time.
    fn points(&self) -> Vec<(u64, f64)> {
        let breaks = self.breaks();
        let mut points = vec![(0, self.base_before(0))];
        let mut add = |t_ns: u64, volts: f64| match points.last() {
            Some((last_ns, _)) if *last_ns >= t_ns => {}
            Some(_) | None => points.push((t_ns, volts)),
        };
        for &t_ns in &breaks {
            let done_ns = t_ns + RISE_NS;
            add(t_ns, self.base_before(t_ns));
            if self.bends(t_ns) {
                continue;
            }
            let next = breaks.range(t_ns + 1..=done_ns).next();
            match next {
                Some(_) => add(done_ns, self.base_before(done_ns)),
                None => add(done_ns, self.base(done_ns)),
            }
        }
        let end_ns = self.signals.schedule.duration_ns;
        add(end_ns, self.base_before(end_ns));
        points
    }
}

fn sources(signals: &Signals, lines: &[Waveform], nodes: &[String], inner: &[String]) -> String {
    let schedule = signals.schedule;
    let mut text = format!("* {}: one voltage source for each channel, steps rise in {RISE_NS} ns\n", schedule.name);
    if !inner.is_empty() {
        text.push_str("* with one more in series for each drive train, whose last number is how many periods it has\n");
    }
    let mut inner = inner.iter();
    for (line, node) in lines.iter().zip(nodes) {
        let channel = &schedule.channels[line.channel];
        let wire = channel.wire.as_deref().map_or_else(String::new, |wire| format!(", wire {}", one_line(wire)));
        let scale = match channel.unit {
            ChannelUnit::Volt => "",
            ChannelUnit::Micrometre => ", 1 V stands for 1 um",
        };
        let _ = writeln!(text, "* {} [{}]{scale}{wire}", channel.name, channel.unit.symbol());
        let own: Vec<&str> = inner.by_ref().take(line.trains.len()).map(String::as_str).collect();
        // The sources are in series: each stands on the next one, the last on ground.
        let below = own.iter().copied().chain(["0"]);
        let mut names = std::iter::once(node.as_str()).chain(own.iter().copied()).zip(below);
        if let Some((node, below)) = names.next() {
            let _ = writeln!(text, "V{node} {node} {below} PWL(");
        }
        for (t_ns, volts) in line.points() {
            let _ = writeln!(text, "+ {} {volts}", seconds(t_ns));
        }
        text.push_str("+ )\n");
        for ((node, below), (train, swing)) in names.zip(&line.trains) {
            let _ = writeln!(text, "V{node} {node} {below} {}", pulses(train, *swing));
        }
    }
    text
}

/// Voltage that a train adds to the second level of its swing.
fn pulses(train: &Actuation, swing: Swing) -> String {
    let Swing { period_ns, levels: [first, second] } = swing;
    let (rise, width) = (seconds(RISE_NS), seconds(half_ns(swing) - RISE_NS));
    let (start, period, count) = (seconds(train.start_ns), seconds(period_ns), train.duration_ns / period_ns);
    format!("PULSE(0 {} {start} {rise} {rise} {width} {period} {count})", first - second)
}

/// Nanoseconds as decimal seconds, without rounding.
fn seconds(t_ns: u64) -> String {
    let text = format!("{}.{:09}", t_ns / 1_000_000_000, t_ns % 1_000_000_000);
    text.trim_end_matches('0').trim_end_matches('.').to_owned()
}

fn deck(signals: &Signals, nodes: &[String]) -> String {
    let schedule = signals.schedule;
    let name = &schedule.name;
    let stop_ns = stop_ns(signals).max(STEPS * RISE_NS);
    let mut text = format!(
        "* {name}: run with `ngspice -b {name}.cir`, which writes {name}.ngspice.txt\n\
         * replace the loads by the actuators' own models\n.include {name}.pwl.inc\n"
    );
    if stop_ns < schedule.duration_ns {
        let _ = writeln!(text, "{}", whole_run(signals));
    }
    for node in nodes {
        let _ = writeln!(text, "R{node} {node} 0 {LOAD_OHM}");
    }
    let _ = writeln!(text, ".tran {} {}", seconds(stop_ns / STEPS), seconds(stop_ns));
    text.push_str(".control\nset wr_singlescale\nset wr_vecnames\noption numdgt=12\nrun\n");
    let vectors: Vec<String> = nodes.iter().map(|node| format!("v({node})")).collect();
    let _ = writeln!(text, "wrdata {name}.ngspice.txt {}", vectors.join(" "));
    // Without it, ngspice ends a batch run with status 1, because the run was not started by batch mode itself.
    text.push_str("quit 0\n.endc\n.end\n");
    text
}

/// Instructions for running a deck that stops early to its end: with output at fixed points instead of all that ngspice
/// takes, which would fill the memory.
fn whole_run(signals: &Signals) -> String {
    let channels = 0..signals.schedule.channels.len();
    let halves_ns = channels.clone().flat_map(|channel| signals.swings(channel)).map(|(_, swing)| half_ns(swing));
    let point_ns = halves_ns.min().unwrap_or(STEPS).div_ceil(2);
    let (edges, end) = (signals.count_edges(channels), seconds(signals.schedule.duration_ns));
    format!(
        "* the sources run to the end of the schedule, but this deck stops after {} of {edges} edges, of which ngspice takes\n\
         * about 2000 in a second; to run all, put these two lines in place of the one with .tran:\n\
         *   .options interp\n*   .tran {} {end}",
        most_edges(signals),
        seconds(point_ns)
    )
}

/// Where the deck stops: at the end of the schedule, or, if there are trains, after [`most_edges`].
fn stop_ns(signals: &Signals) -> u64 {
    let duration_ns = signals.schedule.duration_ns;
    let channels = 0..signals.schedule.channels.len();
    match trains(signals) {
        0 => duration_ns,
        _ => signals.edges(channels).nth(most_edges(signals)).map_or(duration_ns, |t_ns| t_ns.min(duration_ns)),
    }
}

/// Upper bound on the number of edges in the deck.
fn most_edges(signals: &Signals) -> usize {
    let sources = (signals.schedule.channels.len() + trains(signals)) as u64;
    MAX_EDGES.min(MAX_WORK / sources.max(1)) as usize
}

fn trains(signals: &Signals) -> usize {
    signals.schedule.actuations.iter().filter(|actuation| actuation.swing.is_some()).count()
}
