//! The kink of slanted centre cracks: where the criterion turns, against what it says of the analytic field averaged over
//! the same disc, the stress parallel to the crack included.
//!
//! In a wide plate under the tension σ at the angle β to the crack, K_I = σ√(πa)·sin²β, K_II = σ√(πa)·sin β·cos β. The stress
//! parallel to the crack exceeds its singular part by T = σ(cos²β − sin²β), a tenth of σ√(a/R) and more.

use super::super::reference::{csv, file};
use super::super::{Artifacts, Axes, Line, Row, Rows, VerifyError, largest};
use super::cracked::{Cracked, Pattern, Tissue, even, refined, under_tension};
use glam::DVec2;
use rhexis::math::{CrackTip, Sym2};
use rhexis::membrane::BodyError;
use rhexis::storage::TriangleMesh;
use rhexis::systems::fracture::strength;
use rhexis::systems::kernels::failure::{Cone, evaluate};
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
/// Edges per R around the tips; from three on the engine calls a disc resolved.
const EDGES: [f64; 3] = [2.0, 2.8, RESOLVED];
/// Where the comparison is judged.
const RESOLVED: f64 = 4.0;
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

pub(crate) fn run(out: &Artifacts) -> Result<Vec<Row>, VerifyError> {
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
    let (patterns, edges) = match out.is_quick() {
        true => (&Pattern::ALL[..1], &EDGES[2..]),
        false => (&Pattern::ALL[..], &EDGES[..]),
    };

    let mut lines = ["disc of the analytic field, with T", "its limit R/a → 0", "Erdogan, Sih"]
        .map(|name| Line { name: name.to_owned(), points: Vec::new() })
        .to_vec();
    for slant in &slants {
        for (line, kink) in lines.iter_mut().zip([slant.wanted(&tissue)?, slant.limit, slant.hoop]) {
            line.points.push(DVec2::new(90.0 - slant.beta.to_degrees(), kink));
        }
    }
    for &pattern in patterns {
        let mesh = pattern.mesh(DVec2::splat(SIDE), COARSE)?;
        for &edges in edges {
            let mut worst = [0.0; 2];
            let mut found: [Line; 2] = ["stress", "energy"]
                .map(|by| Line { name: format!("{by}, {}, {edges} edges per R", pattern.name()), points: Vec::new() });
            for slant in &slants {
                let kinks = one(&mut rows, (pattern, &mesh, edges), &tissue, slant)?;
                for (line, kink) in found.iter_mut().zip(kinks.first) {
                    line.points.push(DVec2::new(90.0 - slant.beta.to_degrees(), kink));
                }
                worst.iter_mut().zip(kinks.off).for_each(|(worst, off)| *worst = largest([*worst, off]));
            }
            let what = format!("{}, {edges} edges per R, worst of all cracks", pattern.name());
            rows.note(format!("{what}: kink by stress"), worst[0], "°");
            rows.note(format!("{what}: kink by energy"), worst[1], "°");
            // The other patterns' lines would hide behind these.
            if edges == RESOLVED && pattern == patterns[patterns.len() - 1] {
                lines.extend(found);
            }
        }
    }
    let names = ["slant of the crack, 90° − β [°]", "kink [°]"];
    let axes = Axes { title: "kink of slanted cracks", names, is_isometric: false };
    out.plot("tear-kink", axes, &lines)?;
    rows.finish()
}

/// By criterion and energy \[°\].
struct Kinks {
    /// At the first tip.
    first: [f64; 2],
    /// How far the worse of both tips is off.
    off: [f64; 2],
}

/// One crack on one mesh.
fn one(
    rows: &mut Rows,
    (pattern, mesh, edges): (Pattern, &TriangleMesh, f64),
    tissue: &Tissue,
    slant: &Slant,
) -> Result<Kinks, VerifyError> {
    let size = DVec2::splat(SIDE);
    let sheet = under_tension(tissue.membrane(mesh.clone()), size, TENSION, tissue.material.thickness);
    let (middle, way) = (0.5 * size, slant.direction() * HALF);
    let mut cracked = Cracked::new(sheet.with(refined(edges, MARGIN)), [middle - way, middle + way])?;
    cracked.solve()?;
    // Of an even toughness the direction does not depend on its size.
    let kinks: Vec<[f64; 2]> = cracked.tips(even(1.0))?.iter().map(|tip| [tip.kink(), tip.kink_by_energy()]).collect();
    let off = |by: usize, wanted: f64| match kinks.len() {
        2 => largest(kinks.iter().map(|kink| (kink[by] - wanted).abs())),
        _ => f64::NAN,
    };
    let (wanted, hoop) = (slant.wanted(tissue)?, slant.hoop);
    let off = [off(0, wanted), off(1, hoop)];
    let what = format!("β = {:.0}°, {}, {edges} edges per R", slant.beta.to_degrees(), pattern.name());
    let limits = if edges == RESOLVED { [3.0, 1.0] } else { [f64::INFINITY; 2] };
    rows.add(format!("{what}: kink by stress off {wanted:.1}°"), off[0], limits[0], "°");
    rows.add(format!("{what}: kink by energy off Erdogan and Sih's {hoop:.1}°"), off[1], limits[1], "°");
    Ok(Kinks { first: kinks.first().copied().unwrap_or([f64::NAN; 2]), off })
}
