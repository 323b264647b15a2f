//! House rules, checked on the project's own files.

#[path = "tidy/circles.rs"]
mod circles;
#[path = "tidy/generators.rs"]
mod generators;
#[path = "tidy/parameters.rs"]
mod parameters;
#[path = "tidy/rooms.rs"]
mod rooms;

use rooms::{BASE, SIGHT, room, seen_rooms};
use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};
use std::process::Command;

/// The longest file, in lines.
const MAX_FILE_LINES: usize = 600;

/// The kinds of device; each has the same file name in every stage.
const KINDS: [&str; 4] = ["dimibot", "electrode_array", "fingers", "microrobots"];

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

/// Every file with an extension under a folder, as its path from the root and its text, by path.
fn files(folder: &str, ending: &str) -> Vec<(String, String)> {
    let mut found = Vec::new();
    let mut open = vec![root().join(folder)];
    while let Some(folder) = open.pop() {
        for entry in std::fs::read_dir(&folder).into_iter().flatten().flatten() {
            let path = entry.path();
            if path.is_dir() {
                open.push(path);
            } else if path.extension().is_some_and(|other| other == ending) {
                let text = std::fs::read_to_string(&path).unwrap_or_else(|error| panic!("{}: {error}", path.display()));
                found.push((from_root(&path), text));
            }
        }
    }
    found.sort();
    found
}

fn from_root(path: &Path) -> String {
    path.strip_prefix(root()).unwrap_or(path).to_string_lossy().replace('\\', "/")
}

fn sources() -> Vec<(String, String)> {
    files("src", "rs")
}

/// All Rust files of the project.
fn rust() -> Vec<(String, String)> {
    ["src", "tests", "benches", "fuzz"]
        .iter()
        .flat_map(|folder| files(folder, "rs"))
        .filter(|f| !f.0.contains("/target/"))
        .collect()
}

/// A text without comments and without the content of strings.
fn code(text: &str) -> String {
    let mut lines = Vec::new();
    let mut goes_on = false;
    for line in text.lines() {
        let mut kept = String::new();
        let (mut quoted, mut escaped) = (goes_on, false);
        for (at, c) in line.char_indices() {
            if !quoted && line[at..].starts_with("//") {
                break;
            }
            let is_quote = c == '"' && !escaped && !line[..at].ends_with('\'');
            escaped = quoted && c == '\\' && !escaped;
            if is_quote {
                quoted = !quoted;
            }
            if !quoted || is_quote {
                kept.push(c);
            }
        }
        // After a `\` a string continues on the next line.
        goes_on = quoted && line.ends_with('\\');
        lines.push(kept);
    }
    lines.join("\n")
}

/// The code of a file without its tests.
fn without_tests(text: &str) -> String {
    let code = code(text);
    code.split("\n#[cfg(test)]\nmod tests {").next().unwrap_or_default().to_owned()
}

fn is_test_file(path: &str) -> bool {
    path.contains("/tests/") || path.ends_with("/tests.rs") || path.ends_with("/fixture.rs")
}

/// Everything in `geometry` that the verifier names: the types that claims are written in, the greatest coordinate, and
/// the switch that injects faults for tests. None of it measures anything.
const SEEN_OF_GEOMETRY: [&str; 9] =
    ["Fault", "MAX_EXTENT_UM", "Outline", "Pose", "Shape", "fault", "inject", "outline", "shape"];

/// Functions of `device` that both planners and the verifier call, and why a fault in them could not deceive both.
const SHARED: &[(&str, &str)] = &[
    ("apart", "the figure of a separation, or the one that stands for the published table"),
    ("axes", "the unit vectors of a hand's two planes"),
    ("normal", "the unit vectors across them"),
    ("digit", "what stands for an arm in words and states: 0 or 1"),
    ("watchdog_ns", "a figure of the device, or five of its intervals where it states none"),
    ("sign", "how a relation is written, for messages"),
    ("outcome", "names of the vocabulary: what `require` compares"),
    ("dimension", "whether an outcome is a length, a time or a count"),
];

