//! The facts of a bed: its table, its levels, how robots meet, and bounds of errors.

use super::errors;
use super::table::RobotTable;
use super::{CheckedBed, validity};
use crate::check::devices::CheckedDevice;
use crate::check::figures::Figures;
use crate::check::labels::DeviceLabel;
use crate::device::microrobots::{Docking, Errors, Fine, MAX_ROBOTS, MicrorobotsFacts, Robot, Turning};
use crate::diagnostic::Sink;
use crate::geometry::shape::MAX_EXTENT_UM;
use crate::quantity::Quantity;
use std::collections::BTreeMap;
use std::f64::consts::{FRAC_PI_2, PI};
use std::sync::Arc;

/// The fields that bound errors of robots and measurements.
const ERROR_FIELDS: [&str; 5] = ["speed_error", "turning_error", "place_error", "heading_error", "replan_interval"];

/// Greatest number of cycles in a fine motion.
const MAX_CYCLES: f64 = 2_000.0;

/// The facts of a device and the control states of its bed; `None` after an error.
pub fn bed(device: &CheckedDevice, sink: &mut Sink) -> Option<CheckedBed> {
    let table = RobotTable::of(device)?;
    let errors = sink.errors();
    fits_a_bed(&table, device, sink);
    names_apart(&table, device, sink);
    (sink.errors() == errors).then_some(())?;
    let facts = facts(device, &table, sink)?;
    bodies_are_countable(&facts, &table, device, sink);
    figures_have_sense(device, sink);
    meets_forwards(&facts, device, sink);
    fine_motion_has_room(&facts, device, sink);
    levels_in_order(&facts, device, sink)?;
    let states = validity::states(&facts, &table, device, sink)?;
    (sink.errors() == errors).then(|| CheckedBed { facts: Arc::new(facts), states: Arc::new(states) })
}

fn fits_a_bed(table: &RobotTable, device: &CheckedDevice, sink: &mut Sink) {
    if table.rows() > MAX_ROBOTS {
        let wrong = errors::too_many_robots(table.rows(), MAX_ROBOTS);
        let labels = [DeviceLabel::cell(table.place(MAX_ROBOTS, "robot"), "one too many")];
        sink.push(device.labelled(wrong, labels));
    }
}

fn names_apart(table: &RobotTable, device: &CheckedDevice, sink: &mut Sink) {
    let mut seen: BTreeMap<&str, usize> = BTreeMap::new();
    for row in 0..table.rows() {
        let Some(name) = table.text(row, "robot") else { continue };
        if let Some(first) = seen.get(name) {
            let again = DeviceLabel::cell(table.place(row, "robot"), "again here");
            let labels = [again, DeviceLabel::cell(table.place(*first, "robot"), "first here")];
            sink.push(device.labelled(errors::robot_twice(name), labels));
        } else {
            seen.insert(name, row);
        }
    }
}

fn facts(device: &CheckedDevice, table: &RobotTable, sink: &mut Sink) -> Option<MicrorobotsFacts> {
    let si = |name: &str| device.fields.si(name);
    let um = |name: &str| device.fields.length_um(name);
    let period_ns = period_ns(device, sink);
    let dwell_ns = device.fields.clock_ns("dwell", sink);
    let errors = errors_of(device, sink);
    let period_ns = period_ns?;
    let robots: Option<Vec<Robot>> = (0..table.rows()).map(|row| robot(row, table, device, period_ns)).collect();
    Some(MicrorobotsFacts {
        robots: robots?,
        margin_v: si("margin")?,
        max_v: si("max_voltage")?,
        relax_v: si("relax")?,
        flex_v: si("flex")?,
        period_ns,
        dwell_ns: dwell_ns?,
        clearance_um: um("clearance")?,
        orbit_clearance_um: um("orbit_clearance")?,
        docking: Docking {
            self_aligning_rad: si("self_aligning_angle")?,
            self_aligning_um: um("self_aligning_offset")?,
            sticking_rad: si("sticking_angle")?,
            tolerance_um: um("docking_tolerance")?,
        },
        fine: Fine { length_um: um("fine_length")?, cycle_um: um("fine_cycle")? },
        errors: errors?,
        watchdog_ns: match device.fields.contains_key("watchdog") {
            true => Some(device.fields.clock_ns("watchdog", sink)?),
            false => None,
        },
    })
}

