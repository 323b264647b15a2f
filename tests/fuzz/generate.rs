//! Random programs from the vocabulary of the kinds; most are valid, and some have a number of another magnitude.

use super::numbers::{self, MAGNITUDES};
use super::random::Random;
use super::seeds;
use std::fmt::Write as _;
use tweeze::device::shape::ShapeForm;
use tweeze::device::{Kind, Need, Sort, Vocabulary, VocabularyField};

/// A program with one kind, or with two on one clock; published devices are written out.
pub fn program(random: &mut Random) -> String {
    let kind = Kind::ALL[random.below(Kind::ALL.len() as u32) as usize];
    let mut text = seeds::with_library(&format!("// with {}\n", kind.name()));
    text.push_str(&body(kind, random));
    if random.below(4) == 0 {
        text.push_str("program all { run go, wait 3 ms, together { run go }, for i in 0..2 { run go } }\n");
    }
    for _ in 0..random.below(3) {
        let places = numbers::places(&text);
        let place = &places[random.below(places.len() as u32) as usize];
        let factor = MAGNITUDES[random.below(MAGNITUDES.len() as u32) as usize];
        text = numbers::scaled(&text, place, factor);
    }
    text
}

/// A device, a scene and the task `go` of a kind.
fn body(kind: Kind, random: &mut Random) -> String {
    match kind {
        Kind::Dimibot => dimibot(random),
        Kind::ElectrodeArray => electrode_array(random),
        Kind::Microrobots => microrobots(random),
        Kind::Fingers => fingers(random),
    }
}

/// A random integer in a range, both ends included.
fn whole(random: &mut Random, from: u32, to: u32) -> u32 {
    from + random.below(to - from + 1)
}

fn one_of<'a>(random: &mut Random, words: &[&'a str]) -> &'a str {
    words[random.below(words.len() as u32) as usize]
}

/// The head of a task: planner, objective and limits from the vocabulary, and some of its settings.
fn head(words: &Vocabulary, budget: u32, random: &mut Random) -> String {
    let mut text = String::new();
    let planner = &words.planners[random.below(words.planners.len() as u32) as usize];
    let _ = writeln!(text, "  using {} {{ expansions: {budget} }}", planner.name);
    if random.below(2) == 0 {
        let objective = words.objectives[random.below(words.objectives.len() as u32) as usize].name;
        let _ = writeln!(text, "  minimize {objective}");
    }
    for outcome in words.outcomes {
        if random.below(6) == 0 {
            let unit = tweeze::quantity::Quantity::new(random.unit() * 4.0, outcome.unit.dimension());
            let _ = writeln!(text, "  require {} {} {unit}", outcome.name, one_of(random, &["<=", "<", ">="]));
        }
    }
    for field in words.settings.iter().filter(|field| field.need != Need::Required) {
        if random.below(4) == 0 {
            let _ = writeln!(text, "  {}: {}", field.name, value(field, random));
        }
    }
    text
}

/// A random value for a setting.
fn value(field: &VocabularyField, random: &mut Random) -> String {
    let quantity = |dimension, size| tweeze::quantity::Quantity::new(size, dimension).to_string();
    match field.sort {
        Sort::Count { least, .. } | Sort::CountOrWord { least, .. } => (least + random.below(5)).to_string(),
        Sort::Quantity { dimension, .. } => quantity(dimension, random.unit() * 1e-6),
        Sort::Word(words) => words[random.below(words.len() as u32) as usize].name.to_owned(),
        Sort::Flag => one_of(random, &["true", "false"]).to_owned(),
        Sort::Vector { dimension, .. } => {
            let [x, y, z] = [(); 3].map(|()| quantity(dimension, (random.unit() - 0.5) * 1e-6));
            format!("({x}, {y}, {z})")
        }
        Sort::Pixel => one_of(random, &["(3 px, 4 px)", "(1e9 px, -2.5 px)"]).to_owned(),
        Sort::State
        | Sort::Target
        | Sort::Targets
        | Sort::Cell
        | Sort::Cells
        | Sort::CountRows { .. }
        | Sort::CountTables { .. }
        | Sort::Size
        | Sort::Places
        | Sort::Shape(_)
        | Sort::Table(_)
        | Sort::Object(_)
        | Sort::Site(_)
        | Sort::Sites(_)
        | Sort::Name
        | Sort::Pose
        | Sort::Control
        | Sort::Contacts
        | Sort::Orientation
        | Sort::Curve
        | Sort::Text
        | Sort::Board(_) => one_of(random, &["1", "(1, 1)", "true"]).to_owned(),
    }
}

