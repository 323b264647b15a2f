//! No readable schedule or claims make the verifier panic, and none take it long.

use super::*;
use crate::device::electrode_array::{ElectrodeMap, Electrodes, MAX_PARTS, MAX_PLACED_PARTS};
use crate::schedule::electrode_array::ElectrodeArrayState;
use crate::verify::tests::{UnfitOrder, each_unfit, write};
use proptest::prelude::*;

fn sound() -> (Claims, Schedule) {
    let steps = vec![
        ElectrodeArrayAction::Move(vec![merge(0, 1, (5, 5)), go(2, &[(9, 8), (9, 9)])]),
        ElectrodeArrayAction::Wait(BEAT),
        ElectrodeArrayAction::Move(vec![go(0, &[(6, 5)])]),
        ElectrodeArrayAction::Assay(vec![
            incubate(0, &[(6, 6)], 2),
            operation(merge(0, 2, (8, 8))),
            incubate(0, &[], 1),
            split(3, 0, (8, 8), (7, 8)),
            mix(0, &[], 4),
        ]),
    ];
    let parts = [("a", 3, 5), ("b", 7, 5), ("c", 9, 7), ("d", 1, 1)];
    let mut order = without_places(order(chip(14, 14), &parts, steps), &[3]);
    let bodies = [
        ElectrodeArrayObstacleBody::Electrodes { from: cell(12, 12), to: cell(13, 13) },
        ElectrodeArrayObstacleBody::Fixed(cell(2, 12)),
    ];
    order.obstacles = Arc::new(bodies.into_iter().map(|body| obstacle("dust", body)).collect());
    let claims = alone(order);
    let mut schedule =
        schedule(&claims, &[&[&["RR", "LL", "UU"], &[], &["R"], &["U..RRUU.RRULD", "", "....LD.x", "________o"]]]);
    let recorded: [(&[&str], [u64; 3]); 5] = [
        (&["a"], [0, 1, 3]),
        (&["a", "c"], [0, 7, 7]),
        (&["a"], [7, 7, 8]),
        (&["a", "d"], [8, 8, 9]),
        (&["a"], [9, 9, 13]),
    ];
    schedule.steps[3].operations = recorded.map(|(parts, beats)| assay::recorded(parts, beats)).to_vec();
    let begins_ns = schedule.steps[3].start_ns;
    for operation in &mut schedule.steps[3].operations {
        operation.start_ns += begins_ns;
        operation.arrival_ns += begins_ns;
    }
    (claims, schedule)
}

fn instant() -> impl Strategy<Value = u64> {
    let picked = vec![0, 1, u64::MAX, 1 << 40, BEAT, 2 * BEAT, 3 * BEAT];
    prop_oneof![7 => prop::sample::select(picked), 1 => any::<u64>()]
}

fn index() -> impl Strategy<Value = u32> {
    prop_oneof![4 => 0..16u32, 1 => Just(u32::MAX), 1 => any::<u32>()]
}

fn number() -> impl Strategy<Value = f64> {
    prop_oneof![Just(0.0), Just(100.0), Just(0.5), Just(f64::NAN), Just(f64::INFINITY), Just(-1e308), any::<f64>()]
}

