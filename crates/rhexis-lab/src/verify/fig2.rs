//! The square of Figure 2 under a pull of 10 %: static equilibrium, and the ramp with backward Euler.

use super::bodies::{self, Snapshot};
use super::reference::{Json, csv, file};
use super::{Artifacts, Row, Rows, VerifyError, largest};
use glam::DVec3;
use rhexis::components::{Curve, Fibres, Holds, Material};
use rhexis::generate;
use rhexis::membrane::Membrane;
use rhexis::settings::{Advanced, Settings, Tangent};
use rhexis::simulation::{Simulation, SimulationError};
use rhexis::storage::BodyId;

/// Displacement of either edge \[mm\].
const PULL: f64 = 1.5;

fn square(nx: usize, ny: usize, material: Material, ramp: Curve) -> Result<Membrane, VerifyError> {
    let mesh = generate::grid(30.0, 30.0, nx, ny)?;
    let membrane = Membrane::new("square", mesh, material).fibres(Fibres::at_degrees(45.0)).planar();
    let side = |name: &str, at: f64, to: f64| {
        let offset = move |p: DVec3| (p.x == at).then_some(DVec3::X * to);
        bodies::hold_along(&membrane, name, [true; 3], ramp.clone(), offset)
    };
    let (left, right) = (side("left", 0.0, -PULL), side("right", 30.0, PULL));
    Ok(membrane.hold(left).hold(right))
}

/// From zero to one within the duration \[ms\].
fn ramp(duration: f64) -> Curve {
    Curve::ramp(duration, 1.0).unwrap_or_else(|_| Curve::constant(1.0))
}

pub(super) fn large(_: &Artifacts) -> Result<Vec<Row>, VerifyError> {
    let mut rows = Rows::new("fig2-large");
    let (name, text) = file!("fig2_large.json");
    let file = Json::new(name, text)?;
    let aniso = Material::allard_2009();
    let iso = Material::isotropic(3.0, 0.3, 0.1);
    let cases = [
        ("M(30,25)", (30, 25), aniso, "/results/1", file!("fig2_large_gradient_30x25.csv")),
        ("M(60,50)", (60, 50), aniso, "/results/4", file!("fig2_large_gradient_60x50.csv")),
        ("isotropic M(30,25)", (30, 25), iso, "/isotropic/gradient_30x25", file!("fig2iso_large_gradient_30x25.csv")),
    ];
    for (what, (nx, ny), material, at, (name, text)) in cases {
        let settings = Settings { threads: 1, ..Settings::default() };
        let (mut simulation, body) = bodies::simulate(settings, square(nx, ny, material, ramp(1.0))?)?;
        // 1e-12 of the largest corner force of about 0.1 N.
        simulation.settle(1.0, 1e-12)?;
        let reference: Vec<[f64; 2]> = csv(name, text)?;
        let found = bodies::positions(&simulation, body)?;
        let off = found.iter().zip(&reference).map(|(x, r)| (x.x - r[0]).hypot(x.y - r[1]));
        // The file has 1e-12 mm; an imbalance of 1e-13 N moves a vertex by as little as 1e-11 mm.
        rows.add(format!("{what}: positions"), largest(off), 1e-7, "mm");
        let energy = simulation.energies(body)?.elastic;
        rows.relative(format!("{what}: energy"), energy, file.number(&format!("{at}/energy_mJ"))?, 1e-8);
        let (fx, fy) = (file.number(&format!("{at}/F_right_N/0"))?, file.number(&format!("{at}/F_right_N/1"))?);
        let right = bodies::reaction(&simulation, body, "right")?;
        // Equilibrium is reached to 1e-13 N at each vertex.
        rows.ratio(format!("{what}: grip force"), (right.x - fx).hypot(right.y - fy) / fx, 1e-7);
        let left = bodies::reaction(&simulation, body, "left")?;
        rows.ratio(format!("{what}: grips in balance"), (left + right).length() / fx, 1e-9);
    }
    work(&mut rows)?;
    rows.finish()
}

