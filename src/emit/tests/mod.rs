use super::fixture::FixtureSchedule;
use super::signal::SignalCursor;
use super::{EmitError, Format, Provenance, emit, fixture};
use crate::device::instrument::Protocol;
use crate::device::{Kind, Outcome};
use crate::diagnostic::Code;
use crate::schedule::{Actuation, ChannelUnit, json};
use crate::verify::Verified;
use std::collections::BTreeSet;

pub(super) mod bench;
mod positions;

fn one(format: Format, fixture: &FixtureSchedule) -> Vec<u8> {
    let mut files = emit(format, &fixture.verified, &fixture.provenance).expect("the fixture can be written");
    files.remove(0).bytes
}

fn text(format: Format, fixture: &FixtureSchedule) -> String {
    String::from_utf8(one(format, fixture)).expect("the format is text")
}

fn code(format: Format, verified: &Verified) -> Code {
    let error = emit(format, verified, &Provenance::default()).expect_err("the schedule cannot be written");
    error.diagnostic().code
}

/// The formats that a fixture can be written in: G-code is for stages only, and instruments play the channels wired to
/// them.
fn formats(verified: &Verified) -> impl Iterator<Item = Format> {
    let all_stages = verified.schedule().channels.iter().all(|channel| channel.unit == ChannelUnit::Micrometre);
    let is_wired = !verified.schedule().bench.is_empty();
    Format::ALL.iter().copied().filter(move |format| match format {
        Format::Gcode => all_stages,
        Format::Scpi => is_wired,
        Format::Nidaqmx | Format::Frames | Format::Opendrop | Format::Microdrop | Format::Stages | Format::Sheet => {
            false
        }
        Format::Mcap | Format::Json | Format::Csv | Format::Vcd | Format::Pwl | Format::Html | Format::Svg => true,
    })
}

#[test]
fn names_find_their_formats() {
    for format in Format::ALL {
        assert_eq!(Format::find(format.name()), Some(*format));
    }
    assert_eq!(Format::find("MCAP"), None);
}

#[test]
fn the_same_schedule_gives_the_same_bytes() {
    for make in [fixture::fetch, fixture::pair, fixture::idle, fixture::bed, fixture::paces, fixture::hand] {
        let FixtureSchedule { verified, provenance } = make();
        for format in formats(&verified) {
            let again = make().verified;
            let files = emit(format, &verified, &provenance).unwrap();
            assert_eq!(files, emit(format, &again, &provenance).unwrap());
            assert!(!files.is_empty());
            assert!(
                files.iter().all(|file| file.name.starts_with(&verified.schedule().name) && !file.bytes.is_empty())
            );
        }
    }
}

#[test]
fn json_comes_back_as_it_was() {
    for make in
        [fixture::fetch, fixture::pair, fixture::large, fixture::idle, fixture::bed, fixture::paces, fixture::hand]
    {
        let fixture = make();
        let bytes = one(Format::Json, &fixture);
        let back = json::read(&bytes).unwrap();
        assert_eq!(&back, fixture.verified.schedule());
        assert_eq!(json::write(&back), bytes);
    }
}

#[test]
fn csv_has_a_row_for_each_change_and_units_and_wires_in_the_header() {
    let text = text(Format::Csv, &fixture::fetch());
    let mut lines = text.lines();
    let header: Vec<&str> = lines.next().unwrap().split(',').collect();
    assert_eq!(header[..2], ["time [ns]", "bot.bl0.set [V] @ Dev1/port0/line0"]);
    assert_eq!(header.len(), 21);
    let rows: Vec<&str> = lines.collect();
    assert_eq!(rows[0], "0,20,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0");
    assert_eq!(rows.len(), 1 + fixture::fetch().verified.schedule().actuations.len());
    assert!(rows.last().unwrap().ends_with(",0,0,0,0"));
    assert!(super::fixture::pair().verified.schedule().channels.last().unwrap().wire.is_none());
    assert!(self::text(Format::Csv, &fixture::pair()).lines().next().unwrap().ends_with(",Aid.br1.reset [V]"));
}

