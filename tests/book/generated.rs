//! Generated pages, made from what the program prints (the vocabulary and the diagnostics), and pages that include
//! whole files.

use super::blocks::blocks;
use super::{assert_nothing, read, root, updates};
use std::collections::BTreeSet;
use std::fs;
use std::process::Command;
use tweeze::device::Kind;
use tweeze::device::instrument::Family;

/// Output of `tweeze`.
fn printed(arguments: &[&str]) -> String {
    let output = Command::new(env!("CARGO_BIN_EXE_tweeze")).args(arguments).output().expect("the program starts");
    assert!(output.status.success(), "{arguments:?}");
    String::from_utf8(output.stdout).expect("text")
}

fn assert_generated(page: &str, text: &str) {
    if updates() {
        fs::write(root().join(page), text).expect("the page is written");
    }
    assert!(read(page) == text, "{page} is not what the program prints: TWEEZE_UPDATE=1 rewrites it");
}

/// Columns of `tweeze devices` at which a term and its meaning begin.
const TERM: usize = 2;
const MEANING: usize = 34;

/// Whether a line has a meaning in its column; a long term has its own line.
fn has_meaning(line: &str) -> bool {
    let near: Vec<char> = line.chars().skip(MEANING - 2).take(3).collect();
    matches!(near.as_slice(), [' ', ' ', first] if *first != ' ')
}

/// A section of `tweeze devices KIND` as Markdown: a table of terms and meanings, or a paragraph.
fn section(title: &str, lines: &[&str]) -> String {
    let mut entries: Vec<(String, String)> = Vec::new();
    for line in lines {
        let chars: Vec<char> = line.chars().collect();
        let is_blank = |from: usize, to: usize| chars[from..to].iter().all(|c| *c == ' ');
        let text = |from: usize, to: usize| chars[from..to].iter().collect::<String>().trim().to_owned();
        let has_meaning = has_meaning(line);
        match entries.last_mut() {
            Some((_, meaning)) if has_meaning && is_blank(0, MEANING) => {
                let rest = text(MEANING, chars.len());
                *meaning = if meaning.is_empty() { rest } else { format!("{meaning} {rest}") };
            }
            _ if has_meaning => entries.push((text(TERM, MEANING), text(MEANING, chars.len()))),
            _ => entries.push((text(TERM, chars.len()), String::new())),
        }
    }
    if entries.iter().all(|(_, meaning)| meaning.is_empty()) {
        let terms: Vec<String> = entries.into_iter().map(|(term, _)| shown(&term)).collect();
        return format!("{title}\n\n{}\n", terms.join(" ")).trim_start().to_owned();
    }
    let rows = entries.iter().map(|(term, meaning)| format!("| `{}` | {} |\n", barred(term), barred(&shown(meaning))));
    format!("{title}\n\n| | |\n|---|---|\n{}", rows.collect::<String>())
}

fn barred(cell: &str) -> String {
    cell.replace('|', "\\|")
}

/// A text in which `<device>` is displayed instead of parsed as a tag.
fn shown(text: &str) -> String {
    let parts = text.split('`').enumerate();
    let parts = parts.map(|(at, part)| if at % 2 == 0 { part.replace('<', "\\<") } else { part.to_owned() });
    parts.collect::<Vec<_>>().join("`")
}

/// The page of a kind or a family as Markdown.
fn chapter(printed: &str) -> String {
    let mut lines = printed.lines();
    let head = lines.next().unwrap_or_default();
    let (name, summary) = head.split_once(": ").expect("a name and what it is");
    let mut text = format!("## {name}\n\n{}\n", shown(summary));
    let mut title: Option<String> = None;
    let mut entries: Vec<&str> = Vec::new();
    let mut close = |title: &mut Option<String>, entries: &mut Vec<&str>| {
        let of = title.take();
        match of {
            Some(title) if entries.is_empty() => text.push_str(&format!("\n{title}\n")),
            Some(title) => text.push_str(&format!("\n{}", section(&format!("### {name}: {title}"), entries))),
            None => {}
        }
        entries.clear();
    };
    for line in lines.filter(|line| !line.is_empty()) {
        if line.starts_with(' ') {
            entries.push(line);
        } else {
            close(&mut title, &mut entries);
            title = Some(line.to_owned());
        }
    }
    close(&mut title, &mut entries);
    text
}

#[test]
fn the_vocabulary_is_that_of_the_compiler() {
    let mut page = String::from(
        "# The vocabulary\n\nWhat each kind of device and each family of instruments offers: the tables that the checker reads, as `tweeze devices KIND` prints \
         them. [The language](language.md) explains how it fits together, [the library](library.md) has the published devices.\n",
    );
    let names = Kind::ALL.iter().map(|kind| kind.name()).chain(Family::ALL.iter().map(|family| family.name()));
    for name in names {
        page.push('\n');
        page.push_str(&chapter(&printed(&["devices", name])));
    }
    assert_generated("docs/vocabulary.md", &page);
}

