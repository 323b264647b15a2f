//! `--watch`: each change to a program's files is built.

use crate::{Bench, DONE, SMALL, USAGE, err, out, says};
use std::fs;
use std::io::{BufRead, BufReader};
use std::process::{Child, Command, Stdio};
use std::sync::mpsc::{Receiver, channel};
use std::thread;
use std::time::Duration;

/// No build of these tests takes longer, even on a busy machine.
const PATIENCE: Duration = Duration::from_secs(60);

/// A watching program and the lines that it prints.
struct Watched {
    process: Child,
    lines: Receiver<String>,
}

impl Watched {
    fn run(bench: &Bench, arguments: &[&str]) -> Watched {
        let mut command = Command::new(env!("CARGO_BIN_EXE_tweeze"));
        command.current_dir(bench.path(".")).args(arguments).stdout(Stdio::piped()).stderr(Stdio::null());
        let mut process = command.spawn().expect("it runs");
        let (line, lines) = channel();
        let printed = BufReader::new(process.stdout.take().expect("a pipe")).lines();
        thread::spawn(move || printed.map_while(Result::ok).try_for_each(|text| line.send(text)));
        Watched { process, lines }
    }

    /// The lines of the next build, including the one that ends it.
    #[track_caller]
    fn build(&self) -> String {
        let mut built = String::new();
        while !built.contains("Watching") {
            built.push_str(&self.lines.recv_timeout(PATIENCE).expect("a build follows"));
            built.push('\n');
        }
        built
    }
}

impl Drop for Watched {
    fn drop(&mut self) {
        self.process.kill().expect("it goes on until it is ended");
        self.process.wait().expect("it has ended");
    }
}

#[test]
fn each_change_of_a_file_that_is_needed_is_built_and_nothing_else() {
    let bench = Bench::with(SMALL);
    let watched = Watched::run(&bench, &["build", "a.twz", "-o", "out", "--watch"]);
    says(&watched.build(), &["Wrote  out/go.mcap", "Watching  1 file", "Ctrl-C ends"]);
    fs::write(bench.path("a.twz"), format!("use \"own.twz\"\n{SMALL}")).expect("written");
    says(&watched.build(), &["Watching  2 files"]);
    assert_eq!(bench.names("out"), ["go.lichtblick.json", "go.mcap"], "the last good build is kept");
    fs::write(bench.path("other.twz"), "").expect("written");
    fs::write(bench.path("own.twz"), "const far : (1, 1)\n").expect("written");
    says(&watched.build(), &["Watching  2 files"]);
    fs::write(bench.path("own.twz"), "// Nothing of its own.\n").expect("written");
    says(&watched.build(), &["Planned  go", "Watching  2 files"]);
    fs::remove_file(bench.path("own.twz")).expect("removed");
    says(&watched.build(), &["Watching  2 files"]);
    assert!(watched.lines.recv_timeout(Duration::from_millis(600)).is_err(), "nothing has changed");
}

#[test]
fn checks_follow_their_program_too() {
    let bench = Bench::with(SMALL);
    let watched = Watched::run(&bench, &["check", "a.twz", "--watch", "--plan"]);
    says(&watched.build(), &["Checked  a.twz", "Planned  go", "Watching  1 file"]);
    fs::write(bench.path("a.twz"), format!("use \"own.twz\"\n{SMALL}")).expect("written");
    says(&watched.build(), &["Watching  2 files"]);
    fs::write(bench.path("own.twz"), "// Nothing of its own.\n").expect("written");
    says(&watched.build(), &["Planned  go", "Watching  2 files"]);
    assert_eq!(bench.names("."), ["a.twz", "own.twz"]);
}

#[test]
fn pages_follow_their_program() {
    let bench = Bench::with(SMALL);
    bench.run(&["view", "a.twz", "-o", "once", "--no-open"]).code(DONE);
    let once = fs::read_to_string(bench.path("once/go.html")).expect("the page is there");
    assert!(!once.contains("data-follow"), "only with --watch");
    let watched = Watched::run(&bench, &["view", "a.twz", "-o", "out", "--no-open", "--watch"]);
    says(&watched.build(), &["Wrote  out/go.html"]);
    assert_eq!(bench.names("out"), ["a.latest.js", "go.html"]);
    let latest = || fs::read_to_string(bench.path("out/a.latest.js")).expect("the script is there");
    let (page, good) = (fs::read_to_string(bench.path("out/go.html")).expect("the page is there"), latest());
    let stamp = good.split('"').nth(3).expect("a stamp");
    says(&page, &[&format!("data-follow=\"a.latest.js\" data-stamp=\"{stamp}\"")]);
    says(&good, &["tweezeBuilt({", "\"pages\":[\"go.html\"]"]);
    fs::write(bench.path("a.twz"), SMALL.replace("(1, 1)", "(99, 1)")).expect("written");
    says(&watched.build(), &["Wrote  out/a.failed.html"]);
    says(&latest(), &["\"pages\":[\"a.failed.html\"]"]);
    fs::write(bench.path("a.twz"), SMALL).expect("written");
    says(&watched.build(), &["Wrote  out/go.html"]);
    assert_eq!((bench.names("out"), latest()), (vec!["a.latest.js".to_owned(), "go.html".to_owned()], good.clone()));
    fs::remove_file(bench.path("a.twz")).expect("removed");
    says(&watched.build(), &["Wrote  out/a.failed.html"]);
    says(&fs::read_to_string(bench.path("out/a.failed.html")).expect("the page is there"), &["E0801"]);
    fs::write(bench.path("a.twz"), SMALL).expect("written");
    says(&watched.build(), &["Wrote  out/go.html"]);
    assert_eq!((bench.names("out"), latest()), (vec!["a.latest.js".to_owned(), "go.html".to_owned()], good));
}

#[test]
fn what_cannot_change_is_not_watched() {
    let bench = Bench::with(SMALL);
    for arguments in [
        ["build", "-", "--watch"].as_slice(),
        &["check", "-", "--watch"],
        &["build", "a.twz", "-", "--watch"],
        &["view", "-", "--watch"],
        &["view", "go.mcap", "--watch"],
    ] {
        let wrong = bench.run(arguments).code(USAGE);
        says(&err(&wrong), &["--watch needs a", &format!("Usage: tweeze {}", arguments[0])]);
        assert_eq!(out(&wrong), "");
    }
    // Wrong usage is not watched; the command ends.
    says(&err(&bench.run(&["build", "a.twz", "--at", "1ms", "--watch"]).code(USAGE)), &["--emit svg"]);
}
