//! The order of a step's stages, with its loops and their conditions: one list, run by [`run`](super::run).

use super::schedule::Stage;
use crate::settings::ablation::Part;
use crate::settings::{LinearParams, Tangent};
use crate::systems::StepContext;
use crate::systems::fracture::CORRECTORS;
use std::slice::from_ref;

/// Factor on the stress tolerance of the corrector solve. An advance cannot be undone, and the error at a tip may be several times the mean
/// of the body.
const CORRECTOR_STRESS: f64 = 0.2;

/// Upper bound of the relative residual for Newton corrections of a step that fails the energy check.
const CORRECTION_RESIDUAL: f64 = 1e-6;

/// Maximum contact rounds per step.
const CONTACT_ROUNDS: u32 = 4;

/// Maximum friction rounds per step. With two, a sheet that is drawn along by a fifth of its length per step is thrown off
/// (`cargo test --release --test contact friction`).
const FRICTION_ROUNDS: u32 = 4;

/// A part of the step.
pub enum Phase {
    /// The systems of a stage, in the order of [`STEP`](super::schedule::STEP).
    Run(Stage),
    /// Fault check: bodies without a sound state are rolled back and excluded; the step ends where none is left.
    Check,
    /// Fault check at the end of a pass, made only where systems of the caller run after the other checks.
    CheckCallers,
    /// Phases run in order.
    Group(&'static [Phase]),
    /// Phases that run where the condition holds for the step.
    When(fn(&StepContext) -> bool, &'static [Phase]),
    /// Phases that run with the context of another stage of time integration.
    With(fn(&StepContext) -> StepContext, &'static [Phase]),
    /// Rounds while a stage counts bodies that need one.
    While(Loop),
    /// Rounds while a stage counts bodies that need one, after a first round that is made anyway.
    AtLeastOnce(Loop),
}

/// Rounds of phases.
pub struct Loop {
    /// The stage whose systems count the bodies that need another round.
    pub needed: Stage,
    /// Maximum number of repetitions; [`AtLeastOnce`](Phase::AtLeastOnce) makes one round more.
    pub most: fn(&StepContext) -> u32,
    /// The context of a round, by the number of rounds before.
    pub context: fn(&StepContext, u32) -> StepContext,
    /// Phases that are repeated.
    pub phases: &'static [Phase],
    /// Phases run where the repetitions are used up and bodies still need one; if there are none, need is not counted again.
    pub used_up: &'static [Phase],
}

use Phase::{AtLeastOnce, Check, CheckCallers, Group, Run, When, While, With};

/// A dynamic step: solved, decided, torn, and resumed while tears may advance further in it: the same equations and start, continued from
/// the displacement reached, on the torn mesh.
pub const PHASES: &[Phase] = &[AtLeastOnce(Loop {
    needed: Stage::Unfinished,
    most: |step| step.max_tear_passes,
    context: |step, round| StepContext { is_resumed: round > 0, ..*step },
    phases: &[
        When(|step| step.is_resumed, &[Run(Stage::Resume)]),
        When(|step| !step.is_resumed && step.has_first_stage(), FIRST_STAGE),
        When(|step| !step.is_resumed && !step.has_first_stage(), &[Run(Stage::Begin)]),
        Group(SOLVE),
        Run(Stage::Judge),
        Check,
        When(is_linear, &[CONTACT, FRICTION, Run(Stage::Unsettled)]),
        Run(Stage::PreventTunnelling),
        Run(Stage::Decide),
        When(is_linear, from_ref(&CORRECTOR)),
        Run(Stage::Account),
        Run(Stage::Tear),
        CheckCallers,
    ],
    used_up: &[],
})];

/// A static solve.
pub const STATIC_PHASES: &[Phase] = &[Run(Stage::Begin), Group(SOLVE), Run(Stage::Judge), Run(Stage::Account)];

/// The first stage of a step of two, after the acceleration at its start.
const FIRST_STAGE: &[Phase] = &[
    With(StepContext::first_stage, &[Run(Stage::Begin)]),
    With(StepContext::at_start, &[Run(Stage::Evaluate), Run(Stage::Start)]),
    With(StepContext::first_stage, SOLVE),
    Check,
    Run(Stage::SecondStage),
];

/// The solve of a step or a stage of it.
const SOLVE: &[Phase] = &[When(is_linear, LINEAR), When(|step| !is_linear(step), from_ref(&NEWTON))];

/// Newton's iteration. The last one of a dynamic step only evaluates the state reached by the ones before. A quarter of the budget is kept for
/// retries.
const NEWTON: Phase = AtLeastOnce(Loop {
    needed: Stage::Unconverged,
    most: |step| step.newton_iterations,
    context: |step, _| StepContext { budget: step.budget.map(|budget| budget - budget / 4), ..*step },
    phases: &[Run(Stage::Evaluate), Run(Stage::Solve)],
    used_up: &[],
});

/// The solve of a linearly implicit step, then Newton corrections of bodies that fail the energy check.
const LINEAR: &[Phase] = &[
    Run(Stage::Evaluate),
    Run(Stage::Solve),
    While(Loop {
        needed: Stage::Uncorrected,
        most: |step| step.newton_corrections,
        context: |step, round| StepContext {
            newton_corrections: step.newton_corrections - 1 - round,
            is_correction: true,
            tangent: Tangent::Projected,
            linear: LinearParams { tolerance: step.linear.tolerance.min(CORRECTION_RESIDUAL), ..step.linear },
            // Work is reserved for a fallback sub-step after failed corrections.
            ..step.before(1)
        },
        phases: &[Run(Stage::Evaluate), Run(Stage::Solve)],
        used_up: &[],
    }),
    Run(Stage::Solved),
];

/// Contact rounds: repeated solves of bodies with vertices carried deep into an obstacle.
const CONTACT: Phase = While(Loop {
    needed: Stage::Penetrating,
    most: |step| if step.has(Part::ContactRounds) { CONTACT_ROUNDS } else { 0 },
    context: |step, _| *step,
    phases: &[Group(LINEAR), Check],
    used_up: &[Run(Stage::Depenetrate), Check],
});

/// Friction rounds: repeated solves of bodies whose friction is far from its law. None in passes that follow an advance: their
/// solves have the springs of their own states.
const FRICTION: Phase = While(Loop {
    needed: Stage::Slipping,
    most: |step| if step.has(Part::ContactRounds) && !step.is_resumed { FRICTION_ROUNDS } else { 0 },
    context: |step, _| *step,
    phases: &[Group(LINEAR), Check, CONTACT],
    used_up: &[],
});

/// Further solves of the bodies whose tips are about to advance in this step, until the energy release there is at rest. One linear solve leaves the
/// linearisation error of the whole step, or of an advance that springs open, on which the path would depend. Where triangles are in tension
/// their tangent has the turning terms: without them the rotations lag behind.
const CORRECTOR: Phase = While(Loop {
    needed: Stage::Advancing,
    most: |step| if step.has(Part::TipSolve) { CORRECTORS } else { 0 },
    context: |step, _| {
        let stress_tolerance = CORRECTOR_STRESS * step.linear.stress_tolerance;
        StepContext { is_corrector: true, linear: LinearParams { stress_tolerance, ..step.linear }, ..*step }
    },
    phases: &[Group(LINEAR), Check, Run(Stage::PreventTunnelling), Run(Stage::Decide)],
    used_up: &[],
});

fn is_linear(step: &StepContext) -> bool {
    step.newton_iterations == 1
}
