//! Drives end to end: every plan is integrated and checked.

use super::*;
use crate::claims::microrobots::MicrorobotsObstacle;
use crate::device::microrobots::{ControlState, Robot};
use crate::geometry::Shape;
use crate::plan::microrobots::legs_ns;
use crate::plan::microrobots::world::fixture::{bed, obstacle, pose, robot};
use proptest::prelude::*;
use std::sync::Arc;

fn drive_in(
    order: &MicrorobotsOrder,
    docked: &[usize],
    driven: usize,
    stops: &[Pose],
) -> Result<DrivePlan, StuckDrive> {
    let world = CollisionWorld::new(order);
    let start: Vec<Pose> = order.robots.iter().map(|placed| placed.pose).collect();
    let docked: Vec<bool> = (0..start.len()).map(|robot| docked.contains(&robot)).collect();
    let bed = BedPoses::new(start.clone(), docked.clone());
    let request = DriveRequest { order, world: &world, bed: &bed, robot: driven, stops };
    let plan = drive(&request, SearchBudget::of(500_000))?;
    assert_eq!(world.first_collision(&start, &docked, &plan.legs, &[]), None);
    let mut poses = start;
    let mut stop = 0;
    for (index, leg) in plan.legs.iter().enumerate() {
        assert!(leg.strokes > 0);
        let joined = plan.met.contains(&index);
        assert!(index == 0 || joined || plan.legs[index - 1].state != leg.state, "{plan:?}");
        world.advance(&mut poses, &docked, *leg);
        while stop < stops.len() && strokes::is_within(poses[driven], stops[stop], order.precision) {
            stop += 1;
        }
    }
    assert!(plan.legs.is_empty() || stop == stops.len(), "{plan:?}");
    Ok(plan)
}

fn three(at: [Pose; 3], obstacles: Vec<MicrorobotsObstacle>) -> MicrorobotsOrder {
    let robots = ["D1", "D2", "D3"].map(|name| robot(name, 150.0, 0.015));
    bed(robots.into_iter().zip(at).collect(), obstacles)
}

fn far(index: usize) -> Pose {
    pose(100_000.0 * (1.0 + index as f64), 0.0, 90.0)
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 1_000, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn drives_reach_their_goals(
        driven in 0..3usize,
        from in (-5_000.0..5_000.0f64, -5_000.0..5_000.0f64, -180.0..180.0f64),
        to in (-5_000.0..5_000.0f64, -5_000.0..5_000.0f64, -180.0..180.0f64),
        (radius_um, step_um) in (30.0..400.0f64, 0.01..0.02f64),
    ) {
        let facts = |index: usize| Robot { step_um: step_um * (1.0 + 0.1 * index as f64), ..robot(&format!("D{index}"), radius_um, step_um) };
        let at = |index: usize| if index == driven { pose(from.0, from.1, from.2) } else { far(index) };
        let order = bed((0..3).map(|index| (facts(index), at(index))).collect(), Vec::new());
        let plan = drive_in(&order, &[], driven, &[pose(to.0, to.1, to.2)]).unwrap();
        prop_assert!(plan.direct && plan.legs.len() <= 5, "{plan:?}");
        // Fewer control cycles may be worth more strokes.
        let exact_ns = (plan.exact_strokes + 10) * order.facts.period_ns;
        let cycle_ns = |state: &ControlState| state.levels_v.len() as u64 * order.facts.dwell_ns;
        let cycles_ns = 5 * order.states.iter().map(cycle_ns).max().unwrap();
        prop_assert!(legs_ns(&order, &plan.legs) <= exact_ns + cycles_ns, "{plan:?}");
    }
}

/// Two legs that end within the precision take 45 strokes more than the way to the goal itself, and a control cycle less.
#[test]
fn a_drive_with_fewer_control_cycles_is_direct() {
    let facts = |index: usize| Robot {
        step_um: 0.01 * (1.0 + 0.1 * index as f64),
        ..robot(&format!("D{index}"), 325.011_773_878_120_1, 0.01)
    };
    let from = pose(-3_793.502_860_412_387_2, 2_429.374_402_525_442_7, -35.452_668_108_718_61);
    let to = pose(2_467.456_094_471_549_5, -2_286.008_753_921_15, -104.532_798_154_314_22);
    let at = |index: usize| if index == 0 { from } else { far(index) };
    let order = bed((0..3).map(|index| (facts(index), at(index))).collect(), Vec::new());
    let plan = drive_in(&order, &[], 0, &[to]).unwrap();
    assert!(plan.direct && plan.legs.len() == 2 && plan.strokes > plan.exact_strokes + 10, "{plan:?}");
}

#[test]
fn who_is_there_stays() {
    let order = three([Pose::at(0.0, 0.0), far(1), far(2)], Vec::new());
    let plan = drive_in(&order, &[], 0, &[pose(0.3, 0.2, 0.4)]).unwrap();
    assert!(plan.legs.is_empty() && plan.direct);
}

#[test]
fn the_others_turn_where_they_can() {
    let order = three([far(0), Pose::at(0.0, 0.0), far(2)], Vec::new());
    let plan = drive_in(&order, &[], 1, &[pose(1_500.0, -900.0, -120.0)]).unwrap();
    // State 3 lowers all arms, state 1 raises those of the second and the third.
    let states = plan.legs.iter().map(|leg| leg.state);
    assert!(states.zip([3, 1].into_iter().cycle()).all(|(state, expected)| state == expected), "{plan:?}");
}

