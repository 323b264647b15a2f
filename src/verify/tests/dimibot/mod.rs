use super::*;
use crate::claims::Timeline;
use crate::claims::dimibot::{Asked, DimibotAction, DimibotObstacle, DimibotStop};
use crate::device::dimibot::{DimibotFacts, LatticeCell, Side, Simultaneous};
use crate::geometry::shape::{Pose, Shape};
use crate::source::{Span, Spanned};
use build::*;

pub(super) mod build;
mod garbage;
mod mutants;
mod shared_scene;

/// Far less than a planner's margin for errors in shapes, far more than rounding.
const HAIR_UM: f64 = 1e-9;

/// Two moves: first bl0 and bl1, then br1.
fn moves() -> Claims {
    alone(order(facts(3, 3), vec![go(&[(3, 0)]), go(&[(3, 2)])]))
}

const MOVES: Pulses = &[&[&["bl0.set", "bl1.set"], &["br1.set"]]];

/// Delays everything from an instant on by `by_ns`, or advances it if `by_ns` is negative. An actuation that spans the
/// instant is stretched.
fn slide(schedule: &mut Schedule, from_ns: u64, by_ns: i64) {
    let moved = |at_ns: &mut u64| {
        if *at_ns >= from_ns {
            *at_ns = at_ns.checked_add_signed(by_ns).expect("an instant on the clock");
        }
    };
    let span = |start_ns: &mut u64, duration_ns: &mut u64| {
        let mut end_ns = *start_ns + *duration_ns;
        moved(start_ns);
        moved(&mut end_ns);
        *duration_ns = end_ns - *start_ns;
    };
    moved(&mut schedule.duration_ns);
    schedule.actuations.iter_mut().for_each(|actuation| moved(&mut actuation.start_ns));
    schedule.steps.iter_mut().for_each(|step| span(&mut step.start_ns, &mut step.duration_ns));
    schedule.plans.iter_mut().for_each(|plan| span(&mut plan.start_ns, &mut plan.duration_ns));
}

/// The moves after an edit, with true records.
fn edited(edit: impl Fn(&mut Schedule)) -> (Schedule, Claims) {
    let claims = moves();
    let mut schedule = schedule(&claims, MOVES);
    edit(&mut schedule);
    record(&mut schedule, &claims);
    (schedule, claims)
}

#[track_caller]
fn edited_breaks(rule: Rule, edit: impl Fn(&mut Schedule)) {
    let (schedule, claims) = edited(edit);
    only(rule, &schedule, &claims);
}

#[test]
fn the_moves_are_sound() {
    passes(&schedule(&moves(), MOVES), &moves());
}

#[test]
fn a_pulse_is_that_of_the_device() {
    edited_breaks(Rule::Pulse, |s| s.actuations[1].from = 20.000_000_1);
    edited_breaks(Rule::Pulse, |s| s.actuations[1].to = 19.999_999_9);
    edited_breaks(Rule::Pulse, |s| s.actuations[2].to = -20.0);
    edited_breaks(Rule::Pulse, |s| s.actuations[0].duration_ns += 1);
    edited_breaks(Rule::Pulse, |s| s.actuations[2].duration_ns -= 1);
}

#[test]
fn a_rest_is_over_before_the_next_pulse_and_the_end() {
    edited_breaks(Rule::Rest, |s| slide(s, 20 * MS, -1));
    edited_breaks(Rule::Rest, |s| slide(s, 40 * MS, -1));
    edited_breaks(Rule::Rest, |s| slide(s, 60 * MS, -1));
    edited_breaks(Rule::Rest, |s| slide(s, 20 * MS, -5 * MS as i64));
    let mut restless = moves();
    order_of(&mut restless, 0).facts.rest_ns = 0;
    passes(&schedule(&restless, MOVES), &restless);
}

#[test]
fn two_pulses_that_overlap_in_part_have_no_rest() {
    edited_breaks(Rule::Rest, |s| slide(s, 20 * MS, -10 * MS as i64));
}

