//! Tests: each check just inside and just outside its limit, settling times against the paper, the painted cover
//! against a test of every obstacle, and the speed of checks on large scenes.

use super::cover::{ObstacleCells, SpacedPlaces, nearest_cell};
use super::motion::{Glide, Pull};
use crate::check::imports::{self, NoFiles};
use crate::check::{Checked, Options, check};
use crate::claims::electrode_array::{
    Bystanders, ElectrodeArrayAction, ElectrodeArrayMethod, ElectrodeArrayObjective, ElectrodeArrayObstacle,
    ElectrodeArrayObstacleBody, ElectrodeArrayOrder,
};
use crate::device::electrode_array::fixture::microparts;
use crate::device::electrode_array::{ElectrodeArrayFacts, ElectrodeCell};
use crate::diagnostic::Sink;
use crate::random::SplitMix64;
use crate::source::{Sources, Span};

fn checked(text: &str) -> (Option<Checked>, Vec<String>) {
    let (mut sources, mut sink) = (Sources::default(), Sink::default());
    let text = format!("use std.electrode_array as ea\n{text}");
    let modules = imports::load(&mut sources, "main.twz", &text, &NoFiles, &mut sink);
    let checked = check(&mut sources, &modules, &Options::default(), &mut sink);
    let codes = sink.sorted().iter().map(|diagnostic| diagnostic.code.to_string()).collect();
    (checked, codes)
}

fn assert_codes(text: &str, expected: &[&str]) {
    assert_eq!(checked(text).1, expected, "{text}");
}

fn device(fields: &str, expected: &[&str]) {
    assert_codes(
        &format!("device plate : ea.smart_platform {{ {fields} }}\ntask t on plate {{ wait 5 ms }}"),
        expected,
    );
}

fn chip(fields: &str, expected: &[&str]) {
    assert_codes(&format!("device plate : ea.droplet_chip {{ {fields} }}\ntask t on plate {{ wait 5 ms }}"), expected);
}

fn scene(objects: &str, expected: &[&str]) {
    tasks(objects, "task t on plate in tray { wait 5 ms }", expected);
}

fn steps(objects: &str, steps: &str, expected: &[&str]) {
    tasks(objects, &format!("task t on plate in tray {{ {steps} }}"), expected);
}

fn tasks(objects: &str, tasks: &str, expected: &[&str]) {
    let device = "device plate : ea.smart_platform { columns: 20, rows: 20 }";
    assert_codes(&format!("{device}\nscene tray {{ {objects} }}\n{tasks}"), expected);
}

fn droplets(objects: &str, steps: &str, expected: &[&str]) {
    let device = "device plate : ea.droplet_chip { columns: 20, rows: 20 }";
    assert_codes(&format!("{device}\nscene tray {{ {objects} }}\ntask t on plate in tray {{ {steps} }}"), expected);
}

fn orders(text: &str) -> Vec<ElectrodeArrayOrder> {
    let (checked, codes) = checked(text);
    let checked = checked.unwrap_or_else(|| panic!("{codes:?}: {text}"));
    let jobs = checked.claims.iter().flat_map(|claims| &claims.jobs);
    jobs.filter_map(|job| ElectrodeArrayOrder::of(&job.order).cloned()).collect()
}

#[test]
fn the_example_of_the_language_becomes_an_order() {
    let order = &orders(
        "device plate : ea.smart_platform { columns: 50, rows: 50, radius: 35 um }
         scene tray {
           obstacle fixed : cells { from: (20, 20), to: (23, 23) }
           part m1 : ea.micropart at (5, 3)
           part m2 : ea.micropart at (26, 31)
         }
         task swap on plate in tray {
           minimize makespan
           require steps <= 90
           together { move m1 to (26, 31), move m2 to (5, 3) }
         }",
    )[0];
    assert_eq!(order.facts, board(50, 50));
    assert_eq!(
        order.obstacles[0].body,
        ElectrodeArrayObstacleBody::Electrodes { from: ElectrodeCell::new(20, 20), to: ElectrodeCell::new(23, 23) }
    );
    let parts: Vec<(&str, ElectrodeCell)> =
        order.parts.iter().filter_map(|part| Some((part.name.as_str(), part.cell?))).collect();
    assert_eq!(parts, [("m1", ElectrodeCell::new(5, 3)), ("m2", ElectrodeCell::new(26, 31))]);
    let ElectrodeArrayAction::Move(moves) = &order.steps[0].action else { panic!("a step of moves") };
    let goals: Vec<(usize, ElectrodeCell)> = moves.iter().map(|step| (step.part, step.goal().cell)).collect();
    assert_eq!(goals, [(0, ElectrodeCell::new(26, 31)), (1, ElectrodeCell::new(5, 3))]);
    assert_eq!(
        (order.objective, order.planner.method, order.bystanders),
        (ElectrodeArrayObjective::Makespan, ElectrodeArrayMethod::Portfolio, Bystanders::Stay)
    );
}

