//! Each check just inside and just outside its limit, the content of orders, and chosen turns against all turns.

mod turns;

use super::orientation;
use crate::check::imports::{self, FileFault, Library};
use crate::check::solid;
use crate::check::{Checked, Options, check};
use crate::claims::Claims;
use crate::claims::fingers::{FingersAction, FingersOrder, FingersPlanner, FingersTurn};
use crate::device::fingers::{Adhesion, Plane};
use crate::diagnostic::Sink;
use crate::random::SplitMix64;
use crate::source::Sources;
use std::f64::consts::PI;

struct Nothing;

impl Library for Nothing {
    fn read(&self, _from: &str, path: &str) -> Result<(String, String), FileFault> {
        let text = match path {
            "bead.stl" => Some(ball(16.0, 24, None)),
            "thorn.stl" => Some(ball(16.0, 24, Some((11, 1)))),
            "spike.stl" => Some(ball(16.0, 24, Some((3, 1)))),
            _ => None,
        };
        text.map(|text| (path.to_owned(), text)).ok_or_else(|| "there is none".into())
    }
}

/// A ball of triangles, one vertex of which may stand out by 1.2 um.
fn ball(radius: f64, count: usize, thorn: Option<(usize, usize)>) -> String {
    let place = |i: usize, j: usize| {
        let radius = radius + if thorn == Some((i, j)) { 1.2 } else { 0.0 };
        let (polar, round) = (PI * i as f64 / count as f64, PI * (j % (2 * count)) as f64 / count as f64);
        let [x, y, z] = [polar.sin() * round.cos(), polar.sin() * round.sin(), polar.cos()];
        let on_axis = i == 0 || i == count;
        [if on_axis { 0.0 } else { x }, if on_axis { 0.0 } else { y }, z].map(|unit| format!("{:.6}", radius * unit))
    };
    let mut text = "solid ball\n".to_owned();
    for j in 0..2 * count {
        for i in 0..count {
            let corners = [place(i, j), place(i + 1, j), place(i + 1, j + 1), place(i, j + 1)];
            for [a, b, c] in [[0, 1, 2], [0, 2, 3]] {
                if corners[a] != corners[b] && corners[b] != corners[c] && corners[a] != corners[c] {
                    let vertices = [a, b, c].map(|at| format!("vertex {}", corners[at].join(" "))).join("\n");
                    text.push_str(&format!("facet normal 0 0 0\nouter loop\n{vertices}\nendloop\nendfacet\n"));
                }
            }
        }
    }
    text + "endsolid ball\n"
}

const BEAD: &str = "ellipsoid { axes: (16 um, 11.845 um, 11.845 um), material: f.silicon }";

/// The checked program, and the codes.
fn reported(text: &str) -> (Option<Checked>, Vec<String>) {
    let (mut sources, mut sink) = (Sources::default(), Sink::default());
    let text = format!("use std.fingers as f\n{text}");
    let modules = imports::load(&mut sources, "main.twz", &text, &Nothing, &mut sink);
    let checked = check(&mut sources, &modules, &Options::default(), &mut sink);
    let codes = sink.sorted().iter().map(|diagnostic| diagnostic.code.to_string()).collect();
    (checked, codes)
}

fn program(fields: &str, shape: &str, steps: &str) -> String {
    format!(
        "device hand : f.three_fingers {{ {fields} }}\nscene cell {{ part bead : {shape} }}\n\
         task turn on hand in cell {{ {steps} }}"
    )
}

fn assert_codes(text: &str, expected: &[&str]) {
    assert_eq!(reported(text).1, expected, "{text}");
}

fn shape(shape: &str, expected: &[&str]) {
    assert_codes(&program("", shape, "precision: 10 deg, rotate bead by 80 deg about z"), expected);
}

fn steps(steps: &str, expected: &[&str]) {
    assert_codes(&program("", BEAD, steps), expected);
}

fn orders(claims: &Claims) -> Vec<&FingersOrder> {
    claims.jobs.iter().filter_map(|job| FingersOrder::of(&job.order)).collect()
}

fn order(fields: &str, shape: &str, steps: &str) -> FingersOrder {
    let (checked, codes) = reported(&program(fields, shape, steps));
    let checked = checked.unwrap_or_else(|| panic!("{codes:?}"));
    orders(&checked.claims[0])[0].clone()
}

