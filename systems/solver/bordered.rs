//! A solve with the content of a compartment: one unknown more, the pressure, eliminated.
//!
//! The operator A has k·g·gᵀ beside, with the gradient g of the volume. A nearly incompressible content makes k so large that single precision would lose
//! the rest of A beside it, and no preconditioner knows it. So the system is that of displacement and pressure q, counted from the one that is expected,
//!
//! A·x = b − (p − p₀)·g + q·g,     q = p − p₀ − k·gᵀ·x,
//!
//! with p where the body is evaluated and p₀ expected: by the solve before, in the first one that at the end of the last step. With y = A⁻¹·(b − (p − p₀)·g) and z = A⁻¹·g it is x = y + q·z and
//! q = (p − p₀ − k·gᵀ·y)/(1 + k·gᵀ·z) (Sherman, Morrison 1950). The volume obeys the content to rounding, whatever residual is left of y and z; z of the last
//! solve is a good guess.

use super::{Available, CgError, CgInfo, Operator, ProductMemory, preconditioned};
use crate::components::{SolverScratch, VolumeStiffness};
use crate::settings::LinearParams;
use crate::systems::parallel;
use glam::DVec3;

/// Largest relative residual of z.
const TOLERANCE_OF_ANSWER: f64 = 1e-4;

/// Solves as [`preconditioned::solve`] does, for an operator with a compartment. `answer` is z of the last solve.
///
/// # Errors
/// See [`CgError`].
pub(super) fn solve(
    (operator, volume): (&Operator, &VolumeStiffness),
    params: &LinearParams,
    available: &mut Available,
    memory: &mut ProductMemory<'_>,
    (x, answer): (&mut [DVec3], &mut Vec<DVec3>),
    scratch: &mut SolverScratch,
) -> Result<CgInfo, CgError> {
    let without = Operator { volume: None, ..*operator };
    let share = |available: &mut Available, is_same| {
        if let Some((mixed, _)) = &mut available.mixed {
            mixed.share(is_same);
        }
    };
    share(available, true);
    let rhs = scratch.residual.clone();
    let to_pressure = answer_to_pressure((&without, volume), params, available, memory, answer, scratch);
    let left_of_answer = std::mem::replace(&mut scratch.residual, rhs);
    let solved = to_pressure.and_then(|to_pressure| {
        parallel::for_rows(&mut scratch.residual, |v, r| *r -= volume.gradient[v] * volume.ahead);
        Ok((to_pressure, preconditioned::solve(&without, params, available, memory, x, scratch)?))
    });
    share(available, false);
    let (to_pressure, info) = solved?;
    let resistance = 1.0 + volume.stiffness * volume.swept(answer);
    if !(resistance > 0.0) {
        return Err(CgError::Indefinite { iteration: info.iterations });
    }
    let pressure = (volume.ahead - volume.stiffness * volume.swept(x)) / resistance;
    parallel::for_rows(x, |v, x| *x += answer[v] * pressure);
    let free = &scratch.free;
    parallel::for_rows(&mut scratch.residual, |v, r| *r += left_of_answer[v] * free[v] * pressure);
    Ok(CgInfo { iterations: info.iterations + to_pressure.iterations, ..info })
}

/// Solves A·z = g along free axes, in units of its own.
fn answer_to_pressure(
    (without, volume): (&Operator, &VolumeStiffness),
    params: &LinearParams,
    available: &mut Available,
    memory: &mut ProductMemory<'_>,
    answer: &mut Vec<DVec3>,
    scratch: &mut SolverScratch,
) -> Result<CgInfo, CgError> {
    answer.resize(volume.gradient.len(), DVec3::ZERO);
    let free = &scratch.free;
    parallel::for_rows(answer, |v, z| *z *= free[v]);
    scratch.residual.copy_from_slice(&volume.gradient);
    let params = LinearParams {
        tolerance: params.tolerance.min(TOLERANCE_OF_ANSWER),
        stress_tolerance: f64::INFINITY,
        ..*params
    };
    let scales = (scratch.near, scratch.twice_stored, scratch.reference_sq);
    (scratch.near, scratch.twice_stored, scratch.reference_sq) = (0.0, 0.0, 0.0);
    let info = preconditioned::solve(without, &params, available, memory, answer, scratch);
    (scratch.near, scratch.twice_stored, scratch.reference_sq) = scales;
    info
}
