//! A schedule cut at its waits for an input or a person; each part is played on its own clock.

use super::wired::{WiredInstrument, wired};
use super::{EmitError, Format, Signals};
use crate::device::instrument::{Awaited, Family};
use crate::schedule::{Actuation, ChannelUnit, Schedule, ScheduledHold};
use std::borrow::Cow;

/// Placeholder line in a sender for what it plays.
pub const PLAYS: &str = "PLAYS = {}";

/// Placeholder line in a sender for [`SENDERS_SHARE`].
const SHARED_PLACE: &str = "# SHARED\n";

/// Code shared by senders: waiting for inputs and people, reading arguments, and ending.
const SENDERS_SHARE: &str = include_str!("sender.py");

/// Duration of a part that only holds the values of a wait at its beginning, in nanoseconds.
const LEAST_NS: u64 = 1_000_000;

/// The parts of a schedule, one more than it has waits with something after them; each starts at its own instant 0. A
/// schedule without waits is its only part. Where a wait follows, the last values of a part extend beyond its end,
/// since the wait holds them.
pub fn parts(schedule: &Schedule) -> Vec<Cow<'_, Schedule>> {
    if schedule.holds.is_empty() {
        return vec![Cow::Borrowed(schedule)];
    }
    let whole = Signals::new(schedule);
    let starts = [0].into_iter().chain(schedule.holds.iter().map(ScheduledHold::end_ns));
    let holds = schedule.holds.iter().map(Some).chain([None]);
    let all = starts.zip(holds).map(|(start_ns, hold)| Cow::Owned(clip_part(&whole, start_ns, hold)));
    // After a wait at the end there is nothing to play.
    let mut all: Vec<Cow<Schedule>> = all.collect();
    if all.len() > 1 && all.last().is_some_and(|last| last.duration_ns == 0) {
        all.pop();
    }
    all
}

/// The instants at which waits cut a schedule, and the duration of a part with nothing between two waits.
pub fn cuts_ns(schedule: &Schedule) -> impl Iterator<Item = u64> {
    schedule.holds.iter().flat_map(|hold| [hold.start_ns, hold.end_ns(), LEAST_NS.min(hold.terms.duration_ns)])
}

fn clip_part(whole: &Signals, start_ns: u64, hold: Option<&ScheduledHold>) -> Schedule {
    let schedule = whole.schedule;
    let (end_ns, held_ns) = match hold {
        None => (schedule.duration_ns, schedule.duration_ns),
        // Something must be played that puts the outputs where the wait holds them.
        Some(hold) if hold.start_ns == start_ns => {
            let end_ns = start_ns + LEAST_NS.min(hold.terms.duration_ns);
            (end_ns, end_ns + (end_ns - start_ns))
        }
        // Held values last for a multiple of the played time, so that the sample period need not become finer.
        Some(hold) => (hold.start_ns, hold.start_ns + (hold.start_ns - start_ns)),
    };
    let clipped = |actuation: &Actuation| {
        let begin_ns = actuation.start_ns.max(start_ns);
        let is_held = hold.is_some_and(|hold| actuation.start_ns <= hold.start_ns && actuation.end_ns() > end_ns);
        let last_ns = if is_held { held_ns } else { actuation.end_ns().min(end_ns) };
        let duration_ns = last_ns.checked_sub(begin_ns).filter(|duration_ns| *duration_ns > 0)?;
        Some(Actuation { start_ns: begin_ns - start_ns, duration_ns, ..*actuation })
    };
    let mut actuations: Vec<Actuation> = schedule.actuations.iter().filter_map(clipped).collect();
    // A stage that does not move in a part stays where it was.
    for channel in whole.in_unit(ChannelUnit::Micrometre) {
        let place_um = whole.value(channel, start_ns);
        let (channel, duration_ns) = (channel as u32, held_ns - start_ns);
        if duration_ns > 0 && actuations.iter().all(|actuation| actuation.channel != channel) {
            let still =
                Actuation { channel, start_ns: 0, duration_ns, from: place_um, to: place_um, swing: None, step: 0 };
            actuations.push(still);
        }
    }
    actuations.sort_by_key(|actuation| (actuation.start_ns, actuation.channel));
    // Steps and plans are left out: no sender names them.
    Schedule {
        name: schedule.name.clone(),
        source: schedule.source.clone(),
        duration_ns: end_ns - start_ns,
        channels: schedule.channels.clone(),
        actuations,
        steps: Vec::new(),
        plans: Vec::new(),
        holds: Vec::new(),
        bench: schedule.bench.clone(),
    }
}

/// Playback of a part by one instrument: its entry in the sender, and its file with the ending.
pub type PlayedFile = (serde_json::Value, (String, Vec<u8>));

