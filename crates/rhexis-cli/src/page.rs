//! `rhexis report`: a run as one page of HTML that needs no other file.

use crate::output::file;
use crate::plot::{of_run, svg};
use crate::say::say;
use crate::{Stop, kept, outputs};
use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use clap::Args;
use rhexis::internal::source::Sources;
use serde_json::Value;
use std::fmt::Write;
use std::path::{Path, PathBuf};

#[derive(Args)]
pub(super) struct ReportArgs {
    /// Output directory of `rhexis run`.
    #[arg(value_name = "RUN_DIR")]
    run: PathBuf,
    /// The page [default: `report.html` in the run's directory].
    #[arg(long, value_name = "FILE")]
    out: Option<PathBuf>,
}

pub(super) const EXAMPLES: &str = "\
Examples:
  rhexis report out/capsulorhexis
  rhexis report out/fig2-tear --out fig2.html

One page: summary, notes, pictures, plots, figures of report.json and the first events. It needs no other file and no network.";

/// Events that the page lists.
const MOST_EVENTS: usize = 200;

const STYLE: &str = "body{font:16px/1.5 system-ui,sans-serif;max-width:62rem;margin:2rem auto;padding:0 1rem;color:#1b1b1f;background:#fff}\
h1{margin-bottom:0}h2{margin-top:2.2rem;border-bottom:1px solid #ccc}table{border-collapse:collapse;font-size:.9rem}\
td,th{text-align:left;padding:.15rem .8rem .15rem 0;vertical-align:top}tr:nth-child(even){background:#f4f4f6}\
img,svg{max-width:100%;height:auto}.notes{background:#fff4d6;padding:.6rem 1rem;border-left:4px solid #a86a00}\
.pictures{display:grid;grid-template-columns:repeat(auto-fill,minmax(24rem,1fr));gap:1rem}figure{margin:0}\
summary{cursor:pointer}code{font-size:.9em}";

/// The first bytes of a page.
const HEAD: &str = "<!doctype html>\n<html lang=\"en\"><head><meta charset=\"utf-8\">";

/// Writes the page of a run.
pub(super) fn page(args: &ReportArgs) -> Result<(), Stop> {
    let out = args.out.clone().unwrap_or_else(|| args.run.join("report.html"));
    outputs::spare(&out, HEAD.as_bytes(), "page")?;
    file::replace(&out, html(&args.run)?.as_bytes())?;
    say(&format!("written to {}", out.display()))
}

fn html(run: &Path) -> Result<String, Stop> {
    let path = run.join("report.json");
    let failed = |what: &dyn std::fmt::Display| {
        Stop::Failed(format!("{}: {what}; give the output directory of `rhexis run`", path.display()))
    };
    let sources = Sources::new(kept::MOST_BYTES);
    let content = sources.read(&path, kept::MOST_BYTES).map_err(|error| failed(&error))?;
    let report: Value = serde_json::from_slice(&content).map_err(|error| failed(&error))?;
    let word = |key: &str| escaped(report[key].as_str().unwrap_or_default());
    let (scene, about) = (word("scene"), word("about"));
    let mut page = format!(
        "{HEAD}<meta name=\"viewport\" content=\"width=device-width\">\
         <title>{scene}</title><style>{STYLE}</style></head><body>\n<h1>{scene}</h1><p>{about}</p>\n"
    );
    summary(&mut page, &report);
    notes(&mut page, &report);
    pictures(&mut page, run, &sources)?;
    page.push_str("<h2>Curves</h2>\n");
    for panel in of_run(run)? {
        let drawn = svg(&panel).map_err(Stop::Failed)?;
        let _ = writeln!(page, "<figure>{drawn}<figcaption>{}</figcaption></figure>", escaped(&panel.axes[1]));
    }
    for body in report["bodies"].as_array().into_iter().flatten() {
        let _ = writeln!(page, "<h2>Body {}</h2>", escaped(body["name"].as_str().unwrap_or_default()));
        figures(&mut page, body);
    }
    let rest = [("Cuts", "cuts"), ("Solver", "solver"), ("Events, counted", "events"), ("Systems", "systems")];
    for (title, key) in rest {
        let _ = writeln!(page, "<details><summary>{title}</summary>");
        figures(&mut page, &report[key]);
        page.push_str("</details>\n");
    }
    events(&mut page, run, &sources)?;
    let _ = writeln!(page, "<p><small>{}</small></p>\n</body></html>", word("program"));
    Ok(page)
}

