//! A scene's text, with what `--set` changes in it, and where each key stands.
//!
//! An override is put into the parsed tree before it is deserialised, so it is judged like text of the file. Its spans are
//! moved behind the end of the file, which tells whose fault an error is.

use super::error::{Fault, SceneError, Span, explain, is_control, position};
use super::files::Files;
use super::schema::SceneFile;
use super::table_file::{self, TableSpec};
use super::{Scene, catalog, mesh_file, renamed, size};
use rhexis::internal::source;
use serde::Deserialize;
use std::borrow::Cow;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use toml::de::{DeTable, DeValue};

/// The most words a dotted key may have; the schema needs seven.
const DEEPEST: usize = 16;

/// The largest number of a scene: lengths and forces are squared.
const LARGEST: f64 = 1e150;

/// The largest scene file that is read \[bytes\]; a mesh that takes more belongs into a file of its own.
const MOST_BYTES: u64 = 16 << 20;

/// Where `inf` means that the limit is not asked for.
const MAY_BE_INFINITE: [&str; 2] = ["run.advanced.stress_tolerance", "run.position_tolerance"];

/// Texts that are sentences, not names.
const MAY_HAVE_LINES: [&str; 2] = ["scene.about", "scene.reference"];

/// The text of a scene before it is understood.
#[derive(Clone, Debug)]
pub struct Document {
    origin: String,
    /// The scene file, where the text is from one.
    file: Option<PathBuf>,
    /// Where relative paths of files begin.
    folder: PathBuf,
    /// Contents of files by the paths that the text names them by.
    given: BTreeMap<PathBuf, Arc<Vec<u8>>>,
    text: String,
    overrides: Vec<(String, String)>,
}

impl Document {
    /// A scene from text; `origin` names it in errors, files it mentions are looked for in the current directory.
    pub fn new(text: impl Into<String>, origin: impl Into<String>) -> Self {
        let (origin, text) = (origin.into(), text.into());
        Self { origin, file: None, folder: PathBuf::new(), given: BTreeMap::new(), text, overrides: Vec::new() }
    }

    /// A scene file; files it mentions are looked for beside it.
    ///
    /// # Errors
    /// If it cannot be read.
    pub fn load(path: &Path) -> Result<Self, SceneError> {
        let origin = path.display().to_string();
        let refuse = |what: String, hint: &str| {
            let (origin, hint) = (origin.clone(), hint.to_owned());
            SceneError { origin, position: None, key: String::new(), what, hint }
        };
        if !path.is_file() && path.exists() {
            return Err(refuse("is not a regular file".to_owned(), "give the path of a scene file (.toml)"));
        }
        let extension = path.extension().unwrap_or_default().to_string_lossy().to_lowercase();
        if mesh_file::EXTENSIONS.contains(&extension.as_str()) {
            let name = path.file_name().unwrap_or_default().to_string_lossy();
            let hint = format!(
                "`rhexis scenes --show fig2-tear > my.toml` gives a scene; write `mesh = {{ file = \"{name}\" }}` into it"
            );
            return Err(refuse("is a mesh, not a scene".to_owned(), &hint));
        }
        let hint = "check the path; a scene file is UTF-8 text (TOML)";
        let bytes = source::read(path, MOST_BYTES).map_err(|e| refuse(format!("cannot be read: {e}"), hint))?;
        let text = String::from_utf8(bytes).map_err(|e| refuse(format!("cannot be read: {e}"), hint))?;
        let folder = path.parent().unwrap_or(Path::new("")).to_owned();
        Ok(Self { file: Some(path.to_owned()), folder, ..Self::new(text, origin) })
    }

    /// A scene of the catalog.
    ///
    /// # Errors
    /// If there is none of that name.
    pub fn named(name: &str) -> Result<Self, SceneError> {
        let entry = catalog::find(name)?;
        Ok(Self::new(entry.text, format!("{name}.toml (catalog)")))
    }

    /// A scene of the catalog, or else the file at this path.
    ///
    /// # Errors
    /// If there is neither.
    pub fn open(name_or_path: &str) -> Result<Self, SceneError> {
        let path = Path::new(name_or_path);
        match Self::named(name_or_path) {
            Err(unknown) if path.exists() || name_or_path.ends_with(".toml") || path.components().count() > 1 => {
                Self::load(path)
                    .map_err(|error| if path.exists() { error } else { SceneError { hint: unknown.hint, ..error } })
            }
            found => found,
        }
    }

