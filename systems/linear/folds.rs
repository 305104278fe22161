//! Bending of a body: moments against the angles between its triangles, in passes over the triangles.
//!
//! The energy is that of Morley's triangle (1968), Σ ½·A·κ:D:κ, whose unknowns are the heights of the vertices and the tilts of
//! mid-edge normals. The tilts are not unknowns here: each normal starts half-way between its two triangles (Grinspun et al. 2006)
//! and is turned once, by a part of the difference of the two moments at its edge. The start by itself is 2 to 14 % too stiff on
//! meshes that are not regular, more where an edge is free; with the turn 2 % remain. Any turn that is linear in
//! the angles leaves an energy that is a sum of squares, above Morley's own.
//!
//! With h half the angles, Q the triangles' laws ([`fold::law`]) and J the differences of moments over edges, times −ω/k:
//! energy ½·φ·Q·φ with φ = (1 + J·Q)·h, moments (1 + Q·J)·Q·φ. Without J it is the majorant that dynamic steps take as tangent, with
//! the triangles that are not [taut](taut).

mod angles;
mod energy;
mod hinge;
mod left_over;
mod taut;

use crate::components::Bending;
use crate::math::{Orthotropic, RestTriangle, Sym2};
use crate::storage::{NONE, Topology, Triangles, Vertices, measure};
use crate::systems::kernels::fold::{self, OverEdges, Tilt};
use crate::systems::kernels::membrane_lanes::Four;
use crate::systems::parallel;
use angles::Edges;
use glam::DVec3;
pub use hinge::Hinge;
use std::sync::{Mutex, PoisonError};
use taut::Part;

/// The part ω of a single mid-edge normal's own way to balance by which all are turned at once (2/3 would be best for a triangle by
/// itself, whose modes lie between 0 and 3).
const TURN: f64 = 0.65;

/// What the rest data of a triangle are made of: besides, its neighbours and the factor of its law.
type MadeOf = (RestTriangle, [u32; 3], Orthotropic, f64);

/// The shape a triangle bends from.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct RestFold {
    law: OverEdges,
    /// Rest angles, zero at the boundary.
    angle: DVec3,
    /// ω over the stiffness of the mid-edge normals \[1/(N·mm)\].
    turn: DVec3,
    /// The same edge as the triangle across has it, three times that triangle plus the edge; [`NONE`] at the boundary.
    across: [u32; 3],
    /// What bending adds at most to the stiffness along normals, as a form of the slope of the triangle \[N·mm\].
    stiffest: Sym2,
}

/// What bending of a body needs. *Derived*: rest data follow the mesh by themselves.
#[derive(Debug, Default)]
pub struct Folds {
    rest: Vec<RestFold>,
    made_of: Vec<MadeOf>,
    is_changed: Vec<bool>,
    edges: Edges,
    tilt: Vec<Tilt>,
    /// Half of what the angles are off their rest values.
    half: Vec<DVec3>,
    /// What of the triangles is in the majorant.
    part: Vec<Part>,
    is_slack: Vec<bool>,
    /// Whether its moments are in the majorant.
    bends: Vec<bool>,
    /// 1 + β/s, with the span s of the step and the time β of strain-rate damping.
    factor: f64,
    passes: Mutex<Passes>,
}

/// What passes over the triangles leave for each other.
#[derive(Debug, Default)]
struct Passes {
    /// Tilts of a displacement, later moments, at last forces on corners along the normals.
    rows: Vec<DVec3>,
    /// Half angles and moments.
    bent: Vec<[DVec3; 2]>,
    /// Per edge half of what its angle is off its rest value.
    off: Vec<f64>,
    /// Of a motion: where vertices go and where they end.
    motion: Vec<[DVec3; 2]>,
    /// Normals at its end, its tilts and those of a motion before.
    moved: Vec<[DVec3; 3]>,
    halves: Vec<Halves>,
}

/// Per edge of a triangle four half angles, and their products with the law: at the start of a motion, at its end, their change along the
/// tilts, and that of the motion before.
type Halves = [[Four; 3]; 2];

/// Tables of a body.
type Body<'a> = (&'a Vertices, &'a Triangles, &'a Topology);

/// Whether a triangle is the first of the two at an edge.
#[inline(always)]
fn is_first(t: usize, e: usize, across: u32) -> bool {
    across != NONE && ((3 * t + e) as u32) < across
}

