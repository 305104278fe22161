//! Vertices that an entity's transform holds and moves.

use crate::message::{Cause, RhexisError};
use crate::tissue::TissueBody;
use crate::world::RhexisWorld;
use bevy::ecs::prelude::*;
use bevy::prelude::{GlobalTransform, Name, Transform};
use rhexis::components::{Holds, Pose};
use rhexis::glam::DVec3;
use rhexis::simulation::Simulation;
use rhexis::storage::{BodyId, VertexKey};
use std::sync::Arc;

/// Vertices of a tissue that move with an entity's transform, as if they were nailed to it. Pins that are refused are taken off.
#[derive(Component, Clone)]
#[require(Transform, PinsState)]
pub struct Pins {
    tissue: Entity,
    choice: Choice,
}

#[derive(Clone)]
enum Choice {
    Within(f64),
    Vertices(Vec<VertexKey>),
    Rest(Arc<dyn Fn(DVec3) -> bool + Send + Sync>),
}

impl Pins {
    /// The vertices within `radius` \[mm\] of the transform.
    pub fn within(tissue: Entity, radius: f64) -> Self {
        Self { tissue, choice: Choice::Within(radius) }
    }

    /// Vertices by their keys.
    pub fn vertices(tissue: Entity, keys: Vec<VertexKey>) -> Self {
        Self { tissue, choice: Choice::Vertices(keys) }
    }

    /// The vertices whose positions in the rest shape \[mm\] meet a condition.
    pub fn of_rest(tissue: Entity, condition: impl Fn(DVec3) -> bool + Send + Sync + 'static) -> Self {
        Self { tissue, choice: Choice::Rest(Arc::new(condition)) }
    }

    /// The entity of the tissue.
    pub fn tissue(&self) -> Entity {
        self.tissue
    }
}

/// What pins hold and feel.
#[derive(Component, Clone, Debug, Default)]
pub struct PinsState {
    held: Option<Held>,
    is_lost: bool,
    /// Number of vertices that were pinned; copies that tears make are held too.
    pub count: usize,
    /// Force of the pins on the tissue \[N\] in the last step, in the engine's space.
    pub force: DVec3,
}

#[derive(Clone, Debug)]
struct Held {
    body: BodyId,
    name: String,
    pose: Pose,
    target: Pose,
}

pub(crate) type Nails<'w> = (Entity, &'w Pins, &'w mut PinsState, &'w GlobalTransform, Option<&'w Name>);

/// Pins what is not pinned yet, and reads where transforms are.
pub(crate) fn aim(
    world: &mut RhexisWorld,
    pins: &mut Query<Nails>,
    tissues: &Query<(Entity, &TissueBody)>,
    commands: &mut Commands,
    errors: &mut MessageWriter<RhexisError>,
) {
    let space = *world.space();
    let simulation = world.quietly();
    for (entity, pins, mut state, transform, name) in
        pins.iter_mut().sort_by_key::<Entity, _>(|entity| entity.index_u32())
    {
        let Some(pose) = space.pose(transform) else {
            if !std::mem::replace(&mut state.is_lost, true) {
                errors.write(RhexisError::of(entity, name, Cause::BadTransform));
            }
            continue;
        };
        state.is_lost = false;
        let body = tissues.get(pins.tissue).ok().map(|(_, body)| body.body());
        let is_same = state.held.as_ref().is_none_or(|held| Some(held.body) == body);
        let outcome = match (body.filter(|_| is_same), &mut state.held) {
            (None, _) => Err(Cause::NoSuchTissue(pins.tissue)),
            (Some(_), Some(held)) => {
                held.target = pose;
                Ok(())
            }
            (Some(body), None) => hold(simulation, body, entity, pins, pose, name).map(|(held, count)| {
                (state.held, state.count) = (Some(held), count);
            }),
        };
        if let Err(cause) = outcome {
            errors.write(RhexisError::of(entity, name, cause));
            commands.entity(entity).try_remove::<Pins>();
        }
    }
}

fn hold(
    simulation: &mut Simulation,
    body: BodyId,
    entity: Entity,
    pins: &Pins,
    pose: Pose,
    name: Option<&Name>,
) -> Result<(Held, usize), Cause> {
    let view = simulation.view(body)?;
    let (keys, radius): (Vec<VertexKey>, _) = match &pins.choice {
        Choice::Within(radius) => {
            let all = view.vertex_keys.iter().zip(view.positions);
            let near = all.filter(|(_, place)| place.distance(pose.position) <= *radius);
            (near.map(|(key, _)| *key).collect(), Some(*radius))
        }
        Choice::Vertices(keys) => (keys.clone(), None),
        Choice::Rest(condition) => {
            let all = view.vertex_keys.iter().zip(view.rest_positions);
            (all.filter(|(_, place)| condition(**place)).map(|(key, _)| *key).collect(), None)
        }
    };
    if keys.is_empty() {
        return Err(Cause::NothingToPin(radius));
    }
    let name = free_name(simulation, body, name.map_or("pins", |name| name.as_str()), entity);
    simulation.pin(body, &name, &keys)?;
    Ok((Held { body, name, pose, target: pose }, keys.len()))
}

/// A name that no hold of the body has.
fn free_name(simulation: &Simulation, body: BodyId, name: &str, entity: Entity) -> String {
    let holds = simulation.world().get::<&Holds>(body.entity());
    let is_taken = holds.is_ok_and(|holds| {
        holds.groups.iter().any(|hold| hold.name == name && !(hold.is_pin() && hold.members.rows().is_empty()))
    });
    if is_taken { format!("{name} {entity}") } else { name.to_owned() }
}

/// Moves pins by their part of the way that is left in a frame, of which so many steps are left.
pub(crate) fn drive(
    simulation: &mut Simulation,
    pins: &mut Query<Nails>,
    left: u32,
    commands: &mut Commands,
    errors: &mut MessageWriter<RhexisError>,
) {
    for (entity, _, mut state, _, name) in pins.iter_mut().sort_by_key::<Entity, _>(|entity| entity.index_u32()) {
        let Some(held) = state.held.as_mut().filter(|held| held.pose != held.target) else { continue };
        let (before, next) = (held.pose, held.pose.towards(&held.target, 1.0 / f64::from(left.max(1))));
        let moved = simulation.move_pins(held.body, &held.name, |pin| next.carry(before.place(pin.place)));
        held.pose = next;
        if let Err(error) = moved {
            errors.write(RhexisError::of(entity, name, error));
            commands.entity(entity).try_remove::<Pins>();
        }
    }
}

/// Reads what the pins feel.
pub(crate) fn feel(simulation: &Simulation, pins: &mut Query<Nails>) {
    for (_, _, mut state, ..) in pins.iter_mut() {
        let Some(held) = &state.held else { continue };
        let forces = simulation.reactions(held.body).unwrap_or_default();
        state.force = forces.into_iter().find(|(name, _)| *name == held.name).map_or(DVec3::ZERO, |(_, force)| force);
    }
}

pub(crate) fn on_removed(
    removed: On<Remove, Pins>,
    mut states: Query<&mut PinsState>,
    world: Option<ResMut<RhexisWorld>>,
) {
    if let (Ok(mut state), Some(mut world)) = (states.get_mut(removed.entity), world)
        && let Some(held) = std::mem::take(&mut *state).held
    {
        // A body that is gone holds nothing any more.
        let _ = world.quietly().unpin_all(held.body, &held.name);
    }
}
