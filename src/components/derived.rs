//! What a step computes and the next one overwrites. All *derived*: sized to the tables at the start of a step, never saved.

use super::{Allowed, FreeAxes, Readings, Stops};
use crate::math::{CoupledStiffness, ElementState, FlatState, GeometricStiffness, Orthotropic, Sym2, Sym3};
use crate::report::{Fault, GuardFigures, GuardPlace};
use crate::settings::Tangent;
use crate::storage::room::grow;
use crate::storage::{Edit, EditRecord, Triangles};
use glam::{DVec2, DVec3};

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
    pub is_part: bool,
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
pub(crate) fn partly(delta: DVec3, free: DVec3, part: f64) -> DVec3 {
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
    pub(crate) fn go_part(&mut self, free: &FreeAxes, part: f64) {
        if part < 1.0 {
            self.delta.iter_mut().zip(free).for_each(|(delta, free)| *delta = partly(*delta, *free, part));
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

/// What a step of several Newton iterations or of two stages is judged by at its end; empty in others.
#[derive(Clone, Debug, Default)]
pub struct StepAccount {
    /// The body's own forces \[N\], of stress, damping and bending, at the last evaluation.
    pub own: Vec<DVec3>,
    /// Those at the start of a step of two stages and, in its second, with those at the end of the first, less the imbalance there
    /// along free axes. In a step taken up again the displacement \[mm\] from where it is.
    pub earlier: Vec<DVec3>,
    /// Energy stored and of motion \[mJ\] at the start, or where the step is taken up again, until that is judged.
    pub energy: Option<f64>,
}

/// Vectors of the linear solve, one entry per vertex, and what it reached.
#[derive(Clone, Debug, Default)]
#[cfg_attr(feature = "snapshot", derive(serde::Serialize, serde::Deserialize))]
pub struct SolverScratch {
    /// 1 along free axes, 0 along prescribed ones.
    #[cfg_attr(feature = "snapshot", serde(skip))]
    pub free: FreeAxes,
    /// Motions of guided vertices, which have no free axes for them.
    #[cfg_attr(feature = "snapshot", serde(skip))]
    pub allowed: Box<Allowed>,
    /// Residual \[N\].
    #[cfg_attr(feature = "snapshot", serde(skip))]
    pub residual: Vec<DVec3>,
    /// Right-hand side \[N\] of a solve in double precision that may have to begin anew.
    #[cfg_attr(feature = "snapshot", serde(skip))]
    pub rhs: Vec<DVec3>,
    /// Search direction \[mm\].
    #[cfg_attr(feature = "snapshot", serde(skip))]
    pub direction: Vec<DVec3>,
    /// Operator times direction \[N\], and in turn the preconditioned residual \[mm\].
    #[cfg_attr(feature = "snapshot", serde(skip))]
    pub product: Vec<DVec3>,
    /// Inverse diagonal blocks \[mm/N\], symmetric: xx, yy, zz and yz, zx, xy; where nothing is free along z xx, yy, xy and nothing.
    #[cfg_attr(feature = "snapshot", serde(skip))]
    pub inverse_block: [Vec<DVec3>; 2],
    /// Sums per chunk of rows.
    #[cfg_attr(feature = "snapshot", serde(skip))]
    pub partials: Vec<f64>,
    /// Pairs of sums per chunk of rows.
    #[cfg_attr(feature = "snapshot", serde(skip))]
    pub pairs: Vec<DVec2>,
    /// What a step of several iterations is judged by.
    #[cfg_attr(feature = "snapshot", serde(skip))]
    pub account: Box<StepAccount>,
    /// Where solves have stopped because time was up.
    #[cfg_attr(feature = "snapshot", serde(skip))]
    pub stops: Stops,
    /// Of the triangles that have to be put outside an obstacle.
    #[cfg_attr(feature = "snapshot", serde(skip))]
    pub sweeps: Box<Sweeps>,
    /// Twice the energy stored in the body \[mJ\], where the solve asks for it; else zero.
    pub stored: f64,
    /// Whether `residual` has to be exact after the solve: an energy balance counts it.
    pub is_audited: bool,
    /// Linear iterations in this step.
    pub iterations: u32,
    /// Newton iterations in this step, or in its last stage.
    pub newton_iterations: u32,
    /// Relative residual of the last linear solve.
    pub linear_residual: f64,
    /// Estimated error of the stress after it, relative to the stress in the body; zero where it was not asked for.
    pub stress_error: f64,
    /// Whether a linear solve of this step stopped because time was up.
    pub is_late: bool,
    /// Largest free nodal imbalance at the last evaluation \[N\].
    pub imbalance: f64,
    /// The smallest of those at the evaluations before it in this solve \[N\].
    #[cfg_attr(feature = "snapshot", serde(skip))]
    pub least_imbalance: f64,
    /// Whether this body needs no further iteration in this step.
    pub is_converged: bool,
    /// Whether the exact tangent was indefinite and the rotated one took its place.
    pub fell_back: bool,
    /// The tangent that the last linear solve used.
    pub tangent: Tangent,
    /// Energy \[mJ\] that steps along the tangent have created so far and not taken away again; never negative.
    pub left_over: f64,
    /// No less \[mJ\] than what they have created beside since it was last looked at.
    pub unseen: f64,
    /// `left_over` and `unseen` at the start of the step.
    pub start_left_over: [f64; 2],
    /// What can be read of the last step, to be put back if this one is undone.
    #[cfg_attr(feature = "snapshot", serde(skip))]
    pub readings: Readings,
    /// The work \[mJ\] of the residual that the last solve has left, along its answer.
    #[cfg_attr(feature = "snapshot", serde(skip))]
    pub residual_work: f64,
    /// Whether a solve of this step is in `left_over` already.
    #[cfg_attr(feature = "snapshot", serde(skip))]
    pub is_counted: bool,
    /// Why the last step of the body was given up.
    #[cfg_attr(feature = "snapshot", serde(skip))]
    pub fault: Option<Fault>,
    /// Whether the last solve would create more of it than is bearable.
    pub creates_energy: bool,
    /// The energy \[mJ\] that may come from nowhere in this step, where a solve has created more and the next one is to correct it.
    #[cfg_attr(feature = "snapshot", serde(skip))]
    pub to_correct: Option<f64>,
    /// Whether the body went only a part of its way in this step, lest that happen.
    pub is_held_back: bool,
    /// How many times the body's next last resort is made shorter: once more each time that it is held back again.
    pub shortenings: u32,
    /// Whole steps in which vertices may still [find their own way](crate::report::GuardFigures::relaxed) at once, after one in which some had to.
    pub relaxing: u32,
    /// Work that this step has taken, retries and resumes included, in iterations of linear solves.
    #[cfg_attr(feature = "snapshot", serde(skip))]
    pub work: u32,
    /// Energy \[mJ\] of the body's motion by an edge in one step, where the solve asks for the error of positions; else zero.
    #[cfg_attr(feature = "snapshot", serde(skip))]
    pub motion_scale: f64,
    /// Estimated error of positions after the last linear solve, over the mean edge; zero where it was not asked for.
    pub position_error: f64,
    /// The static increment that is being tried.
    pub line_search: Option<LineSearch>,
}

impl SolverScratch {
    /// What it tells of the last step, without the vectors, which the next one overwrites.
    pub(crate) fn without_vectors(&self) -> Self {
        let empty = Self::default();
        let Self { free, residual, rhs, direction, product, inverse_block, partials, pairs, account, stops, .. } =
            empty;
        let Self {
            sweeps,
            readings,
            residual_work,
            is_counted,
            fault,
            to_correct,
            work,
            motion_scale,
            least_imbalance,
            allowed,
            ..
        } = empty;
        let Self { stored, is_audited, iterations, newton_iterations, linear_residual, stress_error, .. } = *self;
        let Self { is_late, imbalance, is_converged, fell_back, tangent, line_search, .. } = *self;
        let Self { left_over, unseen, start_left_over, creates_energy, is_held_back, shortenings, .. } = *self;
        let Self { relaxing, position_error, .. } = *self;
        Self {
            free,
            residual,
            rhs,
            direction,
            product,
            inverse_block,
            partials,
            pairs,
            account,
            stops,
            sweeps,
            stored,
            is_audited,
            iterations,
            newton_iterations,
            linear_residual,
            stress_error,
            is_late,
            imbalance,
            is_converged,
            fell_back,
            tangent,
            left_over,
            unseen,
            start_left_over,
            readings,
            residual_work,
            is_counted,
            fault,
            creates_energy,
            to_correct,
            is_held_back,
            shortenings,
            relaxing,
            work,
            motion_scale,
            least_imbalance,
            allowed,
            position_error,
            line_search,
        }
    }

    /// Forgets what an attempt that is undone has come to.
    pub(crate) fn forget_attempt(&mut self) {
        (self.linear_residual, self.stored, self.stress_error, self.imbalance) = (0.0, 0.0, 0.0, 0.0);
        (self.creates_energy, self.to_correct, self.line_search) = (false, None, None);
        [self.left_over, self.unseen] = self.start_left_over;
    }

    /// How many of a body's rows are to be worked on in this iteration: all of them, or none.
    pub fn rows_to_solve(&self, rows: usize) -> usize {
        if self.is_converged { 0 } else { rows }
    }
}

/// When corners have last moved and triangles last been looked at, counted in motions.
#[derive(Clone, Debug, Default)]
pub struct Sweeps {
    /// Motions so far.
    pub motions: u64,
    /// Of every vertex.
    pub moved: Vec<u64>,
    /// Of every triangle.
    pub looked_at: Vec<u64>,
}

/// What a static increment is compared with.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "snapshot", derive(serde::Serialize, serde::Deserialize))]
pub struct LineSearch {
    /// |increment · imbalance| before it \[mJ\].
    pub work: f64,
    /// Squared norm of the imbalance before it \[N²\].
    pub norm_sq: f64,
    /// Fraction of the increment that stands.
    pub fraction: f64,
}
