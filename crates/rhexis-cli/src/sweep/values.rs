//! Values of a parameter: lists, ranges and random numbers, as text of a scene file.

use rhexis::internal::{Random, fingerprint};
use rhexis::math::elementary;
use std::f64::consts::TAU;
use toml::de::{DeTable, DeValue};

/// The most values of one range.
const MOST: u64 = 1_000_000;

/// A value with the place of its text.
pub(super) type Value<'i> = toml::Spanned<DeValue<'i>>;

/// Where random values come from.
#[derive(Clone, Debug)]
pub(super) enum Distribution {
    /// Between two numbers, all alike.
    Uniform([f64; 2]),
    /// Between two numbers above zero, their logarithms all alike.
    LogUniform([f64; 2]),
    /// Mean and standard deviation.
    Normal([f64; 2]),
    /// Whole numbers from one to another, both included.
    Integer([i64; 2]),
    /// One of a list.
    Choice(Vec<String>),
}

const RANGE: &str = "give a list `[1, 2, 5]` or a range `{ from = 1, to = 5, count = 3 }`, `{ from = 1, to = 5, step = 2 }`, \
                     with `scale = \"log\"` for equal ratios";
const RANDOM: &str = "give one of `{ uniform = [low, high] }`, `{ log_uniform = [low, high] }`, `{ normal = [mean, deviation] }`, \
                      `{ integer = [first, last] }`, `{ choice = [a, b] }`";

