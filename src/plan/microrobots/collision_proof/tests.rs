//! Proofs of inevitable collisions compared with all sequences of arm positions on a coarse clock, by independent
//! motion and distances.

use super::*;
use crate::device::microrobots::Turning;
use crate::geometry::Shape;
use crate::plan::microrobots::world::fixture::{bed, obstacle, pose, robot};
use crate::random::SplitMix64;

/// A bed with one robot, discs, and the clearance of the fixture.
struct Trap {
    radius_um: f64,
    turning: Turning,
    start: Pose,
    /// Middle and radius of each disc.
    discs: Vec<([f64; 2], f64)>,
}

/// Pieces of a sequence of arm positions.
const PIECES: u32 = 12;

const KEEP_UM: f64 = 10.0;
const HALF_UM: [f64; 2] = [125.0, 30.0];

impl Trap {
    fn inevitable_collision(&self, needed_um: f64) -> Option<InevitableCollision> {
        let facts = crate::device::microrobots::Robot { turning: self.turning, ..robot("D1", self.radius_um, 0.015) };
        let discs = self.discs.iter().map(|([x_um, y_um], radius_um)| {
            obstacle("o", Shape::Disc { radius_um: *radius_um }, pose(*x_um, *y_um, 0.0))
        });
        let order = bed(vec![(facts, self.start)], discs.collect());
        inevitable_collision(&CollisionWorld::new(&order), 0, self.start, needed_um)
    }

    /// Whether a body at a pose keeps the clearance, by distances of discs in its own frame.
    fn is_free(&self, [x, y, heading]: [f64; 3]) -> bool {
        self.discs.iter().all(|([disc_x, disc_y], radius_um)| {
            let (dx, dy, sin, cos) = (disc_x - x, disc_y - y, heading.sin(), heading.cos());
            let (along, across) = ((dx * cos + dy * sin).abs() - HALF_UM[0], (dy * cos - dx * sin).abs() - HALF_UM[1]);
            along.max(0.0).hypot(across.max(0.0)) - radius_um >= KEEP_UM
        })
    }

    fn gone(&self, [x, y, heading]: [f64; 3], way_um: f64, is_down: bool) -> [f64; 3] {
        if !is_down {
            return [x + way_um * heading.cos(), y + way_um * heading.sin(), heading];
        }
        let curve_um = self.turning.sign() * self.radius_um;
        let later = heading + way_um / curve_um;
        [x + curve_um * (later.sin() - heading.sin()), y - curve_um * (later.cos() - heading.cos()), later]
    }

    /// Whether some sequence of `pieces` pieces, each with the arm up or down, is free at the end of every piece.
    fn survives(&self, place: [f64; 3], pieces: u32, piece_um: f64) -> bool {
        let goes_on = |is_down: &bool| {
            let next = self.gone(place, piece_um, *is_down);
            self.is_free(next) && self.survives(next, pieces - 1, piece_um)
        };
        pieces == 0 || [false, true].iter().any(goes_on)
    }

    fn place(&self) -> [f64; 3] {
        [self.start.x_um, self.start.y_um, self.start.heading_rad]
    }
}

fn trap(random: &mut SplitMix64) -> Trap {
    let turning = if random.below(2) == 0 { Turning::Clockwise } else { Turning::Counterclockwise };
    let start = pose(100.0 * random.unit(), 100.0 * random.unit(), 360.0 * random.unit());
    let disc = |random: &mut SplitMix64| {
        let (radius_um, turn, gap_um) =
            (30.0 + 200.0 * random.unit(), 1.2 * random.signed_unit(), 40.0 * random.unit());
        let far_um = radius_um + 140.0 + gap_um;
        let (sin, cos) = (start.heading_rad + turn).sin_cos();
        ([start.x_um + far_um * cos, start.y_um + far_um * sin], radius_um)
    };
    let discs = (0..1 + random.below(3)).map(|_| disc(random)).collect();
    Trap { radius_um: 80.0 + 160.0 * random.unit(), turning, start, discs }
}

#[test]
fn a_robot_with_a_proof_survives_no_sequence_of_arm_positions() {
    let mut random = SplitMix64::new(41);
    let (mut proven, mut lost) = (0, 0);
    for _ in 0..400 {
        let trap = trap(&mut random);
        if !trap.is_free(trap.place()) {
            continue;
        }
        match trap.inevitable_collision(1e6) {
            Some(collision) => {
                proven += 1;
                assert!(
                    !trap.survives(trap.place(), PIECES, collision.way_um / f64::from(PIECES)),
                    "{:?} {:?}",
                    trap.start,
                    trap.discs
                );
                assert!(
                    collision.obstacles.iter().all(|obstacle| *obstacle < trap.discs.len())
                        && !collision.obstacles.is_empty()
                );
                assert_eq!(trap.inevitable_collision(collision.way_um * 0.99), None, "that far it may come");
            }
            None => lost += u64::from(!trap.survives(trap.place(), PIECES, 150.0 / f64::from(PIECES))),
        }
    }
    println!("{proven} proven, {lost} more survive no sequence");
    assert!(proven > 60 && 10 * lost < proven, "{proven} proven, {lost} more survive no sequence");
}

/// The same disc, ahead and a little beside: past the second one the robot turns away.
#[test]
fn a_robot_before_a_disc_must_meet_it_and_one_that_turns_past_it_need_not() {
    let at = |y_um: f64| Trap {
        radius_um: 160.0,
        turning: Turning::Clockwise,
        start: pose(0.0, 0.0, 0.0),
        discs: vec![([125.0 + 30.0 + 100.0, y_um], 100.0)],
    };
    let collision = at(0.0).inevitable_collision(1_000.0).expect("it runs or turns into the disc");
    assert!(collision.obstacles == [0] && (20.0..60.0).contains(&collision.way_um), "{collision:?}");
    assert_eq!(at(0.0).inevitable_collision(10.0), None);
    assert_eq!(at(120.0).inevitable_collision(1_000.0), None);
}
