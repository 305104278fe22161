//! A rigid solid within a closed triangle mesh: signed distances by the nearest triangle.
//!
//! The sign is that of the pseudonormal at the nearest point (Bærentzen and Aanæs 2005). Inside a triangle that is its normal, on
//! an edge the sum of both normals, and at a vertex the sum weighted by angles. Boxes around triangles, halved by their middles,
//! lead to the nearest one.

use crate::math::{is_place, nearest_in_triangle};
use glam::DVec3;
use smallvec::{SmallVec, smallvec};
use std::collections::BTreeMap;

/// Weights and parts of the radius below this are zero.
const WEIGHT_ROUNDING: f64 = 1e-12;
/// Triangles in a box that is not halved further.
const LEAF_TRIANGLES: usize = 4;

/// A closed triangle mesh, facing outwards, about the middle of its bounds.
#[derive(Clone, Debug)]
#[cfg_attr(feature = "snapshot", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "snapshot", serde(try_from = "Surface", into = "Surface"))]
pub struct Hull {
    surface: Surface,
    /// Distance \[mm\] of the farthest vertex from the middle.
    radius: f64,
    /// Normals of each triangle's edges and of the triangle, not of unit length.
    normals: Vec<[DVec3; 4]>,
    vertex_normals: Vec<DVec3>,
    boxes: Vec<Bounds>,
    /// Triangles in the order of the boxes.
    order: Vec<u32>,
}

/// Surface mesh from which a hull is built.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "snapshot", derive(serde::Serialize, serde::Deserialize))]
struct Surface {
    positions: Vec<DVec3>,
    triangles: Vec<[u32; 3]>,
}

/// A box around triangles; the half with the lower ones comes next.
#[derive(Clone, Copy, Debug)]
struct Bounds {
    low: DVec3,
    high: DVec3,
    /// Triangles in the box, by their places in the order; of a box with halves none.
    triangles: [u32; 2],
    /// Index of the upper half of the box.
    upper: u32,
}

/// Defect by which a mesh bounds no solid.
///
/// ```
/// use rhexis::{components::{Hull, HullError}, glam::DVec3};
/// let refused = Hull::new(vec![DVec3::ZERO, DVec3::X, DVec3::Y], vec![[0, 1, 2]]);
/// assert_eq!(refused, Err(HullError::Open(3)));
/// ```
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum HullError {
    /// A triangle without area, or with a corner that is not there or beyond 1e75 mm.
    #[error("triangle {0} has no area, or a corner that is not there or beyond 1e75 mm")]
    BadTriangle(usize),
    /// Edges with one triangle, or with more than two.
    #[error("the surface is not closed: {0} edges have not two triangles")]
    Open(usize),
    /// It faces inwards, or triangles at an edge face different sides.
    #[error("the triangles do not all face outwards")]
    TurnedOver,
}

impl PartialEq for Hull {
    fn eq(&self, other: &Self) -> bool {
        std::ptr::eq(self, other) || self.surface == other.surface
    }
}

impl TryFrom<Surface> for Hull {
    type Error = HullError;
    fn try_from(surface: Surface) -> Result<Self, HullError> {
        Self::about_middle(surface)
    }
}

impl From<Hull> for Surface {
    fn from(hull: Hull) -> Self {
        hull.surface
    }
}

impl Hull {
    /// The solid within a mesh \[mm\], and the middle of its bounds, to which it is moved.
    ///
    /// # Errors
    /// For a mesh that is not closed or does not face outwards.
    pub fn new(mut positions: Vec<DVec3>, triangles: Vec<[u32; 3]>) -> Result<(Self, DVec3), HullError> {
        let (low, high) = bounds(positions.iter().copied());
        let middle = low.midpoint(high);
        positions.iter_mut().for_each(|p| *p -= middle);
        Ok((Self::about_middle(Surface { positions, triangles })?, middle))
    }