/// What is wrong with a value, and how to mend it.
pub(super) type Fault = (String, &'static str);

/// The values of a list or a range, each as text of a scene file.
///
/// # Errors
/// For what is neither, an empty one, and ends that do not go together.
pub(super) fn listed(value: &Value<'_>, text: &str) -> Result<Vec<String>, Fault> {
    let values = match value.get_ref() {
        DeValue::Array(entries) => entries.iter().map(|entry| written(entry, text)).collect(),
        DeValue::Table(table) => range(table, text)?,
        _ => return Err(("one value alone does not vary".to_owned(), RANGE)),
    };
    if values.is_empty() { Err(("the list is empty".to_owned(), RANGE)) } else { Ok(values) }
}

/// The text of a value as it stands in the file.
pub(super) fn written(value: &Value<'_>, text: &str) -> String {
    text.get(value.span()).unwrap_or_default().to_owned()
}

fn range(table: &DeTable<'_>, text: &str) -> Result<Vec<String>, Fault> {
    let known = ["from", "to", "count", "step", "scale"];
    if let Some(key) = table.keys().find(|key| !known.contains(&key.get_ref().as_ref())) {
        return Err((format!("a range has no `{}`", key.get_ref()), RANGE));
    }
    let word = |key: &str| table.get(key).map(|value| written(value, text));
    let (Some(from), Some(to)) = (word("from"), word("to")) else {
        return Err(("a range has `from` and `to`".to_owned(), RANGE));
    };
    let is_log = match word("scale").as_deref() {
        None | Some("\"linear\"" | "'linear'") => false,
        Some("\"log\"" | "'log'") => true,
        Some(other) => return Err((format!("the scale {other} is neither \"linear\" nor \"log\""), RANGE)),
    };
    match (word("count"), word("step")) {
        (Some(count), None) => counted([&from, &to], &count, is_log),
        (None, Some(step)) if !is_log => stepped([&from, &to], &step),
        _ => Err(("a range has either a `count` or a `step`; of equal ratios a `count`".to_owned(), RANGE)),
    }
}

fn counted([from, to]: [&str; 2], count: &str, is_log: bool) -> Result<Vec<String>, Fault> {
    let count = whole(count).filter(|count| (1..=MOST as i64).contains(count));
    let count = count.ok_or((format!("the count is not a whole number from 1 to {MOST}"), RANGE))?;
    if let (Some(from), Some(to), false) = (whole(from), whole(to), is_log) {
        let span = i128::from(to) - i128::from(from);
        let gaps = i128::from(count - 1).max(1);
        if span % gaps == 0 {
            return Ok((0..i128::from(count)).map(|i| (i128::from(from) + span / gaps * i).to_string()).collect());
        }
    }
    let [from, to] = [number(from)?, number(to)?];
    if is_log && !(from > 0.0 && to > 0.0) {
        return Err(("a range of equal ratios has ends above zero".to_owned(), RANGE));
    }
    let last = count - 1;
    let at = |i: i64| match i {
        0 => from,
        i if i == last => to,
        i if is_log => from * elementary::pow(to / from, i as f64 / last as f64),
        i => from + (to - from) * (i as f64 / last as f64),
    };
    Ok((0..count).map(|i| plain(at(i), 12)).collect())
}

fn stepped([from, to]: [&str; 2], step: &str) -> Result<Vec<String>, Fault> {
    let [a, b, gap] = [number(from)?, number(to)?, number(step)?];
    // The relative 1e-9 keeps an end that is a multiple of the step from being lost by rounding.
    let gaps = ((b - a) / gap * (1.0 + 1e-9)).floor();
    if !(gaps >= 0.0 && gaps < MOST as f64) {
        return Err((format!("steps of {step} do not lead from {from} to {to} in at most {MOST} values"), RANGE));
    }
    let values = 0..=gaps as i64;
    Ok(match (whole(from), whole(step)) {
        (Some(from), Some(step)) => values.map(|i| (from + step * i).to_string()).collect(),
        _ => values.map(|i| plain(a + gap * i as f64, 12)).collect(),
    })
}

impl Distribution {
    /// Reads `{ uniform = [1, 2] }` and the like.
    ///
    /// # Errors
    /// For what is none, and for ends that do not go together.
    pub(super) fn read(value: &Value<'_>, text: &str) -> Result<Self, Fault> {
        let table = match value.get_ref() {
            DeValue::Table(table) if table.len() == 1 => table,
            _ => return Err(("this is no distribution".to_owned(), RANDOM)),
        };
        let Some((kind, value)) = table.iter().next() else {
            return Err(("this is no distribution".to_owned(), RANDOM));
        };
        let DeValue::Array(entries) = value.get_ref() else {
            return Err((format!("`{}` has a list of numbers", kind.get_ref()), RANDOM));
        };
        let entries: Vec<String> = entries.iter().map(|entry| written(entry, text)).collect();
        if kind.get_ref() == "choice" {
            return match entries.is_empty() {
                true => Err(("the choice is empty".to_owned(), RANDOM)),
                false => Ok(Self::Choice(entries)),
            };
        }
        let [a, b] = entries.as_slice() else {
            return Err((format!("`{}` has two numbers", kind.get_ref()), RANDOM));
        };
        let found = match (kind.get_ref().as_ref(), number(a)?, number(b)?) {
            ("uniform", low, high) if low < high => Self::Uniform([low, high]),
            ("log_uniform", low, high) if 0.0 < low && low < high => Self::LogUniform([low, high]),
            ("normal", mean, deviation) if deviation > 0.0 => Self::Normal([mean, deviation]),
            ("integer", ..) => match (whole(a), whole(b)) {
                (Some(first), Some(last)) if first < last => Self::Integer([first, last]),
                _ => {
                    return Err((
                        format!("`integer` has two whole numbers, the smaller first, not {a} and {b}"),
                        RANDOM,
                    ));
                }
            },
            ("uniform" | "log_uniform" | "normal", ..) => {
                return Err((format!("{a} and {b} are no numbers of `{}`", kind.get_ref()), RANDOM));
            }
            (other, ..) => return Err((format!("there is no distribution `{other}`"), RANDOM)),
        };
        Ok(found)
    }

    /// The value of a sample as text of a scene file. It depends on seed, number and keys alone: other parameters do not change it.
    pub(super) fn draw(&self, seed: u64, sample: u64, keys: &str) -> String {
        let mut random = Random::new(fingerprint(format!("{seed}/{sample}/{keys}").as_bytes()));
        let unit = random.unit();
        match self {
            Self::Uniform([low, high]) => plain(low + (high - low) * unit, 6),
            Self::LogUniform([low, high]) => plain(low * elementary::pow(high / low, unit), 6),
            Self::Normal([mean, deviation]) => {
                // Box and Muller 1958; 1 − unit is never zero.
                let length = (-2.0 * elementary::ln(1.0 - unit)).sqrt();
                plain(mean + deviation * length * elementary::cos(TAU * random.unit()), 6)
            }
            Self::Integer([first, last]) => {
                let count = (i128::from(*last) - i128::from(*first) + 1) as f64;
                (i128::from(*first) + (count * unit) as i128).min(i128::from(*last)).to_string()
            }
            Self::Choice(entries) => entries[((entries.len() as f64 * unit) as usize).min(entries.len() - 1)].clone(),
        }
    }
}

/// A number of so many significant digits, written with a point or an exponent so that it is no whole number.
fn plain(value: f64, digits: usize) -> String {
    let rounded = format!("{value:.*e}", digits - 1).parse().unwrap_or(value);
    format!("{rounded:?}")
}

fn whole(text: &str) -> Option<i64> {
    text.replace('_', "").parse().ok()
}

/// A finite number as a scene file writes it.
pub(super) fn number(text: &str) -> Result<f64, Fault> {
    let value = text.replace('_', "").parse().ok().filter(|value: &f64| value.is_finite());
    value.ok_or((format!("{text} is not a number"), "give ordinary numbers"))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn values(text: &str) -> Result<Vec<String>, String> {
        let whole = format!("v = {text}");
        let table = DeTable::parse(&whole).unwrap();
        listed(table.get_ref().get("v").unwrap(), &whole).map_err(|(what, _)| what)
    }

    fn drawn(text: &str, count: u64) -> Result<Vec<String>, String> {
        let whole = format!("v = {text}");
        let table = DeTable::parse(&whole).unwrap();
        let read = Distribution::read(table.get_ref().get("v").unwrap(), &whole).map_err(|(what, _)| what)?;
        Ok((0..count).map(|sample| read.draw(1, sample, "k")).collect())
    }

    #[test]
    fn ranges_keep_their_ends_and_whole_numbers() {
        assert_eq!(values("[1, 2.50, \"a\"]").unwrap(), ["1", "2.50", "\"a\""]);
        assert_eq!(values("{ from = 0, to = 90, count = 4 }").unwrap(), ["0", "30", "60", "90"]);
        assert_eq!(values("{ from = 0, to = 1, count = 3 }").unwrap(), ["0.0", "0.5", "1.0"]);
        assert_eq!(values("{ from = 0.1, to = 0.3, step = 0.1 }").unwrap(), ["0.1", "0.2", "0.3"]);
        assert_eq!(values("{ from = 10, to = 1, step = -4 }").unwrap(), ["10", "6", "2"]);
        assert_eq!(values("{ from = 0.01, to = 1, count = 3, scale = \"log\" }").unwrap(), ["0.01", "0.1", "1.0"]);
        assert_eq!(values("{ from = 3, to = 5, count = 1 }").unwrap(), ["3"]);
    }

    #[test]
    fn what_is_no_range_is_said() {
        for (text, word) in [
            ("3", "one value alone"),
            ("[]", "empty"),
            ("{ from = 1, to = 2 }", "either a `count` or a `step`"),
            ("{ from = 1, to = 2, step = -1 }", "do not lead"),
            ("{ from = 1, to = 2, count = 0 }", "the count"),
            ("{ from = 0, to = 2, count = 3, scale = \"log\" }", "above zero"),
            ("{ from = 1, till = 2 }", "`till`"),
            ("{ from = \"a\", to = 2, count = 2 }", "not a number"),
        ] {
            let error = values(text).unwrap_err();
            assert!(error.contains(word), "{text}: {error}");
        }
    }

    #[test]
    fn samples_stay_in_their_ranges_and_follow_the_seed() {
        let number = |text: &String| text.parse::<f64>().unwrap();
        let uniform = drawn("{ uniform = [2, 3] }", 1000).unwrap();
        assert!(uniform.iter().map(number).all(|x| (2.0..=3.0).contains(&x)));
        let mean = uniform.iter().map(number).sum::<f64>() / 1000.0;
        // Six standard errors of the mean of 1000 uniform numbers: 6·√(1/12/1000).
        assert!((mean - 2.5).abs() < 0.055, "{mean}");
        let normal: Vec<f64> = drawn("{ normal = [5, 2] }", 1000).unwrap().iter().map(number).collect();
        let mean = normal.iter().sum::<f64>() / 1000.0;
        // Six standard errors of the mean: 6·2/√1000.
        assert!((mean - 5.0).abs() < 0.38, "{mean}");
        let integers = drawn("{ integer = [1, 3] }", 60).unwrap();
        assert!(["1", "2", "3"].iter().all(|n| integers.iter().any(|i| i == n)), "{integers:?}");
        assert!(drawn("{ choice = [\"a\", 4] }", 20).unwrap().iter().all(|v| v == "\"a\"" || v == "4"));
        assert_eq!(uniform, drawn("{ uniform = [2, 3] }", 1000).unwrap());
        for bad in
            ["{ uniform = [3, 2] }", "{ uniform = [1] }", "{ even = [1, 2] }", "[1, 2]", "{ log_uniform = [0, 1] }"]
        {
            drawn(bad, 1).unwrap_err();
        }
    }
}
