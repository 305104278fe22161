//! What a call answers: a status, and on failure a message that its thread keeps.

use std::any::Any;
use std::cell::RefCell;
use std::ffi::{CString, c_char};
use std::fmt::Display;
use std::panic::{AssertUnwindSafe, catch_unwind};

/// The answer of a call. On any but `RHEXIS_STATUS_OK` nothing has been written, unless the status says so, and
/// `rhexis_last_error_message` says why.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(i32)]
pub enum RhexisStatus {
    /// Done.
    Ok = 0,
    /// A null or misaligned pointer, text that is not UTF-8, a number out of its range.
    InvalidArgument = 1,
    /// A handle that was never given out, is destroyed, or belongs to another world or another kind of object.
    InvalidHandle = 2,
    /// Another thread is in a call with the same object; nothing was done. Call again later.
    Busy = 3,
    /// The buffer is too small; the number of elements needed has been written, and nothing else.
    BufferTooSmall = 4,
    /// The engine refused it; everything is as it was.
    Refused = 5,
    /// A scene, a component or settings in TOML that cannot be read; the message has line, reason and remedy.
    Scene = 6,
    /// Header and library are of different versions, or the library lacks a feature.
    AbiMismatch = 7,
    /// The library has failed inside; the world of the call is marked, and refuses further calls.
    Panic = 8,
    /// The world has failed in an earlier call. Destroy it; a snapshot from before can go on in a new one.
    Poisoned = 9,
    /// No more handles of this kind can be given out.
    Capacity = 10,
    /// There is no such thing: no tissue within reach, no body or component of this name, no model yet.
    NotFound = 11,
}

impl RhexisStatus {
    /// All of them, by number.
    pub const ALL: [(Self, &'static std::ffi::CStr); 12] = [
        (Self::Ok, c"OK"),
        (Self::InvalidArgument, c"INVALID_ARGUMENT"),
        (Self::InvalidHandle, c"INVALID_HANDLE"),
        (Self::Busy, c"BUSY"),
        (Self::BufferTooSmall, c"BUFFER_TOO_SMALL"),
        (Self::Refused, c"REFUSED"),
        (Self::Scene, c"SCENE"),
        (Self::AbiMismatch, c"ABI_MISMATCH"),
        (Self::Panic, c"PANIC"),
        (Self::Poisoned, c"POISONED"),
        (Self::Capacity, c"CAPACITY"),
        (Self::NotFound, c"NOT_FOUND"),
    ];
}

/// Why a call did nothing.
#[derive(Debug)]
pub(crate) struct Failure {
    pub(crate) status: RhexisStatus,
    pub(crate) message: String,
}

/// What calls compute.
pub(crate) type Answer<T> = Result<T, Failure>;

impl Failure {
    pub(crate) fn new(status: RhexisStatus, message: impl Display) -> Self {
        Self { status, message: message.to_string() }
    }

    pub(crate) fn argument(message: impl Display) -> Self {
        Self::new(RhexisStatus::InvalidArgument, message)
    }
}

/// The engine's refusal.
pub(crate) fn refused(error: impl Display) -> Failure {
    Failure::new(RhexisStatus::Refused, error)
}

/// A text that cannot be read.
pub(crate) fn unreadable(error: impl Display) -> Failure {
    Failure::new(RhexisStatus::Scene, error)
}

thread_local! {
    static LAST: RefCell<CString> = RefCell::new(CString::default());
}

/// Text for C: without zeros inside.
pub(crate) fn c_text(text: &str) -> CString {
    CString::new(text.replace('\0', "\u{fffd}")).unwrap_or_default()
}

/// Runs the body of a call. No panic leaves it.
pub(crate) fn call(body: impl FnOnce() -> Answer<()>) -> RhexisStatus {
    // A world that was locked when a panic passed is marked by its lock; tables of handles are whole between two of their lines.
    let failure = match catch_unwind(AssertUnwindSafe(body)) {
        Ok(Ok(())) => return RhexisStatus::Ok,
        Ok(Err(failure)) => failure,
        Err(payload) => Failure::new(RhexisStatus::Panic, format!("the library has failed inside: {}", said(payload))),
    };
    // A thread that is ending has no message any more.
    let _ = LAST.try_with(|last| last.replace(c_text(&failure.message)));
    failure.status
}

fn said(payload: Box<dyn Any + Send>) -> String {
    let text = payload.downcast_ref::<&str>().map(|text| (*text).to_owned());
    let text = text.or_else(|| payload.downcast_ref::<String>().cloned());
    // A payload of another kind might panic when it is dropped.
    std::mem::forget(payload);
    text.unwrap_or_else(|| "no reason given".to_owned())
}

/// Why the last call of this thread failed that did: UTF-8, valid until the next one fails or the thread ends; empty before the first.
#[unsafe(no_mangle)]
pub extern "C" fn rhexis_last_error_message() -> *const c_char {
    LAST.try_with(|last| last.borrow().as_ptr()).unwrap_or(c"".as_ptr())
}

/// The name of a status, such as "BUSY"; "UNKNOWN" for a number that is none. Valid for ever.
#[unsafe(no_mangle)]
pub extern "C" fn rhexis_status_name(status: i32) -> *const c_char {
    let found = RhexisStatus::ALL.iter().find(|(known, _)| *known as i32 == status);
    found.map_or(c"UNKNOWN".as_ptr(), |(_, name)| name.as_ptr())
}
