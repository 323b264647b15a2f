//! Invariants of the canonical form of any text.

use super::mangle::mangled;
use super::random::Random;
use super::{generate, mutate, seeds};
use std::path::Path;
use tweeze::diagnostic::Sink;
use tweeze::format::format;
use tweeze::source::FileId;
use tweeze::syntax::parse;

/// Number of generated programs and mutated texts per run; `TWEEZE_FORMAT_CASES` overrides it.
const CASES: u64 = 300;

fn cases() -> u64 {
    std::env::var("TWEEZE_FORMAT_CASES").ok().and_then(|cases| cases.parse().ok()).unwrap_or(CASES)
}

/// The canonical text, and the errors that were reported.
pub fn canonical(text: &str) -> (String, Vec<String>) {
    let mut sink = Sink::default();
    let formatted = format(FileId(0), text, &mut sink);
    (formatted, errors(&sink))
}

fn errors(sink: &Sink) -> Vec<String> {
    sink.sorted().iter().map(|error| format!("{} {}", error.code.name(), error.title)).collect()
}

/// The tree of a text without spans and with units in their usual spelling, and the errors.
fn tree(text: &str) -> (String, Vec<String>) {
    let mut sink = Sink::default();
    let tree = parse(FileId(0), text, &mut sink);
    let shown = format!("{:?} {:?} {:?}", tree.doc, tree.items, tree.broken_names).replace(['µ', 'μ'], "u");
    let mut parts = shown.split("span: ");
    let mut bare = parts.next().unwrap_or_default().to_owned();
    for part in parts {
        bare.push_str(part.trim_start_matches(|c: char| c.is_ascii_digit() || ":.".contains(c)));
    }
    (bare, errors(&sink))
}

/// The comments of a text without errors, in order.
fn comments(text: &str) -> Vec<&str> {
    let comment = |line: &'_ str| -> Option<usize> {
        let mut is_text = false;
        line.char_indices().find_map(|(at, c)| {
            is_text ^= c == '"';
            (!is_text && line[at..].starts_with("//")).then_some(at)
        })
    };
    text.lines().filter_map(|line| comment(line).map(|at| line[at..].trim_end())).collect()
}

/// Checks the invariants for a text; returns its canonical text.
#[track_caller]
pub fn hold(text: &str) -> String {
    let (once, found) = canonical(text);
    let (twice, again) = canonical(&once);
    assert_eq!(once, twice, "the canonical text of\n{text}\nis not its own");
    assert_eq!(found, again, "other errors in\n{text}\nthan in\n{once}");
    if found.is_empty() {
        let (before, after) = (tree(text).0, tree(&once).0);
        assert_eq!(before, after, "another tree\n{text}\nis not\n{once}");
        let without_mark = text.strip_prefix('\u{feff}').unwrap_or(text);
        assert_eq!(comments(without_mark), comments(&once), "other comments");
        let is_tidy = |line: &str| line == line.trim_end() && !line.starts_with('\t');
        assert!(once.lines().all(is_tidy) && !once.contains("\n\n\n") && !once.starts_with('\n'), "{once}");
        assert!(once.is_empty() || once.ends_with('\n') && !once.ends_with("\n\n"), "{once:?}");
    }
    once
}

#[test]
fn every_text_of_the_project_keeps_its_tree_and_its_comments() {
    let texts = seeds::all();
    assert!(texts.len() > 300, "{}", texts.len());
    for text in texts {
        hold(&text);
    }
}

#[test]
fn examples_and_published_devices_are_canonical() {
    for folder in ["examples", "stdlib"] {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join(folder);
        for entry in std::fs::read_dir(folder).expect("it is there").map(|entry| entry.expect("it can be listed")) {
            let text = std::fs::read_to_string(entry.path()).expect("it is a text");
            let (formatted, found) = canonical(&text);
            assert!(found.is_empty(), "{found:?}");
            assert_eq!(text, formatted, "{} is not canonical: run `tweeze fmt` on it", entry.path().display());
        }
    }
}

#[test]
fn generated_programs_keep_their_tree() {
    let mut random = Random::new(17);
    for _ in 0..cases() {
        hold(&generate::program(&mut random));
    }
}

/// Changes in spaces, commas and empty lines do not change the canonical text.
#[test]
fn there_is_one_canonical_form() {
    let mut random = Random::new(18);
    let sound = |text: &String| canonical(text).1.is_empty();
    let texts: Vec<String> = seeds::all().into_iter().filter(sound).collect();
    let mut changed = 0;
    for case in 0..cases() {
        let text = match case % 2 {
            0 => generate::program(&mut random),
            _ => texts[random.below(texts.len() as u32) as usize].clone(),
        };
        let (text, _) = canonical(&text);
        let other = mangled(&text, &mut random);
        changed += u64::from(other != text);
        assert_eq!(hold(&other), text, "from\n{other}");
    }
    assert!(changed * 10 > cases() * 9, "{changed}");
}

#[test]
fn broken_texts_keep_their_errors() {
    let mut random = Random::new(19);
    let texts = seeds::all();
    let (mut broken, mut mended) = (0, 0);
    for _ in 0..4 * cases() {
        let text = mutate::mutated(&mut random, &texts);
        let formatted = hold(&text);
        let has_errors = !tree(&text).1.is_empty();
        broken += u64::from(has_errors);
        mended += u64::from(has_errors && formatted != text);
    }
    assert!(broken > cases() && mended * 20 > cases(), "{broken} broken, {mended} of them changed");
}
