//! Viscoelastic tissue against the closed forms of a Prony series, and its history under edits, snapshots and undone steps.

use crate::common::Square;
use glam::{DQuat, DVec3};
use rhexis::components::{
    Branch, Curve, EdgeLoad, EdgeLoads, EnergyAudit, Fibres, Hold, Holds, Material, PreStretch, Reactions, Refinement,
    Relaxation, Sleeping, StiffeningFibres, TearLog,
};
use rhexis::generate;
use rhexis::math::Sym2;
use rhexis::membrane::Membrane;
use rhexis::settings::{Advanced, Integrator, Settings};
use rhexis::simulation::Simulation;
#[cfg(feature = "snapshot")]
use rhexis::snapshot::Snapshot;
use rhexis::storage::{BodyId, Triangles, Vertices};
use std::f64::consts::{PI, TAU};

/// Side of the square \[mm\], its instantaneous modulus \[MPa\] and thickness \[mm\].
const SIDE: f64 = 10.0;
const YOUNG: f64 = 2.0;
const THICKNESS: f64 = 0.1;
/// A body without inertia answers a load at its end: rounding of the settles.
const ROUNDING: f64 = 1e-7;
/// Demand on all closed forms.
const CLOSE: f64 = 0.01;

fn branches() -> Vec<Branch> {
    vec![Branch { part: 0.3, time: 20.0 }, Branch { part: 0.4, time: 300.0 }]
}

fn lasting(branches: &[Branch]) -> f64 {
    1.0 - branches.iter().map(|branch| branch.part).sum::<f64>()
}

/// Modulus over the instantaneous one, this long after a jump of strain.
fn modulus(branches: &[Branch], time: f64) -> f64 {
    lasting(branches) + branches.iter().map(|b| b.part * (-time / b.time).exp()).sum::<f64>()
}

/// A square that is free to contract, on rollers at its left side.
fn square(branches: Vec<Branch>) -> Membrane {
    let mesh = generate::grid(SIDE, SIDE, 4, 3).unwrap();
    let sheet = Membrane::new("square", mesh, Material::isotropic(YOUNG, 0.3, THICKNESS)).planar();
    let rollers = Hold::new("rollers", sheet.select(|p| p.x == 0.0)).along([true, false, false]);
    let corner = Hold::new("corner", sheet.select(|p| p.x == 0.0 && p.y == 0.0)).along([false, true, false]);
    sheet.hold(rollers).hold(corner).with(Relaxation { branches })
}

fn drawn(sheet: Membrane, strain: Curve) -> Membrane {
    let right = Hold::new("right", sheet.select(|p| p.x == SIDE)).moved(DVec3::X * SIDE, strain);
    sheet.hold(right.along([true, false, false]))
}

fn spawn(sheet: Membrane, settings: Settings) -> (Simulation, BodyId) {
    let mut simulation = Simulation::new(Settings { threads: 1, ..settings }).unwrap();
    let body = simulation.spawn(sheet).unwrap();
    (simulation, body)
}

/// Stress \[MPa\] by the force on the last hold.
fn stress(simulation: &Simulation, body: BodyId) -> f64 {
    simulation.reactions(body).unwrap().last().unwrap().1.x / (SIDE * THICKNESS)
}

fn settle(simulation: &mut Simulation, dt: f64) {
    simulation.settle(dt, 1e-10).unwrap();
}

#[test]
fn a_strain_that_is_held_relaxes_as_the_series_does() {
    for dt in [0.5, 7.0, 100.0] {
        let (mut simulation, body) = spawn(drawn(square(branches()), Curve::constant(0.05)), Settings::default());
        settle(&mut simulation, 0.0);
        assert!((stress(&simulation, body) / (YOUNG * 0.05) - 1.0).abs() < ROUNDING);
        while simulation.time() < 400.0 {
            settle(&mut simulation, dt);
            let wanted = 0.05 * YOUNG * modulus(&branches(), simulation.time());
            let found = stress(&simulation, body);
            assert!((found / wanted - 1.0).abs() < ROUNDING, "{dt}: {found} {wanted}");
        }
    }
}

