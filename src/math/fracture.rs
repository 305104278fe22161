//! The field at the tip of a crack in an orthotropic plate: stress, its average over a disc, energy released per length
//! (Sih, Paris, Irwin, On cracks in rectilinearly anisotropic bodies, Int. J. Fract. Mech. 1 (1965) 189; Lekhnitskii 1963).
//!
//! Axes of the crack: x ahead, y across, the tip at 0, θ from x. With the roots μ₁, μ₂ (Im > 0) of
//! s₁₁μ⁴ − 2s₁₆μ³ + (2s₁₂ + s₆₆)μ² − 2s₂₆μ + s₂₂ = 0 and ψ_k = cos θ + μ_k·sin θ, stresses are K/√(2πr) times real parts of
//! g_k = ψ_k^(−½) and of their divided difference D = (g₁ − g₂)/(μ₁ − μ₂). The published forms divide by μ₁ − μ₂; but
//! D = −sin θ/(√ψ₁·√ψ₂·(√ψ₁ + √ψ₂)), in which nothing cancels: the double root of isotropic plates needs no case of its own.

use super::{Orthotropic, Sym2, elementary};
use glam::DVec2;
use num_complex::Complex64;
use std::f64::consts::{FRAC_2_PI, PI, TAU};

/// Nodes and weights of Gauss's rule with five points on [−1, 1].
const GAUSS: [(f64, f64); 5] = [
    (-0.906_179_845_938_664, 0.236_926_885_056_189_1),
    (-0.538_469_310_105_683_1, 0.478_628_670_499_366_5),
    (0.0, 0.568_888_888_888_888_9),
    (0.538_469_310_105_683_1, 0.478_628_670_499_366_5),
    (0.906_179_845_938_664, 0.236_926_885_056_189_1),
];

/// The neighbourhood of a crack's tip in a plate of one orthotropic material.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CrackTip {
    /// μ₁, μ₂.
    roots: [Complex64; 2],
    /// s₁₁ \[1/MPa\]: strain along the crack from stress along it.
    compliance_along: f64,
    /// s₂₂ \[1/MPa\].
    compliance_across: f64,
    /// s₁₂ \[1/MPa\].
    compliance_mixed: f64,
    /// s₁₆, s₂₆ \[1/MPa\]: strains along and across the crack from the shear stress.
    compliance_shear: [f64; 2],
}

/// How the displacements of the two modes change along the crack, in the crack's axes: ∂u/∂x of K_I and of K_II.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Slopes {
    /// Per K_I.
    pub opening: DVec2,
    /// Per K_II.
    pub sliding: DVec2,
}

/// The stresses of the two modes, in the crack's axes: of K_I (opening) and of K_II (sliding).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Modes {
    /// Per K_I.
    pub opening: Sym2,
    /// Per K_II.
    pub sliding: Sym2,
}

impl CrackTip {
    /// A crack in a plate of this law whose fibre stands at `fibre_to_crack` \[rad\] counter-clockwise from the direction in
    /// which the crack points.
    pub fn new(law: &Orthotropic, fibre_to_crack: f64) -> Self {
        let d = law.q11 * law.q22 - law.q12 * law.q12;
        let (s11, s22, s12, s66) = (law.q22 / d, law.q11 / d, -law.q12 / d, 1.0 / law.q66);
        // In the fibre's axes the quartic is quadratic in μ²; with m = −μ² the two m have the sum b/s₁₁ and the product s₂₂/s₁₁.
        let half = 0.5 * (2.0 * s12 + s66) / s11;
        let product = s22 / s11;
        let gap = half * half - product;
        // Both sums of √m are positive; √(m₁·m₂) = √product keeps the double root exact to a square root of rounding at
        // worst, to which no coefficient is sensitive: each is smooth in the sum and the product of the roots.
        let [m1, m2] = if gap >= 0.0 {
            let large = half + gap.sqrt();
            [Complex64::from(large), Complex64::from(product / large)]
        } else {
            let m = Complex64::new(half, (-gap).sqrt());
            [m, m.conj()]
        };
        // μ = i·√m has Im μ > 0. Lekhnitskii 1963, §7: in axes turned by φ, μ' = (μ·cos φ − sin φ)/(cos φ + μ·sin φ).
        let (sin, cos) = elementary::sin_cos(-fibre_to_crack);
        let roots = [m1, m2].map(|m| {
            let mu = Complex64::I * elementary::complex_sqrt(m);
            (mu * cos - sin) / (cos + mu * sin)
        });
        let (c2, s2) = (cos * cos, sin * sin);
        let mixed = (2.0 * s12 + s66) * s2 * c2;
        let strain =
            |stress: Sym2| law.strain(stress.in_axes_turned_by(fibre_to_crack)).in_axes_turned_by(-fibre_to_crack);
        let (across, shear) = (strain(Sym2::new(0.0, 1.0, 0.0)), strain(Sym2::new(0.0, 0.0, 1.0)));
        Self {
            roots,
            compliance_mixed: across.xx,
            compliance_shear: [shear.xx, shear.yy],
            compliance_along: s11 * c2 * c2 + mixed + s22 * s2 * s2,
            compliance_across: s11 * s2 * s2 + mixed + s22 * c2 * c2,
        }
    }

    /// Stress at the angle `theta` \[rad\], in (−π, π), from the direction ahead, over K/√(2πr).
    pub fn stress(&self, theta: f64) -> Modes {
        let (sin, cos) = elementary::sin_cos(theta);
        let [mu1, mu2] = self.roots;
        // Im ψ has the sign of sin θ, so both roots lie in one quadrant and their sum is not zero.
        let [a1, a2] = self.roots.map(|mu| elementary::complex_sqrt(cos + mu * sin));
        let (g1, g2, product) = (a1.inv(), a2.inv(), mu1 * mu2);
        let d = -sin * g1 * g2 / (a1 + a2);
        Modes {
            opening: Sym2::new(-(product * (g1 + mu2 * d)).re, (g2 - mu2 * d).re, (product * d).re),
            sliding: Sym2::new(-((mu1 + mu2) * g1 + mu2 * mu2 * d).re, -d.re, (g1 + mu2 * d).re),
        }
    }

