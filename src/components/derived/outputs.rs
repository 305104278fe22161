//! Outputs of the last step, kept until the next one has left a sound state.

use crate::components::{Grips, Reactions, TearDecision, TearDecisions};
use crate::storage::Tips;
use glam::DVec3;

/// Reactions, forces of jaws and decisions at tips as they were at the start of a step. *Derived.*
#[derive(Clone, Debug, Default)]
pub struct Outputs {
    reactions: Vec<Vec<DVec3>>,
    /// Force and torque of every pinch.
    pinches: Vec<[DVec3; 2]>,
    criterion: Vec<f64>,
    decisions: Vec<Option<TearDecision>>,
}

/// The components from which they are read, where a body has them.
pub(crate) type OutputsMut<'a> =
    (Option<&'a mut Reactions>, Option<&'a mut Grips>, Option<(&'a mut Tips, &'a mut TearDecisions)>);

impl Outputs {
    /// Keeps the present outputs.
    pub fn keep(&mut self, (reactions, grips, tears): OutputsMut<'_>) {
        let Self { reactions: kept, pinches, criterion, decisions: before } = self;
        if let Some(Reactions { groups }) = reactions {
            kept.resize_with(groups.len(), Vec::new);
            kept.iter_mut().zip(groups).for_each(|(kept, forces)| kept.clone_from(forces));
        }
        pinches.clear();
        let of_jaws = grips.into_iter().flat_map(|grips| &grips.pinches);
        pinches.extend(of_jaws.map(|pinch| [pinch.force, pinch.torque]));
        if let Some((tips, decisions)) = tears {
            criterion.clone_from(&tips.criterion);
            // Before the first decisions there is room for them already: a later step allocates nothing.
            before.clear();
            before.reserve(tips.len());
            before.extend_from_slice(&decisions.tips);
        }
    }

    /// Puts back the kept outputs. Vertices and tips that a tear has made since have had no output: zero.
    pub fn put_back(&self, (reactions, grips, tears): OutputsMut<'_>) {
        if let Some(Reactions { groups }) = reactions {
            groups.truncate(self.reactions.len());
            for (forces, kept) in groups.iter_mut().zip(&self.reactions) {
                let count = forces.len();
                forces.clone_from(kept);
                forces.resize(count.max(kept.len()), DVec3::ZERO);
            }
        }
        for (k, pinch) in grips.into_iter().flat_map(|grips| &mut grips.pinches).enumerate() {
            [pinch.force, pinch.torque] = self.pinches.get(k).copied().unwrap_or_default();
            pinch.target = pinch.start.or(pinch.target);
        }
        if let Some((tips, decisions)) = tears {
            for (tip, value) in tips.criterion.iter_mut().enumerate() {
                *value = self.criterion.get(tip).copied().unwrap_or(0.0);
            }
            decisions.tips.clone_from(&self.decisions);
            decisions.nucleation = None;
            decisions.ligament_failure = None;
        }
    }
}
