//! Lets tips decide by energy instead of stress.

use crate::components::BodyError;
use crate::components::Toughness;
use crate::components::check::{Check, Host, number, positive};

/// Decides at tips by the energy that an advance would release, against a toughness that depends on its direction. Needs
/// [`Tearing`](crate::components::Tearing), of which it takes the cone, the exponent and R. *Parameter.* A body without it spends nothing on it.
///
/// The energy is the material force: the derivative of the energy by the place of the tip, right where the tissue is bent, in any law, beside
/// jaws and contact. In the field of a plane crack the energy release rate G(θ) of a kink at the angle θ is that of the tractions'
/// intensities on it (Nuismer 1975); K_I, K_II come from the disc of the material force. The toughness at the angle δ between kink and fibre is
/// G_c(δ) = G_along + (G_across − G_along)·(2δ/π)^α with the exponent α of `Tearing`, as for the strengths. The criterion is
/// √(G/G_c), which grows with the load as that of stress does.
///
/// Where the disc does not have the field of one straight crack ([`RingFault`](crate::components::RingFault)), the
/// material force alone decides. A start has no crack: it asks for both, the strengths of `Tearing` along a whole length and
/// the toughness by opening that length (Leguillon 2002). [`Tearing::from_toughness`](crate::components::Tearing::from_toughness)
/// gives strengths that fit.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "snapshot", derive(serde::Serialize, serde::Deserialize))]
pub struct EnergyCriterion {
    /// G_c along and across the fibres \[N/mm\], both > 0.
    pub toughness: Toughness,
    /// Radius of the disc of the material force over R, above 0 and at most 100; 2 by default. The disc takes three edges at least
    /// and six at most.
    pub ring: f64,
}

impl EnergyCriterion {
    /// With a disc of 2R.
    pub fn new(toughness: Toughness) -> Self {
        Self { toughness, ring: 2.0 }
    }
}

impl Check for EnergyCriterion {
    fn check(&self, _: &Host<'_>) -> Result<(), BodyError> {
        positive("EnergyCriterion", "toughness along the fibres", self.toughness.along)?;
        positive("EnergyCriterion", "toughness across the fibres", self.toughness.across)?;
        let is_right = self.ring > 0.0 && self.ring <= 100.0;
        number("EnergyCriterion", "ring", self.ring, (is_right, "it must be above 0 and at most 100"))
    }
}
