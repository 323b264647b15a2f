//! `tweeze control` as a user runs it: lines in, commands out, over standard input and over a socket.

#[cfg(unix)]
use crate::ignored::{SIGINT, SIGTERM, is_ignored};
use assert_cmd::Command;
use serde_json::{Value, json};
use std::path::{Path, PathBuf};
use tempfile::TempDir;

const DONE: i32 = 0;
const USAGE: i32 = 2;
const FILES: i32 = 4;
const STOPPED: i32 = 6;

/// The example with four robots, planned for few control cycles, with a watchdog too long to expire on a busy machine.
fn four(folder: &TempDir) -> PathBuf {
    let example = Path::new(env!("CARGO_MANIFEST_DIR")).join("examples/microrobots_four.twz");
    let text = std::fs::read_to_string(example).expect("the example is there");
    let text =
        text.replace("minimize failures", "minimize switches").replace("margin: 2 V", "margin: 2 V\n  watchdog: 60 s");
    let path = folder.path().join("four.twz");
    std::fs::write(&path, text).expect("a program is written");
    path
}

fn tweeze(arguments: &[&str]) -> Command {
    let mut command = Command::cargo_bin("tweeze").expect("tweeze is built");
    command.args(arguments);
    command
}

fn folder() -> TempDir {
    tempfile::tempdir().expect("a folder")
}

fn text(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes).into_owned()
}

/// Poses of the four robots at their starts, measured at a given time.
fn measured(t_ns: u64) -> String {
    let pose =
        |x_um: f64, y_um: f64, heading_deg: f64| json!({ "x_um": x_um, "y_um": y_um, "heading_deg": heading_deg });
    let robots = json!({
        "D1": pose(-1500.0, -1000.0, 0.0),
        "D2": pose(4000.0, -500.0, 90.0),
        "D3": pose(3500.0, 3000.0, 0.0),
        "D4": pose(-500.0, 3000.0, 180.0),
    });
    format!("{}\n", json!({ "t_ns": t_ns, "robots": robots }))
}

fn answers(out: &[u8]) -> Vec<Value> {
    let schema = include_str!("../../schema/control.schema.json");
    let schema: Value = serde_json::from_str(schema).expect("the schema is JSON");
    let valid = jsonschema::validator_for(&schema).expect("the schema is a schema");
    let parsed = |line: &str| {
        let line: Value = serde_json::from_str(line).expect("an answer is JSON");
        assert!(valid.is_valid(&line), "{line}");
        line
    };
    text(out).lines().map(parsed).collect()
}

/// The same trials succeed whether the controller runs in this process or in another one over a socket.
#[test]
fn four_robots_are_assembled_over_a_socket() {
    let folder = folder();
    let path = four(&folder);
    let path = path.to_string_lossy();
    let simulated = |more: &[&str]| {
        let mut arguments = vec!["simulate", &*path, "--trials", "2", "--seed", "5", "--format", "json"];
        arguments.extend(more);
        let out = tweeze(&arguments).assert().code(DONE).get_output().stdout.clone();
        serde_json::from_slice::<Value>(&out).expect("a report")
    };
    let (here, there) = (simulated(&[]), simulated(&["--against-controller"]));
    assert_eq!(there["successes"], 2, "{there}");
    assert_eq!(here["dockings"].as_array().map(Vec::len), Some(4));
    assert_eq!((&here["successes"], &here["trials"]), (&there["successes"], &there["trials"]));
    let disturbed =
        ["--against-controller", "--delay", "50ms", "--lost", "0.01", "--wrong", "0.01", "--stalls", "0.01"];
    assert_eq!(simulated(&disturbed)["trials"], 2);
}

#[test]
fn every_line_has_an_answer_and_nonsense_stops_it() {
    let folder = folder();
    let path = four(&folder);
    let path = path.to_string_lossy();
    let mut input = measured(1000);
    // An empty line is skipped, but counted.
    input.push_str("\nnonsense\n{\"t_ns\": 1}\n{\"t_ns\": 2, \"robots\": {\"D9\": null}}\n");
    input.push_str(
        "{\"t_ns\": 1.5, \"robots\": {}}\n[3, {}]\n{\"t_ns\": 4, \"robots\": {\"D1\": null, \"D1\": null}}\n",
    );
    let run = tweeze(&["control", &path]).write_stdin(input).assert().code(STOPPED);
    let answers = answers(&run.get_output().stdout);
    assert_eq!(answers[0]["control"], "quartet");
    assert_eq!((&answers[1]["command"], &answers[1]["line"]), (&json!("drive"), &json!(27)));
    assert!(!answers[1]["segments"][0]["levels_v"].as_array().is_none_or(Vec::is_empty), "{}", answers[1]);
    assert!(answers[2..8].iter().all(|answer| answer["error"].is_string()), "{answers:?}");
    assert_eq!([2, 7].map(|nth: usize| answers[nth]["input_line"].as_u64()), [Some(3), Some(8)], "{answers:?}");
    assert!(answers[4]["error"].as_str().is_some_and(|why| why.contains("`D9` is not a robot of the scene")));
    assert!(answers[5]["error"].as_str().is_some_and(|why| why.contains("expected a whole number of ns")));
    assert!(answers[6]["error"].as_str().is_some_and(|why| why.contains("one JSON object")));
    assert!(answers[7]["error"].as_str().is_some_and(|why| why.contains("`D1` occurs twice")));
    assert!(String::from_utf8_lossy(&run.get_output().stderr).contains("tweeze: stopped: "));
    assert_eq!((&answers[8]["command"], &answers[8]["reason"]), (&json!("stop"), &json!("garbled")));
    assert_eq!(answers.len(), 9);
}

