//! The path of one robot as arm positions and whole strokes.
//!
//! Input: a path of arcs and straight lines in micrometres, and its required end. Output: the same path in whole
//! strokes, of a given total number where required. Promise: the returned path ends within the precision; its pieces
//! change by a few strokes each.

use crate::claims::microrobots::Precision;
use crate::device::microrobots::{Arm, Robot, wrapped_rad};
use crate::geometry::Pose;
use crate::plan::microrobots::free::ArmSegment;
use crate::real::Real;

/// Changes of a piece that are tried, in strokes, the largest first.
const CHANGES: [i64; 7] = [64, 27, 9, 5, 3, 2, 1];

/// Share of the precision at which a path is accepted without further correction.
const GOOD_SHARE: f64 = 0.02;

/// Rounds of corrections.
const MAX_ROUNDS: usize = 40;

/// Rounding tolerance of a heading, in radians.
const ROUNDING_RAD: f64 = 1e-9;

/// Arm positions of one robot over time.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct ArmTrack {
    /// Adjacent pieces differ in their arm; each is at least one stroke.
    pub pieces: Vec<(Arm, u64)>,
}

impl ArmTrack {
    pub fn push(&mut self, arm: Arm, strokes: u64) {
        match self.pieces.last_mut() {
            Some((last, count)) if *last == arm => *count += strokes,
            Some(_) | None if strokes == 0 => {}
            Some(_) | None => self.pieces.push((arm, strokes)),
        }
    }

    pub fn extend(&mut self, other: &ArmTrack) {
        other.pieces.iter().for_each(|&(arm, strokes)| self.push(arm, strokes));
    }

    /// The same track with each arm change moved to a change of the other track, if that is at most `most` strokes
    /// away: fewer control states are set.
    pub fn aligned(&self, other: &ArmTrack, most: u64) -> ArmTrack {
        let changes: Vec<u64> = other
            .pieces
            .iter()
            .scan(0, |at, piece| {
                *at += piece.1;
                Some(*at)
            })
            .collect();
        let near = |at: u64| changes.iter().copied().min_by_key(|change| change.abs_diff(at));
        let mut aligned = ArmTrack::default();
        let (mut begun, mut end) = (0, 0);
        for (index, (arm, strokes)) in self.pieces.iter().enumerate() {
            end += strokes;
            let is_last = index + 1 == self.pieces.len();
            let moved = near(end).filter(|change| !is_last && change.abs_diff(end) <= most).unwrap_or(end);
            aligned.push(*arm, moved.saturating_sub(begun));
            begun = begun.max(moved);
        }
        aligned
    }

    /// Pose to which it brings a robot.
    pub fn end(&self, robot: &Robot, from: Pose) -> Pose {
        end(robot, from, &self.pieces)
    }
}

fn end(robot: &Robot, from: Pose, pieces: &[(Arm, u64)]) -> Pose {
    pieces.iter().fold(from, |pose, &(arm, strokes)| robot.moved(pose, arm, robot.step_um * strokes as f64))
}

/// Distance of a pose from its goal, as a share of the precision: the larger one of place and heading.
pub fn miss(precision: Precision, pose: Pose, goal: Pose) -> f64 {
    let place_um = (pose.x_um - goal.x_um).hypotenuse(pose.y_um - goal.y_um);
    let heading_rad = wrapped_rad(pose.heading_rad - goal.heading_rad).abs();
    (place_um / precision.place_um).max(heading_rad / precision.heading_rad)
}

/// Required end of a path: after the fixed motion that follows it, the robot must be at its goal.
#[derive(Debug, Clone, Copy)]
pub struct TrackAim {
    pub goal: Pose,
    pub precision: Precision,
    /// Motion after the path, as the pose to which it brings a robot from the origin.
    pub motion: Pose,
}

impl TrackAim {
    /// Distance from the goal, after the motion, of a robot that ends its path at this pose.
    pub fn miss(&self, pose: Pose) -> f64 {
        miss(self.precision, composed(pose, self.motion), self.goal)
    }

    /// Whether a robot that is this far off the goal's heading comes within precision of it by more or fewer strokes
    /// with its arm down, each of which turns it by the same angle.
    fn can_face(&self, robot: &Robot, off_rad: f64) -> bool {
        let stroke_rad = robot.step_um / robot.turning_radius_um;
        let left_rad = off_rad - stroke_rad * (off_rad / stroke_rad).round();
        left_rad.abs() <= self.precision.heading_rad + ROUNDING_RAD
    }

