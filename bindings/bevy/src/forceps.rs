//! Forceps that an entity's transform moves.

use crate::message::{Cause, RhexisError};
use crate::tissue::TissueBody;
use crate::world::RhexisWorld;
use bevy::ecs::prelude::*;
use bevy::prelude::{GlobalTransform, Name, Transform};
use rhexis::components::{Grasp, Jaws, Pose};
use rhexis::glam::DVec3;
use rhexis::simulation::{Simulation, ToolError};
use rhexis::storage::ForcepsId;

/// Forceps at an entity's transform. What they hold follows the transform evenly over the steps of a frame.
#[derive(Component, Clone, Debug)]
#[require(Transform, ForcepsState)]
pub struct Forceps {
    /// How they hold; read when they come into the world.
    pub jaws: Jaws,
    /// How far from the transform tissue is taken \[mm\].
    pub reach: f64,
    /// Whether they are to be closed. The plugin sets it back where there is nothing to take, and where they slip.
    pub is_closed: bool,
}

impl Forceps {
    /// Open forceps.
    pub fn new(jaws: Jaws, reach: f64) -> Self {
        Self { jaws, reach, is_closed: false }
    }
}

/// What forceps hold and feel.
#[derive(Component, Clone, Debug, Default)]
pub struct ForcepsState {
    tool: Option<ForcepsId>,
    pose: Option<Pose>,
    is_lost: bool,
    is_refused: bool,
    /// The tissue of which they hold a part.
    pub tissue: Option<Entity>,
    /// Force of the jaws on the tissue \[N\] in the last step, in the engine's space; the hand feels the opposite.
    pub force: DVec3,
    /// Torque of the jaws on the tissue about their position \[N·mm\] in the last step, in the engine's space.
    pub torque: DVec3,
}

impl ForcepsState {
    /// The forceps in the engine, for its calls; `None` before they are there.
    pub fn tool(&self) -> Option<ForcepsId> {
        self.tool
    }

    /// Where the jaws were told to go \[mm\], in the engine's space.
    pub fn pose(&self) -> Option<Pose> {
        self.pose
    }
}

pub(crate) type Tools<'w> = (Entity, Mut<'w, Forceps>, &'w mut ForcepsState, &'w GlobalTransform, Option<&'w Name>);

/// Brings forceps to their transforms within a time \[ms\], closes and opens them.
pub(crate) fn drive(
    world: &mut RhexisWorld,
    tools: &mut Query<Tools>,
    tissues: &Query<(Entity, &TissueBody)>,
    within: f64,
    errors: &mut MessageWriter<RhexisError>,
) {
    let space = *world.space();
    let simulation = world.quietly();
    for (entity, mut forceps, mut state, transform, name) in
        tools.iter_mut().sort_by_key::<Entity, _>(|entity| entity.index_u32())
    {
        let Some(pose) = space.pose(transform) else {
            if !std::mem::replace(&mut state.is_lost, true) {
                errors.write(RhexisError::of(entity, name, Cause::BadTransform));
            }
            continue;
        };
        state.is_lost = false;
        if state.is_refused && !forceps.is_changed() {
            continue;
        }
        let done = follow(simulation, &mut state, &forceps, pose, within, name)
            .and_then(|()| close(simulation, &mut state, &forceps, tissues, name));
        state.is_refused = done.is_err() && state.tool.is_none();
        if let Err(error) = done {
            forceps.is_closed = false;
            errors.write(RhexisError::of(entity, name, error));
        }
    }
}

fn follow(
    simulation: &mut Simulation,
    state: &mut ForcepsState,
    forceps: &Forceps,
    pose: Pose,
    within: f64,
    name: Option<&Name>,
) -> Result<(), ToolError> {
    // Forceps that the host has taken out of the engine are made anew.
    let tool = match state.tool.filter(|&tool| simulation.forceps(tool).is_ok()) {
        Some(tool) => tool,
        None => {
            (state.tool, state.tissue) = (None, None);
            let tool = simulation.spawn_forceps(called(name), forceps.jaws, pose)?;
            (state.tool, state.pose) = (Some(tool), Some(pose));
            tool
        }
    };
    if state.pose != Some(pose) {
        // Open jaws are at once where they are to close.
        let within = if state.tissue.is_some() { within } else { 0.0 };
        simulation.move_forceps(tool, pose, within)?;
        state.pose = Some(pose);
    }
    Ok(())
}

fn close(
    simulation: &mut Simulation,
    state: &mut ForcepsState,
    forceps: &Forceps,
    tissues: &Query<(Entity, &TissueBody)>,
    name: Option<&Name>,
) -> Result<(), ToolError> {
    let (Some(tool), Some(pose)) = (state.tool, state.pose) else { return Ok(()) };
    match (forceps.is_closed, state.tissue) {
        (true, None) => {
            let distance = |(tissue, body): (Entity, &TissueBody)| {
                let hit = simulation.nearest(body.body(), pose.position, forceps.reach)?;
                Some((hit.distance, tissue, body.body()))
            };
            let near = tissues.iter().filter_map(distance);
            let nearest = near.min_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
            let name = || called(name).to_owned();
            let (_, tissue, body) = nearest.ok_or_else(|| ToolError::NothingThere { name: name() })?;
            simulation.close_forceps(tool, body, &Grasp::Nearest { reach: forceps.reach })?;
            state.tissue = Some(tissue);
        }
        (false, Some(_)) => {
            simulation.open_forceps(tool)?;
            state.tissue = None;
            (state.force, state.torque) = (DVec3::ZERO, DVec3::ZERO);
        }
        _ => {}
    }
    Ok(())
}

/// Reads what the forceps feel, and whether they still hold something.
pub(crate) fn feel(simulation: &Simulation, tools: &mut Query<Tools>) {
    for (_, mut forceps, mut state, ..) in tools.iter_mut() {
        let Some(tool) = state.tool.and_then(|tool| simulation.forceps(tool).ok()) else { continue };
        (state.force, state.torque) = (tool.force, tool.torque);
        let holds = tool.body.is_some_and(|body| simulation.world().contains(body.entity()));
        if state.tissue.is_some() && !holds {
            state.tissue = None;
            forceps.is_closed = false;
        }
    }
}

pub(crate) fn on_removed(
    removed: On<Remove, Forceps>,
    mut states: Query<&mut ForcepsState>,
    world: Option<ResMut<RhexisWorld>>,
) {
    if let (Ok(mut state), Some(mut world)) = (states.get_mut(removed.entity), world)
        && let Some(tool) = std::mem::take(&mut *state).tool
    {
        // Forceps that the host has taken out of the engine are gone already.
        let _ = world.quietly().despawn(tool);
    }
}

fn called(name: Option<&Name>) -> &str {
    name.map_or("forceps", |name| name.as_str())
}
