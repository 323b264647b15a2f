//! Document symbols and code lenses of a text, and its canonical form.

use super::text::{ColumnUnit, EditedText};
use crate::check::scope::path_text;
use crate::diagnostic::Sink;
use crate::source::{Sources, Span};
use crate::syntax::tree::{Item, Runnable, Tree};
use crate::{format, syntax};
use lsp_types::{CodeLens, Command, DocumentSymbol, SymbolKind, Uri};
use serde_json::json;

/// The tree of a text on its own, without the files that it uses.
pub fn tree(text: &str) -> Tree {
    let file = Sources::default().add("", text);
    syntax::parse(file, text, &mut Sink::default())
}

/// The canonical form; parts with syntax errors stay as they are.
pub fn canonical(text: &str) -> String {
    let file = Sources::default().add("", text);
    format::format(file, text, &mut Sink::default())
}

/// The declarations of a text, in order.
pub fn symbols(text: &EditedText, unit: ColumnUnit) -> Vec<DocumentSymbol> {
    let symbol = |name: &str, detail: &str, kind: SymbolKind, [whole, word]: [Span; 2]| {
        let [range, selection_range] = [whole, word].map(|span| text.range(span.range(), unit));
        // The protocol deprecates this field, but the struct still requires it.
        #[allow(deprecated)]
        DocumentSymbol {
            name: name.to_owned(),
            detail: Some(detail.to_owned()),
            kind,
            tags: None,
            deprecated: None,
            range,
            selection_range,
            children: None,
        }
    };
    let of = |item: &Item| match item {
        Item::Let(item) => Some(symbol(&item.name.text, "let", SymbolKind::CONSTANT, [item.span, item.name.span])),
        Item::Device(item) => Some(symbol(&item.name.text, "device", SymbolKind::CLASS, [item.span, item.name.span])),
        Item::Instrument(item) => {
            Some(symbol(&item.name.text, "instrument", SymbolKind::INTERFACE, [item.span, item.name.span]))
        }
        Item::Output(item) => Some(symbol(&item.name.text, "output", SymbolKind::EVENT, [item.span, item.name.span])),
        Item::Scene(item) => Some(symbol(&item.name.text, "scene", SymbolKind::NAMESPACE, [item.span, item.name.span])),
        Item::Task(item) => Some(symbol(&item.name.text, "task", SymbolKind::FUNCTION, [item.span, item.name.span])),
        Item::Program(item) => {
            Some(symbol(&item.name.text, "program", SymbolKind::MODULE, [item.span, item.name.span]))
        }
        Item::Wiring(item) => {
            Some(symbol(&path_text(&item.device), "wiring", SymbolKind::OBJECT, [item.span, item.device.span]))
        }
        Item::Use(_) | Item::Error(_) => None,
    };
    // The protocol forbids empty names; a declaration with an error may have one.
    tree(text.as_str()).items.iter().filter_map(of).filter(|symbol| !symbol.name.is_empty()).collect()
}

/// Titles and client commands of the lenses: `tweeze build FILE --task NAME`, and the same with `view`.
const LENSES: [(&str, &str); 2] = [("Build", "tweeze.build"), ("View", "tweeze.view")];

/// The lenses of each task and program, with the document and the name as arguments. Those with parameters get none,
/// because they are built by the programs that run them.
pub fn lenses(text: &EditedText, uri: &Uri, unit: ColumnUnit) -> Vec<CodeLens> {
    let tree = tree(text.as_str());
    let alone = tree.items.iter().filter_map(Item::runnable).filter(|head| head.parameters.is_empty());
    let named = alone.filter(|head| !head.name.text.is_empty());
    let of = |head: Runnable| {
        let range = text.range(head.name.span.range(), unit);
        LENSES.map(|(title, command)| CodeLens {
            range,
            command: Some(Command {
                title: title.to_owned(),
                command: command.to_owned(),
                arguments: Some(vec![json!(uri), json!(head.name.text)]),
            }),
            data: None,
        })
    };
    named.flat_map(of).collect()
}
