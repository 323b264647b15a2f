use super::*;
use crate::device::electrode_array::{ElectrodeArrayFacts, ElectrodeCell, ElectrodeMap, Electrodes};
use crate::device::instrument::{Awaited, Bench, Drive, HoldTerms, Instrument, Link, StageLimits, Start};
use crate::diagnostic::Code;
use crate::emit::dispensed;
use crate::emit::fixture::FixtureSchedule;
use crate::emit::{Provenance, emit, fixture};
use crate::lower::electrode_array::tests::{carried, facts};
use crate::schedule::{Actuation, Channel, ChannelUnit, ScheduledHold, ScheduledStep, State};
use crate::source::Span;
use crate::verify::Verified;

/// A bench with a single driver.
fn bench_of(protocol: Protocol) -> Bench {
    let facts = ElectrodeDriverFacts {
        protocol,
        channels: protocol.channels(),
        least_v: 0.0,
        most_v: 300.0,
        least_frame_ns: 1,
        frequency_hz: protocol.sets_voltage().then_some(1e4),
        heaters_degc: if protocol.heaters() > 0 { BTreeMap::from([(2, 60)]) } else { BTreeMap::new() },
        start: Start::Sender,
    };
    let mut bench = Bench::default();
    let instrument = Instrument { model: "a.driver".to_owned(), facts: InstrumentFacts::ElectrodeDriver(facts) };
    bench.instruments.insert("driver".to_owned(), instrument);
    bench
}

/// Two droplets on a board of 8 x 5 electrodes without its corner, numbered 5 c + r - 6; both move on, rest 1 ms, and
/// move back.
pub fn board_on_driver(protocol: Protocol) -> FixtureSchedule {
    numbered_board(protocol, |cell| (5 * cell.column + cell.row).checked_sub(7))
}

/// The same board with other channel numbers.
fn numbered_board(protocol: Protocol, number: fn(ElectrodeCell) -> Option<u32>) -> FixtureSchedule {
    let cells = (1..=5).flat_map(|row| (1..=8).map(move |column| ElectrodeCell::new(column, row)));
    let map = ElectrodeMap { columns: 8, channels: cells.map(number).collect(), disabled: Vec::new() };
    let facts = ElectrodeArrayFacts { columns: 8, rows: 5, map: Some(map.clone().into()), ..facts(Electrodes::Single) };
    let there = vec![vec![(1, 5), (2, 5), (3, 5)], vec![(8, 1), (8, 2), (8, 3)]];
    let back = there.iter().map(|way| way.iter().rev().copied().collect()).collect();
    let (claims, mut schedule) = carried(&facts, &[there, Vec::new(), back]);
    schedule.bench = bench_of(protocol);
    for (cell, number) in map.numbered() {
        let drive = Drive {
            instrument: "driver".to_owned(),
            output: format!("c{number}"),
            link: Link::Switch { on_v: facts.potential_v },
            limits: StageLimits::default(),
            span: Span::default(),
        };
        let first = ElectrodeArrayFacts::channel(facts.first_on_channel_of(cell));
        schedule.bench.drives.insert(format!("plate.{first}"), drive);
    }
    FixtureSchedule { verified: Verified::assume(schedule, claims), provenance: Provenance::default() }
}

/// The same board with waits for a person of 1 ms each: before the first step, where nothing moves, and at the end.
pub fn prompting_board(protocol: Protocol) -> FixtureSchedule {
    board_on_driver(protocol).changed(|schedule| {
        let rest_ns = schedule.steps[0].end_ns();
        let shift = |t_ns: u64| t_ns + 1_000_000 + if t_ns > rest_ns { 1_000_000 } else { 0 };
        let over_ns = shift(schedule.duration_ns);
        for actuation in &mut schedule.actuations {
            let end_ns = shift(actuation.end_ns());
            actuation.start_ns = if actuation.start_ns == 0 { 0 } else { shift(actuation.start_ns) };
            // Channels that are on at the end stay on during the last prompt.
            let end_ns = if end_ns == over_ns { end_ns + 1_000_000 } else { end_ns };
            actuation.duration_ns = end_ns - actuation.start_ns;
        }
        let asked = [(0, "fill the board"), (rest_ns + 1_000_000, "add \"oil\""), (over_ns, "done?")];
        schedule.duration_ns = over_ns + 1_000_000;
        schedule.holds = asked.map(|(start_ns, prompt)| hold(start_ns, prompt, false)).to_vec();
    })
}

