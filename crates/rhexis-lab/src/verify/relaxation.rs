//! Viscoelastic tissue: a sheet with a Prony series against the closed forms of generalised Maxwell solids.

use super::bodies;
use super::{Artifacts, Row, Rows, VerifyError, largest};
use glam::{DQuat, DVec3};
use rhexis::components::{Branch, Curve, EdgeLoad, EdgeLoads, Fibres, Hold, Material, Reactions, Relaxation};
use rhexis::generate;
use rhexis::membrane::Membrane;
use rhexis::settings::{Advanced, Integrator, Settings};
use rhexis::simulation::Simulation;
use rhexis::storage::{BodyId, Vertices};
use std::f64::consts::{PI, TAU};

/// Side \[mm\], instantaneous modulus \[MPa\] and thickness \[mm\] of the sheet.
const SIDE: f64 = 10.0;
const YOUNG: f64 = 2.0;
const THICKNESS: f64 = 0.1;

/// Imbalance at which settles stop.
const TOLERANCE: f64 = 1e-10;

/// Demand on the closed forms.
const CLOSE: f64 = 0.01;

/// Demand where the steps are exact at any length: the tolerance of the settles.
const EXACT: f64 = 1e-6;

const SERIES: [Branch; 2] = [Branch { part: 0.3, time: 20.0 }, Branch { part: 0.4, time: 300.0 }];

/// Modulus over the instantaneous one, this long after a jump of strain.
fn modulus(time: f64) -> f64 {
    Relaxation { branches: SERIES.to_vec() }.lasting() + sum(|branch| (-time / branch.time).exp())
}

/// Sum over the branches, by their parts.
fn sum(of: impl Fn(&Branch) -> f64) -> f64 {
    SERIES.iter().map(|branch| branch.part * of(branch)).sum()
}

/// A sheet on rollers at its left side, free to contract.
fn sheet(branches: &[Branch]) -> Result<Membrane, VerifyError> {
    let mesh = generate::grid(SIDE, SIDE, 5, 4)?;
    let sheet = Membrane::new("sheet", mesh, Material::isotropic(YOUNG, 0.3, THICKNESS)).planar();
    let rollers = Hold::new("rollers", sheet.select(|p| p.x == 0.0)).along([true, false, false]);
    let corner = Hold::new("corner", sheet.select(|p| p == DVec3::ZERO)).along([false, true, false]);
    Ok(sheet.hold(rollers).hold(corner).with(Relaxation { branches: branches.to_vec() }))
}

/// The sheet with its right side drawn out to a strain over time.
fn drawn(strain: Curve, settings: Settings) -> Result<(Simulation, BodyId), VerifyError> {
    let sheet = sheet(&SERIES)?;
    let right = Hold::new("right", sheet.select(|p| p.x == SIDE)).moved(DVec3::X * SIDE, strain);
    bodies::simulate(settings, sheet.hold(right.along([true, false, false])))
}

fn bare() -> Settings {
    Settings { threads: 1, ..Settings::default() }
}

/// Stress \[MPa\] by the force on the last hold.
fn stress(simulation: &Simulation, body: BodyId) -> Result<f64, VerifyError> {
    let reactions = simulation.reactions(body)?;
    Ok(reactions.last().map_or(f64::NAN, |(_, force)| force.x / (SIDE * THICKNESS)))
}

