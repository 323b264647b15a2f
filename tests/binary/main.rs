//! The built program from the user's side: commands, exit statuses, files, streams.

mod editor;
mod hints;
mod holds;
mod live;
mod outputs;
mod pages;
mod reports;
mod usage;
mod watch;

use assert_cmd::Command;
use assert_cmd::assert::Assert;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command as Plain, Stdio};
use tempfile::TempDir;

const DONE: i32 = 0;
const ERRORS: i32 = 1;
const USAGE: i32 = 2;
const REFUSED: i32 = 3;
const FILES: i32 = 4;

const SMALL: &str = "use std.dimibot\ndevice bot : dimibot.femto_st\ntask go on bot { move to (1, 1) }\n";

const ALL_FORMATS: &str = "mcap,json,csv,vcd,pwl,nidaqmx,html,svg";

const ENDINGS: [&str; 12] = [
    "mcap", "lichtblick.json", "json", "csv", "vcd", "gtkw", "pwl.inc", "cir", "card.daq", "nidaqmx.py", "html", "svg",
];

fn example(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("examples").join(name)
}

/// A temporary folder in which the program runs.
struct Bench {
    folder: TempDir,
}

impl Bench {
    fn new() -> Bench {
        Bench { folder: tempfile::tempdir().expect("a folder for the test") }
    }

    fn with(text: impl AsRef<[u8]>) -> Bench {
        let bench = Bench::new();
        fs::write(bench.path("a.twz"), text).expect("a program is written");
        bench
    }

    fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    fn command(&self, arguments: &[&str]) -> Command {
        let mut command = Command::new(env!("CARGO_BIN_EXE_tweeze"));
        command.current_dir(self.folder.path()).env_remove("COLUMNS").env_remove("NO_COLOR").args(arguments);
        command
    }

    fn run(&self, arguments: &[&str]) -> Assert {
        self.command(arguments).assert()
    }

    /// The names in a folder, including hidden ones except the manifest.
    fn names(&self, folder: &str) -> Vec<String> {
        let entries = fs::read_dir(self.path(folder)).into_iter().flatten().flatten();
        let mut names: Vec<String> = entries.map(|entry| entry.file_name().to_string_lossy().into_owned()).collect();
        names.retain(|name| name != ".tweeze.json");
        names.sort();
        names
    }
}

fn out(assert: &Assert) -> String {
    String::from_utf8_lossy(&assert.get_output().stdout).into_owned()
}

fn err(assert: &Assert) -> String {
    String::from_utf8_lossy(&assert.get_output().stderr).into_owned()
}

#[track_caller]
fn says(text: &str, parts: &[&str]) {
    for part in parts {
        assert!(text.contains(part), "`{part}` is not in:\n{text}");
    }
}

#[test]
fn help_teaches() {
    let bench = Bench::new();
    let commands =
        ["check", "build", "verify", "new", "explain", "fmt", "lsp", "simulate", "control", "devices", "completions"];
    let top = out(&bench.run(&["--help"]).code(DONE));
    says(&top, &commands);
    says(&top, &["Exit status: 0 done; 1 the program has errors; 2 wrong usage; 3", "tweeze build FILE.twz"]);
    for command in commands {
        let help = out(&bench.run(&[command, "--help"]).code(DONE));
        says(&help, &["Example", &format!("tweeze {command}"), "Usage: "]);
        assert!(help.lines().all(|line| line.chars().count() <= 100), "{help}");
    }
    says(&out(&bench.run(&["build", "--help"])), &ALL_FORMATS.split(',').collect::<Vec<_>>());
    says(&out(&bench.run(&["--version"]).code(DONE)), &["tweeze ", env!("CARGO_PKG_VERSION")]);
}

