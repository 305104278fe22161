//! The order in which a level's rows are swept: chunks of rows that are near each other, every second chunk first.
//!
//! Where a row has blocks with its own chunk and the two beside it only, the chunks of one colour do not depend on each other. They
//! are swept side by side, and yet the sweep is that of Gauss and Seidel, in one order for any number of threads. Rows that edits
//! have added may have blocks with any other: they are swept last, one after another.

/// Rows of a chunk at the least: handing one to a thread costs some microseconds, sweeping it twenty.
const LEAST_SIZE: u32 = 1024;

/// Fewer chunks than this are not worth it: the level is swept in one piece.
const LEAST_COUNT: u32 = 4;

/// [`LEAST_SIZE`] as a power of two, and a power that is larger than every number of rows.
const LEAST_BITS: u32 = LEAST_SIZE.trailing_zeros();
const ONE_PIECE: u32 = 31;

/// The numbering of a level. A row has a *place* along the surface and its number in the sweep.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Numbering {
    /// Rows.
    pub count: u32,
    /// Rows that stand in chunks; those after them were added later.
    base: u32,
    /// Rows of the first colour, which come first.
    pub first: u32,
    /// Chunks have two to the power of this many rows.
    bits: u32,
}

impl Numbering {
    /// All rows in one piece.
    pub(super) fn single(count: usize) -> Self {
        let count = count as u32;
        Self { count, base: count, first: count, bits: ONE_PIECE }
    }

    /// Chunks that are as small as they can be for rows that have blocks with each other up to so many places away.
    pub(super) fn of_width(count: usize, width: u32) -> Self {
        let bits = width.max(LEAST_SIZE).next_power_of_two().trailing_zeros();
        Self::of_chunks(count as u32, bits).unwrap_or(Self::single(count))
    }

    /// Chunks of two to the power of so many rows; `None` where they would be too few.
    fn of_chunks(count: u32, bits: u32) -> Option<Self> {
        let (pairs, rest) = (count >> (bits + 1), count & ((2 << bits) - 1));
        let first = (pairs << bits) + rest.min(1 << bits);
        (count.div_ceil(1 << bits) >= LEAST_COUNT).then_some(Self { count, base: count, first, bits })
    }

    /// Arguments that [`of_kept`](Self::of_kept) remakes the numbering from: rows in chunks, and their size as a power of two.
    pub(super) fn kept(&self) -> [u32; 2] {
        [self.base, self.bits]
    }

    /// The numbering of so many rows that was kept; `None` where there is none.
    pub(super) fn of_kept([base, bits]: [u32; 2], count: usize) -> Option<Self> {
        let count = u32::try_from(count).ok().filter(|&count| base <= count)?;
        let numbering = match bits {
            ONE_PIECE => Self::single(base as usize),
            LEAST_BITS..ONE_PIECE => Self::of_chunks(base, bits)?,
            _ => return None,
        };
        Some(Self { count, ..numbering })
    }

    /// Adds rows at the end.
    pub(super) fn grow(&mut self, count: usize) {
        self.count = count as u32;
    }

    /// Rows of the first colour, of the second, and those that were added.
    pub(super) fn split<'a, T>(&self, rows: &'a mut [T]) -> [&'a mut [T]; 3] {
        let (chunks, added) = rows.split_at_mut(self.base as usize);
        let (first, second) = chunks.split_at_mut(self.first as usize);
        [first, second, added]
    }

    /// Whether a sweep allows for a block of two rows.
    pub(super) fn may_meet(&self, a: u32, b: u32) -> bool {
        let chunk =
            |row: u32| if row < self.first { (0, row >> self.bits) } else { (1, (row - self.first) >> self.bits) };
        let ((colour_a, chunk_a), (colour_b, chunk_b)) = (chunk(a), chunk(b));
        a.max(b) >= self.base || colour_a != colour_b || chunk_a == chunk_b
    }

    /// Rows of a chunk.
    pub(super) fn size(&self) -> usize {
        1 << self.bits
    }

    /// The row at a place.
    #[inline(always)]
    pub(super) fn row(&self, place: u32) -> u32 {
        if place >= self.base {
            return place;
        }
        let (chunk, within) = (place >> self.bits, place & ((1 << self.bits) - 1));
        ((chunk >> 1) << self.bits) + within + if chunk & 1 == 1 { self.first } else { 0 }
    }

    /// The place of a row.
    #[inline(always)]
    pub(super) fn place(&self, row: u32) -> u32 {
        if row >= self.base {
            return row;
        }
        let (row, colour) = if row < self.first { (row, 0) } else { (row - self.first, 1) };
        let (pair, within) = (row >> self.bits, row & ((1 << self.bits) - 1));
        ((2 * pair + colour) << self.bits) + within
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn added_rows_stand_last_and_may_meet_any() {
        let mut numbering = Numbering::of_width(8192, 700);
        numbering.grow(8200);
        assert_eq!(Numbering::of_kept(numbering.kept(), 8200), Some(numbering));
        for row in 8192..8200 {
            assert_eq!((numbering.row(row), numbering.place(row)), (row, row));
            assert!((0..8200).all(|other| numbering.may_meet(row, other) && numbering.may_meet(other, row)));
        }
        // Chunks 0, 2, 4, 6 come first.
        assert!(numbering.may_meet(5, 1000) && numbering.may_meet(5, 4096) && !numbering.may_meet(5, 1024));
        assert!(!numbering.may_meet(4096, 5120));
        let mut rows: Vec<u32> = (0..8200).collect();
        assert_eq!(numbering.split(&mut rows).map(|part| part.len()), [4096, 4096, 8]);
        for kept in [[8192, 9], [8192, 32], [8192, 12], [9000, 10]] {
            assert_eq!(Numbering::of_kept(kept, 8200), None);
        }
    }

    #[test]
    fn places_and_rows_are_each_others_inverse() {
        for count in [0, 1, 100, 4096, 4097, 5000, 8192, 9217, 20_000] {
            for numbering in
                [Numbering::single(count), Numbering::of_width(count, 700), Numbering::of_width(count, 1500)]
            {
                let mut is_met = vec![false; count];
                for place in 0..count as u32 {
                    let row = numbering.row(place);
                    assert_eq!(numbering.place(row), place, "{numbering:?}");
                    assert!(!std::mem::replace(&mut is_met[row as usize], true));
                    // Colours alternate.
                    let colour = place / numbering.size() as u32 % 2;
                    assert_eq!(row >= numbering.first, colour == 1);
                }
            }
        }
    }
}
