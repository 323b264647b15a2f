//! Waits for inputs and people, from the program to the senders that wait.

use crate::{Bench, DONE, ERRORS, USAGE, err, says};
use serde_json::Value;
use std::fs;
use std::path::Path;
use std::process::{Command, Stdio};

/// A robot on a data acquisition card, with a light that stays on during the waits.
const ON_A_CARD: &str = "use std.dimibot\nuse std.instruments\ndevice bot : dimibot.femto_st { left: 1, right: 1 }\n\
    instrument card : instruments.ni_usb_6343\noutput light : level { to: 10 V, rest: 10 % }\n\
    task go on bot {\n set light to 60 %\n prompt \"add the sample\"\n move to (1, 0)\n\
    wait until card.port0.line31 for at most 5 s\n set light to 30 %\n move to (0, 0)\n prompt \"take it\" for at most 1 min\n}\n\
    wiring bot { switches: 20 V, bl0.set -> card.port0.line0, bl0.reset -> card.port0.line1 }\n\
    wiring light { out -> card.ao0 }\n";

/// Runs a sender with stand-ins for the instruments' libraries and a person's answers; returns its status and output.
/// `None` without Python.
fn sent(bench: &Bench, script: &str, arguments: &[&str], answers: &str, low: u32) -> Option<(i32, String)> {
    let stand_ins = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/oracles/standins");
    fs::write(bench.path("answers"), answers).expect("written");
    let run = Command::new("python3")
        .arg(bench.path(script))
        .args(arguments)
        .env("PYTHONPATH", stand_ins)
        .env("STANDIN_LOG", bench.path("standin.log"))
        .env("STANDIN_LOW", low.to_string())
        .stdin(Stdio::from(fs::File::open(bench.path("answers")).expect("it is there")))
        .output()
        .ok()?;
    let words = String::from_utf8_lossy(&[run.stdout, run.stderr].concat()).into_owned();
    Some((run.status.code().unwrap_or(-1), words))
}

fn schedule(bench: &Bench, path: &str) -> Value {
    let text = fs::read_to_string(bench.path(path)).expect("the schedule is there");
    serde_json::from_str(&text).expect("it is JSON")
}

#[test]
fn a_card_is_played_in_parts_and_keeps_what_it_gives_in_between() {
    let bench = Bench::with(ON_A_CARD);
    bench.run(&["build", "a.twz", "-o", "out", "--emit", "mcap,json,nidaqmx,html,svg"]).code(DONE);
    bench.run(&["verify", "out/go.mcap", "--against", "a.twz"]).code(DONE);
    let schedule = schedule(&bench, "out/go.json");
    let holds: Vec<[u64; 2]> = (schedule["holds"].as_array().expect("waits").iter())
        .map(|hold| ["start_ns", "duration_ns"].map(|key| hold[key].as_u64().expect("a time")))
        .collect();
    assert_eq!(holds, [[0, 1_000_000_000], [1_015_000_000, 5_000_000_000], [6_030_000_000, 60_000_000_000]]);
    let last = |part: &str| {
        let text = fs::read_to_string(bench.path(&format!("out/go.card.{part}.daq"))).expect("it is there");
        text.lines().last().expect("a line").to_owned()
    };
    assert_eq!(["1", "2", "3"].map(last), ["1\t0x00000000\t6", "1\t0x00000000\t6", "1\t0x00000000\t3"]);
    assert!(!bench.path("out/go.card.4.daq").exists(), "nothing comes after the last wait");
    let Some((status, words)) = sent(&bench, "out/go.nidaqmx.py", &["card=Dev1"], "\n\n", 5) else { return };
    assert_eq!(status, 0, "{words}");
    says(&words, &["add the sample", "waiting until card.port0.line31 is high", "take it", "played", "lines off"]);
    let log = fs::read_to_string(bench.path("standin.log")).expect("calls");
    let calls: Vec<Value> = log.lines().map(|line| serde_json::from_str(line).expect("a call")).collect();
    let rests = calls.iter().filter(|call| call["rest"].as_object().is_some_and(|rest| !rest.is_empty()));
    assert_eq!(rests.count(), 4, "lines and voltages go to rest before the start and after the end only");
    assert_eq!(calls.iter().filter(|call| call["channels"][0] == "Dev1/port0/line31").count(), 6);
    // Nobody answers, and no input arrives in time.
    for (answers, low, why) in
        [("", 0, "nobody is there to answer: add the sample"), ("\n\n", 1_000_000, "is not high after 0.05 s")]
    {
        let quick = fs::read_to_string(bench.path("out/go.nidaqmx.py")).expect("the sender");
        fs::write(bench.path("out/quick.py"), quick.replace("\"at_most_s\": 5.0", "\"at_most_s\": 0.05"))
            .expect("written");
        let (status, words) = sent(&bench, "out/quick.py", &["card=Dev1"], answers, low).expect("Python is there");
        assert_eq!(status, 1, "{words}");
        says(&words, &[why, "lines off, voltages at rest"]);
    }
}

