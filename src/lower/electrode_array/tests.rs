//! Lowering against Table 2 of the paper, and a schedule for the tests of later stages.

use super::*;
use crate::claims::electrode_array::{
    BoardPart, ElectrodeArrayMethod, ElectrodeArrayMove, ElectrodeArrayPlanner, ElectrodeArrayStep as TaskStep,
    ElectrodeArrayStop,
};
use crate::claims::fixture::{self, board_order};
use crate::claims::{Claims, Order, Timeline};
use crate::device::electrode_array::fixture::{droplets, microparts};
use crate::diagnostic::Sink;
use crate::lower::lower;
use crate::plan::{Motion, Optimality, Plan, Planned};
use crate::schedule::Schedule;
use crate::schedule::electrode_array::ElectrodeArrayState;
use crate::source::{Sources, Span};

/// A board for four-electrode parts, or for droplets.
pub(crate) fn facts(electrodes: Electrodes) -> ElectrodeArrayFacts {
    match electrodes {
        Electrodes::Quad => ElectrodeArrayFacts { clearance: 1, ..microparts(20, 12) },
        Electrodes::Single => droplets(20, 12),
    }
}

/// The claims and the schedule of a task whose parts follow these paths in its steps; a step without paths is a wait
/// of 1 ms. Parts are called a, b, …; two parts that end on the same cell merge.
pub(crate) fn carried(facts: &ElectrodeArrayFacts, steps: &[Vec<Vec<(u32, u32)>>]) -> (Claims, Schedule) {
    let cells =
        |way: &Vec<(u32, u32)>| way.iter().map(|(column, row)| ElectrodeCell::new(*column, *row)).collect::<Vec<_>>();
    let ways: Vec<Vec<Vec<ElectrodeCell>>> = steps.iter().map(|step| step.iter().map(cells).collect()).collect();
    let first = ways.iter().find(|step| !step.is_empty()).expect("a step of moves");
    let start: Vec<Option<ElectrodeCell>> = first.iter().map(|way| way.first().copied()).collect();
    let name = |index: usize| char::from(b'a' + index as u8).to_string();
    let part = |(index, cell): (usize, &Option<ElectrodeCell>)| BoardPart {
        name: name(index),
        cell: *cell,
        span: Span::default(),
    };
    let order = ElectrodeArrayOrder {
        planner: ElectrodeArrayPlanner { method: ElectrodeArrayMethod::Portfolio, expansions: 1 },
        ..board_order(facts.clone(), start.iter().enumerate().map(part), ways.iter().map(|ways| asked(ways)).collect())
    };
    let motion = |ways: &Vec<Vec<ElectrodeCell>>| match ways.is_empty() {
        true => ElectrodeArrayStepMotion::Wait(1_000_000),
        false => ElectrodeArrayStepMotion::Paths(ways.clone()),
    };
    let plan = Plan {
        planner: "portfolio",
        objective: "makespan",
        unit: "",
        cost: 0.0,
        bound: 0.0,
        proof: Optimality::Open,
        bounds: Default::default(),
        outcomes: Default::default(),
        remarks: Vec::new(),
        motion: ElectrodeArrayMotion { start, steps: ways.iter().map(motion).collect() },
    };
    let jobs = vec![fixture::job("carry", "plate", Order::ElectrodeArray(order))];
    let claims = fixture::claims("carry", jobs, Timeline::Run(0));
    let mut sources = Sources::default();
    sources.add("carry.twz", "task carry on plate {}\n");
    let order = ElectrodeArrayOrder::of(&claims.jobs[0].order).expect("its order");
    let plan = plan.map(|motion| Motion::ElectrodeArray(Planned { order, motion }));
    let schedule = lower(&claims, &[plan], &sources, &mut Sink::default()).expect("a short schedule");
    (claims, schedule)
}

