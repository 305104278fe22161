//! `rhexis plot`: curves of runs over time, or of one column over another.

mod draw;
mod table;

pub(super) use draw::{Curve, Panel, Style, files, svg};
pub(super) use table::{Table, label};

use crate::Stop;
use crate::say::say;
use clap::Args;
use glam::DVec3;
use rhexis_scene::measures::HandForce;
use std::path::{Path, PathBuf};

#[derive(Args)]
pub(super) struct PlotArgs {
    /// Output directories of `rhexis run`; several are drawn into the same plots.
    #[arg(value_name = "RUN_DIR", required = true)]
    runs: Vec<PathBuf>,
    /// Column of series.csv along the horizontal axis.
    #[arg(long, value_name = "COLUMN", default_value = "time_ms")]
    x: String,
    /// Columns of series.csv to draw into one plot, instead of the usual ones.
    #[arg(long, value_name = "COLUMN", value_delimiter = ',')]
    y: Vec<String>,
    /// Directory for the plots [default: `plots` in the first run's directory].
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
}

pub(super) const EXAMPLES: &str = "\
Examples:
  rhexis plot out/fig2-tear
  rhexis plot out/coarse out/fine --y tear_length_mm
  rhexis plot out/fig2-tear --x tear_length_mm --y square/left_x_N

Without --y: forces of holds and grips (dots: before an advance; in the legend: mean while it tears, and before advances), energies
stacked, tear length, criterion and iterations, each as SVG and PNG.";

/// Draws the plots of some runs.
pub(super) fn plot(args: &PlotArgs) -> Result<(), Stop> {
    let tables: Vec<Table> = args.runs.iter().map(|run| Table::read(run)).collect::<Result<_, _>>()?;
    let panels = if args.y.is_empty() { usual(&tables, &args.x)? } else { asked(&tables, &args.x, &args.y)? };
    let out = args.out.clone().unwrap_or_else(|| args.runs[0].join("plots"));
    std::fs::create_dir_all(&out).map_err(|error| Stop::Failed(format!("{}: {error}", out.display())))?;
    for panel in &panels {
        files(&out, panel).map_err(Stop::Failed)?;
    }
    let names: Vec<&str> = panels.iter().map(|panel| panel.name.as_str()).collect();
    say(&format!("{} in {} as .svg and .png", names.join(", "), out.display()))
}

/// The usual plots of one run.
pub(super) fn of_run(directory: &Path) -> Result<Vec<Panel>, Stop> {
    usual(&[Table::read(directory)?], "time_ms")
}

/// The columns that were asked for, in one plot.
fn asked(tables: &[Table], x: &str, y: &[String]) -> Result<Vec<Panel>, Stop> {
    let mut curves = Vec::new();
    for table in tables {
        for column in y {
            curves.push(Curve::new(named(tables, table, column), table.column(x)?, table.column(column)?));
        }
    }
    let first = label(&y[0]);
    let unit = first.split_once(" [").map(|(_, unit)| format!("[{unit}"));
    let y_label = if y.len() == 1 { first } else { unit.unwrap_or_default() };
    let name: String = y.join("-").chars().map(|c| if c.is_alphanumeric() { c } else { '-' }).collect();
    Ok(vec![Panel { name, axes: [label(x), y_label], curves, style: Style::Lines }])
}

/// The plots that every run has something to show in.
fn usual(tables: &[Table], x: &str) -> Result<Vec<Panel>, Stop> {
    let mut panels = Vec::new();
    let mut panel = |name: &str, y: &str, curves: Vec<Curve>, style: Style| {
        if curves.iter().any(Curve::is_there) {
            panels.push(Panel { name: name.to_owned(), axes: [label(x), y.to_owned()], curves, style });
        }
    };
    let mut forces = Vec::new();
    for table in tables {
        for (name, lengths) in table.lengths("N") {
            forces.push(force(named(tables, table, &name), table, table.column(x)?, &lengths));
        }
    }
    panel("forces", "force [N]", forces, Style::Lines);
    let columns = |names: &[&str]| -> Result<Vec<Curve>, Stop> {
        let mut curves = Vec::new();
        for table in tables {
            for name in names {
                curves.push(Curve::new(named(tables, table, &label(name)), table.column(x)?, table.column(name)?));
            }
        }
        Ok(curves)
    };
    let energies = if tables.len() == 1 { Style::Areas } else { Style::Lines };
    panel("energies", "energy [mJ]", columns(&["elastic_mJ", "kinetic_mJ"])?, energies);
    panel("tear-length", "tear length [mm]", columns(&["tear_length_mm"])?, Style::Lines);
    panel("criterion", "largest criterion; above 1 it tears", columns(&["max_criterion"])?, Style::Lines);
    panel("iterations", "iterations of a step", columns(&["iterations"])?, Style::Lines);
    Ok(panels)
}

/// Curve of a force, with its means over a tear in the legend and a dot before each advance.
fn force(name: String, table: &Table, x: &[f64], lengths: &[f64]) -> Curve {
    let Ok(advances) = table.column("advances") else { return Curve::new(name, x, lengths) };
    let mut hand = HandForce::default();
    for (&length, &advances) in lengths.iter().zip(advances) {
        // Jaws that are open have no force.
        hand.note((length > 0.0).then_some(DVec3::X * length), advances > 0.0);
    }
    let felt = hand.figures().map_or(String::new(), |felt| {
        format!(": while it tears {:.3} mN, before advances {:.3}", 1e3 * felt.mean, 1e3 * felt.before_advances)
    });
    let before = advances.iter().enumerate().skip(1).filter(|(_, advances)| **advances > 0.0).map(|(row, _)| row - 1);
    let dots = before.filter(|&row| lengths[row] > 0.0).map(|row| (x[row], lengths[row])).collect();
    Curve::new(name + &felt, x, lengths).dotted(dots)
}

/// The name of a curve; with the run's where there are several.
fn named(tables: &[Table], table: &Table, curve: &str) -> String {
    if tables.len() == 1 { curve.to_owned() } else { format!("{}: {curve}", table.run) }
}
