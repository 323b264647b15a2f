//! Characters, before the grammar reads them.
//!
//! Input: the text of a file. Output: the same text, of the same length and in the same places, in which text that no rule can recover from
//! is covered with [`HOLE`], spellings of other languages are replaced by Tweeze's, and a line end after which a forgotten
//! `}` is assumed is a [`CUT`]; with it the findings and the places of the doc comments. Promise: brackets in the returned
//! text pair up, apart from braces that a cut or the end closes, and nest at most [`MAX_NESTING`] deep.

use super::brackets::Brackets;
use super::lexical;
use super::reader::MAX_FINDINGS;
use crate::diagnostic::Diagnostic;
use crate::source::{FileId, Span};
use std::borrow::Cow;

/// Stands where something could not be read and was reported; the grammar takes a run of it for a value.
pub(super) const HOLE: char = '\u{1}';

/// Stands for a line end that closes every open block.
pub(super) const CUT: char = '\u{2}';

/// The deepest that brackets, braces and blocks may nest.
pub const MAX_NESTING: usize = 64;

/// Result of the scan.
pub(super) struct Scanned<'t> {
    pub text: Cow<'t, str>,
    pub findings: Vec<Diagnostic>,
    /// The doc comments, in order.
    pub docs: Vec<Span>,
}

/// Reads the characters of a text.
pub(super) fn scan(file: FileId, text: &str) -> Scanned<'_> {
    let mut scan = Scan::new(file, text);
    scan.byte_order_mark();
    while scan.at < text.len() {
        scan.token();
    }
    scan.end_of_text();
    let text = match scan.covered {
        Some(bytes) => String::from_utf8(bytes).map_or(Cow::Borrowed(text), Cow::Owned),
        None => Cow::Borrowed(text),
    };
    Scanned { text, findings: scan.findings, docs: scan.docs }
}

/// Walks over a text.
pub(super) struct Scan<'t> {
    file: FileId,
    pub text: &'t str,
    pub at: usize,
    covered: Option<Vec<u8>>,
    findings: Vec<Diagnostic>,
    docs: Vec<Span>,
    pub brackets: Brackets,
    /// Where the code of a declaration's head ends that has had no block yet.
    pub head_end: Option<usize>,
    /// The last byte of code, and where the line of that code ends, if a line end has been met since.
    pub last: u8,
    pub line_end: Option<usize>,
    /// Where the line begins.
    pub line_start: usize,
    /// Where it ends; known once, because a line may be a megabyte long.
    line_limit: usize,
    /// The blanks at its head.
    pub indent: usize,
    /// Whether the line has had no code yet.
    pub is_line_start: bool,
}

impl<'t> Scan<'t> {
    fn new(file: FileId, text: &'t str) -> Self {
        Scan {
            file,
            text,
            at: 0,
            covered: None,
            findings: Vec::new(),
            docs: Vec::new(),
            brackets: Brackets::default(),
            head_end: None,
            last: b'\n',
            line_end: None,
            line_start: 0,
            line_limit: end_of_line(text, 0),
            indent: 0,
            is_line_start: true,
        }
    }

    pub fn span(&self, start: usize, end: usize) -> Span {
        Span::new(self.file, start, end)
    }

    pub fn report(&mut self, finding: Diagnostic) {
        if self.findings.len() < MAX_FINDINGS {
            self.findings.push(finding);
        }
    }

    /// Puts bytes in the place of others: `with`, filled up with blanks.
    pub fn replace(&mut self, start: usize, end: usize, with: &str) {
        let bytes = self.covered.get_or_insert_with(|| self.text.as_bytes().to_vec());
        bytes[start..end].fill(b' ');
        bytes[start..start + with.len()].copy_from_slice(with.as_bytes());
    }

    /// Covers text that has been reported.
    pub fn cover(&mut self, start: usize, end: usize) {
        let bytes = self.covered.get_or_insert_with(|| self.text.as_bytes().to_vec());
        bytes[start..end].fill(HOLE as u8);
    }

    /// Closes every block at a line end.
    pub fn cut(&mut self, at: usize) {
        let bytes = self.covered.get_or_insert_with(|| self.text.as_bytes().to_vec());
        bytes[at] = CUT as u8;
    }

    pub fn rest(&self) -> &'t str {
        &self.text[self.at..]
    }

    /// Where the line ends.
    pub fn end_of_line(&self) -> usize {
        self.line_limit
    }

    /// Goes on behind some code that may end lines further down.
    pub fn go_to(&mut self, at: usize) {
        self.at = at;
        if at > self.line_limit {
            self.line_start = self.text[..at].rfind('\n').map_or(0, |end| end + 1);
            self.line_limit = end_of_line(self.text, at);
            let line = &self.text[self.line_start..self.line_limit];
            self.indent = line.len() - line.trim_start_matches([' ', '\t']).len();
        }
    }

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
            // A unit elsewhere, but no line begins with one.
            '%' if self.is_line_start => return lexical::foreign_comment(self),
            _ => {}
        }
        if self.is_line_start && first == '|' && self.outer_bars() {
            return;
        }
        if self.is_line_start {
            self.is_line_start = false;
            self.indent = self.at - self.line_start;
            if super::brackets::starts_item(self.rest()) {
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
            _ if lexical::is_word(first) => lexical::word(self),
            _ => lexical::sign(self, first),
        }
        self.last = self.text.as_bytes()[self.at - 1];
        self.line_end = None;
    }

    /// The bars around a row, and the line under a header, as in Markdown: blank to the grammar.
    fn outer_bars(&mut self) -> bool {
        let line = self.text[self.at..self.line_limit].trim_end();
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

    /// A blank to the grammar, wherever it stands.
    fn carriage_return(&mut self) {
        self.replace(self.at, self.at + 1, "");
        self.at += 1;
    }

    pub fn newline(&mut self) {
        self.line_end.get_or_insert(self.at);
        if !self.goes_on() {
            self.brackets.line_ended(self.at);
        }
        self.at += 1;
        self.line_start = self.at;
        self.line_limit = end_of_line(self.text, self.at);
        self.is_line_start = true;
    }

    /// Whether the last code demands a next line.
    fn goes_on(&self) -> bool {
        matches!(self.last, b'(' | b'[' | b',' | b':' | b'=' | b'<' | b'>' | b'+' | b'-' | b'*' | b'/' | b'^')
    }

    fn comment(&mut self) {
        let end = self.end_of_line();
        let comment = &self.text[self.at..end];
        let is_doc = comment.starts_with("//!") || (comment.starts_with("///") && !comment.starts_with("////"));
        if is_doc {
            let span = self.span(self.at, end);
            self.docs.push(span);
        }
        self.at = end;
    }
}

fn end_of_line(text: &str, from: usize) -> usize {
    text[from..].find('\n').map_or(text.len(), |length| from + length)
}
