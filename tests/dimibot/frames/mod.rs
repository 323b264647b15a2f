//! Robots in a common scene frame, tested from outside: programs as text, and an oracle with its own kinematics of the
//! tips.

mod camera;
mod oracle;

use crate::scene::{Random, cases};
use crate::support::{Built, build};
use oracle::least_gap_um;
use tweeze::claims::{Claims, Order};
use tweeze::schedule::{Reached, Schedule};
use tweeze::verify::{Rule, violations};

/// Cases in which two tips are nearer than this to touching are skipped, because the oracle rounds differently.
const HAIR_UM: f64 = 1e-6;

const BOTS: &str = "use std.dimibot\n\
    device left : dimibot.femto_st { left: 5, right: 5, tip_radius: 0.2 um }\n\
    device right : left { }\n";

const FACING: &str = "scene bench {\n  frame left at (0 um, 0 um)\n  frame right at pose(12 um, 12 um, 180 deg)\n}\n";

fn program(scene: &str, tasks: &str) -> Built {
    build(&format!("{BOTS}{scene}{tasks}program day {{ together {{ run fetch, run bring }} }}\n"))
}

/// Whether the verifier finds that the tips touch at some instant; there must be no other violation.
fn refuses_touch(schedule: &Schedule, claims: &Claims) -> bool {
    let found = violations(schedule, claims).unwrap_or_else(|why| panic!("inconclusive: {why}"));
    assert!(found.iter().all(|violation| violation.rule == Rule::Encounter), "{found:#?}");
    !found.is_empty()
}

#[test]
fn two_robots_are_not_sent_to_one_point() {
    let tasks = "task fetch on left in bench { move to (6 um, 6 um) }\n\
                 task bring on right in bench { move to (6 um, 6 um) }\n";
    assert_eq!(program(FACING, tasks).codes, ["E0610"]);
    let unplaced = program("scene bench { }\n", tasks);
    assert_eq!(unplaced.codes, ["W0510"]);
    assert_eq!(unplaced.schedules[0].claims().not_held, [["left".to_owned(), "right".to_owned()]]);
}

#[test]
fn one_robot_waits_until_the_other_has_left_the_point() {
    let tasks = "task fetch on left in bench { move to (6 um, 6 um) }\n\
                 task bring on right in bench { move to (6 um, 6 um), move to (12 um, 12 um) }\n";
    let built = program(FACING, tasks);
    assert_eq!(built.codes, [""; 0]);
    let (schedule, claims) = (built.schedules[0].schedule(), built.schedules[0].claims());
    assert!(least_gap_um(schedule, claims, ["left", "right"]) > 0.0);
    let [fetch, bring] = [&schedule.plans[0], &schedule.plans[1]];
    // Six switches of 15 ms would be 90 ms.
    assert!(fetch.duration_ns > 90_000_000 && fetch.outcomes["time_ns"] == fetch.duration_ns as f64);
    assert!(fetch.optimal && bring.optimal, "the way of neither is longer than alone");
}

#[test]
fn waiting_is_not_called_the_shortest_time() {
    let tasks = "task fetch on left in bench { minimize time, move to (6 um, 6 um) }\n\
                 task bring on right in bench { move to (6 um, 6 um), move to (12 um, 12 um) }\n";
    let built = program(FACING, tasks);
    let plan = &built.schedules[0].schedule().plans[0];
    assert!(plan.cost > plan.bound && !plan.optimal, "{plan:?}");
    let limited = tasks.replace("minimize time", "require time <= 90 ms");
    assert_eq!(program(FACING, &limited).codes, ["E0610"]);
}

#[test]
fn a_robot_that_never_runs_stands_in_the_way() {
    let at = |cell: &str| {
        let scene = "scene bench {\n  frame left at (0 um, 0 um)\n  frame right at pose(6 um, 6 um, 180 deg)\n}\n";
        build(&format!("{BOTS}{scene}task fetch on left in bench {{ move to {cell} }}\n")).codes
    };
    assert_eq!(at("(14, 14)"), ["E0601"]);
    assert_eq!(at("(20, 20)"), [""; 0]);
}

#[test]
fn the_heading_of_a_frame_has_a_limit_of_its_own() {
    let turned = |turns: u32| {
        let scene = format!("scene bench {{ frame left at pose(1 um, 2 um, {turns} turn) }}\n");
        let left = "use std.dimibot\ndevice left : dimibot.femto_st { left: 5, right: 5 }\n";
        build(&format!("{left}{scene}task fetch on left in bench {{ move to (14, 14) }}\n"))
    };
    // An angle may be larger than the greatest coordinate of a frame in micrometres.
    assert_eq!(turned(20_000).codes, [""; 0]);
    let refused = turned(1_000_001);
    assert_eq!(refused.codes, ["E0560"]);
    assert_eq!(refused.titles, ["the heading of a frame is more than 360000000 deg"]);
}

