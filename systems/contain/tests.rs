//! The lanes against one triangle after another, and the instruction sets against each other.

use super::*;
use crate::components::{Fibres, Material};
use crate::membrane::Membrane;
use crate::scene::generate;
use crate::settings::Settings;
use crate::simulation::Simulation;
use crate::systems::kernels::simd::{force_portable, run};

/// A sheet after a step, then thrown about: any shape and displacement, and some triangles collapsed to a point.
fn with_sheet(is_planar: bool, f: impl FnOnce(&mut Solved)) {
    let mesh = generate::grid(10.0, 8.0, 7, 5).unwrap();
    let sheet = Membrane::new("sheet", mesh, Material::figure_2()).fibres(Fibres::at_degrees(30.0));
    let mut simulation = Simulation::new(Settings { threads: 1, ..Settings::default() }).unwrap();
    let body = simulation.spawn(if is_planar { sheet.planar() } else { sheet }).unwrap();
    let wave = |v: usize, k: f64| (k * v as f64).sin();
    {
        let mut vertices = simulation.world().get::<&mut Vertices>(body).unwrap();
        for (v, x) in vertices.position.iter_mut().enumerate() {
            *x += DVec3::new(wave(v, 7.1), wave(v, 3.3), if is_planar { 0.0 } else { wave(v, 5.7) }) * 0.3;
        }
    }
    simulation.step(10.0).unwrap();
    let mut query = simulation
        .world()
        .query_one::<((&mut Vertices, &Triangles, &Topology, &Frames), (&mut Increment, &SolverScratch))>(body);
    let ((vertices, triangles, topology, frames), (increment, scratch)) = query.get().unwrap();
    for (v, u) in increment.delta.iter_mut().enumerate() {
        *u = DVec3::new(wave(v, 2.9), wave(v, 4.1), if is_planar { 0.0 } else { wave(v, 6.3) }) * 0.5;
    }
    for (v, u) in increment.displacement.iter_mut().enumerate() {
        *u = DVec3::new(wave(v, 1.9), wave(v, 5.3), if is_planar { 0.0 } else { wave(v, 8.1) }) * 0.5;
    }
    for v in triangles.corners[3] {
        (vertices.position[v as usize], increment.delta[v as usize]) = (DVec3::ZERO, DVec3::X);
    }
    let tangent = Tangent::Rotated;
    let (external, folds, inertia, viscosity) = (None, None, 0.01, 0.7);
    let vertices = &*vertices;
    let operator = Operator { vertices, triangles, topology, frames, external, folds, inertia, viscosity, tangent };
    let unstretched = Sym2::new(0.98, 1.01, 0.005);
    let (is_counted, rate, far, lets_pass) = (false, 0.1, 0.0, false);
    let (free, fibres) = (&scratch.free[..], None);
    f(&mut Solved { operator, increment, free, unstretched, fibres, is_planar, is_counted, rate, far, lets_pass });
}

#[test]
fn lanes_agree_with_one_triangle_after_another() {
    for is_planar in [false, true] {
        with_sheet(is_planar, |solved| {
            let count = solved.operator.triangles.len();
            let before = force_portable(true);
            // All; those that go far.
            for far in [0.0, 0.3] {
                solved.far = far;
                let each: Vec<f64> = (0..count).map(|t| solved.of_triangle(t, 1.0)).collect();
                let wide = [true, false].map(|is_portable| {
                    force_portable(is_portable);
                    run(&Whole(solved), 0, &mut vec![(); count])
                });
                assert_eq!(wide[0].to_bits(), wide[1].to_bits(), "planar {is_planar}, far {far}");
                // Rounding of sums of work and energy, each some thousand times what is left over of the smallest triangle.
                let (sum, size) = each.iter().fold((0.0, 0.0), |(sum, size), e| (sum + e, size + e.abs()));
                assert!((wide[0] - sum).abs() <= 1e-12 * size, "planar {is_planar}, far {far}: {} for {sum}", wide[0]);
                let is_any = each.iter().any(|&e| e != 0.0);
                assert!(is_any && (far == 0.0 || each.contains(&0.0)), "planar {is_planar}, far {far}: {each:?}");
            }
            force_portable(before);
        });
    }
}
