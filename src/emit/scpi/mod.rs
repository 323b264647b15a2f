//! SCPI: a script that uploads each channel to an arbitrary-waveform generator and plays all of them on one trigger.
//!
//! `<name>.scpi` has the messages to send, each ended by a line feed; samples are IEEE 488.2 definite-length
//! blocks, so the file is no text. SCPI has no comments, so `<name>.scpi.txt` describes which output plays which channel.
//! The differences between instruments are the data of a [`Profile`].
//!
//! The sample period is the greatest common divisor of all times, so that every edge falls on a sample. One sample of 0 V
//! comes before the schedule and one after it: a generator waits at its first sample and rests at its last, and an actuator
//! left under voltage burns.
//!
//! Where a channel has drive trains, all outputs play sequences instead, in the dialect of the 33500 series: a train is one
//! segment and the number of its repetitions. A sequence waits for its trigger at 0 V and rests at 0 V.
//!
//! A channel of positions is the voltage at the analogue input of a stage's driver, 1 V per um, to be scaled to the driver's
//! sensitivity. A generator has no straight lines, so they are sampled: each sample is the position of the stage, and
//! between two samples no stage moves by more than `sampling::SAMPLE_UM` unless the instrument's memory is too small for that; the
//! description gives the distance. It waits at the first position and rests at the last one.

mod sampling;
mod sequence;

use super::csv::one_line;
use super::error::EmitError;
use super::{Format, Signals};
use crate::schedule::ChannelUnit;
use sampling::Sampling;
pub use sequence::Sequencer;
use sequence::{Sequence, sequence};
use std::fmt::Write as _;

/// Limits and commands of an instrument.
///
/// In the commands `{output}` is the number of the output, `{segment}` for the name of its waveform, `{block}` for the
/// samples, `{span}` for the voltage between the lowest and the highest code, `{seconds}` for the length of the waveform.
#[derive(Debug, Clone)]
pub struct Profile {
    pub name: &'static str,
    /// Outputs that play at the same time.
    pub outputs: usize,
    /// Fewest points of a waveform; shorter ones are filled up with 0 V.
    pub least_points: u64,
    /// Most points of a waveform, or of all segments of a sequence.
    pub most_points: u64,
    /// The code of full scale; its negative is that of negative full scale. At most 32767: codes travel as 16 bits, signed,
    /// most significant byte first.
    pub full_scale: i16,
    /// Sent once at the beginning.
    pub prepare: &'static [&'static str],
    /// Sent for each output; the block command among them.
    pub upload: &'static [&'static str],
    /// For schedules with drive trains, instead of `upload`.
    pub sequencer: Sequencer,
    /// Asked after each upload: answers `0,"No error"`.
    pub ask_error: &'static str,
    /// Sent for each output, when all uploads are done.
    pub arm: &'static [&'static str],
    /// Sent once at the end, to begin.
    pub start: &'static [&'static str],
}

/// A plain instrument of the 16-bit sort. Its commands are the widespread ones; a lab compares them with its manual.
pub const GENERIC: Profile = Profile {
    name: "generic 16 bit",
    outputs: 4096,
    least_points: 8,
    most_points: 1_000_000,
    full_scale: i16::MAX,
    prepare: &["*RST", "*CLS", ":FORM:BORD NORM"],
    upload: &[
        ":SOUR{output}:DATA:VOL:CLE",
        ":SOUR{output}:DATA:ARB:DAC {segment},{block}",
        ":SOUR{output}:FUNC:ARB {segment}",
        ":SOUR{output}:FUNC:ARB:PER {seconds}",
        ":OUTP{output}:LOAD INF",
        ":SOUR{output}:VOLT {span}",
        ":SOUR{output}:VOLT:OFFS 0",
        ":SOUR{output}:FUNC ARB",
        ":SOUR{output}:BURS:MODE TRIG",
        ":SOUR{output}:BURS:NCYC 1",
        ":TRIG{output}:SOUR BUS",
        ":SOUR{output}:BURS:STAT ON",
    ],
    sequencer: Sequencer {
        most_steps: 512,
        most_repeats: 1_000_000,
        upload: &[
            ":SOUR{output}:DATA:VOL:CLE",
            ":SOUR{output}:DATA:ARB:DAC {segment},{block}",
            ":SOUR{output}:DATA:SEQ {steps}",
            ":SOUR{output}:FUNC:ARB {segment}",
            ":SOUR{output}:FUNC:ARB:SRAT {rate}",
            ":SOUR{output}:FUNC:ARB:FILT STEP",
            ":OUTP{output}:LOAD INF",
            ":SOUR{output}:VOLT {span}",
            ":SOUR{output}:VOLT:OFFS 0",
            ":SOUR{output}:FUNC ARB",
            ":TRIG{output}:SOUR BUS",
        ],
    },
    ask_error: ":SYST:ERR?",
    arm: &[":OUTP{output} ON"],
    start: &["*TRG"],
};

