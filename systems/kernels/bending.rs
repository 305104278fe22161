//! Bending of a triangle: how it tilts about its edges, and its moments against the tilts.
//!
//! Edge `e` runs from corner `e` to the next. Along it two triangles meet at the angle θ, zero where they are level and positive
//! where they form a valley, seen from the side of the normals. The angle θ changes by the tilt of either triangle about the edge. A
//! tilt is linear in the displacements of the corners along the normal.

use super::formulas::{Vector, cross, dot, less, scaled};
use crate::math::number::{Number, Real};
use crate::math::{Orthotropic, RestTriangle, Sym2, elementary};
use glam::{DVec2, DVec3};

/// The part ω of a single mid-edge normal's own way to balance by which all are turned at once (2/3 would be best for a triangle by
/// itself, whose modes lie between 0 and 3).
pub const TURN: f64 = 0.65;

/// A triangle squeezed to less than this part of its rest area has no meaningful normal, and is left out.
const LEAST_BENT_AREA: f64 = 1e-3;

/// How a triangle tilts. Its edges e₀, e₁, e₂ follow one after the other and have the lengths l; cₑ is eₑ·eₑ₊₁ over twice the area.
/// Heights a and b of corners 1 and 2 over corner 0 tilt it about its edges by (c₂·(a − b) − c₀·b)/l₀, (c₁·a + c₀·b)/l₁ and
/// (−c₁·a − c₂·(a − b))/l₂.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Tilt {
    /// Unit normal; zero for a collapsed triangle.
    pub normal: DVec3,
    /// cₑ, minus the cotangents of the angles; zero for a collapsed triangle.
    pub minus_cotangent: DVec3,
    /// 1/l \[1/mm\]; zero for an edge without length.
    pub inverse_length: DVec3,
}

/// Twice the area up to which a triangle with a rest area \[mm²\] is collapsed.
#[inline(always)]
pub fn least_twice_area(rest_area: f64) -> f64 {
    2.0 * LEAST_BENT_AREA * rest_area
}

impl Tilt {
    /// Of a triangle with corners at `x` that is collapsed up to twice an area \[mm²\].
    pub fn new(x: [DVec3; 3], least_twice_area: f64) -> Self {
        let edges = edges(x.map(|x| x.to_array()));
        let normal = twice_area_vector(edges);
        let twice_area = dot(normal, normal).sqrt();
        let inverse_length = DVec3::from_array(edges.map(|edge| {
            let length = dot(edge, edge).sqrt();
            if length > 0.0 { 1.0 / length } else { 0.0 }
        }));
        if !(twice_area > least_twice_area) {
            return Self { inverse_length, ..Self::default() };
        }
        let inverse = 1.0 / twice_area;
        let minus_cotangent = DVec3::from_array(minus_cotangents(edges, inverse));
        Self { normal: DVec3::from_array(scaled(normal, inverse)), minus_cotangent, inverse_length }
    }

    /// Tilt of the triangle about an edge per unit of height at a corner \[1/mm\].
    #[inline(always)]
    pub fn by_corner(&self, edge: usize, corner: usize) -> f64 {
        let [own, last] = [self.minus_cotangent[edge], self.minus_cotangent[(edge + 2) % 3]];
        let by_unit = match (corner + 3 - edge) % 3 {
            0 => own,
            1 => last,
            _ => -(own + last),
        };
        by_unit * self.inverse_length[edge]
    }

    /// The tilts about the three edges when the corners move by `u`.
    pub fn of(&self, u: [DVec3; 3]) -> DVec3 {
        let (a, b) = (self.normal.dot(u[1] - u[0]), self.normal.dot(u[2] - u[0]));
        DVec3::from_array(tilts(self.minus_cotangent.to_array(), a, b)) * self.inverse_length
    }

    /// Forces on the corners along the normal from moments about the three edges: the transpose of [`of`](Self::of).
    pub fn along(&self, moment: DVec3) -> DVec3 {
        let moment = moment * self.inverse_length;
        DVec3::from_array(forces_along(self.minus_cotangent.to_array(), moment.to_array()))
    }
}

/// The edges, each from its corner to the next.
#[inline(always)]
pub fn edges<N: Number>(x: [Vector<N>; 3]) -> [Vector<N>; 3] {
    [less(x[1], x[0]), less(x[2], x[1]), less(x[0], x[2])]
}

