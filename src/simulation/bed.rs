//! Figures of the bed that a body is stuck to.

use super::Simulation;
use crate::components::Springs;
use crate::storage::{BodyId, Topology, Triangles};
use crate::systems::kernels::separation::Separation;

/// Bonds of a body to its bed.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Bed {
    /// Rest area of vertices that have or had a bond \[mm²\].
    pub area: f64,
    /// Part of it that is off \[mm²\].
    pub off: f64,
    /// Energy that the bonds have taken \[mJ\]; the energy that they store is not in it.
    pub energy: f64,
    /// Least strength that the mesh allows over the one that is given: below 1 where it is too coarse.
    pub resolved: f64,
}

impl Simulation {
    /// Figures of a body's bed; `None` where it has none.
    ///
    /// # Examples
    /// ```
    /// # let (mut simulation, body) = rhexis::internal::example()?;
    /// # use rhexis::prelude::*;
    /// use rhexis::components::{Anchor, Bond, Springs};
    /// use rhexis::simulation::Bed;
    ///
    /// let bond = Bond::new(0.05, 0.01);
    /// let anchor = Anchor { point: DVec3::ZERO, stiffness: bond.usual_stiffness(), bond: Some(bond) };
    /// simulation.set(body, Springs { anchors: Attached::new([(0, anchor)]) })?;
    /// let bed: Option<Bed> = simulation.bed(body);
    /// assert!(bed.is_some_and(|bed| bed.area > 0.0 && bed.off == 0.0));
    /// # Ok::<(), rhexis::Error>(())
    /// ```
    pub fn bed(&self, body: BodyId) -> Option<Bed> {
        let mut query = self.world.query_one::<(&Springs, &Triangles, &Topology)>(body.entity());
        let (springs, triangles, topology) = query.get().ok()?;
        let mut bed = Bed { resolved: 1.0, ..Bed::default() };
        for (&row, anchor) in springs.anchors.rows().iter().zip(springs.anchors.values()) {
            let Some(bond) = anchor.bond else { continue };
            let (area, triangle) = topology.areas_at(triangles, row);
            let law = Separation::new(anchor.stiffness, bond.strength, bond.energy, triangle);
            bed.area += area;
            bed.off += if bond.damage < 1.0 { 0.0 } else { area };
            bed.energy += area * bond.energy * law.taken(bond.damage);
            bed.resolved = bed.resolved.min(law.strength() / bond.strength);
        }
        (bed.area > 0.0).then_some(bed)
    }
}
