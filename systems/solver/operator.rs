//! Operator A = M/s² + external stiffness + bending + Σ over triangles of (1 + β/s)·elastic + geometric + load stiffness, applied matrix-free.
//! The effective time step s is that of the formula.
//!
//! Every triangle has a force for each of its corners, every vertex the sum of its corners in the order of triangle rows. No two
//! threads write one number and every sum has one order.

use super::load_stiffness::{edge_loads, load_product};
use crate::components::{ExternalStiffness, Frames, FreeAxes, VolumeStiffness};
use crate::math::{ElementState, GeometricStiffness, Orthotropic, Sym3};
use crate::settings::Tangent;
use crate::storage::{Topology, Triangles, Vertices};
use crate::systems::bending::{BendingPasses, DihedralAngles};
use crate::systems::forces::corners;
use crate::systems::kernels::gather::Stored;
use crate::systems::kernels::lanes::{DOUBLES, Lanes};
use crate::systems::kernels::membrane::{ElementTangent, shear_majorant, turning_weight};
use crate::systems::kernels::product_lanes;
use crate::systems::kernels::simd::Kernel;
use crate::systems::{StepContext, parallel};
use glam::{DMat3, DVec3};

/// The operator at one state of one body.
#[derive(Clone, Copy, Debug)]
pub struct Operator<'a> {
    /// For the masses.
    pub vertices: &'a Vertices,
    /// Rest data and material.
    pub triangles: &'a Triangles,
    /// For the gather.
    pub topology: &'a Topology,
    /// State of the triangles.
    pub frames: &'a Frames,
    /// Stiffness of springs, contact, grips and drag.
    pub external: Option<&'a ExternalStiffness>,
    /// Stiffness of a compartment's content.
    pub volume: Option<&'a VolumeStiffness>,
    /// Bending, at the same state.
    pub folds: Option<&'a DihedralAngles>,
    /// 1/s² \[1/ms²\] for the effective time step s.
    pub inertia: f64,
    /// β/s of strain-rate damping, for the effective time step s.
    pub viscosity: f64,
    /// Follower pressure \[MPa\] whose load stiffness is part of it; zero where that is left out.
    pub pressure: f64,
    /// Which derivative of the membrane's forces it is; `frames` holds the geometric stiffness that goes with it.
    pub tangent: Tangent,
}

/// Working memory of an operator's products.
#[derive(Debug)]
pub struct ProductMemory<'a> {
    /// Forces on the corners of every triangle \[N\].
    pub corner: &'a mut Vec<[DVec3; 3]>,
    /// Passes of bending, where the body bends.
    pub passes: &'a mut BendingPasses,
}

impl<'a> Operator<'a> {
    /// The operator of the membrane alone, without masses, damping, bending and loads.
    pub fn membrane(
        (vertices, triangles, topology, frames): (&'a Vertices, &'a Triangles, &'a Topology, &'a Frames),
        tangent: Tangent,
    ) -> Self {
        Self {
            vertices,
            triangles,
            topology,
            frames,
            external: None,
            volume: None,
            folds: None,
            inertia: 0.0,
            viscosity: 0.0,
            pressure: 0.0,
            tangent,
        }
    }
}

