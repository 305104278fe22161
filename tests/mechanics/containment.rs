//! No step creates energy: bodies that nothing holds or pushes keep what they have or lose it, however they are thrown, crumpled and
//! stepped, and however badly their linear systems are solved.

use crate::noise::noises;
use glam::DVec3;
use rhexis::components::{Bending, Curve, Fibres, Gravity, Hold, Material};
use rhexis::generate;
use rhexis::membrane::Membrane;
use rhexis::settings::{Accuracy, Advanced, Integrator, LinearParams, Settings, Tangent};
use rhexis::simulation::Simulation;
use rhexis::storage::{Attached, BodyId, Vertices};

/// A sheet of 10 mm as thin as a lens capsule, that nothing holds.
fn sheet(is_planar: bool, settings: Settings) -> (Simulation, BodyId) {
    spawned(settings, |sheet| if is_planar { sheet.planar() } else { sheet })
}

fn spawned(settings: Settings, kind: impl Fn(Membrane) -> Membrane) -> (Simulation, BodyId) {
    let mesh = generate::grid(10.0, 10.0, 10, 10).unwrap();
    let mut sheet = Membrane::new("sheet", mesh, Material { thickness: 0.015, ..Material::allard_2009() });
    sheet = kind(sheet.fibres(Fibres::at_degrees(30.0)));
    let mut simulation = Simulation::new(Settings { threads: 1, ..settings }).unwrap();
    let body = simulation.spawn(sheet).unwrap();
    (simulation, body)
}

/// The default step, solved to this residual.
fn solved_to(tolerance: f64) -> Settings {
    Settings {
        advanced: Advanced { linear: LinearParams::by_residual(tolerance, 2000), ..Advanced::default() },
        ..Settings::default()
    }
}

/// Steps of several iterations or of two stages.
fn nonlinear() -> [(&'static str, Settings); 4] {
    let newton = Settings {
        advanced: Advanced { newton_iterations: 4, tangent: Tangent::Projected, ..Advanced::default() },
        ..Settings::default()
    };
    let single = Settings {
        advanced: Advanced { integrator: Integrator::TrBdf2, ..Advanced::default() },
        ..Settings::default()
    };
    let exact =
        Settings { advanced: Advanced { tangent: Tangent::Exact, newton_iterations: 2, ..single.advanced }, ..single };
    [
        ("accurate", Settings::new(Accuracy::Accurate)),
        ("newton", newton),
        ("one solve per stage", single),
        ("exact", exact),
    ]
}

fn energy(simulation: &mut Simulation, body: BodyId) -> f64 {
    let energies = simulation.energies(body).unwrap();
    energies.elastic + energies.kinetic
}

fn change(simulation: &Simulation, body: BodyId, change: impl Fn(usize, &mut DVec3, &mut DVec3)) {
    let mut vertices = simulation.world().get::<&mut Vertices>(body.entity()).unwrap();
    let Vertices { position, velocity, .. } = &mut *vertices;
    position.iter_mut().zip(velocity).enumerate().for_each(|(v, (x, u))| change(v, x, u));
}

/// Throws every vertex up to `size` \[mm\] off.
fn crumple(simulation: &Simulation, body: BodyId, is_planar: bool, size: f64) {
    change(simulation, body, |v, x, _| {
        let by = noises(v, 0) * size;
        *x += if is_planar { by.with_z(0.0) } else { by };
    });
}

/// Steps on and asks that what is in the body never exceeds what was in it at first by more than the share that the engine
/// allows, a tenth, and a tenth of what a strain of 1 % stores in all of it. Returns how many steps were retried.
fn assert_contained(simulation: &mut Simulation, body: BodyId, dt: f64, what: &str) -> u32 {
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
            let (mut simulation, body) = sheet(is_planar, solved_to(1e-4));
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
                    let (mut simulation, body) = sheet(is_planar, solved_to(tolerance));
                    crumple(&simulation, body, is_planar, size);
                    let what = format!("planar {is_planar}, crumpled by {size} mm, {dt} ms, residual {tolerance}");
                    let retried = assert_contained(&mut simulation, body, dt, &what);
                    println!("{what}: {retried}");
                }
            }
        }
    }
}

