//! The order of a body's rows, changed on request.

use super::{Simulation, SimulationError};
use crate::components::{
    Attributes, Changes, CompartmentState, EdgeLoads, EnergyAudit, Frames, Grips, Holds, Increment, PointLoads,
    Reactions, Springs, StepForces, TearDecisions,
};
use crate::replay::Input;
use crate::storage::{BodyId, Mesh, Order, Tips, Topology, Triangles, Vertices, reorder, sort};
use crate::systems::solver::Factor;

impl Simulation {
    /// Sorts the rows of a body's vertices and triangles so that neighbours in the tissue are neighbours in memory. A mesh from a
    /// file may come in any order, and tears and refinement append new rows: on large bodies steps then wait for
    /// memory. No step does this by itself: it moves the whole body and takes as long as several steps, and the Cholesky factor
    /// is made anew. Call it between steps, once after loading, or when a tenth of the triangles are new.
    ///
    /// Every position, velocity, material and key is unchanged; holds, springs, grips, loads, tips and
    /// reactions refer to the same vertices under their new rows. Masses, and from then on every sum over triangles, are added
    /// up in the new order, so that the last digits of later steps differ from those without it. Rows that you have kept
    /// yourself, also in components of your own, are void: keep keys.
    ///
    /// # Errors
    /// If there is no such body.
    pub fn reorder(&mut self, body: BodyId) -> Result<(), SimulationError> {
        type Query<'a> = (
            (&'a mut Vertices, &'a mut Triangles, &'a mut Topology),
            (&'a mut Increment, &'a mut Frames, &'a mut Factor, Option<&'a mut EnergyAudit>),
            (Option<&'a mut Holds>, Option<&'a mut Reactions>, Option<&'a mut Springs>, Option<&'a mut Grips>),
            (
                Option<&'a mut PointLoads>,
                Option<&'a mut EdgeLoads>,
                Option<&'a mut StepForces>,
                Option<&'a mut Changes>,
            ),
            (
                Option<&'a mut Tips>,
                Option<&'a mut TearDecisions>,
                Option<&'a mut Attributes>,
                Option<&'a mut CompartmentState>,
            ),
        );
        self.note(|| Input::Reorder(body));
        self.validate_dirty()?;
        let found = self.world.query_one_mut::<Query>(body.entity()).map_err(|_| SimulationError::NoSuchBody)?;
        let (
            (vertices, triangles, topology),
            (increment, frames, factor, audit),
            (holds, reactions, springs, grips),
            (point_loads, edge_loads, step_forces, changes),
            (tips, decisions, attributes, compartment),
        ) = found;
        let mut mesh = Mesh { vertices, triangles, topology };
        let order = Order::along_curve(&mesh);
        reorder(&mut mesh, &order);

        let Increment { start, start_velocity, displacement, delta, .. } = increment;
        [start, start_velocity, displacement, delta].into_iter().for_each(|values| order.sort_vertices(values));
        order.sort_triangles(&mut frames.solid);
        order.sort_triangles(&mut frames.flat);
        order.sort_triangles(&mut frames.geometric);
        order.sort_triangles(&mut frames.in_plane);
        order.sort_triangles(&mut frames.stiffened);
        *factor = Factor::default();
        if let Some(attributes) = attributes {
            attributes.sort(&order);
        }
        if let Some(changes) = changes {
            changes.forget();
        }
        if let Some(audit) = audit {
            audit.forget_loads();
        }

        let row = |old: u32| order.vertex(old);
        let count = mesh.vertices.len();
        if let Some(holds) = holds {
            let mut forces = reactions.map(|reactions| reactions.groups.iter_mut()).into_iter().flatten();
            for group in &mut holds.groups {
                let places = group.members.renumber(row);
                if let Some(forces) = forces.next() {
                    sort(&places, forces);
                }
            }
        }
        if let Some(compartment) = compartment {
            compartment.rim.renumber(row);
            compartment.answer.clear();
        }
        if let Some(springs) = springs {
            springs.anchors.renumber(row);
        }
        for pinch in grips.into_iter().flat_map(|grips| &mut grips.pinches) {
            pinch.held.renumber(row);
        }
        for load in point_loads.into_iter().flat_map(|loads| &mut loads.groups) {
            load.rows.iter_mut().for_each(|vertex| *vertex = row(*vertex));
        }
        for load in edge_loads.into_iter().flat_map(|loads| &mut loads.groups) {
            load.edges.as_flattened_mut().iter_mut().for_each(|vertex| *vertex = row(*vertex));
        }
        for (vertex, _) in step_forces.into_iter().flat_map(|forces| &mut forces.list) {
            *vertex = row(*vertex);
        }
        if let Some(tips) = tips {
            tips.vertex.iter_mut().for_each(|vertex| *vertex = row(*vertex));
        }
        if let Some(decisions) = decisions {
            let there = decisions.tips.iter_mut().flatten().filter(|decision| (decision.row as usize) < count);
            there.for_each(|decision| decision.row = row(decision.row));
            decisions.nucleation = None;
            decisions.ligament_failure = None;
        }
        Ok(())
    }
}
