//! The co-rotational membrane element: force, rotated, exact and projected tangent of the energy ½·A·h·(U−I):C:(U−I).
//!
//! Everything in-plane is written in the triangle's own axes (fibre, transverse). A 2×2 matrix there is `[m11, m12, m21, m22]`.
//! J = [[0, −1], [1, 0]]. For a change dF of the deformation gradient, a = RᵀdF gives the spin ω = (a₂₁ − a₁₂)/tr U and the
//! stretch rate dU = a − ω·J·U. The first Piola–Kirchhoff stress in the frame is Π = T − (κ/tr U)·J with
//! κ = (T₂₂ − T₁₁)·U₁₂ + T₁₂·(U₁₁ − U₂₂): T contracted with dU. The classical co-rotational force leaves the second term out;
//! it is then no gradient of any energy, and an anisotropic triangle spins by itself.

use super::formulas::{
    self, Tangent, balance, first_piola, in_frame, in_space, inverse_trace, rates, rotated_rate, scaled, spin_stress,
    spread, with_normal_part,
};
use super::polar;
use crate::math::{ElementState, Faded, FibreLaw, Orthotropic, Polar, RestTriangle, Sym2};
use glam::{DMat3, DVec2, DVec3};

/// In-plane 2×2 matrix `[m11, m12, m21, m22]`.
type Mat = [f64; 4];

/// Below this tr U the spin term is held bounded. Reached by mirrored triangles of planar bodies only: in space tr U is at
/// least the norm of F, and the term is bounded by the stress.
pub const LEAST_TRACE: f64 = 1e-2;

/// Least principal stress over Q66 from which the weighted tangent is the projected one.
const FULL_TURNING: f64 = 0.005;

/// A squared strain up to which there is none: some roundings of F and its factors. Without it a body at rest is driven by the rounding
/// of its forces, by 1e-11 mm in 20,000 steps of 100 ms.
pub(super) const ROUNDING_SQ: f64 = (16.0 * f64::EPSILON) * (16.0 * f64::EPSILON);

/// The columns f₁, f₂ of the deformation gradient (or of any gradient, given nodal values) in the fibre's rest frame.
#[inline(always)]
pub fn gradient(x: [DVec3; 3], rest: &RestTriangle) -> (DVec3, DVec3) {
    let [f1, f2] = columns(x, rest);
    (DVec3::from_array(f1), DVec3::from_array(f2))
}

#[inline(always)]
fn columns(x: [DVec3; 3], rest: &RestTriangle) -> [[f64; 3]; 2] {
    formulas::gradient([(x[1] - x[0]).to_array(), (x[2] - x[0]).to_array()], shape_gradients(rest))
}

/// Rotation, stretch and stress of a triangle with corners at `x`. `unstretched` is the stretch that is free of stress:
/// the identity, less a held pre-stretch. A planar body keeps its normal along +z.
#[inline]
pub fn state(
    x: [DVec3; 3],
    rest: &RestTriangle,
    stiffness: &Orthotropic,
    is_planar: bool,
    unstretched: Sym2,
) -> ElementState {
    let (f1, f2) = gradient(x, rest);
    let polar = if is_planar { polar::planar(f1, f2) } else { polar::membrane(f1, f2) };
    let strain = polar.stretch - unstretched;
    if strain.xx * strain.xx + strain.yy * strain.yy + strain.xy * strain.xy <= ROUNDING_SQ {
        return ElementState { polar: Polar { stretch: unstretched, ..polar }, stress: Sym2::ZERO };
    }
    let stress = match Faded::at(polar.stretch, is_planar) {
        None => stiffness.stress(strain),
        Some(faded) => faded.stress(stiffness, polar.stretch, unstretched),
    };
    ElementState { polar, stress }
}

/// Twice the energy per volume \[MPa\] of a triangle with the law `stiffness` in a state: of [`state`], with the part of `fibres`.
#[inline]
pub fn twice_energy(
    ElementState { polar, stress }: &ElementState,
    stiffness: &Orthotropic,
    (is_planar, unstretched, fibres): (bool, Sym2, Option<&FibreLaw>),
) -> f64 {
    let stretch = polar.stretch;
    match Faded::at(stretch, is_planar) {
        Some(faded) if !fibres.is_some_and(FibreLaw::replaces_linear) => {
            let own = fibres.map_or(0.0, |law| law.energy(stretch, unstretched, stiffness));
            faded.twice_energy(stiffness, stretch, unstretched) + 2.0 * own
        }
        _ => FibreLaw::twice_energy(fibres, stretch, unstretched, (*stress, stiffness)),
    }
}

