//! `tweeze control` when its peers, its clock or its disk fail: the run ends, and `stop` is sent if anybody can still
//! read it.

#![cfg(unix)]

use crate::ignored::{SIGINT, is_ignored};
use serde_json::{Value, json};
use std::io::{BufRead, BufReader, Lines, Write};
use std::path::{Path, PathBuf};
use std::process::{Child, ChildStdin, ChildStdout, Command, Stdio};
use std::time::{Duration, Instant};
use tempfile::TempDir;

const FILES: i32 = 4;
const STOPPED: i32 = 6;

/// Longer than anything here takes, even on a busy machine.
const LONG: Duration = Duration::from_secs(60);

/// The drive example with a given watchdog time.
fn drive(folder: &TempDir, watchdog: &str) -> PathBuf {
    let example = Path::new(env!("CARGO_MANIFEST_DIR")).join("examples/microrobots_drive.twz");
    let text = std::fs::read_to_string(example).expect("the example is there");
    let path = folder.path().join("drive.twz");
    let text = text.replace("margin: 4 V", &format!("watchdog: {watchdog}\n  margin: 4 V"));
    std::fs::write(&path, text).expect("a program is written");
    path
}

/// The robots at their starts, with D2 shifted by `shift_um`.
fn measured(t_ns: u64, shift_um: f64) -> String {
    let pose = |x_um: f64| json!({ "x_um": x_um, "y_um": 0.0, "heading_deg": 90.0 });
    let robots = json!({ "D1": pose(0.0), "D2": pose(2000.0 + shift_um), "D3": pose(4500.0) });
    format!("{}\n", json!({ "t_ns": t_ns, "robots": robots }))
}

fn begun(command: &mut Command) -> Child {
    command.stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().expect("tweeze starts")
}

fn control(program: &Path, more: &[&str]) -> Command {
    let mut control = Command::new(assert_cmd::cargo::cargo_bin!("tweeze"));
    control.arg("control").arg(program).args(more);
    control
}

/// A controller that has sent its greeting, with both ends of the connection.
struct Peer {
    child: Child,
    to: ChildStdin,
    lines: Lines<BufReader<ChildStdout>>,
}

impl Peer {
    fn of(command: &mut Command) -> Peer {
        let mut child = begun(command);
        let to = child.stdin.take().expect("its input");
        let mut lines = BufReader::new(child.stdout.take().expect("its answers")).lines();
        assert!(lines.next().expect("a line").expect("text").contains("\"control\""));
        Peer { child, to, lines }
    }

    fn ask(&mut self, line: &str) -> Value {
        self.try_ask(line).expect("it reads")
    }

    /// The answer; `None` if it no longer reads.
    fn try_ask(&mut self, line: &str) -> Option<Value> {
        self.to.write_all(line.as_bytes()).ok()?;
        Some(serde_json::from_str(&self.lines.next().expect("an answer").expect("text")).expect("JSON"))
    }

    /// The reason for its stop, its exit status and its standard error.
    fn end(mut self, last: &Value) -> (String, Option<i32>, String) {
        drop(self.to);
        let rest = self.lines.map_while(Result::ok).last();
        let last = rest.map_or(last.clone(), |line| serde_json::from_str(&line).expect("JSON"));
        let status = self.child.wait().expect("it ends");
        let mut said = String::new();
        std::io::Read::read_to_string(&mut self.child.stderr.take().expect("its words"), &mut said).expect("text");
        (last["reason"].as_str().unwrap_or_default().to_owned(), status.code(), said)
    }
}

#[test]
fn places_in_which_no_motion_shows_are_not_understood() {
    let folder = tempfile::tempdir().expect("a folder");
    let mut peer = Peer::of(&mut control(&drive(&folder, "60 s"), &[]));
    peer.ask(&measured(0, 0.0));
    for _ in 0..6 {
        let refused = peer.ask(&measured(1_000_000_000, 1e20));
        assert!(refused["error"].as_str().is_some_and(|why| why.contains("`D2` is measured beyond")), "{refused}");
    }
    let (reason, status, _) = peer.end(&Value::Null);
    assert_eq!((reason.as_str(), status), ("garbled", Some(STOPPED)));
}

#[test]
fn a_robot_that_somebody_moved_is_not_driven_on() {
    let folder = tempfile::tempdir().expect("a folder");
    let mut peer = Peer::of(&mut control(&drive(&folder, "60 s"), &[]));
    let first = peer.ask(&measured(0, 0.0));
    let until_ns = first["until_ns"].as_u64().expect("an end");
    let held = peer.ask(&measured(until_ns, 1000.0));
    assert_eq!(held["segments"].as_array().map(Vec::len), Some(0), "{held}");
    let last = peer.ask(&measured(held["until_ns"].as_u64().expect("an end"), 1000.0));
    assert_eq!((&last["reason"], &last["robot"]), (&json!("moved"), &json!("D2")), "{last}");
    assert_eq!(peer.end(&last).1, Some(STOPPED));
}

