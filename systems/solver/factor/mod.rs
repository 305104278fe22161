//! A body's Cholesky factor through the steps: when it serves, when it is renewed and when it is not worth it.
//!
//! A factor is as good as the body is near the state it was made at. In a dynamic step it is renewed aside, from a snapshot of the
//! operator, and takes effect a fixed number of solves later. So no step waits, and no result depends on threads. Meanwhile the old
//! one serves, across edits by its [`EditMap`]. A static solve, which can wait, renews it on the spot.

mod state;

use super::block_jacobi::invert;
pub(super) use super::cholesky::NoFactor;
use super::cholesky::{Cholesky, FactorPrecision};
use super::edit_map::EditMap;
use super::operator_copy::OperatorCopy;
use super::rotation_warp::RotationWarp;
use super::scale_to_single;
use super::{MixedPreconditioner, Operator};
use crate::components::FreeAxes;
use crate::storage::EditRecord;
use crate::systems::parallel::{self, Aside};
use glam::{DMat3, DVec3, Vec4};
pub use state::FactorState;
use state::Origin;
use std::sync::Arc;

/// Iterations of a dynamic solve from which on a new factor is made: with a present one it takes one or two.
const STALE: u32 = 4;

/// Cost of a solve without the factor, the baseline (`rhexis bench ladder`).
struct Baseline {
    /// Baseline iterations that cost about as much as an iteration with the factor.
    iteration_cost: u32,
    /// Baseline iterations that cost as much as the preparation of the baseline's preconditioner.
    prepared: u32,
    /// Iterations assumed for the first solve.
    first: u32,
}

/// With an incomplete factor, made for every solve: the first as on a sheet of 500 triangles.
const INCOMPLETE: Baseline = Baseline { iteration_cost: 5, prepared: 8, first: 60 };
/// With multigrid, whose numbers last.
const LEVELS: Baseline = Baseline { iteration_cost: 2, prepared: 0, first: 8 };

/// Consecutive early-stale factors after which factorisation pauses: each stale before it has served for as long as it took to make.
const MOST_EARLY_STALE: u32 = 3;
/// Solves without a factor after [`MOST_EARLY_STALE`] stale ones in a row. A factor after such a pause is only tried once; if stale as soon, the
/// next pause is twice as long. A trial makes a step twice as long as others, and tissue that bends and tears as it did has no use for
/// one.
const PAUSE: u32 = 512;
/// Maximum doublings of the pause: after 16,384 solves there is always another trial.
const PAUSE_DOUBLINGS: u32 = 5;
/// Solves with factors made on the spot after one that has come to nothing without: then solves are as before. Tissue
/// that was crushed has come free by then, or costs one such solve more in so many.
const FACTORED_NOW: u32 = 16;

/// Solves from a snapshot to the day its factor takes effect: a 1,500-triangle sheet steps 20 times in 4 ms, and is factored in
/// three; the larger, the more.
fn delay(free: &FreeAxes) -> u32 {
    16 + free.len() as u32 / 200
}

/// A body's factor. *State*: its matrix is saved, and how long it has served.
#[derive(Default)]
pub struct Factor {
    current: Option<Box<InUse>>,
    pending: Option<Pending>,
    /// Iterations of the last solve without it; zero before the first.
    without: u32,
    stale_count: u32,
    pause: u32,
    /// Pauses since a factor has last served for long.
    pauses: u32,
    /// Solves that are still to be served by factors made on the spot.
    factored_now: u32,
}

struct InUse {
    cholesky: Cholesky,
    edit_map: EditMap,
    rotation_warp: RotationWarp,
    /// Solves it has served.
    served: u32,
    is_worse_than_none: bool,
    /// The vertices that edits have touched: inverse block and free axes.
    touched: Vec<(usize, DMat3, DVec3)>,
}

struct Pending {
    job: Aside<Result<Cholesky, NoFactor>>,
    /// Data that the pending factor is made of.
    origin: Origin,
    edit_map: EditMap,
    rotation_warp: RotationWarp,
    /// Solves until it takes effect.
    left: u32,
}