/// Writes an arbitrary value to one field of a schedule.
fn spoiled(schedule: &mut Schedule, what: u8, at: usize, value: u64, small: u32) {
    let Schedule { duration_ns, channels, actuations, steps, plans, .. } = schedule;
    match what {
        0 => *duration_ns = value,
        1 => write(steps, at, |step| step.duration_ns = value),
        2 => write(steps, at, |step| step.start_ns = value),
        3 => write(plans, at, |plan| plan.duration_ns = value),
        4 => write(actuations, at, |actuation| actuation.duration_ns = value),
        5 => write(actuations, at, |actuation| actuation.start_ns = value),
        6 => write(actuations, at, |actuation| actuation.channel = small),
        7 => write(actuations, at, |actuation| actuation.step = small),
        8 => write(channels, at, |channel| channel.name = format!("board.e{small}_{}", at + 1)),
        9 => plans.iter_mut().for_each(|plan| plan.states.truncate(at)),
        10 => write(steps, 3, |step| write(&mut step.operations, at, |own| own.start_ns = value)),
        11 => write(steps, 3, |step| write(&mut step.operations, at, |own| own.duration_ns = value)),
        12 => drop((at < actuations.len()).then(|| actuations.remove(at))),
        _ => write(plans, 0, |plan| {
            write(&mut plan.states, at, |state| {
                let State::ElectrodeArray(ElectrodeArrayState { parts }) = &mut state.state else { return };
                parts.set("a", Some([small, at as u32]));
            });
        }),
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 4000, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn spoiled_schedules_are_judged(
        spoils in prop::collection::vec(((0..14u8, 0..12usize), instant(), index()), 1..6),
        sorts: bool,
    ) {
        let (claims, mut schedule) = sound();
        for ((what, at), value, small) in spoils {
            spoiled(&mut schedule, what, at, value, small);
        }
        if sorts {
            schedule.actuations.sort_by_key(|actuation| (actuation.start_ns, actuation.channel));
        }
        verify(schedule, &claims);
    }

    #[test]
    fn a_long_clock_takes_no_time(step_ns in instant(), lasts_ns in instant(), nth in 0..3usize) {
        let (mut claims, mut schedule) = sound();
        order_of(&mut claims, 0).facts.step_ns = step_ns;
        let end_ns = |schedule: &Schedule, at: usize| schedule.steps[at].start_ns.saturating_add(schedule.steps[at].duration_ns);
        schedule.steps[nth].duration_ns = lasts_ns;
        for later in nth + 1..3 {
            schedule.steps[later].start_ns = end_ns(&schedule, later - 1);
        }
        schedule.duration_ns = end_ns(&schedule, 2);
        schedule.plans[0].duration_ns = schedule.duration_ns;
        verify(schedule, &claims);
    }

    #[test]
    fn random_claims_are_judged(
        cells in prop::collection::vec((index(), index()), 8),
        numbers in prop::collection::vec(number(), 4),
        (columns, rows, separation, clearance) in (index(), index(), index(), index()),
        (part, with) in (0..5usize, prop::option::of(0..5usize)),
        (is_quad, is_held, yields) in any::<(bool, bool, bool)>(),
    ) {
        let (mut claims, schedule) = sound();
        let order = order_of(&mut claims, 0);
        let cells: Vec<_> = cells.into_iter().map(|(column, row)| cell(column, row)).collect();
        (order.facts.columns, order.facts.rows, order.facts.clearance) = (columns, rows, clearance);
        order.facts.separation = Separation::Apart(separation);
        (order.facts.potential_v, order.facts.layout.half_width_pitches) = (numbers[0], numbers[1]);
        (order.facts.radius_um, order.facts.pitch_ratio) = (numbers[2], numbers[3]);
        order.facts.layout.electrodes = if is_quad { Electrodes::Quad } else { Electrodes::Single };
        order.facts.hold = if is_held { Hold::On } else { Hold::Off };
        order.bystanders = if yields { Bystanders::Yield } else { Bystanders::Stay };
        let parts = Arc::make_mut(&mut order.parts);
        parts.iter_mut().zip(&cells).for_each(|(part, cell)| part.cell = Some(*cell));
        let bodies = [ElectrodeArrayObstacleBody::Electrodes { from: cells[3], to: cells[4] }, ElectrodeArrayObstacleBody::Fixed(cells[5])];
        order.obstacles = Arc::new(bodies.into_iter().map(|body| obstacle("dust", body)).collect());
        let ElectrodeArrayAction::Move(moves) = &mut order.steps[0].action else { panic!("a step of moves") };
        (moves[1].part, moves[1].with, moves[1].stops[0].cell) = (part, with, cells[6]);
        verify(schedule, &claims);
    }
}

#[test]
fn claims_that_no_program_has_are_inconclusive() {
    let (claims, schedule) = sound();
    fn moves(order: &mut ElectrodeArrayOrder) -> &mut Vec<ElectrodeArrayMove> {
        let ElectrodeArrayAction::Move(moves) = &mut order.steps[0].action else { panic!("a step of moves") };
        moves
    }
    let cases: &[UnfitOrder<ElectrodeArrayOrder>] = &[
        ("no electrode", |order| order.facts.columns = 0),
        ("too many", |order| order.facts.rows = 1_001),
        ("not finite", |order| order.facts.radius_um = f64::NAN),
        ("potential that is not above 0", |order| order.facts.potential_v = 0.0),
        ("step of zero duration", |order| order.facts.step_ns = 0),
        ("body with a size out of range", |order| order.facts.layout.half_width_pitches = -0.1),
        ("map of another board", |order| {
            let map = ElectrodeMap { columns: 5, channels: vec![Some(1); 7], disabled: Vec::new() };
            order.facts.map = Some(Arc::new(map));
        }),
        ("a clearance below 1", |order| order.facts.clearance = 0),
        ("separation out of range", |order| order.facts.separation = Separation::Apart(0)),
        ("separation out of range", |order| order.facts.separation = Separation::Apart(1_001)),
        ("two parts with the same name", |order| Arc::make_mut(&mut order.parts)[1].name = "a".into()),
        ("not all on the board", |order| Arc::make_mut(&mut order.parts)[1].cell = Some(cell(15, 5))),
        ("not all on the board", |order| Arc::make_mut(&mut order.parts)[1].cell = Some(cell(0, 5))),
        ("too many parts", |order| {
            let part = order.parts[0].clone();
            let many = (0..=MAX_PLACED_PARTS)
                .map(|at| crate::claims::electrode_array::BoardPart { name: at.to_string(), ..part.clone() });
            order.parts = Arc::new(many.collect());
        }),
        ("too many parts", |order| {
            let part = crate::claims::electrode_array::BoardPart { cell: None, ..order.parts[0].clone() };
            let many = (0..=MAX_PARTS)
                .map(|at| crate::claims::electrode_array::BoardPart { name: at.to_string(), ..part.clone() });
            order.parts = Arc::new(many.collect());
        }),
        ("obstacle without electrodes", |order| {
            order.obstacles = Arc::new(vec![obstacle(
                "dust",
                ElectrodeArrayObstacleBody::Electrodes { from: cell(5, 5), to: cell(4, 9) },
            )]);
        }),
        ("do not have", |order| moves(order)[1].part = 4),
        ("do not have", |order| moves(order)[0].with = Some(4)),
        ("does not have", |order| moves(order)[1].stops[0].cell = cell(15, 1)),
        ("twice", |order| moves(order)[0].with = Some(0)),
        ("twice", |order| moves(order)[1].part = 1),
        ("without a goal", |order| moves(order)[1].stops.clear()),
        ("other stops", |order| moves(order)[0].stops = go(0, &[(4, 5), (5, 5)]).stops),
        ("more than go", |order| moves(order)[0].team = Some(0)),
        ("more than go", |order| moves(order)[1].team = Some(0)),
        ("one goal twice", |order| {
            moves(order)[0] = ElectrodeArrayMove { team: Some(0), ..go(0, &[(4, 5)]) };
            moves(order)[1] = ElectrodeArrayMove { team: Some(0), ..go(2, &[(4, 5)]) };
        }),
        ("not droplets", |order| order.facts.layout.electrodes = Electrodes::Quad),
    ];
    each_unfit((&schedule, &claims), order_of, cases);
}

#[test]
fn the_parts_of_a_device_are_the_same_in_all_its_runs() {
    let task = |name| order(chip(9, 9), &[(name, 5, 5)], vec![ElectrodeArrayAction::Wait(5)]);
    let claims = in_turn(vec![task("a"), task("b")]);
    let schedule = schedule(&claims, &[&[&[]], &[&[]]]);
    assert_eq!(
        why(&schedule, &claims).as_deref(),
        Some("the claims have two different sets of parts on the device `board`")
    );
}

/// The largest size that the planner is designed for: 400 parts, 400 by 400 electrodes, 300 steps of the board.
#[test]
fn a_large_schedule_is_followed() {
    let word: String = "RRRUUULLLDDD".chars().cycle().take(300).collect();
    let names: Vec<String> = (0..400).map(|part| format!("part{part}")).collect();
    let place = |part: u32| (10 + 6 * (part % 20), 10 + 6 * (part / 20));
    let parts: Vec<(&str, u32, u32)> =
        (0..400).zip(&names).map(|(part, name)| (name.as_str(), place(part).0, place(part).1)).collect();
    let goals = (0..400).map(|part| go(part as usize, &[place(part)])).collect();
    let words = vec![word.as_str(); 400];
    let (schedule, claims) = one_step(moving(platform(400, 400), &parts, goals), &words);
    assert_eq!(schedule.actuations.len(), 240_000);
    passes(&schedule, &claims);
}
