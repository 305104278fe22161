//! Error over time on logarithmic axes, as SVG and PNG.

use super::BenchError;
use super::front::{Point, front};
use super::table::make;
use crate::verify::{FONT_NAME, load_font};
use plotters::coord::Shift;
use plotters::prelude::*;
use std::path::Path;

/// Width and height \[px\].
const SIZE: (u32, u32) = (1100, 800);

/// Colours that are told apart on white, by colour-blind eyes too (Okabe, Ito 2008; their yellow is too light for lines).
const COLOURS: [(u8, u8, u8); 8] = [
    (213, 94, 0),
    (0, 114, 178),
    (0, 158, 115),
    (204, 121, 167),
    (86, 180, 233),
    (230, 159, 0),
    (90, 60, 30),
    (120, 120, 120),
];

/// One setting over its tolerances, or one time step over meshes.
#[derive(Clone, Debug)]
pub(super) struct Series {
    /// Name in the legend.
    pub name: String,
    /// Its points.
    pub points: Vec<Point>,
}

/// A work–precision diagram.
#[derive(Clone, Debug)]
pub(super) struct Chart {
    /// Headline.
    pub title: String,
    /// What the axes show, with units in brackets: time, error.
    pub axes: [&'static str; 2],
    /// The curves.
    pub series: Vec<Series>,
    /// The default settings' points.
    pub defaults: Vec<Point>,
}

/// Draws `<name>.svg` and `<name>.png` into the directory; nothing where no point is known.
///
/// # Errors
/// If a file cannot be written.
pub(super) fn draw(directory: &Path, name: &str, chart: &Chart) -> Result<(), BenchError> {
    let points: Vec<Point> = chart.series.iter().flat_map(|series| &series.points).copied().collect();
    if front(&points).is_empty() {
        return Ok(());
    }
    make(directory)?;
    load_font();
    let [svg, png] = ["svg", "png"].map(|kind| directory.join(format!("{name}.{kind}")));
    let failed = |path: &Path, what: String| BenchError::File { path: path.to_owned(), what };
    try_draw(&SVGBackend::new(&svg, SIZE).into_drawing_area(), chart, &points)
        .map_err(|error| failed(&svg, error.to_string()))?;
    try_draw(&BitMapBackend::new(&png, SIZE).into_drawing_area(), chart, &points)
        .map_err(|error| failed(&png, error.to_string()))
}

fn try_draw<B: DrawingBackend>(
    area: &DrawingArea<B, Shift>,
    chart: &Chart,
    points: &[Point],
) -> Result<(), DrawingAreaErrorKind<B::ErrorType>> {
    let known = || points.iter().filter(|point| point.is_known());
    let range = |value: fn(&Point) -> f64| {
        let least = known().map(value).fold(f64::INFINITY, f64::min);
        let most = known().map(value).fold(0.0, f64::max);
        match most / least {
            // Less than a decade would have hardly a tick.
            span if span < 10.0 => 0.9 * 10_f64.powf(least.log10().floor())..1.1 * 10_f64.powf(most.log10().ceil()),
            // Room for markers.
            _ => (least / 1.6)..(most * 1.6),
        }
    };
    area.fill(&WHITE)?;
    let mut drawing = ChartBuilder::on(area)
        .caption(&chart.title, (FONT_NAME, 22))
        .margin(16)
        .x_label_area_size(50)
        .y_label_area_size(80)
        .build_cartesian_2d(range(|point| point.ms).log_scale(), range(|point| point.error).log_scale())?;
    drawing
        .configure_mesh()
        .x_desc(chart.axes[0])
        .y_desc(chart.axes[1])
        .x_label_formatter(&|value| short(*value))
        .y_label_formatter(&|value| short(*value))
        .label_style((FONT_NAME, 16))
        .bold_line_style(BLACK.mix(0.15))
        .light_line_style(BLACK.mix(0.05))
        .draw()?;
    let front = front(points).into_iter().map(|point| (point.ms, point.error));
    let grey = BLACK.mix(0.18).stroke_width(12);
    drawing
        .draw_series(LineSeries::new(front, grey))?
        .label("Pareto front")
        .legend(move |(x, y)| PathElement::new([(x, y), (x + 24, y)], grey));
    for (index, series) in chart.series.iter().enumerate() {
        let (red, green, blue) = COLOURS[index % COLOURS.len()];
        let colour = RGBColor(red, green, blue).to_rgba();
        let points = || series.points.iter().filter(|point| point.is_known()).map(|point| (point.ms, point.error));
        drawing
            .draw_series(LineSeries::new(points(), colour.stroke_width(2)))?
            .label(series.name.as_str())
            .legend(move |(x, y)| PathElement::new([(x, y), (x + 24, y)], colour.stroke_width(3)));
        drawing.draw_series(points().map(|at| Circle::new(at, 4, colour.filled())))?;
    }
    let defaults = chart.defaults.iter().filter(|point| point.is_known()).map(|point| (point.ms, point.error));
    drawing
        .draw_series(defaults.map(|at| Circle::new(at, 10, BLACK.stroke_width(3))))?
        .label("default settings")
        .legend(|(x, y)| Circle::new((x + 12, y), 7, BLACK.stroke_width(3)));
    drawing
        .configure_series_labels()
        .position(SeriesLabelPosition::UpperRight)
        .label_font((FONT_NAME, 15))
        .background_style(WHITE.mix(0.85))
        .border_style(BLACK.mix(0.3))
        .draw()?;
    area.present()
}

/// A tick as people write it.
fn short(value: f64) -> String {
    if (1e-2..1e4).contains(&value) { format!("{}", (value * 1e3).round() / 1e3) } else { format!("{value:.0e}") }
}
