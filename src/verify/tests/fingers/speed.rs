//! Speed limits of tips: measured from the lines alone, at the limit and just above it.

use super::*;

/// Two fingers grasp the bead and roll it, a third one replaces one of them, and the bead is carried, without waits.
fn brisk(order: FingersOrder) -> Day {
    Day::new(order)
        .step(FingersAction::Grasp(Some(vec![1, 38, 0])))
        .come(0, 1)
        .come(1, 38)
        .record()
        .rotate(Plane::Xy, 3)
        .roll(2)
        .come(2, 28)
        .counted()
        .record()
        .go(1)
        .counted()
        .record()
        .roll(1)
        .step(FingersAction::Translate([5.0, -3.0, 2.0]))
        .carry([5.0, -3.0, 2.0])
}

/// Speed of the fastest line of any finger, among those selected by their step and their two ends.
fn fastest_um_per_s(day: &Day, is_one: impl Fn(usize, &[Point; 2]) -> bool) -> f64 {
    let mut tips_um = day.start_um.clone();
    let mut fastest = 0.0_f64;
    for (step, lines) in day.lines.iter().enumerate() {
        for line in lines {
            for (from, to) in tips_um.iter().zip(&line.tips_um) {
                if is_one(step, &[*from, *to]) {
                    fastest = fastest.max((to - from).norm() / (line.duration_ns as f64 / 1e9));
                }
            }
            tips_um.clone_from(&line.tips_um);
        }
    }
    fastest
}

fn with_speeds(edit: impl Fn(&mut FingersFacts)) -> Vec<Rule> {
    broken(&brisk(with_facts(edit)))
}

#[test]
fn each_speed_is_a_limit() {
    let day = brisk(order());
    assert_eq!(broken(&day), []);
    // The longest paths are those of free tips, through the air; the last step carries all tips; tips approach over
    // their last 5 um.
    let free = fastest_um_per_s(&day, |_, _| true);
    let carried = fastest_um_per_s(&day, |step, _| step == 2);
    assert!((carried - 38.0_f64.sqrt() / 2.0 / 0.1).abs() < 1e-9, "{carried} um/s");
    let coming = 5.0 / 0.1;
    type Set = fn(&mut FingersFacts, f64);
    let cases: [(f64, Set); 3] = [
        (free, |facts, um_per_s| facts.speed_um_per_s = um_per_s),
        (carried, |facts, um_per_s| facts.rolling_um_per_s = um_per_s),
        (coming, |facts, um_per_s| facts.approach_um_per_s = um_per_s),
    ];
    for (at, (limit, set)) in cases.into_iter().enumerate() {
        assert_eq!(with_speeds(|facts| set(facts, limit)), [], "{at}");
        assert_eq!(with_speeds(|facts| set(facts, limit * (1.0 - 1e-7))), [], "{at}, rounding");
        assert_eq!(with_speeds(|facts| set(facts, limit * (1.0 - 1e-5))), [Rule::Speed], "{at}");
    }
}

/// A hand whose tips may be faster near the part than elsewhere is judged by their positions.
#[test]
fn a_fast_approach_is_fast_near_the_contact_only() {
    let free = fastest_um_per_s(&brisk(order()), |_, _| true);
    let quick = |facts: &mut FingersFacts, speed| (facts.speed_um_per_s, facts.approach_um_per_s) = (speed, 1e6);
    assert_eq!(with_speeds(|facts| quick(facts, free)), []);
    assert_eq!(with_speeds(|facts| quick(facts, free * (1.0 - 1e-5))), [Rule::Speed]);
}

/// The last line to a contact begins inside the slow distance, so it must be slow from there on.
#[test]
fn tips_are_slow_within_the_distance_of_their_retreat() {
    let coming = |out_um: f64| {
        let mut order = with_facts(|facts| (facts.speed_um_per_s, facts.approach_um_per_s) = (1000.0, 50.0));
        order.precision_rad = 0.01;
        let mut day = Day::new(order).step(FingersAction::Grasp(None)).come(0, 1).come(1, 38).record();
        let (rolled_rad, across) = (day.rolled_rad(57), Point::new(0.0, 0.0, 35.0));
        let (above, over) = (day.tips_um[2] + across, day.seat_um(rolled_rad, 30.0) + across);
        day = day.fly(2, above).fly(2, over);
        for out_um in [30.0, out_um, 0.0] {
            let to_um = day.seat_um(rolled_rad, out_um);
            day = day.fly(2, to_um);
        }
        day.grasp[2] = 57;
        broken(&day.step(FingersAction::Grasp(None)).still(MS).counted().record())
    };
    assert!(!coming(5.0).contains(&Rule::Speed));
    // 25.1 um in 100 ms, of which the last 0.1 um lie within 5 um of the contact.
    assert!(coming(4.9).contains(&Rule::Speed));
}

fn hastened(schedule: &mut Schedule, divisor: u64) {
    let quick = |time_ns: &mut u64| *time_ns /= divisor;
    quick(&mut schedule.duration_ns);
    for line in &mut schedule.actuations {
        quick(&mut line.start_ns);
        quick(&mut line.duration_ns);
    }
    for step in &mut schedule.steps {
        quick(&mut step.start_ns);
        quick(&mut step.duration_ns);
    }
    for plan in &mut schedule.plans {
        quick(&mut plan.duration_ns);
        plan.states.iter_mut().for_each(|state| quick(&mut state.t_ns));
        plan.outcomes.insert("time_ns".to_owned(), plan.duration_ns as f64);
    }
}

#[test]
fn a_clock_that_runs_too_fast_is_noticed_by_this_rule_alone() {
    let (sound, claims) = brisk(order()).both();
    for divisor in [2, 100, 1000] {
        let mut forged = sound.clone();
        hastened(&mut forged, divisor);
        only(Rule::Speed, &forged, &claims);
    }
}
