//! The examples are built by the system's compilers and run: to the hash that Rust comes to, and clean under sanitizers.

mod build;
use build::*;

use rhexis::storage::TriangleMesh;
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

const OWN: &str = "## A mesh of your own";

/// The first block of a language below a heading in a page of this package.
fn block(page: &str, heading: &str, language: &str) -> String {
    let page = std::fs::read_to_string(root().join(page)).unwrap();
    let (_, below) = page.split_once(heading).unwrap();
    let (_, rest) = below.split_once(&format!("```{language}\n")).unwrap();
    rest.split_once("\n```").unwrap().0.to_owned() + "\n"
}

/// Numbers between commas.
fn listed<T: ToString>(numbers: impl IntoIterator<Item = T>) -> String {
    numbers.into_iter().map(|number| number.to_string()).collect::<Vec<_>>().join(", ")
}

/// The programs of the pages that tear a disc from arrays: as they stand there, with the arrays of a host around them.
fn disc_programs(folder: &Path, disc: &TriangleMesh) -> Vec<(&'static str, Command)> {
    let positions = listed(disc.positions.iter().flat_map(|position| position.to_array()));
    let triangles = listed(disc.triangles.as_flattened());
    let (vertex_count, triangle_count) = (disc.positions.len(), disc.triangles.len());
    let write = |name: &str, text: String| {
        let path = folder.join(name);
        std::fs::write(&path, text).unwrap();
        path.display().to_string()
    };
    let mut all = Vec::new();
    if is_there("cc", "the program of the readme") {
        let example = block("README.md", OWN, "c");
        let (includes, example) = example.split_once("\n\n").unwrap();
        let text = format!(
            "{includes}\nstatic const double positions[] = {{{positions}}};\nstatic const uint32_t triangles[] = {{{triangles}}};\n\
             static const size_t vertex_count = {vertex_count}, triangle_count = {triangle_count};\n\
             int main(void) {{\n{example}return 0;\n}}\n"
        );
        let (compiler, standard, source) = ("cc", "-std=c11", write("own.c", text));
        let build = Build { compiler, standard, source: &source, more: &[], is_static: false };
        all.push(("C", Command::new(build.program(folder))));
    }
    if is_there("c++", "the program of the readme in C++") {
        let example = block("README.md", OWN, "cpp");
        let (includes, example) = example.split_once("\n\n").unwrap();
        let text = format!(
            "{includes}\nint main() {{\nconst std::vector<double> positions{{{positions}}};\n\
             const std::vector<std::uint32_t> triangles{{{triangles}}};\n{example}}}\n"
        );
        let (compiler, standard, source) = ("c++", "-std=c++17", write("own.cpp", text));
        let build = Build { compiler, standard, source: &source, more: &[], is_static: false };
        all.push(("C++", Command::new(build.program(folder))));
    }
    if has_cs("the program of docs/unity.md") {
        let example = block("docs/unity.md", "## Without Unity", "csharp");
        let text = format!(
            "{example}\npublic static class Host\n{{\n    public static void Main()\n    {{\n        \
             Own.Run(new double[] {{ {positions} }}, new uint[] {{ {triangles} }});\n    }}\n}}\n"
        );
        all.push(("C#", in_cs(&write("Own.cs", text), folder)));
    }
    all
}

#[test]
fn the_programs_of_the_pages_tear_a_disc() {
    if !cfg!(unix) {
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    let disc = rhexis::generate::disc(12.0, 1200).unwrap();
    let mut counts = Vec::new();
    for (language, mut program) in disc_programs(folder.path(), &disc) {
        let told = said(language, &mut program);
        assert!(told.lines().all(|line| line.contains(" ms: the tear goes on to (")), "{language}: {told}");
        counts.push((language, told.lines().count()));
    }
    assert!(counts.iter().all(|(_, count)| *count > 3 && *count == counts[0].1), "{counts:?}");
}

#[test]
fn the_scene_of_the_readme_tears_a_disc() {
    if !cfg!(unix) || !is_there("cc", "the scene of the readme") {
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    let disc = rhexis::generate::disc(12.0, 1200).unwrap();
    let vertices = disc.positions.iter().map(|p| format!("v {} {} {}\n", p.x, p.y, p.z));
    let faces = disc.triangles.iter().map(|[a, b, c]| format!("f {} {} {}\n", a + 1, b + 1, c + 1));
    std::fs::write(folder.path().join("disc.obj"), vertices.chain(faces).collect::<String>()).unwrap();
    std::fs::write(folder.path().join("my.toml"), block("README.md", OWN, "toml")).unwrap();
    let (compiler, standard, source) = ("cc", "-std=c11", "examples/tear.c");
    let build = Build { compiler, standard, source, more: &[], is_static: false };
    let mut tear = Command::new(build.program(folder.path()));
    let output = succeed("tear", tear.current_dir(&folder).args(["my.toml", "torn.obj"]));
    let told = String::from_utf8(output.stderr).unwrap();
    assert!(told.contains("torn through at"), "{told}");
}
