//! The criterion on energy at a tip, from the ring around it; that on stress where the ring tells nothing.

use super::tip_decision::{admissible, decision_in_fan, in_fan};
use super::{Contour, Surface, TipMemory, strength};
use crate::components::{DecidedBy, EnergyCriterion, RingFault, TearDecision, Tearing};
use crate::systems::kernels::failure::{Strength, evaluate_release};
use glam::DVec3;

/// What a body's tips decide by.
#[derive(Clone, Copy, Debug)]
pub struct EnergyTerms<'a> {
    /// Cone, exponent, R, and the strengths for where there is no energy to tell of.
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

    /// The field in the ring at the `tip`th tip of a body, at `vertex`, and J \[N/mm\]: the energy released per area of a crack
    /// that goes straight on. `None` where the stress decides.
    pub fn contour(&self, surface: &Surface, (tip, vertex): (usize, u32), memory: &mut TipMemory) -> Option<Contour> {
        let radii = (self.tearing.radius, self.energy.ring * self.tearing.radius);
        let (.., ring) = memory.at_tip_with_ring(surface, (tip, vertex), strength(self.tearing), radii)?;
        ring.contour(surface).ok()
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
    let EnergyTerms { tearing, energy } = terms;
    let radii = (tearing.radius, energy.ring * tearing.radius);
    let (chart, search, average, ring) = memory.at_tip_with_ring(surface, (tip, vertex), strength(tearing), radii)?;
    let released = ring.contour(surface).and_then(|contour| {
        let (cone, sector) = admissible(tearing, previous, chart);
        let answer = evaluate_release(&contour.field, &terms.toughness(), cone, sector);
        answer.filter(|answer| answer.best.value > 0.0).ok_or(RingFault::NoRelease)
    });
    match released {
        Ok(answer) => Some(TearDecision { by: DecidedBy::Energy, ..decision_in_fan(vertex, &answer, chart, &average) }),
        Err(fault) => {
            let decision = in_fan(tearing, (vertex, previous), chart, search, &average)?;
            Some(TearDecision { by: DecidedBy::StressFor(fault), ..decision })
        }
    }
}
