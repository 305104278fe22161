//! Parts of a step that `rhexis bench ablation` leaves out one at a time.

/// A remedy or a speed path of a step that no other setting switches off.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Part {
    /// Displacement of the last step as the first guess of a dynamic solve.
    InitialGuess,
    /// Energy guard of linearly implicit steps as a whole.
    EnergyGuard,
    /// Local relaxation by vertex block descent.
    LocalRelaxation,
    /// Limit of an increment to the largest fraction that creates no energy.
    IncrementLimit,
    /// Undo of a step that would create energy.
    Undo,
    /// Second solve of bodies whose tips will advance.
    TipSolve,
    /// Further solves of bodies that a solve has carried into an obstacle.
    ContactRounds,
}
