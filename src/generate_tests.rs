//! Counts, symmetry, quality and refusals of the generators.

use glam::{DVec3, dvec3};

use super::*;
use crate::math::smallest_angle;

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

#[test]
fn the_grid_is_numbered_as_stated() {
    let mesh = grid(3.0, 1.0, 3, 2).unwrap();
    mesh.check().unwrap();
    assert!(faces_up(&mesh));
    for j in 0..3 {
        for i in 0..4 {
            assert_eq!(mesh.positions[j * 4 + i], dvec3(3.0 * (i as f64 / 3.0), j as f64 / 2.0, 0.0));
        }
    }
    // Cell (0, 0) lower-left to upper-right, (1, 0) and (0, 1) the other way, (1, 1) as the first.
    let has_edge = |a: u32, b: u32| mesh.triangles.iter().any(|t| t.contains(&a) && t.contains(&b));
    assert!(has_edge(0, 5) && has_edge(5, 2) && has_edge(8, 5) && has_edge(5, 10));
    assert!(!has_edge(1, 4) && !has_edge(1, 6) && !has_edge(4, 9) && !has_edge(6, 9));
    for (nx, ny, triangles) in [(30, 25, 1_500), (95, 79, 15_010), (300, 250, 150_000)] {
        assert_eq!(grid(30.0, 30.0, nx, ny).unwrap().triangles.len(), triangles);
    }
}

#[test]
fn cooks_membrane_by_its_bilinear_map() {
    let map = |s: f64, t: f64| dvec3(48.0 * s, 44.0 * (s + t) - 28.0 * s * t, 0.0);
    let mesh = mapped_grid(4, 4, map).unwrap();
    mesh.check().unwrap();
    assert_eq!(
        [0, 4, 20, 24].map(|v| mesh.positions[v]),
        [[0.0, 0.0], [48.0, 44.0], [0.0, 44.0], [48.0, 60.0]].map(|[x, y]| dvec3(x, y, 0.0))
    );
    // Trapezium 48 × (44 + 16)/2; straight edges, so the triangles fill it to rounding.
    assert!((area(&mesh) - 1440.0).abs() < 1e-10);
}

#[test]
fn discs_are_round_and_well_shaped() {
    for target in [100, 1_500, 5_000, 20_000, 80_000] {
        let mesh = disc(15.0, target).unwrap();
        mesh.check().unwrap();
        assert!(faces_up(&mesh));
        let angle = smallest_angle_degrees(&mesh);
        assert!(angle >= 35.0, "{target}: {angle}");
        let count = mesh.triangles.len();
        assert!(count.abs_diff(target) * 100 <= 2 * target, "{target}: {count}");
        // The polygon with n corners on the circle has the area ½nr²sin(2π/n): all of it is covered once.
        let rim = mesh.positions.iter().filter(|p| (p.length() - 15.0).abs() < 1e-12).count() as f64;
        let polygon = 0.5 * rim * 225.0 * (TAU / rim).sin();
        assert!((area(&mesh) / polygon - 1.0).abs() < 1e-12);
    }
}

#[test]
fn every_small_disc_is_well_shaped() {
    for target in 24..400 {
        let mesh = disc(1.0, target).unwrap();
        mesh.check().unwrap();
        assert!(faces_up(&mesh));
        assert!(smallest_angle_degrees(&mesh) >= 25.0, "{target}: {}", smallest_angle_degrees(&mesh));
        assert!(mesh.triangles.len().abs_diff(target) * 10 <= target, "{target}: {}", mesh.triangles.len());
    }
}

#[test]
fn the_lens_capsule_at_its_four_sizes() {
    for target in [1_500, 5_000, 20_000, 80_000] {
        let mesh = cap(10.0, 9.8, target).unwrap();
        mesh.check().unwrap();
        assert!(faces_up(&mesh));
        assert_eq!(mesh.positions[0], DVec3::ZERO);
        let centre = dvec3(0.0, 0.0, -10.0);
        // Rounding of coordinates of size 10.
        assert!(mesh.positions.iter().all(|p| ((*p - centre).length() - 10.0).abs() < 1e-13));
        let widest = mesh.positions.iter().map(|p| p.truncate().length()).fold(0.0, f64::max);
        assert!((widest - 4.9).abs() < 1e-12);
        let (angle, count) = (smallest_angle_degrees(&mesh), mesh.triangles.len());
        println!("cap of {count} triangles ({target} asked): smallest angle {angle:.1}°");
        assert!(angle >= 35.0, "{target}: {angle}");
        assert!(count.abs_diff(target) * 100 <= 2 * target, "{target}: {count}");
    }
}

