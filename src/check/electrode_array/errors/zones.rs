//! Diagnostics of heaters, detectors and magnets, and of the parts that stay there.

use crate::claims::electrode_array::{BoardZone, ZoneSort};
use crate::device::electrode_array::ElectrodeCell;
use crate::diagnostic::{Code, Diagnostic};
use crate::quantity::{Dimension, Quantity};
use crate::source::Span;

/// Most zones that a message lists.
const SHOWN_ZONES: usize = 6;

/// Two zones of one sort with a common electrode.
pub fn zones_overlap(zone: &BoardZone, other: &BoardZone, shared: ElectrodeCell) -> Diagnostic {
    let (noun, one, two) = (zone.sort.name(), &zone.name, &other.name);
    Diagnostic::new(Code::E0574, format!("{noun}s `{one}` and `{two}` share electrode {shared}"))
        .label(zone.span, "covers it too")
        .label_elsewhere(other.span, zone.span, "the other one")
        .help(format!("give each {noun} electrodes of its own, or make them one"))
}

/// A detector with room for two parts.
pub fn detector_too_large(zone: &BoardZone, [columns, rows]: [u32; 2], apart: u32) -> Diagnostic {
    let title = format!(
        "detector `{}` of {columns} × {rows} electrodes has room for two parts: parts keep {apart} apart",
        zone.name
    );
    Diagnostic::new(Code::E0574, title)
        .label(zone.span, "reads one part at a time")
        .help(format!("make it at most {apart} × {apart} electrodes, or declare two detectors"))
}

/// A zone of another sort than the step needs; `others` are the zones of that sort.
pub fn zone_of_other_sort<'n>(
    span: Span,
    zone: &BoardZone,
    sort: ZoneSort,
    others: impl Iterator<Item = &'n str>,
) -> Diagnostic {
    let (name, is) = (&zone.name, zone.sort);
    let others: Vec<String> = others.take(SHOWN_ZONES).map(|name| format!("`{name}`")).collect();
    let help = match others.as_slice() {
        [] => format!("use `{}` at a {}, or declare a {}", is.verb().name(), is.name(), sort.name()),
        some => format!("{}s of this scene: {}", sort.name(), some.join(", ")),
    };
    Diagnostic::new(
        Code::E0574,
        format!("`{name}` is a {}, but `{}` takes a {}", is.name(), sort.verb().name(), sort.name()),
    )
    .label(span, format!("a {}", is.name()))
    .label_elsewhere(zone.span, span, "declared here")
    .help(help)
}

/// A cell without a zone of a sort; `near` is the nearest cell with one.
pub fn no_zone_here(span: Span, cell: ElectrodeCell, sort: ZoneSort, near: Option<ElectrodeCell>) -> Diagnostic {
    let noun = sort.name();
    let help = match near {
        Some(near) => format!("the nearest cell with a {noun} is {near}"),
        None => format!("declare one in the scene, as `{noun} NAME at {cell}`"),
    };
    Diagnostic::new(Code::E0574, format!("there is no {noun} at {cell}"))
        .label(span, format!("`{}` takes a {noun}, or a cell of one", sort.verb().name()))
        .help(help)
}

/// A temperature out of the range of a device's heaters; `field` sets the limit.
pub fn temperature_out_of_range(span: Span, asked: Quantity, device: &str, field: &str, limit_k: f64) -> Diagnostic {
    let limit = Quantity::new(limit_k, Dimension::TEMPERATURE);
    let word = if asked.si < limit_k { "lowest" } else { "highest" };
    let title = format!("the heaters of `{device}` cannot be set to {asked}; their {word} temperature is {limit}");
    Diagnostic::new(Code::E0575, title)
        .label(span, "out of their range")
        .help(format!("write {limit}, or correct `{field}` of the device"))
}

/// A temperature at which droplets freeze, of a device that does not state that its heaters also cool. Mostly degrees
/// Celsius that were written as kelvin.
pub fn too_cold_for_heaters(span: Span, asked: Quantity) -> Diagnostic {
    let title = format!("a heater does not cool to {asked}");
    Diagnostic::new(Code::E0575, title)
        .label(span, "below the freezing point of water")
        .help("write it in `degC`, or state `least_temperature` of the device if its heaters also cool")
}

/// A heater with two requested temperatures.
pub fn two_temperatures(name: &str, asked_k: f64, span: Span, first_k: f64, first: Span) -> Diagnostic {
    let text = |si: f64| Quantity::new(si, Dimension::TEMPERATURE).to_string();
    let (asked, before) = (text(asked_k), text(first_k));
    Diagnostic::new(Code::E0575, format!("heater `{name}` is set to {asked}, but also to {before}"))
        .label(span, asked)
        .label_elsewhere(first, span, before)
        .help("declare another heater for one of them: a heater keeps one temperature for the whole program")
}

/// A temperature that no heater of the drivers is set to; `set` has the instrument, heater number and setting in
/// degrees Celsius of each.
pub fn no_heater_so_warm(
    name: &str,
    asked_k: f64,
    span: Span,
    setting: Option<u32>,
    set: &[(&str, u32, u32)],
) -> Diagnostic {
    let asked = Quantity::new(asked_k, Dimension::TEMPERATURE).to_string();
    let heaters: Vec<String> =
        set.iter().map(|(driver, number, degc)| format!("`heater{number}` of `{driver}` to {degc} degC")).collect();
    let (driver, number, degc) = set[0];
    let other = setting.map(|setting| format!("write `heater{number}: {setting} degC` for `{driver}`, or "));
    Diagnostic::new(Code::W0514, format!("`{name}` is to be at {asked}, but no heater of the bench is set to that"))
        .label(span, asked)
        .help(format!(
            "the bench sets {}: {}write `to {degc} degC` here",
            heaters.join(", "),
            other.unwrap_or_default()
        ))
}

/// A droplet held by a magnet of the scene while every magnet that the bench switches is down; `output` switches one of
/// these.
pub fn no_magnet_raised(magnet: &str, span: Span, output: &str) -> Diagnostic {
    let title = format!("`{magnet}` holds a droplet while the magnets of the bench are down");
    Diagnostic::new(Code::W0516, title).label(span, "nothing is held here").help(format!(
        "write `set {output} to high` before the `assay` with this `hold`, and `set {output} to low` after it"
    ))
}

/// A droplet that is split after it was held by a magnet: its name and its half's, their last cells, and whether these
/// are over the magnet.
pub fn beads_left_behind(
    [part, half]: [&str; 2],
    [end, other_end]: [ElectrodeCell; 2],
    stays: [bool; 2],
    magnet: &BoardZone,
    span: Span,
) -> Diagnostic {
    let name = &magnet.name;
    let (title, help) = match stays {
        [false, true] => (
            format!("magnet `{name}` holds what is in `{part}`, but `{half}` gets it"),
            format!("write `to {end}`, so that `{part}` stays over the magnet"),
        ),
        [false, false] => (
            format!("magnet `{name}` holds what is in `{part}`, but neither `{part}` nor `{half}` stays over it"),
            format!("give `{name}` one more electrode, where `{part}` ends: {end}"),
        ),
        [true, _] => (
            format!("magnet `{name}` holds what is in `{part}`, but both `{part}` and `{half}` stay over it"),
            format!("split it at the edge of `{name}`, so that one of them stays over the magnet"),
        ),
    };
    Diagnostic::new(Code::W0515, title)
        .label(span, format!("`{part}` ends at {end}, `{half}` at {other_end}"))
        .label_elsewhere(magnet.span, span, "the magnet")
        .help(help)
}
