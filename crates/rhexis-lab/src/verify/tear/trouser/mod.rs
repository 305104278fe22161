//! Trouser tears: two legs drawn apart across the sheet tear it at F·(λ + 1)/2·(cos ψ₁ + cos ψ₂) = G_c·h (Rivlin, Thomas 1953),
//! whatever the averaging radius, the stiffness, the toughness, the mesh and the step.
//!
//! Their form 2F·λ − 2·w·h·W(λ) = G_c·h has legs of one stretch. Here the tension runs in bands beside the tear. By the
//! engine's law, which is linear in λ − 1, a band stores ½F·(λ − 1) per length, so that the force and the stretch between
//! grip and tip say all.

mod sheet;
mod theory;

pub(super) use sheet::Triangles;

use super::super::{Artifacts, Line, Row, Rows, VerifyError};
use super::steady::{median, steady};
use glam::DVec2;
use sheet::{LEGS, LENGTH, THICKNESS, TOUGHNESS, Torn, Trouser, WIDTH};
use std::f64::consts::FRAC_PI_2;

/// Of the pull before an advance where the force rises by 3 % in a step or less: half a step's rise, and what a disc of three edges
/// leaves out, each some 1.5 %.
const FORCE: f64 = 0.03;
/// The same where it rises by up to 6 %.
const FORCE_AT_LONG_STEPS: f64 = 0.05;
/// Rises of the force in a step of either kind.
const RISES: [f64; 2] = [0.03, 0.06];
/// How far from the path of theory \[mm\]: a third of an edge.
const OFF_PATH: f64 = 0.1;
/// Of directions \[°\].
const DIRECTION: f64 = 3.0;
/// What is nearer to the rim is left out of paths \[mm\]: less than a band lies before the tear there.
const RIM: f64 = 2.0;
/// Bands of tension are so wide \[mm\]: a tear takes as long to know of its own turn.
const BAND: f64 = 3.0;

const PLAIN: Trouser = Trouser {
    name: "isotropic",
    triangles: Triangles::Unstructured(3),
    edge: 0.35,
    young: 1.0,
    toughness: TOUGHNESS,
    radius: 1.0,
    fibres: None,
    dt: 1.0,
};

/// The last one stretches by a tenth, and its tip is as blunt as an edge is long (G_c/E = 0.5 mm).
const CASES: [Trouser; 8] = [
    PLAIN,
    Trouser { name: "half the step", dt: 0.5, ..PLAIN },
    Trouser { name: "twice the step", dt: 2.0, ..PLAIN },
    Trouser { name: "half the radius", radius: 0.5, ..PLAIN },
    Trouser { name: "twice the radius", radius: 2.0, ..PLAIN },
    Trouser { name: "ten times as stiff", young: 10.0, ..PLAIN },
    Trouser { name: "a tenth as tough", toughness: 0.1 * TOUGHNESS, ..PLAIN },
    Trouser { name: BLUNT, toughness: 10.0 * TOUGHNESS, ..PLAIN },
];
const BLUNT: &str = "ten times as tough";

const MESHES: [Trouser; 6] = [
    Trouser { name: "another unstructured mesh", triangles: Triangles::Unstructured(8), ..PLAIN },
    Trouser { name: "alternating diagonals", triangles: Triangles::Alternating, ..PLAIN },
    Trouser { name: "diagonals one way", triangles: Triangles::OneWay, ..PLAIN },
    Trouser { name: "unstructured, edges of 0.5 mm", edge: 0.5, ..PLAIN },
    Trouser { name: "alternating diagonals, edges of 0.25 mm", edge: 0.25, triangles: Triangles::Alternating, ..PLAIN },
    Trouser { name: "diagonals one way, edges of 0.5 mm", edge: 0.5, triangles: Triangles::OneWay, ..PLAIN },
];

const FIBRES: [Trouser; 7] = [
    Trouser { name: "fibres at 20°, α = 2", fibres: Some([20.0, 2.0, 2.0]), ..PLAIN },
    Trouser { name: "fibres at 0°, α = 2", fibres: Some([0.0, 2.0, 2.0]), ..PLAIN },
    Trouser { name: "fibres at 45°, α = 2", fibres: Some([45.0, 2.0, 2.0]), ..PLAIN },
    Trouser { name: "fibres at 90°, α = 2", fibres: Some([90.0, 2.0, 2.0]), ..PLAIN },
    Trouser { name: "fibres at 20°, α = 1", fibres: Some([20.0, 2.0, 1.0]), ..PLAIN },
    Trouser { name: "fibres at 45°, α = 1", fibres: Some([45.0, 2.0, 1.0]), ..PLAIN },
    Trouser { name: "fibres at 90°, α = 1", fibres: Some([90.0, 2.0, 1.0]), ..PLAIN },
];

pub(crate) fn run(out: &Artifacts) -> Result<Vec<Row>, VerifyError> {
    all("tear-trouser", &CASES, out)
}

pub(crate) fn meshes(out: &Artifacts) -> Result<Vec<Row>, VerifyError> {
    all("tear-trouser-mesh", &MESHES, out)
}

