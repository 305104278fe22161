//! The speed of one core of the machine: what arithmetic and memory could do at best, measured in the run whose times it is to
//! scale.

use super::clock::Stopwatch;
use pulp::{Arch, Simd, WithSimd};
use rhexis::systems::kernels::simd::wide;
use std::hint::black_box;

/// Repetitions of each measurement, of which the fastest counts: the machine at its best, not what else it did.
const ROUNDS: usize = 7;
/// Numbers of each of the triad's three vectors: 32 MB, beyond the caches of most machines.
const TRIAD: usize = 4_000_000;
/// Rounds of the multiply-add loop: some 3 ms.
const LOOPS: u32 = 1_000_000;
/// Sums that do not wait for each other: enough for two units with a latency of four cycles each.
const CHAINS: usize = 12;

/// What one core does.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Yardsticks {
    /// Fused multiply-adds in single precision, each counted as two operations \[GFLOP/s\].
    pub fma_gflops: f64,
    /// `a = b + s·c` on vectors beyond the caches, 24 bytes per number (McCalpin's STREAM counts so) \[GB/s\].
    pub triad_gbs: f64,
}

impl Yardsticks {
    /// The core that the targets are stated for.
    pub const REFERENCE: Self = Self { fma_gflops: 115.0, triad_gbs: 22.0 };

    /// Measures this machine: a quarter of a second.
    pub fn measure() -> Self {
        Self { fma_gflops: fma(), triad_gbs: triad() }
    }

    /// By how much this core is faster than `other`: by arithmetic for a body that fits the caches, by memory for a larger one.
    pub fn over(&self, other: &Self, triangles: usize) -> f64 {
        if triangles <= MOST_IN_CACHE { self.fma_gflops / other.fma_gflops } else { self.triad_gbs / other.triad_gbs }
    }
}

/// A body of so many triangles lives in the caches: some 350 bytes per triangle, in the 8 MB that most machines have or more.
const MOST_IN_CACHE: usize = 20_000;

struct Fma;

impl WithSimd for Fma {
    type Output = (f32, usize);

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> Self::Output {
        // Each chain tends to 2: no overflow, no number so small that the processor slows down.
        let (factor, add) = (simd.splat_f32s(black_box(0.5)), simd.splat_f32s(black_box(1.0)));
        let mut sums: [S::f32s; CHAINS] = std::array::from_fn(|i| simd.splat_f32s(i as f32));
        for _ in 0..LOOPS {
            for sum in &mut sums {
                *sum = simd.mul_add_e_f32s(*sum, factor, add);
            }
        }
        let total = sums.into_iter().reduce(|a, b| simd.add_f32s(a, b)).map_or(0.0, |sum| simd.reduce_sum_f32s(sum));
        (total, S::F32_LANES)
    }
}

fn fma() -> f64 {
    let rate = || {
        let watch = Stopwatch::start();
        let (total, lanes) = Arch::new().dispatch(Fma);
        let ms = watch.elapsed().thread;
        black_box(total);
        2e-6 * (lanes * CHAINS) as f64 * f64::from(LOOPS) / ms
    };
    (0..ROUNDS).map(|_| rate()).fold(0.0, f64::max)
}

fn triad() -> f64 {
    let (mut a, b, c) = (vec![0.0_f64; TRIAD], vec![1.0_f64; TRIAD], vec![2.0_f64; TRIAD]);
    let mut rate = || {
        let factor = black_box(0.5);
        let watch = Stopwatch::start();
        wide(|| {
            for ((a, b), c) in a.iter_mut().zip(&b).zip(&c) {
                *a = *b + factor * *c;
            }
        });
        let ms = watch.elapsed().thread;
        black_box(&mut a);
        1e-6 * 24.0 * TRIAD as f64 / ms
    };
    (0..ROUNDS).map(|_| rate()).fold(0.0, f64::max)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn large_bodies_are_scaled_by_memory() {
        let twice = Yardsticks { fma_gflops: 230.0, triad_gbs: 66.0 };
        assert_eq!(twice.over(&Yardsticks::REFERENCE, 1_500), 2.0);
        assert_eq!(twice.over(&Yardsticks::REFERENCE, 150_000), 3.0);
    }
}
