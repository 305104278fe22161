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
    /// Four times the vertex plus the axis of every column.
    axis: Vec<u32>,
    symbolic: SymbolicCholesky<u32>,
    matrix: Vec<f64>,
    factor: Vec<f64>,
    panels: Either,
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

impl Equations {
    /// The equations of an operator.
    pub(super) fn of(operator_copy: &OperatorCopy) -> Self {
        let mut matrix = Vec::new();
        let folded = operator_copy.folded();
        if let Some(pattern) = AxisPattern::new(&operator_copy.corners, &folded, &operator_copy.free) {
            pattern.assemble(operator_copy, &mut matrix);
        }
        Self { corners: operator_copy.corners.clone(), folded, free: operator_copy.free.clone(), matrix }
    }
}

/// The factor to solve with, in single or double precision.
enum Either {
    Single(Panels<f32>),
    Double(Panels<f64>),
}

/// The precision of solves with a factor.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "snapshot", derive(serde::Serialize, serde::Deserialize))]
pub(super) enum FactorPrecision {
    /// Half the time. For dynamic steps.
    Single,
    /// For static solves, in which nothing may hold a piece.
    Double,
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
    pub(super) fn new(
        operator_copy: &OperatorCopy,
        precision: FactorPrecision,
        before: Option<Self>,
    ) -> Result<Self, NoFactor> {
        // First gone, then new: there is never memory for two.
        let folded = operator_copy.folded();
        let fits = |before: &Self| {
            before.fits(&operator_copy.corners, &operator_copy.free) && before.pattern.folded() == folded
        };
        let kept = before.filter(fits);
        let empty = || Self::empty(&operator_copy.corners, &folded, &operator_copy.free).ok_or(NoFactor::Unavailable);
        let mut factor = kept.map_or_else(empty, Ok)?;
        factor.set_precision(precision);
        factor.pattern.assemble(operator_copy, &mut factor.matrix);
        factor.factorize()?;
        Ok(factor)
    }

    /// Makes the factor anew that had these equations, to the same bits.
    ///
    /// # Errors
    /// As [`new`](Self::new), and where the equations are not those of their triangles and free axes.
    pub(super) fn of_equations(equations: &Equations, precision: FactorPrecision) -> Result<Self, NoFactor> {
        let Equations { corners, folded, free, matrix } = equations;
        let mut factor = Self::empty(corners, folded, free).ok_or(NoFactor::Unavailable)?;
        if matrix.len() != factor.pattern.entry_count() {
            return Err(NoFactor::Unavailable);
        }
        factor.set_precision(precision);
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

    /// The precision of solves with it.
    pub(super) fn precision(&self) -> FactorPrecision {
        match self.panels {
            Either::Single(_) => FactorPrecision::Single,
            Either::Double(_) => FactorPrecision::Double,
        }
    }

    fn set_precision(&mut self, precision: FactorPrecision) {
        if self.precision() != precision {
            self.panels = match precision {
                FactorPrecision::Single => Either::Single(Panels::default()),
                FactorPrecision::Double => Either::Double(Panels::default()),
            };
        }
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
        let panels = Either::Single(Panels::default());
        let axis = pattern.axis_of_columns();
        Some(Self { pattern, axis, symbolic, matrix: Vec::new(), factor, panels, memory })
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
            let subdomains = self.pattern.subdomains();
            match &mut self.panels {
                Either::Single(panels) => panels.fill(factor, subdomains),
                Either::Double(panels) => panels.fill(factor, subdomains),
            }
        }
        Ok(())
    }

    /// Whether it is a factor for these triangles and free axes.
    pub(super) fn fits(&self, corners: &[[u32; 3]], free: &FreeAxes) -> bool {
        self.pattern.fits(corners, free)
    }

    /// The free axes of the vertices it was made for, 1 or 0.
    pub(super) fn free(&self) -> &FreeAxes {
        self.pattern.free()
    }

    /// Sets all forces to zero.
    pub(super) fn clear(&mut self) {
        match &mut self.panels {
            Either::Single(panels) => panels.column.fill(0.0),
            Either::Double(panels) => panels.column.fill(0.0),
        }
    }

