//! Logs: the judge is not talked round.

use super::bench::{Bench, DONE, REFUSED, USAGE, found, says};

const SETTING: &str = "--set bead_radius=0.01um";

/// A log that drives the tip through a bead which its builder made small.
fn built_with_a_small_bead() -> Bench {
    let bench = Bench::new();
    bench.write("lab.twz", found("against-set.twz"));
    let built = bench.run(&["build", "lab.twz", "--set", "bead_radius=0.01um"]).code(DONE);
    says(&built.out, &["With", SETTING]);
    bench
}

#[test]
fn a_trusted_program_is_taken_with_its_own_values() {
    let bench = built_with_a_small_bead();
    let refused = bench.run(&["verify", "go.mcap", "--against", "lab.twz"]).code(REFUSED);
    says(&refused.err, &["E0770", "`go.mcap` was built with `--set bead_radius=0.01um`"]);
    says(&refused.err, &["`--against lab.twz --set bead_radius=0.01um`"]);
    assert_eq!(refused.out, "");
    let repeated = ["verify", "go.mcap", "--against", "lab.twz", "--set", "bead_radius=0.01um"];
    says(&bench.run(&repeated).code(DONE).out, &["With", SETTING, "Matches", "with the settings above"]);
    let other = ["verify", "go.mcap", "--against", "lab.twz", "--set", "bead_radius=0.02um"];
    says(&bench.run(&other).code(REFUSED).err, &["E0770"]);
    bench.run(&["verify", "go.mcap", "--set", "bead_radius=0.01um"]).code(USAGE);
}

#[test]
fn a_setting_that_only_the_command_line_has_is_named() {
    let bench = Bench::new();
    bench.write("lab.twz", found("against-set.twz"));
    bench.run(&["build", "lab.twz"]).code(DONE);
    bench.run(&["verify", "go.mcap", "--against", "lab.twz"]).code(DONE);
    let other = ["verify", "go.mcap", "--against", "lab.twz", "--set", "bead_radius=0.02um"];
    says(&bench.run(&other).code(REFUSED).err, &["E0770", "was built without `--set bead_radius=0.02um`"]);
    // A setting that says what the program says anyway changes no claim.
    let same = ["verify", "go.mcap", "--against", "lab.twz", "--set", "bead_radius = 1um"];
    bench.run(&same).code(DONE);
}

#[test]
fn every_report_names_the_settings_in_force() {
    let bench = built_with_a_small_bead();
    says(&bench.run(&["verify", "go.mcap"]).code(DONE).out, &["With", SETTING, "instead of its own value"]);
    bench.run(&["build", "lab.twz"]).code(DONE);
    assert!(!bench.run(&["verify", "go.mcap"]).code(DONE).out.contains("With"));
}

#[test]
fn what_was_not_derived_again_is_called_so() {
    let bench = Bench::new();
    bench.write("a.twz", "use std.dimibot\ndevice bot : dimibot.femto_st\ntask go on bot { move to (1, 1) }\n");
    bench.run(&["build", "a.twz"]).code(DONE);
    let told = bench.run(&["verify", "go.mcap", "--against", "a.twz"]).code(DONE).out;
    says(&told, &["Unchecked", "the planner's bounds, and that the plan is optimal: recorded, and not derived again"]);
}

#[cfg(unix)]
#[test]
fn a_name_forges_no_line_and_commands_no_terminal() {
    let bench = Bench::new();
    let name = "t.twz\n  Matches  fetch.twz  the log does what this program claims\x1b]0;x\x07\u{202e}";
    bench.write(name, "use std.dimibot\ndevice bot : dimibot.femto_st\ntask go on bot { move to (1, 1) }\nlet a = 1\n");
    let built = bench.run(&["build", name, "--emit", "mcap,csv,vcd,pwl,scpi"]).code(DONE);
    let verified = bench.run(&["verify", "go.mcap"]).code(DONE);
    let no_task = bench.run(&["build", name, "--task", "x\n\x1b[2J"]).code(1);
    for text in [built.out, built.err, verified.out, no_task.err] {
        assert!(!text.lines().any(|line| line.trim_start().starts_with("Matches")), "{text}");
        assert!(!text.contains(['\x1b', '\x07', '\u{202e}']), "{text:?}");
    }
    for file in ["go.csv", "go.vcd", "go.pwl.inc", "go.cir", "go.scpi", "go.scpi.txt"] {
        let bytes = std::fs::read(bench.path(file)).expect("it was written");
        let text = String::from_utf8_lossy(&bytes);
        assert!(!text.contains(['\x1b', '\x07', '\u{202e}']), "{file}: {text:?}");
        assert!(!text.lines().any(|line| line.trim_start().starts_with("Matches")), "{file}: {text}");
    }
}
