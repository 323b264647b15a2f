//! Hostile logs: the verifier is not deceived.

use super::bench::{Bench, DONE, REFUSED, USAGE, found, says};
use tweeze::check::Options;
use tweeze::check::imports::NoFiles;
use tweeze::compile::{CompileOutcome, ProgramSource, check_program, compile, planned};
use tweeze::diagnostic::{Remark, Sink};
use tweeze::emit::{Format, Provenance, emit};
use tweeze::schedule::PlanRecord;
use tweeze::source::Sources;
use tweeze::verify::{Verdict, verify_program};

const SETTING: &str = "--set bead_radius=0.01um";

/// A log that drives the tip through a bead that its builder declared too small.
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
    says(&refused.err, &["E0772", "`go.mcap` was built with `--set bead_radius=0.01um`"]);
    says(&refused.err, &["`--against lab.twz --set bead_radius=0.01um`"]);
    assert_eq!(refused.out, "");
    let repeated = ["verify", "go.mcap", "--against", "lab.twz", "--set", "bead_radius=0.01um"];
    says(&bench.run(&repeated).code(DONE).out, &["With", SETTING, "Matches", "with the settings above"]);
    let other = ["verify", "go.mcap", "--against", "lab.twz", "--set", "bead_radius=0.02um"];
    says(&bench.run(&other).code(REFUSED).err, &["E0772"]);
    bench.run(&["verify", "go.mcap", "--set", "bead_radius=0.01um"]).code(USAGE);
}

#[test]
fn a_setting_that_only_the_command_line_has_is_named() {
    let bench = Bench::new();
    bench.write("lab.twz", found("against-set.twz"));
    bench.run(&["build", "lab.twz"]).code(DONE);
    bench.run(&["verify", "go.mcap", "--against", "lab.twz"]).code(DONE);
    let other = ["verify", "go.mcap", "--against", "lab.twz", "--set", "bead_radius=0.02um"];
    says(&bench.run(&other).code(REFUSED).err, &["E0772", "was built without `--set bead_radius=0.02um`"]);
    // A setting equal to the program's own value changes no claim.
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
    let reported = bench.run(&["verify", "go.mcap", "--against", "a.twz"]).code(DONE).out;
    says(
        &reported,
        &[
            "Unchecked",
            "the planner's bounds, estimates, guarantees and remarks, and that the plan is optimal: recorded but not derived again",
        ],
    );
}