#[test]
fn radius_gap_and_potential_keep_their_limits() {
    let slow = "step_duration: 100 ms";
    device(&format!("radius: 15 um, {slow}"), &[]);
    device(&format!("radius: 100 um, potential: 225 V, {slow}"), &[]);
    device(&format!("radius: 14.99 um, {slow}"), &["E0409"]);
    device(&format!("radius: 100.1 um, potential: 225 V, {slow}"), &["E0409"]);
    device("pitch_ratio: 0.5", &[]);
    device("pitch_ratio: 0.896", &[]);
    device("pitch_ratio: 0.499", &["E0410"]);
    device("pitch_ratio: 0.897", &["E0410"]);
    device("potential: 99.9 V", &["E0411"]);
    // Half way from 50 V to 100 V, and from 100 V to 125 V.
    device("radius: 22.5 um, potential: 75 V", &[]);
    device("radius: 22.5 um, potential: 74.9 V", &["E0411"]);
    device(&format!("radius: 47.5 um, potential: 112.5 V, {slow}"), &[]);
    device(&format!("radius: 47.5 um, potential: 112.4 V, {slow}"), &["E0411"]);
    // Half of the permittivity needs √2 times the potential.
    device("permittivity: 4, potential: 141.43 V", &[]);
    device("permittivity: 4, potential: 141.41 V", &["E0411"]);
    // 0.747 uN against 0.406 uN and 0.111 uN: 1.4449.
    device("friction: 1.444, step_duration: 10 ms", &[]);
    device("friction: 1.446, step_duration: 10 ms", &["E0411"]);
    chip("potential: 40 V", &[]);
    chip("potential: 39.9 V", &["E0411"]);
}

#[test]
fn the_published_potentials_move_their_parts() {
    for (radius_um, potential_v) in
        [(15, 50), (20, 50), (30, 100), (45, 100), (50, 125), (55, 125), (60, 150), (65, 150)]
    {
        device(&format!("radius: {radius_um} um, potential: {potential_v} V, step_duration: 100 ms"), &[]);
    }
    for (radius_um, potential_v) in [(70, 175), (85, 175), (90, 200), (95, 200), (100, 225)] {
        device(&format!("radius: {radius_um} um, potential: {potential_v} V, step_duration: 100 ms"), &[]);
        device(&format!("radius: {radius_um} um, potential: {} V, step_duration: 100 ms", potential_v - 1), &["E0411"]);
    }
}

fn published() -> Glide {
    let pitch_m = 2.7 * 35e-6;
    Glide {
        pull: Pull::through(pitch_m, 0.747e-6, 35e-6),
        mass_kg: 1180.0 * (3.0 * pitch_m).powi(2) * 17.5e-6,
        damping: 5e-3 * (2.0 * pitch_m).powi(2) / 17.5e-6,
        pitch_m,
        rest_share: 0.02,
    }
}

/// Section 3.2 of the paper: a part of 35 um at 100 V is at rest after 2.2 ms.
#[test]
fn a_part_settles_as_published() {
    let settling_ms = published().settling_s().unwrap_or(0.0) * 1e3;
    assert!((2.0..2.4).contains(&settling_ms), "{settling_ms} ms");
}

#[test]
fn the_pull_goes_through_its_known_points() {
    let pull = Pull::through(94.5e-6, 0.747e-6, 35e-6);
    assert!((pull.at(94.5e-6) - 0.747e-6).abs() < 1e-15);
    assert_eq!(pull.at(0.0), 0.0);
    assert_eq!(pull.at(-20e-6), -pull.at(20e-6));
    let beside = [34e-6, 36e-6].map(|at| pull.at(at));
    assert!(beside.iter().all(|force| *force < pull.at(35e-6)));
}

