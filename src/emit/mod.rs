//! Writes a verified schedule in formats for other programs.
//!
//! Input: a [`Verified`] schedule and its [`Provenance`]. Output: [`OutputFile`]s, in memory. Guarantees: no file is
//! touched, the same input gives the same bytes, and every format represents every channel at every instant, or
//! [`EmitError`] states why it cannot.

pub mod csv;
mod dimibot;
mod electrode_array;
mod error;
mod fingers;
#[cfg(test)]
pub(crate) mod fixture;
mod frames;
pub mod gcode;
mod hold_parts;
mod html;
mod identifier;
pub mod mcap;
mod microrobots;
mod motion;
mod nidaqmx;
pub mod pwl;
mod sampling;
mod scpi;
mod sheet;
mod signal;
mod stages;
mod svg;
pub mod vcd;
mod wired;

pub use error::EmitError;
pub use html::{FAILED_ENDING, FailedProgram, RefusedSchedule};

use crate::device::words::words;
use crate::schedule::{Reached, Schedule, json};
use crate::verify::Verified;
use electrode_array::{dispensed, write_microdrop};
use signal::Signals;

words! {
    /// Output formats, in the order of the handbook; the words are those of `--emit`.
    pub enum Format {
        Mcap = "mcap": "a log that Foxglove, Lichtblick and Rerun play",
        Json = "json": "the schedule itself, for other programs",
        Csv = "csv": "one row for each change, one column for each channel",
        Vcd = "vcd": "waveforms for GTKWave and similar viewers",
        Pwl = "pwl": "voltage sources for SPICE",
        Scpi = "scpi": "upload script for arbitrary-waveform generators",
        Nidaqmx = "nidaqmx": "digital lines and analog outputs for National Instruments cards",
        Frames = "frames": "frames of electrodes that are on, for OpenDrop, PurpleDrop and DropBot",
        Opendrop = "opendrop": "frames for the program that comes with an OpenDrop",
        Microdrop = "microdrop": "steps and the device for MicroDrop, which drives DropBot and OpenDrop",
        Stages = "stages": "positions of translation stages, for controllers from PI and SmarAct",
        Gcode = "gcode": "moves of translation stages, for LinuxCNC",
        Html = "html": "a page that plays the schedule in any browser",
        Svg = "svg": "a static picture for papers",
        Sheet = "sheet": "what to load, what happens when, and what is left afterwards, for the person at the bench",
    }
}

impl Format {
    /// File endings of a schedule's files, except those named after instruments or devices.
    pub fn endings(self) -> &'static [&'static str] {
        match self {
            Format::Mcap => &["mcap", "lichtblick.json"],
            Format::Json => &["json"],
            Format::Csv => &["csv"],
            Format::Vcd => &["vcd", "gtkw"],
            Format::Pwl => &["pwl.inc", "cir"],
            Format::Scpi => &["scpi.py"],
            Format::Nidaqmx => &["nidaqmx.py"],
            Format::Frames => &["frames.py"],
            Format::Stages => &["stages.py"],
            Format::Opendrop | Format::Microdrop | Format::Gcode => &[],
            Format::Html => &["html"],
            Format::Svg => &["svg"],
            Format::Sheet => &["sheet.md"],
        }
    }
}

/// One file to be written.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct OutputFile {
    /// File name without a folder: `fetch.mcap`.
    pub name: String,
    pub bytes: Vec<u8>,
}

/// Origin of a schedule; it is written into a log so that the log can be judged without the files beside it.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Provenance {
    /// Name and text of every file: the program's own first, then the used ones, without the standard library.
    pub files: Vec<(String, String)>,
    /// The `--set` values as given.
    pub settings: Vec<String>,
    /// Whether the schedule was read from a log, whose bounds, proofs and remarks were not derived again.
    pub is_recorded: bool,
}

