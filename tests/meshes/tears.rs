//! What the tests of tears share: a cutter without limits, angles, undoing.

use super::Body;
use glam::DVec3;
use rhexis::storage::{Mesh, measure::rest_angles, undo};
use rhexis::systems::fracture::{Cutter, Quality, TearScratch};

fn everything(_: u32) -> bool {
    true
}

pub fn cutter<'c, 'm>(mesh: &'c mut Mesh<'m>, scratch: &'c mut TearScratch) -> Cutter<'c, 'm> {
    Cutter { mesh, is_movable: &everything, quality: Quality::default(), scratch }
}

/// Smallest angle and first percentile \[degrees\].
pub fn angles(body: &Body) -> (f64, f64) {
    let mut all: Vec<f64> = rest_angles(&body.vertices, &body.triangles).map(f64::to_degrees).collect();
    all.sort_by(f64::total_cmp);
    (all[0], all[all.len() / 100])
}

pub fn nearest(body: &Body, point: DVec3) -> u32 {
    let distance = |v: &u32| body.vertices.rest_position[*v as usize].distance(point);
    (0..body.vertices.len() as u32).min_by(|a, b| distance(a).total_cmp(&distance(b))).unwrap()
}

pub fn undo_all(body: &mut Body, scratch: &TearScratch) {
    for record in scratch.records.iter().rev() {
        undo(&mut body.mesh(), record).unwrap();
    }
}

pub fn assert_same(body: &Body, start: &Body) {
    assert_eq!(body.topology, start.topology);
    assert_eq!(body.vertices.keys(), start.vertices.keys());
    for row in 0..start.vertices.len() as u32 {
        assert_eq!(body.vertices.at(row), start.vertices.at(row));
    }
    assert_eq!(body.triangles.len(), start.triangles.len());
    for row in 0..start.triangles.len() as u32 {
        assert_eq!(body.triangles.at(row), start.triangles.at(row));
    }
}