/// Near its goal a part is a damped spring, whose time constant without inertia is drag over stiffness.
#[test]
fn a_creeping_part_settles_like_a_spring() {
    let spring = Glide {
        pull: Pull { peak_at_m: 1.0, peak_n: 0.5 },
        mass_kg: 1.0,
        damping: 1e4,
        pitch_m: 1e-3,
        rest_share: 0.01,
    };
    let expected_s = 1e4 * (1.0f64 / 0.01).ln();
    let settling_s = spring.settling_s().unwrap_or(0.0);
    assert!((settling_s / expected_s - 1.0).abs() < 0.2, "{settling_s} s, {expected_s} s");
    let lively = Glide { damping: 15.0, ..spring };
    let rate = lively.settling_s().unwrap_or(0.0) / (15.0 * (1.0f64 / 0.01).ln());
    assert!((rate - 1.0).abs() < 0.2, "{rate}");
}

#[test]
fn what_never_settles_is_given_up() {
    for damping in [0.0, 1e-20, f64::INFINITY, f64::NAN] {
        assert_eq!(Glide { damping, ..published() }.settling_s(), None, "{damping}");
    }
    for mass_kg in [0.0, f64::INFINITY, f64::NAN] {
        assert_eq!(Glide { mass_kg, ..published() }.settling_s(), None, "{mass_kg}");
    }
}

#[test]
fn a_step_is_long_enough_to_settle() {
    let settling_ms = published().settling_s().unwrap_or(0.0) * 1e3;
    device(&format!("step_duration: {} ms", settling_ms + 0.001), &[]);
    device(&format!("step_duration: {} ms", settling_ms - 0.001), &["E0412"]);
    device("viscosity: 1e-15 ug/um/s", &["E0412"]);
    device("settling: 3 ms", &[]);
    device("settling: 3.001 ms", &["E0412"]);
    chip("step_duration: 50 ms", &[]);
    chip("step_duration: 49.9 ms", &["E0412"]);
}

#[test]
fn forces_need_mass_and_drag() {
    let own = "device plate : electrode_array {
        columns: 5, rows: 5, radius: 35 um, pitch_ratio: 0.7, potential: 100 V, step_duration: 3 ms, part: ea.micropart
        separation: 4, clearance: 3
        forces: table {
          radius [um] | potential [V] | permittivity | distance [um] | vertical_force [uN] | weight [uN] | lateral_force [uN]
          35 | 100 | 8 | 94.5 | 0.406 | 0.111 | 0.747
        }";
    let task = "task t on plate { wait 5 ms }";
    assert_codes(&format!("{own}\n mass: 1.66 ug, damping: 1.02e-5 kg/s }}\n{task}"), &[]);
    assert_codes(&format!("{own}\n settling: 2 ms }}\n{task}"), &[]);
    assert_codes(&format!("{own}\n mass: 1.66 ug }}\n{task}"), &["E0401"]);
    assert_codes(&format!("{own} }}\n{task}"), &["E0401"]);
}

#[test]
fn layouts_are_those_that_boards_carry() {
    device("part: layout { electrodes: (3, 3), half_width: 2.5 }", &["E0413"]);
    device("part: layout { electrodes: (1, 2), half_width: 2.5 }", &["E0413"]);
    // One pitch and 35 um of a pitch of 94.5 um.
    device("part: layout { electrodes: (2, 2), half_width: 1.3704 }", &[]);
    device("part: layout { electrodes: (2, 2), half_width: 1.37 }", &["E0413"]);
    device("part: layout { electrodes: (2, 2), half_width: 1.999 }, step_duration: 10 ms", &[]);
    device("part: layout { electrodes: (2, 2), half_width: 2 }, step_duration: 10 ms", &["E0414"]);
    device("separation: 3", &["E0414"]);
    device("clearance: 2", &[]);
    device("clearance: 1", &["E0414"]);
    chip("separation: 1, part: layout { electrodes: (1, 1), half_width: 0.48 }", &["E0414"]);
    chip("part: layout { electrodes: (1, 1), half_width: 0.46 }", &["E0413"]);
    chip("part: layout { electrodes: (1, 1), half_width: 0.999 }", &[]);
    chip("part: layout { electrodes: (1, 1), half_width: 1 }", &["E0414", "E0414"]);
}

