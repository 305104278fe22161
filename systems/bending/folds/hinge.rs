//! Bending by the dihedrals of two triangles each, for preconditioners.

use super::{DihedralAngles, is_first};
use crate::storage::NONE;
use crate::systems::kernels::bending::Tilt;
use glam::DVec3;

/// Four vertices around an edge, for matrices that need entries: the two of the edge, then those opposite.
#[derive(Clone, Copy, Debug)]
pub struct Dihedral {
    /// The vertices.
    pub vertices: [u32; 4],
    /// Derivative of the angle by each of them \[1/mm\].
    pub gradient: [DVec3; 4],
    /// Moment per angle \[N·mm\].
    pub stiffness: f64,
}

impl DihedralAngles {
    /// The dihedral at an edge of a triangle: without the terms that couple the edges of a triangle, for preconditioners.
    /// `None` at the boundary.
    pub fn hinge(&self, corners: &[[u32; 3]], t: usize, e: usize) -> Option<Dihedral> {
        let across = self.rest[t].across[e];
        if across == NONE {
            return None;
        }
        let (n, f) = (across as usize / 3, across as usize % 3);
        let (own, other) = (&self.tilt(t), &self.tilt(n));
        let part = |tilt: &Tilt, e: usize, corner: usize| tilt.normal * tilt.by_corner(e, corner % 3);
        let gradient = [
            part(own, e, e) + part(other, f, f + 1),
            part(own, e, e + 1) + part(other, f, f),
            part(own, e, e + 2),
            part(other, f, f + 2),
        ];
        let vertices = [corners[t][e], corners[t][(e + 1) % 3], corners[t][(e + 2) % 3], corners[n][(f + 2) % 3]];
        let stiffness = 0.25 * (self.law(t)[e] + self.law(n)[f]);
        Some(Dihedral { vertices, gradient, stiffness })
    }

    /// All dihedrals, each once.
    pub fn hinges(&self, corners: &[[u32; 3]]) -> impl Iterator<Item = Dihedral> {
        let edges = (0..self.rest.len()).flat_map(|t| [0, 1, 2].map(|e| (t, e)));
        let once = edges.filter(|&(t, e)| is_first(t, e, self.rest[t].across[e]));
        once.filter_map(move |(t, e)| self.hinge(corners, t, e))
    }
}
