use super::*;
use crate::device::microrobots::fixture::pose;
use crate::plan::microrobots::simulation::tests::{errors, single};

const INTERVAL_NS: u64 = 100_000_000;

/// One robot and its structure, as they are measured at first.
fn seen() -> Vec<Option<Pose>> {
    vec![Some(pose(1500.0, 900.0, 30.0)), Some(pose(0.0, 0.0, 0.0))]
}

fn turning() -> crate::device::microrobots::Turning {
    crate::device::microrobots::Turning::Clockwise
}

#[test]
fn commands_follow_measurements_and_never_overlap() {
    let (order, motion) = single(pose(1500.0, 900.0, 30.0), turning(), errors(100));
    let mut controller = Controller::new(&order, &motion).expect("the errors are known");
    assert_eq!(controller.last(), Command::Rest { until_ns: 0 });
    let Command::Drive { segments, until_ns } = controller.observe(&seen(), 7) else { panic!("a drive") };
    assert!(!segments.is_empty() && segments[0].sets_arms && until_ns >= 7 + INTERVAL_NS, "{segments:?} {until_ns}");
    assert_eq!(controller.observe(&seen(), until_ns - 1), Command::Continue { until_ns });
    assert!(matches!(controller.observe(&seen(), until_ns), Command::Drive { .. }), "it is time again");
}

#[test]
fn what_was_not_seen_is_not_acted_upon() {
    let (order, motion) = single(pose(1500.0, 900.0, 30.0), turning(), errors(100));
    let mut controller = Controller::new(&order, &motion).expect("the errors are known");
    let mut now_ns = 0;
    for _ in 0..MAX_UNUSABLE {
        let command = controller.observe(&[None, Some(pose(0.0, 0.0, 0.0))], now_ns);
        assert_eq!(command, Command::Drive { segments: &[], until_ns: now_ns + INTERVAL_NS });
        now_ns += INTERVAL_NS;
    }
    let mut lost = controller.clone();
    assert!(matches!(controller.observe(&seen(), now_ns), Command::Drive { segments: [_, ..], .. }));
    let Command::Stop(stop) = lost.observe(&[None, None], now_ns) else { panic!("given up") };
    assert_eq!((stop.reason, stop.robot), (StopReason::Unseen, Some(0)));
    assert_eq!(lost.observe(&seen(), now_ns + INTERVAL_NS), Command::Stop(stop), "for good");
}

/// Segments driven before an unusable measurement still count for the next one.
#[test]
fn a_measurement_that_is_lost_on_the_way_does_no_harm() {
    let (order, motion) = single(pose(1500.0, 900.0, 30.0), turning(), errors(100));
    let mut controller = Controller::new(&order, &motion).expect("the errors are known");
    let mut poses = [pose(1500.0, 900.0, 30.0), pose(0.0, 0.0, 0.0)];
    let mut now_ns = 0;
    for nth in 0..30 {
        let lost = nth % 3 == 1;
        let measured = [(!lost).then_some(poses[0]), Some(poses[1])];
        let Command::Drive { segments, until_ns } = controller.observe(&measured, now_ns) else { panic!("a drive") };
        assert_eq!(segments.is_empty(), lost, "{nth}");
        for segment in segments {
            let arm = order.states[segment.state].arms[0];
            poses[0] = order.robot(0).moved(poses[0], arm, order.robot(0).step_um * segment.strokes as f64);
        }
        now_ns = until_ns;
    }
}

/// A jump is not believed at once. If the next measurement confirms it, it is a slip, or somebody's hand if it is a
/// long one.
#[test]
fn jumps_are_confirmed_first() {
    let (order, motion) = single(pose(1500.0, 900.0, 30.0), turning(), errors(100));
    let mut controller = Controller::new(&order, &motion).expect("the errors are known");
    let Command::Drive { until_ns, .. } = controller.observe(&seen(), 0) else { panic!("a drive") };
    let far = [Some(pose(1900.0, 900.0, 30.0)), Some(pose(0.0, 0.0, 0.0))];
    let mut moved = controller.clone();
    let Command::Drive { segments: [], until_ns: again_ns } = moved.observe(&far, until_ns) else { panic!("it holds") };
    let Command::Stop(Stop { reason, .. }) = moved.observe(&far, again_ns) else { panic!("it stops") };
    assert_eq!(reason, StopReason::Moved);
    let jumped = [Some(pose(1700.0, 900.0, 30.0)), Some(pose(0.0, 0.0, 0.0))];
    let Command::Drive { segments: [], until_ns } = controller.observe(&jumped, until_ns) else { panic!("it holds") };
    let mut wrong = controller.clone();
    assert!(matches!(controller.observe(&jumped, until_ns), Command::Drive { segments: [_, ..], .. }), "it slipped");
    assert!(
        matches!(wrong.observe(&seen(), until_ns), Command::Drive { segments: [_, ..], .. }),
        "a wrong measurement"
    );
    let nonsense = [Some(pose(f64::NAN, 0.0, 0.0)), Some(pose(0.0, 0.0, 0.0))];
    let Command::Drive { until_ns, .. } = wrong.last() else { panic!("a drive") };
    assert!(matches!(wrong.observe(&nonsense, until_ns), Command::Drive { segments: [], .. }));
}

