//! Bending stiffness.

use crate::components::BodyError;
use crate::components::check::{Check, Host, positive};
use crate::math::Orthotropic;

/// Resistance to a change of curvature, so that a slack flap folds over and lies down instead of crumpling. For bodies in space:
/// one that is kept in its plane does not bend. *Parameter.*
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "snapshot", derive(serde::Serialize, serde::Deserialize))]
pub struct Bending {
    /// Stiffness D \[N·mm\], > 0; for fibrous tissue √(D₁₁·D₂₂). Without it that of a sheet which is even through its thickness,
    /// h³/12·C: E·h³/(12·(1 − ν²)) of an isotropic one. Tissue in layers may be softer or stiffer.
    pub stiffness: Option<f64>,
}

impl Check for Bending {
    fn check(&self, _: &Host<'_>) -> Result<(), BodyError> {
        self.stiffness.map_or(Ok(()), |d| positive("Bending", "bending stiffness", d))
    }
}

impl Bending {
    /// Factor \[mm³\] by which a law \[MPa\] of tissue of a thickness \[mm\] is multiplied to give that of bending.
    pub(crate) fn scale(&self, law: &Orthotropic, thickness: f64) -> f64 {
        self.stiffness.map_or_else(|| thickness * thickness * thickness / 12.0, |d| d / (law.q11 * law.q22).sqrt())
    }
}
