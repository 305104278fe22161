//! The load at which a crack tears, against that which its stress intensity and R predict: the criterion on the singular
//! field averaged over the disc.

use super::super::reference::{Json, file};
use super::super::{Artifacts, Axes, Line, Row, Rows, VerifyError};
use super::contour::Contour;
use super::cracked::{Cracked, Pattern, Tissue, between_grips, refined, under_tension};
use crate::components::{Material, Tearing};
use crate::event::EventKind;
use crate::math::CrackTip;
use crate::membrane::{BodyError, Membrane};
use crate::storage::TriangleMesh;
use crate::systems::kernels::failure::{Cone, evaluate};
use crate::systems::tearing::strength;
use glam::DVec2;
use std::f64::consts::TAU;

/// Stress at the tips \[MPa\] or strain between the grips: small, so that everything is proportional to the load.
const SMALL: f64 = 1e-4;
/// What is asked at four edges per R.
const TOLERANCE: f64 = 0.05;

/// A sheet of which the stress intensity is known.
struct Sheet {
    name: String,
    tissue: Tissue,
    size: DVec2,
    crack: [DVec2; 2],
    /// Crack length, or half of it where it has two tips \[mm\].
    length: f64,
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

pub fn run(out: &Artifacts) -> Result<Vec<Row>, VerifyError> {
    let mut rows = Rows::new("tear-load");
    let sheets = sheets()?;
    let (sheets, patterns) =
        if out.is_quick() { (&sheets[..1], &Pattern::ALL[..1]) } else { (&sheets[..], &Pattern::ALL[..]) };
    for sheet in sheets {
        let mut lines = Vec::new();
        for &pattern in patterns {
            lines.extend(resolutions(&mut rows, sheet, pattern, out.is_quick())?);
        }
        let title = format!("tear load, {}", sheet.name);
        let axes = Axes { title: &title, names: ["edges per R", "load above prediction [%]"], is_isometric: false };
        let name: String = sheet.name.chars().map(|c| if c.is_alphanumeric() { c } else { '-' }).collect();
        out.plot(&format!("tear-load-{name}"), axes, &lines)?;
    }
    if let Some(sheet) = sheets.first() {
        sheet.bisect(&mut rows)?;
    }
    rows.finish()
}

/// Loads of one sheet on one pattern of mesh: the disc average's and that of the energy released.
fn resolutions(rows: &mut Rows, sheet: &Sheet, pattern: Pattern, is_quick: bool) -> Result<Vec<Line>, VerifyError> {
    let radius = sheet.tissue.tearing.radius;
    let what = format!("{}, {}", sheet.name, pattern.name());
    let mut lines = ["disc", "energy"].map(|by| Line { name: format!("{by}, {}", pattern.name()), points: Vec::new() });
    let edges: &[f64] = if is_quick { &[4.0] } else { &[2.0, 3.0, 4.0] };
    for &edges in edges {
        let mesh = pattern.mesh(sheet.size, radius / edges)?;
        let found = sheet.loads(mesh, None)?;
        let what = format!("{what}, R = {radius} mm, {edges} edges per R");
        match edges {
            4.0 => rows.ratio(format!("{what}: tear load"), found.disc.abs(), TOLERANCE),
            _ => rows.note(format!("{what}: tear load"), found.disc.abs(), "1"),
        }
        rows.note(format!("{what}: load by energy released"), found.energy.abs(), "1");
        for (line, error) in lines.iter_mut().zip([found.disc, found.energy]) {
            line.points.push(DVec2::new(edges, 100.0 * error));
        }
    }
    // A disc half as large, on a mesh that is fine around the tip only.
    let mut small = sheet.clone_with_radius(0.5 * radius);
    small.name.push_str(", small disc");
    let found = small.loads(pattern.mesh(sheet.size, 0.5 * radius)?, Some(1.5 * radius))?;
    let what = format!("{what}, R = {} mm, refined from 1 edge per R to 4", 0.5 * radius);
    rows.ratio(format!("{what}: tear load"), found.disc.abs(), TOLERANCE);
    rows.note(format!("{what}: load by energy released"), found.energy.abs(), "1");
    Ok(lines.into())
}

/// How far the loads at which a tear begins lie above those predicted, relatively.
struct Found {
    disc: f64,
    energy: f64,
}

impl Sheet {
    fn clone_with_radius(&self, radius: f64) -> Self {
        let tissue = Tissue { tearing: Tearing { radius, ..self.tissue.tearing }, ..self.tissue };
        Self { name: self.name.clone(), tissue, ..*self }
    }

    fn membrane(&self, mesh: TriangleMesh, load: Load) -> Membrane {
        let membrane = self.tissue.membrane(mesh);
        match load {
            Load::Tension(stress) => under_tension(membrane, self.size, stress, self.tissue.material.thickness),
            Load::Grips(u) => between_grips(membrane, self.size.x, u),
        }
    }

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

