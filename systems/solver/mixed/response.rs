//! Response of a body to further loads, with the single-precision operator and the preconditioner of its last solve. Later solves do not
//! depend on it.

use super::cg::solve;
use super::{MixedPreconditioner, MixedSolver, size};
use crate::storage::{Topology, Triangles};
use crate::systems::parallel;
use crate::systems::solver::CgError;
use crate::systems::solver::estimate::Limits;
use crate::systems::solver::recurrence::Reached;
use glam::{DVec3, Vec4};

impl MixedSolver {
    /// Whether the last solve of the step has left an operator of these triangles, for [`product`](Self::product) and [`correct`](Self::correct).
    pub fn has_operator_of(&self, triangles: &Triangles, topology: &Topology) -> bool {
        self.ready.is_some() && self.is_of(&triangles.corners, topology)
    }

    /// Leaves no operator to be used: the next solve is of another.
    pub fn forget_operator(&mut self) {
        self.ready = None;
    }

    /// `out` = A·x \[N\] along free axes, for an `x` \[mm\] by vertex that is zero along the others.
    pub fn product(&mut self, x: &[DVec3], out: &mut Vec<DVec3>) {
        let Self { matrix, partition, order, vectors, .. } = self;
        size(&mut vectors.p, x.len(), Vec4::ZERO);
        size(&mut vectors.q, x.len(), Vec4::ZERO);
        let (vertex, row) = (&order.vertex, &order.row);
        parallel::for_rows(&mut vectors.p, |row, p| *p = x[vertex[row] as usize].as_vec3().extend(0.0));
        matrix.apply(partition, &vectors.p, &mut vectors.q, &mut vectors.partials);
        out.resize(x.len(), DVec3::ZERO);
        let q = &vectors.q;
        parallel::for_rows(out, |v, out| *out = q[row[v] as usize].truncate().as_dvec3());
    }

    /// Brings `x` nearer to the answer by a residual b − A·x \[N\], until the squared energy norm of the error is `energy` \[mJ\] or `most`
    /// iterations are done; the residual follows. Returns how many it took.
    ///
    /// # Errors
    /// [`CgError`] where single precision has come to nothing; `x` and the residual are then as they were.
    pub fn correct(
        &mut self,
        (energy, most): (f64, u32),
        residual: &mut [DVec3],
        x: &mut [DVec3],
    ) -> Result<u32, CgError> {
        let Some(ready) = self.ready else { return Ok(0) };
        let norm_sq: f64 = residual.iter().map(|r| r.length_squared()).sum();
        if norm_sq == 0.0 {
            return Ok(0);
        }
        if !norm_sq.is_finite() {
            return Err(CgError::NotFinite { iteration: 0 });
        }
        let norm = norm_sq.sqrt();
        self.set_residual(residual, norm);
        let limits = Limits::by_energy(energy / norm_sq, most);
        let Self { matrix, partition, vectors, jacobi, incomplete, multigrid, .. } = self;
        let Reached { iterations, .. } = match ready {
            MixedPreconditioner::BlockJacobi => solve(matrix, partition, &mut **jacobi, vectors, &limits),
            MixedPreconditioner::IncompleteCholesky => solve(matrix, partition, &mut **incomplete, vectors, &limits),
            MixedPreconditioner::Multigrid => solve(matrix, partition, &mut **multigrid, vectors, &limits),
        }?;
        self.add_to(x, norm);
        let (row, xr) = (&self.order.row, &self.vectors.xr);
        parallel::for_rows(residual, |v, r| *r = xr[row[v] as usize][1].truncate().as_dvec3() * norm);
        Ok(iterations)
    }
}
