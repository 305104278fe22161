//! Preconditioned conjugate gradients in single precision, scalar products in double, passes over the vectors fused with the
//! preconditioner's.

use super::empty;
use super::matrix::Matrix;
use super::partition::Partition;
use crate::components::Six;
use crate::systems::solver::CgError;
use crate::systems::solver::estimate::Limits;
use crate::systems::solver::recurrence::{self, Reached, Vectors as _, iterate};
use glam::{DVec2, Vec4};
use smallvec::SmallVec;

/// The vectors, in the order of the preconditioner.
#[derive(Debug, Default)]
pub(super) struct Vectors {
    /// Answer and residual: they change in one pass.
    pub xr: Vec<[Vec4; 2]>,
    /// Search direction.
    pub p: Vec<Vec4>,
    /// Operator times direction.
    pub q: Vec<Vec4>,
    /// Preconditioned residual.
    pub z: Vec<Vec4>,
    /// Sums per chunk of rows.
    pub partials: Vec<f64>,
    /// Sums of r·r and r·z per chunk of rows.
    pub pairs: Vec<DVec2>,
}

/// A preconditioner M, with the vector passes of an iteration around it.
pub(super) trait Precondition {
    /// Least step length of a sound M, whose steps are no shorter than the inverse of the largest eigenvalue of M⁻¹·A.
    const LEAST_STEP: f64 = 0.0;

    /// x += α·p, r −= α·q and as much of z = M⁻¹·r as it takes to know r·z; returns r·r and r·z.
    fn forward_sweep(&mut self, alpha: f32, vectors: &mut Vectors) -> DVec2;

    /// The rest of z = M⁻¹·r, then p = z + β·p.
    fn backward_sweep(&mut self, beta: f32, vectors: &mut Vectors);
}

/// Solves A·x = r for the `r` in `vectors`, whose `x` is zero, up to the limits.
///
/// # Errors
/// See [`CgError`].
pub(super) fn solve<P: Precondition>(
    matrix: &mut Matrix,
    partition: &Partition,
    preconditioner: &mut P,
    vectors: &mut Vectors,
    limits: &Limits,
) -> Result<Reached, CgError> {
    let n = vectors.xr.len();
    for zero in [&mut vectors.p, &mut vectors.q, &mut vectors.z] {
        empty(zero, n);
        zero.resize(n, Vec4::ZERO);
    }
    let mut single = Single { matrix, partition, preconditioner, vectors, of_patches: SmallVec::new() };
    let start = single.advance(0.0);
    iterate(&mut single, start, limits)
}

/// Vectors in single precision.
struct Single<'a, P> {
    matrix: &'a mut Matrix,
    partition: &'a Partition,
    preconditioner: &'a mut P,
    vectors: &'a mut Vectors,
    /// Answers of the patches in touch with rigid obstacles.
    of_patches: SmallVec<[Six; 1]>,
}

impl<P: Precondition> recurrence::Vectors for Single<'_, P> {
    fn least_step(&self) -> f64 {
        P::LEAST_STEP
    }

    fn next_direction(&mut self, beta: f64) {
        self.preconditioner.backward_sweep(beta as f32, self.vectors);
        let p = &mut self.vectors.p;
        for (patch, answer) in self.matrix.between.iter().flat_map(|between| between.patches()).zip(&self.of_patches) {
            patch.spread(answer, |row, motion| p[row] += motion.as_vec3().extend(0.0));
        }
    }

    fn multiply(&mut self) -> f64 {
        let Vectors { p, q, partials, .. } = &mut *self.vectors;
        self.matrix.apply(self.partition, p, q, partials)
    }

    fn is_at_end(&mut self, _: f64, _: f64) -> bool {
        false
    }

    fn advance(&mut self, alpha: f64) -> DVec2 {
        let mut sums = self.preconditioner.forward_sweep(alpha as f32, self.vectors);
        self.of_patches.clear();
        for patch in self.matrix.between.iter().flat_map(|between| between.patches()) {
            let (answer, part) = patch.answer(|row| self.vectors.xr[row][1].truncate().as_dvec3());
            self.of_patches.push(answer);
            sums.y += part;
        }
        sums
    }
}
