//! The words of comments and documents: idioms that hide the subject of a sentence are counted, and their budget only falls.

mod sources;

use std::fs;
use std::path::{Path, PathBuf};

/// Lines of comments in `src` and `systems` that may have "what" as a word, mostly for a noun clause ("what a step needs").
const WHAT: usize = 0;

/// Lines of documents that may have "what" as a word.
const WHAT_IN_DOCUMENTS: usize = 202;

/// Doc items that may lean on the item before them ("The same …", "Its …", "Whether the other has").
const LEANING: usize = 0;

/// Openings of a doc item that cannot be read alone.
const LEANS: [&str; 5] = ["The same", "Its ", "As above", "Whether the other", "Those of"];

/// Documents beside the folder `docs`.
const DOCUMENTS: [&str; 5] = ["README.md", "CHANGELOG.md", "ARCHITECTURE.md", "CONTRIBUTING.md", "SECURITY.md"];

/// The text of a line that is a comment, with the kind of comment.
fn comment(line: &str) -> Option<(&'static str, &str)> {
    let line = line.trim_start();
    ["///", "//!", "//"].into_iter().find_map(|kind| Some((kind, line.strip_prefix(kind)?.trim())))
}

fn has_what(text: &str) -> bool {
    text.split(|c: char| !c.is_alphanumeric()).any(|word| word.eq_ignore_ascii_case("what"))
}

/// Fails with the places of `found` where they are more than the budget, and where the budget can fall.
fn judge(name: &str, budget: usize, found: &[String], hint: &str) {
    let count = found.len();
    assert!(count <= budget, "{count} lines, {budget} allowed; {hint}:\n{}", found.join("\n"));
    assert!(count == budget, "{count} lines are left: lower {name} = {budget} in tests/words.rs, which only falls");
}

#[test]
fn comments_name_their_subject() {
    let (mut what, mut leaning) = (Vec::new(), Vec::new());
    for file in ["src", "systems"].into_iter().flat_map(|folder| sources::files(folder, "rs")) {
        let text = fs::read_to_string(&file).unwrap();
        let mut is_inside = false;
        for (number, line) in (1..).zip(text.lines()) {
            let found = comment(line);
            if let Some((kind, words)) = found {
                let place = || format!("{}:{number}: {words}", file.display());
                if has_what(words) {
                    what.push(place());
                }
                if kind == "///" && !is_inside && LEANS.iter().any(|lean| words.starts_with(lean)) {
                    leaning.push(place());
                }
            }
            is_inside = found.is_some_and(|(kind, _)| kind == "///");
        }
    }
    judge("WHAT", WHAT, &what, "name the thing in place of \"what\"");
    judge("LEANING", LEANING, &leaning, "name the subject of the doc item");
}

#[test]
fn documents_name_their_subject() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let documents = DOCUMENTS.iter().map(|name| root.join(name)).chain(sources::files("docs", "md"));
    let lines = |file: PathBuf| -> Vec<String> {
        let text = fs::read_to_string(&file).unwrap();
        let lines = (1..).zip(text.lines()).filter(|(_, line)| has_what(line));
        lines.map(|(number, line)| format!("{}:{number}: {line}", file.display())).collect()
    };
    let found: Vec<String> = documents.flat_map(lines).collect();
    judge("WHAT_IN_DOCUMENTS", WHAT_IN_DOCUMENTS, &found, "name the thing in place of \"what\"");
}
