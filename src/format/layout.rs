//! Arranges tokens in lines: which tokens share a line, the spaces between them, and the indent of each line.

use super::token::{FormatToken, TokenKind};

/// Spaces per indentation level.
const LEVEL: usize = 2;

/// Indent of a line.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Indent {
    /// No indent.
    Margin,
    /// The indent of another line plus some spaces.
    Beyond { line: usize, blanks: usize },
    /// The column of a place in another line: a byte offset in one of its parts.
    Below { line: usize, part: usize, byte: usize },
}

/// The alignment group of a line within its block.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Alignment<'p> {
    Alone,
    /// `left:  5`.
    Field,
    /// `obstacle bead  : disc`, by the noun.
    Object(&'p str),
    /// `device left  : base`.
    Device,
    /// `bl0.set   -> "line0"`.
    Wire,
    /// A row of the table with this number.
    Table(usize),
}

/// A line of the canonical text.
#[derive(Debug)]
pub(super) struct CanonicalLine<'p> {
    pub indent: Indent,
    /// Its code, in parts that may be padded; empty for a line with only a comment.
    pub parts: Vec<String>,
    /// The separator between two parts.
    pub separator: &'static str,
    pub comment: Option<&'p FormatToken<'p>>,
    /// Whether an empty line comes before it.
    pub after_gap: bool,
    /// Whether it continues the entry of the previous line.
    pub goes_on: bool,
    pub alignment: Alignment<'p>,
    /// Whole lines that stay as they are.
    pub kept: Option<&'p str>,
    /// Whether it ends with a bracket whose content begins on the next line.
    opens: bool,
    /// Whether it begins with the first token of an entry.
    starts_entry: bool,
    /// The number of brackets that are open at its beginning.
    depth: usize,
}

/// Content of a pair of braces.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Block {
    File,
    Scene,
    Wiring,
    Table(usize),
    Other,
}

/// An open bracket, and the entry of its block that is being read. The first one represents the file.
struct OpenBracket<'p> {
    is_brace: bool,
    /// Whether its content is on lines of its own.
    is_broken: bool,
    block: Block,
    /// Its position: the line, the part, and the byte after it.
    line: usize,
    part: usize,
    byte: usize,
    entry_line: usize,
    entry_word: &'p str,
    /// Number of tokens of the entry so far.
    entry_tokens: usize,
}

/// Arranges tokens in lines.
struct LineBuilder<'p> {
    tokens: &'p [FormatToken<'p>],
    /// For each bracket, whether its content is on lines of its own.
    broken: Vec<bool>,
    lines: Vec<CanonicalLine<'p>>,
    open: Vec<OpenBracket<'p>>,
    tables: usize,
    /// The last token of code.
    last: Option<&'p FormatToken<'p>>,
    /// Whether the last line is still open for tokens.
    in_line: bool,
    /// Whether the last token of code is a bracket whose content is on lines of its own.
    opens: bool,
    after_gap: bool,
    /// Whether the last `^` has spaces around it.
    is_power_apart: bool,
}

