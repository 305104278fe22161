//! What a multigrid cycle is made of anew, to the same bits: levels follow from the mesh, numbers of the coarser ones from
//! those of the finest.

use super::{Multigrid, Order, Partition};
use crate::storage::{Topology, Triangles, Vertices};
use crate::systems::kernels::block::Block;
use glam::Vec4;

/// The age of the numbers, and those of the finest level.
#[derive(Clone, Debug, Default)]
#[cfg_attr(feature = "snapshot", derive(serde::Serialize, serde::Deserialize))]
pub struct MultigridState {
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
    /// What a snapshot keeps. `is_current`: no edit has changed the triangles since the levels were found.
    pub fn state(&self, is_current: bool) -> MultigridState {
        let &Self { ref hierarchy, has_levels, served, rate, excess, strict, strictness } = self;
        let numbers = (has_levels && is_current).then(|| {
            let finest = hierarchy.finest();
            let (diagonal, lower) = (finest.diagonal.clone(), finest.lower.clone());
            Numbers { diagonal, lower, free: finest.free.clone() }
        });
        MultigridState { numbers, served, rate, excess, strict, strictness }
    }

    /// The cycle of a state, with levels of these triangles or of those before edits; `None` where its numbers are not of this mesh.
    pub fn of_state(
        state: &MultigridState,
        has_levels: bool,
        partition: &Partition,
        order: &Order,
        mesh: (&Vertices, &Triangles, &Topology),
    ) -> Option<Self> {
        let &MultigridState { ref numbers, served, rate, excess, strict, strictness } = state;
        let mut multigrid = Self { served, rate, excess, strict, strictness, ..Self::default() };
        if let Some(Numbers { diagonal, lower, free }) = numbers {
            multigrid.hierarchy.rebuild(partition, order, mesh);
            if !multigrid.hierarchy.set(diagonal, lower, free) {
                return None;
            }
        }
        // Those that edits have made useless since are found anew before they are used.
        multigrid.has_levels = has_levels;
        (has_levels || numbers.is_none()).then_some(multigrid)
    }

    /// Whether a state has numbers.
    pub fn is_numbered(state: &MultigridState) -> bool {
        state.numbers.is_some()
    }
}