#[test]
fn times_of_a_program_of_floating_point_numbers_are_whole_too() {
    let folder = folder();
    let path = four(&folder);
    let path = path.to_string_lossy();
    let (whole, float) = (measured(7), measured(7).replace("\"t_ns\":7}", "\"t_ns\":7.0}"));
    assert_ne!(whole, float);
    let answered = |measured: &str| {
        let run = tweeze(&["control", &path]).write_stdin(measured.to_owned()).assert().code(STOPPED);
        answers(&run.get_output().stdout)
    };
    assert_eq!(answered(&whole), answered(&float));
}

/// The end of the input counts as lost measurements, and equal measurements are recorded in equal bytes.
#[test]
fn a_recording_depends_on_the_measurements_alone() {
    let folder = folder();
    let path = four(&folder);
    let path = path.to_string_lossy();
    let recorded = |name: &str| {
        let record = folder.path().join(name);
        let arguments = ["control", &path, "--record", &record.to_string_lossy()];
        let run = tweeze(&arguments).write_stdin(measured(7)).assert().code(STOPPED);
        let last = answers(&run.get_output().stdout).pop().expect("answers");
        assert_eq!((&last["command"], &last["reason"]), (&json!("stop"), &json!("closed")));
        tweeze(&arguments).write_stdin(measured(7)).assert().code(FILES);
        std::fs::read(record).expect("a recording")
    };
    let (one, two) = (recorded("one.mcap"), recorded("two.mcap"));
    assert!(one.starts_with(b"\x89MCAP0\r\n") && one == two);
}

/// A signal must not leave the source at its last voltage: the last line is a stop, and the recording is complete.
#[cfg(unix)]
#[test]
fn a_signal_stops_the_robots_first() {
    use std::io::{BufRead, BufReader, Write};
    use std::process::{Command, Stdio};
    const VERIFICATION: i32 = 3;
    let folder = folder();
    let path = four(&folder);
    let record = folder.path().join("run.mcap");
    // Before the first measurement, and after it.
    let signals = [("INT", SIGINT, 0), ("TERM", SIGTERM, 1)];
    for (signal, _, measurements) in signals.into_iter().filter(|(_, number, _)| !is_ignored(*number)) {
        let mut control = Command::new(assert_cmd::cargo::cargo_bin!("tweeze"));
        control.arg("control").arg(&path).arg("--record").arg(&record);
        let mut child =
            control.stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().expect("tweeze starts");
        let mut lines = BufReader::new(child.stdout.take().expect("its answers")).lines();
        let mut next = || lines.next().expect("a line").expect("text");
        assert!(next().contains("\"control\":\"quartet\""));
        let mut to = child.stdin.take().expect("its input");
        for nth in 0..measurements {
            to.write_all(measured(1000 + nth).as_bytes()).expect("it reads");
            assert!(next().contains("\"command\":\"drive\""));
        }
        let sent = Command::new("kill").args(["-s", signal, &child.id().to_string()]).status();
        assert!(sent.expect("`kill` is there").success());
        let last = answers(next().as_bytes()).remove(0);
        assert_eq!((&last["command"], &last["reason"]), (&json!("stop"), &json!("interrupted")));
        let run = child.wait_with_output().expect("it ends");
        assert_eq!(run.status.code(), Some(STOPPED), "{}", text(&run.stderr));
        assert_eq!(text(&run.stderr), "tweeze: stopped: the controller was interrupted\n");
        let verified = tweeze(&["verify", &record.to_string_lossy()]).assert().code(VERIFICATION);
        assert!(text(&verified.get_output().stderr).contains("interrupted"), "{verified}");
        std::fs::remove_file(&record).expect("the recording");
    }
}

