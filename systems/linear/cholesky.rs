//! A sparse Cholesky factor of the operator at some state of a body.

use super::panels::Panels;
use super::pattern::Pattern;
use super::snapshot::Snapshot;
use faer::dyn_stack::{MemBuffer, MemStack, StackReq};
use faer::sparse::linalg::SupernodalThreshold;
use faer::sparse::linalg::cholesky::supernodal::SupernodalLltRef;
use faer::sparse::linalg::cholesky::{
    CholeskySymbolicParams, SymbolicCholesky, SymbolicCholeskyRaw, SymmetricOrdering, factorize_symbolic_cholesky,
};
use faer::{Par, Side, Spec};
use glam::DVec3;

/// A factor, with what can be kept from one to the next while triangles and free axes stay.
pub struct Cholesky {
    pattern: Pattern,
    symbolic: SymbolicCholesky<u32>,
    matrix: Vec<f64>,
    factor: Vec<f64>,
    panels: Either,
    memory: MemBuffer,
}

/// The factor to solve with, in single or double precision.
enum Either {
    Single(Panels<f32>),
    Double(Panels<f64>),
}

/// The precision of solves with a factor.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Precision {
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
    /// Factors an operator, on one thread. What `before` has and can be used again is.
    ///
    /// # Errors
    /// Where the operator is not positive definite, or there is no memory.
    pub fn new(snapshot: &Snapshot, precision: Precision, before: Option<Self>) -> Result<Self, NoFactor> {
        // First gone, then new: there is never memory for two.
        let kept = before.filter(|before| before.fits(&snapshot.corners, &snapshot.free));
        let mut factor = kept.map_or_else(|| Self::empty(snapshot).ok_or(NoFactor::Unavailable), Ok)?;
        factor.panels = match (precision, factor.panels) {
            (Precision::Single, kept @ Either::Single(_)) | (Precision::Double, kept @ Either::Double(_)) => kept,
            (Precision::Single, _) => Either::Single(Panels::default()),
            (Precision::Double, _) => Either::Double(Panels::default()),
        };
        factor.factorize(snapshot)?;
        Ok(factor)
    }

    fn empty(snapshot: &Snapshot) -> Option<Self> {
        let pattern = Pattern::new(snapshot)?;
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
        Some(Self { pattern, symbolic, matrix: Vec::new(), factor, panels, memory })
    }

    fn factorize(&mut self, snapshot: &Snapshot) -> Result<(), NoFactor> {
        self.pattern.assemble(snapshot, &mut self.matrix);
        let matrix = self.pattern.matrix(&self.matrix);
        let stack = MemStack::new(&mut self.memory);
        let (bare, spec) = (Default::default(), Spec::default());
        let result =
            self.symbolic.factorize_numeric_llt(&mut self.factor, matrix, Side::Upper, bare, Par::Seq, stack, spec);
        // The one thing that can go wrong here is a pivot that is not positive.
        result.map(|_| ()).map_err(|_| NoFactor::Indefinite)?;
        if let SymbolicCholeskyRaw::Supernodal(symbolic) = self.symbolic.raw() {
            let factor = SupernodalLltRef::new(symbolic, &self.factor);
            match &mut self.panels {
                Either::Single(panels) => panels.fill(factor),
                Either::Double(panels) => panels.fill(factor),
            }
        }
        Ok(())
    }

    /// Whether it is a factor for these triangles and free axes.
    pub fn fits(&self, corners: &[[u32; 3]], free: &[DVec3]) -> bool {
        self.pattern.fits(corners, free)
    }

    /// The free axes of the vertices it was made for, 1 or 0.
    pub fn free(&self) -> &[DVec3] {
        self.pattern.free()
    }

    /// Sets all forces to zero.
    pub fn clear(&mut self) {
        match &mut self.panels {
            Either::Single(panels) => panels.column.fill(0.0),
            Either::Double(panels) => panels.column.fill(0.0),
        }
    }

    /// Sets the force on a vertex along its free axes.
    #[inline]
    pub fn put(&mut self, v: usize, force: DVec3) {
        match &mut self.panels {
            Either::Single(panels) => {
                self.pattern.columns(v).for_each(|(c, axis)| panels.column[c] = force[axis] as f32)
            }
            Either::Double(panels) => self.pattern.columns(v).for_each(|(c, axis)| panels.column[c] = force[axis]),
        }
    }

    /// Adds to the force on a vertex along its free axes.
    #[inline]
    pub fn add(&mut self, v: usize, force: DVec3) {
        match &mut self.panels {
            Either::Single(panels) => {
                self.pattern.columns(v).for_each(|(c, axis)| panels.column[c] += force[axis] as f32)
            }
            Either::Double(panels) => self.pattern.columns(v).for_each(|(c, axis)| panels.column[c] += force[axis]),
        }
    }

    /// Replaces the forces by the displacements that answer them.
    pub fn solve(&mut self) {
        match &mut self.panels {
            Either::Single(panels) => panels.solve(),
            Either::Double(panels) => panels.solve(),
        }
    }

    /// The displacement of a vertex, zero along its prescribed axes.
    #[inline]
    pub fn part(&self, v: usize) -> DVec3 {
        let mut part = DVec3::ZERO;
        match &self.panels {
            Either::Single(panels) => {
                self.pattern.columns(v).for_each(|(c, axis)| part[axis] = panels.column[c].into())
            }
            Either::Double(panels) => self.pattern.columns(v).for_each(|(c, axis)| part[axis] = panels.column[c]),
        }
        part
    }
}
