//! The plane-stress orthotropic law in the fibre's axes (Allard, Marchal, Cotin 2009, eq. 1, with its misprints corrected).

use super::number::linear_stress;
use super::{Sym2, elementary};

/// Plane-stress stiffness in axes (fibre, transverse) \[MPa\]: with D = 1 − ν_F·ν_T and ν_T = ν_F·E_T/E_F,
/// Q11 = E_F/D, Q22 = E_T/D, Q12 = ν_T·E_F/D, Q66 = G.
///
/// Every triangle's rest frame lies along its fibre, so this is all the material a triangle needs.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "snapshot", derive(serde::Serialize, serde::Deserialize))]
pub struct Orthotropic {
    /// Stiffness along the fibre \[MPa\].
    pub q11: f64,
    /// Coupling stiffness \[MPa\].
    pub q12: f64,
    /// Stiffness across the fibre \[MPa\].
    pub q22: f64,
    /// Shear stiffness \[MPa\], against engineering shear.
    pub q66: f64,
}

/// Why a set of elastic constants is no material: its energy would not be positive.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum InadmissibleMaterial {
    /// A modulus outside the range in which products of two of them, and their inverses, are numbers.
    #[error("{name} is {value:?} MPa: a modulus must be positive, from 1e-100 to 1e100 MPa")]
    Modulus {
        /// Name of the modulus.
        name: &'static str,
        /// Rejected modulus \[MPa\].
        value: f64,
    },
    /// ν_F²·E_T/E_F ≥ 1.
    #[error(
        "poisson_major = {poisson_major} with these moduli gives ν_F²·E_T/E_F = {product}: it must stay below 1, \
         so choose |poisson_major| < {limit}"
    )]
    Poisson {
        /// The given major Poisson ratio.
        poisson_major: f64,
        /// ν_F²·E_T/E_F.
        product: f64,
        /// The largest admissible |ν_F|.
        limit: f64,
    },
}

impl Orthotropic {
    /// The law from engineering constants: moduli along and across the fibre \[MPa\], major Poisson ratio (strain across
    /// from stress along), shear modulus \[MPa\].
    ///
    /// # Errors
    /// Refused unless E_F, E_T, G > 0 and ν_F²·E_T/E_F < 1, which holds exactly when the matrix is positive definite.
    pub fn new(
        young_fibre: f64,
        young_transverse: f64,
        poisson_major: f64,
        shear_modulus: f64,
    ) -> Result<Self, InadmissibleMaterial> {
        for (name, value) in
            [("young_fibre", young_fibre), ("young_transverse", young_transverse), ("shear_modulus", shear_modulus)]
        {
            if !(1e-100..=1e100).contains(&value) {
                return Err(InadmissibleMaterial::Modulus { name, value });
            }
        }
        let product = poisson_major * poisson_major * young_transverse / young_fibre;
        if !(product < 1.0) {
            let limit = (young_fibre / young_transverse).sqrt();
            return Err(InadmissibleMaterial::Poisson { poisson_major, product, limit });
        }
        let d = 1.0 - product;
        Ok(Self {
            q11: young_fibre / d,
            q12: poisson_major * young_transverse / d,
            q22: young_transverse / d,
            q66: shear_modulus,
        })
    }

    /// Huber's shear modulus √(E_F·E_T)/(2(1+√(ν_F·ν_T))) \[MPa\], the default when none is given; the isotropic value
    /// where E_F = E_T.
    pub fn huber_shear_modulus(young_fibre: f64, young_transverse: f64, poisson_major: f64) -> f64 {
        let mean_poisson = (poisson_major * poisson_major * young_transverse / young_fibre).sqrt();
        (young_fibre * young_transverse).sqrt() / (2.0 * (1.0 + mean_poisson))
    }

    /// Whether this is the law of an incompressible neo-Hookean substance at small strain: 4μ, 2μ, 4μ and μ.
    pub fn is_neo_hookean(&self) -> bool {
        let mu = self.q66;
        let wanted = [(self.q11, 4.0 * mu), (self.q12, 2.0 * mu), (self.q22, 4.0 * mu)];
        // Roundings of engineering constants.
        wanted.into_iter().all(|(found, wanted)| (found - wanted).abs() <= 1e-9 * wanted)
    }

    /// Stress \[MPa\] in the fibre's axes from a strain there (tensor shear).
    #[inline]
    pub fn stress(&self, strain: Sym2) -> Sym2 {
        Sym2::from_array(linear_stress(self.to_array(), strain.to_array()))
    }

    /// Q11, Q12, Q22 and Q66.
    #[inline(always)]
    pub(crate) fn to_array(self) -> [f64; 4] {
        [self.q11, self.q12, self.q22, self.q66]
    }

    /// The isotropic law that answers a change of area alike, and shear in the mean over all directions.
    pub(crate) fn isotropic_mean(&self) -> Self {
        let area = 0.25 * (self.q11 + self.q22 + 2.0 * self.q12);
        let shear = 0.5 * (0.25 * (self.q11 + self.q22 - 2.0 * self.q12) + self.q66);
        Self { q11: area + shear, q12: area - shear, q22: area + shear, q66: shear }
    }

    /// Stress with Q16 and Q26 \[MPa\] beside, which couple strain along and across the fibre with engineering shear.
    #[inline(always)]
    pub fn coupled_stress(&self, [q16, q26]: [f64; 2], strain: Sym2) -> Sym2 {
        let mut stress = self.stress(strain);
        if q16 != 0.0 || q26 != 0.0 {
            stress.xx += 2.0 * q16 * strain.xy;
            stress.yy += 2.0 * q26 * strain.xy;
            stress.xy += q16 * strain.xx + q26 * strain.yy;
        }
        stress
    }

    /// Strain in the fibre's axes (tensor shear) from a stress \[MPa\] there: the inverse of [`stress`](Self::stress).
    #[inline]
    pub fn strain(&self, stress: Sym2) -> Sym2 {
        let determinant = self.q11 * self.q22 - self.q12 * self.q12;
        Sym2::new(
            (self.q22 * stress.xx - self.q12 * stress.yy) / determinant,
            (self.q11 * stress.yy - self.q12 * stress.xx) / determinant,
            stress.xy / (2.0 * self.q66),
        )
    }

    /// The Voigt matrix (xx, yy, xy with engineering shear) \[MPa\] in axes from which the fibre stands at `angle` \[rad\]
    /// counter-clockwise. For checks and output: the engine itself works in the fibre's axes.
    pub fn voigt_matrix(&self, angle: f64) -> [[f64; 3]; 3] {
        let (s, c) = elementary::sin_cos(angle);
        let (c2, s2, cs) = (c * c, s * s, c * s);
        let mixed = self.q12 + 2.0 * self.q66;
        let k11 = self.q11 * c2 * c2 + 2.0 * mixed * s2 * c2 + self.q22 * s2 * s2;
        let k22 = self.q11 * s2 * s2 + 2.0 * mixed * s2 * c2 + self.q22 * c2 * c2;
        let k12 = (self.q11 + self.q22 - 4.0 * self.q66) * s2 * c2 + self.q12 * (c2 * c2 + s2 * s2);
        let k13 = cs * (self.q11 * c2 - self.q22 * s2 - mixed * (c2 - s2));
        let k23 = cs * (self.q11 * s2 - self.q22 * c2 + mixed * (c2 - s2));
        let k33 = (self.q11 + self.q22 - 2.0 * self.q12) * s2 * c2 + self.q66 * (c2 - s2) * (c2 - s2);
        [[k11, k12, k13], [k12, k22, k23], [k13, k23, k33]]
    }
}
