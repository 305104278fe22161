//! Failures of calls, and the exception that they become.

use pyo3::exceptions::PyException;
use pyo3::prelude::*;
use rhexis::ErrorKind;
use std::any::Any;
use std::fmt::Display;
use std::panic::{AssertUnwindSafe, catch_unwind};

pyo3::create_exception!(
    rhexis,
    Error,
    PyException,
    "What the engine or the binding refuses; `kind` says what sort of failure it is."
);

/// Sort of a failure.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Kind {
    /// An argument, mesh, component or setting out of its range.
    InvalidInput,
    /// A handle that is destroyed, of another world or of another kind.
    InvalidHandle,
    /// Another thread is in a call with the same object.
    Busy,
    /// TOML that cannot be read.
    Scene,
    /// A failure inside the library.
    Panic,
    /// A world that has failed in an earlier call.
    Poisoned,
    /// No such body, component, hold or vertex.
    NotFound,
    /// A tool without tissue in reach, or a cut that the mesh refused.
    NothingDone,
    /// No equilibrium or no linear answer.
    NotSolved,
    /// Bytes that are no snapshot or recording.
    Unreadable,
    /// A file that cannot be read or written.
    File,
    /// A replay with another end than its recording.
    Diverged,
    /// Threads that the system does not grant.
    Threads,
    /// A part that this build does not have.
    Unavailable,
}

impl Kind {
    /// All of them, with their names in Python.
    pub(crate) const ALL: [(Self, &'static str); 14] = [
        (Self::InvalidInput, "invalid_input"),
        (Self::InvalidHandle, "invalid_handle"),
        (Self::Busy, "busy"),
        (Self::Scene, "scene"),
        (Self::Panic, "panic"),
        (Self::Poisoned, "poisoned"),
        (Self::NotFound, "not_found"),
        (Self::NothingDone, "nothing_done"),
        (Self::NotSolved, "not_solved"),
        (Self::Unreadable, "unreadable"),
        (Self::File, "file"),
        (Self::Diverged, "diverged"),
        (Self::Threads, "threads"),
        (Self::Unavailable, "unavailable"),
    ];

    fn name(self) -> &'static str {
        Self::ALL.iter().find(|(kind, _)| *kind == self).map_or("", |(_, name)| name)
    }
}

/// Reason why a call did nothing.
#[derive(Debug)]
pub(crate) struct Failure {
    kind: Kind,
    message: String,
}

/// Result of a call.
pub(crate) type Answer<T> = Result<T, Failure>;

impl Failure {
    pub(crate) fn new(kind: Kind, message: impl Display) -> Self {
        Self { kind, message: message.to_string() }
    }

    pub(crate) fn input(message: impl Display) -> Self {
        Self::new(Kind::InvalidInput, message)
    }

    pub(crate) fn handle(message: impl Display) -> Self {
        Self::new(Kind::InvalidHandle, message)
    }
}

/// Refusal by the engine.
pub(crate) fn refused(error: impl Into<rhexis::Error>) -> Failure {
    let error = error.into();
    let kind = match error.kind() {
        ErrorKind::NotFound => Kind::NotFound,
        ErrorKind::NothingDone => Kind::NothingDone,
        ErrorKind::NotSolved => Kind::NotSolved,
        ErrorKind::Unreadable => Kind::Unreadable,
        ErrorKind::File => Kind::File,
        ErrorKind::Diverged => Kind::Diverged,
        ErrorKind::Threads => Kind::Threads,
        _ => Kind::InvalidInput,
    };
    Failure::new(kind, error)
}

/// Text that cannot be read.
pub(crate) fn unreadable(error: impl Display) -> Failure {
    Failure::new(Kind::Scene, error)
}

impl From<Failure> for PyErr {
    fn from(failure: Failure) -> Self {
        let error = Error::new_err(failure.message);
        // Without its kind the error is still one.
        Python::attach(|py| _ = error.value(py).setattr("kind", failure.kind.name()));
        error
    }
}

/// Runs the work of a call; a panic becomes a failure.
pub(crate) fn guarded<R, E: From<Failure>>(work: impl FnOnce() -> Result<R, E>) -> Result<R, E> {
    let inside = |payload| Failure::new(Kind::Panic, format!("the library has failed inside: {}", said(payload)));
    // A world that was locked when a panic passed is marked by its lock.
    catch_unwind(AssertUnwindSafe(work)).unwrap_or_else(|payload| Err(inside(payload).into()))
}

fn said(payload: Box<dyn Any + Send>) -> String {
    let text = payload.downcast_ref::<&str>().map(|text| (*text).to_owned());
    let text = text.or_else(|| payload.downcast_ref::<String>().cloned());
    // A payload of another kind might panic when it is dropped.
    std::mem::forget(payload);
    text.unwrap_or_else(|| "no reason given".to_owned())
}