/// The same board on an OpenDrop, with its first magnet on in the first step, and its second heater on from 7 ms.
pub fn board_with_magnet() -> FixtureSchedule {
    board_on_driver(Protocol::Opendrop).changed(|schedule| {
        let end_ns = schedule.duration_ns;
        let first = schedule.steps[0].end_ns();
        for (name, output, [start_ns, end_ns]) in
            [("lift", "magnet1", [0, first]), ("stove", "heater2", [7_000_000, end_ns])]
        {
            let channel = schedule.channels.len() as u32;
            let full = format!("{name}.out");
            schedule.channels.push(Channel {
                name: full.clone(),
                device: name.to_owned(),
                unit: ChannelUnit::Volt,
                wire: Some(format!("driver.{output}")),
                rest_v: 0.0,
            });
            schedule.bench.drives.insert(
                full,
                Drive {
                    instrument: "driver".to_owned(),
                    output: output.to_owned(),
                    link: Link::Switch { on_v: 5.0 },
                    limits: StageLimits::default(),
                    span: Span::default(),
                },
            );
            let duration_ns = end_ns - start_ns;
            schedule.actuations.push(Actuation {
                channel,
                start_ns,
                duration_ns,
                from: 5.0,
                to: 5.0,
                swing: None,
                step: 0,
            });
        }
        schedule.actuations.sort_by_key(|actuation| (actuation.start_ns, actuation.channel));
    })
}

fn hold(start_ns: u64, prompt: &str, is_bounded: bool) -> ScheduledHold {
    let awaited = Awaited::Person { prompt: prompt.to_owned() };
    ScheduledHold { step: 0, start_ns, terms: HoldTerms { awaited, duration_ns: 1_000_000, is_bounded } }
}

/// All voltages of a fixture on a driver, from channel 8 on.
pub fn on_driver(fixture: FixtureSchedule, protocol: Protocol) -> FixtureSchedule {
    fixture.changed(|schedule| {
        let mut bench = bench_of(protocol);
        let volts = schedule.channels.iter().filter(|channel| channel.unit == ChannelUnit::Volt);
        for (Channel { name, .. }, number) in volts.zip(8..) {
            let drive = Drive {
                instrument: "driver".to_owned(),
                output: format!("c{number}"),
                link: Link::Switch { on_v: 20.0 },
                limits: StageLimits::default(),
                span: Span::default(),
            };
            bench.drives.insert(name.clone(), drive);
        }
        schedule.bench = bench;
    })
}

fn file(format: Format, fixture: &FixtureSchedule, ending: &str) -> String {
    let files = emit(format, &fixture.verified, &fixture.provenance).expect("the fixture can be written");
    let name = format!("{}.{ending}", fixture.verified.schedule().name);
    let found = files.into_iter().find(|file| file.name == name).expect("the file is written");
    String::from_utf8(found.bytes).expect("a text")
}

/// Five pulses of 15 ms, one every 30 ms, alternating between the left and the right side.
#[test]
fn frames_follow_each_other_from_the_start_to_the_end() {
    let fixture = on_driver(fixture::fetch(), Protocol::Opendrop);
    let text = file(Format::Frames, &fixture, "driver.frames.csv");
    let rows: Vec<Vec<&str>> = text.lines().map(|row| row.split(',').collect()).collect();
    assert_eq!(rows[0], ["frame", "start [ms]", "duration [ms]", "on"]);
    let mut end = 0.0;
    for (row, number) in rows[1..].iter().zip(1..) {
        let [start, lasts]: [f64; 2] = [1, 2].map(|cell| row[cell].parse().expect("a number"));
        assert_eq!((row[0], start), (number.to_string().as_str(), end), "{text}");
        end = start + lasts;
    }
    assert_eq!(end, fixture.verified.schedule().duration_ns as f64 / 1e6);
    assert!(rows[1..].windows(2).all(|pair| pair[0][3] != pair[1][3]), "neighbours differ: {text}");
    // Each channel has the value of the schedule at each instant.
    let signals = Signals::new(fixture.verified.schedule());
    for row in &rows[1..] {
        let start_ns = (row[1].parse::<f64>().expect("a number") * 1e6).round() as u64;
        let on: Vec<u32> = row[3].split_whitespace().map(|number| number.parse().expect("a channel")).collect();
        let expected = (0..signals.schedule.channels.len()).filter(|channel| signals.value(*channel, start_ns) != 0.0);
        assert_eq!(on, expected.map(|channel| channel as u32 + 8).collect::<Vec<_>>(), "{text}");
    }
}

