//! Paths around obstacles.

use super::*;
use crate::geometry::Shape;
use crate::plan::microrobots::world::fixture::{bed, obstacle, pose, robot};
use crate::plan::search::SearchBudget;

fn wall(x_um: f64, from_um: f64, to_um: f64) -> crate::claims::microrobots::MicrorobotsObstacle {
    obstacle("wall", Shape::Box { size_um: [40.0, to_um - from_um] }, Pose::at(x_um, (from_um + to_um) / 2.0))
}

fn disc(x_um: f64, y_um: f64, radius_um: f64) -> crate::claims::microrobots::MicrorobotsObstacle {
    obstacle("disc", Shape::Disc { radius_um }, Pose::at(x_um, y_um))
}

/// The path found, verified to be free by samples; with the number of expanded states.
fn found(
    obstacles: Vec<crate::claims::microrobots::MicrorobotsObstacle>,
    from: Pose,
    to: Pose,
) -> Result<(FreePath, u64), PathFailure> {
    let order = bed(vec![(robot("D1", 150.0, 0.015), from)], obstacles);
    let world = CollisionWorld::new(&order);
    let fixtures = Fixtures::default();
    let request = PathRequest { world: &world, robot: 0, from, to, fixtures: &fixtures };
    let mut meter = Meter::new(SearchBudget::of(200_000));
    let found = request.find(&mut meter)?;
    let mut at = from;
    for segment in &found.segments {
        for part in 0..=200 {
            let pose = request.facts().moved(at, segment.arm, segment.way_um * f64::from(part) / 200.0);
            assert!(world.room_um(0, pose, &fixtures) >= 0.0);
        }
        at = request.facts().moved(at, segment.arm, segment.way_um);
    }
    assert!((at.x_um - to.x_um).hypot(at.y_um - to.y_um) < 1e-3, "{at:?}");
    assert!(
        free::turn_rad(request.facts(), at.heading_rad, to.heading_rad)
            .min(TAU - free::turn_rad(request.facts(), at.heading_rad, to.heading_rad))
            < 1e-6
    );
    println!(
        "{:.1} of {:.1} in {} legs, {} taken",
        found.length_um,
        found.bound_um,
        found.segments.len(),
        meter.spent()
    );
    Ok((found, meter.spent()))
}

#[test]
fn nothing_in_the_way_is_the_optimum() {
    let (found, taken) =
        found(vec![disc(0.0, 3_000.0, 50.0)], pose(0.0, 0.0, 0.0), pose(2_000.0, -500.0, -60.0)).unwrap();
    assert!(taken == 0 && (found.length_um - found.bound_um).abs() < 1e-9);
}

#[test]
fn a_disc_in_the_way_is_passed() {
    for y_um in [-60.0, 0.0, 60.0] {
        let (found, taken) =
            found(vec![disc(1_000.0, y_um, 50.0)], pose(0.0, 0.0, 0.0), pose(2_000.0, 0.0, 0.0)).unwrap();
        // A lateral offset takes a full turn.
        assert!(found.length_um < 2_000.0 + TAU * 150.0 + 60.0, "{found:?}");
        assert!(taken < 20_000, "{taken}");
    }
}

#[test]
fn a_gap_in_a_wall_is_found() {
    let gap = |half_um: f64| vec![wall(1_000.0, half_um, 1_500.0), wall(1_000.0, -1_500.0, -half_um)];
    let goal = pose(2_000.0, 300.0, 40.0);
    let start = pose(0.0, -400.0, 90.0);
    let (wide, _) = found(gap(60.0), start, goal).unwrap();
    let (closed, _) = found(gap(39.0), start, goal).unwrap();
    assert!(wide.length_um < 4_000.0 && closed.length_um > wide.length_um + 500.0, "{wide:?} {closed:?}");
}

#[test]
fn a_corridor_is_followed() {
    let walls = vec![wall(0.0, -100.0, 900.0), wall(240.0, -100.0, 900.0)];
    let (found, _) = found(walls, pose(120.0, 400.0, 90.0), pose(800.0, 400.0, 90.0)).unwrap();
    assert!(found.length_um < 2_200.0 && found.length_um > found.bound_um + 300.0, "{found:?}");
}

#[test]
fn bad_ends_are_proofs() {
    let from = pose(0.0, 0.0, 0.0);
    let bad = found(vec![disc(1_000.0, 0.0, 50.0)], from, pose(1_000.0, 0.0, 90.0)).map(|_| ());
    assert_eq!(bad, Err(PathFailure::Goal(Obstruction::Obstacle(0))));
    let bad = found(vec![disc(0.0, 0.0, 50.0)], from, pose(1_000.0, 0.0, 90.0)).map(|_| ());
    assert_eq!(bad, Err(PathFailure::Start(Obstruction::Obstacle(0))));
}

#[test]
fn a_cage_is_not_left() {
    let cage = vec![
        wall(-250.0, -300.0, 300.0),
        wall(250.0, -300.0, 300.0),
        obstacle("top", Shape::Box { size_um: [600.0, 40.0] }, Pose::at(0.0, 250.0)),
        obstacle("bottom", Shape::Box { size_um: [600.0, 40.0] }, Pose::at(0.0, -250.0)),
    ];
    let bad = found(cage, pose(0.0, 0.0, 0.0), pose(2_000.0, 0.0, 0.0)).map(|_| ());
    assert!(matches!(bad, Err(PathFailure::Blocked(_))), "{bad:?}");
}