/// Names that the standard types have too, or that do not show whose they are; and `quantity::digits`.
const COMMON: &[&str] = &["contains", "digits", "find", "key", "name", "new", "of", "round", "vocabulary"];

/// All code of a room, without tests.
fn room_code(wanted: &str) -> String {
    let files = sources().into_iter().filter(|(path, _)| room(path) == wanted && !is_test_file(path));
    files.map(|(_, text)| without_tests(&text)).collect::<Vec<_>>().join("\n")
}

fn calls(code: &str, name: &str) -> bool {
    let is_word = |c: char| c.is_alphanumeric() || c == '_';
    code.match_indices(&format!("{name}(")).any(|(at, _)| !code[..at].ends_with(is_word))
}

/// The names of the visible functions that a text declares, including `const` ones.
fn open_functions(code: &str) -> BTreeSet<String> {
    let word = |rest: &str| rest.chars().take_while(|c| c.is_alphanumeric() || *c == '_').collect::<String>();
    let heads = code.lines().filter_map(|line| {
        let line = line.trim_start();
        let rest = line.strip_prefix("pub(crate) ").or_else(|| line.strip_prefix("pub "))?;
        rest.strip_prefix("const ").unwrap_or(rest).strip_prefix("fn ")
    });
    heads.map(word).collect()
}

/// The names that a text uses from a room of the crate, also in groups.
fn named_of(code: &str, room: &str) -> BTreeSet<String> {
    let mark = format!("crate::{room}::");
    let ends = |c: char| !(c.is_alphanumeric() || "_:{}, \n".contains(c));
    let of_path = |(at, _): (usize, &str)| {
        let rest = &code[at + mark.len()..];
        let path = rest.split(ends).next().unwrap_or_default();
        // Without a group, a path ends at the next word.
        let path = if path.contains('{') { path } else { path.split(' ').next().unwrap_or_default() };
        path.split(|c: char| !(c.is_alphanumeric() || c == '_')).map(str::to_owned).collect::<Vec<_>>()
    };
    code.match_indices(&mark).flat_map(of_path).filter(|word| !word.is_empty()).collect()
}

/// An error in a measure shared by planners and the verifier would deceive both, so the verifier has its own measures.
#[test]
fn the_verifier_measures_by_itself() {
    let verify = room_code("verify");
    let seen = named_of(&verify, "geometry");
    assert_eq!(seen, SEEN_OF_GEOMETRY.map(str::to_owned).into(), "what the verifier names of `geometry`");
    let own: BTreeSet<String> =
        verify.match_indices("fn ").map(|(at, _)| word_at(&verify[at + "fn ".len()..])).collect();
    let called: Vec<String> = open_functions(&room_code("geometry"))
        .into_iter()
        .filter(|name| calls(&verify, name) && !own.contains(name) && !COMMON.contains(&name.as_str()))
        .collect();
    // `Plane::normal` of `device` has the same name.
    assert_eq!(called, ["inject", "normal"], "what the verifier calls of `geometry`");
    assert_eq!(
        named_of("use crate::a::{b::C, d};\nx(crate::a::e::f(1), y)\nuse crate::ab::c;", "a"),
        ["C", "b", "d", "e", "f"].map(str::to_owned).into()
    );
}

fn word_at(text: &str) -> String {
    text.chars().take_while(|c| c.is_alphanumeric() || *c == '_').collect()
}

