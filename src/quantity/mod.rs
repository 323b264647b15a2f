//! Dimensions, units and typed quantities: parsing and printing with SI prefixes.
//!
//! A [`Quantity`] is a number in SI base units with its [`Dimension`]. Decimal prefixes are applied to the digits
//! before they become binary, so `35 um` is the double nearest to 35·10⁻⁶ and not a rounded product.

mod figures;
pub(crate) mod unit_suggestion;

pub use figures::{count, digits, fraction, grouped, round_down, round_up, significant, to_decimals};

use crate::real::Real;
use serde::{Deserialize, Serialize};
use std::borrow::Cow;
use std::fmt;

/// The exponents of the base units metre, kilogram, second, ampere, kelvin, radian and pixel.
///
/// Angles are a dimension of their own, so that `90` cannot pass for `90 deg`; so are pixels of an image, so that no
/// pixel count passes for a length.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Default, Serialize, Deserialize)]
pub struct Dimension([i8; 7]);

const fn dimension(metre: i8, kilogram: i8, second: i8, ampere: i8, kelvin: i8, radian: i8) -> Dimension {
    Dimension([metre, kilogram, second, ampere, kelvin, radian, 0])
}

/// Largest absolute value of an exponent.
pub const MAX_EXPONENT: i8 = 12;

impl Dimension {
    pub const NUMBER: Dimension = dimension(0, 0, 0, 0, 0, 0);
    pub const LENGTH: Dimension = dimension(1, 0, 0, 0, 0, 0);
    pub const MASS: Dimension = dimension(0, 1, 0, 0, 0, 0);
    pub const TIME: Dimension = dimension(0, 0, 1, 0, 0, 0);
    pub const CURRENT: Dimension = dimension(0, 0, 0, 1, 0, 0);
    pub const TEMPERATURE: Dimension = dimension(0, 0, 0, 0, 1, 0);
    pub const ANGLE: Dimension = dimension(0, 0, 0, 0, 0, 1);
    pub const FREQUENCY: Dimension = dimension(0, 0, -1, 0, 0, 0);
    pub const SPEED: Dimension = dimension(1, 0, -1, 0, 0, 0);
    pub const ACCELERATION: Dimension = dimension(1, 0, -2, 0, 0, 0);
    pub const FORCE: Dimension = dimension(1, 1, -2, 0, 0, 0);
    pub const PRESSURE: Dimension = dimension(-1, 1, -2, 0, 0, 0);
    pub const ENERGY: Dimension = dimension(2, 1, -2, 0, 0, 0);
    pub const POWER: Dimension = dimension(2, 1, -3, 0, 0, 0);
    pub const CHARGE: Dimension = dimension(0, 0, 1, 1, 0, 0);
    pub const VOLTAGE: Dimension = dimension(2, 1, -3, -1, 0, 0);
    pub const CAPACITANCE: Dimension = dimension(-2, -1, 4, 2, 0, 0);
    pub const DENSITY: Dimension = dimension(-3, 1, 0, 0, 0, 0);
    pub const VISCOSITY: Dimension = dimension(-1, 1, -1, 0, 0, 0);
    /// Turning rate of a path: angle per length.
    pub const ANGLE_PER_LENGTH: Dimension = dimension(-1, 0, 0, 0, 0, 1);
    /// Length along a row or a column of an image.
    pub const PIXELS: Dimension = Dimension([0, 0, 0, 0, 0, 0, 1]);
    /// Length per pixel.
    pub const SCALE: Dimension = Dimension([1, 0, 0, 0, 0, 0, -1]);
    /// Voltage per time.
    pub const SLEW_RATE: Dimension = dimension(2, 1, -4, -1, 0, 0);
    /// Voltage per length.
    pub const VOLTAGE_PER_LENGTH: Dimension = dimension(1, 1, -3, -1, 0, 0);
    /// Force per speed.
    pub const DAMPING: Dimension = dimension(0, 1, -1, 0, 0, 0);

    /// The dimension of a product, if its exponents stay within [`MAX_EXPONENT`].
    pub fn times(self, other: Dimension) -> Option<Dimension> {
        self.zip(other, |a, b| a + b)
    }

    /// The dimension of a quotient, if its exponents stay within [`MAX_EXPONENT`].
    pub fn over(self, other: Dimension) -> Option<Dimension> {
        self.zip(other, |a, b| a - b)
    }

