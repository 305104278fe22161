//! Working memory of a body's solves.

use crate::components::{BodyGroup, Frames, FreeAxes, GuideConstraints, Increment, Layers, Outputs, OutputsMut, Stops};
use crate::math::Sym3;
use glam::{DVec2, DVec3};
use hecs::Entity;

/// Forces and energy by which a step of several Newton iterations or two stages is judged at its end; empty in others.
#[derive(Clone, Debug, Default)]
pub struct StepAccount {
    /// The body's own forces \[N\], of stress, damping and bending, at the last evaluation.
    pub own: Vec<DVec3>,
    /// Own forces \[N\] at the start of a two-stage step; the second stage adds those at the end of the first, less its imbalance.
    /// In a resumed pass, instead, the displacement \[mm\] at the start of that pass.
    pub earlier: Vec<DVec3>,
    /// Stored and kinetic energy \[mJ\] at the start of the step or resumed pass; `None` once the step is judged.
    pub energy: Option<f64>,
}

/// Memory of a solve whose exact tangent may be indefinite, for another one without it.
#[derive(Clone, Debug, Default)]
pub(crate) struct TangentFallback {
    /// Right-hand side \[N\] before the solve.
    pub rhs: Vec<DVec3>,
    /// First guess \[mm\].
    pub guess: Vec<DVec3>,
    /// Frames that those of the rotated tangent replace.
    pub spare: Frames,
}

/// Vertices of a body that are relaxed locally where the solve's answer would create energy.
#[derive(Clone, Debug, Default)]
pub(crate) struct LocalRelaxation {
    /// Rows of the relaxed vertices, in ascending order.
    pub rows: Vec<u32>,
    /// Whether each vertex of the body is one of the relaxed ones.
    pub is_in: Vec<bool>,
    /// The way of every vertex of the body \[mm\].
    pub way: Vec<DVec3>,
    /// Deviation of every vertex's way from the solve's \[mm\].
    pub off: Vec<DVec3>,
    /// Triangles that create energy, with that energy \[mJ\], in descending order.
    pub created: Vec<(f64, u32)>,
}

/// Vectors of the linear solve, one entry per vertex, and temporaries of a step. *Derived*: no step needs the values of another.
#[derive(Clone, Debug, Default)]
pub struct SolverScratch {
    /// 1 along free axes, 0 along prescribed ones.
    pub free: FreeAxes,
    /// Motions of guided vertices, which have no free axes for them.
    pub guide_constraints: GuideConstraints,
    /// Right-hand side b \[N\] before a solve, its residual b − A·δ after it.
    pub residual: Vec<DVec3>,
    /// Right-hand side \[N\] of a solve in double precision that may have to begin anew.
    pub rhs_backup: Vec<DVec3>,
    /// Search direction \[mm\]; after a solve in mixed precision its right-hand side \[N\].
    pub direction: Vec<DVec3>,
    /// Operator times direction \[N\], and in turn the preconditioned residual \[mm\].
    pub product: Vec<DVec3>,
    /// Inverse diagonal blocks \[mm/N\], symmetric: xx, yy, zz and yz, zx, xy; where nothing is free along z xx, yy, xy and nothing.
    pub inverse_block: [Vec<DVec3>; 2],
    /// Sums per chunk of rows.
    pub partials: Vec<f64>,
    /// Pairs of sums per chunk of rows.
    pub pairs: Vec<DVec2>,
    /// Forces and energy by which a step of several iterations is judged.
    pub account: Box<StepAccount>,
    /// Where solves have stopped because time was up.
    pub stops: Box<Stops>,
    /// Motion counts of the triangles that have to be put outside an obstacle.
    pub sweeps: Box<Sweeps>,
    /// Forces of obstacles on the body.
    pub(crate) contact: Box<ContactScratch>,
    /// Loads and rate of momentum of the last solve.
    pub(crate) momentum: Box<MomentumScratch>,
    /// Outputs of the last step, to be put back if this one is undone.
    pub outputs: Box<Outputs>,
    /// Twice the energy stored in the body \[mJ\], where the solve asks for it; else zero.
    pub twice_stored: f64,
    /// Energy \[mJ\] of the body's motion by an edge in one step, where the solve asks for the error of positions; else zero.
    pub motion_scale: f64,
    /// Squared energy norm \[mJ\] of the position error at which the solve may stop; zero where no position tolerance is asked for.
    pub near: f64,
    /// Squared norm \[N²\] of the largest right-hand side of the step's linear solves, which their residuals are measured by.
    pub reference_sq: f64,
    /// Whether `residual` has to be exact after the solve: an energy balance counts it.
    pub is_audited: bool,
    /// Smallest imbalance \[N\] at the evaluations of this solve before the last.
    pub least_imbalance: f64,
    /// Work \[mJ\] of the residual that the last solve has left, along its answer.
    pub residual_work: f64,
    /// Whether a solve of this step is in the [ledger](crate::components::GuardLedger) already.
    pub is_counted: bool,
    /// Limit \[mJ\] of the spurious energy of a step that gets a Newton correction; `None` otherwise.
    pub to_correct: Option<f64>,
    /// Memory of solves with exact tangents.
    pub(crate) fallback: Box<TangentFallback>,
    /// Memory of the energy guard; empty until it acts.
    pub(crate) relaxation: Box<LocalRelaxation>,
    /// The static increment that is being tried.
    pub line_search: Option<LineSearch>,
}

