//! Evaluates each `let` once, dependencies first, and finds the origin of an expression's value.

use super::scope::{Declaration, DeclarationPlace, DeclarationSort, Scope, path_text};
use super::value::Value;
use super::{Checker, errors};
use crate::claims::ValueOrigin;
use crate::diagnostic::{Diagnostic, Sink};
use crate::source::{Span, Spanned};
use crate::syntax::tree::{Expr, ExprKind, Item, Path, TextPart};
use std::rc::Rc;

/// State of a `let`.
pub enum LetState {
    /// Being evaluated: a use of it now is a cycle.
    Open,
    Done(Value),
    /// Set from the command line.
    Set(Value),
}

impl LetState {
    fn value(&self) -> Option<&Value> {
        match self {
            LetState::Done(value) | LetState::Set(value) => Some(value),
            LetState::Open => None,
        }
    }
}

/// Pending evaluation of a `let`.
enum LetTask {
    /// Evaluate this dependency first.
    Begin(DeclarationPlace),
    /// All its dependencies are known, or in a cycle with it.
    Evaluate(DeclarationPlace),
}

/// A value with its span, and its origin if a name stands there.
#[derive(Debug, Clone)]
pub struct Argument {
    pub value: Value,
    pub span: Span,
    pub origin: Option<ValueOrigin>,
}

impl Argument {
    /// A value that is written where it is used.
    pub fn plain(value: &Spanned<Value>) -> Argument {
        Argument { value: value.value.clone(), span: value.span, origin: None }
    }

    /// Reports a fault of the value, if there is one, and labels the value's origin; `None` if a fault was reported.
    pub fn unless(&self, wrong: Option<Diagnostic>, sink: &mut Sink) -> Option<()> {
        sink.push_if_some(wrong.map(|wrong| errors::given_at(wrong, self)))
    }
}

