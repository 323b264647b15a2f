//! G-code in the dialect of LinuxCNC: positions of the stages of a hand on the schedule's clock.
//!
//! If channels are wired to a `machine_controller`, `<name>.<instrument>.ngc` moves the axes that their wires name;
//! places are those of the stages' own travel. Without such an instrument `<name>.<device>.ngc` moves up to three
//! fingers: X Y Z are the axes of the first, U V W of the second, A B C of the third, and places are those of the
//! channels. A hand with more fingers has a file for every three, `<name>.<device>.f1-f3.ngc` and so on, which must be
//! started together. All nine axes are linear and in millimetres. After a rapid move to the start of the schedule, the
//! program pauses (M0); resuming is instant 0 of the schedule. Each line then gives the places of the moving axes at
//! the next common instant. In G93 the feed is one over the minutes that a line takes, so all axes arrive together and
//! in time; G4 waits while nothing moves.
//!
//! A wait for a person is a pause (M0) with its message. A wait for an input is `M66` on the pin that the program
//! names, as `"motion.digital-in-00"`, with its timeout; on timeout the program aborts, and the stages stay where they
//! are.
//!
//! `G64 P` lets the controller round corners by at most half of the hand's `tolerance`, less the corners cut by the
//! servo cycles of a declared controller; planned paths use the other half. Under G61 (exact path) the controller would
//! stop at every corner, and the program would take longer than its schedule. Numbers are whole nanometres. Without
//! wires the machine's accelerations are not considered, and may lengthen its moves. A line slower than the
//! interpreter's least feed is refused.

use super::csv::one_line;
use super::error::{EmitError, MAX_TEXT_BYTES};
use super::wired::{WiredInstrument, wired};
use super::{Format, Signals};
use crate::claims::Claims;
use crate::device::instrument::{
    AXIS_LETTERS, Awaited, Family, InstrumentFacts, Level, Link, MachineControllerFacts, corner_cut_um,
};
use crate::quantity::{Dimension, Quantity};
use crate::schedule::{Channel, ChannelUnit, Schedule, ScheduledHold};
use std::fmt::Write as _;

/// Number of fingers that one file moves.
const FINGERS: usize = 3;

/// Axes per finger; also the size of the groups of letters (X Y Z, U V W, A B C) to one of which a feed applies.
const AXES: usize = AXIS_LETTERS.len() / FINGERS;

/// Estimated bytes of a line, per axis and for the rest.
const WORD_BYTES: u64 = 11;
const LINE_BYTES: u64 = 24;

const NS_PER_MINUTE: f64 = 60e9;

/// The slowest feed of LinuxCNC, in millimetres a minute. Its interpreter raises every G93 feed to this, so a slower
/// line would end early.
const LEAST_FEED_MM_PER_MINUTE: f64 = 0.1;

/// Prefix of the names of digital pins that a program can wait for.
const PIN: &str = "motion.digital-in-";

/// The files, each with the part of its name between the schedule's name and `.ngc`.
///
/// # Errors
/// [`EmitError::NotPositions`] if a channel is not a stage's, or there is none; [`EmitError::Jump`] for a position that
/// jumps; [`EmitError::Unsupported`] for a wait that the controller cannot express, and for a controller together with
/// other instruments; [`EmitError::TooLarge`] past [`MAX_TEXT_BYTES`].
pub(super) fn write(signals: &Signals, claims: &Claims) -> Result<Vec<(String, Vec<u8>)>, EmitError> {
    let mut instruments = signals.schedule.bench.instruments.values();
    match instruments.any(|instrument| instrument.facts.family() == Family::MachineController) {
        true => by_wires(signals.schedule, claims),
        false => by_fingers(signals, claims),
    }
}