#[test]
fn no_time_is_lost_in_a_move() {
    edited_breaks(Rule::Idle, |s| slide(s, 20 * MS, 1));
    edited_breaks(Rule::Idle, |s| slide(s, 60 * MS, 1));
    edited_breaks(Rule::Idle, |s| {
        slide(s, 40 * MS, 1);
        s.steps[0].duration_ns -= 1;
        s.steps[1].start_ns -= 1;
        s.steps[1].duration_ns += 1;
    });
    let still = alone(order(facts(3, 3), vec![go(&[(0, 0)])]));
    let mut late = schedule(&still, &[&[&[]]]);
    passes(&late, &still);
    (late.duration_ns, late.plans[0].duration_ns, late.steps[0].duration_ns) = (1, 1, 1);
    record(&mut late, &still);
    only(Rule::Idle, &late, &still);
}

#[test]
fn a_wait_is_quiet_and_as_long_as_claimed() {
    let claimed = |duration_ns| alone(order(facts(3, 3), vec![go(&[(1, 0)]), DimibotAction::Wait(duration_ns)]));
    let quiet: Pulses = &[&[&["bl0.set"], &[]]];
    let sound = schedule(&claimed(40 * MS), quiet);
    passes(&sound, &claimed(40 * MS));
    only(Rule::Wait, &sound, &claimed(40 * MS - 1));
    only(Rule::Wait, &sound, &claimed(40 * MS + 1));
    let nothing = schedule(&claimed(0), quiet);
    passes(&nothing, &claimed(0));
    let loud = schedule(&claimed(40 * MS), &[&[&["bl0.set"], &["br0.set", "br0.reset"]]]);
    only(Rule::Wait, &loud, &claimed(40 * MS));
}

#[test]
fn a_module_is_not_set_and_reset_at_once() {
    let claims = moves();
    let torn = schedule(&claims, &[&[&["bl0.set br2.set br2.reset", "bl1.set"], &["br1.set"]]]);
    only(Rule::Opposed, &torn, &claims);
}

#[test]
fn a_pulse_does_something() {
    let claims = moves();
    only(Rule::Switch, &schedule(&claims, &[&[&["bl0.set", "bl0.set", "bl1.set"], &["br1.set"]]]), &claims);
    only(Rule::Switch, &schedule(&claims, &[&[&["br0.reset", "bl0.set", "bl1.set"], &["br1.set"]]]), &claims);
    passes(&schedule(&claims, &[&[&["br0.set", "br0.reset", "bl0.set", "bl1.set"], &["br1.set"]]]), &claims);
}

#[test]
fn one_module_at_a_time_unless_safe() {
    let pulses: Pulses = &[&[&["bl0.set bl1.set"], &["br1.set"]]];
    let mut claims = moves();
    only(Rule::Simultaneous, &schedule(&claims, pulses), &claims);
    order_of(&mut claims, 0).simultaneous = Simultaneous::Safe;
    passes(&schedule(&claims, pulses), &claims);
    order_of(&mut claims, 0).simultaneous = Simultaneous::Never;
    order_of(&mut claims, 0).facts.simultaneous = Simultaneous::Safe;
    only(Rule::Simultaneous, &schedule(&claims, pulses), &claims);
}

/// Claims of one move among obstacles.
fn among(from: (u32, u32), to: (u32, u32), obstacles: Vec<DimibotObstacle>) -> Claims {
    let mut order = order(facts(3, 3), vec![go(&[to])]);
    order.start = Some(Spanned::new(cell(from.0, from.1), Span::default()));
    order.simultaneous = Simultaneous::Safe;
    order.obstacles = obstacles.into();
    alone(order)
}

