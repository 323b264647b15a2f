//! Proofs of inevitable collisions compared with all sequences of control states on a coarse clock, by independent
//! motion and distances.

use super::*;
use crate::device::microrobots::Turning;
use crate::plan::microrobots::disc_oracle::{DiscBed, STEP_UM, are_apart, place, turning};
use crate::plan::microrobots::world::fixture::pose;
use crate::random::SplitMix64;

/// One or two robots among discs.
struct Trap {
    bed: DiscBed,
    starts: Vec<Pose>,
}

/// Pieces of a sequence of control states.
const PIECES: u32 = 12;
const PIECES_OF_TWO: u32 = 8;

impl Trap {
    fn inevitable_collision(&self, needed_um: f64) -> Option<InevitableCollision> {
        let robots: Vec<usize> = (0..self.starts.len()).collect();
        let bed = BedPoses::new(self.starts.clone(), vec![false; self.starts.len()]);
        let needed = needed_um / STEP_UM;
        let world = CollisionWorld::new(&self.bed.order(&self.starts));
        CollisionQuestion { world: &world, bed: &bed, robots: &robots, keep_apart: true, needed }.inevitable()
    }

    /// Whether some sequence of `pieces` pieces, each in one of the control states, is free at the end of every piece.
    fn survives(&self, places: &[[f64; 3]], pieces: u32, piece_um: f64) -> bool {
        let goes_on = |lowered: usize| {
            let next: Vec<[f64; 3]> =
                places.iter().enumerate().map(|(at, place)| self.bed.gone(*place, piece_um, at < lowered)).collect();
            let is_free = next.iter().all(|place| self.bed.is_free(*place))
                && next.windows(2).all(|pair| are_apart(pair[0], pair[1]));
            is_free && self.survives(&next, pieces - 1, piece_um)
        };
        pieces == 0 || (0..=places.len()).any(goes_on)
    }

    fn places(&self) -> Vec<[f64; 3]> {
        self.starts.iter().map(|start| place(*start)).collect()
    }
}

fn trap(random: &mut SplitMix64) -> Trap {
    let turning = turning(random);
    let start = pose(100.0 * random.unit(), 100.0 * random.unit(), 360.0 * random.unit());
    let disc = |random: &mut SplitMix64| {
        let (radius_um, turn, gap_um) =
            (30.0 + 200.0 * random.unit(), 1.2 * random.signed_unit(), 40.0 * random.unit());
        let far_um = radius_um + 140.0 + gap_um;
        let (sin, cos) = (start.heading_rad + turn).sin_cos();
        ([start.x_um + far_um * cos, start.y_um + far_um * sin], radius_um)
    };
    let discs = (0..1 + random.below(3)).map(|_| disc(random)).collect();
    let bed = DiscBed { radius_um: 80.0 + 160.0 * random.unit(), turning, discs };
    Trap { bed, starts: vec![start] }
}

/// Path to which the strokes of a proof amount.
fn way_um(collision: &InevitableCollision) -> f64 {
    collision.strokes * STEP_UM
}

#[test]
fn a_robot_with_a_proof_survives_no_sequence_of_arm_positions() {
    let mut random = SplitMix64::new(41);
    let (mut proven, mut lost) = (0, 0);
    for _ in 0..400 {
        let trap = trap(&mut random);
        if !trap.bed.is_free(trap.places()[0]) {
            continue;
        }
        match trap.inevitable_collision(1e6) {
            Some(collision) => {
                proven += 1;
                assert!(
                    !trap.survives(&trap.places(), PIECES, way_um(&collision) / f64::from(PIECES)),
                    "{:?} {:?}",
                    trap.starts,
                    trap.bed.discs
                );
                let obstacles = collision.obstacles();
                assert!(obstacles.iter().all(|obstacle| *obstacle < trap.bed.discs.len()) && !obstacles.is_empty());
                assert_eq!(trap.inevitable_collision(way_um(&collision) * 0.99), None, "that far it may come");
            }
            None => lost += u64::from(!trap.survives(&trap.places(), PIECES, 150.0 / f64::from(PIECES))),
        }
    }
    println!("{proven} proven, {lost} more survive no sequence");
    assert!(proven > 60 && 10 * lost < proven, "{proven} proven, {lost} more survive no sequence");
}

/// A second robot beside the first one, which is often in its way.
fn trap_of_two(random: &mut SplitMix64) -> Trap {
    let mut trap = trap(random);
    let start = trap.starts[0];
    let (sin, cos) = (start.heading_rad + 1.4 * random.signed_unit()).sin_cos();
    let far_um = 170.0 + 160.0 * random.unit();
    let heading_deg = start.heading_rad.to_degrees() + 180.0 + 150.0 * random.signed_unit();
    trap.starts.push(pose(start.x_um + far_um * cos, start.y_um + far_um * sin, heading_deg));
    trap
}

#[test]
fn two_robots_with_a_proof_survive_no_sequence_of_control_states() {
    let mut random = SplitMix64::new(43);
    let (mut proven, mut together) = (0, 0);
    for _ in 0..800 {
        let trap = trap_of_two(&mut random);
        let places = trap.places();
        if !places.iter().all(|place| trap.bed.is_free(*place)) || !are_apart(places[0], places[1]) {
            continue;
        }
        let Some(collision) = trap.inevitable_collision(1e6) else { continue };
        proven += 1;
        together += u64::from(collision.robots().len() == 2);
        let piece_um = way_um(&collision) / f64::from(PIECES_OF_TWO);
        assert!(!trap.survives(&places, PIECES_OF_TWO, piece_um), "{:?} {:?}", trap.starts, trap.bed.discs);
    }
    println!("{proven} proven, {together} of them for both robots");
    assert!(proven > 80 && together > 20, "{proven} proven, {together} of them for both robots");
}

/// The same disc, ahead and a little beside: past the second one the robot turns away.
#[test]
fn a_robot_before_a_disc_must_meet_it_and_one_that_turns_past_it_need_not() {
    let at = |y_um: f64| Trap {
        bed: DiscBed {
            radius_um: 160.0,
            turning: Turning::Clockwise,
            discs: vec![([125.0 + 30.0 + 100.0, y_um], 100.0)],
        },
        starts: vec![pose(0.0, 0.0, 0.0)],
    };
    let collision = at(0.0).inevitable_collision(1_000.0).expect("it runs or turns into the disc");
    assert!(collision.obstacles() == [0] && (20.0..60.0).contains(&way_um(&collision)), "{collision:?}");
    assert_eq!(at(0.0).inevitable_collision(10.0), None);
    assert_eq!(at(120.0).inevitable_collision(1_000.0), None);
}
