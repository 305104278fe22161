//! Bending of a body: moments against the angles between its triangles, in passes over the triangles.
//!
//! The energy is that of Morley's triangle (1968), Σ ½·A·κ:D:κ, whose unknowns are the heights of the vertices and the tilts of
//! mid-edge normals. The tilts are not unknowns here: each normal starts half-way between its two triangles (Grinspun et al. 2006)
//! and is turned once, by a part of the difference of the two moments at its edge. The start by itself is 2 to 14 % too stiff on
//! meshes that are not regular, more where an edge is free; with the turn 2 % remain. Any turn that is linear in
//! the angles leaves an energy that is a sum of squares, above Morley's own.
//!
//! With h half the angles, Q the triangles' laws ([`bending::law`]) and J the differences of moments over edges, times −ω/k:
//! energy ½·φ·Q·φ with φ = (1 + J·Q)·h, moments (1 + Q·J)·Q·φ. Without J it is the majorant that dynamic steps take as tangent, with
//! the triangles that are not [taut](taut).

mod angles;
mod energy;
mod forces;
mod hinge;
mod spurious_energy;
mod taut;

use crate::components::Bending;
use crate::math::{Orthotropic, RestTriangle, Sym2};
use crate::storage::{NONE, Topology, Triangles, Vertices, measure};
use crate::systems::kernels::bending::{self, EdgeMatrix, Tilt};
use crate::systems::kernels::bending_lanes::{self, EdgeValuesX4, RestX4, TiltX4};
use crate::systems::kernels::lanes::DOUBLES;
use crate::systems::parallel;
use angles::Edges;
pub use forces::BendingPasses;
use glam::DVec3;
pub use hinge::Dihedral;
use std::sync::Arc;
use taut::Part;

/// Data from which a triangle's rest bending follows, beside its neighbours: rest shape, neighbour rows, bending law and the
/// factor of that law.
type MadeOf = (RestTriangle, [u32; 3], Orthotropic, f64);

/// The shape a triangle bends from.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct RestBending {
    law: EdgeMatrix,
    /// Rest angles, zero at the boundary.
    angle: DVec3,
    /// ω over the stiffness of the mid-edge normals \[1/(N·mm)\].
    turn: DVec3,
    /// Per edge the matching edge of the neighbouring triangle, as three times its row plus the edge; [`NONE`] at the boundary.
    across: [u32; 3],
    /// Upper bound of the stiffness that bending adds along normals, as a quadratic form of the triangle's slope \[N·mm\].
    stiffest: Sym2,
}

/// Bending state of a body. *Derived*: rest data follow the mesh by themselves; an energy at other positions shares them.
#[derive(Debug, Default)]
pub struct DihedralAngles {
    rest: Arc<Vec<RestBending>>,
    made_of: Arc<Vec<MadeOf>>,
    is_changed: Vec<bool>,
    /// The rest data in lanes, four triangles side by side.
    groups: Arc<Vec<RestX4>>,
    edges: Arc<Edges>,
    tilt: Vec<TiltX4>,
    /// Half the deviations of the dihedral angles from their rest values.
    half: Vec<EdgeValuesX4>,
    /// Part of each triangle that the majorant includes, padded to a multiple of four.
    part: Vec<Part>,
    is_slack: Vec<bool>,
    /// Whether its moments are in the majorant.
    bends: Vec<bool>,
    /// 1 + β/s, with the span s of the step and the time β of strain-rate damping.
    factor: f64,
}

/// Tables of a body.
type Body<'a> = (&'a Vertices, &'a Triangles, &'a Topology);

/// Whether a triangle is the first of the two at an edge.
#[inline(always)]
fn is_first(t: usize, e: usize, across: u32) -> bool {
    across != NONE && ((3 * t + e) as u32) < across
}

