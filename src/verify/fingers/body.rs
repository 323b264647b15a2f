//! Pose of the part between the tips, and distances of its outlines from a tip.
//!
//! Only the part's two sections are known. For a tip whose centre lies in the plane of a section, the distance from
//! the part is that from the section's outline. For any other tip the verifier knows only a lower bound: the distance
//! from a sphere round the part's origin that encloses both sections.

use super::super::geometry::contour::{Contour, Foot};
use super::Point;
use crate::claims::fingers::{HandPart, Section};
use crate::device::fingers::Plane;
use nalgebra::UnitQuaternion;
use std::f64::consts::TAU;

/// Pose of the part: its origin in the hand's frame, and the rotation from its axes to the hand's.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct ObjectPose {
    pub position_um: Point,
    pub orientation: UnitQuaternion<f64>,
}

impl ObjectPose {
    /// The section's two axes and its normal, in the hand's frame.
    pub fn axes(&self, plane: Plane) -> [Point; 3] {
        let [first, second] = plane.axes();
        [first, second, plane.normal()].map(|axis| self.orientation * Point::from(axis))
    }

    /// A point in the coordinates of a section, and its height above the section's plane.
    pub fn section_um(&self, plane: Plane, place_um: &Point) -> ([f64; 2], f64) {
        let from_origin = place_um - self.position_um;
        let [x, y, z] = self.axes(plane).map(|axis| axis.dot(&from_origin));
        ([x, y], z)
    }

    /// The orientation of the part after a turn about the normal of a plane.
    pub fn turned(&self, plane: Plane, turn_rad: f64) -> UnitQuaternion<f64> {
        self.orientation * UnitQuaternion::from_scaled_axis(Point::from(plane.normal()) * turn_rad)
    }
}

/// An outline with its contacts, prepared for queries.
#[derive(Debug)]
pub(super) struct Surface {
    pub contour: Contour,
    contacts: u32,
    step_rad: f64,
    tip_radius_um: f64,
}

impl Surface {
    /// Prepares a section; `None` if its outline cannot be followed.
    pub fn of(section: &Section, tip_radius_um: f64) -> Option<Self> {
        let contour = Contour::of(&section.outline)?;
        Some(Surface { contour, contacts: section.contacts, step_rad: section.step_rad, tip_radius_um })
    }

    /// Turn of the part while a tip rolls from one contact to the next.
    pub fn contact_step_rad(&self) -> f64 {
        self.step_rad
    }

    /// Turn of the part while a tip rolls once round the outline.
    pub fn round_rad(&self) -> f64 {
        TAU + self.contour.round_um() / self.tip_radius_um
    }

    /// Turn of the part while a tip rolls from contact 1 to a point of the outline.
    pub fn turned_rad(&self, foot: &Foot) -> f64 {
        foot.turn_of_tip_rad(self.tip_radius_um)
    }

    /// The point of a contact, numbered from 1.
    pub fn contact_place(&self, contact: u32) -> Option<Foot> {
        self.contour.rolled_to(f64::from(contact.saturating_sub(1)) * self.step_rad, self.tip_radius_um)
    }

    /// The number of the nearest contact, and the distance that a tip's centre would roll to it.
    pub fn contact(&self, foot: &Foot) -> (u32, f64) {
        let rolled_rad = self.turned_rad(foot);
        let steps = (rolled_rad / self.step_rad).round();
        let off_um = (rolled_rad - steps * self.step_rad).abs() * self.tip_radius_um;
        // Below MAX_CONTACTS.
        (steps.rem_euclid(f64::from(self.contacts)) as u32 % self.contacts + 1, off_um)
    }
}

/// The part's outlines.
#[derive(Debug)]
pub(super) struct PartOutlines {
    xy: Surface,
    xz: Option<Surface>,
    /// Greatest distance of the part's sections from its origin.
    pub reach_um: f64,
}

impl PartOutlines {
    /// Prepares a part; `None` if an outline cannot be followed.
    pub fn of(part: &HandPart, tip_radius_um: f64) -> Option<Self> {
        let xy = Surface::of(&part.xy, tip_radius_um)?;
        let xz = match &part.xz {
            Some(section) => Some(Surface::of(section, tip_radius_um)?),
            None => None,
        };
        let reach_um = xz.as_ref().map_or(0.0, |xz| xz.contour.radius_um()).max(xy.contour.radius_um());
        Some(PartOutlines { xy, xz, reach_um })
    }

    /// The part's outline in a plane, if it has one.
    pub fn surface(&self, plane: Plane) -> Option<&Surface> {
        match plane {
            Plane::Xy => Some(&self.xy),
            Plane::Xz => self.xz.as_ref(),
        }
    }

    /// The planes in which the part has outlines.
    pub fn planes(&self) -> impl Iterator<Item = Plane> + '_ {
        Plane::ALL.into_iter().filter(|plane| self.surface(*plane).is_some())
    }

    /// The point of an outline nearest to a tip whose centre lies in the outline's plane, within the tolerance.
    pub fn foot(&self, pose: &ObjectPose, plane: Plane, tip_um: &Point, tolerance_um: f64) -> Option<Foot> {
        let (place_um, height_um) = pose.section_um(plane, tip_um);
        let surface = self.surface(plane).filter(|_| height_um.abs() <= tolerance_um)?;
        surface.contour.foot(place_um)
    }

    /// Lower bound on the distance of a tip's centre from the part; need not be the best bound once it reaches
    /// `enough_um`.
    pub fn gap_um(&self, pose: &ObjectPose, tip_um: &Point, tolerance_um: f64, enough_um: f64) -> f64 {
        let sphere_um = (tip_um - pose.position_um).norm() - self.reach_um;
        if sphere_um >= enough_um {
            return sphere_um;
        }
        let outlines = self.planes().filter_map(|plane| self.foot(pose, plane, tip_um, tolerance_um));
        outlines.map(|foot| foot.distance_um).reduce(f64::min).unwrap_or(sphere_um)
    }
}
