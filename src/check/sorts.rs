//! Checks values against the sorts that fields and arguments take.

use super::errors::{self, WantedName};
use super::scope::nearest;
use super::value::{TableValue, Value, whole};
use crate::device::{self, Need, Range, Sort};
use crate::quantity::{Dimension, digits};
use crate::source::{Span, Spanned};
use std::ops::RangeInclusive;

/// Allowed magnitudes of the quantities of devices and steps, in SI units: products of a few of them stay within the
/// range of a double.
const SIZES_SI: RangeInclusive<f64> = 1e-40..=1e40;

/// Checks that a value is of a sort; the error is a diagnostic at `span` or at the faulty element.
pub fn judge(
    sort: Sort,
    value: &Value,
    span: Span,
    wanted: &WantedName,
) -> Result<(), Box<crate::diagnostic::Diagnostic>> {
    let wrong = |what: &str, example: &str| Err(Box::new(errors::wrong_value(wanted, what, example, span, value)));
    match sort {
        Sort::Count { least, most } => judge_count(least, most, value, span, wanted),
        Sort::Quantity { dimension, range } => judge_quantity(dimension, range, value, span, wanted),
        Sort::Word(choices) => match value {
            Value::Text(text) if choices.iter().any(|choice| choice.name == text) => Ok(()),
            Value::Text(text) => {
                let near = nearest(text, choices.iter().map(|choice| choice.name));
                Err(Box::new(errors::wrong_word(wanted, choices, span, text, near)))
            }
            _ => wrong("a word", choices.first().map_or("", |choice| choice.name)),
        },
        Sort::Object(_) => Ok(()),
        Sort::Site(_) if is_point(value, Dimension::NUMBER) || matches!(value, Value::Object(_)) => Ok(()),
        Sort::Site(noun) => wrong(&format!("a cell, or the name of a {noun}"), "(20, 23)"),
        Sort::Sites(noun) => {
            judge_list(Sort::Site(noun), &format!("a list of cells, or of names of {noun}s"), value, span, wanted)
        }
        Sort::Name if matches!(value, Value::Text(text) if is_name(text)) => Ok(()),
        Sort::Name => wrong("a name", "D1"),
        Sort::Pose if matches!(value, Value::Pose(_)) => Ok(()),
        Sort::Pose => wrong("a pose", "pose(1.8 mm, 1.5 mm, 90 deg)"),
        Sort::Control if matches!(value, Value::Word(_)) => Ok(()),
        Sort::Control if matches!(value, Value::Quantity(number) if whole(*number).is_some_and(|n| n >= 0)) => Ok(()),
        Sort::Control => wrong("the number of a control state, or a word of its arms", "2"),
        Sort::CountOrWord { least, most, .. } => judge_count(least, most, value, span, wanted),
        Sort::Flag if matches!(value, Value::Bool(_)) => Ok(()),
        Sort::Flag => wrong("true or false", "true"),
        Sort::Shape(form) => match value {
            Value::Shape(shape) if shape.form == form => Ok(()),
            _ => wrong(&format!("a {}", form.name()), &format!("{} {{ … }}", form.name())),
        },
        Sort::Table(columns) => match value {
            Value::Table(table) => judge_table(columns, table, span, wanted),
            _ => wrong("a table", "table { … }"),
        },
        Sort::State | Sort::Target if is_target(value) => Ok(()),
        Sort::State => wrong("a state", "0b00101_10010"),
        Sort::Target => wrong("a cell or a place", "(19, 28)"),
        Sort::Targets => match value {
            Value::List(list) if list.is_empty() => wrong("at least one place", "[(3, 9), (12, 4)]"),
            Value::List(list) => judge_each(Sort::Target, list, wanted),
            _ => wrong("a list of cells and places", "[(3, 9), (12, 4)]"),
        },
        Sort::Cell if is_point(value, Dimension::NUMBER) => Ok(()),
        Sort::Cell => wrong("a cell", "(20, 23)"),
        Sort::Cells => judge_list(Sort::Cell, "a list of cells", value, span, wanted),
        Sort::CountRows { .. } => wrong("a list for each row", "[[4, 5, none], [1, 2, 3]]"),
        Sort::CountTables { .. } => wrong("a list of lists of lists", "[[[3], [3, 2], [0, 9]]]"),
        Sort::Size if is_point(value, Dimension::LENGTH) => Ok(()),
        Sort::Size => Err(not_a_size(value, span, wanted)),
        Sort::Pixel if is_point(value, Dimension::PIXELS) => Ok(()),
        Sort::Pixel => wrong("a place in pixels", "(640 px, 512 px)"),
        Sort::Places => match value {
            Value::List(list) => list.iter().try_for_each(|element| match &element.value {
                Value::Unknown => Ok(()),
                point if is_point(point, Dimension::LENGTH) => Ok(()),
                other => Err(Box::new(errors::wrong_value(wanted, "places", "(9 um, 12 um)", element.span, other))),
            }),
            _ => wrong("a list of places", "[(9 um, 9 um), (12 um, 9 um), (9 um, 12 um)]"),
        },
        Sort::Vector { dimension, range } => judge_vector(dimension, range, value, span, wanted),
        Sort::Contacts if is_contacts(value) => Ok(()),
        Sort::Contacts => wrong("a contact for each finger", "(1, 38, 0)"),
        Sort::Orientation if matches!(value, Value::Orientation(_)) => Ok(()),
        Sort::Orientation => wrong("an orientation", "euler(80 deg, 220 deg, 100 deg)"),
        Sort::Curve => wrong("a curve", "16 um * cos(t)"),
        Sort::Text => wrong("the name of a file", "\"bead.stl\""),
        Sort::Board(_) => wrong("the name of a file", "\"board.json\""),
    }
}

