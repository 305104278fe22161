//! One error for all calls: a host that does not tell them apart writes `?`, and asks for the kind.

use crate::components::{BadCurve, BodyError, HullError, InadmissibleToughness};
use crate::generate::GenerateError;
use crate::math::InadmissibleMaterial;
use crate::replay::ReplayError;
use crate::settings::OutOfRange;
use crate::simulation::{
    CutError, ForceError, HapticError, MotionError, PinError, SetError, SimulationError, SpawnError, ToolError,
};
use crate::snapshot::SnapshotError;
use crate::storage::MeshError;
use crate::systems::step::schedule::BadPlace;

/// The result of a call that any of the engine's errors can end.
pub type Result<T, E = Error> = std::result::Result<T, E>;

/// Kind of an error, by the remedy of a host.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum ErrorKind {
    /// A mesh, component, setting or argument is refused: the message names it and the allowed values. Nothing has changed.
    InvalidInput,
    /// There is no such body, tool, vertex, hold or system.
    NotFound,
    /// A tool found no tissue within reach, or the mesh refused a cut. Nothing has changed.
    NothingDone,
    /// No equilibrium or no linear answer was found; the last good state stands.
    NotSolved,
    /// Bytes that are no snapshot or recording of this version, or are damaged.
    Unreadable,
    /// A file cannot be read or written.
    File,
    /// A replay has ended in another state than the recording.
    Diverged,
    /// The system grants no threads.
    Threads,
}

/// Any error of the engine. `Debug` prints the words of `Display`: a `main` that returns it tells the user the remedy.
#[derive(Clone, PartialEq, thiserror::Error)]
#[error(transparent)]
#[non_exhaustive]
pub enum Error {
    /// Of a body or one of its components.
    Body(#[from] BodyError),
    /// Of a body that is spawned.
    Spawn(#[from] SpawnError),
    /// Of a mesh.
    Mesh(#[from] MeshError),
    /// Of a generated mesh.
    Generate(#[from] GenerateError),
    /// Of a material.
    Material(#[from] InadmissibleMaterial),
    /// Of a toughness.
    Toughness(#[from] InadmissibleToughness),
    /// Of a curve.
    Curve(#[from] BadCurve),
    /// Of the mesh of an obstacle.
    Hull(#[from] HullError),
    /// Of a setting.
    Setting(#[from] OutOfRange),
    /// Of a simulation or a step.
    Simulation(#[from] SimulationError),
    /// Of a cut, puncture or blade.
    Cut(#[from] CutError),
    /// Of forceps.
    Tool(#[from] ToolError),
    /// Of pins.
    Pin(#[from] PinError),
    /// Of a force on a vertex.
    Force(#[from] ForceError),
    /// Of a motion.
    Motion(#[from] MotionError),
    /// Of a component that is set.
    Set(#[from] SetError),
    /// Of a haptic model.
    Haptic(#[from] HapticError),
    /// Of the place of a system.
    Place(#[from] BadPlace),
    /// Of a snapshot.
    Snapshot(#[from] SnapshotError),
    /// Of a replay.
    Replay(#[from] ReplayError),
    /// Of a component asked of the world.
    #[error("{0}: spawn the entity, or set the component, before it is asked for")]
    Component(#[from] hecs::ComponentError),
}

impl std::fmt::Debug for Error {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{self}")
    }
}

impl Error {
    /// Kind of the error.
    pub fn kind(&self) -> ErrorKind {
        use ErrorKind::{Diverged, InvalidInput, NotFound, NotSolved, NothingDone, Threads};
        match self {
            Self::Simulation(error) => match error {
                SimulationError::NoSuchBody | SimulationError::NoSuchComponents => NotFound,
                SimulationError::NoEquilibrium { .. }
                | SimulationError::IterationsUsedUp { .. }
                | SimulationError::NoLinearAnswer { .. } => NotSolved,
                SimulationError::Threads(_) => Threads,
                _ => InvalidInput,
            },
            Self::Cut(error) => match error {
                CutError::NoSuchBody | CutError::NoSuchBlade => NotFound,
                CutError::NothingThere | CutError::Refused(_) => NothingDone,
                _ => InvalidInput,
            },
            Self::Tool(error) => match error {
                ToolError::NoSuchBody | ToolError::NoSuchForceps | ToolError::NoSuchVertex { .. } => NotFound,
                ToolError::NothingThere { .. } | ToolError::Closed { .. } => NothingDone,
                _ => InvalidInput,
            },
            Self::Pin(error) | Self::Haptic(HapticError::Pins(error)) => kind_of_pin(error),
            Self::Force(ForceError::NoSuchBody | ForceError::NoSuchVertex(_))
            | Self::Motion(MotionError::NoSuchBody)
            | Self::Set(SetError::NoSuchEntity)
            | Self::Haptic(HapticError::NoSuchBody | HapticError::NoSuchVertex(_) | HapticError::NotClosed(_))
            | Self::Place(BadPlace::NoSuchSystem { .. })
            | Self::Component(_) => NotFound,
            Self::Haptic(HapticError::NoAnswer(_)) => NotSolved,
            Self::Snapshot(error) | Self::Replay(ReplayError::Start(error)) => kind_of_snapshot(error),
            Self::Replay(ReplayError::Diverged { .. }) => Diverged,
            _ => InvalidInput,
        }
    }
}

fn kind_of_pin(error: &PinError) -> ErrorKind {
    match error {
        PinError::NoSuchBody | PinError::NoSuchVertex(_) | PinError::NoSuchHold(_) | PinError::NotPinned(_) => {
            ErrorKind::NotFound
        }
        _ => ErrorKind::InvalidInput,
    }
}

fn kind_of_snapshot(error: &SnapshotError) -> ErrorKind {
    match error {
        SnapshotError::File { .. } => ErrorKind::File,
        SnapshotError::Threads(_) => ErrorKind::Threads,
        SnapshotError::Settings(_) => ErrorKind::InvalidInput,
        _ => ErrorKind::Unreadable,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn errors_of_calls_become_one_with_their_words_and_a_kind() {
        fn missing() -> Result<()> {
            Err(SimulationError::NoSuchBody)?
        }
        let error = missing().unwrap_err();
        assert_eq!((error.kind(), error.to_string().as_str()), (ErrorKind::NotFound, "there is no such body"));
        assert_eq!(format!("{error:?}"), "there is no such body");
        let kinds = [
            (Error::from(BadCurve::Empty), ErrorKind::InvalidInput),
            (Error::from(CutError::NothingThere), ErrorKind::NothingDone),
            (Error::from(hecs::ComponentError::NoSuchEntity), ErrorKind::NotFound),
            (Error::from(SnapshotError::Damaged), ErrorKind::Unreadable),
            (Error::from(ReplayError::Start(SnapshotError::Damaged)), ErrorKind::Unreadable),
            (Error::from(SimulationError::NoLinearAnswer { time: 0.0, residual: 1.0 }), ErrorKind::NotSolved),
        ];
        assert!(kinds.iter().all(|(error, kind)| error.kind() == *kind), "{kinds:?}");
    }
}
