//! The examples are built by the system's compilers and run: to the hash that Rust comes to, and clean under sanitizers.

use rhexis_scene::Document;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

const STRICT: [&str; 4] = ["-Wall", "-Wextra", "-Werror", "-pedantic"];
const SANITIZED: [&str; 3] = ["-fsanitize=address,undefined", "-fno-sanitize-recover=all", "-g"];

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

/// Where cargo has put the libraries, beside this test.
fn libraries() -> PathBuf {
    std::env::current_exe().unwrap().parent().unwrap().to_owned()
}

fn run(command: &mut Command) -> Option<Output> {
    command.output().ok()
}

/// Whether a compiler is there and builds an empty program with these flags that runs.
fn can(compiler: &str, suffix: &str, flags: &[&str], folder: &Path) -> bool {
    let (source, program) = (folder.join(format!("empty.{suffix}")), folder.join("empty"));
    std::fs::write(&source, "int main(void) { return 0; }\n").unwrap();
    let built = run(Command::new(compiler).args(flags).arg(&source).arg("-o").arg(&program));
    built.is_some_and(|built| built.status.success())
        && run(&mut Command::new(program)).is_some_and(|run| run.status.success())
}

fn succeed(what: &str, command: &mut Command) -> Output {
    let output = command.output().unwrap_or_else(|error| panic!("{what}: {error}"));
    assert!(output.status.success(), "{what}: {}", String::from_utf8_lossy(&output.stderr));
    output
}

struct Build<'a> {
    compiler: &'a str,
    standard: &'a str,
    source: &'a str,
    more: &'a [&'a str],
    is_static: bool,
}

impl Build<'_> {
    fn program(&self, folder: &Path) -> PathBuf {
        let program = folder.join(format!("{}-{}-{}", self.source.replace('.', "-"), self.more.len(), self.is_static));
        let mut command = Command::new(self.compiler);
        command.arg(self.standard).args(STRICT).args(self.more).arg("-I").arg(root().join("include"));
        command.arg(root().join("examples").join(self.source));
        if self.is_static {
            command.arg(libraries().join("librhexis_c.a")).args(["-lpthread", "-ldl", "-lm"]);
        } else {
            command.arg("-L").arg(libraries()).arg("-lrhexis_c");
            command.arg(format!("-Wl,-rpath,{}", libraries().display()));
        }
        succeed(&format!("{} {}", self.compiler, self.source), command.arg("-o").arg(&program));
        program
    }
}

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
    let mut built = 0;
    for (compiler, suffix, standard, source) in
        [("cc", "c", "-std=c11", "tear.c"), ("c++", "cpp", "-std=c++17", "tear.cpp")]
    {
        if !can(compiler, suffix, &[], folder) {
            println!("{compiler} is not there: {source} is not built");
            continue;
        }
        let mut ways = vec![(&[][..], false), (&[][..], true)];
        if can(compiler, suffix, &SANITIZED, folder) {
            ways.push((&SANITIZED[..], false));
        } else {
            println!("{compiler} has no sanitizers");
        }
        for (more, is_static) in ways {
            let program = Build { compiler, standard, source, more, is_static }.program(folder);
            let sheet = folder.join("sheet.obj");
            let output = succeed(source, Command::new(program).arg(&scene).arg(&sheet));
            assert_eq!(String::from_utf8_lossy(&output.stdout).trim(), hash, "{source} {more:?}");
            let obj = std::fs::read_to_string(&sheet).unwrap();
            let count = |kind: &str| obj.lines().filter(|line| line.starts_with(kind)).count();
            assert_eq!((count("v "), count("f ")), (vertices, triangles));
            built += 1;
        }
    }
    println!("{built} programs built and run");
}

#[test]
fn a_missing_scene_is_told() {
    let folder = tempfile::tempdir().unwrap();
    if !cfg!(unix) || !can("cc", "c", &[], folder.path()) {
        return;
    }
    let build = Build { compiler: "cc", standard: "-std=c11", source: "tear.c", more: &[], is_static: false };
    let scene = folder.path().join("bad.toml");
    std::fs::write(&scene, "[scene]\nnam = 'x'\n").unwrap();
    let output = Command::new(build.program(folder.path())).arg(&scene).arg("sheet.obj").output().unwrap();
    let said = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(!output.status.success() && said.starts_with("SCENE: ") && said.contains("bad.toml:2:1"), "{said}");
}
