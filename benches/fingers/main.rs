//! Ways through the grasp graph, against the A* of the crate `pathfinding` on the same tables in one run, and beside the times that
//! the paper prints (MATLAB, Core i7-9750H).
//!
//! `cargo bench --bench fingers` prints all tables, `-- queries` one of them. A time is that of a whole request: the tables of
//! grasps are given, everything else is made anew for each.

#[path = "../electrode_array/clock.rs"]
mod clock;
mod rival;
mod scenes;

use clock::timed;
use rival::Outcome;
use std::sync::Arc;
use std::time::Duration;
use tweeze::device::fingers::Adhesion;
use tweeze::plan::fingers::graph::{Answer, Estimator, Request, solve};
use tweeze::plan::fingers::tables::Tables;
use tweeze::plan::search::Budget;

/// What the rival may expand of one query; it needs some kilobytes for each.
const RIVAL_MOST: u64 = 1_000_000;

fn main() {
    let arguments: Vec<String> = std::env::args().skip(1).filter(|argument| !argument.starts_with('-')).collect();
    let filter = arguments.first().map_or("", String::as_str);
    let tables: [(&str, fn()); 4] =
        [("rotation", second_rotation), ("queries", queries), ("no_path", no_path), ("large", large)];
    for (_, table) in tables.iter().filter(|(name, _)| name.contains(filter)) {
        table();
    }
}

fn milliseconds(time: Duration) -> f64 {
    time.as_secs_f64() * 1e3
}

/// The time, the cost if there is a way, and how many nodes were expanded.
fn ours(request: &Request, estimator: Estimator) -> (f64, Option<u64>, u64) {
    let (time, answer) = timed(|| solve(request, estimator, Budget::of(u64::MAX)));
    let (cost, expanded) = match answer {
        Answer::Found(way) => (Some(way.cost), way.expanded),
        Answer::Impossible(_) => (None, 0),
        Answer::GaveUp(_) | Answer::TooLarge { .. } => unreachable!("the budget has no end, and no graph is too large"),
    };
    (milliseconds(time), cost, expanded)
}

/// The rival's time, once; its answer must be ours.
fn theirs(request: &Request, cost: Option<u64>) -> String {
    let start = std::time::Instant::now();
    let outcome = rival::cost(request, RIVAL_MOST);
    let time = milliseconds(start.elapsed());
    match outcome {
        Outcome::Open => format!(">{time:8.1}"),
        Outcome::Cost(theirs) => {
            assert_eq!(Some(theirs), cost, "the rival finds another cost");
            format!("{time:9.1}")
        }
        Outcome::NoPath => {
            assert_eq!(cost, None, "the rival finds no way");
            format!("{time:9.1}")
        }
    }
}

fn ellipsoid(adhesion: Adhesion) -> Arc<Tables> {
    let facts = scenes::hand(adhesion);
    let (time, tables) = timed(|| scenes::ellipsoid(&facts));
    println!("tables of the ellipsoid ({adhesion:?}): {:.1} ms", milliseconds(time));
    Arc::new(tables)
}

fn second_rotation() {
    println!("\nrotation: the ellipsoid turned by 220 deg from [1 38 0 1], 74 contacts, 19 angles; removal safety 1.8");
    let tables = ellipsoid(Adhesion::Sticking);
    println!("goal                cost    layers ms  nodes   published ms    nodes  pathfinding ms | paper's cost   and s");
    let goals = [
        ([1, 0, 38], 2240, [45, 10]),
        ([0, 1, 38], 2240, [50, 8]),
        ([38, 0, 1], 2240, [78, 35]),
        ([38, 1, 0], 1880, [3, 2]),
        ([0, 38, 1], 2240, [48, 20]),
        ([1, 38, 0], 2600, [857, 203]),
    ];
    let mut total = 0.0;
    for (goal, paper, seconds) in goals {
        let request = scenes::query(&tables, [1, 38, 0], 11, goal);
        let (layers, cost, nodes) = ours(&request, Estimator::Layers);
        let (published, same, more) = ours(&request, Estimator::Published);
        assert_eq!(cost, same);
        total += layers;
        let shown = cost.map_or("none".to_owned(), |cost| cost.to_string());
        print!("{:16} {shown:>7} {layers:12.2} {nodes:6} {published:14.2} {more:8}", format!("{goal:?}"));
        println!(" {:>15} | {paper:12} {seconds:?}", theirs(&request, cost));
    }
    println!("all six: {total:.1} ms with layers; in the paper 278 s, without a way 34,207 s");
}

fn queries() {
    println!("\nqueries: 200 random ones on the ellipsoid, each from a grasp that holds to another at a random angle");
    for adhesion in [Adhesion::Sticking, Adhesion::Absent] {
        let tables = ellipsoid(adhesion);
        let requests = scenes::random(&tables, 200);
        for estimator in [Estimator::Layers, Estimator::Published] {
            let mut times: Vec<(f64, Option<u64>, u64)> = requests.iter().map(|request| ours(request, estimator)).collect();
            let none = times.iter().filter(|(_, cost, _)| cost.is_none()).count();
            let nodes = times.iter().map(|(_, _, nodes)| *nodes).max().unwrap_or(0);
            times.sort_by(|a, b| a.0.total_cmp(&b.0));
            let (median, worst) = (times[times.len() / 2].0, times[times.len() - 1].0);
            println!("{estimator:?}: median {median:.2} ms, worst {worst:.2} ms, most nodes {nodes}, {none} without a way");
        }
    }
    let tables = ellipsoid(Adhesion::Sticking);
    println!("the first ten, layers ms and pathfinding ms:");
    for request in scenes::random(&tables, 10) {
        let (layers, cost, _) = ours(&request, Estimator::Layers);
        println!("{layers:9.2} {}", theirs(&request, cost));
    }
}

fn no_path() {
    println!("\nno_path: the ellipsoid, but no finger may leave the triple of the start; everything else reaches the goal");
    let tables = Arc::new(scenes::stuck(&ellipsoid(Adhesion::Sticking), [10, 30, 55]));
    let request = scenes::query(&tables, [11, 31, 56], 11, [38, 1, 0]);
    println!("proof from the start: {:.2} ms", ours(&request, Estimator::Layers).0);
    println!("pathfinding: {}", theirs(&request, None));
}

fn large() {
    println!("\nlarge: a circle of 192 contacts, tips 15 contacts apart, 19 angles: 134 million nodes");
    let circle = scenes::circle(192, 15);
    let tables = Arc::new(circle.clone());
    for goal in [[97, 1, 0], [1, 97, 0], [20, 0, 140], [50, 100, 150]] {
        let (time, cost, nodes) = ours(&scenes::query(&tables, [1, 97, 0], 11, goal), Estimator::Layers);
        println!("to {:16} {time:8.1} ms, cost {cost:?}, {nodes} nodes", format!("{goal:?}"));
    }
    let tables = Arc::new(scenes::stuck(&circle, [10, 70, 130]));
    let (time, cost, _) = ours(&scenes::query(&tables, [11, 71, 131], 11, [97, 1, 0]), Estimator::Layers);
    println!("no way: {time:8.1} ms, cost {cost:?}; peak memory {}", peak_memory());
}

/// The most memory that this process has had, where the system tells.
fn peak_memory() -> String {
    let text = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let line = text.lines().find(|line| line.starts_with("VmHWM")).unwrap_or("unknown");
    line.trim_start_matches("VmHWM:").trim().to_owned()
}
