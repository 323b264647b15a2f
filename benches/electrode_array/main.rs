//! Many parts on one board, against a plain baseline and the crate `mapf-rs`: the same instances in one run, with
//! every plan checked.
//!
//! `cargo bench --bench electrode_array` prints all tables, `-- droplets` one of them. Instances come from fixed
//! seeds. Our planner has a budget of steps, so its plans are the same on every machine; the baseline and the rival
//! have time limits.

mod assays;
mod baseline;
#[path = "../../tests/electrode_array/check.rs"]
mod check;
mod clock;
mod large;
#[path = "../../tests/electrode_array/programs.rs"]
mod programs;
mod protein;
mod rival;
mod sample;
#[path = "../../tests/electrode_array/scenes.rs"]
mod scenes;

use rival::Rival;
use sample::{Sample, ours, plain};
use scenes::{Random, Shape};
use std::time::Duration;
use tweeze::plan::electrode_array::board::{BoardCosts, BoardObjective, Instance};
use tweeze::plan::electrode_array::{fast, solve};
use tweeze::plan::search::SearchBudget;

/// Time limit for an instance: running time for the baseline, wall-clock time for the rival.
const TIME: Duration = Duration::from_secs(1);

/// Our budget, the first plan included; it takes a fraction of that time.
const BUDGET: SearchBudget = SearchBudget::of(2_000_000);

/// A budget that takes about a second with 50 crowded microparts.
const SECOND: SearchBudget = SearchBudget::of(5_500_000);

fn main() {
    let arguments: Vec<String> = std::env::args().skip(1).filter(|argument| !argument.starts_with('-')).collect();
    if let [name, seed] = arguments.as_slice()
        && name == large::CHILD
    {
        return large::measure(seed.parse().expect("a seed"));
    }
    let filter = arguments.first().map_or("", String::as_str);
    if filter == "long-assays" {
        // These take some ten minutes and 4 GB, so they are not among the tables that run without a filter.
        return assays::long_table();
    }
    let tables: [(&str, fn()); 7] = [
        ("microparts", microparts),
        ("crowd", crowd),
        ("large", large::table),
        ("droplets", droplets),
        ("points", points),
        ("assays", assays::table),
        ("field-assays", assays::field_table),
    ];
    for (_, table) in tables.iter().filter(|(name, _)| name.contains(filter)) {
        table();
    }
}

fn microparts() {
    println!("\nmicroparts: 50 x 50 electrodes, separation 4; 20 random instances in a row");
    sample::header();
    for agents in [5, 10, 20, 30, 40, 50] {
        compare(micropart_shape(agents), 20);
    }
    println!("with a budget of about a second:");
    row_alone(micropart_shape(50), 20, SECOND);
    println!("with the default budget:");
    for agents in [50, 60, 65] {
        row_alone(micropart_shape(agents), 20, SearchBudget::DEFAULT);
    }
}

/// One row for our planner.
fn row_alone(shape: Shape, count: u64, budget: SearchBudget) {
    let samples: Vec<Sample> = instances(shape, count).iter().map(|instance| ours(instance, budget)).collect();
    sample::row("tweeze", shape.agents, &samples);
}

fn micropart_shape(agents: usize) -> Shape {
    Shape { size: (50, 50), rim: 1, separation: 4, agents, obstacles: 0 }
}

fn crowd() {
    println!("\ncrowd: 50 x 50 electrodes, separation 2; 20 random instances");
    sample::header();
    let shape = |agents| Shape { size: (50, 50), rim: 1, separation: 2, agents, obstacles: 0 };
    compare(shape(100), 20);
    println!("with the default budget:");
    for agents in [200, 250] {
        row_alone(shape(agents), 5, SearchBudget::DEFAULT);
    }
    println!("200 x 200 electrodes, with the default budget:");
    row_alone(Shape { size: (200, 200), ..shape(1000) }, 5, SearchBudget::DEFAULT);
}

