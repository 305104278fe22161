//! The direction of dependencies, computed from the paths in the sources: what stands below knows nothing of what stands above.

mod sources;

use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};

/// The modules of the engine, from the ground up: each may name those before it, and itself.
const ORDER: [&str; 31] = [
    "clock",
    "units",
    "math",
    "source",
    "storage",
    "settings",
    "event",
    "components",
    "generate",
    "report",
    "frame",
    "systems::kernels",
    "systems::parallel",
    "systems::context",
    "systems::work",
    "systems::bending",
    "systems::contact",
    "systems::forces",
    "systems::tools",
    "systems::solver",
    "systems::fracture",
    "systems::guard",
    "registry",
    "membrane",
    "snapshot",
    "replay",
    "systems::step",
    "simulation",
    "error",
    "prelude",
    "internal",
];

/// A source file: where it is, and the path of its module.
struct Source {
    file: PathBuf,
    module: Vec<String>,
    code: String,
}

fn rust_files(folder: &str) -> Vec<PathBuf> {
    sources::files(folder, "rs")
}

/// The code of a file, its lines kept: without comments, and without the unit tests at its end.
fn code_of(file: &Path) -> String {
    let text = fs::read_to_string(file).unwrap();
    let code = text.split("#[cfg(test)]\nmod ").next().unwrap_or_default();
    code.lines().map(|line| line.split("//").next().unwrap_or_default()).collect::<Vec<_>>().join("\n")
}

/// All files of the engine but those of unit tests.
fn engine() -> Vec<Source> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let files = rust_files("src").into_iter().chain(rust_files("systems"));
    let is_test = |file: &Path| file.file_stem().unwrap().to_str().unwrap().ends_with("_tests");
    files
        .filter(|file| !is_test(file) && !file.ends_with("src/lib.rs") && !file.ends_with("systems/mod.rs"))
        .map(|file| {
            let place = file.strip_prefix(root).unwrap().with_extension("");
            let parts = place.iter().map(|part| part.to_str().unwrap().to_owned());
            let module = parts.filter(|part| part != "src" && part != "mod").collect();
            Source { module, code: code_of(&file), file }
        })
        .collect()
}

/// The paths that a `use` tree or a path expression at the start of `text` names.
fn paths_at(text: &str) -> Vec<Vec<&str>> {
    let end = text.find(|c: char| !c.is_alphanumeric() && c != '_').unwrap_or(text.len());
    let (name, rest) = text.split_at(end);
    let Some(inner) = rest.strip_prefix("::") else { return vec![vec![name]] };
    let branches = match inner.strip_prefix('{') {
        Some(list) => branches_of(list).into_iter().flat_map(|branch| paths_at(branch.trim_start())).collect(),
        None => paths_at(inner),
    };
    branches.into_iter().map(|path| [vec![name], path].concat()).collect()
}

/// The branches of a list, after its opening brace.
fn branches_of(list: &str) -> Vec<&str> {
    let (mut depth, mut start, mut branches) = (0, 0, Vec::new());
    for (at, c) in list.char_indices() {
        match c {
            '{' => depth += 1,
            '}' | ',' if depth == 0 => {
                branches.push(&list[start..at]);
                start = at + 1;
                if c == '}' {
                    break;
                }
            }
            '}' => depth -= 1,
            _ => {}
        }
    }
    branches
}

/// The one of [`ORDER`] to which a path from the root of the crate belongs, by its place.
fn place_of(path: &[&str]) -> Option<usize> {
    ORDER.iter().position(|unit| {
        let unit: Vec<&str> = unit.split("::").collect();
        path.starts_with(&unit)
    })
}

/// What a source names, as paths from the root of the crate with their lines.
fn named(source: &Source) -> Vec<(usize, Vec<&str>)> {
    let module: Vec<&str> = source.module.iter().map(String::as_str).collect();
    let starts = ["crate::", "super::"].into_iter().flat_map(|word| source.code.match_indices(word));
    let is_start = |at: usize| !source.code[..at].ends_with(|c: char| c.is_alphanumeric() || "_:$".contains(c));
    let mut found = Vec::new();
    for (at, _) in starts.filter(|(at, _)| is_start(*at)) {
        let line = source.code[..at].matches('\n').count() + 1;
        for path in paths_at(&source.code[at..]) {
            let above = path.iter().take_while(|part| **part == "super").count();
            let base = if above == 0 { &[][..] } else { &module[..module.len().saturating_sub(above)] };
            let full = [base, &path[above.max(1)..]].concat();
            // What the folder of systems gives on is of the step's context.
            let is_context = matches!(full[..], ["systems", "StepContext" | "Formula", ..]);
            found.push((line, if is_context { vec!["systems", "context"] } else { full }));
        }
    }
    found
}

