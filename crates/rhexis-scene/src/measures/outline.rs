//! Figures of an opening's outline that its area and its length do not tell: spikes, and how far an optic's edge is covered.
//!
//! | figure | definition | source |
//! |---|---|---|
//! | spikes | runs of directions from the centroid in which the outline lies beyond its smoothed radius, somewhere by more than 5 % of the mean radius; smoothed is the mean over ±30° | Privett et al. 2010, J Cataract Refract Surg 36:1835: spikes tell experts from novices; the limits are our own |
//! | covered part | part of the circumference of an optic about the axis that lies outside the opening, as it is seen along the axis | overlap all round is the aim of a rhexis |
//! | smallest overlap | from the outline's farthest point to the optic's edge along a radius, negative where that point lies beyond the edge | |
//!
//! An ellipse has no spikes up to an axis ratio of 1.4: those of a longer one are its ends. The seam of a tear that comes back within 5 % of its
//! own beginning is no spike.

use super::opening::{Axis, edges};
use glam::{DVec2, DVec3};
use rhexis::math::elementary;
use std::f64::consts::TAU;

/// Directions in which a radius is taken: one every half degree.
const RAYS: usize = 720;

/// Directions on either side that the smoothed radius is the mean of: 30°.
const NEIGHBOURS: usize = 60;

/// Excess of a spike over the smoothed radius, as a part of the mean radius.
const SPIKE: f64 = 0.05;

/// Angle between an edge's end and a direction that still counts as met \[directions\].
const ROUNDING: f64 = 1e-9;

/// How far the capsule covers the edge of an optic that is centred on the axis.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "snapshot", derive(serde::Serialize, serde::Deserialize))]
pub struct OpticOverlap {
    /// Part of the optic's circumference outside the opening.
    pub covered: f64,
    /// Smallest overlap along a radius \[mm\].
    pub smallest: f64,
}

impl OpticOverlap {
    /// The overlap of a closed outline \[mm\], whose last point is joined to the first, with an optic of this diameter \[mm\].
    pub fn from_outline(outline: &[DVec3], axis: &Axis, diameter: f64) -> Self {
        let points = seen_along(outline, axis);
        let radius = 0.5 * diameter;
        let mut crossings: Vec<f64> = edges(&points).flat_map(|(a, b)| crossings(a, b, radius)).collect();
        crossings.sort_by(f64::total_cmp);
        let first = crossings.first().copied().unwrap_or(0.0);
        let ends = crossings.iter().copied().skip(1).chain([first + TAU]);
        let begins = std::iter::once(first).chain(crossings.iter().copied().skip(1));
        let is_covered =
            |&(begin, end): &(f64, f64)| !contains(&points, radius * elementary::unit_at(0.5 * (begin + end)));
        let covered: f64 = begins.zip(ends).filter(is_covered).map(|(begin, end)| end - begin).sum();
        let farthest = points.iter().map(|point| point.length()).fold(0.0, f64::max);
        Self { covered: covered / TAU, smallest: radius - farthest }
    }
}

/// Number of spikes of a closed outline \[mm\], whose last point is joined to the first; none for one without area.
pub fn spikes(outline: &[DVec3]) -> u32 {
    let Some(axis) = Axis::from_outline(outline) else { return 0 };
    let radii = radii(&seen_along(outline, &axis));
    let mean = radii.iter().sum::<f64>() / RAYS as f64;
    let window = 2 * NEIGHBOURS + 1;
    let excess = |ray: usize| {
        let about = (0..window).map(|k| radii[(ray + RAYS + k - NEIGHBOURS) % RAYS]);
        radii[ray] - about.sum::<f64>() / window as f64
    };
    let mut excesses: Vec<f64> = (0..RAYS).map(excess).collect();
    // A run may go over the first direction.
    let start = excesses.iter().position(|&excess| excess <= 0.0).unwrap_or(0);
    excesses.rotate_left(start);
    let is_spike = |run: &&[f64]| run.iter().any(|&excess| excess > SPIKE * mean);
    excesses.split(|&excess| excess <= 0.0).filter(is_spike).count() as u32
}

