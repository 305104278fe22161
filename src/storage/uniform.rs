//! A column that is uniform in most bodies: one value for all rows.

use super::order;
use super::table::Column;
use crate::math::PerRow;
use std::ops::{Index, IndexMut};

/// A list that keeps one value while it is uniform, and one per row from the first that differs. The material of most bodies is uniform.
///
/// Indexing is as of a `Vec`, but that no row beyond the end is noticed while it is uniform. To write through an index gives every
/// row a value of its own.
#[derive(Clone, Debug)]
pub struct Uniform<T> {
    /// One value or none while it is uniform, else one per row.
    values: Vec<T>,
    /// Mask from a row to the place of its value: no bits while the list is uniform, else all.
    mask: usize,
    len: usize,
    /// Rows that there is to be room for, should they come to differ.
    room: usize,
}

impl<T> Default for Uniform<T> {
    fn default() -> Self {
        Self { values: Vec::new(), mask: 0, len: 0, room: 0 }
    }
}

impl<T: Copy + PartialEq> Uniform<T> {
    /// Adds a row at the end.
    pub fn push(&mut self, value: T) {
        if self.len == 0 {
            self.values.clear();
            self.mask = 0;
        } else if self.mask == 0 && self.values[0] != value {
            self.part();
        }
        if self.len == 0 || self.mask != 0 {
            self.values.push(value);
        }
        self.len += 1;
    }

    /// Takes the last row away.
    pub fn pop(&mut self) -> Option<T> {
        let last = self.len.checked_sub(1)?;
        Some(self.swap_remove(last))
    }

    /// Takes a row away; the last one takes its place.
    ///
    /// # Panics
    /// If there is no such row.
    pub fn swap_remove(&mut self, row: usize) -> T {
        assert!(row < self.len, "row {row} of {}", self.len);
        self.len -= 1;
        if self.mask == 0 { self.values[0] } else { self.values.swap_remove(row) }
    }

    /// Swaps two rows.
    pub fn swap(&mut self, a: usize, b: usize) {
        if self.mask != 0 {
            self.values.swap(a, b);
        }
    }

    /// Makes room for so many more rows, and no more.
    pub fn reserve_exact(&mut self, additional: usize) {
        self.room = self.room.max(self.len + additional);
        if self.mask != 0 {
            self.values.reserve_exact(additional);
        }
    }

    /// Keeps room for as many rows as another column does.
    pub(crate) fn take_room_of(&mut self, other: &Self) {
        self.room = self.room.max(other.room);
        if self.mask != 0 && self.room > self.len {
            self.values.reserve_exact(self.room - self.len);
        }
    }

    /// Gives every row a value of its own.
    fn part(&mut self) {
        let Some(&one) = self.values.first() else { return };
        self.values.reserve(self.room.max(self.len + 1) - 1);
        self.values.resize(self.len, one);
        self.mask = usize::MAX;
    }
}

impl<T> Uniform<T> {
    /// Number of rows.
    pub fn len(&self) -> usize {
        self.len
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.len == 0
    }

    /// Whether one value stands for all rows.
    pub fn is_uniform(&self) -> bool {
        self.mask == 0
    }

    /// The value of a row, if there is one.
    pub fn get(&self, row: usize) -> Option<&T> {
        if row < self.len { self.values.get(row & self.mask) } else { None }
    }

    /// A list of as many rows, each a function of that of this one.
    pub(crate) fn map(&self, f: impl Fn(&T) -> T) -> Self {
        let Self { values, mask, len, room } = self;
        Self { values: values.iter().map(f).collect(), mask: *mask, len: *len, room: *room }
    }

    /// The values by row, for a kernel.
    pub fn by_row(&self) -> PerRow<'_, T> {
        if self.mask == 0 { PerRow::uniform(&self.values) } else { PerRow::each(&self.values) }
    }

    /// All rows.
    pub fn iter(&self) -> impl ExactSizeIterator<Item = &T> {
        (0..self.len).map(|row| &self[row])
    }
}

impl<T> Index<usize> for Uniform<T> {
    type Output = T;

