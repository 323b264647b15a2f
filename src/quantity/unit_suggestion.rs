//! Guesses the unit that was meant if one of a wrong dimension is written.

use super::{Dimension, PREFIXED, PREFIXES, Unit};

/// Greatest power that a suggestion contains.
const MAX_POWER: u32 = 4;

/// Units of electricity and mechanics that are often confused, such as `W` for `J`.
const CONFUSED: [&str; 7] = ["V", "A", "J", "W", "N", "C", "F"];

/// A unit of the required dimension that differs from the written one by one power, such as `g/cm^3` from `g/cm^2`,
/// or by the name after its prefix, such as `mJ` from `mW`; `None` if there is none: any other unit would change the
/// meaning of the number.
pub fn suggest(written: &str, dimension: Dimension) -> Option<String> {
    with_another_power(written, dimension).or_else(|| with_another_name(written, dimension))
}

/// Drops a factor, or else changes its power.
fn with_another_power(written: &str, dimension: Dimension) -> Option<String> {
    let starts = || std::iter::once(0).chain(written.match_indices(['*', '/']).map(|(at, _)| at + 1));
    let end = |start: usize| written[start..].find(['*', '/']).map_or(written.len(), |end| start + end);
    let left_out = starts().skip(1).map(|start| format!("{}{}", &written[..start - 1], &written[end(start)..]));
    let repowered = starts().flat_map(|start| {
        let name = written[start..end(start)].split('^').next().unwrap_or_default();
        let (before, behind) = (&written[..start], &written[end(start)..]);
        (1..=MAX_POWER).map(move |power| match power {
            1 => format!("{before}{name}{behind}"),
            _ => format!("{before}{name}^{power}{behind}"),
        })
    });
    left_out.chain(repowered).find(|unit| Unit::parse(unit).is_ok_and(|unit| unit.dimension == dimension))
}

fn with_another_name(written: &str, dimension: Dimension) -> Option<String> {
    let (name, ..) = PREFIXED.iter().find(|(name, _, of)| *of == dimension && CONFUSED.contains(name))?;
    let prefixes = std::iter::once("").chain(PREFIXES.iter().map(|(prefix, _)| *prefix));
    prefixes
        .filter(|prefix| written.strip_prefix(prefix).is_some_and(|rest| CONFUSED.contains(&rest)))
        .map(|prefix| format!("{prefix}{name}"))
        .next()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_suggestion_keeps_the_size_of_what_is_written() {
        let of = |written: &str, dimension| suggest(written, dimension);
        assert_eq!(of("g/cm^2", Dimension::DENSITY).as_deref(), Some("g/cm^3"));
        assert_eq!(of("kg/m", Dimension::DENSITY).as_deref(), Some("kg/m^3"));
        assert_eq!(of("mm^2", Dimension::LENGTH).as_deref(), Some("mm"));
        assert_eq!(of("mm/s^2", Dimension::SPEED).as_deref(), Some("mm/s"));
        assert_eq!(of("mm/s", Dimension::LENGTH).as_deref(), Some("mm"));
        assert_eq!(of("us/s", Dimension::TIME).as_deref(), Some("us"));
        assert_eq!(of("mW", Dimension::ENERGY).as_deref(), Some("mJ"));
        assert_eq!(of("A", Dimension::VOLTAGE).as_deref(), Some("V"));
        assert_eq!(of("V", Dimension::LENGTH), None);
        assert_eq!(of("um", Dimension::SPEED), None);
        assert_eq!(of("", Dimension::LENGTH), None);
    }
}
