//! The co-rotational membrane element: force, rotated tangent and exact tangent of the energy ½·A·h·(U−I):C:(U−I).
//!
//! Everything in-plane is written in the triangle's own axes (fibre, transverse). A 2×2 matrix there is `[m11, m12, m21, m22]`.
//! J = [[0, −1], [1, 0]]. For a change dF of the deformation gradient, a = RᵀdF gives the spin ω = (a₂₁ − a₁₂)/tr U and the
//! stretch rate dU = a − ω·J·U. The first Piola–Kirchhoff stress in the frame is Π = T − (κ/tr U)·J with
//! κ = (T₂₂ − T₁₁)·U₁₂ + T₁₂·(U₁₁ − U₂₂): T contracted with dU. The classical co-rotational force leaves the second term out;
//! it is then no gradient of any energy, and an anisotropic triangle spins by itself.

use crate::math::{ElementState, Orthotropic, Polar, RestTriangle, Sym2};
use glam::{DMat3, DVec2, DVec3};

/// In-plane 2×2 matrix `[m11, m12, m21, m22]`.
type Mat = [f64; 4];

/// Below this tr U the spin term is held bounded. Reached by mirrored triangles of planar bodies only: in space tr U is at
/// least the norm of F, and the term is bounded by the stress.
const LEAST_TRACE: f64 = 1e-2;

/// The columns f₁, f₂ of the deformation gradient (or of any gradient, given nodal values) in the fibre's rest frame.
#[inline]
pub fn gradient(x: [DVec3; 3], rest: &RestTriangle) -> (DVec3, DVec3) {
    let [g1, g2] = rest.gradients;
    let (a, b) = (x[1] - x[0], x[2] - x[0]);
    (a * g1.x + b * g2.x, a * g1.y + b * g2.y)
}

/// κ/tr U: the size of the skew part of Π.
#[inline]
fn spin_stress(stress: Sym2, stretch: Sym2) -> f64 {
    let kappa = (stress.yy - stress.xx) * stretch.xy + stress.xy * (stretch.xx - stretch.yy);
    kappa / stretch.trace().max(LEAST_TRACE)
}

/// Π = T − (κ/tr U)·J: the energy-consistent first Piola–Kirchhoff stress in the frame.
#[inline]
fn first_piola(stress: Sym2, stretch: Sym2) -> Mat {
    let spin = spin_stress(stress, stretch);
    [stress.xx, stress.xy + spin, stress.xy - spin, stress.yy]
}

/// Forces on the three corners \[N\], −V·R·Π·∇N_i, of a triangle with rest volume V = A·h \[mm³\] under the stress `stress`.
#[inline]
pub fn nodal_forces(polar: &Polar, stress: Sym2, rest: &RestTriangle, volume: f64) -> [DVec3; 3] {
    spread(polar, first_piola(stress, polar.stretch), DVec2::ZERO, rest, volume)
}

/// −V·(R·Π + n ⊗ m)·∇N_i for the three corners.
#[inline]
fn spread(polar: &Polar, pi: Mat, normal_row: DVec2, rest: &RestTriangle, volume: f64) -> [DVec3; 3] {
    let (r1, r2) = (polar.fibre_axis, polar.transverse_axis);
    let n = r1.cross(r2);
    let p1 = r1 * pi[0] + r2 * pi[2] + n * normal_row.x;
    let p2 = r1 * pi[1] + r2 * pi[3] + n * normal_row.y;
    let [g1, g2] = rest.gradients;
    let a = (p1 * g1.x + p2 * g1.y) * -volume;
    let b = (p1 * g2.x + p2 * g2.y) * -volume;
    [-a - b, a, b]
}

/// Second Piola–Kirchhoff stress S = U⁻¹·Π \[MPa\] (symmetric). It carries the out-of-plane stiffness; T in its place is 16 %
/// wrong at 15 % stretch.
#[inline]
pub fn second_piola(stress: Sym2, stretch: Sym2) -> Sym2 {
    let pi = first_piola(stress, stretch);
    // A triangle squeezed to less than 1 % of its area has no meaningful S: the bound keeps it finite.
    let trace = stretch.trace();
    let inverse = 1.0 / stretch.determinant().max(2.5e-3 * trace * trace).max(f64::MIN_POSITIVE);
    let xy = stretch.yy * pi[1] - stretch.xy * pi[3];
    let yx = stretch.xx * pi[2] - stretch.xy * pi[0];
    Sym2::new(
        (stretch.yy * pi[0] - stretch.xy * pi[2]) * inverse,
        (stretch.xx * pi[3] - stretch.xy * pi[1]) * inverse,
        0.5 * (xy + yx) * inverse,
    )
}

