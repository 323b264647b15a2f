//! Programs with robots at random poses: assemblies on fields of some millimetres, and drives of one robot among two
//! others and obstacles.
//!
//! A seed gives the same program on every machine.

use std::f64::consts::TAU;
use std::fmt::Write;
use tweeze::check::Options;
use tweeze::check::imports::NoFiles;
use tweeze::claims::Claims;
use tweeze::claims::microrobots::MicrorobotsOrder;
use tweeze::compile::{self, ProgramSource};
use tweeze::diagnostic::Sink;
use tweeze::random::SplitMix64;
use tweeze::real::Real;
use tweeze::source::Sources;

/// Half the length of a robot.
const HALF_UM: f64 = 130.0;

/// Distance from the centre of a robot to its corners.
const CORNER_UM: f64 = 133.5;

/// Least distance between the centres of two robots at the start.
const APART_UM: f64 = 300.0;

/// Goals relative to the structure: the two robots that meet head on, then places at their sides, alternately.
const SEATS: [[f64; 3]; 6] = [
    [0.0, -HALF_UM, 90.0],
    [0.0, HALF_UM, 270.0],
    [160.0, 70.0, 180.0],
    [-160.0, -70.0, 0.0],
    [160.0, -90.0, 180.0],
    [-160.0, 90.0, 0.0],
];

/// The checked program; `None` if the checker refuses it.
pub fn checked(text: &str) -> Option<Claims> {
    let options = Options::default();
    let program = ProgramSource { name: "bench.twz", text, library: &NoFiles, options: &options };
    let (mut sources, mut sink) = (Sources::default(), Sink::default());
    compile::check_program(&program, &mut sources, &mut sink)?.claims.into_iter().next()
}

/// The order of the only job.
pub fn order(claims: &Claims) -> &MicrorobotsOrder {
    claims.jobs.first().and_then(|job| MicrorobotsOrder::of(&job.order)).expect("it is a task of microrobots")
}

/// The device: robots with a STRING table and the errors of `std.microrobots`.
pub fn device(count: usize) -> String {
    let mut text = "use std.microrobots\ndevice fleet : microrobots.bed {\n  robots: table {\n    \
                    robot | snap_down [V] | release [V] | turning_radius [um]\n"
        .to_owned();
    for label in 1..=count {
        let _ = writeln!(text, "    D{label} | {} | {} | {}", 106 + 12 * label, 8 * label + 8, 160 + 3 * label);
    }
    text + "  }\n  margin: 2 V\n}\n"
}

/// A pose as the language writes it: micrometres and degrees.
pub fn pose([x, y, heading]: [f64; 3]) -> String {
    format!("pose({x:.1} um, {y:.1} um, {heading:.2} deg)")
}

/// Whether a position is at least `apart_um` from all others.
fn is_apart(place: [f64; 3], others: &[[f64; 3]], apart_um: f64) -> bool {
    others.iter().all(|other| {
        let [dx, dy] = [place[0] - other[0], place[1] - other[1]];
        dx * dx + dy * dy >= apart_um * apart_um
    })
}

/// Random start poses in a square, apart from one another.
fn starts(random: &mut SplitMix64, count: usize, side_um: f64) -> Vec<[f64; 3]> {
    let mut places: Vec<[f64; 3]> = Vec::new();
    while places.len() < count {
        let place = [random.unit() * side_um, random.unit() * side_um, random.unit() * 360.0];
        if is_apart(place, &places, APART_UM) {
            places.push(place);
        }
    }
    places
}

/// An assembly of `count` robots on a square field: the structure is in its middle third, in a random orientation,
/// and the robots that dock at its sides do so in random order.
pub fn assembly(count: usize, side_um: f64, seed: u64, objective: &str) -> String {
    let mut random = SplitMix64::stream(seed, (count as u64) << 32 | side_um as u64);
    let starts = starts(&mut random, count, side_um);
    let middle = [0, 1].map(|_| side_um * (1.0 + random.unit()) / 3.0);
    let turned = random.unit() * 360.0;
    let mut seats = SEATS[..count].to_vec();
    random.shuffle(&mut seats[2..]);
    let (sin, cos) = (turned / 360.0 * TAU).sine_cosine();
    let placed = |[x, y, heading]: [f64; 3]| {
        pose([middle[0] + x * cos - y * sin, middle[1] + x * sin + y * cos, (heading + turned) % 360.0])
    };
    let mut text = device(count) + "scene field {\n";
    for (at, start) in starts.iter().enumerate() {
        let _ = writeln!(text, "  robot D{} at {}", at + 1, pose(*start));
    }
    let _ = write!(text, "}}\ntask join on fleet in field {{\n  minimize {objective}\n  assemble {{\n");
    for (at, seat) in seats.iter().enumerate() {
        let _ = writeln!(text, "    D{} to {}", count - at, placed(*seat));
    }
    text + "  }\n}\n"
}

/// The same program for a device whose errors are zero, so that plans are carried out as written.
pub fn without_errors(text: &str) -> String {
    let errors = "  speed_error: 0 %, turning_error: 0 deg/mm, place_error: 0 um, heading_error: 0 deg\n";
    text.replacen("  margin: 2 V\n", &format!("  margin: 2 V\n{errors}"), 1)
}

/// A drive of one of three robots on a square of 3 mm, among up to twelve discs that touch neither starts nor goal.
pub fn drive(seed: u64) -> String {
    const SIDE_UM: f64 = 3_000.0;
    let mut random = SplitMix64::stream(seed, 3);
    let mut places = starts(&mut random, 4, SIDE_UM);
    let goal = places.remove(3);
    let driven = random.below(3);
    let mut text = device(3) + "scene field {\n";
    for (at, start) in places.iter().enumerate() {
        let _ = writeln!(text, "  robot D{} at {}", at + 1, pose(*start));
    }
    places.push(goal);
    for obstacle in 0..random.below(13) {
        let radius_um = (50.0 + 200.0 * random.unit()).round();
        let place = [random.unit() * SIDE_UM, random.unit() * SIDE_UM, 0.0];
        if is_apart(place, &places, radius_um + CORNER_UM + 20.0) {
            let _ = writeln!(text, "  obstacle o{obstacle} : disc {{ radius: {radius_um} um }} at {}", pose(place));
        }
    }
    let _ = write!(text, "}}\ntask go on fleet in field {{\n  drive D{} to {}\n}}\n", driven + 1, pose(goal));
    text
}
