//! Order in time: a taut sheet that is drawn out at a constant speed while it swings in and out of its plane, with strain-rate
//! damping and drag. Everything in it is smooth; the reference is the same mesh in steps eight times as short as the shortest.

use super::bodies::{self, Snapshot};
use super::{Artifacts, Row, Rows, VerifyError};
use glam::DVec3;
use rhexis::components::{Curve, Damping, Drag, Fibres, Material, PreStretch};
use rhexis::generate;
use rhexis::math::Sym2;
use rhexis::membrane::Membrane;
use rhexis::settings::{Accuracy, Advanced, Integrator, LinearParams, Settings, Tangent};
use rhexis::storage::Vertices;
use std::f64::consts::PI;

/// Side of the sheet \[mm\].
const SIDE: f64 = 30.0;
/// Two thirds of the period of the slowest wave \[ms\].
const DURATION: f64 = 0.4;
/// Speed at which the rim draws apart, per mm from the centre \[1/ms\].
const DRAW: f64 = 0.05;
/// Speed of the swing \[mm/ms\]: it goes as far as a strain of some 10 %.
const SWING: f64 = 10.0;

pub(super) fn run(_: &Artifacts) -> Result<Vec<Row>, VerifyError> {
    let mut rows = Rows::new("integrator");
    let tight =
        LinearParams { tolerance: 1e-12, stress_tolerance: f64::INFINITY, ..bodies::exacting().advanced.linear };
    let converged = Settings {
        advanced: Advanced { tangent: Tangent::Projected, linear: tight, ..bodies::exacting().advanced },
        ..bodies::exacting()
    };
    let tr_bdf2 = Settings { advanced: Advanced { integrator: Integrator::TrBdf2, ..converged.advanced }, ..converged };
    let reference = swing(tr_bdf2, 640)?;
    let steps = [20, 40, 80];
    let kinds = [
        ("TR-BDF2, converged", tr_bdf2, Some(2.0)),
        ("accurate", Settings { threads: 1, ..Settings::new(Accuracy::Accurate) }, Some(2.0)),
        (
            "TR-BDF2, one exact solve per stage",
            Settings {
                advanced: Advanced { newton_iterations: 1, tangent: Tangent::Exact, ..tr_bdf2.advanced },
                ..tr_bdf2
            },
            Some(2.0),
        ),
        (
            "TR-BDF2, one rotated solve per stage",
            Settings { advanced: Advanced { newton_iterations: 1, ..tr_bdf2.advanced }, ..tr_bdf2 },
            None,
        ),
        ("backward Euler, converged", converged, Some(1.0)),
        (
            "backward Euler, one rotated solve",
            Settings { advanced: Advanced { newton_iterations: 1, ..converged.advanced }, ..converged },
            None,
        ),
    ];
    for (what, settings, order) in kinds {
        let mut errors = [[0.0; 2]; 3];
        for (errors, steps) in errors.iter_mut().zip(steps) {
            *errors = difference(&swing(settings, steps)?, &reference);
        }
        let [_, coarse, fine] = errors;
        for (quantity, (coarse, fine)) in ["positions", "velocities"].iter().zip(coarse.into_iter().zip(fine)) {
            let found = (coarse / fine).log2();
            match order {
                // Steps of 0.01 and 0.005 ms, an eighth of the period of the fastest wave that matters.
                Some(order) => {
                    rows.ratio(
                        format!("{what}: order of {quantity}, distance from {order}"),
                        (found - order).abs(),
                        0.15,
                    );
                }
                None => rows.note(format!("{what}: order of {quantity}"), found, "1"),
            }
        }
        rows.note(format!("{what}: positions in steps of {} ms", DURATION / f64::from(steps[2])), fine[0], "mm");
    }
    rows.finish()
}

fn swing(settings: Settings, steps: u32) -> Result<Vertices, VerifyError> {
    let mesh = generate::grid(SIDE, SIDE, 8, 7)?;
    let centre = DVec3::new(0.5 * SIDE, 0.5 * SIDE, 0.0);
    let membrane = Membrane::new("sheet", mesh, Material::allard_2009())
        .fibres(Fibres::at_degrees(30.0))
        .with(PreStretch { strain: Sym2::new(0.05, 0.1, 0.0) })
        .with(Damping { time: 0.003 })
        .with(Drag { coefficient: 2e-5 });
    let draw = Curve::ramp(1.0, 1.0).unwrap_or_else(|_| Curve::constant(1.0));
    let rim = bodies::hold_along(&membrane, "rim", [true; 3], draw, |p| {
        let is_rim = p.x == 0.0 || p.x == SIDE || p.y == 0.0 || p.y == SIDE;
        is_rim.then_some((p - centre) * DRAW)
    });
    let (mut simulation, body) = bodies::simulate(settings, membrane.hold(rim))?;
    bodies::set_motion(&mut simulation, body, |_, x| {
        let bump = (PI * x.x / SIDE).sin() * (PI * x.y / SIDE).sin();
        (x, (x - centre) * DRAW + DVec3::new(0.5, -0.3, 1.0) * (SWING * bump))
    })?;
    let dt = DURATION / f64::from(steps);
    for _ in 0..steps {
        simulation.step(dt)?;
    }
    Ok(Snapshot::new(&mut simulation, body)?.vertices)
}

/// Root mean square over the vertices, of positions \[mm\] and of velocities \[mm/ms\].
fn difference(a: &Vertices, b: &Vertices) -> [f64; 2] {
    let rms = |a: &[DVec3], b: &[DVec3]| {
        (a.iter().zip(b).map(|(a, b)| a.distance_squared(*b)).sum::<f64>() / a.len() as f64).sqrt()
    };
    [rms(&a.position, &b.position), rms(&a.velocity, &b.velocity)]
}
