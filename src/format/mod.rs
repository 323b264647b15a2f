//! The canonical form of a program.
//!
//! Problem: programs with the same meaning should look the same, so that their changes are readable. Input: the text
//! of one file. Output: its canonical text.
//!
//! Method: line breaks, groups of lines and comments are the user's; everything in between is Tweeze's. The text is
//! split into tokens (`token`); the tree decides what their characters leave open: which words are a unit, which `-` is
//! a sign, which bracket belongs to a name (`marks`). The tokens are arranged in lines (`layout`), with the spacing
//! that their neighbours require, and the lines are indented and aligned (`columns`). No line is broken or joined
//! because of its length.
//!
//! Promises, for every text without syntax errors: the canonical text has the same tree, apart from the spelling of
//! units, and the same comments in the same order; formatting it again does not change it. A declaration with an
//! error stays as it is, byte for byte; so does the whole file if there is an error outside of its declarations.

mod columns;
mod grid;
mod layout;
mod marks;
mod token;

use crate::diagnostic::{Diagnostic, Sink};
use crate::source::{FileId, Span};
use crate::syntax;
use crate::syntax::tree::Tree;
use marks::Marks;
use std::ops::Range;

/// The canonical text of a file. Syntax errors are reported to `sink`; declarations with errors stay as they are.
pub fn format(file: FileId, text: &str, sink: &mut Sink) -> String {
    let mut own = Sink::default();
    let tree = syntax::parse(file, text, &mut own);
    let formatted = match (own.errors(), own.dropped()) {
        (0, _) => formatted(text, &Marks::of(&tree), &[]),
        (_, 0) => around_errors(text, &tree, &own.sorted()),
        _ => None,
    };
    sink.append(own);
    formatted.unwrap_or_else(|| text.to_owned())
}

/// The canonical text, except for ranges of whole lines that stay as they are; `None` if it cannot be split into
/// tokens, which only happens in the lines of an error.
fn formatted(text: &str, marks: &Marks, kept: &[Range<usize>]) -> Option<String> {
    let tokens = token::without_idle_commas(token::tokens(text, marks, kept)?);
    let mut lines = layout::lines(&tokens);
    grid::align(&mut lines);
    Some(columns::print(&lines))
}

/// The canonical text with the declarations that have errors left as they are, provided that this does not change the
/// reported errors.
fn around_errors(text: &str, tree: &Tree, errors: &[&Diagnostic]) -> Option<String> {
    let marks = Marks::of(tree);
    let spans: Vec<Span> = tree.items.iter().map(|item| item.span()).collect();
    let places: Vec<Span> = errors.iter().flat_map(|error| error.labels.iter().map(|label| label.span)).collect();
    let touches = |item: &Span, place: &Span| item.start <= place.start && place.start <= item.end;
    if errors.iter().any(|error| error.span().is_none_or(|place| !spans.iter().any(|item| touches(item, &place)))) {
        return None;
    }
    let is_broken = |(index, item): (usize, &Span)| {
        marks.broken_items.contains(&index) || places.iter().any(|place| touches(item, place))
    };
    let broken: Vec<bool> = spans.iter().enumerate().map(is_broken).collect();
    let result = formatted(text, &marks, &broken_lines(text, &spans, &broken))?;
    let mut sink = Sink::default();
    let again = syntax::parse(tree.file, &result, &mut sink);
    let reports = |errors: &[&Diagnostic]| -> Vec<String> {
        errors.iter().map(|error| format!("{} {}", error.code.name(), error.title)).collect()
    };
    let same_errors = reports(&sink.sorted()) == reports(errors);
    let same_items = again.items.len() == tree.items.len() && Marks::of(&again).broken_items == marks.broken_items;
    (same_errors && same_items).then_some(result)
}

/// The lines of broken declarations, as sorted byte ranges, together with the declarations that share lines with
/// them.
fn broken_lines(text: &str, items: &[Span], broken: &[bool]) -> Vec<Range<usize>> {
    let mut clusters: Vec<(Range<usize>, bool)> = Vec::new();
    for (item, &is_broken) in items.iter().zip(broken) {
        let start = text[..item.start as usize].rfind('\n').map_or(0, |end| end + 1);
        // An unclosed declaration ends with the file.
        let last = text[..item.end as usize].trim_end().len().max(start);
        let end = text[last..].find('\n').map_or(text.len(), |length| last + length);
        match clusters.last_mut() {
            Some((lines, any)) if start < lines.end => {
                lines.end = lines.end.max(end);
                *any |= is_broken;
            }
            _ => clusters.push((start..end, is_broken)),
        }
    }
    clusters.into_iter().filter(|(_, any)| *any).map(|(lines, _)| lines).collect()
}
