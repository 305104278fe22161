//! Lines, shapes and text on a bitmap, in picture pixels with y downwards.

use super::Rgba;
use glam::DVec2;
use rhexis_lab::FONT;
use std::f64::consts::TAU;
use tiny_skia::{
    FillRule, FilterQuality, LineCap, LineJoin, Paint, Path, PathBuilder, Pixmap, PixmapPaint, Stroke, StrokeDash,
    Transform,
};
use ttf_parser::{Face, GlyphId, OutlineBuilder};

/// Everything is drawn at twice the size and averaged: neighbouring triangles are filled without blending (blending
/// would leave pale seams between them), so this is what smooths their edges.
const OVERSAMPLING: f32 = 2.0;

/// How a line is drawn.
#[derive(Clone, Copy)]
pub(super) struct Line {
    /// Width \[px\].
    pub width: f64,
    /// Colour.
    pub color: Rgba,
    /// Length of dashes and of the gaps between them \[px\].
    pub dash: Option<[f64; 2]>,
}

impl Line {
    pub(super) fn new(width: f64, color: Rgba) -> Self {
        Self { width, color, dash: None }
    }

    pub(super) fn dashed(self, dash: f64, gap: f64) -> Self {
        Self { dash: Some([dash, gap]), ..self }
    }
}

/// Where a text's position is on it.
#[derive(Clone, Copy)]
pub(super) enum Anchor {
    Left,
    Middle,
}

pub(super) struct Canvas {
    pixels: Pixmap,
    font: Face<'static>,
}

impl Canvas {
    /// `None` if there is no memory for the size or the font does not parse.
    pub(super) fn new(width: u32, height: u32, background: Rgba) -> Option<Self> {
        let factor = OVERSAMPLING as u32;
        let mut pixels = Pixmap::new(width.checked_mul(factor)?, height.checked_mul(factor)?)?;
        pixels.fill(paint_color(background));
        Some(Self { pixels, font: Face::parse(FONT, 0).ok()? })
    }

    /// Fills a polygon; `smooth` blends its rim.
    pub(super) fn fill(&mut self, corners: &[DVec2], color: Rgba, smooth: bool) {
        if let Some(path) = path(corners, true) {
            self.fill_path(&path, color, smooth);
        }
    }

    pub(super) fn stroke(&mut self, points: &[DVec2], closed: bool, line: Line) {
        if let Some(path) = path(points, closed) {
            self.stroke_path(&path, line);
        }
    }

    /// A line with a wider pale one beneath it, so that it reads on every colour.
    pub(super) fn stroke_haloed(&mut self, points: &[DVec2], closed: bool, line: Line, halo: Rgba) {
        self.stroke(points, closed, Line { width: line.width * 2.2, color: halo, dash: None });
        self.stroke(points, closed, line);
    }

    pub(super) fn disc(&mut self, middle: DVec2, radius: f64, color: Rgba) {
        self.fill(&ring(middle, radius), color, true);
    }

    /// An arrow with a filled head, haloed.
    pub(super) fn arrow(&mut self, from: DVec2, to: DVec2, line: Line, halo: Rgba) {
        let along = (to - from).normalize_or_zero();
        let head = (4.2 * line.width).min((to - from).length());
        let neck = to - along * head;
        let side = along.perp() * head * 0.48;
        let corners = [to, neck + side, neck + along * head * 0.18, neck - side];
        let edge = Line::new(line.width * 1.2, halo);
        self.stroke(
            &[from, neck + along * head * 0.3],
            false,
            Line { width: line.width * 2.2, color: halo, dash: None },
        );
        self.stroke(&corners, true, edge);
        self.stroke(&[from, neck + along * head * 0.3], false, line);
        self.fill(&corners, line.color, true);
    }

    /// Writes one line of text with its vertical middle (of lower-case letters) at `at`.
    pub(super) fn text(&mut self, at: DVec2, size: f64, anchor: Anchor, color: Rgba, text: &str) {
        let start = match anchor {
            Anchor::Left => at,
            Anchor::Middle => at - DVec2::new(0.5 * self.text_width(size, text), 0.0),
        };
        let scale = self.text_scale(size);
        let mut outline = Outline {
            builder: PathBuilder::new(),
            scale: scale as f32,
            x: start.x as f32,
            y: (start.y + 0.5 * scale * self.x_height()) as f32,
        };
        for c in text.chars() {
            let glyph = self.glyph(c);
            // A glyph without an outline is a blank.
            let _ = self.font.outline_glyph(glyph, &mut outline);
            outline.x += self.advance(glyph) * scale as f32;
        }
        if let Some(path) = outline.builder.finish() {
            self.fill_path(&path, color, true);
        }
    }

    pub(super) fn text_width(&self, size: f64, text: &str) -> f64 {
        text.chars().map(|c| f64::from(self.advance(self.glyph(c)))).sum::<f64>() * self.text_scale(size)
    }

