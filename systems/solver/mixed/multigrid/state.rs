//! Data to remake a multigrid cycle from, to the same bits: levels follow from the mesh and the choice of their nodes, numbers of the
//! coarser ones from those of the finest.

use super::follow::Choices;
use super::hierarchy::Hierarchy;
use super::{Multigrid, Order, Partition};
use crate::storage::{Topology, Triangles, Vertices};
use crate::systems::kernels::block::Block;
use glam::Vec4;

/// The levels, the age of their numbers, and those of the finest.
#[derive(Clone, Debug, Default)]
#[cfg_attr(feature = "snapshot", derive(serde::Serialize, serde::Deserialize))]
pub(crate) struct MultigridState {
    choices: Option<Choices>,
    is_used: bool,
    numbers: Option<Numbers>,
    served: u32,
    rate: f64,
    excess: f64,
    strict: u32,
    strictness: u32,
}

/// The finest level.
#[derive(Clone, Debug)]
#[cfg_attr(feature = "snapshot", derive(serde::Serialize, serde::Deserialize))]
struct Numbers {
    diagonal: Vec<Block>,
    lower: Vec<Block>,
    free: Vec<Vec4>,
}

impl Multigrid {
    /// Snapshot state of multigrid. `is_current`: no edit has changed the triangles since the levels were brought up to them.
    pub(crate) fn state(&self, is_current: bool) -> MultigridState {
        let &Self { ref hierarchy, has_levels, is_used, has_numbers, served, rate, excess, strict, strictness } = self;
        let choices = has_levels.then(|| hierarchy.choices());
        let numbers = (has_levels && has_numbers && is_current).then(|| {
            let finest = hierarchy.finest();
            let (diagonal, lower) = (finest.diagonal.clone(), finest.lower.clone());
            Numbers { diagonal, lower, free: finest.free.clone() }
        });
        MultigridState { choices, is_used, numbers, served, rate, excess, strict, strictness }
    }

    /// The cycle of a state. `is_current`: its levels are those of these triangles, and not of some before edits. `None` where they cannot
    /// be.
    pub(crate) fn of_state(
        state: &MultigridState,
        is_current: bool,
        partition: &Partition,
        order: &Order,
        mesh: (&Vertices, &Triangles, &Topology),
    ) -> Option<Self> {
        let &MultigridState { ref choices, is_used, ref numbers, served, rate, excess, strict, strictness } = state;
        let mut multigrid = Self { is_used, served, rate, excess, strict, strictness, ..Self::default() };
        if let Some(choices) = choices {
            multigrid.hierarchy = Hierarchy::of_choices(choices, order.vertex.len())?;
            multigrid.has_levels = true;
            // Those of triangles before edits follow them before they are used.
            if is_current && !multigrid.hierarchy.follow(partition, order, mesh, None) {
                return None;
            }
        }
        if let Some(Numbers { diagonal, lower, free }) = numbers {
            multigrid.has_numbers = true;
            if choices.is_none() || !is_current || !multigrid.hierarchy.set(diagonal, lower, free) {
                return None;
            }
        }
        Some(multigrid)
    }
}
