//! Attacks the compiler with random programs, altered board maps and altered logs, each case under a watchdog.
//!
//! Six attacks take turns: texts are parsed; texts are checked and the reports drawn; boards with altered maps are
//! checked; programs are built, written in every format, and their logs read back and verified; every number of
//! published devices is swept over magnitudes; logs are altered, their checksums corrected, and verified. Faults are: a
//! panic, a case that takes more than [`watch::CPU_LIMIT_S`] of processor time for each of its tasks or more than 1 GB
//! of memory, a fresh plan that the verifier refuses, and a log of Tweeze's own that does not verify.
//!
//! Usage:
//! `cargo test --test fuzz -- [--seed N] [--seconds N | --cases N] [--jobs N] [--only parse|check|map|build|sweep|verify]`.
//! Faults are written to `tmp/fuzz` of the target folder. `-- --show N` prints a case, `-- --file PATH` runs one program.

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

/// Arguments of a run.
#[derive(Debug, Clone)]
pub struct Run {
    pub seed: u64,
    /// The first case, so that a long run can be continued where another one was stopped.
    pub from: u64,
    /// Number of cases, unless the time is up first.
    pub cases: u64,
    /// Time after which no new case is begun, in seconds.
    pub seconds: Option<u64>,
    /// Number of parallel workers; one per core by default.
    pub jobs: u64,
    pub only: Option<Attack>,
}

/// Attack that a case makes.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Attack {
    /// Parses a batch of texts.
    Parse,
    /// Checks a batch of texts and draws the reports.
    Check,
    /// Checks a program with each of a batch of altered board maps.
    Map,
    /// Runs a random program through all stages.
    Build,
    /// Runs a program with one number at another magnitude through all stages.
    Sweep,
    /// Verifies a batch of altered logs.
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

    /// The attack of a case; attacks take turns.
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
