//! The pure-shear strip (Rivlin, Thomas 1953): a long crack between clamps runs where W(λ)·2b = G_c, however long it is.

use super::super::bodies;
use super::super::{Artifacts, Row, Rows, VerifyError};
use super::cracked::{Cracked, Pattern, Tissue, even, refined};
use glam::{DVec2, DVec3};
use rhexis::components::EnergyCriterion;
use rhexis::event::EventKind;
use rhexis::membrane::BodyError;

/// Length and height 2b of the strip, and length of its crack \[mm\].
const SIZE: DVec2 = DVec2::new(60.0, 20.0);
const CRACK: f64 = 25.0;
/// Toughness \[N/mm\] and R \[mm\].
const TOUGHNESS: f64 = 0.15;
const RADIUS: f64 = 1.0;
/// Edges per R at the tip and far from it.
const EDGES: [f64; 2] = [3.0, 1.0];

pub(crate) fn run(out: &Artifacts) -> Result<Vec<Row>, VerifyError> {
    let mut rows = Rows::new("tear-strip");
    let patterns = if out.is_quick() { &Pattern::ALL[..1] } else { &Pattern::ALL[..] };
    let tissue = Tissue::isotropic(1.0, RADIUS);
    let law = tissue.material.stiffness().map_err(|source| BodyError::Material { triangle: 0, source })?;
    // W = Q₁₁·ε²/2: the strip cannot narrow along its length.
    let wanted = (2.0 * TOUGHNESS / (law.q11 * SIZE.y)).sqrt();
    for &pattern in patterns {
        let (mut low, mut high) = (0.9 * wanted, 1.1 * wanted);
        let what = format!("{}: strain at which the crack runs", pattern.name());
        if runs_at(&tissue, pattern, low)? || !runs_at(&tissue, pattern, high)? {
            rows.ratio(format!("{what}, not within a tenth of {wanted:.4}"), f64::NAN, 0.0);
            continue;
        }
        while high - low > 2e-3 * wanted {
            let middle = 0.5 * (low + high);
            *if runs_at(&tissue, pattern, middle)? { &mut high } else { &mut low } = middle;
        }
        let strain = 0.5 * (low + high);
        rows.relative(what, strain, wanted, 0.02);
        rows.relative(format!("{}: W(λ)·2b of the toughness", pattern.name()), strain.powi(2), wanted.powi(2), 0.04);
    }
    rows.finish()
}

fn runs_at(tissue: &Tissue, pattern: Pattern, strain: f64) -> Result<bool, VerifyError> {
    let sheet = tissue.membrane(pattern.mesh(SIZE, RADIUS / EDGES[1])?);
    let clamp = |name: &str, at: f64, way: f64| {
        let by = DVec3::Y * (0.5 * way * strain * SIZE.y);
        bodies::hold(&sheet, name, move |p| ((p.y - at).abs() < 1e-9).then_some(by))
    };
    let (bottom, top) = (clamp("bottom", 0.0, -1.0), clamp("top", SIZE.y, 1.0));
    let sheet = sheet.hold(bottom).hold(top).with(EnergyCriterion::new(even(TOUGHNESS)));
    let sheet = sheet.with(refined(EDGES[0], 2.0 * RADIUS));
    let middle = 0.5 * SIZE.y;
    let mut cracked = Cracked::new(sheet, [DVec2::new(0.0, middle), DVec2::new(CRACK, middle)])?;
    cracked.simulation.settle_and_tear(1.0, 1e-9, 1)?;
    let has_run = cracked.simulation.drain_events().any(|event| matches!(event.kind, EventKind::Advanced { .. }));
    Ok(has_run)
}
