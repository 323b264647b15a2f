//! Plan quality on random programs: share with a plan, planning time, duration, and success rate.

use crate::fields::{self, checked};
use crate::simple;
use std::time::Instant;
use tweeze::claims::Claims;
use tweeze::claims::microrobots::MicrorobotsAction;
use tweeze::diagnostic::{Code, Sink};
use tweeze::plan::microrobots::bound::together::{self, RobotArrival};
use tweeze::plan::{self, Motion, Plan};
use tweeze::simulate::simulate;

/// Trials of each plan; then their seed.
const TRIALS: u64 = 200;
const SEED: u64 = 7;

/// Side lengths of the fields.
const SIDES_UM: [f64; 3] = [3_000.0, 4_000.0, 6_000.0];

/// Numbers of robots.
const COUNTS: std::ops::RangeInclusive<usize> = 3..=6;

/// Result of one program.
struct Outcome {
    has_plan: bool,
    /// Only the simple search found a plan.
    is_missed: bool,
    planning_ms: f64,
    lasts_s: Option<f64>,
    direct_s: Option<f64>,
    over_bound: Option<f64>,
    success: Option<f64>,
    has_proof: bool,
}

/// Number of programs of each kind: the second argument if there is one, otherwise `usual`.
fn programs(usual: u64) -> u64 {
    std::env::args().filter_map(|argument| argument.parse().ok()).next().unwrap_or(usual)
}

fn planned<'a>(claims: &'a Claims, sink: &mut Sink) -> (f64, Option<Plan<Motion<'a>>>) {
    let start = Instant::now();
    let plan = plan::plan(claims, sink, &mut |_, _, _| ()).and_then(|mut plans| plans.pop());
    (start.elapsed().as_secs_f64() * 1e3, plan)
}

fn outcome(text: &str) -> Outcome {
    let claims = checked(text).unwrap_or_else(|| panic!("the program is right:\n{text}"));
    let order = fields::order(&claims);
    let mut sink = Sink::default();
    let (planning_ms, plan) = planned(&claims, &mut sink);
    let has_plan = plan.is_some();
    let success = plan.as_ref().and_then(|plan| simulate(&plan.motion, TRIALS, SEED, 1));
    if std::env::args().any(|argument| argument == "show") {
        let share = success.as_ref().map_or(0, |report| report.successes);
        println!("{has_plan} {planning_ms:.0} ms, {share} of {TRIALS}\n{text}");
    }
    Outcome {
        has_plan,
        is_missed: !has_plan && simple::has_plan(order),
        planning_ms,
        lasts_s: plan.as_ref().and_then(|plan| plan.outcomes.get("time").copied()),
        direct_s: simple::direct_s(order),
        over_bound: plan.as_ref().filter(|plan| plan.unit == "s").map(|plan| plan.cost / plan.bound),
        success: success.map(|report| report.successes as f64 / report.trials as f64),
        has_proof: sink.sorted().iter().any(|found| found.code == Code::E0601),
    }
}

/// The quantile of a share of the values.
fn quantile(values: impl Iterator<Item = f64>, share: f64) -> f64 {
    let mut values: Vec<f64> = values.collect();
    values.sort_by(f64::total_cmp);
    let at = (values.len() as f64 * share) as usize;
    values.get(at.min(values.len().saturating_sub(1))).copied().unwrap_or(f64::NAN)
}

fn mean(values: impl Iterator<Item = f64>) -> f64 {
    let values: Vec<f64> = values.collect();
    values.iter().sum::<f64>() / values.len() as f64
}

fn row(name: &str, all: &[Outcome]) {
    let count = |is: fn(&Outcome) -> bool| all.iter().filter(|one| is(one)).count();
    let time_ms = |share| quantile(all.iter().map(|one| one.planning_ms), share);
    let shorter = all.iter().filter_map(|one| Some(one.lasts_s? / one.direct_s?));
    println!(
        "| {name} | {} | {} | {} | {} | {:.0} | {:.0} | {:.1} | {:.0} % | {:.2} | {:.3} |",
        all.len(),
        count(|one| one.has_plan),
        count(|one| one.is_missed),
        count(|one| one.direct_s.is_some()),
        time_ms(0.5),
        time_ms(0.9),
        quantile(all.iter().filter_map(|one| one.lasts_s), 0.5),
        100.0 * (1.0 - quantile(shorter, 0.5)),
        quantile(all.iter().filter_map(|one| one.over_bound), 0.5),
        mean(all.iter().filter_map(|one| one.success)),
    );
}

