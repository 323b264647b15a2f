//! The collision rules compared with dense samples, by independent distance computations.

use super::fixture::{bed, obstacle, pose, robot};
use super::*;
use crate::geometry::Shape;
use crate::plan::microrobots::free::ArmSegment;
use proptest::prelude::*;

/// Points on the border of a robot's rectangle at a pose.
fn border(pose: Pose, [a_um, b_um]: [f64; 2]) -> Vec<[f64; 2]> {
    let (sin, cos) = pose.heading_rad.sin_cos();
    let place = |[x, y]: [f64; 2]| [pose.x_um + x * cos - y * sin, pose.y_um + x * sin + y * cos];
    let sides = [
        [[a_um, b_um], [-a_um, b_um]],
        [[-a_um, b_um], [-a_um, -b_um]],
        [[-a_um, -b_um], [a_um, -b_um]],
        [[a_um, -b_um], [a_um, b_um]],
    ];
    let along = |[p, q]: [[f64; 2]; 2]| {
        (0..25).map(move |part| [0, 1].map(|axis| p[axis] + (q[axis] - p[axis]) * part as f64 / 25.0))
    };
    sides.into_iter().flat_map(along).map(place).collect()
}

/// Distance of a point from a filled rectangle.
fn beyond_um(pose: Pose, [a_um, b_um]: [f64; 2], [x_um, y_um]: [f64; 2]) -> f64 {
    let (sin, cos) = pose.heading_rad.sin_cos();
    let (dx, dy) = (x_um - pose.x_um, y_um - pose.y_um);
    ((dx * cos + dy * sin).abs() - a_um).max(0.0).hypot(((dy * cos - dx * sin).abs() - b_um).max(0.0))
}

fn apart_um(one: Pose, other: Pose, half_um: [f64; 2]) -> f64 {
    let of = |a: Pose, b: Pose| {
        border(b, half_um).into_iter().map(|point| beyond_um(a, half_um, point)).fold(f64::INFINITY, f64::min)
    };
    of(one, other).min(of(other, one))
}

/// Margin by which the rules R2 and R3 are kept, at the worst of many instants.
fn sampled_room_um(world: &CollisionWorld, discs: &[OrbitDisc], start: &[Pose], legs: &[Leg]) -> f64 {
    let mut poses = start.to_vec();
    let mut least_um = f64::INFINITY;
    for leg in legs {
        for part in 0..=leg.strokes.div_ceil(400) {
            let strokes = (part * 400).min(leg.strokes);
            let now: Vec<Pose> = (0..world.count())
                .map(|robot| {
                    world.body(robot).robot.moved(
                        poses[robot],
                        world.arm(leg.state, robot),
                        world.way_um(robot, strokes),
                    )
                })
                .collect();
            for (index, pose) in now.iter().enumerate() {
                let half_um = world.body(index).half_um;
                for disc in discs {
                    least_um = least_um.min(beyond_um(*pose, half_um, disc.centre_um) - disc.radius_um - 10.0);
                }
                now[..index].iter().for_each(|other| least_um = least_um.min(apart_um(*pose, *other, half_um) - 10.0));
            }
        }
        world.advance(&mut poses, &vec![false; start.len()], *leg);
    }
    least_um
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 150, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn meetings_are_those_of_the_samples(
        places in prop::collection::vec((-600.0..600.0f64, -600.0..600.0f64, 0.0..360.0f64), 2..4),
        discs in prop::collection::vec((-900.0..900.0f64, -900.0..900.0f64, 5.0..100.0f64), 0..3),
        legs in prop::collection::vec((0..3usize, 1..30_000u64), 1..5),
    ) {
        let robots = places.iter().enumerate().map(|(index, at)| {
            (robot(&format!("D{index}"), 120.0 + 40.0 * index as f64, 0.015 + 0.002 * index as f64), pose(at.0, at.1, at.2))
        });
        let obstacles = discs.iter().map(|disc| obstacle("o", Shape::Disc { radius_um: disc.2 }, Pose::at(disc.0, disc.1)));
        let mut order = bed(robots.collect(), obstacles.collect());
        // The orbit discs have a test of their own.
        std::sync::Arc::make_mut(&mut order.facts).orbit_clearance_um = -1e6;
        let world = CollisionWorld::new(&order);
        let start: Vec<Pose> = order.robots.iter().map(|placed| placed.pose).collect();
        let legs: Vec<Leg> = legs.into_iter().map(|(state, strokes)| Leg { state, strokes }).collect();
        let discs: Vec<OrbitDisc> = discs.into_iter().map(|disc| OrbitDisc { centre_um: [disc.0, disc.1], radius_um: disc.2 }).collect();
        let hit = world.first_collision(&start, &vec![false; start.len()], &legs, &[]);
        let room_um = sampled_room_um(&world, &discs, &start, &legs);
        match hit {
            // The last sample is at the stroke of the collision.
            Some(hit) => {
                let until = Leg { strokes: (hit.strokes.ceil() as u64).max(1), ..legs[hit.leg] };
                let until: Vec<Leg> = legs[..hit.leg].iter().copied().chain([until]).collect();
                prop_assert!(sampled_room_um(&world, &discs, &start, &until) < 0.1, "{hit:?} {room_um}");
            }
            None => prop_assert!(room_um >= 0.0, "{room_um}"),
        }
    }
}

