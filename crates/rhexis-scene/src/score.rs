//! A score of 100 for the course of a tear, by contrasting groups; its thresholds are data with their sources.
//!
//! A scoring is a TOML file: that of a capsulorhexis is in the crate, `scoring = "capsulorhexis"` in `[output]` of a scene, and a copy of it with other
//! numbers is named by its path. Each measure gives 0 points at the mean of novices and 100 at that of experts, on a straight line between them.
//! A measure without a value gives none. The total is their mean by weights, and zero where the tear has run out or the flap has torn off.
//! A tear that has closed passes from a given total on, or from where the normal densities of the groups' totals cross
//! (contrasting groups: Livingston, Zieky 1982, Passing Scores).
//!
//! ```
//! use rhexis_scene::{Scene, course::CourseReport, measures::TearCourse};
//! let instance = Scene::named("capsulorhexis")?.instantiate()?;
//! let scoring = instance.scoring.as_ref().ok_or("the scene has no scoring")?;
//! let course = TearCourse::new(instance.simulation.world(), instance.bodies[0], 0.0).ok_or("the body has no rim")?;
//! let score = scoring.score(&CourseReport::of(&course.with_limits(scoring.limits())));
//! assert!(!score.is_passed && score.total < 80.0);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

use super::course::CourseReport;
use super::error::{Fault, SceneError, explain, not_negative, position, positive};
use super::files::Files;
use super::measures::Limits;
use rhexis::math::elementary;
use serde::{Deserialize, Serialize};
use std::path::Path;
use toml::Spanned;

/// The scoring in the crate, by its name.
const CAPSULORHEXIS: (&str, &str) = ("capsulorhexis", include_str!("score/capsulorhexis.toml"));

/// Largest scoring file that is read \[bytes\].
const MOST_BYTES: u64 = 1 << 20;

/// Points of a perfect measure, and of a perfect course.
const FULL: f64 = 100.0;

/// Largest number of a scoring.
const LARGEST: f64 = 1e9;

/// Halvings of the interval between two means in which their densities cross: down to rounding.
const HALVINGS: u32 = 60;

/// How a course is scored.
#[derive(Clone, Debug, PartialEq)]
pub struct Scoring {
    limits: Limits,
    /// Least total that passes.
    pass: f64,
    measures: Vec<Scored>,
}

/// Score of a course.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Score {
    /// From 0 to 100.
    pub total: f64,
    /// Least total that passes.
    pub pass: f64,
    /// Whether the tear has closed with that total.
    pub is_passed: bool,
    /// Cause of a total of zero; absent for a tear that has closed or goes on.
    pub failure: Option<&'static str>,
    /// One row per measure, in the order of the file.
    pub measures: Vec<MeasureScore>,
}

/// Points of one measure.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct MeasureScore {
    /// Key of the measure in `course`.
    pub key: Measure,
    /// Value of the measure; absent where the course has none.
    pub value: Option<f64>,
    /// From 0 to 100; zero without a value.
    pub points: f64,
    /// Part in the total, beside those of the others.
    pub weight: f64,
    /// Cause of a missing value; absent where there is one.
    pub missing: Option<&'static str>,
}

/// Measure of a course, by its key in `report.json`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, Serialize)]
pub enum Measure {
    /// Angle that cuts and tips have passed \[°\].
    #[serde(rename = "completion_deg")]
    Completion,
    /// Mean diameter of the opening \[mm\].
    #[serde(rename = "diameter_mm")]
    Diameter,
    /// Circularity of the opening.
    #[serde(rename = "circularity")]
    Circularity,
    /// Distance of the opening's centre from the axis \[mm\].
    #[serde(rename = "decentration_mm")]
    Decentration,
    /// Largest distance from the axis \[mm\].
    #[serde(rename = "largest_radius_mm")]
    LargestRadius,
    /// Spikes of the opening.
    #[serde(rename = "spikes")]
    Spikes,
    /// Covered part of an optic's edge.
    #[serde(rename = "optic_covered")]
    OpticCovered,
    /// Smallest overlap with an optic \[mm\].
    #[serde(rename = "optic_overlap_mm")]
    OpticOverlap,
    /// Number of grasps.
    #[serde(rename = "grasps")]
    Grasps,
    /// Time until the end \[ms\].
    #[serde(rename = "time_ms")]
    Time,
    /// Mean force \[N\].
    #[serde(rename = "force_mean_n")]
    ForceMean,
    /// Root mean square of the force \[N\].
    #[serde(rename = "force_rms_n")]
    ForceRms,
    /// Peak of the force \[N\].
    #[serde(rename = "force_peak_n")]
    ForcePeak,
    /// Force × time above the limit \[mN·s\].
    #[serde(rename = "force_time_above_mn_s")]
    ForceTimeAbove,
    /// Way of the jaws \[mm\].
    #[serde(rename = "tool_path_mm")]
    ToolPath,
    /// Tremor \[mm\].
    #[serde(rename = "tremor_mm")]
    Tremor,
    /// Largest load of the zonules \[N\].
    #[serde(rename = "zonule_load_n")]
    ZonuleLoad,
}