impl Checker<'_> {
    /// The value of a `let`; `asked` is where its name is used.
    pub fn value_of_let(&mut self, place: DeclarationPlace, asked: Span) -> Value {
        if let Some(LetState::Open) = self.lets.get(&place) {
            let (name, declared) = self.named(place);
            return self.unknown(errors::defined_by_itself(name, declared, asked));
        }
        self.evaluate_let(place);
        let text_bytes = match self.lets.get(&place).and_then(LetState::value) {
            Some(Value::Text(text)) => text.len(),
            Some(_) | None => 0,
        };
        let is_short = self.spend_text(text_bytes, asked);
        let value = self.lets.get(&place).and_then(LetState::value).filter(|_| is_short);
        value.cloned().unwrap_or(Value::Unknown)
    }

    /// Evaluates a `let` and its dependencies with an explicit stack, since a chain of them may be as long as the file.
    fn evaluate_let(&mut self, place: DeclarationPlace) {
        let mut tasks = vec![LetTask::Begin(place)];
        while let Some(task) = tasks.pop() {
            match task {
                LetTask::Begin(place) if self.lets.contains_key(&place) => {}
                LetTask::Begin(place) => {
                    self.lets.insert(place, LetState::Open);
                    tasks.push(LetTask::Evaluate(place));
                    tasks.extend(self.lets_needed(place).into_iter().map(LetTask::Begin));
                }
                LetTask::Evaluate(place) => {
                    let state = match self.replaced.get(&place).cloned() {
                        Some(replacement) => LetState::Set(self.evaluate(&replacement, &self.top_of_settings())),
                        None => {
                            let Item::Let(item) = self.item(place) else { continue };
                            LetState::Done(self.evaluate(&item.value, &self.top(place)))
                        }
                    };
                    self.lets.insert(place, state);
                }
            }
        }
    }

    /// The dependencies of a `let` that are not evaluated yet.
    fn lets_needed(&self, place: DeclarationPlace) -> Vec<DeclarationPlace> {
        let Item::Let(item) = self.item(place) else { return Vec::new() };
        let replacement = self.replaced.get(&place);
        let mut named = Vec::new();
        paths(replacement.map_or(&item.value, Rc::as_ref), &mut named);
        let scope = if replacement.is_some() { self.top_of_settings() } else { self.top(place) };
        let found = named.into_iter().filter_map(|path| self.find(path, &scope)).map(|(place, _)| place);
        found.filter(|place| matches!(self.item(*place), Item::Let(_)) && !self.lets.contains_key(place)).collect()
    }

    /// Scope of the value of a `--set`: the top of the program's own file.
    fn top_of_settings(&self) -> Scope {
        Scope::top(0)
    }

    /// Evaluates an argument of a step or a run.
    pub fn argument_of(&mut self, expr: &Expr, value: Value, scope: &Scope) -> Argument {
        Argument { value, span: expr.span, origin: self.origin(expr, scope) }
    }

    /// Origin of an expression's value, if a name stands in it: the value of a `let`, the element that a `for` took, or
    /// the argument of a run.
    pub fn origin(&mut self, expr: &Expr, scope: &Scope) -> Option<ValueOrigin> {
        let mut named = Vec::new();
        paths(expr, &mut named);
        named.into_iter().find_map(|path| self.origin_of_name(path, scope))
    }

    fn origin_of_name(&mut self, path: &Path, scope: &Scope) -> Option<ValueOrigin> {
        let text = format!("`{}` is given here", path_text(path));
        if let Some(local) = scope.local(&path.segments[0].name.text) {
            return Some(ValueOrigin { span: local.given, text });
        }
        let (place, segment) = self.find(path, scope)?;
        let Declaration { sort: DeclarationSort::Let, .. } = self.declaration(place) else { return None };
        let Item::Let(item) = self.item(place) else { return None };
        if let Some(LetState::Set(_)) = self.lets.get(&place) {
            let text = format!("`{}` has the value of `--set` in place of this", path_text(path));
            return Some(ValueOrigin { span: item.value.span, text });
        }
        let span = match (self.lets.get(&place), path.segments[segment].indices.as_slice()) {
            (Some(LetState::Done(Value::List(list))), [index]) => {
                let list = std::rc::Rc::clone(list);
                let index = self.index(index, scope)?;
                list.get(index)?.span
            }
            _ => item.value.span,
        };
        Some(ValueOrigin { span, text })
    }
}

/// Collects the names in an expression, in the order of writing.
pub fn paths<'e>(expr: &'e Expr, found: &mut Vec<&'e Path>) {
    match &expr.kind {
        ExprKind::Path(path) => add(path, found),
        ExprKind::Tuple(parts) | ExprKind::List(parts) => parts.iter().for_each(|part| paths(part, found)),
        ExprKind::Range { from, to } => [from, to].into_iter().for_each(|end| paths(end, found)),
        ExprKind::Negative(inner) => paths(inner, found),
        ExprKind::Binary { left, right, .. } => [left, right].into_iter().for_each(|side| paths(side, found)),
        ExprKind::Call { arguments, .. } => arguments.iter().for_each(|argument| paths(argument, found)),
        ExprKind::With { base, fields } => {
            add(base, found);
            fields.iter().for_each(|field| paths(&field.value, found));
        }
        ExprKind::Table(table) => table.rows.iter().flat_map(|row| &row.cells).for_each(|cell| paths(cell, found)),
        ExprKind::Text(text) => text.parts.iter().for_each(|part| match part {
            TextPart::Hole(hole) => paths(hole, found),
            TextPart::Plain(_) => {}
        }),
        ExprKind::Number(_) | ExprKind::Quantity { .. } | ExprKind::Word(_) | ExprKind::Bool(_) | ExprKind::Error => {}
    }
}

fn add<'e>(path: &'e Path, found: &mut Vec<&'e Path>) {
    found.push(path);
    path.segments.iter().flat_map(|segment| &segment.indices).for_each(|index| paths(index, found));
}