fn turned(shape: Shape, x_um: f64, y_um: f64, degrees: f64) -> DimibotObstacle {
    let mut obstacle = solid("bead", shape, 0.0, 0.0);
    let pose = Pose { x_um, y_um, heading_rad: degrees.to_radians() };
    if let crate::claims::dimibot::DimibotObstacleBody::Solid { pose: own, .. } = &mut obstacle.body {
        *own = pose;
    }
    obstacle
}

/// A plate with a slot from the top, 0.4 um wide about x = 0 and down to y = -1.
fn slotted() -> Shape {
    let corners =
        [(-2.0, -2.0), (2.0, -2.0), (2.0, 2.0), (0.2, 2.0), (0.2, -1.0), (-0.2, -1.0), (-0.2, 2.0), (-2.0, 2.0)];
    Shape::Polygon { points_um: corners.map(|(x, y)| [x, y]).to_vec() }
}

#[test]
fn a_sweep_keeps_its_gap_from_every_shape() {
    let length_um = 4.0 * facts(3, 3).pitch_um(Side::Left);
    let half_diagonal = 0.5f64.sqrt();
    let square = || Shape::Box { size_um: [1.0, 1.0] };
    let capsule = || Shape::Capsule { length_um: 2.0, radius_um: 0.25 };
    let disc = || Shape::Disc { radius_um: 0.5 };
    // Shapes beside the path along x: angle, position along the path, and extent below the origin.
    let beside = [
        (Shape::Point, 0.0, 3.0, 0.0),
        (disc(), 0.0, 3.0, 0.5),
        (square(), 0.0, 3.0, 0.5),
        (square(), 45.0, 3.0, half_diagonal),
        (capsule(), 0.0, 3.0, 0.25),
        (capsule(), 90.0, 3.0, 1.25),
        (capsule(), 30.0, 3.0, 0.5 + 0.25),
        (slotted(), 0.0, 3.0, 2.0),
        (slotted(), 180.0, 3.0, 2.0),
        (square(), 0.0, length_um + 0.4, 0.5),
    ];
    for (shape, degrees, x_um, reach_um) in beside {
        let at = |gap_um: f64| among((0, 0), (4, 0), vec![turned(shape.clone(), x_um, reach_um + gap_um, degrees)]);
        assert_gap(at, &format!("{shape:?} turned by {degrees}"));
    }
    // The same at the end of the path.
    for (shape, degrees, reach_um) in [(disc(), 0.0, 0.5), (square(), 45.0, half_diagonal), (capsule(), 0.0, 1.25)] {
        let at = |gap_um: f64| {
            among((0, 0), (4, 0), vec![turned(shape.clone(), length_um + reach_um + gap_um, 0.0, degrees)])
        };
        assert_gap(at, &format!("{shape:?} at the end"));
    }
}

/// Asserts that a gap just above tip radius plus repeatability passes, and that a smaller one breaks one rule.
#[track_caller]
fn assert_gap(at: impl Fn(f64) -> Claims, name: &str) {
    let pulses: Pulses = &[&[&["bl2.set"]]];
    for (gap_um, expected) in [(0.1 + HAIR_UM, vec![]), (0.1 - HAIR_UM, vec![Rule::Sweep]), (0.0, vec![Rule::Sweep])] {
        let claims = at(gap_um);
        assert_eq!(rules(&schedule(&claims, pulses), &claims), expected, "{name}, gap {gap_um}");
    }
}

#[test]
fn the_way_may_lead_into_a_slot() {
    let length_um = 4.0 * facts(3, 3).pitch_um(Side::Right);
    let into_slot = |x_um: f64| among((0, 4), (0, 0), vec![solid("plate", slotted(), x_um, 1.0 - 0.1 - HAIR_UM)]);
    let down: Pulses = &[&[&["br2.reset"]]];
    assert!(length_um > 3.0);
    passes(&schedule(&into_slot(0.0), down), &into_slot(0.0));
    passes(&schedule(&into_slot(0.1 - HAIR_UM), down), &into_slot(0.1 - HAIR_UM));
    only(Rule::Sweep, &schedule(&into_slot(0.1 + HAIR_UM), down), &into_slot(0.1 + HAIR_UM));
    only(Rule::Sweep, &schedule(&into_slot(-0.1 - HAIR_UM), down), &into_slot(-0.1 - HAIR_UM));
}

