//! Entities as bytes: by their bits, so that handles stay as they are.

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

/// Optional entities as bytes, by their bits.
pub(crate) mod option {
    use super::{Deserialize, Deserializer, Entity, Error, Serialize, Serializer};

    /// Writes the bits.
    pub(crate) fn serialize<S: Serializer>(entity: &Option<Entity>, serializer: S) -> Result<S::Ok, S::Error> {
        entity.map(|entity| entity.to_bits().get()).serialize(serializer)
    }

    /// Reads an entity.
    pub(crate) fn deserialize<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Option<Entity>, D::Error> {
        let Some(bits) = Option::<u64>::deserialize(deserializer)? else { return Ok(None) };
        Entity::from_bits(bits).map(Some).ok_or_else(|| D::Error::custom("no entity has these bits"))
    }
}