/// Channel 8 x + y is character x of row y; all frames of the file have the same length.
#[test]
fn the_file_of_the_opendrop_says_the_same() {
    let fixture = on_driver(fixture::fetch(), Protocol::Opendrop);
    let table = file(Format::Frames, &fixture, "driver.frames.csv");
    let text = file(Format::Opendrop, &fixture, "driver.opendrop.json");
    let frames: Vec<BTreeMap<String, serde_json::Value>> = serde_json::from_str(&text).expect("JSON");
    let on = |frame: &BTreeMap<String, serde_json::Value>| -> Vec<u32> {
        let row = |y: u32| frame[&format!("y{y}")].as_str().expect("a text").to_owned();
        let rows: Vec<String> = (0..8).map(row).collect();
        assert!(rows.iter().all(|row| row.len() == 18), "{text}");
        let is_on = |number: &u32| rows[(number % 8) as usize].as_bytes()[(number / 8) as usize] == b'1';
        (0..144).filter(is_on).collect()
    };
    let mut expected = Vec::new();
    for row in table.lines().skip(1) {
        let cells: Vec<&str> = row.split(',').collect();
        let times = cells[2].parse::<f64>().expect("a number") / 15.0;
        let channels: Vec<u32> = cells[3].split_whitespace().map(|number| number.parse().expect("a channel")).collect();
        expected.extend(vec![channels; times as usize]);
    }
    assert_eq!(frames.iter().map(on).collect::<Vec<_>>(), expected);
    assert_eq!(
        frames.iter().map(|frame| frame["frame"].clone()).collect::<Vec<_>>(),
        (1..=frames.len()).collect::<Vec<_>>()
    );
}

#[test]
fn magnets_and_heaters_stand_beside_the_electrodes() {
    let fixture = board_with_magnet();
    let text = file(Format::Frames, &fixture, "driver.frames.csv");
    let expected = "frame,start [ms],duration [ms],on,accessories\n\
                    1,0,5,8 35,magnet1\n2,5,2,13 36,magnet1\n3,7,3,13 36,heater2=60 magnet1\n\
                    4,10,1,13 36,heater2=60\n5,11,5,8 35,heater2=60\n6,16,5,3 34,heater2=60\n";
    assert_eq!(text, expected);
    let refused =
        |format| emit(format, &fixture.verified, &fixture.provenance).expect_err("it has no form").diagnostic();
    assert!(refused(Format::Opendrop).title.contains("driver.magnet1"), "{:?}", refused(Format::Opendrop));
    assert!(refused(Format::Microdrop).title.contains("lift.out"), "{:?}", refused(Format::Microdrop));
}

/// The part is absent in the first state, so it comes in the step that begins there.
#[test]
fn droplets_that_come_are_named_when_they_are_due() {
    let (claims, mut schedule) =
        carried(&facts(Electrodes::Single), &[vec![vec![(5, 5), (6, 5), (7, 5)], vec![(12, 5)]]]);
    let due = |schedule: &Schedule| dispensed(&Verified::assume(schedule.clone(), claims.clone()));
    assert_eq!(due(&schedule), Vec::<serde_json::Value>::new());
    let states = &mut schedule.plans[0].states;
    let name = states[2].state.cells().and_then(|parts| parts.iter().nth(1)).expect("a second part").0.to_owned();
    let at_s = states[1].t_ns as f64 / 1e9;
    for state in &mut states[..2] {
        let State::ElectrodeArray(board) = &mut state.state else { panic!("a board") };
        board.parts.set(&name, None);
    }
    assert!(at_s > 0.0);
    assert_eq!(due(&schedule), [json!({ "at_s": at_s, "droplet": name, "outlet": [12, 5] })]);
    // After a wait the droplet is due when its step begins, not when the board last changed.
    let later_ns = schedule.plans[0].states[2].t_ns - 1;
    schedule.steps.push(ScheduledStep { start_ns: later_ns, ..schedule.steps[0].clone() });
    assert_eq!(due(&schedule)[0]["at_s"], json!(later_ns as f64 / 1e9));
}

