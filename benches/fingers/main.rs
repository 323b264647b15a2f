//! Paths through the grasp graph, against the A* of the crate `pathfinding` on the same tables in one run, and beside
//! the times printed in the paper (MATLAB, Core i7-9750H).
//!
//! `cargo bench --bench fingers` prints all tables, `-- queries` one of them. A time is that of a whole request: the
//! tables of grasps are given, everything else is computed anew for each.

#[path = "../electrode_array/clock.rs"]
mod clock;
mod rival;
mod scenes;

use clock::timed;
use rival::Outcome;
use std::sync::Arc;
use std::time::Duration;
use tweeze::device::fingers::Adhesion;
use tweeze::plan::fingers::graph::{Estimator, GraspAnswer, GraspRequest, GraspSearchEnd, solve};
use tweeze::plan::fingers::tables::Tables;
use tweeze::plan::search::SearchBudget;

/// Most node expansions in one query, for the rival and for ours with the paper's heuristic.
const MOST: u64 = 200_000;

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

/// Result of a request.
struct Sample {
    milliseconds: f64,
    outcome: Outcome,
    expanded: u64,
}

fn ours(request: &GraspRequest, estimator: Estimator) -> Sample {
    let (time, answer) = timed(|| solve(request, estimator, SearchBudget::of(MOST)));
    let (outcome, expanded) = match answer {
        GraspAnswer::Found(way) => (Outcome::Cost(way.cost), way.expanded),
        GraspAnswer::Impossible(_) => (Outcome::NoPath, 0),
        GraspAnswer::GaveUp(GraspSearchEnd::TooLarge { nodes }) => unreachable!("{nodes} nodes are not too many"),
        GraspAnswer::GaveUp(GraspSearchEnd::Expansions(_) | GraspSearchEnd::Looks { .. }) => (Outcome::Open, MOST),
    };
    Sample { milliseconds: milliseconds(time), outcome, expanded }
}

/// The rival's time, measured once; its answer must agree with ours.
fn theirs(request: &GraspRequest, ours: Outcome) -> String {
    let start = std::time::Instant::now();
    let outcome = rival::cost(request, MOST);
    let time = milliseconds(start.elapsed());
    if outcome == Outcome::Open {
        return format!(">{time:.1}");
    }
    assert!(outcome == ours || ours == Outcome::Open, "the rival finds {outcome:?} and we {ours:?}");
    format!("{time:.1}")
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
    println!(
        "goal           cost          layers ms  nodes   published ms    nodes  pathfinding ms | paper's cost and s"
    );
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
        let layers = ours(&request, Estimator::Layers);
        let published = ours(&request, Estimator::Published);
        assert_eq!(layers.outcome, published.outcome);
        total += layers.milliseconds;
        print!("{:14} {:12} {:10.2} {:6}", format!("{goal:?}"), shown(&layers), layers.milliseconds, layers.expanded);
        print!(" {:14.2} {:8}", published.milliseconds, published.expanded);
        println!(" {:>15} | {paper:12} {seconds:?}", theirs(&request, layers.outcome));
    }
    println!(
        "one by one: {total:.1} ms with layers; in the paper 278 s, and 34,207 s for a proof that there is no way"
    );
    let cheapest = ours(&scenes::junction(&tables, [1, 38, 0], 11), Estimator::Layers);
    println!("the cheapest of the six, as one search: {}, {:.2} ms", shown(&cheapest), cheapest.milliseconds);
}

fn shown(sample: &Sample) -> String {
    match sample.outcome {
        Outcome::Cost(cost) => format!("{cost} deg"),
        Outcome::NoPath => "no way".to_owned(),
        Outcome::Open => "stopped".to_owned(),
    }
}

fn queries() {
    println!("\nqueries: random ones on the ellipsoid, each from a grasp that holds to another at a random angle");
    for adhesion in [Adhesion::Sticking, Adhesion::Absent] {
        let tables = ellipsoid(adhesion);
        let requests = scenes::random(&tables, 200);
        summary(&requests, Estimator::Layers);
        summary(&requests[..30], Estimator::Published);
    }
    let tables = ellipsoid(Adhesion::Sticking);
    println!("the first ten: layers ms, pathfinding ms");
    for request in scenes::random(&tables, 10) {
        let layers = ours(&request, Estimator::Layers);
        println!("{:9.2} {:>10}  {}", layers.milliseconds, theirs(&request, layers.outcome), shown(&layers));
    }
}

fn summary(requests: &[GraspRequest], estimator: Estimator) {
    let mut samples: Vec<Sample> = requests.iter().map(|request| ours(request, estimator)).collect();
    let count = |outcome: Outcome| samples.iter().filter(|sample| sample.outcome == outcome).count();
    let (none, stopped) = (count(Outcome::NoPath), count(Outcome::Open));
    samples.sort_by(|a, b| a.milliseconds.total_cmp(&b.milliseconds));
    let (median, worst) = (&samples[samples.len() / 2], &samples[samples.len() - 1]);
    print!("{:3} with {estimator:?}: median {:.2} ms,", samples.len(), median.milliseconds);
    print!(" worst {:.2} ms ({} nodes, {});", worst.milliseconds, worst.expanded, shown(worst));
    println!(" {none} without a way, {stopped} stopped");
}

fn no_path() {
    println!(
        "\nno_path: the ellipsoid, but no finger may leave the triple of the start; everything else reaches the goal"
    );
    let tables = Arc::new(scenes::stuck(&ellipsoid(Adhesion::Sticking), [10, 30, 55]));
    let request = scenes::query(&tables, [11, 31, 56], 11, [38, 1, 0]);
    let proof = ours(&request, Estimator::Layers);
    println!("layers: {:.2} ms, {}", proof.milliseconds, shown(&proof));
    println!("the other way round: the goal's triple cannot be left, and no finger comes to it");
    let tables = Arc::new(scenes::lonely(&tables, [10, 30, 55]));
    let request = scenes::query(&tables, [1, 38, 0], 11, [11, 31, 56]);
    let proof = ours(&request, Estimator::Layers);
    println!(
        "layers: {:.2} ms, {}; pathfinding: {} ms",
        proof.milliseconds,
        shown(&proof),
        theirs(&request, proof.outcome)
    );
}

fn large() {
    println!("\nlarge: a circle of 192 contacts, tips 15 contacts apart, 19 angles: 134 million nodes");
    let circle = scenes::circle(192, 15);
    let tables = Arc::new(circle.clone());
    for goal in [[97, 1, 0], [1, 97, 0], [20, 0, 140], [50, 100, 150]] {
        let sample = ours(&scenes::query(&tables, [1, 97, 0], 11, goal), Estimator::Layers);
        let goal = format!("{goal:?}");
        println!("to {goal:16} {:8.1} ms, {}, {} nodes", sample.milliseconds, shown(&sample), sample.expanded);
    }
    let tables = Arc::new(scenes::stuck(&circle, [10, 70, 130]));
    let sample = ours(&scenes::query(&tables, [11, 71, 131], 11, [97, 1, 0]), Estimator::Layers);
    println!("{}: {:.1} ms; peak memory {}", shown(&sample), sample.milliseconds, peak_memory());
}

/// Peak memory of this process, if the system reports it.
fn peak_memory() -> String {
    let text = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let line = text.lines().find(|line| line.starts_with("VmHWM")).unwrap_or("unknown");
    line.trim_start_matches("VmHWM:").trim().to_owned()
}
