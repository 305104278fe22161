//! One call, of bodies and tools.

use super::*;

impl Hostile {
    /// One call.
    pub(crate) fn call(&mut self) {
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

    pub(crate) fn step(&mut self, world: RhexisWorld, dt: f64) {
        let mut report = RhexisReport::default();
        let report_out = self.out(&mut report);
        match self.random.below(40) {
            0 => _ = self.judge("settle", rhexis_settle(world, dt, 1e-6, report_out)),
            1..=3 => _ = self.judge("advance", rhexis_advance(world, report_out)),
            4..=6 => _ = self.judge("is_finished", rhexis_is_finished(world, out(&mut 0))),
            _ => _ = self.judge("step", rhexis_step(world, dt, report_out)),
        }
    }

    pub(crate) fn component(&mut self, world: RhexisWorld, entity: RhexisEntity) {
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
                let mut rigid = RhexisRigid::default();
                let known =
                    [c"", c"mass = 2", c"mass = 1e-300", c"velocity = [1, 0, 1e9]", c"mass = 0.1\nspin = [0, 9, 0]"];
                let toml = if self.random.chance(10) { self.text() } else { text(self.random.pick(&known)) };
                self.judge("rigid_set", rhexis_rigid_set(world, entity, toml));
                self.judge("rigid", rhexis_rigid(world, entity, out(&mut rigid)));
            }
            _ => _ = self.judge("set", rhexis_set(world, entity, text(name), toml)),
        }
    }

    pub(crate) fn forceps(&mut self, world: RhexisWorld, entity: RhexisEntity, body: RhexisEntity) {
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

    pub(crate) fn pins(&mut self, world: RhexisWorld, body: RhexisEntity) {
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

    pub(crate) fn look(&mut self, world: RhexisWorld, body: RhexisEntity, behind: f64) {
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
        if self.crowd.is_some() {
            return;
        }
        // What is lent is finite, and rows are those of vertices.
        assert!(seen(doubles.data, doubles.count).iter().all(|number| number.is_finite()));
        let _ = seen(singles.data, singles.count);
        if is_there && rhexis_indices(world, body, out(&mut rows)) == RhexisStatus::Ok {
            ok(rhexis_positions(world, body, out(&mut doubles)));
            let count = doubles.count as u32 / 3;
            assert!(seen(rows.data, rows.count).iter().all(|&row| row < count));
        }
    }
}
