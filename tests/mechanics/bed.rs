//! Tissue that is stuck to a bed: bonds that stay off, edits. The force of peeling is a case of `rhexis verify bed`.

use glam::DVec3;
use rhexis::components::{Anchor, Bond, Curve, Damping, Fibres, Hold, Holds, Material, Springs};
use rhexis::generate;
use rhexis::membrane::Membrane;
use rhexis::settings::Settings;
use rhexis::simulation::Simulation;
use rhexis::storage::Attached;
use std::f64::consts::FRAC_PI_2;

/// Width, length and free arm of the strip \[mm\], its modulus \[MPa\] and thickness \[mm\].
const WIDTH: f64 = 0.5;
const LENGTH: f64 = 5.0;
const ARM: f64 = 1.0;
const YOUNG: f64 = 30.0;
const THICKNESS: f64 = 0.015;
/// Strength of its bonds \[MPa\].
const STRENGTH: f64 = 0.05;
/// Speed of the front \[mm/ms\].
const SPEED: f64 = 0.0004;
/// Time step \[ms\] in which the front goes on by a tenth of an edge.
const DT: f64 = 25.0;

/// A strip of this many cells per mm, whose arm stands at an angle \[rad\] to its bed and is drawn so that it keeps it.
fn strip(per_mm: usize, angle: f64, energy: f64) -> Membrane {
    let (nx, ny) = (5 * per_mm, (per_mm / 2).max(2));
    let along = DVec3::new(-angle.cos(), 0.0, angle.sin());
    let place = |s: f64, y: f64| {
        let foot = DVec3::new(s.max(ARM), y, 0.0);
        foot + along * (ARM - s).max(0.0)
    };
    let mesh = generate::mapped_grid(nx, ny, |u, v| place(u * LENGTH, v * WIDTH)).unwrap();
    let membrane = Membrane::new("strip", mesh, Material::isotropic(YOUNG, 0.0, THICKNESS));
    let column = |row: u32| row as usize % (nx + 1);
    let rows = 0..membrane.mesh().positions.len() as u32;
    let bond = Bond::new(STRENGTH, energy);
    let bonded = rows.clone().filter(|row| column(*row) >= per_mm);
    let anchor = |row: u32| {
        let point = membrane.mesh().positions[row as usize];
        (row, Anchor { point, stiffness: bond.usual_stiffness(), bond: Some(bond) })
    };
    let springs = Springs { anchors: Attached::new(bonded.map(anchor)) };
    let motion = DVec3::X + along;
    let members = Attached::new(rows.filter(|row| column(*row) == 0).map(|row| (row, motion)));
    let curve = Curve::ramp(1e4, 1e4 * SPEED).unwrap();
    let hand = Hold { name: "hand".into(), members, axes: [true; 3], curve };
    membrane.fibres(Fibres::at_degrees(0.0)).with(springs).with(Damping { time: 0.1 }).hold(hand)
}

#[test]
fn what_has_come_off_stays_off_and_the_same_bits_follow_a_snapshot() {
    let mut simulation = Simulation::new(Settings { threads: 1, ..Settings::default() }).unwrap();
    let body = simulation.spawn(strip(10, FRAC_PI_2, 0.003)).unwrap();
    let damage = |simulation: &Simulation| -> Vec<f64> {
        let world = simulation.world();
        let springs = world.get::<&Springs>(body.entity()).unwrap();
        springs.anchors.values().iter().map(|anchor| anchor.bond.unwrap().damage).collect()
    };
    for _ in 0..200 {
        simulation.step(DT).unwrap();
    }
    let opened = damage(&simulation);
    let count = |is_such: fn(f64) -> bool| opened.iter().filter(|damage| is_such(**damage)).count();
    assert!(count(|d| d == 1.0) > 0 && count(|d| d > 0.0 && d < 1.0) > 0 && count(|d| d == 0.0) > 0, "{opened:?}");
    let mut again = Simulation::from_snapshot(&simulation.snapshot()).unwrap();
    assert_eq!(damage(&again), opened);
    // Back to the start.
    let holds = |at: f64| Curve::new(vec![(0.0, 0.0), (5000.0, at), (10_000.0, 0.0)]).unwrap();
    for simulation in [&mut simulation, &mut again] {
        let mut held = (*simulation.world().get::<&Holds>(body.entity()).unwrap()).clone();
        held.groups[0].curve = holds(5000.0 * SPEED);
        simulation.set(body, held).unwrap();
        for _ in 0..200 {
            simulation.step(DT).unwrap();
        }
    }
    let closed = damage(&simulation);
    assert!(closed.iter().zip(&opened).all(|(after, before)| after >= before));
    assert_eq!(crate::common::state_bits(&simulation, body), crate::common::state_bits(&again, body));
    assert_eq!(damage(&again), closed);
}
