//! Whether the forces of a device move its parts, and whether its steps are long enough.

use super::errors;
use super::forces::{Forces, RadiusTable};
use super::motion::Glide;
use crate::check::devices::CheckedDevice;
use crate::check::figures::Figures;
use crate::check::labels::DeviceLabel;
use crate::device::VocabularyField;
use crate::device::electrode_array::{ElectrodeArrayFacts, Electrodes, VOCABULARY};
use crate::diagnostic::Sink;
use crate::quantity::{Dimension, Quantity, round_down, round_up, significant};
use crate::real::Real;

/// Relative rounding error allowed in comparisons with a limit.
const SLACK: f64 = 1e-9;

/// Checks radius, gap, potential and step of a device against its own limits and forces.
pub fn check(facts: &ElectrodeArrayFacts, device: &CheckedDevice, sink: &mut Sink) {
    gap(device, sink);
    let forces = forces(facts, device, sink);
    // Settling time depends on the potential; if that was reported as wrong, the step cannot be judged.
    if potential(facts, forces.as_ref(), device, sink) || device.fields.contains_key("settling") {
        step(facts, forces.as_ref(), device, sink);
    }
}

fn si(device: &CheckedDevice, name: &str) -> Option<f64> {
    device.fields.si(name)
}

/// Checks the gap between neighbouring electrodes against the limits of the pitch ratio.
fn gap(device: &CheckedDevice, sink: &mut Sink) {
    let Some(ratio) = si(device, "pitch_ratio") else { return };
    let least = si(device, "least_pitch_ratio").filter(|least| ratio < least * (1.0 - SLACK));
    let most = si(device, "most_pitch_ratio").filter(|most| ratio > most * (1.0 + SLACK));
    let limits = [("least_pitch_ratio", least), ("most_pitch_ratio", most)];
    let Some((field, limit)) = limits.into_iter().find_map(|(field, limit)| Some((field, limit?))) else { return };
    let bounds = ["least_pitch_ratio", "most_pitch_ratio"].map(|name| si(device, name));
    let labels = [DeviceLabel::field("pitch_ratio", "out of the limits"), DeviceLabel::field(field, "the limit")];
    sink.push(device.labelled(errors::gap_out_of_limits(ratio, limit, bounds), labels));
}

/// The forces on a part of this device; `None` if it has no force table, or none that covers its radius.
fn forces(facts: &ElectrodeArrayFacts, device: &CheckedDevice, sink: &mut Sink) -> Option<Forces> {
    let table = match RadiusTable::of(&device.fields)? {
        Ok(table) => table,
        Err(repeated) => {
            sink.push(errors::radius_twice(length(repeated.radius_m), repeated.first, repeated.second));
            return None;
        }
    };
    let radius_m = si(device, "radius")?;
    let Some(row) = table.at(radius_m) else {
        let range = table.radii_m();
        let nearest = length(radius_m.clamp(range[0], range[1]));
        let wrong = errors::radius_out_of_table(length(radius_m), range.map(length), nearest);
        let labels = [DeviceLabel::field("radius", "not in the table"), DeviceLabel::cell(table.span, "the table")];
        sink.push(device.labelled(wrong, labels));
        return None;
    };
    let peak_at_m = radius_m * si(device, "peak_distance")?;
    let friction = si(device, "friction")?;
    Some(Forces::new(row, facts.pitch_um() / 1e6, peak_at_m, si(device, "permittivity"), friction))
}

/// Whether the potential moves a part: it must reach the measured least potential or the table's, and overcome
/// friction.
fn potential(facts: &ElectrodeArrayFacts, forces: Option<&Forces>, device: &CheckedDevice, sink: &mut Sink) -> bool {
    let potential_v = facts.potential_v;
    let measured_v = si(device, "least_potential");
    let Some(needed_v) = measured_v.or(forces.map(Forces::needed_v)) else { return true };
    let net_n = forces.map(|forces| forces.net_n(potential_v));
    let is_enough = potential_v >= needed_v * (1.0 - SLACK);
    if is_enough && net_n.is_none_or(|net_n| net_n > 0.0) {
        return true;
    }
    // The needed potential is at least the one that overcomes friction.
    let least_v = match forces.map(|forces| (forces, forces.net_n(needed_v))) {
        Some((forces, net_n)) if net_n <= 0.0 => {
            forces.balance_v().map(|balance_v| balance_v * 1.001).map(|least_v| round_up(least_v, 4))
        }
        _ => Some(round_up(needed_v, 4)),
    };
    let balance = forces.map(|forces| errors::Balance {
        lateral: force(forces.lateral_n(potential_v)),
        friction: force(forces.friction_n(potential_v)),
        net: force(forces.net_n(potential_v)),
        there: least_v.map(|least_v| force(forces.net_n(least_v))),
        known_by: match measured_v {
            _ if forces.net_n(potential_v) <= 0.0 => None,
            Some(_) => Some("`least_potential`, the least that was measured to move one"),
            None => Some("the table `forces`, measured at the potential that moves one"),
        },
    });
    let radius = length(facts.radius_um / 1e6);
    let (asked, least) = (voltage(potential_v), least_v.map(voltage));
    let most_friction =
        forces.map(|forces| round_down(forces.balance_friction(potential_v) * 0.999, 4)).filter(|_| least_v.is_none());
    let wrong = errors::potential_too_low(&asked, &radius, least.as_deref(), balance.as_ref(), most_friction);
    let mut labels = vec![DeviceLabel::field("potential", "too low")];
    if measured_v.is_some() {
        labels.push(DeviceLabel::field("least_potential", "the least that moves a part"));
    } else if is_enough {
        labels = vec![DeviceLabel::field("friction", "holds the part"), DeviceLabel::field("potential", "pulls it")];
    } else {
        labels.push(DeviceLabel::field("radius", "electrodes of this size"));
    }
    sink.push(device.labelled(wrong, labels));
    false
}

