//! Auxiliary outputs, from the program to the files written.

use crate::{Bench, DONE, ERRORS, err, says};
use serde_json::Value;
use std::collections::BTreeMap;
use std::fs;

const OUTPUTS: &str = "output camera : trigger { duration: 1 ms }\noutput light : digital { voltage: 3 V }\noutput heater : level { from: 1 V, to: 6 V }\n";

/// A task of each kind, with steps that switch outputs.
const PROGRAMS: [(&str, &str); 4] = [
    (
        "use std.dimibot\ndevice bot : dimibot.femto_st\n",
        "task go on bot {\n pulse camera\n move to (1, 1)\n set light to high\n move to (3, 2)\n set light to low\n pulse camera\n}\n",
    ),
    (
        "use std.electrode_array as ea\ndevice plate : ea.droplet_chip { columns: 8, rows: 6 }\nscene s { part a : ea.droplet at (3, 3) }\n",
        "task go on plate in s {\n set light to high\n move a to (5, 3)\n pulse camera\n for i in 0..2 { wait 2 ms, pulse camera }\n move a to (3, 3)\n}\n",
    ),
    (
        "use std.microrobots\ndevice fleet : microrobots.bed\nscene s { for i in 1..5 { robot D[i] at pose(i * 1 mm, 0 mm, 90 deg) } }\n",
        "task go on fleet in s {\n apply state 1 for 10 ms\n pulse camera\n apply state 2 for 10 ms\n set light to high\n wait 1 ms\n set light to low\n}\n",
    ),
    (
        "use std.fingers as f\ndevice hand : f.three_fingers { step: 18 deg }\nscene s { part bead : ellipsoid { axes: (16 um, 11.845 um, 11.845 um), material: f.silicon } }\n",
        "task go on hand in s {\n minimize effort\n set light to high\n rotate bead by 18 deg about z\n pulse camera\n rotate bead by 18 deg about z\n pulse camera\n}\n",
    ),
];

/// Intervals in which an output is high according to the steps alone, in nanoseconds.
fn expected(schedule: &Value, output: &str) -> Vec<(u64, u64)> {
    let end = schedule["duration_ns"].as_u64().expect("a duration");
    let mut high = Vec::new();
    let mut since = None;
    for step in schedule["steps"].as_array().expect("steps") {
        let (text, t) = (step["text"].as_str().expect("a text"), step["start_ns"].as_u64().expect("a start"));
        match text.split_whitespace().collect::<Vec<_>>()[..] {
            ["pulse", name] if name == output => high.push((t, t + 1_000_000)),
            ["set", name, "to", "high"] if name == output => since = Some(t),
            ["set", name, "to", "low"] if name == output => high.extend(since.take().map(|start| (start, t))),
            _ => {}
        }
    }
    high.extend(since.map(|start| (start, end)));
    high
}

