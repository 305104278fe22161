//! Which vertices have a triangle in common, and which the fill of level one brings together.

use super::empty;
use crate::storage::Topology;
use std::iter::once;
use std::mem::take;

/// The neighbours of all vertices, each once, which every rebuild of orders and patterns reads many times. Scratch, in lists
/// that only edits use beside.
#[derive(Debug, Default)]
pub(super) struct Adjacency {
    /// First entry of every vertex in `vertex`; one more entry at the end. Empty until it is found.
    start: Vec<u32>,
    vertex: Vec<u32>,
}

impl Adjacency {
    /// Finds the neighbours, as the triangles around each vertex meet them.
    pub(super) fn rebuild(&mut self, corners: &[[u32; 3]], topology: &Topology) {
        let n = topology.incident.len();
        empty(&mut self.start, n + 1);
        // Three edges for each vertex of a surface, and each of them at both its ends.
        empty(&mut self.vertex, 6 * n);
        self.start.push(0);
        for v in 0..n as u32 {
            let first = self.vertex.len();
            for w in neighbours(v, corners, topology) {
                if !self.vertex[first..].contains(&w) {
                    self.vertex.push(w);
                }
            }
            self.start.push(self.vertex.len() as u32);
        }
    }

    /// In the room of these lists.
    pub(super) fn in_room([start, vertex]: [&mut Vec<u32>; 2]) -> Self {
        Self { start: take(start), vertex: take(vertex) }
    }

    /// Gives the room back, and with it the lists.
    pub(super) fn give_room(&mut self, [start, vertex]: [&mut Vec<u32>; 2]) {
        let Self { start: own_start, vertex: own_vertex } = take(self);
        (*start, *vertex) = (own_start, own_vertex);
    }

    /// Whether they are known.
    pub(super) fn is_found(&self) -> bool {
        !self.start.is_empty()
    }

    /// Number of vertices.
    pub(super) fn vertex_count(&self) -> usize {
        self.start.len() - 1
    }

    /// The neighbours of a vertex.
    #[inline]
    pub(super) fn of(&self, v: u32) -> impl Iterator<Item = u32> + '_ {
        self.vertex[self.start[v as usize] as usize..self.start[v as usize + 1] as usize].iter().copied()
    }
}

/// The neighbours of a vertex, most of them twice.
pub(super) fn neighbours<'a>(
    v: u32,
    corners: &'a [[u32; 3]],
    topology: &'a Topology,
) -> impl Iterator<Item = u32> + 'a {
    topology.incident[v as usize].iter().flat_map(move |&entry| {
        let (c, corner) = (corners[entry as usize / 3], entry as usize % 3);
        [c[(corner + 1) % 3], c[(corner + 2) % 3]]
    })
}

/// The vertices of the blocks before the diagonal in a vertex' row, many of them more than once. They are its neighbours that come
/// before it, and the fill of level one. That fill is the entries that eliminating each of these puts between the vertex and those of
/// their neighbours that come after them. `near` has the neighbours of a vertex.
#[inline]
pub(super) fn before_with_fill<I: Iterator<Item = u32>>(
    v: u32,
    row: &[u32],
    near: impl Fn(u32) -> I + Copy,
) -> impl Iterator<Item = u32> {
    let end = row[v as usize];
    let before = move |v: u32| near(v).filter(move |&w| row[w as usize] < end);
    before(v).flat_map(move |k| once(k).chain(before(k).filter(move |&w| row[w as usize] > row[k as usize])))
}
