//! Contact of a body with itself and with others, as found.

use crate::math::Sym3;
use glam::DVec3;
use hecs::Entity;

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

/// Two parts at the start of a sweep.
#[derive(Clone, Copy, Debug)]
pub(crate) struct PairStart {
    /// Unit normal along the shortest way from the second part to the first.
    pub normal: DVec3,
    /// Length of that way \[mm\].
    pub distance: f64,
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

/// A box around points.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Bounds {
    /// Lowest corner \[mm\].
    pub low: DVec3,
    /// Highest corner \[mm\].
    pub high: DVec3,
}

/// Two triangles with parts that may touch.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Candidate {
    /// Rows of the triangles, ascending.
    pub rows: [u32; 2],
    /// Which of their vertices are too near to each other in the rest shape to touch.
    pub near: [[bool; 3]; 3],
}

/// Pairs of triangles that may meet while all vertices stay in their boxes.
#[derive(Clone, Debug, Default)]
pub(crate) struct Candidates {
    /// The pairs, in no order.
    pub list: Vec<Candidate>,
    /// Boxes of the vertices.
    pub boxes: Vec<Bounds>,
    /// Triangles of the mesh, and rest positions \[mm\], for which they hold.
    pub corners: Vec<[u32; 3]>,
    pub rest: Vec<DVec3>,
    /// Band \[mm\].
    pub band: f64,
    /// Whether they exceeded their limit; the list is then empty.
    pub are_too_many: bool,
}

/// Self-contact of a body in the last step, and the memory of the search. *Derived.*
#[derive(Clone, Debug, Default)]
pub(crate) struct Layers {
    /// Pairs that may touch, in ascending order, and how each begins the sweep.
    pub pairs: Vec<Pair>,
    pub starts: Vec<PairStart>,
    /// Pairs that a solve of this step has carried through each other, in ascending order.
    pub through: Vec<Pair>,
    /// Sweep of the last search: positions at its start and end \[mm\], and the triangles.
    pub found_from: Vec<DVec3>,
    pub found_to: Vec<DVec3>,
    pub found_of: Vec<[u32; 3]>,
    /// Reach and band of the last search \[mm\].
    pub found_within: [f64; 2],
    /// Restriction of the last search to parts of different bodies.
    pub found_between: bool,
    /// Whether the pairs exceeded the limit of the search; the list is then empty.
    pub are_too_many: bool,
    /// Whether all of them were proved apart on these ways.
    pub are_apart: bool,
    /// Candidates of the searches.
    pub candidates: Candidates,
    /// Rows of the triangles along a Morton curve, the order of the search tree.
    pub order: Vec<u32>,
    /// Pairs that repel each other in the last solve.
    pub touching: u32,
    /// Largest number of vertices held back in one pass of the step, where no solve had kept the layers apart.
    pub held_back: u32,
    /// Whether the search or the work ended at its limit in a pass of the step, so that the body moved as one.
    pub moved_as_one: bool,
    /// Pairs of triangles that met in the last search, those beyond the band.
    pub met: usize,
    /// Box tests since the work was last counted; a pair's proof is some of them.
    pub tests: usize,
    /// Pairs of triangles that had passed through each other at the start of the step, in ascending order.
    pub crossed: Vec<[u32; 2]>,
    /// Springs to other bodies in the last solve, and triangles of others that had been passed through.
    pub touching_others: u32,
    pub overlapping_others: u32,
}

/// Bodies that may touch each other in a step, kept by the first of them. *Derived.*
#[derive(Clone, Debug, Default)]
pub(crate) struct BodyGroup {
    /// The bodies, in the order of spawning.
    pub bodies: Vec<Entity>,
    /// Contact of their layers, with vertices and triangles numbered body after body.
    pub layers: Layers,
    /// Springs between bodies at the evaluation, with their forces \[N\]; rows are numbered likewise.
    pub springs: Vec<(PairSpring, f64)>,
    /// Number of the first vertex of every body.
    pub first: Vec<u32>,
}
