//! How the triangles are cut into blocks, each with its own list of vertices, so that blocks run side by side and every sum has
//! one order.
//!
//! A block writes to its own segment of one buffer; afterwards every vertex sums the terms of its blocks, in their order.
//! The cut depends on the triangles alone, never on the number of threads.

use super::empty;
use crate::systems::kernels::pack::{LANES, Places};
use std::ops::Range;

/// Triangles of a block: its two local vectors (16 bytes for each of some 1,100 vertices) stay in the first cache, and a
/// sheet of 5,000 still has a block for either of two threads.
const PARTITION_BLOCK: usize = 2048;

/// First triangle of the second subdomain: half of the blocks of triangles belong to each of two threads.
pub(super) fn cut(triangle_count: usize) -> u32 {
    (triangle_count.div_ceil(PARTITION_BLOCK) / 2 * PARTITION_BLOCK) as u32
}

/// Whether a subdomain may begin with this triangle.
pub(super) fn is_cut(triangle: u32) -> bool {
    (triangle as usize).is_multiple_of(PARTITION_BLOCK)
}

/// Packs per block of triangles.
const PACKS: usize = PARTITION_BLOCK / LANES;

/// No triangle in this lane.
pub(super) const EMPTY: u32 = u32::MAX;

/// Blocks of triangles, and the vertices that each has.
#[derive(Debug, Default)]
pub(super) struct Partition {
    /// Number of triangles.
    count: usize,
    /// Places of the corners in the block's list of vertices.
    pub places: Vec<Places>,
    /// First pack of every block; one more entry at the end.
    pub pack_start: Vec<u32>,
    /// First entry of every block in `vertex`; one more entry at the end.
    pub vertex_start: Vec<u32>,
    /// The vertices of the blocks.
    pub vertex: Vec<u32>,
    /// First entry of every vertex in `source`; one more entry at the end.
    pub source_start: Vec<u32>,
    /// Where the blocks leave their terms for the vertex, in the order of blocks: a block's segment holds its sums, then as
    /// many values.
    pub source: Vec<u32>,
}

impl Partition {
    /// Cuts the triangles anew. `number` gives the vertices their rows in the vectors.
    pub(super) fn rebuild(&mut self, corners: &[[u32; 3]], number: &[u32]) {
        let (block_count, pack_count) = (corners.len().div_ceil(PARTITION_BLOCK), corners.len().div_ceil(LANES));
        self.count = corners.len();
        empty(&mut self.places, pack_count);
        // Some vertices are in several blocks.
        empty(&mut self.vertex, number.len() + number.len() / 4);
        empty(&mut self.pack_start, block_count + 1);
        empty(&mut self.vertex_start, block_count + 1);
        // Here: per vertex its entry in the block at hand.
        empty(&mut self.source_start, number.len() + 1);
        self.source_start.resize(number.len() + 1, EMPTY);
        for (block, of_block) in corners.chunks(PARTITION_BLOCK).enumerate() {
            self.pack_start.push((block * PACKS) as u32);
            self.vertex_start.push(self.vertex.len() as u32);
            self.add_block(of_block, number);
        }
        self.pack_start.push(pack_count as u32);
        self.vertex_start.push(self.vertex.len() as u32);
        self.find_sources(number.len());
    }

    /// All blocks of triangles.
    pub(super) fn all_blocks(&self) -> Range<usize> {
        0..self.pack_start.len() - 1
    }

    /// The triangles of a block: first those of its packs' first lane, pack after pack, then those of the next one.
    pub(super) fn triangles_of(&self, block: usize) -> Range<u32> {
        let first = block * PARTITION_BLOCK;
        first as u32..(first + self.of_block(first)) as u32
    }

    /// The blocks before a [`cut`], and the blocks from it on.
    pub(super) fn blocks_of_subdomains(&self, cut: u32) -> [Range<usize>; 2] {
        let all = self.all_blocks();
        let second = (cut as usize / PARTITION_BLOCK).min(all.end);
        [0..second, second..all.end]
    }

    /// Triangles in the block that begins with this one.
    fn of_block(&self, first: usize) -> usize {
        (self.count - first).min(PARTITION_BLOCK)
    }