    /// Lays a finished canvas over this one.
    pub(super) fn place(&mut self, x: u32, y: u32, other: &Self) {
        let factor = OVERSAMPLING as i32;
        let (x, y) = (x.min(1 << 20) as i32 * factor, y.min(1 << 20) as i32 * factor);
        let paint = PixmapPaint::default();
        self.pixels.draw_pixmap(x, y, other.pixels.as_ref(), &paint, Transform::identity(), None);
    }

    /// The picture at its true size; `None` if there is no memory for it.
    pub(super) fn finish(self) -> Option<Pixmap> {
        let factor = OVERSAMPLING as u32;
        let mut small = Pixmap::new(self.pixels.width() / factor, self.pixels.height() / factor)?;
        // Bilinear sampling at exactly one half is the average of two by two pixels.
        let paint = PixmapPaint { quality: FilterQuality::Bilinear, ..PixmapPaint::default() };
        let shrink = Transform::from_scale(1.0 / OVERSAMPLING, 1.0 / OVERSAMPLING);
        small.draw_pixmap(0, 0, self.pixels.as_ref(), &paint, shrink, None);
        Some(small)
    }

    fn fill_path(&mut self, path: &Path, color: Rgba, smooth: bool) {
        let mut paint = Paint { anti_alias: smooth, ..Paint::default() };
        paint.set_color(paint_color(color));
        self.pixels.fill_path(path, &paint, FillRule::Winding, enlarge(), None);
    }

    fn stroke_path(&mut self, path: &Path, line: Line) {
        let mut paint = Paint::default();
        paint.set_color(paint_color(line.color));
        let stroke = Stroke {
            width: line.width as f32,
            line_cap: if line.dash.is_some() { LineCap::Butt } else { LineCap::Round },
            line_join: LineJoin::Round,
            dash: line.dash.and_then(|[dash, gap]| StrokeDash::new(vec![dash as f32, gap as f32], 0.0)),
            ..Stroke::default()
        };
        self.pixels.stroke_path(path, &paint, &stroke, enlarge(), None);
    }

    fn text_scale(&self, size: f64) -> f64 {
        size / f64::from(self.font.units_per_em())
    }

    /// Height of a lower-case letter, measured on the x: the font's own table may lack it.
    fn x_height(&self) -> f64 {
        self.font.glyph_bounding_box(self.glyph('x')).map_or(0.0, |b| f64::from(b.y_max))
    }

    fn glyph(&self, c: char) -> GlyphId {
        self.font.glyph_index(c).unwrap_or_default()
    }

    fn advance(&self, glyph: GlyphId) -> f32 {
        f32::from(self.font.glyph_hor_advance(glyph).unwrap_or(0))
    }
}

/// A circle as a polygon.
pub(super) fn ring(middle: DVec2, radius: f64) -> Vec<DVec2> {
    (0..96).map(|k| middle + radius * DVec2::from_angle(f64::from(k) * TAU / 96.0)).collect()
}

fn enlarge() -> Transform {
    Transform::from_scale(OVERSAMPLING, OVERSAMPLING)
}

fn paint_color([r, g, b, a]: Rgba) -> tiny_skia::Color {
    tiny_skia::Color::from_rgba8(r, g, b, a)
}

fn path(points: &[DVec2], closed: bool) -> Option<Path> {
    let (first, rest) = points.split_first()?;
    let mut builder = PathBuilder::new();
    builder.move_to(first.x as f32, first.y as f32);
    for p in rest {
        builder.line_to(p.x as f32, p.y as f32);
    }
    if closed {
        builder.close();
    }
    builder.finish()
}

/// Glyph outlines (font units, y upwards) as a path at a place.
struct Outline {
    builder: PathBuilder,
    scale: f32,
    x: f32,
    y: f32,
}

impl Outline {
    fn at(&self, x: f32, y: f32) -> (f32, f32) {
        (self.x + self.scale * x, self.y - self.scale * y)
    }
}

impl OutlineBuilder for Outline {
    fn move_to(&mut self, x: f32, y: f32) {
        let (x, y) = self.at(x, y);
        self.builder.move_to(x, y);
    }

    fn line_to(&mut self, x: f32, y: f32) {
        let (x, y) = self.at(x, y);
        self.builder.line_to(x, y);
    }

    fn quad_to(&mut self, x1: f32, y1: f32, x: f32, y: f32) {
        let ((x1, y1), (x, y)) = (self.at(x1, y1), self.at(x, y));
        self.builder.quad_to(x1, y1, x, y);
    }

    fn curve_to(&mut self, x1: f32, y1: f32, x2: f32, y2: f32, x: f32, y: f32) {
        let ((x1, y1), (x2, y2), (x, y)) = (self.at(x1, y1), self.at(x2, y2), self.at(x, y));
        self.builder.cubic_to(x1, y1, x2, y2, x, y);
    }

    fn close(&mut self) {
        self.builder.close();
    }
}
