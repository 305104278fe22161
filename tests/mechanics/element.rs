//! The membrane element by derivatives: force = −dE/dx, exact tangent = −df/dx, no net force or torque; and by eigenvalues.

use glam::{DMat3, DQuat, DVec3};
use rhexis::math::{ElementState, Orthotropic, RestTriangle, Sym2};
use rhexis::systems::kernels::membrane::{
    ElementTangent, gradient, nodal_forces, second_piola, shear_majorant, spin_majorant, turning_weight,
};
use rhexis::systems::kernels::polar;

/// A fixed-seed generator is enough for shapes: splitmix64.
struct Random(u64);

impl Random {
    fn unit(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        ((z ^ (z >> 31)) >> 11) as f64 / (1u64 << 53) as f64
    }
    fn in_range(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.unit()
    }
    fn vector(&mut self, size: f64) -> DVec3 {
        DVec3::new(self.in_range(-size, size), self.in_range(-size, size), self.in_range(-size, size))
    }
}

struct Case {
    rest: RestTriangle,
    stiffness: Orthotropic,
    x: [DVec3; 3],
    planar: bool,
}

impl Case {
    fn random(r: &mut Random, planar: bool) -> Self {
        let rest_x =
            [DVec3::ZERO, DVec3::new(r.in_range(0.8, 1.4), r.in_range(-0.2, 0.2), 0.0), DVec3::new(0.3, 1.0, 0.0)];
        let angle = r.in_range(0.0, 6.3);
        let rest = RestTriangle::new(rest_x, DVec3::new(angle.cos(), angle.sin(), 0.0)).unwrap();
        let stiffness =
            Orthotropic::new(r.in_range(2.0, 20.0), r.in_range(0.5, 2.0), 0.3, r.in_range(0.2, 1.0)).unwrap();
        let axis = if planar { DVec3::Z } else { r.vector(1.0).normalize() };
        let turn = DMat3::from_quat(DQuat::from_axis_angle(axis, r.in_range(0.0, 6.0)));
        let x = rest_x.map(|p| {
            let mut noise = r.vector(0.15);
            if planar {
                noise.z = 0.0;
            }
            turn * (p + noise)
        });
        Self { rest, stiffness, x, planar }
    }
    fn state(&self, x: [DVec3; 3]) -> ElementState {
        let (f1, f2) = gradient(x, &self.rest);
        let polar = if self.planar { polar::planar(f1, f2) } else { polar::membrane(f1, f2) };
        ElementState { polar, stress: self.stiffness.stress(polar.stretch - Sym2::IDENTITY) }
    }
    fn energy(&self, x: [DVec3; 3]) -> f64 {
        let s = self.state(x);
        0.5 * self.rest.area * s.stress.contract(s.polar.stretch - Sym2::IDENTITY)
    }
    fn forces(&self, x: [DVec3; 3]) -> [DVec3; 3] {
        let s = self.state(x);
        nodal_forces(&s.polar, s.stress, &self.rest, self.rest.area)
    }
    fn exact_tangent<'a>(&'a self, state: &'a ElementState) -> ElementTangent<'a> {
        let normal = if self.planar { Sym2::ZERO } else { second_piola(state.stress, state.polar.stretch) };
        ElementTangent {
            state: *state,
            rest: &self.rest,
            stiffness: &self.stiffness,
            coupling: [0.0; 2],
            normal,
            shear: 0.0,
            spin: 0.0,
            turning: 1.0,
            elastic: self.rest.area,
            geometric: self.rest.area,
        }
    }
    fn nudged(&self, corner: usize, axis: usize, by: f64) -> [DVec3; 3] {
        let mut x = self.x;
        x[corner][axis] += by;
        x
    }
    fn axes(&self) -> usize {
        if self.planar { 2 } else { 3 }
    }
}

#[test]
fn forces_are_the_gradient_of_the_energy() {
    let mut r = Random(7);
    for i in 0..200 {
        let c = Case::random(&mut r, i % 2 == 0);
        let f = c.forces(c.x);
        for corner in 0..3 {
            for axis in 0..c.axes() {
                let h = 1e-5;
                let slope = (c.energy(c.nudged(corner, axis, h)) - c.energy(c.nudged(corner, axis, -h))) / (2.0 * h);
                // Central differences: h² · third derivative (about 20 MPa·mm) plus rounding 1e-16/h.
                assert!((slope + f[corner][axis]).abs() < 1e-7, "case {i}: {slope} against {}", -f[corner][axis]);
            }
        }
    }
}

