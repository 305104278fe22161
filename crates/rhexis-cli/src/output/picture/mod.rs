//! A picture of one body at one moment: stress in colours, fibres, tears and their tips.

mod camera;
mod canvas;
mod legend;
mod pieces;
mod scale;
mod sheet;
mod surface;
mod tips;

use super::{OutputError, file, shape};
use camera::{Area, Camera};
use canvas::{Anchor, Canvas, Line};
use glam::{DVec2, DVec3};
use rhexis::frame::{BodyFrame, SolidFrame, TipFrame};
use scale::Scale;
use std::path::Path;

pub(crate) use sheet::{Drawn, Look, Sheet};

type Rgba = [u8; 4];

const BACKGROUND: Rgba = [255, 255, 255, 255];
const FORCE: Rgba = [190, 30, 45, 255];
/// Half the side of the enlarged view, over the main view's: between these.
const CLOSEST: f64 = 1e-3;
const FARTHEST: f64 = 1e3;

/// The size all lengths of the layout refer to \[px\].
const REFERENCE: [f64; 2] = [1600.0, 1200.0];
/// Below, text is unreadable; above, the bitmap takes more than 1 GB.
const SIZE_RANGE: std::ops::RangeInclusive<u32> = 160..=8000;

/// From where a body is seen.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum View {
    /// From +z if the body is flat across z (to 1 % of its size), otherwise obliquely.
    #[default]
    Auto,
    /// From +z, y upwards.
    Top,
    /// From the side.
    Oblique {
        /// Where the viewer stands, from +x towards +y \[°\].
        azimuth: f64,
        /// How high above the xy plane \[°\], −90 to 90.
        elevation: f64,
    },
    /// From there, by an eye near enough that what is nearer is larger; the scale bar holds in the middle of the body.
    Perspective {
        /// As of [`Oblique`](Self::Oblique).
        azimuth: f64,
        /// As of [`Oblique`](Self::Oblique).
        elevation: f64,
    },
    /// From this direction.
    Along {
        /// Towards the viewer; of any length.
        direction: DVec3,
    },
}

/// What a picture shows.
#[derive(Clone, Debug)]
pub struct PictureSettings {
    /// Width and height \[px\], 160 to 8000 each; 1600 × 1200 by default.
    pub size: [u32; 2],
    /// From where the body is seen.
    pub view: View,
    /// First line, usually the scene's name.
    pub title: String,
    /// Second line, usually time, step and tears.
    pub note: String,
    /// Ends of the stress colours \[MPa\]; by default 0 and the 98th percentile of the largest principal stress.
    pub stress_range: Option<[f64; 2]>,
    /// Whether strokes show the fibres.
    pub show_fibres: bool,
    /// Whether the tips are drawn, with an enlarged view of the one with the largest criterion.
    pub show_tips: bool,
    /// Obstacles and jaws around the body.
    pub solids: Vec<SolidFrame>,
    /// Whether arrows show the forces of the solids on the bodies, to scale among each other.
    pub show_forces: bool,
}

impl Default for PictureSettings {
    fn default() -> Self {
        Self {
            size: [1600, 1200],
            view: View::Auto,
            title: String::new(),
            note: String::new(),
            stress_range: None,
            show_fibres: true,
            show_tips: true,
            solids: Vec::new(),
            show_forces: false,
        }
    }
}

impl PictureSettings {
    /// The default picture, titled with the scene and its moment. `time` in \[ms\].
    #[must_use]
    pub fn titled(scene: &str, time: f64, step: u64, tears: usize) -> Self {
        let tears = match tears {
            0 => "no tear".to_owned(),
            1 => "1 tear".to_owned(),
            many => format!("{many} tears"),
        };
        Self {
            title: scene.to_owned(),
            note: format!("t = {} ms, step {step}, {tears}", (time * 1e3).round() / 1e3),
            ..Self::default()
        }
    }
}