#[test]
fn plans_are_derived_again_where_that_is_asked_for() {
    let bench = built_with_a_small_bead();
    let replanned = bench.run(&["verify", "go.mcap", "--replan"]).code(DONE).out;
    says(&replanned, &["Replanned", "planning the program again gives this plan", "With", SETTING]);
    assert!(!replanned.contains("Unchecked"), "{replanned}");
    let json = bench.run(&["verify", "go.mcap", "--replan", "--format", "json"]).code(DONE).out;
    says(&json, &[r#""replanned":true"#, r#""optimal":true"#]);
    let json = bench.run(&["verify", "go.mcap", "--format", "json"]).code(DONE).out;
    says(&json, &[r#""replanned":false"#]);
    assert!(!json.contains("optimal"), "{json}");

    for (edit, place) in [
        (edit_of(|plan| (plan.bound, plan.optimal) = (0.0, false)), "`plans[0].bound`: 0.0 in the log"),
        (edit_of(|plan| plan.remarks.push(safe())), "`plans[0].remarks`"),
    ] {
        bench.write("edited.mcap", edit);
        bench.run(&["verify", "edited.mcap"]).code(DONE);
        let refused = bench.run(&["verify", "edited.mcap", "--replan"]).code(REFUSED).err;
        says(&refused, &["E0779", place]);
    }
}

fn safe() -> Remark {
    Remark { subject: "go".to_owned(), text: "guaranteed up to 90 deg/mm".to_owned() }
}

/// A log that is intact except for an edit to its plan record.
fn edit_of(edit: impl Fn(&mut PlanRecord)) -> Vec<u8> {
    let (mut sources, mut sink, options) = (Sources::default(), Sink::default(), Options::default());
    let program = ProgramSource { name: "a.twz", text: HONEST, library: &NoFiles, options: &options };
    let checked = check_program(&program, &mut sources, &mut sink).expect("no error");
    let claims = &checked.claims[0];
    let (_, mut schedule) = planned(claims, &sources, &mut sink, &mut |_, _, _| ()).expect("a plan");
    edit(&mut schedule.plans[0]);
    let Verdict::Accepted(edited) = verify_program(schedule, claims, &sources) else {
        panic!("no replay depends on what the planner says");
    };
    let files = vec![("a.twz".to_owned(), HONEST.to_owned())];
    let provenance = Provenance { files, settings: Vec::new(), is_recorded: false };
    emit(Format::Mcap, &edited, &provenance).expect("a log").remove(0).bytes
}

#[cfg(unix)]
#[test]
fn a_name_forges_no_line_and_commands_no_terminal() {
    let bench = Bench::new();
    let name = "t.twz\n  Matches  fetch.twz  the log does what this program claims\x1b]0;x\x07\u{202e}";
    let program = "use std.dimibot\nuse std.instruments\ndevice bot : dimibot.femto_st\ninstrument card : instruments.ni_usb_6343\n\
                   task go on bot { move to (1, 1) }\nwiring bot { bl0.set -> card.port0.line0 { switches: 20 V } }\nlet a = 1\n";
    bench.write(name, program);
    let built = bench.run(&["build", name, "--emit", "mcap,csv,vcd,pwl,nidaqmx"]).code(DONE);
    let verified = bench.run(&["verify", "go.mcap"]).code(DONE);
    let no_task = bench.run(&["build", name, "--task", "x\n\x1b[2J"]).code(1);
    for text in [built.out, built.err, verified.out, no_task.err] {
        assert!(!text.lines().any(|line| line.trim_start().starts_with("Matches")), "{text}");
        assert!(!text.contains(['\x1b', '\x07', '\u{202e}']), "{text:?}");
    }
    for file in ["go.csv", "go.vcd", "go.pwl.inc", "go.cir", "go.card.daq", "go.nidaqmx.py"] {
        let bytes = std::fs::read(bench.path(file)).expect("it was written");
        let text = String::from_utf8_lossy(&bytes);
        assert!(!text.contains(['\x1b', '\x07', '\u{202e}']), "{file}: {text:?}");
        assert!(!text.lines().any(|line| line.trim_start().starts_with("Matches")), "{file}: {text}");
    }
}

const HONEST: &str = "use std.dimibot\ndevice bot : dimibot.femto_st\ntask go on bot { move to (1, 1) }\n";

/// A sound log that carries another program and other settings.
fn carrying(text: &str, settings: &[&str]) -> Vec<u8> {
    let (mut sources, mut sink, options) = (Sources::default(), Sink::default(), Options::default());
    let program = ProgramSource { name: "a.twz", text: HONEST, library: &NoFiles, options: &options };
    let CompileOutcome::Compiled(compiled) = compile(&program, &mut sources, &mut sink, &mut ()) else {
        panic!("{:?}", sink.sorted())
    };
    let files = vec![("a.twz".to_owned(), text.to_owned())];
    let provenance =
        Provenance { files, settings: settings.iter().map(|text| (*text).to_owned()).collect(), is_recorded: false };
    let mut set = emit(Format::Mcap, &compiled.schedules[0], &provenance).expect("a log");
    set.remove(0).bytes
}

#[test]
fn a_hostile_program_in_a_log_does_no_harm() {
    for (name, code) in
        [("oom-strings.twz", "E0313"), ("panic-too-deep.twz", "E0120"), ("panic-too-deep-string.twz", "E0120")]
    {
        let bench = Bench::new();
        bench.write("go.mcap", carrying(&found(name), &[]));
        let refused = bench.run_in_mib(700, &["verify", "go.mcap"]).code(REFUSED);
        says(&refused.err, &["E0743", code]);
    }
    let bench = Bench::new();
    let lists = found("hang-list-equality.twz").replace("s12 == s12", "s12 == [s11, s11]").replace("let q", "let r");
    bench.write("go.mcap", carrying(&lists, &[&format!("s0=\"{}\"", "x".repeat(100_000))]));
    bench.run_in_mib(700, &["verify", "go.mcap"]).code(REFUSED);
}

#[test]
fn what_is_built_can_be_verified_however_deep_it_is_nested() {
    for name in ["unverifiable-programs-63.twz", "unverifiable-together-40.twz"] {
        let bench = Bench::new();
        bench.write("a.twz", found(name));
        bench.run(&["build", "a.twz"]).code(DONE);
        bench.run(&["verify", "p0.mcap", "--against", "a.twz"]).code(DONE);
    }
}

/// Programs that run one another in parallel with a wait.
fn groups(deep: usize) -> String {
    let mut text = "use std.dimibot\ndevice bot : dimibot.femto_st\ntask go on bot { move to (1, 1) }\n".to_owned();
    for level in 0..deep {
        let inner = if level + 1 == deep { "go".to_owned() } else { format!("p{}", level + 1) };
        let block = format!("  wait 1 ms\n  together {{\n    run {inner}\n    wait 1 ms\n  }}\n");
        text.push_str(&format!("program p{level} {{\n{block}}}\n"));
    }
    text
}

#[test]
fn groups_deeper_than_a_log_can_hold_are_refused_by_the_checker() {
    let bench = Bench::new();
    bench.write("a.twz", groups(40)).write("b.twz", groups(28));
    says(&bench.run(&["build", "a.twz"]).code(1).err, &["E0207", "groups of runs are nested more than 60 deep"]);
    bench.run(&["build", "b.twz"]).code(DONE);
    bench.run(&["verify", "p0.mcap", "--against", "b.twz"]).code(DONE);
}

/// Names that take little space in the file but much memory.
#[test]
fn a_log_of_very_many_columns_does_not_fill_the_memory() {
    let columns: std::collections::BTreeMap<String, String> =
        (0..2_000_000).map(|column| (format!("v[{column}]"), String::new())).collect();
    let options = mcap::WriteOptions::new().profile("").compression(Some(mcap::Compression::Zstd));
    let mut writer = options.create(std::io::Cursor::new(Vec::new())).expect("a log");
    let schema = writer.add_schema("x.X", "protobuf", &[]).expect("a schema");
    writer.add_channel(schema, "/x/voltages", "protobuf", &columns).expect("a topic");
    writer.finish().expect("a log");
    let bench = Bench::new();
    bench.write("go.mcap", writer.into_inner().into_inner());
    let refused = bench.run_in_mib(700, &["verify", "go.mcap"]).code(super::bench::FILES);
    says(&refused.err, &["E0843", "the sum of the definitions"]);
}
