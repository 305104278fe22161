//! Symmetry: what the mesh, the tissue and the pull have in common, the tears keep, until a tie has to be broken.
//!
//! M(nx, ny) is its own mirror image in x where nx is even, in y where ny is, and its own image under 180° where nx + ny is.

use super::super::{Artifacts, Line, Row, Rows, VerifyError, largest};
use super::square::{Square, Tissue};
use glam::DVec2;

const SIDE: f64 = 30.0;
const MIRROR_X: Image = |p| DVec2::new(SIDE - p.x, p.y);
const MIRROR_Y: Image = |p| DVec2::new(p.x, SIDE - p.y);
const HALF_TURN: Image = |p| DVec2::splat(SIDE) - p;

type Image = fn(DVec2) -> DVec2;

pub(crate) fn run(out: &Artifacts) -> Result<Vec<Row>, VerifyError> {
    let mut rows = Rows::new("tear-symmetry");
    let all = [[30, 26], [40, 40]];
    for cells in if out.is_quick() { &all[..1] } else { &all[..] } {
        let cell = SIDE / f64::from(cells[1]);
        // Cuts end in vertices.
        let slit = [[15.0, 15.0 - 4.0 * cell], [15.0, 15.0 + 4.0 * cell]];
        let notch = |x: f64| [[x, SIDE], [x, SIDE - 3.0 * cell]];
        for tissue in [Tissue::Fibres(90.0), Tissue::Isotropic] {
            let name = format!("centre crack, {}, M({}, {})", tissue.name(), cells[0], cells[1]);
            torn(&mut rows, out, &name, *cells, tissue, &[slit], MIRROR_Y)?;
        }
        // Two tears that feel each other and bend.
        let name = format!("two notches, isotropic, M({}, {})", cells[0], cells[1]);
        torn(&mut rows, out, &name, *cells, Tissue::Isotropic, &[notch(9.0), notch(21.0)], MIRROR_X)?;
    }
    // Fibres at 45° allow no mirror, but half a turn.
    let slit = [[15.0, 15.0 - 4.0 * SIDE / 26.0], [15.0, 15.0 + 4.0 * SIDE / 26.0]];
    torn(&mut rows, out, "centre crack, 45°, M(30, 26)", [30, 26], Tissue::Fibres(45.0), &[slit], HALF_TURN)?;
    rows.finish()
}

/// Tears a square with two tips through, or up to the first tie, and compares either path with the image of the other.
fn torn(
    rows: &mut Rows,
    out: &Artifacts,
    name: &str,
    cells: [u32; 2],
    tissue: Tissue,
    cuts: &[[[f64; 2]; 2]],
    image: Image,
) -> Result<(), VerifyError> {
    let mesh = format!("{{ grid = {{ width = {SIDE}, height = {SIDE}, nx = {}, ny = {} }} }}", cells[0], cells[1]);
    let cuts: Vec<String> = cuts.iter().map(|cut| format!("{{ polyline = {cut:?} }}")).collect();
    let cuts = format!("bodies.0.cuts=[{}]", cuts.join(", "));
    // With the default of 1e-4 images drift apart by 1e-7 mm. By whole triangles: tips that glide do so one after the other, and edits between
    // two mirrored tips are no mirror images.
    let mode = "bodies.0.tearing.mode=free";
    let changes = [&cuts, mode, "run.advanced.linear_tolerance=1e-12", "run.steps=300"];
    let mut square = Square::new("fig2-tear", &mesh, tissue, &changes)?;
    square.approach()?;
    square.tear_through()?;
    let mut advances = square.advances();
    // Directions equal within roundings: which one is taken is a rule, not a symmetry.
    let tie = advances.iter().position(|a| a.margin < 1e-9);
    advances.truncate(tie.unwrap_or(advances.len()));
    let first = advances.first().map(|a| a.tip);
    let [one, other] = [true, false].map(|is_first| -> Vec<DVec2> {
        advances.iter().filter(|a| (Some(a.tip) == first) == is_first).map(|a| a.to).collect()
    });
    // The event that ends the tear may leave the other tip nothing to do.
    rows.add(format!("{name}: advances without a counterpart"), one.len().abs_diff(other.len()) as f64, 1.0, "1");
    let pairs: Vec<(&DVec2, &DVec2)> = one.iter().zip(&other).collect();
    let apart = if pairs.is_empty() { f64::NAN } else { largest(pairs.iter().map(|(p, q)| image(**p).distance(**q))) };
    rows.add(format!("{name}: images apart, {} advances each", pairs.len()), apart, 1e-9, "mm");
    let lines = [("one tip", one.clone()), ("image of the other", other.iter().map(|p| image(*p)).collect())];
    let lines = lines.map(|(name, points)| Line { name: name.to_owned(), points });
    out.paths(&format!("tear-symmetry-{}", name.replace([' ', ',', '(', ')'], "")), name, &lines)
}
