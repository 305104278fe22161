//! Four triangles side by side in single precision: the rotated tangent as a symmetric 6×6 matrix, and its product.
//!
//! A tangent that no translation strains is a matrix on the two differences u₁ − u₀ and u₂ − u₀ alone, in global axes:
//! K = Σ bₖ·Ĉₖₗ·bₗᵀ + (n ⊗ n)·(gᵢ·N·gⱼ). With q = U₁₂/tr U and s = (U₁₁ − U₂₂)/tr U a corner with the shape gradient
//! (g₁, g₂) that moves by (w₁, w₂) in the triangle's own axes gives the strain rates ε₁₁: (g₁ − q·g₂, q·g₁),
//! ε₂₂: (q·g₂, g₂ − q·g₁), γ: ((1+s)·g₂, (1−s)·g₁), whose transpose is the first Piola–Kirchhoff stress of [`super::membrane`].
//!
//! Layout: one [`Vec4`] per entry, a lane per triangle: 84 bytes a triangle. Four lanes are what every processor has, and what a
//! transposition brings four vertices into.

use super::membrane::ElementTangent;
use glam::{Mat4, Vec4};

/// Triangles in a pack.
pub const LANES: usize = 4;

/// The matrices \[N/mm\] of four triangles, entries by rows of their blocks.
#[derive(Clone, Copy, Debug, Default)]
pub struct Pack {
    /// Upper triangle of the block of corner 1: xx, xy, xz, yy, yz, zz.
    pub k11: [Vec4; 6],
    /// Block of corner 1 (row) and corner 2 (column): xx, xy, xz, yx, yy, yz, zx, zy, zz.
    pub k12: [Vec4; 9],
    /// Upper triangle of the block of corner 2.
    pub k22: [Vec4; 6],
}

/// Where the corners of four triangles stand in the vectors: per corner one place for each lane.
pub type Places = [[u16; LANES]; 3];

