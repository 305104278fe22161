//! Opening made by a closed tear: the figures by which surgeons judge a capsulorhexis, from its outline in the rest shape.
//!
//! The outline is looked at along its own mean normal, as through the microscope. With its area A and length P there:
//!
//! | figure | definition | source |
//! |---|---|---|
//! | diameter | 2·√(A/π), of the circle of the same area | Kránitz et al. 2011, J Refract Surg 27:558 |
//! | circularity | 4πA/P², 1 for a circle, less for long or jagged outlines | Cox 1927, J Paleontol 1:179; Kránitz et al. 2011 |
//! | decentration | from the axis to the centroid of the area | distance of centres, as Kránitz et al. 2011 |
//! | largest radius | from the axis to the farthest point of the outline | the radius that must stay clear of the zonules |
//!
//! The axis goes through the centroid of the body's outer rim, along the rim's mean normal: for a lens capsule its pole.

use glam::DVec3;
use rhexis::math::elementary;
use rhexis::storage::{Topology, Triangles, Vertices};
use std::f64::consts::PI;

/// A loop of smaller area than this part of its squared length is the two lips of a slit.
const SLIT: f64 = 1e-4;

/// A line through space.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "snapshot", derive(serde::Serialize, serde::Deserialize))]
pub struct Axis {
    /// A point on it \[mm\].
    pub point: DVec3,
    /// Direction of the axis \[unit\].
    pub direction: DVec3,
}

impl Axis {
    /// Through the centroid of the area in a closed outline \[mm\], along its mean normal; `None` for one without area.
    pub fn from_outline(outline: &[DVec3]) -> Option<Self> {
        let (area, point) = area_and_centroid(outline)?;
        Some(Self { point, direction: area.normalize() })
    }

    /// From the axis to a point, square to the axis \[mm\].
    pub fn offset(&self, point: DVec3) -> DVec3 {
        (point - self.point).reject_from_normalized(self.direction)
    }

    /// Angle \[rad\] by which one offset is turned against another, counter-clockwise about the axis.
    pub fn turn(&self, from: DVec3, to: DVec3) -> f64 {
        elementary::atan2(from.cross(to).dot(self.direction), from.dot(to))
    }
}

/// The shape of an opening.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "snapshot", derive(serde::Serialize, serde::Deserialize))]
pub struct Opening {
    /// Diameter of the circle of the same area \[mm\].
    pub diameter: f64,
    /// 4πA/P².
    pub circularity: f64,
    /// From the axis to the centroid \[mm\].
    pub decentration: f64,
    /// From the axis to the farthest point of the outline \[mm\].
    pub largest_radius: f64,
}

impl Opening {
    /// The figures of a closed outline \[mm\], whose last point is joined to the first; `None` for one without area.
    pub fn from_outline(outline: &[DVec3], axis: &Axis) -> Option<Self> {
        let (area, centroid) = area_and_centroid(outline)?;
        let normal = area.normalize();
        let length: f64 = edges(outline).map(|(a, b)| (b - a).reject_from_normalized(normal).length()).sum();
        let area = area.length();
        Some(Self {
            diameter: 2.0 * (area / PI).sqrt(),
            circularity: 4.0 * PI * area / (length * length),
            decentration: axis.offset(centroid).length(),
            largest_radius: outline.iter().map(|&p| axis.offset(p).length()).fold(0.0, f64::max),
        })
    }

    /// Openings of a body, the largest first, each with the rows of its outline: loops of its boundary that are no piece's outer rim
    /// and no slit.
    pub(super) fn of_body(
        vertices: &Vertices,
        triangles: &Triangles,
        topology: &Topology,
        axis: &Axis,
    ) -> Vec<(Self, Vec<u32>)> {
        let loops = boundary_loops(triangles, topology);
        let (count, piece) = topology.components();
        let outline = |rows: &[u32]| rows.iter().map(|&v| vertices.rest_position[v as usize]).collect::<Vec<_>>();
        let size = |rows: &[u32]| area_within(&outline(rows));
        let of_piece = |rows: &[u32]| piece[(topology.incident[rows[0] as usize][0] / 3) as usize];
        let mut rims = vec![None; count];
        for (i, rows) in loops.iter().enumerate() {
            let rim = &mut rims[of_piece(rows) as usize];
            if rim.is_none_or(|other: usize| size(&loops[other]) < size(rows)) {
                *rim = Some(i);
            }
        }
        let inner = loops.iter().enumerate().filter(|(i, _)| !rims.contains(&Some(*i)));
        let mut openings: Vec<(Self, Vec<u32>)> = inner
            .filter_map(|(_, rows)| Some((Self::from_outline(&outline(rows), axis)?, rows.clone())))
            .filter(|(opening, _)| opening.circularity > SLIT)
            .collect();
        openings.sort_by(|(a, _), (b, _)| b.diameter.total_cmp(&a.diameter));
        openings
    }
}

