//! The law of a body's fibres, whichever it has.

use super::{Orthotropic, PreparedLaw, StiffeningFibres, Sym2};

/// Law of a triangle beside the linear one, or in its place.
#[expect(clippy::large_enum_variant, reason = "there is one per body and step, which its triangles borrow")]
#[derive(Clone, Copy, Debug)]
pub enum FibreLaw {
    /// Fibres that stiffen by their stretch, beside it.
    Stiffening(StiffeningFibres),
    /// Law of Holzapfel, Gasser and Ogden, with its own matrix or beside the linear law.
    Published(PreparedLaw),
}

impl FibreLaw {
    /// Whether it holds in place of the linear law.
    #[inline]
    pub fn replaces_linear(&self) -> bool {
        match self {
            Self::Stiffening(_) => false,
            Self::Published(law) => law.replaces_linear(),
        }
    }

    /// Stiffness \[MPa\] with which fibres begin to be drawn out.
    pub fn first_stiffness(&self) -> f64 {
        match self {
            Self::Stiffening(fibres) => fibres.k1,
            Self::Published(law) => law.first_stiffness(),
        }
    }

    /// Energy per volume \[mJ/mm³\] of the fibre law alone at a stretch, in a triangle of a material.
    pub fn energy(&self, stretch: Sym2, unstretched: Sym2, material: &Orthotropic) -> f64 {
        match self {
            Self::Stiffening(fibres) => fibres.energy(stretch, unstretched),
            Self::Published(law) => law.energy(stretch, material.q66),
        }
    }

    /// Biot stress \[MPa\] of the fibre law alone.
    #[inline]
    fn own_stress(&self, stretch: Sym2, unstretched: Sym2, material: &Orthotropic) -> Sym2 {
        match self {
            Self::Stiffening(fibres) => fibres.biot(stretch, unstretched),
            Self::Published(law) => law.stress(stretch, material.q66),
        }
    }

    /// Biot stress \[MPa\] of a triangle at a stretch, from that of the `linear` law.
    #[inline]
    pub fn stress(
        this: Option<&Self>,
        stretch: Sym2,
        unstretched: Sym2,
        (linear, material): (Sym2, &Orthotropic),
    ) -> Sym2 {
        let Some(law) = this else { return linear };
        let own = law.own_stress(stretch, unstretched, material);
        if law.replaces_linear() { own } else { linear + own }
    }

    /// Twice the energy per volume \[MPa\] of a triangle at a stretch; without a law from the `stress` there.
    #[inline]
    pub fn twice_energy(
        this: Option<&Self>,
        stretch: Sym2,
        unstretched: Sym2,
        (stress, material): (Sym2, &Orthotropic),
    ) -> f64 {
        let strain = stretch - unstretched;
        let Some(law) = this else { return stress.contract(strain) };
        let own = 2.0 * law.energy(stretch, unstretched, material);
        if law.replaces_linear() { own } else { own + material.stress(strain).contract(strain) }
    }

    /// Biot stress \[MPa\] of a triangle at a stretch, from that of its `linear` law, and the stiffness ∂²W/∂U² there, from that of the
    /// linear law: positive semidefinite.
    pub fn answer(
        &self,
        stretch: Sym2,
        unstretched: Sym2,
        (linear, stiffness): (Sym2, &Orthotropic),
        material: &Orthotropic,
    ) -> (Sym2, CoupledStiffness) {
        match self {
            Self::Stiffening(fibres) => {
                (linear + fibres.biot(stretch, unstretched), fibres.stiffness(stretch, unstretched, stiffness))
            }
            Self::Published(law) => {
                let (own, stiffness) = law.answer(stretch, stiffness, material.q66);
                (if law.replaces_linear() { own } else { linear + own }, stiffness)
            }
        }
    }
}

/// Stiffness that couples strains and shear.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CoupledStiffness {
    /// Orthotropic part of the stiffness.
    pub law: Orthotropic,
    /// Stress along the fibre per engineering shear \[MPa\].
    pub q16: f64,
    /// Stress across the fibre per engineering shear \[MPa\].
    pub q26: f64,
}

impl CoupledStiffness {
    /// Adds `stiffness`·(A:dU)².
    pub(super) fn add_square(&mut self, a: Sym2, stiffness: f64) {
        let Self { law, q16, q26 } = self;
        law.q11 += stiffness * a.xx * a.xx;
        law.q12 += stiffness * a.xx * a.yy;
        law.q22 += stiffness * a.yy * a.yy;
        law.q66 += stiffness * a.xy * a.xy;
        *q16 += stiffness * a.xx * a.xy;
        *q26 += stiffness * a.yy * a.xy;
    }
}
