//! Collision rules for one leg of the whole bed.

use super::statics::Nearness;
use super::tracks::{MotionKind, RobotTrack, far_apart, first_near, first_near_convex};
use super::{Collision, FirstCollision, LegCursor, MARGIN_UM, OrbitDisc, WorldObstacle, statics};

impl LegCursor<'_> {
    /// The first collision of the leg whose tracks are set.
    pub(super) fn collision(&self, leg: usize) -> Option<FirstCollision> {
        let mut first: Option<(f64, Collision)> = None;
        let mut record = |at: Option<f64>, collision: Collision| {
            if let Some(at) = at.filter(|at| first.is_none_or(|(earlier, _)| *at < earlier)) {
                first = Some((at, collision));
            }
        };
        for (robot, track) in self.tracks.iter().enumerate() {
            if track.kind != MotionKind::Rests {
                self.obstacles_of(robot, &mut record);
            }
            for other in robot + 1..self.tracks.len() {
                record(self.bodies(robot, other), Collision::Robots { robot, other });
            }
            if self.orbits[leg * self.tracks.len() + robot] {
                self.orbit_of(leg, robot, &mut record);
            }
        }
        let (strokes, collision) = first?;
        let (robot, other) = collision.robots();
        let [at, with] = [robot, other].map(|robot| self.tracks[robot].pose_at(strokes));
        Some(FirstCollision { collision, leg, strokes, at, with })
    }

    fn obstacles_of(&self, robot: usize, record: &mut impl FnMut(Option<f64>, Collision)) {
        let track = &self.tracks[robot];
        for (obstacle, body) in self.world.obstacles.iter().enumerate() {
            let asked = Nearness::first(self.world.keep_um);
            record(statics::meets_obstacle(track, body, asked), Collision::Obstacle { robot, obstacle });
        }
    }

    /// Checks the disc of an orbiting robot against everything else.
    fn orbit_of(&self, leg: usize, robot: usize, record: &mut impl FnMut(Option<f64>, Collision)) {
        let RobotTrack { centre_um, reach_um, .. } = self.tracks[robot];
        let disc = OrbitDisc { centre_um, radius_um: reach_um };
        let keep_um = self.world.orbit_keep_um;
        for (obstacle, WorldObstacle { body, .. }) in self.world.obstacles.iter().enumerate() {
            let near = disc.to_rounded_um(body) < keep_um + MARGIN_UM;
            record(near.then_some(0.0), Collision::OrbitObstacle { robot, obstacle });
        }
        for (other, track) in self.tracks.iter().enumerate().filter(|(other, _)| *other != robot) {
            let met = statics::meets_disc(track, &disc, Nearness::first(keep_um));
            record(met, Collision::OrbitRobot { robot, other });
            if other > robot && self.orbits[leg * self.tracks.len() + other] {
                let theirs = OrbitDisc { centre_um: track.centre_um, radius_um: track.reach_um };
                let near = disc.to_disc_um(&theirs) < keep_um + MARGIN_UM;
                record(near.then_some(0.0), Collision::Orbits { robot, other });
            }
        }
    }

    /// The first instant at which two bodies are too near.
    fn bodies(&self, robot: usize, other: usize) -> Option<f64> {
        let (one, two) = (&self.tracks[robot], &self.tracks[other]);
        if (one.kind, two.kind) == (MotionKind::Rests, MotionKind::Rests) || far_apart(one, two, self.world.keep_um) {
            return None;
        }
        let near_from = self.near_from(robot, other).clamp(0.0, one.strokes);
        let clear = (near_from > 0.0).then(|| bodies_near(one, two, [0.0, near_from], self.world.keep_um));
        let docking = || {
            let overlap_um = self.world.keep_um.min(-self.world.overlap_um);
            (near_from < one.strokes).then(|| bodies_near(one, two, [near_from, one.strokes], overlap_um))
        };
        clear.flatten().or_else(|| docking().flatten())
    }
}

fn bodies_near(one: &RobotTrack, two: &RobotTrack, span: [f64; 2], keep_um: f64) -> Option<f64> {
    let distance_um = |at: f64| one.at(at).to_rectangle_um(&two.at(at));
    if one.kind == MotionKind::Turns || two.kind == MotionKind::Turns {
        return first_near(span, one.speed_um + two.speed_um, keep_um, distance_um);
    }
    first_near_convex(span, keep_um, distance_um)
}

impl Collision {
    /// The first robot and the other one; the first one twice if there is no other.
    pub fn robots(&self) -> (usize, usize) {
        match *self {
            Collision::Obstacle { robot, .. } | Collision::OrbitObstacle { robot, .. } => (robot, robot),
            Collision::Robots { robot, other }
            | Collision::OrbitRobot { robot, other }
            | Collision::Orbits { robot, other } => (robot, other),
        }
    }
}
