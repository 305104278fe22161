//! Writing to the terminal without ever panicking on a reader that has left.

use super::Stop;
use std::borrow::Cow;
use std::fmt::Write as _;
use std::io::{self, Write};

/// Whether a terminal shows a character of a text and does nothing else.
fn is_plain(c: char) -> bool {
    // Marks of direction let a text read otherwise than it is written.
    matches!(c, '\n' | '\t') || !c.is_control() && !matches!(c, '\u{202a}'..='\u{202e}' | '\u{2066}'..='\u{2069}')
}

/// Whether a terminal shows a text and does nothing else.
pub(super) fn is_printable(text: &str) -> bool {
    text.chars().all(is_plain)
}

/// Text for a terminal, with control characters escaped as in JSON, `\u001b`.
fn printable(text: &str) -> Cow<'_, str> {
    if is_printable(text) {
        return Cow::Borrowed(text);
    }
    let mut shown = String::with_capacity(text.len());
    for c in text.chars() {
        if is_plain(c) {
            shown.push(c);
        } else {
            // Writing to a String cannot fail.
            let _ = write!(shown, "\\u{:04x}", u32::from(c));
        }
    }
    Cow::Owned(shown)
}

/// Writes a text and a line break to standard output.
pub(super) fn say(text: &str) -> Result<(), Stop> {
    let mut out = io::stdout().lock();
    let written =
        out.write_all(printable(text).as_bytes()).and_then(|()| out.write_all(b"\n")).and_then(|()| out.flush());
    written.map_err(|error| match error.kind() {
        io::ErrorKind::BrokenPipe => Stop::ClosedPipe,
        _ => Stop::Failed(format!("cannot write to standard output: {error}")),
    })
}

/// Writes a line to standard error; if nobody reads it there is nothing left to do.
pub(super) fn complain(text: &str) {
    let _ = writeln!(io::stderr().lock(), "{}", printable(text));
}