/// A random planar shape of about `size_um` micrometres.
fn flat(form: ShapeForm, size_um: f64, random: &mut Random) -> String {
    let mut length = |share: f64| format!("{:.3} um", size_um * share * (0.2 + random.unit()));
    match form {
        ShapeForm::Disc => format!("disc {{ radius: {} }}", length(0.5)),
        ShapeForm::Box => format!("box {{ size: ({}, {}) }}", length(1.0), length(1.0)),
        ShapeForm::Polygon => {
            let (a, b, c) = (length(1.0), length(1.0), length(0.5));
            format!("polygon {{ points: [(0 um, 0 um), ({a}, 0 um), ({a}, {b}), ({c}, {b})] }}")
        }
        ShapeForm::Capsule => format!("capsule {{ length: {}, radius: {} }}", length(1.0), length(0.2)),
        ShapeForm::Cells
        | ShapeForm::Layout
        | ShapeForm::Ellipsoid
        | ShapeForm::Superellipsoid
        | ShapeForm::RoundedBox
        | ShapeForm::Profile
        | ShapeForm::Sections
        | ShapeForm::Mesh
        | ShapeForm::Image => "cells { from: (2, 2), to: (3, 2) }".to_owned(),
    }
}

fn dimibot(random: &mut Random) -> String {
    let (left, right) = (whole(random, 1, 5), whole(random, 1, 5));
    let wide_um = 0.427 * f64::from(1 << left);
    let high_um = 0.427 * f64::from(1 << right);
    let mut text =
        format!("device bot : femto_st {{ left: {left}, right: {right}, rest: {} ms }}\nscene s {{\n", random.below(9));
    let forms = [ShapeForm::Disc, ShapeForm::Box, ShapeForm::Polygon, ShapeForm::Capsule, ShapeForm::Cells];
    for at in 0..random.below(5) {
        let form = forms[random.below(5) as usize];
        let [x, y] = [wide_um, high_um].map(|um| random.unit() * um);
        let place = match (form, random.below(2)) {
            (ShapeForm::Cells, _) => String::new(),
            (_, 0) => format!(" at ({x:.3} um, {y:.3} um)"),
            (_, _) => format!(" at pose({x:.3} um, {y:.3} um, {} deg)", random.below(400)),
        };
        let _ = writeln!(text, "  obstacle o{at} : {}{place}", flat(form, 0.8, random));
    }
    text.push_str("}\ntask go on bot in s {\n");
    text.push_str(&head(Kind::Dimibot.vocabulary(), 20_000, random));
    let cell = |random: &mut Random| format!("({}, {})", random.below(1 << left), random.below(1 << right));
    for _ in 0..whole(random, 1, 3) {
        let step = match random.below(6) {
            0 => format!("visit [{}, {}, {}]", cell(random), cell(random), cell(random)),
            1 => format!("move to {} via {}", cell(random), cell(random)),
            2 => format!("wait {} us", random.below(100_000)),
            3 => format!("for p in [{}, {}] {{ move to p }}", cell(random), cell(random)),
            4 => format!("move to ({:.3} um, {:.3} um)", random.unit() * wide_um, random.unit() * high_um),
            _ => format!("move to {}", cell(random)),
        };
        let _ = writeln!(text, "  {step}");
    }
    text.push_str("}\n");
    text
}

fn electrode_array(random: &mut Random) -> String {
    let (columns, rows) = (whole(random, 5, 16), whole(random, 5, 16));
    let (device, part) = [("droplet_chip", "droplet"), ("smart_platform", "micropart")][random.below(2) as usize];
    let cell = |random: &mut Random| format!("({}, {})", whole(random, 1, columns), whole(random, 1, rows));
    let map = if random.below(3) == 0 { electrode_map(columns, rows, random) } else { String::new() };
    let mut text = format!("device board : {device} {{ columns: {columns}, rows: {rows}{map} }}\nscene s {{\n");
    let parts = whole(random, 1, 4);
    for at in 0..parts {
        let is_dispensed = random.below(6) == 0;
        let place = if is_dispensed { String::new() } else { format!(" at {}", cell(random)) };
        let _ = writeln!(text, "  part p{at} : {part}{place}");
    }
    for at in 0..random.below(3) {
        let _ = writeln!(text, "  reservoir r{at} at {}", cell(random));
    }
    let _ = writeln!(text, "  heater z0 at {}\n  detector z1 at {}", cell(random), cell(random));
    if random.below(3) == 0 {
        let _ = writeln!(text, "  obstacle o : cells {{ from: {}, to: {} }}", cell(random), cell(random));
    }
    text.push_str("}\ntask go on board in s {\n");
    text.push_str(&head(Kind::ElectrodeArray.vocabulary(), 5_000, random));
    for _ in 0..whole(random, 1, 3) {
        match random.below(6) {
            3 => drop(writeln!(text, "  assay {{ {} }}", operations(parts, &cell, random).join(", "))),
            0 if parts > 1 => drop(writeln!(text, "  merge p0 with p1 at {}", cell(random))),
            1 => {
                let moves: Vec<String> = (0..parts).map(|part| format!("move p{part} to {}", cell(random))).collect();
                let _ = writeln!(text, "  together {{ {} }}", moves.join(", "));
            }
            2 => drop(writeln!(text, "  wait {} ms", random.below(2000))),
            _ => {
                let _ = writeln!(text, "  move p{} to {} via {}", random.below(parts), cell(random), cell(random));
            }
        }
    }
    text.push_str("}\n");
    text
}

