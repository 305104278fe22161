//! What the crates depend on: few packages for an embedder, each of them used, each under a licence that goes with this one.

use serde_json::Value;
use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

/// The most that an embedder takes with the default features: direct dependencies, and packages in all.
const MOST: [usize; 2] = [15, 70];

/// Licences that go with MIT or Apache-2.0 in source and in programs.
const LICENCES: [&str; 13] = [
    "0BSD",
    "Apache-2.0",
    "Apache-2.0 WITH LLVM-exception",
    "BSD-2-Clause",
    "BSD-3-Clause",
    "BSL-1.0",
    "CC0-1.0",
    "ISC",
    "MIT",
    "MIT-0",
    "Unicode-3.0",
    "Unlicense",
    "Zlib",
];

fn cargo(arguments: &[&str]) -> String {
    let mut command = Command::new(env!("CARGO"));
    let output = command.current_dir(env!("CARGO_MANIFEST_DIR")).args(arguments).output().unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    String::from_utf8(output.stdout).unwrap()
}

#[test]
fn an_embedder_takes_few_packages() {
    let count = |depth: &str| {
        let arguments = ["tree", "--locked", "--package", "rhexis", "--edges", "normal", "--prefix", "none", "--depth"];
        let tree = cargo(&[&arguments[..], &[depth]].concat());
        tree.lines().collect::<BTreeSet<_>>().len()
    };
    // The package itself is in both.
    let found = [count("1") - 1, count("99")];
    assert!(found[0] <= MOST[0] && found[1] <= MOST[1], "{found:?} packages, at most {MOST:?}");
}

/// Whether one of the ways to read the licence is among ours.
fn is_allowed(licence: &str) -> bool {
    let is_ours = |name: &str| LICENCES.contains(&name.trim_matches(['(', ')', ' ']));
    let all = |part: &str| part.split(" AND ").all(is_ours);
    // `(A OR B) AND C` is read from its outside.
    match licence.split_once(") AND ") {
        Some((any, rest)) => is_allowed(any.trim_start_matches('(')) && is_allowed(rest),
        None => licence.replace('/', " OR ").split(" OR ").any(all),
    }
}

#[test]
fn licences_go_with_this_one() {
    let arguments = ["tree", "--locked", "--workspace", "--edges", "normal,build", "--prefix", "none", "--format"];
    let tree = cargo(&[&arguments[..], &["{p} | {l}"]].concat());
    let lines: BTreeSet<&str> =
        tree.lines().map(|line| line.trim_end_matches(" (*)")).filter(|line| !line.is_empty()).collect();
    assert!(lines.len() > 100, "{}", lines.len());
    let licence = |line: &&&str| line.split_once(" | ").is_some_and(|(_, licence)| is_allowed(licence));
    let refused: Vec<_> = lines.iter().filter(|line| !licence(line)).collect();
    assert!(refused.is_empty(), "not in tests/dependencies.rs: {refused:#?}");
}

/// The Rust files of a package, and those beside a file outside it that one of them takes in by its path.
fn rust_files(package: &Path) -> BTreeSet<PathBuf> {
    let (mut pending, mut files) = (vec![package.to_owned()], BTreeSet::new());
    let mut seen = BTreeSet::new();
    while let Some(folder) = pending.pop() {
        if !seen.insert(folder.canonicalize().unwrap()) {
            continue;
        }
        for path in fs::read_dir(&folder).unwrap().map(|entry| entry.unwrap().path()) {
            let is_package = path.join("Cargo.toml").exists() || path.ends_with("target");
            if path.is_dir() && !is_package && !path.is_symlink() {
                pending.push(path);
            } else if path.extension().is_some_and(|extension| extension == "rs") {
                let text = fs::read_to_string(&path).unwrap();
                let taken =
                    text.lines().filter_map(|line| line.trim().strip_prefix("#[path = \"")?.strip_suffix("\"]"));
                pending.extend(taken.map(|taken| folder.join(taken).parent().unwrap().to_owned()));
                files.insert(path);
            }
        }
    }
    files
}

#[test]
fn every_dependency_is_used() {
    let metadata: Value =
        serde_json::from_str(&cargo(&["metadata", "--no-deps", "--locked", "--format-version", "1"])).unwrap();
    let mut unused = Vec::new();
    for package in metadata["packages"].as_array().unwrap() {
        let manifest = Path::new(package["manifest_path"].as_str().unwrap());
        let files = rust_files(manifest.parent().unwrap());
        let code: Vec<String> = files.iter().map(|file| fs::read_to_string(file).unwrap()).collect();
        for dependency in package["dependencies"].as_array().unwrap() {
            let name = dependency["name"].as_str().unwrap().replace('-', "_");
            let uses = [format!("{name}::"), format!("use {name} as"), format!("use {name};")];
            let is_used =
                |line: &str| !line.trim_start().starts_with("//") && uses.iter().any(|words| line.contains(words));
            if !code.iter().any(|text| text.lines().any(is_used)) {
                unused.push(format!("{}: {name}", package["name"]));
            }
        }
    }
    assert!(unused.is_empty(), "dependencies that no line names: {unused:?}");
}
