//! States of the tree against a replay of their legs.

use super::*;
use crate::geometry::Shape;
use crate::plan::microrobots::world::Collision;
use crate::plan::microrobots::world::fixture::{bed, obstacle, pose, robot};

/// Two robots, one of them in a bay of discs.
fn crowded() -> (CollisionWorld, BedPoses) {
    let disc = |x_um, y_um| obstacle("o", Shape::Disc { radius_um: 120.0 }, pose(x_um, y_um, 0.0));
    let starts = [pose(0.0, 0.0, 0.0), pose(900.0, 300.0, 100.0)];
    let robots = starts.iter().zip(["D1", "D2"]).map(|(start, label)| (robot(label, 160.0, 0.015), *start));
    let order = bed(robots.collect(), vec![disc(330.0, 60.0), disc(60.0, 260.0), disc(250.0, -300.0)]);
    (CollisionWorld::new(&order), BedPoses::new(starts.to_vec(), vec![false, false]))
}

#[test]
fn every_state_is_where_its_legs_lead_and_no_leg_meets_anything() {
    let (world, start) = crowded();
    let grown = |seed| InitialLegTree::new(&world, &start, 0, &[pose(1_500.0, 0.0, 90.0)], seed).take(300);
    let (mut places, mut longest) = (Vec::new(), 0);
    for InitialLegs { legs, bed } in grown(1) {
        assert!(legs.windows(2).all(|pair| pair[0].state != pair[1].state), "{legs:?}");
        let mut replayed = start.clone();
        replayed.follow(&world, &legs, &[]);
        assert_eq!(replayed, bed);
        match start.first_collision(&world, &legs, &[]).map(|hit| hit.collision) {
            None => {}
            // A turn that becomes a full one only in a later leg keeps the larger clearance from its beginning on.
            Some(Collision::OrbitObstacle { .. } | Collision::OrbitRobot { .. } | Collision::Orbits { .. }) => {}
            Some(found @ (Collision::Obstacle { .. } | Collision::Robots { .. })) => panic!("{found:?} {legs:?}"),
        }
        longest = longest.max(legs.len());
        places.push(bed.poses);
    }
    assert!(places.len() == 300 && longest > 3, "{} states, {longest} legs", places.len());
    assert_eq!(grown(1).map(|found| found.bed.poses).collect::<Vec<_>>(), places);
    assert_ne!(grown(2).map(|found| found.bed.poses).collect::<Vec<_>>(), places);
}

#[test]
fn the_tree_of_a_bed_without_a_moving_robot_is_empty() {
    let (world, start) = crowded();
    let docked = BedPoses::new(start.poses, vec![true, true]);
    assert_eq!(InitialLegTree::new(&world, &docked, 0, &[], 1).count(), 0);
}