#[test]
fn wrong_usage_is_told_apart() {
    let bench = Bench::with(SMALL);
    for arguments in [
        &[][..],
        &["bild"],
        &["build"],
        &["check"],
        &["verify"],
        &["fmt"],
        &["build", "-", "-"],
        &["build", "a.twz", "--color", "red"],
        &["build", "a.twz", "--emit", "mp3"],
        &["build", "a.twz", "--emit", ""],
        &["check", "a.twz", "--format", "xml"],
        &["explain", "E9999"],
        &["devices", "dimibott"],
        &["completions", "cmd"],
        &["build", "a.twz", "--frobnicate"],
    ] {
        let wrong = bench.run(arguments).code(USAGE);
        assert!(!err(&wrong).is_empty() && out(&wrong).is_empty(), "{arguments:?}");
    }
    says(&err(&bench.run(&["bild"])), &["build"]);
    says(&err(&bench.run(&["devices", "dimibott"])), &["did you mean `dimibot`?"]);
    says(&err(&bench.run(&["build", "a.twz", "--emit", "mcap,cvs"])), &["'cvs'", "similar", "'csv'"]);
    assert_eq!(bench.names("."), ["a.twz"]);
}

#[test]
fn every_command_answers() {
    let bench = Bench::with(SMALL);
    says(&out(&bench.run(&["check", "a.twz"]).code(DONE)), &["Checked  a.twz  1 device, 1 task"]);
    says(&out(&bench.run(&["devices"]).code(DONE)), &["dimibot", "use std.dimibot"]);
    let page = out(&bench.run(&["devices", "dimibot"]).code(DONE));
    says(&page, &["pulse_voltage", "[V]", "move to", "visit", "energy", "hypercube_astar", "capsule", "bl<i>.set"]);
    assert!(page.lines().all(|line| line.chars().count() <= 100), "{page}");
    says(&out(&bench.run(&["explain", "E0503"]).code(DONE)), &["E0503", "precision"]);
    assert_eq!(out(&bench.run(&["explain", "e0503"]).code(DONE)), out(&bench.run(&["explain", "E0503"])));
    assert!(out(&bench.run(&["explain"]).code(DONE)).lines().count() > 60);
    for shell in ["bash", "zsh", "fish", "powershell", "elvish"] {
        says(&out(&bench.run(&["completions", shell]).code(DONE)), &["tweeze", "build"]);
    }
}

#[test]
fn every_code_has_a_page() {
    let bench = Bench::new();
    for line in out(&bench.run(&["explain"])).lines() {
        let code = line.split_whitespace().next().unwrap_or_default();
        assert!(out(&bench.run(&["explain", code]).code(DONE)).lines().count() > 2, "{code}");
    }
}

#[test]
fn a_build_tells_what_it_did_and_writes_every_format() {
    let bench = Bench::new();
    let fetch = example("dimibot_fetch.twz");
    let arguments = ["build", &fetch.to_string_lossy(), "--emit", ALL_FORMATS, "-o", "deep/er"];
    let built = bench.run(&arguments).code(DONE);
    let report = "  \
  Checked  dimibot_fetch.twz              1 device, 1 scene, 1 task
  Planned  fetch                          30.74 um (72 r) in 11 switches, optimal (bound 30.74 um)
  Nearest                                 (3.2 um, 5.9 um) is cell (7, 14), 225.1 nm off
 Verified  fetch                          11 actuations replayed, 0 violations
    Wrote  deep/er/fetch.mcap             20 channels, 11 actuations, 165 ms, 330 mJ
";
    assert!(out(&built).starts_with(report), "{}", out(&built));
    assert_eq!(err(&built), "");
    let mut expected: Vec<String> = ENDINGS.iter().map(|ending| format!("fetch.{ending}")).collect();
    expected.sort();
    assert_eq!(bench.names("deep/er"), expected);
    let before: Vec<Vec<u8>> =
        expected.iter().map(|name| fs::read(bench.path("deep/er").join(name)).expect("written")).collect();
    assert!(before.iter().all(|bytes| !bytes.is_empty()));

    bench.run(&arguments).code(DONE);
    let after: Vec<Vec<u8>> =
        expected.iter().map(|name| fs::read(bench.path("deep/er").join(name)).expect("written")).collect();
    assert!(before == after, "two builds differ");
    assert_eq!(bench.names("deep/er"), expected);

    bench.run(&["verify", "deep/er/fetch.mcap"]).code(DONE);
    says(
        &out(&bench.run(&["verify", "deep/er/fetch.mcap", "--against", &fetch.to_string_lossy()]).code(DONE)),
        &["Matches"],
    );
}

