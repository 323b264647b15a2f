//! SCPI: for each waveform generator of the program a script that uploads what its outputs play, and a program that
//! sends them.
//!
//! `<name>.<instrument>.scpi` has the messages to send, each ended by a line feed; samples are IEEE 488.2
//! definite-length blocks, so the file is not text. `<name>.<instrument>.scpi.txt` describes it, since SCPI has no
//! comments. `<name>.scpi.py` sends all scripts with PyVISA, reads the error queue after each message, and starts the
//! instruments. At the end, on an error and on Ctrl-C it switches the outputs off, except those of stages, which keep
//! their voltage. The commands are those of the Keysight 33500 and 33600 series.
//!
//! An output gives the channel's value before the amplifier or the stage driver of its wire. Its codes span the range
//! that it uses, since the instrument allows its full amplitude only to waveforms of the full range; an output with a
//! single value is a DC source. The filter is off: it would ring at edges and swallow drive trains.
//!
//! The sample period is the greatest common divisor of all times, or a fraction of it, so that every edge falls on a
//! sample. One sample at rest comes before the schedule and one after it: a generator waits at its first sample and
//! rests at its last, and an actuator left under voltage burns. An output that does not rest at 0 V stays on as a DC
//! source at the end. A channel of positions waits at its first position and rests at its last one. Straight lines are
//! sampled: between two samples no stage moves by more than `SAMPLE_UM` or, if the instrument's memory is too small for
//! that, than the tolerance of its device; the description gives the distance.
//!
//! If a channel has drive trains, the schedule waits for inputs or people, or several instruments play together, all
//! outputs of the instrument play sequences instead. A train is then one segment with its number of repetitions, and a
//! wait is a segment that holds its value until the next trigger. A trigger counts only after that segment was played
//! to its end, so samples are fine enough to keep it short, as far as rate and memory allow.

mod description;
mod sequence;

use super::error::EmitError;
use super::hold_parts::{self, listing as holds_listing};
use super::sampling::{SampleLimits, Sampling};
use super::wired::{WiredInstrument, wired};
use super::{Format, Signals};
use crate::claims::Claims;
use crate::device::instrument::{Family, InstrumentFacts, Link, Start, WaveformGeneratorFacts, number_after};
use crate::schedule::{ChannelUnit, Schedule};
use sequence::{Sequence, sequence};
use std::collections::BTreeMap;
use std::fmt::Write as _;

/// The code of the highest voltage of an output; its negative is that of the lowest. Codes are sent as signed 16-bit
/// integers, most significant byte first.
const FULL_SCALE: i16 = i16::MAX;

/// Most times that one step repeats its segment.
const MOST_REPEATS: u64 = 1_000_000;

/// Greatest duration of a segment that waits for a trigger, in nanoseconds: short beside the time of a sender's
/// message.
const MOST_WAITING_NS: u64 = 1_000_000;

/// Sample of a segment at which the marker rises: the first that the 33500 series accepts.
const MARKER_POINT: u64 = 4;

/// Sent once at the beginning.
const PREPARE: [&str; 3] = ["*RST", "*CLS", ":FORM:BORD NORM"];

/// Sent for each output that plays a waveform. `{output}` is its number, `{segment}` the name of its waveform,
/// `{block}` the samples, `{rate}` the sample rate, `{span}` the voltage between the lowest and the highest code,
/// `{middle}` the voltage of code 0.
const UPLOAD_WAVEFORM: [&str; 13] = [
    ":SOUR{output}:DATA:VOL:CLE",
    ":SOUR{output}:DATA:ARB:DAC {segment},{block}",
    ":SOUR{output}:FUNC:ARB {segment}",
    ":SOUR{output}:FUNC:ARB:FILT OFF",
    ":SOUR{output}:FUNC:ARB:SRAT {rate}",
    ":OUTP{output}:LOAD INF",
    ":SOUR{output}:VOLT {span}",
    ":SOUR{output}:VOLT:OFFS {middle}",
    ":SOUR{output}:FUNC ARB",
    ":SOUR{output}:BURS:MODE TRIG",
    ":SOUR{output}:BURS:NCYC 1",
    ":TRIG{output}:SOUR {source}",
    ":SOUR{output}:BURS:STAT ON",
];

