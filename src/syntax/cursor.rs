//! A place in the text that is being scanned: what is open there, how to go on, and how to cover what was read.

use super::MAX_FINDINGS;
use crate::diagnostic::Diagnostic;
use crate::source::{FileId, Span};

/// Stands where something could not be read and was reported; the grammar takes a run of it for a value.
pub(super) const HOLE: char = '\u{1}';

/// Stands for a line end that closes every open block.
pub(super) const CUT: char = '\u{2}';

/// A place in a text, with what was found before it.
pub(super) struct Cursor<'t> {
    file: FileId,
    pub text: &'t str,
    pub at: usize,
    pub covered: Option<Vec<u8>>,
    pub findings: Vec<Diagnostic>,
    pub docs: Vec<Span>,
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

/// An opening bracket.
#[derive(Debug, Clone, Copy)]
pub(super) struct OpenBracket {
    pub bracket: u8,
    pub at: usize,
    /// The blanks at the head of its line.
    pub indent: usize,
    /// The first line end inside that neither the code before it nor a closing bracket after it explains.
    pub line_end: Option<usize>,
}

/// The brackets that are open.
#[derive(Debug, Default)]
pub(super) struct Brackets {
    pub open: Vec<OpenBracket>,
    /// A brace that was closed by a `}` further left than its own line: its own closing brace is missing.
    pub suspect: Option<usize>,
    pub is_too_deep: bool,
}

impl Brackets {
    /// Whether the innermost bracket is a brace that stands at or after an offset.
    pub fn opened_after(&self, offset: usize) -> bool {
        self.open.last().is_some_and(|open| open.bracket == b'{' && open.at >= offset)
    }

    pub fn is_empty(&self) -> bool {
        self.open.is_empty()
    }

    /// Whether no list and no place is open.
    pub fn takes_entries(&self) -> bool {
        self.open.last().is_none_or(|open| open.bracket == b'{')
    }

    /// A line ended where an open `(` or `[` may not continue on the next one.
    pub fn line_ended(&mut self, at: usize) {
        for open in self.open.iter_mut().rev().take_while(|open| open.bracket != b'{') {
            open.line_end.get_or_insert(at);
        }
    }
}

impl<'t> Cursor<'t> {
    pub fn new(file: FileId, text: &'t str) -> Self {
        Cursor {
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

    pub fn newline(&mut self) {
        self.line_ends();
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
}

/// Where the line of a place ends, before its CR and LF.
pub(super) fn end_of_line(text: &str, from: usize) -> usize {
    let line = text[from..].split('\n').next().unwrap_or_default();
    from + line.strip_suffix('\r').unwrap_or(line).len()
}
