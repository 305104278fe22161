//! Forces and tangents against the energy, for both laws of fibres.

use super::{FIBRES, sheet, simulate};
use glam::{DMat3, DQuat, DVec3};
use rhexis::components::{Forces, Frames};
use rhexis::math::{
    FibreLaw, FibreResponse, GroundSubstance, HolzapfelGasserOgden, PreparedLaw, StiffeningFibres, Sym2,
};
use rhexis::settings::{Settings, Tangent};
use rhexis::storage::{Topology, Triangles, Vertices};
use rhexis::systems::forces::{assembly, corotation};
use rhexis::systems::solver::Operator;

/// Numbers in −1..1 without any pattern that matters: a linear congruential sequence.
fn numbers() -> impl FnMut() -> f64 {
    let mut state = 7_u64;
    move || {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
    }
}

/// A body's tables, to be looked at in any positions.
struct Tables {
    vertices: Vertices,
    triangles: Triangles,
    topology: Topology,
    is_planar: bool,
    law: FibreLaw,
}

/// Both laws, the published one with either matrix; the sheet's own q66 is the shear modulus of the neo-Hookean one.
fn laws() -> [FibreLaw; 3] {
    let published = |matrix| {
        let law = HolzapfelGasserOgden { matrix, ..HolzapfelGasserOgden::symmetric(0.3, 1.5, 35.0, 0.15) };
        FibreLaw::Published(PreparedLaw::new(&law, Sym2::IDENTITY))
    };
    [FibreLaw::Stiffening(FIBRES), published(GroundSubstance::Linear), published(GroundSubstance::NeoHookean)]
}

/// Energy per volume of the law of [`laws`], in plain formulas of C.
fn published_energy(u: Sym2, is_neo_hookean: bool, mu: f64) -> f64 {
    let c = [u.xx * u.xx + u.xy * u.xy, u.xx * u.xy + u.xy * u.yy, u.xy * u.xy + u.yy * u.yy];
    let first = c[0] + c[2] + 1.0 / (c[0] * c[2] - c[1] * c[1]);
    let (s, k) = 35_f64.to_radians().sin_cos();
    let fibres = [s, -s].map(|s| {
        let fourth = k * k * c[0] + 2.0 * s * k * c[1] + s * s * c[2];
        let e = f64::max(0.15 * (first - 3.0) + 0.55 * (fourth - 1.0), 0.0);
        0.3 / 3.0 * ((1.5 * e * e).exp() - 1.0)
    });
    fibres[0] + fibres[1] + if is_neo_hookean { 0.5 * mu * (first - 3.0) } else { 0.0 }
}

impl Tables {
    /// A sheet drawn out by a fifth on the average and thrown about by `noise`, in its plane or in space.
    fn new(is_planar: bool, noise: f64, law: FibreLaw) -> Self {
        let (simulation, body) = simulate(Settings::default(), sheet(30.0));
        let world = simulation.world();
        let mut vertices = (*world.get::<&Vertices>(body.entity()).unwrap()).clone();
        let mut next = numbers();
        let depth = if is_planar { 0.0 } else { noise };
        vertices.position.iter_mut().for_each(|x| {
            *x = DVec3::new(1.2 * x.x, 1.1 * x.y, 0.0) + DVec3::new(noise * next(), noise * next(), depth * next());
        });
        let triangles = (*world.get::<&Triangles>(body.entity()).unwrap()).clone();
        Self {
            vertices,
            triangles,
            topology: (*world.get::<&Topology>(body.entity()).unwrap()).clone(),
            is_planar,
            law,
        }
    }

    fn frames(&self, tangent: Tangent) -> Frames {
        let mut frames = Frames::default();
        corotation::evaluate(&self.vertices, &self.triangles, &mut frames, self.is_planar, None, Some(&self.law));
        corotation::geometric_stiffness(&mut frames, &self.triangles, tangent, -0.5);
        frames
    }

