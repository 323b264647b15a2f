//! No readable schedule or claims make the verifier panic.

use super::*;
use crate::claims::Claims;
use crate::claims::fingers::Section;
use crate::geometry::outline::Outline;
use crate::verify::tests::{UnfitOrder, each_unfit, why, write};
use proptest::prelude::*;

fn instant() -> impl Strategy<Value = u64> {
    prop_oneof![Just(0), Just(1), Just(u64::MAX), Just(1 << 40), Just(100 * MS), Just(1 << 62), any::<u64>()]
}

fn index() -> impl Strategy<Value = u32> {
    prop_oneof![4 => 0..9u32, 1 => Just(u32::MAX), 1 => any::<u32>()]
}

fn number() -> impl Strategy<Value = f64> {
    prop_oneof![
        4 => -60.0..60.0f64,
        5 => prop::sample::select(vec![0.0, 1e-300, f64::NAN, f64::INFINITY, -1e308]),
        1 => any::<f64>()
    ]
}

/// Two fingers grasp the bead and roll it by one step.
fn sound() -> (Schedule, Claims) {
    let day = Day::new(order()).step(FingersAction::Grasp(None)).come(0, 1).come(1, 38).record();
    day.rotate(Plane::Xy, 1).roll(1).step(FingersAction::Release).go(0).go(1).record().both()
}

/// Writes an arbitrary value to one field of a schedule.
fn spoiled(schedule: &mut Schedule, what: u8, at: usize, value: u64, small: u32, number: f64) {
    let Schedule { duration_ns, channels, actuations, steps, plans, .. } = schedule;
    match what {
        0 => *duration_ns = value,
        1 => write(steps, at, |step| step.duration_ns = value),
        2 => write(plans, at, |plan| plan.duration_ns = value),
        3 => write(actuations, at, |line| line.duration_ns = value),
        4 => write(actuations, at, |line| line.start_ns = value),
        5 => write(actuations, at, |line| line.channel = small),
        6 | 7 => write(actuations, at, |line| line.from = number),
        8 => drop((at < actuations.len()).then(|| actuations.remove(at))),
        9 => write(channels, at, |channel| channel.name = format!("hand.f{small}.x")),
        10 => plans.iter_mut().for_each(|plan| plan.states.truncate(at % 5)),
        _ => write(plans, 0, |plan| {
            write(&mut plan.states, at, |timed| {
                let State::Fingers(state) = &mut timed.state else { return };
                (state.position_um[0], state.orientation[1], state.angle_index) = (number, number, value as i64);
                state.grasp.resize(small as usize % 9, small);
                state.tips_um.truncate(small as usize % 9);
            });
        }),
    }
}

