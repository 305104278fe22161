//! Contact of a body with itself, as found.

use crate::math::Sym3;
use glam::DVec3;

/// Two parts of a body that may touch: a vertex and a triangle, or two edges.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) struct Pair {
    /// Whether they are edges.
    pub are_edges: bool,
    /// Rows of a vertex and the corners of a triangle, or of the ends of both edges.
    pub rows: [u32; 4],
    /// The triangle; of edges one that has the second.
    pub triangle: u32,
}

/// A spring between two parts of a body along a normal.
#[derive(Clone, Copy, Debug)]
pub(crate) struct PairSpring {
    /// Rows of the vertices.
    pub rows: [u32; 4],
    /// Weights of the vertices in the distance, whose sum is zero.
    pub weights: [f64; 4],
    /// Unit normal.
    pub normal: DVec3,
    /// Stiffness along it \[N/mm\].
    pub stiffness: f64,
}

impl PairSpring {
    /// Force \[N\] along the normal for a displacement \[mm\] of every vertex.
    #[inline]
    pub(crate) fn force(&self, u: &[DVec3]) -> DVec3 {
        let distance: DVec3 = (0..4).map(|i| u[self.rows[i] as usize] * self.weights[i]).sum();
        self.normal * (self.stiffness * self.normal.dot(distance))
    }

    /// Block of a vertex on the diagonal \[N/mm\], by its place in the pair.
    pub(crate) fn block(&self, place: usize) -> Sym3 {
        Sym3::outer(self.normal) * (self.stiffness * self.weights[place] * self.weights[place])
    }
}

/// Self-contact of a body in the last step, and the memory of the search. *Derived.*
#[derive(Clone, Debug, Default)]
pub(crate) struct Layers {
    /// Pairs that may touch, in ascending order.
    pub pairs: Vec<Pair>,
    /// Pairs that a solve of this step has carried through each other, in ascending order.
    pub through: Vec<Pair>,
    /// Sweep of the last search: positions at its start and end \[mm\], and the triangles.
    pub found_from: Vec<DVec3>,
    pub found_to: Vec<DVec3>,
    pub found_of: Vec<[u32; 3]>,
    /// Reach and band of the last search \[mm\].
    pub found_within: [f64; 2],
    /// Whether the pairs exceeded the limit of the search; the list is then empty.
    pub are_too_many: bool,
    /// Whether all of them were proved apart on these ways.
    pub are_apart: bool,
    /// Rows of the triangles along a Morton curve, the order of the search tree.
    pub order: Vec<u32>,
    /// Pairs that repel each other in the last solve.
    pub touching: u32,
    /// Largest number of vertices held back in one pass of the step, where no solve had kept the layers apart.
    pub held_back: u32,
    /// Pairs of triangles that had passed through each other at the start of the step, which are left alone.
    pub overlapping: u32,
}
