//! Independence of the mesh: the same square on four kinds of mesh at three sizes, in free and in edge mode.
//!
//! A tear that is a property of the tissue takes the same path at the same load on all of them. The averaging radius spans
//! three edges or more everywhere; with fewer the load depends on the mesh, and the body's report says so.

use super::super::{Artifacts, Axes, Line, Row, Rows, VerifyError, largest};
use super::hausdorff::hausdorff;
use super::square::{Onset, Square, Tissue, length};
use glam::DVec2;
use rhexis::systems::fracture::Quality;

/// Cells along each side of the structured mesh; the other kinds have as many triangles. For multiples of 10 the notch ends in
/// a vertex, and edges lie along fibres at 45° and 90° through it.
const SIZES: [u32; 3] = [70, 90, 120];
const TISSUES: [Tissue; 3] = [Tissue::Fibres(45.0), Tissue::Fibres(90.0), Tissue::Isotropic];
/// Averaging radius of the scenes \[mm\].
const RADIUS: f64 = 1.5;
/// Paths nearer than this \[mm\] are the same: roundings of thousands of solves to 1e-4 of an increment.
const SAME: f64 = 1e-6;

/// A kind of mesh.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Kind {
    Structured,
    Rotated,
    Jittered,
    Unstructured,
}

impl Kind {
    /// All kinds.
    pub(crate) const ALL: [Self; 4] = [Self::Structured, Self::Rotated, Self::Jittered, Self::Unstructured];

    /// As a scene file writes it.
    pub(crate) fn mesh(self, cells: u32) -> String {
        // As many equilateral triangles as there are halves of square cells.
        let edge = 30.0 / f64::from(cells) * (2.0 / 3.0_f64.sqrt()).sqrt();
        let square = "corners = [[0, 0], [30, 0], [30, 30], [0, 30]]";
        let grid = format!("width = 30, height = 30, nx = {cells}, ny = {cells}");
        match self {
            Self::Structured => format!("{{ grid = {{ {grid} }} }}"),
            Self::Rotated => format!("{{ lattice = {{ {square}, edge = {edge}, degrees = 20 }} }}"),
            Self::Jittered => format!("{{ jittered = {{ {grid}, seed = 1 }} }}"),
            Self::Unstructured => format!("{{ unstructured = {{ {square}, edge = {edge}, seed = 1 }} }}"),
        }
    }
}

/// What a tear has left.
struct Torn {
    kind: Kind,
    cells: u32,
    edge: f64,
    path: Vec<DVec2>,
    onsets: Vec<Onset>,
}

impl Torn {
    fn new(scene: &str, mode: &str, tissue: Tissue, kind: Kind, cells: u32) -> Result<Self, VerifyError> {
        let mode = format!("bodies.0.tearing.mode={mode}");
        let mut square = Square::new(scene, &kind.mesh(cells), tissue, &[&mode, "run.steps=300"])?;
        square.approach()?;
        let is_through = square.tear_through()?;
        // A path that stops half way has no end to compare.
        let path = if is_through { square.path() } else { Vec::new() };
        Ok(Self { kind, cells, edge: square.edge, path, onsets: square.onsets })
    }

    fn load(&self) -> f64 {
        self.onsets.first().map_or(f64::NAN, |onset| onset.u)
    }

    /// Whether the disc at the tip, torn so far \[mm\], reaches neither gripped edge: nearer than the radius its stress is the
    /// clamp's, singular at the corner that the tear makes with it.
    fn is_off_the_grips(&self, torn: f64) -> bool {
        let mut left = torn;
        let tip = self.path.windows(2).find_map(|w| {
            let part = left / w[0].distance(w[1]);
            left -= w[0].distance(w[1]);
            (left <= 0.0).then(|| w[0].lerp(w[1], part))
        });
        tip.is_some_and(|tip| tip.x >= RADIUS && tip.x <= 30.0 - RADIUS)
    }

    /// The load at which the tear goes on at a length \[mm\], between two at which it has rested.
    fn load_at(&self, length: f64) -> Option<f64> {
        self.onsets.windows(2).find(|w| w[0].length <= length && length <= w[1].length).map(|w| {
            let part = (length - w[0].length) / (w[1].length - w[0].length);
            w[0].u + (w[1].u - w[0].u) * part
        })
    }
}

/// The dynamic scene, free mode.
pub(crate) fn run(out: &Artifacts) -> Result<Vec<Row>, VerifyError> {
    table(out, "tear-mesh", "fig2-tear", "free")
}

/// Equilibria, free mode.
pub(crate) fn stable(out: &Artifacts) -> Result<Vec<Row>, VerifyError> {
    table(out, "tear-mesh-stable", "fig2-tear-stable", "free")
}

/// The dynamic scene, edge mode.
pub(crate) fn edge(out: &Artifacts) -> Result<Vec<Row>, VerifyError> {
    table(out, "tear-mesh-edge", "fig2-tear", "edge")
}

