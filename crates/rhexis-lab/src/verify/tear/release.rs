//! The energy that a crack releases: a square between fixed grips on aligned meshes, cut to neighbouring lengths along a line
//! of edges. −dE/dA tends to the continuum's G(a) at first order in the edge.

use super::super::reference::{Json, file};
use super::super::{Artifacts, Axes, Line, Row, Rows, VerifyError, largest};
use super::cracked::{Cracked, Tissue, between_grips};
use glam::DVec2;
use rhexis::components::{Material, Tearing};
use rhexis::generate;

/// Cells along a side; the file lists energies of the first three.
const CELLS: [usize; 4] = [20, 40, 80, 160];
const LISTED: usize = 80;

/// Energies and releases of one tissue on one mesh, by crack length.
struct Curve {
    cells: usize,
    /// Elastic energy \[mJ\].
    energy: Vec<f64>,
    /// Energy released per area \[N/mm\].
    release: Vec<f64>,
}

pub(crate) fn run(out: &Artifacts) -> Result<Vec<Row>, VerifyError> {
    let mut rows = Rows::new("tear-release");
    let (name, text) = file!("energy_release.json");
    let file = Json::new(name, text)?;
    let (count, cells) = if out.is_quick() { (1, &CELLS[..3]) } else { (file.len("/fixed_grips/cases")?, &CELLS[..]) };
    for case in 0..count {
        one_tissue(&mut rows, out, &file, case, cells)?;
    }
    rows.finish()
}

fn one_tissue(rows: &mut Rows, out: &Artifacts, file: &Json, case: usize, cells: &[usize]) -> Result<(), VerifyError> {
    let at = format!("/fixed_grips/cases/{case}");
    // The isotropic tissue has no angle.
    let (name, material, fibre_degrees) = match file.number(&format!("{at}/theta_deg")) {
        Ok(degrees) => (format!("fibres at {degrees}°"), Material::allard_2009(), degrees),
        Err(_) => ("isotropic".to_owned(), Material::isotropic(3.0, 0.3, 0.1), 0.0),
    };
    let tissue = Tissue { material, fibre_degrees, tearing: Tearing::default() };
    let wanted = |key: &str| -> Result<Vec<f64>, VerifyError> {
        (0..file.len(&format!("{at}/table"))?).map(|i| file.number(&format!("{at}/table/{i}/{key}"))).collect()
    };
    let (lengths, energy, release) = (wanted("a")?, wanted("W_mJ")?, wanted("G_N_per_mm")?);
    let (side, u) = (file.number("/fixed_grips/L")?, file.number("/fixed_grips/u")?);
    let mut curves = Vec::new();
    for &n in cells {
        let cell = side / n as f64;
        let stored = |length: f64| -> Result<f64, VerifyError> {
            let sheet = between_grips(tissue.membrane(generate::grid(side, side, n, n)?), side, u);
            let middle = 0.5 * side;
            Ok(Cracked::new(sheet, [DVec2::new(middle, 0.0), DVec2::new(middle, length)])?.solve()?.energy)
        };
        let mut curve = Curve { cells: n, energy: Vec::new(), release: Vec::new() };
        for &a in &lengths {
            let released = stored(a - cell)? - stored(a + cell)?;
            curve.energy.push(stored(a)?);
            curve.release.push(released / (2.0 * cell * material.thickness));
        }
        if n <= LISTED {
            let listed = wanted(&format!("P1_on_M(n,n)_slit/n={n}/W_mJ"))?;
            // The same mesh: the solver's residual of 1e-13 times the condition of the stiffness.
            rows.ratio(format!("{name}, M({n}, {n}): energy"), worst(&curve.energy, &listed), 1e-8);
        }
        curves.push(curve);
    }
    for pair in curves.windows(2) {
        let [coarse, fine] = pair else { continue };
        let order = |of: fn(&Curve) -> &[f64], wanted: &[f64]| (rms(of(coarse), wanted) / rms(of(fine), wanted)).log2();
        let what = format!("{name}, from {} to {} cells", coarse.cells, fine.cells);
        let stored = order(|c| &c.energy, &energy);
        let released = order(|c| &c.release, &release);
        if fine.cells != cells.last().copied().unwrap_or_default() {
            rows.note(format!("{what}: order of the energy"), stored, "1");
            rows.note(format!("{what}: order of the energy released"), released, "1");
        } else {
            // Orders approach 1 from either side: from 0.9 and 1.7 on the coarsest meshes, as what is of second order falls.
            rows.ratio(format!("{what}: order of the energy, off 1"), (stored - 1.0).abs(), 0.1);
            let what = format!("{what}: energy released");
            rows.ratio(format!("{what}, order short of 1"), (1.0 - released).max(0.0), 0.05);
            rows.note(format!("{what}, worst of {} lengths", lengths.len()), worst(&fine.release, &release), "1");
            // What is left of second order: with the shortest crack four to eight cells long on the coarser mesh, some of 1/16 to 1/64.
            let limit: Vec<f64> = fine.release.iter().zip(&coarse.release).map(|(f, c)| 2.0 * f - c).collect();
            rows.ratio(format!("{what}, first order extrapolated"), worst(&limit, &release), 0.01);
        }
    }
    plots(out, &name, &lengths, &release, &curves, side)
}

/// Root mean square of the relative errors.
fn rms(found: &[f64], wanted: &[f64]) -> f64 {
    let sum: f64 = found.iter().zip(wanted).map(|(f, w)| (f / w - 1.0).powi(2)).sum();
    (sum / found.len() as f64).sqrt()
}

/// Largest relative error.
fn worst(found: &[f64], wanted: &[f64]) -> f64 {
    largest(found.iter().zip(wanted).map(|(f, w)| (f / w - 1.0).abs()))
}

fn plots(
    out: &Artifacts,
    name: &str,
    lengths: &[f64],
    release: &[f64],
    curves: &[Curve],
    side: f64,
) -> Result<(), VerifyError> {
    let file = format!("tear-release-{}", name.replace(' ', "-").replace('°', ""));
    let over_length = |values: &[f64]| lengths.iter().zip(values).map(|(&a, &g)| DVec2::new(a, 1e6 * g)).collect();
    let mut lines = vec![Line { name: "continuum".to_owned(), points: over_length(release) }];
    let of_mesh = |c: &Curve| Line { name: format!("M({}, {})", c.cells, c.cells), points: over_length(&c.release) };
    lines.extend(curves.iter().map(of_mesh));
    let title = format!("energy released per area of crack, {name}");
    let axes = Axes { title: &title, names: ["crack length [mm]", "G [1e-6 N/mm]"], is_isometric: false };
    out.plot(&file, axes, &lines)?;
    let over_size = |c: &Curve, error: f64| DVec2::new((side / c.cells as f64).log10(), error.log10());
    let errors: Vec<DVec2> = curves.iter().map(|c| over_size(c, rms(&c.release, release))).collect();
    let slope = |p: &DVec2, first: &DVec2| DVec2::new(p.x, first.y + p.x - first.x);
    let ideal = errors.first().map(|first| errors.iter().map(|p| slope(p, first)).collect()).unwrap_or_default();
    let lines = [("error", errors), ("first order", ideal)];
    let lines = lines.map(|(name, points)| Line { name: name.to_owned(), points });
    let title = format!("error of the energy released, {name}");
    let names = ["log10 of the cell [mm]", "log10 of the relative error"];
    out.plot(&format!("{file}-order"), Axes { title: &title, names, is_isometric: false }, &lines)
}
