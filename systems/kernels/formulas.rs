//! The formulas of the membrane, each once: for one triangle, and for several side by side.
//!
//! Vectors are components; symmetric tensors in the axes of fibre and transverse direction are xx, yy, xy, other matrices there
//! 11, 12, 21, 22. [`super::membrane`] defines them, and is their side for one triangle; [`super::membrane_lanes`] and
//! [`super::product_lanes`] are that for lanes.

use super::membrane::LEAST_TRACE;
use crate::math::number::{Number, Real, linear_stress};

/// x, y and z.
pub type Vector<N> = [N; 3];

/// xx, yy and xy.
pub type Tensor<N> = [N; 3];

/// a·b.
#[inline(always)]
pub fn dot<N: Number>(a: Vector<N>, b: Vector<N>) -> N {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// a × b.
#[inline(always)]
pub fn cross<N: Number>(a: Vector<N>, b: Vector<N>) -> Vector<N> {
    [a[1] * b[2] - b[1] * a[2], a[2] * b[0] - b[2] * a[0], a[0] * b[1] - b[0] * a[1]]
}

/// a − b.
#[inline(always)]
pub fn less<N: Number>(a: Vector<N>, b: Vector<N>) -> Vector<N> {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

/// a + b.
#[inline(always)]
pub fn plus<N: Number>(a: Vector<N>, b: Vector<N>) -> Vector<N> {
    [a[0] + b[0], a[1] + b[1], a[2] + b[2]]
}

/// a·s.
#[inline(always)]
pub fn scaled<N: Number>(a: Vector<N>, s: N) -> Vector<N> {
    [a[0] * s, a[1] * s, a[2] * s]
}

/// a·s + b·t.
#[inline(always)]
pub fn combine<N: Number>(a: Vector<N>, s: N, b: Vector<N>, t: N) -> Vector<N> {
    [a[0] * s + b[0] * t, a[1] * s + b[1] * t, a[2] * s + b[2] * t]
}

/// √(a² + b²).
#[inline(always)]
pub fn radius<N: Real>(a: N, b: N) -> N {
    (a * a + b * b).sqrt()
}

/// T:E.
#[inline(always)]
pub fn contract<N: Number>(t: Tensor<N>, e: Tensor<N>) -> N {
    t[0] * e[0] + t[1] * e[1] + t[2].constant(2.0) * t[2] * e[2]
}

/// The columns of a gradient, of the differences of corners 1 and 2 from corner 0 and of their shape gradients, x and y of either.
#[inline(always)]
pub fn gradient<N: Number>([a, b]: [Vector<N>; 2], [g1x, g1y, g2x, g2y]: [N; 4]) -> [Vector<N>; 2] {
    [combine(a, g1x, b, g2x), combine(a, g1y, b, g2y)]
}

/// A polar decomposition.
#[derive(Clone, Copy)]
pub struct Rotated<N> {
    /// Fibre and transverse axis.
    pub axes: [Vector<N>; 2],
    /// Stretch.
    pub stretch: Tensor<N>,
}

/// R = (F + cofactors)/tr U and U = RᵀF.
#[inline(always)]
fn with_cofactors<N: Real>([f1, f2]: [Vector<N>; 2], [c1, c2]: [Vector<N>; 2], trace: N) -> Rotated<N> {
    let inverse = trace.constant(1.0) / trace;
    let (r1, r2) = (scaled(plus(f1, c1), inverse), scaled(plus(f2, c2), inverse));
    let stretch = [dot(r1, f1), dot(r2, f2), trace.constant(0.5) * (dot(r1, f2) + dot(r2, f1))];
    Rotated { axes: [r1, r2], stretch }
}

/// |f₁|² + |f₂|².
#[inline(always)]
pub fn lengths_sq<N: Number>([f1, f2]: [Vector<N>; 2]) -> N {
    dot(f1, f1) + dot(f2, f2)
}

/// The decomposition of a body whose normal stays +z, and (tr U)²: see [`super::polar::planar`].
#[inline(always)]
pub fn rotated_in_plane<N: Real>([f1, f2]: [Vector<N>; 2]) -> (Rotated<N>, N) {
    let zero = f1[0].constant(0.0);
    let (f1, f2) = ([f1[0], f1[1], zero], [f2[0], f2[1], zero]);
    let cofactors = [[f2[1], zero - f2[0], zero], [zero - f1[1], f1[0], zero]];
    let along = plus(f1, cofactors[0]);
    let trace_sq = dot(along, along);
    (with_cofactors([f1, f2], cofactors, trace_sq.sqrt()), trace_sq)
}

/// The decomposition of a membrane in space, and its area ratio |f₁ × f₂|: see [`super::polar::membrane`].
#[inline(always)]
pub fn rotated_in_space<N: Real>(f: [Vector<N>; 2]) -> (Rotated<N>, N) {
    let normal = cross(f[0], f[1]);
    let area = dot(normal, normal).sqrt();
    let trace = (lengths_sq(f) + area + area).sqrt();
    (rotated_about(f, scaled(normal, area.constant(1.0) / area), trace), area)
}

/// The area ratio up to which the cross product of a membrane in space is all rounding, far under the resolution of U;
/// 1 over more is finite.
#[inline(always)]
pub fn least_area<N: Real>(f: [Vector<N>; 2]) -> N {
    let lengths_sq = lengths_sq(f);
    (lengths_sq * lengths_sq.constant(1e-30)).max(lengths_sq.constant(1e-300))
}

/// The decomposition with a unit normal and tr U = √(|f₁|² + |f₂|² + 2|f₁ × f₂|) given.
#[inline(always)]
pub fn rotated_about<N: Real>(f: [Vector<N>; 2], normal: Vector<N>, trace: N) -> Rotated<N> {
    with_cofactors(f, [cross(f[1], normal), cross(normal, f[0])], trace)
}

/// 1/tr U, bounded. Every matrix-vector product needs it twice per triangle, and a division costs as much as the law.
#[inline(always)]
pub fn inverse_trace<N: Real>(stretch: Tensor<N>) -> N {
    let trace = stretch[0] + stretch[1];
    trace.constant(1.0) / trace.max(trace.constant(LEAST_TRACE))
}

/// κ/tr U: the size of the skew part of Π.
#[inline(always)]
pub fn spin_stress<N: Number>([txx, tyy, txy]: Tensor<N>, [uxx, uyy, uxy]: Tensor<N>, inverse_trace: N) -> N {
    ((tyy - txx) * uxy + txy * (uxx - uyy)) * inverse_trace
}

/// Π = T − (κ/tr U)·J: the energy-consistent first Piola–Kirchhoff stress in the frame.
#[inline(always)]
pub fn first_piola<N: Number>(stress: Tensor<N>, stretch: Tensor<N>, inverse_trace: N) -> [N; 4] {
    let spin = spin_stress(stress, stretch, inverse_trace);
    [stress[0], stress[2] + spin, stress[2] - spin, stress[1]]
}

/// R·Π, by columns.
#[inline(always)]
pub fn in_space<N: Number>([r1, r2]: [Vector<N>; 2], pi: [N; 4]) -> [Vector<N>; 2] {
    [combine(r1, pi[0], r2, pi[2]), combine(r1, pi[1], r2, pi[3])]
}

/// P·∇N for the corners 1 and 2.
#[inline(always)]
pub fn spread<N: Number>([p1, p2]: [Vector<N>; 2], [g1x, g1y, g2x, g2y]: [N; 4]) -> [Vector<N>; 2] {
    [combine(p1, g1x, p2, g1y), combine(p1, g2x, p2, g2y)]
}

/// The force on corner 0 that balances those on corners 1 and 2.
#[inline(always)]
pub fn balance<N: Number>([a, b]: [Vector<N>; 2]) -> Vector<N> {
    let minus_one = a[0].constant(-1.0);
    less(scaled(a, minus_one), b)
}

/// RᵀdF.
#[inline(always)]
pub fn in_frame<N: Number>([r1, r2]: [Vector<N>; 2], [d1, d2]: [Vector<N>; 2]) -> [N; 4] {
    [dot(r1, d1), dot(r1, d2), dot(r2, d1), dot(r2, d2)]
}

/// Spin ω and stretch rate dU for a gradient change a = RᵀdF.
#[inline(always)]
pub fn rates<N: Number>(a: [N; 4], [uxx, uyy, uxy]: Tensor<N>, inverse_trace: N) -> (N, Tensor<N>) {
    let spin = (a[2] - a[1]) * inverse_trace;
    // J·U = [[−U12, −U22], [U11, U12]]; both off-diagonal entries of a − ω·J·U are equal, their mean halves the rounding.
    let xy = spin.constant(0.5) * (a[1] + spin * uyy + a[2] - spin * uxx);
    (spin, [a[0] + spin * uxy, a[3] - spin * uxy, xy])
}

/// Second Piola–Kirchhoff stress S = U⁻¹·Π (symmetric): see [`super::membrane::second_piola`].
#[inline(always)]
pub fn second_piola<N: Real>(stress: Tensor<N>, stretch: Tensor<N>) -> Tensor<N> {
    let [uxx, uyy, uxy] = stretch;
    let pi = first_piola(stress, stretch, inverse_trace(stretch));
    let trace = uxx + uyy;
    // A triangle squeezed to less than 1 % of its area has no meaningful S: the bound keeps it finite.
    let bound = trace.constant(2.5e-3) * trace * trace;
    let determinant = (uxx * uyy - uxy * uxy).max(bound).max(trace.constant(f64::MIN_POSITIVE));
    let inverse = trace.constant(1.0) / determinant;
    let (xy, yx) = (uyy * pi[1] - uxy * pi[3], uxx * pi[2] - uxy * pi[0]);
    let half = trace.constant(0.5);
    [(uyy * pi[0] - uxy * pi[2]) * inverse, (uxx * pi[3] - uxy * pi[1]) * inverse, half * (xy + yx) * inverse]
}

/// Stiffness that stands for the in-plane geometric stiffness in the rotated tangent: see [`super::membrane::shear_majorant`].
#[inline(always)]
pub fn shear_majorant<N: Real>(
    [txx, tyy, txy]: Tensor<N>,
    [uxx, uyy, uxy]: Tensor<N>,
    [q11, q12, q22, q66]: [N; 4],
    reserve: f64,
) -> N {
    let zero = txx.constant(0.0);
    let (half, quarter) = (zero.constant(0.5), zero.constant(0.25));
    let trace = uxx + uyy;
    // A collapsed triangle has no meaningful geometric stiffness: the bound keeps it finite.
    let least = (zero.constant(0.2) * trace).max(zero.constant(f64::MIN_POSITIVE));
    let low = (half * trace - radius(half * (uxx - uyy), uxy)).max(least);
    let (mean, radius) = (half * (txx + tyy), radius(half * (txx - tyy), txy));
    let along = mean + radius + (radius + radius) * (low / trace);
    let geometric = along * trace * quarter / (low * low);
    // The smaller of two numbers.
    let own = zero - (zero - q66).max(zero - (quarter * (q11 + q22) - half * q12));
    (geometric + zero.constant(reserve) * own).max(zero)
}

/// How the rotated tangent answers.
#[derive(Clone, Copy)]
pub struct Tangent<N> {
    /// Q11, Q12, Q22, Q66.
    pub law: [N; 4],
    /// Q16 and Q26.
    pub coupling: [N; 2],
    /// A·h times the factor of the elastic part.
    pub elastic: N,
    /// A·h times the factor of the geometric part, times the stiffness in the plane.
    pub in_plane: N,
}

/// V·dΠ of the rotated tangent for a gradient change a = RᵀdF.
#[inline(always)]
pub fn rotated_rate<N: Real>(a: [N; 4], stretch: Tensor<N>, tangent: Tangent<N>) -> [N; 4] {
    let Tangent { law, coupling: [q16, q26], elastic, in_plane } = tangent;
    let inverse = inverse_trace(stretch);
    let (_, du) = rates(a, stretch, inverse);
    let [xx, yy, xy] = du;
    let stress = linear_stress(law, du);
    let (along, across) = (q16 * xy, q26 * xy);
    let deviator = in_plane * (xx - yy);
    let stress = [
        (stress[0] + (along + along)) * elastic + deviator,
        (stress[1] + (across + across)) * elastic - deviator,
        (stress[2] + (q16 * xx + q26 * yy)) * elastic + in_plane * (xy + xy),
    ];
    first_piola(stress, stretch, inverse)
}

/// R·Π + n ⊗ (N·dF)ᵀ·n, by columns: the sum of a tangent with the out-of-plane stiffness N.
#[inline(always)]
pub fn with_normal_part<N: Number>(
    axes: [Vector<N>; 2],
    pi: [N; 4],
    [d1, d2]: [Vector<N>; 2],
    ([nxx, nyy, nxy], geometric): (Tensor<N>, N),
) -> [Vector<N>; 2] {
    let n = cross(axes[0], axes[1]);
    let (n1, n2) = (dot(n, d1), dot(n, d2));
    let (m1, m2) = ((nxx * n1 + nxy * n2) * geometric, (nxy * n1 + nyy * n2) * geometric);
    let [p1, p2] = in_space(axes, pi);
    [plus(p1, scaled(n, m1)), plus(p2, scaled(n, m2))]
}