fn assemblies(objective: &str, usual: u64, changed: fn(&str) -> String) {
    println!(
        "\nAssemblies on random fields, `minimize {objective}`; success of {TRIALS} trials; times include the 400 trials of `build`.\n"
    );
    println!(
        "| robots, field | fields | planned | missed | without first legs | median [ms] | p90 [ms] | lasts [s] | shorter by | over bound | success |"
    );
    println!("|---|---|---|---|---|---|---|---|---|---|---|");
    for count in COUNTS {
        let mut whole = Vec::new();
        for side_um in SIDES_UM {
            let one = |seed| outcome(&changed(&fields::assembly(count, side_um, seed, objective)));
            let found: Vec<Outcome> = (0..programs(usual)).map(one).collect();
            row(&format!("{count}, {} mm", side_um / 1e3), &found);
            whole.extend(found);
        }
        row(&format!("{count}"), &whole);
    }
}

/// The bound of an assembly divided by that of its slowest robot alone.
fn over_slowest(text: &str) -> f64 {
    let claims = checked(text).unwrap_or_else(|| panic!("the program is right:\n{text}"));
    let order = fields::order(&claims);
    let arrivals: Vec<RobotArrival> = match order.steps.first().map(|step| &step.action) {
        Some(MicrorobotsAction::Assemble(docks)) => docks
            .iter()
            .map(|dock| RobotArrival::of(order, dock.robot, order.robots[dock.robot].pose, dock.goal.pose))
            .collect(),
        Some(_) | None => panic!("it is an assembly"),
    };
    let alone = arrivals.iter().map(|arrival| together::least_strokes(order, vec![*arrival])).max();
    together::least_strokes(order, arrivals) as f64 / alone.unwrap_or(1) as f64
}

/// Improvement of the bounds by taking all robots together.
pub fn bounds() {
    println!("\nBound of assemblies on random fields, over that of the slowest robot alone.\n");
    println!("| robots | fields | median | p90 |\n|---|---|---|---|");
    for count in COUNTS {
        let of_side = |side_um: f64| {
            (0..programs(24)).map(move |seed| over_slowest(&fields::assembly(count, side_um, seed, "time")))
        };
        let gains: Vec<f64> = SIDES_UM.into_iter().flat_map(of_side).collect();
        let [median, p90] = [0.5, 0.9].map(|share| quantile(gains.iter().copied(), share));
        println!("| {count} | {} | {median:.2} | {p90:.2} |", gains.len());
    }
}

/// Plans for the objective `time`.
pub fn fastest() {
    assemblies("time", 8, str::to_owned);
}

/// The same for a device without errors.
pub fn written() {
    assemblies("time", 8, fields::without_errors);
}

/// Plans for the objective `failures`.
pub fn safest() {
    assemblies("failures", 4, str::to_owned);
}

/// Drives of one robot among two others and obstacles.
pub fn drives() {
    let one = |seed| outcome(&fields::drive(seed));
    let found: Vec<Outcome> = (0..programs(200)).map(one).collect();
    assert!(!found.iter().any(|one| one.has_proof && one.is_missed), "a drive that is proven impossible has a plan");
    let count = |is: fn(&Outcome) -> bool| found.iter().filter(|one| is(one)).count();
    println!("\nDrives of one of three robots among up to 12 obstacles.\n");
    println!(
        "| drives | planned | no plan, proven | no plan found (E0602) | of these the simple search has one | median [ms] | p90 [ms] | over bound |"
    );
    println!("|---|---|---|---|---|---|---|---|");
    println!(
        "| {} | {} | {} | {} | {} | {:.1} | {:.1} | {:.2} |",
        found.len(),
        count(|one| one.has_plan),
        count(|one| !one.has_plan && one.has_proof),
        count(|one| !one.has_plan && !one.has_proof),
        count(|one| one.is_missed && !one.has_proof),
        quantile(found.iter().map(|one| one.planning_ms), 0.5),
        quantile(found.iter().map(|one| one.planning_ms), 0.9),
        quantile(found.iter().filter_map(|one| one.over_bound), 0.5),
    );
}
