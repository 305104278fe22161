//! A small dense system.

/// Pivot over the diagonal below which a row has none.
const LEAST_PIVOT: f64 = 1e-12;

/// Solves a symmetric positive semidefinite system by Cholesky's factor; rows without a pivot, which are bodies that are held, stay zero.
pub(super) fn solve_dense(mut matrix: Vec<Vec<f64>>, mut b: Vec<f64>) -> Option<Vec<f64>> {
    let size = b.len();
    for j in 0..size {
        let before: f64 = matrix[j][..j].iter().map(|l| l * l).sum();
        let (own, pivot) = (matrix[j][j], matrix[j][j] - before);
        let is_there = pivot > LEAST_PIVOT * own;
        matrix[j][j] = if is_there { pivot.sqrt() } else { f64::INFINITY };
        for i in j + 1..size {
            let sum: f64 = (0..j).map(|k| matrix[i][k] * matrix[j][k]).sum();
            matrix[i][j] = (matrix[i][j] - sum) / matrix[j][j];
        }
    }
    for i in 0..size {
        let sum: f64 = (0..i).map(|k| matrix[i][k] * b[k]).sum();
        b[i] = (b[i] - sum) / matrix[i][i];
    }
    for i in (0..size).rev() {
        let sum: f64 = (i + 1..size).map(|k| matrix[k][i] * b[k]).sum();
        b[i] = (b[i] - sum) / matrix[i][i];
    }
    b.iter().all(|b| b.is_finite()).then_some(b)
}
