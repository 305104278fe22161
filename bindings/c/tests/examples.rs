//! The examples are built by the system's compilers and run: to the hash that Rust comes to, and clean under sanitizers.

mod build;
use build::*;

use rhexis_scene::Document;
use std::path::Path;
use std::process::Command;

/// The hash at the end of the scene, in Rust, and the counts of vertices and triangles.
fn in_rust(name: &str) -> (String, usize, usize) {
    let mut instance = Document::named(name).unwrap().scene().unwrap().instantiate().unwrap();
    while !instance.is_finished() {
        instance.advance().unwrap();
    }
    let hash = instance.simulation.hash().to_string();
    let view = instance.simulation.view(instance.bodies[0]).unwrap();
    (hash, view.positions.len(), view.triangles.len())
}

/// Each way of each language that can be built here: how it is called, and the command.
fn programs(folder: &Path) -> Vec<(String, Command)> {
    let mut all = Vec::new();
    for (compiler, suffix, standard, source) in
        [("cc", "c", "-std=c11", "examples/tear.c"), ("c++", "cpp", "-std=c++17", "examples/tear.cpp")]
    {
        if !is_there(compiler, source) {
            continue;
        }
        let mut ways = vec![(&[][..], false), (&[][..], true)];
        if can(compiler, suffix, &SANITIZED, folder) {
            ways.push((&SANITIZED[..], false));
        } else {
            skip(source, &format!("{compiler} has no sanitizers: install the package libasan of its version"));
        }
        for (more, is_static) in ways {
            let program = Build { compiler, standard, source, more, is_static }.program(folder);
            all.push((format!("{source} {more:?}"), Command::new(program)));
        }
    }
    if has_cs("examples/Tear.cs") {
        all.push(("examples/Tear.cs".to_owned(), in_cs("examples/Tear.cs", folder)));
    }
    all
}

#[test]
fn the_examples_tear_the_square_to_the_hash_of_rust() {
    if !cfg!(unix) {
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let scene = folder.join("fig2-tear.toml");
    std::fs::write(&scene, Document::named("fig2-tear").unwrap().text()).unwrap();
    let (hash, vertices, triangles) = in_rust("fig2-tear");
    let mut sheets = Vec::new();
    for (i, (what, mut program)) in programs(folder).into_iter().enumerate() {
        let sheet = folder.join(format!("sheet-{i}.obj"));
        assert_eq!(said(&what, program.arg(&scene).arg(&sheet)), hash, "{what}");
        let obj = std::fs::read_to_string(&sheet).unwrap();
        let count = |kind: &str| obj.lines().filter(|line| line.starts_with(kind)).count();
        assert_eq!((count("v "), count("f ")), (vertices, triangles), "{what}");
        let numbers: Vec<f64> = obj
            .split_whitespace()
            .filter(|word| !matches!(*word, "v" | "f"))
            .map(|word| word.parse().unwrap())
            .collect();
        sheets.push((what, numbers));
    }
    for pair in sheets.windows(2) {
        assert_eq!(pair[0].1, pair[1].1, "the sheets of {} and {}", pair[0].0, pair[1].0);
    }
}

#[test]
fn a_missing_scene_is_told() {
    if !cfg!(unix) {
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let scene = folder.join("bad.toml");
    std::fs::write(&scene, "[scene]\nnam = 'x'\n").unwrap();
    let mut programs = Vec::new();
    if is_there("cc", "the error of tear.c") {
        let (standard, source) = ("-std=c11", "examples/tear.c");
        let build = Build { compiler: "cc", standard, source, more: &[], is_static: false };
        programs.push((Command::new(build.program(folder)), "SCENE: "));
    }
    if has_cs("the error of Tear.cs") {
        programs.push((in_cs("examples/Tear.cs", folder), "Scene: "));
    }
    for (mut program, begin) in programs {
        let output = program.arg(&scene).arg(folder.join("sheet.obj")).output().unwrap();
        let said = String::from_utf8_lossy(&output.stderr).into_owned();
        assert!(!output.status.success() && said.starts_with(begin) && said.contains("bad.toml:2:1"), "{said}");
    }
}

/// The one from arrays, with what it takes from its host around it.
#[test]
fn the_example_of_the_readme_compiles() {
    if !cfg!(unix) || !is_there("cc", "the example of the readme") {
        return;
    }
    let readme = std::fs::read_to_string(root().join("README.md")).unwrap();
    let (_, rest) = readme.split_once("```c\n#include <rhexis.h>\n").unwrap();
    let (example, _) = rest.split_once("```").unwrap();
    let folder = tempfile::tempdir().unwrap();
    let source = folder.path().join("readme.c");
    let given = "const double *positions, const uint32_t *triangles, size_t vertex_count, size_t triangle_count,\n\
                 const uint64_t *keys, size_t key_count, RhexisPose pose_of_hand";
    let text = format!("#include <rhexis.h>\nvoid host({given});\nvoid host({given}) {{\n{example}}}\n");
    std::fs::write(&source, text).unwrap();
    // A host would look at what calls answer, and draw what it is shown.
    let mut command = Command::new("cc");
    command.args(["-std=c11", "-Wall", "-Wextra", "-Werror", "-Wno-unused", "-fsyntax-only", "-I"]);
    succeed("the example of the readme", command.arg(root().join("include")).arg(source));
}