#[test]
fn the_papers_case_has_its_contacts_and_its_turns() {
    let turns = "rotate bead by 80 deg about z, rotate bead by 220 deg about y, rotate bead by 100 deg about z";
    let order = order("", BEAD, turns);
    for section in [&order.part.xy, order.part.xz.as_ref().expect("a solid has two")] {
        assert_eq!((section.contacts, section.opposite), (74, Some(38)));
        assert!((section.step_rad.to_degrees() - 20.0).abs() < 1e-3);
    }
    let of = |step: &crate::claims::fingers::FingersStep| match step.action {
        FingersAction::Rotate { plane, steps, .. } => Some((plane, steps)),
        _ => None,
    };
    let turned: Vec<_> = order.steps.iter().filter_map(of).collect();
    assert_eq!(turned, [(Plane::Xy, 4), (Plane::Xz, 11), (Plane::Xy, 5)]);
    assert_eq!((order.planner, order.facts.adhesion), (FingersPlanner::JointAstar, Adhesion::Sticking));
    // 4/3 π 16 · 11.845² um³ of 2330 kg/m³.
    assert!((order.load_un[2] + 2.1486e-4).abs() < 1e-8, "{:?}", order.load_un);
}

#[test]
fn an_orientation_stands_for_the_same_turns() {
    let order = order("", BEAD, "orient bead to euler(80 deg, 220 deg, 100 deg)");
    let FingersAction::Orient { goal, turns, .. } = &order.steps[0].action else { panic!("an orientation") };
    let whole = |plane, steps| FingersTurn { plane, steps };
    assert!(turns.contains(&vec![whole(Plane::Xy, 4), whole(Plane::Xz, 11), whole(Plane::Xy, 5)]));
    // The second solution, and the long ways.
    assert!(turns.contains(&vec![whole(Plane::Xy, -5), whole(Plane::Xz, 7), whole(Plane::Xy, -4)]));
    assert!(turns.contains(&vec![whole(Plane::Xy, 4), whole(Plane::Xz, -7), whole(Plane::Xy, 5)]));
    for turns in turns {
        let off = orientation::after(turns, &order.part).angle_to(&orientation::read(*goal));
        assert!(off <= order.precision_rad);
    }
}

#[test]
fn an_orientation_counts_from_where_the_part_is() {
    let order = order("", BEAD, "rotate bead by 80 deg about z, orient bead to euler(120 deg, 0 deg, 0 deg)");
    let FingersAction::Orient { turns, .. } = &order.steps[1].action else { panic!("an orientation") };
    assert_eq!(turns[0], [FingersTurn { plane: Plane::Xy, steps: 2 }]);
}

#[test]
fn a_part_that_is_there_needs_no_turn() {
    let order = order("", BEAD, "orient bead to quaternion(1, 0, 0, 0)");
    let FingersAction::Orient { turns, .. } = &order.steps[0].action else { panic!("an orientation") };
    assert_eq!(turns[0], []);
}

#[test]
fn a_turn_about_x_needs_a_step_that_divides_90_deg() {
    steps("rotate bead by 80 deg about x", &["E0545"]);
    let order = order("step: 10 deg", BEAD, "precision: 1 deg, rotate bead by 80 deg about x");
    let FingersAction::Orient { goal, turns, .. } = &order.steps[0].action else { panic!("an orientation") };
    assert!((goal[1] - 40f64.to_radians().sin()).abs() < 1e-9 && goal[2].abs() + goal[3].abs() < 1e-9);
    let whole = |plane, steps| FingersTurn { plane, steps };
    assert!(turns.contains(&vec![whole(Plane::Xy, -9), whole(Plane::Xz, 8), whole(Plane::Xy, 9)]), "{turns:?}");
}

#[test]
fn steps_of_a_full_turn() {
    for (step, codes) in [("20 deg", &[][..]), ("20.1 deg", &["E0425"]), ("90 deg", &[]), ("120 deg", &["E0425"])] {
        assert_codes(
            &program(&format!("step: {step}"), BEAD, "precision: 40 deg, rotate bead by 80 deg about z"),
            codes,
        );
    }
    assert_codes(&program("step: 51.4286 deg", BEAD, "precision: 40 deg, rotate bead by 80 deg about z"), &[]);
    assert_codes(&program("gaiting_cost: 0.5 deg", BEAD, "grasp bead"), &["E0403"]);
    assert_codes(&program("gaiting_cost: 1 deg", BEAD, "grasp bead"), &[]);
}

