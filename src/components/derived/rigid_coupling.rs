//! Rigid obstacles as unknowns of a solve, eliminated.

use glam::DVec3;

/// Six numbers of a rigid motion: a displacement and a rotation vector.
pub(crate) type Six = [f64; 6];

/// A rigid obstacle among the unknowns of a body's solve. Its own six are eliminated: beside the springs B of the vertices in touch the
/// operator has −C·Cᵀ, C = B·J·L⁻ᵀ, with the rigid motions J of the vertices and the Cholesky factor L of M/Δt² + Jᵀ·B·J.
#[derive(Clone, Debug)]
pub(crate) struct RigidCoupling {
    /// Place of the obstacle among those of the evaluation.
    pub place: u32,
    /// Centre of mass of the obstacle \[mm\].
    pub centre: DVec3,
    /// Place of the first vertex in touch with it among all of the body.
    pub first: usize,
    /// Rows of the vertices in touch, and their three rows of C by columns.
    pub rows: Vec<(u32, [DVec3; 6])>,
    /// The factor L.
    pub lower: [Six; 6],
    /// Motion of the obstacle where the vertices stay.
    pub base: Six,
    /// Part of the obstacle that the body moves, as one of several.
    pub share: f64,
}

impl RigidCoupling {
    /// Cᵀ·u.
    pub(crate) fn seen(&self, u: &[DVec3]) -> Six {
        let mut seen = [0.0; 6];
        for (row, columns) in &self.rows {
            let u = u[*row as usize];
            seen.iter_mut().zip(columns).for_each(|(seen, column)| *seen += column.dot(u));
        }
        seen
    }

    /// One vertex' rows of C, times a vector.
    pub(crate) fn back(columns: &[DVec3; 6], seen: &Six) -> DVec3 {
        columns.iter().zip(seen).map(|(column, seen)| *column * *seen).sum()
    }

    /// Motion of the obstacle at the answer u of the solve.
    pub(crate) fn motion(&self, u: &[DVec3]) -> [DVec3; 2] {
        let by_vertices = solve_upper(&self.lower, self.seen(u));
        let motion: Six = std::array::from_fn(|i| (self.base[i] + by_vertices[i]) * self.share);
        [DVec3::from_slice(&motion), DVec3::from_slice(&motion[3..])]
    }
}

/// Lower Cholesky factor of a symmetric matrix; `None` where that is not positive definite.
pub(crate) fn cholesky(matrix: &[Six; 6]) -> Option<[Six; 6]> {
    let mut lower = [[0.0; 6]; 6];
    for i in 0..6 {
        for j in 0..=i {
            let rest = matrix[i][j] - (0..j).map(|k| lower[i][k] * lower[j][k]).sum::<f64>();
            lower[i][j] = if i == j { rest.sqrt() } else { rest / lower[j][j] };
        }
        if !(lower[i][i] > 0.0 && lower[i][i].is_finite()) {
            return None;
        }
    }
    Some(lower)
}

/// L⁻¹·b.
pub(crate) fn solve_lower(lower: &[Six; 6], mut b: Six) -> Six {
    for i in 0..6 {
        b[i] = (b[i] - (0..i).map(|k| lower[i][k] * b[k]).sum::<f64>()) / lower[i][i];
    }
    b
}

/// L⁻ᵀ·b.
pub(crate) fn solve_upper(lower: &[Six; 6], mut b: Six) -> Six {
    for i in (0..6).rev() {
        b[i] = (b[i] - (i + 1..6).map(|k| lower[k][i] * b[k]).sum::<f64>()) / lower[i][i];
    }
    b
}