/// Functions that the verifier also declares itself are exempt unless listed. Whether a fault in its own copy is
/// noticed is tested by the verifier's tests, which inject faults.
#[test]
fn what_planners_and_verifier_share_is_listed() {
    let (plan, verify) = (room_code("plan"), room_code("verify"));
    let own: BTreeSet<String> =
        verify.match_indices("fn ").map(|(at, _)| word_at(&verify[at + "fn ".len()..])).collect();
    let open = open_functions(&room_code("device"));
    let both: BTreeSet<String> = open.into_iter().filter(|name| calls(&plan, name) && calls(&verify, name)).collect();
    let listed: BTreeSet<String> = SHARED.iter().map(|(name, _)| (*name).to_owned()).collect();
    let unlisted: Vec<_> =
        both.iter().filter(|n| !listed.contains(*n) && !own.contains(*n) && !COMMON.contains(&n.as_str())).collect();
    assert!(unlisted.is_empty(), "planners and verifier share {unlisted:?}: say in `SHARED` why that deceives nobody");
    let gone: Vec<_> = listed.difference(&both).collect();
    assert!(gone.is_empty(), "{gone:?} are shared no more");
    assert!(calls("a.b(c)", "b") && !calls("ab(c)", "b"));
    assert_eq!(open_functions("pub fn a() {}\n    pub const fn b()\nfn c()"), ["a", "b"].map(str::to_owned).into());
}

#[test]
fn every_room_is_known_to_these_rules() {
    for (path, _) in sources() {
        let room = room(&path);
        let known =
            BASE.contains(&room) || SIGHT.iter().any(|(name, _)| *name == room) || matches!(room, "lib" | "main");
        assert!(known, "{path} lies in a room that `SIGHT` does not know");
    }
}

/// Only `verify` can make a `Verified`, and only without access to the planner.
#[test]
fn the_ticket_is_made_in_one_place() {
    for (path, text) in sources().into_iter().filter(|(path, _)| !is_test_file(path)) {
        let code = without_tests(&text);
        let makes = code.match_indices("Verified {").any(|(at, _)| {
            let before = code[..at].trim_end();
            !before.ends_with("struct")
                && !before.ends_with("impl")
                && !before.ends_with("->")
                && !before.ends_with("for")
        });
        assert!(!makes || path == "src/verify/mod.rs", "{path} makes a `Verified`");
    }
}

#[test]
fn files_are_not_long() {
    for (path, text) in rust() {
        assert!(text.lines().count() <= MAX_FILE_LINES, "{path} has {} lines", text.lines().count());
        assert!(!path.ends_with("utils.rs") && !path.ends_with("util.rs") && !path.ends_with("helpers.rs"), "{path}");
    }
}

#[test]
fn every_file_says_what_it_is() {
    for (path, text) in rust() {
        let is_part = path.contains("/tests/") || path.contains("/tests.rs");
        assert!(text.starts_with("//!") || is_part, "{path} does not begin with `//!`");
    }
    for stage in BASE.into_iter().chain(SIGHT.iter().map(|stage| stage.0)) {
        let place = [format!("src/{stage}/mod.rs"), format!("src/{stage}.rs")];
        let found = place.iter().any(|path| root().join(path).exists());
        assert!(found, "`{stage}` has no file of its own");
    }
}

#[test]
fn a_kind_has_the_same_name_in_every_stage() {
    for kind in KINDS {
        for stage in ["device", "claims", "check", "plan", "schedule", "lower", "verify", "emit", "cli/report"] {
            let file = root().join(format!("src/{stage}/{kind}.rs"));
            let folder = root().join(format!("src/{stage}/{kind}/mod.rs"));
            assert!(file.exists() || folder.exists(), "`{stage}` has nothing named `{kind}`");
        }
        assert!(root().join(format!("stdlib/{kind}.twz")).exists());
        let stories = files("examples", "twz");
        assert!(stories.iter().any(|(path, _)| path.starts_with(&format!("examples/{kind}_"))), "no example of {kind}");
    }
    let listed = std::fs::read_to_string(root().join("src/device/mod.rs")).unwrap_or_default();
    let others = ["shape", "instrument"].len();
    assert_eq!(listed.matches("pub mod ").count() - others, KINDS.len(), "a kind is missing in `KINDS`");
}