pub(crate) fn fibres(out: &Artifacts) -> Result<Vec<Row>, VerifyError> {
    all("tear-trouser-fibre", &FIBRES, out)
}

fn all(name: &'static str, cases: &[Trouser], out: &Artifacts) -> Result<Vec<Row>, VerifyError> {
    let mut rows = Rows::new(name);
    let cases = if out.is_quick() { &cases[..1] } else { cases };
    let mut lines = Vec::new();
    for case in cases {
        let torn = case.tear()?;
        case.judge(&mut rows, &torn);
        lines.push(Line { name: case.name.to_owned(), points: torn.path });
    }
    out.paths(name, "trouser tears: paths in the rest shape", &lines)?;
    rows.finish()
}

impl Trouser {
    fn judge(&self, rows: &mut Rows, torn: &Torn) {
        let what = |text: &str| format!("{}: {text}", self.name);
        rows.ratio(what("not torn to the rim"), f64::from(u8::from(!torn.is_through)), 0.0);
        self.judge_force(rows, torn);
        self.judge_path(rows, torn);
    }

    fn judge_force(&self, rows: &mut Rows, torn: &Torn) {
        let what = |text: &str| format!("{}: {text}", self.name);
        let pulls = steady(&torn.pulls);
        let (Some(first), Some(last)) = (pulls.first(), pulls.last()) else {
            rows.ratio(what("does not tear"), f64::NAN, 0.0);
            return;
        };
        let path = theory::Path::new(self, LENGTH);
        let form = |pull: &sheet::Pull| pull.force * 0.5 * (pull.stretch + 1.0) / path.pull(pull.torn);
        let off = (median(pulls.iter().map(form)) - 1.0).abs();
        let is_long = self.dt > PLAIN.dt;
        // Turning tears and blunt tips are beyond the form: reported, not judged.
        let turns = self.fibres.is_some_and(|[degrees, ..]| degrees > 20.0);
        let tolerance = match (turns || self.name == BLUNT, is_long) {
            (true, _) => f64::INFINITY,
            (false, true) => FORCE_AT_LONG_STEPS,
            (false, false) => FORCE,
        };
        rows.ratio(what("pull before an advance, median"), off, tolerance);
        let rise = median(pulls.iter().map(|pull| pull.rise / pull.force));
        rows.ratio(what("rise of the pull in the step before"), rise, RISES[usize::from(is_long)]);
        let release = median(pulls.iter().map(|pull| pull.release / self.toughness));
        if self.fibres.is_none() {
            // An advance is decided in the step in which the force passes the limit: at most one step's rise above it.
            let limit = RISES[usize::from(is_long)];
            rows.ratio(what("G at an advance above the toughness, median"), (release - 1.0).max(0.0), limit);
        }
        let area = (last.torn - first.torn) * THICKNESS;
        rows.note(
            what("work of the hands per area torn, over the toughness"),
            (last.work - first.work) / (area * self.toughness),
            "1",
        );
    }

    fn judge_path(&self, rows: &mut Rows, torn: &Torn) {
        let what = |text: &str| format!("{}: {text}", self.name);
        let path = theory::Path::new(self, LENGTH);
        let [degrees, ..] = self.fibres.unwrap_or_default();
        let is_inner = |p: &DVec2| 0.5 * WIDTH - p.x.abs() > RIM && p.y > RIM;
        let inner: Vec<DVec2> = torn.path.iter().copied().filter(is_inner).collect();
        // A tear that turns lags behind by its turn over a band, which the theory has not: its place is reported.
        let tolerance = if self.turns() || self.name == BLUNT { f64::INFINITY } else { OFF_PATH };
        rows.add(what("off the path of theory, 2 mm and more from the rim"), path.off(&inner), tolerance, "mm");
        if self.fibres.is_none() {
            return;
        }
        let angle = |way: DVec2| way.x.abs().atan2(-way.y);
        let &[start, first, ..] = &torn.path[..] else { return };
        let wanted = self.first_direction();
        let off = (angle(first - start) - wanted).abs().to_degrees();
        rows.add(format!("{}, {:.1}°", what("first direction, off"), wanted.to_degrees()), off, DIRECTION, "°");
        let ways = inner.windows(2).filter(|way| way[0].distance(start) > BAND);
        let off = median(ways.map(|way| {
            let at = DVec2::new(way[0].x.abs(), LENGTH - LEGS - way[0].y);
            (angle(way[1] - way[0]) - self.direction(at, angle(way[1] - way[0]))).abs().to_degrees()
        }));
        // Across strong fibres it turns by more than that in every band, to the rim.
        let tolerance = if degrees < 90.0 { DIRECTION } else { f64::INFINITY };
        rows.add(what("direction once it runs steadily, off that of theory at its place"), off, tolerance, "°");
        if degrees.to_radians() >= FRAC_PI_2 {
            let side = if first.x < start.x { "left" } else { "right" };
            let name = format!("first advance no tie (it turns to the {side})");
            rows.ratio(what(&name), f64::from(u8::from(!torn.is_tie)), 0.0);
        }
    }
}
