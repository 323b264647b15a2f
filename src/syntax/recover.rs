//! Fragments that no rule could read: what to say of them.

use super::errors::{self, Place};
use super::grammar::Node;
use super::reader::Reader;
use super::tree::{Doc, Item};
use crate::diagnostic::{Code, Diagnostic};

impl Reader<'_> {
    pub fn bad_entry(&mut self, node: &Node, place: Place) {
        if Self::has_hole(node) {
            return;
        }
        let span = self.span(node);
        self.report(
            Diagnostic::new(Code::E0101, format!("`{}` cannot be read", errors::quote(node.as_str().trim_end())))
                .label(span, format!("expected {}", place.wants())),
        );
    }

    pub fn bad_item(&mut self, node: &Node, _doc: Doc) -> Option<Item> {
        self.bad_entry(node, Place::Top);
        None
    }
}
