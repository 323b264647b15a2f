//! Attacks the compiler with random programs, altered maps of boards and altered logs, each case under a watchdog.
//!
//! Six attacks take turns: texts are parsed; texts are checked and the reports drawn, and so are boards by altered maps; programs are built, written in every format, and
//! their logs read back and verified; every number of published devices is swept over magnitudes; logs are altered, their checksums
//! corrected, and verified. Must never happen: a panic, a case of more than [`watch::CPU_LIMIT_S`] of processor time for each of its
//! tasks, or of 1 GB of memory, a fresh plan that the verifier refuses, a log of Tweeze's own that does not verify.
//!
//! `cargo test --test fuzz -- [--seed N] [--seconds N | --cases N] [--jobs N] [--only parse|check|map|build|sweep|verify]`; faults are
//! written to `tmp/fuzz` of the target folder. `-- --show N` prints a case, `-- --file PATH` runs one program.

mod generate;
mod judge;
mod logs;
mod mutate;
mod numbers;
#[path = "../support/random.rs"]
mod random;
mod seeds;
mod watch;
mod worker;

use std::process::ExitCode;
use std::thread::available_parallelism;

/// What a run is asked for.
#[derive(Debug, Clone)]
pub struct Run {
    pub seed: u64,
    /// The first case: a long run can go on where another was stopped.
    pub from: u64,
    /// The number of cases, unless the time ends it before.
    pub cases: u64,
    /// After so long no new case is begun.
    pub seconds: Option<u64>,
    /// Workers at the same time; one for each core unless it is said.
    pub jobs: u64,
    pub only: Option<Attack>,
}

/// What is done with a case.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Attack {
    /// A batch of texts through the parser.
    Parse,
    /// A batch of texts through the checker and its reports.
    Check,
    /// A batch of altered maps of boards through the checker of a program that names them.
    Map,
    /// A random program through everything.
    Build,
    /// A program with one number at another magnitude through everything.
    Sweep,
    /// A batch of altered logs through the verifier.
    Verify,
}

impl Attack {
    pub const ALL: [Attack; 6] =
        [Attack::Parse, Attack::Check, Attack::Map, Attack::Build, Attack::Sweep, Attack::Verify];

    pub fn name(self) -> &'static str {
        match self {
            Attack::Parse => "parse",
            Attack::Check => "check",
            Attack::Map => "map",
            Attack::Build => "build",
            Attack::Sweep => "sweep",
            Attack::Verify => "verify",
        }
    }

    /// The attack of a case, by turns.
    pub fn of(run: &Run, case: u64) -> Attack {
        run.only.unwrap_or(Attack::ALL[(case % Attack::ALL.len() as u64) as usize])
    }
}

fn main() -> ExitCode {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let value = |name: &str| {
        let at = arguments.iter().position(|argument| argument == name)?;
        arguments.get(at + 1).cloned()
    };
    let number = |name: &str| value(name).and_then(|value| value.parse::<u64>().ok());
    let run = Run {
        seed: number("--seed").unwrap_or(1),
        from: number("--from").unwrap_or(0),
        cases: number("--cases").unwrap_or(if value("--seconds").is_some() { u64::MAX } else { 100 }),
        seconds: number("--seconds"),
        jobs: number("--jobs").unwrap_or_else(|| available_parallelism().map_or(1, |count| count.get() as u64)).max(1),
        only: value("--only").and_then(|name| Attack::ALL.into_iter().find(|attack| attack.name() == name)),
    };
    if let Some(case) = number("--show") {
        println!("{}", worker::shown(&run, case));
        return ExitCode::SUCCESS;
    }
    if let Some(path) = value("--file") {
        let text = std::fs::read_to_string(&path).unwrap_or_default();
        println!("{:?}", judge::build(&text, &mut |_| ()));
        return ExitCode::SUCCESS;
    }
    if arguments.iter().any(|argument| argument == "--worker") {
        worker::serve(&run);
        return ExitCode::SUCCESS;
    }
    if seeds::all().is_empty() {
        eprintln!("fuzz: no programs to begin with: run it in the checkout in which it was built");
        return ExitCode::FAILURE;
    }
    watch::run(&run)
}