#[test]
fn one_task_of_a_program_can_be_built() {
    let bench = Bench::new();
    let day = example("dimibot_day.twz");
    let day = day.to_string_lossy();
    bench.run(&["build", &day, "-o", "out", "--task", "errand", "--emit", "json,csv,json"]).code(DONE);
    assert_eq!(bench.names("out"), ["errand.csv", "errand.json"]);
    let unknown = bench.run(&["build", &day, "--task", "errant"]).code(ERRORS);
    says(&err(&unknown), &["E0513", "did you mean `errand`?"]);
    // A task with parameters cannot be built on its own.
    bench.run(&["build", &day, "--task", "go"]).code(ERRORS);
}

#[test]
fn settings_replace_values() {
    let bench = Bench::new();
    let day = example("dimibot_day.twz");
    let day = day.to_string_lossy();
    let set = |value: &str| bench.run(&["build", &day, "--task", "errand", "-o", "out", "--set", value]);
    says(&out(&set("pause=10ms").code(DONE)), &["235 ms"]);
    says(&out(&set("pause = 30 ms").code(DONE)), &["255 ms"]);
    for (value, part) in [
        ("pause=3um", "is a length"),
        ("paus=3ms", "paus"),
        ("pause", "pause"),
        ("pause=", "is not a value"),
        ("=", ""),
        ("pause=1e999ms", ""),
        ("pause=10 V)", ""),
    ] {
        says(&err(&set(value).code(ERRORS)), &[part]);
    }
    bench.run(&["verify", "out/errand.mcap"]).code(DONE);
}

#[test]
fn programs_with_errors_write_nothing() {
    let bench = Bench::with(SMALL.replace("(1, 1)", "(1, 9)"));
    let failed = bench.run(&["build", "a.twz", "-o", "out"]).code(ERRORS);
    says(&err(&failed), &["E0501", "a.twz:3:", "help: "]);
    assert_eq!((out(&failed).as_str(), bench.names("out").len(), bench.path("out").exists()), ("", 0, false));

    let shut = SMALL
        .replace("go on bot {", "go on bot in s {\n")
        .replace("task", "scene s { obstacle a at (0, 1), obstacle b at (1, 0) }\ntask");
    fs::write(bench.path("a.twz"), shut.replace("(1, 1) }", "(1, 1)\n}")).expect("written");
    says(&err(&bench.run(&["build", "a.twz"]).code(ERRORS)), &["E0601", "without `a`"]);
}

#[test]
fn files_that_cannot_be_read() {
    let bench = Bench::with(b"use std.dimibot\ndevice b\xff : dimibot\n");
    fs::create_dir(bench.path("folder.twz")).expect("a folder");
    for command in ["check", "build", "verify"] {
        says(&err(&bench.run(&[command, "missing.twz"]).code(FILES)), &["E0801", "missing.twz", "no such file"]);
        says(&err(&bench.run(&[command, "folder.twz"]).code(FILES)), &["E0801", "it is a folder"]);
    }
    says(&err(&bench.run(&["check", "a.twz"]).code(FILES)), &["E0803", "byte 24, in line 2"]);
    // The gravest outcome is the exit status, and the others are reported too.
    fs::write(bench.path("good.twz"), SMALL).expect("written");
    fs::write(bench.path("bad.twz"), SMALL.replace("(1, 1)", "(1 V, 1)")).expect("written");
    let several = bench.run(&["check", "bad.twz", "missing.twz", "good.twz"]).code(FILES);
    says(&err(&several), &["missing.twz", "bad.twz:3:"]);
    says(&out(&several), &["good.twz"]);
}

#[test]
fn a_file_larger_than_the_limit_is_refused_before_it_is_read() {
    let bench = Bench::new();
    let file = fs::File::create(bench.path("a.twz")).expect("a file");
    file.set_len(40 * 1024 * 1024).expect("a long file");
    says(&err(&bench.run(&["check", "a.twz"]).code(FILES)), &["E0802", "16 MiB"]);
    if Path::new("/dev/zero").exists() {
        says(&err(&bench.run(&["check", "/dev/zero"]).code(FILES)), &["E0802"]);
    }
}

