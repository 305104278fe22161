//! What a step computes and the next one overwrites. All *derived*: sized to the tables at the start of a step, never saved.

use super::{FreeAxes, GuardFigures};
use crate::event::GuardPlace;
use crate::math::{CoupledStiffness, ElementState, FlatState, GeometricStiffness, Orthotropic, Sym2, Sym3};
use crate::storage::room::grow;
use crate::storage::{Edit, EditRecord, Triangles};
use glam::DVec3;

/// Rotation, stretch and stress of every triangle, and its geometric stiffness.
#[derive(Clone, Debug, Default)]
pub struct Frames {
    /// State at the positions of the last evaluation, but for planar bodies.
    pub solid: Vec<ElementState>,
    /// That of planar bodies.
    pub flat: Vec<FlatState>,
    /// Geometric stiffness there, but for planar bodies.
    pub geometric: Vec<GeometricStiffness>,
    /// That of planar bodies, which have none out of the plane \[MPa\].
    pub in_plane: Vec<f64>,
    /// Stiffness \[MPa\] there of a body with a [`FibreLaw`](crate::math::FibreLaw); empty without one.
    pub stiffened: Vec<CoupledStiffness>,
}

impl Frames {
    /// Makes the lists fit for so many triangles, of a planar body or not. Those that have to grow grow as far as there is `room` in the
    /// table of triangles.
    pub(crate) fn resize(&mut self, count: usize, room: usize, is_planar: bool) {
        let [solid, flat] = if is_planar { [0, count] } else { [count, 0] };
        size(&mut self.solid, (solid, room), ElementState::REST);
        size(&mut self.geometric, (solid, room), GeometricStiffness::default());
        size(&mut self.flat, (flat, room), ElementState::REST.into());
        size(&mut self.in_plane, (flat, room), 0.0);
    }

    /// Whether it was evaluated in a plane: no axis of a triangle has a part along z, and nothing is stiff along it.
    #[inline]
    pub fn is_planar(&self) -> bool {
        !self.flat.is_empty()
    }

    /// Number of triangles that have been evaluated.
    pub fn len(&self) -> usize {
        self.solid.len().max(self.flat.len())
    }

    /// Whether none has been.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// The state of a triangle.
    #[inline(always)]
    pub fn state(&self, t: usize) -> ElementState {
        match self.solid.get(t) {
            Some(state) => *state,
            None => self.flat[t].into(),
        }
    }

    /// The state of one triangle after the other.
    pub fn states(&self) -> impl ExactSizeIterator<Item = ElementState> + '_ {
        (0..self.len()).map(|t| self.state(t))
    }

    /// The geometric stiffness of a triangle.
    #[inline(always)]
    pub fn geometric_stiffness(&self, t: usize) -> GeometricStiffness {
        match self.geometric.get(t) {
            Some(geometric) => *geometric,
            None => GeometricStiffness { normal: Sym2::ZERO, in_plane: self.in_plane[t] },
        }
    }

    /// The stiffness \[MPa\] of a triangle at its state: that of the material, but for what stiffens.
    #[inline(always)]
    pub fn stiffness<'a>(&'a self, triangles: &'a Triangles, t: usize) -> &'a Orthotropic {
        self.stiffened.get(t).map_or_else(|| &triangles.stiffness[t], |stiffened| &stiffened.law)
    }

    /// Q16 and Q26 \[MPa\] there, which couple strain along and across the fibre with shear.
    #[inline(always)]
    pub fn coupling(&self, t: usize) -> [f64; 2] {
        self.stiffened.get(t).map_or([0.0; 2], |stiffened| [stiffened.q16, stiffened.q26])
    }
}

fn size<T: Clone>(list: &mut Vec<T>, (count, room): (usize, usize), blank: T) {
    grow(list, count, room);
    list.resize(count, blank);
}

/// Nodal forces, and the buffer of corners from which they are summed.
#[derive(Clone, Debug, Default)]
pub struct Forces {
    /// Force per vertex \[N\].
    pub nodal: Vec<DVec3>,
    /// Scratch: what triangles contribute to their corners.
    pub corner: Vec<[DVec3; 3]>,
    /// Whether `scale` is asked for: where Newton's method iterates.
    pub has_scale: bool,
    /// The largest force of a triangle on one of its corners \[N\], of the membrane alone; zero where it is not asked for.
    pub scale: f64,
}