#[test]
fn obstacles_are_driven_around() {
    let disc = obstacle("disc", Shape::Disc { radius_um: 80.0 }, Pose::at(1_000.0, 0.0));
    let order = three([Pose::at(0.0, 0.0), far(1), far(2)], vec![disc]);
    let plan = drive_in(&order, &[], 0, &[Pose::at(2_000.0, 0.0)]).unwrap();
    assert!(!plan.direct && plan.strokes > plan.exact_strokes && plan.spent < 5_000, "{plan:?}");
}

#[test]
fn who_orbits_is_driven_around() {
    // The first robot turns with every leg of the second one, or comes towards it.
    let order = three([pose(1_000.0, -30.0, 180.0), Pose::at(0.0, 0.0), far(2)], Vec::new());
    let plan = drive_in(&order, &[], 1, &[Pose::at(2_200.0, 0.0)]).unwrap();
    assert!(!plan.direct, "{plan:?}");
    // If it runs away, nothing obstructs it; nor if it orbits elsewhere.
    let order = three([pose(1_000.0, 150.0, 0.0), Pose::at(0.0, 0.0), far(2)], Vec::new());
    assert!(drive_in(&order, &[], 1, &[Pose::at(2_200.0, 0.0)]).unwrap().direct);
    let order = three([pose(1_000.0, 700.0, 0.0), Pose::at(0.0, 0.0), far(2)], Vec::new());
    assert!(drive_in(&order, &[], 1, &[Pose::at(2_200.0, 0.0)]).unwrap().direct);
}

#[test]
fn docked_robots_are_driven_around() {
    let order = three([Pose::at(0.0, 0.0), pose(1_000.0, 0.0, 90.0), far(2)], Vec::new());
    let plan = drive_in(&order, &[1], 0, &[Pose::at(2_000.0, 0.0)]).unwrap();
    assert!(!plan.direct);
    let stuck = drive_in(&order, &[1], 0, &[Pose::at(1_000.0, 50.0)]).unwrap_err();
    assert!(stuck.reason == StuckReason::Goal(DriveBlocker::Robot(1)) && !stuck.reason.is_proof());
    assert_eq!(drive_in(&order, &[1], 1, &[Pose::at(1_000.0, 500.0)]).unwrap_err().reason, StuckReason::Docked);
}

/// The second robot's arm is down only together with the first one's.
#[test]
fn the_arms_of_docked_robots_stay_up() {
    let order = three([Pose::at(0.0, 0.0), pose(3_000.0, 0.0, 90.0), far(2)], Vec::new());
    let goal = pose(900.0, -900.0, 180.0);
    let plan = drive_in(&order, &[1], 0, &[goal]).unwrap();
    assert!(plan.legs.iter().all(|leg| leg.state < 2), "{plan:?}");
    let order = three([pose(3_000.0, 0.0, 90.0), Pose::at(0.0, 0.0), far(2)], Vec::new());
    assert_eq!(drive_in(&order, &[0], 1, &[goal]).unwrap_err().reason, StuckReason::NeverTurns);
}

#[test]
fn what_others_hit_is_told() {
    // The third robot runs straight whenever the first one does, into a wall before it.
    let wall = obstacle("wall", Shape::Box { size_um: [40.0, 4_000.0] }, Pose::at(5_300.0, 0.0));
    let order = three([Pose::at(0.0, 0.0), far(1), pose(5_000.0, 0.0, 0.0)], vec![wall]);
    let stuck = drive_in(&order, &[], 0, &[Pose::at(2_000.0, 0.0)]).unwrap_err();
    let StuckReason::Meets(hit) = stuck.reason else { panic!("{stuck:?}") };
    assert_eq!(hit.collision, Collision::Obstacle { robot: 2, obstacle: 0 });
    assert!(!stuck.reason.is_proof());
    // With its legs chosen accordingly, it turns in time: while all arms are down in between, it comes back.
    let wall = obstacle("wall", Shape::Box { size_um: [40.0, 4_000.0] }, Pose::at(9_000.0, 0.0));
    let order = three([Pose::at(0.0, 0.0), far(1), pose(5_000.0, 0.0, 0.0)], vec![wall]);
    assert!(drive_in(&order, &[], 0, &[Pose::at(2_000.0, 0.0)]).is_ok());
}

#[test]
fn stops_are_met_in_order() {
    let order = three([Pose::at(0.0, 0.0), far(1), far(2)], Vec::new());
    let stops = [pose(500.0, 0.0, 0.0), pose(900.0, 0.0, 0.0), pose(900.0, -900.0, 180.0)];
    let plan = drive_in(&order, &[], 0, &stops).unwrap();
    assert!(plan.met.len() == 3 && plan.direct, "{plan:?}");
}

#[test]
fn without_an_arm_down_there_is_no_turn() {
    let mut order = three([Pose::at(0.0, 0.0), far(1), far(2)], Vec::new());
    Arc::make_mut(&mut order.states).truncate(1);
    let stuck = drive_in(&order, &[], 0, &[pose(900.0, -900.0, 180.0)]).unwrap_err();
    assert_eq!(stuck.reason, StuckReason::NeverTurns);
    assert!(drive_in(&order, &[], 0, &[Pose::at(1_000.0, 0.0)]).unwrap().direct);
}
