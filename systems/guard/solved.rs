//! Spurious energy of a fraction of a solve's answer.

use super::lanes::Whole;
use super::{shorter, slack_energy};
use crate::components::{FreeAxes, Increment};
use crate::math::{ElementState, Sym2};
use crate::settings::Tangent;
use crate::systems::bending::BendingPasses;
use crate::systems::forces::element::BodyLaw;
use crate::systems::kernels::membrane;
use crate::systems::parallel;
use crate::systems::solver::Operator;
use glam::{DVec2, DVec3};

/// A body and the solve's answer.
#[derive(Clone, Copy)]
pub(super) struct Solved<'a> {
    pub(super) operator: Operator<'a>,
    pub(super) increment: &'a Increment,
    /// Displacement that is judged \[mm\]: the solve's answer, or that of a local relaxation.
    pub(super) delta: &'a [DVec3],
    pub(super) free: &'a FreeAxes,
    pub(super) law: BodyLaw<'a>,
    /// Residual of the solve, b − A·δ \[N\].
    pub(super) residual: &'a [DVec3],
    /// Whether the ledger already holds the spurious energy and the dissipation of the step's earlier solves.
    pub(super) is_counted: bool,
    /// Whether the body is damped and an earlier solve of the step has displaced it.
    pub(super) is_damped_before: bool,
    /// The coefficient of drag over dt \[N/mm³\].
    pub(super) drag: f64,
    /// 1/dt \[1/ms\].
    pub(super) inv_effective_dt: f64,
}

/// Energies by which a fraction of an answer is judged \[mJ\].
pub(super) struct Bounds {
    /// Spurious energy of earlier solves.
    pub(super) before: f64,
    /// Work of the residual.
    pub(super) work: f64,
    /// Work of the step's right-hand side along the whole answer ([`Solved::unsolved`]).
    pub(super) unsolved: f64,
    /// Limit of the spurious energy.
    pub(super) most: f64,
}

/// Energies of membrane and bending along the whole answer \[mJ\].
pub(super) struct Strained {
    /// Spurious energy before dissipation.
    pub(super) spurious: f64,
    /// Energy of damping in the incremental potential: the work of the stress of earlier solves, and half of that of its own.
    pub(super) damped: f64,
}

/// Working memory of the sums over a body.
pub(super) struct Sums<'a> {
    pub(super) partials: &'a mut Vec<f64>,
    pub(super) pairs: &'a mut Vec<DVec2>,
    pub(super) passes: &'a mut BendingPasses,
    /// Of the operator's products.
    pub(super) corner: &'a mut Vec<[DVec3; 3]>,
    /// −∇Φ along free axes \[N\] where a Newton correction starts.
    pub(super) pull: &'a mut Vec<DVec3>,
    /// Operator times a way \[N\].
    pub(super) product: &'a mut Vec<DVec3>,
}

