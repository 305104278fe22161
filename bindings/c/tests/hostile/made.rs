//! Worlds and bodies, made and let go.

use super::*;

impl Hostile {
    pub(crate) fn make_world(&mut self) {
        let (mut world, mut settings) = (RhexisWorld::default(), blank_settings());
        ok(rhexis_settings_init(out(&mut settings)));
        settings.threads = 1;
        settings.accuracy = self.random.below(6) as u32;
        let (settings, world_out) = (self.input(&settings), self.out(&mut world));
        if self.judge("world_create", rhexis_world_create(settings, world_out)) && world.bits != 0 {
            self.pool.worlds.push(world);
        }
        self.thin_worlds();
    }

    /// No more than a few at a time.
    pub(crate) fn thin_worlds(&mut self) {
        if self.pool.worlds.len() <= 4 {
            return;
        }
        let oldest = self.pool.worlds.remove(0);
        // Some of its entities stay known, as stale ones do.
        let Self { random, pool, .. } = self;
        pool.entities.retain(|(world, _)| *world != oldest || random.chance(8));
        let answer = rhexis_world_destroy(oldest);
        self.judge("world_destroy", answer);
        if answer == RhexisStatus::Busy {
            self.pool.worlds.push(oldest);
        }
    }

    pub(crate) fn make_body(&mut self) {
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
        let (of, [entity, _]) = self.entities();
        let (given, material) = (self.input(&desc), self.random.chance(3));
        if material {
            self.judge("material_set", rhexis_material_set(of, entity, given));
        }
        let (world, desc, body_out) = (self.world(), self.input(&desc), self.out(&mut body));
        if self.judge("body_create", rhexis_body_create(world, desc, body_out)) {
            self.note(world, body);
            let mut keys = RhexisViewU64 { data: std::ptr::null(), count: 0 };
            let answer = rhexis_vertex_keys(world, body, out(&mut keys));
            if self.crowd.is_none() {
                ok(answer);
                self.pool.keys = seen(keys.data, keys.count);
            } else if self.judge("vertex_keys", answer) {
                // As slotmap gives them to the vertices of a body that is new.
                self.pool.keys = (1..=keys.count as u64).map(|row| (1 << 32) | row).collect();
            }
        }
    }

    pub(crate) fn note(&mut self, world: RhexisWorld, entity: RhexisEntity) {
        if self.pool.entities.len() > 40 {
            let at = self.random.below(40);
            self.pool.entities.swap_remove(at);
        }
        self.pool.entities.push((world, entity));
    }

    pub(crate) fn vertices(&mut self) -> Vec<u64> {
        let mut vertices = Vec::new();
        for _ in 0..self.random.below(4) {
            let made_up = self.random.chance(12) || self.pool.keys.is_empty();
            vertices.push(if made_up { self.random.next() } else { self.random.pick(&self.pool.keys) });
        }
        vertices
    }
}
