//! `rhexis check`.

use super::{SceneArgs, Stop, document, say::say};

/// Prints what the scene holds, or why it is refused.
pub(super) fn check(args: &SceneArgs) -> Result<(), Stop> {
    let summary = document(args)?.scene()?.check()?;
    say(&format!("{summary}\nok"))
}
