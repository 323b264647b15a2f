//! Frames for the drivers of electrode boards: for each driver of the program the electrodes that are on, frame by
//! frame, and a program that plays them.
//!
//! `<name>.<driver>.frames.csv` has a row for each frame: its number from 1, its start and duration in milliseconds,
//! and the numbers of the channels that are on, separated by blanks. If magnets or heaters of the driver are wired,
//! those that are on stand in a column of their own, as `magnet1 heater1=60` with the temperature in degrees Celsius.
//! Frames follow each other without a gap from 0 to the end of the schedule; two neighbours differ. `<name>.frames.py`
//! plays them on an OpenDrop (frames of 32 bytes over USB serial), a PurpleDrop (JSON-RPC calls) or a DropBot (calls of
//! its Python package). At the end, on an error and on Ctrl-C it switches off all electrodes except those that rest on.
//! If the pads of reservoirs are not among the channels of a board, it says when a droplet is due at which outlet.
//! Where the schedule waits for an input or a person, frames cover the longest wait; the sender goes on from the end of
//! the wait as soon as its event occurs.
//!
//! `<name>.<driver>.opendrop.json`, a format of its own, is for the program that comes with an OpenDrop. It has no
//! times, so each frame is repeated as often as the common period of all durations fits into its own.

use super::error::{EmitError, MAX_TEXT_BYTES};
use super::hold_parts::{listing as holds_listing, sender};
use super::wired::{WiredInstrument, wired};
use super::{Format, Signals};
use crate::device::instrument::{ElectrodeDriverFacts, Family, InstrumentFacts, Link, Protocol, number_after};
use crate::schedule::{Schedule, common_divisor_ns};
use serde_json::json;
use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Write as _;

/// The sender, with an empty list of drivers at the marker.
const SENDER: &str = include_str!("send.py");

/// Estimated bytes of a row without its channels, and of a channel.
const ROW_BYTES: u64 = 32;
const CHANNEL_BYTES: u64 = 4;

/// Electrodes in a column of an OpenDrop: the bits of a byte.
const OPENDROP_ROWS: u32 = 8;

/// Most frames that the program loads.
const OPENDROP_FRAMES: u64 = 200;

/// Characters of a row in the file of OpenDrop's program, one per column: 16 of electrodes, and 2 that are never set.
const OPENDROP_CHARACTERS: u32 = 18;

/// The files, each with its ending; `dispensed` are the droplets that a person puts onto the boards.
///
/// # Errors
/// [`EmitError::NotWired`], [`EmitError::Ramp`], [`EmitError::Unsupported`], [`EmitError::TooLarge`].
pub(super) fn write(schedule: &Schedule, dispensed: &[serde_json::Value]) -> Result<Vec<(String, Vec<u8>)>, EmitError> {
    let mut files = Vec::new();
    let mut plays = Vec::new();
    for wired in wired(Format::Frames, schedule, Family::ElectrodeDriver)? {
        let InstrumentFacts::ElectrodeDriver(facts) = &wired.instrument.facts else { continue };
        let board = FramedBoard::new(&wired, facts)?;
        files.push((format!("{}.frames.csv", wired.name), board.text()?.into_bytes()));
        plays.push(board.listing()?);
    }
    let listing = json!({
        "name": schedule.name,
        "duration_s": schedule.duration_ns as f64 / 1e9,
        "drivers": plays,
        "dispensed": dispensed,
        "holds": holds_listing(schedule),
    });
    files.push(("frames.py".to_owned(), sender(SENDER, &listing).into_bytes()));
    Ok(files)
}

