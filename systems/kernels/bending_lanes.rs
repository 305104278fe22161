//! Bending of four triangles side by side: the formulas of [`super::bending`], lane by lane.
//!
//! Layout: numbers over the edges of four triangles are [`EdgeValuesX4`], edge by edge; those of all triangles, one list, in which an edge of
//! a triangle has its `place`. The list ends with zeros, which stand for the triangle across at the boundary.

use super::bending::{self, EdgeMatrix, Tilt, least_twice_area};
use super::formulas::{dot, less, scaled};
use super::gather::{at_corners, components, row};
use super::lanes::{DOUBLES, Doubles, Lanes};
use super::membrane_lanes::{F64x4, Vectors, arrays, doubles};
use crate::math::number::Real;
use glam::DVec3;

/// Numbers over the edges of four triangles.
pub type EdgeValuesX4 = [F64x4; 3];

/// The numbers of four triangles in a list.
const NUMBERS_OF_FOUR: usize = 3 * DOUBLES;

/// The place of an edge of a triangle in a list of numbers.
#[inline(always)]
fn place(t: usize, e: usize) -> usize {
    t / DOUBLES * NUMBERS_OF_FOUR + e * DOUBLES + t % DOUBLES
}

/// The value of an edge of a triangle.
#[inline(always)]
pub fn at(values: &[EdgeValuesX4], t: usize, e: usize) -> f64 {
    values[t / DOUBLES][e][t % DOUBLES]
}

/// The values of the edges of a triangle.
#[inline(always)]
pub fn of_triangle(values: &[EdgeValuesX4], t: usize) -> DVec3 {
    DVec3::new(at(values, t, 0), at(values, t, 1), at(values, t, 2))
}

/// A triangle across an edge, and which edge of that it is.
pub type Across = Option<(usize, usize)>;

/// Rest state and bending coefficients of four triangles.
#[derive(Clone, Copy, Debug, Default)]
pub struct RestX4 {
    /// Bending laws of the four triangles.
    law: [F64x4; 6],
    /// Rotation of the mid-edge normals per difference of moments; none where a lane has no triangle.
    turn: EdgeValuesX4,
    /// 1 where there is a triangle across, else 0.
    inside: EdgeValuesX4,
    /// The place of every edge as the triangle across has it.
    across: [[u32; DOUBLES]; 3],
    /// Twice the areas up to which the triangles are collapsed.
    least: F64x4,
}

impl RestX4 {
    /// The triangles from `first` on of so many, each with its law, its turns, for each of its edges the triangle across and which
    /// edge of that it is, and its rest area.
    pub fn new(first: usize, count: usize, of: impl Fn(usize) -> (EdgeMatrix, DVec3, [Across; 3], f64)) -> Self {
        let nothing = (count.div_ceil(DOUBLES) * NUMBERS_OF_FOUR) as u32;
        let mut four = Self { across: [[nothing; DOUBLES]; 3], least: [f64::INFINITY; DOUBLES], ..Self::default() };
        for lane in 0..DOUBLES.min(count - first) {
            let (law, turn, across, area) = of(first + lane);
            (0..6).for_each(|i| four.law[i][lane] = law[i]);
            for e in 0..3 {
                four.turn[e][lane] = turn[e];
                if let Some((n, f)) = across[e] {
                    four.across[e][lane] = place(n, f) as u32;
                    four.inside[e][lane] = 1.0;
                }
            }
            four.least[lane] = least_twice_area(area);
        }
        four
    }

    /// The laws' products with vectors over the edges.
    #[inline(always)]
    pub fn product<L: Lanes>(&self, lanes: L, v: Vectors<L>) -> Vectors<L> {
        bending::symmetric_product(&doubles(lanes, &self.law), v)
    }

