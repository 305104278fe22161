//! What must hold for every body and every run: rigid motion costs nothing, internal forces have no resultant, a step loses
//! energy but makes none, a spinning sheet keeps spinning.

use super::bodies::{self, Snapshot};
use super::{Artifacts, Row, Rows, VerifyError, largest};
use glam::{DMat3, DVec3};
use rhexis::components::{Curve, Fibres, Material};
use rhexis::generate;
use rhexis::membrane::Membrane;
use rhexis::settings::{Accuracy, Advanced, Settings, Tangent};
use rhexis::storage::Vertices;

pub(super) fn run(_: &Artifacts) -> Result<Vec<Row>, VerifyError> {
    let mut rows = Rows::new("motion");
    rigid(&mut rows)?;
    resultants(&mut rows)?;
    balance(&mut rows)?;
    momentum_of_steps(&mut rows)?;
    spin(&mut rows)?;
    rows.finish()
}

/// Side of the square \[mm\].
const SIDE: f64 = 30.0;
/// E_F·h·L of the square \[N\], the force that rounding is measured by.
const FORCE: f64 = 10.0 * 0.1 * SIDE;

fn square() -> Result<Membrane, VerifyError> {
    let mesh = generate::grid(SIDE, SIDE, 12, 10)?;
    Ok(Membrane::new("square", mesh, Material::allard_2009()).fibres(Fibres::at_degrees(45.0)))
}

fn default_step() -> Settings {
    Settings { threads: 1, ..Settings::default() }
}

fn rigid(rows: &mut Rows) -> Result<(), VerifyError> {
    let (mut simulation, body) = bodies::simulate(default_step(), square()?)?;
    let (mut forces, mut energies) = (Vec::new(), Vec::new());
    for i in 0..20 {
        let i = f64::from(i);
        let axis = DVec3::new((2.3 * i).cos(), (1.1 * i).sin(), (0.7 * i).cos()).normalize_or(DVec3::Z);
        let (turn, shift) = (DMat3::from_axis_angle(axis, 0.9 * i), DVec3::new(5.0, -3.0, 2.0));
        bodies::set_motion(&mut simulation, body, |_, x| (turn * x + shift, DVec3::ZERO))?;
        let snapshot = Snapshot::new(&mut simulation, body)?;
        forces.push(largest(snapshot.elastic_forces().iter().map(|f| f.length())));
        energies.push(simulation.energies(body)?.elastic);
    }
    // Rounding of positions, 4e-15 mm over edges of 2.5 mm, is a strain of 2e-15.
    rows.ratio("rigid motion in space: forces over E·h·L", largest(forces) / FORCE, 1e-13);
    rows.ratio("rigid motion in space: energy over E·h·L²", largest(energies) / (FORCE * SIDE), 1e-26);
    Ok(())
}

/// A smooth bump and a rough one: strains of 20 % and folds.
fn crumple(x: DVec3, i: usize) -> DVec3 {
    let i = i as f64;
    let bump = DVec3::new((0.3 * x.y).sin(), (0.2 * x.x).cos(), 2.0 * (0.25 * (x.x + x.y)).sin());
    bump + DVec3::new((12.9 * i).sin(), (78.2 * i).sin(), (37.7 * i).sin()) * 0.3
}

fn resultants(rows: &mut Rows) -> Result<(), VerifyError> {
    let (mut simulation, body) = bodies::simulate(default_step(), square()?)?;
    bodies::set_motion(&mut simulation, body, |i, x| (x + crumple(x, i), DVec3::ZERO))?;
    let snapshot = Snapshot::new(&mut simulation, body)?;
    let forces = snapshot.elastic_forces();
    let total: f64 = forces.iter().map(|f| f.length()).sum();
    let net: DVec3 = forces.iter().sum();
    let torque: DVec3 = snapshot.vertices.position.iter().zip(&forces).map(|(x, f)| x.cross(*f)).sum();
    // Rounding of 240 triangles' forces; the classical co-rotational force has a torque of 1e-1 here.
    rows.ratio("crumpled sheet: net force over the sum of forces", net.length() / total, 1e-14);
    rows.ratio("crumpled sheet: net torque over forces times the side", torque.length() / (total * SIDE), 1e-14);
    Ok(())
}