/// One file per machine that channels are wired to.
fn by_wires(schedule: &Schedule, claims: &Claims) -> Result<Vec<(String, Vec<u8>)>, EmitError> {
    let mut files = Vec::new();
    for wired in wired(Format::Gcode, schedule, Family::MachineController)? {
        let InstrumentFacts::MachineController(facts) = &wired.instrument.facts else { continue };
        refuse_company(&wired)?;
        let signals = Signals::new(&wired.schedule);
        let waits = &waits(signals.schedule)?;
        EmitError::refuse_jumps(Format::Gcode, &signals)?;
        let letter = |output: &str| AXIS_LETTERS.iter().position(|letter| letter.to_string() == output);
        let axes = wired.drives.iter().enumerate().filter_map(|(channel, drive)| {
            Some(MovedAxis { letter: letter(&drive.output)?, channel, link: Some(drive.link) })
        });
        let mut axes: Vec<MovedAxis> = axes.collect();
        axes.sort_by_key(|axis| axis.letter);
        let rounding_nm = wired_rounding_nm(&signals, facts, claims);
        let (signals, name, machine) = (&signals, wired.name, Some(facts));
        let program = GcodeProgram { signals, name, axes, rounding_nm, machine, waits };
        files.push((wired.name.to_owned(), program.text()?.into_bytes()));
    }
    Ok(files)
}

/// An error for a machine together with other instruments, since only its operator can start it.
fn refuse_company(wired: &WiredInstrument) -> Result<(), EmitError> {
    if wired.is_alone {
        return Ok(());
    }
    Err(EmitError::Unsupported {
        format: Format::Gcode,
        what: format!("`{}` with other instruments: its program starts when the operator resumes it", wired.name),
        help: "wire all channels of the program to it, or its stages to controllers with a trigger".to_owned(),
    })
}

/// One file per three fingers of a device.
fn by_fingers(signals: &Signals, claims: &Claims) -> Result<Vec<(String, Vec<u8>)>, EmitError> {
    refuse_what_is_no_stage(signals)?;
    let waits = &waits(signals.schedule)?;
    EmitError::refuse_jumps(Format::Gcode, signals)?;
    let mut files = Vec::new();
    for (device, _, channels) in signals.devices() {
        let rounding_nm = rounding_nm(claims, device);
        let groups: Vec<&[usize]> = channels.chunks(AXIS_LETTERS.len()).collect();
        for (index, group) in groups.iter().enumerate() {
            let name = match groups.len() {
                1 => device.to_owned(),
                _ => format!("{device}.f{}-f{}", index * FINGERS + 1, index * FINGERS + group.len().div_ceil(AXES)),
            };
            let axes = group.iter().enumerate();
            let axes = axes.map(|(letter, channel)| MovedAxis { letter, channel: *channel, link: None }).collect();
            let program = GcodeProgram { signals, name: device, axes, rounding_nm, machine: None, waits };
            files.push((name, program.text()?.into_bytes()));
        }
    }
    Ok(files)
}

fn refuse_what_is_no_stage(signals: &Signals) -> Result<(), EmitError> {
    let of_volts = |channel: &&Channel| match channel.unit {
        ChannelUnit::Volt => true,
        ChannelUnit::Micrometre => false,
    };
    let channels = &signals.schedule.channels;
    let channel = channels.iter().find(of_volts).map(|channel| channel.name.clone());
    match channel.is_some() || channels.is_empty() {
        true => Err(EmitError::NotPositions { format: Format::Gcode, channel }),
        false => Ok(()),
    }
}

/// How far the controller may deviate from the path of a device, in nanometres: half of the least tolerance of its
/// jobs.
pub(super) fn rounding_nm(claims: &Claims, device: &str) -> u64 {
    (claims.tolerance_um(device).unwrap_or(0.0) / 2.0 * 1000.0).floor() as u64
}

/// As `rounding_nm` for the channels of a machine, less the corners that the straight lines between its servo cycles
/// cut.
fn wired_rounding_nm(signals: &Signals, facts: &MachineControllerFacts, claims: &Claims) -> u64 {
    let of_channel = |(index, channel): (usize, &Channel)| {
        let jumps = signals.schedule.speed_jumps(index).into_iter();
        let cut_um = jumps.map(|jump| corner_cut_um(jump.change_um_per_s, 1.0 / facts.rate_hz)).fold(0.0, f64::max);
        let spare_um = claims.tolerance_um(&channel.device).unwrap_or(0.0) / 2.0;
        ((spare_um - cut_um) * 1000.0).floor().max(0.0) as u64
    };
    signals.schedule.channels.iter().enumerate().map(of_channel).min().unwrap_or(0)
}

