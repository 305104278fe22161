//! The energy-based criterion: the direction in which a small kink of a crack releases most energy against its toughness.
//!
//! A kink at the angle θ has, to first order, the intensities of the tractions on it in the crack's own field (Nuismer 1975; in
//! orthotropic plates the same construction): k_I = √(2πr)·σ_θθ(θ), k_II = √(2πr)·σ_rθ(θ). It releases what a crack along θ
//! does at these (Sih, Paris, Irwin 1965), where faces that press on each other (k_I < 0) release by sliding alone. The
//! value of a direction is √(G(θ)/G_c(δ)), δ its angle to the fibre: in proportion to the load.

use super::ranking::Ranking;
use super::region::Region;
use super::{Cone, Decision, Origin, Sector, Strength, unit};
use crate::math::{CrackTip, Orthotropic, elementary};
use glam::DVec2;
use std::f64::consts::PI;

/// Half the base of central differences \[rad\]; also how far from a kink of the toughness slopes are taken.
const DIFFERENCE: f64 = 1e-4;
/// Cells into which the circle is cut: of each, whether the value rises at its start and falls at its end. A cell is 3° wide; two
/// maxima nearer than that are one decision.
const CELLS: i32 = 120;
/// Halvings of a cell: to 1e-14 rad, below the rounding of a difference.
const HALVINGS: usize = 42;

/// The field at a crack's tip, in axes of the caller's.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TipField {
    /// Elastic constants at the tip.
    pub law: Orthotropic,
    /// Unit direction of the fibre.
    pub fibre: DVec2,
    /// Unit direction in which the crack points.
    pub ahead: DVec2,
    /// K_I, K_II \[MPa·√mm\].
    pub intensities: [f64; 2],
}

/// What a direction is worth.
struct Release<'a> {
    tip: CrackTip,
    fibre_to_crack: f64,
    field: &'a TipField,
    /// G_c \[N/mm\] in the place of strengths: `fibre` across the fibres, `transverse` along them.
    toughness: &'a Strength,
}

impl<'a> Release<'a> {
    fn new(field: &'a TipField, toughness: &'a Strength) -> Self {
        let fibre_to_crack = elementary::turn(field.ahead, field.fibre);
        Self { tip: CrackTip::new(&field.law, fibre_to_crack), fibre_to_crack, field, toughness }
    }

    /// √(G/G_c) of a kink at the angle `theta` \[rad\] from the crack, at the angle `delta` \[rad\] to the fibre.
    fn value_at(&self, theta: f64, delta: f64) -> f64 {
        let stress = self.tip.stress(theta);
        let [opening, sliding] = self.field.intensities;
        let turned = (stress.opening * opening + stress.sliding * sliding).in_axes_turned_by(theta);
        let kink = CrackTip::new(&self.field.law, self.fibre_to_crack - theta);
        let release = kink.energy_release(turned.yy.max(0.0), turned.xy);
        (release / self.toughness.threshold(delta)).max(0.0).sqrt()
    }

    fn value(&self, theta: f64) -> f64 {
        let turn = elementary::sin_cos(self.fibre_to_crack - theta);
        self.value_at(theta, elementary::atan2(turn.0.abs(), turn.1.abs()))
    }

    fn rise(&self, theta: f64) -> f64 {
        self.value(theta + DIFFERENCE) - self.value(theta - DIFFERENCE)
    }

    fn direction(&self, theta: f64) -> DVec2 {
        elementary::unit_at(theta).rotate(self.field.ahead)
    }
}

/// √(G/G_c) of one direction: what [`evaluate_release`] searches. Zero along the crack's lips.
pub fn release_value(field: &TipField, toughness: &Strength, d: DVec2) -> f64 {
    let theta = elementary::turn(field.ahead, d);
    if is_off_lips(theta) { Release::new(field, toughness).value(theta) } else { 0.0 }
}

/// Whether the field can be asked at this angle \[rad\] and a little beside.
fn is_off_lips(theta: f64) -> bool {
    theta.abs() < PI - 2.0 * DIFFERENCE
}

/// The admissible direction of the largest √(G/G_c), with its runner-up, as [`evaluate`](super::evaluate) gives that of the
/// largest c; `toughness` holds G_c \[N/mm\] across (`fibre`) and along (`transverse`) the fibres. `None` if no direction is
/// admissible or an input is not finite.
pub fn evaluate_release(
    field: &TipField,
    toughness: &Strength,
    cone: Option<Cone>,
    sector: Option<Sector>,
) -> Option<Decision> {
    let (fibre, ahead) = (unit(field.fibre)?, unit(field.ahead)?);
    let field = &TipField { fibre, ahead, ..*field };
    let release = Release::new(field, toughness);
    let region = Region::new(cone, sector)?;
    let limits = region.limits();
    let mut ranking = Ranking::new(fibre, region);

    let mut bends =
        [(fibre, 0.0), (fibre.perp(), 0.5 * PI), (-fibre, 0.0), (-fibre.perp(), 0.5 * PI)].map(|(d, delta)| {
            let theta = elementary::turn(ahead, d);
            let value = if is_off_lips(theta) { release.value_at(theta, delta) } else { 0.0 };
            let rises = [DIFFERENCE, -DIFFERENCE].map(|step| is_off_lips(theta) && release.value(theta + step) > value);
            ranking.offer(d, value, Origin::Kink, rises);
            theta
        });
    bends.sort_by(f64::total_cmp);

    let cell = 2.0 * PI / f64::from(CELLS);
    let mut search = |mut low: f64, mut high: f64| {
        if high <= low || !(release.rise(low) > 0.0 && release.rise(high) <= 0.0) {
            return;
        }
        for _ in 0..HALVINGS {
            let middle = 0.5 * (low + high);
            *if release.rise(middle) > 0.0 { &mut low } else { &mut high } = middle;
        }
        ranking.offer(release.direction(high), release.value(high), Origin::Smooth, [false; 2]);
    };
    // Half a cell off, so that straight ahead, where symmetry puts maxima, lies inside one.
    for i in 1 - CELLS / 2..CELLS / 2 {
        let (mut from, to) = (cell * (f64::from(i) - 0.5), cell * (f64::from(i) + 0.5));
        if !region.admits(release.direction(from)) && !region.admits(release.direction(to)) {
            continue;
        }
        for bend in bends {
            if from < bend && bend < to {
                search(from, bend - DIFFERENCE);
                from = bend + DIFFERENCE;
            }
        }
        search(from, to);
    }
    for d in limits.into_iter().flatten() {
        let theta = elementary::turn(ahead, d);
        if is_off_lips(theta) {
            let value = release.value(theta);
            let rises = [DIFFERENCE, -DIFFERENCE].map(|step| release.value(theta + step) > value);
            ranking.offer(d, value, Origin::Limit, rises);
        }
    }
    ranking.decide(1.0)
}