    /// Gives the content of a file that the scene names by this path: for programs without a file system, such as a page in a browser.
    /// It goes before a file of that path.
    #[must_use]
    pub fn with_file(mut self, path: impl Into<PathBuf>, bytes: Vec<u8>) -> Self {
        self.given.insert(path.into(), Arc::new(bytes));
        self
    }

    /// Replaces or adds a value: `run.dt=5`, `bodies.0.tearing.radius=1`. The value is TOML; what is none is a string.
    ///
    /// # Errors
    /// Without an equals sign or a key. Whether the key exists is judged by [`scene`](Self::scene).
    pub fn set(&mut self, assignment: &str) -> Result<(), SceneError> {
        match assignment.split_once('=') {
            Some((key, value)) if (1..=DEEPEST).contains(&key.trim().split('.').filter(|w| !w.is_empty()).count()) => {
                self.overrides.push((key.trim().to_owned(), value.trim().to_owned()));
                Ok(())
            }
            _ => Err(SceneError {
                origin: format!("--set {assignment}"),
                position: None,
                key: String::new(),
                what: "not of the form key=value".to_owned(),
                hint: "write for example --set run.dt=5 or --set bodies.0.tearing.radius=1".to_owned(),
            }),
        }
    }

    /// The text.
    pub fn text(&self) -> &str {
        &self.text
    }

    /// The scene file, where the text is from one.
    pub(super) fn file(&self) -> Option<&Path> {
        self.file.as_deref()
    }

    /// The files that the scene mentions, none of them read.
    pub(super) fn files(&self) -> Files {
        Files::new(self.folder.clone(), self.given.clone())
    }

    /// Understands the text.
    ///
    /// # Errors
    /// Where it is not TOML, does not follow the schema, or holds a number that is not finite or above 10¹⁵⁰, or a name or path with a
    /// control character; `inf` is allowed for `run.advanced.stress_tolerance` and `run.position_tolerance`.
    pub fn scene(self) -> Result<Scene, SceneError> {
        let parsed = self.parse().map_err(|error| self.blame(error, |document| document.parse().map(|_| ())));
        let Parsed { file, spans, tables } = parsed?;
        Ok(Scene { file, document: self, spans, tables })
    }

    /// The error with the override to blame in place of a line of the file: one with which `judge` finds the same fault, and not
    /// without it.
    pub(super) fn blame(&self, error: SceneError, judge: impl Fn(Self) -> Result<(), SceneError>) -> SceneError {
        if error.position.is_none() || self.overrides.is_empty() {
            return error;
        }
        let is_there = |count: &usize| {
            let document = Self { overrides: self.overrides[..*count].to_vec(), ..self.clone() };
            judge(document).is_err_and(|other| (&other.key, &other.what) == (&error.key, &error.what))
        };
        // Between none and all of them, by halving: a trial may build the whole scene.
        let (mut without, mut count) = (0, self.overrides.len());
        if is_there(&0) {
            return error;
        }
        while count - without > 1 {
            let middle = without.midpoint(count);
            if is_there(&middle) {
                count = middle;
            } else {
                without = middle;
            }
        }
        match self.overrides[..count].last() {
            Some((key, value)) => SceneError { origin: format!("--set {key}={value}"), position: None, ..error },
            None => error,
        }
    }

