//! The kink of slanted centre cracks: where the criterion turns, against what it says of the analytic field averaged over
//! the same disc, the stress parallel to the crack included.
//!
//! In a wide plate under the tension σ at the angle β to the crack, K_I = σ√(πa)·sin²β, K_II = σ√(πa)·sin β·cos β, and the
//! stress parallel to the crack exceeds its singular part by T = σ(cos²β − sin²β), a tenth of σ√(a/R) and more.

use super::super::reference::{csv, file};
use super::super::{Artifacts, Axes, Line, Row, Rows, VerifyError};
use super::contour::Contour;
use super::cracked::{Cracked, Pattern, Tissue, refined, under_tension};
use crate::math::{CrackTip, Sym2};
use crate::membrane::BodyError;
use crate::storage::TriangleMesh;
use crate::systems::kernels::failure::{Cone, evaluate};
use crate::systems::tearing::strength;
use glam::DVec2;
use std::f64::consts::{PI, TAU};

/// Half the crack's length \[mm\].
const HALF: f64 = 1.0;
/// Side of the plate \[mm\]: wide enough that K_I exceeds that of the infinite plate by 1 to 2 %.
const SIDE: f64 = 14.0;
/// Averaging radius \[mm\]. The terms beyond T are of the order R/a.
const RADIUS: f64 = 0.1;
/// Edges of the mesh away from the tips \[mm\].
const COARSE: f64 = 0.14;
/// How far beyond the disc the mesh is as fine as in it \[mm\].
const MARGIN: f64 = 0.3;
/// Tension \[MPa\]: strains of 1e-3 at the tip at most.
const TENSION: f64 = 1e-3;

/// A crack at an angle to the load.
struct Slant {
    beta: f64,
    /// K_I and K_II \[MPa·√mm\].
    intensities: [f64; 2],
    /// Kink by largest hoop stress \[°\].
    hoop: f64,
    /// By the criterion on the singular field alone \[°\].
    limit: f64,
}

impl Slant {
    /// Direction of the crack where the load is along y.
    fn direction(&self) -> DVec2 {
        DVec2::new(self.beta.sin(), self.beta.cos())
    }

    /// Kink \[°\] by the criterion on the analytic field averaged over the disc.
    fn wanted(&self, tissue: &Tissue) -> Result<f64, VerifyError> {
        let law = tissue.material.stiffness().map_err(|source| BodyError::Material { triangle: 0, source })?;
        let modes = CrackTip::new(&law, 0.0).disc_average();
        let scale = 1.0 / (TAU * RADIUS).sqrt();
        let parallel = TENSION * (2.0 * self.beta).cos();
        let [opening, sliding] = self.intensities;
        let stress =
            modes.opening * (opening * scale) + modes.sliding * (sliding * scale) + Sym2::new(parallel, 0.0, 0.0);
        let cone = Cone { previous: DVec2::X, half_angle: tissue.tearing.cone };
        let answer = evaluate(stress, DVec2::X, &strength(&tissue.tearing), Some(cone), None);
        Ok(answer.map_or(f64::NAN, |answer| answer.best.angle().to_degrees()))
    }
}

pub fn run(out: &Artifacts) -> Result<Vec<Row>, VerifyError> {
    let mut rows = Rows::new("tear-kink");
    let (name, text) = file!("kink.csv");
    let unit = TENSION * (PI * HALF).sqrt();
    let slant = |[beta, opening, sliding, hoop, _, limit, ..]: [f64; 11]| Slant {
        beta: beta.to_radians(),
        intensities: [opening * unit, sliding * unit],
        hoop,
        limit,
    };
    let slants: Vec<Slant> = csv(name, text)?.into_iter().map(slant).collect();
    let tissue = Tissue::isotropic(1.0, RADIUS);
    let patterns = if out.is_quick() { &Pattern::ALL[..1] } else { &Pattern::ALL[..] };
    let slants = if out.is_quick() { &slants[1..3] } else { &slants[..] };

    let mut lines: Vec<Line> =
        [("disc of the analytic field, with T", 0), ("its limit R/a → 0", 1), ("Erdogan, Sih", 2)]
            .map(|(name, _)| Line { name: name.to_owned(), points: Vec::new() })
            .into();
    for slant in slants {
        for (line, kink) in lines.iter_mut().zip([slant.wanted(&tissue)?, slant.limit, slant.hoop]) {
            line.points.push(DVec2::new(slant.beta.to_degrees(), kink));
        }
    }
    for &pattern in patterns {
        let mesh = pattern.mesh(DVec2::splat(SIDE), COARSE)?;
        let mut found: [Line; 2] = ["criterion", "energy release"]
            .map(|what| Line { name: format!("{what}, {}", pattern.name()), points: Vec::new() });
        for slant in slants {
            let kinks = one(&mut rows, pattern, &mesh, &tissue, slant)?;
            for (line, kink) in found.iter_mut().zip(kinks) {
                line.points.push(DVec2::new(slant.beta.to_degrees(), kink));
            }
        }
        lines.extend(found);
    }
    let names = ["angle between crack and load [°]", "kink [°]"];
    let axes = Axes { title: "kink of slanted cracks", names, is_isometric: false };
    out.plot("tear-kink", axes, &lines)?;
    rows.finish()
}

/// One crack on one mesh: the kinks \[°\] of criterion and energy at the first tip.
fn one(
    rows: &mut Rows,
    pattern: Pattern,
    mesh: &TriangleMesh,
    tissue: &Tissue,
    slant: &Slant,
) -> Result<[f64; 2], VerifyError> {
    let size = DVec2::splat(SIDE);
    let sheet = under_tension(tissue.membrane(mesh.clone()), size, TENSION, tissue.material.thickness);
    let (middle, way) = (0.5 * size, slant.direction() * HALF);
    let mut cracked = Cracked::new(sheet.with(refined(4.0, MARGIN)), [middle - way, middle + way])?;
    let solved = cracked.solve()?;
    let what = format!("β = {:.0}°, {}", slant.beta.to_degrees(), pattern.name());
    let wanted = slant.wanted(tissue)?;
    let (mut off, mut energy_off) = (0.0_f64, 0.0_f64);
    let mut first = None;
    for tip in cracked.tips()? {
        let contour = Contour::around(&cracked, &solved.displacement, &tip, tissue, RADIUS)?;
        off = off.max((tip.kink() - wanted).abs());
        energy_off = energy_off.max((contour.kink() - slant.hoop).abs());
        first.get_or_insert([tip.kink(), contour.kink()]);
    }
    let first = first.unwrap_or([f64::NAN; 2]);
    rows.add(format!("{what}: kink, worst of both tips, wanted {wanted:.1}°"), off.max(first[0] * 0.0), 3.0, "°");
    rows.note(
        format!("{what}: kink of largest energy release off Erdogan and Sih's {:.1}°", slant.hoop),
        energy_off,
        "°",
    );
    Ok(first)
}