/// Checks that a part comes to rest within a step.
fn step(facts: &ElectrodeArrayFacts, forces: Option<&Forces>, device: &CheckedDevice, sink: &mut Sink) {
    let step = device.fields.quantity("step_duration");
    let settling_s = match si(device, "settling") {
        Some(measured_s) => Some(measured_s),
        None => {
            let Some(glide) = forces.and_then(|forces| glide(facts, forces, device, sink)) else { return };
            glide.settling_s()
        }
    };
    let Some(step) = step else { return };
    let by = if device.fields.contains_key("settling") { "settling" } else { "radius" };
    match settling_s {
        Some(settling_s) if step.si >= settling_s * (1.0 - SLACK) => {}
        Some(settling_s) => {
            let (step, least) = (step.to_string(), time(round_up(settling_s, 4)));
            let settling = Some(time(settling_s)).filter(|settling| *settling != step);
            let wrong = errors::step_too_short(&step, settling.as_ref().unwrap_or(&least), &least);
            let why = if by == "settling" { "known to take this long" } else { "a part of these electrodes" };
            let mut labels = vec![DeviceLabel::field("step_duration", "too short"), DeviceLabel::field(by, why)];
            let is_own = |name: &&str| device.fields.get(name).is_some_and(|field| field.span.file == device.span.file);
            let own = ["potential", "viscosity", "damping", "density", "mass"].into_iter().filter(is_own);
            labels.extend(
                own.filter(|_| by == "radius").map(|name| DeviceLabel::field(name, "settling depends on this")),
            );
            sink.push(device.labelled(wrong, labels));
        }
        None => {
            let drag = if device.fields.contains_key("damping") { "damping" } else { "viscosity" };
            let heft = if device.fields.contains_key("mass") { "mass" } else { "density" };
            let labels =
                [DeviceLabel::field(drag, "too little, or far too much"), DeviceLabel::field(heft, "against this")];
            sink.push(device.labelled(errors::never_settles(drag), labels));
        }
    }
}

/// The model of a moving part; `None` after an error.
fn glide(facts: &ElectrodeArrayFacts, forces: &Forces, device: &CheckedDevice, sink: &mut Sink) -> Option<Glide> {
    if forces.net_n(facts.potential_v) <= 0.0 {
        return None;
    }
    let pitch_m = facts.pitch_um() / 1e6;
    // Section 3.1.1 of the paper: as wide as the body, half an electrode radius thick.
    let thickness_m = facts.radius_um / 1e6 / 2.0;
    let width_m = 2.0 * facts.layout.half_width_pitches * pitch_m;
    let mass_kg =
        si(device, "mass").or(si(device, "density").map(|density| density * width_m.whole_power(2) * thickness_m));
    // Section 3.2: viscosity times the area of the square between the part's electrodes, over half an electrode radius.
    let square_m = match facts.layout.electrodes {
        Electrodes::Quad => 2.0 * pitch_m,
        Electrodes::Single => width_m,
    };
    let damping = si(device, "damping")
        .or(si(device, "viscosity").map(|viscosity| viscosity * square_m.whole_power(2) / thickness_m));
    let (Some(mass_kg), Some(damping)) = (mass_kg, damping) else {
        let lacking = [("density", mass_kg), ("viscosity", damping)];
        let lacking = lacking.into_iter().filter(|(_, figure)| figure.is_none()).map(|(name, _)| name);
        let missing: Vec<&VocabularyField> =
            lacking.filter_map(|name| VOCABULARY.fields.iter().find(|field| field.name == name)).collect();
        let owner = format!("device `{}`", device.name);
        sink.push(errors::missing_fields(device.span, &owner, &missing, Some(VOCABULARY.library)));
        return None;
    };
    let rest_share = si(device, "rest_share")?;
    Some(Glide { pull: forces.pull(facts.potential_v), mass_kg, damping, pitch_m, rest_share })
}

fn length(m: f64) -> String {
    Quantity::new(m, Dimension::LENGTH).to_string()
}

fn voltage(v: f64) -> String {
    Quantity::voltage(v).to_string()
}

fn time(s: f64) -> String {
    Quantity::new(significant(s, 4), Dimension::TIME).to_string()
}

/// A force for a message, with four digits: one more than in the table.
fn force(n: f64) -> String {
    Quantity::new(significant(n, 4), Dimension::FORCE).to_string()
}