/// Π \[MPa\] of a state, `[11, 12, 21, 22]`: the first Piola–Kirchhoff stress is R·Π, and the derivative of the energy per rest volume.
#[inline]
pub fn first_piola_stress(state: &ElementState) -> [f64; 4] {
    let stretch = state.polar.stretch.to_array();
    first_piola(state.stress.to_array(), stretch, inverse_trace(stretch))
}

/// Forces on the three corners \[N\], −V·R·Π·∇N_i, of a triangle with rest volume V = A·h \[mm³\] under the stress `stress`.
#[inline]
pub fn nodal_forces(polar: &Polar, stress: Sym2, rest: &RestTriangle, volume: f64) -> [DVec3; 3] {
    let stretch = polar.stretch.to_array();
    let pi = first_piola(stress.to_array(), stretch, inverse_trace(stretch));
    let [a, b] = spread(in_space(axes(polar), pi), shape_gradients(rest));
    corner_forces([scaled(a, -volume), scaled(b, -volume)])
}

/// The forces on corners 1 and 2, with the force that balances them on corner 0 before.
#[inline(always)]
fn corner_forces(forces: [[f64; 3]; 2]) -> [DVec3; 3] {
    [DVec3::from_array(balance(forces)), DVec3::from_array(forces[0]), DVec3::from_array(forces[1])]
}

#[inline(always)]
fn axes(polar: &Polar) -> [[f64; 3]; 2] {
    [polar.fibre_axis.to_array(), polar.transverse_axis.to_array()]
}

#[inline(always)]
fn shape_gradients(rest: &RestTriangle) -> [f64; 4] {
    let [g1, g2] = rest.gradients;
    [g1.x, g1.y, g2.x, g2.y]
}

/// Second Piola–Kirchhoff stress S = U⁻¹·Π \[MPa\] (symmetric). It carries the out-of-plane stiffness; T in its place is 16 %
/// wrong at 15 % stretch.
#[inline]
pub fn second_piola(stress: Sym2, stretch: Sym2) -> Sym2 {
    Sym2::from_array(formulas::second_piola(stress.to_array(), stretch.to_array()))
}

/// Stiffness c \[MPa\] that stands, in the rotated tangent, for the in-plane geometric stiffness: 2c·dev(dU) adds to dT.
///
/// A shear wave that travels along the larger principal stress T₁ is stiffened by T₁ + (T₁ − T₂)·λ₂/t, over t = λ₁ + λ₂
/// (exact tangent, U and T coaxial). Left out, a linearly implicit step makes that part of the force explicit, and the wave
/// grows where it exceeds the elastic shear stiffness: from a fibre tension of 4/3·G on. The deviator of dU resists such a
/// wave in any direction and no rotation, so the tangent stays semidefinite and exerts no torque. `reserve` times
/// the tissue's own least shear stiffness is added: −0.5 where a step is stable down to half of the true stiffness; small
/// tensions then add nothing.
#[inline]
pub fn shear_majorant(stress: Sym2, stretch: Sym2, law: &Orthotropic, reserve: f64) -> f64 {
    formulas::shear_majorant(stress.to_array(), stretch.to_array(), law.to_array(), reserve)
}

/// The functional ℓ \[MPa\] of the geometric part of the Hessian in the plane, ½·(ω⊗ℓ + ℓ⊗ω), for a gradient change a: the
/// stress turns with the frame, and κ changes with the stretch. Without a spin there is none of it.
#[inline]
fn turning(stress: Sym2, stretch: Sym2, inverse_trace: f64) -> Mat {
    let (t, u) = (stress, stretch);
    let spin = spin_stress(t.to_array(), u.to_array(), inverse_trace);
    let half = 0.5 * (t.yy - t.xx);
    let own = -(half * (u.yy - u.xx) + 2.0 * t.xy * u.xy) * inverse_trace;
    [2.0 * (spin - t.xy), -t.yy - half - own, t.xx - half + own, 2.0 * (spin + t.xy)]
}

