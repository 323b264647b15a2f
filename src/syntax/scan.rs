//! Character scan before parsing.
//!
//! Input: the text of a file. Output: a text of the same length, with the findings and the places of the doc comments.
//! In that text, parts that no rule can recover from are covered with [`super::cursor::HOLE`], foreign spellings are
//! replaced by Tweeze's, and a line end after which a forgotten `}` is assumed is a [`super::cursor::CUT`]; offsets do
//! not change. Guarantee: brackets in the returned text match, apart from braces that a cut or the end closes, and nest
//! at most [`super::MAX_NESTING`] deep.

use super::cursor::Cursor;
use super::foreign_syntax;
use super::lexical;
use super::words::{is_word, starts_item};
use crate::diagnostic::Diagnostic;
use crate::source::{FileId, Span};
use std::borrow::Cow;

/// Result of the scan.
pub(super) struct Scanned<'t> {
    pub text: Cow<'t, str>,
    pub findings: Vec<Diagnostic>,
    /// The doc comments, in order.
    pub docs: Vec<Span>,
}

/// Scans the characters of a text.
pub(super) fn scan(file: FileId, text: &str) -> Scanned<'_> {
    let mut cursor = Cursor::new(file, text);
    cursor.byte_order_mark();
    while cursor.at < text.len() {
        cursor.token();
    }
    cursor.end_of_text();
    let text = match cursor.covered {
        Some(bytes) => String::from_utf8(bytes).map_or(Cow::Borrowed(text), Cow::Owned),
        None => Cow::Borrowed(text),
    };
    Scanned { text, findings: cursor.findings, docs: cursor.docs }
}

impl Cursor<'_> {
    fn byte_order_mark(&mut self) {
        if self.text.starts_with('\u{feff}') {
            self.replace(0, 3, "");
            self.at = 3;
        }
    }

    fn token(&mut self) {
        let Some(first) = self.rest().chars().next() else { return };
        match first {
            '\n' => return self.newline(),
            ' ' | '\t' => {
                self.at += 1;
                return;
            }
            '\r' => return self.carriage_return(),
            '/' if self.rest().starts_with("//") => return self.comment(),
            '/' if self.rest().starts_with("/*") => return lexical::block_comment(self),
            '#' => return lexical::foreign_comment(self),
            // Elsewhere `%` is a unit, but no line or block begins with one.
            '%' if self.is_line_start || self.last == b'{' => return lexical::foreign_comment(self),
            _ => {}
        }
        if self.is_line_start && first == '|' && self.outer_bars() {
            return;
        }
        if self.is_line_start {
            self.is_line_start = false;
            self.indent = self.at - self.line_start;
            if starts_item(self.rest()) {
                self.item_begins();
            }
        }
        match first {
            '"' => lexical::string(self),
            '0'..='9' => lexical::number(self),
            '.' if lexical::is_bare_fraction(self) => lexical::bare_fraction(self),
            '(' | '[' | '{' => self.opening(first as u8),
            ')' | ']' | '}' => self.closing(first as u8),
            ';' => lexical::semicolon(self),
            _ if is_word(first) => lexical::word(self),
            _ => lexical::sign(self, first),
        }
        self.last = self.text.as_bytes()[self.at - 1];
        self.line_end = None;
    }

    /// Scans the outer bars of a row or the rule under a header, as in Markdown; the grammar sees them as spaces.
    fn outer_bars(&mut self) -> bool {
        let line = self.text[self.at..self.end_of_line()].trim_end();
        if line.len() < 2 || !line.ends_with('|') {
            return false;
        }
        if line.bytes().all(|byte| matches!(byte, b'|' | b'-' | b':' | b' ')) {
            self.replace(self.at, self.at + line.len(), "");
            self.at += line.len();
            return true;
        }
        let last = self.at + line.len() - 1;
        self.replace(self.at, self.at + 1, "");
        self.replace(last, last + 1, "");
        self.at += 1;
        true
    }

    /// Scans a CR; the grammar sees it as a space everywhere.
    fn carriage_return(&mut self) {
        self.replace(self.at, self.at + 1, "");
        self.at += 1;
    }

    fn comment(&mut self) {
        let end = self.end_of_line();
        let comment = &self.text[self.at..end];
        let is_doc = comment.starts_with("//!") || (comment.starts_with("///") && !comment.starts_with("////"));
        if is_doc {
            let span = self.span(self.at, end);
            self.docs.push(span);
        } else if let Some(finding) = foreign_syntax::whole_division(self.span(self.at, end), self.text) {
            self.report(finding);
        }
        self.at = end;
    }
}