/// Where in a segment the marker rises: the first sample that the 33500 series takes.
const MARKER_POINT: u64 = 4;

impl Profile {
    /// The code of a voltage, where full scale is `volts`.
    fn code(&self, value: f64, volts: f64) -> i16 {
        (value / volts * f64::from(self.full_scale)).round() as i16
    }
}

/// The waveforms of the outputs, one entry for each channel where they play sequences.
enum Playing {
    Waveforms,
    Sequences(Vec<Sequence>),
}

/// Values of the placeholders of a command.
struct Filling<'a> {
    channel: usize,
    segment: &'a str,
    volts: f64,
    sampling: &'a Sampling,
}

/// The script and its description.
///
/// # Errors
/// [`EmitError::Ramp`], [`EmitError::TooManyPoints`], [`EmitError::TooManyOutputs`].
pub(super) fn write(signals: &Signals, profile: &Profile) -> Result<[Vec<u8>; 2], EmitError> {
    EmitError::refuse_ramps(Format::Scpi, signals)?;
    let channels = signals.schedule.channels.len();
    if channels > profile.outputs {
        return Err(EmitError::TooManyOutputs { channels, limit: profile.outputs });
    }
    let sampling = Sampling::new(signals, profile);
    let playing = playing(signals, profile, &sampling)?;
    let description = description(signals, profile, &sampling, &playing);
    Ok([script(signals, profile, &sampling, &playing), description.into_bytes()])
}

fn playing(signals: &Signals, profile: &Profile, sampling: &Sampling) -> Result<Playing, EmitError> {
    let swings = signals.schedule.actuations.iter().any(|actuation| actuation.swing.is_some());
    let refused = |most_steps| EmitError::TooManyPoints {
        points: sampling.points,
        limit: profile.most_points,
        period_ns: sampling.period_ns,
        duration_ns: signals.schedule.duration_ns,
        most_steps,
    };
    if !swings {
        return if sampling.points > profile.most_points { Err(refused(None)) } else { Ok(Playing::Waveforms) };
    }
    let of_channel = |channel| sequence(signals, channel, full_scale_volts(signals, channel), profile, sampling);
    let sequences: Option<Vec<Sequence>> = (0..signals.schedule.channels.len()).map(of_channel).collect();
    sequences.map(Playing::Sequences).ok_or_else(|| refused(Some(profile.sequencer.most_steps as u64)))
}

fn script(signals: &Signals, profile: &Profile, sampling: &Sampling, playing: &Playing) -> Vec<u8> {
    let mut bytes = Vec::new();
    let channels = signals.schedule.channels.len();
    profile.prepare.iter().for_each(|command| send(&mut bytes, command.as_bytes()));
    for channel in 0..channels {
        let volts = full_scale_volts(signals, channel);
        let filling = Filling { channel, segment: &segment(channel), volts, sampling };
        match playing {
            Playing::Waveforms => {
                let block = block(&codes(signals, channel, volts, profile, sampling));
                profile.upload.iter().for_each(|command| filling.send(&mut bytes, command, &block));
            }
            Playing::Sequences(sequences) => upload(&mut bytes, &sequences[channel], profile, &filling),
        }
        send(&mut bytes, profile.ask_error.as_bytes());
    }
    for command in profile.arm {
        for channel in 0..channels {
            let filling = Filling { channel, segment: &segment(channel), volts: 0.0, sampling };
            filling.send(&mut bytes, command, &[]);
        }
    }
    send(&mut bytes, profile.ask_error.as_bytes());
    profile.start.iter().for_each(|command| send(&mut bytes, command.as_bytes()));
    bytes
}

