//! Operators and functions on values, with the rules of their dimensions.

use super::errors;
use super::orientation;
use super::value::{PoseValue, Value, whole};
use crate::diagnostic::Diagnosed;
use crate::quantity::{Dimension, Quantity};
use crate::real::Real;
use crate::source::{Span, Spanned};
use crate::syntax::tree::Operator;

type Operand<'a> = (Span, &'a Value);

/// Applies a binary operator.
pub fn apply_operator(operator: Operator, span: Span, a: &Spanned<Value>, b: &Spanned<Value>) -> Diagnosed<Value> {
    if a.value.is_unknown() || b.value.is_unknown() {
        return Ok(Value::Unknown);
    }
    let (left, right) = ((a.span, &a.value), (b.span, &b.value));
    let value = match operator {
        Operator::Add => sum("+", left, right)?,
        Operator::Subtract => sum("-", left, right)?,
        Operator::Multiply => product(span, left, right)?,
        Operator::Divide => quotient(span, left, right)?,
        Operator::Power => power(span, left, right)?,
        Operator::Equal
        | Operator::NotEqual
        | Operator::Less
        | Operator::LessEqual
        | Operator::Greater
        | Operator::GreaterEqual => return comparison(operator, left, right),
    };
    finite(value, span)
}

fn finite(value: Value, span: Span) -> Diagnosed<Value> {
    let is_finite = match &value {
        Value::Quantity(quantity) => quantity.si.is_finite(),
        Value::Point(coordinates) => coordinates.iter().all(|coordinate| coordinate.si.is_finite()),
        _ => true,
    };
    if is_finite { Ok(value) } else { Err(Box::new(errors::not_finite(span))) }
}

/// A sum, or a difference for `-`. Two temperatures on the Celsius scale have no sum, and their difference is not on
/// that scale.
fn sum(symbol: &str, left: Operand, right: Operand) -> Diagnosed<Value> {
    let is_sum = symbol == "+";
    let join = |a: &Quantity, b: &Quantity| {
        let is_celsius = if is_sum { a.is_celsius || b.is_celsius } else { a.is_celsius && !b.is_celsius };
        Quantity { si: if is_sum { a.si + b.si } else { a.si - b.si }, dimension: a.dimension, is_celsius }
    };
    match (left.1, right.1) {
        _ if is_sum && left.1.is_celsius() && right.1.is_celsius() => {
            Err(Box::new(errors::sum_of_celsius(left, right)))
        }
        (Value::Quantity(a), Value::Quantity(b)) if a.dimension == b.dimension => Ok(Value::Quantity(join(a, b))),
        (Value::Point(a), Value::Point(b)) if a.len() == b.len() && a[0].dimension == b[0].dimension => {
            Ok(Value::Point(a.iter().zip(b).map(|(a, b)| join(a, b)).collect()))
        }
        _ => Err(Box::new(errors::unlike_operands(symbol, left, right))),
    }
}

/// Rejects a Celsius operand: its kelvins would be multiplied where its degrees are meant.
fn no_celsius(symbol: &str, operands: &[Operand]) -> Diagnosed<()> {
    match operands.iter().find(|(_, value)| value.is_celsius()) {
        Some((span, value)) => Err(Box::new(errors::celsius_operand(*span, symbol, value))),
        None => Ok(()),
    }
}

fn product(span: Span, left: Operand, right: Operand) -> Diagnosed<Value> {
    no_celsius("*", &[left, right])?;
    let times = |a: Quantity, b: Quantity| {
        let dimension = a.dimension.times(b.dimension).ok_or_else(|| Box::new(errors::exponent_too_large(span)))?;
        Ok(Quantity::new(a.si * b.si, dimension))
    };
    match (left.1, right.1) {
        (Value::Quantity(a), Value::Quantity(b)) => times(*a, *b).map(Value::Quantity),
        (Value::Point(point), Value::Quantity(factor)) | (Value::Quantity(factor), Value::Point(point)) => {
            let scaled: Result<Vec<Quantity>, _> = point.iter().map(|coordinate| times(*coordinate, *factor)).collect();
            scaled.map(Value::Point)
        }
        _ => Err(Box::new(errors::unlike_operands("*", left, right))),
    }
}

