//! The only file that names threads. Work is cut into chunks of rows that depend on the mesh alone, and sums add chunk by
//! chunk in order, so that every result has the same bits for any number of threads. Every chunk is a [`wide`] loop.

use super::kernels::simd::{Kernel, LANES, force_portable, run, wide};
use hecs::{Query, World};
use rayon::prelude::*;
use std::cell::Cell;
use std::iter::Sum;
use std::ops::{AddAssign, Range};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

/// Rows per chunk: large enough that a chunk of the cheapest loop (a vector update, 1 ns a row) outweighs handing it to a
/// thread, small enough that 5,000 triangles still fill two cores.
const CHUNK: usize = 1024;

/// Calls `run` for every body of a query that has work to do, and returns their number. `work` is what a body's work is, in
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
    side_by_side(count.min(rayon::current_num_threads()), &worker);
    count
}

/// Lets so many threads do the same.
fn side_by_side(count: usize, worker: &(impl Fn() + Sync)) {
    if count < 2 {
        return worker();
    }
    rayon::join(|| side_by_side(count / 2, worker), || side_by_side(count - count / 2, worker));
}

/// Whether this many rows are worth handing out.
pub fn is_worth_sharing(rows: usize) -> bool {
    rows > 2 * CHUNK && !IS_ALONE.get() && rayon::current_num_threads() > 1
}

/// Calls `f(row, out)` for every row.
pub fn for_rows<T: Send>(out: &mut [T], f: impl Fn(usize, &mut T) + Sync) {
    for_slices(out, |first, rows| {
        for (i, value) in rows.iter_mut().enumerate() {
            f(first + i, value);
        }
    });
}

/// Calls `f(first_row, rows)` for every chunk of rows: a kernel that takes several rows at a time. All chunks but the last
/// have a multiple of eight rows.
pub fn for_slices<T: Send>(out: &mut [T], f: impl Fn(usize, &mut [T]) + Sync) {
    let chunk = |(c, rows): (usize, &mut [T])| wide(|| f(c * CHUNK, rows));
    if is_worth_sharing(out.len()) {
        out.par_chunks_mut(CHUNK).enumerate().for_each(chunk);
    } else {
        out.chunks_mut(CHUNK).enumerate().for_each(chunk);
    }
}

/// Calls `f(first_row, rows, others)` for every chunk of the rows of two lists of one length: what one loop has filled is still near
/// the processor when the next one reads it.
pub fn for_pairs<T: Send, U: Send>(a: &mut [T], b: &mut [U], f: impl Fn(usize, &mut [T], &mut [U]) + Sync) {
    let chunk = |(c, (a, b)): (usize, (&mut [T], &mut [U]))| f(c * CHUNK, a, b);
    if is_worth_sharing(a.len()) {
        a.par_chunks_mut(CHUNK).zip(b.par_chunks_mut(CHUNK)).enumerate().for_each(chunk);
    } else {
        a.chunks_mut(CHUNK).zip(b.chunks_mut(CHUNK)).enumerate().for_each(chunk);
    }
}

/// Runs a kernel on every chunk of rows; all chunks but the last have a multiple of eight rows.
pub fn for_chunks<T: Send>(out: &mut [T], kernel: &impl Kernel<T>) {
    for_pieces(out, CHUNK, kernel);
}

/// Runs a kernel on every chunk of packs of eight rows.
pub fn for_packs<T: Send>(packs: &mut [T], kernel: &impl Kernel<T>) {
    in_pieces(packs, CHUNK / LANES, is_worth_sharing(LANES * packs.len()), kernel);
}

/// Does two things that take about as long as so many rows, side by side where that is worth it.
pub fn both(rows: usize, a: impl FnOnce() + Send, b: impl FnOnce() + Send) {
    if is_worth_sharing(rows) {
        rayon::join(a, b);
    } else {
        a();
        b();
    }
}

/// Runs a kernel on every piece of so many rows.
pub fn for_pieces<T: Send>(out: &mut [T], size: usize, kernel: &impl Kernel<T>) {
    in_pieces(out, size, is_worth_sharing(out.len()) && out.len() > size, kernel);
}

fn in_pieces<T: Send>(out: &mut [T], size: usize, is_shared: bool, kernel: &impl Kernel<T>) {
    let piece = |(p, rows): (usize, &mut [T])| run(kernel, p * size, rows);
    if is_shared {
        out.par_chunks_mut(size).enumerate().for_each(piece);
    } else {
        out.chunks_mut(size).enumerate().for_each(piece);
    }
}

/// Runs a kernel on every chunk of rows and sums what it returns. `partials` is scratch; it grows once.
pub fn sum_chunks<T: Send, S: Copy + Default + Send + Sum>(
    out: &mut [T],
    partials: &mut Vec<S>,
    kernel: &impl Kernel<T, S>,
) -> S {
    sum_pieces(out, CHUNK, partials, kernel)
}

