//! What a factor is made of anew, to the same bits: the matrix that it was made of is several times as small.

use super::super::bridge::Bridge;
use super::super::cholesky::{Cholesky, Equations, NoFactor, Precision};
use super::super::snapshot::Snapshot;
use super::super::warp::Warp;
use super::{Factor, InUse, Pending};
use std::sync::Arc;

/// What a factor that is made aside is made of.
#[derive(Clone, Debug)]
#[cfg_attr(
    feature = "snapshot",
    derive(serde::Serialize, serde::Deserialize),
    serde(from = "Equations", into = "Equations")
)]
pub(crate) enum Origin {
    /// The operator of a body.
    Operator(Arc<Snapshot>),
    /// What a snapshot has kept of one.
    Equations(Arc<Equations>),
}

impl Origin {
    /// Makes the factor, on one thread.
    ///
    /// # Errors
    /// As [`Cholesky::new`].
    pub(crate) fn factor(&self) -> Result<Cholesky, NoFactor> {
        match self {
            Self::Operator(snapshot) => Cholesky::new(snapshot, Precision::Single, None),
            Self::Equations(equations) => Cholesky::of_equations(equations, Precision::Single),
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
            Origin::Operator(snapshot) => Self::of(&snapshot),
            Origin::Equations(equations) => (*equations).clone(),
        }
    }
}

/// What a snapshot keeps of a factor.
#[derive(Clone, Debug, Default)]
#[cfg_attr(feature = "snapshot", derive(serde::Serialize, serde::Deserialize))]
pub struct FactorState {
    current: Option<Current>,
    pending: Option<Coming>,
    without: u32,
    strikes: u32,
    rest: u32,
    rests: u32,
    rescued: u32,
}

/// The factor in use.
#[derive(Clone, Debug)]
#[cfg_attr(feature = "snapshot", derive(serde::Serialize, serde::Deserialize))]
struct Current {
    equations: Equations,
    precision: Precision,
    bridge: Bridge,
    warp: Warp,
    served: u32,
    is_worse_than_none: bool,
}

/// The one that is being made.
#[derive(Clone, Debug)]
#[cfg_attr(feature = "snapshot", derive(serde::Serialize, serde::Deserialize))]
struct Coming {
    origin: Origin,
    bridge: Bridge,
    warp: Warp,
    left: u32,
}

impl Factor {
    /// What a snapshot keeps.
    pub fn state(&self) -> FactorState {
        let &Self { ref current, ref pending, without, strikes, rest, rests, rescued } = self;
        // Across edits a factor does not turn.
        let turning = |bridge: &Bridge, warp: &Warp| if bridge.is_empty() { warp.state() } else { Warp::default() };
        let current = current.as_deref().map(|current| Current {
            equations: current.cholesky.equations(),
            precision: current.cholesky.precision(),
            bridge: current.bridge.clone(),
            warp: turning(&current.bridge, &current.warp),
            served: current.served,
            is_worse_than_none: current.is_worse_than_none,
        });
        let coming = |Pending { origin, bridge, warp, left, .. }: &Pending| {
            let (origin, warp, bridge) = (origin.clone(), turning(bridge, warp), bridge.clone());
            Coming { origin, bridge, warp, left: *left }
        };
        FactorState { current, pending: pending.as_ref().map(coming), without, strikes, rest, rests, rescued }
    }

    /// The factor of a state, which goes on as the one did that it was kept of. The one in use is made now, the other aside.
    ///
    /// # Errors
    /// Where the matrix has none, which that of a factor has.
    pub fn of_state(state: &FactorState) -> Result<Self, NoFactor> {
        let &FactorState { ref current, ref pending, without, strikes, rest, rests, rescued } = state;
        let current = current.as_ref().map(|current| {
            let cholesky = Cholesky::of_equations(&current.equations, current.precision)?;
            let mut factor = InUse::new(cholesky, current.bridge.clone(), current.warp.clone());
            (factor.served, factor.is_worse_than_none) = (current.served, current.is_worse_than_none);
            Ok(factor)
        });
        let begin = |Coming { origin, bridge, warp, left }: &Coming| {
            Pending::new(origin.clone(), bridge.clone(), warp.clone(), *left)
        };
        let pending = pending.as_ref().map(begin);
        Ok(Self { current: current.transpose()?, pending, without, strikes, rest, rests, rescued })
    }
}

#[cfg(feature = "snapshot")]
impl FactorState {
    /// Whether it may belong to a body of so many vertices, and names nothing that is not there.
    pub fn is_sound(&self, vertex_count: usize) -> bool {
        use crate::storage::Topology;
        let are_sound = |equations: &Equations, bridge: &Bridge, warp: &Warp| {
            let Equations { corners, folded, free, .. } = equations;
            Topology::new(free.len(), corners).is_ok()
                && folded.iter().flatten().all(|&v| (v as usize) < free.len())
                && free.are_sound()
                && bridge.is_sound(vertex_count, free.len())
                && warp.vertex_count() == if bridge.is_empty() { free.len() } else { 0 }
        };
        self.current.iter().all(|current| are_sound(&current.equations, &current.bridge, &current.warp))
            && self.pending.iter().all(|Coming { origin, bridge, warp, left }| {
                *left > 0
                    && match origin {
                        Origin::Equations(equations) => are_sound(equations, bridge, warp),
                        // Of a body here, not of bytes.
                        Origin::Operator(_) => true,
                    }
            })
    }
}