#[test]
fn used_files_lie_beside_the_program() {
    let bench = Bench::with("use \"lab/bench.twz\" as lab\ntask go on lab.bot { move to (1, 1) }\n");
    says(&err(&bench.run(&["check", "a.twz"]).code(ERRORS)), &["lab/bench.twz", "a.twz:1:"]);
    fs::create_dir(bench.path("lab")).expect("a folder");
    fs::write(bench.path("lab/bench.twz"), "use std.dimibot\nuse \"../a.twz\" as a\ndevice bot : dimibot.femto_st\n")
        .expect("written");
    says(&err(&bench.run(&["check", "a.twz"]).code(ERRORS)), &["a.twz", "lab/bench.twz"]);
    fs::write(bench.path("lab/bench.twz"), "use std.dimibot\ndevice bot : dimibot.femto_st\n").expect("written");
    bench.run(&["build", "a.twz", "-o", "out"]).code(DONE);
    // The log contains both files, so it can be verified elsewhere.
    fs::remove_dir_all(bench.path("lab")).expect("removed");
    bench.run(&["verify", "out/go.mcap"]).code(DONE);
}

#[test]
fn all_files_are_written_or_none() {
    let bench = Bench::with(SMALL);
    // A folder blocks the last file that is written.
    fs::create_dir_all(bench.path("out/go.svg")).expect("a folder");
    fs::write(bench.path("out/go.json"), "as it was").expect("written");
    let failed = bench.run(&["build", "a.twz", "-o", "out", "--emit", "mcap,json,csv,vcd,pwl,html,svg"]).code(FILES);
    says(&err(&failed), &["E0804", "go.svg", "nothing was written"]);
    assert!(out(&failed).contains("Verified") && !out(&failed).contains("Wrote"));
    assert_eq!(bench.names("out"), ["go.json", "go.svg"]);
    assert_eq!(fs::read_to_string(bench.path("out/go.json")).expect("there"), "as it was");

    for folder in ["a.twz", "a.twz/in"] {
        says(&err(&bench.run(&["build", "a.twz", "-o", folder]).code(FILES)), &["E0804", "a.twz"]);
    }
    assert_eq!(fs::read_to_string(bench.path("a.twz")).expect("there"), SMALL);
}

#[test]
fn voltages_are_no_gcode() {
    let bench = Bench::with(SMALL);
    let refused = bench.run(&["build", "a.twz", "-o", "out", "--emit", "json,gcode"]).code(ERRORS);
    says(&err(&refused), &["E0827", "takes voltages"]);
    assert!(bench.names("out").is_empty());
}

#[test]
fn a_picture_of_one_instant() {
    let bench = Bench::with(SMALL);
    let picture = |spelling: &str| {
        bench.run(&["build", "a.twz", "-o", "out", "--emit", "svg", "--at", spelling]).code(DONE);
        fs::read_to_string(bench.path("out/go.svg")).expect("the picture is there")
    };
    let drawn = picture("15 ms");
    assert!(drawn.contains("data-t-ns=\"15000000\"") && drawn.contains("at 15 ms of "));
    assert!(["15ms", "0.015 s", "15000us"].iter().all(|spelling| picture(spelling) == drawn));
    bench.run(&["build", "a.twz", "-o", "out", "--emit", "svg"]).code(DONE);
    assert!(fs::read_to_string(bench.path("out/go.svg")).expect("the picture is there").contains("1:\u{a0}0\u{a0}ms"));

    let late = bench.run(&["build", "a.twz", "-o", "late", "--emit", "svg,json", "--at", "1 h"]).code(ERRORS);
    says(&err(&late), &["E0828", "after the end of `go`, which lasts 30 ms"]);
    let unused = bench.run(&["build", "a.twz", "-o", "late", "--at", "5ms"]).code(USAGE);
    says(&err(&unused), &["--at", "--emit svg", "Usage"]);
    let forms = "expected a time, such as 50ms or 0.5s";
    for (text, mend) in [("5", forms), ("5 um", forms), ("ms", forms), ("-5ms", "expected a time of 0 s or more")] {
        let at = format!("--at={text}");
        let wrong = bench.run(&["build", "a.twz", "-o", "late", "--emit", "svg", &at]).code(USAGE);
        says(&err(&wrong), &[mend]);
    }
    assert!(bench.names("late").is_empty());
}

