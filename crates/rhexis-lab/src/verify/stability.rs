//! A taut sheet at rest with a little noise in its velocities: a step must damp it at any time step, by either formula of time.

use super::bodies::{self, Snapshot};
use super::{Artifacts, Row, Rows, VerifyError};
use glam::DVec3;
use rhexis::components::{Curve, Fibres, Material};
use rhexis::generate;
use rhexis::membrane::Membrane;
use rhexis::settings::{Accuracy, Advanced, Integrator, Settings};

/// Size of the noise \[mm/ms\]: far from anything that is not linear.
const NOISE: f64 = 1e-6;

pub(super) fn run(_: &Artifacts) -> Result<Vec<Row>, VerifyError> {
    let mut rows = Rows::new("stability");
    for (young, stretch) in [(10.0, 0.1), (10.0, 0.3), (100.0, 0.1), (100.0, 0.3)] {
        for dt in [0.01, 0.1, 1.0, 10.0, 100.0] {
            for (what, settings) in kinds() {
                let left = noise_left(young, stretch, dt, Settings { threads: 1, ..settings })?;
                // Both formulas damp every wave of a stable sheet, TR-BDF2 the less the better it resolves it; an unstable step ends
                // above 1e3.
                let case = format!("E_F/E_T {young}, stretched {stretch}, dt {dt} ms{what}");
                rows.ratio(format!("{case}: noise left after 60 steps"), left, 1.0);
            }
        }
    }
    rows.finish()
}

/// One solve by either formula, and the accurate step.
fn kinds() -> [(&'static str, Settings); 3] {
    let default = Settings::default();
    let tr_bdf2 = Settings { advanced: Advanced { integrator: Integrator::TrBdf2, ..default.advanced }, ..default };
    [("", default), (", TR-BDF2", tr_bdf2), (", accurate", Settings::new(Accuracy::Accurate))]
}

/// Stretches a sheet along its fibres and gives the size of the velocities after 60 steps over that of the noise that was put
/// in.
fn noise_left(young_fibre: f64, stretch: f64, dt: f64, settings: Settings) -> Result<f64, VerifyError> {
    let side = 30.0;
    let material = Material { young_fibre, shear_modulus: None, ..Material::allard_2009() };
    let membrane =
        Membrane::new("sheet", generate::grid(side, side, 16, 14)?, material).fibres(Fibres::at_degrees(0.0));
    let ends = bodies::hold_along(&membrane, "ends", [true; 3], Curve::constant(stretch), |p| {
        (p.x == 0.0 || p.x == side).then(|| DVec3::X * (p.x - 0.5 * side))
    });
    let (mut simulation, body) = bodies::simulate(settings, membrane.hold(ends))?;
    simulation.settle(0.0, 1e-10)?;
    let rest = bodies::positions(&simulation, body)?;
    let noise = |v: usize| {
        let v = v as f64;
        DVec3::new((12.9898 * v).sin(), (78.233 * v).sin(), (37.719 * v).sin()) * NOISE
    };
    bodies::set_motion(&mut simulation, body, |v, x| {
        (rest[v], if x.x > 0.0 && x.x < side { noise(v) } else { DVec3::ZERO })
    })?;
    let size = |s: &Snapshot| s.vertices.velocity.iter().map(|v| v.length_squared()).sum::<f64>().sqrt();
    let start = size(&Snapshot::new(&mut simulation, body)?);
    for _ in 0..60 {
        simulation.step(dt)?;
    }
    Ok(size(&Snapshot::new(&mut simulation, body)?) / start)
}
