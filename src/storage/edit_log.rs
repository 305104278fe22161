//! The log of a mesh's edits: whoever keeps derived data remembers a [`Revision`] and asks which triangles have changed since.

use super::EditRecord;
use super::room::fit;
use std::sync::atomic::{AtomicU64, Ordering};

/// Number of the next history. No result depends on it.
static NEXT_HISTORY: AtomicU64 = AtomicU64::new(1);

/// Moment in the history of a mesh. The default is of no mesh's history.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Revision {
    history: u64,
    edits: u32,
}

/// Edits of one mesh so far, and per row of a triangle the last one that touched it. A copy begins a history of its own.
#[derive(Debug)]
pub(crate) struct EditLog {
    now: Revision,
    /// Empty before the first edit.
    touched: Vec<u32>,
}

impl Default for EditLog {
    fn default() -> Self {
        let history = NEXT_HISTORY.fetch_add(1, Ordering::Relaxed);
        Self { now: Revision { history, edits: 0 }, touched: Vec::new() }
    }
}

impl Clone for EditLog {
    fn clone(&self) -> Self {
        Self::default()
    }
}

impl EditLog {
    /// The present moment.
    pub(crate) fn now(&self) -> Revision {
        self.now
    }

    /// Whether the triangle in a row may be another, or have other corners or rest data, than at an earlier moment.
    pub(crate) fn has_changed(&self, triangle: u32, since: Revision) -> bool {
        let is_touched = || self.touched.get(triangle as usize).is_none_or(|&edit| edit > since.edits);
        since != self.now && (since.history != self.now.history || is_touched())
    }

    /// Whether any of some triangles may have changed since an earlier moment; true for a moment in another history.
    pub(crate) fn have_changed(&self, mut triangles: impl Iterator<Item = u32>, since: Revision) -> bool {
        let is_other = since.history != self.now.history;
        is_other || since != self.now && triangles.any(|triangle| self.has_changed(triangle, since))
    }

    /// Begins another history: all triangles have changed.
    pub(crate) fn renew(&mut self) {
        *self = Self::default();
    }

    /// Notes an edit that was applied, to a mesh whose lists of triangles have this room.
    pub(super) fn apply(&mut self, record: &EditRecord, room: usize) {
        self.note(record, [record.first_triangle as usize, record.triangle_count()], room);
    }

    /// Notes an edit that was undone.
    pub(super) fn undo(&mut self, record: &EditRecord, room: usize) {
        self.note(record, [record.triangle_count(), record.first_triangle as usize], room);
    }

