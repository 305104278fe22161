//! How a device passes from one haptic model to the next: without a jump of the force, and without a gain of energy.
//!
//! Each model takes the place of the last over an interval. The force felt meanwhile, (1 − s)·F₁(x) + s·F₂(x), is a model too: its
//! stiffness is positive semidefinite as both are, and the next model replaces it. The force is therefore continuous
//! whenever models come. Models that change while the hand moves may still give energy: a force there on the way along it, and gone on the way
//! back. An observer keeps account of the hand's work (time-domain passivity, Hannaford, Ryu 2002). Where it would be given more
//! than it has put in since the first model, the force along its motion is cut: it is given at most half of one call's work too much. The account holds no more than tissue under this load can: F·S⁻¹·F, twice the
//! energy of a linear spring. A spring that stiffens as any power of its length has stored less.

use super::haptic_feed::HapticModel;
use glam::{DMat3, DVec3};

/// The stiffness that counts at least in the energy under a load, as part of the largest.
const LEAST_STIFFNESS: f64 = 1e-6;

/// Blends successive models of one grasp for one device; the next grasp begins a new one. It runs on the device's thread, and neither waits nor
/// allocates.
#[derive(Clone, Debug)]
pub struct HapticBlend {
    interval: f64,
    from: Option<HapticModel>,
    to: Option<HapticModel>,
    /// Part of the way from one to the other.
    part: f64,
    /// Energy that the hand may be given \[mJ\].
    credit: f64,
    withheld: f64,
    /// Where the hand was, and the force of the tool on the tissue there.
    last: Option<(DVec3, DVec3)>,
}

impl HapticBlend {
    /// A blend in which each model takes the place of the last within `interval` \[ms\], best the time between models. A value that is not
    /// a positive number is taken for no time at all: forces then jump.
    pub fn new(interval: f64) -> Self {
        let interval = if interval > 0.0 { interval } else { 0.0 };
        Self { interval, from: None, to: None, part: 1.0, credit: 0.0, withheld: 0.0, last: None }
    }

    /// Takes a model over. One that it has already, by its time, is left as it is.
    pub fn hand_over(&mut self, model: &HapticModel) {
        if self.to.is_some_and(|to| to.time == model.time) || !is_finite(model) {
            return;
        }
        self.from = self.model();
        self.to = Some(*model);
        self.part = 0.0;
    }

    /// The model that is felt now; `None` before the first.
    pub fn model(&self) -> Option<HapticModel> {
        let to = self.to?;
        let Some(from) = self.from.filter(|_| self.part < 1.0) else { return Some(to) };
        let (old, new) = (1.0 - self.part, self.part);
        let stiffness = from.stiffness * old + to.stiffness * new;
        let force = from.force_at(to.position) * old + to.force * new;
        Some(HapticModel { stiffness, force, ..to })
    }

    /// Force of the tool on the tissue \[N\] with the tool at a position \[mm\], `elapsed` \[ms\] after the last call; the hand feels the
    /// opposite. `None` before the first model, and for a position or a time that is not finite.
    pub fn force_at(&mut self, elapsed: f64, position: DVec3) -> Option<DVec3> {
        if !(elapsed >= 0.0 && elapsed.is_finite() && position.is_finite()) {
            return None;
        }
        self.to?;
        self.part = if elapsed < self.interval * (1.0 - self.part) { self.part + elapsed / self.interval } else { 1.0 };
        let model = self.model()?;
        let mut force = model.force_at(position);
        if let Some((before, force_before)) = self.last {
            let way = position - before;
            // By the trapezoidal rule, exact for the forces of one model: with half of the force felt now kept back for the next call.
            let most = (self.credit + 0.5 * force_before.dot(way)).max(0.0);
            let excess = -force.dot(way) - most;
            if let Some(along) = way.try_normalize().filter(|_| excess > 0.0) {
                force += along * (excess / way.length());
                self.withheld += excess;
            }
            self.credit += 0.5 * (force_before + force).dot(way);
            self.credit = self.credit.min(most_stored(&model, force));
        }
        self.last = Some((position, force));
        Some(force)
    }

    /// Energy \[mJ\] that the hand has not been given because it had not put it in.
    pub fn withheld(&self) -> f64 {
        self.withheld
    }
}

fn is_finite(model: &HapticModel) -> bool {
    model.time.is_finite() && model.position.is_finite() && model.force.is_finite() && model.stiffness.is_finite()
}

/// The most energy \[mJ\] that tissue of a model's stiffness may hold under a force.
fn most_stored(model: &HapticModel, force: DVec3) -> f64 {
    let stiffness = model.stiffness;
    let largest = stiffness.x_axis.x + stiffness.y_axis.y + stiffness.z_axis.z;
    let raised = stiffness + DMat3::from_diagonal(DVec3::splat(LEAST_STIFFNESS * largest));
    let stored = force.dot(raised.inverse() * force);
    // Without any stiffness there is no bound.
    if stored >= 0.0 { stored } else { f64::INFINITY }
}