pub(super) fn held(_: &Artifacts) -> Result<Vec<Row>, VerifyError> {
    let mut rows = Rows::new("time-relaxation");
    let strain = 0.05;
    for dt in [0.5, 10.0, 100.0] {
        let (mut simulation, body) = drawn(Curve::constant(strain), bare())?;
        simulation.settle(0.0, TOLERANCE)?;
        let mut off = vec![(stress(&simulation, body)? / (strain * YOUNG) - 1.0).abs()];
        while simulation.time() < 600.0 {
            simulation.settle(dt, TOLERANCE)?;
            off.push((stress(&simulation, body)? / (strain * YOUNG * modulus(simulation.time())) - 1.0).abs());
        }
        rows.ratio(format!("equilibria, dt {dt} ms: stress over 600 ms"), largest(off), EXACT);
    }
    for (name, integrator) in [("backward Euler", Integrator::BackwardEuler), ("TR-BDF2", Integrator::TrBdf2)] {
        for dt in [0.5, 2.0, 10.0] {
            let settings = Settings { advanced: Advanced { integrator, ..Advanced::default() }, ..bare() };
            let (mut simulation, body) = drawn(Curve::ramp(10.0, strain)?, settings)?;
            while simulation.time() < 400.0 {
                simulation.step(dt)?;
            }
            // After a ramp of 10 ms.
            let ramped = |b: &Branch| (10.0 / b.time).exp_m1() * b.time / 10.0 * (-simulation.time() / b.time).exp();
            let wanted = strain * YOUNG * (modulus(f64::INFINITY) + sum(ramped));
            rows.relative(format!("{name}, dt {dt} ms: stress at 400 ms"), stress(&simulation, body)?, wanted, CLOSE);
        }
    }
    for dt in [5.0, 60.0] {
        let (mut simulation, body) = bodies::simulate(bare(), folded()?)?;
        simulation.settle(0.0, TOLERANCE)?;
        let at_once = forces(&simulation, body);
        let most = largest(at_once.iter().map(|force| force.length()));
        let mut off = Vec::new();
        while simulation.time() < 300.0 {
            simulation.settle(dt, TOLERANCE)?;
            let part = modulus(simulation.time());
            let now = forces(&simulation, body);
            off.extend(now.iter().zip(&at_once).map(|(now, before)| (*now - *before * part).length() / most));
        }
        rows.ratio(format!("folded, with fibres, dt {dt} ms: force at every vertex"), largest(off), EXACT);
    }
    rows.finish()
}

/// A folded sheet with fibres askew, all of whose vertices are held out of their places.
fn folded() -> Result<Membrane, VerifyError> {
    let fold = 1.2_f64;
    let place = |u: f64, v: f64| {
        let (flat, up) = (u.min(0.5), (u - 0.5).max(0.0));
        DVec3::new(flat + up * fold.cos(), v, up * fold.sin()) * SIDE
    };
    let sheet = Membrane::new("folded", generate::mapped_grid(6, 5, place)?, Material::allard_2009());
    let sheet = sheet.fibres(Fibres::at_degrees(35.0)).with(Relaxation { branches: SERIES.to_vec() });
    let mut all = Hold::new("all", sheet.select(|_| true));
    let at = sheet.mesh().positions.clone();
    all.members.update(|row, _| {
        let p = at[row as usize];
        DVec3::new(0.05 * p.x + 0.02 * p.y, 0.03 * p.y - 0.01 * p.x, 0.04 * p.x)
    });
    Ok(sheet.hold(all))
}

fn forces(simulation: &Simulation, body: BodyId) -> Vec<DVec3> {
    let found = simulation.world().get::<&Reactions>(body.entity());
    found.map_or(Vec::new(), |reactions| reactions.groups.iter().flatten().copied().collect())
}

pub(super) fn limits(_: &Artifacts) -> Result<Vec<Row>, VerifyError> {
    let mut rows = Rows::new("time-limits");
    let strain = 0.05;
    for (dt, part) in [(1e-6, 1.0), (1e-3, 1.0), (1e6, 0.3), (1e9, 0.3)] {
        let (mut simulation, body) = drawn(Curve::constant(strain), bare())?;
        simulation.settle(dt, TOLERANCE)?;
        let wanted = strain * YOUNG * part;
        rows.relative(format!("one step of {dt:e} ms after a jump: stress"), stress(&simulation, body)?, wanted, CLOSE);
    }
    rows.finish()
}

pub(super) fn creep(_: &Artifacts) -> Result<Vec<Row>, VerifyError> {
    let mut rows = Rows::new("time-creep");
    let (solid, load) = (Branch { part: 0.6, time: 50.0 }, 0.02);
    let lasting = 1.0 - solid.part;
    for dt in [2.0, 5.0, 10.0] {
        let sheet = sheet(&[solid])?;
        let mut side = sheet.select(|p| p.x == SIDE);
        let at = &sheet.mesh().positions;
        side.sort_by(|&a, &b| at[a as usize].y.total_cmp(&at[b as usize].y));
        let edges = side.windows(2).map(|pair| [pair[0], pair[1]]).collect();
        let traction = DVec3::X * (load * THICKNESS);
        let groups = vec![EdgeLoad { edges, traction, curve: Curve::constant(1.0) }];
        let (mut simulation, body) = bodies::simulate(bare(), sheet.with(EdgeLoads { groups }))?;
        let drawn = |simulation: &Simulation| {
            let vertices = simulation.world().get::<&Vertices>(body.entity());
            let right = side.first().copied().unwrap_or_default() as usize;
            vertices.map_or(f64::NAN, |vertices| vertices.position[right].x / SIDE - 1.0)
        };
        simulation.settle(0.0, TOLERANCE)?;
        let mut off = vec![(drawn(&simulation) * YOUNG / load - 1.0).abs()];
        while simulation.time() < 400.0 {
            simulation.settle(dt, TOLERANCE)?;
            let fallen = solid.part * (-simulation.time() * lasting / solid.time).exp();
            off.push((drawn(&simulation) * YOUNG / load / ((1.0 - fallen) / lasting) - 1.0).abs());
        }
        rows.ratio(format!("dt {dt} ms: strain over 400 ms"), largest(off), CLOSE);
    }
    rows.finish()
}

