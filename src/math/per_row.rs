//! Values of rows that may all be one.

use std::ops::Index;

/// One value per row, or one for all of them: a kernel's view of a list that keeps a uniform value only once.
#[derive(Clone, Copy, Debug)]
pub struct PerRow<'a, T> {
    values: &'a [T],
    /// Mask from a row to the place of its value: no bits or all.
    mask: usize,
}

impl<'a, T> PerRow<'a, T> {
    /// A value for each row.
    pub fn each(values: &'a [T]) -> Self {
        Self { values, mask: usize::MAX }
    }

    /// The first value for all rows; none of them may be read where there is no value.
    pub fn uniform(values: &'a [T]) -> Self {
        Self { values, mask: 0 }
    }
}

impl<T> Index<usize> for PerRow<'_, T> {
    type Output = T;

    #[inline(always)]
    fn index(&self, row: usize) -> &T {
        &self.values[row & self.mask]
    }
}
