//! Membrane stresses and criterion values of a body as it stands, whether it steps or not.

use super::{Simulation, SimulationError};
use crate::components::{EnergyCriterion, Forces, TearDecision, Tearing};
use crate::math::Sym2;
use crate::storage::{BodyId, Tips, Topology, Triangles, Vertices};
use crate::systems::forces::assembly::membrane_forces;
use crate::systems::fracture::{EnergyTerms, Surface, SurfaceQuery, TipMemory, energy_decision, tip_decision};
use glam::DVec3;

/// State of the tissue at a point of it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Reading {
    /// Position \[mm\].
    pub position: DVec3,
    /// Velocity \[mm/ms\].
    pub velocity: DVec3,
    /// Biot stress of its triangle \[MPa\] in the axes (fibre, transverse).
    pub stress: Sym2,
}

impl Simulation {
    /// State at the point of the tissue that lies nearest to a point \[mm\] of the rest shape. `None` as with [`current`](Self::current).
    ///
    /// # Examples
    /// ```
    /// # let (mut simulation, body) = rhexis::internal::example()?;
    /// # use rhexis::prelude::*;
    /// simulation.step(5.0)?;
    /// let reading = simulation.reading(body, DVec3::new(5.0, 5.0, 0.0)).expect("a body");
    /// println!("{} MPa at {}", reading.stress.principal_values().0, reading.position);
    /// # Ok::<(), rhexis::Error>(())
    /// ```
    pub fn reading(&self, body: BodyId, rest_point: DVec3) -> Option<Reading> {
        let hit = self.current(body, rest_point)?;
        let frames = self.present_frames(body).ok()?;
        let mut query = self.world.query_one::<(&Vertices, &Triangles)>(body.entity());
        let (vertices, triangles) = query.get().ok()?;
        let row = triangles.row(hit.triangle)? as usize;
        let stress = frames.state(row).stress;
        let corners = triangles.corners[row].map(|v| vertices.velocity[v as usize]);
        let velocity = corners.iter().zip(hit.barycentric).map(|(velocity, weight)| *velocity * weight).sum();
        Some(Reading { position: hit.position, velocity, stress })
    }

    /// Criterion at every tip of the body as it stands, in the order of the tips' rows; `None` where no direction is admissible. Empty for a
    /// body that cannot tear.
    ///
    /// # Errors
    /// If there is no such body.
    pub fn tip_decisions(&self, body: BodyId) -> Result<Vec<Option<TearDecision>>, SimulationError> {
        type Query<'a> = (SurfaceQuery<'a>, Option<(&'a Tearing, &'a Tips)>, Option<&'a EnergyCriterion>);
        let mut query = self.world.query_one::<Query>(body.entity());
        let (surface, tearing, energy) = query.get().map_err(|_| SimulationError::NoSuchBody)?;
        let Some((tearing, tips)) = tearing else { return Ok(Vec::new()) };
        let surface = Surface::of(surface);
        let mut memory = TipMemory::default();
        let decisions = (0..tips.len()).map(|tip| {
            let place = (tips.vertex[tip], tips.previous[tip]);
            match energy {
                Some(energy) => energy_decision(&surface, EnergyTerms { tearing, energy }, tip, place, &mut memory)
                    .map(|found| found.0),
                None => tip_decision(&surface, tearing, tip, place, &mut memory),
            }
        });
        Ok(decisions.collect())
    }

    /// Elastic forces of the membrane on every vertex \[N\], as it stands: without bending, damping, loads, contact and holds.
    ///
    /// # Errors
    /// If there is no such body.
    pub fn elastic_forces(&self, body: BodyId) -> Result<Vec<DVec3>, SimulationError> {
        let frames = &self.present_frames(body)?;
        let mut query = self.world.query_one::<(&Triangles, &Topology)>(body.entity());
        let (triangles, topology) = query.get().map_err(|_| SimulationError::NoSuchBody)?;
        let mut forces = Forces::default();
        self.pool.run(|| membrane_forces((triangles, topology), frames, |_| DVec3::ZERO, 0.0, &mut forces));
        Ok(forces.nodal)
    }
}
