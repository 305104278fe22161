//! The threads: a pool for the steps, and work that goes on beside them.

use super::CHUNK;
use crate::clock::Moment;
use crate::systems::kernels::simd::force_portable;
use std::cell::Cell;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

/// Whether this many rows are worth handing out.
pub fn is_worth_sharing(rows: usize) -> bool {
    rows > 2 * CHUNK && !IS_ALONE.get() && thread_count() > 1
}

/// Threads of the pool that this one belongs to.
pub(super) fn thread_count() -> usize {
    rayon::current_num_threads()
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
        // Where the platform does not say how many threads it runs, zero is the one that there is.
        let is_alone = threads == 0 && std::thread::available_parallelism().is_err();
        if threads == 1 || is_alone {
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

    /// Runs a step of bodies with `rows` rows in the pool. Where these are worth sharing one more thread stays awake: loops of some ten
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

/// Rows from which on a step gains more by a thread that stays awake than that costs. At 15,000 triangles it takes a tenth of the
/// time away; at 5,000 it takes twice the processor time for nothing.
const AWAKE_FROM: usize = 8192;

/// A thread that has found nothing to do for so long goes to sleep.
const AWAKE: Duration = Duration::from_millis(1);

/// Rests of some ten nanoseconds between two looks for work: looking takes hold of a list that the one who has work writes to.
const RESTS: u32 = 32;

/// Works on shared tasks until the work is done. A thread takes the oldest task that another has to share, so that the first to come takes
/// this, and nothing that others wait for is under it.
fn stay_awake(is_done: &AtomicBool) {
    let mut since = Moment::now();
    while !is_done.load(Ordering::Acquire) {
        if rayon::yield_now() == Some(rayon::Yield::Executed) {
            since = Moment::now();
            continue;
        }
        if since.elapsed() > AWAKE {
            return;
        }
        (0..RESTS).for_each(|_| std::hint::spin_loop());
    }
}

/// Restores the settings of this thread, also after a panic.
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
