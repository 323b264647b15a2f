//! Fields and arguments: each value held against the sort that its table wants.

use super::Checker;
use super::errors::{self, Wanted};
use super::scope::{Scope, nearest, path_text};
use super::value::{ShapeValue, Value, whole};
use crate::device::{self, Need, Sort};
use crate::quantity::{Dimension, digits};
use crate::source::{Span, Spanned};
use crate::syntax::tree::{self, Expr, ExprKind};
use std::collections::BTreeMap;

/// The fields that were given and accepted, by name.
pub type Accepted = BTreeMap<&'static str, Spanned<Value>>;

/// Whose fields are being read.
#[derive(Debug, Clone)]
pub struct Owner {
    /// "device `bot`".
    pub name: String,
    /// Its declaration, for a label.
    pub declared: Option<(Span, String)>,
}

impl Owner {
    fn wanted(&self, field: &device::Field) -> Wanted {
        Wanted {
            name: format!("`{}` of {}", field.name, self.name),
            doc: field.doc.to_owned(),
            declared: self.declared.clone(),
        }
    }
}

/// A field with the scope in which it was written.
pub struct Given<'a> {
    pub field: &'a tree::Field,
    pub scope: Scope,
}

impl Checker<'_> {
    /// Reads fields against their table; unknown, repeated and unfit ones are reported. Missing ones are the caller's to judge.
    pub fn read_fields(&mut self, owner: &Owner, given: &[Given], table: &'static [device::Field]) -> Accepted {
        let mut accepted = Accepted::new();
        let mut seen: BTreeMap<&str, Span> = BTreeMap::new();
        for Given { field, scope } in given {
            if let Some(earlier) = seen.insert(&field.name.text, field.name.span) {
                self.sink.push(errors::field_twice(&field.name, earlier));
                continue;
            }
            let Some(entry) = table.iter().find(|entry| entry.name == field.name.text) else {
                let known: Vec<&str> = table.iter().map(|entry| entry.name).collect();
                let near = nearest(&field.name.text, known.iter().copied());
                self.sink.push(errors::unknown_field(&field.name, &owner.name, near, &known));
                continue;
            };
            let value = self.accept(entry.sort, &field.value, scope, &owner.wanted(entry));
            accepted.insert(entry.name, Spanned::new(value.unwrap_or(Value::Unknown), field.value.span));
        }
        accepted
    }

    /// The required fields of a table that were not given.
    pub fn missing(accepted: &Accepted, table: &'static [device::Field]) -> Vec<&'static device::Field> {
        let required = table.iter().filter(|field| field.need == Need::Required);
        required.filter(|field| !accepted.contains_key(field.name)).collect()
    }

    /// The value of an expression, if it is of a sort; `None` after an error, which has then been pushed.
    pub fn accept(&mut self, sort: Sort, expr: &Expr, scope: &Scope, wanted: &Wanted) -> Option<Value> {
        if let Sort::Word(choices) = sort {
            return self.accept_word(choices, expr, wanted);
        }
        let value = self.evaluate(expr, scope);
        if value.is_unknown() {
            return None;
        }
        let wanted = &self.with_origin(wanted, expr, scope);
        match judge(sort, &value, expr.span, wanted) {
            Ok(()) => Some(value),
            Err(diagnostic) => {
                self.sink.push(*diagnostic);
                None
            }
        }
    }

    fn accept_word(&mut self, choices: &'static [device::Choice], expr: &Expr, wanted: &Wanted) -> Option<Value> {
        let text = match &expr.kind {
            ExprKind::Path(path) if path.segments.iter().all(|segment| segment.indices.is_empty()) => path_text(path),
            ExprKind::Error => return None,
            _ => String::new(),
        };
        let found = choices.iter().find(|choice| choice.name == text);
        if found.is_none() {
            let near = nearest(&text, choices.iter().map(|choice| choice.name));
            self.sink.push(errors::wrong_word(wanted, choices, (expr.span, &text), near));
        }
        found.map(|choice| Value::Text(choice.name.to_owned()))
    }

    /// Where a value has a name, the place where it was given says more than the owner's declaration.
    fn with_origin(&mut self, wanted: &Wanted, expr: &Expr, scope: &Scope) -> Wanted {
        match self.origin(expr, scope) {
            Some(origin) => Wanted { declared: Some((origin.span, origin.text)), ..wanted.clone() },
            None => wanted.clone(),
        }
    }

    /// A shape with some fields changed.
    pub fn shape_with(&mut self, shape: ShapeValue, span: Span, fields: &[tree::Field], scope: &Scope) -> Value {
        let mut shape = shape;
        let owner = Owner { name: format!("a {}", shape.form.name()), declared: None };
        let given: Vec<Given> = fields.iter().map(|field| Given { field, scope: scope.clone() }).collect();
        shape.fields.extend(self.read_fields(&owner, &given, shape.form.fields()));
        let missing = Self::missing(&shape.fields, shape.form.fields());
        if !missing.is_empty() {
            return self.unknown(errors::missing_fields(span, &owner.name, &missing, None));
        }
        if shape.fields.values().any(|field| field.value.is_unknown()) {
            return Value::Unknown;
        }
        match super::shapes::impossible(&shape, span) {
            Some(diagnostic) => self.unknown(diagnostic),
            None => Value::Shape(shape),
        }
    }
}