/// Writes a picture of the body as PNG.
///
/// # Errors
/// The body has no triangles, no extent or positions that are not finite, its arrays do not belong together, the size is
/// out of range, or the file cannot be written. Stresses that are not finite are drawn grey and said to be so.
pub fn render(path: &Path, body: &BodyFrame, settings: &PictureSettings) -> Result<(), OutputError> {
    shape::check_shape(path, body)?;
    check_picture(path, body, settings)?;
    let [width, height] = settings.size;
    let out_of_memory =
        || OutputError::content(path, format!("no memory for {width} × {height} pixels; choose a smaller size"));

    let mut canvas = Canvas::new(width, height, BACKGROUND).ok_or_else(out_of_memory)?;
    let layout = Layout::new(settings, tips::foremost(body).is_some() && settings.show_tips);
    let unit = layout.unit;
    let view = resolve(settings.view, body);
    let seen = pieces::framing(body);
    let camera = Camera::fitting(view, seen.iter().copied(), layout.main).ok_or_else(|| {
        OutputError::content(path, format!("body '{}' has no extent that can be shown; check its positions", body.name))
    })?;
    let scale = Scale::new(settings.stress_range, &[body]);

    let style = surface::Style { is_confined: true, ..surface::Style::new(unit) };
    surface::draw(&mut canvas, &camera, (body, &settings.solids), &scale, layout.main, style);
    if !settings.solids.is_empty() {
        clear_around(&mut canvas, layout.main, DVec2::from(settings.size.map(f64::from)), unit);
    }
    if settings.show_fibres {
        surface::draw_fibres(&mut canvas, &camera, body, layout.main, [25, 20], unit);
    }
    if settings.show_forces {
        draw_forces(&mut canvas, &camera, &settings.solids, layout.main, unit);
    }
    legend::heading(&mut canvas, &settings.title, &settings.note, f64::from(width), unit);
    let below = legend::color_bar(&mut canvas, &scale, layout.column, layout.bar_height, unit);
    legend::scale_bar(&mut canvas, &camera, layout.foot, layout.main.size().x, &describe(view), unit);
    if layout.with_inset {
        draw_tips(&mut canvas, &camera, body, &scale, &layout, below, settings).ok_or_else(out_of_memory)?;
    } else {
        let signs = DVec2::new(layout.column.x, below + 10.0 * unit);
        legend::signs(&mut canvas, &scale, settings.show_fibres, None, signs, unit);
    }

    let pixels = canvas.finish().ok_or_else(out_of_memory)?;
    let bytes = pixels.encode_png().map_err(|source| OutputError::content(path, source.to_string()))?;
    file::replace(path, &bytes)
}

fn check_picture(path: &Path, body: &BodyFrame, settings: &PictureSettings) -> Result<(), OutputError> {
    if !settings.size.iter().all(|side| SIZE_RANGE.contains(side)) {
        let [width, height] = settings.size;
        let (low, high) = SIZE_RANGE.into_inner();
        return Err(OutputError::content(
            path,
            format!("{width} × {height} pixels; each side must be {low} to {high}"),
        ));
    }
    if body.triangles.is_empty() {
        return Err(OutputError::content(path, format!("body '{}' has no triangles to show", body.name)));
    }
    match body.triangles.iter().flatten().find(|&&v| !body.positions[v as usize].is_finite()) {
        None => Ok(()),
        Some(v) => Err(OutputError::content(
            path,
            format!(
                "vertex {v} of body '{}' is at {}; only finite positions can be shown",
                body.name, body.positions[*v as usize]
            ),
        )),
    }
}

/// Where things stand on the picture \[px\].
struct Layout {
    /// One pixel of the reference size.
    unit: f64,
    with_inset: bool,
    main: Area,
    column: DVec2,
    column_width: f64,
    bar_height: f64,
    foot: DVec2,
}

impl Layout {
    fn new(settings: &PictureSettings, with_inset: bool) -> Self {
        let size = DVec2::from(settings.size.map(f64::from));
        let unit = (size / DVec2::from(REFERENCE)).min_element();
        let column_width = unit * if with_inset { 380.0 } else { 190.0 };
        let column_x = size.x - column_width - 40.0 * unit;
        let low = DVec2::new(50.0, 140.0) * unit;
        let high = DVec2::new(column_x - 50.0 * unit, size.y - 100.0 * unit);
        Self {
            unit,
            with_inset,
            main: Area { low, high },
            column: DVec2::new(column_x, low.y + 8.0 * unit),
            column_width,
            bar_height: if with_inset { 280.0 * unit } else { 0.7 * (high.y - low.y) },
            foot: DVec2::new(52.0 * unit, size.y - 45.0 * unit),
        }
    }
}