#[cfg(unix)]
#[test]
fn a_folder_that_cannot_be_written_to() {
    use std::os::unix::fs::PermissionsExt;
    let bench = Bench::with(SMALL);
    fs::create_dir(bench.path("out")).expect("a folder");
    fs::set_permissions(bench.path("out"), fs::Permissions::from_mode(0o555)).expect("permissions");
    if fs::write(bench.path("out/probe"), "").is_ok() {
        let _ = fs::remove_file(bench.path("out/probe"));
        println!("SKIPPED: permissions do not bind this user");
        return;
    }
    says(&err(&bench.run(&["build", "a.twz", "-o", "out"]).code(FILES)), &["E0804", "permission denied"]);
    assert!(bench.names("out").is_empty());
}

/// A limit on file size stands in for a full disk: a write fails half-way.
#[cfg(unix)]
#[test]
fn a_disk_that_is_full_half_way() {
    let bench = Bench::new();
    let fetch = example("dimibot_fetch.twz");
    // One block of 512 or 1024 bytes: none of the files but the shortest fits. The signal is ignored, so that the write
    // fails.
    let script = format!(
        "trap '' XFSZ; ulimit -f 1; exec '{}' build '{}' -o out --emit {ALL_FORMATS}",
        env!("CARGO_BIN_EXE_tweeze"),
        fetch.display()
    );
    let full = Command::new("sh").arg("-c").arg(script).current_dir(bench.folder.path()).assert().code(FILES);
    says(&err(&full), &["E0804", "too large"]);
    assert!(!bench.path("out").exists(), "{:?}", bench.names("out"));
}

#[test]
fn hostile_texts_are_answered() {
    let nested = |open: &str| format!("let a = {}\n", open.repeat(100_000));
    let texts: Vec<(&str, Vec<u8>, i32)> = vec![
        ("empty", Vec::new(), DONE),
        ("blank", b"\n\n  \n".to_vec(), DONE),
        ("byte order mark", format!("\u{feff}{SMALL}").into_bytes(), DONE),
        ("CRLF", SMALL.replace('\n', "\r\n").into_bytes(), DONE),
        ("no last line end", SMALL.trim_end().as_bytes().to_vec(), DONE),
        ("NUL", b"\0".to_vec(), ERRORS),
        ("a long line", vec![b'a'; 1_000_000], ERRORS),
        ("long lines of brackets", vec![b'{'; 1_000_000], ERRORS),
        ("nested tuples", nested("(").into_bytes(), ERRORS),
        ("nested lists", nested("[").into_bytes(), ERRORS),
        ("nested records", nested("disc { a: ").into_bytes(), ERRORS),
        ("nested minus", nested("-").into_bytes(), ERRORS),
        ("nested steps", format!("program p {{ {} }}\n", "together { ".repeat(100_000)).into_bytes(), ERRORS),
        ("a long sum", format!("let a = 1{}\n", " + 1".repeat(200_000)).into_bytes(), ERRORS),
        ("many quotes", vec![b'"'; 1_000_000], ERRORS),
        ("another kind of file", b"\x7fELF\x02\x01\x01\0\0\0\0\0\0\0\0\0".to_vec(), ERRORS),
    ];
    for (what, text, code) in texts {
        let bench = Bench::with(text);
        let mut command = bench.command(&["check", "a.twz"]);
        let answered = command.timeout(std::time::Duration::from_secs(60)).assert();
        assert_eq!(answered.get_output().status.code(), Some(code), "{what}: {}", err(&answered));
        assert!(err(&answered).len() < 200_000 && !err(&answered).contains("panicked"), "{what}");
    }
}