/// Stiffness p \[MPa\] against spin that makes the Hessian of the energy positive semidefinite in the plane, p·ω² at the least.
///
/// With the stretch rate dU and the spin ω as unknowns the Hessian is dU:C:dU + ω·(l:dU) + k·ω². C is positive definite, so that
/// only one direction can be negative, and it is where the Schur complement k − ¼·l:C⁻¹:l is: p is the amount that it lacks. Where
/// nothing lacks the Hessian stays as it is. Clamping the negative eigenvalue instead takes an iteration for four axes, and
/// stiffens strains where this stiffens the turn alone. Q16 and Q26 \[MPa\] belong to C and couple strains and shear.
#[inline]
pub fn spin_majorant(stress: Sym2, stretch: Sym2, law: &Orthotropic, [q16, q26]: [f64; 2]) -> f64 {
    let inverse = inverse_trace(stretch.to_array());
    let l = turning(stress, stretch, inverse);
    // The gradient change of a unit of spin that strains nothing.
    let (skew, half) = (0.5 * (stretch.xx - stretch.yy), 0.5 / inverse);
    let turn = [-stretch.xy, skew - half, skew + half, stretch.xy];
    let own: f64 = l.iter().zip(turn).map(|(l, turn)| l * turn).sum();
    let shear = l[1] + l[2];
    // The shear eliminated first.
    let (along, across) = (q16 / law.q66, q26 / law.q66);
    let (xx, yy) = (l[0] - 0.5 * shear * along, l[3] - 0.5 * shear * across);
    let (q11, q12, q22) = (law.q11 - q16 * along, law.q12 - q16 * across, law.q22 - q26 * across);
    let direct = (q22 * xx * xx - 2.0 * q12 * xx * yy + q11 * yy * yy) / (q11 * q22 - q12 * q12);
    (0.25 * (direct + shear * shear / (4.0 * law.q66)) - own).max(0.0)
}

/// Weight of the turning terms in the weighted tangent, from 0 where a triangle is slack to 1 where its least principal stress is that of a
/// shear strain of 0.5 %.
#[inline]
pub fn turning_weight(stress: Sym2, law: &Orthotropic) -> f64 {
    (stress.principal_values().1 / (FULL_TURNING * law.q66)).clamp(0.0, 1.0)
}

/// dU for nodal velocities (or displacements) `u`: the exact strain rate, zero for every rigid motion.
#[inline]
pub fn stretch_rate(polar: &Polar, rest: &RestTriangle, u: [DVec3; 3]) -> Sym2 {
    let stretch = polar.stretch.to_array();
    Sym2::from_array(rates(in_frame(axes(polar), columns(u, rest)), stretch, inverse_trace(stretch)).1)
}

/// A triangle's tangent, ready to be applied to any displacement.
#[derive(Clone, Copy, Debug)]
pub struct ElementTangent<'a, S = ElementState> {
    /// State at the positions where the tangent is taken, or where that is stored.
    pub state: S,
    /// Rest shape.
    pub rest: &'a RestTriangle,
    /// Elastic constants.
    pub stiffness: &'a Orthotropic,
    /// Q16 and Q26 beside them \[MPa\], which couple strain along and across the fibre with engineering shear.
    pub coupling: [f64; 2],
    /// Out-of-plane stiffness \[MPa\]: S for the exact tangent, S⁺ for the others.
    pub normal: Sym2,
    /// Stiffness \[MPa\] against shear in place of the turning terms: [`shear_majorant`] for the rotated tangent, a part of it for the
    /// weighted one.
    pub shear: f64,
    /// Stiffness \[MPa\] against spin: [`spin_majorant`] for the projected and the weighted tangent.
    pub spin: f64,
    /// Weight of the Hessian's turning terms: 0 for the rotated tangent, whose sum is always positive semidefinite.
    pub turning: f64,
    /// A·h times the factor of the elastic part (1, or 1 + β/dt with strain-rate damping β) \[mm³\].
    pub elastic: f64,
    /// A·h times the factor of the geometric part \[mm³\].
    pub geometric: f64,
}