/// Sent for each output that plays a sequence. The command with `{block}` is sent for each segment, with `{segment}` as
/// its name; elsewhere `{segment}` is the name of the sequence. `{steps}` stands for the sequence.
const UPLOAD_SEQUENCE: [&str; 11] = [
    ":SOUR{output}:DATA:VOL:CLE",
    ":SOUR{output}:DATA:ARB:DAC {segment},{block}",
    ":SOUR{output}:DATA:SEQ {steps}",
    ":SOUR{output}:FUNC:ARB {segment}",
    ":SOUR{output}:FUNC:ARB:FILT OFF",
    ":SOUR{output}:FUNC:ARB:SRAT {rate}",
    ":OUTP{output}:LOAD INF",
    ":SOUR{output}:VOLT {span}",
    ":SOUR{output}:VOLT:OFFS {middle}",
    ":SOUR{output}:FUNC ARB",
    ":TRIG{output}:SOUR {source}",
];

/// Sent for each output with a single value.
const UPLOAD_CONSTANT: [&str; 3] =
    [":OUTP{output}:LOAD INF", ":SOUR{output}:FUNC DC", ":SOUR{output}:VOLT:OFFS {middle}"];

/// Asked after each output: answers `0,"No error"`.
const ASK_ERROR: &str = ":SYST:ERR?";

/// Sent where other instruments begin with this one: its trigger output rises when the outputs begin.
const LEAD: [&str; 2] = [":OUTP:TRIG:SLOP POS", ":OUTP:TRIG ON"];

/// Sent for each output after all uploads.
const SWITCH_ON: &str = ":OUTP{output} ON";

/// Sent for each output at the end and on an error.
const SWITCH_OFF: &str = ":OUTP{output} OFF";

/// Sent instead for an output that does not rest at 0 V: a DC source of `{rest}`, immediately.
const REST: &str = ":SOUR{output}:APPL:DC DEF,DEF,{rest}";

/// Starts the instrument if the sender starts it.
const BEGIN: &str = "*TRG";

/// The sender, with an empty list of schedules at the marker.
const SENDER: &str = include_str!("send.py");

/// The files, each with its ending.
///
/// # Errors
/// [`EmitError::NotWired`], [`EmitError::Ramp`], [`EmitError::TooManyPoints`], and those of [`Sampling::new`].
pub(super) fn write(schedule: &Schedule, claims: &Claims) -> Result<Vec<(String, Vec<u8>)>, EmitError> {
    let mut files = Vec::new();
    let mut plays = Vec::new();
    for wired in wired(Format::Scpi, schedule, Family::WaveformGenerator)? {
        let InstrumentFacts::WaveformGenerator(facts) = &wired.instrument.facts else { continue };
        let generator = Generator::new(&wired, facts, claims)?;
        files.push((format!("{}.scpi", wired.name), generator.script()));
        files.push((format!("{}.scpi.txt", wired.name), generator.description().into_bytes()));
        plays.push(generator.listing());
    }
    files.push(("scpi.py".to_owned(), sender(schedule, &plays).into_bytes()));
    Ok(files)
}

/// The program that sends the scripts; instruments that wait for a trigger come first.
fn sender(schedule: &Schedule, plays: &[serde_json::Value]) -> String {
    let listing = serde_json::json!({
        "name": schedule.name,
        "duration_s": schedule.duration_ns as f64 / 1e9,
        "instruments": plays,
        "holds": holds_listing(schedule),
    });
    hold_parts::sender(SENDER, &listing)
}

/// A waveform generator with the signals of its outputs.
struct Generator<'a> {
    wired: &'a WiredInstrument<'a>,
    facts: &'a WaveformGeneratorFacts,
    signals: Signals<'a>,
    sampling: Sampling,
    /// Whether its outputs play sequences.
    is_sequenced: bool,
    /// By channel.
    outputs: Vec<GeneratorOutput>,
}

/// An output with its voltage range.
struct GeneratorOutput {
    number: u32,
    link: Link,
    low_v: f64,
    high_v: f64,
    playing: Playing,
}

/// Content of an output.
enum Playing {
    /// A single voltage throughout.
    Constant,
    Waveform(Vec<i16>),
    Sequence(Sequence),
}

impl GeneratorOutput {
    /// The output of a channel, without content yet.
    fn new(signals: &Signals, channel: usize, number: u32, link: Link) -> GeneratorOutput {
        let levels = signals.of(channel).iter().flat_map(|actuation| actuation.levels());
        // The resting value counts too.
        let ends = [0, signals.schedule.duration_ns].map(|t_ns| signals.value(channel, t_ns));
        let rest = signals.rest_v(channel);
        let (mut low_v, mut high_v) = (f64::INFINITY, f64::NEG_INFINITY);
        for value in levels.chain(ends).chain(rest) {
            let output_v = link.at_output(value);
            (low_v, high_v) = (low_v.min(output_v), high_v.max(output_v));
        }
        GeneratorOutput { number, link, low_v, high_v, playing: Playing::Constant }
    }

