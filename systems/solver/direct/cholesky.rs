//! A sparse Cholesky factor of the operator at some state of a body.

use super::operator_copy::OperatorCopy;
use super::panels::Panels;
use super::pattern::AxisPattern;
use crate::components::FreeAxes;
use faer::dyn_stack::{MemBuffer, MemStack, StackReq};
use faer::sparse::linalg::SupernodalThreshold;
use faer::sparse::linalg::cholesky::supernodal::SupernodalLltRef;
use faer::sparse::linalg::cholesky::{
    CholeskySymbolicParams, SymbolicCholesky, SymbolicCholeskyRaw, SymmetricOrdering, factorize_symbolic_cholesky,
};
use faer::{Par, Side, Spec};
use glam::DVec3;

/// A Cholesky factor, with the data that can be kept from one to the next while triangles and free axes stay.
pub(super) struct Cholesky {
    pattern: AxisPattern,
    symbolic: SymbolicCholesky<u32>,
    matrix: Vec<f64>,
    factor: Vec<f64>,
    panels: Panels,
    memory: MemBuffer,
}

/// The matrix that a factor was made of.
#[derive(Clone, Debug, Default)]
#[cfg_attr(feature = "snapshot", derive(serde::Serialize, serde::Deserialize))]
pub(super) struct Equations {
    /// Corners of the triangles.
    pub corners: Vec<[u32; 3]>,
    /// Vertices of the dihedrals.
    pub folded: Vec<[u32; 4]>,
    /// 1 along free axes, 0 along prescribed ones.
    pub free: FreeAxes,
    /// The entries in the order of their [`AxisPattern`] \[N/mm\]; none where there is no factor of these triangles.
    pub matrix: Vec<f64>,
}

/// Why there is no factor.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum NoFactor {
    /// The operator is not positive definite.
    Indefinite,
    /// The body has no free axis, or there is not enough memory.
    Unavailable,
}

impl Cholesky {
    /// Factors an operator, on one thread. Parts of `before` that can be used again are.
    ///
    /// # Errors
    /// Where the operator is not positive definite, or there is no memory.
    pub(super) fn new(operator_copy: &OperatorCopy, before: Option<Self>) -> Result<Self, NoFactor> {
        // First gone, then new: there is never memory for two.
        let folded = operator_copy.folded();
        let fits = |before: &Self| {
            before.fits(&operator_copy.corners, &operator_copy.free) && before.pattern.folded() == folded
        };
        let kept = before.filter(fits);
        let empty = || Self::empty(&operator_copy.corners, &folded, &operator_copy.free).ok_or(NoFactor::Unavailable);
        let mut factor = kept.map_or_else(empty, Ok)?;
        factor.pattern.assemble(operator_copy, &mut factor.matrix);
        factor.factorize()?;
        Ok(factor)
    }

    /// Makes the factor anew that had these equations, to the same bits.
    ///
    /// # Errors
    /// As [`new`](Self::new), and where the equations are not those of their triangles and free axes.
    pub(super) fn of_equations(equations: &Equations) -> Result<Self, NoFactor> {
        let Equations { corners, folded, free, matrix } = equations;
        let mut factor = Self::empty(corners, folded, free).ok_or(NoFactor::Unavailable)?;
        if matrix.len() != factor.pattern.entry_count() {
            return Err(NoFactor::Unavailable);
        }
        factor.matrix.clone_from(matrix);
        factor.factorize()?;
        Ok(factor)
    }

    /// Pattern and matrix that the factor was made of.
    pub(super) fn equations(&self) -> Equations {
        let Self { pattern, matrix, .. } = self;
        let (corners, folded, free) = (pattern.corners().to_vec(), pattern.folded().to_vec(), pattern.free().clone());
        Equations { corners, folded, free, matrix: matrix.clone() }
    }

    fn empty(corners: &[[u32; 3]], folded: &[[u32; 4]], free: &FreeAxes) -> Option<Self> {
        let pattern = AxisPattern::new(corners, folded, free)?;
        // The pattern is in the order of elimination already.
        let ordering = SymmetricOrdering::Identity;
        let threshold = SupernodalThreshold::FORCE_SUPERNODAL;
        let params = CholeskySymbolicParams { supernodal_flop_ratio_threshold: threshold, ..Default::default() };
        let symbolic = factorize_symbolic_cholesky(pattern.symbolic(), Side::Upper, ordering, params).ok()?;
        let needed: StackReq = symbolic.factorize_numeric_llt_scratch::<f64>(Par::Seq, Spec::default());
        let memory = MemBuffer::try_new(needed).ok()?;
        let mut factor = Vec::new();
        factor.try_reserve_exact(symbolic.len_val()).ok()?;
        factor.resize(symbolic.len_val(), 0.0);
        Some(Self { pattern, symbolic, matrix: Vec::new(), factor, panels: Panels::default(), memory })
    }

