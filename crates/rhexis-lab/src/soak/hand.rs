//! A surgeon's hand that errs.

use crate::stress::Dice;
use glam::DVec3;
use rhexis::components::{Grips, Jaws, Pose, Slip};
use rhexis::math::elementary;
use rhexis::simulation::Grasp;
use rhexis::snapshot::Snapshot;
use rhexis::storage::{ForcepsId, Vertices};
use rhexis_scene::Instance;
use std::f64::consts::TAU;

/// What the hand has.
#[derive(Default)]
pub(super) struct Hand {
    forceps: Vec<ForcepsId>,
    kept: Option<Snapshot>,
}

impl Hand {
    /// Takes over the grasps to come: each at another place, with another pull, and with a sway of up to 0.15 mm.
    pub(super) fn new(instance: &mut Instance, dice: &mut Dice) -> Self {
        if let Ok(grips) = instance.simulation.entity_mut::<&mut Grips>(instance.bodies[0]) {
            for grip in &mut grips.list {
                if let Some(near) = &mut grip.near_tip {
                    near.behind += dice.between(-0.1, 0.1);
                    near.left += dice.between(-0.1, 0.1);
                }
                let (sway, pull) = (dice.point() * 0.15, dice.between(0.9, 1.1));
                let (period, phase) = (dice.between(2500.0, 5000.0), dice.between(0.0, TAU));
                let start = grip.path.at(grip.from);
                for (time, hand) in &mut grip.path.points {
                    let swing = elementary::sin(TAU * (*time - grip.from) / period + phase) - elementary::sin(phase);
                    *hand = start + (*hand - start) * pull + sway * swing;
                }
            }
        }
        Self::default()
    }

    /// Perhaps does something before a step that was not asked for. What the engine refuses of it, it may refuse. Returns how many
    /// states it went back to.
    pub(super) fn act(&mut self, instance: &mut Instance, dice: &mut Dice) -> u64 {
        if !dice.chance(0.2) {
            return 0;
        }
        let (body, dt) = (instance.bodies[0], instance.run.dt);
        let Some(at) = somewhere(instance, dice) else { return 0 };
        let simulation = &mut instance.simulation;
        match dice.below(6) {
            0 if self.forceps.len() < 3 => {
                let jaws = Jaws { radius: 0.2, stiffness: Some(0.2), force_limit: Some(0.02), slip: Slip::Slide };
                if let Ok(forceps) = simulation.spawn_forceps("second hand", jaws, Pose::at(at)) {
                    let _ = simulation.close_forceps(forceps, body, &Grasp::Nearest { reach: 1.0 });
                    self.forceps.push(forceps);
                }
            }
            0 | 1 => {
                let Some(forceps) = self.forceps.pop() else { return 0 };
                let _ = simulation.open_forceps(forceps);
                let _ = simulation.despawn(forceps);
            }
            2 | 3 => {
                for &forceps in &self.forceps {
                    let Ok(tool) = simulation.forceps(forceps) else { continue };
                    let by = dice.point() * 0.3;
                    let pose = Pose::at(tool.motion.at(simulation.time()).position + by);
                    let _ = simulation.move_forceps(forceps, pose, dt);
                }
            }
            4 => _ = simulation.puncture(body, at, dice.direction(), dice.between(0.2, 0.6)),
            // Forceps of another time have other handles.
            _ => match self.kept.take() {
                Some(kept) => {
                    self.forceps.clear();
                    return u64::from(simulation.restore(&kept).is_ok());
                }
                None => self.kept = Some(simulation.snapshot()),
            },
        }
        0
    }
}

/// Some place of the tissue.
fn somewhere(instance: &Instance, dice: &mut Dice) -> Option<DVec3> {
    let vertices = instance.simulation.world().get::<&Vertices>(instance.bodies[0].entity()).ok()?;
    vertices.position.get(dice.below(vertices.len().max(1))).copied()
}