fn summary(page: &mut String, report: &Value) {
    let state = report["end"]["state"].as_str().unwrap_or_default().replace('_', " ");
    let number = |key: &str| report[key].as_f64().unwrap_or(f64::NAN);
    let _ = writeln!(
        page,
        "<table><tr><th>end</th><td>{}</td></tr><tr><th>steps</th><td>{} of {} of {} ms, {}</td></tr>\
         <tr><th>simulated</th><td>{} ms in {:.2} s of stepping ({:.2} × real time)</td></tr></table>",
        escaped(&state),
        number("steps"),
        number("steps_planned"),
        number("dt_ms"),
        escaped(report["mode"].as_str().unwrap_or_default()),
        number("simulated_ms"),
        number("stepping_s"),
        number("real_time_factor"),
    );
    let overrides: Vec<&str> = report["overrides"].as_array().into_iter().flatten().filter_map(Value::as_str).collect();
    if !overrides.is_empty() {
        let _ = writeln!(page, "<p>Changed: <code>{}</code></p>", escaped(&overrides.join(" ")));
    }
}

fn notes(page: &mut String, report: &Value) {
    let notes: Vec<&str> = report["caveats"].as_array().into_iter().flatten().filter_map(Value::as_str).collect();
    if !notes.is_empty() {
        page.push_str("<h2>Notes</h2><ul class=\"notes\">");
        notes.iter().for_each(|note| _ = write!(page, "<li>{}</li>", escaped(note)));
        page.push_str("</ul>\n");
    }
}

/// The pictures of the run, in their order, inside the page.
fn pictures(page: &mut String, run: &Path, sources: &Sources) -> Result<(), Stop> {
    let failed = |path: &Path, error: std::io::Error| {
        Stop::Failed(format!("{}: {error}; take it out of the directory", path.display()))
    };
    let entries = std::fs::read_dir(run).map_err(|error| failed(run, error))?;
    let is_picture = |name: &str| name.starts_with("picture-") && name.ends_with(".png");
    let names = entries.filter_map(|entry| entry.ok()?.file_name().into_string().ok());
    let mut names: Vec<String> = names.filter(|name| is_picture(name)).collect();
    names.sort();
    if names.is_empty() {
        return Ok(());
    }
    page.push_str("<h2>Pictures</h2>\n<div class=\"pictures\">\n");
    for name in names {
        let path = run.join(&name);
        let bytes = sources.read(&path, kept::MOST_BYTES).map_err(|error| failed(&path, error))?;
        let step = name.rsplit('-').next().and_then(|end| end.strip_suffix(".png")).unwrap_or_default();
        let step = step.trim_start_matches('0');
        let step = if step.is_empty() { "0".to_owned() } else { escaped(step) };
        let data = STANDARD.encode(bytes.as_slice());
        let _ = writeln!(
            page,
            "<figure><img alt=\"state after step {step}\" src=\"data:image/png;base64,{data}\"><figcaption>step {step}</figcaption></figure>"
        );
    }
    page.push_str("</div>\n");
    Ok(())
}

