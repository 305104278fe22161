//! Eight triangles of a planar body side by side in single precision: the tangent as a symmetric 4×4 matrix, and its product.
//!
//! In a plane nothing moves along z, and the second axis of a triangle is the first one turned. Of [`super::pack`]'s 21 numbers per
//! triangle 10 are left, 40 bytes, and of the products 16 out of 36.

use super::lanes::{Lanes, Singles};
use super::membrane::ElementTangent;
use super::pack::{
    Entry, InPlane, LANES, Pack, Places, entries, gather, half_of, minus_sum, put_turning, singles, strain_rates,
};
use glam::{Mat4, Vec4};

/// The matrices \[N/mm\] of eight triangles, entries by rows of their blocks.
#[derive(Clone, Copy, Debug, Default)]
pub struct FlatPack {
    /// Upper triangle of the block of corner 1: xx, xy, yy.
    pub k11: [Entry; 3],
    /// Block of corner 1 (row) and corner 2 (column): xx, xy, yx, yy.
    pub k12: [Entry; 4],
    /// Upper triangle of the block of corner 2.
    pub k22: [Entry; 3],
}

impl FlatPack {
    /// The matrices of up to eight triangles of a planar body, all of them of one kind of tangent; a lane without one stays empty.
    #[inline(always)]
    pub fn new<'a, L: Lanes>(lanes: L, turns: bool, element: impl Fn(usize) -> Option<ElementTangent<'a>>) -> Self {
        let mut f = [[0.0_f32; LANES]; 12];
        let (mut turning, mut coupling) = ([[0.0_f32; LANES]; 5], [[0.0_f32; LANES]; 2]);
        for lane in 0..LANES {
            let Some(e) = element(lane) else { continue };
            if turns {
                put_turning(&e, lane, &mut turning);
            }
            coupling.iter_mut().zip(e.coupling).for_each(|(row, q)| row[lane] = (q * e.elastic) as f32);
            let r1 = e.state.polar.fibre_axis;
            let [q, s] = e.skew();
            let shear = e.shear * e.geometric;
            let [g1, g2] = e.rest.gradients;
            let values = [
                [r1.x, r1.y, q, s],
                [g1.x, g1.y, g2.x, g2.y],
                [
                    e.stiffness.q11 * e.elastic + shear,
                    e.stiffness.q12 * e.elastic - shear,
                    e.stiffness.q22 * e.elastic + shear,
                    e.stiffness.q66 * e.elastic + shear,
                ],
            ];
            for (row, value) in f.iter_mut().zip(values.as_flattened()) {
                row[lane] = *value as f32;
            }
        }
        let [c, sine, q, s, g1x, g1y, g2x, g2y, c11, c12, c22, c66] = singles(lanes, &f);
        let one = Singles::splat(lanes, 1.0);
        let in_plane = InPlane {
            g: [[g1x, g1y], [g2x, g2y]],
            b: [strain_rates(g1x, g1y, q, s, one), strain_rates(g2x, g2y, q, s, one)],
            law: [c11, c12, c22, c66],
            coupling: (coupling != [[0.0; LANES]; 2]).then(|| singles(lanes, &coupling)),
            turning: turns.then(|| singles(lanes, &turning)),
        };
        let k12 = turned(in_plane.block(0, 1), c, sine);
        let [xx, xy, _, yy] = turned(in_plane.block(0, 0), c, sine);
        let k11 = [xx, xy, yy];
        let [xx, xy, _, yy] = turned(in_plane.block(1, 1), c, sine);
        Self { k11, k12, k22: [xx, xy, yy] }
    }

    /// The product with `u` at corners 1 and 2 \[N\]; at corner 0 it is minus their sum.
    #[inline(always)]
    pub fn forces<L: Lanes>(&self, lanes: L, places: &Places, u: &[Vec4]) -> [[Singles<L>; 3]; 2] {
        let u0 = gather(lanes, &places[0], u);
        let (u1, u2) = (gather(lanes, &places[1], u), gather(lanes, &places[2], u));
        let (ax, ay, bx, by) = (u1[0] - u0[0], u1[1] - u0[1], u2[0] - u0[0], u2[1] - u0[1]);
        let (k, m, l) = (entries(lanes, &self.k11), entries(lanes, &self.k12), entries(lanes, &self.k22));
        let fx = (k[0] * ax + k[1] * ay) + (m[0] * bx + m[1] * by);
        let fy = (k[1] * ax + k[2] * ay) + (m[2] * bx + m[3] * by);
        let hx = (m[0] * ax + m[2] * ay) + (l[0] * bx + l[1] * by);
        let hy = (m[1] * ax + m[3] * ay) + (l[1] * bx + l[2] * by);
        let zero = Singles::splat(lanes, 0.0);
        [[fx, fy, zero], [hx, hy, zero]]
    }

    /// As [`Pack::blocks`], in the plane: the columns of a matrix are the entries of a [`super::flat_block`].
    #[inline(always)]
    pub fn blocks(&self, half: usize) -> ([Mat4; 3], [Mat4; 3]) {
        let (k, m, l) = (half_of(&self.k11, half), half_of(&self.k12, half), half_of(&self.k22, half));
        let (k11, k22) = ([[k[0], k[1]], [k[1], k[2]]], [[l[0], l[1]], [l[1], l[2]]]);
        // Columns, as all of these.
        let (k21, k12) = ([[m[0], m[1]], [m[2], m[3]]], [[m[0], m[2]], [m[1], m[3]]]);
        let (k10, k20) = (minus_sum(k11, k12), minus_sum(k21, k22));
        let k00 = minus_sum(k10, k20);
        ([k00, k11, k22].map(by_lane), [k10, k20, k21].map(by_lane))
    }

    /// The matrices as a pack in space, for readers of its blocks.
    #[inline(always)]
    pub fn in_space(&self) -> Pack {
        let ([k11, k12, k22], zero) = ([&self.k11[..], &self.k12, &self.k22], Entry::default());
        let symmetric = |k: &[Entry]| [k[0], k[1], zero, k[2], zero, zero];
        Pack {
            k11: symmetric(k11),
            k12: [k12[0], k12[1], zero, k12[2], k12[3], zero, zero, zero, zero],
            k22: symmetric(k22),
        }
    }
}

