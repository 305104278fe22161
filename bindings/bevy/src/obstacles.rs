//! Obstacles of the engine, shown by meshes that follow them.

use crate::message::{Cause, RhexisError};
use crate::space::Space;
use crate::world::RhexisWorld;
use bevy::asset::{Assets, Handle, RenderAssetUsages};
use bevy::ecs::prelude::*;
use bevy::math::primitives::{Capsule3d, Cuboid, Cylinder, Plane3d, Sphere};
use bevy::math::{Vec2, Vec3};
use bevy::mesh::{Mesh, Mesh3d, MeshBuilder, Meshable, PrimitiveTopology};
use bevy::prelude::{GlobalTransform, Name, Transform};
use rhexis::components::{Hull, Obstacle, ObstacleMotion, Shape};
use rhexis::glam::{DMat3, DQuat, DVec3};
use rhexis::simulation::Simulation;
use rhexis::storage::ObstacleId;
use std::sync::Arc;

/// Side \[mm\] of the square that shows a plane, unless another is asked for.
const PLANE_SIDE: f64 = 100.0;
/// Segments around an axis.
const AROUND: u32 = 48;

/// Request to show every obstacle of the engine, each by an entity of its own with a mesh: a [`ShownObstacle`].
///
/// ```
/// use bevy::prelude::*;
/// use bevy_rhexis::ShownObstacles;
/// # #[derive(Component, Clone)]
/// # struct Steel;
/// // With rendering, the bundle is a `MeshMaterial3d`.
/// fn spawn(mut commands: Commands) {
///     commands.spawn(ShownObstacles::with(Steel));
/// }
/// ```
#[derive(Component, Clone)]
pub struct ShownObstacles {
    dress: Arc<dyn Fn(&mut EntityCommands) + Send + Sync>,
    plane_side: f64,
}

impl ShownObstacles {
    /// Obstacles whose entities get a copy of a bundle, such as a material.
    pub fn with(bundle: impl Bundle + Clone) -> Self {
        let dress = move |entity: &mut EntityCommands| _ = entity.insert(bundle.clone());
        Self { dress: Arc::new(dress), plane_side: PLANE_SIDE }
    }

    /// Obstacles whose planes are shown as squares of this side \[mm\] about their points; 100 mm by default.
    pub fn plane_side(self, plane_side: f64) -> Self {
        Self { plane_side, ..self }
    }
}

/// Entity that shows an obstacle; it goes with the obstacle, and with the [`ShownObstacles`] that asked for it.
#[derive(Component, Clone, Debug)]
#[require(Transform)]
pub struct ShownObstacle {
    obstacle: ObstacleId,
    list: Entity,
    form: Form,
    /// Place at the start of the last step, and at its end.
    start: Placed,
    end: Placed,
    /// Whether a step was made since it was last shown.
    is_stepped: bool,
}

impl ShownObstacle {
    /// Obstacle in the engine, for calls of the engine.
    pub fn obstacle(&self) -> ObstacleId {
        self.obstacle
    }

    /// Entity of the [`ShownObstacles`] that asked for it.
    pub fn list(&self) -> Entity {
        self.list
    }
}

/// Mesh of a shape, at unit size.
#[derive(Clone, Debug)]
enum Form {
    Square,
    Ball,
    /// A capsule of radius 1, by the length of its segment.
    Capsule(f64),
    Block,
    Cylinder,
    Hull(Arc<Hull>),
}

impl PartialEq for Form {
    fn eq(&self, other: &Self) -> bool {
        match (self, other) {
            (Self::Capsule(a), Self::Capsule(b)) => a == b,
            (Self::Hull(a), Self::Hull(b)) => Arc::ptr_eq(a, b),
            _ => std::mem::discriminant(self) == std::mem::discriminant(other),
        }
    }
}

/// Place, rotation and sizes of a form, in the engine's space \[mm\].
#[derive(Clone, Copy, Debug, PartialEq)]
struct Placed {
    place: DVec3,
    rotation: DQuat,
    sizes: DVec3,
}

impl Placed {
    fn towards(&self, other: &Self, part: f64) -> Self {
        Self {
            place: self.place.lerp(other.place, part),
            rotation: self.rotation.slerp(other.rotation, part),
            sizes: self.sizes.lerp(other.sizes, part),
        }
    }

