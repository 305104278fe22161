//! The instruction set of the loops, chosen when the program runs: one binary for every processor of a family.
//!
//! A loop that runs inside [`wide`] is compiled once for the plain processor and once for the wide one (AVX2), and the compiler
//! finds the lanes by itself: kernels are written as plain arithmetic on arrays of [`LANES`] numbers. Multiplications and
//! additions are never contracted to one rounding, so every instruction set gives the same bits.

use std::cell::Cell;

/// Triangles that a kernel takes at a time.
pub const LANES: usize = 8;

thread_local! {
    static IS_PORTABLE: Cell<bool> = const { Cell::new(false) };
}

/// Makes this thread's loops use the instructions that every processor of the family has, or the best there are. Returns
/// what was set before.
pub fn force_portable(is_portable: bool) -> bool {
    IS_PORTABLE.replace(is_portable)
}

/// Runs a loop with the best instructions there are.
#[inline]
pub fn wide<R>(f: impl FnOnce() -> R) -> R {
    let arch = if IS_PORTABLE.get() { pulp::Arch::Scalar } else { pulp::Arch::new() };
    arch.dispatch(f)
}
