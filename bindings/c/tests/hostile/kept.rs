//! Calls on what is kept: snapshots, recordings, haptic models, settings.

use super::*;

impl Hostile {
    pub(crate) fn snapshots(&mut self, world: RhexisWorld) {
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
                if self.judge("snapshot_bytes", rhexis_snapshot_bytes(known, out(&mut bytes))) && self.crowd.is_none() {
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
        while self.pool.snapshots.len() > 4 {
            self.judge("snapshot_destroy", rhexis_snapshot_destroy(self.pool.snapshots[0]));
            self.pool.snapshots.remove(0);
        }
    }

    pub(crate) fn recordings(&mut self, world: RhexisWorld) {
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
        while self.pool.recordings.len() > 3 {
            self.judge("recording_destroy", rhexis_recording_destroy(self.pool.recordings[0]));
            self.pool.recordings.remove(0);
        }
    }

    pub(crate) fn haptics(&mut self, world: RhexisWorld, entity: RhexisEntity, number: f64, place: RhexisVec3) {
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
        while self.pool.haptics.len() > 2 {
            self.judge("haptics_destroy", rhexis_haptics_destroy(self.pool.haptics[0]));
            self.pool.haptics.remove(0);
        }
        while self.pool.receivers.len() > 2 {
            self.judge("receiver_destroy", rhexis_receiver_destroy(self.pool.receivers[0]));
            self.pool.receivers.remove(0);
        }
    }

    pub(crate) fn settings(&mut self, world: RhexisWorld, number: f64) {
        let toml = self.random.pick(&[
            c"max_tear_passes = 1",
            c"max_tear_passes = 2",
            c"budget = 5",
            c"budgets = 5",
            c"advanced = 3",
            c"x",
        ]);
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

    pub(crate) fn questions(&mut self, world: RhexisWorld) {
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
}