    /// The triangles in the lanes of a pack; [`EMPTY`] where there is none. Triangles that follow each other share vertices: side by side they
    /// would wait for each other's sums. The lanes of a pack are as far apart as they can be.
    #[inline(always)]
    pub(super) fn triangles(&self, pack: usize) -> [u32; LANES] {
        let (first, within) = (pack / PACKS * PARTITION_BLOCK, pack % PACKS);
        let count = self.of_block(first);
        let apart = count.div_ceil(LANES);
        std::array::from_fn(|lane| {
            let t = within + lane * apart;
            if t < count { (first + t) as u32 } else { EMPTY }
        })
    }

    /// The pack and lane of a triangle.
    pub(super) fn place_of(&self, triangle: u32) -> (usize, usize) {
        let (block, within) = (triangle as usize / PARTITION_BLOCK, triangle as usize % PARTITION_BLOCK);
        let apart = self.of_block(block * PARTITION_BLOCK).div_ceil(LANES);
        (block * PACKS + within % apart, within / apart)
    }

    /// Number of triangles.
    pub(super) fn triangle_count(&self) -> usize {
        self.count
    }

    /// The rows of the corners of a triangle.
    pub(super) fn rows(&self, triangle: u32) -> [u32; 3] {
        let (pack, lane) = self.place_of(triangle);
        let start = self.vertex_start[triangle as usize / PARTITION_BLOCK];
        self.places[pack].map(|places| self.vertex[(start + u32::from(places[lane])) as usize])
    }

    /// Rows of the corners of all triangles, one after another.
    pub(super) fn all_rows(&self) -> impl Iterator<Item = [u32; 3]> + '_ {
        (0..self.count).step_by(PARTITION_BLOCK).zip(&self.vertex_start).flat_map(move |(first, &start)| {
            let (pack, count) = (first / PARTITION_BLOCK * PACKS, self.of_block(first));
            let apart = count.div_ceil(LANES);
            let all = (0..LANES).flat_map(move |lane| (pack..pack + apart).map(move |pack| (pack, lane)));
            let row = move |place: u16| self.vertex[(start + u32::from(place)) as usize];
            all.take(count).map(move |(pack, lane)| self.places[pack].map(|places| row(places[lane])))
        })
    }

    /// Number of packs, from the first on, that have the same triangles in their lanes as one of `before` triangles would. Where
    /// the number of triangles has changed, they are those before the block in which the last triangles stand.
    pub(super) fn packs_as_before(&self, before: usize) -> usize {
        if before == self.count { self.places.len() } else { before.min(self.count) / PARTITION_BLOCK * PACKS }
    }

    /// Adds a block; its vertices stand as triangle after triangle meets them, near each other those that are so.
    fn add_block(&mut self, corners: &[[u32; 3]], number: &[u32]) {
        let first_entry = self.vertex.len() as u32;
        let (first_pack, pack_count) = (self.places.len(), corners.len().div_ceil(LANES));
        self.places.resize(first_pack + pack_count, Places::default());
        for (t, corners) in corners.iter().enumerate() {
            let (pack, lane) = (first_pack + t % pack_count, t / pack_count);
            for (corner, v) in corners.iter().enumerate() {
                let v = number[*v as usize];
                let entry = &mut self.source_start[v as usize];
                // Entries of the blocks before are stale.
                if *entry == EMPTY || *entry < first_entry {
                    *entry = self.vertex.len() as u32;
                    self.vertex.push(v);
                }
                // At most three vertices for each triangle of a block: this fits.
                self.places[pack][corner][lane] = (*entry - first_entry) as u16;
            }
        }
    }

    /// Sorts the entries of the blocks by vertices.
    fn find_sources(&mut self, vertex_count: usize) {
        self.source_start.fill(0);
        for &v in &self.vertex {
            self.source_start[v as usize + 1] += 1;
        }
        for v in 0..vertex_count {
            self.source_start[v + 1] += self.source_start[v];
        }
        empty(&mut self.source, self.vertex.len());
        self.source.resize(self.vertex.len(), 0);
        for block in self.vertex_start.windows(2) {
            for i in block[0]..block[1] {
                let next = &mut self.source_start[self.vertex[i as usize] as usize];
                self.source[*next as usize] = block[0] + i;
                *next += 1;
            }
        }
        // Every start has moved on to that of the next vertex.
        self.source_start.rotate_right(1);
        self.source_start[0] = 0;
    }
}
