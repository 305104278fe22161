//! The only folder that names threads. Work is cut into chunks of rows that depend on the mesh alone, and sums add chunk by
//! chunk in order, so that every result has the same bits for any number of threads. Every chunk is a [`wide`] loop.

mod pool;
mod share;

use super::kernels::lanes::DOUBLES;
use super::kernels::simd::{Kernel, LANES, run, wide};
use hecs::{Query, World};
pub use pool::{Pool, is_worth_sharing};
use share::{Cut, Parts, Rows, join, share};
use std::iter::Sum;
use std::ops::{AddAssign, Range};
use std::sync::Mutex;

/// Rows per chunk: large enough that a chunk of the cheapest loop (a vector update, 1 ns a row) outweighs handing it to a
/// thread, small enough that 5,000 triangles still fill two cores.
const CHUNK: usize = 1024;

/// Calls `run` for every body of a query that has work to do, and returns their number. `work` is the work of a body, in
/// rows; with 0 the body is passed over. Several bodies that are worth it run side by side: no body sees another, so that
/// the result does not depend on which thread takes which.
pub fn for_bodies<Q: Query>(
    world: &mut World,
    work: impl Fn(&Q::Item<'_>) -> usize + Sync,
    run: impl Fn(Q::Item<'_>) + Sync,
) -> usize
where
    for<'a> Q::Item<'a>: Send,
{
    let works = world.query_mut::<Q>().into_iter().map(|body| work(&body)).filter(|&rows| rows > 0);
    let (count, rows) = works.fold((0, 0), |(count, sum), rows| (count + 1, sum + rows));
    if count == 0 {
        return 0;
    }
    let is_busy = |body: &Q::Item<'_>| work(body) > 0;
    if count == 1 || !is_worth_sharing(rows) {
        world.query_mut::<Q>().into_iter().filter(is_busy).for_each(run);
        return count;
    }
    let bodies = Mutex::new(world.query_mut::<Q>().into_iter_batched(1));
    let take = || bodies.lock().ok().and_then(|mut bodies| bodies.next());
    let worker = || {
        while let Some(body) = take() {
            body.filter(is_busy).for_each(&run);
        }
    };
    side_by_side(count.min(pool::thread_count()), &worker);
    count
}

/// Lets so many threads do the same.
fn side_by_side(count: usize, worker: &(dyn Fn() + Sync)) {
    if count < 2 {
        return worker();
    }
    join(&mut || side_by_side(count / 2, worker), &mut || side_by_side(count - count / 2, worker));
}

/// Calls `f(row, out)` for every row.
pub fn for_rows<T: Send>(out: &mut [T], f: impl Fn(usize, &mut T) + Sync) {
    for_slices(
        out,
        #[inline(always)]
        |first, rows| {
            for (i, value) in rows.iter_mut().enumerate() {
                f(first + i, value);
            }
        },
    );
}

/// Calls `f(first_row, rows)` for every chunk of rows: a kernel that takes several rows at a time. All chunks but the last
/// have a multiple of eight rows.
pub fn for_slices<T: Send>(out: &mut [T], f: impl Fn(usize, &mut [T]) + Sync) {
    let is_shared = is_worth_sharing(out.len());
    share(Rows(out, CHUNK), is_shared, &|first, rows| {
        rows.pieces().enumerate().for_each(|(c, rows)| {
            wide(
                #[inline(always)]
                || f((first + c) * CHUNK, rows),
            )
        });
    });
}

/// Calls `f(first_row, rows, others)` for every chunk of the rows of two lists of one length: rows that one loop has filled are still near
/// the processor when the next one reads them.
pub fn for_pairs<T: Send, U: Send>(a: &mut [T], b: &mut [U], f: impl Fn(usize, &mut [T], &mut [U]) + Sync) {
    let is_shared = is_worth_sharing(a.len());
    share((Rows(a, CHUNK), Rows(b, CHUNK)), is_shared, &|first, (a, b)| {
        a.pieces().zip(b.pieces()).enumerate().for_each(|(c, (a, b))| f((first + c) * CHUNK, a, b));
    });
}

/// Runs a kernel on every chunk of rows; all chunks but the last have a multiple of eight rows.
pub fn for_chunks<T: Send>(out: &mut [T], kernel: &impl Kernel<T>) {
    for_pieces(out, CHUNK, kernel);
}

/// Runs a kernel on every chunk of packs of eight rows.
pub fn for_packs<T: Send>(packs: &mut [T], kernel: &impl Kernel<T>) {
    let is_shared = is_worth_sharing(LANES * packs.len());
    in_pieces(Rows(packs, CHUNK / LANES), is_shared, kernel);
}

/// Runs a kernel on every chunk of groups of four rows.
pub fn for_x4<T: Send>(fours: &mut [T], kernel: &impl Kernel<T>) {
    let is_shared = is_worth_sharing(DOUBLES * fours.len());
    in_pieces(Rows(fours, CHUNK / DOUBLES), is_shared, kernel);
}

/// Does two things that take about as long as so many rows, side by side where that is worth it.
pub fn both(rows: usize, mut a: impl FnMut() + Send, mut b: impl FnMut() + Send) {
    if is_worth_sharing(rows) {
        join(&mut a, &mut b);
    } else {
        a();
        b();
    }
}

/// Runs a kernel on every piece of so many rows.
pub fn for_pieces<T: Send>(out: &mut [T], size: usize, kernel: &impl Kernel<T>) {
    let is_shared = is_worth_sharing(out.len());
    in_pieces(Rows(out, size), is_shared, kernel);
}

fn in_pieces<T: Send>(rows: Rows<T>, is_shared: bool, kernel: &impl Kernel<T>) {
    let size = rows.1;
    share(rows, is_shared, &|first, rows| {
        rows.pieces().enumerate().for_each(|(p, rows)| run(kernel, (first + p) * size, rows));
    });
}

/// Runs a kernel on every chunk of rows and adds up its results. `partials` is scratch; it grows once.
pub fn sum_chunks<T: Send, S: Copy + Default + Send + Sum>(
    out: &mut [T],
    partials: &mut Vec<S>,
    kernel: &impl Kernel<T, S>,
) -> S {
    sum_pieces(out, CHUNK, partials, kernel)
}

/// Runs a kernel on every piece of `size` rows and adds up its results. `partials` is scratch; it grows once.
pub fn sum_pieces<T: Send, S: Copy + Default + Send + Sum>(
    out: &mut [T],
    size: usize,
    partials: &mut Vec<S>,
    kernel: &impl Kernel<T, S>,
) -> S {
    sum_of(out, size, partials, |first, rows| run(kernel, first, rows))
}

/// Runs a kernel on every chunk of `count` groups of four rows and adds up its results. `partials` is scratch; it grows once.
pub fn sum_x4<S: Copy + Default + Send + Sum>(count: usize, partials: &mut Vec<S>, kernel: &impl Kernel<(), S>) -> S {
    sum_pieces(&mut vec![(); count], CHUNK / DOUBLES, partials, kernel)
}

/// Calls `f(row, out)` for every row and adds up its results, one number or several. `partials` is scratch; it grows once.
pub fn sum_rows<T: Send, S: Copy + Default + Send + AddAssign + Sum>(
    out: &mut [T],
    partials: &mut Vec<S>,
    f: impl Fn(usize, &mut T) -> S + Sync,
) -> S {
    sum_of(out, CHUNK, partials, |first, rows| {
        wide(
            #[inline(always)]
            || {
                let mut sum = S::default();
                for (i, value) in rows.iter_mut().enumerate() {
                    sum += f(first + i, value);
                }
                sum
            },
        )
    })
}

/// The sum of `of_piece(first_row, rows)` over pieces of so many rows.
fn sum_of<T: Send, S: Copy + Default + Send + Sum>(
    out: &mut [T],
    size: usize,
    partials: &mut Vec<S>,
    of_piece: impl Fn(usize, &mut [T]) -> S + Sync,
) -> S {
    let is_shared = is_worth_sharing(out.len());
    let rows = Rows(out, size);
    partials.clear();
    partials.resize(rows.count(), S::default());
    share((rows, Rows(partials, 1)), is_shared, &|first, (rows, partials)| {
        for (p, (rows, partial)) in rows.pieces().zip(partials.0).enumerate() {
            *partial = of_piece((first + p) * size, rows);
        }
    });
    partials.iter().copied().sum()
}

/// Sums `f(row)` over so many rows. `partials` is scratch; it grows once.
pub fn sum(rows: usize, partials: &mut Vec<f64>, f: impl Fn(usize) -> f64 + Sync) -> f64 {
    fill(rows, partials, |rows| {
        wide(
            #[inline(always)]
            || rows.map(&f).sum(),
        )
    });
    partials.iter().sum()
}

/// A number for every chunk of so many rows.
#[inline]
fn fill(rows: usize, partials: &mut Vec<f64>, of_chunk: impl Fn(Range<usize>) -> f64 + Sync) {
    partials.clear();
    partials.resize(rows.div_ceil(CHUNK), 0.0);
    share(Rows(partials, 1), is_worth_sharing(rows), &|first, partials| {
        for (c, partial) in (first..).zip(partials.0) {
            *partial = of_chunk(c * CHUNK..((c + 1) * CHUNK).min(rows));
        }
    });
}

/// Runs a kernel on every part of `out`, with the number of the part: part `p` has the rows from `starts[p]` up to `starts[p + 1]`.
pub fn for_parts<T: Send>(out: &mut [T], starts: &[u32], kernel: &impl Kernel<T>) {
    let is_shared = is_worth_sharing(out.len());
    share(Parts(out, starts), is_shared, &|first, Parts(mut rows, starts)| {
        for (p, ends) in starts.windows(2).enumerate() {
            let (part, others) = rows.split_at_mut((ends[1] - ends[0]) as usize);
            run(kernel, first + p, part);
            rows = others;
        }
    });
}