#[test]
fn a_board_has_room_for_a_part() {
    device("columns: 3, rows: 3", &[]);
    device("columns: 2, rows: 3", &["E0415"]);
    device("columns: 3, rows: 2", &["E0415"]);
    device("columns: 1000, rows: 1000", &[]);
    device("columns: 1001", &["E0403"]);
    chip("columns: 1, rows: 1", &[]);
}

#[test]
fn published_separations_are_for_published_planners() {
    let text = |planner: &str| {
        format!(
            "device plate : ea.smart_platform {{ separation: as_published }}
             scene tray {{ part m1 at (5, 3) }}
             task t on plate in tray {{ {planner} move m1 to (9, 3) }}"
        )
    };
    assert_codes(&text("using cooperative_astar,"), &["W0402"]);
    assert_codes(&text("using plain_cooperative_astar,"), &["W0402"]);
    assert_codes(&text(""), &["W0402", "E0520"]);
    assert_codes(&text("using portfolio,"), &["W0402", "E0520"]);
}

#[test]
fn published_planners_plan_single_goals() {
    let parts = "part m1 at (5, 3), part m2 at (15, 3)";
    for planner in ["cooperative_astar", "plain_cooperative_astar"] {
        let ask = |rest: &str, expected: &[&str]| steps(parts, &format!("using {planner}, {rest}"), expected);
        ask("together { move m1 to (5, 9), move m2 to (15, 9) }", &[]);
        ask("minimize makespan, may_yield: false, move m1 to (5, 9)", &[]);
        ask("minimize sum_of_costs, move m1 to (5, 9)", &["E0520"]);
        ask("may_yield: true, move m1 to (5, 9)", &["E0520"]);
        ask("move m1 to (5, 9) via (9, 9)", &["E0520"]);
        droplets(parts, &format!("using {planner}, merge m1 with m2 at (9, 9)"), &["E0520"]);
    }
    steps(parts, "minimize sum_of_costs, may_yield: true, move m1 to (5, 9) via (9, 9)", &[]);
}

#[test]
fn objects_stand_on_the_board() {
    for cell in ["(2, 2)", "(19, 19)", "(2, 19)"] {
        scene(&format!("part m1 at {cell}"), &[]);
    }
    for cell in ["(1, 2)", "(2, 20)", "(21, 5)", "(0, 5)", "(-3, 5)", "(2.5, 5)", "(1e15, 5)", "(3 um, 3 um)"] {
        scene(&format!("part m1 at {cell}"), &["E0515"]);
    }
    scene("part m1", &["E0515"]);
    scene("obstacle o", &["E0515"]);
    scene("obstacle o at (20, 20)", &[]);
    scene("obstacle o at (21, 20)", &["E0515"]);
    scene("obstacle o : cells { from: (20, 20), to: (90, 90) }", &[]);
    scene("obstacle o : cells { from: (21, 20), to: (90, 90) }", &["E0515"]);
    scene("obstacle o : cells { from: (21, 20), to: (90, 90) } at (-1, 0)", &[]);
    scene("obstacle o : ea.micropart at (1, 1)", &[]);
    scene("obstacle o : ea.micropart at (1, 0)", &["E0515"]);
    scene("obstacle o : ea.droplet at (4, 4)", &["E0521"]);
    scene("part m1 : ea.droplet at (4, 4)", &["E0521"]);
    scene("part m1 : layout { electrodes: (2, 2), half_width: 1.5 } at (4, 4)", &[]);
    scene("part m1 : layout { electrodes: (2, 2), half_width: 1.51 } at (4, 4)", &["E0521"]);
    scene("part m1 : cells { from: (1, 1), to: (2, 2) } at (4, 4)", &["E0514"]);
    scene("obstacle o : disc { radius: 3 um } at (4, 4)", &["E0514"]);
}

