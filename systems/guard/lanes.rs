//! Spurious energy of a solve, for four triangles side by side: bodies of the linear law with the rotated tangent, and all of the answer.

use super::solved::Solved;
use crate::math::GeometricStiffness;
use crate::systems::kernels::gather::{StateLanes, Stored, at_corners, gradients_of, law_of, less};
use crate::systems::kernels::lanes::{DOUBLES, Doubles, Lanes};
use crate::systems::kernels::membrane::LEAST_TRACE;
use crate::systems::kernels::membrane_lanes::{Vectors, combine, cross, dot, doubles, rotated};
use crate::systems::kernels::simd::Kernel;

/// T:E of two symmetric tensors, xx, yy and xy.
#[inline(always)]
fn contract<L: Lanes>(lanes: L, t: Vectors<L>, e: Vectors<L>) -> Doubles<L> {
    t[0] * e[0] + t[1] * e[1] + Doubles::splat(lanes, 2.0) * t[2] * e[2]
}

/// The stress by the law q₁₁, q₁₂, q₂₂, q₆₆.
#[inline(always)]
fn stress<L: Lanes>([q11, q12, q22, q66]: [Doubles<L>; 4], e: Vectors<L>) -> Vectors<L> {
    [q11 * e[0] + q12 * e[1], q12 * e[0] + q22 * e[1], (q66 + q66) * e[2]]
}

/// The stretch rate of a gradient change, in the frame of the axes: [`membrane`](crate::systems::kernels::membrane)'s.
#[inline(always)]
fn stretch_rate<L: Lanes>(
    lanes: L,
    [r1, r2]: [Vectors<L>; 2],
    [uxx, uyy, uxy]: Vectors<L>,
    inverse_trace: Doubles<L>,
    [d1, d2]: [Vectors<L>; 2],
) -> Vectors<L> {
    let (a12, a21) = (dot(r1, d2), dot(r2, d1));
    let spin = (a21 - a12) * inverse_trace;
    let xy = Doubles::splat(lanes, 0.5) * (a12 + spin * uyy + a21 - spin * uxx);
    [dot(r1, d1) + spin * uxy, dot(r2, d2) - spin * uxy, xy]
}

/// Triangles of a body, every one with its whole displacement: the rows have nothing in them.
pub(super) struct Whole<'a, 'b, S> {
    pub solved: &'a Solved<'b>,
    /// Of every triangle, as the body's are stored.
    pub state: &'a [S],
}

