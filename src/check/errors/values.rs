//! Units and values: E03xx.

use super::either;
use crate::check::value::Value;
use crate::device;
use crate::diagnostic::{Code, Diagnostic};
use crate::quantity::{self, Dimension, Quantity, Unit, digits};
use crate::source::{Span, Spanned};
use crate::syntax::functions::function_form;
use crate::syntax::tree::{Expr, ExprKind, Ident};

/// Name of a field, an argument or a parameter in messages, and where it is declared.
#[derive(Debug, Clone)]
pub struct WantedName {
    /// "`stroke` of device `bot`".
    pub name: String,
    /// Its meaning, from its table; empty where there is none.
    pub doc: String,
    /// The declaration it belongs to.
    pub declared: Option<(Span, String)>,
}

impl WantedName {
    fn declared_on(&self, diagnostic: Diagnostic) -> Diagnostic {
        match &self.declared {
            Some((span, text)) if diagnostic.span() != Some(*span) => diagnostic.label(*span, text.clone()),
            _ => diagnostic,
        }
    }
}

pub fn wrong_dimension(wanted: &WantedName, dimension: Dimension, span: Span, found: &Value) -> Diagnostic {
    let title = format!("{} must be {}, but this is {}", wanted.name, dimension.with_article(), found.describe_fully());
    let diagnostic = Diagnostic::new(Code::E0301, title).label(span, found.describe());
    wanted.declared_on(diagnostic).help(dimension_help(wanted, dimension, found, &example(dimension, found)))
}

fn dimension_help(wanted: &WantedName, dimension: Dimension, found: &Value, example: &str) -> String {
    let unit = dimension.example_unit();
    let about = if wanted.doc.is_empty() { String::new() } else { format!(" ({})", wanted.doc) };
    match found {
        Value::Quantity(quantity) if quantity.dimension == Dimension::NUMBER && !unit.is_empty() => {
            let other = second_unit(dimension, example);
            format!("give the number its unit, as `{example}`{other}{about}")
        }
        _ if unit.is_empty() => format!("write a plain number without a unit{about}"),
        _ => format!("write {} with its unit, as `{example}`{about}", dimension.with_article()),
    }
}

/// A second likely unit, for the help: milliseconds and seconds are equally likely for a time, degrees and radians for
/// an angle. Both are shown, and no edit writes either.
fn second_unit(dimension: Dimension, example: &str) -> String {
    match example.split_once(' ') {
        Some((number, "ms")) if dimension == Dimension::TIME => format!(" or `{number} s`"),
        Some((number, "s")) if dimension == Dimension::TIME => format!(" or `{number} ms`"),
        Some((number, "deg")) if dimension == Dimension::ANGLE => format!(" or `{number} rad`"),
        _ => String::new(),
    }
}

/// The likely unit of a value that lacks one: times below 1 are meant in seconds.
fn likely_unit(dimension: Dimension, found: &Value) -> String {
    let is_small =
        |quantity: &Quantity| quantity.dimension == Dimension::NUMBER && quantity.si > 0.0 && quantity.si < 1.0;
    match found {
        Value::Quantity(quantity) if dimension == Dimension::TIME && is_small(quantity) => "s".to_owned(),
        _ => dimension.example_unit(),
    }
}

/// Whether digits make sense with the unit of an example.
fn is_plain(digits: &str) -> bool {
    const PLAIN: std::ops::RangeInclusive<f64> = 0.001..=100_000.0;
    digits.parse().is_ok_and(|number: f64| PLAIN.contains(&number.abs()))
}

/// The digits of a value with a unit that fits; `1` where the digits would make no sense there.
fn example(dimension: Dimension, found: &Value) -> String {
    let unit = likely_unit(dimension, found);
    let written = match (found, kept_unit(dimension, found)) {
        (Value::Quantity(quantity), Some(numerator)) => digits(quantity.in_unit(&numerator)),
        (Value::Quantity(quantity), None) => quantity.to_string().split(' ').next().unwrap_or_default().to_owned(),
        _ => String::new(),
    };
    format!("{} {unit}", if is_plain(&written) { written.as_str() } else { "1" })
}