    /// Notes a change of the number of triangles, and of the rows that an edit names.
    fn note(&mut self, record: &EditRecord, [before, after]: [usize; 2], room: usize) {
        if self.now.edits == u32::MAX {
            self.renew();
        }
        self.now.edits += 1;
        let most = before.max(after);
        // At once to where the tables have room: the next edits allocate nothing.
        fit(&mut self.touched, room.max(most));
        self.touched.resize(before, 0);
        self.touched.resize(most, self.now.edits);
        for (row, _) in record.triangles_before().chain(record.triangles_after()) {
            self.touched[row as usize] = self.now.edits;
        }
        self.touched.truncate(after);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::components::Material;
    use crate::generate;
    use crate::internal::Random;
    use crate::membrane::Membrane;
    use crate::settings::Settings;
    use crate::simulation::Simulation;
    use crate::storage::{Edit, Mesh, NONE, Order, Topology, Triangles, Vertices, apply, outlook, reorder, undo};

    /// Columns of a triangle that an edit may change.
    type Row = ([u32; 3], [u64; 2]);

    fn rows(triangles: &Triangles) -> Vec<Row> {
        let row = |t: usize| (triangles.corners[t], [triangles.rest[t].area, triangles.fibre[t].x].map(f64::to_bits));
        (0..triangles.len()).map(row).collect()
    }

    /// A vertex to a point of its first triangle.
    fn glide(mesh: &Mesh<'_>, vertex: u32) -> Edit {
        let entry = mesh.topology.incident[vertex as usize][0];
        let mut weights = [0.25; 3];
        weights[entry as usize % 3] = 0.5;
        Edit::Glide { vertex, triangle: entry / 3, weights }
    }

    fn random_edit(mesh: &Mesh<'_>, random: &mut Random) -> Edit {
        let mut below = |count: usize| (random.unit() * count as f64) as usize;
        let (triangle, edge, kind) = (below(mesh.triangles.len()) as u32, below(3), below(8));
        let corners = mesh.triangles.corners[triangle as usize];
        let (vertex, towards) = (corners[edge], corners[(edge + 1) % 3]);
        match kind {
            0 => Edit::SplitEdge { triangle, edge, weight: 0.4 },
            1 => Edit::SplitTriangle { triangle, weights: [0.25, 0.25, 0.5] },
            2 => Edit::Flip { triangle, edge },
            3 => Edit::Slide { vertex, towards, weight: 0.2 },
            4 => Edit::Collapse { vertex, into: towards },
            5 | 6 => {
                let glides = (0..mesh.vertices.len()).map(|row| glide(mesh, row as u32));
                let possible: Vec<Edit> = glides.filter(|edit| outlook(mesh, edit).is_ok()).collect();
                possible.get(below(possible.len().max(1))).cloned().unwrap_or(Edit::Flip { triangle, edge })
            }
            _ => {
                let open = (0..3).find(|&e| mesh.topology.neighbours[triangle as usize][e] == NONE).unwrap_or(edge);
                Edit::Open { path: [corners[open], corners[(open + 2) % 3]].into_iter().collect() }
            }
        }
    }

    fn with_mesh(test: impl FnOnce(&mut Mesh<'_>)) {
        let mut simulation = Simulation::new(Settings { threads: 1, ..Settings::default() }).unwrap();
        let sheet = generate::grid(8.0, 6.0, 16, 12).unwrap();
        let body = simulation.spawn(Membrane::new("sheet", sheet, Material::allard_2009())).unwrap();
        type Query<'a> = (&'a mut Vertices, &'a mut Triangles, &'a mut Topology);
        let found = simulation.world_mut().query_one_mut::<Query>(body.entity()).unwrap();
        let (vertices, triangles, topology) = found;
        test(&mut Mesh { vertices, triangles, topology });
    }

    #[test]
    fn whatever_differs_is_named() {
        with_mesh(|mesh| {
            let mut random = Random::new(7);
            let mut earlier = vec![(mesh.topology.log.now(), rows(mesh.triangles))];
            let (mut undone, mut glides, mut most_named) = (0, 0, 0);
            for round in 0..600 {
                let edit = random_edit(mesh, &mut random);
                if let Ok(record) = apply(mesh, &edit) {
                    glides += usize::from(matches!(edit, Edit::Glide { .. }));
                    if random.unit() < 0.3 {
                        undo(mesh, &record).unwrap();
                        undone += 1;
                    }
                    mesh.release();
                }
                if round == 400 {
                    let order = Order::along_curve(mesh);
                    reorder(mesh, &order);
                }
                let (log, now) = (&mesh.topology.log, rows(mesh.triangles));
                for (place, (since, before)) in earlier.iter().enumerate() {
                    let named = |t: &usize| log.has_changed(*t as u32, *since);
                    let differs = |t: &usize| before.get(*t) != Some(&now[*t]);
                    assert!((0..now.len()).filter(differs).all(|t| named(&t)), "{round}: {edit:?}");
                    let of_last = place + 1 == earlier.len() && round != 400;
                    most_named = most_named.max(if of_last { (0..now.len()).filter(named).count() } else { 0 });
                }
                if earlier.len() == 5 {
                    earlier.remove((random.unit() * 4.0) as usize);
                }
                earlier.push((log.now(), now));
            }
            assert!(undone > 50 && glides > 50 && most_named < 40, "{undone} {glides} {most_named}");
        });
    }

    #[test]
    fn another_history_has_changed_all() {
        with_mesh(|mesh| {
            let start = mesh.topology.log.now();
            assert!(mesh.topology.log.touched.is_empty() && !mesh.topology.log.has_changed(0, start));
            assert!(!mesh.topology.log.have_changed(0..9, start));
            let copy = mesh.topology.clone();
            assert_eq!(copy, *mesh.topology);
            assert!(copy.log.has_changed(0, start) && copy.log.have_changed(0..0, start));
            assert!(copy.log.have_changed(0..0, Revision::default()));
            // An edit after the last one that can be counted.
            mesh.topology.log.now.edits = u32::MAX;
            let late = mesh.topology.log.now();
            apply(mesh, &Edit::SplitTriangle { triangle: 3, weights: [0.25, 0.25, 0.5] }).unwrap();
            assert!((0..9).all(|t| mesh.topology.log.has_changed(t, late)));
            let (log, last) = (&mesh.topology.log, mesh.topology.log.now());
            assert!(log.now.edits == 1 && !log.have_changed(0..9, last));
        });
    }
}