#[test]
fn starts_keep_apart() {
    scene("part m1 at (5, 3), part m2 at (9, 3)", &[]);
    scene("part m1 at (5, 3), part m2 at (8, 6)", &["E0523"]);
    scene("part m1 at (5, 3), part m2 at (5, 3)", &["E0523"]);
    scene("part m1 at (5, 3), obstacle o at (8, 6)", &[]);
    scene("part m1 at (5, 3), obstacle o at (7, 5)", &["E0505"]);
    scene("part m1 at (5, 3), obstacle o : ea.micropart at (9, 3)", &[]);
    scene("part m1 at (5, 3), obstacle o : ea.micropart at (8, 6)", &["E0505"]);
    droplets("part a at (5, 3), part b at (7, 3), obstacle o at (6, 4)", "wait 5 ms", &[]);
    droplets("part a at (5, 3), part b at (6, 4)", "wait 5 ms", &["E0523"]);
    droplets("part a at (5, 3), obstacle o at (5, 3)", "wait 5 ms", &["E0505"]);
}

#[test]
fn goals_are_free_cells() {
    let objects = "part m1 at (5, 3), obstacle o at (12, 12), obstacle f : ea.micropart at (5, 14)";
    steps(objects, "move m1 to (19, 19)", &[]);
    steps(objects, "move m1 to (9, 12)", &[]);
    steps(objects, "move m1 to (10, 12)", &["E0502"]);
    steps(objects, "move m1 to (5, 10)", &[]);
    steps(objects, "move m1 to (5, 11)", &["E0502"]);
    steps(objects, "move m1 to (5, 5) via (5, 11)", &["E0502"]);
    steps(objects, "move m1 to (20, 5)", &["E0501"]);
    steps(objects, "move m1 to (5, 5) via (-7, 5)", &["E0501"]);
    steps(objects, "move m1 to (1e15, 5)", &["E0501"]);
    steps(objects, "move m1 to (5.5, 5)", &["E0515"]);
    steps(objects, "move m1 to (5 um, 5 um)", &["E0304"]);
    steps(objects, "move m2 to (5, 5)", &["E0211"]);
    steps(objects, "move o to (5, 5)", &["E0211"]);
    tasks("", "task t on plate { move m1 to (5, 5) }", &["E0211"]);
    steps(objects, "start at (5, 3), move m1 to (5, 5)", &["E0518"]);
}

#[test]
fn goals_at_the_same_time_are_apart() {
    let objects = "part m1 at (5, 3), part m2 at (15, 3), part m3 at (5, 15)";
    steps(objects, "together { move m1 to (15, 3), move m2 to (5, 3) }", &[]);
    steps(objects, "together { move m1 to (9, 9), move m2 to (13, 9) }", &[]);
    steps(objects, "together { move m1 to (9, 9), move m2 to (12, 12) }", &["E0524"]);
    steps(objects, "together { move m1 to (9, 9), move m2 to (9, 9) }", &["E0524"]);
    steps(objects, "together { move m1 to (9, 9), move m1 to (15, 15) }", &["E0525"]);
    steps(objects, "move m1 to (11, 3)", &[]);
    steps(objects, "move m1 to (12, 3)", &["E0524"]);
    steps(objects, "move m1 to (9, 9) via (12, 3)", &["E0524"]);
    steps(objects, "may_yield: true, move m1 to (9, 9) via (12, 3)", &[]);
    steps(objects, "may_yield: true, move m1 to (12, 3)", &["E0524"]);
    steps(objects, "move m2 to (15, 9), move m1 to (15, 3)", &[]);
    steps(objects, "move m2 to (15, 9), move m1 to (15, 6)", &["E0524"]);
    steps(objects, "move m2 to (15, 9), wait 5 ms, move m1 to (15, 3), move m3 to (18, 9)", &["E0524"]);
}

#[test]
fn droplets_merge_once() {
    let objects = "part a at (5, 3), part b at (15, 3), part c at (5, 15)";
    droplets(objects, "merge a with b at (9, 3), move a to (12, 12)", &[]);
    droplets(objects, "merge a with b at (9, 3), merge a with c at (12, 12)", &[]);
    droplets(objects, "merge a with b at (9, 3), move c to (15, 3)", &[]);
    droplets(objects, "merge a with b at (9, 3), move b to (12, 12)", &["E0526"]);
    droplets(objects, "merge a with b at (9, 3), move c to (9, 4)", &["E0524"]);
    droplets(objects, "merge a with a at (9, 3)", &["E0527"]);
    droplets(objects, "together { merge a with b at (9, 3), move b to (12, 12) }", &["E0525"]);
    droplets(objects, "together { merge a with b at (9, 3), move c to (10, 4) }", &["E0524"]);
    droplets(objects, "together { merge a with b at (9, 3), move c to (11, 4) }", &[]);
    steps(objects, "merge a with b at (9, 3)", &["E0527"]);
}