/// The numerator of the likely unit if the value has its dimension, so that the value keeps its size: a length given
/// for a length per pixel is `0.02 um` in `0.02 um/px`.
fn kept_unit(dimension: Dimension, found: &Value) -> Option<String> {
    let unit = likely_unit(dimension, found);
    let (numerator, _) = unit.split_once('/')?;
    let Value::Quantity(quantity) = found else { return None };
    let is_same = Unit::parse(numerator).is_ok_and(|of| of.dimension == quantity.dimension);
    is_same.then(|| numerator.to_owned())
}

/// The text of a quantity converted from a reciprocal unit or from degrees Fahrenheit; `None` for any other unit.
fn converted(dimension: Dimension, written: &str, found: &Value) -> Option<String> {
    let Value::Quantity(quantity) = found else { return None };
    if dimension == Dimension::TEMPERATURE && written == "F" {
        let celsius = (quantity.si - FAHRENHEIT_AT_0_DEGC) * 5.0 / 9.0;
        return Some(format!("{} {}", digits(celsius), quantity::CELSIUS));
    }
    let unit = dimension.example_unit();
    let is_reciprocal = quantity.dimension.power(-1) == Some(dimension) && quantity.si != 0.0;
    is_reciprocal.then(|| format!("{} {unit}", digits(Quantity::new(1.0 / quantity.si, dimension).in_unit(&unit))))
}

/// The melting point of ice in degrees Fahrenheit, by definition.
const FAHRENHEIT_AT_0_DEGC: f64 = 32.0;

/// Improves a finding about the dimension of a number: the help shows the digits that were written, and an edit adds
/// the unit, where the digits make sense with it.
pub fn unit_mended(
    finding: Diagnostic,
    wanted: &WantedName,
    dimension: Dimension,
    expr: &Expr,
    found: &Value,
) -> Diagnostic {
    let unit = likely_unit(dimension, found);
    let (sign, inner) = match &expr.kind {
        ExprKind::Negative(inner) => ("-", inner.as_ref()),
        _ => ("", expr),
    };
    let (ExprKind::Number(number) | ExprKind::Quantity { number, .. }) = &inner.kind else { return finding };
    if finding.code != Code::E0301 || unit.is_empty() || !is_plain(number) {
        return finding;
    }
    let shown = |finding: Diagnostic, example: &str| finding.help(dimension_help(wanted, dimension, found, example));
    let example = format!("{sign}{number} {unit}");
    let ExprKind::Quantity { unit: written, .. } = &inner.kind else {
        let is_open = dimension == Dimension::TIME || dimension == Dimension::ANGLE;
        let finding = shown(finding, &example);
        return if is_open { finding } else { finding.with_fix(inner.span.after(), format!(" {unit}")) };
    };
    if let Some(meant) = quantity::unit_suggestion::suggest(&written.text, dimension) {
        return shown(finding, &format!("{sign}{number} {meant}")).with_fix(written.span, meant);
    }
    if let Some(converted) = converted(dimension, &written.text, found) {
        return shown(finding, &converted).with_fix(expr.span, converted);
    }
    match kept_unit(dimension, found) {
        Some(numerator) if written.text == numerator => shown(finding, &example).with_fix(written.span, unit),
        Some(_) => finding,
        // Any other unit would give the number another meaning: it is shown, but no edit writes it.
        None => shown(finding, &example),
    }
}

pub fn wrong_value(wanted: &WantedName, what: &str, example: &str, span: Span, found: &Value) -> Diagnostic {
    let title = format!("{} must be {what}, but this is {}", wanted.name, found.describe_fully());
    let diagnostic = Diagnostic::new(Code::E0304, title).label(span, found.describe());
    wanted.declared_on(diagnostic).help(format!("write {what}, as `{example}`"))
}

/// A list where one object belongs.
pub fn several_objects(wanted: &WantedName, noun: &str, span: Span) -> Diagnostic {
    let title = format!("{} must be the name of a {noun}, but this is a list", wanted.name);
    let diagnostic = Diagnostic::new(Code::E0304, title).label(span, "a list");
    let help = match noun {
        "fluid" => "write a line for each, or a `for` over the list",
        _ if wanted.name.starts_with("`after`") => "write `after` before each",
        _ => "write a step for each, or use `together { … }` where the device kind allows it",
    };
    wanted.declared_on(diagnostic).help(help)
}