/// Measurements continue, but their time stands still.
#[test]
fn a_clock_that_stands_still_is_silence() {
    let folder = tempfile::tempdir().expect("a folder");
    let mut peer = Peer::of(&mut control(&drive(&folder, "300 ms"), &[]));
    let begin = Instant::now();
    let mut last = peer.ask(&measured(1000, 0.0));
    while last["command"] != "stop" {
        assert!(begin.elapsed() < LONG, "{last}");
        // It may also stop between two measurements.
        let Some(answer) = peer.try_ask(&measured(1000, 0.0)) else { break };
        last = answer;
    }
    let (reason, status, _) = peer.end(&last);
    assert_eq!((reason.as_str(), status), ("silence", Some(STOPPED)), "{last}");
}

/// The reader of the commands hangs, and the pipe is full.
#[test]
fn commands_that_nobody_takes_end_the_run() {
    let folder = tempfile::tempdir().expect("a folder");
    let record = folder.path().join("run.mcap");
    let mut child = begun(&mut control(&drive(&folder, "300 ms"), &["--record", &record.to_string_lossy()]));
    let mut to = child.stdin.take().expect("its input");
    let feeding = std::thread::spawn(move || while to.write_all(measured(0, 0.0).as_bytes()).is_ok() {});
    let status = child.wait().expect("it ends");
    feeding.join().expect("it ends with it");
    assert_eq!(status.code(), Some(STOPPED));
    let verified = Command::new(assert_cmd::cargo::cargo_bin!("tweeze")).arg("verify").arg(&record).output();
    let said = String::from_utf8_lossy(&verified.expect("it runs").stderr).into_owned();
    let is_told = said.contains("does not read them") || said.contains("no measurement arrived");
    assert!(said.contains("E0765") && is_told, "{said}");
}

/// Writing to the disk fails, and the robots are stopped nevertheless.
#[test]
fn a_full_disk_stops_the_robots_first() {
    let folder = tempfile::tempdir().expect("a folder");
    let record = folder.path().join("run.mcap");
    let mut limited = Command::new("sh");
    // In blocks of 512 bytes: the attachments fit, a hundred lines do not.
    limited.args(["-c", "ulimit -f 100; exec \"$@\"", "sh"]).arg(assert_cmd::cargo::cargo_bin!("tweeze"));
    limited.arg("control").arg(drive(&folder, "60 s")).arg("--record").arg(&record);
    let mut peer = Peer::of(&mut limited);
    let mut last = peer.ask(&measured(0, 0.0));
    let until_ns = last["until_ns"].as_u64().expect("an end");
    for t_ns in 1..4000 {
        assert!(t_ns < until_ns);
        last = peer.ask(&measured(t_ns, 0.0));
        if last["command"] == "stop" {
            break;
        }
    }
    assert_eq!(last["reason"], "unrecorded", "{last}");
    let (_, status, said) = peer.end(&last);
    assert_eq!(status, Some(FILES), "{said}");
    assert!(said.contains("E0804") && said.matches("cannot continue recording").count() == 1, "{said}");
}

#[test]
fn nothing_is_left_of_a_run_that_nobody_joined() {
    if is_ignored(SIGINT) {
        return eprintln!("skipped: SIGINT is ignored here");
    }
    let folder = tempfile::tempdir().expect("a folder");
    let program = drive(&folder, "1 s");
    let (socket, record) = (folder.path().join("bed.sock"), folder.path().join("run.mcap"));
    let listen = format!("unix:{}", socket.display());
    // A socket that a process left behind or listens at is for its owner to delete.
    drop(std::os::unix::net::UnixListener::bind(&socket).expect("a socket"));
    let run = control(&program, &["--listen", &listen]).output().expect("it runs");
    let said = String::from_utf8_lossy(&run.stderr);
    assert!(run.status.code() == Some(FILES) && said.contains("if a killed process left it behind"), "{said}");
    std::fs::remove_file(&socket).expect("the socket");
    let mut child = begun(&mut control(&program, &["--listen", &listen, "--record", &record.to_string_lossy()]));
    let mut words = BufReader::new(child.stderr.take().expect("its words")).lines().map_while(Result::ok);
    assert!(words.any(|line| line.contains("listening at")));
    let sent = Command::new("kill").args(["-s", "INT", &child.id().to_string()]).status();
    assert!(sent.expect("`kill` is there").success());
    assert_eq!(child.wait().expect("it ends").code(), Some(STOPPED));
    assert_eq!((socket.exists(), record.exists()), (false, false));
}
