//! Materials, strengths and toughnesses that change over time.
//!
//! A step takes the values at its end. Whether they change in it follows from the time alone, so that a resumed run goes on with the same ones.

use super::build;
use super::error::Fault;
use super::schema::{BodySpec, EnergyCriterionSpec, MaterialSpec, TearingSpec, TimeCurve};
use glam::DVec3;
use rhexis::components::{EnergyCriterion, Material, Tearing};
use rhexis::simulation::{SetError, Simulation};
use rhexis::storage::BodyId;
use std::sync::Arc;

type Grading = dyn Fn(Material, DVec3) -> Material + Send + Sync;

/// A body whose values change.
#[derive(Clone)]
pub(super) struct Changing {
    material: MaterialSpec,
    grading: Option<Arc<Grading>>,
    tearing: Option<TearingSpec>,
    energy: Option<EnergyCriterionSpec>,
    /// Thickness is that of each triangle.
    keeps_thickness: bool,
    key: String,
}

/// Values at one time.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Values {
    material: Material,
    tearing: Option<Tearing>,
    criterion: Option<EnergyCriterion>,
}

impl Changing {
    /// Changes of a body, judged at every point of its curves; `None` without any. `key` is the path of the body in the scene.
    pub(crate) fn of(spec: &BodySpec, key: &str) -> Result<Option<Self>, Fault> {
        let changes = |spec: &MaterialSpec| curves(spec).any(|curve| !is_constant(curve));
        for (i, part) in spec.materials.iter().enumerate() {
            if changes(&part.material) {
                let hint = "give the part numbers, or make it a body of its own";
                let key = format!("{key}.materials.{i}.material");
                return Err(Fault::new(key, "a material that changes over time is that of a whole body", hint));
            }
        }
        if changes(&spec.material) && !spec.materials.is_empty() {
            let hint = "give numbers, or remove `materials`";
            let key = format!("{key}.material");
            return Err(Fault::new(key, "a material that changes over time is that of a whole body", hint));
        }
        let keeps_thickness = spec.per_triangle.as_ref().is_some_and(|values| values.thickness.is_some());
        if keeps_thickness && !is_constant(&spec.material.thickness) {
            let hint = "give one number, or remove `per_triangle.thickness`";
            let key = format!("{key}.material.thickness");
            return Err(Fault::new(key, "a thickness that changes over time is that of a whole body", hint));
        }
        let of_tearing = spec.tearing.iter().flat_map(|tearing| {
            let TearingSpec {
                strength_along_fibres,
                strength_across_fibres,
                toughness_along_fibres,
                toughness_across_fibres,
                ..
            } = tearing;
            let strengths = [strength_along_fibres, strength_across_fibres];
            strengths.into_iter().chain([toughness_along_fibres, toughness_across_fibres]).flatten()
        });
        let of_energy = spec.energy_criterion.iter();
        let of_energy = of_energy.flat_map(|energy| [&energy.toughness_along_fibres, &energy.toughness_across_fibres]);
        let all = curves(&spec.material).chain(of_tearing).chain(of_energy);
        let all: Vec<&TimeCurve> = all.filter(|curve| !is_constant(curve)).collect();
        if all.is_empty() {
            return Ok(None);
        }
        let grading = spec.grading.as_ref().map(|spec| build::grading(spec, &format!("{key}.grading"))).transpose()?;
        let changing = Self {
            material: spec.material.clone(),
            grading: grading.map(|grading| Arc::new(grading) as Arc<Grading>),
            tearing: spec.tearing.clone(),
            energy: spec.energy_criterion.clone(),
            keeps_thickness,
            key: key.to_owned(),
        };
        // Between their points curves are linear, and so are the conditions on moduli: what holds at the points holds between them.
        for &(time, _) in all.iter().flat_map(|curve| curve.0.points()) {
            let at = |fault: Fault| Fault { what: format!("at {time} ms: {}", fault.what), ..fault };
            let values = changing.values(time).map_err(at)?;
            if let (Some(grading), Some(spec)) = (&changing.grading, &spec.grading) {
                // Moduli at the rim are the farthest from those on the axis.
                let rim = spec.centre.0 + spec.axis.0.normalize().any_orthonormal_vector() * spec.radius;
                let refused = |error| at(Fault::new(format!("{key}.grading"), error, "choose a ratio nearer to 1"));
                grading(values.material, rim).stiffness().map_err(refused)?;
            }
        }
        Ok(Some(changing))
    }

    fn values(&self, time: f64) -> Result<Values, Fault> {
        let Self { material, tearing, energy, key, .. } = self;
        let material = build::material(material, time, &format!("{key}.material"))?;
        let present = (&material, time);
        let criterion = build::tip_criterion((tearing, energy), present, key)?;
        let own = tearing.as_ref().map(|spec| build::tearing(spec, present, &format!("{key}.tearing")));
        Ok(Values { material, tearing: own.transpose()?, criterion })
    }

    /// Gives a body the values at the end of the step from a time to another \[ms\], if they are others than at its start.
    ///
    /// # Errors
    /// If the engine refuses them.
    pub(crate) fn before(
        &self,
        simulation: &mut Simulation,
        body: BodyId,
        (start, end): (f64, f64),
    ) -> Result<(), SetError> {
        // They were judged when the scene was built.
        let (Ok(old), Ok(new)) = (self.values(start), self.values(end)) else { return Ok(()) };
        if old.material != new.material {
            simulation.set_material(body, |at, thickness| {
                let material = self.grading.as_ref().map_or(new.material, |grading| grading(new.material, at));
                Material { thickness: if self.keeps_thickness { thickness } else { material.thickness }, ..material }
            })?;
        }
        if let Some(tearing) = new.tearing.filter(|tearing| Some(*tearing) != old.tearing) {
            simulation.set(body, tearing)?;
        }
        match new.criterion.filter(|criterion| Some(*criterion) != old.criterion) {
            Some(criterion) => simulation.set(body, criterion),
            None => Ok(()),
        }
    }
}

fn curves(spec: &MaterialSpec) -> impl Iterator<Item = &TimeCurve> {
    let MaterialSpec { mu, young, young_fibre, young_transverse, shear_modulus, thickness, .. } = spec;
    [mu, young, young_fibre, young_transverse, shear_modulus].into_iter().flatten().chain([thickness])
}

fn is_constant(curve: &TimeCurve) -> bool {
    curve.0.points().windows(2).all(|pair| pair[0].1 == pair[1].1)
}
