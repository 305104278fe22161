//! The law of a triangle in a plane that has nearly been turned into its mirror image.

use super::{Orthotropic, Sym2, elementary};

/// tr U from which on down the law loses its directions: that of a mean stretch of a quarter.
pub const FADES_FROM: f64 = 0.5;

/// How much of a law is left in a triangle of a planar body where tr U is small.
///
/// In a plane F is a turn and a stretch of all directions alike, p, and a mirror image, q, of the sizes |p| = tr U and
/// |q| = |dev U|·√2: where p vanishes the rotation may be any, and with it the axes of the tissue in the mirror image. An anisotropic law
/// has there as many energies as there are rotations, and a body that passes by gains the energy of the steepest step between them. So from
/// t₀ = [`FADES_FROM`] on down the energy is that of w·E + (1 − w)·Ē with w = s³·(10 − 15s + 6s²), s = tr U/t₀: Ē, of the law's
/// isotropic mean (`Orthotropic::isotropic_mean`), knows of the rotation nothing. Both are positive, hence so is every mixture, and the
/// stress T = w·∂E/∂U + (1 − w)·∂Ē/∂U + w′·(E − Ē)·I has no step either. In space tr U is at least |F|, and nothing fades.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Faded {
    weight: f64,
    slope: f64,
    curvature: f64,
}

impl Faded {
    /// Faded law at a stretch; `None` where nothing has faded.
    #[inline]
    pub fn at(stretch: Sym2, is_planar: bool) -> Option<Self> {
        let s = stretch.trace() / FADES_FROM;
        if !is_planar || s >= 1.0 {
            return None;
        }
        let s = s.max(0.0);
        Some(Self {
            weight: s * s * s * (10.0 + s * (6.0 * s - 15.0)),
            slope: 30.0 * elementary::powi(s * (1.0 - s), 2) / FADES_FROM,
            curvature: 60.0 * s * (1.0 - s) * (1.0 - 2.0 * s) / (FADES_FROM * FADES_FROM),
        })
    }

    /// Strain and stress of a law and of its mean.
    fn both(law: &Orthotropic, stretch: Sym2, unstretched: Sym2) -> [(Sym2, Sym2); 2] {
        let all_alike = 0.5 * unstretched.trace();
        let (strain, mean) = (stretch - unstretched, stretch - Sym2::new(all_alike, all_alike, 0.0));
        [(strain, law.stress(strain)), (mean, law.isotropic_mean().stress(mean))]
    }

    /// Biot stress \[MPa\] at a stretch, `unstretched` being free of it.
    pub fn stress(&self, law: &Orthotropic, stretch: Sym2, unstretched: Sym2) -> Sym2 {
        let [own, mean] = Self::both(law, stretch, unstretched);
        let pressure = 0.5 * self.slope * (own.1.contract(own.0) - mean.1.contract(mean.0));
        own.1 * self.weight + mean.1 * (1.0 - self.weight) + Sym2::new(pressure, pressure, 0.0)
    }

    /// Twice the energy per volume \[MPa\] there.
    pub fn twice_energy(&self, law: &Orthotropic, stretch: Sym2, unstretched: Sym2) -> f64 {
        let [own, mean] = Self::both(law, stretch, unstretched);
        self.weight * own.1.contract(own.0) + (1.0 - self.weight) * mean.1.contract(mean.0)
    }