#[test]
fn a_ramp_is_refused_where_voltages_are_held() {
    let flat = fixture::fetch().verified;
    let ramp = fixture::changed(&flat, |schedule| schedule.actuations[3].to = 10.0);
    for format in [Format::Csv, Format::Vcd] {
        assert_eq!(code(format, &ramp), Code::E0821);
        assert!(emit(format, &flat, &Provenance::default()).is_ok());
    }
    for format in [Format::Mcap, Format::Json, Format::Pwl] {
        assert!(emit(format, &ramp, &Provenance::default()).is_ok());
    }
}

#[test]
fn what_is_not_finite_is_refused() {
    let good = fixture::fetch().verified;
    let voltage = fixture::changed(&good, |schedule| schedule.actuations[0].from = f64::INFINITY);
    let cost = fixture::changed(&good, |schedule| schedule.plans[0].cost = f64::NAN);
    for format in Format::ALL {
        assert_eq!(code(*format, &voltage), Code::E0820);
        assert_eq!(emit(*format, &cost, &Provenance::default()), Err(EmitError::NotFinite));
    }
}

/// Writes every format of every fixture into the folder that `TWEEZE_FIXTURES` names, for `tests/oracles/run.py`.
/// Fixtures with slopes, which not every format can represent, go into its folder `slopes`, and a long drive train into
/// `trains`.
#[test]
#[ignore = "writes files: for the judges under tests/oracles"]
fn write_fixtures() {
    let folder = std::env::var_os("TWEEZE_FIXTURES").expect("TWEEZE_FIXTURES names a folder");
    let folder = std::path::PathBuf::from(folder);
    let (slopes, trains) = (folder.join("slopes"), folder.join("trains"));
    std::fs::create_dir_all(&trains).unwrap();
    std::fs::create_dir_all(&slopes).unwrap();
    for make in
        [fixture::fetch, fixture::pair, fixture::large, fixture::idle, fixture::bed, fixture::hand, fixture::mixed]
    {
        let make = || bench::on_generators(make());
        formats(&make().verified).for_each(|format| write(&folder, format, &make()));
    }
    let paces = || bench::on(fixture::paces(), bench::fast_generator());
    formats(&paces().verified).for_each(|format| write(&folder, format, &paces()));
    for format in [Format::Json, Format::Csv, Format::Vcd, Format::Pwl, Format::Scpi, Format::Svg] {
        // Longer than the run of the deck.
        let long = fixture::train(12_000).changed(|schedule| schedule.name = "long".to_owned());
        write(&trains, format, &bench::on_generators(long));
    }
    let cards = folder.join("cards");
    std::fs::create_dir_all(&cards).unwrap();
    for make in [fixture::fetch, fixture::hand] {
        for format in [Format::Json, Format::Nidaqmx] {
            write(&cards, format, &super::nidaqmx::tests::on_card(make(), 1e6));
        }
    }
    let drivers = folder.join("drivers");
    std::fs::create_dir_all(&drivers).unwrap();
    for (name, protocol) in [("od", Protocol::Opendrop), ("pd", Protocol::Purpledrop)] {
        let fixture = super::frames::tests::on_driver(fixture::fetch(), protocol);
        let named = fixture.changed(|schedule| schedule.name = name.to_owned());
        for format in [Format::Json, Format::Frames] {
            write(&drivers, format, &named);
        }
    }
    type Make = fn(Protocol) -> FixtureSchedule;
    let boards: [(&str, Protocol, Make); 3] = [
        ("db", Protocol::Dropbot, super::frames::tests::board_on_driver),
        ("ob", Protocol::Opendrop, super::frames::tests::board_on_driver),
        ("ask", Protocol::Dropbot, super::frames::tests::prompting_board),
    ];
    for (name, protocol, make) in boards {
        let fixture = make(protocol);
        let named = fixture.changed(|schedule| schedule.name = name.to_owned());
        for format in [Format::Json, Format::Frames, Format::Microdrop] {
            write(&drivers, format, &named);
        }
    }
    let fixture = super::frames::tests::board_with_magnet();
    let named = fixture.changed(|schedule| schedule.name = "lift".to_owned());
    for format in [Format::Json, Format::Frames] {
        write(&drivers, format, &named);
    }
    write_controllers(&folder.join("controllers"));
    for format in [Format::Mcap, Format::Json, Format::Pwl, Format::Svg] {
        write(&slopes, format, &fixture::crowd());
    }
}