    /// Whether a path to the goal with this length in turns has a counterpart in whole strokes that ends with the
    /// goal's heading, within precision. If it has none, neither has any other path that turns by the same angle.
    pub fn allows_turn(&self, robot: &Robot, turn_um: f64) -> bool {
        self.can_face(robot, turn_um / robot.turning_radius_um)
    }
}

/// Length of a path's turns.
pub fn turn_um(way: &[ArmSegment]) -> f64 {
    way.iter().filter(|segment| segment.arm == Arm::Down).map(|segment| segment.way_um).sum()
}

/// The second pose in the frame of the first.
pub fn composed(frame: Pose, pose: Pose) -> Pose {
    let (sin, cos) = frame.heading_rad.sine_cosine();
    Pose {
        x_um: frame.x_um + pose.x_um * cos - pose.y_um * sin,
        y_um: frame.y_um + pose.x_um * sin + pose.y_um * cos,
        heading_rad: wrapped_rad(frame.heading_rad + pose.heading_rad),
    }
}

/// A path in whole strokes that ends at the goal within precision, of exactly `total` strokes; `None` if none is found.
///
/// Rounding preserves the sums of turns and of straight lines approximately; a descent that moves strokes between
/// pieces removes the remaining error.
pub fn whole(robot: &Robot, from: Pose, way: &[ArmSegment], aim: &TrackAim, total: u64) -> Option<ArmTrack> {
    let mut pieces = rounded(robot, way);
    let excess = pieces.iter().map(|piece| piece.1).sum::<u64>() as i64 - total as i64;
    let longest = |arm: Arm| (0..pieces.len()).filter(|&at| pieces[at].0 == arm).max_by_key(|&at| pieces[at].1);
    let longest = longest(Arm::Up).or(longest(Arm::Down))?;
    pieces[longest].1 = pieces[longest].1.checked_add_signed(-excess)?;
    let heading_rad = composed(end(robot, from, &pieces), aim.motion).heading_rad;
    if !aim.can_face(robot, wrapped_rad(heading_rad - aim.goal.heading_rad)) {
        return None;
    }
    let best = descend(robot, from, &mut pieces, aim);
    let track = pieces.into_iter().fold(ArmTrack::default(), |mut track, (arm, strokes)| {
        track.push(arm, strokes);
        track
    });
    (best <= 1.0).then_some(track)
}

/// Moves strokes between pieces as long as that brings the end nearer to the goal; returns the remaining miss.
fn descend(robot: &Robot, from: Pose, pieces: &mut [(Arm, u64)], aim: &TrackAim) -> f64 {
    let mut best = aim.miss(end(robot, from, pieces));
    for _ in 0..MAX_ROUNDS {
        let before = best;
        for change in CHANGES {
            for (giver, taker) in pairs(pieces.len()) {
                if best <= GOOD_SHARE {
                    return best;
                }
                let (Some(less), true) = (pieces[giver].1.checked_add_signed(-change), giver != taker) else {
                    continue;
                };
                let old = (pieces[giver].1, pieces[taker].1);
                (pieces[giver].1, pieces[taker].1) = (less, old.1.saturating_add_signed(change));
                let found = aim.miss(end(robot, from, pieces));
                if found < best {
                    best = found;
                } else {
                    (pieces[giver].1, pieces[taker].1) = old;
                }
            }
        }
        if best == before {
            break;
        }
    }
    best
}

/// All ordered pairs of indices.
fn pairs(count: usize) -> impl Iterator<Item = (usize, usize)> {
    (0..count).flat_map(move |one| (0..count).map(move |other| (one, other)))
}

/// Each piece in whole strokes, such that neither the turns nor the straight lines accumulate more than half a stroke
/// of error.
fn rounded(robot: &Robot, way: &[ArmSegment]) -> Vec<(Arm, u64)> {
    let mut owed = [0.0; 2];
    let round = |&ArmSegment { arm, way_um }: &ArmSegment| {
        let owed = &mut owed[usize::from(arm.digit())];
        let wanted = (way_um / robot.step_um + *owed).max(0.0);
        *owed = wanted - wanted.round();
        (arm, wanted.round() as u64)
    };
    way.iter().map(round).collect()
}
