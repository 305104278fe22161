//! The only file that names threads. Work is cut into chunks of rows that depend on the mesh alone, and sums add chunk by
//! chunk in order, so that every result has the same bits for any number of threads.

use rayon::prelude::*;
use std::cell::Cell;

/// Rows per chunk: large enough that a chunk of the cheapest loop (a vector update, 1 ns a row) outweighs handing it to a
/// thread, small enough that 5,000 triangles still fill two cores.
const CHUNK: usize = 1024;

/// Whether this many rows are worth handing out.
fn is_worth_sharing(rows: usize) -> bool {
    rows > 2 * CHUNK && !IS_ALONE.get() && rayon::current_num_threads() > 1
}

/// Calls `f(row, out)` for every row.
pub fn for_rows<T: Send>(out: &mut [T], f: impl Fn(usize, &mut T) + Sync) {
    let chunk = |(c, rows): (usize, &mut [T])| {
        for (i, value) in rows.iter_mut().enumerate() {
            f(c * CHUNK + i, value);
        }
    };
    if is_worth_sharing(out.len()) {
        out.par_chunks_mut(CHUNK).enumerate().for_each(chunk);
    } else {
        out.chunks_mut(CHUNK).enumerate().for_each(chunk);
    }
}

/// Calls `f(row, out)` for every row and sums what it returns. `partials` is scratch; it grows once.
pub fn sum_rows<T: Send>(out: &mut [T], partials: &mut Vec<f64>, f: impl Fn(usize, &mut T) -> f64 + Sync) -> f64 {
    partials.clear();
    partials.resize(out.len().div_ceil(CHUNK), 0.0);
    let chunk = |(c, (rows, partial)): (usize, (&mut [T], &mut f64))| {
        for (i, value) in rows.iter_mut().enumerate() {
            *partial += f(c * CHUNK + i, value);
        }
    };
    if is_worth_sharing(out.len()) {
        out.par_chunks_mut(CHUNK).zip(partials.par_iter_mut()).enumerate().for_each(chunk);
    } else {
        out.chunks_mut(CHUNK).zip(partials.iter_mut()).enumerate().for_each(chunk);
    }
    partials.iter().sum()
}

thread_local! {
    /// Whether this thread runs the work of a pool that has no other.
    static IS_ALONE: Cell<bool> = const { Cell::new(false) };
}

/// A pool with a fixed number of threads; zero asks for one per core. A pool of one is the thread that asks: it starts none,
/// and waits for none.
#[derive(Debug)]
pub struct Pool(Option<rayon::ThreadPool>);

impl Pool {
    /// Starts the threads.
    ///
    /// # Errors
    /// The system's message, where it grants no threads.
    pub fn new(threads: usize) -> Result<Self, String> {
        if threads == 1 {
            return Ok(Self(None));
        }
        let builder = rayon::ThreadPoolBuilder::new().num_threads(threads).thread_name(|i| format!("rhexis-{i}"));
        builder.build().map(|pool| Self(Some(pool))).map_err(|e| e.to_string())
    }

    /// Runs `f` inside the pool: entered once per step.
    pub fn run<R: Send>(&self, f: impl FnOnce() -> R + Send) -> R {
        match &self.0 {
            Some(pool) => pool.install(f),
            None => {
                let _entered = Alone(IS_ALONE.replace(true));
                f()
            }
        }
    }

    /// Number of threads.
    pub fn thread_count(&self) -> usize {
        self.0.as_ref().map_or(1, rayon::ThreadPool::current_num_threads)
    }
}

/// Puts back what [`IS_ALONE`] was, also after a panic.
struct Alone(bool);

impl Drop for Alone {
    fn drop(&mut self) {
        IS_ALONE.set(self.0);
    }
}