/// `found` is the word as it was written, or empty if it was none.
pub fn wrong_word(
    wanted: &WantedName,
    choices: &[device::WordChoice],
    span: Span,
    found: &str,
    near: Option<&str>,
) -> Diagnostic {
    let words: Vec<&str> = choices.iter().map(|choice| choice.name).collect();
    let found = if found.is_empty() { "no word".to_owned() } else { format!("`{found}`") };
    let title = format!("{} must be {}, but this is {found}", wanted.name, either(&words));
    let list = choices.iter().map(|choice| format!("`{}` is {}", choice.name, choice.doc)).collect::<Vec<_>>();
    let diagnostic = Diagnostic::new(Code::E0311, title);
    wanted.declared_on(diagnostic.label(span, "not one of these words")).near_or(near, list.join("; "))
}

/// A bare name where a whole number or one of some words belongs.
pub fn neither_count_nor_word(
    wanted: &WantedName,
    words: &[&str],
    span: Span,
    found: &str,
    near: Option<&str>,
) -> Diagnostic {
    let words = either(words);
    let title = format!("{} must be a whole number or {words}, but this is `{found}`", wanted.name);
    let diagnostic =
        Diagnostic::new(Code::E0311, title).label(span, "neither one of these words nor the name of a value");
    wanted.declared_on(diagnostic).near_or(near, format!("write a whole number, or {words}"))
}

/// A bare name where true or false belongs.
pub fn no_truth_value(wanted: &WantedName, span: Span, found: &str) -> Diagnostic {
    let title = format!("{} must be true or false, but this is `{found}`", wanted.name);
    let likely = if matches!(found, "no" | "off" | "never" | "False" | "FALSE") { "false" } else { "true" };
    let diagnostic = Diagnostic::new(Code::E0311, title).label(span, "no value of this name");
    wanted.declared_on(diagnostic).help(format!("write `{likely}`")).with_fix(span, likely)
}

pub fn out_of_range(wanted: &WantedName, span: Span, found: &str, limit: &str) -> Diagnostic {
    let diagnostic = Diagnostic::new(Code::E0403, format!("{} is {found}, but must be {limit}", wanted.name));
    let what = if limit.starts_with("a ") { limit.to_owned() } else { format!("a value {limit}") };
    let about = (!wanted.doc.is_empty()).then(|| format!("write {what} ({})", wanted.doc));
    wanted.declared_on(diagnostic.label(span, format!("must be {limit}"))).help_if(about)
}

pub fn unlike_operands(symbol: &str, left: (Span, &Value), right: (Span, &Value)) -> Diagnostic {
    let title = format!("cannot apply `{symbol}` to {} and {}", left.1.describe(), right.1.describe());
    Diagnostic::new(Code::E0302, title)
        .label(left.0, left.1.describe_fully())
        .label(right.0, right.1.describe_fully())
        .help_if(operand_help(left.1, right.1))
}

fn operand_help(left: &Value, right: &Value) -> Option<String> {
    let (Value::Quantity(a), Value::Quantity(b)) = (left, right) else { return None };
    let (bare, other) = match (a.dimension == Dimension::NUMBER, b.dimension == Dimension::NUMBER) {
        (true, false) => (left, b.dimension),
        (false, true) => (right, a.dimension),
        (true, true) | (false, false) => return None,
    };
    Some(format!("give the bare number a unit, as `{}`", example(other, bare)))
}

pub fn bad_operand(span: Span, symbol: &str, operand: Span, found: &Value) -> Diagnostic {
    Diagnostic::new(Code::E0302, format!("cannot apply `{symbol}` to {}", found.describe()))
        .label(if span == operand { span } else { operand }, found.describe_fully())
}

