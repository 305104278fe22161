//! What the readme shows.

const README: &str = include_str!("../../README.md");

#[test]
fn the_readme_has_the_code_of_the_sheet() {
    let sheet = include_str!("../../examples/sheet.rs");
    assert!(README.contains(&format!("```rust\n{sheet}```")), "the readme's code is not that of examples/sheet.rs");
    assert!(sheet.lines().count() <= 60);
}

#[test]
fn the_readme_names_the_keys_of_the_trainer() {
    let keys = include_str!("../../examples/trainer/screen.rs");
    for key in ["Space", "R", "Z", "F", "S", "T", "M", "C", "L", "Esc"] {
        assert!(README.contains(&format!("| {key} |")), "{key} is not in the readme's table");
        assert!(keys.contains(key));
    }
}