impl Operator<'_> {
    /// The tangent of a triangle.
    #[inline(always)]
    pub fn element(&self, t: usize) -> ElementTangent<'_> {
        if self.tangent == Tangent::Weighted { self.weighted_element(t) } else { self.plain_element(t) }
    }

    /// The tangent of a triangle of an operator that is not weighted.
    #[inline(always)]
    pub fn plain_element(&self, t: usize) -> ElementTangent<'_> {
        self.element_at(t, self.frames.state(t))
    }

    /// Weighted tangent of a triangle.
    #[inline(never)]
    pub fn weighted_element(&self, t: usize) -> ElementTangent<'_> {
        let element = self.plain_element(t);
        let (ElementState { polar, stress }, law) = (element.state, self.triangles.law(t));
        let turning = turning_weight(stress, law);
        let slack = 1.0 - turning;
        let shear = if slack > 0.0 {
            slack * shear_majorant(stress, polar.stretch, law, StepContext::RESERVE_OF_EULER)
        } else {
            0.0
        };
        ElementTangent { shear, turning, ..element }
    }

    /// The tangent of a triangle with this state, or one that is stored there.
    #[inline(always)]
    fn element_at<S>(&self, t: usize, state: S) -> ElementTangent<'_, S> {
        let volume = self.triangles.rest[t].area * self.triangles.thickness[t];
        let GeometricStiffness { normal, in_plane } = self.frames.geometric_stiffness(t);
        let (shear, spin, turning) =
            if self.tangent == Tangent::Rotated { (in_plane, 0.0, 0.0) } else { (0.0, in_plane, 1.0) };
        ElementTangent {
            state,
            rest: &self.triangles.rest[t],
            stiffness: self.frames.stiffness(self.triangles, t),
            coupling: self.frames.coupling(t),
            normal,
            shear,
            spin,
            turning,
            elastic: volume * (1.0 + self.viscosity),
            geometric: volume,
        }
    }

    /// Rotated tangent of a triangle at the operator's state, which may be exact: never indefinite.
    #[inline(never)]
    pub fn rotated_element(&self, t: usize) -> ElementTangent<'_> {
        let element = self.plain_element(t);
        let state = element.state;
        let law = self.triangles.law(t);
        let shear = shear_majorant(state.stress, state.polar.stretch, law, StepContext::RESERVE_OF_EULER);
        ElementTangent { normal: element.normal.positive_part(), shear, spin: 0.0, turning: 0.0, ..element }
    }

    /// Frames of the triangles with the geometric stiffness of the rotated tangent, in the memory of `frames`; `reserve` is that of the
    /// step's formula.
    pub fn rotated_frames(&self, reserve: f64, mut frames: Frames) -> Frames {
        frames.clone_from(self.frames);
        let majorant = |(state, law): (ElementState, &Orthotropic)| {
            shear_majorant(state.stress, state.polar.stretch, law, reserve)
        };
        let laws = (0..self.triangles.len()).map(|t| self.triangles.law(t));
        let majorants = self.frames.states().zip(laws).map(majorant);
        if frames.is_planar() {
            frames.in_plane.clear();
            frames.in_plane.extend(majorants);
        } else {
            for (geometric, in_plane) in frames.geometric.iter_mut().zip(majorants) {
                *geometric = GeometricStiffness { normal: geometric.normal.positive_part(), in_plane };
            }
        }
        frames
    }

    /// The product of a triangle's tangent, its load stiffness included, with displacements of its corners.
    #[inline(always)]
    fn triangle_product(&self, t: usize, u: [DVec3; 3]) -> [DVec3; 3] {
        let forces = self.element(t).apply(u);
        if self.pressure == 0.0 {
            return forces;
        }
        let loads = load_product(self.edge_loads(t), u);
        [forces[0] + loads[0], forces[1] + loads[1], forces[2] + loads[2]]
    }

    /// The edges of a triangle, weighted as its load stiffness has them \[N/mm\].
    pub fn edge_loads(&self, t: usize) -> [DVec3; 3] {
        edge_loads(self.triangles.corners[t].map(|v| self.vertices.position[v as usize]), self.pressure)
    }

    /// Vertex block of `v`: mass and external stiffness \[N/mm\].
    pub fn vertex_block(&self, v: usize) -> DMat3 {
        let mass = DMat3::from_diagonal(DVec3::splat(self.vertices.mass[v] * self.inertia));
        self.external.map_or(mass, |e| mass + e.block[v].to_mat())
    }

    /// The vertex block of `v` and the part of springs between layers on the diagonal \[N/mm\].
    pub fn own_block(&self, v: usize) -> DMat3 {
        let pairs = self.external.and_then(|external| external.coupled.pair_block.get(v));
        self.vertex_block(v) + pairs.map_or(DMat3::ZERO, |block| block.to_mat())
    }

    /// `out` = A·u \[N\] for u \[mm\]; returns Σ u·(A·u) over the free axes.
    pub fn apply(
        &self,
        u: &[DVec3],
        free: &FreeAxes,
        memory: &mut ProductMemory<'_>,
        out: &mut [DVec3],
        partials: &mut Vec<f64>,
    ) -> f64 {
        if self.frames.is_planar() {
            self.apply_membrane(&self.frames.flat, u, memory, out);
        } else {
            self.apply_membrane(&self.frames.solid, u, memory, out);
        }
        if let Some(external) = self.external {
            external.coupled.add(u, out);
        }
        self.add_volume(u, out);
        parallel::sum_rows(out, partials, |v, out| {
            let own = match self.external {
                None => u[v] * (self.vertices.mass[v] * self.inertia),
                Some(_) => self.vertex_block(v) * u[v],
            };
            *out = own + *out;
            (free[v] * u[v]).dot(*out)
        })
    }

    /// `out` = (the terms of triangles and bending in A)·u \[N\], with the states of the triangles.
    fn apply_membrane<S: Stored>(&self, state: &[S], u: &[DVec3], memory: &mut ProductMemory<'_>, out: &mut [DVec3]) {
        let ProductMemory { corner, passes } = memory;
        let (Triangles { corners, .. }, products) = (self.triangles, Products { operator: self, state, u });
        if let Some(folds) = self.folds {
            corner.resize(corners.len(), [DVec3::ZERO; 3]);
            parallel::for_chunks(corner, &products);
            folds.add_to_corners(corners, u, self.tangent == Tangent::Exact, corner, passes);
            parallel::for_rows(out, |v, out| *out = corners::gathered(self.topology, corner, v));
        } else {
            corners::add_up((corners, self.topology), corner, out, &products, |_| ());
        }
    }

    /// Whether nothing is stiff along z: so it is in a plane.
    pub fn is_planar(&self) -> bool {
        self.frames.is_planar() && self.folds.is_none()
    }

    /// Whether the operator is positive definite but for rounding: the masses of a dynamic step make a semidefinite operator definite.
    pub fn is_definite(&self) -> bool {
        self.inertia > 0.0 && self.tangent != Tangent::Exact
    }

    /// `out` = A·u \[N\] for a u \[mm\] that is zero but at a few vertices, as prescribed motion is.
    pub fn apply_sparse(&self, u: &[DVec3], out: &mut [DVec3], passes: &mut BendingPasses) {
        out.fill(DVec3::ZERO);
        for (v, moved) in u.iter().enumerate().filter(|(_, u)| **u != DVec3::ZERO) {
            out[v] += self.vertex_block(v) * *moved;
            for &c in &self.topology.incident[v] {
                let (t, corner) = (c as usize / 3, c as usize % 3);
                let corners = self.triangles.corners[t];
                let u = corners.map(|v| u[v as usize]);
                // Each triangle once, for the first of its corners that moves.
                if u.iter().position(|u| *u != DVec3::ZERO) == Some(corner) {
                    let forces = self.triangle_product(t, u);
                    corners.iter().zip(forces).for_each(|(&v, force)| out[v as usize] += force);
                }
            }
        }
        if let Some(external) = self.external {
            external.coupled.add(u, out);
        }
        if u.iter().any(|u| *u != DVec3::ZERO) {
            self.add_volume(u, out);
        }
        if let Some(folds) = self.folds
            && u.iter().any(|u| *u != DVec3::ZERO)
        {
            folds.add_product(&self.triangles.corners, self.topology, u, self.tangent == Tangent::Exact, out, passes);
        }
    }

    /// Adds the forces \[N\] of a compartment's content for a displacement \[mm\].
    fn add_volume(&self, u: &[DVec3], out: &mut [DVec3]) {
        if let Some(volume) = self.volume {
            let pressure = self.volume_pressure(u);
            parallel::for_rows(out, |v, out| *out += volume.gradient[v] * pressure);
        }
    }

    /// Fall of a content's pressure \[MPa\] by a displacement \[mm\]; zero without one.
    pub fn volume_pressure(&self, u: &[DVec3]) -> f64 {
        self.volume.map_or(0.0, |volume| volume.stiffness * volume.swept(u))
    }

    /// Force \[N\] at the vertex `v` by such a fall.
    pub fn volume_force(&self, v: usize, pressure: f64) -> DVec3 {
        self.volume.map_or(DVec3::ZERO, |volume| volume.gradient[v] * pressure)
    }

    /// A·u \[N\] at the vertex `v` alone, but for the content of a compartment, whose pressure all vertices have in common.
    pub fn apply_at(&self, v: usize, u: &[DVec3]) -> DVec3 {
        let corners = &self.triangles.corners;
        let is_exact = self.tangent == Tangent::Exact;
        let bending = self.folds.map(|folds| folds.product_at(v, corners, self.topology, u, is_exact));
        let coupled = self.external.map_or(DVec3::ZERO, |external| external.coupled.at(v, u));
        let own = self.vertex_block(v) * u[v] + bending.unwrap_or_default() + coupled;
        self.topology.incident[v].iter().fold(own, |sum, &c| {
            let (t, corner) = (c as usize / 3, c as usize % 3);
            sum + self.triangle_product(t, self.triangles.corners[t].map(|v| u[v as usize]))[corner]
        })
    }

    /// The 3×3 block of vertex `v` on the diagonal \[N/mm\]; dihedrals included, load stiffness has none.
    pub fn diagonal_block(&self, v: usize) -> DMat3 {
        let incident = &self.topology.incident[v];
        let own = self.own_block(v) + self.folds.map_or(DMat3::ZERO, |folds| self.bending_block(folds, v));
        incident.iter().fold(own, |sum, &c| sum + self.element(c as usize / 3).diagonal_block(c as usize % 3))
    }

    fn bending_block(&self, folds: &DihedralAngles, v: usize) -> DMat3 {
        let mut sum = Sym3::ZERO;
        for &c in &self.topology.incident[v] {
            let (t, corner) = (c as usize / 3, c as usize % 3);
            // The edges from the vertex and opposite to it; the one to it is from it in the triangle across.
            for (e, place) in [(corner, 0), ((corner + 1) % 3, 2)] {
                if let Some(hinge) = folds.hinge(&self.triangles.corners, t, e) {
                    sum += Sym3::outer(hinge.gradient[place]) * hinge.stiffness;
                }
            }
        }
        sum.to_mat()
    }
}

