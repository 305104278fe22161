//! Data to remake a factor from, to the same bits: the matrix that it was made of is several times as small.

use super::super::cholesky::{Cholesky, Equations, FactorPrecision, NoFactor};
use super::super::edit_map::EditMap;
use super::super::operator_copy::OperatorCopy;
use super::super::rotation_warp::RotationWarp;
use super::{Factor, InUse, Pending};
use std::sync::Arc;

/// Source of a factor that is made on another thread.
#[derive(Clone, Debug)]
#[cfg_attr(
    feature = "snapshot",
    derive(serde::Serialize, serde::Deserialize),
    serde(from = "Equations", into = "Equations")
)]
pub(crate) enum Origin {
    /// The operator of a body.
    Operator(Arc<OperatorCopy>),
    /// Equations kept in a snapshot.
    Equations(Arc<Equations>),
}

impl Origin {
    /// Makes the factor, on one thread.
    ///
    /// # Errors
    /// As [`Cholesky::new`].
    pub(crate) fn factor(&self) -> Result<Cholesky, NoFactor> {
        match self {
            Self::Operator(operator_copy) => Cholesky::new(operator_copy, FactorPrecision::Single, None),
            Self::Equations(equations) => Cholesky::of_equations(equations, FactorPrecision::Single),
        }
    }
}

impl From<Equations> for Origin {
    fn from(equations: Equations) -> Self {
        Self::Equations(Arc::new(equations))
    }
}

impl From<Origin> for Equations {
    fn from(origin: Origin) -> Self {
        match origin {
            Origin::Operator(operator_copy) => Self::of(&operator_copy),
            Origin::Equations(equations) => (*equations).clone(),
        }
    }
}

/// Snapshot state of a factor.
#[derive(Clone, Debug, Default)]
#[cfg_attr(feature = "snapshot", derive(serde::Serialize, serde::Deserialize))]
pub struct FactorState {
    current: Option<Current>,
    pending: Option<Coming>,
    without: u32,
    stale_count: u32,
    pause: u32,
    pauses: u32,
    factored_now: u32,
}

/// The factor in use.
#[derive(Clone, Debug)]
#[cfg_attr(feature = "snapshot", derive(serde::Serialize, serde::Deserialize))]
struct Current {
    equations: Equations,
    precision: FactorPrecision,
    edit_map: EditMap,
    rotation_warp: RotationWarp,
    served: u32,
    is_worse_than_none: bool,
}

/// The one that is being made.
#[derive(Clone, Debug)]
#[cfg_attr(feature = "snapshot", derive(serde::Serialize, serde::Deserialize))]
struct Coming {
    origin: Origin,
    edit_map: EditMap,
    rotation_warp: RotationWarp,
    left: u32,
}

impl Factor {
    /// Snapshot state of the factor and of its use.
    pub fn state(&self) -> FactorState {
        let &Self { ref current, ref pending, without, stale_count, pause, pauses, factored_now } = self;
        // Across edits a factor does not turn.
        let turning = |edit_map: &EditMap, rotation_warp: &RotationWarp| {
            if edit_map.is_empty() { rotation_warp.state() } else { RotationWarp::default() }
        };
        let current = current.as_deref().map(|current| Current {
            equations: current.cholesky.equations(),
            precision: current.cholesky.precision(),
            edit_map: current.edit_map.clone(),
            rotation_warp: turning(&current.edit_map, &current.rotation_warp),
            served: current.served,
            is_worse_than_none: current.is_worse_than_none,
        });
        let coming = |Pending { origin, edit_map, rotation_warp, left, .. }: &Pending| {
            let (origin, rotation_warp, edit_map) =
                (origin.clone(), turning(edit_map, rotation_warp), edit_map.clone());
            Coming { origin, edit_map, rotation_warp, left: *left }
        };
        FactorState {
            current,
            pending: pending.as_ref().map(coming),
            without,
            stale_count,
            pause,
            pauses,
            factored_now,
        }
    }

    /// The factor of a state, which goes on as the one did that it was kept of. The one in use is made now, the other aside.
    ///
    /// # Errors
    /// Where the matrix has none, which that of a factor has.
    pub fn of_state(state: &FactorState) -> Result<Self, NoFactor> {
        let &FactorState { ref current, ref pending, without, stale_count, pause, pauses, factored_now } = state;
        let current = current.as_ref().map(|current| {
            let cholesky = Cholesky::of_equations(&current.equations, current.precision)?;
            let mut factor = InUse::new(cholesky, current.edit_map.clone(), current.rotation_warp.clone());
            (factor.served, factor.is_worse_than_none) = (current.served, current.is_worse_than_none);
            Ok(factor)
        });
        let begin = |Coming { origin, edit_map, rotation_warp, left }: &Coming| {
            Pending::new(origin.clone(), edit_map.clone(), rotation_warp.clone(), *left)
        };
        let pending = pending.as_ref().map(begin);
        Ok(Self { current: current.transpose()?, pending, without, stale_count, pause, pauses, factored_now })
    }
}

#[cfg(feature = "snapshot")]
impl FactorState {
    /// Whether it may belong to a body of so many vertices, and names nothing that is not there.
    pub fn is_sound(&self, vertex_count: usize) -> bool {
        use crate::storage::Topology;
        let are_sound = |equations: &Equations, edit_map: &EditMap, rotation_warp: &RotationWarp| {
            let Equations { corners, folded, free, .. } = equations;
            Topology::new(free.len(), corners).is_ok()
                && folded.iter().flatten().all(|&v| (v as usize) < free.len())
                && free.are_sound()
                && edit_map.is_sound(vertex_count, free.len())
                && rotation_warp.vertex_count() == if edit_map.is_empty() { free.len() } else { 0 }
        };
        self.current.iter().all(|current| are_sound(&current.equations, &current.edit_map, &current.rotation_warp))
            && self.pending.iter().all(|Coming { origin, edit_map, rotation_warp, left }| {
                *left > 0
                    && match origin {
                        Origin::Equations(equations) => are_sound(equations, edit_map, rotation_warp),
                        // Of a body here, not of bytes.
                        Origin::Operator(_) => true,
                    }
            })
    }
}
