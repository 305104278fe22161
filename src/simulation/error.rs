//! Why a simulation could not be made or could not go on, and the inputs it rejects.

use crate::components::BodyError;
use crate::registry::Rejected;
use crate::settings::OutOfRange;

/// Why a body is not spawned.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("body `{name}`: {source}")]
pub struct SpawnError {
    /// Name of the body.
    pub name: String,
    /// Component, its rejected value and the requirement.
    pub source: BodyError,
}

/// Why a simulation could not be made or could not go on.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum SimulationError {
    /// The threads could not be started.
    #[error("the threads could not be started: {0}")]
    Threads(String),
    /// A time step that is not a positive finite number, or leads beyond the largest number.
    #[error("dt is {0:?} ms: it must be positive and finite, and so must be the time it leads to")]
    TimeStep(f64),
    /// A setting or an argument outside its range.
    #[error(transparent)]
    OutOfRange(#[from] OutOfRange),
    /// There is no such body.
    #[error("there is no such body")]
    NoSuchBody,
    /// Something that was written past the calls, or an obstacle's shape, is refused; the last good state stands.
    #[error(transparent)]
    Written(#[from] Rejected),
    /// A dynamic step of a body whose energy is audited, by another formula than the audit's.
    #[error(
        "body `{body}` has an energy audit, whose terms are those of backward Euler: \
         take the audit out, or let the integrator be backward Euler"
    )]
    AuditOfAnotherIntegrator {
        /// The body's name.
        body: String,
    },
    /// A body or obstacle lacks the components asked for.
    #[error("the body or obstacle does not carry all of the components asked for")]
    NoSuchComponents,
    /// No equilibrium was found; the last good state stands.
    #[error("no equilibrium at time {time} ms: imbalance {imbalance:e} N after {iterations} iterations; {advice}")]
    NoEquilibrium {
        /// Time whose loads were applied \[ms\].
        time: f64,
        /// Largest free nodal force left \[N\].
        imbalance: f64,
        /// Newton iterations done.
        iterations: u32,
        /// Advice towards convergence.
        advice: String,
    },
    /// The iterations of a static solve were used up while it still came nearer; the last good state stands.
    #[error(
        "not yet in equilibrium at time {time} ms: the {iterations} iterations are used up while the imbalance still falls \
         ({imbalance:e} N, {least:e} N before): raise `static_iterations`, or use smaller load steps"
    )]
    IterationsUsedUp {
        /// Time whose loads were applied \[ms\].
        time: f64,
        /// Largest free nodal force left \[N\].
        imbalance: f64,
        /// The least at an earlier iteration \[N\].
        least: f64,
        /// Newton iterations done.
        iterations: u32,
    },
    /// The linear system of a linear response was not solved; the last good state stands.
    #[error(
        "no linear response at time {time} ms: relative residual {residual:e}; a part of the body may be held by nothing"
    )]
    NoLinearAnswer {
        /// Time whose loads were applied \[ms\].
        time: f64,
        /// Residual over the right-hand side.
        residual: f64,
    },
}
