//! The field at the tip of a crack in an orthotropic plate: stress, its average over a disc, energy released per length
//! (Sih, Paris, Irwin, On cracks in rectilinearly anisotropic bodies, Int. J. Fract. Mech. 1 (1965) 189; Lekhnitskii 1963).
//!
//! Axes of the crack: x ahead, y across, the tip at 0, θ from x. With the roots μ₁, μ₂ (Im > 0) of
//! s₁₁μ⁴ − 2s₁₆μ³ + (2s₁₂ + s₆₆)μ² − 2s₂₆μ + s₂₂ = 0 and ψ_k = cos θ + μ_k·sin θ, stresses are K/√(2πr) times real parts of
//! g_k = ψ_k^(−½) and of their divided difference D = (g₁ − g₂)/(μ₁ − μ₂). The published forms divide by μ₁ − μ₂; but
//! D = −sin θ/(√ψ₁·√ψ₂·(√ψ₁ + √ψ₂)), in which nothing cancels: the double root of isotropic plates needs no case of its own.

use super::{Orthotropic, Sym2};
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
        let (sin, cos) = (-fibre_to_crack).sin_cos();
        let roots = [m1, m2].map(|m| {
            let mu = Complex64::I * m.sqrt();
            (mu * cos - sin) / (cos + mu * sin)
        });
        let (c2, s2) = (cos * cos, sin * sin);
        let mixed = (2.0 * s12 + s66) * s2 * c2;
        Self {
            roots,
            compliance_along: s11 * c2 * c2 + mixed + s22 * s2 * s2,
            compliance_across: s11 * s2 * s2 + mixed + s22 * c2 * c2,
        }
    }

    /// Stress at the angle `theta` \[rad\], in (−π, π), from the direction ahead, over K/√(2πr).
    pub fn stress(&self, theta: f64) -> Modes {
        let (sin, cos) = theta.sin_cos();
        let [mu1, mu2] = self.roots;
        // Im ψ has the sign of sin θ, so both roots lie in one quadrant and their sum is not zero.
        let [a1, a2] = self.roots.map(|mu| (cos + mu * sin).sqrt());
        let (g1, g2, product) = (a1.inv(), a2.inv(), mu1 * mu2);
        let d = -sin * g1 * g2 / (a1 + a2);
        Modes {
            opening: Sym2::new(-(product * (g1 + mu2 * d)).re, (g2 - mu2 * d).re, (product * d).re),
            sliding: Sym2::new(-((mu1 + mu2) * g1 + mu2 * mu2 * d).re, -d.re, (g1 + mu2 * d).re),
        }
    }

    /// Average of the stress over the disc of radius R about the tip, over K/√(2πR). With f(θ)/√r the stress, it is
    /// 2/(3π)·∫f dθ: exact over r, Gauss's rule over θ.
    pub fn disc_average(&self) -> Modes {
        // The nearest singularity of f lies at tan θ = −1/μ, that is at |Im θ| = −½·ln|(1 + iμ)/(1 − iμ)| from the real line; a
        // panel an eighth of that long leaves 32⁻¹⁰ = 1e-15.
        let distance = self.roots.map(|mu| {
            let i_mu = Complex64::I * mu;
            -0.5 * ((1.0 + i_mu) / (1.0 - i_mu)).norm().ln()
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
