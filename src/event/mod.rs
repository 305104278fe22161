//! Events in the tissue, in order.

mod causes;

pub use causes::{BlockedNucleation, DecidedBy, GuardCause, GuardPlace, PartedBy, RingFault};

use crate::storage::{BodyId, TipKey, VertexKey};
use glam::DVec3;
use std::fmt;

/// One event.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "snapshot", derive(serde::Serialize, serde::Deserialize))]
pub struct Event {
    /// Step in which it happened.
    pub step: u64,
    /// Time at the end of that step \[ms\].
    pub time: f64,
    /// The body.
    pub body: BodyId,
    /// Kind of the event.
    pub kind: EventKind,
}

/// The course of an advance: that of the direction which the criterion chose, or the nearest that the mesh allows.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "snapshot", derive(serde::Serialize, serde::Deserialize))]
pub enum Course {
    /// On the ray, through the whole triangle.
    Exact,
    /// To a vertex beside the ray.
    Snapped,
    /// On the ray, a part of the way through the triangle.
    Part,
    /// Along an existing edge that leads forward: always in edge mode, where no other way is left in free mode.
    Edge,
}

impl Course {
    /// All of them.
    pub const ALL: [Self; 4] = [Self::Exact, Self::Snapped, Self::Part, Self::Edge];
}

impl fmt::Display for Course {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Exact => "exact",
            Self::Snapped => "snapped",
            Self::Part => "part",
            Self::Edge => "edge",
        })
    }
}

/// Criterion value behind a decision, and its margin.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "snapshot", derive(serde::Serialize, serde::Deserialize))]
pub struct Verdict {
    /// The criterion in the chosen direction.
    pub criterion: f64,
    /// 1 − (best other direction's criterion)/criterion; infinite where there was no other.
    pub margin: f64,
    /// Whether the margin is under 5 %: by its nature another run could have gone the other way.
    pub is_ambiguous: bool,
}

/// Toughness and overshoot of an advance: its cost, and how late it came.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "snapshot", derive(serde::Serialize, serde::Deserialize))]
pub struct TearCost {
    /// Area torn: new length times thickness \[mm²\].
    pub area: f64,
    /// Toughness G_c in the direction that was taken \[N/mm\].
    pub toughness: f64,
    /// Overshoot G/G_c − 1 in the direction that was chosen: the excess at the end of a step.
    pub overshoot: f64,
}

impl TearCost {
    /// Surface energy that the toughness claims for the area \[mJ\]. No step takes it out of the body.
    pub fn surface_energy(&self) -> f64 {
        self.area * self.toughness
    }
}

/// Cause of a body's waking.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "snapshot", derive(serde::Serialize, serde::Deserialize))]
pub enum WokenBy {
    /// A hold, closed forceps or a load that moves on, forceps that close or open.
    Drive,
    /// An obstacle that has come, gone or moved within its reach, or another body near it that is awake.
    Obstacle,
    /// A cut.
    Cut,
    /// A static solve, which finds an equilibrium closer than the bound of sleep.
    StaticSolve,
    /// The program in which the simulation is embedded: it woke the body, or reached for its components.
    Caller,
}

impl fmt::Display for WokenBy {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Drive => "drive",
            Self::Obstacle => "obstacle",
            Self::Cut => "cut",
            Self::StaticSolve => "static solve",
            Self::Caller => "caller",
        })
    }
}

/// Cause of a new tip.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "snapshot", derive(serde::Serialize, serde::Deserialize))]
pub enum Renewal {
    /// A tear that ended, or tissue that parted, and left a notch.
    Notch,
    /// Two directions that tied.
    Branch,
}

impl fmt::Display for Renewal {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Notch => "notch",
            Self::Branch => "branch",
        })
    }
}