/// Points in the plane across an axis, from it.
fn seen_along(outline: &[DVec3], axis: &Axis) -> Vec<DVec2> {
    let right = axis.direction.any_orthonormal_vector();
    let up = axis.direction.cross(right);
    let seen = |&point: &DVec3| DVec2::new((point - axis.point).dot(right), (point - axis.point).dot(up));
    outline.iter().map(seen).collect()
}

/// Distance of the farthest place of an outline in every direction; zero in directions without one.
fn radii(points: &[DVec2]) -> Vec<f64> {
    let mut radii = vec![0.0_f64; RAYS];
    let step = TAU / RAYS as f64;
    for (a, b) in edges(points) {
        let start = elementary::atan2(a.y, a.x);
        let end = start + elementary::turn(a, b);
        let (from, to) = (start.min(end) / step - ROUNDING, start.max(end) / step + ROUNDING);
        for ray in from.ceil() as i64..=to.floor() as i64 {
            let place = &mut radii[ray.rem_euclid(RAYS as i64) as usize];
            // An edge along the ray has no place of its own: not a number, which is passed over.
            *place = place.max(a.perp_dot(b) / elementary::unit_at(ray as f64 * step).perp_dot(b - a));
        }
    }
    radii
}

/// Angles \[rad\] at which the line from one point to another crosses a circle about the origin.
fn crossings(a: DVec2, b: DVec2, radius: f64) -> impl Iterator<Item = f64> {
    let way = b - a;
    let (square, half) = (way.length_squared(), a.dot(way));
    let root = (half * half - square * (a.length_squared() - radius * radius)).sqrt();
    let parts = [-1.0, 1.0].map(|sign| (sign * root - half) / square);
    // Parts of a line that misses the circle, and of one without length, are no numbers.
    parts.into_iter().filter(|part| (0.0..1.0).contains(part)).map(move |part| {
        let at = a + part * way;
        elementary::atan2(at.y, at.x)
    })
}

