//! The rules of the language: just inside passes, just outside fails with exactly that code.

use super::imports::{self, FileFault, Library};
use super::{Checked, Options, check};
use crate::claims::Timeline;
use crate::diagnostic::Sink;
use crate::source::Sources;

const HEAD: &str = "use std.dimibot\ndevice bot : dimibot.femto_st { left: 5, right: 5 }\n";
const GO: &str = "task fetch on bot { move to (19, 28) }\n";

struct Shelf<'a>(&'a [(&'a str, &'a str)]);

impl Library for Shelf<'_> {
    fn read(&self, _from: &str, path: &str) -> Result<(String, String), FileFault> {
        let found = self.0.iter().find(|(name, _)| *name == path);
        found.map(|(name, text)| ((*name).to_owned(), (*text).to_owned())).ok_or("there is none".into())
    }
}

fn checked(text: &str, files: &[(&str, &str)], options: &Options) -> (Option<Checked>, Vec<String>) {
    let (mut sources, mut sink) = (Sources::default(), Sink::default());
    let modules = imports::load(&mut sources, "main.twz", text, &Shelf(files), &mut sink);
    let checked = check(&mut sources, &modules, options, &mut sink);
    let codes = sink.sorted().iter().map(|diagnostic| diagnostic.code.to_string()).collect();
    (checked, codes)
}

fn codes(text: &str) -> Vec<String> {
    checked(text, &[], &Options::default()).1
}

fn bot(text: &str) -> Vec<String> {
    codes(&format!("{HEAD}{text}"))
}

fn assert_codes(text: &str, expected: &[&str]) {
    assert_eq!(bot(text), expected, "{text}");
}

#[test]
fn a_name_is_declared_once_whatever_it_names() {
    assert_codes(
        "scene s { for i in 0..2 { obstacle d[i] at (i + 4, 4) } }\ntask t on bot in s { move to (1, 1) }",
        &[],
    );
    for text in [
        "let bot = 3\ntask t on bot { move to (1, 1) }",
        "let i = 3\nscene s { for i in 0..2 { obstacle d[i] at (i + 4, 4) } }\ntask t on bot in s { move to (i, 1) }",
        "scene s { obstacle i at (4, 4), for i in 0..2 { obstacle d[i] at (i + 4, 4) } }\ntask t on bot in s { move to (1, 1) }",
        "scene s { obstacle bot at (4, 4) }\ntask t on bot in s { move to (1, 1) }",
        "let d1 = 3\nscene s { for i in 0..2 { obstacle d[i] at (i + 4, 4) } }\ntask t on bot in s { move to (d1, 1) }",
        "task t(bot: cell) on bot { move to (1, 1) }\nprogram p { run t((1, 1)) }",
        "task t(a: number, a: number) on bot { move to (a, 1) }\nprogram p { run t(1, 2) }",
        "task t on bot { for i in 0..2 { for i in 0..2 { move to (i, 1) } } }",
    ] {
        assert_codes(text, &["E0202"]);
    }
}

#[test]
fn kinds_shapes_functions_and_outcomes_keep_their_names() {
    for name in ["dimibot2", "discs", "counts", "times"] {
        assert_codes(&format!("let {name} = 3\ntask t on bot {{ move to ({name}, 1) }}"), &[]);
    }
    for name in ["disc", "count", "time"] {
        assert_codes(&format!("let {name} = 3\ntask t on bot {{ move to (1, 1) }}"), &["E0203"]);
        assert_codes(
            &format!("task t({name}: number) on bot {{ move to (1, 1) }}\nprogram p {{ run t(1) }}"),
            &["E0203"],
        );
        assert_codes(
            &format!("scene s {{ obstacle {name} at (4, 4) }}\ntask t on bot in s {{ move to (1, 1) }}"),
            &["E0203"],
        );
    }
}

#[test]
fn indices_are_whole_and_within_the_list() {
    for (index, expected) in
        [("0", ""), ("1", ""), ("2", "E0306"), ("-1", "E0306"), ("0.5", "E0306"), ("1 um", "E0306")]
    {
        let text = format!("let spots = [(1, 2), (3, 4)]\ntask t on bot {{ move to spots[{index}] }}");
        assert_eq!(bot(&text).concat(), expected, "{index}");
    }
}

#[test]
fn a_for_takes_elements_and_counts_them() {
    let text = "let spots = [(1, 2), (3, 4)]\ntask t on bot { for i, p in spots { move to p + (i, i) } }";
    assert_codes(text, &[]);
    assert_codes("task t on bot { for i in 3 { move to (i, 1) } }", &["E0304"]);
    assert_codes("task t on bot { for i in 0..2.5 { move to (i, 1) } }", &["E0304"]);
}

