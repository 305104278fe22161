//! The load at which a crack tears, against that which its stress intensity and R predict: the criterion on the singular
//! field averaged over the disc. Beside it the load at which the criterion on energy tears, against the same criterion on the
//! singular field itself.

use super::super::reference::{Json, file};
use super::super::{Artifacts, Axes, Line, Row, Rows, VerifyError, largest};
use super::cracked::{Cracked, Pattern, Tissue, between_grips, refined, under_tension};
use glam::DVec2;
use rhexis::components::{EnergyCriterion, Material, Tearing, Toughness};
use rhexis::event::EventKind;
use rhexis::math::CrackTip;
use rhexis::membrane::BodyError;
use rhexis::systems::fracture::{EnergyTerms, strength};
use rhexis::systems::kernels::failure::{Cone, TipField, evaluate, evaluate_release};
use std::f64::consts::TAU;

/// Tension \[MPa\] and strengths \[MPa\]: a ten-thousandth of Young's modulus and less, so that everything is proportional to
/// the load.
const SMALL: f64 = 1e-4;
const STRENGTH: f64 = 3e-4;
/// Edges per R; from three on the engine calls a disc resolved.
const EDGES: [f64; 3] = [2.0, 2.8, RESOLVED];
/// Where the comparison is judged.
const RESOLVED: f64 = 4.0;
/// How far beyond R a refined mesh is as fine as in it, in R.
const MARGIN: f64 = 3.0;
/// What is asked at four edges per R.
const TOLERANCE: f64 = 0.05;
/// Of energy, which does not feel the field beyond the singular one: R/a of up to a tenth leaves 1 %.
const BY_ENERGY: f64 = 0.02;

/// Of the material force against the ring: ahead both are J, by one set of elements on nearly the same disc. Isotropic they differ by 0.2 %;
/// with fibres across, whose stress changes within an edge, by 0.8 %.
const BY_FORCE: f64 = 0.01;

/// A sheet of which the stress intensity is known.
struct Sheet {
    name: String,
    tissue: Tissue,
    size: DVec2,
    crack: [DVec2; 2],
    /// Whether the mesh is fine around the tips only; elsewhere an edge is as long as R.
    is_refined: bool,
    /// Angle of the fibres from the crack's direction \[°\].
    fibre_to_crack: f64,
    load: Load,
    /// K_I under the load \[MPa·√mm\].
    intensity: f64,
}

#[derive(Clone, Copy)]
enum Load {
    /// Tension along y \[MPa\].
    Tension(f64),
    /// Displacement of each grip along x \[mm\].
    Grips(f64),
}

pub(crate) fn run(out: &Artifacts) -> Result<Vec<Row>, VerifyError> {
    let mut rows = Rows::new("tear-load");
    let sheets = sheets()?;
    let (sheets, patterns, edges) = match out.is_quick() {
        true => (&sheets[..4], &Pattern::ALL[..1], &EDGES[2..]),
        false => (&sheets[..], &Pattern::ALL[..], &EDGES[..]),
    };
    // Per entry of `edges`.
    let mut all: Vec<Vec<Found>> = vec![Vec::new(); edges.len()];
    for sheet in sheets {
        let mut lines = Vec::new();
        let mut of_sheet = Vec::new();
        for &pattern in patterns {
            let mut found = Vec::new();
            for (&edges, all) in edges.iter().zip(&mut all) {
                let one = sheet.loads(pattern, edges)?;
                one.judge(&mut rows, &format!("{}, {}", sheet.name, pattern.name()), edges == RESOLVED);
                found.push(one);
                all.push(one);
            }
            lines.extend(Found::BY.map(|(by, error)| {
                let point = |found: &Found| DVec2::new(found.edges_per_radius, 100.0 * error(found));
                Line { name: format!("{by}, {}", pattern.name()), points: found.iter().map(point).collect() }
            }));
            of_sheet.extend(found);
        }
        // The criterion sees more than the singular field; what the mesh does to it shows in the spread.
        for (by, error) in Found::BY.into_iter().filter(|_| of_sheet.len() > 1) {
            let errors = || of_sheet.iter().map(error);
            let spread = errors().fold(f64::MIN, f64::max) - errors().fold(f64::MAX, f64::min);
            rows.note(format!("{}: spread of the load over all meshes, by {by}", sheet.name), spread, "1");
        }
        let title = format!("tear load, {}", sheet.name);
        let axes = Axes { title: &title, names: ["edges per R", "load above prediction [%]"], is_isometric: false };
        let name = sheet.name.replace([',', ' ', '=', '/'], "");
        out.plot(&format!("tear-load-{name}"), axes, &lines)?;
    }
    for (edges, found) in edges.iter().zip(&all) {
        for (by, error) in Found::BY {
            let worst = largest(found.iter().map(|found| error(found).abs()));
            rows.note(format!("all sheets, at least {edges} edges per R: tear load by {by}, worst"), worst, "1");
        }
    }
    if let Some(sheet) = sheets.first() {
        sheet.bisect(&mut rows)?;
    }
    rows.finish()
}