pub(super) fn rate(_: &Artifacts) -> Result<Vec<Row>, VerifyError> {
    let mut rows = Rows::new("time-rate");
    let rate = 1e-4;
    for dt in [1.0, 25.0, 250.0] {
        let (mut simulation, body) = drawn(Curve::ramp(1000.0, 1000.0 * rate)?, bare())?;
        let mut off = Vec::new();
        while simulation.time() < 500.0 {
            simulation.settle(dt, TOLERANCE)?;
            let t = simulation.time();
            let branches = sum(|b| b.time * rate * (1.0 - (-t / b.time).exp()));
            let wanted = YOUNG * (modulus(f64::INFINITY) * rate * t + branches);
            off.push((stress(&simulation, body)? / wanted - 1.0).abs());
        }
        rows.ratio(format!("dt {dt} ms: stress over 500 ms"), largest(off), EXACT);
    }
    rows.finish()
}

pub(super) fn cycle(_: &Artifacts) -> Result<Vec<Row>, VerifyError> {
    let mut rows = Rows::new("time-cycle");
    let amplitude = 0.01;
    for (period, steps) in [(50.0, 100_u32), (200.0, 60), (200.0, 100), (2000.0, 100)] {
        let (dt, omega) = (period / f64::from(steps), TAU / period);
        // So long that the transients have died away.
        let cycles = (3000.0 / period).ceil().max(3.0) as u32;
        let at = |i: u32| (f64::from(i) * dt, amplitude * (TAU * f64::from(i) / f64::from(steps)).sin());
        let strain = Curve::new((0..=cycles * steps).map(at).collect())?;
        let (mut simulation, body) = drawn(strain, bare())?;
        let (mut lost, mut in_phase, mut before) = (0.0, 0.0, 0.0);
        for i in 1..=cycles * steps {
            simulation.settle(dt, TOLERANCE)?;
            let now = stress(&simulation, body)?;
            if i > (cycles - 1) * steps {
                lost += 0.5 * (now + before) * (at(i).1 - at(i - 1).1);
                in_phase += 2.0 / f64::from(steps) * now * at(i).1 / (amplitude * amplitude);
            }
            before = now;
        }
        let damped = |b: &Branch| omega * b.time / (1.0 + (omega * b.time).powi(2));
        let loss = YOUNG * sum(damped);
        let storage = YOUNG * (modulus(f64::INFINITY) + sum(|b| omega * b.time * damped(b)));
        let area = PI * amplitude * amplitude;
        let on = format!("period {period} ms in {steps} steps");
        rows.relative(format!("{on}: loss per cycle"), lost, area * loss, CLOSE);
        rows.relative(format!("{on}: phase"), (lost / area).atan2(in_phase), loss.atan2(storage), CLOSE);
    }
    rows.finish()
}

pub(super) fn spin(_: &Artifacts) -> Result<Vec<Row>, VerifyError> {
    let mut rows = Rows::new("time-spin");
    for (degrees, dt) in [(5.0_f64, 1.0), (40.0, 10.0)] {
        let (mut simulation, body) = bodies::simulate(bare(), folded()?)?;
        simulation.settle(0.0, TOLERANCE)?;
        let at_once: Vec<f64> = forces(&simulation, body).into_iter().map(DVec3::length).collect();
        let most = largest(at_once.iter().copied());
        let turn = DQuat::from_axis_angle(DVec3::new(0.6, 0.0, 0.8), degrees.to_radians());
        let mut off = Vec::new();
        for _ in 0..72 {
            simulation.teleport(body, turn, DVec3::ZERO)?;
            simulation.settle(dt, TOLERANCE)?;
            let part = modulus(simulation.time());
            let now = forces(&simulation, body);
            off.extend(now.iter().zip(&at_once).map(|(now, before)| (now.length() - before * part).abs() / most));
        }
        rows.ratio(format!("{degrees}° in each step of {dt} ms: force at every vertex"), largest(off), EXACT);
    }
    rows.finish()
}
