//! The operator in single precision: A = vertex blocks + Σ over triangles, as packs over blocks of triangles.

use super::between::Between;
use super::folding::BendingPacks;
use super::order::Order;
use super::partition::{EMPTY, Partition};
use super::vertex_blocks::VertexBlocks;
use super::{empty, size};
use crate::components::FreeAxes;
use crate::settings::Tangent;
use crate::systems::kernels::block::{self, Block};
use crate::systems::kernels::factor_block::FactorBlock;
use crate::systems::kernels::flat_block::{Coefficient, FlatBlock};
use crate::systems::kernels::flat_pack::FlatPack;
use crate::systems::kernels::lanes::Lanes;
use crate::systems::kernels::membrane::ElementTangent;
use crate::systems::kernels::pack::{LANES, Pack};
use crate::systems::kernels::simd::Kernel;
use crate::systems::parallel;
use crate::systems::solver::Operator;
use glam::{Mat4, Vec4};
use std::ops::Range;

/// Corners of the edges of a triangle: of the row of their block, and of its column.
pub(super) const EDGES: [[usize; 2]; 3] = [[1, 0], [2, 0], [2, 1]];

/// The numbers of the operator at one state. Rows are numbered as in the [`Partition`].
#[derive(Debug, Default)]
pub(super) struct Matrix {
    /// The triangles' part of a body in space.
    packs: Vec<Pack>,
    /// Packs of a planar body.
    flat_packs: Vec<FlatPack>,
    /// Whether it is of a planar body, of which nothing moves along z.
    pub is_flat: bool,
    /// Vertex blocks: masses and external stiffness.
    pub vertex_blocks: VertexBlocks,
    /// Per block of triangles the sums that it adds to its vertices, then their values.
    segments: Vec<Vec4>,
    /// Twice the starts of the blocks' vertices.
    segment_start: Vec<u32>,
    /// Bending, where there is any.
    folding: Option<Box<BendingPacks>>,
    /// Terms between vertices that no triangle joins, where there are any.
    pub between: Option<Box<Between>>,
}

impl Matrix {
    /// Assembles the numbers of the double-precision operator, those of the rotated tangent.
    pub(super) fn assemble(&mut self, operator: &Operator, partition: &Partition, order: &Order, free: &FreeAxes) {
        let vertex = &order.vertex;
        self.is_flat = operator.is_planar() && free.are_flat();
        if self.is_flat {
            size(&mut self.flat_packs, partition.places.len(), FlatPack::default());
            parallel::for_packs(&mut self.flat_packs, &Assembly { operator, partition });
        } else {
            size(&mut self.packs, partition.places.len(), Pack::default());
            parallel::for_packs(&mut self.packs, &Assembly { operator, partition });
        }
        self.vertex_blocks.assemble(self.is_flat, vertex.len(), |row| {
            let v = vertex[row] as usize;
            (operator.vertex_block(v), free[v])
        });
        Between::assemble(&mut self.between, operator, order, free);
        size(&mut self.segments, 2 * partition.vertex.len(), Vec4::ZERO);
        empty(&mut self.segment_start, partition.vertex_start.len());
        self.segment_start.extend(partition.vertex_start.iter().map(|start| 2 * start));
        match operator.folds {
            Some(folds) => {
                let corners = &operator.triangles.corners;
                self.folding.get_or_insert_default().assemble(folds, corners, partition, &order.row);
            }
            None => self.folding = None,
        }
    }

    /// Calls `diagonal(row, block)` and `edge((pack, edge, lane), rows, block)` for the 3×3 or 2×2 blocks of the triangles of some of the
    /// partition's blocks, pack by pack. The edges are [`EDGES`].
    #[inline(always)]
    pub(super) fn add_blocks<B: OfPacks>(
        &self,
        partition: &Partition,
        blocks: Range<usize>,
        mut diagonal: impl FnMut(usize, &B),
        mut edge: impl FnMut((usize, usize, usize), [usize; 2], &B),
    ) {
        for block in blocks {
            let vertices = &partition.vertex[partition.vertex_start[block] as usize..];
            for pack in partition.pack_start[block] as usize..partition.pack_start[block + 1] as usize {
                let (places, triangles) = (&partition.places[pack], partition.triangles(pack));
                for half in 0..2 {
                    let of_half = B::of_half(self, pack, half);
                    for i in 0..LANES / 2 {
                        let lane = half * (LANES / 2) + i;
                        let triangle = triangles[lane];
                        if triangle == EMPTY {
                            continue;
                        }
                        let (corners, edges) = B::of_lane(self, &of_half, i, triangle);
                        let rows = [0, 1, 2].map(|corner| vertices[places[corner][lane] as usize] as usize);
                        for (row, block) in rows.into_iter().zip(&corners) {
                            diagonal(row, block);
                        }
                        for (e, (ends, block)) in EDGES.into_iter().zip(&edges).enumerate() {
                            edge((pack, e, lane), ends.map(|corner| rows[corner]), block);
                        }
                    }
                }
            }
        }
    }