#[test]
fn steps_of_several_solves_gain_nothing_either() {
    for (name, settings) in nonlinear() {
        let mut retried = 0;
        for (is_planar, axis) in [(true, DVec3::Z), (false, DVec3::X), (false, DVec3::new(0.6, 0.0, 0.8))] {
            for dt in [0.01, 0.1, 1.0, 10.0, 100.0] {
                let what = |motion: &str| format!("{name}, planar {is_planar}, {motion}, {dt} ms");
                let (mut simulation, body) = sheet(is_planar, settings);
                change(&simulation, body, |_, x, u| *u = axis.cross(*x - DVec3::new(5.0, 5.0, 0.0)) * 0.1);
                retried += assert_contained(&mut simulation, body, dt, &what(&format!("spinning about {axis}")));
                for size in [0.1, 3.0] {
                    let (mut simulation, body) = sheet(is_planar, settings);
                    crumple(&simulation, body, is_planar, size);
                    retried += assert_contained(&mut simulation, body, dt, &what(&format!("crumpled by {size} mm")));
                }
            }
        }
        println!("{name}: {retried}");
        // Else this shows nothing.
        assert!(retried > 0, "{name}");
    }
}

#[test]
fn work_that_is_done_on_a_body_is_not_taken_for_its_own() {
    for (name, settings) in nonlinear() {
        for (dt, steps) in [(0.02, 200), (1.0, 40), (20.0, 20)] {
            let (mut simulation, body) = drawn(settings, dt * f64::from(steps));
            let start = energy(&mut simulation, body);
            for i in 0..steps {
                let report = simulation.step(dt).unwrap();
                assert!(report.rolled_back == 0, "{name}, {dt} ms: step {i} retried");
            }
            let now = energy(&mut simulation, body);
            assert!(now > 3.0 * start, "{name}, {dt} ms: {now:e} mJ, {start:e} at first");
        }
    }
}

/// A taut sheet in a plane that is drawn out on, from a twentieth to a tenth within so many ms, and aside, in a field of gravity.
fn drawn(settings: Settings, over: f64) -> (Simulation, BodyId) {
    let mesh = generate::grid(10.0, 10.0, 10, 10).unwrap();
    let material = Material { thickness: 0.1, ..Material::allard_2009() };
    let mut sheet = Membrane::new("sheet", mesh, material).fibres(Fibres::at_degrees(30.0)).planar();
    for (name, x, way) in [("left", 0.0, DVec3::ZERO), ("right", 10.0, DVec3::new(1.0, 0.3, 0.0))] {
        let members = Attached::new(sheet.select(|p| p.x == x).into_iter().map(|vertex| (vertex, way)));
        let curve = Curve::new(vec![(0.0, 0.5), (over, 1.0)]).unwrap();
        sheet = sheet.hold(Hold { name: name.into(), members, axes: [true; 3], curve });
    }
    sheet = sheet.with(Gravity { acceleration: DVec3::Y * -9.8e-3 });
    let mut simulation = Simulation::new(Settings { threads: 1, ..settings }).unwrap();
    let body = simulation.spawn(sheet).unwrap();
    simulation.settle(0.0, 1e-10).unwrap();
    (simulation, body)
}

/// Crumpled and let go with this bending stiffness \[N·mm\]; returns how many steps were retried.
fn let_go(stiffness: f64) -> u32 {
    let mut retried = 0;
    for dt in [0.01, 0.1, 1.0, 10.0] {
        for size in [0.5, 3.0] {
            let bending = Bending { stiffness: Some(stiffness) };
            let (mut simulation, body) = spawned(solved_to(1e-4), |sheet| sheet.with(bending));
            change(&simulation, body, |v, x, _| {
                *x += noises(v, 0) * size;
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