/// The time of one stroke, of two equal halves; `None` if the clock cannot count it.
fn period_ns(device: &CheckedDevice, sink: &mut Sink) -> Option<u64> {
    let frequency = device.fields.quantity("drive_frequency")?;
    let half_ns = 0.5e9 / frequency.si;
    let limit = crate::check::MAX_TIME_NS as f64 / 2.0;
    if (1.0..=limit).contains(&half_ns) {
        return Some(2 * half_ns.round() as u64);
    }
    sink.push(
        device
            .labelled(errors::stroke_out_of_clock(frequency), [DeviceLabel::field("drive_frequency", "of one stroke")]),
    );
    None
}

fn robot(row: usize, table: &RobotTable, device: &CheckedDevice, period_ns: u64) -> Option<Robot> {
    let um = |name: &str| table.quantity(row, name).or(device.fields.quantity(name)).map(|length| length.in_unit("um"));
    let step_um = match table.quantity(row, "speed") {
        Some(speed) => speed.in_unit("um/s") * period_ns as f64 / 1e9,
        None => device.fields.length_um("step_size")?,
    };
    let turning = table.text(row, "turns").and_then(Turning::find).unwrap_or_default();
    Some(Robot {
        name: table.text(row, "robot")?.to_owned(),
        snap_down_v: table.quantity(row, "snap_down")?.si,
        release_v: table.quantity(row, "release")?.si,
        turning_radius_um: um("turning_radius")?,
        step_um,
        turning,
        length_um: um("length")?,
        width_um: um("width")?,
    })
}