/// A value of the report as nested tables; what is not there is left out.
fn figures(page: &mut String, value: &Value) {
    match value {
        Value::Object(fields) => {
            page.push_str("<table>");
            for (key, value) in fields.iter().filter(|(_, value)| !is_empty(value)) {
                let _ = write!(page, "<tr><th>{}</th><td>", escaped(&key.replace('_', " ")));
                figures(page, value);
                page.push_str("</td></tr>");
            }
            page.push_str("</table>\n");
        }
        Value::Array(values) if values.iter().all(|value| !value.is_object()) => {
            let words: Vec<String> = values.iter().map(plain).collect();
            page.push_str(&escaped(&words.join(", ")));
        }
        Value::Array(values) => values.iter().for_each(|value| figures(page, value)),
        value => page.push_str(&escaped(&plain(value))),
    }
}

fn is_empty(value: &Value) -> bool {
    match value {
        Value::Null => true,
        Value::String(text) => text.is_empty(),
        Value::Array(values) => values.is_empty(),
        Value::Object(fields) => fields.values().all(is_empty),
        _ => false,
    }
}

/// A number with at most six digits, anything else as it is.
fn plain(value: &Value) -> String {
    match value {
        Value::String(text) => text.clone(),
        Value::Number(number) if !number.is_i64() && !number.is_u64() => {
            let value = number.as_f64().unwrap_or(f64::NAN);
            let digits = format!("{value:.5e}").parse::<f64>().unwrap_or(value);
            if digits == 0.0 || (1e-4..1e7).contains(&digits.abs()) {
                format!("{digits}")
            } else {
                format!("{digits:e}")
            }
        }
        value => value.to_string(),
    }
}

/// The first events, one per row.
fn events(page: &mut String, run: &Path, sources: &Sources) -> Result<(), Stop> {
    let path = run.join("events.jsonl");
    let content = match sources.read(&path, kept::MOST_BYTES) {
        Ok(content) => content,
        Err(error) if error.kind() == std::io::ErrorKind::NotFound => return Ok(()),
        Err(error) => {
            return Err(Stop::Failed(format!("{}: {error}; take it out of the directory", path.display())));
        }
    };
    let text = String::from_utf8_lossy(&content);
    let all = text.lines().count();
    let _ = writeln!(page, "<details><summary>Events: {} of {all}</summary><table>", all.min(MOST_EVENTS));
    page.push_str("<tr><th>ms</th><th>body</th><th>what</th><th>figures</th></tr>\n");
    for event in text.lines().take(MOST_EVENTS).filter_map(|line| serde_json::from_str::<Value>(line).ok()) {
        let Value::Object(fields) = event else { continue };
        let told = |key: &str| fields.get(key).map(plain).unwrap_or_default();
        let named = |(key, value): (&String, &Value)| format!("{} {}", key.replace('_', " "), plain(value));
        let is_own = |key: &str| !["kind", "body", "time_ms", "step"].contains(&key);
        let rest: Vec<String> =
            fields.iter().filter(|(key, value)| is_own(key) && !is_empty(value)).map(named).collect();
        let cells = [told("time_ms"), told("body"), told("kind").replace('_', " "), rest.join("; ")];
        let cells: String = cells.iter().map(|cell| format!("<td>{}</td>", escaped(cell))).collect();
        let _ = writeln!(page, "<tr>{cells}</tr>");
    }
    page.push_str("</table></details>\n");
    Ok(())
}

/// Text that is no markup.
fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;").replace('\'', "&#39;")
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    #[test]
    fn figures_are_short_and_no_markup() {
        assert_eq!(plain(&json!(0.123_456_789)), "0.123457");
        assert_eq!(plain(&json!(1.25e-9)), "1.25e-9");
        assert_eq!(plain(&json!(12)), "12");
        let mut page = String::new();
        figures(&mut page, &json!({ "a_b": "<x>", "none": null, "list": [1, 2.5], "empty": { "c": null } }));
        assert_eq!(
            page,
            "<table><tr><th>a b</th><td>&lt;x&gt;</td></tr><tr><th>list</th><td>1, 2.5</td></tr></table>\n"
        );
    }
}