impl Pending {
    /// Begins to make the factor.
    fn new(origin: Origin, edit_map: EditMap, rotation_warp: RotationWarp, left: u32) -> Self {
        Self { job: Aside::new(origin.clone(), Origin::factor), origin, edit_map, rotation_warp, left }
    }
}

impl InUse {
    fn new(cholesky: Cholesky, edit_map: EditMap, rotation_warp: RotationWarp) -> Box<Self> {
        let (served, touched) = (0, Vec::new());
        Box::new(Self { cholesky, edit_map, rotation_warp, served, is_worse_than_none: false, touched })
    }

    /// Whether mesh and turns are those it was made at.
    fn is_plain(&self) -> bool {
        self.edit_map.is_empty() && self.rotation_warp.turns().is_empty()
    }

    /// Takes the residual `r`, given by vertex, as far down as it takes to know its scalar product with the answer of the old mesh.
    #[inline]
    fn forward_sweep(&mut self, r: impl Fn(usize) -> DVec3, vertex_count: usize) -> f64 {
        let Self { cholesky, edit_map, rotation_warp, .. } = self;
        if !edit_map.is_empty() {
            cholesky.clear();
            for v in 0..vertex_count {
                let r = r(v);
                edit_map.links(v).iter().for_each(|&(old, weight)| cholesky.add(old as usize, r * weight));
            }
        } else if rotation_warp.turns().is_empty() {
            (0..vertex_count).for_each(|v| cholesky.put(v, r(v)));
        } else {
            rotation_warp.turns().iter().enumerate().for_each(|(v, turn)| cholesky.put(v, turn.transpose() * r(v)));
        }
        cholesky.forward_sweep()
    }

    /// The rest of the way; hands that answer for every vertex to `z`.
    #[inline]
    fn backward_sweep(&mut self, vertex_count: usize, mut z: impl FnMut(usize, DVec3)) {
        let Self { cholesky, edit_map, rotation_warp, .. } = self;
        cholesky.backward_sweep();
        if !edit_map.is_empty() {
            for v in 0..vertex_count {
                z(v, edit_map.links(v).iter().map(|&(old, weight)| cholesky.part(old as usize) * weight).sum());
            }
        } else if rotation_warp.turns().is_empty() {
            (0..vertex_count).for_each(|v| z(v, cholesky.part(v)));
        } else {
            rotation_warp.turns().iter().enumerate().for_each(|(v, turn)| z(v, *turn * cholesky.part(v)));
        }
    }

    /// Whether it belongs to a body with these free axes: away from edits they are those it was made for.
    fn fits(&self, free: &FreeAxes) -> bool {
        let known = self.cholesky.free();
        if self.edit_map.is_empty() {
            return known == free;
        }
        let edit_map = &self.edit_map;
        let is_same = |v: usize| edit_map.is_touched(v) || known[edit_map.links(v)[0].0 as usize] == free[v];
        edit_map.vertex_count() == free.len() && (0..free.len()).all(is_same)
    }
}

impl Factor {
    /// Whether there is a factor of an operator with these triangles and free axes.
    pub fn is_of(&self, corners: &[[u32; 3]], free: &FreeAxes) -> bool {
        self.current.as_ref().is_some_and(|current| current.edit_map.is_empty() && current.cholesky.fits(corners, free))
    }

    /// Factors the operator at its state.
    ///
    /// # Errors
    /// Where the operator is not positive definite, or there is no memory; there is then no factor.
    pub fn renew(&mut self, operator: &Operator, free: &FreeAxes) -> Result<(), NoFactor> {
        self.pending = None;
        let before = self.current.take().map(|current| current.cholesky);
        let cholesky = Cholesky::new(&OperatorCopy::new(operator, free), FactorPrecision::Double, before);
        let cholesky = cholesky.inspect_err(|_| self.factored_now = 0)?;
        self.current = Some(InUse::new(cholesky, EditMap::default(), RotationWarp::new(operator)));
        Ok(())
    }