impl Measure {
    /// Name of the measure in words.
    pub fn name(self) -> &'static str {
        match self {
            Self::Completion => "completion",
            Self::Diameter => "diameter",
            Self::Circularity => "circularity",
            Self::Decentration => "decentration",
            Self::LargestRadius => "largest radius",
            Self::Spikes => "spikes",
            Self::OpticCovered => "optic covered",
            Self::OpticOverlap => "optic overlap",
            Self::Grasps => "grasps",
            Self::Time => "time",
            Self::ForceMean => "force mean",
            Self::ForceRms => "force rms",
            Self::ForcePeak => "force peak",
            Self::ForceTimeAbove => "force × time",
            Self::ToolPath => "tool path",
            Self::Tremor => "tremor",
            Self::ZonuleLoad => "zonule load",
        }
    }

    /// Value in a course, or the cause for which it has none.
    fn of(self, course: &CourseReport) -> Result<f64, &'static str> {
        let opened = |value: Option<f64>| value.ok_or("the tear has not closed");
        match self {
            Self::Completion => Ok(course.completion_deg),
            Self::Diameter => opened(course.diameter_mm),
            Self::Circularity => opened(course.circularity),
            Self::Decentration => opened(course.decentration_mm),
            Self::LargestRadius => Ok(course.largest_radius_mm),
            Self::Spikes => opened(course.spikes.map(f64::from)),
            Self::OpticCovered => opened(course.optic_covered),
            Self::OpticOverlap => opened(course.optic_overlap_mm),
            Self::Grasps => Ok(f64::from(course.grasps)),
            Self::Time => Ok(course.time_ms),
            Self::ForceMean => Ok(course.force_mean_n),
            Self::ForceRms => Ok(course.force_rms_n),
            Self::ForcePeak => Ok(course.force_peak_n),
            Self::ForceTimeAbove => Ok(course.force_time_above_mn_s),
            Self::ToolPath => Ok(course.tool_path_mm),
            Self::Tremor => course.tremor_mm.ok_or("no grasp has lasted for a second"),
            Self::ZonuleLoad => course.zonule_load_n.ok_or("the body has no springs to ground"),
        }
    }
}

/// A measure with the means of the groups.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Scored {
    measure: Measure,
    target: Option<f64>,
    novice: f64,
    expert: f64,
    weight: f64,
}

impl Scored {
    fn points(&self, value: f64) -> f64 {
        let judged = self.target.map_or(value, |target| (value - target).abs());
        FULL * ((judged - self.novice) / (self.expert - self.novice)).clamp(0.0, 1.0)
    }
}

impl Scoring {
    /// The scoring of this name in the crate, or of the file at this path; `key` is that of the scene.
    pub(super) fn open(name_or_path: &Path, files: &Files, key: &str) -> Result<Self, Fault> {
        let refused = |error: SceneError| {
            let hint = error.hint.clone();
            Fault::new(key, SceneError { hint: String::new(), ..error }, hint)
        };
        if Self::is_named(name_or_path) {
            return Self::parse(CAPSULORHEXIS.1, "capsulorhexis.toml (scoring)").map_err(refused);
        }
        let path = files.path(name_or_path).display().to_string();
        let unread = |error: &dyn std::fmt::Display| {
            let hint =
                "give \"capsulorhexis\", or the path of a scoring; a relative path begins at the scene file's folder";
            Fault::new(key, format!("cannot read {path}: {error}"), hint)
        };
        let bytes = files.read(name_or_path, MOST_BYTES).map_err(|error| unread(&error))?;
        let text = std::str::from_utf8(&bytes).map_err(|error| unread(&error))?;
        Self::parse(text, &path).map_err(refused)
    }

