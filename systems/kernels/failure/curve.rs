//! The curve c(δ) on both sides of the fibre, and the refinement of its smooth maxima.

use super::{Origin, Strength};
use crate::math::{Sym2, elementary};
use glam::DVec2;
use std::f64::consts::{FRAC_PI_2, PI};

/// Below this (stress and strength scaled to order one) a slope at a kink is rounding, and is judged [`INSIDE`] instead.
const NO_SLOPE: f64 = 1e-9;
/// Distance from the kink, in the branch variable.
const INSIDE: f64 = 1e-4;
/// Deviatoric part, relative to the mean, up to which a stress is hydrostatic to rounding.
const HYDROSTATIC: f64 = 1e-13;
/// Relative size of the last Newton step.
const NEWTON_DONE: f64 = 1e-8;
/// Enough for pure bisection down to rounding.
const ROOT_STEPS: usize = 100;

/// c(δ), with stress and strength scaled to order one. `side` is +1 on the fibre's left, −1 on its right.
///
/// The branch variable v in [0, 1] is w for α < 1 and 2δ/π otherwise: in it c is differentiable up to the kinks.
#[derive(Clone, Copy)]
pub(super) struct Curve {
    /// m, half the trace.
    pub mean: f64,
    /// Half of σ_TT − σ_FF.
    pub half_difference: f64,
    /// σ_FT.
    pub shear: f64,
    /// σ̄_F.
    fibre: f64,
    /// σ̄_T.
    transverse: f64,
    /// α.
    pub exponent: f64,
    /// Unit that a value of one on this curve stands for.
    pub unit_of_value: f64,
}

/// A smooth maximum of the curve.
pub(super) struct Peak {
    pub side: f64,
    pub delta: f64,
    pub value: f64,
    pub origin: Origin,
}

/// The curve at one place.
struct Point {
    /// 2δ/π, and its derivative in v.
    x: f64,
    x_slope: f64,
    /// c and σ̄.
    value: f64,
    threshold: f64,
    /// σ̄²·dc/dv, and its derivative (valid for v > 0).
    rise: f64,
    rise_slope: f64,
}

