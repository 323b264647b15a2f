//! Command-line behaviour shared by `build`, `check` and `verify`: several programs, standard input, all formats,
//! amount of output.

use super::*;

#[test]
fn several_programs_are_built_each_by_itself() {
    let bench = Bench::with(SMALL);
    fs::write(bench.path("b.twz"), SMALL.replace("task go", "task go_too").replace("(1, 1)", "(999, 1)"))
        .expect("written");
    fs::write(bench.path("c.twz"), SMALL.replace("task go", "task gone")).expect("written");
    let built = bench.run(&["build", "a.twz", "b.twz", "c.twz", "--emit", "json", "-o", "out"]).code(ERRORS);
    says(&out(&built), &["Wrote  out/go.json", "Wrote  out/gone.json"]);
    says(&err(&built), &["b.twz:3:", "error"]);
    assert_eq!(bench.names("out"), ["go.json", "gone.json"]);
}

#[test]
fn a_program_may_come_from_standard_input() {
    let bench = Bench::with(SMALL);
    let built = bench.command(&["build", "-", "-o", "out"]).write_stdin(SMALL).assert().code(DONE);
    says(&out(&built), &["Checked  <stdin>", "out/go.mcap"]);
    let log = bench.path("out/go.mcap").to_string_lossy().into_owned();
    bench.run(&["verify", &log]).code(DONE);
    bench.run(&["verify", &log, "--against", "a.twz"]).code(DONE);
    // The same program again replaces its own files; another program does not.
    bench.command(&["build", "-", "-o", "out"]).write_stdin(SMALL).assert().code(DONE);
    says(&err(&bench.run(&["build", "a.twz", "-o", "out"]).code(FILES)), &["<stdin>"]);
    let wrong = bench.command(&["check", "-"]).write_stdin(SMALL.replace("move", "mvoe")).assert().code(ERRORS);
    says(&err(&wrong), &["<stdin>:3:"]);
}

#[test]
fn a_check_may_plan_and_writes_nothing() {
    let bench = Bench::with(SMALL);
    let planned = bench.run(&["check", "a.twz", "--plan"]).code(DONE);
    says(&out(&planned), &["Checked  a.twz", "Planned  go", "optimal", "Verified  go"]);
    let built = bench.run(&["build", "a.twz", "-o", "out", "--format", "json"]).code(DONE);
    let json = bench.run(&["check", "a.twz", "--plan", "--format", "json"]).code(DONE);
    let [checked, built] =
        [&json, &built].map(|report| serde_json::from_str::<serde_json::Value>(&out(report)).expect("JSON"));
    assert_eq!(checked["checked"], "a.twz");
    assert_eq!(checked["schedules"][0]["plans"], built["schedules"][0]["plans"]);
    says(checked["schedules"][0]["plans"][0]["summary"].as_str().expect("a text"), &["optimal (bound"]);
    // Without a plan, `check --plan` does not succeed in any format; the checker alone has no objection.
    let walled = SMALL.replace(
        "task go on bot",
        "scene s { obstacle wall : cells { from: (1, 0), to: (1, 3) } }\ntask go on bot in s",
    );
    fs::write(bench.path("b.twz"), walled.replace("(1, 1)", "(3, 3)")).expect("written");
    bench.run(&["check", "b.twz"]).code(DONE);
    for format in ["human", "short", "json", "github"] {
        let failed = bench.run(&["check", "b.twz", "--plan", "--format", format]).code(ERRORS);
        says(&err(&failed), &["E0601"]);
    }
    says(&out(&bench.run(&["check", "b.twz", "a.twz", "--plan", "--format", "sarif"]).code(ERRORS)), &["E0601"]);
    assert_eq!(out(&bench.run(&["check", "a.twz", "--plan", "--quiet"]).code(DONE)), "");
    assert_eq!(bench.names("."), ["a.twz", "b.twz", "out"]);
}

#[test]
fn all_formats_are_those_that_have_a_form() {
    let bench = Bench::with(SMALL);
    let built = bench.run(&["build", "a.twz", "--emit", "all", "-o", "out"]).code(DONE);
    says(&out(&built), &["out/go.mcap", "out/go.svg", "Left out  scpi", "Left out  nidaqmx", "Left out  gcode"]);
    let json = bench.run(&["build", "a.twz", "--emit", "all", "-o", "out", "--format", "json"]).code(DONE);
    says(&out(&json), &["\"left_out\":[{\"format\":\"scpi\""]);
    // A format that was named must be written.
    says(&err(&bench.run(&["build", "a.twz", "--emit", "all,scpi", "-o", "out"]).code(ERRORS)), &["E0824"]);
}