/// Writes hands on PI and SmarAct controllers, and on a machine.
fn write_controllers(folder: &std::path::Path) {
    std::fs::create_dir_all(folder).unwrap();
    for (name, facts) in [("pi", super::stages::tests::gcs(9000)), ("smaract", super::stages::tests::mcs2())] {
        let fixture = super::stages::tests::on_controllers(fixture::hand(), &facts);
        let named = fixture.changed(|schedule| schedule.name = name.to_owned());
        for format in [Format::Json, Format::Stages] {
            write(folder, format, &named);
        }
    }
    let machine = bench::on_machine(fixture::hand()).changed(|schedule| schedule.name = "mill".to_owned());
    for format in [Format::Mcap, Format::Json, Format::Gcode] {
        write(folder, format, &machine);
    }
}

/// Writes the files of a format into a folder.
fn write(folder: &std::path::Path, format: Format, fixture: &FixtureSchedule) {
    for file in emit(format, &fixture.verified, &fixture.provenance).unwrap() {
        std::fs::write(folder.join(file.name), file.bytes).unwrap();
    }
}

/// A change of a document.
type Edit = fn(&mut serde_json::Value);

/// The JSON of the pair after a change, judged: whether the schema and the reader accept it.
fn judged(change: impl FnOnce(&mut serde_json::Value)) -> (bool, bool) {
    judged_of(fixture::pair(), change)
}

fn judged_of(fixture: FixtureSchedule, change: impl FnOnce(&mut serde_json::Value)) -> (bool, bool) {
    let schema: serde_json::Value =
        serde_json::from_str(include_str!("../../../schema/schedule.schema.json")).expect("the schema is JSON");
    let validator = jsonschema::validator_for(&schema).expect("the schema is a schema");
    let mut value = serde_json::from_slice(&one(Format::Json, &fixture)).unwrap();
    change(&mut value);
    let read = json::read(&serde_json::to_vec(&value).unwrap());
    (validator.is_valid(&value), read.is_ok())
}

#[test]
fn json_keeps_to_its_schema() {
    assert_eq!(judged(|_| ()), (true, true));
    assert_eq!(judged(|value| value["source"]["settings"] = serde_json::json!(["pitch=80um"])), (true, true));
    assert_eq!(judged_of(crate::emit::frames::tests::board_with_magnet(), |_| ()), (true, true));
    let changes: &[fn(&mut serde_json::Value)] = &[
        |value| value["version"] = 1.into(),
        |value| value["format"] = "schedule".into(),
        |value| value["duration_ns"] = (-1).into(),
        |value| value["duration_ns"] = u64::MAX.into(),
        |value| value["duration_ns"] = 1.5.into(),
        |value| value["channels"][0]["unit"] = "A".into(),
        |value| value["channels"][0]["wire"] = 7.into(),
        |value| value["actuations"][0]["duration_ns"] = 0.into(),
        |value| value["actuations"][0]["from"] = serde_json::Value::Null,
        |value| value["actuations"][0]["channel"] = (-1).into(),
        |value| value["plans"][0]["kind"] = "snail".into(),
        |value| value["plans"][0]["states"][0]["cell"] = serde_json::json!([1]),
        |value| value["plans"][0]["states"][0]["position_um"] = serde_json::json!([1.0, 2.0, 3.0]),
        |value| drop(value.as_object_mut().unwrap().remove("steps")),
        |value| drop(value["plans"][0]["states"][0].as_object_mut().unwrap().remove("word")),
    ];
    for (index, change) in changes.iter().enumerate() {
        assert_eq!(judged(change), (false, false), "change {index}");
    }
    let stricter: &[fn(&mut serde_json::Value)] = &[
        |value| value["actuations"][0]["colour"] = "red".into(),
        |value| value["source"]["sha256"] = "0f".into(),
        |value| value["extra"] = 1.into(),
        |value| value["steps"][0]["line"] = 0.into(),
    ];
    for (index, change) in stricter.iter().enumerate() {
        assert_eq!(judged(change), (false, true), "change {index}");
    }
}