#[test]
fn parts_stand_where_the_last_task_left_them() {
    let objects = "part m1 at (5, 3), part m2 at (15, 3)";
    let go = "task go(p: part, goal: cell) on plate in tray { move p to goal }\n";
    let run = |program: &str, expected: &[&str]| tasks(objects, &format!("{go}program all {{ {program} }}"), expected);
    run("run go(m1, (5, 9)), run go(m2, (5, 3))", &[]);
    run("run go(m2, (5, 3)), run go(m1, (5, 9))", &["E0524"]);
    run("run go(m1, (5, 9)), run go(m2, (5, 6))", &["E0524"]);
    run("for i in 0..4 { run go(m2, (5, 6)) }", &["E0524"]);
    run("run go(m3, (5, 6))", &["E0211"]);
    run("run go(m1, 5 um)", &["E0304"]);
    tasks(objects, go, &["W0502"]);
}

#[test]
fn scenes_of_one_schedule_have_the_same_parts() {
    let text = |other: &str| {
        format!(
            "device plate : ea.smart_platform
             scene tray {{ part m1 at (5, 3), part m2 at (15, 3) }}
             scene other {{ {other}, obstacle o at (30, 30) }}
             task first on plate in tray {{ move m1 to (5, 9) }}
             task second on plate in other {{ move m2 to (5, 3) }}
             program both {{ run first, run second }}"
        )
    };
    assert_codes(&text("part m2 at (25, 3), part m1 at (5, 3)"), &[]);
    assert_codes(&text("part m2 at (25, 3), part m3 at (5, 3)"), &["E0528"]);
    assert_codes(&text("part m2 at (25, 3)"), &["E0528"]);
}

#[test]
fn obstacles_of_a_later_scene_leave_room_for_the_parts() {
    let text = |obstacle: &str| {
        format!(
            "device plate : ea.smart_platform
             scene earlier {{ part m1 at (5, 3) }}
             scene later : earlier {{ obstacle o {obstacle} }}
             task bring on plate in earlier {{ move m1 to (15, 5) }}
             task clear on plate in later {{ move m1 to (5, 3) }}
             program day {{ for i in 0..2 {{ run bring, run clear }} }}"
        )
    };
    assert_codes(&text("at (18, 5)"), &[]);
    assert_codes(&text("at (17, 5)"), &["E0530"]);
    assert_codes(&text("at (15, 5)"), &["E0530"]);
    assert_codes(&text(": ea.micropart at (19, 5)"), &[]);
    assert_codes(&text(": ea.micropart at (18, 5)"), &["E0530"]);
}

#[test]
fn droplets_merge_where_they_are_held() {
    let text = |hold: &str| {
        format!(
            "device chip : ea.droplet_chip {{ hold: {hold} }}
             scene tray {{ part a at (2, 2), part b at (8, 2) }}
             task t on chip in tray {{ merge a with b at (5, 2) }}"
        )
    };
    assert_codes(&text("true"), &[]);
    assert_codes(&text("false"), &["E0529"]);
}

fn board(columns: u32, rows: u32) -> ElectrodeArrayFacts {
    ElectrodeArrayFacts { step_ns: 3_000_000, ..microparts(columns, rows) }
}

/// Random numbers below a bound.
fn numbers() -> impl FnMut(u32) -> u32 {
    let mut stream = SplitMix64::new(12_345);
    move |most| stream.below(most as usize) as u32
}