/// One file per part of a schedule and instrument of a family, and the sender that plays them, all with their endings.
/// `one` makes a file from the channels wired to an instrument and the number of the part, which is empty if there is
/// only one; `noun` is the sender's word for the instruments.
///
/// # Errors
/// [`EmitError::NotWired`], and those of `one`.
pub fn played(
    schedule: &Schedule,
    format: Format,
    family: Family,
    noun: &str,
    template: &str,
    one: impl Fn(&WiredInstrument, &str) -> Result<Option<PlayedFile>, EmitError>,
) -> Result<Vec<(String, Vec<u8>)>, EmitError> {
    let mut files = Vec::new();
    let mut listings = Vec::new();
    let all = parts(schedule);
    for (index, part) in all.iter().enumerate() {
        let number = if all.len() > 1 { format!(".{}", index + 1) } else { String::new() };
        let mut plays = Vec::new();
        for wired in wired(format, part, family)? {
            if let Some((known, file)) = one(&wired, &number)? {
                plays.push(known);
                files.push(file);
            }
        }
        listings.push(serde_json::json!({ "duration_s": part.duration_ns as f64 / 1e9, (noun): plays }));
    }
    let whole = serde_json::json!({ "name": schedule.name, "holds": listing(schedule), "parts": listings });
    files.push((format!("{}.py", format.name()), sender(template, &whole).into_bytes()));
    Ok(files)
}

/// The waits as data for a sender: the prompt or the input, and the longest time.
pub fn listing(schedule: &Schedule) -> Vec<serde_json::Value> {
    let of_hold = |hold: &ScheduledHold| {
        let seconds = |ns: u64| ns as f64 / 1e9;
        let at_most_s = hold.terms.is_bounded.then(|| seconds(hold.terms.duration_ns));
        let times = [seconds(hold.start_ns), seconds(hold.end_ns())];
        match &hold.terms.awaited {
            Awaited::Person { prompt } => {
                serde_json::json!({ "at_most_s": at_most_s, "prompt": prompt, "times_s": times })
            }
            Awaited::Input { name, place, level } => serde_json::json!({
                "at_most_s": at_most_s,
                "input": name,
                "instrument": place.as_ref().map(|(instrument, _)| instrument),
                "line": place.as_ref().map(|(_, line)| line.replace('.', "/")),
                "level": level.name(),
                "times_s": times,
            }),
        }
    };
    schedule.holds.iter().map(of_hold).collect()
}

/// A sender with its data: what it plays and how it waits. Texts of the program are escaped so that none ends the
/// Python string.
pub fn sender(template: &str, listing: &serde_json::Value) -> String {
    let text = format!("{listing:#}").replace('\'', "\\u0027");
    let plays = format!("PLAYS = json.loads(r'''{text}''')");
    template.replacen(PLAYS, &plays, 1).replacen(SHARED_PLACE, SENDERS_SHARE, 1)
}

/// An error if a schedule waits and the format cannot express that.
pub fn refuse_holds(format: Format, schedule: &Schedule) -> Result<(), EmitError> {
    let Some(hold) = schedule.holds.first() else { return Ok(()) };
    let unsupported = |what: String, help: &str| Err(EmitError::Unsupported { format, what, help: help.to_owned() });
    match format {
        Format::Mcap | Format::Json | Format::Html | Format::Svg | Format::Sheet => Ok(()),
        Format::Csv | Format::Vcd | Format::Pwl | Format::Opendrop => unsupported(
            format!("the wait for {}: it has one clock", hold.terms.awaited.shown()),
            "write `--emit scpi`, `nidaqmx`, `frames`, `stages` or `gcode`, which wait, or `mcap`, `json` and `html`, which show the longest wait",
        ),
        Format::Scpi | Format::Nidaqmx | Format::Frames | Format::Stages => refuse_two_senders(format, schedule),
        Format::Microdrop => refuse_all_but_prompts(schedule),
        Format::Gcode => Ok(()),
    }
}

/// An error if a schedule waits for an input, or for a person with a longest time: MicroDrop has only prompts without
/// one.
fn refuse_all_but_prompts(schedule: &Schedule) -> Result<(), EmitError> {
    let is_prompt = |hold: &&ScheduledHold| match hold.terms.awaited {
        Awaited::Person { .. } => !hold.terms.is_bounded,
        Awaited::Input { .. } => false,
    };
    let Some(hold) = schedule.holds.iter().find(|hold| !is_prompt(hold)) else { return Ok(()) };
    let bound = if hold.terms.is_bounded { ", with a longest time" } else { "" };
    let what =
        format!("the wait for {}{bound}: it has only prompts without a longest time", hold.terms.awaited.shown());
    let help = "write `--emit frames`, whose sender waits for both, or `prompt` without `for at most`".to_owned();
    Err(EmitError::Unsupported { format: Format::Microdrop, what, help })
}

/// An error if a schedule waits and its instruments are not all played by one sender.
fn refuse_two_senders(format: Format, schedule: &Schedule) -> Result<(), EmitError> {
    let families: Vec<Family> =
        schedule.bench.instruments.values().map(|instrument| instrument.facts.family()).collect();
    if !families.iter().any(|family| family.format() == format.name()) {
        return Ok(());
    }
    let apart = families.iter().any(|family| family.format() != format.name());
    if !apart && (format != Format::Scpi || families.len() < 2) {
        return Ok(());
    }
    let what = match apart {
        true => "a wait with instruments of two families, which need two senders",
        false => "a wait of two generators, which start together only once",
    };
    let help =
        "wire all channels of a program that waits to instruments of one family, generators to one of them".to_owned();
    Err(EmitError::Unsupported { format, what: what.to_owned(), help })
}