/// A wait as G-code: its start and end on the schedule's clock, and its lines.
struct WaitLines {
    start_ns: u64,
    end_ns: u64,
    lines: String,
}

/// The waits of a schedule.
///
/// # Errors
/// [`EmitError::Unsupported`] for an input that is not a digital pin of the motion controller.
fn waits(schedule: &Schedule) -> Result<Vec<WaitLines>, EmitError> {
    schedule
        .holds
        .iter()
        .zip(1..)
        .map(|(hold, number)| {
            let lines = wait_lines(hold, number)?;
            Ok(WaitLines { start_ns: hold.start_ns, end_ns: hold.end_ns(), lines })
        })
        .collect()
}

/// The lines of a wait; `number` makes its label unique.
fn wait_lines(hold: &ScheduledHold, number: usize) -> Result<String, EmitError> {
    let seconds = |ns: u64| format!("{}.{:09}", ns / 1_000_000_000, ns % 1_000_000_000);
    match &hold.terms.awaited {
        Awaited::Person { prompt } if hold.terms.is_bounded => {
            let what =
                format!("the longest time of `{prompt}`: its pause lasts until the operator resumes the program");
            let help = "omit `for at most`, or write another format".to_owned();
            Err(EmitError::Unsupported { format: Format::Gcode, what, help })
        }
        Awaited::Person { prompt } => {
            let text = message(prompt);
            let lines = lines_of(&text).into_iter().map(|line| format!("(MSG, {line})\n"));
            Ok(lines.collect::<String>() + "M0\n")
        }
        Awaited::Input { name, level, .. } => {
            let Some(pin) = pin(name) else {
                let what = format!("the input `{name}`: it reads only digital pins of the motion controller");
                let help = format!("wait for a pin of LinuxCNC, `wait until \"{PIN}00\" for at most 5 s`");
                return Err(EmitError::Unsupported { format: Format::Gcode, what, help });
            };
            let mode = match level {
                Level::High => 3,
                Level::Low => 4,
            };
            let limit = seconds(hold.terms.duration_ns);
            Ok(format!(
                "M66 P{pin} L{mode} Q{limit} ; {} {}\no{number} if [#5399 LT 0]\n(ABORT, {} has not come)\no{number} endif\n",
                ascii(name),
                level.name(),
                message(name)
            ))
        }
    }
}

/// Most characters of a message, since LinuxCNC reads lines of up to 256.
const MESSAGE_CHARACTERS: usize = 200;

/// An ASCII text in lines that LinuxCNC reads, broken at blanks where possible.
fn lines_of(text: &str) -> Vec<&str> {
    let (mut lines, mut rest) = (Vec::new(), text);
    while rest.len() > MESSAGE_CHARACTERS {
        let end = rest[..MESSAGE_CHARACTERS].rfind(' ').filter(|end| *end > 0).unwrap_or(MESSAGE_CHARACTERS);
        lines.push(&rest[..end]);
        rest = rest[end..].trim_start();
    }
    lines.push(rest);
    lines
}

/// The number of a digital pin of the motion controller, as `motion.digital-in-00`.
fn pin(name: &str) -> Option<u32> {
    let digits = name.strip_prefix(PIN)?;
    let is_plain = digits.len() == 2 && digits.bytes().all(|byte| byte.is_ascii_digit());
    digits.parse().ok().filter(|_| is_plain)
}

/// A text inside a comment in parentheses, which ends at the first `)`.
fn message(text: &str) -> String {
    ascii(text).replace(['(', ')'], "_")
}

/// A machine axis and the channel that moves on it.
struct MovedAxis {
    /// Index in [`AXIS_LETTERS`].
    letter: usize,
    channel: usize,
    /// `None` if the position of the axis is that of its channel.
    link: Option<Link>,
}

/// The content of one file.
struct GcodeProgram<'a> {
    signals: &'a Signals<'a>,
    /// Name of the device or the instrument.
    name: &'a str,
    /// In the order of their letters.
    axes: Vec<MovedAxis>,
    /// How far the controller may deviate from the path.
    rounding_nm: u64,
    /// `None` without a wired machine.
    machine: Option<&'a MachineControllerFacts>,
    waits: &'a [WaitLines],
}

