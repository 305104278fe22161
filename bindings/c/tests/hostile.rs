//! Random calls with hostile arguments: handles of all kinds, stale and made up, lengths, numbers that are none, text that is none.
//!
//! The pointers are valid for what is said of them, null or not aligned: more cannot be judged. Every answer is a status, a refusal has its
//! message, and no call fails inside.

#![allow(unsafe_code, reason = "pointers are handed over as C does")]

mod common;
use common::*;

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

/// Xorshift64* (Vigna 2016): the same calls on every machine.
struct Random(u64);

impl Random {
    fn next(&mut self) -> u64 {
        self.0 ^= self.0 >> 12;
        self.0 ^= self.0 << 25;
        self.0 ^= self.0 >> 27;
        self.0.wrapping_mul(0x2545_f491_4f6c_dd1d)
    }

    fn below(&mut self, count: usize) -> usize {
        (self.next() >> 33) as usize % count
    }

    fn chance(&mut self, one_in: usize) -> bool {
        self.below(one_in) == 0
    }

    fn pick<T: Copy>(&mut self, from: &[T]) -> T {
        from[self.below(from.len())]
    }

    /// Mostly a length or a time that makes sense.
    fn number(&mut self) -> f64 {
        const HOSTILE: [f64; 10] =
            [f64::NAN, f64::INFINITY, f64::NEG_INFINITY, 0.0, -0.0, -1.0, 1e-300, 1e300, f64::MAX, f64::MIN_POSITIVE];
        if self.chance(12) { self.pick(&HOSTILE) } else { (self.next() >> 11) as f64 / (1u64 << 53) as f64 * 4.0 }
    }

    fn vector(&mut self) -> RhexisVec3 {
        RhexisVec3 { x: self.number(), y: self.number(), z: self.number() - 2.0 }
    }

    fn pose(&mut self) -> RhexisPose {
        let mut pose =
            RhexisPose { position: self.vector(), orientation: RhexisQuat { x: 0.0, y: 0.0, z: 0.0, w: 1.0 } };
        if self.chance(8) {
            pose.orientation.x = self.number();
        }
        pose
    }
}

/// What calls have given out, dead or alive.
#[derive(Default)]
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

const TEXTS: [&CStr; 8] = [c"", c"sheet", c"left", c"\xff\xfe", c"shape = {", c"\xc3\xa4", c"Tearing", c"radius = nan"];