    /// The voltage between the lowest and the highest code.
    fn span_v(&self) -> f64 {
        self.high_v - self.low_v
    }

    /// The voltage of code 0.
    fn middle_v(&self) -> f64 {
        (self.low_v + self.high_v) / 2.0
    }

    /// The code of a value of the channel.
    fn code(&self, value: f64) -> i16 {
        let share = (self.link.at_output(value) - self.middle_v()) / (self.span_v() / 2.0);
        (share * f64::from(FULL_SCALE)).round() as i16
    }
}

impl<'a> Generator<'a> {
    fn new(
        wired: &'a WiredInstrument<'a>,
        facts: &'a WaveformGeneratorFacts,
        claims: &Claims,
    ) -> Result<Generator<'a>, EmitError> {
        let signals = Signals::new(&wired.schedule);
        EmitError::refuse_ramps(Format::Scpi, &signals)?;
        let points = [facts.least_points, facts.most_points].map(u64::from);
        // A waveform begins with a sample of its own; a sequence begins with its trigger, as other instruments do.
        let has_trains = signals.schedule.actuations.iter().any(|actuation| actuation.swing.is_some());
        let is_sequenced = !wired.is_alone || has_trains || !signals.schedule.holds.is_empty();
        let most_ns = is_sequenced.then(|| MOST_WAITING_NS / points[0].max(1));
        let limits = SampleLimits { points, rate_hz: facts.voltage.rate_hz, most_ns };
        let sampling = Sampling::new(&signals, wired, claims, &limits)?;
        let channels = wired.drives.iter().enumerate();
        let outputs = channels.filter_map(|(channel, drive)| {
            let number = number_after("ch", &drive.output)?;
            Some(GeneratorOutput::new(&signals, channel, number, drive.link))
        });
        let outputs = outputs.collect();
        let mut generator = Generator { wired, facts, signals, sampling, is_sequenced, outputs };
        for channel in 0..generator.outputs.len() {
            generator.outputs[channel].playing = generator.playing(channel)?;
        }
        Ok(generator)
    }

    fn playing(&self, channel: usize) -> Result<Playing, EmitError> {
        let output = &self.outputs[channel];
        if output.span_v() <= 0.0 {
            return Ok(Playing::Constant);
        }
        if self.is_sequenced {
            let sequence = sequence(&self.signals, channel, output, self.facts, &self.sampling);
            return sequence
                .map(Playing::Sequence)
                .ok_or_else(|| self.too_long(Some(u64::from(self.facts.most_steps))));
        }
        match self.sampling.points <= u64::from(self.facts.most_points) {
            true => Ok(Playing::Waveform(self.codes(channel))),
            false => Err(self.too_long(None)),
        }
    }

    fn too_long(&self, most_steps: Option<u64>) -> EmitError {
        EmitError::TooManyPoints {
            instrument: self.wired.name.to_owned(),
            points: self.sampling.points,
            limit: u64::from(self.facts.most_points),
            period_ns: self.sampling.period_ns,
            duration_ns: self.signals.schedule.duration_ns,
            most_steps,
        }
    }

    fn codes(&self, channel: usize) -> Vec<i16> {
        let output = &self.outputs[channel];
        match self.signals.unit(channel) {
            ChannelUnit::Volt => {
                let rest = output.code(self.signals.rest_v(channel).unwrap_or_default());
                let mut codes = vec![rest; self.sampling.points as usize];
                for actuation in self.signals.away_from_rest(channel) {
                    let sample = |t_ns: u64| (1 + t_ns / self.sampling.period_ns) as usize;
                    codes[sample(actuation.start_ns)..sample(actuation.end_ns())].fill(output.code(actuation.from));
                }
                codes
            }
            ChannelUnit::Micrometre => {
                let positions = self.sampling.positions(&self.signals, channel);
                positions.map(|position_um| output.code(position_um)).collect()
            }
        }
    }

    fn script(&self) -> Vec<u8> {
        let mut bytes = Vec::new();
        PREPARE.iter().for_each(|command| send(&mut bytes, command.as_bytes()));
        for output in &self.outputs {
            self.upload(&mut bytes, output);
            send(&mut bytes, ASK_ERROR.as_bytes());
        }
        if self.wired.leads {
            LEAD.iter().for_each(|command| send(&mut bytes, command.as_bytes()));
        }
        for output in &self.outputs {
            send(&mut bytes, numbered(SWITCH_ON, output.number).as_bytes());
        }
        send(&mut bytes, ASK_ERROR.as_bytes());
        if self.facts.start == Start::Sender {
            send(&mut bytes, BEGIN.as_bytes());
        }
        bytes
    }

    fn upload(&self, bytes: &mut Vec<u8>, output: &GeneratorOutput) {
        let name = waveform_name(output.number);
        match &output.playing {
            Playing::Constant => {
                UPLOAD_CONSTANT.iter().for_each(|command| self.send(bytes, command, output, &name, &[]));
            }
            Playing::Waveform(codes) => {
                let block = block(codes);
                UPLOAD_WAVEFORM.iter().for_each(|command| self.send(bytes, command, output, &name, &block));
            }
            Playing::Sequence(sequence) => {
                for command in UPLOAD_SEQUENCE {
                    if !command.contains("{block}") {
                        let command = command.replace("{steps}", &steps(sequence, output.number));
                        self.send(bytes, &command, output, &name, &[]);
                        continue;
                    }
                    for (index, samples) in sequence.segments.iter().enumerate() {
                        self.send(bytes, command, output, &segment_name(output.number, index), &block(samples));
                    }
                }
            }
        }
    }

    fn send(&self, bytes: &mut Vec<u8>, command: &str, output: &GeneratorOutput, name: &str, block: &[u8]) {
        let source = match self.facts.start {
            Start::Sender => "BUS",
            Start::Trigger => "EXT",
        };
        let command = numbered(command, output.number)
            .replace("{segment}", name)
            .replace("{span}", &output.span_v().to_string())
            .replace("{middle}", &output.middle_v().to_string())
            .replace("{source}", source)
            .replace("{rate}", &(1e9 / self.sampling.period_ns as f64).to_string());
        match command.split_once("{block}") {
            Some((head, tail)) => send(bytes, &[head.as_bytes(), block, tail.as_bytes()].concat()),
            None => send(bytes, command.as_bytes()),
        }
    }

    /// Data for the sender.
    fn listing(&self) -> serde_json::Value {
        let numbers: Vec<u32> = self.outputs.iter().map(|output| output.number).collect();
        // A stage stays where it is: without the voltage of its output it would run to its zero.
        let stays = |output: &&GeneratorOutput| matches!(output.link, Link::StageDriver { .. });
        let stay_on: Vec<u32> = self.outputs.iter().filter(stays).map(|output| output.number).collect();
        let rests: BTreeMap<String, f64> = (self.outputs.iter().enumerate())
            .filter_map(|(channel, output)| {
                Some((output, self.signals.rest_v(channel).filter(|rest_v| *rest_v != 0.0)?))
            })
            .map(|(output, rest_v)| (output.number.to_string(), output.link.at_output(rest_v)))
            .collect();
        serde_json::json!({
            "name": self.wired.name,
            "model": self.wired.instrument.model,
            "file": format!("{}.{}.scpi", self.signals.schedule.name, self.wired.name),
            "outputs": numbers,
            "stay_on": stay_on,
            "rest_v": rests,
            "starts": self.facts.start == Start::Sender,
        })
    }
}