/// Markdown with every heading one level lower.
fn demoted(text: &str) -> String {
    let mut is_code = false;
    let mut lines = Vec::new();
    for line in text.lines() {
        is_code ^= line.starts_with("```");
        lines.push(if line.starts_with('#') && !is_code { format!("#{line}") } else { line.to_owned() });
    }
    lines.join("\n") + "\n"
}

#[test]
fn the_diagnostics_are_those_of_the_compiler() {
    let page = format!(
        "# All diagnostics\n\nThe pages of `tweeze explain CODE`. Most show a program that is refused and the same one mended; the tests compile both.\n\n{}",
        demoted(&printed(&["explain", "--all"]))
    );
    assert_generated("docs/diagnostics.md", &page);
}

/// Asserts that a page includes every file of a folder under its name, and no others.
fn assert_included(page: &str, folder: &str) {
    let entries = fs::read_dir(root().join(folder)).expect("the folder is there").flatten();
    let mut names: Vec<String> = entries.map(|entry| entry.file_name().to_string_lossy().into_owned()).collect();
    names.retain(|name| name.ends_with(".twz"));
    names.sort();
    let due: Vec<String> =
        names.iter().map(|name| format!("## {name}\n```twz\n{{{{#include ../{folder}/{name}}}}}\n```\n")).collect();
    let text = read(page);
    assert_eq!(text.split_once("\n## ").map(|(_, rest)| format!("## {rest}")), Some(due.join("\n")), "{page}");
}

#[test]
fn examples_and_library_are_whole() {
    assert_included("docs/examples.md", "examples");
    assert_included("docs/library.md", "stdlib");
}

/// Prepositions of steps.
const PREPOSITIONS: [&str; 7] = ["about", "at", "by", "for", "to", "via", "with"];

/// Sections of `tweeze devices` that contain no words of programs.
const WITHOUT_WORDS: [&str; 4] = ["Channels", "Outputs", "To begin with", "Played by"];

fn words(text: &str) -> impl Iterator<Item = &str> {
    text.split(|c: char| !(c.is_alphanumeric() || c == '_')).filter(|word| !word.is_empty())
}

/// The words that a kind or family adds: the first word of each term, the fields in its braces, and the prepositions.
fn vocabulary(printed: &str) -> BTreeSet<String> {
    let mut found = BTreeSet::new();
    let mut has_words = true;
    for line in printed.lines().skip(1).filter(|line| !line.is_empty()) {
        if !line.starts_with(' ') {
            has_words = !WITHOUT_WORDS.iter().any(|section| line.starts_with(section));
        }
        let is_term = line.starts_with("  ") && line.chars().nth(TERM).is_some_and(|c| c != ' ');
        if has_words && is_term {
            let term: String = line.chars().take(if has_meaning(line) { MEANING } else { usize::MAX }).collect();
            found.extend(words(&term).take(1).map(str::to_owned));
            found.extend(words(&term).filter(|word| PREPOSITIONS.contains(word)).map(str::to_owned));
            let fields = term.split_once('{').map_or("", |(_, fields)| fields);
            let names = fields.split(',').filter_map(|field| field.split_once(':')).map(|(name, _)| name.trim());
            found.extend(names.filter(|name| words(name).count() == 1).map(str::to_owned));
        }
    }
    found
}

#[test]
fn every_form_is_on_its_page() {
    let page = read("docs/forms.md");
    let mut missing = Vec::new();
    for name in Kind::ALL.iter().map(|kind| kind.name()).chain(Family::ALL.iter().map(|family| family.name())) {
        let (_, rest) = page.split_once(&format!("\n## {name}\n")).unwrap_or_else(|| panic!("no section {name}"));
        let section = rest.split("\n## ").next().unwrap_or_default();
        // A card is mentioned in the section of a generator, too.
        let text = if Kind::find(name).is_some() { section } else { page.as_str() };
        let shown: Vec<String> = blocks(text).into_iter().filter(|b| b.language == "twz").map(|b| b.text()).collect();
        let shown: BTreeSet<&str> = shown.iter().flat_map(|text| words(text)).collect();
        let due = vocabulary(&printed(&["devices", name]));
        assert!(due.len() >= 8, "{name}: {due:?}");
        missing.extend(due.into_iter().filter(|w| !shown.contains(w.as_str())).map(|word| format!("{name}: `{word}`")));
    }
    assert_nothing(&missing);
}

#[test]
fn a_page_of_terms_becomes_tables() {
    let printed = format!(
        "a: b\n\nFields\n  {:30}  one\n  {:30}  two | three\n  {}\n\nChannels\n  <d>.x\n\nTo: x\n",
        "x: y",
        "",
        "z".repeat(40)
    );
    let page = chapter(&printed);
    assert!(page.contains("### a: Fields\n\n| | |\n|---|---|\n| `x: y` | one two \\| three |\n"), "{page}");
    assert!(page.contains("### a: Channels\n\n\\<d>.x\n") && page.ends_with("\nTo: x\n"), "{page}");
}
