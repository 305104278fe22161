//! A grip as bytes, where the turns of its hand stand beside the place of the grasp: older bytes are those of one without.

use super::grip::{Grip, NearTip, Path};
use crate::components::Jaws;
use glam::DVec3;
use serde::{Deserialize, Deserializer, Serialize, Serializer};

/// Form of bytes.
#[derive(Serialize, Deserialize)]
struct Bytes {
    name: String,
    from: f64,
    until: f64,
    material_point: DVec3,
    place: Place,
    jaws: Jaws,
    path: Path,
}

/// Place beside a tip and turns of the hand, where there are any. The first two are those of an option.
#[derive(Serialize, Deserialize)]
enum Place {
    Fixed,
    NearTip(NearTip),
    FixedTurning(Path),
    NearTipTurning(NearTip, Path),
}

/// Form of text.
#[derive(Serialize, Deserialize)]
struct Text {
    name: String,
    from: f64,
    until: f64,
    material_point: DVec3,
    near_tip: Option<NearTip>,
    jaws: Jaws,
    path: Path,
    #[serde(default)]
    turns: Path,
}

impl Serialize for Grip {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let Self { name, from, until, material_point, near_tip, jaws, path, turns } = self.clone();
        if serializer.is_human_readable() {
            return Text { name, from, until, material_point, near_tip, jaws, path, turns }.serialize(serializer);
        }
        let place = match (near_tip, turns.points.is_empty()) {
            (None, true) => Place::Fixed,
            (Some(near), true) => Place::NearTip(near),
            (None, false) => Place::FixedTurning(turns),
            (Some(near), false) => Place::NearTipTurning(near, turns),
        };
        Bytes { name, from, until, material_point, place, jaws, path }.serialize(serializer)
    }
}

impl<'de> Deserialize<'de> for Grip {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        if deserializer.is_human_readable() {
            let Text { name, from, until, material_point, near_tip, jaws, path, turns } =
                Text::deserialize(deserializer)?;
            return Ok(Self { name, from, until, material_point, near_tip, jaws, path, turns });
        }
        let Bytes { name, from, until, material_point, place, jaws, path } = Bytes::deserialize(deserializer)?;
        let (near_tip, turns) = match place {
            Place::Fixed => (None, Path::default()),
            Place::NearTip(near) => (Some(near), Path::default()),
            Place::FixedTurning(turns) => (None, turns),
            Place::NearTipTurning(near, turns) => (Some(near), turns),
        };
        Ok(Self { name, from, until, material_point, near_tip, jaws, path, turns })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Fields of a grip before its hand turned.
    #[derive(Serialize)]
    struct Old {
        name: String,
        from: f64,
        until: f64,
        material_point: DVec3,
        near_tip: Option<NearTip>,
        jaws: Jaws,
        path: Path,
    }

    #[test]
    fn older_bytes_are_those_of_a_grip_that_does_not_turn() {
        let near = NearTip { behind: 0.5, left: -0.25, axis: DVec3::Z, heading: DVec3::X };
        let path = Path { points: vec![(1.0, DVec3::X), (3.0, DVec3::Y)] };
        for near_tip in [None, Some(near)] {
            for turns in [Path::default(), path.clone()] {
                let grip = Grip {
                    name: "g".to_owned(),
                    from: 1.0,
                    until: 4.0,
                    material_point: DVec3::ONE,
                    near_tip,
                    jaws: Jaws { radius: 0.2, ..Jaws::default() },
                    path: path.clone(),
                    turns,
                };
                let bytes = postcard::to_allocvec(&grip).unwrap();
                assert_eq!(postcard::from_bytes::<Grip>(&bytes).unwrap(), grip);
                let text = serde_json::to_string(&grip).unwrap();
                assert_eq!(serde_json::from_str::<Grip>(&text).unwrap(), grip);
                let Grip { name, from, until, material_point, near_tip, jaws, path, turns } = grip;
                let old = Old { name, from, until, material_point, near_tip, jaws, path };
                assert_eq!(postcard::to_allocvec(&old).unwrap() == bytes, turns.points.is_empty());
            }
        }
    }
}