fn balance(rows: &mut Rows) -> Result<(), VerifyError> {
    for dt in [10.0, 1.0, 0.1] {
        let steps = 60;
        let ramp = Curve::ramp(0.5 * f64::from(steps) * dt, 1.0).unwrap_or_else(|_| Curve::constant(1.0));
        let membrane = square()?.planar();
        let side = |name: &str, at: f64, by: f64| {
            let offset = move |p: DVec3| (p.x == at).then_some(DVec3::X * by);
            bodies::hold_along(&membrane, name, [true; 3], ramp.clone(), offset)
        };
        let (left, right) = (side("left", 0.0, -1.5), side("right", SIDE, 1.5));
        let settings = Settings {
            advanced: Advanced { tangent: Tangent::Exact, ..bodies::exacting().advanced },
            ..bodies::exacting()
        };
        let (mut simulation, body) = bodies::simulate(settings, membrane.hold(left).hold(right))?;
        let (mut lost, mut work) = (Vec::new(), 0.0);
        let mut before = simulation.energies(body)?;
        for i in 0..steps {
            simulation.step(dt)?;
            let after = simulation.energies(body)?;
            let way = 1.5 * (ramp.at(f64::from(i + 1) * dt) - ramp.at(f64::from(i) * dt));
            let pull = bodies::reaction(&simulation, body, "right")? - bodies::reaction(&simulation, body, "left")?;
            work += pull.x * way;
            lost.push(pull.x * way - (after.elastic + after.kinetic - before.elastic - before.kinetic));
            before = after;
        }
        // Backward Euler dissipates wherever the energy is convex; rounding of the energies is 1e-16 of the work.
        let gained = lost.iter().map(|l| (-l / work).max(0.0));
        rows.ratio(format!("balance of 60 steps, dt {dt} ms: energy made, over the work"), largest(gained), 1e-12);
        rows.note(
            format!("balance of 60 steps, dt {dt} ms: energy lost, over the work"),
            lost.iter().sum::<f64>() / work,
            "1",
        );
    }
    Ok(())
}

/// Momentum \[g·mm/ms\] and angular momentum about the origin \[g·mm²/ms\].
fn momenta(vertices: &Vertices) -> (DVec3, DVec3) {
    let rows = vertices.position.iter().zip(&vertices.velocity).zip(&vertices.mass);
    rows.fold((DVec3::ZERO, DVec3::ZERO), |(p, l), ((x, v), m)| (p + *v * *m, l + x.cross(*v) * *m))
}

fn momentum_of_steps(rows: &mut Rows) -> Result<(), VerifyError> {
    let linear = rhexis::settings::LinearParams::by_residual(1e-12, 20_000);
    let (mut simulation, body) = bodies::simulate(
        Settings { advanced: Advanced { linear, ..default_step().advanced }, ..default_step() },
        square()?,
    )?;
    let drift = DVec3::new(0.1, -0.2, 0.3);
    bodies::set_motion(&mut simulation, body, |i, x| (x, drift + crumple(x, i) * 0.05))?;
    let (start, _) = momenta(&Snapshot::new(&mut simulation, body)?.vertices);
    for _ in 0..50 {
        simulation.step(0.5)?;
    }
    let (end, _) = momenta(&Snapshot::new(&mut simulation, body)?.vertices);
    // The residual of each linear solve, 1e-12 of the momentum put in, adds up over the steps.
    rows.ratio("free sheet, 50 default steps: momentum lost", (end - start).length() / start.length(), 1e-9);
    Ok(())
}

/// Fraction of its angular momentum that a free sheet keeps in 10 steps of 0.1 rad.
fn kept(settings: Settings, axis: DVec3, dt: f64) -> Result<f64, VerifyError> {
    let (mut simulation, body) = bodies::simulate(settings, square()?)?;
    let centre = DVec3::new(0.5 * SIDE, 0.5 * SIDE, 0.0);
    bodies::set_motion(&mut simulation, body, |_, x| (x - centre, (axis * (0.1 / dt)).cross(x - centre)))?;
    let (_, start) = momenta(&Snapshot::new(&mut simulation, body)?.vertices);
    for _ in 0..10 {
        simulation.step(dt)?;
    }
    let (_, end) = momenta(&Snapshot::new(&mut simulation, body)?.vertices);
    Ok(end.dot(start) / start.length_squared())
}

fn spin(rows: &mut Rows) -> Result<(), VerifyError> {
    for dt in [1.0, 10.0] {
        for (what, axis) in [("in its plane", DVec3::Z), ("about its middle line", DVec3::X)] {
            let default = kept(default_step(), axis, dt)?;
            let exact = kept(
                Settings {
                    advanced: Advanced { tangent: Tangent::Exact, ..default_step().advanced },
                    ..default_step()
                },
                axis,
                dt,
            )?;
            let converged = kept(
                Settings {
                    advanced: Advanced { tangent: Tangent::Exact, ..bodies::exacting().advanced },
                    ..bodies::exacting()
                },
                axis,
                dt,
            )?;
            if axis == DVec3::Z {
                // The rotated tangent exerts no torque in the plane; the exact one, solved once, turns the tension that one step's
                // tangential displacement brings into a brake, and so does the tension along the normal out of the plane.
                rows.ratio(
                    format!("sheet spinning {what}, dt {dt} ms: lost by the default step"),
                    (1.0 - default).abs(),
                    1e-3,
                );
            } else {
                rows.note(format!("sheet spinning {what}, dt {dt} ms: kept by the default step"), default, "1");
            }
            rows.note(format!("sheet spinning {what}, dt {dt} ms: kept by one exact solve"), exact, "1");
            rows.note(format!("sheet spinning {what}, dt {dt} ms: kept by the converged step"), converged, "1");
            let accurate = kept(Settings { threads: 1, ..Settings::new(Accuracy::Accurate) }, axis, dt)?;
            // Converged TR-BDF2 loses 0.002, backward Euler 0.083 however well it converges; in between is what two solves leave.
            rows.ratio(
                format!("sheet spinning {what}, dt {dt} ms: lost by the accurate step"),
                (1.0 - accurate).abs(),
                0.03,
            );
        }
    }
    Ok(())
}
