//! Expressions to values: every operator and function checked for the dimensions of its operands.

use super::budget::MAX_LIST_DEPTH;
use super::scope::{ANGLE_NAME, DeclarationSort, Scope, nearest, path_text};
use super::value::{Accepted, ListValue, ModuleWord, ShapeValue, TableValue, Value, whole};
use super::{Checker, errors, functions};
use crate::device::MAX_WORD_DIGITS;
use crate::device::shape::ShapeForm;
use crate::quantity::{Quantity, Unit, UnitError};
use crate::source::{Span, Spanned};
use crate::syntax::functions::{function_names, is_function};
use crate::syntax::tree::{Expr, ExprKind, Field, Ident, Operator, Path, Table, Text, TextPart};
use std::borrow::Cow;
use std::rc::Rc;

/// Greatest number of elements of a list, and greatest width of a range.
pub const MAX_ELEMENTS: usize = 1_000_000;

impl Checker<'_> {
    /// The value of an expression; [`Value::Unknown`] after an error, which has then been pushed.
    pub fn evaluate(&mut self, expr: &Expr, scope: &Scope) -> Value {
        if !self.spend(1, expr.span) {
            return Value::Unknown;
        }
        match &expr.kind {
            ExprKind::Number(digits) => self.quantity(digits, None, expr.span),
            ExprKind::Quantity { number, unit } => self.quantity(number, Some(unit), expr.span),
            ExprKind::Word(digits) => self.word(digits, expr.span),
            ExprKind::Text(text) => self.text(text, expr.span, scope).map_or(Value::Unknown, Value::Text),
            ExprKind::Bool(value) => Value::Bool(*value),
            ExprKind::Path(path) => self.path(path, scope),
            ExprKind::Tuple(parts) => self.tuple(expr.span, parts, scope),
            ExprKind::List(parts) => self.list(parts, expr.span, scope),
            ExprKind::Range { from, to } => self.range(from, to, scope),
            ExprKind::Negative(inner) => {
                // Some units have a zero of their own: `-5 degC` is a little less than `0 degC`, so the sign belongs to
                // the number. In front of brackets it belongs to the temperature.
                if let ExprKind::Quantity { number, unit } = &inner.kind
                    && inner.span.end == unit.span.end
                {
                    return self.quantity(&format!("-{number}"), Some(unit), expr.span);
                }
                self.negative(inner, expr.span, scope)
            }
            ExprKind::Binary { left, operator, operator_span, right } => {
                self.binary(left, *operator, *operator_span, right, scope)
            }
            ExprKind::Call { function, arguments } => self.call(function, arguments, expr.span, scope),
            ExprKind::With { base, fields } => self.with_fields(base, fields, scope),
            ExprKind::Table(table) => self.table(table, scope),
            ExprKind::Error => Value::Unknown,
        }
    }

    /// The value of an expression with its place.
    pub fn evaluate_spanned(&mut self, expr: &Expr, scope: &Scope) -> Spanned<Value> {
        Spanned::new(self.evaluate(expr, scope), expr.span)
    }

    fn quantity(&mut self, digits: &str, unit: Option<&Ident>, span: Span) -> Value {
        let parsed = match unit {
            Some(unit) => self.unit(unit),
            None => Some(Unit::ONE),
        };
        let Some(unit) = parsed else { return Value::Unknown };
        match unit.of(digits) {
            Some(quantity) => Value::Quantity(quantity),
            None => self.unknown(errors::not_finite(span)),
        }
    }

    fn unit(&mut self, unit: &Ident) -> Option<Unit> {
        match Unit::parse(&unit.text) {
            Ok(unit) => Some(unit),
            Err(UnitError::Unknown { part, nearest }) => {
                self.sink.push(errors::unknown_unit(unit.span, &part, nearest.as_deref()));
                None
            }
            Err(UnitError::ExponentTooLarge) => {
                self.sink.push(errors::exponent_too_large(unit.span));
                None
            }
        }
    }

    fn word(&mut self, text: &str, span: Span) -> Value {
        let digits = text.trim_start_matches("0b").chars().filter(|digit| *digit != '_');
        let (mut bits, mut width) = (0u64, 0u32);
        for digit in digits {
            width += 1;
            if width > MAX_WORD_DIGITS {
                return self.unknown(errors::word_too_long(span));
            }
            bits = bits << 1 | u64::from(digit == '1');
        }
        Value::Word(ModuleWord { bits, width })
    }

    /// The text of a string with its braces filled in; `None` after an error.
    pub fn text(&mut self, text: &Text, span: Span, scope: &Scope) -> Option<String> {
        let mut result = String::new();
        for part in &text.parts {
            let before = result.len();
            match part {
                TextPart::Plain(plain) => result.push_str(plain),
                TextPart::Hole(expr) => result.push_str(&self.hole(expr, scope)?),
            }
            if !self.spend_text(result.len() - before, span) {
                return None;
            }
        }
        Some(result)
    }

    fn hole(&mut self, expr: &Expr, scope: &Scope) -> Option<String> {
        match self.evaluate(expr, scope) {
            Value::Text(text) => Some(text),
            Value::Quantity(quantity) if whole(quantity).is_some() => whole(quantity).map(|number| number.to_string()),
            Value::Unknown => None,
            other => {
                self.sink.push(errors::not_in_text(expr.span, &other));
                None
            }
        }
    }

    fn path(&mut self, path: &Path, scope: &Scope) -> Value {
        let first = &path.segments[0];
        if let Some(local) = scope.local(&first.name.text) {
            let value = self.charged_copy(&local.value, path.span);
            self.note_use(first.name.span, local.span);
            return self.element_of(value, path, 0, scope);
        }
        self.use_import(path, scope);
        let Some((place, segment)) = self.find(path, scope) else {
            return self.unknown_value_name(path, scope);
        };
        self.use_place(place);
        let declaration = self.declaration(place);
        self.note_use(path.segments[segment].name.span, declaration.span);
        if declaration.sort != DeclarationSort::Let {
            return self.unknown(errors::wrong_sort(path, declaration, "a value"));
        }
        let value = self.value_of_let(place, path.span);
        self.element_of(value, path, segment, scope)
    }

    fn unknown_value_name(&mut self, path: &Path, scope: &Scope) -> Value {
        match ShapeForm::find(&path_text(path)) {
            Some(form) => self.sink.push(errors::shape_without_fields(path.span, form)),
            None => drop(self.report_unknown(path, scope, DeclarationSort::Let)),
        }
        Value::Unknown
    }

    /// The element of a list that the indices of a path's segment select.
    fn element_of(&mut self, value: Value, path: &Path, segment: usize, scope: &Scope) -> Value {
        if let Some(extra) = path.segments.get(segment + 1) {
            if value.is_unknown() {
                return Value::Unknown;
            }
            return self.unknown(errors::no_fields_on_values(extra.name.span));
        }
        let mut value = value;
        for index in &path.segments[segment].indices {
            let Some(number) = self.index(index, scope) else { return Value::Unknown };
            value = match &value {
                Value::Unknown => return Value::Unknown,
                Value::List(list) => match list.get(number) {
                    Some(element) => self.charged_copy(&element.value, index.span),
                    None => return self.unknown(errors::index_beyond(index.span, number, list.len())),
                },
                other => return self.unknown(errors::not_a_list(path.segments[segment].name.span, other)),
            };
        }
        value
    }

    /// An index: whole and not negative.
    pub fn index(&mut self, expr: &Expr, scope: &Scope) -> Option<usize> {
        let value = self.evaluate(expr, scope);
        let number = match &value {
            Value::Unknown => return None,
            Value::Quantity(quantity) => whole(*quantity).and_then(|number| usize::try_from(number).ok()),
            _ => None,
        };
        if number.is_none() {
            self.sink.push(errors::bad_index(expr.span, &value));
        }
        number
    }

    fn tuple(&mut self, span: Span, parts: &[Expr], scope: &Scope) -> Value {
        let values: Vec<Value> = parts.iter().map(|part| self.evaluate(part, scope)).collect();
        let mut coordinates = Vec::with_capacity(values.len());
        for (part, value) in parts.iter().zip(&values) {
            match value {
                Value::Quantity(quantity) => coordinates.push(*quantity),
                Value::Unknown => return Value::Unknown,
                other => return self.unknown(errors::bad_coordinate(part.span, other)),
            }
        }
        let Some(first) = coordinates.first() else { return Value::Unknown };
        if let Some(odd) = coordinates.iter().position(|coordinate| coordinate.dimension != first.dimension) {
            let at = |index: usize| Spanned::new(&values[index], parts[index].span);
            return self.unknown(errors::mixed_point(at(0), at(odd), span, &coordinates));
        }
        Value::Point(coordinates)
    }

    fn list(&mut self, parts: &[Expr], span: Span, scope: &Scope) -> Value {
        if parts.len() > MAX_ELEMENTS {
            return self.unknown(errors::too_many_elements(span, parts.len()));
        }
        let list = ListValue::new(parts.iter().map(|part| self.evaluate_spanned(part, scope)).collect());
        if list.depth() > MAX_LIST_DEPTH {
            return self.unknown(errors::too_deep(span, "lists", MAX_LIST_DEPTH));
        }
        Value::List(Rc::new(list))
    }

    fn range(&mut self, from: &Expr, to: &Expr, scope: &Scope) -> Value {
        let (low, high) = (self.whole_end(from, scope), self.whole_end(to, scope));
        let (Some(low), Some(high)) = (low, high) else { return Value::Unknown };
        if high.saturating_sub(low) > MAX_ELEMENTS as i64 {
            return self.unknown(errors::too_many_elements(from.span.to(to.span), high.saturating_sub(low) as usize));
        }
        Value::Range { from: low, to: high }
    }

    fn whole_end(&mut self, expr: &Expr, scope: &Scope) -> Option<i64> {
        let value = self.evaluate(expr, scope);
        let number = match &value {
            Value::Unknown => return None,
            Value::Quantity(quantity) => whole(*quantity),
            _ => None,
        };
        if number.is_none() {
            self.sink.push(errors::bad_range_end(expr.span, &value));
        }
        number
    }

    fn negative(&mut self, inner: &Expr, span: Span, scope: &Scope) -> Value {
        match self.evaluate(inner, scope) {
            value if value.is_celsius() => self.unknown(errors::celsius_operand(inner.span, "-", &value)),
            Value::Quantity(quantity) => Value::Quantity(Quantity { si: -quantity.si, ..quantity }),
            Value::Point(coordinates) => {
                Value::Point(coordinates.into_iter().map(|c| Quantity { si: -c.si, ..c }).collect())
            }
            Value::Unknown => Value::Unknown,
            other => self.unknown(errors::bad_operand(span, "-", inner.span, &other)),
        }
    }

    fn binary(&mut self, left: &Expr, operator: Operator, at: Span, right: &Expr, scope: &Scope) -> Value {
        let a = self.evaluate_spanned(left, scope);
        let b = self.evaluate_spanned(right, scope);
        if functions::is_equality(operator, &a.value, &b.value) {
            let is_equal = self.are_equal(&a.value, &b.value, at);
            return is_equal.map_or(Value::Unknown, |equal| Value::Bool(equal == (operator == Operator::Equal)));
        }
        match functions::apply_operator(operator, at, &a, &b) {
            Ok(value) => value,
            Err(diagnostic) => self.unknown(*diagnostic),
        }
    }

    fn call(&mut self, function: &Path, arguments: &[Expr], span: Span, scope: &Scope) -> Value {
        let name = path_text(function);
        let values: Vec<Spanned<Value>> =
            arguments.iter().map(|argument| self.evaluate_spanned(argument, scope)).collect();
        if !is_function(&name) {
            let declared = self.modules[scope.module].names.get(&name);
            let is_value =
                declared.is_some_and(|found| found.sort == DeclarationSort::Let) || scope.local(&name).is_some();
            if is_value {
                return self.unknown(errors::index_in_round_brackets(function.span, &name));
            }
            let near = nearest(&name, function_names());
            return self.unknown(errors::unknown_function(function.span, &name, near));
        }
        let elements: usize = values.iter().map(|value| value.value.elements()).sum();
        if !self.spend(elements as u64, span) {
            return Value::Unknown;
        }
        match functions::apply_function(&name, span, &values) {
            Ok(value) => value,
            Err(diagnostic) => self.unknown(*diagnostic),
        }
    }

    fn with_fields(&mut self, base: &Path, fields: &[Field], scope: &Scope) -> Value {
        let shape = match ShapeForm::find(&path_text(base)).filter(|_| base.segments.len() == 1) {
            Some(form) => ShapeValue { form, fields: Accepted::new(form.fields()) },
            None => match self.shape_base(base, scope) {
                Some(shape) => shape,
                None => {
                    self.read_for_errors(fields, scope);
                    return Value::Unknown;
                }
            },
        };
        self.shape_with(shape, base.span, fields, scope)
    }

    fn shape_base(&mut self, base: &Path, scope: &Scope) -> Option<super::value::ShapeValue> {
        if !self.names_value(base, scope) && is_word(base) {
            let text = path_text(base);
            let near = nearest(&text, ShapeForm::ALL.iter().map(|form| form.name()));
            self.sink.push(errors::unknown_shape(base.span, &text, near));
            return None;
        }
        match self.path(base, scope) {
            Value::Shape(shape) => Some(shape),
            Value::Unknown => None,
            other => {
                self.sink.push(errors::not_a_shape(base.span, &other));
                None
            }
        }
    }

    /// Evaluates fields whose owner is unknown, so that their own mistakes are still reported.
    pub fn read_for_errors(&mut self, fields: &[Field], scope: &Scope) {
        let mut scope = scope.clone();
        for field in fields {
            if !matches!(field.value.kind, ExprKind::Path(_)) {
                // It may be meant as a curve, whose angle has a name.
                let angle = Ident { text: ANGLE_NAME.to_owned(), span: field.value.span };
                let unknown = Spanned::new(Value::Unknown, field.value.span);
                scope.with(&angle, unknown, |scope| self.evaluate(&field.value, scope));
            }
        }
    }

    fn table(&mut self, table: &Table, scope: &Scope) -> Value {
        let units: Vec<Option<Unit>> =
            table.columns.iter().map(|column| column.unit.as_ref().and_then(|unit| self.unit(unit))).collect();
        let mut seen: Vec<(String, Span)> = Vec::new();
        for column in &table.columns {
            if let Some((_, earlier)) = seen.iter().find(|(name, _)| *name == column.name.text) {
                self.sink.push(errors::declared_twice(&column.name.text, column.name.span, *earlier));
            }
            seen.push((column.name.text.clone(), column.name.span));
        }
        let rows = table.rows.iter().map(|row| {
            let cells = row.cells.iter().zip(&units).zip(&table.columns);
            cells.map(|((cell, unit), column)| self.cell(cell, *unit, column.unit.as_ref(), scope)).collect()
        });
        let rows = rows.collect();
        Value::Table(Rc::new(TableValue { columns: seen, rows }))
    }

    /// A table's cell: a bare number takes the unit of its column, and a bare word stands for itself.
    fn cell(&mut self, cell: &Expr, unit: Option<Unit>, header: Option<&Ident>, scope: &Scope) -> Spanned<Value> {
        let value = match (bare_number(cell), unit) {
            (Some(number), Some(unit)) => match unit.of(&number) {
                Some(quantity) => Value::Quantity(quantity),
                None => self.unknown(errors::not_finite(cell.span)),
            },
            _ => self.cell_value(cell, header, scope),
        };
        let unlike = match (&value, unit, header) {
            (Value::Quantity(quantity), Some(unit), Some(header)) if quantity.dimension != unit.dimension => {
                Some(errors::cell_of_other_dimension(cell.span, &value, header, unit.dimension))
            }
            _ => None,
        };
        let value = unlike.map_or(value, |diagnostic| self.unknown(diagnostic));
        Spanned::new(value, cell.span)
    }

    fn cell_value(&mut self, cell: &Expr, header: Option<&Ident>, scope: &Scope) -> Value {
        match &cell.kind {
            ExprKind::Path(path) if header.is_none() && is_word(path) && self.find(path, scope).is_none() => {
                Value::Text(path_text(path))
            }
            _ => self.evaluate(cell, scope),
        }
    }

    /// Pushes an error and returns the unknown value.
    pub fn unknown(&mut self, diagnostic: crate::diagnostic::Diagnostic) -> Value {
        self.sink.push(diagnostic);
        Value::Unknown
    }
}

/// The digits of a number without a unit, with its sign.
fn bare_number(expr: &Expr) -> Option<Cow<'_, str>> {
    match &expr.kind {
        ExprKind::Number(digits) => Some(digits.into()),
        ExprKind::Negative(inner) => {
            let digits = bare_number(inner)?;
            Some(digits.strip_prefix('-').map_or_else(|| format!("-{digits}"), str::to_owned).into())
        }
        _ => None,
    }
}

fn is_word(path: &Path) -> bool {
    path.segments.len() == 1 && path.segments[0].indices.is_empty()
}
