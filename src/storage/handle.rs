//! Handles of things in the world: an entity with its kind. As bytes they are the entity's bits, so that they stay as they are.

use hecs::Entity;

/// Declares a handle.
macro_rules! handle {
    ($(#[$doc:meta])* $name:ident) => {
        $(#[$doc])*
        #[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
        pub struct $name(Entity);

        impl $name {
            /// The entity, for access to the world.
            pub const fn entity(self) -> Entity {
                self.0
            }
        }

        impl From<Entity> for $name {
            fn from(entity: Entity) -> Self {
                Self(entity)
            }
        }

        impl From<$name> for Entity {
            fn from(id: $name) -> Self {
                id.0
            }
        }

        #[cfg(feature = "snapshot")]
        impl serde::Serialize for $name {
            fn serialize<S: serde::Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
                bits::serialize(&self.0, serializer)
            }
        }

        #[cfg(feature = "snapshot")]
        impl<'de> serde::Deserialize<'de> for $name {
            fn deserialize<D: serde::Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
                bits::deserialize(deserializer).map(Self)
            }
        }
    };
}

handle! {
    /// Handle of a body. One of an entity that is no body is refused by every call.
    ///
    /// # Examples
    /// ```
    /// # let (mut simulation, body) = rhexis::internal::example()?;
    /// # use rhexis::prelude::*;
    /// let tearing = simulation.world().get::<&Tearing>(body.entity()).expect("a tearing body").radius;
    /// simulation.set(body, Tearing { radius: 2.0 * tearing, ..Tearing::default() })?;
    /// # Ok::<(), rhexis::Error>(())
    /// ```
    BodyId
}

handle! {
    /// Handle of an obstacle. One of an entity that is no obstacle is refused by every call.
    ObstacleId
}

handle! {
    /// Handle of forceps. One of an entity that is no forceps is refused by every call.
    ForcepsId
}

handle! {
    /// Handle of a blade. One of an entity that is no blade is refused by every call.
    BladeId
}

/// Entities as bytes, by their bits.
#[cfg(feature = "snapshot")]
pub(crate) mod bits {
    use hecs::Entity;
    use serde::{Deserialize, Deserializer, Serialize, Serializer, de::Error};

    /// Writes the bits.
    pub(crate) fn serialize<S: Serializer>(entity: &Entity, serializer: S) -> Result<S::Ok, S::Error> {
        entity.to_bits().get().serialize(serializer)
    }

    /// Reads an entity.
    pub(crate) fn deserialize<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Entity, D::Error> {
        let bits = u64::deserialize(deserializer)?;
        Entity::from_bits(bits).ok_or_else(|| D::Error::custom("no entity has these bits"))
    }
}