#[test]
fn deep_caps_up_to_the_hemisphere() {
    for diameter in [1e-6, 10.0, 19.0, 20.0] {
        let mesh = cap(10.0, diameter, 2_000).unwrap();
        mesh.check().unwrap();
        assert!(smallest_angle_degrees(&mesh) >= 25.0, "{diameter}: {}", smallest_angle_degrees(&mesh));
        assert!(mesh.triangles.len().abs_diff(2_000) <= 200, "{diameter}: {}", mesh.triangles.len());
    }
}

#[test]
fn the_plate_with_a_hole() {
    for n_t in [8, 32, 64, 128] {
        let mesh = plate_with_hole(n_t).unwrap();
        mesh.check().unwrap();
        assert!(faces_up(&mesh));
        assert_eq!((mesh.positions.len(), mesh.triangles.len()), (n_t * (n_t / 4 + 1), n_t * n_t / 2));
        let hole = 0.5 * n_t as f64 * (TAU / n_t as f64).sin();
        assert!((area(&mesh) - (100.0 - hole)).abs() < 1e-11);
        // The listed edge length at the hole, 2 sin(π/n_t).
        let edge = mesh.positions[0].distance(mesh.positions[1]);
        assert!((edge - 2.0 * (0.5 * TAU / n_t as f64).sin()).abs() < 1e-14);
    }
    let mesh = plate_with_hole(8).unwrap();
    let corner = mesh.positions[2 * 8 + 1];
    assert!((corner - dvec3(5.0, 5.0, 0.0)).length() < 1e-14);
    assert!(mesh.triangles[..2].iter().all(|t| t.contains(&0) && t.contains(&9)));
}

#[test]
fn silly_numbers_are_refused() {
    for bad in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        assert!(matches!(grid(bad, 1.0, 1, 1), Err(GenerateError::Length { what: "width", .. })));
        assert!(matches!(grid(1.0, bad, 1, 1), Err(GenerateError::Length { what: "height", .. })));
        assert!(matches!(disc(bad, 100), Err(GenerateError::Length { what: "radius", .. })));
        assert!(matches!(cap(bad, 1.0, 100), Err(GenerateError::Length { .. })));
        assert!(matches!(cap(1.0, bad, 100), Err(GenerateError::Length { .. })));
    }
    assert!(matches!(grid(1.0, 1.0, 0, 5), Err(GenerateError::TooFew { value: 0, least: 1, .. })));
    assert!(matches!(grid(1.0, 1.0, 5, 0), Err(GenerateError::TooFew { value: 0, least: 1, .. })));
    assert_eq!(grid(1.0, 1.0, 10_000, 10_000), Err(GenerateError::TooMany));
    assert_eq!(grid(1.0, 1.0, usize::MAX, 2), Err(GenerateError::TooMany));
    assert_eq!(disc(1.0, usize::MAX), Err(GenerateError::TooMany));
    assert_eq!(plate_with_hole(usize::MAX - 7), Err(GenerateError::TooMany));
    assert!(matches!(disc(1.0, 23), Err(GenerateError::TooFew { .. })));
    assert!(matches!(plate_with_hole(0), Err(GenerateError::TooFew { .. })));
    assert!(matches!(plate_with_hole(12), Err(GenerateError::NotMultiple { value: 12, of: 8, .. })));
    assert!(matches!(cap(1.0, 2.1, 100), Err(GenerateError::CapTooWide { .. })));
    let at_the_edge = mapped_grid(2, 2, |s, _| dvec3(1.0 / (1.0 - s), 0.0, 0.0));
    assert_eq!(at_the_edge, Err(GenerateError::NonFinitePosition { i: 2, j: 0 }));
}
