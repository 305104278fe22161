//! Random surfaces: sheets, discs, caps, plates with a hole, closed ones, slivers.

use super::dice::Dice;
use glam::{DVec3, dvec3};
use rhexis::generate;
use rhexis::storage::TriangleMesh;
use std::collections::HashMap;

/// How large a mesh may be.
struct Most {
    /// Cells of a grid along each side.
    cells: usize,
    /// Triangles of a disc or a cap.
    triangles: usize,
    /// Eights of points round a hole.
    layers: usize,
    /// Divisions in four of an octahedron's triangles.
    divisions: usize,
}

/// Of nine meshes in ten: a step of few triangles finds as many faults as one of many, and more of them in an hour.
const SMALL: Most = Most { cells: 4, triangles: 16, layers: 1, divisions: 1 };
/// Of most others.
const MIDDLING: Most = Most { cells: 12, triangles: 250, layers: 3, divisions: 3 };
/// Of some.
const LARGE: Most = Most { cells: 40, triangles: 3000, layers: 10, divisions: 4 };

/// A surface of some triangles, and whether it lies in z = 0.
pub(super) fn surface(dice: &mut Dice) -> (TriangleMesh, bool) {
    let size = if dice.chance(0.2) { dice.decades(-2.0, 2.0) } else { dice.between(2.0, 20.0) };
    let Most { cells, triangles, layers, divisions } = match dice.below(1000) {
        0..5 => LARGE,
        5..100 => MIDDLING,
        _ => SMALL,
    };
    let [nx, ny] = [(); 2].map(|()| 1 + dice.below(cells));
    let height = size * ny as f64 / nx as f64;
    let made = match dice.below(8) {
        0 | 1 => generate::grid(size, height, nx, ny),
        2 => generate::jittered(size, height, nx, ny, dice.bits()),
        3 => generate::disc(0.5 * size, 24 + dice.below(triangles)),
        4 => generate::cap(size, size * dice.between(0.5, 1.99), 24 + dice.below(triangles)),
        5 => generate::plate_with_hole(8 * (1 + dice.below(layers))),
        6 => return (closed(dice, size, divisions), false),
        // Slivers down to a hundredth as wide as long.
        _ => generate::grid(size, height * dice.decades(-2.0, 0.0), nx, ny),
    };
    let mesh = made.unwrap_or_default();
    let is_flat = mesh.positions.iter().all(|x| x.z == 0.0);
    (mesh, is_flat)
}

/// The least coordinates.
pub(super) fn lowest(points: &[DVec3]) -> DVec3 {
    points.iter().fold(DVec3::MAX, |least, &x| least.min(x))
}

/// The largest coordinates.
pub(super) fn highest(points: &[DVec3]) -> DVec3 {
    points.iter().fold(DVec3::MIN, |most, &x| most.max(x))
}

/// An ellipsoid of an octahedron whose triangles are divided in four up to so many times.
fn closed(dice: &mut Dice, size: f64, most: usize) -> TriangleMesh {
    let mut positions = vec![DVec3::X, DVec3::NEG_X, DVec3::Y, DVec3::NEG_Y, DVec3::Z, DVec3::NEG_Z];
    let mut triangles: Vec<[u32; 3]> =
        vec![[0, 2, 4], [2, 1, 4], [1, 3, 4], [3, 0, 4], [2, 0, 5], [1, 2, 5], [3, 1, 5], [0, 3, 5]];
    for _ in 0..dice.below(most + 1) {
        let mut middles = HashMap::new();
        let mut middle = |a: u32, b: u32| {
            *middles.entry((a.min(b), a.max(b))).or_insert_with(|| {
                positions.push((positions[a as usize] + positions[b as usize]).normalize_or(DVec3::X));
                positions.len() as u32 - 1
            })
        };
        let divided = triangles.iter().flat_map(|&[a, b, c]| {
            let [ab, bc, ca] = [middle(a, b), middle(b, c), middle(c, a)];
            [[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]
        });
        triangles = divided.collect();
    }
    let half_axes = dvec3(1.0, dice.between(0.3, 1.0), dice.between(0.1, 1.0)) * (0.5 * size);
    positions.iter_mut().for_each(|x| *x *= half_axes);
    TriangleMesh { positions, triangles, ..TriangleMesh::default() }
}