impl Solved<'_> {
    /// Largest fraction of the answer, down to `least` or else zero, whose spurious energy is below the limit, with that energy. The
    /// caller compares that of zero with the limit.
    pub(super) fn shorten(&self, bounds: &Bounds, least: f64, sums: &mut Sums<'_>) -> (f64, f64) {
        let &Bounds { before, work, unsolved, most } = bounds;
        let mut fraction = 1.0;
        loop {
            fraction = shorter(fraction);
            if fraction < least {
                fraction = 0.0;
            }
            let spurious_energy = self.spurious_energy(fraction, sums);
            let sum = before + spurious_energy + fraction * (work - (1.0 - fraction) * unsolved);
            if sum <= most || fraction == 0.0 {
                return (fraction, sum);
            }
        }
    }

    pub(super) fn volume(&self, t: usize) -> f64 {
        self.operator.triangles.rest[t].area * self.operator.triangles.thickness[t]
    }

    pub(super) fn stored(&self, t: usize, state: &ElementState) -> f64 {
        self.law.stored(self.operator.triangles, t, state)
    }

    /// Spurious energy of a triangle \[mJ\] by this `fraction` of the answer.
    pub(super) fn of_triangle(&self, t: usize, fraction: f64) -> f64 {
        self.of_triangle_and_damped(t, fraction).x
    }

    /// Spurious energy of a triangle, and energy of damping in the incremental potential there \[mJ\].
    fn of_triangle_and_damped(&self, t: usize, fraction: f64) -> DVec2 {
        let Self { operator: Operator { vertices, triangles, frames, .. }, .. } = self;
        let rest = &triangles.rest[t];
        let corners = triangles.corners[t].map(|v| v as usize);
        let u = corners.map(|v| self.delta[v] * fraction);
        let x = corners.map(|v| vertices.position[v]);
        let x = [x[0] + u[0], x[1] + u[1], x[2] + u[2]];
        let start = frames.state(t);
        let (volume, end) = (self.volume(t), self.law.element(self.operator.triangles, t).energy(x));
        let rate = membrane::stretch_rate(&start.polar, rest, u);
        let (pull, damped) = (self.operator.element(t).apply(u), self.damped(t, rate));
        let work = volume * start.stress.contract(rate) + damped + (0..3).map(|i| pull[i].dot(u[i])).sum::<f64>();
        let own = 0.5 * volume * self.viscous_stress(t, rate).contract(rate);
        DVec2::new(end - self.stored(t, &start) - work, damped + own)
    }

    /// [`damped`](Self::damped) where a triangle goes this `fraction` of the answer.
    pub(super) fn damped_along(&self, t: usize, fraction: f64) -> f64 {
        if !self.is_damped_before {
            return 0.0;
        }
        let Operator { triangles, frames, .. } = self.operator;
        let u = triangles.corners[t].map(|v| self.delta[v as usize] * fraction);
        self.damped(t, membrane::stretch_rate(&frames.state(t).polar, &triangles.rest[t], u))
    }

    /// Stress of damping \[MPa\] by a stretch rate.
    fn viscous_stress(&self, t: usize, rate: Sym2) -> Sym2 {
        let Operator { triangles, frames, viscosity, .. } = self.operator;
        frames.stiffness(triangles, t).coupled_stress(frames.coupling(t), rate * viscosity)
    }

    /// Work along a stretch rate \[mJ\] of the damping stress from the step's earlier solves, and in these where they are not
    /// counted.
    pub(super) fn damped(&self, t: usize, rate: Sym2) -> f64 {
        let Operator { triangles, frames, .. } = self.operator;
        if !self.is_damped_before {
            return 0.0;
        }
        let u = triangles.corners[t].map(|v| self.increment.displacement[v as usize]);
        let earlier = membrane::stretch_rate(&frames.state(t).polar, &triangles.rest[t], u);
        let along = if self.is_counted { rate } else { rate + earlier };
        self.volume(t) * self.viscous_stress(t, earlier).contract(along)
    }

    /// Spurious energy of this `fraction` of the answer \[mJ\].
    pub(super) fn spurious_energy(&self, fraction: f64, sums: &mut Sums<'_>) -> f64 {
        let strained = self.strained(fraction, sums);
        self.less_dissipated(strained, fraction, sums.partials)
    }

    /// Spurious energy \[mJ\] of this `fraction` of the answer, by that of membrane and bending.
    pub(super) fn less_dissipated(&self, strained: f64, fraction: f64, partials: &mut Vec<f64>) -> f64 {
        if strained == 0.0 { 0.0 } else { strained - self.dissipated(fraction, partials) }
    }

    /// Spurious energy of membrane and bending \[mJ\] along this `fraction` of the answer, before dissipation.
    pub(super) fn strained(&self, fraction: f64, sums: &mut Sums<'_>) -> f64 {
        let Self { operator: Operator { triangles, tangent, .. }, .. } = self;
        let is_alike = fraction == 1.0 && self.law.fibres.is_none() && *tangent == Tangent::Rotated;
        let sum = if is_alike {
            let (frames, mut rows) = (self.operator.frames, vec![(); triangles.len()]);
            if frames.is_planar() {
                parallel::sum_chunks(&mut rows, sums.partials, &Whole { solved: self, state: &frames.flat })
            } else {
                parallel::sum_chunks(&mut rows, sums.partials, &Whole { solved: self, state: &frames.solid })
            }
        } else {
            parallel::sum(triangles.len(), sums.partials, |t| self.of_triangle(t, fraction))
        };
        sum + self.bent(fraction, sums)
    }

    /// Energies of membrane and bending along the whole answer \[mJ\].
    pub(super) fn strained_and_damped(&self, sums: &mut Sums<'_>) -> Strained {
        let mut rows = vec![(); self.operator.triangles.len()];
        let sum = parallel::sum_rows(&mut rows, sums.pairs, |t, ()| self.of_triangle_and_damped(t, 1.0));
        Strained { spurious: sum.x + self.bent(1.0, sums), damped: sum.y }
    }

    /// Dissipation by backward Euler and drag \[mJ\] along this `fraction` of the answer, less the work of the motion at the
    /// start of the step.
    pub(super) fn dissipated(&self, fraction: f64, partials: &mut Vec<f64>) -> f64 {
        let Self { operator: Operator { vertices, triangles, topology, .. }, increment, .. } = self;
        let dissipated = |v: usize| {
            let delta = self.delta[v] * fraction;
            let (gained, before) = (delta * self.inv_effective_dt, increment.start_velocity[v]);
            let gone = increment.displacement[v];
            let (earlier, dragged) = if self.is_counted {
                (0.0, 0.0)
            } else {
                (0.5 * (gone * self.inv_effective_dt - before).length_squared(), gone.length_squared())
            };
            let drag = if self.drag > 0.0 { self.drag * topology.vertex_area(triangles, v as u32) } else { 0.0 };
            vertices.mass[v] * (earlier + 0.5 * gained.length_squared() - gained.dot(before))
                + drag * (dragged + delta.dot(gone + delta))
        };
        parallel::sum(vertices.len(), partials, dissipated)
    }

    /// u·A·u \[mJ\] of the rows of free axes, with the membrane and the masses of the step's matrix A: the right-hand side's work along the
    /// answer. Of a fraction p of the answer, p·(1 − p) of it is unsolved, and is no work of holds and loads.
    pub(super) fn unsolved(&self, partials: &mut Vec<f64>) -> f64 {
        let Operator { vertices, triangles, inertia, .. } = self.operator;
        let along = |v: usize| self.delta[v] * self.free[v];
        let pulls = parallel::sum(triangles.len(), partials, |t| {
            let corners = triangles.corners[t].map(|v| v as usize);
            let pull = self.operator.element(t).apply(corners.map(|v| self.delta[v]));
            (0..3).map(|i| pull[i].dot(along(corners[i]))).sum()
        });
        let masses = |v: usize| vertices.mass[v] * inertia * along(v).length_squared();
        let sum = pulls + parallel::sum(vertices.len(), partials, masses);
        if sum.is_finite() { sum } else { 0.0 }
    }

    /// Energy of the body where the solve starts \[mJ\]: stored, half of `twice_stored`, of bending and of motion, and the `slack` allowance.
    pub(super) fn energy(&self, twice_stored: f64, slack: f64, partials: &mut Vec<f64>) -> f64 {
        let Operator { vertices, triangles, frames, .. } = self.operator;
        let motion = |v: usize| 0.5 * vertices.mass[v] * vertices.velocity[v].length_squared();
        let motion = parallel::sum(vertices.len(), partials, motion);
        let bent = self.operator.folds.map_or(0.0, |folds| folds.stored(partials));
        if frames.stiffened.is_empty() {
            return 0.5 * twice_stored + bent + slack + motion;
        }
        let stored = parallel::sum(triangles.len(), partials, |t| self.stored(t, &frames.state(t)));
        stored + bent + slack_energy(triangles, |t| frames.stiffness(triangles, t)) + motion
    }
}
