//! Contacts of tips with a section.
//!
//! Input: a prepared outline, its contacts, and a tip's radius. Output: points, normals and tip centres at any instant of a rolling
//! step.

use crate::claims::fingers::Section;
use crate::geometry::outline::{Curve, PRECISION_UM};
use crate::real::Real;

/// Tolerance of a tip centre's distance from the outline, so that rounding makes no contact unusable.
const TOUCH_UM: f64 = 10.0 * PRECISION_UM;

/// A possible contact of a tip with the object, in section coordinates.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Contact {
    pub point_um: [f64; 2],
    /// Outward unit normal.
    pub normal: [f64; 2],
    /// Centre of a tip in contact here.
    pub tip_um: [f64; 2],
    /// Whether a tip in contact here intersects the outline nowhere else.
    pub usable: bool,
}

impl Contact {
    /// Distance between the centres of tips on two contacts.
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
    /// Whether the outline is convex: then no tip in contact intersects it elsewhere.
    is_convex: bool,
}

impl<'a> Contacts<'a> {
    /// The contacts of a section whose outline is `curve`.
    pub fn of(section: &Section, curve: &'a Curve, tip_radius_um: f64) -> Self {
        let is_convex = curve.least_curvature_per_um() >= 0.0;
        Contacts { curve, number: section.contacts as usize, step_rad: section.step_rad, tip_radius_um, is_convex }
    }

    /// Number of contacts, c.
    pub fn number(&self) -> usize {
        self.number
    }

    /// The radius of a tip.
    pub fn tip_radius_um(&self) -> f64 {
        self.tip_radius_um
    }

    /// Angle by which a step turns the object.
    pub fn step_rad(&self) -> f64 {
        self.step_rad
    }

    /// Greatest distance of the outline from the origin.
    pub fn reach_um(&self) -> f64 {
        self.curve.reach_um()
    }

    /// A contact, counted from 0, after the object has turned by a part of a step.
    pub fn one(&self, contact: usize, part_of_step: f64) -> Contact {
        self.at((contact as f64 - part_of_step) * self.step_rad)
    }

    /// All contacts after the object has turned by a part of a step: 0 gives the contacts themselves; at 1 each takes the place of
    /// the one before it.
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
        let spot = self.curve.point_at(self.curve.way_rolled_um(rolled_rad, self.tip_radius_um));
        let (sin, cos) = spot.normal_rad.sine_cosine();
        let [x, y] = spot.point_um;
        let tip_um = [x + self.tip_radius_um * cos, y + self.tip_radius_um * sin];
        Contact { point_um: spot.point_um, normal: [cos, sin], tip_um, usable: true }
    }

    fn touches_once(&self, contact: &Contact) -> bool {
        self.curve.nearest(contact.tip_um).distance_um >= self.tip_radius_um - TOUCH_UM
    }
}
