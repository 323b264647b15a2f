//! Runs cases in a separate process, which may die or hang.
//!
//! Each line of standard input is the number of a case; each line of the output is its result: `fine`, with the numbers
//! of texts parsed, checked, built, verified and refused, or `fault` with a description. A line before it says which
//! task of a program is being planned.

use super::generate;
use super::judge::{self, Built};
use super::logs::{self, Parts};
use super::mutate;
use super::numbers::{self, MAGNITUDES};
use super::random::Random;
use super::seeds;
use super::{Attack, Run};
use std::io::{BufRead, Write};
use std::panic::{self, AssertUnwindSafe};
use std::sync::{Mutex, OnceLock};

/// Number of texts and maps that one case parses, checks or alters, so that a case is worth its message.
const PARSED_AT_ONCE: u64 = 200;
const CHECKED_AT_ONCE: u64 = 20;
const ALTERED_AT_ONCE: u64 = 20;

/// Stack size of the compiler's own command line, in bytes.
const STACK_BYTES: usize = 64 * 1024 * 1024;

/// Counts of outcomes.
#[derive(Debug, Clone, Copy, Default)]
pub struct Tally {
    pub parsed: u64,
    pub checked: u64,
    pub built: u64,
    pub verified: u64,
    pub altered: u64,
    /// Number of altered logs that still verify.
    pub accepted: u64,
}

impl Tally {
    pub fn add(&mut self, other: Tally) {
        self.parsed += other.parsed;
        self.checked += other.checked;
        self.built += other.built;
        self.verified += other.verified;
        self.altered += other.altered;
        self.accepted += other.accepted;
    }

    fn numbers(&mut self) -> [&mut u64; 6] {
        [
            &mut self.parsed, &mut self.checked, &mut self.built, &mut self.verified, &mut self.altered,
            &mut self.accepted,
        ]
    }

    /// The counts as one line.
    fn line(mut self) -> String {
        self.numbers().map(|number| number.to_string()).join(" ")
    }

    /// Parses such a line.
    pub fn read(line: &str) -> Tally {
        let mut tally = Tally::default();
        for (number, word) in tally.numbers().into_iter().zip(line.split(' ')) {
            *number = word.parse().unwrap_or(0);
        }
        tally
    }
}

/// Inputs that cases are made of, prepared once.
struct Stock {
    texts: Vec<String>,
    complete: Vec<String>,
    /// For each map format, a file name and the maps in that format.
    maps: Vec<(&'static str, Vec<String>)>,
    /// Every case of the sweep: program, range of a number, factor.
    sweep: Vec<(usize, std::ops::Range<usize>, f64)>,
}

fn stock() -> &'static Stock {
    static STOCK: OnceLock<Stock> = OnceLock::new();
    STOCK.get_or_init(|| {
        let (texts, complete) = (seeds::all(), seeds::complete());
        let mut sweep = Vec::new();
        for (index, text) in complete.iter().enumerate() {
            for place in numbers::places(text) {
                sweep.extend(MAGNITUDES.map(|factor| (index, place.clone(), factor)));
            }
        }
        let maps = ["board.json", "board.svg"].map(|name| (name, seeds::maps(name))).into();
        Stock { texts, complete, maps, sweep }
    })
}

/// The logs of the complete programs, unpacked.
fn good_logs() -> &'static [Parts] {
    static LOGS: OnceLock<Vec<Parts>> = OnceLock::new();
    LOGS.get_or_init(|| stock().complete.iter().filter_map(|text| Parts::of(judge::log_of(text)?)).collect())
}

/// Number of cases in the sweep.
pub fn sweep_cases() -> usize {
    stock().sweep.len()
}

fn random(run: &Run, case: u64) -> Random {
    let mut random =
        Random::new(run.seed.wrapping_mul(0x9E37_79B9_7F4A_7C15) ^ case.wrapping_mul(0xD134_2543_DE82_EF95));
    random.next();
    random
}

/// The text of a case that builds a single program.
fn program(run: &Run, case: u64) -> String {
    let mut random = random(run, case);
    let stock = stock();
    match Attack::of(run, case) {
        Attack::Sweep => {
            // A prime step, so that even a short run covers every program.
            let turn = if run.only.is_some() { case } else { case / Attack::ALL.len() as u64 };
            let at = (turn.wrapping_add(run.seed - 1).wrapping_mul(7919) % stock.sweep.len() as u64) as usize;
            let (program, place, factor) = &stock.sweep[at];
            numbers::scaled(&stock.complete[*program], place, *factor)
        }
        _ if random.below(4) == 0 => mutate::mutated(&mut random, &stock.complete),
        _ => generate::program(&mut random),
    }
}

/// The texts of a case that mutates.
fn texts(run: &Run, case: u64, count: u64) -> impl Iterator<Item = String> {
    let mut random = random(run, case);
    (0..count).map(move |_| match random.below(8) {
        0 => generate::program(&mut random),
        _ => mutate::mutated(&mut random, &stock().texts),
    })
}

