//! Tear tips: the polar curve of the criterion and the directions around it, as in Figure 2 of Allard, Marchal and
//! Cotin (2009).

use super::Rgba;
use super::camera::{Area, Camera};
use super::canvas::{Canvas, Line, ring};
use glam::{DVec2, DVec3};
use rhexis::frame::{BodyFrame, TipFrame};
use std::f64::consts::TAU;

pub(super) const CURVE: Rgba = [214, 20, 60, 255];
const CURVE_FILL: Rgba = [255, 235, 235, 150];
pub(super) const PREVIOUS: Rgba = [15, 15, 20, 255];
pub(super) const THRESHOLD: Rgba = [15, 15, 20, 255];
pub(super) const DISC: Rgba = [0, 90, 220, 255];
pub(super) const FORCE: Rgba = [120, 60, 200, 255];
pub(super) const HALO: Rgba = [255, 255, 255, 230];

/// The tips that can be drawn, with their numbers.
pub(super) fn drawable(body: &BodyFrame) -> Vec<(usize, &TipFrame)> {
    body.tips.iter().enumerate().filter(|(_, tip)| tip.position.is_finite()).collect()
}

/// The tip nearest to tearing (or tearing most), and its number.
pub(super) fn foremost(body: &BodyFrame) -> Option<(usize, &TipFrame)> {
    let value = |tip: &TipFrame| if tip.value.is_nan() { f64::NEG_INFINITY } else { tip.value };
    // Of equal ones the first, so that a mirror tie does not depend on rounding of a sort.
    drawable(body).into_iter().reduce(|best, next| if value(next.1) > value(best.1) { next } else { best })
}

/// The largest radius the polar curve needs, in units of c; at least 1, so that the circle c = 1 fits as well.
pub(super) fn reach(tip: &TipFrame) -> f64 {
    let curve = tip.curve.iter().map(|(_, c)| *c);
    curve.chain([tip.value]).filter(|c| c.is_finite()).fold(1.0, f64::max)
}

/// Unit normal of the surface around a tip, towards the viewer.
pub(super) fn normal(body: &BodyFrame, tip: &TipFrame, camera: &Camera) -> DVec3 {
    let near = |x: [DVec3; 3]| {
        let middle = (x[0] + x[1] + x[2]) / 3.0;
        // Half as far again as the triangle reaches: the tip's own triangles are met even if R is below one edge.
        let size = x.iter().map(|x| x.distance(middle)).fold(0.0, f64::max);
        middle.distance(tip.position) <= (1.5 * size).max(tip.radius)
    };
    let sum: DVec3 = body
        .triangles
        .iter()
        .map(|corners| corners.map(|v| body.positions[v as usize]))
        .filter(|&x| near(x))
        .map(|[a, b, c]| (b - a).cross(c - a))
        .sum();
    let normal = sum.try_normalize().unwrap_or(camera.toward);
    if normal.dot(camera.toward) < 0.0 { -normal } else { normal }
}

/// Draws one tip. `unit` is the radius of c = 1 \[px\], `weight` the width of a thin line \[px\].
pub(super) fn draw(
    canvas: &mut Canvas,
    camera: &Camera,
    tip: &TipFrame,
    normal: DVec3,
    area: Area,
    unit: f64,
    weight: f64,
) {
    let middle = camera.project(tip.position);
    if !area.contains(middle) {
        return;
    }
    let toward = |d: DVec3, length: f64| middle + camera.along(d * length / camera.scale);
    let side = normal.any_orthonormal_vector();
    let circle = |radius: f64| -> Vec<DVec2> {
        let turn = |k: u32| f64::from(k) * TAU / 96.0;
        (0..96).map(|k| toward(side * turn(k).cos() + normal.cross(side) * turn(k).sin(), radius)).collect()
    };

    let radius = tip.radius * camera.scale;
    if radius.is_finite() && radius > 1.0 && radius < 2.0 * area.size().max_element() {
        canvas.stroke_haloed(&circle(radius), true, Line::new(1.5 * weight, DISC), HALO);
    }
    for run in runs(&tip.curve) {
        let mut points: Vec<DVec2> = run.points.iter().map(|&(d, c)| toward(d, unit * c.max(0.0))).collect();
        if !run.is_closed {
            points.push(middle);
        }
        canvas.fill(&points, CURVE_FILL, true);
        canvas.stroke_haloed(&points, true, Line::new(1.8 * weight, CURVE), HALO);
    }
    let threshold = circle(unit);
    canvas.stroke(&threshold, true, Line::new(2.6 * weight, [255, 255, 255, 150]));
    canvas.stroke(&threshold, true, Line::new(1.3 * weight, THRESHOLD).dashed(5.0 * weight, 4.0 * weight));

    if let Some(p) = tip.previous.filter(|p| p.is_finite()) {
        canvas.arrow(
            toward(-p, 1.05 * unit.max(20.0 * weight)),
            toward(-p, 7.0 * weight),
            Line::new(2.6 * weight, PREVIOUS),
            HALO,
        );
    }
    if let Some(force) = pull(tip) {
        // Wider than the chosen direction, which mostly lies on it.
        canvas.arrow(middle, toward(force, unit.max(16.0 * weight)), Line::new(6.0 * weight, FORCE), HALO);
    }
    if tip.direction.is_finite() && tip.direction != DVec3::ZERO && tip.value.is_finite() {
        let length = (unit * tip.value).max(16.0 * weight);
        canvas.arrow(middle, toward(tip.direction, length), Line::new(2.6 * weight, CURVE), HALO);
    }
    canvas.fill(&ring(middle, 5.5 * weight), [255, 255, 255, 255], true);
    canvas.disc(middle, 4.0 * weight, PREVIOUS);
}

