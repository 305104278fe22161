//! The criterion on energy at a tip: from the field in the ring around it where that is a plane crack's, by the material force where
//! it is not.

use super::tip_decision::{admissible, decision_in_fan};
use super::{Contour, MaterialForce, Surface, TipMemory, strength};
use crate::components::{DecidedBy, EnergyCriterion, RingFault, TearDecision, Tearing};
use crate::systems::kernels::failure::{Strength, evaluate_pull, evaluate_release};
use glam::DVec3;

/// What a body's tips decide by.
#[derive(Clone, Copy, Debug)]
pub struct EnergyTerms<'a> {
    /// Cone, exponent and R.
    pub tearing: &'a Tearing,
    /// Toughness and ring.
    pub energy: &'a EnergyCriterion,
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

    /// The material force at the `tip`th tip of a body, at `vertex`, in the rest shape. `None` where the tip has no fan.
    pub fn material_force(
        &self,
        surface: &Surface,
        at: (usize, u32),
        memory: &mut TipMemory,
    ) -> Option<(DVec3, MaterialForce)> {
        let (chart, force) = memory.material_force(surface, at, strength(self.tearing), self.radii())?;
        let [x, y] = chart.axes();
        Some((x * force.release.x + y * force.release.y, force))
    }
}

/// As [`tip_decision`](super::tip_decision), by energy.
pub fn energy_decision(
    surface: &Surface,
    terms: EnergyTerms<'_>,
    tip: usize,
    (vertex, previous): (u32, DVec3),
    memory: &mut TipMemory,
) -> Option<TearDecision> {
    let tearing = terms.tearing;
    let (chart, average, ring) =
        memory.at_tip_with_ring(surface, (tip, vertex), strength(tearing), terms.radii())?;
    let (cone, sector) = admissible(tearing, previous, chart);
    let fault = match ring.contour(surface) {
        Err(fault) => fault,
        Ok(contour) => match evaluate_release(&contour.field, &terms.toughness(), cone, sector) {
            Some(answer) if answer.best.value > 0.0 => {
                let decision = decision_in_fan(vertex, &answer, chart, &average);
                return Some(TearDecision { by: DecidedBy::Energy, ..decision });
            }
            _ => RingFault::NoRelease,
        },
    };
    let (chart, force) = memory.material_force(surface, (tip, vertex), strength(tearing), terms.radii())?;
    let answer = evaluate_pull(force.release, average.fibre, &terms.toughness(), cone, sector)?;
    Some(TearDecision { by: DecidedBy::MaterialForce(fault), ..decision_in_fan(vertex, &answer, chart, &average) })
}
