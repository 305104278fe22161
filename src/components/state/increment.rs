//! Start and progress of a step, and its legacy to the next: the first guess and the forces of holds.

use crate::components::{FreeAxes, GuardFigures, LastStep};
use crate::event::GuardPlace;
use crate::storage::EditRecord;
use crate::storage::room::grow;
use glam::DVec3;

/// Where the step started and how far it has come. *State.*
#[derive(Clone, Debug, Default)]
#[cfg_attr(feature = "snapshot", derive(serde::Serialize, serde::Deserialize))]
pub struct Increment {
    /// Positions at the start of the step \[mm\].
    pub start: Vec<DVec3>,
    /// Velocities at the start of the step \[mm/ms\].
    pub start_velocity: Vec<DVec3>,
    /// Displacement since the start \[mm\]; kept afterwards as the next step's first guess.
    pub displacement: Vec<DVec3>,
    /// The linear solve's answer: the change of `displacement` \[mm\].
    pub delta: Vec<DVec3>,
    /// Acceleration by the forces at the start of the step \[mm/ms²\], along free axes (TR-BDF2).
    pub start_acceleration: Vec<DVec3>,
    /// Displacement at the end of the first stage, from the start of the step \[mm\] (TR-BDF2).
    pub middle_displacement: Vec<DVec3>,
    /// Velocity at the end of the first stage \[mm/ms\] (TR-BDF2).
    pub middle_velocity: Vec<DVec3>,
    /// Elastic energy \[mJ\] at the strain below which tissue counts as slack; `None` after an edit.
    #[cfg_attr(feature = "snapshot", serde(skip))]
    pub slack_energy: Option<f64>,
    /// Fraction of the answer of the last solve that is applied.
    #[cfg_attr(feature = "snapshot", serde(skip))]
    pub applied: f64,
    /// Fraction of the step's increment that is not applied: 1 at its start, 0 once a whole answer was.
    #[cfg_attr(feature = "snapshot", serde(skip))]
    pub unapplied: f64,
    /// Whether only a fraction of the increment of the last solve was applied.
    #[cfg_attr(feature = "snapshot", serde(skip))]
    pub is_fraction: bool,
    /// Whether vertices were put back outside an obstacle after the last solve.
    #[cfg_attr(feature = "snapshot", serde(skip))]
    pub has_projected_vertices: bool,
    /// Whether only a fraction of an increment was applied in any part of the step that was asked for.
    #[cfg_attr(feature = "snapshot", serde(skip))]
    pub any_substep_limited: bool,
    /// Whether vertices were put back outside an obstacle in any part of the step that was asked for.
    #[cfg_attr(feature = "snapshot", serde(skip))]
    pub any_vertex_projected: bool,
    /// Figures of the energy guard for the step that was asked for.
    #[cfg_attr(feature = "snapshot", serde(skip))]
    pub guard: Box<GuardFigures>,
    /// Where the last solve would have created energy.
    #[cfg_attr(feature = "snapshot", serde(skip))]
    pub creates_at: Box<Option<GuardPlace>>,
    /// Largest number of vertices relaxed locally in one sub-step.
    #[cfg_attr(feature = "snapshot", serde(skip))]
    pub relaxed: u32,
    /// Length of the step that `displacement` belongs to, and friction in it.
    pub last: LastStep,
}

impl Increment {
    /// Makes room for `more` vertices, whose table has `room`: lists that double take as much again in vain.
    pub fn make_room(&mut self, more: usize, room: usize) {
        let Self { start, start_velocity, displacement, delta, middle_displacement, middle_velocity, .. } = self;
        let lists = [start, start_velocity, displacement, delta, middle_displacement, middle_velocity];
        for values in lists.into_iter().filter(|values| !values.is_empty()) {
            grow(values, values.len() + more, room);
        }
    }

    /// Longest way \[mm\] of a vertex along prescribed axes in the last solve's answer.
    pub(crate) fn prescribed_way(&self, free: &FreeAxes) -> f64 {
        let ways = self.delta.iter().zip(free).map(|(delta, free)| (*delta * (DVec3::ONE - *free)).length());
        ways.fold(0.0, f64::max)
    }

    /// Scales the last solve's answer by `part`: prescribed axes go as far as free ones, and the rest of their way in later steps.
    pub(crate) fn take_fraction(&mut self, part: f64) {
        if part < 1.0 {
            self.applied = part;
            self.delta.iter_mut().for_each(|delta| *delta *= part);
        }
    }

    /// Clears the progress of an undone attempt.
    pub(crate) fn forget_attempt(&mut self) {
        self.displacement.fill(DVec3::ZERO);
        self.delta.fill(DVec3::ZERO);
        let stages = [&mut self.start_acceleration, &mut self.middle_displacement, &mut self.middle_velocity];
        stages.into_iter().for_each(Vec::clear);
        self.last.forget_attempt();
    }

    /// Follows an edit: new and moved vertices take the blend of their parents, and the one that a collapse removes is gone.
    pub fn follow(&mut self, record: &EditRecord) {
        self.slack_energy = None;
        self.last.follow(record);
        let Self { start, start_velocity, displacement, middle_displacement, middle_velocity, .. } = self;
        for values in [start, start_velocity, displacement, middle_displacement, middle_velocity] {
            for (row, parents) in record.created() {
                if values.len() == row as usize {
                    let blended = parents.blend(|parent| values[parent as usize]);
                    values.push(blended);
                }
            }
            if let Some((vertex, parents)) = record.moved()
                && parents.rows().iter().all(|&row| (row as usize) < values.len())
            {
                values[vertex as usize] = parents.blend(|row| values[row as usize]);
            }
            if let Some(removed) = &record.removed
                && values.len() == record.first_vertex as usize
            {
                values.swap_remove(removed.vertex as usize);
            }
        }
    }
}

/// Forces \[N\] that the holds exert on their vertices, in the groups and order of [`Holds`](crate::components::Holds). *State.*
#[derive(Clone, Debug, Default)]
#[cfg_attr(feature = "snapshot", derive(serde::Serialize, serde::Deserialize))]
pub struct Reactions {
    /// One force per held vertex, zero along free axes.
    pub groups: Vec<Vec<DVec3>>,
}