/// Diagnostic for a value that is not a width and a height.
fn not_a_size(value: &Value, span: Span, wanted: &WantedName) -> Box<crate::diagnostic::Diagnostic> {
    let wrong = errors::wrong_value(wanted, "a width and a height", "(4 um, 0.5 um)", span, value);
    let is_in_space = matches!(value, Value::Point(sizes) if sizes.len() == 3);
    Box::new(if is_in_space { wrong.help("use a `rounded_box` for a body of three sizes") } else { wrong })
}

/// Checks that a value is a list of values of a sort; `what` describes such a list in the message.
fn judge_list(
    of: Sort,
    what: &str,
    value: &Value,
    span: Span,
    wanted: &WantedName,
) -> Result<(), Box<crate::diagnostic::Diagnostic>> {
    match value {
        Value::List(list) => judge_each(of, list, wanted),
        _ => Err(Box::new(errors::wrong_value(wanted, what, "[(3, 9), (12, 4)]", span, value))),
    }
}

/// Checks that all known elements of a list are of a sort.
fn judge_each(
    sort: Sort,
    list: &[Spanned<Value>],
    wanted: &WantedName,
) -> Result<(), Box<crate::diagnostic::Diagnostic>> {
    let known = list.iter().filter(|element| !element.value.is_unknown());
    known.into_iter().try_for_each(|element| judge(sort, &element.value, element.span, wanted))
}

/// Checks that a table has the required columns, at least one row, and in each cell a value of its column's sort.
fn judge_table(
    columns: &'static [device::VocabularyField],
    table: &TableValue,
    span: Span,
    wanted: &WantedName,
) -> Result<(), Box<crate::diagnostic::Diagnostic>> {
    let known: Vec<&str> = columns.iter().map(|column| column.name).collect();
    if let Some((name, at)) = table.columns.iter().find(|(name, _)| !known.contains(&name.as_str())) {
        let near = nearest(name, known.iter().copied());
        return Err(Box::new(errors::unknown_column(*at, name, wanted, near, &known)));
    }
    let given = |column: &&device::VocabularyField| table.columns.iter().any(|(name, _)| name == column.name);
    let missing: Vec<&device::VocabularyField> =
        columns.iter().filter(|c| c.need == Need::Required && !given(c)).collect();
    if !missing.is_empty() || table.rows.is_empty() {
        return Err(Box::new(errors::incomplete_table(span, wanted, &missing)));
    }
    for row in &table.rows {
        for ((name, _), cell) in table.columns.iter().zip(row) {
            let Some(column) = columns.iter().find(|column| column.name == name) else { continue };
            let wanted = WantedName { name: format!("column `{name}` of {}", wanted.name), ..wanted.clone() };
            if !cell.value.is_unknown() {
                judge(column.sort, &cell.value, cell.span, &wanted)?;
            }
        }
    }
    Ok(())
}

