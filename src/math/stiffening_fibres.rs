//! Fibres that stiffen as they are drawn out.

use super::{CoupledStiffness, Orthotropic, Sym2, elementary};

/// k₂·e² from which on the stress goes along its tangent.
const MOST_FIBRE_EXPONENT: f64 = 4.0;

/// Fibres that stiffen in tension, beside the linear law: with the fibre's stretch λ = |F·f| and its strain e = λ − λ₀ the energy per
/// volume gains
///
/// W(e) = k₁/(2·k₂)·(exp(k₂·e²) − 1)  for e > 0, and nothing for e ≤ 0
///
/// (Holzapfel, Gasser, Ogden, *A new constitutive framework for arterial wall mechanics*, J. Elast. 61 (2000) 1, its fibre part with the
/// strain λ − λ₀ in place of their λ² − 1). λ₀ is 1, or the part that a held pre-stretch leaves. Small strains have Young's modulus
/// E_F + k₁ along the fibre in tension and E_F in compression. From e = 2/√k₂ on, where the stiffness is 491·k₁, the stress goes on
/// along its tangent: no strain overflows. The linear law at no strain converts toughness into strength. *Parameter*, of
/// the whole body.
///
/// ```
/// use rhexis::components::StiffeningFibres;
/// let fibres = StiffeningFibres { k1: 2.0, k2: 8.0 };
/// let (stress, e) = (fibres.response(0.2).stress, 0.2_f64);
/// assert!((stress - 2.0 * e * (8.0 * e * e).exp()).abs() < 1e-15);
/// assert_eq!(fibres.response(-0.2).stress, 0.0);
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "snapshot", derive(serde::Serialize, serde::Deserialize))]
pub struct StiffeningFibres {
    /// Stiffness k₁ \[MPa\] with which fibres begin to be drawn out, > 0 and at most 1e12.
    pub k1: f64,
    /// How fast they stiffen, k₂, from 1e-9 to 1e9: the stress has left the straight line by a half where e² = 0.41/k₂.
    pub k2: f64,
}

/// Contribution of the fibres at a strain.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct FibreResponse {
    /// W \[mJ/mm³\].
    pub energy: f64,
    /// W′ \[MPa\].
    pub stress: f64,
    /// W″ \[MPa\], never negative.
    pub stiffness: f64,
}

impl StiffeningFibres {
    /// Checks the ranges; an error holds the parameter's name, value and requirement.
    pub fn check(&self) -> Result<(), (&'static str, f64, &'static str)> {
        if !(self.k1 > 0.0 && self.k1 <= 1e12) {
            return Err(("k1 of the stiffening fibres", self.k1, "it must be above 0 and at most 1e12 MPa"));
        }
        if !(self.k2 >= 1e-9 && self.k2 <= 1e9) {
            return Err(("k2 of the stiffening fibres", self.k2, "it must be from 1e-9 to 1e9"));
        }
        Ok(())
    }

    /// The answer to the strain `e` along the fibre.
    pub fn response(&self, e: f64) -> FibreResponse {
        let (stress, stiffness) = self.curve().slopes(e);
        FibreResponse { energy: self.curve().energy(e), stress, stiffness }
    }

    #[inline]
    fn curve(&self) -> Exponential {
        Exponential::new(self.k1, self.k2, MOST_FIBRE_EXPONENT)
    }

    /// W \[mJ/mm³\] at a stretch.
    pub fn energy(&self, stretch: Sym2, unstretched: Sym2) -> f64 {
        self.curve().energy(Self::strain(stretch, unstretched))
    }

    /// e, from the stretch and that which is free of stress.
    #[inline]
    pub fn strain(stretch: Sym2, unstretched: Sym2) -> f64 {
        length(stretch) - length(unstretched)
    }

    /// Biot stress \[MPa\] beside that of the linear law, at a stretch in the fibre's axes: W′·λ̂ with the unit vector
    /// λ̂ = (U₁₁, U₁₂)/λ is the force of the fibres in the frame, and its symmetric part the stress.
    pub(crate) fn biot(&self, stretch: Sym2, unstretched: Sym2) -> Sym2 {
        let (stress, _) = self.curve().slopes(Self::strain(stretch, unstretched));
        let pull = stress / length(stretch).max(f64::MIN_POSITIVE);
        Sym2::new(pull * stretch.xx, 0.0, 0.5 * pull * stretch.xy)
    }

    /// The stiffness of a body at a stretch, from that of its linear law: with λ̂ = (c, s) the second derivative of W by the
    /// stretch is W″·(c·dU₁₁ + s·dU₁₂)² + W′/λ·(c·dU₁₂ − s·dU₁₁)².
    pub fn stiffness(&self, stretch: Sym2, unstretched: Sym2, linear: &Orthotropic) -> CoupledStiffness {
        let (stress, stiffness) = self.curve().slopes(Self::strain(stretch, unstretched));
        let length = length(stretch).max(f64::MIN_POSITIVE);
        let (c, s, turn) = (stretch.xx / length, stretch.xy / length, stress / length);
        let mut law = *linear;
        law.q11 += stiffness * c * c + turn * s * s;
        law.q66 += 0.25 * (stiffness * s * s + turn * c * c);
        CoupledStiffness { law, q16: 0.5 * (stiffness - turn) * c * s, q26: 0.0 }
    }
}

/// λ: the length of the fibre over that at rest.
fn length(stretch: Sym2) -> f64 {
    elementary::hypot(stretch.xx, stretch.xy)
}

/// The energy k₁/(2·k₂)·(exp(k₂·e²) − 1) of fibres at the strain e > 0, whose derivative goes along its tangent from the strain `limit` on.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Exponential {
    pub k1: f64,
    pub k2: f64,
    pub limit: f64,
}

impl Exponential {
    /// With the exponent `most` at the limit.
    pub(super) fn new(k1: f64, k2: f64, most: f64) -> Self {
        Self { k1, k2, limit: (most / k2).sqrt() }
    }

    /// W′ and W″ \[MPa\].
    #[inline]
    pub(super) fn slopes(&self, e: f64) -> (f64, f64) {
        if e <= 0.0 {
            return (0.0, 0.0);
        }
        let inside = e.min(self.limit);
        let exponent = self.k2 * inside * inside;
        let grown = elementary::exp(exponent);
        let stiffness = self.k1 * (1.0 + 2.0 * exponent) * grown;
        (self.k1 * inside * grown + stiffness * (e - inside), stiffness)
    }

    /// W \[mJ/mm³\].
    pub(super) fn energy(&self, e: f64) -> f64 {
        if e <= 0.0 {
            return 0.0;
        }
        let (inside, beyond) = (e.min(self.limit), e - e.min(self.limit));
        let (stress, stiffness) = self.slopes(inside);
        0.5 * self.k1 / self.k2 * elementary::exp_m1(self.k2 * inside * inside)
            + beyond * (stress + 0.5 * stiffness * beyond)
    }
}
