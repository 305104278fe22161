//! Each way a mesh can be wrong, and the two repairs.

use glam::{DVec3, dvec3};

use super::TriangleMesh;
use crate::storage::MeshError;

fn mesh(positions: &[[f64; 3]], triangles: &[[u32; 3]]) -> TriangleMesh {
    TriangleMesh {
        positions: positions.iter().map(|&p| p.into()).collect(),
        triangles: triangles.to_vec(),
        fibres: None,
    }
}

/// Two triangles on the unit square.
fn square() -> TriangleMesh {
    mesh(&[[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]], &[[0, 1, 2], [0, 2, 3]])
}

/// A band of `n` quads closed on itself after `half_twists` half turns.
fn band(n: u32, half_twists: u32) -> TriangleMesh {
    let mut positions = Vec::new();
    for i in 0..n {
        let angle = std::f64::consts::TAU * f64::from(i) / f64::from(n);
        let lean = 0.5 * angle * f64::from(half_twists);
        let out = dvec3(angle.cos(), angle.sin(), 0.0);
        let across = out * lean.cos() + DVec3::Z * lean.sin();
        positions.extend([out * 3.0 - across, out * 3.0 + across]);
    }
    let mut triangles = Vec::new();
    for i in 0..n {
        let (a, b) = (2 * i, 2 * i + 1);
        let (mut c, mut d) = (2 * ((i + 1) % n), 2 * ((i + 1) % n) + 1);
        if i + 1 == n && half_twists % 2 == 1 {
            std::mem::swap(&mut c, &mut d);
        }
        triangles.extend([[a, c, b], [b, c, d]]);
    }
    TriangleMesh { positions, triangles, fibres: None }
}