    /// Values of a list at the edges in the triangles across; zero at the boundary.
    #[inline(always)]
    pub fn others<L: Lanes>(&self, lanes: L, values: &[EdgeValuesX4]) -> Vectors<L> {
        let values = values.as_flattened().as_flattened();
        let mut others = [Doubles::splat(lanes, 0.0); 3];
        for e in 0..3 {
            let a = &self.across[e];
            let of_lanes = [values[a[0] as usize], values[a[1] as usize], values[a[2] as usize], values[a[3] as usize]];
            others[e] = Doubles::new(lanes, of_lanes);
        }
        others
    }

    /// Half the change of the angles for their own tilts and those of others.
    #[inline(always)]
    pub fn half_of_tilts<L: Lanes>(&self, lanes: L, own: Vectors<L>, tilts: &[EdgeValuesX4]) -> Vectors<L> {
        let (inside, others) = (doubles(lanes, &self.inside), self.others(lanes, tilts));
        let half = Doubles::splat(lanes, 0.5);
        [
            (own[0] * inside[0] + others[0]) * half,
            (own[1] * inside[1] + others[1]) * half,
            (own[2] * inside[2] + others[2]) * half,
        ]
    }

    /// Values in the triangles across less those of the triangles themselves.
    #[inline(always)]
    pub fn differences<L: Lanes>(&self, lanes: L, four: usize, values: &[EdgeValuesX4]) -> Vectors<L> {
        less(self.others(lanes, values), doubles(lanes, &values[four]))
    }

    /// Angles plus the rotations of the mid-edge normals by differences of moments.
    #[inline(always)]
    pub fn plus_turned<L: Lanes>(&self, lanes: L, angles: Vectors<L>, differences: Vectors<L>) -> Vectors<L> {
        let turn = doubles(lanes, &self.turn);
        [
            angles[0] + differences[0] * turn[0],
            angles[1] + differences[1] * turn[1],
            angles[2] + differences[2] * turn[2],
        ]
    }

    /// Which four the triangle across an edge is of, and the place of the edge among their numbers.
    #[inline(always)]
    pub fn across(&self, e: usize, lane: usize) -> (usize, usize) {
        let across = self.across[e][lane] as usize;
        (across / NUMBERS_OF_FOUR, across % NUMBERS_OF_FOUR)
    }
}

/// [`Tilt`] of four triangles.
#[derive(Clone, Copy, Debug, Default)]
pub struct TiltX4 {
    /// Unit normals.
    pub normal: [DVec3; DOUBLES],
    /// Minus the cotangents of the angles.
    minus_cotangent: EdgeValuesX4,
    /// One over the lengths of the edges.
    inverse_length: EdgeValuesX4,
}

/// The unit normals of four triangles, the edges, and one over twice the areas; and whether none is collapsed.
#[inline(always)]
fn normals<L: Lanes>(lanes: L, x: [Vectors<L>; 3], rest: &RestX4) -> (Vectors<L>, [Vectors<L>; 3], Doubles<L>, bool) {
    let edges = bending::edges(x);
    let normal = bending::twice_area_vector(edges);
    let twice_area = dot(normal, normal).sqrt();
    let inverse = Doubles::splat(lanes, 1.0) / twice_area;
    let is_sound = twice_area.is_larger(Doubles::new(lanes, rest.least));
    (scaled(normal, inverse), edges, inverse, is_sound)
}

/// Four vectors of components.
#[inline(always)]
fn vectors<L: Lanes>(lanes: L, [x, y, z]: Vectors<L>) -> [DVec3; DOUBLES] {
    let rows = Doubles::transpose([x, y, z, Doubles::splat(lanes, 0.0)]);
    let mut vectors = [DVec3::ZERO; DOUBLES];
    for lane in 0..DOUBLES {
        let [x, y, z, _] = rows[lane].to_array();
        vectors[lane] = DVec3::new(x, y, z);
    }
    vectors
}

