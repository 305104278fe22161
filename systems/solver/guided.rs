//! Solves in which holds leave their vertices some motion ([`HoldGuides`](crate::components::HoldGuides)).
//!
//! Conjugate gradients run in the space of motions that the guides allow. With the orthogonal projection Π onto it the system is
//! Π·A·Π·x = Π·b. Every iterate meets the constraint to rounding (Gould, Hribar, Nocedal 2001, "On the solution of equality
//! constrained quadratic programming problems arising in optimization"). The preconditioner is that of the free axes, for which
//! guided vertices are held. For every list of vertices that move alike it is the inverse of its own block Zᵀ·A·Z.

use super::cg::Free;
use super::estimate::Limits;
use super::recurrence::{self, Vectors};
use super::{CgError, CgInfo, Operator, ProductMemory};
use crate::components::{FreeAxes, GuideConstraints, SolverScratch};
use crate::settings::LinearParams;
use crate::systems::bending::BendingPasses;
use crate::systems::parallel;
use glam::{DMat3, DVec2, DVec3};

/// Determinant over the product of the diagonal below which a block counts as singular.
const LEAST_GUIDED_PIVOT: f64 = 1e-12;

/// Guides in a solve, with the inverse of the block of each list of vertices that move alike.
pub(super) struct Guides(GuideConstraints);

impl Guides {
    /// Guides of the body, whose forces are added to the right-hand side; `None` for a body without guides.
    pub(super) fn begin(operator: &Operator, passes: &mut BendingPasses, scratch: &mut SolverScratch) -> Option<Self> {
        if scratch.guide_constraints.is_empty() {
            return None;
        }
        let mut constraints = std::mem::take(&mut scratch.guide_constraints);
        constraints.add_forces(&mut scratch.residual);
        invert_blocks(operator, &mut constraints, passes, scratch);
        Some(Self(constraints))
    }

    /// Gives the guides back after the solve.
    pub(super) fn end(self, scratch: &mut SolverScratch) {
        scratch.guide_constraints = self.0;
    }

    /// Projects forces orthogonally onto free axes and guides.
    fn project(&mut self, free: &FreeAxes, forces: &mut [DVec3]) {
        self.0.level(forces);
        scale((&mut self.0, free), forces, 1.0);
    }

    /// Writes the answer of the blocks to the residual `r` into `z`, and returns their part of r·z.
    fn precondition(&self, r: &[DVec3], z: &mut [DVec3]) -> f64 {
        let mut sum = 0.0;
        for (group, inverse) in self.0.inverse_blocks.iter().enumerate() {
            let (rows, directions) = self.0.group(group);
            let force: DVec3 = rows.iter().map(|&row| r[row as usize]).sum();
            let mut parts = DVec3::ZERO;
            directions.iter().enumerate().for_each(|(i, d)| parts[i] = d.dot(force));
            let answer = *inverse * parts;
            let motion: DVec3 = directions.iter().enumerate().map(|(i, d)| *d * answer[i]).sum();
            rows.iter().for_each(|&row| z[row as usize] += motion);
            sum += answer.dot(parts);
        }
        sum
    }
}

/// Inverts Zᵀ·A·Z for each list of vertices that move alike, Z having their directions in its columns.
fn invert_blocks(
    operator: &Operator,
    constraints: &mut GuideConstraints,
    passes: &mut BendingPasses,
    scratch: &mut SolverScratch,
) {
    let mut blocks = std::mem::take(&mut constraints.inverse_blocks);
    blocks.clear();
    for group in 0..constraints.len() {
        let (rows, directions) = constraints.group(group);
        let block = match rows {
            [row] => operator.diagonal_block(*row as usize),
            _ => sum_of_blocks(operator, rows, passes, scratch),
        };
        let mut own = DMat3::IDENTITY;
        for (j, d) in directions.iter().enumerate() {
            let image = block * *d;
            let mut column = DVec3::ZERO;
            directions.iter().enumerate().for_each(|(i, e)| column[i] = e.dot(image));
            *own.col_mut(j) = column;
        }
        blocks.push(inverse(own, directions.len()));
    }
    constraints.inverse_blocks = blocks;
}

/// Σ over pairs of rows of their blocks of A: how the sum of their forces answers a common displacement.
fn sum_of_blocks(
    operator: &Operator,
    rows: &[u32],
    passes: &mut BendingPasses,
    SolverScratch { direction: moved, product: forces, .. }: &mut SolverScratch,
) -> DMat3 {
    for vector in [&mut *moved, forces] {
        vector.clear();
        vector.resize(operator.vertices.len(), DVec3::ZERO);
    }
    let mut column = |axis: DVec3| -> DVec3 {
        rows.iter().for_each(|&row| moved[row as usize] = axis);
        operator.apply_sparse(moved, forces, passes);
        rows.iter().map(|&row| forces[row as usize]).sum()
    };
    DMat3::from_cols(column(DVec3::X), column(DVec3::Y), column(DVec3::Z))
}

