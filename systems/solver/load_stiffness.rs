//! Load stiffness of follower pressure, which pushes p · A · n of every triangle, a third to each corner.
//!
//! The force f = p/6·(b − a) × (d − a) on each corner changes with the corners (Hibbitt 1979, "Some follower forces and load
//! stiffness"). Its change is ∂f/∂x_j·u = p/6·u × e_j with the edge e_j opposite to corner j. Summed over a closed surface, or one
//! with a held rim, that matrix is symmetric. It equals the sum of the triangles' symmetric parts (Schweizerhof, Ramm 1984,
//! "Displacement dependent pressure loads in nonlinear finite element analyses"). With a free rim it is not symmetric, and is left
//! out. For a strip with two free sides under pressure Newton's method took 19 iterations with its symmetric part alone, 14 without
//! it. At twice the pressure it found no equilibrium with that part.

use crate::components::FreeAxes;
use crate::storage::{NONE, Topology, Triangles, Vertices};
use glam::{DMat3, DVec3};

/// Part of a boundary edge's length along an axis up to which it has none along it.
const ACROSS: f64 = 1e-6;

/// Whether the load stiffness is not symmetric: some boundary edge d has ends that are free along two axes, and a part along the third.
/// The asymmetric part consists of products u·(d × w) of displacements of the ends. A rim in a plane of symmetry, in which it may move,
/// has none.
pub fn has_free_rim((vertices, triangles, topology): (&Vertices, &Triangles, &Topology), free: &FreeAxes) -> bool {
    let is_free = |[a, b]: [usize; 2]| {
        let edge = vertices.position[b] - vertices.position[a];
        let may_move = free[a].max(free[b]);
        (0..3).any(|k| edge[k].abs() > ACROSS * edge.length() && may_move[(k + 1) % 3] * may_move[(k + 2) % 3] != 0.0)
    };
    topology.neighbours.iter().zip(&triangles.corners).any(|(neighbours, corners)| {
        (0..3).any(|i| neighbours[i] == NONE && is_free([corners[i] as usize, corners[(i + 1) % 3] as usize]))
    })
}

/// The edges opposite to the corners `x` \[mm\] of a triangle, times a twelfth of the pressure \[MPa\]: the terms of its load stiffness.
#[inline]
pub fn edge_loads(x: [DVec3; 3], pressure: f64) -> [DVec3; 3] {
    [x[1] - x[2], x[2] - x[0], x[0] - x[1]].map(|edge| edge * (pressure / 12.0))
}

/// The product of a triangle's load stiffness, −½·(∂f/∂x + (∂f/∂x)ᵀ), with displacements of its corners.
#[inline]
pub fn load_product(edges: [DVec3; 3], u: [DVec3; 3]) -> [DVec3; 3] {
    let (turned, sum) = ((0..3).map(|j| edges[j].cross(u[j])).sum::<DVec3>(), u[0] + u[1] + u[2]);
    edges.map(|edge| turned - edge.cross(sum))
}

/// Block of corners `i` and `j` in a triangle's load stiffness \[N/mm\].
pub fn load_block(edges: &[DVec3; 3], i: usize, j: usize) -> DMat3 {
    let DVec3 { x, y, z } = edges[j] - edges[i];
    DMat3::from_cols(DVec3::new(0.0, z, -y), DVec3::new(-z, 0.0, x), DVec3::new(y, -x, 0.0))
}