/// Limits on what a kind may cost outside its own files: shared files that name it in code, and lines in them.
const MAX_SHARED_FILES: usize = 10;
const MAX_SHARED_LINES: usize = 15;

/// Extra files and lines of a kind for features that no other kind has.
const OWN_OFFERS: &[(&str, [usize; 2])] = &[
    // It is simulated and controlled, and voltage tables are suggested for it.
    ("microrobots", [1, 5]),
    // It has liquids to load, which a loading sheet lists.
    ("electrode_array", [1, 4]),
];

/// Number of lines of code in shared files that name a kind, by file: `dimibot` as a word, or a word that begins with
/// `Dimibot`. A file or folder with the kind's name is its own.
fn names_of_kind(kind: &str) -> BTreeMap<String, usize> {
    let is_of_word = |c: char| c.is_alphanumeric() || c == '_';
    let is_own = |path: &str| path.trim_end_matches(".rs").split('/').any(|part| KINDS.contains(&part));
    let variant: String = kind.split('_').map(|word| word[..1].to_uppercase() + &word[1..]).collect();
    let names = |line: &&str| line.split(|c| !is_of_word(c)).any(|word| word == kind || word.starts_with(&variant));
    let shared = sources().into_iter().filter(|(path, _)| !is_test_file(path) && !is_own(path));
    let counts = shared.map(|(path, text)| (path, without_tests(&text).lines().filter(names).count()));
    counts.filter(|(_, lines)| *lines > 0).collect()
}

/// The page on the cost of a fifth kind names every shared file that names a kind.
#[test]
fn shared_files_seldom_name_a_kind() {
    let mut all = BTreeSet::new();
    for kind in KINDS {
        let counts = names_of_kind(kind);
        let (files, lines) = (counts.len(), counts.values().sum::<usize>());
        println!("{kind}: {files} shared files, {lines} lines: {counts:?}");
        let own = OWN_OFFERS.iter().find(|(offered, _)| *offered == kind).map_or([0; 2], |(_, own)| *own);
        let is_seldom = files <= MAX_SHARED_FILES + own[0] && lines <= MAX_SHARED_LINES + own[1];
        assert!(is_seldom, "{kind}: {files}, {lines}: {counts:?}");
        all.extend(counts.into_keys());
    }
    let page = std::fs::read_to_string(root().join("src/device/mod.rs")).unwrap_or_default();
    let rows = page.lines().filter_map(|line| line.strip_prefix("//! | `"));
    let listed: BTreeSet<String> =
        rows.filter_map(|row| row.split('`').next()).filter(|path| path.ends_with(".rs")).map(str::to_owned).collect();
    assert_eq!(listed, all, "the files that name a kind, and the table in `src/device/mod.rs`");
}

/// The largest share of types that may have their name from another type, in percent.
const MAX_SHARED_NAMES: usize = 5;

/// A name leads to one type, so that a search for it finds what it is.
#[test]
fn types_have_names_of_their_own() {
    let is_type = |word: &str| matches!(word, "struct" | "enum" | "trait" | "type");
    let mut places: BTreeMap<String, Vec<String>> = BTreeMap::new();
    for (path, text) in sources().into_iter().filter(|(path, _)| !is_test_file(path)) {
        for line in without_tests(&text).lines().filter(|line| !line.starts_with(' ')) {
            let line = line.trim_start_matches("pub(crate) ").trim_start_matches("pub(super) ");
            let mut words = line.trim_start_matches("pub ").split([' ', '<', '(', ';', '=', ':']);
            if words.next().is_some_and(is_type) {
                let name = words.next().unwrap_or_default();
                places.entry(name.to_owned()).or_default().push(path.clone());
            }
        }
    }
    let all: usize = places.values().map(Vec::len).sum();
    let shared: Vec<_> = places.iter().filter(|(_, paths)| paths.len() > 1).collect();
    let count: usize = shared.iter().map(|(_, paths)| paths.len()).sum();
    assert!(all > 500, "only {all} types were found");
    assert!(100 * count <= MAX_SHARED_NAMES * all, "{count} of {all} types share their names: {shared:?}");
}