    /// The dimension of a whole power, if its exponents stay within [`MAX_EXPONENT`].
    pub fn power(self, exponent: i32) -> Option<Dimension> {
        self.map(|a| i32::from(a).checked_mul(exponent))
    }

    /// The dimension of a square root, if every exponent is even.
    pub fn square_root(self) -> Option<Dimension> {
        self.map(|a| (a % 2 == 0).then_some(i32::from(a) / 2))
    }

    fn zip(self, other: Dimension, join: impl Fn(i32, i32) -> i32) -> Option<Dimension> {
        let mut result = [0; 7];
        for (slot, (a, b)) in result.iter_mut().zip(self.0.into_iter().zip(other.0)) {
            *slot = within(join(i32::from(a), i32::from(b)))?;
        }
        Some(Dimension(result))
    }

    fn map(self, change: impl Fn(i8) -> Option<i32>) -> Option<Dimension> {
        let mut result = [0; 7];
        for (slot, a) in result.iter_mut().zip(self.0) {
            *slot = within(change(a)?)?;
        }
        Some(Dimension(result))
    }

    fn named(self) -> Option<&'static Named> {
        NAMED.iter().find(|named| named.dimension == self)
    }

    /// Its usual name with an article: `a length`, `a number`, `a quantity in m^2`.
    pub fn with_article(self) -> String {
        match self.named() {
            Some(named) => named.with_article.to_owned(),
            None => format!("a quantity in {}", self.base_units()),
        }
    }

    /// Its usual name without an article: `length`, `number`, `quantity in m^2`.
    pub fn name(self) -> String {
        let name = self.with_article();
        name.split_once(' ').map_or(name.clone(), |(_, rest)| rest.to_owned())
    }

    /// A common unit, for an example in a message: `um`, `ms`, `V`; empty for a plain number.
    pub fn example_unit(self) -> String {
        self.named().map_or_else(|| self.base_units(), |named| named.example.to_owned())
    }

    /// Its common units, with everyday prefixes; empty for a plain number.
    pub fn usual_units(self) -> Vec<String> {
        let prefixed = PREFIXED.iter().filter(|unit| unit.2 == self);
        let prefixed = prefixed.flat_map(|unit| ["n", "u", "m", ""].map(|prefix| format!("{prefix}{}", unit.0)));
        let plain = PLAIN.iter().filter(|unit| unit.3 == self && self != Dimension::NUMBER);
        let units: Vec<String> = prefixed.chain(plain.map(|unit| unit.0.to_owned())).collect();
        let example = || Some(self.example_unit()).filter(|unit| !unit.is_empty()).into_iter().collect();
        if units.is_empty() { example() } else { units }
    }

    fn base_units(self) -> String {
        let mut text = String::new();
        for (exponent, unit) in self.0.into_iter().zip(["m", "kg", "s", "A", "K", "rad", "px"]) {
            if exponent == 0 {
                continue;
            }
            if !text.is_empty() {
                text.push('*');
            }
            text.push_str(unit);
            if exponent != 1 {
                text.push_str(&format!("^{exponent}"));
            }
        }
        text
    }
}

fn within(exponent: i32) -> Option<i8> {
    i8::try_from(exponent).ok().filter(|e| e.abs() <= MAX_EXPONENT)
}

/// A dimension with a name, the unit in which it is printed, and the unit of examples.
struct Named {
    dimension: Dimension,
    with_article: &'static str,
    /// The unit that takes SI prefixes when a value is printed; empty if there is none.
    symbol: &'static str,
    example: &'static str,
}

