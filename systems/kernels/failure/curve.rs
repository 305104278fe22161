//! The curve c(δ) on both sides of the fibre, and all its smooth maxima.
//!
//! What makes the search exact without sampling: in the variable w = (2δ/π)^α the threshold is *affine*. So c = σ_u/σ̄ is
//! quasiconvex where σ_u is convex in w (no maximum inside) and quasiconcave where σ_u is concave in w (at most one). With
//! σ_u = m + ρ·cos(2δ + ψ), y = 2δ and γ = 1 − α, the second derivative of σ_u in w has the sign of −sin H,
//! H(y) = y + ψ + arg(γ + i·y). H turns at most once, so its passages through multiples of π are enumerated, not searched
//! for, and each concave stretch holds at most one bracketed root of c′.

use super::{Origin, Strength};
use crate::math::Sym2;
use glam::DVec2;
use std::f64::consts::{FRAC_PI_2, PI};

/// Below this (stress and strength scaled to order one) a slope at a kink is rounding, and is judged [`INSIDE`] instead.
const NO_SLOPE: f64 = 1e-9;
/// Distance from the kink, in the branch variable.
const INSIDE: f64 = 1e-4;
/// Deviatoric part, relative to the mean, up to which a stress is hydrostatic to rounding.
const HYDROSTATIC: f64 = 1e-13;
/// Relative size of the last Newton step.
const NEWTON_DONE: f64 = 1e-10;
/// Enough for pure bisection down to rounding.
const ROOT_STEPS: usize = 100;

/// c(δ), with stress and strength scaled to order one. `side` is +1 on the fibre's left, −1 on its right.
///
/// The branch variable v in [0, 1] is w for α < 1 and 2δ/π otherwise: in it c is differentiable up to the kinks.
pub(super) struct Curve {
    /// m, half the trace.
    mean: f64,
    /// Half of σ_TT − σ_FF.
    half_difference: f64,
    /// σ_FT.
    shear: f64,
    /// σ̄_F.
    fibre: f64,
    /// σ̄_T.
    transverse: f64,
    /// α.
    exponent: f64,
    unit_of_value: f64,
}

/// A smooth maximum of the curve.
pub(super) struct Peak {
    pub side: f64,
    pub delta: f64,
    pub value: f64,
    pub origin: Origin,
}

impl Curve {
    /// `None` where stress or strength is not admissible.
    pub fn new(stress: Sym2, fibre: DVec2, strength: &Strength) -> Option<Self> {
        let strength = Strength::new(strength.fibre, strength.transverse, strength.exponent).ok()?;
        if !stress.is_finite() {
            return None;
        }
        let stress_unit = power_of_two_below(stress.xx.abs().max(stress.yy.abs()).max(stress.xy.abs()));
        let strength_unit = power_of_two_below(strength.fibre.max(strength.transverse));
        let scaled = Sym2::new(stress.xx / stress_unit, stress.yy / stress_unit, stress.xy / stress_unit);
        let t = scaled.in_axes(fibre, fibre.perp());
        let mut curve = Self {
            mean: 0.5 * (t.xx + t.yy),
            half_difference: 0.5 * (t.yy - t.xx),
            shear: t.xy,
            fibre: strength.fibre / strength_unit,
            transverse: strength.transverse / strength_unit,
            exponent: strength.exponent,
            unit_of_value: stress_unit / strength_unit,
        };
        // So that no direction wins by rounding alone.
        if curve.is_isotropic() && curve.amplitude() <= HYDROSTATIC * curve.mean.abs() {
            curve.mean += curve.amplitude();
            (curve.half_difference, curve.shear) = (0.0, 0.0);
        }
        Some(curve)
    }

    /// What a value of one on this curve stands for.
    pub fn unit_of_value(&self) -> f64 {
        self.unit_of_value
    }

    /// Whether c is the same in every direction.
    pub fn is_constant(&self) -> bool {
        self.amplitude() == 0.0 && (self.mean == 0.0 || self.is_isotropic())
    }

    /// What a maximum along or across the fibre is called.
    pub fn kink_origin(&self) -> Origin {
        if self.is_isotropic() { Origin::Principal } else { Origin::Kink }
    }

