//! Closed triangle meshes: reading STL files, volume and centroid, sections, distances.
//!
//! Input: the bytes of an STL file, text or binary, in micrometres. Output: a [`Mesh`] whose surface is closed and
//! faces outwards. Promise: a surface that is not closed, not finite or too large is refused; the same bytes give the
//! same mesh, and [`Mesh::to_text`] is read back bit by bit. Self-intersection is not checked.
//!
//! Volume and centroid come from the divergence theorem. A section treats a vertex on the plane as being in front of
//! it, as if the plane were slightly behind (symbolic perturbation); so each triangle is cut on two edges or on none.

mod message;
mod section;
mod stl;
mod surface;
#[cfg(test)]
mod tests;

/// Greatest number of triangles of a mesh.
pub const MAX_TRIANGLES: usize = 200_000;

/// Greatest length of a file, in bytes.
pub const MAX_BYTES: usize = 1 << 26;

/// Greatest coordinate, in micrometres.
pub const MAX_UM: f64 = 1e6;

/// Reason why data are not a mesh, or a mesh has no section.
#[derive(Debug, Clone, PartialEq)]
pub enum MeshError {
    /// The file is longer than [`MAX_BYTES`].
    TooLong { bytes: usize },
    /// There are more than [`MAX_TRIANGLES`].
    TooManyTriangles(usize),
    /// Not an STL file; the reader's message.
    Format(String),
    /// There is no triangle.
    Empty,
    /// A coordinate of this triangle, counted from 0, is not finite or too large.
    Number { triangle: usize },
    /// This triangle, counted from 0, has no area.
    ZeroArea { triangle: usize },
    /// Holes: edges that belong to only one triangle, and the midpoint of one of them.
    Open { edges: usize, at_um: [f64; 3] },
    /// Edges of more than two triangles, or of two with opposite orientation, and the midpoint of one of them.
    Tangled { edges: usize, at_um: [f64; 3] },
    /// It encloses no volume.
    NoVolume,
    /// The plane does not meet it.
    NoSection,
    /// The plane cuts it in several closed curves.
    SeveralLoops(usize),
}

/// A closed surface that faces outwards, in micrometres.
#[derive(Debug, Clone, PartialEq)]
pub struct Mesh {
    vertices_um: Vec<[f64; 3]>,
    triangles: Vec<[u32; 3]>,
    /// The bounding box of each [`BLOCK`] triangles, in order.
    blocks_um: Vec<[[f64; 3]; 2]>,
}

/// Triangles per bounding box; neighbours in a file are often neighbours in space.
const BLOCK: usize = 64;

impl Mesh {
    /// Reads an STL file, text or binary. A mesh that faces inwards is turned inside out.
    ///
    /// # Errors
    /// See [`MeshError`].
    pub fn read(bytes: &[u8]) -> Result<Mesh, MeshError> {
        let corners_um = stl::corners(bytes)?;
        Mesh::of(&corners_um)
    }

    /// Builds a mesh from the corners of its triangles; corners that coincide are joined.
    ///
    /// # Errors
    /// All of [`MeshError`] except those of files and sections.
    pub fn of(corners_um: &[[[f64; 3]; 3]]) -> Result<Mesh, MeshError> {
        surface::joined(corners_um)
    }

    /// The mesh about another origin and in other units: each coordinate minus that of the origin, times the scale.
    ///
    /// # Errors
    /// If the result is not a mesh, because numbers become too large or coincide.
    pub fn placed(&self, origin_um: [f64; 3], scale: f64) -> Result<Mesh, MeshError> {
        let place = |point: [f64; 3]| [0, 1, 2].map(|axis| (point[axis] - origin_um[axis]) * scale);
        let corners_um: Vec<[[f64; 3]; 3]> = self.corners().map(|corners| corners.map(place)).collect();
        Mesh::of(&corners_um)
    }

    /// The mesh as the text of an STL file, without normals. A mesh that came from a file is read back from this text
    /// bit by bit.
    pub fn to_text(&self) -> String {
        stl::text(self)
    }

    /// The corners of each triangle, counter-clockwise seen from outside.
    pub fn corners(&self) -> impl Iterator<Item = [[f64; 3]; 3]> + '_ {
        self.triangles.iter().map(|triangle| self.places(*triangle))
    }

    fn places(&self, triangle: [u32; 3]) -> [[f64; 3]; 3] {
        triangle.map(|vertex| self.vertices_um[vertex as usize])
    }

    /// Bounding box: the least and the greatest coordinates.
    pub fn bounds_um(&self) -> [[f64; 3]; 2] {
        surface::bounds(self.vertices_um.iter().copied())
    }

    /// Enclosed volume, in cubic micrometres.
    pub fn volume_um3(&self) -> f64 {
        surface::volume_and_centre(self).0
    }

    /// The centroid of the enclosed volume.
    pub fn centre_um(&self) -> [f64; 3] {
        surface::volume_and_centre(self).1
    }

    /// The section with the plane through the origin that two perpendicular unit vectors span: a closed polyline in
    /// coordinates along them, counter-clockwise; the first point is not repeated.
    ///
    /// # Errors
    /// [`MeshError::NoSection`] and [`MeshError::SeveralLoops`].
    pub fn section(&self, axes: [[f64; 3]; 2]) -> Result<Vec<[f64; 2]>, MeshError> {
        let mut loops = section::loops(self, axes);
        match loops.len() {
            0 => Err(MeshError::NoSection),
            1 => Ok(loops.remove(0)),
            several => Err(MeshError::SeveralLoops(several)),
        }
    }

    /// The distance of a point from the surface, never negative: that from the nearest triangle in the blocks that
    /// are near enough.
    pub fn distance_um(&self, point_um: [f64; 3]) -> f64 {
        let away = |bounds: &[[f64; 3]; 2]| surface::box_square(*bounds, point_um);
        let mut blocks: Vec<(f64, &[[u32; 3]])> =
            self.blocks_um.iter().map(away).zip(self.triangles.chunks(BLOCK)).collect();
        blocks.sort_unstable_by(|a, b| a.0.total_cmp(&b.0));
        let mut best = f64::INFINITY;
        for (least, triangles) in blocks {
            if least >= best {
                break;
            }
            let square = |triangle: &[u32; 3]| surface::square(self.places(*triangle), point_um);
            best = triangles.iter().map(square).fold(best, f64::min);
        }
        best.sqrt()
    }
}

fn minus(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}
