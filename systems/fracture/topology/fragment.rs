//! Detects fragments freed by tears that have met a boundary.

use crate::storage::NONE;
use crate::storage::room::fit;
use crate::systems::fracture::Cutter;

impl Cutter<'_, '_> {
    /// Makes room for the walks with the first cut, so that a cut that frees a fragment allocates none.
    pub(in crate::systems::fracture) fn make_room_to_walk(&mut self) {
        let room = self.mesh.triangles.corners.capacity();
        fit(&mut self.scratch.marks, room);
        self.scratch.queues.iter_mut().for_each(|queue| fit(queue, room / 2));
    }

    /// The number of triangles of the smaller part, where the two lips of the last opening, at the edge between these
    /// vertices, no longer hang together. Both parts are walked in turn, so the work follows the smaller one.
    pub(in crate::systems::fracture) fn freed_fragment(&mut self, from: u32, to: u32) -> Option<usize> {
        let lips = self.lips(from, to)?;
        let neighbours = &self.mesh.topology.neighbours;
        let scratch = &mut *self.scratch;
        scratch.marks.resize(neighbours.len().max(scratch.marks.len()), 0);
        for (side, queue) in scratch.queues.iter_mut().enumerate() {
            queue.clear();
            queue.push(lips[side]);
            scratch.marks[lips[side] as usize] = side as u8 + 1;
        }
        let mut next = [0, 0];
        let mut freed = None;
        'walk: while freed.is_none() {
            for side in 0..2 {
                let Some(&triangle) = scratch.queues[side].get(next[side]) else {
                    freed = Some(scratch.queues[side].len());
                    break 'walk;
                };
                next[side] += 1;
                for &neighbour in neighbours[triangle as usize].iter().filter(|&&n| n != NONE) {
                    let mark = &mut scratch.marks[neighbour as usize];
                    if *mark == 0 {
                        *mark = side as u8 + 1;
                        scratch.queues[side].push(neighbour);
                    } else if *mark != side as u8 + 1 {
                        break 'walk;
                    }
                }
            }
        }
        for queue in &scratch.queues {
            for &triangle in queue {
                scratch.marks[triangle as usize] = 0;
            }
        }
        freed
    }

    /// A triangle on each lip of the edge that the last opening has parted, at copies of these vertices.
    fn lips(&self, from: u32, to: u32) -> Option<[u32; 2]> {
        let opening =
            self.scratch.records.iter().rev().find(|r| matches!(r.edit, crate::storage::Edit::Open { .. }))?;
        let copies = |row: u32| {
            let made = opening.created().filter(move |(_, parents)| parents.rows() == [row]).map(|(copy, _)| copy);
            std::iter::once(row).chain(made)
        };
        let corners = &self.mesh.triangles.corners;
        let lip = |from: u32, to: u32| {
            let mut pairs = copies(from).flat_map(|a| copies(to).map(move |b| (a, b)));
            pairs.find_map(|(a, b)| {
                let (triangle, edge) = self.mesh.topology.directed_edge(corners, a, b)?;
                (self.mesh.topology.neighbours[triangle as usize][edge] == NONE).then_some(triangle)
            })
        };
        Some([lip(from, to)?, lip(to, from)?])
    }
}