#[test]
fn a_table_takes_the_unit_of_its_header() {
    let table = |cell: &str| {
        let table = format!("let t = table {{\n  name | place [um]\n  a | {cell}\n}}\n");
        format!("{table}let rows = count(t)\ntask go on bot {{ move to (rows, 1) }}")
    };
    for cell in ["3", "-3", "3 nm", "2 um + 1 um"] {
        assert_codes(&table(cell), &[]);
    }
    for cell in ["3 V", "(3, 4)"] {
        let reported = bot(&table(cell));
        assert!(
            reported.iter().all(|code| code == "E0301") && (cell != "3 V" || reported.len() == 1),
            "{cell}: {reported:?}"
        );
    }
}

#[test]
fn chains_of_values_may_be_as_long_as_the_file_in_any_order() {
    let count = 10_000;
    let lets: String = (0..count).map(|i| format!("let a{i} = a{} + 1\n", i + 1)).collect();
    let text = format!("{lets}let a{count} = 0\ntask t on bot {{ move to (a0 / 1000, 1) }}");
    assert_codes(&text, &[]);
    let circle = format!("{lets}let a{count} = a0\ntask t on bot {{ move to (1, 1) }}");
    assert_codes(&circle, &["E0207"]);
}

#[test]
fn chains_of_devices_may_be_as_long_as_the_file() {
    let bases: String = (0..3_000).map(|i| format!("device d{i} : d{} {{ left: 5 }}\n", i + 1)).collect();
    let text = format!("{bases}device d3000 : dimibot.femto_st {{ right: 5 }}\ntask t on d0 {{ move to (1, 1) }}");
    assert_eq!(bot(&format!("{text}\ntask u on bot {{ move to (1, 1) }}")), Vec::<String>::new());
    let circle = format!("{bases}device d3000 : d0 {{ right: 5 }}\ntask t on bot {{ move to (1, 1) }}");
    assert_codes(&circle, &["E0207"]);
}

#[test]
fn scenes_stand_on_one_another_up_to_a_limit() {
    let chain = |length: usize| {
        let bases: String = (0..length).map(|i| format!("scene s{i} : s{} {{ }}\n", i + 1)).collect();
        format!("{bases}scene s{length} {{ obstacle d at (4, 4) }}\ntask t on bot in s0 {{ move to (1, 1) }}")
    };
    assert_codes(&chain(super::scenes::MAX_BASES), &[]);
    assert_codes(&chain(super::scenes::MAX_BASES + 1), &["E0207"]);
    assert_codes(&chain(3_000), &["E0207"]);
}

#[test]
fn an_object_replaces_the_one_of_its_base() {
    let scenes = |own: &str| format!("scene a {{ obstacle d at (1, 1) }}\nscene b : a {{ obstacle d at {own} }}\n");
    assert_codes(&format!("{}task t on bot in b {{ move to (1, 1) }}", scenes("(2, 2)")), &[]);
    assert_codes(&format!("{}task t on bot in b {{ move to (1, 1) }}", scenes("(1, 1)")), &["E0502"]);
}

#[test]
fn a_scene_is_judged_with_each_device_that_meets_it() {
    let text = "device wide : dimibot.femto_st { left: 6, right: 5 }\nscene s { obstacle d at (40, 4) }\n\
                task a on bot in s { move to (1, 1) }\ntask b on wide in s { move to (1, 1) }";
    assert_codes(text, &["W0501"]);
}

#[test]
fn a_program_that_runs_itself_is_said_once() {
    assert_codes(&format!("{GO}program a {{ run fetch, run b }}\nprogram b {{ run a }}"), &["E0207"]);
}

#[test]
fn programs_that_double_each_other_end_at_the_limit() {
    let programs: String = (0..60).map(|i| format!("program p{i} {{ run p{}, run p{} }}\n", i + 1, i + 1)).collect();
    let reported = bot(&format!("{GO}{programs}program p60 {{ wait 1 ms }}"));
    assert!(!reported.is_empty() && reported.iter().all(|code| code == "E0512" || code == "W0502"), "{reported:?}");
}

#[test]
fn runs_up_to_the_limit_pass() {
    let runs = |count: usize| format!("{GO}program p {{ for i in 0..{count} {{ run fetch }} }}");
    assert_codes(&runs(super::programs::MAX_RUNS), &[]);
    assert_codes(&runs(super::programs::MAX_RUNS + 1), &["E0512"]);
}

#[test]
fn arguments_are_of_the_sort_that_is_declared() {
    let run = |sort: &str, value: &str| {
        format!("task t(a: {sort}) on bot {{ move to (1, 1) }}\nprogram p {{ run t({value}) }}")
    };
    for (sort, value) in
        [("length", "1 um"), ("cell", "(1, 2)"), ("place", "(1 um, 2 um)"), ("word", "0b1_1"), ("number", "2")]
    {
        assert_codes(&run(sort, value), &[]);
    }
    assert_codes(&run("length", "1"), &["E0301"]);
    assert_codes(&run("cell", "(1 um, 2 um)"), &["E0304"]);
    assert_codes(&run("lenght", "1 um"), &["E0511"]);
    assert_codes("task t(a: cell) on bot { move to a }\nprogram p { run t }", &["E0511"]);
}

