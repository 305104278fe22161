//! Interventions of the energy guard on a body in a step.

use crate::event::{GuardCause, GuardPlace};

/// Why a body's step was given up: the last good state stands.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[cfg_attr(feature = "snapshot", derive(serde::Serialize, serde::Deserialize))]
#[non_exhaustive]
pub enum Fault {
    /// A linear system without a finite solution: a force, a stiffness or a prescribed motion beyond the range of numbers.
    #[error("its linear system has no finite answer: a force, a stiffness or a prescribed motion is too large")]
    Unsolvable,
    /// A position that is not finite, or velocities whose energy is not.
    #[error("its positions or velocities are not finite, or so large that their energy is not")]
    NotFinite,
    /// Spurious energy, however small the fraction of the increment.
    #[error("even the smallest part of its step would create energy: take a shorter step, or add damping")]
    CreatesEnergy,
}

/// Interventions of the energy guard on a body in one step.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "snapshot", derive(serde::Serialize, serde::Deserialize))]
pub struct GuardFigures {
    /// Attempts that got a Newton correction, by cause in the order of [`GuardCause::ALL`]. Where the last correction was damped, its answer
    /// obeys the bound on energy, not the equations of the step.
    pub corrected: [u32; GuardCause::COUNT],
    /// Undone attempts at the step or a sub-step, by cause in the order of [`GuardCause::ALL`].
    pub refused: [u32; GuardCause::COUNT],
    /// Sub-steps limited to a fraction of their increment, by cause in the order of [`GuardCause::ALL`].
    pub limited: [u32; GuardCause::COUNT],
    /// Sub-steps with a local relaxation, by cause in the order of [`GuardCause::ALL`].
    pub relaxed: [u32; GuardCause::COUNT],
    /// Number of vertices of the body where a sub-step was limited: the fraction applies to all of them.
    pub limited_vertices: u32,
    /// Place of the first intervention other than a correction.
    pub first: Option<GuardPlace>,
}

impl GuardFigures {
    /// Number of attempts that got a Newton correction.
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

    /// Number of parts in which a few vertices were relaxed locally.
    pub fn relaxations(&self) -> u32 {
        self.relaxed.iter().sum()
    }

    /// Whether the guard undid, limited or relaxed anything; corrections alone do not count.
    pub fn has_acted(&self) -> bool {
        self.first.is_some()
    }

    /// Counts an attempt that gets a Newton correction.
    pub(crate) fn correct(&mut self, cause: GuardCause) {
        self.corrected[cause as usize] += 1;
    }

    /// Counts an attempt that is undone.
    pub(crate) fn refuse(&mut self, place: GuardPlace) {
        self.refused[place.cause as usize] += 1;
        self.first.get_or_insert(place);
    }

    /// Counts an answer limited to a fraction, of a body with `vertices` vertices.
    pub(crate) fn limit(&mut self, place: GuardPlace, vertices: usize) {
        self.limited[place.cause as usize] += 1;
        self.limited_vertices = self.limited_vertices.max(u32::try_from(vertices).unwrap_or(u32::MAX));
        self.first.get_or_insert(place);
    }

    /// Counts an answer in which a few vertices were relaxed locally.
    pub(crate) fn relax(&mut self, place: GuardPlace) {
        self.relaxed[place.cause as usize] += 1;
        self.first.get_or_insert(place);
    }
}