/// The step whose goals are the ends of these paths.
fn asked(ways: &[Vec<ElectrodeCell>]) -> TaskStep {
    if ways.is_empty() {
        return TaskStep { action: ElectrodeArrayAction::Wait(1_000_000), span: Span::default() };
    }
    let mut moves: Vec<ElectrodeArrayMove> = Vec::new();
    for (part, way) in ways.iter().enumerate() {
        let Some(&goal) = way.last() else { continue };
        if let Some(first) = moves.iter_mut().find(|action| action.goal().cell == goal) {
            first.with = Some(part);
        } else if way.len() > 1 {
            let stops = vec![ElectrodeArrayStop { cell: goal, span: Span::default(), origin: None }];
            moves.push(ElectrodeArrayMove::alone(part, stops, Span::default()));
        }
    }
    TaskStep { action: ElectrodeArrayAction::Move(moves), span: Span::default() }
}

/// Channel, start and end in steps of the board, of every actuation.
fn lit(schedule: &Schedule) -> Vec<(String, u64, u64)> {
    let beat_ns = 5_000_000;
    let lit = schedule.actuations.iter().map(|actuation| {
        let name = schedule.channels[actuation.channel as usize].name.clone();
        (name, actuation.start_ns / beat_ns, actuation.end_ns() / beat_ns)
    });
    lit.collect()
}

#[test]
fn a_micropart_follows_the_pairs_of_table_2_and_rests_by_itself() {
    let ways = vec![vec![vec![(5, 5), (6, 5), (6, 6), (6, 6), (5, 6), (5, 5)]]];
    let (_, schedule) = carried(&facts(Electrodes::Quad), &ways);
    let mut lit = lit(&schedule);
    lit.sort_by_key(|(name, start, _)| (*start, name.clone()));
    let expected = [
        ("plate.e7_4", 0, 1),
        ("plate.e7_6", 0, 1),
        ("plate.e5_7", 1, 2),
        ("plate.e7_7", 1, 2),
        ("plate.e4_5", 3, 4),
        ("plate.e4_7", 3, 4),
        ("plate.e4_4", 4, 5),
        ("plate.e6_4", 4, 5),
    ];
    assert_eq!(lit, expected.map(|(name, start, end)| (name.to_owned(), start, end)));
    assert!(schedule.actuations.iter().all(|actuation| (actuation.from, actuation.to) == (100.0, 100.0)));
}

#[test]
fn a_droplet_is_held_without_a_break_and_its_channels_are_those_that_are_used() {
    let ways = vec![vec![vec![(3, 3), (4, 3), (4, 3), (4, 4)], vec![(9, 9)]], vec![]];
    let (_, schedule) = carried(&facts(Electrodes::Single), &ways);
    let names: Vec<&str> = schedule.channels.iter().map(|channel| channel.name.as_str()).collect();
    assert_eq!(names, ["plate.e4_3", "plate.e4_4", "plate.e9_9"]);
    let mut of_rest = lit(&schedule);
    of_rest.retain(|(name, ..)| name == "plate.e9_9" || name == "plate.e4_3");
    assert_eq!(of_rest[0], ("plate.e4_3".to_owned(), 0, 2));
    assert_eq!(of_rest[1], ("plate.e9_9".to_owned(), 0, 3));
    assert_eq!(schedule.duration_ns, 16_000_000);
    let last = schedule.actuations.last().expect("the droplets are held while nothing moves");
    assert_eq!((last.start_ns, last.duration_ns), (15_000_000, 1_000_000));
}

#[test]
fn merged_droplets_are_one_in_the_last_state() {
    let ways = vec![vec![vec![(3, 3), (4, 3)], vec![(6, 3), (5, 3), (4, 3)]]];
    let (_, schedule) = carried(&facts(Electrodes::Single), &ways);
    let states = &schedule.plans[0].states;
    assert_eq!(states.len(), 3);
    let State::ElectrodeArray(ElectrodeArrayState { parts }) = &states[2].state else { panic!("a state of a board") };
    assert_eq!(parts.iter().collect::<Vec<_>>(), [("a", [4, 3])]);
}
