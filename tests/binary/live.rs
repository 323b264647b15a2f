//! The report of `build`, line by line.

use crate::{Bench, DONE, ERRORS, SMALL, err, out, says};
use std::fs;
use std::io::{BufRead, BufReader};
use std::path::Path;
use std::process::{Command, Stdio};

#[test]
fn lines_come_while_the_rest_is_planned() {
    // Takes more than a second.
    let slow = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/found/ea_siding_gave_up.twz");
    let bench = Bench::new();
    let mut command = Command::new(env!("CARGO_BIN_EXE_tweeze"));
    command.current_dir(bench.path(".")).arg("build").arg(slow).args(["-o", "out"]).stdout(Stdio::piped());
    let mut build = command.spawn().expect("it runs");
    let mut line = String::new();
    BufReader::new(build.stdout.take().expect("a pipe")).read_line(&mut line).expect("a line");
    let has_ended = build.try_wait().expect("it is watched").is_some();
    build.kill().expect("it can be ended");
    build.wait().expect("it has ended");
    says(&line, &["Checked", "ea_siding_gave_up.twz"]);
    assert!(!has_ended);
}

#[test]
fn a_build_that_fails_keeps_the_lines_that_it_had() {
    let apart = "task far on bot { require switches <= 1\n move to (1, 1) }\n";
    let bench = Bench::with(format!("{SMALL}{apart}"));
    let failed = bench.run(&["build", "a.twz", "-o", "out"]).code(ERRORS);
    says(&out(&failed), &["Checked  a.twz", "Planned  go"]);
    assert_eq!(out(&failed).lines().count(), 2, "{}", out(&failed));
    says(&err(&failed), &["E0603"]);
    assert!(bench.names("out").is_empty());
    // Nothing is free of errors before all is.
    fs::write(bench.path("a.twz"), SMALL.replace("(1, 1)", "(99, 1)")).expect("written");
    assert_eq!(out(&bench.run(&["build", "a.twz"]).code(ERRORS)), "");
}

#[test]
fn the_last_line_counts_programs_schedules_and_files() {
    let bench = Bench::with(SMALL);
    let last = |text: &str| text.lines().last().unwrap_or_default().trim().to_owned();
    assert_eq!(last(&out(&bench.run(&["build", "a.twz"]).code(DONE))), "Done  1 schedule in 2 files");
    fs::write(bench.path("b.twz"), SMALL.replace("task go", "task come")).expect("written");
    fs::write(bench.path("c.twz"), "task").expect("written");
    let two = ["build", "a.twz", "b.twz", "--emit", "json,csv,svg"];
    assert_eq!(last(&out(&bench.run(&two).code(DONE))), "Done  2 programs, 2 schedules in 6 files");
    let three = bench.run(&["build", "a.twz", "b.twz", "c.twz"]).code(ERRORS);
    assert_eq!(last(&out(&three)), "Done  2 of 3 programs, 2 schedules in 4 files");
    assert_eq!(out(&bench.run(&["build", "c.twz"]).code(ERRORS)), "");
    assert_eq!(out(&bench.run(&["build", "a.twz", "--quiet"]).code(DONE)), "");
}