#[test]
fn angles_are_whole_steps_within_the_precision() {
    steps("rotate bead by 80.49 deg about z", &[]);
    steps("rotate bead by 80.51 deg about z", &["E0543"]);
    steps("rotate bead by -80.49 deg about y", &[]);
    steps("precision: 0.1 deg, rotate bead by 80.49 deg about z", &["E0543"]);
    // An angle that is advised can be written: 360.98 deg would be too far.
    let program = |asked: &str| {
        let bead = "ellipsoid { axes: (16 um, 11.845 um, 11.845 um) }";
        program("step: 18 deg", bead, &format!("precision: 0.5 deg, rotate bead by {asked} deg about z"))
    };
    assert_codes(&program("360"), &["E0543"]);
    assert_codes(&program("342.93"), &[]);
    steps("rotate bead by 360 deg about z", &[]);
    steps("rotate bead by -360.1 deg about z", &["E0544"]);
    steps("rotate bead by 0 deg about z", &[]);
}

#[test]
fn hollows_take_the_tips_that_fit() {
    // At t = 0 it is hollow with a radius of 13² / (24 - 14) um.
    let bean = "profile { x: 14 um * cos(t) - 6 um * cos(2 * t), y: 13 um * sin(t) }";
    let turn = "precision: 10 deg, rotate bead by 80 deg about z";
    assert_codes(&program("tip_radius: 16.8 um, range: (200 um, 200 um, 200 um)", bean, turn), &[]);
    assert_codes(&program("tip_radius: 17 um, range: (200 um, 200 um, 200 um)", bean, turn), &["E0540"]);
}

#[test]
fn shapes_just_possible_and_just_not() {
    shape("rounded_box { size: (30 um, 20 um, 10 um), radius: 5 um }", &[]);
    shape("rounded_box { size: (30 um, 20 um, 10 um), radius: 5.01 um }", &["E0514"]);
    shape("superellipsoid { axes: (16 um, 12 um, 12 um), exponent: 10 }", &[]);
    shape("superellipsoid { axes: (16 um, 12 um, 12 um), exponent: 10.01 }", &["E0514"]);
    shape("profile { points: [(9 um, 0 um), (0 um, 7 um), (-9 um, 0 um), (0 um, -7 um)] }", &[]);
    shape("profile { points: [(9 um, 0 um), (0 um, 7 um), (-9 um, 0 um)] }", &["E0514"]);
    shape("profile { points: [(9 um, 0 um), (-9 um, 0 um), (0 um, 7 um), (0 um, -7 um)] }", &["E0514"]);
    shape("ellipsoid { axes: (16 um, 12 um, 0 um) }", &["E0403"]);
    shape("mesh { file: \"bead.stl\", unit: 1 um }", &[]);
    shape("mesh { file: \"none.stl\", unit: 1 um }", &["E0204"]);
}

#[test]
fn points_may_go_round_either_way() {
    let order = |points: &str| order("", &format!("profile {{ points: [{points}] }}"), "grasp bead");
    let one = order("(16 um, 0 um), (0 um, 12 um), (-16 um, 0 um), (0 um, -12 um)");
    let other = order("(0 um, -12 um), (-16 um, 0 um), (0 um, 12 um), (16 um, 0 um)");
    assert_eq!(one.part.xy, other.part.xy);
    assert_eq!(one.part.xz, None);
}

#[test]
fn the_second_section_is_written_by_x_and_z() {
    // It reaches further up than down.
    let lifted = "sections { xy: profile { x: 16 um * cos(t), y: 12 um * sin(t) },
        xz: profile { x: 16 um * cos(t), y: 12 um * sin(t) + 2 um * (1 - cos(2 * t)) } }";
    let order = order("", lifted, "precision: 9 deg, rotate bead by 80 deg about z");
    let section = order.part.xz.clone().expect("it is given");
    let curve = crate::geometry::outline::Curve::of(&section.outline).expect("it can be followed");
    let up = -curve.nearest([0.0, -100.0]).distance_um + 100.0;
    assert!((up - 16.0).abs() < 1e-3, "z is up, the plane's second axis is down: {up}");
}

