//! Rows of whole numbers, as the channels of a board: a list of lists with the word `none` at empty places.

use super::Checker;
use super::errors::{self, WantedName};
use super::scope::{Scope, path_text};
use super::sorts::judge;
use super::value::{ListValue, Value};
use crate::device::{NONE, Sort};
use crate::quantity::{Dimension, Quantity};
use crate::source::{Span, Spanned};
use crate::syntax::tree::{Expr, ExprKind};
use std::rc::Rc;

/// Expected form and an example of it, for messages.
#[derive(Clone, Copy)]
struct ListForm {
    what: &'static str,
    example: &'static str,
}

const ROWS: ListForm = ListForm { what: "a list for each row", example: "[[4, 5, none], [1, 2, 3]]" };
const TABLES: ListForm = ListForm { what: "a list of lists of lists", example: "[[[3], [3, 2], [0, 9]]]" };

impl Checker<'_> {
    /// A list of rows, each a list of [`Value::Quantity`]s and, at empty places, the text [`NONE`]; `None` after an
    /// error. The rows are written out; each may be a range or the name of a list.
    pub fn accept_rows(&mut self, most: u32, expr: &Expr, scope: &Scope, wanted: &WantedName) -> Option<Value> {
        self.rows(most, expr, scope, wanted, ROWS)
    }

    fn rows(&mut self, most: u32, expr: &Expr, scope: &Scope, wanted: &WantedName, form: ListForm) -> Option<Value> {
        let ExprKind::List(written) = &expr.kind else {
            let found = self.evaluate(expr, scope);
            return self.no_rows(&found, expr.span, wanted, form);
        };
        let sort = Sort::Count { least: 0, most };
        let mut rows = Vec::with_capacity(written.len());
        for row in written {
            let mut cells = self.row(row, scope, wanted, form)?;
            for cell in &mut cells {
                let is_empty = matches!(&cell.value, Value::Text(text) if text == NONE);
                if !is_empty && let Err(wrong) = judge(sort, &cell.value, cell.span, wanted) {
                    self.sink.push(*wrong);
                    return None;
                }
            }
            rows.push(Spanned::new(Value::List(Rc::new(ListValue::new(cells))), row.span));
        }
        Some(Value::List(Rc::new(ListValue::new(rows))))
    }

    /// Lists of rows as [`Self::accept_rows`] takes them; `None` after an error.
    pub fn accept_count_tables(&mut self, most: u32, expr: &Expr, scope: &Scope, wanted: &WantedName) -> Option<Value> {
        let ExprKind::List(written) = &expr.kind else {
            let found = self.evaluate(expr, scope);
            return self.no_rows(&found, expr.span, wanted, TABLES);
        };
        let mut table = |rows: &Expr| Some(Spanned::new(self.rows(most, rows, scope, wanted, TABLES)?, rows.span));
        let tables: Option<Vec<Spanned<Value>>> = written.iter().map(&mut table).collect();
        Some(Value::List(Rc::new(ListValue::new(tables?))))
    }

    /// The places of a row, not yet judged.
    fn row(&mut self, expr: &Expr, scope: &Scope, wanted: &WantedName, form: ListForm) -> Option<Vec<Spanned<Value>>> {
        if let ExprKind::List(written) = &expr.kind {
            let place = |cell: &Expr| match self.empty_place(cell, scope) {
                Some(empty) => Some(Spanned::new(empty, cell.span)),
                None => Some(self.evaluate(cell, scope))
                    .filter(|value| !value.is_unknown())
                    .map(|value| Spanned::new(value, cell.span)),
            };
            return written.iter().map(place).collect();
        }
        match self.evaluate(expr, scope) {
            Value::List(list) => self.spend(list.len() as u64, expr.span).then(|| list.to_vec()),
            Value::Range { from, to } => {
                let count = u64::try_from(to.saturating_sub(from)).unwrap_or(0);
                let number = |n: i64| Value::Quantity(Quantity::new(n as f64, Dimension::NUMBER));
                self.spend(count, expr.span).then(|| (from..to).map(|n| Spanned::new(number(n), expr.span)).collect())
            }
            found => self.no_rows(&found, expr.span, wanted, form),
        }
    }

    /// The word for an empty place, unless it names a value.
    fn empty_place(&self, expr: &Expr, scope: &Scope) -> Option<Value> {
        let ExprKind::Path(path) = &expr.kind else { return None };
        (path_text(path) == NONE && !self.names_value(path, scope)).then(|| Value::Text(NONE.to_owned()))
    }

    /// Reports a value that stands in place of rows.
    fn no_rows<T>(&mut self, found: &Value, span: Span, wanted: &WantedName, form: ListForm) -> Option<T> {
        if !found.is_unknown() {
            self.sink.push(errors::wrong_value(wanted, form.what, form.example, span, found));
        }
        None
    }
}
