//! Keys as bytes: the living ones in the order of their rows, the buried ones, and those that will be given next. A table that
//! is read back gives the keys that the first one would have given.

use super::super::NONE;
use super::Rows;
use serde::{Deserialize, Deserializer, Serialize, Serializer, de::Error};
use slotmap::{Key, KeyData, SlotMap};

/// A key: its slot, counted from 1, and its version, which is odd.
type Name = (u32, u32);

#[derive(Serialize, Deserialize)]
struct Names {
    living: Vec<Name>,
    buried: Vec<Name>,
    /// Keys of the free slots, the next one first.
    next: Vec<Name>,
}

/// A slot as the map reads it.
#[derive(Serialize)]
struct Slot {
    value: Option<u32>,
    version: u32,
}

fn name(key: impl Key) -> Name {
    let bits = key.data().as_ffi();
    (bits as u32, (bits >> 32) as u32)
}

fn key<K: Key>((slot, version): Name) -> K {
    KeyData::from_ffi(u64::from(version) << 32 | u64::from(slot)).into()
}

/// The keys that the map will give for the slots that are free.
fn next<K: Key>(slots: &SlotMap<K, u32>) -> Vec<Name> {
    let mut slots = slots.clone();
    std::iter::repeat_with(|| name(slots.insert(NONE))).take_while(|&(_, version)| version > 1).collect()
}

impl<K: Key> Serialize for Rows<K> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let names = |keys: &[K]| keys.iter().map(|&key| name(key)).collect();
        Names { living: names(&self.keys), buried: names(&self.buried), next: next(&self.slots) }.serialize(serializer)
    }
}

impl<'de, K: Key> Deserialize<'de> for Rows<K> {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let wrong = || D::Error::custom("keys that contradict each other");
        let Names { living, buried, next } = Names::deserialize(deserializer)?;
        let count = living.len() + buried.len() + next.len();
        // All slots are taken at first; the map's first is none.
        let mut slots: Vec<Slot> = (0..=count).map(|_| Slot { value: None, version: 0 }).collect();
        let living_rows = (0..).zip(&living).map(|(row, &name)| (name, row));
        let others = buried.iter().chain(&next).map(|&name| (name, NONE));
        for ((slot, version), row) in living_rows.chain(others) {
            let free = slots.get_mut(slot as usize).filter(|free| slot > 0 && free.value.is_none());
            let free = free.filter(|_| version % 2 == 1).ok_or_else(wrong)?;
            *free = Slot { value: Some(row), version };
        }
        for &(slot, version) in &next {
            // It was free with the version after that of the key before.
            slots[slot as usize].version = version.checked_sub(2).ok_or_else(wrong)?;
        }
        let bytes = postcard::to_allocvec(&slots).map_err(D::Error::custom)?;
        let mut slots: SlotMap<K, u32> = postcard::from_bytes(&bytes).map_err(D::Error::custom)?;
        for &(slot, version) in next.iter().rev() {
            slots.remove(key((slot, version - 2)));
        }
        let keys = |names: &[Name]| names.iter().map(|&name| key(name)).collect();
        let rows = Self { keys: keys(&living), buried: keys(&buried), slots };
        if rows.is_consistent() { Ok(rows) } else { Err(wrong()) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use slotmap::DefaultKey;

    #[test]
    fn rows_that_were_read_back_give_the_same_keys() {
        let mut rows = Rows::<DefaultKey>::default();
        (0..20).for_each(|_| _ = rows.push());
        for row in [3, 7, 1, 0, 9, 4] {
            rows.swap_remove(row);
        }
        (0..3).for_each(|_| _ = rows.push());
        rows.bury(2);
        rows.bury(5);
        let bytes = postcard::to_allocvec(&rows).unwrap();
        let mut read: Rows<DefaultKey> = postcard::from_bytes(&bytes).unwrap();
        assert_eq!(postcard::to_allocvec(&read).unwrap(), bytes);
        for rows in [&mut rows, &mut read] {
            rows.exhume(4);
            rows.release();
        }
        for _ in 0..10 {
            assert_eq!(rows.push(), read.push());
        }
        assert_eq!((rows.keys(), rows.buried()), (read.keys(), read.buried()));
    }

    #[test]
    fn keys_that_contradict_each_other_are_refused() {
        let read = |living: &[Name], next: &[Name]| {
            let names = Names { living: living.to_vec(), buried: Vec::new(), next: next.to_vec() };
            postcard::from_bytes::<Rows<DefaultKey>>(&postcard::to_allocvec(&names).unwrap()).is_ok()
        };
        assert!(read(&[(1, 1), (2, 3)], &[(3, 5)]));
        for (living, next) in [
            (&[(1, 1), (1, 3)][..], &[][..]),
            (&[(0, 1)], &[]),
            (&[(9, 1)], &[]),
            (&[(1, 2)], &[]),
            (&[(1, 1)], &[(2, 1)]),
            (&[(1, 1)], &[(2, 4)]),
        ] {
            assert!(!read(living, next), "{living:?} {next:?}");
        }
    }
}
