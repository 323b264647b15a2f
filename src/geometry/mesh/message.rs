//! Faults of a mesh, worded to follow its name: "`bead.stl` is not closed …".

use super::{MAX_BYTES, MAX_TRIANGLES, MAX_UM, MeshError};
use std::fmt;

impl fmt::Display for MeshError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let place = |[x, y, z]: &[f64; 3]| format!("({x:.6}, {y:.6}, {z:.6})");
        match self {
            MeshError::TooLong { bytes } => write!(f, "has {bytes} bytes; at most {MAX_BYTES} are read"),
            MeshError::TooManyTriangles(count) => {
                write!(f, "has {count} triangles; at most {MAX_TRIANGLES} are accepted")
            }
            MeshError::Format(why) => write!(f, "is not an STL file: {why}"),
            MeshError::Empty => f.write_str("has no triangles"),
            MeshError::Number { triangle } => {
                write!(f, "has a coordinate in triangle {} that is not a number of at most {MAX_UM} um", triangle + 1)
            }
            MeshError::ZeroArea { triangle } => write!(f, "has a triangle of zero area, number {}", triangle + 1),
            MeshError::Open { edges, at_um } => {
                write!(
                    f,
                    "is not closed: {edges} edges have a triangle on one side only, one of them at {}",
                    place(at_um)
                )
            }
            MeshError::Tangled { edges, at_um } => {
                write!(
                    f,
                    "is not a simple surface: {edges} edges do not have two triangles of consistent orientation, one of them at {}",
                    place(at_um)
                )
            }
            MeshError::NoVolume => f.write_str("encloses no volume"),
            MeshError::NoSection => f.write_str("does not meet it"),
            MeshError::SeveralLoops(count) => write!(f, "meets it in {count} closed lines"),
        }
    }
}