#[test]
fn volumes_agree_with_sums() {
    let volume = |text: &str| {
        let order = order("range: (1 mm, 1 mm, 1 mm)", &format!("{text}, material: 1e6 kg/m^3 }}"), "grasp bead");
        -order.load_un[2] / (1e6 * 1e-18 * 9.806_65 * 1e6)
    };
    let near = |found: f64, exact: f64| assert!((found / exact - 1.0).abs() < 1e-9, "{found} is not {exact}");
    near(volume("superellipsoid { axes: (16 um, 12 um, 11 um), exponent: 2"), 4.0 / 3.0 * PI * 16.0 * 12.0 * 11.0);
    near(volume("rounded_box { size: (20 um, 20 um, 20 um), radius: 10 um"), 4.0 / 3.0 * PI * 1000.0);
    let found = volume("superellipsoid { axes: (16 um, 12 um, 11 um), exponent: 4");
    let (count, mut share) = (2000, 0.0);
    for i in 0..count {
        for j in 0..count {
            let [x, y] = [i, j].map(|k| (f64::from(k) + 0.5) / f64::from(count));
            share += (1.0 - x.powi(4) - y.powi(4)).max(0.0).powf(0.25) / f64::from(count).powi(2);
        }
    }
    assert!((found / (8.0 * 16.0 * 12.0 * 11.0 * share) - 1.0).abs() < 1e-4);
}

/// Compares volumes, and with them weights, with the share of random points that lie within a shape, by its definition
/// in the handbook.
#[test]
fn weights_are_those_of_the_points_within_a_shape() {
    let mut random = SplitMix64::new(31);
    let mut counted = |text: &str, half_um: [f64; 3], within: &dyn Fn([f64; 3]) -> bool| {
        let order = order("range: (1 mm, 1 mm, 1 mm)", &format!("{text}, material: 2330 kg/m^3 }}"), "grasp bead");
        let points = 200_000;
        let inside = (0..points).filter(|_| within([0, 1, 2].map(|axis| half_um[axis] * random.signed_unit()))).count();
        let volume_um3 = 8.0 * half_um.iter().product::<f64>() * inside as f64 / f64::from(points);
        // kg/m^3 times um^3 times m/s^2, in uN.
        let weight_un = 2330.0 * 1e-18 * volume_um3 * 9.806_65 * 1e6;
        assert!((-order.load_un[2] / weight_un - 1.0).abs() < 0.01, "{text}: {:?}, not {weight_un}", order.load_un);
        assert_eq!(order.load_un[..2], [0.0; 2]);
    };
    let [a, b, c] = [16.0, 12.0, 11.0];
    let power = move |exponent: f64, point: [f64; 3]| -> f64 {
        point.into_iter().zip([a, b, c]).map(|(at, half)| (at / half).abs().powf(exponent)).sum()
    };
    counted("ellipsoid { axes: (16 um, 12 um, 11 um)", [a, b, c], &|point| power(2.0, point) <= 1.0);
    for exponent in [2.5, 6.0] {
        let text = format!("superellipsoid {{ axes: (16 um, 12 um, 11 um), exponent: {exponent}");
        counted(&text, [a, b, c], &|point| power(exponent, point) <= 1.0);
    }
    counted("rounded_box { size: (32 um, 24 um, 22 um), radius: 5 um", [a, b, c], &|point| {
        let beyond = point.into_iter().zip([a, b, c]).map(|(at, half)| (at.abs() - (half - 5.0)).max(0.0).powi(2));
        beyond.sum::<f64>() <= 25.0
    });
}

#[test]
fn a_mesh_is_its_ball() {
    let order = order("", "mesh { file: \"bead.stl\", unit: 1 um, material: 1e6 kg/m^3 }", "grasp bead");
    let found = -order.load_un[2] / (1e6 * 1e-18 * 9.806_65 * 1e6);
    assert!((found / (4.0 / 3.0 * PI * 16f64.powi(3)) - 1.0).abs() < 0.02, "{found}");
    assert!(order.part.centre_um.iter().all(|um| um.abs() < 0.01));
    // A circle of 16 um: 18 (1 + 16/4.5) = 82.
    assert_eq!((order.part.xy.contacts, order.part.xy.opposite), (82, Some(42)));
}

/// The thorn stands beside the plane xy, between two contacts there.
#[test]
fn a_tip_must_not_roll_into_the_solid_between_two_contacts() {
    let turn = "precision: 30 deg, rotate bead by 90 deg about z";
    let turned = |file: &str, fields: &str| program(fields, &format!("mesh {{ file: \"{file}\", unit: 1 um }}"), turn);
    assert_codes(&turned("bead.stl", "step: 90 deg"), &[]);
    assert_codes(&turned("thorn.stl", "step: 90 deg"), &["E0552"]);
    assert_codes(&turned("thorn.stl", "step: 90 deg, tolerance: 0.3 um"), &["E0552"]);
    assert_codes(&turned("thorn.stl", "step: 90 deg, tolerance: 0.5 um, retract: 1 um"), &[]);
}

