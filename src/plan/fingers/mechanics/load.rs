//! External load on the object, and the wrenches that fingers must exert against it.

use crate::device::fingers::Plane;
use crate::real::Real;
use nalgebra::{UnitQuaternion, Vector3};

/// Out-of-plane share of a force below which it is attributed to rounding.
const ROUNDING: f64 = 1e-12;

/// A force on the object, seen from a section at an instant.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Load {
    /// In-plane component, in section coordinates, in micronewtons.
    pub force_un: [f64; 2],
    /// Out-of-plane component, along the plane's normal, in micronewtons.
    pub across_un: f64,
    /// Point of action, in section coordinates.
    pub at_um: [f64; 2],
    /// Height of the point of action above the plane, along its normal.
    pub height_um: f64,
}

impl Load {
    /// No load.
    pub const NONE: Load = Load { force_un: [0.0; 2], across_un: 0.0, at_um: [0.0; 2], height_um: 0.0 };

    /// A force given in the hand's frame, on a part with the given orientation, seen from the section of a plane.
    pub fn seen(plane: Plane, orientation: &UnitQuaternion<f64>, load_un: [f64; 3], centre_um: [f64; 3]) -> Load {
        let force_un = orientation.inverse() * Vector3::from(load_un);
        let along = |axis: [f64; 3], of: &Vector3<f64>| Vector3::from(axis).dot(of);
        let [x, y] = plane.axes();
        let centre_um = Vector3::from(centre_um);
        let least_un = ROUNDING * force_un.norm();
        let part = |axis| Some(along(axis, &force_un)).filter(|part: &f64| part.abs() > least_un).unwrap_or(0.0);
        Load {
            force_un: [part(x), part(y)],
            across_un: part(plane.normal()),
            at_um: [along(x, &centre_um), along(y, &centre_um)],
            height_um: along(plane.normal(), &centre_um),
        }
    }

    /// Whether it is the same for every rotation of the part in the plane: it has no in-plane component.
    pub fn is_across(&self) -> bool {
        self.force_un == [0.0; 2]
    }

    /// Whether it has no component across the plane and no torque out of it.
    pub fn is_in_plane(&self) -> bool {
        self.across_un == 0.0 && (self.height_um == 0.0 || self.force_un == [0.0; 2])
    }

    /// Out-of-plane force and torque that the fingers must exert against it.
    pub(super) fn across(&self) -> Across {
        let ([x_um, y_um], [fx_un, fy_un]) = (self.at_um, self.force_un);
        let torque_un_um =
            [y_um * self.across_un - self.height_um * fy_un, self.height_um * fx_un - x_um * self.across_un];
        Across { force_un: -self.across_un, torque_un_um: torque_un_um.map(|torque| -torque) }
    }

    /// Whether there is no load.
    pub fn is_none(&self) -> bool {
        self.size_un() == 0.0
    }

    /// Magnitude, in micronewtons.
    pub fn size_un(&self) -> f64 {
        let [x_un, y_un] = self.force_un;
        (x_un * x_un + y_un * y_un + self.across_un * self.across_un).sqrt()
    }

    /// The same force after the part has turned in the section's plane; in the part's frame the force turns in the
    /// opposite direction.
    pub fn after_turn(&self, angle_rad: f64) -> Load {
        let (sin, cos) = angle_rad.sine_cosine();
        let [x, y] = self.force_un;
        Load { force_un: [x * cos + y * sin, y * cos - x * sin], ..*self }
    }
}

/// Out-of-plane force and torque that fingers must exert, about the origin of the section.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Across {
    pub force_un: f64,
    /// About the two axes of the plane.
    pub torque_un_um: [f64; 2],
}

/// A wrench on the object in the plane: force, and moment about the origin.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Wrench {
    pub force_un: [f64; 2],
    /// Counter-clockwise.
    pub moment_un_um: f64,
}

impl Wrench {
    /// No force.
    pub const NONE: Wrench = Wrench { force_un: [0.0; 2], moment_un_um: 0.0 };

    /// The wrench of a force that acts at a point.
    pub fn of(force_un: [f64; 2], at_um: [f64; 2]) -> Wrench {
        Wrench { force_un, moment_un_um: at_um[0] * force_un[1] - at_um[1] * force_un[0] }
    }

    /// The wrench that balances this one and another.
    pub fn against(self, other: Wrench) -> Wrench {
        Wrench {
            force_un: [-self.force_un[0] - other.force_un[0], -self.force_un[1] - other.force_un[1]],
            moment_un_um: -self.moment_un_um - other.moment_un_um,
        }
    }
}

/// Condition for a grasp to hold.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum GripDemand {
    /// No load and no adhesion: any equilibrium with forces that are not all zero.
    Squeeze,
    /// The fingers can exert this wrench.
    Exert(Wrench),
}
