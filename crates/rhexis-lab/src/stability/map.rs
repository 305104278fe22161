//! The map as text and as pictures: a panel per mode; across, the time step within the rotation speed; down, the stiffness ratio within
//! the compression within the quality of the mesh.

use super::{Axes, Grade, Map};
use crate::bench::{BenchError, make};
use crate::verify::{FONT_NAME, load_font};
use plotters::coord::Shift;
use plotters::prelude::*;
use std::fmt::Write;
use std::path::Path;

/// Colours of the grades, told apart by colour-blind eyes too (Okabe, Ito 2008).
const COLOURS: [RGBColor; 4] =
    [RGBColor(0, 158, 115), RGBColor(86, 180, 233), RGBColor(240, 228, 66), RGBColor(213, 94, 0)];

/// A cell of the map \[px\].
const CELL: [i32; 2] = [20, 15];
/// Between groups of cells \[px\].
const GAP: i32 = 5;
/// Left, above, between panels, below \[px\].
const MARGINS: [i32; 4] = [250, 86, 26, 70];

/// The maps as text, one sign per case.
pub fn printed(axes: &Axes, maps: &[Map]) -> String {
    let mut text = String::new();
    let signs: Vec<String> = Grade::ALL.iter().map(|grade| format!("{} {}", grade.sign(), grade.name())).collect();
    let _ = writeln!(text, "{}", signs.join(", "));
    let list = |values: &[f64]| values.iter().map(f64::to_string).collect::<Vec<_>>().join(" ");
    let _ = writeln!(
        text,
        "across: dt {} ms, within spin {} rad/ms; down: E_F/E_T {}\n",
        list(&axes.dt),
        list(&axes.spin),
        list(&axes.ratio)
    );
    let across = axes.dt.len() * axes.spin.len();
    let width = across + axes.spin.len();
    let heads: Vec<String> = maps.iter().map(|map| format!("{:width$}", map.mode.name())).collect();
    let _ = writeln!(text, "{:26}{}", "", heads.join("  ").trim_end());
    for (row, label) in labels(axes).iter().enumerate() {
        let group = |map: &Map| {
            let cells = &map.courses[row * across..(row + 1) * across];
            let signs: Vec<char> = cells.iter().map(|(_, course)| course.grade().sign()).collect();
            let groups = signs.chunks(axes.dt.len()).map(|group| group.iter().collect::<String>());
            format!("{:width$}", groups.collect::<Vec<_>>().join(" "))
        };
        let cells: Vec<String> = maps.iter().map(group).collect();
        let _ = writeln!(text, "{label:26}{}", cells.join("  ").trim_end());
    }
    for map in maps {
        let count = |grade: Grade| map.courses.iter().filter(|(_, course)| course.grade() == grade).count();
        let counts: Vec<String> =
            Grade::ALL.iter().map(|&grade| format!("{} {}", count(grade), grade.name())).collect();
        let _ = write!(text, "\n{}: {}", map.mode.name(), counts.join(", "));
    }
    text
}

/// What the rows are, from above.
fn labels(axes: &Axes) -> Vec<String> {
    let mut labels = Vec::new();
    for quality in &axes.quality {
        for compression in &axes.compression {
            let name = |i: usize| match i {
                0 => format!("{}, pressed by {compression}", quality.name()),
                _ => String::new(),
            };
            labels.extend((0..axes.ratio.len()).map(name));
        }
    }
    labels
}

/// Draws `stability.svg` and `.png`, the grades, and `stability-energy.svg` and `.png`, the energy that is left at the end.
///
/// # Errors
/// If a file cannot be written.
pub fn draw(directory: &Path, axes: &Axes, maps: &[Map], steps: u64) -> Result<(), BenchError> {
    make(directory)?;
    load_font();
    for (name, picture) in [("stability", Picture::Grades), ("stability-energy", Picture::Energy)] {
        let [svg, png] = ["svg", "png"].map(|kind| directory.join(format!("{name}.{kind}")));
        let failed = |path: &Path, what: String| BenchError::File { path: path.to_owned(), what };
        let size = size(axes, maps.len());
        picture
            .draw(&SVGBackend::new(&svg, size).into_drawing_area(), axes, maps, steps)
            .map_err(|error| failed(&svg, error.to_string()))?;
        picture
            .draw(&BitMapBackend::new(&png, size).into_drawing_area(), axes, maps, steps)
            .map_err(|error| failed(&png, error.to_string()))?;
    }
    Ok(())
}

fn panel_width(axes: &Axes) -> i32 {
    (axes.spin.len() * axes.dt.len()) as i32 * CELL[0] + (axes.spin.len() as i32 - 1) * GAP
}

fn size(axes: &Axes, panels: usize) -> (u32, u32) {
    let [left, top, between, below] = MARGINS;
    let groups = (axes.quality.len() * axes.compression.len()) as i32;
    let height = groups * axes.ratio.len() as i32 * CELL[1] + (groups - 1) * GAP;
    let panels = panels as i32;
    let width = left + panels * panel_width(axes) + (panels - 1) * between + 20;
    (width as u32, (top + height + below) as u32)
}