impl Pack {
    /// The matrices of up to four triangles; a lane without one stays empty.
    #[inline(always)]
    pub fn new<'a>(element: impl Fn(usize) -> Option<ElementTangent<'a>>) -> Self {
        let mut f = [[0.0_f32; LANES]; 21];
        for lane in 0..LANES {
            let Some(e) = element(lane) else { continue };
            let (polar, rest) = (&e.state.polar, e.rest);
            let (r1, r2) = (polar.fibre_axis, polar.transverse_axis);
            let [q, s] = e.skew();
            let shear = e.shear * e.geometric;
            let [g1, g2] = rest.gradients;
            let values = [
                [r1.x, r1.y, r1.z, r2.x, r2.y, r2.z, q],
                [s, g1.x, g1.y, g2.x, g2.y, e.geometric, shear],
                [
                    e.stiffness.q11 * e.elastic + shear,
                    e.stiffness.q12 * e.elastic - shear,
                    e.stiffness.q22 * e.elastic + shear,
                    e.stiffness.q66 * e.elastic + shear,
                    e.normal.xx * e.geometric,
                    e.normal.yy * e.geometric,
                    e.normal.xy * e.geometric,
                ],
            ];
            for (row, value) in f.iter_mut().zip(values.as_flattened()) {
                row[lane] = *value as f32;
            }
        }
        let f = f.map(Vec4::from_array);
        let [r1, r2] = [[f[0], f[1], f[2]], [f[3], f[4], f[5]]];
        let (q, s) = (f[6], f[7]);
        let [c11, c12, c22, c66] = [f[14], f[15], f[16], f[17]];
        let [n11, n22, n12] = [f[18], f[19], f[20]];
        let n = [r1[1] * r2[2] - r1[2] * r2[1], r1[2] * r2[0] - r1[0] * r2[2], r1[0] * r2[1] - r1[1] * r2[0]];
        // Strain rates of a corner per unit of motion along the first and the second axis.
        let rows = |g1: Vec4, g2: Vec4| {
            let first = [g1 - q * g2, q * g2, (Vec4::ONE + s) * g2];
            let second = [q * g1, g2 - q * g1, (Vec4::ONE - s) * g1];
            [first, second]
        };
        let law = |e: [Vec4; 3]| [c11 * e[0] + c12 * e[1], c12 * e[0] + c22 * e[1], c66 * e[2]];
        let dot = |a: [Vec4; 3], b: [Vec4; 3]| a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
        let g = [[f[8], f[9]], [f[10], f[11]]];
        let b = g.map(|[g1, g2]| rows(g1, g2));
        let block = |i: usize, j: usize| {
            let t = b[j].map(law);
            // In the triangle's axes; then the two halves of the turn into global ones.
            let a = [[dot(b[i][0], t[0]), dot(b[i][0], t[1])], [dot(b[i][1], t[0]), dot(b[i][1], t[1])]];
            let nn = g[i][0] * (n11 * g[j][0] + n12 * g[j][1]) + g[i][1] * (n12 * g[j][0] + n22 * g[j][1]);
            let row = |y: usize| [a[0][0] * r1[y] + a[0][1] * r2[y], a[1][0] * r1[y] + a[1][1] * r2[y], nn * n[y]];
            let half = [row(0), row(1), row(2)];
            move |x: usize, y: usize| r1[x] * half[y][0] + r2[x] * half[y][1] + n[x] * half[y][2]
        };
        let upper = |k: &dyn Fn(usize, usize) -> Vec4| [k(0, 0), k(0, 1), k(0, 2), k(1, 1), k(1, 2), k(2, 2)];
        let k = block(0, 1);
        let k12 = [k(0, 0), k(0, 1), k(0, 2), k(1, 0), k(1, 1), k(1, 2), k(2, 0), k(2, 1), k(2, 2)];
        Self { k11: upper(&block(0, 0)), k12, k22: upper(&block(1, 1)) }
    }

    /// Adds the product with `u` to `out` \[N\].
    #[inline(always)]
    pub fn apply(&self, places: &Places, u: &[Vec4], out: &mut [Vec4]) {
        let corner = |c: usize| {
            let p = places[c];
            Mat4::from_cols(u[p[0] as usize], u[p[1] as usize], u[p[2] as usize], u[p[3] as usize]).transpose()
        };
        let (u0, u1, u2) = (corner(0), corner(1), corner(2));
        let (ax, ay, az) = (u1.x_axis - u0.x_axis, u1.y_axis - u0.y_axis, u1.z_axis - u0.z_axis);
        let (bx, by, bz) = (u2.x_axis - u0.x_axis, u2.y_axis - u0.y_axis, u2.z_axis - u0.z_axis);
        let (k, m, l) = (&self.k11, &self.k12, &self.k22);
        let fx = (k[0] * ax + k[1] * ay + k[2] * az) + (m[0] * bx + m[1] * by + m[2] * bz);
        let fy = (k[1] * ax + k[3] * ay + k[4] * az) + (m[3] * bx + m[4] * by + m[5] * bz);
        let fz = (k[2] * ax + k[4] * ay + k[5] * az) + (m[6] * bx + m[7] * by + m[8] * bz);
        let hx = (m[0] * ax + m[3] * ay + m[6] * az) + (l[0] * bx + l[1] * by + l[2] * bz);
        let hy = (m[1] * ax + m[4] * ay + m[7] * az) + (l[1] * bx + l[3] * by + l[4] * bz);
        let hz = (m[2] * ax + m[5] * ay + m[8] * az) + (l[2] * bx + l[4] * by + l[5] * bz);
        let f1 = Mat4::from_cols(fx, fy, fz, Vec4::ZERO).transpose();
        let f2 = Mat4::from_cols(hx, hy, hz, Vec4::ZERO).transpose();
        for lane in 0..LANES {
            let (a, b) = (f1.col(lane), f2.col(lane));
            out[places[0][lane] as usize] -= a + b;
            out[places[1][lane] as usize] += a;
            out[places[2][lane] as usize] += b;
        }
    }

    /// The blocks \[N/mm\] of the three corners on the diagonal, and those of the edges 1–0, 2–0, 2–1 (row, column), as
    /// columns: column `lane` of each matrix belongs to the triangle in that lane.
    #[inline(always)]
    pub fn blocks(&self) -> ([[Mat4; 3]; 3], [[Mat4; 3]; 3]) {
        let (k, m, l) = (&self.k11, &self.k12, &self.k22);
        let k11 = [[k[0], k[1], k[2]], [k[1], k[3], k[4]], [k[2], k[4], k[5]]];
        let k22 = [[l[0], l[1], l[2]], [l[1], l[3], l[4]], [l[2], l[4], l[5]]];
        // Columns, as all of these.
        let k21 = [[m[0], m[1], m[2]], [m[3], m[4], m[5]], [m[6], m[7], m[8]]];
        let k12 = [[m[0], m[3], m[6]], [m[1], m[4], m[7]], [m[2], m[5], m[8]]];
        let combine = |a: [[Vec4; 3]; 3], b: [[Vec4; 3]; 3], sign: f32| {
            std::array::from_fn(|x| std::array::from_fn(|y| (a[x][y] + b[x][y]) * sign))
        };
        let k10 = combine(k11, k12, -1.0);
        let k20 = combine(k21, k22, -1.0);
        let k00 = combine(k10, k20, -1.0);
        let by_lane =
            |k: [[Vec4; 3]; 3]| k.map(|[x, y, z]: [Vec4; 3]| Mat4::from_cols(x, y, z, Vec4::ZERO).transpose());
        ([by_lane(k00), by_lane(k11), by_lane(k22)], [by_lane(k10), by_lane(k20), by_lane(k21)])
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::{ElementState, Orthotropic, Polar, RestTriangle, Sym2};
    use glam::DVec3;

    /// Numbers in −1..1 without any pattern that matters: a linear congruential sequence.
    fn numbers() -> impl FnMut() -> f64 {
        let mut state = 7_u64;
        move || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (state >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
        }
    }

    struct Triangle {
        state: ElementState,
        rest: RestTriangle,
        law: Orthotropic,
        normal: Sym2,
        shear: f64,
    }

    impl Triangle {
        /// Any orientation, stretch, fibre and tension.
        fn new(mut next: impl FnMut() -> f64) -> Self {
            let mut vector = || DVec3::new(next(), next(), next());
            let (a, b, fibre) = (vector() + DVec3::X * 2.0, vector() + DVec3::Y * 2.0, vector());
            let rest = RestTriangle::new([DVec3::ZERO, a, b], fibre).unwrap();
            let fibre_axis = vector().normalize();
            let transverse_axis = fibre_axis.cross(vector()).normalize();
            let stretch = Sym2::new(1.1 + 0.2 * next(), 1.0 + 0.2 * next(), 0.2 * next());
            let law = Orthotropic::new(10.0, 1.0, 0.3, 0.5).unwrap();
            let stress = law.stress(stretch - Sym2::IDENTITY);
            let polar = Polar { fibre_axis, transverse_axis, stretch };
            Self {
                state: ElementState { polar, stress },
                rest,
                law,
                normal: stress.positive_part(),
                shear: next().abs(),
            }
        }

        fn tangent(&self) -> ElementTangent<'_> {
            ElementTangent {
                state: &self.state,
                rest: &self.rest,
                stiffness: &self.law,
                normal: self.normal,
                shear: self.shear,
                elastic: 0.3,
                geometric: 0.2,
                is_exact: false,
            }
        }
    }

    #[test]
    fn a_pack_is_the_rotated_tangent_but_for_rounding() {
        let mut next = numbers();
        for _ in 0..100 {
            let triangles: Vec<Triangle> = (0..3).map(|_| Triangle::new(&mut next)).collect();
            let pack = Pack::new(|lane| triangles.get(lane).map(Triangle::tangent));
            let u: Vec<Vec4> = (0..9).map(|_| Vec4::new(next() as f32, next() as f32, next() as f32, 0.0)).collect();
            // The empty lane shares its vertices with the first: it must add nothing.
            let places = [[0, 3, 6, 0], [1, 4, 7, 1], [2, 5, 8, 2]];
            let mut out = vec![Vec4::ZERO; 9];
            pack.apply(&places, &u, &mut out);
            let (corners, edges) = pack.blocks();
            for (t, triangle) in triangles.iter().enumerate() {
                let tangent = triangle.tangent();
                let u = [0, 1, 2].map(|c| u[3 * t + c].truncate().as_dvec3());
                // Every entry is at most the trace, and is a sum of some thirty products, each rounded to half of 1.2e-7.
                let size = (0..3).map(|c| tangent.diagonal_block(c)).map(|k| k.x_axis.x + k.y_axis.y + k.z_axis.z);
                let bound = size.sum::<f64>() * 30.0 * f64::from(f32::EPSILON);
                for (c, force) in tangent.apply(u).into_iter().enumerate() {
                    let off = (force - out[3 * t + c].truncate().as_dvec3()).length();
                    assert!(off < bound, "{off} over {bound}");
                }
                for (block, [row, column]) in
                    corners.iter().zip([[0, 0], [1, 1], [2, 2]]).chain(edges.iter().zip([[1, 0], [2, 0], [2, 1]]))
                {
                    for axis in 0..3 {
                        let mut unit = [DVec3::ZERO; 3];
                        unit[column][axis] = 1.0;
                        let off = tangent.apply(unit)[row] - block[axis].col(t).truncate().as_dvec3();
                        assert!(off.length() < bound, "{off} over {bound}");
                    }
                }
            }
            assert!(out.iter().all(|f| f.w == 0.0));
        }
    }
}