    /// c(f) = σ_TT/σ̄_T.
    pub fn value_along_fibre(&self) -> f64 {
        (self.mean + self.half_difference) / self.transverse
    }

    /// c(f⊥) = σ_FF/σ̄_F.
    pub fn value_across_fibre(&self) -> f64 {
        (self.mean - self.half_difference) / self.fibre
    }

    /// c at δ \[rad\].
    pub fn value(&self, side: f64, delta: f64) -> f64 {
        self.value_at(side, delta, (delta / FRAC_PI_2).powf(self.exponent))
    }

    /// Sign of dc/dδ at δ \[rad\].
    pub fn slope(&self, side: f64, delta: f64) -> f64 {
        self.derivatives(side, self.variable(delta / FRAC_PI_2)).0
    }

    /// Signs of dc/dδ beside d ∥ f: left, right.
    pub fn slopes_along_fibre(&self) -> [f64; 2] {
        self.slopes_at(0.0, INSIDE)
    }

    /// Signs of dc/dδ beside d ⊥ f: left, right.
    pub fn slopes_across_fibre(&self) -> [f64; 2] {
        self.slopes_at(1.0, 1.0 - INSIDE)
    }

    /// Calls `found` for every smooth local maximum strictly between the kinks.
    pub fn for_each_peak(&self, mut found: impl FnMut(Peak)) {
        if self.is_constant() {
            return;
        }
        let phase = self.shear.atan2(self.half_difference);
        if self.is_isotropic() {
            let value = (self.mean + self.amplitude()) / self.transverse;
            found(Peak { side: -phase.signum(), delta: 0.5 * phase.abs(), value, origin: Origin::Principal });
            return;
        }
        for side in [1.0, -1.0] {
            let (nodes, count) = self.inflections(side * phase);
            let mut from = 0.0;
            for &to in nodes[..count].iter().chain([&PI]) {
                if to > from && self.bend(0.5 * (from + to), side * phase).sin() > 0.0 {
                    let (low, high) = (self.variable(from / PI), self.variable(to / PI));
                    if let Some(v) = self.stationary_point(side, low, high) {
                        let (delta, w) = self.delta_and_w(v);
                        found(Peak { side, delta, value: self.value_at(side, delta, w), origin: Origin::Smooth });
                    }
                }
                from = to;
            }
        }
    }

    fn is_isotropic(&self) -> bool {
        self.fibre == self.transverse
    }

    /// ρ.
    fn amplitude(&self) -> f64 {
        self.half_difference.hypot(self.shear)
    }

    fn value_at(&self, side: f64, delta: f64, w: f64) -> f64 {
        let (s, c) = (2.0 * delta).sin_cos();
        let stress = self.mean + self.half_difference * c - side * self.shear * s;
        stress / ((1.0 - w) * self.transverse + w * self.fibre)
    }

    /// v of x = 2δ/π.
    fn variable(&self, x: f64) -> f64 {
        if self.exponent < 1.0 { x.powf(self.exponent) } else { x }
    }

    fn delta_and_w(&self, v: f64) -> (f64, f64) {
        if self.exponent < 1.0 {
            (FRAC_PI_2 * v.powf(1.0 / self.exponent), v)
        } else {
            (FRAC_PI_2 * v, v.powf(self.exponent))
        }
    }

    /// σ̄²·dc/dv, and its derivative (valid for v > 0).
    fn derivatives(&self, side: f64, v: f64) -> (f64, f64) {
        // Of x(v) and w(v) one is v itself and the other v^e, e ≥ 1.
        let is_cusp = self.exponent < 1.0;
        let e = if is_cusp { 1.0 / self.exponent } else { self.exponent };
        let power = v.powf(e - 1.0);
        let (bent, linear) = ([v * power, e * power, e * (e - 1.0) * power / v], [v, 1.0, 0.0]);
        let ([x, x1, x2], [w, w1, w2]) = if is_cusp { (bent, linear) } else { (linear, bent) };

        let (s, c) = (PI * x).sin_cos();
        let (a, b) = (self.half_difference, side * self.shear);
        let stress = self.mean + a * c - b * s;
        let stress_x = -PI * (a * s + b * c);
        let stress_xx = -PI * PI * (a * c - b * s);
        let threshold = (1.0 - w) * self.transverse + w * self.fibre;
        let step = self.fibre - self.transverse;
        (
            stress_x * x1 * threshold - stress * step * w1,
            (stress_xx * x1 * x1 + stress_x * x2) * threshold - stress * step * w2,
        )
    }

