//! A sparse Cholesky factor of the operator at some state of the body: the preconditioner of solves at that state and near it.
//!
//! At the factor's own state conjugate gradients need one or two iterations, at another state as many more as it is further
//! away: a factor serves until it needs more iterations than a new one costs. Everything here runs on one thread.

use super::Operator;
use super::panels::Panels;
use super::pattern::Pattern;
use faer::dyn_stack::{MemBuffer, MemStack, StackReq};
use faer::sparse::linalg::SupernodalThreshold;
use faer::sparse::linalg::cholesky::supernodal::SupernodalLltRef;
use faer::sparse::linalg::cholesky::{
    CholeskySymbolicParams, SymbolicCholesky, SymbolicCholeskyRaw, SymmetricOrdering, factorize_symbolic_cholesky,
};
use faer::{Par, Side, Spec};
use glam::DVec3;

/// A body's factor, with what can be kept from one to the next while triangles and free axes stay. *Derived.*
#[derive(Default)]
pub struct Factor(Option<Box<Parts>>);

struct Parts {
    pattern: Pattern,
    symbolic: SymbolicCholesky<u32>,
    matrix: Vec<f64>,
    factor: Vec<f64>,
    is_factored: bool,
    panels: Panels,
    columns: Vec<f32>,
    memory: MemBuffer,
}

/// Why there is no factor.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum NoFactor {
    /// The operator is not positive definite.
    Indefinite,
    /// The body has no free axis, or there is not enough memory.
    Unavailable,
}

impl Factor {
    /// Whether there is a factor of an operator with these triangles and free axes.
    pub fn fits(&self, corners: &[[u32; 3]], free: &[DVec3]) -> bool {
        self.0.as_ref().is_some_and(|parts| parts.is_factored && parts.pattern.fits(corners, free))
    }

    /// Factors the operator at its state.
    ///
    /// # Errors
    /// Where the operator is not positive definite, or there is no memory; there is then no factor.
    pub fn renew(&mut self, operator: &Operator, free: &[DVec3]) -> Result<(), NoFactor> {
        if !self.0.as_ref().is_some_and(|parts| parts.pattern.fits(&operator.triangles.corners, free)) {
            // First gone, then new: there is never memory for two.
            self.0 = None;
            self.0 = Some(Box::new(Parts::new(operator, free).ok_or(NoFactor::Unavailable)?));
        }
        self.0.as_mut().map_or(Err(NoFactor::Unavailable), |parts| parts.factorize(operator))
    }

    /// The factor's answer \[mm\] to a residual \[N\], per vertex; zero along prescribed axes, and without a factor.
    pub fn solve(&mut self, residual: &[DVec3]) -> impl Fn(usize) -> DVec3 + Sync {
        // Scaled by a power of two, so that single precision neither over- nor underflows and loses nothing.
        let largest = residual.iter().map(|r| r.abs().max_element()).fold(0.0, f64::max);
        let scale = if largest.is_normal() { (-largest.log2().floor().clamp(-1000.0, 1000.0)).exp2() } else { 1.0 };
        let parts = self.0.as_mut().filter(|parts| parts.is_factored).map(|parts| {
            parts.pattern.gather(residual, scale, &mut parts.columns);
            parts.panels.solve(&mut parts.columns);
            (&parts.pattern, &parts.columns)
        });
        move |v| parts.map_or(DVec3::ZERO, |(pattern, columns)| pattern.at(columns, v) / scale)
    }
}

impl Parts {
    fn new(operator: &Operator, free: &[DVec3]) -> Option<Self> {
        let pattern = Pattern::new(operator, free)?;
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
        let (matrix, panels, columns) = (Vec::new(), Panels::default(), vec![0.0; pattern.column_count()]);
        Some(Self { pattern, symbolic, matrix, factor, is_factored: false, panels, columns, memory })
    }

    fn factorize(&mut self, operator: &Operator) -> Result<(), NoFactor> {
        self.pattern.assemble(operator, &mut self.matrix);
        let matrix = self.pattern.matrix(&self.matrix);
        let stack = MemStack::new(&mut self.memory);
        let (bare, spec) = (Default::default(), Spec::default());
        let result =
            self.symbolic.factorize_numeric_llt(&mut self.factor, matrix, Side::Upper, bare, Par::Seq, stack, spec);
        // The one thing that can go wrong here is a pivot that is not positive.
        let result = result.map(|_| ()).map_err(|_| NoFactor::Indefinite);
        self.is_factored = result.is_ok();
        if self.is_factored
            && let SymbolicCholeskyRaw::Supernodal(symbolic) = self.symbolic.raw()
        {
            self.panels.fill(SupernodalLltRef::new(symbolic, &self.factor));
        }
        result
    }
}