    /// Factors the operator at its state where a dynamic solve has come to nothing in so many iterations
    /// without a factor. The next solves begin with it, and renew it on the spot.
    ///
    /// # Errors
    /// As [`renew`](Self::renew).
    pub fn factor_now(&mut self, operator: &Operator, free: &FreeAxes, without: u32) -> Result<(), NoFactor> {
        (self.without, self.stale_count, self.pause, self.pauses) = (without, 0, 0, 0);
        self.renew(operator, free)?;
        self.factored_now = FACTORED_NOW;
        Ok(())
    }

    /// Before a dynamic solve: whether one of the last has come to nothing without a factor, as this one might.
    pub fn is_factored_now(&mut self) -> bool {
        if self.factored_now == 0 {
            return false;
        }
        self.factored_now -= 1;
        if self.factored_now == 0 {
            // The iterations of that solve tell nothing of those to come.
            self.without = 0;
        }
        true
    }

    /// Before a dynamic solve: whether it is to use the factor.
    pub fn is_ready(&mut self, operator: &Operator, free: &FreeAxes) -> bool {
        if let Some(pending) = &mut self.pending {
            pending.left -= 1;
            if pending.left == 0
                && let Some(Pending { job, edit_map, rotation_warp, .. }) = self.pending.take()
            {
                match job.finish().and_then(Result::ok) {
                    Some(cholesky) => self.current = Some(InUse::new(cholesky, edit_map, rotation_warp)),
                    // An operator without a factor now will have none in the next solves either.
                    None => self.discard(),
                }
            }
        }
        if self.current.as_ref().is_some_and(|current| !current.fits(free)) {
            (self.current, self.pending) = (None, None);
        }
        if self.pause > 0 {
            self.pause -= 1;
            return false;
        }
        if self.current.is_none() && self.pending.is_none() {
            self.renew_aside(operator, free);
        }
        self.current.as_ref().is_some_and(|current| !current.is_worse_than_none)
    }

    fn renew_aside(&mut self, operator: &Operator, free: &FreeAxes) {
        let origin = Origin::Operator(Arc::new(OperatorCopy::new(operator, free)));
        self.pending = Some(Pending::new(origin, EditMap::default(), RotationWarp::new(operator), delay(free)));
    }

    /// Iterations with it in a dynamic solve at the most: with more it is worse than none, which has `mixed` in its place.
    pub fn most(&self, mixed: Option<MixedPreconditioner>) -> u32 {
        let Baseline { iteration_cost, prepared, first } =
            if mixed == Some(MixedPreconditioner::Multigrid) { LEVELS } else { INCOMPLETE };
        let without = if self.without == 0 { first } else { self.without };
        ((without + prepared) / iteration_cost).max(STALE + 1)
    }

    /// After a dynamic solve with the factor, which might have taken so many iterations at the most.
    pub fn has_served(&mut self, iterations: u32, most: u32, operator: &Operator, free: &FreeAxes) {
        let Some(current) = &mut self.current else { return };
        current.served += 1;
        current.is_worse_than_none |= iterations >= most;
        if iterations <= STALE || self.pending.is_some() {
            return;
        }
        if current.served > delay(free) {
            (self.stale_count, self.pauses) = (0, 0);
        } else {
            self.stale_count += 1;
        }
        if self.stale_count < if self.pauses == 0 { MOST_EARLY_STALE } else { 1 } {
            self.renew_aside(operator, free);
        } else {
            self.discard();
        }
    }

    /// Where it is of no use, or there could be none: there is none for a while.
    pub fn discard(&mut self) {
        (self.current, self.pending, self.stale_count) = (None, None, 0);
        self.pause = PAUSE << self.pauses.min(PAUSE_DOUBLINGS);
        self.pauses = self.pauses.saturating_add(1);
    }

    /// After a dynamic solve without it.
    pub fn has_paused(&mut self, iterations: u32) {
        self.without = iterations;
    }

    /// Follows an edit of the mesh.
    pub fn follow(&mut self, record: &EditRecord) {
        if let Some(current) = &mut self.current {
            current.edit_map.follow(record);
        }
        if let Some(pending) = &mut self.pending {
            pending.edit_map.follow(record);
        }
    }

