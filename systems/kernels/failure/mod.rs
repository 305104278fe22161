//! The tear criterion: where, and whether, a fibrous membrane fails at a point (Allard, Marchal, Cotin 2009, eq. 3–6, with
//! the misprints of eq. 4 and 6 corrected: c = +σ/σ̄, and σ̄_F where σ̄_L is printed).
//!
//! For a direction `d` in the rest surface, u = d⊥ and δ = angle(d, fibre) in [0, π/2]:
//! c(d) = σ_u/σ̄(δ), σ_u = u·T·u, σ̄(δ) = σ̄_T + (σ̄_F − σ̄_T)·(2δ/π)^α. The membrane tears where max c > 1.
//!
//! The maximum is exact: `bends` lists every smooth maximum of c, or `table` does so with work shared between searches;
//! `region` lists the limits of the admissible set; with the kinks d = ±f, ±f⊥ these are all the candidates there can be,
//! and `ranking` chooses.
//!
//! `release` is the other criterion, on energy, from a crack's field or a material force: it shares the admissible set and the
//! choice, and searches by `directions`.

mod bends;
mod curve;
mod directions;
mod ranking;
mod region;
mod release;
mod table;

pub use release::{TipField, evaluate_pull, evaluate_release, pull_value, release_value};

use crate::math::{Sym2, elementary};
use curve::{Curve, Peak};
use glam::DVec2;
use ranking::Ranking;
use region::Region;
use std::f64::consts::FRAC_PI_2;
use table::Table;

/// Values closer than this, relatively, are a tie.
const VALUE_TIE: f64 = 1e-12;
/// Below this margin to the runner-up a decision is ambiguous.
const AMBIGUOUS_MARGIN: f64 = 0.05;

/// Strength of the membrane against a tear along or across its fibre.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Strength {
    /// σ̄_F, threshold of the stress along the fibre, against a tear that cuts the fibres \[MPa\].
    pub fibre: f64,
    /// σ̄_T, threshold of the stress across the fibre, against a tear that runs along it \[MPa\].
    pub transverse: f64,
    /// α, exponent of the passage from one to the other; a sharp preference for the fibre needs α ≤ 1.
    pub exponent: f64,
}

/// Why a set of strengths is refused.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[error("{name} = {value}: it must be positive and finite")]
pub struct InadmissibleStrength {
    /// Name of the parameter.
    pub name: &'static str,
    /// Value of the parameter.
    pub value: f64,
}

impl Strength {
    /// Thresholds along and across the fibre \[MPa\] and the exponent between them.
    ///
    /// # Errors
    /// Each must be positive and finite.
    pub fn new(fibre: f64, transverse: f64, exponent: f64) -> Result<Self, InadmissibleStrength> {
        for (name, value) in
            [("strength_across_fibres", fibre), ("strength_along_fibres", transverse), ("strength_exponent", exponent)]
        {
            if !(value > 0.0 && value.is_finite()) {
                return Err(InadmissibleStrength { name, value });
            }
        }
        Ok(Self { fibre, transverse, exponent })
    }

    /// With both thresholds `factor` times as large.
    #[must_use]
    pub fn times(self, factor: f64) -> Self {
        Self { fibre: self.fibre * factor, transverse: self.transverse * factor, ..self }
    }

    /// σ̄(δ) \[MPa\], eq. 6, for a tear at the angle `delta` \[rad\] in [0, π/2] to the fibre; exactly σ̄_T at 0 and σ̄_F at π/2.
    pub fn threshold(&self, delta: f64) -> f64 {
        let w = elementary::pow(delta / FRAC_PI_2, self.exponent);
        (1.0 - w) * self.transverse + w * self.fibre
    }

    /// The smallest threshold of any direction \[MPa\].
    pub fn smallest(&self) -> f64 {
        self.fibre.min(self.transverse)
    }
}

/// The directions a running tear may turn into: d·p ≥ cos θ_P (eq. 4).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cone {
    /// p, the direction the tear came in.
    pub previous: DVec2,
    /// θ_P \[rad\], at least 0; from π up it admits everything.
    pub half_angle: f64,
}

/// The directions that lie in the triangles connected to a point: an interval of angles \[rad\], counter-clockwise from the
/// first axis, with `from <= to <= from + 2π`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sector {
    /// First angle \[rad\].
    pub from: f64,
    /// Last angle \[rad\].
    pub to: f64,
}

/// A direction and its value.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Candidate {
    /// Unit direction; where directions are lines, the one that points up.
    pub direction: DVec2,
    /// c(d); the membrane tears above 1. Negative under pure compression.
    pub value: f64,
}

impl Candidate {
    /// Angle of the direction from the first axis \[rad\], in (−π, π]; not negative where directions are lines.
    pub fn angle(&self) -> f64 {
        elementary::angle_of(self.direction)
    }
}

/// Kind of point that a maximum is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Origin {
    /// A stationary point between the kinks.
    Smooth,
    /// Exactly along or exactly across the fibre, where the threshold has a kink.
    Kink,
    /// A limit of the cone or of the sector.
    Limit,
    /// The line across the largest principal stress: both thresholds are equal.
    Principal,
}

/// The outcome of the criterion at one point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Decision {
    /// The exact maximiser.
    pub best: Candidate,
    /// Kind of the maximum.
    pub origin: Origin,
    /// The best other local maximum at least 2° away.
    pub runner_up: Option<Candidate>,
}

