//! No step creates energy: bodies that nothing holds or pushes keep what they have or lose it, however they are thrown, crumpled and
//! stepped, and however badly their linear systems are solved.

use glam::DVec3;
use hecs::Entity;
use rhexis::components::{Bending, Fibres, Material};
use rhexis::membrane::Membrane;
use rhexis::scene::generate;
use rhexis::settings::{LinearParams, Settings};
use rhexis::simulation::Simulation;
use rhexis::storage::Vertices;

/// A sheet of 10 mm as thin as a lens capsule, that nothing holds.
fn sheet(is_planar: bool, tolerance: f64) -> (Simulation, Entity) {
    spawned(tolerance, |sheet| if is_planar { sheet.planar() } else { sheet })
}

fn spawned(tolerance: f64, kind: impl Fn(Membrane) -> Membrane) -> (Simulation, Entity) {
    let mesh = generate::grid(10.0, 10.0, 10, 10).unwrap();
    let mut sheet = Membrane::new("sheet", mesh, Material { thickness: 0.015, ..Material::figure_2() });
    sheet = kind(sheet.fibres(Fibres::at_degrees(30.0)));
    let linear = LinearParams::by_residual(tolerance, 2000);
    let mut simulation = Simulation::new(Settings { linear, threads: 1, ..Settings::default() }).unwrap();
    let body = simulation.spawn(sheet).unwrap();
    (simulation, body)
}

fn energy(simulation: &mut Simulation, body: Entity) -> f64 {
    let energies = simulation.energies(body).unwrap();
    energies.elastic + energies.kinetic
}

/// Uniform in −1 … 1 (splitmix64 of a counter).
fn noise(i: usize) -> f64 {
    let mut z = (i as u64).wrapping_mul(0x9E37_79B9_7F4A_7C15);
    z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
    ((z ^ (z >> 31)) >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
}

fn change(simulation: &Simulation, body: Entity, change: impl Fn(usize, &mut DVec3, &mut DVec3)) {
    let mut vertices = simulation.world().get::<&mut Vertices>(body).unwrap();
    let Vertices { position, velocity, .. } = &mut *vertices;
    position.iter_mut().zip(velocity).enumerate().for_each(|(v, (x, u))| change(v, x, u));
}

/// Steps on and asks that what is in the body never exceeds what was in it at first by more than the share that the engine
/// allows, a tenth, and a tenth of what a strain of 1 % stores in all of it. Returns how many steps were retried.
fn assert_contained(simulation: &mut Simulation, body: Entity, dt: f64, what: &str) -> u32 {
    let start = energy(simulation, body);
    // ½·V·(E_F + E_T)·0.01², over 1 − ν_F·ν_T = 0.991.
    let slack = 0.5 * 1.5 * 11.0 * 1e-4 / 0.99;
    let mut retried = 0;
    for i in 0..40 {
        let report = simulation.step(dt).unwrap();
        assert!(!report.has_failed, "{what}: step {i} failed");
        retried += report.rolled_back;
        let now = energy(simulation, body);
        assert!(now <= 1.11 * (start + slack), "{what}: {now:e} mJ after step {i}, {start:e} at first");
    }
    retried
}

#[test]
fn a_body_that_spins_gains_nothing() {
    let mut retried = 0;
    for (is_planar, axis) in
        [(true, DVec3::Z), (false, DVec3::Z), (false, DVec3::X), (false, DVec3::new(0.6, 0.0, 0.8))]
    {
        for dt in [0.1, 1.0, 10.0] {
            let (mut simulation, body) = sheet(is_planar, 1e-4);
            // 100 radians a second.
            change(&simulation, body, |_, x, u| *u = axis.cross(*x - DVec3::new(5.0, 5.0, 0.0)) * 0.1);
            retried += assert_contained(&mut simulation, body, dt, &format!("about {axis} at {dt} ms"));
        }
    }
    // A radian in a step is far too much for one solve along a tangent.
    assert!(retried > 0);
}

#[test]
fn a_crumpled_body_gains_nothing_however_badly_it_is_solved() {
    for is_planar in [true, false] {
        for tolerance in [1e-4, 0.5] {
            for dt in [0.01, 0.1, 1.0, 10.0, 100.0] {
                for size in [0.1, 0.5, 3.0] {
                    let (mut simulation, body) = sheet(is_planar, tolerance);
                    change(&simulation, body, |v, x, _| {
                        let by = DVec3::new(noise(3 * v), noise(3 * v + 1), noise(3 * v + 2)) * size;
                        *x += if is_planar { by.with_z(0.0) } else { by };
                    });
                    let what = format!("planar {is_planar}, crumpled by {size} mm, {dt} ms, residual {tolerance}");
                    let retried = assert_contained(&mut simulation, body, dt, &what);
                    println!("{what}: {retried}");
                }
            }
        }
    }
}

/// Crumpled and let go with this bending stiffness \[N·mm\]; returns how many steps were retried.
fn let_go(stiffness: f64) -> u32 {
    let mut retried = 0;
    for dt in [0.01, 0.1, 1.0, 10.0] {
        for size in [0.5, 3.0] {
            let bending = Bending { stiffness: Some(stiffness) };
            let (mut simulation, body) = spawned(1e-4, |sheet| sheet.with(bending));
            change(&simulation, body, |v, x, _| {
                *x += DVec3::new(noise(3 * v), noise(3 * v + 1), noise(3 * v + 2)) * size;
            });
            let what = format!("D = {stiffness} N·mm, crumpled by {size} mm, {dt} ms");
            retried += assert_contained(&mut simulation, body, dt, &what);
        }
    }
    retried
}

#[test]
fn a_crumpled_body_that_bends_gains_nothing() {
    // Folds that store a hundredth of what the crumpled sheet does, and as much.
    assert!(let_go(1e-3) + let_go(0.1) > 0);
}