/// The files for the program that comes with an OpenDrop, each with its ending.
///
/// # Errors
/// [`EmitError::NotWired`], [`EmitError::Ramp`], [`EmitError::Unsupported`], [`EmitError::TooManyFrames`].
pub(super) fn write_opendrop(schedule: &Schedule) -> Result<Vec<(String, Vec<u8>)>, EmitError> {
    let mut files = Vec::new();
    for wired in wired(Format::Opendrop, schedule, Family::ElectrodeDriver)? {
        let InstrumentFacts::ElectrodeDriver(facts) = &wired.instrument.facts else { continue };
        match facts.protocol {
            Protocol::Opendrop => {
                let board = FramedBoard::new(&wired, facts)?;
                board.refuse_rest(Format::Opendrop)?;
                board.refuse_accessories()?;
                let text = board.controller_file()?;
                files.push((format!("{}.opendrop.json", wired.name), text.into_bytes()));
            }
            Protocol::Purpledrop | Protocol::Dropbot => {}
        }
    }
    let none = || EmitError::OtherProtocol { format: Format::Opendrop, name: schedule.name.clone() };
    if files.is_empty() { Err(none()) } else { Ok(files) }
}

/// The channels that a driver has on during an interval.
#[derive(Clone)]
pub(super) struct Frame {
    pub(super) start_ns: u64,
    pub(super) end_ns: u64,
    /// Channel numbers, in order.
    pub(super) on: BTreeSet<u32>,
    /// Magnets and heaters.
    accessories: BTreeSet<Accessory>,
}

/// A magnet or heater of a driver, as written in the table of frames: `magnet1`, `heater1=60`.
type Accessory = String;

/// The object that an output switches.
enum Switched {
    Electrodes(u32),
    Accessory(Accessory),
}

impl Switched {
    /// The object behind an output of a driver.
    fn of(output: &str, facts: &ElectrodeDriverFacts) -> Switched {
        match (number_after("c", output), facts.heats_to_degc(output)) {
            (Some(number), _) => Switched::Electrodes(number),
            (None, Some(degc)) => Switched::Accessory(format!("{output}={degc}")),
            (None, None) => Switched::Accessory(output.to_owned()),
        }
    }
}

impl Frame {
    fn switch(&mut self, output: &Switched, is_on: bool) {
        match (output, is_on) {
            (Switched::Electrodes(number), true) => drop(self.on.insert(*number)),
            (Switched::Electrodes(number), false) => drop(self.on.remove(number)),
            (Switched::Accessory(name), true) => drop(self.accessories.insert(name.clone())),
            (Switched::Accessory(name), false) => drop(self.accessories.remove(name)),
        }
    }
}

/// A driver with its frames.
pub(super) struct FramedBoard<'a> {
    pub(super) wired: &'a WiredInstrument<'a>,
    pub(super) facts: &'a ElectrodeDriverFacts,
    pub(super) frames: Vec<Frame>,
    /// Channels that are on before and after the schedule; its times are not used.
    resting: Frame,
    /// Whether magnets or heaters are wired.
    has_accessories: bool,
}

