//! Eight triangles side by side in single precision: the tangent as a symmetric 6×6 matrix, and its product.
//!
//! A tangent that no translation strains is a matrix on the two differences u₁ − u₀ and u₂ − u₀ alone, in global axes:
//! K = Σ bₖ·Ĉₖₗ·bₗᵀ + (n ⊗ n)·(gᵢ·N·gⱼ). With q = U₁₂/tr U and s = (U₁₁ − U₂₂)/tr U a corner with the shape gradient
//! (g₁, g₂) that moves by (w₁, w₂) in the triangle's own axes gives the strain rates ε₁₁: (g₁ − q·g₂, q·g₁),
//! ε₂₂: (q·g₂, g₂ − q·g₁), γ: ((1+s)·g₂, (1−s)·g₁), whose transpose is the first Piola–Kirchhoff stress of [`super::membrane`].
//! An exact tangent has ½·(ω⊗ℓ + ℓ⊗ω) beside it, with the spin ω: (−g₂, g₁)/tr U.
//!
//! Layout: eight numbers per entry, a lane per triangle: 84 bytes a triangle.

use super::lanes::{Lanes, SINGLES, Singles};
use super::membrane::ElementTangent;
use glam::{Mat4, Vec4};

/// Triangles in a pack.
pub const LANES: usize = SINGLES;

/// One number of each of eight triangles.
pub(super) type Entry = [Vec4; 2];

/// The matrices \[N/mm\] of eight triangles, entries by rows of their blocks.
#[derive(Clone, Copy, Debug, Default)]
pub struct Pack {
    /// Upper triangle of the block of corner 1: xx, xy, xz, yy, yz, zz.
    pub k11: [Entry; 6],
    /// Block of corner 1 (row) and corner 2 (column): xx, xy, xz, yx, yy, yz, zx, zy, zz.
    pub k12: [Entry; 9],
    /// Upper triangle of the block of corner 2.
    pub k22: [Entry; 6],
}

/// Where the corners of eight triangles stand in the vectors: per corner one place for each lane.
pub type Places = [[u16; LANES]; 3];

/// Rotational part of an exact tangent of a triangle, into its lane.
#[inline(always)]
pub(super) fn put_turning(element: &ElementTangent<'_>, lane: usize, turning: &mut [[f32; LANES]; 5]) {
    let (inverse, l) = element.turning_terms();
    let values = l.map(|l| 0.5 * l * element.geometric).into_iter().chain([inverse]);
    for (row, value) in turning.iter_mut().zip(values) {
        row[lane] = value as f32;
    }
}

