//! Work budget of the checker. A program of a few hundred bytes can demand more work, and longer strings, than any
//! machine has, because each `let` may be ten times as long as the one before it. Programs may come from strangers,
//! inside logs.
//!
//! Everything that can grow is counted here; passing a limit is reported once, and the remaining values are unknown.

use super::value::Value;
use super::{Checker, errors};
use crate::source::Span;
use std::mem::discriminant;
use std::rc::Rc;

/// Greatest number of subexpressions evaluated and elements compared in a whole program: `for`s and
/// curves evaluate their expressions again at every iteration.
pub const MAX_WORK: u64 = 50_000_000;

/// Greatest number of bytes of strings that a program builds and passes on.
pub const MAX_TEXT_BYTES: u64 = 64 * 1024 * 1024;

/// Greatest nesting depth of lists.
pub const MAX_LIST_DEPTH: usize = 64;

/// Work charged for the comparison of a mesh or a curve.
const WORK_OF_A_SOLID: u64 = 10_000;

/// Work and text used.
#[derive(Debug, Default)]
pub struct CheckBudget {
    work: u64,
    text_bytes: u64,
}

impl Checker<'_> {
    /// Charges work; `false` once the limit is passed, which is reported once, at the expression that passed it.
    pub fn spend(&mut self, work: u64, span: Span) -> bool {
        let before = self.budget.work;
        self.budget.work = before.saturating_add(work);
        if before <= MAX_WORK && self.budget.work > MAX_WORK {
            self.sink.push(errors::too_much_work(span, MAX_WORK));
        }
        self.budget.work <= MAX_WORK
    }

    /// Charges bytes of strings; `false` once the limit is passed, which is reported once, at the expression that
    /// passed it.
    pub fn spend_text(&mut self, bytes: usize, span: Span) -> bool {
        let before = self.budget.text_bytes;
        self.budget.text_bytes = before.saturating_add(bytes as u64);
        if before <= MAX_TEXT_BYTES && self.budget.text_bytes > MAX_TEXT_BYTES {
            self.sink.push(errors::too_much_text(span, MAX_TEXT_BYTES));
        }
        self.budget.text_bytes <= MAX_TEXT_BYTES
    }

    /// A copy of a value: strings are copied and charged, everything else that can be large is shared. Unknown once the
    /// limit of text is passed.
    pub fn charged_copy(&mut self, value: &Value, span: Span) -> Value {
        match value {
            Value::Text(text) if !self.spend_text(text.len(), span) => Value::Unknown,
            other => other.clone(),
        }
    }

    /// Whether two values are equal, regardless of their spans; `None` if either is unknown or the comparison exceeds
    /// the work limit.
    pub fn are_equal(&mut self, a: &Value, b: &Value, span: Span) -> Option<bool> {
        let mut open = vec![(a, b)];
        while let Some((a, b)) = open.pop() {
            if a.is_unknown() || b.is_unknown() || !self.spend(1, span) {
                return None;
            }
            let is_equal = match (a, b) {
                (Value::List(a), Value::List(b)) if Rc::ptr_eq(a, b) => true,
                (Value::List(a), Value::List(b)) => {
                    if a.len() == b.len() && !self.spend(a.len() as u64, span) {
                        return None;
                    }
                    open.extend(a.iter().zip(b.iter()).map(|(a, b)| (&a.value, &b.value)));
                    a.len() == b.len()
                }
                (Value::Table(a), Value::Table(b)) => {
                    let sizes = [a, b].map(|table| table.rows.iter().map(Vec::len).collect::<Vec<_>>());
                    if !self.spend(sizes[0].iter().map(|cells| *cells as u64 + 1).sum(), span) {
                        return None;
                    }
                    let cells = a.rows.iter().flatten().zip(b.rows.iter().flatten());
                    open.extend(cells.map(|(a, b)| (&a.value, &b.value)));
                    a.columns.iter().map(|column| &column.0).eq(b.columns.iter().map(|column| &column.0))
                        && sizes[0] == sizes[1]
                }
                (Value::Shape(a), Value::Shape(b)) => {
                    open.extend(a.fields.values().zip(b.fields.values()).map(|(a, b)| (&a.value, &b.value)));
                    a.form == b.form && a.fields.keys().eq(b.fields.keys())
                }
                (Value::Curve(_) | Value::Mesh(_), Value::Curve(_) | Value::Mesh(_)) => {
                    if !self.spend(WORK_OF_A_SOLID, span) {
                        return None;
                    }
                    a == b
                }
                (Value::Text(a), Value::Text(b)) => {
                    if a.len() == b.len() && !self.spend(a.len() as u64 / 64, span) {
                        return None;
                    }
                    a == b
                }
                (a, b) => discriminant(a) == discriminant(b) && a == b,
            };
            if !is_equal {
                return Some(false);
            }
        }
        Some(true)
    }
}
