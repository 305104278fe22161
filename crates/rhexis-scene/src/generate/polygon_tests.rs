//! Quality and refusals of meshes in polygons.

use glam::{DVec3, dvec3};

use super::super::jittered;
use super::*;
use rhexis::math::smallest_angle;
use std::f64::consts::TAU;

fn corners_of(mesh: &TriangleMesh) -> impl Iterator<Item = [DVec3; 3]> {
    mesh.triangles.iter().map(|t| t.map(|corner| mesh.positions[corner as usize]))
}

fn smallest_angle_degrees(mesh: &TriangleMesh) -> f64 {
    corners_of(mesh).map(|x| smallest_angle(x).to_degrees()).fold(f64::INFINITY, f64::min)
}

fn area(mesh: &TriangleMesh) -> f64 {
    corners_of(mesh).map(|[a, b, c]| 0.5 * (b - a).cross(c - a).length()).sum()
}

fn faces_up(mesh: &TriangleMesh) -> bool {
    corners_of(mesh).all(|[a, b, c]| (b - a).cross(c - a).z > 0.0)
}

/// Meshes of one shape in every pattern: well shaped, without gaps, corners exact, the same again.
#[test]
fn patterns_fill_the_square_with_good_triangles() {
    let corners = [[0.0, 0.0], [30.0, 0.0], [30.0, 30.0], [0.0, 30.0]].map(DVec2::from);
    for k in 0..24 {
        let edge = [2.0, 1.0, 0.7][k as usize % 3];
        let cells = (30.0 / edge) as usize;
        let patterns: [&dyn Fn() -> TriangleMesh; 3] = [
            &|| jittered(30.0, 30.0, cells, cells * 5 / 6, k).unwrap(),
            &|| lattice(&corners, edge, 5.0 * k as f64).unwrap(),
            &|| unstructured(&corners, edge, k).unwrap(),
        ];
        for (pattern, make) in patterns.iter().enumerate() {
            let mesh = make();
            mesh.check().unwrap();
            assert!(faces_up(&mesh));
            assert!((area(&mesh) - 900.0).abs() < 1e-9);
            for corner in corners {
                assert!(mesh.positions.contains(&corner.extend(0.0)));
            }
            let angle = smallest_angle_degrees(&mesh);
            assert!(angle >= 25.0, "pattern {pattern}, {k}: {angle}");
            assert_eq!(mesh, make());
            // Triangles of the edge asked for, but for the border.
            let expected = 900.0 / (edge * edge * 0.75_f64.sqrt() / 2.0);
            let share = mesh.triangles.len() as f64 / expected;
            assert!(pattern == 0 || (0.85..1.1).contains(&share), "pattern {pattern}, {k}: {share}");
        }
    }
    assert_ne!(unstructured(&corners, 2.0, 1), unstructured(&corners, 2.0, 2));
}

#[test]
fn the_lattice_is_regular_inside_and_turned() {
    let corners = [[0.0, 0.0], [20.0, 0.0], [20.0, 20.0], [0.0, 20.0]].map(DVec2::from);
    let mesh = lattice(&corners, 1.0, 13.0).unwrap();
    let middle = |x: &[DVec3; 3]| ((x[0] + x[1] + x[2]) / 3.0).distance(dvec3(10.0, 10.0, 0.0)) < 6.0;
    for [a, b, c] in corners_of(&mesh).filter(middle) {
        for side in [b - a, c - b, a - c] {
            assert!((side.length() - 1.0).abs() < 1e-12);
            let turn = (side.y.atan2(side.x).to_degrees() - 13.0).rem_euclid(60.0);
            assert!(turn.min(60.0 - turn) < 1e-9);
        }
    }
}

#[test]
fn polygons_with_notches_are_filled_and_knots_refused() {
    let notched = [[0.0, 0.0], [10.0, 0.0], [10.0, 8.0], [5.0, 3.0], [0.0, 8.0]].map(DVec2::from);
    let mut clockwise = notched;
    clockwise.reverse();
    for mesh in [unstructured(&notched, 0.5, 3), lattice(&clockwise, 0.5, 10.0)] {
        let mesh = mesh.unwrap();
        mesh.check().unwrap();
        assert!(faces_up(&mesh) && (area(&mesh) - 55.0).abs() < 1e-10);
        assert!(smallest_angle_degrees(&mesh) >= 25.0, "{}", smallest_angle_degrees(&mesh));
    }
    // Sides in any direction, whose points are off the line by roundings.
    for k in 0..6 {
        let corner = |i: usize| DVec2::from_angle(0.3 * k as f64 + TAU * i as f64 / 7.0) * 10.0 + DVec2::new(3.1, -7.7);
        let outline: Vec<DVec2> = (0..7).map(corner).collect();
        let inside = 0.5 * 7.0 * 100.0 * (TAU / 7.0).sin();
        for mesh in [unstructured(&outline, 0.7, k), lattice(&outline, 0.7, k as f64)] {
            let mesh = mesh.unwrap();
            mesh.check().unwrap();
            assert!(faces_up(&mesh) && (area(&mesh) / inside - 1.0).abs() < 1e-12);
            assert!(smallest_angle_degrees(&mesh) >= 25.0, "{k}: {}", smallest_angle_degrees(&mesh));
        }
    }
    let knot = [[0.0, 0.0], [4.0, 4.0], [4.0, 0.0], [0.0, 4.0]].map(DVec2::from);
    let flat = [[0.0, 0.0], [4.0, 0.0], [8.0, 0.0]].map(DVec2::from);
    let twice = [[0.0, 0.0], [4.0, 0.0], [4.0, 0.0], [0.0, 4.0]].map(DVec2::from);
    for outline in [&knot[..], &flat, &twice, &knot[..2], &[DVec2::NAN; 3]] {
        assert!(matches!(unstructured(outline, 0.5, 1), Err(GenerateError::Outline(_))), "{outline:?}");
        assert!(matches!(lattice(outline, 0.5, 1.0), Err(GenerateError::Outline(_))), "{outline:?}");
    }
    assert!(matches!(lattice(&notched, 0.5, f64::NAN), Err(GenerateError::Angle(_))));
    assert!(matches!(unstructured(&notched, 0.0, 1), Err(GenerateError::Length { .. })));
    assert_eq!(unstructured(&notched, 1e-6, 1), Err(GenerateError::TooMany));
    assert_eq!(unstructured(&notched.map(|p| p * 1e300), 1.0, 1), Err(GenerateError::TooMany));
    // An edge longer than the sides: the corners alone.
    assert_eq!(unstructured(&notched, 100.0, 1).unwrap().triangles.len(), 3);
}
