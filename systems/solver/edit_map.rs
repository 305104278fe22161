//! Edit map: interpolation from the vertices of a mesh when it was factored to its vertices now.
//!
//! Edits change the mesh. A factor of the mesh before them stays a good preconditioner if every new vertex takes the answer of the
//! vertices it came from. The vertices around the edits add the answer of their own block. This is additive Schwarz, with the old
//! mesh as its coarse space.

use crate::storage::{Edit, EditRecord};
use smallvec::SmallVec;

/// The old vertices that a vertex takes its part from.
type Link = SmallVec<[(u32, f64); 4]>;

/// Links to more old vertices than this are cut down to the heaviest: a vertex in the middle of much refined tissue.
const MOST_LINKS: usize = 4;

/// Room for so many vertices more than there are at the first edit, and one in sixteen: a factor serves a few dozen steps.
const SPARE: usize = 256;

/// Interpolation weights of every vertex since the factorisation. Empty until the first edit, before which every vertex is an old one.
#[derive(Clone, Debug, Default)]
#[cfg_attr(feature = "snapshot", derive(serde::Serialize, serde::Deserialize))]
pub(super) struct EditMap {
    link: Vec<Link>,
    is_touched: Vec<bool>,
}

impl EditMap {
    /// Whether the mesh is the one that was factored.
    pub(super) fn is_empty(&self) -> bool {
        self.link.is_empty()
    }

    /// Number of vertices now, once there was an edit.
    pub(super) fn vertex_count(&self) -> usize {
        self.link.len()
    }

    /// Whether it leads every one of `vertex_count` vertices, if any, to some of `old_count`.
    #[cfg(feature = "snapshot")]
    pub(super) fn is_sound(&self, vertex_count: usize, old_count: usize) -> bool {
        let is_there = |&(old, weight): &(u32, f64)| (old as usize) < old_count && weight.is_finite();
        self.link.len() == self.is_touched.len()
            && (self.is_empty() || self.link.len() == vertex_count)
            && self.link.iter().all(|link| !link.is_empty() && link.iter().all(is_there))
    }

    /// The old vertices behind a vertex with their weights.
    pub(super) fn links(&self, v: usize) -> &[(u32, f64)] {
        &self.link[v]
    }

    /// Whether edits have touched a triangle at a vertex.
    pub(super) fn is_touched(&self, v: usize) -> bool {
        self.is_touched[v]
    }

    /// The vertices in the triangles that edits have touched.
    pub(super) fn touched(&self) -> impl Iterator<Item = usize> + '_ {
        self.is_touched.iter().enumerate().filter(|&(_, &is_touched)| is_touched).map(|(v, _)| v)
    }

    /// Follows an edit.
    pub(super) fn follow(&mut self, record: &EditRecord) {
        if self.is_empty() {
            let room = record.first_vertex as usize + SPARE + record.first_vertex as usize / 16;
            self.link.reserve_exact(room);
            self.is_touched.reserve_exact(room);
            self.link.extend((0..record.first_vertex).map(|v| Link::from_slice(&[(v, 1.0)])));
            self.is_touched.resize(record.first_vertex as usize, false);
        }
        for (_, parents) in record.created() {
            let parts = parents.rows().iter().zip(parents.weights());
            let link = self.blend(parts.map(|(&row, &weight)| (row, weight)));
            self.link.push(link);
            self.is_touched.push(true);
        }
        if let Edit::Slide { vertex, towards, weight } = record.edit {
            self.link[vertex as usize] = self.blend([(vertex, 1.0 - weight), (towards, weight)].into_iter());
        }
        if let Some(removed) = &record.removed {
            self.link.swap_remove(removed.vertex as usize);
            self.is_touched.swap_remove(removed.vertex as usize);
        }
        let changed = record.changed_triangles.iter().map(|changed| changed.corners);
        for v in changed.chain(record.new_triangles.iter().map(|new| new.corners)).flatten() {
            self.is_touched[v as usize] = true;
        }
    }

    fn blend(&self, parts: impl Iterator<Item = (u32, f64)>) -> Link {
        let mut sum = Link::new();
        for (row, part) in parts {
            for &(old, weight) in &self.link[row as usize] {
                match sum.iter_mut().find(|(known, _)| *known == old) {
                    Some((_, known)) => *known += weight * part,
                    None => sum.push((old, weight * part)),
                }
            }
        }
        sum.sort_by(|a, b| b.1.total_cmp(&a.1).then(a.0.cmp(&b.0)));
        sum.truncate(MOST_LINKS);
        let total: f64 = sum.iter().map(|(_, weight)| weight).sum();
        sum.iter_mut().for_each(|(_, weight)| *weight /= total);
        sum
    }
}