fn quotient(span: Span, left: Operand, right: Operand) -> Diagnosed<Value> {
    no_celsius("/", &[left, right])?;
    let Value::Quantity(divisor) = right.1 else {
        return Err(Box::new(errors::unlike_operands("/", left, right)));
    };
    if divisor.si == 0.0 {
        return Err(Box::new(errors::division_by_zero(right.0)));
    }
    let over = |a: Quantity| {
        let dimension =
            a.dimension.over(divisor.dimension).ok_or_else(|| Box::new(errors::exponent_too_large(span)))?;
        Ok(Quantity::new(a.si / divisor.si, dimension))
    };
    match left.1 {
        Value::Quantity(a) => over(*a).map(Value::Quantity),
        Value::Point(point) => {
            let scaled: Result<Vec<Quantity>, _> = point.iter().map(|coordinate| over(*coordinate)).collect();
            scaled.map(Value::Point)
        }
        _ => Err(Box::new(errors::unlike_operands("/", left, right))),
    }
}

fn power(span: Span, left: Operand, right: Operand) -> Diagnosed<Value> {
    no_celsius("^", &[left, right])?;
    let (Value::Quantity(base), Value::Quantity(exponent)) = (left.1, right.1) else {
        return Err(Box::new(errors::unlike_operands("^", left, right)));
    };
    if base.dimension == Dimension::NUMBER && exponent.dimension == Dimension::NUMBER {
        return match base.si.power(exponent.si) {
            _ if base.si == 0.0 && exponent.si < 0.0 => Err(Box::new(errors::division_by_zero(left.0))),
            power if power.is_nan() => Err(Box::new(errors::root_of_negative(left.0, base.si))),
            power => Ok(Value::number(power)),
        };
    }
    let Some(whole) = whole(*exponent).and_then(|number| i32::try_from(number).ok()) else {
        return Err(Box::new(errors::bad_exponent(right.0, right.1)));
    };
    let dimension = base.dimension.power(whole).ok_or_else(|| Box::new(errors::exponent_too_large(span)))?;
    Ok(Value::Quantity(Quantity::new(base.si.whole_power(whole), dimension)))
}

fn comparison(operator: Operator, left: Operand, right: Operand) -> Diagnosed<Value> {
    let unlike = || Box::new(errors::unlike_operands(operator.symbol(), left, right));
    let ordering = match (left.1, right.1) {
        (Value::Quantity(a), Value::Quantity(b)) if a.dimension == b.dimension => a.si.partial_cmp(&b.si),
        _ => return Err(unlike()),
    };
    let ordering = ordering.ok_or_else(unlike)?;
    let holds = match operator {
        Operator::Equal => ordering.is_eq(),
        Operator::NotEqual => ordering.is_ne(),
        Operator::Less => ordering.is_lt(),
        Operator::LessEqual => ordering.is_le(),
        Operator::Greater => ordering.is_gt(),
        Operator::GreaterEqual => ordering.is_ge(),
        Operator::Add | Operator::Subtract | Operator::Multiply | Operator::Divide | Operator::Power => {
            return Err(unlike());
        }
    };
    Ok(Value::Bool(holds))
}

/// Whether an operator tests equality of two values of one sort other than quantities; such comparisons are evaluated
/// elsewhere.
pub fn is_equality(operator: Operator, a: &Value, b: &Value) -> bool {
    matches!(operator, Operator::Equal | Operator::NotEqual)
        && std::mem::discriminant(a) == std::mem::discriminant(b)
        && !matches!(a, Value::Quantity(_) | Value::Unknown)
}

/// Applies one of [`crate::syntax::functions::FUNCTIONS`]; `span` is the whole call.
pub fn apply_function(name: &str, span: Span, arguments: &[Spanned<Value>]) -> Diagnosed<Value> {
    if arguments.iter().any(|argument| argument.value.is_unknown()) {
        return Ok(Value::Unknown);
    }
    match (name, arguments) {
        ("abs", [a]) if a.value.is_celsius() => Err(Box::new(errors::celsius_operand(a.span, name, &a.value))),
        ("abs", [a]) => on_quantity(name, a, |q| Some(Quantity { si: q.si.abs(), ..q })),
        ("round", [a]) => on_number(name, a, f64::round),
        ("floor", [a]) => on_number(name, a, f64::floor),
        ("sqrt", [a]) => square_root(a),
        ("sin", [a]) => on_angle(name, a, Real::sine),
        ("cos", [a]) => on_angle(name, a, Real::cosine),
        ("atan2", [y, x]) => arc_tangent(y, x),
        ("count", [a]) => count(a),
        ("min" | "max", _) if !arguments.is_empty() => extreme(name, span, arguments),
        ("pose", [x, y]) => pose(x, y, None),
        ("pose", [x, y, heading]) => pose(x, y, Some(heading)),
        ("euler", [a, b, c]) => euler([a, b, c]),
        ("quaternion", [w, x, y, z]) => quaternion(span, [w, x, y, z]),
        _ => Err(Box::new(errors::wrong_arguments(span, name, arguments.len()))),
    }
}

