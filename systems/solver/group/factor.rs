//! Incomplete Cholesky factor of a group: 3×3 blocks, without fill, over the vertices of all bodies.
//!
//! Triangles, dihedrals and springs have their places in the pattern. Springs beside the diagonal are the point of it: parts on stiff springs move together as
//! easily as their bodies do, and a factor of each body, with the springs on the diagonal alone, would hold them back (Meijerink, van der Vorst 1977; the
//! diagonal is raised as in Manteuffel 1980).

use crate::components::{FreeAxes, PairSpring};
use crate::math::Sym3;
use crate::systems::solver::Operator;
use glam::{DMat3, DVec3};

/// Level of fill.
const LEVEL: u32 = 2;

/// Fractions of itself by which the diagonal is raised, one after the other until there is a factor. Soft motions of parts on stiff springs ask for a small one.
const SHIFTS: [f64; 7] = [0.0, 1e-5, 1e-3, 1e-2, 0.1, 1.0, 10.0];

/// The matrix: blocks of every row on and before the diagonal, in ascending order of their columns.
#[derive(Default)]
pub(super) struct Blocks {
    entries: Vec<(u32, u32, DMat3)>,
    /// First entry of every row, and the end.
    start: Vec<usize>,
    /// Place of every row in the factor.
    row: Vec<u32>,
}

impl Blocks {
    /// Adds the operator of a body whose vertices begin at row `first`.
    pub(super) fn add_body(&mut self, operator: &Operator, first: u32) {
        for v in 0..operator.vertices.len() {
            self.entries.push((first + v as u32, first + v as u32, operator.vertex_block(v)));
        }
        for (t, corners) in operator.triangles.corners.iter().enumerate() {
            let element = operator.element(t);
            for j in 0..3 {
                let columns = [DVec3::X, DVec3::Y, DVec3::Z].map(|axis| {
                    let mut u = [DVec3::ZERO; 3];
                    u[j] = axis;
                    element.apply(u)
                });
                for i in 0..3 {
                    let block = DMat3::from_cols(columns[0][i], columns[1][i], columns[2][i]);
                    self.add(first + corners[i], first + corners[j], block);
                }
            }
        }
        for hinge in operator.folds.into_iter().flat_map(|folds| folds.hinges(&operator.triangles.corners)) {
            self.add_product(hinge.vertices.map(|v| first + v), hinge.gradient, hinge.stiffness);
        }
        let pairs = operator.external.map_or(&[][..], |external| &external.coupled.pairs);
        pairs.iter().for_each(|spring| self.add_spring(spring, spring.rows.map(|v| Some(first + v))));
    }

    /// Adds a spring between these rows.
    pub(super) fn add_spring(&mut self, spring: &PairSpring, rows: [Option<u32>; 4]) {
        for (i, j) in (0..4).flat_map(|i| (0..4).map(move |j| (i, j))) {
            if let [Some(row), Some(column)] = [rows[i], rows[j]] {
                let factor = spring.stiffness * spring.weights[i] * spring.weights[j];
                self.add(row, column, (Sym3::outer(spring.normal) * factor).to_mat());
            }
        }
    }

    /// Adds k·g·gᵀ.
    fn add_product(&mut self, rows: [u32; 4], gradient: [DVec3; 4], stiffness: f64) {
        for (i, j) in (0..4).flat_map(|i| (0..4).map(move |j| (i, j))) {
            let [a, b] = [gradient[i] * stiffness, gradient[j]];
            self.add(rows[i], rows[j], DMat3::from_cols(a * b.x, a * b.y, a * b.z));
        }
    }

    fn add(&mut self, row: u32, column: u32, block: DMat3) {
        if column <= row {
            self.entries.push((row, column, block));
        }
    }

    /// Puts rows in the order of a breadth-first search, so that parts on springs stand side by side (Cuthill, McKee 1969); masks blocks to free
    /// axes, and sums those of one place in the order in which they were added.
    pub(super) fn finish(&mut self, free: &[&FreeAxes], first: &[u32]) {
        let count = first.last().map_or(0, |first| *first as usize) + free.last().map_or(0, |free| free.len());
        self.row = breadth_first(&self.entries, count);
        let axes = |row: u32| {
            let part = first.partition_point(|first| *first <= row) - 1;
            DMat3::from_diagonal(free[part][(row - first[part]) as usize])
        };
        for (row, column, block) in &mut self.entries {
            let [own, other] = [axes(*row), axes(*column)];
            *block = own * *block * other;
            let places = [self.row[*row as usize], self.row[*column as usize]];
            if places[0] < places[1] {
                *block = block.transpose();
            }
            (*row, *column) = (places[0].max(places[1]), places[0].min(places[1]));
        }
        let held = (0..count as u32).map(|v| (self.row[v as usize], DMat3::IDENTITY - axes(v)));
        self.entries.extend(held.map(|(row, block)| (row, row, block)));
        // Blocks are large: their numbers are sorted.
        let mut order: Vec<(u32, u32, u32)> =
            (0..).zip(&self.entries).map(|(i, (row, column, _))| (*row, *column, i)).collect();
        order.sort_unstable();
        let mut summed: Vec<(u32, u32, DMat3)> = Vec::with_capacity(order.len() / 4);
        for (row, column, i) in order {
            let block = self.entries[i as usize].2;
            match summed.last_mut() {
                Some(last) if (last.0, last.1) == (row, column) => last.2 += block,
                _ => summed.push((row, column, block)),
            }
        }
        self.entries = summed;
        self.fill(count);
    }

