//! The instruction set of the loops, chosen when the program runs: one binary for every processor of a family.
//!
//! Code that runs inside [`wide`] is compiled once for the plain processor and once for the wide one (AVX2), and the compiler finds the
//! lanes by itself. Kernels are written as plain arithmetic on arrays of [`LANES`] numbers. A closure is compiled so only where it
//! is small enough to be inlined there; a loop that matters is a [`Kernel`], whose `run` always is. Multiplications and additions
//! are never contracted to one rounding, so every instruction set gives the same bits.

use super::lanes::{Lanes, Portable};
pub use pulp::NullaryFnOnce;
use std::cell::Cell;
#[cfg(target_arch = "x86_64")]
use std::marker::PhantomData;

/// Triangles that a kernel takes at a time.
pub const LANES: usize = 8;

thread_local! {
    static IS_PORTABLE: Cell<bool> = const { Cell::new(false) };
}

/// Makes this thread's loops use the instructions that every processor of the family has, or the best there are. Returns
/// the setting before.
pub fn force_portable(is_portable: bool) -> bool {
    IS_PORTABLE.replace(is_portable)
}

/// Runs a loop with the best instructions there are: a closure, or one that is too large to be inlined by itself and therefore
/// implements [`NullaryFnOnce`], marked `#[inline(always)]`.
#[inline]
pub fn wide<F: NullaryFnOnce>(f: F) -> F::Output {
    arch().dispatch(f)
}

/// The inner loop of a system: the data to fill a chunk of rows.
pub trait Kernel<T, S = ()>: Sync {
    /// Fills the rows from `first` on; returns their sum, or nothing. To be marked `#[inline(always)]`: a call that is not
    /// inlined leaves the wide instructions behind.
    fn run<L: Lanes>(&self, lanes: L, first: usize, rows: &mut [T]) -> S;
}

/// Runs a kernel with the best instructions there are.
#[inline]
pub fn run<T, S, K: Kernel<T, S>>(kernel: &K, first: usize, rows: &mut [T]) -> S {
    match arch() {
        #[cfg(target_arch = "x86_64")]
        pulp::Arch::V3(v3) => v3.vectorize(Chunk { lanes: v3, kernel, first, rows, sum: PhantomData }),
        _ => kernel.run(Portable, first, rows),
    }
}

/// A pass over the data it holds, row after row.
pub trait Pass {
    /// Result of the pass.
    type Output;

    /// Runs the pass. To be marked `#[inline(always)]`, as that of a kernel.
    fn run<L: Lanes>(self, lanes: L) -> Self::Output;
}

/// Does a pass with the best instructions there are.
#[inline]
pub fn pass<P: Pass>(pass: P) -> P::Output {
    match arch() {
        #[cfg(target_arch = "x86_64")]
        pulp::Arch::V3(v3) => v3.vectorize(WholePass { lanes: v3, pass }),
        _ => pass.run(Portable),
    }
}

/// A pass and its instruction set.
#[cfg(target_arch = "x86_64")]
struct WholePass<L, P> {
    lanes: L,
    pass: P,
}

#[cfg(target_arch = "x86_64")]
impl<L: Lanes, P: Pass> NullaryFnOnce for WholePass<L, P> {
    type Output = P::Output;

    #[inline(always)]
    fn call(self) -> P::Output {
        self.pass.run(self.lanes)
    }
}

fn arch() -> pulp::Arch {
    if IS_PORTABLE.get() { pulp::Arch::Scalar } else { pulp::Arch::new() }
}

/// A kernel, the rows to fill and the kind of its sum.
#[cfg(target_arch = "x86_64")]
struct Chunk<'a, L, K, T, S> {
    lanes: L,
    kernel: &'a K,
    first: usize,
    rows: &'a mut [T],
    sum: PhantomData<S>,
}

#[cfg(target_arch = "x86_64")]
impl<L: Lanes, S, K: Kernel<T, S>, T> NullaryFnOnce for Chunk<'_, L, K, T, S> {
    type Output = S;

    #[inline(always)]
    fn call(self) -> S {
        self.kernel.run(self.lanes, self.first, self.rows)
    }
}
