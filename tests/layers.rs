//! The direction of dependencies, read from the `use` lines: data never names systems, kernels name only mathematics,
//! systems do not name each other, threads are named in one file.

use std::fs;
use std::path::{Path, PathBuf};

fn rust_files(folder: &str) -> Vec<PathBuf> {
    let mut pending = vec![Path::new(env!("CARGO_MANIFEST_DIR")).join(folder)];
    let mut files = Vec::new();
    while let Some(path) = pending.pop() {
        if path.is_dir() {
            pending.extend(fs::read_dir(&path).unwrap().map(|entry| entry.unwrap().path()));
        } else if path.extension().is_some_and(|e| e == "rs") {
            files.push(path);
        }
    }
    files.sort();
    assert!(!files.is_empty(), "{folder} holds no Rust file");
    files
}

/// Lines of code (comments and the unit tests at the end left out) that contain one of the words.
fn lines_naming(file: &Path, words: &[&str]) -> Vec<String> {
    let text = fs::read_to_string(file).unwrap();
    let code = text.split("#[cfg(test)]\nmod tests {").next().unwrap_or_default();
    let code_lines = code.lines().enumerate().filter(|(_, line)| !line.trim_start().starts_with("//"));
    code_lines
        .filter(|(_, line)| words.iter().any(|word| line.contains(word)))
        .map(|(i, line)| format!("{}:{}: {}", file.display(), i + 1, line.trim()))
        .collect()
}

fn assert_never_named(folders: &[&str], words: &[&str], reason: &str) {
    let files = folders.iter().flat_map(|folder| rust_files(folder));
    let offences: Vec<String> = files.flat_map(|file| lines_naming(&file, words)).collect();
    assert!(offences.is_empty(), "{reason}:\n{}", offences.join("\n"));
}

const FACES: [&str; 3] = ["crate::schedule", "crate::simulation", "crate::membrane"];

#[test]
fn mathematics_names_nothing_of_the_engine() {
    assert_never_named(&["src/math"], &["crate::"], "src/math stands on glam alone");
}

#[test]
fn data_never_names_systems() {
    let words = [&["crate::systems", "systems::"], &FACES[..]].concat();
    assert_never_named(&["src/storage", "src/components"], &words, "storage and components are data");
    assert_never_named(&["src/storage"], &["crate::components"], "storage does not know what entities carry");
}

#[test]
fn kernels_name_only_mathematics() {
    let words = [&["crate::storage", "crate::components", "hecs::", "rayon", "parallel"], &FACES[..]].concat();
    assert_never_named(&["systems/kernels"], &words, "kernels are functions on numbers and slices");
}

#[test]
fn systems_name_neither_faces_nor_each_other() {
    assert_never_named(&["systems"], &FACES, "systems do not know who runs them");
    let schedule = fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join("src/schedule.rs")).unwrap();
    let systems: Vec<&str> = schedule
        .lines()
        .filter_map(|line| line.trim().strip_prefix("system(\"")?.split("systems::").nth(1)?.split("::").next())
        .collect();
    assert!(systems.len() > 10, "the step's systems are read from src/schedule.rs: {systems:?}");
    for file in rust_files("systems") {
        let own = file.file_stem().unwrap().to_str().unwrap().to_owned();
        if !systems.contains(&own.as_str()) {
            continue;
        }
        let others = systems.iter().filter(|other| **other != own);
        let words: Vec<String> =
            others.flat_map(|o| [format!("super::{o}"), format!("systems::{o}"), format!(" {o}::")]).collect();
        let words: Vec<&str> = words.iter().map(String::as_str).collect();
        let offences = lines_naming(&file, &words);
        assert!(offences.is_empty(), "a system names another:\n{}", offences.join("\n"));
    }
}

#[test]
fn threads_are_named_in_one_folder() {
    let files = rust_files("systems").into_iter().chain(rust_files("src"));
    let others = files.filter(|file| !file.parent().unwrap().ends_with("systems/parallel"));
    let offences: Vec<String> = others.flat_map(|file| lines_naming(&file, &["rayon::", "std::thread"])).collect();
    assert!(offences.is_empty(), "threads belong to systems/parallel:\n{}", offences.join("\n"));
}