/// A temperature on the Celsius scale in an operation that would use its kelvins.
pub fn celsius_operand(span: Span, symbol: &str, found: &Value) -> Diagnostic {
    let degrees = match found {
        Value::Quantity(quantity) => digits(quantity.in_unit(quantity::CELSIUS)),
        _ => "60".to_owned(),
    };
    let help = match symbol {
        "-" | "abs" => "write the sign before the number, as in `-5 degC`; a temperature difference is in `K`",
        _ => {
            "write `degC` after the number itself, as in `let t = 60 degC` or `[60 degC, 95 degC]`, or add kelvins to a temperature, as in `25 degC + n * 5 K`"
        }
    };
    Diagnostic::new(Code::E0302, format!("cannot apply `{symbol}` to a temperature on the Celsius scale"))
        .label(span, format!("{degrees} degC counts from the zero of the Celsius scale"))
        .help(help)
}

/// Two temperatures on the Celsius scale, added.
pub fn sum_of_celsius(left: (Span, &Value), right: (Span, &Value)) -> Diagnostic {
    let difference = match right.1 {
        Value::Quantity(quantity) => digits(quantity.in_unit(quantity::CELSIUS)),
        _ => "5".to_owned(),
    };
    Diagnostic::new(Code::E0302, "cannot add two temperatures on the Celsius scale")
        .label(left.0, left.1.describe_fully())
        .label(right.0, right.1.describe_fully())
        .help(format!("a temperature difference is in `K`: add `{difference} K`"))
}

pub fn bad_exponent(span: Span, found: &Value) -> Diagnostic {
    let title = "where the base or the exponent has a unit, the exponent must be a whole number without one";
    Diagnostic::new(Code::E0302, title)
        .label(span, found.describe_fully())
        .help("write powers of ten as in `0.25e-6 m`; a quantity with a unit can be raised only to whole powers, and `sqrt(x)` is its square root")
}

/// Units as spelt out in words, with the symbol that is meant.
const SPELT_OUT: [(&str, &str); 27] = [
    ("micron", "um"),
    ("microns", "um"),
    ("micrometer", "um"),
    ("micrometers", "um"),
    ("micrometre", "um"),
    ("micrometres", "um"),
    ("nanometer", "nm"),
    ("nanometre", "nm"),
    ("millimeter", "mm"),
    ("millimetre", "mm"),
    ("sec", "s"),
    ("secs", "s"),
    ("second", "s"),
    ("seconds", "s"),
    ("msec", "ms"),
    ("minutes", "min"),
    ("hour", "h"),
    ("hours", "h"),
    ("volt", "V"),
    ("volts", "V"),
    ("degree", "deg"),
    ("degrees", "deg"),
    ("radians", "rad"),
    ("newton", "N"),
    ("cc", "cm^3"),
    ("hr", "h"),
    ("hrs", "h"),
];

/// Units of quantities that are counted otherwise, and how those are counted.
const WITHOUT_UNITS: [(&[&str], &str); 2] = [
    (
        &["l", "L", "ml", "mL", "ul", "uL", "µl", "µL", "nl", "nL", "pl", "pL"],
        "give a volume in droplets as dispensed by a reservoir: `require sample.volume <= 2`",
    ),
    (
        &["mM", "uM", "µM", "nM", "mol", "mmol", "umol"],
        "give the content of a droplet as shares of its fluids: `require sample.dye == 1 / 4`",
    ),
];