    pub(super) fn parse(&self) -> Result<Parsed, SceneError> {
        let refuse = |error: &toml::de::Error| {
            let (what, hint) = explain(error.message());
            self.at(error.span(), String::new(), what, hint)
        };
        let root = DeTable::parse(&self.text).map_err(|e| refuse(&e))?;
        let texts = self.override_texts();
        let (whole, mut root) = (root.span(), root.into_inner());
        self.apply_preset(&mut root)?;
        for ((key, _), (start, text)) in self.overrides.iter().zip(&texts) {
            let mut parsed = DeTable::parse(text).map_err(|e| refuse(&e))?.into_inner();
            if let Some(value) = parsed.remove("value") {
                let value = moved(value, *start);
                insert(&mut root, key, value).map_err(|(what, hint)| self.at_override(key, what, hint))?;
            }
        }
        let mut spans = BTreeMap::new();
        record(&root, "", &mut spans);
        let mut tables = Vec::new();
        tables_in(&root, "", &mut tables);
        let (files, mut read, mut paths) = (self.files(), Vec::new(), Vec::new());
        for (key, table, span) in tables {
            let spec = TableSpec::deserialize(toml::Deserializer::from(toml::Spanned::new(span.clone(), table)))
                .map_err(|e| refuse(&e))?;
            let points = table_file::read(&spec, &files, &key).map_err(|fault| self.locate(&spans, fault))?;
            paths.extend((!files.is_given(&spec.csv)).then_some(spec.csv));
            read.push((key, format!("value = {points}"), span));
        }
        for (key, text, span) in &read {
            let mut parsed = DeTable::parse(text).map_err(|e| refuse(&e))?.into_inner();
            if let Some(value) = parsed.remove("value") {
                let value = standing_at(value, span);
                insert(&mut root, key, value)
                    .map_err(|(what, hint)| self.at(Some(span.clone()), key.clone(), what, hint))?;
            }
        }
        if let Some((old, new)) = renamed::of_run(|key| spans.contains_key(&format!("run.{key}"))) {
            let key = format!("run.{old}");
            let what = format!("the key is now `run.{new}`");
            return Err(self.at(spans.get(&key).cloned(), key, what, format!("write `{new} = …` in `[run]`")));
        }
        if let Some((key, what, hint)) = first_unusable(&root, "") {
            let span = spans.get(&key).cloned();
            return Err(self.at(span, key, what, hint.to_owned()));
        }
        if let Some(key) = size::hand_beyond(&root, "", &mut 0.0) {
            let what = format!("up to here hands have more than {} points in all", size::MOST_POINTS);
            let hint = "give a larger `every` or a shorter `duration`".to_owned();
            return Err(self.at(spans.get(&key).cloned(), key, what, hint));
        }
        let tree = toml::Spanned::new(whole, root);
        let file = SceneFile::deserialize(toml::Deserializer::from(tree)).map_err(|e| refuse(&e))?;
        Ok(Parsed { file, spans, tables: paths })
    }

    /// Puts the values of the chosen preset in the places of the file's own: `[presets.NAME]` with a dotted key in quotes per value.
    /// What `--set` changes comes after it.
    fn apply_preset<'i>(&'i self, root: &mut DeTable<'i>) -> Result<(), SceneError> {
        let presets = root.remove("presets").map(toml::Spanned::into_inner);
        let set = self.overrides.iter().rev().find(|(key, _)| key == "scene.preset").map(|(_, name)| name.as_str());
        let written = root.get("scene").and_then(|scene| scene.get_ref().get("preset"));
        let place = written.map(toml::Spanned::span);
        let written = written.and_then(|name| name.get_ref().as_str().map(str::to_owned));
        let Some(name) = set.map(|name| name.trim_matches('"').to_owned()).or(written) else { return Ok(()) };
        let mut presets = match presets {
            Some(DeValue::Table(presets)) => presets,
            _ => DeTable::new(),
        };
        let Some(DeValue::Table(values)) = presets.remove(name.as_str()).map(toml::Spanned::into_inner) else {
            let known: Vec<String> = presets.keys().map(|key| key.get_ref().to_string()).collect();
            let hint =
                if known.is_empty() { "it has no presets".to_owned() } else { format!("it has {}", known.join(", ")) };
            let what = format!("the scene has no preset `{name}`");
            return Err(self.at(place, "scene.preset".to_owned(), what, hint));
        };
        for (key, value) in values {
            let (span, key) = (key.span(), key.into_inner());
            let Cow::Borrowed(path) = key else {
                let hint = "write its key as plain text in quotes".to_owned();
                return Err(self.at(Some(span), key.into_owned(), "this key has escapes".to_owned(), hint));
            };
            insert(root, path, value).map_err(|(what, hint)| self.at(Some(span), path.to_owned(), what, hint))?;
        }
        Ok(())
    }

    /// Each override as a document of its own, and its place behind the end of the file and of those before.
    fn override_texts(&self) -> Vec<(usize, String)> {
        let mut next = self.text.len() + 1;
        let overrides = self.overrides.iter().map(|(_, value)| {
            let is_toml = DeValue::parse(value).is_ok();
            let value = if is_toml { value.clone() } else { toml::Value::String(value.clone()).to_string() };
            let (start, text) = (next, format!("value = {value}"));
            next += text.len() + 1;
            (start, text)
        });
        overrides.collect()
    }

    /// The error for a fault, at the place of its key or of the nearest key above that is written down.
    pub(super) fn locate(&self, spans: &BTreeMap<String, Span>, fault: Fault) -> SceneError {
        let mut path = fault.key.as_str();
        let span = loop {
            match spans.get(path) {
                Some(span) => break Some(span.clone()),
                None => match path.rsplit_once('.') {
                    Some((above, _)) => path = above,
                    None => break None,
                },
            }
        };
        self.at(span, fault.key, fault.what, fault.hint)
    }

    fn at(&self, span: Option<Span>, key: String, what: String, hint: String) -> SceneError {
        let start = span.map_or(0, |span| span.start);
        if start <= self.text.len() {
            let position = Some(position(&self.text, start));
            return SceneError { origin: self.origin.clone(), position, key, what, hint };
        }
        let texts = self.override_texts();
        let at_fault =
            self.overrides.iter().zip(&texts).rev().find(|(_, (from, _))| start >= *from).map(|(set, _)| set);
        let origin = at_fault.map_or(String::new(), |(key, value)| format!("--set {key}={value}"));
        SceneError { origin, position: None, key, what, hint }
    }

    fn at_override(&self, key: &str, what: String, hint: String) -> SceneError {
        SceneError { origin: format!("--set {key}=…"), position: None, key: String::new(), what, hint }
    }
}

