//! The tissue's elastic constants, thickness and density.

use crate::math::{InadmissibleMaterial, Orthotropic};

/// Linear, transversely isotropic membrane material in engineering constants. *Parameter* at spawning; each triangle keeps
/// its own matrix.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Material {
    /// Young's modulus along the fibre E_F \[MPa\], > 0.
    pub young_fibre: f64,
    /// Young's modulus across the fibre E_T \[MPa\], > 0.
    pub young_transverse: f64,
    /// Major Poisson ratio ν_F: strain across from stress along. ν_F²·E_T/E_F must stay below 1.
    pub poisson_major: f64,
    /// In-plane shear modulus G \[MPa\], > 0; Huber's √(E_F·E_T)/(2(1+√(ν_F·ν_T))) where `None`.
    pub shear_modulus: Option<f64>,
    /// Thickness h \[mm\], > 0.
    pub thickness: f64,
    /// Density \[g/mm³\], > 0; soft tissue is near 1e-3.
    pub density: f64,
}

impl Material {
    /// An isotropic material; thickness in mm, density 1e-3 g/mm³.
    pub fn isotropic(young: f64, poisson: f64, thickness: f64) -> Self {
        Self {
            young_fibre: young,
            young_transverse: young,
            poisson_major: poisson,
            shear_modulus: None,
            thickness,
            density: 1e-3,
        }
    }

    /// An incompressible substance with the shear modulus `mu` \[MPa\], c of the papers: E = 3μ, ν = 0.5; thickness in mm, density 1e-3 g/mm³.
    /// The matrix of a [`HolzapfelGasserOgden`](crate::components::HolzapfelGasserOgden) that is neo-Hookean.
    pub fn neo_hookean(mu: f64, thickness: f64) -> Self {
        Self { shear_modulus: Some(mu), ..Self::isotropic(3.0 * mu, 0.5, thickness) }
    }

    /// The material of Figure 2 of Allard, Marchal and Cotin 2009: E_F 10, E_T 1, G 0.5 MPa, ν_F 0.3, 0.1 mm thick.
    pub fn allard_2009() -> Self {
        Self {
            young_fibre: 10.0,
            young_transverse: 1.0,
            poisson_major: 0.3,
            shear_modulus: Some(0.5),
            thickness: 0.1,
            density: 1e-3,
        }
    }

    /// The matrix in the fibre's frame.
    ///
    /// # Errors
    /// If the constants are not admissible.
    pub fn stiffness(&self) -> Result<Orthotropic, InadmissibleMaterial> {
        let shear = self.shear_modulus.unwrap_or_else(|| {
            Orthotropic::huber_shear_modulus(self.young_fibre, self.young_transverse, self.poisson_major)
        });
        Orthotropic::new(self.young_fibre, self.young_transverse, self.poisson_major, shear)
    }
}
