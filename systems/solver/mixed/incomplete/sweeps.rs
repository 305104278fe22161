//! Application of an incomplete factor: the forward sweep with L, the backward sweep with its transpose, and the vector passes around them.

use super::super::cg::{Precondition, Vectors};
use super::super::dissection::Dissection;
use super::super::pattern::BlockPattern;
use super::{Incomplete, Numbers};
use crate::systems::kernels::factor_block::FactorBlock;
use crate::systems::kernels::lanes::{Doubles, Lanes, Singles};
use crate::systems::kernels::simd::{Pass, pass};
use crate::systems::parallel;
use glam::{DVec2, Vec4};

/// The least step of conjugate gradients with a sound factor: on the torn capsule they are longer than 1e-6. Where soft directions are but
/// rounding of stiff ones, L may grow without bound though no pivot tells, and steps are 1e-9 to 1e-19.
const LEAST_STEP: f64 = 1e-8;

impl Precondition for Incomplete {
    const LEAST_STEP: f64 = LEAST_STEP;

    fn forward_sweep(&mut self, alpha: f32, vectors: &mut Vectors) -> DVec2 {
        let Self { pattern, solid, flat, is_flat, dissection, .. } = self;
        if *is_flat {
            flat.forward_sweep(pattern, *dissection, alpha, vectors)
        } else {
            solid.forward_sweep(pattern, *dissection, alpha, vectors)
        }
    }

    fn backward_sweep(&mut self, beta: f32, vectors: &mut Vectors) {
        let Self { pattern, solid, flat, is_flat, dissection, .. } = self;
        if *is_flat {
            flat.backward_sweep(pattern, *dissection, beta, vectors);
        } else {
            solid.backward_sweep(pattern, *dissection, beta, vectors);
        }
    }
}

impl<B: FactorBlock> Numbers<B> {
    /// The blocks of a row and their columns.
    #[inline(always)]
    fn row<'a>(&'a self, pattern: &'a BlockPattern, i: usize) -> impl Iterator<Item = (&'a B::Pair, &'a [u32; 2])> {
        let blocks = pattern.before(i);
        let (columns, _) = pattern.column[blocks.clone()].as_chunks();
        self.lower[blocks.start / 2..blocks.end / 2].iter().zip(columns)
    }

    fn forward_sweep(
        &self,
        pattern: &BlockPattern,
        dissection: Dissection,
        alpha: f32,
        vectors: &mut Vectors,
    ) -> DVec2 {
        let Vectors { xr, p, q, z, .. } = vectors;
        let [second, separator] = [dissection.second, dissection.separator].map(|row| row as usize);
        let mut sums = [DVec2::ZERO; 3];
        let down = |first: usize, first_known: usize, xr: &mut [_], q: &mut [Vec4], z: &mut [Vec4]| {
            let p = &p[first..first + xr.len()];
            pass(ForwardSweep { pattern, factor: self, alpha, first, first_known, xr, p, q, z })
        };
        let [of_first, of_second, of_separator] = &mut sums;
        if dissection.are_cut() {
            let [xr, other_xr, _] = dissection.split(xr);
            let [q, other_q, _] = dissection.split(q);
            let [z, other_z, _] = dissection.split(z);
            parallel::both(
                separator,
                || *of_first = down(0, 0, xr, q, z),
                || *of_second = down(second, second, other_xr, other_q, other_z),
            );
        }
        *of_separator = down(separator, 0, &mut xr[separator..], &mut q[separator..], z);
        sums[0] + sums[1] + sums[2]
    }

    fn backward_sweep(&self, pattern: &BlockPattern, dissection: Dissection, beta: f32, vectors: &mut Vectors) {
        let Vectors { p, q, .. } = vectors;
        let [second, separator] = [dissection.second, dissection.separator].map(|row| row as usize);
        let up = |first: usize, first_known: usize, p: &mut [Vec4], all: &mut [Vec4]| {
            pass(BackwardSweep { pattern, factor: self, beta, first, first_known, p, all });
        };
        up(separator, 0, &mut p[separator..], q);
        if dissection.are_cut() {
            let [p, other_p, _] = dissection.split(p);
            let [q, other_q, _] = dissection.split(q);
            parallel::both(separator, || up(0, 0, p, q), || up(second, second, other_p, other_q));
        }
    }
}

/// The forward sweep, over the rows from `first` on.
struct ForwardSweep<'a, B: FactorBlock> {
    pattern: &'a BlockPattern,
    factor: &'a Numbers<B>,
    alpha: f32,
    first: usize,
    xr: &'a mut [[Vec4; 2]],
    p: &'a [Vec4],
    q: &'a mut [Vec4],
    /// From the row `first_known` on, which no column comes before.
    z: &'a mut [Vec4],
    first_known: usize,
}

impl<B: FactorBlock> Pass for ForwardSweep<'_, B> {
    type Output = DVec2;

    #[inline(always)]
    fn run<L: Lanes>(self, lanes: L) -> DVec2 {
        let Self { pattern, factor, alpha, first, xr, p, q, z, first_known } = self;
        let (mut rr, mut rz) = (Doubles::splat(lanes, 0.0), Doubles::splat(lanes, 0.0));
        for (i, (([x, r], p), q)) in xr.iter_mut().zip(p).zip(q).enumerate() {
            let i = first + i;
            *x += *p * alpha;
            *r -= *q * alpha;
            let mut sum = Singles::splat(lanes, 0.0);
            for (pair, &[j, k]) in factor.row(pattern, i) {
                sum = sum + B::times_pair(lanes, pair, z[j as usize - first_known], z[k as usize - first_known]);
            }
            let y = *r - B::total(sum);
            z[i - first_known] = y;
            // D⁻¹·y, from which the backward sweep subtracts; A·p has been used up.
            *q = B::only_axes(factor.inverse[i].times(y));
            rr = rr + Doubles::widened(lanes, *r * *r);
            rz = rz + Doubles::widened(lanes, y * *q);
        }
        let total = |sums: Doubles<L>| sums.to_array().iter().sum();
        DVec2::new(total(rr), total(rz))
    }
}

/// The backward sweep, over the rows from `first` on.
struct BackwardSweep<'a, B: FactorBlock> {
    pattern: &'a BlockPattern,
    factor: &'a Numbers<B>,
    beta: f32,
    first: usize,
    p: &'a mut [Vec4],
    /// From the row `first_known` on, which no column comes before.
    all: &'a mut [Vec4],
    first_known: usize,
}

impl<B: FactorBlock> Pass for BackwardSweep<'_, B> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes>(self, lanes: L) {
        let Self { pattern, factor, beta, first, p, all, first_known } = self;
        // Lᵀ by the rows of L: a row that is done is subtracted from those above it.
        for i in (0..p.len()).rev() {
            let z = B::only_axes(all[first + i - first_known]);
            for (pair, &[j, k]) in factor.row(pattern, first + i) {
                let [to_j, to_k] = B::times_pair_transposed(lanes, pair, z);
                all[j as usize - first_known] -= to_j;
                all[k as usize - first_known] -= to_k;
            }
            p[i] = z + p[i] * beta;
        }
    }
}
