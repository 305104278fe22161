//! What a first guess is worth.

use crate::systems::parallel;
use glam::{DVec2, DVec3};

/// Scales the free part of a guess `x` to the least energy of its error: by x·b/x·A·x, with b as `without` \[N\], the residual of
/// no guess. The displacement of the last step is a good guess but for its length where a hand speeds up or stops, and where tissue has
/// sprung open. `of_guess` makes the residual \[N\] of the guess from what is in `residual`, which is brought along. Returns its squared
/// norm, or `None` where the guess was of no use and is none now.
pub fn fit(
    x: &mut [DVec3],
    free: &[DVec3],
    without: &[DVec3],
    residual: &mut [DVec3],
    of_guess: impl Fn(usize, DVec3) -> DVec3 + Sync,
    (pairs, partials): (&mut Vec<DVec2>, &mut Vec<f64>),
) -> Option<f64> {
    let works = parallel::sum_rows(residual, pairs, |v, r| {
        *r = of_guess(v, *r);
        let x = x[v] * free[v];
        DVec2::new(x.dot(without[v]), x.dot(without[v] - *r))
    });
    let scale = works.x / works.y;
    if !(works.y > 0.0 && works.y.is_finite() && scale.is_finite()) {
        parallel::for_rows(x, |v, x| *x *= DVec3::ONE - free[v]);
        residual.copy_from_slice(without);
        return None;
    }
    parallel::for_rows(x, |v, x| *x *= DVec3::ONE + free[v] * (scale - 1.0));
    Some(parallel::sum_rows(residual, partials, |v, r| {
        *r = without[v] - (without[v] - *r) * scale;
        r.length_squared()
    }))
}