/// The material force over the toughness along d*, where it decides: its part along d* is c². Drawn three radii of c = 1 long at most.
pub(super) fn pull(tip: &TipFrame) -> Option<DVec3> {
    let along = tip.material_force.dot(tip.direction);
    let scale = tip.value * tip.value / along;
    let is_drawn = tip.is_by_force && along > 0.0 && scale.is_finite() && tip.material_force.is_finite();
    is_drawn.then(|| (tip.material_force * scale).clamp_length_max(3.0))
}

/// A stretch of the polar curve without a gap.
struct Run {
    points: Vec<(DVec3, f64)>,
    is_closed: bool,
}

/// Splits the curve where neighbouring samples are far apart: what lies between was not admissible.
fn runs(curve: &[(DVec3, f64)]) -> Vec<Run> {
    let samples: Vec<(DVec3, f64)> = curve.iter().copied().filter(|(d, c)| d.is_finite() && c.is_finite()).collect();
    let mut steps: Vec<f64> = samples.windows(2).map(|w| w[0].0.angle_between(w[1].0)).collect();
    steps.sort_by(f64::total_cmp);
    let typical = steps.get(steps.len() / 2).copied().unwrap_or(0.0);
    let gap = (4.0 * typical).max(5_f64.to_radians());
    let is_near = |a: &(DVec3, f64), b: &(DVec3, f64)| a.0.angle_between(b.0) <= gap;

    let mut runs: Vec<Run> =
        samples.chunk_by(is_near).map(|points| Run { points: points.to_vec(), is_closed: false }).collect();
    if let [run] = runs.as_mut_slice() {
        run.is_closed = run.points.len() > 3 && is_near(&run.points[0], &run.points[run.points.len() - 1]);
    }
    runs
}

#[cfg(test)]
mod tests {
    use super::*;

    fn arc(degrees: impl Iterator<Item = i32>) -> Vec<(DVec3, f64)> {
        degrees.map(|a| (glam::DQuat::from_rotation_z(f64::from(a).to_radians()) * DVec3::X, 1.0)).collect()
    }

    #[test]
    fn a_whole_turn_is_closed_and_a_fan_is_not() {
        let turn = runs(&arc((0..360).step_by(3)));
        assert_eq!((turn.len(), turn[0].is_closed), (1, true));
        let fan = runs(&arc((-60..61).step_by(3)));
        assert_eq!((fan.len(), fan[0].is_closed), (1, false));
    }

    #[test]
    fn a_gap_splits_the_curve_and_what_is_no_number_is_left_out() {
        let mut curve = arc((0..60).step_by(2).chain((100..140).step_by(2)));
        assert_eq!(runs(&curve).iter().map(|r| r.points.len()).collect::<Vec<_>>(), [30, 20]);
        curve[3].1 = f64::NAN;
        assert_eq!(runs(&curve).iter().map(|r| r.points.len()).collect::<Vec<_>>(), [29, 20]);
        assert!(runs(&[]).is_empty());
    }
}
