//! The motions that guides of holds allow, as a step needs them.

use crate::components::{Guide, Hold, Planar};
use glam::{DMat3, DVec3};
use smallvec::SmallVec;
use std::ops::Range;

/// Motions of guided vertices: lists of rows that move alike, each along up to three orthonormal directions. *Derived*, with the free axes.
#[derive(Clone, Debug, Default)]
pub struct GuideConstraints {
    rows: Vec<u32>,
    groups: Vec<Group>,
    /// Inverse block of each list in the solve at hand \[mm/N\].
    pub(crate) inverse_blocks: Vec<DMat3>,
    /// Vectors of the guided rows while all rows are scaled.
    guided: Vec<DVec3>,
}

/// Vertices that move alike.
#[derive(Clone, Debug)]
struct Group {
    rows: Range<usize>,
    directions: SmallVec<[DVec3; 3]>,
    /// Force on all vertices of the group together \[N\].
    force: DVec3,
}

impl GuideConstraints {
    /// Forgets all.
    pub fn clear(&mut self) {
        self.rows.clear();
        self.groups.clear();
    }

    /// Whether no vertex is guided.
    pub fn is_empty(&self) -> bool {
        self.groups.is_empty()
    }

    /// Takes up a guided hold, at a time \[ms\].
    pub fn add(&mut self, hold: &Hold, guide: &Guide, planar: Option<&Planar>, time: f64) {
        let rows = hold.members.rows();
        let across = |n: DVec3| {
            let first = n.any_orthonormal_vector();
            SmallVec::from_slice(&[first, n.cross(first)])
        };
        let (directions, force): (SmallVec<[DVec3; 3]>, DVec3) = match guide {
            // In the plane there is one direction across another.
            Guide::Across(n) if planar.is_some() => (SmallVec::from_slice(&[DVec3::Z.cross(*n)]), DVec3::ZERO),
            Guide::Across(n) => (across(*n), DVec3::ZERO),
            Guide::Along(d) => (SmallVec::from_slice(&[*d]), DVec3::ZERO),
            Guide::Together { force, curve } => {
                let axes = [DVec3::X, DVec3::Y, DVec3::Z].into_iter().zip(hold.axes);
                let axes = axes.filter(|(axis, is_held)| *is_held && !(planar.is_some() && axis.z != 0.0));
                (axes.map(|(axis, _)| axis).collect(), *force * curve.at(time))
            }
        };
        let alike = if matches!(guide, Guide::Together { .. }) { rows.len() } else { 1 };
        for rows in rows.chunks(alike.max(1)) {
            let first = self.rows.len();
            let force = directions.iter().map(|d| *d * d.dot(force)).sum();
            self.rows.extend_from_slice(rows);
            self.groups.push(Group { rows: first..self.rows.len(), directions: directions.clone(), force });
        }
    }

    /// Number of lists of rows that move alike.
    pub fn len(&self) -> usize {
        self.groups.len()
    }

    /// The rows of a list and the directions along which they move.
    pub fn group(&self, group: usize) -> (&[u32], &[DVec3]) {
        let Group { rows, directions, .. } = &self.groups[group];
        (&self.rows[rows.clone()], directions)
    }

    /// Calls with every list's rows, and the mean of the vectors there as far as it lies along their directions.
    fn for_each_mean(&self, vectors: &mut [DVec3], mut call: impl FnMut(&mut [DVec3], &[u32], &[DVec3], DVec3)) {
        for group in 0..self.len() {
            let (rows, directions) = self.group(group);
            let mean = rows.iter().map(|&row| vectors[row as usize]).sum::<DVec3>() / rows.len().max(1) as f64;
            let part = directions.iter().map(|d| *d * d.dot(mean)).sum();
            call(vectors, rows, directions, part);
        }
    }

    /// Replaces the components along the directions by their mean, for vertices that move alike.
    pub fn level(&self, vectors: &mut [DVec3]) {
        self.for_each_mean(vectors, |vectors, rows, directions, mean| {
            for &row in rows.iter().filter(|_| rows.len() > 1) {
                let own = &mut vectors[row as usize];
                let along: DVec3 = directions.iter().map(|d| *d * d.dot(*own)).sum();
                *own += mean - along;
            }
        });
    }

    /// Takes the vectors of the guided rows.
    pub(crate) fn take_guided(&mut self, vectors: &[DVec3]) {
        self.guided.clear();
        self.guided.extend(self.rows.iter().map(|&row| vectors[row as usize]));
    }

    /// Adds the parts along the directions of the vectors [taken](Self::take_guided), times a factor.
    pub(crate) fn add_guided(&self, factor: f64, vectors: &mut [DVec3]) {
        for Group { rows, directions, .. } in &self.groups {
            for (&row, own) in self.rows[rows.clone()].iter().zip(&self.guided[rows.clone()]) {
                let along: DVec3 = directions.iter().map(|d| *d * d.dot(*own)).sum();
                vectors[row as usize] += along * factor;
            }
        }
    }

    /// Subtracts the mean component along the directions, for vertices that move alike.
    pub fn take(&self, vectors: &mut [DVec3]) {
        self.for_each_mean(vectors, |vectors, rows, _, mean| {
            rows.iter().for_each(|&row| vectors[row as usize] -= mean);
        });
    }

    /// Adds the forces on those that move alike \[N\].
    pub fn add_forces(&self, vectors: &mut [DVec3]) {
        for Group { rows, force, .. } in &self.groups {
            let rows = &self.rows[rows.clone()];
            let share = *force / rows.len().max(1) as f64;
            rows.iter().for_each(|&row| vectors[row as usize] += share);
        }
    }

    /// The largest part along a direction of the sums of forces \[N\] on those that move alike, over the root of their number.
    pub fn imbalance(&self, forces: &[DVec3]) -> f64 {
        let of_group = |Group { rows, directions, force }: &Group| {
            let rows = &self.rows[rows.clone()];
            let sum = *force + rows.iter().map(|&row| forces[row as usize]).sum::<DVec3>();
            let root = (rows.len().max(1) as f64).sqrt();
            // NaN counts as infinitely large.
            let part = |d: &DVec3| Some(d.dot(sum).abs() / root).filter(|part| !part.is_nan()).unwrap_or(f64::INFINITY);
            directions.iter().map(part).fold(0.0, f64::max)
        };
        self.groups.iter().map(of_group).fold(0.0, f64::max)
    }

    /// Work of the forces along a way \[mJ\], and the squared norm of those parts of them that find a way \[N²\].
    pub fn merit(&self, way: &[DVec3], forces: &[DVec3]) -> (f64, f64) {
        self.groups.iter().fold((0.0, 0.0), |(work, norm_sq), Group { rows, directions, force }| {
            let rows = &self.rows[rows.clone()];
            let count = rows.len().max(1) as f64;
            let sum = *force + rows.iter().map(|&row| forces[row as usize]).sum::<DVec3>();
            let mean = rows.iter().map(|&row| way[row as usize]).sum::<DVec3>() / count;
            let parts = |of: DVec3| directions.iter().map(move |d| d.dot(of));
            let along: f64 = parts(sum).zip(parts(mean)).map(|(f, u)| f * u).sum();
            (work + along, norm_sq + parts(sum).map(|f| f * f).sum::<f64>() / count)
        })
    }
}
