//! Which axes of every vertex are free to move.

use crate::storage::room::grow;
use glam::DVec3;
use std::ops::Index;

/// The free axes of every vertex of a body: 1 along those, 0 along prescribed ones. A byte for each, of which bits 0 to 2 are x to z.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "snapshot", derive(serde::Serialize, serde::Deserialize))]
pub struct FreeAxes(Vec<u8>);

/// Axis factors for each byte value.
static AXES: [DVec3; 8] = {
    let mut axes = [DVec3::ZERO; 8];
    let mut bits = 0;
    while bits < axes.len() {
        axes[bits] = DVec3::new((bits & 1) as f64, (bits >> 1 & 1) as f64, (bits >> 2) as f64);
        bits += 1;
    }
    axes
};

fn axes(bits: &u8) -> &'static DVec3 {
    &AXES[*bits as usize % AXES.len()]
}

fn bits(axes: DVec3) -> u8 {
    axes.cmpne(DVec3::ZERO).bitmask() as u8
}

/// The free axes of one vertex after the other.
pub type EachFree<'a> = std::iter::Map<std::slice::Iter<'a, u8>, fn(&u8) -> &'static DVec3>;

impl FreeAxes {
    /// Gives so many vertices these axes. Lists that have to grow grow as far as there is `room` in the table of vertices.
    pub fn reset(&mut self, count: usize, room: usize, axes: DVec3) {
        self.0.clear();
        grow(&mut self.0, count, room);
        self.0.resize(count, bits(axes));
    }

    /// Number of vertices.
    pub fn len(&self) -> usize {
        self.0.len()
    }

    /// Whether there is no vertex.
    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    /// The free axes of one vertex after the other.
    pub fn iter(&self) -> EachFree<'_> {
        self.0.iter().map(axes as fn(&u8) -> &'static DVec3)
    }

    /// Whether nothing is free along z.
    pub fn are_flat(&self) -> bool {
        self.iter().all(|axes| axes.z == 0.0)
    }

    /// Frees these axes of a vertex, and no others.
    pub fn set(&mut self, vertex: usize, axes: DVec3) {
        self.0[vertex] = bits(axes);
    }

    /// Prescribes an axis of a vertex.
    pub fn prescribe(&mut self, vertex: usize, axis: usize) {
        self.0[vertex] &= !(1 << axis);
    }

    /// Whether no byte has bits that stand for no axis, as one of a file might.
    pub fn are_sound(&self) -> bool {
        self.0.iter().all(|&bits| usize::from(bits) < AXES.len())
    }
}

impl Index<usize> for FreeAxes {
    type Output = DVec3;

    #[inline]
    fn index(&self, vertex: usize) -> &DVec3 {
        axes(&self.0[vertex])
    }
}

impl FromIterator<DVec3> for FreeAxes {
    fn from_iter<I: IntoIterator<Item = DVec3>>(axes: I) -> Self {
        Self(axes.into_iter().map(bits).collect())
    }
}

impl<'a> IntoIterator for &'a FreeAxes {
    type Item = &'static DVec3;
    type IntoIter = EachFree<'a>;

    fn into_iter(self) -> Self::IntoIter {
        self.iter()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn any_axes_may_be_free() {
        let all =
            [0, 1, 2, 3, 4, 5, 6, 7].map(|i: u8| DVec3::new((i & 1).into(), (i >> 1 & 1).into(), (i >> 2).into()));
        let mut free: FreeAxes = all.into_iter().collect();
        assert!(free.iter().eq(&all) && (0..8).all(|v| free[v] == all[v]));
        free.prescribe(7, 1);
        assert_eq!(free[7], DVec3::new(1.0, 0.0, 1.0));
        free.set(0, DVec3::Y);
        assert_eq!(free[0], DVec3::Y);
        assert!(!free.are_flat());
        free.reset(3, 5, DVec3::new(1.0, 1.0, 0.0));
        assert!(free.are_flat());
        free.reset(3, 5, DVec3::Z);
        assert!(free.iter().eq(&[DVec3::Z; 3]));
    }
}