    /// Change of the displacement along the crack, ∂u/∂x, at the angle `theta` \[rad\], in (−π, π), over K/√(2πr). With
    /// q_k = s₁₂μ_k + s₂₂/μ_k − s₂₆ the part across the crack is Re (μ₁q₂g₂ − μ₂q₁g₁)/(μ₁ − μ₂) for K_I and
    /// Re (q₂g₂ − q₁g₁)/(μ₁ − μ₂) for K_II, written with D as above; the part along it is the strain there.
    pub fn slope(&self, theta: f64) -> Slopes {
        let (sin, cos) = elementary::sin_cos(theta);
        let [mu1, mu2] = self.roots;
        let [a1, a2] = self.roots.map(|mu| elementary::complex_sqrt(cos + mu * sin));
        let (g1, g2, product) = (a1.inv(), a2.inv(), mu1 * mu2);
        let d = -sin * g1 * g2 / (a1 + a2);
        let (s12, s22, [s16, s26]) = (self.compliance_mixed, self.compliance_across, self.compliance_shear);
        let q1 = s12 * mu1 + s22 / mu1 - s26;
        let sliding = -(q1 * d + g2 * (s12 - s22 / product)).re;
        let opening = -(product * (q1 / mu1) * d + g2 * (s26 - s22 * (mu1 + mu2) / product)).re;
        let stress = self.stress(theta);
        let along = |s: Sym2| self.compliance_along * s.xx + s12 * s.yy + s16 * s.xy;
        Slopes {
            opening: DVec2::new(along(stress.opening), opening),
            sliding: DVec2::new(along(stress.sliding), sliding),
        }
    }

    /// K_I and K_II \[MPa·√mm\] of a field from its interaction integrals \[N/mm per MPa·√mm\] with the fields of K_I = 1 and
    /// K_II = 1 (Yau, Wang, Corten 1980). The integrals are the derivatives of the energy release by each: a linear system.
    pub fn intensities(&self, interaction: [f64; 2]) -> [f64; 2] {
        let (opening, sliding) = (self.energy_release(1.0, 0.0), self.energy_release(0.0, 1.0));
        let mixed = 0.5 * (self.energy_release(1.0, 1.0) - opening - sliding);
        let scale = 0.5 / (opening * sliding - mixed * mixed);
        let [first, second] = interaction;
        [(sliding * first - mixed * second) * scale, (opening * second - mixed * first) * scale]
    }

    /// Average of the stress over the disc of radius R about the tip, over K/√(2πR). With f(θ)/√r the stress, it is
    /// 2/(3π)·∫f dθ: exact over r, Gauss's rule over θ.
    pub fn disc_average(&self) -> Modes {
        // The nearest singularity of f lies at tan θ = −1/μ, that is at |Im θ| = −½·ln|(1 + iμ)/(1 − iμ)| from the real line; a
        // panel an eighth of that long leaves 32⁻¹⁰ = 1e-15.
        let distance = self.roots.map(|mu| {
            let i_mu = Complex64::I * mu;
            -0.25 * elementary::ln(((1.0 + i_mu) / (1.0 - i_mu)).norm_sqr())
        });
        let panel_count = (8.0 * TAU / distance[0].min(distance[1])).clamp(64.0, 1e5).ceil();
        let half = PI / panel_count;
        let mut sum = Modes { opening: Sym2::ZERO, sliding: Sym2::ZERO };
        for panel in 0..panel_count as u32 {
            let middle = -PI + half * (2.0 * f64::from(panel) + 1.0);
            for (node, weight) in GAUSS {
                let stress = self.stress(middle + half * node);
                sum.opening += stress.opening * weight;
                sum.sliding += stress.sliding * weight;
            }
        }
        let scale = FRAC_2_PI / 3.0 * half;
        Modes { opening: sum.opening * scale, sliding: sum.sliding * scale }
    }

    /// Energy released per area of crack \[N/mm\] at stress intensities K_I, K_II \[MPa·√mm\] (Sih, Paris, Irwin 1965).
    pub fn energy_release(&self, k_opening: f64, k_sliding: f64) -> f64 {
        let [mu1, mu2] = self.roots;
        let (sum, product) = (mu1 + mu2, mu1 * mu2);
        let opening = -0.5 * self.compliance_across * ((k_opening * sum + k_sliding) / product).im;
        let sliding = 0.5 * self.compliance_along * (k_sliding * sum + k_opening * product).im;
        k_opening * opening + k_sliding * sliding
    }

    /// The toughness \[N/mm\] of a material that lets a pure opening crack go straight on where the stress across it, averaged
    /// over the disc of `radius` \[mm\], reaches `strength` \[MPa\].
    pub fn toughness(&self, strength: f64, radius: f64) -> f64 {
        let k = strength * (TAU * radius).sqrt() / self.disc_average().opening.yy;
        self.energy_release(k, 0.0)
    }

    /// The inverse: the strength \[MPa\] that goes with a `toughness` \[N/mm\].
    pub fn strength(&self, toughness: f64, radius: f64) -> f64 {
        let k = (toughness / self.energy_release(1.0, 0.0)).sqrt();
        k * self.disc_average().opening.yy / (TAU * radius).sqrt()
    }
}

#[cfg(test)]
#[path = "fracture_tests.rs"]
mod tests;
