//! The stress at a crack's tip: its average over the averaging disc, as the criterion sees it, against that of the
//! continuum (`tip_disc_average.json`: the whole field, not its singular part alone).

use super::super::reference::{Json, file};
use super::super::{Artifacts, Axes, Line, Row, Rows, VerifyError, largest};
use super::cracked::{Cracked, Pattern, Tip, Tissue, between_grips, even, refined};
use glam::DVec2;
use rhexis::components::{Material, Tearing};
use rhexis::math::Sym2;
use rhexis::simulation::SimulationError;

/// Averaging radius over edge of the meshes; three is where the engine begins to call a disc resolved.
const EDGES: [f64; 3] = [3.0, 4.0, 6.0];
/// What is asked of resolved discs: an error of the mesh alone, which linear triangles make at their singular tip.
const RESOLVED: f64 = 0.05;
/// What is asked where the mesh was fine around the tip only: the coarse one around adds its own error.
const REFINED: f64 = 0.1;

/// The reference square with one tissue and averaging radius.
struct Square {
    name: String,
    tissue: Tissue,
    /// Mean stress \[MPa\] in x and y; the crack opens along x.
    wanted: Sym2,
    /// Energy released per area \[N/mm\], if the crack goes straight on.
    release: f64,
}

pub(crate) fn run(out: &Artifacts) -> Result<Vec<Row>, VerifyError> {
    let mut rows = Rows::new("tear-tip-stress");
    let (name, text) = file!("tip_disc_average.json");
    let file = Json::new(name, text)?;
    let (side, crack, u) = (file.number("/L")?, file.number("/a")?, file.number("/u")?);
    // The tip, and how far the energy released would lead the load astray that makes it critical.
    let find = |square: &Square, mesh, refinement| -> Result<(Tip, f64), VerifyError> {
        let tissue = &square.tissue;
        let mut membrane = between_grips(tissue.membrane(mesh), side, u);
        if let Some(refinement) = refinement {
            membrane = membrane.with(refinement);
        }
        let middle = 0.5 * side;
        let mut cracked = Cracked::new(membrane, [DVec2::new(middle, 0.0), DVec2::new(middle, crack)])?;
        cracked.solve()?;
        let tip = cracked.tips(even(1.0))?.into_iter().next().ok_or(SimulationError::NoSuchBody)?;
        Ok((tip, ((square.release / tip.release).sqrt() - 1.0).abs()))
    };
    let (radii, patterns) = if out.is_quick() {
        (&[2][..], &[Pattern::Structured, Pattern::Unstructured][..])
    } else {
        (&[0, 1, 2][..], &Pattern::ALL[..])
    };
    for &radius in radii {
        let squares = squares(&file, radius)?;
        let Some(r) = squares.first().map(|square| square.tissue.tearing.radius) else { continue };
        let mut curves: Vec<Line> = Vec::new();
        for &pattern in patterns {
            let meshes = EDGES.map(|edges| pattern.mesh(DVec2::splat(side), r / edges));
            let meshes = meshes.into_iter().collect::<Result<Vec<_>, _>>()?;
            let coarse = pattern.mesh(DVec2::splat(side), r)?;
            for square in &squares {
                let what = format!("{}, R = {r} mm, {}", square.name, pattern.name());
                let mut points = Vec::new();
                for mesh in &meshes {
                    let (tip, energy) = find(square, mesh.clone(), None)?;
                    rows.ratio(
                        format!("{what}, {:.1} edges per R", tip.edges_per_radius),
                        square.error(&tip),
                        RESOLVED,
                    );
                    let what = format!("{what}, {:.1} edges per R: load by energy released", tip.edges_per_radius);
                    rows.note(what, energy, "1");
                    points.push(DVec2::new(tip.edges_per_radius, 100.0 * (tip.stress.xx / square.wanted.xx - 1.0)));
                }
                curves.push(Line { name: format!("{}, {}", square.name, pattern.name()), points });
                let (tip, _) = find(square, coarse.clone(), None)?;
                rows.note(format!("{what}, {:.1} edges per R", tip.edges_per_radius), square.error(&tip), "1");
                let (tip, energy) = find(square, coarse.clone(), Some(refined(4.0, 0.5 * r)))?;
                let what = format!("{what}, refined from 1 edge per R to {:.1}", tip.edges_per_radius);
                rows.ratio(what.clone(), square.error(&tip), REFINED);
                rows.note(format!("{what}: load by energy released"), energy, "1");
            }
        }
        let title = format!("opening stress at the tip, mean over {r} mm");
        let axes = Axes { title: &title, names: ["edges per R", "error [%]"], is_isometric: false };
        out.plot(&format!("tear-tip-stress-{r}mm"), axes, &curves)?;
    }
    rows.finish()
}

/// Both tissues of the file with its `radius`th averaging radius.
fn squares(file: &Json, radius: usize) -> Result<Vec<Square>, VerifyError> {
    let (name, text) = file!("energy_release.json");
    let releases = Json::new(name, text)?;
    let square = |[case, row]: [usize; 2], name: &str, material: Material, fibre_degrees: f64| {
        // The same crack in the same square.
        let release = releases.number(&format!("/fixed_grips/cases/{row}/table/2/G_N_per_mm"))?;
        let at = format!("/cases/{case}/rows/{radius}");
        let r = file.number(&format!("{at}/r"))?;
        let stress = file.numbers(&format!("{at}/average_sxx_syy_sxy"))?;
        let &[xx, yy, xy] = &stress[..] else { return Ok(None) };
        let tearing = Tearing { radius: r, ..Tearing::default() };
        let tissue = Tissue { material, fibre_degrees, tearing };
        Ok::<_, VerifyError>(Some(Square { name: name.to_owned(), tissue, wanted: Sym2::new(xx, yy, xy), release }))
    };
    let both = [
        square([0, 0], "isotropic", Material::isotropic(3.0, 0.3, 0.1), 0.0)?,
        square([1, 2], "fibres at 45°", Material::allard_2009(), 45.0)?,
    ];
    Ok(both.into_iter().flatten().collect())
}

impl Square {
    /// The largest error of a component over the opening stress.
    fn error(&self, tip: &Tip) -> f64 {
        let off = tip.stress - self.wanted;
        largest([off.xx, off.yy, off.xy].map(f64::abs)) / self.wanted.xx
    }
}
