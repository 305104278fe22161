//! What the plugin tells: events of the engine, tissues that are gone, and what was refused.

use bevy::ecs::entity::Entity;
use bevy::ecs::message::Message;
use bevy::prelude::Name;
use rhexis::event::Event;
use std::error::Error;
use std::fmt;

/// An event of the engine: a tear began, advanced or ended, jaws slipped, a step was undone.
#[derive(Message, Clone, Debug, PartialEq)]
pub struct TissueEvent {
    /// The entity of the tissue; `None` for a body that no entity shows.
    pub tissue: Option<Entity>,
    /// What happened, to which body of the engine and when.
    pub event: Event,
}

/// A tissue whose body has been taken out of the engine; its entity is despawned with this message.
#[derive(Message, Clone, Copy, Debug, PartialEq, Eq)]
pub struct TissueGone {
    /// The entity that showed it.
    pub tissue: Entity,
    /// The body that there was.
    pub body: rhexis::storage::BodyId,
}

/// Something that was refused; nothing else has changed. Its text names the entity and the remedy.
#[derive(Message, Clone, Debug, PartialEq)]
pub struct RhexisError {
    /// The entity; `None` for settings and steps.
    pub entity: Option<Entity>,
    /// The name of the entity, if it has one.
    pub name: Option<String>,
    /// Why.
    pub cause: Cause,
}

/// Why something was refused.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum Cause {
    /// The engine refuses it.
    Engine(rhexis::Error),
    /// A transform that is no rigid motion of finite numbers: the tool stays where it is.
    BadTransform,
    /// A space that is not finite or has more than one scale: millimetres are taken as units.
    BadSpace,
    /// Pins on an entity that shows no body.
    NoSuchTissue(Entity),
    /// Pins with no vertex to hold, by their radius \[mm\] if they have one.
    NothingToPin(Option<f64>),
    /// A mesh that is not in the main world's memory any more.
    MeshTaken,
    /// A side \[mm\] of shown planes that is not positive and finite.
    BadPlaneSide(f64),
}

impl RhexisError {
    pub(crate) fn of(entity: Entity, name: Option<&Name>, cause: impl Into<Cause>) -> Self {
        Self { entity: Some(entity), name: name.map(|name| name.as_str().to_owned()), cause: cause.into() }
    }

    pub(crate) fn of_world(cause: impl Into<Cause>) -> Self {
        Self { entity: None, name: None, cause: cause.into() }
    }
}

impl<E: Into<rhexis::Error>> From<E> for Cause {
    fn from(error: E) -> Self {
        Self::Engine(error.into())
    }
}

impl fmt::Display for RhexisError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match (self.entity, &self.name) {
            (Some(entity), Some(name)) => write!(f, "entity {entity} (`{name}`): {}", self.cause),
            (Some(entity), None) => write!(f, "entity {entity}: {}", self.cause),
            (None, _) => write!(f, "{}", self.cause),
        }
    }
}

impl fmt::Display for Cause {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Engine(error) => write!(f, "{error}"),
            Self::BadTransform => f.write_str(
                "its transform is no rigid motion: give it finite numbers, a unit quaternion and a scale other than zero",
            ),
            Self::BadSpace => f.write_str(
                "the plugin's space is refused, units are millimetres: give it finite numbers, a unit quaternion and one positive scale",
            ),
            Self::NoSuchTissue(tissue) => write!(
                f,
                "its pins are taken off, as entity {tissue} shows no body: give an entity with a Tissue that was not refused"
            ),
            Self::NothingToPin(Some(radius)) => write!(
                f,
                "its pins are taken off, as there is no vertex within {radius} mm: place them nearer, or give a larger radius"
            ),
            Self::NothingToPin(None) => {
                f.write_str("its pins are taken off, as they choose no vertex: choose by positions of the rest shape in mm")
            }
            Self::MeshTaken => f.write_str(
                "its mesh is not in the main world's memory any more: leave the asset usages of a tissue's mesh as they are",
            ),
            Self::BadPlaneSide(side) => write!(
                f,
                "no obstacles are shown, as {side} mm is no side of a square: give a positive finite number"
            ),
        }
    }
}

impl Error for RhexisError {}