#[test]
fn reports_are_as_loud_and_colourful_as_asked() {
    let bench = Bench::with(SMALL);
    for arguments in [&["build", "a.twz", "-q"][..], &["check", "--quiet", "a.twz"], &["verify", "go.mcap", "-q"]] {
        let quiet = bench.run(arguments).code(DONE);
        assert_eq!((out(&quiet), err(&quiet)), (String::new(), String::new()), "{arguments:?}");
    }
    let plain = out(&bench.run(&["build", "a.twz"]).code(DONE));
    let coloured = out(&bench.run(&["--color", "always", "build", "a.twz"]).code(DONE));
    assert!(!plain.contains('\x1b') && coloured.contains("\x1b[1;32m"));
    let wrong = bench.run(&["check", "none.twz", "--color=always"]).code(FILES);
    assert!(err(&wrong).contains('\x1b'), "{}", err(&wrong));
}

#[test]
fn a_folder_that_cannot_be_written_is_found_before_the_search_for_a_plan() {
    // Planning this one would end in E0601.
    let walled = SMALL.replace("on bot", "on bot in s").replace("task", "scene s { obstacle wall at (1, 1) }\ntask");
    let bench = Bench::with(walled);
    let failed = bench.run(&["build", "a.twz", "-o", "a.twz/out"]).code(FILES);
    says(&err(&failed), &["it is a file, not a folder"]);
}

/// A log that keeps its own program but not another one is not a bug of Tweeze: the report says whose it is, and names
/// each broken rule once.
#[test]
fn a_log_of_another_program_is_told_so() {
    let bench = Bench::new();
    let wired = fs::read_to_string(example("dimibot_fetch.twz")).expect("the example is there");
    let [before, wiring] = wired.split_once("\nwiring ").map(<[&str; 2]>::from).expect("it is wired");
    let after = wiring.split_once("\n}\n").expect("the wiring ends").1;
    let plain: String =
        before.lines().filter(|line| !line.contains("instrument")).map(|line| format!("{line}\n")).collect();
    fs::write(bench.path("a.twz"), &wired).expect("written");
    fs::write(bench.path("b.twz"), format!("{plain}{after}")).expect("written");
    bench.run(&["build", "a.twz"]).code(DONE);
    let refused = err(&bench.run(&["verify", "fetch.mcap", "--against", "b.twz"]).code(REFUSED));
    says(
        &refused,
        &[
            "E0742",
            "`fetch.mcap` was built from a program with other claims than `b.twz`",
            "E0706",
            "20 more violations of this rule",
        ],
    );
    assert_eq!(refused.matches("E0706").count(), 1, "{refused}");
    assert!(!refused.contains("report it as a bug"), "{refused}");
}

#[test]
fn a_file_of_devices_alone_is_no_reason_to_warn_of_its_devices() {
    let bench = Bench::with("use std.dimibot\ndevice bot : dimibot.femto_st\n");
    says(&err(&bench.run(&["check", "a.twz"]).code(DONE)), &["W0503"]);
    let listed = bench.run(&["devices", "a.twz"]).code(DONE);
    assert!(err(&listed).is_empty() && out(&listed).contains("bot: dimibot"), "{}", err(&listed));
}

/// A project from each template builds at once without a diagnostic and is in canonical form; nothing is overwritten.
#[test]
fn a_new_project_builds_at_once() {
    let bench = Bench::new();
    for template in ["pick-and-place", "scan", "sort", "assay", "assemble", "turn"] {
        let folder = format!("deep/{template}");
        let made = out(&bench.run(&["new", &folder, "--template", template]).code(DONE));
        let program = format!("{folder}/{template}.twz");
        says(&made, &["Created", &program, "tweeze build", "tweeze view"]);
        let text = fs::read_to_string(bench.path(&program)).expect("it is there");
        assert!(text.starts_with(&format!("//! {template}: ")), "{text}");
        let built = bench.run(&["build", &program, "-o", &format!("{folder}/out")]).code(DONE);
        assert!(err(&built).is_empty() && out(&built).contains("0 violations"), "{}", err(&built));
        bench.run(&["fmt", "--check", &program]).code(DONE);
        let again = bench.run(&["new", &folder, "--template", template]).code(FILES);
        says(&err(&again), &["E0804", "it already exists"]);
        assert_eq!(fs::read_to_string(bench.path(&program)).expect("it is there"), text);
    }
    for (kind, word) in [
        ("dimibot", "femto_st"),
        ("electrode_array", "smart_platform"),
        ("microrobots", "bed"),
        ("fingers", "three_fingers"),
    ] {
        bench.run(&["new", kind, "--kind", kind]).code(DONE);
        let text = fs::read_to_string(bench.path(&format!("{kind}/{kind}.twz"))).expect("it is there");
        assert!(text.contains(word), "{text}");
    }
    says(&err(&bench.run(&["new", "x", "--template", "sacn"]).code(USAGE)), &["'sacn'", "scan"]);
    says(&err(&bench.run(&["new", ".."]).code(FILES)), &["is not a valid name"]);
    says(&err(&bench.run(&["new", "fetch.twz"]).code(FILES)), &["tweeze new fetch`"]);
}