#[test]
fn outputs_of_all_kinds_switch_where_their_steps_stand() {
    for (nth, (devices, task)) in PROGRAMS.iter().enumerate() {
        let bench = Bench::with(format!("{devices}{OUTPUTS}{task}"));
        bench.run(&["build", "a.twz", "-o", "out", "--emit", "mcap,json,csv,vcd,html"]).code(DONE);
        bench.run(&["verify", "out/go.mcap", "--against", "a.twz"]).code(DONE);
        let text = fs::read_to_string(bench.path("out/go.json")).expect("the schedule is there");
        let schedule: Value = serde_json::from_str(&text).expect("it is JSON");
        let names: BTreeMap<u64, &str> = (0..)
            .zip(schedule["channels"].as_array().expect("channels"))
            .map(|(index, channel)| (index, channel["name"].as_str().expect("a name")))
            .collect();
        for (output, volts) in [("camera", 5.0), ("light", 3.0)] {
            let own = schedule["actuations"].as_array().expect("actuations").iter().filter(|actuation| {
                names[&actuation["channel"].as_u64().expect("an index")] == format!("{output}.out")
            });
            let found: Vec<(u64, u64)> = own
                .map(|actuation| {
                    let [start, lasts] =
                        ["start_ns", "duration_ns"].map(|key| actuation[key].as_u64().expect("a time"));
                    assert_eq!([&actuation["from"], &actuation["to"]], [volts, volts], "program {nth}");
                    (start, start + lasts)
                })
                .collect();
            assert!(!found.is_empty(), "program {nth}");
            assert_eq!(found, expected(&schedule, output), "`{output}` of program {nth}");
        }
        // Without the switching steps, the plan is the same.
        let is_switching = |line: &&str| line.contains("pulse") || line.contains("set light");
        let still: String = task.lines().filter(|line| !is_switching(line)).map(|line| format!("{line}\n")).collect();
        fs::write(bench.path("b.twz"), format!("{devices}{still}")).expect("written");
        bench.run(&["build", "b.twz", "-o", "still", "--emit", "json"]).code(DONE);
        let text = fs::read_to_string(bench.path("still/go.json")).expect("the schedule is there");
        let still: Value = serde_json::from_str(&text).expect("it is JSON");
        assert_eq!(still["plans"][0]["cost"], schedule["plans"][0]["cost"], "program {nth}");
    }
}

#[test]
fn a_log_is_held_against_where_the_steps_stand() {
    let (devices, task) = PROGRAMS[0];
    let bench = Bench::with(format!("{devices}{OUTPUTS}{task}"));
    bench.run(&["build", "a.twz", "-o", "out"]).code(DONE);
    for (from, to) in
        [("set light to low\n pulse camera", "pulse camera\n set light to low"), ("1 ms", "2 ms"), ("3 V", "4 V")]
    {
        fs::write(bench.path("b.twz"), format!("{devices}{OUTPUTS}{task}").replace(from, to)).expect("written");
        let refused = bench.run(&["verify", "out/go.mcap", "--against", "b.twz"]);
        assert_ne!(refused.get_output().status.code(), Some(DONE), "{from}");
    }
}

#[test]
fn steps_that_no_output_takes_are_errors() {
    let (devices, _) = PROGRAMS[0];
    for (step, parts) in [
        ("pulse light", ["E0556", "set light to high"]),
        ("set camera to high", ["E0556", "`pulse camera`"]),
        ("pulse camra", ["E0201", "did you mean `camera`?"]),
        ("pulse bot", ["E0206", "`bot`"]),
        ("pulse camera for 5 ms", ["E0509", "`pulse camera`"]),
        ("set light high", ["E0509", "`set light to high`"]),
        ("set light to on", ["E0122", "`set light to high`"]),
        ("set light to hgih", ["E0311", "`high`"]),
        ("set light to 3 V", ["E0311", "`high`"]),
        ("set heater to 120 %", ["E0403", "from 0 % to 100 %"]),
        ("set heater to high", ["E0311", "`100 %`"]),
        ("set heater to 3 V", ["E03", "the level of `heater`"]),
        ("pulse heater", ["E0556", "set heater to 60 %"]),
        ("pulse camera\n pulse camera", ["E0607", "more than 1 ms"]),
        ("set light to high\n set light to low", ["E0607", "set twice"]),
        ("move to (1, 1)\n set light to high", ["E0607", "as the schedule ends"]),
        ("together { pulse camera }", ["E05", "together"]),
    ] {
        let bench = Bench::with(format!("{devices}{OUTPUTS}task go on bot {{\n {step}\n}}\n"));
        says(&err(&bench.run(&["build", "a.twz", "-o", "out"]).code(ERRORS)), &parts);
    }
    let program = format!(
        "{devices}{OUTPUTS}task go on bot {{ pulse camera, wait 2 ms }}\nprogram p {{ run go, pulse camera }}\n"
    );
    says(&err(&Bench::with(program).run(&["check", "a.twz"]).code(ERRORS)), &["E0518", "by the steps of tasks"]);
    let unused = Bench::with(format!("{devices}{OUTPUTS}task go on bot {{ pulse camera, move to (1, 1) }}\n"));
    says(&err(&unused.run(&["check", "a.twz"]).code(DONE)), &["W0201", "light"]);
}

