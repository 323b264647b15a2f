use super::{EmitError, Format, Provenance, emit, fixture};
use crate::diagnostic::Code;
use crate::schedule::json;
use crate::verify::Verified;

fn one(format: Format, (verified, provenance): &(Verified, Provenance)) -> Vec<u8> {
    let mut files = emit(format, verified, provenance).expect("the fixture can be written");
    files.remove(0).bytes
}

fn text(format: Format, fixture: &(Verified, Provenance)) -> String {
    String::from_utf8(one(format, fixture)).expect("the format is text")
}

fn code(format: Format, verified: &Verified) -> Code {
    let error = emit(format, verified, &Provenance::default()).expect_err("the schedule cannot be written");
    error.diagnostic().code
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
    for format in Format::ALL {
        for make in [fixture::fetch, fixture::pair, fixture::idle] {
            let (verified, provenance) = make();
            let (again, _) = make();
            let files = emit(*format, &verified, &provenance).unwrap();
            assert_eq!(files, emit(*format, &again, &provenance).unwrap());
            assert!(!files.is_empty());
            assert!(
                files.iter().all(|file| file.name.starts_with(&verified.schedule().name) && !file.bytes.is_empty())
            );
        }
    }
}

#[test]
fn json_comes_back_as_it_was() {
    for make in [fixture::fetch, fixture::pair, fixture::large, fixture::idle] {
        let fixture = make();
        let bytes = one(Format::Json, &fixture);
        let back = json::read(&bytes).unwrap();
        assert_eq!(&back, fixture.0.schedule());
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
    assert_eq!(rows.len(), 1 + fixture::fetch().0.schedule().actuations.len());
    assert!(rows.last().unwrap().ends_with(",0,0,0,0"));
    assert!(super::fixture::pair().0.schedule().channels.last().unwrap().wire.is_none());
    assert!(self::text(Format::Csv, &fixture::pair()).lines().next().unwrap().ends_with(",Aid.br1.reset [V]"));
}

#[test]
fn a_ramp_is_refused_where_values_are_held() {
    let (flat, _) = fixture::fetch();
    let ramp = fixture::changed(&flat, |schedule| schedule.actuations[3].to = 10.0);
    for format in [Format::Csv, Format::Vcd, Format::Scpi] {
        assert_eq!(code(format, &ramp), Code::E0821);
        assert!(emit(format, &flat, &Provenance::default()).is_ok());
    }
    for format in [Format::Mcap, Format::Json, Format::Pwl] {
        assert!(emit(format, &ramp, &Provenance::default()).is_ok());
    }
}

#[test]
fn what_is_not_finite_is_refused() {
    let (good, _) = fixture::fetch();
    let voltage = fixture::changed(&good, |schedule| schedule.actuations[0].from = f64::INFINITY);
    let cost = fixture::changed(&good, |schedule| schedule.plans[0].cost = f64::NAN);
    for format in Format::ALL {
        assert_eq!(code(*format, &voltage), Code::E0820);
        assert_eq!(emit(*format, &cost, &Provenance::default()), Err(EmitError::NotFinite));
    }
}

/// Writes every format of every fixture into the folder that `TWEEZE_FIXTURES` names, for `tests/oracles/run.py`; what runs on
/// slopes, and so cannot be written in every format, into its folder `slopes`.
#[test]
#[ignore = "writes files: for the judges under tests/oracles"]
fn write_fixtures() {
    let folder = std::env::var_os("TWEEZE_FIXTURES").expect("TWEEZE_FIXTURES names a folder");
    let folder = std::path::PathBuf::from(folder);
    let slopes = folder.join("slopes");
    std::fs::create_dir_all(&slopes).unwrap();
    let write = |folder: &std::path::Path, format: Format, (verified, provenance): (Verified, Provenance)| {
        for file in emit(format, &verified, &provenance).unwrap() {
            std::fs::write(folder.join(file.name), file.bytes).unwrap();
        }
    };
    for format in Format::ALL {
        for fixture in [fixture::fetch(), fixture::pair(), fixture::large(), fixture::idle()] {
            write(&folder, *format, fixture);
        }
    }
    for format in [Format::Mcap, Format::Json, Format::Pwl] {
        write(&slopes, format, fixture::crowd());
    }
}

/// The JSON of a fixture, and whether the schema and the reader take it.
fn judged(change: impl FnOnce(&mut serde_json::Value)) -> (bool, bool) {
    let schema: serde_json::Value =
        serde_json::from_str(include_str!("../../schema/schedule.schema.json")).expect("the schema is JSON");
    let validator = jsonschema::validator_for(&schema).expect("the schema is a schema");
    let mut value = serde_json::from_slice(&one(Format::Json, &fixture::pair())).unwrap();
    change(&mut value);
    let read = json::read(&serde_json::to_vec(&value).unwrap());
    (validator.is_valid(&value), read.is_ok())
}

#[test]
fn json_keeps_to_its_schema() {
    assert_eq!(judged(|_| ()), (true, true));
    let changes: &[fn(&mut serde_json::Value)] = &[
        |value| value["version"] = 2.into(),
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
fn json_with_indices_out_of_range_is_refused() {
    let last = fixture::pair().0.schedule().channels.len();
    assert_eq!(judged(|value| value["actuations"][0]["channel"] = (last - 1).into()), (true, true));
    assert_eq!(judged(|value| value["actuations"][0]["channel"] = last.into()), (true, false));
    assert_eq!(judged(|value| value["actuations"][0]["step"] = 3.into()), (true, false));
    assert_eq!(judged(|value| value["steps"][0]["plan"] = 2.into()), (true, false));
    assert_eq!(judged(|value| value["actuations"][0]["start_ns"] = json::MAX_DURATION_NS.into()), (true, true));
}

#[test]
fn vcd_finds_channels_under_their_names_and_their_wires() {
    let text = text(Format::Vcd, &fixture::pair());
    assert!(text.contains("$comment bot.bl0.set [V] wire: Dev1/port0/line0 $end\n"));
    assert!(
        text.contains("$scope module bl0 $end\n$var real 64 a set $end\n$var real 64 b reset $end\n$upscope $end\n")
    );
    assert!(text.contains("$scope module wires $end\n$var real 64 a Dev1/port0/line0 $end\n"));
    assert!(text.contains("#0\n$dumpvars\nr20 a\nr0 b\n"));
    assert!(text.ends_with("\n#112500000\n"));
}

#[test]
fn pwl_steps_rise_in_a_nanosecond_and_slopes_are_exact() {
    let (crowd, _) = fixture::crowd();
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
fn scpi_begins_and_ends_at_zero_and_puts_every_edge_on_a_sample() {
    let script = one(Format::Scpi, &fixture::fetch());
    let head = b":SOUR1:DATA:ARB:DAC CH1,#224";
    let at = script.windows(head.len()).position(|window| window == head).unwrap() + head.len();
    let codes: Vec<i16> = script[at..at + 24].chunks(2).map(|pair| i16::from_be_bytes([pair[0], pair[1]])).collect();
    assert_eq!(codes, [0, i16::MAX, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0]);
    let text = String::from_utf8_lossy(&script).into_owned();
    assert!(text.contains("\n:SOUR1:FUNC:ARB:PER 0.180000000\n"));
    assert!(text.contains("\n:OUTP1:LOAD INF\n:SOUR1:VOLT 40\n"));
    assert!(text.starts_with("*RST\n*CLS\n") && text.ends_with(":OUTP20 ON\n:SYST:ERR?\n*TRG\n"));
    let notes = emit(Format::Scpi, &fixture::fetch().0, &Provenance::default()).unwrap().remove(1);
    assert_eq!(notes.name, "fetch.scpi.txt");
    assert!(String::from_utf8(notes.bytes).unwrap().contains("1\tCH1\t20\tbot.bl0.set\tDev1/port0/line0\n"));
}

#[test]
fn scpi_is_refused_past_the_memory_and_the_outputs_of_the_instrument() {
    let (fetch, _) = fixture::fetch();
    let signals = super::Signals::new(fetch.schedule());
    let profile = |most_points, outputs| super::scpi::Profile { most_points, outputs, ..super::scpi::GENERIC };
    assert!(super::scpi::write(&signals, &profile(12, 20)).is_ok());
    let Err(error) = super::scpi::write(&signals, &profile(11, 20)) else { panic!("12 points are too many") };
    assert_eq!(error.diagnostic().code, Code::E0823);
    assert_eq!(
        error.diagnostic().title,
        "12 points of 15000000 ns make up the 150000000 ns of the schedule, the instrument takes 11"
    );
    let Err(error) = super::scpi::write(&signals, &profile(12, 19)) else { panic!("20 channels are too many") };
    assert_eq!(error.diagnostic().code, Code::E0824);
    let one_ns = fixture::changed(&fetch, |schedule| schedule.duration_ns += 1);
    assert_eq!(code(Format::Scpi, &one_ns), Code::E0823);
}

#[test]
fn text_that_its_readers_could_not_hold_is_refused() {
    let limit = super::error::MAX_TEXT_BYTES;
    assert_eq!(EmitError::refuse_size(Format::Csv, limit, limit), Ok(()));
    let Err(error) = EmitError::refuse_size(Format::Csv, limit + 1, limit) else { panic!("a byte too many") };
    assert_eq!(error.diagnostic().code, Code::E0822);
}
