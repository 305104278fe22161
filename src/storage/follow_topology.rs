//! The topology follows edits: lists are patched around the touched triangles only.

use super::{EditRecord, Follow, Incidence, NONE, Tables, Topology};

impl Follow for Topology {
    fn apply(&mut self, record: &EditRecord, tables: Tables<'_>) {
        for changed in &record.changed_triangles {
            self.unlink(changed.row);
        }
        self.incident.resize(record.first_vertex as usize + record.new_vertices.len(), Incidence::new());
        for changed in &record.changed_triangles {
            self.move_corners(changed.row, changed.before.corners, changed.corners);
        }
        for (row, new) in (record.first_triangle..).zip(&record.new_triangles) {
            self.neighbours.push([NONE; 3]);
            for (corner, &vertex) in new.corners.iter().enumerate() {
                self.insert_incident(row, corner, vertex);
            }
        }
        for changed in &record.changed_triangles {
            self.link(&tables.triangles.corners, changed.row);
        }
        for (row, _) in (record.first_triangle..).zip(&record.new_triangles) {
            self.link(&tables.triangles.corners, row);
        }
    }

    fn undo(&mut self, record: &EditRecord, tables: Tables<'_>) {
        for (row, new) in (record.first_triangle..).zip(&record.new_triangles) {
            self.unlink(row);
            for (corner, &vertex) in new.corners.iter().enumerate() {
                self.remove_incident(row, corner, vertex);
            }
        }
        for changed in &record.changed_triangles {
            self.unlink(changed.row);
            self.move_corners(changed.row, changed.corners, changed.before.corners);
        }
        self.neighbours.truncate(record.first_triangle as usize);
        self.incident.truncate(record.first_vertex as usize);
        for changed in &record.changed_triangles {
            self.link(&tables.triangles.corners, changed.row);
        }
    }
}

impl Topology {
    fn move_corners(&mut self, triangle: u32, from: [u32; 3], to: [u32; 3]) {
        for corner in (0..3).filter(|&corner| from[corner] != to[corner]) {
            self.remove_incident(triangle, corner, from[corner]);
            self.insert_incident(triangle, corner, to[corner]);
        }
    }
}