/// Unit normals of the four triangles from `first` on with vertices at `x`; zero for those that are collapsed.
#[inline(always)]
pub fn unit_normals<L: Lanes>(
    lanes: L,
    triangles: (&[[u32; 3]], usize),
    x: &impl Fn(usize) -> DVec3,
    rest: &RestX4,
) -> [DVec3; DOUBLES] {
    let (normal, _, _, is_sound) = normals(lanes, at_corners(lanes, triangles, x), rest);
    if is_sound { vectors(lanes, normal) } else { alone(triangles, x, rest, |tilt| tilt.normal) }
}

/// A value of each of four triangles, found by itself.
#[inline(never)]
fn alone<T: Default + Copy>(
    (corners, first): (&[[u32; 3]], usize),
    x: &impl Fn(usize) -> DVec3,
    rest: &RestX4,
    of: impl Fn(Tilt) -> T,
) -> [T; DOUBLES] {
    let mut each = [T::default(); DOUBLES];
    for (lane, (corners, each)) in corners[first..].iter().zip(&mut each).enumerate() {
        *each = of(Tilt::new(corners.map(|v| x(v as usize)), rest.least[lane]));
    }
    each
}

impl TiltX4 {
    /// Tilts of the four triangles from `first` on with vertices at `x`.
    #[inline(always)]
    pub fn new<L: Lanes>(
        lanes: L,
        triangles: (&[[u32; 3]], usize),
        x: &impl Fn(usize) -> DVec3,
        rest: &RestX4,
    ) -> Self {
        let (normal, edges, inverse, is_sound) = normals(lanes, at_corners(lanes, triangles, x), rest);
        if !is_sound {
            let each = alone(triangles, x, rest, |tilt| tilt);
            let mut four = Self::default();
            for (lane, tilt) in each.iter().enumerate() {
                four.normal[lane] = tilt.normal;
                for e in 0..3 {
                    four.minus_cotangent[e][lane] = tilt.minus_cotangent[e];
                    four.inverse_length[e][lane] = tilt.inverse_length[e];
                }
            }
            return four;
        }
        let one = Doubles::splat(lanes, 1.0);
        let [a, b, c] = edges;
        let inverse_length = [one / dot(a, a).sqrt(), one / dot(b, b).sqrt(), one / dot(c, c).sqrt()];
        Self {
            normal: vectors(lanes, normal),
            minus_cotangent: arrays(bending::minus_cotangents(edges, inverse)),
            inverse_length: arrays(inverse_length),
        }
    }

    /// Tilt of one of the four triangles.
    #[inline(always)]
    pub fn lane(&self, lane: usize) -> Tilt {
        let (c, l) = (&self.minus_cotangent, &self.inverse_length);
        let minus_cotangent = DVec3::new(c[0][lane], c[1][lane], c[2][lane]);
        let inverse_length = DVec3::new(l[0][lane], l[1][lane], l[2][lane]);
        Tilt { normal: self.normal[lane], minus_cotangent, inverse_length }
    }

    /// The tilts when the corners move by `u`.
    #[inline(always)]
    pub fn of<L: Lanes>(&self, lanes: L, u: [Vectors<L>; 3]) -> Vectors<L> {
        let mut rows = [row(lanes, DVec3::ZERO); DOUBLES];
        for lane in 0..DOUBLES {
            rows[lane] = row(lanes, self.normal[lane]);
        }
        let n = components(rows);
        let (a, b) = (dot(n, less(u[1], u[0])), dot(n, less(u[2], u[0])));
        let (c, l) = (doubles(lanes, &self.minus_cotangent), doubles(lanes, &self.inverse_length));
        let tilts = bending::tilts(c, a, b);
        [tilts[0] * l[0], tilts[1] * l[1], tilts[2] * l[2]]
    }

    /// Forces on the corners along the normal from moments about the edges.
    #[inline(always)]
    pub fn along<L: Lanes>(&self, lanes: L, moment: Vectors<L>) -> Vectors<L> {
        let (c, l) = (doubles(lanes, &self.minus_cotangent), doubles(lanes, &self.inverse_length));
        bending::forces_along(c, [moment[0] * l[0], moment[1] * l[1], moment[2] * l[2]])
    }
}