/// Random operations of an assay: most parts exist, and most cells are apart.
fn operations(parts: u32, cell: &impl Fn(&mut Random) -> String, random: &mut Random) -> Vec<String> {
    let count = whole(random, 1, 6);
    let operation = |_| {
        let part = format!("p{}", random.below(parts));
        match random.below(15) {
            14 => format!("detect {part} among [z1, {}] for {} ms", cell(random), random.below(700)),
            13 => {
                let verb = ["incubate", "mix"][random.below(2) as usize];
                let places: Vec<String> = (0..whole(random, 1, 4)).map(|_| cell(random)).collect();
                format!("{verb} {part} among [{}] for {} ms", places.join(", "), random.below(700))
            }
            12 => format!("heat {part} at z0 to {} degC for {} ms", whole(random, 20, 120), random.below(700)),
            11 => format!("detect {part} at z1 for {} ms", random.below(700)),
            10 => format!("dispense {part} from r{}", random.below(2)),
            9 => format!("mix {part} for {} ms", random.below(700)),
            8 => format!("mix {part} at {} for {} ms", cell(random), random.below(700)),
            7 if random.below(2) == 0 => format!("split {part} from p{} at {}", random.below(parts), cell(random)),
            7 => format!("split {part} from p{} at (4, 4) to (4, {})", random.below(parts), whole(random, 3, 6)),
            0 => format!("merge {part} with p{} at {}", random.below(parts), cell(random)),
            1 => format!("incubate {part} for {} ms", random.below(700)),
            2 => format!("incubate {part} at {} for {} ms", cell(random), random.below(700)),
            3 => format!("move {part} to {} via {}", cell(random), cell(random)),
            4 if random.below(2) == 0 => format!("discard {part} at {}", cell(random)),
            _ => format!("move {part} to {}", cell(random)),
        }
    };
    (0..count).map(operation).collect()
}

/// An electrode map with gaps and defective electrodes, mostly for boards of droplets.
fn electrode_map(columns: u32, rows: u32, random: &mut Random) -> String {
    let mut number = 0;
    let mut cell = |random: &mut Random| match random.below(12) {
        0 => "none".to_owned(),
        _ => {
            number += 1;
            number.to_string()
        }
    };
    let mut row = |random: &mut Random| (0..columns).map(|_| cell(random)).collect::<Vec<_>>().join(", ");
    let channels: Vec<String> = (0..rows).map(|_| format!("[{}]", row(random))).collect();
    let dead: Vec<String> =
        (0..random.below(3)).map(|_| format!("({}, {})", whole(random, 1, columns), whole(random, 1, rows))).collect();
    match random.below(3) {
        0 => format!(", disabled: [{}]", dead.join(", ")),
        1 => format!(", channels: [{}]", channels.join(", ")),
        _ => format!(", channels: [{}], disabled: [{}]", channels.join(", "), dead.join(", ")),
    }
}

