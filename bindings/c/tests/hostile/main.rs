//! Random calls with hostile arguments: handles of all kinds, stale and made up, lengths, numbers that are none, text that is none.
//!
//! The pointers are valid for what is said of them, null or not aligned: more cannot be judged. Every answer is a status, a refusal has its
//! message, and no call fails inside.

#![allow(unsafe_code, reason = "pointers are handed over as C does")]

macro_rules! handle {
    ($random:expr, $list:expr, $kind:ident) => {{
        let known = $list.len();
        match $random.below(24) {
            0 => $kind { bits: $random.next() },
            1 => $kind { bits: 0 },
            _ if known == 0 => $kind { bits: 1 },
            _ => $list[$random.below(known)],
        }
    }};
}

mod calls;
#[path = "../common/mod.rs"]
mod common;
mod kept;
mod made;
mod random;

use common::*;
use random::Random;

use rhexis_c::body::*;
use rhexis_c::component::*;
use rhexis_c::events::*;
use rhexis_c::haptics::*;
use rhexis_c::pins::*;
use rhexis_c::pointer::{Array, Buffer, In, Out, Text};
use rhexis_c::saved::*;
use rhexis_c::shown::*;
use rhexis_c::status::*;
use rhexis_c::tools::*;
use rhexis_c::types::*;
use rhexis_c::world::*;
use std::collections::BTreeMap;
use std::ffi::CStr;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Mutex};

/// What calls have given out, dead or alive.
#[derive(Clone, Default)]
struct Pool {
    worlds: Vec<RhexisWorld>,
    /// Each with its world.
    entities: Vec<(RhexisWorld, RhexisEntity)>,
    snapshots: Vec<RhexisSnapshot>,
    recordings: Vec<RhexisRecording>,
    haptics: Vec<RhexisHaptics>,
    receivers: Vec<RhexisReceiver>,
    keys: Vec<u64>,
}

const TEXTS: [&CStr; 8] = [c"", c"sheet", c"left", c"\xff\xfe", c"shape = {", c"\xc3\xa4", c"Tearing", c"radius = nan"];

const COMPONENTS: [(&CStr, &CStr); 16] = [
    (c"Tearing", c"radius = 0.8\nstrength_across_fibres = 0.02\nstrength_along_fibres = 0.01"),
    (c"Tearing", c"radius = -inf"),
    (c"Tearing", c""),
    (c"Gravity", c"acceleration = [0, 0, -9.81e-3]"),
    (c"Gravity", c"acceleration = [nan, 0, 0]"),
    (c"Damping", c"time = 0.1"),
    (c"Drag", c"coefficient = 1e-4"),
    (c"Pressure", c"curve = { points = [[0, 1e-4], [50, 0]] }"),
    (c"Pressure", c"curve = { points = [] }"),
    (c"Bending", c""),
    (c"Sleeping", c""),
    (c"Attributes", c"stride = 1\nvalues = [0, 1, 2]"),
    (c"PointLoads", c"groups = [{ rows = [4294967295], force = [0, 0, 1], curve = { points = [[0, 1]] } }]"),
    (c"Obstacle", c"shape = { Sphere = { centre = [1, 1, -1], radius = 0.5 } }"),
    (c"Holds", c"groups = [{ name = 'h', axes = [true, true, true], curve = { points = [[0, 1]] }, members = { rows = [0], values = [[0, 0, 0]] } }]"),
    (c"PreStretch", c"strain = { xx = 0.01, yy = 0.01, xy = 0 }"),
];

/// Pools of threads that call the same objects.
type Crowd = Arc<[Mutex<Pool>]>;

struct Hostile {
    random: Random,
    pool: Pool,
    /// The pools of all threads, where there are several: what is lent may change under this one, and is not looked at.
    crowd: Option<Crowd>,
    /// Answers by call and status.
    told: BTreeMap<(&'static str, i32), u64>,
}

impl Hostile {
    fn new(seed: u64) -> Self {
        Self { random: Random(seed | 1), pool: Pool::default(), crowd: None, told: BTreeMap::new() }
    }