const NAMED: &[Named] = &[
    named(Dimension::NUMBER, "a number", "", ""),
    named(Dimension::LENGTH, "a length", "m", "um"),
    named(Dimension::MASS, "a mass", "g", "ug"),
    named(Dimension::TIME, "a time", "s", "ms"),
    named(Dimension::CURRENT, "a current", "A", "mA"),
    named(Dimension::TEMPERATURE, "a temperature", CELSIUS, CELSIUS),
    named(Dimension::ANGLE, "an angle", "", "deg"),
    named(Dimension::FREQUENCY, "a frequency", "Hz", "kHz"),
    named(Dimension::SPEED, "a speed", "m/s", "um/s"),
    named(Dimension::ACCELERATION, "an acceleration", "m/s^2", "mm/s^2"),
    named(Dimension::FORCE, "a force", "N", "uN"),
    named(Dimension::PRESSURE, "a pressure", "Pa", "kPa"),
    named(Dimension::ENERGY, "an energy", "J", "mJ"),
    named(Dimension::POWER, "a power", "W", "mW"),
    named(Dimension::CHARGE, "a charge", "C", "nC"),
    named(Dimension::VOLTAGE, "a voltage", "V", "V"),
    named(Dimension::CAPACITANCE, "a capacitance", "F", "pF"),
    named(Dimension::DENSITY, "a density", "kg/m^3", "kg/m^3"),
    named(Dimension::VISCOSITY, "a viscosity", "Pa*s", "Pa*s"),
    named(Dimension::ANGLE_PER_LENGTH, "a turning rate", "deg/mm", "deg/mm"),
    named(Dimension::PIXELS, "a number of pixels", "px", "px"),
    named(Dimension::SCALE, "a scale", "um/px", "um/px"),
    named(Dimension::SLEW_RATE, "a slew rate", "V/s", "V/us"),
    named(Dimension::VOLTAGE_PER_LENGTH, "a sensitivity", "V/m", "V/um"),
    named(Dimension::DAMPING, "a damping", "N*s/m", "uN*s/m"),
];

const fn named(dimension: Dimension, with_article: &'static str, symbol: &'static str, example: &'static str) -> Named {
    Named { dimension, with_article, symbol, example }
}

/// A unit: a power of ten, a further factor (1 except for `deg`, `turn`, `min`, `h`), and a dimension. Its zero is at
/// `zero` base units (0 except for `degC`).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Unit {
    ten: i32,
    factor: f64,
    zero: f64,
    pub dimension: Dimension,
}

/// The zero of the Celsius scale, in kelvin.
const CELSIUS_ZERO_K: f64 = 273.15;

/// The unit of temperature whose zero differs from that of its base unit; it must stand alone, not in products.
pub const CELSIUS: &str = "degC";

/// The units that take the prefixes of [`PREFIXES`]: name, power of ten of the unprefixed unit in base units,
/// dimension.
pub(crate) const PREFIXED: &[(&str, i32, Dimension)] = &[
    ("m", 0, Dimension::LENGTH),
    ("s", 0, Dimension::TIME),
    ("V", 0, Dimension::VOLTAGE),
    ("A", 0, Dimension::CURRENT),
    ("N", 0, Dimension::FORCE),
    ("J", 0, Dimension::ENERGY),
    ("W", 0, Dimension::POWER),
    ("Hz", 0, Dimension::FREQUENCY),
    ("g", -3, Dimension::MASS),
    ("F", 0, Dimension::CAPACITANCE),
    ("C", 0, Dimension::CHARGE),
    ("Pa", 0, Dimension::PRESSURE),
    ("K", 0, Dimension::TEMPERATURE),
];

pub(crate) const PREFIXES: &[(&str, i32)] = &[
    ("f", -15),
    ("p", -12),
    ("n", -9),
    ("u", -6),
    ("µ", -6),
    ("μ", -6),
    ("m", -3),
    ("c", -2),
    ("d", -1),
    ("k", 3),
    ("M", 6),
    ("G", 9),
    ("T", 12),
];

/// The units without prefixes: name, power of ten, further factor, dimension.
pub(crate) const PLAIN: &[(&str, i32, f64, Dimension)] = &[
    ("deg", 0, std::f64::consts::PI / 180.0, Dimension::ANGLE),
    ("rad", 0, 1.0, Dimension::ANGLE),
    ("turn", 0, std::f64::consts::TAU, Dimension::ANGLE),
    ("px", 0, 1.0, Dimension::PIXELS),
    ("min", 0, 60.0, Dimension::TIME),
    ("h", 0, 3600.0, Dimension::TIME),
    (CELSIUS, 0, 1.0, Dimension::TEMPERATURE),
    ("%", -2, 1.0, Dimension::NUMBER),
];

/// Reason why a text is not a unit.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum UnitError {
    /// Unknown unit, with the nearest known one, if one is near.
    Unknown { part: String, nearest: Option<String> },
    /// An exponent beyond [`MAX_EXPONENT`].
    ExponentTooLarge,
}

impl Unit {
    /// The unit of a plain number.
    pub const ONE: Unit = Unit { ten: 0, factor: 1.0, zero: 0.0, dimension: Dimension::NUMBER };

