//! The mechanics of one section: contacts, grasps in equilibrium, placements and removals of fingers, all tabulated for the search.
//!
//! Input: a section, the hand's data, and the load. Output: [`tables`], and the same answers one by one from [`GripModel`].
//! Guaranteed: the answers are exact up to [`TOLERANCE`]; an exact balance counts as holding. Bodies are rigid, friction is Coulomb's,
//! and the object stays in place while fingers roll, come and leave.
//!
//! The model in the plane: each finger's force lies in a triangle, a friction cone whose apex is shifted outwards by
//! adhesion and which is cut off at the greatest normal force (equation 1 of the paper). A grasp holds if forces in
//! these triangles add up to the required wrench. Two fingers leave one unknown, the force along the chord between
//! them; eliminating it (Fourier and Motzkin) gives at most nine half-spaces of wrenches that they can bear. A third
//! finger is tested by clipping its triangle with these. Out-of-plane loads are borne by friction and by torsion of the
//! contacts: see `space`.

mod contact;
mod grip;
mod instant;
mod lazy;
mod load;
mod model;
mod pair;
mod rolling_checker;
mod rows;
mod simplex;
mod space;
mod tabulate;

pub use contact::{Contact, Contacts};
pub use lazy::LazyGraspEvaluator;
pub use load::{Load, Wrench};
pub use model::GripModel;
pub use rolling_checker::{RollingChecker, forbid};
pub use tabulate::{NoTables, PARTS_OF_ROLLING, PARTS_OF_STEP, TableRequest, tables};

/// Tolerance of an equilibrium, relative to the forces involved: an exact balance holds, whatever the rounding.
pub const TOLERANCE: f64 = 1e-9;

#[cfg(test)]
mod tests;
