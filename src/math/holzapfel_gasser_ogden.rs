//! The law of Holzapfel, Gasser and Ogden for collagenous tissue, with families of fibres that disperse.

use super::stiffening_fibres::Exponential;
use super::{CoupledStiffness, Orthotropic, Sym2, elementary};

/// Most families of a body: the "four-fibre" models of arteries have as many.
pub(super) const MOST_FAMILIES: usize = 4;

/// k₂·E² from which on the stress goes along its tangent in E.
const MOST_FAMILY_EXPONENT: f64 = 9.0;

/// Area ratio below which 1/D² goes on along its second-order expansion, so that a crushed or mirrored triangle has a finite energy.
const LEAST_AREA_RATIO: f64 = 0.2;

/// Largest principal strain of a pre-stretch, by which the law divides.
const MOST_PRE_STRETCH: f64 = 0.9;

/// One family of fibres.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "snapshot", derive(serde::Serialize, serde::Deserialize))]
pub struct FibreFamily {
    /// Stiffness k₁ \[MPa\], from 0 to 1e12.
    pub k1: f64,
    /// Exponent k₂, from 1e-9 to 1e9.
    pub k2: f64,
    /// Mean direction \[°\] from the body's fibre direction, counter-clockwise about the normal.
    pub degrees: f64,
    /// Dispersion κ: 0 where all fibres are parallel, 1/3 where their directions in space are isotropic.
    pub kappa: f64,
}

/// The substance around the fibres.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "snapshot", derive(serde::Serialize, serde::Deserialize))]
pub enum GroundSubstance {
    /// The linear law of the body's material.
    #[default]
    Linear,
    /// ½·μ·(I₁ − 3) in place of it, incompressible, with the material's shear modulus μ. The material must be isotropic with Poisson's
    /// ratio 0.5: [`Material::neo_hookean`](crate::components::Material::neo_hookean).
    NeoHookean,
}

/// Fibres in a matrix: per volume, with F = R·U and C = U² in the plane and the thickness from incompressibility,
///
/// W = ½·μ·(I₁ − 3) + Σ k₁/(2·k₂)·(exp(k₂·⟨E⟩²) − 1),  E = κ·(I₁ − 3) + (1 − 3κ)·(I₄ − 1),
///
/// I₁ = tr C + 1/det C, I₄ = a·C·a of each family's direction a (Gasser, Ogden, Holzapfel, *Hyperelastic modelling of arterial layers
/// with distributed collagen fibre orientations*, J. R. Soc. Interface 3 (2006) 15). With κ = 0 it is the law of Holzapfel, Gasser and Ogden
/// (J. Elast. 61 (2000) 1). A family acts where E > 0. From E = 3/√k₂ on, where the stiffness by E is 154,000·k₁, its stress goes on along
/// its tangent, and below a fifth of the area 1/det C goes on along its second-order expansion: nothing overflows. A held pre-stretch
/// multiplies: C is that of F·U₀⁻¹ with the stretch U₀ that is free of stress. *Parameter*, of the whole body, in place of
/// [`StiffeningFibres`](super::StiffeningFibres).
///
/// ```
/// use rhexis::components::{HolzapfelGasserOgden, Material, GroundSubstance};
/// // The adventitia of an iliac artery (Gasser et al. 2006): c = 7.64 kPa, k₁ = 996.6 kPa, k₂ = 524.6, ±49.98°, κ = 0.226.
/// let law = HolzapfelGasserOgden::symmetric(0.9966, 524.6, 49.98, 0.226);
/// assert_eq!((law.families.len(), law.matrix), (2, GroundSubstance::NeoHookean));
/// let material = Material::neo_hookean(7.64e-3, 0.4);
/// ```
#[derive(Clone, Debug, Default, PartialEq)]
#[cfg_attr(feature = "snapshot", derive(serde::Serialize, serde::Deserialize))]
pub struct HolzapfelGasserOgden {
    /// Up to four families; none leaves the matrix alone.
    pub families: Vec<FibreFamily>,
    /// Ground substance around the fibres.
    pub matrix: GroundSubstance,
}