    /// `out` = A·u along free axes; returns u·(A·u). `u` is zero along prescribed axes.
    pub(super) fn apply(
        &mut self,
        partition: &Partition,
        u: &[Vec4],
        out: &mut [Vec4],
        partials: &mut Vec<f64>,
    ) -> f64 {
        let Self { packs, flat_packs, is_flat, vertex_blocks: own, segments, segment_start, folding, between } = self;
        if let Some(folding) = folding {
            folding.bend(u);
        }
        let folding = folding.as_deref();
        let product = if *is_flat {
            parallel::for_parts(segments, segment_start, &FlatBlocks { packs: flat_packs, partition, u });
            parallel::sum_chunks(out, partials, &Rows { own, blocks: &own.flat, segments, partition, u })
        } else {
            parallel::for_parts(segments, segment_start, &Blocks { packs, partition, u, folding });
            parallel::sum_chunks(out, partials, &Rows { own, blocks: &own.solid, segments, partition, u })
        };
        product + between.as_ref().map_or(0.0, |between| between.add(u, out, own))
    }
}

/// Blocks that a matrix has of its triangles, and of its vertices.
pub(super) trait OfPacks: FactorBlock {
    /// Blocks of four triangles: of their corners on the diagonal, and of their edges.
    type Half;

    /// Blocks of the first (0) or last (1) four triangles of a pack.
    fn of_half(matrix: &Matrix, pack: usize, half: usize) -> Self::Half;
    /// Blocks of one of the four triangles of a half.
    fn of_lane(matrix: &Matrix, half: &Self::Half, lane: usize, triangle: u32) -> ([Self; 3], [Self; 3]);
    /// The vertex block of a row.
    fn own(matrix: &Matrix, row: usize) -> Self;
}

impl OfPacks for Block {
    type Half = ([[Mat4; 3]; 3], [[Mat4; 3]; 3]);

    #[inline(always)]
    fn of_half(matrix: &Matrix, pack: usize, half: usize) -> Self::Half {
        if matrix.is_flat { matrix.flat_packs[pack].in_space().blocks(half) } else { matrix.packs[pack].blocks(half) }
    }

    #[inline(always)]
    fn of_lane(matrix: &Matrix, half: &Self::Half, lane: usize, triangle: u32) -> ([Self; 3], [Self; 3]) {
        let (mut corners, mut edges) = (of_lane(&half.0, lane), of_lane(&half.1, lane));
        if let Some(folding) = &matrix.folding {
            folding.add_blocks(triangle as usize, &mut corners, &mut edges);
        }
        (corners, edges)
    }

    #[inline(always)]
    fn own(matrix: &Matrix, row: usize) -> Self {
        let mut own =
            if matrix.is_flat { matrix.vertex_blocks.flat[row].in_space() } else { matrix.vertex_blocks.solid[row] };
        if let Some(pairs) = matrix.between.as_ref().and_then(|between| between.pair_blocks.get(row)) {
            block::add(&mut own, pairs);
        }
        own
    }
}

/// Of a [flat](Matrix::is_flat) matrix: such a body does not bend.
impl OfPacks for FlatBlock {
    type Half = ([Mat4; 3], [Mat4; 3]);

    #[inline(always)]
    fn of_half(matrix: &Matrix, pack: usize, half: usize) -> Self::Half {
        matrix.flat_packs[pack].blocks(half)
    }

    #[inline(always)]
    fn of_lane(_: &Matrix, (corners, edges): &Self::Half, lane: usize, _: u32) -> ([Self; 3], [Self; 3]) {
        let (mut of_corners, mut of_edges) = ([Self::ZERO; 3], [Self::ZERO; 3]);
        for i in 0..3 {
            of_corners[i] = Self::new(corners[i].col(lane));
            of_edges[i] = Self::new(edges[i].col(lane));
        }
        (of_corners, of_edges)
    }

    #[inline(always)]
    fn own(matrix: &Matrix, row: usize) -> Self {
        matrix.vertex_blocks.flat[row]
    }
}

/// The blocks of one lane; without a closure, which may not be inlined.
#[inline(always)]
fn of_lane(blocks: &[[Mat4; 3]; 3], lane: usize) -> [Block; 3] {
    let mut of_lane = [block::ZERO; 3];
    for (of_lane, block) in of_lane.iter_mut().zip(blocks) {
        *of_lane = [block[0].col(lane), block[1].col(lane), block[2].col(lane)];
    }
    of_lane
}

/// The packs of the operator's triangles.
struct Assembly<'a> {
    operator: &'a Operator<'a>,
    partition: &'a Partition,
}

/// A pack that is made of the tangents of up to eight triangles, those of a lane each.
trait OfElements {
    fn of<'a, L: Lanes>(lanes: L, turns: bool, element: impl Fn(usize) -> Option<ElementTangent<'a>>) -> Self;
}

impl OfElements for Pack {
    #[inline(always)]
    fn of<'a, L: Lanes>(lanes: L, turns: bool, element: impl Fn(usize) -> Option<ElementTangent<'a>>) -> Self {
        Self::new(lanes, turns, element)
    }
}