/// Spin ω and stretch rate dU for a gradient change `a` = RᵀdF.
#[inline]
fn rates(a: Mat, stretch: Sym2) -> (f64, Sym2) {
    let spin = (a[2] - a[1]) / stretch.trace().max(LEAST_TRACE);
    // J·U = [[−U12, −U22], [U11, U12]]; both off-diagonal entries of a − ω·J·U are equal, their mean halves the rounding.
    let xy = 0.5 * (a[1] + spin * stretch.yy + a[2] - spin * stretch.xx);
    (spin, Sym2::new(a[0] + spin * stretch.xy, a[3] - spin * stretch.xy, xy))
}

/// dU for nodal velocities (or displacements) `u`: the exact strain rate, zero for every rigid motion.
#[inline]
pub fn stretch_rate(polar: &Polar, rest: &RestTriangle, u: [DVec3; 3]) -> Sym2 {
    let (d1, d2) = gradient(u, rest);
    rates(in_frame(polar, d1, d2), polar.stretch).1
}

#[inline]
fn in_frame(polar: &Polar, d1: DVec3, d2: DVec3) -> Mat {
    let (r1, r2) = (polar.fibre_axis, polar.transverse_axis);
    [r1.dot(d1), r1.dot(d2), r2.dot(d1), r2.dot(d2)]
}

/// What the rotated tangent adds to the stress rate \[MPa\] so that tension does not make the linearly implicit step unstable.
///
/// A tension T stiffens in-plane waves as it does a string. A step whose tangent K̃ lacks that multiplies a wave of the true
/// stiffness K by 1 − K/K̃ and blows up where K > 2K̃: for a shear wave along the tension above T = 1.3·G. The term cannot be had
/// from the exact geometric stiffness, which resists the spin ω and would brake rotation. But spin comes with stretching: the
/// mean of det(ω·J·U + dU) over a sheet with held edges vanishes, since it is a divergence. In the axes n, m of the principal
/// stresses, with s = n·dU·m, this bounds the part of T by c·T·s² + (2T/λ_m)·|dU_nn·dU_mm|, c = (λ_n + 2λ_m)/λ_m². Half of that
/// would do inside; free edges need about all of it (measured: E_F/E_T = 100 at 30 % stretch grew by 1.6 a step with half). A
/// part of the material's own stiffness is taken off, so that small tensions add nothing.
#[inline]
fn wave_stress(law: &Orthotropic, stress: Sym2, stretch: Sym2, du: Sym2) -> Sym2 {
    let mean = 0.5 * (stress.xx + stress.yy);
    let (tn, ts) = (0.5 * (stress.xx - stress.yy), stress.xy);
    // A bound of the larger principal stress: a lightly loaded triangle pays no square root.
    if mean + tn.abs() + ts.abs() <= LEAST_WAVE_TENSION * law.q66.min(law.q22).min(law.q11) {
        return Sym2::ZERO;
    }
    let radius = tn.hypot(ts);
    // Twice the angle from the fibre to n.
    let (cos, sin) = if radius > 0.0 { (tn / radius, ts / radius) } else { (1.0, 0.0) };
    let nn = Sym2::new(0.5 + 0.5 * cos, 0.5 - 0.5 * cos, 0.5 * sin);
    let mm = Sym2::IDENTITY - nn;
    let nm = Sym2::new(-0.5 * sin, 0.5 * sin, 0.5 * cos);
    let trace = stretch.trace();
    // A triangle squeezed to a tenth of its width has no meaningful wave: the bound keeps the term finite.
    let least = (0.1 * trace).max(f64::MIN_POSITIVE);
    let (ln, lm) = (stretch.contract(nn).max(least), stretch.contract(mm).max(least));
    let (tension_n, tension_m) = ((mean + radius).max(0.0), (mean - radius).max(0.0));

    let shear = tension_n * (ln + 2.0 * lm) / (lm * lm) + tension_m * (lm + 2.0 * ln) / (ln * ln);
    let (cnn, cmm) = (law.stress(nn), law.stress(mm));
    let (qn, qm, coupling) = (cnn.contract(nn), cmm.contract(mm), cnn.contract(mm));
    let across = |tension: f64, width: f64, q_along: f64, q_across: f64| {
        let product = tension / width + coupling;
        if tension > 0.0 { (product * product / q_along - 0.5 * q_across).max(0.0) } else { 0.0 }
    };
    let of_shear = (shear - 2.0 * law.q66).max(0.0) * nm.contract(du);
    let of_m = across(tension_n, lm, qn, qm) * mm.contract(du);
    let of_n = across(tension_m, ln, qm, qn) * nn.contract(du);
    nm * of_shear + mm * of_m + nn * of_n
}

