//! The rules of the house that can be executed.

use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};

/// The longest file of code, in lines.
const MAX_FILE_LINES: usize = 600;

/// The longest function, in lines.
const MAX_FUNCTION_LINES: usize = 70;

/// The rooms of `src`, and which others each may see.
const ROOMS: &[(&str, &[&str])] = &[
    ("source", &[]),
    ("quantity", &[]),
    ("geometry", &[]),
    ("stdlib", &[]),
    ("diagnostic", &["source"]),
    ("device", &["quantity", "geometry"]),
    ("syntax", &["source", "diagnostic", "quantity"]),
    ("check", &["source", "quantity", "geometry", "diagnostic", "device", "stdlib", "syntax"]),
    ("plan", &["source", "quantity", "geometry", "diagnostic", "device", "check"]),
    ("schedule", &["source", "diagnostic", "device", "check", "plan"]),
    ("verify", &["source", "quantity", "geometry", "diagnostic", "device", "check", "schedule"]),
    ("emit", &["source", "quantity", "geometry", "diagnostic", "device", "check", "schedule", "verify"]),
    ("compile", &["source", "diagnostic", "check", "plan", "schedule", "verify"]),
];

/// The stages that hold a file or a folder for each kind.
const KIND_STAGES: &[&str] = &["device", "check", "plan", "schedule", "verify"];

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

fn files(folder: &Path, ending: &str, found: &mut Vec<PathBuf>) {
    let entries = fs::read_dir(folder).unwrap_or_else(|error| panic!("{}: {error}", folder.display()));
    let mut paths: Vec<PathBuf> = entries.map(|entry| entry.expect("a readable entry").path()).collect();
    paths.sort();
    for path in paths {
        if path.is_dir() {
            files(&path, ending, found);
        } else if path.extension().is_some_and(|own| own == ending) {
            found.push(path);
        }
    }
}

fn code(folder: &str) -> Vec<(PathBuf, String)> {
    let mut found = Vec::new();
    files(&root().join(folder), "rs", &mut found);
    assert!(!found.is_empty(), "{folder} holds no code");
    found.into_iter().map(|path| (path.clone(), fs::read_to_string(&path).expect("readable code"))).collect()
}

fn is_test(path: &Path) -> bool {
    path.components().any(|part| part.as_os_str().to_string_lossy().starts_with("tests"))
        || path.file_name().is_some_and(|name| name == "fixture.rs")
}

/// The code of a file without its tests.
fn without_tests(text: &str) -> &str {
    text.split("#[cfg(test)]\nmod tests {").next().unwrap_or(text)
}

/// The room of a file: the first part of its path below `src`.
fn room(path: &Path) -> String {
    let below = path.strip_prefix(root().join("src")).expect("a path below src");
    let first = below.components().next().expect("a file").as_os_str().to_string_lossy().into_owned();
    first.trim_end_matches(".rs").to_owned()
}

/// The rooms that a file names by `crate::`, in `use` and elsewhere.
fn seen_rooms(text: &str) -> BTreeSet<String> {
    let mut seen = BTreeSet::new();
    for piece in text.split("crate::").skip(1) {
        if let Some(group) = piece.strip_prefix('{') {
            let group = group.split('}').next().unwrap_or_default();
            let names = group.split(',').map(|name| name.trim().split("::").next().unwrap_or_default());
            seen.extend(names.filter(|name| !name.is_empty()).map(str::to_owned));
        } else {
            let name: String = piece.chars().take_while(|c| c.is_alphanumeric() || *c == '_').collect();
            seen.insert(name);
        }
    }
    seen
}

#[test]
fn rooms_see_only_whom_they_may() {
    for (path, text) in code("src") {
        let own = room(&path);
        if is_test(&path) || ["main", "lib", "cli"].contains(&own.as_str()) {
            continue;
        }
        let (_, may) = ROOMS.iter().find(|(name, _)| *name == own).unwrap_or_else(|| panic!("no rule for room {own}"));
        for seen in seen_rooms(without_tests(&text)) {
            assert!(seen == own || may.contains(&seen.as_str()), "{} sees `{seen}`", path.display());
        }
    }
}