fn is_point(value: &Value, dimension: Dimension) -> bool {
    matches!(value, Value::Point(point) if point.len() == 2 && point[0].dimension == dimension)
}

/// Two or three numbers in brackets, or a list of numbers; the kind decides what they mean.
fn is_contacts(value: &Value) -> bool {
    match value {
        Value::Point(point) => point[0].dimension == Dimension::NUMBER,
        Value::List(list) => list.iter().all(|element| match &element.value {
            Value::Quantity(number) => number.dimension == Dimension::NUMBER,
            other => other.is_unknown(),
        }),
        _ => false,
    }
}

/// Three coordinates of a dimension, each in its range.
fn judge_vector(
    dimension: Dimension,
    range: device::Range,
    value: &Value,
    span: Span,
    wanted: &WantedName,
) -> Result<(), Box<crate::diagnostic::Diagnostic>> {
    let unit = dimension.example_unit();
    let example = format!("(16 {unit}, 12 {unit}, 12 {unit})");
    match value {
        Value::Point(point) if point.len() == 3 && point[0].dimension == dimension => {
            match point.iter().find(|coordinate| !range.contains(coordinate.si)) {
                Some(odd) => Err(Box::new(errors::out_of_range(wanted, span, &odd.to_string(), range.text()))),
                None => Ok(()),
            }
        }
        _ => {
            let what = format!("three {}s, along x, y and z", dimension.name());
            Err(Box::new(errors::wrong_value(wanted, &what, &example, span, value)))
        }
    }
}

/// Whether a text may be used as a name.
fn is_name(text: &str) -> bool {
    text.starts_with(|c: char| c.is_ascii_alphabetic()) && text.chars().all(|c| c.is_ascii_alphanumeric() || c == '_')
}

fn is_target(value: &Value) -> bool {
    matches!(value, Value::Word(_)) || is_point(value, Dimension::NUMBER) || is_point(value, Dimension::LENGTH)
}

fn judge_count(
    least: u32,
    most: u32,
    value: &Value,
    span: Span,
    wanted: &WantedName,
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
    wanted: &WantedName,
) -> Result<(), Box<crate::diagnostic::Diagnostic>> {
    match value {
        Value::Quantity(quantity) if quantity.dimension != dimension => {
            Err(Box::new(errors::wrong_dimension(wanted, dimension, span, value)))
        }
        Value::Quantity(quantity) if !range.contains(quantity.si) => {
            let is_absolute = dimension == Dimension::TEMPERATURE && range == Range::Positive;
            let limit = if is_absolute { "above -273.15 degC" } else { range.text() };
            Err(Box::new(errors::out_of_range(wanted, span, &quantity.to_string(), limit)))
        }
        Value::Quantity(quantity) if quantity.si != 0.0 && !SIZES_SI.contains(&quantity.si.abs()) => {
            let [least, most] = [SIZES_SI.start(), SIZES_SI.end()].map(|si| digits(*si));
            let or_none = if range.contains(0.0) { "0, or " } else { "" };
            let limit = format!("{or_none}from {least} to {most} in SI units");
            Err(Box::new(errors::out_of_range(wanted, span, &quantity.to_string(), &limit)))
        }
        Value::Quantity(_) => Ok(()),
        _ => Err(Box::new(errors::wrong_dimension(wanted, dimension, span, value))),
    }
}
