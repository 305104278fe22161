//! Pieces of work handed out to threads: cut in two again and again, so that each thread has a run of pieces side by side, the same ones
//! in every loop while none falls behind.

use super::pool;
use std::slice::ChunksMut;

/// Runs both closures, side by side where a thread has nothing else to do. Not generic: the code that rayon makes of a pair of closures is
/// many times as long as most of them.
pub(super) fn join(a: &mut (dyn FnMut() + Send), b: &mut (dyn FnMut() + Send)) {
    rayon::join(a, b);
}

/// Work that comes in pieces, one after the other.
pub(super) trait Cut: Send + Sized {
    /// Number of pieces.
    fn count(&self) -> usize;
    /// The pieces before that one, and those from it on.
    fn cut(self, piece: usize) -> (Self, Self);
}

/// Rows in pieces of so many.
pub(super) struct Rows<'a, T>(pub &'a mut [T], pub usize);

impl<'a, T> Rows<'a, T> {
    /// The pieces.
    pub(super) fn pieces(self) -> ChunksMut<'a, T> {
        self.0.chunks_mut(self.1)
    }
}

impl<T: Send> Cut for Rows<'_, T> {
    fn count(&self) -> usize {
        self.0.len().div_ceil(self.1)
    }

    fn cut(self, piece: usize) -> (Self, Self) {
        let (before, after) = self.0.split_at_mut((piece * self.1).min(self.0.len()));
        (Self(before, self.1), Self(after, self.1))
    }
}

/// Rows of which part `p` has those from `starts[p]` up to `starts[p + 1]`.
pub(super) struct Parts<'a, T>(pub &'a mut [T], pub &'a [u32]);

impl<T: Send> Cut for Parts<'_, T> {
    fn count(&self) -> usize {
        self.1.len().saturating_sub(1)
    }

    fn cut(self, piece: usize) -> (Self, Self) {
        let Self(rows, starts) = self;
        let (before, after) = rows.split_at_mut((starts[piece] - starts[0]) as usize);
        (Self(before, &starts[..=piece]), Self(after, &starts[piece..]))
    }
}

/// Two lists of as many pieces.
impl<A: Cut, B: Cut> Cut for (A, B) {
    fn count(&self) -> usize {
        self.0.count()
    }

    fn cut(self, piece: usize) -> (Self, Self) {
        let ((a, c), (b, d)) = (self.0.cut(piece), self.1.cut(piece));
        ((a, b), (c, d))
    }
}

/// Spans of pieces for each thread: so many that none waits long for another.
const SPANS: usize = 8;

/// Calls `run(first, pieces)` for all pieces, in one span or in several, of which each begins with its `first`.
pub(super) fn share<C: Cut>(pieces: C, is_shared: bool, run: &(impl Fn(usize, C) + Sync)) {
    let count = pieces.count();
    let most = if is_shared { count.div_ceil(SPANS * pool::thread_count()) } else { count };
    share_from(0, pieces, most, run);
}

fn share_from<C: Cut>(first: usize, pieces: C, most: usize, run: &(impl Fn(usize, C) + Sync)) {
    if pieces.count() <= most {
        return run(first, pieces);
    }
    let half = pieces.count() / 2;
    let (left, right) = pieces.cut(half);
    let (mut left, mut right) = (Some(left), Some(right));
    join(&mut || left.take().into_iter().for_each(|left| share_from(first, left, most, run)), &mut || {
        right.take().into_iter().for_each(|right| share_from(first + half, right, most, run))
    });
}

#[cfg(test)]
mod tests {
    use super::pool::Pool;
    use super::*;

    /// Calls `f` with either way to hand out, in pools of one to three threads.
    fn in_every_way(f: impl Fn(bool) + Sync) {
        for threads in 1..=3 {
            Pool::new(threads, false).unwrap().run(|| [false, true].map(&f));
        }
    }

    #[test]
    fn every_row_is_in_its_piece_once() {
        in_every_way(|is_shared| {
            for (count, size) in [(0, 8), (1, 8), (8, 8), (9, 8), (1000, 8), (1003, 1)] {
                let (mut rows, mut pieces) = (vec![0; count], vec![0; count.div_ceil(size)]);
                share((Rows(&mut rows, size), Rows(&mut pieces, 1)), is_shared, &|first, (rows, pieces)| {
                    for (p, (rows, piece)) in rows.pieces().zip(pieces.0).enumerate() {
                        *piece += rows.len();
                        rows.iter_mut().for_each(|row| *row += first + p + 1);
                    }
                });
                assert!(rows.iter().enumerate().all(|(i, row)| *row == i / size + 1), "{count} by {size}");
                assert!(pieces.iter().enumerate().all(|(p, rows)| *rows == size.min(count - p * size)));
            }
        });
    }

    #[test]
    fn every_part_has_its_rows_once_however_long_it_is() {
        in_every_way(|is_shared| {
            for count in [0, 1, 2, 77] {
                let starts: Vec<u32> = (0..=count).map(|p| p * p / 3).collect();
                let mut rows = vec![0; starts[count as usize] as usize];
                share(Parts(&mut rows, &starts), is_shared, &|first, Parts(rows, of_span)| {
                    assert_eq!(of_span, &starts[first..first + of_span.len()]);
                    assert_eq!(rows.len() as u32, of_span[of_span.len() - 1] - of_span[0]);
                    rows.iter_mut().for_each(|row| *row += 1);
                });
                assert!(rows.iter().all(|row| *row == 1), "{count} parts");
            }
        });
    }
}