impl ElementTangent<'_> {
    /// K·u \[N\] for the three corners.
    #[inline(always)]
    pub fn apply(&self, u: [DVec3; 3]) -> [DVec3; 3] {
        let (axes, d) = (axes(&self.state.polar), columns(u, self.rest));
        let pi = self.first_piola_rate(in_frame(axes, d));
        let columns = with_normal_part(axes, pi, d, (self.normal.to_array(), self.geometric));
        corner_forces(spread(columns, shape_gradients(self.rest)))
    }

    /// U₁₂/tr U and (U₁₁ − U₂₂)/tr U: how the spin enters the stretch rate, dU₁₁ = a₁₁ + q·(a₂₁ − a₁₂),
    /// dU₂₂ = a₂₂ − q·(a₂₁ − a₁₂), 2·dU₁₂ = (1+s)·a₁₂ + (1−s)·a₂₁.
    #[inline]
    pub fn skew(&self) -> [f64; 2] {
        let u = self.state.polar.stretch;
        let inverse = inverse_trace(u.to_array());
        [u.xy * inverse, (u.xx - u.yy) * inverse]
    }

    /// Turning terms: the spin is inverse·(a₂₁ − a₁₂), and ½·(ω⊗ℓ + ℓ⊗ω) the geometric part of the Hessian in the plane, its weight and the
    /// semidefinite correction included. The inverse of tr U and ℓ \[MPa\].
    #[inline]
    pub fn turning_terms(&self) -> (f64, [f64; 4]) {
        let u = self.state.polar.stretch;
        let inverse = inverse_trace(u.to_array());
        let [l11, l12, l21, l22] = turning(self.state.stress, u, inverse);
        let more = self.spin * inverse;
        (inverse, [l11, l12 - more, l21 + more, l22].map(|l| l * self.turning))
    }

    /// V·dΠ for the in-plane gradient change `a`, in the co-rotated frame.
    #[inline(always)]
    fn first_piola_rate(&self, a: Mat) -> Mat {
        if self.turning > 0.0 { self.turned(a) } else { self.rotated(a) }
    }

    #[inline(always)]
    fn rotated(&self, a: Mat) -> Mat {
        let Self { coupling, elastic, .. } = *self;
        let tangent =
            Tangent { law: self.stiffness.to_array(), coupling, elastic, in_plane: self.shear * self.geometric };
        rotated_rate(a, self.state.polar.stretch.to_array(), tangent)
    }

    /// Out of line, so that the loop over the rotated tangent stays one straight piece of code.
    #[inline(never)]
    fn turned(&self, a: Mat) -> Mat {
        let u = self.state.polar.stretch.to_array();
        let (inverse, l) = self.turning_terms();
        let (spin, du) = rates(a, u, inverse);
        let own = self.stiffness.coupled_stress(self.coupling, Sym2::from_array(du)) * self.elastic;
        let shear = self.shear * self.geometric;
        let deviator = shear * (du[0] - du[1]);
        let stress = own + Sym2::new(deviator, -deviator, 2.0 * shear * du[2]);
        let dpi = first_piola(stress.to_array(), u, inverse);
        let half = 0.5 * self.geometric;
        let turned = half * spin;
        let along = half * inverse * (l[0] * a[0] + l[1] * a[1] + l[2] * a[2] + l[3] * a[3]);
        [dpi[0] + turned * l[0], dpi[1] + turned * l[1] - along, dpi[2] + turned * l[2] + along, dpi[3] + turned * l[3]]
    }

    /// The blocks K₁₁, K₁₂, K₂₂ \[N/mm\] of the stiffness.
    pub fn blocks(&self) -> [DMat3; 3] {
        let polar = &self.state.polar;
        let (r1, r2) = (polar.fibre_axis, polar.transverse_axis);
        let axes = DMat3::from_cols(r1, r2, r1.cross(r2));
        // Columns of V·∂Π/∂a.
        let unit = |k: usize| std::array::from_fn(|i| f64::from(u8::from(i == k)));
        let law: [Mat; 4] = std::array::from_fn(|k| self.first_piola_rate(unit(k)));
        let [g1, g2] = self.rest.gradients.map(|g| g.to_array());
        let block = |gi: [f64; 2], gj: [f64; 2]| {
            let mut local = DMat3::ZERO;
            for (row, column) in [(0, 0), (0, 1), (1, 0), (1, 1)] {
                for (k, l) in [(0, 0), (0, 1), (1, 0), (1, 1)] {
                    local.col_mut(column)[row] += gi[k] * law[2 * column + l][2 * row + k] * gj[l];
                }
            }
            local.z_axis.z = self.geometric * DVec2::from_array(gi).dot(self.normal.apply(DVec2::from_array(gj)));
            axes * local * axes.transpose()
        };
        [block(g1, g1), block(g1, g2), block(g2, g2)]
    }

    /// The 3×3 block of corner `i` on the diagonal of the stiffness \[N/mm\].
    #[inline]
    pub fn diagonal_block(&self, i: usize) -> DMat3 {
        let polar = &self.state.polar;
        let g = self.rest.all_gradients()[i];
        let k1 = self.first_piola_rate([g.x, g.y, 0.0, 0.0]);
        let k2 = self.first_piola_rate([0.0, 0.0, g.x, g.y]);
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
