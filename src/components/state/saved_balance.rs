//! An energy balance as text and as bytes. Without relaxation and compartments the bytes are those of older versions.

use super::energy_audit::{Energies, EnergyBalance};
use serde::{
    Deserialize, Deserializer, Serialize, Serializer, de::Error, de::SeqAccess, de::Visitor, ser::SerializeTuple,
};
use std::fmt;

/// NaN bits in the place of the first term: relaxation and the first term follow.
const RELAXATION_FOLLOWS: u64 = 0x7ff8_0000_7265_6c61;

/// NaN bits in its place: the terms of a compartment, relaxation and the first term follow.
const COMPARTMENT_FOLLOWS: u64 = 0x7ff8_0000_636f_6d70;

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
    #[serde(default)]
    inflow: f64,
    #[serde(default)]
    leak: f64,
    #[serde(default)]
    content: f64,
    #[serde(default)]
    numerical_content: f64,
    numerical_elastic: f64,
    numerical_kinetic: f64,
    residual: f64,
    unbalanced: f64,
    released: f64,
}

/// The terms in the order of the bytes, without relaxation, those of compartments and the first one.
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
    #[serde(skip)]
    inflow: f64,
    #[serde(skip)]
    leak: f64,
    #[serde(skip)]
    content: f64,
    #[serde(skip)]
    numerical_content: f64,
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
        let (relaxes, of_compartment) = (self.relaxation != 0.0, self.of_compartment());
        let is_filled = of_compartment != [0.0; 4];
        let mut bytes = to.serialize_tuple(if is_filled {
            5
        } else if relaxes {
            4
        } else {
            2
        })?;
        if is_filled {
            bytes.serialize_element(&f64::from_bits(COMPARTMENT_FOLLOWS))?;
            bytes.serialize_element(&of_compartment)?;
            bytes.serialize_element(&self.relaxation)?;
        } else if relaxes {
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
        from.deserialize_tuple(5, Bytes)
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
        let (mut relaxation, mut of_compartment) = (0.0, [0.0; 4]);
        let is_filled = work_of_holds.to_bits() == COMPARTMENT_FOLLOWS;
        if is_filled {
            of_compartment = bytes.next_element()?.ok_or_else(ended)?;
        }
        if is_filled || work_of_holds.to_bits() == RELAXATION_FOLLOWS {
            relaxation = bytes.next_element()?.ok_or_else(ended)?;
            work_of_holds = bytes.next_element()?.ok_or_else(ended)?;
        }
        let Others(others) = bytes.next_element()?.ok_or_else(ended)?;
        let [inflow, leak, content, numerical_content] = of_compartment;
        Ok(EnergyBalance { work_of_holds, relaxation, inflow, leak, content, numerical_content, ..others })
    }
}

impl EnergyBalance {
    fn of_compartment(&self) -> [f64; 4] {
        [self.inflow, self.leak, self.content, self.numerical_content]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_balance_is_read_as_it_was_written() {
        for (relaxation, leak, count) in [(0.0, 0.0, 14), (0.25, 0.0, 16), (0.0, 0.5, 20), (0.25, 0.5, 20)] {
            let terms = EnergyBalance { relaxation, leak, ..EnergyBalance::default() };
            let balance = EnergyBalance { work_of_holds: 1.5, released: -2.0, ..terms };
            let bytes = postcard::to_allocvec(&balance).unwrap();
            assert_eq!(bytes.len(), 8 * count);
            assert_eq!(postcard::from_bytes::<EnergyBalance>(&bytes).unwrap(), balance);
        }
    }
}
