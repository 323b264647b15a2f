//! Positions of stages in every format.

use super::{Edit, bench, code, judged_of, text};
use crate::diagnostic::Code;
use crate::emit::fixture::FixtureSchedule;
use crate::emit::signal::SignalCursor;
use crate::emit::{Format, Provenance, Signals, emit, fixture};
use crate::schedule::Channel;
use serde_json::json;

#[test]
fn stages_stay_where_they_are_before_and_after_their_runs() {
    let hand = fixture::hand().verified;
    let signals = Signals::new(hand.schedule());
    let end_ns = hand.schedule().duration_ns;
    assert_eq!([0, 6_999_999, 7_000_000].map(|t_ns| signals.value(0, t_ns)), [28.5; 3]);
    assert_eq!(signals.value_before(0, 0), 28.5);
    assert!((signals.value(0, 57_000_000) - 23.5).abs() < 1e-9, "half way in");
    assert_eq!(SignalCursor::new(&signals, 0).envelope(57_000_000), [signals.value(0, 57_000_000); 2]);
    let last = signals.of(2).last().unwrap().to;
    assert_eq!([end_ns - 3_000_000, end_ns].map(|t_ns| signals.value(2, t_ns)), [last; 2]);
    assert_eq!(last, 5.0);
    assert_eq!(signals.value_before(2, end_ns), last);
    assert_eq!(signals.first_jump(), None);
}

#[test]
fn csv_has_a_row_for_each_bend_of_a_position() {
    let text = text(Format::Csv, &fixture::hand());
    let mut lines = text.lines();
    assert!(lines.next().unwrap().starts_with("time [ns],hand.f1.x [um] @ stage1/x,hand.f1.y [um],"));
    let rows: Vec<Vec<f64>> =
        lines.map(|line| line.split(',').map(|number| number.parse().unwrap()).collect()).collect();
    assert_eq!(rows[0][..3], [0.0, 28.5, 0.0]);
    assert_eq!(rows[1][..3], [7e6, 28.5, 0.0]);
    assert_eq!(rows[2][..3], [107e6, 18.5, 0.0]);
}

#[test]
fn a_position_that_jumps_is_refused_where_lines_run_between_positions() {
    let jump = fixture::changed(&fixture::hand().verified, |schedule| schedule.actuations[0].from += 1.0);
    assert!(emit(Format::Csv, &jump, &Provenance::default()).is_ok(), "it begins elsewhere");
    let jump = fixture::changed(&jump, |schedule| schedule.actuations[0].to += 1.0);
    for format in [Format::Csv, Format::Gcode] {
        assert_eq!(code(format, &jump), Code::E0826);
    }
    for format in [Format::Mcap, Format::Json, Format::Vcd, Format::Pwl] {
        assert!(emit(format, &jump, &Provenance::default()).is_ok());
    }
}

#[test]
fn vcd_counts_positions_to_the_nearest_hundredth_of_a_micrometre() {
    let hand = fixture::hand();
    let text = text(Format::Vcd, &hand);
    assert!(
        text.contains("$comment hand_f1_x is hand.f1.x [um], the nearest multiple of 0.01 um, wire: stage1/x $end\n")
    );
    let schedule = hand.verified.schedule();
    let signals = Signals::new(schedule);
    let (mut t_ns, mut count, mut changes, mut last_ns) = (0u64, 28.5, 0, 0);
    let held = |count: f64, t_ns: u64| {
        let off_um = (count - signals.value(0, t_ns)).abs();
        assert!(off_um <= 0.005 + 1e-9, "{off_um} um off at {t_ns} ns");
    };
    for line in text.split("$enddefinitions $end\n").nth(1).unwrap().lines() {
        if let Some(instant) = line.strip_prefix('#') {
            t_ns = instant.parse().unwrap();
            assert!(t_ns > last_ns || t_ns == 0);
            (last_ns, changes) = (t_ns, changes + 1);
            held(count, t_ns.saturating_sub(1));
        } else if let Some(value) = line.strip_prefix('r').and_then(|line| line.strip_suffix(" a")) {
            count = value.parse().unwrap();
            held(count, t_ns);
        }
    }
    assert!(changes > 1000 && t_ns == schedule.duration_ns);
}

