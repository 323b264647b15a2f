//! Geometry of the judge's own: a second implementation of all of [`crate::geometry`] that decides whether a schedule is right.
//!
//! Planners measure with `crate::geometry`, and so does the checker, which makes the claims. If the verifier did so too, a distance that is
//! 15 um too great there would let a plan through that runs into an obstacle. So it takes from there only what claims are written in
//! ([`Shape`](crate::geometry::Shape), [`Pose`](crate::geometry::Pose), [`Outline`](crate::geometry::outline::Outline): numbers), and measures by other means:
//!
//! | question | planners and checker | verifier |
//! |---|---|---|
//! | how far apart bodies are | the least distance of corners and edges | [`convex`]: the widest gap between their shadows |
//! | where an obstacle is | grown, as a core with a radius | [`solid`]: as it is, and the distance held against the clearance |
//! | where on an outline a tip touches | boxes, then Newton's method | [`contour`]: bounds by the way, then regula falsi |
//! | how far a tip rolls | tables of polynomials of the way | [`contour`]: the way is integrated when it is asked for |
//!
//! The two agree to about 1e-9 um where coordinates are below [`MAX_EXTENT_UM`](crate::geometry::shape::MAX_EXTENT_UM); planners keep a
//! margin for that. `tests` hold them against each other, and put faults into either one.

pub(super) mod contour;
pub(super) mod convex;
pub(super) mod solid;

#[cfg(test)]
mod tests;
