//! What is seen: the capsule on its lens, the iris around it, forceps, light, and the circle to be torn along.

use crate::screen::Shown;
use bevy::prelude::*;
use bevy_rhexis::{Forceps, Tissue};
use std::f32::consts::TAU;

/// Radius of the lens under the capsule [mm].
const LENS: f32 = 10.0;
/// Radius of the circle to be torn along [mm].
const CIRCLE: f32 = 2.625;
/// One of the two jaws, by its side.
#[derive(Component)]
pub struct Jaw(f32);

pub fn spawn(
    mut commands: Commands,
    (capsule, hand): (Single<Entity, With<Tissue>>, Single<Entity, With<Forceps>>),
    mut meshes: ResMut<Assets<Mesh>>,
    mut materials: ResMut<Assets<StandardMaterial>>,
) {
    let membrane = StandardMaterial {
        base_color: Color::srgba(0.82, 0.9, 1.0, 0.62),
        alpha_mode: AlphaMode::Blend,
        perceptual_roughness: 0.35,
        reflectance: 0.6,
        double_sided: true,
        cull_mode: None,
        ..default()
    };
    commands.entity(*capsule).insert(MeshMaterial3d(materials.add(membrane)));
    // Light that comes back from the eye's ground glows through the lens.
    let lens = StandardMaterial {
        base_color: Color::srgb(0.55, 0.16, 0.06),
        emissive: LinearRgba::rgb(0.16, 0.03, 0.01),
        perceptual_roughness: 0.6,
        ..default()
    };
    let ball = Sphere::new(LENS - 0.06).mesh().uv(128, 64);
    commands.spawn((
        Mesh3d(meshes.add(ball)),
        MeshMaterial3d(materials.add(lens)),
        Transform::from_xyz(0.0, 0.0, -LENS),
    ));
    let iris = StandardMaterial { base_color: Color::srgb(0.16, 0.27, 0.34), perceptual_roughness: 0.9, ..default() };
    let ring = Annulus::new(4.55, 8.5).mesh().resolution(128);
    let at = Transform::from_xyz(0.0, 0.0, -0.95);
    commands.spawn((Mesh3d(meshes.add(ring)), MeshMaterial3d(materials.add(iris)), at));

    let steel = StandardMaterial {
        base_color: Color::srgb(0.75, 0.77, 0.8),
        perceptual_roughness: 0.3,
        metallic: 0.4,
        ..default()
    };
    let (steel, arm) =
        (materials.add(steel), meshes.add(ConicalFrustum { radius_top: 0.16, radius_bottom: 0.03, height: 6.0 }));
    commands.entity(*hand).insert(Visibility::default()).with_children(|hand| {
        for side in [-1.0, 1.0] {
            hand.spawn((Jaw(side), Mesh3d(arm.clone()), MeshMaterial3d(steel.clone()), Transform::default()));
        }
    });

    commands.insert_resource(ClearColor(Color::srgb(0.03, 0.035, 0.045)));
    commands.insert_resource(GlobalAmbientLight { brightness: 250.0, ..default() });
    for (place, illuminance) in [(Vec3::new(-6.0, 4.0, 14.0), 5_000.0), (Vec3::new(9.0, -3.0, 8.0), 2_500.0)] {
        let light = DirectionalLight { illuminance, ..default() };
        commands.spawn((light, Transform::from_translation(place).looking_at(Vec3::ZERO, Vec3::Y)));
    }
    commands.spawn((Camera3d::default(), Msaa::Sample4, Transform::default()));
}

/// Opens and closes the jaws that are seen, and draws the circle to be torn along.
pub fn circle(
    shown: Res<Shown>,
    forceps: Single<&Forceps>,
    mut jaws: Query<(&Jaw, &mut Transform)>,
    mut gizmos: Gizmos,
) {
    let spread = if forceps.is_closed { 0.012 } else { 0.06 };
    for (Jaw(side), mut transform) in &mut jaws {
        // The arm leans back from the view, and its thin end is at the tip.
        let lean = Quat::from_rotation_z(-0.5) * Quat::from_rotation_x(0.75);
        let turn = lean * Quat::from_rotation_z(side * spread);
        *transform = Transform::from_translation(turn * Vec3::Y * 3.0).with_rotation(turn);
    }
    if shown.has_circle {
        let height = (LENS * LENS - CIRCLE * CIRCLE).sqrt() - LENS + 0.02;
        let point = |i: u32| {
            let (sin, cos) = (TAU * i as f32 / 96.0).sin_cos();
            Vec3::new(CIRCLE * cos, CIRCLE * sin, height)
        };
        for i in (0..96).step_by(2) {
            gizmos.line(point(i), point(i + 1), Color::srgba(1.0, 1.0, 1.0, 0.5));
        }
    }
}