impl OfElements for FlatPack {
    #[inline(always)]
    fn of<'a, L: Lanes>(lanes: L, turns: bool, element: impl Fn(usize) -> Option<ElementTangent<'a>>) -> Self {
        Self::new(lanes, turns, element)
    }
}

impl Assembly<'_> {
    #[inline(always)]
    fn fill<'a, P: OfElements, L: Lanes>(
        &self,
        lanes: L,
        first: usize,
        packs: &mut [P],
        element: impl Fn(usize) -> ElementTangent<'a>,
    ) {
        let turns = matches!(self.operator.tangent, Tangent::Projected | Tangent::Weighted);
        for (p, pack) in (first..).zip(packs) {
            let triangles = self.partition.triangles(p);
            let of_lane = |lane: usize| (triangles[lane] != EMPTY).then(|| element(triangles[lane] as usize));
            *pack = P::of(lanes, turns, of_lane);
        }
    }
}

impl<P: OfElements> Kernel<P> for Assembly<'_> {
    #[inline(always)]
    fn run<L: Lanes>(&self, lanes: L, first: usize, packs: &mut [P]) {
        // A choice for every triangle would write its tangent down and read it again.
        match self.operator.tangent {
            Tangent::Exact => self.fill(lanes, first, packs, |t| self.operator.rotated_element(t)),
            Tangent::Weighted => self.fill(lanes, first, packs, |t| self.operator.weighted_element(t)),
            _ => self.fill(lanes, first, packs, |t| self.operator.plain_element(t)),
        }
    }
}

/// The product of each block of triangles with its vertices.
struct Blocks<'a> {
    packs: &'a [Pack],
    partition: &'a Partition,
    u: &'a [Vec4],
    folding: Option<&'a BendingPacks>,
}

/// Sums of zero and the values of a block's vertices, the halves of its segment; and the block's packs.
#[inline(always)]
fn begin<'a>(
    partition: &Partition,
    block: usize,
    u: &[Vec4],
    segment: &'a mut [Vec4],
) -> (&'a mut [Vec4], &'a [Vec4], Range<usize>) {
    let (out, local) = segment.split_at_mut(segment.len() / 2);
    let start = partition.vertex_start[block] as usize;
    for ((out, local), &v) in out.iter_mut().zip(local.iter_mut()).zip(&partition.vertex[start..]) {
        *out = Vec4::ZERO;
        *local = u[v as usize];
    }
    (out, local, partition.pack_start[block] as usize..partition.pack_start[block + 1] as usize)
}

impl Kernel<Vec4> for Blocks<'_> {
    #[inline(always)]
    fn run<L: Lanes>(&self, lanes: L, block: usize, segment: &mut [Vec4]) {
        let Self { packs, partition, u, folding } = self;
        let (out, local, packs_of) = begin(partition, block, u, segment);
        for (pack, places) in packs[packs_of.clone()].iter().zip(&partition.places[packs_of]) {
            Pack::scatter(places, pack.forces(lanes, places, local), out);
        }
        if let Some(folding) = folding {
            folding.add_forces(lanes, block, out);
        }
    }
}

/// Products of the blocks of triangles of a body in a plane.
struct FlatBlocks<'a> {
    packs: &'a [FlatPack],
    partition: &'a Partition,
    u: &'a [Vec4],
}

impl Kernel<Vec4> for FlatBlocks<'_> {
    #[inline(always)]
    fn run<L: Lanes>(&self, lanes: L, block: usize, segment: &mut [Vec4]) {
        let Self { packs, partition, u } = self;
        let (out, local, packs_of) = begin(partition, block, u, segment);
        for (pack, places) in packs[packs_of.clone()].iter().zip(&partition.places[packs_of]) {
            Pack::scatter(places, pack.forces(lanes, places, local), out);
        }
    }
}

/// The sums of the vertices' own terms and those of the blocks for them.
struct Rows<'a, B> {
    own: &'a VertexBlocks,
    /// Of the kind of the body.
    blocks: &'a [B],
    segments: &'a [Vec4],
    partition: &'a Partition,
    u: &'a [Vec4],
}

impl<B: Coefficient> Kernel<Vec4, f64> for Rows<'_, B> {
    #[inline(always)]
    fn run<L: Lanes>(&self, _: L, first: usize, rows: &mut [Vec4]) -> f64 {
        let Self { own, blocks, segments, partition, u } = self;
        let mut product = 0.0;
        for (i, out) in rows.iter_mut().enumerate() {
            let v = first + i;
            let mut sum = B::only_axes(blocks[v].times(u[v]));
            let sources = partition.source_start[v] as usize..partition.source_start[v + 1] as usize;
            for &source in &partition.source[sources] {
                sum += segments[source as usize];
            }
            *out = sum * own.free(v);
            product += dot(u[v], *out);
        }
        product
    }
}

/// The scalar product, summed in double precision: that of millions of rows is to have more digits than one row.
#[inline(always)]
pub(super) fn dot(a: Vec4, b: Vec4) -> f64 {
    let p = (a * b).as_dvec4();
    (p.x + p.y) + p.z
}