#[test]
fn dynamic_steps_of_either_formula_relax_so_too() {
    for integrator in [Integrator::BackwardEuler, Integrator::TrBdf2] {
        for newton_iterations in [1, 4] {
            let advanced = Advanced { integrator, newton_iterations, ..Advanced::default() };
            let (mut simulation, body) = spawn(
                drawn(square(branches()), Curve::ramp(1.0, 0.05).unwrap()),
                Settings { advanced, position_tolerance: 1e-9, ..Settings::default() },
            );
            let mut guarded = 0;
            for _ in 0..400 {
                simulation.step(1.0).unwrap();
                guarded += simulation.report().rolled_back;
            }
            let wanted = 0.05 * YOUNG * modulus(&branches(), simulation.time() - 0.5);
            let found = stress(&simulation, body);
            assert!((found / wanted - 1.0).abs() < 1e-3, "{integrator:?} {newton_iterations}: {found} {wanted}");
            assert_eq!(guarded, 0, "{integrator:?} {newton_iterations}");
        }
    }
}

#[test]
fn long_steps_give_the_lasting_modulus_and_short_ones_the_instantaneous_one() {
    for (dt, wanted) in [(1e9, 0.3), (1e-6, 1.0)] {
        let (mut simulation, body) = spawn(drawn(square(branches()), Curve::constant(0.05)), Settings::default());
        settle(&mut simulation, dt);
        assert!((stress(&simulation, body) / (0.05 * YOUNG * wanted) - 1.0).abs() < 1e-6);
    }
}

/// Strain under a stress \[MPa\] on the right side.
fn creep(dt: f64, until: f64) -> f64 {
    let load = 0.02;
    let sheet = square(vec![Branch { part: 0.6, time: 50.0 }]);
    let mut side = sheet.select(|p| p.x == SIDE);
    side.sort_by(|&a, &b| sheet.mesh().positions[a as usize].y.total_cmp(&sheet.mesh().positions[b as usize].y));
    let edges = side.windows(2).map(|pair| [pair[0], pair[1]]).collect();
    let traction = DVec3::X * (load * THICKNESS);
    let edge = EdgeLoad { edges, traction, curve: Curve::constant(1.0) };
    let (mut simulation, body) = spawn(sheet.with(EdgeLoads { groups: vec![edge] }), Settings::default());
    settle(&mut simulation, 0.0);
    while simulation.time() < until {
        settle(&mut simulation, dt);
    }
    let vertices = simulation.world().get::<&Vertices>(body.entity()).unwrap();
    (vertices.position[side[0] as usize].x / SIDE - 1.0) * YOUNG / load
}

#[test]
fn a_standard_solid_creeps_with_its_own_time() {
    let wanted = |t: f64| (1.0 - 0.6 * (-t / (50.0 / 0.4)).exp()) / 0.4;
    assert!((creep(5.0, 0.0) - 1.0).abs() < ROUNDING);
    for until in [40.0, 200.0] {
        let off = [10.0, 5.0].map(|dt| (creep(dt, until) / wanted(until) - 1.0).abs());
        assert!(off[0] < CLOSE && off[1] < 0.3 * off[0], "{until}: {off:?}");
    }
}

#[test]
fn a_constant_rate_draws_each_branch_towards_its_viscosity() {
    let rate = 1e-4;
    for dt in [1.0, 25.0, 250.0] {
        let (mut simulation, body) =
            spawn(drawn(square(branches()), Curve::ramp(1e3, 0.1).unwrap()), Settings::default());
        while simulation.time() < 500.0 {
            settle(&mut simulation, dt);
            let t = simulation.time();
            let branch = |b: &Branch| b.part * b.time * rate * (1.0 - (-t / b.time).exp());
            let wanted = YOUNG * (0.3 * rate * t + branches().iter().map(branch).sum::<f64>());
            let found = stress(&simulation, body);
            assert!((found / wanted - 1.0).abs() < ROUNDING, "{dt}: {found} {wanted}");
        }
    }
}

