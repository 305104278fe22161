//! Loads along an edge follow what a blade does to it.

use glam::DVec3;
use rhexis::components::{Curve, EdgeLoad, EdgeLoads, Material};
use rhexis::generate;
use rhexis::membrane::Membrane;
use rhexis::settings::Settings;
use rhexis::simulation::Simulation;
use rhexis::storage::{Topology, Triangles, Vertices};

#[test]
fn a_cut_through_a_loaded_edge_keeps_its_length_and_its_edges_on_the_boundary() {
    let mesh = generate::grid(4.0, 3.0, 4, 3).unwrap();
    let sheet = Membrane::new("sheet", mesh, Material::allard_2009()).planar();
    let top = sheet.select(|p| p.y == 3.0);
    let edges = top.windows(2).map(|pair| [pair[0], pair[1]]).collect();
    let load = EdgeLoad { edges, traction: DVec3::Y, curve: Curve::constant(1.0) };
    let mut simulation = Simulation::new(Settings::default()).unwrap();
    let body = simulation.spawn(sheet.with(EdgeLoads { groups: vec![load] })).unwrap();
    // Through the middle of an edge, which is split, and through a vertex, which is doubled.
    simulation.cut(body, &[DVec3::new(1.5, 3.0, 0.0), DVec3::new(1.5, 1.5, 0.0)]).unwrap();
    simulation.cut(body, &[DVec3::new(3.0, 3.0, 0.0), DVec3::new(3.0, 2.0, 0.0)]).unwrap();

    let world = simulation.world();
    let (vertices, triangles) =
        (world.get::<&Vertices>(body.entity()).unwrap(), world.get::<&Triangles>(body.entity()).unwrap());
    let topology = world.get::<&Topology>(body.entity()).unwrap();
    let loads = world.get::<&EdgeLoads>(body.entity()).unwrap();
    let edges = &loads.groups[0].edges;
    assert_eq!(edges.len(), 5);
    let length: f64 = edges
        .iter()
        .map(|&[a, b]| vertices.rest_position[a as usize].distance(vertices.rest_position[b as usize]))
        .sum();
    // Sums of five lengths of about 1 mm.
    assert!((length - 4.0).abs() < 1e-14, "{length}");
    for &[a, b] in edges {
        let next = |v| topology.next_boundary_vertex(&triangles.corners, v);
        assert!(next(a) == Some(b) || next(b) == Some(a), "edge {a}-{b} is not on the boundary");
    }
}