#[test]
fn every_module_names_only_what_stands_below_it() {
    let (mut against, mut seen) = (Vec::new(), BTreeSet::new());
    for source in engine() {
        let module: Vec<&str> = source.module.iter().map(String::as_str).collect();
        let own = place_of(&module).unwrap_or_else(|| panic!("{} has no place in ORDER", source.file.display()));
        for (line, path) in named(&source) {
            let Some(other) = place_of(&path) else { continue };
            seen.insert((own, other));
            if other > own {
                let (from, to) = (ORDER[own], path.join("::"));
                against.push(format!("{}:{line}: {from} names {to}, which stands above it", source.file.display()));
            }
        }
    }
    // A scan that finds no arrows would find none against the order either.
    assert!(seen.len() > 60, "only {} arrows were found", seen.len());
    assert!(against.is_empty(), "{}", against.join("\n"));
}

/// Lines of code that contain one of the words.
fn lines_naming(file: &Path, words: &[&str]) -> Vec<String> {
    let code = code_of(file);
    let lines = code.lines().enumerate().filter(|(_, line)| words.iter().any(|word| line.contains(word)));
    lines.map(|(i, line)| format!("{}:{}: {}", file.display(), i + 1, line.trim())).collect()
}

fn assert_never_named(files: Vec<PathBuf>, words: &[&str], reason: &str) {
    let offences: Vec<String> = files.iter().flat_map(|file| lines_naming(file, words)).collect();
    assert!(offences.is_empty(), "{reason}:\n{}", offences.join("\n"));
}

#[test]
fn kernels_name_only_mathematics() {
    let words = ["crate::storage", "crate::components", "crate::event", "hecs::", "rayon", "parallel"];
    assert_never_named(rust_files("systems/kernels"), &words, "kernels are functions on numbers and slices");
}

#[test]
fn threads_are_named_in_one_folder() {
    let files = rust_files("systems").into_iter().chain(rust_files("src"));
    let others = files.filter(|file| !file.parent().unwrap().ends_with("systems/parallel")).collect();
    assert_never_named(others, &["rayon::", "std::thread"], "threads belong to systems/parallel");
}

/// The words in backquotes of a text, in order.
fn quoted(text: &str) -> Vec<&str> {
    text.split('`').skip(1).step_by(2).collect()
}

/// The part of ARCHITECTURE.md under a heading.
fn architecture<'a>(text: &'a str, heading: &str) -> &'a str {
    let (_, rest) = text.split_once(&format!("\n## {heading}\n")).unwrap_or_else(|| panic!("no heading {heading}"));
    rest.split("\n## ").next().unwrap_or_default()
}

#[test]
fn the_architecture_page_lists_the_layers_and_the_stages() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let page = fs::read_to_string(root.join("ARCHITECTURE.md")).unwrap();
    let layers = architecture(&page, "Order of layers").split("\n\n").find(|part| part.starts_with('`')).unwrap();
    assert_eq!(quoted(layers), ORDER, "ARCHITECTURE.md, Order of layers: list them as tests/layers.rs does");

    let schedule = fs::read_to_string(root.join("systems/step/schedule/mod.rs")).unwrap();
    let (_, stages) = schedule.split_once("pub enum Stage {\n").unwrap();
    let stages = stages.split("\n}").next().unwrap().lines().filter(|line| !line.contains("///"));
    let mut stages: Vec<&str> = stages.map(|line| line.trim().trim_end_matches(',')).collect();
    let rows = architecture(&page, "The step").lines().filter(|line| line.starts_with("| `"));
    let mut listed: Vec<&str> = rows.flat_map(|row| quoted(row.split('|').nth(1).unwrap_or_default())).collect();
    stages.sort_unstable();
    listed.sort_unstable();
    assert_eq!(listed, stages, "ARCHITECTURE.md, The step: a row for each stage of systems/step/schedule/mod.rs");
}