impl Pack {
    /// The matrices of up to eight triangles, all of them of one kind of tangent; a lane without one stays empty.
    #[inline(always)]
    pub fn new<'a, L: Lanes>(lanes: L, turns: bool, element: impl Fn(usize) -> Option<ElementTangent<'a>>) -> Self {
        let mut f = [[0.0_f32; LANES]; 21];
        let (mut turning, mut coupling) = ([[0.0_f32; LANES]; 5], [[0.0_f32; LANES]; 2]);
        for lane in 0..LANES {
            let Some(e) = element(lane) else { continue };
            if turns {
                put_turning(&e, lane, &mut turning);
            }
            coupling.iter_mut().zip(e.coupling).for_each(|(row, q)| row[lane] = (q * e.elastic) as f32);
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
        let f = singles(lanes, &f);
        let (r1, r2, one) = ([f[0], f[1], f[2]], [f[3], f[4], f[5]], Singles::splat(lanes, 1.0));
        let n = [r1[1] * r2[2] - r1[2] * r2[1], r1[2] * r2[0] - r1[0] * r2[2], r1[0] * r2[1] - r1[1] * r2[0]];
        let in_plane = InPlane {
            g: [[f[8], f[9]], [f[10], f[11]]],
            b: [strain_rates(f[8], f[9], f[6], f[7], one), strain_rates(f[10], f[11], f[6], f[7], one)],
            law: [f[14], f[15], f[16], f[17]],
            coupling: (coupling != [[0.0; LANES]; 2]).then(|| singles(lanes, &coupling)),
            turning: turns.then(|| singles(lanes, &turning)),
        };
        let element = Element { axes: [r1, r2, n], in_plane, normal: [f[18], f[19], f[20]] };
        let [[xx, xy, xz], [_, yy, yz], [_, _, zz]] = element.block(0, 0);
        let k11 = [xx, xy, xz, yy, yz, zz];
        let [[xx, xy, xz], [yx, yy, yz], [zx, zy, zz]] = element.block(0, 1);
        let k12 = [xx, xy, xz, yx, yy, yz, zx, zy, zz];
        let [[xx, xy, xz], [_, yy, yz], [_, _, zz]] = element.block(1, 1);
        Self { k11, k12, k22: [xx, xy, xz, yy, yz, zz] }
    }

    /// The product with `u` at corners 1 and 2 \[N\]; at corner 0 it is minus their sum.
    #[inline(always)]
    pub fn forces<L: Lanes>(&self, lanes: L, places: &Places, u: &[Vec4]) -> [[Singles<L>; 3]; 2] {
        let u0 = gather(lanes, &places[0], u);
        let (u1, u2) = (gather(lanes, &places[1], u), gather(lanes, &places[2], u));
        let (ax, ay, az) = (u1[0] - u0[0], u1[1] - u0[1], u1[2] - u0[2]);
        let (bx, by, bz) = (u2[0] - u0[0], u2[1] - u0[1], u2[2] - u0[2]);
        let (k, m, l) = (entries(lanes, &self.k11), entries(lanes, &self.k12), entries(lanes, &self.k22));
        let fx = (k[0] * ax + k[1] * ay + k[2] * az) + (m[0] * bx + m[1] * by + m[2] * bz);
        let fy = (k[1] * ax + k[3] * ay + k[4] * az) + (m[3] * bx + m[4] * by + m[5] * bz);
        let fz = (k[2] * ax + k[4] * ay + k[5] * az) + (m[6] * bx + m[7] * by + m[8] * bz);
        let hx = (m[0] * ax + m[3] * ay + m[6] * az) + (l[0] * bx + l[1] * by + l[2] * bz);
        let hy = (m[1] * ax + m[4] * ay + m[7] * az) + (l[1] * bx + l[3] * by + l[4] * bz);
        let hz = (m[2] * ax + m[5] * ay + m[8] * az) + (l[2] * bx + l[4] * by + l[5] * bz);
        [[fx, fy, fz], [hx, hy, hz]]
    }

    /// Adds forces on corners 1 and 2, and minus their sum on corner 0, to `out` \[N\].
    #[inline(always)]
    pub fn scatter<L: Lanes>(places: &Places, [f1, f2]: [[Singles<L>; 3]; 2], out: &mut [Vec4]) {
        let (f1, f2) = (Singles::rows(f1), Singles::rows(f2));
        for lane in 0..LANES {
            let (a, b) = (f1[lane], f2[lane]);
            out[places[0][lane] as usize] -= a + b;
            out[places[1][lane] as usize] += a;
            out[places[2][lane] as usize] += b;
        }
    }

    /// The blocks \[N/mm\] of the triangles in the first (0) or last (1) four lanes, as columns. First those of the three corners
    /// on the diagonal, then those of the edges 1–0, 2–0, 2–1 (row, column). Column `i` of each matrix belongs to the `i`-th of the
    /// triangles.
    #[inline(always)]
    pub fn blocks(&self, half: usize) -> ([[Mat4; 3]; 3], [[Mat4; 3]; 3]) {
        let (k, m, l) = (half_of(&self.k11, half), half_of(&self.k12, half), half_of(&self.k22, half));
        let k11 = [[k[0], k[1], k[2]], [k[1], k[3], k[4]], [k[2], k[4], k[5]]];
        let k22 = [[l[0], l[1], l[2]], [l[1], l[3], l[4]], [l[2], l[4], l[5]]];
        // Columns, as all of these.
        let k21 = [[m[0], m[1], m[2]], [m[3], m[4], m[5]], [m[6], m[7], m[8]]];
        let k12 = [[m[0], m[3], m[6]], [m[1], m[4], m[7]], [m[2], m[5], m[8]]];
        let (k10, k20) = (minus_sum(k11, k12), minus_sum(k21, k22));
        let k00 = minus_sum(k10, k20);
        ([by_lane(k00), by_lane(k11), by_lane(k22)], [by_lane(k10), by_lane(k20), by_lane(k21)])
    }
}

#[inline(always)]
pub(super) fn half_of<const N: usize>(entries: &[Entry; N], half: usize) -> [Vec4; N] {
    let mut of_half = [Vec4::ZERO; N];
    for i in 0..N {
        of_half[i] = entries[i][half];
    }
    of_half
}