#[test]
fn a_cycle_loses_what_the_loss_modulus_says() {
    let (branches, amplitude, period) = (branches(), 0.01, 200.0);
    let count = 100;
    let dt = period / f64::from(count);
    let points =
        (0..=12 * count).map(|i| (f64::from(i) * dt, amplitude * (TAU * f64::from(i) / f64::from(count)).sin()));
    let curve = Curve::new(points.collect()).unwrap();
    let (mut simulation, body) = spawn(drawn(square(branches.clone()), curve.clone()), Settings::default());
    let (mut lost, mut before, mut in_phase) = (0.0, 0.0, 0.0);
    for i in 1..=12 * count {
        settle(&mut simulation, dt);
        let now = stress(&simulation, body);
        if i > 11 * count {
            let time = f64::from(i) * dt;
            lost += 0.5 * (now + before) * (curve.at(time) - curve.at(time - dt));
            in_phase += 2.0 / f64::from(count) * now * (TAU * time / period).sin() / amplitude;
        }
        before = now;
    }
    let omega = TAU / period;
    let loss: f64 = branches.iter().map(|b| YOUNG * b.part * omega * b.time / (1.0 + (omega * b.time).powi(2))).sum();
    let square = |x: f64| x * x / (1.0 + x * x);
    let kept = YOUNG * (0.3 + branches.iter().map(|b| b.part * square(omega * b.time)).sum::<f64>());
    let wanted = PI * amplitude * amplitude * loss;
    assert!((lost / wanted - 1.0).abs() < CLOSE, "{lost} {wanted}");
    let phase = (lost / (PI * amplitude * amplitude)).atan2(in_phase);
    assert!((phase / loss.atan2(kept) - 1.0).abs() < CLOSE, "{phase}");
}

/// A sheet that is folded along its middle, with fibres askew, all of whose vertices are held out of their places.
fn folded() -> Membrane {
    let fold = 1.2_f64;
    let place = |u: f64, v: f64| {
        let (flat, up) = (u.min(0.5), (u - 0.5).max(0.0));
        DVec3::new(flat + up * fold.cos(), v, up * fold.sin()) * SIDE
    };
    let mesh = generate::mapped_grid(6, 5, place).unwrap();
    let material = Material { young_transverse: 0.1, ..Material::allard_2009() };
    let sheet = Membrane::new("folded", mesh, material).fibres(Fibres::at_degrees(35.0));
    let mut hold = Hold::new("all", sheet.select(|_| true));
    let at = sheet.mesh().positions.clone();
    hold.members.update(|row, _| {
        let p = at[row as usize];
        DVec3::new(0.05 * p.x + 0.02 * p.y, 0.03 * p.y - 0.01 * p.x, 0.04 * p.x)
    });
    sheet.hold(hold).with(Relaxation { branches: branches() })
}

fn forces(simulation: &Simulation, body: BodyId) -> Vec<DVec3> {
    simulation.world().get::<&Reactions>(body.entity()).unwrap().groups[0].clone()
}

#[test]
fn folded_tissue_with_fibres_relaxes_at_every_vertex() {
    let (mut simulation, body) = spawn(folded(), Settings::default());
    settle(&mut simulation, 0.0);
    let at_once = forces(&simulation, body);
    let largest = at_once.iter().map(|f| f.length()).fold(0.0, f64::max);
    for _ in 0..8 {
        settle(&mut simulation, 15.0);
        let part = modulus(&branches(), simulation.time());
        let off = forces(&simulation, body).into_iter().zip(&at_once).map(|(now, f)| (now - *f * part).length());
        assert!(off.fold(0.0, f64::max) < 1e-9 * largest);
    }
}

