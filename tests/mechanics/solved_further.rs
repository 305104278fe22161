//! Steps that would create energy are solved further from where they lead: fewer are undone, nothing is gained, and only the bodies that
//! need it are solved again.

use crate::noise::noises;
use glam::DVec3;
use rhexis::components::{Curve, Damping, EnergyAudit, Fibres, Gravity, Hold, Jaws, Material, Pose};
use rhexis::generate;
use rhexis::membrane::Membrane;
use rhexis::settings::{Advanced, Settings};
use rhexis::simulation::{Grasp, Simulation};
use rhexis::storage::{Attached, BodyId, Vertices};

/// A sheet at rest, and one that spins by a radian per step of 10 ms about an axis in its plane, each held by a corner and with its audit.
fn two_sheets(settings: Settings) -> (Simulation, [BodyId; 2]) {
    let mut simulation = Simulation::new(settings).unwrap();
    let bodies = ["at rest", "spinning"].map(|name| {
        let mesh = generate::grid(10.0, 10.0, 12, 12).unwrap();
        let sheet = Membrane::new(name, mesh, Material { thickness: 0.015, ..Material::allard_2009() });
        // One corner stays where it is, about which the sheet spins.
        let members = Attached::new([(0, DVec3::ZERO)]);
        let hold = Hold { name: "corner".into(), members, axes: [true; 3], curve: Curve::constant(0.0) };
        let sheet = sheet.fibres(Fibres::at_degrees(30.0)).hold(hold).with(EnergyAudit::default());
        simulation.spawn(sheet).unwrap()
    });
    let mut vertices = simulation.world().get::<&mut Vertices>(bodies[1].entity()).unwrap();
    let Vertices { position, velocity, .. } = &mut *vertices;
    let axis = DVec3::new(0.6, 0.8, 0.0);
    position.iter().zip(velocity).for_each(|(x, u)| *u = axis.cross(*x) * 0.1);
    drop(vertices);
    (simulation, bodies)
}

fn single(corrections: u32) -> Settings {
    Settings {
        threads: 1,
        advanced: Advanced { newton_corrections: corrections, ..Advanced::default() },
        ..Settings::default()
    }
}

/// Attempts undone and solved further in 20 steps.
fn undone_and_corrected(corrections: u32) -> [u32; 2] {
    let (mut simulation, [rest, spinning]) = two_sheets(single(corrections));
    let start = simulation.energies(spinning).unwrap();
    let start = start.elastic + start.kinetic;
    let mut counts = [0; 2];
    for step in 0..20 {
        let report = simulation.step(10.0).unwrap();
        let of = |body| report.bodies.iter().find(|report| report.body == body).unwrap().guard;
        assert_eq!(of(rest), Default::default(), "step {step}: the sheet at rest needs nothing");
        counts[0] += of(spinning).refusals();
        counts[1] += of(spinning).corrections();
        let now = simulation.energies(spinning).unwrap();
        // The guard lets a tenth through, and a tenth of what a strain of 1 % stores in all of it: ½·V·(E_F + E_T)·0.01²/0.991.
        let slack = 0.5 * 1.5 * 11.0 * 1e-4 / 0.991;
        let now = now.elastic + now.kinetic;
        assert!(now <= 1.11 * (start + slack), "step {step}: {now:e} mJ, {start:e} at first");
        let balance = simulation.energy_balance(spinning).unwrap().unwrap();
        // Quadrature along the ways of triangles that turn far.
        assert!(balance.relative_imbalance() < 1e-4, "step {step}: {balance:?}");
    }
    println!("{corrections} corrections: {counts:?}");
    counts
}

#[test]
fn fewer_steps_are_undone_and_nothing_is_gained() {
    let ([before, none], [after, corrected]) = (undone_and_corrected(0), undone_and_corrected(6));
    assert_eq!(none, 0);
    assert!(before > 0 && corrected > 0, "{before} undone without; {corrected} solved further");
    assert!(4 * after <= before, "{after} undone, {before} without corrections");
}

#[test]
fn other_bodies_keep_their_bits_and_threads_do_not_matter() {
    let run = |threads: usize| {
        let (mut simulation, _) = two_sheets(Settings { threads, ..single(6) });
        (0..6).for_each(|_| assert!(!simulation.step(10.0).unwrap().has_failed));
        simulation.hash()
    };
    let hashes = [1, 2, 4].map(run);
    assert!(hashes.iter().all(|hash| *hash == hashes[0]), "{hashes:?}");
    let rest = |corrections: u32| {
        let (mut simulation, [rest, _]) = two_sheets(single(corrections));
        (0..6).for_each(|_| assert!(!simulation.step(10.0).unwrap().has_failed));
        simulation.world().get::<&Vertices>(rest.entity()).unwrap().position.clone()
    };
    assert_eq!(rest(0), rest(6));
}

/// Steps undone while a hand jerks slack sheets, hung by two corners, to and fro: 480 steps.
fn undone_under_a_hand(corrections: u32) -> u32 {
    let mut undone = 0;
    for seed in 0..4 {
        let mesh = generate::grid(20.0, 20.0, 20, 20).unwrap();
        let sheet = Membrane::new("sheet", mesh, Material { thickness: 0.015, ..Material::allard_2009() });
        let sheet = sheet.fibres(Fibres::at_degrees(30.0)).with(Damping { time: 1.0 });
        let sheet = sheet.with(Gravity { acceleration: DVec3::new(0.0, -9.81e-3, 0.0) });
        let mut simulation = Simulation::new(single(corrections)).unwrap();
        let body = simulation.spawn(sheet).unwrap();
        let keys = simulation.view(body).unwrap().vertex_keys;
        let corners = [keys[20 * 21], keys[21 * 21 - 1]];
        simulation.pin(body, "corners", &corners).unwrap();
        let centre = DVec3::ZERO;
        let forceps =
            simulation.spawn_forceps("forceps", Jaws { radius: 1.5, ..Jaws::default() }, Pose::at(centre)).unwrap();
        simulation.close_forceps(forceps, body, &Grasp::Point(centre)).unwrap();
        for step in 0..120 {
            if step % 8 == 0 {
                let pose = Pose::at(centre + noises(step, seed) * 15.0);
                simulation.move_forceps(forceps, pose, 1000.0 / 60.0).unwrap();
            }
            let report = simulation.step(1000.0 / 60.0).unwrap();
            undone += report.bodies[0].guard.refusals();
        }
    }
    undone
}

#[test]
fn a_few_triangles_that_go_astray_do_not_hold_up_the_others() {
    let (before, after) = (undone_under_a_hand(0), undone_under_a_hand(10));
    println!("{before} undone, {after} with further solves");
    // 7 % of the steps that needed halves, 28 of 380; 5 % with an incomplete or a Cholesky factor in every solve, 21 of 404 and 18 of 401:
    // sheets that are flung part by the last digits of their solves.
    assert!(10 * after <= before, "{after} undone, {before} without further solves");
}