#[test]
fn silence_and_a_clock_that_goes_back_stop_it() {
    let (mut order, motion) = single(pose(1500.0, 900.0, 30.0), turning(), errors(100));
    std::sync::Arc::make_mut(&mut order.facts).watchdog_ns = Some(INTERVAL_NS);
    let reason = |before: &Controller, late_ns: u64| {
        let mut controller = before.clone();
        match controller.observe(&seen(), late_ns) {
            Command::Stop(stop) => Some(stop.reason),
            Command::Drive { .. } | Command::Rest { .. } | Command::Continue { .. } | Command::Finished => None,
        }
    };
    let mut controller = Controller::new(&order, &motion).expect("the errors are known");
    let Command::Drive { until_ns, .. } = controller.observe(&seen(), 10) else { panic!("a drive") };
    assert_eq!(reason(&controller, until_ns + INTERVAL_NS), None);
    assert_eq!(reason(&controller, until_ns + INTERVAL_NS + 1), Some(StopReason::Silence));
    assert_eq!(reason(&controller, 9), Some(StopReason::Clock));
}

/// Measures one pose after the other while the robot is driven. Returns the number of answers, and why the task was
/// given up.
fn answers(at: impl Fn(u32, Pose) -> Pose) -> (u32, Option<Stop>) {
    let (order, motion) = single(pose(1500.0, 900.0, 30.0), turning(), errors(100));
    let mut controller = Controller::new(&order, &motion).expect("the errors are known");
    let mut driven = pose(1500.0, 900.0, 30.0);
    let mut now_ns = 0;
    for nth in 1..=40 {
        driven = at(nth, driven);
        match controller.observe(&[Some(driven), Some(pose(0.0, 0.0, 0.0))], now_ns) {
            Command::Drive { segments, until_ns } => {
                for segment in segments {
                    let arm = order.states[segment.state].arms[0];
                    driven = order.robot(0).moved(driven, arm, order.robot(0).step_um * segment.strokes as f64);
                }
                now_ns = until_ns;
            }
            Command::Stop(stop) => return (nth, Some(stop)),
            Command::Rest { .. } | Command::Continue { .. } | Command::Finished => panic!("a drive"),
        }
    }
    (40, None)
}

/// The controller gives up on a picture that does not change, and on a robot that stands still.
#[test]
fn a_robot_that_does_not_follow_stops_it() {
    let start = pose(1500.0, 900.0, 30.0);
    let (count, stop) = answers(|_, _| start);
    let stop = stop.expect("given up");
    assert_eq!((count, stop.reason, stop.robot), (MAX_ASTRAY + 2, StopReason::Astray, Some(0)));
    let (count, stop) = answers(|nth, driven| if nth <= 10 { driven } else { pose(1600.0, 900.0, 30.0) });
    assert!(count < 20 && stop.is_some_and(|stop| stop.reason == StopReason::Astray), "{count} {stop:?}");
    assert_eq!(answers(|_, driven| driven).1, None, "it follows");
}

/// A robot that stands for a while is driven on.
#[test]
fn a_robot_that_stalls_for_a_while_is_driven_on() {
    use std::cell::Cell;
    let stalled = |length: u32| {
        let last = Cell::new(pose(1500.0, 900.0, 30.0));
        answers(move |nth, driven| {
            // It stalls in some of every ten intervals.
            if nth % 10 > length || nth < 10 {
                last.set(driven);
            }
            last.get()
        })
    };
    assert_eq!(stalled(MAX_ASTRAY - 1).1, None);
    assert_eq!(stalled(MAX_ASTRAY).1.map(|stop| stop.reason), Some(StopReason::Astray));
}

/// Robots are set down by hand near their starts, each in its own place.
#[test]
fn a_first_measurement_is_not_believed_anywhere() {
    let (order, motion) = single(pose(1500.0, 900.0, 30.0), turning(), errors(100));
    let first = |poses: [Pose; 2], count: u32| {
        let mut controller = Controller::new(&order, &motion).expect("the errors are known");
        for nth in 0..count {
            controller.observe(&poses.map(Some), u64::from(nth) * INTERVAL_NS);
        }
        match controller.last() {
            Command::Drive { segments, .. } => Ok(segments.len()),
            Command::Stop(stop) => Err(stop.reason),
            Command::Rest { .. } | Command::Continue { .. } | Command::Finished => panic!("a drive or a stop"),
        }
    };
    let [one, two] = [pose(1500.0, 900.0, 30.0), pose(0.0, 0.0, 0.0)];
    for (what, poses) in [
        ("swapped", [two, one]),
        ("far", [pose(51_500.0, 900.0, 30.0), two]),
        ("beyond all numbers", [pose(1e308, -1e308, 30.0), two]),
        ("turned", [pose(1500.0, 900.0, 70.0), two]),
    ] {
        assert_eq!(first(poses, 1), Ok(0), "{what}");
        assert_eq!(first(poses, MAX_UNUSABLE), Ok(0), "{what}");
        assert_eq!(first(poses, MAX_UNUSABLE + 1), Err(StopReason::Doubtful), "{what}");
    }
    assert!(first([pose(1650.0, 1050.0, 50.0), pose(0.0, 0.0, 0.0)], 1).is_ok_and(|segments| segments > 0));
    // Beside each other, so near that a hand could reach the other one's place.
    let (order, motion) = single(pose(0.0, 120.0, 0.0), turning(), errors(100));
    let mut controller = Controller::new(&order, &motion).expect("the errors are known");
    for (what, poses) in [
        ("swapped", [pose(0.0, 0.0, 0.0), pose(0.0, 120.0, 0.0)]),
        ("one in the other", [pose(0.0, 70.0, 0.0), pose(0.0, 50.0, 0.0)]),
    ] {
        let held = controller.observe(&poses.map(Some), 0);
        assert!(matches!(held, Command::Drive { segments: [], .. }), "{what}: {held:?}");
        controller = Controller::new(&order, &motion).expect("the errors are known");
    }
}