/// The inverse of a block of this size; of a singular one that of its diagonal, whose zeros count as 1.
fn inverse(block: DMat3, size: usize) -> DMat3 {
    let diagonal = [block.x_axis.x, block.y_axis.y, block.z_axis.z];
    let scale: f64 = diagonal[..size].iter().product();
    let padded = (size..3).fold(1.0, |product, i| product * diagonal[i]);
    if diagonal.iter().all(|d| *d > 0.0) && block.determinant() > LEAST_GUIDED_PIVOT * scale * padded {
        return block.inverse();
    }
    let safe = diagonal.map(|d| if d > 0.0 && d.is_finite() { 1.0 / d } else { 1.0 });
    DMat3::from_diagonal(DVec3::from_array(safe))
}

/// Multiplies vectors by a factor along free axes and guides, and leaves nothing of them elsewhere.
pub fn scale((guides, free): (&mut GuideConstraints, &FreeAxes), vectors: &mut [DVec3], factor: f64) {
    guides.take_guided(vectors);
    parallel::for_rows(vectors, |v, vector| *vector *= free[v] * factor);
    guides.add_guided(factor, vectors);
}

/// Solves A·x = b as [`cg::solve`](super::cg::solve) does, from a zero guess along free axes and guides.
///
/// # Errors
/// See [`CgError`].
pub(super) fn solve(
    guides: &mut Guides,
    operator: &Operator,
    params: &LinearParams,
    memory: &mut ProductMemory<'_>,
    x: &mut [DVec3],
    scratch: &mut SolverScratch,
    precondition: impl FnMut(&[DVec3], &FreeAxes, &mut [DVec3], &mut Vec<f64>) -> f64,
) -> Result<CgInfo, CgError> {
    let n = x.len();
    let scales = [scratch.twice_stored, scratch.near];
    let SolverScratch { free, residual, direction, product, partials, stops, reference_sq, .. } = scratch;
    [&mut *direction, product].into_iter().for_each(|vector| vector.resize(n, DVec3::ZERO));
    parallel::for_rows(x, |v, x| *x *= DVec3::ONE - free[v]);
    guides.0.take(x);
    operator.apply(x, free, memory, product, partials);
    parallel::for_rows(residual, |v, r| *r -= product[v]);
    guides.project(free, residual);
    let residual_sq = parallel::sum(n, partials, |v| residual[v].length_squared());
    if !residual_sq.is_finite() {
        return Err(CgError::NotFinite { iteration: 0 });
    }
    *reference_sq = reference_sq.max(residual_sq);
    let limits = Limits::new(params, *reference_sq, scales).repeating(stops);
    let on_axes = Free { operator, memory, x, free, residual, direction, product, partials, precondition };
    let mut vectors = Guided { guides, on_axes };
    let rz = vectors.precondition();
    let reached = recurrence::iterate(&mut vectors, DVec2::new(residual_sq, rz), &limits)?;
    stops.note(reached.iterations, reached.is_late);
    Ok(reached.beside(*reference_sq))
}

/// Vectors on free axes and along guides.
struct Guided<'a, 'b, P> {
    guides: &'a mut Guides,
    on_axes: Free<'a, 'b, P>,
}

impl<P: FnMut(&[DVec3], &FreeAxes, &mut [DVec3], &mut Vec<f64>) -> f64> Guided<'_, '_, P> {
    /// z = M⁻¹·r. Returns r·z.
    fn precondition(&mut self) -> f64 {
        let Free { free, residual, product, partials, precondition, .. } = &mut self.on_axes;
        let of_free = precondition(residual, free, product, partials);
        of_free + self.guides.precondition(residual, product)
    }
}

impl<P: FnMut(&[DVec3], &FreeAxes, &mut [DVec3], &mut Vec<f64>) -> f64> Vectors for Guided<'_, '_, P> {
    fn next_direction(&mut self, beta: f64) {
        self.on_axes.next_direction(beta);
    }

    fn multiply(&mut self) -> f64 {
        let Free { operator, memory, free, direction, product, partials, .. } = &mut self.on_axes;
        operator.apply(direction, free, memory, product, partials);
        parallel::sum(direction.len(), partials, |v| direction[v].dot(product[v]))
    }

    fn is_at_end(&mut self, _: f64, rz: f64) -> bool {
        self.on_axes.operator.is_definite() || rz == 0.0
    }

    fn advance(&mut self, alpha: f64) -> DVec2 {
        let Self { guides, on_axes } = self;
        let Free { x, free, residual, direction, product, partials, .. } = on_axes;
        parallel::for_rows(x, |v, x| *x += direction[v] * alpha);
        guides.project(free, product);
        let residual_sq = parallel::sum_rows(residual, partials, |v, r| {
            *r -= product[v] * alpha;
            r.length_squared()
        });
        DVec2::new(residual_sq, self.precondition())
    }
}
