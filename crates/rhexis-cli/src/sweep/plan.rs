//! A sweep file: the scene, what is set in it, what varies, and so its cases.

use super::values::{Distribution, Fault, Value, listed, written};
use rhexis::internal::source;
use rhexis_scene::{Document, Scene, SceneError, catalog, nearest};
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use toml::de::{DeTable, DeValue};

/// The most cases of a sweep.
const MOST_CASES: u64 = 1_000_000;

/// The largest sweep file that is read \[bytes\].
const MOST_BYTES: u64 = 16 << 20;

/// Nothing is drawn and no frames are written unless the file says otherwise: a thousand runs would fill the disk.
const QUIET: [&str; 2] = ["output.pictures=0", "output.frames=0"];

const KNOWN: [&str; 7] = ["scene", "samples", "seed", "keep", "set", "vary", "sample"];

/// What varies: one key of the scene, or several that take the same value.
#[derive(Clone, Debug)]
pub(super) struct Parameter {
    /// The keys as the file has them.
    pub name: String,
    keys: Vec<String>,
    /// Line and column.
    place: (usize, usize),
    values: Values,
}

#[derive(Clone, Debug)]
enum Values {
    Listed(Vec<String>),
    Random(Distribution),
}

/// A sweep file that has been understood.
#[derive(Debug)]
pub(super) struct Plan {
    /// The file.
    pub origin: PathBuf,
    /// The scene's name or path.
    pub scene: String,
    /// Whether the directories of single runs are kept.
    pub keep: bool,
    fixed: Vec<Parameter>,
    assignments: Vec<String>,
    parameters: Vec<Parameter>,
    samples: u64,
    seed: u64,
}

impl Plan {
    /// Reads a file; `set` are further values for all cases.
    ///
    /// # Errors
    /// With file, line and remedy, for what is no TOML, an unknown key and values that are none.
    pub(super) fn read(path: &Path, set: &[String]) -> Result<Self, SceneError> {
        let origin = path.display().to_string();
        let hint = "a sweep file is TOML: `rhexis sweep --help` shows one";
        let refuse = |what: String| SceneError {
            origin: origin.clone(),
            position: None,
            key: String::new(),
            what,
            hint: hint.to_owned(),
        };
        let bytes = source::read(path, MOST_BYTES).map_err(|error| refuse(format!("cannot be read: {error}")))?;
        let text = String::from_utf8(bytes).map_err(|error| refuse(format!("cannot be read: {error}")))?;
        let root = DeTable::parse(&text).map_err(|error| {
            let position = error.span().map(|span| position(&text, span.start));
            SceneError { position, ..refuse(error.message().to_owned()) }
        })?;
        let reader = Reader { origin: &origin, text: &text };
        let mut plan = reader.plan(path, root.get_ref())?;
        plan.assignments = set.to_vec();
        Ok(plan)
    }

    /// The parameters in the order of the file: lists and ranges, then samples.
    pub(super) fn parameters(&self) -> &[Parameter] {
        &self.parameters
    }

    /// Number of cases.
    pub(super) fn count(&self) -> u64 {
        self.parameters
            .iter()
            .fold(1, |count: u64, parameter| count.saturating_mul(parameter.count()))
            .saturating_mul(self.samples)
    }

    /// The values of a case, one per parameter. The last list changes from case to case, but for the samples.
    pub(super) fn values(&self, case: u64) -> Vec<String> {
        let (mut rest, sample) = (case / self.samples, case % self.samples);
        let mut values: Vec<String> = Vec::with_capacity(self.parameters.len());
        for parameter in self.parameters.iter().rev() {
            values.push(match &parameter.values {
                Values::Listed(listed) => {
                    let value = listed[(rest % listed.len() as u64) as usize].clone();
                    rest /= listed.len() as u64;
                    value
                }
                Values::Random(distribution) => distribution.draw(self.seed, sample, &parameter.name),
            });
        }
        values.reverse();
        values
    }

