//! The material force at tear tips.

use super::{Simulation, SimulationError};
use crate::components::{EnergyCriterion, Tearing, Toughness};
use crate::math::elementary;
use crate::storage::{BodyId, TipKey, Tips};
use crate::systems::fracture::{EnergyTerms, Surface, SurfaceQuery, TipMemory};
use glam::DVec3;

/// The material force at a tip, in the rest shape.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TipForce {
    /// The tip.
    pub tip: TipKey,
    /// Position of the tip \[mm\].
    pub at: DVec3,
    /// Material force per thickness \[N/mm\]: an advance along the unit direction d releases the energy force·d per area of tear.
    pub force: DVec3,
    /// Energy released by an advance in the tear's last direction \[N/mm\]; the size of the force where there is none.
    pub along: f64,
    /// Angle \[rad\] from the last direction to the force, counter-clockwise seen from the normal; zero where there is none.
    pub turn: f64,
}

impl Simulation {
    /// The material forces at a body's tips at its present positions, in the order of the tips' rows; of a body that does not tear
    /// none. Costs some microseconds per tip.
    ///
    /// ```
    /// use glam::DVec3;
    /// use rhexis::components::{Material, Tearing};
    /// use rhexis::{generate, membrane::Membrane, settings::Settings, simulation::Simulation};
    /// let mesh = generate::grid(4.0, 4.0, 8, 8)?;
    /// let sheet = Membrane::new("sheet", mesh, Material::allard_2009()).with(Tearing::default());
    /// let mut simulation = Simulation::new(Settings::default())?;
    /// let body = simulation.spawn(sheet)?;
    /// simulation.cut(body, &[DVec3::new(2.0, 4.0, 0.0), DVec3::new(2.0, 2.0, 0.0)])?;
    /// // At rest nothing is released.
    /// assert_eq!(simulation.material_forces(body)?[0].force, DVec3::ZERO);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    /// Where there is no such body.
    pub fn material_forces(&self, body: BodyId) -> Result<Vec<TipForce>, SimulationError> {
        type Query<'a> = (SurfaceQuery<'a>, Option<(&'a Tearing, &'a Tips)>, Option<&'a EnergyCriterion>);
        let mut query = self.world.query_one::<Query>(body.entity());
        let (surface, tearing, energy) = query.get().map_err(|_| SimulationError::NoSuchBody)?;
        let Some((tearing, tips)) = tearing else { return Ok(Vec::new()) };
        let surface = Surface::of(surface);
        let mut memory = TipMemory::default();
        let forces = (0..tips.len()).filter_map(|tip| {
            let vertex = tips.vertex[tip];
            let force = material_force(&surface, (tearing, energy), (tip, vertex), &mut memory);
            let last = tips.previous[tip];
            let (along, turn) = match surface.chart(vertex).filter(|_| last != DVec3::ZERO) {
                Some(chart) => {
                    let [x, y] = chart.axes();
                    (force.dot(last), elementary::atan2(last.cross(force).dot(x.cross(y)), last.dot(force)))
                }
                None => (force.length(), 0.0),
            };
            Some(TipForce {
                tip: tips.key(tip as u32)?,
                at: surface.vertices.rest_position[vertex as usize],
                force,
                along,
                turn,
            })
        });
        Ok(forces.collect())
    }
}

/// The material force \[N/mm\] at the `tip`th tip of a body, at `vertex`, in the rest shape; zero where it has no fan.
pub(super) fn material_force(
    surface: &Surface,
    (tearing, energy): (&Tearing, Option<&EnergyCriterion>),
    at: (usize, u32),
    memory: &mut TipMemory,
) -> DVec3 {
    // Toughness has no part in the force.
    let default = EnergyCriterion::new(Toughness { along: 1.0, across: 1.0 });
    let terms = EnergyTerms { tearing, energy: energy.unwrap_or(&default) };
    let force = terms.material_force(surface, at, memory);
    force.map_or(DVec3::ZERO, |([x, y], force)| x * force.release.x + y * force.release.y)
}