    #[inline(always)]
    fn index(&self, row: usize) -> &T {
        &self.values[row & self.mask]
    }
}

impl<T: Copy + PartialEq> IndexMut<usize> for Uniform<T> {
    fn index_mut(&mut self, row: usize) -> &mut T {
        if self.mask == 0 {
            self.part();
        }
        &mut self.values[row]
    }
}

impl<T: Copy + PartialEq> FromIterator<T> for Uniform<T> {
    fn from_iter<I: IntoIterator<Item = T>>(rows: I) -> Self {
        let mut column = Self::default();
        rows.into_iter().for_each(|value| column.push(value));
        column
    }
}

impl<T: Copy + PartialEq> Column<T> for Uniform<T> {
    fn put(&mut self, row: usize, value: T) {
        if self[row] != value {
            self[row] = value;
        }
    }

    fn sort(&mut self, order: &[u32]) {
        if self.mask != 0 {
            order::sort(order, &mut self.values);
        }
    }
}

/// As the number of rows and their values, of which there is one where it is uniform.
#[cfg(feature = "snapshot")]
impl<T: PartialEq + serde::Serialize> serde::Serialize for Uniform<T> {
    fn serialize<S: serde::Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let values = if self.len == 0 { &[][..] } else { &self.values };
        let are_alike = values.windows(2).all(|pair| pair[0] == pair[1]);
        (self.len as u64, if are_alike { &values[..values.len().min(1)] } else { values }).serialize(serializer)
    }
}

#[cfg(feature = "snapshot")]
impl<'de, T: Copy + PartialEq + serde::Deserialize<'de>> serde::Deserialize<'de> for Uniform<T> {
    fn deserialize<D: serde::Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let (len, values) = <(u64, Vec<T>)>::deserialize(deserializer)?;
        let len = usize::try_from(len).map_err(serde::de::Error::custom)?;
        let are_alike = values.len() == 1 || len == 0 && values.is_empty();
        if !are_alike && values.len() != len {
            return Err(serde::de::Error::custom("a column has neither one value nor one for each row"));
        }
        let mask = if are_alike { 0 } else { usize::MAX };
        Ok(Self { values, mask, len, room: 0 })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Whatever is done to it, it holds the values of a plain list.
    #[test]
    fn it_is_a_list() {
        let (mut column, mut list) = (Uniform::default(), Vec::new());
        let mut number = 12_345_u64;
        for step in 0..4000 {
            number = number.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            let (what, row) = ((number >> 33) % 8, (number >> 40) as usize % list.len().max(1));
            // Alike at first, and again after the list has been empty.
            let value = if step % 1000 < 300 { 7 } else { what };
            match what {
                _ if list.is_empty() || what < 4 && list.len() < 40 => {
                    column.push(value);
                    list.push(value);
                }
                4 => {
                    column.put(row, value);
                    list[row] = value;
                }
                5 => {
                    column.swap(row, 0);
                    list.swap(row, 0);
                }
                6 => {
                    column[row] = value;
                    list[row] = value;
                }
                _ => assert_eq!(column.swap_remove(row), list.swap_remove(row)),
            }
            if step % 1000 == 999 {
                while let Some(last) = list.pop() {
                    assert_eq!(column.pop(), Some(last));
                }
                assert_eq!(column.pop(), None);
            }
            assert!(column.iter().eq(&list) && column.len() == list.len() && column.get(list.len()).is_none());
        }
    }

    #[test]
    fn rows_that_are_alike_take_one_place() {
        let mut column: Uniform<f64> = std::iter::repeat_n(0.015, 1000).collect();
        column.reserve_exact(500);
        column.put(3, 0.015);
        assert!(column.values.len() == 1 && column[999] == 0.015);
        column.put(3, 0.02);
        assert!(column.values.len() == 1000 && column.values.capacity() >= 1500 && column[3] == 0.02);
        let order: Vec<u32> = (0..1000).rev().collect();
        column.sort(&order);
        assert_eq!((column[996], column[3]), (0.02, 0.015));
    }
}
