//! Parses and formats a generated program of 10,000 steps, checks a crowded scene, and renders reports on a large
//! file. Prints the median of several runs, in milliseconds.
//!
//! `cargo bench --bench check`. The text comes from a fixed seed. No public library does the same work.

use std::fmt::Write;
use std::time::Instant;
use tweeze::check::Options;
use tweeze::check::imports::NoFiles;
use tweeze::compile::{ProgramSource, check_program};
use tweeze::diagnostic::render::{Characters, Colour, Look, human};
use tweeze::diagnostic::{Code, Diagnostic, Sink};
use tweeze::random::SplitMix64;
use tweeze::source::{FileId, Sources, Span};

const STEPS: u32 = 10_000;
const RUNS: usize = 21;
const REPORTS: usize = 200;

fn main() {
    let text = program();
    let mut sink = Sink::default();
    let reading = median_ms(|| {
        let tree = tweeze::syntax::parse(FileId(0), &text, &mut sink);
        assert_eq!(tree.items.len(), 4);
    });
    let formatting = median_ms(|| {
        let formatted = tweeze::format::format(FileId(0), &text, &mut Sink::default());
        assert!(formatted.len() > text.len() / 2);
    });
    let checking = median_ms(|| {
        let (mut sources, mut sink, options) = (Sources::default(), Sink::default(), Options::default());
        let program = ProgramSource { name: "steps.twz", text: &text, library: &NoFiles, options: &options };
        assert!(check_program(&program, &mut sources, &mut sink).is_some(), "the program has no errors");
    });
    let crowded = crowded();
    let judging = median_ms(|| {
        let (mut sources, mut sink, options) = (Sources::default(), Sink::default(), Options::default());
        let program = ProgramSource { name: "crowd.twz", text: &crowded, library: &NoFiles, options: &options };
        check_program(&program, &mut sources, &mut sink);
    });
    let mut sources = Sources::default();
    sources.add("large.twz", "let x = 1 um + 2 um\n".repeat(500_000));
    let drawing = median_ms(|| report(&sources));
    let megabytes = text.len() as f64 / 1e6;
    println!("{STEPS} steps, 200 obstacles, {megabytes:.2} MB");
    println!("read             {reading:6.1} ms, {:.1} MB/s", megabytes / reading * 1e3);
    println!("read and formatted {formatting:4.1} ms, {:.1} ms of it beyond reading", formatting - reading);
    println!("read and checked {checking:6.1} ms, {:.1} MB/s", megabytes / checking * 1e3);
    println!("50,000 obstacles, {STEPS} steps on or beside them: read and checked {judging:6.1} ms");
    println!("{REPORTS} reports on a file of 10 MB: {drawing:6.1} ms");
}

/// Moves among 200 obstacle cells; no goal is an obstacle cell.
fn program() -> String {
    let mut text = "use std.dimibot\ndevice bot : dimibot.femto_st { left: 10, right: 10 }\n".to_owned();
    text.push_str("scene bench { for i in 0..200 { obstacle d[i] at (5*i, 3*i + 1) } }\ntask walk on bot in bench {\n  start at (2, 0)\n");
    let mut random = SplitMix64::new(1);
    for _ in 0..STEPS {
        let (x, y) = (random.below(1024), random.below(1024));
        let x = if x % 5 == 0 { x + 1 } else { x };
        writeln!(text, "  move to ({x}, {y})").expect("a string takes all");
    }
    text.push_str("}\n");
    text
}

/// The same number of steps among 50,000 discs; some goals are covered.
fn crowded() -> String {
    let mut text =
        "use std.dimibot\ndevice bot : dimibot.femto_st { left: 10, right: 10, repeatability: 1 nm }\n".to_owned();
    text.push_str("scene bench {\n");
    for i in 0..50_000 {
        let (x, y) = (1 + i % 223 / 20, 1 + i / 4600);
        writeln!(text, "  obstacle d{i} : disc {{ radius: 2 nm }} at ({x} um, {y} um)").expect("a string takes all");
    }
    text.push_str("}\ntask walk on bot in bench {\n");
    for i in 0..STEPS {
        writeln!(text, "  move to ({}, {})", i * 7 % 1000, i / 12 + 30).expect("a string takes all");
    }
    text.push_str("}\n");
    text
}

/// Renders reports at places all over a file.
fn report(sources: &Sources) {
    let look = Look { colour: Colour::Plain, characters: Characters::Unicode, width: 100 };
    for number in 0..REPORTS {
        let span = Span::new(FileId(0), number * 50_000, number * 50_000 + 3);
        let diagnostic = Diagnostic::new(Code::E0201, "a title").label(span, "");
        assert!(human(&diagnostic, sources, look).len() < 2_000);
    }
}

fn median_ms(mut work: impl FnMut()) -> f64 {
    let mut times: Vec<f64> = Vec::with_capacity(RUNS);
    for _ in 0..RUNS {
        let begin = Instant::now();
        work();
        times.push(begin.elapsed().as_secs_f64() * 1e3);
    }
    times.sort_by(f64::total_cmp);
    times[RUNS / 2]
}