    /// Parses a unit without spaces: factors joined by `*` and `/` from left to right, each with an optional integer
    /// power after `^`.
    pub fn parse(text: &str) -> Result<Unit, UnitError> {
        if text == CELSIUS {
            return Ok(Unit { ten: 0, factor: 1.0, zero: CELSIUS_ZERO_K, dimension: Dimension::TEMPERATURE });
        }
        let mut unit = Unit::ONE;
        let mut sign = 1;
        let mut rest = text;
        loop {
            let end = rest.find(['*', '/']).unwrap_or(rest.len());
            let (factor, exponent) = power(&rest[..end])?;
            unit = unit.times(factor, exponent * sign).ok_or(UnitError::ExponentTooLarge)?;
            if end == rest.len() {
                break;
            }
            sign = if rest.as_bytes()[end] == b'/' { -1 } else { 1 };
            rest = &rest[end + 1..];
        }
        Ok(unit)
    }

    fn times(self, other: Unit, exponent: i32) -> Option<Unit> {
        Some(Unit {
            ten: self.ten + other.ten * exponent,
            factor: self.factor * other.factor.whole_power(exponent),
            zero: 0.0,
            dimension: self.dimension.times(other.dimension.power(exponent)?)?,
        })
    }

    /// The quantity of `digits` in this unit; `digits` is a decimal number in Rust's notation.
    ///
    /// `None` if the digits are not a number or the result is not finite.
    pub fn of(self, digits: &str) -> Option<Quantity> {
        let (mantissa, exponent) = match digits.split_once(['e', 'E']) {
            Some((mantissa, exponent)) => (mantissa, exponent.parse::<i32>().ok()?),
            None => (digits, 0),
        };
        let ten = exponent.checked_add(self.ten)?;
        let scaled: f64 = format!("{mantissa}e{ten}").parse().ok()?;
        let si = scaled * self.factor + self.zero;
        si.is_finite().then_some(Quantity { si, dimension: self.dimension, is_celsius: self.zero != 0.0 })
    }
}

/// A unit in its canonical spelling: `um` for `µm`. A text that is not a unit is returned unchanged.
pub fn canonical_unit(text: &str) -> Cow<'_, str> {
    const MICRO: [char; 2] = ['µ', 'μ'];
    if text.contains(MICRO) && Unit::parse(text).is_ok() { text.replace(MICRO, "u").into() } else { text.into() }
}

fn power(text: &str) -> Result<(Unit, i32), UnitError> {
    let (name, exponent) = match text.split_once('^') {
        Some((name, digits)) => (name, digits.parse::<i32>().map_err(|_| unknown(text))?),
        None => (text, 1),
    };
    if exponent.abs() > i32::from(MAX_EXPONENT) {
        return Err(UnitError::ExponentTooLarge);
    }
    single(name).map(|unit| (unit, exponent)).ok_or_else(|| unknown(name))
}

fn single(name: &str) -> Option<Unit> {
    let is_factor = |unit: &&(&str, i32, f64, Dimension)| unit.0 == name && name != CELSIUS;
    if let Some(&(_, ten, factor, dimension)) = PLAIN.iter().find(is_factor) {
        return Some(Unit { ten, factor, zero: 0.0, dimension });
    }
    let prefixes = std::iter::once(("", 0)).chain(PREFIXES.iter().copied());
    for (prefix, prefix_ten) in prefixes {
        let Some(rest) = name.strip_prefix(prefix) else { continue };
        if let Some(&(_, ten, dimension)) = PREFIXED.iter().find(|unit| unit.0 == rest) {
            return Some(Unit { ten: ten + prefix_ten, factor: 1.0, zero: 0.0, dimension });
        }
    }
    None
}

fn unknown(part: &str) -> UnitError {
    if part == CELSIUS {
        return UnitError::Unknown { part: part.to_owned(), nearest: Some("K".to_owned()) };
    }
    let nearest = common_units()
        .into_iter()
        .map(|unit| (strsim::osa_distance(&unit.to_lowercase(), &part.to_lowercase()), unit))
        // One-letter units are near to every other one; only a change of case counts for them.
        .filter(|(distance, unit)| *distance == 0 || *distance == 1 && unit.len() > 1)
        .min()
        .map(|(_, unit)| unit);
    UnitError::Unknown { part: part.to_owned(), nearest }
}

/// Common units, for suggestions and completions.
pub fn common_units() -> Vec<String> {
    let mut units: Vec<String> = PLAIN.iter().map(|unit| unit.0.to_owned()).collect();
    for (name, _, _) in PREFIXED {
        units.extend(["", "n", "u", "m", "k"].iter().map(|prefix| format!("{prefix}{name}")));
    }
    units
}