impl Decision {
    /// How far the runner-up stays behind, relative to the best: 1 − c₂/c₁ in tension. Infinite without a runner-up.
    pub fn margin(&self) -> f64 {
        match self.runner_up {
            None => f64::INFINITY,
            Some(other) if other.value == self.best.value => 0.0,
            Some(other) => ((self.best.value - other.value) / self.best.value.abs()).max(0.0),
        }
    }

    /// Whether the runner-up is so close (margin under 5 %) that the decision is ambiguous by nature.
    pub fn is_ambiguous(&self) -> bool {
        self.margin() < AMBIGUOUS_MARGIN
    }

    /// Whether the runner-up is as good as the best, so that the tie rule of [`evaluate`] decided.
    pub fn is_tie(&self) -> bool {
        self.margin() <= VALUE_TIE
    }

    /// The result where all thresholds are `factor` times as large.
    #[must_use]
    pub fn over(self, factor: f64) -> Self {
        let over = |candidate: Candidate| Candidate { value: candidate.value / factor, ..candidate };
        Self { best: over(self.best), runner_up: self.runner_up.map(over), ..self }
    }

    /// Whether the membrane fails here.
    pub fn tears(&self) -> bool {
        self.best.value > 1.0
    }
}

/// Whether no direction can reach c > 1, from a bound far cheaper than [`evaluate`]: the largest principal stress is at most
/// the smallest threshold.
#[inline]
pub fn cannot_tear(stress: Sym2, strength: &Strength) -> bool {
    stress.principal_values().0 <= strength.smallest()
}

/// c(d) of eq. 3 and 5 for one direction; `fibre` and `d` need not be unit, but must have a direction.
pub fn direction_value(stress: Sym2, fibre: DVec2, strength: &Strength, d: DVec2) -> f64 {
    // Not acos(|d·f|): near the fibre it loses half the digits of δ, which at α = 0.2 is 16 % of c.
    let delta = elementary::atan2(fibre.perp_dot(d).abs(), fibre.dot(d).abs());
    stress.normal_component(d.perp()) / d.length_squared() / strength.threshold(delta)
}

/// The search for the direction of largest c with a table of the threshold, for many searches with the same strengths.
///
/// The answers are those of [`evaluate`] to a few roundings.
#[derive(Clone, Debug, PartialEq)]
pub struct Search {
    strength: Strength,
    table: Option<Table>,
}

impl Search {
    /// Prepares the search: some microseconds.
    pub fn new(strength: Strength) -> Self {
        Self { strength, table: Table::new(&strength) }
    }

    /// The strengths it is for.
    pub fn strength(&self) -> &Strength {
        &self.strength
    }

    /// As [`evaluate`].
    pub fn evaluate(&self, stress: Sym2, fibre: DVec2, cone: Option<Cone>, sector: Option<Sector>) -> Option<Decision> {
        match &self.table {
            Some(table) => decide(stress, fibre, &self.strength, cone, sector, |curve, found| {
                table.for_each_peak(curve, found);
            }),
            None => evaluate(stress, fibre, &self.strength, cone, sector),
        }
    }
}

/// The direction of largest c among the admissible ones, with its runner-up; `None` if no direction is admissible or an
/// input is not finite (or has no direction).
///
/// A direction is admissible if d·p ≥ cos θ_P − 1e-9 (no cone: all) and it lies in the sector to 1e-9 rad (no sector: all).
/// With neither, `d` and `−d` are one line, named by the direction that points up.
///
/// Ties (values equal to 1e-12, directions 2° or more apart) go to the direction nearest p. Then they go to the line met first
/// turning counter-clockwise from the fibre; then to the direction on the left of p, or the first one of the sector. The rule turns
/// with its input and does not see the fibre's sign.
pub fn evaluate(
    stress: Sym2,
    fibre: DVec2,
    strength: &Strength,
    cone: Option<Cone>,
    sector: Option<Sector>,
) -> Option<Decision> {
    decide(stress, fibre, strength, cone, sector, |curve, found| bends::for_each_peak(curve, found))
}

/// The decision, where `peaks` lists the smooth maxima of a curve with different thresholds.
fn decide(
    stress: Sym2,
    fibre: DVec2,
    strength: &Strength,
    cone: Option<Cone>,
    sector: Option<Sector>,
    peaks: impl FnOnce(&Curve, &mut dyn FnMut(Peak)),
) -> Option<Decision> {
    let fibre = unit(fibre)?;
    let curve = Curve::new(stress, fibre, strength)?;
    let mut ranking = Ranking::new(fibre, Region::new(cone, sector)?);

    // Turning counter-clockwise, δ grows on the fibre's left and shrinks on its right.
    let [left, right] = curve.slopes_along_fibre();
    ranking.offer_line(fibre, curve.value_along_fibre(), curve.kink_origin(), [left > 0.0, right > 0.0]);
    let [left, right] = curve.slopes_across_fibre();
    ranking.offer_line(fibre.perp(), curve.value_across_fibre(), curve.kink_origin(), [right < 0.0, left < 0.0]);
    let mut offer = |peak: Peak| {
        let (s, c) = elementary::sin_cos(peak.delta);
        ranking.offer_line(fibre * c + fibre.perp() * (peak.side * s), peak.value, peak.origin, [false; 2]);
    };
    if curve.is_isotropic() && !curve.is_constant() {
        offer(curve.principal_peak());
    } else if !curve.is_constant() {
        peaks(&curve, &mut offer);
    }
    ranking.offer_limits(&curve);
    ranking.decide(curve.unit_of_value)
}

/// `v` without its length, at any scale; `None` where it has no direction.
fn unit(v: DVec2) -> Option<DVec2> {
    let scale = v.abs().max_element();
    (v.is_finite() && scale > 0.0).then(|| (v / scale).normalize())
}