/// The segments of an output in a schedule: start and end in milliseconds, and the voltage.
fn stretches(schedule: &Value, output: &str) -> Vec<(f64, f64, f64)> {
    let channels = schedule["channels"].as_array().expect("channels");
    let index = channels.iter().position(|channel| channel["name"] == format!("{output}.out")).expect("the output");
    let own = schedule["actuations"].as_array().expect("actuations").iter();
    own.filter(|actuation| actuation["channel"] == index as u64)
        .map(|actuation| {
            let ms = |key: &str| actuation[key].as_f64().expect("a time") / 1e6;
            let volts = actuation["from"].as_f64().expect("a voltage");
            assert_eq!(actuation["to"].as_f64(), Some(volts));
            (ms("start_ns"), ms("start_ns") + ms("duration_ns"), volts)
        })
        .collect()
}

#[test]
fn levels_and_what_outputs_rest_at_are_played_and_verified() {
    let program = "use std.dimibot\nuse std.instruments\ndevice bot : dimibot.femto_st { left: 1, right: 1 }\n\
        instrument card : instruments.ni_usb_6343\ninstrument od : instruments.opendrop_v4 { start: trigger }\n\
        output heater : level { from: 1 V, to: 6 V, rest: 20 % }\noutput valve : digital { rest: high }\n\
        output shutter : trigger { duration: 2 ms, rest: high }\noutput lamp : digital { voltage: 200 V, rest: high }\n\
        task go on bot {\n set heater to 60 %\n pulse shutter\n wait 100 ms\n set valve to low\n set lamp to low\n wait 100 ms\n \
        set heater to 20 %\n set valve to high\n wait 100 ms\n set heater to 100 %\n wait 100 ms\n}\n\
        wiring heater { out -> card.ao0 }\nwiring valve { out -> card.port0.line0 { switches: 5 V } }\n\
        wiring shutter { out -> card.port0.line1 { switches: 5 V } }\nwiring lamp { out -> od.c8 { switches: 200 V } }\n";
    let bench = Bench::with(program);
    bench.run(&["build", "a.twz", "-o", "out", "--emit", "mcap,json,csv,vcd,pwl,nidaqmx,frames"]).code(DONE);
    bench.run(&["verify", "out/go.mcap", "--against", "a.twz"]).code(DONE);
    let text = |name: &str| fs::read_to_string(bench.path(&format!("out/{name}"))).expect("it is there");
    let schedule: Value = serde_json::from_str(&text("go.json")).expect("it is JSON");
    assert_eq!(stretches(&schedule, "heater"), [(0.0, 200.0, 4.0), (300.0, 400.0, 6.0)]);
    assert_eq!(stretches(&schedule, "valve"), [(100.0, 200.0, 0.0)]);
    assert_eq!(stretches(&schedule, "shutter"), [(0.0, 2.0, 0.0)]);
    assert_eq!(stretches(&schedule, "lamp"), [(100.0, 400.0, 0.0)]);
    let rests = schedule["channels"].as_array().expect("channels").iter().map(|channel| &channel["rest_v"]);
    assert_eq!(rests.filter_map(Value::as_f64).collect::<Vec<_>>(), [2.0, 200.0, 5.0, 5.0]);
    let samples = text("go.card.daq");
    let rows: Vec<&str> = samples.lines().filter(|line| line.starts_with(|c: char| c.is_ascii_digit())).collect();
    assert_eq!(rows.first(), Some(&"1\t0x00000001\t4"), "{samples}");
    assert_eq!(rows.last(), Some(&"1\t0x00000003\t2"), "{samples}");
    let sender = text("go.nidaqmx.py");
    says(&sender, &["\"line_rests\": [\n            true,\n            true\n          ]", "\"rest_v\": 2.0"]);
    says(&text("go.od.frames.csv"), &["1,0,100,8\n2,100,300,\n"]);
    says(&text("go.frames.py"), &["\"rest\": [\n        8\n      ]"]);
    let refused = bench.run(&["build", "a.twz", "-o", "other", "--emit", "opendrop"]);
    says(&err(&refused.code(ERRORS)), &["E0831", "`od.c8`", "rests on", "--emit frames"]);
    fs::write(bench.path("b.twz"), program.replace("rest: 20 %", "rest: 40 %")).expect("written");
    let refused = bench.run(&["verify", "out/go.mcap", "--against", "b.twz"]);
    assert_ne!(refused.get_output().status.code(), Some(DONE));
    says(&err(&refused), &["E0774", "heater.out"]);
    // Values that the output or its switch cannot provide.
    for (from, to, code) in
        [("to: 6 V", "to: 40 V", "E0620"), ("digital { rest: high }", "digital { voltage: 4 V, rest: high }", "E0621")]
    {
        fs::write(bench.path("c.twz"), program.replace(from, to)).expect("written");
        says(&err(&bench.run(&["build", "c.twz", "-o", "c", "--emit", "json"]).code(ERRORS)), &[code]);
    }
}

