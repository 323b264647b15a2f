//! `tweeze fmt` from the user's side.

use assert_cmd::Command;
use assert_cmd::assert::Assert;
use std::fs;
use tempfile::TempDir;

const LOOSE: &str = "let  a=1 um\nlet b = 2 um\n";
const TIDY: &str = "let a = 1 um\nlet b = 2 um\n";
const BROKEN: &str = "let  a=1 um\nlet b = = 2 um\n";

fn bench(files: &[(&str, &str)]) -> TempDir {
    let bench = tempfile::tempdir().expect("a folder for the test");
    for (name, text) in files {
        let path = bench.path().join(name);
        fs::create_dir_all(path.parent().expect("it lies in the folder")).expect("a folder is made");
        fs::write(path, text).expect("a program is written");
    }
    bench
}

fn fmt(bench: &TempDir, arguments: &[&str], input: &str) -> Assert {
    let mut command = Command::new(env!("CARGO_BIN_EXE_tweeze"));
    command.current_dir(bench.path()).arg("fmt").args(arguments).write_stdin(input).assert()
}

fn out(assert: &Assert) -> String {
    String::from_utf8_lossy(&assert.get_output().stdout).into_owned()
}

fn err(assert: &Assert) -> String {
    String::from_utf8_lossy(&assert.get_output().stderr).into_owned()
}

fn read(bench: &TempDir, name: &str) -> String {
    fs::read_to_string(bench.path().join(name)).expect("it is there")
}

#[test]
fn files_are_rewritten_in_place() {
    let bench =
        bench(&[("a.twz", LOOSE), ("b.twz", TIDY), ("sub/c.twz", LOOSE), ("sub/c.txt", LOOSE), (".git/d.twz", LOOSE)]);
    let before = fs::metadata(bench.path().join("b.twz")).and_then(|data| data.modified()).expect("a time");
    let done = fmt(&bench, &["."], "").code(0);
    assert_eq!(out(&done), "Formatted  ./a.twz\nFormatted  ./sub/c.twz\n");
    assert_eq!(err(&done), "");
    assert_eq!([read(&bench, "a.twz"), read(&bench, "sub/c.twz")], [TIDY, TIDY]);
    assert_eq!([read(&bench, "sub/c.txt"), read(&bench, ".git/d.twz")], [LOOSE, LOOSE]);
    let after = fs::metadata(bench.path().join("b.twz")).and_then(|data| data.modified()).expect("a time");
    assert_eq!(before, after, "a canonical file is not touched");
    assert_eq!(out(&fmt(&bench, &["a.twz", "b.twz"], "").code(0)), "");
    let names: Vec<_> =
        fs::read_dir(bench.path()).expect("it can be listed").flatten().map(|e| e.file_name()).collect();
    assert_eq!(names.len(), 4, "{names:?}");
}

#[test]
fn standard_input_becomes_standard_output() {
    let bench = bench(&[]);
    assert_eq!(out(&fmt(&bench, &["-"], LOOSE).code(0)), TIDY);
    assert_eq!(out(&fmt(&bench, &["-"], TIDY).code(0)), TIDY);
    assert_eq!(out(&fmt(&bench, &["--check", "-"], LOOSE).code(1)), "<stdin>\n");
}

#[test]
fn check_and_diff_write_nothing() {
    let bench = bench(&[("a.twz", LOOSE), ("b.twz", TIDY)]);
    assert_eq!(out(&fmt(&bench, &["--check", "a.twz", "b.twz"], "").code(1)), "a.twz\n");
    assert_eq!(out(&fmt(&bench, &["--check", "b.twz"], "").code(0)), "");
    let diff = "--- a.twz\n+++ a.twz (canonical)\n@@ -1,2 +1,2 @@\n-let  a=1 um\n+let a = 1 um\n let b = 2 um\n";
    assert_eq!(out(&fmt(&bench, &["--diff", "a.twz", "b.twz"], "").code(0)), diff);
    assert_eq!(out(&fmt(&bench, &["--diff", "--check", "a.twz"], "").code(1)), diff);
    assert_eq!(read(&bench, "a.twz"), LOOSE);
}

#[test]
fn errors_are_reported_and_the_rest_is_formatted() {
    let bench = bench(&[("a.twz", BROKEN)]);
    let failed = fmt(&bench, &["a.twz", "gone.twz"], "").code(4);
    assert!(err(&failed).contains("a.twz:2:") && err(&failed).contains("cannot read `gone.twz`"), "{}", err(&failed));
    assert_eq!(read(&bench, "a.twz"), "let a = 1 um\nlet b = = 2 um\n");
    let failed = fmt(&bench, &["a.twz", "--format", "json"], "").code(1);
    assert!(err(&failed).starts_with('{') && out(&failed).is_empty(), "{}", err(&failed));
    fmt(&bench, &["."], "").code(1);
    fs::write(bench.path().join("a.twz"), LOOSE).expect("it can be written");
    let json = |arguments: &[&str]| out(&fmt(&bench, arguments, ""));
    assert_eq!(json(&["--check", "a.twz", "--format", "json"]), "{\"not_canonical\":\"a.twz\"}\n");
    assert_eq!(json(&["a.twz", "--format", "json"]), "{\"formatted\":\"a.twz\"}\n");
    fs::remove_file(bench.path().join("a.twz")).expect("it is there");
    let empty = fmt(&bench, &["."], "").code(4);
    assert!(err(&empty).contains("contains no `.twz` file"), "{}", err(&empty));
}

#[test]
fn without_a_file_it_says_how_it_is_used() {
    let failed = fmt(&bench(&[]), &[], "").code(2);
    assert!(err(&failed).contains("tweeze fmt") && err(&failed).contains("<FILE|DIR|->"), "{}", err(&failed));
}

#[cfg(unix)]
#[test]
fn permissions_and_links_stay() {
    use std::os::unix::fs::{PermissionsExt, symlink};
    let bench = bench(&[("a.twz", LOOSE), ("fixed.twz", LOOSE)]);
    let mode = |name: &str| fs::metadata(bench.path().join(name)).expect("it is there").permissions().mode() & 0o777;
    let set = |name: &str, mode| {
        fs::set_permissions(bench.path().join(name), fs::Permissions::from_mode(mode)).expect("it can be set");
    };
    set("a.twz", 0o640);
    symlink("a.twz", bench.path().join("link.twz")).expect("a link is made");
    fmt(&bench, &["link.twz"], "").code(0);
    assert_eq!((read(&bench, "a.twz").as_str(), mode("a.twz")), (TIDY, 0o640));
    assert!(fs::symlink_metadata(bench.path().join("link.twz")).expect("it is there").is_symlink());
    set("fixed.twz", 0o444);
    let refused = fmt(&bench, &["fixed.twz"], "").code(4);
    assert!(err(&refused).contains("it is read-only"), "{}", err(&refused));
    assert_eq!(read(&bench, "fixed.twz"), LOOSE);
}