fn table(out: &Artifacts, case: &'static str, scene: &str, mode: &str) -> Result<Vec<Row>, VerifyError> {
    let mut rows = Rows::new(case);
    let (tissues, kinds, sizes) = match out.is_quick() {
        true => (&TISSUES[2..], &[Kind::Structured, Kind::Unstructured][..], &SIZES[..1]),
        false => (&TISSUES[..], &Kind::ALL[..], &SIZES[..]),
    };
    for &tissue in tissues {
        let mut torn = Vec::new();
        for &cells in sizes {
            for &kind in kinds {
                torn.push(Torn::new(scene, mode, tissue, kind, cells)?);
            }
        }
        compare(&mut rows, &tissue.name(), &torn, sizes);
        let lengths = spread(torn.iter().map(|t| length(&t.path)));
        // A zigzag along edges is longer than the line it follows, on a lattice by up to 2/√3.
        let limit = if mode == "edge" { 2.0 / 3.0_f64.sqrt() - 1.0 } else { 0.05 };
        rows.ratio(format!("{}: spread of the length torn", tissue.name()), lengths, limit);
        if mode == "edge" {
            against_free(&mut rows, scene, tissue, &torn)?;
        }
        let line = |t: &Torn| Line { name: format!("{:?}, {} cells", t.kind, t.cells), points: t.path.clone() };
        let lines: Vec<Line> = torn.iter().map(line).collect();
        out.paths(&format!("{case}-{}", tissue.name()), &format!("{scene}, {mode} mode, {}", tissue.name()), &lines)?;
        if torn.iter().all(|t| t.onsets.len() > 2) {
            let points = |t: &Torn| t.onsets.iter().map(|o| DVec2::new(o.length, o.u)).collect();
            let loads: Vec<Line> =
                torn.iter().zip(&lines).map(|(t, l)| Line { name: l.name.clone(), points: points(t) }).collect();
            let title = format!("{scene}, {}: load over the tear", tissue.name());
            let axes = Axes { title: &title, names: ["torn [mm]", "u [mm]"], is_isometric: false };
            out.plot(&format!("{case}-load-{}", tissue.name()), axes, &loads)?;
        }
    }
    rows.finish()
}

/// The largest distance between two of the paths, in edges of the coarser of both.
fn in_edges<'t>(torn: impl IntoIterator<Item = &'t Torn> + Clone) -> f64 {
    let of = |a: &'t Torn| torn.clone().into_iter().map(move |b| hausdorff(&a.path, &b.path) / a.edge.max(b.edge));
    largest(torn.clone().into_iter().flat_map(of))
}

/// How far \[edges\] one advance may end off its ray, by the snap to a vertex that saves a thin triangle. Which advance meets such
/// a vertex is chance, so paths nearer than this are as near at any size; it falls with the edge.
fn snap() -> f64 {
    Quality::default().snap.sin()
}

fn compare(rows: &mut Rows, tissue: &str, torn: &[Torn], sizes: &[u32]) {
    rows.add(format!("{tissue}: paths on all meshes apart"), in_edges(torn), 2.0, "edges");
    let mut coarser = f64::INFINITY;
    for &cells in sizes {
        let of_size = torn.iter().filter(|t| t.cells == cells);
        let apart = in_edges(of_size.clone());
        let edge = of_size.clone().map(|t| t.edge).fold(0.0, f64::max);
        rows.note(format!("{tissue}: {cells} cells, paths apart"), apart, "edges");
        let what = format!("{tissue}: {cells} cells, paths apart, no more than on coarser meshes or a snap");
        rows.add(what, apart * edge, coarser.max(snap() * edge), "mm");
        coarser = apart * edge;
        let load = spread(of_size.map(Torn::load));
        rows.note(format!("{tissue}: {cells} cells, spread of the load of the first tear"), load, "1");
    }
    rows.ratio(format!("{tissue}: spread of the load of the first tear"), spread(torn.iter().map(Torn::load)), 0.05);
    // Where the tear rests often enough on every mesh, the whole curve.
    let at = |a: f64| torn.iter().map(|t| t.load_at(a)).collect::<Option<Vec<f64>>>().map(|loads| (a, spread(loads)));
    let spreads: Vec<(f64, f64)> = (0..60).filter_map(|i| at(0.5 * f64::from(i))).collect();
    let is_free = |&&(a, _): &&(f64, f64)| torn.iter().all(|t| t.is_off_the_grips(a));
    let free: Vec<(f64, f64)> = spreads.iter().filter(is_free).copied().collect();
    for (what, spreads, limit) in [("clear of the grips", free, 0.05), ("up to the grips", spreads, f64::INFINITY)] {
        if let (Some(first), Some(last)) = (spreads.first(), spreads.last()) {
            let what = format!("{tissue}: spread of the load from {} to {} mm torn, {what}", first.0, last.0);
            rows.ratio(what, largest(spreads.iter().map(|s| s.1)), limit);
        }
    }
}

/// (largest − smallest)/mean.
fn spread(values: impl IntoIterator<Item = f64>) -> f64 {
    let values: Vec<f64> = values.into_iter().collect();
    let (low, high) = values.iter().fold((f64::INFINITY, 0.0_f64), |(low, high), v| (low.min(*v), high.max(*v)));
    (high - low) / (values.iter().sum::<f64>() / values.len() as f64)
}

/// Edge mode against free mode on the same meshes.
fn against_free(rows: &mut Rows, scene: &str, tissue: Tissue, torn: &[Torn]) -> Result<(), VerifyError> {
    let (mut aligned, mut other) = (0.0_f64, 0.0_f64);
    for edge in torn {
        let free = Torn::new(scene, "free", tissue, edge.kind, edge.cells)?;
        let apart = hausdorff(&edge.path, &free.path);
        match (tissue, edge.kind) {
            (Tissue::Fibres(_), Kind::Structured) => aligned = largest([aligned, apart]),
            _ => other = largest([other, apart / edge.edge]),
        }
    }
    let tissue = tissue.name();
    rows.add(format!("{tissue}: off free mode where edges lie along the fibre"), aligned, SAME, "mm");
    rows.add(format!("{tissue}: off free mode on other meshes"), other, 2.0, "edges");
    Ok(())
}