/// Whether a value is of a sort.
fn judge(sort: Sort, value: &Value, span: Span, wanted: &Wanted) -> Result<(), Box<crate::diagnostic::Diagnostic>> {
    let wrong = |what, example| Err(Box::new(errors::wrong_value(wanted, what, example, span, value)));
    match sort {
        Sort::Count { least, most } => judge_count((least, most), value, span, wanted),
        Sort::Quantity { dimension, range } => judge_quantity(dimension, range, value, span, wanted),
        Sort::Word(_) => Ok(()),
        Sort::State | Sort::Target if is_target(value) => Ok(()),
        Sort::State => wrong("a state", "0b00101_10010"),
        Sort::Target => wrong("a cell or a place", "(19, 28)"),
        Sort::Targets => match value {
            Value::List(list) if list.is_empty() => wrong("at least one place", "[(3, 9), (12, 4)]"),
            Value::List(list) => list.iter().try_for_each(|element| match &element.value {
                Value::Unknown => Ok(()),
                element_value => judge(Sort::Target, element_value, element.span, wanted),
            }),
            _ => wrong("a list of cells and places", "[(3, 9), (12, 4)]"),
        },
        Sort::Cell => {
            if is_point(value, Dimension::NUMBER) {
                Ok(())
            } else {
                wrong("a cell", "(20, 23)")
            }
        }
        Sort::Size => {
            if is_point(value, Dimension::LENGTH) {
                Ok(())
            } else {
                wrong("a width and a height", "(4 um, 0.5 um)")
            }
        }
        Sort::Places => match value {
            Value::List(list) => list.iter().try_for_each(|element| match &element.value {
                Value::Unknown => Ok(()),
                point if is_point(point, Dimension::LENGTH) => Ok(()),
                other => Err(Box::new(errors::wrong_value(wanted, "places", "(9 um, 12 um)", element.span, other))),
            }),
            _ => wrong("a list of places", "[(9 um, 9 um), (12 um, 9 um), (9 um, 12 um)]"),
        },
    }
}

fn is_point(value: &Value, dimension: Dimension) -> bool {
    matches!(value, Value::Point(point) if point.len() == 2 && point[0].dimension == dimension)
}

fn is_target(value: &Value) -> bool {
    matches!(value, Value::Word(_)) || is_point(value, Dimension::NUMBER) || is_point(value, Dimension::LENGTH)
}

fn judge_count(
    (least, most): (u32, u32),
    value: &Value,
    span: Span,
    wanted: &Wanted,
) -> Result<(), Box<crate::diagnostic::Diagnostic>> {
    let Value::Quantity(quantity) = value else {
        return Err(Box::new(errors::wrong_value(wanted, "a whole number", "5", span, value)));
    };
    if quantity.dimension != Dimension::NUMBER {
        return Err(Box::new(errors::wrong_dimension(wanted, Dimension::NUMBER, span, value)));
    }
    let limit = format!("a whole number from {least} to {most}");
    let fits = whole(*quantity).is_some_and(|number| (i64::from(least)..=i64::from(most)).contains(&number));
    if fits { Ok(()) } else { Err(Box::new(errors::out_of_range(wanted, span, &digits(quantity.si), &limit))) }
}

fn judge_quantity(
    dimension: Dimension,
    range: device::Range,
    value: &Value,
    span: Span,
    wanted: &Wanted,
) -> Result<(), Box<crate::diagnostic::Diagnostic>> {
    match value {
        Value::Quantity(quantity) if quantity.dimension != dimension => {
            Err(Box::new(errors::wrong_dimension(wanted, dimension, span, value)))
        }
        Value::Quantity(quantity) if !range.holds(quantity.si) => {
            Err(Box::new(errors::out_of_range(wanted, span, &quantity.to_string(), range.text())))
        }
        Value::Quantity(_) => Ok(()),
        _ => Err(Box::new(errors::wrong_dimension(wanted, dimension, span, value))),
    }
}
