//! Two parts of the rows that have no block with each other, and the rest, which has blocks with both: two threads factor and sweep them
//! side by side, and each does so with the rows of the triangles that it multiplies.
//!
//! Triangles before the *cut* have no vertex in the second part, those from it on none in the first. So it stays under edits: new rows
//! belong to the rest, and a row that a triangle from across the cut has come to goes over to it. The cut depends on the triangles alone,
//! never on the number of threads.

use std::ops::Range;

/// Where the parts begin. Without a cut all rows are the rest.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "snapshot", derive(serde::Serialize, serde::Deserialize))]
pub(super) struct Halves {
    /// First row of the second part.
    pub second: u32,
    /// First row of the rest.
    pub rest: u32,
    /// First triangle from the cut on.
    pub cut: u32,
}

impl Halves {
    /// Whether there are two parts.
    pub(super) fn are_cut(&self) -> bool {
        self.cut > 0
    }

    /// The rows of the first part, of the second and of the rest, of so many.
    pub(super) fn ranges(&self, rows: usize) -> [Range<usize>; 3] {
        let (second, rest) = (self.second as usize, self.rest as usize);
        [0..second, second..rest, rest..rows]
    }

    /// A list that has an entry for every row, by parts.
    pub(super) fn split<'a, T>(&self, list: &'a mut [T]) -> [&'a mut [T]; 3] {
        let (parts, rest) = list.split_at_mut(self.rest as usize);
        let (first, second) = parts.split_at_mut(self.second as usize);
        [first, second, rest]
    }

    /// Whether a triangle may have a vertex in a row.
    pub(super) fn may_have(&self, triangle: u32, row: u32) -> bool {
        row >= self.rest || (row < self.second) == (triangle < self.cut)
    }

    /// Whether these are parts of so many rows of triangles with their corners in these.
    pub(super) fn are_of(&self, rows: usize, corners: impl Iterator<Item = [u32; 3]>) -> bool {
        let are_in_order = self.second <= self.rest && self.rest as usize <= rows;
        let are_none = self.rest == 0;
        are_in_order
            && (self.are_cut() || are_none)
            && (0..).zip(corners).all(|(t, corners)| corners.into_iter().all(|row| self.may_have(t, row)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parts_are_apart_or_are_none() {
        // Rows 0 and 1 have the first triangle to themselves, row 2 the second, which share rows 3 and 4.
        let corners = [[0, 1, 3], [2, 3, 4]];
        let are_halves = |second, rest, cut| Halves { second, rest, cut }.are_of(5, corners.into_iter());
        assert!(are_halves(2, 3, 1) && !are_halves(1, 2, 1) && are_halves(0, 0, 0));
        // A triangle across the cut, parts out of order or beyond the rows, and parts without a cut.
        assert!(!are_halves(2, 4, 1) && !are_halves(3, 2, 1) && !are_halves(2, 6, 1) && !are_halves(0, 3, 0));
    }
}
