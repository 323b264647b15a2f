//! 400 parts on 400 x 400 electrodes. Each instance runs in a process of its own, so that its peak memory is its own.

use crate::clock::timed;
use crate::sample::{self, costs, mean, ratios, spread};
use crate::scenes::{Random, Shape};
use std::process::Command;
use tweeze::plan::electrode_array::board::{BoardAnswer, BoardObjective, BoardPlan};
use tweeze::plan::electrode_array::{fast, solve};
use tweeze::plan::search::SearchBudget;

/// The argument with which this program measures one instance.
pub const CHILD: &str = "measure-large";

/// Number of random instances.
const COUNT: u64 = 5;

const SHAPE: Shape = Shape { size: (400, 400), rim: 1, separation: 4, agents: 400, obstacles: 0 };

const BUDGET: SearchBudget = SearchBudget::of(8_000_000);

/// Runs all instances, one process each.
pub fn table() {
    println!("\nlarge: 400 parts on 400 x 400 electrodes, separation 4; {COUNT} random instances");
    let rows: Vec<Vec<f64>> = (0..COUNT).map(child).collect();
    let column = |k: usize| rows.iter().map(move |row| row[k]);
    let [median, _, max] = spread(column(0).collect());
    println!(
        "first plan: median {median:.0} ms, max {max:.0} ms; makespan {:.3}, sum {:.3} of the bound; peak {:.0} MB",
        mean(column(1)),
        mean(column(2)),
        spread(column(3).collect())[2]
    );
    println!(
        "in the end: after {:.1} s; makespan {:.3}, sum {:.3} of the bound; peak {:.0} MB",
        mean(column(4)),
        mean(column(5)),
        mean(column(6)),
        spread(column(7).collect())[2]
    );
}

/// Measures one instance in a fresh process, and reads the figures that it prints.
fn child(seed: u64) -> Vec<f64> {
    let program = std::env::current_exe().expect("the path of this program");
    let output = Command::new(program).args([CHILD, &seed.to_string()]).output().expect("this program starts");
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let text = String::from_utf8_lossy(&output.stdout).into_owned();
    text.split_whitespace().map(|word| word.parse().expect("a number")).collect()
}

/// Prints time, ratios and peak memory at the first plan and at the end.
pub fn measure(seed: u64) {
    let instance = SHAPE.instance(&mut Random::new(seed)).expect("the board holds so many");
    let bounds = fast::bounds(&instance).expect("no part is walled in");
    let (ms, first) = sample::first(&instance).expect("a plan");
    let first_peak = peak_mb();
    let [makespan, sum] = ratios(costs(&instance, &first), bounds);
    println!("{ms} {makespan} {sum} {first_peak}");
    drop(first);
    let (time, answer) = timed(|| solve(&instance, BoardObjective::Makespan, None, BUDGET));
    let seconds = time.as_secs_f64();
    let last_peak = peak_mb();
    let BoardAnswer::Found(BoardPlan { paths, .. }) = answer else { panic!("a plan was found before") };
    let [makespan, sum] = ratios(costs(&instance, &paths), bounds);
    println!("{seconds} {makespan} {sum} {last_peak}");
}

/// Peak resident memory so far, in MB; NaN if the system does not report it.
fn peak_mb() -> f64 {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:"));
    let kb = line.and_then(|rest| rest.split_whitespace().next()).and_then(|word| word.parse::<f64>().ok());
    kb.map_or(f64::NAN, |kb| kb / 1024.0)
}
