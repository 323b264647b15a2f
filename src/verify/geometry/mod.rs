//! The verifier's own geometry: a second implementation of everything in [`crate::geometry`] that decides whether a
//! schedule is correct.
//!
//! Planners measure with `crate::geometry`, and so does the checker, which derives the claims. If the verifier did so
//! too, a bug there that makes a distance 15 um too great would let it accept a plan that hits an obstacle. So it
//! takes only the types of the claims from there ([`Shape`](crate::geometry::Shape), [`Pose`](crate::geometry::Pose),
//! [`Outline`](crate::geometry::outline::Outline), all plain numbers) and measures by other methods:
//!
//! | question | planners and checker | verifier |
//! |---|---|---|
//! | distance of bodies | the least distance of corners and edges | [`convex`]: the widest gap between their projections |
//! | place of an obstacle | grown, as a core with a radius | [`solid`]: as it is, the distance compared with the clearance |
//! | contact of a tip on an outline | boxes, then Newton's method | [`contour`]: bounds by the path, then regula falsi |
//! | rolled distance of a tip | tables of polynomials of the path | [`contour`]: integrated on demand |
//!
//! The two agree to about 1e-9 um where coordinates are below
//! [`MAX_EXTENT_UM`](crate::geometry::shape::MAX_EXTENT_UM); planners keep a margin for that. `tests` compare the two
//! and inject faults into each.

pub(super) mod contour;
pub(super) mod convex;
pub(super) mod solid;

#[cfg(test)]
mod tests;
