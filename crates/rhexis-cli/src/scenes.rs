//! `rhexis scenes`.

use super::{ScenesArgs, Stop, say::say};
use rhexis_scene::catalog::{self, CATALOG};

/// Prints the catalog, or one scene's file.
pub(super) fn scenes(args: &ScenesArgs) -> Result<(), Stop> {
    if let Some(name) = &args.show {
        return say(catalog::find(name)?.text.trim_end());
    }
    let width = CATALOG.iter().map(|entry| entry.name.len()).max().unwrap_or(0);
    for entry in CATALOG {
        say(&format!("{:width$}  {}", entry.name, entry.about()))?;
    }
    Ok(())
}
