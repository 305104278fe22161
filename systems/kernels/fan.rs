//! The chart of a fan: the triangles around a vertex, laid out in a plane.
//!
//! A flat fan is its own chart: with normal +z the axes are exactly x and y. Around a vertex of a curved surface the
//! angles of the triangles are laid side by side in the tangent plane. An open fan keeps them exactly and is turned so
//! that its middle is not distorted; a closed one is stretched to the full circle evenly.

use crate::math::elementary;
use glam::{DVec2, DVec3};
use smallvec::SmallVec;
use std::f64::consts::{PI, TAU};

/// A fan whose spokes leave one plane by less than this, relative to their lengths, is flat: some roundings of positions.
const FLAT_FAN: f64 = 1e-12;

/// The chart. Directions in it are unit vectors; offsets are in mm.
#[derive(Clone, Debug)]
pub struct FanChart {
    axes: [DVec3; 2],
    /// One more than sectors; in a closed fan the last is the first again, a turn later.
    spokes: SmallVec<[Spoke; 14]>,
    /// Chart angle per angle on the surface; 1 unless the fan is closed and curved.
    stretch: f64,
    is_closed: bool,
    is_flat: bool,
}

#[derive(Clone, Copy, Debug)]
struct Spoke {
    offset: DVec3,
    planar: DVec2,
    angle: f64,
}

/// Where a ray from the vertex leaves the fan.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Exit {
    /// The sector that the ray crosses; it lies between spokes `sector` and `sector + 1`.
    pub sector: usize,
    /// Position on the opposite edge, from 0 at the end of spoke `sector` to 1 at the end of the next.
    pub along: f64,
    /// Way to the opposite edge \[mm\].
    pub distance: f64,
}

impl FanChart {
    /// The chart of a fan from its spokes \[mm\], as offsets from the vertex, counter-clockwise. An open fan has one spoke
    /// more than sectors. `None` where a sector has no area or the fan has no normal.
    pub fn new(spokes: &[DVec3], is_closed: bool) -> Option<Self> {
        let mut offsets: SmallVec<[DVec3; 14]> = spokes.into();
        if is_closed {
            offsets.push(*spokes.first()?);
        }
        if offsets.len() < 2 {
            return None;
        }
        let crosses = offsets.windows(2).map(|s| s[0].cross(s[1]));
        let normal = crosses.clone().sum::<DVec3>().try_normalize()?;
        let e1 = axis_in_plane(normal);
        let axes = [e1, normal.cross(e1)];
        let is_flat = offsets.iter().all(|s| s.dot(normal).abs() <= FLAT_FAN * s.length());

        let mut turns: SmallVec<[f64; 14]> = SmallVec::new();
        let mut turn = 0.0;
        turns.push(turn);
        for (pair, cross) in offsets.windows(2).zip(crosses) {
            let area = cross.length();
            if !area.is_normal() {
                return None;
            }
            turn += elementary::atan2(area, pair[0].dot(pair[1]));
            turns.push(turn);
        }
        let stretch = if is_closed && !is_flat { TAU / turn } else { 1.0 };
        let project = |v: DVec3| DVec2::new(v.dot(axes[0]), v.dot(axes[1]));
        let zero = if is_flat {
            elementary::angle_of(project(offsets[0]))
        } else if is_closed {
            mean_difference(offsets.iter().zip(&turns).map(|(&s, &t)| elementary::angle_of(project(s)) - t * stretch))
        } else {
            elementary::angle_of(project(turned(&offsets, &turns, 0.5 * turn))) - 0.5 * turn
        };
        let laid_out = offsets.iter().zip(&turns).map(|(&offset, &t)| {
            let angle = zero + t * stretch;
            let planar = if is_flat { project(offset) } else { elementary::unit_at(angle) * offset.length() };
            Spoke { offset, planar, angle }
        });
        let mut spokes: SmallVec<[Spoke; 14]> = laid_out.collect();
        if is_closed {
            // A turn later is the same direction: no gap of a rounding between the last sector and the first.
            spokes[turns.len() - 1].planar = spokes[0].planar;
        }
        Some(Self { axes, spokes, stretch, is_closed, is_flat })
    }

    /// The axes of the chart in the rest shape: unit vectors of the tangent plane.
    pub fn axes(&self) -> [DVec3; 2] {
        self.axes
    }

    /// Whether the fan surrounds the vertex, so that every direction lies in it.
    pub fn is_closed(&self) -> bool {
        self.is_closed
    }