    fn transform(&self, space: &Space) -> Transform {
        space.transform()
            * Transform {
                translation: Vec3::from_array(self.place.as_vec3().to_array()),
                rotation: bevy::math::Quat::from_array(self.rotation.as_quat().to_array()),
                scale: Vec3::from_array(self.sizes.as_vec3().to_array()),
            }
    }
}

fn placed(shape: &Shape, plane_side: f64) -> (Form, Placed) {
    let turned = |place: DVec3, axes: DMat3, sizes: DVec3| Placed { place, rotation: DQuat::from_mat3(&axes), sizes };
    // Bevy's primitives stand along y.
    let along = |[a, b]: [DVec3; 2], sizes: DVec3| {
        let axis = (b - a).try_normalize().unwrap_or(DVec3::Y);
        Placed { place: a.midpoint(b), rotation: DQuat::from_rotation_arc(DVec3::Y, axis), sizes }
    };
    match *shape {
        Shape::Plane { point, normal } => {
            let rotation = DQuat::from_rotation_arc(DVec3::Y, normal);
            (Form::Square, Placed { place: point, rotation, sizes: DVec3::splat(plane_side) })
        }
        Shape::Sphere { centre, radius } => (Form::Ball, turned(centre, DMat3::IDENTITY, DVec3::splat(radius))),
        Shape::Ellipsoid { centre, half_axes, axes } => (Form::Ball, turned(centre, axes, half_axes)),
        Shape::Capsule { ends, radius } => {
            (Form::Capsule(ends[0].distance(ends[1]) / radius), along(ends, DVec3::splat(radius)))
        }
        Shape::Box { centre, half, axes } => (Form::Block, turned(centre, axes, 2.0 * half)),
        Shape::Cylinder { ends, radius } => {
            (Form::Cylinder, along(ends, DVec3::new(radius, ends[0].distance(ends[1]), radius)))
        }
        Shape::Mesh { ref hull, centre, axes } => (Form::Hull(hull.clone()), turned(centre, axes, DVec3::ONE)),
    }
}

impl Form {
    fn mesh(&self) -> Mesh {
        match self {
            Self::Square => Plane3d::new(Vec3::Y, Vec2::splat(0.5)).mesh().build(),
            Self::Ball => Sphere::new(1.0).mesh().uv(AROUND, AROUND / 2),
            Self::Capsule(length) => Capsule3d::new(1.0, *length as f32).mesh().longitudes(AROUND).build(),
            Self::Block => Cuboid::new(1.0, 1.0, 1.0).mesh().build(),
            Self::Cylinder => Cylinder::new(1.0, 1.0).mesh().resolution(AROUND).build(),
            Self::Hull(hull) => of_hull(hull),
        }
    }
}

/// A mesh with flat faces.
fn of_hull(hull: &Hull) -> Mesh {
    let (places, triangles) = hull.surface();
    let corners = triangles.iter().flatten().filter_map(|&row| places.get(row as usize));
    let corners: Vec<[f32; 3]> = corners.map(|place| place.as_vec3().to_array()).collect();
    let mesh = Mesh::new(PrimitiveTopology::TriangleList, RenderAssetUsages::default());
    mesh.with_inserted_attribute(Mesh::ATTRIBUTE_POSITION, corners).with_computed_flat_normals()
}

fn shape_of(simulation: &Simulation, obstacle: ObstacleId) -> Option<Shape> {
    simulation.world().get::<&Obstacle>(obstacle.entity()).ok().map(|found| found.shape.clone())
}

/// Shape at the start of the step under way, where the obstacle moves in it.
fn start_of(simulation: &Simulation, obstacle: ObstacleId) -> Option<Shape> {
    simulation.world().get::<&ObstacleMotion>(obstacle.entity()).ok().map(|motion| motion.from.clone())
}

pub(crate) fn refuse(
    mut commands: Commands,
    lists: Query<(Entity, &ShownObstacles, Option<&Name>), Added<ShownObstacles>>,
    mut errors: MessageWriter<RhexisError>,
) {
    for (entity, list, name) in &lists {
        if !(list.plane_side > 0.0 && list.plane_side.is_finite()) {
            errors.write(RhexisError::of(entity, name, Cause::BadPlaneSide(list.plane_side)));
            commands.entity(entity).try_remove::<ShownObstacles>();
        }
    }
}