#[test]
fn the_exact_tangent_is_the_derivative_of_the_forces() {
    let mut r = Random(11);
    for i in 0..200 {
        let c = Case::random(&mut r, i % 2 == 0);
        let state = c.state(c.x);
        let tangent = c.exact_tangent(&state);
        for corner in 0..3 {
            let block = tangent.diagonal_block(corner);
            for axis in 0..c.axes() {
                let mut u = [DVec3::ZERO; 3];
                u[corner][axis] = 1.0;
                let k = tangent.apply(u);
                let h = 1e-5;
                let (plus, minus) = (c.forces(c.nudged(corner, axis, h)), c.forces(c.nudged(corner, axis, -h)));
                for j in 0..3 {
                    let slope = (plus[j] - minus[j]) / (-2.0 * h);
                    // As above; the exact tangent of a 3D membrane at large strain has terms of 100 MPa.
                    assert!(
                        (slope - k[j]).length() < 2e-7,
                        "case {i} ({corner},{axis})->{j}: {slope} against {}",
                        k[j]
                    );
                }
                assert!((block.col(axis) - k[corner]).length() < 1e-12 * (1.0 + k[corner].length()));
                let [k11, k12, k22] = tangent.blocks();
                let off = match corner {
                    1 => (k11.col(axis) - k[1]).length() + (k12.transpose().col(axis) - k[2]).length(),
                    2 => (k12.col(axis) - k[1]).length() + (k22.col(axis) - k[2]).length(),
                    _ => 0.0,
                };
                // The same sums in another order.
                assert!(off < 1e-12 * (1.0 + k[1].length() + k[2].length()), "{off:e}");
            }
        }
    }
}

#[test]
fn no_net_force_or_torque_for_any_anisotropy() {
    let mut r = Random(13);
    for i in 0..500 {
        let c = Case::random(&mut r, i % 2 == 0);
        let f = c.forces(c.x);
        let torque: DVec3 = c.x.iter().zip(&f).map(|(x, f)| x.cross(*f)).sum();
        let size: f64 = f.iter().map(|f| f.length()).sum();
        // A few roundings of forces of that size at arms of about 1 mm.
        assert!((f[0] + f[1] + f[2]).length() <= 1e-15 * size && torque.length() < 1e-14 * (1.0 + size));
    }
}

#[test]
fn the_rotated_tangent_is_semidefinite_and_exerts_no_in_plane_torque() {
    let mut r = Random(17);
    for i in 0..200 {
        let c = Case::random(&mut r, i % 2 == 0);
        let state = c.state(c.x);
        let normal = second_piola(state.stress, state.polar.stretch).positive_part();
        let tangent = ElementTangent {
            state,
            rest: &c.rest,
            stiffness: &c.stiffness,
            coupling: [0.0; 2],
            normal,
            shear: shear_majorant(state.stress, state.polar.stretch, &c.stiffness, -0.5),
            spin: 0.0,
            turning: 0.0,
            elastic: c.rest.area,
            geometric: c.rest.area,
        };
        let u = [r.vector(1.0), r.vector(1.0), r.vector(1.0)];
        let k = tangent.apply(u);
        let form: f64 = u.iter().zip(&k).map(|(u, k)| u.dot(*k)).sum();
        assert!(form > -1e-12);
        let n = state.polar.fibre_axis.cross(state.polar.transverse_axis);
        let torque: DVec3 = c.x.iter().zip(&k).map(|(x, k)| x.cross(*k)).sum();
        assert!(torque.dot(n).abs() < 1e-12, "{torque}");
    }
}

/// A tangent by its columns: 9 × 9.
fn matrix(tangent: &ElementTangent) -> [[f64; 9]; 9] {
    std::array::from_fn(|column| {
        let mut u = [DVec3::ZERO; 3];
        u[column / 3][column % 3] = 1.0;
        let k = tangent.apply(u);
        std::array::from_fn(|row| k[row / 3][row % 3])
    })
}

/// Eigenvalues by cyclic Jacobi rotations; ten sweeps of a 9 × 9 matrix leave nothing off the diagonal.
fn eigenvalues(mut a: [[f64; 9]; 9]) -> [f64; 9] {
    for _ in 0..10 {
        for (p, q) in (0..9).flat_map(|p| (p + 1..9).map(move |q| (p, q))) {
            if a[p][q] == 0.0 {
                continue;
            }
            let (sin, cos) = (0.5 * (2.0 * a[p][q]).atan2(a[q][q] - a[p][p])).sin_cos();
            for k in 0..9 {
                (a[k][p], a[k][q]) = (cos * a[k][p] - sin * a[k][q], sin * a[k][p] + cos * a[k][q]);
            }
            for k in 0..9 {
                (a[p][k], a[q][k]) = (cos * a[p][k] - sin * a[q][k], sin * a[p][k] + cos * a[q][k]);
            }
        }
    }
    std::array::from_fn(|i| a[i][i])
}