impl<S: Stored> Kernel<(), f64> for Whole<'_, '_, S> {
    #[inline(always)]
    fn run<L: Lanes>(&self, lanes: L, first: usize, rows: &mut [()]) -> f64 {
        let Self { solved, state } = self;
        let operator = &solved.operator;
        let (vertices, triangles, frames) = (operator.vertices, operator.triangles, operator.frames);
        let (thickness, stiffness) = (triangles.thickness.by_row(), triangles.stiffness.by_row());
        let pre_stretch = triangles.pre_stretch.by_row();
        let (zero, half, one) = (Doubles::splat(lanes, 0.0), Doubles::splat(lanes, 0.5), Doubles::splat(lanes, 1.0));
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
                let own = solved.law.unstretched - pre_stretch[t];
                (free[0][lane], free[1][lane], free[2][lane]) = (own.xx, own.yy, own.xy);
            }
            let free = doubles(lanes, &free);
            let of_group = (&triangles.corners[..], start);
            let [x, x1, x2] = at_corners(lanes, of_group, &|v| vertices.position[v]);
            let [u, u1, u2] = at_corners(lanes, of_group, &|v| solved.delta[v]);
            let ((f1, f2), (d1, d2)) = ((less(x1, x), less(x2, x)), (less(u1, u), less(u2, u)));
            let StateLanes { axes: [r1, r2], stretch: [uxx, uyy, uxy], stress: [txx, tyy, txy] } =
                S::lanes(lanes, of_lanes);
            let ([g1x, g1y, g2x, g2y], volume) = (Doubles::transpose(shape), Doubles::new(lanes, volume));
            let ([q11, q12, q22, q66], [nxx, nyy, nxy, in_plane]) =
                (Doubles::transpose(law), Doubles::transpose(geometric));
            let (d1, d2) = (combine(d1, g1x, d2, g2x), combine(d1, g1y, d2, g2y));
            let trace = uxx + uyy;
            // The work of the stress and of the tangent.
            let inverse_trace = one / trace.max(Doubles::splat(lanes, LEAST_TRACE));
            let law = [q11, q12, q22, q66];
            let rate = stretch_rate(lanes, [r1, r2], [uxx, uyy, uxy], inverse_trace, [d1, d2]);
            let elastic = contract(lanes, stress(law, rate), rate);
            let (deviator, shear) = (rate[0] - rate[1], rate[2] + rate[2]);
            let shear = in_plane * (deviator * deviator + shear * shear);
            let n = cross(r1, r2);
            let (m1, m2) = (dot(n, d1), dot(n, d2));
            let out_of_plane = nxx * m1 * m1 + two * nxy * m1 * m2 + nyy * m2 * m2;
            let mut work = contract(lanes, [txx, tyy, txy], rate) + damped * elastic + shear + out_of_plane;
            if is_damped_before {
                let [u, u1, u2] = at_corners(lanes, of_group, &|v| before[v]);
                let (d1, d2) = (less(u1, u), less(u2, u));
                let (d1, d2) = (combine(d1, g1x, d2, g2x), combine(d1, g1y, d2, g2y));
                let earlier = stretch_rate(lanes, [r1, r2], [uxx, uyy, uxy], inverse_trace, [d1, d2]);
                let along = [rate[0] + seen * earlier[0], rate[1] + seen * earlier[1], rate[2] + seen * earlier[2]];
                work = work + viscosity * contract(lanes, stress(law, earlier), along);
            }
            // What is stored at both ends.
            let (f1, f2) = (combine(f1, g1x, f2, g2x), combine(f1, g1y, f2, g2y));
            let (f1, f2) = (combine(f1, one, d1, one), combine(f2, one, d2, one));
            let end = rotated(lanes, f1, f2, solved.law.is_planar);
            let before = contract(lanes, [txx, tyy, txy], [uxx - free[0], uyy - free[1], uxy - free[2]]);
            let strain = [end.stretch[0] - free[0], end.stretch[1] - free[1], end.stretch[2] - free[2]];
            let after = contract(lanes, stress(law, strain), strain);
            let more = (volume * (half * (after - before) - work)).to_array();
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
        let sheet = Membrane::new("sheet", mesh, Material::figure_2()).fibres(Fibres::at_degrees(30.0));
        let mut simulation = Simulation::new(Settings { threads: 1, ..Settings::default() }).unwrap();
        let body = simulation.spawn(if is_planar { sheet.planar() } else { sheet }).unwrap();
        let wave = |v: usize, k: f64| (k * v as f64).sin();
        {
            let mut vertices = simulation.world().get::<&mut Vertices>(body).unwrap();
            for (v, x) in vertices.position.iter_mut().enumerate() {
                *x += DVec3::new(wave(v, 7.1), wave(v, 3.3), if is_planar { 0.0 } else { wave(v, 5.7) }) * 0.3;
            }
        }
        simulation.step(10.0).unwrap();
        let mut query = simulation
            .world()
            .query_one::<((&mut Vertices, &Triangles, &Topology, &Frames), (&mut Increment, &SolverScratch))>(body);
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
        let (is_counted, is_damped_before, rate) = (false, false, 0.1);
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
            rate,
        });
    }

    #[test]
    fn lanes_agree_with_one_triangle_after_another() {
        for is_planar in [false, true] {
            with_sheet(is_planar, |solved| {
                let count = solved.operator.triangles.len();
                let before = force_portable(true);
                // The step's first solve; a later one, with what damping has done in the first or without.
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
                    let passes = &mut BendingPasses::default();
                    solved.spurious_energy(1.0, &mut Sums { partials: &mut Vec::new(), passes })
                });
                // Rounding of the spurious energy, some hundred times what drag takes.
                assert!((without - with - 2e-3 * way).abs() < 1e-12 * without.abs(), "{without} {with} {way}");
            }
        });
    }
}
