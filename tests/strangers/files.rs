//! Files that a build finds in its folder, and files that it leaves there. Kills are tested with the commit, in
//! `cli/disk`.

use super::bench::{Bench, DONE, FILES, says};
use std::fs;

const ONE: &str = "use std.dimibot\ndevice bot : dimibot.femto_st\ntask go on bot { move to (1, 1) }\n";
const OTHER: &str = "use std.dimibot\ndevice bot : dimibot.femto_st\ntask go on bot { move to (2, 1) }\n";

#[test]
fn files_of_another_program_are_not_replaced_in_silence() {
    let bench = Bench::new();
    bench.write("one.twz", ONE).write("other.twz", OTHER);
    bench.run(&["build", "one.twz", "--emit", "mcap,csv"]).code(DONE);
    let before = fs::read(bench.path("go.csv")).expect("written");
    for format in ["mcap", "csv"] {
        let refused = bench.run(&["build", "other.twz", "--emit", format]).code(FILES);
        says(&refused.err, &["E0806", "was built from another program, `one.twz`", "--force", "-o DIR"]);
    }
    assert_eq!(fs::read(bench.path("go.csv")).expect("still there"), before);
    // The same program, edited or not, may replace its own files.
    bench.write("one.twz", format!("{ONE}\n// edited\n"));
    bench.run(&["build", "one.twz", "--emit", "mcap,csv"]).code(DONE);
    bench.run(&["build", "other.twz", "--emit", "mcap,csv", "--force"]).code(DONE);
    says(&bench.run(&["build", "one.twz"]).code(FILES).err, &["`other.twz`"]);
    bench.run(&["build", "one.twz", "-o", "elsewhere"]).code(DONE);
    // A deleted file belongs to no program.
    for file in ["go.mcap", "go.lichtblick.json"] {
        fs::remove_file(bench.path(file)).expect("removed");
    }
    bench.run(&["build", "one.twz"]).code(DONE);
}

#[test]
fn what_a_build_reads_is_never_replaced() {
    let bench = Bench::new();
    let map = r#"{"layout": {"grid": [[1, 2, 3], [4, 5, 6], [7, 8, 9]]}}"#;
    bench.write("grid.json", map).write(
        "board.twz",
        "use std.electrode_array as ea\ndevice chip : ea.droplet_chip { map: \"grid.json\" }\n\
         scene lab { part a : ea.droplet at (1, 1) }\ntask grid on chip in lab { move a to (3, 3) }\n",
    );
    for force in [&[][..], &["--force"]] {
        let refused = bench.run(&[&["build", "board.twz", "--emit", "json"], force].concat()).code(FILES);
        says(&refused.err, &["E0809", "`grid.json`", "-o DIR"]);
    }
    assert_eq!(fs::read_to_string(bench.path("grid.json")).expect("still there"), map);
    // A file that it has not read may be replaced.
    bench.run(&["build", "board.twz", "--emit", "svg"]).code(DONE);
    bench.run(&["build", "board.twz", "--emit", "json", "-o", "out"]).code(DONE);
}

#[test]
fn a_folder_that_is_moved_with_its_program_stays_its_own() {
    let bench = Bench::new();
    fs::create_dir(bench.path("here")).expect("a folder");
    bench.write("here/one.twz", ONE);
    bench.run(&["build", "here/one.twz", "-o", "here/out"]).code(DONE);
    fs::rename(bench.path("here"), bench.path("there")).expect("moved");
    bench.run(&["build", "there/one.twz", "-o", "there/out"]).code(DONE);
}

#[test]
fn leftovers_of_builds_that_were_killed_are_cleared() {
    let bench = Bench::new();
    bench.write("one.twz", ONE).write(".tweeze-new-0", "half").write(".tweeze-draft", "half");
    bench.run(&["build", "one.twz"]).code(DONE);
    assert_eq!(bench.names(), [".tweeze.json", "go.lichtblick.json", "go.mcap", "one.twz"]);
}

/// A journal that came with a folder from elsewhere is not carried out, neither by a build nor by `verify`, which reads
/// logs of strangers.
#[cfg(unix)]
#[test]
fn a_journal_from_elsewhere_changes_nothing() {
    let bench = Bench::new();
    bench.write("one.twz", ONE);
    bench.run(&["build", "one.twz"]).code(DONE);
    bench.write("a.csv", "mine").write(".tweeze-new-0", "new");
    let journal =
        r#"{"moves":[{"from":".tweeze-new-0","to":"a.csv","number":7}],"remove":[{"name":"one.twz","number":7}]}"#;
    bench.write(".tweeze-journal", journal);
    for arguments in [&["verify", "go.mcap"], &["build", "one.twz"]] {
        let refused = bench.run(arguments).code(FILES);
        says(
            &refused.err,
            &["E0808", "the journal does not belong to a build into this folder", "delete `.tweeze-journal`"],
        );
        assert_eq!(fs::read_to_string(bench.path("a.csv")).expect("there"), "mine");
        assert!(bench.path("one.twz").exists());
    }
    fs::remove_file(bench.path(".tweeze-journal")).expect("removed");
    bench.run(&["verify", "go.mcap"]).code(DONE);
    bench.run(&["build", "one.twz"]).code(DONE);
    assert_eq!(bench.names(), [".tweeze.json", "a.csv", "go.lichtblick.json", "go.mcap", "one.twz"]);
}

/// Concurrent builds wait for one another, so that each set is of one build.
#[test]
fn builds_at_once_leave_whole_sets() {
    let bench = Bench::new();
    bench.write("one.twz", ONE).write("other.twz", OTHER);
    let arguments = |program| ["build", program, "--emit", "mcap,csv,json,vcd", "--force"];
    bench.run(&arguments("one.twz")).code(DONE);
    let read = || ["mcap", "csv", "json", "vcd"].map(|end| fs::read(bench.path(&format!("go.{end}"))).expect("there"));
    let one = read();
    bench.run(&arguments("other.twz")).code(DONE);
    let other = read();
    for _ in 0..5 {
        std::thread::scope(|scope| {
            for program in ["one.twz", "other.twz", "one.twz", "other.twz"] {
                let bench = &bench;
                scope.spawn(move || bench.run(&arguments(program)).code(DONE));
            }
        });
        let now = read();
        assert!(now == one || now == other);
    }
    assert_eq!(bench.names().len(), 9, "{:?}", bench.names());
}