/// Three full turns of a strained body, 15° in each step.
#[test]
fn a_spin_keeps_the_history() {
    let (mut simulation, body) = spawn(folded(), Settings::default());
    settle(&mut simulation, 0.0);
    let at_once: Vec<f64> = forces(&simulation, body).into_iter().map(DVec3::length).collect();
    let largest = at_once.iter().copied().fold(0.0, f64::max);
    let turn = DQuat::from_axis_angle(DVec3::new(0.6, 0.0, 0.8), PI / 12.0);
    for _ in 0..72 {
        simulation.teleport(body, turn, DVec3::ZERO).unwrap();
        settle(&mut simulation, 2.0);
        let part = modulus(&branches(), simulation.time());
        let off = forces(&simulation, body).into_iter().zip(&at_once).map(|(now, f)| (now.length() - f * part).abs());
        assert!(off.fold(0.0, f64::max) < 1e-9 * largest);
    }
}

#[test]
fn a_pre_stretch_is_that_of_relaxed_tissue() {
    let strain = Sym2::new(0.04, 0.04, 0.0);
    let sheet = drawn(square(branches()), Curve::constant(0.0)).with(PreStretch { strain });
    let (mut simulation, body) = spawn(sheet, Settings::default());
    // The sides contract under the pre-stretch, and the branches see that.
    for _ in 0..60 {
        settle(&mut simulation, 100.0);
    }
    assert!((stress(&simulation, body) / (0.3 * YOUNG * 0.04) - 1.0).abs() < 1e-6);
    let pinned = folded();
    let all = Hold::new("all", pinned.select(|_| true));
    let mesh = pinned.mesh().clone();
    let sheet = Membrane::new("all", mesh, Material::allard_2009()).hold(all).with(PreStretch { strain });
    let (mut elastic, first) = spawn(sheet.clone(), Settings::default());
    let (mut relaxing, second) = spawn(sheet.with(Relaxation { branches: branches() }), Settings::default());
    settle(&mut elastic, 0.0);
    settle(&mut relaxing, 0.0);
    for (elastic, relaxing) in forces(&elastic, first).iter().zip(forces(&relaxing, second)) {
        assert!((relaxing - *elastic * 0.3).length() < 1e-12);
    }
}

/// Work of the holds over a ramp and a rest, and where it went.
#[test]
fn the_account_closes_with_the_dashpots_losses() {
    let (branches, strain, duration) = (branches(), 0.05, 100.0);
    let curve = Curve::new(vec![(0.0, 0.0), (duration, strain)]).unwrap();
    let sheet = drawn(square(branches.clone()), curve).with(EnergyAudit::default());
    let (mut simulation, body) = spawn(sheet, Settings::default());
    let dt = 0.5;
    while simulation.time() < 300.0 {
        settle(&mut simulation, dt);
    }
    let balance = simulation.energy_balance(body).unwrap().unwrap();
    assert!(balance.relative_imbalance() < 1e-9, "{balance:?}");
    let volume = SIDE * SIDE * THICKNESS * YOUNG;
    let rate = strain / duration;
    // Strain of a spring at the end of the ramp, then at the end.
    let spring = |b: &Branch, t: f64| {
        let grown = b.time * rate * (1.0 - (-t.min(duration) / b.time).exp());
        grown * (-(t - duration).max(0.0) / b.time).exp()
    };
    let stored = 0.3 * strain * strain + branches.iter().map(|b| b.part * spring(b, 300.0).powi(2)).sum::<f64>();
    let stored = 0.5 * volume * stored;
    let work = |b: &Branch| {
        let (tau, d) = (b.time, duration);
        b.part * tau * rate * rate * (d - tau * (1.0 - (-d / tau).exp()))
    };
    let work = volume * (0.5 * 0.3 * strain * strain + branches.iter().map(work).sum::<f64>());
    let found = simulation.energies(body).unwrap().elastic;
    assert!((found / stored - 1.0).abs() < CLOSE && (balance.stored.elastic / stored - 1.0).abs() < CLOSE);
    assert!((balance.relaxation / (work - stored) - 1.0).abs() < CLOSE, "{} {}", balance.relaxation, work - stored);
    assert!((balance.work_of_holds / work - 1.0).abs() < CLOSE);
}

