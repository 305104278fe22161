//! The topology follows edits: lists are patched around the touched triangles only. All of these are taken out at the rows and
//! corners they had and put in again at those they have. A vertex that is added, removed or moved to another row has no triangles
//! in between, so that the lists only grow or shrink at their end.

use super::{EditRecord, Follow, Incidence, NONE, Tables, Topology};

impl Follow for Topology {
    fn apply(&mut self, record: &EditRecord, tables: Tables<'_>) {
        self.take_out(record.triangles_before());
        self.incident.resize(record.vertex_count(), Incidence::new());
        self.neighbours.resize(record.triangle_count(), [NONE; 3]);
        self.put_in(&tables.triangles.corners, record.triangles_after());
        self.log.apply(record, self.neighbours.capacity());
    }

    fn undo(&mut self, record: &EditRecord, tables: Tables<'_>) {
        self.take_out(record.triangles_after());
        self.incident.resize(record.first_vertex as usize, Incidence::new());
        self.neighbours.resize(record.first_triangle as usize, [NONE; 3]);
        self.put_in(&tables.triangles.corners, record.triangles_before());
        self.log.undo(record, self.neighbours.capacity());
    }
}

impl Topology {
    fn take_out(&mut self, triangles: impl Iterator<Item = (u32, [u32; 3])>) {
        for (row, corners) in triangles {
            self.unlink(row);
            for (corner, vertex) in corners.into_iter().enumerate() {
                self.remove_incident(row, corner, vertex);
            }
        }
    }

    fn put_in(&mut self, corners: &[[u32; 3]], triangles: impl Iterator<Item = (u32, [u32; 3])> + Clone) {
        for (row, corners) in triangles.clone() {
            for (corner, vertex) in corners.into_iter().enumerate() {
                self.insert_incident(row, corner, vertex);
            }
        }
        for (row, _) in triangles {
            self.link(corners, row);
        }
    }
}
