//! The mechanics of one section: where tips touch, which grasps are in equilibrium, which fingers may come and go, and all of it
//! tabulated for the search.
//!
//! Input: a section, what the hand is, and the load. Output: [`tables`], and the same answers one by one from [`GripModel`].
//! Promise: the answers are exact up to [`TOLERANCE`]; what is exactly balanced counts as holding. Bodies are rigid, friction is
//! Coulomb's, and the object stays where it is while fingers roll, come and go.
//!
//! The model in the plane: each finger's force lies in a triangle of the plane, a friction cone whose apex adhesion moves outwards, cut off at
//! the greatest normal force (equation 1 of the paper). A grasp holds if forces of these triangles add up to the wrench that is
//! wanted. Two fingers leave one unknown, the force along the chord between them; eliminating it (Fourier and Motzkin) gives at
//! most nine half-spaces of wrenches that they can bear. A third finger is tried by cutting its triangle with these.
//! What acts across the plane, or out of it, is borne by friction and by torsion of the contacts: see `space`.

mod closer;
mod contact;
mod grip;
mod instant;
mod lazy;
mod load;
mod pair;
mod rows;
mod simplex;
mod space;
mod tabulate;

pub use closer::{Closer, forbid};
pub use contact::{Contact, Contacts};
pub use grip::{GripModel, Wrench};
pub use lazy::Lazy;
pub use load::Load;
pub use tabulate::{NoTables, PARTS_OF_ROLLING, PARTS_OF_STEP, TableRequest, tables};

/// By how much a balance may be missed, relative to the forces in play: what is exactly balanced holds, whatever the rounding.
pub const TOLERANCE: f64 = 1e-9;

#[cfg(test)]
mod tests;