/// How far the loads at which a tear begins lie above those predicted, and the release by the material force above that by the ring,
/// relatively.
#[derive(Clone, Copy)]
struct Found {
    edges_per_radius: f64,
    disc: f64,
    energy: f64,
    force: f64,
}

/// By what, and by how much it is off.
type Reading = (&'static str, fn(&Found) -> f64);

impl Found {
    const BY: [Reading; 2] = [("disc average", |found| found.disc), ("energy", |found| found.energy)];

    fn judge(&self, rows: &mut Rows, what: &str, is_resolved: bool) {
        for ((by, error), tolerance) in Self::BY.into_iter().zip([TOLERANCE, BY_ENERGY]) {
            let limit = if is_resolved { tolerance } else { f64::INFINITY };
            let what = format!("{what}, {:.1} edges per R: tear load by {by}", self.edges_per_radius);
            rows.ratio(what, error(self).abs(), limit);
        }
        let limit = if is_resolved { BY_FORCE } else { f64::INFINITY };
        let what =
            format!("{what}, {:.1} edges per R: release by the material force, off the ring's", self.edges_per_radius);
        rows.ratio(what, self.force.abs(), limit);
    }
}

impl Sheet {
    fn tip_field(&self) -> Result<CrackTip, VerifyError> {
        let law = self.tissue.material.stiffness().map_err(|source| BodyError::Material { triangle: 0, source })?;
        Ok(CrackTip::new(&law, self.fibre_to_crack.to_radians()))
    }

    /// The criterion under the load, as K_I and R predict it.
    fn predicted(&self) -> Result<f64, VerifyError> {
        let tearing = &self.tissue.tearing;
        let scale = self.intensity / (TAU * tearing.radius).sqrt();
        let stress = self.tip_field()?.disc_average().opening * scale;
        let fibre = DVec2::from_angle(self.fibre_to_crack.to_radians());
        let cone = Cone { previous: DVec2::X, half_angle: tearing.cone };
        let answer = evaluate(stress, fibre, &strength(tearing), Some(cone), None);
        Ok(answer.map_or(f64::NAN, |answer| answer.best.value))
    }

    /// A toughness that K_I reaches straight ahead, in the ratio of the squared strengths.
    fn toughness(&self) -> Result<Toughness, VerifyError> {
        let Tearing { strength_across_fibres, strength_along_fibres, .. } = self.tissue.tearing;
        let release = self.tip_field()?.energy_release(self.intensity, 0.0);
        let across = release * (strength_across_fibres / strength_along_fibres).powi(2);
        Ok(Toughness { along: release, across })
    }

    /// The criterion on energy under the load, as K_I predicts it.
    fn predicted_by_energy(&self) -> Result<f64, VerifyError> {
        let law = self.tissue.material.stiffness().map_err(|source| BodyError::Material { triangle: 0, source })?;
        let fibre = DVec2::from_angle(self.fibre_to_crack.to_radians());
        let field = TipField { law, fibre, ahead: DVec2::X, intensities: [self.intensity, 0.0] };
        let (tearing, energy) = (&self.tissue.tearing, &EnergyCriterion::new(self.toughness()?));
        let cone = Cone { previous: DVec2::X, half_angle: tearing.cone };
        let answer = evaluate_release(&field, &EnergyTerms { tearing, energy }.toughness(), Some(cone), None);
        Ok(answer.map_or(f64::NAN, |answer| answer.best.value))
    }

    /// The sheet on a mesh with so many edges per R at the tips, under so many times its load.
    fn cracked(&self, pattern: Pattern, edges: f64, times: f64) -> Result<Cracked, VerifyError> {
        let radius = self.tissue.tearing.radius;
        let far = if self.is_refined { 1.0 } else { edges };
        let mut membrane = self.tissue.membrane(pattern.mesh(self.size, radius / far)?);
        membrane = match self.load {
            Load::Tension(stress) => under_tension(membrane, self.size, times * stress, self.tissue.material.thickness),
            Load::Grips(u) => between_grips(membrane, self.size.x, times * u),
        };
        if self.is_refined {
            membrane = membrane.with(refined(edges, MARGIN * radius));
        }
        Cracked::new(membrane, self.crack)
    }

    fn loads(&self, pattern: Pattern, edges: f64) -> Result<Found, VerifyError> {
        let mut cracked = self.cracked(pattern, edges, 1.0)?;
        cracked.solve()?;
        let mut found = Found { edges_per_radius: f64::NAN, disc: f64::NAN, energy: f64::NAN, force: f64::NAN };
        // Both criteria grow with the load; a centre crack tears at the weaker tip.
        if let Some(tip) = cracked.tips(self.toughness()?)?.into_iter().max_by(|a, b| a.value.total_cmp(&b.value)) {
            found.edges_per_radius = tip.edges_per_radius;
            found.disc = self.predicted()? / tip.value - 1.0;
            let by_energy = tip.by_energy.map_or(f64::NAN, |(_, value)| value);
            found.energy = self.predicted_by_energy()? / by_energy - 1.0;
            found.force = tip.by_force / tip.release - 1.0;
        }
        Ok(found)
    }

    /// Whether the sheet tears at so many times the load, in a nonlinear equilibrium.
    fn tears_at(&self, times: f64) -> Result<bool, VerifyError> {
        let mut cracked = self.cracked(Pattern::Structured, RESOLVED, times)?;
        cracked.simulation.settle_and_tear(1.0, 1e-9, 1)?;
        let has_advanced = cracked.simulation.drain_events().any(|e| matches!(e.kind, EventKind::Advanced { .. }));
        Ok(has_advanced)
    }

    /// The load at which the nonlinear sheet begins to tear lies where the linear one says.
    fn bisect(&self, rows: &mut Rows) -> Result<(), VerifyError> {
        let wanted = (1.0 + self.loads(Pattern::Structured, RESOLVED)?.disc) / self.predicted()?;
        let (mut low, mut high) = (0.98 * wanted, 1.02 * wanted);
        let what = format!("{}: load by bisection of equilibria", self.name);
        if self.tears_at(low)? || !self.tears_at(high)? {
            rows.ratio(format!("{what}, not near that of the linear solve"), f64::NAN, 0.0);
            return Ok(());
        }
        while high - low > 1e-3 * wanted {
            let middle = 0.5 * (low + high);
            *if self.tears_at(middle)? { &mut high } else { &mut low } = middle;
        }
        // Half an interval of the bisection, and strains of 5e-4 near the tip.
        rows.relative(what, 0.5 * (low + high), wanted, 2e-3);
        Ok(())
    }
}

/// Plates under tension (isotropic; K_I by converged elements, Tada and Feddersen within 0.6 %) and a square between grips
/// with fibres along and across its crack (K_I from the energy released).
fn sheets() -> Result<Vec<Sheet>, VerifyError> {
    let (name, text) = file!("energy_release.json");
    let file = Json::new(name, text)?;
    Ok(vec![
        plate(&file, EDGE, 20.0)?,
        plate(&file, CENTRE, 20.0)?,
        square(&file, 3)?,
        square(&file, 1)?,
        plate(&file, EDGE, 10.0)?,
        plate(&file, CENTRE, 10.0)?,
    ])
}

/// Rows of the file: an edge crack over a quarter of the width, a centre crack as long as half of it. Both are 5 mm from tip to
/// rim or middle, and R is short against what is left of the width.
const EDGE: usize = 2;
const CENTRE: usize = 5;

fn plate(file: &Json, row: usize, parts: f64) -> Result<Sheet, VerifyError> {
    let number = |key: &str| file.number(&format!("/plates/table/{row}/{key}"));
    let (length, size) = (number("a")?, DVec2::new(number("W")?, number("H")?));
    let middle = 0.5 * size;
    let (kind, start, end) = match row {
        EDGE => ("edge", DVec2::new(0.0, middle.y), DVec2::new(length, middle.y)),
        _ => ("centre", middle - DVec2::X * length, middle + DVec2::X * length),
    };
    Ok(Sheet {
        name: format!("{kind} crack, isotropic, R = a/{parts}"),
        tissue: Tissue::isotropic(STRENGTH, length / parts),
        size,
        crack: [start, end],
        is_refined: parts > 10.0,
        fibre_to_crack: 0.0,
        load: Load::Tension(SMALL),
        intensity: number("K_I_FE")? * SMALL / number("sigma")?,
    })
}

/// Half of the square is cut. Fibres across the crack carry its opening to the grips, so that the tip's own field does not
/// reach far. Averaged over a tenth of the crack the stress exceeds it by 10 %, over a fiftieth by 1.5 %, over a hundredth by
/// 0.5 % (structured meshes with four edges per R). Hence the small disc.
fn square(file: &Json, case: usize) -> Result<Sheet, VerifyError> {
    let at = format!("/fixed_grips/cases/{case}");
    let number = |key: &str| file.number(&format!("{at}/table/4/{key}"));
    let (side, length, fibre_degrees) =
        (file.number("/fixed_grips/L")?, number("a")?, file.number(&format!("{at}/theta_deg"))?);
    let is_along = fibre_degrees == 90.0;
    // Strong fibres along the crack keep it straight; across it, where it would turn, both strengths are the same.
    let strength_across_fibres = if is_along { 16.0 * STRENGTH } else { STRENGTH };
    let tearing = Tearing {
        strength_across_fibres,
        strength_along_fibres: STRENGTH,
        radius: length / 50.0,
        ..Tearing::default()
    };
    let mut sheet = Sheet {
        name: format!("edge crack, fibres {} it, R = a/50", if is_along { "along" } else { "across" }),
        tissue: Tissue { material: Material::allard_2009(), fibre_degrees, tearing },
        size: DVec2::splat(side),
        crack: [DVec2::new(0.5 * side, 0.0), DVec2::new(0.5 * side, length)],
        is_refined: true,
        fibre_to_crack: fibre_degrees - 90.0,
        load: Load::Grips(file.number("/fixed_grips/u")?),
        intensity: 0.0,
    };
    sheet.intensity = (number("G_N_per_mm")? / sheet.tip_field()?.energy_release(1.0, 0.0)).sqrt();
    Ok(sheet)
}
