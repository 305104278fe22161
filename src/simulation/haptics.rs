//! The tissue at a tool as a linear spring, for a haptic loop that runs faster than the steps.
//!
//! K_g are the tool's springs between its points and the vertices it holds, and A is the rest of the body's tangent at its present
//! state. The vertices answer a small motion d of the tool by u with (A + K_g)·u = K_g·E·d, where E gives every vertex the motion
//! of the tool. The force then changes by S·d with S = Eᵀ·K_g·(E − U), the Schur complement: U has the answers to the three unit
//! motions. The computed quantity is the energy (E − U)ᵀ·K_g·(E − U) + Uᵀ·A·U, equal to S for the exact U. It is symmetric and positive
//! semidefinite for any U, and too stiff by the square of the error of U alone. So a loose solve is enough, and no loop gains
//! energy from it. A tool with pins has no springs: U is E at its vertices, and S = Uᵀ·A·U.
//!
//! External stiffness, with the drag of the fluid, counts as the last step evaluated it.

use super::haptic_feed::HapticModel;
use super::{Pin, PinError, Simulation};
use crate::components::{
    Bending, Damping, ExternalStiffness, FibreLaws, Forceps, Frames, Grips, Holds, Planar, PreStretch, Reactions,
    SolverScratch, fibre_law,
};
use crate::math::Sym3;
use crate::registry::Rejected;
use crate::settings::{LinearParams, Tangent};
use crate::storage::{BodyId, ForcepsId, Topology, Triangles, VertexKey, Vertices};
use crate::systems::StepContext;
use crate::systems::bending::{BendingPasses, DihedralAngles};
use crate::systems::forces::corotation::{evaluate, geometric_stiffness};
use crate::systems::solver::{
    self, Available, Factor, FactorUse, MixedPreconditioner, MixedSolver, Operator, ProductMemory,
};
use glam::{DMat3, DVec3};

/// Limits of the three solves: the force is then right to the square of this.
const LIMITS: LinearParams = LinearParams::by_residual(1e-3, 500);

/// A spring between a tool and a vertex.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ToolSpring {
    /// The vertex.
    pub vertex: VertexKey,
    /// The tool's point that it is drawn to \[mm\].
    pub point: DVec3,
    /// Stiffness \[N/mm\], > 0.
    pub stiffness: f64,
}

/// How a tool has hold of a body.
#[derive(Clone, Debug, PartialEq)]
pub enum Coupling {
    /// By springs, as forceps do.
    Springs {
        /// The springs.
        springs: Vec<ToolSpring>,
        /// Whether a component of the body, such as [`Grips`], exerts them in the steps.
        is_in_steps: bool,
    },
    /// By pins: the vertices go where the tool goes.
    Pins {
        /// The pins.
        pins: Vec<Pin>,
        /// Force of the tool on the tissue \[N\]: their reaction.
        force: DVec3,
    },
}

