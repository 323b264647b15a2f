//! Links between the pages, and the table of contents.

use super::{assert_nothing, pages, read, root};
use std::collections::BTreeSet;
use std::path::{Component, Path, PathBuf};

const SUMMARY: &str = "docs/SUMMARY.md";

/// The link targets of a page outside code: the text in the round brackets.
fn links(text: &str) -> Vec<String> {
    let mut found = Vec::new();
    for line in prose(text) {
        let mut rest = line.as_str();
        while let Some((_, after)) = rest.split_once("](") {
            let Some((target, behind)) = after.split_once(')') else { break };
            found.push(target.to_owned());
            rest = behind;
        }
    }
    found
}

/// The lines outside fenced blocks, without code spans.
fn prose(text: &str) -> Vec<String> {
    let mut is_code = false;
    let mut lines = Vec::new();
    for line in text.lines() {
        if line.starts_with("```") {
            is_code = !is_code;
        } else if !is_code {
            lines.push(without_code(line));
        }
    }
    lines
}

/// A line without its code spans; a link whose text is code remains a link.
fn without_code(line: &str) -> String {
    line.split('`').step_by(2).collect::<Vec<_>>().join("code")
}

/// The anchors of a page, in the form that mdBook and forges derive from headings.
fn anchors(text: &str) -> BTreeSet<String> {
    let mut is_code = false;
    let mut found = BTreeSet::new();
    for line in text.lines() {
        if line.starts_with("```") {
            is_code = !is_code;
        } else if let Some(heading) = line.strip_prefix('#').filter(|_| !is_code) {
            let kept = heading.trim_start_matches('#').trim().to_lowercase();
            let kept = kept.chars().filter(|c| c.is_alphanumeric() || matches!(c, ' ' | '-' | '_'));
            found.insert(kept.map(|c| if c == ' ' { '-' } else { c }).collect());
        }
    }
    found
}

/// A path from the root with `..` resolved.
fn resolved(page: &str, target: &str) -> String {
    let from = Path::new(page).parent().unwrap_or(Path::new(""));
    let mut path = PathBuf::new();
    for part in from.join(target).components() {
        match part {
            Component::ParentDir => drop(path.pop()),
            other => path.push(other),
        }
    }
    path.to_string_lossy().replace('\\', "/")
}

#[test]
fn every_link_leads_somewhere() {
    let mut wrong = Vec::new();
    for page in pages() {
        let text = read(&page);
        for link in links(&text).into_iter().filter(|link| !link.contains("://")) {
            let (target, anchor) = link.split_once('#').unwrap_or((&link, ""));
            let path = if target.is_empty() { page.clone() } else { resolved(&page, target) };
            let is_outside = page.starts_with("docs/") && !path.starts_with("docs/");
            if is_outside || !root().join(&path).exists() {
                wrong
                    .push(format!("{page}: `{link}` leads {}", if is_outside { "out of the book" } else { "nowhere" }));
            } else if !anchor.is_empty() && !anchors(&read(&path)).contains(anchor) {
                wrong.push(format!("{page}: {path} has no heading `#{anchor}`"));
            }
        }
    }
    assert_nothing(&wrong);
}

#[test]
fn the_table_of_contents_has_every_page_once() {
    let mut listed: Vec<String> = links(&read(SUMMARY)).iter().map(|link| resolved(SUMMARY, link)).collect();
    listed.sort();
    let pages: Vec<String> = pages().into_iter().filter(|page| page.starts_with("docs/") && page != SUMMARY).collect();
    assert_eq!(listed, pages);
}

#[test]
fn links_and_anchors_are_read() {
    let text = "# A `b`: c\n[x](y.md#z) and `[no](code)` [`q`](w)\n```\n[no](block)\n# no\n```\n";
    assert_eq!(links(text), ["y.md#z", "w"]);
    assert_eq!(anchors(text), ["a-b-c".to_owned()].into());
    assert_eq!(resolved("docs/tutorials/a.md", "../b.md"), "docs/b.md");
}
