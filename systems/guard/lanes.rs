//! Spurious energy of a solve, for four triangles side by side: bodies of the linear law with the rotated tangent, and all of the answer.

use super::solved::Solved;
use crate::math::GeometricStiffness;
use crate::math::number::{Real, linear_stress};
use crate::systems::kernels::formulas::{
    contract, cross, dot, gradient, in_frame, inverse_trace, less, plus, rates, scaled,
};
use crate::systems::kernels::gather::{StateLanes, Stored, at_corners, gradients_of, law_of};
use crate::systems::kernels::lanes::{DOUBLES, Doubles, Lanes};
use crate::systems::kernels::membrane_lanes::{doubles, rotated};
use crate::systems::kernels::simd::Kernel;

/// Kernel over the triangles of a body, with the whole answer; its rows are empty.
pub(super) struct Whole<'a, 'b, S> {
    pub solved: &'a Solved<'b>,
    /// States of all triangles, as the body's are stored.
    pub state: &'a [S],
}

impl<S: Stored> Kernel<(), f64> for Whole<'_, '_, S> {
    #[inline(always)]
    fn run<L: Lanes>(&self, lanes: L, first: usize, rows: &mut [()]) -> f64 {
        let Self { solved, state } = self;
        let operator = &solved.operator;
        let (vertices, triangles, frames) = (operator.vertices, operator.triangles, operator.frames);
        let (thickness, stiffness) = (triangles.thickness.by_row(), triangles.laws());
        let (unstretched, pre_stretch) = triangles.held(solved.law.unstretched);
        let (zero, half) = (Doubles::splat(lanes, 0.0), Doubles::splat(lanes, 0.5));
        let (two, damped) = (Doubles::splat(lanes, 2.0), Doubles::splat(lanes, 1.0 + operator.viscosity));
        let is_damped_before = solved.is_damped_before;
        let (before, viscosity) = (&solved.increment.displacement, Doubles::splat(lanes, operator.viscosity));
        let seen = Doubles::splat(lanes, if solved.is_counted { 0.0 } else { 1.0 });
        let mut sum = 0.0;
        for start in (first..first + rows.len()).step_by(DOUBLES) {
            let count = (first + rows.len() - start).min(DOUBLES);
            let (mut shape, mut law) = ([zero; DOUBLES], [zero; DOUBLES]);
            let (mut geometric, mut volume) = ([zero; DOUBLES], [0.0; DOUBLES]);
            let mut of_lanes = [&state[start]; DOUBLES];
            let mut free = [[0.0; DOUBLES]; 3];
            for lane in 0..DOUBLES {
                // The last group is filled up with its last triangle.
                let t = start + lane.min(count - 1);
                (shape[lane], law[lane]) = (gradients_of(lanes, &triangles.rest[t]), law_of(lanes, &stiffness[t]));
                let GeometricStiffness { normal, in_plane } = frames.geometric_stiffness(t);
                geometric[lane] = Doubles::new(lanes, [normal.xx, normal.yy, normal.xy, in_plane]);
                volume[lane] = triangles.rest[t].area * thickness[t];
                of_lanes[lane] = &state[t];
                let own = unstretched - pre_stretch[t];
                (free[0][lane], free[1][lane], free[2][lane]) = (own.xx, own.yy, own.xy);
            }
            let free = doubles(lanes, &free);
            let of_group = (&triangles.corners[..], start);
            let [x, x1, x2] = at_corners(lanes, of_group, &|v| vertices.position[v]);
            let [u, u1, u2] = at_corners(lanes, of_group, &|v| solved.delta[v]);
            let StateLanes { axes, stretch, stress: t } = S::lanes(lanes, of_lanes);
            let (gradients, volume) = (Doubles::transpose(shape), Doubles::new(lanes, volume));
            let (law, [nxx, nyy, nxy, in_plane]) = (Doubles::transpose(law), Doubles::transpose(geometric));
            let d = gradient([less(u1, u), less(u2, u)], gradients);
            // The work of the stress and of the tangent.
            let inverse_trace = inverse_trace(stretch);
            let (_, rate) = rates(in_frame(axes, d), stretch, inverse_trace);
            let elastic = contract(linear_stress(law, rate), rate);
            let (deviator, shear) = (rate[0] - rate[1], rate[2] + rate[2]);
            let shear = in_plane * (deviator * deviator + shear * shear);
            let n = cross(axes[0], axes[1]);
            let (m1, m2) = (dot(n, d[0]), dot(n, d[1]));
            let out_of_plane = nxx * m1 * m1 + two * nxy * m1 * m2 + nyy * m2 * m2;
            let mut work = contract(t, rate) + damped * elastic + shear + out_of_plane;
            if is_damped_before {
                let [u, u1, u2] = at_corners(lanes, of_group, &|v| before[v]);
                let d = gradient([less(u1, u), less(u2, u)], gradients);
                let (_, earlier) = rates(in_frame(axes, d), stretch, inverse_trace);
                let along = plus(rate, scaled(earlier, seen));
                work = work + viscosity * contract(linear_stress(law, earlier), along);
            }
            // Energy stored at both ends.
            let f = gradient([less(x1, x), less(x2, x)], gradients);
            let end = rotated(lanes, [plus(f[0], d[0]), plus(f[1], d[1])], solved.law.is_planar);
            let before = contract(t, less(stretch, free));
            let strain = less(end.rotated.stretch, free);
            let after = contract(linear_stress(law, strain), strain);
            let more = (volume * (half * (after - before) - work)).to_array();
            let trace = stretch[0] + stretch[1];
            // In a plane the law may have faded where the triangle starts, too.
            let sound =
                if solved.law.is_planar { zero - (zero - end.sound).max(zero - trace * trace) } else { end.sound };
            let [sound, least] = [sound.to_array(), end.least.to_array()];
            for lane in 0..count {
                sum += if sound[lane] > least[lane] { more[lane] } else { solved.of_triangle(start + lane, 1.0) };
            }
        }
        sum
    }
}