fn microrobots(random: &mut Random) -> String {
    let robots = whole(random, 1, 4);
    let pose = |random: &mut Random| {
        let [x, y] = [(); 2].map(|()| random.unit() * 6.0 - 3.0);
        format!("pose({x:.2} mm, {y:.2} mm, {} deg)", whole(random, 0, 720))
    };
    let mut text =
        "device fleet : bed {\n  robots: table {\n    robot | snap_down [V] | release [V] | turning_radius [um]\n"
            .to_owned();
    for at in 0..robots {
        let (down, up) = (110 + 12 * at, 20 + 13 * at);
        let _ = writeln!(text, "    D{at} | {down} | {up} | {}", whole(random, 150, 190));
    }
    text.push_str("  }\n  margin: 4 V\n}\nscene s {\n");
    for at in 0..robots {
        let _ = writeln!(text, "  robot D{at} at {}", pose(random));
    }
    let forms = [ShapeForm::Disc, ShapeForm::Box, ShapeForm::Polygon, ShapeForm::Capsule];
    for at in 0..random.below(3) {
        let form = forms[random.below(4) as usize];
        let _ = writeln!(text, "  obstacle o{at} : {} at {}", flat(form, 300.0, random), pose(random));
    }
    text.push_str("}\ntask go on fleet in s {\n");
    text.push_str(&head(Kind::Microrobots.vocabulary(), 300, random));
    let is_assembly = robots > 1 && random.below(3) == 0;
    if is_assembly {
        let (a, b) = (robots - 1, robots - 2);
        let _ =
            writeln!(text, "  assemble {{ D{a} to pose(2 mm, 3 mm, 90 deg), D{b} to pose(2 mm, 3260 um, 270 deg) }}");
    }
    for _ in 0..u32::from(!is_assembly) * whole(random, 1, 3) {
        let step = match random.below(5) {
            0 => format!("apply state 0b{} for {} ms", "1".repeat(robots as usize), random.below(3000)),
            1 => format!("wait {} ms", random.below(50)),
            2 => format!("apply state {} for {} ms", random.below(robots + 1), random.below(3000)),
            _ => format!("drive D{} to {}", random.below(robots), pose(random)),
        };
        let _ = writeln!(text, "  {step}");
    }
    text.push_str("}\n");
    text
}

/// A random solid or flat part, some tens of micrometres wide.
fn solid(random: &mut Random) -> String {
    let mut um = |from: f64, to: f64| format!("{:.2} um", from + random.unit() * (to - from));
    let (a, b, c) = (um(8.0, 20.0), um(8.0, 20.0), um(8.0, 20.0));
    match random.below(6) {
        0 => format!("superellipsoid {{ axes: ({a}, {b}, {c}), exponent: {:.2} }}", 2.0 + random.unit() * 8.0),
        1 => {
            format!("rounded_box {{ size: (2 * {a}, 2 * {b}, 2 * {c}), radius: {:.2} um }}", 1.0 + random.unit() * 8.0)
        }
        2 => format!("profile {{ x: {a} * cos(t) - {:.2} um * cos(2 * t), y: {b} * sin(t) }}", random.unit() * 7.0),
        3 => format!("profile {{ points: [({a}, 0 um), (0 um, {b}), (-{c}, 0 um), (0 um, -{a})] }}"),
        4 => {
            let outline = |b: &str| format!("profile {{ x: {a} * cos(t), y: {b} * sin(t) }}");
            format!("sections {{ xy: {}, xz: {} }}", outline(&b), outline(&c))
        }
        _ => format!("ellipsoid {{ axes: ({a}, {b}, {b}), material: silicon }}"),
    }
}

fn fingers(random: &mut Random) -> String {
    let angle = [5, 10, 20, 30, 45, 60][random.below(6) as usize];
    let adhesion = one_of(random, &["true", "false"]);
    let count = whole(random, 2, 4);
    let mut text = format!(
        "device hand : three_fingers {{ fingers: {count}, adhesion: {adhesion}, friction: {:.2}, step: {angle} deg, support: {} uN, \
         removal_safety: {} }}\nscene s {{ part bead : {} }}\ntask go on hand in s {{\n",
        0.1 + random.unit() * 0.6,
        random.below(6),
        one_of(random, &["1", "1.8", "0.5"]),
        solid(random)
    );
    text.push_str(&head(Kind::Fingers.vocabulary(), 5_000, random));
    for _ in 0..whole(random, 1, 2) {
        let turn = angle * whole(random, 1, 8);
        let sign = one_of(random, &["", "-"]);
        let step = match random.below(8) {
            0 => format!("orient bead to euler({turn} deg, 0 deg, {sign}{turn} deg)"),
            1 => format!("translate bead by ({sign}{} um, 0 um, 1 um)", random.below(30)),
            2 => format!(
                "grasp bead at [{}, {}{}]",
                whole(random, 1, 40),
                whole(random, 1, 40),
                ", 0".repeat(count as usize - 2)
            ),
            3 => "wait 10 ms".to_owned(),
            _ => format!("rotate bead by {sign}{turn} deg about {}", one_of(random, &["z", "z", "y", "x"])),
        };
        let _ = writeln!(text, "  {step}");
    }
    if random.below(3) == 0 {
        text.push_str("  release\n");
    }
    text.push_str("}\n");
    text
}
