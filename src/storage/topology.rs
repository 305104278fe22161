//! Which triangles meet where: neighbours across edges, triangles around vertices.
//!
//! Invariant: both lists are functions of the corners alone. Two triangles are neighbours if and only if one has the
//! directed edge (u, v) and the other (v, u); the triangles around a vertex stand in ascending order. A list patched by
//! edits is therefore equal to a rebuilt one, entry by entry, and a sum gathered along it has the same bits.

use super::{Broken, EditLog, NONE, Triangles};
use smallvec::SmallVec;

/// The triangles around one vertex: entries 3·triangle + corner, ascending. Ten fit without a heap allocation: a tear
/// through a structured mesh leaves some vertices with nine or ten.
pub type Incidence = SmallVec<[u32; 10]>;

/// Neighbours and incidence of a body's triangles. *Derived.* Edge `e` of a triangle runs from corner `e` to corner `(e + 1) % 3`.
///
/// The topology also holds the log of the edits, on which derived data rely. Whoever writes corners in another way gives the body a
/// [new](Topology::new) topology.
#[derive(Clone, Debug, Default)]
pub struct Topology {
    /// Per triangle and edge the triangle on the other side, or [`NONE`] at the boundary.
    pub neighbours: Vec<[u32; 3]>,
    /// Per vertex the corners that lie on it.
    pub incident: Vec<Incidence>,
    /// Edits so far.
    pub(crate) log: EditLog,
}

/// A topology that has followed edits equals one found anew: the logs are not compared.
impl PartialEq for Topology {
    fn eq(&self, other: &Self) -> bool {
        self.neighbours == other.neighbours && self.incident == other.incident
    }
}

impl Eq for Topology {}

/// The triangles around a vertex in counter-clockwise order, as (triangle, corner of the vertex in it).
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Fan {
    /// The sectors. An open fan starts at the triangle whose first spoke is a boundary edge, a closed one at the lowest row.
    pub sectors: SmallVec<[(u32, usize); 12]>,
    /// Whether the last sector borders on the first: the vertex lies inside the surface.
    pub is_closed: bool,
}

impl Topology {
    /// The topology of triangles over `vertex_count` vertices.
    ///
    /// # Errors
    /// Refused unless the triangles form an oriented 2-manifold: every corner a vertex, three different corners per
    /// triangle, no directed edge twice, and exactly one fan around every vertex.
    pub fn new(vertex_count: usize, corners: &[[u32; 3]]) -> Result<Self, Broken> {
        let mut incident = vec![Incidence::new(); vertex_count];
        // (edge with its lower vertex first, entry): both sides of an edge become neighbours in the sorted list.
        let mut edges = Vec::with_capacity(3 * corners.len());
        for (triangle, c) in corners.iter().enumerate() {
            if let Some(&vertex) = c.iter().find(|&&v| v as usize >= vertex_count) {
                return Err(Broken::CornerRange { triangle: triangle as u32, vertex });
            }
            if c[0] == c[1] || c[1] == c[2] || c[2] == c[0] {
                return Err(Broken::RepeatedCorner { triangle: triangle as u32 });
            }
            for corner in 0..3 {
                let entry = 3 * triangle as u32 + corner as u32;
                incident[c[corner] as usize].push(entry);
                let (u, v) = (c[corner], c[(corner + 1) % 3]);
                edges.push((u.min(v), u.max(v), u > v, entry));
            }
        }
        edges.sort_unstable();
        let mut neighbours = vec![[NONE; 3]; corners.len()];
        for pair in edges.windows(2) {
            let (a, b) = (pair[0], pair[1]);
            if (a.0, a.1) != (b.0, b.1) {
                continue;
            }
            if a.2 == b.2 {
                let (from, to) = if a.2 { (a.1, a.0) } else { (a.0, a.1) };
                return Err(Broken::EdgeUsedTwice { from, to });
            }
            neighbours[(a.3 / 3) as usize][(a.3 % 3) as usize] = b.3 / 3;
            neighbours[(b.3 / 3) as usize][(b.3 % 3) as usize] = a.3 / 3;
        }
        let topology = Self { neighbours, incident, log: EditLog::default() };
        topology.check_fans()?;
        Ok(topology)
    }