impl Curve {
    /// `None` where stress or strength is not admissible.
    pub(super) fn new(stress: Sym2, fibre: DVec2, strength: &Strength) -> Option<Self> {
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

    /// Whether c is the same in every direction.
    pub(super) fn is_constant(&self) -> bool {
        self.half_difference == 0.0 && self.shear == 0.0 && (self.mean == 0.0 || self.is_isotropic())
    }

    /// Origin of a maximum along or across the fibre.
    pub(super) fn kink_origin(&self) -> Origin {
        if self.is_isotropic() { Origin::Principal } else { Origin::Kink }
    }

    /// c(f) = σ_TT/σ̄_T.
    pub(super) fn value_along_fibre(&self) -> f64 {
        (self.mean + self.half_difference) / self.transverse
    }

    /// c(f⊥) = σ_FF/σ̄_F.
    pub(super) fn value_across_fibre(&self) -> f64 {
        (self.mean - self.half_difference) / self.fibre
    }

    /// c, and the sign in which it changes counter-clockwise, in the unit direction with these components along and across
    /// the fibre; neither is zero.
    pub(super) fn value_and_slope(&self, along: f64, across: f64) -> (f64, f64) {
        let side = if along * across < 0.0 { -1.0 } else { 1.0 };
        let x = elementary::atan2(across.abs(), along.abs()) / FRAC_PI_2;
        let w = elementary::pow(x, self.exponent);
        let (v, power) = if self.exponent < 1.0 { (w, x / w) } else { (x, w / x) };
        let point = self.point(side, v, power, (2.0 * (along * across).abs(), (along - across) * (along + across)));
        (point.value, side * point.rise)
    }

    /// Signs of dc/dδ beside d ∥ f: left, right.
    pub(super) fn slopes_along_fibre(&self) -> [f64; 2] {
        let power = if self.exponent == 1.0 { 1.0 } else { 0.0 };
        [1.0, -1.0].map(|side| self.slope_at_kink(side, self.point(side, 0.0, power, (0.0, 1.0)), INSIDE))
    }

    /// Signs of dc/dδ beside d ⊥ f: left, right.
    pub(super) fn slopes_across_fibre(&self) -> [f64; 2] {
        [1.0, -1.0].map(|side| self.slope_at_kink(side, self.point(side, 1.0, 1.0, (0.0, -1.0)), 1.0 - INSIDE))
    }

    fn slope_at_kink(&self, side: f64, kink: Point, inside: f64) -> f64 {
        if kink.rise.abs() > NO_SLOPE { kink.rise } else { self.rise(side, inside) }
    }

    /// The one smooth maximum where both thresholds are equal.
    pub(super) fn principal_peak(&self) -> Peak {
        let phase = self.phase();
        let value = (self.mean + self.amplitude()) / self.transverse;
        Peak { side: -phase.signum(), delta: 0.5 * phase.abs(), value, origin: Origin::Principal }
    }

    /// ψ of σ_u = m + ρ·cos(2δ + ψ) on the fibre's left; on its right it is −ψ.
    pub(super) fn phase(&self) -> f64 {
        elementary::atan2(self.shear, self.half_difference)
    }

    /// Whether both thresholds are equal.
    pub(super) fn is_isotropic(&self) -> bool {
        self.fibre == self.transverse
    }

    /// ρ.
    fn amplitude(&self) -> f64 {
        elementary::hypot(self.half_difference, self.shear)
    }

    /// v of x = 2δ/π.
    pub(super) fn variable(&self, x: f64) -> f64 {
        if self.exponent < 1.0 { elementary::pow(x, self.exponent) } else { x }
    }

    /// σ̄²·dc/dv.
    pub(super) fn rise(&self, side: f64, v: f64) -> f64 {
        self.at(side, v).rise
    }

    /// The maximum between `low` and `high`, where [`Curve::rise`] passes from plus to minus once, sought from `start`.
    pub(super) fn peak_between(&self, side: f64, [low, start, high]: [f64; 3]) -> Peak {
        let (mut at, mut point) = (start, None);
        let v = falling_root([low, start, high], |v| {
            let here = self.at(side, v);
            let (rise, slope) = (here.rise, here.rise_slope);
            (at, point) = (v, Some(here));
            (rise, slope)
        });
        // The last step is so small that c′ falls to zero along it in a straight line.
        let point = point.unwrap_or_else(|| self.at(side, v));
        let delta = FRAC_PI_2 * (point.x + point.x_slope * (v - at));
        let value = point.value + 0.5 * (v - at) * point.rise / (point.threshold * point.threshold);
        Peak { side, delta, value, origin: Origin::Smooth }
    }

    fn at(&self, side: f64, v: f64) -> Point {
        let power = elementary::pow(v, self.steepness() - 1.0);
        let x = if self.exponent < 1.0 { v * power } else { v };
        // From the nearer end, so that the sine vanishes at both.
        let is_far = x > 0.5;
        let (s, c) = elementary::sin_cos(PI * if is_far { 1.0 - x } else { x });
        self.point(side, v, power, (s, if is_far { -c } else { c }))
    }

    /// e ≥ 1: of x(v) and w(v) one is v itself and the other v^e.
    fn steepness(&self) -> f64 {
        if self.exponent < 1.0 { 1.0 / self.exponent } else { self.exponent }
    }

    /// The curve at v, where v^(e − 1) is `power` and 2δ has this sine and cosine.
    fn point(&self, side: f64, v: f64, power: f64, (s, c): (f64, f64)) -> Point {
        let e = self.steepness();
        let (bent, linear) = ([v * power, e * power, e * (e - 1.0) * power / v], [v, 1.0, 0.0]);
        let ([x, x1, x2], [w, w1, w2]) = if self.exponent < 1.0 { (bent, linear) } else { (linear, bent) };
        let (a, b) = (self.half_difference, side * self.shear);
        let stress = self.mean + a * c - b * s;
        let stress_x = -PI * (a * s + b * c);
        let stress_xx = -PI * PI * (a * c - b * s);
        let threshold = (1.0 - w) * self.transverse + w * self.fibre;
        let step = self.fibre - self.transverse;
        Point {
            x,
            x_slope: x1,
            value: stress / threshold,
            threshold,
            rise: stress_x * x1 * threshold - stress * step * w1,
            rise_slope: (stress_xx * x1 * x1 + stress_x * x2) * threshold - stress * step * w2,
        }
    }
}

/// The root between `low` and `high` of a function (given with its derivative) that passes there from plus to minus: Newton
/// from `start` while it stays inside the bracket and at least halves its steps, else bisection.
pub(super) fn falling_root([mut low, start, mut high]: [f64; 3], mut f: impl FnMut(f64) -> (f64, f64)) -> f64 {
    let mut x = start;
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