pub fn unknown_unit(span: Span, part: &str, near: Option<&str>) -> Diagnostic {
    let list =
        "units are m s V A N J W Hz g F C Pa K with prefixes f p n u m c d k M G T, and deg rad turn min h % degC px";
    let spelt_out = SPELT_OUT.iter().find(|(word, _)| *word == part.to_lowercase()).map(|(_, unit)| *unit);
    let pair =
        part.strip_prefix(['x', 'X']).filter(|rest| !rest.is_empty() && rest.bytes().all(|b| b.is_ascii_digit()));
    if let Some(second) = pair {
        return Diagnostic::new(Code::E0303, format!("no unit is called `{part}`"))
            .label(span, "not a unit")
            .help(format!("write two numbers in brackets, as `(2, {second})`"));
    }
    if let Some(counted) = WITHOUT_UNITS.iter().find(|(units, _)| units.contains(&part)).map(|(_, counted)| counted) {
        return Diagnostic::new(Code::E0303, format!("no unit is called `{part}`"))
            .label(span, "not a unit")
            .help(*counted);
    }
    if part == quantity::CELSIUS {
        return Diagnostic::new(Code::E0303, "`degC` cannot be part of a product of units")
            .label(span, "a scale with a zero of its own cannot be multiplied")
            .help("write `degC` alone, as in `60 degC`, and `K` for a difference of temperatures");
    }
    // Some mean millihertz or millipascals, others megahertz or megapascals.
    if let Some(base) = ["Hz", "Pa"].into_iter().find(|base| part.to_lowercase() == format!("m{}", base.to_lowercase()))
    {
        return Diagnostic::new(Code::E0303, format!("no unit is called `{part}`"))
            .label(span, "capitals matter in units")
            .help(format!("write `M{base}` or `m{base}`"));
    }
    if part == "degF" {
        return Diagnostic::new(Code::E0303, "degrees Fahrenheit are not supported")
            .label(span, "not a unit")
            .help("write temperatures in `degC`: 100 degF is 37.8 degC");
    }
    // `kg/m3`
    let letters = part.trim_end_matches(|c: char| c.is_ascii_digit());
    if letters.len() < part.len() && Unit::parse(letters).is_ok() {
        return Diagnostic::new(Code::E0303, format!("no unit is called `{part}`"))
            .label(span, "unknown unit")
            .help(format!("write a power with `^`, as in `{letters}^{}`", &part[letters.len()..]));
    }
    Diagnostic::new(Code::E0303, format!("no unit is called `{part}`"))
        .label(span, "unknown unit")
        .near_or(spelt_out.or(near), list.to_owned())
}

pub fn exponent_too_large(span: Span) -> Diagnostic {
    let limit = crate::quantity::MAX_EXPONENT;
    Diagnostic::new(Code::E0303, format!("the exponent of a unit must be from -{limit} to {limit}"))
        .label(span, "too large a power")
}

pub fn not_finite(span: Span) -> Diagnostic {
    Diagnostic::new(Code::E0305, "a number is too large to represent").label(span, "out of the range of a double")
}

pub fn root_of_negative(span: Span, base: f64) -> Diagnostic {
    Diagnostic::new(Code::E0305, "a negative number cannot be raised to a fractional power")
        .label(span, format!("this is {base}"))
        .help("no real number is the result: use its absolute value, `abs(…)`")
}

pub fn division_by_zero(span: Span) -> Diagnostic {
    Diagnostic::new(Code::E0305, "division by zero").label(span, "this is 0")
}

pub fn word_too_long(span: Span) -> Diagnostic {
    let limit = crate::device::MAX_WORD_DIGITS;
    Diagnostic::new(Code::E0504, format!("a word of more than {limit} digits"))
        .label(span, "too many digits")
        .help(format!("a word has one digit for each module, at most {limit}"))
}

pub fn not_in_text(span: Span, found: &Value) -> Diagnostic {
    Diagnostic::new(
        Code::E0304,
        format!("braces in a string must hold a whole number or a string, but this is {}", found.describe_fully()),
    )
    .label(span, found.describe())
    .help("a brace itself is written `{{`")
}

pub fn no_fields_on_values(span: Span) -> Diagnostic {
    Diagnostic::new(Code::E0304, "a value has no named parts")
        .label(span, "no such part")
        .help("the name before a dot must be an imported file; write `list[0]` for an element of a list")
}

pub fn index_beyond(span: Span, index: usize, length: usize) -> Diagnostic {
    Diagnostic::new(Code::E0306, format!("index {index} is out of range for a list of length {length}"))
        .label(span, "beyond the end")
        .help_if((length > 0).then(|| format!("the last element has index {}", length - 1)))
}

pub fn not_a_list(span: Span, found: &Value) -> Diagnostic {
    Diagnostic::new(Code::E0306, format!("only a list can be indexed, but this is {}", found.describe()))
        .label(span, "not a list")
}

pub fn bad_index(span: Span, found: &Value) -> Diagnostic {
    Diagnostic::new(
        Code::E0306,
        format!("an index must be a whole number from 0, but this is {}", found.describe_fully()),
    )
    .label(span, "not an index")
    .help("elements count from 0; the last one is `list[count(list) - 1]`")
}

