//! Why a scene is refused: where, what is wrong, how to mend it.

use crate::renamed::remedy;
use std::borrow::Cow;
use std::fmt::{self, Write as _};
use std::ops::Range;

/// A refused scene. Displayed as `file:line:column: what` and, on a second line, how to mend it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct SceneError {
    /// The scene file, the catalog scene or the `--set` that is at fault.
    pub origin: String,
    /// Line and column, both from 1, where the fault has a place in the text.
    pub position: Option<(usize, usize)>,
    /// Dotted path of the key at fault (`bodies.0.material`); empty where the text itself cannot be read.
    pub key: String,
    /// What is wrong.
    pub what: String,
    /// How to mend it.
    pub hint: String,
}

impl fmt::Display for SceneError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}:", on_one_line(&self.origin))?;
        if let Some((line, column)) = self.position {
            write!(f, "{line}:{column}:")?;
        }
        if !self.key.is_empty() {
            write!(f, " {}:", on_one_line(&self.key))?;
        }
        write!(f, " {}", on_one_line(&self.what))?;
        if !self.hint.is_empty() {
            write!(f, "\n  help: {}", on_one_line(&self.hint))?;
        }
        Ok(())
    }
}

impl std::error::Error for SceneError {}

/// Whether a character breaks a line or commands a terminal.
pub(super) fn is_control(c: char) -> bool {
    c.is_control() || matches!(c, '\u{2028}' | '\u{2029}')
}

/// A text with its line breaks and control characters escaped as in JSON, `\u001b`.
pub(super) fn on_one_line(text: &str) -> Cow<'_, str> {
    if !text.contains(is_control) {
        return Cow::Borrowed(text);
    }
    let mut shown = String::with_capacity(text.len());
    for c in text.chars() {
        if is_control(c) {
            // Writing to a String cannot fail.
            let _ = write!(shown, "\\u{:04x}", u32::from(c));
        } else {
            shown.push(c);
        }
    }
    Cow::Owned(shown)
}

/// A fault found after the text was understood; [`Document`](super::Document) adds the place.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Fault {
    pub key: String,
    pub what: String,
    pub hint: String,
}

impl Fault {
    pub(crate) fn new(key: impl Into<String>, what: impl fmt::Display, hint: impl fmt::Display) -> Self {
        Self { key: key.into(), what: what.to_string(), hint: hint.to_string() }
    }
}

/// A number that must be above zero.
pub(super) fn positive(key: String, value: f64, unit: &str) -> Result<f64, Fault> {
    if value > 0.0 {
        return Ok(value);
    }
    Err(Fault::new(key, format!("{value}{} is not above zero", spaced(unit)), "give a number above zero"))
}

/// A number that must not be below zero.
pub(super) fn not_negative(key: String, value: f64, unit: &str) -> Result<f64, Fault> {
    if value >= 0.0 {
        return Ok(value);
    }
    Err(Fault::new(key, format!("{value}{} is below zero", spaced(unit)), "give zero or more"))
}

fn spaced(unit: &str) -> String {
    if unit.is_empty() { String::new() } else { format!(" {unit}") }
}

/// Line and column, from 1, of a byte of the text.
pub(super) fn position(text: &str, byte: usize) -> (usize, usize) {
    let before = text.get(..byte.min(text.len())).unwrap_or(text);
    let line_start = before.rfind('\n').map_or(0, |at| at + 1);
    (before.matches('\n').count() + 1, before[line_start..].chars().count() + 1)
}

/// The word nearest to `given`, if one is near enough to be what was meant.
pub fn nearest<'a>(given: &str, known: impl IntoIterator<Item = &'a str>) -> Option<&'a str> {
    let scored = known.into_iter().map(|word| (strsim::jaro_winkler(given, word), word));
    // 0.75 accepts a slip in four letters and refuses unrelated words of the schema.
    scored.filter(|(score, _)| *score > 0.75).max_by(|a, b| a.0.total_cmp(&b.0)).map(|(_, word)| word)
}

