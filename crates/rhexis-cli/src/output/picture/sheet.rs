//! A sheet of panels: one body from several sides and at several moments, with one scale of colours.

use super::camera::{Area, Camera};
use super::canvas::{Anchor, Canvas, Line};
use super::scale::Scale;
use super::{BACKGROUND, View, describe, legend, pieces, resolve, surface, tips};
use glam::{DVec2, DVec3};
use rhexis::frame::{BodyFrame, SolidFrame};
use tiny_skia::Pixmap;

/// The target circle.
const CIRCLE: super::Rgba = [214, 20, 60, 255];
/// Height of a panel over its width: between these.
const SHAPE: [f64; 2] = [0.35, 1.4];
/// The side of a panel to which the lengths of the layout refer \[px\].
const REFERENCE: f64 = 700.0;

/// Above, the bitmap takes more than 1 GB.
const MOST_PIXELS: u64 = 64_000_000;

/// What panels show.
#[derive(Clone, Debug)]
pub(crate) struct Look {
    /// Width of a panel \[px\].
    pub side: u32,
    pub with_lines: bool,
    pub with_fibres: bool,
    pub with_tips: bool,
    /// Whether there is no title, caption and colour bar.
    pub is_bare: bool,
    /// Opacity of what lies turned over, 0 to 1.
    pub turned_opacity: f64,
    /// A closed line on the surface, and its name.
    pub circle: Option<(Vec<DVec3>, String)>,
}

/// A moment to be drawn.
pub(crate) struct Drawn<'a> {
    pub body: &'a BodyFrame,
    pub solids: &'a [SolidFrame],
    pub caption: String,
}

/// Panels that share views and colours over all their moments.
pub(crate) struct Sheet {
    look: Look,
    views: Vec<(View, Vec<DVec3>)>,
    scale: Scale,
    /// Height of each view's panel \[px\].
    heights: Vec<u32>,
    unit: f64,
}

impl Sheet {
    /// For these views of a body at these moments, framed so that nothing large leaves the frame at any of them.
    ///
    /// # Errors
    /// Where there is nothing to be seen.
    pub(crate) fn new(look: Look, views: &[View], bodies: &[&BodyFrame]) -> Result<Self, String> {
        let first = bodies.first().filter(|body| !body.triangles.is_empty()).ok_or("there are no triangles to show")?;
        let points: Vec<DVec3> = bodies.iter().flat_map(|body| pieces::framing(body)).collect();
        let views: Vec<(View, Vec<DVec3>)> = views.iter().map(|&view| (resolve(view, first), points.clone())).collect();
        let mut heights = Vec::new();
        for (view, points) in &views {
            let extent = Camera::extent(*view, points.iter().copied());
            if !(extent.is_finite() && extent.max_element() > 0.0) {
                return Err("the body has no extent that can be shown; check its positions".to_owned());
            }
            let shape = (extent.y / extent.x.max(f64::MIN_POSITIVE)).clamp(SHAPE[0], SHAPE[1]);
            heights.push((f64::from(look.side) * shape).round() as u32);
        }
        let unit = (f64::from(look.side) / REFERENCE).clamp(0.6, 2.5);
        Ok(Self { scale: Scale::new(None, bodies), look, views, heights, unit })
    }

    /// Width and height of a picture of so many columns and rows \[px\]; both even, as films want them.
    fn size(&self, columns: u32, rows: &[u32]) -> [u32; 2] {
        let width = f64::from(self.look.side * columns) + 2.0 * self.margin() + self.column();
        let height = self.top(rows, rows.len()) + self.foot();
        [width, height].map(|side| (side.ceil() as u32).next_multiple_of(2))
    }

    /// Where a row begins below others of these heights \[px\].
    fn top(&self, rows: &[u32], row: usize) -> f64 {
        self.head() + rows[..row].iter().map(|&height| f64::from(height) + self.captions()).sum::<f64>()
    }

    fn margin(&self) -> f64 {
        20.0 * self.unit
    }

    fn head(&self) -> f64 {
        if self.look.is_bare { self.margin() } else { 112.0 * self.unit }
    }

    /// Of a row: the caption above a panel and the scale bar below it.
    fn captions(&self) -> f64 {
        if self.look.is_bare { 44.0 * self.unit } else { 78.0 * self.unit }
    }