/// Stiffness of springs, grips, contact and drag: a symmetric block per vertex \[N/mm\]. Present only with one of them.
#[derive(Clone, Debug, Default)]
pub struct ExternalStiffness {
    /// −∂f/∂x per vertex.
    pub block: Vec<Sym3>,
}

/// Where the step started and how far it has come.
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
    /// Acceleration by the forces at the start of the step \[mm/ms²\], along free axes; of TR-BDF2 only, as the next two.
    pub start_acceleration: Vec<DVec3>,
    /// Displacement since the start where the first stage has ended \[mm\].
    pub middle_displacement: Vec<DVec3>,
    /// Velocity there \[mm/ms\].
    pub middle_velocity: Vec<DVec3>,
    /// How much the body resists strain; none after an edit.
    #[cfg_attr(feature = "snapshot", serde(skip))]
    pub tautness: Option<Tautness>,
    /// Whether only a part of the last solve's answer was gone.
    #[cfg_attr(feature = "snapshot", serde(skip))]
    pub is_fraction: bool,
    /// Whether vertices were put back outside an obstacle after the last solve.
    #[cfg_attr(feature = "snapshot", serde(skip))]
    pub is_put_outside: bool,
    /// Whether the one and the other have happened in any part of the step that was asked for.
    #[cfg_attr(feature = "snapshot", serde(skip))]
    pub limits: [bool; 2],
    /// What the guard against created energy did in the step that was asked for.
    #[cfg_attr(feature = "snapshot", serde(skip))]
    pub guard: Box<GuardFigures>,
    /// Where the last solve would have created energy.
    #[cfg_attr(feature = "snapshot", serde(skip))]
    pub creates_at: Option<GuardPlace>,
    /// The most vertices that have found their own way in a part of it.
    #[cfg_attr(feature = "snapshot", serde(skip))]
    pub relaxed: usize,
    /// The time step that `displacement` belongs to \[ms\].
    pub dt: f64,
}

/// A displacement of which only a part is gone along free axes.
pub(crate) fn fraction_of(delta: DVec3, free: DVec3, part: f64) -> DVec3 {
    delta * (DVec3::ONE - free * (1.0 - part))
}

/// How much a body resists strain.
#[derive(Clone, Copy, Debug)]
pub struct Tautness {
    /// What it stores at the strain from which on it counts as taut \[mJ\].
    pub slack: f64,
    /// The largest stiffness of a triangle against strain in any direction, over its thickness \[N/mm\].
    pub stiffest: f64,
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

    /// Leaves a part of the last solve's answer along free axes.
    pub(crate) fn take_fraction(&mut self, free: &FreeAxes, part: f64) {
        if part < 1.0 {
            self.delta.iter_mut().zip(free).for_each(|(delta, free)| *delta = fraction_of(*delta, *free, part));
        }
    }

    /// Forgets how far an attempt has come that is undone.
    pub(crate) fn forget_attempt(&mut self) {
        self.displacement.fill(DVec3::ZERO);
        self.delta.fill(DVec3::ZERO);
        let stages = [&mut self.start_acceleration, &mut self.middle_displacement, &mut self.middle_velocity];
        stages.into_iter().for_each(Vec::clear);
    }

    /// Follows an edit: new vertices start and move as the blend of their parents, a slid one as the point it slid to, and
    /// the one that a collapse removes is gone.
    pub fn follow(&mut self, record: &EditRecord) {
        self.tautness = None;
        let Self { start, start_velocity, displacement, middle_displacement, middle_velocity, .. } = self;
        for values in [start, start_velocity, displacement, middle_displacement, middle_velocity] {
            for (row, parents) in record.created() {
                if values.len() == row as usize {
                    let blended = parents.blend(|parent| values[parent as usize]);
                    values.push(blended);
                }
            }
            if let Edit::Slide { vertex, towards, weight } = record.edit
                && (vertex.max(towards) as usize) < values.len()
            {
                values[vertex as usize] = values[vertex as usize].lerp(values[towards as usize], weight);
            }
            if let Some(removed) = &record.removed
                && values.len() == record.first_vertex as usize
            {
                values.swap_remove(removed.vertex as usize);
            }
        }
    }
}

/// Forces \[N\] that the holds exert on their vertices, in the groups and order of [`Holds`](super::Holds).
#[derive(Clone, Debug, Default)]
#[cfg_attr(feature = "snapshot", derive(serde::Serialize, serde::Deserialize))]
pub struct Reactions {
    /// One force per held vertex, zero along free axes.
    pub groups: Vec<Vec<DVec3>>,
}
