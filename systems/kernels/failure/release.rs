//! The energy-based criterion: the direction in which a small kink of a crack releases most energy against its toughness.
//!
//! A kink at the angle θ has, to first order, the intensities of the tractions on it in the crack's own field (Nuismer 1975; in
//! orthotropic plates the same construction): k_I = √(2πr)·σ_θθ(θ), k_II = √(2πr)·σ_rθ(θ). It releases as much as a crack along θ
//! does at these (Sih, Paris, Irwin 1965), where faces that press on each other (k_I < 0) release by sliding alone. The
//! value of a direction is √(G(θ)/G_c(δ)), δ its angle to the fibre: in proportion to the load.

use super::directions::{Worth, best_direction};
use super::{Cone, Decision, Sector, Strength, unit};
use crate::math::{CrackTip, Orthotropic, elementary};
use glam::DVec2;
use std::f64::consts::PI;

/// Lips are this near \[rad\] to the line behind the tip: the field is not asked there.
const LIPS: f64 = 2e-4;

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

impl TipField {
    /// Energy released straight ahead per area \[N/mm\].
    pub fn release(&self) -> f64 {
        let [opening, sliding] = self.intensities;
        CrackTip::new(&self.law, elementary::turn(self.ahead, self.fibre)).energy_release(opening, sliding)
    }
}

/// Energy criterion √(G/G_c) of a small kink by direction.
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
}

impl Worth for Release<'_> {
    fn fibre_to_ahead(&self) -> f64 {
        self.fibre_to_crack
    }

    fn value_at(&self, theta: f64, delta: f64) -> f64 {
        let stress = self.tip.stress(theta);
        let [opening, sliding] = self.field.intensities;
        let turned = (stress.opening * opening + stress.sliding * sliding).in_axes_turned_by(theta);
        let kink = CrackTip::new(&self.field.law, self.fibre_to_crack - theta);
        let release = kink.energy_release(turned.yy.max(0.0), turned.xy);
        (release / self.toughness.threshold(delta)).max(0.0).sqrt()
    }

    fn is_defined(&self, theta: f64) -> bool {
        theta.abs() < PI - LIPS
    }
}

/// √(G/G_c) of one direction, the value that [`evaluate_release`] maximises. Zero along the crack's lips.
pub fn release_value(field: &TipField, toughness: &Strength, d: DVec2) -> f64 {
    let (theta, release) = (elementary::turn(field.ahead, d), Release::new(field, toughness));
    if release.is_defined(theta) { release.value(theta) } else { 0.0 }
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
    best_direction(&Release::new(field, toughness), (fibre, ahead), cone, sector)
}

/// Energy criterion √(g·d/G_c) of a material force by direction.
struct Pull<'a> {
    fibre_to_ahead: f64,
    /// Magnitude of the material force \[N/mm\].
    size: f64,
    toughness: &'a Strength,
}

impl Worth for Pull<'_> {
    fn fibre_to_ahead(&self) -> f64 {
        self.fibre_to_ahead
    }

    fn value_at(&self, theta: f64, delta: f64) -> f64 {
        (self.size * elementary::cos(theta) / self.toughness.threshold(delta)).max(0.0).sqrt()
    }

    fn is_defined(&self, _: f64) -> bool {
        true
    }
}

/// √(g·d/G_c) of one direction, the value that [`evaluate_pull`] maximises.
pub fn pull_value(release: DVec2, fibre: DVec2, toughness: &Strength, d: DVec2) -> f64 {
    let pull = Pull { fibre_to_ahead: elementary::turn(release, fibre), size: release.length(), toughness };
    pull.value(elementary::turn(release, d))
}

/// The admissible direction of the largest √(g·d/G_c) for a material force `release` \[N/mm\], as [`evaluate_release`] gives that of
/// a crack's field: Griffith's criterion with the energy that an advance along d releases to first order.
pub fn evaluate_pull(
    release: DVec2,
    fibre: DVec2,
    toughness: &Strength,
    cone: Option<Cone>,
    sector: Option<Sector>,
) -> Option<Decision> {
    let fibre = unit(fibre)?;
    // No force at all is worth nothing in every direction.
    let ahead = unit(release).or(cone.map(|cone| cone.previous)).unwrap_or(fibre);
    let pull = Pull { fibre_to_ahead: elementary::turn(ahead, fibre), size: release.length(), toughness };
    best_direction(&pull, (fibre, ahead), cone, sector)
}
