//! What happened to the tissue, in order.

use crate::storage::{TipKey, VertexKey};
use glam::DVec3;
use hecs::Entity;

/// One event.
#[derive(Clone, Debug, PartialEq)]
pub struct Event {
    /// Step in which it happened.
    pub step: u64,
    /// Time at the end of that step \[ms\].
    pub time: f64,
    /// The body.
    pub body: Entity,
    /// What happened.
    pub kind: EventKind,
}

/// The kinds of event. Positions and directions are in the rest shape.
#[derive(Clone, Debug, PartialEq)]
pub enum EventKind {
    /// A tear began: a cut by a tool, or the criterion inside the tissue.
    Started {
        /// The new tip.
        tip: TipKey,
        /// Where it is \[mm\].
        at: DVec3,
    },
    /// A tip moved on.
    Advanced {
        /// The tip.
        tip: TipKey,
        /// From here \[mm\].
        from: DVec3,
        /// To here \[mm\].
        to: DVec3,
        /// The direction that the criterion chose.
        direction: DVec3,
        /// The criterion there.
        criterion: f64,
        /// 1 − (best other direction's criterion)/criterion; 1 where there was no other.
        margin: f64,
        /// Whether the margin is under 5 %: by its nature another run could have gone the other way.
        is_ambiguous: bool,
    },
    /// A body with an [`EnergyAudit`](crate::components::EnergyAudit) has found its equilibrium after tears have advanced or it
    /// was cut, with nothing else moved on. Advances of several tips before one equilibrium are told together: their shares
    /// cannot be told apart.
    Released {
        /// Fall of its elastic energy, and the work of its loads meanwhile \[mJ\].
        energy: f64,
        /// Length torn and cut since the last equilibrium \[mm\].
        length: f64,
    },
    /// A tip reached a boundary and is gone.
    Ended {
        /// The tip, no longer alive.
        tip: TipKey,
        /// Where it ended \[mm\].
        at: DVec3,
        /// The vertex it ran into.
        vertex: Option<VertexKey>,
    },
    /// A piece came free.
    PieceFreed {
        /// Triangles of the smaller part.
        triangle_count: usize,
    },
    /// The criterion asked for an advance that the mesh could not make.
    Refused {
        /// The tip.
        tip: Option<TipKey>,
        /// Where \[mm\].
        at: DVec3,
        /// Why.
        reason: String,
    },
    /// A step left no usable state and was undone; the last good state stands.
    StepFailed {
        /// Why.
        reason: String,
    },
}
