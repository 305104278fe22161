//! Natural frequencies of a body about its present state, with the engine's own operator and linear solver.

use super::VerifyError;
use super::bodies::{Snapshot, operator};
use glam::DVec3;
use rhexis::components::{FreeAxes, SolverScratch};
use rhexis::settings::LinearParams;
use rhexis::systems::bending::BendingPasses;
use rhexis::systems::solver::{self, Available, Factor, FactorUse, ProductMemory};
use std::f64::consts::TAU;

/// Krylov vectors: the lowest three of a spectrum like a membrane's are then exact to 1e-10.
const VECTORS: usize = 24;

/// The `count` lowest frequencies \[kHz\] of K·φ = ω²·M·φ on the free axes (1 free, 0 held). Lanczos' method finds them for K⁻¹·M
/// in the inner product of M, with full orthogonalisation (Parlett, The Symmetric Eigenvalue Problem, ch. 13 and 15). Only modes
/// that the engine's symmetry lets the start vector reach are found: one that moves along z finds those along z.
pub(super) fn lowest_frequencies(body: &Snapshot, free: &FreeAxes, count: usize) -> Result<Vec<f64>, VerifyError> {
    let operator = operator(&body.vertices, &body.triangles, &body.topology, &body.frames);
    let mass = &body.vertices.mass;
    let mut scratch = SolverScratch::default();
    scratch.free.clone_from(free);
    let (mut corner, mut passes) = (Vec::new(), BendingPasses::default());
    let params = LinearParams::by_residual(1e-12, 20_000);
    let dot = |a: &[DVec3], b: &[DVec3]| a.iter().zip(b).zip(mass).map(|((a, b), m)| a.dot(*b) * m).sum::<f64>();

    // A start without symmetry, so that no mode is orthogonal to it.
    let start = |(v, f): (usize, &DVec3)| *f * DVec3::new(1.0, (v as f64).cos(), (1.7 * v as f64).sin() + 0.5);
    let mut factor = Factor::default();
    let mut basis: Vec<Vec<DVec3>> = Vec::new();
    let mut next: Vec<DVec3> = free.iter().enumerate().map(start).collect();
    let (mut diagonal, mut off_diagonal) = (Vec::new(), Vec::new());
    for _ in 0..VECTORS {
        let norm = dot(&next, &next).sqrt();
        off_diagonal.push(norm);
        next.iter_mut().for_each(|x| *x /= norm);
        basis.push(next);
        let last = &basis[basis.len() - 1];
        let mut image = vec![DVec3::ZERO; last.len()];
        scratch.residual = last.iter().zip(mass).zip(free).map(|((x, m), f)| *x * *m * *f).collect();
        let mut available = Available { factor: Some((&mut factor, FactorUse::First)), ..Available::default() };
        let mut memory = ProductMemory { corner: &mut corner, passes: &mut passes };
        solver::solve(&operator, &params, &mut available, &mut memory, &mut image, &mut scratch)?;
        diagonal.push(dot(last, &image));
        // Twice is enough (Kahan).
        for _ in 0..2 {
            for b in &basis {
                let part = dot(b, &image);
                image.iter_mut().zip(b).for_each(|(x, b)| *x -= *b * part);
            }
        }
        next = image;
    }
    // The first norm is that of the start vector, not an entry of the matrix.
    let values = (0..count).map(|k| largest_eigenvalue(&diagonal, &off_diagonal[1..], k));
    Ok(values.map(|value| 1.0 / (value.sqrt() * TAU)).collect())
}

/// The eigenvalue number `k` from the top of a symmetric tridiagonal matrix, by bisection with Sturm's count.
fn largest_eigenvalue(diagonal: &[f64], off_diagonal: &[f64], k: usize) -> f64 {
    let above = |x: f64| {
        let mut count = 0;
        let mut pivot = 1.0;
        for (i, d) in diagonal.iter().enumerate() {
            let coupling = if i == 0 { 0.0 } else { off_diagonal[i - 1] };
            pivot = d - x - coupling * coupling / pivot;
            // A pivot of zero is moved off it, as usual, by less than rounding of the matrix.
            if pivot.abs() < f64::MIN_POSITIVE {
                pivot = f64::MIN_POSITIVE;
            }
            count += usize::from(pivot > 0.0);
        }
        count
    };
    let bound: f64 = diagonal.iter().map(|d| d.abs()).sum::<f64>() + 2.0 * off_diagonal.iter().sum::<f64>();
    let (mut low, mut high) = (0.0, bound);
    // 120 halvings reach neighbouring floating-point numbers from any start.
    for _ in 0..120 {
        let middle = 0.5 * (low + high);
        if above(middle) > k { low = middle } else { high = middle }
    }
    0.5 * (low + high)
}