/// Moves whole tips where two lines meet, so that axes stay continuous.
fn shaken(schedule: &mut Schedule, shakes: &[(u32, u32, usize, f64)]) {
    for (finger, axis, line, by_um) in shakes {
        let count = lines(schedule, finger % 3, axis % 3).len();
        shift(schedule, finger % 3, axis % 3, line % (count - 1), *by_um);
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 100, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn spoiled_schedules_are_judged(
        spoils in prop::collection::vec(((0..12u8, 0..400usize), instant(), index(), number()), 1..5),
        sorts: bool,
    ) {
        let (mut schedule, claims) = sound();
        for ((what, at), value, small, number) in spoils {
            spoiled(&mut schedule, what, at, value, small, number);
        }
        if sorts {
            schedule.actuations.sort_by_key(|line| (line.start_ns, line.channel));
        }
        verify(schedule, &claims);
    }

    /// Tips move to arbitrary positions.
    #[test]
    fn shaken_tips_are_judged(shakes in prop::collection::vec((0..3u32, 0..3u32, 0..100usize, -40.0..40.0f64), 1..6)) {
        let (mut schedule, claims) = sound();
        shaken(&mut schedule, &shakes);
        verify(schedule, &claims);
    }

    #[test]
    fn random_facts_are_judged(
        numbers in prop::collection::vec(number(), 12),
        (fingers, steps_per_turn, contacts) in (index(), index(), index()),
        turns in prop::collection::vec(number(), 8),
    ) {
        let (schedule, mut claims) = sound();
        let order = order_of(&mut claims, 0);
        let facts = Arc::make_mut(&mut order.facts);
        for (at, number) in numbers.into_iter().enumerate() {
            match at {
                0 if fingers > 4 => facts.tip_radius_um = number,
                1 => facts.pull_off_un = number.abs(),
                2 => facts.max_force_un = number.abs(),
                3 => facts.friction = number.abs(),
                4 => facts.removal_safety = number.abs(),
                5 => facts.clearance_um = number.abs() / 60.0,
                6 => facts.retract_um = number.abs(),
                7 => facts.tolerance_um = number.abs() / 600.0,
                8 => facts.support_un = number.abs(),
                9 => order.load_un[0] = number,
                10 => order.load_un[2] = number,
                _ => order.precision_rad = number.abs(),
            }
        }
        facts.fingers = if fingers < 5 { 3 } else { fingers };
        facts.steps_per_turn = steps_per_turn;
        order.steps[1].action = FingersAction::Orient { goal: [turns[0], turns[1], turns[2], turns[3]], turns: Vec::new(), left_out_steps: None };
        let part = Arc::make_mut(&mut order.part);
        part.centre_um = [turns[4], turns[5], turns[6]];
        if contacts > 4 {
            part.xy.contacts = contacts;
        }
        if contacts == 5 {
            part.xy.outline = Outline::Ellipse { semi_um: [turns[7], turns[0]] };
        }
        verify(schedule, &claims);
    }
}

fn facts_of(order: &mut FingersOrder) -> &mut FingersFacts {
    Arc::make_mut(&mut order.facts)
}

fn part_of(order: &mut FingersOrder) -> &mut crate::claims::fingers::HandPart {
    Arc::make_mut(&mut order.part)
}

/// Claims that no program has, with part of the reason.
const UNFIT: &[UnfitOrder<FingersOrder>] = &[
    ("too few or too many fingers", |order| facts_of(order).fingers = 2),
    ("too few or too many fingers", |order| facts_of(order).fingers = 7),
    ("steps per turn", |order| facts_of(order).steps_per_turn = 0),
    ("steps per turn", |order| facts_of(order).steps_per_turn = 361),
    ("not above 0", |order| facts_of(order).tip_radius_um = 0.0),
    ("not above 0", |order| facts_of(order).tolerance_um = f64::NAN),
    ("not above 0", |order| facts_of(order).range_um[2] = -1.0),
    ("not above 0", |order| facts_of(order).friction = f64::INFINITY),
    ("out of range", |order| facts_of(order).removal_safety = -1.0),
    ("out of range", |order| facts_of(order).support_un = f64::NAN),
    ("out of range", |order| facts_of(order).torsion_um = -0.1),
    ("out of range", |order| facts_of(order).rolling_reserve = 1.0),
    ("a place or a load", |order| order.load_un[1] = f64::NAN),
    ("a place or a load", |order| part_of(order).position_um[1] = 1e10),
    ("a precision", |order| order.precision_rad = -0.1),
    ("too few or too many contacts", |order| part_of(order).xy.contacts = 2),
    ("too few or too many contacts", |order| {
        part_of(order).xz = Some(Section { contacts: 513, ..order.part.xy.clone() })
    }),
    ("a step between contacts", |order| part_of(order).xy.step_rad = 0.0),
    ("one turn round", |order| part_of(order).xy.step_rad *= 1.000_01),
    ("one turn round", |order| facts_of(order).tip_radius_um = 4.6),
    ("cannot be followed", |order| {
        part_of(order).xy.outline = Outline::Spline { points_um: vec![[1.0, 0.0]] };
    }),
    ("the device's step apart", |order| facts_of(order).steps_per_turn = 20),
    ("an opposite contact that does not exist", |order| part_of(order).xy.opposite = Some(75)),
    ("off the x axis", |order| part_of(order).xy.opposite = Some(37)),
    ("another number of fingers", |order| order.steps[0].action = FingersAction::Grasp(Some(vec![1, 38]))),
    ("with too few or too many fingers", |order| order.steps[0].action = FingersAction::Grasp(Some(vec![1, 0, 0]))),
    ("at a contact that does not exist", |order| order.steps[0].action = FingersAction::Grasp(Some(vec![1, 75, 0]))),
    ("an angle out of range", |order| {
        order.steps[1].action = FingersAction::Rotate { plane: Plane::Xy, steps: 1, angle_rad: f64::NAN };
    }),
    ("no outline", |order| {
        part_of(order).xz = None;
        order.steps[1].action = FingersAction::Rotate { plane: Plane::Xz, steps: 1, angle_rad: 0.3 };
    }),
    ("not an orientation", |order| {
        order.steps[1].action =
            FingersAction::Orient { goal: [0.5; 4].map(|x| x * 1.1), turns: vec![], left_out_steps: None }
    }),
    ("a distance out of range", |order| order.steps[1].action = FingersAction::Translate([f64::INFINITY, 0.0, 0.0])),
];

#[test]
fn claims_that_no_program_has_are_inconclusive() {
    let (schedule, claims) = sound();
    each_unfit((&schedule, &claims), order_of, UNFIT);
}

/// A run has other facts, or another part, on the same device.
#[test]
fn a_hand_has_one_set_of_facts_and_one_part() {
    let because = |edit: fn(&mut FingersOrder), expected: &str| {
        let first = Day::new(order()).step(FingersAction::Wait(1)).still(1);
        let second = first.after(order()).step(FingersAction::Wait(1)).still(1);
        let mut claims = in_turn(vec![first.order.clone(), second.order.clone()]);
        let schedule = schedule(&claims, &[first, second]);
        passes(&schedule, &claims);
        edit(order_of(&mut claims, 1));
        assert_eq!(why(&schedule, &claims).as_deref(), Some(expected));
    };
    because(
        |order| facts_of(order).friction = 0.4,
        "the claims have two different sets of facts about the device `hand`",
    );
    because(
        |order| part_of(order).position_um[0] = 0.0,
        "the claims have two different sets of parts on the device `hand`",
    );
}