/// A trial is recorded and judged, alone and against its program, and any change to the file is detected.
#[test]
fn a_recording_is_verified() {
    const VERIFICATION: i32 = 3;
    let folder = folder();
    let path = four(&folder);
    let record = folder.path().join("run.mcap");
    let (path, run) = (path.to_string_lossy(), record.to_string_lossy());
    let simulated = ["simulate", &*path, "--against-controller", "--seed", "5", "--record", &*run, "--trials"];
    tweeze(&[&simulated[..], &["2"]].concat()).assert().code(USAGE);
    tweeze(&[&simulated[..], &["1"]].concat()).assert().code(DONE);
    let verified = |more: &[&str], code: i32| {
        let run = tweeze(&[&["verify", &*run], more].concat()).assert().code(code);
        format!("{}{}", text(&run.get_output().stdout), text(&run.get_output().stderr))
    };
    let report = verified(&["--against", &path], DONE);
    for line in ["Read  run.mcap", "0 violations", "Followed", "Docked  D4", "Matches"] {
        assert!(report.contains(line), "{line}: {report}");
    }
    let report: Value = serde_json::from_str(&verified(&["--format", "json"], DONE)).expect("a report");
    assert_eq!(report["recording"]["goals"].as_array().map(Vec::len), Some(4), "{report}");
    let other = folder.path().join("other.twz");
    let program = std::fs::read_to_string(&*path).expect("the program");
    std::fs::write(&other, program.replace("margin: 2 V", "margin: 1 V")).expect("another program");
    assert!(verified(&["--against", &other.to_string_lossy()], VERIFICATION).contains("E0742"));
    assert!(verified(&["--path-tolerance", "20"], USAGE).contains("expected a length, such as 20um"));
    let view = tweeze(&["view", &run, "--no-open"]).assert().code(FILES);
    assert!(text(&view.get_output().stderr).contains("recording of a controlled run"));
    let mut bytes = std::fs::read(&record).expect("a recording");
    let at = bytes.len() / 2;
    bytes[at] ^= 1;
    std::fs::write(&record, bytes).expect("an edited recording");
    verified(&[], FILES);
}

#[test]
fn only_this_machine_is_listened_at_and_one_task_controlled() {
    let folder = folder();
    let path = four(&folder);
    let path = path.to_string_lossy();
    for (address, why) in [("8.8.8.8:7000", "only addresses of this machine"), ("7000", "HOST:PORT"), ("unix:", "path")]
    {
        let run = tweeze(&["control", &path, "--listen", address]).assert().code(USAGE);
        assert!(text(&run.get_output().stderr).contains(why), "{address}: {}", text(&run.get_output().stderr));
    }
    let other = Path::new(env!("CARGO_MANIFEST_DIR")).join("examples/dimibot_fetch.twz");
    let run = tweeze(&["control", &other.to_string_lossy()]).assert().code(USAGE);
    assert!(text(&run.get_output().stderr).contains("cannot be controlled"));
    let two_runs = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/found/microrobots-two-runs.twz");
    let two_runs = two_runs.to_string_lossy();
    let run = tweeze(&["simulate", &two_runs, "--trials", "1", "--against-controller"]).assert().code(USAGE);
    assert!(text(&run.get_output().stderr).contains("--task NAME"));
}

/// If the precision of a task is finer than its drives can keep, that is reported before the run, with the tolerances
/// that `verify` needs.
#[test]
fn a_precision_that_no_drive_keeps_is_told_of() {
    let example = Path::new(env!("CARGO_MANIFEST_DIR")).join("examples/microrobots_drive.twz");
    let run = tweeze(&["control", &example.to_string_lossy()]).write_stdin("").assert().code(STOPPED);
    let said = text(&run.get_output().stderr);
    assert!(said.contains("--goal-tolerance ") && said.contains("um") && said.contains("deg"), "{said}");
    let folder = folder();
    let wide = folder.path().join("wide.twz");
    let program = std::fs::read_to_string(&example).expect("it is there");
    let lines = program.lines().map(|line| match line.trim_start().starts_with("task ") {
        true => format!("{line}\n  precision: 300 um\n  heading_precision: 60 deg\n"),
        false => format!("{line}\n"),
    });
    let lines = lines.filter(|line| {
        !line.trim_start().starts_with("precision:") && !line.trim_start().starts_with("heading_precision:")
    });
    std::fs::write(&wide, lines.collect::<String>()).expect("written");
    let run = tweeze(&["control", &wide.to_string_lossy()]).write_stdin("").assert().code(STOPPED);
    assert!(!text(&run.get_output().stderr).contains("--goal-tolerance"), "{}", text(&run.get_output().stderr));
}

