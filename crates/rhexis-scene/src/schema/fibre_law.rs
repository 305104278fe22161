//! How the fibres of a body answer: `stiffening_fibres` and `holzapfel_gasser_ogden`.

use serde::de::value::{MapAccessDeserializer, SeqAccessDeserializer};
use serde::de::{Deserialize, Deserializer, Error, IgnoredAny, MapAccess, SeqAccess, Visitor};
use std::fmt;

/// `stiffening_fibres`: adds k₁·e·exp(k₂·e²) to the stress along the fibres in tension, e their strain; from 2/√k₂ on the stress
/// goes on along its tangent. Not with `energy_criterion`. One family, along the fibres: [`HolzapfelGasserOgdenSpec`] has more, and κ.
#[derive(Clone, Copy, Debug)]
pub struct StiffeningFibresSpec {
    /// k₁ \[MPa\], > 0 and at most 1e12.
    pub k1: f64,
    /// k₂, from 1e-9 to 1e9.
    pub k2: f64,
}

impl<'de> Deserialize<'de> for StiffeningFibresSpec {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        #[derive(serde::Deserialize)]
        #[serde(deny_unknown_fields)]
        struct Table {
            k1: f64,
            k2: f64,
            kappa: Option<IgnoredAny>,
            degrees: Option<IgnoredAny>,
        }
        struct Read;
        impl<'de> Visitor<'de> for Read {
            type Value = StiffeningFibresSpec;
            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str("a table with `k1` and `k2`")
            }
            fn visit_map<A: MapAccess<'de>>(self, access: A) -> Result<Self::Value, A::Error> {
                let Table { k1, k2, kappa, degrees } = Table::deserialize(MapAccessDeserializer::new(access))?;
                let what = match (kappa, degrees) {
                    (None, None) => return Ok(StiffeningFibresSpec { k1, k2 }),
                    (Some(_), _) => "this law, of the fibre's stretch, has no dispersion `kappa`",
                    (None, Some(_)) => "the fibres of this law run along `fibres`, and have no angle of their own",
                };
                Err(Error::custom(format!("{what}; {INSTEAD}")))
            }
            fn visit_seq<A: SeqAccess<'de>>(self, _: A) -> Result<Self::Value, A::Error> {
                Err(Error::custom(format!("this law has one family of fibres, along `fibres`; {INSTEAD}")))
            }
        }
        deserializer.deserialize_any(Read)
    }
}

const INSTEAD: &str = "`holzapfel_gasser_ogden = { k1 = …, k2 = …, degrees = [40, -40], kappa = … }` is the published law, \
                       of the invariants I₁ and I₄";

/// `holzapfel_gasser_ogden`: k₁/(2·k₂)·(exp(k₂·E²) − 1) per volume for each family where E = κ·(I₁ − 3) + (1 − 3κ)·(I₄ − 1) > 0, in the linear
/// law or, with `material = { model = "neo_hookean", … }`, in a neo-Hookean matrix; numbers as in papers, in MPa. A table, or a list
/// of tables for families that differ; at most four families. Not with `stiffening_fibres` or `energy_criterion`.
#[derive(Clone, Debug)]
pub struct HolzapfelGasserOgdenSpec(pub Vec<FibreFamilySpec>);

/// Families of fibres that are alike but for their angles.
#[derive(Clone, Debug, serde::Deserialize)]
#[serde(deny_unknown_fields)]
pub struct FibreFamilySpec {
    /// k₁ \[MPa\], from 0 to 1e12.
    pub k1: f64,
    /// k₂, from 1e-9 to 1e9.
    pub k2: f64,
    /// Angle \[°\] from `fibres`, counter-clockwise about the normal, or a list of such, a family each. Default 0.
    #[serde(default)]
    pub degrees: Angles,
    /// Dispersion κ, from 0 (all parallel) to 1/3 (isotropic). Default 0.
    #[serde(default)]
    pub kappa: f64,
}

/// One angle \[°\] or several.
#[derive(Clone, Debug, serde::Deserialize)]
#[serde(try_from = "super::Numbers")]
pub struct Angles(pub Vec<f64>);

impl Default for Angles {
    fn default() -> Self {
        Self(vec![0.0])
    }
}

impl TryFrom<super::Numbers> for Angles {
    type Error = &'static str;
    fn try_from(numbers: super::Numbers) -> Result<Self, Self::Error> {
        let list = numbers.one().map(|angle| vec![angle]).or_else(|| numbers.flat());
        list.filter(|list| !list.is_empty()).map(Self).ok_or("no angles; write 40 or [40, -40]")
    }
}

impl<'de> Deserialize<'de> for HolzapfelGasserOgdenSpec {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct Read;
        impl<'de> Visitor<'de> for Read {
            type Value = HolzapfelGasserOgdenSpec;
            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str("a table with `k1`, `k2`, `degrees` and `kappa`, or a list of such tables")
            }
            fn visit_map<A: MapAccess<'de>>(self, access: A) -> Result<Self::Value, A::Error> {
                let family = FibreFamilySpec::deserialize(MapAccessDeserializer::new(access))?;
                Ok(HolzapfelGasserOgdenSpec(vec![family]))
            }
            fn visit_seq<A: SeqAccess<'de>>(self, access: A) -> Result<Self::Value, A::Error> {
                Vec::deserialize(SeqAccessDeserializer::new(access)).map(HolzapfelGasserOgdenSpec)
            }
        }
        deserializer.deserialize_any(Read)
    }
}
