//! The time step: path and load of the dynamic tear converge as it falls.

use super::super::{Artifacts, Line, Row, Rows, VerifyError};
use super::hausdorff::hausdorff;
use super::square::{Advanced, Square, Tissue, length};
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
        let steps = [format!("run.dt={dt}"), "run.steps=2000".to_owned()];
        let mut square = Square::new("fig2-tear", mesh, tissue, &[change, &steps[0], &steps[1]])?;
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

pub fn run(out: &Artifacts) -> Result<Vec<Row>, VerifyError> {
    let mut rows = Rows::new("tear-time-step");
    // Along the fibre; free to bend, since the notch is off the middle; bending away from a weak preference.
    let cases = [
        ("45°", Tissue::Fibres(45.0), "scene.name=fig2-tear"),
        ("isotropic, notch at x = 9", Tissue::Isotropic, "bodies.0.cuts.0.polyline=[[9, 30], [9, 27]]"),
        ("60°, strength ratio 2", Tissue::Fibres(60.0), "bodies.0.tearing.strength_fibre=0.1"),
    ];
    let (cases, steps) = if out.is_quick() { (&cases[1..2], &STEPS[1..3]) } else { (&cases[..], &STEPS[..]) };
    for &(name, tissue, change) in cases {
        let runs = steps.iter().map(|&dt| Run::new(tissue, change, dt)).collect::<Result<Vec<_>, _>>()?;
        let mut coarser = [f64::INFINITY; 2];
        for pair in runs.windows(2) {
            let [run, half] = pair else { continue };
            let path = hausdorff(&run.path, &half.path) / run.edge;
            let what = format!("{name}: dt {} against {} ms", run.dt, half.dt);
            let limit = if run.dt <= STEPS[DEFAULT] { 1.0 } else { f64::INFINITY };
            rows.add(format!("{what}, paths apart"), path, limit, "edges");
            // The tear may run max_tear_speed·dt in a step, all of it at the load of the step's end.
            let half_way = 0.5 * length(&half.path);
            let load = (run.load_at(half_way) / half.load_at(half_way) - 1.0).abs();
            rows.ratio(format!("{what}, load half way"), load, coarser[0]);
            let onset = (run.onset / half.onset - 1.0).abs();
            rows.ratio(format!("{what}, load of the first tear"), onset, coarser[1].max(1e-4));
            coarser = [load, onset];
        }
        let line = |r: &Run, points: &[DVec2]| Line { name: format!("dt {} ms", r.dt), points: points.to_vec() };
        let lines: Vec<Line> = runs.iter().map(|r| line(r, &r.path)).collect();
        let plot = format!("tear-time-step-{}", name.split([',', ' ']).next().unwrap_or(name));
        out.paths(&plot, &format!("fig2-tear, {name}"), &lines)?;
    }
    rows.finish()
}