#[test]
fn pwl_bends_without_a_rise_and_says_its_scale() {
    let files = emit(Format::Pwl, &fixture::hand().verified, &Provenance::default()).unwrap();
    let text = String::from_utf8(files[0].bytes.clone()).unwrap();
    let head = "* hand.f1.x [um], 1 V stands for 1 um, wire stage1/x\nVhand_f1_x hand_f1_x 0 PWL(\n";
    assert!(text.contains(&format!("{head}+ 0 28.5\n+ 0.007 28.5\n+ 0.107 18.5\n+ 0.287 18.5\n")), "{text}");
}

#[test]
fn gcode_says_where_all_axes_are_at_their_common_instants() {
    let FixtureSchedule { verified: hand, provenance } = fixture::hand();
    let files = emit(Format::Gcode, &hand, &provenance).unwrap();
    assert_eq!(files.iter().map(|file| file.name.as_str()).collect::<Vec<_>>(), ["turn.hand.ngc"]);
    let text = String::from_utf8(files[0].bytes.clone()).unwrap();
    assert!(text.contains("; X is hand.f1.x, wire stage1/x\n") && text.contains("; C is hand.f3.z\n"), "{text}");
    let lines: Vec<&str> = text.lines().filter(|line| !line.starts_with(';')).collect();
    assert_eq!(lines[..2], ["G21", "G90"]);
    assert!(
        lines[2].starts_with("G64 P0.000025 ; ") && lines[3] == "G93",
        "half of the tolerance of 50 nm: {}",
        lines[2]
    );
    let finest =
        crate::emit::gcode::rounding_nm(&crate::claims::Claims { jobs: Vec::new(), ..hand.claims().clone() }, "hand");
    assert_eq!(finest, 0);
    assert!(lines[4].starts_with("G0 X0.028500 Y0.000000 Z0.000000 U-0.014250 V0.024682 "), "{}", lines[4]);
    assert_eq!(lines[6..8], ["G4 P0.007000000", "G1 X0.018500 F600"]);
    assert_eq!(lines[lines.len() - 3..], ["G1 Z0.005000 W0.005000 C0.005000 F1200", "G4 P0.053000000", "M2"]);
}

#[test]
fn gcode_moves_the_axes_that_wires_name_in_places_of_their_own_travel() {
    let FixtureSchedule { verified: hand, provenance } = bench::on_machine(fixture::hand());
    let files = emit(Format::Gcode, &hand, &provenance).unwrap();
    assert_eq!(files.iter().map(|file| file.name.as_str()).collect::<Vec<_>>(), ["turn.mill.ngc"]);
    let text = String::from_utf8(files[0].bytes.clone()).unwrap();
    assert!(text.contains("; X is hand.f3.z, whose 0 is at 500 um, forward\n"), "{text}");
    assert!(
        text.contains("; B is hand.f1.y, whose 0 is at 500 um, backward\n; C is hand.f1.x, whose 0 is at"),
        "{text}"
    );
    let lines: Vec<&str> = text.lines().filter(|line| !line.starts_with(';')).collect();
    // Half of the tolerance of 50 nm, less the under 5 nm that a cycle of 50 us cuts at the sharpest turn.
    assert!(lines[2].starts_with("G64 P0.000020 ; "), "{}", lines[2]);
    assert!(lines[4].ends_with(" B0.500000 C0.528500"), "{}", lines[4]);
    assert_eq!(lines[6..8], ["G4 P0.007000000", "G1 C0.518500 F600"]);
    let beside = fixture::changed(&hand, |schedule| {
        let other = schedule.bench.instruments["mill"].clone();
        schedule.bench.instruments.insert("other".to_owned(), other);
    });
    assert_eq!(code(Format::Gcode, &beside), Code::E0831);
    let idle = fixture::changed(&hand, |schedule| schedule.bench.drives.clear());
    assert_eq!(code(Format::Gcode, &idle), Code::E0824);
    assert_eq!(code(Format::Stages, &hand), Code::E0824);
    assert_eq!(judged_of(bench::on_machine(fixture::hand()), |_| ()), (true, true));
    let changes: [fn(&mut serde_json::Value); 2] = [
        |value| value["bench"]["instruments"]["mill"]["facts"]["machine_controller"]["axes"] = 10.into(),
        |value| value["bench"]["instruments"]["mill"]["facts"]["machine_controller"]["rate_hz"] = 0.into(),
    ];
    for change in changes {
        assert!(!judged_of(bench::on_machine(fixture::hand()), change).0);
    }
}