type Value<'i> = toml::Spanned<DeValue<'i>>;

/// A scene file as it is understood.
pub(super) struct Parsed {
    pub file: SceneFile,
    /// Where every key stands.
    pub spans: BTreeMap<String, Span>,
    /// Files of curves and paths, but for those given with the text.
    pub tables: Vec<PathBuf>,
}

/// The tables of curves and paths, each with its key and place.
fn tables_in<'i>(table: &DeTable<'i>, path: &str, found: &mut Vec<(String, DeTable<'i>, Span)>) {
    for (key, value) in table {
        table_in(value, &join(path, key.get_ref()), found);
    }
}

fn table_in<'i>(value: &Value<'i>, path: &str, found: &mut Vec<(String, DeTable<'i>, Span)>) {
    match value.get_ref() {
        DeValue::Table(table) if table.contains_key("csv") => {
            found.push((path.to_owned(), table.clone(), value.span()))
        }
        DeValue::Table(table) => tables_in(table, path, found),
        DeValue::Array(array) => {
            array.iter().enumerate().for_each(|(i, value)| table_in(value, &join(path, &i.to_string()), found));
        }
        _ => {}
    }
}

/// A value all of which stands at one place of the text.
fn standing_at<'i>(value: Value<'i>, span: &Span) -> Value<'i> {
    let value = match value.into_inner() {
        DeValue::Array(array) => DeValue::Array(array.into_iter().map(|entry| standing_at(entry, span)).collect()),
        plain => plain,
    };
    toml::Spanned::new(span.clone(), value)
}

