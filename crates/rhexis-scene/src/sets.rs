//! Sets of rows.

/// Sets of rows that are joined one by one.
pub(super) struct Sets(Vec<u32>);

impl Sets {
    /// Every row by itself.
    pub(super) fn new(count: usize) -> Self {
        Self((0..count as u32).collect())
    }

    /// The first row of the set that a row is in.
    pub(super) fn first(&mut self, mut row: u32) -> u32 {
        while self.0[row as usize] != row {
            self.0[row as usize] = self.0[self.0[row as usize] as usize];
            row = self.0[row as usize];
        }
        row
    }

    /// Makes one set of two.
    pub(super) fn join(&mut self, a: u32, b: u32) {
        let (a, b) = (self.first(a), self.first(b));
        self.0[a.max(b) as usize] = a.min(b);
    }

    /// Sets of which the first row is counted.
    pub(super) fn count(&self, is_counted: impl Fn(usize) -> bool) -> usize {
        self.0.iter().enumerate().filter(|(row, first)| *row == **first as usize && is_counted(*row)).count()
    }
}