/// The spike stands beside the plane xz, far from the plane xy.
#[test]
fn a_section_round_which_no_step_turns_may_be_what_it_is() {
    let spike = "mesh { file: \"spike.stl\", unit: 1 um }";
    let checked = |steps: &str, codes: &[&str]| assert_codes(&program("step: 90 deg", spike, steps), codes);
    checked("precision: 30 deg, rotate bead by 90 deg about z", &[]);
    checked("grasp bead, translate bead by (1 um, 0 um, 0 um)", &[]);
    checked("precision: 30 deg, rotate bead by 90 deg about y", &["E0552"]);
    checked("precision: 30 deg, rotate bead by 90 deg about z, rotate bead by 90 deg about x", &["E0552"]);
    checked("precision: 30 deg, orient bead to euler(0 deg, 0 deg, 90 deg)", &["E0552"]);
}

#[test]
fn a_tip_that_is_off_is_farther_away_than_the_tolerance() {
    let bead = "ellipsoid { axes: (16 um, 11.845 um, 11.845 um) }";
    for (fields, codes) in [
        ("retract: 0.5 um, clearance: 0.2 um, tolerance: 0.5 um", &["E0403"][..]),
        ("retract: 0.51 um, clearance: 0.2 um, tolerance: 0.5 um", &[]),
        ("retract: 0.1 um, clearance: 0.6 um, tolerance: 0.5 um", &[]),
    ] {
        assert_codes(&program(fields, bead, "grasp bead"), codes);
    }
}

#[test]
fn the_mass_of_a_profile_is_that_of_the_points_within_it() {
    let mut random = SplitMix64::new(7);
    for _ in 0..8 {
        let mut um = |most: f64| (random.signed_unit() * most * 100.0).round() / 100.0;
        let ([dx, dy], [bend, lobe]) = ([um(4.0), um(4.0)], [um(3.0), um(1.5)]);
        let shape = format!(
            "profile {{ x: {dx} um + 16 um * cos(t) + {bend} um * cos(2 * t), y: {dy} um + 12 um * sin(t) + {lobe} um * sin(3 * t) }}"
        );
        // The outline in chords; the points of a grid with an odd number of crossings to their left lie inside.
        let at = |nth: u32| {
            let t = f64::from(nth) / 2000.0 * 2.0 * PI;
            [dx + 16.0 * t.cos() + bend * (2.0 * t).cos(), dy + 12.0 * t.sin() + lobe * (3.0 * t).sin()]
        };
        let chords: Vec<_> = (0..2000).map(|nth| [at(nth), at(nth + 1)]).collect();
        let (mut count, mut sum) = (0.0, [0.0; 2]);
        for row in -120..=120 {
            let y = f64::from(row) * 0.2 + 0.0137;
            let mut ends: Vec<f64> = chords
                .iter()
                .filter(|[a, b]| (a[1] > y) != (b[1] > y))
                .map(|[a, b]| a[0] + (y - a[1]) / (b[1] - a[1]) * (b[0] - a[0]))
                .collect();
            ends.sort_by(f64::total_cmp);
            for inside in ends.chunks_exact(2) {
                let width = inside[1] - inside[0];
                count += width;
                sum = [sum[0] + width * (inside[0] + inside[1]) / 2.0, sum[1] + width * y];
            }
        }
        let order = order("tip_radius: 3 um", &shape, "grasp bead");
        let [x, y, z] = order.part.centre_um;
        let off = (x - sum[0] / count).hypot(y - sum[1] / count);
        assert!(off < 0.01 && z == 0.0, "{shape}: ({x}, {y}), {off} um off");
    }
    let order = order("", "profile { x: 16 um * cos(t), y: 12 um * sin(t) }", "grasp bead");
    assert_eq!(order.part.centre_um, [0.0; 3]);
}