#[test]
fn what_is_never_run_is_checked_all_the_same() {
    assert_codes("task t(a: cell) on bot { mvoe to a }", &["E0208"]);
    assert_codes(&format!("{GO}program p(n: number) {{ run ftech, wait 1 V }}"), &["E0201", "E0301"]);
    assert_codes("task t(a: cell) on bot { move to a }", &["W0502"]);
}

#[test]
fn a_task_picked_by_name_is_built_alone_and_warns_of_no_other() {
    let text = format!("{HEAD}{GO}task back on bot {{ move to (0, 0) }}");
    let options = Options { settings: Vec::new(), only: Some("back".to_owned()) };
    let (checked, codes) = checked(&text, &[], &options);
    assert!(codes.is_empty(), "{codes:?}");
    let names: Vec<String> = checked.into_iter().flat_map(|c| c.claims).map(|claims| claims.name).collect();
    assert_eq!(names, ["back"]);
}

#[test]
fn settings_replace_values_of_the_own_and_of_used_files() {
    let text = format!("use \"lab.twz\" as lab\n{HEAD}let x = 1\ntask t on bot {{ move to (x, lab.y) }}");
    let with = |setting: &str| {
        let options = Options { settings: vec![setting.to_owned()], only: None };
        checked(&text, &[("lab.twz", "let y = 2\n")], &options).1
    };
    assert!(with("x=3").is_empty() && with("lab.y=31").is_empty());
    assert_eq!(with("lab.y=32"), ["E0501"]);
    for setting in ["x=3um", "z=3", "lab.z=1", "x"] {
        assert_eq!(with(setting), ["E0309"], "{setting}");
    }
}

/// A file that is there needs no advice about its folder.
#[test]
fn a_file_that_is_no_text_is_to_be_saved_as_one() {
    struct Wide;
    impl Library for Wide {
        fn read(&self, _from: &str, path: &str) -> Result<(String, String), FileFault> {
            Err(match path {
                "wide.twz" => FileFault::NotText("`wide.twz` is not UTF-8 at byte 0, in line 1".to_owned()),
                _ => "there is none".into(),
            })
        }
    }
    let help = |text: &str| {
        let (mut sources, mut sink) = (Sources::default(), Sink::default());
        imports::load(&mut sources, "main.twz", text, &Wide, &mut sink);
        sink.sorted().first().and_then(|diagnostic| diagnostic.help.clone()).unwrap_or_default()
    };
    assert!(help("use \"wide.twz\"\n").contains("UTF-8"));
    assert!(help("use \"other.twz\"\n").contains("folder"));
}

#[test]
fn a_file_that_cannot_be_used_is_said_once() {
    let text = format!("use \"lab.twz\" as lab\n{HEAD}task t on bot in lab.s {{ move to lab.y }}");
    assert_eq!(codes(&text), ["E0204"]);
    let name = format!("use \"my-lab.twz\"\n{HEAD}{GO}");
    assert_eq!(checked(&name, &[("my-lab.twz", "let y = 2\n")], &Options::default()).1, ["E0110"]);
}

#[test]
fn a_repeated_mistake_is_said_once() {
    assert_codes("task t on bot { for i in 40..60 { move to (i, 1) } }", &["E0501"]);
    assert_codes("let far = (40, 1)\ntask t on bot { move to far, move to far }", &["E0501", "E0501"]);
}

#[test]
fn warnings_of_unused_names_wait_until_there_is_no_error() {
    assert_codes(&format!("let spare = 3\n{GO}"), &["W0201"]);
    assert_codes("let spare = 3\ntask t on bot { mvoe to (spare, 1) }", &["E0208"]);
}

/// The clock counts whole nanoseconds, and loses none.
#[test]
fn times_are_rounded_to_nanoseconds_and_no_further() {
    for (written, expected_ns) in [
        ("1 ns", 1),
        ("23 ns", 23),
        ("2.6 ns", 3),
        ("1.001 us", 1001),
        ("1.000001 ms", 1_000_001),
        ("1 s", 1_000_000_000),
    ] {
        let text = format!("{HEAD}{GO}program p {{ run fetch, wait {written} }}");
        let (checked, codes) = checked(&text, &[], &Options::default());
        let claims = &checked.unwrap_or_else(|| panic!("{codes:?}")).claims[0];
        let Timeline::Sequence(parts) = &claims.timeline else { panic!("a run and a wait: {:?}", claims.timeline) };
        assert_eq!(parts[1], Timeline::Wait(expected_ns), "{written}");
    }
}
