//! Measurements of one instance, and statistics over many.

use crate::baseline::{self, Until};
use crate::check::{fault, judged};
use crate::clock::{running, timed};
use std::time::Duration;
use tweeze::plan::electrode_array::board::{BoardAnswer, BoardCosts, BoardObjective, Instance, Paths};
use tweeze::plan::electrode_array::{self, fast, solve};
use tweeze::plan::search::SearchBudget;

/// Budget of a first plan alone: half of the default budget.
const FIRST: SearchBudget = SearchBudget::of(SearchBudget::DEFAULT.steps / 2);

/// Results of a planner on one instance.
#[derive(Default)]
pub struct Sample {
    /// Milliseconds to the first plan, and its costs.
    pub first: Option<(f64, BoardCosts)>,
    /// Seconds until it ended, and the costs then.
    pub last: Option<(f64, BoardCosts)>,
    /// Lower bounds: the costs if parts ignore one another.
    pub simple: BoardCosts,
    /// The bounds proven at the end.
    pub proven: BoardCosts,
}

/// Our planner: first a first plan alone, then the whole portfolio from scratch with a budget.
pub fn ours(instance: &Instance, budget: SearchBudget) -> Sample {
    let simple = fast::bounds(instance).expect("no part is walled in");
    let first = first(instance).map(|(ms, paths)| (ms, costs(instance, &paths)));
    let (time, answer) = timed(|| solve(instance, BoardObjective::Makespan, None, budget));
    assert!(!matches!(answer, BoardAnswer::Impossible(_)), "none of these instances is impossible");
    let judged = judged(instance, &answer);
    let last = judged.map(|(costs, _)| (time.as_secs_f64(), costs));
    Sample { first, last, simple, proven: judged.map_or(simple, |(_, bounds)| bounds) }
}

/// The first plan, and the milliseconds until it was found.
pub fn first(instance: &Instance) -> Option<(f64, Paths)> {
    let (time, first) = timed(|| electrode_array::first(instance, BoardObjective::Makespan, FIRST));
    first.map(|paths| (milliseconds(time), paths))
}

/// The plain baseline with a time limit.
pub fn plain(instance: &Instance, time: Duration) -> Sample {
    let simple = fast::bounds(instance).expect("no part is walled in");
    let (first_time, first) = timed(|| baseline::run(instance, simple, Until::First, time));
    let Some(first) = first else { return Sample { simple, proven: simple, ..Sample::default() } };
    let begun = running();
    let best = baseline::run(instance, simple, Until::TheEnd, time).map_or(first.first.clone(), |found| found.best);
    let last = Some(((running() - begun).as_secs_f64(), costs(instance, &best)));
    let first = Some((milliseconds(first_time), costs(instance, &first.first)));
    Sample { first, last, simple, proven: simple }
}

/// The costs of a plan, after the checker has accepted it.
pub fn costs(instance: &Instance, paths: &Paths) -> BoardCosts {
    assert_eq!(fault(instance, paths), None);
    BoardCosts::of(paths)
}

pub fn milliseconds(time: Duration) -> f64 {
    time.as_secs_f64() * 1e3
}

/// Costs divided by their bounds.
pub fn ratios(costs: BoardCosts, bounds: BoardCosts) -> [f64; 2] {
    let ratio = |cost: u64, bound: u64| cost as f64 / bound.max(1) as f64;
    [ratio(costs.makespan, bounds.makespan), ratio(costs.sum_of_costs, bounds.sum_of_costs)]
}

/// Median, 90th percentile and largest value.
pub fn spread(mut values: Vec<f64>) -> [f64; 3] {
    values.sort_by(f64::total_cmp);
    let at = |share: usize| values.get((values.len() * share / 100).min(values.len().max(1) - 1)).copied();
    [50, 90, 100].map(|share| at(share).unwrap_or(f64::NAN))
}

pub fn mean(values: impl Iterator<Item = f64>) -> f64 {
    let values: Vec<f64> = values.collect();
    values.iter().sum::<f64>() / values.len() as f64
}

pub fn header() {
    println!(
        "                 first plan: ms                          over bound    | in the end:      over bound     proven"
    );
    println!(
        "parts            found    median      p90      max  latest    sum |  found      s  latest    sum latest  sum"
    );
}

/// One row: number of instances with a plan, times to the first plan, ratios to the bounds at first and at the end,
/// number proven optimal.
pub fn row(name: &str, agents: usize, samples: &[Sample]) {
    let over = |it: &Sample, (time, costs): (f64, BoardCosts)| (time, ratios(costs, it.simple));
    let first: Vec<(f64, [f64; 2])> = samples.iter().filter_map(|it| it.first.map(|first| over(it, first))).collect();
    let last: Vec<(f64, [f64; 2])> = samples.iter().filter_map(|it| it.last.map(|last| over(it, last))).collect();
    let shortest = |it: &&Sample| it.last.is_some_and(|(_, costs)| costs.makespan == it.proven.makespan);
    let cheapest = |it: &&Sample| it.last.is_some_and(|(_, costs)| costs.sum_of_costs == it.proven.sum_of_costs);
    let [median, p90, max] = spread(first.iter().map(|(ms, _)| *ms).collect());
    let ratio = |of: &[(f64, [f64; 2])], k: usize| mean(of.iter().map(|(_, ratios)| ratios[k]));
    print!("{agents:5} {name:9} {:4}/{:2}", first.len(), samples.len());
    print!(" {median:9.2} {p90:8.1} {max:8.1}  {:6.3} {:6.3}", ratio(&first, 0), ratio(&first, 1));
    print!(" | {:4}/{:2} {:6.2}", last.len(), samples.len(), mean(last.iter().map(|(s, _)| *s)));
    print!("  {:6.3} {:6.3}", ratio(&last, 0), ratio(&last, 1));
    println!(" {:6} {:4}", samples.iter().filter(shortest).count(), samples.iter().filter(cheapest).count());
}
