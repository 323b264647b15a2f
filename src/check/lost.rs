//! Names on lines that could not be read: calling them unknown elsewhere would repeat one mistake.

use crate::diagnostic::{Code, Diagnostic, Sink};
use crate::source::{FileId, Sources, Span};
use std::collections::{BTreeMap, BTreeSet};

/// The words of the lines on which something could not be read, by file.
pub struct LostWords<'s>(BTreeMap<FileId, BTreeSet<&'s str>>);

/// The words of a text.
fn words(text: &str) -> impl Iterator<Item = &str> {
    text.split(|c: char| !(c.is_alphanumeric() || c == '_')).filter(|word| !word.is_empty())
}

impl<'s> LostWords<'s> {
    /// The words on the lines of the parser's errors.
    pub fn of(sources: &'s Sources, found: &Sink) -> Self {
        let mut lost: BTreeMap<FileId, BTreeSet<&str>> = BTreeMap::new();
        let unread = found.sorted().into_iter().filter(|finding| finding.is_error() && finding.code.is_of_syntax());
        for Span { file, start, .. } in unread.filter_map(Diagnostic::span) {
            let source = sources.file(file);
            let line = source.line(source.position(start).line).unwrap_or_default();
            lost.entry(file).or_default().extend(words(&source.text[line]));
        }
        LostWords(lost)
    }

    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    /// Whether a finding is about a name that may be declared on such a line.
    pub fn explain(&self, finding: &Diagnostic, sources: &Sources) -> bool {
        let Some(span) = finding.span() else { return false };
        let Some(lost) = self.0.get(&span.file) else { return false };
        let is_of_name = matches!(finding.code, Code::E0201 | Code::E0211 | Code::E0532 | Code::E0559);
        let is_of_image = finding.code == Code::E0570;
        // Some of these codes are also about whole steps.
        let name = sources.text(span);
        let is_lost = !name.contains(char::is_whitespace) && words(name).any(|word| lost.contains(word));
        is_of_name && is_lost || is_of_image && lost.contains("image")
    }
}
