//! Data to remake a factor from, to the same bits: the matrix that it was made of is several times as small.

use super::cholesky::{Cholesky, Equations, NoFactor};
use super::rotation_warp::RotationWarp;
use super::{Factor, InUse};

/// Snapshot state of a factor.
#[derive(Clone, Debug, Default)]
#[cfg_attr(feature = "snapshot", derive(serde::Serialize, serde::Deserialize))]
pub struct FactorState {
    current: Option<(Equations, RotationWarp)>,
    needed: u32,
}

impl Factor {
    /// Snapshot state of the factor.
    pub fn state(&self) -> FactorState {
        let of = |current: &InUse| (current.cholesky.equations(), current.rotation_warp.state());
        FactorState { current: self.current.as_deref().map(of), needed: self.needed.into() }
    }

    /// The factor of a state, which goes on as the one did that it was kept of.
    ///
    /// # Errors
    /// Where the matrix has none, which that of a factor has.
    pub fn of_state(state: &FactorState) -> Result<Self, NoFactor> {
        let remade = |(equations, rotation_warp): &(Equations, RotationWarp)| {
            let cholesky = Cholesky::of_equations(equations)?;
            Ok(Box::new(InUse { cholesky, rotation_warp: rotation_warp.clone() }))
        };
        Ok(Self {
            current: state.current.as_ref().map(remade).transpose()?,
            needed: u16::try_from(state.needed).unwrap_or_default(),
            ..Self::default()
        })
    }
}

#[cfg(feature = "snapshot")]
impl FactorState {
    /// Whether its matrix is of a mesh: a body may have been cut since, and then has another number of vertices.
    pub fn is_sound(&self) -> bool {
        use crate::storage::Topology;
        self.current.iter().all(|(Equations { corners, folded, free, .. }, rotation_warp)| {
            Topology::new(free.len(), corners).is_ok()
                && folded.iter().flatten().all(|&v| (v as usize) < free.len())
                && free.are_sound()
                && rotation_warp.vertex_count() == free.len()
        })
    }
}