    /// A law for tangents that is nowhere softer than the energy's second derivative. With C between the two laws, ΔT and ΔE the
    /// differences of stress and energy, that derivative is dU:C:dU + 2w′·tr dU·ΔT:dU + w″·ΔE·(tr dU)². It is at most 2·dU:C:dU +
    /// (w″·ΔE + w′²·ΔT:C⁻¹:ΔT)·(tr dU)².
    pub fn majorant(&self, law: &Orthotropic, stretch: Sym2, unstretched: Sym2) -> Orthotropic {
        let mean = law.isotropic_mean();
        let mix = |own: f64, mean: f64| mean + self.weight * (own - mean);
        let mixed = Orthotropic {
            q11: mix(law.q11, mean.q11),
            q12: mix(law.q12, mean.q12),
            q22: mix(law.q22, mean.q22),
            q66: mix(law.q66, mean.q66),
        };
        let [own, mean] = Self::both(law, stretch, unstretched);
        let (stress, energy) = (own.1 - mean.1, 0.5 * (own.1.contract(own.0) - mean.1.contract(mean.0)));
        let turned = self.slope * self.slope * mixed.strain(stress).contract(stress);
        let area = (self.curvature * energy + turned).max(0.0);
        Orthotropic {
            q11: 2.0 * mixed.q11 + area,
            q12: 2.0 * mixed.q12 + area,
            q22: 2.0 * mixed.q22 + area,
            q66: 2.0 * mixed.q66,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const LAW: Orthotropic = Orthotropic { q11: 100.0, q12: 2.0, q22: 3.0, q66: 0.7 };

    #[test]
    fn the_stress_is_the_gradient_of_the_energy() {
        let unstretched = Sym2::new(0.97, 1.02, 0.01);
        for stretch in [Sym2::new(1.1, -0.9, 0.3), Sym2::new(0.1, 0.05, 0.02), Sym2::new(-0.4, 0.85, -0.6)] {
            let energy = |u: Sym2| 0.5 * Faded::at(u, true).unwrap().twice_energy(&LAW, u, unstretched);
            let stress = Faded::at(stretch, true).unwrap().stress(&LAW, stretch, unstretched);
            let h = 1e-5;
            for rate in [Sym2::new(1.0, 0.0, 0.0), Sym2::new(0.0, 1.0, 0.0), Sym2::new(0.0, 0.0, 1.0)] {
                let slope = (energy(stretch + rate * h) - energy(stretch - rate * h)) / (2.0 * h);
                // The third derivative, of some 1e4 MPa, times h²/6.
                assert!((slope - stress.contract(rate)).abs() < 1e-5, "{stretch:?}: {slope} {stress:?}");
            }
        }
    }

    #[test]
    fn a_mirror_image_has_one_energy_whatever_its_rotation() {
        for degrees in [0.0_f64, 17.0, 45.0, 80.0, 90.0] {
            let (s, c) = (2.0 * degrees.to_radians()).sin_cos();
            let stretch = Sym2::new(0.8 * c, -0.8 * c, 0.8 * s);
            let energy = Faded::at(stretch, true).unwrap().twice_energy(&LAW, stretch, Sym2::new(0.9, 1.0, 0.02));
            let mean = LAW.isotropic_mean();
            let strain = Sym2::new(0.8 - 0.95, -0.8 - 0.95, 0.0);
            let expected = mean.stress(strain).contract(strain);
            assert!((energy - expected).abs() < 1e-12 * expected, "{degrees}: {energy} {expected}");
        }
    }

    #[test]
    fn nothing_fades_in_space_or_from_a_quarter_of_the_stretch_on() {
        assert_eq!(Faded::at(Sym2::new(0.1, 0.1, 0.0), false), None);
        assert_eq!(Faded::at(Sym2::new(0.25, 0.25, 0.0), true), None);
        let edge = Sym2::new(0.3, 0.2 - 1e-9, 0.1);
        let (faded, stress) = (Faded::at(edge, true).unwrap(), LAW.stress(edge - Sym2::IDENTITY));
        let d = faded.stress(&LAW, edge, Sym2::IDENTITY) - stress;
        // The shortfall from t₀ enters the slope of the weight squared.
        assert!(d.xx.abs().max(d.yy.abs()).max(d.xy.abs()) < 1e-12, "{d:?}");
    }

    #[test]
    fn no_change_of_stress_is_stiffer_than_the_majorant() {
        let unstretched = Sym2::new(0.97, 1.02, 0.01);
        for stretch in [Sym2::new(1.1, -0.9, 0.3), Sym2::new(0.1, 0.05, 0.02), Sym2::new(-0.4, 0.85, -0.6)] {
            let stress = |u: Sym2| Faded::at(u, true).unwrap().stress(&LAW, u, unstretched);
            let majorant = Faded::at(stretch, true).unwrap().majorant(&LAW, stretch, unstretched);
            let h = 1e-6;
            for k in 0..24 {
                let (a, b) = (f64::from(k) * 0.7, f64::from(k) * 1.3);
                let rate = Sym2::new(a.cos(), a.sin() * b.cos(), a.sin() * b.sin());
                let change = (stress(stretch + rate * h) - stress(stretch - rate * h)) * (0.5 / h);
                let (true_one, bound) = (change.contract(rate), majorant.stress(rate).contract(rate));
                assert!(true_one <= bound, "{stretch:?} {rate:?}: {true_one} {bound}");
            }
        }
    }
}