/// Enums for which some place may handle a few variants and refuse all others in the same way.
const OPEN_ENUMS: [&str; 1] = ["Value"];

/// Our enums are matched by name, so that a new variant requires its arms. A `_` arm is recognised textually if every
/// other arm of the same `match` names a variant of one of our enums.
#[test]
fn our_enums_are_matched_by_name() {
    let mut enums: BTreeSet<String> = sources().iter().flat_map(|(_, text)| enum_names(&code(text))).collect();
    enums.retain(|name| !OPEN_ENUMS.contains(&name.as_str()));
    for (path, text) in sources().into_iter().filter(|(path, _)| !is_test_file(path)) {
        let code = without_tests(&text);
        let lines: Vec<&str> = code.lines().collect();
        for (at, line) in lines.iter().enumerate().filter(|(_, line)| line.trim_start().starts_with("_ => ")) {
            let arms = arms_above(&lines, at);
            // In `syntax`, `Rule` is generated by pest from the grammar.
            let is_grammar = |name: &str| name == "Rule" && path.starts_with("src/syntax/");
            let is_ours = |name: &str| enums.contains(name) && !is_grammar(name);
            let of_ours = |arm: &String| arm.split_once("::").is_some_and(|(name, _)| is_ours(name));
            // A match with one or two named arms is a question, not a table.
            let is_table = arms.len() > 2 && arms.iter().all(of_ours);
            assert!(!is_table, "{path}:{}: `{}` stands for variants of {}", at + 1, line.trim(), arms[0]);
        }
    }
}

fn enum_names(code: &str) -> Vec<String> {
    let name = |rest: &str| rest.chars().take_while(|c| c.is_alphanumeric()).collect::<String>();
    code.lines().filter_map(|line| line.trim_start().strip_prefix("pub enum ").map(name)).collect()
}

/// The patterns of the arms of a `match` above a line.
fn arms_above(lines: &[&str], at: usize) -> Vec<String> {
    let indent = |line: &str| line.len() - line.trim_start().len();
    let level = indent(lines[at]);
    let above = lines[..at].iter().rev().take_while(|line| line.trim().is_empty() || indent(line) >= level);
    above
        .filter(|line| indent(line) == level && line.contains(" => "))
        .map(|line| line.trim_start().to_owned())
        .collect()
}

/// Speed is measured in `benches/`: a test that reads the clock fails on a busy machine.
#[test]
fn no_test_looks_at_the_clock() {
    for (path, text) in rust().into_iter().filter(|(path, _)| path.starts_with("tests/") || is_test_file(path)) {
        assert!(!code(&text).contains("time::Instant"), "{path}");
    }
}

/// A name for a number of micrometres, nanoseconds or volts ends with the unit.
#[test]
fn units_are_the_last_word() {
    let units = [
        "um", "nm", "mm", "m", "ns", "ms", "s", "v", "a", "j", "mj", "rad", "deg", "hz", "bytes", "si", "r", "px",
        "pitches",
    ];
    let quantities =
        ["voltage", "duration", "length", "width", "height", "radius", "distance", "pitch", "gap", "energy", "current"];
    for (path, text) in sources().into_iter().filter(|(path, _)| !is_test_file(path)) {
        for line in without_tests(&text).lines() {
            let Some((name, _)) = line.trim().trim_start_matches("pub ").split_once(": f64") else { continue };
            let last = name.rsplit(['_', '(', ' ']).next().unwrap_or_default();
            assert!(!quantities.contains(&last), "{path}: `{name}` has no unit (one of {units:?})");
        }
    }
}

/// Tracked files, as listed by git; none without git, as in a published crate.
fn tracked() -> Vec<PathBuf> {
    let listed = Command::new("git").args(["ls-files", "-z"]).current_dir(root()).output();
    let names = listed.map(|output| output.stdout).unwrap_or_default();
    names
        .split(|byte| *byte == 0)
        .filter(|name| !name.is_empty())
        .map(|name| root().join(String::from_utf8_lossy(name).as_ref()))
        .collect()
}

