//! Text to tree.
//!
//! Input: the text of one file. Output: its [`Tree`] and, in the sink, one diagnostic for each mistake. Promise: there is
//! always a tree, every node's span lies in its parent's, and what could be read around a mistake is in it.
//!
//! The work is done in three passes. `scan` reads characters: it reports what no grammar can mend and covers it. pest reads
//! what is left by `grammar/*.pest`, whose lists end in rules that take everything. The `Reader` turns pest's pairs into the
//! tree and says what was wrong with the parts that only those rules could take.

mod entries;
mod errors;
mod grammar;
mod items;
mod reader;
mod recover;
mod scan;
pub mod tree;
mod values;

pub use values::MAX_OPERATORS;

use crate::diagnostic::Sink;
use crate::source::FileId;
use grammar::{Grammar, Rule};
use pest::Parser;
use reader::Reader;
use tree::{Expr, Tree};

/// The words that cannot be names.
pub const RESERVED: [&str; 20] = [
    "use", "as", "let", "device", "scene", "task", "program", "wiring", "table", "true", "false", "to", "from", "by",
    "about", "for", "at", "via", "with", "in",
];

fn is_reserved(word: &str) -> bool {
    RESERVED.contains(&word) || word == "on"
}

/// Reads one file.
pub fn parse(file: FileId, text: &str, sink: &mut Sink) -> Tree {
    let mut reader = Reader::new(file, text);
    let mut tree = Tree { file, doc: None, items: Vec::new() };
    if let Ok(mut nodes) = Grammar::parse(Rule::file, text) {
        if let Some(node) = nodes.next() {
            (tree.doc, tree.items) = reader.file(node);
        }
    }
    for finding in reader.findings {
        sink.push(finding);
    }
    tree
}

/// Reads one value, as in `--set pitch=80um`; `None` if a diagnostic was pushed.
pub fn parse_value(file: FileId, text: &str, sink: &mut Sink) -> Option<Expr> {
    let mut reader = Reader::new(file, text);
    let node = Grammar::parse(Rule::one_value, text).ok().and_then(|mut nodes| nodes.next());
    let value = node.and_then(|node| reader.only_value(node));
    for finding in reader.findings {
        sink.push(finding);
    }
    value
}

#[cfg(test)]
mod tests;