fn send(bytes: &mut Vec<u8>, message: &[u8]) {
    bytes.extend_from_slice(message);
    bytes.push(b'\n');
}

fn upload(bytes: &mut Vec<u8>, sequence: &Sequence, profile: &Profile, filling: &Filling) {
    for command in profile.sequencer.upload {
        if command.contains("{block}") {
            for (index, samples) in sequence.segments.iter().enumerate() {
                let segment = &part(filling.channel, index);
                Filling { segment, ..*filling }.send(bytes, command, &block(samples));
            }
        } else {
            filling.send(bytes, &command.replace("{steps}", &steps(sequence, filling.channel)), &[]);
        }
    }
}

/// The sequence as a definite-length block of text: its name, then name, repetitions, advance mode and marker of each step.
fn steps(sequence: &Sequence, channel: usize) -> String {
    let mut text = format!("\"{}\"", segment(channel));
    for step in &sequence.steps {
        let (part, way_on) = (part(channel, step.segment), step.control.word());
        let _ = write!(text, ",\"{part}\",{},{way_on},lowAtStart,{MARKER_POINT}", step.repeats);
    }
    let length = text.len().to_string();
    format!("#{}{length}{text}", length.len())
}

impl Filling<'_> {
    fn send(&self, bytes: &mut Vec<u8>, command: &str, block: &[u8]) {
        let command = command
            .replace("{output}", &(self.channel + 1).to_string())
            .replace("{segment}", self.segment)
            .replace("{span}", &(2.0 * self.volts).to_string())
            .replace("{seconds}", &seconds(self.sampling.points * self.sampling.period_ns))
            .replace("{rate}", &(1e9 / self.sampling.period_ns as f64).to_string());
        match command.split_once("{block}") {
            Some((head, tail)) => send(bytes, &[head.as_bytes(), block, tail.as_bytes()].concat()),
            None => send(bytes, command.as_bytes()),
        }
    }
}

/// The waveform's name: short, as instruments ask for it.
fn segment(channel: usize) -> String {
    format!("CH{}", channel + 1)
}

/// The name of a segment of a sequence.
fn part(channel: usize, index: usize) -> String {
    format!("{}_{}", segment(channel), index + 1)
}

fn seconds(t_ns: u64) -> String {
    format!("{}.{:09}", t_ns / 1_000_000_000, t_ns % 1_000_000_000)
}

/// The largest voltage or position of a channel in either direction, or 1 V where it is never driven.
fn full_scale_volts(signals: &Signals, channel: usize) -> f64 {
    let levels = signals.of(channel).iter().flat_map(|actuation| [actuation.from, actuation.to]);
    let largest = levels.map(f64::abs).fold(0.0, f64::max);
    if largest > 0.0 { largest } else { 1.0 }
}

fn codes(signals: &Signals, channel: usize, volts: f64, profile: &Profile, sampling: &Sampling) -> Vec<i16> {
    match signals.unit(channel) {
        ChannelUnit::Volt => codes_of_voltages(signals, channel, volts, profile, sampling),
        ChannelUnit::Micrometre => {
            let positions = sampling.positions(signals, channel);
            positions.map(|position_um| profile.code(position_um, volts)).collect()
        }
    }
}

fn codes_of_voltages(
    signals: &Signals,
    channel: usize,
    volts: f64,
    profile: &Profile,
    sampling: &Sampling,
) -> Vec<i16> {
    let mut codes = vec![0; sampling.points as usize];
    for actuation in signals.of(channel) {
        let [first, end] =
            [actuation.start_ns, actuation.end_ns()].map(|t_ns| (1 + t_ns / sampling.period_ns) as usize);
        codes[first..end].fill(profile.code(actuation.from, volts));
    }
    codes
}

/// IEEE 488.2 clause 7.7.6: `#`, the number of digits, the number of bytes, the bytes.
fn block(codes: &[i16]) -> Vec<u8> {
    let length = (2 * codes.len()).to_string();
    let head = format!("#{}{length}", length.len());
    let samples = codes.iter().flat_map(|code| code.to_be_bytes());
    head.into_bytes().into_iter().chain(samples).collect()
}