const COMPONENTS: [(&CStr, &CStr); 16] = [
    (c"Tearing", c"radius = 0.8\nstrength_fibre = 0.02\nstrength_transverse = 0.01"),
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

struct Hostile {
    random: Random,
    pool: Pool,
    /// Answers by call and status.
    told: BTreeMap<(&'static str, i32), u64>,
}

impl Hostile {
    fn new(seed: u64) -> Self {
        Self { random: Random(seed | 1), pool: Pool::default(), told: BTreeMap::new() }
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
        assert!(
            !matches!(status, RhexisStatus::Panic | RhexisStatus::Poisoned | RhexisStatus::Busy),
            "{name}: {status:?}: {said}"
        );
        assert!(status == RhexisStatus::Ok || !said.is_empty(), "{name}: {status:?} without a message");
        status == RhexisStatus::Ok
    }

    fn make_world(&mut self) {
        let (mut world, mut settings) = (RhexisWorld::default(), blank_settings());
        ok(rhexis_settings_init(out(&mut settings)));
        settings.threads = 1;
        settings.preset = self.random.below(6) as u32;
        let (settings, world_out) = (self.input(&settings), self.out(&mut world));
        if self.judge("world_create", rhexis_world_create(settings, world_out)) && world.bits != 0 {
            self.pool.worlds.push(world);
        }
        // No more than a few at a time.
        if self.pool.worlds.len() > 4 {
            let oldest = self.pool.worlds[0];
            self.pool.worlds.remove(0);
            // Some of its entities stay known, as stale ones do.
            let Self { random, pool, .. } = self;
            pool.entities.retain(|(world, _)| *world != oldest || random.chance(8));
            self.judge("world_destroy", rhexis_world_destroy(oldest));
        }
    }

    fn make_body(&mut self) {
        let (mut positions, mut triangles) = grid(1 + self.random.below(4) as u32);
        let vertices = positions.len() / 3;
        if self.random.chance(6) {
            let at = self.random.below(positions.len());
            positions[at] = self.random.number();
        }
        if self.random.chance(6) {
            let at = self.random.below(triangles.len());
            triangles[at] = self.random.next() as u32;
        }
        // SAFETY: all numbers and pointers, which may be zero.
        let mut desc: RhexisBodyDesc = unsafe { std::mem::zeroed() };
        ok(rhexis_body_init(out(&mut desc)));
        desc.name = self.text();
        (desc.positions, desc.vertex_count) = (array(&positions), vertices - usize::from(self.random.chance(8)));
        (desc.triangles, desc.triangle_count) = (array(&triangles), triangles.len() / 3);
        match self.random.below(16) {
            0 => (desc.positions, desc.vertex_count) = (Array::NULL, self.random.next() as usize),
            1 => desc.vertex_count = usize::MAX / 3 - self.random.below(3),
            2 => desc.thickness = self.random.number(),
            3 => desc.fibre = self.random.vector(),
            4 => desc.young_fibre = self.random.number(),
            5 => desc.triangles = Array::NULL,
            _ => {}
        }
        // A count that memory does not hold goes with a pointer that is none.
        if desc.vertex_count > vertices {
            desc.positions = Array::NULL;
        }
        let mut body = RhexisEntity::default();
        let (world, desc, body_out) = (self.world(), self.input(&desc), self.out(&mut body));
        if self.judge("body_create", rhexis_body_create(world, desc, body_out)) {
            self.note(world, body);
            let mut keys = RhexisViewU64 { data: std::ptr::null(), count: 0 };
            ok(rhexis_vertex_keys(world, body, out(&mut keys)));
            self.pool.keys = seen(keys.data, keys.count);
        }
    }

    fn note(&mut self, world: RhexisWorld, entity: RhexisEntity) {
        if self.pool.entities.len() > 40 {
            let at = self.random.below(40);
            self.pool.entities.swap_remove(at);
        }
        self.pool.entities.push((world, entity));
    }

    fn vertices(&mut self) -> Vec<u64> {
        let mut vertices = Vec::new();
        for _ in 0..self.random.below(4) {
            let made_up = self.random.chance(12) || self.pool.keys.is_empty();
            vertices.push(if made_up { self.random.next() } else { self.random.pick(&self.pool.keys) });
        }
        vertices
    }

    /// One call.
    fn call(&mut self) {
        let (world, [entity, other]) = self.entities();
        let (a, b, p, q) = (self.random.number(), self.random.number(), self.random.vector(), self.random.vector());
        match self.random.below(30) {
            0 if self.random.chance(3) || self.pool.worlds.len() < 3 => self.make_world(),
            1 => self.make_body(),
            2..=5 => self.step(world, a),
            6 => self.component(world, entity),
            7..=11 => self.forceps(world, entity, other),
            12 | 13 => self.pins(world, entity),
            14 => {
                let mut cut = RhexisCut::default();
                let line = [p.x, p.y, 0.0, q.x, q.y, 0.0, a, b, a];
                let (count, cut_out) = (self.random.below(4), self.out(&mut cut));
                self.judge("cut", rhexis_cut(world, entity, array(&line), count, cut_out));
            }
            15 => _ = self.judge("puncture", rhexis_puncture(world, entity, p, q, a, Out::NULL)),
            16 => {
                let mut blade = RhexisEntity::default();
                if self.judge("blade_create", rhexis_blade_create(world, a, b, out(&mut blade))) {
                    self.note(world, blade);
                }
            }
            17 => _ = self.judge("blade_draw", rhexis_blade_draw(world, entity, other, p, Out::NULL)),
            18 => {
                // SAFETY: all numbers, which may be zero.
                let mut hit: RhexisHit = unsafe { std::mem::zeroed() };
                let hit_out = self.out(&mut hit);
                self.judge("nearest", rhexis_nearest(world, entity, p, a, hit_out));
                let hit_out = self.out(&mut hit);
                self.judge("cast_ray", rhexis_cast_ray(world, entity, p, q, a, hit_out));
            }
            19 | 20 => self.look(world, entity, a),
            21 => {
                // SAFETY: all numbers and pointers, which may be zero.
                let mut event: RhexisEvent = unsafe { std::mem::zeroed() };
                let event_out = self.out(&mut event);
                self.judge("next_event", rhexis_next_event(world, event_out));
            }
            22 => self.snapshots(world),
            23 => self.recordings(world),
            24 | 25 => self.haptics(world, entity, a, p),
            26 => {
                let key = self.vertices().first().copied().unwrap_or(0);
                self.judge("apply_force", rhexis_apply_force(world, entity, key, p));
            }
            27 if self.random.chance(3) => _ = self.judge("entity_destroy", rhexis_entity_destroy(world, entity)),
            28 => self.settings(world, a),
            _ => self.questions(world),
        }
    }

    fn step(&mut self, world: RhexisWorld, dt: f64) {
        let mut report = RhexisReport::default();
        let report_out = self.out(&mut report);
        match self.random.below(12) {
            0 => _ = self.judge("settle", rhexis_settle(world, dt, 1e-6, report_out)),
            1 => _ = self.judge("advance", rhexis_advance(world, report_out)),
            2 => _ = self.judge("is_finished", rhexis_is_finished(world, out(&mut 0))),
            _ => _ = self.judge("step", rhexis_step(world, dt, report_out)),
        }
    }

    fn component(&mut self, world: RhexisWorld, entity: RhexisEntity) {
        let (name, toml) = self.random.pick(&COMPONENTS);
        let toml = if self.random.chance(10) { self.text() } else { text(toml) };
        let (mut bytes, mut count) = ([0; 300], 0);
        match self.random.below(5) {
            0 => _ = self.judge("unset", rhexis_unset(world, entity, text(name), Out::NULL)),
            1 => {
                let capacity = self.random.below(301);
                let answer = rhexis_get(world, entity, text(name), buffer(&mut bytes), capacity, out(&mut count));
                self.judge("get", answer);
            }
            2 => {
                let mut obstacle = RhexisEntity::default();
                if self.judge("obstacle_create", rhexis_obstacle_create(world, toml, out(&mut obstacle))) {
                    self.note(world, obstacle);
                }
            }
            _ => _ = self.judge("set", rhexis_set(world, entity, text(name), toml)),
        }
    }

    fn forceps(&mut self, world: RhexisWorld, entity: RhexisEntity, body: RhexisEntity) {
        let pose = self.random.pose();
        match self.random.below(5) {
            0 => {
                let mut jaws = RhexisJaws { radius: 0.5, stiffness: 0.0, force_limit: 0.0, slides: 0 };
                if self.random.chance(2) {
                    jaws.stiffness = self.random.number();
                    jaws.force_limit = self.random.number();
                    jaws.slides = self.random.below(3) as u8;
                }
                let mut forceps = RhexisEntity::default();
                let (name, jaws, pose) = (self.text(), self.input(&jaws), self.input(&pose));
                if self.judge("forceps_create", rhexis_forceps_create(world, name, jaws, pose, out(&mut forceps))) {
                    self.note(world, forceps);
                }
            }
            1 => {
                let vertices = self.vertices();
                let grasp = RhexisGrasp {
                    kind: self.random.below(5) as u32,
                    reach: self.random.number(),
                    point: self.random.vector(),
                    direction: self.random.vector(),
                    vertices: array(&vertices),
                    vertex_count: vertices.len(),
                };
                let grasp = self.input(&grasp);
                self.judge("forceps_close", rhexis_forceps_close(world, entity, body, grasp, Out::NULL));
            }
            2 => _ = self.judge("forceps_open", rhexis_forceps_open(world, entity)),
            3 => {
                // SAFETY: all numbers, which may be zero.
                let mut state: RhexisForcepsState = unsafe { std::mem::zeroed() };
                self.judge("forceps_state", rhexis_forceps_state(world, entity, out(&mut state)));
            }
            _ => {
                let (pose, within) = (self.input(&pose), self.random.number());
                self.judge("forceps_move", rhexis_forceps_move(world, entity, pose, within));
            }
        }
    }

    fn pins(&mut self, world: RhexisWorld, body: RhexisEntity) {
        let (vertices, name) = (self.vertices(), if self.random.chance(4) { self.text() } else { text(c"left") });
        let (keys, count) = (array(&vertices), vertices.len());
        let mut pins = [RhexisPin::default(); 8];
        match self.random.below(6) {
            0 | 1 => _ = self.judge("pin", rhexis_pin(world, body, name, keys, count)),
            2 => _ = self.judge("unpin", rhexis_unpin(world, body, keys, count)),
            3 => _ = self.judge("unpin_all", rhexis_unpin_all(world, body, name)),
            4 => {
                let (capacity, mut count) = (self.random.below(9), 0);
                self.judge("pins", rhexis_pins(world, body, name, buffer(&mut pins), capacity, out(&mut count)));
                let places: Vec<f64> = (0..24).map(|_| self.random.number()).collect();
                let given = count.min(8) - usize::from(count > 0 && self.random.chance(4));
                self.judge("pins_move", rhexis_pins_move(world, body, name, array(&places), given));
            }
            _ => {
                let way = self.random.vector();
                self.judge("pins_shift", rhexis_pins_shift(world, body, name, way));
                self.judge("reaction", rhexis_reaction(world, body, name, out(&mut RhexisVec3::default())));
            }
        }
    }

    fn look(&mut self, world: RhexisWorld, body: RhexisEntity, behind: f64) {
        let mut doubles = RhexisViewF64 { data: std::ptr::null(), count: 0 };
        let mut singles = RhexisViewF32 { data: std::ptr::null(), count: 0 };
        let mut rows = RhexisViewU32 { data: std::ptr::null(), count: 0 };
        let view = self.out(&mut doubles);
        let is_there = match self.random.below(8) {
            0 => self.judge("positions", rhexis_positions(world, body, view)),
            1 => self.judge("rest_positions", rhexis_rest_positions(world, body, view)),
            2 => self.judge("normals", rhexis_normals(world, body, view)),
            3 => self.judge("positions_before", rhexis_positions_before(world, body, behind, view)),
            4 => self.judge("attributes", rhexis_attributes(world, body, view, Out::NULL)),
            5 => self.judge("positions_f32", rhexis_positions_f32(world, body, out(&mut singles))),
            6 => self.judge("track_changes", rhexis_track_changes(world, body)),
            _ => {
                // SAFETY: all numbers and pointers, which may be zero.
                let mut changes: RhexisChanges = unsafe { std::mem::zeroed() };
                self.judge("changes", rhexis_changes(world, body, out(&mut changes)))
            }
        };
        // What is lent is finite, and rows are those of vertices.
        assert!(seen(doubles.data, doubles.count).iter().all(|number| number.is_finite()));
        let _ = seen(singles.data, singles.count);
        if is_there && rhexis_indices(world, body, out(&mut rows)) == RhexisStatus::Ok {
            ok(rhexis_positions(world, body, out(&mut doubles)));
            let count = doubles.count as u32 / 3;
            assert!(seen(rows.data, rows.count).iter().all(|&row| row < count));
        }
    }

    fn snapshots(&mut self, world: RhexisWorld) {
        let mut made = RhexisSnapshot::default();
        let known = handle!(self.random, self.pool.snapshots, RhexisSnapshot);
        match self.random.below(5) {
            0 | 1 => {
                if self.judge("snapshot_take", rhexis_snapshot_take(world, out(&mut made))) {
                    self.pool.snapshots.push(made);
                }
            }
            2 => _ = self.judge("restore", rhexis_restore(world, known)),
            3 => {
                let mut bytes = RhexisViewU8 { data: std::ptr::null(), count: 0 };
                if self.judge("snapshot_bytes", rhexis_snapshot_bytes(known, out(&mut bytes))) {
                    let mut bytes = seen(bytes.data, bytes.count);
                    if self.random.chance(2) {
                        let at = self.random.below(bytes.len());
                        bytes[at] = self.random.next() as u8;
                    }
                    let count = bytes.len() - self.random.below(2);
                    if self
                        .judge("snapshot_from_bytes", rhexis_snapshot_from_bytes(array(&bytes), count, out(&mut made)))
                    {
                        self.pool.snapshots.push(made);
                    }
                }
            }
            _ => {
                let mut other = RhexisWorld::default();
                if self.judge("world_from_snapshot", rhexis_world_from_snapshot(known, out(&mut other))) {
                    self.judge("step", rhexis_step(other, 1.0, Out::NULL));
                    self.judge("world_destroy", rhexis_world_destroy(other));
                }
            }
        }
        if self.pool.snapshots.len() > 4 {
            self.judge("snapshot_destroy", rhexis_snapshot_destroy(self.pool.snapshots[0]));
            self.pool.snapshots.remove(0);
        }
    }

    fn recordings(&mut self, world: RhexisWorld) {
        let mut made = RhexisRecording::default();
        let known = handle!(self.random, self.pool.recordings, RhexisRecording);
        match self.random.below(4) {
            0 => _ = self.judge("record", rhexis_record(world)),
            1 => {
                if self.judge("record_end", rhexis_record_end(world, out(&mut made))) {
                    self.pool.recordings.push(made);
                }
            }
            2 => _ = self.judge("replay", rhexis_replay(known, Out::NULL)),
            _ => {
                let mut bytes = RhexisViewU8 { data: std::ptr::null(), count: 0 };
                self.judge("recording_bytes", rhexis_recording_bytes(known, out(&mut bytes)));
            }
        }
        if self.pool.recordings.len() > 3 {
            self.judge("recording_destroy", rhexis_recording_destroy(self.pool.recordings[0]));
            self.pool.recordings.remove(0);
        }
    }

    fn haptics(&mut self, world: RhexisWorld, entity: RhexisEntity, number: f64, place: RhexisVec3) {
        let known = handle!(self.random, self.pool.haptics, RhexisHaptics);
        let receiver = handle!(self.random, self.pool.receivers, RhexisReceiver);
        let (mut model, mut force) = (RhexisHapticModel::default(), RhexisVec3::default());
        match self.random.below(8) {
            0 => {
                let mut made = RhexisHaptics::default();
                ok(rhexis_haptics_create(number, out(&mut made)));
                self.pool.haptics.push(made);
            }
            1 => {
                let mut made = RhexisReceiver::default();
                if self.judge("receiver_create", rhexis_receiver_create(known, number, out(&mut made))) {
                    self.pool.receivers.push(made);
                }
            }
            2 => _ = self.judge("haptics_model", rhexis_haptics_model(known, world, entity, out(&mut model))),
            3 => _ = self.judge("haptics_refresh", rhexis_haptics_refresh(known, world, entity, Out::NULL)),
            4 => {
                let answer = rhexis_haptics_model_of_pins(known, world, entity, text(c"left"), Out::NULL);
                self.judge("haptics_model_of_pins", answer);
            }
            5 => _ = self.judge("receiver_latest", rhexis_receiver_latest(receiver, out(&mut model))),
            6 => _ = self.judge("receiver_force", rhexis_receiver_force(receiver, number, place, out(&mut force))),
            _ => _ = self.judge("force_at", rhexis_haptic_force_at(input(&model), place, out(&mut force))),
        }
        if self.pool.haptics.len() > 2 {
            self.judge("haptics_destroy", rhexis_haptics_destroy(self.pool.haptics[0]));
            self.pool.haptics.remove(0);
        }
        if self.pool.receivers.len() > 2 {
            self.judge("receiver_destroy", rhexis_receiver_destroy(self.pool.receivers[0]));
            self.pool.receivers.remove(0);
        }
    }

    fn settings(&mut self, world: RhexisWorld, number: f64) {
        let toml =
            self.random.pick(&[c"resumes = 1", c"halvings = 2", c"budget = 5", c"budgets = 5", c"linear = 3", c"x"]);
        match self.random.below(3) {
            0 => _ = self.judge("settings_set", rhexis_settings_set(world, text(toml))),
            // Of the clock only times that make sense: what a step does then depends on it.
            1 => {
                let iterations = self.random.below(200) as u32;
                let milliseconds = if number.is_finite() && number > 0.0 { 0.0 } else { number };
                self.judge("set_budget", rhexis_set_budget(world, iterations, milliseconds));
            }
            _ => {
                let (mut bytes, mut count) = ([0; 4], 0);
                self.judge("settings_get", rhexis_settings_get(world, buffer(&mut bytes), 4, out(&mut count)));
            }
        }
    }

    fn questions(&mut self, world: RhexisWorld) {
        let (mut bodies, mut count) = ([RhexisEntity::default(); 3], 0);
        let (name, hash_out, time_out) = (self.text(), &mut 0, &mut 0.0);
        let (hash_out, time_out) = (self.out(hash_out), self.out(time_out));
        match self.random.below(4) {
            0 => _ = self.judge("time", rhexis_time(world, time_out)),
            1 => _ = self.judge("hash", rhexis_hash(world, hash_out)),
            2 => _ = self.judge("find_body", rhexis_find_body(world, name, out(&mut bodies[0]))),
            _ => {
                let buffer = if self.random.chance(6) { Buffer::NULL } else { buffer(&mut bodies) };
                self.judge("bodies", rhexis_bodies(world, buffer, 3, out(&mut count)));
            }
        }
    }

    fn run(&mut self, calls: u64) {
        (0..calls).for_each(|_| self.call());
        for world in std::mem::take(&mut self.pool.worlds) {
            rhexis_world_destroy(world);
        }
    }
}

fn run(seed: u64, calls: u64) -> BTreeMap<(&'static str, i32), u64> {
    let mut hostile = Hostile::new(seed);
    hostile.run(calls);
    hostile.told
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

/// `RHEXIS_CALLS` says how many; ten million without.
#[test]
#[ignore = "an hour"]
fn ten_million_hostile_calls_are_answered() {
    let calls = std::env::var("RHEXIS_CALLS").ok().and_then(|calls| calls.parse().ok()).unwrap_or(10_000_000);
    let mut done = 0;
    for seed in 1.. {
        let count = u64::min(50_000, calls - done);
        run(seed * 0x9e37_79b9, count);
        done += count;
        println!("{done} calls");
        if done == calls {
            break;
        }
    }
}