    /// Whether this is the name of a scoring in the crate and no path.
    pub(super) fn is_named(name_or_path: &Path) -> bool {
        name_or_path == Path::new(CAPSULORHEXIS.0)
    }

    /// A scoring from text; `origin` names it in errors.
    ///
    /// # Errors
    /// For text that is not TOML, keys that a scoring does not have, and numbers that part no groups.
    pub fn parse(text: &str, origin: &str) -> Result<Self, SceneError> {
        let text = Text { text, origin };
        let ScoringFile { limits, pass, measures } = toml::from_str(text.text).map_err(|error| {
            let (what, mut hint) = explain(error.message());
            if error.message().starts_with("missing field") {
                hint = "add it, as in the scoring of a capsulorhexis (docs/score.md)".to_owned();
            }
            text.at(error.span().map_or(0, |span| span.start), Fault::new("", what, hint))
        })?;
        let force = text.judged(limits.force_n, |limit| limit.judge("limits.force_n", "N"))?;
        let optic_diameter =
            text.judged(limits.optic_diameter_mm, |limit| limit.judge("limits.optic_diameter_mm", "mm"))?;
        let pass = text.judged(pass, PassSpec::judge)?;
        let mut scored: Vec<Scored> = Vec::new();
        for (i, measure) in measures.into_iter().enumerate() {
            let row = text.judged(measure, |measure| measure.judge(&format!("measures.{i}"), &scored))?;
            scored.push(row);
        }
        if scored.is_empty() {
            return Err(text.at(0, Fault::new("measures", "there is no measure", "add a [[measures]] table")));
        }
        Ok(Self { limits: Limits { force, optic_diameter }, pass, measures: scored })
    }

    /// Limits that the measures of a course are to be taken by.
    pub fn limits(&self) -> Limits {
        self.limits
    }

    /// The score of a course as it stands.
    pub fn score(&self, course: &CourseReport) -> Score {
        let row = |scored: &Scored| {
            let value = scored.measure.of(course);
            MeasureScore {
                key: scored.measure,
                value: value.ok(),
                points: value.map_or(0.0, |value| scored.points(value)),
                weight: scored.weight,
                missing: value.err(),
            }
        };
        let measures: Vec<MeasureScore> = self.measures.iter().map(row).collect();
        let failure = match course.outcome {
            "ran_out" => Some("the tear has run out to the rim"),
            "torn_off" => Some("the flap has torn off"),
            _ => None,
        };
        let weights: f64 = measures.iter().map(|row| row.weight).sum();
        let mean = measures.iter().map(|row| row.weight * row.points).sum::<f64>() / weights;
        let total = if failure.is_some() { 0.0 } else { mean };
        Score { total, pass: self.pass, is_passed: course.outcome == "closed" && total >= self.pass, failure, measures }
    }
}

/// The text of a scoring, and its name in errors.
struct Text<'a> {
    text: &'a str,
    origin: &'a str,
}

impl Text<'_> {
    /// The error for a fault at a byte of the text.
    fn at(&self, byte: usize, fault: Fault) -> SceneError {
        let Fault { key, what, hint } = fault;
        SceneError { origin: self.origin.to_owned(), position: Some(position(self.text, byte)), key, what, hint }
    }

    fn judged<T, R>(&self, spec: Spanned<T>, judge: impl FnOnce(T) -> Result<R, Fault>) -> Result<R, SceneError> {
        let start = spec.span().start;
        judge(spec.into_inner()).map_err(|fault| self.at(start, fault))
    }
}

/// The file.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct ScoringFile {
    limits: LimitsSpec,
    pass: Spanned<PassSpec>,
    measures: Vec<Spanned<MeasureSpec>>,
}