    /// Adds the places that elimination fills, up to the level [`LEVEL`], and finds where rows begin.
    fn fill(&mut self, count: usize) {
        let (mut filled, mut place) = (Vec::with_capacity(4 * self.entries.len()), 0);
        // Rows below the diagonal of every column so far, with their levels.
        let mut columns: Vec<Vec<(u32, u32)>> = vec![Vec::new(); count];
        let mut level = vec![u32::MAX; count];
        self.start.clear();
        for row in 0..count as u32 {
            self.start.push(filled.len());
            let mut own: std::collections::BTreeSet<u32> = std::collections::BTreeSet::new();
            let first = place;
            while self.entries.get(place).is_some_and(|entry| entry.0 == row) {
                own.insert(self.entries[place].1);
                level[self.entries[place].1 as usize] = 0;
                place += 1;
            }
            let mut next = own.first().copied();
            while let Some(k) = next.filter(|k| *k < row) {
                for &(j, of_column) in &columns[k as usize] {
                    let of_fill = level[k as usize] + of_column + 1;
                    if of_fill <= LEVEL && of_fill < level[j as usize] {
                        level[j as usize] = of_fill;
                        own.insert(j);
                    }
                }
                next = own.range(k + 1..).next().copied();
            }
            let mut given = self.entries[first..place].iter().peekable();
            for column in own {
                let block = given.next_if(|entry| entry.1 == column).map_or(DMat3::ZERO, |entry| entry.2);
                filled.push((row, column, block));
                if column < row {
                    columns[column as usize].push((row, level[column as usize]));
                }
                level[column as usize] = u32::MAX;
            }
        }
        self.start.push(filled.len());
        self.entries = filled;
    }

    /// The factor, with the diagonal raised until there is one.
    pub(super) fn factor(self) -> Factor {
        let Self { entries, start, row } = self;
        let column = entries.iter().map(|entry| entry.1).collect();
        let matrix: Vec<DMat3> = entries.into_iter().map(|entry| entry.2).collect();
        let spare = vec![DVec3::ZERO; row.len()];
        let mut factor = Factor { start, column, row, lower: matrix.clone(), matrix, inverse: Vec::new(), spare };
        let _ = SHIFTS.into_iter().find(|shift| factor.try_with(*shift));
        factor
    }
}

/// Places of rows in a breadth-first search over the entries, from a row far from others.
fn breadth_first(entries: &[(u32, u32, DMat3)], count: usize) -> Vec<u32> {
    let mut pairs: Vec<(u32, u32)> = entries
        .iter()
        .filter(|entry| entry.0 != entry.1)
        .flat_map(|entry| [(entry.0, entry.1), (entry.1, entry.0)])
        .collect();
    pairs.sort_unstable();
    pairs.dedup();
    let mut start = vec![0; count + 1];
    pairs.iter().for_each(|pair| start[pair.0 as usize + 1] += 1);
    (0..count).for_each(|row| start[row + 1] += start[row]);
    let search = |from: u32, seen: &mut Vec<bool>, order: &mut Vec<u32>| {
        let mut at = order.len();
        order.push(from);
        seen[from as usize] = true;
        while let Some(&row) = order.get(at) {
            for &(_, other) in &pairs[start[row as usize]..start[row as usize + 1]] {
                if !std::mem::replace(&mut seen[other as usize], true) {
                    order.push(other);
                }
            }
            at += 1;
        }
    };
    let (mut seen, mut order) = (vec![false; count], Vec::with_capacity(count));
    for row in 0..count as u32 {
        if seen[row as usize] {
            continue;
        }
        let (mut tried, mut trial) = (seen.clone(), Vec::new());
        search(row, &mut tried, &mut trial);
        search(trial.last().copied().unwrap_or(row), &mut seen, &mut order);
    }
    let mut place = vec![0; count];
    (0..).zip(order).for_each(|(at, row)| place[row as usize] = at);
    place
}

/// The factor L, with the inverses of its blocks on the diagonal.
pub(super) struct Factor {
    /// First block of every row, and the end; the column of every block.
    start: Vec<usize>,
    column: Vec<u32>,
    /// Place of every vertex among the rows.
    row: Vec<u32>,
    matrix: Vec<DMat3>,
    lower: Vec<DMat3>,
    inverse: Vec<DMat3>,
    spare: Vec<DVec3>,
}

