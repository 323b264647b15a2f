//! Mesh files are read as text, even if they are binary on the disk.

use super::{Disk, Embedded};
use crate::check::imports::{FileFault, Library};
use crate::geometry::mesh::Mesh;

const CORNERS: [[f32; 3]; 4] = [[0.0, 0.0, 0.0], [1.5, 0.0, 0.0], [0.0, 0.1, 0.0], [0.0, 0.0, 0.3]];

/// A tetrahedron as a binary mesh.
fn binary() -> Vec<u8> {
    let mut bytes = vec![0u8; 80];
    bytes.extend(4u32.to_le_bytes());
    for corners in [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]] {
        bytes.extend([0u8; 12]);
        corners.iter().flat_map(|corner| CORNERS[*corner]).for_each(|number| bytes.extend(number.to_le_bytes()));
        bytes.extend([0u8; 2]);
    }
    bytes
}

#[test]
fn a_binary_file_is_read_as_text_that_a_log_gives_back() {
    let folder = tempfile::tempdir().expect("a folder can be made");
    let program = folder.path().join("main.twz");
    std::fs::write(folder.path().join("bead.stl"), binary()).expect("it can be written");
    let (name, text) = Disk::around(&program).read_mesh("main.twz", "bead.stl").expect("it can be read");
    assert_eq!(name, "bead.stl");
    assert!(text.starts_with("solid"));
    let mesh = Mesh::read(&binary()).expect("it is a mesh");
    assert_eq!(Mesh::read(text.as_bytes()).expect("so is its text"), mesh);
    let files = [(name.clone(), text.clone())];
    assert_eq!(Embedded(&files).read_mesh("main.twz", "bead.stl"), Ok((name, text)));
}

#[test]
fn what_is_no_mesh_says_so() {
    let folder = tempfile::tempdir().expect("a folder can be made");
    let program = folder.path().join("main.twz");
    let disk = Disk::around(&program);
    std::fs::write(folder.path().join("bead.stl"), [0xff; 200]).expect("it can be written");
    let why = disk.read_mesh("main.twz", "bead.stl").expect_err("it is none");
    assert!(matches!(&why, FileFault::NoSurface(why) if why.contains("STL")), "{why:?}");
    assert!(disk.read_mesh("main.twz", "none.stl").is_err());
}
