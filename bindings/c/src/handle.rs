//! Handles of 64 bits, and the objects behind them.
//!
//! An object has a kind (4 bits, never zero) and a serial number (60 bits) that no other object of the process has had before. An entity of
//! a world has its index (20 bits), its generation (22) and the tag of its world (22), so that stale and foreign ones are told.

use crate::status::{Answer, Failure, RhexisStatus};
use hecs::Entity;
use std::collections::BTreeMap;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError, RwLock, TryLockError};

/// Kinds of objects.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Kind {
    World = 1,
    Snapshot = 2,
    Recording = 3,
    Haptics = 4,
    Receiver = 5,
}

impl Kind {
    fn name(self) -> &'static str {
        match self {
            Self::World => "world",
            Self::Snapshot => "snapshot",
            Self::Recording => "recording",
            Self::Haptics => "haptics",
            Self::Receiver => "receiver",
        }
    }
}

const SERIAL_BITS: u32 = 60;
const INDEX_BITS: u32 = 20;
const GENERATION_BITS: u32 = 22;
const TAG_BITS: u32 = 22;

/// Of all kinds: no two objects have the same.
static NEXT: AtomicU64 = AtomicU64::new(1);

/// The objects of a kind that are alive.
pub(crate) struct Table<T> {
    kind: Kind,
    objects: RwLock<BTreeMap<u64, Arc<Mutex<T>>>>,
}

impl<T> Table<T> {
    pub(crate) const fn new(kind: Kind) -> Self {
        Self { kind, objects: RwLock::new(BTreeMap::new()) }
    }

    /// Keeps an object that is told its handle.
    pub(crate) fn add(&self, make: impl FnOnce(u64) -> T) -> Answer<u64> {
        let serial = NEXT.fetch_add(1, Ordering::Relaxed);
        if serial >> SERIAL_BITS != 0 {
            return Err(Failure::new(RhexisStatus::Capacity, "no more handles can be given out in this process"));
        }
        let handle = (self.kind as u64) << SERIAL_BITS | serial;
        let object = Arc::new(Mutex::new(make(handle)));
        self.objects.write().unwrap_or_else(PoisonError::into_inner).insert(handle, object);
        Ok(handle)
    }

    fn find(&self, handle: u64) -> Answer<Arc<Mutex<T>>> {
        let objects = self.objects.read().unwrap_or_else(PoisonError::into_inner);
        objects.get(&handle).cloned().ok_or_else(|| self.no_such(handle))
    }

    fn no_such(&self, handle: u64) -> Failure {
        let kind = self.kind.name();
        let message = if handle >> SERIAL_BITS == self.kind as u64 {
            format!("the {kind} {handle:#x} is destroyed, or was never made")
        } else {
            format!("{handle:#x} is no handle of a {kind}")
        };
        Failure::new(RhexisStatus::InvalidHandle, message)
    }

    fn busy(&self) -> Failure {
        let message = format!("another call with the same {} is running", self.kind.name());
        Failure::new(RhexisStatus::Busy, message)
    }

    fn lock<'a>(&self, object: &'a Mutex<T>) -> Answer<MutexGuard<'a, T>> {
        object.try_lock().map_err(|error| match error {
            TryLockError::WouldBlock => self.busy(),
            TryLockError::Poisoned(_) => {
                let message = format!("the {} has failed in an earlier call: destroy it", self.kind.name());
                Failure::new(RhexisStatus::Poisoned, message)
            }
        })
    }

    /// Works on an object that no other call works on.
    pub(crate) fn with<R>(&self, handle: u64, work: impl FnOnce(&mut T) -> Answer<R>) -> Answer<R> {
        let object = self.find(handle)?;
        let mut object = self.lock(&object)?;
        work(&mut object)
    }

    /// Destroys an object that no call works on, one that has failed too.
    pub(crate) fn remove(&self, handle: u64) -> Answer<()> {
        let object = self.find(handle)?;
        let held = match object.try_lock() {
            Ok(held) => held,
            Err(TryLockError::Poisoned(held)) => held.into_inner(),
            Err(TryLockError::WouldBlock) => return Err(self.busy()),
        };
        let removed = self.objects.write().unwrap_or_else(PoisonError::into_inner).remove(&handle);
        drop(held);
        // Another thread may have been faster.
        removed.map(|_| ()).ok_or_else(|| self.no_such(handle))
    }
}

/// The tag of a world, from its handle: another one of the next four million worlds has another.
pub(crate) fn tag(world: u64) -> u64 {
    world & ((1 << TAG_BITS) - 1)
}

/// The handle of an entity.
pub(crate) fn pack(tag: u64, entity: Entity) -> Answer<u64> {
    let bits = entity.to_bits().get();
    let (index, generation) = (bits & 0xffff_ffff, bits >> 32);
    if index >> INDEX_BITS != 0 || generation >> GENERATION_BITS != 0 {
        return Err(Failure::new(
            RhexisStatus::Capacity,
            "the world has had more bodies, obstacles and tools than handles can name",
        ));
    }
    Ok(tag << (INDEX_BITS + GENERATION_BITS) | generation << INDEX_BITS | index)
}

/// The entity of a handle.
pub(crate) fn unpack(tag: u64, handle: u64) -> Answer<Entity> {
    let wrong = |what: &str| Failure::new(RhexisStatus::InvalidHandle, format!("the entity {handle:#x} {what}"));
    if handle == 0 {
        return Err(wrong("is none"));
    }
    if handle >> (INDEX_BITS + GENERATION_BITS) != tag {
        return Err(wrong("belongs to another world"));
    }
    let generation = handle >> INDEX_BITS & ((1 << GENERATION_BITS) - 1);
    Entity::from_bits(generation << 32 | handle & ((1 << INDEX_BITS) - 1)).ok_or_else(|| wrong("was never made"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn handles_name_what_they_named_or_nothing() {
        let entity = |generation: u64, index: u64| Entity::from_bits(generation << 32 | index).unwrap();
        let (last, tag) = (entity((1 << 22) - 1, (1 << 20) - 1), (1 << 22) - 1);
        for (tag, entity) in [(tag, last), (0, entity(1, 0)), (5, entity(3, 77))] {
            assert_eq!(unpack(tag, pack(tag, entity).unwrap()).unwrap(), entity);
        }
        assert_eq!(pack(1, entity(1 << 22, 0)).unwrap_err().status, RhexisStatus::Capacity);
        assert_eq!(pack(1, entity(1, 1 << 20)).unwrap_err().status, RhexisStatus::Capacity);
        // A generation of zero was never made.
        assert_eq!(unpack(0, 17).unwrap_err().status, RhexisStatus::InvalidHandle);
        assert_eq!(unpack(4, pack(5, last).unwrap()).unwrap_err().status, RhexisStatus::InvalidHandle);
    }
}