#[test]
fn a_generator_holds_its_voltage_until_the_next_trigger() {
    let program = "use std.microrobots\nuse std.instruments\ndevice fleet : microrobots.bed\n\
        instrument awg : instruments.keysight_33500b\noutput light : level { to: 5 V, rest: 20 % }\n\
        scene s { for i in 1..5 { robot D[i] at pose(i * 1 mm, 0 mm, 90 deg) } }\n\
        task go on fleet in s {\n set light to 60 %\n apply state 1 for 10 ms\n prompt \"look\"\n apply state 2 for 10 ms\n\
        wait until \"ready\" for at most 5 s\n apply state 1 for 10 ms\n prompt \"go home\"\n}\n\
        wiring fleet { bed -> awg.ch1 { gain: 50 } }\nwiring light { out -> awg.ch2 }\n";
    let bench = Bench::with(program);
    bench.run(&["build", "a.twz", "-o", "out", "--emit", "json,scpi"]).code(DONE);
    let text = fs::read_to_string(bench.path("out/go.awg.scpi.txt")).expect("the description");
    let waits =
        |output: &str| text.lines().filter(|line| line.starts_with(output) && line.contains("onceWaitTrig")).count();
    assert_eq!([waits("ch1\t"), waits("ch2\t")], [4, 4], "{text}");
    let unread = sent(&bench, "out/go.scpi.py", &["awg=a"], "\n\n", 0);
    let Some((status, words)) = unread else { return };
    assert_eq!(status, 2, "{words}");
    says(&words, &["no command for the input ready: --input 'ready=COMMAND'"]);
    let arguments = ["awg=a", "--input", "ready=true"];
    let (status, words) = sent(&bench, "out/go.scpi.py", &arguments, "\n\n", 0).expect("Python is there");
    assert_eq!(status, 0, "{words}");
    says(&words, &["look (then press Enter)", "awg: goes on", "ready is high", "2 rests at 1.0 V"]);
    let log = fs::read_to_string(bench.path("standin.log")).expect("messages");
    assert_eq!(log.lines().filter(|line| line.contains("*TRG")).count(), 4, "{log}");
    assert!(log.lines().any(|line| line.contains(":SOUR2:APPL:DC DEF,DEF,1.0")), "{log}");
}

/// Plays frames on a board that records when it received each.
const PLAY: &str = "import importlib.util, json, sys, time\n\
    spec = importlib.util.spec_from_file_location('sender', sys.argv[1])\n\
    sender = importlib.util.module_from_spec(spec)\nspec.loader.exec_module(sender)\n\
    class Board:\n    def __init__(self, address):\n        self.address, self.sent = address, []\n\
    \x20   def send(self, on):\n        print('on', *sorted(on), round(time.monotonic() - begin, 1), flush=True)\n\
    \x20   def close(self):\n        pass\nbegin = time.monotonic()\nsender.PROTOCOLS['opendrop'] = Board\n\
    sys.exit(sender.main(sys.argv[2:]))\n";