#[test]
fn the_painted_cover_agrees_with_asking_every_obstacle() {
    let facts = board(70, 50);
    let mut next = numbers();
    let bodies: Vec<ElectrodeArrayObstacleBody> = (0..25)
        .map(|index| {
            let from = ElectrodeCell::new(1 + next(70), 1 + next(50));
            let to = ElectrodeCell::new((from.column + next(9)).min(70), (from.row + next(4)).min(50));
            if index % 3 == 0 {
                ElectrodeArrayObstacleBody::Fixed(from)
            } else {
                ElectrodeArrayObstacleBody::Electrodes { from, to }
            }
        })
        .collect();
    let obstacles: Vec<ElectrodeArrayObstacle> = bodies
        .into_iter()
        .map(|body| ElectrodeArrayObstacle { name: String::new(), body, span: Span::default() })
        .collect();
    let cover = ObstacleCells::of(&obstacles, &facts);
    let mut covered = 0;
    for (column, row) in (1..=70).flat_map(|column| (1..=50).map(move |row| (column, row))) {
        let cell = ElectrodeCell::new(column, row);
        let expected = obstacles.iter().position(|obstacle| match obstacle.body {
            ElectrodeArrayObstacleBody::Fixed(at) => cell.apart(at) < 4,
            ElectrodeArrayObstacleBody::Electrodes { from, to } => (from.row..=to.row)
                .flat_map(|row| (from.column..=to.column).map(move |column| ElectrodeCell::new(column, row)))
                .any(|at| cell.apart(at) < 3),
        });
        assert_eq!(cover.covering(cell), expected, "{cell}");
        covered += usize::from(expected.is_some());
    }
    assert!((500..3000).contains(&covered), "{covered} covered cells say little");
}

#[test]
fn the_spread_agrees_with_asking_every_place() {
    let mut next = numbers();
    let mut spread: SpacedPlaces<usize> = SpacedPlaces::new(4);
    let mut places: Vec<ElectrodeCell> = Vec::new();
    let mut near = 0;
    for _ in 0..2000 {
        let cell = ElectrodeCell::new(1 + next(60), 1 + next(60));
        let expected = places.iter().map(|at| at.apart(cell)).min().filter(|apart| *apart < 4);
        assert_eq!(spread.near(cell).map(|(at, _)| at.apart(cell)), expected, "{cell}");
        if expected.is_none() {
            spread.put(cell, places.len());
            places.push(cell);
        } else if near % 50 == 0 {
            let gone = places.swap_remove(0);
            spread.take(gone, |_| true);
        }
        near += usize::from(expected.is_some());
    }
    assert!(near > 100 && places.len() > 50);
}

#[test]
fn the_nearest_cell_is_one_that_can_be_taken() {
    let facts = board(20, 20);
    assert_eq!(nearest_cell(ElectrodeCell::new(1, 7), &facts, |_| true), Some(ElectrodeCell::new(2, 7)));
    assert_eq!(nearest_cell(ElectrodeCell::new(900, 7), &facts, |_| true), Some(ElectrodeCell::new(19, 7)));
    assert_eq!(nearest_cell(ElectrodeCell::new(5, 5), &facts, |cell| cell.column > 7), Some(ElectrodeCell::new(8, 5)));
    assert_eq!(nearest_cell(ElectrodeCell::new(5, 5), &facts, |_| false), None);
}

#[test]
fn crowded_boards_and_long_tasks_are_checked_fast() {
    let many = "device plate : ea.droplet_chip { columns: 1000, rows: 1000 }
        scene tray {
          for i in 0..50 { for j in 0..20 { part d[i, j] at (3 * i + 1, 3 * j + 1) } }
          for i in 0..300 { for j in 0..300 { obstacle o[i, j] at (i + 400, j + 400) } }
          for i in 0..300 { obstacle w[i] : cells { from: (200, 200), to: (1000, 1000) } }
        }
        task back_and_forth on plate in tray {
          for k in 0..1000 { together { for i in 0..50 { move d[i, 0] to (3 * i + 1, 2 - 2 * floor(k / 2) + k) } } }
        }
        program all { for k in 0..20 { run back_and_forth } }";
    let (_, codes) = checked(many);
    assert!(codes.iter().all(|code| code == "E0524" || code == "E0501"), "{codes:?}");
    let too_many = "device plate : ea.droplet_chip { columns: 1000, rows: 1000 }
        scene tray { for i in 0..400 { for j in 0..400 { part d[i, j] at (1, 1) } } }
        task t on plate in tray { move d[3, 3] to (5, 5) }";
    assert_codes(too_many, &["E0522"]);
}