#[test]
fn the_projected_tangent_is_the_exact_one_where_that_is_semidefinite_and_is_so_everywhere() {
    let mut r = Random(19);
    let [mut kept, mut projected_count] = [0; 2];
    for i in 0..400 {
        let mut c = Case::random(&mut r, i % 2 == 0);
        // From a quarter of the area, or mirrored in the plane, up to twice the area.
        let size = r.in_range(0.5, 1.4);
        c.x = c.x.map(|x| x * size);
        if i % 16 == 0 {
            c.x = c.x.map(|x| DVec3::new(-x.x, x.y, x.z));
        }
        let state = c.state(c.x);
        let exact = c.exact_tangent(&state);
        let spin = spin_majorant(state.stress, state.polar.stretch, &c.stiffness, [0.0; 2]);
        let projected = ElementTangent { normal: exact.normal.positive_part(), spin, ..exact };
        let (exact, projected) = (matrix(&exact), matrix(&projected));
        let values = eigenvalues(exact);
        let size = values.iter().fold(0.0_f64, |size, l| size.max(l.abs()));
        let difference = |a: &[[f64; 9]; 9], b: &[[f64; 9]; 9]| {
            a.iter().flatten().zip(b.iter().flatten()).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
        };
        // Sums of some thirty products each.
        let transposed: [[f64; 9]; 9] = std::array::from_fn(|i| std::array::from_fn(|j| projected[j][i]));
        let off = difference(&projected, &transposed) / size;
        assert!(off < 1e-12, "case {i}: {off:e}");
        let least = eigenvalues(projected).into_iter().fold(f64::INFINITY, f64::min);
        // Three translations and what was negative are zero but for rounding.
        assert!(least > -1e-12 * size, "case {i}: {least:e} of {size:e}");
        if values.iter().all(|l| *l > -1e-14 * size) {
            kept += 1;
            assert!(difference(&exact, &projected) < 1e-12 * size, "case {i}");
        } else if values.iter().any(|l| *l < -1e-12 * size) {
            projected_count += 1;
            assert!(difference(&exact, &projected) > 0.0, "case {i}");
        }
    }
    println!("{kept} semidefinite, {projected_count} projected");
    assert!(kept > 50 && projected_count > 50);
}

#[test]
fn the_weighted_tangent_is_the_projected_one_in_tension_the_rotated_one_where_slack_and_semidefinite_between() {
    let mut r = Random(23);
    let [mut taut, mut slack, mut between] = [0; 3];
    for i in 0..400 {
        let mut c = Case::random(&mut r, i % 2 == 0);
        let size = r.in_range(0.9, 1.3);
        c.x = c.x.map(|x| x * size);
        let state = c.state(c.x);
        let (stress, stretch) = (state.stress, state.polar.stretch);
        let exact = c.exact_tangent(&state);
        let normal = exact.normal.positive_part();
        let spin = spin_majorant(stress, stretch, &c.stiffness, [0.0; 2]);
        let majorant = shear_majorant(stress, stretch, &c.stiffness, -0.5);
        // The band between is narrow, and not met by chance.
        let turning = if i % 4 == 0 { r.in_range(0.0, 1.0) } else { turning_weight(stress, &c.stiffness) };
        let weighted = ElementTangent { normal, spin, turning, shear: (1.0 - turning) * majorant, ..exact };
        let projected = ElementTangent { normal, spin, ..exact };
        let rotated = ElementTangent { normal, shear: majorant, turning: 0.0, ..exact };
        let [weighted, projected, rotated] = [weighted, projected, rotated].map(|tangent| matrix(&tangent));
        let size = eigenvalues(projected).iter().fold(0.0_f64, |size, l| size.max(l.abs()));
        // A weighted mean of two semidefinite matrices, each entry a sum of some thirty products.
        let off = (0..9).flat_map(|row| (0..9).map(move |column| (row, column))).map(|(row, column)| {
            let mean = turning * projected[row][column] + (1.0 - turning) * rotated[row][column];
            (weighted[row][column] - mean).abs().max((weighted[row][column] - weighted[column][row]).abs())
        });
        assert!(off.fold(0.0, f64::max) < 1e-12 * size, "case {i}");
        let least = eigenvalues(weighted).into_iter().fold(f64::INFINITY, f64::min);
        assert!(least > -1e-12 * size, "case {i}: {least:e} of {size:e}");
        match turning {
            0.0 => slack += 1,
            1.0 => taut += 1,
            _ => between += 1,
        }
    }
    println!("{taut} in tension, {slack} slack, {between} between");
    assert!(taut > 50 && slack > 50 && between > 0);
}