#[inline(always)]
pub(super) fn minus_sum<const N: usize>(a: [[Vec4; N]; N], b: [[Vec4; N]; N]) -> [[Vec4; N]; N] {
    let mut sum = a;
    for x in 0..N {
        for y in 0..N {
            sum[x][y] = -(a[x][y] + b[x][y]);
        }
    }
    sum
}

#[inline(always)]
fn by_lane(k: [[Vec4; 3]; 3]) -> [Mat4; 3] {
    let mut columns = [Mat4::ZERO; 3];
    for (column, [x, y, z]) in columns.iter_mut().zip(k) {
        *column = Mat4::from_cols(x, y, z, Vec4::ZERO).transpose();
    }
    columns
}

/// Eight vertices' vectors by components.
#[inline(always)]
pub(super) fn gather<L: Lanes>(lanes: L, place: &[u16; LANES], u: &[Vec4]) -> [Singles<L>; 3] {
    let mut rows = [Vec4::ZERO; LANES];
    for lane in 0..LANES {
        rows[lane] = u[place[lane] as usize];
    }
    Singles::components(lanes, rows)
}

#[inline(always)]
pub(super) fn entries<L: Lanes, const N: usize>(lanes: L, k: &[Entry; N]) -> [Singles<L>; N] {
    let mut values = [Singles::new(lanes, k[0]); N];
    for i in 1..N {
        values[i] = Singles::new(lanes, k[i]);
    }
    values
}

#[inline(always)]
pub(super) fn singles<L: Lanes, const N: usize>(lanes: L, x: &[[f32; LANES]; N]) -> [Singles<L>; N] {
    let mut values = [Singles::splat(lanes, 0.0); N];
    for i in 0..N {
        let [a, b, c, d, e, f, g, h] = x[i];
        values[i] = Singles::new(lanes, [Vec4::new(a, b, c, d), Vec4::new(e, f, g, h)]);
    }
    values
}

/// Strain rates ε₁₁, ε₂₂, γ of a corner with the shape gradient (g₁, g₂) per unit of motion along the triangle's first axis,
/// and along its second.
#[inline(always)]
pub(super) fn strain_rates<L: Lanes>(
    g1: Singles<L>,
    g2: Singles<L>,
    q: Singles<L>,
    s: Singles<L>,
    one: Singles<L>,
) -> [[Singles<L>; 3]; 2] {
    [[g1 - q * g2, q * g2, (one + s) * g2], [q * g1, g2 - q * g1, (one - s) * g1]]
}

