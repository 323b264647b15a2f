//! Tests of the index of covered cells against a test of every obstacle.

use super::*;
use crate::random::SplitMix64;

fn facts() -> dimibot::DimibotFacts {
    dimibot::DimibotFacts { tip_radius_um: 0.1, ..dimibot::tests::femto_st(7, 6) }
}

fn bodies() -> Vec<DimibotObstacleBody> {
    let mut stream = SplitMix64::new(12_345);
    let mut next = || stream.unit();
    let mut bodies = Vec::new();
    for index in 0..60u32 {
        let pose = Pose { x_um: next() * 14.0, y_um: next() * 14.0, heading_rad: next() * 6.0 };
        let size = next() * next() * 3.0 + 0.01;
        let cell = LatticeCell { x: (next() * 120.0) as u32, y: (next() * 60.0) as u32 };
        bodies.push(match index % 4 {
            0 => DimibotObstacleBody::Solid { shape: Shape::Disc { radius_um: size }, pose },
            1 => DimibotObstacleBody::Solid { shape: Shape::Box { size_um: [size, 0.3] }, pose },
            2 => DimibotObstacleBody::Solid { shape: Shape::Point, pose },
            _ => DimibotObstacleBody::Cells {
                from: cell,
                to: LatticeCell { x: cell.x + index % 5, y: cell.y + index % 3 },
            },
        });
    }
    bodies
}

#[test]
fn the_index_of_covered_cells_agrees_with_asking_every_obstacle() {
    let facts = facts();
    let all: Vec<DimibotObstacle> = bodies()
        .into_iter()
        .enumerate()
        .map(|(index, body)| DimibotObstacle { name: index.to_string(), body, span: Span::default() })
        .collect();
    let cover = SceneCover::of(all.clone(), &facts, None);
    let mut covered = 0;
    for x in 0..facts.cells(Side::Left) {
        for y in 0..facts.cells(Side::Right) {
            let cell = LatticeCell { x, y };
            let expected = all.iter().position(|obstacle| match &obstacle.body {
                DimibotObstacleBody::Cells { from, to } => (from.x..=to.x).contains(&x) && (from.y..=to.y).contains(&y),
                DimibotObstacleBody::Solid { shape, pose } => {
                    clearance_um(shape, pose, cell, &facts) <= facts.growth_um()
                }
            });
            assert_eq!(cover.covering(cell, &facts), expected, "{cell}");
            covered += usize::from(expected.is_some());
        }
    }
    assert!(covered > 100, "only {covered} covered cells: the test says little");
}
