//! The search for the direction of largest value, where values are smooth but for the toughness's kinks along and across the fibre.

use super::ranking::Ranking;
use super::region::Region;
use super::{Cone, Decision, Origin, Sector};
use crate::math::elementary;
use glam::DVec2;
use std::f64::consts::PI;

/// Half the base of central differences \[rad\]; also how far from a kink of the toughness slopes are taken.
const DIFFERENCE: f64 = 1e-4;
/// Cells into which the circle is cut: of each, whether the value rises at its start and falls at its end. A cell is 3° wide; two
/// maxima nearer than that are one decision.
const CELLS: i32 = 120;
/// Halvings of a cell: to 1e-14 rad, below the rounding of a difference.
const CELL_HALVINGS: usize = 42;

/// Value of a criterion by direction. Angles θ \[rad\] count from a direction ahead.
pub(super) trait Worth {
    /// Angle \[rad\] of the fibre.
    fn fibre_to_ahead(&self) -> f64;

    /// The value of a direction at the angle `theta` \[rad\] and at `delta` \[rad\] to the fibre.
    fn value_at(&self, theta: f64, delta: f64) -> f64;

    /// Whether there is a value at this angle \[rad\] and a little beside.
    fn is_defined(&self, theta: f64) -> bool;

    /// The value of a direction at the angle `theta` \[rad\].
    fn value(&self, theta: f64) -> f64 {
        let turn = elementary::sin_cos(self.fibre_to_ahead() - theta);
        self.value_at(theta, elementary::atan2(turn.0.abs(), turn.1.abs()))
    }

    /// By how much it grows over a small angle about `theta` \[rad\].
    fn rise(&self, theta: f64) -> f64 {
        self.value(theta + DIFFERENCE) - self.value(theta - DIFFERENCE)
    }
}

/// The admissible direction of the largest value, with its runner-up, for unit directions of the fibre and ahead.
pub(super) fn best_direction<W: Worth>(
    worth: &W,
    (fibre, ahead): (DVec2, DVec2),
    cone: Option<Cone>,
    sector: Option<Sector>,
) -> Option<Decision> {
    let region = Region::new(cone, sector)?;
    let limits = region.limits();
    let mut ranking = Ranking::new(fibre, region);
    let direction = |theta: f64| elementary::unit_at(theta).rotate(ahead);

    let mut bends =
        [(fibre, 0.0), (fibre.perp(), 0.5 * PI), (-fibre, 0.0), (-fibre.perp(), 0.5 * PI)].map(|(d, delta)| {
            let theta = elementary::turn(ahead, d);
            let value = if worth.is_defined(theta) { worth.value_at(theta, delta) } else { 0.0 };
            let rises =
                [DIFFERENCE, -DIFFERENCE].map(|step| worth.is_defined(theta) && worth.value(theta + step) > value);
            ranking.offer(d, value, Origin::Kink, rises);
            theta
        });
    bends.sort_by(f64::total_cmp);

    let cell = 2.0 * PI / f64::from(CELLS);
    let mut search = |mut low: f64, mut high: f64| {
        if high <= low || !(worth.rise(low) > 0.0 && worth.rise(high) <= 0.0) {
            return;
        }
        for _ in 0..CELL_HALVINGS {
            let middle = 0.5 * (low + high);
            *if worth.rise(middle) > 0.0 { &mut low } else { &mut high } = middle;
        }
        ranking.offer(direction(high), worth.value(high), Origin::Smooth, [false; 2]);
    };
    // Half a cell off, so that straight ahead, where symmetry puts maxima, lies inside one.
    for i in 1 - CELLS / 2..CELLS / 2 {
        let (mut from, to) = (cell * (f64::from(i) - 0.5), cell * (f64::from(i) + 0.5));
        if !region.admits(direction(from)) && !region.admits(direction(to)) {
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
        if worth.is_defined(theta) {
            let value = worth.value(theta);
            let rises = [DIFFERENCE, -DIFFERENCE].map(|step| worth.value(theta + step) > value);
            ranking.offer(d, value, Origin::Limit, rises);
        }
    }
    ranking.decide(1.0)
}