/// `[limits]`.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct LimitsSpec {
    force_n: Spanned<LimitSpec>,
    optic_diameter_mm: Spanned<LimitSpec>,
}

/// A limit.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct LimitSpec {
    value: f64,
    source: String,
}

/// `[pass]`: a total, or the totals of the groups.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct PassSpec {
    total: Option<f64>,
    novice: Option<GroupSpec>,
    expert: Option<GroupSpec>,
    source: String,
}

/// Mean and standard deviation of a group.
#[derive(Clone, Copy, Deserialize)]
#[serde(deny_unknown_fields)]
struct GroupSpec {
    mean: f64,
    sd: f64,
}

/// One of `[[measures]]`.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct MeasureSpec {
    key: Measure,
    target: Option<f64>,
    novice: f64,
    expert: f64,
    weight: f64,
    source: String,
}

impl LimitSpec {
    fn judge(self, key: &str, unit: &str) -> Result<f64, Fault> {
        has_source(key, &self.source)?;
        positive(format!("{key}.value"), number(format!("{key}.value"), self.value)?, unit)
    }
}

impl PassSpec {
    /// The least total that passes.
    fn judge(self) -> Result<f64, Fault> {
        has_source("pass", &self.source)?;
        match (self.total, self.novice, self.expert) {
            (Some(total), None, None) if (0.0..=FULL).contains(&total) => Ok(total),
            (Some(total), None, None) => Err(Fault::new("pass.total", format!("{total} is no total"), "give 0 to 100")),
            (None, Some(novice), Some(expert)) => {
                for (name, group) in [("novice", novice), ("expert", expert)] {
                    number(format!("pass.{name}.mean"), group.mean)?;
                    positive(format!("pass.{name}.sd"), number(format!("pass.{name}.sd"), group.sd)?, "")?;
                }
                let what = "the groups' densities do not cross between their means";
                let hint = "give experts the larger mean, or a `total` where the groups are not apart";
                crossing(novice, expert).ok_or_else(|| Fault::new("pass", what, hint))
            }
            _ => {
                let hint = "give either `total`, or `novice` and `expert`, each as { mean = …, sd = … }";
                Err(Fault::new("pass", "the pass mark is given twice or not at all", hint))
            }
        }
    }
}

impl MeasureSpec {
    /// The measure, after those before it in the file.
    fn judge(self, key: &str, before: &[Scored]) -> Result<Scored, Fault> {
        let Self { key: measure, target, novice, expert, weight, source } = self;
        has_source(key, &source)?;
        for (name, value) in [("target", target.unwrap_or(0.0)), ("novice", novice), ("expert", expert)] {
            number(format!("{key}.{name}"), value)?;
        }
        positive(format!("{key}.weight"), number(format!("{key}.weight"), weight)?, "")?;
        if target.is_some() {
            not_negative(format!("{key}.novice"), novice, "from the target")?;
            not_negative(format!("{key}.expert"), expert, "from the target")?;
        }
        if novice == expert {
            let what = format!("novices and experts both have {expert}, which parts no groups");
            return Err(Fault::new(format!("{key}.expert"), what, "give two values, or remove the measure"));
        }
        if before.iter().any(|scored| scored.measure == measure) {
            let what = format!("the {} is scored already", measure.name());
            return Err(Fault::new(format!("{key}.key"), what, "give each measure one table"));
        }
        Ok(Scored { measure, target, novice, expert, weight })
    }
}

/// A number of an ordinary size.
fn number(key: String, value: f64) -> Result<f64, Fault> {
    if (-LARGEST..=LARGEST).contains(&value) {
        return Ok(value);
    }
    Err(Fault::new(key, format!("{value} is out of scale"), "give an ordinary number"))
}

fn has_source(key: &str, source: &str) -> Result<(), Fault> {
    if !source.trim().is_empty() {
        return Ok(());
    }
    let hint = "name where the numbers are from, or write \"own estimate: …\"";
    Err(Fault::new(format!("{key}.source"), "the numbers have no source", hint))
}