/// A bed with one robot that turns by `turn_deg` in two legs, and another thing beside its orbit.
fn orbit(turn_deg: f64, gap_um: f64, shape: Option<f64>) -> Option<Collision> {
    let one = robot("D1", 100.0, 0.02);
    let beyond_um = one.orbit_reach_um() + gap_um;
    let mut robots = vec![(one.clone(), pose(0.0, 100.0, 0.0))];
    let obstacles =
        shape.map(|radius_um| obstacle("o", Shape::Disc { radius_um }, Pose::at(0.0, -beyond_um - radius_um)));
    if shape.is_none() {
        robots.push((robot("D2", 100.0, 1e-7), pose(beyond_um + 125.0, 0.0, 0.0)));
    }
    let order = bed(robots, obstacles.into_iter().collect());
    let world = CollisionWorld::new(&order);
    let strokes = (turn_deg.to_radians() * 100.0 / 0.02 / 2.0) as u64;
    let start: Vec<Pose> = order.robots.iter().map(|placed| placed.pose).collect();
    let legs = [Leg { state: 1, strokes }, Leg { state: order.states.len() - 1, strokes }];
    world.first_collision(&start, &vec![false; start.len()], &legs, &[]).map(|hit| hit.collision)
}

#[test]
fn a_whole_turn_sweeps_a_disc() {
    assert_eq!(orbit(361.0, 20.1, Some(30.0)), None);
    assert_eq!(orbit(361.0, 19.9, Some(30.0)), Some(Collision::OrbitObstacle { robot: 0, obstacle: 0 }));
    assert_eq!(orbit(359.0, 19.9, Some(30.0)), None);
    assert_eq!(orbit(361.0, 20.1, None), None);
    assert_eq!(orbit(361.0, 19.9, None), Some(Collision::OrbitRobot { robot: 0, other: 1 }));
    assert_eq!(orbit(359.0, 19.9, None), None);
}

#[test]
fn bodies_keep_exactly_the_clearance() {
    for (left_um, hits) in [(40.01, false), (39.99, true)] {
        let wall = obstacle("wall", Shape::Box { size_um: [300.0, 20.0] }, Pose::at(1_000.0, left_um + 10.0));
        let order = bed(vec![(robot("D1", 100.0, 0.02), Pose::at(0.0, 0.0))], vec![wall]);
        let world = CollisionWorld::new(&order);
        let hit = world.first_collision(&[Pose::at(0.0, 0.0)], &[false], &[Leg { state: 0, strokes: 100_000 }], &[]);
        assert_eq!(hit.is_some(), hits);
        let way = ArmSegment { arm: Arm::Up, way_um: 2_000.0 };
        let found = world.obstruction(0, Pose::at(0.0, 0.0), way, &Fixtures::default());
        assert_eq!(found, hits.then_some(Obstruction::Obstacle(0)));
        if let Some(hit) = hit {
            assert!((hit.at.x_um - (1_000.0 - 150.0 - 125.0)).abs() < 11.0, "{hit:?}");
        }
    }
}

/// A robot runs head on into a docked one and stops this far before it.
fn docks(gap_um: f64, docking: bool) -> Option<FirstCollision> {
    let start = [pose(0.0, 0.0, 0.0), pose(1_000.0, 0.0, 180.0)];
    let order = bed(vec![(robot("D1", 100.0, 0.02), start[0]), (robot("D2", 100.0, 0.02), start[1])], Vec::new());
    let world = CollisionWorld::new(&order);
    let legs = [Leg { state: 0, strokes: 10_000 }, Leg { state: 0, strokes: ((550.0 - gap_um) / 0.02) as u64 }];
    let docks = [RobotDocking { robot: 0, leg: 1 }];
    world.first_collision(&start, &[false, true], &legs, if docking { &docks } else { &[] })
}

#[test]
fn who_docks_may_touch_but_not_overlap() {
    assert_eq!(docks(0.0, true), None);
    assert_eq!(docks(-0.99, true), None);
    assert!(docks(-1.01, true).is_some());
    let hit = docks(0.0, false).unwrap();
    assert_eq!((hit.leg, hit.collision), (1, Collision::Robots { robot: 0, other: 1 }));
    assert_eq!(docks(10.01, false), None);
    assert!(docks(9.99, false).is_some());
}

/// The cheap distance equals the exact one where that matters, and never exceeds it.
#[test]
fn the_cheap_distance_is_the_distance_where_it_is_small() {
    let mut random = crate::random::SplitMix64::new(7);
    let mut draw = |least: f64, most: f64| least + (most - least) * random.unit();
    let (mut exact, mut cheap) = (0, 0);
    for _ in 0..20_000 {
        let pose = Pose { x_um: draw(-200.0, 200.0), y_um: draw(-200.0, 200.0), heading_rad: draw(-4.0, 4.0) };
        let rectangle = OrientedRectangle::new(pose, [draw(10.0, 150.0), draw(5.0, 60.0)]);
        let shape = match draw(0.0, 4.0) as u32 {
            0 => Shape::Disc { radius_um: draw(1.0, 80.0) },
            1 => Shape::Capsule { length_um: draw(1.0, 200.0), radius_um: draw(1.0, 60.0) },
            2 => Shape::Box { size_um: [draw(1.0, 200.0), draw(1.0, 200.0)] },
            // Not convex: a box with a notch.
            _ => Shape::Polygon {
                points_um: vec![[-80.0, -60.0], [80.0, -60.0], [80.0, 60.0], [draw(-60.0, 60.0), -20.0], [-80.0, 60.0]],
            },
        };
        let body = shape.grown(&Pose::at(0.0, 0.0), 0.0).expect("a shape");
        let truth_um = rectangle.to_rounded_um(&body);
        let known_um = rectangle.nearly_to_rounded_um(&body, 12.0);
        if known_um > 12.0 {
            assert!(known_um <= truth_um + 1e-9, "{known_um} of {truth_um}");
            cheap += 1;
        } else {
            assert!((known_um - truth_um).abs() < 1e-9, "{known_um} for {truth_um}");
            exact += 1;
        }
    }
    assert!(exact > 3_000 && cheap > 3_000, "{exact} and {cheap}");
}