    fn foot(&self) -> f64 {
        if self.look.is_bare { 0.0 } else { self.margin() }
    }

    fn column(&self) -> f64 {
        if self.look.is_bare { 0.0 } else { 215.0 * self.unit }
    }

    /// Draws moments, each with its caption: a row per view where `is_strip`, else a column per view, of the one moment.
    ///
    /// # Errors
    /// Where there is no memory for it.
    pub(crate) fn draw(
        &self,
        moments: &[Drawn<'_>],
        is_strip: bool,
        title: &str,
        note: &str,
    ) -> Result<Pixmap, String> {
        let highest = [self.heights.iter().copied().max().unwrap_or(0)];
        let (columns, rows) = match is_strip {
            true => (moments.len() as u32, &self.heights[..]),
            false => (self.views.len() as u32, &highest[..]),
        };
        let [width, height] = self.size(columns, rows);
        let no_memory = || format!("no memory for {width} × {height} pixels; choose a smaller --size or fewer moments");
        if u64::from(width) * u64::from(height) > MOST_PIXELS {
            return Err(no_memory());
        }
        let mut canvas = Canvas::new(width, height, BACKGROUND).ok_or_else(no_memory)?;
        for (row, column) in (0..rows.len()).flat_map(|row| (0..columns).map(move |column| (row, column))) {
            let (view, moment) = if is_strip { (row, column as usize) } else { (column as usize, 0) };
            let left = self.margin() + f64::from(self.look.side * column);
            let corner = DVec2::new(left, self.top(rows, row));
            let is_first = !is_strip || column == 0;
            let Drawn { body, solids, caption } = &moments[moment];
            let caption = if is_strip && row == 0 { caption.as_str() } else { "" };
            self.panel(&mut canvas, corner, view, (body, solids), caption, is_first).ok_or_else(no_memory)?;
        }
        if !self.look.is_bare {
            legend::heading(&mut canvas, title, note, f64::from(width), self.unit);
            let column = DVec2::new(f64::from(width) - self.column(), self.head() + 8.0 * self.unit);
            // Notes and signs take some 150 px below it.
            let room = f64::from(height) - self.head() - 230.0 * self.unit;
            let bar = room.clamp(60.0 * self.unit, f64::from(self.look.side));
            let below = legend::color_bar(&mut canvas, &self.scale, column, bar, self.unit);
            let at = DVec2::new(column.x, below + 10.0 * self.unit);
            legend::signs(&mut canvas, &self.scale, self.look.with_fibres, None, at, self.unit);
        }
        canvas.finish().ok_or_else(no_memory)
    }

    /// One panel at its corner; `None` if there is no memory for it.
    fn panel(
        &self,
        canvas: &mut Canvas,
        corner: DVec2,
        view_number: usize,
        (body, solids): (&BodyFrame, &[SolidFrame]),
        caption: &str,
        is_first: bool,
    ) -> Option<()> {
        let unit = self.unit;
        let (view, points) = &self.views[view_number];
        let height = self.heights[view_number];
        let mut own = Canvas::new(self.look.side, height, BACKGROUND)?;
        let whole = Area { low: DVec2::ZERO, high: DVec2::new(f64::from(self.look.side), f64::from(height)) };
        let inner = Area { low: DVec2::splat(8.0 * unit), high: whole.high - 8.0 * unit };
        let camera = Camera::fitting(*view, points.iter().copied(), inner)?;
        let style = surface::Style {
            with_lines: self.look.with_lines,
            turned_opacity: self.look.turned_opacity,
            ..surface::Style::new(unit)
        };
        surface::draw(&mut own, &camera, (body, solids), &self.scale, whole, style);
        if self.look.with_fibres {
            surface::draw_fibres(&mut own, &camera, body, whole, [20, 16], unit);
        }
        if let Some((circle, _)) = &self.look.circle {
            let line: Vec<DVec2> = circle.iter().map(|&point| camera.project(point)).collect();
            own.stroke(&line, true, Line::new(5.0 * unit, [255, 255, 255, 150]));
            own.stroke(&line, true, Line::new(2.4 * unit, CIRCLE).dashed(9.0 * unit, 7.0 * unit));
        }
        if self.look.with_tips {
            for (_, tip) in tips::drawable(body) {
                let normal = tips::normal(body, tip, &camera);
                tips::draw(&mut own, &camera, tip, normal, whole, 60.0 * unit / tips::reach(tip), unit);
            }
        }
        let above = if self.look.is_bare { 0.0 } else { 34.0 * unit };
        let place = (corner + DVec2::new(0.0, above)).round();
        canvas.place(place.x as u32, place.y as u32, &own);
        if !caption.is_empty() && !self.look.is_bare {
            let at = corner + DVec2::new(0.5 * f64::from(self.look.side), 14.0 * unit);
            canvas.text(at, 22.0 * unit, Anchor::Middle, legend::INK, caption);
        }
        if is_first {
            let foot = place + DVec2::new(14.0 * unit, f64::from(height) + 20.0 * unit);
            let circle = self.look.circle.as_ref().map(|(_, name)| format!("; dashed: {name}")).unwrap_or_default();
            let words = format!("{}{circle}", describe(*view));
            // A panel of a film strip is narrow, and its neighbour's foot is free only in the same row.
            legend::scale_bar(canvas, &camera, foot, f64::from(self.look.side), &words, unit);
        }
        Some(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn body() -> BodyFrame {
        let mesh = rhexis::generate::grid(2.0, 1.0, 4, 2).unwrap();
        let count = mesh.triangles.len();
        BodyFrame {
            rest_positions: mesh.positions.clone(),
            positions: mesh.positions,
            stress: vec![glam::DMat3::ZERO; count],
            principal_stress: vec![DVec2::new(1.0, 0.0); count],
            fibres: vec![DVec3::X; count],
            triangles: mesh.triangles,
            ..BodyFrame::default()
        }
    }

    fn look() -> Look {
        Look {
            side: 120,
            with_lines: false,
            with_fibres: false,
            with_tips: true,
            is_bare: true,
            turned_opacity: 0.5,
            circle: None,
        }
    }

    #[test]
    fn a_strip_has_a_row_per_view_and_a_column_per_moment() {
        let body = body();
        let views = [View::Top, View::Perspective { azimuth: -70.0, elevation: 40.0 }];
        let sheet = Sheet::new(look(), &views, &[&body]).unwrap();
        let moments = ["a", "b", "c"].map(|caption| Drawn { body: &body, solids: &[], caption: caption.to_owned() });
        let strip = sheet.draw(&moments, true, "", "").unwrap();
        let still = sheet.draw(&moments[..1], false, "", "").unwrap();
        assert!(strip.width() > 3 * 120 && still.width() > 2 * 120 && still.width() < strip.width());
        assert!(strip.height() > still.height() && strip.height().is_multiple_of(2));
    }

    #[test]
    fn what_lies_turned_over_lets_what_is_beneath_it_through() {
        let mut folded = body();
        // The right half over the left, seen from its back.
        for p in folded.positions.iter_mut().filter(|p| p.x > 1.0) {
            *p = DVec3::new(2.0 - p.x, p.y, 0.01);
        }
        for t in 0..folded.triangles.len() {
            let is_right = folded.triangles[t].iter().any(|&v| folded.rest_positions[v as usize].x > 1.0);
            folded.principal_stress[t].x = if is_right { 1.0 } else { 0.0 };
        }
        let pixel = |turned_opacity: f64| {
            let sheet = Sheet::new(Look { turned_opacity, ..look() }, &[View::Top], &[&folded, &body()]).unwrap();
            let moment = Drawn { body: &folded, solids: &[], caption: String::new() };
            let drawn = sheet.draw(&[moment], false, "", "").unwrap();
            let colour = drawn.pixel(drawn.width() * 35 / 100, 40).unwrap();
            [colour.red(), colour.green(), colour.blue()]
        };
        let [opaque, half, none] = [1.0, 0.5, 0.0].map(pixel);
        assert!(opaque != half && half != none, "{opaque:?} {half:?} {none:?}");
        // Viridis: yellow on violet.
        assert!(opaque[0] > half[0] && half[0] > none[0] && none[2] > opaque[2], "{opaque:?} {half:?} {none:?}");
    }

    #[test]
    fn nothing_to_see_is_said() {
        assert!(Sheet::new(look(), &[View::Top], &[]).is_err());
        let mut point = body();
        point.positions.fill(DVec3::ONE);
        assert!(Sheet::new(look(), &[View::Top], &[&point]).is_err_and(|error| error.contains("extent")));
    }
}
