//! Meshes built here, intact and damaged.

use super::*;
use crate::geometry::outline::{Curve, Outline};
use crate::random::SplitMix64;
use std::collections::BTreeMap;
use std::f64::consts::{PI, TAU};

type Corners = Vec<[[f64; 3]; 3]>;

/// The section planes xy and xz.
const XY: [[f64; 3]; 2] = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
const XZ: [[f64; 3]; 2] = [[1.0, 0.0, 0.0], [0.0, 0.0, -1.0]];

/// An icosahedron whose faces are split into four several times; all vertices are at distance 1.
fn icosphere(cuts: usize) -> Corners {
    let g = f64::midpoint(1.0, 5.0_f64.sqrt());
    let mut vertices: Vec<[f64; 3]> = Vec::new();
    for (a, b) in [(1.0, g), (-1.0, g), (1.0, -g), (-1.0, -g)] {
        vertices.extend([[0.0, a, b], [a, b, 0.0], [b, 0.0, a]]);
    }
    // The faces are the triples of neighbouring vertices, which are 2 apart.
    let near = |a: [f64; 3], b: [f64; 3]| (dot(minus(a, b), minus(a, b)) - 4.0).abs() < 1e-9;
    let mut faces: Corners = Vec::new();
    for (i, a) in vertices.iter().enumerate() {
        for (j, b) in vertices.iter().enumerate().skip(i + 1) {
            for c in vertices.iter().skip(j + 1).filter(|c| near(*a, *b) && near(*b, **c) && near(*a, **c)) {
                let is_outward = dot(cross(minus(*b, *a), minus(*c, *a)), *a) > 0.0;
                faces.push(if is_outward { [*a, *b, *c] } else { [*a, *c, *b] });
            }
        }
    }
    assert_eq!(faces.len(), 20);
    let unit = |a: [f64; 3]| a.map(|number| number / dot(a, a).sqrt());
    let half = |a: [f64; 3], b: [f64; 3]| unit([0, 1, 2].map(|axis| a[axis] + b[axis]));
    faces.iter_mut().for_each(|face| *face = face.map(unit));
    for _ in 0..cuts {
        let split = |[a, b, c]: [[f64; 3]; 3]| {
            let [ab, bc, ca] = [half(a, b), half(b, c), half(c, a)];
            [[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]
        };
        faces = faces.into_iter().flat_map(split).collect();
    }
    faces
}

fn scaled(corners: &Corners, by: [f64; 3]) -> Corners {
    corners.iter().map(|face| face.map(|corner| [0, 1, 2].map(|axis| corner[axis] * by[axis]))).collect()
}

fn moved(corners: &Corners, by: [f64; 3]) -> Corners {
    corners.iter().map(|face| face.map(|corner| [0, 1, 2].map(|axis| corner[axis] + by[axis]))).collect()
}

/// Two triangles for each face of the box between two corners.
fn cuboid(low: [f64; 3], high: [f64; 3]) -> Corners {
    let mut faces = Vec::new();
    for axis in 0..3 {
        let (u, v) = ((axis + 1) % 3, (axis + 2) % 3);
        for (side, is_high) in [(low, false), (high, true)] {
            let corner = |at_u: [f64; 3], at_v: [f64; 3]| {
                let mut corner = side;
                (corner[u], corner[v]) = (at_u[u], at_v[v]);
                corner
            };
            let mut square = [corner(low, low), corner(high, low), corner(high, high), corner(low, high)];
            if !is_high {
                square.reverse();
            }
            faces.extend([[square[0], square[1], square[2]], [square[0], square[2], square[3]]]);
        }
    }
    faces
}

fn binary(corners: &Corners, header: &[u8]) -> Vec<u8> {
    let mut bytes = header.to_vec();
    bytes.resize(80, b' ');
    bytes.extend((corners.len() as u32).to_le_bytes());
    for face in corners {
        bytes.extend([0; 12]);
        face.iter().flatten().for_each(|number| bytes.extend((*number as f32).to_le_bytes()));
        bytes.extend([0; 2]);
    }
    bytes
}

fn area(line: &[[f64; 2]]) -> f64 {
    let next = |at: usize| line[(at + 1) % line.len()];
    (0..line.len()).map(|at| line[at][0] * next(at)[1] - line[at][1] * next(at)[0]).sum::<f64>() / 2.0
}

#[test]
fn a_ball_has_its_volume_centre_and_sections() {
    let ball = Mesh::of(&moved(&scaled(&icosphere(5), [14.0; 3]), [1.0, 2.0, 3.0])).unwrap();
    assert_eq!(ball.triangles.len(), 20 * 4_usize.pow(5));
    assert!((ball.volume_um3() / (4.0 / 3.0 * PI * 14.0_f64.powi(3)) - 1.0).abs() < 2e-3);
    assert!(dot(minus(ball.centre_um(), [1.0, 2.0, 3.0]), [1.0; 3]).abs() < 1e-9);
    for (axes, across, centre) in [(XY, 3.0, [1.0, 2.0]), (XZ, 2.0, [1.0, -3.0])] {
        let line = ball.section(axes).unwrap();
        let radius = 14.0_f64.powi(2) - f64::powi(across, 2);
        let off = |point: &[f64; 2]| (point[0] - centre[0]).hypot(point[1] - centre[1]) / radius.sqrt() - 1.0;
        assert!(line.iter().all(|point| off(point) < 1e-9 && off(point) > -2e-3));
        assert!((area(&line) / (PI * radius) - 1.0).abs() < 3e-3, "{}", area(&line));
    }
    assert_eq!(ball.placed([1.0, 2.0, 20.0], 1.0).unwrap().section(XY), Err(MeshError::NoSection));
}

/// Both sections of an icosphere around the origin pass through vertices and along edges.
#[test]
fn vertices_on_the_plane_are_no_trouble() {
    for cuts in 0..5 {
        let ball = Mesh::of(&scaled(&icosphere(cuts), [16.0, 12.0, 12.0])).unwrap();
        let on_plane = ball.vertices_um.iter().filter(|vertex| vertex[2] == 0.0).count();
        assert!(on_plane > 0);
        for axes in [XY, XZ] {
            let line = ball.section(axes).unwrap();
            assert!(area(&line) > 0.7 * PI * 16.0 * 12.0, "{cuts}: {}", area(&line));
            let turns = (0..line.len()).map(|at| {
                let [a, b, c] = [0, 1, 2].map(|step| line[(at + step) % line.len()]);
                let (one, other) = ([b[0] - a[0], b[1] - a[1]], [c[0] - b[0], c[1] - b[1]]);
                (one[0] * other[1] - one[1] * other[0]).atan2(one[0] * other[0] + one[1] * other[1])
            });
            // Convex, and exactly one turn.
            let turns: Vec<f64> = turns.collect();
            assert!(turns.iter().all(|turn| *turn > -1e-9), "{turns:?}");
            assert!((turns.iter().sum::<f64>() - TAU).abs() < 1e-9);
        }
    }
}

#[test]
fn vertices_that_rounding_moves_off_the_plane_are_on_it() {
    let corners = scaled(&icosphere(3), [16.0, 12.0, 12.0]);
    let line = Mesh::of(&corners).unwrap().section(XY).unwrap();
    for sign in [1.0, -1.0] {
        let off = |[x, y, z]: [f64; 3]| [x, y, if z == 0.0 { sign * 7e-13 * (x + 0.3 * y).signum() } else { z }];
        let moved = Mesh::of(&corners.iter().map(|corners| corners.map(off)).collect::<Corners>()).unwrap();
        assert_eq!(moved.section(XY).unwrap(), line);
    }
}

#[test]
fn a_box_is_exact() {
    let mesh = Mesh::of(&cuboid([-3.0, -2.0, -1.0], [5.0, 4.0, 3.0])).unwrap();
    assert!((mesh.volume_um3() - 192.0).abs() < 1e-12);
    assert!((0..3).all(|axis| (mesh.centre_um()[axis] - 1.0).abs() < 1e-12));
    assert_eq!(mesh.bounds_um(), [[-3.0, -2.0, -1.0], [5.0, 4.0, 3.0]]);
    assert!((area(&mesh.section(XY).unwrap()) - 48.0).abs() < 1e-12);
    assert!((area(&mesh.section(XZ).unwrap()) - 32.0).abs() < 1e-12);
    for (point, distance) in [
        ([0.0, 0.0, 0.0], 1.0),
        ([7.0, 0.0, 0.0], 2.0),
        ([8.0, 8.0, 0.0], 5.0),
        ([6.0, 6.0, 5.0], 3.0),
        ([5.0, 4.0, 3.0], 0.0),
        ([1.0, 1.0, 3.25], 0.25),
    ] {
        assert!((mesh.distance_um(point) - distance).abs() < 1e-12, "{point:?} {}", mesh.distance_um(point));
    }
    // A mesh that rests on the plane is not cut; one that hangs from it is.
    assert_eq!(mesh.placed([0.0, 0.0, -1.0], 1.0).unwrap().section(XY), Err(MeshError::NoSection));
    assert!(mesh.placed([0.0, 0.0, 3.0], 1.0).unwrap().section(XY).is_ok());
    let thousand = mesh.placed([1.0; 3], 1e3).unwrap();
    assert!((thousand.volume_um3() / 192e9 - 1.0).abs() < 1e-12);
    assert_eq!(mesh.placed([0.0; 3], 1e9), Err(MeshError::Number { triangle: 0 }));
}

/// The smallest distance to a fine grid of points on each triangle is slightly more than the reported one, and never
/// less.
#[test]
fn distances_are_those_of_brute_force() {
    let mesh = Mesh::of(&scaled(&icosphere(3), [9.0, 7.0, 5.0])).unwrap();
    for step in 0..40 {
        let angle = f64::from(step) * 0.7;
        let point = [8.0 * angle.cos(), 9.0 * (1.3 * angle).sin(), 6.0 * (0.37 * angle).sin()];
        let mut brute = f64::INFINITY;
        for [a, b, c] in mesh.corners() {
            for i in 0..=12 {
                for j in 0..=12 - i {
                    let (s, t) = (f64::from(i) / 12.0, f64::from(j) / 12.0);
                    let place = [0, 1, 2].map(|axis| a[axis] + s * (b[axis] - a[axis]) + t * (c[axis] - a[axis]));
                    brute = brute.min(dot(minus(place, point), minus(place, point)).sqrt());
                }
            }
        }
        let reported = mesh.distance_um(point);
        assert!(reported <= brute + 1e-12 && reported > brute - 0.1, "{point:?}: {reported} {brute}");
        let each = mesh.corners().map(|corners| surface::square(corners, point)).fold(f64::INFINITY, f64::min);
        assert_eq!(reported, each.sqrt());
    }
}

#[test]
fn a_hole_is_told() {
    let mut corners = icosphere(2);
    let [a, b, c] = corners.remove(77);
    let Err(MeshError::Open { edges, at_um }) = Mesh::of(&corners) else { panic!() };
    assert_eq!(edges, 3);
    let middles = [(a, b), (b, c), (c, a)].map(|(a, b)| [0, 1, 2].map(|axis| f64::midpoint(a[axis], b[axis])));
    assert!(middles.contains(&at_um));
    // A triangle with the wrong orientation, and a duplicate.
    let mut turned = icosphere(2);
    turned[5].swap(0, 1);
    assert!(matches!(Mesh::of(&turned), Err(MeshError::Tangled { edges: 3, .. })));
    let mut twice = icosphere(2);
    twice.push(twice[8]);
    assert!(matches!(Mesh::of(&twice), Err(MeshError::Tangled { edges: 3, .. })));
}

#[test]
fn what_is_no_surface_is_refused() {
    assert_eq!(Mesh::of(&[]), Err(MeshError::Empty));
    for odd in [f64::NAN, f64::INFINITY, -1.1 * MAX_UM] {
        let mut corners = icosphere(1);
        corners[3][1][2] = odd;
        assert_eq!(Mesh::of(&corners), Err(MeshError::Number { triangle: 3 }));
        let reported = Mesh::read(&binary(&corners, b"made here"));
        assert_eq!(reported, Err(MeshError::Number { triangle: 3 }));
    }
    let mut corners = icosphere(1);
    corners[9][1] = corners[9][0];
    assert_eq!(Mesh::of(&corners), Err(MeshError::ZeroArea { triangle: 9 }));
    let flat = scaled(&icosphere(1), [1.0, 1.0, 0.0]);
    assert!(matches!(
        Mesh::of(&flat),
        Err(MeshError::ZeroArea { .. } | MeshError::Tangled { .. } | MeshError::NoVolume)
    ));
    // Two triangles back to back: closed, but without volume.
    let [a, b, c] = corners[0];
    assert_eq!(Mesh::of(&[[a, b, c], [a, c, b]]), Err(MeshError::NoVolume));
    let many = vec![corners[0]; MAX_TRIANGLES + 1];
    assert_eq!(Mesh::of(&many), Err(MeshError::TooManyTriangles(MAX_TRIANGLES + 1)));
    assert_eq!(Mesh::read(&binary(&many, b"")), Err(MeshError::TooManyTriangles(MAX_TRIANGLES + 1)));
    assert_eq!(Mesh::read(&vec![0; MAX_BYTES + 1]), Err(MeshError::TooLong { bytes: MAX_BYTES + 1 }));
    assert_eq!(Mesh::read(&binary(&Vec::new(), b"")), Err(MeshError::Empty));
}

/// From a mesh to an outline: that of the paper's ellipsoid, with its 74 contacts.
#[test]
fn a_section_becomes_a_smooth_outline() {
    let axes_um = [16.0, 11.845, 11.845];
    let mesh = Mesh::read(&binary(&scaled(&icosphere(4), axes_um), b"")).unwrap();
    let exact = Curve::of(&Outline::Ellipse { semi_um: [16.0, 11.845] }).unwrap();
    for axes in [XY, XZ] {
        let line = mesh.section(axes).unwrap();
        let curve = Curve::of(&Outline::from_polygon(&line).unwrap()).unwrap();
        let contacts = curve.rolled_rad(curve.perimeter_um(), 4.5) / (TAU / 18.0);
        assert!((contacts - 74.0).abs() < 0.2, "{contacts}");
        let places = (0..200).map(|step| curve.point_at(curve.perimeter_um() * f64::from(step) / 200.0).point_um);
        let off = places.map(|place| exact.nearest(place).distance_um.abs()).fold(0.0, f64::max);
        assert!(off < 0.05, "{off}");
        assert!(curve.least_curvature_per_um() > 0.03, "{}", curve.least_curvature_per_um());
    }
}

#[test]
fn one_that_faces_inwards_is_turned_round() {
    let corners = icosphere(2);
    let inwards: Corners = corners.iter().map(|[a, b, c]| [*a, *c, *b]).collect();
    let (one, other) = (Mesh::of(&corners).unwrap(), Mesh::of(&inwards).unwrap());
    assert!(other.volume_um3() > 0.0 && (one.volume_um3() - other.volume_um3()).abs() < 1e-12);
}

#[test]
fn several_loops_are_told() {
    let mut two = scaled(&icosphere(2), [5.0; 3]);
    two.extend(moved(&scaled(&icosphere(2), [5.0; 3]), [20.0, 0.0, 0.0]));
    let two = Mesh::of(&two).unwrap();
    assert_eq!(two.section(XY), Err(MeshError::SeveralLoops(2)));
    // A box that stands on the plane, beside a ball that is cut, adds nothing to the section.
    let mut beside = scaled(&icosphere(2), [5.0; 3]);
    beside.extend(cuboid([10.0, 0.0, 0.0], [12.0, 2.0, 2.0]));
    assert!(Mesh::of(&beside).unwrap().section(XY).is_ok());
    // Neither does the tip of an icosahedron that hangs below the plane.
    let mut below = scaled(&icosphere(2), [5.0; 3]);
    let tip = Mesh::of(&icosphere(0)).unwrap().bounds_um()[1][2];
    below.extend(moved(&icosphere(0), [10.0, 0.0, -tip]));
    let line = Mesh::of(&below).unwrap().section(XY).unwrap();
    assert!(line.iter().all(|point| point[0] < 6.0));
}

#[test]
fn binary_and_text_are_the_same_bit_by_bit() {
    let corners = scaled(&icosphere(3), [16.0, 11.845, 1e-3]);
    for header in [&b"solid that is binary all the same"[..], b"", b"\xff\xfe"] {
        let mesh = Mesh::read(&binary(&corners, header)).unwrap();
        let text = mesh.to_text();
        let again = Mesh::read(text.as_bytes()).unwrap();
        assert_eq!(again, mesh);
        assert_eq!(again.to_text(), text);
        let bits = |mesh: &Mesh| mesh.corners().flatten().flatten().map(f64::to_bits).collect::<Vec<_>>();
        assert_eq!(bits(&again), bits(&mesh));
        let single = |number: f64| f64::from(number as f32) + 0.0;
        assert!(mesh.corners().zip(&corners).all(|(read, made)| read == made.map(|corner| corner.map(single))));
    }
}

#[test]
fn text_is_read_as_others_write_it() {
    let mesh = Mesh::read(&binary(&icosphere(0), b"")).unwrap();
    let text = mesh.to_text();
    let same = |text: &str| assert_eq!(Mesh::read(text.as_bytes()).as_ref(), Ok(&mesh), "{text:.40}");
    same(&text.replace('\n', "\r\n"));
    same(&text.replace("solid mesh", "solid"));
    same(&text.to_uppercase());
    same(&format!("\n  {}\n\n", text.replace('\n', "\n  ").trim()));
    same(&text.replace("facet normal 0 0 0", "facet normal 1e-1 0.2E3 -3.0"));
    let wrong = |text: &str| assert!(matches!(Mesh::read(text.as_bytes()), Err(MeshError::Format(_))), "{text:.40}");
    wrong("");
    wrong("solid");
    wrong("sold");
    wrong(&text.replace("endsolid mesh\n", ""));
    wrong(&text.replacen("endloop", "", 1));
    wrong(&text.replacen("outer loop", "vertex 1 2 3", 1));
    wrong(&text.replacen("vertex ", "vertex nan ", 1));
    wrong(&format!("{text}{text}"));
    assert_eq!(Mesh::read(b"solid nothing\nendsolid nothing"), Err(MeshError::Empty));
    let mut cut = binary(&icosphere(0), b"");
    cut.pop();
    assert!(matches!(Mesh::read(&cut), Err(MeshError::Format(_))));
}

#[test]
fn damaged_bytes_never_panic() {
    let mut dice = SplitMix64::new(99);
    let binary = binary(&icosphere(1), b"");
    let text = Mesh::read(&binary).unwrap().to_text().into_bytes();
    let mut reported = BTreeMap::new();
    for _ in 0..3000 {
        for whole in [&binary, &text] {
            let mut bytes = whole.clone();
            for _ in 0..1 + dice.below(4) {
                let at = dice.below(bytes.len());
                bytes[at] = dice.next_u64() as u8;
            }
            if dice.below(4) == 0 {
                bytes.truncate(dice.below(bytes.len() + 1));
            }
            let result = Mesh::read(&bytes).and_then(|mesh| mesh.section(XY).and(mesh.section(XZ)));
            let name = result.map_or_else(
                |error| format!("{error:?}").split([' ', '(']).next().unwrap().to_owned(),
                |_| "fine".into(),
            );
            *reported.entry(name).or_insert(0) += 1;
        }
        let noise: Vec<u8> = (0..dice.below(300)).map(|_| dice.next_u64() as u8).collect();
        drop(Mesh::read(&noise));
    }
    // The damage was of several kinds.
    assert!(reported.len() >= 4, "{reported:?}");
}
