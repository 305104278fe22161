//! Products of the rotated tangent for four triangles side by side: [`ElementTangent::apply`], lane by lane.

use super::formulas::{Tangent, gradient, in_frame, rotated_rate, spread, with_normal_part};
use super::gather::{StateLanes, Stored, components, gradients_of, law_of, row};
use super::lanes::{DOUBLES, Doubles, Lanes};
use super::membrane::ElementTangent;
use super::membrane_lanes::put_forces;
use glam::DVec3;

/// Writes K·u \[N\] for the corners of up to four triangles, none of whose tangents is exact.
#[inline(always)]
pub fn apply<L: Lanes, S: Stored>(
    lanes: L,
    elements: &[ElementTangent<'_, &S>; DOUBLES],
    u: [[DVec3; 3]; DOUBLES],
    out: &mut [[DVec3; 3]],
) {
    let zero = Doubles::splat(lanes, 0.0);
    let (mut state, mut edges) = ([elements[0].state; DOUBLES], [[zero; DOUBLES]; 2]);
    let (mut gradients, mut law, mut stiff) = ([zero; DOUBLES], [zero; DOUBLES], [[zero; DOUBLES]; 2]);
    for (lane, e) in elements.iter().enumerate() {
        let from = row(lanes, u[lane][0]);
        edges[0][lane] = row(lanes, u[lane][1]) - from;
        edges[1][lane] = row(lanes, u[lane][2]) - from;
        state[lane] = e.state;
        gradients[lane] = gradients_of(lanes, e.rest);
        law[lane] = law_of(lanes, e.stiffness);
        stiff[0][lane] = Doubles::new(lanes, [e.coupling[0], e.shear, e.elastic, e.geometric]);
        stiff[1][lane] = Doubles::new(lanes, [e.normal.xx, e.normal.yy, e.normal.xy, e.coupling[1]]);
    }
    let StateLanes { axes, stretch, .. } = S::lanes(lanes, state);
    let gradients = Doubles::transpose(gradients);
    let [q16, in_plane, elastic, geometric] = Doubles::transpose(stiff[0]);
    let [nxx, nyy, nxy, q26] = Doubles::transpose(stiff[1]);
    let d = gradient([components(edges[0]), components(edges[1])], gradients);
    let (law, coupling, in_plane) = (Doubles::transpose(law), [q16, q26], in_plane * geometric);
    let pi = rotated_rate(in_frame(axes, d), stretch, Tangent { law, coupling, elastic, in_plane });
    let columns = with_normal_part(axes, pi, d, ([nxx, nyy, nxy], geometric));
    put_forces(spread(columns, gradients), out);
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::{ElementState, Orthotropic, Polar, RestTriangle, Sym2};
    use crate::systems::kernels::simd::{Pass, force_portable, pass};

    struct Products<'a>([ElementTangent<'a, &'a ElementState>; DOUBLES], [[DVec3; 3]; DOUBLES]);

    impl Pass for Products<'_> {
        type Output = [[DVec3; 3]; DOUBLES];

        #[inline(always)]
        fn run<L: Lanes>(self, lanes: L) -> Self::Output {
            let mut out = [[DVec3::ZERO; 3]; DOUBLES];
            apply(lanes, &self.0, self.1, &mut out);
            out
        }
    }

    fn element<'a, S>(lane: usize, state: S, of: (&'a RestTriangle, &'a Orthotropic)) -> ElementTangent<'a, S> {
        let ((rest, stiffness), lane) = (of, lane as f64);
        ElementTangent {
            state,
            rest,
            stiffness,
            coupling: [lane, 0.5 * lane],
            normal: Sym2::new(0.3 + 0.3 * lane, 0.2, 0.1),
            shear: 0.5 + 0.5 * lane,
            spin: 0.0,
            turning: 0.0,
            elastic: 1.2 + lane,
            geometric: 0.1 + 0.1 * lane,
        }
    }

    #[test]
    fn lanes_compute_what_one_triangle_does() {
        let rest =
            RestTriangle::new([DVec3::ZERO, DVec3::X, DVec3::new(0.3, 0.8, 0.0)], DVec3::new(1.0, 0.4, 0.0)).unwrap();
        let law = Orthotropic::new(10.0, 2.0, 0.3, 0.7).unwrap();
        // Stretched, squeezed to next to nothing, at rest, and sheared; some with terms that couple strain and shear.
        let stretches =
            [Sym2::new(1.2, 0.9, 0.1), Sym2::new(1e-3, 2e-3, 0.0), Sym2::IDENTITY, Sym2::new(1.0, 1.0, -0.4)];
        let states = [0.0_f64, 1.0, 2.0, 3.0].map(|turn| {
            let polar = Polar {
                fibre_axis: DVec3::new(turn.cos(), 0.6 * turn.sin(), 0.8 * turn.sin()),
                transverse_axis: DVec3::new(-turn.sin(), 0.6 * turn.cos(), 0.8 * turn.cos()),
                stretch: stretches[turn as usize],
            };
            ElementState { polar, stress: law.stress(polar.stretch - Sym2::IDENTITY) }
        });
        let elements = [0, 1, 2, 3].map(|lane| element(lane, &states[lane], (&rest, &law)));
        let u = [0.1, 0.7, -0.4, 0.9]
            .map(|s| [DVec3::new(s, 0.2, -s), DVec3::new(0.5, s * s, 0.3), DVec3::new(-0.1, s, s)]);
        let [wide, portable] = [false, true].map(|is_portable| {
            force_portable(is_portable);
            pass(Products(elements, u))
        });
        force_portable(false);
        assert!(wide == portable);
        for lane in 0..DOUBLES {
            let alone = element(lane, states[lane], (&rest, &law)).apply(u[lane]);
            for (a, b) in alone.into_iter().zip(wide[lane]) {
                // Forces are up to a hundred, with some dozen roundings.
                assert!((a - b).length() < 1e-12, "{lane}: {a} {b}");
                // Plain instructions take one triangle at a time, and give the same bits.
                assert_eq!(a, b, "{lane}");
            }
        }
    }
}
