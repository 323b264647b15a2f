//! Faults injected into the measures of planners and checker, or into those of the verifier: the build fails in either
//! case.
//!
//! Each program is planned with one wrong measure and judged with the right ones, and vice versa. If the two sides
//! shared a measure, both would be wrong alike and the build would report success.

use super::*;
use crate::check::Options;
use crate::check::imports::NoFiles;
use crate::compile::{ProgramSource, check_program};
use crate::diagnostic::Sink;
use crate::geometry::fault::{Fault, Wrong, with};
use crate::lower::lower;
use crate::plan::plan;
use crate::source::Sources;

/// Outcome of a build.
#[derive(Debug, PartialEq)]
enum Built {
    Verified,
    /// The checker or a planner stops it, with these codes.
    Stopped(Vec<&'static str>),
    /// The rules that the verifier finds broken.
    Refused(Vec<Rule>),
    /// The verifier reports that no schedule can be judged by these claims.
    Inconclusive(String),
}

fn built(text: &str) -> Built {
    let (mut sources, mut sink) = (Sources::default(), Sink::default());
    let options = Options::default();
    let program = ProgramSource { name: "a.twz", text, library: &NoFiles, options: &options };
    let checked = check_program(&program, &mut sources, &mut sink);
    let planned = checked.and_then(|checked| {
        let claims = checked.claims.into_iter().next()?;
        let plans = plan(&claims, &mut sink, &mut |_, _, _| {})?;
        Some((lower(&claims, &plans, &sources, &mut sink)?, claims))
    });
    let Some((schedule, claims)) = planned else {
        return Built::Stopped(sink.sorted().iter().map(|diagnostic| diagnostic.code.name()).collect());
    };
    match verify_program(schedule, &claims, &sources) {
        Verdict::Accepted(_) => Built::Verified,
        Verdict::Rejected(found) => {
            let mut rules: Vec<Rule> = found.into_iter().map(|violation| violation.rule).collect();
            rules.sort_unstable();
            rules.dedup();
            Built::Refused(rules)
        }
        Verdict::Inconclusive { why } => Built::Inconclusive(why),
    }
}

/// The program of the bug report: a straight path past a grain of dust.
fn dust() -> String {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/found/common-mode.twz");
    std::fs::read_to_string(path).unwrap_or_else(|error| panic!("{path}: {error}"))
}

/// A robot passes 14 um from a grain of dust, where 20 um are needed.
const ORBIT: &str = "use std.microrobots as m
device fleet : m.bed
scene field {
  robot D1 at pose(0 mm, 0 mm, 90 deg)
  robot D4 at pose(3 mm, 0 mm, 90 deg)
  obstacle dust : disc { radius: 50 um } at (463 um, 0 um)
}
task t on fleet in field { apply state 2 for 12 s }";

const APPLY: &str = "use std.microrobots as m
device fleet : m.bed
scene field { robot D1 at pose(0 mm, 0 mm, 90 deg) }
task t on fleet in field { apply state 2 for 2 s }";

/// The goal is 0.28 um from a bead; the tip needs 0.39 um.
const GOAL: &str = "use std.dimibot
device bot : dimibot.femto_st { left: 5, right: 5, tip_radius: 0.3 um }
scene bench { obstacle bead : disc { radius: 0.8 um } at (6.2 um, 5 um) }
task go on bot in bench {
  start at (0, 0)
  move to (5 um, 5 um)
}";

const FAR: &str = "use std.dimibot
device bot : dimibot.femto_st { left: 5, right: 5 }
task go on bot {
  start at (0, 0)
  move to (12 um, 12 um)
}";

/// Two tips end 0.8 um from each other; they need 0.58 um.
const MEET: &str = "use std.dimibot
device left : dimibot.femto_st { left: 5, right: 5, tip_radius: 0.2 um }
device right : left { }
scene bench {
  frame left  at pose(0 um, 0 um, 0 deg)
  frame right at pose(12 um, 12 um, 180 deg)
}
task fetch on left in bench { move to (6 um, 6 um) }
task bring on right in bench { move to (6 um, 5.2 um) }
program both { together { run fetch, run bring } }";

const BEAD: &str = "use std.fingers as f
device hand : f.three_fingers { support: 3 uN }
scene cell { part bead : ellipsoid { axes: (16 um, 11.845 um, 11.845 um) } }
task t on hand in cell {
  rotate bead by 120 deg about z
  release
}";

const LOADED: &str = "use std.fingers as f
device hand : f.three_fingers { support: 3 uN }
scene cell { part bead : ellipsoid { axes: (16 um, 11.845 um, 11.845 um) } }
task t on hand in cell {
  load: (0 uN, -1.2 uN, 0 uN)
  rotate bead by 60 deg about z
}";

const BOTH_PLANES: &str = "use std.fingers as f
device hand : f.three_fingers { support: 3 uN }
scene cell { part bead : ellipsoid { axes: (16 um, 11.845 um, 11.845 um) } }
task t on hand in cell {
  rotate bead by 80 deg about z
  rotate bead by 220 deg about y
}";

const BEAN: &str = "use std.fingers as f
device hand : f.three_fingers { support: 3 uN }
scene cell { part blank : profile { x: 14 um * cos(t) - 6 um * cos(2 * t), y: 13 um * sin(t) } }
task t on hand in cell {
  precision: 3 deg
  rotate blank by 180 deg about z
}";

#[test]
fn without_a_fault_these_programs_are_verified_or_have_no_plan() {
    for text in [&dust(), APPLY, FAR, MEET, BEAD, LOADED, BOTH_PLANES, BEAN] {
        assert_eq!(built(text), Built::Verified, "{text}");
    }
    assert_eq!(built(ORBIT), Built::Stopped(vec!["E0606"]));
    assert_eq!(built(GOAL), Built::Stopped(vec!["E0502"]));
}

/// Asserts that a build with a fault is rejected, with this rule among those broken.
#[track_caller]
fn refused_for(text: &str, fault: Fault, wrong: Wrong, rule: Rule) {
    match with(fault, wrong, || built(text)) {
        Built::Refused(rules) => assert!(rules.contains(&rule), "{fault:?}: {rules:?}"),
        other => panic!("{fault:?}: {other:?} of\n{text}"),
    }
}

/// Asserts that a build with a fault that corrupts the claims is inconclusive.
#[track_caller]
fn inconclusive_for(text: &str, fault: Fault, wrong: Wrong, expected: &str) {
    match with(fault, wrong, || built(text)) {
        Built::Inconclusive(why) => assert!(why.contains(expected), "{fault:?}: {why}"),
        other => panic!("{fault:?}: {other:?} of\n{text}"),
    }
}

#[test]
fn faults_in_distances_and_shapes_are_noticed() {
    let dust = dust();
    refused_for(&dust, Fault::Distance, [1.0, 15.0], Rule::Graze);
    refused_for(&dust, Fault::Distance, [1.0, 0.3], Rule::Graze);
    refused_for(&dust, Fault::Distance, [1.01, 0.0], Rule::Graze);
    refused_for(&dust, Fault::Grown, [1.0, -15.0], Rule::Graze);
    refused_for(&dust, Fault::Place, [1.0, 15.0], Rule::Graze);
    refused_for(ORBIT, Fault::Distance, [1.0, 15.0], Rule::Orbit);
    refused_for(ORBIT, Fault::Grown, [0.5, 0.0], Rule::Orbit);
    refused_for(ORBIT, Fault::Place, [1.0, 15.0], Rule::Orbit);
    refused_for(GOAL, Fault::Grown, [0.0, 0.0], Rule::Sweep);
    refused_for(GOAL, Fault::Place, [1.0, 0.3], Rule::Sweep);
}

#[test]
fn faults_in_figures_of_robots_are_noticed() {
    refused_for(GOAL, Fault::Growth, [0.0, 0.0], Rule::Sweep);
    refused_for(MEET, Fault::Growth, [0.0, 0.0], Rule::Encounter);
    refused_for(FAR, Fault::Pitch, [1.1, 0.0], Rule::Place);
    refused_for(APPLY, Fault::Stroke, [1.01, 0.0], Rule::State);
}

#[test]
fn faults_in_outlines_are_noticed() {
    refused_for(BEAD, Fault::OutlinePoint, [1.0, -0.3], Rule::Pierce);
    refused_for(BEAD, Fault::OutlinePoint, [0.99, 0.0], Rule::Pierce);
    refused_for(BEAD, Fault::Normal, [1.0, 0.3], Rule::Pierce);
    refused_for(BOTH_PLANES, Fault::Outline, [1.0, 0.04], Rule::State);
    refused_for(LOADED, Fault::Rolled, [1.0, 0.3], Rule::Contact);
    refused_for(BEAD, Fault::WayRolled, [1.01, 0.0], Rule::Contact);
    inconclusive_for(BEAD, Fault::Perimeter, [1.01, 0.0], "one turn round an outline");
}

#[test]
fn faults_in_figures_of_hands_are_noticed() {
    refused_for(LOADED, Fault::Sticking, [1.1, 0.0], Rule::Equilibrium);
    refused_for(BEAD, Fault::Slow, [0.5, 0.0], Rule::Speed);
    inconclusive_for(BEAN, Fault::Step, [3.0, 0.0], "the device's step apart");
}

/// A fault in the verifier alone makes it reject a correct schedule.
#[test]
fn faults_of_the_verifier_are_noticed() {
    let dust = dust();
    refused_for(&dust, Fault::JudgedDistance, [0.5, 0.0], Rule::Graze);
    refused_for(&dust, Fault::JudgedPlace, [1.0, 30.0], Rule::Graze);
    refused_for(BEAD, Fault::JudgedOutline, [1.0, -0.3], Rule::Pierce);
    refused_for(LOADED, Fault::JudgedNormal, [1.0, 0.3], Rule::Equilibrium);
    inconclusive_for(BEAD, Fault::JudgedRoll, [1.01, 0.0], "off the x axis");
}
