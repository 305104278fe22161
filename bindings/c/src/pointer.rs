//! Pointers of C: the only file of this crate that looks behind one.
//!
//! C makes values of these types, by passing pointers; Rust makes them with `new`, which is unsafe. Both promise the same: a pointer that
//! is not null points to what its type says, for as long as the call lasts, and nothing else writes there meanwhile. What can be checked is
//! checked: null, alignment and size are refused.

use crate::status::{Answer, Failure, RhexisStatus};
use crate::types::*;
use std::ffi::{CStr, c_char};

/// A type whose every bit pattern is a value: what C has left there can be read.
///
/// # Safety
/// Made of numbers, pointers and such types only.
pub unsafe trait Plain: Copy {}

macro_rules! plain {
    ($($kind:ty),*) => {
        $(
            // SAFETY: made of numbers and pointers of this file only.
            unsafe impl Plain for $kind {}
        )*
    };
}
plain!(
    u8,
    u32,
    u64,
    f64,
    RhexisVec3,
    RhexisPose,
    RhexisJaws,
    RhexisGrasp,
    RhexisBodyDesc,
    RhexisSettings,
    RhexisHapticModel
);

fn sound<T>(pointer: *const T, what: &str) -> Answer<()> {
    if pointer.is_null() {
        return Err(Failure::argument(format!("{what} is a null pointer")));
    }
    if !pointer.is_aligned() {
        return Err(Failure::argument(format!("{what} is not aligned to {} bytes", align_of::<T>())));
    }
    Ok(())
}

/// Text that ends with a zero.
#[derive(Clone, Copy, Debug)]
#[repr(transparent)]
pub struct Text(*const c_char);

impl Text {
    /// No text.
    pub const NULL: Self = Self(std::ptr::null());

    /// Text at a pointer.
    ///
    /// # Safety
    /// Null, or a zero follows within the same allocation, and nothing writes before it while the value is in use.
    pub unsafe fn new(pointer: *const c_char) -> Self {
        Self(pointer)
    }

    /// Whether there is none.
    pub fn is_null(&self) -> bool {
        self.0.is_null()
    }

    pub(crate) fn read(&self, what: &str) -> Answer<&str> {
        sound(self.0, what)?;
        // SAFETY: not null, and by `new` a zero follows that nothing overwrites while `self` lives.
        let text = unsafe { CStr::from_ptr(self.0) };
        text.to_str().map_err(|error| Failure::argument(format!("{what} is not UTF-8: {error}")))
    }
}

/// Many values in a row; their count is passed beside.
#[derive(Clone, Copy, Debug)]
#[repr(transparent)]
pub struct Array<T>(*const T);

impl<T> Array<T> {
    /// No values.
    pub const NULL: Self = Self(std::ptr::null());

    /// Values at a pointer.
    ///
    /// # Safety
    /// Null, or as many values follow as the count says that is passed beside, and nothing writes there while the value is in use.
    pub unsafe fn new(pointer: *const T) -> Self {
        Self(pointer)
    }

    /// Whether there are none.
    pub fn is_null(&self) -> bool {
        self.0.is_null()
    }
}

impl<T: Plain> Array<T> {
    pub(crate) fn read(&self, count: usize, what: &str) -> Answer<&[T]> {
        if count == 0 {
            return Ok(&[]);
        }
        sound(self.0, what)?;
        if count > isize::MAX as usize / size_of::<T>() {
            return Err(Failure::argument(format!("{what}: {count} values are more than memory holds")));
        }
        // SAFETY: not null, aligned, not too long; by `new` that many values are there, every bit pattern is one, and nothing writes to
        // them while `self` lives.
        Ok(unsafe { std::slice::from_raw_parts(self.0, count) })
    }
}

/// A description.
#[derive(Clone, Copy, Debug)]
#[repr(transparent)]
pub struct In<T>(*const T);

impl<T> In<T> {
    /// No description.
    pub const NULL: Self = Self(std::ptr::null());

    /// A description at a pointer.
    ///
    /// # Safety
    /// Null, or a value is there that nothing writes to while this one is in use.
    pub unsafe fn new(pointer: *const T) -> Self {
        Self(pointer)
    }
}

impl<T: Plain> In<T> {
    pub(crate) fn read(&self, what: &str) -> Answer<T> {
        sound(self.0, what)?;
        // SAFETY: not null, aligned; by `new` a value is there, and every bit pattern is one.
        Ok(unsafe { self.0.read() })
    }

    /// `None` for null.
    pub(crate) fn read_if_any(&self, what: &str) -> Answer<Option<T>> {
        if self.0.is_null() { Ok(None) } else { self.read(what).map(Some) }
    }
}

/// Where an answer goes.
#[derive(Clone, Copy, Debug)]
#[repr(transparent)]
pub struct Out<T>(*mut T);

impl<T> Out<T> {
    /// Nowhere.
    pub const NULL: Self = Self(std::ptr::null_mut());

    /// To a pointer.
    ///
    /// # Safety
    /// Null, or a value may be written there, and nothing else reads or writes it while this one is in use.
    pub unsafe fn new(pointer: *mut T) -> Self {
        Self(pointer)
    }

    /// Refuses what cannot be written to: before anything is done.
    pub(crate) fn check(&self, what: &str) -> Answer<()> {
        sound(self.0, what)
    }

    /// As [`check`](Self::check), where null says that the answer is not wanted.
    pub(crate) fn check_if_any(&self, what: &str) -> Answer<()> {
        if self.0.is_null() { Ok(()) } else { self.check(what) }
    }

    /// Writes, unless it leads nowhere or astray.
    pub(crate) fn write(&self, value: T)
    where
        T: Copy,
    {
        if sound(self.0, "").is_ok() {
            // SAFETY: not null, aligned; by `new` it may be written to.
            unsafe { self.0.write(value) }
        }
    }
}

/// Memory of the caller's for many values; its capacity is passed beside.
#[derive(Clone, Copy, Debug)]
#[repr(transparent)]
pub struct Buffer<T>(*mut T);

impl<T> Buffer<T> {
    /// No memory.
    pub const NULL: Self = Self(std::ptr::null_mut());

    /// Memory at a pointer.
    ///
    /// # Safety
    /// Null, or as many values may be written as the capacity says that is passed beside, and nothing else reads or writes them while
    /// this one is in use.
    pub unsafe fn new(pointer: *mut T) -> Self {
        Self(pointer)
    }
}

impl<T: Copy> Buffer<T> {
    /// Writes values and their count. With too small a capacity only the count that is needed.
    pub(crate) fn fill(&self, capacity: usize, values: &[T], count: Out<usize>) -> Answer<()> {
        count.check("the count")?;
        if values.len() > capacity {
            count.write(values.len());
            let message = format!("{} elements are to be written, the buffer has room for {capacity}", values.len());
            return Err(Failure::new(RhexisStatus::BufferTooSmall, message));
        }
        if !values.is_empty() {
            sound(self.0, "the buffer")?;
            // SAFETY: not null, aligned; by `new` it has room for `capacity` values, which are no fewer, and they are none of Rust's own.
            unsafe { std::ptr::copy_nonoverlapping(values.as_ptr(), self.0, values.len()) }
        }
        count.write(values.len());
        Ok(())
    }
}
