//! Programs for beds that once hung, were refused by the verifier, or got a wrong answer. The first line of each gives
//! the right one.

use super::support::{Built, build, found, found_path};
use std::path::Path;
use std::process::Command;

fn built(name: &str) -> Built {
    build(&found(name))
}

/// Standard output of a command on a program.
fn output_of(command: &[&str], name: &str) -> String {
    let mut tool = Command::new(env!("CARGO_BIN_EXE_tweeze"));
    tool.args(command).arg(found_path(name)).current_dir(env!("CARGO_TARGET_TMPDIR"));
    let output = tool.output().expect("the tool runs");
    assert!(output.status.success(), "{name}: {}", String::from_utf8_lossy(&output.stderr));
    String::from_utf8_lossy(&output.stdout).into_owned()
}

fn codes(name: &str) -> Vec<&'static str> {
    let built = built(name);
    assert!(!built.refused, "{name} is refused by the judge");
    built.codes
}

const NONE: [&str; 0] = [];

#[test]
fn extreme_programs_build_or_are_refused_at_the_door() {
    assert_eq!(codes("hang-assemble-slow-robots"), ["E0403"; 3]);
    assert_eq!(codes("hang-heading"), ["E0501"]);
    assert_eq!(codes("hang-place-error"), ["E0403"]);
    assert_eq!(codes("refused-apply-far"), ["E0501"]);
    assert_eq!(codes("refused-heading"), NONE);
    assert_eq!(codes("refused-fine-cycle"), NONE);
    assert_eq!(codes("microrobots-precision-half-stroke"), NONE);
    let tight = codes("refused-docking-tolerance");
    assert!(tight == NONE || tight == ["E0602"], "{tight:?}");
}

/// All three were once reported as guaranteed, although no trial of any succeeded: in one a robot would turn flat
/// against its edge, and in another D1 passes the end of D2 at 20 um, which is not the edge with which it docks.
#[test]
fn what_fails_in_trials_is_not_guaranteed() {
    assert!(codes("microrobots-guaranteed-gap").contains(&"E0605"));
    assert_eq!(codes("microrobots-guaranteed-incidence"), ["E0537"]);
    let said = output_of(&["build", "-o", "guaranteed-beside", "--force"], "microrobots-guaranteed-beside");
    assert!(said.contains("D1: not guaranteed") && said.contains("0.27 % of all errors"), "{said}");
    let within = &["simulate", "--trials", "1000", "--set", "k=0.00027"];
    let reported = output_of(within, "microrobots-guaranteed-beside");
    assert!(reported.contains("1000 of 1000 trials succeeded"), "{reported}");
}

/// Both once took seconds to plan, because examining paths did not count towards the budget.
#[test]
fn all_work_is_part_of_the_budget() {
    assert_eq!(codes("microrobots-heading-too-fine"), ["E0602"]);
    assert_eq!(codes("microrobots-obstacle-before-goal"), ["E0602"]);
}

#[test]
fn extreme_figures_of_a_device_end_in_an_answer() {
    let with = |field: &str| {
        let text = format!(
            "use std.microrobots as m\ndevice d : m.bed {{ {field} }}\nscene s {{ robot D3 at pose(0 mm, 0 mm, 90 deg)\n \
             robot D4 at pose(2 mm, 1 mm, 0 deg) }}\n\
             task t on d in s {{ assemble {{ D4 to pose(2 mm, 3 mm, 90 deg), D3 to pose(2 mm, 3260 um, 270 deg) }} }}\n"
        );
        let built = build(&text);
        assert!(!built.refused, "{text}");
        built.codes
    };
    assert_eq!(with("step_size: 1e-6 nm"), ["E0403"]);
    assert_eq!(with("fine_length: 1 m"), ["E0403"]);
    for field in ["speed_error: 1e4", "turning_error: 1e9 deg/mm", "heading_error: 1e9 deg", "place_error: 1 m"] {
        assert_eq!(with(field), ["E0403"], "{field}");
    }
    for field in [
        "fine_cycle: 0.1 um",
        "fine_cycle: 1e-3 um",
        "fine_cycle: 0.5 um",
        "fine_length: 100 mm",
        "docking_tolerance: 0 um",
    ] {
        with(field);
    }
}

/// A drive of `D1` while `D2` is idle before a disc, `aside_um` to its left.
fn before_a_disc(aside_um: u32) -> Built {
    build(&format!(
        "use std.microrobots as m\ndevice fleet : m.bed {{ robots: table {{\n robot | snap_down [V] | release [V] | turning_radius [um]\n \
         D1 | 110 | 20 | 165\n D2 | 122 | 33 | 165\n }}, margin: 2 V }}\nscene field {{\n robot D1 at pose(0 mm, 0 mm, 90 deg)\n \
         robot D2 at pose(2 mm, 2 mm, 0 deg)\n obstacle stone : disc {{ radius: 100 um }} at (2255 um, {} um)\n}}\n\
         task go on fleet in field {{ drive D1 to pose(1 mm, -1 mm, 0 deg) }}\n",
        2000 + aside_um
    ))
}

/// No voltage keeps an idle robot away from an obstacle right in front of it; it can turn or run past one slightly to
/// the side.
#[test]
fn a_bystander_before_an_obstacle_is_a_proof_and_one_beside_it_is_not() {
    assert_eq!(before_a_disc(0).codes, ["E0601"]);
    let beside = before_a_disc(200);
    assert!(!beside.refused && beside.codes == NONE, "{:?}", beside.codes);
}