#[test]
fn what_cannot_be_written_says_why() {
    let code = |format, fixture: FixtureSchedule| {
        emit(format, &fixture.verified, &fixture.provenance)
            .map(|files| files.len())
            .map_err(|error| error.diagnostic().code)
    };
    assert_eq!(code(Format::Frames, fixture::fetch()), Err(Code::E0824), "no driver");
    // A wiring does not help without channels.
    let still = fixture::idle().changed(|schedule| schedule.channels.clear());
    let error = emit(Format::Opendrop, &still.verified, &still.provenance).map(|_| ()).unwrap_err().diagnostic();
    assert!(error.code == Code::E0824 && error.title.contains("switches and moves nothing"), "{}", error.title);
    assert_eq!(code(Format::Opendrop, on_driver(fixture::fetch(), Protocol::Purpledrop)), Err(Code::E0824));
    assert_eq!(code(Format::Frames, on_driver(fixture::fetch(), Protocol::Purpledrop)), Ok(2));
    let long = on_driver(fixture::fetch(), Protocol::Opendrop).changed(|schedule| {
        schedule.actuations[0].duration_ns -= 1;
    });
    assert_eq!(code(Format::Opendrop, long), Err(Code::E0823), "frames of 1 ns");
}

/// The steps that MicroDrop reads, without their names.
fn microdrop_steps(fixture: &FixtureSchedule) -> Vec<serde_json::Value> {
    let text = file(Format::Microdrop, fixture, "driver.microdrop.json");
    let protocol: serde_json::Value = serde_json::from_str(&text).expect("JSON");
    let rows = protocol["rows"].as_array().expect("rows").iter();
    rows.map(|row| row.as_array().expect("a row")[4..].to_vec().into()).collect()
}

/// Both droplets hold their electrodes, and the previous electrode stays on while they move on; numbers are 5 c + r -
/// 7.
#[test]
fn a_step_of_microdrop_stands_for_each_frame() {
    let steps = microdrop_steps(&board_on_driver(Protocol::Dropbot));
    let on = |channels: [u32; 2]| channels.map(|number| format!("electrode{number:03}"));
    let frames = [(0.005, [8, 35]), (0.006, [13, 36]), (0.005, [8, 35]), (0.005, [3, 34])];
    let expected = frames.map(|(seconds, channels)| json!([seconds, on(channels), 100, 10_000]));
    assert_eq!(steps, expected);
    let steps = microdrop_steps(&board_on_driver(Protocol::Opendrop));
    assert_eq!(steps, frames.map(|(seconds, channels)| json!([seconds, on(channels)])), "nothing to set");
}

/// The electrode at (1, 5) shares its channel with those at (4, 1) and (4, 3): one number in the frames, but one name
/// for each in MicroDrop. The channel has the name of its first electrode, row by row.
#[test]
fn a_shared_channel_is_one_channel_and_all_its_electrodes() {
    let number = |cell: ElectrodeCell| match cell.pair() {
        [4, 1] | [4, 3] => Some(3),
        _ => (5 * cell.column + cell.row).checked_sub(7),
    };
    let board = numbered_board(Protocol::Dropbot, number);
    let names: Vec<&str> = board.verified.schedule().channels.iter().map(|own| own.name.as_str()).collect();
    assert_eq!(names, ["plate.e4_1", "plate.e8_1", "plate.e8_2", "plate.e8_3", "plate.e2_5", "plate.e3_5"]);
    let text = file(Format::Frames, &board, "driver.frames.csv");
    let last = text.lines().last().expect("a row");
    assert!(last.ends_with(",3 34"), "{text}");
    let steps = microdrop_steps(&board);
    let on = ["electrode003", "electrode003_2", "electrode003_3", "electrode034"];
    assert_eq!(steps.last().expect("a step")[1], json!(on));
    let device = file(Format::Microdrop, &board, "driver.microdrop.svg");
    assert_eq!(device.matches("data-channels=\"3\"").count(), 3);
    assert_eq!(device.matches("<path ").count(), 39);
    let protocol = file(Format::Microdrop, &board, "driver.microdrop.json");
    assert!(protocol.contains("\"electrode003_3\":3"), "{protocol}");
}

