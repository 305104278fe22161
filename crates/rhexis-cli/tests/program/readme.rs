//! The README keeps to what is: its library example is the one that the crate's docs compile and run, its pictures and links
//! exist.

use std::fs;
use std::path::Path;

fn read(file: &str) -> String {
    fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join("../..").join(file)).unwrap()
}

#[test]
fn library_example_is_the_tested_one() {
    let readme = read("README.md");
    let example = readme.split("```rust\n").nth(1).and_then(|rest| rest.split("```").next()).unwrap();
    let docs = read("src/lib.rs");
    let front_page: Vec<&str> = docs.lines().filter_map(|line| line.strip_prefix("//!")).collect();
    let front_page =
        front_page.iter().map(|line| line.strip_prefix(' ').unwrap_or(line)).collect::<Vec<_>>().join("\n");
    assert!(
        example.lines().count() > 10 && front_page.contains(example),
        "README.md and src/lib.rs differ:\n{example}"
    );
}

/// Documents with Rust: compiled with a crate's docs, or held to an example by a test.
const COMPILED: [&str; 3] = ["README.md", "bindings/bevy/README.md", "crates/rhexis-scene/README.md"];

#[test]
fn rust_in_documents_is_compiled() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    let mut pending = vec![root.clone()];
    while let Some(path) = pending.pop() {
        let name = path.strip_prefix(&root).unwrap().to_string_lossy().into_owned();
        if path.is_dir() {
            let is_made = ["target", "node_modules", ".git"].iter().any(|folder| path.ends_with(folder));
            let inner = fs::read_dir(&path).unwrap().map(|entry| entry.unwrap().path());
            pending.extend(inner.filter(|inner| !is_made && !inner.is_symlink()));
        } else if name.ends_with(".md") {
            let text = fs::read_to_string(&path).unwrap();
            let mut blocks = text.lines().filter(|line| line.trim_start().starts_with("```rust"));
            assert!(
                blocks.clone().next().is_none() || COMPILED.contains(&name.as_str()),
                "{name} has Rust that nothing compiles"
            );
            assert!(blocks.all(|line| line.trim() == "```rust"), "{name} has Rust that is not compiled as it stands");
        }
    }
}

#[test]
fn linked_files_exist() {
    let readme = read("README.md");
    let targets = readme.split("](").skip(1).filter_map(|rest| rest.split(')').next());
    let files: Vec<&str> = targets.filter(|target| !target.contains("://")).collect();
    assert!(files.len() >= 3, "{files:?}");
    for file in files {
        assert!(Path::new(env!("CARGO_MANIFEST_DIR")).join("../..").join(file).exists(), "README.md names {file}");
    }
}

#[test]
fn minimum_rust_version_is_that_of_the_manifest() {
    let manifest = read("Cargo.toml");
    let version = manifest.split("rust-version = \"").nth(1).and_then(|rest| rest.split('"').next()).unwrap();
    assert!(read("README.md").contains(&format!("Rust {version} or newer")), "{version}");
}

#[test]
fn named_scenes_are_in_the_catalog() {
    let readme = read("README.md");
    let after = |words: &str| -> Vec<String> {
        let names = readme.split(words).skip(1).filter_map(|rest| rest.split_whitespace().next());
        names.filter(|name| *name != "NAME`").map(str::to_owned).collect()
    };
    let mut names = after("scenes --show ");
    names.extend(after("-- run "));
    assert!(names.len() >= 2, "{names:?}");
    for name in names {
        assert!(rhexis_scene::catalog::find(&name).is_ok(), "README.md names the scene {name}");
    }
}