fn on_quantity(name: &str, a: &Spanned<Value>, change: impl Fn(Quantity) -> Option<Quantity>) -> Diagnosed<Value> {
    let refused = || Box::new(errors::bad_argument(a.span, name, &a.value));
    match &a.value {
        Value::Quantity(quantity) => change(*quantity).map(Value::Quantity).ok_or_else(refused),
        _ => Err(refused()),
    }
}

fn on_number(name: &str, a: &Spanned<Value>, change: impl Fn(f64) -> f64) -> Diagnosed<Value> {
    on_quantity(name, a, |q| (q.dimension == Dimension::NUMBER).then(|| Quantity::number(change(q.si))))
}

fn on_angle(name: &str, a: &Spanned<Value>, change: impl Fn(f64) -> f64) -> Diagnosed<Value> {
    on_quantity(name, a, |q| (q.dimension == Dimension::ANGLE).then(|| Quantity::number(change(q.si))))
}

fn square_root(a: &Spanned<Value>) -> Diagnosed<Value> {
    on_quantity("sqrt", a, |q| {
        let dimension = q.dimension.square_root()?;
        (q.si >= 0.0).then(|| Quantity::new(q.si.sqrt(), dimension))
    })
}

fn arc_tangent(y: &Spanned<Value>, x: &Spanned<Value>) -> Diagnosed<Value> {
    no_celsius("atan2", &[(y.span, &y.value), (x.span, &x.value)])?;
    match (&y.value, &x.value) {
        (Value::Quantity(a), Value::Quantity(b)) if a.dimension == b.dimension => {
            Ok(Value::Quantity(Quantity::new(a.si.arc_tangent_over(b.si), Dimension::ANGLE)))
        }
        _ => Err(Box::new(errors::unlike_operands("atan2", (y.span, &y.value), (x.span, &x.value)))),
    }
}

fn count(a: &Spanned<Value>) -> Diagnosed<Value> {
    let number = match &a.value {
        Value::List(list) => list.len() as i64,
        Value::Range { from, to } => (to - from).max(0),
        Value::Table(table) => table.rows.len() as i64,
        other => return Err(Box::new(errors::bad_argument(a.span, "count", other))),
    };
    Ok(Value::number(number as f64))
}

/// The least or greatest of the arguments, or of the one list that is given.
fn extreme(name: &str, span: Span, arguments: &[Spanned<Value>]) -> Diagnosed<Value> {
    let list = match arguments {
        [Spanned { value: Value::List(list), .. }] => list,
        _ => arguments,
    };
    let Some(first) = list.first() else {
        return Err(Box::new(errors::wrong_arguments(span, name, 0)));
    };
    let mut best: Option<Quantity> = None;
    for element in list {
        let Value::Quantity(quantity) = &element.value else {
            return if element.value.is_unknown() {
                Ok(Value::Unknown)
            } else {
                Err(Box::new(errors::bad_argument(element.span, name, &element.value)))
            };
        };
        match best {
            Some(b) if b.dimension != quantity.dimension => {
                let unlike = errors::unlike_operands(name, (first.span, &first.value), (element.span, &element.value));
                return Err(Box::new(unlike));
            }
            Some(b) if (name == "min") == (quantity.si >= b.si) => {}
            _ => best = Some(*quantity),
        }
    }
    Ok(best.map_or(Value::Unknown, Value::Quantity))
}

