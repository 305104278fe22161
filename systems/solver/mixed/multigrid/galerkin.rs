//! The operator of the next coarser level: PᵀAP.

use super::super::empty;
use super::super::pattern::BlockPattern;
use super::interpolation::Parts;
use super::level::Level;
use super::marks::Marks;
use super::transfer::Transfer;
use crate::systems::kernels::block;

/// The pattern of the coarser level.
pub(super) fn rebuild_pattern(coarse: &mut BlockPattern, fine: &BlockPattern, transfer: &Transfer) {
    let node_count = transfer.coarsening.row.len();
    // As many as on a regular grid.
    coarse.begin(node_count, 4 * node_count);
    (0..node_count).for_each(|node| push_row(coarse, fine, transfer, node));
    coarse.finish();
}

/// Updates the pattern of the coarser level after edits: rows without any mark have the columns that they had.
pub(super) fn follow_pattern(coarse: &mut BlockPattern, fine: &BlockPattern, transfer: &Transfer, marks: &Marks) {
    let node_count = transfer.coarsening.row.len();
    coarse.renew(node_count, |node| !marks.is_any(node), |coarse, node| push_row(coarse, fine, transfer, node));
    coarse.finish();
}

fn push_row(coarse: &mut BlockPattern, fine: &BlockPattern, transfer: &Transfer, node: usize) {
    let rows = transfer.support(node).iter().flat_map(|&(row, _)| fine.neighbours(row as usize).chain([row]));
    let columns = rows.flat_map(|row| transfer.parts[row as usize].iter().map(|(other, _)| other as u32));
    coarse.push_row(columns.filter(|&other| (other as usize) < node));
}

/// The numbers of the coarser level, whose pattern and free axes stand.
pub(super) fn assemble(coarse: &mut Level, fine: &Level, transfer: &Transfer) {
    let node_count = coarse.pattern.row_count();
    let Level { pattern, diagonal, lower, .. } = coarse;
    let pattern = &*pattern;
    empty(diagonal, node_count);
    diagonal.resize(node_count, block::ZERO);
    empty(lower, pattern.column.len());
    lower.resize(pattern.column.len(), block::ZERO);
    for node in 0..node_count {
        let start = pattern.row_start[node] as usize;
        let columns = &pattern.column[start..pattern.row_start[node + 1] as usize];
        let (own, of_row) = (&mut diagonal[node], &mut lower[start..start + columns.len()]);
        let mut add = |row: usize, weight: f32, value: &block::Block| {
            let Parts { node: others, weight: weights } = transfer.parts[row];
            for (other, part) in others.into_iter().zip(weights) {
                let factor = weight * part;
                if factor == 0.0 || other as usize > node {
                    continue;
                }
                let target = if other as usize == node {
                    &mut *own
                } else {
                    let k = columns.iter().take_while(|&&column| column != other).count();
                    &mut of_row[k]
                };
                *target = block::sum(target, value, factor);
            }
        };
        for &(row, weight) in transfer.support(node) {
            let row = row as usize;
            add(row, weight, &fine.diagonal[row]);
            let p = &fine.pattern;
            for k in p.before(row) {
                add(p.column[k] as usize, weight, &fine.lower[k]);
            }
            for k in p.after(row) {
                add(p.below[k][0] as usize, weight, &block::transpose(&fine.lower[p.below[k][1] as usize]));
            }
        }
    }
}

#[cfg(test)]
pub mod tests {
    use super::*;
    use crate::systems::solver::mixed::multigrid::interpolation::{self, Place};
    use crate::systems::solver::mixed::multigrid::level::FREE;
    use crate::systems::solver::mixed::multigrid::numbering::Numbering;
    use glam::{DVec3, Vec4};

    /// Rows of a grid of `SIDE` by `SIDE` vertices, each with up to eight neighbours.
    pub const SIDE: usize = 9;