#[test]
fn numbers_of_json_have_one_unit_each_at_the_end_of_their_keys() {
    const UNITS: [&str; 10] = ["um", "deg", "ns", "v", "hz", "v_per_um", "v_per_s", "um_per_s", "um_per_s2", "j"];
    /// Keys without a unit suffix: a factor, and values whose unit is the `unit` of their plan or channel.
    const WITHOUT: [&str; 5] = ["gain", "cost", "bound", "from", "to"];
    let schema: serde_json::Value =
        serde_json::from_str(include_str!("../../../schema/schedule.schema.json")).expect("the schema is JSON");
    let (mut keys, mut rest) = (Vec::new(), vec![&schema]);
    while let Some(part) = rest.pop() {
        if let Some(properties) = part.get("properties").and_then(|properties| properties.as_object()) {
            let is_number = |kind: &serde_json::Value| kind == "number" || kind[0] == "number";
            keys.extend(properties.iter().filter(|(_, sort)| is_number(&sort["type"])).map(|(key, _)| key.as_str()));
        }
        rest.extend(part.as_object().into_iter().flat_map(|object| object.values()));
        rest.extend(part.as_array().into_iter().flatten());
    }
    assert!(keys.len() > 20, "{keys:?}");
    let has_unit = |key: &str| UNITS.iter().any(|unit| key.ends_with(&format!("_{unit}")));
    let bare: Vec<&str> = keys.into_iter().filter(|key| !has_unit(key) && !WITHOUT.contains(key)).collect();
    assert_eq!(bare, [""; 0]);
    // Keys of outcomes come from the vocabulary.
    let outcomes = Kind::ALL.iter().flat_map(|kind| kind.vocabulary().outcomes).map(Outcome::key);
    let listed = schema["$defs"]["outcomes"]["properties"].as_object().expect("outcomes by key");
    assert_eq!(outcomes.collect::<BTreeSet<String>>(), listed.keys().cloned().collect());
}

#[test]
fn json_with_indices_out_of_range_is_refused() {
    let last = fixture::pair().verified.schedule().channels.len();
    assert_eq!(judged(|value| value["actuations"][0]["channel"] = (last - 1).into()), (true, true));
    assert_eq!(judged(|value| value["actuations"][0]["channel"] = last.into()), (true, false));
    assert_eq!(judged(|value| value["actuations"][0]["step"] = 3.into()), (true, false));
    assert_eq!(judged(|value| value["steps"][0]["plan"] = 2.into()), (true, false));
    assert_eq!(judged(|value| value["actuations"][0]["start_ns"] = json::MAX_DURATION_NS.into()), (true, true));
}

#[test]
fn vcd_finds_channels_under_their_names_and_their_wires() {
    let text = text(Format::Vcd, &fixture::pair());
    assert!(text.contains("$comment bot_bl0_set is bot.bl0.set [V], 1 stands for 20 V, wire: Dev1/port0/line0 $end\n"));
    assert!(
        text.contains("$timescale 100 us $end\n$scope module bot $end\n$var wire 1 a bot_bl0_set $end\n"),
        "{text}"
    );
    let mut codes =
        text.lines().filter_map(|line| line.strip_prefix("$var wire 1 ")?.strip_suffix(" Dev1/port0/line0 $end"));
    let code = codes.next_back().expect("the wire has a variable");
    assert!(text.contains(&format!("#0\n$dumpvars\n1a\n1{code}\n0b\n")), "{text}");
    assert!(text.ends_with("\n#1125\n"));
}

