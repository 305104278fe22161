//! The words of comments: idioms that hide the subject of a sentence are counted, and their budget only falls.

use std::fs;
use std::path::{Path, PathBuf};

/// Comments of `src` and `systems` that may have "what" as a word, mostly for a noun clause ("what a step needs").
const WHAT: usize = 6;

/// Doc items that may lean on the item before them ("The same …", "Its …", "Whether the other has").
const LEANING: usize = 1;

/// Openings of a doc item that cannot be read alone.
const LEANS: [&str; 5] = ["The same", "Its ", "As above", "Whether the other", "Those of"];

fn sources(folder: &Path, found: &mut Vec<PathBuf>) {
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            sources(&path, found);
        } else if path.extension().is_some_and(|extension| extension == "rs") {
            found.push(path);
        }
    }
}

/// The text of a line that is a comment, with the kind of comment.
fn comment(line: &str) -> Option<(&'static str, &str)> {
    let line = line.trim_start();
    ["///", "//!", "//"].into_iter().find_map(|kind| Some((kind, line.strip_prefix(kind)?.trim())))
}

#[test]
fn comments_name_their_subject() {
    let mut files = Vec::new();
    for folder in ["src", "systems"] {
        sources(&Path::new(env!("CARGO_MANIFEST_DIR")).join(folder), &mut files);
    }
    let (mut what, mut leaning) = (Vec::new(), Vec::new());
    for file in &files {
        let text = fs::read_to_string(file).unwrap();
        let mut is_inside = false;
        for (number, line) in (1..).zip(text.lines()) {
            let found = comment(line);
            if let Some((kind, words)) = found {
                let place = || format!("{}:{number}: {words}", file.display());
                if words.split(|c: char| !c.is_alphanumeric()).any(|word| word.eq_ignore_ascii_case("what")) {
                    what.push(place());
                }
                if kind == "///" && !is_inside && LEANS.iter().any(|lean| words.starts_with(lean)) {
                    leaning.push(place());
                }
            }
            is_inside = found.is_some_and(|(kind, _)| kind == "///");
        }
    }
    for (found, budget, hint) in
        [(what, WHAT, "name the thing in place of \"what\""), (leaning, LEANING, "name the subject of the doc item")]
    {
        let count = found.len();
        assert!(count <= budget, "{count} comments, {budget} allowed; {hint}:\n{}", found.join("\n"));
        assert!(
            count == budget,
            "{count} comments are left: lower the budget of {budget} in tests/words.rs, it only falls"
        );
    }
}