    fn text(&mut self) -> Text {
        if self.random.chance(12) { Text::NULL } else { text(self.random.pick(&TEXTS)) }
    }

    fn world(&mut self) -> RhexisWorld {
        handle!(self.random, self.pool.worlds, RhexisWorld)
    }

    /// Two entities, most often of the world that comes with them.
    fn entities(&mut self) -> (RhexisWorld, [RhexisEntity; 2]) {
        if self.pool.entities.is_empty() {
            return (self.world(), [RhexisEntity { bits: self.random.next() }; 2]);
        }
        let (mut world, first) = self.random.pick(&self.pool.entities);
        if self.random.chance(16) {
            world = self.world();
        }
        let beside: Vec<RhexisEntity> =
            self.pool.entities.iter().filter(|(its, _)| *its == world).map(|(_, entity)| *entity).collect();
        let made_up = self.random.chance(16) || beside.is_empty();
        let second = if made_up { RhexisEntity { bits: self.random.next() } } else { self.random.pick(&beside) };
        if self.random.chance(2) { (world, [first, second]) } else { (world, [second, first]) }
    }

    fn out<T>(&mut self, value: &mut T) -> Out<T> {
        match self.random.below(40) {
            0 => Out::NULL,
            1 if align_of::<T>() > 1 => {
                // SAFETY: not aligned, hence refused.
                unsafe { Out::new(std::ptr::from_mut(value).byte_add(1)) }
            }
            _ => out(value),
        }
    }

    fn input<T>(&mut self, value: &T) -> In<T> {
        if self.random.chance(40) { In::NULL } else { input(value) }
    }

    /// Judges an answer.
    fn judge(&mut self, name: &'static str, status: RhexisStatus) -> bool {
        *self.told.entry((name, status as i32)).or_default() += 1;
        let said = message();
        let has_failed = match status {
            RhexisStatus::Panic | RhexisStatus::Poisoned => true,
            RhexisStatus::Busy => self.crowd.is_none(),
            _ => false,
        };
        assert!(!has_failed, "{name}: {status:?}: {said}");
        assert!(status == RhexisStatus::Ok || !said.is_empty(), "{name}: {status:?} without a message");
        status == RhexisStatus::Ok
    }

    /// Learns of some objects of another thread, and shows it those of this one.
    fn mingle(&mut self, crowd: &Crowd) {
        let (from, to) = (self.random.below(crowd.len()), self.random.below(crowd.len()));
        crowd[to].lock().unwrap().clone_from(&self.pool);
        let other = crowd[from].lock().unwrap().clone();
        if let Some(&world) = other.worlds.last().filter(|world| !self.pool.worlds.contains(world)) {
            self.pool.worlds.push(world);
            other.entities.iter().filter(|(of, _)| *of == world).for_each(|(_, entity)| self.note(world, *entity));
            self.thin_worlds();
        }
        self.pool.snapshots.extend(other.snapshots.last());
        self.pool.recordings.extend(other.recordings.last());
        self.pool.haptics.extend(other.haptics.last());
        self.pool.receivers.extend(other.receivers.last());
    }