#[cfg(test)]
mod tests {
    //! The lanes against one triangle after another, and the instruction sets against each other.

    use super::super::line_search::Fraction;
    use super::super::*;
    use super::Whole;
    use crate::components::{Fibres, Material};
    use crate::math::Sym2;
    use crate::membrane::Membrane;
    use crate::settings::{Settings, Tangent};
    use crate::simulation::Simulation;
    use crate::storage::TriangleMesh;
    use crate::systems::kernels::simd::{force_portable, run};

    /// A sheet after a step, then thrown about: any shape and displacement, and some triangles collapsed to a point.
    fn with_sheet(is_planar: bool, f: impl FnOnce(&mut Solved)) {
        let positions = (0..48).map(|v| DVec3::new(f64::from(v % 8) * 1.4, f64::from(v / 8) * 1.6, 0.0)).collect();
        let cells = (0..5).flat_map(|row| (0..7).map(move |column| 8 * row + column));
        let triangles = cells.flat_map(|v| [[v, v + 1, v + 9], [v, v + 9, v + 8]]).collect();
        let mesh = TriangleMesh { positions, triangles, fibres: None };
        let sheet = Membrane::new("sheet", mesh, Material::allard_2009()).fibres(Fibres::at_degrees(30.0));
        let mut simulation = Simulation::new(Settings { threads: 1, ..Settings::default() }).unwrap();
        let body = simulation.spawn(if is_planar { sheet.planar() } else { sheet }).unwrap();
        let wave = |v: usize, k: f64| (k * v as f64).sin();
        {
            let mut vertices = simulation.world().get::<&mut Vertices>(body.entity()).unwrap();
            for (v, x) in vertices.position.iter_mut().enumerate() {
                *x += DVec3::new(wave(v, 7.1), wave(v, 3.3), if is_planar { 0.0 } else { wave(v, 5.7) }) * 0.3;
            }
        }
        simulation.step(10.0).unwrap();
        let mut query = simulation
            .world()
            .query_one::<((&mut Vertices, &Triangles, &Topology, &Frames), (&mut Increment, &SolverScratch))>(
                body.entity(),
            );
        let ((vertices, triangles, topology, frames), (increment, scratch)) = query.get().unwrap();
        for (v, u) in increment.delta.iter_mut().enumerate() {
            *u = DVec3::new(wave(v, 2.9), wave(v, 4.1), if is_planar { 0.0 } else { wave(v, 6.3) }) * 0.5;
        }
        for v in triangles.corners[3] {
            (vertices.position[v as usize], increment.delta[v as usize]) = (DVec3::ZERO, DVec3::X);
        }
        let tangent = Tangent::Rotated;
        let (inertia, viscosity) = (0.01, 0.7);
        let vertices = &*vertices;
        let operator =
            Operator { inertia, viscosity, ..Operator::membrane((vertices, triangles, topology, frames), tangent) };
        let unstretched = Sym2::new(0.98, 1.01, 0.005);
        let (is_counted, is_damped_before, inv_effective_dt) = (false, false, 0.1);
        let (free, residual, drag) = (&scratch.free, &scratch.residual, 0.0);
        let increment = &*increment;
        f(&mut Solved {
            operator,
            increment,
            delta: &increment.delta,
            free,
            law: BodyLaw { is_planar, unstretched, fibres: None },
            residual,
            is_counted,
            is_damped_before,
            drag,
            inv_effective_dt,
        });
    }

