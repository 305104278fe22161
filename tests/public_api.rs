//! The public interface of the engine is what `public_api.txt` says, so that a change of it is seen where the change is read.
//!
//! One line for each item: its path, and its declaration as it stands in the source. Hidden items are none of it.

use serde_json::Value;
use std::collections::{BTreeSet, HashMap, HashSet};
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

/// With this in the environment, the file is written anew.
const UPDATE: &str = "RHEXIS_UPDATE_API";

const HOW: &str = "If the change is meant, write the file anew and say in the changelog what users have to do:
    RHEXIS_UPDATE_API=1 cargo test --release -p rhexis --test public_api -- --ignored";

/// Maximum lines of `public_api.txt` that are not of the prelude, which names items a second time:
/// `grep -vc '^rhexis::prelude' tests/public_api.txt`.
const MAX_ITEMS: usize = 1500;

/// Folders and files whose words count as a use of the interface.
const USERS: [&str; 7] = ["crates", "bindings", "examples", "benches", "tests", "docs", "README.md"];

/// What the documentation's tool knows of the crate, with the default features.
struct Crate {
    items: Value,
    /// Lines of the source files that have been read.
    sources: HashMap<String, Vec<String>>,
    lines: BTreeSet<String>,
}

impl Crate {
    fn new() -> Self {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR"));
        let target = folder.join("target/api");
        let mut command = Command::new(env!("CARGO"));
        command.current_dir(folder).args(["rustdoc", "--package", "rhexis", "--lib", "--target-dir"]).arg(&target);
        // The form of the output is not stable; the tool that belongs to the compiler of the day writes it.
        command.args(["--", "-Z", "unstable-options", "--output-format", "json", "--cap-lints", "allow"]);
        let output = command.env("RUSTC_BOOTSTRAP", "1").output().unwrap();
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        let text = fs::read_to_string(target.join("doc/rhexis.json")).unwrap();
        Self { items: serde_json::from_str(&text).unwrap(), sources: HashMap::new(), lines: BTreeSet::new() }
    }

    fn item(&self, id: &Value) -> Value {
        self.items["index"][id.to_string()].clone()
    }

