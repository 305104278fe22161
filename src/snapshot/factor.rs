//! A body's Cholesky factor among the bytes of a snapshot: a block with its length in front, whose first byte is its layout. A build
//! without the feature `direct` passes over it and writes none, which a build with it reads as no factor yet; so it does with the layouts
//! of versions before 16, whose factors were those of dynamic steps.

use crate::systems::solver::FactorState;
use serde::de::Visitor;
use serde::ser::Error as _;
use serde::{Deserialize, Deserializer, Serialize, Serializer};

/// First byte of a block; before version 16 it was 0 or 1.
const LAYOUT: u8 = 2;

struct Written(Vec<u8>);

impl Serialize for Written {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.serialize_bytes(&self.0)
    }
}

struct Read(FactorState);

impl<'de> Deserialize<'de> for Read {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_bytes(Block)
    }
}

struct Block;

impl Visitor<'_> for Block {
    type Value = Read;

    fn expecting(&self, f: &mut std::fmt::Formatter) -> std::fmt::Result {
        f.write_str("the bytes of a factor")
    }

    fn visit_bytes<E: serde::de::Error>(self, bytes: &[u8]) -> Result<Read, E> {
        let Some((&LAYOUT, block)) = bytes.split_first().filter(|_| cfg!(feature = "direct")) else {
            return Ok(Read(FactorState::default()));
        };
        match postcard::take_from_bytes(block) {
            Ok((state, [])) => Ok(Read(state)),
            Ok(_) => Err(E::custom("more follows on a factor than belongs to it")),
            Err(error) => Err(E::custom(error)),
        }
    }
}

pub(super) fn serialize<S: Serializer>(factor: &Option<FactorState>, serializer: S) -> Result<S::Ok, S::Error> {
    let block = |state: &FactorState| match cfg!(feature = "direct") {
        true => postcard::to_extend(state, vec![LAYOUT]),
        false => Ok(Vec::new()),
    };
    let bytes = factor.as_ref().map(block).transpose().map_err(S::Error::custom)?;
    bytes.map(Written).serialize(serializer)
}

pub(super) fn deserialize<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Option<FactorState>, D::Error> {
    Ok(Option::<Read>::deserialize(deserializer)?.map(|Read(state)| state))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[derive(Serialize, Deserialize)]
    struct Between {
        before: u8,
        #[serde(with = "super")]
        factor: Option<FactorState>,
        after: u8,
    }

    fn read(bytes: &[u8]) -> Option<Between> {
        postcard::take_from_bytes(bytes).ok().filter(|(_, rest)| rest.is_empty()).map(|(value, _)| value)
    }

    #[test]
    fn what_a_build_without_factors_has_written_is_no_factor_yet() {
        let Between { before: 7, factor: Some(state), after: 9 } = read(&[7, 1, 0, 9]).unwrap() else { panic!() };
        assert_eq!(format!("{state:?}"), format!("{:?}", FactorState::default()));
        assert!(read(&[7, 0, 9]).unwrap().factor.is_none());
    }

    #[test]
    fn what_a_build_with_factors_has_written_is_read_or_passed_over() {
        // Of this layout: no factor in use, one to be begun with in five solves.
        let bytes = [7, 1, 3, 2, 0, 5, 9];
        let value = read(&bytes).unwrap();
        assert!(value.factor.is_some() && value.after == 9);
        let again = postcard::to_allocvec(&value).unwrap();
        assert_eq!(again, if cfg!(feature = "direct") { bytes.to_vec() } else { vec![7, 1, 0, 9] });
    }

    #[test]
    fn what_a_version_before_16_has_written_is_no_factor_yet() {
        // Neither a factor in use nor one that was being made; the five counts of its age.
        let Between { factor: Some(state), after: 9, .. } = read(&[7, 1, 7, 0, 0, 5, 1, 4, 2, 3, 9]).unwrap() else {
            panic!()
        };
        assert_eq!(format!("{state:?}"), format!("{:?}", FactorState::default()));
    }

    #[test]
    fn what_follows_on_a_factor_is_refused_by_a_build_that_reads_it() {
        assert_eq!(read(&[7, 1, 4, 2, 0, 5, 0, 9]).is_some(), cfg!(not(feature = "direct")));
        assert!(read(&[7, 1, 200, 1, 2, 0, 5, 9]).is_none(), "the length is more than there is");
    }
}