#[test]
fn a_bound_is_no_more_than_any_plan_takes() {
    let (driven, applied) = (built("microrobots-bound-drive"), built("microrobots-bound-applied"));
    let [driven, applied] = [&driven, &applied].map(|built| &built.schedules[0].schedule().plans[0]);
    assert!(driven.bound <= applied.cost && applied.cost < driven.cost && !driven.optimal, "{driven:?}");
    assert!(applied.optimal && applied.bound == applied.cost);
    assert!(driven.bound > 0.98 * applied.cost, "{}", driven.bound);
}

/// Robots in bays and beside each other: few sequences of legs save them all and lead one to its goal.
#[test]
fn crowded_robots_are_driven_where_few_sequences_of_legs_lead() {
    for drive in [38, 172, 175] {
        assert_eq!(codes(&format!("microrobots-crowded-drive-{drive}")), NONE, "drive {drive}");
    }
}

#[test]
fn a_search_that_ends_is_no_proof() {
    assert_eq!(codes("microrobots-false-e0601-bystander"), ["E0602"]);
}

/// Goals in orbits, overlapping orbits, meetings that cannot be timed, robots in the way: initial legs of the whole bed
/// help.
#[test]
fn robots_in_the_way_move_away_first() {
    for name in ["e0538-goal", "e0538-orbits", "false-e0601", "e0602-orbit", "e0602-untimely", "e0602-drive"] {
        let found = codes(&format!("microrobots-{name}"));
        assert!(found == NONE || found == ["W0511"], "{name}: {found:?}");
    }
    for name in [
        "e0538-goal-moved-first",
        "e0538-orbits-moved-first",
        "e0602-orbit-moved-first",
        "e0602-untimely-moved-first",
        "e0602-applied",
        "plan-that-never-succeeds",
    ] {
        let found = codes(&format!("microrobots-{name}"));
        assert!(found == NONE || found == ["W0511"], "{name}: {found:?}");
    }
}

#[test]
fn a_plan_that_is_likely_to_fail_is_warned_of_and_another_chosen_on_demand() {
    let text = found("microrobots-e0538-goal-moved-first");
    let printed = |text: &str| {
        let file = Path::new(env!("CARGO_TARGET_TMPDIR")).join("likely-to-fail.twz");
        std::fs::write(&file, text).expect("a file");
        let mut tool = Command::new(env!("CARGO_BIN_EXE_tweeze"));
        tool.args(["build", "--force", "-o", "likely-to-fail"]).arg(file).current_dir(env!("CARGO_TARGET_TMPDIR"));
        let output = tool.output().expect("the tool runs");
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        [output.stdout, output.stderr].map(|stream| String::from_utf8_lossy(&stream).into_owned())
    };
    let [reported, warned] = printed(&text);
    assert!(
        reported.contains("Expected  ") && warned.contains("W0511") && warned.contains("minimize failures"),
        "{warned}"
    );
    let chosen = text.replacen("  precision: 0.5 um", "  minimize failures\n  precision: 0.5 um", 1);
    assert_ne!(chosen, text);
    let [reported, warned] = printed(&chosen);
    assert!(reported.contains("% of simulated trials fail") && !warned.contains("W0511"), "{reported}{warned}");
}

/// A plan with fewer control cycles than the fastest one, or as many, and never fewer than the program applies.
#[test]
fn switches_are_minimized() {
    let text = found("microrobots-e0602-untimely");
    let plan = |text: &str| build(text).schedules[0].schedule().plans[0].clone();
    let fewest = plan(&text.replacen("  assemble {", "  minimize switches\n  assemble {", 1));
    let fastest = plan(&text);
    assert_eq!((fewest.objective.as_str(), fewest.cost), ("switches", fewest.outcomes["switches"]));
    assert!(
        fewest.cost <= fastest.outcomes["switches"] && fewest.outcomes["time_ns"] >= 1e9 * fastest.cost,
        "{fewest:?}"
    );
    assert!(fewest.bound <= fewest.cost && !fewest.optimal);
}

#[test]
fn nothing_is_guaranteed_with_errors_and_everything_without() {
    for name in ["a", "c"] {
        assert_eq!(codes(&format!("microrobots-false-guarantee-{name}")), ["E0605"]);
    }
    // The plan with a fine motion did not bear these errors; the one with a few legs does, as written.
    let reported = output_of(&["simulate", "--trials", "1000"], "microrobots-false-guarantee-b");
    assert!(reported.contains("1000 of 1000 trials succeeded"), "{reported}");
    let reported = output_of(&["build"], "microrobots-no-errors-not-guaranteed");
    assert!(reported.contains("D1: guaranteed") && !reported.contains("not guaranteed"), "{reported}");
}

#[test]
fn without_errors_every_trial_carries_out_the_plan() {
    let reported = output_of(&["simulate", "--trials", "20"], "microrobots-no-errors-simulate-fails");
    assert!(reported.contains("20 of 20 trials succeeded"), "{reported}");
    for name in ["no-errors-not-guaranteed", "no-errors-beside-a-side", "no-errors-wide-precision"] {
        let reported = output_of(&["simulate", "--trials", "20"], &format!("microrobots-{name}"));
        assert!(reported.contains("20 of 20 trials succeeded"), "{name}: {reported}");
    }
}