    fn run(&mut self, calls: u64) {
        for _ in 0..calls {
            if let Some(crowd) = self.crowd.clone().filter(|_| self.random.chance(50)) {
                self.mingle(&crowd);
            }
            self.call();
        }
        for world in std::mem::take(&mut self.pool.worlds) {
            while rhexis_world_destroy(world) == RhexisStatus::Busy {
                std::thread::yield_now();
            }
        }
    }
}

fn run(seed: u64, calls: u64) -> BTreeMap<(&'static str, i32), u64> {
    let mut hostile = Hostile::new(seed);
    hostile.run(calls);
    hostile.told
}

/// The answers of several threads that each make so many calls, on objects of one another.
fn run_crowd(seed: u64, threads: u64, calls: u64) -> BTreeMap<(&'static str, i32), u64> {
    let crowd: Crowd = (0..threads).map(|_| Mutex::default()).collect();
    let begin = |thread: u64| {
        let crowd = Some(Arc::clone(&crowd));
        std::thread::spawn(move || {
            let mut hostile = Hostile { crowd, ..Hostile::new(seed.wrapping_mul(2 * thread + 3)) };
            hostile.run(calls);
            hostile.told
        })
    };
    let threads: Vec<_> = (0..threads).map(begin).collect();
    let mut all = BTreeMap::new();
    for (what, count) in threads.into_iter().flat_map(|thread| thread.join().unwrap()) {
        *all.entry(what).or_default() += count;
    }
    all
}

#[test]
fn hostile_calls_are_answered() {
    let told = run(0x5eed, 20_000);
    let names: std::collections::BTreeSet<_> = told.keys().map(|(name, _)| *name).collect();
    let answered = |status: RhexisStatus| told.iter().filter(|((_, told), _)| *told == status as i32).count();
    // Every call was made, most with success at times, and each kind of refusal was met.
    assert!(names.len() > 50, "{names:?}");
    assert!(answered(RhexisStatus::Ok) > 45, "{told:?}");
    for status in ["InvalidArgument", "InvalidHandle", "BufferTooSmall", "Refused", "Scene", "NotFound"] {
        let (known, _) = RhexisStatus::ALL.into_iter().find(|(known, _)| format!("{known:?}") == status).unwrap();
        assert!(answered(known) > 0, "{status}");
    }
    // The same calls have the same answers.
    assert_eq!(run(0x5eed, 2_000), run(0x5eed, 2_000));
}

/// Threads that step, change and destroy the worlds of one another: those that meet are told that it is busy.
#[test]
fn hostile_calls_of_several_threads_are_answered() {
    let told = run_crowd(0x5eed, 4, 3_000);
    let answered = |status: RhexisStatus| told.iter().filter(|((_, told), _)| *told == status as i32).count();
    for status in [RhexisStatus::Ok, RhexisStatus::Busy, RhexisStatus::InvalidHandle] {
        assert!(answered(status) > 5, "{status:?}: {told:?}");
    }
}

/// Calls of one round, a tenth of them by four threads that share their objects.
const ROUND: u64 = 100_000;

/// `RHEXIS_CALLS` says how many, in rounds; ten million without. `RHEXIS_FIRST` is the first round, so that a run that was cut off goes on.
#[test]
#[ignore = "minutes: cargo test --release -p rhexis-c --test hostile -- --ignored"]
fn ten_million_hostile_calls_are_answered() {
    let asked = |name: &str, usual: u64| std::env::var(name).map_or(usual, |value| value.parse::<u64>().unwrap());
    let (calls, first) = (asked("RHEXIS_CALLS", 10_000_000), asked("RHEXIS_FIRST", 1));
    let (rounds, next, done) = (first - 1 + calls.div_ceil(ROUND), AtomicU64::new(first), AtomicU64::new(0));
    let work = || {
        loop {
            let round = next.fetch_add(1, Ordering::Relaxed);
            if round > rounds {
                return;
            }
            let seed = round * 0x9e37_79b9;
            let answers = [run(seed, ROUND / 10 * 9), run_crowd(seed, 4, ROUND / 40)];
            let made: u64 = answers.iter().flat_map(BTreeMap::values).sum();
            println!("round {round}: {} calls so far", done.fetch_add(made, Ordering::Relaxed) + made);
        }
    };
    std::thread::scope(|scope| {
        (0..std::thread::available_parallelism().map_or(1, usize::from)).for_each(|_| _ = scope.spawn(work));
    });
    assert!(done.into_inner() >= calls);
}
