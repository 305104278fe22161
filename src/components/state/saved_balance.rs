//! An energy balance as text and as bytes. Bytes without dissipation by relaxation are those of older versions, which knew none.

use super::energy_audit::{Energies, EnergyBalance};
use serde::{
    Deserialize, Deserializer, Serialize, Serializer, de::Error, de::SeqAccess, de::Visitor, ser::SerializeTuple,
};
use std::fmt;

/// NaN bits in the place of the first term: relaxation and the first term follow.
const RELAXATION_FOLLOWS: u64 = 0x7ff8_0000_7265_6c61;

/// The terms by their names.
#[derive(Serialize, Deserialize)]
#[serde(remote = "EnergyBalance")]
struct Text {
    work_of_holds: f64,
    work_of_jaws: f64,
    work_of_loads: f64,
    edits: Energies,
    stored: Energies,
    damping: f64,
    #[serde(default)]
    relaxation: f64,
    drag: f64,
    numerical_elastic: f64,
    numerical_kinetic: f64,
    residual: f64,
    unbalanced: f64,
    released: f64,
}

/// The terms in the order of the bytes, without relaxation and the first one.
#[derive(Serialize, Deserialize)]
#[serde(remote = "EnergyBalance")]
struct OthersOf {
    #[serde(skip)]
    work_of_holds: f64,
    work_of_jaws: f64,
    work_of_loads: f64,
    edits: Energies,
    stored: Energies,
    damping: f64,
    #[serde(skip)]
    relaxation: f64,
    drag: f64,
    numerical_elastic: f64,
    numerical_kinetic: f64,
    residual: f64,
    unbalanced: f64,
    released: f64,
}

/// Those terms of a balance.
#[derive(Serialize, Deserialize)]
struct Others(#[serde(with = "OthersOf")] EnergyBalance);

impl Serialize for EnergyBalance {
    fn serialize<S: Serializer>(&self, to: S) -> Result<S::Ok, S::Error> {
        if to.is_human_readable() {
            return Text::serialize(self, to);
        }
        let relaxes = self.relaxation != 0.0;
        let mut bytes = to.serialize_tuple(if relaxes { 4 } else { 2 })?;
        if relaxes {
            bytes.serialize_element(&f64::from_bits(RELAXATION_FOLLOWS))?;
            bytes.serialize_element(&self.relaxation)?;
        }
        bytes.serialize_element(&self.work_of_holds)?;
        bytes.serialize_element(&Others(*self))?;
        bytes.end()
    }
}

impl<'de> Deserialize<'de> for EnergyBalance {
    fn deserialize<D: Deserializer<'de>>(from: D) -> Result<Self, D::Error> {
        if from.is_human_readable() {
            return Text::deserialize(from);
        }
        from.deserialize_tuple(4, Bytes)
    }
}

/// Reader of the bytes.
struct Bytes;

impl<'de> Visitor<'de> for Bytes {
    type Value = EnergyBalance;

    fn expecting(&self, to: &mut fmt::Formatter<'_>) -> fmt::Result {
        to.write_str("an energy balance")
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut bytes: A) -> Result<EnergyBalance, A::Error> {
        let ended = || A::Error::custom("an energy balance ends early");
        let mut work_of_holds: f64 = bytes.next_element()?.ok_or_else(ended)?;
        let mut relaxation = 0.0;
        if work_of_holds.to_bits() == RELAXATION_FOLLOWS {
            relaxation = bytes.next_element()?.ok_or_else(ended)?;
            work_of_holds = bytes.next_element()?.ok_or_else(ended)?;
        }
        let Others(others) = bytes.next_element()?.ok_or_else(ended)?;
        Ok(EnergyBalance { work_of_holds, relaxation, ..others })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_balance_is_read_as_it_was_written() {
        for relaxation in [0.0, 0.25] {
            let balance = EnergyBalance { work_of_holds: 1.5, relaxation, released: -2.0, ..EnergyBalance::default() };
            let bytes = postcard::to_allocvec(&balance).unwrap();
            assert_eq!(bytes.len(), 8 * if relaxation > 0.0 { 16 } else { 14 });
            assert_eq!(postcard::from_bytes::<EnergyBalance>(&bytes).unwrap(), balance);
        }
    }
}