    fn about_middle(surface: Surface) -> Result<Self, HullError> {
        let Surface { positions, triangles } = &surface;
        let corners = |t: &[u32; 3]| {
            let [a, b, c] = t.map(|v| positions.get(v as usize).copied());
            Some([a?, b?, c?])
        };
        let mut faces = Vec::with_capacity(triangles.len());
        let mut vertex_normals = vec![DVec3::ZERO; positions.len()];
        let mut edges: BTreeMap<[u32; 2], usize> = BTreeMap::new();
        let mut volume = 0.0;
        for (row, t) in triangles.iter().enumerate() {
            let x = corners(t).filter(|x| x.iter().all(|&p| is_place(p))).ok_or(HullError::BadTriangle(row))?;
            let normal = (x[1] - x[0]).cross(x[2] - x[0]).try_normalize().ok_or(HullError::BadTriangle(row))?;
            faces.push(normal);
            volume += x[0].dot(x[1].cross(x[2]));
            for i in 0..3 {
                let (next, last) = (x[(i + 1) % 3] - x[i], x[(i + 2) % 3] - x[i]);
                let angle = crate::math::elementary::atan2(next.cross(last).length(), next.dot(last));
                vertex_normals[t[i] as usize] += normal * angle;
                if edges.insert([t[i], t[(i + 1) % 3]], row).is_some() {
                    return Err(HullError::TurnedOver);
                }
            }
        }
        let open = edges.keys().filter(|[a, b]| !edges.contains_key(&[*b, *a])).count();
        if open > 0 || triangles.is_empty() {
            return Err(HullError::Open(open));
        }
        if !(volume > 0.0) {
            return Err(HullError::TurnedOver);
        }
        let beyond = |t: &[u32; 3], i: usize| edges.get(&[t[(i + 1) % 3], t[i]]).map_or(DVec3::ZERO, |&row| faces[row]);
        let normals = triangles.iter().zip(&faces).map(|(t, &face)| {
            let edge = |i: usize| face + beyond(t, i);
            [edge(0), edge(1), edge(2), face]
        });
        let normals = normals.collect();
        let mut order: Vec<u32> = (0..triangles.len() as u32).collect();
        let mut boxes = Vec::new();
        let of = |row: u32| triangles[row as usize].map(|v| positions[v as usize]);
        halve(&of, &mut order, 0, &mut boxes);
        let radius = positions.iter().map(|p| p.length()).fold(0.0, f64::max);
        Ok(Self { radius, normals, vertex_normals, boxes, order, surface })
    }

    /// Vertices \[mm\], about the middle of the bounds, and triangles, which face outwards.
    pub fn surface(&self) -> (&[DVec3], &[[u32; 3]]) {
        (&self.surface.positions, &self.surface.triangles)
    }

    /// Distance \[mm\] of its farthest point from the middle.
    pub fn radius(&self) -> f64 {
        self.radius
    }

    /// Signed distance \[mm\] (negative inside) and unit outward normal at the closest point.
    pub fn distance(&self, x: DVec3) -> Option<(f64, DVec3)> {
        let Surface { positions, triangles } = &self.surface;
        let mut best: Option<(f64, u32, [f64; 3], DVec3)> = None;
        let mut pending: SmallVec<[u32; 64]> = smallvec![0];
        while let Some(place) = pending.pop() {
            let Bounds { low, high, triangles: [first, end], upper } = *self.boxes.get(place as usize)?;
            let off = (low - x).max(x - high).max(DVec3::ZERO).length_squared();
            if best.is_some_and(|(least, ..)| off > least) {
                continue;
            }
            if first == end {
                pending.extend([upper, place + 1]);
            }
            for &row in &self.order[first as usize..end as usize] {
                let corners = triangles[row as usize].map(|v| positions[v as usize]);
                let weights = nearest_in_triangle(corners, x);
                let point = corners[0] * weights[0] + corners[1] * weights[1] + corners[2] * weights[2];
                let squared = point.distance_squared(x);
                // Of equally near ones the first: they meet in one point, with one pseudonormal.
                if best.is_none_or(|(least, first, ..)| squared < least || (squared == least && row < first)) {
                    best = Some((squared, row, weights, point));
                }
            }
        }
        let (_, row, weights, point) = best?;
        let normal = self.pseudonormal(row, weights);
        let (way, distance) = (x - point, x.distance(point));
        let sign = if way.dot(normal) < 0.0 { -1.0 } else { 1.0 };
        // At a rounding from the surface the way to it says nothing.
        let is_off = distance > WEIGHT_ROUNDING * self.radius;
        let normal = if is_off { way * (sign / distance) } else { normal.normalize_or_zero() };
        (normal != DVec3::ZERO).then_some((sign * distance, normal))
    }

    fn pseudonormal(&self, row: u32, weights: [f64; 3]) -> DVec3 {
        let corners = self.surface.triangles[row as usize];
        let [edges @ .., face] = self.normals[row as usize];
        if let Some(corner) = (0..3).find(|&i| weights[i] >= 1.0 - WEIGHT_ROUNDING) {
            return self.vertex_normals[corners[corner] as usize];
        }
        (0..3).find(|&edge| weights[(edge + 2) % 3] <= WEIGHT_ROUNDING).map_or(face, |edge| edges[edge])
    }
}