fn numbered(command: &str, output: u32) -> String {
    command.replace("{output}", &output.to_string())
}

fn send(bytes: &mut Vec<u8>, message: &[u8]) {
    bytes.extend_from_slice(message);
    bytes.push(b'\n');
}

/// The sequence as a definite-length block of text: its name, then name, repetitions, advance mode and marker of each
/// step.
fn steps(sequence: &Sequence, output: u32) -> String {
    let mut text = format!("\"{}\"", waveform_name(output));
    for step in &sequence.steps {
        let (segment, way_on) = (segment_name(output, step.segment), step.control.word());
        let _ = write!(text, ",\"{segment}\",{},{way_on},lowAtStart,{MARKER_POINT}", step.repeats);
    }
    let length = text.len().to_string();
    format!("#{}{length}{text}", length.len())
}

/// The name of an output's waveform or sequence; instruments require it to be short.
fn waveform_name(output: u32) -> String {
    format!("CH{output}")
}

/// The name of a segment of a sequence.
fn segment_name(output: u32, index: usize) -> String {
    format!("{}_{}", waveform_name(output), index + 1)
}

/// IEEE 488.2 clause 7.7.6: `#`, the number of digits, the number of bytes, the bytes.
fn block(codes: &[i16]) -> Vec<u8> {
    let length = (2 * codes.len()).to_string();
    let head = format!("#{}{length}", length.len());
    let samples = codes.iter().flat_map(|code| code.to_be_bytes());
    head.into_bytes().into_iter().chain(samples).collect()
}

#[cfg(test)]
mod tests;
