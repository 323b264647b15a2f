//! The facts of a hand.

use super::errors;
use crate::check::devices::CheckedDevice;
use crate::check::figures::Figures;
use crate::check::labels::DeviceLabel;
use crate::check::value::Value;
use crate::device::fingers::{Adhesion, FingersFacts, MAX_RESERVE, MAX_STEPS_PER_TURN};
use crate::diagnostic::Sink;
use std::f64::consts::TAU;

/// The fewest steps of one turn: 90 deg each.
const MIN_STEPS_PER_TURN: u32 = 4;

/// Greatest deviation of a full turn from a whole number of steps, as a share of that number: the rounding of a step
/// that was written with few digits.
const STEP_SLACK: f64 = 1e-4;

/// The largest length of a hand: a metre.
const MAX_LENGTH_UM: f64 = 1e6;

/// The smallest length that is allowed: that of an atom.
const MIN_LENGTH_UM: f64 = 1e-4;

/// Least non-zero and greatest force: a femtonewton and a newton.
const FORCES_UN: [f64; 2] = [1e-9, 1e6];

/// The slowest and the fastest tip.
const SPEEDS_UM_PER_S: [f64; 2] = [1e-3, 1e9];

/// Least non-zero and greatest friction coefficient and removal safety.
const RATIOS: [f64; 2] = [1e-6, 100.0];

/// The facts of a hand; `None` after an error.
pub fn facts(device: &CheckedDevice, sink: &mut Sink) -> Option<FingersFacts> {
    let errors = sink.errors();
    let steps_per_turn = steps_per_turn(device, sink);
    let gaiting_cost_deg = gaiting_cost_deg(device, sink);
    let mut figures = HandFigures { device, sink };
    let facts = FingersFacts {
        fingers: device.fields.count("fingers")?,
        tip_radius_um: figures.length_um("tip_radius")?,
        adhesion: if device.fields.is_set("adhesion") { Adhesion::Sticking } else { Adhesion::Absent },
        pull_off_un: figures.force_un("pull_off")?,
        max_force_un: figures.force_un("max_force")?,
        friction: figures.ratio("friction")?,
        steps_per_turn: steps_per_turn?,
        removal_safety: figures.ratio("removal_safety")?,
        gaiting_cost_deg: gaiting_cost_deg?,
        clearance_um: figures.length_um("clearance")?,
        retract_um: figures.length_um("retract")?,
        speed_um_per_s: figures.speed_um_per_s("speed")?,
        approach_um_per_s: figures.speed_um_per_s("approach_speed")?,
        rolling_um_per_s: figures.speed_um_per_s("rolling_speed")?,
        support_un: figures.force_un("support").unwrap_or(0.0),
        range_um: figures.range_um()?,
        tolerance_um: figures.length_um("tolerance")?,
        torsion_um: figures.length_um("torsion")?,
        rolling_reserve: figures.reserve("rolling_reserve")?,
    };
    if facts.slow_um() <= facts.tolerance_um {
        let labels = [
            DeviceLabel::field("tolerance", "a tip this far off counts as touching"),
            DeviceLabel::field("retract", "a tip moves off its contact by this"),
            DeviceLabel::field("clearance", "and by at least this"),
        ];
        sink.push(device.labelled(errors::tolerance_as_large_as_retract(&facts), labels));
    }
    (sink.errors() == errors).then_some(facts)
}

/// Number of steps in a full turn; `None` after an error.
fn steps_per_turn(device: &CheckedDevice, sink: &mut Sink) -> Option<u32> {
    let step = device.fields.quantity("step")?;
    let steps = TAU / step.si;
    let whole = steps.round();
    if (whole - steps).abs() > STEP_SLACK * whole.max(1.0) {
        sink.push(
            device
                .labelled(errors::step_divides_no_turn(step), [DeviceLabel::field("step", "does not divide 360 deg")]),
        );
        return None;
    }
    if !(f64::from(MIN_STEPS_PER_TURN)..=f64::from(MAX_STEPS_PER_TURN)).contains(&whole) {
        let wrong = errors::step_out_of_limits(step, whole, [MIN_STEPS_PER_TURN, MAX_STEPS_PER_TURN]);
        sink.push(device.labelled(wrong, [DeviceLabel::field("step", "too large or too small")]));
        return None;
    }
    Some(whole as u32)
}

