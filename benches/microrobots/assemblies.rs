//! Assemblies from the text of a program: planned, and executed a thousand times with errors. There is no public
//! rival for either.

use crate::clock::timed;
use std::fmt::Write;
use tweeze::check::Options;
use tweeze::check::imports::NoFiles;
use tweeze::claims::Claims;
use tweeze::compile::{self, ProgramSource};
use tweeze::diagnostic::Sink;
use tweeze::plan::{self, Motion, Plan};
use tweeze::simulate::simulate;
use tweeze::source::Sources;

/// Trials of one simulation.
const TRIALS: u64 = 1_000;

/// Start and dock of each robot, in millimetres and degrees; the robot that snaps down last comes first.
const ENDS: [([f64; 3], [f64; 3]); 5] = [
    ([-0.5, 3.0, 180.0], [1.60, 1.20, 90.0]),
    ([3.5, 3.0, 0.0], [1.60, 1.46, 270.0]),
    ([4.0, -0.5, 90.0], [1.76, 1.40, 180.0]),
    ([-1.5, -1.0, 0.0], [1.44, 1.26, 0.0]),
    ([5.5, 1.5, 90.0], [1.76, 1.24, 180.0]),
];

/// A program with `count` robots and the best table for that number.
fn program(count: usize) -> String {
    let mut text = "use std.microrobots\ndevice fleet : microrobots.bed {\n  robots: table {\n    \
                    robot | snap_down [V] | release [V] | turning_radius [um]\n"
        .to_owned();
    for label in 1..=count {
        let _ = writeln!(text, "    D{label} | {} | {} | {}", 106 + 12 * label, 8 + 9 * label, 160 + 3 * label);
    }
    text.push_str("  }\n  margin: 2 V\n}\nscene field {\n");
    let pose = |[x, y, heading]: [f64; 3]| format!("pose({x} mm, {y} mm, {heading} deg)");
    let named = || (1..=count).rev().zip(&ENDS);
    for (label, (start, _)) in named() {
        let _ = writeln!(text, "  robot D{label} at {}", pose(*start));
    }
    text.push_str("}\ntask join on fleet in field {\n  assemble {\n");
    for (label, (_, goal)) in named() {
        let _ = writeln!(text, "    D{label} to {}", pose(*goal));
    }
    text.push_str("  }\n}\n");
    text
}

fn claims(text: &str) -> Claims {
    let options = Options::default();
    let program = ProgramSource { name: "bench.twz", text, library: &NoFiles, options: &options };
    let (mut sources, mut sink) = (Sources::default(), Sink::default());
    let checked = compile::check_program(&program, &mut sources, &mut sink).expect("the program is right");
    checked.claims.into_iter().next().expect("it has a task")
}

fn planned(claims: &Claims) -> Option<Plan<Motion<'_>>> {
    plan::plan(claims, &mut Sink::default(), &mut |_, _, _| ())?.pop()
}

/// One row for each number of robots.
pub fn table() {
    println!(
        "Assemblies of 2 to {} robots: planned; then {TRIALS} trials with the errors of `std.microrobots`, on one thread.\n",
        ENDS.len()
    );
    println!("| robots | planned in [ms] | lasts [s] | bound [s] | {TRIALS} trials in [ms] | succeeded |");
    println!("|---|---|---|---|---|---|");
    for count in 2..=ENDS.len() {
        let claims = claims(&program(count));
        let (planning, plan) = timed(|| planned(&claims));
        let Some(plan) = plan else {
            println!("| {count} | {:.1} | no plan | | | |", planning.as_secs_f64() * 1e3);
            continue;
        };
        let (simulating, report) = timed(|| simulate(&plan.motion, TRIALS, 7, 1));
        println!(
            "| {count} | {:.1} | {:.1} | {:.1} | {:.0} | {} |",
            planning.as_secs_f64() * 1e3,
            plan.cost,
            plan.bound,
            simulating.as_secs_f64() * 1e3,
            report.map_or(0, |report| report.successes)
        );
    }
    println!();
}
