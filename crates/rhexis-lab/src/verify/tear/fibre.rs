//! Following the fibre: the tear of the notched square stays on the fibre line through the notch's end.

use super::super::{Artifacts, Line, Row, Rows, VerifyError, largest};
use super::square::{Square, Tissue};
use glam::DVec2;
use std::f64::consts::FRAC_PI_2;

pub(crate) fn run(out: &Artifacts) -> Result<Vec<Row>, VerifyError> {
    let mut rows = Rows::new("tear-fibre");
    // Three edges per averaging radius.
    let mesh = "{ grid = { width = 30, height = 30, nx = 76, ny = 64 } }";
    let scenes: &[&str] = if out.is_quick() { &["fig2-tear"] } else { &["fig2-tear", "fig2-tear-stable"] };
    for scene in scenes {
        let mut lines = Vec::new();
        for degrees in [30.0, 45.0, 60.0, 75.0, 90.0] {
            let path = torn(&mut rows, scene, mesh, Tissue::Fibres(degrees), degrees)?;
            lines.push(Line { name: format!("fibres at {degrees}°"), points: path });
        }
        // The pull is along x, so the largest principal stress opens a tear along y.
        let path = torn(&mut rows, scene, mesh, Tissue::Isotropic, 90.0)?;
        lines.push(Line { name: "isotropic".to_owned(), points: path });
        out.paths(&format!("tear-fibre-{scene}"), &format!("{scene}: paths by fibre angle"), &lines)?;
    }
    rows.finish()
}

/// Tears a square through; its tear shall be straight, at `degrees` to x.
fn torn(rows: &mut Rows, scene: &str, mesh: &str, tissue: Tissue, degrees: f64) -> Result<Vec<DVec2>, VerifyError> {
    let what = format!("{scene}, {}", tissue.name());
    let mut square = Square::new(scene, mesh, tissue, &["run.steps=300"])?;
    square.approach()?;
    let is_through = square.tear_through()?;
    let path = square.path();
    let line = DVec2::from_angle(degrees.to_radians());
    let &[tip, .., end] = &path[..] else {
        rows.add(format!("{what}: tears"), f64::NAN, 0.0, "1");
        return Ok(path);
    };
    let off = largest(path.iter().map(|p| line.perp_dot(*p - tip).abs()));
    rows.ratio(format!("{what}: not torn through"), f64::from(u8::from(!is_through)), 0.0);
    rows.add(format!("{what}: largest distance from the line"), off / square.edge, 1.0, "edge");
    let slope = line.angle_to(end - tip).abs();
    rows.add(format!("{what}: mean slope"), slope.min(2.0 * FRAC_PI_2 - slope).to_degrees(), 2.0, "°");
    Ok(path)
}
