//! All smooth maxima of the curve by enumeration, without sampling.
//!
//! In the variable w = (2δ/π)^α the threshold is *affine*. So c = σ_u/σ̄ is quasiconvex where σ_u is convex in w (no
//! maximum inside) and quasiconcave where σ_u is concave in w (at most one). With σ_u = m + ρ·cos(2δ + ψ), y = 2δ and
//! γ = 1 − α, the second derivative of σ_u in w has the sign of −sin H, H(y) = y + ψ + arg(γ + i·y). H turns at most once,
//! so its passages through multiples of π are enumerated, not searched for, and each concave stretch holds at most one
//! bracketed root of c′.

use super::curve::{Curve, Peak, falling_root};
use crate::math::elementary;
use std::f64::consts::{FRAC_PI_2, PI};

/// Calls `found` for every smooth local maximum strictly between the kinks; both thresholds differ.
pub(super) fn for_each_peak(curve: &Curve, mut found: impl FnMut(Peak)) {
    let gamma = 1.0 - curve.exponent;
    for side in [1.0, -1.0] {
        let phase = side * curve.phase();
        let (nodes, count) = inflections(gamma, phase);
        let mut from = 0.0;
        for &to in nodes[..count].iter().chain([&PI]) {
            if to > from && elementary::sin(bend(gamma, 0.5 * (from + to), phase)) > 0.0 {
                let (low, high) = (curve.variable(from / PI), curve.variable(to / PI));
                if curve.rise(side, low) > 0.0 && curve.rise(side, high) < 0.0 {
                    found(curve.peak_between(side, [low, 0.5 * (low + high), high]));
                }
            }
            from = to;
        }
    }
}

/// H(y): σ_u is concave in w where sin H > 0.
pub(super) fn bend(gamma: f64, y: f64, phase: f64) -> f64 {
    // At α = 1 the limit y → 0 is wanted, where atan2(0, 0) is 0.
    let turn = if gamma == 0.0 { FRAC_PI_2 } else { elementary::atan2(y, gamma) };
    y + phase + turn
}

/// The y in [0, π) at which H turns; zero where it does not.
pub(super) fn turning(gamma: f64) -> f64 {
    // dH/dy = 1 + γ/(γ² + y²) vanishes there.
    (-gamma * (1.0 + gamma)).max(0.0).sqrt()
}

/// The y in (0, π) where σ_u as a function of w changes its bending, ascending.
fn inflections(gamma: f64, phase: f64) -> ([f64; 4], usize) {
    let turning = turning(gamma);
    let (mut nodes, mut count) = ([0.0; 4], 0);
    for (from, to) in [(0.0, turning), (turning, PI)] {
        let (start, end) = (bend(gamma, from, phase), bend(gamma, to, phase));
        let sign = if start > end { 1.0 } else { -1.0 };
        for multiple in (start.min(end) / PI).ceil() as i32..=(start.max(end) / PI).floor() as i32 {
            if to > from && count < nodes.len() {
                nodes[count] = falling_root([from, 0.5 * (from + to), to], |y| {
                    let slope = 1.0 + if gamma == 0.0 { 0.0 } else { gamma / (gamma * gamma + y * y) };
                    (sign * (bend(gamma, y, phase) - f64::from(multiple) * PI), sign * slope)
                });
                count += 1;
            }
        }
    }
    (nodes, count)
}