#[test]
fn numbers_out_of_range_are_errors() {
    let device = |field: &str| {
        format!("use std.dimibot\ndevice bot : dimibot.femto_st {{ {field} }}\ntask go on bot {{ move to (1, 1) }}\n")
    };
    for field in [
        "stroke: NaN",
        "stroke: inf um",
        "stroke: -inf um",
        "stroke: 1e999 um",
        "stroke: 1e-999 um",
        "stroke: -35 um",
        "stroke: 0 um",
        "stroke: 1/0 * 1 um",
        "stroke: (1e300 * 1e300) * 1 um",
        "stroke: sqrt(-1) * 1 um",
        "stroke: 1e30 um",
        "gain: 1e308",
        "left: 0",
        "left: 21",
        "left: -1",
        "left: 2.5",
        "left: 99999999999999999999",
        "left: 1e18",
        "rest: 1e20 s",
        "rest: 0.1 ns",
        "pulse_duration: 0 ms",
        "tip_radius: 1e9 um",
        "home: (4, 0)",
        "home: (-1, 0)",
        "home: (1e30, 0)",
        "home: 0b1",
    ] {
        let bench = Bench::with(device(field));
        let answered = bench.run(&["build", "a.twz", "-o", "out"]).code(ERRORS);
        says(&err(&answered), &["a.twz:2:"]);
        assert!(!bench.path("out").exists(), "{field}");
    }
    for target in
        ["(1e30, 0)", "(-1, 0)", "(0.5, 1)", "(1e30 um, 0 um)", "(-2 um, 0 um)", "0b1111111", "(1, 1, 1)", "1", "()"]
    {
        let bench = Bench::with(SMALL.replace("(1, 1)", target));
        bench.run(&["build", "a.twz"]).code(ERRORS);
    }
}

#[test]
fn json_lines_parse() {
    let bench = Bench::with(format!("let unused = 3 um\n{}", SMALL.replace("(1, 1)", "(9 V, \"µ\\n\")")));
    let failed = bench.run(&["build", "a.twz", "--format", "json"]).code(ERRORS);
    let lines: Vec<serde_json::Value> =
        err(&failed).lines().map(|line| serde_json::from_str(line).unwrap_or_else(|e| panic!("{e}: {line}"))).collect();
    assert!(!lines.is_empty());
    for line in &lines {
        let code = line["code"].as_str().unwrap_or_default();
        assert!(code.len() == 5 && code.starts_with(['E', 'W']), "{line}");
        assert!(line["title"].is_string() && matches!(line["severity"].as_str(), Some("error" | "warning")), "{line}");
        for place in [line, &line["labels"][0]] {
            assert!(place["line"].as_u64() > Some(0) && place["column"].as_u64() > Some(0), "{line}");
        }
    }
    let missing = err(&bench.run(&["build", "missing.twz", "--format", "json"]).code(FILES));
    assert_eq!(serde_json::from_str::<serde_json::Value>(&missing).expect("one line")["code"], "E0801");
}

#[test]
fn a_pipe_gets_no_escapes_and_a_narrow_terminal_narrow_reports() {
    let bench = Bench::with(SMALL.replace("(1, 1)", "(99, 1)"));
    let wide = bench.run(&["build", "a.twz"]);
    let narrow = bench.command(&["build", "a.twz"]).env("COLUMNS", "44").env("NO_COLOR", "1").assert();
    let silly = bench.command(&["build", "a.twz"]).env("COLUMNS", "0").assert();
    for text in [err(&wide), err(&narrow), err(&silly)] {
        assert!(!text.contains('\x1b') && text.contains("E0501"), "{text}");
    }
    // A title is on one line, which the terminal wraps.
    let help = |text: &str| -> usize {
        let drawn = |l: &&str| !l.contains(['│', '·', '╰']) && !l.starts_with("error[");
        text.lines().filter(drawn).map(|l| l.chars().count()).max().unwrap_or(0)
    };
    assert!(help(&err(&narrow)) <= 44 && help(&err(&wide)) > 44, "{}", err(&narrow));
    let dumb = bench.command(&["build", "a.twz"]).env("TERM", "dumb").assert();
    assert!(err(&dumb).is_ascii(), "{}", err(&dumb));
}

#[test]
fn a_reader_that_goes_away_is_no_error() {
    let bench = Bench::with(SMALL);
    for arguments in
        [&["explain"][..], &["devices", "dimibot"], &["completions", "bash"], &["build", "a.twz"], &["--help"]]
    {
        let mut child = Plain::new(env!("CARGO_BIN_EXE_tweeze"))
            .current_dir(bench.folder.path())
            .args(arguments)
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .expect("the program starts");
        drop(child.stdout.take());
        let ended = child.wait_with_output().expect("the program ends");
        assert_eq!((ended.status.code(), ended.stderr.as_slice()), (Some(DONE), &b""[..]), "{arguments:?}");
    }
}

