//! Why tissue tears, parts or withstands, and why the energy guard acts.

use glam::DVec3;
use std::fmt;

/// Which criterion a decision is of.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "snapshot", derive(serde::Serialize, serde::Deserialize))]
pub enum DecidedBy {
    /// The stress averaged over the disc.
    #[default]
    Stress,
    /// The energy that a kink releases ([`EnergyCriterion`](crate::components::EnergyCriterion)).
    Energy,
    /// The energy that an advance releases by the material force alone, because the disc around the tip has no field of a plane crack.
    MaterialForce(RingFault),
    /// None: a blade led the tip.
    Blade,
    /// The start itself, whose whole length opens at once: strength along it and the energy of opening it.
    Nucleation,
}

/// Why the ring around a tip does not have the field of one straight crack.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[cfg_attr(feature = "snapshot", derive(serde::Serialize, serde::Deserialize))]
pub enum RingFault {
    /// No crack leads through the ring to the tip: the tip stands at an open corner, or its crack ends within the ring.
    #[error("no crack leads through the ring")]
    NoCrack,
    /// The ring meets a boundary that is not the two lips of a straight crack: the rim, another tear, a bend of its own.
    #[error("the ring meets another boundary than a straight crack's lips")]
    OtherBoundary,
    /// The disc is folded, at rest or now: a triangle's normal is off the mean by more than 60°.
    #[error("the ring is folded")]
    Bent,
    /// The field is not a plane crack's: its stress intensities release another energy than the material force.
    #[error("the field is not that of a plane crack")]
    OtherField,
    /// The field opens nothing: no energy is released in any direction.
    #[error("the ring releases no energy")]
    NoRelease,
    /// The fibres stiffen, and the fields by which the ring is read are those of a linear law.
    #[error("the fibres stiffen")]
    Stiffening,
}

impl RingFault {
    /// All of them.
    pub const ALL: [Self; 6] =
        [Self::NoCrack, Self::OtherBoundary, Self::Bent, Self::OtherField, Self::NoRelease, Self::Stiffening];
}

impl fmt::Display for DecidedBy {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Stress => f.write_str("stress"),
            Self::Energy => f.write_str("energy"),
            Self::Blade => f.write_str("blade"),
            Self::Nucleation => f.write_str("strength and energy of a nucleation"),
            Self::MaterialForce(fault) => write!(f, "energy by the material force: {fault}"),
        }
    }
}

/// A start whose stress reaches the strength, and which does not open for want of energy.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "snapshot", derive(serde::Serialize, serde::Deserialize))]
pub struct BlockedNucleation {
    /// Position of the start \[mm, rest shape\].
    pub at: DVec3,
    /// The criterion of strength there, above 1.
    pub criterion: f64,
    /// Length along which the strength is reached \[mm\], in whole edges; zero where that is less than one.
    pub length: f64,
    /// Energy that opening it would release, per area \[N/mm\].
    pub release: f64,
    /// Mean toughness along it \[N/mm\].
    pub toughness: f64,
}

/// Why tissue parts where no tip leads.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "snapshot", derive(serde::Serialize, serde::Deserialize))]
pub enum PartedBy {
    /// A ligament narrower than R carries more than its strength over its whole width.
    Ligament,
    /// The tissue is stretched beyond [`ultimate_stretch`](crate::components::Tearing::ultimate_stretch).
    Stretch,
}

impl fmt::Display for PartedBy {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Ligament => "ligament",
            Self::Stretch => "stretch",
        })
    }
}

/// Why an attempt at a step was refused, or its answer limited.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "snapshot", derive(serde::Serialize, serde::Deserialize))]
#[non_exhaustive]
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
    /// Energy from the residual of the linear solve: its tolerance is too loose.
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
