//! Which room of the house sees which.

use super::{is_test_file, sources, without_tests};
use std::collections::{BTreeMap, BTreeSet};

/// The base: seen by everybody, sees nothing but itself.
pub const BASE: [&str; 7] = ["source", "real", "random", "quantity", "geometry", "diagnostic", "device"];

/// What each other room may see besides the base. `plan` is never in reach of `verify`, and nobody sees `cli`.
pub const SIGHT: &[(&str, &[&str])] = &[
    ("stdlib", &[]),
    ("syntax", &[]),
    ("format", &["syntax"]),
    // The contract: what the stages hand to one another.
    ("claims", &[]),
    ("schedule", &["claims"]),
    // Side by side on it; none of them sees another.
    ("check", &["syntax", "stdlib", "claims"]),
    ("plan", &["claims"]),
    ("verify", &["claims", "schedule"]),
    ("log", &["claims", "schedule"]),
    // What joins them.
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

/// The room of a file: `src/check/mod.rs` lies in `check`.
pub fn room(path: &str) -> &str {
    path.trim_start_matches("src/").trim_end_matches(".rs").split('/').next().unwrap_or_default()
}

/// The rooms that a text names after `crate::`, in `use` groups too.
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
            // Names of the crate's own root are macros, and not rooms.
            let is_room = BASE.contains(&seen.as_str()) || sight.contains_key(seen.as_str());
            let allowed = seen == room
                || BASE.contains(&seen.as_str())
                || sight.get(room).is_some_and(|list| list.contains(&seen.as_str()));
            assert!(allowed && is_room, "{path} sees `{seen}`");
        }
    }
}

/// The most rooms on the longest way down, from `cli` to those that see nobody.
const MAX_FLOORS: usize = 8;

#[test]
fn the_house_has_few_floors() {
    let mut sight: BTreeMap<String, BTreeSet<String>> = BTreeMap::new();
    for (path, text) in sources().into_iter().filter(|(path, _)| !is_test_file(path)) {
        sight.entry(room(&path).to_string()).or_default().extend(seen_rooms(&without_tests(&text)));
    }
    // Rooms by their floor, from the ground: each pass puts in those that see none but rooms below.
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
