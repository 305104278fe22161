//! The scenes in the binary. Each is a commented file to copy and change.

use super::SceneError;
use super::error::nearest;

/// A scene of the catalog.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Entry {
    /// Its name.
    pub name: &'static str,
    /// Its file.
    pub text: &'static str,
}

macro_rules! entries {
    ($($name:literal),* $(,)?) => {
        &[$(Entry { name: $name, text: include_str!(concat!("catalog/", $name, ".toml")) }),*]
    };
}

/// All of them, the lead scene first.
pub const CATALOG: &[Entry] = entries![
    "capsulorhexis",
    "capsulorhexis-runout",
    "capsulorhexis-rescue",
    "fig2",
    "fig2-haptic",
    "fig2-iso",
    "fig2-tear",
    "fig2-tear-iso",
    "fig2-tear-stable",
    "two-points",
    "edge-crack",
    "hole",
    "cook",
    "cook-fibre",
    "artery-strip",
    "drum",
    "free-triangle",
    "many",
];

impl Entry {
    /// The `about` line of the scene.
    pub fn about(&self) -> String {
        super::Scene::named(self.name).map(|scene| scene.about().to_owned()).unwrap_or_default()
    }
}

/// The entry of that name.
///
/// # Errors
/// If there is none; the hint names the nearest.
pub fn find(name: &str) -> Result<Entry, SceneError> {
    CATALOG.iter().find(|entry| entry.name == name).copied().ok_or_else(|| {
        let names: Vec<&str> = CATALOG.iter().map(|entry| entry.name).collect();
        let list = format!("the catalog has {}; a scene file is named by its path", names.join(", "));
        let hint = nearest(name, names).map_or(list.clone(), |near| format!("did you mean `{near}`? {list}"));
        let what = "no such scene in the catalog, and no such file".to_owned();
        SceneError { origin: name.to_owned(), position: None, key: String::new(), what, hint }
    })
}
