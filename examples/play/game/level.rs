//! The level: a dome of cloth hung on two corners, and a smaller one beside it that comes and goes.

use super::{Renderer, Result};
use glam::{DQuat, DVec2, DVec3};
use rhexis::components::{Changes, Damping, Drag, Fibres, Gravity, Material, TearMode, Tearing};
use rhexis::membrane::Membrane;
use rhexis::simulation::Simulation;
use rhexis::storage::{BodyId, TriangleMesh};
use std::sync::Arc;

/// Side of a sheet \[mm\].
pub const SIZE: f64 = 40.0;
/// Radius of the sphere that it is cut from \[mm\].
const RADIUS: f64 = 30.0;
/// Vertices along a side.
const FINE: usize = 40;
const COARSE: usize = 12;
/// Where the second sheet appears \[mm\].
const BESIDE: DVec3 = DVec3::new(60.0, 0.0, 0.0);

#[derive(Clone)]
pub struct Level {
    pub cloth: BodyId,
    second: Option<BodyId>,
}

impl Level {
    /// Hangs the cloth on its two upper corners.
    pub fn new(simulation: &mut Simulation, renderer: &mut Renderer) -> Result<Self> {
        let cloth = spawn(simulation, renderer, FINE)?;
        let keys = simulation.view(cloth)?.vertex_keys;
        let corners = [keys[FINE * (FINE - 1)], keys[FINE * FINE - 1]];
        simulation.pin(cloth, "corners", &corners)?;
        Ok(Self { cloth, second: None })
    }

    /// Takes the second sheet away or puts one there; says which.
    pub fn toggle_second(&mut self, simulation: &mut Simulation, renderer: &mut Renderer) -> Result<&'static str> {
        if let Some(sheet) = self.second.take() {
            simulation.despawn(sheet)?;
            renderer.remove(sheet);
            return Ok("despawned");
        }
        let sheet = spawn(simulation, renderer, COARSE)?;
        simulation.teleport(sheet, DQuat::IDENTITY, BESIDE)?;
        self.second = Some(sheet);
        Ok("spawned")
    }
}

fn spawn(simulation: &mut Simulation, renderer: &mut Renderer, side: usize) -> Result<BodyId> {
    let (mesh, texture) = dome(side);
    let tearing = Tearing {
        strength_across_fibres: 0.6,
        strength_along_fibres: 0.3,
        may_initiate: true,
        mode: TearMode::Free,
        ..Tearing::default()
    };
    let sheet = Membrane::new("cloth", mesh, Material { density: 1e-3, ..Material::allard_2009() })
        .fibres(Fibres::Function(Arc::new(|x| DVec3::Z.cross(x))))
        .with(Gravity { acceleration: DVec3::new(0.0, -9.81e-3, 0.0) })
        .with(Damping { time: 1.0 })
        .with(Drag { coefficient: 1e-6 })
        .with(tearing)
        .with(Changes::default());
    let body = simulation.spawn(sheet)?;
    renderer.add(simulation, body, texture)?;
    Ok(body)
}

/// A square part of a sphere with `side` × `side` vertices, and their texture coordinates.
fn dome(side: usize) -> (TriangleMesh, Vec<DVec2>) {
    let row = side as u32;
    let texture: Vec<DVec2> =
        (0..side * side).map(|v| DVec2::new((v % side) as f64, (v / side) as f64) / (side - 1) as f64).collect();
    let on_sphere = |uv: &DVec2| ((*uv - 0.5) * SIZE).extend(RADIUS).normalize() * RADIUS;
    let cells = (0..row - 1).flat_map(|j| (0..row - 1).map(move |i| j * row + i));
    let triangles = cells.flat_map(|a| [[a, a + 1, a + row + 1], [a, a + row + 1, a + row]]).collect();
    (TriangleMesh { positions: texture.iter().map(on_sphere).collect(), triangles, fibres: None }, texture)
}