#[test]
fn a_good_mesh_passes() {
    assert_eq!(square().check(), Ok(()));
    assert_eq!(band(12, 0).check(), Ok(()));
    // Closed surfaces have no boundary at all.
    let tetrahedron = mesh(
        &[[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
        &[[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]],
    );
    assert_eq!(tetrahedron.check(), Ok(()));
}

#[test]
fn empty_meshes_are_refused() {
    assert_eq!(TriangleMesh::default().check(), Err(MeshError::Empty("vertices")));
    assert_eq!(mesh(&[[0.0; 3]], &[]).check(), Err(MeshError::Empty("triangles")));
}

#[test]
fn positions_and_corners_are_checked() {
    for bad in [f64::NAN, f64::INFINITY] {
        let mut m = square();
        m.positions[2].y = bad;
        assert!(matches!(m.check(), Err(MeshError::NonFinitePosition { vertex: 2, .. })));
    }
    let mut m = square();
    m.triangles[1][2] = 4;
    let error = MeshError::IndexOutOfRange { triangle: 1, index: 4, count: 4 };
    assert_eq!(m.check(), Err(error.clone()));
    assert_eq!(m.clone().oriented(), Err(error.clone()));
    assert_eq!(m.without_unused_vertices().check(), Err(error));
    for (corners, vertex) in [([0, 0, 3], 0), ([0, 3, 3], 3), ([3, 0, 3], 3)] {
        let mut m = square();
        m.triangles[1] = corners;
        assert_eq!(m.check(), Err(MeshError::RepeatedCorner { triangle: 1, vertex }));
    }
}

#[test]
fn degenerate_triangles_are_refused_at_any_scale() {
    // 1e-200 would underflow in a plain cross product.
    for scale in [1e-200, 1.0, 1e70] {
        let with_height = |height: f64| {
            mesh(&[[0.0; 3], [scale, 0.0, 0.0], [0.5 * scale, height * scale, 0.0]], &[[0, 1, 2]]).check()
        };
        assert_eq!(with_height(1.0), Ok(()));
        assert_eq!(with_height(2e-9), Ok(()));
        assert!(matches!(with_height(5e-10), Err(MeshError::Degenerate { triangle: 0, .. })));
        assert_eq!(with_height(0.0), Err(MeshError::Degenerate { triangle: 0, ratio: 0.0 }));
    }
    let coincident = mesh(&[[1.0; 3], [1.0; 3], [1.0; 3]], &[[0, 1, 2]]);
    assert_eq!(coincident.check(), Err(MeshError::Degenerate { triangle: 0, ratio: 0.0 }));
    // Areas of such edges are no numbers.
    for size in [1e76, 1e155, 1e308] {
        let huge = mesh(&[[-size, 0.0, 0.0], [size, 0.0, 0.0], [0.0, size, 0.0]], &[[0, 1, 2]]);
        assert!(matches!(huge.check(), Err(MeshError::NonFinitePosition { vertex: 0, .. })), "{size}");
    }
}

#[test]
fn duplicates_and_extra_sheets_are_refused() {
    let mut m = square();
    m.triangles.push([2, 0, 1]);
    assert_eq!(m.check(), Err(MeshError::Duplicate { first: 0, second: 2 }));

    let mut m = square();
    m.positions.push(dvec3(0.5, 0.5, 1.0));
    m.triangles.push([0, 2, 4]);
    let error = MeshError::NonManifoldEdge { edge: [0, 2], triangles: vec![0, 1, 2] };
    assert_eq!(m.check(), Err(error.clone()));
    assert_eq!(m.oriented(), Err(error));
}

#[test]
fn orientation_is_checked_and_mended() {
    let mut m = square();
    m.triangles[1] = [0, 3, 2];
    assert_eq!(m.check(), Err(MeshError::InconsistentOrientation { edge: [0, 2], first: 0, second: 1 }));
    let mended = m.oriented().unwrap();
    assert_eq!(mended, square());

    // Every third triangle turned over: the first keeps its sense, so the original comes back.
    let good = band(40, 2);
    let mut bad = good.clone();
    bad.triangles.iter_mut().skip(1).step_by(3).for_each(|t| t.swap(1, 2));
    assert!(matches!(bad.check(), Err(MeshError::InconsistentOrientation { .. })));
    assert_eq!(bad.oriented().unwrap(), good);
}

#[test]
fn each_piece_keeps_the_sense_of_its_first_triangle() {
    let mut m = square();
    m.positions.extend([dvec3(5.0, 0.0, 0.0), dvec3(6.0, 0.0, 0.0), dvec3(5.0, 1.0, 0.0), dvec3(6.0, 1.0, 0.0)]);
    m.triangles.extend([[4, 6, 5], [5, 7, 6]]);
    let mended = m.oriented().unwrap();
    assert_eq!(mended.triangles, [[0, 1, 2], [0, 2, 3], [4, 6, 5], [5, 6, 7]]);
    assert_eq!(mended.check(), Ok(()));
}

#[test]
fn a_moebius_strip_is_refused() {
    assert!(matches!(band(12, 1).oriented(), Err(MeshError::NotOrientable { .. })));
    assert!(matches!(band(12, 1).check(), Err(MeshError::InconsistentOrientation { .. })));
    assert!(band(12, 2).oriented().is_ok());
}

#[test]
fn bowties_are_refused() {
    let m = mesh(
        &[[0.0; 3], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [-1.0, 0.0, 0.0], [-1.0, -1.0, 0.0]],
        &[[0, 1, 2], [0, 3, 4]],
    );
    assert_eq!(m.check(), Err(MeshError::Bowtie { vertex: 0, fans: 2 }));
}

#[test]
fn unused_vertices_are_refused_and_can_be_dropped() {
    let mut m = square();
    m.positions.insert(1, dvec3(9.0, 9.0, 9.0));
    m.triangles.iter_mut().flatten().for_each(|corner| *corner += u32::from(*corner > 0));
    assert_eq!(m.check(), Err(MeshError::UnusedVertex { vertex: 1 }));
    assert_eq!(m.without_unused_vertices(), square());
}

#[test]
fn fibres_are_checked() {
    let mut m = square();
    m.fibres = Some(vec![DVec3::X]);
    assert_eq!(m.check(), Err(MeshError::FibreCount { fibres: 1, triangles: 2 }));
    for bad in [DVec3::ZERO, dvec3(0.0, f64::NAN, 1.0)] {
        m.fibres = Some(vec![DVec3::X, bad]);
        assert!(matches!(m.check(), Err(MeshError::BadFibre { triangle: 1, .. })));
    }
    m.fibres = Some(vec![DVec3::X * 7.0, DVec3::Y]);
    assert_eq!(m.check(), Ok(()));
}
