//! Hands cases to workers and watches them: a worker that dies, or takes too much time or memory, has found a fault.

use super::worker::{self, Tally};
use super::{Attack, Run};
use std::collections::BTreeMap;
use std::io::{BufRead, BufReader, Write};
use std::path::PathBuf;
use std::process::{Child, ChildStdin, Command, ExitCode, Stdio};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, RecvTimeoutError, channel};
use std::sync::{Arc, Mutex};
use std::thread;
use std::time::Duration;

/// Greatest processor time of a case, in seconds for each of its tasks. Hands with fine steps take longest, with tables
/// for two revolutions.
pub const CPU_LIMIT_S: u64 = 25;

/// Greatest wall-clock time in seconds, for a worker that hangs and for systems that do not report processor time. It
/// is generous, because a worker may have to wait for the processor.
const WALL_LIMIT_S: u64 = 60 * CPU_LIMIT_S;

/// Greatest address space of a worker, in kilobytes: 1 GB plus its code, stack and stock of inputs.
const MEMORY_LIMIT_KB: u64 = 1_250_000;

/// Polling interval.
const LOOK: Duration = Duration::from_millis(200);

/// A worker with its pipes.
struct Worker {
    child: Child,
    input: ChildStdin,
    answers: Receiver<String>,
}

impl Worker {
    fn start(run: &Run) -> Worker {
        let own = std::env::current_exe().expect("the program has a file");
        let limit = format!("ulimit -v {MEMORY_LIMIT_KB} 2>/dev/null; exec \"$0\" \"$@\"");
        let mut command = match cfg!(unix) {
            true => {
                let mut shell = Command::new("sh");
                shell.arg("-c").arg(limit).arg(own);
                shell
            }
            false => Command::new(own),
        };
        command.args(["--worker", "--seed", &run.seed.to_string()]);
        if let Some(attack) = run.only {
            command.args(["--only", attack.name()]);
        }
        // A single malloc arena, because the address space of each arena counts as memory.
        command.env("MALLOC_ARENA_MAX", "1").stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::null());
        let mut child = command.spawn().expect("a worker starts");
        let input = child.stdin.take().expect("it has an input");
        let output = child.stdout.take().expect("it has an output");
        let (sender, answers) = channel();
        thread::spawn(move || {
            for line in BufReader::new(output).lines().map_while(Result::ok) {
                if sender.send(line).is_err() {
                    break;
                }
            }
        });
        let worker = Worker { child, input, answers };
        // Preparing its inputs is not part of a case.
        let _ = worker.answers.recv_timeout(Duration::from_secs(600));
        worker
    }

    /// Runs a case; the error is what became of the worker.
    fn ask(&mut self, case: u64) -> Result<String, String> {
        let before_s = self.used_s();
        if writeln!(self.input, "{case}").is_err() {
            return Err("the worker was gone".to_owned());
        }
        let looks = WALL_LIMIT_S * 1000 / LOOK.as_millis() as u64;
        let (mut tasks, mut looked) = (1, 0);
        while looked < looks * tasks {
            match self.answers.recv_timeout(LOOK) {
                Ok(answer) => match answer.strip_prefix(worker::TASK) {
                    Some(number) => tasks = number.parse().unwrap_or(1),
                    None => return Ok(answer),
                },
                Err(RecvTimeoutError::Disconnected) => {
                    let status = self.child.wait().map_or_else(|error| error.to_string(), |status| status.to_string());
                    return Err(format!("died or out of memory: {status}"));
                }
                Err(RecvTimeoutError::Timeout) => {
                    looked += 1;
                    let limit_s = CPU_LIMIT_S * tasks;
                    if self.used_s().zip(before_s).is_some_and(|(now, before)| now - before > limit_s as f64) {
                        return Err(format!("more than {limit_s} s of processor time for {tasks} tasks"));
                    }
                }
            }
        }
        Err(format!("no answer in {} s", WALL_LIMIT_S * tasks))
    }

    /// Processor time that a worker has used, if the system reports it.
    fn used_s(&self) -> Option<f64> {
        let text = std::fs::read_to_string(format!("/proc/{}/stat", self.child.id())).ok()?;
        let (_, after_name) = text.rsplit_once(')')?;
        let mut fields = after_name.split_whitespace().skip(11);
        let ticks = fields.next()?.parse::<u64>().ok()? + fields.next()?.parse::<u64>().ok()?;
        Some(ticks as f64 / 100.0)
    }

    fn stop(mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

/// Results of all workers.
#[derive(Default)]
struct Found {
    tally: Tally,
    cases: u64,
    /// For each fault, without its numbers: how often it occurred, the first case, and the message.
    faults: BTreeMap<String, (u64, u64, String)>,
}

/// Writes a case to `tmp/fuzz` of the target folder.
pub fn keep(run: &Run, case: u64, text: &str) {
    let folder = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join("fuzz");
    let name = format!("{}-{}-{case}.twz", run.seed, Attack::of(run, case).name());
    let _ = std::fs::create_dir_all(&folder).and_then(|()| std::fs::write(folder.join(name), text));
}

fn without_numbers(fault: &str) -> String {
    let text: String = fault.chars().map(|c| if c.is_ascii_digit() { '#' } else { c }).collect();
    let mut short = text;
    while short.contains("##") {
        short = short.replace("##", "#");
    }
    short.chars().take(90).collect()
}

/// One job: every n-th case, until the cases or the time are used up.
fn job(run: &Run, first: u64, is_over: &AtomicBool, found: &Mutex<Found>) {
    let mut worker = Worker::start(run);
    let (mut case, end) = (run.from.saturating_add(first), run.from.saturating_add(run.cases));
    while case < end && !is_over.load(Ordering::Relaxed) {
        let answer = worker.ask(case);
        let fault = match &answer {
            Ok(line) => line.strip_prefix("fault ").map(str::to_owned),
            Err(what) => Some(what.clone()),
        };
        if answer.is_err() {
            keep(run, case, &worker::shown(run, case));
            worker.stop();
            worker = Worker::start(run);
        }
        if let Ok(mut found) = found.lock() {
            found.cases += 1;
            if let Some(line) = answer.as_ref().ok().and_then(|line| line.strip_prefix("fine ")) {
                found.tally.add(Tally::read(line));
            }
            if let Some(fault) = fault {
                let attack = Attack::of(run, case).name();
                println!("case {case}, {attack}: {}", fault.chars().take(300).collect::<String>());
                let row = found.faults.entry(without_numbers(&fault)).or_insert((0, case, fault));
                row.0 += 1;
            }
        }
        case = case.saturating_add(run.jobs);
    }
    worker.stop();
}

/// Runs all jobs and reports.
pub fn run(run: &Run) -> ExitCode {
    println!("fuzz: seed {}, {} jobs, {} cases in the sweep of numbers", run.seed, run.jobs, worker::sweep_cases());
    let (is_over, found) = (Arc::new(AtomicBool::new(false)), Arc::new(Mutex::new(Found::default())));
    if let Some(seconds) = run.seconds {
        let is_over = Arc::clone(&is_over);
        thread::spawn(move || {
            thread::sleep(Duration::from_secs(seconds));
            is_over.store(true, Ordering::Relaxed);
        });
    }
    thread::scope(|scope| {
        for first in 0..run.jobs {
            let (is_over, found) = (&is_over, &found);
            scope.spawn(move || job(run, first, is_over, found));
        }
    });
    let Ok(found) = found.lock() else { return ExitCode::FAILURE };
    let Tally { parsed, checked, built, verified, altered, accepted } = found.tally;
    println!(
        "fuzz: {} cases: {parsed} texts parsed, {checked} checked, {built} programs built, {verified} of them written and verified \
         from their bytes, {altered} altered logs judged, {accepted} of them accepted",
        found.cases
    );
    for (count, case, fault) in found.faults.values() {
        println!("fuzz: {count} x {}, first in case {case}", fault.chars().take(300).collect::<String>());
    }
    match found.faults.is_empty() && found.cases > 0 {
        true => ExitCode::SUCCESS,
        false => ExitCode::FAILURE,
    }
}
