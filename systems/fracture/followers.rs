//! Components that refer to vertices and follow edits of the mesh.

use crate::components::{
    Attributes, Changes, CompartmentState, EdgeLoad, EdgeLoads, Grips, Holds, Increment, PointLoads, Refined, Springs,
    StepForces,
};
use crate::storage::{EditRecord, Follow, Mesh, Tips};

/// Query of the components that follow edits, without the list of additions to the mesh.
pub type FollowersQuery<'a> = (
    &'a mut Increment,
    (Option<&'a mut Holds>, Option<&'a mut Springs>, Option<&'a mut Grips>),
    (Option<&'a mut PointLoads>, Option<&'a mut EdgeLoads>, Option<&'a mut StepForces>),
    (Option<&'a mut Attributes>, Option<&'a mut Changes>, Option<&'a mut CompartmentState>),
);

/// Components of a body that follow edits.
#[derive(Debug)]
pub struct Followers<'a> {
    /// Increment of the body: where the step started and how far it has come.
    pub increment: &'a mut Increment,
    /// Prescribed vertices.
    pub holds: Option<&'a mut Holds>,
    /// Springs to ground.
    pub springs: Option<&'a mut Springs>,
    /// Forceps.
    pub grips: Option<&'a mut Grips>,
    /// Loads on vertices.
    pub point_loads: Option<&'a mut PointLoads>,
    /// Loads along edges.
    pub edge_loads: Option<&'a mut EdgeLoads>,
    /// Forces of one step.
    pub step_forces: Option<&'a mut StepForces>,
    /// The list of additions to the mesh.
    pub refined: Option<&'a mut Refined>,
    /// Numbers of the host's.
    pub attributes: Option<&'a mut Attributes>,
    /// The list of changes that somebody has asked for.
    pub changes: Option<&'a mut Changes>,
    /// Content of a compartment, with the rims of its lids.
    pub compartment: Option<&'a mut CompartmentState>,
}

impl<'a> Followers<'a> {
    /// The followers of a body, with the list of additions to its mesh.
    pub fn of(
        (
            increment,
            (holds, springs, grips),
            (point_loads, edge_loads, step_forces),
            (attributes, changes, compartment),
        ): FollowersQuery<'a>,
        refined: Option<&'a mut Refined>,
    ) -> Self {
        Self {
            increment,
            holds,
            springs,
            grips,
            point_loads,
            edge_loads,
            step_forces,
            refined,
            attributes,
            changes,
            compartment,
        }
    }
}

impl Followers<'_> {
    /// Whether a vertex belongs to the tissue alone, so that it may be moved in the rest shape.
    pub fn leave_free(&self, vertex: u32) -> bool {
        let is_anchored =
            self.springs.as_ref().is_some_and(|s| s.anchors.value(vertex).is_some_and(|anchor| anchor.is_whole()));
        !(self.hold(vertex) || is_anchored)
    }

    /// Whether a hold or a closed grip has hold of a vertex. It keeps both lips of a tear that parts the vertex, as jaws do.
    pub fn hold(&self, vertex: u32) -> bool {
        let is_held = self.holds.as_ref().is_some_and(|h| h.groups.iter().any(|g| g.members.value(vertex).is_some()));
        is_held || self.grips.as_ref().is_some_and(|grips| grips.hold(vertex))
    }

    /// Whether a vertex may vanish in a collapse without changing supports or loads of the body: it is free, no load acts on
    /// it, and along a loaded rim it lies between two loaded edges.
    pub fn can_spare(&self, vertex: u32) -> bool {
        let is_loaded =
            self.point_loads.as_ref().is_some_and(|loads| loads.groups.iter().any(|load| load.rows.contains(&vertex)));
        let is_pushed =
            self.step_forces.as_ref().is_some_and(|forces| forces.list.iter().any(|(row, _)| *row == vertex));
        let ends_loaded_rim = self.edge_loads.as_ref().is_some_and(|loads| {
            let ends = |load: &EdgeLoad| load.edges.iter().filter(|edge| edge.contains(&vertex)).count();
            loads.groups.iter().any(|load| ends(load) == 1)
        });
        self.leave_free(vertex) && !is_loaded && !is_pushed && !ends_loaded_rim
    }

    /// Follows the edits that were done to the mesh, in their order, and closes the books on them: the records are gone, and
    /// nothing is kept any more for taking them back.
    pub fn follow(&mut self, records: &mut Vec<EditRecord>, mesh: &mut Mesh<'_>, mut tips: Option<&mut Tips>) {
        let tables = mesh.tables();
        let created = records.iter().map(|record| record.created().count()).sum();
        self.increment.make_room(created, tables.vertices.position.capacity());
        for record in &*records {
            self.increment.follow(record);
            if let Some(tips) = &mut tips {
                tips.follow(record);
            }
            if let Some(holds) = &mut self.holds {
                for members in holds.groups.iter_mut().map(|group| &mut group.members) {
                    members.apply(record, tables);
                    members.fill_in(record);
                }
            }
            if let Some(springs) = &mut self.springs {
                springs.anchors.apply(record, tables);
                springs.anchors.fill_in(record);
            }
            if let Some(grips) = &mut self.grips {
                for held in grips.pinches.iter_mut().map(|pinch| &mut pinch.held) {
                    held.apply(record, tables);
                    held.fill_in(record);
                }
            }
            if let Some(loads) = &mut self.point_loads {
                loads.follow(record);
            }
            if let Some(loads) = &mut self.edge_loads {
                loads.follow(record);
            }
            if let Some(forces) = &mut self.step_forces {
                forces.follow(record);
            }
            if let Some(refined) = &mut self.refined {
                refined.follow(record, tables);
            }
            if let Some(attributes) = &mut self.attributes {
                attributes.follow(record);
            }
            if let Some(compartment) = &mut self.compartment {
                compartment.rim.apply(record, tables);
            }
            if let Some(changes) = &mut self.changes {
                changes.note(record, tables.triangles.len());
            }
        }
        records.clear();
        mesh.release();
        if let Some(holds) = &mut self.holds {
            holds.groups.iter_mut().for_each(|group| group.members.release());
        }
        if let Some(springs) = &mut self.springs {
            springs.anchors.release();
        }
        if let Some(compartment) = &mut self.compartment {
            compartment.rim.release();
        }
        if let Some(grips) = &mut self.grips {
            grips.pinches.iter_mut().for_each(|pinch| pinch.held.release());
        }
    }
}
