//! Record of a body's tears so far.

use crate::components::{DecidedBy, RingFault, TearDecision};
use crate::event::EventKind;

/// Totals since the body was spawned, and the events not yet collected. *State.*
#[derive(Clone, Debug, Default, PartialEq)]
#[cfg_attr(feature = "snapshot", derive(serde::Serialize, serde::Deserialize))]
pub struct TearLog {
    /// Total length torn or cut in the rest shape \[mm\].
    pub length: f64,
    /// Area torn by the criterion \[mm²\]: length times thickness of advances and starts, without cuts.
    pub area: f64,
    /// Surface energy that the toughness claims for that area \[mJ\]; `None` where none of it was torn under a toughness.
    pub surface_energy: Option<f64>,
    /// Tears that the criterion has started.
    pub nucleation_count: u32,
    /// Steps in which a start was refused for want of energy: its stress reached the strength, and opening it released too little.
    pub blocked_nucleation_count: u32,
    /// Advances of tips.
    pub advance_count: u32,
    /// Advances that took another way than the one wanted: by a snap, a part of the way or, in free mode, along an edge.
    pub detour_count: u32,
    /// Starts and advances whose margin to the runner-up was under 5 %.
    pub ambiguous_count: u32,
    /// Advances decided by the material force, on a body with an energy criterion.
    pub material_force_count: u32,
    /// Decisions at tips by the field of a plane crack, one per tip and step.
    pub energy_decision_count: u64,
    /// Decisions at tips by the material force, one per tip and step, by the reason in the order of [`RingFault::ALL`].
    pub force_decision_counts: [u64; RingFault::ALL.len()],
    /// Steps in which a tip that was to advance had to wait, because a tear is no faster than Rayleigh waves.
    pub held_back_count: u32,
    /// Largest criterion at a tip that had to wait.
    pub held_back_criterion: f64,
    /// Tips that ended at a boundary, or because a tear or cut went through them.
    pub end_count: u32,
    /// Live tips left at a notch where a tear had ended or tissue had parted.
    pub renewed_count: u32,
    /// Second tips sent the other way where two directions tied.
    pub branch_count: u32,
    /// Places where tissue parted without a tip: ligaments, and tissue beyond its ultimate stretch.
    pub parted_count: u32,
    /// Fragments that came free.
    pub fragment_count: u32,
    /// Advances that the mesh refused; a tip that stays refused counts once.
    pub refusal_count: u32,
    /// Parted vertices that a hold or a grip keeps shut.
    pub held_shut_count: u32,
    /// Smallest rest angle \[rad\] of the triangles whose shape tears have changed; `None` before the first.
    pub smallest_angle: Option<f64>,
    /// Smallest ratio of the averaging radius to the edge length around a tip; under 3 the mesh is too coarse for R.
    pub edges_per_radius: Option<f64>,
    /// Events in order, until the simulation collects them.
    pub pending: Vec<EventKind>,
}

impl TearLog {
    /// Counts the deciding criterion of each tip in a step, for a body with an energy criterion.
    pub(crate) fn note_decisions(&mut self, tips: &[Option<TearDecision>]) {
        for decision in tips.iter().flatten() {
            let count = match decision.by {
                DecidedBy::Energy => &mut self.energy_decision_count,
                DecidedBy::MaterialForce(fault) => &mut self.force_decision_counts[fault as usize],
                DecidedBy::Stress | DecidedBy::Blade | DecidedBy::Nucleation => continue,
            };
            *count = count.saturating_add(1);
        }
    }

    /// Counts an area \[mm²\] that the criterion has torn, with the toughness \[N/mm\] of a body that has one.
    pub(crate) fn note_area(&mut self, area: f64, toughness: Option<f64>) {
        self.area += area;
        if let Some(toughness) = toughness {
            *self.surface_energy.get_or_insert(0.0) += area * toughness;
        }
    }

    /// Keeps the smallest angle \[rad\]; π stands for no triangle at all.
    pub(crate) fn note_angle(&mut self, angle: f64) {
        if angle < std::f64::consts::PI {
            self.smallest_angle = Some(self.smallest_angle.map_or(angle, |least| least.min(angle)));
        }
    }
}
