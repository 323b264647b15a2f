use super::*;
use crate::device::electrode_array::Electrodes;
use crate::device::instrument::{Bench, Drive, Instrument, Link, StageLimits, Start};
use crate::diagnostic::Code;
use crate::emit::{Provenance, emit, fixture};
use crate::lower::electrode_array::tests::{carried, facts};
use crate::schedule::{Channel, ChannelUnit, State};
use crate::source::Span;
use crate::verify::Verified;

/// All voltages of a fixture on a driver, from channel 8 on.
pub fn on_driver((verified, provenance): (Verified, Provenance), protocol: Protocol) -> (Verified, Provenance) {
    let facts = ElectrodeDriverFacts {
        protocol,
        channels: 128,
        least_v: 0.0,
        most_v: 300.0,
        least_frame_ns: 1,
        start: Start::Sender,
    };
    let wired = fixture::changed(&verified, |schedule| {
        let mut bench = Bench::default();
        let instrument = Instrument { model: "a.driver".to_owned(), facts: InstrumentFacts::ElectrodeDriver(facts) };
        bench.instruments.insert("driver".to_owned(), instrument);
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
    });
    (wired, provenance)
}

fn file(format: Format, fixture: &(Verified, Provenance), ending: &str) -> String {
    let files = emit(format, &fixture.0, &fixture.1).expect("the fixture can be written");
    let name = format!("{}.{ending}", fixture.0.schedule().name);
    let found = files.into_iter().find(|file| file.name == name).expect("the file is written");
    String::from_utf8(found.bytes).expect("a text")
}

/// Five pulses of 15 ms, one each 30 ms, of the left and the right side in turn.
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
    assert_eq!(end, fixture.0.schedule().duration_ns as f64 / 1e6);
    assert!(rows[1..].windows(2).all(|pair| pair[0][3] != pair[1][3]), "neighbours differ: {text}");
    // Each instant of each channel is that of the schedule.
    let signals = Signals::new(fixture.0.schedule());
    for row in &rows[1..] {
        let start_ns = (row[1].parse::<f64>().expect("a number") * 1e6).round() as u64;
        let on: Vec<u32> = row[3].split_whitespace().map(|number| number.parse().expect("a channel")).collect();
        let expected = (0..signals.schedule.channels.len()).filter(|channel| signals.value(*channel, start_ns) != 0.0);
        assert_eq!(on, expected.map(|channel| channel as u32 + 8).collect::<Vec<_>>(), "{text}");
    }
}

/// Channel 8 x + y is character x of row y; the frames of the file are as long as one another.
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

/// The part is not in the first state, and so comes in the step that begins there.
#[test]
fn droplets_that_come_are_named_when_they_are_due() {
    let (_, mut schedule) = carried(&facts(Electrodes::Single), &[vec![vec![(5, 5), (6, 5), (7, 5)], vec![(12, 5)]]]);
    assert_eq!(dispensed(&schedule), Vec::<serde_json::Value>::new());
    let states = &mut schedule.plans[0].states;
    let name = states[2].state.cells().and_then(|parts| parts.keys().nth(1)).expect("a second part").clone();
    let at_s = states[1].t_ns as f64 / 1e9;
    for state in &mut states[..2] {
        let State::ElectrodeArray(board) = &mut state.state else { panic!("a board") };
        board.parts.remove(&name);
    }
    assert!(at_s > 0.0);
    assert_eq!(dispensed(&schedule), [json!({ "at_s": at_s, "droplet": name, "outlet": [12, 5] })]);
}

#[test]
fn what_cannot_be_written_says_why() {
    let code = |format, fixture: (Verified, Provenance)| {
        emit(format, &fixture.0, &fixture.1).map(|files| files.len()).map_err(|error| error.diagnostic().code)
    };
    assert_eq!(code(Format::Frames, fixture::fetch()), Err(Code::E0824), "no driver");
    assert_eq!(code(Format::Opendrop, on_driver(fixture::fetch(), Protocol::Purpledrop)), Err(Code::E0824));
    assert_eq!(code(Format::Frames, on_driver(fixture::fetch(), Protocol::Purpledrop)), Ok(2));
    let long = fixture::changed(&on_driver(fixture::fetch(), Protocol::Opendrop).0, |schedule| {
        schedule.actuations[0].duration_ns -= 1;
    });
    assert_eq!(code(Format::Opendrop, (long, Provenance::default())), Err(Code::E0823), "frames of 1 ns");
}