impl Factor {
    /// Factors with the diagonal raised by this fraction; whether all pivots are positive. Others count as the matrix' own.
    fn try_with(&mut self, shift: f64) -> bool {
        let Self { start, column: columns, matrix, lower, inverse, .. } = self;
        inverse.clear();
        let mut is_sound = true;
        for row in 0..start.len() - 1 {
            let own = start[row]..start[row + 1];
            for place in own.clone() {
                let (column, block) = (columns[place], matrix[place]);
                let other = start[column as usize]..start[column as usize + 1];
                let mut sum = block;
                // Columns that both rows have.
                let (mut i, mut j) = (own.start, other.start);
                while i < place && j + 1 < other.end {
                    match columns[i].cmp(&columns[j]) {
                        std::cmp::Ordering::Less => i += 1,
                        std::cmp::Ordering::Greater => j += 1,
                        std::cmp::Ordering::Equal => {
                            sum -= lower[i] * lower[j].transpose();
                            (i, j) = (i + 1, j + 1);
                        }
                    }
                }
                if (column as usize) < row {
                    lower[place] = sum * inverse[column as usize].transpose();
                    continue;
                }
                let raised = |sum: DMat3| sum + DMat3::from_diagonal(diagonal(block) * shift);
                let found = inverse_of_lower(raised(sum));
                is_sound &= found.is_some();
                inverse.push(found.or_else(|| inverse_of_lower(raised(block))).unwrap_or(DMat3::IDENTITY));
            }
        }
        is_sound
    }

    /// z = (L·Lᵀ)⁻¹·r, over all rows, in place.
    pub(super) fn apply(&mut self, r: &mut [DVec3]) {
        let Self { start, column, row, lower, inverse, spare: z, .. } = self;
        row.iter().zip(&*r).for_each(|(row, r)| z[*row as usize] = *r);
        for row in 0..z.len() {
            let before = start[row]..start[row + 1] - 1;
            let sum = before.fold(z[row], |sum, place| sum - lower[place] * z[column[place] as usize]);
            z[row] = inverse[row] * sum;
        }
        for row in (0..z.len()).rev() {
            z[row] = inverse[row].transpose() * z[row];
            for place in start[row]..start[row + 1] - 1 {
                let more = lower[place].transpose() * z[row];
                z[column[place] as usize] -= more;
            }
        }
        row.iter().zip(r).for_each(|(row, r)| *r = z[*row as usize]);
    }
}

fn diagonal(block: DMat3) -> DVec3 {
    DVec3::new(block.x_axis.x, block.y_axis.y, block.z_axis.z)
}

/// The inverse of the lower Cholesky factor of a symmetric block, where that is positive definite.
fn inverse_of_lower(block: DMat3) -> Option<DMat3> {
    let [a, b, c] = [block.x_axis, block.y_axis, block.z_axis];
    let l11 = a.x.sqrt();
    let (l21, l31) = (a.y / l11, a.z / l11);
    let l22 = (b.y - l21 * l21).sqrt();
    let l32 = (b.z - l31 * l21) / l22;
    let l33 = (c.z - l31 * l31 - l32 * l32).sqrt();
    let is_positive = l11 > 0.0 && l22 > 0.0 && l33 > 0.0 && (l11 + l22 + l33).is_finite();
    let lower = DMat3::from_cols(DVec3::new(l11, l21, l31), DVec3::new(0.0, l22, l32), DVec3::new(0.0, 0.0, l33));
    is_positive.then(|| lower.inverse()).filter(DMat3::is_finite)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A matrix whose factor has no fill is factored exactly, but for the shift.
    #[test]
    fn a_chain_of_springs_is_solved_at_once() {
        let mut blocks = Blocks::default();
        let mut full = vec![vec![DMat3::ZERO; 6]; 6];
        for v in 0..6_u32 {
            let own = DMat3::from_diagonal(DVec3::new(1.0, 2.0, 3.0 + f64::from(v)));
            blocks.add(v, v, own);
            full[v as usize][v as usize] += own;
        }
        for v in 0..5_u32 {
            let normal = DVec3::new(1.0, f64::from(v) - 2.0, 0.5).normalize();
            let spring = PairSpring { rows: [v, v + 1, 0, 0], weights: [1.0, -1.0, 0.0, 0.0], normal, stiffness: 1e4 };
            blocks.add_spring(&spring, [Some(v), Some(v + 1), None, None]);
            for (i, j) in [(v, v), (v, v + 1), (v + 1, v), (v + 1, v + 1)] {
                let sign = if i == j { 1e4 } else { -1e4 };
                full[i as usize][j as usize] += (Sym3::outer(normal) * sign).to_mat();
            }
        }
        let free: FreeAxes = [DVec3::ONE; 6].into_iter().collect();
        blocks.finish(&[&free], &[0]);
        let mut factor = blocks.factor();
        assert!(factor.try_with(0.0));
        let answer: Vec<DVec3> = (0..6).map(|v| DVec3::new(f64::from(v), 1.0, -0.3)).collect();
        let mut z: Vec<DVec3> =
            full.iter().map(|row| row.iter().zip(&answer).map(|(block, x)| *block * *x).sum()).collect();
        factor.apply(&mut z);
        // The condition of the matrix is 1e4.
        let off = z.iter().zip(&answer).map(|(z, x)| (*z - *x).length()).fold(0.0, f64::max);
        assert!(off < 1e-10, "{off}");
    }
}