#[test]
fn frames_stay_in_a_wait_and_go_on_from_its_end() {
    let program = "use std.electrode_array as ea\nuse std.instruments\ninstrument od : instruments.opendrop_v4\n\
        device chip : ea.opendrop_v4 { potential: 200 V, settling: 80 ms, step_duration: 100 ms }\nwiring chip { electrodes -> od }\n\
        scene s { part a : ea.droplet at (1, 4) }\n\
        task go on chip in s {\n move a to (2, 4)\n prompt \"look\"\n move a to (3, 4)\n\
        wait until \"ready\" for at most 20 s\n move a to (4, 4)\n}\n";
    let bench = Bench::with(program);
    bench.run(&["build", "a.twz", "-o", "out", "--emit", "mcap,json,frames,sheet"]).code(DONE);
    bench.run(&["verify", "out/go.mcap", "--against", "a.twz"]).code(DONE);
    fs::write(bench.path("play.py"), PLAY).expect("written");
    let sender = bench.path("out/go.frames.py").to_string_lossy().into_owned();
    let arguments = [sender.as_str(), "--input", "ready=true"];
    let Some((status, words)) = sent(&bench, "play.py", &arguments, "\n", 0) else { return };
    assert_eq!(status, 0, "{words}");
    says(&words, &["look (then press Enter)", "ready is high after", "played 3 frames", "all electrodes are off"]);
    let (status, words) = sent(&bench, "play.py", &arguments, "", 0).expect("Python is there");
    assert_eq!(status, 1, "{words}");
    says(&words, &["nobody is there to answer: look", "all electrodes are off"]);
    assert_eq!(sent(&bench, "play.py", &[sender.as_str()], "\n", 0).expect("Python is there").0, USAGE);
}

const HAND: &str = "use std.fingers as f\ndevice hand : f.three_fingers { step: 18 deg }\n\
    scene s { part bead : ellipsoid { axes: (16 um, 11.845 um, 11.845 um), material: f.silicon } }\n\
    task go on hand in s {\n minimize effort\n rotate bead by 18 deg about z\n prompt \"look (closely)\"\n rotate bead by 18 deg about z\n\
    wait until \"motion.digital-in-03\" at low for at most 2.5 s\n}\n";

#[test]
fn g_code_pauses_and_waits_for_pins() {
    let bench = Bench::with(HAND);
    bench.run(&["build", "a.twz", "-o", "out", "--emit", "json,gcode,mcap"]).code(DONE);
    let text = fs::read_to_string(bench.path("out/go.hand.ngc")).expect("the program");
    let waits = "M66 P3 L4 Q2.500000000 ; motion.digital-in-03 low\no2 if [#5399 LT 0]\n\
        (ABORT, motion.digital-in-03 has not come)\no2 endif\n";
    says(&text, &["\n(MSG, look _closely_)\nM0\nG1 ", waits]);
    for (from, to) in [("motion.digital-in-03", "Dev1/port1/line0"), ("(closely)\"", "(closely)\" for at most 5 s")] {
        fs::write(bench.path("b.twz"), HAND.replace(from, to)).expect("written");
        says(&err(&bench.run(&["build", "b.twz", "-o", "b", "--emit", "gcode"]).code(ERRORS)), &["E0831", "`gcode`"]);
    }
}

#[test]
fn formats_of_one_clock_and_two_senders_refuse_a_wait() {
    let bench = Bench::with(ON_A_CARD);
    for format in ["csv", "vcd", "pwl"] {
        let refused = bench.run(&["build", "a.twz", "-o", "out", "--emit", format]);
        says(&err(&refused.code(ERRORS)), &["E0831", "it has one clock"]);
    }
    let two = ON_A_CARD.replace(
        "output light",
        "instrument awg : instruments.keysight_33500b { start: trigger }\noutput lamp : digital\noutput light",
    );
    let two =
        two.replace("set light to 60 %", "set light to 60 %\n set lamp to high") + "wiring lamp { out -> awg.ch1 }\n";
    let bench = Bench::with(two);
    let refused = bench.run(&["build", "a.twz", "-o", "out", "--emit", "nidaqmx"]);
    says(&err(&refused.code(ERRORS)), &["E0831", "two families"]);
    bench.run(&["build", "a.twz", "-o", "out", "--emit", "json,mcap"]).code(DONE);
}
