//! What verification leaves for the eye: plots of curves, as SVG and PNG, and their points as CSV.

use super::VerifyError;
use crate::FONT;
use glam::DVec2;
use plotters::coord::Shift;
use plotters::prelude::*;
use plotters::style::register_font;
use rhexis_scene::output::file;
use std::path::{Path, PathBuf};

/// The font of all plots.
pub const FONT_NAME: &str = "DejaVu Sans";
/// Width and height of a plot \[px\].
const SIZE: (u32, u32) = (1000, 900);

/// Makes [`FONT_NAME`] known to the plots.
pub fn load_font() {
    // A font that is registered already is no failure.
    let _ = register_font(FONT_NAME, FontStyle::Normal, FONT);
}

/// How much a case computes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Depth {
    /// The coarsest meshes that still show the claim: seconds.
    Quick,
    /// All sizes: minutes.
    #[default]
    Full,
}

/// Where a case may leave plots, and how deep it goes.
#[derive(Clone, Debug, Default)]
pub struct Artifacts {
    /// Directory for plots, made with the first of them; none are drawn without it.
    pub directory: Option<PathBuf>,
    /// How much is computed.
    pub depth: Depth,
}

/// A curve with its name in the legend.
#[derive(Clone, Debug, PartialEq)]
pub struct Line {
    /// Name.
    pub name: String,
    /// Points in axis units.
    pub points: Vec<DVec2>,
}

/// Axes of a plot.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Axes<'a> {
    /// Headline.
    pub title: &'a str,
    /// Names of x and y, with their units in brackets.
    pub names: [&'a str; 2],
    /// Whether a unit is equally long on both axes, as for paths in a sheet.
    pub is_isometric: bool,
}

impl Artifacts {
    /// Whether only the quick part is asked for.
    pub fn is_quick(&self) -> bool {
        self.depth == Depth::Quick
    }

    /// Draws tear paths \[mm, rest shape\] over each other: `<name>.svg`, `<name>.png` and `<name>.csv`.
    ///
    /// # Errors
    /// If a file cannot be written.
    pub fn paths(&self, name: &str, title: &str, paths: &[Line]) -> Result<(), VerifyError> {
        self.plot(name, Axes { title, names: ["x [mm]", "y [mm]"], is_isometric: true }, paths)
    }

    /// Draws curves: `<name>.svg`, `<name>.png` and `<name>.csv`.
    ///
    /// # Errors
    /// If a file cannot be written.
    pub fn plot(&self, name: &str, axes: Axes<'_>, lines: &[Line]) -> Result<(), VerifyError> {
        let Some(directory) = &self.directory else { return Ok(()) };
        let [svg, png, csv] = ["svg", "png", "csv"].map(|kind| directory.join(format!("{name}.{kind}")));
        let failed = |path: &Path, what: String| VerifyError::Plot { path: path.to_owned(), what };
        std::fs::create_dir_all(directory).map_err(|error| failed(directory, error.to_string()))?;
        file::replace(&csv, table(axes, lines).as_bytes())?;
        load_font();
        draw(&SVGBackend::new(&svg, SIZE).into_drawing_area(), axes, lines).map_err(|what| failed(&svg, what))?;
        draw(&BitMapBackend::new(&png, SIZE).into_drawing_area(), axes, lines).map_err(|what| failed(&png, what))
    }
}

fn table(axes: Axes<'_>, lines: &[Line]) -> String {
    let mut rows = format!("line,{},{}\n", axes.names[0], axes.names[1]);
    for line in lines {
        for point in &line.points {
            rows.push_str(&format!("{},{},{}\n", line.name.replace(',', ";"), point.x, point.y));
        }
    }
    rows
}

fn draw<B: DrawingBackend>(area: &DrawingArea<B, Shift>, axes: Axes<'_>, lines: &[Line]) -> Result<(), String> {
    try_draw(area, axes, lines).map_err(|error| error.to_string())
}

fn try_draw<B: DrawingBackend>(
    area: &DrawingArea<B, Shift>,
    axes: Axes<'_>,
    lines: &[Line],
) -> Result<(), DrawingAreaErrorKind<B::ErrorType>> {
    let (low, high) = limits(axes, lines);
    area.fill(&WHITE)?;
    let mut chart = ChartBuilder::on(area)
        .caption(axes.title, (FONT_NAME, 24))
        .margin(16)
        .x_label_area_size(50)
        .y_label_area_size(70)
        .build_cartesian_2d(low.x..high.x, low.y..high.y)?;
    chart
        .configure_mesh()
        .x_desc(axes.names[0])
        .y_desc(axes.names[1])
        .label_style((FONT_NAME, 16))
        .light_line_style(TRANSPARENT)
        .draw()?;
    for (index, line) in lines.iter().enumerate() {
        let style = Palette99::pick(index).stroke_width(2);
        chart
            .draw_series(LineSeries::new(line.points.iter().map(|p| (p.x, p.y)), style))?
            .label(line.name.as_str())
            .legend(move |(x, y)| PathElement::new([(x, y), (x + 24, y)], style));
    }
    chart.configure_series_labels().label_font((FONT_NAME, 15)).background_style(WHITE.mix(0.8)).draw()?;
    area.present()
}

/// Lower left and upper right corner of the axes: all points with a margin, never without extent.
fn limits(axes: Axes<'_>, lines: &[Line]) -> (DVec2, DVec2) {
    let finite = lines.iter().flat_map(|line| &line.points).filter(|p| p.is_finite());
    let (low, high) = finite.fold((DVec2::MAX, DVec2::MIN), |(low, high), &p| (low.min(p), high.max(p)));
    if low.x > high.x {
        return (DVec2::ZERO, DVec2::ONE);
    }
    let middle = (low + high) * 0.5;
    let extent = high - low;
    // The axes may have different units: neither sets a scale for the other.
    let least = (middle.abs() * 1e-6).max(DVec2::splat(1e-12));
    let mut half = extent.max(least) * 0.55;
    if axes.is_isometric {
        // The plot's area is nearly square.
        half = DVec2::splat(half.max_element());
    }
    (middle - half, middle + half)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_plot_leaves_svg_png_and_the_points() {
        let directory = tempfile::tempdir().unwrap();
        let out = Artifacts { directory: Some(directory.path().join("plots")), depth: Depth::Quick };
        let line = |name: &str, points: &[DVec2]| Line { name: name.to_owned(), points: points.to_vec() };
        // One line without extent along y, one of a single point, one that is not finite: none may stop the plot.
        let lines = [
            line("flat, thin", &[DVec2::ZERO, DVec2::X]),
            line("dot", &[DVec2::ONE]),
            line("hole", &[DVec2::NAN, DVec2::ONE]),
        ];
        out.paths("paths", "two lines", &lines).unwrap();
        let read = |kind: &str| std::fs::read(directory.path().join(format!("plots/paths.{kind}"))).unwrap();
        assert!(String::from_utf8(read("svg")).unwrap().contains("flat, thin"));
        assert_eq!(&read("png")[1..4], b"PNG");
        let table = String::from_utf8(read("csv")).unwrap();
        assert_eq!(table.lines().nth(2), Some("flat; thin,1,0"));
        assert_eq!(table.lines().count(), 6);
    }

    #[test]
    fn without_a_directory_nothing_is_drawn() {
        Artifacts::default().paths("paths", "none", &[]).unwrap();
    }
}
