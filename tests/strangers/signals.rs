//! Signals sent to a build: how it ends, and which files it leaves.

use super::bench::{Bench, found};
use super::ignored::{SIGHUP, SIGINT, SIGTERM, is_ignored, mask};
use std::os::unix::process::ExitStatusExt;
use std::process::{Child, Command, Stdio};
use std::time::Duration;

/// Starts a slow build in a folder.
fn start(bench: &Bench, wrap: &str) -> Child {
    start_with(bench, wrap, "")
}

/// As `start`, with further options.
fn start_with(bench: &Bench, wrap: &str, options: &str) -> Child {
    bench.write("slow.twz", found("ea_400_parts_gave_up.twz"));
    let line = format!("{wrap} '{}' build slow.twz -o out {options}", env!("CARGO_BIN_EXE_tweeze"));
    let mut command = Command::new("sh");
    command.args(["-c", &line]).current_dir(bench.path("")).stdout(Stdio::null()).stderr(Stdio::piped());
    command.spawn().expect("the shell starts")
}

fn send(signal: &str, child: &Child) {
    let status = Command::new("kill").args(["-s", signal, &child.id().to_string()]).status();
    assert!(status.expect("`kill` is there").success());
}

/// Waits until the build has installed its signal handlers, as the system reports.
#[cfg(target_os = "linux")]
fn is_ready(child: &mut Child) -> bool {
    for _ in 0..3000 {
        let status = std::fs::read_to_string(format!("/proc/{}/status", child.id())).unwrap_or_default();
        if mask(&status, "SigCgt:") >> (SIGTERM - 1) & 1 == 1 {
            return true;
        }
        assert_eq!(child.try_wait().expect("it can be asked"), None, "it ended by itself");
        std::thread::sleep(Duration::from_millis(10));
    }
    false
}

#[cfg(target_os = "linux")]
#[test]
fn a_signal_ends_a_build_as_it_ends_any_program() {
    let signals = [("INT", SIGINT), ("TERM", SIGTERM), ("HUP", SIGHUP)];
    for (signal, number) in signals.into_iter().filter(|(_, number)| !is_ignored(*number)) {
        let bench = Bench::new();
        let mut child = start(&bench, "exec");
        assert!(is_ready(&mut child), "no signal is caught");
        send(signal, &child);
        let output = child.wait_with_output().expect("it ends");
        assert_eq!(output.status.signal(), Some(number), "{output:?}");
        assert_eq!(String::from_utf8_lossy(&output.stderr), "tweeze: interrupted, nothing was written\n");
        assert_eq!(bench.names(), ["slow.twz"]);
    }
}

/// A build with `--keep-best` after a first Ctrl-C; its search has begun, and finds no plan for some seconds.
#[cfg(target_os = "linux")]
fn interrupted(bench: &Bench, options: &str) -> Child {
    let mut child = start_with(bench, "exec", &format!("{options} --keep-best"));
    assert!(is_ready(&mut child), "no signal is caught");
    std::thread::sleep(Duration::from_millis(500));
    send("INT", &child);
    child
}

/// With `--keep-best` the first Ctrl-C ends a search once it has a plan, which is verified and written as usual.
#[cfg(target_os = "linux")]
#[test]
fn the_best_plan_is_kept_where_that_is_asked_for() {
    if is_ignored(SIGINT) {
        return;
    }
    let bench = Bench::new();
    let output = interrupted(&bench, "--emit json").wait_with_output().expect("it ends");
    let reported = "tweeze: continuing with the best plan found; press Ctrl-C again to stop without one\n";
    assert_eq!((output.status.code(), String::from_utf8_lossy(&output.stderr).as_ref()), (Some(0), reported));
    let json = std::fs::read_to_string(bench.path("out/go.json")).expect("it was written");
    let schedule: serde_json::Value = serde_json::from_str(&json).expect("JSON");
    let plan = &schedule["plans"][0];
    assert_eq!((&plan["optimal"], &plan["remarks"][0]["subject"]), (&false.into(), &"search".into()));
}

/// The second Ctrl-C ends the build, like any signal without `--keep-best`.
#[cfg(target_os = "linux")]
#[test]
fn a_second_signal_ends_a_build_that_would_keep_its_best_plan() {
    if is_ignored(SIGINT) {
        return;
    }
    let bench = Bench::new();
    let child = interrupted(&bench, "");
    std::thread::sleep(Duration::from_millis(100));
    send("INT", &child);
    let output = child.wait_with_output().expect("it ends");
    assert_eq!(output.status.signal(), Some(SIGINT), "{output:?}");
    assert!(
        String::from_utf8_lossy(&output.stderr).ends_with("tweeze: interrupted, nothing was written\n"),
        "{output:?}"
    );
    assert_eq!(bench.names(), ["slow.twz"]);
}

/// A signal that the parent process ignores, as `nohup` does, stays ignored.
#[cfg(target_os = "linux")]
#[test]
fn a_signal_that_is_ignored_stays_ignored() {
    let bench = Bench::new();
    let mut child = start(&bench, "trap '' HUP; exec");
    assert!(is_ready(&mut child), "no signal is caught");
    send("HUP", &child);
    send("TERM", &child);
    assert_eq!(child.wait().expect("it ends").signal(), Some(SIGTERM));
}

/// A shell shows 128 plus the number of the signal.
#[test]
fn a_shell_sees_the_usual_status() {
    let bench = Bench::new();
    let text = "\"$0\" build slow.twz -o out & sleep 0.3; kill -s TERM $!; wait $!";
    bench.write("slow.twz", found("ea_400_parts_gave_up.twz"));
    let mut command = Command::new("sh");
    command.args(["-c", text, env!("CARGO_BIN_EXE_tweeze")]).current_dir(bench.path("")).stderr(Stdio::null());
    assert_eq!(command.status().expect("the shell starts").code(), Some(143));
    assert_eq!(bench.names(), ["slow.twz"]);
}
