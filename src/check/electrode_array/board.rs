//! The facts of a board: geometry first, then the limits from forces.

use super::cells::whole_cell;
use super::physics;
use super::{errors, map, reservoirs};
use crate::check::devices::CheckedDevice;
use crate::check::figures::Figures;
use crate::check::labels::DeviceLabel;
use crate::check::value::Accepted;
use crate::check::value::{ShapeValue, Value, whole};
use crate::device::electrode_array::{
    DEFAULT_MIXER, ElectrodeArrayFacts, Electrodes, Hold, Layout, MAX_SIDE, Separation,
};
use crate::diagnostic::Sink;
use crate::quantity::{digits, round_up};

/// The facts of a complete device; `None` if parts cannot even be placed.
pub fn facts(device: &CheckedDevice, sink: &mut Sink) -> Option<ElectrodeArrayFacts> {
    let fields = &device.fields;
    let [columns, rows] = map::sides(device, sink)?;
    let mut facts = ElectrodeArrayFacts {
        columns,
        rows,
        radius_um: fields.length_um("radius")?,
        pitch_ratio: fields.si("pitch_ratio")?,
        potential_v: fields.si("potential")?,
        step_ns: fields.clock_ns("step_duration", sink)?,
        layout: layout(device, sink)?,
        hold: if fields.is_set("hold") { Hold::On } else { Hold::Off },
        dispense_ns: match fields.get("dispense_duration") {
            Some(_) => Some(fields.clock_ns("dispense_duration", sink)?),
            None => None,
        },
        mixer: mixer(device, sink)?,
        least_volume: fields.si("least_volume"),
        most_volume: fields.si("most_volume"),
        least_temperature_k: fields.si("least_temperature"),
        most_temperature_k: fields.si("most_temperature"),
        separation: separation(fields)?,
        clearance: fields.count("clearance")?,
        map: None,
        reservoirs: None,
    };
    facts.map = map::of(&facts, device, sink)?;
    facts.reservoirs = reservoirs::of(&facts, device, sink)?;
    let errors = sink.errors();
    covers_electrodes(&facts, device, sink);
    keeps_apart(&facts, device, sink);
    has_room(&facts, device, sink);
    carries_one(&facts, device, sink);
    let is_placeable = sink.errors() == errors;
    warn_of_published(&facts, device, sink);
    physics::check(&facts, device, sink);
    is_placeable.then_some(facts)
}

/// Columns and rows of the mixing loop.
fn mixer(device: &CheckedDevice, sink: &mut Sink) -> Option<[u32; 2]> {
    let Some(field) = device.fields.get("mixer") else { return Some(DEFAULT_MIXER) };
    let sides = whole_cell(&field.value);
    let is_side = |side: &i64| (2..=i64::from(MAX_SIDE)).contains(side);
    let Some([columns, rows]) = sides.filter(|sides| sides.iter().all(is_side)) else {
        sink.push(device.labelled(errors::no_mixing_loop(&field.value), [DeviceLabel::field("mixer", "no loop")]));
        return None;
    };
    Some([columns as u32, rows as u32])
}

fn separation(fields: &Accepted) -> Option<Separation> {
    let separation = match fields.get("separation").map(|field| &field.value) {
        Some(Value::Text(_)) => Separation::AsPublished,
        _ => Separation::Apart(fields.count("separation")?),
    };
    Some(separation)
}

fn layout(device: &CheckedDevice, sink: &mut Sink) -> Option<Layout> {
    let Value::Shape(shape) = &device.fields.get("part")?.value else { return None };
    let layout = layout_of(shape);
    if layout.is_none() {
        let found = electrodes_text(shape);
        sink.push(
            device
                .labelled(errors::unknown_layout(&found), [DeviceLabel::field("part", format!("{found} electrodes"))]),
        );
    }
    layout
}

/// The layout that a shape describes; `None` if no board carries it.
pub fn layout_of(shape: &ShapeValue) -> Option<Layout> {
    let half_width = shape.fields.si("half_width")?;
    let Value::Point(point) = &shape.fields.get("electrodes")?.value else { return None };
    let electrodes = match [whole(*point.first()?)?, whole(*point.get(1)?)?] {
        [1, 1] => Electrodes::Single,
        [2, 2] => Electrodes::Quad,
        _ => return None,
    };
    Some(Layout { electrodes, half_width_pitches: half_width })
}