type Drawn<B> = Result<(), DrawingAreaErrorKind<<B as DrawingBackend>::ErrorType>>;

#[derive(Clone, Copy)]
enum Picture {
    Grades,
    Energy,
}

impl Picture {
    fn draw<B: DrawingBackend>(self, area: &DrawingArea<B, Shift>, axes: &Axes, maps: &[Map], steps: u64) -> Drawn<B> {
        let [left, top, between, _] = MARGINS;
        area.fill(&WHITE)?;
        let title = match self {
            Self::Grades => format!("Where {steps} steps stay stable"),
            Self::Energy => format!("Energy left after {steps} steps"),
        };
        let text = |words: String, at: (i32, i32), size: i32| Text::new(words, at, (FONT_NAME, size));
        area.draw(&text(title, (12, 10), 20))?;
        for (row, label) in labels(axes).iter().enumerate().filter(|(_, label)| !label.is_empty()) {
            area.draw(&text(label.clone(), (12, top + down(axes, row)), 13))?;
        }
        for row in 0..labels(axes).len() {
            let ratio = axes.ratio[row % axes.ratio.len()].to_string();
            let at = (left - 12 - 8 * ratio.len() as i32, top + down(axes, row));
            area.draw(&text(ratio, at, 12))?;
        }
        area.draw(&text("E_F/E_T".to_owned(), (left - 66, top - 22), 13))?;
        for (panel, map) in maps.iter().enumerate() {
            let x = left + panel as i32 * (panel_width(axes) + between);
            area.draw(&text(map.mode.name().to_owned(), (x, 38), 17))?;
            let across = axes.dt.len() * axes.spin.len();
            for (group, spin) in axes.spin.iter().enumerate() {
                let at = x + right(axes, group * axes.dt.len());
                area.draw(&text(format!("{spin} rad/ms"), (at, top - 22), 13))?;
            }
            for (i, (_, course)) in map.courses.iter().enumerate() {
                let at = (x + right(axes, i % across), top + down(axes, i / across));
                let cell = [at, (at.0 + CELL[0] - 1, at.1 + CELL[1] - 1)];
                let colour = match self {
                    Self::Grades => COLOURS[course.grade() as usize].to_rgba(),
                    Self::Energy => shade(course.energy_left).to_rgba(),
                };
                area.draw(&Rectangle::new(cell, colour.filled()))?;
            }
        }
        self.legend(area, axes)?;
        area.present()
    }

    fn legend<B: DrawingBackend>(self, area: &DrawingArea<B, Shift>, axes: &Axes) -> Drawn<B> {
        let bottom = size(axes, 1).1 as i32;
        let dts: Vec<String> = axes.dt.iter().map(f64::to_string).collect();
        let words = format!("cells of a group, left to right: steps of {} ms", dts.join(", "));
        area.draw(&Text::new(words, (12, bottom - 52), (FONT_NAME, 13)))?;
        let entries: Vec<(String, RGBColor)> = match self {
            Self::Grades => {
                Grade::ALL.iter().map(|&grade| (grade.name().to_owned(), COLOURS[grade as usize])).collect()
            }
            Self::Energy => [1e-8, 1e-6, 1e-4, 1e-2, 0.1, 0.5, 1.0, 1.01, 1.1, 10.0]
                .map(|left| (format!("{left}"), shade(left)))
                .to_vec(),
        };
        let mut x = 12;
        for (name, colour) in entries {
            let swatch = [(x, bottom - 26), (x + 18, bottom - 12)];
            area.draw(&Rectangle::new(swatch, colour.filled()))?;
            area.draw(&Text::new(name.clone(), (x + 24, bottom - 27), (FONT_NAME, 14)))?;
            x += 44 + 9 * name.len() as i32;
        }
        Ok(())
    }
}

/// Where a column begins in its panel \[px\].
fn right(axes: &Axes, column: usize) -> i32 {
    column as i32 * CELL[0] + (column / axes.dt.len()) as i32 * GAP
}

/// Where a row begins \[px\].
fn down(axes: &Axes, row: usize) -> i32 {
    row as i32 * CELL[1] + (row / axes.ratio.len()) as i32 * GAP
}

/// Blue the darker the more is left, red for what is more than there was, grey for what is unknown.
fn shade(left: f64) -> RGBColor {
    let mix = |from: [f64; 3], to: [f64; 3], part: f64| {
        let [r, g, b] = [0, 1, 2].map(|i| (from[i] + (to[i] - from[i]) * part.clamp(0.0, 1.0)) as u8);
        RGBColor(r, g, b)
    };
    match left {
        _ if !left.is_finite() => RGBColor(120, 120, 120),
        // A tenth above, the most that the engine allows, is as red as it gets.
        left if left > 1.0 + 1e-6 => mix([250.0, 200.0, 170.0], [190.0, 40.0, 0.0], (left - 1.0) * 10.0),
        // Eight decades.
        left => mix([235.0, 243.0, 250.0], [0.0, 80.0, 150.0], 1.0 + left.max(1e-8).log10() / 8.0),
    }
}