/// The slope of the energy over the pull is the grips' force.
fn work(rows: &mut Rows) -> Result<(), VerifyError> {
    let settings = Settings { threads: 1, ..Settings::default() };
    let curve = Curve::constant(1.0);
    let (mut simulation, body) = bodies::simulate(settings, square(30, 25, Material::allard_2009(), curve)?)?;
    let step = 1e-3;
    let mut energies = [0.0; 2];
    let mut at = |factor: f64| -> Result<(f64, f64), VerifyError> {
        let holds = simulation.world_mut().query_one_mut::<&mut Holds>(body.entity());
        for hold in &mut holds.map_err(|_| SimulationError::NoSuchBody)?.groups {
            hold.curve = Curve::constant(factor);
        }
        simulation.settle(1.0, 1e-11)?;
        let force = bodies::reaction(&simulation, body, "right")? - bodies::reaction(&simulation, body, "left")?;
        Ok((simulation.energies(body)?.elastic, force.x * PULL))
    };
    for (energy, factor) in energies.iter_mut().zip([1.0 - step, 1.0 + step]) {
        *energy = at(factor)?.0;
    }
    let (_, power) = at(1.0)?;
    let slope = (energies[1] - energies[0]) / (2.0 * step);
    // Central differences with a step of 1e-3 of the pull: 1e-6 times the third derivative over the first, which is small for
    // a nearly quadratic energy. The classical co-rotational force misses by 2.5e-2.
    rows.relative("work of the grips is the change of energy", power, slope, 1e-7);
    Ok(())
}

pub(super) fn dynamic(_: &Artifacts) -> Result<Vec<Row>, VerifyError> {
    let mut rows = Rows::new("fig2-dynamic");
    for (dt, (name, text)) in
        [(10.0, file!("fig2_dynamic_gradient_dt10.csv")), (0.5, file!("fig2_dynamic_gradient_dt0.5.csv"))]
    {
        let reference: Vec<[f64; 9]> = csv(name, text)?;
        let converged = Settings {
            advanced: Advanced { newton_iterations: 20, tangent: Tangent::Exact, ..bodies::exacting().advanced },
            ..bodies::exacting()
        };
        let off = Deviation::of_run(dt, converged, &reference)?;
        // Every step is solved to 1e-11 of the largest corner force; the file has 12 digits.
        rows.add(format!("dt {dt} ms, converged: middle vertex"), off.position, 1e-6, "mm");
        rows.ratio(format!("dt {dt} ms, converged: elastic energy over its last value"), off.elastic, 1e-8);
        rows.ratio(format!("dt {dt} ms, converged: kinetic energy over its largest value"), off.kinetic, 1e-8);
        rows.ratio(format!("dt {dt} ms, converged: grip force over its last value"), off.force, 1e-8);
        let off = Deviation::of_run(dt, Settings { threads: 1, ..Settings::default() }, &reference)?;
        rows.note(format!("dt {dt} ms, default step: middle vertex"), off.position, "mm");
        rows.note(format!("dt {dt} ms, default step: elastic energy over its last value"), off.elastic, "1");
        rows.note(format!("dt {dt} ms, default step: grip force over its last value"), off.force, "1");
        rows.note(format!("dt {dt} ms, default step: middle vertex at the end"), off.final_position, "mm");
    }
    rows.finish()
}

/// Largest deviations of a run from the listed one.
#[derive(Default)]
struct Deviation {
    position: f64,
    final_position: f64,
    elastic: f64,
    kinetic: f64,
    force: f64,
}

impl Deviation {
    fn of_run(dt: f64, settings: Settings, reference: &[[f64; 9]]) -> Result<Self, VerifyError> {
        let (mut simulation, body) =
            bodies::simulate(settings, square(30, 25, Material::allard_2009(), ramp(50.0 * dt))?)?;
        let scale = |column: usize| reference.iter().map(|row| row[column].abs()).fold(0.0, f64::max);
        let (elastic, kinetic, force) = (scale(3), scale(4), scale(5));
        let mut worst = Self::default();
        for row in reference {
            simulation.step(dt)?;
            let middle = bodies::positions(&simulation, body)?[12 * 31 + 15];
            let pull = internal_force(&mut simulation, body)?;
            let energies = simulation.energies(body)?;
            worst.final_position = (middle.x - row[7]).hypot(middle.y - row[8]);
            worst.position = largest([worst.position, worst.final_position]);
            worst.elastic = largest([worst.elastic, (energies.elastic - row[3]).abs() / elastic]);
            worst.kinetic = largest([worst.kinetic, (energies.kinetic - row[4]).abs() / kinetic]);
            worst.force = largest([worst.force, (pull.x - row[5]).hypot(pull.y - row[6]) / force]);
        }
        Ok(worst)
    }
}

/// Elastic force on the right edge, without the inertia of its vertices, as the file lists it \[N\].
fn internal_force(simulation: &mut Simulation, body: BodyId) -> Result<DVec3, VerifyError> {
    let body = Snapshot::new(simulation, body)?;
    let forces = body.elastic_forces();
    let edge = body.vertices.rest_position.iter().zip(&forces).filter(|(x, _)| x.x == 30.0);
    Ok(-edge.map(|(_, f)| *f).sum::<DVec3>())
}
