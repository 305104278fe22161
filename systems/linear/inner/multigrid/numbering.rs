//! The order in which a level's rows are swept: chunks of rows that are near each other, every second chunk first.
//!
//! Where a row has blocks with its own chunk and the two beside it only, the chunks of one colour do not depend on each other:
//! they are swept side by side, and yet the sweep is that of Gauss and Seidel, in one order for any number of threads.

/// Rows of a chunk at the least: handing one to a thread costs some microseconds, sweeping it twenty.
const LEAST_SIZE: u32 = 1024;

/// Fewer chunks than this are not worth it: the level is swept in one piece.
const LEAST_COUNT: u32 = 4;

/// The numbering of a level. A row has a *place* along the surface and its number in the sweep.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Numbering {
    /// Rows.
    pub count: u32,
    /// Rows of the first colour, which come first.
    pub first: u32,
    /// Chunks have two to the power of this many rows.
    bits: u32,
}

impl Numbering {
    /// All rows in one piece.
    pub fn single(count: usize) -> Self {
        let count = count as u32;
        Self { count, first: count, bits: 31 }
    }

    /// Chunks that are as small as they can be for rows that have blocks with each other up to so many places away.
    pub fn of_width(count: usize, width: u32) -> Self {
        let bits = width.max(LEAST_SIZE).next_power_of_two().trailing_zeros();
        let count = count as u32;
        if count.div_ceil(1 << bits) < LEAST_COUNT {
            return Self::single(count as usize);
        }
        let (pairs, rest) = (count >> (bits + 1), count & ((2 << bits) - 1));
        Self { count, first: (pairs << bits) + rest.min(1 << bits), bits }
    }

    /// Rows of a chunk.
    pub fn size(&self) -> usize {
        1 << self.bits
    }

    /// The row at a place.
    #[inline(always)]
    pub fn row(&self, place: u32) -> u32 {
        let (chunk, within) = (place >> self.bits, place & ((1 << self.bits) - 1));
        ((chunk >> 1) << self.bits) + within + if chunk & 1 == 1 { self.first } else { 0 }
    }

    /// The place of a row.
    #[inline(always)]
    pub fn place(&self, row: u32) -> u32 {
        let (row, colour) = if row < self.first { (row, 0) } else { (row - self.first, 1) };
        let (pair, within) = (row >> self.bits, row & ((1 << self.bits) - 1));
        ((2 * pair + colour) << self.bits) + within
    }
}

#[cfg(test)]
mod tests {
    use super::*;

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
