//! The forces of a displacement on the corners of triangles: one after another for any law and tangent, and for four side by side where the
//! law is linear and the tangent the rotated one.

use super::Operator;
use crate::settings::Tangent;
use crate::systems::kernels::lanes::{DOUBLES, Doubles, Lanes};
use crate::systems::kernels::membrane::LEAST_TRACE;
use crate::systems::kernels::membrane_lanes::{
    Vectors, arrays, combine, cross, dot, doubles, first_piola, stress, stretch_rate,
};
use crate::systems::kernels::simd::Kernel;
use glam::DVec3;

/// K·u \[N\] of every triangle.
pub struct Products<'a> {
    /// The tangents.
    pub operator: &'a Operator<'a>,
    /// Displacement of the vertices \[mm\].
    pub u: &'a [DVec3],
}

impl Products<'_> {
    #[inline(always)]
    fn of_triangle(&self, t: usize) -> [DVec3; 3] {
        let [a, b, c] = self.operator.triangles.corners[t];
        self.operator.element(t).apply([self.u[a as usize], self.u[b as usize], self.u[c as usize]])
    }
}

/// c·v.
#[inline(always)]
fn scaled<L: Lanes>(v: Vectors<L>, c: Doubles<L>) -> Vectors<L> {
    [v[0] * c, v[1] * c, v[2] * c]
}

/// a + b.
#[inline(always)]
fn sum<L: Lanes>(a: Vectors<L>, b: Vectors<L>) -> Vectors<L> {
    [a[0] + b[0], a[1] + b[1], a[2] + b[2]]
}

impl Kernel<[DVec3; 3]> for Products<'_> {
    #[inline(always)]
    fn run<L: Lanes>(&self, lanes: L, first: usize, rows: &mut [[DVec3; 3]]) {
        let Operator { triangles, frames, viscosity, tangent, .. } = self.operator;
        if *tangent != Tangent::Rotated || !frames.stiffened.is_empty() {
            for (i, out) in rows.iter_mut().enumerate() {
                *out = self.of_triangle(first + i);
            }
            return;
        }
        let (thickness, stiffness) = (triangles.thickness.by_row(), triangles.stiffness.by_row());
        let (one, two) = (Doubles::splat(lanes, 1.0), Doubles::splat(lanes, 2.0));
        let damped = Doubles::splat(lanes, 1.0 + viscosity);
        for (group, out) in rows.chunks_mut(DOUBLES).enumerate() {
            let first = first + group * DOUBLES;
            let (mut edges, mut shape, mut axes) = ([[0.0; DOUBLES]; 6], [[0.0; DOUBLES]; 5], [[0.0; DOUBLES]; 6]);
            let (mut stretch, mut laws, mut geometric) =
                ([[0.0; DOUBLES]; 3], [[0.0; DOUBLES]; 4], [[0.0; DOUBLES]; 4]);
            for lane in 0..DOUBLES {
                // The last group is filled up with its last triangle.
                let t = first + lane.min(out.len() - 1);
                let [i, j, k] = triangles.corners[t];
                let u = self.u[i as usize];
                let (a, b) = (self.u[j as usize] - u, self.u[k as usize] - u);
                for (edge, value) in edges.iter_mut().zip([a.x, a.y, a.z, b.x, b.y, b.z]) {
                    edge[lane] = value;
                }
                let ([g1, g2], area) = (triangles.rest[t].gradients, triangles.rest[t].area);
                for (shape, value) in shape.iter_mut().zip([g1.x, g1.y, g2.x, g2.y, area * thickness[t]]) {
                    shape[lane] = value;
                }
                let polar = &frames.state[t].polar;
                let (r1, r2, u) = (polar.fibre_axis, polar.transverse_axis, polar.stretch);
                for (axis, value) in axes.iter_mut().zip([r1.x, r1.y, r1.z, r2.x, r2.y, r2.z]) {
                    axis[lane] = value;
                }
                for (stretch, value) in stretch.iter_mut().zip([u.xx, u.yy, u.xy]) {
                    stretch[lane] = value;
                }
                let (q, g) = (&stiffness[t], &frames.geometric[t]);
                for (law, value) in laws.iter_mut().zip([q.q11, q.q12, q.q22, q.q66]) {
                    law[lane] = value;
                }
                for (geometric, value) in geometric.iter_mut().zip([g.normal.xx, g.normal.yy, g.normal.xy, g.in_plane])
                {
                    geometric[lane] = value;
                }
            }
            let [ax, ay, az, bx, by, bz] = doubles(lanes, &edges);
            let [g1x, g1y, g2x, g2y, volume] = doubles(lanes, &shape);
            let [r1x, r1y, r1z, r2x, r2y, r2z] = doubles(lanes, &axes);
            let [uxx, uyy, uxy] = doubles(lanes, &stretch);
            let [nxx, nyy, nxy, in_plane] = doubles(lanes, &geometric);
            let (a, b) = ([ax, ay, az], [bx, by, bz]);
            let (d1, d2) = (combine(a, g1x, b, g2x), combine(a, g1y, b, g2y));
            let (r1, r2) = ([r1x, r1y, r1z], [r2x, r2y, r2z]);
            let inverse_trace = one / (uxx + uyy).max(Doubles::splat(lanes, LEAST_TRACE));
            let rate = stretch_rate(lanes, [r1, r2], [uxx, uyy, uxy], inverse_trace, [d1, d2]);
            let elastic = scaled(stress(doubles(lanes, &laws), rate), volume * damped);
            let shear = in_plane * volume;
            let deviator = shear * (rate[0] - rate[1]);
            let turned = [elastic[0] + deviator, elastic[1] - deviator, elastic[2] + two * shear * rate[2]];
            let pi = first_piola(turned, [uxx, uyy, uxy], inverse_trace);
            let n = cross(r1, r2);
            let (m1, m2) = (dot(n, d1), dot(n, d2));
            let (m1, m2) = ((nxx * m1 + nxy * m2) * volume, (nxy * m1 + nyy * m2) * volume);
            let p1 = sum(combine(r1, pi[0], r2, pi[2]), scaled(n, m1));
            let p2 = sum(combine(r1, pi[1], r2, pi[3]), scaled(n, m2));
            let (a, b) = (arrays(combine(p1, g1x, p2, g1y)), arrays(combine(p1, g2x, p2, g2y)));
            for (lane, out) in out.iter_mut().enumerate() {
                let a = DVec3::new(a[0][lane], a[1][lane], a[2][lane]);
                let b = DVec3::new(b[0][lane], b[1][lane], b[2][lane]);
                *out = [-a - b, a, b];
            }
        }
    }
}
