//! The criterion on energy at a tip: the material force is the energy; the field of a plane crack around the tip, if there is one, gives the
//! share of a kink.

use crate::components::{DecidedBy, EnergyCriterion, RingFault, TearDecision, Tearing};
use crate::math::elementary;
use crate::systems::fracture::criterion::by_triangle::in_runs;
use crate::systems::fracture::criterion::tip_decision::{admissible, decision_in_fan};
use crate::systems::fracture::{MaterialForce, Surface, TipMemory, strength};
use crate::systems::kernels::failure::{self, Strength, TipField, evaluate_pull, evaluate_release};
use glam::{DVec2, DVec3};

/// Largest deviation of the energy of a crack's field from the material force. At strains of 10 % a crack's field is off by 22 %
/// (`tests/tearing/one_energy.rs`).
const MOST_OFF: f64 = 0.3;

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

    /// The material force at the `tip`th tip of a body, at `vertex`, in its tangent plane. `None` where the tip has no fan.
    pub fn material_force(
        &self,
        surface: &Surface,
        at: (usize, u32),
        memory: &mut TipMemory,
    ) -> Option<([DVec3; 2], MaterialForce)> {
        let (chart, disc) = memory.shifted_disc(surface, at, strength(self.tearing), self.radii())?;
        Some((chart.axes(), disc.force(surface)?))
    }

    /// The field of a plane crack at the `tip`th tip of a body, at `vertex`, as the interaction integral finds it: not yet of the energy that
    /// the material force releases. `None` where the tip has no fan or no such field.
    pub fn crack_field(&self, surface: &Surface, at: (usize, u32), memory: &mut TipMemory) -> Option<TipField> {
        let (_, disc) = memory.shifted_disc(surface, at, strength(self.tearing), self.radii())?;
        disc.read(surface)?.1.ok()
    }
}

/// Scales the field so that straight ahead it releases as much as the material force `release` \[N/mm\].
fn of_energy(field: TipField, release: DVec2) -> Result<TipField, RingFault> {
    let wanted = release.dot(field.ahead);
    if !(wanted > 0.0) {
        return Err(RingFault::NoRelease);
    }
    let found = field.release();
    if !((found / wanted - 1.0).abs() <= MOST_OFF) {
        return Err(RingFault::OtherField);
    }
    let scale = (wanted / found).sqrt();
    Ok(TipField { intensities: field.intensities.map(|k| k * scale), ..field })
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
    let average = memory.average(surface, (tip, vertex), strength(tearing), tearing.radius)?;
    let (chart, disc) = memory.shifted_disc(surface, (tip, vertex), strength(tearing), terms.radii())?;
    let (force, field) = disc.read(surface)?;
    let (cone, sector) = admissible(tearing, previous, chart);
    let (factors, place) = (&surface.triangles.toughness, (surface, vertex, chart));
    let field = field.and_then(|field| of_energy(field, force.release)).and_then(|field| {
        let answer = in_runs(factors, place, sector, |sector, factor| {
            Some(evaluate_release(&field, &toughness, cone, sector)?.over(factor.sqrt()))
        });
        let answer = answer.filter(|(answer, _)| answer.best.value > 0.0).ok_or(RingFault::NoRelease)?;
        Ok((EnergyReading::Field(field), answer))
    });
    let (reading, (answer, factor)) = match field {
        Ok(found) => found,
        Err(fault) => {
            let (release, fibre) = (force.release, average.fibre);
            let answer = in_runs(factors, place, sector, |sector, factor| {
                Some(evaluate_pull(release, fibre, &toughness, cone, sector)?.over(factor.sqrt()))
            })?;
            (EnergyReading::Pull { release, fibre, fault }, answer)
        }
    };
    let decision = decision_in_fan(vertex, &answer, chart, &average);
    let (fibre, d) = (average.fibre, answer.best.direction);
    let delta = elementary::atan2(fibre.perp_dot(d).abs(), fibre.dot(d).abs());
    let release = Some(answer.best.value * answer.best.value * toughness.threshold(delta) * factor);
    Some((TearDecision { by: reading.by(), release, ..decision }, reading))
}
