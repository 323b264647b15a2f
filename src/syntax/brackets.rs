//! Bracket matching: which brackets are open, which were never closed, and where an unclosed one is taken to end.

use super::context;
use super::cursor::{Brackets, Cursor, OpenBracket};
use super::words::{takes_block, takes_fields};
use super::{MAX_NESTING, errors, known_mistakes};
use crate::source::Span;

fn counterpart(bracket: u8) -> u8 {
    match bracket {
        b'(' => b')',
        b'[' => b']',
        b'{' => b'}',
        b')' => b'(',
        b']' => b'[',
        _ => b'{',
    }
}

impl Cursor<'_> {
    pub fn opening(&mut self, bracket: u8) {
        let at = self.at;
        let is_of_head = at == self.line_start + self.indent || self.head_end.is_some_and(|end| at < end);
        if bracket == b'{' && self.brackets.open.is_empty() && is_of_head {
            self.head_end = None;
        }
        if self.brackets.open.len() >= MAX_NESTING {
            self.too_deep();
            return;
        }
        self.brackets.open.push(OpenBracket { bracket, at, indent: self.indent, line_end: None });
        self.at += 1;
    }

    /// Skips everything inside a bracket that is nested too deep.
    fn too_deep(&mut self) {
        let start = self.at;
        let mut depth = 0_usize;
        let mut end = self.text.len();
        for (offset, byte) in self.rest().bytes().enumerate() {
            match byte {
                b'(' | b'[' | b'{' => depth += 1,
                b')' | b']' | b'}' => depth -= 1,
                _ => continue,
            }
            if depth == 0 {
                end = start + offset + 1;
                break;
            }
        }
        if !std::mem::replace(&mut self.brackets.is_too_deep, true) {
            let span = self.span(start, start + 1);
            self.report(errors::too_deep(span));
        }
        self.cover(start, end);
        self.go_to(end);
    }

    pub fn closing(&mut self, bracket: u8) {
        let opening = counterpart(bracket);
        let at = self.at;
        self.at += 1;
        let reach = |open: &OpenBracket| open.bracket == opening || (opening != b'{' && open.bracket == b'{');
        let Some(place) = self.brackets.open.iter().rposition(reach) else { return self.stray(at) };
        if self.brackets.open[place].bracket != opening {
            return self.stray(at);
        }
        if opening == b'{' || place + 1 < self.brackets.open.len() {
            self.unclosed_brackets(place + 1, at);
        }
        if let Some(open) = self.brackets.open.pop() {
            let is_first = at == self.line_start + self.indent;
            if bracket == b'}' && is_first && self.indent < open.indent {
                self.brackets.probably_unclosed.get_or_insert(open.at);
            }
        }
        if self.brackets.open.is_empty() {
            self.brackets.probably_unclosed = None;
        }
    }

    fn stray(&mut self, at: usize) {
        // A `}` on the head's own line does not show where the block should begin.
        let opens = |head: &usize| *head <= at && self.text.as_bytes()[at] == b'}';
        if let Some(head) = self.head_end.take().filter(opens) {
            let line = context::line_before(self.text, head);
            if line.ends_with(':') {
                let mark = self.span(head - 1, head);
                self.report(known_mistakes::colon_for_brace(mark, line).with_fix_here(" {"));
                return self.replace(head - 1, head, "{");
            }
            let last = context::token_before_sign(&self.text[..head]).len();
            let mark = self.span(head - last, head);
            self.report(known_mistakes::missing_brace(mark, line));
            return self.replace(head, head + 1, "{");
        }
        let span = self.span(at, at + 1);
        self.report(errors::stray_bracket(span, self.text));
        if self.text.as_bytes()[at] == b'}' {
            self.replace(at, at + 1, "");
        } else {
            self.cover(at, at + 1);
        }
    }

    /// Reports the open `(` and `[` from index `first` on as one mistake, and covers them up to the end of their line
    /// or to `limit`.
    fn unclosed_brackets(&mut self, first: usize, limit: usize) {
        let lost: Vec<OpenBracket> = self.brackets.open.drain(first..).collect();
        let (Some(outer), Some(inner)) = (lost.first(), lost.last()) else { return };
        if !self.brackets.is_too_deep {
            let span = self.span(inner.at, inner.at + 1);
            self.report(errors::unclosed_bracket(span, self.text, counterpart(inner.bracket)));
        }
        let holds_block = lost.iter().any(|open| open.bracket == b'{');
        let line_end = outer.line_end.filter(|_| !holds_block);
        let end = line_end.map_or(limit, |end| end.min(limit));
        let code = context::code_end_before(self.text, end).max(outer.at + 1);
        self.cover(outer.at, code);
    }

    /// Handles the beginning of a declaration: open brackets count as never closed unless the declaration is indented
    /// further than the first of them.
    pub fn item_begins(&mut self) {
        let Some(first) = self.brackets.open.first() else { return self.head_begins() };
        if self.indent > first.indent {
            return;
        }
        let next = self.end_of_line();
        let item = self.span(self.at, next);
        let limit = self.line_end.unwrap_or(self.line_start);
        self.close_all(limit, Some(item));
        self.head_begins();
    }

    /// Remembers where the block of the declaration must begin.
    fn head_begins(&mut self) {
        let end = self.end_of_line();
        let code = context::code_end_before(self.text, end);
        let has_braces = takes_block(self.rest()) || takes_fields(self.rest());
        self.head_end = Some(code).filter(|code| has_braces && *code > self.at && *code < self.text.len());
    }

    /// Handles `robots: table` at the end of a line whose rows follow without a `{`.
    pub fn line_ends(&mut self) {
        if !self.text.get(self.line_start..self.at).is_some_and(|line| line.contains("table")) {
            return;
        }
        let code = context::code_end_before(self.text, self.at);
        let Some(line) = self.text.get(self.line_start..code) else { return };
        let is_table = line.strip_suffix("table").is_some_and(|before| before.trim_end().ends_with(':'));
        let has_bar = |rest: &str| rest.lines().nth(1).is_some_and(|row| row.contains('|'));
        if !is_table || !self.text[code..self.at].trim().is_empty() || !has_bar(self.rest()) {
            return;
        }
        let mark = self.span(code - "table".len(), code);
        self.report(known_mistakes::missing_brace(mark, line.trim_start()));
        self.replace(code, code + 1, "{");
        self.brackets.open.push(OpenBracket { bracket: b'{', at: code, indent: self.indent, line_end: None });
    }

    pub fn end_of_text(&mut self) {
        self.close_all(self.text.len(), None);
    }

    /// Closes everything that is open: brackets by covering them with a hole, braces by a cut.
    fn close_all(&mut self, limit: usize, item: Option<Span>) {
        if let Some(first) = self.brackets.open.iter().position(|open| open.bracket != b'{') {
            self.unclosed_brackets(first, limit);
        }
        if let Some(innermost) = self.brackets.open.last() {
            let at = self.brackets.probably_unclosed.unwrap_or(innermost.at);
            if !self.brackets.is_too_deep {
                let span = self.span(at, at + 1);
                self.report(errors::unclosed_brace(span, self.text, item));
            }
            if item.is_some() {
                self.cut(limit);
            }
        }
        self.brackets = Brackets { is_too_deep: self.brackets.is_too_deep, ..Brackets::default() };
    }
}