    /// ½·V·E:C:E + V·W, from the stretch alone.
    fn energy(&self) -> f64 {
        let (frames, triangles) = (self.frames(Tangent::Exact), &self.triangles);
        let energy = |t: usize| {
            let stretch = frames.state(t).polar.stretch;
            let strain = stretch - Sym2::IDENTITY;
            let linear = 0.5 * triangles.stiffness[t].stress(strain).contract(strain);
            let (mu, volume) = (triangles.stiffness[t].q66, triangles.rest[t].area * triangles.thickness[t]);
            let is_neo_hookean = self.law.replaces_linear();
            let own = match self.law {
                FibreLaw::Stiffening(fibres) => fibres.response(stretch.xx.hypot(stretch.xy) - 1.0).energy,
                FibreLaw::Published(_) => published_energy(stretch, is_neo_hookean, mu),
            };
            volume * (own + if is_neo_hookean { 0.0 } else { linear })
        };
        (0..triangles.len()).map(energy).sum()
    }

    fn forces(&self) -> Vec<DVec3> {
        let mut forces = Forces::default();
        let mesh = (&self.triangles, &self.topology);
        assembly::membrane_forces(mesh, &self.frames(Tangent::Exact), |_| DVec3::ZERO, 0.0, &mut forces);
        forces.nodal
    }

    fn operator<'a>(&'a self, frames: &'a Frames, tangent: Tangent) -> Operator<'a> {
        let Self { vertices, triangles, topology, .. } = self;
        let (external, folds, inertia, viscosity) = (None, None, 0.0, 0.0);
        Operator {
            folds,
            inertia,
            viscosity,
            external,
            ..Operator::membrane((vertices, triangles, topology, frames), tangent)
        }
    }

    /// `f` with a coordinate moved by ±h: its central difference.
    fn slope<T: std::ops::Sub<Output = T>>(&mut self, v: usize, axis: usize, h: f64, f: impl Fn(&Self) -> T) -> T {
        let x = self.vertices.position[v][axis];
        self.vertices.position[v][axis] = x + h;
        let plus = f(self);
        self.vertices.position[v][axis] = x - h;
        let minus = f(self);
        self.vertices.position[v][axis] = x;
        plus - minus
    }
}

#[test]
fn stress_and_stiffness_are_the_derivatives_of_the_energy_and_never_overflow() {
    let h = 1e-6;
    let limit = 2.0 / FIBRES.k2.sqrt();
    for e in [0.01, 0.1, 0.3, limit - 1e-3, limit + 1e-3, 2.0, 99.0] {
        let [low, at, high] = [e - h, e, e + h].map(|e| FIBRES.response(e));
        // Central differences: h² of the third derivative, and rounding of ε/h.
        let off = |plus: f64, minus: f64, slope: f64| ((plus - minus) / (2.0 * h) / slope - 1.0).abs();
        assert!(off(high.energy, low.energy, at.stress) < 2e-7, "{e}");
        assert!(off(high.stress, low.stress, at.stiffness) < 2e-7, "{e}");
    }
    // Stress and stiffness go through the limit without a jump.
    let [below, above] = [limit * (1.0 - 1e-12), limit * (1.0 + 1e-12)].map(|e| FIBRES.response(e));
    assert!(
        (above.stress / below.stress - 1.0).abs() < 1e-10 && (above.stiffness / below.stiffness - 1.0).abs() < 1e-10
    );
    assert!((above.stiffness / FIBRES.k1 - 9.0 * 4.0_f64.exp()).abs() < 1e-9, "491 of k₁");
    for fibres in [FIBRES, StiffeningFibres { k1: 1e12, k2: 1e9 }, StiffeningFibres { k1: 1e-300, k2: 1e-9 }] {
        for e in [1e-300, 1e-9, 1.0, 99.0, 1e6, 1e100] {
            let FibreResponse { energy, stress, stiffness } = fibres.response(e);
            assert!(energy.is_finite() && stress.is_finite() && stiffness.is_finite(), "{fibres:?} at {e}");
        }
    }
    assert_eq!(FIBRES.response(0.0), FIBRES.response(-3.0));
}