/// Whether a point lies within a closed outline, by the number of edges to its right.
fn contains(points: &[DVec2], at: DVec2) -> bool {
    let is_right = |&(a, b): &(DVec2, DVec2)| {
        (a.y > at.y) != (b.y > at.y) && a.x + (at.y - a.y) / (b.y - a.y) * (b.x - a.x) > at.x
    };
    edges(points).filter(is_right).count() % 2 == 1
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::PI;

    const POLE: Axis = Axis { point: DVec3::ZERO, direction: DVec3::Z };

    /// An outline by its number of points and its radius over the angle, about a centre.
    fn outline(count: u32, centre: DVec3, radius: impl Fn(f64) -> f64) -> Vec<DVec3> {
        let angles = (0..count).map(|i| TAU * f64::from(i) / f64::from(count));
        angles.map(|angle| centre + radius(angle) * DVec3::new(angle.cos(), angle.sin(), 0.0)).collect()
    }

    /// The radius of an ellipse over the angle, by its half axes.
    fn ellipse(a: f64, b: f64) -> impl Fn(f64) -> f64 {
        move |angle| a * b / (b * angle.cos()).hypot(a * angle.sin())
    }

    /// A circle with teeth of a height and a half width \[°\], as roofs.
    fn toothed(count: u32, height: f64, half_width: f64) -> impl Fn(f64) -> f64 {
        move |angle| {
            let pitch = TAU / f64::from(count);
            let from_middle = ((angle / pitch).fract() - 0.5).abs() * pitch;
            2.5 * (1.0 + height * (1.0 - from_middle / half_width.to_radians()).max(0.0))
        }
    }

    #[test]
    fn every_tooth_is_a_spike_and_no_round_shape_has_any() {
        let place = DVec3::new(0.3, -0.2, 1.0);
        assert_eq!(spikes(&outline(300, place, |_| 2.5)), 0);
        for ratio in [1.1, 1.2, 1.3, 1.4] {
            assert_eq!(spikes(&outline(300, place, ellipse(2.5 * ratio, 2.5))), 0, "{ratio}");
        }
        for count in 1..=8 {
            assert_eq!(spikes(&outline(1440, place, toothed(count, 0.12, 8.0))), count);
        }
        // Clockwise, turned out of the plane and begun at any point of a tooth.
        let turn = glam::DQuat::from_rotation_x(0.6);
        let mut turned: Vec<DVec3> = outline(1440, place, toothed(3, 0.12, 8.0)).iter().map(|&p| turn * p).collect();
        turned.reverse();
        for _ in 0..16 {
            turned.rotate_left(90);
            assert_eq!(spikes(&turned), 3);
        }
    }

    #[test]
    fn edges_of_a_mesh_are_no_spikes() {
        // Points that stand out and back by half an edge in turn, edges of a tenth and a twentieth of the radius.
        for count in [60_u32, 120] {
            let half = 0.5 * TAU / f64::from(count);
            let jagged = |angle: f64| {
                let number = (angle / TAU * f64::from(count)).round() as u32;
                2.5 * (1.0 + if number.is_multiple_of(2) { 0.5 } else { -0.5 } * half)
            };
            assert_eq!(spikes(&outline(count, DVec3::ZERO, jagged)), 0, "{count}");
        }
        assert_eq!(spikes(&outline(4, DVec3::ZERO, |_| 0.0)), 0);
        assert_eq!(spikes(&[]), 0);
    }

    #[test]
    fn a_notch_inwards_and_a_low_bump_are_no_spikes() {
        assert_eq!(spikes(&outline(1440, DVec3::ZERO, toothed(1, -0.2, 8.0))), 0);
        assert_eq!(spikes(&outline(1440, DVec3::ZERO, toothed(1, 0.04, 8.0))), 0);
    }

    #[test]
    fn the_overlap_of_circles_is_that_of_their_closed_form() {
        // A polygon of 4000 chords lies 8e-7 of its radius within its circle.
        let opening = |shift: f64, radius: f64| outline(4000, DVec3::new(0.0, shift, 0.3), move |_| radius);
        let concentric = OpticOverlap::from_outline(&opening(0.0, 2.5), &POLE, 6.0);
        assert_eq!(concentric.covered, 1.0);
        assert!((concentric.smallest - 0.5).abs() < 1e-12);
        assert_eq!(OpticOverlap::from_outline(&opening(0.0, 3.2), &POLE, 6.0).covered, 0.0);
        for (shift, radius) in [(0.6, 2.7), (1.0, 2.2), (-0.5, 3.1), (0.2, 2.5)] {
            let found = OpticOverlap::from_outline(&opening(shift, radius), &POLE, 6.0);
            // The edge is bare within the angle from the shift at which both circles meet.
            let shift = shift.abs();
            let meets = (9.0 + shift * shift - radius * radius) / (6.0 * shift);
            let bare = if meets < 1.0 { meets.acos() / PI } else { 0.0 };
            assert!((found.covered - (1.0 - bare)).abs() < 1e-5, "{found:?} {bare}");
            assert!((found.smallest - (3.0 - radius - shift)).abs() < 1e-5, "{found:?}");
        }
    }

    #[test]
    fn an_optic_seen_through_a_square_is_bare_in_its_corners() {
        // A circle of radius r about a square of half side s is within it where |cos| and |sin| are below s/r.
        let square: Vec<DVec3> =
            [(1.0, 1.0), (-1.0, 1.0), (-1.0, -1.0), (1.0, -1.0)].map(|(x, y)| 2.5 * DVec3::new(x, y, 0.0)).into();
        let found = OpticOverlap::from_outline(&square, &POLE, 6.0);
        let covered = 4.0 * 2.0 * (2.5_f64 / 3.0).acos() / TAU;
        assert!((found.covered - covered).abs() < 1e-12, "{found:?} {covered}");
        assert!((found.smallest - (3.0 - 2.5 * 2_f64.sqrt())).abs() < 1e-12);
    }
}
