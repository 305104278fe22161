//! A pinch as bytes. Up to version 17 there was no target: whether the tissue slides stood as 0 or 1, as it does without one.

use super::forceps::{JawsTarget, Motion, Pinch, Pose};
use crate::components::Jaws;
use crate::storage::{Attached, ForcepsId};
use glam::DVec3;
use serde::{Deserialize, Serialize};

/// The fields in the order of the bytes.
#[derive(Serialize, Deserialize)]
pub(super) struct Bytes {
    name: String,
    forceps: Option<ForcepsId>,
    jaws: Jaws,
    motion: Motion,
    origin: Pose,
    held: Attached<DVec3>,
    prescribed: Vec<DVec3>,
    force: DVec3,
    torque: DVec3,
    hold: Hold,
}

/// Whether the tissue slides, and the jaws' target where there is one.
#[derive(Serialize, Deserialize)]
enum Hold {
    Firm,
    Slipped,
    FirmAt(JawsTarget),
    SlippedAt(JawsTarget),
}

impl From<Pinch> for Bytes {
    fn from(pinch: Pinch) -> Self {
        let Pinch { name, forceps, jaws, motion, origin, held, prescribed, force, torque, has_slipped, target, .. } =
            pinch;
        let hold = match (has_slipped, target) {
            (false, None) => Hold::Firm,
            (true, None) => Hold::Slipped,
            (false, Some(target)) => Hold::FirmAt(target),
            (true, Some(target)) => Hold::SlippedAt(target),
        };
        Self { name, forceps, jaws, motion, origin, held, prescribed, force, torque, hold }
    }
}

impl From<Bytes> for Pinch {
    fn from(bytes: Bytes) -> Self {
        let Bytes { name, forceps, jaws, motion, origin, held, prescribed, force, torque, hold } = bytes;
        let (has_slipped, target) = match hold {
            Hold::Firm => (false, None),
            Hold::Slipped => (true, None),
            Hold::FirmAt(target) => (false, Some(target)),
            Hold::SlippedAt(target) => (true, Some(target)),
        };
        Self {
            name,
            forceps,
            jaws,
            motion,
            origin,
            held,
            prescribed,
            force,
            torque,
            has_slipped,
            target,
            ..Self::default()
        }
    }
}