#[test]
fn a_sweep_within_a_body_touches_it() {
    let middle_um = 2.0 * facts(3, 3).pitch_um(Side::Left);
    for shape in [Shape::Box { size_um: [50.0, 50.0] }, Shape::Disc { radius_um: 20.0 }] {
        let claims = among((0, 0), (4, 0), vec![solid("slab", shape, middle_um, 1.0)]);
        only(Rule::Sweep, &schedule(&claims, &[&[&["bl2.set"]]]), &claims);
    }
}

#[test]
fn cells_block_what_passes_or_ends_there() {
    let cases = [
        ((2, 3), (2, 3), true),
        ((1, 3), (1, 3), true),
        ((5, 3), (5, 3), true),
        ((0, 3), (0, 3), false),
        ((6, 3), (7, 3), false),
        ((3, 2), (3, 2), false),
        ((3, 4), (3, 7), false),
        ((0, 0), (1, 3), true),
        ((5, 3), (7, 7), true),
        ((0, 0), (7, 2), false),
    ];
    for (from, to, blocked) in cases {
        let claims = among((1, 3), (5, 3), vec![cells("dust", from, to)]);
        let expected = if blocked { vec![Rule::Sweep] } else { vec![] };
        assert_eq!(rules(&schedule(&claims, &[&[&["bl2.set"]]]), &claims), expected, "{from:?} to {to:?}");
    }
}

#[test]
fn the_edges_that_the_paper_deletes_are_refused() {
    let steps =
        [((1, 1), (2, 1)), ((1, 1), (3, 1)), ((0, 1), (1, 1)), ((1, 0), (1, 1)), ((1, 1), (1, 3)), ((1, 0), (1, 2))];
    let mut deleted = 0;
    for from in 0..16 {
        for module in 0..4 {
            let facts = facts(2, 2);
            let to = from ^ (1 << module);
            let name = format!("{}.{}", ["br0", "br1", "bl0", "bl1"][module], if to > from { "set" } else { "reset" });
            let mut order = order(
                facts.clone(),
                vec![DimibotAction::Move(vec![DimibotStop { cell: facts.cell(to), ..stop(0, 0) }])],
            );
            order.start = Some(Spanned::new(facts.cell(from), Span::default()));
            order.obstacles = vec![cells("dust", (1, 2), (1, 2))].into();
            let claims = alone(order);
            deleted += rules(&schedule(&claims, &[&[&[&name]]]), &claims).len();
        }
    }
    // Obstacle 6 of N = 2 deletes 2-6, 2-10, 4-6, 5-7, 6-7 and 6-14, each in both directions.
    assert_eq!(deleted, 2 * steps.len());
}

#[test]
fn the_tip_stands_clear_even_without_a_move() {
    let disc = |radius_um| vec![solid("bead", Shape::Disc { radius_um }, 1.0, 0.0)];
    let still: Pulses = &[&[&[]]];
    let touched = among((0, 0), (0, 0), disc(0.9 + HAIR_UM));
    only(Rule::Sweep, &schedule(&touched, still), &touched);
    let clear = among((0, 0), (0, 0), disc(0.9 - HAIR_UM));
    passes(&schedule(&clear, still), &clear);
}

/// Touching exactly counts as touching: these numbers have no rounding.
#[test]
fn a_gap_of_just_the_growth_is_too_small() {
    let apart = |radius_um: f64| {
        let mut claims = among((0, 0), (0, 0), vec![solid("bead", Shape::Disc { radius_um }, 1.0, 0.0)]);
        let Order::Dimibot(order) = &mut claims.jobs[0].order else { panic!("a robot") };
        (order.facts.tip_radius_um, order.facts.repeatability_um) = (0.25, 0.25);
        rules(&schedule(&claims, &[&[&[]]]), &claims)
    };
    assert_eq!(apart(0.5), [Rule::Sweep]);
    assert_eq!(apart(0.5 - f64::EPSILON), []);
}

