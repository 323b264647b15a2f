//! Position in the text that is being scanned: what is open there, how to move on, and how to cover text.

use super::MAX_FINDINGS;
use crate::diagnostic::Diagnostic;
use crate::source::{FileId, Span};

/// Placeholder for reported text that could not be read; the grammar takes a run of holes as a value.
pub(super) const HOLE: char = '\u{1}';

/// Placeholder for a line end that closes every open block.
pub(super) const CUT: char = '\u{2}';

/// A position in a text, with what was found before it.
pub(super) struct Cursor<'t> {
    file: FileId,
    pub text: &'t str,
    pub at: usize,
    pub covered: Option<Vec<u8>>,
    pub findings: Vec<Diagnostic>,
    pub docs: Vec<Span>,
    pub brackets: Brackets,
    /// End of the code of a declaration's head whose block has not begun yet.
    pub head_end: Option<usize>,
    /// The last byte of code, and the end of the line of that code if a line end has followed.
    pub last: u8,
    pub line_end: Option<usize>,
    /// Where the current line begins.
    pub line_start: usize,
    /// Where the current line ends; computed once per line, because a line may be a megabyte long.
    line_limit: usize,
    /// Indentation of the current line.
    pub indent: usize,
    /// Whether there has been no code on the line yet.
    pub is_line_start: bool,
}

/// An opening bracket.
#[derive(Debug, Clone, Copy)]
pub(super) struct OpenBracket {
    pub bracket: u8,
    pub at: usize,
    /// Indentation of its line.
    pub indent: usize,
    /// The first line end inside that is explained neither by the code before it nor by a closing bracket after it.
    pub line_end: Option<usize>,
}

/// The brackets that are open.
#[derive(Debug, Default)]
pub(super) struct Brackets {
    pub open: Vec<OpenBracket>,
    /// A brace that was closed by a `}` further left than the brace's own line: its own closing brace is probably
    /// missing.
    pub probably_unclosed: Option<usize>,
    pub is_too_deep: bool,
}

impl Brackets {
    /// Whether the innermost bracket is a brace at or after an offset.
    pub fn opened_after(&self, offset: usize) -> bool {
        self.open.last().is_some_and(|open| open.bracket == b'{' && open.at >= offset)
    }

    pub fn is_empty(&self) -> bool {
        self.open.is_empty()
    }

    /// Whether entries may stand here: no `(` or `[` is open inside the innermost brace.
    pub fn takes_entries(&self) -> bool {
        self.open.last().is_none_or(|open| open.bracket == b'{')
    }

    /// Records a line end inside an open `(` or `[` that may not continue on the next line.
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

    /// Overwrites a range of bytes with `with`, padded with spaces.
    pub fn replace(&mut self, start: usize, end: usize, with: &str) {
        let bytes = self.covered.get_or_insert_with(|| self.text.as_bytes().to_vec());
        bytes[start..end].fill(b' ');
        bytes[start..start + with.len()].copy_from_slice(with.as_bytes());
    }

    /// Covers reported text with holes.
    pub fn cover(&mut self, start: usize, end: usize) {
        let bytes = self.covered.get_or_insert_with(|| self.text.as_bytes().to_vec());
        bytes[start..end].fill(HOLE as u8);
    }

    /// Closes every open block at a line end.
    pub fn cut(&mut self, at: usize) {
        let bytes = self.covered.get_or_insert_with(|| self.text.as_bytes().to_vec());
        bytes[at] = CUT as u8;
    }

    pub fn rest(&self) -> &'t str {
        &self.text[self.at..]
    }

    /// Where the current line ends.
    pub fn end_of_line(&self) -> usize {
        self.line_limit
    }

    /// Moves past code that may span several lines.
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

    /// Whether the last code must be continued on the next line.
    fn goes_on(&self) -> bool {
        matches!(self.last, b'(' | b'[' | b',' | b':' | b'=' | b'<' | b'>' | b'+' | b'-' | b'*' | b'/' | b'^')
    }
}

/// End of the line at a position, before its CR and LF.
pub(super) fn end_of_line(text: &str, from: usize) -> usize {
    let line = text[from..].split('\n').next().unwrap_or_default();
    from + line.strip_suffix('\r').unwrap_or(line).len()
}
