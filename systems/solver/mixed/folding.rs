//! Bending in single precision: the product in passes over packs of triangles, as in [`DihedralAngles`], and dihedrals for
//! preconditioners.
//!
//! A dihedral couples the two vertices opposite its edge, which are no neighbours. The pattern of a factor without fill and the
//! levels of multigrid have no place for that, and one with fill has not for all. The coupling is left out, and so much is added to
//! the two diagonal blocks that the remainder is semidefinite still. Without that, curvature would be negative along smooth shapes.

use super::partition::{EMPTY, Partition};
use super::{empty, size};
use crate::storage::NONE;
use crate::systems::bending::DihedralAngles;
use crate::systems::kernels::bending::EdgeMatrix;
use crate::systems::kernels::bending_pack::{BendingPack, NUMBERS};
use crate::systems::kernels::block::{self, Block};
use crate::systems::kernels::lanes::Lanes;
use crate::systems::kernels::pack::{LANES, Pack, Places};
use crate::systems::kernels::simd::Kernel;
use crate::systems::parallel;
use glam::{Vec4, Vec4Swizzles};

/// A triangle's part of its dihedrals.
#[derive(Clone, Copy, Debug, Default)]
struct Side {
    normal: Vec4,
    /// Minus the cotangents of the angles.
    minus_cotangent: [f32; 3],
    /// Half of one over the lengths of edges without [`NONE`] across.
    scale: [f32; 3],
    /// Per edge the tilts by the corner where it begins, where it ends and opposite, then the stiffness.
    edge: [Vec4; 3],
    /// The edges as they stand in the triangles across: three times the triangle plus the edge, or [`NONE`] without any stiffness.
    across: [u32; 3],
}

/// The bending part of the operator: of the triangles that bend or lie beside one that does, block by block.
#[derive(Debug, Default)]
pub(super) struct BendingPacks {
    packs: Vec<BendingPack>,
    /// Triangle of every lane; [`EMPTY`] where there is none.
    triangle: Vec<[u32; LANES]>,
    /// Places of the corners in the block's list of vertices.
    places: Vec<Places>,
    /// First pack of every block; one more entry at the end.
    pack_start: Vec<u32>,
    /// Sides of the triangles that are packed.
    sides: Vec<Side>,
    tilt: Vec<f32>,
    moment: Vec<f32>,
    /// Of every triangle its place in the lists of numbers; [`EMPTY`] without one.
    place: Vec<u32>,
    /// First number of every block of packs; one more entry at the end.
    start: Vec<u32>,
    /// The triangles of the block at hand.
    of_block: Vec<u32>,
}

impl BendingPacks {
    /// Takes the numbers of the majorant.
    pub(super) fn assemble(
        &mut self,
        folds: &DihedralAngles,
        corners: &[[u32; 3]],
        partition: &Partition,
        row: &[u32],
    ) {
        self.select(folds, corners.len(), partition);
        size(&mut self.sides, corners.len(), Side::default());
        parallel::for_rows(&mut self.sides, |t, side| {
            if folds.has_part(t) {
                *side = Side::new(folds, t);
            }
        });
        let Self { packs, sides, place, triangle, .. } = self;
        size(packs, triangle.len(), BendingPack::default());
        parallel::for_rows(packs, |p, pack| {
            *pack = BendingPack::default();
            for (lane, &t) in triangle[p].iter().enumerate() {
                for e in 0..3 {
                    pack.across[e][lane] = (p * NUMBERS + e * LANES + lane) as u32;
                }
                if t != EMPTY {
                    fill(pack, lane, &folds.law(t as usize), &sides[t as usize], place);
                    for corner in 0..3 {
                        pack.row[corner][lane] = row[corners[t as usize][corner] as usize];
                    }
                }
            }
        });
        let numbers = NUMBERS * self.triangle.len();
        for pass in [&mut self.tilt, &mut self.moment] {
            size(pass, numbers, 0.0);
        }
        empty(&mut self.start, self.pack_start.len());
        self.start.extend(self.pack_start.iter().map(|start| NUMBERS as u32 * start));
    }

    /// Packs the triangles that have a part in it: like those of the partition, neighbours far apart.
    fn select(&mut self, folds: &DihedralAngles, count: usize, partition: &Partition) {
        let Self { triangle, places, pack_start, place, of_block, .. } = self;
        empty(triangle, partition.places.len());
        empty(places, partition.places.len());
        empty(pack_start, partition.pack_start.len());
        empty(place, count);
        place.resize(count, EMPTY);
        pack_start.push(0);
        for block in partition.all_blocks() {
            of_block.clear();
            of_block.extend(partition.triangles_of(block).filter(|&t| folds.has_part(t as usize)));
            let (first, packs) = (triangle.len(), of_block.len().div_ceil(LANES));
            triangle.resize(first + packs, [EMPTY; LANES]);
            places.resize(first + packs, Places::default());
            for (i, &t) in of_block.iter().enumerate() {
                let (p, lane) = (first + i % packs, i / packs);
                triangle[p][lane] = t;
                place[t as usize] = (p * NUMBERS + lane) as u32;
                let (pack, from) = partition.place_of(t);
                for corner in 0..3 {
                    places[p][corner][lane] = partition.places[pack][corner][from];
                }
            }
            pack_start.push(triangle.len() as u32);
        }
    }

    /// The moments on every triangle by a displacement; [`add_forces`](Self::add_forces) has their forces then.
    pub(super) fn bend(&mut self, u: &[Vec4]) {
        let Self { packs, tilt, moment, start, pack_start, .. } = self;
        let first = &*pack_start;
        parallel::for_parts(tilt, start, &Tilts { packs, first, u });
        parallel::for_parts(moment, start, &Moments { packs, first, tilt });
    }