impl HolzapfelGasserOgden {
    /// Two families at ±`degrees` from the fibre direction in a neo-Hookean matrix.
    pub fn symmetric(k1: f64, k2: f64, degrees: f64, kappa: f64) -> Self {
        let family = |degrees| FibreFamily { k1, k2, degrees, kappa };
        Self { families: vec![family(degrees), family(-degrees)], matrix: GroundSubstance::NeoHookean }
    }

    /// Checks the ranges in a body with the pre-stretch `held`; an error holds the parameter's name, value and requirement.
    pub fn check(&self, held: Sym2) -> Result<(), (&'static str, f64, &'static str)> {
        let (count, strain) = (self.families.len(), held.principal_values().0);
        if !(strain <= MOST_PRE_STRETCH) {
            return Err((
                "the pre-stretch",
                strain,
                "it must be at most 0.9, as this law divides by what is left of 1",
            ));
        }
        if count > MOST_FAMILIES {
            return Err(("the number of fibre families", count as f64, "it must be at most 4"));
        }
        for &FibreFamily { k1, k2, degrees, kappa } in &self.families {
            if !(0.0..=1e12).contains(&k1) {
                return Err(("k1 of a fibre family", k1, "it must be from 0 to 1e12 MPa"));
            }
            if !(1e-9..=1e9).contains(&k2) {
                return Err(("k2 of a fibre family", k2, "it must be from 1e-9 to 1e9"));
            }
            if !(degrees.abs() <= 360.0) {
                return Err(("the angle of a fibre family", degrees, "it must be from -360 to 360 degrees"));
            }
            if !(0.0..=1.0 / 3.0).contains(&kappa) {
                return Err(("kappa of a fibre family", kappa, "it must be from 0, all parallel, to 1/3, isotropic"));
            }
        }
        Ok(())
    }

    /// Whether the law holds in place of the linear one.
    pub fn replaces_linear(&self) -> bool {
        self.matrix == GroundSubstance::NeoHookean
    }
}

/// One family, ready for evaluation.
#[derive(Clone, Copy, Debug, Default)]
struct Family {
    /// Exponential law in E.
    curve: Exponential,
    kappa: f64,
    /// κ·I + (1 − 3κ)·a⊗a, in the tissue free of stress.
    structure: Sym2,
    /// Structure tensor where the body is drawn: U₀⁻¹·(κ·I + (1 − 3κ)·a⊗a)·U₀⁻¹.
    drawn: Sym2,
}

/// A [`HolzapfelGasserOgden`] with the stretch that is free of stress, ready for evaluation at any stretch.
#[derive(Clone, Copy, Debug)]
pub struct PreparedLaw {
    families: [Family; MOST_FAMILIES],
    count: usize,
    is_neo_hookean: bool,
    /// U₀.
    unstretched: Sym2,
    /// V = U₀⁻¹.
    inverse: Sym2,
    /// V².
    metric: Sym2,
    /// 1/det U₀.
    area: f64,
}

/// 1/D² − 1 of the area ratio D, and its derivatives by det U.
#[derive(Clone, Copy, Debug)]
struct Thickening {
    /// D − 1.
    growth: f64,
    value: f64,
    slope: f64,
    curvature: f64,
    is_crushed: bool,
}

/// How a law answers in sum.
#[derive(Clone, Copy, Debug)]
struct Sums {
    /// Factor of tr C, as a tensor: ∂W/∂C but for the part that goes by the area \[MPa\].
    along: Sym2,
    /// Factor of 1/D² \[MPa\].
    across: f64,
}

impl PreparedLaw {
    /// The law of a body whose stretch `unstretched` is free of stress.
    pub fn new(law: &HolzapfelGasserOgden, unstretched: Sym2) -> Self {
        let area = 1.0 / unstretched.determinant();
        let inverse = Sym2::new(unstretched.yy, unstretched.xx, -unstretched.xy) * area;
        let mut families = [Family::default(); MOST_FAMILIES];
        for (family, of) in families.iter_mut().zip(&law.families) {
            let (s, c) = elementary::sin_cos(of.degrees.to_radians());
            let along = Sym2::new(c * c, s * s, c * s);
            let structure = Sym2::IDENTITY * of.kappa + along * (1.0 - 3.0 * of.kappa);
            let drawn = sandwich(inverse, structure);
            let curve = Exponential::new(of.k1, of.k2, MOST_FAMILY_EXPONENT);
            *family = Family { curve, kappa: of.kappa, structure, drawn };
        }
        let count = law.families.len().min(MOST_FAMILIES);
        let is_neo_hookean = law.replaces_linear();
        Self { families, count, is_neo_hookean, unstretched, inverse, metric: square(inverse), area }
    }

