//! Items that most programs embedding the engine use: `use rhexis::prelude::*;`.

pub use crate::components::{
    Attributes, Bending, Changes, Contact, Curve, Damping, EnergyCriterion, Fibres, Grasp, Gravity, Hold, Jaws,
    Material, Motion, Obstacle, Pose, Pressure, Refinement, Rigid, SelfContact, Shape, Slip, TearLog, Tearing,
};
pub use crate::error::{Error, ErrorKind};
pub use crate::event::{Event, EventKind};
pub use crate::generate;
pub use crate::membrane::Membrane;
pub use crate::report::Report;
pub use crate::settings::{Accuracy, Advanced, Settings};
pub use crate::simulation::{FixedStep, Simulation, Solid};
pub use crate::storage::{Attached, BodyId, ForcepsId, ObstacleId, TipKey, TriangleKey, TriangleMesh, VertexKey};
pub use crate::units;
pub use glam::{DQuat, DVec3};
pub use hecs::Entity;
