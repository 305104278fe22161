//! The sheet of the map: pressed together along x, spinning about x, with ends that slide freely across it.

use super::Case;
use crate::bench::BenchError;
use glam::DVec3;
use rhexis::components::{Curve, Fibres, Hold, Material};
use rhexis::generate;
use rhexis::membrane::Membrane;
use rhexis::simulation::Simulation;
use rhexis::storage::{Attached, BodyId, Vertices};

/// Side of the sheet \[mm\].
const SIDE: f64 = 10.0;

/// What the vertices are off the plane at first \[mm\]: enough to let it buckle.
const NOISE: f64 = 1e-3;

/// How well the triangles of the mesh are shaped.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Quality {
    /// A grid of halved squares: angles of 45° and 90°.
    Even,
    /// Their vertices moved at random: smallest angle 20° to 25°.
    Jittered,
    /// Halved rectangles ten times as long as wide: smallest angle 5.7°.
    Slivers,
}

impl Quality {
    /// Its name.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Even => "even",
            Self::Jittered => "jittered",
            Self::Slivers => "slivers",
        }
    }
}

/// The simulation of a case.
pub(super) fn simulation(case: &Case) -> Result<(Simulation, BodyId), BenchError> {
    let refused = |what: String| BenchError::State(format!("the sheet of the stability map: {what}"));
    let mesh = match case.quality {
        Quality::Even => generate::grid(SIDE, SIDE, 6, 6),
        Quality::Jittered => generate::jittered(SIDE, SIDE, 6, 6, 1),
        Quality::Slivers => generate::grid(SIDE, SIDE, 2, 20),
    };
    let mesh = mesh.map_err(|error| refused(error.to_string()))?;
    let material = Material {
        young_fibre: case.ratio,
        young_transverse: 1.0,
        poisson_major: 0.3,
        shear_modulus: None,
        thickness: 0.1,
        density: 1e-3,
    };
    let sheet = Membrane::new("sheet", mesh, material).fibres(Fibres::at_degrees(30.0));
    let is_end = |p: DVec3| p.x == 0.0 || p.x == SIDE;
    let shift = |p: DVec3| DVec3::X * (case.compression * (0.5 * SIDE - p.x));
    let rest = sheet.mesh().positions.clone();
    let ends = sheet.select(is_end).into_iter().map(|vertex| (vertex, shift(rest[vertex as usize])));
    let hold = Hold {
        name: "ends".into(),
        members: Attached::new(ends),
        axes: [true, false, false],
        curve: Curve::constant(1.0),
    };
    let mut simulation = Simulation::new(case.mode.settings())?;
    let body = simulation.spawn(sheet.hold(hold)).map_err(|error| refused(error.to_string()))?;
    if let Ok(mut vertices) = simulation.world().get::<&mut Vertices>(body.entity()) {
        let Vertices { position, velocity, rest_position, .. } = &mut *vertices;
        for (v, ((x, u), &rest)) in position.iter_mut().zip(velocity).zip(rest_position.iter()).enumerate() {
            let v = v as f64;
            // Along x the ends are where they are held.
            let noise = DVec3::new(0.0, (78.233 * v).sin(), (37.719 * v).sin());
            *x = rest + shift(rest) + noise * NOISE;
            *u = DVec3::X.cross(*x - DVec3::splat(0.5 * SIDE).with_z(0.0)) * case.spin;
        }
    }
    Ok((simulation, body))
}