/// The electrode count of a shape as written, such as `(3, 3)`.
pub fn electrodes_text(shape: &ShapeValue) -> String {
    match shape.fields.get("electrodes").map(|field| &field.value) {
        Some(Value::Point(point)) if point.len() == 2 => format!("({}, {})", point[0], point[1]),
        _ => "no".to_owned(),
    }
}

/// Distance from the centre of a part to the rim of its outermost electrodes, in pitches.
fn electrodes_reach(facts: &ElectrodeArrayFacts) -> f64 {
    f64::from(facts.layout.electrodes.rim()) + 1.0 / (2.0 + facts.pitch_ratio)
}

fn covers_electrodes(facts: &ElectrodeArrayFacts, device: &CheckedDevice, sink: &mut Sink) {
    let (half, reach) = (facts.layout.half_width_pitches, electrodes_reach(facts));
    if half < reach * (1.0 - 1e-9) {
        let wrong = errors::body_too_small(half, round_up(reach, 4));
        sink.push(device.labelled(
            wrong,
            [DeviceLabel::field("part", format!("reaches {} pitches from its centre", digits(half)))],
        ));
    }
}

/// Reports boards on which parts would touch or pull on each other, or pass over obstacles.
fn keeps_apart(facts: &ElectrodeArrayFacts, device: &CheckedDevice, sink: &mut Sink) {
    let half = facts.layout.half_width_pitches;
    let apart = facts.separation.apart();
    let by_bodies = beyond(2.0 * half);
    let by_pull = facts.layout.electrodes.least_apart();
    if apart < by_bodies {
        let wrong = errors::bodies_touch(apart, 2.0 * half, by_bodies.max(by_pull));
        sink.push(
            device.labelled(
                wrong,
                [DeviceLabel::field("separation", "too small"), DeviceLabel::field("part", "this wide")],
            ),
        );
    } else if apart < by_pull {
        let wrong = errors::parts_pulled(apart, by_pull);
        sink.push(device.labelled(wrong, [DeviceLabel::field("separation", "too small")]));
    }
    if facts.clearance < beyond(half) {
        let wrong = errors::obstacle_under_body(facts.clearance, half, beyond(half));
        sink.push(
            device.labelled(
                wrong,
                [DeviceLabel::field("clearance", "too small"), DeviceLabel::field("part", "this wide")],
            ),
        );
    }
}

/// The least whole number above a figure, up to a rounding error.
fn beyond(figure: f64) -> u32 {
    // A cast saturates at the largest integer.
    ((figure * (1.0 + 1e-9)).floor() as u32).saturating_add(1)
}

fn has_room(facts: &ElectrodeArrayFacts, device: &CheckedDevice, sink: &mut Sink) {
    if facts.reach().is_some() {
        return;
    }
    let least = 2 * facts.layout.electrodes.rim() + 1;
    let narrow = [("columns", facts.columns), ("rows", facts.rows)].into_iter().filter(|(_, count)| *count < least);
    let labels = narrow.map(|(name, _)| DeviceLabel::field(name, "too few"));
    sink.push(device.labelled(errors::board_too_small(facts.columns, facts.rows, least), labels));
}

/// Reports volume limits that exclude a droplet as dispensed.
fn carries_one(facts: &ElectrodeArrayFacts, device: &CheckedDevice, sink: &mut Sink) {
    let limits = [("least_volume", facts.least_volume.filter(|least| *least > 1.0))];
    let limits = limits.into_iter().chain([("most_volume", facts.most_volume.filter(|most| *most < 1.0))]);
    for (field, limit) in limits.filter_map(|(field, limit)| Some((field, limit?))) {
        let label = DeviceLabel::field(field, "in droplets as they are dispensed");
        sink.push(device.labelled(errors::no_droplet_fits(field, limit), [label]));
    }
}

fn warn_of_published(facts: &ElectrodeArrayFacts, device: &CheckedDevice, sink: &mut Sink) {
    if facts.separation == Separation::AsPublished {
        sink.push(
            device.labelled(errors::published_separation(), [DeviceLabel::field("separation", "as it is printed")]),
        );
    }
}