#[test]
fn a_load_on_sections_needs_to_know_where_it_acts() {
    let round = |at: f64| format!("profile {{ x: {at} um + 12 um * cos(t), y: 12 um * sin(t) }}");
    let of = |at: f64, more: &str| format!("sections {{ xy: {0}, xz: {0}{more} }}", round(at));
    let loaded = "load: (0 uN, 0 uN, -0.1 uN), grasp bead";
    assert_codes(&program("torsion: 1 um", &of(0.0, ""), loaded), &[]);
    assert_codes(&program("torsion: 1 um", &of(2.0, ""), loaded), &["E0577"]);
    assert_codes(&program("torsion: 1 um", &of(2.0, ""), "load: (0 uN, 0 uN, 0 uN), grasp bead"), &[]);
    assert_codes(&program("torsion: 1 um", &of(2.0, ""), "grasp bead"), &[]);
    let stated = of(2.0, ", centre_of_mass: (2 um, 0.5 um, -1 um)");
    assert_eq!(order("torsion: 1 um", &stated, loaded).part.centre_um, [2.0, 0.5, -1.0]);
    shape(&of(2.0, ", centre_of_mass: (20 um, 0 um, 0 um)"), &["E0514"]);
}

#[test]
fn sections_that_meet_hand_over() {
    let of = |x: f64| {
        format!(
            "sections {{ xy: profile {{ x: 16 um * cos(t), y: 12 um * sin(t) }}, \
             xz: profile {{ x: {x} um * cos(t), y: 12 um * sin(t) }} }}"
        )
    };
    let both = "precision: 9 deg, rotate bead by 80 deg about z, rotate bead by 80 deg about y";
    assert_codes(&program("", &of(16.01), both), &[]);
    assert_codes(&program("", &of(16.02), both), &["E0542"]);
    assert_codes(&program("", &of(16.02), "precision: 9 deg, rotate bead by 80 deg about y"), &[]);
}

#[test]
fn tips_keep_apart() {
    steps("grasp bead at (1, 7)", &[]);
    steps("grasp bead at (1, 6)", &["E0547"]);
    steps("grasp bead at (74, 6)", &[]);
    steps("grasp bead at [0, 74, 38]", &[]);
    steps("grasp bead at (0, 75, 38)", &["E0547"]);
    steps("grasp bead at (0, 0, 38)", &["E0547"]);
    steps("grasp bead at (1, 38, 38)", &["E0547"]);
}

#[test]
fn stages_reach_round_the_part() {
    // 16 um, and 32.05 um to the sphere of the third finger; 9.15 um more to that of a fourth.
    steps("grasp bead, translate bead by (51.94 um, 0 um, 0 um)", &[]);
    steps("grasp bead, translate bead by (51.96 um, 0 um, 0 um)", &["E0550"]);
    steps("grasp bead, translate bead by (41 um, 0 um, 0 um), translate bead by (11 um, 0 um, 0 um)", &["E0550"]);
    assert_codes(&program("fingers: 4", BEAD, "grasp bead, translate bead by (42.79 um, 0 um, 0 um)"), &[]);
    assert_codes(&program("fingers: 4", BEAD, "grasp bead, translate bead by (42.81 um, 0 um, 0 um)"), &["E0550"]);
}

#[test]
fn a_release_needs_its_support() {
    assert_codes(&program("support: 2.7 uN", BEAD, "grasp bead, release"), &[]);
    assert_codes(&program("support: 2.69 uN", BEAD, "grasp bead, release"), &["E0549"]);
    assert_codes(&program("adhesion: false", BEAD, "grasp bead, release"), &[]);
    assert_codes(&program("adhesion: false", BEAD, "grasp bead, release, release"), &["E0548"]);
}

#[test]
fn loops_of_shapes_have_their_end() {
    let text = "let row = [1, 2]\nscene cell { for i in 0..1000 { part p[i] : profile { x: 9 um * cos(t), y: 7 um * sin(t) } } }";
    assert!(reported(text).1.contains(&"E0308".to_owned()));
}

#[test]
fn reaches_agree_with_samples() {
    let text = program(
        "range: (1 mm, 1 mm, 1 mm)",
        "superellipsoid { axes: (16 um, 12 um, 11 um), exponent: 5 }",
        "grasp bead",
    );
    assert!(reported(&text).0.is_some());
    let reach = solid::super_reach([16.0, 12.0, 11.0], 5.0);
    let mut most: f64 = 0.0;
    for i in 0..=400 {
        for j in 0..=400 {
            let [a, b] = [i, j].map(|k| f64::from(k) / 400.0 * PI / 2.0);
            let unit = [a.cos() * b.cos(), a.cos() * b.sin(), a.sin()];
            let length =
                [16.0, 12.0, 11.0].iter().zip(unit).map(|(axis, u)| (u / axis).abs().powi(5)).sum::<f64>().powf(-0.2);
            most = most.max(length);
        }
    }
    assert!(most <= reach && reach < most * (1.0 + 1e-4), "{most} {reach}");
}
