//! The order of the rows of the mixed-precision solver: reverse Cuthill–McKee, then by levels.
//!
//! Cuthill–McKee (1969, reversed by George 1971) keeps neighbours near each other whatever the order of the mesh. An incomplete
//! factor needs that: with rows in colours the iterations of one without fill are half as many again. A row's level is one more
//! than the highest among the rows before it that it has a block with. By levels the factor stays the same number for number, but
//! rows that follow each other do not wait for each other. In large bodies rows of a level stand by their length, so that the
//! processor foresees where a row ends; small ones lose by it more than they gain.

use super::adjacency::{Adjacency, before_with_fill};
use super::dissection::Dissection;
use super::empty;
use smallvec::SmallVec;

/// Rows that are sorted by levels among themselves. They are enough that those of a level keep the processor busy, and few enough
/// that rows near each other stay near on large meshes. All sorted, a product takes up to twice as long at 1.5 million triangles.
const WINDOW: usize = 1024;

/// Row lengths told apart, in pairs of blocks; longer rows count as the longest.
const LENGTHS: u32 = 16;

/// Triangles from which on the rows of a level are sorted by their length.
const LARGE: usize = 50_000;

/// The vertices in order, and back.
#[derive(Debug, Default)]
pub(super) struct Order {
    /// The vertex of every row.
    pub vertex: Vec<u32>,
    /// The row of every vertex.
    pub row: Vec<u32>,
    /// Triangles that edits have changed since the order was found.
    pub changed: usize,
    /// Rows that do not need each other.
    pub dissection: Dissection,
    /// Level of every vertex times [`LENGTHS`], in large bodies plus how many pairs of blocks its row has.
    level: Vec<u32>,
}

impl Order {
    /// Finds the order anew. From 1 on, `cut` is the first triangle from the cut of a [`Dissection`] on.
    pub(super) fn rebuild(&mut self, corners: &[[u32; 3]], adjacency: &Adjacency, cut: u32) {
        let n = adjacency.vertex_count();
        // Here: how often a vertex has been met, once to find the end of its piece to begin at, once to be numbered.
        empty(&mut self.level, n);
        self.level.resize(n, 0);
        empty(&mut self.vertex, n);
        for seed in 0..n as u32 {
            if self.level[seed as usize] == 0 {
                let first = self.vertex.len();
                self.walk(adjacency, seed, 1);
                let last = self.vertex.last().copied().unwrap_or(seed);
                self.vertex.truncate(first);
                self.walk(adjacency, last, 2);
            }
        }
        self.changed = 0;
        self.vertex.reverse();
        self.number();
        self.dissection = Dissection::default();
        if cut > 0 {
            self.cut(corners, cut);
            self.number();
        }
        self.sort_by_level(adjacency, corners.len() >= LARGE);
        self.number();
    }

    /// Sorts the rows into two subdomains and their separator.
    fn cut(&mut self, corners: &[[u32; 3]], cut: u32) {
        let Self { vertex, row, level, dissection, .. } = self;
        // Here: on which sides of the cut a vertex has triangles.
        level.fill(0);
        for (t, corners) in (0..).zip(corners) {
            corners.iter().for_each(|&v| level[v as usize] |= if t < cut { 1 } else { 2 });
        }
        vertex.sort_unstable_by_key(|&v| (level[v as usize], row[v as usize]));
        let first_of = |sides: u32| vertex.partition_point(|&v| level[v as usize] < sides) as u32;
        *dissection = Dissection { second: first_of(2), separator: first_of(3), cut };
    }

    /// The order with these vertices in its rows; `None` where they are not every one once.
    pub(super) fn of_vertices(vertex: &[u32], changed: usize, dissection: Dissection) -> Option<Self> {
        let mut row = vec![u32::MAX; vertex.len()];
        for (r, &v) in (0..).zip(vertex) {
            let place = row.get_mut(v as usize).filter(|row| **row == u32::MAX)?;
            *place = r;
        }
        Some(Self { vertex: vertex.to_vec(), row, changed, dissection, level: Vec::new() })
    }

