//! Keys and rows: a slotmap from stable keys to the dense rows of a table, and back.
//!
//! Invariant: `keys[row]` is the key whose slot holds `row`, for every row below `len`; the slot of a buried key holds
//! [`NONE`]. Rows are dense: where one is taken away, the last takes its place.
//!
//! A removal that may be undone *buries* its key: nothing lives under it, but its slot is not given to another, so that
//! [`exhume`](Rows::exhume) can bring back that very key. [`release`](Rows::release) frees the slots of all buried keys.

use super::NONE;
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
        let key = self.bury(row)?;
        self.buried.pop();
        self.slots.remove(key);
        Some(key)
    }

    /// As [`swap_remove`](Self::swap_remove), but the key can be exhumed.
    pub fn bury(&mut self, row: u32) -> Option<K> {
        let key = self.key(row)?;
        self.keys.swap_remove(row as usize);
        if let Some(&moved) = self.keys.get(row as usize) {
            self.slots[moved] = row;
        }
        self.slots[key] = NONE;
        self.buried.push(key);
        Some(key)
    }

    /// Brings the key that was buried last back to `row`; what is there moves to the end. `None` where no key is buried, or
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
        self.keys.reserve(additional);
    }

    /// Whether keys and rows name each other, one to one, and every other slot is that of a buried key.
    pub fn is_consistent(&self) -> bool {
        self.slots.len() == self.keys.len() + self.buried.len()
            && self.buried.iter().all(|&key| self.slots.get(key) == Some(&NONE))
            && self.keys.iter().enumerate().all(|(row, &key)| self.row(key) == Some(row as u32))
    }
}