    /// What `--set` would have to say for a case.
    pub(super) fn assignments(&self, values: &[String]) -> Vec<String> {
        let fixed = self.fixed.iter().flat_map(|parameter| match &parameter.values {
            Values::Listed(listed) => parameter.assignments(&listed[0]),
            Values::Random(_) => Vec::new(),
        });
        let varied = self.parameters.iter().zip(values).flat_map(|(parameter, value)| parameter.assignments(value));
        let quiet = QUIET.map(str::to_owned).into_iter();
        quiet.chain(fixed).chain(self.assignments.iter().cloned()).chain(varied).collect()
    }

    /// The scene of a case.
    ///
    /// # Errors
    /// For a key or a value that the schema refuses, at its place in the sweep file.
    pub(super) fn scene(&self, document: &Document, values: &[String]) -> Result<Scene, SceneError> {
        let mut document = document.clone();
        let understood = self.assignments(values).iter().try_for_each(|assignment| document.set(assignment));
        understood.and_then(|()| document.scene()).map_err(|error| self.placed(error))
    }

    /// The error at the place of the parameter that it blames.
    fn placed(&self, error: SceneError) -> SceneError {
        let blames = |key: &String| error.origin.starts_with(&format!("--set {key}="));
        let at_fault = self.fixed.iter().chain(&self.parameters).find(|parameter| parameter.keys.iter().any(blames));
        match at_fault {
            Some(parameter) => SceneError {
                origin: self.origin.display().to_string(),
                position: Some(parameter.place),
                what: format!("{} ({})", error.what, error.origin.trim_start_matches("--set ")),
                ..error
            },
            None => error,
        }
    }
}

impl Parameter {
    fn count(&self) -> u64 {
        match &self.values {
            Values::Listed(listed) => listed.len() as u64,
            Values::Random(_) => 1,
        }
    }

    fn assignments(&self, value: &str) -> Vec<String> {
        self.keys.iter().map(|key| format!("{key}={value}")).collect()
    }
}

/// The text on its way to a plan.
struct Reader<'a> {
    origin: &'a str,
    text: &'a str,
}