#[test]
fn modules_switched_at_once_need_the_whole_rectangle() {
    let facts = facts(3, 3);
    let (wide_um, high_um) = (4.0 * facts.pitch_um(Side::Left), 2.0 * facts.pitch_um(Side::Right));
    let both: Pulses = &[&[&["bl2.set br1.set"]]];
    let one_by_one: Pulses = &[&[&["bl2.set", "br1.set"]]];
    let check = |shape: Shape, x_um: f64, y_um: f64, expected: &[Rule]| {
        let claims = among((0, 0), (4, 2), vec![solid("bead", shape.clone(), x_um, y_um)]);
        assert_eq!(rules(&schedule(&claims, both), &claims), expected, "{shape:?} at {x_um}, {y_um}");
    };
    let disc = || Shape::Disc { radius_um: 0.5 };
    check(disc(), wide_um / 2.0, high_um / 2.0, &[Rule::Mixture]);
    check(Shape::Point, wide_um / 2.0, high_um / 2.0, &[Rule::Mixture]);
    check(Shape::Capsule { length_um: 1.0, radius_um: 0.0 }, wide_um / 2.0, high_um / 2.0, &[Rule::Mixture]);
    check(Shape::Box { size_um: [0.1, 0.1] }, wide_um / 2.0, high_um / 2.0, &[Rule::Mixture]);
    check(Shape::Disc { radius_um: 30.0 }, wide_um + 29.0, 0.0, &[Rule::Mixture]);
    check(disc(), wide_um / 2.0, high_um + 0.6 - HAIR_UM, &[Rule::Mixture]);
    check(disc(), wide_um / 2.0, high_um + 0.6 + HAIR_UM, &[]);
    let corner_um = (0.6 + HAIR_UM) * 0.5f64.sqrt();
    check(disc(), wide_um + corner_um, high_um + corner_um, &[]);
    let corner_um = (0.6 - HAIR_UM) * 0.5f64.sqrt();
    check(disc(), wide_um + corner_um, high_um + corner_um, &[Rule::Mixture]);
    let claims = among((0, 0), (4, 2), vec![solid("bead", disc(), wide_um / 2.0, high_um / 2.0)]);
    passes(&schedule(&claims, one_by_one), &claims);
}

#[test]
fn partial_strokes_of_one_side_reach_beyond_both_ends() {
    let cases = [((0, 0), true), ((3, 0), true), ((1, 0), true), ((4, 0), false), ((0, 1), false), ((3, 1), false)];
    for (at, blocked) in cases {
        let claims = among((1, 0), (2, 0), vec![cells("dust", at, at)]);
        let mut expected = if blocked { vec![Rule::Mixture] } else { vec![] };
        if at == (1, 0) {
            expected.insert(0, Rule::Sweep);
        }
        assert_eq!(rules(&schedule(&claims, &[&[&["bl0.reset bl1.set"]]]), &claims), expected, "{at:?}");
    }
}

/// Two runs of one device, the second with a `start at`.
fn two_runs(first: Option<LatticeCell>, second: Option<LatticeCell>) -> Claims {
    let spanned = |cell: Option<LatticeCell>| cell.map(|cell| Spanned::new(cell, Span::default()));
    let mut there = order(facts(3, 3), vec![go(&[(3, 1)])]);
    let mut back = order(facts(3, 3), vec![go(&[(3, 0)])]);
    (there.start, back.start) = (spanned(first), spanned(second));
    (there.facts.home, back.facts.home) = (cell(2, 1), cell(2, 1));
    let timeline = Timeline::Sequence(vec![Timeline::Run(0), Timeline::Run(1)]);
    claims(vec![job("there", "bot", there), job("back", "bot", back)], timeline)
}

