//! The tokens of a text: words, signs, comments and line ends, without the spaces between them.

use super::marks::Marks;
use crate::quantity;
use crate::syntax::is_word;
use std::borrow::Cow;
use std::ops::Range;

/// Kind of a token, as far as spacing depends on it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum TokenKind {
    /// A name or a reserved word.
    Word,
    /// A number, a string, or a word such as `0b01`.
    Literal,
    Unit,
    /// `(`, `[` or `{`.
    Open,
    /// `(` or `[` that belongs to the name before it.
    Joint,
    Close,
    Comma,
    Colon,
    Equals,
    Arrow,
    Dot,
    /// `..`.
    Range,
    /// `|`.
    Bar,
    /// A binary operator other than `^`.
    Operator,
    /// `^`.
    Power,
    /// A unary minus.
    Minus,
    Comment,
    /// `///`.
    Doc,
    /// A line end.
    Break,
    /// A line end followed by one or more empty lines.
    Gap,
    /// Whole lines that stay as they are.
    Kept,
}

impl TokenKind {
    pub fn is_comment(self) -> bool {
        matches!(self, TokenKind::Comment | TokenKind::Doc)
    }

    pub fn is_break(self) -> bool {
        matches!(self, TokenKind::Break | TokenKind::Gap)
    }

    /// Whether it is part of the program; comments and line ends are not.
    pub fn is_code(self) -> bool {
        !self.is_comment() && !self.is_break()
    }

    /// Whether a value must follow, if necessary on the next line.
    pub fn goes_on(self) -> bool {
        matches!(
            self,
            TokenKind::Colon
                | TokenKind::Equals
                | TokenKind::Arrow
                | TokenKind::Range
                | TokenKind::Operator
                | TokenKind::Power
                | TokenKind::Minus
        )
    }
}

/// A token of the text.
#[derive(Debug, Clone)]
pub(super) struct FormatToken<'t> {
    pub kind: TokenKind,
    pub text: Cow<'t, str>,
}

impl FormatToken<'_> {
    pub fn is_brace(&self) -> bool {
        self.kind == TokenKind::Open && self.text == "{"
    }
}

/// Splits a text into tokens.
struct Tokenizer<'t, 'm> {
    text: &'t str,
    at: usize,
    units: &'m [(u32, u32)],
    operators: &'m [u32],
    joints: &'m [u32],
    tokens: Vec<FormatToken<'t>>,
}

/// Splits a text into tokens; `kept` are ranges of whole lines. `None` if something in between is not Tweeze syntax.
pub(super) fn tokens<'t>(text: &'t str, marks: &Marks, kept: &[Range<usize>]) -> Option<Vec<FormatToken<'t>>> {
    let (units, operators, joints) = (&marks.units[..], &marks.operators[..], &marks.joints[..]);
    let start = if text.starts_with('\u{feff}') { '\u{feff}'.len_utf8() } else { 0 };
    let mut tokenizer = Tokenizer { text, at: start, units, operators, joints, tokens: Vec::new() };
    let mut kept = kept.iter().peekable();
    while tokenizer.at < text.len() {
        match kept.peek() {
            Some(lines) if lines.contains(&tokenizer.at) => {
                tokenizer.take(TokenKind::Kept, lines.end);
                kept.next();
            }
            _ => tokenizer.next()?,
        }
    }
    Some(tokenizer.tokens)
}

/// Drops the leading offsets that are before `at`; returns whether the next one is at `at`.
fn reaches(list: &mut &[u32], at: usize) -> bool {
    while let Some((first, rest)) = list.split_first()
        && (*first as usize) < at
    {
        *list = rest;
    }
    list.first().is_some_and(|first| *first as usize == at)
}

impl<'t> Tokenizer<'t, '_> {
    fn take(&mut self, kind: TokenKind, end: usize) {
        self.tokens.push(FormatToken { kind, text: Cow::Borrowed(&self.text[self.at..end]) });
        self.at = end;
    }

    fn next(&mut self) -> Option<()> {
        let (at, rest) = (self.at, &self.text[self.at..]);
        if let Some(end) = self.unit() {
            self.take(TokenKind::Unit, end);
            if let Some(token) = self.tokens.last_mut() {
                token.text = quantity::canonical_unit(&self.text[at..end]);
            }
            return Some(());
        }
        let end_of = |is_in: fn(char) -> bool| rest.find(|c| !is_in(c)).map_or(self.text.len(), |length| at + length);
        match rest.chars().next()? {
            ' ' | '\t' | '\r' => self.at += 1,
            '\n' => self.line_end(),
            '/' if rest.starts_with("//") => self.comment(),
            '"' => {
                let end = at + 1 + rest[1..].find(['"', '\n'])?;
                self.take(TokenKind::Literal, end + 1);
            }
            '0'..='9' => self.take(TokenKind::Literal, at + number(rest)),
            c if is_word(c) => self.take(TokenKind::Word, end_of(is_word)),
            _ => {
                let (kind, length) = self.sign()?;
                self.take(kind, at + length);
            }
        }
        Some(())
    }

    /// The end of the unit that begins here, if one does.
    fn unit(&mut self) -> Option<usize> {
        while let Some(((start, _), rest)) = self.units.split_first()
            && (*start as usize) < self.at
        {
            self.units = rest;
        }
        self.units.first().filter(|unit| unit.0 as usize == self.at).map(|unit| unit.1 as usize)
    }

    fn line_end(&mut self) {
        let rest = &self.text[self.at..];
        let blank = &rest[..rest.len() - rest.trim_start_matches([' ', '\t', '\r', '\n']).len()];
        let ends = blank.bytes().filter(|byte| *byte == b'\n').count();
        let last = blank.rfind('\n').unwrap_or_default();
        let kind = if ends > 1 { TokenKind::Gap } else { TokenKind::Break };
        self.take(kind, self.at + last + 1);
    }

    fn comment(&mut self) {
        let rest = &self.text[self.at..];
        let line = rest.lines().next().unwrap_or_default();
        let is_doc = line.starts_with("///") && !line.starts_with("////");
        let end = self.at + rest.find('\n').unwrap_or(rest.len());
        self.take(if is_doc { TokenKind::Doc } else { TokenKind::Comment }, end);
        if let Some(token) = self.tokens.last_mut() {
            token.text = Cow::Borrowed(line.trim_end());
        }
    }

    /// The sign at the current position, and its length.
    fn sign(&mut self) -> Option<(TokenKind, usize)> {
        let (at, rest) = (self.at, &self.text[self.at..]);
        let pairs = [
            ("->", TokenKind::Arrow),
            ("..", TokenKind::Range),
            ("==", TokenKind::Operator),
            ("!=", TokenKind::Operator),
            ("<=", TokenKind::Operator),
            (">=", TokenKind::Operator),
        ];
        if let Some((_, kind)) = pairs.into_iter().find(|(sign, _)| rest.starts_with(sign)) {
            return Some((kind, 2));
        }
        let kind = match rest.as_bytes().first()? {
            b'(' | b'[' if reaches(&mut self.joints, at) => TokenKind::Joint,
            b'(' | b'[' | b'{' => TokenKind::Open,
            b')' | b']' | b'}' => TokenKind::Close,
            b',' => TokenKind::Comma,
            b':' => TokenKind::Colon,
            b'=' => TokenKind::Equals,
            b'.' => TokenKind::Dot,
            b'|' => TokenKind::Bar,
            b'^' => TokenKind::Power,
            b'-' if !reaches(&mut self.operators, at) => TokenKind::Minus,
            b'+' | b'-' | b'*' | b'/' | b'<' | b'>' => TokenKind::Operator,
            _ => return None,
        };
        Some((kind, 1))
    }
}