impl DihedralAngles {
    /// Updates rest data where the mesh or the material has changed. They are a function of the mesh alone: data updated after
    /// edits have the same bits as data rebuilt from scratch.
    pub fn refresh(
        &mut self,
        (vertices, triangles, topology): Body<'_>,
        bending: &Bending,
        passes: &mut BendingPasses,
    ) {
        let count = triangles.len();
        let scale = |t: usize| bending.scale(&triangles.stiffness[t], triangles.thickness[t]);
        let made_of = |t: usize| (triangles.rest[t], topology.neighbours[t], triangles.stiffness[t], scale(t));
        let is_same = |t: usize, (rest, neighbours, stiffness, factor): &MadeOf| {
            // No branches: all is the same, next to always.
            let ([a, b], RestTriangle { gradients: [c, d], area }) = (rest.gradients, triangles.rest[t]);
            let (p, &Orthotropic { q11, q12, q22, q66 }) = (stiffness, &triangles.stiffness[t]);
            let is_rest = (a.x == c.x) & (a.y == c.y) & (b.x == d.x) & (b.y == d.y) & (rest.area == area);
            let is_law = (p.q11 == q11) & (p.q12 == q12) & (p.q22 == q22) & (p.q66 == q66);
            (*neighbours == topology.neighbours[t]) & is_rest & is_law & (*factor == scale(t))
        };
        let before = &self.made_of;
        self.is_changed.resize(count, false);
        parallel::for_rows(&mut self.is_changed, |t, is_changed| {
            *is_changed = before.get(t).is_none_or(|before| !is_same(t, before));
        });
        if before.len() == count && !self.is_changed.contains(&true) {
            return;
        }
        let (rest, all_made_of) = (Arc::make_mut(&mut self.rest), Arc::make_mut(&mut self.made_of));
        rest.resize(count, RestBending::default());
        all_made_of.truncate(count);
        for t in (0..count).filter(|&t| self.is_changed[t]) {
            let made_of = made_of(t);
            rest[t].law = bending::law(&made_of.0, &made_of.2, made_of.3);
            match all_made_of.get_mut(t) {
                Some(before) => *before = made_of,
                // All that are new are changed, and come in order.
                None => all_made_of.push(made_of),
            }
        }
        let normal = |t: usize| {
            let [a, b, c] = measure::rest_corners(vertices, triangles.corners[t]);
            (b - a).cross(c - a).normalize_or_zero()
        };
        for t in 0..count {
            let neighbours = topology.neighbours[t];
            let is_near = neighbours.iter().any(|&n| n != NONE && self.is_changed[n as usize]);
            if !(self.is_changed[t] || is_near) {
                continue;
            }
            for e in 0..3 {
                let (n, corners) = (neighbours[e], triangles.corners[t]);
                let [from, to] = [corners[e], corners[(e + 1) % 3]];
                let of_other = |n: u32| triangles.corners[n as usize].iter().position(|&v| v == to);
                let across = if n == NONE { None } else { of_other(n).map(|f| (n as usize, f)) };
                let mut stiffness = self.rest[t].law[e];
                let mut angle = 0.0;
                if let Some((n, f)) = across {
                    stiffness += self.rest[n].law[f];
                    let edge = vertices.rest_position[to as usize] - vertices.rest_position[from as usize];
                    angle = bending::angle(normal(t), normal(n), edge);
                }
                let rest = &mut Arc::make_mut(&mut self.rest)[t];
                rest.across[e] = across.map_or(NONE, |(n, f)| (3 * n + f) as u32);
                rest.angle[e] = angle;
                rest.turn[e] = bending::TURN / stiffness;
            }
            let stiffest = self.stiffest(t, neighbours);
            Arc::make_mut(&mut self.rest)[t].stiffest = stiffest;
        }
        Arc::make_mut(&mut self.edges).list(self.rest.iter().map(|rest| (&rest.angle, rest.across)));
        passes.is_at_end = false;
        let Self { rest, made_of, groups, .. } = self;
        let across = |across: u32| (across != NONE).then_some((across as usize / 3, across as usize % 3));
        let of_triangle = |t: usize| (rest[t].law, rest[t].turn, rest[t].across.map(across), made_of[t].0.area);
        let groups = Arc::make_mut(groups);
        groups.clear();
        groups.extend((0..count).step_by(DOUBLES).map(|first| RestX4::new(first, count, of_triangle)));
    }

    /// Whether the rest data are the same, bit for bit.
    pub fn has_rest_of(&self, other: &Self) -> bool {
        self.rest == other.rest && self.made_of == other.made_of
    }

    /// Finds tilts and angles with the vertices at positions `x`; the step's tangent is taken there. `factor` is 1 + β/s.
    pub fn evaluate(&mut self, corners: &[[u32; 3]], x: &[DVec3], factor: f64, passes: &mut BendingPasses) {
        self.factor = factor;
        self.part.clear();
        self.part.resize(DOUBLES * self.groups.len(), Part::Whole);
        self.find_tilts(corners, x);
        self.find_angles(corners, x, passes);
    }

    /// Half the deviations of the dihedral angles around a triangle from their rest values.
    fn half(&self, t: usize) -> DVec3 {
        bending_lanes::of_triangle(&self.half, t)
    }

    /// Rotations of a triangle's mid-edge normals by the differences of moments across its edges.
    fn turned(&self, t: usize, moment: impl Fn(usize) -> DVec3) -> DVec3 {
        let rest = &self.rest[t];
        (self.others(t, &moment) - moment(t)) * rest.turn
    }