#[test]
fn vcd_has_a_bit_for_a_voltage_of_two_levels_only() {
    let fetch = fixture::fetch();
    let lines = |fixture: &FixtureSchedule| {
        let text = text(Format::Vcd, fixture);
        let own = text.lines().filter(|line| line.contains("bot_bl0_set")).map(str::to_owned).collect::<Vec<_>>();
        assert_eq!(own.len(), 2, "a comment and a variable");
        own.join("\n")
    };
    assert!(lines(&fetch).contains("1 stands for 20 V") && lines(&fetch).contains("$var wire 1 a "));
    let other = |volts: f64| {
        fetch.clone().changed(|schedule| {
            let last = Actuation { start_ns: schedule.duration_ns, from: volts, to: volts, ..schedule.actuations[0] };
            schedule.duration_ns = last.end_ns();
            schedule.actuations.push(last);
        })
    };
    assert!(lines(&other(0.0)).contains("$var wire 1 a "), "0 V is no third level");
    assert!(lines(&other(19.0)).contains("[V], wire: ") && lines(&other(19.0)).contains("$var real 64 a "));
    let never = fetch.changed(|schedule| schedule.actuations.retain(|actuation| actuation.channel != 0));
    assert!(lines(&never).contains("0 V throughout") && lines(&never).contains("$var wire 1 a "));
}

#[test]
fn vcd_of_a_train_changes_only_at_its_ends() {
    let text = text(Format::Vcd, &fixture::bed());
    let declared = "$timescale 100 us $end\n$scope module m $end\n$var wire 1 a m_bed_train $end\n$var real 64 b m_bed_first $end\n\
                    $var real 64 c m_bed_second $end\n$var real 64 d m_bed_period_ns $end\n$upscope $end\n";
    assert!(text.contains(declared), "{text}");
    assert!(text.contains("\n#20\n1a\n1e\nr130 b\nr115 c\nr50000 d\n#320\n"), "{text}");
    let files = emit(Format::Vcd, &fixture::bed().verified, &Provenance::default()).unwrap();
    assert_eq!(files[1].name, "bed.gtkw");
    let view = String::from_utf8(files[1].bytes.clone()).unwrap();
    assert!(view.contains("@800200\n-m\n@28\nm.m_bed_train\n@8420\nm.m_bed_first\n"), "{view}");
}

#[test]
fn pwl_steps_rise_in_a_nanosecond_and_slopes_are_exact() {
    let crowd = fixture::crowd().verified;
    let files = emit(Format::Pwl, &crowd, &Provenance::default()).unwrap();
    assert_eq!(files.iter().map(|file| file.name.as_str()).collect::<Vec<_>>(), ["crowd.pwl.inc", "crowd.cir"]);
    let text = String::from_utf8(files[0].bytes.clone()).unwrap();
    let source = text.split("Vbot_e0 bot_e0 0 PWL(\n").nth(1).unwrap().split("+ )").next().unwrap();
    let points: Vec<(f64, f64)> = source
        .lines()
        .map(|line| line.trim_start_matches("+ ").split_once(' ').unwrap())
        .map(|(t, v)| ((t.parse::<f64>().unwrap() * 1e9).round(), v.parse().unwrap()))
        .collect();
    assert!(points.windows(2).all(|pair| pair[0].0 < pair[1].0));
    let after = 1.0 + 1.0 / 300.0;
    let expected = [(0.0, 0.0), (1.0, after), (300.0, 2.0), (301.0, 2.01), (600.0, 5.0), (601.0, 0.0), (602.0, 3.0)];
    assert_eq!(points[..7], expected);
    assert_eq!(points[7..], [(901.0, 3.0), (902.0, 0.0), (1000.0, 0.0)]);
}

#[test]
fn text_that_its_readers_could_not_hold_is_refused() {
    let limit = super::error::MAX_TEXT_BYTES;
    assert_eq!(EmitError::refuse_size(Format::Csv, limit, limit), Ok(()));
    let Err(error) = EmitError::refuse_size(Format::Csv, limit + 1, limit) else { panic!("a byte too many") };
    assert_eq!(error.diagnostic().code, Code::E0822);
}

