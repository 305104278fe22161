//! The criterion on energy at a tip: from the field in the ring around it where that is a plane crack's, by the material force where
//! it is not.

use crate::components::{DecidedBy, EnergyCriterion, RingFault, TearDecision, Tearing};
use crate::math::elementary;
use crate::systems::fracture::criterion::by_triangle::in_runs;
use crate::systems::fracture::criterion::tip_decision::{admissible, decision_in_fan};
use crate::systems::fracture::{Contour, MaterialForce, Surface, TipMemory, strength};
use crate::systems::kernels::failure::{self, Strength, TipField, evaluate_pull, evaluate_release};
use glam::{DVec2, DVec3};

/// Material data by which a body's tips decide.
#[derive(Clone, Copy, Debug)]
pub struct EnergyTerms<'a> {
    /// Cone, exponent and R.
    pub tearing: &'a Tearing,
    /// Toughness and ring.
    pub energy: &'a EnergyCriterion,
}

/// Energy release at a tip as a function of the direction of advance.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum EnergyReading {
    /// The field of a plane crack, which knows how a kink unloads its surroundings.
    Field(TipField),
    /// The material force, right for advances that do not turn far.
    Pull {
        /// Energy released per area of tear \[N/mm\].
        release: DVec2,
        /// Unit direction of the fibre.
        fibre: DVec2,
        /// Reason why there is no field.
        fault: RingFault,
    },
}

impl EnergyReading {
    /// √(G/G_c) of a unit direction.
    pub fn value(&self, toughness: &Strength, direction: DVec2) -> f64 {
        match self {
            Self::Field(field) => failure::release_value(field, toughness, direction),
            Self::Pull { release, fibre, .. } => failure::pull_value(*release, *fibre, toughness, direction),
        }
    }

    fn by(&self) -> DecidedBy {
        match self {
            Self::Field(_) => DecidedBy::Energy,
            Self::Pull { fault, .. } => DecidedBy::MaterialForce(*fault),
        }
    }
}

impl EnergyTerms<'_> {
    /// Toughness by direction, in the place of strengths.
    pub fn toughness(&self) -> Strength {
        let toughness = self.energy.toughness;
        Strength { fibre: toughness.across, transverse: toughness.along, exponent: self.tearing.exponent }
    }

    /// R and the radius of the ring \[mm\].
    fn radii(&self) -> (f64, f64) {
        (self.tearing.radius, self.energy.ring * self.tearing.radius)
    }

    /// The field in the ring at the `tip`th tip of a body, at `vertex`, and J \[N/mm\]: the energy released per area of a crack
    /// that goes straight on. `None` where the ring has no such field.
    pub fn contour(&self, surface: &Surface, at: (usize, u32), memory: &mut TipMemory) -> Option<Contour> {
        let (.., ring) = memory.at_tip_with_ring(surface, at, strength(self.tearing), self.radii())?;
        ring.contour(surface).ok()
    }

    /// The material force at the `tip`th tip of a body, at `vertex`, in its tangent plane. `None` where the tip has no fan.
    pub fn material_force(
        &self,
        surface: &Surface,
        at: (usize, u32),
        memory: &mut TipMemory,
    ) -> Option<([DVec3; 2], MaterialForce)> {
        let (chart, force) = memory.material_force(surface, at, strength(self.tearing), self.radii())?;
        Some((chart.axes(), force))
    }
}

/// Decision at a tip by the energy criterion, as `tip_decision` by strength; with the release that it was found from.
pub fn energy_decision(
    surface: &Surface,
    terms: EnergyTerms<'_>,
    tip: usize,
    (vertex, previous): (u32, DVec3),
    memory: &mut TipMemory,
) -> Option<(TearDecision, EnergyReading)> {
    let (tearing, toughness) = (terms.tearing, terms.toughness());
    let (chart, average, ring) = memory.at_tip_with_ring(surface, (tip, vertex), strength(tearing), terms.radii())?;
    let (cone, sector) = admissible(tearing, previous, chart);
    let (factors, place) = (&surface.triangles.toughness, (surface, vertex, chart));
    let field = ring.contour(surface).map(|contour| contour.field).and_then(|field| {
        let answer = in_runs(factors, place, sector, |sector, factor| {
            Some(evaluate_release(&field, &toughness, cone, sector)?.over(factor.sqrt()))
        });
        let answer = answer.filter(|(answer, _)| answer.best.value > 0.0).ok_or(RingFault::NoRelease)?;
        Ok((EnergyReading::Field(field), answer))
    });
    let (reading, (answer, factor)) = match field {
        Ok(found) => found,
        Err(fault) => {
            let (chart, force) = memory.material_force(surface, (tip, vertex), strength(tearing), terms.radii())?;
            let (release, fibre) = (force.release, average.fibre);
            let place = (surface, vertex, chart);
            let answer = in_runs(factors, place, sector, |sector, factor| {
                Some(evaluate_pull(release, fibre, &toughness, cone, sector)?.over(factor.sqrt()))
            })?;
            (EnergyReading::Pull { release, fibre, fault }, answer)
        }
    };
    let decision = decision_in_fan(vertex, &answer, &surface.chart(vertex)?, &average);
    let (fibre, d) = (average.fibre, answer.best.direction);
    let delta = elementary::atan2(fibre.perp_dot(d).abs(), fibre.dot(d).abs());
    let release = Some(answer.best.value * answer.best.value * toughness.threshold(delta) * factor);
    Some((TearDecision { by: reading.by(), release, ..decision }, reading))
}
