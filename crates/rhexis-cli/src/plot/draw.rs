//! Curves on linear axes, as SVG and PNG.

use plotters::coord::Shift;
use plotters::prelude::*;
use rhexis_lab::verify::{FONT_NAME, load_font};
use std::path::Path;

/// Width and height \[px\].
const SIZE: (u32, u32) = (1000, 600);

/// Colours that are told apart on white, by colour-blind eyes too (Okabe, Ito 2008; their yellow is too light for lines).
const COLOURS: [RGBColor; 7] = [
    RGBColor(0, 114, 178),
    RGBColor(213, 94, 0),
    RGBColor(0, 158, 115),
    RGBColor(204, 121, 167),
    RGBColor(86, 180, 233),
    RGBColor(230, 159, 0),
    RGBColor(90, 60, 30),
];

/// One curve.
pub(crate) struct Curve {
    name: String,
    points: Vec<(f64, f64)>,
    /// Dots beside the line.
    marks: Vec<(f64, f64)>,
}

impl Curve {
    /// A curve through the finite points of two columns.
    pub(crate) fn new(name: String, x: &[f64], y: &[f64]) -> Self {
        let points = x.iter().copied().zip(y.iter().copied()).filter(|(x, y)| x.is_finite() && y.is_finite());
        Self { name, points: points.collect(), marks: Vec::new() }
    }

    /// Adds dots to the curve.
    pub(crate) fn dotted(self, marks: Vec<(f64, f64)>) -> Self {
        Self { marks, ..self }
    }

    /// Whether it shows anything but zero.
    pub(crate) fn is_there(&self) -> bool {
        self.points.iter().any(|(_, y)| *y != 0.0)
    }
}

/// One plot.
pub(crate) struct Panel {
    /// Name of its files.
    pub name: String,
    /// What the axes show, with units in brackets.
    pub axes: [String; 2],
    /// The curves.
    pub curves: Vec<Curve>,
    /// How the curves are drawn.
    pub style: Style,
}

/// How curves are drawn.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Style {
    /// As lines.
    Lines,
    /// As areas, each on those before it.
    Areas,
    /// As points that nothing joins.
    Points,
}

/// Writes `<name>.svg` and `<name>.png`.
pub(crate) fn files(directory: &Path, panel: &Panel) -> Result<(), String> {
    load_font();
    let [svg, png] = ["svg", "png"].map(|kind| directory.join(format!("{}.{kind}", panel.name)));
    draw(&SVGBackend::new(&svg, SIZE).into_drawing_area(), panel)
        .map_err(|error| format!("{}: {error}", svg.display()))?;
    draw(&BitMapBackend::new(&png, SIZE).into_drawing_area(), panel)
        .map_err(|error| format!("{}: {error}", png.display()))
}

/// The plot as SVG text.
pub(crate) fn svg(panel: &Panel) -> Result<String, String> {
    load_font();
    let mut text = String::new();
    draw(&SVGBackend::with_string(&mut text, SIZE).into_drawing_area(), panel).map_err(|error| error.to_string())?;
    Ok(text)
}

/// Each curve on top of those before it, as far as all have the same points.
fn stacked(curves: &[Curve]) -> Vec<Vec<(f64, f64)>> {
    let mut sums: Vec<Vec<(f64, f64)>> = Vec::new();
    for curve in curves {
        let below = sums.last();
        let on = |(row, &(x, y)): (usize, &(f64, f64))| {
            (x, y + below.and_then(|below| below.get(row)).map_or(0.0, |(_, below)| *below))
        };
        let sum = curve.points.iter().enumerate().map(on).collect();
        sums.push(sum);
    }
    sums
}

/// The range of values, with some room; of none, or of one, around it.
fn range(values: impl Iterator<Item = f64> + Clone, room: f64) -> std::ops::Range<f64> {
    let (least, most) = (values.clone().fold(f64::INFINITY, f64::min), values.fold(f64::NEG_INFINITY, f64::max));
    match most - least {
        span if span > 0.0 => (least - room * span)..(most + room * span),
        _ if least.is_finite() => (least - 0.5)..(least + 0.5),
        _ => 0.0..1.0,
    }
}