impl GcodeProgram<'_> {
    /// The whole file.
    fn text(&self) -> Result<String, EmitError> {
        let mut instants = self.signals.breaks(self.axes.iter().map(|axis| axis.channel));
        let bytes = (instants.len() as u64).saturating_mul(self.axes.len() as u64 * WORD_BYTES + LINE_BYTES);
        EmitError::refuse_size(Format::Gcode, bytes, MAX_TEXT_BYTES)?;
        let mut text = self.header();
        let mut at_nm = self.places_nm(0);
        let _ = writeln!(text, "G0{}\nM0 ; going on is the instant 0 of the schedule", self.words(&at_nm, |_| true));
        let duration_ns = self.signals.schedule.duration_ns;
        instants.extend(self.waits.iter().flat_map(|wait| [wait.start_ns, wait.end_ns]));
        let (mut last_ns, mut still_ns) = (0, 0);
        let inner = instants.into_iter().filter(|t_ns| *t_ns > 0 && *t_ns < duration_ns);
        for t_ns in inner.chain([duration_ns]) {
            if let Some(wait) = self.waits.iter().find(|wait| wait.start_ns <= last_ns && last_ns < wait.end_ns) {
                if wait.start_ns == last_ns {
                    dwell(&mut text, std::mem::take(&mut still_ns));
                    text.push_str(&wait.lines);
                }
                last_ns = t_ns;
                continue;
            }
            let next_nm = self.places_nm(t_ns);
            let moves = |axis: usize| next_nm[axis] != at_nm[axis];
            match (0..self.axes.len()).any(moves) {
                false => still_ns += t_ns - last_ns,
                true => {
                    dwell(&mut text, std::mem::take(&mut still_ns));
                    let feed = NS_PER_MINUTE / (t_ns - last_ns) as f64;
                    self.refuse_crawling(&at_nm, &next_nm, feed)?;
                    let _ = writeln!(text, "G1{} F{feed}", self.words(&next_nm, moves));
                }
            }
            (at_nm, last_ns) = (next_nm, t_ns);
        }
        dwell(&mut text, still_ns);
        text.push_str("M2\n");
        Ok(text)
    }

    /// An error for a line that LinuxCNC would play too fast. The feed of a line applies to the first three letters
    /// among which one moves.
    fn refuse_crawling(&self, at_nm: &[i64], next_nm: &[i64], per_minute: f64) -> Result<(), EmitError> {
        let mut squares = [0.0; FINGERS];
        for (axis, (at, next)) in self.axes.iter().zip(at_nm.iter().zip(next_nm)) {
            let way_mm = (next - at) as f64 / 1e6;
            squares[axis.letter / AXES] += way_mm * way_mm;
        }
        let way_mm = squares.into_iter().map(f64::sqrt).find(|way| *way > 0.0);
        let feed = way_mm.map_or(f64::INFINITY, |way| way * per_minute);
        if feed >= LEAST_FEED_MM_PER_MINUTE {
            return Ok(());
        }
        let [speed, least] = [feed, LEAST_FEED_MM_PER_MINUTE].map(|feed| Quantity::new(feed / 60e3, Dimension::SPEED));
        let times = (LEAST_FEED_MM_PER_MINUTE / feed * 10.0).ceil() / 10.0;
        Err(EmitError::Unsupported {
            format: Format::Gcode,
            what: format!("a finger at {speed}: LinuxCNC plays every line at {least} or more"),
            help: format!("use speeds {times} times as high for the device, or write `--emit csv` or `stages`"),
        })
    }

    /// Instructions for the operator; comments extend from `;` to the end of the line.
    fn header(&self) -> String {
        let schedule = self.signals.schedule;
        let mut text = String::new();
        let mut say = |line: String| {
            let _ = writeln!(text, "; {}", ascii(&line));
        };
        say(format!("{}: stages of {}, written by tweeze {}", schedule.name, self.name, env!("CARGO_PKG_VERSION")));
        say(format!("from {}, SHA-256 {}", schedule.source.file, schedule.source.sha256));
        schedule.source.settings.iter().for_each(|setting| say(format!("with --set {setting}")));
        for axis in &self.axes {
            let Channel { name, wire, .. } = &schedule.channels[axis.channel];
            let behind = match (axis.link, wire) {
                (Some(Link::Axis { origin_um, direction, .. }), _) => {
                    format!(", whose 0 is at {origin_um} um, {}", direction.name())
                }
                (_, Some(wire)) => format!(", wire {wire}"),
                (_, None) => String::new(),
            };
            say(format!("{} is {name}{behind}", AXIS_LETTERS[axis.letter]));
        }
        let period =
            self.machine.map_or_else(|| "millisecond".to_owned(), |facts| format!("{} ms", 1e3 / facts.rate_hz));
        for line in [
            "all axes are linear and in millimetres, A, B and C too; set the machine up so",
            "G93: F is one over the minutes that a line takes, so all axes arrive at the same instant; G4 waits P seconds",
            &format!(
                "the controller needs a command for every axis at least every {period}, a resolution of a nanometre, and accelerations that"
            ),
            "reach each speed within a small part of its line: what it takes longer is late from there on, so watch its lag",
            "the first line is a rapid move to where the schedule begins: see that the way is free",
        ] {
            say(line.to_owned());
        }
        let corners = match (self.rounding_nm, self.machine) {
            (0, _) => "G61 ; exact path: the tolerance of the hand leaves no nanometre for rounding corners".to_owned(),
            (nm, None) => {
                format!("G64 P{} ; corners may be rounded by half of the tolerance of the hand", millimetres(nm))
            }
            (nm, Some(_)) => format!(
                "G64 P{} ; corners may be rounded by half of the tolerance of the hand, less what servo cycles cut",
                millimetres(nm)
            ),
        };
        let _ = writeln!(text, "G21\nG90\n{corners}\nG93");
        text
    }

    /// Positions of the axes at an instant, in whole nanometres.
    fn places_nm(&self, t_ns: u64) -> Vec<i64> {
        let place_um = |axis: &MovedAxis| {
            let value_um = self.signals.value(axis.channel, t_ns);
            axis.link.map_or(value_um, |link| link.at_output(value_um))
        };
        self.axes.iter().map(|axis| (place_um(axis) * 1000.0).round() as i64).collect()
    }

    /// The words of the axes that move, in millimetres.
    fn words(&self, places_nm: &[i64], is_written: impl Fn(usize) -> bool) -> String {
        let mut text = String::new();
        for (index, (axis, place_nm)) in self.axes.iter().zip(places_nm).enumerate() {
            if !is_written(index) {
                continue;
            }
            let sign = if *place_nm < 0 { "-" } else { "" };
            let _ = write!(text, " {}{sign}{}", AXIS_LETTERS[axis.letter], millimetres(place_nm.unsigned_abs()));
        }
        text
    }
}

fn dwell(text: &mut String, still_ns: u64) {
    if still_ns > 0 {
        let _ = writeln!(text, "G4 P{}.{:09}", still_ns / 1_000_000_000, still_ns % 1_000_000_000);
    }
}

/// Whole nanometres as decimal millimetres.
fn millimetres(length_nm: u64) -> String {
    format!("{}.{:06}", length_nm / 1_000_000, length_nm % 1_000_000)
}

/// The text as a comment that every controller accepts.
fn ascii(text: &str) -> String {
    one_line(text).chars().map(|c| if c.is_ascii() { c } else { '_' }).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_long_question_has_lines_that_are_read() {
        assert_eq!(lines_of("go on"), ["go on"]);
        let words = "word ".repeat(100);
        let lines = lines_of(words.trim_end());
        assert!(lines.iter().all(|line| line.len() <= MESSAGE_CHARACTERS && !line.ends_with(' ')), "{lines:?}");
        assert_eq!(lines.join(" "), words.trim_end());
        assert_eq!(lines_of(&"x".repeat(450)).iter().map(|line| line.len()).collect::<Vec<_>>(), [200, 200, 50]);
    }
}
