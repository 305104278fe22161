//! Numbers, points, ranges and curves as a scene file writes them.

use super::HandSpec;
use glam::DVec3;
use rhexis::components::{Curve, Path};
use rhexis::math::Sym2;
use serde::de::value::{MapAccessDeserializer, SeqAccessDeserializer};
use serde::de::{Deserialize, Deserializer, Error, MapAccess, SeqAccess, Visitor};
use std::fmt;

/// A number or a nested list of numbers: what the short forms below are made from.
#[derive(Clone, Debug, PartialEq)]
pub enum Numbers {
    /// One number.
    One(f64),
    /// A list.
    List(Vec<Numbers>),
}

impl Numbers {
    pub(super) fn one(&self) -> Option<f64> {
        match self {
            Self::One(value) => Some(*value),
            Self::List(_) => None,
        }
    }

    /// The numbers of a flat list.
    pub(super) fn flat(&self) -> Option<Vec<f64>> {
        match self {
            Self::One(_) => None,
            Self::List(list) => list.iter().map(Self::one).collect(),
        }
    }
}

impl<'de> Deserialize<'de> for Numbers {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct Read;
        impl<'de> Visitor<'de> for Read {
            type Value = Numbers;
            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str("a number or a list of numbers")
            }
            fn visit_f64<E: Error>(self, value: f64) -> Result<Numbers, E> {
                Ok(Numbers::One(value))
            }
            fn visit_i64<E: Error>(self, value: i64) -> Result<Numbers, E> {
                Ok(Numbers::One(value as f64))
            }
            fn visit_u64<E: Error>(self, value: u64) -> Result<Numbers, E> {
                Ok(Numbers::One(value as f64))
            }
            fn visit_seq<A: SeqAccess<'de>>(self, mut access: A) -> Result<Numbers, A::Error> {
                let mut list = Vec::new();
                while let Some(next) = access.next_element()? {
                    list.push(next);
                }
                Ok(Numbers::List(list))
            }
        }
        deserializer.deserialize_any(Read)
    }
}

/// A list of so many entries, no more and no fewer.
#[derive(Clone, Copy, Debug, PartialEq, serde::Deserialize)]
#[serde(try_from = "Vec<T>", bound = "T: Deserialize<'de>")]
pub struct Exactly<T, const N: usize>(pub [T; N]);

// Serde's own arrays ignore what a list holds beyond their length.
impl<T, const N: usize> TryFrom<Vec<T>> for Exactly<T, N> {
    type Error = String;
    fn try_from(list: Vec<T>) -> Result<Self, String> {
        let count = list.len();
        list.try_into().map(Self).map_err(|_| format!("a list of {count}; give exactly {N} entries"))
    }
}

/// A point or vector: `[x, y, z]`, or `[x, y]` for z = 0.
#[derive(Clone, Copy, Debug, Default, PartialEq, serde::Deserialize)]
#[serde(try_from = "Numbers")]
pub struct Point(pub DVec3);

impl TryFrom<Numbers> for Point {
    type Error = &'static str;
    fn try_from(numbers: Numbers) -> Result<Self, Self::Error> {
        match numbers.flat().as_deref() {
            Some(&[x, y]) => Ok(Self(DVec3::new(x, y, 0.0))),
            Some(&[x, y, z]) => Ok(Self(DVec3::new(x, y, z))),
            None if matches!(numbers, Numbers::One(_)) => {
                Err("one number in place of a vector; write [x, y, z]: the earth's gravity is [0, 0, -9.81e-3]")
            }
            _ => Err("not a point; write [x, y] or [x, y, z]"),
        }
    }
}

/// A closed range: `[least, greatest]`, or one number for that number alone.
#[derive(Clone, Copy, Debug, PartialEq, serde::Deserialize)]
#[serde(try_from = "Numbers")]
pub struct Interval {
    /// Lower end.
    pub least: f64,
    /// Upper end.
    pub greatest: f64,
}

impl Interval {
    /// Whether a value lies in the range widened by `tolerance` on both sides.
    pub fn contains(&self, value: f64, tolerance: f64) -> bool {
        (self.least - tolerance..=self.greatest + tolerance).contains(&value)
    }
}

impl TryFrom<Numbers> for Interval {
    type Error = &'static str;
    fn try_from(numbers: Numbers) -> Result<Self, Self::Error> {
        match (numbers.one(), numbers.flat().as_deref()) {
            (Some(value), _) => Ok(Self { least: value, greatest: value }),
            (_, Some(&[least, greatest])) if least <= greatest => Ok(Self { least, greatest }),
            (_, Some([_, _])) => Err("the range runs backwards; write [least, greatest]"),
            _ => Err("not a range; write one number or [least, greatest]"),
        }
    }
}

/// A quantity over time: one number, `[[time, value], …]` with ascending times \[ms\], linear between and constant outside, or
/// `{ hand = { … } }`, a pull by a hand that trembles.
#[derive(Clone, Debug, PartialEq)]
pub struct TimeCurve(pub Curve);

impl Default for TimeCurve {
    fn default() -> Self {
        Self(Curve::constant(1.0))
    }
}

