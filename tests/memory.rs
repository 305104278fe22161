//! Memory of a body after warm-up, per triangle. One test alone in its process: the counter sees every thread.

use glam::DVec3;
use rhexis::components::{
    Anchor, Contact, Curve, Damping, Drag, EnergyAudit, Fibres, Gravity, Hold, Material, Obstacle, Refinement, Shape,
    Sleeping, Springs, Tearing,
};
use rhexis::generate;
use rhexis::membrane::Membrane;
use rhexis::settings::{Advanced, LinearParams, Precision, Preconditioner, Settings};
use rhexis::simulation::Simulation;
use rhexis::storage::{Attached, Triangles};
use stats_alloc::{INSTRUMENTED_SYSTEM, Region, StatsAlloc};
use std::alloc::System;

#[global_allocator]
static GLOBAL: &StatsAlloc<System> = &INSTRUMENTED_SYSTEM;

fn square([nx, ny]: [usize; 2]) -> Membrane {
    let mesh = generate::grid(30.0, 30.0, nx, ny).unwrap();
    let mut body = Membrane::new("square", mesh, Material::allard_2009()).fibres(Fibres::at_degrees(45.0)).planar();
    for (name, x, way) in [("left", 0.0, DVec3::NEG_X), ("right", 30.0, DVec3::X)] {
        let members = Attached::new(body.select(|p| p.x == x).into_iter().map(|vertex| (vertex, way)));
        body =
            body.hold(Hold { name: name.into(), members, axes: [true; 3], curve: Curve::ramp(1000.0, 1.5).unwrap() });
    }
    body
}

/// Everything that costs memory per triangle or vertex.
fn laden(cells: [usize; 2]) -> Membrane {
    let body = square(cells);
    let anchor = Anchor::new(DVec3::ZERO, 0.0);
    let anchors = Attached::new(body.select(|p| p.y == 0.0).into_iter().map(|vertex| (vertex, anchor)));
    body.with(Tearing {
        strength_across_fibres: 1e6,
        strength_along_fibres: 1e6,
        may_initiate: true,
        ..Tearing::default()
    })
    .with(Refinement::default())
    .with(Contact { stiffness: Some(0.01), friction: 0.0, ..Contact::default() })
    .with(Drag { coefficient: 1e-6 })
    .with(Gravity { acceleration: DVec3::X * 1e-6 })
    .with(Damping { time: 0.1 })
    .with(Springs { anchors })
    .with(Sleeping::default())
    .with(EnergyAudit::default())
}

/// Bytes per triangle once a few steps have been made, and a few more after a cut if there is to be one. The iterations are limited: they
/// need no memory.
fn bytes_per_triangle(
    membrane: impl Fn() -> Membrane,
    preconditioner: Preconditioner,
    precision: Precision,
    is_cut: bool,
) -> usize {
    let region = Region::new(GLOBAL);
    let linear = LinearParams { iterations: 5, ..LinearParams::default() };
    let settings = Settings {
        // Solves of five iterations leave steps to be tried again, as often as it takes.
        budget: None,
        threads: 1,
        advanced: Advanced { preconditioner, precision, linear, ..Advanced::default() },
        ..Settings::default()
    };
    let mut simulation = Simulation::new(settings).unwrap();
    let body = simulation.spawn(membrane()).unwrap();
    simulation.spawn_obstacle(Obstacle { shape: Shape::Sphere { centre: DVec3::Z * 50.0, radius: 1.0 } }).unwrap();
    for _ in 0..3 {
        simulation.step(1.0).unwrap();
    }
    if is_cut {
        simulation.cut(body, &[DVec3::new(14.0, 13.0, 0.0), DVec3::new(15.5, 16.0, 0.0)]).unwrap();
        for _ in 0..3 {
            simulation.step(1.0).unwrap();
        }
    }
    let change = region.change();
    let count = simulation.world().get::<&Triangles>(body.entity()).unwrap().len();
    (change.bytes_allocated - change.bytes_deallocated) / count
}

#[test]
fn memory_grows_with_what_a_body_carries() {
    use Preconditioner::{BlockJacobi, IncompleteCholesky};
    for cells in [[95, 79], [180, 150]] {
        let plain = bytes_per_triangle(|| square(cells), BlockJacobi, Precision::Double, false);
        let elastic = bytes_per_triangle(|| square(cells), IncompleteCholesky, Precision::Mixed, false);
        let [all, cut] =
            [false, true].map(|cut| bytes_per_triangle(|| laden(cells), IncompleteCholesky, Precision::Mixed, cut));
        println!(
            "{cells:?}: {plain} B per triangle in double precision, {elastic} with the incomplete factor, {all} with all, {cut} after a cut"
        );
        // What is asked for; the others as measured, and 5 % for what lists are given to spare. docs/performance.md says who holds it.
        assert!(plain <= 350 && all <= 700, "{plain} {all}");
        assert!(elastic <= 577 && cut <= 815, "{elastic} {cut}");
    }
}