/// The bounds on errors, if all of them are given; the outer `None` after an error.
fn errors_of(device: &CheckedDevice, sink: &mut Sink) -> Option<Option<Errors>> {
    let is_given = |name: &&'static str| device.fields.contains_key(*name);
    let (given, missing): (Vec<&'static str>, Vec<&str>) = ERROR_FIELDS.iter().copied().partition(is_given);
    if given.is_empty() {
        return Some(None);
    }
    if !missing.is_empty() {
        let labels = given.into_iter().map(|name| DeviceLabel::field(name, "without the others"));
        sink.push(device.labelled(errors::some_error_bounds(&missing), labels));
        return Some(None);
    }
    Some(Some(Errors {
        speed_ratio: device.fields.si("speed_error")?,
        // Radians for each metre.
        turning_rad_per_um: device.fields.si("turning_error")? / 1e6,
        place_um: device.fields.length_um("place_error")?,
        heading_rad: device.fields.si("heading_error")?,
        replan_ns: device.fields.clock_ns("replan_interval", sink)?,
    }))
}

/// Least side of a body and least turning radius, in micrometres: a smaller one is a mistaken unit.
const LEAST_BODY_UM: f64 = 0.1;

/// Least length of a stroke, in micrometres; planners and the verifier count strokes.
const LEAST_STROKE_UM: f64 = 1e-5;

/// Longest fine motion, in micrometres: a few body lengths, because its cycles are walked one by one.
const MAX_FINE_UM: f64 = 1_000.0;

/// Bounds on errors beyond which nothing is known of a robot, in SI units.
const MAX_ERRORS: [(&str, f64); 4] =
    [("speed_error", 1.0), ("turning_error", 2e3 * PI), ("place_error", 1e-3), ("heading_error", PI)];

/// Rejects error bounds that bound nothing and excessive fine motions: their units are mistaken.
fn figures_have_sense(device: &CheckedDevice, sink: &mut Sink) {
    let most = MAX_ERRORS.into_iter().chain([("fine_length", MAX_FINE_UM / 1e6)]);
    for (name, most_si) in most {
        let Some(found) = device.fields.quantity(name).filter(|found| found.si > most_si) else { continue };
        let most = Quantity { si: most_si, ..found };
        sink.push(
            device.labelled(errors::beyond_figure(name, found, most), [DeviceLabel::field(name, "out of range")]),
        );
    }
}

/// Rejects lengths beyond the range of exact geometry: their units are mistaken.
fn bodies_are_countable(facts: &MicrorobotsFacts, table: &RobotTable, device: &CheckedDevice, sink: &mut Sink) {
    let mut of_device = BTreeMap::new();
    for (row, robot) in facts.robots.iter().enumerate() {
        let figures = [
            ("turning_radius", robot.turning_radius_um, LEAST_BODY_UM),
            ("length", robot.length_um, LEAST_BODY_UM),
            ("width", robot.width_um, LEAST_BODY_UM),
            ("speed", robot.step_um, LEAST_STROKE_UM),
        ];
        for (name, um, least_um) in figures {
            if (least_um..=MAX_EXTENT_UM).contains(&um) {
                continue;
            }
            match (table.quantity(row, name), name) {
                (Some(found), _) => {
                    let labels = [DeviceLabel::cell(table.place(row, name), "out of range")];
                    sink.push(device.labelled(errors::beyond_extent(name, found, least_um, MAX_EXTENT_UM), labels));
                }
                (None, "speed") => drop(of_device.insert("step_size", least_um)),
                (None, _) => drop(of_device.insert(name, least_um)),
            }
        }
    }
    let own = [
        ("clearance", facts.clearance_um),
        ("orbit_clearance", facts.orbit_clearance_um),
        ("docking_tolerance", facts.docking.tolerance_um),
    ];
    of_device.extend(own.into_iter().filter(|(_, um)| *um > MAX_EXTENT_UM).map(|(name, _)| (name, 0.0)));
    for (name, least_um) in of_device {
        let Some(found) = device.fields.quantity(name) else { continue };
        let wrong = errors::beyond_extent(name, found, least_um, MAX_EXTENT_UM);
        sink.push(device.labelled(wrong, [DeviceLabel::field(name, "out of range")]));
    }
}

/// Checks that the drive train swings upwards, and no higher than the source; `None` if it does not.
fn levels_in_order(facts: &MicrorobotsFacts, device: &CheckedDevice, sink: &mut Sink) -> Option<()> {
    let errors = sink.errors();
    let voltage = |name: &str| device.fields.text(name);
    if facts.relax_v >= facts.flex_v {
        let labels = [DeviceLabel::field("relax", "not below `flex`"), DeviceLabel::field("flex", "not above `relax`")];
        sink.push(device.labelled(errors::no_stroke(&voltage("relax"), &voltage("flex")), labels));
    }
    if facts.flex_v > facts.max_v {
        let labels = [
            DeviceLabel::field("flex", "more than the source gives"),
            DeviceLabel::field("max_voltage", "the most that it gives"),
        ];
        sink.push(device.labelled(errors::flex_beyond_source(&voltage("flex"), &voltage("max_voltage")), labels));
    }
    (sink.errors() == errors).then_some(())
}

/// Checks that docking angles are below a right angle, because a robot meets its partner with its front.
fn meets_forwards(facts: &MicrorobotsFacts, device: &CheckedDevice, sink: &mut Sink) {
    let angles =
        [("self_aligning_angle", facts.docking.self_aligning_rad), ("sticking_angle", facts.docking.sticking_rad)];
    for (name, _) in angles.into_iter().filter(|(_, angle_rad)| *angle_rad >= FRAC_PI_2) {
        let found = device.fields.text(name);
        sink.push(
            device
                .labelled(errors::docking_sideways(name, &found), [DeviceLabel::field(name, "a right angle or more")]),
        );
    }
}

fn fine_motion_has_room(facts: &MicrorobotsFacts, device: &CheckedDevice, sink: &mut Sink) {
    if facts.fine.cycle_um > facts.fine.length_um {
        let found = ["fine_cycle", "fine_length"].map(|name| device.fields.text(name));
        let labels = [
            DeviceLabel::field("fine_cycle", "longer than the whole fine motion"),
            DeviceLabel::field("fine_length", "the fine motion"),
        ];
        sink.push(device.labelled(errors::cycle_beyond_fine_motion(&found[0], &found[1]), labels));
        return;
    }
    if facts.fine.length_um > MAX_FINE_UM {
        return; // Reported by `figures_have_sense`.
    }
    // A cycle has at least one stroke for each of its three primitives.
    let step_um = facts.robots.iter().map(|robot| robot.step_um).fold(0.0, f64::max);
    let cycles = facts.fine.length_um / facts.fine.cycle_um.max(3.0 * step_um);
    if cycles > MAX_CYCLES {
        let found = device.fields.text("fine_length");
        let labels =
            [DeviceLabel::field("fine_length", "the fine motion"), DeviceLabel::field("fine_cycle", "one cycle of it")];
        sink.push(device.labelled(errors::too_many_cycles(&found, cycles, MAX_CYCLES), labels));
    }
}
