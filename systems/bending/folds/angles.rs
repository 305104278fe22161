//! Angles between the triangles of a body, four edges side by side.

use super::forces::size;
use super::is_first;
use crate::math::number::Real;
use crate::storage::NONE;
use crate::systems::kernels::bending;
use crate::systems::kernels::bending_lanes::EdgeValuesX4;
use crate::systems::kernels::formulas::{cross, dot, scaled};
use crate::systems::kernels::gather::{components, row};
use crate::systems::kernels::lanes::{DOUBLES, Doubles, Lanes};
use crate::systems::kernels::simd::Kernel;
use crate::systems::parallel;
use glam::DVec3;
use std::f64::consts::PI;

/// An edge between two triangles.
#[derive(Clone, Copy, Debug)]
pub(super) struct Edge {
    /// The edge in its first triangle and in the one across, each as three times the triangle's row plus the edge.
    sides: [u32; 2],
    /// Rest value of the dihedral angle.
    angle: f64,
}

impl Edge {
    /// The normals of its triangles, and its way as the first of them sees it.
    #[inline(always)]
    fn place(&self, corners: &[[u32; 3]], normal: &impl Fn(usize) -> DVec3, x: &impl Fn(usize) -> DVec3) -> [DVec3; 3] {
        let [(t, e), (n, _)] = self.sides.map(|side| (side as usize / 3, side as usize % 3));
        let [from, to] = [e, (e + 1) % 3].map(|corner| x(corners[t][corner] as usize));
        [normal(t), normal(n), to - from]
    }
}

/// The edges between triangles, each once: both of its triangles see an angle the same.
#[derive(Clone, Debug, Default)]
pub(super) struct Edges {
    edges: Vec<Edge>,
    /// The edges of every four triangles; at the boundary that after the last, which has zero.
    of_four: Vec<[[u32; DOUBLES]; 3]>,
}

impl Edges {
    /// Lists the edges of triangles with such rest angles and the same edges as those across have them.
    pub(super) fn list<'a>(&mut self, rest: impl ExactSizeIterator<Item = (&'a DVec3, [u32; 3])>) {
        let Self { edges, of_four } = self;
        edges.clear();
        of_four.clear();
        of_four.resize(rest.len().div_ceil(DOUBLES), [[NONE; DOUBLES]; 3]);
        for (t, (angle, across)) in rest.enumerate() {
            for e in 0..3 {
                if is_first(t, e, across[e]) {
                    let (n, f) = (across[e] as usize / 3, across[e] as usize % 3);
                    for (t, e) in [(t, e), (n, f)] {
                        of_four[t / DOUBLES][e][t % DOUBLES] = edges.len() as u32;
                    }
                    edges.push(Edge { sides: [(3 * t + e) as u32, across[e]], angle: angle[e] });
                }
            }
        }
        for edge in of_four.as_flattened_mut().as_flattened_mut() {
            *edge = (*edge).min(edges.len() as u32);
        }
    }

    /// Finds half the deviations of the dihedral angles from their rest values, for triangles with such normals and vertices at
    /// `x`.
    pub(super) fn find(
        &self,
        corners: &[[u32; 3]],
        normal: impl Fn(usize) -> DVec3 + Sync,
        x: impl Fn(usize) -> DVec3 + Sync,
        half: &mut Vec<f64>,
    ) {
        let count = self.edges.len();
        size(half, count);
        parallel::for_chunks(&mut half[..count], &Angles { edges: &self.edges, corners, normal, x });
    }

    /// Values at the edges of four triangles; zero at the boundary.
    #[inline(always)]
    pub(super) fn around(&self, four: usize, value: &[f64]) -> EdgeValuesX4 {
        let mut around = EdgeValuesX4::default();
        for e in 0..3 {
            for lane in 0..DOUBLES {
                around[e][lane] = value[self.of_four[four][e][lane] as usize];
            }
        }
        around
    }
}

/// Half the deviation of an edge's dihedral angle from its rest value: [`bending::angle`] where it is less than a right one.
struct Angles<'a, N, X> {
    edges: &'a [Edge],
    corners: &'a [[u32; 3]],
    normal: N,
    x: X,
}

