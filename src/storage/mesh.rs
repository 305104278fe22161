//! A triangle mesh as it comes from a file or a generator, and the checks at the door.
//!
//! A mesh that [`TriangleMesh::check`] lets through is an oriented manifold with boundary. Every edge belongs to one or two triangles, two
//! triangles run their shared edge in opposite directions, and the triangles of a vertex form one fan.

use glam::DVec3;

use super::mesh_error::MOST_AT_VERTEX;
use super::{MeshError, NONE};
use crate::math::{is_direction, is_place};

/// Below this ratio of smallest altitude to longest edge a triangle counts as degenerate: its shape-function gradients have
/// lost more than half the digits of an `f64` by then.
pub const THINNEST: f64 = 1e-9;

/// Indexed triangle mesh with an optional fibre direction per triangle, as readers and generators give and a body takes it.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct TriangleMesh {
    /// Vertex positions \[mm\].
    pub positions: Vec<DVec3>,
    /// Corner indices, counter-clockwise.
    pub triangles: Vec<[u32; 3]>,
    /// One direction per triangle, if the source carries fibres; need not be unit, must not be zero.
    pub fibres: Option<Vec<DVec3>>,
}

impl TriangleMesh {
    /// Whether the mesh can be torn: finite, manifold, consistently oriented, without degenerate triangles, bowties and
    /// unused vertices. The first fault found is the error.
    pub fn check(&self) -> Result<(), MeshError> {
        self.check_positions()?;
        self.check_corners()?;
        self.check_valences()?;
        self.check_shapes()?;
        self.check_duplicates()?;
        let edges = SharedEdges::new(&self.triangles)?;
        if let Some(edge) = edges.0.iter().find(|edge| edge.same_way) {
            let [first, second] = edge.triangles.map(|t| t as usize);
            return Err(MeshError::InconsistentOrientation { edge: edge.ends, first, second });
        }
        self.check_fans(&edges)?;
        self.check_fibres()
    }

    /// Turns triangles over until neighbours run their shared edges in opposite directions. In each connected piece the fewer are turned,
    /// of as many those that differ from its first; in a closed piece those that face inwards. A turned triangle swaps its last two corners.
    ///
    /// # Errors
    /// For corners out of range, an edge of three triangles and a one-sided piece.
    pub fn oriented(mut self) -> Result<Self, MeshError> {
        self.check_corners()?;
        let edges = SharedEdges::new(&self.triangles)?;
        let (turned, pieces) = edges.sides(self.triangles.len())?;
        let is_wrong = self.pieces_to_turn(&edges, &turned, &pieces);
        for ((triangle, turned), piece) in self.triangles.iter_mut().zip(turned).zip(pieces) {
            if turned != is_wrong[piece as usize] {
                triangle.swap(1, 2);
            }
        }
        Ok(self)
    }

    /// For each piece whether the sense of its first triangle is the wrong one.
    fn pieces_to_turn(&self, edges: &SharedEdges, turned: &[bool], pieces: &[u32]) -> Vec<bool> {
        #[derive(Clone, Default)]
        struct Piece {
            triangles: usize,
            turned: usize,
            shared: usize,
            volume: f64,
            centre: DVec3,
        }
        let mut of = vec![Piece::default(); pieces.iter().max().map_or(0, |last| *last as usize + 1)];
        edges.0.iter().for_each(|edge| of[pieces[edge.triangles[0] as usize] as usize].shared += 1);
        let at = |corner: u32| self.positions[corner as usize];
        for (triangle, &piece) in pieces.iter().enumerate() {
            let piece = &mut of[piece as usize];
            // About a point of its own, so that its distance from the origin takes no digits.
            if piece.triangles == 0 {
                piece.centre = at(self.triangles[triangle][0]);
            }
            let [a, b, c] = self.triangles[triangle].map(|corner| at(corner) - piece.centre);
            let volume = a.dot(b.cross(c));
            piece.volume += if turned[triangle] { -volume } else { volume };
            piece.triangles += 1;
            piece.turned += usize::from(turned[triangle]);
        }
        of.iter()
            .map(|piece| {
                let is_closed = 2 * piece.shared == 3 * piece.triangles;
                match is_closed && piece.volume != 0.0 && piece.volume.is_finite() {
                    true => piece.volume < 0.0,
                    false => 2 * piece.turned > piece.triangles,
                }
            })
            .collect()
    }

