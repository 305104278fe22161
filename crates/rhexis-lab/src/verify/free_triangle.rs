//! One anisotropic triangle in free flight. The force is the gradient of an energy and exerts no torque, so an exact flow
//! keeps energy and angular momentum. The engine's own step converges to that flow with first order.

use super::bodies::{self, Snapshot};
use super::reference::{Json, file};
use super::{Artifacts, Row, Rows, VerifyError, largest};
use glam::DVec3;
use rhexis::components::{Fibres, Forces};
use rhexis::membrane::Membrane;
use rhexis::settings::{Advanced, Settings, Tangent};
use rhexis::simulation::Simulation;
use rhexis::storage::{BodyId, TriangleMesh};
use rhexis::systems::forces::{assembly, corotation};

pub(super) fn run(_: &Artifacts) -> Result<Vec<Row>, VerifyError> {
    let mut rows = Rows::new("free-triangle");
    let (name, text) = file!("free_triangle.json");
    let file = Json::new(name, text)?;
    exact_flow(&mut rows, &file)?;
    backward_euler(&mut rows, &file)?;
    rows.finish()
}

const TRIANGLE: &str = "/free_triangle";
const LAW: &str = "/free_triangle/laws/gradient";

fn triangle(file: &Json, is_planar: bool, settings: Settings) -> Result<(Simulation, BodyId), VerifyError> {
    let number = |path: &str| file.number(&format!("{TRIANGLE}{path}"));
    let mesh =
        TriangleMesh { positions: file.vectors(&format!("{TRIANGLE}/X"))?, triangles: vec![[0, 1, 2]], fibres: None };
    let constants =
        [number("/material/EF")?, number("/material/ET")?, number("/material/nuF")?, number("/material/G")?];
    let material = bodies::material(constants, number("/h")?, number("/rho")?);
    let membrane = Membrane::new("triangle", mesh, material).fibres(Fibres::at_degrees(number("/theta_deg")?));
    let membrane = if is_planar { membrane.planar() } else { membrane };
    let (mut simulation, body) = bodies::simulate(settings, membrane)?;
    let (x, v) = (file.vectors(&format!("{TRIANGLE}/x0"))?, file.vectors(&format!("{TRIANGLE}/v0"))?);
    bodies::set_motion(&mut simulation, body, |i, _| (x[i], v[i]))?;
    Ok((simulation, body))
}

/// The triangle under the engine's forces in space and the classical Runge–Kutta method of fourth order.
struct Flow {
    body: Snapshot,
    forces: Forces,
}

impl Flow {
    fn acceleration(&mut self, x: &[DVec3; 3]) -> [DVec3; 3] {
        let Snapshot { vertices, triangles, topology, frames } = &mut self.body;
        vertices.position.copy_from_slice(x);
        corotation::evaluate(vertices, triangles, frames, false, None, None);
        assembly::membrane_forces((triangles, topology), frames, |_| DVec3::ZERO, 0.0, &mut self.forces);
        [0, 1, 2].map(|v| self.forces.nodal[v] / vertices.mass[v])
    }

    fn step(&mut self, x: &mut [DVec3; 3], v: &mut [DVec3; 3], dt: f64) {
        let along = |x: &[DVec3; 3], v: &[DVec3; 3], by: f64| [0, 1, 2].map(|i| x[i] + v[i] * by);
        let a1 = self.acceleration(x);
        let (v2, x2) = (along(v, &a1, 0.5 * dt), along(x, v, 0.5 * dt));
        let a2 = self.acceleration(&x2);
        let (v3, x3) = (along(v, &a2, 0.5 * dt), along(x, &v2, 0.5 * dt));
        let a3 = self.acceleration(&x3);
        let (v4, x4) = (along(v, &a3, dt), along(x, &v3, dt));
        let a4 = self.acceleration(&x4);
        for i in 0..3 {
            x[i] += (v[i] + (v2[i] + v3[i]) * 2.0 + v4[i]) * (dt / 6.0);
            v[i] += (a1[i] + (a2[i] + a3[i]) * 2.0 + a4[i]) * (dt / 6.0);
        }
    }