    /// Before solves with the factor at a state: how far the tissue has turned, or the blocks of the vertices that edits have touched.
    pub fn begin(&mut self, operator: &Operator, free: &FreeAxes) {
        if let Some(InUse { edit_map, rotation_warp, touched, .. }) = self.current.as_deref_mut() {
            if edit_map.is_empty() {
                rotation_warp.update(operator, free);
            } else {
                rotation_warp.clear();
            }
            touched.clear();
            touched.reserve(edit_map.touched().count());
            touched.extend(edit_map.touched().map(|v| (v, invert(operator.diagonal_block(v), free[v]), free[v])));
        }
    }

    /// The factor's answer z \[mm\] to a residual r \[N\], zero along prescribed axes (`free` 0); returns r·z. Without a
    /// factor all of it is zero.
    pub fn apply(&mut self, r: &[DVec3], free: &FreeAxes, z: &mut [DVec3], partials: &mut Vec<f64>) -> f64 {
        let Some(current) = self.current.as_deref_mut() else {
            z.fill(DVec3::ZERO);
            return 0.0;
        };
        let scale = scale_to_single(r);
        current.forward_sweep(|v| r[v] * scale, r.len());
        current.backward_sweep(r.len(), |v, answer| z[v] = answer * free[v] / scale);
        current.touched.iter().for_each(|&(v, inverse, _)| z[v] += inverse * r[v]);
        parallel::sum_rows(z, partials, |v, z| r[v].dot(*z))
    }

    /// The first half of the same in single precision, as far as it takes to know r·z, which is returned: `xr` has r as second entry,
    /// and is numbered by `row`, which gives the row of a vertex. Entries of r are neither near the largest nor near the smallest
    /// numbers.
    pub fn forward_sweep(&mut self, xr: &[[Vec4; 2]], row: &[u32]) -> f64 {
        let Some(current) = self.current.as_deref_mut() else { return 0.0 };
        if current.is_plain() {
            current.cholesky.put_all(|v, axis| xr[row[v] as usize][1][axis]);
            return current.cholesky.forward_sweep();
        }
        let r = |v: usize| xr[row[v] as usize][1].truncate().as_dvec3();
        let of_touched: f64 = current.touched.iter().map(|&(v, inverse, _)| r(v).dot(inverse * r(v))).sum();
        current.forward_sweep(r, row.len()) + of_touched
    }

    /// The second half, after the first for the same `xr`; `z` is numbered by `row` too, and zero along prescribed axes.
    pub fn backward_sweep(&mut self, xr: &[[Vec4; 2]], row: &[u32], z: &mut [Vec4]) {
        let Some(current) = self.current.as_deref_mut() else { return z.fill(Vec4::ZERO) };
        if current.is_plain() {
            current.cholesky.backward_sweep();
            return current.cholesky.parts(|v, axis, part| z[row[v] as usize][axis] = part);
        }
        let r = |v: usize| xr[row[v] as usize][1].truncate().as_dvec3();
        current.backward_sweep(row.len(), |v, answer| z[row[v] as usize] = answer.as_vec3().extend(0.0));
        for &(v, inverse, free) in &current.touched {
            let z = &mut z[row[v] as usize];
            *z = ((z.truncate().as_dvec3() + inverse * r(v)) * free).as_vec3().extend(0.0);
        }
    }
}

impl std::fmt::Debug for Factor {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let served = self.current.as_ref().map(|current| current.served);
        let left = self.pending.as_ref().map(|pending| pending.left);
        f.debug_struct("Factor").field("served", &served).field("pending", &left).finish_non_exhaustive()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pauses_grow_while_no_factor_serves() {
        let mut factor = Factor::default();
        let mut pauses = (0..8).map(|_| {
            factor.discard();
            factor.pause
        });
        assert!(pauses.by_ref().eq([512, 1024, 2048, 4096, 8192, 16384, 16384, 16384]));
    }
}
