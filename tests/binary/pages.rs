//! Pages: `view`, and the page of a failed build.

use crate::{Bench, DONE, ERRORS, FILES, SMALL, err, out, says};
use std::fs;

/// The second step leaves the lattice of 32 × 32 cells.
const OFF: &str =
    "use std.dimibot\ndevice bot : dimibot.femto_st\ntask go on bot {\n  move to (1, 1)\n  move to (40, 3)\n}\n";

/// Data that only the page of a log has.
const RECORDED: &str = "\"recorded\":true,";

#[test]
fn a_log_is_shown_as_its_program_is_once_it_is_verified() {
    let bench = Bench::with(SMALL);
    let shown = bench.run(&["view", "a.twz", "--no-open"]).code(DONE);
    says(&out(&shown), &["Verified  go", "Wrote  go.html"]);
    let page = fs::read(bench.path("go.html")).expect("the page is there");
    bench.run(&["build", "a.twz", "-o", "logs"]).code(DONE);
    let shown = bench.run(&["view", "logs/go.mcap", "-o", "pages", "--no-open"]).code(DONE);
    says(&out(&shown), &["Verified  go", "Wrote  pages/go.html"]);
    // The page says that the bounds in the log were not derived again; everything else is the same.
    let of_log = fs::read_to_string(bench.path("pages/go.html")).expect("the page is there");
    assert_eq!(of_log.matches(RECORDED).count(), 1);
    assert_eq!(of_log.replace(RECORDED, "").into_bytes(), page);
    let mut log = fs::read(bench.path("logs/go.mcap")).expect("the log is there");
    let middle = log.len() / 2;
    log[middle] ^= 1;
    fs::write(bench.path("logs/go.mcap"), log).expect("the log is damaged");
    let refused = bench.run(&["view", "logs/go.mcap", "-o", "none", "--no-open"]).get_output().status.code();
    assert!(refused != Some(DONE) && bench.names("none").is_empty());
    // It is the page of the same program, which a program with another name does not replace.
    bench.run(&["view", "a.twz", "-o", "pages", "--no-open"]).code(DONE);
    bench.run(&["build", "a.twz", "-o", "logs", "--force"]).code(DONE);
    bench.run(&["view", "logs/go.mcap", "-o", "pages", "--no-open"]).code(DONE);
    fs::write(bench.path("b.twz"), SMALL).expect("written");
    bench.run(&["view", "b.twz", "-o", "pages", "--no-open"]).code(FILES);
    says(&err(&bench.run(&["view", "go.json", "--no-open"]).code(FILES)), &["E0801", "`FILE.mcap`"]);
}

#[test]
fn a_failed_build_that_asks_for_a_page_gets_one_of_its_errors_and_nothing_else() {
    let bench = Bench::with(OFF);
    let built = ["build", "a.twz", "-o", "out", "--emit", "mcap,html"];
    let failed = bench.run(&built).code(ERRORS);
    says(&err(&failed), &["E0501", "(40, 3)"]);
    says(&out(&failed), &["Wrote  out/a.failed.html", "what went wrong, and where"]);
    assert_eq!(bench.names("out"), ["a.failed.html"]);
    let page = fs::read_to_string(bench.path("out/a.failed.html")).expect("the page is there");
    says(&page, &["\"code\":\"E0501\"", "\"at\":[40.0,3.0]", "\"duration_ns\": 30000000"]);
    bench.run(&built).code(ERRORS);
    assert_eq!(fs::read_to_string(bench.path("out/a.failed.html")).expect("the page is there"), page, "same bytes");
    // Without a request for a page, none is written.
    bench.run(&["build", "a.twz", "-o", "none"]).code(ERRORS);
    assert!(bench.names("none").is_empty());
    // Another program's page is not replaced, nor removed.
    fs::create_dir(bench.path("other")).expect("a folder");
    fs::write(bench.path("other/a.twz"), OFF).expect("written");
    says(
        &err(&bench.run(&["build", "other/a.twz", "-o", "out", "--emit", "html"]).code(FILES)),
        &["E08", "a.failed.html"],
    );
    fs::write(bench.path("other/a.twz"), SMALL).expect("written");
    bench.run(&["build", "other/a.twz", "-o", "out", "--emit", "json"]).code(DONE);
    assert_eq!(bench.names("out"), ["a.failed.html", "go.json"]);
    // Once the program is built, its page of errors is removed.
    fs::write(bench.path("a.twz"), SMALL.replace("task go", "task come")).expect("written");
    bench.run(&built).code(DONE);
    assert_eq!(bench.names("out"), ["come.html", "come.lichtblick.json", "come.mcap", "go.json"]);
}

#[test]
fn whatever_is_wrong_is_shown() {
    let bench = Bench::new();
    let texts =
        ["task", "use std.dimibot\ntask go on bot { move to (1, 1) }\n", "\u{0}\u{feff}}}}{{{", "move to (1, 1)"];
    for text in texts {
        fs::write(bench.path("a.twz"), text).expect("written");
        let answered = bench.run(&["build", "a.twz", "-o", "out", "--emit", "html"]);
        let reported = err(&answered);
        let is_page =
            fs::read_to_string(bench.path("out/a.failed.html")).is_ok_and(|page| page.contains("\"schedule\":null"));
        assert!(answered.get_output().status.code() == Some(ERRORS) && is_page, "{text:?}: {reported}");
    }
    let piped = bench.command(&["build", "-", "-o", "piped", "--emit", "html"]).write_stdin(OFF).assert().code(ERRORS);
    says(&out(&piped), &["Wrote  piped/stdin.failed.html"]);
    fs::write(bench.path("a.twz"), OFF).expect("written");
    let reported = out(&bench.run(&["build", "a.twz", "-o", "out", "--emit", "html", "--format", "json"]).code(ERRORS));
    let report: serde_json::Value = serde_json::from_str(&reported).expect("one JSON document");
    assert_eq!(report, serde_json::json!({ "failed": "a.twz", "files": ["out/a.failed.html"] }));
    let viewed = bench.run(&["view", "a.twz", "-o", "out", "--no-open"]).code(ERRORS);
    says(&out(&viewed), &["Wrote  out/a.failed.html"]);
}
