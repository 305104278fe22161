//! Springs to ground: zonules, a soft foundation, a bed that tissue is stuck to.

use crate::components::BodyError;
use crate::components::check::{Check, Host, at_row, not_negative, number, place, positive};
use crate::storage::{Attached, Attachment};
use glam::DVec3;

/// Where a spring is fixed, and how stiff it is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Anchor {
    /// Fixed point of space \[mm\].
    pub point: DVec3,
    /// Stiffness per rest area of the vertex (a third of its triangles') \[N/mm³\], ≥ 0: a torn vertex shares it out.
    pub stiffness: f64,
    /// Separation from a bed; none for a spring that holds for ever.
    pub bond: Option<Bond>,
}

/// A bond between tissue and a bed, which comes off: traction grows with the opening up to the strength, then falls to zero in a straight line, and the whole
/// takes the energy (Camanho, Davila 2002). Damage never falls.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "snapshot", derive(serde::Serialize, serde::Deserialize))]
pub struct Bond {
    /// Largest traction \[MPa\], > 0. A coarse mesh takes a smaller one, which it resolves, with the same energy (Turon et al. 2007).
    pub strength: f64,
    /// Energy per area \[N/mm\] until it is off, > 0.
    pub energy: f64,
    /// Lost part of the stiffness: 0 where it is whole, 1 where it is off. *State.*
    pub damage: f64,
    /// Lost part of the stiffness in the last solve. *Derived.*
    pub solved: f64,
}

impl Bond {
    /// A whole bond of this strength \[MPa\] and energy per area \[N/mm\].
    pub fn new(strength: f64, energy: f64) -> Self {
        Self { strength, energy, damage: 0.0, solved: 0.0 }
    }

    /// Stiffness per area \[N/mm³\] with which it opens by a tenth of its range before it begins to come off.
    pub fn usual_stiffness(&self) -> f64 {
        5.0 * self.strength * self.strength / self.energy
    }

    /// Least stiffness per area \[N/mm³\]: of a bond that is off at once when it reaches its strength.
    pub(crate) fn least_stiffness(&self) -> f64 {
        0.1 * self.usual_stiffness()
    }
}

impl Anchor {
    /// A spring that holds for ever.
    pub fn new(point: DVec3, stiffness: f64) -> Self {
        Self { point, stiffness, bond: None }
    }

    /// Whether it still pulls.
    pub fn is_whole(&self) -> bool {
        self.bond.is_none_or(|bond| bond.damage < 1.0)
    }

    /// Stiffness per area in the last solve \[N/mm³\].
    pub(crate) fn solved_stiffness(&self) -> f64 {
        self.bond.map_or(self.stiffness, |bond| self.stiffness * (1.0 - bond.solved))
    }
}

impl Attachment for Anchor {
    fn between(a: Self, b: Self, weight: f64) -> Self {
        let mean = |a, b| f64::between(a, b, weight);
        let bond = a.bond.zip(b.bond).map(|(a, b)| Bond {
            strength: mean(a.strength, b.strength),
            energy: mean(a.energy, b.energy),
            damage: mean(a.damage, b.damage),
            solved: mean(a.solved, b.solved),
        });
        Self {
            point: a.point.lerp(b.point, weight),
            stiffness: mean(a.stiffness, b.stiffness),
            bond: bond.or(a.bond).or(b.bond),
        }
    }
}

/// Linear springs of zero rest length between vertices and fixed points of space. *Parameter*, but for the damage of bonds.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "snapshot", derive(serde::Serialize, serde::Deserialize))]
pub struct Springs {
    /// The vertices and their anchors.
    pub anchors: Attached<Anchor>,
}

impl Check for Springs {
    fn check(&self, host: &Host<'_>) -> Result<(), BodyError> {
        host.rows("Springs", || "springs".to_owned(), self.anchors.rows())?;
        for (&row, anchor) in self.anchors.rows().iter().zip(self.anchors.values()) {
            not_negative("Springs", "spring stiffness", anchor.stiffness).map_err(at_row(row))?;
            place("Springs", "fixed point", anchor.point.to_array()).map_err(at_row(row))?;
            anchor.bond.map_or(Ok(()), |bond| bond.check(anchor.stiffness)).map_err(at_row(row))?;
        }
        Ok(())
    }
}

impl Bond {
    fn check(&self, stiffness: f64) -> Result<(), BodyError> {
        positive("Springs", "strength of a bond", self.strength)?;
        positive("Springs", "energy of a bond", self.energy)?;
        for damage in [self.damage, self.solved] {
            let is_right = (0.0..=1.0).contains(&damage);
            number("Springs", "damage of a bond", damage, (is_right, "it must be from 0 to 1"))?;
        }
        let is_right = stiffness >= self.least_stiffness();
        let must = "a bond needs strength² / (2 · energy) or more, or it would take more than its energy";
        number("Springs", "spring stiffness", stiffness, (is_right, must))
    }
}
