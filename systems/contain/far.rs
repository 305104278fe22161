//! How far a solve's answer takes triangles, four side by side.

use crate::math::RestTriangle;
use crate::systems::kernels::lanes::{DOUBLES, Doubles, Lanes};
use crate::systems::kernels::membrane_lanes::{combine, dot, doubles};
use crate::systems::kernels::simd::Kernel;
use glam::{DVec2, DVec3};

/// How far triangles go: the rows have nothing in them. Of the sums the first says how many go far, at the least; the second is that of A·a⁴ with
/// the rest area A \[mm²\] and the norm a of the change of the deformation gradient.
pub struct Far<'a> {
    /// Vertices of the triangles.
    pub corners: &'a [[u32; 3]],
    /// Rest shapes.
    pub rest: &'a [RestTriangle],
    /// Displacement of the vertices \[mm\].
    pub displacement: &'a [DVec3],
    /// The a from which on a triangle goes far.
    pub from: f64,
}

impl Kernel<(), DVec2> for Far<'_> {
    #[inline(always)]
    fn run<L: Lanes>(&self, lanes: L, first: usize, rows: &mut [()]) -> DVec2 {
        let most_sq = self.from * self.from;
        let (mut count, mut sum) = (0, 0.0);
        for start in (first..first + rows.len()).step_by(DOUBLES) {
            let (mut edges, mut gradients, mut areas) = ([[0.0; DOUBLES]; 6], [[0.0; DOUBLES]; 4], [0.0; DOUBLES]);
            let within = (first + rows.len() - start).min(DOUBLES);
            for lane in 0..DOUBLES {
                let t = start + lane.min(within - 1);
                let [i, j, k] = self.corners[t];
                let u = self.displacement[i as usize];
                let (a, b) = (self.displacement[j as usize] - u, self.displacement[k as usize] - u);
                let [g1, g2] = self.rest[t].gradients;
                for (edge, value) in edges.iter_mut().zip([a.x, a.y, a.z, b.x, b.y, b.z]) {
                    edge[lane] = value;
                }
                for (gradient, value) in gradients.iter_mut().zip([g1.x, g1.y, g2.x, g2.y]) {
                    gradient[lane] = value;
                }
                areas[lane] = self.rest[t].area;
            }
            let [ax, ay, az, bx, by, bz] = doubles(lanes, &edges);
            let [g1x, g1y, g2x, g2y] = doubles(lanes, &gradients);
            let d1 = combine([ax, ay, az], g1x, [bx, by, bz], g2x);
            let d2 = combine([ax, ay, az], g1y, [bx, by, bz], g2y);
            let change_sq = dot(d1, d1) + dot(d2, d2);
            let weighted = (Doubles::new(lanes, areas) * change_sq * change_sq).to_array();
            let change_sq = change_sq.to_array();
            for lane in 0..within {
                // What is no number goes far.
                count += usize::from(!(change_sq[lane] <= most_sq));
                sum += weighted[lane];
            }
        }
        DVec2::new(count as f64, sum)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::systems::kernels::membrane::gradient;
    use crate::systems::kernels::simd::run;

    #[test]
    fn those_that_go_far_are_counted() {
        // Seventeen triangles, so that the last group is not whole.
        let wave = |i: u32, k: f64| (k * f64::from(i)).sin();
        let vector = |i: u32| DVec3::new(wave(i, 7.1), wave(i, 3.3), wave(i, 5.7));
        let corners: Vec<[u32; 3]> = (0..17).map(|t| [3 * t, 3 * t + 1, 3 * t + 2]).collect();
        let shape = |t: &[u32; 3]| [vector(t[0]), vector(t[1]) + DVec3::X * 3.0, vector(t[2]) + DVec3::Y * 3.0];
        let rest: Vec<_> = corners.iter().map(|t| RestTriangle::new(shape(t), DVec3::X).unwrap()).collect();
        let displacement: Vec<_> = (0..51).map(|i| vector(i + 100)).collect();
        let change = |t: usize| {
            let (d1, d2) = gradient(corners[t].map(|v| displacement[v as usize]), &rest[t]);
            (d1.length_squared() + d2.length_squared()).sqrt()
        };
        let largest = (0..corners.len()).map(change).fold(0.0, f64::max);
        let fourth: f64 = (0..corners.len()).map(|t| rest[t].area * change(t).powi(4)).sum();
        for (from, is_any) in [(1.001 * largest, false), (0.999 * largest, true), (f64::NAN, true)] {
            let far = Far { corners: &corners, rest: &rest, displacement: &displacement, from };
            let found = run(&far, 0, &mut vec![(); corners.len()]);
            assert_eq!(found.x > 0.0, is_any, "{from}");
            // Rounding of a sum of some dozen numbers.
            assert!((found.y - fourth).abs() <= 1e-14 * fourth, "{} {fourth}", found.y);
        }
    }
}
