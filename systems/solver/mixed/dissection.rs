//! Nested dissection of the rows into two subdomains and their separator. The subdomains have no block with each other. Two threads factor
//! and sweep them side by side, each with the rows of the triangles that it multiplies.
//!
//! Triangles before the *cut* have no vertex in the second subdomain, those from it on none in the first. So it stays under edits: new rows
//! belong to the separator, and a row that a triangle from across the cut has come to goes over to it. The cut depends on the triangles alone,
//! never on the number of threads.

use std::ops::Range;

/// First rows of the second subdomain and of the separator. Without a cut all rows are the separator.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "snapshot", derive(serde::Serialize, serde::Deserialize))]
pub(super) struct Dissection {
    /// First row of the second subdomain.
    pub second: u32,
    /// First row of the separator.
    pub separator: u32,
    /// First triangle from the cut on.
    pub cut: u32,
}

impl Dissection {
    /// Whether there are two subdomains.
    pub(super) fn are_cut(&self) -> bool {
        self.cut > 0
    }

    /// Rows of the two subdomains and of the separator, of so many.
    pub(super) fn ranges(&self, rows: usize) -> [Range<usize>; 3] {
        let (second, separator) = (self.second as usize, self.separator as usize);
        [0..second, second..separator, separator..rows]
    }

    /// A list with an entry per row, split into the two subdomains and the separator.
    pub(super) fn split<'a, T>(&self, list: &'a mut [T]) -> [&'a mut [T]; 3] {
        let (parts, separator) = list.split_at_mut(self.separator as usize);
        let (first, second) = parts.split_at_mut(self.second as usize);
        [first, second, separator]
    }

    /// Whether a triangle may have a vertex in a row.
    pub(super) fn may_have(&self, triangle: u32, row: u32) -> bool {
        row >= self.separator || (row < self.second) == (triangle < self.cut)
    }

    /// Whether this is a dissection of so many rows, of triangles with their corners in these.
    pub(super) fn are_of(&self, rows: usize, corners: impl Iterator<Item = [u32; 3]>) -> bool {
        let are_in_order = self.second <= self.separator && self.separator as usize <= rows;
        let are_none = self.separator == 0;
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
        let are_halves = |second, separator, cut| Dissection { second, separator, cut }.are_of(5, corners.into_iter());
        assert!(are_halves(2, 3, 1) && !are_halves(1, 2, 1) && are_halves(0, 0, 0));
        // A triangle across the cut, subdomains out of order or beyond the rows, and subdomains without a cut.
        assert!(!are_halves(2, 4, 1) && !are_halves(3, 2, 1) && !are_halves(2, 6, 1) && !are_halves(0, 3, 0));
    }
}