#[test]
fn json_of_swings_keeps_to_its_schema_and_its_sense() {
    let bed = |change: Edit| judged_of(fixture::bed(), change);
    assert_eq!(bed(|_| ()), (true, true));
    let changes: &[(Edit, (bool, bool))] = &[
        (|value| value["actuations"][2]["swing"]["period_ns"] = 0.into(), (false, false)),
        (|value| value["actuations"][2]["swing"]["period_ns"] = 15.into(), (false, false)),
        (|value| value["actuations"][2]["swing"]["period_ns"] = 200_000.into(), (true, true)),
        (|value| value["actuations"][2]["swing"]["period_ns"] = 70_000.into(), (true, false)),
        (|value| value["actuations"][2]["swing"]["levels"][0] = 131.into(), (true, false)),
        (|value| value["actuations"][2]["to"] = 114.into(), (true, false)),
        (|value| value["actuations"][2]["swing"]["levels"] = serde_json::json!([130.0]), (false, false)),
        (|value| value["plans"][0]["states"][0]["arms"][0] = 2.into(), (false, true)),
        (|value| value["plans"][0]["states"][0]["poses"]["D1"] = serde_json::json!([1.0, 2.0]), (false, false)),
        (|value| value["plans"][0]["states"][0]["docked"] = serde_json::json!(["D1", "D1"]), (false, true)),
    ];
    for (index, (change, expected)) in changes.iter().enumerate() {
        assert_eq!(bed(*change), *expected, "change {index}");
    }
    let place = |change: fn(&mut crate::schedule::Schedule)| {
        let bytes = json::write(fixture::changed(&fixture::bed().verified, change).schedule());
        json::read(&bytes).expect_err("a contradiction").to_string()
    };
    let odd = place(|schedule| schedule.actuations[2].swing.as_mut().unwrap().period_ns = 15);
    assert_eq!(odd, "`actuations[2].swing.period_ns` is zero or odd, so it has no halves");
    let part = place(|schedule| schedule.actuations[2].duration_ns += 1);
    assert_eq!(part, "`actuations[2].duration_ns` is not a whole number of its swing's periods");
    let levels = place(|schedule| schedule.actuations[2].from = 1.0);
    assert_eq!(levels, "`actuations[2].swing.levels` are not `from` and `to`");
}

#[test]
fn signals_tell_every_edge_of_swings_once() {
    let paces = fixture::paces().verified;
    let signals = super::Signals::new(paces.schedule());
    let at = |channel, instants: [u64; 6]| instants.map(|t_ns| signals.value(channel, t_ns));
    assert_eq!(at(0, [0, 2, 3, 6, 29, 30]), [5.0, 5.0, -2.5, 5.0, -2.5, 2.0]);
    assert_eq!([3, 6, 30, 50, 61].map(|t_ns| signals.value_before(0, t_ns)), [5.0, -2.5, -2.5, 2.0, 0.0]);
    let mut cursor = SignalCursor::new(&signals, 1);
    assert_eq!(
        [0, 7, 12, 45, 52].map(|t_ns| cursor.envelope(t_ns)),
        [[4.0; 2], [0.0; 2], [1.0, 3.0], [6.0, 8.0], [0.0; 2]]
    );
    for channels in [0..3, 0..1, 1..2, 2..3] {
        // Brute force over every nanosecond.
        let jumps = |t_ns: &u64| {
            channels.clone().any(|channel| signals.value_before(channel, *t_ns) != signals.value(channel, *t_ns))
        };
        let jumps: Vec<u64> = (0..=100).filter(jumps).collect();
        let edges: Vec<u64> = signals.edges(channels.clone()).collect();
        assert!(jumps.iter().all(|t_ns| edges.contains(t_ns)), "{channels:?}: {jumps:?} {edges:?}");
        assert!(edges.windows(2).all(|pair| pair[0] < pair[1]));
        assert!(signals.count_edges(channels) >= edges.len() as u64);
    }
    assert_eq!(signals.edges([0]).take(12).collect::<Vec<_>>(), [0, 3, 6, 9, 12, 15, 18, 21, 24, 27, 30, 50]);
}

