//! Writing to the terminal without ever panicking on a reader that has left.

use super::Stop;
use std::io::{self, Write};

/// Writes a text and a line break to standard output.
pub(super) fn say(text: &str) -> Result<(), Stop> {
    let mut out = io::stdout().lock();
    let written = out.write_all(text.as_bytes()).and_then(|()| out.write_all(b"\n")).and_then(|()| out.flush());
    written.map_err(|error| match error.kind() {
        io::ErrorKind::BrokenPipe => Stop::ClosedPipe,
        _ => Stop::Failed(format!("cannot write to standard output: {error}")),
    })
}

/// Writes a line to standard error; if nobody reads it there is nothing left to do.
pub(super) fn complain(text: &str) {
    let _ = writeln!(io::stderr().lock(), "{text}");
}
