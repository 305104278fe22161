//! Keys and rows: a slotmap from stable keys to the dense rows of a table, and back.
//!
//! Invariant: `keys[row]` is the key whose slot holds `row`, for every row below `len`; the slot of a buried key holds
//! [`NONE`]. Rows are dense: where one is taken away, the last takes its place.
//!
//! A removal that may be undone *buries* its key: nothing lives under it, but its slot is not given to another, so that
//! [`exhume`](Rows::exhume) can bring back that very key. [`release`](Rows::release) frees the slots of all buried keys.

#[cfg(feature = "snapshot")]
mod serial;

use super::NONE;
use super::order::sort;
use slotmap::{Key, SlotMap};

/// The key side of a table.
#[derive(Clone, Debug)]
pub struct Rows<K: Key> {
    slots: SlotMap<K, u32>,
    keys: Vec<K>,
    buried: Vec<K>,
}

impl<K: Key> Default for Rows<K> {
    fn default() -> Self {
        Self { slots: SlotMap::with_key(), keys: Vec::new(), buried: Vec::new() }
    }
}

impl<K: Key> Rows<K> {
    /// Adds a row at the end and gives its key.
    pub fn push(&mut self) -> K {
        let key = self.slots.insert(self.keys.len() as u32);
        self.keys.push(key);
        key
    }

    /// Takes the last row away; its key is dead from then on.
    pub fn pop(&mut self) -> Option<K> {
        let key = self.keys.pop()?;
        self.slots.remove(key);
        Some(key)
    }

    /// Takes `row` away and moves the last row into its place. `None` where there is no such row.
    pub fn swap_remove(&mut self, row: u32) -> Option<K> {
        let key = self.take_out(row)?;
        self.slots.remove(key);
        Some(key)
    }

    /// As [`swap_remove`](Self::swap_remove), but the key can be exhumed.
    pub fn bury(&mut self, row: u32) -> Option<K> {
        let key = self.take_out(row)?;
        self.slots[key] = NONE;
        self.buried.push(key);
        Some(key)
    }

    /// Moves the last row into the place of `row`, whose key then names none.
    fn take_out(&mut self, row: u32) -> Option<K> {
        let key = self.key(row)?;
        self.keys.swap_remove(row as usize);
        if let Some(&moved) = self.keys.get(row as usize) {
            self.slots[moved] = row;
        }
        Some(key)
    }

    /// Brings the key that was buried last back to `row`; the key there moves to the end. `None` where no key is buried, or
    /// `row` is beyond the end.
    pub fn exhume(&mut self, row: u32) -> Option<K> {
        let last = self.keys.len();
        if row as usize > last {
            return None;
        }
        let key = self.buried.pop()?;
        self.keys.push(key);
        self.keys.swap(row as usize, last);
        self.slots[self.keys[last]] = last as u32;
        self.slots[key] = row;
        Some(key)
    }

    /// Brings the rows into another order; `order` has the old row of every new one. Rows that are buried keep none.
    ///
    /// # Panics
    /// If `order` does not have every row once.
    pub fn permute(&mut self, order: &[u32]) {
        assert_eq!(order.len(), self.keys.len(), "an order of all rows");
        sort(order, &mut self.keys);
        for (row, &key) in (0..).zip(&self.keys) {
            self.slots[key] = row;
        }
        debug_assert!(self.is_consistent(), "every row once");
    }

    /// Frees the slots of the buried keys, which are dead for good then.
    pub fn release(&mut self) {
        for key in self.buried.drain(..) {
            self.slots.remove(key);
        }
    }

    /// The buried keys, the last one last.
    pub fn buried(&self) -> &[K] {
        &self.buried
    }

    /// The row where a living key is now.
    pub fn row(&self, key: K) -> Option<u32> {
        self.slots.get(key).copied().filter(|&row| row != NONE)
    }

    /// The key of a row.
    pub fn key(&self, row: u32) -> Option<K> {
        self.keys.get(row as usize).copied()
    }

    /// All keys, in the order of their rows.
    pub fn keys(&self) -> &[K] {
        &self.keys
    }