    /// Keeps the rows of the vertices that there were before. New ones come last; the last rows of their subdomain or the separator
    /// take the places of those that are gone. Adds the vertices whose rows have changed to `moved`. A few rows at the end, all of
    /// whose neighbours come before them, hardly change the iterations; a new order is due before they are many. `changed` are the
    /// triangles with other corners than before.
    pub(super) fn follow(&mut self, vertex_count: usize, changed: &[u32], corners: &[[u32; 3]], moved: &mut Vec<u32>) {
        for v in self.row.len()..vertex_count {
            self.row.push(self.vertex.len() as u32);
            self.vertex.push(v as u32);
        }
        while self.row.len() > vertex_count {
            let Some(row) = self.row.pop() else { return };
            // It may be one that goes next that is moved.
            let last = self.vertex.len() - 1;
            let end = self.pass_on(row as usize, last, moved);
            self.vertex.truncate(end);
        }
        for &t in changed {
            for &v in &corners[t as usize] {
                let row = self.row[v as usize];
                if !self.dissection.may_have(t, row) {
                    let first_of_separator = self.pass_on(row as usize, self.dissection.separator as usize - 1, moved);
                    self.put(v, first_of_separator, moved);
                }
            }
        }
        moved.retain(|&v| (v as usize) < vertex_count);
    }

    /// Takes the vertex out of a row. The last of its subdomain goes there, the last of the next subdomain takes the place of that
    /// one, and so on, until the gap is at the row `to`. Returns that.
    fn pass_on(&mut self, gap: usize, to: usize, moved: &mut Vec<u32>) -> usize {
        let mut gap = gap;
        let Dissection { second, separator, .. } = self.dissection;
        for (part, end) in [second as usize, separator as usize].into_iter().enumerate() {
            if gap < end {
                if gap != end - 1 {
                    self.put(self.vertex[end - 1], gap, moved);
                }
                gap = end - 1;
                if part == 0 {
                    self.dissection.second -= 1;
                } else {
                    self.dissection.separator -= 1;
                }
            }
        }
        if gap != to {
            self.put(self.vertex[to], gap, moved);
        }
        to
    }

    /// Gives a vertex a row.
    fn put(&mut self, v: u32, row: usize, moved: &mut Vec<u32>) {
        self.vertex[row] = v;
        if let Some(of_v) = self.row.get_mut(v as usize).filter(|of_v| **of_v != row as u32) {
            *of_v = row as u32;
            moved.push(v);
        }
    }

    /// Appends the piece of `start`, nearest vertices first.
    fn walk(&mut self, adjacency: &Adjacency, start: u32, mark: u32) {
        let Self { vertex, level, .. } = self;
        let mut next = vertex.len();
        vertex.push(start);
        level[start as usize] = mark;
        while next < vertex.len() {
            for w in adjacency.of(vertex[next]) {
                if level[w as usize] < mark {
                    level[w as usize] = mark;
                    vertex.push(w);
                }
            }
            next += 1;
        }
    }

    fn number(&mut self) {
        empty(&mut self.row, self.vertex.len());
        self.row.resize(self.vertex.len(), 0);
        for (row, &v) in self.vertex.iter().enumerate() {
            self.row[v as usize] = row as u32;
        }
    }

    /// A row that comes before another and has a block with it has a lower level: sorted by levels it still comes before.
    fn sort_by_level(&mut self, adjacency: &Adjacency, is_large: bool) {
        let Self { vertex, row, level, dissection, .. } = self;
        let mut columns = SmallVec::<[u32; 32]>::new();
        for &v in &*vertex {
            let before = || before_with_fill(v, row, |v| adjacency.of(v));
            let of_row = before().map(|w| level[w as usize] / LENGTHS + 1).max().unwrap_or(0);
            let mut pairs = 0;
            if is_large {
                columns.clear();
                columns.extend(before());
                columns.sort_unstable();
                columns.dedup();
                pairs = (columns.len() as u32).div_ceil(2).min(LENGTHS - 1);
            }
            level[v as usize] = of_row * LENGTHS + pairs;
        }
        for rows in dissection.split(vertex).into_iter().flat_map(|part| part.chunks_mut(WINDOW)) {
            rows.sort_unstable_by_key(|&v| (level[v as usize], row[v as usize]));
        }
    }
}
