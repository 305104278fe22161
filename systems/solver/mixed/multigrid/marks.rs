//! Marks of the rows of a level that edits have reached.

use super::super::empty;
use super::super::pattern::BlockPattern;

/// The mark of a row.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Mark(u8);

impl Mark {
    /// Has other neighbours or stands elsewhere, or may: data that depends on it is recomputed.
    pub(super) const STALE: Self = Self(1);
    /// Near an edit, too: may become a node. It follows from the edits and the levels as they are, not from those before.
    pub(super) const REACHED: Self = Self(3);

    /// Marks with another as well.
    pub(super) fn add(&mut self, other: Self) {
        self.0 |= other.0;
    }

    /// The mark reduced to [`STALE`](Self::STALE).
    pub(super) fn of_stale(self) -> Self {
        Self(self.0 & Self::STALE.0)
    }
}

/// Marks of all rows.
#[derive(Debug, Default)]
pub(super) struct Marks(Vec<Mark>);

impl Marks {
    /// So many rows without any.
    pub(super) fn clear(&mut self, count: usize) {
        empty(&mut self.0, count);
        self.0.resize(count, Mark::default());
    }

    /// Marks a row.
    pub(super) fn add(&mut self, row: usize, mark: Mark) {
        self.0[row].add(mark);
    }

    /// Marks all rows.
    pub(super) fn add_to_all(&mut self, mark: Mark) {
        self.0.iter_mut().for_each(|own| own.add(mark));
    }

    /// Whether a row has any.
    pub(super) fn is_any(&self, row: usize) -> bool {
        self.0[row] != Mark::default()
    }

    /// Whether a row is near an edit.
    pub(super) fn is_reached(&self, row: usize) -> bool {
        self.0[row] == Mark::REACHED
    }

    /// The marks in the order of rows.
    pub(super) fn iter(&self) -> impl Iterator<Item = Mark> + '_ {
        self.0.iter().copied()
    }

    /// The marks themselves.
    pub(super) fn as_mut_slice(&mut self) -> &mut [Mark] {
        &mut self.0
    }

    /// The marks of others, and those of a row on its neighbours too.
    pub(super) fn spread_from(&mut self, others: &Self, pattern: &BlockPattern) {
        self.clear(others.0.len());
        for (row, mark) in others.0.iter().enumerate().filter(|(_, mark)| **mark != Mark::default()) {
            self.add(row, *mark);
            pattern.neighbours(row).for_each(|near| self.add(near as usize, *mark));
        }
    }
}
