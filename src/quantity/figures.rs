//! Numbers for people: a given number of digits, rounded to the nearest or towards the side on which a sentence stays
//! true.

use crate::real::Real;
use std::fmt::Display;

/// Relative distance from a round number that counts as rounding error of arithmetic.
const ROUNDING: f64 = 1e-9;

/// The nearest value with this many significant digits.
pub fn significant(value: f64, digits: usize) -> f64 {
    let after_the_first = digits.saturating_sub(1);
    format!("{value:.after_the_first$e}").parse().unwrap_or(value)
}

/// The next value with this many significant digits that is not less: for what must be enough.
pub fn round_up(value: f64, digits: usize) -> f64 {
    directed(value * (1.0 - ROUNDING), digits, f64::ceil)
}

/// The next value with this many significant digits that is not more: for what is available.
pub fn round_down(value: f64, digits: usize) -> f64 {
    directed(value * (1.0 + ROUNDING), digits, f64::floor)
}

fn directed(value: f64, digits: usize, to_whole: impl Fn(f64) -> f64) -> f64 {
    if value <= 0.0 || !value.is_normal() {
        return value;
    }
    let decimals = digits as i32 - 1 - value.common_logarithm().floor() as i32;
    // Parsing the text gives the double nearest to the digits; a product with a power of ten need not be that.
    let scaled = to_whole(value * 10f64.whole_power(decimals));
    format!("{scaled}e{}", -decimals).parse().ok().filter(|rounded: &f64| rounded.is_finite()).unwrap_or(value)
}

/// The nearest value with this many decimals.
pub fn to_decimals(value: f64, decimals: u8) -> f64 {
    let power = 10f64.whole_power(i32::from(decimals));
    (value * power).round() / power
}

/// Greatest denominator of a number that is written as a fraction.
const MAX_DENOMINATOR: u32 = 4_096;

/// Most halvings after which a number is still written as a fraction.
const MAX_HALVINGS: u32 = 20;

/// Relative difference from a fraction that counts as rounding error.
const FRACTION_ROUNDING: f64 = 1e-12;

/// A share or a volume as a fraction such as `3/8` if it is one; otherwise in the form of [`digits`], and never as 1
/// if it is less.
pub fn fraction(value: f64) -> String {
    let numerator = |denominator: &u32| {
        let numerator = (value * f64::from(*denominator)).round();
        let is_it = (numerator / f64::from(*denominator) - value).abs() <= FRACTION_ROUNDING * value.abs();
        is_it.then_some((numerator, *denominator))
    };
    // Repeated halving gives powers of two as denominators.
    let powers = (MAX_DENOMINATOR.ilog2()..=MAX_HALVINGS).map(|halvings| 1 << halvings);
    match (1..=MAX_DENOMINATOR).chain(powers).find_map(|denominator| numerator(&denominator)) {
        Some((numerator, denominator)) if denominator > 1 => format!("{numerator}/{denominator}"),
        Some(_) | None => match digits(value) {
            one if one == "1" && value < 1.0 => format!("1 - {}", digits(1.0 - value)),
            shown => shown,
        },
    }
}

/// A count with a space between thousands: `200 000`.
pub fn grouped(count: u64) -> String {
    if count < 1000 { count.to_string() } else { format!("{} {:03}", grouped(count / 1000), count % 1000) }
}

/// A number of things: `3 switches`, `1 step`.
pub fn count<N: Display + PartialEq + From<u8>>(number: N, noun: &str) -> String {
    let plural = match number == N::from(1) {
        true => "",
        false if noun.ends_with("ch") => "es",
        false => "s",
    };
    format!("{number} {noun}{plural}")
}

/// A number with at most six significant digits, without trailing zeros; in plain notation if that is short.
pub fn digits(value: f64) -> String {
    if value == 0.0 {
        return "0".to_owned();
    }
    let exponent = value.abs().common_logarithm().floor();
    if !(-5.0..15.0).contains(&exponent) {
        // Parsing and printing it again drops trailing zeros.
        let rounded: f64 = format!("{value:.5e}").parse().unwrap_or(value);
        return format!("{rounded:e}");
    }
    let decimals = (5.0 - exponent).max(0.0) as usize;
    let text = format!("{value:.decimals$}");
    if !text.contains('.') {
        return text;
    }
    text.trim_end_matches('0').trim_end_matches('.').to_owned()
}