    /// Makes room for an edit sequence that adds so many rows.
    pub fn reserve(&mut self, vertices: usize, triangles: usize) {
        self.incident.reserve_exact(vertices);
        self.neighbours.reserve_exact(triangles);
    }

    /// The counter-clockwise fan of triangles around a vertex.
    pub fn fan(&self, vertex: u32) -> Fan {
        let around = &self.incident[vertex as usize];
        let start = around.iter().find(|&&e| self.neighbours[(e / 3) as usize][(e % 3) as usize] == NONE);
        let Some(&first) = start.or(around.first()) else { return Fan::default() };
        let mut fan = Fan { sectors: SmallVec::new(), is_closed: false };
        let mut entry = first;
        // Bounded, so that a broken list cannot make the walk endless.
        for _ in 0..around.len() {
            let (triangle, corner) = (entry / 3, (entry % 3) as usize);
            fan.sectors.push((triangle, corner));
            let next = self.neighbours[triangle as usize][(corner + 2) % 3];
            let Some(&found) = around.iter().find(|&&e| e / 3 == next) else { return fan };
            if found == first {
                fan.is_closed = true;
                return fan;
            }
            entry = found;
        }
        fan
    }

    /// The triangle and edge that run from vertex `from` to vertex `to`.
    pub fn directed_edge(&self, corners: &[[u32; 3]], from: u32, to: u32) -> Option<(u32, usize)> {
        self.incident.get(from as usize)?.iter().find_map(|&entry| {
            let (triangle, corner) = (entry / 3, (entry % 3) as usize);
            (corners[triangle as usize][(corner + 1) % 3] == to).then_some((triangle, corner))
        })
    }

    /// Whether an edge joins the two vertices.
    pub(crate) fn is_edge(&self, corners: &[[u32; 3]], a: u32, b: u32) -> bool {
        self.directed_edge(corners, a, b).is_some() || self.directed_edge(corners, b, a).is_some()
    }

    /// Whether the vertex lies on the boundary: the outer rim or the lip of a tear.
    pub fn is_boundary_vertex(&self, vertex: u32) -> bool {
        self.boundary_entry(vertex).is_some()
    }

    /// The next vertex along the boundary, with the surface to the left. `None` for a vertex inside.
    pub fn next_boundary_vertex(&self, corners: &[[u32; 3]], vertex: u32) -> Option<u32> {
        let entry = self.boundary_entry(vertex)?;
        Some(corners[(entry / 3) as usize][(entry as usize + 1) % 3])
    }

    fn boundary_entry(&self, vertex: u32) -> Option<u32> {
        let around = self.incident.get(vertex as usize)?;
        around.iter().copied().find(|&e| self.neighbours[(e / 3) as usize][(e % 3) as usize] == NONE)
    }

    /// Rest area \[mm²\] of a vertex: a third of every triangle around it, in ascending order of rows.
    pub fn vertex_area(&self, triangles: &Triangles, vertex: u32) -> f64 {
        self.incident[vertex as usize].iter().map(|&e| triangles.rest[(e / 3) as usize].area / 3.0).sum()
    }

