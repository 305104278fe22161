//! What the guard against created energy did to a body in a step, why and where.

use glam::DVec3;
use std::fmt;

/// Why an attempt at a step was refused, or its answer limited.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "snapshot", derive(serde::Serialize, serde::Deserialize))]
pub enum GuardCause {
    /// Energy by the membrane's stress, at a triangle that nothing holds.
    Membrane,
    /// Energy by the membrane's stress, at a triangle of which jaws hold a vertex.
    Grips,
    /// Energy by the membrane's stress, at a triangle of which contact or springs hold a vertex.
    Contact,
    /// Energy by the moments of bending.
    Bending,
    /// Energy by damping, in a step that is solved more than once.
    Damping,
    /// Energy by masses or drag, in a step that is solved more than once.
    Drag,
    /// Energy by what the linear solve left unsolved: its tolerance is too loose.
    Residual,
    /// Energy left by several Newton iterations or by a step of two stages.
    Iterations,
    /// Positions or velocities that are not finite.
    NotFinite,
    /// A linear system that has no finite answer.
    Unsolvable,
}

impl GuardCause {
    /// Number of causes.
    pub const COUNT: usize = 10;

    /// All causes, in the order of the counts.
    pub const ALL: [Self; Self::COUNT] = [
        Self::Membrane,
        Self::Grips,
        Self::Contact,
        Self::Bending,
        Self::Damping,
        Self::Drag,
        Self::Residual,
        Self::Iterations,
        Self::NotFinite,
        Self::Unsolvable,
    ];
}

impl fmt::Display for GuardCause {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Membrane => "membrane",
            Self::Grips => "grips",
            Self::Contact => "contact",
            Self::Bending => "bending",
            Self::Damping => "damping",
            Self::Drag => "drag",
            Self::Residual => "residual",
            Self::Iterations => "iterations",
            Self::NotFinite => "not_finite",
            Self::Unsolvable => "unsolvable",
        })
    }
}

/// Where an attempt at a step was refused or limited, and why.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "snapshot", derive(serde::Serialize, serde::Deserialize))]
pub struct GuardPlace {
    /// Cause.
    pub cause: GuardCause,
    /// Row of the triangle that creates most, where there is one.
    pub triangle: Option<u32>,
    /// Row of the vertex: a corner of that triangle, or the first one that is not finite.
    pub vertex: Option<u32>,
    /// Place of the triangle's centre or of the vertex in the rest shape \[mm\]; zero where there is neither.
    pub at: DVec3,
    /// Energy that the attempt would have created \[mJ\]; zero where that is no number.
    pub energy: f64,
}

impl GuardPlace {
    /// A cause without a place.
    pub(crate) fn nowhere(cause: GuardCause) -> Self {
        Self { cause, triangle: None, vertex: None, at: DVec3::ZERO, energy: 0.0 }
    }
}

/// What the guard did to a body in one step.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "snapshot", derive(serde::Serialize, serde::Deserialize))]
pub struct GuardFigures {
    /// Attempts at the step or a part of it that were solved further from where they led, by cause in the order of [`GuardCause::ALL`].
    pub corrected: [u32; GuardCause::COUNT],
    /// Attempts at the step or a part of it that were undone, by cause in the same order.
    pub refused: [u32; GuardCause::COUNT],
    /// Parts of the step whose answer was limited, by cause in the same order.
    pub limited: [u32; GuardCause::COUNT],
    /// Parts of the step in which a few vertices found their own way, by cause in the same order.
    pub relaxed: [u32; GuardCause::COUNT],
    /// Most vertices whose displacement was limited in one part of the step.
    pub limited_vertices: u32,
    /// The first place.
    pub first: Option<GuardPlace>,
}

impl GuardFigures {
    /// Number of attempts that were solved further.
    pub fn corrections(&self) -> u32 {
        self.corrected.iter().sum()
    }

    /// Number of attempts that were undone.
    pub fn refusals(&self) -> u32 {
        self.refused.iter().sum()
    }

    /// Number of parts whose answer was limited.
    pub fn limitations(&self) -> u32 {
        self.limited.iter().sum()
    }

    /// Number of parts in which a few vertices found their own way.
    pub fn relaxations(&self) -> u32 {
        self.relaxed.iter().sum()
    }

    /// Whether the guard did anything.
    pub fn has_acted(&self) -> bool {
        self.first.is_some()
    }

    /// Counts an attempt that is solved further.
    pub(crate) fn correct(&mut self, cause: GuardCause) {
        self.corrected[cause as usize] += 1;
    }

    /// Counts an attempt that is undone.
    pub(crate) fn refuse(&mut self, place: GuardPlace) {
        self.refused[place.cause as usize] += 1;
        self.first.get_or_insert(place);
    }

    /// Counts an answer of which so many vertices go only a part.
    pub(crate) fn limit(&mut self, place: GuardPlace, vertices: usize) {
        self.limited[place.cause as usize] += 1;
        self.limited_vertices = self.limited_vertices.max(u32::try_from(vertices).unwrap_or(u32::MAX));
        self.first.get_or_insert(place);
    }

    /// Counts an answer in which a few vertices found their own way.
    pub(crate) fn relax(&mut self, place: GuardPlace) {
        self.relaxed[place.cause as usize] += 1;
        self.first.get_or_insert(place);
    }
}
