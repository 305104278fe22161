//! Tearing as text and as bytes. Bytes of snapshots up to version 16 had a largest speed behind each mode: it is passed over.

use super::tearing::{TearMode, TearRate, Tearing};
use serde::{Deserialize, Deserializer, Serialize, Serializer};

/// The fields by their names.
#[derive(Serialize, Deserialize)]
#[serde(remote = "Tearing")]
struct Text {
    strength_across_fibres: f64,
    strength_along_fibres: f64,
    exponent: f64,
    cone: f64,
    radius: f64,
    mode: TearMode,
    rate: Option<TearRate>,
    may_initiate: bool,
    ultimate_stretch: Option<f64>,
    branch_margin: Option<f64>,
}

/// The fields in the order of the bytes.
#[derive(Serialize, Deserialize)]
struct Bytes {
    strengths: [f64; 2],
    exponent: f64,
    cone: f64,
    radius: f64,
    way: Way,
    may_initiate: bool,
    ultimate_stretch: Option<f64>,
    branch_margin: Option<f64>,
}

/// Mode and rate; with a largest speed \[mm/ms\] up to version 16.
#[derive(Serialize, Deserialize)]
enum Way {
    Free(f64),
    Edge(f64),
    Glide(f64),
    Rated(TearMode, Option<TearRate>),
}

impl Serialize for Tearing {
    fn serialize<S: Serializer>(&self, to: S) -> Result<S::Ok, S::Error> {
        if to.is_human_readable() {
            return Text::serialize(self, to);
        }
        let Self { exponent, cone, radius, may_initiate, ultimate_stretch, branch_margin, .. } = *self;
        let strengths = [self.strength_across_fibres, self.strength_along_fibres];
        let way = Way::Rated(self.mode, self.rate);
        Bytes { strengths, exponent, cone, radius, way, may_initiate, ultimate_stretch, branch_margin }.serialize(to)
    }
}

impl<'de> Deserialize<'de> for Tearing {
    fn deserialize<D: Deserializer<'de>>(from: D) -> Result<Self, D::Error> {
        if from.is_human_readable() {
            return Text::deserialize(from);
        }
        let bytes = Bytes::deserialize(from)?;
        let Bytes { strengths, exponent, cone, radius, way, may_initiate, ultimate_stretch, branch_margin } = bytes;
        let [strength_across_fibres, strength_along_fibres] = strengths;
        let (mode, rate) = match way {
            Way::Free(_) => (TearMode::Free, None),
            Way::Edge(_) => (TearMode::Edge, None),
            Way::Glide(_) => (TearMode::Glide, None),
            Way::Rated(mode, rate) => (mode, rate),
        };
        Ok(Self {
            strength_across_fibres,
            strength_along_fibres,
            exponent,
            cone,
            radius,
            mode,
            rate,
            may_initiate,
            ultimate_stretch,
            branch_margin,
        })
    }
}