/// A camera whose picture is frozen does not drive the robots for long, and the recording shows that they did not
/// follow.
#[test]
fn a_picture_that_does_not_change_stops_it() {
    const VERIFICATION: i32 = 3;
    let folder = folder();
    let path = four(&folder);
    let record = folder.path().join("frozen.mcap");
    let (path, record) = (path.to_string_lossy(), record.to_string_lossy());
    let frozen: String = (0..40).map(|nth| measured(nth * 500_000_000)).collect();
    let run = tweeze(&["control", &path, "--record", &record]).write_stdin(frozen).assert().code(STOPPED);
    let answers = answers(&run.get_output().stdout);
    let last = answers.last().expect("answers");
    assert_eq!((&last["command"], &last["reason"]), (&json!("stop"), &json!("astray")), "{last}");
    assert!(last["message"].as_str().is_some_and(|why| why.contains("does not follow the commands")), "{last}");
    assert!(answers.len() < 12, "{} answers", answers.len());
    let verified = tweeze(&["verify", &record]).assert().code(VERIFICATION);
    assert!(text(&verified.get_output().stderr).contains("from where the commands bring it"), "{verified}");
}

/// Measurements that do not fit the scene are not acted upon.
#[test]
fn a_bed_that_is_another_one_is_not_driven() {
    let folder = folder();
    let path = four(&folder);
    let path = path.to_string_lossy();
    let swapped: String = (0..40).map(|nth| measured(nth * 500_000_000).replace("\"D2\"", "\"D0\"")).collect();
    let swapped = swapped.replace("\"D3\"", "\"D2\"").replace("\"D0\"", "\"D3\"");
    let run = tweeze(&["control", &path]).write_stdin(swapped).assert().code(STOPPED);
    let answers = answers(&run.get_output().stdout);
    let drives = |answer: &&Value| answer["segments"].as_array().is_some_and(|segments| !segments.is_empty());
    assert_eq!(answers.iter().find(drives), None);
    assert_eq!(answers.last().map(|last| &last["reason"]), Some(&json!("doubtful")), "{answers:?}");
}

/// Robots that never move fail their trials for that reason; the trials differ from those of `build`.
#[test]
fn robots_that_stand_still_fail_their_trials() {
    let folder = folder();
    let path = four(&folder);
    let path = path.to_string_lossy();
    for more in [&["--trials", "3"][..], &["--trials", "1", "--against-controller"]] {
        let arguments = [&["simulate", &*path, "--format", "json", "--stalls", "1"], more].concat();
        let out = tweeze(&arguments).assert().code(DONE).get_output().stdout.clone();
        let report: Value = serde_json::from_slice(&out).expect("a report");
        assert_eq!((&report["successes"], &report["seed"]), (&json!(0), &json!(3)), "{report}");
        let failures = report["failures"].as_array().expect("failures");
        assert!(failures.iter().all(|failure| failure["reason"] == "astray"), "{report}");
    }
}

/// An existing file is the user's mistake, not the compiler's.
#[test]
fn a_trial_is_not_recorded_over_a_file() {
    let folder = folder();
    let path = four(&folder);
    let record = folder.path().join("run.mcap");
    std::fs::write(&record, "kept").expect("a file");
    let (path, run) = (path.to_string_lossy(), record.to_string_lossy());
    let nowhere = folder.path().join("nowhere/run.mcap");
    for (to, why) in [(&*run, "choose another name"), (&*nowhere.to_string_lossy(), "choose another folder")] {
        let simulated = ["simulate", &*path, "--against-controller", "--trials", "1", "--record", to];
        let run = tweeze(&simulated).assert().code(FILES);
        let reported = text(&run.get_output().stderr);
        assert!(reported.contains("E0804") && reported.contains(why), "{reported}");
    }
    assert_eq!(std::fs::read_to_string(&record).expect("the file"), "kept");
}

/// An address that cannot be listened at is reported before a plan is searched for; this one does not exist.
#[cfg(unix)]
#[test]
fn a_bad_address_is_reported_before_a_plan_is_searched() {
    let folder = folder();
    let path = four(&folder);
    let program = std::fs::read_to_string(&path).expect("the program");
    let hopeless = program.replace("  minimize switches", "  require time <= 1 s\n  minimize switches");
    assert_ne!(program, hopeless);
    std::fs::write(&path, hopeless).expect("a program");
    let run = tweeze(&["control", &path.to_string_lossy(), "--listen", "unix:/nonexistent/x"]).assert().code(FILES);
    assert!(text(&run.get_output().stderr).contains("cannot listen there"), "{run}");
    let socket = folder.path().join("bed.sock");
    let address = format!("unix:{}", socket.display());
    tweeze(&["control", &path.to_string_lossy(), "--listen", &address]).assert().code(1);
    assert!(!socket.exists(), "it leaves nothing behind");
}
