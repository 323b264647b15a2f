//! Turns pest's pairs into the tree: the shared parts of the walk.
//!
//! Input: the pairs of one text. Output: tree nodes with owned spans, and findings. Guarantee: one finding for every
//! mark that the grammar left where it recovered from a mistake, and none for text that `scan` has covered.

use super::cursor::HOLE;
use super::grammar::{Node, Rule};
use super::tree::{Doc, Expr, ExprKind, Ident, Item};
use super::words::RESERVED;
use super::{MAX_FINDINGS, errors};
use crate::diagnostic::{Code, Diagnostic, Sink};
use crate::source::{FileId, Span};

/// Least number of unreadable items, with no readable one, at which a file is not taken for a program.
const FOREIGN_LINES: usize = 5;

/// The length of `///` and of `//!`.
const DOC_MARK_BYTES: usize = 3;

/// Where a parsed fragment comes from.
#[derive(Clone, Copy)]
pub(super) struct FragmentOrigin<'s> {
    file: FileId,
    source: &'s str,
    /// Offset in the text at which the fragment begins.
    pub base: usize,
}

impl FragmentOrigin<'_> {
    /// The span of a node, widened to whole characters: the scan may have put a short spelling over a long character.
    pub fn span(self, node: &Node) -> Span {
        let span = node.as_span();
        let start = self.source.floor_char_boundary(self.base + span.start());
        let end = self.source.ceil_char_boundary(self.base + span.end());
        Span::new(self.file, start, end)
    }
}

/// Walks the pairs of one text.
pub(super) struct Reader<'s> {
    pub file: FileId,
    /// The whole text as written, for messages.
    pub source: &'s str,
    /// The whole text, with holes over unreadable parts.
    pub text: &'s str,
    pub origin: FragmentOrigin<'s>,
    pub findings: Vec<Diagnostic>,
    /// Offsets of the doc comments that belong to a declaration, in order.
    pub attached_docs: Vec<usize>,
    /// The names that unreadable declarations would have declared.
    pub broken_names: Vec<Ident>,
    /// Number of operators in the expressions that are open.
    pub operators: usize,
    /// Offset up to which entries are already covered by one finding about a whole step.
    pub covered_until: u32,
}

impl<'s> Reader<'s> {
    pub fn new(file: FileId, source: &'s str, text: &'s str, findings: Vec<Diagnostic>) -> Self {
        Reader {
            file,
            source,
            text,
            origin: FragmentOrigin { file, source, base: 0 },
            findings,
            attached_docs: Vec::new(),
            broken_names: Vec::new(),
            operators: 0,
            covered_until: 0,
        }
    }

    pub fn report(&mut self, finding: Diagnostic) {
        if !self.is_full() {
            self.findings.push(finding);
        }
    }

    /// Whether a further finding would be dropped.
    pub fn is_full(&self) -> bool {
        self.findings.len() >= MAX_FINDINGS
    }

    pub fn span(&self, node: &Node) -> Span {
        self.origin.span(node)
    }

    /// The node's children without comments and marks; marks are reported on the way.
    pub fn children<'i>(&mut self, node: Node<'i>) -> Vec<Node<'i>> {
        let mut children: Vec<Node> = node.into_inner().collect();
        children.retain(|child| !self.is_mark(child));
        children
    }

    /// Whether a node is a mark or irrelevant; a mark for something missing is reported.
    pub fn is_mark(&mut self, node: &Node) -> bool {
        let finding: fn(Span, &str) -> Diagnostic = match node.as_rule() {
            Rule::comment_text | Rule::stray_doc | Rule::file_docs => return true,
            Rule::late => errors::late_brace,
            Rule::leading_operator => errors::leading_operator,
            Rule::leading_preposition => errors::leading_preposition,
            Rule::blank_before => errors::blank_before_bracket,
            Rule::wrong_colon => errors::wrong_colon,
            Rule::wrong_equals => errors::wrong_equals,
            Rule::joined | Rule::joined_item => errors::joined,
            _ => return false,
        };
        let finding = finding(self.span(node), self.source);
        self.report(finding);
        true
    }

    pub fn ident(&self, node: &Node) -> Ident {
        Ident { text: node.as_str().to_owned(), span: self.span(node) }
    }

    /// Reads a name that is declared here and so must not be reserved.
    pub fn declared(&mut self, node: &Node) -> Ident {
        let ident = self.ident(node);
        if RESERVED.contains(&ident.text.as_str()) {
            self.report(errors::reserved_name(&ident));
        }
        ident
    }

    /// Reads the doc comments of the next node.
    pub fn doc(&mut self, node: Node) -> Doc {
        let mut lines = Vec::new();
        for line in node.into_inner().filter(|line| line.as_rule() == Rule::doc_text) {
            self.attached_docs.push(self.origin.base + line.as_span().start() - DOC_MARK_BYTES);
            let words = line.as_str().trim_end();
            lines.push(words.strip_prefix(' ').unwrap_or(words).to_owned());
        }
        (!lines.is_empty()).then(|| lines.join("\n"))
    }

    /// Reports a missing value, and returns an error expression in its place.
    pub fn missing(&mut self, node: &Node) -> Expr {
        let span = self.span(node);
        let finding = errors::missing_value(span, self.source);
        self.report(finding);
        Expr { kind: ExprKind::Error, span }
    }

    /// Reports the doc comments that belong to no declaration.
    pub fn misplaced_docs(&mut self, docs: &[Span]) {
        self.attached_docs.sort_unstable();
        for &doc in docs {
            if self.attached_docs.binary_search(&(doc.start as usize)).is_err() {
                self.report(errors::misplaced_doc(doc, self.source));
            }
        }
    }

    /// Replaces the findings of a file that is not a program at all by a single one.
    pub fn shorten(&mut self, items: &[Item]) {
        // If a broken declaration has kept its name, the file is a program.
        let is_foreign = items.len() >= FOREIGN_LINES && self.broken_names.is_empty();
        let is_foreign = is_foreign && items.iter().all(|item| matches!(item, Item::Error(_)));
        let first = self.findings.iter().find(|finding| finding.code == Code::E0101).and_then(Diagnostic::span);
        if let Some(first) = first.filter(|_| is_foreign) {
            self.findings = vec![super::known_mistakes::not_a_program(first)];
        }
    }

    /// Passes the findings on to the sink; returns whether there is an error among them.
    pub fn push_findings(self, sink: &mut Sink) -> bool {
        let mut findings = self.findings;
        findings.sort_by_key(|finding| finding.span().map(|span| span.start));
        let has_error = findings.iter().any(Diagnostic::is_error);
        for finding in super::repeated::joined(findings) {
            sink.push(finding);
        }
        has_error
    }

    /// Whether the scan has already reported something inside this node.
    pub fn has_hole(node: &Node) -> bool {
        node.as_str().contains(HOLE)
    }
}
