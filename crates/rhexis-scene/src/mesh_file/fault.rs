//! What a reader finds wrong; the file's name is added by the caller.

use std::fmt::Display;

/// A fault in the text or bytes of a file.
#[derive(Debug)]
pub(super) struct Fault {
    /// Line, counted from 1.
    pub line: Option<usize>,
    /// What is wrong and how to mend it.
    pub what: String,
}

impl Fault {
    /// A fault that belongs to no line.
    pub(super) fn new(what: impl Display) -> Self {
        Self { line: None, what: what.to_string() }
    }

    /// A fault in `line`, counted from 1.
    pub(super) fn at(line: usize, what: impl Display) -> Self {
        Self { line: Some(line), what: what.to_string() }
    }
}

/// The line, counted from 1, in which byte `at` of `text` stands.
pub(super) fn line_of(text: &[u8], at: usize) -> usize {
    1 + text.iter().take(at).filter(|byte| **byte == b'\n').count()
}
