//! Work of a step that is not an iteration, counted in iterations of linear solves: the unit of [`Settings::budget`].
//!
//! Counted and not timed, so that a budget ends a step at the same place on every machine. The ratios are those of the lens capsule
//! with 6,900 triangles, half torn, where an iteration takes 11 ns per triangle (`docs/performance.md`, "Where time goes").
//!
//! [`Settings::budget`]: crate::settings::Settings::budget

use crate::components::SolveResult;
use crate::systems::StepContext;

/// Work of an evaluation: rotations, forces, contact, and the account of energy.
pub const EVALUATION: u32 = 7;

/// Work of the matrix and its preconditioner in a solve.
pub const SET_UP: u32 = 11;

/// Work of a Cholesky factor of some thousand triangles; twice as much for the first of a mesh, which finds its pattern.
pub const FACTOR: u32 = 80;

/// Work of an iteration with a Cholesky factor.
pub const FACTOR_ITERATION: u32 = 10;

/// Work of a solve in three iterations with the first factor of a mesh.
pub const FACTORED: u32 = 2 * FACTOR + 3 * FACTOR_ITERATION;

/// Minimum iterations of a solve whose budget is used up.
pub const LEAST_ITERATIONS: u32 = 4;

/// Number of triangles over which an iteration takes as long as an advance of a tear.
const TRIANGLES_PER_ADVANCE: usize = 10_000;

/// Number of triangles over which an iteration takes as long as halving one of them.
const TRIANGLES_PER_HALVING: usize = 500;

/// Box tests of contact between layers in the time that an iteration takes over a triangle.
const TESTS_PER_ITERATION: usize = 2;

/// Work that contact between layers may take where the budget leaves less.
const LEAST_OF_LAYERS: u32 = 100;

/// Maximum iterations with a new factor within a work; at least one.
pub fn iterations_with_factor(work: u32) -> u32 {
    (work.saturating_sub(2 * FACTOR) / FACTOR_ITERATION).max(1)
}

/// Work of so many advances of tears in a body of so many triangles.
pub fn of_advances(advances: usize, triangles: usize) -> u32 {
    in_iterations(advances * TRIANGLES_PER_ADVANCE, triangles)
}

/// Work of halving so many triangles of a body of so many.
pub fn of_halvings(halvings: usize, triangles: usize) -> u32 {
    in_iterations(halvings * TRIANGLES_PER_HALVING, triangles)
}

/// Number of halvings that so much work allows in a body of so many triangles; one at the least.
pub fn halvings_within(work: u32, triangles: usize) -> usize {
    (work as usize * triangles / TRIANGLES_PER_HALVING).max(1)
}

/// Work of box tests between the layers of a body, by its number of triangles.
pub fn of_layers(tests: usize, triangles: usize) -> u32 {
    in_iterations(tests / TESTS_PER_ITERATION, triangles)
}

/// Number of box tests for which the budget has work left; some are allowed always, since layers are held apart by them alone.
pub fn tests_within(left: Option<u32>, triangles: usize) -> usize {
    left.map_or(usize::MAX, |left| left.max(LEAST_OF_LAYERS) as usize * triangles * TESTS_PER_ITERATION)
}

/// Work of the shortest solve of a body, with an advance after it where it may tear.
fn least(result: &SolveResult) -> u32 {
    EVALUATION + SET_UP + LEAST_ITERATIONS + result.work_of_advance
}

impl StepContext {
    /// Work that is left to a body for this part, if there is a budget.
    pub fn left(&self, result: &SolveResult) -> Option<u32> {
        let reserved = self.reserved.saturating_mul(least(result));
        self.budget.map(|budget| budget.saturating_sub(result.work).saturating_sub(reserved))
    }

    /// Whether a body's budget is enough for `solves` more solves.
    pub fn affords(&self, result: &SolveResult, solves: u32) -> bool {
        self.left(result).is_none_or(|left| left >= solves.saturating_mul(least(result)))
    }
}

/// Whether every body has enough left of its budget for `solves` more solves.
pub fn all_afford(world: &mut hecs::World, step: &StepContext, solves: u32) -> bool {
    step.budget.is_none() || world.query_mut::<&SolveResult>().into_iter().all(|result| step.affords(result, solves))
}

fn in_iterations(passed: usize, triangles: usize) -> u32 {
    u32::try_from(passed.div_ceil(triangles.max(1))).unwrap_or(u32::MAX)
}
