//! Motion of an obstacle in the step, and its forces on bodies.

use crate::components::check::{Check, Host, Owner, finite};
use crate::components::{BodyError, Rigid, Shape};
use glam::{DMat3, DVec3};
use hecs::Entity;
use smallvec::SmallVec;

/// Where an obstacle was at the start of the step, so that none passes through a body unchecked, and how tissue moves it. *State.*
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "snapshot", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "snapshot", serde(from = "saved::Motion", into = "saved::Motion"))]
pub struct ObstacleMotion {
    /// Shape of the obstacle at the start of the step.
    pub from: Shape,
    /// The rotation from there to where it is now, if it is turned.
    pub turn: Option<DMat3>,
    /// Mass and motion of a rigid body that tissue pushes; `None` for an obstacle that yields to nothing.
    pub rigid: Option<Rigid>,
    /// The step of a rigid body that is under way.
    pub(crate) under_way: Option<Box<RigidStep>>,
}

impl ObstacleMotion {
    /// An obstacle that was there, and yields to nothing.
    pub fn at(from: Shape) -> Self {
        Self { from, turn: None, rigid: None, under_way: None }
    }
}

/// Where and how a rigid body is.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct RigidState {
    pub shape: Shape,
    pub rigid: Rigid,
}

/// A rigid body within a step. *Derived.*
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct RigidStep {
    /// State at the start of the step, and that time \[ms\].
    pub first: RigidState,
    pub first_time: f64,
    /// State at the start of the part of the step that is under way.
    pub part: RigidState,
    /// State at the end of the last part that left sound bodies, and that time \[ms\].
    pub settled: Option<(RigidState, f64)>,
    /// Deviation from free motion over that part with which it waits for tissue: displacement \[mm\] and rotation vector \[rad\].
    pub expected: [DVec3; 2],
    /// Further deviation by the push of each body: displacement \[mm\] and rotation vector \[rad\].
    pub deviations: SmallVec<[(Entity, [DVec3; 2]); 2]>,
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
        self.rigid.map_or(Ok(()), |rigid| rigid.check("ObstacleMotion"))?;
        self.turn.map_or(Ok(()), |turn| finite("ObstacleMotion", "turn", turn.to_cols_array()))
    }
}

impl Check for ContactForces {
    const OWNER: Owner = Owner::Obstacle;

    fn check(&self, _: &Host<'_>) -> Result<(), BodyError> {
        self.forces.iter().try_for_each(|(_, force)| finite("ContactForces", "force", force.to_array()))
    }
}

/// The motion as bytes: those of an obstacle that yields to nothing did not change when rigid bodies came.
#[cfg(feature = "snapshot")]
mod saved {
    use super::{DMat3, ObstacleMotion, Rigid, Shape};
    use serde::{Deserialize, Serialize};

    #[derive(Serialize, Deserialize)]
    pub(super) struct Motion {
        from: Shape,
        turn: Turn,
    }

    #[derive(Serialize, Deserialize)]
    enum Turn {
        None,
        Some(DMat3),
        NoneAnd(Rigid),
        SomeAnd(DMat3, Rigid),
    }

    impl From<ObstacleMotion> for Motion {
        fn from(ObstacleMotion { from, turn, rigid, .. }: ObstacleMotion) -> Self {
            let turn = match (turn, rigid) {
                (None, None) => Turn::None,
                (Some(turn), None) => Turn::Some(turn),
                (None, Some(rigid)) => Turn::NoneAnd(rigid),
                (Some(turn), Some(rigid)) => Turn::SomeAnd(turn, rigid),
            };
            Self { from, turn }
        }
    }

    impl From<Motion> for ObstacleMotion {
        fn from(Motion { from, turn }: Motion) -> Self {
            let (turn, rigid) = match turn {
                Turn::None => (None, None),
                Turn::Some(turn) => (Some(turn), None),
                Turn::NoneAnd(rigid) => (None, Some(rigid)),
                Turn::SomeAnd(turn, rigid) => (Some(turn), Some(rigid)),
            };
            Self { turn, rigid, ..Self::at(from) }
        }
    }
}