impl Reader<'_> {
    fn fault(&self, at: usize, key: &str, (what, hint): (String, &str)) -> SceneError {
        SceneError {
            origin: self.origin.to_owned(),
            position: Some(position(self.text, at)),
            key: key.to_owned(),
            what,
            hint: hint.to_owned(),
        }
    }

    fn plan(&self, path: &Path, root: &DeTable<'_>) -> Result<Plan, SceneError> {
        for key in root.keys() {
            let name = key.get_ref().as_ref();
            if !KNOWN.contains(&name) {
                let hint = match nearest(name, KNOWN) {
                    Some(known) => format!("did you mean `{known}`?"),
                    None if name.contains('.') => "keys of the scene stand in [set], [vary] or [sample]".to_owned(),
                    None => format!("it may have {}", KNOWN.join(", ")),
                };
                return Err(self.fault(key.span().start, name, ("unknown key".to_owned(), &hint)));
            }
        }
        let scene = match root.get("scene").map(|value| (value.span().start, value.get_ref().as_str())) {
            Some((_, Some(scene))) => located(path, scene),
            Some((at, None)) => return Err(self.fault(at, "scene", ("is no string".to_owned(), SCENE))),
            None => return Err(self.fault(0, "", ("it names no scene".to_owned(), SCENE))),
        };
        let fixed = self.parameters(root, "set", |value| Ok(Values::Listed(vec![written(value, self.text)])))?;
        let mut parameters = self.parameters(root, "vary", |value| listed(value, self.text).map(Values::Listed))?;
        let random = |value: &Value<'_>| Distribution::read(value, self.text).map(Values::Random);
        parameters.extend(self.parameters(root, "sample", random)?);
        let has_samples = parameters.iter().any(|parameter| matches!(parameter.values, Values::Random(_)));
        let samples = self.whole(root, "samples")?;
        let place = root.get("samples").or(root.get("sample")).map_or(0, |value| value.span().start);
        let samples = match (samples, has_samples) {
            (Some(samples), true) if samples > 0 => samples,
            (None, false) => 1,
            _ => {
                let what = "`samples`, a number from 1, and a table [sample] go together".to_owned();
                return Err(self.fault(place, "samples", (what, "give both or neither")));
            }
        };
        self.distinct(fixed.iter().chain(&parameters))?;
        let keep = match root.get("keep").map(|value| (value.span().start, value.get_ref().as_bool())) {
            None => true,
            Some((_, Some(keep))) => keep,
            Some((at, None)) => {
                return Err(self.fault(at, "keep", ("is not true or false".to_owned(), "write keep = false")));
            }
        };
        let seed = self.whole(root, "seed")?.unwrap_or(1);
        let (origin, assignments) = (path.to_owned(), Vec::new());
        let plan = Plan { origin, scene, keep, fixed, assignments, parameters, samples, seed };
        if plan.count() > MOST_CASES {
            let what = format!("that would be more than {MOST_CASES} cases");
            return Err(self.fault(0, "", (what, "give shorter lists, or `samples` in place of ranges")));
        }
        Ok(plan)
    }

    fn whole(&self, root: &DeTable<'_>, key: &str) -> Result<Option<u64>, SceneError> {
        let Some(value) = root.get(key) else { return Ok(None) };
        let number = written(value, self.text).replace('_', "").parse().ok();
        let fault = || ("is not a whole number, zero or more".to_owned(), "write for example 20");
        number.map(Some).ok_or_else(|| self.fault(value.span().start, key, fault()))
    }

    /// The entries of a table in the order of the file.
    fn parameters(
        &self,
        root: &DeTable<'_>,
        table: &str,
        read: impl Fn(&Value<'_>) -> Result<Values, Fault>,
    ) -> Result<Vec<Parameter>, SceneError> {
        let Some(value) = root.get(table) else { return Ok(Vec::new()) };
        let DeValue::Table(entries) = value.get_ref() else {
            let hint = format!("write [{table}] and below it one key per line");
            return Err(self.fault(value.span().start, table, ("is no table".to_owned(), &hint)));
        };
        let mut entries: Vec<_> = entries.iter().collect();
        entries.sort_by_key(|(key, _)| key.span().start);
        let parameter = |(key, value): (&toml::Spanned<std::borrow::Cow<'_, str>>, &Value<'_>)| {
            let (at, name) = (key.span().start, key.get_ref().to_string());
            let keys: Vec<String> = name.split(',').map(|key| key.trim().to_owned()).collect();
            let is_bare = !name.contains('.');
            if is_bare || keys.iter().any(|key| key.is_empty() || key.contains('=')) {
                let hint = format!("write the whole path in quotes: \"bodies.0.pre_stretch\" = …, in [{table}]");
                return Err(self.fault(at, &name, ("is no path of a value".to_owned(), &hint)));
            }
            let values = read(value).map_err(|fault| self.fault(at, &name, fault))?;
            Ok(Parameter { name, keys, place: position(self.text, at), values })
        };
        entries.into_iter().map(parameter).collect()
    }

    fn distinct<'p>(&self, parameters: impl Iterator<Item = &'p Parameter>) -> Result<(), SceneError> {
        let mut seen = BTreeSet::new();
        for parameter in parameters {
            if let Some(twice) = parameter.keys.iter().find(|key| !seen.insert(key.as_str())) {
                return Err(SceneError {
                    origin: self.origin.to_owned(),
                    position: Some(parameter.place),
                    key: twice.clone(),
                    what: "is given twice".to_owned(),
                    hint: "keep it in one of [set], [vary] and [sample]".to_owned(),
                });
            }
        }
        Ok(())
    }
}

const SCENE: &str = "write scene = \"capsulorhexis\", or the path of a scene file from here";

/// The scene of the catalog, or the path of a file beside the sweep file.
fn located(sweep: &Path, scene: &str) -> String {
    if catalog::find(scene).is_ok() {
        return scene.to_owned();
    }
    sweep.parent().unwrap_or(Path::new("")).join(scene).display().to_string()
}

/// Line and column, from 1, of a byte of the text.
fn position(text: &str, byte: usize) -> (usize, usize) {
    let before = text.get(..byte).unwrap_or(text);
    let line = before.rfind('\n').map_or(0, |at| at + 1);
    (before.matches('\n').count() + 1, before[line..].chars().count() + 1)
}
