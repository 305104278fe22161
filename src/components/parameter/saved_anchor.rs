//! Anchors as text and as bytes. Bytes without bonds are those of older versions, which knew none.

use super::springs::{Anchor, Bond};
use glam::DVec3;
use serde::de::{Error, SeqAccess, Visitor};
use serde::ser::SerializeTuple;
use serde::{Deserialize, Deserializer, Serialize, Serializer};
use std::fmt;

/// Bits of a number that is none, in the place of the stiffness: stiffness and bond follow.
const BOND_FOLLOWS: u64 = 0x7ff8_0000_626f_6e64;

/// The fields by their names.
#[derive(Serialize, Deserialize)]
#[serde(remote = "Anchor")]
struct Text {
    point: DVec3,
    stiffness: f64,
    #[serde(default)]
    bond: Option<Bond>,
}

impl Serialize for Anchor {
    fn serialize<S: Serializer>(&self, to: S) -> Result<S::Ok, S::Error> {
        if to.is_human_readable() {
            return Text::serialize(self, to);
        }
        let mut bytes = to.serialize_tuple(if self.bond.is_some() { 4 } else { 2 })?;
        bytes.serialize_element(&self.point)?;
        if let Some(bond) = &self.bond {
            bytes.serialize_element(&f64::from_bits(BOND_FOLLOWS))?;
            bytes.serialize_element(&self.stiffness)?;
            bytes.serialize_element(bond)?;
        } else {
            bytes.serialize_element(&self.stiffness)?;
        }
        bytes.end()
    }
}

impl<'de> Deserialize<'de> for Anchor {
    fn deserialize<D: Deserializer<'de>>(from: D) -> Result<Self, D::Error> {
        if from.is_human_readable() {
            return Text::deserialize(from);
        }
        from.deserialize_tuple(4, Bytes)
    }
}

/// The fields in the order of the bytes.
struct Bytes;

impl<'de> Visitor<'de> for Bytes {
    type Value = Anchor;

    fn expecting(&self, to: &mut fmt::Formatter<'_>) -> fmt::Result {
        to.write_str("the anchor of a spring")
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut bytes: A) -> Result<Anchor, A::Error> {
        let ended = || A::Error::custom("an anchor ends early");
        let point = bytes.next_element()?.ok_or_else(ended)?;
        let stiffness: f64 = bytes.next_element()?.ok_or_else(ended)?;
        if stiffness.to_bits() != BOND_FOLLOWS {
            return Ok(Anchor { point, stiffness, bond: None });
        }
        let stiffness = bytes.next_element()?.ok_or_else(ended)?;
        let bond = bytes.next_element()?.ok_or_else(ended)?;
        Ok(Anchor { point, stiffness, bond: Some(bond) })
    }
}