    /// Values that the neighbouring triangles have at the edges of a triangle; zero at the boundary.
    fn others(&self, t: usize, value: impl Fn(usize) -> DVec3) -> DVec3 {
        let mut others = DVec3::ZERO;
        for (e, &across) in self.rest[t].across.iter().enumerate() {
            if across != NONE {
                others[e] = value(across as usize / 3)[across as usize % 3];
            }
        }
        others
    }

    /// Half the change of the angles around a triangle for its own tilts and those of others.
    fn half_of_tilts(&self, t: usize, tilt: impl Fn(usize) -> DVec3) -> DVec3 {
        let inside = DVec3::from_array(self.rest[t].across.map(|across| f64::from(u8::from(across != NONE))));
        (tilt(t) * inside + self.others(t, &tilt)) * 0.5
    }

    /// Moments of a triangle about its edges for half angles everywhere: of the energy, or of the majorant.
    fn moment(&self, t: usize, half: &impl Fn(usize) -> DVec3, is_exact: bool) -> DVec3 {
        if !is_exact && self.part[t] != Part::Whole {
            return DVec3::ZERO;
        }
        let first = |t: usize| bending::product(&self.rest[t].law, half(t));
        if !is_exact {
            return first(t);
        }
        let second = |t: usize| bending::product(&self.rest[t].law, half(t) + self.turned(t, first));
        second(t) + bending::product(&self.rest[t].law, self.turned(t, second))
    }

    /// Adds the bending forces \[N\] at the angles last evaluated; `velocity_displacement` holds the displacements of the vertices over the
    /// span of the step.
    pub fn add_forces(
        &self,
        corners: &[[u32; 3]],
        topology: &Topology,
        velocity_displacement: impl Fn(usize) -> DVec3 + Sync,
        forces: &mut [DVec3],
        passes: &mut BendingPasses,
    ) {
        let is_moving = self.factor != 1.0 && (0..forces.len()).any(|v| velocity_displacement(v) != DVec3::ZERO);
        let by = if is_moving { self.factor - 1.0 } else { 0.0 };
        self.spread((1.0, by), velocity_displacement, (true, -1.0), (corners, topology), (forces, passes));
    }

    /// Adds the product \[N\] of the tangent with u \[mm\]: of the energy, but for the change of the angles' derivatives, or of the
    /// majorant.
    pub fn add_product(
        &self,
        corners: &[[u32; 3]],
        topology: &Topology,
        u: &[DVec3],
        is_exact: bool,
        out: &mut [DVec3],
        passes: &mut BendingPasses,
    ) {
        self.spread((0.0, self.factor), |v| u[v], (is_exact, 1.0), (corners, topology), (out, passes));
    }

    /// The product \[N\] at one vertex alone.
    pub fn product_at(
        &self,
        v: usize,
        corners: &[[u32; 3]],
        topology: &Topology,
        u: &[DVec3],
        is_exact: bool,
    ) -> DVec3 {
        let tilt = |t: usize| self.tilt(t).of(corners[t].map(|v| u[v as usize]));
        let half = |t: usize| self.half_of_tilts(t, tilt) * self.factor;
        let moment = |t: usize| self.moment(t, &half, is_exact);
        let force = |&c: &u32| {
            let (t, corner) = (c as usize / 3, c as usize % 3);
            {
                let tilt = self.tilt(t);
                tilt.normal * tilt.along(self.half_of_tilts(t, moment))[corner]
            }
        };
        topology.incident[v].iter().map(force).sum()
    }

    /// The tilts of a triangle.
    #[inline(always)]
    pub fn tilt(&self, t: usize) -> Tilt {
        self.tilt[t / DOUBLES].lane(t % DOUBLES)
    }

    /// The law of a triangle in the majorant, times 1 + β/s \[N·mm\].
    #[inline(always)]
    pub fn law(&self, t: usize) -> EdgeMatrix {
        if self.part[t] == Part::Whole { self.rest[t].law.map(|q| q * self.factor) } else { EdgeMatrix::default() }
    }

    /// Diagonal entry of a triangle's law in the majorant for one edge, times 1 + β/s \[N·mm\].
    #[inline(always)]
    pub fn stiffness(&self, t: usize, e: usize) -> f64 {
        if self.part[t] == Part::Whole { self.rest[t].law[e] * self.factor } else { 0.0 }
    }

    /// The edges of a triangle as those across have them, three times the triangle plus the edge; [`NONE`] at the boundary.
    pub fn across(&self, t: usize) -> [u32; 3] {
        self.rest[t].across
    }
}
