//! Semantic tokens and folding ranges.
//!
//! Roles come from the words alone and not from the tree, so that colours stay while a line is being typed.

use super::outline;
use super::text::{ColumnUnit, EditedText};
use super::words::COMMON_STEPS;
use crate::check::frames;
use crate::device::Kind;
use crate::syntax::tree::{Entry, Item, SceneEntry, Tree, WiringEntry};
use crate::syntax::{RESERVED, is_word};
use lsp_types::{FoldingRange, FoldingRangeKind, SemanticToken, SemanticTokenType};
use std::collections::BTreeSet;
use std::ops::Range;

/// Token types, in the order of [`WordRole`].
pub const LEGEND: [SemanticTokenType; 9] = [
    SemanticTokenType::COMMENT,
    SemanticTokenType::STRING,
    SemanticTokenType::NUMBER,
    SemanticTokenType::KEYWORD,
    SemanticTokenType::PROPERTY,
    SemanticTokenType::TYPE,
    SemanticTokenType::FUNCTION,
    SemanticTokenType::NAMESPACE,
    SemanticTokenType::VARIABLE,
];

/// Role of a piece of text; the unit of a number belongs to the number.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum WordRole {
    Comment,
    Text,
    Number,
    Keyword,
    Property,
    Type,
    Function,
    Namespace,
    Variable,
}

/// A piece of one line; a sign is a piece that has no role and is not a word.
#[derive(Debug, Clone)]
struct Piece {
    bytes: Range<usize>,
    form: PieceForm,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum PieceForm {
    Comment,
    Text,
    Number,
    Word,
    Sign(char),
}

/// The coloured pieces, each relative to the one before it, as the protocol requires.
pub fn tokens(text: &EditedText, unit: ColumnUnit) -> Vec<SemanticToken> {
    let heads = heads();
    let width = |text: &str| match unit {
        ColumnUnit::Byte => text.len() as u32,
        ColumnUnit::Utf16 => text.encode_utf16().count() as u32,
    };
    let mut tokens = Vec::new();
    let mut depth = 0;
    // Lines since the last token.
    let mut delta_line = 0;
    for source in text.as_str().split_inclusive('\n') {
        let (mut delta_start, mut at) = (0, 0);
        for (bytes, role) in roles(source, &heads, &mut depth) {
            delta_start += width(&source[at..bytes.start]);
            let length = width(&source[bytes.clone()]);
            let token_type = role as u32;
            tokens.push(SemanticToken { delta_line, delta_start, length, token_type, token_modifiers_bitset: 0 });
            (delta_line, delta_start, at) = (0, 0, bytes.start);
        }
        delta_line += 1;
    }
    tokens
}

/// The words that begin an entry of a block.
fn heads() -> BTreeSet<&'static str> {
    let of_kinds = Kind::ALL.iter().flat_map(|kind| {
        let vocabulary = kind.vocabulary();
        let verbs = vocabulary.verbs_and_conditions().flat_map(|verb| std::iter::once(verb.name).chain(verb.noun));
        verbs.chain(vocabulary.nouns.iter().map(|noun| noun.name))
    });
    COMMON_STEPS.iter().map(|(word, _)| *word).chain(["start", "run", frames::NOUN]).chain(of_kinds).collect()
}

