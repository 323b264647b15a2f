//! Hostile programs: whatever a text demands, the answer is a diagnostic, in short time and little memory.

use super::bench::{Bench, DONE, ERRORS, found, says};

#[test]
fn brackets_too_deep_that_end_lines_below_are_reported() {
    for name in ["panic-too-deep.twz", "panic-too-deep-string.twz"] {
        let bench = Bench::new();
        bench.write("a.twz", found(name));
        says(&bench.run(&["check", "a.twz"]).code(ERRORS).err, &["E0120", "nested more than 64 levels deep"]);
    }
}

/// Memory limit for any text, including the program itself and the stack of the working thread.
const MIB: u64 = 700;

fn check(text: &str) -> super::bench::Ended {
    let bench = Bench::new();
    bench.write("a.twz", text);
    bench.run_in_mib(MIB, &["check", "a.twz"])
}

#[test]
fn strings_that_grow_tenfold_have_an_end() {
    says(&check(&found("oom-strings.twz")).code(ERRORS).err, &["E0313", "more than 64 MiB of strings"]);
}

#[test]
fn strings_that_are_handed_on_count_each_time() {
    let mut text = format!("let a = \"{}\"\n", "x".repeat(1_000_000));
    text.push_str(&format!("let l = [{}]\n", "a, ".repeat(10_000) + "a"));
    says(&check(&text).code(ERRORS).err, &["E0313"]);
}

/// Lists of lists, ten wide.
fn lists(name: &str, deep: usize) -> String {
    let mut text = format!("let {name}0 = [1, 2, 3, 4, 5, 6, 7, 8, 9, 10]\n");
    for level in 1..=deep {
        let below = format!("{name}{}", level - 1);
        text.push_str(&format!("let {name}{level} = [{}]\n", vec![below; 10].join(", ")));
    }
    text
}

#[test]
fn comparing_lists_has_an_end() {
    // A list is compared with itself by identity; another one must be traversed.
    check(&found("hang-list-equality.twz")).code(DONE);
    let two = format!("{}{}let q = a12 == b12\n", lists("a", 12), lists("b", 12));
    says(&check(&two).code(ERRORS).err, &["E0314", "more than 50000000 evaluation steps"]);
}

#[test]
fn lists_are_equal_wherever_they_are_written() {
    let text = "use std.dimibot\nlet same = [1, [2, 3]] == [1, [2, 3]]\nlet other = [1, [2, 3]] != [1, [2, 4]]\n\
                let t = [same, other, 1 == 1]\ndevice b : dimibot.femto_st\ntask t1 on b { move to (1, 1) }\n";
    let bench = Bench::new();
    bench.write("a.twz", text.replace("let t = [same, other, 1 == 1]", "let t = [0][0]"));
    // `true` is not a number, so the message shows the value.
    bench.write("b.twz", format!("{text}let u = same == true\nlet v = other == true\nlet w = u == v\n"));
    bench.run(&["check", "b.twz"]).code(DONE);
}

#[test]
fn lists_in_lists_are_not_deeper_than_can_be_taken_apart() {
    let mut text = "let a0 = [1]\n".to_owned();
    (1..200_000).for_each(|level| text.push_str(&format!("let a{level} = [a{}]\n", level - 1)));
    says(&check(&text).code(ERRORS).err, &["E0207", "lists are nested more than 64 deep"]);
}

/// Times in the language are exact to the nanosecond in the schedule.
#[test]
fn a_wait_lasts_as_long_as_it_says() {
    let bench = Bench::new();
    let text = "use std.dimibot\ndevice bot : dimibot.femto_st\ntask go on bot { wait 1234567 ns }\n";
    bench.write("a.twz", text);
    bench.run(&["build", "a.twz", "--emit", "json"]).code(DONE);
    let schedule = std::fs::read_to_string(bench.path("go.json")).expect("written");
    says(&schedule, &["\"duration_ns\": 1234567"]);
}

#[test]
fn names_have_an_end() {
    let long = "n".repeat(5_000_000);
    let reported = check(&format!("let {long} = 1\n")).code(ERRORS).err;
    says(&reported, &["E0129", "a name of 5000000 bytes; the limit is 200"]);
    assert!(reported.len() < 10_000, "{} bytes", reported.len());
    let digits = check(&format!("let a = 1{long}\n")).code(ERRORS).err;
    assert!(digits.len() < 20_000, "{} bytes", digits.len());
}

#[test]
fn very_many_unknown_names_are_not_compared_with_all_others() {
    let text: String = (0..12_000).map(|n| format!("let known_name_{n} = unknown_name_{n}\n")).collect();
    says(&check(&text).code(ERRORS).err, &["E0201", "and 11"]);
}

#[test]
fn a_loop_that_works_out_a_long_expression_has_an_end() {
    let sum = "1 + ".repeat(200) + "1";
    let text = format!(
        "use std.dimibot\ndevice bot : dimibot.femto_st\ntask go on bot {{\n  for i in 0..1_000_000 {{ wait ({sum}) * 1 ms }}\n}}\n"
    );
    says(&check(&text).code(ERRORS).err, &["E0314"]);
}

/// A long experiment has a log: 129 bytes of text ask for 100,000 moves, each of one module.
#[cfg(target_os = "linux")]
#[test]
fn a_hundred_thousand_moves_have_a_log_in_little_memory() {
    let bench = Bench::new();
    let moves = "for i in 0..50000 { move to (1, 0)\n move to (0, 0) }";
    bench.write("long.twz", format!("use std.dimibot\ndevice bot : dimibot.femto_st\ntask go on bot {{ {moves} }}\n"));
    for arguments in [["build", "long.twz"], ["verify", "go.mcap"]] {
        let done = bench.run_in_mib(500, &arguments).code(DONE);
        says(&done.out, &["100000 actuations replayed, 0 violations"]);
    }
}