/// The normal, as long as twice the area.
#[inline(always)]
pub fn twice_area_vector<N: Number>(edges: [Vector<N>; 3]) -> Vector<N> {
    cross(edges[2], edges[0])
}

/// cₑ of the edges and one over twice the area.
#[inline(always)]
pub fn minus_cotangents<N: Number>([a, b, c]: [Vector<N>; 3], inverse: N) -> [N; 3] {
    [dot(a, b) * inverse, dot(b, c) * inverse, dot(c, a) * inverse]
}

/// Tilts times the lengths of the edges, for heights `a` and `b` of corners 1 and 2 over corner 0.
#[inline(always)]
pub fn tilts<N: Number>(c: [N; 3], a: N, b: N) -> [N; 3] {
    let (p, q, r) = (c[2] * (a - b), c[0] * b, c[1] * a);
    [p - q, q + r, a.constant(0.0) - (r + p)]
}

/// Forces along the normal on the corners of moments over the lengths of their edges: the transpose of [`tilts`].
#[inline(always)]
pub fn forces_along<N: Number>(c: [N; 3], m: [N; 3]) -> [N; 3] {
    let (p, q, r) = (c[2] * (m[0] - m[2]), c[0] * (m[1] - m[0]), c[1] * (m[1] - m[2]));
    [m[0].constant(0.0) - (q + r), p + r, q - p]
}

/// arctan(x)/x = 1 + Σ aₖ·x²ᵏ⁺² up to x = tan(π/8): the polynomial with the least error, 5e-18.
pub const ARC_TANGENT: [f64; 11] = [
    -0.333_333_333_333_333_3,
    0.199_999_999_999_955_2,
    -0.142_857_142_846_665_42,
    0.111_111_110_152_563_61,
    -0.090_909_045_781_239_03,
    0.076_921_831_908_260_87,
    -0.066_645_114_473_819_48,
    0.058_581_489_128_022_1,
    -0.050_854_497_379_402_6,
    0.039_231_658_295_587_19,
    -0.019_176_887_119_062_21,
];

/// The angle between two triangles with these unit normals, along the edge between them as the first of them sees it.
pub fn angle(normal: DVec3, across: DVec3, edge: DVec3) -> f64 {
    let (sine, cosine) = (-normal.cross(across).dot(edge.normalize_or_zero()), normal.dot(across));
    if !(cosine > 0.0) {
        return elementary::atan2(sine, cosine);
    }
    acute_angle(sine, cosine)
}

