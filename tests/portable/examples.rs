//! Every example with something to build: checked without diagnostics, built, verified, and written in every format.

use crate::support::{build, build_in, carries_droplets, switches_accessories};
use std::path::{Path, PathBuf};
use tweeze::device::instrument::{InstrumentFacts, Protocol};
use tweeze::schedule::microrobots::MicrorobotsState;
use tweeze::schedule::{ChannelUnit, Schedule, ScheduledHold, State};
use tweeze::verify::Verified;

fn folder() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("examples")
}

/// The examples' names and texts, by name.
fn examples() -> Vec<(String, String)> {
    let entries = std::fs::read_dir(folder()).expect("the examples are there").flatten();
    let mut paths: Vec<PathBuf> = entries.map(|entry| entry.path()).collect();
    paths.retain(|path| path.extension().is_some_and(|ending| ending == "twz"));
    paths.sort();
    let name = |path: &Path| path.file_name().unwrap_or_default().to_string_lossy().into_owned();
    paths.iter().map(|path| (name(path), std::fs::read_to_string(path).expect("an example is text"))).collect()
}

fn has_docked(state: &State) -> bool {
    match state {
        State::Microrobots(MicrorobotsState { docked, .. }) => !docked.is_empty(),
        State::Dimibot(_) | State::ElectrodeArray(_) | State::Fingers(_) => false,
    }
}

fn has_tasks(text: &str) -> bool {
    text.lines().any(|line| line.starts_with("task "))
}

#[test]
fn every_example_builds_without_a_word_and_is_written_in_every_format() {
    let programs: Vec<_> = examples().into_iter().filter(|(_, text)| has_tasks(text)).collect();
    assert!(programs.len() >= 6);
    for (name, text) in programs {
        let built = build_in(&folder(), &text);
        assert!(built.codes.is_empty() && !built.schedules.is_empty(), "{name}: {:?}", built.codes);
        let files = built.files();
        // G-code is written for stages only, a loading sheet for droplets only. A generator has a script and its
        // description, a card its samples, an electrode driver its frames, and each format a sender.
        let are_stages =
            |schedule: &Schedule| schedule.channels.iter().all(|channel| channel.unit == ChannelUnit::Micrometre);
        let of_instruments = |schedule: &Schedule| -> usize {
            let facts = schedule.bench.instruments.values().map(|instrument| &instrument.facts);
            let files = facts.map(|facts| match facts {
                InstrumentFacts::WaveformGenerator(_) => 3,
                InstrumentFacts::DataAcquisition(_) => {
                    let goes_on = |hold: &&ScheduledHold| hold.end_ns() < schedule.duration_ns;
                    2 + schedule.holds.iter().filter(goes_on).count()
                }
                InstrumentFacts::StageController(_) => 2,
                // Its G-code is counted with the schedules of stages.
                InstrumentFacts::MachineController(_) => 0,
                InstrumentFacts::ElectrodeDriver(_) if switches_accessories(schedule) => 2,
                InstrumentFacts::ElectrodeDriver(facts) => {
                    2 + usize::from(facts.protocol == Protocol::Opendrop)
                        + 2 * usize::from(facts.protocol.has_microdrop())
                }
            });
            files.sum()
        };
        let of_kinds = |verified: &Verified| {
            usize::from(are_stages(verified.schedule())) + usize::from(carries_droplets(verified))
        };
        // A schedule that waits has no tables and waveforms, because these have a single clock.
        let of_one_clock = |schedule: &Schedule| if schedule.holds.is_empty() { 5 } else { 0 };
        let due = built
            .schedules
            .iter()
            .map(|built| 5 + of_one_clock(built.schedule()) + of_kinds(built) + of_instruments(built.schedule()));
        assert_eq!(files.len(), due.sum::<usize>(), "{name}");
        assert!(files.iter().all(|file| !file.bytes.is_empty()), "{name}");
        let plans = built.schedules.iter().flat_map(|verified| &verified.schedule().plans);
        for plan in plans {
            let assembles = plan.states.iter().any(|timed| has_docked(&timed.state));
            // For assemblies and drives on a bed only bounds are known.
            let is_open = assembles || name == "microrobots_drive.twz";
            // A share of failures is an estimate, about which nothing is proven.
            let is_estimate = plan.objective == "failures";
            let is_bound = plan.bound <= plan.cost && (is_estimate || plan.bound > 0.0);
            assert!(is_bound && plan.optimal == (plan.bound == plan.cost), "{name}");
            assert!(is_open || plan.optimal, "{name}");
        }
    }
}

#[test]
fn every_example_begins_with_what_it_shows() {
    for (name, text) in examples() {
        assert!(text.starts_with("//! "), "{name}");
        assert!(text.lines().all(|line| line.chars().count() <= 130), "{name}");
    }
}

#[test]
fn a_file_without_tasks_is_only_there_to_be_used() {
    let examples = examples();
    for (name, text) in examples.iter().filter(|(_, text)| !has_tasks(text)) {
        let used = examples.iter().any(|(_, other)| other.contains(&format!("use \"{name}\"")));
        assert!(used, "{name} has no tasks, and no example uses it");
        assert!(build(text).codes.iter().all(|code| code.starts_with('W')), "{name}");
    }
}

/// The loading sheet of an example that dilutes.
fn sheet_of(example: &str) -> String {
    let text = examples().into_iter().find(|(name, _)| name == example).map(|(_, text)| text);
    let files = build_in(&folder(), &text.expect("the example")).files();
    let sheet = files.iter().find(|file| file.name == "dilute.sheet.md").expect("a sheet");
    String::from_utf8(sheet.bytes.clone()).expect("a text")
}

#[test]
fn a_sheet_says_what_its_prompts_ask() {
    let sheet = sheet_of("electrode_array_dropbot.twz");
    let row =
        "| 3.5 s | 4.5 s at the answer | chip | **put the lid on, then start the camera**, until it is answered |\n";
    assert!(sheet.contains(row) && sheet.contains("count on from the answer."), "{sheet}");
    assert!(sheet.contains("| 4.5 s | 9.5 s | chip | nothing moves |\n"), "{sheet}");
    assert_eq!(sheet.matches("nothing moves").count(), 2, "{sheet}");
}

#[test]
fn a_sheet_says_what_to_load_and_what_is_left() {
    let sheet = sheet_of("electrode_array_dilute.twz");
    let has = |line: &str| assert!(sheet.contains(line), "{line}\n{sheet}");
    has("| ☐ | reservoir `dye` | outlet (1, 2) | 1 droplet |\n");
    has("| ☐ | reservoir `buffer` | outlet (1, 8) | 6 droplets |\n");
    has("| chip | `sample` is split at (7, 3): `half0` comes to (8, 3) |\n");
    has("| chip | `half0` stays at (12, 7) for 2.04 s |\n");
    has("`half0`, 1 droplet: 1/2 buffer, 1/2 dye; ");
    has("`half5`, 1 droplet: 63/64 buffer, 1/64 dye |\n");
    has("| left at (14, 1) | `sample`, 1 droplet: 63/64 buffer, 1/64 dye |\n");
    assert!(!sheet.contains("prompt"), "it waits for nobody:\n{sheet}");
    // Every operation has its row, in order of time.
    let run = sheet.split("## Run").nth(1).and_then(|rest| rest.split("## After").next()).expect("a table");
    assert_eq!(run.lines().filter(|line| line.contains("| chip |")).count(), 2 + 6 * 6);
}
