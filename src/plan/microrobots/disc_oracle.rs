//! Robots among discs, with motion and distances of its own: the oracle of proofs that there is no plan.

use super::world::fixture::{bed, obstacle, pose, robot};
use crate::claims::microrobots::MicrorobotsOrder;
use crate::device::microrobots::{Robot, Turning};
use crate::geometry::{Pose, Shape};
use crate::random::SplitMix64;

const KEEP_UM: f64 = 10.0;
const HALF_UM: [f64; 2] = [125.0, 30.0];

/// Path of one stroke.
pub const STEP_UM: f64 = 0.015;

/// Discs, and what the robots among them have in common.
pub struct DiscBed {
    pub radius_um: f64,
    pub turning: Turning,
    /// Middle and radius of each disc.
    pub discs: Vec<([f64; 2], f64)>,
}

/// A random turning sense.
pub fn turning(random: &mut SplitMix64) -> Turning {
    if random.below(2) == 0 { Turning::Clockwise } else { Turning::Counterclockwise }
}

impl DiscBed {
    /// The order of up to two robots at these poses; the second one's arm is down only if the first one's is.
    pub fn order(&self, starts: &[Pose]) -> MicrorobotsOrder {
        let facts = |label: &str| Robot { turning: self.turning, ..robot(label, self.radius_um, STEP_UM) };
        let discs = self.discs.iter().map(|([x_um, y_um], radius_um)| {
            obstacle("o", Shape::Disc { radius_um: *radius_um }, pose(*x_um, *y_um, 0.0))
        });
        bed(starts.iter().zip(["D1", "D2"]).map(|(start, label)| (facts(label), *start)).collect(), discs.collect())
    }

    /// Whether a body at a place keeps the clearance from the discs.
    pub fn is_free(&self, place: [f64; 3]) -> bool {
        self.discs.iter().all(|(disc, radius_um)| far_um(place, *disc) - radius_um >= KEEP_UM)
    }

    /// Place after a path, or before it if that is negative.
    pub fn gone(&self, [x, y, heading]: [f64; 3], way_um: f64, is_down: bool) -> [f64; 3] {
        if !is_down {
            return [x + way_um * heading.cos(), y + way_um * heading.sin(), heading];
        }
        let curve_um = self.turning.sign() * self.radius_um;
        let later = heading + way_um / curve_um;
        [x + curve_um * (later.sin() - heading.sin()), y - curve_um * (later.cos() - heading.cos()), later]
    }
}

/// Position and heading of a pose.
pub fn place(pose: Pose) -> [f64; 3] {
    [pose.x_um, pose.y_um, pose.heading_rad]
}

/// Distance of a point from a body, in the body's own frame.
fn far_um([x, y, heading]: [f64; 3], point: [f64; 2]) -> f64 {
    let (dx, dy, sin, cos) = (point[0] - x, point[1] - y, heading.sin(), heading.cos());
    let (along, across) = ((dx * cos + dy * sin).abs() - HALF_UM[0], (dy * cos - dx * sin).abs() - HALF_UM[1]);
    along.max(0.0).hypot(across.max(0.0))
}

/// Whether two bodies keep the clearance, by fifty points of each side: a proof allows more than lies between them.
pub fn are_apart(one: [f64; 3], other: [f64; 3]) -> bool {
    let outline = |[x, y, heading]: [f64; 3]| {
        let (sin, cos) = heading.sin_cos();
        let corners = [(1.0, 1.0), (1.0, -1.0), (-1.0, -1.0), (-1.0, 1.0)].map(|(along, across)| {
            let [a, b] = [along * HALF_UM[0], across * HALF_UM[1]];
            [x + a * cos - b * sin, y + a * sin + b * cos]
        });
        (0..200).map(move |at| {
            let (side, share) = (at / 50, f64::from(at as u32 % 50) / 50.0);
            let [from, to] = [corners[side], corners[(side + 1) % 4]];
            [from[0] + share * (to[0] - from[0]), from[1] + share * (to[1] - from[1])]
        })
    };
    let is_clear = |body: [f64; 3], other| outline(other).all(|point| far_um(body, point) >= KEEP_UM);
    is_clear(one, other) && is_clear(other, one)
}