    /// Sets the force on a vertex along its free axes.
    #[inline]
    pub(super) fn put(&mut self, v: usize, force: DVec3) {
        match &mut self.panels {
            Either::Single(panels) => self.pattern.for_columns(v, |c, axis| panels.column[c] = force[axis] as f32),
            Either::Double(panels) => self.pattern.for_columns(v, |c, axis| panels.column[c] = force[axis]),
        }
    }

    /// Adds to the force on a vertex along its free axes.
    #[inline]
    pub(super) fn add(&mut self, v: usize, force: DVec3) {
        match &mut self.panels {
            Either::Single(panels) => self.pattern.for_columns(v, |c, axis| panels.column[c] += force[axis] as f32),
            Either::Double(panels) => self.pattern.for_columns(v, |c, axis| panels.column[c] += force[axis]),
        }
    }

    /// Sets all forces, given by vertex and axis.
    pub(super) fn put_all(&mut self, force: impl Fn(usize, usize) -> f32) {
        let of = |axis: &u32| force(*axis as usize / 4, *axis as usize % 4);
        match &mut self.panels {
            Either::Single(panels) => panels.column.iter_mut().zip(&self.axis).for_each(|(x, axis)| *x = of(axis)),
            Either::Double(panels) => {
                panels.column.iter_mut().zip(&self.axis).for_each(|(x, axis)| *x = of(axis).into())
            }
        }
    }

    /// Hands out the displacements along all free axes, each with its vertex and axis.
    pub(super) fn parts(&self, mut part: impl FnMut(usize, usize, f32)) {
        let mut hand = |axis: &u32, x: f32| part(*axis as usize / 4, *axis as usize % 4, x);
        match &self.panels {
            Either::Single(panels) => panels.column.iter().zip(&self.axis).for_each(|(x, axis)| hand(axis, *x)),
            Either::Double(panels) => panels.column.iter().zip(&self.axis).for_each(|(x, axis)| hand(axis, *x as f32)),
        }
    }

    /// The first half of a solve; returns the scalar product of the forces with the displacements that answer them.
    pub(super) fn forward_sweep(&mut self) -> f64 {
        match &mut self.panels {
            Either::Single(panels) => panels.forward_sweep(),
            Either::Double(panels) => panels.forward_sweep(),
        }
    }

    /// The second half, which leaves those displacements.
    pub(super) fn backward_sweep(&mut self) {
        match &mut self.panels {
            Either::Single(panels) => panels.backward_sweep(),
            Either::Double(panels) => panels.backward_sweep(),
        }
    }

    /// The displacement of a vertex, zero along its prescribed axes.
    #[inline]
    pub(super) fn part(&self, v: usize) -> DVec3 {
        let mut part = DVec3::ZERO;
        match &self.panels {
            Either::Single(panels) => self.pattern.for_columns(v, |c, axis| part[axis] = panels.column[c].into()),
            Either::Double(panels) => self.pattern.for_columns(v, |c, axis| part[axis] = panels.column[c]),
        }
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
        for (precision, least) in [(FactorPrecision::Double, 1e-5), (FactorPrecision::Single, 1e-2)] {
            let mut factor = Cholesky::new(&operator_copy, precision, None).unwrap();
            assert!(factor.pattern.subdomains().is_some());
            let answers = [1, 2].map(|threads| {
                (0..operator_copy.own.len()).for_each(|v| factor.put(v, force(v)));
                let work = Pool::new(threads, false).unwrap().run(|| {
                    let work = factor.forward_sweep();
                    factor.backward_sweep();
                    work
                });
                (work, (0..operator_copy.own.len()).map(|v| factor.part(v)).collect::<Vec<_>>())
            });
            assert!(answers[0] == answers[1]);
            let (work, answer) = &answers[0];
            let back = product(&operator_copy, answer);
            // The diagonal is raised by 1e-10 of a trace of some dozen, displacements are up to a hundred; single precision knows
            // forces of a thousand, which cancel, to 1e-4.
            let off = back.iter().enumerate().map(|(v, b)| (*b - force(v)).length()).fold(0.0, f64::max);
            assert!(off < least, "{off}");
            let exact: f64 = answer.iter().enumerate().map(|(v, x)| x.dot(force(v))).sum();
            assert!((work - exact).abs() < least * exact, "{work} {exact}");
        }
    }
}
