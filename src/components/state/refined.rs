//! Refinement done so far.

use crate::storage::{EditRecord, Tables, TipKey, VertexKey};
use glam::DVec3;

/// Record of the refinement done, and of the part that coarsening may take back. *State.*
#[derive(Clone, Debug, Default)]
#[cfg_attr(feature = "snapshot", derive(serde::Serialize, serde::Deserialize))]
pub struct Refined {
    /// Triangles at the start.
    pub start_count: usize,
    /// Triangles that refinement has added, less those that coarsening has removed.
    pub added: i64,
    /// Edges split.
    pub split_count: u32,
    /// Vertices removed.
    pub removed_count: u32,
    /// How often the budget has ended a refinement.
    pub budget_hit_count: u32,
    /// Sum of the changes of elastic energy \[mJ\] by coarsening at unchanged positions. Splits change none.
    pub energy_change: f64,
    /// Vertices added since the start, by refinement and by tears: those that may be removed.
    pub made: Vec<VertexKey>,
    /// Tips and where they were in the rest shape when the mesh was last refined around them.
    pub tips: Vec<(TipKey, DVec3)>,
    /// Whether tips have gone on since the mesh was last coarsened.
    pub is_behind: bool,
    /// Whether the budget of the last step has left halvings to the next one.
    #[cfg_attr(feature = "snapshot", serde(skip))]
    pub is_put_off: bool,
    /// Scratch: triangles that are too large, as distance from the tip \[mm\] and row.
    pub queue: Vec<(f64, u32)>,
}

impl Refined {
    /// Remembers the vertices that an edit has added; the tables are those after it.
    pub fn follow(&mut self, record: &EditRecord, tables: Tables<'_>) {
        self.made.extend(record.created().filter_map(|(row, _)| tables.vertices.key(row)));
    }
}
