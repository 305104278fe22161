//! Residual reduction by a first guess.

use super::{CgError, Operator};
use crate::components::FreeAxes;
use crate::systems::bending::BendingPasses;
use crate::systems::parallel;
use glam::{DVec2, DVec3};

/// Fills `without` with the residual \[N\] of a zero guess, b − A·x for the prescribed motion in `x`, and returns its squared norm.
/// `product` is scratch.
///
/// # Errors
/// [`CgError::NotFinite`] where b, the motion or the operator holds a NaN or an infinity.
pub(super) fn residual_without(
    operator: &Operator,
    (x, free, b): (&[DVec3], &FreeAxes, &[DVec3]),
    without: &mut [DVec3],
    product: &mut [DVec3],
    (partials, passes): (&mut Vec<f64>, &mut BendingPasses),
) -> Result<f64, CgError> {
    parallel::for_rows(without, |v, p| *p = x[v] * (DVec3::ONE - free[v]));
    operator.apply_sparse(without, product, passes);
    let norm_sq = parallel::sum_rows(without, partials, |v, p| {
        *p = (b[v] - product[v]) * free[v];
        p.length_squared()
    });
    if norm_sq.is_finite() { Ok(norm_sq) } else { Err(CgError::NotFinite { iteration: 0 }) }
}

/// Whether the guess is zero along free axes.
pub(super) fn is_none(x: &[DVec3], free: &FreeAxes) -> bool {
    x.iter().zip(free).all(|(x, free)| *x * *free == DVec3::ZERO)
}

/// Scales the free part of a guess `x` to the least energy of its error: by x·b/x·A·x, with b as `without` \[N\], the residual of
/// no guess. The displacement of the last step is a good guess but for its length where a hand speeds up or stops, and where tissue has
/// sprung open. `of_guess` has the residual \[N\] of the guess, which takes the place of `without`, scaled. Returns its squared norm, or
/// `None` where the guess was of no use and is none now, and `without` as it was.
pub(super) fn fit(
    x: &mut [DVec3],
    free: &FreeAxes,
    without: &mut [DVec3],
    of_guess: impl Fn(usize, DVec3) -> DVec3 + Sync,
    (pairs, partials): (&mut Vec<DVec2>, &mut Vec<f64>),
) -> Option<f64> {
    let works = parallel::sum_rows(without, pairs, |v, without| {
        let x = x[v] * free[v];
        DVec2::new(x.dot(*without), x.dot(*without - of_guess(v, *without)))
    });
    let scale = works.x / works.y;
    if !(works.y > 0.0 && works.y.is_finite() && scale.is_finite()) {
        parallel::for_rows(x, |v, x| *x *= DVec3::ONE - free[v]);
        return None;
    }
    parallel::for_rows(x, |v, x| *x *= DVec3::ONE + free[v] * (scale - 1.0));
    Some(parallel::sum_rows(without, partials, |v, r| {
        *r = *r - (*r - of_guess(v, *r)) * scale;
        r.length_squared()
    }))
}