    /// Whether it holds in place of the linear law.
    pub fn replaces_linear(&self) -> bool {
        self.is_neo_hookean
    }

    /// Stiffness \[MPa\] with which the families begin to be drawn out: no less than theirs in any direction.
    pub fn first_stiffness(&self) -> f64 {
        self.families[..self.count].iter().map(|family| 4.0 * family.curve.k1).sum()
    }

    /// Energy per volume \[mJ/mm³\] at a stretch, of a matrix with the shear modulus `mu` \[MPa\] where that is neo-Hookean.
    pub fn energy(&self, stretch: Sym2, mu: f64) -> f64 {
        let (gradient, change) = self.change(stretch);
        let thickening = self.thickening(stretch, gradient);
        let fibres = self.families[..self.count].iter().map(|f| f.curve.energy(f.strain(change, &thickening))).sum();
        if !self.is_neo_hookean {
            return fibres;
        }
        fibres + 0.5 * mu * first_invariant(gradient, &thickening)
    }

    /// Biot stress \[MPa\]: ∂W/∂U.
    pub fn stress(&self, stretch: Sym2, mu: f64) -> Sym2 {
        if stretch == self.unstretched {
            return Sym2::ZERO;
        }
        let (gradient, change) = self.change(stretch);
        let thickening = self.thickening(stretch, gradient);
        let Sums { along, across } = self.sums(change, &thickening, mu, |_, _| ());
        anticommutator(stretch, along) + adjugate(stretch) * (across * thickening.slope)
    }

    /// The stress and the stiffness ∂²W/∂U² beside that of `linear`, or in its place where the matrix is neo-Hookean. The stiffness
    /// is positive semidefinite, and exact but for triangles with less than a fifth of their area, where it is no less.
    pub fn answer(&self, stretch: Sym2, linear: &Orthotropic, mu: f64) -> (Sym2, CoupledStiffness) {
        let (gradient, change) = self.change(stretch);
        let thickening = self.thickening(stretch, gradient);
        let flat = adjugate(stretch);
        let none = Orthotropic { q11: 0.0, q12: 0.0, q22: 0.0, q66: 0.0 };
        let law = if self.is_neo_hookean { none } else { *linear };
        let mut sum = CoupledStiffness { law, q16: 0.0, q26: 0.0 };
        let Sums { along, across } = self.sums(change, &thickening, mu, |family, stiffness| {
            let slope = anticommutator(stretch, family.drawn) + flat * (family.kappa * thickening.slope);
            sum.add_square(slope, stiffness);
        });
        sum.add_square(flat, across * thickening.curvature);
        // 2·∂W/∂C : dU².
        sum.law.q11 += 2.0 * along.xx;
        sum.law.q22 += 2.0 * along.yy;
        sum.law.q66 += 0.5 * along.trace();
        sum.q16 += along.xy;
        sum.q26 += along.xy;
        // Factor of det dU, the second part of the area's change.
        let pressure = across * thickening.slope;
        if thickening.is_crushed {
            sum.law.q11 -= pressure;
            sum.law.q22 -= pressure;
        } else {
            sum.law.q12 += pressure;
        }
        sum.law.q66 -= 0.5 * pressure;
        let is_at_rest = stretch == self.unstretched;
        let stress = if is_at_rest { Sym2::ZERO } else { anticommutator(stretch, along) + flat * pressure };
        (stress, sum)
    }