    #[test]
    fn lanes_agree_with_one_triangle_after_another() {
        for is_planar in [false, true] {
            with_sheet(is_planar, |solved| {
                let count = solved.operator.triangles.len();
                let before = force_portable(true);
                // The step's first solve; a later one, with the work of damping in the first or without.
                for (is_damped_before, is_counted) in [(false, false), (true, true), (true, false)] {
                    (solved.is_damped_before, solved.is_counted) = (is_damped_before, is_counted);
                    let each: Vec<f64> = (0..count).map(|t| solved.of_triangle(t, 1.0)).collect();
                    let wide = [true, false].map(|is_portable| {
                        force_portable(is_portable);
                        let Frames { solid, flat, .. } = solved.operator.frames;
                        if is_planar {
                            run(&Whole { solved, state: flat }, 0, &mut vec![(); count])
                        } else {
                            run(&Whole { solved, state: solid }, 0, &mut vec![(); count])
                        }
                    });
                    assert_eq!(wide[0].to_bits(), wide[1].to_bits(), "planar {is_planar}, later {is_damped_before}");
                    // Rounding of sums of work and energy, each some thousand times the spurious energy of the smallest triangle.
                    let (sum, size) = each.iter().fold((0.0, 0.0), |(sum, size), e| (sum + e, size + e.abs()));
                    assert!(
                        (wide[0] - sum).abs() <= 1e-12 * size,
                        "planar {is_planar}, later {is_damped_before}: {} for {sum}",
                        wide[0]
                    );
                }
                force_portable(before);
            });
        }
    }

    #[test]
    fn the_potential_along_a_whole_answer_needs_no_product() {
        with_sheet(false, |solved| {
            for (is_damped_before, is_counted) in [(false, false), (true, true)] {
                let (partials, pairs, passes) = (&mut Vec::new(), &mut Vec::new(), &mut BendingPasses::default());
                let (corner, [pull, product]) = (&mut Vec::new(), &mut [Vec::new(), Vec::new()]);
                let mut sums = Sums { partials, pairs, passes, corner, pull, product };
                let solved = Solved { is_damped_before, is_counted, ..*solved };
                solved.find_pull(&solved.operator, &mut sums);
                let Fraction { fraction, potential, .. } = solved.fraction(&solved.operator, &mut sums);
                // The fraction as the whole answer of another solve of the same load b: its residual is b − p·(b − s).
                let delta: Vec<DVec3> = solved.delta.iter().map(|u| *u * fraction).collect();
                let residual: Vec<DVec3> =
                    sums.pull.iter().zip(solved.residual).map(|(b, s)| *b - (*b - *s) * fraction).collect();
                let work = -delta.iter().zip(&residual).map(|(u, s)| u.dot(*s)).sum::<f64>();
                let part = Solved { delta: &delta, residual: &residual, ..solved };
                let energies = part.strained_and_damped(&mut sums);
                let without = part.potential(&part.operator, (&energies, work), sums.partials);
                // Rounding of energies and works that are some thousand times their sum.
                assert!((without - potential).abs() < 1e-12 * potential.abs(), "{without:e} {potential:e}");
            }
        });
    }

    #[test]
    fn what_drag_takes_is_not_left_over() {
        with_sheet(false, |solved| {
            let Solved {
                operator: Operator { triangles, .. }, increment: Increment { displacement, delta, .. }, ..
            } = solved;
            // Against c·A·(d + u)/dt along u, and c·A·d/dt along the way d before it where that is not counted yet.
            let [mut now, mut earlier] = [0.0; 2];
            for (corners, rest) in triangles.corners.iter().zip(triangles.rest.iter()) {
                for v in corners.map(|v| v as usize) {
                    now += rest.area / 3.0 * delta[v].dot(displacement[v] + delta[v]);
                    earlier += rest.area / 3.0 * displacement[v].length_squared();
                }
            }
            for (is_counted, way) in [(true, now), (false, now + earlier)] {
                solved.is_counted = is_counted;
                let [with, without] = [2e-3, 0.0].map(|drag| {
                    solved.drag = drag;
                    let (partials, pairs, passes) = (&mut Vec::new(), &mut Vec::new(), &mut BendingPasses::default());
                    let (corner, [pull, product]) = (&mut Vec::new(), &mut [Vec::new(), Vec::new()]);
                    solved.spurious_energy(1.0, &mut Sums { partials, pairs, passes, corner, pull, product })
                });
                // Rounding of the spurious energy, some hundred times the dissipation by drag.
                assert!((without - with - 2e-3 * way).abs() < 1e-12 * without.abs(), "{without} {with} {way}");
            }
        });
    }
}
