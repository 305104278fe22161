//! Programs that tests build with the compilers of the system, against the libraries that cargo has put beside the tests.

#![allow(dead_code, reason = "each test takes what it needs")]

use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

const STRICT: [&str; 4] = ["-Wall", "-Wextra", "-Werror", "-pedantic"];
pub const SANITIZED: [&str; 3] = ["-fsanitize=address,undefined", "-fno-sanitize-recover=all", "-g"];

/// Tools, and the package of Debian that has each.
const TOOLS: [(&str, &str); 6] = [
    ("cc", "gcc"),
    ("c++", "g++"),
    ("pkg-config", "pkgconf"),
    ("cmake", "cmake"),
    ("mcs", "mono-mcs"),
    ("mono", "mono-runtime"),
];

pub fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

/// Where cargo has put the libraries, beside this test.
pub fn libraries() -> PathBuf {
    std::env::current_exe().unwrap().parent().unwrap().to_owned()
}

/// Says on the terminal, past what cargo keeps back of tests that succeed, that something is not tested, and how it would be.
pub fn skip(what: &str, remedy: &str) {
    std::io::stderr().write_all(format!("skipped: {what}: {remedy}\n").as_bytes()).unwrap();
}

/// Whether a tool is there; where it is not, what is skipped is said.
pub fn is_there(tool: &str, what: &str) -> bool {
    let (_, package) = TOOLS.into_iter().find(|(known, _)| *known == tool).unwrap();
    let found = Command::new(tool).arg("--version").output().is_ok_and(|output| output.status.success());
    if !found {
        skip(what, &format!("{tool} is not there: install the package {package}"));
    }
    found
}

/// Whether a compiler builds an empty program with these flags that runs.
pub fn can(compiler: &str, suffix: &str, flags: &[&str], folder: &Path) -> bool {
    let (source, program) = (folder.join(format!("empty.{suffix}")), folder.join("empty"));
    std::fs::write(&source, "int main(void) { return 0; }\n").unwrap();
    let succeeds = |command: &mut Command| command.output().is_ok_and(|output| output.status.success());
    succeeds(Command::new(compiler).args(flags).arg(&source).arg("-o").arg(&program))
        && succeeds(&mut Command::new(program))
}

pub fn succeed(what: &str, command: &mut Command) -> Output {
    let output = command.output().unwrap_or_else(|error| panic!("{what}: {error}"));
    let [said, told] = [&output.stdout, &output.stderr].map(|bytes| String::from_utf8_lossy(bytes));
    assert!(output.status.success(), "{what}: {said}{told}");
    output
}

pub fn said(what: &str, command: &mut Command) -> String {
    String::from_utf8(succeed(what, command).stdout).unwrap().trim().to_owned()
}

/// A program in C or C++.
pub struct Build<'a> {
    pub compiler: &'a str,
    pub standard: &'a str,
    /// Below this package.
    pub source: &'a str,
    pub more: &'a [&'a str],
    pub is_static: bool,
}

impl Build<'_> {
    pub fn program(&self, folder: &Path) -> PathBuf {
        let name = self.source.replace(['.', '/'], "-");
        let program = folder.join(format!("{name}-{}-{}", self.more.len(), self.is_static));
        let mut command = Command::new(self.compiler);
        command.arg(self.standard).args(STRICT).args(self.more).arg("-I").arg(root().join("include"));
        command.arg(root().join(self.source));
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

/// Builds a program in C# together with the declarations, and makes the command that runs it.
pub fn in_cs(source: &str, folder: &Path) -> Command {
    let program = folder.join(source.replace(['.', '/'], "-") + ".exe");
    let mut command = Command::new("mcs");
    command.args(["-langversion:7", "-warn:4", "-warnaserror"]).arg(format!("-out:{}", program.display()));
    succeed(source, command.arg(root().join(source)).arg(root().join("unity/Rhexis.cs")));
    let mut run = Command::new("mono");
    run.env("LD_LIBRARY_PATH", libraries()).arg(program);
    run
}

/// Whether C# can be built and run here.
pub fn has_cs(what: &str) -> bool {
    is_there("mcs", what) && is_there("mono", what)
}
