//! STL files: format detection and triangles.
//!
//! Input: bytes. Output: the corners of triangles, or the canonical text of a mesh. Promise: a file is binary exactly
//! if its length matches its triangle count, whatever its header begins with; nothing is allocated for a count that
//! exceeds the file's length. Normals and attributes are ignored: they follow from the corners, and are often wrong.

use super::{MAX_BYTES, MAX_TRIANGLES, Mesh, MeshError};
use std::fmt::Write;
use std::io::{Cursor, Read, Seek};

/// Length of the header in the binary format.
const HEADER_BYTES: usize = 80;

/// Length of the header and the triangle count.
const HEAD_BYTES: usize = HEADER_BYTES + 4;

/// Length of one triangle in the binary format.
const TRIANGLE_BYTES: usize = 50;

/// The triangles of a file.
pub(super) fn corners(bytes: &[u8]) -> Result<Vec<[[f64; 3]; 3]>, MeshError> {
    if bytes.len() > MAX_BYTES {
        return Err(MeshError::TooLong { bytes: bytes.len() });
    }
    match binary_count(bytes) {
        Some(count) if count > MAX_TRIANGLES => Err(MeshError::TooManyTriangles(count)),
        Some(_) => {
            // The reader would take a header that begins with `solid` for text.
            let mut plain = bytes.to_vec();
            plain[..HEADER_BYTES].fill(0);
            read(&mut Cursor::new(plain))
        }
        None => read(&mut Cursor::new(plain_text(bytes)?)),
    }
}

/// Number of triangles in a binary file; `None` if the file is not binary.
fn binary_count(bytes: &[u8]) -> Option<usize> {
    let count = bytes.get(HEADER_BYTES..HEAD_BYTES)?.try_into().ok().map(u32::from_le_bytes)? as usize;
    let length = count.checked_mul(TRIANGLE_BYTES)?.checked_add(HEAD_BYTES)?;
    (length == bytes.len()).then_some(count)
}

/// The text in the form that the reader expects: one solid, without its name, in lower case.
fn plain_text(bytes: &[u8]) -> Result<String, MeshError> {
    let wrong = |what: &str| MeshError::Format(what.to_owned());
    let is_text = bytes.trim_ascii_start().get(..5).is_some_and(|word| word.eq_ignore_ascii_case(b"solid"));
    if !is_text {
        return Err(wrong("it neither begins with `solid` nor has the length that a binary file would have"));
    }
    let text = std::str::from_utf8(bytes).map_err(|_| wrong("it begins with `solid` but is not text"))?;
    let text = text.trim().to_ascii_lowercase();
    let (_, facets) = text.split_once('\n').ok_or_else(|| wrong("it has a single line"))?;
    let ends = facets.lines().filter(|line| line.trim_start().starts_with("endsolid")).count();
    if ends > 1 {
        return Err(wrong("it contains several solids"));
    }
    if !facets.lines().next_back().is_some_and(|line| line.trim_start().starts_with("endsolid")) {
        return Err(wrong("it does not end with `endsolid`"));
    }
    Ok(format!("solid \n{facets}\n"))
}

fn read<R: Read + Seek>(source: &mut R) -> Result<Vec<[[f64; 3]; 3]>, MeshError> {
    let wrong = |error: std::io::Error| MeshError::Format(error.to_string());
    let mut corners = Vec::new();
    for triangle in stl_io::create_stl_reader(source).map_err(wrong)? {
        if corners.len() == MAX_TRIANGLES {
            return Err(MeshError::TooManyTriangles(MAX_TRIANGLES + 1));
        }
        corners.push(triangle.map_err(wrong)?.vertices.map(|vertex| vertex.0.map(f64::from)));
    }
    Ok(corners)
}

/// Text of a mesh, with the shortest numbers that are read back as the same bits.
pub(super) fn text(mesh: &Mesh) -> String {
    let mut text = String::from("solid mesh\n");
    for corners in mesh.corners() {
        text.push_str("facet normal 0 0 0\nouter loop\n");
        for [x, y, z] in corners.map(|corner| corner.map(|number| number as f32)) {
            // Writing to a string cannot fail.
            let _ = writeln!(text, "vertex {x} {y} {z}");
        }
        text.push_str("endloop\nendfacet\n");
    }
    text.push_str("endsolid mesh\n");
    text
}