    fn factorize(&mut self) -> Result<(), NoFactor> {
        let matrix = self.pattern.matrix(&self.matrix);
        let stack = MemStack::new(&mut self.memory);
        let (bare, spec) = (Default::default(), Spec::default());
        let result =
            self.symbolic.factorize_numeric_llt(&mut self.factor, matrix, Side::Upper, bare, Par::Seq, stack, spec);
        // The one thing that can go wrong here is a pivot that is not positive.
        result.map(|_| ()).map_err(|_| NoFactor::Indefinite)?;
        if let SymbolicCholeskyRaw::Supernodal(symbolic) = self.symbolic.raw() {
            let factor = SupernodalLltRef::new(symbolic, &self.factor);
            self.panels.fill(factor, self.pattern.subdomains());
        }
        Ok(())
    }

    /// Whether it is a factor for these triangles and free axes.
    pub(super) fn fits(&self, corners: &[[u32; 3]], free: &FreeAxes) -> bool {
        self.pattern.fits(corners, free)
    }

    /// Sets the force on a vertex along its free axes.
    #[inline]
    pub(super) fn put(&mut self, v: usize, force: DVec3) {
        self.pattern.for_columns(v, |c, axis| self.panels.column[c] = force[axis]);
    }

    /// The first half of a solve.
    pub(super) fn forward_sweep(&mut self) {
        self.panels.sweep(true);
    }

    /// The second half, which leaves the displacements that answer the forces.
    pub(super) fn backward_sweep(&mut self) {
        self.panels.sweep(false);
    }

    /// The displacement of a vertex, zero along its prescribed axes.
    #[inline]
    pub(super) fn part(&self, v: usize) -> DVec3 {
        let mut part = DVec3::ZERO;
        self.pattern.for_columns(v, |c, axis| part[axis] = self.panels.column[c]);
        part
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::systems::parallel::Pool;
    use glam::DMat3;

    /// A square of `side` by `side` vertices, triangles with edges like springs that pull along any axis, and a weak hold everywhere.
    fn square(side: u32) -> OperatorCopy {
        let mut operator_copy = OperatorCopy::default();
        for v in (0..side * (side - 1)).filter(|v| v % side < side - 1) {
            operator_copy.corners.extend([[v, v + 1, v + side], [v + 1, v + side + 1, v + side]]);
        }
        let stiff = |x: f64| DMat3::from_diagonal(DVec3::new(1.0, 2.0, 0.5) * x);
        operator_copy.blocks = vec![[stiff(2.0), stiff(-1.0), stiff(2.0)]; operator_copy.corners.len()];
        operator_copy.own = vec![stiff(0.01); (side * side) as usize];
        let free = |v| if v < side { DVec3::new(1.0, 0.0, 1.0) } else { DVec3::ONE };
        operator_copy.free = (0..side * side).map(free).collect();
        operator_copy
    }

    fn product(operator_copy: &OperatorCopy, u: &[DVec3]) -> Vec<DVec3> {
        let mut out: Vec<DVec3> = operator_copy.own.iter().zip(u).map(|(own, u)| *own * *u).collect();
        for (t, corners) in operator_copy.corners.iter().enumerate() {
            for (i, &v) in corners.iter().enumerate() {
                for (j, &w) in corners.iter().enumerate() {
                    out[v as usize] += operator_copy.block(t, i, j) * u[w as usize];
                }
            }
        }
        out.iter().zip(&operator_copy.free).map(|(out, free)| *out * *free).collect()
    }

    #[test]
    fn two_threads_sweep_two_parts_to_the_same_bits() {
        let operator_copy = square(66);
        let force = |v: usize| DVec3::new((v as f64).sin(), (2.0 * v as f64).cos(), 1.0) * operator_copy.free[v];
        let mut factor = Cholesky::new(&operator_copy, None).unwrap();
        assert!(factor.pattern.subdomains().is_some());
        let answers = [1, 2].map(|threads| {
            (0..operator_copy.own.len()).for_each(|v| factor.put(v, force(v)));
            Pool::new(threads, false).unwrap().run(|| {
                factor.forward_sweep();
                factor.backward_sweep();
            });
            (0..operator_copy.own.len()).map(|v| factor.part(v)).collect::<Vec<_>>()
        });
        assert!(answers[0] == answers[1]);
        let back = product(&operator_copy, &answers[0]);
        // The diagonal is raised by 1e-10 of a trace of some dozen, displacements are up to a hundred.
        let off = back.iter().enumerate().map(|(v, b)| (*b - force(v)).length()).fold(0.0, f64::max);
        assert!(off < 1e-5, "{off}");
    }
}
