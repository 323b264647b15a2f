//! Whether robots at their goals hold together: the first two meet head on, each further one meets the structure by its
//! front.
//!
//! Section 3.5 of the paper: two robots that meet head on slide until their fronts are aligned; a robot that comes to a
//! structure turns about the corner that touches first until its front lies along the edge. The angles up to which that
//! happens (`self_aligning_angle`, `sticking_angle`) are angles of approach, not final ones: a goal at an angle to its
//! edge is never reached.

use super::bodies::{RobotBody, SLACK_UM};
use super::errors;
use crate::device::microrobots::{Docking, Robot, wrapped_rad};
use crate::diagnostic::Diagnostic;
use crate::geometry::Pose;
use crate::real::Real;
use crate::source::Span;
use nalgebra::{Point2, Vector2};
use std::f64::consts::{FRAC_PI_2, PI};

/// Rounding allowed in an angle.
const SLACK_RAD: f64 = 1e-9;

/// A robot at its goal.
#[derive(Debug, Clone, Copy)]
pub struct Docked<'a> {
    /// Index among the order's robots.
    pub robot: usize,
    pub facts: &'a Robot,
    pub pose: Pose,
    /// Where the goal stands in the source.
    pub span: Span,
}

impl Docked<'_> {
    /// The body at the goal.
    pub fn body(&self) -> RobotBody {
        RobotBody::of(self.facts, self.pose)
    }

    fn heading(&self) -> Vector2<f64> {
        let (sin, cos) = self.pose.heading_rad.sine_cosine();
        Vector2::new(cos, sin)
    }

    fn front(&self) -> Point2<f64> {
        Point2::new(self.pose.x_um, self.pose.y_um) + self.heading() * (self.facts.length_um / 2.0)
    }
}

/// Limits on the goals of an assembly.
#[derive(Debug, Clone, Copy)]
pub struct GoalLimits {
    pub docking: Docking,
    /// The task's `heading_precision`: greatest angle of a goal from the heading at which its robot lies flat.
    pub flat_rad: f64,
}

/// Whether two bodies touch, within the docking tolerance.
pub fn touches(one: &Docked, other: &Docked, docking: &Docking) -> bool {
    one.body().gap_um(&other.body()).abs() <= docking.tolerance_um + SLACK_UM
}

/// Geometry of two robots that meet head on.
#[derive(Debug, Clone, Copy)]
pub struct HeadOn {
    /// Angle between the heading of the one and the reversed heading of the other, from 0 to 180 degrees.
    pub angle_rad: f64,
    /// The greater distance of a front's middle from the axis of the other robot.
    pub offset_um: f64,
    /// Whether their fronts meet.
    pub faces: bool,
}

impl HeadOn {
    /// Measures how two robots meet.
    pub fn of(one: &Docked, other: &Docked, docking: &Docking) -> HeadOn {
        let angle_rad = wrapped_rad(one.pose.heading_rad - other.pose.heading_rad - PI).abs();
        let off = |one: &Docked, other: &Docked| one.heading().perp(&(other.front() - one.front())).abs();
        HeadOn {
            angle_rad,
            offset_um: off(one, other).max(off(other, one)),
            faces: angle_rad < FRAC_PI_2
                && (lies_before(&one.body(), &other.body(), docking)
                    || lies_before(&other.body(), &one.body(), docking)),
        }
    }

    /// Whether they stay as they meet.
    pub fn holds(&self, limits: &GoalLimits) -> bool {
        self.faces
            && self.angle_rad <= limits.flat_rad + SLACK_RAD
            && self.offset_um <= limits.docking.self_aligning_um + SLACK_UM
    }
}

/// Whether a body lies in front of another one's front side, except for the overlap that docking permits.
fn lies_before(body: &RobotBody, other: &RobotBody, docking: &Docking) -> bool {
    let [(normal, at), ..] = other.sides();
    body.beyond_um(normal, at) >= -docking.tolerance_um - SLACK_UM
}