#[test]
fn the_reader_of_rooms_finds_groups_and_paths() {
    let seen = seen_rooms("use crate::{plan, check::Options};\nfn f() { crate::emit::write() }");
    assert_eq!(seen.into_iter().collect::<Vec<_>>(), ["check", "emit", "plan"]);
}

#[test]
fn files_and_functions_stay_short() {
    for (path, text) in code("src") {
        let lines = text.lines().count();
        assert!(lines <= MAX_FILE_LINES, "{} has {lines} lines", path.display());
        for (name, length) in functions(&text) {
            assert!(length <= MAX_FUNCTION_LINES, "{}: fn {name} has {length} lines", path.display());
        }
    }
}

/// The functions of a formatted file with their lines: from `fn` to the closing brace of the same indentation.
fn functions(text: &str) -> Vec<(String, usize)> {
    let lines: Vec<&str> = text.lines().collect();
    let mut found = Vec::new();
    for (start, line) in lines.iter().enumerate() {
        let trimmed = line.trim_start();
        let head = ["pub ", "pub(crate) ", "pub(super) ", "const "]
            .iter()
            .fold(trimmed, |rest, word| rest.trim_start_matches(word));
        let Some(name) = head.strip_prefix("fn ") else { continue };
        let indent = line.len() - trimmed.len();
        let closing = format!("{}}}", " ".repeat(indent));
        let length = lines[start..].iter().position(|line| *line == closing).map_or(1, |end| end + 1);
        found.push((name.split(['(', '<']).next().unwrap_or_default().to_owned(), length));
    }
    found
}

#[test]
fn nothing_is_left_open() {
    // Put together here, so that this file does not find itself.
    let open = ["todo", "unimplemented", "dbg"].map(|word| format!("{word}!("));
    let marks = ["FIX", "TO"].map(|word| format!("{word}{}", if word == "FIX" { "ME" } else { "DO" }));
    for (path, text) in code("src").into_iter().chain(code("tests")).chain(code("benches")) {
        for word in open.iter().chain(&marks) {
            assert!(!text.contains(word.as_str()), "{} holds `{word}`", path.display());
        }
        assert!(path.file_name().is_some_and(|name| name != "utils.rs" && name != "helpers.rs"), "{}", path.display());
    }
}

#[test]
fn every_module_says_what_it_is() {
    for (path, text) in code("src") {
        assert!(is_test(&path) || text.starts_with("//! "), "{} begins without its doc", path.display());
    }
}

#[test]
fn each_kind_has_its_file_in_every_stage() {
    for kind in tweeze::device::Kind::ALL {
        for stage in KIND_STAGES {
            let place = root().join("src").join(stage).join(kind.name());
            assert!(place.is_dir() || place.with_extension("rs").is_file(), "{stage} knows no {}", kind.name());
        }
        let library = root().join("stdlib").join(kind.name()).with_extension("twz");
        assert!(library.is_file(), "no {}", library.display());
        let examples = fs::read_dir(root().join("examples")).expect("the examples");
        let own = examples.flatten().filter(|entry| entry.file_name().to_string_lossy().starts_with(kind.name()));
        assert!(own.count() > 0, "no example of a {}", kind.name());
    }
}

#[test]
fn only_the_command_line_touches_files_clock_and_terminal() {
    let outside = ["std::fs", "std::env", "std::time", "println!", "eprintln!", "std::net", "std::process"];
    for (path, text) in code("src") {
        if is_test(&path) || ["main", "cli"].contains(&room(&path).as_str()) {
            continue;
        }
        for word in outside {
            assert!(!without_tests(&text).contains(word), "{} holds `{word}`", path.display());
        }
    }
}

#[test]
fn no_path_of_a_machine_is_in_the_project() {
    let mut found = Vec::new();
    for folder in ["src", "tests", "docs", "examples", "stdlib", "grammar", "schema", "benches", ".ci"] {
        for ending in ["rs", "md", "twz", "pest", "json", "py", "txt", "run"] {
            files(&root().join(folder), ending, &mut found);
        }
    }
    let homes = ["home", "root", "work"].map(|folder| format!("/{folder}/"));
    for path in found {
        let text = fs::read(&path).unwrap_or_default();
        let text = String::from_utf8_lossy(&text);
        for home in &homes {
            assert!(!text.contains(home.as_str()), "{} holds `{home}`", path.display());
        }
    }
}
