//! Components that refer to vertices and follow what a tear does to them.

use crate::components::{EdgeLoads, Grips, Holds, Increment, Springs};
use crate::storage::{EditRecord, Follow, Tables};

/// Those that a body carries.
#[derive(Debug)]
pub struct Followers<'a> {
    /// Its increment: where the step started and how far it has come.
    pub increment: &'a mut Increment,
    /// Prescribed vertices.
    pub holds: Option<&'a mut Holds>,
    /// Springs to ground.
    pub springs: Option<&'a mut Springs>,
    /// Forceps.
    pub grips: Option<&'a mut Grips>,
    /// Loads along edges.
    pub edge_loads: Option<&'a mut EdgeLoads>,
}

impl Followers<'_> {
    /// Whether a vertex belongs to the tissue alone, so that it may be moved in the rest shape.
    pub fn leave_free(&self, vertex: u32) -> bool {
        let is_anchored = self.springs.as_ref().is_some_and(|s| s.anchors.value(vertex).is_some());
        !(self.hold(vertex) || is_anchored)
    }

    /// Whether a hold or a closed grip has hold of a vertex. It keeps both lips of a tear that parts the vertex, as jaws do.
    pub fn hold(&self, vertex: u32) -> bool {
        let is_held = self.holds.as_ref().is_some_and(|h| h.groups.iter().any(|g| g.members.value(vertex).is_some()));
        is_held || self.grips.as_ref().is_some_and(|g| g.held.iter().any(|held| held.value(vertex).is_some()))
    }

    /// Follows the edits in their order; the tables are those after the last.
    pub fn follow(&mut self, records: &[EditRecord], tables: Tables<'_>) {
        for record in records {
            self.increment.follow(record);
            if let Some(holds) = &mut self.holds {
                holds.groups.iter_mut().for_each(|group| group.members.apply(record, tables));
            }
            if let Some(springs) = &mut self.springs {
                springs.anchors.apply(record, tables);
            }
            if let Some(grips) = &mut self.grips {
                grips.held.iter_mut().for_each(|held| held.apply(record, tables));
            }
            if let Some(loads) = &mut self.edge_loads {
                loads.follow(record);
            }
        }
    }
}