/// Runs a kernel on every piece of so many rows and sums what it returns. `partials` is scratch; it grows once.
pub fn sum_pieces<T: Send, S: Copy + Default + Send + Sum>(
    out: &mut [T],
    size: usize,
    partials: &mut Vec<S>,
    kernel: &impl Kernel<T, S>,
) -> S {
    partials.clear();
    partials.resize(out.len().div_ceil(size), S::default());
    let piece = |(p, (rows, partial)): (usize, (&mut [T], &mut S))| *partial = run(kernel, p * size, rows);
    if is_worth_sharing(out.len()) && out.len() > size {
        out.par_chunks_mut(size).zip(partials.par_iter_mut()).enumerate().for_each(piece);
    } else {
        out.chunks_mut(size).zip(partials.iter_mut()).enumerate().for_each(piece);
    }
    partials.iter().copied().sum()
}

/// Calls `f(row, out)` for every row and sums what it returns, one number or several. `partials` is scratch; it grows once.
pub fn sum_rows<T: Send, S: Copy + Default + Send + AddAssign + Sum>(
    out: &mut [T],
    partials: &mut Vec<S>,
    f: impl Fn(usize, &mut T) -> S + Sync,
) -> S {
    partials.clear();
    partials.resize(out.len().div_ceil(CHUNK), S::default());
    let chunk = |(c, (rows, partial)): (usize, (&mut [T], &mut S))| {
        wide(|| {
            for (i, value) in rows.iter_mut().enumerate() {
                *partial += f(c * CHUNK + i, value);
            }
        });
    };
    if is_worth_sharing(out.len()) {
        out.par_chunks_mut(CHUNK).zip(partials.par_iter_mut()).enumerate().for_each(chunk);
    } else {
        out.chunks_mut(CHUNK).zip(partials.iter_mut()).enumerate().for_each(chunk);
    }
    partials.iter().copied().sum()
}

/// Sums `f(row)` over so many rows. `partials` is scratch; it grows once.
pub fn sum(rows: usize, partials: &mut Vec<f64>, f: impl Fn(usize) -> f64 + Sync) -> f64 {
    fill(rows, partials, |rows| wide(|| rows.map(&f).sum()));
    partials.iter().sum()
}

/// The least `f(row)` over so many rows; infinite without any. `partials` is scratch; it grows once.
pub fn least(rows: usize, partials: &mut Vec<f64>, f: impl Fn(usize) -> f64 + Sync) -> f64 {
    fill(rows, partials, |rows| wide(|| rows.map(&f).fold(f64::INFINITY, f64::min)));
    partials.iter().copied().fold(f64::INFINITY, f64::min)
}

/// A number for every chunk of so many rows.
#[inline]
fn fill(rows: usize, partials: &mut Vec<f64>, of_chunk: impl Fn(Range<usize>) -> f64 + Sync) {
    partials.clear();
    partials.resize(rows.div_ceil(CHUNK), 0.0);
    let chunk = |(c, partial): (usize, &mut f64)| *partial = of_chunk(c * CHUNK..((c + 1) * CHUNK).min(rows));
    if is_worth_sharing(rows) {
        partials.par_iter_mut().enumerate().for_each(chunk);
    } else {
        partials.iter_mut().enumerate().for_each(chunk);
    }
}

/// Runs a kernel on every part of `out`, which is told its number: part `p` has the rows from `starts[p]` up to `starts[p + 1]`.
pub fn for_parts<T: Send>(out: &mut [T], starts: &[u32], kernel: &impl Kernel<T>) {
    let is_shared = is_worth_sharing(out.len());
    for_parts_from(0, out, starts, is_shared, kernel);
}

fn for_parts_from<T: Send>(first: usize, out: &mut [T], starts: &[u32], is_shared: bool, kernel: &impl Kernel<T>) {
    let count = starts.len().saturating_sub(1);
    if count < 2 {
        if count == 1 {
            run(kernel, first, out);
        }
        return;
    }
    let half = count / 2;
    let (left, right) = out.split_at_mut((starts[half] - starts[0]) as usize);
    let mut left = || for_parts_from(first, left, &starts[..=half], is_shared, kernel);
    let mut right = || for_parts_from(first + half, right, &starts[half..], is_shared, kernel);
    if is_shared {
        rayon::join(left, right);
    } else {
        left();
        right();
    }
}

thread_local! {
    /// Whether this thread runs the work of a pool that has no other.
    static IS_ALONE: Cell<bool> = const { Cell::new(false) };
}