#[test]
fn a_device_starts_where_it_stands() {
    let pulses: Pulses = &[&[&["bl0.set"]], &[&["br0.reset"]]];
    let sound = schedule(&two_runs(None, None), pulses);
    passes(&sound, &two_runs(None, None));
    passes(&sound, &two_runs(Some(cell(2, 1)), Some(cell(3, 1))));
    only(Rule::Start, &sound, &two_runs(None, Some(cell(2, 1))));
    let elsewhere = schedule(&two_runs(Some(cell(1, 1)), None), &[&[&["bl1.set"]], &[&["br0.reset"]]]);
    passes(&elsewhere, &two_runs(Some(cell(1, 1)), None));
    let found = rules(&elsewhere, &two_runs(None, None));
    assert!(found.contains(&Rule::Start) && found.contains(&Rule::Switch), "{found:?}");
}

#[test]
fn a_run_of_no_length_carries_the_place_on() {
    let still = order(facts(3, 3), vec![go(&[(1, 0)])]);
    let runs = ["a", "b", "c"].map(|task| job(task, "bot", still.clone())).to_vec();
    let claims = claims(runs, Timeline::Sequence((0..3).map(Timeline::Run).collect()));
    passes(&schedule(&claims, &[&[&["bl0.set"]], &[&[]], &[&[]]]), &claims);
}

fn goal(action: DimibotAction, pulses: &[&str], expected: &[Rule]) {
    let claims = alone(order(facts(3, 3), vec![action.clone()]));
    assert_eq!(rules(&schedule(&claims, &[&[pulses]]), &claims), expected, "{action:?} by {pulses:?}");
}

#[test]
fn a_move_reaches_its_stops_in_order() {
    let ring = ["bl0.set", "br0.set", "bl0.reset", "br0.reset"];
    goal(go(&[(0, 0)]), &ring, &[]);
    goal(go(&[(1, 0), (1, 1), (0, 1), (0, 0)]), &ring, &[]);
    goal(go(&[(0, 0), (0, 0), (1, 1), (0, 0)]), &ring, &[]);
    goal(go(&[(0, 1), (1, 1), (0, 0)]), &ring, &[Rule::Goal]);
    goal(go(&[(2, 0), (0, 0)]), &ring, &[Rule::Goal]);
    goal(go(&[(0, 1)]), &ring, &[Rule::Goal]);
    goal(go(&[(0, 1)]), &ring[..3], &[]);
    goal(go(&[(1, 0), (0, 0), (1, 0)]), &ring[..1], &[Rule::Goal]);
    goal(go(&[(1, 0)]), &[], &[Rule::Goal]);
}

#[test]
fn a_visit_reaches_its_stops_in_any_order() {
    let ring = ["bl0.set", "br0.set", "bl0.reset", "br0.reset"];
    let visit = |cells: &[(u32, u32)]| DimibotAction::Visit(stops(cells));
    goal(visit(&[(0, 1), (1, 1), (1, 0)]), &ring[..3], &[]);
    goal(visit(&[(0, 0), (0, 1)]), &ring[..3], &[]);
    goal(visit(&[(0, 1), (1, 1), (2, 0)]), &ring[..3], &[Rule::Goal]);
    goal(visit(&[(1, 1), (1, 0)]), &ring[..3], &[Rule::Goal]);
    goal(visit(&[(1, 1), (0, 0)]), &ring[..3], &[Rule::Goal]);
    goal(visit(&[(1, 1), (0, 0)]), &ring, &[]);
}

#[test]
fn a_stop_of_one_step_does_not_count_in_the_next() {
    let claims = alone(order(facts(3, 3), vec![go(&[(1, 0)]), DimibotAction::Visit(stops(&[(0, 0), (1, 1)]))]));
    only(Rule::Goal, &schedule(&claims, &[&[&["bl0.set"], &["br0.set"]]]), &claims);
    let claims = alone(order(facts(3, 3), vec![go(&[(1, 0)]), DimibotAction::Visit(stops(&[(1, 0), (1, 1)]))]));
    passes(&schedule(&claims, &[&[&["bl0.set"], &["br0.set"]]]), &claims);
}