/// The edge that a robot meets.
struct MetEdge {
    /// Outward normal.
    normal: Vector2<f64>,
    /// A point of it.
    at: Point2<f64>,
    /// Angle between the heading of the robot and the inward normal.
    incidence_rad: f64,
}

impl MetEdge {
    /// The edge; at a corner, the one with the smaller angle of incidence. `None` if the robot lies in front of no
    /// edge.
    fn of(one: &Docked, met: &Docked, docking: &Docking) -> Option<MetEdge> {
        let body = one.body();
        let edge = |(normal, at)| MetEdge { normal, at, incidence_rad: one.heading().angle(&-normal) };
        let edges = met.body().sides().into_iter().map(edge);
        let met = edges.filter(|edge| body.beyond_um(edge.normal, edge.at) >= -docking.tolerance_um - SLACK_UM);
        met.min_by(|one, other| one.incidence_rad.total_cmp(&other.incidence_rad))
    }
}

/// The angle between the heading of a robot and the inward normal of the edge that it meets; at a corner the smaller one.
pub fn incidence_rad(one: &Docked, met: &Docked, docking: &Docking) -> f64 {
    MetEdge::of(one, met, docking).map_or(PI, |edge| edge.incidence_rad)
}

/// Whether the front of a robot lies along an edge of a docked one.
pub fn lies_flat(one: &Docked, met: &Docked, limits: &GoalLimits) -> bool {
    let docking = &limits.docking;
    touches(one, met, docking) && incidence_rad(one, met, docking) <= limits.flat_rad + SLACK_RAD
}

/// Pose of a robot laid flat on the edge that it meets: turned about the middle of its front and moved to the edge.
fn laid_flat(one: &Docked, met: &Docked, docking: &Docking, accepts: impl Fn(&Docked) -> bool) -> Option<Pose> {
    let MetEdge { normal, at, .. } = MetEdge::of(one, met, docking)?;
    let front = one.front() - normal * (one.front() - at).dot(&normal);
    let centre = front + normal * (one.facts.length_um / 2.0);
    let heading_rad = (-normal.y).arc_tangent_over(-normal.x);
    rounded(one, Pose { x_um: centre.x, y_um: centre.y, heading_rad }, accepts)
}