    /// Chart angles \[rad\] of the first and the last spoke: the sector of admissible directions, from one face of the tear
    /// to the other. A full turn for a closed fan.
    pub fn range(&self) -> (f64, f64) {
        (self.spokes[0].angle, self.spokes[self.spokes.len() - 1].angle)
    }

    /// Number of spokes; of a closed fan the first is counted twice.
    pub fn spoke_count(&self) -> usize {
        self.spokes.len()
    }

    /// Chart angle \[rad\] of a spoke.
    ///
    /// # Panics
    /// If there is no such spoke.
    pub fn angle(&self, index: usize) -> f64 {
        self.spokes[index].angle
    }

    /// Chart position \[mm\] of the end of a spoke, from the vertex.
    ///
    /// # Panics
    /// If there is no such spoke.
    pub fn spoke(&self, index: usize) -> DVec2 {
        self.spokes[index].planar
    }

    /// The sector in which a direction lies, if any.
    pub fn sector(&self, direction: DVec2) -> Option<usize> {
        (0..self.spokes.len() - 1).find(|&i| {
            let (a, b) = (self.spokes[i].planar, self.spokes[i + 1].planar);
            a.perp_dot(direction) >= 0.0 && direction.perp_dot(b) >= 0.0
        })
    }

    /// Where the ray in a unit direction leaves the fan; `None` where the direction lies outside it.
    pub fn exit(&self, direction: DVec2) -> Option<Exit> {
        let sector = self.sector(direction)?;
        let (a, b, direction) = self.unstretched(sector, direction);
        let (to_a, to_b) = (a.perp_dot(direction), direction.perp_dot(b));
        let along = to_a / (to_a + to_b);
        let distance = a.perp_dot(b) / direction.perp_dot(b - a);
        (along.is_finite() && distance > 0.0).then_some(Exit { sector, along: along.clamp(0.0, 1.0), distance })
    }

    /// The unit direction in the rest shape, tangent to the triangle in which it lies; outside an open fan tangent to
    /// the chart.
    pub fn to_surface(&self, direction: DVec2) -> DVec3 {
        let plain = self.axes[0] * direction.x + self.axes[1] * direction.y;
        if self.is_flat {
            return plain;
        }
        let Some(sector) = self.sector(direction) else { return plain };
        let (a, b, direction) = self.unstretched(sector, direction);
        // Components along the two spokes of the sector.
        let area = a.perp_dot(b);
        let (p, q) = (direction.perp_dot(b) / area, a.perp_dot(direction) / area);
        (self.spokes[sector].offset * p + self.spokes[sector + 1].offset * q).normalize_or(plain)
    }

    /// The chart's unit direction of a direction in the rest shape; zero for one along the normal.
    pub fn to_chart(&self, direction: DVec3) -> DVec2 {
        let project = |v: DVec3| DVec2::new(v.dot(self.axes[0]), v.dot(self.axes[1]));
        let plain = project(direction).normalize_or_zero();
        if self.is_flat {
            return plain;
        }
        let sector = self.spokes.windows(2).position(|s| {
            let (a, b) = (project(s[0].offset), project(s[1].offset));
            a.perp_dot(plain) >= 0.0 && plain.perp_dot(b) >= 0.0
        });
        let Some(sector) = sector else { return plain };
        let (a, b) = (self.spokes[sector].offset, self.spokes[sector + 1].offset);
        let across = a.cross(b).cross(a).normalize_or_zero();
        let turn = elementary::atan2(direction.dot(across), direction.dot(a) / a.length());
        elementary::unit_at(self.spokes[sector].angle + turn * self.stretch)
    }

    /// The two spokes of a sector and a direction in it, in axes in which the sector has its true angle.
    fn unstretched(&self, sector: usize, direction: DVec2) -> (DVec2, DVec2, DVec2) {
        let (a, b) = (self.spokes[sector], self.spokes[sector + 1]);
        if self.stretch == 1.0 {
            return (a.planar, b.planar, direction);
        }
        let turn = (b.angle - a.angle) / self.stretch;
        let part = elementary::turn(a.planar, direction) / self.stretch;
        (DVec2::X * a.offset.length(), elementary::unit_at(turn) * b.offset.length(), elementary::unit_at(part))
    }
}

/// A unit vector normal to `normal`, and as near to the x axis as there is; near y where the normal is along x.
fn axis_in_plane(normal: DVec3) -> DVec3 {
    let along = if normal.x.abs() < 0.9 { DVec3::X } else { DVec3::Y };
    (along - normal * normal.dot(along)).normalize()
}

