//! Pieces of work handed out to threads: cut in two again and again, so that each thread has a run of pieces side by side, the same ones
//! in every loop while none falls behind.

use super::pool;
use std::slice::ChunksMut;

/// Does both, side by side where a thread has nothing else to do. Not generic: what rayon makes of a pair of closures is many times as
/// long as most of them.
pub fn join(a: &mut (dyn FnMut() + Send), b: &mut (dyn FnMut() + Send)) {
    rayon::join(a, b);
}

/// Work that comes in pieces, one after the other.
pub trait Cut: Send + Sized {
    /// The pieces before that one, and those from it on.
    fn cut(self, piece: usize) -> (Self, Self);
}

/// Rows in pieces of so many.
pub struct Rows<'a, T>(pub &'a mut [T], pub usize);

impl<'a, T> Rows<'a, T> {
    /// Number of pieces.
    pub fn count(&self) -> usize {
        self.0.len().div_ceil(self.1)
    }

    /// The pieces.
    pub fn pieces(self) -> ChunksMut<'a, T> {
        self.0.chunks_mut(self.1)
    }
}

impl<T: Send> Cut for Rows<'_, T> {
    fn cut(self, piece: usize) -> (Self, Self) {
        let (before, after) = self.0.split_at_mut((piece * self.1).min(self.0.len()));
        (Self(before, self.1), Self(after, self.1))
    }
}

/// Rows of which part `p` has those from `starts[p]` up to `starts[p + 1]`.
pub struct Parts<'a, T>(pub &'a mut [T], pub &'a [u32]);

impl<T: Send> Cut for Parts<'_, T> {
    fn cut(self, piece: usize) -> (Self, Self) {
        let Self(rows, starts) = self;
        let (before, after) = rows.split_at_mut((starts[piece] - starts[0]) as usize);
        (Self(before, &starts[..=piece]), Self(after, &starts[piece..]))
    }
}

impl<A: Cut, B: Cut> Cut for (A, B) {
    fn cut(self, piece: usize) -> (Self, Self) {
        let ((a, c), (b, d)) = (self.0.cut(piece), self.1.cut(piece));
        ((a, b), (c, d))
    }
}

/// Spans of pieces for each thread: so many that none waits long for another.
const SPANS: usize = 8;

/// Calls `run(first, pieces)` for all of so many pieces, in one span or in several, of which each begins with its `first`.
pub fn share<C: Cut>(count: usize, pieces: C, is_shared: bool, run: &(impl Fn(usize, C) + Sync)) {
    let most = if is_shared { count.div_ceil(SPANS * pool::thread_count()) } else { count };
    share_from(0, count, pieces, most, run);
}

fn share_from<C: Cut>(first: usize, count: usize, pieces: C, most: usize, run: &(impl Fn(usize, C) + Sync)) {
    if count <= most {
        return run(first, pieces);
    }
    let half = count / 2;
    let (left, right) = pieces.cut(half);
    let (mut left, mut right) = (Some(left), Some(right));
    join(&mut || left.take().into_iter().for_each(|left| share_from(first, half, left, most, run)), &mut || {
        right.take().into_iter().for_each(|right| share_from(first + half, count - half, right, most, run))
    });
}
