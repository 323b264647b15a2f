//! Budget of checking a program. A text of a few hundred bytes can demand more work, and longer strings, than any machine
//! has: each `let` may be ten times as long as the one before it. Programs come from strangers too, inside logs.
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

/// The deepest that lists may hold one another.
pub const MAX_LIST_DEPTH: usize = 64;

/// Work charged for the comparison of a file of triangles or a curve.
const WORK_OF_A_SOLID: u64 = 10_000;

/// Work and text used.
#[derive(Debug, Default)]
pub struct CheckBudget {
    work: u64,
    text_bytes: u64,
}

impl Checker<'_> {
    /// Counts work; `false` once there was too much, which is reported where it came to that.
    pub fn spend(&mut self, work: u64, span: Span) -> bool {
        let before = self.budget.work;
        self.budget.work = before.saturating_add(work);
        if before <= MAX_WORK && self.budget.work > MAX_WORK {
            self.sink.push(errors::too_much_work(span, MAX_WORK));
        }
        self.budget.work <= MAX_WORK
    }

    /// Counts bytes of strings; `false` once there were too many, which is reported where it came to that.
    pub fn spend_text(&mut self, bytes: usize, span: Span) -> bool {
        let before = self.budget.text_bytes;
        self.budget.text_bytes = before.saturating_add(bytes as u64);
        if before <= MAX_TEXT_BYTES && self.budget.text_bytes > MAX_TEXT_BYTES {
            self.sink.push(errors::too_much_text(span, MAX_TEXT_BYTES));
        }
        self.budget.text_bytes <= MAX_TEXT_BYTES
    }

    /// A value handed on: strings are copied, all else that can be large is shared. Unknown where there was too much text.
    pub fn handed_on(&mut self, value: &Value, span: Span) -> Value {
        match value {
            Value::Text(text) if !self.spend_text(text.len(), span) => Value::Unknown,
            other => other.clone(),
        }
    }

    /// Whether two values are equal, wherever they were written; `None` if either is unknown, or to find out is too much work.
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
