//! A body that has many cuts takes more.

use glam::DVec3;
use rhexis::components::{Fibres, Material, Tearing};
use rhexis::generate::{self, Random};
use rhexis::membrane::Membrane;
use rhexis::settings::Settings;
use rhexis::simulation::Simulation;
use rhexis::storage::{Topology, TriangleMesh, Triangles, Vertices, validate};

/// Number of cuts of a body, and of those made at the least.
const CUTS: usize = 40;
const MADE: usize = 36;

/// Cuts a sheet of 20 by 20 mm along random lines. Returns how many cuts were made, and the largest distance \[mm\] of one from its line.
fn cut_all(mesh: TriangleMesh, seed: u64) -> (usize, f64) {
    let mut simulation = Simulation::new(Settings { threads: 1, ..Settings::default() }).unwrap();
    let membrane = Membrane::new("net", mesh, Material::isotropic(0.5, 0.3, 0.1));
    let body = simulation.spawn(membrane.fibres(Fibres::at_degrees(0.0)).with(Tearing::default())).unwrap();
    let mut random = Random::new(seed);
    let mut place = || DVec3::new(1.0 + 18.0 * random.unit(), 1.0 + 18.0 * random.unit(), 0.0);
    let (mut made, mut off_line) = (0, 0.0_f64);
    for _ in 0..CUTS {
        let line = [place(), place()];
        if let Ok(cut) = simulation.cut(body, &line) {
            (made, off_line) = (made + 1, off_line.max(cut.off_line));
        }
        let world = simulation.world();
        let mut of_body = world.query_one::<(&Vertices, &Triangles, &Topology)>(body.entity());
        let (vertices, triangles, topology) = of_body.get().unwrap();
        assert_eq!(validate(vertices, triangles, topology), Ok(()));
    }
    (made, off_line)
}

#[test]
fn nine_of_ten_random_cuts_are_made_on_a_body_that_has_many() {
    let meshes = [generate::grid(20.0, 20.0, 20, 20), generate::jittered(20.0, 20.0, 20, 20, 0)];
    for (mesh, name) in meshes.into_iter().zip(["grid", "jittered"]) {
        let (made, off_line) = cut_all(mesh.unwrap(), 0);
        // An end is at most one mean edge from its place, which is 1.2 mm here.
        assert!(made >= MADE && off_line <= 1.3, "{name}: {made} of {CUTS}, {off_line} mm");
    }
}