/// A value with its spans further on in the text.
fn moved(value: Value<'_>, by: usize) -> Value<'_> {
    let further = |span: Span| span.start + by..span.end + by;
    let span = further(value.span());
    let value = match value.into_inner() {
        DeValue::Array(array) => DeValue::Array(array.into_iter().map(|entry| moved(entry, by)).collect()),
        DeValue::Table(table) => {
            let entries = table.into_iter().map(|(key, entry)| {
                let span = further(key.span());
                (toml::Spanned::new(span, key.into_inner()), moved(entry, by))
            });
            DeValue::Table(entries.collect())
        }
        plain => plain,
    };
    toml::Spanned::new(span, value)
}

/// Puts a value at a dotted path; tables on the way are made, arrays are indexed.
fn insert<'i>(root: &mut DeTable<'i>, path: &'i str, value: Value<'i>) -> Result<(), (String, String)> {
    let span = value.span();
    let mut words = path.split('.').peekable();
    let mut table = root;
    let mut walked = String::new();
    while let Some(word) = words.next() {
        let key = toml::Spanned::new(span.clone(), word.into());
        if words.peek().is_none() {
            // An old key would keep its span in the file.
            table.remove(word);
            table.insert(key, value);
            return Ok(());
        }
        if !table.contains_key(word) {
            table.insert(key, toml::Spanned::new(span.clone(), DeValue::Table(DeTable::new())));
        }
        let Some(mut next) = table.get_mut(word).map(toml::Spanned::get_mut) else { break };
        walked = join(&walked, word);
        while let DeValue::Array(array) = next {
            let (count, index) = (array.len(), words.next().unwrap_or_default());
            let entry = index.parse().ok().and_then(|i: usize| array.get_mut(i));
            let Some(entry) = entry else {
                let range = if count == 0 { "no entry".to_owned() } else { format!("the entries 0 to {}", count - 1) };
                return Err((
                    format!("`{walked}` has {range}, so `{index}` names none"),
                    format!("write `{walked}.0` for the first"),
                ));
            };
            if words.peek().is_none() {
                *entry = value;
                return Ok(());
            }
            walked = join(&walked, index);
            next = entry.get_mut();
        }
        match next {
            DeValue::Table(inner) => table = inner,
            _ => {
                let hint = "leave out what stands behind it".to_owned();
                return Err((format!("`{walked}` is a single value and has no keys"), hint));
            }
        }
    }
    Ok(())
}

pub(super) fn join(path: &str, word: &str) -> String {
    if path.is_empty() { word.to_owned() } else { format!("{path}.{word}") }
}

pub(super) fn children<'a, 'i>(value: &'a DeValue<'i>) -> Vec<(String, Span, &'a Value<'i>)> {
    match value {
        DeValue::Table(table) => table.iter().map(|(k, v)| (k.get_ref().to_string(), k.span(), v)).collect(),
        DeValue::Array(array) => array.iter().enumerate().map(|(i, v)| (i.to_string(), v.span(), v)).collect(),
        _ => Vec::new(),
    }
}

/// Where every key stands.
fn record(table: &DeTable<'_>, path: &str, spans: &mut BTreeMap<String, Span>) {
    for (key, value) in table {
        let path = join(path, key.get_ref());
        spans.insert(path.clone(), key.span());
        record_children(value.get_ref(), &path, spans);
    }
}

fn record_children(value: &DeValue<'_>, path: &str, spans: &mut BTreeMap<String, Span>) {
    for (word, span, child) in children(value) {
        let path = join(path, &word);
        record_children(child.get_ref(), &path, spans);
        spans.insert(path, span);
    }
}

/// The first number that cannot be reckoned with, or text that cannot stand on one line: its key, why and the remedy.
fn first_unusable(table: &DeTable<'_>, path: &str) -> Option<(String, String, &'static str)> {
    table.iter().find_map(|(key, value)| unusable(value.get_ref(), &join(path, key.get_ref())))
}

fn unusable(value: &DeValue<'_>, path: &str) -> Option<(String, String, &'static str)> {
    let number = match value {
        DeValue::Float(number) => number.as_str().parse::<f64>(),
        DeValue::String(text) => {
            let is_named = text.contains(is_control) && !MAY_HAVE_LINES.contains(&path);
            let hint = "write it on one line, in plain characters";
            let what = || format!("`{text}` has a line break or a control character, as no name and no path may");
            return is_named.then(|| (path.to_owned(), what(), hint));
        }
        _ => {
            let inside = |(word, _, child): (String, Span, &Value<'_>)| unusable(child.get_ref(), &join(path, &word));
            return children(value).into_iter().find_map(inside);
        }
    };
    let what = match number {
        Ok(f64::INFINITY) if MAY_BE_INFINITE.contains(&path) => return None,
        Ok(value) if value.abs() <= LARGEST => return None,
        Ok(value) if value.is_finite() => "out of scale: its square is too large for a number",
        _ => "not a finite number",
    };
    Some((path.to_owned(), what.to_owned(), "give an ordinary number"))
}
