//! Declarations at the top of a file.

use super::context;
use super::errors;
use super::grammar::{Node, Rule};
use super::heads;
use super::known_mistakes;
use super::reader::Reader;
use super::tree::{
    Device, Doc, ExprKind, Ident, Item, Let, Parameter, Path, Program, Scene, Task, Use, UsePath, Wiring,
};
use crate::diagnostic::{Code, Diagnostic};
use crate::source::Span;

/// The parts of a declaration; they may come in any order.
#[derive(Default)]
struct DeclarationHead<'i> {
    name: Option<Ident>,
    paths: Vec<Path>,
    scene: Option<Path>,
    parameters: Vec<Parameter>,
    block: Option<Node<'i>>,
    is_broken: bool,
}

impl Reader<'_> {
    /// Reads the items of a file and its own doc comment.
    pub fn file(&mut self, node: Node) -> (Doc, Vec<Item>) {
        let file_doc = node.clone().into_inner().find(|child| child.as_rule() == Rule::file_docs);
        let file_doc = file_doc.and_then(|docs| self.doc(docs));
        let mut items = Vec::new();
        let mut doc = None;
        for child in self.children(node) {
            match child.as_rule() {
                Rule::docs => doc = Some(child),
                Rule::EOI => {}
                Rule::bad_item if self.belongs_to_let(&child, items.last_mut()) => {}
                _ => {
                    let takes_doc = child.as_rule() != Rule::use_item;
                    let doc = doc.take().filter(|_| takes_doc).and_then(|docs| self.doc(docs));
                    items.push(self.item(child, doc));
                }
            }
        }
        (file_doc, items)
    }

    /// Whether an unreadable item continues the value of the `let` before it, which lacks its brackets. If so, it is
    /// reported and that value becomes an error.
    fn belongs_to_let(&mut self, node: &Node, last: Option<&mut Item>) -> bool {
        let Some(Item::Let(Let { value, .. })) = last else { return false };
        let Some(finding) = known_mistakes::let_without_brackets(value.span, self.span(node), self.source) else {
            return false;
        };
        self.report(finding);
        value.kind = ExprKind::Error;
        true
    }

    fn item(&mut self, node: Node, doc: Doc) -> Item {
        let span = self.span(&node);
        let item = match node.as_rule() {
            Rule::use_item
            | Rule::let_item
            | Rule::device
            | Rule::instrument
            | Rule::output
            | Rule::scene
            | Rule::task
            | Rule::program
            | Rule::wiring => {
                let rest = self.children(node).pop();
                rest.and_then(|rest| self.declaration(rest, doc, span))
            }
            Rule::stray_loop => {
                self.report(errors::loop_at_top(span));
                None
            }
            _ => self.bad_item(&node, doc),
        };
        item.unwrap_or(Item::Error(span))
    }

    /// Reads a declaration from after its first word.
    pub fn declaration(&mut self, rest: Node, doc: Doc, span: Span) -> Option<Item> {
        let rule = rest.as_rule();
        match rule {
            Rule::use_rest => return self.use_item(rest, span).map(Item::Use),
            Rule::let_rest => return self.let_item(rest, doc, span).map(Item::Let),
            _ => {}
        }
        let head = self.head(rest, span);
        match rule {
            Rule::device_rest => self.device(head, doc, span).map(Item::Device),
            Rule::instrument_rest => self.device(head, doc, span).map(Item::Instrument),
            Rule::output_rest => self.device(head, doc, span).map(Item::Output),
            Rule::scene_rest => self.scene(head, doc, span).map(Item::Scene),
            Rule::task_rest => self.task(head, doc, span).map(Item::Task),
            Rule::program_rest => self.program(head, doc, span).map(Item::Program),
            _ => self.wiring(head, doc, span).map(Item::Wiring),
        }
    }

    fn head<'i>(&mut self, rest: Node<'i>, span: Span) -> DeclarationHead<'i> {
        let mut head = DeclarationHead::default();
        let rule = rest.as_rule();
        for part in self.children(rest) {
            match part.as_rule() {
                // `device device left : …`: the rest is read once the word is gone.
                Rule::name if part.as_str() == context::token_at(self.source, span.start as usize) => {
                    let twice = self.span(&part);
                    self.report(heads::word_twice(twice, self.source));
                    return DeclarationHead { is_broken: true, ..DeclarationHead::default() };
                }
                Rule::name => head.name = Some(self.declared(&part)),
                Rule::path => {
                    let path = self.path(part);
                    head.paths.push(path);
                }
                Rule::scene_path => {
                    head.scene = self.children(part).pop().map(|path| self.path(path));
                }
                Rule::parameters => {
                    let parameters = self.children(part);
                    head.parameters = parameters.into_iter().filter_map(|part| self.parameter(part)).collect();
                }
                Rule::fields | Rule::scene_block | Rule::block | Rule::wiring_block => head.block = Some(part),
                _ => {
                    head.is_broken = true;
                    if !Self::has_hole(&part) && !self.is_full() {
                        let rest = self.span(&part);
                        if self.is_reserved_name(rest) {
                            continue;
                        }
                        let slip = heads::diagnose(rest, rule, span, self.source);
                        let finding = slip.unwrap_or_else(|| errors::bad_head(rest, rule, span, self.source));
                        self.keep_mended_name(&finding);
                        if finding.fix.iter().any(|edit| edit.text == " {") {
                            self.forget_stray_brace(rest.start);
                        }
                        self.report(finding);
                    }
                }
            }
        }
        head
    }

    /// Whether the head ends with a reserved word that was already reported where it was declared.
    fn is_reserved_name(&self, rest: Span) -> bool {
        let last = self.source[rest.range()].split_whitespace().next_back().unwrap_or_default();
        let is_declared = |finding: &Diagnostic| {
            finding.code == Code::E0110 && finding.span().is_some_and(|place| self.source[place.range()] == *last)
        };
        super::RESERVED.contains(&last) && self.findings.iter().any(is_declared)
    }

    fn parameter(&mut self, node: Node) -> Option<Parameter> {
        let span = self.span(&node);
        let mut parts = self.children(node).into_iter();
        let name = parts.next().map(|name| self.declared(&name))?;
        let sort = parts.next().map(|sort| self.ident(&sort))?;
        Some(Parameter { name, sort, span })
    }

    /// The name of a valid declaration. The name of a broken one is kept in `broken_names`, so that it is not reported
    /// as unknown.
    fn name_of(&mut self, head: &mut DeclarationHead) -> Option<Ident> {
        let name = head.name.take()?;
        if head.is_broken {
            self.broken_names.push(name);
            return None;
        }
        Some(name)
    }

    fn device(&mut self, mut head: DeclarationHead, doc: Doc, span: Span) -> Option<Device> {
        let fields = head.block.take().map(|block| self.fields(block)).unwrap_or_default();
        let name = self.name_of(&mut head)?;
        Some(Device { doc, name, base: head.paths.pop()?, fields, span })
    }

    fn scene(&mut self, mut head: DeclarationHead, doc: Doc, span: Span) -> Option<Scene> {
        let entries = head.block.take().map(|block| self.scene_entries(block)).unwrap_or_default();
        let name = self.name_of(&mut head)?;
        Some(Scene { doc, name, base: head.paths.pop(), entries, span })
    }

    fn task(&mut self, mut head: DeclarationHead, doc: Doc, span: Span) -> Option<Task> {
        let entries = head.block.take().map(|block| self.entries(block)).unwrap_or_default();
        let name = self.name_of(&mut head)?;
        let device = head.paths.pop()?;
        Some(Task { doc, name, parameters: head.parameters, device, scene: head.scene, entries, span })
    }

    fn program(&mut self, mut head: DeclarationHead, doc: Doc, span: Span) -> Option<Program> {
        let entries = head.block.take().map(|block| self.entries(block)).unwrap_or_default();
        let name = self.name_of(&mut head)?;
        Some(Program { doc, name, parameters: head.parameters, entries, span })
    }

    fn wiring(&mut self, mut head: DeclarationHead, doc: Doc, span: Span) -> Option<Wiring> {
        let entries = head.block.take().map(|block| self.wires(block)).unwrap_or_default();
        Some(Wiring { doc, device: head.paths.pop()?, entries, span })
    }

    fn use_item(&mut self, node: Node, span: Span) -> Option<Use> {
        let mut path = None;
        let mut alias = None;
        for part in self.children(node) {
            match part.as_rule() {
                Rule::library => {
                    let span = self.span(&part);
                    let words = part.into_inner().map(|word| self.ident(&word)).collect();
                    path = Some(UsePath::Library { words, span });
                }
                Rule::text => path = Some(UsePath::File(self.text(part))),
                Rule::name => alias = Some(self.declared(&part)),
                _ => {}
            }
        }
        Some(Use { path: path?, alias, span })
    }

    fn let_item(&mut self, node: Node, doc: Doc, span: Span) -> Option<Let> {
        let mut parts = self.children(node).into_iter();
        let name = parts.next().map(|name| self.declared(&name))?;
        let value = self.value(parts.next(), name.span);
        Some(Let { doc, name, value, span })
    }
}
