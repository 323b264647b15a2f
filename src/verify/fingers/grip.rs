//! The fingers that hold the part, and the pose of the part while they move.
//!
//! Tips translate and roll: the pose in the plane is the one in which all tips touch and none has slipped. Without
//! slip, the path along the outline and the world angle of its normal change together (w + l2 φ is constant), so the
//! law holds at every instant and not only between neighbouring contacts. Two or three fingers give more equations
//! than the pose has unknowns: the pose is their least-squares solution by Gauss-Newton, starting from the last pose,
//! and its residual is the tips' deviation from rolling and touching exactly.

use super::super::geometry::contour::Foot;
use super::Point;
use super::body::{ObjectPose, PartOutlines, Surface};
use crate::device::fingers::Plane;
use crate::real::Real;
use nalgebra::{Matrix3, Vector3};

/// Greatest number of Gauss-Newton corrections of a pose.
const MAX_CORRECTIONS: usize = 60;

/// Length of a correction at which the iteration has converged.
const SETTLED_UM: f64 = 1e-11;

/// A holding tip.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct HoldingTip {
    pub finger: usize,
    /// Its contact on the outline.
    pub foot: Foot,
    /// Sum of rolled distance and the part's turn (w + l2 φ): constant as long as the tip does not slip.
    anchor_rad: f64,
    /// Height above the section's plane.
    height_um: f64,
    /// Gap at the instant when the finger began to hold; kept as an offset, so that it does not move the part.
    gap_um: f64,
}

/// The fingers that hold in a plane; also an empty set, which only carries the pose.
#[derive(Debug, Clone)]
pub(super) struct JudgedGrip {
    pub plane: Plane,
    /// Pose from which turns and shifts are measured.
    reference: ObjectPose,
    /// Shift along the two axes of the plane, and the turn times the part's reach.
    shift_um: Vector3<f64>,
    /// Shift across the plane.
    lift_um: f64,
    reach_um: f64,
    tip_radius_um: f64,
    /// Holding tips, sorted by finger.
    pub holds: Vec<HoldingTip>,
}

/// Deviation of tips from touching and rolling exactly.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct RollingMisfit {
    /// The finger with the largest gap, and that gap: positive outside the part, negative inside.
    pub gap_um: (usize, f64),
    /// The finger that slips most, along the outline or across the plane, and its slip.
    pub slip_um: (usize, f64),
}

impl RollingMisfit {
    /// The larger of the two magnitudes.
    pub fn most_um(&self) -> f64 {
        self.gap_um.1.abs().max(self.slip_um.1.abs())
    }
}

impl JudgedGrip {
    /// A grip without fingers.
    pub fn empty(plane: Plane, pose: ObjectPose, body: &PartOutlines, tip_radius_um: f64) -> Self {
        let (shift_um, lift_um) = (Vector3::zeros(), 0.0);
        JudgedGrip {
            plane,
            reference: pose,
            shift_um,
            lift_um,
            reach_um: body.reach_um,
            tip_radius_um,
            holds: Vec::new(),
        }
    }

    /// Turn of the part from the reference pose.
    pub fn turn_rad(&self) -> f64 {
        self.shift_um.z / self.reach_um
    }

    /// Present pose of the part.
    pub fn pose(&self) -> ObjectPose {
        let [first, second, normal] = self.reference.axes(self.plane);
        let shift_um = first * self.shift_um.x + second * self.shift_um.y + normal * self.lift_um;
        ObjectPose {
            position_um: self.reference.position_um + shift_um,
            orientation: self.reference.turned(self.plane, self.turn_rad()),
        }
    }

    /// Whether a finger holds.
    pub fn has(&self, finger: usize) -> bool {
        self.holds.iter().any(|hold| hold.finger == finger)
    }

    /// Adds a finger that holds from now on, at its present position.
    pub fn add(&mut self, surface: &Surface, finger: usize, tip_um: &Point) {
        let (place_um, height_um) = self.pose().section_um(self.plane, tip_um);
        // Only a tip without a valid position has no foot, and the tracks have no such tip.
        let Some(foot) = surface.contour.foot(place_um) else { return };
        let gap_um = foot.distance_um - self.tip_radius_um;
        let anchor_rad = surface.turned_rad(&foot) + self.turn_rad();
        self.holds.push(HoldingTip { finger, foot, anchor_rad, height_um, gap_um });
        self.holds.sort_by_key(|hold| hold.finger);
    }

    /// Removes a finger.
    pub fn remove(&mut self, finger: usize) {
        self.holds.retain(|hold| hold.finger != finger);
    }

    /// Restarts the grip in a plane, with the same fingers and a new reference pose.
    pub fn anew(&self, plane: Plane, body: &PartOutlines, tips_um: &[Point]) -> Option<Self> {
        let mut grip = JudgedGrip::empty(plane, self.pose(), body, self.tip_radius_um);
        let surface = body.surface(plane)?;
        for hold in &self.holds {
            grip.add(surface, hold.finger, &tips_um[hold.finger]);
        }
        Some(grip)
    }