/// The table form of a curve.
#[derive(serde::Deserialize)]
#[serde(deny_unknown_fields)]
struct NamedCurve {
    hand: HandSpec,
}

impl<'de> Deserialize<'de> for TimeCurve {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct Read;
        impl<'de> Visitor<'de> for Read {
            type Value = TimeCurve;
            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str("a number, a list of points or { hand = { … } }")
            }
            fn visit_f64<E: Error>(self, value: f64) -> Result<TimeCurve, E> {
                Ok(TimeCurve(Curve::constant(value)))
            }
            fn visit_i64<E: Error>(self, value: i64) -> Result<TimeCurve, E> {
                self.visit_f64(value as f64)
            }
            fn visit_u64<E: Error>(self, value: u64) -> Result<TimeCurve, E> {
                self.visit_f64(value as f64)
            }
            fn visit_seq<A: SeqAccess<'de>>(self, access: A) -> Result<TimeCurve, A::Error> {
                TimeCurve::through(&Numbers::deserialize(SeqAccessDeserializer::new(access))?).map_err(A::Error::custom)
            }
            fn visit_map<A: MapAccess<'de>>(self, access: A) -> Result<TimeCurve, A::Error> {
                let NamedCurve { hand } = NamedCurve::deserialize(MapAccessDeserializer::new(access))?;
                hand.curve().map(TimeCurve).map_err(A::Error::custom)
            }
        }
        deserializer.deserialize_any(Read)
    }
}

impl TimeCurve {
    /// The curve through a list of points.
    pub(super) fn through(numbers: &Numbers) -> Result<Self, String> {
        const SHAPE: &str = "not a curve; write one number or [[time, value], …]";
        let Numbers::List(list) = numbers else { return Err(SHAPE.into()) };
        let point = |row: &Numbers| match row.flat().as_deref() {
            Some(&[time, value]) => Ok((time, value)),
            _ => Err(SHAPE),
        };
        let points = list.iter().map(point).collect::<Result<Vec<_>, _>>()?;
        Curve::new(points).map(Self).map_err(|bad| format!("{bad}; write [[time, value], …] with ascending times"))
    }

    /// The value at a time \[ms\].
    pub(crate) fn at(&self, time: f64) -> f64 {
        self.0.at(time)
    }
}

/// A way through space: `[[time, [x, y, z]], …]` with ascending times \[ms\], straight between and at rest outside.
#[derive(Clone, Debug, PartialEq, serde::Deserialize)]
#[serde(try_from = "Numbers")]
pub struct TimePath(pub Path);

impl TryFrom<Numbers> for TimePath {
    type Error = String;
    fn try_from(numbers: Numbers) -> Result<Self, String> {
        const SHAPE: &str = "not a path; write [[time, [x, y, z]], …] with ascending times";
        let Numbers::List(list) = numbers else { return Err(SHAPE.into()) };
        let point = |row: Numbers| match row {
            Numbers::List(row) => match <[Numbers; 2]>::try_from(row) {
                Ok([Numbers::One(time), place]) => Ok((time, Point::try_from(place).map_err(|_| SHAPE)?.0)),
                _ => Err(SHAPE),
            },
            Numbers::One(_) => Err(SHAPE),
        };
        let points = list.into_iter().map(point).collect::<Result<Vec<_>, _>>()?;
        // Of the times a path asks what a curve does.
        Curve::new(points.iter().map(|&(time, place)| (time, place.element_sum())).collect())
            .map_err(|bad| format!("{bad}; write [[time, [x, y, z]], …] with ascending times"))?;
        Ok(Self(Path { points }))
    }
}

/// A strain in the fibre's axes: one number (the same in all directions), `[along, across]`, `[along, across, shear]` (tensor shear) or the
/// tensor, `[[along, shear], [shear, across]]`.
#[derive(Clone, Copy, Debug, PartialEq, serde::Deserialize)]
#[serde(try_from = "Numbers")]
pub struct Strain(pub Sym2);

impl Strain {
    /// The strain of two equal off-diagonals.
    fn tensor(numbers: &Numbers) -> Option<Self> {
        let Numbers::List(rows) = numbers else { return None };
        let [first, second] = rows.as_slice() else { return None };
        match (first.flat()?.as_slice(), second.flat()?.as_slice()) {
            (&[along, shear], &[other, across]) if shear == other => Some(Self(Sym2::new(along, across, shear))),
            _ => None,
        }
    }
}

impl TryFrom<Numbers> for Strain {
    type Error = &'static str;
    fn try_from(numbers: Numbers) -> Result<Self, Self::Error> {
        match (numbers.one(), numbers.flat().as_deref()) {
            (Some(e), _) => Ok(Self(Sym2::new(e, e, 0.0))),
            (_, Some(&[along, across])) => Ok(Self(Sym2::new(along, across, 0.0))),
            (_, Some(&[along, across, shear])) => Ok(Self(Sym2::new(along, across, shear))),
            _ => Self::tensor(&numbers)
                .ok_or("not a strain; write one number, [along, across], [along, across, shear] or a symmetric tensor"),
        }
    }
}
