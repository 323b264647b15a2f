//! Which room (top-level module) may use which others.

use super::{is_test_file, sources, without_tests};
use std::collections::{BTreeMap, BTreeSet};

/// The base rooms: every room may use them, and they use only each other.
pub const BASE: [&str; 7] = ["source", "real", "random", "quantity", "geometry", "diagnostic", "device"];

/// The other rooms that each room may use besides the base. `verify` never reaches `plan`, and nothing uses `cli`.
pub const SIGHT: &[(&str, &[&str])] = &[
    ("stdlib", &[]),
    ("syntax", &[]),
    ("format", &["syntax"]),
    // The contract: data that the stages hand to one another.
    ("claims", &[]),
    ("schedule", &["claims"]),
    // Stages side by side on the contract; none of them uses another.
    ("check", &["syntax", "stdlib", "claims"]),
    ("plan", &["claims"]),
    ("verify", &["claims", "schedule"]),
    ("log", &["claims", "schedule"]),
    // Rooms that join the stages.
    ("simulate", &["claims", "plan"]),
    ("lower", &["claims", "plan", "schedule"]),
    ("emit", &["claims", "schedule", "verify", "log"]),
    ("compile", &["syntax", "claims", "schedule", "check", "plan", "lower", "verify"]),
    ("lsp", &["stdlib", "syntax", "format", "claims", "check"]),
    (
        "cli",
        &[
            "syntax", "format", "stdlib", "claims", "schedule", "check", "plan", "verify", "log", "simulate", "lower",
            "emit", "compile", "lsp",
        ],
    ),
];

/// The room of a file: `src/check/mod.rs` is in `check`.
pub fn room(path: &str) -> &str {
    path.trim_start_matches("src/").trim_end_matches(".rs").split('/').next().unwrap_or_default()
}

/// The rooms that a text names after `crate::`, also in `use` groups.
pub fn seen_rooms(code: &str) -> BTreeSet<String> {
    let word = |text: &str| text.chars().take_while(|c| c.is_alphanumeric() || *c == '_').collect::<String>();
    let mut rooms = BTreeSet::new();
    for (at, _) in code.match_indices("crate::") {
        let rest = &code[at + "crate::".len()..];
        match rest.strip_prefix('{') {
            None => drop(rooms.insert(word(rest))),
            Some(group) => {
                let mut depth = 0;
                let mut begins = true;
                for (at, c) in group.char_indices() {
                    match c {
                        '{' => depth += 1,
                        '}' if depth == 0 => break,
                        '}' => depth -= 1,
                        ',' if depth == 0 => begins = true,
                        _ if begins && c.is_alphabetic() => {
                            rooms.insert(word(&group[at..]));
                            begins = false;
                        }
                        _ => {}
                    }
                }
            }
        }
    }
    rooms
}

#[test]
fn rooms_see_only_what_they_may() {
    let sight: BTreeMap<&str, &[&str]> = SIGHT.iter().copied().collect();
    for (path, text) in sources() {
        let room = room(&path);
        if is_test_file(&path) || matches!(room, "lib" | "main") {
            continue;
        }
        for seen in seen_rooms(&without_tests(&text)) {
            // Other names in the crate's root are macros, not rooms.
            let is_room = BASE.contains(&seen.as_str()) || sight.contains_key(seen.as_str());
            let allowed = seen == room
                || BASE.contains(&seen.as_str())
                || sight.get(room).is_some_and(|list| list.contains(&seen.as_str()));
            assert!(allowed && is_room, "{path} sees `{seen}`");
        }
    }
}

/// Greatest number of rooms on the longest dependency chain, from `cli` to those that use no other.
const MAX_FLOORS: usize = 8;

#[test]
fn the_house_has_few_floors() {
    let mut sight: BTreeMap<String, BTreeSet<String>> = BTreeMap::new();
    for (path, text) in sources().into_iter().filter(|(path, _)| !is_test_file(path)) {
        sight.entry(room(&path).to_string()).or_default().extend(seen_rooms(&without_tests(&text)));
    }
    // Rooms by level, from the bottom: each pass adds those that use only rooms below.
    let mut built: BTreeSet<String> = BTreeSet::from(["lib".to_string(), "main".to_string()]);
    let mut floors = 0;
    while built.len() < sight.len() {
        let rests = |(name, seen): &(&String, &BTreeSet<String>)| {
            !built.contains(*name)
                && seen.iter().all(|other| other == *name || built.contains(other) || !sight.contains_key(other))
        };
        let floor: Vec<String> = sight.iter().filter(rests).map(|(name, _)| name.clone()).collect();
        assert!(
            !floor.is_empty(),
            "rooms see each other in a circle; above them stand {:?}",
            sight.keys().filter(|name| !built.contains(*name))
        );
        built.extend(floor);
        floors += 1;
    }
    assert!(floors <= MAX_FLOORS, "{floors} floors");
}