fn draw<B: DrawingBackend>(
    area: &DrawingArea<B, Shift>,
    panel: &Panel,
) -> Result<(), DrawingAreaErrorKind<B::ErrorType>> {
    let is_stacked = panel.style == Style::Areas;
    let lines: Vec<Vec<(f64, f64)>> = if is_stacked {
        stacked(&panel.curves)
    } else {
        panel.curves.iter().map(|curve| curve.points.clone()).collect()
    };
    let points = || lines.iter().flatten();
    // Zero is seen: curves are quantities from it.
    let y = range(points().map(|(_, y)| *y).chain([0.0]), 0.05);
    // A point on the frame would be half a point.
    let room = if panel.style == Style::Points { 0.03 } else { 0.0 };
    area.fill(&WHITE)?;
    let mut chart = ChartBuilder::on(area)
        .margin(16)
        .x_label_area_size(50)
        .y_label_area_size(90)
        .build_cartesian_2d(range(points().map(|(x, _)| *x), room), y)?;
    chart
        .configure_mesh()
        .x_desc(&panel.axes[0])
        .y_desc(&panel.axes[1])
        .label_style((FONT_NAME, 16))
        .bold_line_style(BLACK.mix(0.15))
        .light_line_style(BLACK.mix(0.04))
        .draw()?;
    // The topmost area first, so that those below it stay visible.
    let order: Vec<usize> = if is_stacked { (0..lines.len()).rev().collect() } else { (0..lines.len()).collect() };
    for index in order {
        let (colour, name) = (COLOURS[index % COLOURS.len()], panel.curves[index].name.as_str());
        let line = lines[index].iter().copied();
        let style = colour.stroke_width(2);
        let drawn = match panel.style {
            Style::Areas => chart.draw_series(AreaSeries::new(line, 0.0, colour.to_rgba()).border_style(style))?,
            Style::Lines => chart.draw_series(LineSeries::new(line, style))?,
            Style::Points => chart.draw_series(line.map(|point| Circle::new(point, 5, colour.mix(0.7).filled())))?,
        };
        drawn.label(name).legend(move |(x, y)| PathElement::new([(x, y), (x + 24, y)], colour.stroke_width(4)));
        let dots = panel.curves[index].marks.iter().copied();
        chart.draw_series(dots.map(|point| Circle::new(point, 3, colour.filled())))?;
    }
    chart
        .configure_series_labels()
        .position(SeriesLabelPosition::UpperLeft)
        .label_font((FONT_NAME, 15))
        .background_style(WHITE.mix(0.85))
        .border_style(BLACK.mix(0.3))
        .draw()?;
    area.present()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn areas_stand_on_each_other_and_ranges_hold_what_there_is() {
        let curve = |y: [f64; 2]| Curve::new("a".into(), &[0.0, 1.0], &y);
        assert_eq!(stacked(&[curve([1.0, 2.0]), curve([3.0, 4.0])])[1], [(0.0, 4.0), (1.0, 6.0)]);
        assert_eq!(range([2.0, 4.0].into_iter(), 0.0), 2.0..4.0);
        assert_eq!(range([3.0].into_iter(), 0.1), 2.5..3.5);
        assert_eq!(range(std::iter::empty(), 0.1), 0.0..1.0);
        assert!(Curve::new("a".into(), &[0.0, 1.0], &[f64::NAN, 1.0]).points.len() == 1);
    }

    #[test]
    fn a_plot_has_its_axes_and_names() {
        let curve = Curve::new("left".into(), &[0.0, 1.0], &[0.0, 2.0]);
        let axes = ["time [ms]".to_owned(), "force [N]".to_owned()];
        let text = svg(&Panel { name: "forces".into(), axes, curves: vec![curve], style: Style::Lines }).unwrap();
        assert!(["time [ms]", "force [N]", "left"].iter().all(|word| text.contains(word)), "{text}");
    }
}