#[test]
fn gcode_is_refused_below_the_least_feed_of_its_interpreter() {
    let slowed = |times: u64| {
        fixture::changed(&fixture::hand().verified, |schedule| {
            schedule.duration_ns *= times;
            for actuation in &mut schedule.actuations {
                actuation.start_ns *= times;
                actuation.duration_ns *= times;
            }
        })
    };
    assert!(emit(Format::Gcode, &slowed(1), &Provenance::default()).is_ok());
    let times_as_high = |times: u64| {
        let error = emit(Format::Gcode, &slowed(times), &Provenance::default()).unwrap_err().diagnostic();
        assert_eq!(error.code, Code::E0831);
        let help = error.help.expect("a mend");
        let (_, rest) = help.split_once("speeds ").expect("by how much");
        rest.split_once(" times as high").expect("how many times").0.parse::<f64>().expect("a number")
    };
    let [once, twice] = [1000, 2000].map(times_as_high);
    // Each is rounded up to a tenth.
    assert!(once > 1.0 && (twice - 2.0 * once).abs() <= 0.21, "{once} {twice}");
}

#[test]
fn gcode_has_a_file_for_every_three_fingers_and_none_for_voltages() {
    let hand = fixture::hand().verified;
    let many = fixture::changed(&hand, |schedule| {
        for channel in 0..6 {
            let name = format!("hand.f{}.{}", 4 + channel / 3, ["x", "y", "z"][channel % 3]);
            schedule.channels.push(Channel { name, ..schedule.channels[1].clone() });
        }
    });
    let names: Vec<String> =
        emit(Format::Gcode, &many, &Provenance::default()).unwrap().into_iter().map(|file| file.name).collect();
    assert_eq!(names, ["turn.hand.f1-f3.ngc", "turn.hand.f4-f5.ngc"]);
    assert_eq!(code(Format::Gcode, &fixture::fetch().verified), Code::E0827);
    let error = emit(Format::Gcode, &fixture::fetch().verified, &Provenance::default()).unwrap_err().diagnostic();
    assert_eq!(error.title, "`bot.bl0.set` takes voltages, but `gcode` stores only stage positions");
    let none = fixture::changed(&hand, |schedule| (schedule.channels, schedule.actuations) = Default::default());
    assert_eq!(code(Format::Gcode, &none), Code::E0827);
}

#[test]
fn json_of_positions_keeps_to_its_schema() {
    let hand = |change: Edit| judged_of(fixture::hand(), change);
    assert_eq!(hand(|_| ()), (true, true));
    let changes: &[(Edit, (bool, bool))] = &[
        (|value| value["channels"][0]["unit"] = "mm".into(), (false, false)),
        (|value| value["plans"][0]["states"][1]["plane"] = "yz".into(), (false, false)),
        (|value| value["plans"][0]["states"][1]["grasp"][0] = (-1).into(), (false, false)),
        (|value| value["plans"][0]["states"][1]["tips_um"][2] = json!([1.0, 2.0]), (false, false)),
        (|value| value["plans"][0]["states"][1]["orientation"] = json!([1.0, 0.0, 0.0]), (false, false)),
        (|value| value["plans"][0]["states"][1]["orientation"][0] = (-1.0).into(), (false, true)),
    ];
    for (index, (change, expected)) in changes.iter().enumerate() {
        assert_eq!(hand(*change), *expected, "change {index}");
    }
}