    /// Energy \[mJ\] and angular momentum about the origin along z \[g·mm²/ms\].
    fn invariants(&mut self, x: &[DVec3; 3], v: &[DVec3; 3]) -> (f64, f64) {
        self.acceleration(x);
        let Snapshot { vertices, triangles, frames, .. } = &self.body;
        let s = frames.state(0);
        let strain = s.polar.stretch - rhexis::math::Sym2::IDENTITY;
        let elastic = 0.5 * triangles.rest[0].area * triangles.thickness[0] * s.stress.contract(strain);
        let kinetic: f64 = (0..3).map(|i| 0.5 * vertices.mass[i] * v[i].length_squared()).sum();
        let spin: f64 = (0..3).map(|i| vertices.mass[i] * x[i].cross(v[i]).z).sum();
        (elastic + kinetic, spin)
    }
}

fn exact_flow(rows: &mut Rows, file: &Json) -> Result<(), VerifyError> {
    let (mut simulation, body) = triangle(file, false, bodies::exacting())?;
    let body = Snapshot::new(&mut simulation, body)?;
    let (p, q) = (&body.vertices.position, &body.vertices.velocity);
    let (mut x, mut v) = ([p[0], p[1], p[2]], [q[0], q[1], q[2]]);
    let mut flow = Flow { body, forces: Forces::default() };
    let start = flow.invariants(&x, &v);
    // The fastest mode has about 13/ms: at 1e-4 ms the method's own phase error is 1e-11 over the whole flight and its loss of
    // energy below 1e-13.
    let steps = 200_000;
    let duration = file.number(&format!("{TRIANGLE}/T"))?;
    for _ in 0..steps {
        flow.step(&mut x, &mut v, duration / f64::from(steps));
    }
    let end = flow.invariants(&x, &v);

    let wanted = file.vectors(&format!("{LAW}/x_T"))?;
    let off = x.iter().zip(&wanted).map(|(a, b)| a.distance(*b));
    // The table's two integrators agree to 4e-11; this method adds as much.
    rows.add("exact flow, 20 ms: positions", largest(off), 1e-8, "mm");
    let wanted = file.vectors(&format!("{LAW}/v_T"))?;
    rows.add(
        "exact flow, 20 ms: velocities",
        largest(v.iter().zip(&wanted).map(|(a, b)| a.distance(*b))),
        1e-8,
        "mm/ms",
    );
    // Rounding of 200,000 steps; the classical co-rotational force gains 0.15 and 1.27.
    rows.relative("exact flow, 20 ms: energy kept", end.0, start.0, 1e-12);
    rows.relative("exact flow, 20 ms: angular momentum kept", end.1, start.1, 1e-12);
    rows.relative("energy at the start", start.0, file.number(&format!("{LAW}/start/E"))?, 1e-12);
    Ok(())
}

fn backward_euler(rows: &mut Rows, file: &Json) -> Result<(), VerifyError> {
    let exact = file.vectors(&format!("{LAW}/x_T_order"))?;
    let mut errors = Vec::new();
    for i in 0..file.len(&format!("{LAW}/schemes"))? {
        let scheme = format!("{LAW}/schemes/{i}");
        let (steps, dt) = (file.number(&format!("{scheme}/n"))? as u32, file.number(&format!("{scheme}/dt"))?);
        let settings = Settings {
            advanced: Advanced { tangent: Tangent::Exact, ..bodies::exacting().advanced },
            ..bodies::exacting()
        };
        let (mut simulation, body) = triangle(file, true, settings)?;
        for _ in 0..steps {
            simulation.step(dt)?;
        }
        let found = bodies::positions(&simulation, body)?;
        let wanted = file.vectors(&format!("{scheme}/backward_euler/x"))?;
        let off = found.iter().zip(&wanted).map(|(a, b)| a.distance(*b));
        // Both iterate Newton's method to rounding; 1e-11 of the largest force moves 1e-12 mm.
        rows.add(format!("backward Euler, dt {dt} ms: positions at 2 ms"), largest(off), 1e-8, "mm");
        errors.push((dt, largest(found.iter().zip(&exact).map(|(a, b)| a.distance(*b)))));
    }
    if let [.., (coarse_dt, coarse), (fine_dt, fine)] = errors[..] {
        let order = (coarse / fine).ln() / (coarse_dt / fine_dt).ln();
        // The table's own codes show 1.008.
        rows.ratio("backward Euler: order in time, distance from 1", (order - 1.0).abs(), 0.1);
    }
    Ok(())
}
