//! Components and settings as text.

use crate::status::{Answer, unreadable};
use rhexis_scene::patch;
use serde::{Serialize, de::DeserializeOwned};

/// A value as text.
pub(crate) fn text(what: &str, value: &impl Serialize) -> Answer<String> {
    toml::to_string(value).map_err(|error| unreadable(format!("{what}: {error}")))
}

/// A value with what a text changes of it; a key that it does not have is refused.
pub(crate) fn patched<T: Serialize + DeserializeOwned>(what: &str, base: Option<&T>, text: &str) -> Answer<T> {
    let table = toml::from_str(text).map_err(|error| unreadable(format!("{what}: {error}")))?;
    patch::patched(what, base, table).map_err(unreadable)
}
