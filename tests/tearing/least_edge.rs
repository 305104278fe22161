//! Tears among the lips of other tears leave no triangles of any size.

use crate::meshes::{Body, Random, Sheet};
use glam::DVec3;
use rhexis::generate;
use rhexis::systems::fracture::{Cutter, Quality, TearScratch};

const RADIUS: f64 = 1.5;

/// The shortest edge \[mm\] after so many advances from random vertices of the boundary near one place.
fn shortest_after(quality: Quality, count: usize) -> (f64, usize) {
    let mesh = generate::grid(4.0, 4.0, 5, 5).unwrap();
    let sheet: Sheet = mesh.into();
    let mut body = Body::new(&sheet, DVec3::X);
    let (mut random, mut scratch, mut advanced) = (Random::new(11), TearScratch::default(), 0);
    for _ in 0..count {
        let rim: Vec<u32> = {
            let near = |v: &u32| body.vertices.rest_position[*v as usize].distance(DVec3::new(2.0, 0.0, 0.0)) < 0.9;
            (0..body.vertices.len() as u32).filter(|v| body.topology.is_boundary_vertex(*v)).filter(near).collect()
        };
        let from = rim[random.below(rim.len())];
        let angle = random.unit() * std::f64::consts::TAU;
        let mut mesh = body.mesh();
        let mut cutter = Cutter { mesh: &mut mesh, is_movable: &|_| true, quality, scratch: &mut scratch };
        advanced += usize::from(cutter.advance(from, DVec3::new(angle.cos(), angle.sin(), 0.0)).is_ok());
        scratch.records.clear();
    }
    assert_eq!(body.mesh().validate(), Ok(()));
    let edges = body.triangles.corners.iter().flat_map(|&[a, b, c]| [[a, b], [b, c], [c, a]]);
    let length =
        |[a, b]: [u32; 2]| body.vertices.rest_position[a as usize].distance(body.vertices.rest_position[b as usize]);
    (edges.map(length).fold(f64::INFINITY, f64::min), advanced)
}

#[test]
fn tears_among_tears_leave_no_edge_below_the_least() {
    let quality = Quality::of_radius(RADIUS);
    let (bounded, advanced) = shortest_after(quality, 600);
    let (free, _) = shortest_after(Quality::default(), 600);
    assert!(advanced > 50, "{advanced} advances");
    // Angles alone let the same tears go on below it.
    assert!(free < 0.5 * quality.least_edge, "{free} mm without a least edge");
    assert!(bounded >= quality.least_edge, "{bounded} mm of {} mm", quality.least_edge);
}
