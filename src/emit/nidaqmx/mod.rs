//! NI-DAQmx: for each data acquisition card of the program the samples of its lines and outputs, and a program that
//! plays them.
//!
//! `<name>.<instrument>.daq` is a text: lines that begin with `#`, a line of titles, then one line for each run of
//! equal samples. Its columns are separated by tabs: the number of samples, the word of each port with a bit for each
//! line, and the volts of each analog output. `<name>.nidaqmx.py` plays all of them with the `nidaqmx` package of
//! National Instruments: every card on its sample clock, lines and outputs of one card on the same clock, from one
//! start. Before the start, at the end, on an error and on Ctrl-C it puts lines and voltages to rest; the outputs of
//! stages keep their values.
//!
//! A schedule that waits for inputs or people has a file for each part, `<name>.<instrument>.1.daq` and so on, whose
//! last sample is held during the wait.
//!
//! The sample period is the greatest common divisor of all times, so that every edge of a voltage falls on a sample;
//! the first sample is instant 0. After the schedule there is one sample of rest: 0 V and lines off unless a channel
//! rests at another voltage, and stages at their last position. Stages are sampled as for generators.

use super::csv::one_line;
use super::error::{EmitError, MAX_TEXT_BYTES};
use super::hold_parts::played;
use super::sampling::{SampleLimits, Sampling};
use super::wired::WiredInstrument;
use super::{Format, Signals};
use crate::claims::Claims;
use crate::device::instrument::{DataAcquisitionFacts, Family, InstrumentFacts, Start};
use crate::schedule::Schedule;
use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Write as _;

/// Most samples of a card, since the sender holds all of them in memory.
const MOST_SAMPLES: u64 = 10_000_000;

/// Estimated bytes of a column in a line.
const COLUMN_BYTES: u64 = 12;

/// The sender, with an empty list of cards at the marker.
const SENDER: &str = include_str!("send.py");

/// The files, each with its ending.
///
/// # Errors
/// [`EmitError::NotWired`], [`EmitError::NoSampleClock`], [`EmitError::Ramp`], [`EmitError::TooManyPoints`],
/// [`EmitError::TooLarge`], and those of [`Sampling::new`].
pub(super) fn write(schedule: &Schedule, claims: &Claims) -> Result<Vec<(String, Vec<u8>)>, EmitError> {
    played(schedule, Format::Nidaqmx, Family::DataAcquisition, "cards", SENDER, |wired, number| {
        let InstrumentFacts::DataAcquisition(facts) = &wired.instrument.facts else { return Ok(None) };
        let card = Card::new(wired, facts, claims)?;
        let ending = format!("{}{number}.daq", wired.name);
        Ok(Some((card.listing(&ending), (ending, card.text()?.into_bytes()))))
    })
}

/// A card with the signals of its outputs.
struct Card<'a> {
    wired: &'a WiredInstrument<'a>,
    facts: &'a DataAcquisitionFacts,
    signals: Signals<'a>,
    period_ns: u64,
    /// The channel of each wired line, by port and line.
    lines: BTreeMap<(u32, u32), usize>,
    /// The channel of each wired analog output.
    analog: BTreeMap<u32, usize>,
}

/// Port words by port number, and volts of the analog outputs, at one sample.
#[derive(PartialEq)]
struct CardLevels {
    words: BTreeMap<u32, u32>,
    volts: Vec<f64>,
}

