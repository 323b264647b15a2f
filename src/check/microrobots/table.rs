//! The table of a bed's robots, each figure with its place in the source.

use crate::check::devices::CheckedDevice;
use crate::check::value::{TableValue, Value};
use crate::quantity::Quantity;
use crate::source::{Span, Spanned};

/// The field `robots` of a device; its columns and cells were checked against the vocabulary.
#[derive(Clone, Copy)]
pub struct RobotTable<'a> {
    value: &'a TableValue,
    /// The whole table.
    pub span: Span,
}

impl<'a> RobotTable<'a> {
    /// `None` if a cell is unknown, already reported.
    pub fn of(device: &'a CheckedDevice) -> Option<RobotTable<'a>> {
        let field = device.fields.get("robots")?;
        let Value::Table(value) = &field.value else { return None };
        let is_known = value.rows.iter().flatten().all(|cell| !cell.value.is_unknown());
        is_known.then_some(RobotTable { value, span: field.span })
    }

    /// Number of rows.
    pub fn rows(&self) -> usize {
        self.value.rows.len()
    }

    fn cell(&self, row: usize, column: &str) -> Option<&'a Spanned<Value>> {
        let at = self.value.columns.iter().position(|(name, _)| name == column)?;
        self.value.rows.get(row)?.get(at)
    }

    /// A figure; `None` where the table has no such column.
    pub fn quantity(&self, row: usize, column: &str) -> Option<Quantity> {
        match self.cell(row, column)?.value {
            Value::Quantity(quantity) => Some(quantity),
            _ => None,
        }
    }

    /// A word; `None` where the table has no such column.
    pub fn text(&self, row: usize, column: &str) -> Option<&'a str> {
        match &self.cell(row, column)?.value {
            Value::Text(text) => Some(text),
            _ => None,
        }
    }

    /// Span of a cell, or of the whole table if it has no such column.
    pub fn place(&self, row: usize, column: &str) -> Span {
        self.cell(row, column).map_or(self.span, |cell| cell.span)
    }
}