/// A notched square that is refined around its tip and torn in dynamic steps.
fn torn(threads: usize, relaxation: Option<Relaxation>, is_audited: bool) -> (Simulation, BodyId) {
    let square = Square::new([16, 14], 60.0);
    let mut sheet = square.membrane().with(Refinement::default());
    if let Some(relaxation) = relaxation {
        sheet = sheet.with(relaxation);
    }
    if is_audited {
        sheet = sheet.with(EnergyAudit::default());
    }
    let mut simulation = Simulation::new(Settings { threads, ..Settings::default() }).unwrap();
    let body = simulation.spawn(sheet).unwrap();
    for notch in &square.notches {
        simulation.cut(body, notch).unwrap();
    }
    (simulation, body)
}

fn series() -> Option<Relaxation> {
    Some(Relaxation { branches: vec![Branch { part: 0.3, time: 40.0 }, Branch { part: 0.2, time: 400.0 }] })
}

#[test]
fn a_torn_and_refined_body_relaxes_and_its_account_closes() {
    let (mut simulation, body) = torn(1, series(), true);
    let before = simulation.world().get::<&Triangles>(body.entity()).unwrap().len();
    for _ in 0..90 {
        simulation.step(10.0).unwrap();
        assert!(!simulation.report().has_failed);
    }
    let advances = simulation.world().get::<&TearLog>(body.entity()).unwrap().advance_count;
    let after = simulation.world().get::<&Triangles>(body.entity()).unwrap().len();
    assert!(advances > 5 && after > before, "{advances} advances, {before} to {after} triangles");
    let balance = simulation.energy_balance(body).unwrap().unwrap();
    assert!(balance.relaxation > 0.0);
    assert!(balance.relative_imbalance() < 1e-3, "{} {balance:?}", balance.relative_imbalance());
}

#[test]
fn a_tear_of_relaxing_tissue_has_the_same_bits_for_any_number_of_threads() {
    let [one, three] = [1, 3].map(|threads| {
        let (mut simulation, _) = torn(threads, series(), false);
        for _ in 0..60 {
            simulation.step(10.0).unwrap();
        }
        simulation.hash()
    });
    assert_eq!(one, three);
}

#[cfg(feature = "snapshot")]
#[test]
fn a_snapshot_in_the_midst_goes_on_to_the_same_bits() {
    let (mut simulation, body) = torn(1, series(), true);
    for _ in 0..45 {
        simulation.step(10.0).unwrap();
    }
    let snapshot = simulation.snapshot();
    let bytes = snapshot.to_bytes().unwrap();
    let mut read = Simulation::from_snapshot(&Snapshot::from_bytes(&bytes).unwrap()).unwrap();
    assert_eq!((read.hash(), read.snapshot().to_bytes().unwrap()), (simulation.hash(), bytes));
    let mut hashes = Vec::new();
    for simulation in [&mut simulation, &mut read] {
        for _ in 0..25 {
            simulation.step(10.0).unwrap();
        }
        hashes.push((simulation.hash(), simulation.energy_balance(body).unwrap()));
    }
    simulation.restore(&snapshot).unwrap();
    for _ in 0..25 {
        simulation.step(10.0).unwrap();
    }
    hashes.push((simulation.hash(), simulation.energy_balance(body).unwrap()));
    assert!(hashes[0] == hashes[1] && hashes[0] == hashes[2], "{hashes:?}");
}

#[test]
fn a_body_without_branches_is_elastic_to_the_bit() {
    let [elastic, relaxing] = [None, Some(Relaxation::default())].map(|relaxation| {
        let (mut simulation, body) = torn(1, relaxation, false);
        for _ in 0..30 {
            simulation.step(10.0).unwrap();
        }
        simulation.world().get::<&Vertices>(body.entity()).unwrap().position.clone()
    });
    let largest = elastic.iter().zip(&relaxing).map(|(a, b)| a.distance(*b)).fold(0.0, f64::max);
    assert!(elastic.len() == relaxing.len() && largest < 1e-9, "{largest}");
}