    /// Removes the vertices that no triangle uses; the others keep their order. Corners out of range are left for
    /// [`check`](Self::check) to report.
    ///
    /// ```
    /// use rhexis::{glam::DVec3, storage::TriangleMesh};
    /// let positions = vec![DVec3::NEG_X, DVec3::ZERO, DVec3::X, DVec3::Y];
    /// let mesh = TriangleMesh { positions, triangles: vec![[1, 2, 3]], fibres: None };
    /// assert!(mesh.check().is_err());
    /// let mesh = mesh.without_unused_vertices();
    /// assert_eq!((mesh.check(), mesh.positions.len()), (Ok(()), 3));
    /// ```
    pub fn without_unused_vertices(mut self) -> Self {
        let mut row = vec![NONE; self.positions.len()];
        for &corner in self.triangles.iter().flatten() {
            match row.get_mut(corner as usize) {
                Some(used) => *used = 0,
                None => return self,
            }
        }
        for (next, row) in row.iter_mut().filter(|row| **row != NONE).enumerate() {
            *row = next as u32;
        }
        let mut kept = row.iter();
        self.positions.retain(|_| kept.next().is_some_and(|&row| row != NONE));
        for corner in self.triangles.iter_mut().flatten() {
            *corner = row[*corner as usize];
        }
        self
    }

    fn check_positions(&self) -> Result<(), MeshError> {
        for (what, count) in [("vertices", self.positions.len()), ("triangles", self.triangles.len())] {
            if count == 0 {
                return Err(MeshError::Empty(what));
            }
            if count >= NONE as usize {
                return Err(MeshError::TooLarge { what, count });
            }
        }
        match self.positions.iter().position(|&p| !is_place(p)) {
            Some(vertex) => Err(MeshError::NonFinitePosition { vertex, position: self.positions[vertex] }),
            None => Ok(()),
        }
    }

    fn check_corners(&self) -> Result<(), MeshError> {
        let count = self.positions.len();
        for (triangle, &[a, b, c]) in self.triangles.iter().enumerate() {
            if let Some(&index) = [a, b, c].iter().find(|&&index| index as usize >= count) {
                return Err(MeshError::IndexOutOfRange { triangle, index, count });
            }
            if a == b || b == c || c == a {
                return Err(MeshError::RepeatedCorner { triangle, vertex: if a == b { a } else { c } });
            }
        }
        Ok(())
    }

    /// No vertex has more triangles than may go round it; corners are in range.
    fn check_valences(&self) -> Result<(), MeshError> {
        let mut counts = vec![0_usize; self.positions.len()];
        self.triangles.iter().flatten().for_each(|&corner| counts[corner as usize] += 1);
        match counts.iter().position(|&count| count > MOST_AT_VERTEX) {
            Some(vertex) => Err(MeshError::Crowded { vertex, triangles: counts[vertex] }),
            None => Ok(()),
        }
    }

    fn check_shapes(&self) -> Result<(), MeshError> {
        for (triangle, corners) in self.triangles.iter().enumerate() {
            let ratio = slenderness(corners.map(|corner| self.positions[corner as usize]));
            // Written so that NaN is refused too.
            if !matches!(ratio.partial_cmp(&THINNEST), Some(std::cmp::Ordering::Greater | std::cmp::Ordering::Equal)) {
                return Err(MeshError::Degenerate { triangle, ratio });
            }
        }
        Ok(())
    }

    fn check_duplicates(&self) -> Result<(), MeshError> {
        match by_corners(&self.triangles).windows(2).find(|pair| pair[0].0 == pair[1].0) {
            Some(pair) => Err(MeshError::Duplicate { first: pair[0].1, second: pair[1].1 }),
            None => Ok(()),
        }
    }

    /// One fan per vertex: the corners at a vertex, joined across shared edges, are one set.
    fn check_fans(&self, edges: &SharedEdges) -> Result<(), MeshError> {
        let mut sets: Vec<usize> = (0..3 * self.triangles.len()).collect();
        let corner_of = |triangle: u32, vertex: u32| {
            let place = self.triangles[triangle as usize].iter().position(|&corner| corner == vertex).unwrap_or(0);
            3 * triangle as usize + place
        };
        for edge in &edges.0 {
            for vertex in edge.ends {
                let [a, b] = edge.triangles.map(|triangle| root(&mut sets, corner_of(triangle, vertex)));
                sets[a.max(b)] = a.min(b);
            }
        }
        let mut fans = vec![0usize; self.positions.len()];
        for (corner, _) in sets.iter().enumerate().filter(|(corner, set)| *corner == **set) {
            fans[self.triangles[corner / 3][corner % 3] as usize] += 1;
        }
        match fans.iter().position(|&fans| fans != 1) {
            Some(vertex) if fans[vertex] == 0 => Err(MeshError::UnusedVertex { vertex }),
            Some(vertex) => Err(MeshError::Bowtie { vertex, fans: fans[vertex] }),
            None => Ok(()),
        }
    }

    fn check_fibres(&self) -> Result<(), MeshError> {
        let Some(fibres) = &self.fibres else { return Ok(()) };
        if fibres.len() != self.triangles.len() {
            return Err(MeshError::FibreCount { fibres: fibres.len(), triangles: self.triangles.len() });
        }
        match fibres.iter().position(|&fibre| !is_direction(fibre)) {
            Some(triangle) => Err(MeshError::BadFibre { triangle, fibre: fibres[triangle] }),
            None => Ok(()),
        }
    }
}

