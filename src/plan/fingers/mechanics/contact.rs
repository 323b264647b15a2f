//! Where tips touch a section.
//!
//! Input: an outline ready for questions, its contacts, and a tip's radius. Output: points, normals and tip centres at any
//! instant of a rolling step.

use crate::claims::fingers::Section;
use crate::geometry::outline::{Curve, PRECISION_UM};
use crate::real::Real;

/// How much nearer than its radius a tip's centre may be to the outline, so that rounding makes no contact unusable.
const TOUCH_UM: f64 = 10.0 * PRECISION_UM;

/// A place where a tip may touch the object, in section coordinates.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Contact {
    pub point_um: [f64; 2],
    /// Outwards, of length 1.
    pub normal: [f64; 2],
    /// The centre of a tip that touches here.
    pub tip_um: [f64; 2],
    /// Whether a tip that touches here cuts the outline nowhere else.
    pub usable: bool,
}

impl Contact {
    /// How far the centres of tips on two contacts are apart.
    pub fn tips_apart_um(&self, other: &Contact) -> f64 {
        let [x_um, y_um] = [0, 1].map(|k| self.tip_um[k] - other.tip_um[k]);
        (x_um * x_um + y_um * y_um).sqrt()
    }
}

/// The contacts of a section.
#[derive(Debug, Clone, Copy)]
pub struct Contacts<'a> {
    curve: &'a Curve,
    number: usize,
    step_rad: f64,
    tip_radius_um: f64,
    /// Then no tip that touches somewhere cuts the outline elsewhere.
    is_convex: bool,
}

impl<'a> Contacts<'a> {
    /// Those of a section whose outline `curve` follows.
    pub fn of(section: &Section, curve: &'a Curve, tip_radius_um: f64) -> Self {
        let is_convex = curve.least_curvature_per_um() >= 0.0;
        Contacts { curve, number: section.contacts as usize, step_rad: section.step_rad, tip_radius_um, is_convex }
    }

    /// c.
    pub fn number(&self) -> usize {
        self.number
    }

    /// The radius of a tip.
    pub fn tip_radius_um(&self) -> f64 {
        self.tip_radius_um
    }

    /// By how much a step turns the object.
    pub fn step_rad(&self) -> f64 {
        self.step_rad
    }

    /// How far the outline reaches from the origin.
    pub fn reach_um(&self) -> f64 {
        self.curve.reach_um()
    }

    /// One of them, counted from 0, where the object has turned by a part of a step since it was touched.
    pub fn one(&self, contact: usize, part_of_step: f64) -> Contact {
        self.at((contact as f64 - part_of_step) * self.step_rad)
    }

    /// All of them, where the object has turned by a part of a step since they were touched: 0 for the contacts themselves; at 1
    /// each is where the one before it was.
    pub fn after(&self, part_of_step: f64) -> Vec<Contact> {
        (0..self.number)
            .map(|index| {
                let mut contact = self.at((index as f64 - part_of_step) * self.step_rad);
                contact.usable = self.is_convex || self.touches_once(&contact);
                contact
            })
            .collect()
    }

    fn at(&self, rolled_rad: f64) -> Contact {
        let spot = self.curve.spot(self.curve.way_rolled_um(rolled_rad, self.tip_radius_um));
        let (sin, cos) = spot.normal_rad.sine_cosine();
        let [x, y] = spot.point_um;
        let tip_um = [x + self.tip_radius_um * cos, y + self.tip_radius_um * sin];
        Contact { point_um: spot.point_um, normal: [cos, sin], tip_um, usable: true }
    }

    fn touches_once(&self, contact: &Contact) -> bool {
        self.curve.nearest(contact.tip_um).distance_um >= self.tip_radius_um - TOUCH_UM
    }
}