#[inline(always)]
fn dot<L: Lanes>(a: [Singles<L>; 3], b: [Singles<L>; 3]) -> Singles<L> {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// Terms of the matrices of eight triangles in their own planes.
pub(super) struct InPlane<L: Lanes> {
    /// Shape gradients of corners 1 and 2.
    pub g: [[Singles<L>; 2]; 2],
    /// The [`strain_rates`] of corners 1 and 2.
    pub b: [[[Singles<L>; 3]; 2]; 2],
    /// Stiffness 11, 12, 22, 66.
    pub law: [Singles<L>; 4],
    /// Stiffness 16 and 26, where there is any.
    pub coupling: Option<[Singles<L>; 2]>,
    /// ½·ℓ and 1/tr U of an exact tangent.
    pub turning: Option<[Singles<L>; 5]>,
}

impl<L: Lanes> InPlane<L> {
    /// The block of corners `i` and `j` in the triangle's axes, by rows.
    #[inline(always)]
    pub(super) fn block(&self, i: usize, j: usize) -> [[Singles<L>; 2]; 2] {
        let [c11, c12, c22, c66] = self.law;
        let (gi, gj, bi, bj) = (self.g[i], self.g[j], self.b[i], self.b[j]);
        let mut t0 = [c11 * bj[0][0] + c12 * bj[0][1], c12 * bj[0][0] + c22 * bj[0][1], c66 * bj[0][2]];
        let mut t1 = [c11 * bj[1][0] + c12 * bj[1][1], c12 * bj[1][0] + c22 * bj[1][1], c66 * bj[1][2]];
        if let Some([c16, c26]) = self.coupling {
            for (t, b) in [(&mut t0, bj[0]), (&mut t1, bj[1])] {
                t[0] = t[0] + c16 * b[2];
                t[1] = t[1] + c26 * b[2];
                t[2] = t[2] + c16 * b[0] + c26 * b[1];
            }
        }
        let mut a = [[dot(bi[0], t0), dot(bi[0], t1)], [dot(bi[1], t0), dot(bi[1], t1)]];
        if let Some([l11, l12, l21, l22, inverse]) = self.turning {
            // The spin of a corner is that along the second axis less that along the first.
            let spins = |g: [Singles<L>; 2]| [g[1] * inverse, g[0] * inverse];
            let along = |g: [Singles<L>; 2]| [l11 * g[0] + l12 * g[1], l21 * g[0] + l22 * g[1]];
            let (wi, wj, li, lj) = (spins(gi), spins(gj), along(gi), along(gj));
            a[0][0] = a[0][0] - (wi[0] * lj[0] + li[0] * wj[0]);
            a[0][1] = a[0][1] + (li[0] * wj[1] - wi[0] * lj[1]);
            a[1][0] = a[1][0] + (wi[1] * lj[0] - li[1] * wj[0]);
            a[1][1] = a[1][1] + (wi[1] * lj[1] + li[1] * wj[1]);
        }
        a
    }
}

/// Terms of the matrices of eight triangles.
struct Element<L: Lanes> {
    /// r₁, r₂ and the normal in global axes.
    axes: [[Singles<L>; 3]; 3],
    in_plane: InPlane<L>,
    /// Out-of-plane stiffness 11, 22, 12.
    normal: [Singles<L>; 3],
}

impl<L: Lanes> Element<L> {
    /// The block of corners `i` and `j` in global axes, by rows.
    #[inline(always)]
    fn block(&self, i: usize, j: usize) -> [[Entry; 3]; 3] {
        let [n11, n22, n12] = self.normal;
        let [r1, r2, n] = self.axes;
        let (gi, gj) = (self.in_plane.g[i], self.in_plane.g[j]);
        // In the triangle's axes; then the two halves of the turn into global ones.
        let a = self.in_plane.block(i, j);
        let nn = gi[0] * (n11 * gj[0] + n12 * gj[1]) + gi[1] * (n12 * gj[0] + n22 * gj[1]);
        let mut block = [[[Vec4::ZERO; 2]; 3]; 3];
        for y in 0..3 {
            let half = [a[0][0] * r1[y] + a[0][1] * r2[y], a[1][0] * r1[y] + a[1][1] * r2[y], nn * n[y]];
            for x in 0..3 {
                block[x][y] = (r1[x] * half[0] + r2[x] * half[1] + n[x] * half[2]).to_array();
            }
        }
        block
    }
}

#[cfg(test)]
mod tests {
    use super::super::lanes::Portable;
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
        in_plane: f64,
        coupling: [f64; 2],
    }

    impl Triangle {
        /// Any orientation, stretch, fibre and tension; the stiffness against spin is that of a projected tangent.
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
                in_plane: next().abs(),
                coupling: [0.6 * next(), 0.3 * next()],
            }
        }

        /// A rotated tangent, one with turning terms, or a weighted one.
        fn tangent(&self, kind: usize) -> ElementTangent<'_> {
            ElementTangent {
                state: self.state,
                rest: &self.rest,
                stiffness: &self.law,
                coupling: self.coupling,
                normal: self.normal,
                shear: self.in_plane * [1.0, 0.0, 0.4][kind],
                spin: self.in_plane,
                turning: [0.0, 1.0, 0.6][kind],
                elastic: 0.3,
                geometric: 0.2,
            }
        }
    }

    #[test]
    fn a_pack_is_the_tangent_but_for_rounding() {
        let mut next = numbers();
        for i in 0..200 {
            let kind = i % 3;
            let triangles: Vec<Triangle> = (0..3).map(|_| Triangle::new(&mut next)).collect();
            let pack = Pack::new(Portable, kind > 0, |lane| triangles.get(lane).map(|t| t.tangent(kind)));
            let u: Vec<Vec4> = (0..9).map(|_| Vec4::new(next() as f32, next() as f32, next() as f32, 0.0)).collect();
            // The empty lanes share its vertices with the first: they must add nothing.
            let places = [[0, 3, 6, 0, 0, 0, 0, 0], [1, 4, 7, 1, 1, 1, 1, 1], [2, 5, 8, 2, 2, 2, 2, 2]];
            let mut out = vec![Vec4::ZERO; 9];
            Pack::scatter(&places, pack.forces(Portable, &places, &u), &mut out);
            let (corners, edges) = pack.blocks(0);
            for (t, triangle) in triangles.iter().enumerate() {
                let tangent = triangle.tangent(kind);
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
