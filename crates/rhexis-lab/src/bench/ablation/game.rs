//! The game of `examples/play`: a mouse draws, tears and cuts a domed cloth hung on two corners.

use super::super::BenchError;
use glam::{DVec2, DVec3};
use rhexis::components::{Damping, Drag, Fibres, Grasp, Gravity, Jaws, Material, Pose, Slip, TearMode, Tearing};
use rhexis::membrane::Membrane;
use rhexis::settings::Settings;
use rhexis::simulation::Simulation;
use rhexis::storage::TriangleMesh;
use rhexis::storage::{BodyId, ForcepsId};
use std::sync::Arc;

/// Side of the sheet, and radius of the sphere that it is cut from \[mm\].
const SIZE: f64 = 40.0;
const RADIUS: f64 = 30.0;
/// Vertices along a side.
const SIDE: usize = 40;
/// Position of the camera, and its range \[mm\].
const EYE: DVec3 = DVec3::new(0.0, 0.0, 120.0);
const FAR: f64 = 500.0;
/// Limit of the cursor, and its largest way in a frame \[mm\].
const REACH: f64 = 25.0;
const PACE: f64 = 2.0;
/// Distance by which the cloth is drawn nearer than it was grasped \[mm\].
const PULL: f64 = 15.0;
/// Chances per frame.
const GRASPS: f64 = 0.1;
const LETS_GO: f64 = 0.02;
const CUTS: f64 = 0.004;

/// The simulation and its player.
pub(super) struct Game {
    pub simulation: Simulation,
    pub cloth: BodyId,
    forceps: ForcepsId,
    dice: u64,
    cursor: DVec2,
    /// Distance at which the cloth was grasped \[mm\]; `None` with an open hand.
    held_at: Option<f64>,
}

fn failed(error: impl std::fmt::Display) -> BenchError {
    BenchError::State(format!("the game: {error}"))
}

impl Game {
    /// One picture, and one step \[ms\].
    pub(super) const FRAME: f64 = 1000.0 / 60.0;

    pub(super) fn new(settings: Settings) -> Result<Self, BenchError> {
        let mut simulation = Simulation::new(settings)?;
        let tearing = Tearing {
            strength_across_fibres: 0.6,
            strength_along_fibres: 0.3,
            may_initiate: true,
            mode: TearMode::Free,
            ..Tearing::default()
        };
        let sheet = Membrane::new("cloth", dome(), Material { density: 1e-3, ..Material::allard_2009() })
            .fibres(Fibres::Function(Arc::new(|x| DVec3::Z.cross(x))))
            .with(Gravity { acceleration: DVec3::new(0.0, -9.81e-3, 0.0) })
            .with(Damping { time: 1.0 })
            .with(Drag { coefficient: 1e-6 })
            .with(tearing);
        let cloth = simulation.spawn(sheet).map_err(failed)?;
        let keys = simulation.view(cloth).map_err(failed)?.vertex_keys;
        let corners = [keys[SIDE * (SIDE - 1)], keys[SIDE * SIDE - 1]];
        simulation.pin(cloth, "corners", &corners).map_err(failed)?;
        let jaws = Jaws { radius: 1.0, stiffness: Some(0.2), force_limit: Some(0.5), slip: Slip::LetGo };
        let forceps = simulation.spawn_forceps("mouse", jaws, Pose::at(DVec3::ZERO)).map_err(failed)?;
        let dice = 0x9e37_79b9_7f4a_7c15 ^ 0xd1b5_4a32_d192_ed03 | 1;
        Ok(Self { simulation, cloth, forceps, dice, cursor: DVec2::ZERO, held_at: None })
    }

    /// A random number in [0, 1) (Marsaglia's xorshift).
    fn next(&mut self) -> f64 {
        self.dice ^= self.dice << 13;
        self.dice ^= self.dice >> 7;
        self.dice ^= self.dice << 17;
        (self.dice >> 11) as f64 / (1_u64 << 53) as f64
    }

    /// One frame of input, which the next step carries out.
    pub(super) fn play(&mut self) -> Result<(), BenchError> {
        let step = DVec2::new(self.next(), self.next()) * 2.0 - 1.0;
        self.cursor = (self.cursor + step * PACE).clamp(DVec2::splat(-REACH), DVec2::splat(REACH));
        let ahead = (DVec3::new(self.cursor.x, self.cursor.y - 10.0, 25.0) - EYE).normalize();
        // One number per frame for each choice, so that rows that part have the same hand.
        let [grasps, lets_go, cuts] = [self.next() < GRASPS, self.next() < LETS_GO, self.next() < CUTS];
        match self.held_at {
            None if grasps => self.grasp(ahead)?,
            Some(_) if lets_go => {
                self.simulation.open_forceps(self.forceps).map_err(failed)?;
                self.held_at = None;
            }
            _ => {}
        }
        if let Some(distance) = self.held_at {
            let pose = Pose::at(EYE + ahead * (distance - PULL));
            self.simulation.move_forceps(self.forceps, pose, Self::FRAME).map_err(failed)?;
        }
        if cuts {
            let aside = (ahead + DVec3::new(0.03, 0.01, 0.0)).normalize();
            let [from, to] = [ahead, aside].map(|way| self.simulation.cast_ray(self.cloth, EYE, way, FAR));
            if let (Some(from), Some(to)) = (from, to) {
                // A cut that would leave the tissue is refused; the game goes on.
                let _ = self.simulation.cut(self.cloth, &[from.rest_position, to.rest_position]);
            }
        }
        Ok(())
    }

    fn grasp(&mut self, ahead: DVec3) -> Result<(), BenchError> {
        let Some(hit) = self.simulation.cast_ray(self.cloth, EYE, ahead, FAR) else { return Ok(()) };
        self.simulation.move_forceps(self.forceps, Pose::at(hit.position), 0.0).map_err(failed)?;
        let grasp = Grasp::Ray { origin: EYE, direction: ahead, reach: FAR };
        let is_closed = self.simulation.close_forceps(self.forceps, self.cloth, &grasp).is_ok();
        self.held_at = is_closed.then_some(hit.distance);
        Ok(())
    }

    /// Learns whether the hand still holds the cloth: jaws slip.
    pub(super) fn look_again(&mut self) -> Result<(), BenchError> {
        if self.simulation.forceps(self.forceps).map_err(failed)?.body.is_none() {
            self.held_at = None;
        }
        Ok(())
    }
}

/// A square part of a sphere.
fn dome() -> TriangleMesh {
    let row = SIDE as u32;
    let on_sphere = |v: usize| {
        let uv = DVec2::new((v % SIDE) as f64, (v / SIDE) as f64) / (SIDE - 1) as f64;
        ((uv - 0.5) * SIZE).extend(RADIUS).normalize() * RADIUS
    };
    let cells = (0..row - 1).flat_map(|j| (0..row - 1).map(move |i| j * row + i));
    let triangles = cells.flat_map(|a| [[a, a + 1, a + row + 1], [a, a + row + 1, a + row]]).collect();
    TriangleMesh { positions: (0..SIDE * SIDE).map(on_sphere).collect(), triangles, fibres: None }
}
