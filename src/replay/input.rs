//! The calls of a host that change a simulation. A new one is a variant here and an arm of `Simulation::repeat`.

use crate::components::{Grasp, Jaws, Obstacle, Path, Pose, Rigid, Shape, Turning};
use crate::math::Orthotropic;
use crate::registry::Parameters;
use crate::settings::Settings;
use crate::snapshot::{Saved, Snapshot};
use crate::storage::{BladeId, BodyId, ForcepsId, ObstacleId, Uniform, VertexKey};
use glam::{DQuat, DVec3};
use hecs::Entity;

/// One call. Those that were refused are written down too: they are refused again.
#[derive(Clone)]
#[cfg_attr(feature = "snapshot", derive(serde::Serialize, serde::Deserialize))]
#[non_exhaustive]
pub enum Input {
    /// A dynamic step.
    Step {
        /// Time step \[ms\].
        dt: f64,
        /// Where a solve may take so long: per body in order of spawning, after how many iterations its rounds have stopped.
        stops: Vec<Vec<u32>>,
    },
    /// A static equilibrium.
    Settle {
        /// Time by which the loads move on \[ms\].
        dt: f64,
        /// Where Newton's method stops.
        tolerance: f64,
    },
    /// Static equilibria and tears.
    SettleAndTear {
        /// Time by which the loads move on \[ms\].
        dt: f64,
        /// Where Newton's method stops.
        tolerance: f64,
        /// How often tears advance at the most.
        rounds: u32,
    },
    /// A linear answer.
    LinearResponse {
        /// Time by which the loads move on \[ms\].
        dt: f64,
    },
    /// A cut.
    Cut {
        /// The body.
        body: BodyId,
        /// Points of the cut \[mm, rest shape\].
        polyline: Vec<DVec3>,
    },
    /// A body was put into the world.
    Spawn(Spawned),
    /// An obstacle was put into the world.
    SpawnObstacle(Obstacle),
    /// An obstacle was put into the world that follows a path, and turns.
    SpawnMovingObstacle(Obstacle, Path, Option<Turning>),
    /// An obstacle was moved.
    MoveObstacle {
        /// The obstacle.
        obstacle: ObstacleId,
        /// Shape of the obstacle at the end of the next step.
        shape: Shape,
    },
    /// Forceps were put into the world.
    SpawnForceps {
        /// Name of the forceps.
        name: String,
        /// Jaws of the forceps.
        jaws: Jaws,
        /// Pose of the forceps.
        pose: Pose,
    },
    /// Forceps were moved.
    MoveForceps {
        /// The forceps.
        forceps: ForcepsId,
        /// Target pose of the forceps.
        pose: Pose,
        /// Time of the motion \[ms\].
        within: f64,
    },
    /// Forceps were closed.
    CloseForceps {
        /// The forceps.
        forceps: ForcepsId,
        /// The body between them.
        body: BodyId,
        /// Grasp on the body.
        grasp: Grasp,
    },
    /// Forceps were opened.
    OpenForceps(ForcepsId),
    /// A blade was put into the world.
    SpawnBlade {
        /// Reach of the blade \[mm\].
        reach: f64,
        /// Shortest cut of the blade \[mm\].
        least: f64,
    },
    /// A blade was drawn.
    DrawBlade {
        /// The blade.
        blade: BladeId,
        /// Through this body.
        body: BodyId,
        /// To here \[mm\].
        edge: DVec3,
    },
    /// Vertices were pinned.
    Pin {
        /// Of this body.
        body: BodyId,
        /// Under this name.
        name: String,
        /// These.
        vertices: Vec<VertexKey>,
    },
    /// Vertices were let go.
    Unpin {
        /// Of this body.
        body: BodyId,
        /// These.
        vertices: Vec<VertexKey>,
    },
    /// All pins of a name were let go.
    UnpinAll {
        /// Of this body.
        body: BodyId,
        /// The name.
        name: String,
    },
    /// A body was set elsewhere.
    Teleport {
        /// The body.
        body: BodyId,
        /// Turned about the origin.
        rotation: DQuat,
        /// Then shifted \[mm\].
        shift: DVec3,
    },
    /// A body, an obstacle or a tool was taken out.
    Despawn(#[cfg_attr(feature = "snapshot", serde(with = "crate::storage::handle::bits"))] Entity),
    /// A body, or those that a changed obstacle touches, was woken.
    Wake(#[cfg_attr(feature = "snapshot", serde(with = "crate::storage::handle::bits"))] Entity),
    /// All bodies were woken.
    WakeAll,
    /// A body's rows were sorted.
    Reorder(BodyId),
    /// Other settings.
    SetSettings(#[cfg_attr(feature = "snapshot", serde(with = "crate::snapshot::settings"))] Settings),
    /// Components were changed from outside.
    Change {
        /// Of this body or obstacle.
        #[cfg_attr(feature = "snapshot", serde(with = "crate::storage::handle::bits"))]
        entity: Entity,
        /// Those that were.
        to: Changes,
    },
    /// Back to a snapshot.
    Restore(Snapshot),
    /// A component was set or taken off.
    Set {
        /// Of this body, obstacle or tool.
        #[cfg_attr(feature = "snapshot", serde(with = "crate::storage::handle::bits"))]
        entity: Entity,
        /// That one.
        to: Changes,
    },
    /// A vertex was pushed.
    ApplyForce {
        /// Of this body.
        body: BodyId,
        /// This one.
        vertex: VertexKey,
        /// \[N\].
        force: DVec3,
    },
    /// An obstacle was made a rigid body, or one that yields to nothing.
    SetRigid {
        /// The obstacle.
        obstacle: ObstacleId,
        /// Mass and motion.
        rigid: Option<Rigid>,
    },
    /// The triangles of a body were given other materials.
    SetMaterial {
        /// The body.
        body: BodyId,
        /// Materials by triangle.
        to: Box<Materials>,
    },
}

/// A body as it was put into the world.
#[derive(Clone)]
#[cfg_attr(feature = "snapshot", derive(serde::Serialize, serde::Deserialize))]
pub struct Spawned(pub(crate) Box<Saved>);

/// Materials of a body's triangles, in the order of their rows.
#[derive(Clone, Default)]
#[cfg_attr(feature = "snapshot", derive(serde::Serialize, serde::Deserialize))]
pub struct Materials {
    pub(crate) stiffness: Uniform<Orthotropic>,
    pub(crate) thickness: Uniform<f64>,
    pub(crate) density: Uniform<f64>,
}

/// Components as they are after a change.
#[derive(Clone)]
#[cfg_attr(feature = "snapshot", derive(serde::Serialize, serde::Deserialize))]
pub struct Changes(pub(crate) Box<Parameters>);

impl From<Parameters> for Changes {
    fn from(changed: Parameters) -> Self {
        Self(Box::new(changed))
    }
}