impl SolverScratch {
    /// Begins a step with the outputs of the last one.
    pub(crate) fn begin(&mut self, read: OutputsMut<'_>, is_retried: bool) {
        self.outputs.keep(read);
        self.contact.keep();
        if let Some(layers) = self.contact.layers.as_mut().filter(|_| !is_retried) {
            (layers.held_back, layers.moved_as_one) = (0, false);
        }
        self.momentum.before = self.momentum.balance;
        (self.is_counted, self.to_correct, self.line_search) = (false, None, None);
        self.reference_sq = 0.0;
        self.account.energy = None;
    }

    /// Whether the increment is the whole answer of the last solve, so that `residual` is its residual.
    pub(crate) fn has_whole_answer(&self, increment: &Increment) -> bool {
        let is_changed = increment.is_fraction || increment.applied < 1.0 || self.to_correct.is_some();
        !is_changed && self.guide_constraints.is_empty()
    }

    /// Forgets the results of an undone attempt.
    pub(crate) fn forget_attempt(&mut self) {
        self.contact.put_back();
        self.momentum.balance = self.momentum.before;
        (self.twice_stored, self.to_correct, self.line_search) = (0.0, None, None);
    }
}

/// Loads of a body and the rate of its momentum.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct MomentumBalance {
    /// Sum of gravity, pressure, loads, springs and drag \[N\].
    pub loads: DVec3,
    /// Rate of the momentum \[N\].
    pub rate: DVec3,
}

/// Balance of momentum of the last step; none before the first one of this process.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct MomentumScratch {
    /// The balance of the last solve.
    pub balance: Option<MomentumBalance>,
    /// The balance as it was at the start of the step.
    before: Option<MomentumBalance>,
}

/// Force and stiffness of an obstacle at a vertex.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Push {
    /// Force at the evaluation \[N\].
    pub force: DVec3,
    /// −∂f/∂x \[N/mm\].
    pub block: Sym3,
    /// Where the obstacle bears it \[mm\], and its normal there.
    pub point: DVec3,
    pub normal: DVec3,
}

/// Force of an obstacle at a vertex, on its way along the solve.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Touch {
    /// Place of the obstacle among the forces.
    pub place: u32,
    /// Row of the vertex.
    pub row: u32,
    /// Whether the vertex is in touch; else it is the corner of a triangle that is.
    pub is_at_vertex: bool,
    /// Force \[N\], at the evaluation and then in the solve's answer.
    pub force: DVec3,
    /// −∂f/∂x \[N/mm\].
    pub block: Sym3,
    /// Where the obstacle bears it \[mm\], and its normal there.
    pub point: DVec3,
    pub normal: DVec3,
}

