//! What cannot be seen of a tissue, as lines: fibres, stress, tear tips, forces.

use crate::forceps::ForcepsState;
use crate::pins::PinsState;
use crate::space::Space;
use crate::tissue::TissueBody;
use crate::world::RhexisWorld;
use bevy::color::Color;
use bevy::ecs::prelude::*;
use bevy::gizmos::config::GizmoConfigGroup;
use bevy::gizmos::gizmos::Gizmos;
use bevy::prelude::GlobalTransform;
use bevy::reflect::Reflect;
use rhexis::components::Obstacle;
use rhexis::glam::DVec3;
use rhexis::simulation::{BodyView, DebugLine, DebugLines, Simulation, SimulationError};
use rhexis::storage::{BodyId, ObstacleId};

/// The group of the plugin's lines, for their width and depth.
#[derive(Default, Reflect, GizmoConfigGroup)]
pub struct RhexisGizmoGroup;

/// Which lines are drawn of all tissues; none by default. They are of the last step, not between two.
#[derive(Resource, Clone, Copy, Debug, Default, PartialEq)]
pub struct RhexisGizmos {
    /// Whether a line along the fibre through every triangle is drawn.
    pub fibres: bool,
    /// Stress \[MPa\] at which a cross of principal stresses is as long as its triangle.
    pub stress: Option<f64>,
    /// Whether the last and the preferred direction are drawn at every tear tip.
    pub tips: bool,
    /// Length \[mm\] of a material force of 1 N/mm at a tear tip.
    pub material_force: Option<f64>,
    /// Length \[mm\] of the arrow for 1 N of an obstacle, forceps or pins on tissue, from their middle.
    pub forces: Option<f64>,
    /// Whether lines from gripped and held vertices to where they are drawn are shown.
    pub grips: bool,
    /// Whether lines from vertices inside an obstacle to its surface are drawn.
    pub contacts: bool,
}

/// Colour of the material force: red, green, blue, from 0 to 1.
const MATERIAL_FORCE: [f32; 3] = [0.9, 0.1, 0.2];

/// Colour of forces of obstacles and tools: red, green, blue, from 0 to 1.
const FORCE: [f32; 3] = [0.0, 0.45, 0.7];

impl RhexisGizmos {
    fn of_engine(&self) -> Option<DebugLines> {
        let Self { fibres, stress, tips, grips, contacts, .. } = *self;
        let any = fibres || stress.is_some() || tips || grips || contacts;
        any.then_some(DebugLines { frames: false, fibres, stress, tips, contacts, grips })
    }
}

pub(crate) fn draw(
    wanted: Res<RhexisGizmos>,
    mut world: ResMut<RhexisWorld>,
    tissues: Query<&TissueBody>,
    (tools, pins): (Query<&ForcepsState>, Query<(&PinsState, &GlobalTransform)>),
    mut gizmos: Gizmos<RhexisGizmoGroup>,
) {
    let (space, engine) = (*world.space(), wanted.of_engine());
    let mut lines: Vec<DebugLine> = Vec::new();
    for body in &tissues {
        if let Some(which) = &engine {
            // A body that is gone is seen elsewhere.
            let _ = world.quietly().debug_lines(body.body(), which, &mut lines);
        }
        let forces = wanted.material_force.map(|length| material_forces(world.quietly(), body.body(), length));
        for arrow in forces.and_then(Result::ok).into_iter().flatten() {
            draw_arrow(&mut gizmos, &space, arrow, MATERIAL_FORCE);
        }
    }
    if let Some(length) = wanted.forces {
        let of_tools = tools.iter().filter_map(|state| Some((state.pose()?.position, state.force)));
        let of_pins = pins.iter().map(|(state, place)| (space.to_engine(place.translation()), state.force));
        let forces = obstacle_forces(world.simulation()).into_iter().chain(of_tools).chain(of_pins);
        for (place, force) in forces.filter(|(_, force)| *force != DVec3::ZERO) {
            draw_arrow(&mut gizmos, &space, [place, place + force * length], FORCE);
        }
    }
    for line in lines {
        let [r, g, b] = line.kind.colour();
        gizmos.line(space.to_world(line.from), space.to_world(line.to), Color::srgb(r, g, b));
    }
}

fn draw_arrow(gizmos: &mut Gizmos<RhexisGizmoGroup>, space: &Space, [from, to]: [DVec3; 2], [r, g, b]: [f32; 3]) {
    gizmos.arrow(space.to_world(from), space.to_world(to), Color::srgb(r, g, b));
}

/// Middle of each obstacle \[mm\] and its force on all bodies \[N\] in the last step.
fn obstacle_forces(simulation: &Simulation) -> Vec<(DVec3, DVec3)> {
    let forces = simulation.bodies().into_iter().filter_map(|body| simulation.contact_forces(body).ok());
    let forces: Vec<_> = forces.flatten().collect();
    let total = |obstacle| forces.iter().filter(|(other, _)| *other == obstacle).map(|(_, force)| *force).sum();
    let middle = |obstacle: ObstacleId| {
        let found = simulation.world().get::<&Obstacle>(obstacle.entity()).ok()?;
        Some((found.shape.anchor(), total(obstacle)))
    };
    simulation.obstacles().into_iter().filter_map(middle).collect()
}

/// The material forces at a body's tips, carried with the tissue: from the tip, so many mm long for 1 N/mm.
///
/// # Errors
/// Where there is no such body.
pub fn material_forces(
    simulation: &mut Simulation,
    body: BodyId,
    length: f64,
) -> Result<Vec<[DVec3; 2]>, SimulationError> {
    let forces = simulation.material_forces(body)?;
    let tips = simulation.tips(body)?;
    let view = simulation.view(body)?;
    let arrow = |(force, tip): (&rhexis::simulation::TipForce, &rhexis::simulation::Tip)| {
        let row = view.vertex_keys.iter().position(|key| *key == tip.vertex)? as u32;
        let corners = view.triangles.iter().find(|corners| corners.contains(&row))?;
        let way = carried(&view, *corners, force.force)?;
        Some([tip.position, tip.position + way * (force.force.length() * length)])
    };
    let pairs = forces.iter().filter_map(|force| Some((force, tips.iter().find(|tip| tip.key == force.tip)?)));
    Ok(pairs.filter_map(arrow).collect())
}

/// Unit direction into which a triangle's deformation carries one of the rest shape.
fn carried(view: &BodyView, corners: [u32; 3], way: DVec3) -> Option<DVec3> {
    let edges = |of: &[DVec3]| {
        let [a, b, c] = corners.map(|row| of.get(row as usize).copied());
        Some([b? - a?, c? - a?])
    };
    let ([p, q], [u, v]) = (edges(view.rest_positions)?, edges(view.positions)?);
    let [pp, pq, qq] = [p.dot(p), p.dot(q), q.dot(q)];
    let [x, y] = [p.dot(way), q.dot(way)];
    // The direction in the edges of the rest shape, with the edges as they are now.
    (u * (qq * x - pq * y) + v * (pp * y - pq * x)).try_normalize()
}