/// A number in SI base units (radians for an angle) with its dimension; always finite.
#[derive(Debug, Clone, Copy)]
pub struct Quantity {
    pub si: f64,
    pub dimension: Dimension,
    /// Whether it is a point on the Celsius scale. Such points have differences, but neither multiples nor sums:
    /// twice 30 degC would be 333.15 degC.
    pub is_celsius: bool,
}

/// Equal temperatures are equal whatever scale they were written in.
impl PartialEq for Quantity {
    fn eq(&self, other: &Quantity) -> bool {
        (self.si, self.dimension) == (other.si, other.dimension)
    }
}

impl Quantity {
    /// A plain number.
    pub fn number(value: f64) -> Self {
        Quantity::new(value, Dimension::NUMBER)
    }

    /// A quantity in base units of a dimension.
    pub fn new(si: f64, dimension: Dimension) -> Self {
        Quantity { si, dimension, is_celsius: false }
    }

    pub fn length_um(um: f64) -> Self {
        Quantity::new(um / 1e6, Dimension::LENGTH)
    }

    pub fn force_un(un: f64) -> Self {
        Quantity::new(un / 1e6, Dimension::FORCE)
    }

    pub fn voltage(volts: f64) -> Self {
        Quantity::new(volts, Dimension::VOLTAGE)
    }

    pub fn time_ns(ns: u64) -> Self {
        Quantity::new(ns as f64 / 1e9, Dimension::TIME)
    }

    /// The value in a unit of its own dimension, without the error of a product with a power of ten.
    pub fn in_unit(self, unit: &str) -> f64 {
        let unit = Unit::parse(unit).expect("only units of the closed list are named in the compiler");
        assert_eq!(unit.dimension, self.dimension);
        shift((self.si - unit.zero) / unit.factor, -unit.ten)
    }
}

/// `value` times 10^`ten`, rounded once: multiplication for growing, division for shrinking, both by an exactly
/// representable power.
fn shift(value: f64, ten: i32) -> f64 {
    if ten >= 0 { value * 10f64.whole_power(ten) } else { value / 10f64.whole_power(-ten) }
}

/// Prints with at most six significant digits and the prefix that leaves one to three digits before the point.
impl fmt::Display for Quantity {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if self.dimension == Dimension::ANGLE {
            return write!(f, "{} deg", digits(self.si.to_degrees()));
        }
        if self.dimension == Dimension::ANGLE_PER_LENGTH {
            return write!(f, "{} deg/mm", digits(self.in_unit("deg/mm")));
        }
        match self.dimension.named().map(|named| named.symbol) {
            Some("") => f.write_str(&digits(self.si)),
            // Nobody counts in kilopixels.
            Some("px") => write!(f, "{} px", digits(self.si)),
            Some("um/px") => write!(f, "{} um/px", digits(self.in_unit("um/px"))),
            Some(CELSIUS) => write!(f, "{} {CELSIUS}", digits(self.in_unit(CELSIUS))),
            // `kg` has its prefix already.
            Some(symbol) if symbol.starts_with("kg") => write!(f, "{} {symbol}", digits(self.si)),
            Some(symbol) => prefixed(f, self.si, symbol),
            None => write!(f, "{} {}", digits(self.si), self.dimension.base_units()),
        }
    }
}

fn prefixed(f: &mut fmt::Formatter<'_>, si: f64, symbol: &str) -> fmt::Result {
    let own_ten = PREFIXED.iter().find(|unit| unit.0 == symbol).map_or(0, |unit| unit.1);
    let value = shift(si, -own_ten);
    if value == 0.0 {
        let example = NAMED.iter().find(|named| named.symbol == symbol).map_or(symbol, |named| named.example);
        return write!(f, "0 {example}");
    }
    const PRINTED: [(&str, i32); 9] =
        [("f", -15), ("p", -12), ("n", -9), ("u", -6), ("m", -3), ("", 0), ("k", 3), ("M", 6), ("G", 9)];
    // Nobody speaks of kiloseconds.
    let greatest = if symbol == "s" { 0 } else { 9 };
    let fits = |&&(_, ten): &&(&str, i32)| ten <= greatest && shift(value.abs(), -ten) >= 0.999_999_5;
    let (prefix, ten) = PRINTED.iter().rev().find(fits).copied().unwrap_or(PRINTED[0]);
    write!(f, "{} {prefix}{symbol}", digits(shift(value, -ten)))
}

#[cfg(test)]
mod tests;
