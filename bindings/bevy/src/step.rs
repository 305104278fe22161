//! The steps that are due in a frame, with the tools' motions in them.

use crate::message::{RhexisError, TissueEvent};
use crate::obstacles::{self, ShownObstacle, ShownObstacles};
use crate::tissue::TissueBody;
use crate::world::RhexisWorld;
use crate::{forceps, pins};
use bevy::ecs::prelude::*;
use bevy::time::Time;

pub(crate) fn advance(
    time: Res<Time>,
    mut world: ResMut<RhexisWorld>,
    tissues: Query<(Entity, &TissueBody)>,
    (mut tools, mut pins): (Query<forceps::Tools>, Query<pins::Nails>),
    (mut shown, lists): (Query<&mut ShownObstacle>, Query<&ShownObstacles>),
    mut commands: Commands,
    mut errors: MessageWriter<RhexisError>,
) {
    let world = &mut *world;
    // In milliseconds, of whatever time a frame has here: virtual time can be paused, and goes slower or faster.
    let steps = match world.steps_after(time.delta_secs_f64() * 1e3) {
        Ok(steps) => steps,
        Err(error) => {
            errors.write(RhexisError::of_world(error));
            return;
        }
    };
    if steps == 0 {
        return;
    }
    let within = f64::from(steps) * world.clock().dt();
    forceps::drive(world, &mut tools, &tissues, within, &mut errors);
    pins::aim(world, &mut pins, &tissues, &mut commands, &mut errors);
    for done in 0..steps {
        pins::drive(world.quietly(), &mut pins, steps - done, &mut commands, &mut errors);
        if done + 1 == steps {
            obstacles::note_start(world.simulation(), &mut shown, &lists);
        }
        if let Err(error) = world.step() {
            errors.write(RhexisError::of_world(error));
            break;
        }
    }
    forceps::feel(world.simulation(), &mut tools);
    pins::feel(world.simulation(), &mut pins);
}

/// Hands on what has happened, in steps and in calls of the host.
pub(crate) fn tell(
    mut world: ResMut<RhexisWorld>,
    tissues: Query<(Entity, &TissueBody)>,
    mut events: MessageWriter<TissueEvent>,
) {
    for event in world.quietly().drain_events() {
        let tissue = tissues.iter().find(|(_, body)| body.body() == event.body).map(|(tissue, _)| tissue);
        events.write(TissueEvent { tissue, event });
    }
}