fn gaiting_cost_deg(device: &CheckedDevice, sink: &mut Sink) -> Option<f64> {
    const MOST_DEG: f64 = 36_000.0;
    let cost = device.fields.quantity("gaiting_cost")?;
    let deg = cost.si.to_degrees();
    let is_whole = (deg - deg.round()).abs() < 1e-9 * deg.max(1.0) && deg.round() >= 1.0;
    if is_whole && deg <= MOST_DEG {
        return Some(deg.round());
    }
    sink.push(device.labelled(
        errors::gaiting_cost_not_whole(cost, MOST_DEG),
        [DeviceLabel::field("gaiting_cost", "not a whole number of degrees in this range")],
    ));
    None
}

/// Reads figures and checks them against their limits.
struct HandFigures<'a> {
    device: &'a CheckedDevice,
    sink: &'a mut Sink,
}

impl HandFigures<'_> {
    fn length_um(&mut self, name: &'static str) -> Option<f64> {
        let found = self.device.fields.quantity(name)?;
        let um = found.in_unit("um");
        let fits = um == 0.0 || (MIN_LENGTH_UM..=MAX_LENGTH_UM).contains(&um);
        self.unless(fits, name, &found.to_string(), "from 0.1 nm to 1 m");
        Some(um)
    }

    fn force_un(&mut self, name: &'static str) -> Option<f64> {
        let found = self.device.fields.quantity(name)?;
        let un = found.in_unit("uN");
        let fits = un == 0.0 || (FORCES_UN[0]..=FORCES_UN[1]).contains(&un);
        self.unless(fits, name, &found.to_string(), "from 1 fN to 1 N");
        Some(un)
    }

    fn ratio(&mut self, name: &'static str) -> Option<f64> {
        let found = self.device.fields.quantity(name)?;
        let fits = found.si == 0.0 || (RATIOS[0]..=RATIOS[1]).contains(&found.si);
        self.unless(fits, name, &found.to_string(), "from 0.000001 to 100");
        Some(found.si)
    }

    fn reserve(&mut self, name: &'static str) -> Option<f64> {
        let found = self.device.fields.quantity(name)?;
        self.unless(found.si <= MAX_RESERVE, name, &found.to_string(), "from 0 to 90 %");
        Some(found.si)
    }

    fn speed_um_per_s(&mut self, name: &'static str) -> Option<f64> {
        let found = self.device.fields.quantity(name)?;
        let um_per_s = found.in_unit("um/s");
        let fits = (SPEEDS_UM_PER_S[0]..=SPEEDS_UM_PER_S[1]).contains(&um_per_s);
        self.unless(fits, name, &found.to_string(), "from 1 nm/s to 1 km/s");
        Some(um_per_s)
    }

    fn range_um(&mut self) -> Option<[f64; 3]> {
        let Value::Point(point) = &self.device.fields.get("range")?.value else { return None };
        let range_um = [0, 1, 2].map(|axis| point.get(axis).map_or(0.0, |length| length.in_unit("um")));
        let greatest = point.iter().copied().max_by(|one, other| one.si.total_cmp(&other.si))?;
        self.unless(greatest.in_unit("um") <= MAX_LENGTH_UM, "range", &greatest.to_string(), "at most 1 m");
        let least = point.iter().copied().min_by(|one, other| one.si.total_cmp(&other.si))?;
        self.unless(least.in_unit("um") >= MIN_LENGTH_UM, "range", &least.to_string(), "at least 0.1 nm");
        Some(range_um)
    }

    fn unless(&mut self, fits: bool, name: &'static str, found: &str, limit: &str) {
        if !fits {
            let wrong = errors::hand_figure(name, &self.device.name, found, limit);
            let label = DeviceLabel::field(name, format!("must be {limit}"));
            self.sink.push(self.device.labelled(wrong, [label]));
        }
    }
}