#[cfg(test)]
mod tests {
    //! The lanes against one triangle after another, on both instruction sets.

    use super::super::simd::{Kernel, force_portable, run};
    use super::*;

    /// Results for four triangles: tilts, and the effects of a displacement and of moments.
    #[derive(Clone, Default)]
    struct Found {
        tilt: TiltX4,
        normals: [DVec3; DOUBLES],
        of: EdgeValuesX4,
        along: EdgeValuesX4,
    }

    struct All<'a> {
        corners: &'a [[u32; 3]],
        x: &'a [DVec3],
        u: &'a [DVec3],
        rest: &'a [RestX4],
    }

    impl Kernel<Found> for All<'_> {
        #[inline(always)]
        fn run<L: Lanes>(&self, lanes: L, first: usize, rows: &mut [Found]) {
            for (four, found) in (first..).zip(rows) {
                let (triangles, x) = ((self.corners, DOUBLES * four), |v: usize| self.x[v]);
                found.normals = unit_normals(lanes, triangles, &x, &self.rest[four]);
                found.tilt = TiltX4::new(lanes, triangles, &x, &self.rest[four]);
                let tilts = found.tilt.of(lanes, at_corners(lanes, triangles, &|v| self.u[v]));
                (found.of, found.along) = (arrays(tilts), arrays(found.tilt.along(lanes, tilts)));
            }
        }
    }

    fn bits(x: DVec3) -> [u64; 3] {
        x.to_array().map(f64::to_bits)
    }

    #[test]
    fn lanes_agree_with_one_triangle_after_another() {
        // Any shape; one flat as a line, one a point, one without end, one crushed to less than a thousandth. Not a multiple of
        // four.
        let wave = |i: usize, k: f64| (k * i as f64).sin();
        let vector = |i: usize, k: f64| DVec3::new(wave(i, 7.1 * k), wave(i, 3.3 * k), wave(i, 5.7 * k));
        let corners: Vec<[u32; 3]> = (0..39).map(|t| [3 * t, 3 * t + 1, 3 * t + 2]).collect();
        let mut x: Vec<DVec3> = (0..117).map(|v| vector(v, 1.0)).collect();
        let u: Vec<DVec3> = (0..117).map(|v| vector(v, 1.7)).collect();
        x[14] = x[12] + (x[13] - x[12]) * 2.0;
        (x[27], x[28], x[29]) = (DVec3::X, DVec3::X, DVec3::X);
        x[45] = DVec3::splat(f64::INFINITY);
        x[62] = x[60] + (x[61] - x[60]) * 0.3 + DVec3::Z * 1e-4;
        let alike = |_| (EdgeMatrix::default(), DVec3::ZERO, [None; 3], 0.5);
        let rest: Vec<RestX4> = (0..39).step_by(DOUBLES).map(|first| RestX4::new(first, 39, alike)).collect();
        let before = force_portable(true);
        for is_portable in [true, false] {
            force_portable(is_portable);
            let mut found = vec![Found::default(); rest.len()];
            run(&All { corners: &corners, x: &x, u: &u, rest: &rest }, 0, &mut found);
            for (t, corners) in corners.iter().enumerate() {
                let Found { tilt, normals, of, along } = &found[t / DOUBLES];
                let alone = Tilt::new(corners.map(|v| x[v as usize]), least_twice_area(0.5));
                let tilts = alone.of(corners.map(|v| u[v as usize]));
                let lane = t % DOUBLES;
                assert_eq!(tilt.lane(lane), alone, "triangle {t}, portable {is_portable}");
                assert_eq!(normals[lane], alone.normal, "triangle {t}, portable {is_portable}");
                let [of, along] = [of, along].map(|values| of_triangle(std::slice::from_ref(values), lane));
                assert_eq!([of, along].map(bits), [tilts, alone.along(tilts)].map(bits), "triangle {t}");
            }
        }
        force_portable(before);
    }
}