/// The kinds of event. Positions and directions are in the rest shape.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "snapshot", derive(serde::Serialize, serde::Deserialize))]
#[non_exhaustive]
pub enum EventKind {
    /// A tear began: a cut by a tool, or the criterion inside the tissue.
    Started {
        /// The new tip.
        tip: TipKey,
        /// Position of the tip \[mm\].
        at: DVec3,
        /// The criterion's verdict where it began the tear; `None` for a cut.
        verdict: Option<Verdict>,
    },
    /// A tip moved on: by the criterion, or led by a blade, whose cut goes on where the tear has ended; criterion and margin say
    /// nothing then.
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
        /// As in [`Verdict`].
        margin: f64,
        /// As in [`Verdict`].
        is_ambiguous: bool,
        /// Which criterion that is.
        by: DecidedBy,
        /// Energy that the advance was to release per area of tear \[N/mm\], where the criterion is on energy.
        release: Option<f64>,
        /// Cost of the advance, where the body has a toughness and no blade led it.
        cost: Option<TearCost>,
        /// Direction taken: there, or which other way.
        course: Course,
    },
    /// A body with an [`EnergyAudit`](crate::components::EnergyAudit) has found its equilibrium after tears have advanced or it
    /// was cut, with nothing else moved on. Advances of several tips before one equilibrium are reported together: their shares
    /// cannot be separated.
    Released {
        /// Fall of its elastic energy, and the work of its loads meanwhile \[mJ\].
        energy: f64,
        /// Length torn and cut since the last equilibrium \[mm\].
        length: f64,
    },
    /// A tip reached a boundary, or a tear or a cut went through it, and is gone.
    Ended {
        /// The tip, no longer alive.
        tip: TipKey,
        /// Where it ended \[mm\].
        at: DVec3,
        /// The vertex there.
        vertex: Option<VertexKey>,
    },
    /// A live tip was left at a notch, or sent the other way from it.
    Renewed {
        /// The new tip.
        tip: TipKey,
        /// Position of the tip \[mm\].
        at: DVec3,
        /// Cause of the new tip.
        by: Renewal,
    },
    /// Tissue parted where no tip led.
    Parted {
        /// Position of the event \[mm\].
        at: DVec3,
        /// Load over the strength of the ligament: smallest criterion across the ligament, or stretch over the ultimate one.
        value: f64,
        /// Reason of the event.
        by: PartedBy,
    },
    /// A fragment came free.
    FragmentFreed {
        /// Triangles of the smaller part.
        triangle_count: usize,
    },
    /// The tissue was parted at a vertex that a hold or a grip has hold of: it keeps both lips, so the tear stays shut there.
    HeldShut {
        /// Position of the event \[mm\].
        at: DVec3,
    },
    /// A tip wants to advance where the mesh is too coarse for the averaging radius: the load depends on the mesh there.
    /// Told once per tip.
    UnderResolved {
        /// The tip.
        tip: TipKey,
        /// Position of the event \[mm\].
        at: DVec3,
        /// Averaging radius over edge length; should be 3 or more.
        edges_per_radius: f64,
    },
    /// A tip is to advance and has to wait: a tear is no faster than Rayleigh waves. Told once per body; how often and at
    /// which criterion its tips waited is counted ([`TearLog`](crate::components::TearLog)).
    HeldBack {
        /// The tip.
        tip: TipKey,
        /// Position of the event \[mm\].
        at: DVec3,
        /// The criterion there.
        criterion: f64,
    },
    /// The stress reaches the strength where there is no tear, and opening one would release less than the toughness. Reported
    /// once, until no start is refused for that; how often one was is counted ([`TearLog`](crate::components::TearLog)).
    NucleationBlocked(BlockedNucleation),
    /// The criterion asked for an advance that the mesh could not make in any way. The tip rests, and is tried again in later
    /// steps; reported once until it moves or relaxes.
    Refused {
        /// The tip.
        tip: Option<TipKey>,
        /// Position of the event \[mm\].
        at: DVec3,
        /// Reason of the event.
        reason: String,
    },
    /// Jaws were pulled harder than their force limit. Reported once, until they are not any more.
    Slipped {
        /// Name of the grip or forceps.
        jaws: String,
        /// Force \[N\] that was to be held.
        force: f64,
        /// Whether they have let go; else the tissue slides between them.
        is_open: bool,
    },
    /// A body with [`Sleeping`](crate::components::Sleeping) came to rest and fell asleep.
    FellAsleep,
    /// A body that slept woke.
    Woke {
        /// Cause of the waking.
        by: WokenBy,
    },
    /// The energy guard began to act on a body; reported again once a step has passed without it.
    StepGuarded {
        /// Attempts at the step or a part of it that were undone.
        refused: u32,
        /// Parts of the step whose answer was limited.
        limited: u32,
        /// Number of vertices of the body where a sub-step was limited: the fraction applies to all of them.
        limited_vertices: u32,
        /// Cause and place of the first of them.
        first: Option<GuardPlace>,
    },
    /// A step left no usable state and was undone; the last good state stands.
    StepFailed {
        /// Reason of the event.
        reason: String,
    },
    /// A tool has cut a body.
    Cut {
        /// Length \[mm\] of the polyline that was asked for.
        asked: f64,
        /// Length \[mm, rest shape\] that was cut.
        made: f64,
        /// Number of strokes: pieces of the line with a boundary or a slit between them.
        strokes: usize,
    },
}
