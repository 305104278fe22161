//! What a tear leaves of the mesh: angles, the number of triangles, area and mass.
//!
//! Tears on four kinds of mesh, along fibres at five angles and without fibres, in free mode: edge mode changes no triangle.

use super::super::{Artifacts, Row, Rows, VerifyError, largest};
use super::hausdorff::distance;
use super::mesh::Kind;
use super::square::{Square, Tissue, length};
use glam::DVec2;
use rhexis::storage::measure::{rest_angles, rest_corners, total_area, total_mass};
use rhexis::storage::{Triangles, Vertices};

/// Cells along each side of the structured mesh.
const CELLS: u32 = 70;
const TISSUES: [Tissue; 6] = [
    Tissue::Isotropic,
    Tissue::Fibres(30.0),
    Tissue::Fibres(45.0),
    Tissue::Fibres(60.0),
    Tissue::Fibres(75.0),
    Tissue::Fibres(90.0),
];

/// A mesh in figures.
struct Figures {
    /// Smallest angle \[°\].
    least: f64,
    /// One triangle in a hundred of those near the tear has a smaller angle \[°\]: the rest of the mesh would hide them.
    first_percentile: f64,
    triangle_count: usize,
    area: f64,
    mass: f64,
}

impl Figures {
    fn of(square: &Square, path: &[DVec2]) -> Option<Self> {
        let world = square.instance.simulation.world();
        let (vertices, triangles) = (
            world.get::<&Vertices>(square.body().entity()).ok()?,
            world.get::<&Triangles>(square.body().entity()).ok()?,
        );
        // Two edges: triangles that the tear has changed, and their neighbours.
        let is_near = |corners: &[u32; 3]| {
            let x = rest_corners(&vertices, *corners);
            distance(((x[0] + x[1] + x[2]) / 3.0).truncate(), path) < 2.0 * square.edge
        };
        let all = || rest_angles(&vertices, &triangles).map(f64::to_degrees);
        let mut near: Vec<f64> = all().zip(&triangles.corners).filter(|(_, c)| is_near(c)).map(|(a, _)| a).collect();
        near.sort_by(f64::total_cmp);
        Some(Self {
            least: all().fold(f64::INFINITY, f64::min),
            first_percentile: near.get(near.len() / 100).copied().unwrap_or(f64::NAN),
            triangle_count: triangles.len(),
            area: total_area(&triangles),
            mass: total_mass(&vertices),
        })
    }
}

pub(crate) fn run(out: &Artifacts) -> Result<Vec<Row>, VerifyError> {
    let mut rows = Rows::new("tear-quality");
    let (tissues, cells) = if out.is_quick() { (&TISSUES[..1], 40) } else { (&TISSUES[..], CELLS) };
    for kind in Kind::ALL {
        let (mut start, mut least, mut percentile) = (f64::INFINITY, f64::INFINITY, f64::INFINITY);
        let (mut growth, mut drift) = (0.0_f64, 0.0_f64);
        for &tissue in tissues {
            let mut square = Square::new("fig2-tear", &kind.mesh(cells), tissue, &["run.steps=300"])?;
            let before = Figures::of(&square, &[]);
            square.approach()?;
            let is_through = square.tear_through()?;
            let path = square.path();
            let (Some(before), Some(after), true) = (before, Figures::of(&square, &path), is_through) else {
                rows.add(format!("{kind:?}, {}: torn through", tissue.name()), f64::NAN, 0.0, "1");
                continue;
            };
            start = start.min(before.least);
            least = least.min(after.least);
            percentile = percentile.min(after.first_percentile);
            let added = after.triangle_count.abs_diff(before.triangle_count) as f64;
            growth = largest([growth, added * square.edge / length(&path)]);
            drift = largest([drift, (after.area / before.area - 1.0).abs(), (after.mass / before.mass - 1.0).abs()]);
        }
        // Angles are asked to be large: what is missing to the mark.
        rows.note(format!("{kind:?}: smallest angle with the notch, before the tears"), start, "°");
        rows.note(format!("{kind:?}: smallest angle after"), least, "°");
        rows.note(format!("{kind:?}: first percentile within two edges of the tears"), percentile, "°");
        let missing = |mark: f64, angle: f64| if angle.is_nan() { angle } else { (mark - angle).max(0.0) };
        rows.add(format!("{kind:?}: smallest angle after, short of 10°"), missing(10.0, least), 0.0, "°");
        rows.add(format!("{kind:?}: first percentile after, short of 18°"), missing(18.0, percentile), 0.0, "°");
        rows.ratio(format!("{kind:?}: triangles added per edge length torn"), growth, 8.0);
        // Sums of some ten thousand triangles, in another order after the tear.
        rows.ratio(format!("{kind:?}: change of area and mass"), drift, 1e-12);
    }
    rows.finish()
}