/// The closed loops of a body's boundary, each with the surface to its left, in the order of their lowest rows.
pub(super) fn boundary_loops(triangles: &Triangles, topology: &Topology) -> Vec<Vec<u32>> {
    let mut is_seen = vec![false; topology.incident.len()];
    let mut loops = Vec::new();
    for first in 0..is_seen.len() as u32 {
        let mut rows = Vec::new();
        let mut next = Some(first).filter(|&v| topology.is_boundary_vertex(v));
        while let Some(v) = next.filter(|&v| !std::mem::replace(&mut is_seen[v as usize], true)) {
            rows.push(v);
            next = topology.next_boundary_vertex(&triangles.corners, v);
        }
        if !rows.is_empty() {
            loops.push(rows);
        }
    }
    loops
}

/// Pairs of neighbouring points of a closed outline.
pub(super) fn edges<P: Copy>(outline: &[P]) -> impl Iterator<Item = (P, P)> + '_ {
    outline.iter().copied().zip(outline.iter().copied().cycle().skip(1))
}

/// The area \[mm²\] in a closed outline: that of the two lips of a slit is next to none.
pub(super) fn area_within(outline: &[DVec3]) -> f64 {
    area_and_centroid(outline).map_or(0.0, |(area, _)| area.length())
}

/// Vector area \[mm²\] and centroid \[mm\]; by triangles with one corner in the middle of the points.
fn area_and_centroid(outline: &[DVec3]) -> Option<(DVec3, DVec3)> {
    let middle = outline.iter().sum::<DVec3>() / outline.len().max(1) as f64;
    let parts = || edges(outline).map(|(a, b)| (0.5 * (a - middle).cross(b - middle), (a + b + middle) / 3.0));
    let area: DVec3 = parts().map(|(area, _)| area).sum();
    let normal = area.try_normalize()?;
    let weighted: DVec3 = parts().map(|(part, centre)| (centre - middle) * part.dot(normal)).sum();
    Some((area, middle + weighted / area.length()))
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::TAU;

    const POLE: Axis = Axis { point: DVec3::ZERO, direction: DVec3::Z };

    fn ellipse(count: u32, a: f64, b: f64, centre: DVec3) -> Vec<DVec3> {
        let angles = (0..count).map(|i| TAU * f64::from(i) / f64::from(count));
        angles.map(|angle| centre + DVec3::new(a * angle.cos(), b * angle.sin(), 0.0)).collect()
    }

    #[test]
    fn known_shapes() {
        // A circle of 1000 chords: 1e-5 less area and length.
        let centre = DVec3::new(0.3, -0.4, 1.0);
        let circle = Opening::from_outline(&ellipse(1000, 2.5, 2.5, centre), &POLE).unwrap();
        assert!((circle.diameter - 5.0).abs() < 1e-4 && (circle.circularity - 1.0).abs() < 1e-5);
        assert!((circle.decentration - 0.5).abs() < 1e-12);
        assert!((circle.largest_radius - 3.0).abs() < 1e-4);
        // An ellipse of axes 2 : 1 has the circumference 9.68845 (Ramanujan 1914) for half axes 2 and 1.
        let long = Opening::from_outline(&ellipse(1000, 2.0, 1.0, DVec3::ZERO), &POLE).unwrap();
        assert!((long.circularity - 4.0 * PI * TAU / 9.688_45_f64.powi(2)).abs() < 1e-4);
        assert!((long.diameter - 8_f64.sqrt()).abs() < 1e-4);
        // A square, clockwise: the sense does not matter.
        let square = [(0.0, 0.0), (0.0, 2.0), (2.0, 2.0), (2.0, 0.0)].map(|(x, y)| DVec3::new(x, y, 0.0));
        let square = Opening::from_outline(&square, &POLE).unwrap();
        assert!((square.circularity - PI / 4.0).abs() < 1e-12 && (square.decentration - 2_f64.sqrt()).abs() < 1e-12);
        assert_eq!(Opening::from_outline(&[DVec3::ZERO, DVec3::X], &POLE), None);
    }

    #[test]
    fn a_tilted_circle_is_seen_along_its_own_normal() {
        let turn = glam::DQuat::from_rotation_x(0.6);
        let tilted: Vec<DVec3> = ellipse(1000, 2.0, 2.0, DVec3::Z).iter().map(|&p| turn * p).collect();
        let opening = Opening::from_outline(&tilted, &POLE).unwrap();
        assert!((opening.circularity - 1.0).abs() < 1e-5 && (opening.diameter - 4.0).abs() < 1e-4);
        assert!((opening.decentration - 0.6_f64.sin()).abs() < 1e-9);
    }
}