    /// Rest area of a vertex, and mean rest area of the triangles around it \[mm²\].
    ///
    /// # Examples
    /// ```
    /// # let (simulation, body) = rhexis::internal::example()?;
    /// # use rhexis::storage::{Topology, Triangles};
    /// let mut query = simulation.world().query_one::<(&Topology, &Triangles)>(body.entity());
    /// let (topology, triangles) = query.get()?;
    /// let (of_vertex, of_triangles) = topology.areas_at(triangles, 0);
    /// assert!(of_vertex > 0.0 && of_triangles > 0.0);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn areas_at(&self, triangles: &Triangles, vertex: u32) -> (f64, f64) {
        let area = self.vertex_area(triangles, vertex);
        (area, 3.0 * area / self.incident[vertex as usize].len().max(1) as f64)
    }

    /// The number of pieces that hang together across edges, and the piece of every triangle. Pieces are numbered by
    /// their lowest triangle.
    pub fn components(&self) -> (usize, Vec<u32>) {
        let mut piece = vec![NONE; self.neighbours.len()];
        let mut count = 0;
        let mut pending = Vec::new();
        for seed in 0..piece.len() {
            if piece[seed] != NONE {
                continue;
            }
            piece[seed] = count;
            pending.push(seed);
            while let Some(triangle) = pending.pop() {
                for &next in self.neighbours[triangle].iter().filter(|&&next| next != NONE) {
                    if piece[next as usize] == NONE {
                        piece[next as usize] = count;
                        pending.push(next as usize);
                    }
                }
            }
            count += 1;
        }
        (count as usize, piece)
    }

    /// Whether every vertex has exactly one fan.
    pub(super) fn check_fans(&self) -> Result<(), Broken> {
        for (vertex, around) in self.incident.iter().enumerate() {
            let vertex = vertex as u32;
            if around.is_empty() {
                return Err(Broken::LooseVertex { vertex });
            }
            if self.fan(vertex).sectors.len() != around.len() {
                return Err(Broken::Bowtie { vertex });
            }
        }
        Ok(())
    }

    pub(super) fn insert_incident(&mut self, triangle: u32, corner: usize, vertex: u32) {
        let around = &mut self.incident[vertex as usize];
        let entry = 3 * triangle + corner as u32;
        if let Err(place) = around.binary_search(&entry) {
            around.insert(place, entry);
        }
    }

    pub(super) fn remove_incident(&mut self, triangle: u32, corner: usize, vertex: u32) {
        let around = &mut self.incident[vertex as usize];
        if let Ok(place) = around.binary_search(&(3 * triangle + corner as u32)) {
            around.remove(place);
        }
    }

    /// Forgets the neighbours of a triangle, on both sides.
    pub(super) fn unlink(&mut self, triangle: u32) {
        let old = std::mem::replace(&mut self.neighbours[triangle as usize], [NONE; 3]);
        for neighbour in old.into_iter().filter(|&n| n != NONE) {
            for back in self.neighbours[neighbour as usize].iter_mut().filter(|back| **back == triangle) {
                *back = NONE;
            }
        }
    }

    /// Finds the neighbours of a triangle from the corners and sets them on both sides.
    pub(super) fn link(&mut self, corners: &[[u32; 3]], triangle: u32) {
        let c = corners[triangle as usize];
        for edge in 0..3 {
            if let Some((other, back)) = self.directed_edge(corners, c[(edge + 1) % 3], c[edge]) {
                self.neighbours[triangle as usize][edge] = other;
                self.neighbours[other as usize][back] = triangle;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_hexagon_has_a_closed_fan_and_a_ring_of_boundary() {
        let corners: Vec<[u32; 3]> = (0..6).map(|i| [0, 1 + i, 1 + (i + 1) % 6]).collect();
        let topology = Topology::new(7, &corners).unwrap();
        let fan = topology.fan(0);
        assert!(fan.is_closed);
        assert_eq!(fan.sectors.as_slice(), [(0, 0), (1, 0), (2, 0), (3, 0), (4, 0), (5, 0)]);
        assert!(!topology.is_boundary_vertex(0));
        let mut vertex = 1;
        for expected in [2, 3, 4, 5, 6, 1] {
            vertex = topology.next_boundary_vertex(&corners, vertex).unwrap();
            assert_eq!(vertex, expected);
        }
        assert_eq!(topology.fan(1).sectors.as_slice(), [(0, 1), (5, 2)]);
        assert_eq!(topology.components(), (1, vec![0; 6]));
    }

    #[test]
    fn what_is_no_manifold_is_named() {
        assert_eq!(Topology::new(3, &[[0, 1, 3]]), Err(Broken::CornerRange { triangle: 0, vertex: 3 }));
        assert_eq!(Topology::new(3, &[[0, 1, 1]]), Err(Broken::RepeatedCorner { triangle: 0 }));
        let twice = [[0, 1, 2], [0, 1, 3]];
        assert_eq!(Topology::new(4, &twice), Err(Broken::EdgeUsedTwice { from: 0, to: 1 }));
        let three = [[0, 1, 2], [1, 0, 3], [1, 0, 4]];
        assert_eq!(Topology::new(5, &three), Err(Broken::EdgeUsedTwice { from: 1, to: 0 }));
        let bowtie = [[0, 1, 2], [0, 3, 4]];
        assert_eq!(Topology::new(5, &bowtie), Err(Broken::Bowtie { vertex: 0 }));
        assert_eq!(Topology::new(4, &[[0, 1, 2]]), Err(Broken::LooseVertex { vertex: 3 }));
    }
}
