//! Bending in single precision: the product in passes over the triangles, as in [`Folds`], and hinges for preconditioners.
//!
//! A hinge couples the two vertices opposite its edge, which are no neighbours: an incomplete factor without fill and the levels of
//! multigrid have no place for that. It is left out, and so much added to the two diagonal blocks that what is left is
//! semidefinite still: without, curvature would be negative along smooth shapes.

use super::empty;
use crate::storage::{NONE, Topology};
use crate::systems::kernels::block::Block;
use crate::systems::linear::Folds;
use crate::systems::parallel;
use glam::{Vec4, Vec4Swizzles};

/// What a triangle needs in a product.
#[derive(Clone, Copy, Debug)]
struct Fold {
    normal: Vec4,
    /// Tilt about every edge by its corners.
    by_corner: [Vec4; 3],
    /// Columns of the law.
    law: [Vec4; 3],
    /// The same edges in the triangles across: four times the triangle plus the edge. At the boundary its own.
    across: [u32; 3],
    /// One half where there is a triangle across, else zero.
    inside: Vec4,
    /// Rows of the corners.
    row: [u32; 3],
}

/// A hinge seen from a triangle: what it adds to the blocks of the triangle's corners and edges.
#[derive(Clone, Copy, Debug, Default)]
struct HingeBlocks {
    /// Derivatives of the angle by the corners of the triangle, times the root of the stiffness.
    gradient: [Vec4; 3],
    /// Factors of the blocks on the diagonal.
    diagonal: [f32; 3],
    /// Factors of the blocks of the edges 1–0, 2–0, 2–1.
    edge: [f32; 3],
}

/// The bending part of the operator.
#[derive(Debug, Default)]
pub struct Folding {
    folds: Vec<Fold>,
    hinges: Vec<[HingeBlocks; 3]>,
    tilt: Vec<[f32; 4]>,
    moment: Vec<[f32; 4]>,
    /// Per row the first entry in `incident`, four times a triangle plus a corner; one more at the end.
    start: Vec<u32>,
    incident: Vec<u32>,
}

impl Folding {
    /// Takes the numbers of the majorant.
    pub fn assemble(&mut self, folds: &Folds, corners: &[[u32; 3]], topology: &Topology, order: (&[u32], &[u32])) {
        let (vertex, row) = order;
        let n = corners.len();
        empty(&mut self.folds, n);
        self.folds.extend((0..n).map(|t| {
            let (tilt, q, across) = folds.row(t);
            let law = [[q[0], q[3], q[5]], [q[3], q[1], q[4]], [q[5], q[4], q[2]]];
            Fold {
                normal: tilt.normal.as_vec3().extend(0.0),
                by_corner: tilt.by_corner.map(|rates| rates.as_vec3().extend(0.0)),
                law: law.map(|[x, y, z]| glam::DVec3::new(x, y, z).as_vec3().extend(0.0)),
                across: std::array::from_fn(|e| match across[e] {
                    NONE => (4 * t + e) as u32,
                    across => 4 * (across / 3) + across % 3,
                }),
                inside: Vec4::from_array([0, 1, 2, 3].map(|e| match across.get(e) {
                    Some(&across) if across != NONE => 0.5,
                    _ => 0.0,
                })),
                row: corners[t].map(|v| row[v as usize]),
            }
        }));
        empty(&mut self.hinges, n);
        self.hinges.extend((0..n).map(|t| [0, 1, 2].map(|e| hinge_blocks(folds, corners, t, e))));
        for pass in [&mut self.tilt, &mut self.moment] {
            empty(pass, n);
            pass.resize(n, [0.0; 4]);
        }
        empty(&mut self.start, vertex.len() + 1);
        empty(&mut self.incident, 3 * n);
        self.start.push(0);
        for &v in vertex {
            self.incident.extend(topology.incident[v as usize].iter().map(|c| 4 * (c / 3) + c % 3));
            self.start.push(self.incident.len() as u32);
        }
    }