#[test]
fn forces_are_the_gradient_of_the_energy_and_the_exact_tangent_is_their_derivative() {
    for (is_planar, law) in [true, false].into_iter().flat_map(|is_planar| laws().map(|law| (is_planar, law))) {
        let mut body = Tables::new(is_planar, 0.1, law);
        let (forces, frames) = (body.forces(), body.frames(Tangent::Exact));
        let strains: Vec<f64> = frames.states().map(|s| s.polar.stretch.xx - 1.0).collect();
        assert!(strains.iter().any(|e| *e > 0.25) && strains.iter().all(|e| e.abs() > 1e-3), "{strains:?}");
        let n = forces.len();
        let largest = forces.iter().map(|f| f.length()).fold(0.0, f64::max);
        let h = 1e-5;
        for (v, axis) in (0..n).flat_map(|v| (0..if is_planar { 2 } else { 3 }).map(move |axis| (v, axis))) {
            let slope = body.slope(v, axis, h, Tables::energy) / (2.0 * h);
            // h² of a third derivative of some hundred times the forces, and rounding of the energy over h.
            assert!((slope + forces[v][axis]).abs() < 1e-8 * largest, "{slope} against {}", -forces[v][axis]);
            let mut unit = vec![DVec3::ZERO; n];
            unit[v][axis] = 1.0;
            let product: Vec<DVec3> = {
                let operator = body.operator(&frames, Tangent::Exact);
                (0..n).map(|row| operator.apply_at(row, &unit)).collect()
            };
            let size = product.iter().map(|k| k.length()).fold(0.0, f64::max);
            for row in 0..n {
                let slope = body.slope(v, axis, h, |body| body.forces()[row]) / (-2.0 * h);
                // As above.
                assert!((slope - product[row]).length() < 1e-7 * size, "{slope} against {}", product[row]);
            }
        }
    }
}

/// Whether K + `shift` is positive definite: by the pivots of its Cholesky factor.
fn is_definite(mut k: [[f64; 9]; 9], shift: f64) -> bool {
    (0..9).for_each(|i| k[i][i] += shift);
    (0..9).all(|p| {
        for i in p + 1..9 {
            let factor = k[i][p] / k[p][p];
            (p..9).for_each(|j| k[i][j] -= factor * k[p][j]);
        }
        k[p][p] > 0.0
    })
}

#[test]
fn rotated_and_projected_tangents_are_semidefinite() {
    let mut indefinite_count = 0;
    for (is_planar, law) in [true, false].into_iter().flat_map(|is_planar| laws().map(|law| (is_planar, law))) {
        let body = Tables::new(is_planar, 0.35, law);
        for tangent in [Tangent::Rotated, Tangent::Projected, Tangent::Exact] {
            let frames = body.frames(tangent);
            let operator = body.operator(&frames, tangent);
            for t in 0..body.triangles.len() {
                let matrix: [[f64; 9]; 9] = std::array::from_fn(|column| {
                    let mut unit = [DVec3::ZERO; 3];
                    unit[column / 3][column % 3] = 1.0;
                    let k = operator.element(t).apply(unit);
                    std::array::from_fn(|row| k[row / 3][row % 3])
                });
                let trace: f64 = (0..9).map(|i| matrix[i][i]).sum();
                // Rigid motions cost nothing but rounding: sums of thirty products.
                let is_semidefinite = is_definite(matrix, 1e-12 * trace);
                if tangent == Tangent::Exact {
                    indefinite_count += usize::from(!is_semidefinite);
                } else {
                    assert!(is_semidefinite, "triangle {t}, {tangent:?}");
                }
            }
        }
    }
    assert!(indefinite_count > 10, "{indefinite_count}: the test is to see tangents that are not");
}

#[test]
fn what_turns_keeps_its_stress_and_turns_its_forces() {
    laws().into_iter().for_each(keeps_its_stress);
}

fn keeps_its_stress(law: FibreLaw) {
    let mut body = Tables::new(false, 0.1, law);
    let (frames, forces) = (body.frames(Tangent::Exact), body.forces());
    let turn = DMat3::from_quat(DQuat::from_axis_angle(DVec3::new(1.0, 2.0, -0.5).normalize(), 2.0));
    body.vertices.position.iter_mut().for_each(|x| *x = turn * *x + DVec3::new(3.0, -1.0, 2.0));
    for (before, after) in frames.states().zip(body.frames(Tangent::Exact).states()) {
        let off = after.stress - before.stress;
        // Strains of positions of 10 mm over edges of 0.5 mm are known to 1e-14, and the stiffness is up to 1e3 MPa.
        assert!(off.contract(off).sqrt() < 1e-11, "{off:?}");
    }
    let largest = forces.iter().map(|f| f.length()).fold(0.0, f64::max);
    for (before, after) in forces.iter().zip(body.forces()) {
        assert!((turn * *before - after).length() < 1e-12 * largest);
    }
}
