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
