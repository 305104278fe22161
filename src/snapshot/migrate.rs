//! Snapshots of earlier versions, brought to the present one step by step.
//!
//! A change of the saved format raises the version and adds a step here that turns a body of the version before into one of the next. A
//! step may go when a release has read its version for a year.

use super::bytes::VERSION;
use std::borrow::Cow;

/// The oldest version of snapshots that is read.
pub(super) const OLDEST: u16 = 14;

/// Conversions of a body from a version to the next one, from [`OLDEST`] on.
const STEPS: [fn(Vec<u8>) -> Vec<u8>; (VERSION - OLDEST) as usize] =
    [with_writer, as_it_is, as_it_is, as_it_is, as_it_is];

/// A body of this version as one of the present version.
pub(super) fn to_present(version: u16, body: &[u8]) -> Cow<'_, [u8]> {
    let steps = &STEPS[usize::from(version.clamp(OLDEST, VERSION) - OLDEST)..];
    if steps.is_empty() {
        return Cow::Borrowed(body);
    }
    Cow::Owned(steps.iter().fold(body.to_vec(), |body, step| step(body)))
}

/// 14 to 15: the version of the crate that wrote it follows, here not known: an empty string.
fn with_writer(mut body: Vec<u8>) -> Vec<u8> {
    body.push(0);
    body
}

/// 15 to 16: another layout of a factor's block; an old block is skipped on reading. 16 to 17: a tear's mode is followed by its rate; the largest
/// speed of older bytes is skipped on reading. 17 to 18: a pinch may have a target; older bytes are those of one without.
/// 18 to 19: friction may follow the last time step.
fn as_it_is(body: Vec<u8>) -> Vec<u8> {
    body
}
