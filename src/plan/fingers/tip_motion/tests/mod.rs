//! Sections for the tests, and the courses that they share.

mod course;
mod reach;
mod rolling;
mod travel;

use super::*;
use crate::device::fingers::fixture::hand;
use crate::geometry::outline::Outline;
use crate::plan::fingers::TipsMove;
use nalgebra::{Quaternion, UnitQuaternion, Vector2, Vector3};

/// The paper's hand, with a fine tolerance.
pub fn facts(fingers: u32) -> FingersFacts {
    FingersFacts { fingers, ..hand() }
}

/// The paper's ellipsoid.
pub fn ellipse() -> Outline {
    Outline::Ellipse { semi_um: [16.0, 11.845] }
}

/// An outline with a waist above and below, within reach of the tips.
pub fn peanut() -> Outline {
    let place = |index: u32| {
        let turn_rad = TAU * f64::from(index) / 48.0;
        let radius_um = 16.0 + 5.2 * (2.0 * turn_rad).cos();
        [radius_um * turn_rad.cos(), radius_um * turn_rad.sin()]
    };
    Outline::Spline { points_um: (0..48).map(place).collect() }
}

/// A part of two equal sections, with all data that a hand needs.
pub struct Bench {
    pub facts: FingersFacts,
    pub section: Section,
    pub curve: Curve,
    pub reach: ContactReach,
}

impl Bench {
    pub fn new(outline: Outline, facts: FingersFacts) -> Bench {
        let curve = Curve::of(&outline).expect("an outline of these tests is sound");
        let round_rad = curve.rolled_rad(curve.perimeter_um(), facts.tip_radius_um);
        let contacts = 2 * (round_rad / facts.step_rad() / 2.0).round() as u32;
        let step_rad = round_rad / f64::from(contacts);
        let section = Section { outline, contacts, opposite: Some(1 + contacts / 2), step_rad };
        let reach = ContactReach::new(&curve, &facts, contacts);
        Bench { facts, section, curve, reach }
    }

    pub fn hand(&self) -> HandSections<'_> {
        let side = PreparedSection { section: &self.section, curve: &self.curve, reach: &self.reach };
        HandSections { facts: &self.facts, xy: side, xz: Some(side) }
    }

    /// A course of one step from home.
    pub fn course(&self, acts: Vec<FingerAct>) -> FingersCourse {
        FingersCourse { start: self.hand().home([0.0; 3]), steps: vec![acts] }
    }
}

/// Both outlines, with a hand of `fingers` fingers.
pub fn benches(fingers: u32) -> [Bench; 2] {
    [ellipse(), peanut()].map(|outline| Bench::new(outline, facts(fingers)))
}

pub fn begin(plane: Plane, grasp: &[u32]) -> FingerAct {
    FingerAct::Begin { plane, grasp: grasp.to_vec() }
}

/// Deterministic pseudo-random numbers.
pub struct Dice(u64);

impl Dice {
    pub fn new(seed: u64) -> Dice {
        Dice(seed)
    }

    pub fn below(&mut self, end: usize) -> usize {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 33) as usize % end
    }
}

/// The rotation of a state's quaternion.
pub fn rotation(orientation: [f64; 4]) -> UnitQuaternion<f64> {
    let [w, x, y, z] = orientation;
    UnitQuaternion::new_normalize(Quaternion::new(w, x, y, z))
}

/// A point of the hand's frame in the coordinates of a plane of the part, and its distance from that plane.
pub fn in_section(hold: &HeldGrasp, tip_um: [f64; 3]) -> (Vector2<f64>, f64) {
    let own = rotation(hold.orientation).inverse() * (Vector3::from(tip_um) - Vector3::from(hold.position_um));
    let [first, second] = hold.plane.axes().map(Vector3::from);
    (Vector2::new(own.dot(&first), own.dot(&second)), own.dot(&first.cross(&second)))
}