#[inline(always)]
fn by_lane([[xx, yx], [xy, yy]]: [[Vec4; 2]; 2]) -> Mat4 {
    Mat4::from_cols(xx, yx, xy, yy).transpose()
}

/// A block in the axes (c, s) and (−s, c) of the triangles in global ones: xx, xy, yx, yy.
#[inline(always)]
fn turned<L: Lanes>([[a11, a12], [a21, a22]]: [[Singles<L>; 2]; 2], c: Singles<L>, s: Singles<L>) -> [Entry; 4] {
    let ([x1, x2], [y1, y2]) = ([a11 * c - a12 * s, a21 * c - a22 * s], [a11 * s + a12 * c, a21 * s + a22 * c]);
    let [xx, xy, yx, yy] = [c * x1 - s * x2, c * y1 - s * y2, s * x1 + c * x2, s * y1 + c * y2];
    [xx.to_array(), xy.to_array(), yx.to_array(), yy.to_array()]
}

#[cfg(test)]
mod tests {
    use super::super::factor_block::FactorBlock;
    use super::super::flat_block::FlatBlock;
    use super::super::lanes::Portable;
    use super::*;
    use crate::math::{ElementState, Orthotropic, Polar, RestTriangle, Sym2};
    use glam::DVec3;

    /// Eight triangles in the plane, each turned, stretched and coupled in its own way.
    #[test]
    fn a_flat_pack_is_the_pack_of_a_plane() {
        let law = Orthotropic::new(10.0, 1.0, 0.3, 0.5).unwrap();
        let corners = [DVec3::ZERO, DVec3::new(1.1, 0.2, 0.0), DVec3::new(0.3, 0.9, 0.0)];
        let rest = RestTriangle::new(corners, DVec3::new(0.6, 0.8, 0.0)).unwrap();
        let states: Vec<ElementState> = (0..LANES)
            .map(|lane| {
                let (sine, cosine) = (0.7 * lane as f64).sin_cos();
                let stretch = Sym2::new(1.0 + 0.03 * lane as f64, 0.97, 0.02 * lane as f64 - 0.05);
                let (fibre_axis, transverse_axis) = (DVec3::new(cosine, sine, 0.0), DVec3::new(-sine, cosine, 0.0));
                let polar = Polar { fibre_axis, transverse_axis, stretch };
                ElementState { polar, stress: law.stress(stretch - Sym2::IDENTITY) }
            })
            .collect();
        for turning in [0.0, 1.0, 0.6] {
            let tangent = |lane: usize| {
                Some(ElementTangent {
                    state: states[lane],
                    rest: &rest,
                    stiffness: &law,
                    coupling: [0.1 * lane as f64, 0.05 * lane as f64],
                    normal: Sym2::ZERO,
                    shear: 0.2 * lane as f64 * (1.0 - turning),
                    spin: 0.2 * lane as f64,
                    turning,
                    elastic: 0.3,
                    geometric: 0.2,
                })
            };
            let (pack, flat) =
                (Pack::new(Portable, turning > 0.0, tangent), FlatPack::new(Portable, turning > 0.0, tangent));
            for half in 0..2 {
                let (corners, edges) = flat.blocks(half);
                let (corners_in_space, edges_in_space) = flat.in_space().blocks(half);
                for (block, in_space) in
                    corners.iter().chain(&edges).zip(corners_in_space.iter().chain(&edges_in_space))
                {
                    for lane in 0..LANES / 2 {
                        let in_space = [in_space[0].col(lane), in_space[1].col(lane), in_space[2].col(lane)];
                        assert_eq!(FlatBlock::new(block.col(lane)), FlatBlock::of(&in_space));
                    }
                }
            }
            let (of_pack, of_flat) = ([pack], [flat.in_space()]);
            let numbers = |p: &[Pack; 1]| [&p[0].k11[..], &p[0].k12, &p[0].k22].concat();
            let largest = pack.k11[0][0].max_element().max(pack.k22[3][0].max_element());
            for (a, b) in numbers(&of_pack).iter().zip(numbers(&of_flat)) {
                // Sums of some thirty products of that size, each rounded to half of 1.2e-7.
                let off = (a[0] - b[0]).abs().max((a[1] - b[1]).abs()).max_element();
                assert!(off <= 30.0 * f32::EPSILON * largest.max(10.0), "{off}");
            }
            let u: Vec<Vec4> = (0..9).map(|i| Vec4::new((i as f32).sin(), (2.0 * i as f32).cos(), 0.0, 0.0)).collect();
            let places = [[0, 3, 6, 0, 1, 2, 4, 5], [1, 4, 7, 2, 0, 3, 8, 6], [2, 5, 8, 4, 3, 1, 7, 0]];
            let mut out = [vec![Vec4::ZERO; 9], vec![Vec4::ZERO; 9]];
            Pack::scatter(&places, pack.forces(Portable, &places, &u), &mut out[0]);
            Pack::scatter(&places, flat.forces(Portable, &places, &u), &mut out[1]);
            for (a, b) in out[0].iter().zip(&out[1]) {
                assert!((*a - *b).length() <= 100.0 * f32::EPSILON * largest.max(10.0), "{a} {b}");
            }
        }
    }
}