/// Writes a schedule in one format: one file, or several that belong together. All names begin with the schedule's.
///
/// # Errors
/// See [`EmitError`].
pub fn emit(format: Format, verified: &Verified, provenance: &Provenance) -> Result<Vec<OutputFile>, EmitError> {
    let schedule = verified.schedule();
    check_finite(schedule)?;
    hold_parts::refuse_holds(format, schedule)?;
    let named = |ending: &str, bytes| (ending.to_owned(), bytes);
    let signals = Signals::new(schedule);
    let files: Vec<(String, Vec<u8>)> = match format {
        Format::Mcap => {
            let [log, layout] = mcap::write(verified, provenance)?;
            vec![named("mcap", log), named("lichtblick.json", layout)]
        }
        Format::Json => vec![named("json", json::write(schedule))],
        Format::Csv => vec![named("csv", csv::write(&signals)?)],
        Format::Vcd => {
            let [waveforms, view] = vcd::write(&signals)?;
            vec![named("vcd", waveforms), named("gtkw", view)]
        }
        Format::Pwl => {
            let [sources, deck] = pwl::write(&signals)?;
            vec![named("pwl.inc", sources), named("cir", deck)]
        }
        Format::Nidaqmx => nidaqmx::write(schedule, verified.claims())?,
        Format::Frames => frames::write(schedule, &dispensed(verified))?,
        Format::Opendrop => frames::write_opendrop(schedule)?,
        Format::Microdrop => write_microdrop(verified)?,
        Format::Stages => stages::write(schedule, verified.claims())?,
        Format::Scpi => scpi::write(schedule, verified.claims())?,
        Format::Gcode => {
            let programs = gcode::write(&signals, verified.claims())?;
            programs.into_iter().map(|(of, program)| (format!("{of}.ngc"), program)).collect()
        }
        Format::Html => vec![named("html", html::write(verified, provenance)?)],
        Format::Svg => vec![named("svg", svg::write(verified, None)?)],
        Format::Sheet => vec![named("sheet.md", sheet::write(verified, provenance)?)],
    };
    let name = |(ending, bytes)| OutputFile { name: format!("{}.{ending}", schedule.name), bytes };
    Ok(files.into_iter().map(name).collect())
}

/// Draws one instant of a schedule, in nanoseconds from its start, instead of the strobes of [`Format::Svg`].
///
/// # Errors
/// [`EmitError::OutsideSchedule`] for an instant after the end; otherwise as [`emit`].
pub fn picture_at(verified: &Verified, t_ns: u64) -> Result<Vec<OutputFile>, EmitError> {
    let schedule = verified.schedule();
    check_finite(schedule)?;
    Ok(vec![OutputFile { name: format!("{}.svg", schedule.name), bytes: svg::write(verified, Some(t_ns))? }])
}

/// The page of a program that could not be built: its errors, and the scene with the parts that could be built. `stem`
/// is the name of the program's file without its ending.
///
/// # Errors
/// As [`emit`] for [`Format::Html`].
pub fn failed_page(stem: &str, failed: &FailedProgram, provenance: &Provenance) -> Result<OutputFile, EmitError> {
    failed.part.map_or(Ok(()), |(verified, _)| check_finite(verified.schedule()))?;
    Ok(OutputFile { name: format!("{stem}.{FAILED_ENDING}"), bytes: html::write_failed(failed, provenance)? })
}

/// The page of a schedule that was refused, named after the file that holds it.
///
/// # Errors
/// As [`emit`] for [`Format::Html`].
pub fn refused_page(stem: &str, refused: &RefusedSchedule, provenance: &Provenance) -> Result<OutputFile, EmitError> {
    Ok(OutputFile { name: format!("{stem}.{FAILED_ENDING}"), bytes: html::write_refused(refused, provenance)? })
}

/// Makes the pages among a build's files follow their program, and adds the script of the given name beside them that
/// names the latest build. Without a page, nothing changes.
pub fn follow(files: &mut Vec<OutputFile>, script: &str, provenance: &Provenance) {
    let follower = html::Follower::new(script, provenance);
    let mut pages = Vec::new();
    for file in files.iter_mut().filter(|file| file.name.ends_with(".html")) {
        follower.mark_page(&mut file.bytes);
        pages.push(file.name.as_str());
    }
    if !pages.is_empty() {
        let bytes = follower.script_bytes(&pages);
        files.push(OutputFile { name: script.to_owned(), bytes });
    }
}

/// An error for infinite or NaN values: decimal text formats have no form for them, and no voltage or position may be
/// one.
fn check_finite(schedule: &Schedule) -> Result<(), EmitError> {
    let actuations = schedule.actuations.iter().flat_map(|actuation| {
        let levels = actuation.swing.map_or([0.0; 2], |swing| swing.levels);
        [actuation.from, actuation.to].into_iter().chain(levels)
    });
    let plans = schedule.plans.iter().flat_map(|plan| {
        let states = plan.states.iter().flat_map(|timed| timed.state.floats());
        let outcomes = plan.outcomes.values().chain(plan.bounds.values()).copied();
        states.chain(outcomes).chain([plan.cost, plan.bound])
    });
    let reached = schedule.steps.iter().flat_map(|step| &step.reached).flat_map(Reached::floats);
    match actuations.chain(plans).chain(reached).all(f64::is_finite) {
        true => Ok(()),
        false => Err(EmitError::NotFinite),
    }
}

#[cfg(test)]
pub(crate) mod tests;