/// The mean of angles that agree up to whole turns and small differences.
fn mean_difference(angles: impl Iterator<Item = f64>) -> f64 {
    let (mut first, mut sum, mut count) = (None, 0.0, 0.0);
    for angle in angles {
        let base = *first.get_or_insert(angle);
        sum += base + (angle - base + PI).rem_euclid(TAU) - PI;
        count += 1.0;
    }
    sum / count
}

/// The unit direction that lies `turn` from the first spoke, in the triangle there.
fn turned(offsets: &[DVec3], turns: &[f64], turn: f64) -> DVec3 {
    let sector = turns.windows(2).position(|t| turn <= t[1]).unwrap_or(0);
    let a = offsets[sector].normalize();
    let across = a.cross(offsets[sector + 1]).cross(a).normalize_or_zero();
    let part = turn - turns[sector];
    a * elementary::cos(part) + across * elementary::sin(part)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Spokes on a cone of slope `rise`, from angle 0 on.
    fn spokes(angles: &[f64], rise: f64) -> Vec<DVec3> {
        angles.iter().map(|a| DVec3::new(a.cos(), a.sin(), -rise) * (1.0 + 0.2 * (3.0 * a).sin())).collect()
    }

    #[test]
    fn a_flat_fan_is_its_own_chart() {
        let chart = FanChart::new(&spokes(&[-3.1, -2.0, -1.0, 0.2, 1.4, 2.5, 3.1], 0.0), false).unwrap();
        assert_eq!(chart.axes(), [DVec3::X, DVec3::Y]);
        let d = DVec2::from_angle(0.7);
        assert_eq!(chart.to_surface(d), d.extend(0.0));
        assert_eq!(chart.sector(d), Some(3));
        assert!((chart.to_chart(d.extend(0.0)) - d).length() < 1e-15);
        assert_eq!(chart.sector(DVec2::NEG_X), None, "the wedge behind a tear's tip lies outside");
        let (first, last) = chart.range();
        assert!((first + 3.1).abs() < 1e-14 && (last - 3.1).abs() < 1e-14);
    }

    #[test]
    fn an_exit_lies_on_the_ray_and_on_the_edge() {
        for rise in [0.0, 0.2] {
            for (is_closed, ends) in [(true, [0.0, 1.0, 2.1, 3.3, 4.0, 5.2]), (false, [0.0, 1.0, 2.1, 3.3, 4.0, 4.9])] {
                let ends = spokes(&ends, rise);
                let chart = FanChart::new(&ends, is_closed).unwrap();
                let (from, to) = chart.range();
                for k in 0..100 {
                    let d = DVec2::from_angle(from + (to - from) * (k as f64 + 0.5) / 100.0);
                    let exit = chart.exit(d).unwrap();
                    let (a, b) = (ends[exit.sector], ends[(exit.sector + 1) % ends.len()]);
                    let on_edge = a + (b - a) * exit.along;
                    let on_ray = chart.to_surface(d) * exit.distance;
                    // A dozen roundings of numbers of size one.
                    assert!((on_edge - on_ray).length() < 1e-14, "{rise} {is_closed} {k}");
                    assert!((chart.to_chart(chart.to_surface(d)) - d).length() < 1e-13, "{rise} {is_closed} {k}");
                }
            }
        }
    }

    #[test]
    fn a_closed_curved_fan_is_stretched_to_a_full_turn() {
        let chart = FanChart::new(&spokes(&[0.0, 1.0, 2.1, 3.3, 4.0, 5.2], 0.2), true).unwrap();
        let (from, to) = chart.range();
        assert!((to - from - TAU).abs() < 1e-14);
        assert!(chart.stretch > 1.0);
    }

    #[test]
    fn the_middle_of_an_open_curved_fan_is_not_distorted() {
        // Symmetric about the x axis, so the middle direction is x tilted down.
        let ends: Vec<DVec3> = [-1.2_f64, -0.5, 0.5, 1.2].iter().map(|a| DVec3::new(a.cos(), a.sin(), -0.3)).collect();
        let chart = FanChart::new(&ends, false).unwrap();
        let (from, to) = chart.range();
        let middle = chart.to_surface(DVec2::from_angle(0.5 * (from + to)));
        assert!(middle.y.abs() < 1e-15);
        assert!((middle.dot(chart.axes()[1])).abs() < 1e-15);
    }

    #[test]
    fn what_has_no_area_has_no_chart() {
        assert!(FanChart::new(&[DVec3::X, DVec3::X * 2.0], false).is_none());
        assert!(FanChart::new(&[], true).is_none());
        assert!(FanChart::new(&[DVec3::X], false).is_none());
        assert!(FanChart::new(&[DVec3::X, DVec3::splat(f64::NAN)], false).is_none());
    }
}
