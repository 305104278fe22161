//! Motion of an obstacle in the step, and its forces on bodies.

use crate::components::check::{Check, Host, Owner, finite};
use crate::components::{BodyError, Shape};
use glam::{DMat3, DVec3};

/// Where an obstacle was at the start of the step, so that none passes through a body unchecked. *State.*
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "snapshot", derive(serde::Serialize, serde::Deserialize))]
pub struct ObstacleMotion {
    /// Shape of the obstacle at the start of the step.
    pub from: Shape,
    /// The rotation from there to where it is now, if it is turned.
    pub turn: Option<DMat3>,
}

/// Forces of an obstacle on bodies in the last step. *State.*
#[derive(Clone, Debug, Default, PartialEq)]
#[cfg_attr(feature = "snapshot", derive(serde::Serialize, serde::Deserialize))]
pub struct ContactForces {
    /// Force on each body that it touches \[N\], by the body's [`order`](crate::components::Body::order).
    pub forces: Vec<(u32, DVec3)>,
}

impl Check for ObstacleMotion {
    const OWNER: Owner = Owner::Obstacle;

    fn check(&self, _: &Host<'_>) -> Result<(), BodyError> {
        self.from.check("ObstacleMotion")?;
        self.turn.map_or(Ok(()), |turn| finite("ObstacleMotion", "turn", turn.to_cols_array()))
    }
}

impl Check for ContactForces {
    const OWNER: Owner = Owner::Obstacle;

    fn check(&self, _: &Host<'_>) -> Result<(), BodyError> {
        self.forces.iter().try_for_each(|(_, force)| finite("ContactForces", "force", force.to_array()))
    }
}
