//! Loads and damping of a whole body. All are parameters; each has its own system, which runs only where the component is present.

use crate::components::BodyError;
use crate::components::Curve;
use crate::components::check::{Check, Host, finite, not_negative, place};
use crate::math::{HolzapfelGasserOgden, StiffeningFibres, Sym2};
use glam::DVec3;

/// Damping of strain rates: the stress C:(U − I) becomes C:(U − I + β·dU/dt). Rigid motion is not braked. *Parameter.*
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "snapshot", derive(serde::Serialize, serde::Deserialize))]
pub struct Damping {
    /// β \[ms\], ≥ 0.
    pub time: f64,
}

/// Uniform acceleration. *Parameter.*
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "snapshot", derive(serde::Serialize, serde::Deserialize))]
pub struct Gravity {
    /// \[mm/ms²\]; the earth's is 9.81e-3.
    pub acceleration: DVec3,
}

/// Follower pressure along each triangle's current normal, on its current area. *Parameter.*
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "snapshot", derive(serde::Serialize, serde::Deserialize))]
pub struct Pressure {
    /// \[MPa\] over time.
    pub curve: Curve,
}

/// Viscous drag of the surrounding fluid, proportional to velocity and rest area. *Parameter.*
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "snapshot", derive(serde::Serialize, serde::Deserialize))]
pub struct Drag {
    /// \[N·ms/mm³\], ≥ 0.
    pub coefficient: f64,
}

/// Pre-stretch held by the surroundings, as an initial Biot strain: the stress is C:(U − I + ε₀), so the drawn shape is
/// under tension and a released piece shrinks to U = I − ε₀. *Parameter.*
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "snapshot", derive(serde::Serialize, serde::Deserialize))]
pub struct PreStretch {
    /// ε₀ in the axes (fibre, transverse).
    pub strain: Sym2,
}

impl PreStretch {
    /// The stretch that is free of stress: the identity, less the pre-stretch where there is one.
    pub fn unstretched(this: Option<&Self>) -> Sym2 {
        Sym2::IDENTITY - this.map_or(Sym2::ZERO, |p| p.strain)
    }
}

impl Check for Damping {
    fn check(&self, _: &Host<'_>) -> Result<(), BodyError> {
        not_negative("Damping", "damping time", self.time)
    }
}

impl Check for Gravity {
    fn check(&self, _: &Host<'_>) -> Result<(), BodyError> {
        finite("Gravity", "acceleration", self.acceleration.to_array())
    }
}

impl Check for Pressure {
    fn check(&self, _: &Host<'_>) -> Result<(), BodyError> {
        self.curve.check("Pressure")
    }
}

impl Check for Drag {
    fn check(&self, _: &Host<'_>) -> Result<(), BodyError> {
        not_negative("Drag", "drag coefficient", self.coefficient)
    }
}

impl Check for PreStretch {
    fn check(&self, _: &Host<'_>) -> Result<(), BodyError> {
        place("PreStretch", "strain", [self.strain.xx, self.strain.yy, self.strain.xy])
    }
}

impl HolzapfelGasserOgden {
    /// Judges it under a held pre-stretch.
    pub(crate) fn check_under(&self, held: Sym2) -> Result<(), BodyError> {
        let component = "HolzapfelGasserOgden";
        let wrong = |(what, value, must)| BodyError::OutOfRange { component, what, row: None, value, must };
        Self::check(self, held).map_err(wrong)
    }
}

impl Check for HolzapfelGasserOgden {
    fn check(&self, _: &Host<'_>) -> Result<(), BodyError> {
        self.check_under(Sym2::ZERO)
    }
}

impl Check for StiffeningFibres {
    fn check(&self, _: &Host<'_>) -> Result<(), BodyError> {
        Self::check(self).map_err(|(what, value, must)| {
            let component = "StiffeningFibres";
            BodyError::OutOfRange { component, what, row: None, value, must }
        })
    }
}