#[test]
fn an_hour_of_strokes_is_a_small_file_in_every_format() {
    let hour = fixture::train(72_000_000);
    let rows = one(Format::Csv, &hour);
    let rows = String::from_utf8(rows).unwrap();
    assert!(
        rows.starts_with(
            "time [ns],m.bed.first [V] @ Dev2/ao0,m.bed.second [V] @ Dev2/ao0,m.bed.period [ns],m.bed.start [ns]\n"
        ),
        "{rows}"
    );
    assert!(rows.ends_with("\n2000000,130,115,50000,2000000\n3600002000000,0,0,0,0\n"), "{rows}");
    let formats = [Format::Json, Format::Csv, Format::Vcd, Format::Pwl].map(|format| (format, 10_000));
    for (format, most_bytes) in formats.into_iter().chain([(Format::Mcap, 20 << 20)]) {
        let files = emit(format, &hour.verified, &Provenance::default()).unwrap();
        let bytes: usize = files.iter().map(|file| file.bytes.len()).sum();
        assert!(bytes < most_bytes, "{format:?} takes {bytes} bytes");
    }
}

#[test]
fn pwl_puts_a_pulse_source_in_series_for_each_train() {
    let files = emit(Format::Pwl, &fixture::bed().verified, &Provenance::default()).unwrap();
    let text = String::from_utf8(files[0].bytes.clone()).unwrap();
    assert!(text.contains("\nVm_bed m_bed m_bed_train1 PWL(\n+ 0 0\n"));
    assert!(text.contains(
        "\nVm_bed_train1 m_bed_train1 m_bed_train2 PULSE(0 15 0.002 0.000000001 0.000000001 0.000024999 0.00005 600)\n"
    ));
    assert!(text.contains("\nVm_bed_train5 m_bed_train5 0 PULSE(0 15 "));
    let paces = emit(Format::Pwl, &fixture::paces().verified, &Provenance::default()).unwrap();
    let text = String::from_utf8(paces[0].bytes.clone()).unwrap();
    assert!(text.contains("\nVbot_e1 bot_e1 0 PWL(\n"), "levels of a nanosecond are written out");
    assert!(text.contains("\nVbot_e0_train1 bot_e0_train1 bot_e0_train2 PULSE(0 7.5 0 "));
    let deck = |strokes| {
        String::from_utf8(
            emit(Format::Pwl, &fixture::train(strokes).verified, &Provenance::default()).unwrap().remove(1).bytes,
        )
        .unwrap()
    };
    assert!(deck(9_990).contains("\n.tran 0.0005015 0.5015\n"));
    assert!(deck(1_200_000).contains("\n.tran 0.00050195 0.50195\n"));
    let whole = "this deck stops after 20000 of 2400006 edges, of which ngspice takes\n";
    assert!(deck(1_200_000).contains(whole), "{}", deck(1_200_000));
    assert!(deck(1_200_000).contains("*   .options interp\n*   .tran 0.0000125 60.002\n"), "{}", deck(1_200_000));
    assert!(deck(9_990).ends_with("\nquit 0\n.endc\n.end\n") && !deck(9_990).contains("interp"));
}

#[test]
fn a_page_holds_its_data_whatever_the_program_says() {
    let mut fixture = fixture::fetch();
    fixture.provenance.files[0].1.push_str("// </script><script>/*script*/ /*data*/ \u{2028} \"\\");
    let page = text(Format::Html, &fixture);
    assert_eq!(page.matches("</script>").count(), 2, "that of the data, and that of the script");
    let data = page.split_once(r#"<script type="application/json" id="data">"#).expect("the page has data").1;
    let data = data.split_once("</script>").expect("the data end").0;
    let data: serde_json::Value = serde_json::from_str(data).expect("the data are JSON");
    assert_eq!(data["sources"][0]["text"], fixture.provenance.files[0].1);
    let schedule = serde_json::from_slice::<serde_json::Value>(&json::write(fixture.verified.schedule())).unwrap();
    assert_eq!(data["schedule"], schedule);
    assert_eq!(data["claims"]["jobs"].as_array().map(Vec::len), Some(fixture.verified.claims().jobs.len()));
}
