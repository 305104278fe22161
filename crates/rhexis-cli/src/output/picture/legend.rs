//! What explains a picture: title, colour bar, scale bar, signs.

use super::Rgba;
use super::camera::{Area, Camera};
use super::canvas::{Anchor, Canvas, Line, ring};
use super::scale::{Scale, round_down, ticks};
use super::{surface, tips};
use glam::DVec2;
use rhexis::frame::TipFrame;

pub(super) const INK: Rgba = [25, 25, 30, 255];
const PALE_INK: Rgba = [95, 95, 105, 255];

/// Title and note, top left. `unit` is one pixel of the default size.
pub(super) fn heading(canvas: &mut Canvas, title: &str, note: &str, width: f64, unit: f64) {
    for (text, size, y, color) in [(title, 34.0, 50.0, INK), (note, 22.0, 92.0, PALE_INK)] {
        let room = width - 80.0 * unit;
        let wanted = canvas.text_width(size * unit, text);
        // A long name shrinks to the picture instead of leaving it.
        let size = size * unit * (room / wanted.max(1.0)).min(1.0);
        canvas.text(DVec2::new(40.0, y) * unit, size, Anchor::Left, color, text);
    }
}

/// The colour bar with ticks; returns the y below it.
pub(super) fn color_bar(canvas: &mut Canvas, scale: &Scale, at: DVec2, height: f64, unit: f64) -> f64 {
    let size = 21.0 * unit;
    for (row, text) in ["largest principal", "stress [MPa]"].into_iter().enumerate() {
        canvas.text(at + DVec2::new(0.0, row as f64 * 28.0 * unit), size, Anchor::Left, INK, text);
    }
    let top = at + DVec2::new(0.0, 60.0 * unit);
    let width = 40.0 * unit;
    let rows = height.round().max(1.0);
    for row in 0..rows as u32 {
        let value = scale.high - (scale.high - scale.low) * (f64::from(row) + 0.5) / rows;
        let (y, bottom) = (top.y + f64::from(row), top.y + f64::from(row) + 1.0);
        let strip = [(top.x, y), (top.x + width, y), (top.x + width, bottom), (top.x, bottom)].map(DVec2::from);
        canvas.fill(&strip, scale.color(value), false);
    }
    let frame = [(0.0, 0.0), (width, 0.0), (width, rows), (0.0, rows)].map(|p| top + DVec2::from(p));
    canvas.stroke(&frame, true, Line::new(1.5 * unit, INK));
    for (value, text) in ticks(scale.low, scale.high, 6.0) {
        let y = top.y + rows * (scale.high - value) / (scale.high - scale.low);
        let x = top.x + width;
        canvas.stroke(&[DVec2::new(x, y), DVec2::new(x + 8.0 * unit, y)], false, Line::new(1.5 * unit, INK));
        canvas.text(DVec2::new(x + 16.0 * unit, y), size, Anchor::Left, INK, &text);
    }
    let mut y = top.y + rows + 26.0 * unit;
    for note in &scale.notes {
        canvas.text(DVec2::new(top.x, y), 17.0 * unit, Anchor::Left, PALE_INK, note);
        y += 24.0 * unit;
    }
    y
}

/// A bar of a round length, and where the viewer stands.
pub(super) fn scale_bar(canvas: &mut Canvas, camera: &Camera, at: DVec2, room: f64, view: &str, unit: f64) {
    let length = round_down(0.25 * room / camera.scale);
    let end = at + DVec2::new(length * camera.scale, 0.0);
    let tick = DVec2::new(0.0, 8.0 * unit);
    let line = Line::new(3.0 * unit, INK);
    canvas.stroke(&[at, end], false, line);
    for p in [at, end] {
        canvas.stroke(&[p - tick, p + tick], false, line);
    }
    let text = format!("{} mm", trimmed(length));
    let size = 21.0 * unit;
    canvas.text(end + DVec2::new(16.0 * unit, 0.0), size, Anchor::Left, INK, &text);
    let after = end.x + canvas.text_width(size, &text) + 46.0 * unit;
    // As a heading, it shrinks to its room instead of leaving it.
    let wanted = canvas.text_width(19.0 * unit, view);
    let fit = ((at.x + room - after) / wanted.max(1.0)).clamp(0.5, 1.0);
    canvas.text(DVec2::new(after, at.y), 19.0 * unit * fit, Anchor::Left, PALE_INK, view);
}

/// A round number without needless zeros.
fn trimmed(value: f64) -> String {
    if (1e-4..1e5).contains(&value) { format!("{}", (value * 1e6).round() / 1e6) } else { format!("{value:e}") }
}

/// The signs on the picture, one row each: the fibres', and those of `tip`.
pub(super) fn signs(
    canvas: &mut Canvas,
    scale: &Scale,
    with_fibres: bool,
    tip: Option<&TipFrame>,
    at: DVec2,
    unit: f64,
) {
    let mut left = at;
    let mut row = |canvas: &mut Canvas, text: &str, draw: &dyn Fn(&mut Canvas, [DVec2; 2])| {
        draw(canvas, [left, left + DVec2::new(44.0 * unit, 0.0)]);
        canvas.text(left + DVec2::new(58.0 * unit, 0.0), 18.0 * unit, Anchor::Left, INK, text);
        // Seven rows at the most fit below the enlarged tip.
        left.y += 24.0 * unit;
    };
    if with_fibres {
        row(canvas, "fibre", &|canvas, [from, to]| {
            let half = DVec2::new(0.0, 9.0 * unit);
            let color = scale.color(0.5 * (scale.low + scale.high));
            canvas.fill(&[from - half, to - half, to + half, from + half], color, true);
            surface::draw_fibre(canvas, [from.lerp(to, 0.2), from.lerp(to, 0.8)], unit);
        });
    }
    let Some(tip) = tip else { return };
    row(canvas, "d*: largest criterion c", &|canvas, [from, to]| {
        canvas.arrow(from, to, Line::new(2.6 * unit, tips::CURVE), tips::HALO);
    });
    if tips::pull(tip).is_some() {
        row(canvas, "material force g/G_c", &|canvas, [from, to]| {
            canvas.arrow(from, to, Line::new(4.0 * unit, tips::FORCE), tips::HALO);
        });
    }
    row(canvas, "c(d), admissible directions", &|canvas, span| {
        canvas.stroke(&span, false, Line::new(2.4 * unit, tips::CURVE));
    });
    row(canvas, "c = 1: the tear advances", &|canvas, span| {
        canvas.stroke(&span, false, Line::new(1.8 * unit, tips::THRESHOLD).dashed(7.0 * unit, 5.0 * unit));
    });
    row(canvas, &format!("averaging radius R = {} mm", trimmed(tip.radius)), &|canvas, [from, to]| {
        canvas.stroke(&ring(from.midpoint(to), 9.0 * unit), true, Line::new(2.0 * unit, tips::DISC));
    });
    if tip.previous.is_some() {
        row(canvas, "previous direction p", &|canvas, [from, to]| {
            canvas.arrow(from, to, Line::new(2.6 * unit, tips::PREVIOUS), tips::HALO);
        });
    }
}

/// A frame around an area.
pub(super) fn frame(canvas: &mut Canvas, area: Area, width: f64) {
    let corners = [area.low, DVec2::new(area.high.x, area.low.y), area.high, DVec2::new(area.low.x, area.high.y)];
    canvas.stroke(&corners, true, Line::new(width, INK));
}
