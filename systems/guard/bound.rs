//! Cheap upper bound of the spurious energy, for solves in which no deformation gradient changes much.

use crate::components::{Frames, Increment};
use crate::math::{ElementState, Faded};
use crate::storage::Triangles;
use crate::systems::kernels::membrane_lanes::Far;
use crate::systems::parallel;
use glam::DVec2;

/// Change of the deformation gradient above which the bound does not hold, for a triangle that is not crushed. A smaller change turns by
/// less than 0.1 rad.
const FAR_GRADIENT: f64 = 0.1;

/// Upper bound \[mJ\] of the spurious energy of the triangles; infinite where the gradient of one changes by more than [`FAR_GRADIENT`].
///
/// Of a stretch the tangent leaves out no more than a²/t, with the change a of the triangle's gradient and t twice its [mean
/// stretch](uncrushed). The sum Σ V·(|T|·a²/t + (a²/t)·C·(a²/t)) is bounded by the stored energy and Schwarz's inequality.
pub(super) fn bound(
    (increment, triangles, frames): (&Increment, &Triangles, &Frames),
    (twice_stored, stiffest): (f64, f64),
    partials: &mut Vec<f64>,
    pairs: &mut Vec<DVec2>,
) -> f64 {
    let least = parallel::least(frames.len(), partials, |t| uncrushed(&frames.state(t), frames.is_planar()));
    let (Triangles { corners, rest, .. }, displacement) = (triangles, &increment.delta);
    let far = Far { corners, rest, displacement, from: FAR_GRADIENT * least };
    let DVec2 { x: count, y: fourth } = parallel::sum_chunks(&mut vec![(); triangles.len()], pairs, &far);
    if count > 0.0 {
        return f64::INFINITY;
    }
    let missed = stiffest * fourth / (4.0 * least * least);
    (twice_stored * missed).sqrt() + missed
}

/// Mean stretch between 0 and 1, reduced where one stretch is negative (a mirror image). Zero where the law fades: any change may turn the
/// triangle over.
fn uncrushed(state: &ElementState, is_planar: bool) -> f64 {
    let stretch = state.polar.stretch;
    if Faded::at(stretch, is_planar).is_some() {
        return 0.0;
    }
    let (deviator, shear) = (stretch.xx - stretch.yy, 2.0 * stretch.xy);
    let (trace, mirrored) = (stretch.trace(), (deviator * deviator + shear * shear).sqrt());
    (0.5 * trace * (trace / mirrored).min(1.0)).clamp(0.0, 1.0)
}