/// Where the normal densities of two groups cross between their means; `None` where they do not.
fn crossing(novice: GroupSpec, expert: GroupSpec) -> Option<f64> {
    let exponent = |group: GroupSpec, at: f64| {
        let deviation = (at - group.mean) / group.sd;
        0.5 * deviation * deviation
    };
    let spread = elementary::ln(expert.sd / novice.sd);
    let is_novice = |at: f64| spread + exponent(expert, at) > exponent(novice, at);
    let (mut below, mut above) = (novice.mean, expert.mean);
    if !(below < above && is_novice(below) && !is_novice(above)) {
        return None;
    }
    for _ in 0..HALVINGS {
        let middle = below.midpoint(above);
        if is_novice(middle) {
            below = middle;
        } else {
            above = middle;
        }
    }
    Some(above)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Scene;
    use crate::measures::TearCourse;

    fn bundled() -> Scoring {
        Scoring::parse(CAPSULORHEXIS.1, "capsulorhexis").unwrap()
    }

    /// A scoring of one measure, with this pass mark.
    fn scoring(pass: &str, measure: &str) -> Result<Scoring, SceneError> {
        let limit = |name: &str, value: f64| format!("[limits.{name}]\nvalue = {value}\nsource = \"own\"\n");
        let limits = limit("force_n", 9e-3) + &limit("optic_diameter_mm", 6.0);
        let text = format!("{limits}[pass]\n{pass}\nsource = \"own\"\n[[measures]]\n{measure}\n");
        Scoring::parse(&text, "mine.toml")
    }

    const TIME: &str = "key = \"time_ms\"\nnovice = 100\nexpert = 40\nweight = 2\nsource = \"own\"";

    /// A course that has closed, with figures of experts in the bundled scoring.
    fn closed() -> CourseReport {
        let instance = Scene::named("capsulorhexis").unwrap().instantiate().unwrap();
        let course = TearCourse::new(instance.simulation.world(), instance.bodies[0], 0.0).unwrap();
        CourseReport {
            outcome: "closed",
            diameter_mm: Some(5.25),
            circularity: Some(0.95),
            decentration_mm: Some(0.1),
            spikes: Some(0),
            optic_covered: Some(1.0),
            tremor_mm: Some(0.01),
            time_ms: 30e3,
            grasps: 4,
            force_rms_n: 8e-3,
            force_peak_n: 15e-3,
            ..CourseReport::of(&course)
        }
    }

    #[test]
    fn points_are_on_a_line_from_novices_to_experts() {
        let scoring = scoring("total = 50", TIME).unwrap();
        for (time, points) in [(10.0, 100.0), (40.0, 100.0), (70.0, 50.0), (85.0, 25.0), (100.0, 0.0), (1e6, 0.0)] {
            let score = scoring.score(&CourseReport { time_ms: time, ..closed() });
            assert_eq!((score.total, score.is_passed), (points, points >= 50.0), "{time}");
        }
        let target = "key = \"diameter_mm\"\ntarget = 5\nnovice = 1\nexpert = 0\nweight = 1\nsource = \"own\"";
        let scoring = self::scoring("total = 50", target).unwrap();
        for diameter in [4.75, 5.25] {
            assert_eq!(scoring.score(&CourseReport { diameter_mm: Some(diameter), ..closed() }).total, 75.0);
        }
    }

    #[test]
    fn the_total_is_the_weighted_mean_and_a_measure_without_value_gives_nothing() {
        let grasps = "[[measures]]\nkey = \"grasps\"\nnovice = 8\nexpert = 4\nweight = 1\nsource = \"own\"";
        let two = scoring("total = 50", &format!("{TIME}\n{grasps}")).unwrap();
        let score = two.score(&CourseReport { time_ms: 70.0, grasps: 7, ..closed() });
        assert!((score.total - (2.0 * 50.0 + 25.0) / 3.0).abs() < 1e-12);
        let open = CourseReport { outcome: "unfinished", diameter_mm: None, ..closed() };
        let score = bundled().score(&open);
        let row = score.measures.iter().find(|row| row.key == Measure::Diameter).unwrap();
        assert_eq!((row.points, row.value, row.missing), (0.0, None, Some("the tear has not closed")));
        // Eleven of twelve measures are perfect, but the tear goes on.
        assert!((score.total - 1100.0 / 12.0).abs() < 1e-12 && !score.is_passed && score.failure.is_none());
    }

    #[test]
    fn experts_have_all_points_and_a_tear_that_runs_out_none() {
        let score = bundled().score(&closed());
        assert!(score.total == 100.0 && score.is_passed, "{score:?}");
        for outcome in ["ran_out", "torn_off"] {
            let score = bundled().score(&CourseReport { outcome, ..closed() });
            assert!(score.total == 0.0 && !score.is_passed && score.failure.is_some());
        }
    }

    #[test]
    fn contrasting_groups_part_where_their_densities_cross() {
        let group = |mean, sd| GroupSpec { mean, sd };
        // Alike in spread, in the middle.
        assert!((crossing(group(40.0, 10.0), group(80.0, 10.0)).unwrap() - 60.0).abs() < 1e-12);
        // Else at the root of the quadratic between the means.
        let (novice, expert) = (group(47.0, 32.0), group(89.0, 23.0));
        let found = crossing(novice, expert).unwrap();
        let [a, b] = [novice, expert].map(|group| 1.0 / (group.sd * group.sd));
        let (linear, constant) = (
            a * novice.mean - b * expert.mean,
            0.5 * (a * novice.mean.powi(2) - b * expert.mean.powi(2)) - (expert.sd / novice.sd).ln(),
        );
        // Both densities there: ½(a − b)x² − linear·x + constant = 0.
        assert!((0.5 * (a - b) * found * found - linear * found + constant).abs() < 1e-12, "{found}");
        assert!((47.0..89.0).contains(&found));
        assert!(crossing(expert, novice).is_none());
        let groups = "novice = { mean = 40, sd = 10 }\nexpert = { mean = 80, sd = 10 }";
        assert!((scoring(groups, TIME).unwrap().pass - 60.0).abs() < 1e-12);
    }

    #[test]
    fn the_limits_are_those_of_a_course_without_scoring() {
        assert_eq!(bundled().limits(), Limits::default());
    }

    #[test]
    fn every_measure_of_the_bundled_scoring_has_a_value_in_a_closed_course() {
        for row in bundled().score(&closed()).measures {
            assert!(row.value.is_some(), "{row:?}");
        }
        let unknown = scoring("total = 50", &TIME.replace("time_ms", "time")).unwrap_err();
        assert_eq!(unknown.what, "unknown value `time`");
        assert!(unknown.hint.starts_with("did you mean `time_ms`?"), "{unknown}");
    }

    #[test]
    fn errors_name_key_place_and_remedy() {
        let refused = |pass: &str, measure: &str| scoring(pass, measure).unwrap_err().to_string();
        let pass = "total = 80";
        for (error, parts) in [
            (refused("total = 101", TIME), ["mine.toml:7:1: pass.total: 101 is no total", "give 0 to 100"]),
            (refused("", TIME), ["pass: the pass mark is given twice or not at all", "either `total`"]),
            (
                refused("novice = { mean = 80, sd = 1 }\nexpert = { mean = 40, sd = 1 }", TIME),
                ["pass: the groups' densities do not cross", "experts the larger mean"],
            ),
            (refused(pass, &TIME.replace("40", "100")), ["measures.0.expert: novices and experts both", "two values"]),
            (refused(pass, &TIME.replace("= 2", "= 0")), ["measures.0.weight: 0 is not above zero", "above zero"]),
            (refused(pass, &TIME.replace("100", "nan")), ["measures.0.novice: NaN is out of scale", "ordinary"]),
            (
                refused(pass, &TIME.replace("\"own\"", "\" \"")),
                ["measures.0.source: the numbers have no source", "own estimate"],
            ),
            (refused(pass, &TIME.replace("weight", "wieght")), ["unknown key `wieght`", "did you mean `weight`?"]),
            (refused(pass, &TIME.replace("weight = 2", "")), ["the key `weight` is missing", "docs/score.md"]),
            (
                refused(pass, &format!("{TIME}\n[[measures]]\n{TIME}")),
                ["measures.1.key: the time is scored already", "one table"],
            ),
        ] {
            assert!(error.starts_with("mine.toml:"), "{error}");
            parts.iter().for_each(|part| assert!(error.contains(part), "{error}\n{part}"));
        }
    }
}