/// An edge with two triangles.
struct SharedEdge {
    /// Smaller index first.
    ends: [u32; 2],
    /// Earlier triangle first.
    triangles: [u32; 2],
    /// Whether both run the edge in the same direction, so that they face opposite ways.
    same_way: bool,
}

/// The edges with two triangles, in order of their ends.
struct SharedEdges(Vec<SharedEdge>);

impl SharedEdges {
    /// Needs corners in range. An edge with three or more triangles is an error.
    fn new(triangles: &[[u32; 3]]) -> Result<Self, MeshError> {
        let mut halves: Vec<([u32; 2], u32, bool)> = Vec::with_capacity(3 * triangles.len());
        for (triangle, &[a, b, c]) in triangles.iter().enumerate() {
            for [from, to] in [[a, b], [b, c], [c, a]] {
                halves.push(([from.min(to), from.max(to)], triangle as u32, from < to));
            }
        }
        halves.sort_unstable();
        let mut shared = Vec::with_capacity(halves.len() / 2);
        for group in halves.chunk_by(|a, b| a.0 == b.0) {
            match group {
                [a, b] => {
                    shared.push(SharedEdge { ends: a.0, triangles: [a.1, b.1], same_way: a.2 == b.2 });
                }
                [a, _, ..] => {
                    let triangles = group.iter().map(|half| half.1 as usize).collect();
                    return Err(MeshError::NonManifoldEdge { edge: a.0, triangles });
                }
                _ => {}
            }
        }
        Ok(Self(shared))
    }

    /// For each triangle whether it must be turned over to agree with the first of its piece, and the number of its piece.
    fn sides(&self, triangle_count: usize) -> Result<(Vec<bool>, Vec<u32>), MeshError> {
        let mut neighbours = vec![[NONE; 3]; triangle_count];
        for (number, edge) in self.0.iter().enumerate() {
            for triangle in edge.triangles {
                if let Some(slot) = neighbours[triangle as usize].iter_mut().find(|slot| **slot == NONE) {
                    *slot = number as u32;
                }
            }
        }
        let mut turned: Vec<Option<bool>> = vec![None; triangle_count];
        let mut pieces = vec![0; triangle_count];
        let mut piece_count = 0;
        let mut queue = Vec::new();
        for seed in 0..triangle_count {
            if turned[seed].is_some() {
                continue;
            }
            turned[seed] = Some(false);
            queue.push(seed as u32);
            piece_count += 1;
            while let Some(triangle) = queue.pop() {
                pieces[triangle as usize] = piece_count - 1;
                let side = turned[triangle as usize] == Some(true);
                for &number in neighbours[triangle as usize].iter().filter(|number| **number != NONE) {
                    let edge = &self.0[number as usize];
                    let other = edge.triangles[usize::from(edge.triangles[0] == triangle)];
                    let wanted = side != edge.same_way;
                    match turned[other as usize] {
                        None => {
                            turned[other as usize] = Some(wanted);
                            queue.push(other);
                        }
                        Some(side) if side != wanted => {
                            let [first, second] = edge.triangles.map(|t| t as usize);
                            return Err(MeshError::NotOrientable { edge: edge.ends, first, second });
                        }
                        Some(_) => {}
                    }
                }
            }
        }
        Ok((turned.into_iter().map(|turned| turned == Some(true)).collect(), pieces))
    }
}

/// Smallest altitude over longest edge, free of overflow: edges are scaled by the longest first.
pub fn slenderness([a, b, c]: [DVec3; 3]) -> f64 {
    let edges = [b - a, c - b, a - c];
    let scale = edges.iter().map(|edge| edge.abs().max_element()).fold(0.0, f64::max);
    if !(scale > 0.0 && scale.is_finite()) {
        return 0.0;
    }
    let edges = edges.map(|edge| edge / scale);
    let longest_sq = edges.iter().map(|edge| edge.length_squared()).fold(0.0, f64::max);
    edges[0].cross(edges[1]).length() / longest_sq
}

/// The smallest member of the set `at` belongs to, shortening the way for the next caller.
fn root(sets: &mut [usize], mut at: usize) -> usize {
    while sets[at] != at {
        sets[at] = sets[sets[at]];
        at = sets[at];
    }
    at
}

/// The triangles with their corners in ascending order, sorted by them and then by row: those of the same corners are neighbours.
pub fn by_corners(triangles: &[[u32; 3]]) -> Vec<([u32; 3], usize)> {
    let ascending = |(triangle, &corners): (usize, &[u32; 3])| {
        let mut corners = corners;
        corners.sort_unstable();
        (corners, triangle)
    };
    let mut sorted: Vec<_> = triangles.iter().enumerate().map(ascending).collect();
    sorted.sort_unstable();
    sorted
}

#[cfg(test)]
#[path = "mesh_tests.rs"]
mod tests;
