//! The coarsest level, solved by a dense Cholesky factor in double precision.

use super::level::Level;
use crate::systems::kernels::block::Block;
use glam::Vec4;

/// A pivot is at least this part of its diagonal entry: single precision has left no digit of a smaller one.
const LEAST_COARSEST_PIVOT: f64 = 1e-6;

/// The factor.
#[derive(Debug, Default)]
pub(super) struct Coarsest {
    /// Rows of L, full ones.
    factor: Vec<f64>,
    b: Vec<f64>,
}

impl Coarsest {
    /// Factors a level's operator.
    pub(super) fn factor(&mut self, level: &Level) {
        let count = level.pattern.row_count();
        let n = 3 * count;
        self.factor.clear();
        self.factor.resize(n * n, 0.0);
        self.b.clear();
        self.b.resize(n, 0.0);
        for row in 0..count {
            self.put(n, row, row, &level.diagonal[row]);
            for k in level.pattern.before(row) {
                self.put(n, row, level.pattern.column[k] as usize, &level.lower[k]);
            }
        }
        for i in 0..n {
            let (before, from_i) = self.factor.split_at_mut(i * n);
            let of_i = &mut from_i[..=i];
            for j in 0..i {
                let of_j = &before[j * n..=j * n + j];
                of_i[j] = (of_i[j] - dot(&of_i[..j], &of_j[..j])) / of_j[j];
            }
            let own = of_i[i];
            let pivot = own - dot(&of_i[..i], &of_i[..i]);
            // A prescribed axis, or one without any stiffness: it stays where it is.
            let pivot = if own > 0.0 { pivot.max(own * LEAST_COARSEST_PIVOT) } else { f64::INFINITY };
            of_i[i] = pivot.sqrt();
        }
    }

    fn put(&mut self, n: usize, row: usize, column: usize, block: &Block) {
        for (c, values) in block.iter().enumerate() {
            for (r, value) in values.to_array()[..3].iter().enumerate() {
                self.factor[(3 * row + r) * n + 3 * column + c] = f64::from(*value);
            }
        }
    }

    /// x = A⁻¹·r.
    pub(super) fn solve(&mut self, r: &[Vec4], x: &mut [Vec4]) {
        let n = self.b.len();
        let Self { factor, b } = self;
        for (b, r) in b.chunks_exact_mut(3).zip(r) {
            b.iter_mut().zip(r.to_array()).for_each(|(b, r)| *b = f64::from(r));
        }
        for i in 0..n {
            let of_i = &factor[i * n..=i * n + i];
            b[i] = (b[i] - dot(&of_i[..i], &b[..i])) / of_i[i];
        }
        for i in (0..n).rev() {
            let of_i = &factor[i * n..=i * n + i];
            b[i] /= of_i[i];
            let own = b[i];
            b[..i].iter_mut().zip(of_i).for_each(|(b, a)| *b -= a * own);
        }
        for (x, b) in x.iter_mut().zip(b.chunks_exact(3)) {
            *x = Vec4::new(b[0] as f32, b[1] as f32, b[2] as f32, 0.0);
        }
    }
}

/// The scalar product, in eight sums side by side.
fn dot(a: &[f64], b: &[f64]) -> f64 {
    let mut sums = [0.0; 8];
    let ((a, a_rest), (b, b_rest)) = (a.as_chunks::<8>(), b.as_chunks::<8>());
    for (a, b) in a.iter().zip(b) {
        for ((sum, a), b) in sums.iter_mut().zip(a).zip(b) {
            *sum += a * b;
        }
    }
    sums.iter().sum::<f64>() + a_rest.iter().zip(b_rest).map(|(a, b)| a * b).sum::<f64>()
}
