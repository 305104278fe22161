//! What other tools read: the pkg-config file, the CMake package, the declarations for C#; and what this crate promises of its own sources.

mod build;
use build::*;

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;
use std::process::Command;

fn read(path: &str) -> String {
    fs::read_to_string(root().join(path)).unwrap()
}

fn install(prefix: &Path) {
    succeed("install.sh", Command::new("sh").arg(root().join("install.sh")).arg(prefix).arg(libraries()));
}

const PROGRAM: &str = "#include <rhexis.h>\nint main(void) { return rhexis_check_abi(RHEXIS_ABI_VERSION, 0); }\n";

#[test]
fn pkg_config_builds_a_program() {
    if !cfg!(unix) {
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    let prefix = folder.path().join("prefix");
    install(&prefix);
    if !is_there("pkg-config", "the pkg-config file") || !is_there("cc", "the pkg-config file") {
        return;
    }
    let ask = |what: &[&str]| {
        let path = prefix.join("lib/pkgconfig");
        let mut command = Command::new("pkg-config");
        said("pkg-config", command.env("PKG_CONFIG_PATH", path).args(what).arg("rhexis"))
            .split_whitespace()
            .map(str::to_owned)
            .collect::<Vec<_>>()
    };
    assert_eq!(ask(&["--modversion"]), [env!("CARGO_PKG_VERSION")]);
    let (source, program) = (folder.path().join("check.c"), folder.path().join("check"));
    fs::write(&source, PROGRAM).unwrap();
    let mut build = Command::new("cc");
    build.arg(&source).args(ask(&["--cflags", "--libs"])).arg(format!("-Wl,-rpath,{}", prefix.join("lib").display()));
    succeed("cc", build.arg("-o").arg(&program));
    succeed("check", &mut Command::new(program));
}

#[test]
fn cmake_builds_a_program() {
    if !cfg!(unix) || !is_there("cmake", "the CMake package") {
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    let (prefix, source, build) =
        (folder.path().join("prefix"), folder.path().join("source"), folder.path().join("build"));
    install(&prefix);
    fs::create_dir(&source).unwrap();
    fs::write(source.join("check.c"), PROGRAM).unwrap();
    let version = env!("CARGO_PKG_VERSION");
    let lists = format!(
        "cmake_minimum_required(VERSION 3.16)\nproject(check C)\nfind_package(rhexis {version} REQUIRED)\n\
         add_executable(shared check.c)\ntarget_link_libraries(shared rhexis::rhexis)\n\
         add_executable(static check.c)\ntarget_link_libraries(static rhexis::static)\n"
    );
    fs::write(source.join("CMakeLists.txt"), lists).unwrap();
    let prefix = format!("-DCMAKE_PREFIX_PATH={}", prefix.display());
    succeed("cmake", Command::new("cmake").arg("-S").arg(&source).arg("-B").arg(&build).arg(prefix));
    succeed("cmake", Command::new("cmake").arg("--build").arg(&build));
    succeed("shared", &mut Command::new(build.join("shared")));
    succeed("static", &mut Command::new(build.join("static")));
}

/// Every placeholder of the templates is filled by the script.
#[test]
fn nothing_is_left_to_fill_in() {
    if !cfg!(unix) {
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    install(folder.path());
    for file in ["pkgconfig/rhexis.pc", "cmake/rhexis/rhexis-config.cmake", "cmake/rhexis/rhexis-config-version.cmake"]
    {
        let text = fs::read_to_string(folder.path().join("lib").join(file)).unwrap();
        assert!(!text.contains('@'), "{file}: {text}");
    }
}

/// Function and arguments, each as type and name.
type Function = (String, Vec<(String, String)>);

/// Text without comments, with single spaces.
fn bare(text: &str) -> String {
    let mut kept = String::new();
    let mut rest = text;
    while let Some(begin) = rest.find("/*") {
        kept += &rest[..begin];
        rest = rest[begin..].split_once("*/").unwrap().1;
    }
    kept += rest;
    let lines = kept.lines().map(|line| line.split("//").next().unwrap().trim()).filter(|line| !line.starts_with('#'));
    lines.collect::<Vec<_>>().join(" ").split_whitespace().collect::<Vec<_>>().join(" ")
}

fn typed(declaration: &str) -> (String, String) {
    let at = declaration.rfind([' ', '*']).unwrap() + 1;
    (declaration[..at].trim().to_owned(), declaration[at..].trim_start_matches('@').to_owned())
}

fn arguments(list: &str) -> Vec<(String, String)> {
    // Attributes have commas of their own in C#, but none of those used here.
    list.split(", ").filter(|argument| !matches!(*argument, "" | "void")).map(typed).collect()
}

/// Functions by name: what they return and take. In C# each follows the words that begin it.
fn functions(bare: &str, begin: Option<&str>) -> BTreeMap<String, Function> {
    let mut all = BTreeMap::new();
    for statement in bare.split(';') {
        let declared = begin.map_or(Some(statement), |begin| statement.split_once(begin).map(|(_, rest)| rest));
        let Some((head, list)) = declared.and_then(|declared| declared.split_once('(')) else { continue };
        let (returned, name) = typed(head.trim().trim_start_matches("extern \"C\" { ").trim());
        if name.starts_with("rhexis_") {
            let list = list.strip_suffix(')').unwrap_or(list);
            all.insert(name, (returned, arguments(list.trim())));
        }
    }
    all
}

/// Fields by structure: type and name.
fn structures(bare: &str, is_c: bool) -> BTreeMap<String, Vec<(String, String)>> {
    let mut all = BTreeMap::new();
    let keyword = if is_c { "typedef struct {" } else { "public struct " };
    for part in bare.split(keyword).skip(1) {
        let (body, after) = part.split_once('}').unwrap();
        let (name, body) = if is_c {
            (after.split(';').next().unwrap().trim(), body)
        } else {
            let (name, body) = body.split_once('{').unwrap();
            (name.trim(), body)
        };
        let fields = body.split(';').map(str::trim).filter(|field| !field.is_empty()).map(typed).collect();
        all.insert(name.to_owned(), fields);
    }
    all
}

fn number(c: &str) -> Option<&'static str> {
    Some(match c {
        "double" => "double",
        "float" => "float",
        "uint8_t" => "byte",
        "int32_t" => "int",
        "uint32_t" => "uint",
        "uint64_t" => "ulong",
        "size_t" => "UIntPtr",
        _ => return None,
    })
}

/// The C# type of an argument; a buffer is followed by its capacity.
fn argument_in_cs(c: &str, is_buffer: bool) -> String {
    let plain = |name: &str| number(name).map_or(name.to_owned(), str::to_owned);
    if c == "const char *" {
        return "[MarshalAs(UnmanagedType.LPUTF8Str)] string".to_owned();
    }
    match (c.strip_prefix("const ").and_then(|rest| rest.strip_suffix(" *")), c.strip_suffix(" *")) {
        (Some(read), _) if number(read).is_some() => format!("{}[]", plain(read)),
        // Mono passes `in` by value.
        (Some(read), _) => format!("ref {read}"),
        (None, Some(written)) if is_buffer => format!("[Out] {}[]", plain(written)),
        (None, Some(written)) => format!("out {}", plain(written)),
        (None, None) => plain(c),
    }
}

#[test]
fn the_declarations_for_cs_are_those_of_the_header() {
    let (header, cs) = (bare(&read("include/rhexis.h")), bare(&read("unity/Rhexis.cs")));
    let (in_c, in_cs) = (functions(&header, None), functions(&cs, Some("public static extern ")));
    let names = |all: &BTreeMap<String, Function>| all.keys().cloned().collect::<Vec<_>>();
    assert_eq!(names(&in_c), names(&in_cs));
    assert!(in_c.len() > 70, "{}", in_c.len());
    for (name, (returned, arguments)) in &in_c {
        let (returned_in_cs, arguments_in_cs) = &in_cs[name];
        let expected = if returned == "const char *" { "IntPtr" } else { returned };
        assert_eq!(returned_in_cs, expected, "{name}");
        let expected: Vec<(String, String)> = arguments
            .iter()
            .enumerate()
            .map(|(i, (kind, argument))| {
                let is_buffer = arguments.get(i + 1).is_some_and(|(_, next)| next == "capacity");
                (argument_in_cs(kind, is_buffer), argument.clone())
            })
            .collect();
        assert_eq!(arguments_in_cs, &expected, "{name}");
    }
    let (in_c, in_cs) = (structures(&header, true), structures(&cs, false));
    assert_eq!(in_c.keys().collect::<Vec<_>>(), in_cs.keys().collect::<Vec<_>>());
    for (name, fields) in in_c {
        let expected: Vec<(String, String)> = fields
            .into_iter()
            .map(|(kind, field)| match field.split_once('[') {
                Some((field, count)) => {
                    let count = count.trim_end_matches(']');
                    let attribute = format!("[MarshalAs(UnmanagedType.ByValArray, SizeConst = {count})]");
                    (format!("{attribute} public {}[]", number(&kind).unwrap()), field.to_owned())
                }
                None if kind.ends_with('*') => ("public IntPtr".to_owned(), field),
                None => (format!("public {}", number(&kind).map_or(kind.clone(), str::to_owned)), field),
            })
            .collect();
        assert_eq!(in_cs[&name], expected, "{name}");
    }
}

#[test]
fn constants_for_cs_are_those_of_the_header() {
    let (header, cs) = (read("include/rhexis.h"), read("unity/Rhexis.cs"));
    let in_c = header.lines().filter_map(|line| line.strip_prefix("#define RHEXIS_")?.split_once(' '));
    let mut count = 0;
    for (name, value) in in_c {
        assert!(cs.contains(&format!(" RHEXIS_{name} = {value};")), "RHEXIS_{name}");
        count += 1;
    }
    assert_eq!(cs.matches("public const ").count() - cs.matches("public const string").count(), count);
    for line in header.lines().filter_map(|line| line.trim().strip_prefix("RHEXIS_STATUS_")) {
        let (name, value) = line.trim_end_matches(',').split_once(" = ").unwrap();
        let capital = |word: &str| word[..1].to_owned() + &word[1..].to_lowercase();
        let name: String = name.split('_').map(capital).collect();
        assert!(cs.contains(&format!("        {name} = {value},")), "{name}");
    }
}

/// Blocks of unsafe code stand in one file, each under the sentence that says why it is sound.
#[test]
fn unsafe_code_stands_in_one_file() {
    for entry in fs::read_dir(root().join("src")).unwrap() {
        let path = entry.unwrap().path();
        let text = fs::read_to_string(&path).unwrap();
        let code = text.split("#[cfg(test)]").next().unwrap();
        let lines: Vec<&str> = code.lines().collect();
        for (i, line) in lines.iter().enumerate() {
            let is_block = line.contains("unsafe {") || line.contains("unsafe impl");
            if !is_block || line.trim_start().starts_with("//") {
                continue;
            }
            assert!(path.ends_with("pointer.rs"), "{}:{}", path.display(), i + 1);
            let above = lines[..i].iter().rev().take_while(|line| line.trim_start().starts_with("//"));
            assert!(above.clone().any(|line| line.contains("// SAFETY: ")), "{}:{}", path.display(), i + 1);
        }
    }
}