    /// The grip after the tips have moved a little, and its misfit; `None` if no pose is found.
    pub fn follow(&self, surface: &Surface, tips_um: &[Point]) -> Option<(Self, RollingMisfit)> {
        let mut grip = self.clone();
        let places: Vec<([f64; 2], f64)> =
            self.holds.iter().map(|hold| self.reference.section_um(self.plane, &tips_um[hold.finger])).collect();
        let lifts = self.holds.iter().zip(&places).map(|(hold, (_, height_um))| height_um - hold.height_um);
        grip.lift_um = lifts.sum::<f64>() / self.holds.len() as f64;
        for _ in 0..MAX_CORRECTIONS {
            let correction_um = grip.correction_um(surface, &places)?;
            grip.shift_um += correction_um;
            if correction_um.norm() < SETTLED_UM {
                break;
            }
        }
        let feet: Vec<Foot> = grip.equations(surface, &places)?.into_iter().map(|equation| equation.foot).collect();
        grip.holds.iter_mut().zip(feet).for_each(|(hold, foot)| hold.foot = foot);
        let misfit = grip.misfit(surface, &places)?;
        misfit.most_um().is_finite().then_some((grip, misfit))
    }

    fn correction_um(&self, surface: &Surface, places: &[([f64; 2], f64)]) -> Option<Vector3<f64>> {
        let (mut square, mut right) = (Matrix3::zeros(), Vector3::zeros());
        for equation in self.equations(surface, places)? {
            for (slope, off_um) in [(equation.gap, equation.gap_um), (equation.slip, equation.slip_um)] {
                square += slope * slope.transpose();
                right -= slope * off_um;
            }
        }
        let correction_um = square.cholesky()?.solve(&right);
        // Limits the correction: the part does not jump.
        let longest_um = self.reach_um.min(self.tip_radius_um);
        let share = (longest_um / correction_um.norm()).min(1.0);
        correction_um.iter().all(|value| value.is_finite()).then_some(correction_um * share)
    }

    fn equations(&self, surface: &Surface, places: &[([f64; 2], f64)]) -> Option<Vec<Equation>> {
        let pairs = self.holds.iter().zip(places);
        pairs.map(|(hold, (place_um, _))| self.equation(surface, hold, *place_um)).collect()
    }

    fn equation(&self, surface: &Surface, hold: &HoldingTip, [x_um, y_um]: [f64; 2]) -> Option<Equation> {
        let (sin, cos) = self.turn_rad().sine_cosine();
        let (x_um, y_um) = (x_um - self.shift_um.x, y_um - self.shift_um.y);
        let tip_um = [cos * x_um + sin * y_um, cos * y_um - sin * x_um];
        let foot = surface.contour.foot_near(tip_um, hold.foot.arc_length_um)?;
        let (normal_y, normal_x) = foot.normal_rad.sine_cosine();
        // Derivatives of the tip's position in the part's coordinates with respect to the shift along each axis and
        // the turn.
        let slopes = [[-cos, sin], [-sin, -cos], [tip_um[1] / self.reach_um, -tip_um[0] / self.reach_um]];
        let outward = Vector3::from(slopes.map(|[x, y]| normal_x * x + normal_y * y));
        let along = Vector3::from(slopes.map(|[x, y]| normal_x * y - normal_y * x));
        let (curvature, radius_um) = (foot.curvature_per_um, self.tip_radius_um);
        let rolling = (1.0 + radius_um * curvature) / (1.0 + foot.distance_um * curvature);
        let turning = Vector3::new(0.0, 0.0, radius_um / self.reach_um);
        Some(Equation {
            foot,
            gap: outward,
            gap_um: foot.distance_um - radius_um - hold.gap_um,
            slip: along * rolling + turning,
            slip_um: radius_um * (surface.turned_rad(&foot) + self.turn_rad() - hold.anchor_rad),
        })
    }

    fn misfit(&self, surface: &Surface, places: &[([f64; 2], f64)]) -> Option<RollingMisfit> {
        let first = self.holds.first().map_or(0, |hold| hold.finger);
        let mut misfit = RollingMisfit { gap_um: (first, 0.0), slip_um: (first, 0.0) };
        let worse = |most: &mut (usize, f64), finger: usize, off_um: f64| {
            if off_um.is_nan() || off_um.abs() > most.1.abs() {
                *most = (finger, off_um);
            }
        };
        for ((hold, (_, height_um)), equation) in self.holds.iter().zip(places).zip(self.equations(surface, places)?) {
            worse(&mut misfit.gap_um, hold.finger, equation.gap_um + hold.gap_um);
            worse(&mut misfit.slip_um, hold.finger, equation.slip_um);
            worse(&mut misfit.slip_um, hold.finger, height_um - hold.height_um - self.lift_um);
        }
        Some(misfit)
    }
}

/// Equations of one tip on the pose, as residuals with their gradients: a gap of zero, and no slip.
struct Equation {
    foot: Foot,
    gap: Vector3<f64>,
    gap_um: f64,
    slip: Vector3<f64>,
    slip_um: f64,
}