/// Friction of an obstacle at a vertex, as evaluated.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct FrictionPoint {
    /// Place of the obstacle among the forces.
    pub place: u32,
    /// Row of the vertex.
    pub row: u32,
    /// Place of the vertex among those in touch.
    pub touch: u32,
    /// Normal of the contact.
    pub normal: DVec3,
    /// Stiffness of the contact, along the normal and across it \[N/mm\].
    pub stiffness: f64,
    /// Tangential way from the place where the vertex sticks, at the start of the step \[mm\].
    pub start: DVec3,
    /// Tangential way from there at the evaluation \[mm\].
    pub offset: DVec3,
    /// Whether the vertex slips in the evaluation.
    pub slips: bool,
    /// Stiffness of the spring across the normal, a secant where the vertex slips \[N/mm\].
    pub spring: f64,
    /// Whether the force along the slip is constant in the solve.
    pub is_constant: bool,
    /// Normal force in the answer of the solve \[N\].
    pub normal_force: f64,
}

/// Forces of obstacles on a body in its last solve, with the impulses of the corrections after it.
#[derive(Clone, Debug, Default)]
pub(crate) struct ContactScratch {
    /// Force of every obstacle \[N\], in the order of the evaluation.
    pub forces: Vec<(Entity, DVec3)>,
    /// Forces as they were at the start of the step.
    before: Vec<(Entity, DVec3)>,
    /// Whether `forces` belong to a step of this process; in a body just restored they do not.
    pub is_known: bool,
    was_known: bool,
    /// Forces at every vertex in touch.
    pub touched: Vec<Touch>,
    /// Friction at the vertices in touch, by obstacle and row.
    pub friction_points: Vec<FrictionPoint>,
    /// Friction at the evaluation before.
    pub friction_points_before: Vec<FrictionPoint>,
    /// Contact of the body with itself, where it has any.
    pub layers: Option<Box<Layers>>,
    /// Presence of other bodies that may touch it in this step.
    pub has_neighbours: bool,
    /// These bodies and it, where it is the first of them.
    pub group: Option<Box<BodyGroup>>,
    /// Relative residual of the next solve, where its answer is at hand: from one solve of bodies that touch.
    pub solved_together: Option<f64>,
}

impl ContactScratch {
    /// Begins an evaluation.
    pub(crate) fn begin(&mut self) {
        for point in &mut self.friction_points {
            point.normal_force = self.touched[point.touch as usize].force.dot(point.normal).max(0.0);
        }
        self.forces.clear();
        self.touched.clear();
        std::mem::swap(&mut self.friction_points, &mut self.friction_points_before);
        self.friction_points.clear();
        self.is_known = true;
    }

    /// Keeps the forces of the last step.
    fn keep(&mut self) {
        self.before.clone_from(&self.forces);
        self.was_known = self.is_known;
    }

    /// Puts the kept forces back.
    fn put_back(&mut self) {
        self.forces.clone_from(&self.before);
        self.is_known = self.was_known;
    }

    /// The force of an obstacle, to be added to.
    pub(crate) fn of(&mut self, obstacle: Entity) -> &mut DVec3 {
        let found = self.forces.iter().position(|(other, _)| *other == obstacle);
        let place = found.unwrap_or_else(|| {
            self.forces.push((obstacle, DVec3::ZERO));
            self.forces.len() - 1
        });
        &mut self.forces[place].1
    }
}

/// When corners have last moved and triangles last been looked at, counted in motions.
#[derive(Clone, Debug, Default)]
pub struct Sweeps {
    /// Motions so far.
    pub motions: u64,
    /// Motion in which each vertex last moved.
    pub moved: Vec<u64>,
    /// Motion in which each triangle was last looked at.
    pub looked_at: Vec<u64>,
}

/// Reference values for the line search of a static increment.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LineSearch {
    /// |increment · imbalance| before it \[mJ\].
    pub work: f64,
    /// Squared norm of the imbalance before it \[N²\].
    pub norm_sq: f64,
    /// Fraction of the increment that stands.
    pub fraction: f64,
}
