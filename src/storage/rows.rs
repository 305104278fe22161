//! Keys and rows: a slotmap from stable keys to the dense rows of a table, and back.
//!
//! Invariant: `keys[row]` is the key whose slot holds `row`, for every row below `len`.

use slotmap::{Key, SlotMap};

/// The key side of a table. Rows are dense and in order of creation; the newest row alone can be taken away again.
#[derive(Clone, Debug)]
pub struct Rows<K: Key> {
    slots: SlotMap<K, u32>,
    keys: Vec<K>,
}

impl<K: Key> Default for Rows<K> {
    fn default() -> Self {
        Self { slots: SlotMap::with_key(), keys: Vec::new() }
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
        let last = self.keys.len().checked_sub(1)? as u32;
        if row > last {
            return None;
        }
        let key = self.keys.swap_remove(row as usize);
        self.slots.remove(key);
        if row != last {
            self.slots[self.keys[row as usize]] = row;
        }
        Some(key)
    }

    /// The row where a living key is now.
    pub fn row(&self, key: K) -> Option<u32> {
        self.slots.get(key).copied()
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

    /// Whether keys and rows name each other, one to one.
    pub fn is_consistent(&self) -> bool {
        self.slots.len() == self.keys.len()
            && self.keys.iter().enumerate().all(|(row, &key)| self.row(key) == Some(row as u32))
    }
}