/// A random program of two robots with goals in cells: `left` and `right` in their own frames, with a few steps each.
fn random_program(random: &mut Random) -> String {
    let modules = |random: &mut Random| 2 + random.below(3);
    let mut text = String::from("use std.dimibot\n");
    let mut sizes = Vec::new();
    for name in ["left", "right"] {
        let (left, right) = (modules(random), modules(random));
        let (tip, home) = (random.thousandths(0.05, 2.0), (random.below(1 << left), random.below(1 << right)));
        let rest = random.below(3) * 4;
        let pulse = 10 + random.below(3) * 5;
        text += &format!(
            "device {name} : dimibot.femto_st {{ left: {left}, right: {right}, tip_radius: {tip} um, \
             rest: {rest} ms, pulse_duration: {pulse} ms, home: ({}, {}) }}\n",
            home.0, home.1
        );
        sizes.push((1 << left, 1 << right));
    }
    let (x, y) = (random.thousandths(-4.0, 16.0), random.thousandths(-4.0, 16.0));
    let heading = random.below(360);
    text += &format!(
        "scene bench {{\n  frame left at pose(1 um, -2 um, 15 deg)\n  frame right at pose({x} um, {y} um, {heading} deg)\n"
    );
    if random.below(3) == 0 {
        let (x, y) = (random.thousandths(0.0, 12.0), random.thousandths(0.0, 12.0));
        text += &format!("  obstacle bead : disc {{ radius: 0.4 um }} at ({x} um, {y} um)\n");
    }
    text += "}\n";
    for (name, size) in ["left", "right"].into_iter().zip(&sizes) {
        for task in 0..2 {
            let setting = match random.below(4) {
                0 => "minimize time, simultaneous: safe, ",
                1 => "minimize time, ",
                2 => "minimize switches, ",
                _ => "",
            };
            let moves: Vec<String> = (0..1 + random.below(3))
                .map(|_| match random.below(5) {
                    0 => format!("wait {} ms", 1 + random.below(40)),
                    _ => format!("move to ({}, {})", random.below(size.0), random.below(size.1)),
                })
                .collect();
            text += &format!("task {name}{task} on {name} in bench {{ {setting}{} }}\n", moves.join(", "));
        }
    }
    let body = match random.below(4) {
        0 => "together { run left0, run right0 }",
        1 => "run left0, run right0",
        2 => "program_left, ",
        _ => "together { run left0, run right0 }, run left1",
    };
    match body {
        "program_left, " => {
            text += "program lefts { run left0, run left1 }\nprogram rights { wait 7 ms, run right0, run right1 }\n\
                                     program day { together { run lefts, run rights } }\n"
        }
        body => text += &format!("program day {{ {body} }}\n"),
    }
    text
}

/// The claims with the second robot at another pose.
fn moved(claims: &Claims, x_um: f64, y_um: f64, turn_rad: f64) -> Claims {
    let mut claims = claims.clone();
    let shift = |frame: &mut tweeze::geometry::shape::Pose| {
        (frame.x_um, frame.y_um, frame.heading_rad) =
            (frame.x_um + x_um, frame.y_um + y_um, frame.heading_rad + turn_rad);
    };
    for scene in &mut claims.shared {
        scene.frames.get_mut("right").into_iter().for_each(shift);
    }
    for job in claims.jobs.iter_mut().filter(|job| job.device == "right") {
        let Order::Dimibot(order) = &mut job.order else { panic!("a DiMiBot") };
        order.frame.as_mut().into_iter().for_each(shift);
        order.obstacles = Default::default();
    }
    claims
}