impl<'a> FramedBoard<'a> {
    pub(super) fn new(
        wired: &'a WiredInstrument<'a>,
        facts: &'a ElectrodeDriverFacts,
    ) -> Result<FramedBoard<'a>, EmitError> {
        EmitError::refuse_ramps(Format::Frames, &Signals::new(&wired.schedule))?;
        let switched: Vec<Switched> = wired.drives.iter().map(|drive| Switched::of(&drive.output, facts)).collect();
        let mut resting = Frame { start_ns: 0, end_ns: 0, on: BTreeSet::new(), accessories: BTreeSet::new() };
        for (output, channel) in switched.iter().zip(&wired.schedule.channels) {
            resting.switch(output, channel.rest_v != 0.0);
        }
        // By instant, the outputs whose actuations end, and those whose actuations begin, each with whether it is on
        // then.
        let mut changes: BTreeMap<u64, [Vec<(&Switched, bool)>; 2]> = BTreeMap::new();
        for actuation in &wired.schedule.actuations {
            let channel = actuation.channel as usize;
            let (Some(output), Some(own)) = (switched.get(channel), wired.schedule.channels.get(channel)) else {
                continue;
            };
            changes.entry(actuation.start_ns).or_default()[1].push((output, actuation.from != 0.0));
            changes.entry(actuation.end_ns()).or_default()[0].push((output, own.rest_v != 0.0));
        }
        changes.entry(wired.schedule.duration_ns).or_default();
        let mut frames: Vec<Frame> = Vec::new();
        let mut now = resting.clone();
        for (at_ns, [ended, begun]) in changes {
            if at_ns > now.start_ns {
                match frames.last_mut().filter(|last| last.on == now.on && last.accessories == now.accessories) {
                    Some(last) => last.end_ns = at_ns,
                    None => frames.push(Frame { end_ns: at_ns, ..now.clone() }),
                }
                now.start_ns = at_ns;
            }
            ended.into_iter().chain(begun).for_each(|(output, is_on)| now.switch(output, is_on));
        }
        let has_accessories = switched.iter().any(|output| matches!(output, Switched::Accessory(_)));
        Ok(FramedBoard { wired, facts, frames, resting, has_accessories })
    }

    /// The table of frames.
    fn text(&self) -> Result<String, EmitError> {
        let channels: usize = self.frames.iter().map(|frame| frame.on.len()).sum();
        let accessories = self.frames.iter().flat_map(|frame| &frame.accessories).map(|name| name.len() as u64 + 1);
        let bytes = self.frames.len() as u64 * ROW_BYTES + channels as u64 * CHANNEL_BYTES + accessories.sum::<u64>();
        EmitError::refuse_size(Format::Frames, bytes, MAX_TEXT_BYTES)?;
        let title = if self.has_accessories { ",accessories" } else { "" };
        let mut text = format!("frame,start [ms],duration [ms],on{title}\n");
        for (frame, number) in self.frames.iter().zip(1..) {
            let on: Vec<String> = frame.on.iter().map(u32::to_string).collect();
            let (start, lasts) = (ms(frame.start_ns), ms(frame.end_ns - frame.start_ns));
            let _ = write!(text, "{number},{start},{lasts},{}", on.join(" "));
            if self.has_accessories {
                let accessories: Vec<&str> = frame.accessories.iter().map(String::as_str).collect();
                let _ = write!(text, ",{}", accessories.join(" "));
            }
            text.push('\n');
        }
        Ok(text)
    }

    /// An error if a channel rests on: the file cannot say what is on after its last frame.
    pub(super) fn refuse_rest(&self, format: Format) -> Result<(), EmitError> {
        let Some(number) = self.resting.on.first() else { return Ok(()) };
        let output = format!("{}.c{number}", self.wired.name);
        let what = format!("`{output}`, which rests on: its file does not state what is on after the last frame");
        let help = "write `--emit frames`, whose sender leaves it on".to_owned();
        Err(EmitError::Unsupported { format, what, help })
    }

    /// An error if a magnet or heater is wired, since the file of OpenDrop's program has electrodes only.
    fn refuse_accessories(&self) -> Result<(), EmitError> {
        let wired = self.wired.drives.iter().map(|drive| (drive, Switched::of(&drive.output, self.facts)));
        let mut accessories = wired.filter(|(_, switched)| matches!(switched, Switched::Accessory(_)));
        let Some((drive, _)) = accessories.next() else { return Ok(()) };
        let what = format!("`{}.{}`: its file contains only electrodes", self.wired.name, drive.output);
        let help = "write `--emit frames`, whose sender sets magnets and heaters too".to_owned();
        Err(EmitError::Unsupported { format: Format::Opendrop, what, help })
    }

    /// The common voltage of all electrodes that the driver switches, in volts.
    ///
    /// # Errors
    /// [`EmitError::Unsupported`] if there are two.
    pub(super) fn voltage_v(&self, format: Format) -> Result<f64, EmitError> {
        let links = self.wired.drives.iter().map(|drive| (&drive.output, drive.link));
        let volts = links.filter_map(|(output, link)| match link {
            Link::Switch { on_v } => Some((output, on_v)),
            Link::Amplifier { .. } | Link::StageDriver { .. } | Link::Axis { .. } => None,
        });
        let mut volts = volts.peekable();
        let Some((first, voltage_v)) = volts.peek().copied() else { return Ok(0.0) };
        let Some((other, other_v)) = volts.find(|(_, on_v)| *on_v != voltage_v) else { return Ok(voltage_v) };
        let name = self.wired.name;
        let what = format!(
            "{voltage_v} V at `{name}.{first}` beside {other_v} V at `{name}.{other}`: it has one voltage for all"
        );
        let help = "give all boards of the driver the same `potential`".to_owned();
        Err(EmitError::Unsupported { format, what, help })
    }

    /// The duration of each frame in OpenDrop's file, in nanoseconds.
    fn period_ns(&self) -> u64 {
        self.frames
            .iter()
            .fold(0, |period_ns, frame| common_divisor_ns(period_ns, frame.end_ns - frame.start_ns))
            .max(1)
    }

    /// The file that OpenDrop's program loads: a string of columns for each of the 8 rows from the top.
    fn controller_file(&self) -> Result<String, EmitError> {
        let period_ns = self.period_ns();
        let count: u64 = self.frames.iter().map(|frame| (frame.end_ns - frame.start_ns) / period_ns).sum();
        if count > OPENDROP_FRAMES {
            let instrument = self.wired.name.to_owned();
            return Err(EmitError::TooManyFrames { instrument, frames: count, limit: OPENDROP_FRAMES, period_ns });
        }
        let mut frames = Vec::new();
        for frame in &self.frames {
            for _ in 0..(frame.end_ns - frame.start_ns) / period_ns {
                let bit = |x: u32, y: u32| if frame.on.contains(&(OPENDROP_ROWS * x + y)) { '1' } else { '0' };
                let row = |y: u32| (0..OPENDROP_CHARACTERS).map(|x| bit(x, y)).collect::<String>();
                let rows = (0..OPENDROP_ROWS).map(|y| (format!("y{y}"), json!(row(y))));
                let mut object: serde_json::Map<String, serde_json::Value> = rows.collect();
                object.insert("frame".to_owned(), json!(frames.len() + 1));
                frames.push(serde_json::Value::Object(object));
            }
        }
        Ok(format!("{:#}\n", serde_json::Value::Array(frames)))
    }

    /// Data for the sender.
    fn listing(&self) -> Result<serde_json::Value, EmitError> {
        let electrodes: BTreeMap<u32, &str> = (self.wired.drives.iter().zip(&self.wired.schedule.channels))
            .filter_map(|(drive, channel)| Some((number_after("c", &drive.output)?, channel.name.as_str())))
            .collect();
        let name = &self.wired.schedule.name;
        let mut listing = json!({
            "name": self.wired.name,
            "model": self.wired.instrument.model,
            "protocol": self.facts.protocol.name(),
            "file": format!("{name}.{}.frames.csv", self.wired.name),
            "frames": self.frames.len(),
            "rest": self.resting.on,
            "electrodes": electrodes.iter().map(|(number, name)| format!("c{number} {name}")).collect::<Vec<_>>(),
        });
        if self.has_accessories {
            listing["resting_accessories"] = json!(self.resting.accessories);
        }
        if self.facts.protocol.sets_voltage() {
            listing["voltage_v"] = json!(self.voltage_v(Format::Frames)?);
            listing["frequency_hz"] = json!(self.facts.frequency_hz);
        }
        Ok(listing)
    }
}

/// Nanoseconds as milliseconds, exactly.
fn ms(ns: u64) -> String {
    let (whole, part) = (ns / 1_000_000, ns % 1_000_000);
    if part == 0 { whole.to_string() } else { format!("{whole}.{part:06}").trim_end_matches('0').to_owned() }
}

#[cfg(test)]
pub(super) mod tests;
