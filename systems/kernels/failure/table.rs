//! All smooth maxima of the curve by a table of its slope, as exactly as [`bends`](super::bends) and several times as fast.
//!
//! For given strengths the rise σ̄²·c′ and the bending ρ·sin H are linear in the stress (m, a, ±b): at fixed nodes they are
//! three products each. Within a cell H is monotone and turns by less than π, so the signs of the bending at its two ends
//! say whether it is concave, convex, or holds one inflection. Then a cell holds one maximum exactly where the rise passes
//! from plus to minus; except that a cell with an inflection can hide a maximum and a minimum between equal signs. Where
//! the rise at its ends does not exclude that, it is evaluated at the inflection, where it is extreme.

use super::curve::{Curve, Peak, falling_root};
use super::{Strength, bends};
use crate::math::{Sym2, elementary};
use glam::DVec2;
use std::f64::consts::PI;

/// Nodes, at most 64 as their signs are bits of a word. Fewer make a cheaper pass and a poorer first guess.
const NODES: usize = 24;
/// Exponents for which the cells resolve the threshold.
const EXPONENTS: std::ops::RangeInclusive<f64> = 0.02..=50.0;

/// The nodes for one set of strengths.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Table {
    /// The branch variable, ascending from 0 to 1.
    variable: [f64; NODES],
    /// σ̄²·dc/dv on the fibre's left, per unit of m, a and b.
    rise: [[f64; NODES]; 3],
    /// How far the rise strays from its chord within the cell that begins at a node, per unit of m, a and b.
    stray: [[f64; NODES]; 3],
    /// ρ·sin H times a positive number, per unit of a and b.
    bending: [[f64; NODES]; 2],
}

/// Signs of slope and curvature at the nodes, bit by bit.
#[derive(Clone, Copy, Default)]
struct Signs {
    rising: u64,
    concave: u64,
}

impl Table {
    /// `None` where the exponent is out of range or both thresholds are equal.
    pub(super) fn new(strength: &Strength) -> Option<Self> {
        let unit = |xx: f64, yy: f64, xy: f64| Curve::new(Sym2::new(xx, yy, xy), DVec2::X, strength);
        let curves = [unit(1.0, 1.0, 0.0)?, unit(-1.0, 1.0, 0.0)?, unit(0.0, 0.0, 1.0)?];
        if curves[0].is_isotropic() || !EXPONENTS.contains(&strength.exponent) {
            return None;
        }
        let gamma = 1.0 - strength.exponent;
        let variable = variables(&curves[0], bends::turning(gamma) / PI);
        let rise = curves.map(|curve| variable.map(|v| curve.rise(1.0, v)));
        let bending = [0, 1].map(|part| variable.map(|v| bending(gamma, angle(strength.exponent, v))[part]));
        let stray = [0, 1, 2].map(|part| strays(&curves[part], &variable, &rise[part]));
        Some(Self { variable, rise, stray, bending })
    }

    /// Calls `found` for every smooth local maximum strictly between the kinks.
    pub(super) fn for_each_peak(&self, curve: &Curve, mut found: impl FnMut(Peak)) {
        for (signs, side) in self.signs(curve).into_iter().zip([1.0, -1.0]) {
            let Signs { rising, concave } = signs;
            // Bit k for the cell between nodes k and k + 1.
            let cells = (1 << (NODES - 1)) - 1;
            let peaks = rising & !(rising >> 1) & (concave | concave >> 1) & cells;
            let dips = rising & (rising >> 1) & concave & !(concave >> 1) & cells;
            let bumps = !rising & !(rising >> 1) & !concave & (concave >> 1) & cells;
            let mut left = peaks | dips | bumps;
            while left != 0 {
                let (k, bit) = (left.trailing_zeros() as usize, left & left.wrapping_neg());
                left ^= bit;
                let (low, high) = (self.variable[k], self.variable[k + 1]);
                if peaks & bit != 0 {
                    found(curve.peak_between(side, [low, self.guess(curve, side, k), high]));
                    continue;
                }
                if self.keeps_its_sign(curve, side, k) {
                    continue;
                }
                let inflection = self.inflection(curve, side, k);
                let is_rising = curve.rise(side, inflection) > 0.0;
                if dips & bit != 0 && !is_rising {
                    found(curve.peak_between(side, [low, 0.5 * (low + inflection), inflection]));
                } else if bumps & bit != 0 && is_rising {
                    found(curve.peak_between(side, [inflection, 0.5 * (inflection + high), high]));
                }
            }
        }
    }