    /// A level of them, its middle held.
    pub fn grid() -> Level {
        let mut level = Level { numbering: Numbering::single(SIDE * SIDE), ..Level::default() };
        level.pattern.begin(SIDE * SIDE, 4 * SIDE * SIDE);
        for row in 0..SIDE * SIDE {
            let is_near = |other: &u32| {
                let other = *other as usize;
                (other % SIDE).abs_diff(row % SIDE) <= 1 && (other / SIDE).abs_diff(row / SIDE) <= 1
            };
            level.pattern.push_row((0..row as u32).filter(is_near));
        }
        level.pattern.finish();
        let mut state = 1_u32;
        let mut next = || {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            ((state >> 16) % 17) as f32 - 8.0
        };
        for row in 0..SIDE * SIDE {
            let (a, b, c) = (next(), next(), next());
            let diagonal = [Vec4::new(200.0, a, b, 0.0), Vec4::new(a, 210.0, c, 0.0), Vec4::new(b, c, 220.0, 0.0)];
            level.diagonal.push(diagonal);
            for _ in level.pattern.before(row) {
                level.lower.push([0; 3].map(|_| Vec4::new(next(), next(), next(), 0.0)));
            }
            // The middle is held, its neighbour along one axis.
            level.free.push(match row {
                40 => Vec4::ZERO,
                41 => Vec4::new(1.0, 0.0, 1.0, 0.0),
                _ => FREE,
            });
        }
        level.finish();
        level
    }

    /// A·x of a level.
    fn product(level: &Level, x: &[Vec4]) -> Vec<Vec4> {
        let row = |row: usize| {
            let p = &level.pattern;
            let mut y = block::apply(&level.diagonal[row], x[row]);
            p.before(row).for_each(|k| y += block::apply(&level.lower[k], x[p.column[k] as usize]));
            p.after(row).for_each(|k| {
                let upper = block::transpose(&level.lower[p.below[k][1] as usize]);
                y += block::apply(&upper, x[p.below[k][0] as usize]);
            });
            y
        };
        (0..x.len()).map(row).collect()
    }

    /// The next coarser level of a grid, with the places of the rows and its way there.
    pub fn coarser(fine: &Level) -> (Vec<Place>, Transfer, Level) {
        let place = |row: usize| Place {
            position: DVec3::new((row % SIDE) as f64, (row / SIDE) as f64, 0.0),
            normal: DVec3::Z,
        };
        let places: Vec<Place> = (0..SIDE * SIDE).map(place).collect();
        let is_boundary: Vec<bool> =
            (0..SIDE * SIDE).map(|row| [row % SIDE, row / SIDE].iter().any(|i| i % (SIDE - 1) == 0)).collect();
        let mut transfer = Transfer::default();
        transfer.coarsening.rebuild(&fine.pattern, fine.numbering, &is_boundary);
        let node_count = transfer.coarsening.row.len();
        interpolation::rebuild(&mut transfer.parts, &fine.pattern, &places, &transfer.coarsening.node);
        transfer.sort();
        let mut coarse = Level { numbering: Numbering::single(node_count), ..Level::default() };
        rebuild_pattern(&mut coarse.pattern, &fine.pattern, &transfer);
        coarse.free = transfer.coarsening.row.iter().map(|&row| fine.free[row as usize]).collect();
        assemble(&mut coarse, fine, &transfer);
        coarse.finish();
        (places, transfer, coarse)
    }

    #[test]
    fn the_coarser_operator_is_the_product() {
        let fine = grid();
        let (places, transfer, coarse) = coarser(&fine);
        let node_count = transfer.coarsening.row.len();
        // Every second row along either axis is 25, or 16 where the others are.
        assert!((16..=25).contains(&node_count), "{node_count}");
        // Weights reproduce linear fields, to the rounding of three weights times a coordinate up to eight.
        for (row, parts) in transfer.parts.iter().enumerate() {
            let at = |node: usize| places[transfer.coarsening.row[node] as usize].position;
            let sum: DVec3 = parts.iter().map(|(node, weight)| at(node) * f64::from(weight)).sum();
            assert!((sum - places[row].position).length() < 1e-5, "row {row}: {parts:?}");
            assert!((parts.weight.iter().sum::<f32>() - 1.0).abs() < 1e-6);
        }

        for node in 0..node_count {
            for axis in 0..3 {
                if coarse.free[node][axis] == 0.0 {
                    continue;
                }
                let mut unit = vec![Vec4::ZERO; node_count];
                unit[node][axis] = 1.0;
                let mut x = vec![Vec4::ZERO; SIDE * SIDE];
                transfer.prolong(&unit, &mut x);
                let mut expected = vec![Vec4::ZERO; node_count];
                transfer.restrict(&product(&fine, &x), &mut expected);
                for (other, (a, b)) in product(&coarse, &unit).iter().zip(&expected).enumerate() {
                    // Sums of some hundred products of up to 220, each rounded to half of 1.2e-7.
                    let off = (*a - *b * coarse.free[other]).length();
                    assert!(off < 5e-3, "node {other} from {node}: {a} against {b}");
                }
            }
        }
    }
}
