//! Cycles of whole strokes: the radius that they follow, and the way back.

use super::*;
use crate::device::microrobots::Turning;
use crate::device::microrobots::fixture::{self, pose};

fn robot(turning: Turning, turning_radius_um: f64) -> Robot {
    Robot {
        snap_down_v: 100.0,
        release_v: 40.0,
        turning,
        length_um: 260.0,
        ..fixture::robot("D1", turning_radius_um, 0.01)
    }
}

/// The radius of the circle that leaves the origin along its heading, to the right, and passes through a point.
fn radius_um(end: Pose) -> f64 {
    end.x_um.hypot(end.y_um).powi(2) / (2.0 * end.y_um.abs())
}

/// The printed formula has the shares exchanged: 3 parts of 10 turning give 333 um of a 100 um radius, and not 143 um.
#[test]
fn the_radius_is_that_of_the_corrected_formula() {
    let robot = robot(Turning::Clockwise, 100.0);
    let cycles = Cycles::<2> { strokes: [3, 7], count: 2000 };
    let from = pose(0.0, 0.0, 0.0);
    let end = cycles.forward(&robot, [Arm::Down, Arm::Up], from);
    assert!((radius_um(end) - 1000.0 / 3.0).abs() < 0.2, "{}", radius_um(end));
    let arms = [[Arm::Down, Arm::Up, Arm::Up], [Arm::Down, Arm::Down, Arm::Up]];
    for (arms, expected_um) in arms.into_iter().zip([300.0, 150.0]) {
        let end = Cycles { strokes: [1, 1, 1], count: 5000 }.forward(&robot, arms, from);
        assert!((radius_um(end) - expected_um).abs() < 0.1, "{}", radius_um(end));
    }
}

#[test]
fn cycles_go_back_as_they_went() {
    let fine = Fine { length_um: 200.0, cycle_um: 10.0 };
    let robot = robot(Turning::Counterclockwise, 165.0);
    let cycles = Cycles::<3>::symmetric(&fine, &[0.009, robot.step_um]);
    assert_eq!(cycles.strokes.iter().sum::<u64>(), 1000);
    assert_eq!(cycles.count, 20);
    let arms = [Arm::Down, Arm::Up, Arm::Up];
    let goal = pose(1000.0, -400.0, 123.0);
    let back = cycles.forward(&robot, arms, cycles.backward(&robot, arms, goal));
    assert!((back.x_um - goal.x_um).hypot(back.y_um - goal.y_um) < 1e-9);
    let legs: Vec<Leg> = cycles.legs([3, 2, 1]).collect();
    assert_eq!(legs.len(), 60);
    assert_eq!(legs.iter().map(|leg| leg.strokes).sum::<u64>(), cycles.total());
    assert_eq!(legs[2].state, 1);
}

/// However short the fine motion and its cycles are, each primitive occurs at least once, and no cycle exceeds its
/// limit of strokes.
#[test]
fn short_fine_motions_still_end_straight() {
    for (length_um, cycle_um) in [(0.005, 0.001), (0.02, 0.02), (0.1, 0.03), (5.0, 10.0)] {
        let cycles = Cycles::<2>::symmetric(&Fine { length_um, cycle_um }, &[0.01]);
        assert!(cycles.count >= 1 && cycles.strokes.iter().all(|strokes| *strokes >= 1), "{cycles:?}");
    }
    assert_eq!(split([0.25, 0.75], 10), [3, 7]);
    assert_eq!(split([0.0, 1.0], 7), [0, 7]);
}