    /// The declaration of an item, as it stands in the source, in one line.
    fn declaration(&mut self, item: &Value) -> String {
        let span = &item["span"];
        let Some(file) = span["filename"].as_str() else { return String::new() };
        let lines = self.sources.entry(file.to_owned()).or_insert_with(|| {
            let text = fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join(file)).unwrap_or_default();
            text.lines().map(str::to_owned).collect()
        });
        let place = |end: &str, i: usize| span[end][i].as_u64().unwrap() as usize;
        let (first, last) = (place("begin", 0), place("end", 0).min(lines.len()));
        let mut text = lines.get(first - 1..last).unwrap_or_default().join(" ");
        let column = text.char_indices().nth(place("begin", 1) - 1).map_or(0, |(at, _)| at);
        text.drain(..column);
        if first == place("end", 0) {
            text = text.chars().take(place("end", 1) + 1 - place("begin", 1)).collect();
        }
        // What a macro makes has the macro's place.
        if let Some((made_by, _)) = text.split_once('!').filter(|(name, _)| name.chars().all(is_of_name)) {
            return format!("{made_by}!");
        }
        let until = match item["inner"].as_object().and_then(|inner| inner.keys().next()).map(String::as_str) {
            Some("struct_field") => text.len(),
            Some("constant" | "static" | "assoc_const") => text.find(" =").unwrap_or(text.len()),
            _ => body(&text),
        };
        text[..until].trim_end_matches(',').split_whitespace().collect::<Vec<_>>().join(" ")
    }

    /// Notes an item and what belongs to it.
    fn visit(&mut self, id: &Value, path: &str, above: &mut Vec<String>) {
        let item = self.item(id);
        // What is not of this crate has no entry.
        let Some((kind, inner)) = item["inner"].as_object().and_then(|inner| inner.iter().next()) else { return };
        if above.contains(&id.to_string()) {
            return;
        }
        let name = item["name"].as_str().unwrap_or_default();
        let path = if path.is_empty() { name.to_owned() } else { format!("{path}::{name}") };
        above.push(id.to_string());
        match kind.as_str() {
            "module" => self.members(inner, &path, above),
            "use" => self.reexport(inner, &path, above),
            "impl" => self.list(&inner["items"], path.trim_end_matches("::"), above),
            _ => {
                let traits = self.traits(&inner["impls"]);
                let declaration = self.declaration(&item);
                self.lines.insert(format!("{path}: {declaration}{traits}"));
                self.belongings(inner, &path, above);
            }
        }
        above.pop();
    }

    fn members(&mut self, module: &Value, path: &str, above: &mut Vec<String>) {
        self.list(&module["items"], path, above);
    }

    fn list(&mut self, ids: &Value, path: &str, above: &mut Vec<String>) {
        ids.as_array().into_iter().flatten().for_each(|id| self.visit(id, path, above));
    }

    fn reexport(&mut self, inner: &Value, path: &str, above: &mut Vec<String>) {
        let parent = path.trim_end_matches("::");
        let target = self.item(&inner["id"]);
        if target.is_null() {
            self.lines.insert(format!("{parent}: pub use {}", inner["source"].as_str().unwrap()));
        } else if inner["is_glob"] == true {
            self.members(&target["inner"]["module"], parent, above);
        } else if target["name"] == inner["name"] {
            self.visit(&inner["id"], parent, above);
        } else {
            let name = inner["name"].as_str().unwrap();
            self.lines.insert(format!("{parent}::{name}: pub use {}", inner["source"].as_str().unwrap()));
        }
    }

    /// The traits of the source (those that hold for every type are left out).
    fn traits(&self, impls: &Value) -> String {
        let of_source = |id: &Value| {
            let item = self.item(id);
            let name = item["inner"]["impl"]["trait"]["path"].as_str()?.rsplit("::").next()?.to_owned();
            let is_written = !item["span"].is_null() && item["inner"]["impl"]["blanket_impl"].is_null();
            (is_written && name != "StructuralPartialEq").then_some(name)
        };
        let names: BTreeSet<String> = impls.as_array().into_iter().flatten().filter_map(of_source).collect();
        let names: Vec<String> = names.into_iter().collect();
        if names.is_empty() { String::new() } else { format!(" [{}]", names.join(", ")) }
    }

    /// Fields, variants, methods, and the items of traits.
    fn belongings(&mut self, inner: &Value, path: &str, above: &mut Vec<String>) {
        self.list(&inner["kind"]["plain"]["fields"], path, above);
        self.list(&inner["kind"]["struct"]["fields"], path, above);
        self.list(&inner["variants"], path, above);
        self.list(&inner["items"], path, above);
        for id in inner["impls"].as_array().into_iter().flatten() {
            // Methods of the type's own; those of traits are told by the trait's name.
            if self.item(id)["inner"]["impl"]["trait"].is_null() {
                self.visit(id, path, above);
            }
        }
    }
}

fn is_of_name(character: char) -> bool {
    character == '_' || character.is_alphanumeric()
}

/// Where the body of a declaration begins.
fn body(declaration: &str) -> usize {
    let mut depth = 0;
    for (at, character) in declaration.char_indices() {
        match character {
            '(' | '[' => depth += 1,
            ')' | ']' => depth -= 1,
            '{' | ';' if depth == 0 => return at,
            _ => {}
        }
    }
    declaration.len()
}

