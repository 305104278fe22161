//! Tissues: entities that show bodies of the engine.

use crate::mesh::{self, MeshUpdates};
use crate::message::{RhexisError, TissueGone};
use crate::world::RhexisWorld;
use bevy::asset::{AssetMut, Assets};
use bevy::ecs::prelude::*;
use bevy::mesh::{Mesh, Mesh3d};
use bevy::prelude::{Name, Transform};
use rhexis::components::Changes;
use rhexis::membrane::Membrane;
use rhexis::simulation::{Simulation, SimulationError};
use rhexis::storage::BodyId;

/// A membrane of the engine, shown by a [`Mesh3d`] that the plugin makes and keeps in step. Its transform is the plugin's
/// [`Space`](crate::Space).
#[derive(Component)]
#[require(Transform, MeshUpdates)]
pub struct Tissue {
    source: Source,
    has_normals: bool,
}

enum Source {
    Membrane(Box<Membrane>),
    Body(BodyId),
    Taken,
}

impl Tissue {
    /// A membrane that the plugin spawns in the engine.
    pub fn new(membrane: Membrane) -> Self {
        Self { source: Source::Membrane(Box::new(membrane)), has_normals: true }
    }

    /// A body that is in the engine already: of a scene, a snapshot or a call.
    pub fn of_body(body: BodyId) -> Self {
        Self { source: Source::Body(body), has_normals: true }
    }

    /// The same without normals in its mesh, for materials that need none.
    pub fn without_normals(self) -> Self {
        Self { has_normals: false, ..self }
    }

    /// Whether normals are computed for its mesh.
    pub fn has_normals(&self) -> bool {
        self.has_normals
    }
}

/// The body of a [`Tissue`], once the engine has taken it. Without it the tissue was refused.
#[derive(Component, Clone, Copy, Debug, PartialEq, Eq)]
pub struct TissueBody(BodyId);

impl TissueBody {
    /// The body, for calls of the engine.
    pub fn body(&self) -> BodyId {
        self.0
    }
}

type New<'w> = (Entity, &'w mut Tissue, &'w mut Transform, Option<&'w Name>);

pub(crate) fn spawn(
    mut commands: Commands,
    mut world: ResMut<RhexisWorld>,
    mut tissues: Query<New, (Without<TissueBody>, Added<Tissue>)>,
    mut meshes: Option<ResMut<Assets<Mesh>>>,
    mut errors: MessageWriter<RhexisError>,
) {
    for (entity, mut tissue, mut transform, name) in &mut tissues {
        let made = match std::mem::replace(&mut tissue.source, Source::Taken) {
            Source::Membrane(membrane) => {
                world.quietly().spawn(membrane.with(Changes::default())).map_err(rhexis::Error::from)
            }
            Source::Body(body) => adopt(world.quietly(), body).map_err(rhexis::Error::from),
            Source::Taken => continue,
        };
        let body = match made {
            Ok(body) => body,
            Err(error) => {
                errors.write(RhexisError::of(entity, name, error));
                continue;
            }
        };
        *transform = world.space().transform();
        commands.entity(entity).insert(TissueBody(body));
        if let Some(meshes) = &mut meshes {
            commands.entity(entity).insert(Mesh3d(meshes.add(mesh::empty())));
        }
    }
}

/// Has the changes of a body's mesh noted.
fn adopt(simulation: &mut Simulation, body: BodyId) -> Result<BodyId, SimulationError> {
    // Whoever asked for changes before has had them: a new list says that all is new.
    let is_there = simulation.view(body).is_ok();
    let noted = is_there && simulation.world_mut().insert_one(body.entity(), Changes::default()).is_ok();
    if noted { Ok(body) } else { Err(SimulationError::NoSuchBody) }
}

/// Despawns the entities of bodies that are not in the engine any more.
pub(crate) fn see_gone(
    mut commands: Commands,
    world: Res<RhexisWorld>,
    tissues: Query<(Entity, &TissueBody)>,
    mut gone: MessageWriter<TissueGone>,
) {
    for (tissue, body) in &tissues {
        if !world.simulation().world().contains(body.0.entity()) {
            gone.write(TissueGone { tissue, body: body.0 });
            commands.entity(tissue).try_despawn();
        }
    }
}

pub(crate) fn on_removed_body(
    removed: On<Remove, TissueBody>,
    bodies: Query<&TissueBody>,
    world: Option<ResMut<RhexisWorld>>,
) {
    if let (Ok(body), Some(mut world)) = (bodies.get(removed.entity), world) {
        // One that the host has taken out of the engine is gone already.
        let _ = world.quietly().despawn(body.0);
    }
}

pub(crate) fn on_removed_tissue(removed: On<Remove, Tissue>, mut commands: Commands) {
    if let Ok(mut entity) = commands.get_entity(removed.entity) {
        entity.try_remove::<(TissueBody, Mesh3d, MeshUpdates)>();
    }
}

type Shown<'w> = (Entity, &'w Tissue, &'w TissueBody, &'w Mesh3d, &'w mut MeshUpdates, Option<&'w Name>);

pub(crate) fn update_meshes(
    mut world: ResMut<RhexisWorld>,
    mut tissues: Query<Shown>,
    meshes: Option<ResMut<Assets<Mesh>>>,
    mut errors: MessageWriter<RhexisError>,
) {
    let Some(mut meshes) = meshes else { return };
    for (entity, tissue, body, handle, mut updates, name) in &mut tissues {
        let Some(now) = updates.due(&mut world, body.0, handle.0.id()) else { continue };
        // The asset of a handle that the host has put in place may not be there yet.
        let Some(mesh) = meshes.get_mut(&handle.0).map(AssetMut::into_inner) else { continue };
        let was_lost = updates.is_lost();
        if updates.write(&mut world, body.0, mesh, tissue.has_normals, now).is_err() && !was_lost {
            errors.write(RhexisError::of(entity, name, crate::message::Cause::MeshTaken));
        }
    }
}
