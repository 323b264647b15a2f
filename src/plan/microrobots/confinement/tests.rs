//! Proofs of confinement compared with sequences of arm positions on a coarse clock, by independent motion and
//! distances, forwards from the start and backwards from the goal.

use super::*;
use crate::claims::microrobots::Precision;
use crate::device::microrobots::Turning;
use crate::plan::microrobots::bound::together::EXACT;
use crate::plan::microrobots::disc_oracle::{DiscBed, place, turning};
use crate::plan::microrobots::world::fixture::pose;
use crate::random::SplitMix64;

/// Pieces of a sequence of arm positions.
const PIECES: u32 = 14;

/// Instants of a piece at which it is checked.
const PARTS: u32 = 4;

/// A robot among discs.
struct Bay {
    bed: DiscBed,
    pose: Pose,
    slack: Precision,
}

impl Bay {
    fn confinement(&self, end: PathEnd, needed_um: f64) -> Option<Confinement> {
        let near = PoseWithin { pose: self.pose, slack: self.slack };
        let world = CollisionWorld::new(&self.bed.order(&[self.pose]));
        ConfinementQuestion { world: &world, robot: 0, near, end, needed_um }.confinement(&RESOLUTIONS)
    }

    /// Whether some sequence of `pieces` pieces, each with the arm up or down, is free at some instants of each.
    fn survives(&self, place: [f64; 3], pieces: u32, piece_um: f64) -> bool {
        let goes_on = |is_down: &bool| {
            let at = |part: u32| self.bed.gone(place, piece_um * f64::from(part) / f64::from(PARTS), *is_down);
            (1..=PARTS).all(|part| self.bed.is_free(at(part))) && self.survives(at(PARTS), pieces - 1, piece_um)
        };
        pieces == 0 || [false, true].iter().any(goes_on)
    }

    /// Places within the slack, one of them in the middle.
    fn places(&self, random: &mut SplitMix64) -> Vec<[f64; 3]> {
        let [x_um, y_um, heading_rad] = place(self.pose);
        let beside = |random: &mut SplitMix64| {
            let (sin, cos) = (TAU * random.unit()).sin_cos();
            let turned = self.slack.heading_rad * random.signed_unit();
            [x_um + self.slack.place_um * cos, y_um + self.slack.place_um * sin, heading_rad + turned]
        };
        std::iter::once([x_um, y_um, heading_rad]).chain((0..4).map(|_| beside(random))).collect()
    }
}

/// A robot with a few discs in front of it, or behind a goal; or with a ring of discs about it.
fn bay(random: &mut SplitMix64, end: PathEnd) -> Bay {
    let turning = turning(random);
    let start = pose(100.0 * random.unit(), 100.0 * random.unit(), 360.0 * random.unit());
    let (ahead, slack) = match end {
        PathEnd::Start => (0.0, EXACT),
        PathEnd::Goal => (PI, Precision { place_um: 2.0, heading_rad: 0.02 }),
    };
    let radius_um = 80.0 + 160.0 * random.unit();
    let (is_ring, count) = (random.below(3) > 0, 7 + random.below(3));
    let disc = |random: &mut SplitMix64, at: usize| {
        let (disc_um, aside, gap_um) = match is_ring {
            true => (70.0 + 80.0 * random.unit(), (at as f64 + random.unit()) / count as f64 * TAU, 130.0),
            false => (40.0 + 160.0 * random.unit(), 2.2 * random.signed_unit(), 50.0),
        };
        let far_um = disc_um + gap_um + 110.0 * random.unit();
        let (sin, cos) = (start.heading_rad + ahead + aside).sin_cos();
        ([start.x_um + far_um * cos, start.y_um + far_um * sin], disc_um)
    };
    let discs = (0..if is_ring { count } else { 3 + random.below(3) }).map(|at| disc(random, at)).collect();
    Bay { bed: DiscBed { radius_um, turning, discs }, pose: start, slack }
}

fn no_confined_robot_survives(end: PathEnd, seed: u64, sign: f64) {
    let mut random = SplitMix64::new(seed);
    let (mut proven, mut lost, mut turned) = (0, 0, 0);
    for _ in 0..1_500 {
        let bay = bay(&mut random, end);
        let places = bay.places(&mut random);
        if !places.iter().all(|place| bay.bed.is_free(*place)) {
            continue;
        }
        let survive = |way_um: f64| {
            let piece_um = sign * way_um / f64::from(PIECES);
            places.iter().any(|place| bay.survives(*place, PIECES, piece_um))
        };
        match bay.confinement(end, 1e6) {
            Some(found) => {
                proven += 1;
                turned += u64::from(found.way_um > bay.bed.radius_um);
                assert!(!survive(found.way_um), "{:?} {} {:?}", bay.pose, bay.bed.radius_um, bay.bed.discs);
                assert!(found.end == end && !found.obstacles.is_empty());
                let closer = bay.confinement(end, found.way_um * 0.99);
                assert!(closer.is_none_or(|closer| closer.way_um < found.way_um * 0.99), "not farther than needed");
            }
            None => lost += u64::from(!survive(300.0)),
        }
    }
    println!("{proven} proven, {turned} of them on longer paths, {lost} more survive no sequence");
    assert!(proven > 100 && turned > 20 && lost < proven, "{proven} proven, {turned} longer, {lost} lost");
}

#[test]
fn a_robot_confined_to_its_start_survives_no_sequence_of_arm_positions() {
    no_confined_robot_survives(PathEnd::Start, 51, 1.0);
}

#[test]
fn a_goal_that_is_shut_off_is_reached_by_no_sequence_of_arm_positions() {
    no_confined_robot_survives(PathEnd::Goal, 52, -1.0);
}

/// Between two discs, a robot that turns to the right cannot leave; one with more room can.
#[test]
fn a_robot_leaves_a_bay_only_if_the_bay_is_wide_enough() {
    let bay = |gap_um: f64| Bay {
        bed: DiscBed {
            radius_um: 160.0,
            turning: Turning::Clockwise,
            discs: vec![([125.0 + 150.0 + gap_um, 40.0], 150.0), ([80.0, -30.0 - 150.0 - gap_um], 150.0)],
        },
        pose: pose(0.0, 0.0, 0.0),
        slack: EXACT,
    };
    let found = bay(25.0).confinement(PathEnd::Start, 1e4).expect("it is confined");
    assert!((20.0..200.0).contains(&found.way_um), "{found:?}");
    assert_eq!(bay(400.0).confinement(PathEnd::Start, 1e4), None);
}

/// A robot without obstacles is free at once, however coarse the cells.
#[test]
fn a_robot_without_obstacles_is_not_confined() {
    for end in [PathEnd::Start, PathEnd::Goal] {
        let bed = DiscBed { radius_um: 160.0, turning: Turning::Counterclockwise, discs: Vec::new() };
        let free = Bay { bed, pose: pose(3.0, 4.0, 30.0), slack: EXACT };
        assert_eq!(free.confinement(end, 1e5), None);
    }
}