fn description(signals: &Signals, profile: &Profile, sampling: &Sampling, playing: &Playing) -> String {
    let schedule = signals.schedule;
    let name = &schedule.name;
    let mut text = format!(
        "{name}.scpi holds what to send to an arbitrary-waveform generator ({}), message by message, each\n\
         ended by a line feed. Samples are IEEE 488.2 definite-length blocks: 16 bit, signed, most significant byte first.\n\
         Read the answer to every {} before sending on; anything but 0 means that the instrument refused a message.\n\
         Compare the commands with your instrument's manual, connect the actuators last, and try at a low voltage first.\n\
         Voltages are those of an output without load. Where an amplifier stands between output and actuator, divide each\n\
         VOLT by its gain; generators rarely give the current that an actuator draws.\n{}\n\
         {} All outputs begin on {}.\n\
         Several instruments: send each its own messages, then trigger them from one line (EXT) instead of BUS.\n\n\
         output\tsegment\tfull scale [V]\tchannel\twire\n",
        profile.name,
        profile.ask_error,
        stages(signals, sampling),
        playback(signals, sampling, playing),
        profile.start.join(" "),
    );
    for (index, channel) in schedule.channels.iter().enumerate() {
        let wire = channel.wire.as_deref().map_or_else(|| "-".to_owned(), one_line);
        let volts = full_scale_volts(signals, index);
        let mark = match channel.unit {
            ChannelUnit::Volt => "",
            ChannelUnit::Micrometre => " [um]",
        };
        let _ = writeln!(text, "{}\t{}\t{volts}\t{}{mark}\t{wire}", index + 1, segment(index), channel.name);
    }
    if let Playing::Sequences(sequences) = playing {
        text.push_str("\noutput\tstep\tsegment\tpoints\ttimes\tgoes on\tfirst sample\n");
        sequences.iter().enumerate().for_each(|(channel, sequence)| list(&mut text, channel, sequence));
    }
    text
}

/// How to read the outputs of positions.
fn stages(signals: &Signals, sampling: &Sampling) -> String {
    let Some(step_um) = sampling.step_um(signals) else { return String::new() };
    format!(
        "\nOutputs of positions, whose channels are marked um in the table, give 1 V for each micrometre: multiply their VOLT by the volts\n\
         that the stage's driver takes for a micrometre, and set VOLT:OFFS where its zero lies elsewhere. They wait at the first position\n\
         and rest at the last one. Straight lines are sampled: a stage moves by {step_um} um at the most from one sample to the next.\n"
    )
}

/// Duration of the playback, and how the outputs wait and rest.
fn playback(signals: &Signals, sampling: &Sampling, playing: &Playing) -> String {
    let Sampling { period_ns, points } = sampling;
    match playing {
        Playing::Waveforms => format!(
            "Sample period {period_ns} ns, {points} points, {} s in all. The schedule begins at the second sample: the first and the last\n\
             are 0 V, or where a stage is, because an output waits at its first sample and rests at its last.",
            seconds(points * period_ns),
        ),
        Playing::Sequences(_) => format!(
            "Each output plays a sequence: segments one after the other, each so many times, as the table at the end lists them.\n\
             Sample period {period_ns} ns; the schedule lasts {} s and begins when the trigger comes, at the second step: the first and\n\
             the last segment are 0 V, or where a stage is; there an output waits for its trigger and rests when all is played.",
            seconds(signals.schedule.duration_ns),
        ),
    }
}

/// The steps of a sequence; samples count from the trigger.
fn list(text: &mut String, channel: usize, sequence: &Sequence) {
    let mut sample = 0;
    for (number, step) in (1..).zip(&sequence.steps) {
        let (name, points) = (part(channel, step.segment), sequence.segments[step.segment].len() as u64);
        let _ = write!(text, "{}\t{number}\t{name}\t{points}\t{}\t", channel + 1, step.repeats);
        let _ = writeln!(
            text,
            "{}\t{}",
            step.control.word(),
            if number == 1 { "-".to_owned() } else { sample.to_string() }
        );
        sample += if number == 1 { 0 } else { points * step.repeats };
    }
}
