//! A component's kind is one fact: its folder, its section in the registry and the word in its doc agree.

mod sources;

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;

/// The kinds: folders of `src/components`, words of the registry's sections, and words of docs (`*State.*`).
const KINDS: [&str; 3] = ["state", "parameter", "derived"];

/// A type with its doc.
struct Type {
    name: String,
    /// Folder of `src/components`, for a type there.
    folder: Option<String>,
    /// Kind that the doc names.
    told: Option<String>,
    place: String,
}

/// The kind that a doc names: `*State.*`, or `*State*` before a condition.
fn told(doc: &str) -> Option<String> {
    let is_kind = |word: &&str| KINDS.iter().any(|kind| word.trim_end_matches('.').eq_ignore_ascii_case(kind));
    doc.split('*').skip(1).step_by(2).find(is_kind).map(|word| word.trim_end_matches('.').to_lowercase())
}

/// Name of the public type that a line declares: of an item of a file, or of a table's macro.
fn declared(line: &str) -> Option<&str> {
    let rest = line.strip_prefix("pub struct ").or_else(|| line.strip_prefix("pub enum "));
    let rest = rest.or_else(|| line.strip_prefix("    pub struct ").filter(|_| line.contains(", row ")));
    rest.map(|rest| rest.split(|c: char| !c.is_alphanumeric()).next().unwrap_or_default())
}

/// The public types of the engine.
fn types() -> Vec<Type> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let mut found = Vec::new();
    for file in ["src", "systems"].into_iter().flat_map(|folder| sources::files(folder, "rs")) {
        let place = file.strip_prefix(root).unwrap();
        let folder = place.strip_prefix("src/components").ok().and_then(|inner| inner.parent()?.to_str());
        let folder = folder.filter(|folder| KINDS.contains(folder)).map(str::to_owned);
        let mut doc = String::new();
        for (number, line) in (1..).zip(fs::read_to_string(&file).unwrap().lines()) {
            let text = line.trim_start();
            if let Some(words) = text.strip_prefix("///") {
                doc += words;
            } else if let Some(name) = declared(line) {
                let (name, told) = (name.to_owned(), told(&doc));
                found.push(Type { name, folder: folder.clone(), told, place: format!("{}:{number}", place.display()) });
                doc.clear();
            } else if !text.starts_with("#[") {
                doc.clear();
            }
        }
    }
    found
}

/// The components of the registry with their kinds.
fn registered() -> BTreeMap<String, String> {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("src/registry/mod.rs");
    let text = fs::read_to_string(file).unwrap();
    let list = text.split("macro_rules! components").nth(1).unwrap().split("\n}\n").next().unwrap();
    let (mut kind, mut found) = (String::new(), BTreeMap::new());
    for line in list.lines().map(str::trim) {
        if let Some(section) = line.strip_suffix(" {") {
            kind = section.split(',').next().unwrap().to_owned();
        } else if let Some((_, component)) = line.trim_end_matches(',').split_once(": ") {
            found.insert(component.to_owned(), kind.clone());
        }
    }
    found
}

#[test]
fn folder_registry_and_doc_name_one_kind() {
    let (types, registered) = (types(), registered());
    assert!(registered.len() > 45, "only {} components were found in src/registry/mod.rs", registered.len());
    let mut against = Vec::new();
    for (component, kind) in &registered {
        if !KINDS.contains(&kind.as_str()) {
            against
                .push(format!("src/registry/mod.rs: {component}: a section begins with its kind, not with `{kind}`"));
        }
        let found: Vec<&Type> = types.iter().filter(|found| found.name == *component).collect();
        if found.is_empty() {
            against.push(format!("{component} of src/registry/mod.rs is declared nowhere"));
        }
        // A private type elsewhere may have the name of one of `src/components`.
        let is_there = found.iter().any(|found| found.folder.is_some());
        for Type { folder, told, place, .. } in found.into_iter().filter(|found| found.folder.is_some() == is_there) {
            if folder.as_ref().is_some_and(|folder| folder != kind) {
                against.push(format!(
                    "{place}: {component} is {kind} in src/registry/mod.rs: move it to src/components/{kind}"
                ));
            }
            if told.as_ref() != Some(kind) {
                against.push(format!(
                    "{place}: {component} is {kind} in src/registry/mod.rs: say so in its doc, as *{kind}*"
                ));
            }
        }
    }
    for Type { name, folder, told, place } in &types {
        if let (Some(folder), Some(told)) = (folder, told)
            && folder != told
        {
            against.push(format!("{place}: {name} is {told} by its doc: move it to src/components/{told}"));
        }
    }
    assert!(against.is_empty(), "{}", against.join("\n"));
}