pub fn bad_range_end(span: Span, found: &Value) -> Diagnostic {
    Diagnostic::new(Code::E0304, format!("a range runs between whole numbers, but this is {}", found.describe_fully()))
        .label(span, "not a whole number")
        .help("count in whole numbers and scale inside the loop: `for i in 0..4 { … i * 1 um … }`")
}

pub fn too_many_elements(span: Span, count: usize) -> Diagnostic {
    let limit = crate::check::evaluate::MAX_ELEMENTS;
    Diagnostic::new(Code::E0308, format!("{count} elements; at most {limit} are allowed")).label(span, "too many")
}

pub fn too_many_repetitions(span: Span, limit: usize) -> Diagnostic {
    Diagnostic::new(Code::E0308, format!("`for` repeats more than {limit} times in this program"))
        .label(span, "the limit is exceeded here")
        .help("build a scene this large from larger shapes, as in `cells { from: …, to: … }`")
}

pub fn too_many_outlines(span: Span) -> Diagnostic {
    Diagnostic::new(Code::E0308, "more curves and solids than can be evaluated in one program")
        .label(span, "the limit is exceeded here")
        .help("remove parts that no task holds, or split the file into several programs")
}

pub fn repeats_nothing(span: Span) -> Diagnostic {
    Diagnostic::new(Code::W0301, "this `for` repeats nothing")
        .label(span, "has no elements")
        .help("a range excludes its end: `0..4` is 0, 1, 2, 3; remove the loop if nothing is meant to repeat")
}

pub fn not_to_repeat(span: Span, found: &Value) -> Diagnostic {
    Diagnostic::new(Code::E0304, format!("`for` runs over a range or a list, but this is {}", found.describe_fully()))
        .label(span, found.describe())
        .help(match found {
            Value::Table(_) => "write a list of its values, as `for p in [(3, 4), (5, 6)] { … }`",
            _ => "write `for i in 0..4 { … }` or `for p in spots { … }`",
        })
}

pub fn bad_coordinate(span: Span, found: &Value) -> Diagnostic {
    Diagnostic::new(Code::E0304, format!("a point consists of numbers or lengths, but this is {}", found.describe()))
        .label(span, found.describe_fully())
        .help_if(
            matches!(found, Value::Point(_))
                .then(|| "write a list of places in `[ ]`, as `[(3, 4), (5, 6)]`".to_owned()),
        )
}

/// The text of a point with the unit of its other coordinates after each bare 0, if that is its only fault.
fn zero_without_unit(coordinates: &[Quantity]) -> Option<String> {
    let dimension = coordinates.iter().map(|one| one.dimension).find(|dimension| *dimension != Dimension::NUMBER)?;
    let whole: Option<Vec<String>> = coordinates
        .iter()
        .map(|one| match one.dimension == dimension {
            true => Some(one.to_string()),
            false => {
                (one.dimension == Dimension::NUMBER && one.si == 0.0).then(|| Quantity::new(0.0, dimension).to_string())
            }
        })
        .collect();
    Some(format!("({})", whole?.join(", ")))
}

/// `whole` is the point from bracket to bracket, with all its coordinates.
pub fn mixed_point(first: Spanned<&Value>, odd: Spanned<&Value>, whole: Span, coordinates: &[Quantity]) -> Diagnostic {
    let finding = Diagnostic::new(Code::E0310, "the coordinates of a point have different dimensions")
        .label(odd.span, odd.value.describe_fully())
        .label(first.span, first.value.describe_fully());
    match coordinates {
        [x, y, heading] if x.dimension == y.dimension && heading.dimension == Dimension::ANGLE => finding
            .help(format!("a place with a heading is a pose: write `pose({x}, {y}, {heading})`"))
            .with_fix(Span { end: whole.start, ..whole }, "pose"),
        _ => match zero_without_unit(coordinates) {
            Some(point) => finding.help(format!("give 0 its unit: write `{point}`")).with_fix(whole, point),
            None => finding.help("`(5, 3)` is a cell and `(5 um, 3 um)` is a place; a point cannot be both"),
        },
    }
}