/// All tips in place, and the foremost one enlarged below the colour bar. `None` if there is no memory for it.
fn draw_tips(
    canvas: &mut Canvas,
    camera: &Camera,
    body: &BodyFrame,
    scale: &Scale,
    layout: &Layout,
    below: f64,
    settings: &PictureSettings,
) -> Option<()> {
    let Some((number, foremost)) = tips::foremost(body) else { return Some(()) };
    let unit = layout.unit;
    let tips = tips::drawable(body);
    let reach = tips.iter().map(|(_, tip)| tips::reach(tip)).fold(1.0, f64::max);
    for (other, tip) in &tips {
        let normal = tips::normal(body, tip, camera);
        tips::draw(canvas, camera, tip, normal, layout.main, 85.0 * unit / reach, unit);
        if tips.len() > 1 {
            let at = camera.project(tip.position) + (85.0 / reach + 20.0) * unit * beside(camera, tip);
            canvas.disc(at, 13.0 * unit, [255, 255, 255, 220]);
            canvas.text(at, 19.0 * unit, Anchor::Middle, legend::INK, &format!("{}", other + 1));
        }
    }

    let side = layout.column_width;
    let top = below + 24.0 * unit;
    let name = if tips.len() > 1 { format!("tip {}", number + 1) } else { "tip".to_owned() };
    let text = format!("{name}, enlarged: c = {}", scale::short(foremost.value));
    canvas.text(DVec2::new(layout.column.x, top), 21.0 * unit, Anchor::Left, legend::INK, &text);

    let pixels = side.round();
    let mut inset = Canvas::new(pixels as u32, pixels as u32, BACKGROUND)?;
    let area = Area { low: DVec2::ZERO, high: DVec2::splat(pixels) };
    let normal = tips::normal(body, foremost, camera);
    // R takes three fifths of the way to the frame; without R, a tenth of the main view is shown. What is drawn ten thousand times as
    // large lies millions of pixels off, where the drawing library fails.
    let seen = layout.main.size().min_element() / camera.scale;
    let half = if foremost.radius.is_finite() && foremost.radius > 0.0 {
        (foremost.radius / 0.6).clamp(CLOSEST * seen, FARTHEST * seen)
    } else {
        0.05 * seen
    };
    let close = camera.closeup(normal, foremost.position, area.middle(), 0.5 * pixels / half);
    surface::draw(&mut inset, &close, (body, &[]), scale, area, surface::Style::new(unit));
    if settings.show_fibres {
        surface::draw_fibres(&mut inset, &close, body, area, [9, 9], unit);
    }
    tips::draw(&mut inset, &close, foremost, normal, area, 0.5 * pixels * 0.85 / tips::reach(foremost), 1.4 * unit);
    let corner = DVec2::new(layout.column.x, top + 22.0 * unit).round();
    canvas.place(corner.x as u32, corner.y as u32, &inset);
    legend::frame(canvas, Area { low: corner, high: corner + pixels }, 1.5 * unit);
    let signs = DVec2::new(corner.x, corner.y + pixels + 28.0 * unit);
    legend::signs(canvas, scale, settings.show_fibres, Some(foremost), signs, unit);
    Some(())
}

/// Clears a picture around its main area: solids may be larger.
fn clear_around(canvas: &mut Canvas, main: Area, size: DVec2, unit: f64) {
    let (low, high) = (main.low - 3.0 * unit, main.high + 3.0 * unit);
    for (a, b) in [
        (DVec2::ZERO, DVec2::new(size.x, low.y)),
        (DVec2::new(0.0, high.y), size),
        (DVec2::ZERO, DVec2::new(low.x, size.y)),
        (DVec2::new(high.x, 0.0), size),
    ] {
        canvas.fill(&[a, DVec2::new(b.x, a.y), b, DVec2::new(a.x, b.y)], BACKGROUND, false);
    }
}

/// Arrows along the forces of solids, the largest an eighth of the view long, each with its force in words.
fn draw_forces(canvas: &mut Canvas, camera: &Camera, solids: &[SolidFrame], area: Area, unit: f64) {
    let most = solids.iter().map(|solid| solid.force.length()).fold(0.0, f64::max);
    let longest = 0.125 * area.size().min_element() / camera.scale;
    for SolidFrame { at, force, .. } in solids.iter().filter(|solid| solid.force.length() > 1e-3 * most) {
        let [from, to] = [*at, *at + *force * (longest / most)].map(|x| camera.project(x));
        if area.contains(from) && area.contains(to) {
            canvas.arrow(from, to, Line::new(4.0 * unit, FORCE), [255, 255, 255, 200]);
            let text = format!("{} N", scale::short(force.length()));
            canvas.text(to + DVec2::splat(12.0 * unit), 19.0 * unit, Anchor::Left, legend::INK, &text);
        }
    }
}

/// Where a tip's number stands on the picture: beside the way ahead, and rather not on the way the tear came.
fn beside(camera: &Camera, tip: &TipFrame) -> DVec2 {
    let seen = |d: DVec3| (camera.project(tip.position + d) - camera.project(tip.position)).try_normalize();
    let ahead = seen(tip.direction).unwrap_or(DVec2::NEG_Y);
    let came_from = tip.previous.and_then(|p| seen(-p)).unwrap_or(-ahead);
    let [left, right] = [-2.0, 2.0].map(|angle| DVec2::from_angle(angle).rotate(ahead));
    if left.dot(came_from) < right.dot(came_from) { left } else { right }
}

fn resolve(view: View, body: &BodyFrame) -> View {
    match view {
        View::Auto if surface::is_flat(body, DVec3::Z) => View::Top,
        View::Auto => View::Oblique { azimuth: -70.0, elevation: 50.0 },
        stated => stated,
    }
}

fn describe(view: View) -> String {
    match view {
        View::Oblique { azimuth, elevation } => format!("seen from azimuth {azimuth:.0}°, elevation {elevation:.0}°"),
        View::Perspective { azimuth, elevation } => {
            format!("in perspective from {azimuth:.0}°, {elevation:.0}° above")
        }
        View::Along { .. } => "seen along its axis".to_owned(),
        _ => "seen from above".to_owned(),
    }
}