/// The length of the number or of the word such as `0b01` at the beginning of a text.
fn number(text: &str) -> usize {
    if text.starts_with("0b") {
        return text.find(|c: char| !is_word(c)).unwrap_or(text.len());
    }
    let digits = |from: usize| {
        let rest = &text[from..];
        from + rest.find(|c: char| !c.is_ascii_digit() && c != '_').unwrap_or(rest.len())
    };
    let is_digit = |at: usize| text.as_bytes().get(at).is_some_and(u8::is_ascii_digit);
    let mut end = digits(0);
    if text[end..].starts_with('.') && is_digit(end + 1) {
        end = digits(end + 1);
    }
    if text[end..].starts_with(['e', 'E']) {
        let sign = usize::from(text[end + 1..].starts_with(['+', '-']));
        if is_digit(end + 1 + sign) {
            end = digits(end + 1 + sign);
        }
    }
    end
}

/// Removes commas that separate nothing, moves each other comma to the line of what precedes it, and moves doc
/// comments before what they document, on lines of their own.
pub(super) fn without_idle_commas(tokens: Vec<FormatToken>) -> Vec<FormatToken> {
    let mut kept: Vec<FormatToken> = Vec::with_capacity(tokens.len());
    // For each open bracket, whether it is a brace.
    let mut open: Vec<bool> = Vec::new();
    for token in tokens {
        let is_list = open.last() == Some(&false);
        match token.kind {
            TokenKind::Open | TokenKind::Joint => open.push(token.is_brace()),
            TokenKind::Close => {
                open.pop();
                drop_last_comma(&mut kept, is_list);
                empty(&mut kept);
            }
            TokenKind::Comma if is_list => {
                let code = kept.iter().rposition(|token| token.kind.is_code()).map_or(0, |last| last + 1);
                kept.insert(code, token);
                continue;
            }
            TokenKind::Comma if !separates(&kept) => continue,
            TokenKind::Break | TokenKind::Gap | TokenKind::Comment if !is_list => drop_last_comma(&mut kept, false),
            TokenKind::Doc if !is_list => {
                drop_last_comma(&mut kept, false);
                if kept.last().is_some_and(|token| token.kind.is_code()) {
                    kept.push(FormatToken { kind: TokenKind::Break, text: Cow::Borrowed("\n") });
                }
            }
            _ => {}
        }
        // The line ends around a comma that was alone on its line.
        if token.kind.is_break() && kept.last().is_some_and(|last| last.kind.is_break()) {
            kept.pop_if(|last| last.kind == TokenKind::Break);
            if kept.last().is_some_and(|last| last.kind == TokenKind::Gap) {
                continue;
            }
        }
        kept.push(token);
    }
    drop_last_comma(&mut kept, false);
    kept
}

/// Whether a comma after these tokens of a block separates two entries of one line.
fn separates(kept: &[FormatToken]) -> bool {
    kept.last().is_some_and(|token| token.kind.is_code() && token.kind != TokenKind::Comma && !token.is_brace())
}

/// Drops trailing line ends if only an opening bracket is before them.
fn empty(kept: &mut Vec<FormatToken>) {
    let last = kept.iter().rposition(|token| !token.kind.is_break());
    if let Some(last) = last.filter(|last| matches!(kept[*last].kind, TokenKind::Open | TokenKind::Joint)) {
        kept.truncate(last + 1);
    }
}

/// Drops a trailing comma; in a list, comments and line ends may follow it.
fn drop_last_comma(kept: &mut Vec<FormatToken>, is_list: bool) {
    let last = kept.iter().rposition(|token| !is_list || token.kind.is_code());
    if let Some(last) = last.filter(|last| kept[*last].kind == TokenKind::Comma) {
        kept.remove(last);
    }
}
