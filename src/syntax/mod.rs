//! Parser: text to syntax tree.
//!
//! Input: the text of one file. Output: its [`Tree`] and, in the sink, one diagnostic for each mistake. Guarantee:
//! there is always a tree, every node's span lies in its parent's, and everything that could be read around a mistake
//! is in it.
//!
//! Parsing takes three passes. `scan` reads characters; it reports text that no grammar rule can recover from and
//! covers it. pest parses the rest with `grammar/*.pest`, whose lists end in catch-all rules. The `Reader` turns pest's
//! pairs into the tree and reports the faults in the parts that only the catch-all rules accepted.

mod brackets;
mod context;
mod cursor;
mod entries;
mod errors;
mod foreign_syntax;
mod foreign_words;
pub mod functions;
mod grammar;
mod heads;
mod items;
mod known_mistakes;
mod lexical;
mod loops;
mod reader;
mod recover;
mod repeated;
mod scan;
pub mod tree;
mod unexpected_tokens;
mod values;
mod words;

pub use words::RESERVED;
pub(crate) use words::{PARAMETER_SORTS, PREPOSITIONS, is_word};

use crate::diagnostic::{MAX_DIAGNOSTICS, Sink};
use crate::source::{FileId, Span};
use grammar::{Grammar, Rule};
use pest::Parser;
use reader::Reader;
use tree::{Expr, Tree};

/// Deepest nesting of brackets, braces and blocks.
pub const MAX_NESTING: usize = 64;

/// Greatest number of operators in one expression, including those of the enclosing brackets. Together with the nesting
/// limit it bounds the height of a tree.
pub const MAX_OPERATORS: usize = 256;

/// Greatest number of findings that a pass keeps for one text; the sink shows fewer.
const MAX_FINDINGS: usize = 4 * MAX_DIAGNOSTICS;

/// Parses one file.
pub fn parse(file: FileId, text: &str, sink: &mut Sink) -> Tree {
    if let Some(at) = text.find('\r').filter(|_| !text.contains('\n')).filter(|at| at + 1 < text.len()) {
        sink.push(known_mistakes::carriage_returns(Span::new(file, 0, at)));
        let whole = Span::new(file, 0, text.len());
        return Tree { file, doc: None, items: vec![tree::Item::Error(whole)], broken_names: Vec::new() };
    }
    let scanned = scan::scan(file, text);
    let mut reader = Reader::new(file, text, &scanned.text, scanned.findings);
    let node = Grammar::parse(Rule::file, &scanned.text).ok().and_then(|mut nodes| nodes.next());
    let (doc, items) = match node {
        Some(node) => reader.file(node),
        None => reader.unreadable(),
    };
    reader.misplaced_docs(&scanned.docs);
    reader.shorten(&items);
    let broken_names = std::mem::take(&mut reader.broken_names);
    reader.push_findings(sink);
    Tree { file, doc, items, broken_names }
}

/// Parses one value, as in `--set pitch=80um`; `None` if a diagnostic was pushed.
pub fn parse_value(file: FileId, text: &str, sink: &mut Sink) -> Option<Expr> {
    let scanned = scan::scan(file, text);
    let mut reader = Reader::new(file, text, &scanned.text, scanned.findings);
    let node = Grammar::parse(Rule::one_value, &scanned.text).ok().and_then(|mut nodes| nodes.next());
    let value = match node {
        Some(node) => reader.only_value(node),
        None => reader.no_value(),
    };
    if reader.push_findings(sink) { None } else { value }
}

#[cfg(test)]
mod tests;