fn pose(x: &Spanned<Value>, y: &Spanned<Value>, heading: Option<&Spanned<Value>>) -> Diagnosed<Value> {
    let coordinate = |a: &Spanned<Value>, dimension| match &a.value {
        Value::Quantity(quantity) if quantity.dimension == dimension => Ok(*quantity),
        other => Err(Box::new(errors::bad_pose(a.span, other, dimension))),
    };
    let zero = Ok(Quantity::new(0.0, Dimension::ANGLE));
    let in_pixels = matches!(&x.value, Value::Quantity(quantity) if quantity.dimension == Dimension::PIXELS);
    let along = if in_pixels { Dimension::PIXELS } else { Dimension::LENGTH };
    Ok(Value::Pose(PoseValue {
        x: coordinate(x, along)?,
        y: coordinate(y, along)?,
        heading: heading.map_or(zero, |heading| coordinate(heading, Dimension::ANGLE))?,
    }))
}

/// Intrinsic z-y-z Euler angles: each turn is about the axis as left by the turns before it.
fn euler(angles: [&Spanned<Value>; 3]) -> Diagnosed<Value> {
    let mut rad = [0.0; 3];
    for (slot, angle) in rad.iter_mut().zip(angles) {
        match &angle.value {
            Value::Quantity(quantity) if quantity.dimension == Dimension::ANGLE => *slot = quantity.si,
            other => return Err(Box::new(errors::no_angle(angle.span, other))),
        }
    }
    Ok(Value::Orientation(orientation::from_euler(rad)))
}

/// A unit quaternion; only a rounding error of its length is normalised away.
fn quaternion(span: Span, parts: [&Spanned<Value>; 4]) -> Diagnosed<Value> {
    let mut numbers = [0.0; 4];
    for (slot, part) in numbers.iter_mut().zip(parts) {
        match &part.value {
            Value::Quantity(quantity) if quantity.dimension == Dimension::NUMBER => *slot = quantity.si,
            other => return Err(Box::new(errors::bad_argument(part.span, "quaternion", other))),
        }
    }
    let norm = numbers.iter().map(|number| number * number).sum::<f64>().sqrt();
    if (norm - 1.0).abs() > orientation::NORM_SLACK {
        return Err(Box::new(errors::no_unit_quaternion(span, numbers, norm)));
    }
    Ok(Value::Orientation(orientation::unit(numbers)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::quantity::Unit;

    fn of(digits: &str, unit: &str) -> Spanned<Value> {
        let quantity = Unit::parse(unit).expect("a unit").of(digits).expect("a number");
        Spanned::new(Value::Quantity(quantity), Span::default())
    }

    fn joined(a: &Spanned<Value>, operator: Operator, b: &Spanned<Value>) -> Option<Spanned<Value>> {
        let value = apply_operator(operator, Span::default(), a, b).ok()?;
        Some(Spanned::new(value, Span::default()))
    }

    /// The scale belongs to the value, not to the way in which it was written.
    #[test]
    fn celsius_temperatures_have_differences_and_no_multiples() {
        use Operator::{Add, Divide, Multiply, Power, Subtract};
        let (warm, cool, step) = (of("60", "degC"), of("25", "degC"), of("5", "K"));
        let two = Spanned::new(Value::number(2.0), Span::default());
        let shown = |value: &Spanned<Value>| match &value.value {
            Value::Quantity(quantity) => (quantity.in_unit("K"), quantity.is_celsius),
            other => panic!("{other:?}"),
        };
        for (a, operator, b, expected) in [
            (&warm, Subtract, &cool, (35.0, false)),
            (&warm, Subtract, &step, (328.15, true)),
            (&warm, Add, &step, (338.15, true)),
            (&step, Add, &warm, (338.15, true)),
            (&step, Multiply, &two, (10.0, false)),
        ] {
            let value = joined(a, operator, b).expect("a value");
            let ((kelvins, is_celsius), (right, scale)) = (shown(&value), expected);
            assert!((kelvins - right).abs() < 1e-9 && is_celsius == scale, "{kelvins} {is_celsius}, not {expected:?}");
        }
        let warmer = joined(&warm, Add, &step).expect("a value");
        let difference = joined(&warm, Subtract, &cool).expect("a value");
        for value in [&warm, &warmer] {
            for operator in [Multiply, Divide] {
                assert!(joined(value, operator, &two).is_none() && joined(&two, operator, value).is_none());
            }
            assert!(joined(value, Add, &cool).is_none() && joined(value, Power, &two).is_none());
            assert!(apply_function("abs", Span::default(), std::slice::from_ref(value)).is_err());
        }
        assert!(joined(&difference, Multiply, &two).is_some() && joined(&cool, Add, &difference).is_some());
    }
}