#[test]
fn a_generator_rests_at_a_voltage() {
    let program = "use std.dimibot\nuse std.instruments\ndevice bot : dimibot.femto_st { left: 1, right: 1 }\n\
        instrument awg : instruments.keysight_33500b\noutput heater : level { to: 6 V, rest: 50 % }\n\
        task go on bot {\n wait 10 ms\n set heater to 100 %\n wait 10 ms\n}\nwiring heater { out -> awg.ch1 { gain: 2 } }\n";
    let bench = Bench::with(program);
    bench.run(&["build", "a.twz", "-o", "out", "--emit", "scpi"]).code(DONE);
    let text = |name: &str| fs::read_to_string(bench.path(&format!("out/{name}"))).expect("it is there");
    says(&text("go.scpi.py"), &["\"rest_v\": {\n        \"1\": 1.5\n      }"]);
    says(&text("go.awg.scpi.txt"), &[":SOUR1:APPL:DC DEF,DEF,1.5 when all is played", "ch1\t1.5\t3\t"]);
}

/// A device written for MicroDrop is read back as a board that gives the same device; the log contains it.
#[test]
fn a_device_for_microdrop_is_read_back_as_a_board() {
    let program = |board: &str| {
        format!(
            "use std.electrode_array as ea\nuse std.instruments\ninstrument db : instruments.dropbot_db3_120\n\
             device chip : {board}\nwiring chip {{ electrodes -> db }}\nscene s {{ part a : ea.droplet at (1, 19) }}\n\
             task go on chip in s {{ move a to (4, 2) }}\n"
        )
    };
    let bench = Bench::with(program("ea.dropbot_120 { }"));
    bench.run(&["build", "a.twz", "-o", "out", "--emit", "microdrop"]).code(DONE);
    let sizes = "radius: 0.86 mm, pitch_ratio: 1.746 mm / 0.86 mm - 2, potential: 100 V, settling: 20 ms";
    let board = format!("ea.droplet_chip {{ map: \"out/go.db.microdrop.svg\", {sizes} }}");
    fs::write(bench.path("b.twz"), program(&board)).expect("written");
    bench.run(&["build", "b.twz", "-o", "again", "--emit", "microdrop,mcap"]).code(DONE);
    let read = |name: &str| fs::read_to_string(bench.path(name)).expect("it is there");
    let device = read("out/go.db.microdrop.svg");
    assert_eq!(device.matches("<path ").count(), 80);
    assert_eq!(read("again/go.db.microdrop.svg"), device);
    // Without the files beside it.
    fs::remove_file(bench.path("out/go.db.microdrop.svg")).expect("removed");
    bench.run(&["verify", "again/go.mcap"]).code(DONE);
    let refused = bench.run(&["build", "b.twz", "-o", "third", "--emit", "json"]);
    says(&err(&refused.code(ERRORS)), &["E0204", "out/go.db.microdrop.svg"]);
}