/// A pool with a fixed number of threads; zero asks for one per core. A pool of one is the thread that asks: it starts none,
/// and waits for none.
#[derive(Debug)]
pub struct Pool {
    threads: Option<rayon::ThreadPool>,
    is_portable: bool,
}

impl Pool {
    /// Starts the threads. They use the best instructions there are, or those that every processor of the family has.
    ///
    /// # Errors
    /// The system's message, where it grants no threads.
    pub fn new(threads: usize, is_portable: bool) -> Result<Self, String> {
        if threads == 1 {
            return Ok(Self { threads: None, is_portable });
        }
        let builder = rayon::ThreadPoolBuilder::new().num_threads(threads).thread_name(|i| format!("rhexis-{i}"));
        let builder = builder.start_handler(move |_| {
            force_portable(is_portable);
        });
        let threads = Some(builder.build().map_err(|e| e.to_string())?);
        Ok(Self { threads, is_portable })
    }

    /// Runs `f` inside the pool: entered once per step.
    pub fn run<R: Send>(&self, f: impl FnOnce() -> R + Send) -> R {
        match &self.threads {
            Some(pool) => pool.install(f),
            None => {
                let _entered = Alone { was: IS_ALONE.replace(true), was_portable: force_portable(self.is_portable) };
                f()
            }
        }
    }

    /// The same for a step of bodies with so many rows. Where these are worth sharing one more thread stays awake: loops of some ten
    /// microseconds follow each other, and to wake a thread takes as long as one of them.
    pub fn run_step<R: Send>(&self, rows: usize, f: impl FnOnce() -> R + Send) -> R {
        self.run(|| {
            if rows < AWAKE_FROM || !is_worth_sharing(rows) {
                return f();
            }
            let is_done = AtomicBool::new(false);
            let work = || {
                let _done = Done(&is_done);
                f()
            };
            rayon::join(work, || stay_awake(&is_done)).0
        })
    }

    /// Number of threads.
    pub fn thread_count(&self) -> usize {
        self.threads.as_ref().map_or(1, rayon::ThreadPool::current_num_threads)
    }
}

/// Says that the work is done, also after a panic.
struct Done<'a>(&'a AtomicBool);

impl Drop for Done<'_> {
    fn drop(&mut self) {
        self.0.store(true, Ordering::Release);
    }
}

/// Rows from which on a step gains more by a thread that stays awake than that costs: at 15,000 triangles it takes a tenth of the time
/// away, at 5,000 twice the processor time for nothing.
const AWAKE_FROM: usize = 8192;

/// A thread that has found nothing to do for so long goes to sleep.
const AWAKE: Duration = Duration::from_millis(1);

/// Rests of some ten nanoseconds between two looks for work: looking takes hold of a list that the one who has work writes to.
const RESTS: u32 = 32;

/// Does what there is to share until the work is done. Threads take the oldest of what one has to share, so that the first to come takes
/// this, and nothing that others wait for is under it.
fn stay_awake(is_done: &AtomicBool) {
    let mut since = Instant::now();
    while !is_done.load(Ordering::Acquire) {
        if rayon::yield_now() == Some(rayon::Yield::Executed) {
            since = Instant::now();
            continue;
        }
        if since.elapsed() > AWAKE {
            return;
        }
        (0..RESTS).for_each(|_| std::hint::spin_loop());
    }
}

/// Puts back what was set for this thread, also after a panic.
struct Alone {
    was: bool,
    was_portable: bool,
}

impl Drop for Alone {
    fn drop(&mut self) {
        IS_ALONE.set(self.was);
        force_portable(self.was_portable);
    }
}

/// Work that goes on beside the steps, on a thread of its own. Whoever uses it asks for the result after a fixed number of
/// steps, so that nothing depends on how fast that thread is.
pub struct Aside<T>(Mutex<Work<T>>);

enum Work<T> {
    Running(JoinHandle<T>),
    /// The system grants no thread: done when its result is asked for.
    Waiting(Box<dyn FnOnce() -> T + Send>),
}

impl<T: Send + 'static> Aside<T> {
    /// Begins `work` on `input`.
    pub fn new<I: Send + Sync + 'static>(input: I, work: fn(&I) -> T) -> Self {
        let input = Arc::new(input);
        let shared = Arc::clone(&input);
        let thread = std::thread::Builder::new().name("rhexis-aside".into());
        Self(Mutex::new(match thread.spawn(move || work(&shared)) {
            Ok(handle) => Work::Running(handle),
            Err(_) => Work::Waiting(Box::new(move || work(&input))),
        }))
    }

    /// The result, when it is there; `None` where the work has panicked.
    pub fn finish(self) -> Option<T> {
        match self.0.into_inner().ok()? {
            Work::Running(handle) => handle.join().ok(),
            Work::Waiting(work) => Some(work()),
        }
    }
}