    /// Number of rows.
    pub fn len(&self) -> usize {
        self.keys.len()
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.keys.is_empty()
    }

    /// Makes room for `additional` rows, so that the pushes of a step do not allocate.
    pub fn reserve(&mut self, additional: usize) {
        self.slots.reserve(additional);
        self.keys.reserve_exact(additional);
    }

    /// Whether keys and rows name each other, one to one, and every other slot is that of a buried key.
    pub fn is_consistent(&self) -> bool {
        self.slots.len() == self.keys.len() + self.buried.len()
            && self.buried.iter().all(|&key| self.slots.get(key) == Some(&NONE))
            && self.keys.iter().enumerate().all(|(row, &key)| self.row(key) == Some(row as u32))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;
    use slotmap::DefaultKey;
    use std::collections::HashSet;

    #[derive(Clone, Copy, Debug)]
    enum Change {
        Push,
        Pop,
        SwapRemove(usize),
        Bury(usize),
        Exhume(usize),
        Release,
        Permute(u32),
    }

    fn change() -> impl Strategy<Value = Change> {
        prop_oneof![
            4 => Just(Change::Push),
            1 => Just(Change::Pop),
            1 => (0..30_usize).prop_map(Change::SwapRemove),
            3 => (0..30_usize).prop_map(Change::Bury),
            3 => (0..30_usize).prop_map(Change::Exhume),
            1 => Just(Change::Release),
            1 => any::<u32>().prop_map(Change::Permute),
        ]
    }

    proptest! {
        /// Against a plain list of keys: who lives where, who is buried, and that no key is ever given out twice.
        #[test]
        fn rows_equal_a_plain_list(changes in prop::collection::vec(change(), 0..200)) {
            let mut rows = Rows::<DefaultKey>::default();
            let (mut living, mut buried, mut dead) = (Vec::new(), Vec::new(), HashSet::new());
            for change in changes {
                match change {
                    Change::Push => {
                        let key = rows.push();
                        prop_assert!(!living.contains(&key) && !buried.contains(&key) && !dead.contains(&key));
                        living.push(key);
                    }
                    Change::Pop => {
                        let gone = living.pop();
                        prop_assert_eq!(rows.pop(), gone);
                        dead.extend(gone);
                    }
                    Change::SwapRemove(row) => {
                        let gone = (row < living.len()).then(|| living.swap_remove(row));
                        prop_assert_eq!(rows.swap_remove(row as u32), gone);
                        dead.extend(gone);
                    }
                    Change::Bury(row) => {
                        let gone = (row < living.len()).then(|| living.swap_remove(row));
                        prop_assert_eq!(rows.bury(row as u32), gone);
                        buried.extend(gone);
                    }
                    Change::Exhume(row) => {
                        let back = if row <= living.len() { buried.pop() } else { None };
                        prop_assert_eq!(rows.exhume(row as u32), back);
                        if let Some(key) = back {
                            living.push(key);
                            let last = living.len() - 1;
                            living.swap(row, last);
                        }
                    }
                    Change::Permute(turn) => {
                        let count = living.len() as u32;
                        let order: Vec<u32> = (0..count).map(|row| (row + turn % count) % count).rev().collect();
                        rows.permute(&order);
                        living = order.into_iter().map(|old| living[old as usize]).collect();
                    }
                    Change::Release => {
                        rows.release();
                        dead.extend(buried.drain(..));
                    }
                }
                prop_assert!(rows.is_consistent());
                prop_assert_eq!(rows.keys(), &living[..]);
                prop_assert_eq!(rows.buried(), &buried[..]);
                prop_assert!((0..).zip(&living).all(|(row, &key)| rows.row(key) == Some(row)));
                prop_assert!(buried.iter().chain(&dead).all(|&key| rows.row(key).is_none()));
            }
        }
    }

    #[test]
    fn released_slots_are_used_again() {
        let mut rows = Rows::<DefaultKey>::default();
        rows.push();
        for _ in 0..100_000 {
            rows.push();
            rows.bury(0);
            rows.release();
        }
        assert!(rows.slots.capacity() < 10 && rows.buried.capacity() < 10, "memory must not grow with the edits");
    }
}
