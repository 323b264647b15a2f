//! Live report of `build`, line by line.

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
    // No line claims a check before the whole program is free of errors.
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

#[test]
fn a_verbose_build_tells_every_line_and_what_was_searched() {
    let go = |nth: usize| format!("task go{nth} on bot {{ move to ({}, {}) }}\n", 1 + nth % 3, 1 + nth / 3 % 3);
    let program: String = (0..25).map(go).collect();
    let runs: String = (0..25).map(|nth| format!("  run go{nth}\n")).collect();
    let bot = "use std.dimibot\ndevice bot : dimibot.femto_st\n";
    let bench = Bench::with(format!("{bot}{program}program all {{\n{runs}}}\n"));
    let reported = |arguments: &[&str]| out(&bench.run(arguments).code(DONE));
    let lines = |text: &str, word: &str| text.lines().filter(|line| line.trim_start().starts_with(word)).count();
    let usual = reported(&["build", "a.twz", "--task", "all"]);
    assert_eq!((lines(&usual, "Planned"), lines(&usual, "Searched")), (20, 0), "{usual}");
    says(&usual, &["and 5 runs more"]);
    let all = reported(&["build", "a.twz", "--task", "all", "-v"]);
    assert_eq!((lines(&all, "Planned"), lines(&all, "Searched")), (25, 25), "{all}");
    says(&all, &["Searched  all: go24"]);
    // The same bytes again: no time is printed without a terminal.
    assert_eq!(reported(&["build", "a.twz", "--task", "all", "--verbose"]), all);
    bench.run(&["build", "a.twz", "-v", "-q"]).code(crate::USAGE);
}

#[test]
fn what_was_searched_is_told_of_its_own_schedule() {
    let far = "task far on bot { require switches <= 1\n move to (1, 1) }\n";
    let bench = Bench::with(SMALL.replace("task go", &format!("{far}task go")));
    let searched = |text: String| -> Vec<String> {
        text.lines().filter(|line| line.trim_start().starts_with("Searched")).map(str::to_owned).collect()
    };
    let failed = searched(out(&bench.run(&["build", "a.twz", "-v"]).code(ERRORS)));
    assert_eq!(failed.len(), 1, "{failed:?}");
    // The search for `far`, which came before and found nothing, took one step.
    says(&failed[0], &["Searched  go ", "nothing: the plan needs no search"]);
}