/// Stored energy \[mJ\], which is that of the branches' springs.
fn stored_in(simulation: &Simulation, body: BodyId) -> f64 {
    simulation.energies(body).unwrap().elastic
}

#[test]
fn an_undone_solve_leaves_the_history_as_it_was() {
    let (mut simulation, body) = spawn(drawn(square(branches()), Curve::constant(0.05)), Settings::default());
    settle(&mut simulation, 0.0);
    settle(&mut simulation, 10.0);
    let before = stored_in(&simulation, body);
    let kept = (*simulation.world().get::<&Holds>(body.entity()).unwrap()).clone();
    let mut holds = kept.clone();
    // Sheared by more than two iterations can follow.
    holds.groups[2].axes = [true, true, false];
    holds.groups[2].members.update(|_, to| to + DVec3::Y * (40.0 * SIDE));
    simulation.set(body, holds).unwrap();
    let advanced = Advanced { static_iterations: 2, ..Advanced::default() };
    simulation.set_settings(Settings { threads: 1, advanced, ..Settings::default() }).unwrap();
    assert!(simulation.settle(50.0, 1e-10).is_err());
    simulation.set_settings(Settings { threads: 1, ..Settings::default() }).unwrap();
    simulation.set(body, kept).unwrap();
    assert_eq!((simulation.time(), stored_in(&simulation, body)), (10.0, before));
    settle(&mut simulation, 10.0);
    let wanted = 0.05 * YOUNG * modulus(&branches(), 20.0);
    assert!((stress(&simulation, body) / wanted - 1.0).abs() < ROUNDING);
}

#[test]
fn a_body_that_relaxes_stays_awake() {
    let sheet = drawn(square(vec![Branch { part: 0.5, time: 300.0 }]), Curve::constant(0.05));
    let sleeping = Sleeping { strain: 1e-4, steps: 3, ..Sleeping::default() };
    let (mut simulation, body) = spawn(sheet.with(sleeping), Settings::default());
    simulation.settle(0.0, 1e-10).unwrap();
    let is_asleep = |s: &Simulation| s.world().get::<&Sleeping>(body.entity()).unwrap().is_asleep();
    while !is_asleep(&simulation) {
        assert!(simulation.time() < 6000.0, "it never sleeps");
        simulation.step(5.0).unwrap();
    }
    let left = 0.5 * 0.05 * (-simulation.time() / 300.0).exp();
    assert!(left < 1e-4 * 1.1, "it fell asleep with a strain of {left} to relax");
    assert!((stress(&simulation, body) / (0.5 * 0.05 * YOUNG) - 1.0).abs() < CLOSE);
}

#[test]
fn series_that_are_none_are_refused_by_name() {
    let refused = |branches: Vec<Branch>| square(branches).validate().unwrap_err().to_string();
    let branch = |part: f64, time: f64| Branch { part, time };
    assert!(refused(vec![branch(0.0, 1.0)]).contains("part of branch 1"));
    assert!(refused(vec![branch(0.1, 1.0), branch(f64::NAN, 1.0)]).contains("part of branch 2"));
    assert!(refused(vec![branch(0.1, 1.0), branch(0.1, -1.0)]).contains("time of branch 2"));
    assert!(refused(vec![branch(0.1, f64::INFINITY)]).contains("time of branch 1"));
    assert!(refused(vec![branch(0.6, 1.0), branch(0.4, 2.0)]).contains("sum of the parts is 1.0"));
    assert!(refused(vec![branch(0.1, 1.0); 5]).contains("more than four branches"));
    let fibres = square(branches()).with(StiffeningFibres { k1: 1.0, k2: 2.0 });
    assert!(fibres.validate().unwrap_err().to_string().contains("linear law"));
}