/// The pieces of a line that have a role. `depth` is the number of open round and square brackets; it is updated over
/// the line.
fn roles(line: &str, heads: &BTreeSet<&str>, depth: &mut usize) -> Vec<(Range<usize>, WordRole)> {
    let pieces = pieces(line);
    let word = |piece: &Piece| &line[piece.bytes.clone()];
    let mut found: Vec<(Range<usize>, WordRole)> = Vec::new();
    // The declaration word or noun that the entry begins with, and whether its colon has been passed.
    let (mut declares, mut is_based) = (None, false);
    for (at, piece) in pieces.iter().enumerate() {
        let before = at.checked_sub(1).map(|before| &pieces[before]);
        let after = pieces.get(at + 1).map(|after| after.form);
        let is_head =
            *depth == 0 && before.is_none_or(|before| matches!(before.form, PieceForm::Sign('{' | '}' | ',')));
        let role = match piece.form {
            PieceForm::Comment => WordRole::Comment,
            PieceForm::Text => WordRole::Text,
            PieceForm::Number => WordRole::Number,
            PieceForm::Sign(sign) => {
                match sign {
                    '(' | '[' => *depth += 1,
                    ')' | ']' => *depth = depth.saturating_sub(1),
                    ':' => is_based = declares.is_some(),
                    '{' | '}' | ',' if *depth == 0 => (declares, is_based) = (None, false),
                    _ => {}
                }
                continue;
            }
            PieceForm::Word if is_head && after == Some(PieceForm::Sign(':')) => WordRole::Property,
            PieceForm::Word if is_unit(line, &pieces, at, &found) => WordRole::Number,
            PieceForm::Word if is_head && (heads.contains(word(piece)) || RESERVED.contains(&word(piece))) => {
                declares = Some(word(piece));
                WordRole::Keyword
            }
            PieceForm::Word if RESERVED.contains(&word(piece)) => {
                is_based = false;
                WordRole::Keyword
            }
            PieceForm::Word if is_based => WordRole::Type,
            PieceForm::Word if declares == Some("use") => WordRole::Namespace,
            PieceForm::Word => named(before.map(word), after, heads, word(piece)),
        };
        found.push((piece.bytes.clone(), role));
    }
    found
}

/// Role of a word that the language does not have, by its neighbours.
fn named(before: Option<&str>, after: Option<PieceForm>, heads: &BTreeSet<&str>, own: &str) -> WordRole {
    match (before, after) {
        (Some("task" | "program" | "run"), _) => WordRole::Function,
        (Some("device" | "instrument" | "output"), _) => WordRole::Type,
        (Some("minimize" | "require" | "using"), _) => WordRole::Property,
        (Some("scene" | "let" | "on" | "in" | "wiring"), _) => WordRole::Variable,
        // The noun of a verb, as in `apply state 2`.
        (Some(before), Some(PieceForm::Number)) if heads.contains(before) && heads.contains(own) => WordRole::Keyword,
        (_, Some(PieceForm::Sign('('))) => WordRole::Function,
        (_, Some(PieceForm::Sign('{'))) => WordRole::Type,
        _ => WordRole::Variable,
    }
}

/// Whether a word is the unit of a number before it, or continues one: `35 um`, `3 N*m`, `2 s^-1`.
fn is_unit(line: &str, pieces: &[Piece], at: usize, found: &[(Range<usize>, WordRole)]) -> bool {
    let gap = |one: &Piece, other: &Piece| &line[one.bytes.end..other.bytes.start];
    let Some(before) = at.checked_sub(1).map(|before| &pieces[before]) else { return false };
    match before.form {
        PieceForm::Number => gap(before, &pieces[at]) == " " && !RESERVED.contains(&&line[pieces[at].bytes.clone()]),
        PieceForm::Sign('*' | '/') => {
            let is_joined = |first: &Piece| gap(first, before).is_empty() && gap(before, &pieces[at]).is_empty();
            let first = at.checked_sub(2).map(|first| &pieces[first]).filter(|first| is_joined(first));
            let last = found.last().filter(|_| first.is_some_and(|first| first.form == PieceForm::Word));
            last.is_some_and(|(_, role)| *role == WordRole::Number)
        }
        PieceForm::Comment | PieceForm::Text | PieceForm::Word | PieceForm::Sign(_) => false,
    }
}