/// The forces of a displacement on the corners of every triangle.
struct Products<'a, S> {
    operator: &'a Operator<'a>,
    state: &'a [S],
    u: &'a [DVec3],
}

impl<S: Stored> Kernel<[DVec3; 3]> for Products<'_, S> {
    #[inline(always)]
    fn run<L: Lanes>(&self, lanes: L, first: usize, rows: &mut [[DVec3; 3]]) {
        let Self { operator, state, u } = self;
        let corners = &operator.triangles.corners[first..][..rows.len()];
        if operator.tangent != Tangent::Rotated || !L::HAS_DOUBLES {
            for (i, (out, [a, b, c])) in rows.iter_mut().zip(corners).enumerate() {
                *out = operator.triangle_product(first + i, [u[*a as usize], u[*b as usize], u[*c as usize]]);
            }
            return;
        }
        for (group, out) in rows.chunks_mut(DOUBLES).enumerate() {
            let start = group * DOUBLES;
            let element = |i: usize| operator.element_at(first + i, &state[first + i]);
            let (mut elements, mut of_corners) = ([element(start); DOUBLES], [[DVec3::ZERO; 3]; DOUBLES]);
            for lane in 0..DOUBLES {
                // The last group is filled up with its last triangle.
                let i = start + lane.min(out.len() - 1);
                let [a, b, c] = corners[i];
                elements[lane] = element(i);
                of_corners[lane] = [u[a as usize], u[b as usize], u[c as usize]];
            }
            product_lanes::apply(lanes, &elements, of_corners, out);
        }
    }
}