/// Why a goal of an assembly does not fit.
pub enum GoalMisfit<'a> {
    /// It overlaps another goal, by this depth.
    Overlaps { other: Docked<'a>, depth_um: f64 },
    /// It is this far from anything that it could dock with.
    Apart { nearest: Docked<'a>, gap_um: f64 },
    /// The first two do not meet head on.
    NotHeadOn { other: Docked<'a>, meeting: HeadOn },
    /// It touches its partner at an angle.
    NotFlat { met: Docked<'a>, angle_rad: f64 },
}

/// The partner of a docking.
#[derive(Debug, Clone, Copy)]
pub enum Partner<'a> {
    /// Nothing yet: it is the first of a new structure.
    Nothing,
    /// The first of a new structure, which it must meet head on.
    First(&'a Docked<'a>),
    /// Any robot that has docked.
    Structure,
}

/// Why a goal does not fit, given those docked before it; `None` if it does.
pub fn misfit<'a>(
    one: &Docked,
    before: &[Docked<'a>],
    partner: Partner<'a>,
    limits: &GoalLimits,
) -> Option<GoalMisfit<'a>> {
    let docking = &limits.docking;
    let gap_um = |other: &Docked| one.body().gap_um(&other.body());
    let nearest = *before.iter().min_by(|a, b| gap_um(a).total_cmp(&gap_um(b)))?;
    let depth_um = -gap_um(&nearest);
    if depth_um > docking.tolerance_um + SLACK_UM {
        return Some(GoalMisfit::Overlaps { other: nearest, depth_um });
    }
    let apart = |nearest: Docked<'a>| GoalMisfit::Apart { nearest, gap_um: gap_um(&nearest) };
    match partner {
        Partner::Nothing => None,
        Partner::First(first) if !touches(one, first, docking) => Some(apart(*first)),
        Partner::First(first) => {
            let meeting = HeadOn::of(one, first, docking);
            (!meeting.holds(limits)).then_some(GoalMisfit::NotHeadOn { other: *first, meeting })
        }
        Partner::Structure if !touches(one, &nearest, docking) => Some(apart(nearest)),
        Partner::Structure if before.iter().any(|met| lies_flat(one, met, limits)) => None,
        Partner::Structure => {
            let angle_rad = |met: &Docked| incidence_rad(one, met, docking);
            let touched = before.iter().filter(|met| touches(one, met, docking));
            let met = *touched.min_by(|a, b| angle_rad(a).total_cmp(&angle_rad(b)))?;
            Some(GoalMisfit::NotFlat { met, angle_rad: angle_rad(&met) })
        }
    }
}

/// The nearest pose of the same heading at which a body neither overlaps its partner nor is apart from it.
pub fn mended(one: &Docked, other: &Docked, accepts: impl Fn(&Docked) -> bool) -> Option<Pose> {
    let body = one.body();
    let way = body.way_out(&other.body()).unwrap_or_else(|| body.way_to(&other.body()));
    let moved = Pose { x_um: one.pose.x_um + way.x, y_um: one.pose.y_um + way.y, ..one.pose };
    rounded(one, moved, accepts)
}

/// A pose for a message: in whole micrometres, or in hundredths where only these are accepted.
fn rounded(one: &Docked, pose: Pose, accepts: impl Fn(&Docked) -> bool) -> Option<Pose> {
    let to = |per_um: f64| Pose {
        x_um: (pose.x_um * per_um).round() / per_um,
        y_um: (pose.y_um * per_um).round() / per_um,
        ..pose
    };
    [1.0, 100.0].map(to).into_iter().find(|pose| accepts(&Docked { pose: *pose, ..*one }))
}

/// Diagnostic for a goal that does not fit.
pub fn misfit_diagnostic(
    one: &Docked,
    before: &[Docked],
    partner: Partner,
    misfit: &GoalMisfit,
    limits: &GoalLimits,
) -> Diagnostic {
    let docking = &limits.docking;
    let place = |docked: &Docked| errors::GoalPlace { robot: docked.facts.name.clone(), span: docked.span };
    let fits = |moved: &Docked| self::misfit(moved, before, partner, limits).is_none();
    let head_on = || match partner {
        Partner::First(first) => facing(one, first, fits),
        Partner::Nothing | Partner::Structure => None,
    };
    match misfit {
        GoalMisfit::Overlaps { other, depth_um } => {
            let mended = mended(one, other, fits).or_else(head_on);
            errors::docked_overlap(&place(one), &place(other), *depth_um, docking.tolerance_um, mended)
        }
        GoalMisfit::Apart { nearest, gap_um } => {
            let mended = mended(one, nearest, fits).or_else(head_on);
            errors::docked_apart(&place(one), &place(nearest), *gap_um, docking.tolerance_um, mended)
        }
        GoalMisfit::NotHeadOn { other, meeting } => {
            let found = meeting.faces.then_some((meeting.angle_rad, meeting.offset_um));
            errors::not_head_on(&place(one), &place(other), found, docking.self_aligning_um, head_on())
        }
        GoalMisfit::NotFlat { met, angle_rad } => {
            errors::not_flat(&place(one), &place(met), *angle_rad, laid_flat(one, met, docking, fits))
        }
    }
}

/// The pose in which a robot meets another straight head on.
fn facing(one: &Docked, other: &Docked, accepts: impl Fn(&Docked) -> bool) -> Option<Pose> {
    let heading = other.heading();
    let centre = other.front() + heading * (one.facts.length_um / 2.0);
    let heading_rad = wrapped_rad(other.pose.heading_rad + PI);
    let pose = Pose { x_um: centre.x.round(), y_um: centre.y.round(), heading_rad };
    accepts(&Docked { pose, ..*one }).then_some(pose)
}
