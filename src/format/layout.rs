//! Arranges pieces in lines: which pieces share a line, the spaces between them, and the indent of each line.

use super::piece::{PieceKind, TextPiece};

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
    pub comment: Option<&'p TextPiece<'p>>,
    /// Whether an empty line comes before it.
    pub after_gap: bool,
    /// Whether it continues the entry of the previous line.
    pub goes_on: bool,
    pub alignment: Alignment<'p>,
    /// Whole lines that stay as they are.
    pub kept: Option<&'p str>,
    /// Whether it ends with a bracket whose content begins on the next line.
    opens: bool,
    /// Whether it begins with the first piece of an entry.
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
    /// Number of pieces of the entry so far.
    entry_pieces: usize,
}

/// Arranges pieces in lines.
struct LineBuilder<'p> {
    pieces: &'p [TextPiece<'p>],
    /// For each bracket, whether its content is on lines of its own.
    broken: Vec<bool>,
    lines: Vec<CanonicalLine<'p>>,
    open: Vec<OpenBracket<'p>>,
    tables: usize,
    /// The last piece of code.
    last: Option<&'p TextPiece<'p>>,
    /// Whether the last line is still open for pieces.
    in_line: bool,
    /// Whether the last piece of code is a bracket whose content is on lines of its own.
    opens: bool,
    after_gap: bool,
    /// Whether the last `^` has spaces around it.
    is_power_apart: bool,
}