    fn slopes_at(&self, kink: f64, inside: f64) -> [f64; 2] {
        [1.0, -1.0].map(|side| {
            let slope = self.derivatives(side, kink).0;
            if slope.abs() > NO_SLOPE { slope } else { self.derivatives(side, inside).0 }
        })
    }

    /// H(y): σ_u is concave in w where sin H > 0.
    fn bend(&self, y: f64, phase: f64) -> f64 {
        let gamma = 1.0 - self.exponent;
        // At α = 1 the limit y → 0 is wanted, where atan2(0, 0) is 0.
        let turn = if gamma == 0.0 { FRAC_PI_2 } else { y.atan2(gamma) };
        y + phase + turn
    }

    /// The y in (0, π) where σ_u as a function of w changes its bending, ascending.
    fn inflections(&self, phase: f64) -> ([f64; 4], usize) {
        let gamma = 1.0 - self.exponent;
        // dH/dy = 1 + γ/(γ² + y²) vanishes at this y, where there is one.
        let turning = (-gamma * (1.0 + gamma)).max(0.0).sqrt();
        let (mut nodes, mut count) = ([0.0; 4], 0);
        for (from, to) in [(0.0, turning), (turning, PI)] {
            let (start, end) = (self.bend(from, phase), self.bend(to, phase));
            let sign = if start > end { 1.0 } else { -1.0 };
            for multiple in (start.min(end) / PI).ceil() as i32..=(start.max(end) / PI).floor() as i32 {
                if to > from && count < nodes.len() {
                    nodes[count] = falling_root(from, to, |y| {
                        let slope = 1.0 + if gamma == 0.0 { 0.0 } else { gamma / (gamma * gamma + y * y) };
                        (sign * (self.bend(y, phase) - f64::from(multiple) * PI), sign * slope)
                    });
                    count += 1;
                }
            }
        }
        (nodes, count)
    }

    /// The root of dc/dv between `low` and `high`, where it passes from plus to minus once; `None` where it does not.
    fn stationary_point(&self, side: f64, low: f64, high: f64) -> Option<f64> {
        let is_bracketed = self.derivatives(side, low).0 > 0.0 && self.derivatives(side, high).0 < 0.0;
        is_bracketed.then(|| falling_root(low, high, |v| self.derivatives(side, v)))
    }
}

/// The root between `low` and `high` of a function (given with its derivative) that passes there from plus to minus: Newton
/// while it stays inside the bracket and at least halves its steps, else bisection.
fn falling_root(mut low: f64, mut high: f64, f: impl Fn(f64) -> (f64, f64)) -> f64 {
    let mut x = 0.5 * (low + high);
    let mut last_step = high - low;
    for _ in 0..ROOT_STEPS {
        let (value, slope) = f(x);
        if value > 0.0 {
            low = x;
        } else {
            high = x;
        }
        let newton = x - value / slope;
        let is_good = newton >= low && newton <= high && (newton - x).abs() < 0.5 * last_step;
        let next = if is_good { newton } else { 0.5 * (low + high) };
        last_step = (next - x).abs();
        x = next;
        // A Newton step this small leaves its square as error; further ones would only follow rounding.
        if last_step <= (if is_good { NEWTON_DONE } else { 2.0 * f64::EPSILON }) * x {
            break;
        }
    }
    x
}

/// The power of two at or below a finite positive number: dividing by it is exact.
fn power_of_two_below(x: f64) -> f64 {
    f64::from_bits(x.max(f64::MIN_POSITIVE).to_bits() & 0x7ff0_0000_0000_0000)
}