/// What people look for and there is not, with what there is instead.
const INSTEAD: [(&str, &str); 17] = [
    ("self", "a body touches itself by `contact = { self_contact = { radius = … } }`"),
    ("self_contact", "it belongs into `contact`: `contact = { self_contact = { radius = … } }`"),
    ("fixed", "vertices are held by `[[bodies.holds]]`, with a `name` and a `region`"),
    ("pinned", "vertices are held by `[[bodies.holds]]`, with a `name` and a `region`"),
    ("every", "`frames_every` and `pictures_every` are times in ms, `frames` and `pictures` numbers over the run"),
    ("interval", "`frames_every` and `pictures_every` are times in ms, `frames` and `pictures` numbers over the run"),
    ("prony", "stress relaxes by `relaxation = [{ part = …, time = … }]`, parts of the stiffness and times in ms"),
    ("volume", "a closed volume is `compartment = { gas = { … } }` or `compartment = { liquid = { … } }` of the body"),
    ("wind", "wind is not there: `drag` resists motion, `pressure` and `edge_loads` push"),
    ("break_force", "springs break at `break_traction`, a force per area [MPa]; a grip with `force_limit` lets go"),
    ("adhesion", "tissue is stuck to its ground by `[[bodies.beds]]`, with a `region`, `strength` and `energy`"),
    ("glue", "tissue is stuck to its ground by `[[bodies.beds]]`, with a `region`, `strength` and `energy`"),
    ("foundation", "a foundation that holds for ever is `[[bodies.springs]]`, one that comes off `[[bodies.beds]]`"),
    ("units", "units are fixed: mm, g, ms, hence N and MPa; give 1 m as 1000 and 1 kPa as 1e-3"),
    ("seam", "a weak line is a strip of triangles with less strength: `per_triangle = { strength = … }` of the body"),
    ("strength_map", "strengths of triangles are `per_triangle = { strength = … }` of the body"),
    ("torque", "torques are not there: give forces by `point_loads` or `edge_loads`"),
];

/// What is wrong and the hint, from a deserialiser's message: its lists of names become a suggestion.
pub(super) fn explain(message: &str) -> (String, String) {
    let quoted: Vec<&str> = message.split('`').skip(1).step_by(2).collect();
    let (kind, is_name) = if message.starts_with("unknown field") {
        ("key", true)
    } else {
        ("value", message.starts_with("unknown variant"))
    };
    if let (true, Some((given, known))) = (is_name, quoted.split_first()) {
        if let Some((_, hint)) = INSTEAD.iter().find(|(name, _)| name == given) {
            return (format!("there is no `{given}` here"), (*hint).to_owned());
        }
        if let Some(remedy) = remedy(given) {
            return (format!("there is no `{given}` here"), remedy);
        }
        let suggestion = nearest(given, known.iter().copied());
        let list = format!("valid {kind}s here: {}", known.join(", "));
        let hint = suggestion.map_or(list.clone(), |word| format!("did you mean `{word}`? {list}"));
        return (format!("unknown {kind} `{given}`"), hint);
    }
    if let (true, Some(name)) = (message.starts_with("missing field"), quoted.first()) {
        return (
            format!("the key `{name}` is missing"),
            format!("add `{name} = …`; `rhexis scenes --show fig2` shows a whole scene"),
        );
    }
    if message.starts_with("wanted exactly 1 element") {
        return ("exactly one kind belongs here".to_owned(), "keep one of the keys, with its own table".to_owned());
    }
    if message == "wanted string or table" {
        let hint = "write `{ kind = … }`, as the scenes that `rhexis scenes --show` prints do";
        return ("this must name one of several kinds".to_owned(), hint.to_owned());
    }
    if let Some((what, expected)) = message.rsplit_once(", expected ")
        && message.starts_with("invalid ")
    {
        return (what.replace(" as i128", ""), wanted(expected));
    }
    let (what, hint) = message.split_once("; ").unwrap_or((message, ""));
    (what.replace('\n', ", "), hint.to_owned())
}

/// What to write where the deserialiser expected one of its types.
fn wanted(expected: &str) -> String {
    match expected {
        "f32" | "f64" => "give a number".to_owned(),
        "u32" | "u64" | "usize" => "give a whole number, zero or more, of an ordinary size".to_owned(),
        "a sequence" => "give a list: [ … ]".to_owned(),
        "a boolean" => "give true or false".to_owned(),
        "a string" => "give a text in quotes".to_owned(),
        _ if expected.starts_with("struct ") => "give a table: { key = value, … }".to_owned(),
        _ => format!("give {expected}"),
    }
}

/// A byte range, kept apart from [`Range`]'s iteration.
pub(super) type Span = Range<usize>;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn positions_count_lines_and_characters_from_one() {
        let text = "a = 1\nµ = 2 x\n";
        assert_eq!(position(text, 0), (1, 1));
        // The µ takes two bytes and one column.
        assert_eq!(position(text, text.find('x').unwrap()), (2, 7));
        assert_eq!(position(text, 999), (3, 1));
    }

    #[test]
    fn no_type_of_the_program_is_named() {
        let (what, hint) = explain("invalid type: integer `99999999999999999999` as i128, expected usize");
        assert_eq!(what, "invalid type: integer `99999999999999999999`");
        assert!(hint.starts_with("give a whole number"), "{hint}");
        assert_eq!(
            explain("invalid type: string \"x\", expected struct FileSpec").1,
            "give a table: { key = value, … }"
        );
    }

    #[test]
    fn an_unknown_key_brings_its_nearest_neighbour() {
        let (what, hint) = explain("unknown field `yung`, expected one of `young`, `poisson`");
        assert_eq!(what, "unknown key `yung`");
        assert_eq!(hint, "did you mean `young`? valid keys here: young, poisson");
        assert!(!explain("unknown field `zzz`, expected `young`").1.contains("did you mean"));
    }
}
