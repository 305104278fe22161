//! Bending of a triangle: how it tilts about its edges, and its moments against the tilts.
//!
//! Edge `e` runs from corner `e` to the next. Along it two triangles meet at the angle θ, zero where they are level and positive
//! where they form a valley, seen from the side of the normals. θ changes by what either triangle tilts about the edge, a tilt being
//! linear in what the corners move along the normal.

use crate::math::{Orthotropic, RestTriangle, Sym2};
use glam::DVec3;

/// A triangle squeezed to less than this part of its rest area has no meaningful normal, and is left out.
const LEAST_AREA: f64 = 1e-3;

/// The normal of a triangle and what its corners contribute to its tilts.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Tilt {
    /// Unit normal; zero for a collapsed triangle.
    pub normal: DVec3,
    /// Per edge the tilt by a unit of each corner along the normal \[1/mm\].
    pub by_corner: [DVec3; 3],
    /// Lengths of the edges \[mm\].
    pub length: DVec3,
}

impl Tilt {
    /// Of a triangle with corners at `x` and a rest area \[mm²\].
    #[inline(always)]
    pub fn new(x: [DVec3; 3], rest_area: f64) -> Self {
        let edges = [x[1] - x[0], x[2] - x[1], x[0] - x[2]];
        let cross = edges[2].cross(edges[0]);
        let twice_area = cross.length();
        let [a, b, c] = [edges[0].length(), edges[1].length(), edges[2].length()];
        let length = DVec3::new(a, b, c);
        if !(twice_area > 2.0 * LEAST_AREA * rest_area) {
            return Self { length, ..Self::default() };
        }
        let inverse = 1.0 / twice_area;
        // Where the height over an edge stands on it, from the begin and from the end.
        let [ab, bc, ca] = [edges[0].dot(edges[1]), edges[1].dot(edges[2]), edges[2].dot(edges[0])];
        let (of_a, of_b, of_c) = (inverse / a, inverse / b, inverse / c);
        let by_corner = [
            DVec3::new(ab * of_a, ca * of_a, a * inverse),
            DVec3::new(b * inverse, bc * of_b, ab * of_b),
            DVec3::new(bc * of_c, c * inverse, ca * of_c),
        ];
        Self { normal: cross * inverse, by_corner, length }
    }

    /// The tilts about the three edges when the corners move by `u`.
    #[inline(always)]
    pub fn of(&self, u: [DVec3; 3]) -> DVec3 {
        let w = DVec3::new(self.normal.dot(u[0]), self.normal.dot(u[1]), self.normal.dot(u[2]));
        DVec3::new(self.by_corner[0].dot(w), self.by_corner[1].dot(w), self.by_corner[2].dot(w))
    }

    /// What moments about the three edges exert on the corners along the normal: the transpose of [`of`](Self::of).
    #[inline(always)]
    pub fn along(&self, moment: DVec3) -> DVec3 {
        let [x, y, z] = &self.by_corner;
        *x * moment.x + *y * moment.y + *z * moment.z
    }
}

/// The unit normal of a triangle with corners at `x` and a rest area \[mm²\]; zero for a collapsed one, as in [`Tilt`].
#[inline(always)]
pub fn normal(x: [DVec3; 3], rest_area: f64) -> DVec3 {
    let cross = (x[0] - x[2]).cross(x[1] - x[0]);
    let twice_area = cross.length();
    if twice_area > 2.0 * LEAST_AREA * rest_area { cross * (1.0 / twice_area) } else { DVec3::ZERO }
}

/// Below this tangent an angle is a sum of seven powers of it, to the last digit.
pub const SMALL: f64 = 1.0 / 16.0;

/// The angle between two triangles with these unit normals, along the edge between them as the first of them sees it.
#[inline]
pub fn angle(normal: DVec3, across: DVec3, edge: DVec3) -> f64 {
    let (sine, cosine) = (-normal.cross(across).dot(edge.normalize_or_zero()), normal.dot(across));
    if sine.abs() < SMALL * cosine {
        let tangent = sine / cosine;
        let s = tangent * tangent;
        let powers = 1.0 / 7.0 - s * (1.0 / 9.0 - s * (1.0 / 11.0 - s * (1.0 / 13.0)));
        return tangent - tangent * s * (1.0 / 3.0 - s * (1.0 / 5.0 - s * powers));
    }
    f64::atan2(sine, cosine)
}

/// A difference of two angles in −π..π the way round that is shorter.
#[inline(always)]
pub fn shorter_way(difference: f64) -> f64 {
    use std::f64::consts::{PI, TAU};
    if difference > PI {
        difference - TAU
    } else if difference < -PI {
        difference + TAU
    } else {
        difference
    }
}

/// A symmetric 3×3 matrix over the edges of a triangle: 00, 11, 22, 01, 12, 20.
pub type OverEdges = [f64; 6];

/// The product with a vector over the edges.
#[inline(always)]
pub fn product(m: &OverEdges, v: DVec3) -> DVec3 {
    DVec3::new(
        m[0] * v.x + m[3] * v.y + m[5] * v.z,
        m[3] * v.x + m[1] * v.y + m[4] * v.z,
        m[5] * v.x + m[4] * v.y + m[2] * v.z,
    )
}

/// Q \[N·mm\] of the energy ½·φ·Q·φ of a triangle whose mid-edge normals stand at the angles φ to its own: the curvature is
/// κ = Σ φₑ·(lₑ/A)·mₑ⊗mₑ with the edges' lengths and normals, and the energy ½·A·κ:D:κ (Morley 1968; Grinspun, Gingold,
/// Reisman, Zorin 2006). The law times `scale` is D.
pub fn law(rest: &RestTriangle, stiffness: &Orthotropic, scale: f64) -> OverEdges {
    let gradients = rest.all_gradients();
    // The gradient of the corner opposite points against the edge's normal, and l/A is twice its length.
    let curvature = [2, 0, 1].map(|opposite: usize| {
        let g = gradients[opposite];
        Sym2::new(g.x * g.x, g.y * g.y, g.x * g.y) * (2.0 / g.length())
    });
    let moment = curvature.map(|k| stiffness.stress(k) * (scale * rest.area));
    [(0, 0), (1, 1), (2, 2), (0, 1), (1, 2), (2, 0)].map(|(e, f)| moment[e].contract(curvature[f]))
}