/// The lines of a text.
pub(super) fn lines<'p>(pieces: &'p [TextPiece<'p>]) -> Vec<CanonicalLine<'p>> {
    let file = OpenBracket {
        is_brace: true,
        is_broken: true,
        block: Block::File,
        line: 0,
        part: 0,
        byte: 0,
        entry_line: 0,
        entry_word: "",
        entry_pieces: 0,
    };
    let mut builder = LineBuilder {
        pieces,
        broken: broken_brackets(pieces),
        lines: Vec::new(),
        open: vec![file],
        tables: 0,
        last: None,
        in_line: false,
        opens: false,
        after_gap: false,
        is_power_apart: false,
    };
    for index in 0..pieces.len() {
        builder.piece(index);
    }
    builder.end_line();
    builder.lines
}

/// For each bracket, whether its content is on lines of its own: braces with a line end between entries, or with such
/// braces inside; other brackets with a line end after the opening one.
fn broken_brackets(pieces: &[TextPiece]) -> Vec<bool> {
    let mut broken = vec![false; pieces.len()];
    let mut open: Vec<usize> = Vec::new();
    let mut goes_on = false;
    for (index, piece) in pieces.iter().enumerate() {
        match piece.kind {
            PieceKind::Open | PieceKind::Joint => open.push(index),
            PieceKind::Close => {
                let Some(opening) = open.pop() else { continue };
                broken[index] = broken[opening];
                let outer = open.iter().rfind(|outer| pieces[**outer].is_brace());
                if let Some(&outer) = outer.filter(|_| broken[opening] && pieces[opening].is_brace()) {
                    broken[outer] = true;
                }
            }
            kind if !kind.is_code() => {
                if let Some(&opening) = open.last() {
                    broken[opening] |= if pieces[opening].is_brace() { !goes_on } else { index == opening + 1 };
                }
            }
            _ => {}
        }
        if piece.kind.is_code() {
            goes_on = piece.kind.goes_on();
        }
    }
    broken
}

impl<'p> LineBuilder<'p> {
    fn piece(&mut self, index: usize) {
        let pieces = self.pieces;
        let piece = &pieces[index];
        if piece.kind.is_break() {
            self.line_end(index);
        } else if piece.kind.is_comment() {
            if !self.in_line {
                self.begin_line(piece);
            }
            if let Some(line) = self.lines.last_mut() {
                line.comment = Some(piece);
            }
        } else if piece.kind == PieceKind::Kept {
            self.end_line();
            self.begin_line(piece);
            if let Some(line) = self.lines.last_mut() {
                line.kept = Some(&piece.text);
            }
            self.last = Some(piece);
            self.end_line();
        } else {
            if piece.kind == PieceKind::Close && self.broken[index] {
                self.end_line();
            }
            self.code(index);
            if self.opens && pieces.get(index + 1).is_none_or(|next| !next.kind.is_comment()) {
                self.end_line();
            }
        }
    }

    fn line_end(&mut self, index: usize) {
        let closes = self.pieces.get(index + 1).is_some_and(|next| next.kind == PieceKind::Close);
        let follows_comment = index > 0 && self.pieces[index - 1].kind.is_comment();
        if closes && !self.broken[index + 1] && !follows_comment {
            return;
        }
        self.end_line();
        self.after_gap |= self.pieces[index].kind == PieceKind::Gap && !closes && !self.goes_on();
    }

    fn goes_on(&self) -> bool {
        self.last.is_some_and(|last| last.kind.goes_on())
    }

    fn innermost(&mut self) -> &mut OpenBracket<'p> {
        let last = self.open.len() - 1;
        &mut self.open[last]
    }

    fn begin_line(&mut self, piece: &TextPiece) {
        let indent = self.indent(piece);
        let goes_on = self.goes_on();
        let number = self.lines.len();
        let depth = self.open.len();
        let innermost = self.innermost();
        let starts_entry = innermost.is_brace && !goes_on && piece.kind != PieceKind::Close && !piece.kind.is_comment();
        let belongs_before = goes_on || !innermost.is_brace;
        let is_row = matches!(innermost.block, Block::Table(_)) && starts_entry;
        if starts_entry {
            innermost.entry_line = number;
            innermost.entry_pieces = 0;
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

    fn indent(&mut self, piece: &TextPiece) -> Indent {
        let goes_on = self.goes_on();
        let open = self.innermost();
        if piece.kind == PieceKind::Close {
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
        let opens_block = opens && self.last.is_some_and(TextPiece::is_brace);
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

    /// Adds a piece of code to the line.
    fn code(&mut self, index: usize) {
        let pieces = self.pieces;
        let piece = &pieces[index];
        let is_first = !self.in_line;
        if is_first {
            self.begin_line(piece);
        }
        if piece.kind == PieceKind::Close && self.open.len() > 1 {
            self.open.pop();
        }
        let is_bar = self.split_before(piece);
        let is_apart = !is_first && self.is_apart(piece);
        if let Some(line) = self.lines.last_mut() {
            if line.parts.is_empty() {
                line.parts.push(String::new());
            }
            if let Some(part) = line.parts.last_mut().filter(|_| !is_bar) {
                if is_apart && !part.is_empty() {
                    part.push(' ');
                }
                part.push_str(&piece.text);
            }
        }
        self.count(piece);
        if matches!(piece.kind, PieceKind::Open | PieceKind::Joint) {
            self.open_bracket(piece, self.broken[index]);
        }
        self.opens = matches!(piece.kind, PieceKind::Open | PieceKind::Joint) && self.broken[index];
        self.last = Some(piece);
    }

    /// Counts a piece of the entry that is being read, and begins a second part after the name of a field.
    fn count(&mut self, piece: &'p TextPiece<'p>) {
        let number = self.lines.len() - 1;
        let innermost = self.innermost();
        let ends_entry = innermost.is_brace && piece.kind == PieceKind::Comma;
        if innermost.entry_pieces == 0 && !ends_entry {
            innermost.entry_word = &piece.text;
            innermost.entry_line = number;
        }
        innermost.entry_pieces = if ends_entry { 0 } else { innermost.entry_pieces + 1 };
        let names_field = innermost.is_brace && piece.kind == PieceKind::Colon && innermost.entry_pieces == 2;
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

    /// Begins another part of the line before a piece that may be aligned; returns whether the piece is a bar, which
    /// separates the parts.
    fn split_before(&mut self, piece: &TextPiece) -> bool {
        let depth = self.open.len();
        let innermost = self.innermost();
        let (block, word, count) = (innermost.block, innermost.entry_word, innermost.entry_pieces);
        let Some(line) = self.lines.last_mut() else { return false };
        if !line.starts_entry || depth != line.depth {
            return false;
        }
        let is_at = piece.kind == PieceKind::Word && piece.text == "at";
        let is_colon = piece.kind == PieceKind::Colon;
        let alignment = match block {
            Block::Table(number) if piece.kind == PieceKind::Bar => {
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
            Block::Wiring if piece.kind == PieceKind::Arrow => Alignment::Wire,
            Block::File | Block::Scene | Block::Wiring | Block::Table(_) | Block::Other => return false,
        };
        if line.parts.len() == 1 {
            line.alignment = alignment;
            line.parts.push(String::new());
        }
        false
    }

    fn open_bracket(&mut self, piece: &TextPiece, is_broken: bool) {
        let line = self.lines.len() - 1;
        let (part, byte) = match self.lines.last().map(|line| &line.parts) {
            Some(parts) => (parts.len() - 1, parts.last().map_or(0, String::len)),
            None => (0, 0),
        };
        let is_table = self.last.is_some_and(|last| last.kind == PieceKind::Word && last.text == "table");
        let outer = self.innermost();
        let block = match (outer.block, outer.entry_word) {
            _ if !piece.is_brace() => Block::Other,
            _ if is_table => Block::Table(self.tables),
            (Block::File, "scene") | (Block::Scene, "for") => Block::Scene,
            (Block::File, "wiring") | (Block::Wiring, "for") => Block::Wiring,
            _ => Block::Other,
        };
        self.tables += usize::from(is_table);
        self.open.push(OpenBracket {
            is_brace: piece.is_brace(),
            is_broken,
            block,
            line,
            part,
            byte,
            entry_line: line,
            entry_word: "",
            entry_pieces: 0,
        });
    }

    /// Whether there is a space between the last piece of the line and this one.
    fn is_apart(&mut self, piece: &TextPiece) -> bool {
        let Some(last) = self.last else { return false };
        let innermost = self.innermost();
        let names_field = !innermost.is_brace || innermost.entry_pieces == 1;
        if piece.kind == PieceKind::Power {
            // Without the space, `^` would be part of the unit.
            self.is_power_apart = last.kind == PieceKind::Unit;
            return self.is_power_apart;
        }
        let clings = matches!(last.kind, PieceKind::Joint | PieceKind::Minus | PieceKind::Dot | PieceKind::Range);
        if clings || last.kind == PieceKind::Open && !last.is_brace() {
            return false;
        }
        match piece.kind {
            PieceKind::Comma | PieceKind::Joint | PieceKind::Dot | PieceKind::Range => false,
            PieceKind::Close => piece.text == "}",
            PieceKind::Colon => !names_field,
            _ => last.kind != PieceKind::Power || self.is_power_apart,
        }
    }
}