impl<N: Fn(usize) -> DVec3 + Sync, X: Fn(usize) -> DVec3 + Sync> Kernel<f64> for Angles<'_, N, X> {
    #[inline(always)]
    fn run<L: Lanes>(&self, lanes: L, first: usize, out: &mut [f64]) {
        let Self { edges, corners, normal, x } = self;
        let [zero, half, one, minus] = [0.0, 0.5, 1.0, -1.0].map(|x| Doubles::splat(lanes, x));
        let largest = Doubles::splat(lanes, f64::MAX);
        let straight = Doubles::splat(lanes, PI);
        for (group, out) in out.chunks_mut(DOUBLES).enumerate() {
            let edges = &edges[first + group * DOUBLES..][..out.len()];
            let (mut rows, mut rest) = ([[row(lanes, DVec3::ZERO); DOUBLES]; 3], [0.0; DOUBLES]);
            for (lane, edge) in edges.iter().enumerate() {
                for (rows, vector) in rows.iter_mut().zip(edge.place(corners, normal, x)) {
                    rows[lane] = row(lanes, vector);
                }
                rest[lane] = edge.angle;
            }
            // Not by `map`, which is not inlined.
            let (a, b, way) = (components(rows[0]), components(rows[1]), components(rows[2]));
            let inverse = one / dot(way, way).sqrt();
            let (sine, cosine) = (minus * dot(cross(a, b), scaled(way, inverse)), dot(a, b));
            let off = bending::acute_angle(sine, cosine) - Doubles::new(lanes, rest);
            let has_way = inverse.is_larger(zero) && largest.is_larger(inverse);
            let is_short = straight.is_larger(off) && straight.is_larger(minus * off);
            if has_way && cosine.is_larger(zero) && is_short {
                out.copy_from_slice(&(half * off).to_array()[..out.len()]);
                continue;
            }
            for (edge, out) in edges.iter().zip(out) {
                let [a, b, way] = edge.place(corners, normal, x);
                *out = 0.5 * bending::shorter_way(bending::angle(a, b, way) - edge.angle);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    //! The lanes against one edge after another, on both instruction sets.

    use super::*;
    use crate::systems::kernels::simd::force_portable;

    #[test]
    fn lanes_agree_with_one_edge_after_another() {
        let wave = |i: usize, k: f64| (k * i as f64).sin();
        let direction = |i: usize, k: f64| DVec3::new(wave(i, 7.1), wave(i, 3.3), wave(i, 5.7)) * k;
        // Level within a hundredth, bent by some, by any angle; no normal, no edge, one without end.
        let normal = |t: usize| match t % 11 {
            10 => DVec3::ZERO,
            r => (DVec3::Z + direction(t, [0.01, 0.05, 3.0][r % 3])).normalize(),
        };
        let x = |v: usize| match v % 13 {
            0 | 1 => DVec3::ONE,
            2 => DVec3::splat(f64::INFINITY),
            _ => direction(v, 2.0),
        };
        let edge = |i: u32| Edge { sides: [3 * i + i % 3, 3 * i + 3], angle: 4.0 * wave(i as usize, 1.3) };
        let edges = Edges { edges: (0..1027).map(edge).collect(), of_four: Vec::new() };
        let corners: Vec<[u32; 3]> = (0..1027).map(|i| [i, i + 1, i + 2]).collect();
        let each = edges.edges.iter().map(|edge| {
            let [a, b, way] = edge.place(&corners, &normal, &x);
            0.5 * bending::shorter_way(bending::angle(a, b, way) - edge.angle)
        });
        let each: Vec<u64> = each.chain([0.0]).map(f64::to_bits).collect();
        let before = force_portable(true);
        for is_portable in [true, false] {
            force_portable(is_portable);
            let mut half = Vec::new();
            edges.find(&corners, normal, x, &mut half);
            let wide: Vec<u64> = half.iter().map(|x| x.to_bits()).collect();
            assert!(wide == each, "portable {is_portable}");
        }
        force_portable(before);
    }
}