/// One move to a position for which the cell (3, 2) is used.
fn placed(facts: DimibotFacts, place_um: [f64; 2], precision_um: Option<f64>) -> Claims {
    let place = DimibotStop { asked: Asked::Place(place_um), ..stop(3, 2) };
    let mut order = order(facts, vec![DimibotAction::Move(vec![place])]);
    order.precision_um = precision_um;
    alone(order)
}

#[test]
fn the_cell_of_a_place_is_the_nearest_and_near_enough() {
    let there: Pulses = &[&[&["bl0.set", "bl1.set", "br1.set"]]];
    for facts in [facts(3, 3), facts(2, 5), facts(20, 2)] {
        let [x_um, y_um] = facts.place_um(cell(3, 2));
        let (px_um, py_um) = (facts.pitch_um(Side::Left), facts.pitch_um(Side::Right));
        let far_um = 0.4 * px_um.min(py_um);
        let at = |x: f64, y: f64, precision_um| placed(facts.clone(), [x_um + x, y_um + y], precision_um);
        let good = [
            at(0.0, 0.0, Some(1e-6)),
            at(px_um * 0.4999, -py_um * 0.4999, None),
            at(far_um, 0.0, Some(far_um * 1.000_001)),
            at(0.0, -far_um, Some(far_um * 1.000_001)),
        ];
        let bad = [
            at(px_um * 0.51, 0.0, None),
            at(0.0, -py_um * 0.51, None),
            at(far_um, 0.0, Some(far_um * 0.999_999)),
            at(far_um / 2.0, far_um / 2.0, Some(far_um * 0.7)),
            at(f64::NAN, 0.0, None),
        ];
        for claims in good {
            passes(&schedule(&claims, there), &claims);
        }
        for claims in bad {
            only(Rule::Place, &schedule(&claims, there), &claims);
        }
    }
}

#[test]
fn a_robot_of_twenty_modules_is_replayed() {
    let all: Vec<String> = (0..20).flat_map(|module| [format!("bl{module}.set"), format!("br{module}.set")]).collect();
    let pulses: Vec<&str> = all.iter().map(String::as_str).collect();
    let last = (1 << 20) - 1;
    let claims = alone(order(facts(20, 20), vec![go(&[(last, last)])]));
    let schedule = schedule(&claims, &[&[&pulses]]);
    passes(&schedule, &claims);
}

#[test]
fn the_finest_module_of_twenty_has_its_full_digits() {
    let mut order = order(facts(20, 3), vec![go(&[((1 << 20) - 2, 7)])]);
    order.start = Some(Spanned::new(cell((1 << 20) - 1, 7), Span::default()));
    let claims = alone(order);
    passes(&schedule(&claims, &[&[&["bl0.reset"]]]), &claims);
}

#[test]
fn a_sweep_tells_gap_and_limit() {
    let obstacles = vec![solid("bead", Shape::Disc { radius_um: 0.5 }, 3.0, 0.55), cells("dust", (2, 0), (2, 0))];
    let mut claims = among((0, 0), (4, 0), obstacles);
    std::sync::Arc::make_mut(&mut order_of(&mut claims, 0).obstacles)[0].span = Span { end: 9, ..Span::default() };
    let Verdict::Rejected(found) = verify(schedule(&claims, &[&[&["bl2.set"]]]), &claims) else { panic!("it touches") };
    let title = "`bl2.set` at 0 ms moves the tip from (0, 0) to (4, 0), with a gap of 0.05 um to `bead` and 1 more; more than 0.1 um is needed";
    assert_eq!(found[0].title, title);
    assert_eq!(found[0].labels.len(), 1);
    assert_eq!((found[0].step, found[0].time_ns), (Some(0), 0));
}
