//! The time step: path and load of the dynamic tear converge as it falls.

use super::super::{Artifacts, Line, Row, Rows, VerifyError};
use super::hausdorff::hausdorff;
use super::square::{Advanced, GRIP_SPEED, Square, Tissue, length};
use glam::DVec2;

/// Time steps \[ms\]; the scene's own is the second.
const STEPS: [f64; 4] = [20.0, 10.0, 5.0, 2.5];
/// The scene's own in [`STEPS`].
const DEFAULT: usize = 1;

struct Run {
    dt: f64,
    path: Vec<DVec2>,
    /// Load at which the criterion passes 1 \[mm\].
    onset: f64,
    /// (length torn, displacement of the grips) at every advance \[mm\].
    loads: Vec<DVec2>,
    edge: f64,
}

impl Run {
    fn new(tissue: Tissue, change: &str, dt: f64) -> Result<Self, VerifyError> {
        let mesh = "{ unstructured = { corners = [[0, 0], [30, 0], [30, 30], [0, 30]], edge = 0.5, seed = 1 } }";
        let mut square = Square::new(
            "fig2-tear",
            mesh,
            tissue,
            &["run.steps=2000", "run.max_tear_passes=100", &format!("run.dt={dt}"), change],
        )?;
        square.approach()?;
        square.tear_through()?;
        let mut torn = 0.0;
        let advance = |a: &Advanced| {
            torn += a.from.distance(a.to);
            DVec2::new(torn, a.u)
        };
        let loads = square.advances().iter().map(advance).collect();
        let onset = square.onsets.first().map_or(f64::NAN, |onset| onset.u);
        Ok(Self { dt, path: square.path(), onset, loads, edge: square.edge })
    }

    /// Displacement of the grips when the tear has come so far \[mm\].
    fn load_at(&self, torn: f64) -> f64 {
        self.loads.iter().find(|l| l.x >= torn).map_or(f64::NAN, |l| l.y)
    }
}

pub(crate) fn run(out: &Artifacts) -> Result<Vec<Row>, VerifyError> {
    let mut rows = Rows::new("tear-time-step");
    // Along the fibre; free to bend, since the notch is off the middle; between the fibre and the pull, without a cusp of the
    // threshold that would make the tear jump between two directions.
    let cases = [
        ("45°", Tissue::Fibres(45.0), "run.steps=2000"),
        ("isotropic, notch at x = 9", Tissue::Isotropic, "bodies.0.cuts.0.polyline=[[9, 30], [9, 27]]"),
        (
            "60°, α = 1",
            Tissue::Fibres(60.0),
            "bodies.0.tearing={ strength_along_fibres = 0.05, strength_ratio = 2, exponent = 1, radius = 1.5 }",
        ),
    ];
    let (cases, steps) = if out.is_quick() { (&cases[1..2], &STEPS[1..3]) } else { (&cases[..], &STEPS[..]) };
    for &(name, tissue, change) in cases {
        let runs = steps.iter().map(|&dt| Run::new(tissue, change, dt)).collect::<Result<Vec<_>, _>>()?;
        for pair in runs.windows(2) {
            let [run, half] = pair else { continue };
            let what = format!("{name}: dt {} against {} ms", run.dt, half.dt);
            let limit = if run.dt <= STEPS[DEFAULT] { 1.0 } else { f64::INFINITY };
            rows.add(format!("{what}, paths apart"), hausdorff(&run.path, &half.path) / run.edge, limit, "edges");
            // The criterion passes 1 within a step; it is nearly linear there.
            rows.relative(format!("{what}, load of the first tear"), run.onset, half.onset, 2e-3);
            // A tear is seen at the end of a step: first order in its length.
            let half_way = 0.5 * length(&half.path);
            let load = (run.load_at(half_way) - half.load_at(half_way)).abs();
            rows.add(format!("{what}, load half way"), load, GRIP_SPEED * run.dt * (1.0 + 1e-9), "mm");
        }
        let line = |r: &Run, points: &[DVec2]| Line { name: format!("dt {} ms", r.dt), points: points.to_vec() };
        let lines: Vec<Line> = runs.iter().map(|r| line(r, &r.path)).collect();
        let plot = format!("tear-time-step-{}", name.split([',', ' ']).next().unwrap_or(name));
        out.paths(&plot, &format!("fig2-tear, {name}"), &lines)?;
    }
    rows.finish()
}
