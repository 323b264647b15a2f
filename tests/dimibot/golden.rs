//! Figures of the paper, reproduced through the language: V. Chalvet, Y. Haddab, P. Lutz, J. Mechanisms and Robotics
//! 8(2), 2016, 021013.

use crate::support::build;
use tweeze::schedule::dimibot::DimibotState;
use tweeze::schedule::{PlanRecord, State};

/// The cell pitch of a robot with `modules` modules on each side, in micrometres (equation 2: K = 0.138, stroke 35 um).
fn pitch_um(modules: i32) -> f64 {
    0.138 * 35.0 * std::f64::consts::SQRT_2 / f64::from(1 << (modules - 1))
}

/// A program for a robot with `modules` modules on each side: from one word to another, past obstacle cells that are
/// given as words.
fn program(modules: u32, start: u32, goal: u32, obstacles: &[u32], settings: &str) -> String {
    let word = |number: u32| format!("0b{number:0width$b}", width = 2 * modules as usize);
    let cell = |number: u32| format!("({}, {})", number >> modules, number & ((1 << modules) - 1));
    let objects: String = obstacles.iter().map(|o| format!("  obstacle o{o} at {}\n", cell(*o))).collect();
    format!(
        "use std.dimibot\ndevice bot : dimibot.femto_st {{ left: {modules}, right: {modules} }}\n\
         scene bench {{\n{objects}}}\n\
         task go on bot in bench {{\n  {settings}\n  start at {}\n  move to {}\n}}\n",
        word(start),
        word(goal)
    )
}

/// The only plan of a program; `None` if it is proven that there is none.
fn plan(text: &str) -> Option<PlanRecord> {
    let built = build(text);
    match built.codes.as_slice() {
        [] => Some(built.schedules[0].schedule().plans[0].clone()),
        ["E0601"] => None,
        codes => panic!("{codes:?}\n{text}"),
    }
}

fn words(plan: &PlanRecord) -> Vec<u64> {
    let word = |state: &State| match state {
        State::Dimibot(DimibotState { word, .. }) => *word,
        State::ElectrodeArray(_) | State::Microrobots(_) | State::Fingers(_) => panic!("a DiMiBot"),
    };
    plan.states.iter().map(|timed| word(&timed.state)).collect()
}

/// The cost in units of r, which must be an integer.
fn cost_r(plan: &PlanRecord, modules: i32) -> u32 {
    let cost = plan.cost / pitch_um(modules);
    assert!((cost - cost.round()).abs() < 1e-9 && plan.optimal && plan.bound == plan.cost);
    cost.round() as u32
}

const PLANNERS: [&str; 5] = ["staged_astar", "dijkstra", "bidirectional_dijkstra", "astar", "hypercube_astar"];

#[test]
fn from_six_to_ten_with_two_modules_a_side() {
    for planner in PLANNERS {
        let go = |obstacles: &[u32]| plan(&program(2, 6, 10, obstacles, &format!("using {planner}")));
        let cost = |obstacles: &[u32]| go(obstacles).map(|plan| cost_r(&plan, 2));
        assert_eq!(cost(&[]), Some(3), "{planner}");
        assert_eq!((cost(&[14]), words(&go(&[14]).expect("a way by 2"))), (Some(3), vec![6, 2, 10]), "{planner}");
        assert_eq!((cost(&[2]), words(&go(&[2]).expect("a way by 14"))), (Some(3), vec![6, 14, 10]), "{planner}");
        assert_eq!(cost(&[2, 14]), Some(5), "{planner}");
        assert_eq!(cost(&[14, 2, 7, 9]), None, "{planner}");
    }
}

#[test]
fn figure_seven_costs_thirty_by_every_planner() {
    for planner in PLANNERS {
        let plan = plan(&program(4, 0b1000_1000, 0b0111_0111, &[], &format!("using {planner}"))).expect("a way");
        assert_eq!((cost_r(&plan, 4), words(&plan).len()), (30, 9), "{planner}");
        assert_eq!(plan.planner, planner);
    }
}

/// The rows of a table of the paper: numbers separated by commas.
fn rows(table: &str) -> Vec<Vec<u32>> {
    let lines = table.lines().filter(|line| line.starts_with(|first: char| first.is_ascii_digit()));
    lines.map(|line| line.split(',').map(|cell| cell.parse().expect("a number")).collect()).collect()
}