/// A prompt is shown before its step, with the electrodes that were on before.
#[test]
fn prompts_are_messages_of_the_steps_behind_them() {
    let steps = microdrop_steps(&prompting_board(Protocol::Opendrop));
    let asked: Vec<(f64, &str)> =
        steps.iter().map(|step| (step[0].as_f64().expect("seconds"), step[2].as_str().expect("a message"))).collect();
    let expected = [
        (0.0, ""),
        (0.005, "fill the board"),
        (0.005, ""),
        (0.001, "add \"oil\""),
        (0.005, ""),
        (0.005, ""),
        (0.0, "done?"),
    ];
    assert_eq!(asked, expected);
    for before in [0, 2, 5] {
        assert_eq!(steps[before][1], steps[before + 1][1], "what is on stays so");
    }
}

/// Electrodes are squares of twice the radius, 70 um, on a pitch of 94.5 um, and a pixel is 1/96 of an inch.
#[test]
fn the_device_of_microdrop_has_the_sizes_of_the_board() {
    let text = file(Format::Microdrop, &board_on_driver(Protocol::Opendrop), "driver.microdrop.svg");
    let px = |um: f64| {
        let text = format!("{:.5}", um * 96.0 / 25_400.0);
        text.trim_end_matches('0').trim_end_matches('.').to_owned()
    };
    assert!(text.contains(&format!("width=\"{}\" height=\"{}\"", px(8.0 * 94.5), px(5.0 * 94.5))), "{text}");
    // (3, 4) lies in the second row from the top.
    let [left, right, top, bottom] = [236.25 - 35.0, 236.25 + 35.0, 141.75 - 35.0, 141.75 + 35.0].map(px);
    let path = format!("d=\"M {left},{top} H {right} V {bottom} H {left} Z\"");
    let line = text.lines().find(|line| line.contains("id=\"electrode012\"")).expect("its electrode");
    assert!(line.contains("data-channels=\"12\"") && line.contains(&path), "{line}");
    // One of 40 places is empty, so there are 8 x 4 and 7 x 5 pairs minus its two.
    assert_eq!([text.matches("<path ").count(), text.matches("<line ").count()], [39, 32 + 35 - 2]);
}

#[test]
fn what_microdrop_has_no_form_for_is_refused() {
    let refused = |fixture: FixtureSchedule| {
        let error =
            emit(Format::Microdrop, &fixture.verified, &fixture.provenance).expect_err("it has no form").diagnostic();
        (error.code, error.title)
    };
    let changed = |change: &dyn Fn(&mut Schedule)| {
        refused(board_on_driver(Protocol::Dropbot).changed(|schedule| change(schedule)))
    };
    assert_eq!(refused(fixture::fetch()).0, Code::E0824, "no driver");
    assert_eq!(refused(board_on_driver(Protocol::Purpledrop)).0, Code::E0824, "it does not drive it");
    let lamp = refused(on_driver(fixture::fetch(), Protocol::Dropbot));
    assert!(lamp.0 == Code::E0831 && lamp.1.contains("not an electrode of a board"), "{lamp:?}");
    let volts = |on_v: f64| {
        changed(&|schedule| {
            for drive in schedule.bench.drives.values_mut() {
                drive.link = Link::Switch { on_v };
            }
        })
    };
    assert!(volts(82.5).1.contains("82.5 V"), "{:?}", volts(82.5));
    let two = changed(&|schedule| {
        let drive = schedule.bench.drives.get_mut("plate.e2_5").expect("its wire");
        drive.link = Link::Switch { on_v: 90.0 };
    });
    assert!(two.0 == Code::E0831 && two.1.contains("one voltage for all"), "{two:?}");
    assert!(changed(&|schedule| schedule.channels[0].rest_v = 100.0).1.contains("rests on"));
    let bounded = changed(&|schedule| schedule.holds = vec![hold(0, "now", true)]);
    assert!(bounded.0 == Code::E0831 && bounded.1.contains("longest time"), "{bounded:?}");
    let input = changed(&|schedule| {
        let mut wait = hold(0, "", false);
        wait.terms.awaited =
            Awaited::Input { name: "ready".to_owned(), place: None, level: crate::device::instrument::Level::High };
        schedule.holds = vec![wait];
    });
    assert!(input.0 == Code::E0831 && input.1.contains("`ready`"), "{input:?}");
}