    /// Solves on a mesh, which may be refined around the tip so far beyond the disc \[mm\].
    fn loads(&self, mesh: TriangleMesh, margin: Option<f64>) -> Result<Found, VerifyError> {
        let membrane = self.membrane(mesh, self.load);
        let membrane = match margin {
            Some(margin) => membrane.with(refined(4.0, margin)),
            None => membrane,
        };
        let mut cracked = Cracked::new(membrane, self.crack)?;
        let solved = cracked.solve()?;
        let predicted = self.predicted()?;
        let release = self.tip_field()?.energy_release(self.intensity, 0.0);
        let mut found = Found { disc: f64::NAN, energy: f64::NAN };
        // The criterion grows with the load, the energy released with its square; a centre crack tears at the weaker tip.
        if let Some(tip) = cracked.tips()?.into_iter().max_by(|a, b| a.value.total_cmp(&b.value)) {
            let radius = self.tissue.tearing.radius;
            let contour = Contour::around(&cracked, &solved.displacement, &tip, &self.tissue, radius)?;
            found.disc = predicted / tip.value - 1.0;
            found.energy = (release / contour.release).sqrt() - 1.0;
        }
        Ok(found)
    }

    /// Whether the sheet tears at so many times the load, in a nonlinear equilibrium.
    fn tears_at(&self, mesh: &TriangleMesh, times: f64) -> Result<bool, VerifyError> {
        let load = match self.load {
            Load::Tension(stress) => Load::Tension(stress * times),
            Load::Grips(u) => Load::Grips(u * times),
        };
        let mut cracked = Cracked::new(self.membrane(mesh.clone(), load), self.crack)?;
        cracked.simulation.settle_and_tear(1.0, 1e-9, 1)?;
        let has_advanced = cracked.simulation.drain_events().any(|e| matches!(e.kind, EventKind::Advanced { .. }));
        Ok(has_advanced)
    }

    /// The load at which the nonlinear sheet begins to tear lies where the linear one says.
    fn bisect(&self, rows: &mut Rows) -> Result<(), VerifyError> {
        let pattern = Pattern::Structured;
        let mesh = pattern.mesh(self.size, self.tissue.tearing.radius / 4.0)?;
        let wanted = (1.0 + self.loads(mesh.clone(), None)?.disc) / self.predicted()?;
        let (mut low, mut high) = (0.9 * wanted, 1.1 * wanted);
        if self.tears_at(&mesh, low)? || !self.tears_at(&mesh, high)? {
            rows.add(
                format!("{}: tears between 0.9 and 1.1 of the load of the linear solve", self.name),
                f64::NAN,
                0.0,
                "1",
            );
            return Ok(());
        }
        while high - low > 2e-3 * wanted {
            let middle = 0.5 * (low + high);
            if self.tears_at(&mesh, middle)? { high = middle } else { low = middle }
        }
        // Half an interval of the bisection, and strains of 1e-3 where the disc begins.
        rows.relative(format!("{}: load by bisection of equilibria", self.name), 0.5 * (low + high), wanted, 5e-3);
        Ok(())
    }
}

/// Plates under tension (isotropic; K_I by converged elements, Tada and Feddersen within 0.6 %) and a square between grips
/// with fibres along and across its crack (K_I from the energy released).
fn sheets() -> Result<Vec<Sheet>, VerifyError> {
    let (name, text) = file!("energy_release.json");
    let file = Json::new(name, text)?;
    let mut sheets = Vec::new();
    // The edge crack over half the width and the centre crack as long as half of it: those that need the fewest triangles.
    for (row, name) in [(4, "edge crack"), (5, "centre crack")] {
        let number = |key: &str| file.number(&format!("/plates/table/{row}/{key}"));
        let (length, size) = (number("a")?, DVec2::new(number("W")?, number("H")?));
        let middle = 0.5 * size;
        let start = if row == 4 { DVec2::new(0.0, middle.y) } else { middle - DVec2::X * length };
        let end = if row == 4 { DVec2::new(length, middle.y) } else { middle + DVec2::X * length };
        // A thousandth of Young's modulus.
        let tissue = Tissue::isotropic(3e-3, 0.1 * length);
        let intensity = number("K_I_FE")? * SMALL / number("sigma")?;
        let (name, load) = (format!("{name}, isotropic"), Load::Tension(SMALL));
        let crack = [start, end];
        sheets.push(Sheet { name, tissue, size, crack, length, fibre_to_crack: 0.0, load, intensity });
    }
    let side = file.number("/fixed_grips/L")?;
    // Strong fibres along the crack keep it straight; across it, where one would turn, both strengths are the same.
    for (case, fibre_degrees, ratio, name) in [(3, 90.0, 16.0, "along"), (1, 0.0, 1.0, "across")] {
        let number = |key: &str| file.number(&format!("/fixed_grips/cases/{case}/table/4/{key}"));
        let length = number("a")?;
        let tearing = Tearing {
            strength_fibre: 1e-3 * ratio,
            strength_transverse: 1e-3,
            radius: 0.1 * length,
            ..Tearing::default()
        };
        let tissue = Tissue { material: Material::figure_2(), fibre_degrees, tearing };
        let middle = 0.5 * side;
        let mut sheet = Sheet {
            name: format!("edge crack, fibres {name} it"),
            tissue,
            size: DVec2::splat(side),
            crack: [DVec2::new(middle, 0.0), DVec2::new(middle, length)],
            length,
            fibre_to_crack: fibre_degrees - 90.0,
            load: Load::Grips(file.number("/fixed_grips/u")?),
            intensity: 0.0,
        };
        sheet.intensity = (number("G_N_per_mm")? / sheet.tip_field()?.energy_release(1.0, 0.0)).sqrt();
        sheets.push(sheet);
    }
    Ok(sheets)
}