/// The pieces of a line, without spaces.
fn pieces(line: &str) -> Vec<Piece> {
    let mut pieces = Vec::new();
    let mut at = 0;
    while let Some(first) = line[at..].chars().next() {
        let rest = &line[at..];
        let (length, form) = match first {
            _ if rest.starts_with("//") => (rest.trim_end().len(), PieceForm::Comment),
            '"' => (string(rest), PieceForm::Text),
            '0'..='9' => (number(rest), PieceForm::Number),
            first if is_word(first) || first == '%' => {
                (rest.find(|c| !is_word(c) && c != '%').unwrap_or(rest.len()), PieceForm::Word)
            }
            first => (first.len_utf8(), PieceForm::Sign(first)),
        };
        if !first.is_whitespace() {
            pieces.push(Piece { bytes: at..at + length, form });
        }
        at += length;
    }
    pieces
}

/// Length of a string; an unclosed string extends to the end of the line.
fn string(rest: &str) -> usize {
    rest[1..].find('"').map_or(rest.trim_end().len(), |end| end + 2)
}

/// Length of a number: a word of bits, or digits, a fraction and an exponent.
fn number(rest: &str) -> usize {
    let digits = |text: &str| text.find(|c: char| !c.is_ascii_digit() && c != '_').unwrap_or(text.len());
    if let Some(bits) = rest.strip_prefix("0b") {
        return 2 + digits(bits);
    }
    let mut end = digits(rest);
    let fraction = rest[end..].strip_prefix('.').map_or(0, digits);
    end += if fraction > 0 { fraction + 1 } else { 0 };
    if let Some(exponent) = rest[end..].strip_prefix(['e', 'E']) {
        let sign = usize::from(exponent.starts_with(['+', '-']));
        let length = digits(&exponent[sign..]);
        end += if length > 0 { 1 + sign + length } else { 0 };
    }
    end
}

/// Folds for blocks of more than one line and for comments before declarations.
pub fn folds(text: &EditedText) -> Vec<FoldingRange> {
    let tree = outline::tree(text.as_str());
    let mut folds: Vec<FoldingRange> = blocks(&tree)
        .into_iter()
        .filter_map(|bytes| {
            // The line with the closing bracket stays visible.
            let [from, to] = [bytes.start, bytes.end].map(|at| text.position(at, ColumnUnit::Byte).line);
            (to > from + 1).then(|| fold(from, to - 1, None))
        })
        .collect();
    let is_comment = |line: &str| line.trim_start().starts_with("//");
    let mut since = None;
    for (number, line) in (0..).zip(text.as_str().lines().chain([""])) {
        match (is_comment(line), since) {
            (true, None) => since = Some(number),
            (false, Some(first)) => {
                folds.extend((number > first + 1).then(|| fold(first, number - 1, Some(FoldingRangeKind::Comment))));
                since = None;
            }
            (true, Some(_)) | (false, None) => {}
        }
    }
    folds.sort_by_key(|fold| (fold.start_line, fold.end_line));
    folds
}

fn fold(start_line: u32, end_line: u32, kind: Option<FoldingRangeKind>) -> FoldingRange {
    FoldingRange { start_line, end_line, kind, ..FoldingRange::default() }
}

/// The ranges of the declarations and of the blocks in them.
fn blocks(tree: &Tree) -> Vec<Range<usize>> {
    let mut found = Vec::new();
    for item in &tree.items {
        found.push(item.span().range());
        match item {
            Item::Scene(scene) => scene_blocks(&scene.entries, &mut found),
            Item::Task(task) => step_blocks(&task.entries, &mut found),
            Item::Program(program) => step_blocks(&program.entries, &mut found),
            Item::Wiring(wiring) => wire_blocks(&wiring.entries, &mut found),
            Item::Use(_) | Item::Let(_) | Item::Device(_) | Item::Instrument(_) | Item::Output(_) | Item::Error(_) => {}
        }
    }
    found
}

fn scene_blocks(entries: &[SceneEntry], found: &mut Vec<Range<usize>>) {
    for entry in entries {
        if let SceneEntry::For(each) = entry {
            found.push(each.span.range());
            scene_blocks(&each.entries, found);
        }
    }
}