    fn signs(&self, curve: &Curve) -> [Signs; 2] {
        let (m, a, b) = (curve.mean, curve.half_difference, curve.shear);
        let mut signs = [Signs::default(); 2];
        for k in 0..NODES {
            let (even, odd) = (m * self.rise[0][k] + a * self.rise[1][k], b * self.rise[2][k]);
            signs[0].rising |= u64::from(even + odd > 0.0) << k;
            signs[1].rising |= u64::from(even - odd > 0.0) << k;
            let (even, odd) = (a * self.bending[0][k], b * self.bending[1][k]);
            signs[0].concave |= u64::from(even + odd > 0.0) << k;
            signs[1].concave |= u64::from(even - odd > 0.0) << k;
        }
        signs
    }

    fn rise_at(&self, curve: &Curve, side: f64, k: usize) -> f64 {
        curve.mean * self.rise[0][k] + curve.half_difference * self.rise[1][k] + side * curve.shear * self.rise[2][k]
    }

    /// Whether the rise, of one sign at both ends of cell `k`, is too far from zero to reach it between them.
    fn keeps_its_sign(&self, curve: &Curve, side: f64, k: usize) -> bool {
        let [m, a, b] = [0, 1, 2].map(|part| self.stray[part][k]);
        let stray = m * curve.mean.abs() + a * curve.half_difference.abs() + b * curve.shear.abs();
        self.rise_at(curve, side, k).abs().min(self.rise_at(curve, side, k + 1).abs()) > stray
    }

    /// The root in cell `k` of the parabola v(rise) through its ends and a node beside them, or of the chord.
    fn guess(&self, curve: &Curve, side: f64, k: usize) -> f64 {
        let nodes = [k, k + 1, if k == 0 { 2 } else { k - 1 }];
        let ([p, q, r], [u, v, w]) = (nodes.map(|k| self.rise_at(curve, side, k)), nodes.map(|k| self.variable[k]));
        let chord = u + (v - u) * (p / (p - q));
        let parabola = chord + ((v - u) / (q - p) - (w - u) / (r - p)) / (q - r) * p * q;
        [parabola, chord].into_iter().find(|guess| *guess >= u && *guess <= v).unwrap_or(0.5 * (u + v))
    }

    /// Where σ_u changes its bending within cell `k`.
    fn inflection(&self, curve: &Curve, side: f64, k: usize) -> f64 {
        let gamma = 1.0 - curve.exponent;
        let (a, b) = (curve.half_difference, side * curve.shear);
        let at = |k: usize| a * self.bending[0][k] + b * self.bending[1][k];
        let sign = if at(k) > at(k + 1) { 1.0 } else { -1.0 };
        let [low, high] = [k, k + 1].map(|k| angle(curve.exponent, self.variable[k]));
        let start = low + (high - low) * (at(k) / (at(k) - at(k + 1))).clamp(0.0, 1.0);
        let y = falling_root([low, start, high], |y| {
            let (s, c) = elementary::sin_cos(y);
            let (p, q) = (gamma * s + y * c, gamma * c - y * s);
            (sign * (a * p + b * q), sign * (a * (q + c) - b * (p + s)))
        });
        curve.variable(y / PI)
    }
}

/// Per cell a bound of how far a curve's rise strays from its chord: twice the largest of three distances.
fn strays(curve: &Curve, variable: &[f64; NODES], rise: &[f64; NODES]) -> [f64; NODES] {
    let mut strays = [0.0; NODES];
    for k in 0..NODES - 1 {
        for part in [0.25, 0.5, 0.75] {
            let v = variable[k] + (variable[k + 1] - variable[k]) * part;
            let chord = rise[k] + (rise[k + 1] - rise[k]) * part;
            strays[k] = f64::max(strays[k], 2.0 * (curve.rise(1.0, v) - chord).abs());
        }
    }
    strays
}

/// y of the branch variable.
fn angle(exponent: f64, v: f64) -> f64 {
    PI * if exponent < 1.0 { elementary::pow(v, 1.0 / exponent) } else { v }
}

/// |γ + i·y|·sin H per unit of a = ρ·cos ψ and b = ρ·sin ψ.
fn bending(gamma: f64, y: f64) -> [f64; 2] {
    let (s, c) = if gamma == 0.0 && y == 0.0 { return [1.0, 0.0] } else { elementary::sin_cos(y) };
    [gamma * s + y * c, gamma * c - y * s]
}

/// The nodes: evenly in δ, and for a cusp as many evenly in w. The one nearest to the turn of H is put onto it.
fn variables(curve: &Curve, turning: f64) -> [f64; NODES] {
    let is_cusp = curve.exponent < 1.0;
    let mut nodes = [0.0; NODES];
    for (k, node) in nodes.iter_mut().enumerate() {
        let even = k as f64 / (NODES - 1) as f64;
        *node = if is_cusp && k % 2 == 1 && k + 1 < NODES { curve.variable(even) } else { even };
    }
    nodes.sort_unstable_by(f64::total_cmp);
    if turning > 0.0 {
        let nearest = (turning * (NODES - 1) as f64).round() as usize;
        nodes[nearest.clamp(1, NODES - 2)] = turning;
    }
    nodes
}