impl<'a> Card<'a> {
    fn new(
        wired: &'a WiredInstrument<'a>,
        facts: &'a DataAcquisitionFacts,
        claims: &Claims,
    ) -> Result<Card<'a>, EmitError> {
        let signals = Signals::new(&wired.schedule);
        EmitError::refuse_ramps(Format::Nidaqmx, &signals)?;
        let (mut lines, mut analog) = (BTreeMap::new(), BTreeMap::new());
        for (channel, drive) in wired.drives.iter().enumerate() {
            match DataAcquisitionFacts::place(&drive.output) {
                Some((Some(port), line)) => drop(lines.insert((port, line), channel)),
                Some((None, output)) => drop(analog.insert(output, channel)),
                None => {}
            }
        }
        if !lines.is_empty() && facts.digital_rate_hz <= 0.0 {
            return Err(EmitError::NoSampleClock { instrument: wired.name.to_owned() });
        }
        let digital_hz = Some(facts.digital_rate_hz).filter(|_| !lines.is_empty());
        let analog_hz = facts.voltage.map(|voltage| voltage.rate_hz).filter(|_| !analog.is_empty());
        let rate_hz = digital_hz.into_iter().chain(analog_hz).fold(f64::INFINITY, f64::min);
        let limits = SampleLimits { points: [2, MOST_SAMPLES], rate_hz, most_ns: None };
        let Sampling { period_ns, points } = Sampling::new(&signals, wired, claims, &limits)?;
        if points > MOST_SAMPLES {
            let (instrument, duration_ns) = (wired.name.to_owned(), signals.schedule.duration_ns);
            let limit = MOST_SAMPLES;
            return Err(EmitError::TooManyPoints {
                instrument,
                points,
                limit,
                period_ns,
                duration_ns,
                most_steps: None,
            });
        }
        Ok(Card { wired, facts, signals, period_ns, lines, analog })
    }

    /// Number of samples of the schedule, without the one of rest.
    fn samples(&self) -> u64 {
        self.signals.schedule.duration_ns.div_ceil(self.period_ns)
    }

    /// The levels at a sample; after the schedule, those of rest.
    fn levels(&self, sample: u64) -> CardLevels {
        let t_ns = (sample * self.period_ns).min(self.signals.schedule.duration_ns);
        let at_output = |channel: usize| self.wired.drives[channel].link.at_output(self.signals.value(channel, t_ns));
        let mut words: BTreeMap<u32, u32> = self.lines.keys().map(|(port, _)| (*port, 0)).collect();
        for ((port, line), channel) in &self.lines {
            if let Some(word) = words.get_mut(port).filter(|_| at_output(*channel) != 0.0) {
                *word |= 1 << line;
            }
        }
        CardLevels { words, volts: self.analog.values().map(|channel| at_output(*channel)).collect() }
    }

    /// The first sample of each run of equal ones: where something changes, or every sample while a stage moves.
    fn changes(&self) -> BTreeSet<u64> {
        let mut changes = BTreeSet::from([0, self.samples()]);
        for actuation in &self.signals.schedule.actuations {
            let [start, end] = [actuation.start_ns, actuation.end_ns()].map(|t_ns| t_ns.div_ceil(self.period_ns));
            changes.extend([start, end]);
            let step = match actuation.swing {
                Some(swing) => (swing.period_ns / 2 / self.period_ns).max(1),
                None if actuation.from != actuation.to => 1,
                None => continue,
            };
            changes.extend((start..end).step_by(step as usize));
        }
        changes
    }

    fn text(&self) -> Result<String, EmitError> {
        let schedule = self.signals.schedule;
        let changes = self.changes();
        let columns = 1 + self.analog.len() as u64 + self.words().count() as u64;
        EmitError::refuse_size(Format::Nidaqmx, changes.len() as u64 * columns * COLUMN_BYTES, MAX_TEXT_BYTES)?;
        let mut text = format!(
            "# {} on {}: stretches of samples, {} ns each; the last one is the state at rest\n",
            one_line(&schedule.name),
            one_line(self.wired.name),
            self.period_ns
        );
        for (channel, drive) in schedule.channels.iter().zip(&self.wired.drives) {
            let _ = writeln!(text, "# {} is {} [{}]", drive.output, channel.name, channel.unit.symbol());
        }
        text.push_str("samples");
        self.words().for_each(|port| text.push_str(&format!("\tport{port}")));
        self.analog.keys().for_each(|output| text.push_str(&format!("\tao{output} [V]")));
        text.push('\n');
        let mut stretch: Option<(u64, CardLevels)> = None;
        for sample in changes.into_iter().filter(|sample| *sample <= self.samples()) {
            let levels = self.levels(sample);
            if let Some((from, last)) = stretch.take() {
                if last == levels && sample < self.samples() {
                    stretch = Some((from, last));
                    continue;
                }
                line(&mut text, sample - from, &last);
            }
            stretch = Some((sample, levels));
        }
        if let Some((_, rest)) = stretch {
            line(&mut text, 1, &rest);
        }
        Ok(text)
    }

    /// The ports with wired lines, in order.
    fn words(&self) -> impl Iterator<Item = u32> {
        self.lines.keys().map(|(port, _)| *port).collect::<BTreeSet<u32>>().into_iter()
    }

    /// Data for the sender.
    fn listing(&self, ending: &str) -> serde_json::Value {
        let lines: Vec<String> = self.lines.keys().map(|(port, line)| format!("port{port}/line{line}")).collect();
        let line_rests: Vec<bool> = self
            .lines
            .values()
            .map(|channel| self.signals.rest_v(*channel).is_some_and(|rest_v| rest_v != 0.0))
            .collect();
        let analog: Vec<serde_json::Value> = self
            .analog
            .iter()
            .map(|(output, channel)| {
                // A stage stays where it is: sending it elsewhere at once could harm what it holds.
                let rest_v =
                    self.signals.rest_v(*channel).map(|rest_v| self.wired.drives[*channel].link.at_output(rest_v));
                serde_json::json!({ "output": format!("ao{output}"), "rest_v": rest_v })
            })
            .collect();
        let peak_v = self.facts.voltage.map_or(0.0, |voltage| voltage.peak_v);
        serde_json::json!({
            "name": self.wired.name,
            "model": self.wired.instrument.model,
            "file": format!("{}.{ending}", self.signals.schedule.name),
            "rate_hz": 1e9 / self.period_ns as f64,
            "samples": self.samples() + 1,
            "lines": lines,
            "line_rests": line_rests,
            "analog": analog,
            "peak_v": peak_v,
            "waits_for_trigger": self.facts.start == Start::Trigger,
            "leads": self.wired.leads,
        })
    }
}

fn line(text: &mut String, samples: u64, levels: &CardLevels) {
    let _ = write!(text, "{samples}");
    levels.words.values().for_each(|word| text.push_str(&format!("\t{word:#010x}")));
    levels.volts.iter().for_each(|volts| text.push_str(&format!("\t{volts}")));
    text.push('\n');
}

#[cfg(test)]
pub(super) mod tests;