    /// Adds the forces on the corners of a block's triangles to those of its vertices.
    #[inline(always)]
    pub(super) fn add_forces<L: Lanes>(&self, lanes: L, block: usize, out: &mut [Vec4]) {
        for p in self.pack_start[block] as usize..self.pack_start[block + 1] as usize {
            Pack::scatter(&self.places[p], self.packs[p].forces(lanes, p, &self.moment), out);
        }
    }

    /// Adds the dihedrals of a triangle, half of those that it shares, to the blocks of its corners and of its edges 1–0, 2–0, 2–1.
    #[inline(always)]
    pub(super) fn add_blocks(&self, t: usize, corners: &mut [Block; 3], edges: &mut [Block; 3]) {
        if self.place[t] == EMPTY {
            return;
        }
        let side = &self.sides[t];
        for (e, [a, b, opposite]) in [[0, 1, 2], [1, 2, 0], [2, 0, 1]].into_iter().enumerate() {
            if side.across[e] == NONE {
                continue;
            }
            let across = side.across[e] as usize;
            let other = &self.sides[across / 3];
            let (own, far) = (side.edge[e], other.edge[across % 3]);
            // Corners where an edge begins and ends change places across it.
            let at_a = side.normal * own.xxxx() + other.normal * far.yyyy();
            let at_b = side.normal * own.yyyy() + other.normal * far.xxxx();
            let at_opposite = side.normal * own.zzzz();
            let stiffness = Vec4::splat(own.w + far.w);
            let lumped = if own.z > 0.0 { 1.0 + far.z / own.z } else { 0.0 };
            // The terms of its own edge and its two vertices come from the triangle across as well.
            let (half_a, half_b) = (at_a * stiffness * 0.5, at_b * stiffness * 0.5);
            let whole = at_opposite * stiffness;
            add_outer(&mut corners[a], half_a, at_a);
            add_outer(&mut corners[b], half_b, at_b);
            add_outer(&mut corners[opposite], whole * lumped, at_opposite);
            let mut between = |p: usize, of_p: Vec4, q: usize, of_q: Vec4| {
                let (row, column) = if p > q { (of_p, of_q) } else { (of_q, of_p) };
                add_outer(&mut edges[p + q - 1], row, column);
            };
            between(a, half_a, b, at_b);
            between(opposite, whole, a, at_a);
            between(opposite, whole, b, at_b);
        }
    }
}

impl Side {
    fn new(folds: &DihedralAngles, t: usize) -> Self {
        let (tilt, across) = (folds.tilt(t), folds.across(t));
        let mut side = Self {
            normal: tilt.normal.as_vec3().extend(0.0),
            minus_cotangent: tilt.minus_cotangent.as_vec3().to_array(),
            across: [NONE; 3],
            ..Self::default()
        };
        for e in 0..3 {
            let stiffness = folds.stiffness(t, e);
            let rate = |corner: usize| tilt.by_corner(e, corner % 3);
            let rates = [rate(e), rate(e + 1), rate(e + 2), 0.25 * stiffness];
            side.edge[e] = Vec4::from_array(rates.map(|x| x as f32));
            let n = across[e];
            if n != NONE && stiffness + folds.stiffness(n as usize / 3, n as usize % 3) > 0.0 {
                side.across[e] = n;
                side.scale[e] = (0.5 * tilt.inverse_length[e]) as f32;
            }
        }
        side
    }
}

/// Fills a lane of a pack, but for the rows.
#[inline(always)]
fn fill(pack: &mut BendingPack, lane: usize, law: &EdgeMatrix, side: &Side, place: &[u32]) {
    for e in 0..3 {
        pack.normal[e][lane] = side.normal[e];
        pack.minus_cotangent[e][lane] = side.minus_cotangent[e];
        if side.across[e] != NONE {
            let (t, edge) = (side.across[e] as usize / 3, side.across[e] % 3);
            pack.across[e][lane] = place[t] + edge * LANES as u32;
        }
    }
    for (i, [e, f]) in [[0, 0], [1, 1], [2, 2], [0, 1], [1, 2], [2, 0]].into_iter().enumerate() {
        pack.law[i][lane] = law[i] as f32 * (side.scale[e] * side.scale[f]);
    }
}

/// a += p·qᵀ.
#[inline(always)]
fn add_outer(a: &mut Block, p: Vec4, q: Vec4) {
    block::add(a, &[p * q.xxxx(), p * q.yyyy(), p * q.zzzz()]);
}

/// The tilts of each block of triangles.
struct Tilts<'a> {
    packs: &'a [BendingPack],
    /// First pack of every block.
    first: &'a [u32],
    u: &'a [Vec4],
}

impl Kernel<f32> for Tilts<'_> {
    #[inline(always)]
    fn run<L: Lanes>(&self, lanes: L, block: usize, tilts: &mut [f32]) {
        let packs = &self.packs[self.first[block] as usize..];
        for (pack, tilts) in packs.iter().zip(tilts.as_chunks_mut::<NUMBERS>().0) {
            pack.tilt(lanes, self.u, tilts);
        }
    }
}

/// The moments of each block of triangles.
struct Moments<'a> {
    packs: &'a [BendingPack],
    /// First pack of every block.
    first: &'a [u32],
    tilt: &'a [f32],
}

impl Kernel<f32> for Moments<'_> {
    #[inline(always)]
    fn run<L: Lanes>(&self, lanes: L, block: usize, moments: &mut [f32]) {
        let first = self.first[block] as usize;
        for (i, moments) in moments.as_chunks_mut::<NUMBERS>().0.iter_mut().enumerate() {
            self.packs[first + i].moment(lanes, first + i, self.tilt, moments);
        }
    }
}
