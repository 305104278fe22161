//! From `stiffening_fibres`, `holzapfel_gasser_ogden` and a neo-Hookean `material` to the law of a body.

use super::error::{Fault, positive};
use super::schema::{BodySpec, FibreFamilySpec, MaterialModelSpec, MaterialSpec, StiffeningFibresSpec};
use rhexis::components::{FibreFamily, GroundSubstance, HolzapfelGasserOgden, Material, StiffeningFibres};
use rhexis::math::Sym2;
use rhexis::membrane::Membrane;

/// The material at a time \[ms\] where its `model` is neo-Hookean; `None` where it is linear.
pub(super) fn neo_hookean(spec: &MaterialSpec, time: f64, key: &str) -> Result<Option<Material>, Fault> {
    let at_mu = format!("{key}.mu");
    if spec.model == MaterialModelSpec::Linear {
        let Some(_) = &spec.mu else { return Ok(None) };
        let hint = "add `model = \"neo_hookean\"`, or give `young` and `poisson`";
        return Err(Fault::new(at_mu, "`mu` belongs to a neo-Hookean material", hint));
    }
    let moduli = [&spec.young, &spec.young_fibre, &spec.young_transverse, &spec.shear_modulus];
    let ratios = [spec.poisson, spec.poisson_major];
    if moduli.iter().any(|modulus| modulus.is_some()) || ratios.iter().any(Option::is_some) {
        let hint = "keep `mu` and `thickness`, or leave `model` out";
        return Err(Fault::new(key, "a neo-Hookean material is incompressible and has one constant, `mu`", hint));
    }
    let Some(mu) = &spec.mu else {
        let hint = "add `mu = …` in MPa, c of the papers: the energy is mu/2·(I₁ − 3)";
        return Err(Fault::new(key, "the shear modulus `mu` is missing", hint));
    };
    let mu = positive(at_mu, mu.at(time), "MPa")?;
    Ok(Some(Material { density: spec.density, ..Material::neo_hookean(mu, spec.thickness.at(time)) }))
}

/// Gives a membrane the law of its fibres and of their matrix, if that is not the linear one alone.
pub(super) fn fibre_law(mut membrane: Membrane, spec: &BodySpec, key: &str) -> Result<Membrane, Fault> {
    let at = |name: &str| format!("{key}.{name}");
    if let Some(StiffeningFibresSpec { k1, k2 }) = spec.stiffening_fibres {
        let fibres = StiffeningFibres { k1, k2 };
        if let Err((what, value, must)) = fibres.check() {
            return Err(Fault::new(at("stiffening_fibres"), format!("{what} is {value}"), must));
        }
        membrane = membrane.with(fibres);
    }
    let is_neo_hookean = spec.material.model == MaterialModelSpec::NeoHookean;
    let place = if spec.holzapfel_gasser_ogden.is_some() { "holzapfel_gasser_ogden" } else { "material.model" };
    if spec.holzapfel_gasser_ogden.is_none() && !is_neo_hookean {
        return Ok(membrane);
    }
    let families = spec.holzapfel_gasser_ogden.iter().flat_map(|law| &law.0).flat_map(families).collect();
    let law = HolzapfelGasserOgden {
        families,
        matrix: if is_neo_hookean { GroundSubstance::NeoHookean } else { GroundSubstance::Linear },
    };
    if let Err((what, value, must)) = law.check(spec.pre_stretch.map_or(Sym2::ZERO, |strain| strain.0)) {
        return Err(Fault::new(at(place), format!("{what} is {value}"), must));
    }
    if spec.stiffening_fibres.is_some() {
        let what = "`stiffening_fibres` stand beside the linear law alone";
        return Err(Fault::new(at(place), what, "remove one of the two"));
    }
    if is_neo_hookean && spec.grading.is_some() {
        let what = "a neo-Hookean material is isotropic, and a grading changes its moduli by direction";
        return Err(Fault::new(at("grading"), what, "remove `grading`, or give linear constants"));
    }
    Ok(membrane.with(law))
}

fn families(spec: &FibreFamilySpec) -> impl Iterator<Item = FibreFamily> {
    let &FibreFamilySpec { k1, k2, kappa, .. } = spec;
    spec.degrees.0.iter().map(move |&degrees| FibreFamily { k1, k2, degrees, kappa })
}
