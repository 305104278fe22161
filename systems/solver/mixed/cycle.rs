//! The multigrid cycle, in single precision, as the preconditioner of iterations in double precision: for static solves and exact
//! tangents. It is made of the rotated tangent, which is never indefinite.

use super::cg::Precondition;
use super::{MixedSolver, empty};
use crate::components::FreeAxes;
use crate::systems::parallel;
use crate::systems::solver::{Operator, scale_to_single};
use glam::{DVec3, Vec4};

impl MixedSolver {
    /// Before iterations with [`MixedSolver::cycle`].
    pub fn begin_cycles(&mut self, operator: &Operator, free: &FreeAxes) {
        self.assemble(operator, free, false);
        let mesh = (operator.vertices, operator.triangles, operator.topology);
        self.multigrid.set_up(&self.partition, &self.order, mesh, &self.matrix);
        let (n, vectors) = (free.len(), &mut self.vectors);
        empty(&mut vectors.xr, n);
        vectors.xr.resize(n, [Vec4::ZERO; 2]);
        for vector in [&mut vectors.p, &mut vectors.q, &mut vectors.z] {
            empty(vector, n);
            vector.resize(n, Vec4::ZERO);
        }
    }

    /// Iteration limit of a solve with cycles of an earlier operator; `None` where the numbers are of the present one.
    pub fn most_cycles(&self, gain: f64) -> Option<u32> {
        self.multigrid.is_earlier().then(|| self.multigrid.most(gain))
    }

    /// After iterations with the cycle that have reduced the residual to the part `gain` of itself.
    pub fn end_cycles(&mut self, iterations: u32, gain: f64, is_solved: bool) {
        self.multigrid.has_served(iterations, gain);
        if !is_solved {
            self.multigrid.renew(&self.partition, &self.matrix);
        }
    }

    /// The answer z \[mm\] of a cycle to a residual r \[N\], zero along prescribed axes; returns r·z.
    pub fn cycle(&mut self, r: &[DVec3], z: &mut [DVec3], partials: &mut Vec<f64>) -> f64 {
        let scale = scale_to_single(r);
        let Self { order, vectors, multigrid, .. } = self;
        parallel::for_rows(&mut vectors.xr, |row, xr| {
            xr[1] = (r[order.vertex[row] as usize] * scale).as_vec3().extend(0.0);
        });
        multigrid.forward_sweep(0.0, vectors);
        multigrid.backward_sweep(0.0, vectors);
        parallel::sum_rows(z, partials, |v, z| {
            *z = vectors.p[order.row[v] as usize].truncate().as_dvec3() / scale;
            r[v].dot(*z)
        })
    }
}
