//! SCPI: a script that uploads each channel to an arbitrary-waveform generator and plays all of them on one trigger.
//!
//! `<name>.scpi` is what to send, message by message, each ended by a line feed; samples travel as IEEE 488.2 definite-length
//! blocks, so the file is no text. SCPI knows no comments, so `<name>.scpi.txt` says in words which output plays which channel.
//! What differs between instruments is the data of a [`Profile`].
//!
//! The sample period is the greatest common divisor of all times, so that every edge falls on a sample. One sample of 0 V
//! comes before the schedule and one after it: a generator waits at its first sample and rests at its last, and an actuator
//! left under voltage burns.

use super::csv::one_line;
use super::error::EmitError;
use super::{Format, Signals};
use std::fmt::Write as _;

/// What an instrument takes, and how it is spoken to.
///
/// In the commands `{output}` stands for the number of the output, `{segment}` for the name of its waveform, `{block}` for the
/// samples, `{span}` for the voltage between the lowest and the highest code, `{seconds}` for the length of the waveform.
#[derive(Debug, Clone)]
pub struct Profile {
    pub name: &'static str,
    /// Outputs that play at the same time.
    pub outputs: usize,
    /// Fewest points of a waveform; shorter ones are filled up with 0 V.
    pub least_points: u64,
    /// Most points of a waveform.
    pub most_points: u64,
    /// The code of full scale; its negative is that of negative full scale. At most 32767: codes travel as 16 bits, signed,
    /// most significant byte first.
    pub full_scale: i16,
    /// Sent once at the beginning.
    pub prepare: &'static [&'static str],
    /// Sent for each output; the block command among them.
    pub upload: &'static [&'static str],
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
    ask_error: ":SYST:ERR?",
    arm: &[":OUTP{output} ON"],
    start: &["*TRG"],
};

/// The samples of all channels, before they are scaled.
struct Sampling {
    period_ns: u64,
    /// With the samples of 0 V at both ends.
    points: u64,
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
    let sampling = sampling(signals, profile)?;
    Ok([script(signals, profile, &sampling), description(signals, profile, &sampling).into_bytes()])
}

fn sampling(signals: &Signals, profile: &Profile) -> Result<Sampling, EmitError> {
    let schedule = signals.schedule;
    let times = schedule.actuations.iter().flat_map(|actuation| [actuation.start_ns, actuation.end_ns()]);
    let period_ns = times.fold(schedule.duration_ns, gcd).max(1);
    let points = schedule.duration_ns / period_ns + 2;
    if points > profile.most_points {
        let (limit, duration_ns) = (profile.most_points, schedule.duration_ns);
        return Err(EmitError::TooManyPoints { points, limit, period_ns, duration_ns });
    }
    Ok(Sampling { period_ns, points: points.max(profile.least_points) })
}

fn gcd(mut a: u64, mut b: u64) -> u64 {
    while b > 0 {
        (a, b) = (b, a % b);
    }
    a
}

fn script(signals: &Signals, profile: &Profile, sampling: &Sampling) -> Vec<u8> {
    let mut bytes = Vec::new();
    let mut send = |message: &[u8]| {
        bytes.extend_from_slice(message);
        bytes.push(b'\n');
    };
    let channels = signals.schedule.channels.len();
    profile.prepare.iter().for_each(|command| send(command.as_bytes()));
    for channel in 0..channels {
        let volts = full_scale_volts(signals, channel);
        let block = block(&codes(signals, channel, volts, profile, sampling));
        for command in profile.upload {
            let command = filled(command, channel, volts, sampling);
            match command.split_once("{block}") {
                Some((head, tail)) => send(&[head.as_bytes(), &block, tail.as_bytes()].concat()),
                None => send(command.as_bytes()),
            }
        }
        send(profile.ask_error.as_bytes());
    }
    for command in profile.arm {
        (0..channels).for_each(|channel| send(filled(command, channel, 0.0, sampling).as_bytes()));
    }
    send(profile.ask_error.as_bytes());
    profile.start.iter().for_each(|command| send(command.as_bytes()));
    bytes
}

fn filled(command: &str, channel: usize, volts: f64, sampling: &Sampling) -> String {
    command
        .replace("{output}", &(channel + 1).to_string())
        .replace("{segment}", &segment(channel))
        .replace("{span}", &(2.0 * volts).to_string())
        .replace("{seconds}", &seconds(sampling.points * sampling.period_ns))
}

/// The waveform's name: short, as instruments ask for it.
fn segment(channel: usize) -> String {
    format!("CH{}", channel + 1)
}

fn seconds(t_ns: u64) -> String {
    format!("{}.{:09}", t_ns / 1_000_000_000, t_ns % 1_000_000_000)
}

/// The largest voltage of a channel in either direction, or 1 V where it is never driven.
fn full_scale_volts(signals: &Signals, channel: usize) -> f64 {
    let largest = signals.of(channel).iter().map(|actuation| actuation.from.abs()).fold(0.0, f64::max);
    if largest > 0.0 { largest } else { 1.0 }
}

fn codes(signals: &Signals, channel: usize, volts: f64, profile: &Profile, sampling: &Sampling) -> Vec<i16> {
    let mut codes = vec![0; sampling.points as usize];
    for actuation in signals.of(channel) {
        let [first, end] =
            [actuation.start_ns, actuation.end_ns()].map(|t_ns| (1 + t_ns / sampling.period_ns) as usize);
        let code = (actuation.from / volts * f64::from(profile.full_scale)).round() as i16;
        codes[first..end].fill(code);
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

fn description(signals: &Signals, profile: &Profile, sampling: &Sampling) -> String {
    let schedule = signals.schedule;
    let name = &schedule.name;
    let mut text = format!(
        "{name}.scpi holds what to send to an arbitrary-waveform generator ({}), message by message, each\n\
         ended by a line feed. Samples are IEEE 488.2 definite-length blocks: 16 bit, signed, most significant byte first.\n\
         Read the answer to every {} before sending on; anything but 0 means that the instrument refused a message.\n\
         Compare the commands with your instrument's manual, connect the actuators last, and try at a low voltage first.\n\
         Voltages are those of an output without load. Where an amplifier stands between output and actuator, divide each\n\
         VOLT by its gain; generators rarely give the current that an actuator draws.\n\n\
         Sample period {} ns, {} points, {} s in all. The schedule begins at the second sample: the first and the last\n\
         are 0 V, because an output waits at its first sample and rests at its last. All outputs begin on {}.\n\
         Several instruments: send each its own messages, then trigger them from one line (EXT) instead of BUS.\n\n\
         output\tsegment\tfull scale [V]\tchannel\twire\n",
        profile.name,
        profile.ask_error,
        sampling.period_ns,
        sampling.points,
        seconds(sampling.points * sampling.period_ns),
        profile.start.join(" "),
    );
    for (index, channel) in schedule.channels.iter().enumerate() {
        let wire = channel.wire.as_deref().map_or_else(|| "-".to_owned(), one_line);
        let volts = full_scale_volts(signals, index);
        let _ = writeln!(text, "{}\t{}\t{volts}\t{}\t{wire}", index + 1, segment(index), channel.name);
    }
    text
}