/// Why there is no linear model; the last one may still serve.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum HapticError {
    /// There is no such body.
    #[error("there is no such body")]
    NoSuchBody,
    /// The body has no grip of this number, or it is not closed.
    #[error("grip {0} does not exist or is not closed")]
    NotClosed(usize),
    /// A tool without springs or pins.
    #[error("the tool has neither springs nor pins: it holds nothing")]
    HoldsNothing,
    /// A vertex that is no more.
    #[error("the body has no vertex {0:?}: it was removed, or belongs to another body")]
    NoSuchVertex(VertexKey),
    /// A point or stiffness that is none.
    #[error("the spring at vertex {0:?} needs finite points and forces and a positive finite stiffness")]
    BadSpring(VertexKey),
    /// No pins of this name.
    #[error(transparent)]
    Pins(#[from] PinError),
    /// The answer is not finite.
    #[error("the tissue gives no finite answer: {0}")]
    NoAnswer(String),
    /// Something that was written past the calls is refused.
    #[error(transparent)]
    Written(#[from] Rejected),
}

/// Makes linear models of one tool on one body; keeps data that the next model can use, and its memory.
#[derive(Debug, Default)]
pub struct Haptics {
    horizon: f64,
    factor: Factor,
    mixed: MixedSolver,
    frames: Frames,
    folds: DihedralAngles,
    passes: BendingPasses,
    external: ExternalStiffness,
    pub(super) scratch: SolverScratch,
    corner: Vec<[DVec3; 3]>,
    /// The answers to the three unit motions of the tool, and the forces they need.
    pub(super) answers: [Vec<DVec3>; 3],
    pub(super) forces: [Vec<DVec3>; 3],
    /// Row and stiffness of every spring.
    pub(super) springs: Vec<(usize, f64)>,
    /// Rows of the pins.
    pinned: Vec<usize>,
    /// The stiffness of the last model, its body, the vertices of its answers, and those that its springs held.
    pub(super) last: Option<DMat3>,
    pub(super) body: Option<BodyId>,
    pub(super) keys: Vec<VertexKey>,
    pub(super) held: Vec<VertexKey>,
    /// The answer that is improved next.
    pub(super) turn: usize,
    pub(super) work: u32,
}

impl Haptics {
    /// Models that hold for motions of the tool slower than `horizon` \[ms\]: the tissue's masses and damping resist motions that are
    /// faster. With 1000 and more it is the answer in equilibrium; with the length of a step that which the step will give. A value that is
    /// not a positive number is taken for 1000, and longer ones too: tissue that hangs loose has no equilibrium.
    pub fn new(horizon: f64) -> Self {
        let horizon = if horizon > 0.0 { horizon.min(1000.0) } else { 1000.0 };
        Self { horizon, ..Self::default() }
    }

    /// The linear model of a tool at a body's present state: three linear solves with one matrix.
    ///
    /// # Errors
    /// For a tool that holds nothing, a spring that is none, and where the tissue's answer is not finite.
    pub fn model(
        &mut self,
        simulation: &Simulation,
        body: BodyId,
        coupling: &Coupling,
    ) -> Result<HapticModel, HapticError> {
        type Query<'a> = (
            (&'a Vertices, &'a Triangles, &'a Topology),
            (Option<&'a ExternalStiffness>, Option<&'a Holds>, Option<&'a Planar>),
            (Option<&'a PreStretch>, FibreLaws<'a>, Option<&'a Damping>, Option<&'a Bending>),
        );
        simulation.validate_if_dirty(body)?;
        // Until this one is found there is none to refresh.
        (self.last, self.body) = (None, None);
        let mut query = simulation.world.query_one::<Query>(body.entity());
        let found = query.get().map_err(|_| HapticError::NoSuchBody)?;
        let ((vertices, triangles, topology), (external, holds, planar), (pre_stretch, fibres, damping, bending)) =
            found;
        let (position, force) = match coupling {
            Coupling::Springs { springs, .. } => self.take_springs(vertices, springs)?,
            Coupling::Pins { pins, force } => (self.take_pins(vertices, pins, *force)?, *force),
        };
        self.mark_free(vertices, holds, planar.is_some());
        let is_in_steps = matches!(coupling, Coupling::Springs { is_in_steps: true, .. });
        self.add_stiffness(vertices.len(), external, is_in_steps);
        let Self {
            horizon,
            factor,
            mixed,
            frames,
            folds,
            passes,
            external,
            scratch,
            corner,
            answers,
            forces,
            springs,
            ..
        } = self;
        let (pinned, work) = (&self.pinned, &mut self.work);
        *work = 0;
        let rate = 1.0 / *horizon;
        let viscosity = damping.map_or(0.0, |d| d.time) * rate;
        let solved = simulation.pool.run(|| {
            let fibres = fibre_law(fibres, pre_stretch);
            evaluate(vertices, triangles, frames, planar.is_some(), pre_stretch, fibres.as_ref());
            let tangent = Tangent::Projected;
            geometric_stiffness(frames, triangles, tangent, StepContext::RESERVE_OF_EULER);
            // The body's own angles are those of its last step, on the mesh that it had then; before the first there are none.
            if let Some(bending) = bending {
                folds.refresh((vertices, triangles, topology), bending, passes);
                folds.evaluate(&triangles.corners, &vertices.position, 1.0 + viscosity, passes);
                folds.leave_out_taut(triangles, frames);
            }
            let operator = Operator {
                external: Some(external),
                folds: bending.is_some().then_some(&*folds),
                inertia: rate * rate,
                viscosity,
                ..Operator::membrane((vertices, triangles, topology, frames), tangent)
            };
            mixed.share(true);
            let memory = &mut ProductMemory { corner, passes };
            for (axis, (u, force)) in answers.iter_mut().zip(forces.iter_mut()).enumerate() {
                // The last answer is the first guess, where there is one for these vertices.
                u.resize(vertices.len(), DVec3::ZERO);
                u.iter_mut()
                    .zip(&scratch.free)
                    .for_each(|(u, free)| *u = if u.is_finite() { *u * *free } else { DVec3::ZERO });
                pinned.iter().for_each(|&v| u[v] = DVec3::AXES[axis]);
                scratch.reference_sq = 0.0;
                scratch.residual.clear();
                scratch.residual.resize(vertices.len(), DVec3::ZERO);
                springs.iter().for_each(|&(v, stiffness)| scratch.residual[v][axis] += stiffness);
                let mut available = Available {
                    factor: Some((factor, FactorUse::Fallback)),
                    mixed: Some((mixed, MixedPreconditioner::IncompleteCholesky)),
                    left: None,
                };
                *work += 1 + solver::solve(&operator, &LIMITS, &mut available, memory, u, scratch)?.iterations;
                force.resize(vertices.len(), DVec3::ZERO);
                operator.apply(u, &scratch.free, memory, force, &mut scratch.partials);
            }
            Ok::<(), solver::CgError>(())
        });
        self.mixed.share(false);
        solved.map_err(|error| HapticError::NoAnswer(error.to_string()))?;
        let stiffness = self.energy();
        if !(stiffness.is_finite() && force.is_finite()) {
            return Err(HapticError::NoAnswer("a value that is not finite".to_owned()));
        }
        self.note(body, vertices.keys(), coupling, stiffness);
        Ok(HapticModel { time: simulation.report.time, position, force, stiffness })
    }

    /// Notes the springs, and gives the tool's point, the mean of its springs', and its force on the tissue \[N\].
    pub(super) fn take_springs(
        &mut self,
        vertices: &Vertices,
        springs: &[ToolSpring],
    ) -> Result<(DVec3, DVec3), HapticError> {
        self.springs.clear();
        self.pinned.clear();
        let (mut position, mut force, mut total) = (DVec3::ZERO, DVec3::ZERO, 0.0);
        for &ToolSpring { vertex, point, stiffness } in springs {
            let v = vertices.row(vertex).ok_or(HapticError::NoSuchVertex(vertex))? as usize;
            if !(stiffness > 0.0 && stiffness.is_finite() && point.is_finite()) {
                return Err(HapticError::BadSpring(vertex));
            }
            position += point * stiffness;
            force += (point - vertices.position[v]) * stiffness;
            total += stiffness;
            self.springs.push((v, stiffness));
        }
        if self.springs.is_empty() { Err(HapticError::HoldsNothing) } else { Ok((position / total, force)) }
    }

    /// Notes the pins, and gives their mean place.
    fn take_pins(&mut self, vertices: &Vertices, pins: &[Pin], force: DVec3) -> Result<DVec3, HapticError> {
        self.springs.clear();
        self.pinned.clear();
        let mut sum = DVec3::ZERO;
        for &Pin { vertex, place, .. } in pins {
            self.pinned.push(vertices.row(vertex).ok_or(HapticError::NoSuchVertex(vertex))? as usize);
            if !(place.is_finite() && force.is_finite()) {
                return Err(HapticError::BadSpring(vertex));
            }
            sum += place;
        }
        if pins.is_empty() { Err(HapticError::HoldsNothing) } else { Ok(sum / pins.len() as f64) }
    }

    fn mark_free(&mut self, vertices: &Vertices, holds: Option<&Holds>, is_planar: bool) {
        let free = &mut self.scratch.free;
        let axes = if is_planar { DVec3::new(1.0, 1.0, 0.0) } else { DVec3::ONE };
        free.reset(vertices.len(), vertices.position.capacity(), axes);
        for hold in holds.into_iter().flat_map(|holds| &holds.groups) {
            for (&row, axis) in hold.members.rows().iter().flat_map(|row| (0..3).map(move |axis| (row, axis))) {
                if hold.axes[axis] {
                    free.prescribe(row as usize, axis);
                }
            }
        }
        self.pinned.iter().for_each(|&v| free.set(v, DVec3::ZERO));
    }

    /// Stiffness of the other loads on the body, as the last step evaluated it, and the tool's springs.
    fn add_stiffness(&mut self, count: usize, external: Option<&ExternalStiffness>, is_in_steps: bool) {
        let block = &mut self.external.block;
        block.clear();
        block.extend(external.into_iter().flat_map(|external| &external.block));
        // Vertices that the step has made at its end were not evaluated.
        block.resize(count, Sym3::ZERO);
        for &(v, stiffness) in &self.springs {
            let spring = Sym3::isotropic(stiffness);
            // At least the spring itself, should its share have changed since.
            let others = if is_in_steps { block[v] - spring } else { block[v] };
            let least = others.diagonal.min_element();
            block[v] = if is_in_steps && !(least >= 0.0) { spring } else { others + spring };
        }
    }

    /// (E − U)ᵀ·K_g·(E − U) + Uᵀ·A·U \[N/mm\]: with K = A + K_g, Eᵀ·K_g·E − Uᵀ·K_g·E − Eᵀ·K_g·U + Uᵀ·K·U. Pins have no
    /// springs, and U is E there.
    fn energy(&self) -> DMat3 {
        let mut stiffness = [[0.0; 3]; 3];
        for (i, j) in [(0, 0), (0, 1), (0, 2), (1, 1), (1, 2), (2, 2)] {
            let (u, w) = (&self.answers[i], &self.answers[j]);
            let inside: f64 = u.iter().zip(&self.forces[j]).map(|(u, force)| u.dot(*force)).sum();
            let springs = self.springs.iter().map(|&(v, k)| k * (f64::from(u8::from(i == j)) - u[v][j] - w[v][i]));
            stiffness[i][j] = inside + springs.sum::<f64>();
            stiffness[j][i] = stiffness[i][j];
        }
        positive(DMat3::from_cols_array_2d(&stiffness))
    }
}

/// The matrix, raised by as much as rounding may have left it below zero.
pub(super) fn positive(matrix: DMat3) -> DMat3 {
    let size = matrix.x_axis.x.abs() + matrix.y_axis.y.abs() + matrix.z_axis.z.abs();
    let minor = matrix.x_axis.x * matrix.y_axis.y - matrix.x_axis.y * matrix.y_axis.x;
    if matrix.x_axis.x > 0.0 && minor > 0.0 && matrix.determinant() > 0.0 {
        return matrix;
    }
    matrix + DMat3::from_diagonal(DVec3::splat(1e-9 * size))
}

impl Simulation {
    /// How a closed grip of a body's [`Grips`] has hold of it now, those of forceps after those of scripts, for [`Haptics::model`].
    ///
    /// # Errors
    /// If there is no such body, or no such grip that is closed.
    pub fn coupling_of_grip(&self, body: BodyId, grip: usize) -> Result<Coupling, HapticError> {
        let mut query = self.world.query_one::<(&Vertices, &Triangles, &Topology, Option<&Grips>)>(body.entity());
        let (vertices, triangles, topology, grips) = query.get().map_err(|_| HapticError::NoSuchBody)?;
        let closed = grips.and_then(|grips| grips.pinches.get(grip)).filter(|pinch| pinch.is_closed());
        let pinch = closed.ok_or(HapticError::NotClosed(grip))?;
        let targets = pinch
            .targets(pinch.pose(self.report.time))
            .filter_map(|(row, point)| Some((row, vertices.key(row)?, point)));
        let Some(stiffness) = pinch.jaws.stiffness else {
            let rest = |row: u32| vertices.rest_position[row as usize];
            let pins = targets.map(|(row, vertex, place)| Pin { vertex, rest_position: rest(row), place }).collect();
            return Ok(Coupling::Pins { pins, force: pinch.force });
        };
        let there = pinch.held.rows().iter().filter(|&&row| vertices.key(row).is_some());
        let total: f64 = there.map(|&row| topology.vertex_area(triangles, row)).sum();
        let spring = |(row, vertex, point)| {
            let stiffness = stiffness * (topology.vertex_area(triangles, row) / total);
            ToolSpring { vertex, point, stiffness }
        };
        Ok(Coupling::Springs { springs: targets.map(spring).collect(), is_in_steps: true })
    }

    /// How forceps have hold of the body between their jaws now, for [`Haptics::model`] of that body.
    ///
    /// # Errors
    /// If these are no forceps, or they hold nothing.
    pub fn coupling_of_forceps(&self, forceps: ForcepsId) -> Result<Coupling, HapticError> {
        let body = self.world.get::<&Forceps>(forceps.entity()).map_or(None, |forceps| forceps.body);
        let body = body.ok_or(HapticError::HoldsNothing)?;
        let grip = {
            let grips = self.world.get::<&Grips>(body.entity()).map_err(|_| HapticError::NoSuchBody)?;
            grips.pinches.iter().position(|pinch| pinch.forceps == Some(forceps))
        };
        self.coupling_of_grip(body, grip.ok_or(HapticError::HoldsNothing)?)
    }

    /// How [pins](Self::pin) have hold of a body, with their reaction at the last step, for [`Haptics::model`].
    ///
    /// # Errors
    /// If there is no such body, or there are no pins of this name.
    pub fn coupling_of_pins(&self, body: BodyId, name: &str) -> Result<Coupling, HapticError> {
        let pins = self.pins(body, name)?;
        let mut query = self.world.query_one::<(&Holds, &Reactions)>(body.entity());
        let (holds, reactions) = query.get().map_err(|_| HapticError::NoSuchBody)?;
        let group = holds.groups.iter().position(|hold| hold.name == name);
        let forces = group.and_then(|group| reactions.groups.get(group));
        Ok(Coupling::Pins { pins, force: forces.map_or(DVec3::ZERO, |forces| forces.iter().sum()) })
    }
}