pub fn bad_pose(span: Span, found: &Value, dimension: Dimension) -> Diagnostic {
    Diagnostic::new(
        Code::E0301,
        format!("a pose needs {} here, but this is {}", dimension.with_article(), found.describe_fully()),
    )
    .label(span, found.describe())
    .help("write `pose(8 um, 3 um, 30 deg)`: a place, then the heading from +x counter-clockwise")
}

pub fn wrong_arguments(span: Span, name: &str, count: usize) -> Diagnostic {
    let takes = match name {
        "pose" => "`pose(x, y)` or `pose(x, y, heading)`".to_owned(),
        "min" | "max" => "one list, or one or more arguments".to_owned(),
        _ => function_form(name).map_or_else(String::new, |form| format!("`{form}`")),
    };
    Diagnostic::new(Code::E0307, format!("`{name}` does not take {}", quantity::count(count, "argument")))
        .label(span, format!("takes {takes}"))
}

pub fn bad_argument(span: Span, name: &str, found: &Value) -> Diagnostic {
    let takes = match name {
        "sin" | "cos" => "an angle, as `30 deg`",
        "round" | "floor" => "a plain number: divide by a unit first, as `floor(x / 1 um)`",
        "sqrt" => "a number or a quantity in squared units, not below 0",
        "count" => "a list, a range or a table",
        _ => "quantities",
    };
    Diagnostic::new(Code::E0307, format!("`{name}` does not take {}", found.describe_fully()))
        .label(span, found.describe())
        .help(format!("`{name}` takes {takes}"))
}

pub fn not_a_shape(span: Span, found: &Value) -> Diagnostic {
    Diagnostic::new(
        Code::E0304,
        format!("only a shape can be changed by fields in braces, but this is {}", found.describe()),
    )
    .label(span, found.describe_fully())
}

pub fn cell_of_other_dimension(span: Span, found: &Value, header: &Ident, wanted: Dimension) -> Diagnostic {
    let title = format!("a column of {}s contains {}", wanted.name(), found.describe_fully());
    Diagnostic::new(Code::E0301, title)
        .label(span, found.describe())
        .label(header.span, format!("the column's unit: {}", wanted.with_article()))
}

pub fn bad_setting(span: Option<Span>, name: &str, why: &str, help: &str) -> Diagnostic {
    let diagnostic = Diagnostic::new(Code::E0309, format!("`--set {name}` {why}"));
    let diagnostic = match span {
        Some(span) => diagnostic.label(span, "declared here"),
        None => diagnostic,
    };
    diagnostic.help(help)
}

pub fn unknown_column(span: Span, name: &str, wanted: &WantedName, near: Option<&str>, known: &[&str]) -> Diagnostic {
    let columns = super::listed(known.iter().copied());
    Diagnostic::new(Code::E0312, format!("the table of {} has no column `{name}`", wanted.name))
        .label(span, "no such column")
        .near_or(near, format!("its columns are {columns}"))
}

pub fn incomplete_table(span: Span, wanted: &WantedName, missing: &[&device::VocabularyField]) -> Diagnostic {
    let (title, help) = if missing.is_empty() {
        ("has no rows".to_owned(), "write at least one row below the header".to_owned())
    } else {
        let names = super::listed(missing.iter().map(|column| column.name));
        (
            format!("lacks {names}"),
            format!("add to its header: {}", missing.iter().map(|c| c.doc).collect::<Vec<_>>().join("; ")),
        )
    };
    Diagnostic::new(Code::E0312, format!("the table of {} {title}", wanted.name)).label(span, "this table").help(help)
}

pub fn too_much_work(span: Span, limit: u64) -> Diagnostic {
    Diagnostic::new(Code::E0314, format!("checking the program takes more than {limit} evaluation steps"))
        .label(span, "the limit is exceeded here")
        .help("repeat less, and name values that are used repeatedly with `let`")
}

pub fn too_much_text(span: Span, limit: u64) -> Diagnostic {
    Diagnostic::new(Code::E0313, format!("the program builds more than {} MiB of strings", limit >> 20))
        .label(span, "the limit is exceeded here")
        .help("build strings from fewer parts")
}