/// The lines of a text.
pub(super) fn lines<'p>(tokens: &'p [FormatToken<'p>]) -> Vec<CanonicalLine<'p>> {
    let file = OpenBracket {
        is_brace: true,
        is_broken: true,
        block: Block::File,
        line: 0,
        part: 0,
        byte: 0,
        entry_line: 0,
        entry_word: "",
        entry_tokens: 0,
    };
    let mut builder = LineBuilder {
        tokens,
        broken: broken_brackets(tokens),
        lines: Vec::new(),
        open: vec![file],
        tables: 0,
        last: None,
        in_line: false,
        opens: false,
        after_gap: false,
        is_power_apart: false,
    };
    for index in 0..tokens.len() {
        builder.token(index);
    }
    builder.end_line();
    builder.lines
}

/// For each bracket, whether its content is on lines of its own: braces with a line end between entries, or with such
/// braces inside; other brackets with a line end after the opening one.
fn broken_brackets(tokens: &[FormatToken]) -> Vec<bool> {
    let mut broken = vec![false; tokens.len()];
    let mut open: Vec<usize> = Vec::new();
    let mut goes_on = false;
    for (index, token) in tokens.iter().enumerate() {
        match token.kind {
            TokenKind::Open | TokenKind::Joint => open.push(index),
            TokenKind::Close => {
                let Some(opening) = open.pop() else { continue };
                broken[index] = broken[opening];
                let outer = open.iter().rfind(|outer| tokens[**outer].is_brace());
                if let Some(&outer) = outer.filter(|_| broken[opening] && tokens[opening].is_brace()) {
                    broken[outer] = true;
                }
            }
            kind if !kind.is_code() => {
                if let Some(&opening) = open.last() {
                    broken[opening] |= if tokens[opening].is_brace() { !goes_on } else { index == opening + 1 };
                }
            }
            _ => {}
        }
        if token.kind.is_code() {
            goes_on = token.kind.goes_on();
        }
    }
    broken
}

impl<'p> LineBuilder<'p> {
    fn token(&mut self, index: usize) {
        let tokens = self.tokens;
        let token = &tokens[index];
        if token.kind.is_break() {
            self.line_end(index);
        } else if token.kind.is_comment() {
            if !self.in_line {
                self.begin_line(token);
            }
            if let Some(line) = self.lines.last_mut() {
                line.comment = Some(token);
            }
        } else if token.kind == TokenKind::Kept {
            self.end_line();
            self.begin_line(token);
            if let Some(line) = self.lines.last_mut() {
                line.kept = Some(&token.text);
            }
            self.last = Some(token);
            self.end_line();
        } else {
            if token.kind == TokenKind::Close && self.broken[index] {
                self.end_line();
            }
            self.code(index);
            if self.opens && tokens.get(index + 1).is_none_or(|next| !next.kind.is_comment()) {
                self.end_line();
            }
        }
    }

    fn line_end(&mut self, index: usize) {
        let closes = self.tokens.get(index + 1).is_some_and(|next| next.kind == TokenKind::Close);
        let follows_comment = index > 0 && self.tokens[index - 1].kind.is_comment();
        if closes && !self.broken[index + 1] && !follows_comment {
            return;
        }
        self.end_line();
        self.after_gap |= self.tokens[index].kind == TokenKind::Gap && !closes && !self.goes_on();
    }

    fn goes_on(&self) -> bool {
        self.last.is_some_and(|last| last.kind.goes_on())
    }

    fn innermost(&mut self) -> &mut OpenBracket<'p> {
        let last = self.open.len() - 1;
        &mut self.open[last]
    }

    fn begin_line(&mut self, token: &FormatToken) {
        let indent = self.indent(token);
        let goes_on = self.goes_on();
        let number = self.lines.len();
        let depth = self.open.len();
        let innermost = self.innermost();
        let starts_entry = innermost.is_brace && !goes_on && token.kind != TokenKind::Close && !token.kind.is_comment();
        let belongs_before = goes_on || !innermost.is_brace;
        let is_row = matches!(innermost.block, Block::Table(_)) && starts_entry;
        if starts_entry {
            innermost.entry_line = number;
            innermost.entry_tokens = 0;
        }
        let opens = self.lines.last().is_none_or(|line| line.opens);
        let after_gap = std::mem::take(&mut self.after_gap) && !opens;
        self.in_line = true;
        self.lines.push(CanonicalLine {
            indent,
            parts: Vec::new(),
            separator: if is_row { " | " } else { " " },
            comment: None,
            after_gap,
            goes_on: belongs_before,
            alignment: Alignment::Alone,
            kept: None,
            opens: false,
            starts_entry,
            depth,
        });
    }

    fn indent(&mut self, token: &FormatToken) -> Indent {
        let goes_on = self.goes_on();
        let open = self.innermost();
        if token.kind == TokenKind::Close {
            return match open.is_broken {
                true => Indent::Beyond { line: open.line, blanks: 0 },
                false => Indent::Below { line: open.line, part: open.part, byte: open.byte - 1 },
            };
        }
        match open.block {
            _ if !open.is_brace && !open.is_broken => {
                Indent::Below { line: open.line, part: open.part, byte: open.byte }
            }
            _ if open.is_brace && goes_on => Indent::Beyond { line: open.entry_line, blanks: LEVEL },
            Block::File => Indent::Margin,
            Block::Scene | Block::Wiring | Block::Table(_) | Block::Other => {
                Indent::Beyond { line: open.line, blanks: LEVEL }
            }
        }
    }

    fn end_line(&mut self) {
        if !std::mem::take(&mut self.in_line) {
            return;
        }
        let (depth, opens) = (self.open.len(), self.opens);
        let opens_block = opens && self.last.is_some_and(FormatToken::is_brace);
        let Some(line) = self.lines.last_mut() else { return };
        line.opens = opens && !line.parts.is_empty();
        let is_whole = match line.alignment {
            Alignment::Table(_) => depth == line.depth,
            Alignment::Alone | Alignment::Field | Alignment::Object(_) | Alignment::Device | Alignment::Wire => {
                line.parts.len() == 2 && !opens_block
            }
        };
        if !is_whole || line.parts.iter().any(String::is_empty) {
            line.alignment = Alignment::Alone;
        }
    }

    /// Adds a token of code to the line.
    fn code(&mut self, index: usize) {
        let tokens = self.tokens;
        let token = &tokens[index];
        let is_first = !self.in_line;
        if is_first {
            self.begin_line(token);
        }
        if token.kind == TokenKind::Close && self.open.len() > 1 {
            self.open.pop();
        }
        let is_bar = self.split_before(token);
        let is_apart = !is_first && self.is_apart(token);
        if let Some(line) = self.lines.last_mut() {
            if line.parts.is_empty() {
                line.parts.push(String::new());
            }
            if let Some(part) = line.parts.last_mut().filter(|_| !is_bar) {
                if is_apart && !part.is_empty() {
                    part.push(' ');
                }
                part.push_str(&token.text);
            }
        }
        self.count(token);
        if matches!(token.kind, TokenKind::Open | TokenKind::Joint) {
            self.open_bracket(token, self.broken[index]);
        }
        self.opens = matches!(token.kind, TokenKind::Open | TokenKind::Joint) && self.broken[index];
        self.last = Some(token);
    }

    /// Counts a token of the entry that is being read, and begins a second part after the name of a field.
    fn count(&mut self, token: &'p FormatToken<'p>) {
        let number = self.lines.len() - 1;
        let innermost = self.innermost();
        let ends_entry = innermost.is_brace && token.kind == TokenKind::Comma;
        if innermost.entry_tokens == 0 && !ends_entry {
            innermost.entry_word = &token.text;
            innermost.entry_line = number;
        }
        innermost.entry_tokens = if ends_entry { 0 } else { innermost.entry_tokens + 1 };
        let names_field = innermost.is_brace && token.kind == TokenKind::Colon && innermost.entry_tokens == 2;
        let Some(line) = self.lines.last_mut() else { return };
        if ends_entry && self.open.len() == line.depth && line.starts_entry {
            // A second entry follows on the line.
            line.alignment = Alignment::Alone;
            line.starts_entry = false;
        }
        if names_field && line.starts_entry && self.open.len() == line.depth && line.parts.len() == 1 {
            line.alignment = Alignment::Field;
            line.parts.push(String::new());
        }
    }

    /// Begins another part of the line before a token that may be aligned; returns whether the token is a bar, which
    /// separates the parts.
    fn split_before(&mut self, token: &FormatToken) -> bool {
        let depth = self.open.len();
        let innermost = self.innermost();
        let (block, word, count) = (innermost.block, innermost.entry_word, innermost.entry_tokens);
        let Some(line) = self.lines.last_mut() else { return false };
        if !line.starts_entry || depth != line.depth {
            return false;
        }
        let is_at = token.kind == TokenKind::Word && token.text == "at";
        let is_colon = token.kind == TokenKind::Colon;
        let alignment = match block {
            Block::Table(number) if token.kind == TokenKind::Bar => {
                if line.parts.is_empty() {
                    line.parts.push(String::new());
                }
                line.alignment = Alignment::Table(number);
                line.parts.push(String::new());
                return true;
            }
            Block::Scene if (is_colon || is_at) && count >= 2 && word != "for" => Alignment::Object(word),
            Block::File if is_colon && count == 2 && matches!(word, "device" | "instrument" | "output") => {
                Alignment::Device
            }
            Block::Wiring if token.kind == TokenKind::Arrow => Alignment::Wire,
            Block::File | Block::Scene | Block::Wiring | Block::Table(_) | Block::Other => return false,
        };
        if line.parts.len() == 1 {
            line.alignment = alignment;
            line.parts.push(String::new());
        }
        false
    }

    fn open_bracket(&mut self, token: &FormatToken, is_broken: bool) {
        let line = self.lines.len() - 1;
        let (part, byte) = match self.lines.last().map(|line| &line.parts) {
            Some(parts) => (parts.len() - 1, parts.last().map_or(0, String::len)),
            None => (0, 0),
        };
        let is_table = self.last.is_some_and(|last| last.kind == TokenKind::Word && last.text == "table");
        let outer = self.innermost();
        let block = match (outer.block, outer.entry_word) {
            _ if !token.is_brace() => Block::Other,
            _ if is_table => Block::Table(self.tables),
            (Block::File, "scene") | (Block::Scene, "for") => Block::Scene,
            (Block::File, "wiring") | (Block::Wiring, "for") => Block::Wiring,
            _ => Block::Other,
        };
        self.tables += usize::from(is_table);
        self.open.push(OpenBracket {
            is_brace: token.is_brace(),
            is_broken,
            block,
            line,
            part,
            byte,
            entry_line: line,
            entry_word: "",
            entry_tokens: 0,
        });
    }

    /// Whether there is a space between the last token of the line and this one.
    fn is_apart(&mut self, token: &FormatToken) -> bool {
        let Some(last) = self.last else { return false };
        let innermost = self.innermost();
        let names_field = !innermost.is_brace || innermost.entry_tokens == 1;
        if token.kind == TokenKind::Power {
            // Without the space, `^` would be part of the unit.
            self.is_power_apart = last.kind == TokenKind::Unit;
            return self.is_power_apart;
        }
        let clings = matches!(last.kind, TokenKind::Joint | TokenKind::Minus | TokenKind::Dot | TokenKind::Range);
        if clings || last.kind == TokenKind::Open && !last.is_brace() {
            return false;
        }
        match token.kind {
            TokenKind::Comma | TokenKind::Joint | TokenKind::Dot | TokenKind::Range => false,
            TokenKind::Close => token.text == "}",
            TokenKind::Colon => !names_field,
            _ => last.kind != TokenKind::Power || self.is_power_apart,
        }
    }
}