/// The angle with such a sine and a cosine above zero.
#[inline(always)]
pub fn acute_angle<N: Real>(sine: N, cosine: N) -> N {
    let one = sine.constant(1.0);
    // The tangents of its half and its quarter.
    let half = sine / (one + cosine);
    let quarter = half / ((half * half + one).sqrt() + one);
    let s = quarter * quarter;
    let mut powers = sine.constant(0.0);
    for a in ARC_TANGENT.iter().rev() {
        powers = powers * s + sine.constant(*a);
    }
    sine.constant(4.0) * (quarter + quarter * s * powers)
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
pub type EdgeMatrix = [f64; 6];

/// The product with a vector over the edges.
#[inline(always)]
pub fn product(m: &EdgeMatrix, v: DVec3) -> DVec3 {
    DVec3::from_array(symmetric_product(m, v.to_array()))
}

/// The product of a symmetric matrix 00, 11, 22, 01, 12, 20 with a vector.
#[inline(always)]
pub fn symmetric_product<N: Number>(m: &[N; 6], v: [N; 3]) -> [N; 3] {
    [
        m[0] * v[0] + m[3] * v[1] + m[5] * v[2],
        m[3] * v[0] + m[1] * v[1] + m[4] * v[2],
        m[5] * v[0] + m[4] * v[1] + m[2] * v[2],
    ]
}

/// Q \[N·mm\] of the energy ½·φ·Q·φ of a triangle whose mid-edge normals stand at the angles φ to its own: the curvature is
/// κ = Σ φₑ·(lₑ/A)·mₑ⊗mₑ with the edges' lengths and normals, and the energy ½·A·κ:D:κ (Morley 1968; Grinspun, Gingold,
/// Reisman, Zorin 2006). The law times `scale` is D.
pub fn law(rest: &RestTriangle, stiffness: &Orthotropic, scale: f64) -> EdgeMatrix {
    let gradients = rest.all_gradients();
    // The gradient of the corner opposite points against the edge's normal, and l/A is twice its length.
    let curvature = [2, 0, 1].map(|opposite: usize| {
        let g = gradients[opposite];
        Sym2::new(g.x * g.x, g.y * g.y, g.x * g.y) * (2.0 / g.length())
    });
    let moment = curvature.map(|k| stiffness.stress(k) * (scale * rest.area));
    [(0, 0), (1, 1), (2, 2), (0, 1), (1, 2), (2, 0)].map(|(e, f)| moment[e].contract(curvature[f]))
}

/// How Q changes \[N\] when the rest shape is shifted by q·d, d a unit vector, where the weight q has the gradient `fall` \[1/mm\].
/// The gradients of shape functions then change by −∇q·(d·∇N) and the area by the part d·∇q.
pub fn law_under_shift(
    rest: &RestTriangle,
    stiffness: &Orthotropic,
    scale: f64,
    (fall, d): (DVec2, DVec2),
) -> EdgeMatrix {
    let gradients = rest.all_gradients();
    let curvature = [2, 0, 1].map(|opposite: usize| {
        let g = gradients[opposite];
        let (size, change) = (g.length(), fall * -d.dot(g));
        let longer = g.dot(change) / (size * size);
        let square = Sym2::new(g.x * g.x, g.y * g.y, g.x * g.y) * (2.0 / size);
        let mixed = Sym2::new(2.0 * g.x * change.x, 2.0 * g.y * change.y, g.x * change.y + g.y * change.x);
        (square, mixed * (2.0 / size) - square * longer)
    });
    let factor = scale * rest.area;
    let of = |k: Sym2| stiffness.stress(k) * factor;
    let [moment, change] = [curvature.map(|(k, _)| of(k)), curvature.map(|(_, k)| of(k))];
    let wider = d.dot(fall);
    [(0, 0), (1, 1), (2, 2), (0, 1), (1, 2), (2, 0)].map(|(e, f)| {
        let own = moment[e].contract(curvature[f].0) * wider;
        own + change[e].contract(curvature[f].0) + moment[e].contract(curvature[f].1)
    })
}

/// Change \[1/mm\] of the angles φ of a triangle's mid-edge normals at rest when the rest shape is shifted by q·d, as in
/// [`law_under_shift`], at a fixed curvature at rest: Σ dφₑ·kₑ = −Σ φₑ·dkₑ with the curvatures kₑ of unit angles.
pub fn angles_under_shift(rest: &RestTriangle, angles: DVec3, (fall, d): (DVec2, DVec2)) -> DVec3 {
    let gradients = rest.all_gradients();
    let opposite = [2, 0, 1];
    let mut change = Sym2::ZERO;
    for (edge, corner) in opposite.into_iter().enumerate() {
        let (g, g_change) = (gradients[corner], fall * -d.dot(gradients[corner]));
        let size = g.length();
        let square = Sym2::outer(g) * (2.0 / size);
        let mixed = Sym2::new(2.0 * g.x * g_change.x, 2.0 * g.y * g_change.y, g.x * g_change.y + g.y * g_change.x);
        change += (mixed * (2.0 / size) - square * (g.dot(g_change) / (size * size))) * angles[edge];
    }
    // Of two other edges t, s as vectors, t·kₑ·s is −2 over the size of the gradient, and that of their own curvatures is zero.
    let sides = gradients.map(|g| g.perp() * (2.0 * rest.area));
    DVec3::from_array([0, 1, 2].map(|edge: usize| {
        let corner = opposite[edge];
        let [t, s] = [sides[(corner + 1) % 3], sides[(corner + 2) % 3]];
        0.5 * gradients[corner].length() * t.dot(change.apply(s))
    }))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn angles_are_those_of_the_arc_tangent() {
        for i in -4000..=4000 {
            let theta = f64::from(i) * (std::f64::consts::PI / 4000.5);
            for theta in [theta, theta * 1e-6] {
                let (sine, cosine) = theta.sin_cos();
                let found = angle(DVec3::Z, DVec3::new(sine, 0.0, cosine), DVec3::NEG_Y * 0.7);
                // Rounding of a few operations; beyond a right angle that of the sine, which is small there.
                assert!((found - theta).abs() <= 1e-15 * theta.abs(), "{found} for {theta}");
            }
        }
    }
}