/// No path of the developer's machine, and no address of a mirror.
#[test]
fn nothing_tells_of_the_machine() {
    // Put together at run time, so that this file does not find itself.
    let homes = ["work", "home", "root", "Users"].map(|folder| format!("/{folder}/"));
    let mut seen = 0;
    for path in tracked() {
        let Ok(text) = std::fs::read_to_string(&path) else { continue };
        seen += 1;
        let path = from_root(&path);
        for word in &homes {
            assert!(!text.contains(word.as_str()), "{path} holds `{word}`");
        }
        if path == "Cargo.lock" {
            let other = text
                .lines()
                .find(|line| line.starts_with("source = ") && !line.contains("github.com/rust-lang/crates.io-index"));
            assert_eq!(other, None);
        }
    }
    if seen == 0 {
        println!("SKIPPED: no list of tracked files, since git is not here");
    }
}

/// The faults in `tests/faults/faults.txt`: file, old text and new text of each.
fn faults(text: &str) -> Vec<(String, String, String)> {
    let mut faults: Vec<(String, String, String)> = Vec::new();
    for line in text.lines() {
        let head = line.split_once(' ').filter(|(number, _)| number.parse::<usize>().is_ok());
        if let Some((number, rest)) = head {
            faults.push((rest.split(':').next().unwrap_or_default().to_owned(), String::new(), String::new()));
            assert_eq!(number.parse(), Ok(faults.len()), "faults are numbered one after the other");
        }
        let Some(last) = faults.last_mut() else { continue };
        if let Some(old) = line.strip_prefix("- ") {
            old.clone_into(&mut last.1);
        }
        if let Some(new) = line.strip_prefix("+ ") {
            new.clone_into(&mut last.2);
        }
    }
    faults
}

/// A fault whose text no longer exists cannot be injected, and `tests/faults/run.py` would report nothing about it.
#[test]
fn faults_have_a_place() {
    let text = std::fs::read_to_string(root().join("tests/faults/faults.txt")).expect("it is there");
    let faults = faults(&text);
    assert!(faults.len() >= 40, "only {} faults", faults.len());
    for (number, (path, old, new)) in (1..).zip(&faults) {
        let source = std::fs::read_to_string(root().join(path)).unwrap_or_else(|error| panic!("{path}: {error}"));
        // Replacing a text inside a longer word would not compile.
        let is_within_a_word = |at: usize| {
            let touches = |before: Option<char>, after: Option<char>| {
                let is_word = |char: Option<char>| char.is_some_and(|char| char.is_alphanumeric() || char == '_');
                is_word(before) && is_word(after)
            };
            touches(source[..at].chars().next_back(), old.chars().next())
                || touches(old.chars().next_back(), source[at + old.len()..].chars().next())
        };
        let count = source.match_indices(old.as_str()).filter(|(at, _)| !is_within_a_word(*at)).count();
        assert!(!old.is_empty() && !new.is_empty() && old != new, "fault {number} changes nothing");
        assert_eq!(count, 1, "fault {number} of tests/faults/faults.txt: `{old}` stands {count} times in {path}");
    }
}

#[test]
fn the_rules_can_fail() {
    assert_eq!(
        seen_rooms("use crate::{a::b, c::{d, e}, f};\ncrate::g::h()"),
        ["a", "c", "f", "g"].map(str::to_owned).into()
    );
    assert_eq!(code("let a = \"todo!() // x\"; // dbg!()\nb"), "let a = \"\"; \nb");
    let lines = ["match x {", "    A::B => 1,", "    A::C => 2,", "    _ => 3,", "}"];
    assert_eq!(arms_above(&lines, 3), ["A::C => 2,", "A::B => 1,"]);
}