#[test]
fn accepted_programs_never_touch_and_touching_ones_are_refused() {
    let (mut accepted, mut waited, mut apart, mut broken, mut near) = (0, 0, 0, 0, 0);
    for case in 0..cases(60) {
        let mut random = Random::new(0xF4A3_0000 + case);
        let text = random_program(&mut random);
        let built = build(&text);
        assert!(!built.refused, "the planner's own schedule is refused: {:?}\n{text}", built.codes);
        let Some(verified) = built.schedules.iter().find(|verified| verified.claims().name == "day") else {
            apart += usize::from(built.codes.contains(&"E0610"));
            continue;
        };
        let (schedule, claims) = (verified.schedule(), verified.claims());
        accepted += 1;
        assert_eq!(claims.shared.len(), 1, "{text}");
        let gap_um = least_gap_um(schedule, claims, ["left", "right"]);
        assert!(gap_um > -HAIR_UM, "tips touch: {gap_um} um\n{text}");
        waited += usize::from(schedule.plans.iter().any(|plan| plan.objective == "time" && !plan.optimal));
        for _ in 0..8 {
            let (x_um, y_um) = (random.thousandths(-8.0, 8.0), random.thousandths(-8.0, 8.0));
            let claims = moved(claims, x_um, y_um, random.unit() * 6.0);
            let gap_um = least_gap_um(schedule, &claims, ["left", "right"]);
            if gap_um.abs() < HAIR_UM {
                continue;
            }
            assert_eq!(refuses_touch(schedule, &claims), gap_um < 0.0, "a gap of {gap_um} um\n{text}");
            broken += usize::from(gap_um < 0.0);
            near += usize::from(gap_um > 0.0);
        }
    }
    println!(
        "{accepted} accepted, {waited} with waits in time, {apart} not planned apart; {broken} broken, {near} sound"
    );
    assert!(accepted > 10 && waited > 0 && broken > 10 && near > 10, "{accepted} {waited} {broken} {near}");
}

/// The same task in the robot's own coordinates, and in those of a scene in which the robot is placed elsewhere.
fn in_two_frames(random: &mut Random) -> [String; 2] {
    let stand = [random.thousandths(-20.0, 20.0), random.thousandths(-20.0, 20.0)];
    let heading = random.below(360);
    let turned = |[x, y]: [f64; 2]| {
        let (sin, cos) = f64::from(heading).to_radians().sin_cos();
        [stand[0] + x * cos - y * sin, stand[1] + x * sin + y * cos]
    };
    let mut scenes =
        [String::new(), format!("  frame left at pose({} um, {} um, {heading} deg)\n", stand[0], stand[1])];
    for at in 0..4 {
        let place = [random.thousandths(0.0, 13.0), random.thousandths(0.0, 13.0)];
        let (size, turn) = (random.thousandths(0.2, 3.0), random.below(90));
        let shape =
            ["disc { radius: 0.7 um }".to_owned(), format!("box {{ size: ({size} um, 0.6 um) }}")][at % 2].clone();
        for (scene, [x, y], turn) in [(0, place, turn), (1, turned(place), turn + heading)] {
            scenes[scene] += &format!("  obstacle o{at} : {shape} at pose({x:.12} um, {y:.12} um, {turn} deg)\n");
        }
    }
    let goal = [random.thousandths(0.0, 13.0), random.thousandths(0.0, 13.0)];
    [goal, turned(goal)]
        .into_iter()
        .zip(scenes)
        .map(|([x, y], scene)| {
            format!(
                "{BOTS}scene bench {{\n{scene}}}\ntask go on left in bench {{ move to ({x:.12} um, {y:.12} um) }}\n"
            )
        })
        .collect::<Vec<_>>()
        .try_into()
        .expect("two")
}

#[test]
fn work_costs_the_same_wherever_the_robot_stands() {
    let (mut planned, mut refused) = (0, 0);
    for case in 0..cases(40) {
        let [own, placed] = in_two_frames(&mut Random::new(0x0001_F4A3 + case)).map(|text| (build(&text), text));
        let codes = |built: &Built| built.codes.iter().filter(|code| **code != "W0201").copied().collect::<Vec<_>>();
        assert_eq!(codes(&own.0), codes(&placed.0), "{}\n{}", own.1, placed.1);
        let (Some(own), Some(there)) = (own.0.schedules.first(), placed.0.schedules.first()) else {
            refused += 1;
            continue;
        };
        let (own, there) = (own.schedule(), there.schedule());
        assert_eq!(
            (own.plans[0].cost, &own.plans[0].states),
            (there.plans[0].cost, &there.plans[0].states),
            "{}",
            placed.1
        );
        // Both stop at the same distance from the goal, even if the goal and the reached place are given in the scene.
        let [off, off_there] = [own, there].map(|schedule| match &schedule.steps[0].reached[..] {
            [Reached::Place { asked_um, reached_um, off_um }] => {
                assert!(((reached_um[0] - asked_um[0]).hypot(reached_um[1] - asked_um[1]) - off_um).abs() < 1e-9);
                *off_um
            }
            other => panic!("{other:?}"),
        });
        assert!((off - off_there).abs() < 1e-6, "{off} {off_there}\n{}", placed.1);
        planned += 1;
    }
    println!("{planned} planned, {refused} refused, alike");
    assert!(planned > 5 && refused > 2, "{planned} {refused}");
}