#[test]
#[ignore = "builds documentation, a minute of compile time: cargo test -p rhexis --test public_api -- --ignored"]
fn the_public_interface_is_as_written() {
    let mut krate = Crate::new();
    let root = krate.items["root"].clone();
    krate.visit(&root, "", &mut Vec::new());
    let now: Vec<String> = krate.lines.into_iter().collect();
    assert!(now.len() > 500, "{}", now.len());
    let path = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("tests/public_api.txt");
    if std::env::var_os(UPDATE).is_some() {
        fs::write(&path, now.join("\n") + "\n").unwrap();
        return;
    }
    let written = fs::read_to_string(&path).unwrap();
    let written: BTreeSet<&str> = written.lines().collect();
    let now: BTreeSet<&str> = now.iter().map(String::as_str).collect();
    let gone = written.difference(&now).map(|line| format!("- {line}\n"));
    let come = now.difference(&written).map(|line| format!("+ {line}\n"));
    let changes: String = gone.chain(come).collect();
    assert!(changes.is_empty(), "the public interface is not that of tests/public_api.txt:\n{changes}{HOW}");
}

#[test]
fn the_public_interface_is_small() {
    let count = public_items().len();
    assert!(count <= MAX_ITEMS, "{count} public items: hide, or make private, those that no user needs");
}

/// Functions, types, constants and fields; variants of enums and their fields come with their enum.
#[test]
fn public_items_are_used_or_shown() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR"));
    let mut words = HashSet::new();
    USERS.iter().for_each(|user| add_words(&folder.join(user), &mut words));
    ["src", "systems"].iter().for_each(|part| add_examples(&folder.join(part), &mut words));
    let items = public_items();
    let is_own = |declaration: &str| declaration.starts_with("pub ") || declaration.ends_with('!');
    let is_unused = |line: &&String| {
        let (path, declaration) = line.split_once(": ").unwrap_or((line, ""));
        let name = path.rsplit("::").next().unwrap_or_default();
        is_own(declaration.split(" [").next().unwrap_or_default()) && !words.contains(name)
    };
    let unused: Vec<&String> = items.iter().filter(is_unused).collect();
    assert!(unused.is_empty(), "used nowhere outside of the engine, and without an example:\n{unused:#?}");
}

fn public_items() -> Vec<String> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/public_api.txt");
    let text = fs::read_to_string(path).unwrap();
    text.lines().filter(|line| !line.starts_with("rhexis::prelude")).map(str::to_owned).collect()
}

/// Files of a folder whose extension is one of these; folders of builds are left out.
fn files(folder: &Path, extensions: &[&str], found: &mut Vec<PathBuf>) {
    if folder.is_file() {
        found.push(folder.to_owned());
        return;
    }
    for entry in fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()) {
        let name = entry.file_name().unwrap_or_default().to_string_lossy().into_owned();
        let is_built = ["target", "node_modules", "results", "dist"].contains(&name.as_str()) || name.starts_with('.');
        let has_extension = entry.extension().is_some_and(|own| extensions.iter().any(|other| own == *other));
        if entry.is_dir() && !is_built || has_extension {
            files(&entry, extensions, found);
        }
    }
}

fn add_words(folder: &Path, words: &mut HashSet<String>) {
    let mut found = Vec::new();
    let extensions = ["rs", "md", "toml", "py", "pyi", "js", "mjs", "ts", "h", "hpp", "c", "cpp", "cs"];
    files(folder, &extensions, &mut found);
    for file in found {
        let text = fs::read_to_string(&file).unwrap_or_default();
        words.extend(text.split(|character| !is_of_name(character)).map(str::to_owned));
    }
}

/// Words of the examples in docs.
fn add_examples(folder: &Path, words: &mut HashSet<String>) {
    let mut found = Vec::new();
    files(folder, &["rs"], &mut found);
    for file in found {
        let mut is_example = false;
        for line in fs::read_to_string(&file).unwrap_or_default().lines() {
            let line = line.trim_start();
            let Some(line) = line.strip_prefix("///").or_else(|| line.strip_prefix("//!")) else {
                is_example = false;
                continue;
            };
            if line.trim_start().starts_with("```") {
                is_example = !is_example;
            } else if is_example {
                words.extend(line.split(|character| !is_of_name(character)).map(str::to_owned));
            }
        }
    }
}