    /// The moments on every triangle by a displacement; [`at`](Self::at) has their forces then.
    pub fn bend(&mut self, u: &[Vec4]) {
        let Self { folds, tilt, moment, .. } = self;
        parallel::for_rows(tilt, |t, tilt| {
            let Fold { normal, by_corner, row, .. } = &folds[t];
            let along = |c: usize| dot(*normal, u[row[c] as usize]);
            let w = Vec4::new(along(0), along(1), along(2), 0.0);
            *tilt = [dot(by_corner[0], w), dot(by_corner[1], w), dot(by_corner[2], w), 0.0];
        });
        parallel::for_rows(moment, |t, moment| {
            let half = with_others(&folds[t], t, tilt);
            let [x, y, z] = &folds[t].law;
            *moment = (*x * half.xxxx() + *y * half.yyyy() + *z * half.zzzz()).to_array();
        });
        parallel::for_rows(tilt, |t, corners| {
            let m = with_others(&folds[t], t, moment);
            let [x, y, z] = &folds[t].by_corner;
            *corners = (*x * m.xxxx() + *y * m.yyyy() + *z * m.zzzz()).to_array();
        });
    }

    /// The force on a row.
    #[inline(always)]
    pub fn at(&self, row: usize) -> Vec4 {
        let mut sum = Vec4::ZERO;
        for &entry in &self.incident[self.start[row] as usize..self.start[row + 1] as usize] {
            sum += self.folds[entry as usize / 4].normal * self.tilt.as_flattened()[entry as usize];
        }
        sum
    }

    /// Calls `diagonal(corner, block)` and `edge(edge, block)` for the hinges of a triangle, those that it shares by halves.
    #[inline(always)]
    pub fn add_blocks(&self, t: usize, mut diagonal: impl FnMut(usize, &Block), mut edge: impl FnMut(usize, &Block)) {
        let outer = |a: Vec4, b: Vec4| [a * b.xxxx(), a * b.yyyy(), a * b.zzzz()];
        for hinge in &self.hinges[t] {
            let g = &hinge.gradient;
            for corner in 0..3 {
                diagonal(corner, &outer(g[corner] * hinge.diagonal[corner], g[corner]));
            }
            for (e, [a, b]) in [[1, 0], [2, 0], [2, 1]].into_iter().enumerate() {
                edge(e, &outer(g[a] * hinge.edge[e], g[b]));
            }
        }
    }
}

#[inline(always)]
fn dot(a: Vec4, b: Vec4) -> f32 {
    a.x * b.x + a.y * b.y + a.z * b.z
}

/// Half the sum of what a triangle and those across its edges have there; zero at the boundary.
#[inline(always)]
fn with_others(fold: &Fold, t: usize, values: &[[f32; 4]]) -> Vec4 {
    let (all, [a, b, c]) = (values.as_flattened(), fold.across);
    let others = Vec4::new(all[a as usize], all[b as usize], all[c as usize], 0.0);
    (Vec4::from_array(values[t]) + others) * fold.inside
}

fn hinge_blocks(folds: &Folds, corners: &[[u32; 3]], t: usize, e: usize) -> HingeBlocks {
    let Some(hinge) = folds.hinge(corners, t, e) else { return HingeBlocks::default() };
    let root = hinge.stiffness.sqrt();
    let (a, b, opposite) = (e, (e + 1) % 3, (e + 2) % 3);
    let mut blocks = HingeBlocks::default();
    for (corner, gradient) in [a, b, opposite].into_iter().zip(hinge.gradient) {
        blocks.gradient[corner] = (gradient * root).as_vec3().extend(0.0);
    }
    let [near, far] = [hinge.gradient[2].length(), hinge.gradient[3].length()];
    // What its own edge and its two vertices have comes from the triangle across as well.
    blocks.diagonal = [0.5; 3];
    blocks.diagonal[opposite] = if near > 0.0 { (1.0 + far / near) as f32 } else { 0.0 };
    blocks.edge = [1.0; 3];
    blocks.edge[a + b - 1] = 0.5;
    blocks
}
