//! Contact as text and as bytes. Up to version 18 without self-contact: older bytes are those of a body without it.

use super::obstacle::Contact;
use super::self_contact::SelfContact;
use serde::{Deserialize, Deserializer, Serialize, Serializer};

/// The fields by their names.
#[derive(Serialize, Deserialize)]
#[serde(remote = "Contact")]
struct Text {
    stiffness: Option<f64>,
    friction: f64,
    #[serde(default)]
    self_contact: Option<SelfContact>,
    #[serde(default)]
    between_bodies: bool,
}

/// The fields in the order of the bytes.
#[derive(Serialize, Deserialize)]
struct Bytes {
    stiffness: Stiffness,
    friction: f64,
}

/// Stiffness, and the contact of the body with itself, and with others, where there is one.
#[derive(Serialize, Deserialize)]
enum Stiffness {
    OfMembrane,
    Given(f64),
    OfMembraneAnd(SelfContact),
    GivenAnd(f64, SelfContact),
    OfMembraneAndBodies(SelfContact),
    GivenAndBodies(f64, SelfContact),
}

impl Serialize for Contact {
    fn serialize<S: Serializer>(&self, to: S) -> Result<S::Ok, S::Error> {
        if to.is_human_readable() {
            return Text::serialize(self, to);
        }
        let stiffness = match (self.stiffness, self.self_contact, self.between_bodies) {
            (None, None, _) => Stiffness::OfMembrane,
            (Some(stiffness), None, _) => Stiffness::Given(stiffness),
            (None, Some(own), false) => Stiffness::OfMembraneAnd(own),
            (Some(stiffness), Some(own), false) => Stiffness::GivenAnd(stiffness, own),
            (None, Some(own), true) => Stiffness::OfMembraneAndBodies(own),
            (Some(stiffness), Some(own), true) => Stiffness::GivenAndBodies(stiffness, own),
        };
        Bytes { stiffness, friction: self.friction }.serialize(to)
    }
}

impl<'de> Deserialize<'de> for Contact {
    fn deserialize<D: Deserializer<'de>>(from: D) -> Result<Self, D::Error> {
        if from.is_human_readable() {
            return Text::deserialize(from);
        }
        let Bytes { stiffness, friction } = Bytes::deserialize(from)?;
        let (stiffness, self_contact, between_bodies) = match stiffness {
            Stiffness::OfMembrane => (None, None, false),
            Stiffness::Given(stiffness) => (Some(stiffness), None, false),
            Stiffness::OfMembraneAnd(own) => (None, Some(own), false),
            Stiffness::GivenAnd(stiffness, own) => (Some(stiffness), Some(own), false),
            Stiffness::OfMembraneAndBodies(own) => (None, Some(own), true),
            Stiffness::GivenAndBodies(stiffness, own) => (Some(stiffness), Some(own), true),
        };
        Ok(Self { stiffness, friction, self_contact, between_bodies })
    }
}