#[test]
fn table_one_is_a_way_of_thirty_that_the_robot_can_go() {
    let table: Vec<(u32, u32)> = include_str!("../data/dimibot_table1.csv")
        .lines()
        .filter(|line| line.starts_with(['0', '1']))
        .map(|line| line.split_once(',').expect("two columns"))
        .map(|(word, way)| (u32::from_str_radix(word, 2).expect("a word"), way.parse().expect("a number")))
        .collect();
    assert_eq!((table.first(), table.last()), (Some(&(0b1000_1000, 0)), Some(&(0b0111_0111, 30))));
    for pair in table.windows(2) {
        let ((from, at), (to, then)) = (pair[0], pair[1]);
        let plan = plan(&program(4, from, to, &[], "minimize distance")).expect("an edge");
        assert_eq!((cost_r(&plan, 4), words(&plan).len()), (then - at, 2), "{from:08b} to {to:08b}");
    }
    // The printed table ends at the row before the last, one move short of the goal.
    assert_eq!(table[table.len() - 2], (0b0110_0111, 29));
}

/// Edge weight of the graph for N = 2 according to the compiler: a pair of words is an edge if a plan switches one
/// module.
fn edge_weight(from: u32, to: u32, obstacles: &[u32]) -> u32 {
    let plan = plan(&program(2, from, to, obstacles, "minimize switches"));
    match plan.filter(|plan| words(plan).len() == 2) {
        Some(plan) => (plan.outcomes["distance_um"] / pitch_um(2)).round() as u32,
        None => 0,
    }
}

#[test]
fn table_two_is_the_graph_but_for_the_misprint_in_row_thirteen() {
    let printed = rows(include_str!("../data/dimibot_table2.csv"));
    assert_eq!(printed.len(), 16);
    for (from, printed) in printed.iter().enumerate() {
        let graph: Vec<u32> = (0..16).map(|to| edge_weight(from as u32, to, &[])).collect();
        if from == 13 {
            let mut mended = printed.clone();
            assert_eq!((mended[8], mended[11]), (1, 1));
            (mended[8], mended[9], mended[11], mended[12]) = (0, 1, 0, 1);
            assert_eq!(graph, mended);
        } else {
            assert_eq!(&graph, printed, "row {from}");
        }
    }
}

#[test]
fn an_obstacle_at_six_takes_exactly_six_edges_away() {
    // Edges at 6 itself cannot be tested, because nothing starts or ends on an obstacle.
    let others = (0..16).filter(|word| *word != 6);
    let pairs = others.clone().flat_map(|from| others.clone().map(move |to| (from, to))).filter(|(a, b)| a < b);
    let gone: Vec<(u32, u32)> =
        pairs.filter(|(from, to)| edge_weight(*from, *to, &[]) > 0 && edge_weight(*from, *to, &[6]) == 0).collect();
    assert_eq!(gone, [(2, 10), (5, 7)]);
    let at_six = [2, 4, 7, 14];
    assert!(at_six.iter().all(|word| edge_weight(6, *word, &[]) > 0));
    assert_eq!((0..16).filter(|word| edge_weight(6, *word, &[]) > 0).count(), at_six.len());
    assert_eq!(build(&program(2, 2, 6, &[6], "")).codes, ["E0502"]);
    assert_eq!(build(&program(2, 6, 2, &[6], "")).codes, ["E0505"]);
}

/// Published pitches: 1.71 um and a range of 11.95 um for three modules on each side, 213 nm for six, 1.67 nm for
/// thirteen.
#[test]
fn published_pitches_are_met() {
    for (modules, cells, place_um, digits) in
        [(3, 1, 1.71, 2), (3, 7, 11.95, 2), (6, 1, 0.213, 3), (13, 1, 0.00167, 5), (2, 1, 3.415, 3)]
    {
        let text = format!(
            "use std.dimibot\ndevice bot : dimibot.femto_st {{ left: {modules}, right: {modules} }}\n\
             task go on bot {{ move to ({cells}, 0) }}\n"
        );
        let built = build(&text);
        let plan = &built.schedules[0].schedule().plans[0];
        let State::Dimibot(DimibotState { position_um, .. }) = &plan.states.last().expect("a state").state else {
            panic!("a DiMiBot")
        };
        let half_a_digit = 0.5 * 10f64.powi(-digits);
        assert!((position_um[0] - place_um).abs() <= half_a_digit, "{modules}: {position_um:?}");
        assert_eq!(position_um[1], 0.0);
    }
}

/// Cost of each switch: 15 ms and 30 mJ (section 3.2).
#[test]
fn time_and_energy_follow_the_switches() {
    let plan = plan(&program(4, 0b1000_1000, 0b0111_0111, &[], "minimize energy")).expect("a way");
    assert!((plan.cost - 240.0).abs() < 1e-9 && plan.unit == "mJ");
    assert_eq!((plan.duration_ns, plan.outcomes["switches"]), (120_000_000, 8.0));
}