/// Adds an entity for each obstacle that a list does not show yet.
pub(crate) fn spawn(
    mut commands: Commands,
    world: Res<RhexisWorld>,
    lists: Query<(Entity, &ShownObstacles)>,
    shown: Query<(&ShownObstacle, Option<&Mesh3d>)>,
    mut meshes: Option<ResMut<Assets<Mesh>>>,
) {
    for (list, wanted) in &lists {
        let there: Vec<ObstacleId> =
            shown.iter().filter(|(one, _)| one.list == list).map(|(one, _)| one.obstacle).collect();
        let all = world.simulation().obstacles();
        if all.len() == there.len() && all.iter().all(|obstacle| there.contains(obstacle)) {
            continue;
        }
        // Obstacles of one form share a mesh.
        let mut made: Vec<(Form, Handle<Mesh>)> = Vec::new();
        for obstacle in all.into_iter().filter(|obstacle| !there.contains(obstacle)) {
            let Some(shape) = shape_of(world.simulation(), obstacle) else { continue };
            let (form, end) = placed(&shape, wanted.plane_side);
            let mut entity = commands.spawn(ShownObstacle {
                obstacle,
                list,
                form: form.clone(),
                start: end,
                end,
                is_stepped: false,
            });
            if let Some(meshes) = &mut meshes {
                let old = shown.iter().find(|(one, _)| one.form == form).and_then(|(_, mesh)| Some(mesh?.0.clone()));
                let new = made.iter().find(|(other, _)| *other == form).map(|(_, mesh)| mesh.clone());
                let mesh = old.or(new).unwrap_or_else(|| meshes.add(form.mesh()));
                made.push((form, mesh.clone()));
                entity.insert(Mesh3d(mesh));
            }
            (wanted.dress)(&mut entity);
        }
    }
}

/// Notes where obstacles are before a step.
pub(crate) fn note_start(
    simulation: &Simulation,
    shown: &mut Query<&mut ShownObstacle>,
    lists: &Query<&ShownObstacles>,
) {
    for mut one in shown.iter_mut() {
        let (Ok(list), obstacle) = (lists.get(one.list), one.obstacle) else { continue };
        let start = start_of(simulation, obstacle).or_else(|| shape_of(simulation, obstacle));
        if let Some(start) = start {
            (one.start, one.is_stepped) = (placed(&start, list.plane_side).1, true);
        }
    }
}

type Shown<'w> = (Entity, &'w mut ShownObstacle, &'w mut Transform, &'w mut GlobalTransform, Option<&'w mut Mesh3d>);

/// Puts entities where their obstacles are, between the last two steps.
pub(crate) fn follow(
    mut commands: Commands,
    world: Res<RhexisWorld>,
    lists: Query<&ShownObstacles>,
    mut shown: Query<Shown>,
    mut meshes: Option<ResMut<Assets<Mesh>>>,
) {
    let (simulation, part) = (world.simulation(), world.behind() / world.clock().dt());
    for (entity, mut one, mut transform, mut global, mesh) in &mut shown {
        let (Ok(list), Some(shape)) = (lists.get(one.list), shape_of(simulation, one.obstacle)) else {
            commands.entity(entity).try_despawn();
            continue;
        };
        let (form, now) = placed(&shape, list.plane_side);
        if one.is_stepped {
            (one.end, one.is_stepped) = (now, false);
        } else if now != one.end {
            // One that a call has sent on its way waits for the step; all else was put where it is.
            let start = start_of(simulation, one.obstacle).map(|start| placed(&start, list.plane_side).1);
            if start == Some(one.end) {
                continue;
            }
            (one.start, one.end) = (now, now);
        }
        if form != one.form {
            if let (Some(mut mesh), Some(meshes)) = (mesh, &mut meshes) {
                mesh.0 = meshes.add(form.mesh());
            }
            (one.form, one.start) = (form, one.end);
        }
        // Transforms of this frame are propagated already.
        transform.set_if_neq(one.end.towards(&one.start, part).transform(world.space()));
        global.set_if_neq(GlobalTransform::from(*transform));
    }
}

pub(crate) fn on_removed_list(
    removed: On<Remove, ShownObstacles>,
    shown: Query<(Entity, &ShownObstacle)>,
    mut commands: Commands,
) {
    for (entity, _) in shown.iter().filter(|(_, one)| one.list == removed.entity) {
        commands.entity(entity).try_despawn();
    }
}