/// The maps of a case, each with a file name.
fn maps(run: &Run, case: u64) -> impl Iterator<Item = (&'static str, String)> {
    let mut random = random(run, case);
    (0..CHECKED_AT_ONCE).map(move |_| {
        let (name, known) = &stock().maps[random.below(stock().maps.len() as u32) as usize];
        (*name, mutate::mutated(&mut random, known))
    })
}

/// The input of a case in readable form.
pub fn shown(run: &Run, case: u64) -> String {
    let many = |count| texts(run, case, count).collect::<Vec<_>>().join("\n// ---- next ----\n");
    match Attack::of(run, case) {
        Attack::Parse => many(PARSED_AT_ONCE),
        Attack::Check => many(CHECKED_AT_ONCE),
        Attack::Map => maps(run, case).map(|(_, map)| map).collect::<Vec<_>>().join("\n// ---- next ----\n"),
        Attack::Build | Attack::Sweep => program(run, case),
        Attack::Verify => format!("// altered logs: --seed {} --only verify, case {case}\n", run.seed),
    }
}

/// Prefix of the line that says which task of the current case is being planned; each task has its own time budget.
pub const TASK: &str = "task ";

/// The text being processed, for the fault's file.
static CURRENT: Mutex<String> = Mutex::new(String::new());

fn current(text: &str) {
    if let Ok(mut current) = CURRENT.lock() {
        text.clone_into(&mut current);
    }
}

fn carry_out(run: &Run, case: u64) -> Result<Tally, String> {
    let mut tally = Tally::default();
    match Attack::of(run, case) {
        Attack::Parse => {
            for text in texts(run, case, PARSED_AT_ONCE) {
                current(&text);
                judge::parse(&text);
                tally.parsed += 1;
            }
        }
        Attack::Check => {
            for text in texts(run, case, CHECKED_AT_ONCE) {
                current(&text);
                judge::check(&text, &[])?;
                tally.checked += 1;
            }
        }
        Attack::Map => {
            for (name, map) in maps(run, case) {
                current(&map);
                judge::check_map(name, &map)?;
                tally.checked += 1;
            }
        }
        Attack::Build | Attack::Sweep => {
            let text = program(run, case);
            current(&text);
            tally.built += 1;
            match judge::build(&text, &mut |task| println!("{TASK}{task}")) {
                Built::Fault(fault) => return Err(fault),
                Built::Verified => tally.verified += 1,
                Built::Errors(_) => {}
            }
        }
        Attack::Verify => {
            let mut random = random(run, case);
            for _ in 0..ALTERED_AT_ONCE {
                let logs = good_logs();
                let good = &logs[random.below(logs.len() as u32) as usize];
                let log = logs::altered(&mut random, good, &stock().texts);
                current(&format!("an altered log of {} bytes", log.len()));
                tally.altered += 1;
                tally.accepted += u64::from(judge::verify(&log).is_ok());
            }
        }
    }
    Ok(tally)
}

/// Processes case numbers until the input ends.
pub fn serve(run: &Run) {
    let run = run.clone();
    let work = move || {
        panic::set_hook(Box::new(|_| ()));
        // Prepared before the first case, so that no case is charged for it.
        let _ = (stock(), good_logs());
        println!("ready");
        for line in std::io::stdin().lock().lines().map_while(Result::ok) {
            let Ok(case) = line.trim().parse::<u64>() else { continue };
            let answer = one(&run, case);
            println!("{}", answer.replace(['\n', '\r'], " "));
            let _ = std::io::stdout().flush();
        }
    };
    let worker = std::thread::Builder::new().stack_size(STACK_BYTES).spawn(work);
    let _ = worker.map(std::thread::JoinHandle::join);
}

fn one(run: &Run, case: u64) -> String {
    static PLACE: Mutex<String> = Mutex::new(String::new());
    panic::set_hook(Box::new(|info| {
        let place = info.location().map_or_else(String::new, ToString::to_string);
        if let Ok(mut kept) = PLACE.lock() {
            *kept = place;
        }
    }));
    let result = panic::catch_unwind(AssertUnwindSafe(|| carry_out(run, case)));
    let fault = match result {
        Ok(Ok(tally)) => return format!("fine {}", tally.line()),
        Ok(Err(fault)) => fault,
        Err(thrown) => {
            let text = thrown.downcast_ref::<String>().cloned();
            let text =
                text.or_else(|| thrown.downcast_ref::<&str>().map(|text| (*text).to_owned())).unwrap_or_default();
            format!("panic at {}: {text}", PLACE.lock().map(|place| place.clone()).unwrap_or_default())
        }
    };
    let text = CURRENT.lock().map(|text| text.clone()).unwrap_or_default();
    super::watch::keep(run, case, &text);
    format!("fault {fault}")
}
