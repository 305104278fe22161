//! Bisection at longest edges, which keeps angles.
//!
//! To halve a triangle, go over its longest edge to the neighbour, over that one's longest edge to the next, and so on. Where two
//! triangles share the longest edge of both, or the boundary is met, that edge is split in the middle (Rivara 1997, "longest-edge
//! propagation path"). The mesh stays conforming, and its sizes graded. However often a triangle with smallest angle α is
//! halved so, no angle falls below arctan(sin α/(2 − cos α)) (Rosenberg, Stenger 1975): 21° for α = 25°, 9.7° for 10°. Thin
//! triangles left by tears are flipped before they get thinner.

use crate::storage::{Edit, NONE, measure::rest_corners};
use crate::systems::fracture::{Cutter, TearRefusal};

/// Edges count as equally long up to this part: roundings must not make mirror images different.
const EDGE_TIE: f64 = 1e-9;
/// Maximum length of a propagation path, in triangles. Edges grow along it, so only a hostile mesh has long ones.
const LONGEST_WAY: usize = 100;

impl Cutter<'_, '_> {
    /// Splits the last edge of a triangle's longest-edge propagation path at its middle; adds at most two triangles.
    ///
    /// # Errors
    /// Why it cannot be split, or would leave too small an angle; the mesh is as it was.
    pub fn bisect(&mut self, triangle: u32) -> Result<(), TearRefusal> {
        let start = self.scratch.records.len();
        let (triangle, edge) = self.edge_to_split(triangle);
        let before = self.smallest_across(triangle, edge);
        self.edit(&Edit::SplitEdge { triangle, edge, weight: 0.5 })?;
        self.relax(start, &[]);
        let angle = self.smallest_touched(start);
        if angle < self.quality.least.min(before) {
            self.roll_back(start);
            return Err(TearRefusal::NoRoom { angle });
        }
        Ok(())
    }

    /// Last edge of a triangle's longest-edge propagation path.
    fn edge_to_split(&self, triangle: u32) -> (u32, usize) {
        let (mut triangle, (mut edge, mut length)) = (triangle, self.longest_edge(triangle));
        for _ in 0..LONGEST_WAY {
            let next = self.mesh.topology.neighbours[triangle as usize][edge];
            if next == NONE {
                break;
            }
            let longest = self.longest_edge(next);
            if longest.1 <= length * (1.0 + EDGE_TIE) {
                break;
            }
            (triangle, (edge, length)) = (next, longest);
        }
        (triangle, edge)
    }

    /// The longest edge and its length \[mm\]; of equal ones the one between the lowest rows, from either side.
    fn longest_edge(&self, triangle: u32) -> (usize, f64) {
        let corners = self.mesh.triangles.corners[triangle as usize];
        let x = rest_corners(self.mesh.vertices, corners);
        let rows = |e: usize| (corners[e].min(corners[(e + 1) % 3]), corners[e].max(corners[(e + 1) % 3]));
        let mut best = (0, x[0].distance(x[1]));
        for edge in 1..3 {
            let length = x[edge].distance(x[(edge + 1) % 3]);
            let is_tie = (length - best.1).abs() <= EDGE_TIE * length;
            if (is_tie && rows(edge) < rows(best.0)) || (!is_tie && length > best.1) {
                best = (edge, length);
            }
        }
        best
    }

    /// The smallest rest angle \[rad\] of the triangles at an edge.
    fn smallest_across(&self, triangle: u32, edge: usize) -> f64 {
        let own = self.angle_of(triangle);
        match self.mesh.topology.neighbours[triangle as usize][edge] {
            NONE => own,
            other => own.min(self.angle_of(other)),
        }
    }
}