fn bounds(points: impl Iterator<Item = DVec3>) -> (DVec3, DVec3) {
    points.fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(low, high), p| (low.min(p), high.max(p)))
}

/// Appends the box around some triangles, `first` of which stand before them in the order, and those of its halves.
fn halve(of: &dyn Fn(u32) -> [DVec3; 3], rows: &mut [u32], first: u32, boxes: &mut Vec<Bounds>) {
    let (low, high) = bounds(rows.iter().flat_map(|&row| of(row)));
    let place = boxes.len();
    let end = first + rows.len() as u32;
    boxes.push(Bounds { low, high, triangles: [first, end], upper: 0 });
    if rows.len() <= LEAF_TRIANGLES {
        return;
    }
    let size = high - low;
    let axis = (0..3).fold(0, |best, axis| if size[axis] > size[best] { axis } else { best });
    let middle = |row: u32| of(row).iter().map(|x| x[axis]).sum::<f64>();
    rows.sort_by(|&a, &b| middle(a).total_cmp(&middle(b)).then(a.cmp(&b)));
    let half = rows.len() / 2;
    let (lower, upper) = rows.split_at_mut(half);
    halve(of, lower, first, boxes);
    let next = boxes.len() as u32;
    halve(of, upper, first + half as u32, boxes);
    boxes[place].triangles = [first, first];
    boxes[place].upper = next;
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A box of half edges 1, 2 and 0.7, off the origin.
    fn cuboid() -> (Vec<DVec3>, Vec<[u32; 3]>) {
        let corner = |i: u32| {
            let side = |bit: u32| if i >> bit & 1 == 1 { 1.0 } else { -1.0 };
            DVec3::new(5.0, 0.0, -3.0) + DVec3::new(side(0), 2.0 * side(1), 0.7 * side(2))
        };
        let quads = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
        let triangles = quads.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]).collect();
        ((0..8).map(corner).collect(), triangles)
    }

    #[test]
    fn distances_are_those_of_the_box_that_it_is() {
        let (positions, triangles) = cuboid();
        let (hull, middle) = Hull::new(positions, triangles).unwrap();
        assert_eq!(middle, DVec3::new(5.0, 0.0, -3.0));
        assert!((hull.radius() - (1.0_f64 + 4.0 + 0.49).sqrt()).abs() < 1e-15);
        for i in 1..2000 {
            let at = |k: f64| 3.0 * (f64::from(i) * k).sin();
            let x = DVec3::new(at(1.1), at(2.3), at(3.7));
            let (distance, normal) = hull.distance(x).unwrap();
            let expected = super::super::solid::of_box(x, DVec3::new(1.0, 2.0, 0.7));
            assert!((distance - expected.0).abs() < 1e-14, "{x}: {distance} {expected:?}");
            assert!((normal - expected.1).length() < 1e-9, "{x}: {normal} {expected:?}");
        }
        // On a vertex, an edge and a face: the pseudonormal.
        let half = DVec3::new(1.0, 2.0, 0.7);
        assert!((hull.distance(half).unwrap().1 - DVec3::ONE.normalize()).length() < 1e-15);
        assert!((hull.distance(half.with_x(0.2)).unwrap().1 - DVec3::new(0.0, 1.0, 1.0).normalize()).length() < 1e-15);
        let (distance, normal) = hull.distance(DVec3::new(0.2, 0.3, 0.7)).unwrap();
        assert!(distance.abs() < 1e-15 && (normal - DVec3::Z).length() < 1e-15, "{distance} {normal}");
    }

    #[test]
    fn what_bounds_no_solid_is_refused() {
        let (positions, mut triangles) = cuboid();
        let turned: Vec<[u32; 3]> = triangles.iter().map(|&[a, b, c]| [a, c, b]).collect();
        assert_eq!(Hull::new(positions.clone(), turned).unwrap_err(), HullError::TurnedOver);
        let mut one = triangles.clone();
        one[3].swap(0, 1);
        assert_eq!(Hull::new(positions.clone(), one).unwrap_err(), HullError::TurnedOver);
        triangles.pop();
        assert_eq!(Hull::new(positions.clone(), triangles.clone()).unwrap_err(), HullError::Open(3));
        triangles.push([0, 0, 9]);
        assert_eq!(Hull::new(positions, triangles).unwrap_err(), HullError::BadTriangle(11));
        assert_eq!(Hull::new(Vec::new(), Vec::new()).unwrap_err(), HullError::Open(0));
    }
}