impl Folds {
    /// Brings rest data up to the mesh, where that or the material has changed. They are a function of the mesh alone: what has
    /// followed edits has the same bits as what is made anew.
    pub fn refresh(&mut self, vertices: &Vertices, triangles: &Triangles, topology: &Topology, bending: &Bending) {
        let count = triangles.len();
        let scale = |t: usize| {
            let (stiffness, h) = (&triangles.stiffness[t], triangles.thickness[t]);
            bending.stiffness.map_or_else(|| h * h * h / 12.0, |d| d / (stiffness.q11 * stiffness.q22).sqrt())
        };
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
        self.rest.resize(count, RestFold::default());
        self.made_of.truncate(count);
        for t in (0..count).filter(|&t| self.is_changed[t]) {
            let made_of = made_of(t);
            self.rest[t].law = fold::law(&made_of.0, &made_of.2, made_of.3);
            match self.made_of.get_mut(t) {
                Some(before) => *before = made_of,
                // All that are new are changed, and come in order.
                None => self.made_of.push(made_of),
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
                    angle = fold::angle(normal(t), normal(n), edge);
                }
                let rest = &mut self.rest[t];
                rest.across[e] = across.map_or(NONE, |(n, f)| (3 * n + f) as u32);
                rest.angle[e] = angle;
                rest.turn[e] = TURN / stiffness;
            }
            self.rest[t].stiffest = self.stiffest(t, neighbours);
        }
        self.edges.list(self.rest.iter().map(|rest| (&rest.angle, rest.across)));
    }

    /// Whether the rest data are the same, bit for bit.
    pub fn has_rest_of(&self, other: &Self) -> bool {
        self.rest == other.rest && self.made_of == other.made_of
    }

    /// Finds tilts and angles with the vertices at positions `x`; the step's tangent is taken there. `factor` is 1 + β/s.
    pub fn evaluate(&mut self, corners: &[[u32; 3]], x: &[DVec3], factor: f64) {
        let Self { rest, made_of, edges, tilt, half, passes, .. } = self;
        self.factor = factor;
        self.part.clear();
        self.part.resize(rest.len(), Part::Whole);
        tilt.resize(rest.len(), Tilt::default());
        parallel::for_rows(tilt, |t, tilt| {
            let [a, b, c] = corners[t];
            *tilt = Tilt::new([x[a as usize], x[b as usize], x[c as usize]], made_of[t].0.area);
        });
        let off = &mut passes.get_mut().unwrap_or_else(PoisonError::into_inner).off;
        edges.find(corners, |t| tilt[t].normal, |v| x[v], off);
        half.resize(rest.len(), DVec3::ZERO);
        parallel::for_rows(half, |t, half| *half = edges.around(t, off));
    }

    /// What the differences of moments turn the mid-edge normals of a triangle by.
    #[inline(always)]
    fn turned(&self, t: usize, moment: impl Fn(usize) -> DVec3) -> DVec3 {
        let rest = &self.rest[t];
        (self.others(t, &moment) - moment(t)) * rest.turn
    }

    /// What the triangles across the edges of a triangle have there; zero at the boundary.
    #[inline(always)]
    fn others(&self, t: usize, value: impl Fn(usize) -> DVec3) -> DVec3 {
        let mut others = DVec3::ZERO;
        for (e, &across) in self.rest[t].across.iter().enumerate() {
            if across != NONE {
                others[e] = value(across as usize / 3)[across as usize % 3];
            }
        }
        others
    }

    /// Where the triangle has a neighbour 1, else 0.
    #[inline(always)]
    fn inside(&self, t: usize) -> DVec3 {
        DVec3::from_array(self.rest[t].across.map(|across| f64::from(u8::from(across != NONE))))
    }

    /// Half the change of the angles around a triangle for its own tilts and those of others.
    #[inline(always)]
    fn half_of_tilts(&self, t: usize, tilt: impl Fn(usize) -> DVec3) -> DVec3 {
        (tilt(t) * self.inside(t) + self.others(t, &tilt)) * 0.5
    }

    /// Moments of a triangle about its edges for half angles everywhere: of the energy, or of the majorant.
    fn moment(&self, t: usize, half: &impl Fn(usize) -> DVec3, is_exact: bool) -> DVec3 {
        if !is_exact && self.part[t] != Part::Whole {
            return DVec3::ZERO;
        }
        let first = |t: usize| fold::product(&self.rest[t].law, half(t));
        if !is_exact {
            return first(t);
        }
        let second = |t: usize| fold::product(&self.rest[t].law, half(t) + self.turned(t, first));
        second(t) + fold::product(&self.rest[t].law, self.turned(t, second))
    }

    /// Adds to every vertex `sign` times the forces of moments: for `at` times the half angles as they are, and `by` times
    /// their change by a displacement `u`.
    fn spread(
        &self,
        scales: (f64, f64),
        u: impl Fn(usize) -> DVec3 + Sync,
        (is_exact, sign): (bool, f64),
        (corners, topology): (&[[u32; 3]], &Topology),
        out: &mut [DVec3],
    ) {
        let mut passes = self.passes.lock().unwrap_or_else(PoisonError::into_inner);
        self.find_forces(scales, u, is_exact, corners, &mut passes);
        let rows = &passes.rows;
        parallel::for_rows(out, |v, out| {
            let mut sum = DVec3::ZERO;
            for &c in &topology.incident[v] {
                let (t, corner) = (c as usize / 3, c as usize % 3);
                sum += self.tilt[t].normal * rows[t][corner];
            }
            *out += sum * sign;
        });
    }

    /// Leaves in `rows` the forces on the corners along the normals.
    fn find_forces(
        &self,
        (at, by): (f64, f64),
        u: impl Fn(usize) -> DVec3 + Sync,
        is_exact: bool,
        corners: &[[u32; 3]],
        Passes { rows, bent, .. }: &mut Passes,
    ) {
        debug_assert_eq!(corners.len(), self.rest.len());
        let has_part = |t: usize| is_exact || self.part[t] != Part::None;
        rows.resize(self.rest.len(), DVec3::ZERO);
        bent.resize(self.rest.len(), Default::default());
        if by != 0.0 {
            parallel::for_rows(rows, |t, tilts| {
                if !has_part(t) {
                    return;
                }
                let [a, b, c] = corners[t];
                *tilts = self.tilt[t].of([u(a as usize), u(b as usize), u(c as usize)]);
            });
        }
        parallel::for_rows(bent, |t, bent| {
            if !is_exact && self.part[t] != Part::Whole {
                *bent = Default::default();
                return;
            }
            let mut half = if at == 0.0 { DVec3::ZERO } else { self.half[t] * at };
            if by != 0.0 {
                half += self.half_of_tilts(t, |t| rows[t]) * by;
            }
            *bent = [half, fold::product(&self.rest[t].law, half)];
        });
        if is_exact {
            parallel::for_rows(rows, |t, m| {
                *m = fold::product(&self.rest[t].law, bent[t][0] + self.turned(t, |t| bent[t][1]));
            });
            parallel::for_rows(bent, |t, bent| {
                bent[1] = rows[t] + fold::product(&self.rest[t].law, self.turned(t, |t| rows[t]));
            });
        }
        parallel::for_rows(rows, |t, along| {
            let moment = || self.tilt[t].along(self.half_of_tilts(t, |t| bent[t][1]));
            *along = if has_part(t) { moment() } else { DVec3::ZERO };
        });
    }

    /// Adds the forces \[N\] at the angles last evaluated; `travel` is what the vertices travel in the span of the step.
    pub fn add_forces(
        &self,
        corners: &[[u32; 3]],
        topology: &Topology,
        travel: impl Fn(usize) -> DVec3 + Sync,
        forces: &mut [DVec3],
    ) {
        let is_moving = self.factor != 1.0 && (0..forces.len()).any(|v| travel(v) != DVec3::ZERO);
        let by = if is_moving { self.factor - 1.0 } else { 0.0 };
        self.spread((1.0, by), travel, (true, -1.0), (corners, topology), forces);
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
    ) {
        self.spread((0.0, self.factor), |v| u[v], (is_exact, 1.0), (corners, topology), out);
    }

    /// Adds the product \[N\] to the forces on the corners of the triangles.
    pub fn add_to_corners(&self, corners: &[[u32; 3]], u: &[DVec3], is_exact: bool, out: &mut [[DVec3; 3]]) {
        let mut passes = self.passes.lock().unwrap_or_else(PoisonError::into_inner);
        self.find_forces((0.0, self.factor), |v| u[v], is_exact, corners, &mut passes);
        let rows = &passes.rows;
        parallel::for_rows(out, |t, out| {
            if !(is_exact || self.part[t] != Part::None) {
                return;
            }
            let (normal, along) = (self.tilt[t].normal, rows[t]);
            out[0] += normal * along.x;
            out[1] += normal * along.y;
            out[2] += normal * along.z;
        });
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
        let tilt = |t: usize| self.tilt[t].of(corners[t].map(|v| u[v as usize]));
        let half = |t: usize| self.half_of_tilts(t, tilt) * self.factor;
        let moment = |t: usize| self.moment(t, &half, is_exact);
        let force = |&c: &u32| {
            let (t, corner) = (c as usize / 3, c as usize % 3);
            self.tilt[t].normal * self.tilt[t].along(self.half_of_tilts(t, moment))[corner]
        };
        topology.incident[v].iter().map(force).sum()
    }

    /// The tilts of a triangle.
    pub fn tilt(&self, t: usize) -> &Tilt {
        &self.tilt[t]
    }

    /// The law of a triangle in the majorant, times 1 + β/s \[N·mm\].
    #[inline(always)]
    pub fn law(&self, t: usize) -> OverEdges {
        if self.part[t] == Part::Whole { self.rest[t].law.map(|q| q * self.factor) } else { OverEdges::default() }
    }

    /// The edges of a triangle as those across have them, three times the triangle plus the edge; [`NONE`] at the boundary.
    pub fn across(&self, t: usize) -> [u32; 3] {
        self.rest[t].across
    }
}