fn step_blocks(entries: &[Entry], found: &mut Vec<Range<usize>>) {
    for entry in entries {
        let (span, inner) = match entry {
            Entry::For(each) => (each.span, Some(&each.entries)),
            Entry::Step(step) => (step.span, step.block.as_ref()),
            Entry::Field(field) => (field.span, None),
            Entry::Error(_) => continue,
        };
        found.push(span.range());
        inner.into_iter().for_each(|inner| step_blocks(inner, found));
    }
}

fn wire_blocks(entries: &[WiringEntry], found: &mut Vec<Range<usize>>) {
    for entry in entries {
        if let WiringEntry::For(each) = entry {
            found.push(each.span.range());
            wire_blocks(&each.entries, found);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A line with a letter under each coloured piece.
    fn drawn(line: &str) -> String {
        let mut letters = vec![' '; line.chars().count()];
        for (bytes, role) in roles(line, &heads(), &mut 0) {
            let letter = match role {
                WordRole::Comment => 'c',
                WordRole::Text => 's',
                WordRole::Number => 'n',
                WordRole::Keyword => 'k',
                WordRole::Property => 'p',
                WordRole::Type => 't',
                WordRole::Function => 'f',
                WordRole::Namespace => 'u',
                WordRole::Variable => 'v',
            };
            let first = line[..bytes.start].chars().count();
            letters[first..first + line[bytes].chars().count()].fill(letter);
        }
        letters.into_iter().collect::<String>().trim_end().to_owned()
    }

    #[test]
    fn every_word_has_its_colour() {
        let lines = [
            ("use std.dimibot as d  // where", "kkk uuu uuuuuuu kk u  cccccccc"),
            ("use \"bench.twz\" as lab", "kkk sssssssssss kk uuu"),
            ("let spots = [(1, 2), (3 um, -4.5e-3 µm)]", "kkk vvvvv     n  n    n nn   nnnnnn nn"),
            ("device bot : d.femto_st { left: 5 }", "kkkkkk ttt   t tttttttt   pppp  n"),
            ("scene dusty : bench {", "kkkkk vvvvv   ttttt"),
            (
                "  obstacle bead : disc { radius: 0.8 um } at (4.0 um, 2)",
                "  kkkkkkkk vvvv   tttt   pppppp  nnn nn   kk  nnn nn  n",
            ),
            ("task go(p: cell) on bot in dusty {", "kkkk ff v  tttt  kk vvv kk vvvvv"),
            ("  minimize distance", "  kkkkkkkk pppppppp"),
            ("  precision: 3 N*m / 2 s^-1", "  ppppppppp  n n n   n n  n"),
            ("  move m1 to p + (2 * a, b[1]) via low", "  kkkk vv kk v    n   v  v n   kkk vvv"),
            ("  merge a with b at (1, 2), wait 5 ms", "  kkkkk v kkkk v kk  n  n   kkkk n nn"),
            ("  apply state 0b1_01 for 2 s", "  kkkkk kkkkk nnnnnn kkk n n"),
            ("  run go((1, 1))", "  kkk ff  n  n"),
            ("  separation: 2 % // %", "  pppppppppp  n n cccc"),
        ];
        let drawn: Vec<String> = lines.iter().map(|(line, _)| drawn(line)).collect();
        let expected: Vec<&str> = lines.iter().map(|(_, expected)| *expected).collect();
        assert_eq!(drawn, expected);
    }

    #[test]
    fn broken_lines_are_coloured_too() {
        let lines =
            [("move m1 to \"(", "kkkk vv kk ss"), ("0b 1e 2..3 😀 é", "nn nv n  n   v"), ("{ , : for", "      kkk")];
        for (line, expected) in lines {
            assert_eq!(drawn(line), expected, "{line}");
        }
    }
}