    /// H = (U − U₀)·V by rows, the elastic gradient less the identity, and H + Hᵀ + Hᵀ·H: twice the Green strain, without cancellation.
    fn change(&self, stretch: Sym2) -> ([f64; 4], Sym2) {
        let (e, v) = (stretch - self.unstretched, self.inverse);
        let h = [
            e.xx * v.xx + e.xy * v.xy,
            e.xx * v.xy + e.xy * v.yy,
            e.xy * v.xx + e.yy * v.xy,
            e.xy * v.xy + e.yy * v.yy,
        ];
        let green = Sym2::new(
            2.0 * h[0] + h[0] * h[0] + h[2] * h[2],
            2.0 * h[3] + h[1] * h[1] + h[3] * h[3],
            h[1] + h[2] + h[0] * h[1] + h[2] * h[3],
        );
        (h, green)
    }

    fn thickening(&self, stretch: Sym2, h: [f64; 4]) -> Thickening {
        let growth = h[0] + h[3] + h[0] * h[3] - h[1] * h[2];
        let ratio = stretch.determinant() * self.area;
        let is_crushed = !(ratio >= LEAST_AREA_RATIO);
        let at = if is_crushed { LEAST_AREA_RATIO } else { ratio };
        let inverse_sq = 1.0 / (at * at);
        let (slope, curvature) = (-2.0 * inverse_sq / at, 6.0 * inverse_sq * inverse_sq);
        let beyond = ratio - at;
        let value = if is_crushed {
            inverse_sq - 1.0 + beyond * (slope + 0.5 * curvature * beyond)
        } else {
            -growth * (2.0 + growth) * inverse_sq
        };
        Thickening {
            growth,
            value,
            slope: (slope + curvature * beyond) * self.area,
            curvature: curvature * self.area * self.area,
            is_crushed,
        }
    }

    /// ∂W/∂C and ∂W/∂(1/D²); `second` receives every family that acts, with its second derivative by E.
    fn sums(&self, change: Sym2, thickening: &Thickening, mu: f64, mut second: impl FnMut(&Family, f64)) -> Sums {
        let half = if self.is_neo_hookean { 0.5 * mu } else { 0.0 };
        let mut sums = Sums { along: self.metric * half, across: half };
        for family in &self.families[..self.count] {
            let (stress, stiffness) = family.curve.slopes(family.strain(change, thickening));
            if stiffness > 0.0 {
                sums.along += family.drawn * stress;
                sums.across += family.kappa * stress;
                second(family, stiffness);
            }
        }
        sums
    }
}

impl Family {
    /// E.
    fn strain(&self, change: Sym2, thickening: &Thickening) -> f64 {
        self.structure.contract(change) + self.kappa * thickening.value
    }
}

/// I₁ − 3 = |H|² − 2·det H + (1/D² − 1 + 2·(D − 1)): sums of squares, which nothing cancels.
fn first_invariant(h: [f64; 4], thickening: &Thickening) -> f64 {
    let Thickening { growth, value, is_crushed, .. } = *thickening;
    let in_plane = h.iter().map(|h| h * h).sum::<f64>() - 2.0 * (h[0] * h[3] - h[1] * h[2]);
    if is_crushed {
        return in_plane + value + 2.0 * growth;
    }
    let ratio = 1.0 + growth;
    in_plane + growth * growth * (3.0 + 2.0 * growth) / (ratio * ratio)
}

/// A·B + B·A.
fn anticommutator(a: Sym2, b: Sym2) -> Sym2 {
    let off = a.xy * b.xy;
    Sym2::new(2.0 * (a.xx * b.xx + off), 2.0 * (a.yy * b.yy + off), a.xy * b.trace() + b.xy * a.trace())
}

fn square(a: Sym2) -> Sym2 {
    anticommutator(a, a) * 0.5
}

/// V·M·V.
fn sandwich(v: Sym2, m: Sym2) -> Sym2 {
    let row = |a: f64, b: f64| [a * m.xx + b * m.xy, a * m.xy + b * m.yy];
    let ([p, q], [r, s]) = (row(v.xx, v.xy), row(v.xy, v.yy));
    Sym2::new(p * v.xx + q * v.xy, r * v.xy + s * v.yy, p * v.xy + q * v.yy)
}

/// ∂det A/∂A.
fn adjugate(a: Sym2) -> Sym2 {
    Sym2::new(a.yy, a.xx, -a.xy)
}
