//! The header is what cbindgen makes of the sources.

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

/// Wrapped pointers as the pointers that they are: `Out_RhexisPose pose` becomes `RhexisPose *pose`.
fn plain_pointers(header: &str) -> String {
    let mut wrapped = BTreeMap::new();
    let mut kept: Vec<&str> = Vec::new();
    for line in header.lines() {
        let typedef = line.strip_prefix("typedef ").and_then(|rest| rest.strip_suffix(';')?.split_once(" *"));
        let wrapper = typedef.filter(|(_, name)| {
            *name == "Text" || ["Out_", "In_", "Array_", "Buffer_"].iter().any(|kind| name.starts_with(kind))
        });
        match wrapper {
            Some((target, name)) => {
                wrapped.insert(name.to_owned(), target.trim_start_matches("struct ").to_owned());
                // Its documentation goes with it.
                if kept.last().is_some_and(|line| line.trim_end() == " */") {
                    while kept.pop().is_some_and(|line| line != "/**") {}
                }
            }
            None => kept.push(line),
        }
    }
    let mut text = kept.join("\n") + "\n";
    // Longest first: no name is a part of another one then.
    let mut names: Vec<_> = wrapped.into_iter().collect();
    names.sort_by_key(|(name, _)| std::cmp::Reverse(name.len()));
    for (name, target) in names {
        text = text.replace(&format!("struct {name} "), &format!("{target} *"));
        text = text.replace(&format!("{name} "), &format!("{target} *"));
    }
    let mut lines: Vec<&str> = Vec::new();
    for line in text.lines() {
        if !(line.is_empty() && lines.last().is_some_and(|last| last.is_empty())) {
            lines.push(line);
        }
    }
    lines.join("\n") + "\n"
}

fn generated() -> String {
    let config = cbindgen::Config::from_file(root().join("cbindgen.toml")).unwrap();

    // The modules are found from there.
    let builder = cbindgen::Builder::new().with_config(config).with_src(root().join("src/lib.rs"));
    let mut bytes = Vec::new();
    builder.generate().unwrap().write(&mut bytes);
    plain_pointers(&String::from_utf8(bytes).unwrap()).replace("\\[", "[").replace("\\]", "]")
}

#[test]
fn the_header_is_what_the_sources_say() {
    let path = root().join("include/rhexis.h");
    let made = generated();
    if std::env::var_os("RHEXIS_UPDATE").is_some() {
        fs::write(&path, &made).unwrap();
    }
    let there = fs::read_to_string(&path).unwrap_or_default();
    let first = made.lines().zip(there.lines()).find(|(made, there)| made != there);
    assert!(
        there == made,
        "include/rhexis.h is not up to date (RHEXIS_UPDATE=1 writes it); first difference: {first:?}"
    );
}
