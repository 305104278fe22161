//! The choice of preconditioners for a body's solve.

use crate::components::{FreeAxes, TearMode, Tearing};
use crate::settings::{Precision, Preconditioner};
use crate::systems::solver::{Available, Factor, FactorUse, MixedPreconditioner, MixedSolver, Operator};
use crate::systems::{StepContext, work};
use glam::DVec3;

/// Largest number of free axes for a Cholesky factor in static solves: it takes about 0.3 GB and 2 s there.
const MOST_AXES_FACTORED: f64 = 2e5;

/// Maximum free axes of a dynamic solve that takes a Cholesky factor after a failure without one, unless set otherwise: it takes half a second at
/// 100,000.
const MOST_AXES_FALLBACK: f64 = 4e4;

/// Free axes from which on a body in space takes multigrid in dynamic steps.
const LEAST_AXES_IN_SPACE: f64 = 4e4;

/// Free axes from which on a planar body takes multigrid. With 1,500 and with 6,000 triangles it
/// takes six sevenths of the time with an incomplete one. It leaves a half and a fifth of its error
/// (`rhexis bench work-precision fig2-dynamic`). A body much smaller is mostly the coarsest level.
const LEAST_AXES_PLANAR: f64 = 1e3;

/// Free axes from which on a planar body that may tear takes multigrid: levels that follow an edit make the step after it long, which
/// under a hand counts more than the others. With 1e3 the slowest of `rhexis bench targets "haptic 1.5k, tearing"` took 2.6 ms, with an
/// incomplete factor it takes 1.2.
const LEAST_AXES_TORN: f64 = 2e3;

/// Preconditioners for a body in this step, by its free axes and the work that its budget has left.
pub(super) fn available<'a>(
    (step, left): (&StepContext, Option<u32>),
    (operator, free, tearing): (&Operator, &FreeAxes, Option<&Tearing>),
    (factor, mixed): (&'a mut Factor, &'a mut MixedSolver),
) -> Available<'a> {
    // By direction.
    let is_auto = step.preconditioner == Preconditioner::Auto;
    let axes: DVec3 = if is_auto { free.iter().sum() } else { DVec3::ZERO };
    let glides = tearing.is_some_and(|tearing| tearing.mode == TearMode::Glide);
    let axes_of_levels = match (operator.is_planar() && axes.z == 0.0, tearing) {
        (false, _) => LEAST_AXES_IN_SPACE,
        (true, None) => LEAST_AXES_PLANAR,
        (true, Some(_)) => LEAST_AXES_TORN,
    };
    let is_affordable = left.is_none_or(|left| left >= 2 * work::FACTORED);
    Available {
        factor: use_of_factor(step, axes.element_sum()).filter(|_| is_affordable).map(|when| (factor, when)),
        left,
        mixed: mixed_preconditioner(step, axes.element_sum(), axes_of_levels)
            .and_then(|kind| if glides { without_levels(step, kind) } else { Some(kind) })
            .map(|kind| (mixed, kind)),
    }
}

/// The preconditioner of a body whose tips glide: the weights of multigrid's levels stand for places in the rest shape, and a glide moves a
/// vertex there without another edit.
fn without_levels(step: &StepContext, kind: MixedPreconditioner) -> Option<MixedPreconditioner> {
    match kind {
        MixedPreconditioner::Multigrid => (!step.is_static).then_some(MixedPreconditioner::IncompleteCholesky),
        kind => Some(kind),
    }
}

fn use_of_factor(step: &StepContext, axes: f64) -> Option<FactorUse> {
    match step.preconditioner {
        Preconditioner::BlockJacobi | Preconditioner::IncompleteCholesky | Preconditioner::Multigrid => None,
        Preconditioner::Auto if step.is_static => (axes <= MOST_AXES_FACTORED).then_some(FactorUse::First),
        Preconditioner::Auto => (axes <= MOST_AXES_FALLBACK).then_some(FactorUse::Fallback),
        Preconditioner::Cholesky => Some(FactorUse::First),
    }
}

/// Preconditioner of the mixed-precision solver. Static solves use multigrid or none, as their residuals need double precision. Dynamic
/// solves use multigrid above `axes_of_levels` free axes: fewer for planar bodies, whose levels last from solve to solve.
fn mixed_preconditioner(step: &StepContext, axes: f64, axes_of_levels: f64) -> Option<MixedPreconditioner> {
    if step.is_static {
        let is_multigrid = match step.preconditioner {
            Preconditioner::Multigrid => true,
            Preconditioner::Auto => axes > MOST_AXES_FACTORED,
            _ => false,
        };
        return is_multigrid.then_some(MixedPreconditioner::Multigrid);
    }
    if step.precision == Precision::Double {
        return None;
    }
    Some(match step.preconditioner {
        Preconditioner::BlockJacobi => MixedPreconditioner::BlockJacobi,
        Preconditioner::Multigrid => MixedPreconditioner::Multigrid,
        Preconditioner::Auto if axes > axes_of_levels => MixedPreconditioner::Multigrid,
        Preconditioner::Auto | Preconditioner::IncompleteCholesky | Preconditioner::Cholesky => {
            MixedPreconditioner::IncompleteCholesky
        }
    })
}