/// Two rows: our planner, and the baseline on the same instances.
fn compare(shape: Shape, count: u64) {
    let instances = instances(shape, count);
    let samples: Vec<Sample> = instances.iter().map(|instance| ours(instance, BUDGET)).collect();
    sample::row("tweeze", shape.agents, &samples);
    let samples: Vec<Sample> = instances.iter().map(|instance| plain(instance, TIME)).collect();
    sample::row("baseline", shape.agents, &samples);
}

fn instances(shape: Shape, count: u64) -> Vec<Instance> {
    let seed = |k: u64| k * 1_000_003 + shape.agents as u64 * 1009 + u64::from(shape.separation);
    (0..count).map(|k| shape.instance(&mut Random::new(seed(k))).expect("the board holds so many")).collect()
}

fn droplets() {
    println!(
        "\ndroplets: the routing set, separation 2, and the paper's Table 6 at separation 4; the objective is the latest arrival"
    );
    println!(
        "                          first plan    latest arrival proven          default budget             | baseline"
    );
    println!("case              parts     ms latest     ms latest  bound       ms latest  bound   sum  bound | latest");
    let mut totals = [0.0; 3];
    for (name, instance) in scenes::droplets() {
        let times = droplet_row(&name, &instance);
        totals.iter_mut().zip(times).for_each(|(total, time)| *total += time);
    }
    println!("{:23} {:6.1} {:13.1} {:16.1}   ms in all", "the droplet set", totals[0], totals[1], totals[2]);
    droplet_row("table_6", &scenes::table_6());
}

/// Milliseconds to the first plan, with the smallest budget that proves its makespan optimal, and with the default
/// budget.
fn droplet_row(name: &str, instance: &Instance) -> [f64; 3] {
    let first = sample::first(instance).expect("every case has a plan");
    let latest = sample::costs(instance, &first.1).makespan;
    let solved = |budget: SearchBudget| {
        let (time, answer) = clock::timed(|| solve(instance, BoardObjective::Makespan, None, budget));
        check::judged(instance, &answer).map(|(costs, bounds)| (sample::milliseconds(time), costs, bounds))
    };
    let whole = solved(SearchBudget::DEFAULT).expect("every case has a plan");
    let budgets = (10..24).map(|power| SearchBudget::of(1 << power));
    let is_proven = |(_, costs, bounds): &(f64, BoardCosts, BoardCosts)| costs.makespan == bounds.makespan;
    let quick = budgets.filter_map(solved).find(is_proven).unwrap_or(whole);
    let plain = plain(instance, TIME).last.map_or("none".to_owned(), |(_, costs)| costs.makespan.to_string());
    print!("{name:17} {:5} {:6.1} {:6}", instance.agents.len(), first.0, latest);
    print!(" {:6.1} {:6} {:6}", quick.0, quick.1.makespan, quick.2.makespan);
    print!(" {:8.1} {:6} {:6}", whole.0, whole.1.makespan, whole.2.makespan);
    println!(" {:5} {:6} | {plain}", whole.1.sum_of_costs, whole.2.sum_of_costs);
    [first.0, quick.0, whole.0]
}

fn points() {
    println!(
        "\npoints: 48 x 48 cells, point agents; 10 random instances in a row; ours also forbids to follow at once"
    );
    sample::header();
    for agents in [100, 200, 400] {
        let instances = instances(Shape { size: (48, 48), rim: 0, separation: 1, agents, obstacles: 0 }, 10);
        let samples: Vec<Sample> = instances.iter().map(|instance| ours(instance, BUDGET)).collect();
        sample::row("tweeze", agents, &samples);
        let samples: Vec<Sample> = instances.iter().map(theirs).collect();
        sample::row("mapf-rs", agents, &samples);
    }
}

fn theirs(instance: &Instance) -> Sample {
    let rival = Rival::new(instance);
    let simple = fast::bounds(instance).expect("no agent is walled in");
    let first = rival.first(TIME * 10).map(|(time, costs)| (time.as_secs_f64() * 1e3, costs));
    let last = rival.bettered(TIME).map(|costs| (TIME.as_secs_f64(), costs));
    Sample { first, last, simple, proven: simple }
}
