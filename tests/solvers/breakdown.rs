//! Solves that break down have a way out: what single precision cannot hold, and what iterations do not solve.

use glam::DVec3;
use rhexis::components::{Curve, Fibres, Hold, Material};
use rhexis::generate;
use rhexis::membrane::Membrane;
use rhexis::settings::{Advanced, LinearParams, Precision, Settings};
use rhexis::simulation::Simulation;
use rhexis::storage::{Attached, BodyId, Vertices};

/// A strip of slivers, ten times as long as wide, whose left end is held and whose right end is drawn by `way` \[mm\] in 10 ms.
fn strip(material: Material, settings: Settings, way: f64) -> (Simulation, BodyId) {
    let mesh = generate::grid(10.0, 1.0, 12, 12).unwrap();
    let strip = Membrane::new("strip", mesh, material).fibres(Fibres::at_degrees(20.0));
    let hold = |name: &str, x: f64, to: f64| {
        let rows = strip.select(|p| p.x == x).into_iter();
        let members = Attached::new(rows.map(|row| (row, DVec3::X * to)));
        Hold { name: name.into(), members, axes: [true; 3], curve: Curve::ramp(10.0, 1.0).unwrap() }
    };
    let (left, right) = (hold("left", 0.0, 0.0), hold("right", 10.0, way));
    let mut simulation = Simulation::new(settings).unwrap();
    let body = simulation.spawn(strip.hold(left).hold(right).planar()).unwrap();
    (simulation, body)
}

fn positions(simulation: &Simulation, body: BodyId) -> Vec<DVec3> {
    simulation.world().get::<&Vertices>(body.entity()).unwrap().position.clone()
}

#[test]
fn a_stiffness_beyond_single_precision_is_solved_in_double() {
    let linear = LinearParams::by_residual(1e-8, 2000);
    let [mixed, double] = [Precision::Mixed, Precision::Double].map(|precision| {
        let settings = Settings {
            threads: 1,
            advanced: Advanced { linear, precision, ..Advanced::default() },
            ..Settings::default()
        };
        // 1e42 N/mm: the largest single precision number is 3e38.
        let (mut simulation, body) = strip(Material::isotropic(1e43, 0.3, 0.1), settings, 0.1);
        for _ in 0..3 {
            let report = simulation.step(10.0).unwrap();
            assert!(!report.has_failed && report.bodies[0].residual <= 1e-8, "{report:?}");
        }
        positions(&simulation, body)
    });
    // Residuals of 1e-8 times the condition of the strip, some 1e4.
    let apart = mixed.iter().zip(&double).map(|(a, b)| a.distance(*b)).fold(0.0, f64::max);
    assert!(apart < 1e-4, "{apart:e}");
}

#[test]
#[cfg(feature = "direct")]
fn what_iterations_do_not_solve_takes_a_factor() {
    // Slivers, fibres ten thousand times as stiff as what is between them, and a step in which inertia holds nothing.
    let material = Material {
        young_fibre: 1e4,
        young_transverse: 1.0,
        poisson_major: 99.0,
        shear_modulus: Some(0.1),
        thickness: 1.0,
        density: 1e-3,
    };
    let linear = LinearParams::by_residual(1e-6, 2000);
    let (mut simulation, body) = strip(
        material,
        Settings { threads: 1, advanced: Advanced { linear, ..Advanced::default() }, ..Settings::default() },
        0.3,
    );
    for _ in 0..4 {
        simulation.step(100.0).unwrap();
        let own = &simulation.report().bodies[0];
        assert!(own.fault.is_none() && own.residual <= 1e-6, "{own:?}");
        // Of the 269 that are tried without it, and some with it, as often as the step is solved: 2000 at once before there was one.
        assert!(own.iterations < 400, "{own:?}");
    }
    assert!(positions(&simulation, body).iter().all(|x| x.is_finite()));
}