#[cfg(target_os = "linux")]
#[test]
fn a_report_that_cannot_be_written_is_an_error() {
    let bench = Bench::with(SMALL);
    let full = fs::OpenOptions::new().write(true).open("/dev/full");
    let Ok(full) = full else { return println!("SKIPPED: there is no /dev/full") };
    let status = Plain::new(env!("CARGO_BIN_EXE_tweeze"))
        .current_dir(bench.folder.path())
        .args(["devices", "dimibot"])
        .stdout(full)
        .status()
        .expect("the program starts");
    assert_eq!(status.code(), Some(FILES));
}

#[test]
fn logs_that_are_damaged_or_of_another_program_are_refused() {
    let bench = Bench::with(SMALL);
    bench.run(&["build", "a.twz"]).code(DONE);
    let log = fs::read(bench.path("go.mcap")).expect("the log");
    for keep in [0, 1, 7, 8, 100, log.len() / 2, log.len() - 1] {
        fs::write(bench.path("cut.mcap"), &log[..keep]).expect("written");
        let cut = bench.run(&["verify", "cut.mcap"]).code(FILES);
        assert!(err(&cut).contains("E08"), "{keep}: {}", err(&cut));
    }
    for at in (0..log.len()).step_by(log.len() / 60) {
        let mut changed = log.clone();
        changed[at] ^= 0x10;
        fs::write(bench.path("changed.mcap"), &changed).expect("written");
        let answered = bench.run(&["verify", "changed.mcap"]);
        let code = answered.get_output().status.code();
        assert!(matches!(code, Some(REFUSED | FILES)), "byte {at}: {code:?} {}", err(&answered));
    }
    fs::write(bench.path("b.twz"), SMALL.replace("(1, 1)", "(1, 2)")).expect("written");
    says(&err(&bench.run(&["verify", "go.mcap", "--against", "b.twz"]).code(REFUSED)), &["E07"]);
    bench.run(&["verify", "go.mcap", "--against", "missing.twz"]).code(FILES);
    says(&err(&bench.run(&["verify", "a.twz"]).code(FILES)), &["E0840", "`tweeze verify` reads the `.mcap` file"]);
}

#[test]
fn a_suggested_table_is_a_program_that_checks_and_tells_its_states() {
    let bench = Bench::new();
    let wanted = ["devices", "--suggest", "microrobots", "--robots", "6", "--margin", "4V", "--max", "200V"];
    let table = out(&bench.run(&wanted).code(DONE));
    fs::write(bench.path("a.twz"), &table).expect("a program is written");
    let reported = out(&bench.run(&["devices", "a.twz"]).code(DONE));
    says(&reported, &["bed: microrobots, 6 robots", "D6", "slack"]);
    assert_eq!(reported.lines().filter(|line| line.ends_with(" V")).count(), 6 + 1 + 1, "{reported}");
    let many = ["devices", "--suggest", "microrobots", "--robots", "60", "--margin", "4V", "--max", "200V"];
    says(&err(&bench.run(&many).code(ERRORS)), &["60 robots do not fit", "at most "]);
    bench.run(&["devices", "--robots", "6"]).code(USAGE);
}

#[test]
fn a_simulation_is_the_same_for_the_same_seed() {
    let bench = Bench::new();
    // The most reliable plan is not the subject here and takes long to find.
    let four = fs::read_to_string(example("microrobots_four.twz")).expect("an example");
    fs::write(bench.path("four.twz"), four.replace("  minimize failures\n", "")).expect("written");
    let simulated =
        |seed: &str| out(&bench.run(&["simulate", "four.twz", "--trials", "100", "--seed", seed]).code(DONE));
    let reported = simulated("7");
    says(&reported, &["of 100 trials succeeded", "95 % confidence (seed 7)", "area of the goal", "D1", "incidence"]);
    assert_eq!(reported, simulated("7"));
    assert_ne!(reported, simulated("8"));
    let fetch = example("dimibot_fetch.twz");
    says(&err(&bench.run(&["simulate", &fetch.to_string_lossy()]).code(USAGE)), &["nothing to simulate"]);
}