/// Principal stress, over the least modulus, below which [`wave_stress`] is zero, or too small to matter.
const LEAST_WAVE_TENSION: f64 = 0.2;

/// A triangle's tangent, ready to be applied to any displacement.
#[derive(Clone, Copy, Debug)]
pub struct ElementTangent<'a> {
    /// State at the positions where the tangent is taken.
    pub state: &'a ElementState,
    /// Rest shape.
    pub rest: &'a RestTriangle,
    /// Elastic constants.
    pub stiffness: &'a Orthotropic,
    /// Out-of-plane stiffness \[MPa\]: S⁺ for the rotated tangent, S for the exact one.
    pub normal: Sym2,
    /// A·h times the factor of the elastic part (1, or 1 + β/dt with strain-rate damping β) \[mm³\].
    pub elastic: f64,
    /// A·h times the factor of the geometric part \[mm³\].
    pub geometric: f64,
    /// Whether this is the Hessian of the energy; else the rotated constant stiffness, always positive semidefinite.
    pub is_exact: bool,
}

impl ElementTangent<'_> {
    /// K·u \[N\] for the three corners.
    #[inline]
    pub fn apply(&self, u: [DVec3; 3]) -> [DVec3; 3] {
        let polar = &self.state.polar;
        let (d1, d2) = gradient(u, self.rest);
        let n = polar.fibre_axis.cross(polar.transverse_axis);
        let pi = self.in_plane(in_frame(polar, d1, d2));
        let normal = self.normal.apply(DVec2::new(n.dot(d1), n.dot(d2))) * self.geometric;
        spread(polar, pi, normal, self.rest, -1.0)
    }

    /// V·dΠ for the in-plane gradient change `a`, in the co-rotated frame.
    #[inline]
    fn in_plane(&self, a: Mat) -> Mat {
        let (u, t) = (self.state.polar.stretch, self.state.stress);
        let (spin, du) = rates(a, u);
        let dt = self.stiffness.stress(du);
        let dpi = first_piola(dt, u).map(|p| p * self.elastic);
        if !self.is_exact {
            let wave = wave_stress(self.stiffness, t, u, du);
            let dwave = first_piola(wave, u).map(|p| p * self.geometric);
            return [dpi[0] + dwave[0], dpi[1] + dwave[1], dpi[2] + dwave[2], dpi[3] + dwave[3]];
        }
        // d(κ/tr U) at fixed T, and the turning of Π with the frame: ω·J·Π.
        let trace = u.trace().max(LEAST_TRACE);
        let dkappa = (t.yy - t.xx) * du.xy + t.xy * (du.xx - du.yy);
        let skew = (dkappa - spin_stress(t, u) * du.trace()) / trace;
        let pi = first_piola(t, u);
        let g = self.geometric;
        [
            dpi[0] - g * spin * pi[2],
            dpi[1] + g * (skew - spin * pi[3]),
            dpi[2] + g * (spin * pi[0] - skew),
            dpi[3] + g * spin * pi[1],
        ]
    }

    /// The 3×3 block of corner `i` on the diagonal of the stiffness \[N/mm\].
    #[inline]
    pub fn diagonal_block(&self, i: usize) -> DMat3 {
        let polar = &self.state.polar;
        let g = self.rest.all_gradients()[i];
        let k1 = self.in_plane([g.x, g.y, 0.0, 0.0]);
        let k2 = self.in_plane([0.0, 0.0, g.x, g.y]);
        let (k11, k21) = (k1[0] * g.x + k1[1] * g.y, k1[2] * g.x + k1[3] * g.y);
        let (k12, k22) = (k2[0] * g.x + k2[1] * g.y, k2[2] * g.x + k2[3] * g.y);
        let off = 0.5 * (k12 + k21);
        let (r1, r2) = (polar.fibre_axis, polar.transverse_axis);
        let n = r1.cross(r2);
        let knn = self.geometric * self.normal.normal_component(g);
        let c1 = r1 * k11 + r2 * off;
        let c2 = r1 * off + r2 * k22;
        let c3 = n * knn;
        let column = |k: usize| c1 * r1[k] + c2 * r2[k] + c3 * n[k];
        DMat3::from_cols(column(0), column(1), column(2))
    }
}
